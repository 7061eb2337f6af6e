// SPDX-License-Identifier: Apache-2.0
#include "pipeline/menu_of_measures.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "axis/measures.h"
#include "base/parallel.h"
#include "quench/axis.h"
#include "quench/burn.h"
#include "quench/error.h"
#include "quench/pipeline.h"

namespace quench::pipeline {
namespace {

/// What functions work on; what several of them need is made once.
struct Work {
  MedialAxis& axis;
  const LoadedShape& shape;
  std::vector<double>& erosion;  ///< per vertex; empty: not burned yet
  Context* context;
};

void add(Work& work, std::string_view name, CellValues value) {
  work.axis.measures.push_back({std::string(name), std::move(value), {}});
}

void require_surface_memory(const Work& work) {
  if (work.axis.grid.is_plane()) return;
  require_memory(
      predicted_mgf_bytes(work.shape.shape, work.axis.complex.face_count(), tbb::this_task_arena::max_concurrency()),
      "the MGF of the medial axis", {"a lower resolution"}, work.context);
}

// The voxel core's, by the default options of burning.
const std::vector<double>& erosion_of(Work& work) {
  if (!work.erosion.empty()) return work.erosion;
  const MedialAxis& axis = work.axis;
  BurnOptions options;
  options.plane = axis.grid.is_plane();
  options.parents = false;
  options.rounded = true;
  require_memory(predicted_burn_bytes(axis.complex, axis.points_of_voxels(), options),
                 "burning the core for its erosion thickness", {"a lower resolution"}, work.context);
  work.erosion =
      burn(axis.complex, axis.points_of_voxels(), axis.radius_of_voxels(), options, work.context).erosion_thickness;
  return work.erosion;
}

void add_lambda(Work& work) { work.axis.measure(kLambda); }

void add_details(Work& work) {
  if (work.shape.surface)
    add_detail(work.axis, *work.shape.surface, work.context);
  else
    add_detail(work.axis, work.context);
}

void add_cap_height(Work& work) { work.axis.measures.push_back(derived_measure(work.axis, kCapHeight)); }

void add_object_angle(Work& work) {
  CellValues angle = derived_measure(work.axis, kObjectAngle).value;
  axis::take_largest_around(work.axis.complex, angle);
  add(work, kObjectAngle, std::move(angle));
}

void add_radius(Work& work) { add_circumradius(work.axis, work.context); }

void add_ways(Work& work) {
  require_surface_memory(work);
  add_mgf(work.axis, work.shape.shape, work.context);
}

void add_residual(Work& work) {
  require_surface_memory(work);
  add_chord_residual(work.axis, work.shape.shape, work.context);
}

void add_erosion(Work& work) {
  add(work, kCoreErosionThickness, axis::smallest_of_corners(work.axis.complex, erosion_of(work)));
}

void add_relative_erosion(Work& work) {
  std::vector<double> share = erosion_of(work);
  const std::vector<double>& radius = work.axis.radius_of_voxels();
  for (std::size_t v = 0; v < share.size(); ++v)
    share[v] = std::isinf(share[v]) ? 1 : share[v] / (share[v] + radius[v]);
  add(work, kRelativeErosionThickness, axis::smallest_of_corners(work.axis.complex, share));
}

void add_scales(Work& work) { add_scale_axis(work.axis, work.context); }

/// Which function adds a measure: a line for each of kMeasures, in its order.
struct Way {
  std::string_view name;
  void (*add)(Work& work);
};
constexpr std::array kWays{Way{kDetail, add_details},
                           Way{kLambda, add_lambda},
                           Way{kCapHeight, add_cap_height},
                           Way{kObjectAngle, add_object_angle},
                           Way{kCircumradius, add_radius},
                           Way{kMgf, add_ways},
                           Way{kChordResidual, add_residual},
                           Way{kCoreErosionThickness, add_erosion},
                           Way{kRelativeErosionThickness, add_relative_erosion},
                           Way{kScaleAxis, add_scales}};
static_assert(std::ranges::equal(kMeasures, kWays, {}, &MeasureKind::name, &Way::name));

const MeasureKind& kind_of(std::string_view name, std::string_view field) {
  if (const MeasureKind* kind = find_measure_kind(name)) return *kind;
  std::vector<std::string_view> names;
  for (const MeasureKind& kind : kMeasures) names.push_back(kind.name);
  const char* hint = name == "erosion_thickness" ? "; that of burned files is of what is kept, of the whole core it is "
                                                   "core_erosion_thickness"
                     : name == "potential_residual" ? "; the potential residual is mgf"
                                                    : "";
  throw Error(ErrorCode::usage,
              fmt::format("'{}' is not a measure; there are {}{}", name, fmt::join(names, ", "), hint),
              std::string(field));
}

void add_missing(MedialAxis& axis, const LoadedShape& of, const std::vector<std::string>& names, Context* context) {
  std::vector<double> erosion;
  Work work{axis, of, erosion, context};
  for (const Way& way : kWays)  // in this order, as some take what others have found
    if (std::ranges::find(names, way.name) != names.end() && !axis.find_measure(way.name)) way.add(work);
}

}  // namespace

Pruning pruning_of(std::string_view measure, std::string_view threshold, std::string_view field) {
  const MeasureKind& kind = kind_of(measure, field);
  return {kind.name, parse_threshold(threshold, kind, field)};
}

std::vector<std::string> parse_measures(std::string_view text) {
  std::vector<std::string> names;
  if (text == "all") {
    for (const MeasureKind& kind : kMeasures) names.emplace_back(kind.name);
    return names;
  }
  while (true) {
    const std::size_t comma = std::min(text.find(','), text.size());
    names.emplace_back(kind_of(text.substr(0, comma), "measures").name);
    if (comma == text.size()) return names;
    text.remove_prefix(comma + 1);
  }
}

void add_measure(MedialAxis& axis, const LoadedShape& of, std::string_view name, Context* context) {
  const std::string known(kind_of(name, "measures").name);
  base::in_arena(context, [&] { add_missing(axis, of, {known}, context); });
}

void add_measures(MedialAxis& axis, const LoadedShape& of, const std::vector<std::string>& names, Context* context) {
  std::vector<std::string> wanted;  // the others are in every file, as the core has them or to_record() derives them
  for (const std::string& name : names)
    if (const MeasureKind& kind = kind_of(name, "measures"); kind.files != MeasureFiles::all)
      wanted.emplace_back(kind.name);
  add_missing(axis, of, wanted, context);
}

}  // namespace quench::pipeline
