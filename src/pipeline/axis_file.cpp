// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/text.h"
#include "quench/axis.h"
#include "quench/error.h"
#include "quench/geometry.h"
#include "quench/io.h"
#include "quench/pipeline.h"

namespace quench::pipeline {

std::optional<double> field_number(const Record& data, const char* name) {
  const DataArray* array = find_array(data.field_data, name);
  if (!array || array->size() == 0 || std::holds_alternative<std::vector<std::string>>(array->values)) return {};
  return array->numbers().front();
}

std::optional<std::string> field_text(const Record& data, const char* name) {
  const DataArray* array = find_array(data.field_data, name);
  if (!array) return {};
  const auto* text = std::get_if<std::vector<std::string>>(&array->values);
  if (!text || text->empty()) return {};
  return text->front();
}

Record read_surface(const std::filesystem::path& file, Context* context) {
  std::error_code ignored;
  // The bytes of the file and what is made of them; a compressed one says what it holds when it is opened.
  if (const auto size = std::filesystem::file_size(file, ignored); !ignored)
    require_memory(static_cast<std::int64_t>(2 * size), fmt::format("reading '{}'", file.string()), {"a smaller file"},
                   context);
  return io::read_record(file, context);
}

std::string_view result_name(const Record& data) {
  const std::string stage = field_text(data, "stage").value_or("");
  if (stage == "skeleton") return "skeleton";
  if (stage != "core") {
    if (!find_array(data.point_data, "radius")) return {};
    // A mesh may have an array of that name; a medial axis is a closed surface at most without lines.
    if (stage.empty() && data.lines.empty() && data.poly_count() > 0)
      if (const SurfaceTopology t = surface_topology(to_triangle_mesh(data)); t.manifold && t.boundary_edges == 0)
        return {};
  }
  return find_array(data.point_data, "burn_time") ? "burned medial axis" : "medial axis";
}

void take_radii(Record& data, const std::filesystem::path& radii, Context* context) {
  std::erase_if(data.point_data, [](const DataArray& a) { return a.name == "radius"; });
  data.point_data.insert(data.point_data.begin(), {"radius", 1, io::read_radii(radii, data.points, context)});
}

namespace {

// The sites of a core of the plane, where its file has them and their grid.
std::optional<PlaneSites> plane_sites(const Record& data) {
  const auto numbers = [&](const char* name, std::size_t count) -> std::vector<double> {
    const DataArray* array = find_array(data.field_data, name);
    if (!array || array->size() != count || std::holds_alternative<std::vector<std::string>>(array->values)) return {};
    return array->numbers();
  };
  const std::vector<double> dims = numbers("dims", 3), spacing = numbers("spacing", 3), origin = numbers("origin", 3),
                            direction = numbers("direction", 9);
  const DataArray* triples = find_array(data.field_data, "sites");
  if (dims.empty() || spacing.empty() || origin.empty() || direction.empty() || !triples || triples->components != 3)
    return {};
  constexpr double kMostPixels = 0x1p20;
  const auto is_size = [](double n) { return n >= 1 && n <= kMostPixels; };
  if (!is_size(dims[0]) || !is_size(dims[1]) || !(spacing[0] > 0) || !(spacing[1] > 0) || !std::isfinite(spacing[0]) ||
      !std::isfinite(spacing[1]))
    return {};
  PlaneSites sites;
  sites.grid.dims = {static_cast<std::int64_t>(dims[0]), static_cast<std::int64_t>(dims[1]), 1};
  sites.grid.spacing = Vec3(spacing[0], spacing[1], spacing[2]);
  sites.grid.origin = Vec3(origin[0], origin[1], origin[2]);
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) sites.grid.direction(r, c) = direction[static_cast<std::size_t>(3 * r + c)];
  sites.grid.make_plane();
  const std::vector<double> at = triples->numbers();
  for (std::size_t i = 0; i + 2 < at.size(); i += 3) {
    if (!(at[i] >= 0 && at[i] <= dims[0] && at[i + 1] >= 0 && at[i + 1] <= dims[1])) return {};
    sites.sites.push_back({static_cast<std::int32_t>(at[i]), static_cast<std::int32_t>(at[i + 1]), 0});
  }
  std::ranges::sort(sites.sites, {}, [](const LatticePoint& p) { return std::array{p[1], p[0]}; });
  if (sites.sites.empty()) return {};
  return sites;
}

}  // namespace

LoadedAxis axis_of(Record&& data, const std::string& file, Context* context) {
  LoadedAxis loaded;
  loaded.data = std::move(data);
  drop_unusable_fields(loaded.data, file, context);
  AxisRepair repair;
  try {
    loaded.axis = medial_axis_of(loaded.data, &repair);
  } catch (const Error& error) {
    throw Error(error.code(), fmt::format("'{}': {}", file, error.what()), error.field());
  }
  if (loaded.axis.points.empty()) throw Error(ErrorCode::input, fmt::format("'{}' is empty", file));
  checkpoint(context, "read", 1);
  if (repair.degenerate + repair.duplicate > 0)
    note(context,
         fmt::format("'{}' has {} with a repeated corner (the rest of it is kept) and {} twice (counted once)", file,
                     base::counted(repair.degenerate, "cell"), base::counted(repair.duplicate, "polygon")));
  if (const DataArray* spacing = find_array(loaded.data.field_data, "spacing")) {
    const std::vector<double> sizes = spacing->numbers();
    loaded.spacing = {sizes[0], sizes[1], sizes[2]};
    loaded.scale.voxel = loaded.spacing.minCoeff();
    Grid grid = loaded.axis.grid;
    grid.spacing = loaded.spacing;
    loaded.scale.detail = auto_detail(grid);
    // Skeletons do not have the points of the voxels, but say what they are fitted to.
    loaded.scale.fitted = loaded.axis.is_fitted() || field_text(loaded.data, "surface").value_or("voxels") != "voxels";
  }
  loaded.scale.longest_side = field_number(loaded.data, "longest_side").value_or(0);
  if (!(loaded.scale.longest_side > 0)) loaded.scale.longest_side = longest_side_of(loaded.axis.points);
  // A voxel core of ours names the boundary vertices its radii are distances to.
  const DataArray* sites = find_array(loaded.data.field_data, "sites");
  loaded.voxel_core = sites && sites->components == 3 && !loaded.axis.is_fitted();
  loaded.coordinates = {field_text(loaded.data, "units").value_or(""), field_text(loaded.data, "SPACE").value_or(""),
                        field_text(loaded.data, "y_axis") == "down"};
  if (loaded.axis.grid.is_plane()) loaded.sites = plane_sites(loaded.data);
  return loaded;
}

}  // namespace quench::pipeline
