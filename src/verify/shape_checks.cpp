// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "quench/topology.h"
#include "verify/checks.h"

namespace quench::verification {

namespace {

std::string describe(const Topology& t) {
  return fmt::format("euler {}, betti {} {} {}", t.euler, t.betti[0], t.betti[1], t.betti[2]);
}

// True when all voxels that touch x are foreground; x counts as on a voxel face within 1e-9.
bool in_open_shape(const VoxelShape& shape, const Vec3& x) {
  std::int64_t low[3], high[3];
  for (int a = 0; a < 3; ++a) {
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
  for (int a = 0; a < 3; ++a) {
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

Check check_topology(const Result& result) {
  const Topology shape = topology(result.shape), complex = topology(result.complex);
  Check check{"euler and Betti numbers", shape == complex, describe(shape)};
  if (!check.passed) check.detail = fmt::format("shape: {}; result: {}", describe(shape), describe(complex));
  return check;
}

Check check_enclosure(const Result& result, Context* context) {
  Check check{"inside the shape", false, {}};
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
  check.detail = fmt::format("{} vertices, {} edges, {} polygons (along spokes from their centres)", at.size(),
                             complex.edges.size(), complex.face_count());
  return check;
}

Check check_reconstruction(const Result& result, std::size_t samples, Context* context) {
  const std::string name = "reconstructed";
  if (result.radius.empty()) return not_checked(name, "no array 'radius'");
  std::vector<Box> balls;
  for (std::size_t v = 0; v < result.scaled.size(); ++v) {
    const double r = result.radius[v] > 0 ? std::min(result.radius[v] / result.unit, 0x1p22) : 0;
    Box box{};
    for (int a = 0; a < 3; ++a) {
      box.low[static_cast<std::size_t>(a)] = bounded(std::floor(result.scaled[v][a] - r));
      box.high[static_cast<std::size_t>(a)] = bounded(std::ceil(result.scaled[v][a] + r));
    }
    balls.push_back(box);
  }
  const BoxTree tree(std::move(balls));

  // Every n-th voxel of the shape, counted along its runs.
  const std::int64_t voxels = result.shape.voxel_count();
  const std::int64_t step =
      std::max<std::int64_t>(1, voxels / static_cast<std::int64_t>(std::max<std::size_t>(samples, 1)));
  std::vector<Vec3> centres;
  std::int64_t until_next = 0;
  const auto& dims = result.shape.grid().dims;
  for (std::int64_t z = 0; z < dims[2]; ++z)
    for (std::int64_t y = 0; y < dims[1]; ++y)
      for (const Run& run : result.shape.row(y, z)) {
        std::int64_t x = run.begin + until_next;
        for (; x < run.end; x += step)
          centres.push_back(Vec3((static_cast<double>(x) + 0.5) * static_cast<double>(result.scale[0]),
                                 (static_cast<double>(y) + 0.5) * static_cast<double>(result.scale[1]),
                                 (static_cast<double>(z) + 0.5) * static_cast<double>(result.scale[2])));
        until_next = x - run.end;
      }
  std::atomic<std::size_t> covered{0};
  first_failure(centres.size(), context, "verify: reconstruction", [&](std::size_t i) {
    const bool outside = tree.visit_within(centres[i], 0, [&](std::uint32_t v, const Box&) {
      const double r = result.radius[v] / result.unit * (1 + 1e-9);
      return (centres[i] - result.scaled[v]).squaredNorm() > r * r;
    });
    if (!outside) covered.fetch_add(1, std::memory_order_relaxed);
    return true;
  });
  const double share = centres.empty() ? 0 : static_cast<double>(covered) / static_cast<double>(centres.size());
  Check check{name, true,
              fmt::format("{:.4f} of {} sampled voxel centres are inside the balls", share, centres.size())};
  // A part that hangs on a bridge of cells below lambda can be missing without any other trace. Both shares are of
  // samples: 1% is five standard deviations of 10,000 at 0.95.
  const DataArray* claimed = find_array(result.data.field_data, "reconstructed");
  if (claimed && !claimed->numbers().empty() && !(share >= claimed->numbers()[0] - 0.01)) {
    check.passed = false;
    check.detail += fmt::format(", the result claims {:.4f}: parts of it are missing", claimed->numbers()[0]);
  }
  return check;
}

}  // namespace quench::verification
