// SPDX-License-Identifier: Apache-2.0
// Whether a surface is that of grey values, by an interpolation of its own.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "verification/checks.h"

namespace quench::verification {

namespace {

// How far the surface may be from the value, in voxels along each axis: smoothing moves points by less than half of
// one; where the middle of a loop is not moved to the value, as its triangles would turn over, it is farther.
constexpr double kOffIsosurface = 0.5, kFarthestOff = 1;
constexpr double kLeastNear = 0.99;  // of the points

/// Samples of an image, interpolated trilinearly between the centres of its voxels.
class Interpolation {
 public:
  explicit Interpolation(const ImageView& image) : image_(image) {}

  bool is_whole() const { return image_.type != SampleType::float32 && image_.type != SampleType::float64; }
  /// The place of a point of the world among the samples; sample i is at i.
  Vec3 place(const Vec3& world) const { return image_.grid.lattice(world) - Vec3::Constant(0.5); }
  bool has(const Vec3& place, double margin) const {
    for (int a = 0; a < 3; ++a)
      if (!(place[a] >= margin &&
            place[a] <= static_cast<double>(image_.grid.dims[static_cast<std::size_t>(a)]) - 1 - margin))
        return false;
    return true;
  }
  /// Whether one of the voxels around a place is of the shape though its value is not: closing or joining added it.
  bool is_beside_added(const Vec3& place, const VoxelShape& shape, double threshold, bool inverted) const {
    for (int c = 0; c < 8; ++c) {
      std::array<std::int64_t, 3> at;
      Vec3 centre;
      bool there = true;
      for (std::size_t a = 0; a < 3; ++a) {
        const int i = static_cast<int>(a);
        at[a] = static_cast<std::int64_t>(std::floor(place[i])) + (c >> a & 1);
        there = there && at[a] >= 0 && at[a] < image_.grid.dims[a];
        centre[i] = static_cast<double>(at[a]) + 0.5;
      }
      if (!there) continue;
      const double value = sample(at);
      if (inverted ? value < threshold : value >= threshold) continue;
      const Vec3 in_shape = shape.grid().lattice(image_.grid.world(centre));
      if (shape.contains(static_cast<std::int64_t>(std::floor(in_shape[0])),
                         static_cast<std::int64_t>(std::floor(in_shape[1])),
                         static_cast<std::int64_t>(std::floor(in_shape[2]))))
        return true;
    }
    return false;
  }
  double at(const Vec3& place) const {
    std::array<std::int64_t, 3> low;
    Vec3 part;
    for (std::size_t a = 0; a < 3; ++a) {
      const int i = static_cast<int>(a);
      low[a] = std::clamp(static_cast<std::int64_t>(std::floor(place[i])), std::int64_t{0},
                          std::max<std::int64_t>(image_.grid.dims[a] - 2, 0));
      part[i] = place[i] - static_cast<double>(low[a]);
    }
    double sum = 0;
    for (int c = 0; c < 8; ++c) {
      std::array<std::int64_t, 3> at = low;
      double share = 1;
      for (std::size_t a = 0; a < 3; ++a) {
        const bool up = (c >> a & 1) != 0;
        const double t = part[static_cast<int>(a)];
        share *= up ? t : 1 - t;
        at[a] += up;
      }
      if (share > 0) sum += share * sample(at);
    }
    return sum;
  }

 private:
  double sample(const std::array<std::int64_t, 3>& at) const {
    const char* from = static_cast<const char*>(image_.data);
    for (std::size_t a = 0; a < 3; ++a) from += image_.strides[a] * at[a];
    switch (image_.type) {
      case SampleType::uint8:
        return as<std::uint8_t>(from);
      case SampleType::int8:
        return as<std::int8_t>(from);
      case SampleType::uint16:
        return as<std::uint16_t>(from);
      case SampleType::int16:
        return as<std::int16_t>(from);
      case SampleType::uint32:
        return as<std::uint32_t>(from);
      case SampleType::int32:
        return as<std::int32_t>(from);
      case SampleType::uint64:
        return as<std::uint64_t>(from);
      case SampleType::int64:
        return as<std::int64_t>(from);
      case SampleType::float32:
        return as<float>(from);
      default:
        return as<double>(from);
    }
  }
  template <class T>
  static double as(const char* from) {
    T value;
    std::memcpy(&value, from, sizeof value);
    return static_cast<double>(value);
  }

  const ImageView& image_;
};

// Least and largest value in the box around a place. Between the planes of samples a trilinear function has its
// extremes at corners.
std::array<double, 2> range_around(const Interpolation& values, const Vec3& place, double reach) {
  std::array<std::vector<double>, 3> stops;
  for (std::size_t a = 0; a < 3; ++a) {
    const double x = place[static_cast<int>(a)], low = x - reach, high = x + reach;
    stops[a] = {low, high};
    for (double plane = std::ceil(low); plane < high; ++plane) stops[a].push_back(plane);
  }
  std::array<double, 2> range{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (const double x : stops[0])
    for (const double y : stops[1])
      for (const double z : stops[2]) {
        const double value = values.at(Vec3(x, y, z));
        if (std::isnan(value))
          return {-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
        range = {std::min(range[0], value), std::max(range[1], value)};
      }
  return range;
}

}  // namespace

Check check_isosurface(const VoxelShape& shape, const VerifyOptions& options, Context* context) {
  const std::string name = "surface of the grey values";
  if (!options.image) return not_checked(name, "the grey values were not given");
  const Interpolation values(*options.image);
  const double threshold = values.is_whole() && options.threshold == std::floor(options.threshold)
                               ? options.threshold - 0.5
                               : options.threshold;
  const auto& points = options.surface->points;
  const std::vector<std::uint32_t> chosen = sample(points.size(), options.samples);
  std::atomic<std::size_t> compared{0}, near{0}, added{0};
  const auto is_within = [&](const Vec3& place, double reach) {
    const auto [least, largest] = range_around(values, place, reach);
    return least <= threshold && largest >= threshold;
  };
  const std::size_t bad = first_failure(chosen.size(), context, "verify: isosurface", [&](std::size_t i) {
    const Vec3 place = values.place(points[chosen[i]]);
    if (!values.has(place, kFarthestOff)) return true;  // at the border of the image, where it is closed
    if (values.is_beside_added(place, shape, threshold, options.inverted)) {
      added.fetch_add(1, std::memory_order_relaxed);
      return true;
    }
    compared.fetch_add(1, std::memory_order_relaxed);
    if (is_within(place, kOffIsosurface)) {
      near.fetch_add(1, std::memory_order_relaxed);
      return true;
    }
    return is_within(place, kFarthestOff);
  });
  if (bad != chosen.size()) {
    const Vec3& p = points[chosen[bad]];
    const auto [least, largest] = range_around(values, values.place(p), kFarthestOff);
    return failed(name, fmt::format("the surface is at ({:.9g}, {:.9g}, {:.9g}), where values within a voxel are "
                                    "{:.6g} to {:.6g}; it is that of {:.6g}",
                                    p[0], p[1], p[2], least, largest, threshold));
  }
  const std::string text = fmt::format(
      "{} of its {} points were looked at: {} are within half a voxel, along each axis, of the value {:.6g}, "
      "interpolated trilinearly, the others within a voxel{}",
      compared.load(), points.size(), near.load(), threshold,
      added == 0 ? "" : fmt::format("; {} more are beside voxels that were added", added.load()));
  if (static_cast<double>(near) < kLeastNear * static_cast<double>(compared)) return failed(name, text);
  return {name, true, text, {}};
}

}  // namespace quench::verification
