// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <vector>

#include "quench/error.h"
#include "quench/pipeline.h"
#include "quench/tree.h"
#include "tube_graphs.h"

namespace quench {
namespace edited_shape_test {

using testing_tubes::Tube;
using testing_tubes::voxels_of;

struct Way {
  VoxelShape shape;
  Repaired repaired;
  VoxelShape edited;
};

// From voxels to the curves, the repair and back.
Way way_of(VoxelShape voxels, const RepairOptions& options = {}) {
  Way way;
  way.shape = voxels;
  const Grid grid = voxels.grid();
  pipeline::LoadedShape shape = pipeline::shape_of(std::move(voxels), grid, {});
  pipeline::RunOptions run;
  run.skeleton.theta2 = pipeline::parse_length("inf", "theta2");
  const CurveGraph graph = pipeline::run(shape, run).axis.graph;
  RepairOptions of_voxels = options;
  of_voxels.voxel = 1;
  way.repaired = repaired(graph, of_voxels);
  way.edited = edited_shape(way.shape, graph, way.repaired);
  return way;
}

int count(const Repaired& repaired, TreeEdit::Kind kind) {
  int n = 0;
  for (const TreeEdit& edit : repaired.edits) n += edit.kind == kind;
  return n;
}

Topology trees(std::int64_t count) { return {count, {count, 0, 0}}; }

const std::vector<Tube> kFork{{{{32, 32, 4}, {32, 32, 60}}, 5, 4}, {{{32, 32, 20}, {58, 32, 34}}, 2.5, 2}};

TEST(EditedShape, OfATreeIsTheShape) {
  const Way way = way_of(voxels_of(kFork, 64));
  EXPECT_EQ(topology(way.shape), trees(1));
  EXPECT_TRUE(way.repaired.edits.empty());
  EXPECT_EQ(topology(way.edited), trees(1));
  EXPECT_EQ(way.edited.voxel_count(), way.shape.voxel_count());
}

TEST(EditedShape, GapsAreFilled) {
  std::vector<Tube> tubes{{{{8, 32, 32}, {28, 32, 32}}, 3, 3}, {{{38, 32, 32}, {58, 32, 32}}, 3, 3}};
  const Way way = way_of(voxels_of(tubes, 64));
  EXPECT_EQ(topology(way.shape).betti[0], 2);
  EXPECT_EQ(count(way.repaired, TreeEdit::Kind::bridge), 1);
  EXPECT_EQ(topology(way.edited), trees(1));
  EXPECT_GT(way.edited.voxel_count(), way.shape.voxel_count() + 20);
}

TEST(EditedShape, LoopsAreOpened) {
  std::vector<Tube> tubes = kFork;
  tubes.push_back({{{32, 32, 46}, {50, 32, 44}, {52, 32, 29}}, 2.5, 1.6});  // its tip touches the other one
  const Way way = way_of(voxels_of(tubes, 64));
  ASSERT_EQ(topology(way.shape).betti[1], 1);
  EXPECT_EQ(way.repaired.loops_before, 1u);
  EXPECT_EQ(topology(way.edited), trees(1));
  EXPECT_GT(way.edited.voxel_count(), way.shape.voxel_count() - 60);
}

TEST(EditedShape, EveryPlantIsATree) {
  std::vector<Tube> tubes = kFork;
  tubes.push_back({{{8, 8, 8}, {8, 8, 50}}, 3, 3});
  RepairOptions options;
  options.plants = 2;
  EXPECT_EQ(topology(way_of(voxels_of(tubes, 64), options).edited), trees(2));
  options.plants = 1;
  const Way one = way_of(voxels_of(tubes, 64), options);
  EXPECT_EQ(topology(one.edited), trees(1));
  EXPECT_FALSE(one.edited.contains(8, 8, 30));  // left out
}

TEST(EditedShape, OfTwoPlantsThatTouchIsTwoTrees) {
  RepairOptions options;
  options.plants = 2;
  const Way way = way_of(
      voxels_of({{{{16, 32, 6}, {30, 32, 32}, {16, 32, 58}}, 4, 4}, {{{48, 32, 6}, {36, 32, 32}, {48, 32, 58}}, 4, 4}},
                64),
      options);
  EXPECT_EQ(topology(way.shape), trees(1));
  EXPECT_EQ(topology(way.edited), trees(2));
}

// Trees of one voxel each, corner to corner.
TEST(EditedShape, SeedsMayTouch) {
  VoxelShape shape(Grid{{4, 4, 4}});
  Repaired repaired;
  for (std::int32_t z = 0; z < 4; ++z)
    for (std::int32_t y = 0; y < 4; ++y) {
      std::vector<quench::Run> runs;
      if (y == z && (y == 1 || y == 2)) {
        runs.push_back({y, y + 1});
        CurveGraph::Node node;
        node.point = Vec3::Constant(y + 0.5);
        node.radius = 0.5;
        node.component = repaired.graph.components++;
        repaired.graph.nodes.push_back(node);
      }
      shape.append_row(runs);
    }
  EXPECT_EQ(topology(edited_shape(shape, repaired.graph, repaired)), trees(2));
}

TEST(EditedShape, IsATreeWhateverTheShape) {
  std::uint64_t state = 5;
  const auto random = [&](double low, double high) {
    state = state * 6364136223846793005ull + 1442695040888963407ull;
    return low + (high - low) * static_cast<double>(state >> 40) / static_cast<double>(1 << 24);
  };
  std::int64_t tunnels = 0;
  for (int repeat = 0; repeat < 12; ++repeat) {
    std::vector<Tube> tubes;
    for (int t = 0; t < 14; ++t) {
      const auto point = [&] { return Vec3(random(4, 35), random(4, 35), random(4, 35)); };
      tubes.push_back({{point(), point(), point()}, random(1, 3), random(1, 2)});
    }
    const Way way = way_of(voxels_of(tubes, 40));
    tunnels += topology(way.shape).betti[1];
    ASSERT_EQ(topology(way.edited), trees(1)) << repeat;
    ASSERT_EQ(way.repaired.graph.components, 1u);
    for (const CurveGraph::Branch& branch : way.repaired.graph.branches) ASSERT_GT(branch.length, 0);
  }
  EXPECT_GT(tunnels, 100);
}

TEST(EditedShape, OfAGraphWithLoopsIsRefused) {
  RepairOptions options;
  options.rule = RepairRule::off;
  std::vector<Tube> tubes{{{{8, 8, 8}, {30, 8, 8}, {30, 30, 8}, {8, 30, 8}, {8, 8, 8}}, 2, 2}};
  EXPECT_THROW(way_of(voxels_of(tubes, 40), options), Error);
}

}  // namespace edited_shape_test
}  // namespace quench
