// SPDX-License-Identifier: Apache-2.0
#include "quench/voxelize.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/parallel.h"
#include "base/text.h"
#include "quench/error.h"
#include "quench/shape.h"
#include "voxelization/scan_conversion.h"
#include "voxelization/surface_analysis.h"
#include "voxelization/surface_edges.h"
#include "voxelization/surface_repair.h"
#include "voxelization/winding_number.h"

namespace quench {
namespace {

constexpr std::int64_t largest_resolution = 16384;  // the bounds of scan_conversion.cpp rest on it
constexpr std::int64_t largest_margin = 16384;

void check(const VoxelizeOptions& options) {
  if (options.resolution < 1 || options.resolution > largest_resolution)
    throw Error(
        ErrorCode::usage,
        fmt::format("resolution '{}' is not a whole number from 1 to {}", options.resolution, largest_resolution),
        "resolution");
  if (options.margin < 0 || options.margin > largest_margin)
    throw Error(ErrorCode::usage,
                fmt::format("the margin {} is not possible; it takes 0 to {} voxels", options.margin, largest_margin));
}

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
      if (p >= mesh.points.size()) voxelization::refuse_corner(mesh, t, p);
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
struct CheckedMesh {
  const TriangleMesh& mesh;
  voxelization::SurfaceAnalysis analysis;
  Box box;
};

CheckedMesh checked_mesh(const TriangleMesh& mesh) {
  const Box box = bounding_box(mesh);
  return {mesh, voxelization::analyze_surface(mesh), box};
}

voxelization::FixedMesh fixed_mesh(const CheckedMesh& checked, std::int64_t resolution) {
  voxelization::FixedMesh fixed;
  const Box& box = checked.box;
  const double scale = std::ldexp(static_cast<double>(resolution), voxelization::fraction_bits);
  const auto fix = [&](const Vec3& p) {
    voxelization::FixedPoint q{};
    for (int a = 0; a < 3; ++a)
      q[static_cast<std::size_t>(a)] = std::llround((p[a] - box.low[a]) / box.longest_side * scale);
    return q;
  };
  fixed.triangles = checked.mesh.triangles;
  fixed.points.resize(checked.mesh.points.size());  // points no triangle uses stay 0: they may be anywhere
  for (const auto& triangle : checked.mesh.triangles)
    for (const std::uint32_t p : triangle) fixed.points[p] = fix(checked.mesh.points[p]);
  const voxelization::FixedPoint extent = fix(box.high);
  for (std::size_t a = 0; a < 3; ++a)
    fixed.cells[a] = std::max<std::int64_t>(
        1, (extent[a] + (std::int64_t{1} << voxelization::fraction_bits) - 1) >> voxelization::fraction_bits);
  return fixed;
}

/// A sentence when the solid of the mesh has another topology than the shape, else empty.
std::string difference(const VoxelShape& shape, const SurfaceTopology& surface) {
  const Topology voxels = topology(shape);
  const std::int64_t genus = surface.components - surface.euler;
  if (!surface.manifold) {
    if (voxels.euler == surface.euler) return {};
    return fmt::format(
        "the voxel shape has Euler characteristic {}, the solid of the mesh {}; the mesh is not a 2-manifold, so parts "
        "may touch; a higher resolution may help",
        voxels.euler, surface.euler);
  }
  if (voxels.euler == surface.euler && voxels.betti[0] + voxels.betti[2] == surface.components &&
      voxels.betti[1] == genus)
    return {};
  const std::string parts = surface.components == 1
                                ? "1 component, no cavity"
                                : fmt::format("{} components and cavities together", surface.components);
  return fmt::format(
      "the voxel shape has {}, {} and {}, the solid of the mesh {} and {}; a higher resolution may help",
      base::counted(voxels.betti[0], "component", "components"), base::counted(voxels.betti[2], "cavity", "cavities"),
      base::counted(voxels.betti[1], "tunnel", "tunnels"), parts, base::counted(genus, "tunnel", "tunnels"));
}

/// The rule, and the faces it is asked of.
struct Choice {
  FillRule fill;
  std::string reason;
  bool robust = false;  ///< `repaired` is used, with the winding number
  voxelization::RepairedSurface repaired;
};

Choice choose(const voxelization::FixedMesh& fixed, const voxelization::SurfaceAnalysis& analysis, FillRule asked) {
  Choice choice{asked, {}, false, {}};
  const bool sound = analysis.unbalanced_edges == 0;
  choice.robust = asked == FillRule::winding || asked == FillRule::automatic ||
                  (asked == FillRule::nonzero && !sound) || (asked == FillRule::evenodd && analysis.odd_edges > 0);
  if (!choice.robust) return choice;
  choice.repaired = voxelization::repair_orientation(fixed.points, voxelization::weld(fixed.points, fixed.triangles));
  if (asked != FillRule::automatic) return choice;
  if (sound && choice.repaired.flipped_components == 0) {
    choice.fill = FillRule::nonzero;
    choice.reason = "the surface is closed and consistently oriented";
    choice.robust = false;
  } else if (sound) {
    choice.fill = FillRule::winding;
    choice.reason = fmt::format("{} of the closed surface {} inward without lying in another part",
                                base::counted(choice.repaired.flipped_components, "part", "parts"),
                                choice.repaired.flipped_components == 1 ? "faces" : "face");
  } else if (analysis.odd_edges == 0 &&
             !voxelization::boundary_chain(fixed.points.size(), choice.repaired.faces).empty()) {
    choice.fill = FillRule::evenodd;
    choice.reason = "every edge has an even number of faces, but these cannot be oriented consistently";
    choice.robust = false;
  } else {
    choice.fill = FillRule::winding;
    choice.reason = analysis.odd_edges == 0
                        ? "the surface is closed but not consistently oriented"
                        : fmt::format("the surface is not closed: {}",
                                      base::counted(analysis.odd_edges, "edge has an odd number of faces",
                                                    "edges have an odd number of faces"));
  }
  return choice;
}

/// The shape may be empty.
Voxelization digitize(const CheckedMesh& checked, const VoxelizeOptions& options,
                      const voxelization::Progress& progress) {
  voxelization::FixedMesh fixed = fixed_mesh(checked, options.resolution);
  const double h = checked.box.longest_side / static_cast<double>(options.resolution);
  Grid grid;
  for (std::size_t a = 0; a < 3; ++a) grid.dims[a] = fixed.cells[a] + 2 * options.margin;
  grid.spacing = Vec3::Constant(h);
  grid.origin = checked.box.low + Vec3::Constant((0.5 - static_cast<double>(options.margin)) * h);
  const Choice choice = choose(fixed, checked.analysis, options.fill);
  std::optional<voxelization::WindingNumber> winding;
  if (choice.robust) {
    fixed.triangles = choice.repaired.faces;
    winding.emplace(fixed.points, fixed.triangles);
  }
  const auto inside = choice.fill == FillRule::evenodd ? voxelization::Inside::odd : voxelization::Inside::nonzero;
  voxelization::Digitization digitization =
      voxelization::scan_convert(fixed, grid, options.margin, inside, winding ? &*winding : nullptr, progress);
  Voxelization result;
  result.shape = std::move(digitization.shape);
  result.longest_side = checked.box.longest_side;
  result.surface = checked.analysis.topology;
  result.fill = choice.fill;
  result.fill_reason = choice.reason;
  SurfaceDefects& defects = result.defects;
  defects.open_edges = checked.analysis.boundary_edges;
  defects.unbalanced_edges = checked.analysis.unbalanced_edges;
  defects.degenerate_faces = checked.analysis.degenerate_faces;
  defects.duplicate_faces = choice.robust ? choice.repaired.duplicate_faces : 0;
  defects.flipped_faces = choice.robust ? choice.repaired.flipped_faces : 0;
  defects.filled_holes = choice.robust ? choice.repaired.filled_holes : 0;
  defects.flipped_components = choice.robust ? choice.repaired.flipped_components : 0;
  defects.scanlines = digitization.scanlines;
  defects.defective_scanlines = digitization.defective_scanlines;
  if (const std::int64_t voxels = result.shape.voxel_count(); voxels > 0)
    defects.winding_share = static_cast<double>(digitization.winding_voxels) / static_cast<double>(voxels);
  if (digitization.sampled > 0)
    defects.doubtful_share = static_cast<double>(digitization.doubtful) / static_cast<double>(digitization.sampled);
  const bool closed =
      choice.fill == FillRule::evenodd ? checked.analysis.odd_edges == 0 : checked.analysis.unbalanced_edges == 0;
  result.sound = closed && defects.flipped_faces == 0;
  // The surfaces of several parts do not tell the topology of their union when they overlap, a defective one nothing.
  result.topology_known = result.sound;
  if (!result.topology_known) return result;
  result.topology_difference = difference(result.shape, result.surface);
  result.topology_known =
      result.topology_difference.empty() || !digitization.overlapping || result.surface.components == 1;
  if (!result.topology_known) result.topology_difference.clear();
  result.topology_changed = !result.topology_difference.empty();
  return result;
}

Voxelization not_empty(Voxelization result, std::int64_t resolution) {
  if (!result.shape.empty()) return result;
  if (result.sound)
    throw Error(
        ErrorCode::input,
        fmt::format("the mesh encloses no voxel centre at resolution {}; it encloses nothing, or is so thin that "
                    "it needs a higher resolution",
                    resolution),
        "resolution");
  throw Error(
      ErrorCode::input,
      fmt::format("the mesh is not closed ({}) and encloses nothing: no voxel centre has a winding number above "
                  "1/2 at resolution {}; close its holes, or give a higher resolution if it is thin",
                  result.defects.open_edges > 0
                      ? base::counted(result.defects.open_edges, "edge with one face only", "edges with one face only")
                      : "its faces do not agree on an inside",
                  resolution),
      "resolution");
}

}  // namespace

std::string defects_text(const Voxelization& v) {
  if (v.sound) return {};
  const SurfaceDefects& d = v.defects;
  std::string found;
  const auto add = [&](std::int64_t n, const char* one, const char* many) {
    if (n > 0) found += (found.empty() ? "" : ", ") + base::counted(n, one, many);
  };
  add(d.open_edges, "open edge", "open edges");
  add(d.duplicate_faces, "duplicate face left out", "duplicate faces left out");
  add(d.flipped_faces, "face turned", "faces turned");
  add(d.filled_holes, "small hole filled", "small holes filled");
  add(d.flipped_components, "part turned as a whole", "parts turned as a whole");
  if (found.empty()) found = base::counted(d.unbalanced_edges, "edge", "edges") + " whose faces do not agree";
  const char* what = d.open_edges > 0         ? "is not closed"
                     : d.unbalanced_edges > 0 ? "is not consistently oriented"
                                              : "has parts that face inward";
  if (d.defective_scanlines == 0)
    return fmt::format("the mesh {} ({}); every scanline is decided by its crossings", what, found);
  std::string text = fmt::format(
      "the mesh {} ({}); the winding number decides {} of {}, with {:.2g}% of the shape's voxels", what, found,
      d.defective_scanlines, base::counted(d.scanlines, "scanline", "scanlines"), 100 * d.winding_share);
  constexpr double much = 0.3;
  if (d.doubtful_share > much)
    text += fmt::format(
        "; {:.2g}% of the voxels are a guess (winding number below 3/4): large parts of the surface are missing, or it "
        "is a sheet that encloses nothing",
        100 * d.doubtful_share);
  return text;
}

std::string_view fill_name(FillRule rule) {
  switch (rule) {
    case FillRule::nonzero:
      return "nonzero";
    case FillRule::evenodd:
      return "evenodd";
    case FillRule::winding:
      return "winding";
    case FillRule::automatic:
      break;
  }
  return "auto";
}

std::optional<FillRule> fill_of(std::string_view name) {
  for (const FillRule rule : {FillRule::nonzero, FillRule::evenodd, FillRule::winding, FillRule::automatic})
    if (fill_name(rule) == name) return rule;
  return std::nullopt;
}

namespace {

Voxelization voxelized_automatically(const TriangleMesh& mesh, VoxelizeOptions options, Context* context) {
  constexpr std::array<std::int64_t, 5> resolutions{128, 256, 512, 1024, 2048};
  options.resolution = resolutions.front();
  check(options);
  const CheckedMesh checked = checked_mesh(mesh);
  Voxelization result;
  std::optional<Topology> coarser;  // of overlapping parts, whose own topology is not known
  double done = 0;
  for (const std::int64_t resolution : resolutions) {
    options.resolution = resolution;
    const double end = resolution == resolutions.back() ? 1 : (done + 1) / 2;
    result = {};  // frees the coarser one first
    result = digitize(checked, options, {context, done, end});
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

}  // namespace

Voxelization voxelize(const TriangleMesh& mesh, const VoxelizeOptions& options, Context* context) {
  check(options);
  return base::in_arena(context, [&] {
    return not_empty(digitize(checked_mesh(mesh), options, {context, 0, 1}), options.resolution);
  });
}

Voxelization voxelize_auto(const TriangleMesh& mesh, VoxelizeOptions options, Context* context) {
  return base::in_arena(context, [&] { return voxelized_automatically(mesh, options, context); });
}

}  // namespace quench
