// SPDX-License-Identifier: Apache-2.0
#include "quench/verify.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/parallel.h"
#include "quench/error.h"
#include "verification/checks.h"
#include "verification/surface_ways.h"

namespace quench {

namespace {

using namespace verification;

// Why the file does not describe a complex; empty when it does.
std::string structural_defect(const Record& data) {
  try {
    data.validate();
  } catch (const Error& error) {
    return error.what();
  }
  for (std::size_t l = 0; l < data.lines.size(); ++l)
    if (data.lines[l][0] == data.lines[l][1])
      return "line " + std::to_string(l) + " joins point " + std::to_string(data.lines[l][0]) + " to itself";
  for (std::size_t f = 0; f < data.poly_count(); ++f) {
    std::vector<std::uint32_t> corners(data.poly_corners.begin() + data.poly_offsets[f],
                                       data.poly_corners.begin() + data.poly_offsets[f + 1]);
    std::sort(corners.begin(), corners.end());
    if (corners.size() < 3 || std::adjacent_find(corners.begin(), corners.end()) != corners.end())
      return "polygon " + std::to_string(f) + " has fewer than three different corners or repeats one";
  }
  for (std::size_t p = 0; p < data.points.size(); ++p)
    if (!data.points[p].allFinite()) return "point " + std::to_string(p) + " is not finite";
  return {};
}

// The first vertex that is more than a voxel or pixel outside the grid; empty when none is. Sizes and tolerances of the
// checks are those of points of the shape: they would take long, or for ever, where coordinates are of any size.
std::string vertex_off_grid(const Result& result) {
  const auto& dims = result.shape.grid().dims;
  const auto in_grid = [&](const Vec3& p) {
    for (std::size_t a = 0; a < 3; ++a)
      if (const double x = p[static_cast<int>(a)]; !(x >= -1 && x <= static_cast<double>(dims[a]) + 1)) return false;
    return true;
  };
  for (std::uint32_t v = 0; v < result.lattice.size(); ++v)
    if (!in_grid(result.lattice[v]) || (result.fitted && !in_grid(result.shape.grid().lattice(result.point(v)))))
      return result.describe_vertex(v) + " is outside the grid of the shape; nothing else is checked";
  return {};
}

void refuse_conflicts(const Record& data, const VerifyOptions& options) {
  if (options.lambda && options.detail)
    throw Error(ErrorCode::usage, "a medial axis is pruned by lambda or by detail, not by both", "detail");
  if (text_or_empty(data.field_data, "stage") != "core") return;
  const auto refuse = [&](bool given, std::string_view measure, std::string_view other) {
    if (given && find_array(data.field_data, other) && !find_array(data.field_data, measure))
      throw Error(ErrorCode::usage,
                  fmt::format("the file says that it was pruned by {1}, and not by {0}", measure, other),
                  std::string(measure));
  };
  refuse(options.lambda.has_value(), kLambda, kDetail);
  refuse(options.detail.has_value(), kDetail, kLambda);
}

Certificate examine(const VoxelShape& shape, const Record& data, const VerifyOptions& options, Context* context) {
  if (options.erosion_of_core && options.erosion_of_core->size() != data.points.size())
    throw Error(ErrorCode::usage, "erosion_of_core must have one value per point of the file");
  Certificate certificate;
  const std::string defect = structural_defect(data);
  if (!defect.empty()) {
    certificate.checks.push_back(failed("no duplicate or degenerate cell", defect));
    return certificate;
  }
  if (const std::string wrong = array_defect(data); !wrong.empty()) {
    certificate.checks.push_back(failed("arrays", wrong));
    return certificate;
  }
  const Result result(shape, data, options);
  if (const std::string far = vertex_off_grid(result); !far.empty()) {
    certificate.checks.push_back(failed("inside the shape", far));
    return certificate;
  }
  Check dimension = check_dimension(result);
  if (!dimension.passed || result.plane) certificate.checks.push_back(dimension);
  if (!dimension.passed) return certificate;
  const Sites sites(shape);
  VertexSites vertex_sites(result, sites);
  std::optional<BoundaryCurves> boundary;
  if (result.plane) boundary.emplace(shape, sites);
  const auto add = [&](Check check) { certificate.checks.push_back(std::move(check)); };

  add(check_expected(result, options));
  add(check_cells(result));
  add(check_topology(result, options.surface, boundary ? &*boundary : nullptr));
  add(check_enclosure(result, context));
  add(check_radii(result, sites, context));
  if (result.fitted) {
    add(check_moves(result));
    if (options.surface) {
      const TriangleSearch surface(*options.surface);
      add(check_sides(result, surface, options, context));
      if (options.surface_kind == "grey") add(check_isosurface(shape, options, context));
      add(check_balls(result, surface, options, context));
    } else {
      add(not_checked("balls of the surface", fmt::format("the surface ({}) was not given", result.surface)));
    }
  }
  if (result.stage == "core") {
    add(result.plane ? check_voronoi_of_plane(result, sites, vertex_sites, context)
                     : check_voronoi(result, sites, vertex_sites, options.samples, context));
    add(check_lambda(result, sites, vertex_sites, options.samples, context));
    if (!result.by.empty())
      add(not_checked("legal pruning",
                      fmt::format("pruned by {}: that no pair below it is left is said by its levels", result.by)));
    else
      add(result.by_detail ? check_detail_pruning(result, sites, vertex_sites, options.samples, context)
                           : check_pruning(result, sites, vertex_sites, options.samples, context));
    if (result.by_detail) {
      add(check_details(result, sites, vertex_sites, context));
      add(check_coverage(result, sites, context));
    }
  } else {
    const std::string why = result.stage.empty() ? "no FieldData 'stage'" : "the stage is '" + result.stage + "'";
    for (const char* name : {"Voronoi cells", "lambda", "legal pruning"})
      add(not_checked(name, fmt::format("{}, this is a property of {} cores", why, pixel_or_voxel(result))));
  }
  if (result.stage.empty())
    add(not_checked(
        "proximity bound",
        fmt::format("no FieldData 'stage', this is a property of {} cores and parts of them", pixel_or_voxel(result))));
  else
    add(check_proximity(result, options.samples, context));
  for (Check& check : check_levels(result, sites, vertex_sites, context)) add(std::move(check));
  if (find_array(data.field_data, "format_version") || find_array(data.field_data, "measures"))
    add(check_measures(result));
  add(check_sites(result, sites));
  add(check_angles(result));
  add(check_cap_heights(result, sites, vertex_sites, options.samples, context));
  if (result.stage == "core")
    for (Check& check : check_other_measures(result, sites, options, context)) add(std::move(check));
  add(check_kinds(result));
  if (result.plane) {
    if (result.stage == "core") add(check_mgf(result, sites, vertex_sites, *boundary, context));
    add(check_burning_of_plane(result));
    add(check_skeleton_levels_of_plane(result));
  } else {
    if (result.stage == "core") add(check_mgf_of_surface(result, sites, options.samples, context));
    add(check_burning(result));
    if (has_burn_sequence(data)) add(check_burn_sequence(result));
    add(check_skeleton_levels(result));
  }
  add(check_branches(result));
  add(check_reconstruction(result, context));
  add(check_fields(result, options));
  certificate.not_checked = unchecked_arrays(data, certificate.checks);
  certificate.absent = absent_arrays(result);
  add(arrays_left(certificate.not_checked, certificate.absent));
  checkpoint(context, "verify", 1);
  return certificate;
}

}  // namespace

bool Certificate::passed() const {
  return std::all_of(checks.begin(), checks.end(), [](const Check& check) { return check.passed; });
}

Certificate verify(const VoxelShape& shape, const Record& result, const VerifyOptions& options, Context* context) {
  if (shape.empty()) throw Error(ErrorCode::input, "the shape to verify against has no voxels or pixels");
  refuse_conflicts(result, options);
  return base::in_arena(context, [&] { return examine(shape, result, options, context); });
}

}  // namespace quench
