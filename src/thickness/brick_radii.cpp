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

// The whole part of a place in a row, or an end of the row.
int place(double x) { return x > 0 ? x < 64 ? static_cast<int>(x) : 64 : 0; }

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
  double per_n;                  // of what the lune needs, voxels along x; 0: its plane is nearly along x
  double per_slice;              // of what the lune needs in a slice; 0: its plane is nearly that of slices
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

// What a view needs beside its box.
void BrickRadii::complete(View& view) const {
  if (view.whole)
    view.lune.h = -2 * std::sqrt(view.lower->limit);
  else
    view.lune = lune_of(*view.upper, *view.lower);
  const double nx = view.lune.n[0], ny = view.lune.n[1], in_slice = std::hypot(nx, ny);
  view.per_n = std::abs(nx) > 1e-6 ? 1 / (nx * spacing_[0]) : 0;
  view.per_slice = in_slice > 1e-6 ? 1 / in_slice : 0;
}

// The open voxels of a row.
void BrickRadii::take_row(const View& view, int y, int z, std::uint64_t& open) {
  const Ball &upper = *view.upper, &lower = *view.lower;
  const Vec3& n = view.lune.n;
  const double step = spacing_[0], x0 = static_cast<double>(brick_.begin[0]);
  const double py = static_cast<double>(brick_.begin[1] + y) * spacing_[1];
  const double pz = static_cast<double>(brick_.begin[2] + z) * spacing_[2];
  const double dy = py - lower.centre[1], dz = pz - lower.centre[2];
  const double lower_rest = dy * dy + dz * dz, rest = lower.limit - lower_rest;
  if (rest < 0) return;
  std::uint64_t left = open & view.range;
  // Where the row is in the half-space, and in the ball.
  const double middle = lower.centre[0] / step - x0;
  if (view.per_n != 0) {
    const double bound = middle + (view.lune.h - n[1] * dy - n[2] * dz) * view.per_n;
    left &=
        view.per_n > 0 ? bits_of(place(bound + 1 - kRoundingSlack), 64) : bits_of(0, place(bound + 1 + kRoundingSlack));
    if (!left) return;
  }
  if (left & (left - 1)) {
    const double half = std::sqrt(rest) / step + kRoundingSlack;
    left &= bits_of(place(middle - half + 1), place(middle + half + 1));
  }
  const double ey = py - upper.centre[1], ez = pz - upper.centre[2], upper_rest = ey * ey + ez * ez;
  float* values = values_.data() + (static_cast<std::size_t>(z) * kRowsY + static_cast<std::size_t>(y)) *
                                       static_cast<std::size_t>(Brick::kSides[0]);
  for (; left; left &= left - 1) {
    const int x = std::countr_zero(left);
    if (!(values[x] < view.key)) {
      open &= ~(std::uint64_t{1} << x);
      continue;
    }
    const double px = (x0 + x) * step, dx = px - lower.centre[0];
    const double below = dx * dx + lower_rest - lower.limit;  // 0 or less in the lower ball
    if (below > 0) continue;
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

// The rows [first, last) of slice z where the lune is.
std::array<int, 2> BrickRadii::rows_in(const View& view, int z) const {
  const Ball& lower = *view.lower;
  const double dz = static_cast<double>(brick_.begin[2] + z) * spacing_[2] - lower.centre[2];
  const double squared = lower.limit - dz * dz;
  if (squared < 0) return {0, 0};
  const double r = std::sqrt(squared), needed = (view.lune.h - view.lune.n[2] * dz) * view.per_slice;
  double down = r, up = r;
  if (view.per_slice != 0) {
    if (needed > r + kRoundingSlack * spacing_[1]) return {0, 0};
    const double ny = view.lune.n[1] * view.per_slice;
    const double chord =
        std::sqrt(std::max(0.0, squared - needed * needed)) * std::abs(view.lune.n[0]) * view.per_slice;
    if (-ny * r < needed) down = -needed * ny + chord;
    if (ny * r < needed) up = needed * ny + chord;
  }
  const double middle = lower.centre[1] / spacing_[1] - static_cast<double>(brick_.begin[1]);
  const int first = place(middle - down / spacing_[1] + 1 - kRoundingSlack);
  const int last = place(middle + up / spacing_[1] + 1 + kRoundingSlack);
  return {std::max(first, view.low[1]), std::min(last, view.high[1])};
}

// False: the brick has none of it.
bool BrickRadii::see(View& view, const Pencil& pencil) const {
  view.upper = &sweep_.balls[pencil.upper];
  view.lower = &sweep_.balls[pencil.lower];
  view.whole = pencil.upper == pencil.lower;
  view.key = static_cast<float>(view.upper->squared);
  for (std::size_t a = 0; a < 3; ++a) {
    view.low[a] = static_cast<int>(std::max<std::int64_t>(pencil.low[a] - brick_.begin[a], 0));
    view.high[a] = static_cast<int>(std::min<std::int64_t>(pencil.high[a], brick_.end[a]) - brick_.begin[a]);
    if (view.low[a] >= view.high[a]) return false;
  }
  view.range = bits_of(view.low[0], view.high[0]);
  return true;
}

bool BrickRadii::take(const Pencil& pencil) {
  View view;
  if (!see(view, pencil)) return open_blocks_ > 0;
  bool completed = false;
  for (int z = view.low[2]; z < view.high[2]; ++z) {
    const auto k = static_cast<std::size_t>(z) / kBlock;
    std::array<int, 2> rows{view.low[1], view.high[1]};
    bool cut = false;
    for (int y = rows[0]; y < rows[1];) {
      const auto j = static_cast<std::size_t>(y) / kBlock;
      const int end = std::min(static_cast<int>((j + 1) * kBlock), rows[1]);
      if (!(blocks_[k][j].open & view.range) || !(open_in(j, k) & view.range)) {
        y = end;
        continue;
      }
      if (!cut) {
        if (!completed) complete(view);
        completed = cut = true;
        rows = rows_in(view, z);
        y = std::max(y, rows[0]);
        continue;
      }
      for (; y < end; ++y) {
        std::uint64_t& open = open_[static_cast<std::size_t>(z)][static_cast<std::size_t>(y)];
        if (!(open & view.range)) continue;
        const std::uint64_t before = open;
        take_row(view, y, z, open);
        blocks_[k][j].changed |= open != before;
      }
    }
  }
  return open_blocks_ > 0;
}

void BrickRadii::take_few(const Pencil& pencil) {
  View view;
  if (!see(view, pencil)) return;
  bool completed = false;
  for (int z = view.low[2]; z < view.high[2]; ++z)
    for (int y = view.low[1]; y < view.high[1]; ++y) {
      const float* values = row(y, z);
      std::uint64_t open = 0;
      for (int x = view.low[0]; x < view.high[0]; ++x)
        if (values[x] < view.key) open |= std::uint64_t{1} << x;
      if (!open) continue;
      if (!completed) complete(view);
      completed = true;
      take_row(view, y, z, open);
    }
}

}  // namespace quench::thickness
