// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "quench/axis.h"
#include "quench/thickness.h"

namespace quench::thickness {

/// Voxels by which ranges are wider than rounded numbers say; what is in a ball is decided for each voxel.
inline constexpr double kRoundingSlack = 1e-6;

/// A ball in coordinates of the grid in world units: the centre of voxel (i, j, k) is at spacing o (i, j, k).
struct Ball {
  Vec3 centre = Vec3::Zero();
  double squared = 0;  ///< radius
  double limit = 0;    ///< squared distance up to which a point is in
  double radius = 0;   ///< the root of that
};

/// What a pair of balls has that the larger one, of equal ones the first, has not, with the voxels whose centres it may
/// hold. Where both are the same, it is all of a ball that is larger than its neighbours.
struct Pencil {
  std::uint32_t upper = 0, lower = 0;
  std::array<std::int32_t, 3> low{}, high{};  ///< voxels [low, high)

  /// Whether it is quicker to look at all of its voxels than to put it into the order of others.
  bool is_small() const { return (high[0] - low[0]) * (high[1] - low[1]) * (high[2] - low[2]) <= 8; }
};

/// The balls of an axis and their pencils, in the order of its vertices and edges.
struct Sweep {
  struct Chunk {
    std::vector<Pencil> pencils;
    std::int32_t low = std::numeric_limits<std::int32_t>::max(), high = 0;  ///< slices of all of them
  };
  static constexpr std::size_t kChunk = 1 << 13;  // the most of a chunk
  std::vector<Ball> balls;
  std::vector<Chunk> chunks;  ///< those of a core lie near each other

  const Pencil& pencil(std::uint32_t id) const { return chunks[id / kChunk].pencils[id % kChunk]; }
};

/// The half-space n . (p - centre of the lower ball) >= h in which the points are that the lower ball holds and the
/// upper one does not. `h` is a little less than that, for rounding.
struct Lune {
  Vec3 n = Vec3::Zero();
  double h = 0;
  double squared_distance = 0;  ///< of the two centres
};
Lune lune_of(const Ball& upper, const Ball& lower);

/// Pencils that hold a voxel centre in `box`, by their boxes.
Sweep sweep_of(const MedialAxis& axis, const Grid& grid, const VoxelShape::Box& box, bool between, Context* context);

/// A part of the volume: voxels [begin, end), at most kSides of them.
struct Brick {
  static constexpr std::array<std::int64_t, 3> kSides{64, 64, 32};
  std::array<std::int64_t, 3> begin{}, end{};
};

/// Squared radii of the largest balls that hold the centres of the voxels of a brick.
class BrickRadii {
 public:
  BrickRadii(const Sweep& sweep, const Grid& grid, bool between);

  /// Begins a brick: 0 in the shape and the mask, which may be null. Returns the number of these voxels.
  std::int64_t begin(const Brick& brick, const VoxelShape& shape, const VoxelShape* mask);
  /// Takes a pencil, those with larger upper balls first. False: no later one can change anything.
  bool take(const Pencil& pencil);
  /// Takes a pencil of few voxels, in any order, when all others have been taken.
  void take_few(const Pencil& pencil);
  /// Infinite outside the shape and the mask. `y`, `z` from the beginning of the brick.
  const float* row(std::int64_t y, std::int64_t z) const {
    return values_.data() + static_cast<std::size_t>((z * Brick::kSides[1] + y) * Brick::kSides[0]);
  }

 private:
  static constexpr int kBlock = 8;  // rows along y and z
  static constexpr std::size_t kRowsY = static_cast<std::size_t>(Brick::kSides[1]),
                               kRowsZ = static_cast<std::size_t>(Brick::kSides[2]);
  struct View;
  std::uint64_t open_in(std::size_t by, std::size_t bz);
  bool see(View& view, const Pencil& pencil) const;
  void complete(View& view) const;
  struct Rows {
    alignas(32) std::array<int, kBlock> low, high;
  };
  void cut_rows(const View& view, int z, int first, Rows& rows) const;
  void take_row(const View& view, int y, int z, std::uint64_t left, std::uint64_t& open);

  const Sweep& sweep_;
  Vec3 spacing_;
  bool between_;
  Brick brick_;
  std::vector<float> values_;
  // A bit per voxel along x of each row: the value may still grow. Keys descend, so that what has reached one is done.
  std::array<std::array<std::uint64_t, kRowsY>, kRowsZ> open_{};
  // For each block of rows those of any of them, or more where a row has changed.
  struct Block {
    std::uint64_t open = 0;
    bool changed = false;
  };
  std::array<std::array<Block, kRowsY / kBlock>, kRowsZ / kBlock> blocks_{};
  int open_blocks_ = 0;
};

}  // namespace quench::thickness
