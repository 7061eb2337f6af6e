// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "base/prefetch.h"
#include "quench/error.h"
#include "thickness/pencils.h"

namespace quench {
namespace {

using thickness::Brick;
using thickness::BrickRadii;
using thickness::Pencil;
using thickness::Sweep;

// The slices of a volume, Brick::kSides[2] at a time.
class SlabWorker {
 public:
  SlabWorker(const VoxelShape& shape, const Sweep& sweep, const ThicknessOptions& options, double bin_width)
      : shape_(shape), sweep_(sweep), options_(options), dims_(shape.grid().dims), bin_width_(bin_width), desks_([&] {
          return Desk{BrickRadii(sweep, shape.grid(), options.between), {}, {}, {}};
        }) {
    for (std::size_t a = 0; a < 3; ++a) bricks_[a] = (dims_[a] + Brick::kSides[a] - 1) / Brick::kSides[a];
    slices_.resize(static_cast<std::size_t>(dims_[0] * dims_[1] * std::min(dims_[2], Brick::kSides[2])));
  }

  std::int64_t slabs() const { return bricks_[2]; }
  std::span<const float> slice(std::int64_t z) const {
    const auto size = static_cast<std::size_t>(dims_[0] * dims_[1]);
    return {slices_.data() + static_cast<std::size_t>(z % Brick::kSides[2]) * size, size};
  }

  /// Fills the slices of slab `s` and adds to the report.
  void work(std::int64_t s, ThicknessReport& report, Context* context) {
    const std::int64_t begin = s * Brick::kSides[2], end = std::min(begin + Brick::kSides[2], dims_[2]);
    const Members members = members_of(begin, end);
    std::fill(slices_.begin(), slices_.end(), 0.0f);
    const double from = 0.1 + 0.9 * static_cast<double>(s) / static_cast<double>(bricks_[2]);
    const double to = 0.1 + 0.9 * static_cast<double>(s + 1) / static_cast<double>(bricks_[2]);
    const auto bricks = static_cast<std::size_t>(bricks_[0] * bricks_[1]);
    std::vector<std::int64_t> voxels(bricks, 0);
    base::for_chunks(bricks, context, "thickness", from, to, [&](std::size_t b) {
      const auto y = static_cast<std::int64_t>(b) / bricks_[0], x = static_cast<std::int64_t>(b) % bricks_[0];
      Brick brick;
      brick.begin = {x * Brick::kSides[0], y * Brick::kSides[1], begin};
      for (std::size_t a = 0; a < 3; ++a) brick.end[a] = std::min(brick.begin[a] + Brick::kSides[a], dims_[a]);
      Desk& desk = desks_.local();
      voxels[b] = desk.radii.begin(brick, shape_, options_.mask);
      if (voxels[b] == 0) return;
      sort_by_upper(std::span(members.items).subspan(members.begin[b], members.begin[b + 1] - members.begin[b]), desk);
      for (std::size_t i = 0; i < desk.entries.size(); ++i) {
        if (i + kAhead < desk.entries.size()) prefetch(desk.entries[i + kAhead], desk.entries[i + kAhead / 2]);
        if (!desk.radii.take(sweep_.pencil(static_cast<std::uint32_t>(desk.entries[i])))) break;
      }
      for (const std::uint32_t p : desk.few) desk.radii.take_few(sweep_.pencil(p));
      write(desk.radii, brick);
    });
    for (const std::int64_t count : voxels) report.voxels += count;
    add_to(report, begin, end);
  }

 private:
  // What a thread works with.
  struct Desk {
    BrickRadii radii;
    std::vector<std::uint64_t> entries, other;  // the key of a pencil, and which it is
    std::vector<std::uint32_t> few;             // small ones
  };
  // The pencils of each brick of a slab.
  struct Members {
    std::vector<std::size_t> begin;
    std::vector<std::uint32_t> items;
  };

  // Those of a brick come in any order, which does not change its values.
  Members members_of(std::int64_t begin, std::int64_t end) const {
    const auto bricks = static_cast<std::size_t>(bricks_[0] * bricks_[1]);
    const auto each = [&](const auto& visit) {
      tbb::parallel_for(std::size_t{0}, sweep_.chunks.size(), [&](std::size_t c) {
        const Sweep::Chunk& chunk = sweep_.chunks[c];
        if (chunk.low >= end || chunk.high <= begin) return;
        for (std::size_t i = 0; i < chunk.pencils.size(); ++i) {
          const Pencil& pencil = chunk.pencils[i];
          if (pencil.low[2] >= end || pencil.high[2] <= begin) continue;
          for (std::int64_t y = pencil.low[1] / Brick::kSides[1]; y <= (pencil.high[1] - 1) / Brick::kSides[1]; ++y)
            for (std::int64_t x = pencil.low[0] / Brick::kSides[0]; x <= (pencil.high[0] - 1) / Brick::kSides[0]; ++x)
              visit(static_cast<std::size_t>(y * bricks_[0] + x), static_cast<std::uint32_t>(c * Sweep::kChunk + i));
        }
      });
    };
    const bool shared = base::several_threads();
    Members members;
    members.begin.assign(bricks + 1, 0);
    each([&](std::size_t brick, std::uint32_t) { base::fetch_add(members.begin[brick + 1], std::size_t{1}, shared); });
    for (std::size_t b = 0; b < bricks; ++b) members.begin[b + 1] += members.begin[b];
    std::vector<std::size_t> next(members.begin.begin(), members.begin.end() - 1);
    members.items.resize(members.begin.back());
    each([&](std::size_t brick, std::uint32_t p) {
      members.items[base::fetch_add(next[brick], std::size_t{1}, shared)] = p;
    });
    return members;
  }

  // By descending squared radius of the upper ball: counting by 11 bits at a time of the complement of its float.
  void sort_by_upper(std::span<const std::uint32_t> items, Desk& desk) const {
    constexpr int kBits = 11;
    constexpr std::uint32_t kMask = (1U << kBits) - 1;
    desk.entries.clear();
    desk.few.clear();
    std::array<std::array<std::uint32_t, kMask + 2>, 3> counts{};
    for (const std::uint32_t p : items) {
      const Pencil& pencil = sweep_.pencil(p);
      if (pencil.is_small()) {
        desk.few.push_back(p);
        continue;
      }
      const std::uint32_t key = ~std::bit_cast<std::uint32_t>(static_cast<float>(sweep_.balls[pencil.upper].squared));
      desk.entries.push_back(std::uint64_t{key} << 32 | p);
      for (std::size_t d = 0; d < 3; ++d) ++counts[d][(key >> (kBits * d) & kMask) + 1];
    }
    desk.other.resize(desk.entries.size());
    for (std::size_t d = 0; d < 3; ++d) {
      auto& begin = counts[d];
      for (std::size_t i = 1; i < begin.size(); ++i) begin[i] += begin[i - 1];
      for (const std::uint64_t entry : desk.entries) desk.other[begin[entry >> (32 + kBits * d) & kMask]++] = entry;
      desk.entries.swap(desk.other);
    }
  }

  // The pencils of later entries, and the balls of nearer ones.
  static constexpr std::size_t kAhead = 16;
  void prefetch(std::uint64_t later, std::uint64_t nearer) const {
    base::prefetch(&sweep_.pencil(static_cast<std::uint32_t>(later)));
    const Pencil& pencil = sweep_.pencil(static_cast<std::uint32_t>(nearer));
    base::prefetch(&sweep_.balls[pencil.upper]);
    base::prefetch(&sweep_.balls[pencil.lower]);
  }

  void write(const BrickRadii& radii, const Brick& brick) {
    for (std::int64_t z = brick.begin[2]; z < brick.end[2]; ++z)
      for (std::int64_t y = brick.begin[1]; y < brick.end[1]; ++y) {
        const float* squared = radii.row(y - brick.begin[1], z - brick.begin[2]);
        float* out = slices_.data() + ((z % Brick::kSides[2]) * dims_[1] + y) * dims_[0] + brick.begin[0];
        for (std::int64_t x = 0; x < brick.end[0] - brick.begin[0]; ++x)
          if (squared[x] > 0 && squared[x] < std::numeric_limits<float>::infinity())
            out[x] = static_cast<float>(2 * (std::sqrt(static_cast<double>(squared[x])) + options_.correction));
      }
  }

  // In the order of slices, so that sums do not depend on threads.
  void add_to(ThicknessReport& report, std::int64_t begin, std::int64_t end) {
    std::vector<ThicknessDistribution> parts(static_cast<std::size_t>(end - begin), ThicknessDistribution(bin_width_));
    tbb::parallel_for(std::int64_t{0}, end - begin, [&](std::int64_t i) {
      ThicknessDistribution& part = parts[static_cast<std::size_t>(i)];
      for (const float value : slice(begin + i))
        if (value != 0) part.add(static_cast<double>(value));
    });
    for (const ThicknessDistribution& part : parts) report.distribution.add(part);
  }

  const VoxelShape& shape_;
  const Sweep& sweep_;
  const ThicknessOptions& options_;
  std::array<std::int64_t, 3> dims_, bricks_{};
  double bin_width_;
  std::vector<float> slices_;
  tbb::enumerable_thread_specific<Desk> desks_;
};

}  // namespace

ThicknessReport local_thickness(const VoxelShape& shape, const MedialAxis& axis, const ThicknessOptions& options,
                                const TakeThickness& take, Context* context) {
  const Grid& grid = shape.grid();
  if (options.mask && options.mask->grid().dims != grid.dims) {
    const auto& m = options.mask->grid().dims;
    throw Error(ErrorCode::usage,
                fmt::format("the mask has {} x {} x {} voxels and the shape {} x {} x {}; give one of the same size",
                            m[0], m[1], m[2], grid.dims[0], grid.dims[1], grid.dims[2]),
                "mask");
  }
  if (axis.radius.size() != axis.points.size())
    throw Error(ErrorCode::usage, "a medial axis has a radius for each point");
  return base::in_arena(context, [&] {
    const Sweep sweep = thickness::sweep_of(axis, grid, shape.foreground_box(), options.between, context);
    const double largest = sweep.balls.empty() ? 0 : 2 * (std::sqrt(sweep.balls.front().squared) + options.correction);
    const double width = options.bin_width > 0 ? options.bin_width : automatic_bin_width(grid, largest);
    ThicknessReport report;
    report.distribution = ThicknessDistribution(width);
    for (const Sweep::Chunk& chunk : sweep.chunks) report.items += chunk.pencils.size();
    SlabWorker worker(shape, sweep, options, width);
    for (std::int64_t s = 0; s < worker.slabs(); ++s) {
      worker.work(s, report, context);
      if (!take) continue;
      const std::int64_t first = s * Brick::kSides[2];
      for (std::int64_t z = first; z < std::min(first + Brick::kSides[2], grid.dims[2]); ++z) take(z, worker.slice(z));
    }
    report.uncovered = report.voxels - static_cast<std::int64_t>(report.distribution.weight());
    return report;
  });
}

std::vector<float> thickness_volume(const VoxelShape& shape, const MedialAxis& axis, const ThicknessOptions& options,
                                    Context* context) {
  const auto& dims = shape.grid().dims;
  std::vector<float> all(static_cast<std::size_t>(dims[0] * dims[1] * dims[2]));
  local_thickness(
      shape, axis, options,
      [&](std::int64_t z, std::span<const float> slice) {
        std::copy(slice.begin(), slice.end(), all.begin() + z * static_cast<std::int64_t>(slice.size()));
      },
      context);
  return all;
}

}  // namespace quench
