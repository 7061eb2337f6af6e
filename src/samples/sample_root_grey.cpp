// SPDX-License-Identifier: Apache-2.0
// The `root` sample as an image of grey values.
#include <algorithm>
#include <array>
#include <limits>
#include <memory>

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

/// The part of a lattice between two coordinates.
struct Range {
  std::int64_t begin = 0, end = 0;

  bool empty() const { return begin >= end; }
  bool contains(std::int64_t i) const { return begin <= i && i < end; }
  std::int64_t size() const { return end - begin; }
  Range common(const Range& other) const { return {std::max(begin, other.begin), std::min(end, other.end)}; }
  Range grown(std::int64_t by) const { return {begin - by, end + by}; }
  Range around(const Range& other) const {
    if (empty() || other.empty()) return empty() ? other : *this;
    return {std::min(begin, other.begin), std::max(end, other.end)};
  }
};
/// Of points of the finer lattice the voxels they are in.
Range voxels_of(const Range& points) { return {points.begin / kParts, (points.end + kParts - 1) / kParts}; }

/// Points between two coordinates, and those that are nearer to them than `reach`.
Range range_between(double a, double b, double reach, std::int64_t limit) {
  return {std::max<std::int64_t>(0, static_cast<std::int64_t>(std::floor(std::min(a, b) - reach))),
          std::min(limit, static_cast<std::int64_t>(std::ceil(std::max(a, b) + reach)) + 1)};
}

/// What of the axis of a piece lies near to a point: from `begin` to `end` of its length, both from 0 to 1.
struct AxisPart {
  double begin = 0, end = 1;
  bool empty() const { return begin > end; }
};

double reach_of(const Piece& piece) { return std::max(piece.from_radius, piece.to_radius); }

/// What of a part has a ball that may contain points of which one coordinate is `at`.
AxisPart near_to(const Piece& piece, Eigen::Index axis, double at, const AxisPart& part) {
  const double reach = reach_of(piece) + 1;  // rounding errors are far smaller than a part of a voxel
  const double along = piece.to[axis] - piece.from[axis], way = at - piece.from[axis];
  if (std::abs(along) < 1e-6) return std::abs(way) <= reach ? part : AxisPart{1, 0};
  const double a = (way - reach) / along, b = (way + reach) / along;
  return {std::max(part.begin, std::min(a, b)), std::min(part.end, std::max(a, b))};
}

Range range_of(const Piece& piece, Eigen::Index axis, const AxisPart& part, std::int64_t limit) {
  const double along = piece.to[axis] - piece.from[axis];
  return range_between(piece.from[axis] + part.begin * along, piece.from[axis] + part.end * along, reach_of(piece),
                       limit);
}

/// A rectangle of a slice.
struct Area {
  Range x, y;
  bool empty() const { return x.empty() || y.empty(); }
  Area common(const Area& other) const { return {x.common(other.x), y.common(other.y)}; }
  Area grown(std::int64_t by) const { return {x.grown(by), y.grown(by)}; }
};

/// Values of the voxels in a rectangle; everywhere else they are 0.
struct Patch {
  explicit Patch(const Area& where = {}) : area(where) {
    if (!area.empty()) values.resize(static_cast<std::size_t>(area.x.size() * area.y.size()), 0);
  }
  float* row(std::int64_t y) { return values.data() + area.x.size() * (y - area.y.begin); }
  const float* row(std::int64_t y) const { return values.data() + area.x.size() * (y - area.y.begin); }

  Area area;
  std::vector<float> values;
};

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
    pieces_of_layer_.resize(static_cast<std::size_t>(grid.dims[2] / kLayer + 1));
    for (std::size_t b = 0; b < root.branches.size(); ++b) add(root.branches[b], contrasts[b]);
    const int reach = reach_of_blur(options.blur);
    for (int k = -reach; k <= reach; ++k)
      kernel_.push_back(k == 0 ? 1 : static_cast<float>(std::exp(-0.5 * k * k / (options.blur * options.blur))));
    float sum = 0;
    for (float w : kernel_) sum += w;
    for (float& w : kernel_) w /= sum;
    for (std::size_t i = 0; i < shares_.size(); ++i)
      shares_[i] = static_cast<float>(i) / static_cast<float>(255 * kParts * kParts * kParts);
  }

  static int reach_of_blur(double blur) { return static_cast<int>(std::ceil(3 * blur)); }

  Area whole() const { return {{0, grid_.dims[0]}, {0, grid_.dims[1]}}; }

  /// Which pieces may reach into a box of voxels.
  std::vector<std::uint32_t> pieces_in(const Area& area, const Range& slices) const {
    std::vector<std::uint32_t> numbers;
    const Range inside = slices.common({0, grid_.dims[2]});
    for (std::int64_t layer = inside.begin / kLayer; layer * kLayer < inside.end; ++layer)
      for (const std::uint32_t number : pieces_of_layer_[static_cast<std::size_t>(layer)])
        if (!voxels_of(points_of(pieces_[number], 2)).common(slices).empty() &&
            !area_of(pieces_[number]).common(area).empty())
          numbers.push_back(number);
    std::sort(numbers.begin(), numbers.end());
    numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
    return numbers;
  }

  /// The share of each voxel of slice z that is in one of `pieces`, times its contrast; blurred in x and y. Within
  /// `area`, and where it is not 0.
  Patch painted(const Area& area, std::int64_t z, std::span<const std::uint32_t> pieces) const {
    const auto reach = static_cast<std::int64_t>(kernel_.size() / 2);
    const Area seen = area.grown(reach).common(whole());
    Area part;
    for (const std::uint32_t number : pieces) {
      if (!voxels_of(points_of(pieces_[number], 2)).contains(z)) continue;
      const Area of_piece = area_of(pieces_[number]).common(seen);
      if (of_piece.empty()) continue;
      part = {part.x.around(of_piece.x), part.y.around(of_piece.y)};
    }
    Patch patch(part);
    if (part.empty()) return patch;
    for (std::int64_t layer = kParts * z; layer < kParts * (z + 1); ++layer) add_layer(patch, layer, pieces);
    if (reach == 0) return patch;
    const Area blurred_part = part.grown(reach).common(area);
    return blurred(blurred(patch, 0, blurred_part.x), 1, blurred_part.y);
  }

  /// Slice z from those around it, painted from z - reach to z + reach; row y of `area` begins at `bytes` + (y - least
  /// y)
  /// * `step`.
  void finish(const Area& area, std::int64_t z, std::span<const Patch> around, std::uint8_t* bytes,
              std::int64_t step) const {
    std::vector<double> shares(static_cast<std::size_t>(area.x.size()));
    for (std::int64_t y = area.y.begin; y < area.y.end; ++y) {
      std::fill(shares.begin(), shares.end(), 0.0);
      bool empty = options_.noise == 0;
      for (std::size_t k = 0; k < kernel_.size(); ++k) {
        const Patch& patch = around[k];
        if (patch.area.empty() || !patch.area.y.contains(y)) continue;
        empty = false;
        const float* row = patch.row(y);
        for (std::int64_t x = patch.area.x.begin; x < patch.area.x.end; ++x)
          shares[static_cast<std::size_t>(x - area.x.begin)] +=
              static_cast<double>(kernel_[k]) * static_cast<double>(row[x - patch.area.x.begin]);
      }
      std::uint8_t* to = bytes + (y - area.y.begin) * step;
      if (empty) {
        std::fill_n(to, area.x.size(), std::uint8_t{kGreyBackground});
        continue;
      }
      for (std::int64_t x = area.x.begin; x < area.x.end; ++x) {
        double share = shares[static_cast<std::size_t>(x - area.x.begin)];
        if (options_.noise > 0)
          share += options_.noise * normal(static_cast<std::uint64_t>(x + grid_.dims[0] * (y + grid_.dims[1] * z)));
        const double value = kGreyBackground + share * (kGreyObject - kGreyBackground);
        to[x - area.x.begin] = static_cast<std::uint8_t>(std::clamp(std::lround(value), 0L, 255L));
      }
    }
  }

  std::vector<std::uint8_t> cube(const std::array<std::int64_t, 3>& begin, std::int64_t side) const {
    const auto range = [&](std::size_t a) { return Range{begin[a], std::min(begin[a] + side, grid_.dims[a])}; };
    const Area area{range(0), range(1)};
    const Range slices = range(2);
    const auto reach = static_cast<std::int64_t>(kernel_.size() / 2);
    const std::vector<std::uint32_t> pieces = pieces_in(area.grown(reach), slices.grown(reach));
    if (pieces.empty() && options_.noise == 0) return {};
    std::vector<Patch> patches;
    for (std::int64_t z = slices.begin - reach; z < slices.end + reach; ++z)
      patches.push_back(painted(area, z, pieces));
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(side * side * side), std::uint8_t{kGreyBackground});
    for (std::int64_t z = slices.begin; z < slices.end; ++z) {
      const auto k = static_cast<std::size_t>(z - slices.begin);
      finish(area, z, std::span<const Patch>(patches).subspan(k, kernel_.size()),
             bytes.data() + side * side * (z - slices.begin), side);
    }
    return bytes;
  }

 private:
  static constexpr std::int64_t kLayer = 32;  // slices

  Range points_of(const Piece& piece, int axis) const {
    return range_of(piece, axis, {}, kParts * grid_.dims[static_cast<std::size_t>(axis)]);
  }
  Area area_of(const Piece& piece) const { return {voxels_of(points_of(piece, 0)), voxels_of(points_of(piece, 1))}; }

  void add(const RootBranch& branch, const std::vector<std::uint8_t>& contrasts) {
    const double scale = kParts / grid_.spacing[0];
    const auto place = [&](const Vec3& p) { return Vec3(kParts * grid_.lattice(p) - Vec3::Constant(0.5)); };
    for (std::size_t i = 0; i + 1 < branch.points.size(); ++i) {
      if (contrasts[i] == 0) continue;
      const Piece piece{place(branch.points[i]), place(branch.points[i + 1]), branch.radius[i] * scale,
                        branch.radius[i + 1] * scale, contrasts[i]};
      const Range slices = voxels_of(points_of(piece, 2));
      for (std::int64_t layer = slices.begin / kLayer; layer * kLayer < slices.end; ++layer)
        pieces_of_layer_[static_cast<std::size_t>(layer)].push_back(static_cast<std::uint32_t>(pieces_.size()));
      pieces_.push_back(piece);
    }
  }

  /// A piece where it meets a layer of the finer lattice.
  struct Cut {
    const Piece* piece;
    AxisPart part;
    Range rows;
  };

  /// Adds to the shares what is in the pieces, of points of this z.
  void add_layer(Patch& patch, std::int64_t layer, std::span<const std::uint32_t> pieces) const {
    const Range all_rows{kParts * patch.area.y.begin, kParts * patch.area.y.end};
    const Range all_columns{kParts * patch.area.x.begin, kParts * patch.area.x.end};
    std::vector<Cut> cuts;
    Range rows;
    for (const std::uint32_t number : pieces) {
      const AxisPart part = near_to(pieces_[number], 2, static_cast<double>(layer), {});
      if (part.empty()) continue;
      const Range cut = range_of(pieces_[number], 1, part, kParts * grid_.dims[1]).common(all_rows);
      if (cut.empty()) continue;
      cuts.push_back({&pieces_[number], part, cut});
      rows = rows.around(cut);
    }
    std::vector<std::uint8_t> line(static_cast<std::size_t>(all_columns.size()), 0);
    for (std::int64_t y = rows.begin; y < rows.end; ++y) {
      Range used;
      for (const Cut& cut : cuts)
        if (cut.rows.contains(y)) used = used.around(draw(cut, y, layer, all_columns, line));
      float* row = patch.row(y / kParts) - patch.area.x.begin;
      for (std::int64_t x = used.begin; x < used.end; ++x) {
        std::uint8_t& value = line[static_cast<std::size_t>(x - all_columns.begin)];
        row[x / kParts] += shares_[value];
        value = 0;
      }
    }
  }

  /// Raises a line of points to the contrast of the piece they are in; returns those it has looked at.
  Range draw(const Cut& cut, std::int64_t y, std::int64_t layer, const Range& columns,
             std::vector<std::uint8_t>& line) const {
    const Piece& piece = *cut.piece;
    const AxisPart part = near_to(piece, 1, static_cast<double>(y), cut.part);
    if (part.empty()) return {};
    const Range used = range_of(piece, 0, part, kParts * grid_.dims[0]).common(columns);
    for (std::int64_t x = used.begin; x < used.end; ++x) {
      std::uint8_t& value = line[static_cast<std::size_t>(x - columns.begin)];
      if (value < piece.contrast &&
          piece.contains({static_cast<double>(x), static_cast<double>(y), static_cast<double>(layer)}))
        value = piece.contrast;
    }
    return used;
  }

  /// Along axis 0 or 1, over these coordinates.
  Patch blurred(const Patch& patch, int axis, const Range& to) const {
    Patch out(axis == 0 ? Area{to, patch.area.y} : Area{patch.area.x, to});
    if (out.area.empty()) return out;
    for (std::size_t w = 0; w < kernel_.size(); ++w) {
      const std::int64_t shift = static_cast<std::int64_t>(w) - static_cast<std::int64_t>(kernel_.size() / 2);
      const std::int64_t across = axis == 0 ? shift : 0, up = axis == 0 ? 0 : shift;
      const Range columns = out.area.x.common({patch.area.x.begin - across, patch.area.x.end - across});
      for (std::int64_t y = out.area.y.begin; y < out.area.y.end; ++y) {
        if (!patch.area.y.contains(y + up)) continue;
        const float* from = patch.row(y + up) + across - patch.area.x.begin;
        float* row = out.row(y) - out.area.x.begin;
        for (std::int64_t x = columns.begin; x < columns.end; ++x) row[x] += kernel_[w] * from[x];
      }
    }
    return out;
  }

  /// Standard normal (Box and Muller 1958), of its own for every voxel.
  double normal(std::uint64_t voxel) const {
    Random random(options_.seed * 0xD1342543DE82EF95ull + voxel * 0x2545F4914F6CDD1Dull);
    const double radius = std::sqrt(-2 * std::log(1 - random.unit()));
    return radius * std::cos(2 * kPi * random.unit());
  }

  const Grid grid_;
  const GreyOptions options_;
  std::vector<Piece> pieces_;
  std::vector<std::vector<std::uint32_t>> pieces_of_layer_;
  std::vector<float> kernel_;
  std::array<float, 256> shares_;  // of a voxel, by the contrast of one of its points
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
  const int margin = 1 + samples::GreyPainter::reach_of_blur(options.blur);
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
    const samples::Area whole = painter.whole();
    const std::int64_t reach = samples::GreyPainter::reach_of_blur(options.blur), slices = grid.dims[2];
    constexpr std::int64_t kSlab = 16;
    std::vector<samples::Patch> painted(static_cast<std::size_t>(reach));  // from z - reach
    std::int64_t ready = 0;                                                // slices painted
    for (std::int64_t z = 0; z < slices; z += kSlab) {
      const std::int64_t count = std::min(kSlab, slices - z);
      const std::int64_t more = z + count + reach - ready;
      const std::size_t kept = painted.size();
      painted.resize(kept + static_cast<std::size_t>(more));
      const double done = static_cast<double>(z) / static_cast<double>(slices);
      const double next = static_cast<double>(z + count) / static_cast<double>(slices);
      base::for_chunks(static_cast<std::size_t>(more), context, "image", done, 0.5 * (done + next), [&](std::size_t k) {
        const std::int64_t at = ready + static_cast<std::int64_t>(k);
        painted[kept + k] = painter.painted(whole, at, painter.pieces_in(whole, {at, at + 1}));
      });
      ready += more;
      std::vector<std::vector<std::uint8_t>> bytes(static_cast<std::size_t>(count));
      base::for_chunks(bytes.size(), context, "image", 0.5 * (done + next), next, [&](std::size_t k) {
        bytes[k].resize(static_cast<std::size_t>(grid.dims[0] * grid.dims[1]));
        const std::span<const samples::Patch> around(painted);
        painter.finish(whole, z + static_cast<std::int64_t>(k),
                       around.subspan(k, static_cast<std::size_t>(2 * reach + 1)), bytes[k].data(), grid.dims[0]);
      });
      for (const auto& slice : bytes) take(slice);
      painted.erase(painted.begin(), painted.begin() + count);
    }
  });
}

std::function<std::vector<std::uint8_t>(const std::array<std::int64_t, 3>&)> grey_cubes(const Sample& root,
                                                                                        const GreyOptions& options,
                                                                                        std::int64_t side) {
  const auto painter = std::make_shared<const samples::GreyPainter>(root, grey_grid(root, options), options);
  return [painter, side](const std::array<std::int64_t, 3>& begin) { return painter->cube(begin, side); };
}

}  // namespace quench
