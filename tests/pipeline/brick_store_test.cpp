// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "full_run.h"
#include "pipeline/brick_files.h"
#include "quench/bricks.h"
#include "quench/error.h"
#include "quench/io.h"
#include "quench/samples.h"
#include "random_shapes.h"
#include "temporary_folder.h"

// Bricks: the plan, what is stored, and that the way from one to the other does not matter.

namespace quench::pipeline {
namespace brick_store_test {

using dual::bricks::Box;

LoadedShape loaded(const VoxelShape& voxels) { return shape_of(VoxelShape(voxels), voxels.grid(), {}); }

LoadedShape mesh_of(const char* sample, std::int64_t resolution) {
  ShapeOptions options;
  options.resolution = resolution;
  return shape_of(make_sample(sample, {.fineness = 0.3}).mesh, options);
}

bool same_voxels(const VoxelShape& a, const VoxelShape& b) {
  if (a.grid().dims != b.grid().dims || a.grid().origin != b.grid().origin) return false;
  for (std::int64_t z = 0; z < a.grid().dims[2]; ++z)
    for (std::int64_t y = 0; y < a.grid().dims[1]; ++y)
      if (!std::ranges::equal(a.row(y, z), b.row(y, z))) return false;
  return true;
}

std::string bytes_in(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void put_bytes(const std::filesystem::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary) << bytes;
}

std::string file_of(const CoreResult& core) {
  const TemporaryFolder folder;
  io::write_record(folder / "core.vtp", core_file(core));
  return bytes_in(folder / "core.vtp");
}

void run_all(const BrickPlan& plan, BrickStore& store) {
  for (std::size_t round = 0; round < plan.rounds.size(); ++round)
    for (std::size_t brick = 0; brick < plan.rounds[round].bricks.size(); ++brick)
      run_brick(plan, round, brick, store, nullptr);
}

TEST(BrickPlan, EverySiteLiesInOneBoxOfEveryRound) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const LoadedShape shape = loaded(testing_shapes::random_shape(seed, 24, seed % 2 == 1));
    const std::vector<LatticePoint> sites = boundary_vertices(shape.shape);
    const BrickPlan plan = plan_of(shape, {}, 4, nullptr, {2, 2, 1});
    for (std::size_t round = 0; round < plan.rounds.size(); ++round) {
      std::size_t all = 0;
      for (std::size_t b = 0; b < plan.rounds[round].bricks.size(); ++b) {
        const Box box = plan.box(round, b);
        const auto inside = std::ranges::count_if(sites, [&](const LatticePoint& p) { return box.contains(p); });
        EXPECT_EQ(inside, plan.rounds[round].bricks[b].sites) << "seed " << seed;
        EXPECT_GT(inside, 0);
        all += static_cast<std::size_t>(inside);
        if (round == 0) continue;
        std::int64_t below = 0;
        for (const std::size_t child : plan.below(round, b)) below += plan.rounds[round - 1].bricks[child].sites;
        EXPECT_EQ(below, inside);
      }
      EXPECT_EQ(all, sites.size());
    }
    const std::size_t last = plan.rounds.back().bricks.size();
    EXPECT_TRUE(last > 1 || plan.rounds.size() == 1);
  }
}

TEST(BrickPlan, FindsTheBricksThatTouchABox) {
  const BrickPlan plan = plan_of(mesh_of("torus", 60), {}, 8, nullptr, {2, 2, 1});
  std::mt19937 random(1);
  const auto between = [&](int low, int high) {
    return std::int64_t{std::uniform_int_distribution(low, high)(random)};
  };
  for (int i = 0; i < 200; ++i) {
    Box box;
    for (std::size_t a = 0; a < 3; ++a) {
      box.low[a] = between(-10, 70);
      box.high[a] = box.low[a] + between(1, 40);
    }
    std::vector<std::size_t> expected;
    for (std::size_t b = 0; b < plan.rounds[0].bricks.size(); ++b) {
      const Box other = plan.box(0, b);
      bool touches = true;
      for (std::size_t a = 0; a < 3; ++a) touches = touches && box.low[a] < other.high[a] && other.low[a] < box.high[a];
      if (touches) expected.push_back(b);
    }
    EXPECT_EQ(plan.bricks_in(0, box), expected);
  }
}

TEST(BrickPlan, RefusesWhatCannotBe) {
  const LoadedShape shape = loaded(testing_shapes::box_shape(4, 4, 4));
  AxisOptions full, automatic;
  full.full = true;
  automatic.pruning = {kLambda, {}};
  EXPECT_THROW(plan_of(shape, full, 8, nullptr), Error);
  EXPECT_THROW(plan_of(shape, automatic, 8, nullptr), Error);
}

TEST(ShapeFiles, GiveTheVoxelsOfEveryBox) {
  const TemporaryFolder folder;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const VoxelShape shape = testing_shapes::random_shape(seed, 30, seed % 2 == 1);
    const auto& dims = shape.grid().dims;
    const ShapeFiles files{
        folder.path(), shape.grid(), {3 + static_cast<int>(seed % 5), 1 + static_cast<int>(seed % 7)}};
    std::vector<std::uint32_t> sums;
    for (std::size_t layer = 0; layer < files.count(); ++layer)
      put_bytes(files.file(layer), files.encoded(shape, layer, sums.emplace_back()));
    std::atomic<std::int64_t> read{0};
    EXPECT_TRUE(same_voxels(files.voxels({{0, 0, 0}, dims}, sums, read), shape));
    std::mt19937 random(static_cast<unsigned>(seed));
    for (int i = 0; i < 20; ++i) {
      Box box;
      for (std::size_t a = 0; a < 3; ++a) {
        box.low[a] = static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(dims[a]));
        box.high[a] =
            box.low[a] + 1 + static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(dims[a] - box.low[a]));
      }
      EXPECT_TRUE(same_voxels(files.voxels(box, sums, read), cut(shape, box))) << "seed " << seed;
    }
    EXPECT_GT(read, 0);
  }
}

TEST(ShapeFiles, AreCheckedWhenRead) {
  const TemporaryFolder folder;
  const VoxelShape shape = testing_shapes::random_shape(5, 20);
  const ShapeFiles files{folder.path(), shape.grid(), {6, 100}};
  std::vector<std::uint32_t> sums(1);
  const std::string bytes = files.encoded(shape, 0, sums[0]);
  const Box all{{0, 0, 0}, shape.grid().dims};
  std::atomic<std::int64_t> read{0};
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    std::string damaged = bytes;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x21);
    put_bytes(files.file(0), damaged);
    EXPECT_THROW(files.voxels(all, sums, read), Error) << "byte " << i;
    put_bytes(files.file(0), bytes.substr(0, i));
    EXPECT_THROW(files.voxels(all, sums, read), Error) << "cut off at " << i;
  }
}

// Parts that are read and written again are the same; damaged ones are refused.
TEST(PartBytes, ComeBackAsTheyWere) {
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    const LoadedShape shape = loaded(testing_shapes::random_shape(seed, 20, seed % 3 == 1));
    const BrickPlan plan = plan_of(shape, {}, 6, nullptr, {2, 2, 1});
    MemoryBrickStore store(plan, shape);
    run_all(plan, store);
    for (std::size_t round = 0; round < plan.rounds.size(); ++round)
      for (std::size_t brick = 0; brick < plan.rounds[round].bricks.size(); ++brick) {
        dual::Hulls hulls;
        const auto label = plan.label(round, brick);
        const std::string bytes = store.part(round, brick);
        const dual::bricks::Part part = dual::bricks::decode(bytes, hulls, label);
        EXPECT_TRUE(dual::bricks::encode(part, hulls, label) == bytes) << "seed " << seed;
        const auto loose = dual::bricks::decode_loose(
            std::string_view(bytes).substr(0, dual::bricks::loose_bytes(bytes, label)), label);
        EXPECT_TRUE(loose.unfinished.sites == unfinished(part, hulls).sites && loose.pending == part.pending);
        EXPECT_TRUE(loose.unfinished.corners == unfinished(part, hulls).corners);
        EXPECT_THROW(dual::bricks::decode(bytes, hulls, plan.label(round, brick + 1)), Error);
      }
  }
}

TEST(PartBytes, AreRefusedWhenDamaged) {
  const LoadedShape shape = loaded(testing_shapes::random_shape(6, 9));
  const BrickPlan plan = plan_of(shape, {}, 8, nullptr, {2, 2, 1});
  MemoryBrickStore store(plan, shape);
  run_all(plan, store);
  const std::string bytes = store.part(0, 0);
  dual::Hulls hulls;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    std::string damaged = bytes;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x40);
    EXPECT_THROW(dual::bricks::decode(damaged, hulls, plan.label(0, 0)), Error) << "byte " << i;
    EXPECT_THROW(dual::bricks::decode(bytes.substr(0, i), hulls, plan.label(0, 0)), Error) << "cut off at " << i;
  }
}

void expect_same_core(const LoadedShape& shape, const AxisOptions& options, std::int64_t size,
                      const std::string& what) {
  const std::string whole = file_of(core_of(shape, options));
  const BrickPlan plan = plan_of(shape, options, size, nullptr, {2, 2, 1});
  MemoryBrickStore store(plan, shape);
  run_all(plan, store);
  EXPECT_TRUE(file_of(merge_bricks(plan, shape, store, nullptr)) == whole) << what;
}

AxisOptions pruned_by(std::string_view measure, const char* threshold) {
  AxisOptions options;
  options.pruning = {measure, parse_length(threshold, measure)};
  return options;
}

TEST(Bricks, MakeTheCoreOfRandomShapes) {
  const std::vector<AxisOptions> options{
      {}, pruned_by(kLambda, "1vox"), pruned_by(kDetail, "0"), pruned_by(kDetail, "3vox")};
  const std::uint64_t seeds = repeats(48, 24);
  for (std::uint64_t seed = 0; seed < seeds; ++seed)
    expect_same_core(loaded(testing_shapes::random_shape(seed, 26, seed % 3 == 1)), options[seed % options.size()],
                     4 + static_cast<std::int64_t>(seed % 5), "seed " + std::to_string(seed));
}

TEST(Bricks, MakeTheCoreOfMeshes) {
  for (const char* sample : {"torus", "rippled-box", "hollow-sphere"})
    for (const std::int64_t size : {8, 20}) expect_same_core(mesh_of(sample, 48), {}, size, sample);
}

// What tasks write depends neither on threads nor on where it is kept.
TEST(Bricks, AreTheSameInFoldersAndOnAnyThreads) {
  const LoadedShape shape = mesh_of("torus", 48);
  const TemporaryFolder folder;
  std::map<std::string, std::string> first;
  for (const int threads : {1, 3}) {
    const std::filesystem::path work = folder / std::to_string(threads);
    Context context;
    context.threads = threads;
    EXPECT_EQ(plan_bricks(shape, {}, 8, work, "{}", &context).rounds.size(), 2u);
    run_bricks(work, {}, {}, &context);
    for (const auto& entry : std::filesystem::recursive_directory_iterator(work)) {
      if (!entry.is_regular_file() || (entry.path().extension() == ".json" && entry.path().filename() != "plan.json"))
        continue;
      const std::string name = entry.path().lexically_relative(work).string(), bytes = bytes_in(entry.path());
      EXPECT_TRUE(first.emplace(name, bytes).first->second == bytes) << name;
    }
    const MergedBricks merged = merge_bricks(work, &context);
    EXPECT_TRUE(file_of(merged.core) == file_of(core_of(shape)));
  }
  EXPECT_TRUE(file_of(core_in_bricks(shape, {}, folder.path(), nullptr)) == file_of(core_of(shape)));
}

TEST(Bricks, PlansComeBackAsTheyWere) {
  const TemporaryFolder folder;
  LoadedShape shape = mesh_of("torus", 40);
  shape.coordinates = {"mm", "LPS", false, {}};
  AxisOptions options = pruned_by(kLambda, "inf");
  options.rule = LambdaRule::ball;
  plan_bricks(shape, options, 16, folder / "work", R"({"a": [1.5, "b"]})");
  const PlanFile file = read_plan(folder / "work");
  EXPECT_EQ(text_of(file), bytes_in(folder / "work" / "plan.json"));
  EXPECT_EQ(file.plan.options.rule, LambdaRule::ball);
  EXPECT_EQ(file.plan.threshold, std::numeric_limits<double>::infinity());
  const LoadedShape again = FolderBrickStore(folder / "work").shape();
  EXPECT_TRUE(same_voxels(again.shape, shape.shape));
  EXPECT_EQ(again.coordinates.units, "mm");
  EXPECT_EQ(again.topology, shape.topology);
  EXPECT_EQ(again.parameters, shape.parameters);
  EXPECT_TRUE(again.surface->mesh().points == shape.surface->mesh().points);
  EXPECT_TRUE(again.surface->mesh().triangles == shape.surface->mesh().triangles);
}

TEST(Bricks, StopWhenAsked) {
  const TemporaryFolder folder;
  plan_bricks(mesh_of("torus", 40), {}, 16, folder / "work", "{}");
  Context context;
  std::size_t done = 0;
  EXPECT_THROW(run_bricks(
                   folder / "work", {},
                   [&](const BrickDone&) {
                     if (++done == 3) context.cancel();
                   },
                   &context),
               Error);
  EXPECT_EQ(status_of_bricks(folder / "work").rounds[0].done, 3u);
}

}  // namespace brick_store_test
}  // namespace quench::pipeline
