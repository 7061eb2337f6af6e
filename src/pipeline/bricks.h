// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "dual/bricks/part.h"
#include "dual/bricks/part_bytes.h"
#include "quench/pipeline.h"

/// The core of a shape in bricks: boxes of boundary vertices, of a size that memory has room for, in rounds of ever
/// larger boxes. A brick is the work of a task without state; it makes a part of the parts below it. What is left when
/// one box holds all is the merge (docs/algorithms/bricks.md).
namespace quench::pipeline {

/// A box of a round that holds sites.
struct Brick {
  std::array<std::int64_t, 3> index{};  ///< it begins so many sides beyond the lowest corner of all
  std::int64_t sites = 0;               ///< in the box
};

struct BrickRound {
  std::array<std::int64_t, 3> side{};  ///< of its boxes, in lattice steps
  std::vector<Brick> bricks;           ///< in order of z, y, x
};

/// What all tasks know.
struct BrickPlan {
  Grid grid;                              ///< of the whole shape
  std::array<std::int64_t, 3> spacing{};  ///< integer_spacing(grid)
  AxisOptions options;
  double threshold = 0;                       ///< of the measure, world units
  std::array<std::int64_t, 3> low{}, high{};  ///< first and last coordinates of the sites; boxes begin at the first
  std::vector<BrickRound> rounds;             ///< rounds[0]: boxes of single bricks; then of four times the side, then of twice that
  std::uint64_t fingerprint = 0;              ///< of the plan and the shape; 0: there is one plan only

  /// Cells with a lower level are not wanted; 0: all are.
  double cutoff() const;
  dual::bricks::Box box(std::size_t round, std::size_t brick) const;
  /// How far a part of a round knows of what is beyond its box, in lattice steps: an eighth of a side, but at
  /// least as far as in the first round, whose polytopes it has, too.
  std::array<std::int64_t, 3> reach(std::size_t round) const;
  /// The box with what lies within reach; more beyond the last sites, so that no ball leaves it there.
  dual::bricks::Box region(std::size_t round, std::size_t brick) const;
  /// Of all sites.
  dual::bricks::Box whole() const { return {low, {high[0] + 1, high[1] + 1, high[2] + 1}}; }
  /// The bricks of a round that touch a box, ascending.
  std::vector<std::size_t> bricks_in(std::size_t round, const dual::bricks::Box& box) const;
  /// The bricks of the round before that a brick consists of, ascending.
  std::vector<std::size_t> below(std::size_t round, std::size_t brick) const;
  /// Those of the round before whose loose ends a brick looks at, beside the parts it consists of, ascending: their
  /// polytopes may reach into its region.
  std::vector<std::size_t> beside(std::size_t round, std::size_t brick) const;
  dual::bricks::PartLabel label(std::size_t round, std::size_t brick) const {
    return {fingerprint, static_cast<std::uint32_t>(round), static_cast<std::uint32_t>(brick)};
  }
};

/// How the sides of boxes grow from round to round. Bricks of the first round are the share of a task; pruning begins
/// with the second, and finds little in boxes that are small beside the shape. A brick with nearly all sites is left to
/// the merge, which would do the same again.
struct BrickGrowth {
  std::int64_t first = 4, then = 2;
  double nearly_all = 0.6;  ///< share of the sites
};

/// The first round has boxes of about `size`^3 voxels: of the same sides in the world along every axis. Throws
/// Error(usage), field `in_bricks`, for what cannot be done in bricks.
BrickPlan plan_of(const LoadedShape& shape, const AxisOptions& options, std::int64_t size, Context* context,
                  const BrickGrowth& growth = {});
/// What cannot be done in bricks, as a sentence; empty: all.
std::string refused_in_bricks(const VoxelShape& shape, const AxisOptions& options);

/// Where tasks find what others have done. Parts are bytes, as of dual::bricks::encode().
class BrickStore {
 public:
  BrickStore() = default;
  BrickStore(const BrickStore&) = delete;
  BrickStore& operator=(const BrickStore&) = delete;
  virtual ~BrickStore() = default;

  /// The voxels of a box inside the grid, on a grid of its own whose first voxel is `box.low`.
  virtual VoxelShape voxels(const dual::bricks::Box& box) = 0;
  /// What the axis is fitted to; null: the voxels.
  virtual const Surface* surface() = 0;
  virtual bool has(std::size_t round, std::size_t brick) = 0;
  /// Bytes of its part.
  virtual std::int64_t size(std::size_t round, std::size_t brick) = 0;
  virtual std::string part(std::size_t round, std::size_t brick) = 0;
  /// Its first bytes, as many as decode_loose() needs.
  virtual std::string head(std::size_t round, std::size_t brick) = 0;
  virtual void put(std::size_t round, std::size_t brick, const std::string& bytes) = 0;
  /// For errors.
  virtual std::string name(std::size_t round, std::size_t brick);
};

/// All in the memory of a process; the shape must outlive it.
class MemoryBrickStore : public BrickStore {
 public:
  MemoryBrickStore(const BrickPlan& plan, const LoadedShape& shape);
  VoxelShape voxels(const dual::bricks::Box& box) override;
  const Surface* surface() override;
  bool has(std::size_t round, std::size_t brick) override;
  std::int64_t size(std::size_t round, std::size_t brick) override;
  std::string part(std::size_t round, std::size_t brick) override;
  std::string head(std::size_t round, std::size_t brick) override;
  void put(std::size_t round, std::size_t brick, const std::string& bytes) override;

 private:
  const LoadedShape& shape_;
  std::vector<std::vector<std::string>> parts_;
};

/// The voxels of a box of a shape, on a grid of their own. O(runs of its rows).
VoxelShape cut(const VoxelShape& shape, const dual::bricks::Box& box);

/// Does a brick: puts its part into the store. All bricks of the round before must be there.
void run_brick(const BrickPlan& plan, std::size_t round, std::size_t brick, BrickStore& store, Context* context);
/// Does what is left when all rounds are done. `shape`: that of the plan.
CoreResult merge_bricks(const BrickPlan& plan, const LoadedShape& shape, BrickStore& store, Context* context);

}  // namespace quench::pipeline
