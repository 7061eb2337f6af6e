// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "base/parallel.h"
#include "quench/envelope.h"
#include "quench/error.h"

namespace quench {
namespace {

constexpr std::int64_t kBlock = 16;  ///< voxels along a side of the largest boxes, a power of two
constexpr std::int64_t kLargestGrid = 16384;

/// Voxels of `kBlock` slices, box by box.
class BlockLayer {
 public:
  BlockLayer(const Envelope& envelope, const Grid& grid, std::int64_t first)
      : envelope_(envelope),
        grid_(grid),
        first_(first),
        slices_(std::min(kBlock, grid.dims[2] - first)),
        in_(static_cast<std::size_t>(grid.dims[0] * grid.dims[1] * slices_), 0),
        slack_(1e-9 * envelope.largest_radius()) {
    for (std::int64_t y = 0; y < grid.dims[1]; y += kBlock)
      for (std::int64_t x = 0; x < grid.dims[0]; x += kBlock)
        decide({{x, y, first_},
                {std::min(x + kBlock, grid.dims[0]), std::min(y + kBlock, grid.dims[1]), first_ + slices_}});
  }

  /// The runs of all scanlines, one behind the other, and where each ends.
  void append(std::vector<Run>& runs, std::vector<std::size_t>& ends) const {
    const std::int64_t width = grid_.dims[0], rows = grid_.dims[1] * slices_;
    for (std::int64_t r = 0; r < rows; ++r) {
      const std::uint8_t* row = in_.data() + r * width;
      for (std::int64_t x = 0; x < width; ++x) {
        if (!row[x]) continue;
        const std::int64_t begin = x;
        while (x < width && row[x]) ++x;
        runs.push_back({static_cast<std::int32_t>(begin), static_cast<std::int32_t>(x)});
      }
      ends.push_back(runs.size());
    }
  }

 private:
  struct Box {
    std::array<std::int64_t, 3> begin, end;
  };

  void fill(const Box& box) {
    for (std::int64_t z = box.begin[2]; z < box.end[2]; ++z)
      for (std::int64_t y = box.begin[1]; y < box.end[1]; ++y) {
        std::uint8_t* row = in_.data() + (y + grid_.dims[1] * (z - first_)) * grid_.dims[0];
        std::fill(row + box.begin[0], row + box.end[0], std::uint8_t{1});
      }
  }

  void decide(const Box& box) {
    Vec3 middle, half;
    int longest = 0;
    for (int a = 0; a < 3; ++a) {
      const auto i = static_cast<std::size_t>(a);
      const auto size = static_cast<double>(box.end[i] - box.begin[i]);
      middle[a] = static_cast<double>(box.begin[i]) + 0.5 * size;
      half[a] = 0.5 * (size - 1) * grid_.spacing[a];
      if (box.end[i] - box.begin[i] >
          box.end[static_cast<std::size_t>(longest)] - box.begin[static_cast<std::size_t>(longest)])
        longest = a;
    }
    if (grid_.is_plane()) middle[2] = 0;
    const Vec3 p = grid_.world(middle);
    const auto l = static_cast<std::size_t>(longest);
    const std::int64_t size = box.end[l] - box.begin[l];
    if (size == 1) {
      if (envelope_.contains(p)) fill(box);
      return;
    }
    const double reach = half.norm();
    const Envelope::Ball ball = envelope_.nearest(p, 1.001 * reach + slack_, -reach);
    if (ball.element == kNone) return;
    if (ball.distance <= -reach) return fill(box);
    // Halves at multiples of powers of two, all sides that are long at once.
    std::int64_t step = 1;
    while (2 * step < size) step *= 2;
    for (std::int64_t z = box.begin[2]; z < box.end[2]; z += step)
      for (std::int64_t y = box.begin[1]; y < box.end[1]; y += step)
        for (std::int64_t x = box.begin[0]; x < box.end[0]; x += step)
          decide({{x, y, z},
                  {std::min(x + step, box.end[0]), std::min(y + step, box.end[1]), std::min(z + step, box.end[2])}});
  }

  const Envelope& envelope_;
  const Grid& grid_;
  std::int64_t first_, slices_;
  std::vector<std::uint8_t> in_;
  double slack_;
};

}  // namespace

Grid grid_around(const Envelope& envelope, double spacing) {
  const Vec3 size = envelope.high() - envelope.low();
  if (!(spacing > 0) || !(size.maxCoeff() / spacing <= static_cast<double>(kLargestGrid - 4)))
    throw Error(ErrorCode::usage,
                "the size of a voxel must be a number above 0 that gives at most 16384 voxels along an axis");
  Grid grid;
  grid.spacing = Vec3::Constant(spacing);
  for (int a = 0; a < 3; ++a)
    grid.dims[static_cast<std::size_t>(a)] = static_cast<std::int64_t>(std::ceil(size[a] / spacing)) + 2;
  grid.origin = envelope.low() - Vec3::Constant(0.5 * spacing);
  return grid;
}

Grid grown_around(const Envelope& envelope, const Grid& grid) {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  // The box of the envelope has its sides along those of the world.
  for (int corner = 0; corner < 8; ++corner) {
    Vec3 at;
    for (int a = 0; a < 3; ++a) at[a] = corner >> a & 1 ? envelope.high()[a] : envelope.low()[a];
    const Vec3 lattice = grid.lattice(at);
    low = low.cwiseMin(lattice);
    high = high.cwiseMax(lattice);
  }
  Grid grown = grid;
  Vec3 first = grid.first_centre();
  for (int a = 0; a < grid.dimension; ++a) {
    const auto i = static_cast<std::size_t>(a);
    const double below = std::max(0.0, 1 - std::floor(low[a])),
                 above = std::max(0.0, std::ceil(high[a]) + 1 - static_cast<double>(grid.dims[i]));
    if (!(static_cast<double>(grid.dims[i]) + below + above <= 4.0 * kLargestGrid))
      throw Error(ErrorCode::usage, "the axis reaches too far beyond the grid of the shape; is it that of the shape?");
    first[a] -= below;
    grown.dims[i] += static_cast<std::int64_t>(below + above);
  }
  grown.origin = grid.world(first);
  return grown;
}

VoxelShape voxels_of(const Envelope& envelope, const Grid& grid, Context* context) {
  const auto layers = static_cast<std::size_t>((grid.dims[2] + kBlock - 1) / kBlock);
  struct Rows {
    std::vector<Run> runs;
    std::vector<std::size_t> ends;
  };
  std::vector<Rows> rows(layers);
  base::in_arena(context, [&] {
    base::for_chunks(layers, context, "voxels", 0, 1, [&](std::size_t l) {
      BlockLayer(envelope, grid, static_cast<std::int64_t>(l) * kBlock).append(rows[l].runs, rows[l].ends);
    });
  });
  VoxelShape shape(grid);
  for (Rows& layer : rows) {
    std::size_t from = 0;
    for (const std::size_t end : layer.ends) {
      shape.append_row({layer.runs.data() + from, layer.runs.data() + end});
      from = end;
    }
    layer = {};
  }
  return shape;
}

VolumeErrors volume_errors(const VoxelShape& envelope, const VoxelShape& shape) {
  const Grid &ours = envelope.grid(), &its = shape.grid();
  const Vec3 offset = ours.lattice(its.origin) - ours.first_centre();
  std::array<std::int64_t, 3> shift{};
  bool one = ours.dimension == its.dimension && ours.direction.isApprox(its.direction, 1e-9) &&
             ours.spacing.isApprox(its.spacing, 1e-9);
  for (int a = 0; a < ours.dimension; ++a) {
    const double whole = std::round(offset[a]);
    one = one && std::abs(offset[a] - whole) < 1e-3 && std::abs(whole) < 1e9;
    if (one) shift[static_cast<std::size_t>(a)] = static_cast<std::int64_t>(whole);
  }
  if (!one) throw Error(ErrorCode::usage, "the voxels of the envelope and of the shape are not of one lattice");
  std::int64_t common = 0;
  for (std::int64_t z = 0; z < its.dims[2]; ++z)
    for (std::int64_t y = 0; y < its.dims[1]; ++y) {
      const auto a = shape.row(y, z), b = envelope.row(y + shift[1], z + shift[2]);
      for (std::size_t i = 0, j = 0; i < a.size() && j < b.size();) {
        const std::int64_t begin = std::max<std::int64_t>(a[i].begin, b[j].begin - shift[0]),
                           end = std::min<std::int64_t>(a[i].end, b[j].end - shift[0]);
        common += std::max<std::int64_t>(0, end - begin);
        if (a[i].end < b[j].end - shift[0])
          ++i;
        else
          ++j;
      }
    }
  const double voxel =
      ours.is_plane() ? ours.spacing[0] * ours.spacing[1] : ours.spacing[0] * ours.spacing[1] * ours.spacing[2];
  const std::int64_t of_shape = shape.voxel_count(), of_envelope = envelope.voxel_count();
  return {static_cast<double>(of_shape) * voxel, static_cast<double>(of_envelope) * voxel,
          static_cast<double>(of_shape - common) * voxel, static_cast<double>(of_envelope - common) * voxel};
}

}  // namespace quench
