// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "quench/error.h"
#include "thickness/pencils.h"

namespace quench::thickness {
namespace {

// Up to which a centre outside of a sphere counts as on it: of the squared radius.
constexpr double kOnSphere = 2e-9;

// The whole part of what lies in [low, high], or an end.
std::int32_t whole_between(double x, double low, double high) {
  return static_cast<std::int32_t>(x > low ? x < high ? x : high : low);
}

// False: holds no voxel centre.
bool set_box(Pencil& pencil, const Sweep& sweep, const Grid& grid, const VoxelShape::Box& box) {
  const Ball& lower = sweep.balls[pencil.lower];
  const double r = lower.radius;
  Lune lune;
  lune.h = -r;
  if (pencil.upper != pencil.lower) {
    lune = lune_of(sweep.balls[pencil.upper], lower);
    if (!(lune.h <= r)) return false;
  }
  const double circle = std::sqrt(std::max(0.0, r * r - lune.h * lune.h));
  for (std::size_t a = 0; a < 3; ++a) {
    const auto axis = static_cast<Eigen::Index>(a);
    const double n = lune.n[axis], flat = circle * std::sqrt(std::max(0.0, 1 - n * n));
    const double down = -n * r >= lune.h ? r : flat - lune.h * n, up = n * r >= lune.h ? r : flat + lune.h * n;
    const double middle = lower.centre[axis] / grid.spacing[axis], per = 1 / grid.spacing[axis];
    const auto least = static_cast<double>(box.begin[a]), most = static_cast<double>(box.end[a]);
    pencil.low[a] = whole_between(middle - down * per + 1 - kRoundingSlack, least, most);
    pencil.high[a] = whole_between(middle + up * per + 1 + kRoundingSlack, least, most);
    if (pencil.low[a] >= pencil.high[a]) return false;
  }
  return true;
}

}  // namespace

Lune lune_of(const Ball& upper, const Ball& lower) {
  const Vec3 way = lower.centre - upper.centre;
  const double squared = way.squaredNorm(), d = std::sqrt(squared);
  if (d == 0) return {Vec3::Zero(), std::numeric_limits<double>::infinity(), 0};
  const double h = (upper.squared - lower.squared - squared) / (2 * d);
  return {way / d, h - 1e-7 * std::abs(h) - 1e-11 * (upper.squared + squared) / d, squared};
}

Sweep sweep_of(const MedialAxis& axis, const Grid& grid, const VoxelShape::Box& box, bool between, Context* context) {
  const std::size_t count = axis.points.size();
  for (std::size_t v = 0; v < count; ++v)
    if (!axis.points[v].allFinite() || !(std::abs(axis.radius[v]) <= kLargestLength))
      throw Error(ErrorCode::usage, "a vertex of the medial axis has a radius or a place that is no finite number");
  checkpoint(context, "thickness", 0);
  Sweep sweep;
  sweep.balls.resize(count);
  base::for_indices(count, [&](std::size_t v) {
    const double radius = std::max(axis.radius[v], 0.0), squared = radius * radius;
    sweep.balls[v] = {(grid.lattice(axis.points[v]) - grid.first_centre()).cwiseProduct(grid.spacing), squared,
                      squared * (1 + kOnSphere), radius * std::sqrt(1 + kOnSphere)};
  });

  // The largest neighbour of each ball: without one it is a pencil of its own.
  const auto& edges = axis.complex.edges;
  const auto is_larger = [&](std::uint32_t a, std::uint32_t b) {
    const double ra = sweep.balls[a].squared, rb = sweep.balls[b].squared;
    return ra > rb || (ra == rb && a < b);
  };
  std::vector<std::uint32_t> largest(count);
  for (std::size_t v = 0; v < count; ++v) largest[v] = static_cast<std::uint32_t>(v);
  for (const auto& [a, b] : edges) {
    if (is_larger(a, largest[b])) largest[b] = a;
    if (is_larger(b, largest[a])) largest[a] = b;
  }
  const std::size_t all = between ? edges.size() + count : count, lone = between ? count : 0;
  const std::size_t chunks = base::chunks_for(all, Sweep::kChunk);
  if (chunks > std::numeric_limits<std::uint32_t>::max() / Sweep::kChunk)
    throw Error(ErrorCode::failed, "the medial axis has more than 2^32 edges; use a smaller or coarser input");
  sweep.chunks.resize(chunks);
  base::for_chunks(chunks, context, "thickness", 0, 0.1, [&](std::size_t chunk) {
    const auto [first, last] = base::part_of(all, chunk, chunks);
    Sweep::Chunk& found = sweep.chunks[chunk];
    found.pencils.reserve(last - first);
    for (std::size_t i = first; i < last; ++i) {
      Pencil pencil;
      if (!between || i < lone) {
        pencil.lower = static_cast<std::uint32_t>(i);
        pencil.upper = largest[i];
        if (between && pencil.upper != pencil.lower) continue;
      } else {
        const auto& [a, b] = edges[i - lone];
        pencil.upper = is_larger(a, b) ? a : b;
        pencil.lower = a + b - pencil.upper;
      }
      if (!set_box(pencil, sweep, grid, box)) continue;
      found.pencils.push_back(pencil);
      found.low = std::min(found.low, pencil.low[2]);
      found.high = std::max(found.high, pencil.high[2]);
    }
  });
  return sweep;
}

}  // namespace quench::thickness
