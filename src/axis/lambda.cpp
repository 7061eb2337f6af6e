// SPDX-License-Identifier: Apache-2.0
#include "axis/lambda.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include "axis/enclosing_ball.h"
#include "axis/rest_of_core.h"
#include "base/parallel.h"

namespace quench::axis {
namespace {

class SiteDistances {
 public:
  SiteDistances(std::span<const LatticePoint> sites, const std::array<std::int64_t, 3>& spacing, double unit)
      : sites_(sites), spacing_(spacing), unit_(unit) {}

  double half(std::uint32_t a, std::uint32_t b) const {
    double squared = 0;
    for (int i = 0; i < 3; ++i) {
      const auto d = static_cast<double>((sites_[a][i] - sites_[b][i]) * spacing_[i]);
      squared += d * d;  // below 2^46: exact, and so is the order of the roots
    }
    return 0.5 * std::sqrt(squared) * unit_;
  }

  double ball(std::span<const std::uint32_t> ids) const {
    std::vector<Vec3> points;
    const LatticePoint& o = sites_[ids[0]];
    for (std::uint32_t id : ids) {
      Vec3 p;
      for (int a = 0; a < 3; ++a) p[a] = static_cast<double>((sites_[id][a] - o[a]) * spacing_[a]);
      points.push_back(p);
    }
    return std::sqrt(enclosing_ball_squared_radius(points)) * unit_;
  }

 private:
  std::span<const LatticePoint> sites_;
  const std::array<std::int64_t, 3>& spacing_;
  double unit_;
};

}  // namespace

CellValues lambda(const CellComplex& complex, const dual::DualComplex& dual, std::span<const LatticePoint> sites,
                  const std::array<std::int64_t, 3>& spacing, double unit, LambdaRule rule, const Carried& carried,
                  Context* context) {
  const SiteDistances distances(sites, spacing, unit);
  CellValues value;
  tbb::parallel_invoke(
      [&] {
        value.face.resize(complex.face_count());
        value.vertex = carried.vertex_lambda;
        value.vertex.resize(complex.vertex_count, -1);
      },
      [&] {
        value.edge = carried.edge_lambda;
        value.edge.resize(complex.edges.size(), -1);
      });
  const std::size_t chunks = base::chunks_for(complex.edges.size());
  base::for_chunks(chunks, context, "core", 0.5, 0.7, [&](std::size_t chunk) {
    const auto [first, last] = base::part_of(complex.face_count(), chunk, chunks);
    for (std::size_t f = first; f < last; ++f) {
      value.face[f] = distances.half(dual.face_sites[f][0], dual.face_sites[f][1]);
      for (std::uint32_t e : complex.sides(f)) base::raise(value.edge[e], value.face[f]);
    }
  });
  base::for_chunks(chunks, context, "core", 0.7, 0.9, [&](std::size_t chunk) {
    const auto [first, last] = base::part_of(complex.edges.size(), chunk, chunks);
    std::vector<std::uint32_t> shared;
    for (std::size_t e = first; e < last; ++e) {
      const auto& [u, v] = complex.edges[e];
      if (!dual.edge_sites.empty()) {
        value.edge[e] = distances.half(dual.edge_sites[e][0], dual.edge_sites[e][1]);
      } else if (rule == LambdaRule::ball || value.edge[e] < 0) {
        shared.clear();
        const auto su = dual.sites_of(u), sv = dual.sites_of(v);
        std::set_intersection(su.begin(), su.end(), sv.begin(), sv.end(), std::back_inserter(shared));
        // The maximum only mends rounding: the ball of an edge encloses the sites of its faces.
        value.edge[e] = std::max(value.edge[e], distances.ball(shared));
      }
      for (std::uint32_t w : {u, v}) base::raise(value.vertex[w], value.edge[e]);
    }
  });
  base::for_chunks(chunks, context, "core", 0.9, 1, [&](std::size_t chunk) {
    const auto [first, last] = base::part_of(complex.vertex_count, chunk, chunks);
    for (std::size_t v = first; v < last; ++v)
      if (rule == LambdaRule::ball || value.vertex[v] < 0)
        value.vertex[v] = std::max(value.vertex[v], distances.ball(dual.sites_of(static_cast<std::uint32_t>(v))));
  });
  return value;
}

}  // namespace quench::axis
