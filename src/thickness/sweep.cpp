// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "base/sorted_by_key.h"
#include "quench/error.h"
#include "thickness/pencils.h"

namespace quench::thickness {
namespace {

// Up to which a centre outside of a sphere counts as on it: of the squared radius.
constexpr double kOnSphere = 2e-9;

// Voxels of the part of the lower ball in the half-space, along one axis.
void set_range(Pencil& pencil, std::size_t a, double centre, double reach_down, double reach_up, double step,
               const VoxelShape::Box& box) {
  const double low = std::ceil((centre - reach_down) / step - kRoundingSlack),
               high = std::floor((centre + reach_up) / step + kRoundingSlack);
  const double least = static_cast<double>(box.begin[a]), most = static_cast<double>(box.end[a] - 1);
  pencil.low[a] = static_cast<std::int32_t>(std::max(low, least));
  pencil.high[a] = low > most || high < least ? pencil.low[a] : static_cast<std::int32_t>(std::min(high, most)) + 1;
}

bool is_empty(const Pencil& p) { return p.low[0] >= p.high[0] || p.low[1] >= p.high[1] || p.low[2] >= p.high[2]; }

// False: holds no voxel centre.
bool set_box(Pencil& pencil, const Sweep& sweep, const Grid& grid, const VoxelShape::Box& box) {
  const Ball& lower = sweep.balls[pencil.lower];
  const double r = std::sqrt(lower.limit);
  Lune lune;
  lune.h = -r;
  if (pencil.upper != pencil.lower) {
    lune = lune_of(sweep.balls[pencil.upper], lower);
    if (!(lune.h <= r)) return false;
  }
  const double circle = std::sqrt(std::max(0.0, r * r - lune.h * lune.h));
  const auto reach = [&](double n) {
    return n * r >= lune.h ? r : lune.h * n + circle * std::sqrt(std::max(0.0, 1 - n * n));
  };
  for (std::size_t a = 0; a < 3; ++a) {
    const auto axis = static_cast<Eigen::Index>(a);
    set_range(pencil, a, lower.centre[axis], reach(-lune.n[axis]), reach(lune.n[axis]), grid.spacing[axis], box);
    if (pencil.low[a] >= pencil.high[a]) return false;
  }
  return !is_empty(pencil);
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
  const auto radius = [&](std::size_t v) { return std::max(axis.radius[v], 0.0); };
  const auto no_order = [](std::uint32_t, std::uint32_t) { return false; };
  const std::vector<std::uint32_t> order =
      base::sorted_by_key_descending(count, static_cast<std::ptrdiff_t>(count), radius, no_order);
  Sweep sweep;
  sweep.balls.resize(count);
  std::vector<std::uint32_t> place(count);
  base::for_indices(count, [&](std::size_t i) {
    const std::uint32_t v = order[i];
    place[v] = static_cast<std::uint32_t>(i);
    const double squared = radius(v) * radius(v);
    sweep.balls[i] = {(grid.lattice(axis.points[v]) - grid.first_centre()).cwiseProduct(grid.spacing), squared,
                      squared * (1 + kOnSphere)};
  });
  checkpoint(context, "thickness", 0.02);

  // The largest neighbour of each ball: without one it is a pencil of its own.
  std::vector<std::uint32_t> largest(count);
  for (std::size_t i = 0; i < count; ++i) largest[i] = static_cast<std::uint32_t>(i);
  for (const auto& [a, b] : axis.complex.edges) {
    const auto [upper, lower] = std::minmax(place[a], place[b]);
    largest[lower] = std::min(largest[lower], upper);
  }
  const auto& edges = axis.complex.edges;
  const std::size_t lone = between ? count : 0, all = between ? edges.size() + count : count;
  const std::size_t chunks = base::chunks_for(all);
  std::vector<std::vector<Pencil>> found(chunks);
  base::for_chunks(chunks, context, "thickness", 0.02, 0.08, [&](std::size_t chunk) {
    const auto [first, last] = base::part_of(all, chunk, chunks);
    for (std::size_t i = first; i < last; ++i) {
      Pencil pencil;
      if (!between || i < lone) {
        pencil.lower = static_cast<std::uint32_t>(i);
        pencil.upper = largest[i];
        if (between && pencil.upper != pencil.lower) continue;
      } else {
        const auto [a, b] = edges[i - lone];
        std::tie(pencil.upper, pencil.lower) = std::minmax(place[a], place[b]);
      }
      if (set_box(pencil, sweep, grid, box)) found[chunk].push_back(pencil);
    }
  });

  // By the upper ball; in the order they were found where that is the same.
  std::vector<std::size_t> begin(count + 1, 0);
  for (const auto& part : found)
    for (const Pencil& pencil : part) ++begin[pencil.upper + 1];
  for (std::size_t v = 0; v < count; ++v) begin[v + 1] += begin[v];
  sweep.pencils.resize(begin[count]);
  for (auto& part : found) {
    for (const Pencil& pencil : part) sweep.pencils[begin[pencil.upper]++] = pencil;
    part = {};
  }
  checkpoint(context, "thickness", 0.1);
  return sweep;
}

}  // namespace quench::thickness
