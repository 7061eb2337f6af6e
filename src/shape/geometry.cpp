// SPDX-License-Identifier: Apache-2.0
#include "quench/geometry.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "quench/error.h"

namespace quench {

namespace {

constexpr double rounding = 1e-6;  // relative: what integer_spacing() takes for equal

/// The smallest integers proportional to the spacing, up to a relative tolerance per axis, that fit the grid.
std::optional<std::array<std::int64_t, 3>> proportion_of(const Grid& grid, const Vec3& tolerance) {
  constexpr std::int64_t limit = std::int64_t{1} << 20;
  const Vec3& s = grid.spacing;
  const double smallest = s.minCoeff();
  for (std::int64_t m = 1; m <= limit; ++m) {
    std::array<std::int64_t, 3> multiple{};
    bool matches = true;
    for (int a = 0; a < 3; ++a) {
      const double wanted = s[a] / smallest * static_cast<double>(m);
      if (wanted * static_cast<double>(std::max<std::int64_t>(grid.dims[a], 1)) > static_cast<double>(limit) + 0.5)
        return {};
      multiple[a] = std::llround(wanted);
      if (std::abs(wanted - static_cast<double>(multiple[a])) > tolerance[a] * wanted) matches = false;
    }
    if (matches) return multiple;
  }
  return {};
}

}  // namespace

Vec3 nearest_integer_spacing(const Grid& grid, double* moved) {
  const Vec3& s = grid.spacing;
  if (moved) *moved = 0;
  if (!s.allFinite() || !(s.minCoeff() > 0) || proportion_of(grid, Vec3::Constant(rounding))) return s;
  constexpr double noise = 1e-5, over_the_grid = 1e-4;
  Vec3 sides, tolerance;
  for (int a = 0; a < 3; ++a) {
    sides[a] = static_cast<double>(std::max<std::int64_t>(grid.dims[static_cast<std::size_t>(a)], 1));
    tolerance[a] = std::max(noise, over_the_grid / sides[a]);
  }
  const auto proportion = proportion_of(grid, tolerance);
  if (!proportion) return s;
  const Vec3 multiples = Vec3((*proportion)[0], (*proportion)[1], (*proportion)[2]);
  const Vec3 unit = s.cwiseQuotient(multiples);
  const Vec3 nearest = multiples * (unit.minCoeff() / 2 + unit.maxCoeff() / 2);
  if (moved) *moved = ((nearest - s).cwiseAbs().cwiseQuotient(s)).cwiseProduct(sides).maxCoeff();
  return nearest;
}

std::array<std::int64_t, 3> integer_spacing(const Grid& grid) {
  const Vec3& s = grid.spacing;
  const double smallest = s.minCoeff();
  if (!(smallest > 0) || !std::isfinite(s.maxCoeff()))
    throw Error(ErrorCode::input,
                fmt::format("the spacing {} x {} x {} is not positive; give another", s[0], s[1], s[2]));
  // Squares of lengths are needed in double precision, and lambda is kept in single precision.
  constexpr double shortest = 1e-30, longest = 1e30;
  if (smallest < shortest || s.maxCoeff() > longest)
    throw Error(
        ErrorCode::input,
        fmt::format("voxels of {} x {} x {} are beyond what can be computed with, {:g} to {:g}; scale the mesh, "
                    "or give the volume another spacing",
                    s[0], s[1], s[2], shortest, longest));
  // Positions of vertices are doubles: beyond this, neighbours would fall together.
  constexpr double farthest = 1e12;
  if (const double distance = grid.origin.norm(); !(distance <= farthest * smallest))
    throw Error(ErrorCode::input,
                fmt::format("the shape lies {:g} from the origin of its coordinates, where double precision does not "
                            "tell voxels of {:g} apart; move it nearer",
                            distance, smallest));
  if (const auto proportion = proportion_of(grid, Vec3::Constant(rounding))) return *proportion;
  throw Error(
      ErrorCode::input,
      fmt::format("the spacing {} x {} x {} with {} x {} x {} voxels has no integer proportion within 2^20; give a "
                  "rounder one",
                  s[0], s[1], s[2], grid.dims[0], grid.dims[1], grid.dims[2]));
}

double Length::resolve(double longest_side, double smallest_spacing) const {
  switch (unit) {
    case Unit::fraction:
      return value * longest_side;
    case Unit::voxels:
      return value * smallest_spacing;
    case Unit::absolute:
      return value;
  }
  return value;
}

Length parse_length(std::string_view text, std::string_view what) {
  const auto refuse = [&]() -> Length {
    throw Error(
        ErrorCode::usage,
        fmt::format("{} '{}' is not a length; give a fraction (0.02 or 2%), voxels (12vox) or world units (3.5abs)",
                    what, text));
  };
  if (text == "inf") return {std::numeric_limits<double>::infinity(), Length::Unit::absolute};
  if (text.size() > 1 && text[0] == '-' && ((text[1] >= '0' && text[1] <= '9') || text[1] == '.'))
    throw Error(ErrorCode::usage, fmt::format("{} '{}' is negative; a length is 0 or more", what, text));
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || !(value >= 0) || !std::isfinite(value)) return refuse();
  const std::string_view unit(end, static_cast<std::size_t>(text.data() + text.size() - end));
  if (unit.empty()) return {value, Length::Unit::fraction};
  if (unit == "%") return {value / 100, Length::Unit::fraction};
  if (unit == "vox") return {value, Length::Unit::voxels};
  if (unit == "abs") return {value, Length::Unit::absolute};
  return refuse();
}

}  // namespace quench
