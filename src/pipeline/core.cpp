// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <algorithm>
#include <utility>

#include "base/memory.h"
#include "base/parallel.h"
#include "base/text.h"
#include "pipeline/parameters.h"
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

CoreResult made_core(const LoadedShape& from, const AxisOptions& options, const CorePlan& plan, Context* context) {
  const VoxelShape& shape = from.shape;
  CoreResult result;
  result.options = options;
  result.plan = plan;
  result.longest_side = from.longest_side;
  result.topology = from.topology;
  result.coordinates = from.coordinates;
  MedialAxis core = voxel_core(shape, {.rule = options.rule, .in_bricks = plan.in_bricks}, context);
  // Checking the topology and thinning are work for one thread each: together they keep two busy. The topology is the
  // task, so that thinning stays on the calling thread, which alone reports progress; isolated, so that a thread that
  // waits for the initial pairs of the thinning does not begin with the topology.
  Topology found;
  tbb::task_group beside;
  beside.run([&] { found = topology(core.complex); });
  try {
    tbb::this_task_arena::isolate([&] { prune_levels(core, context); });
  } catch (...) {
    beside.cancel();
    beside.wait();
    throw;
  }
  beside.wait();
  const Reconstruction reconstruction(shape, core, Reconstruction::kSamples, context);
  const Scale scale = from.scale();
  result.lambda = options.lambda ? scale.resolve(*options.lambda, "lambda")
                                 : auto_lambda(reconstruction, scale.longest_side, scale.voxel);
  require_topology(found, from.topology, "voxel core", "shape");
  checkpoint(context, "topology", 0.5);
  result.all = counts_of(core.complex);
  result.whole = reconstruction.share(0);
  result.reconstructed = reconstruction.share(result.lambda);

  MedialAxis kept = options.full ? pruned(core, result.lambda) : pruned(std::move(core), result.lambda);
  require_topology(topology(kept.complex), from.topology, "pruned core", "shape");
  checkpoint(context, "topology", 1);
  result.kept = counts_of(kept.complex);
  result.axis = options.full ? std::move(core) : std::move(kept);
  return result;
}

/// Throws Error(failed) when neither way fits; notes the slower one.
void check_plan(const CorePlan& plan, bool from_mesh, Context* context) {
  const std::int64_t before = context && context->memory_limit > 0 ? plan.held : 0;
  std::string what = fmt::format("the medial axis of a shape with {}",
                                 base::counted(plan.sites, "boundary vertex", "boundary vertices"));
  if (plan.in_bricks) what += fmt::format(", in bricks ({} at once),", base::bytes_text(before + plan.at_once));
  require_memory(before + plan.bytes(), what,
                 from_mesh ? std::vector<std::string>{"a lower resolution"}
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
  CoreResult result = base::in_arena(context, [&] {
    const CorePlan plan = plan_core(shape.shape, context);
    check_plan(plan, shape.from_mesh, context);
    return made_core(shape, options, plan, context);
  });
  constexpr double kMostOfTheShape = 0.9;
  if (result.reconstructed < kMostOfTheShape)
    note(context, fmt::format("the balls of the pruned core contain only {:.4f} of the shape; use a smaller lambda, or "
                              "'auto'",
                              result.reconstructed));
  result.parameters = with_parameters(
      shape.parameters, {{"lambda", text_of(options.lambda)}, {"lambda_rule", std::string(name_of(options.rule))}});
  return result;
}

CoreResult pruned_further(const LoadedShape& shape, const CoreResult& core, const Length& lambda, Context* context) {
  const double least = shape.scale().resolve(lambda, "lambda");
  if (least < core.lambda)
    throw Error(ErrorCode::usage,
                fmt::format("lambda '{}' is below {}, which the medial axis was pruned with already; compute it with "
                            "lambda 0",
                            text_of(lambda), core.lambda),
                "lambda");
  CoreResult result = core;
  result.axis = base::in_arena(context, [&] { return pruned(core.axis, least); });
  result.options.lambda = lambda;
  result.lambda = least;
  require_topology(topology(result.axis.complex), core.topology, "pruned core", "shape");
  result.reconstructed = Reconstruction(shape.shape, result.axis, Reconstruction::kSamples, context).share(0);
  result.kept = counts_of(result.axis.complex);
  result.parameters = with_parameters(core.parameters, {{"lambda", text_of(lambda)}});
  return result;
}

namespace {

Record core_file(Record data, const CoreResult& core) {
  const bool full = core.options.full;
  const double lambda = std::min(core.lambda, kInfiniteLevelInFiles);
  const Topology& t = core.topology;
  add_field(data, "stage", std::string("core"));
  add_field(data, "lambda", full ? 0.0 : lambda);
  add_field(data, "lambda_chosen", lambda);
  add_field(data, "lambda_rule", std::string(name_of(core.options.rule)));
  add_field(data, "longest_side", core.longest_side);
  add_field(data, "reconstructed", full ? core.whole : core.reconstructed);
  data.field_data.push_back({"euler", 1, std::vector<std::int64_t>{t.euler}});
  data.field_data.push_back({"betti", 3, std::vector<std::int64_t>(t.betti.begin(), t.betti.end())});
  add_field(data, "units", core.coordinates.units);
  if (!core.coordinates.space.empty()) add_field(data, "SPACE", core.coordinates.space);  // the name Slicer looks for
  add_field(data, "parameters", core.parameters);
  add_field(data, "version", std::string(QUENCH_VERSION));
  return data;
}

}  // namespace

Record core_file(const CoreResult& core) { return core_file(to_record(core.axis), core); }

Record core_file(CoreResult&& core) { return core_file(to_record(std::move(core.axis)), core); }

}  // namespace quench::pipeline
