// SPDX-License-Identifier: Apache-2.0
#include "quench/voxelize.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "quench/error.h"
#include "quench/topology.h"
#include "shape/scan_conversion.h"
#include "shape/surface_analysis.h"

namespace quench {
namespace {

constexpr std::int64_t largest_resolution = 16384;  // the bounds of scan_conversion.cpp rest on it
constexpr std::int64_t largest_margin = 16384;

void check(const VoxelizeOptions& options) {
  if (options.resolution < 1 || options.resolution > largest_resolution)
    throw Error(ErrorCode::usage, fmt::format("the resolution {} is not possible; give --resolution from 1 to {}",
                                              options.resolution, largest_resolution));
  if (options.margin < 0 || options.margin > largest_margin)
    throw Error(ErrorCode::usage,
                fmt::format("the margin {} is not possible; it takes 0 to {} voxels", options.margin, largest_margin));
}

std::string text(const Vec3& p) { return fmt::format("({:.6g}, {:.6g}, {:.6g})", p[0], p[1], p[2]); }

struct Box {
  Vec3 low, high;
  double longest_side = 0;
};

/// Box of the points that triangles use.
Box bounding_box(const TriangleMesh& mesh) {
  if (mesh.triangles.empty())
    throw Error(ErrorCode::input, "the mesh has no triangles; a closed surface is needed to make voxels of");
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const std::uint32_t p : mesh.triangles[t])
      if (p >= mesh.points.size()) detail::refuse_corner(mesh, t, p);
  Box box{mesh.points[mesh.triangles[0][0]], mesh.points[mesh.triangles[0][0]]};
  for (const auto& triangle : mesh.triangles)
    for (const std::uint32_t p : triangle) {
      if (!mesh.points[p].allFinite())
        throw Error(
            ErrorCode::input,
            fmt::format("point {} of the mesh has a coordinate that is not a finite number; repair the mesh", p));
      box.low = box.low.cwiseMin(mesh.points[p]);
      box.high = box.high.cwiseMax(mesh.points[p]);
    }
  const Vec3 sides = box.high - box.low;
  box.longest_side = sides.maxCoeff();
  if (!std::isfinite(box.longest_side) || box.longest_side > 1e300)
    throw Error(ErrorCode::input, "the mesh is too large for double precision; scale it down");
  for (int a = 0; a < 3; ++a)
    if (!(sides[a] > 0) || box.longest_side < 1e-300)
      throw Error(ErrorCode::input,
                  fmt::format("the mesh is flat: its bounding box is {:.6g} x {:.6g} x {:.6g}, which encloses nothing",
                              sides[0], sides[1], sides[2]));
  return box;
}

/// A mesh that passed all checks which do not depend on the resolution.
struct ClosedMesh {
  const TriangleMesh& mesh;
  SurfaceTopology surface;
  Box box;
};

ClosedMesh closed_mesh(const TriangleMesh& mesh) {
  const Box box = bounding_box(mesh);
  const detail::SurfaceAnalysis analysis = detail::analyze_surface(mesh);
  if (analysis.boundary_edges > 0)
    throw Error(ErrorCode::input,
                fmt::format("the mesh is not closed: {} of its edges {} one face only, for example that from {} to {}; "
                            "close its holes first",
                            analysis.boundary_edges, analysis.boundary_edges == 1 ? "has" : "have",
                            text(mesh.points[analysis.one_boundary_edge[0]]),
                            text(mesh.points[analysis.one_boundary_edge[1]])));
  return {mesh, analysis.topology, box};
}

detail::FixedMesh fixed_mesh(const ClosedMesh& closed, std::int64_t resolution) {
  detail::FixedMesh fixed;
  const Box& box = closed.box;
  const double scale = std::ldexp(static_cast<double>(resolution), detail::fraction_bits);
  const auto fix = [&](const Vec3& p) {
    detail::FixedPoint q{};
    for (int a = 0; a < 3; ++a)
      q[static_cast<std::size_t>(a)] = std::llround((p[a] - box.low[a]) / box.longest_side * scale);
    return q;
  };
  fixed.triangles = closed.mesh.triangles;
  fixed.points.resize(closed.mesh.points.size());  // points no triangle uses stay 0: they may be anywhere
  for (const auto& triangle : closed.mesh.triangles)
    for (const std::uint32_t p : triangle) fixed.points[p] = fix(closed.mesh.points[p]);
  const detail::FixedPoint extent = fix(box.high);
  for (std::size_t a = 0; a < 3; ++a)
    fixed.cells[a] = std::max<std::int64_t>(
        1, (extent[a] + (std::int64_t{1} << detail::fraction_bits) - 1) >> detail::fraction_bits);
  return fixed;
}

std::string counted(std::int64_t n, const char* one, const char* many) {
  return fmt::format("{} {}", n, n == 1 ? one : many);
}

/// A sentence when the solid of the mesh has another topology than the shape, else empty.
std::string difference(const VoxelShape& shape, const SurfaceTopology& surface) {
  const Topology voxels = topology(shape);
  const std::int64_t genus = surface.components - surface.euler;
  if (!surface.manifold) {
    if (voxels.euler == surface.euler) return {};
    return fmt::format(
        "the voxel shape has Euler characteristic {}, the solid of the mesh {}; the mesh is not a 2-manifold, so parts "
        "may touch; a higher --resolution may help",
        voxels.euler, surface.euler);
  }
  if (voxels.euler == surface.euler && voxels.betti[0] + voxels.betti[2] == surface.components &&
      voxels.betti[1] == genus)
    return {};
  const std::string parts = surface.components == 1
                                ? "1 component, no cavity"
                                : fmt::format("{} components and cavities together", surface.components);
  return fmt::format(
      "the voxel shape has {}, {} and {}, the solid of the mesh {} and {}; a higher --resolution may help",
      counted(voxels.betti[0], "component", "components"), counted(voxels.betti[2], "cavity", "cavities"),
      counted(voxels.betti[1], "tunnel", "tunnels"), parts, counted(genus, "tunnel", "tunnels"));
}

/// The shape may be empty.
Voxelization digitize(const ClosedMesh& closed, const VoxelizeOptions& options, const detail::Progress& progress) {
  const detail::FixedMesh fixed = fixed_mesh(closed, options.resolution);
  const double h = closed.box.longest_side / static_cast<double>(options.resolution);
  Grid grid;
  for (std::size_t a = 0; a < 3; ++a) grid.dims[a] = fixed.cells[a] + 2 * options.margin;
  grid.spacing = Vec3::Constant(h);
  grid.origin = closed.box.low + Vec3::Constant((0.5 - static_cast<double>(options.margin)) * h);
  detail::Digitization digitization = detail::scan_convert(fixed, grid, options.margin, options.fill, progress);
  if (digitization.defective_scanlines > 0) {
    const auto [y, z] = digitization.one_defective;
    throw Error(
        ErrorCode::input,
        fmt::format("the mesh is not closed and oriented: along {} (for example at y = {:.6g}, z = {:.6g}) the winding "
                    "number does not return to 0; repair it first{}",
                    counted(digitization.defective_scanlines, "scanline", "scanlines"),
                    closed.box.low[1] + (static_cast<double>(y) + 0.5) * h,
                    closed.box.low[2] + (static_cast<double>(z) + 0.5) * h,
                    options.fill == FillRule::nonzero ? " or use --fill evenodd, which ignores orientation" : ""));
  }
  Voxelization result;
  result.shape = std::move(digitization.shape);
  result.longest_side = closed.box.longest_side;
  result.surface = closed.surface;
  result.topology_difference = difference(result.shape, closed.surface);
  // The surfaces of several parts do not tell the topology of their union when they overlap.
  result.topology_known =
      result.topology_difference.empty() || !digitization.overlapping || closed.surface.components == 1;
  if (!result.topology_known) result.topology_difference.clear();
  result.topology_changed = !result.topology_difference.empty();
  return result;
}

Voxelization not_empty(Voxelization result, std::int64_t resolution) {
  if (result.shape.empty())
    throw Error(
        ErrorCode::input,
        fmt::format("the mesh encloses no voxel centre at resolution {}; it encloses nothing, or is so thin that "
                    "it needs a higher --resolution",
                    resolution));
  return result;
}

}  // namespace

Voxelization voxelize(const TriangleMesh& mesh, const VoxelizeOptions& options, Context* context) {
  check(options);
  return not_empty(digitize(closed_mesh(mesh), options, {context, 0, 1}), options.resolution);
}

Voxelization voxelize_auto(const TriangleMesh& mesh, VoxelizeOptions options, Context* context) {
  constexpr std::array<std::int64_t, 5> resolutions{128, 256, 512, 1024, 2048};
  options.resolution = resolutions.front();
  check(options);
  const ClosedMesh closed = closed_mesh(mesh);
  Voxelization result;
  std::optional<Topology> coarser;  // of overlapping parts, whose own topology is not known
  double done = 0;
  for (const std::int64_t resolution : resolutions) {
    options.resolution = resolution;
    const double end = resolution == resolutions.back() ? 1 : (done + 1) / 2;
    result = {};  // frees the coarser one first
    result = digitize(closed, options, {context, done, end});
    done = end;
    if (result.shape.empty()) continue;
    if (result.topology_known) {
      if (!result.topology_changed) break;
    } else {
      const Topology now = topology(result.shape);
      if (coarser == now) break;
      coarser = now;
    }
  }
  checkpoint(context, "voxelize", 1);
  return not_empty(std::move(result), options.resolution);
}

}  // namespace quench
