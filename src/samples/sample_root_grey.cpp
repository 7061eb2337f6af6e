// SPDX-License-Identifier: Apache-2.0
// The `root` sample as an image of grey values.
#include <algorithm>
#include <deque>
#include <limits>

#include "base/parallel.h"
#include "samples/sample_root.h"

namespace quench::samples {
namespace {

constexpr int kParts = 4;  // points of a voxel along each direction

/// A truncated cone with round ends, in parts of voxels: point (i, j, k) of the finer lattice is at i, j, k.
struct Piece {
  Vec3 from, to;
  double from_radius, to_radius;
  std::uint8_t contrast;  ///< of 255

  bool contains(const Vec3& p) const {
    const Vec3 along = to - from;
    const double t = std::clamp((p - from).dot(along) / std::max(along.squaredNorm(), 1e-300), 0.0, 1.0);
    const double radius = from_radius + t * (to_radius - from_radius);
    return (p - from - t * along).squaredNorm() < radius * radius;
  }
};

/// The part of the lattice between two coordinates.
struct Range {
  std::int64_t begin, end;
};
Range range_of(const Piece& piece, int axis, std::int64_t limit) {
  const double reach = std::max(piece.from_radius, piece.to_radius);
  const double low = std::min(piece.from[axis], piece.to[axis]) - reach;
  const double high = std::max(piece.from[axis], piece.to[axis]) + reach;
  return {std::max<std::int64_t>(0, static_cast<std::int64_t>(std::floor(low))),
          std::min(limit, static_cast<std::int64_t>(std::ceil(high)) + 1)};
}

class GreyPainter {
 public:
  GreyPainter(const Sample& root, const Grid& grid, const GreyOptions& options) : grid_(grid), options_(options) {
    std::vector<std::vector<std::uint8_t>> contrasts;
    for (const RootBranch& branch : root.branches)
      contrasts.emplace_back(branch.points.size() - 1, std::uint8_t{255});  // of segments
    for (const RootDamage& d : root.damage)
      if (d.kind == RootDamage::Kind::gap)
        for (std::size_t i = d.from_point; i < d.to_point; ++i)
          contrasts[d.branch][i] = static_cast<std::uint8_t>(std::lround(255 * d.contrast));
    pieces_of_slice_.resize(static_cast<std::size_t>(grid.dims[2]));
    for (std::size_t b = 0; b < root.branches.size(); ++b) add(root.branches[b], contrasts[b]);
    const int reach = reach_of(options.blur);
    for (int k = -reach; k <= reach; ++k)
      kernel_.push_back(k == 0 ? 1 : static_cast<float>(std::exp(-0.5 * k * k / (options.blur * options.blur))));
    float sum = 0;
    for (float w : kernel_) sum += w;
    for (float& w : kernel_) w /= sum;
  }

  static int reach_of(double blur) { return static_cast<int>(std::ceil(3 * blur)); }

  /// The share of each voxel of slice z that is in a branch, times its contrast; blurred in x and y.
  std::vector<float> painted(std::int64_t z) const {
    const std::int64_t width = grid_.dims[0], height = grid_.dims[1], fine = kParts * width;
    std::vector<float> slice(static_cast<std::size_t>(width * height), 0);
    std::vector<std::uint8_t> plane(static_cast<std::size_t>(fine * kParts * height));
    for (std::int64_t layer = kParts * z; layer < kParts * (z + 1); ++layer) {
      std::fill(plane.begin(), plane.end(), std::uint8_t{0});
      for (const std::uint32_t number : pieces_of_slice_[static_cast<std::size_t>(z)]) {
        const Piece& piece = pieces_[number];
        const Range rows = range_of(piece, 1, kParts * height), columns = range_of(piece, 0, fine);
        for (std::int64_t y = rows.begin; y < rows.end; ++y)
          for (std::int64_t x = columns.begin; x < columns.end; ++x) {
            std::uint8_t& value = plane[static_cast<std::size_t>(x + fine * y)];
            if (value < piece.contrast &&
                piece.contains({static_cast<double>(x), static_cast<double>(y), static_cast<double>(layer)}))
              value = piece.contrast;
          }
      }
      for (std::int64_t y = 0; y < kParts * height; ++y)
        for (std::int64_t x = 0; x < fine; ++x)
          slice[static_cast<std::size_t>(x / kParts + width * (y / kParts))] +=
              static_cast<float>(plane[static_cast<std::size_t>(x + fine * y)]) /
              static_cast<float>(255 * kParts * kParts * kParts);
    }
    blur_lines(slice, height, width, width, 1);
    blur_lines(slice, width, height, 1, width);
    return slice;
  }

  /// Slice z from those around it: `painted_slices` begins with z - reach.
  std::vector<std::uint8_t> finished(std::int64_t z, const std::deque<std::vector<float>>& painted_slices,
                                     std::size_t first) const {
    const std::size_t count = painted_slices[first].size();
    std::vector<std::uint8_t> bytes(count);
    for (std::size_t i = 0; i < count; ++i) {
      double share = 0;
      for (std::size_t k = 0; k < kernel_.size(); ++k)
        share += static_cast<double>(kernel_[k]) * static_cast<double>(painted_slices[first + k][i]);
      if (options_.noise > 0) share += options_.noise * normal(static_cast<std::uint64_t>(z) * count + i);
      const double value = kGreyBackground + share * (kGreyObject - kGreyBackground);
      bytes[i] = static_cast<std::uint8_t>(std::clamp(std::lround(value), 0L, 255L));
    }
    return bytes;
  }

 private:
  void add(const RootBranch& branch, const std::vector<std::uint8_t>& contrasts) {
    const double scale = kParts / grid_.spacing[0];
    const auto place = [&](const Vec3& p) { return Vec3(kParts * grid_.lattice(p) - Vec3::Constant(0.5)); };
    for (std::size_t i = 0; i + 1 < branch.points.size(); ++i) {
      if (contrasts[i] == 0) continue;
      const Piece piece{place(branch.points[i]), place(branch.points[i + 1]), branch.radius[i] * scale,
                        branch.radius[i + 1] * scale, contrasts[i]};
      const Range layers = range_of(piece, 2, kParts * grid_.dims[2]);
      for (std::int64_t z = layers.begin / kParts; z * kParts < layers.end; ++z)
        pieces_of_slice_[static_cast<std::size_t>(z)].push_back(static_cast<std::uint32_t>(pieces_.size()));
      pieces_.push_back(piece);
    }
  }

  /// Lines of `length` values `step` apart; line i begins at i * between.
  void blur_lines(std::vector<float>& slice, std::int64_t lines, std::int64_t length, std::int64_t between,
                  std::int64_t step) const {
    const auto reach = static_cast<std::int64_t>(kernel_.size() / 2);
    if (reach == 0) return;
    std::vector<float> line(static_cast<std::size_t>(length + 2 * reach), 0);
    for (std::int64_t i = 0; i < lines; ++i) {
      for (std::int64_t k = 0; k < length; ++k)
        line[static_cast<std::size_t>(k + reach)] = slice[static_cast<std::size_t>(i * between + k * step)];
      for (std::int64_t k = 0; k < length; ++k) {
        float sum = 0;
        for (std::size_t w = 0; w < kernel_.size(); ++w) sum += kernel_[w] * line[static_cast<std::size_t>(k) + w];
        slice[static_cast<std::size_t>(i * between + k * step)] = sum;
      }
    }
  }

  /// Standard normal (Box and Muller 1958), of its own for every voxel.
  double normal(std::uint64_t voxel) const {
    Random random(options_.seed * 0xD1342543DE82EF95ull + voxel * 0x2545F4914F6CDD1Dull);
    const double radius = std::sqrt(-2 * std::log(1 - random.unit()));
    return radius * std::cos(2 * kPi * random.unit());
  }

  const Grid& grid_;
  const GreyOptions& options_;
  std::vector<Piece> pieces_;
  std::vector<std::vector<std::uint32_t>> pieces_of_slice_;
  std::vector<float> kernel_;
};

}  // namespace
}  // namespace quench::samples

namespace quench {

Grid grey_grid(const Sample& root, const GreyOptions& options) {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const RootBranch& branch : root.branches)
    for (std::size_t i = 0; i < branch.points.size(); ++i) {
      low = low.cwiseMin(branch.points[i] - Vec3::Constant(branch.radius[i]));
      high = high.cwiseMax(branch.points[i] + Vec3::Constant(branch.radius[i]));
    }
  Grid grid;
  const double side = (high - low).maxCoeff() / static_cast<double>(options.resolution);
  const int margin = 1 + samples::GreyPainter::reach_of(options.blur);
  grid.spacing = Vec3::Constant(side);
  for (std::size_t a = 0; a < 3; ++a) {
    const auto axis = static_cast<Eigen::Index>(a);
    grid.dims[a] = static_cast<std::int64_t>(std::ceil((high - low)[axis] / side)) + 2 * margin;
  }
  grid.origin = low - Vec3::Constant((margin - 0.5) * side);
  return grid;
}

void grey_slices(const Sample& root, const GreyOptions& options,
                 const std::function<void(std::span<const std::uint8_t>)>& take, Context* context) {
  base::in_arena(context, [&] {
    const Grid grid = grey_grid(root, options);
    const samples::GreyPainter painter(root, grid, options);
    const std::int64_t reach = samples::GreyPainter::reach_of(options.blur), slices = grid.dims[2];
    constexpr std::int64_t kSlab = 16;
    const std::vector<float> empty(static_cast<std::size_t>(grid.dims[0] * grid.dims[1]), 0);
    std::deque<std::vector<float>> painted(static_cast<std::size_t>(reach), empty);  // from z - reach
    std::int64_t ready = 0;                                                          // slices painted
    for (std::int64_t z = 0; z < slices; z += kSlab) {
      const std::int64_t count = std::min(kSlab, slices - z);
      const std::int64_t more = z + count + reach - ready;
      const std::size_t kept = painted.size();
      painted.resize(kept + static_cast<std::size_t>(more));
      const double done = static_cast<double>(z) / static_cast<double>(slices);
      const double next = static_cast<double>(z + count) / static_cast<double>(slices);
      base::for_chunks(static_cast<std::size_t>(more), context, "image", done, 0.5 * (done + next), [&](std::size_t k) {
        const std::int64_t at = ready + static_cast<std::int64_t>(k);
        painted[kept + k] = at < slices ? painter.painted(at) : empty;
      });
      ready += more;
      std::vector<std::vector<std::uint8_t>> bytes(static_cast<std::size_t>(count));
      base::for_chunks(bytes.size(), context, "image", 0.5 * (done + next), next, [&](std::size_t k) {
        bytes[k] = painter.finished(z + static_cast<std::int64_t>(k), painted, k);
      });
      for (const auto& slice : bytes) take(slice);
      painted.erase(painted.begin(), painted.begin() + count);
    }
  });
}

}  // namespace quench
