// SPDX-License-Identifier: Apache-2.0
// What holds of points and radii that are fitted to a surface.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "verification/checks.h"

namespace quench::verification {

namespace {

constexpr double kMostMoved = 1.5;       // in units of the longest side of a voxel
constexpr double kOfLongestSide = 1e-9;  // what a ball may be off
constexpr double kInterpolated = 1;      // in voxel diagonals: what a radius between vertices of the axis may be off

double rounding_of_points(const Result& result) { return 4 * result.rounding * result.unit; }

}  // namespace

Check check_moves(const Result& result) {
  const std::string name = "moved points";
  if (!result.has_voxel_geometry) return not_checked(name, kNotOfVoxels);
  const double most = kMostMoved * result.shape.grid().spacing.maxCoeff();
  double largest = 0;
  std::size_t moved = 0;
  for (std::uint32_t v = 0; v < result.rows.size(); ++v) {
    const double way = (result.point(v) - result.voxel_point(v)).norm();
    if (!(way <= most * (1 + kSingle) + rounding_of_points(result)))
      return failed(name, fmt::format("{} is {:.9g} from its place in the voxel core, more than {:.9g}",
                                      result.describe_vertex(v), way, most));
    largest = std::max(largest, way);
    moved += way > 0;
  }
  return {name,
          true,
          fmt::format("{} of {} points, by {:.3g} at most (1.5 voxels: {:.3g}); cells are those of the voxel core",
                      moved, result.rows.size(), largest, most),
          {}};
}

Check check_sides(const Result& result, const TriangleSearch& surface, const VerifyOptions& options, Context* context) {
  const std::string name = "surface of the shape";
  if (options.surface_kind != result.surface)
    return failed(name, fmt::format("the file refers to the surface '{}', the one of the shape is '{}'", result.surface,
                                    options.surface_kind));
  struct Centre {
    Vec3 at;
    bool inside;
  };
  std::vector<Centre> centres;
  const auto& grid = result.shape.grid();
  const double parts = options.subdivided;  // voxels that were split lie on the side of the whole one
  const auto centre_of = [&](double voxel) { return (std::floor(voxel / parts) + 0.5) * parts; };
  std::size_t runs = 0;
  const auto for_runs = [&](const auto& visit) {
    for (std::int64_t z = 0; z < grid.dims[2]; ++z)
      for (std::int64_t y = 0; y < grid.dims[1]; ++y)
        for (const Run& run : result.shape.row(y, z)) visit(run, static_cast<double>(y), static_cast<double>(z));
  };
  for_runs([&](const Run&, double, double) { ++runs; });
  const std::vector<std::uint32_t> chosen = sample(runs, options.samples / 4);
  std::size_t at = 0, next = 0;
  for_runs([&](const Run& run, double y, double z) {  // both ends, inside and outside
    if (next >= chosen.size() || at++ != chosen[next]) return;
    ++next;
    for (const auto& [x, inside] : {std::pair{run.begin - 1, false}, std::pair{run.begin, true},
                                    std::pair{run.end - 1, true}, std::pair{run.end, false}})
      centres.push_back({grid.world(Vec3(centre_of(x), centre_of(y), centre_of(z))), inside});
  });
  const double near = result.auto_detail * parts * (1 + 1e-9);
  std::atomic<std::size_t> agree{0};
  const std::size_t bad = first_failure(centres.size(), context, "verify: surface", [&](std::size_t i) {
    const bool on_its_side = surface.inside(centres[i].at) == centres[i].inside;
    if (on_its_side) agree.fetch_add(1, std::memory_order_relaxed);
    return on_its_side || surface.distance(centres[i].at) <= near;
  });
  if (bad != centres.size()) {
    const auto& [p, inside] = centres[bad];
    return failed(name,
                  fmt::format("the voxel centre ({:.9g}, {:.9g}, {:.9g}) is {} the shape, and on the other side "
                              "of the surface ({}), {:.9g} away from it",
                              p[0], p[1], p[2], inside ? "in" : "outside of", result.surface, surface.distance(p)));
  }
  Check check{name,
              true,
              fmt::format("{} of {} voxel centres at the boundary are on their side of the surface ({}, {} triangles), "
                          "the others within half a voxel diagonal",
                          agree.load(), centres.size(), result.surface, surface.size()),
              {}};
  cover(check, "field surface");
  return check;
}

Check check_balls(const Result& result, const TriangleSearch& surface, const VerifyOptions& options, Context* context) {
  const std::string name = "balls of the surface";
  if (result.ball_radius.empty()) return not_checked(name, "no array 'radius'");
  const bool interpolated = !result.has_voxel_geometry;  // a skeleton
  const double diagonal = 2 * result.auto_detail * options.subdivided,
               near = kOfLongestSide * surface.longest_side() + rounding_of_points(result),
               off = interpolated ? kInterpolated * diagonal : near;
  std::atomic<std::size_t> outside{0}, exact{0};
  double farthest = 0;
  const auto is_ball = [&](std::size_t v) {
    const Vec3& p = result.point(static_cast<std::uint32_t>(v));
    const double r = result.ball_radius[v], away = surface.distance(p);
    if (std::abs(r - away) <= near) exact.fetch_add(1, std::memory_order_relaxed);
    if (away <= near || surface.inside(p)) {
      if (interpolated) base::raise(farthest, std::abs(r - away));
      return r >= 0 && std::abs(r - away) <= off;
    }
    outside.fetch_add(1, std::memory_order_relaxed);
    return r >= 0 && r <= (interpolated ? off : 0) && away <= diagonal;
  };
  const std::size_t bad = first_failure(result.rows.size(), context, "verify: balls", is_ball);
  if (bad != result.rows.size()) {
    const auto v = static_cast<std::uint32_t>(bad);
    return failed(name, fmt::format("{} with radius {:.9g} is {} the surface ({}), {:.9g} away from it",
                                    result.describe_vertex(v), result.ball_radius[v],
                                    surface.inside(result.point(v)) ? "inside" : "outside of", result.surface,
                                    surface.distance(result.point(v))));
  }
  std::string text =
      fmt::format("{} of {} lie inside the surface and touch it, to {:.2g}", exact.load(), result.rows.size(), near);
  if (interpolated)
    text += fmt::format("; the others, between vertices of the axis, to {:.3g} ({:.3g} is allowed)", farthest, off);
  if (outside > 0) text += fmt::format("; {} points lie outside, with radius 0", outside.load());
  Check check{name, true, std::move(text), {}};
  if (!interpolated) cover(check, "point radius");
  return check;
}

}  // namespace quench::verification
