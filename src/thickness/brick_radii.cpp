// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "thickness/pencils.h"

namespace quench::thickness {
namespace {

constexpr float kOutside = std::numeric_limits<float>::infinity();

// Bits [begin, end) of a row.
std::uint64_t bits_of(int begin, int end) {
  const int count = end - begin;
  return count <= 0 ? 0 : (count == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << count) - 1) << begin;
}

}  // namespace

// A pencil as a brick sees it.
struct BrickRadii::View {
  const Ball* upper;
  const Ball* lower;
  Lune lune;
  bool whole;                    // a ball without upper one
  float key;                     // the most that it gives
  std::array<int, 3> low, high;  // voxels from the beginning of the brick
  std::uint64_t range;           // along x
};

BrickRadii::BrickRadii(const Sweep& sweep, const Grid& grid, bool between)
    : sweep_(sweep),
      spacing_(grid.spacing),
      between_(between),
      values_(static_cast<std::size_t>(Brick::kSides[0] * Brick::kSides[1] * Brick::kSides[2])) {
  static_assert(Brick::kSides[0] == 64);
}

std::int64_t BrickRadii::begin(const Brick& brick, const VoxelShape& shape, const VoxelShape* mask) {
  brick_ = brick;
  std::fill(values_.begin(), values_.end(), kOutside);
  open_ = {};
  blocks_ = {};
  std::int64_t count = 0;
  for (std::int64_t z = brick.begin[2]; z < brick.end[2]; ++z)
    for (std::int64_t y = brick.begin[1]; y < brick.end[1]; ++y) {
      const auto j = static_cast<std::size_t>(y - brick.begin[1]), k = static_cast<std::size_t>(z - brick.begin[2]);
      const auto bits_in = [&](const VoxelShape& of) {
        const auto runs = of.row(y, z);
        auto run = std::lower_bound(runs.begin(), runs.end(), brick.begin[0],
                                    [](const Run& r, std::int64_t x) { return r.end <= x; });
        std::uint64_t bits = 0;
        for (; run != runs.end() && run->begin < brick.end[0]; ++run)
          bits |= bits_of(static_cast<int>(std::max<std::int64_t>(run->begin - brick.begin[0], 0)),
                          static_cast<int>(std::min<std::int64_t>(run->end, brick.end[0]) - brick.begin[0]));
        return bits;
      };
      std::uint64_t bits = bits_in(shape);
      if (mask && bits) bits &= bits_in(*mask);
      open_[k][j] = bits;
      blocks_[k / kBlock][j / kBlock].open |= bits;
      count += std::popcount(bits);
      float* values = values_.data() + (k * kRowsY + j) * static_cast<std::size_t>(Brick::kSides[0]);
      for (; bits; bits &= bits - 1) values[std::countr_zero(bits)] = 0;
    }
  open_blocks_ = 0;
  for (const auto& plane : blocks_)
    for (const Block& block : plane) open_blocks_ += block.open != 0;
  return count;
}

std::uint64_t BrickRadii::open_in(std::size_t by, std::size_t bz) {
  Block& block = blocks_[bz][by];
  if (!block.changed) return block.open;
  block = {};
  for (std::size_t z = bz * kBlock; z < (bz + 1) * kBlock; ++z)
    for (std::size_t y = by * kBlock; y < (by + 1) * kBlock; ++y) block.open |= open_[z][y];
  open_blocks_ -= block.open == 0;
  return block.open;
}

// Whether the pencil may hold a centre of the block.
bool BrickRadii::may_reach(const View& view, int by, int bz) const {
  const std::array<int, 3> low{view.low[0], std::max(view.low[1], by * kBlock), std::max(view.low[2], bz * kBlock)};
  const std::array<int, 3> high{view.high[0], std::min(view.high[1], (by + 1) * kBlock),
                                std::min(view.high[2], (bz + 1) * kBlock)};
  double ahead = 0, outside = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto axis = static_cast<Eigen::Index>(a);
    const double half = (high[a] - 1 - low[a]) * spacing_[axis] / 2;
    const double way =
        (static_cast<double>(brick_.begin[a] + low[a])) * spacing_[axis] + half - view.lower->centre[axis];
    ahead += view.lune.n[axis] * way + std::abs(view.lune.n[axis]) * half;
    const double beyond = std::max(std::abs(way) - half, 0.0);
    outside += beyond * beyond;
  }
  return ahead >= view.lune.h && outside <= view.lower->limit;
}

// The open voxels of a row.
void BrickRadii::take_row(const View& view, int y, int z, std::uint64_t& open) {
  const Ball &upper = *view.upper, &lower = *view.lower;
  const Vec3& n = view.lune.n;
  const double step = spacing_[0], x0 = static_cast<double>(brick_.begin[0]);
  const double py = static_cast<double>(brick_.begin[1] + y) * spacing_[1];
  const double pz = static_cast<double>(brick_.begin[2] + z) * spacing_[2];
  const double dy = py - lower.centre[1], dz = pz - lower.centre[2];
  const double ey = py - upper.centre[1], ez = pz - upper.centre[2];
  const double lower_rest = dy * dy + dz * dz, upper_rest = ey * ey + ez * ez;
  if (lower_rest > lower.limit) return;
  const double needed = view.lune.h - n[1] * dy - n[2] * dz;
  float* values = values_.data() + (static_cast<std::size_t>(z) * kRowsY + static_cast<std::size_t>(y)) *
                                       static_cast<std::size_t>(Brick::kSides[0]);
  for (std::uint64_t left = open & view.range; left; left &= left - 1) {
    const int x = std::countr_zero(left);
    if (!(values[x] < view.key)) {
      open &= ~(std::uint64_t{1} << x);
      continue;
    }
    const double px = (x0 + x) * step, dx = px - lower.centre[0];
    const double below = dx * dx + lower_rest - lower.limit;  // 0 or less in the lower ball
    if (below > 0 || n[0] * dx < needed) continue;
    double squared = lower.squared;
    if (!view.whole) {
      const double ex = px - upper.centre[0], above = ex * ex + upper_rest - upper.limit;
      if (above <= 0) {
        squared = upper.squared;
      } else if (between_) {
        // The ball between the two on whose sphere the point is: both powers are linear along the way.
        const double t = below / (below - above);
        const double there = (1 - t) * squared + t * (upper.squared - (1 - t) * view.lune.squared_distance);
        squared = std::max(squared, there);
      }
    }
    const float value = static_cast<float>(squared);
    if (value > values[x]) values[x] = value;
    if (!(values[x] < view.key)) open &= ~(std::uint64_t{1} << x);
  }
}

void BrickRadii::take_rows(const View& view, int by, int bz) {
  bool changed = false;
  for (int z = std::max(view.low[2], bz * kBlock); z < std::min(view.high[2], (bz + 1) * kBlock); ++z) {
    auto& rows = open_[static_cast<std::size_t>(z)];
    for (int y = std::max(view.low[1], by * kBlock); y < std::min(view.high[1], (by + 1) * kBlock); ++y) {
      std::uint64_t& open = rows[static_cast<std::size_t>(y)];
      if (!(open & view.range)) continue;
      const std::uint64_t before = open;
      take_row(view, y, z, open);
      changed |= open != before;
    }
  }
  if (changed) blocks_[static_cast<std::size_t>(bz)][static_cast<std::size_t>(by)].changed = true;
}

bool BrickRadii::take(const Pencil& pencil) {
  View view;
  view.upper = &sweep_.balls[pencil.upper];
  view.lower = &sweep_.balls[pencil.lower];
  view.whole = pencil.upper == pencil.lower;
  view.key = static_cast<float>(view.upper->squared);
  for (std::size_t a = 0; a < 3; ++a) {
    view.low[a] = static_cast<int>(std::max<std::int64_t>(pencil.low[a] - brick_.begin[a], 0));
    view.high[a] = static_cast<int>(std::min<std::int64_t>(pencil.high[a], brick_.end[a]) - brick_.begin[a]);
    if (view.low[a] >= view.high[a]) return open_blocks_ > 0;
  }
  view.range = bits_of(view.low[0], view.high[0]);
  bool known = false;
  for (int bz = view.low[2] / kBlock; bz <= (view.high[2] - 1) / kBlock; ++bz)
    for (int by = view.low[1] / kBlock; by <= (view.high[1] - 1) / kBlock; ++by) {
      const auto j = static_cast<std::size_t>(by), k = static_cast<std::size_t>(bz);
      if (!(blocks_[k][j].open & view.range) || !(open_in(j, k) & view.range)) continue;
      if (!known) {
        if (view.whole)
          view.lune.h = -2 * std::sqrt(view.lower->limit);
        else
          view.lune = lune_of(*view.upper, *view.lower);
        known = true;
      }
      if (may_reach(view, by, bz)) take_rows(view, by, bz);
    }
  return open_blocks_ > 0;
}

}  // namespace quench::thickness
