// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <tbb/task_group.h>

#include <algorithm>
#include <utility>

#include "axis/rest_of_core.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/text.h"
#include "pipeline/brick_files.h"
#include "pipeline/menu_of_measures.h"
#include "pipeline/parameters.h"
#include "pipeline/part_core.h"
#include "quench/axis.h"
#include "quench/error.h"
#include "quench/pipeline.h"

namespace quench::pipeline {
namespace {

void add_field(Record& data, const char* name, std::string text) {
  data.field_data.push_back({name, 1, std::vector<std::string>{std::move(text)}});
}
void add_field(Record& data, const char* name, double value) {
  data.field_data.push_back({name, 1, std::vector<double>{value}});
}

// The threshold, and by lambda what its choice looks at.
void choose_threshold(const LoadedShape& from, const axis::RestOfCore& core, CoreResult& result, Context* context) {
  const Pruning& pruning = result.options.pruning;
  const Scale scale = from.scale();
  if (pruning.measure == kDetail) {
    result.threshold = pruning.threshold ? scale.resolve(*pruning.threshold, kDetail) : auto_detail(from.shape.grid());
    return;
  }
  if (pruning.measure != kLambda) {
    result.threshold = scale.resolve(*pruning.threshold, pruning.measure);
    return;
  }
  const Reconstruction reconstruction(from.shape, core.axis, Reconstruction::kSamples, context);
  result.threshold = pruning.threshold ? scale.resolve(*pruning.threshold, kLambda)
                                       : auto_lambda(reconstruction, scale.longest_side, scale.voxel);
  if (core.is_whole()) result.whole = reconstruction.share(0);
  result.reconstructed = reconstruction.share(result.threshold);
}

// The measure of the pruning and its levels, of a core whose topology is checked.
void add_levels(axis::RestOfCore& core, const LoadedShape& from, const AxisOptions& options, Context* context) {
  const std::string_view measure = options.pruning.measure;
  const bool detail = measure == kDetail || std::ranges::find(options.measures, kDetail) != options.measures.end();
  // Checking the topology and thinning are work for one thread each: together they keep two busy. The topology is the
  // task, so that thinning stays on the calling thread, which alone reports progress; isolated, so that a thread that
  // waits for the initial pairs of the thinning does not begin with the topology.
  Topology found;
  tbb::task_group beside;
  beside.run([&] { found = topology(core.axis.complex); });
  try {
    tbb::this_task_arena::isolate([&] {
      if (detail) add_detail(core, from.surface ? &*from.surface : nullptr, context);
      add_measure(core.axis, from, measure, context);
      prune_levels(core.axis, measure, context);
    });
  } catch (...) {
    beside.cancel();
    beside.wait();
    throw;
  }
  beside.wait();
  require_topology(found, from.topology, "voxel core", "shape");
  checkpoint(context, "topology", 0.5);
}

CellCounts counts_of_all(const axis::RestOfCore& core) {
  const CellCounts left = counts_of(core.axis.complex);
  return {left.vertices + core.gone.vertices, left.edges + core.gone.edges, left.faces + core.gone.faces};
}

// All that follows from a core, or from what is left of it.
CoreResult result_of(axis::RestOfCore rest, const LoadedShape& from, const AxisOptions& options, Context* context) {
  const VoxelShape& shape = from.shape;
  CoreResult result;
  result.options = options;
  result.longest_side = from.longest_side;
  result.topology = from.topology;
  result.coordinates = from.coordinates;
  const std::string_view measure = options.pruning.measure;
  add_levels(rest, from, options, context);
  result.all = counts_of_all(rest);
  choose_threshold(from, rest, result, context);

  ContactSites contacts;
  // What is fitted does not depend on the detail, as long as that is not below the automatic one.
  const double first = options.full         ? 0
                       : measure == kDetail ? std::min(result.threshold, auto_detail(shape.grid()))
                                            : result.threshold;
  if (from.surface) contacts = contact_sites(rest, first, measure);
  MedialAxis core = std::move(rest.axis);
  rest = {};
  if (from.surface) {
    if (first > 0) core = pruned(std::move(core), first, measure);
    result.fit = fit_to_surface(core, contacts, *from.surface, context);
    contacts = {};
  }
  MedialAxis kept =
      options.full ? pruned(core, result.threshold, measure) : pruned(std::move(core), result.threshold, measure);
  require_topology(topology(kept.complex), from.topology, "pruned core", "shape");
  checkpoint(context, "topology", 1);
  result.kept = counts_of(kept.complex);
  const auto share = [&](const MedialAxis& axis) {
    return Reconstruction(shape, axis, Reconstruction::kSamples, context, measure).share(0);
  };
  if (measure != kLambda || from.surface) result.reconstructed = share(kept);
  if (options.full && (measure != kLambda || from.surface)) result.whole = share(core);
  if (measure == kDetail) result.coverage = coverage(shape, kept, context);
  result.axis = options.full ? std::move(core) : std::move(kept);
  add_measures(result.axis, from, options.measures, context);
  return result;
}

// Its parameters, and what there is to say about it.
CoreResult completed(CoreResult result, const LoadedShape& shape, Context* context) {
  constexpr double kMostOfTheShape = 0.9;
  const AxisOptions& options = result.options;
  if (options.pruning.measure == kLambda && result.reconstructed < kMostOfTheShape)
    note(context, fmt::format("the balls of the pruned core contain only {:.4f} of the shape; use a smaller lambda, or "
                              "'auto'",
                              result.reconstructed));
  result.parameters =
      with_parameters(shape.parameters, {{std::string(options.pruning.measure), text_of(options.pruning.threshold)},
                                         {"lambda_rule", std::string(name_of(options.rule))}});
  return result;
}

/// Throws Error(failed) when neither way fits; notes the slower one.
void check_plan(const CorePlan& plan, const LoadedShape& shape, Context* context) {
  const std::int64_t before = context && context->memory_limit > 0 ? plan.held : 0;
  std::string what = fmt::format("the medial axis of a shape with {}",
                                 base::counted(plan.sites, "boundary vertex", "boundary vertices"));
  if (plan.in_bricks) what += fmt::format(", in bricks ({} at once),", base::bytes_text(before + plan.at_once));
  require_memory(before + plan.bytes(), what,
                 shape.from_mesh || shape.polygon ? std::vector<std::string>{"a lower resolution"}
                 : shape.shape.grid().is_plane()
                     ? std::vector<std::string>{"a smaller or coarser image", "a part of it"}
                     : std::vector<std::string>{"a smaller or coarser volume", "a part of it"},
                 context);
  if (plan.in_bricks)
    note(context,
         fmt::format("{} boundary vertices are worked on in bricks: about {} of memory instead of {}", plan.sites,
                     base::bytes_text(plan.held + plan.bytes()), base::bytes_text(plan.held + plan.at_once)));
}

}  // namespace

void require_topology(const Topology& got, const Topology& wanted, const char* what, const char* whose) {
  if (got == wanted) return;
  throw Error(
      ErrorCode::invariant,
      fmt::format("the topology of the {} (Betti numbers {}, {}, {}) is not that of the {} ({}, {}, {}); this is "
                  "a bug in Quench, please report it with the input",
                  what, got.betti[0], got.betti[1], got.betti[2], whose, wanted.betti[0], wanted.betti[1],
                  wanted.betti[2]));
}

CoreResult core_of(const LoadedShape& shape, const AxisOptions& options, Context* context) {
  if (!options.pruning.threshold) pruning_of(options.pruning.measure, "auto", "prune_by");
  return base::in_arena(context, [&] {
    CorePlan plan = plan_core(shape.shape, context);
    plan.in_bricks = options.bricks_in || (plan.in_bricks && refused_in_bricks(shape.shape, options).empty());
    check_plan(plan, shape, context);
    CoreResult result;
    if (plan.in_bricks) {
      result =
          core_in_bricks(shape, options, options.bricks_in.value_or(std::filesystem::temp_directory_path()), context);
    } else {
      MedialAxis core = voxel_core(shape.shape, {.rule = options.rule}, context);
      result = completed(result_of({std::move(core)}, shape, options, context), shape, context);
    }
    result.plan = plan;
    return result;
  });
}

CoreResult core_of_part(dual::bricks::Part&& part, const dual::Hulls& hulls, const LoadedShape& from,
                        const AxisOptions& options, Context* context) {
  return base::in_arena(context, [&] {
    axis::RestOfCore rest =
        axis::rest_of(std::move(part), hulls, from.shape.grid(), options.rule, from.surface.has_value(), context);
    return completed(result_of(std::move(rest), from, options, context), from, context);
  });
}

CoreResult pruned_further(const LoadedShape& shape, const CoreResult& core, const Length& threshold, Context* context) {
  const std::string measure(core.options.pruning.measure);
  const double least = shape.scale().resolve(threshold, measure);
  if (least < core.threshold)
    throw Error(ErrorCode::usage,
                fmt::format("{0} '{1}' is below {2}, which the medial axis was pruned with already; compute it with "
                            "{0} 0",
                            measure, text_of(threshold), core.threshold),
                measure);
  CoreResult result = core;
  result.axis = base::in_arena(context, [&] { return pruned(core.axis, least, measure); });
  result.options.pruning.threshold = threshold;
  result.threshold = least;
  require_topology(topology(result.axis.complex), core.topology, "pruned core", "shape");
  result.reconstructed = Reconstruction(shape.shape, result.axis, Reconstruction::kSamples, context, measure).share(0);
  if (measure == kDetail) result.coverage = coverage(shape.shape, result.axis, context);
  result.kept = counts_of(result.axis.complex);
  result.parameters = with_parameters(core.parameters, {{measure, text_of(threshold)}});
  return result;
}

namespace {

Record core_file(Record data, const CoreResult& core) {
  const bool plane = find_array(data.field_data, "dimension") != nullptr;
  const bool full = core.options.full;
  const std::string measure(core.options.pruning.measure);
  const double threshold = std::min(core.threshold, kInfiniteLevelInFiles);
  const Topology& t = core.topology;
  add_field(data, "stage", std::string("core"));
  add_field(data, measure.c_str(), full ? 0.0 : threshold);
  add_field(data, (measure + "_chosen").c_str(), threshold);
  add_field(data, "lambda_rule", std::string(name_of(core.options.rule)));
  add_field(data, "longest_side", core.longest_side);
  add_field(data, "reconstructed", full ? core.whole.value_or(core.reconstructed) : core.reconstructed);
  if (measure == kDetail && !full) add_field(data, "coverage", core.coverage);
  data.field_data.push_back({"euler", 1, std::vector<std::int64_t>{t.euler}});
  data.field_data.push_back({"betti", 3, std::vector<std::int64_t>(t.betti.begin(), t.betti.end())});
  add_field(data, "units", core.coordinates.units);
  if (!core.coordinates.space.empty()) add_field(data, "SPACE", core.coordinates.space);  // the name Slicer looks for
  if (plane) add_field(data, "y_axis", std::string(core.coordinates.y_down ? "down" : "up"));
  add_field(data, "parameters", core.parameters);
  add_field(data, "version", std::string(QUENCH_VERSION));
  return data;
}

}  // namespace

Record core_file(const CoreResult& core) { return core_file(to_record(core.axis), core); }

Record core_file(CoreResult&& core) { return core_file(to_record(std::move(core.axis)), core); }

}  // namespace quench::pipeline
