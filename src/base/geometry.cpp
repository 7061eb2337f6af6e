// SPDX-License-Identifier: Apache-2.0
#include "quench/geometry.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "base/grid_text.h"
#include "quench/error.h"

namespace quench {

namespace {

constexpr double rounding = 1e-6;  // relative: what integer_spacing() takes for equal

/// How far integers in proportion m to the smallest step are from the spacing.
struct Proportion {
  std::array<std::int64_t, 3> multiples{};
  Vec3 error;  ///< relative, per axis
};

/// Calls `visit` with the nearest integers for m = 1, 2, ... as long as they fit the grid and it returns true.
template <class Visit>
void each_proportion(const Grid& grid, const Visit& visit) {
  constexpr std::int64_t limit = std::int64_t{1} << 20;
  const Vec3& s = grid.spacing;
  const double smallest = s.minCoeff();
  for (std::int64_t m = 1; m <= limit; ++m) {
    Proportion p;
    for (int a = 0; a < 3; ++a) {
      const double wanted = s[a] / smallest * static_cast<double>(m);
      if (wanted * static_cast<double>(std::max<std::int64_t>(grid.dims[a], 1)) > static_cast<double>(limit) + 0.5)
        return;
      p.multiples[a] = std::llround(wanted);
      p.error[a] = std::abs(wanted - static_cast<double>(p.multiples[a])) / wanted;
    }
    if (!visit(p)) return;
  }
}

/// The smallest integers in proportion to the spacing, up to a relative tolerance per axis.
std::optional<std::array<std::int64_t, 3>> proportion_of(const Grid& grid, const Vec3& tolerance) {
  std::optional<std::array<std::int64_t, 3>> result;
  each_proportion(grid, [&](const Proportion& p) {
    if ((p.error.array() <= tolerance.array()).all()) result = p.multiples;
    return !result;
  });
  return result;
}

/// The integers that move the farthest voxel least, up to `most` voxels.
std::optional<std::array<std::int64_t, 3>> nearest_proportion(const Grid& grid, const Vec3& sides, double most) {
  std::optional<std::array<std::int64_t, 3>> result;
  each_proportion(grid, [&](const Proportion& p) {
    if (const double moved = p.error.cwiseProduct(sides).maxCoeff(); moved < most) {
      most = moved;
      result = p.multiples;
    }
    return true;
  });
  return result;
}

}  // namespace

Vec3 nearest_integer_spacing(const Grid& grid, double* moved) {
  const Vec3& s = grid.spacing;
  if (moved) *moved = 0;
  if (!s.allFinite() || !(s.minCoeff() > 0) || proportion_of(grid, Vec3::Constant(rounding))) return s;
  // The noise of single precision goes first: small integers tell what was meant.
  constexpr double noise = 1e-5, over_the_grid = 1e-4, most = 0.05;
  Vec3 sides, tolerance;
  for (int a = 0; a < 3; ++a) {
    sides[a] = static_cast<double>(std::max<std::int64_t>(grid.dims[static_cast<std::size_t>(a)], 1));
    tolerance[a] = std::max(noise, over_the_grid / sides[a]);
  }
  auto proportion = proportion_of(grid, tolerance);
  if (!proportion) proportion = nearest_proportion(grid, sides, most);
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
    throw Error(ErrorCode::input, fmt::format("the spacing {} is not positive; give another", base::axes_text(grid, s)),
                "spacing");
  // Squares of lengths are needed in double precision, and lambda is kept in single precision.
  constexpr double shortest = 1e-30, longest = 1e30;
  if (smallest < shortest || s.maxCoeff() > longest)
    throw Error(
        ErrorCode::input,
        fmt::format("{}s of {} are beyond what can be computed with, {:g} to {:g}; scale the {}, or give the {} "
                    "another spacing",
                    base::cell_name(grid), base::axes_text(grid, s), shortest, longest,
                    grid.is_plane() ? "polygons" : "mesh", grid.is_plane() ? "image" : "volume"),
        "spacing");
  // Positions of vertices are doubles: beyond this, neighbours would fall together.
  constexpr double farthest = 1e12;
  if (const double distance = grid.origin.norm(); !(distance <= farthest * smallest))
    throw Error(
        ErrorCode::input,
        fmt::format("the shape lies {:g} from the origin of its coordinates, more than 10^12 of its {}s of {:g}, "
                    "which is too far for exact results; move it nearer",
                    distance, base::cell_name(grid), smallest));
  if (const auto proportion = proportion_of(grid, Vec3::Constant(rounding))) return *proportion;
  throw Error(
      ErrorCode::input,
      fmt::format("the spacing {} with {} {}s is not in a proportion of whole numbers, up to a twentieth of a {} over "
                  "the grid; give one that is, such as {}",
                  base::axes_text(grid, s), base::axes_text(grid, grid.dims), base::cell_name(grid),
                  base::cell_name(grid), grid.is_plane() ? "1 x 2" : "1 x 1 x 2"),
      "spacing");
}

}  // namespace quench
