// SPDX-License-Identifier: Apache-2.0
// What a part in which all is complete gives is the core of one piece, file for file.
#include "pipeline/part_core.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>
#include <utility>

#include "full_run.h"
#include "parts_in_rounds.h"
#include "pipeline/bricks.h"
#include "quench/io.h"
#include "quench/pipeline.h"
#include "quench/samples.h"
#include "random_shapes.h"
#include "temporary_folder.h"

namespace quench::pipeline {
namespace part_core_test {

std::string bytes_of(CoreResult&& core) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder / "core.vtp";
  io::write_record(file, core_file(std::move(core)));
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void expect_same(CoreResult got, CoreResult wanted) {
  EXPECT_EQ(got.all.vertices, wanted.all.vertices);
  EXPECT_EQ(got.all.edges, wanted.all.edges);
  EXPECT_EQ(got.all.faces, wanted.all.faces);
  EXPECT_EQ(got.kept.vertices, wanted.kept.vertices);
  EXPECT_EQ(got.kept.edges, wanted.kept.edges);
  EXPECT_EQ(got.kept.faces, wanted.kept.faces);
  EXPECT_EQ(got.threshold, wanted.threshold);
  EXPECT_EQ(got.coverage, wanted.coverage);
  EXPECT_EQ(got.fit.moved, wanted.fit.moved);
  EXPECT_EQ(got.fit.mean_move, wanted.fit.mean_move);
  EXPECT_TRUE(bytes_of(std::move(got)) == bytes_of(std::move(wanted))) << "the files differ";
}

CoreResult from_unpruned_parts(const LoadedShape& shape, const AxisOptions& options, std::int64_t size) {
  testing_duals::Rounds rounds(shape.shape, {size, std::max<std::int64_t>(size / 4, 1)});
  dual::bricks::Part part = rounds.run(100);
  return core_of_part(std::move(part), rounds.hulls(), shape, options, nullptr);
}

CoreResult from_bricks(const LoadedShape& shape, const AxisOptions& options, std::int64_t size) {
  const BrickPlan plan = plan_of(shape, options, size, nullptr, {2, 2, 1});
  MemoryBrickStore store(plan, shape);
  for (std::size_t round = 0; round < plan.rounds.size(); ++round)
    for (std::size_t brick = 0; brick < plan.rounds[round].bricks.size(); ++brick)
      run_brick(plan, round, brick, store, nullptr);
  return merge_bricks(plan, shape, store, nullptr);
}

std::vector<AxisOptions> all_options(const LoadedShape& shape) {
  const double voxel = shape.shape.grid().spacing.minCoeff();
  std::vector<AxisOptions> all;
  for (const LambdaRule rule : {LambdaRule::coface, LambdaRule::ball}) {
    all.push_back({.rule = rule});
    for (const double t : {0.3, 0.6, 1.5}) all.push_back({{kDetail, world_length(t * voxel)}, rule});
    for (const double t : {0.8, 2.0}) all.push_back({{kLambda, world_length(t * voxel)}, rule});
  }
  return all;
}

void expect_same_from_parts(const LoadedShape& shape, std::int64_t size, const AxisOptions& options) {
  const CoreResult wanted = core_of(shape, options);
  expect_same(from_unpruned_parts(shape, options, size), wanted);
  expect_same(from_bricks(shape, options, size), wanted);
}

TEST(PartCore, OfRandomShapesIsThatOfOnePiece) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE(seed);
    const VoxelShape voxels = testing_shapes::random_shape(seed, 24, seed % 3 == 0);
    const LoadedShape shape = shape_of(VoxelShape(voxels), voxels.grid(), {});
    const std::vector<AxisOptions> options = all_options(shape);
    expect_same_from_parts(shape, 4 + static_cast<std::int64_t>(seed % 9), options[seed % options.size()]);
  }
}

TEST(PartCore, OfSamplesIsThatOfOnePiece) {
  std::size_t turn = 0;
  for (const char* name : {"ellipsoid", "torus", "box", "bumpy-sphere"}) {
    SCOPED_TRACE(name);
    for (const SurfaceKind surface : {SurfaceKind::mesh, SurfaceKind::voxels}) {
      SCOPED_TRACE(name_of(surface));
      const std::int64_t resolution = repeats(40, 32);
      TriangleMesh mesh = make_sample(name, {.fineness = 0.3}).mesh;
      const LoadedShape shape = shape_of(std::move(mesh), {.resolution = resolution, .surface = surface});
      ASSERT_EQ(shape.surface.has_value(), surface == SurfaceKind::mesh);
      for (const AxisOptions& options : all_options(shape))
        if (options.rule == LambdaRule::coface && (turn++ % 2 == 0 || full_run()))
          expect_same_from_parts(shape, resolution * 2 / 5, options);
      ++turn;  // the other half of the options for the next one
    }
  }
}

}  // namespace part_core_test
}  // namespace quench::pipeline
