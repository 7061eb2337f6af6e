// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "base/parallel.h"
#include "pipeline/bricks.h"
#include "quench/error.h"

namespace quench::pipeline {
namespace {

using dual::bricks::Box;
using Triple = std::array<std::int64_t, 3>;

constexpr std::int64_t kHalo = 8;  // its width is that part of a side

Triple sides_of(std::int64_t size, const Triple& spacing) {
  double volume = 1;
  for (const std::int64_t s : spacing) volume *= static_cast<double>(s);
  Triple side{};
  for (std::size_t a = 0; a < 3; ++a)
    side[a] = std::max<std::int64_t>(
        1, std::llround(static_cast<double>(size) * std::cbrt(volume) / static_cast<double>(spacing[a])));
  return side;
}

bool in_order(const Triple& a, const Triple& b) { return std::array{a[2], a[1], a[0]} < std::array{b[2], b[1], b[0]}; }

// The number of sites per box, by z, y, x; a slab of layers at a time.
BrickRound first_round(const VoxelShape& shape, const Triple& low, const Triple& side, Context* context) {
  constexpr std::int64_t kLayers = 64;
  std::map<Triple, std::int64_t> count;
  const auto& dims = shape.grid().dims;
  for (std::int64_t z = 0; z <= dims[2]; z += kLayers) {
    checkpoint(context, "plan", static_cast<double>(z) / static_cast<double>(dims[2] + 1));
    const std::int64_t first = std::max<std::int64_t>(z - 1, 0), last = std::min(z + kLayers, dims[2]);
    for (const LatticePoint& p : boundary_vertices(cut(shape, {{0, 0, first}, {dims[0], dims[1], last}}))) {
      const std::int64_t layer = p[2] + first;
      if (layer >= z && layer < z + kLayers)
        ++count[{(layer - low[2]) / side[2], (p[1] - low[1]) / side[1], (p[0] - low[0]) / side[0]}];
    }
  }
  checkpoint(context, "plan", 1);
  BrickRound round{side, {}};
  for (const auto& [index, sites] : count) round.bricks.push_back({{index[2], index[1], index[0]}, sites});
  return round;
}

// Of boxes of `times` the side.
BrickRound next_round(const BrickRound& before, std::int64_t times) {
  std::map<Triple, std::int64_t> count;
  for (const Brick& b : before.bricks) count[{b.index[2] / times, b.index[1] / times, b.index[0] / times}] += b.sites;
  BrickRound round;
  for (std::size_t a = 0; a < 3; ++a) round.side[a] = times * before.side[a];
  for (const auto& [index, sites] : count) round.bricks.push_back({{index[2], index[1], index[0]}, sites});
  return round;
}

std::int64_t sites_of(const BrickRound& round) {
  std::int64_t sites = 0;
  for (const Brick& brick : round.bricks) sites += brick.sites;
  return sites;
}

}  // namespace

VoxelShape cut(const VoxelShape& shape, const Box& box) {
  Grid grid = shape.grid();
  for (std::size_t a = 0; a < 3; ++a) grid.dims[a] = box.high[a] - box.low[a];
  grid.origin = shape.grid().world(
      Vec3(static_cast<double>(box.low[0]), static_cast<double>(box.low[1]), static_cast<double>(box.low[2])) +
      grid.first_centre());
  VoxelShape result(grid);
  std::vector<Run> runs;
  for (std::int64_t z = box.low[2]; z < box.high[2]; ++z)
    for (std::int64_t y = box.low[1]; y < box.high[1]; ++y) {
      runs.clear();
      for (const Run& run : shape.row(y, z)) {
        const std::int64_t begin = std::max<std::int64_t>(run.begin, box.low[0]);
        const std::int64_t end = std::min<std::int64_t>(run.end, box.high[0]);
        if (begin < end)
          runs.push_back({static_cast<std::int32_t>(begin - box.low[0]), static_cast<std::int32_t>(end - box.low[0])});
      }
      result.append_row(runs);
    }
  return result;
}

std::string refused_in_bricks(const VoxelShape& shape, const AxisOptions& options) {
  if (shape.grid().is_plane()) return "axes of images and polygons are not made in bricks: they are small";
  if (options.full) return "cells below the threshold are not kept in bricks; ask for a smaller threshold instead";
  if (!options.measures.empty() || (options.pruning.measure != kDetail && options.pruning.measure != kLambda))
    return "measures other than detail and lambda look at all of the shape, and are not known in bricks";
  if (options.pruning.measure == kLambda && !options.pruning.threshold)
    return "an automatic lambda looks at all of the core, and is not known in bricks; give a length";
  return {};
}

BrickPlan plan_of(const LoadedShape& shape, const AxisOptions& options, std::int64_t size, Context* context,
                  const BrickGrowth& growth) {
  if (shape.shape.empty())
    throw Error(ErrorCode::input, "the voxel shape is empty; there is no medial axis to compute");
  if (const std::string reason = refused_in_bricks(shape.shape, options); !reason.empty())
    throw Error(ErrorCode::usage, reason, "in_bricks");
  BrickPlan plan;
  plan.grid = shape.shape.grid();
  plan.spacing = integer_spacing(plan.grid);
  plan.options = options;
  plan.threshold = options.pruning.threshold
                       ? shape.scale().resolve(*options.pruning.threshold, options.pruning.measure)
                       : auto_detail(plan.grid);
  const VoxelShape::Box box = shape.shape.foreground_box();
  plan.low = box.begin;
  plan.high = box.end;
  base::in_arena(context, [&] {
    plan.rounds.push_back(first_round(shape.shape, plan.low, sides_of(size, plan.spacing), context));
  });
  const std::int64_t all = sites_of(plan.rounds[0]);
  for (std::int64_t times = growth.first;; times = growth.then) {
    BrickRound next = next_round(plan.rounds.back(), times);
    const std::int64_t largest = std::ranges::max(next.bricks, {}, &Brick::sites).sites;
    if (static_cast<double>(largest) >= growth.nearly_all * static_cast<double>(all)) break;
    plan.rounds.push_back(std::move(next));
  }
  return plan;
}

double BrickPlan::cutoff() const {
  return options.pruning.measure == kDetail ? std::min(threshold, auto_detail(grid)) : threshold;
}

Box BrickPlan::box(std::size_t round, std::size_t brick) const {
  const BrickRound& r = rounds[round];
  Box box;
  for (std::size_t a = 0; a < 3; ++a) {
    box.low[a] = low[a] + r.bricks[brick].index[a] * r.side[a];
    box.high[a] = box.low[a] + r.side[a];
  }
  return box;
}

Triple BrickPlan::reach(std::size_t round) const {
  Triple reach{};
  const std::int64_t margin = dual::bricks::margin_of_first_part(spacing);
  for (std::size_t a = 0; a < 3; ++a) reach[a] = round == 0 ? margin : std::max(margin, rounds[round].side[a] / kHalo);
  return reach;
}

Box BrickPlan::region(std::size_t round, std::size_t brick) const {
  constexpr std::int64_t kBeyond = 8;  // balls reach a voxel beyond the sites, and are grown by two
  Box region = box(round, brick);
  const Triple halo = reach(round);
  for (std::size_t a = 0; a < 3; ++a) {
    region.low[a] -= halo[a];
    region.high[a] += halo[a];
    if (region.low[a] <= low[a]) region.low[a] = std::min(region.low[a], low[a] - kBeyond);
    if (region.high[a] > high[a]) region.high[a] = std::max(region.high[a], high[a] + 1 + kBeyond);
  }
  return region;
}

std::vector<std::size_t> BrickPlan::bricks_in(std::size_t round, const Box& box) const {
  const BrickRound& r = rounds[round];
  Triple first{}, last{};
  for (std::size_t a = 0; a < 3; ++a) {
    if (box.high[a] <= low[a]) return {};
    first[a] = (std::max(box.low[a], low[a]) - low[a]) / r.side[a];
    last[a] = (std::min(box.high[a] - 1, high[a]) - low[a]) / r.side[a];
  }
  std::vector<std::size_t> found;
  for (std::int64_t z = first[2]; z <= last[2]; ++z)
    for (std::int64_t y = first[1]; y <= last[1]; ++y) {
      auto at = std::ranges::lower_bound(r.bricks, Triple{first[0], y, z}, in_order, &Brick::index);
      for (; at != r.bricks.end() && !in_order({last[0], y, z}, at->index); ++at)
        found.push_back(static_cast<std::size_t>(at - r.bricks.begin()));
    }
  return found;
}

std::vector<std::size_t> BrickPlan::below(std::size_t round, std::size_t brick) const {
  return bricks_in(round - 1, box(round, brick));
}

std::vector<std::size_t> BrickPlan::beside(std::size_t round, std::size_t brick) const {
  Box around = region(round, brick);  // and as far again as the regions of the others reach
  const Triple others = reach(round - 1);
  for (std::size_t a = 0; a < 3; ++a) {
    around.low[a] -= others[a];
    around.high[a] += others[a];
  }
  std::vector<std::size_t> found = bricks_in(round - 1, around);
  const std::vector<std::size_t> own = below(round, brick);
  std::erase_if(found, [&](std::size_t other) { return std::ranges::binary_search(own, other); });
  return found;
}

}  // namespace quench::pipeline
