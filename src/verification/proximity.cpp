// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "verification/checks.h"

namespace quench::verification {

namespace {

// The boundary of the shape, its voxel faces or pixel edges, as flat boxes in scaled coordinates.
std::vector<Box> boundary_faces(const VoxelShape& shape, const std::array<std::int64_t, 3>& scale) {
  std::vector<Box> faces;
  const bool plane = shape.grid().is_plane();
  const auto add = [&](std::int64_t x, std::int64_t y, std::int64_t z, std::size_t normal) {
    Box box;
    const std::array<std::int64_t, 3> corner{x, y, z};
    for (std::size_t a = 0; a < 3; ++a) {
      box.low[a] = static_cast<std::int32_t>(corner[a] * scale[a]);
      box.high[a] = static_cast<std::int32_t>((corner[a] + (a != normal && !(plane && a == 2))) * scale[a]);
    }
    faces.push_back(box);
  };
  // Voxels of one scanline that another does not have, both sorted.
  const auto uncovered = [](std::span<const Run> runs, std::span<const Run> other, const auto& visit) {
    std::size_t o = 0;
    for (const Run& run : runs)
      for (std::int32_t x = run.begin; x < run.end; ++x) {
        while (o < other.size() && other[o].end <= x) ++o;
        if (o < other.size() && other[o].begin <= x)
          x = std::min(other[o].end, run.end) - 1;
        else
          visit(x);
      }
  };
  const auto& dims = shape.grid().dims;
  for (std::int64_t z = 0; z < dims[2]; ++z)
    for (std::int64_t y = 0; y < dims[1]; ++y) {
      for (const Run& run : shape.row(y, z)) {
        add(run.begin, y, z, 0);
        add(run.end, y, z, 0);
      }
      uncovered(shape.row(y, z), shape.row(y - 1, z), [&](std::int32_t x) { add(x, y, z, 1); });
      uncovered(shape.row(y, z), shape.row(y + 1, z), [&](std::int32_t x) { add(x, y + 1, z, 1); });
      if (plane) continue;
      uncovered(shape.row(y, z), shape.row(y, z - 1), [&](std::int32_t x) { add(x, y, z, 2); });
      uncovered(shape.row(y, z), shape.row(y, z + 1), [&](std::int32_t x) { add(x, y, z + 1, 2); });
    }
  return faces;
}

// Tolerances: 1e-9 of distances, 1e-6 of positions, and the effect of `rounding`.
double at_most(double distance, double rounding) {
  const double reach = distance * (1 + 1e-9) + 4 * rounding;
  return reach * reach;
}
double apart(double rounding) { return 1e-6 + 4 * rounding; }

// The points of the boundary nearest to x.
std::vector<Vec3> nearest_points(const Bvh& faces, const Vec3& x, double distance, double rounding) {
  std::vector<Vec3> points;
  faces.visit_within(x, at_most(distance, rounding), [&](std::uint32_t, const Box& box) {
    const Vec3 p = box.nearest_point(x);
    if (std::none_of(points.begin(), points.end(), [&](const Vec3& q) { return (p - q).norm() < apart(rounding); }))
      points.push_back(p);
    return points.size() < 2;
  });
  return points;
}

enum class Outcome { holds, not_on_a_face, fails };

Outcome test(const Bvh& faces, const Vec3& x, double beta, double rounding) {
  const double distance = std::sqrt(faces.nearest_squared(x));
  const std::vector<Vec3> points = nearest_points(faces, x, distance, rounding);
  if (points.size() != 1) return Outcome::holds;
  const Vec3 direction = (x - points[0]) / distance;
  if (direction.cwiseAbs().maxCoeff() < 1 - 1e-12) return Outcome::not_on_a_face;  // nearest point on an edge
  // Any other boundary point at most as far as p from the moved point.
  const Vec3 moved = x + beta * direction;
  const bool only_p = faces.visit_within(moved, at_most(distance + beta, rounding), [&](std::uint32_t, const Box& box) {
    return (box.nearest_point(moved) - points[0]).norm() < apart(rounding);
  });
  return only_p ? Outcome::fails : Outcome::holds;
}

}  // namespace

Check check_proximity(const Result& result, std::size_t samples, Context* context) {
  Check check{"proximity bound", false, {}, {}};
  if (!result.has_voxel_geometry) return not_checked(check.name, kNotOfVoxels);
  std::array<std::int64_t, 3> h = result.scale;
  std::sort(h.begin(), h.end());
  // The sides of what bounds O, squared: of an edge of a pixel one, of a face of a voxel two.
  const std::int64_t sides = h[2] * h[2] + (result.plane ? 0 : h[1] * h[1]);
  const double beta = static_cast<double>(sides) / (8 * static_cast<double>(h[0]));

  const CellComplex& complex = result.complex;
  const std::size_t share = std::max<std::size_t>(1, samples / 3);
  std::vector<Vec3> points;
  const std::vector<char> smoothed = smoothed_vertices(result);  // these may be off the axis
  for (std::uint32_t v : sample(result.rows.size(), share))
    if (!smoothed[v]) points.push_back(result.scaled[v]);
  for (std::uint32_t e : sample(complex.edges.size(), share))
    if (!smoothed[complex.edges[e][0]] && !smoothed[complex.edges[e][1]])
      points.push_back((result.scaled[complex.edges[e][0]] + result.scaled[complex.edges[e][1]]) / 2);
  for (std::uint32_t f : sample(complex.face_count(), share)) {
    const auto corners = complex.corners(f);
    if (std::none_of(corners.begin(), corners.end(), [&](std::uint32_t v) { return smoothed[v]; }))
      points.push_back(result.centroid(f));
  }

  const Bvh faces(boundary_faces(result.shape, result.scale));
  std::atomic<std::size_t> skipped{0};
  const std::size_t bad = first_failure(points.size(), context, "verify: proximity", [&](std::size_t i) {
    const Outcome outcome = test(faces, points[i], beta, result.rounding);
    if (outcome == Outcome::not_on_a_face) skipped.fetch_add(1, std::memory_order_relaxed);
    return outcome != Outcome::fails;
  });
  check.passed = bad == points.size();
  if (check.passed) {
    check.detail =
        fmt::format("beta {:.6g}: holds at {} points; {} more are nearest to {} of the boundary", beta * result.unit,
                    points.size() - skipped, skipped.load(), result.plane ? "a corner" : "an edge");
  } else {
    const Vec3 world = result.shape.grid().world(
        points[bad].cwiseQuotient(Vec3(static_cast<double>(result.scale[0]), static_cast<double>(result.scale[1]),
                                       static_cast<double>(result.scale[2]))));
    check.detail = fmt::format("({:.9g}) is farther than beta {:.6g} from the medial axis of the shape",
                               fmt::join(std::span(world.data(), result.plane ? 2 : 3), ", "), beta * result.unit);
  }
  return check;
}

}  // namespace quench::verification
