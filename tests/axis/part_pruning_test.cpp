// SPDX-License-Identifier: Apache-2.0
// Shapes in bricks that are pruned round by round: what comes out is the core of one piece.
#include "axis/part_pruning.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "full_run.h"
#include "pipeline/bricks.h"
#include "quench/pipeline.h"
#include "quench/samples.h"
#include "random_shapes.h"

namespace quench::pipeline {
namespace part_pruning_test {

// Of all that is there, and what of it is gone before the merge.
struct Removed {
  std::size_t all = 0, gone = 0;
};

void expect_same(const CellValues& got, const CellValues& wanted) {
  EXPECT_TRUE(got.vertex == wanted.vertex);
  EXPECT_TRUE(got.edge == wanted.edge);
  EXPECT_TRUE(got.face == wanted.face);
}

void expect_same(const CoreResult& got, const CoreResult& wanted) {
  EXPECT_EQ(got.all.vertices, wanted.all.vertices);
  EXPECT_EQ(got.all.edges, wanted.all.edges);
  EXPECT_EQ(got.all.faces, wanted.all.faces);
  EXPECT_EQ(got.coverage, wanted.coverage);
  EXPECT_EQ(got.reconstructed, wanted.reconstructed);
  EXPECT_EQ(got.topology, wanted.topology);
  const MedialAxis &a = got.axis, &b = wanted.axis;
  EXPECT_TRUE(a.complex.edges == b.complex.edges);
  EXPECT_TRUE(a.complex.face_offsets == b.complex.face_offsets);
  EXPECT_TRUE(a.complex.face_vertices == b.complex.face_vertices);
  EXPECT_TRUE(a.points == b.points);
  EXPECT_TRUE(a.radius == b.radius);
  EXPECT_TRUE(a.sites == b.sites);
  EXPECT_TRUE(a.face_sites == b.face_sites);
  ASSERT_EQ(a.measures.size(), b.measures.size());
  for (std::size_t m = 0; m < a.measures.size(); ++m) {
    SCOPED_TRACE(a.measures[m].name);
    EXPECT_EQ(a.measures[m].name, b.measures[m].name);
    expect_same(a.measures[m].value, b.measures[m].value);
    expect_same(a.measures[m].level, b.measures[m].level);
  }
}

void expect_same_in_bricks(const LoadedShape& shape, const AxisOptions& options, std::int64_t size, Removed& removed) {
  SCOPED_TRACE("size " + std::to_string(size) + " by " + std::string(options.pruning.measure));
  const CoreResult wanted = core_of(shape, options);
  const BrickPlan plan = plan_of(shape, options, size, nullptr, {2, 2, 1});
  MemoryBrickStore store(plan, shape);
  for (std::size_t round = 0; round < plan.rounds.size(); ++round)
    for (std::size_t brick = 0; brick < plan.rounds[round].bricks.size(); ++brick)
      run_brick(plan, round, brick, store, nullptr);
  const std::size_t last = plan.rounds.size() - 1;
  for (std::size_t brick = 0; brick < plan.rounds[last].bricks.size(); ++brick) {
    dual::Hulls hulls;
    removed.gone += dual::bricks::decode(store.part(last, brick), hulls, plan.label(last, brick)).pruned.edges;
  }
  removed.all += wanted.all.edges - wanted.kept.edges;
  expect_same(merge_bricks(plan, shape, store, nullptr), wanted);
}

AxisOptions pruned_by(std::string_view measure, double voxels, const LoadedShape& shape,
                      LambdaRule rule = LambdaRule::coface) {
  return {{measure, world_length(voxels * shape.shape.grid().spacing.minCoeff())}, rule};
}

TEST(PartPruning, OfRandomShapes) {
  Removed removed;
  const std::uint64_t seeds = repeats(60, 40);
  for (std::uint64_t seed = 0; seed < seeds; ++seed) {
    SCOPED_TRACE(seed);
    const VoxelShape voxels = testing_shapes::random_shape(seed, seed % 5 ? 20 : 40, seed % 3 == 0);
    const LoadedShape shape = shape_of(VoxelShape(voxels), voxels.grid(), {});
    const double lengths[] = {0.4, 0.7, 1.5};
    const auto size = 4 + static_cast<std::int64_t>(seed * 7 % 13);
    expect_same_in_bricks(shape, {}, size, removed);
    expect_same_in_bricks(shape,
                          pruned_by(seed % 4 ? kDetail : kLambda, lengths[seed % 3], shape,
                                    seed % 2 ? LambdaRule::coface : LambdaRule::ball),
                          size, removed);
    if (HasFailure()) return;
  }
  EXPECT_GT(removed.gone, removed.all / 20);
}

TEST(PartPruning, OfSamples) {
  Removed removed;
  const std::int64_t resolution = repeats(64, 40);
  for (const char* name : {"ellipsoid", "bumpy-sphere"})
    for (const SurfaceKind surface : {SurfaceKind::mesh, SurfaceKind::voxels}) {
      SCOPED_TRACE(name);
      const LoadedShape shape =
          shape_of(make_sample(name, {.fineness = 0.3}).mesh, {.resolution = resolution, .surface = surface});
      for (const std::int64_t size : {std::int64_t{8}, resolution / 2}) {
        expect_same_in_bricks(shape, {}, size, removed);
        expect_same_in_bricks(shape, pruned_by(kDetail, 0.3, shape), size, removed);
        expect_same_in_bricks(shape, pruned_by(kLambda, 2, shape), size, removed);
      }
      if (HasFailure()) return;
    }
  EXPECT_GT(removed.gone, removed.all / 4);
}

}  // namespace part_pruning_test
}  // namespace quench::pipeline
