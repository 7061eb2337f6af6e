// SPDX-License-Identifier: Apache-2.0
// Context::threads binds every public function that works in parallel, without any help by the caller.
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>
#include <tbb/task_scheduler_observer.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "quench/axis.h"
#include "quench/burn.h"
#include "quench/pipeline.h"
#include "quench/samples.h"
#include "quench/skeleton.h"
#include "quench/verify.h"
#include "quench/voxelize.h"

namespace quench {
namespace threads_test {

constexpr int kThreads = 4;  // of the caller

// The threads that come to help in an arena.
class Helpers : public tbb::task_scheduler_observer {
 public:
  explicit Helpers(tbb::task_arena& arena) : tbb::task_scheduler_observer(arena) { observe(true); }
  ~Helpers() override { observe(false); }
  void on_scheduler_entry(bool is_worker) override { came_ += is_worker; }
  int came() const { return came_; }

 private:
  std::atomic<int> came_{0};
};

using Stage = std::function<void(Context*)>;

// The numbers of threads that work inside of a stage, as its progress sees them.
std::map<int, int> threads_seen(const Stage& stage, int threads) {
  std::map<int, int> seen;
  Context context;
  context.threads = threads;
  context.progress = [&](std::string_view, double) { ++seen[tbb::this_task_arena::max_concurrency()]; };
  stage(&context);
  return seen;
}

TEST(Threads, EveryStageKeepsToThoseOfItsContext) {
  const TriangleMesh mesh = make_sample("bumpy-sphere").mesh;
  const VoxelShape shape = voxelize(mesh, {.resolution = 64}).shape;
  const pipeline::LoadedShape loaded = pipeline::shape_of(VoxelShape(shape), shape.grid(), {});
  const pipeline::CoreResult core = pipeline::core_of(loaded, {.pruning = {kLambda, pipeline::world_length(2)}});
  const CellComplex& complex = core.axis.complex;
  const Burning burning = burn(complex, core.axis.points, core.axis.radius);
  const RefinedAxis refined = quench_curves(complex, core.axis.points, core.axis.radius, burning);
  const SkeletonFamily family = skeletons(refined);
  const Skeleton skeleton = extract(family, 2, 2);
  const Record file = pipeline::core_file(core);
  std::vector<std::uint8_t> mask(
      static_cast<std::size_t>(shape.grid().dims[0] * shape.grid().dims[1] * shape.grid().dims[2]));
  const MaskView view{
      shape.grid().dims, {1, shape.grid().dims[0], shape.grid().dims[0] * shape.grid().dims[1]}, mask.data()};

  const std::map<std::string, Stage> stages{
      {"voxelize", [&](Context* c) { voxelize(mesh, {.resolution = 64}, c); }},
      {"voxelize_auto", [&](Context* c) { voxelize_auto(mesh, {}, c); }},
      {"voxel_core", [&](Context* c) { voxel_core(shape, {}, c); }},
      {"prune_levels",
       [&](Context* c) {
         MedialAxis axis = core.axis;
         prune_levels(axis, c);
       }},
      {"Reconstruction", [&](Context* c) { Reconstruction(shape, core.axis, 20000, c); }},
      {"core_of", [&](Context* c) { pipeline::core_of(loaded, {}, c); }},
      {"core_of in bricks",
       [&](Context* c) { pipeline::core_of(loaded, {.bricks_in = std::filesystem::temp_directory_path()}, c); }},
      {"burn", [&](Context* c) { burn(complex, core.axis.points, core.axis.radius, {}, c); }},
      {"quench_curves", [&](Context* c) { quench_curves(complex, core.axis.points, core.axis.radius, burning, c); }},
      {"skeletons", [&](Context* c) { skeletons(refined, c); }},
      {"reconstructed_share", [&](Context* c) { pipeline::reconstructed_share(shape, skeleton, c); }},
      {"mark_balls", [&](Context* c) { mark_balls(core.axis.points, core.axis.radius, shape.grid(), view, c); }},
      {"verify", [&](Context* c) { verify(shape, file, {}, c); }},
  };
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, kThreads);
  for (const auto& [name, stage] : stages) {
    for (const int threads : {1, 3}) {
      tbb::task_arena arena(kThreads);
      const Helpers helpers(arena);
      const std::map<int, int> seen = arena.execute([&, &stage = stage] { return threads_seen(stage, threads); });
      EXPECT_EQ(seen.size(), 1u) << name;
      EXPECT_TRUE(seen.contains(threads)) << name << " works on " << (seen.empty() ? 0 : seen.begin()->first);
      EXPECT_EQ(helpers.came(), 0) << name << ": threads of the caller's arena help";
    }
    // Without a wish, those of the caller.
    const std::map<int, int> seen =
        tbb::task_arena(kThreads).execute([&, &stage = stage] { return threads_seen(stage, 0); });
    EXPECT_TRUE(seen.size() == 1 && seen.contains(kThreads)) << name;
  }
}

}  // namespace threads_test
}  // namespace quench
