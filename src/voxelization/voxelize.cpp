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
#include "voxelization/match_topology.h"
#include "voxelization/scan_conversion.h"
#include "voxelization/solid_topology.h"
#include "voxelization/surface_analysis.h"
#include "voxelization/surface_edges.h"
#include "voxelization/surface_repair.h"
#include "voxelization/winding_number.h"

namespace quench {
namespace {

constexpr std::int64_t kLargestResolution = 16384;  // the bounds in scan_conversion.cpp depend on it
constexpr std::int64_t kLargestMargin = 16384;

void check(const VoxelizeOptions& options) {
  if (options.resolution < 1 || options.resolution > kLargestResolution)
    throw Error(
        ErrorCode::usage,
        fmt::format("resolution '{}' is not a whole number from 1 to {}", options.resolution, kLargestResolution),
        "resolution");
  if (options.margin < 0 || options.margin > kLargestMargin)
    throw Error(ErrorCode::usage,
                fmt::format("the margin {} is not possible; it takes 0 to {} voxels", options.margin, kLargestMargin));
}

struct Box {
  Vec3 low, high;
  double longest_side = 0;
};

/// Box of the points that triangles use.
Box bounding_box(const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) throw Error(ErrorCode::input, "the mesh has no triangles; a closed surface is needed");
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
  const double scale = std::ldexp(static_cast<double>(resolution), voxelization::kFractionBits);
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
        1, (extent[a] + (std::int64_t{1} << voxelization::kFractionBits) - 1) >> voxelization::kFractionBits);
  return fixed;
}

std::string betti_text(const std::array<std::int64_t, 3>& betti) {
  return fmt::format("{}, {} and {}", base::counted(betti[0], "component", "components"),
                     base::counted(betti[2], "cavity", "cavities"), base::counted(betti[1], "tunnel", "tunnels"));
}

/// A clause when the topology of the solid of the mesh differs from that of the shape, else empty.
std::string difference(const Topology& voxels, const Voxelization& v) {
  const SurfaceTopology& surface = v.surface;
  if (v.solid_betti)
    return voxels.betti == *v.solid_betti ? ""
                                          : fmt::format("the voxel shape has {}, the solid of the mesh {}",
                                                        betti_text(voxels.betti), betti_text(*v.solid_betti));
  if (!surface.manifold) {
    if (voxels.euler == surface.euler) return {};
    return fmt::format(
        "the voxel shape has Euler characteristic {}, the solid of the mesh {}; the mesh is not a 2-manifold, so parts "
        "may touch",
        voxels.euler, surface.euler);
  }
  const std::int64_t genus = surface.components - surface.euler;
  if (voxels.euler == surface.euler && voxels.betti[0] + voxels.betti[2] == surface.components &&
      voxels.betti[1] == genus)
    return {};
  const std::string parts = surface.components == 1
                                ? "1 component, no cavity"
                                : fmt::format("{} components and cavities together", surface.components);
  return fmt::format("the voxel shape has {}, the solid of the mesh {} and {}", betti_text(voxels.betti), parts,
                     base::counted(genus, "tunnel", "tunnels"));
}

/// The fill rule, and the faces it is applied to.
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

/// Puts voxels in and takes them out; returns the topology then.
Topology repair_topology(Voxelization& v, const Topology& before, const voxelization::FixedMesh& fixed,
                         const VoxelizeOptions& options, const voxelization::Progress& progress) {
  voxelization::MatchedShape matched =
      voxelization::match_topology(fixed, v.shape, options.margin, before, *v.solid_betti, progress);
  v.repair = {.before = before, .after = matched.topology};
  v.shape = std::move(matched.shape);
  v.repair->added = matched.added;
  v.repair->removed = matched.removed;
  for (const auto& voxel : matched.places)
    v.repair->places.push_back(v.shape.grid().world(Vec3(voxel[0] + 0.5, voxel[1] + 0.5, voxel[2] + 0.5)));
  return matched.topology;
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
  result.topology = options.topology;
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
  // The topology of the union of parts does not follow from their surfaces when they overlap, nor from a defective one.
  result.topology_known = result.sound;
  if (!result.topology_known) return result;
  Topology now = topology(result.shape);
  if (options.topology == TopologyRule::mesh) {
    result.solid_betti = voxelization::solid_betti(checked.mesh, fixed, checked.analysis, inside);
    if (result.solid_betti && *result.solid_betti != now.betti && !result.shape.empty())
      now = repair_topology(result, now, fixed, options, progress);
  }
  result.topology_difference = difference(now, result);
  if (!result.topology_difference.empty() && !result.repair)
    result.topology_difference += "; a higher resolution may help";
  result.topology_known = result.solid_betti || result.topology_difference.empty() || !digitization.overlapping ||
                          result.surface.components == 1;
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
  constexpr double kMuch = 0.3;
  if (d.doubtful_share > kMuch)
    text += fmt::format(
        "; {:.2g}% of the voxels are a guess (winding number below 3/4): large parts of the surface are missing, or it "
        "is a sheet that encloses nothing",
        100 * d.doubtful_share);
  return text;
}

std::string repair_text(const TopologyRepair& repair) {
  if (repair.added + repair.removed == 0) return {};
  return fmt::format("{} put in and {} taken out for the topology of the mesh: {} before, {} now",
                     base::counted(repair.added, "voxel", "voxels"), repair.removed, betti_text(repair.before.betti),
                     betti_text(repair.after.betti));
}

std::string_view topology_name(TopologyRule rule) { return rule == TopologyRule::mesh ? "mesh" : "voxels"; }

std::optional<TopologyRule> topology_of(std::string_view name) {
  for (const TopologyRule rule : {TopologyRule::mesh, TopologyRule::voxels})
    if (topology_name(rule) == name) return rule;
  return std::nullopt;
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

/// Where the topology of the mesh could not be had, and at which resolution it could: the first of some that are not
/// much larger, and cheap.
void say_where(Voxelization& v, const CheckedMesh& checked, VoxelizeOptions options, Context* context) {
  constexpr std::int64_t kCheap = 512;
  const std::int64_t resolution = options.resolution;
  for (const std::int64_t quarters : {5, 6, 8, 12, 16}) {
    options.resolution = resolution * quarters / 4;
    if (options.resolution == resolution || options.resolution > kCheap) continue;
    if (digitize(checked, options, {context, 1, 1}).topology_changed) continue;
    v.repair->working_resolution = options.resolution;
    break;
  }
  for (std::size_t i = 0; i < v.repair->places.size(); ++i) {
    const Vec3& p = v.repair->places[i];
    v.topology_difference += fmt::format("{} ({:.6g}, {:.6g}, {:.6g})", i == 0 ? "; look at" : ",", p[0], p[1], p[2]);
  }
  v.topology_difference += v.repair->working_resolution > 0
                               ? fmt::format("; resolution {} has it", v.repair->working_resolution)
                               : "; a higher resolution may help";
}

Voxelization voxelized_automatically(const TriangleMesh& mesh, VoxelizeOptions options, Context* context) {
  constexpr std::array<std::int64_t, 5> kResolutions{128, 256, 512, 1024, 2048};
  options.resolution = kResolutions.front();
  check(options);
  const CheckedMesh checked = checked_mesh(mesh);
  Voxelization result;
  std::optional<Topology> coarser;  // of overlapping parts, whose own topology is not known
  double done = 0;
  for (const std::int64_t resolution : kResolutions) {
    options.resolution = resolution;
    const double end = resolution == kResolutions.back() ? 1 : (done + 1) / 2;
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
  if (result.repair && result.topology_changed) say_where(result, checked, options, context);
  checkpoint(context, "voxelize", 1);
  return not_empty(std::move(result), options.resolution);
}

}  // namespace

Voxelization voxelize(const TriangleMesh& mesh, const VoxelizeOptions& options, Context* context) {
  check(options);
  return base::in_arena(context, [&] {
    const CheckedMesh checked = checked_mesh(mesh);
    Voxelization result = digitize(checked, options, {context, 0, 1});
    if (result.repair && result.topology_changed) say_where(result, checked, options, context);
    return not_empty(std::move(result), options.resolution);
  });
}

Voxelization voxelize_auto(const TriangleMesh& mesh, VoxelizeOptions options, Context* context) {
  return base::in_arena(context, [&] { return voxelized_automatically(mesh, options, context); });
}

}  // namespace quench
