// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "base/csr.h"
#include "base/parallel.h"
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
      : shape_(shape), sweep_(sweep), options_(options), dims_(shape.grid().dims), bin_width_(bin_width) {
    for (std::size_t a = 0; a < 3; ++a) bricks_[a] = (dims_[a] + Brick::kSides[a] - 1) / Brick::kSides[a];
    slices_.resize(static_cast<std::size_t>(dims_[0] * dims_[1] * std::min(dims_[2], Brick::kSides[2])));
    slabs_ = base::Csr<std::uint32_t>::group(static_cast<std::size_t>(bricks_[2]), [&](const auto& emit) {
      for (std::uint32_t p = 0; p < sweep_.pencils.size(); ++p) {
        const Pencil& pencil = sweep_.pencils[p];
        for (std::int64_t s = pencil.low[2] / Brick::kSides[2]; s <= (pencil.high[2] - 1) / Brick::kSides[2]; ++s)
          emit(static_cast<std::size_t>(s), p);
      }
    });
  }

  std::int64_t slabs() const { return bricks_[2]; }
  std::span<const float> slice(std::int64_t z) const {
    const auto size = static_cast<std::size_t>(dims_[0] * dims_[1]);
    return {slices_.data() + static_cast<std::size_t>(z % Brick::kSides[2]) * size, size};
  }

  /// Fills the slices of slab `s` and adds to the report.
  void work(std::int64_t s, ThicknessReport& report, Context* context) {
    const std::int64_t begin = s * Brick::kSides[2], end = std::min(begin + Brick::kSides[2], dims_[2]);
    const auto members =
        base::Csr<std::uint32_t>::group(static_cast<std::size_t>(bricks_[0] * bricks_[1]), [&](const auto& emit) {
          for (const std::uint32_t p : slabs_[static_cast<std::size_t>(s)]) {
            const Pencil& pencil = sweep_.pencils[p];
            for (std::int64_t y = pencil.low[1] / Brick::kSides[1]; y <= (pencil.high[1] - 1) / Brick::kSides[1]; ++y)
              for (std::int64_t x = pencil.low[0] / Brick::kSides[0]; x <= (pencil.high[0] - 1) / Brick::kSides[0]; ++x)
                emit(static_cast<std::size_t>(y * bricks_[0] + x), p);
          }
        });
    std::fill(slices_.begin(), slices_.end(), 0.0f);
    const double from = 0.1 + 0.9 * static_cast<double>(s) / static_cast<double>(bricks_[2]);
    const double to = 0.1 + 0.9 * static_cast<double>(s + 1) / static_cast<double>(bricks_[2]);
    std::vector<std::int64_t> voxels(members.rows(), 0);
    base::for_chunks(members.rows(), context, "thickness", from, to, [&](std::size_t b) {
      const auto y = static_cast<std::int64_t>(b) / bricks_[0], x = static_cast<std::int64_t>(b) % bricks_[0];
      Brick brick;
      brick.begin = {x * Brick::kSides[0], y * Brick::kSides[1], begin};
      for (std::size_t a = 0; a < 3; ++a) brick.end[a] = std::min(brick.begin[a] + Brick::kSides[a], dims_[a]);
      BrickRadii radii(sweep_, shape_.grid(), options_.between);
      voxels[b] = radii.begin(brick, shape_, options_.mask);
      if (voxels[b] == 0) return;
      for (const std::uint32_t p : members[b])
        if (!radii.take(sweep_.pencils[p])) break;
      write(radii, brick);
    });
    for (const std::int64_t count : voxels) report.voxels += count;
    add_to(report, begin, end);
  }

 private:
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
  base::Csr<std::uint32_t> slabs_;
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
    report.items = sweep.pencils.size();
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
