// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "base/text.h"
#include "quench/pipeline.h"
#include "quench/solid_stages.h"

namespace quench::pipeline {

BoundaryPoints boundary_of(const MedialAxis& axis, const LoadedShape* shape, std::string* what, Context* context) {
  const auto say = [&](std::string_view name) {
    if (what) *what = name;
  };
  if (!shape) {
    say("envelope");
    return boundary_points(axis, 100000, context);
  }
  say(name_of(shape->surface ? shape->surface->kind() : SurfaceKind::voxels));
  return shape->surface ? boundary_points(*shape->surface) : boundary_points(shape->shape);
}

Simplified simplified(const MedialAxis& axis, const BoundaryPoints& boundary, const SimplifyOptions& options,
                      Context* context) {
  require_memory(
      predicted_simplify_bytes(axis.complex),
      fmt::format("simplifying a medial axis with {}", base::counted(axis.complex.vertex_count, "vertex", "vertices")),
      {"an axis that is pruned more"}, context);
  Simplified result = simplify(axis, boundary, options, context);
  const Topology before = topology(axis.complex), after = topology(result.axis.complex);
  if (!(before == after))
    throw Error(
        ErrorCode::invariant,
        fmt::format("the simplified axis has {} components, {} tunnels and {} cavities, the medial axis {}, {} "
                    "and {}; please report this",
                    after.betti[0], after.betti[1], after.betti[2], before.betti[0], before.betti[1], before.betti[2]));
  return result;
}

Record reshaped_file(const MedialAxis& axis, const Record& from, const std::string& stage) {
  MedialAxis bare;
  bare.complex = axis.complex;
  bare.points = axis.points;
  bare.radius = axis.radius;
  Record data = to_record(std::move(bare));
  std::erase_if(data.field_data, [](const DataArray& array) { return array.name != "format_version"; });
  for (const char* name : {"longest_side", "units", "SPACE"})
    if (const DataArray* array = find_array(from.field_data, name)) data.field_data.push_back(*array);
  data.field_data.push_back({"stage", 1, std::vector<std::string>{stage}});
  data.field_data.push_back({"version", 1, std::vector<std::string>{QUENCH_VERSION}});
  return data;
}

}  // namespace quench::pipeline
