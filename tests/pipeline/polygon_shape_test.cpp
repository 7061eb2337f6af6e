// SPDX-License-Identifier: Apache-2.0
// What a polygon in one piece becomes: one piece, with its own holes.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "quench/axis.h"
#include "quench/pipeline.h"

namespace quench {
namespace polygon_shape_test {

PolygonFeature polygon(std::vector<std::vector<Vec2>> rings) {
  PolygonFeature feature;
  feature.polygons.rings = std::move(rings);
  return feature;
}

struct Made {
  pipeline::LoadedShape shape;
  std::vector<std::string> notes;
};

Made made(PolygonFeature feature, std::int64_t resolution) {
  Made result;
  Context context;
  context.note = [&](const std::string& sentence) { result.notes.push_back(sentence); };
  pipeline::ShapeOptions options;
  options.resolution = resolution;
  result.shape = pipeline::shape_of(std::move(feature), options, &context);
  return result;
}

TEST(PolygonShape, SharpTipsDoNotBreakOff) {
  // A needle: its far pixels are thinner than a pixel and fall apart.
  const Made needle = made(polygon({{{0, 0}, {100, 37}, {0, 5}}}), 60);
  EXPECT_EQ(needle.shape.topology.betti[0], 1);
  DigitizeOptions how;
  how.resolution = 60;
  ASSERT_GT(topology(digitize({{{{0, 0}, {100, 37}, {0, 5}}}}, how)).betti[0], 1);  // without
  ASSERT_EQ(needle.notes.size(), 1u);
  EXPECT_NE(needle.notes[0].find("left out"), std::string::npos) << needle.notes[0];
}

TEST(PolygonShape, NarrowInletsLeaveNoHoles) {
  // A square with a slanted wedge cut in from below, which closes above its tip in steps, and a hole that is its own.
  int checked = 0;
  for (int i = 0; i < 40; ++i) {
    const double tip = 60 + 0.37 * i;
    const std::vector<std::vector<Vec2>> rings{
        {{0, 0}, {40, 0}, {tip, 80}, {41.2, 0}, {100, 0}, {100, 100}, {0, 100}},
        {{10, 40}, {30, 40}, {30, 60}, {10, 60}}};
    DigitizeOptions how;
    how.resolution = 75;
    const bool broken = topology(digitize({rings}, how)).betti[1] > 1;
    const Made square = made(polygon(rings), 75);
    EXPECT_EQ(square.shape.topology.betti, (std::array<std::int64_t, 3>{1, 1, 0})) << i;
    EXPECT_EQ(square.notes.empty(), !broken) << i;
    checked += broken;
  }
  EXPECT_GT(checked, 5);
}

// `skeleton` of a file is that of the run which wrote it, MGF included.
TEST(PolygonShape, SkeletonsOfFilesHaveTheSameMeasures) {
  Made star = made(polygon({{{0, 0}, {30, 10}, {60, 0}, {50, 30}, {60, 60}, {30, 50}, {0, 60}, {10, 30}}}), 100);
  const pipeline::RunResult run = pipeline::run(star.shape);
  Record file = pipeline::core_file(run.core);
  const pipeline::LoadedAxis loaded = pipeline::axis_of(std::move(file), "core.vtp");
  ASSERT_TRUE(loaded.sites);
  pipeline::RunOptions options;
  options.graph.voxel = loaded.spacing;
  options.graph.sites = &*loaded.sites;
  const pipeline::AxisRun again =
      pipeline::run_axis(loaded.axis, Record(loaded.data), true, run.core.topology, loaded.scale, options);
  ASSERT_EQ(again.graph.branches.size(), run.axis.graph.branches.size());
  for (std::size_t b = 0; b < again.graph.branches.size(); ++b) {
    EXPECT_FALSE(again.graph.branches[b].mgf.empty());
    EXPECT_EQ(again.graph.branches[b].mgf.size(), run.axis.graph.branches[b].mgf.size());
    EXPECT_NEAR(again.graph.branches[b].length, run.axis.graph.branches[b].length, 1);
  }
}

}  // namespace polygon_shape_test
}  // namespace quench
