// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "thickness/pencils.h"

#ifdef __SSE2__
#include <emmintrin.h>
#endif

namespace quench::thickness {
namespace {

constexpr float kOutside = std::numeric_limits<float>::infinity();

// Bits [begin, end) of a row.
std::uint64_t bits_of(int begin, int end) {
  const int count = end - begin;
  return count <= 0 ? 0 : (count == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << count) - 1) << begin;
}

// Bits [0, i) of a row.
constexpr std::array<std::uint64_t, 65> kBelow = [] {
  std::array<std::uint64_t, 65> bits{};
  for (std::size_t i = 0; i < 64; ++i) bits[i + 1] = bits[i] << 1 | 1;
  return bits;
}();

// Single precision near a brick, in voxels: intervals are a little wider, and what is in a ball is decided after that.
constexpr double kIntervalSlack = 2e-3;

// Where rows of one slice are in a ball and on one side of a plane.
struct Cut {
  float from = 0, step = 0;               // the first row from the centre, and from row to row
  float squared = 0;                      // of the disk of the slice
  float per_step = 0, low = 0, high = 0;  // the middle of rows, wider and with the 1 that a floor makes a ceiling
  float low_at = -1e9f, low_along = 0, high_at = 1e9f, high_along = 0;
};

// Voxels [low, high) of eight rows.
void cut_intervals(const Cut& cut, int* low, int* high) {
#ifdef __SSE2__  // compilers must think of errno, and leave roots in a loop alone
  const auto all = [](float x) { return _mm_set1_ps(x); };
  const __m128 none = _mm_setzero_ps(), most = all(64);
  for (int i = 0; i < 8; i += 4) {
    const __m128 number = _mm_add_ps(_mm_set_ps(3, 2, 1, 0), all(static_cast<float>(i)));
    const __m128 y = _mm_add_ps(all(cut.from), _mm_mul_ps(all(cut.step), number));
    const __m128 rest = _mm_sub_ps(all(cut.squared), _mm_mul_ps(y, y));
    const __m128 half = _mm_mul_ps(_mm_sqrt_ps(_mm_max_ps(rest, none)), all(cut.per_step));
    const __m128 a =
        _mm_max_ps(_mm_sub_ps(all(cut.low), half), _mm_add_ps(all(cut.low_at), _mm_mul_ps(all(cut.low_along), y)));
    const __m128 b =
        _mm_min_ps(_mm_add_ps(all(cut.high), half), _mm_add_ps(all(cut.high_at), _mm_mul_ps(all(cut.high_along), y)));
    const __m128 inside = _mm_cmpge_ps(rest, none);
    const auto store = [&](int* to, __m128 x) {
      _mm_store_si128(reinterpret_cast<__m128i*>(to + i), _mm_cvttps_epi32(_mm_min_ps(_mm_max_ps(x, none), most)));
    };
    store(low, a);
    store(high, _mm_and_ps(b, inside));
  }
#else
  for (int i = 0; i < 8; ++i) {
    const float y = cut.from + cut.step * static_cast<float>(i), rest = cut.squared - y * y;
    const float half = std::sqrt(std::max(rest, 0.0f)) * cut.per_step;
    const float a = std::max(cut.low - half, cut.low_at + cut.low_along * y);
    const float b = std::min(cut.high + half, cut.high_at + cut.high_along * y);
    low[i] = static_cast<int>(std::min(std::max(a, 0.0f), 64.0f));
    high[i] = static_cast<int>(std::min(std::max(rest < 0 ? 0.0f : b, 0.0f), 64.0f));
  }
#endif
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
  double per_n;                  // of what the lune needs, voxels along x; 0: its plane is nearly along x
  double slack;                  // of the place of this plane, voxels
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
  const Ball& lower = *view.lower;
  view.lune = view.whole ? Lune{} : lune_of(*view.upper, lower);
  const double n = view.lune.n[0];
  view.per_n = !view.whole && std::abs(n) > 1e-3 ? 1 / (n * spacing_[0]) : 0;
  view.slack = 1e-6 * (std::abs(view.lune.h) + 2 * lower.radius) * std::abs(view.per_n) + kIntervalSlack;
}

// The voxels [low, high) of the rows of slice z from `first` on, or some more.
void BrickRadii::cut_rows(const View& view, int z, int first, Rows& rows) const {
  const Ball& lower = *view.lower;
  const Vec3& n = view.lune.n;
  const double dz = static_cast<double>(brick_.begin[2] + z) * spacing_[2] - lower.centre[2];
  const double from = static_cast<double>(brick_.begin[1] + first) * spacing_[1] - lower.centre[1];
  const double middle = lower.centre[0] / spacing_[0] - static_cast<double>(brick_.begin[0]);
  Cut cut;
  cut.from = static_cast<float>(from);
  cut.step = static_cast<float>(spacing_[1]);
  cut.squared = static_cast<float>(lower.limit * (1 + 1e-6) - dz * dz);
  cut.per_step = static_cast<float>(1 / spacing_[0]);
  cut.low = static_cast<float>(middle + 1 - kIntervalSlack);
  cut.high = static_cast<float>(middle + 1 + kIntervalSlack);
  if (view.per_n != 0) {
    const double start = middle + 1 + (view.lune.h - n[2] * dz) * view.per_n, along = -n[1] * view.per_n;
    if (view.per_n > 0) {
      cut.low_at = static_cast<float>(start - view.slack);
      cut.low_along = static_cast<float>(along);
    } else {
      cut.high_at = static_cast<float>(start + view.slack);
      cut.high_along = static_cast<float>(along);
    }
  }
  cut_intervals(cut, rows.low.data(), rows.high.data());
}

// Some voxels of a row, as bits.
void BrickRadii::take_row(const View& view, int y, int z, std::uint64_t left, std::uint64_t& open) {
  const Ball &upper = *view.upper, &lower = *view.lower;
  const double step = spacing_[0], x0 = static_cast<double>(brick_.begin[0]);
  const double py = static_cast<double>(brick_.begin[1] + y) * spacing_[1];
  const double pz = static_cast<double>(brick_.begin[2] + z) * spacing_[2];
  const double dy = py - lower.centre[1], dz = pz - lower.centre[2], lower_rest = dy * dy + dz * dz;
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
  Rows cut;
  for (int z = view.low[2]; z < view.high[2]; ++z) {
    const auto k = static_cast<std::size_t>(z) / kBlock;
    for (int y = view.low[1]; y < view.high[1];) {
      const auto j = static_cast<std::size_t>(y) / kBlock;
      const int first = y, end = std::min(static_cast<int>((j + 1) * kBlock), view.high[1]);
      y = end;
      if (!(blocks_[k][j].open & view.range) || !(open_in(j, k) & view.range)) continue;
      if (!completed) complete(view);
      completed = true;
      cut_rows(view, z, static_cast<int>(j * kBlock), cut);
      for (int row = first; row < end; ++row) {
        const auto i = static_cast<std::size_t>(row) % kBlock;
        std::uint64_t& open = open_[static_cast<std::size_t>(z)][static_cast<std::size_t>(row)];
        const std::uint64_t left =
            open & ~kBelow[static_cast<std::size_t>(cut.low[i])] & kBelow[static_cast<std::size_t>(cut.high[i])];
        if (!left) continue;
        const std::uint64_t before = open;
        take_row(view, row, z, left, open);
        blocks_[k][j].changed |= open != before;
      }
    }
  }
  return open_blocks_ > 0;
}

void BrickRadii::take_few(const Pencil& pencil) {
  View view;
  if (!see(view, pencil)) return;
  for (int z = view.low[2]; z < view.high[2]; ++z)
    for (int y = view.low[1]; y < view.high[1]; ++y) {
      const float* values = row(y, z);
      std::uint64_t open = 0;
      for (int x = view.low[0]; x < view.high[0]; ++x)
        if (values[x] < view.key) open |= std::uint64_t{1} << x;
      if (!open) continue;
      view.lune.squared_distance = (view.upper->centre - view.lower->centre).squaredNorm();
      take_row(view, y, z, open, open);
    }
}

}  // namespace quench::thickness
