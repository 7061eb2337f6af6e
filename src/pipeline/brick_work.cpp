// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <numeric>
#include <utility>

#include "axis/part_pruning.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/return_memory.h"
#include "pipeline/bricks.h"
#include "pipeline/part_core.h"
#include "quench/error.h"

namespace quench::pipeline {
namespace {

using dual::Hulls;
using dual::bricks::Box;
using dual::bricks::LooseEnds;
using dual::bricks::Part;

// At the peak, measured: per boundary vertex of a box of the first round, and per byte of the parts that a brick of
// another round, or the merge, is made of.
constexpr double kBytesPerSite = 450, kBytesPerByte = 20;

// The box and so many lattice steps around it.
Box grown(Box box, const std::array<std::int64_t, 3>& by) {
  for (std::size_t a = 0; a < 3; ++a) {
    box.low[a] -= by[a];
    box.high[a] += by[a];
  }
  return box;
}

Part part_of_voxels(const BrickPlan& plan, const Box& box, BrickStore& store, Hulls& hulls, Context* context) {
  const std::array<std::int64_t, 3> margin = plan.reach(0);
  Box voxels = grown(box, {margin[0] + 1, margin[1] + 1, margin[2] + 1});
  LatticePoint at{};
  for (std::size_t a = 0; a < 3; ++a) {
    voxels.low[a] = std::max<std::int64_t>(voxels.low[a], 0);
    voxels.high[a] = std::min(voxels.high[a], plan.grid.dims[a]);
    at[a] = static_cast<std::int32_t>(voxels.low[a]);
  }
  const VoxelShape shape = store.voxels(voxels);
  std::vector<LatticePoint> sites = boundary_vertices(shape);
  for (LatticePoint& p : sites)
    for (std::size_t a = 0; a < 3; ++a) p[a] += at[a];
  // Those where the voxels were cut are none of the whole.
  const Box around = grown(box, margin);
  std::erase_if(sites, [&](const LatticePoint& p) { return !around.contains(p); });
  return dual::bricks::first_part(shape, at, sites, box, plan.spacing, hulls, context);
}

// Errors of the bytes of a part name it.
template <class Decode>
auto naming_part(BrickStore& store, std::size_t round, std::size_t brick, const Decode& decode) {
  try {
    return decode();
  } catch (const Error& error) {
    if (error.code() != ErrorCode::input) throw;
    throw Error(ErrorCode::input, fmt::format("'{}' cannot be used: {}; remove it and run its round again",
                                              store.name(round, brick), error.what()));
  }
}

std::vector<Part> parts_of(const BrickPlan& plan, std::size_t round, const std::vector<std::size_t>& bricks,
                           BrickStore& store, Hulls& hulls) {
  std::vector<Part> parts;
  for (const std::size_t brick : bricks)
    parts.push_back(naming_part(store, round, brick, [&] {
      return dual::bricks::decode(store.part(round, brick), hulls, plan.label(round, brick));
    }));
  return parts;
}

// What other parts of a round have to say about a region. Their polytopes reach as far as their own regions.
struct Surroundings {
  std::vector<dual::bricks::Unfinished> unfinished;
  std::vector<LatticePoint> pending;
};

Surroundings around(const BrickPlan& plan, std::size_t round, std::size_t brick, const Box& region, BrickStore& store) {
  Surroundings found;
  for (const std::size_t other : plan.beside(round, brick)) {
    const LooseEnds loose = naming_part(store, round - 1, other, [&] {
      return dual::bricks::decode_loose(store.head(round - 1, other), plan.label(round - 1, other));
    });
    found.unfinished.push_back(dual::bricks::near(loose.unfinished, region));
    std::ranges::copy_if(loose.pending, std::back_inserter(found.pending),
                         [&](const LatticePoint& p) { return region.contains(p); });
  }
  std::ranges::sort(found.pending, {}, [](const LatticePoint& p) { return std::array{p[2], p[1], p[0]}; });
  return found;
}

axis::PartPruning pruning_of(const BrickPlan& plan, const Surface* surface) {
  return {plan.grid, plan.options.rule, plan.options.pruning.measure, plan.cutoff(), surface};
}

Part part_of_parts(const BrickPlan& plan, std::size_t round, std::size_t brick, BrickStore& store, Hulls& hulls,
                   Context* context) {
  const Box box = plan.box(round, brick), region = plan.region(round, brick);
  Part part = dual::bricks::joined(parts_of(plan, round - 1, plan.below(round, brick), store, hulls), context);
  const Surroundings others = around(plan, round, brick, region, store);
  dual::bricks::complete(part, box, &region, others.unfinished, plan.spacing, hulls, context);
  base::return_free_memory();
  if (plan.cutoff() > 0)
    axis::prune_part(part, hulls, pruning_of(plan, store.surface()), region, others.pending, context);
  return part;
}

// Throws Error(failed) with figures where there is no room for so many bytes beside what the process holds.
void require_room(double bytes, const std::string& what, const Context* context) {
  constexpr double kAlways = 32 << 20, kSmall = 64 << 20;  // measuring what is held takes a while
  bytes += kAlways;
  const bool limited = context && context->memory_limit > 0;
  const std::int64_t held = limited && bytes > kSmall ? base::held_memory() : 0;
  require_memory(held + static_cast<std::int64_t>(bytes), what, {"smaller bricks", "a coarser shape"}, context);
}

double bytes_of(const std::vector<std::size_t>& bricks, std::size_t round, BrickStore& store) {
  double bytes = 0;
  for (const std::size_t brick : bricks) bytes += static_cast<double>(store.size(round, brick));
  return bytes;
}

std::vector<std::size_t> all_of(const BrickRound& round) {
  std::vector<std::size_t> all(round.bricks.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  return all;
}

}  // namespace

void run_brick(const BrickPlan& plan, std::size_t round, std::size_t brick, BrickStore& store, Context* context) {
  base::in_arena(context, [&] {
    if (round > 0) store.surface();  // is held then
    require_room(round == 0 ? kBytesPerSite * static_cast<double>(plan.rounds[0].bricks[brick].sites)
                            : kBytesPerByte * bytes_of(plan.below(round, brick), round - 1, store),
                 fmt::format("brick {} of round {}", brick, round + 1), context);
    Hulls hulls;
    const Part part = round == 0 ? part_of_voxels(plan, plan.box(0, brick), store, hulls, context)
                                 : part_of_parts(plan, round, brick, store, hulls, context);
    store.put(round, brick, dual::bricks::encode(part, hulls, plan.label(round, brick)));
  });
  base::return_free_memory();
}

CoreResult merge_bricks(const BrickPlan& plan, const LoadedShape& shape, BrickStore& store, Context* context) {
  return base::in_arena(context, [&] {
    Hulls hulls;
    const std::size_t last = plan.rounds.size() - 1;
    const std::vector<std::size_t> all = all_of(plan.rounds[last]);
    require_room(kBytesPerByte * bytes_of(all, last, store), "the merge of the bricks", context);
    Part part = dual::bricks::joined(parts_of(plan, last, all, store, hulls), context);
    dual::bricks::complete(part, plan.whole(), nullptr, {}, plan.spacing, hulls, context);
    base::return_free_memory();
    return core_of_part(std::move(part), hulls, shape, plan.options, context);
  });
}

std::string BrickStore::name(std::size_t round, std::size_t brick) {
  return fmt::format("brick {} of round {}", brick, round + 1);
}

MemoryBrickStore::MemoryBrickStore(const BrickPlan& plan, const LoadedShape& shape) : shape_(shape) {
  for (const BrickRound& round : plan.rounds) parts_.emplace_back(round.bricks.size());
}

VoxelShape MemoryBrickStore::voxels(const Box& box) { return cut(shape_.shape, box); }

const Surface* MemoryBrickStore::surface() { return shape_.surface ? &*shape_.surface : nullptr; }

bool MemoryBrickStore::has(std::size_t round, std::size_t brick) { return !parts_[round][brick].empty(); }

std::int64_t MemoryBrickStore::size(std::size_t round, std::size_t brick) {
  return static_cast<std::int64_t>(parts_[round][brick].size());
}

std::string MemoryBrickStore::part(std::size_t round, std::size_t brick) { return parts_[round][brick]; }

std::string MemoryBrickStore::head(std::size_t round, std::size_t brick) { return parts_[round][brick]; }

void MemoryBrickStore::put(std::size_t round, std::size_t brick, const std::string& bytes) {
  parts_[round][brick] = bytes;
}

}  // namespace quench::pipeline
