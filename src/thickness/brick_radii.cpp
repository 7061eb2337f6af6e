// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "thickness/pencils.h"

namespace quench::thickness {
namespace {

constexpr float kOutside = std::numeric_limits<float>::infinity();
constexpr double kSlack = 1e-6;  // voxels

// x is in [low, high).
int clipped(double x, int low, int high) { return x > low ? x < high ? static_cast<int>(x) : high : low; }

}  // namespace

// A pencil as a brick sees it.
struct BrickRadii::View {
  const Ball* upper;
  const Ball* lower;
  Lune lune;
  bool whole;                    // a ball without upper one
  float key;                     // the most that it gives
  std::array<int, 3> low, high;  // voxels from the beginning of the brick
};

BrickRadii::BrickRadii(const Sweep& sweep, const Grid& grid, bool between)
    : sweep_(sweep),
      spacing_(grid.spacing),
      between_(between),
      values_(static_cast<std::size_t>(Brick::kSides[0] * Brick::kSides[1] * Brick::kSides[2])) {}

std::int64_t BrickRadii::begin(const Brick& brick, const VoxelShape& shape, const VoxelShape* mask) {
  brick_ = brick;
  std::fill(values_.begin(), values_.end(), kOutside);
  std::int64_t count = 0;
  open_ = {};
  for (std::int64_t z = brick.begin[2]; z < brick.end[2]; ++z)
    for (std::int64_t y = brick.begin[1]; y < brick.end[1]; ++y) {
      float* row = values_.data() + (this->row(y - brick.begin[1], z - brick.begin[2]) - values_.data());
      const auto clear = [&](std::int64_t begin, std::int64_t end) {
        begin = std::max(begin, brick.begin[0]) - brick.begin[0];
        end = std::min(end, brick.end[0]) - brick.begin[0];
        if (begin >= end) return;
        std::fill(row + begin, row + end, 0.0f);
        count += end - begin;
        auto& bits = open_[static_cast<std::size_t>((z - brick.begin[2]) / kZ)]
                          [static_cast<std::size_t>((y - brick.begin[1]) / kY)];
        for (std::int64_t b = begin / kX; b <= (end - 1) / kX; ++b) bits = static_cast<std::uint8_t>(bits | (1U << b));
      };
      const auto runs = shape.row(y, z);
      auto run = std::lower_bound(runs.begin(), runs.end(), brick.begin[0],
                                  [](const Run& r, std::int64_t x) { return r.end <= x; });
      for (; run != runs.end() && run->begin < brick.end[0]; ++run) {
        if (!mask) {
          clear(run->begin, run->end);
          continue;
        }
        for (const Run& kept : mask->row(y, z)) clear(std::max(run->begin, kept.begin), std::min(run->end, kept.end));
      }
    }
  dirty_ = open_;
  open_blocks_ = 0;
  for (const auto& plane : open_)
    for (const std::uint8_t bits : plane) open_blocks_ += std::popcount(bits);
  return count;
}

// Whether a block has a voxel below `key`. Keys descend, so that what is not open never is again.
bool BrickRadii::is_open(int bx, int by, int bz, float key) {
  std::uint8_t& open = open_[static_cast<std::size_t>(bz)][static_cast<std::size_t>(by)];
  std::uint8_t& dirty = dirty_[static_cast<std::size_t>(bz)][static_cast<std::size_t>(by)];
  const unsigned bit = 1U << bx;
  if (!(open & bit)) return false;
  if (!(dirty & bit)) return true;
  dirty = static_cast<std::uint8_t>(dirty & ~bit);
  for (int z = bz * kZ; z < (bz + 1) * kZ; ++z)
    for (int y = by * kY; y < (by + 1) * kY; ++y) {
      const float* values = row(y, z) + bx * kX;
      float least = values[0];
      for (int x = 1; x < kX; ++x) least = values[x] < least ? values[x] : least;
      if (least < key) return true;
    }
  open = static_cast<std::uint8_t>(open & ~bit);
  --open_blocks_;
  return false;
}

// Voxels [first, last) of the rows of blocks.
void BrickRadii::take_rows(const View& view, int by, int bz, int first, int last) {
  const Ball &upper = *view.upper, &lower = *view.lower;
  const Vec3& n = view.lune.n;
  const double step = spacing_[0], per_step = 1 / step, least = lower.squared;
  const double per_n = std::abs(n[0]) > 1e-6 ? 1 / n[0] : 0;
  const double x0 = static_cast<double>(brick_.begin[0]);
  const double middle = lower.centre[0] * per_step - x0;
  const auto at = [&](int i, int a) {
    return static_cast<double>(brick_.begin[static_cast<std::size_t>(a)] + i) * spacing_[a];
  };
  unsigned changed = 0;
  for (int z = std::max(view.low[2], bz * kZ); z < std::min(view.high[2], (bz + 1) * kZ); ++z) {
    const double pz = at(z, 2), dz = pz - lower.centre[2], ez = pz - upper.centre[2];
    for (int y = std::max(view.low[1], by * kY); y < std::min(view.high[1], (by + 1) * kY); ++y) {
      const double py = at(y, 1), dy = py - lower.centre[1], ey = py - upper.centre[1];
      const double rest = lower.limit - (dy * dy + dz * dz);
      if (rest < 0) continue;
      const double half = std::sqrt(rest) * per_step + kSlack;
      double low = middle - half, high = middle + half;
      if (per_n != 0) {
        const double bound = middle + (view.lune.h - n[1] * dy - n[2] * dz) * per_n * per_step;
        if (per_n > 0)
          low = std::max(low, bound - kSlack);
        else
          high = std::min(high, bound + kSlack);
      }
      const int begin = clipped(std::ceil(low), first, last), end = clipped(std::floor(high) + 1, first, last);
      float* values = values_.data() + (row(y, z) - values_.data());
      for (int x = begin; x < end; ++x) {
        if (!(values[x] < view.key)) continue;
        const double px = (x0 + x) * step, dx = px - lower.centre[0];
        const double below = dx * dx + (dy * dy + dz * dz) - lower.limit;  // 0 or less in the lower ball
        if (below > 0) continue;
        double squared = least;
        if (!view.whole) {
          const double ex = px - upper.centre[0], above = ex * ex + (ey * ey + ez * ez) - upper.limit;
          if (above <= 0) {
            squared = upper.squared;
          } else if (between_) {
            // The ball between the two on whose sphere the point is: both powers are linear along the way.
            const double t = below / (below - above);
            const double there = (1 - t) * least + t * (upper.squared - (1 - t) * view.lune.squared_distance);
            squared = std::max(least, there);
          }
        }
        const float value = static_cast<float>(squared);
        if (value > values[x]) {
          values[x] = value;
          changed |= 1U << (x / kX);
        }
      }
    }
  }
  std::uint8_t& dirty = dirty_[static_cast<std::size_t>(bz)][static_cast<std::size_t>(by)];
  dirty = static_cast<std::uint8_t>(dirty | changed);
}

bool BrickRadii::take(const Pencil& pencil) {
  View view;
  view.upper = &sweep_.balls[pencil.upper];
  view.lower = &sweep_.balls[pencil.lower];
  view.whole = pencil.upper == pencil.lower;
  view.key = static_cast<float>(view.upper->squared);
  for (std::size_t a = 0; a < 3; ++a) {
    view.low[a] = static_cast<int>(std::max<std::int64_t>(pencil.low[a] - brick_.begin[a], 0));
    view.high[a] =
        static_cast<int>(std::min(pencil.high[a], static_cast<std::int32_t>(brick_.end[a])) - brick_.begin[a]);
    if (view.low[a] >= view.high[a]) return open_blocks_ > 0;
  }
  bool any = false;
  for (int bz = view.low[2] / kZ; bz <= (view.high[2] - 1) / kZ; ++bz)
    for (int by = view.low[1] / kY; by <= (view.high[1] - 1) / kY; ++by) {
      if (!open_[static_cast<std::size_t>(bz)][static_cast<std::size_t>(by)]) continue;
      if (!any) {
        any = true;
        if (view.whole)
          view.lune.h = -std::sqrt(view.lower->limit);
        else
          view.lune = lune_of(*view.upper, *view.lower);
      }
      int first = view.high[0], last = view.low[0];
      for (int bx = view.low[0] / kX; bx <= (view.high[0] - 1) / kX; ++bx) {
        if (!is_open(bx, by, bz, view.key)) continue;
        // Far from what the pencil has?
        const Vec3 half = spacing_.cwiseProduct(Vec3(kX, kY, kZ)) / 2;
        const Vec3 corner(static_cast<double>(brick_.begin[0] + bx * kX),
                          static_cast<double>(brick_.begin[1] + by * kY),
                          static_cast<double>(brick_.begin[2] + bz * kZ));
        const Vec3 way = spacing_.cwiseProduct(corner) - spacing_ / 2 + half - view.lower->centre;
        if (view.lune.n.dot(way) + view.lune.n.cwiseAbs().dot(half) < view.lune.h) continue;
        const Vec3 outside = (way.cwiseAbs() - half).cwiseMax(0);
        if (outside.squaredNorm() > view.lower->limit) continue;
        first = std::min(first, std::max(view.low[0], bx * kX));
        last = std::max(last, std::min(view.high[0], (bx + 1) * kX));
      }
      if (first < last) take_rows(view, by, bz, first, last);
    }
  return open_blocks_ > 0;
}

}  // namespace quench::thickness
