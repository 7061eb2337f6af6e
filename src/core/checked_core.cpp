// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <algorithm>
#include <utility>

#include "base/parallel.h"
#include "quench/axis.h"
#include "quench/error.h"
#include "quench/pipeline.h"

namespace quench {
namespace {

void add_field(Record& data, const char* name, std::string text) {
  data.field_data.push_back({name, 1, std::vector<std::string>{std::move(text)}});
}
void add_field(Record& data, const char* name, double value) {
  data.field_data.push_back({name, 1, std::vector<double>{value}});
}

CheckedCore made_core(const VoxelShape& shape, const Topology& wanted, double longest_side,
                      const CheckedCoreOptions& options, Context* context) {
  CheckedCore result;
  result.options = options;
  result.longest_side = longest_side;
  result.topology = wanted;
  MedialAxis core = voxel_core(shape, {.rule = options.rule, .in_bricks = options.in_bricks}, context);
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
  result.lambda =
      options.lambda ? *options.lambda : auto_lambda(reconstruction, longest_side, shape.grid().spacing.minCoeff());
  require_topology(found, wanted, "voxel core", "shape");
  checkpoint(context, "topology", 0.5);
  result.vertices = core.complex.vertex_count;
  result.edges = core.complex.edges.size();
  result.faces = core.complex.face_count();
  result.whole = reconstruction.share(0);
  result.reconstructed = reconstruction.share(result.lambda);

  MedialAxis kept = options.full ? pruned(core, result.lambda) : pruned(std::move(core), result.lambda);
  require_topology(topology(kept.complex), wanted, "pruned core", "shape");
  checkpoint(context, "topology", 1);
  result.kept_vertices = kept.complex.vertex_count;
  result.kept_edges = kept.complex.edges.size();
  result.kept_faces = kept.complex.face_count();
  result.axis = options.full ? std::move(core) : std::move(kept);
  return result;
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

CheckedCore checked_core(const VoxelShape& shape, const Topology& wanted, double longest_side,
                         const CheckedCoreOptions& options, Context* context) {
  return base::in_arena(context, [&] { return made_core(shape, wanted, longest_side, options, context); });
}

namespace {

Record core_file(Record data, const CheckedCore& core, const Coordinates& coordinates, const std::string& parameters) {
  const bool full = core.options.full;
  const double lambda = std::min(core.lambda, kInfiniteLevelInFiles);
  const Topology& t = core.topology;
  add_field(data, "stage", std::string("core"));
  add_field(data, "lambda", full ? 0.0 : lambda);
  add_field(data, "lambda_chosen", lambda);
  add_field(data, "lambda_rule", std::string(core.options.rule == LambdaRule::ball ? "ball" : "coface"));
  add_field(data, "longest_side", core.longest_side);
  add_field(data, "reconstructed", full ? core.whole : core.reconstructed);
  data.field_data.push_back({"euler", 1, std::vector<std::int64_t>{t.euler}});
  data.field_data.push_back({"betti", 3, std::vector<std::int64_t>(t.betti.begin(), t.betti.end())});
  add_field(data, "units", coordinates.units);
  if (!coordinates.space.empty()) add_field(data, "SPACE", coordinates.space);  // the name Slicer looks for
  add_field(data, "parameters", parameters);
  add_field(data, "version", std::string(QUENCH_VERSION));
  return data;
}

}  // namespace

Record core_file(const CheckedCore& core, const Coordinates& coordinates, const std::string& parameters) {
  return core_file(to_record(core.axis), core, coordinates, parameters);
}

Record core_file(CheckedCore&& core, const Coordinates& coordinates, const std::string& parameters) {
  return core_file(to_record(std::move(core.axis)), core, coordinates, parameters);
}

}  // namespace quench
