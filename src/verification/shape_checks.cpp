// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "quench/shape.h"
#include "verification/checks.h"
#include "verification/plane_boundary.h"
#include "verification/solid_of_surface.h"

namespace quench::verification {

namespace {

std::string describe(const Topology& t) {
  return fmt::format("euler {}, betti {} {} {}", t.euler, t.betti[0], t.betti[1], t.betti[2]);
}

// A graph has as many loops as edges beyond a tree.
Topology topology_of_graph(const CellComplex& complex) {
  Topology t;
  for (const std::uint32_t number : components(complex)) t.betti[0] = std::max(t.betti[0], std::int64_t{number} + 1);
  t.euler = std::int64_t{complex.vertex_count} - static_cast<std::int64_t>(complex.edges.size());
  t.betti[1] = t.betti[0] - t.euler;
  return t;
}

// True when all voxels (in a plane pixels) that touch x are foreground; x counts as on their boundary within 1e-9.
bool in_open_shape(const VoxelShape& shape, const Vec3& x) {
  std::int64_t low[3]{0, 0, 0}, high[3]{0, 0, 0};
  for (int a = 0; a < shape.grid().dimension; ++a) {
    if (!(std::abs(x[a]) < 1e9)) return false;
    const double rounded = std::round(x[a]);
    const bool on_plane = std::abs(x[a] - rounded) <= 1e-9;
    high[a] = static_cast<std::int64_t>(on_plane ? rounded : std::floor(x[a]));
    low[a] = on_plane ? high[a] - 1 : high[a];
  }
  for (std::int64_t z = low[2]; z <= high[2]; ++z)
    for (std::int64_t y = low[1]; y <= high[1]; ++y)
      for (std::int64_t i = low[0]; i <= high[0]; ++i)
        if (!shape.contains(i, y, z)) return false;
  return true;
}

// True when the segment is in the open shape: tested where it meets the lattice planes and once between each two.
bool segment_in_open_shape(const VoxelShape& shape, const Vec3& p, const Vec3& q, std::vector<double>& stops) {
  stops.assign({0, 1});
  const Vec3 d = q - p;
  for (int a = 0; a < shape.grid().dimension; ++a) {
    const double low = std::min(p[a], q[a]), high = std::max(p[a], q[a]);
    for (double plane = std::ceil(low); plane <= high; ++plane)
      if (std::abs(d[a]) > 1e-12) stops.push_back(std::clamp((plane - p[a]) / d[a], 0.0, 1.0));
  }
  std::sort(stops.begin(), stops.end());
  for (std::size_t i = 0; i < stops.size(); ++i) {
    if (!in_open_shape(shape, p + stops[i] * d)) return false;
    if (i > 0 && !in_open_shape(shape, p + 0.5 * (stops[i - 1] + stops[i]) * d)) return false;
  }
  return true;
}

}  // namespace

Check check_topology(const Result& result, const TriangleMesh* surface, const BoundaryCurves* boundary) {
  const Topology shape = boundary ? boundary->topology() : topology(result.shape),
                 complex = boundary ? topology_of_graph(result.complex) : topology(result.complex);
  Check check{"euler and Betti numbers", shape == complex, describe(shape), {}};
  if (result.main_axes) {  // one course per component, a loop where there is nothing else
    check.passed = complex.betti[0] == shape.betti[0] && complex.betti[1] <= shape.betti[1];
    check.detail = fmt::format("main axes only: {}", describe(complex));
  }
  if (!check.passed) check.detail = fmt::format("shape: {}; result: {}", describe(shape), describe(complex));
  // The field arrays of the file.
  const auto claims = [&](const char* array, const std::vector<std::int64_t>& counted) {
    const DataArray* found = find_array(result.data.field_data, array);
    if (!found || !check.passed || result.stage.empty()) return;
    const std::vector<double> written = found->numbers();
    if (std::equal(written.begin(), written.end(), counted.begin(), counted.end(),
                   [](double x, std::int64_t n) { return x == static_cast<double>(n); })) {
      cover(check, std::string("field ") + array);
      return;
    }
    check.passed = false;
    check.detail = fmt::format("the field array '{}' has {:g}; the cells have {}", array, fmt::join(written, " "),
                               fmt::join(counted, " "));
  };
  if (const auto solid = surface && check.passed ? solid_topology(*surface) : std::nullopt)
    check.detail += *solid == complex ? "; the solid of the surface has the same"
                                      : fmt::format("; the solid of the surface has {}", describe(*solid));
  claims("euler", {complex.euler});
  claims("betti", {complex.betti.begin(), complex.betti.end()});
  return check;
}

Check check_enclosure(const Result& result, Context* context) {
  Check check{"inside the shape", false, {}, {}};
  if (!result.has_voxel_geometry) return not_checked(check.name, kNotOfVoxels);
  const CellComplex& complex = result.complex;
  const auto& at = result.lattice;
  const std::size_t vertex = first_failure(at.size(), context, "verify: enclosure",
                                           [&](std::size_t v) { return in_open_shape(result.shape, at[v]); });
  if (vertex != at.size()) {
    check.detail = result.describe_vertex(static_cast<std::uint32_t>(vertex)) + " is not inside the shape";
    return check;
  }
  const std::size_t edge = first_failure(complex.edges.size(), context, "verify: enclosure", [&](std::size_t e) {
    thread_local std::vector<double> stops;
    return segment_in_open_shape(result.shape, at[complex.edges[e][0]], at[complex.edges[e][1]], stops);
  });
  if (edge != complex.edges.size()) {
    check.detail = result.describe_edge(static_cast<std::uint32_t>(edge)) + " leaves the shape";
    return check;
  }
  const std::size_t face = first_failure(complex.face_count(), context, "verify: enclosure", [&](std::size_t f) {
    thread_local std::vector<double> stops;
    const auto corners = complex.corners(f);
    Vec3 centre = Vec3::Zero();
    for (std::uint32_t v : corners) centre += at[v] / static_cast<double>(corners.size());
    return std::all_of(corners.begin(), corners.end(),
                       [&](std::uint32_t v) { return segment_in_open_shape(result.shape, at[v], centre, stops); });
  });
  if (face != complex.face_count()) {
    check.detail = result.describe_face(face) + " leaves the shape";
    return check;
  }
  check.passed = true;
  check.detail = fmt::format("{} vertices, {} edges", at.size(), complex.edges.size());
  if (!result.plane)
    check.detail += fmt::format(", {} polygons (along spokes from their centres)", complex.face_count());
  return check;
}

namespace {

constexpr std::size_t kShareSamples = 20000;  // of which the array `reconstructed` is the share

// The sampled voxel centres, scaled. The voxels, in the order of z, y, x, are divided into as many equal parts as there
// are samples; of part i the voxel is taken whose index in the part is the upper 48 bits of (i + 1) * 2^64 / golden
// ratio, modulo the size of the part.
std::vector<Vec3> centres_of_share(const Result& result) {
  struct Stretch {
    std::uint64_t end;  // voxels up to here
    std::int64_t y, z;
    const Run* run;
  };
  std::vector<Stretch> stretches;
  std::uint64_t voxels = 0;
  const auto& dims = result.shape.grid().dims;
  for (std::int64_t z = 0; z < dims[2]; ++z)
    for (std::int64_t y = 0; y < dims[1]; ++y)
      for (const Run& run : result.shape.row(y, z)) {
        voxels += static_cast<std::uint64_t>(run.end - run.begin);
        stretches.push_back({voxels, y, z, &run});
      }
  const std::uint64_t count = std::min<std::uint64_t>(kShareSamples, voxels);
  const auto part = [&](std::uint64_t i) {
    return static_cast<std::uint64_t>(static_cast<double>(i) * static_cast<double>(voxels) /
                                      static_cast<double>(count));
  };
  std::vector<Vec3> centres;
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::uint64_t begin = part(i), size = std::max<std::uint64_t>(part(i + 1) - begin, 1);
    const std::uint64_t index = begin + (((i + 1) * 0x9E3779B97F4A7C15ull) >> 16) % size;
    const auto in = std::upper_bound(stretches.begin(), stretches.end(), index,
                                     [](std::uint64_t at, const Stretch& s) { return at < s.end; });
    const double x = static_cast<double>(in->run->end) - static_cast<double>(in->end - index);
    centres.push_back(
        (Vec3(x, static_cast<double>(in->y), static_cast<double>(in->z)) + Vec3(0.5, 0.5, result.plane ? 0 : 0.5))
            .cwiseProduct(Vec3(static_cast<double>(result.scale[0]), static_cast<double>(result.scale[1]),
                               static_cast<double>(result.scale[2]))));
  }
  return centres;
}

}  // namespace

Check check_reconstruction(const Result& result, Context* context) {
  const std::string name = "reconstructed";
  if (result.ball_radius.empty()) return not_checked(name, "no array 'radius'");
  // A centre on the sphere of a ball counts: the radius is taken 1e-9 larger. A centre that is closer to that than the
  // rounding error may count or not.
  const auto unsure = [&](double r) { return r * (1e-10 + 2 * result.slack) + 4 * result.rounding; };
  const auto reach = [&](std::size_t v) { return result.ball_radius[v] / result.unit * (1 + 1e-9); };
  std::vector<Box> balls;
  for (std::uint32_t v = 0; v < result.rows.size(); ++v) {
    const double r = result.ball_radius[v] > 0 ? std::min(reach(v) + unsure(reach(v)), 0x1p22) : 0;
    const Vec3 centre = result.scaled_point(v);
    Box box{};
    for (int a = 0; a < 3; ++a) {
      box.low[static_cast<std::size_t>(a)] = bounded(std::floor(centre[a] - r));
      box.high[static_cast<std::size_t>(a)] = bounded(std::ceil(centre[a] + r));
    }
    balls.push_back(box);
  }
  const Bvh tree(std::move(balls));
  const std::vector<Vec3> centres = centres_of_share(result);
  std::atomic<std::size_t> surely{0}, perhaps{0};
  for_indices(centres.size(), context, "verify: reconstruction", [&](std::size_t i) {
    bool touched = false;
    const bool outside = tree.visit_within(centres[i], 0, [&](std::uint32_t v, const Box&) {
      const double r = reach(v), distance = (centres[i] - result.scaled_point(v)).norm();
      touched = touched || distance <= r + unsure(r);
      return distance > r - unsure(r);
    });
    if (!outside) surely.fetch_add(1, std::memory_order_relaxed);
    if (!outside || touched) perhaps.fetch_add(1, std::memory_order_relaxed);
  });
  const double count = static_cast<double>(std::max<std::size_t>(centres.size(), 1));
  const auto share = [&](std::size_t covered) { return static_cast<double>(covered) / count; };
  Check check{name,
              true,
              fmt::format("{:.4f} of {} sampled {} centres are inside the {}", share(surely), centres.size(),
                          pixel_or_voxel(result), result.plane ? "disks" : "balls"),
              {}};
  // A part of the axis beyond a bridge of cells below lambda may be missing, and nothing else would show it.
  const std::vector<double> claimed = numbers_or_empty(result.data.field_data, "reconstructed");
  if (claimed.size() != 1 || (result.stage != "core" && result.stage != "skeleton")) return check;
  const double covered = std::round(claimed[0] * count);
  cover(check, "field reconstructed");
  check.passed = std::abs(claimed[0] * count - covered) <= 1e-6 && covered >= static_cast<double>(surely) &&
                 covered <= static_cast<double>(perhaps);
  if (!check.passed) check.detail += fmt::format(", the result claims {:.9g}", claimed[0]);
  return check;
}

}  // namespace quench::verification
