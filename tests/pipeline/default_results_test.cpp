// SPDX-License-Identifier: Apache-2.0
// What default options must give on shapes whose axis everybody knows.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>

#include "full_run.h"
#include "quench/axis.h"
#include "quench/pipeline.h"
#include "quench/samples.h"
#include "random_shapes.h"

namespace quench::pipeline {
namespace default_results_test {

struct Curves {
  std::size_t branches = 0, ends = 0;
};

Curves pure_curves(LoadedShape shape, const std::optional<Length>& theta1 = {}) {
  RunOptions options;
  options.skeleton.theta1 = theta1;
  options.skeleton.theta2 = Length{std::numeric_limits<double>::infinity(), Length::Unit::infinite};
  const CurveGraph graph = run(shape, options).axis.graph;
  Curves curves{graph.branches.size(), 0};
  for (const auto& node : graph.nodes) curves.ends += node.kind == CurveGraph::NodeKind::end;
  return curves;
}

LoadedShape sample(const char* name, std::int64_t resolution) {
  return shape_of(make_sample(name, {}).mesh, {.resolution = resolution});
}

TEST(DefaultResults, PureCurvesAreThoseThatEverybodyKnows) {
  for (const std::int64_t resolution : {64, 128}) {
    SCOPED_TRACE(resolution);
    // The corners of a box stick out of its tube by less than half a burn time.
    const Curves box = pure_curves(sample("box", resolution), parse_theta1("2%"));
    EXPECT_EQ(box.branches, 13u);
    EXPECT_EQ(box.ends, 8u);
    if (resolution == 128 && !full_run()) break;
    EXPECT_EQ(pure_curves(sample("box", resolution)).branches, 1u);
    const Curves ellipsoid = pure_curves(sample("ellipsoid", resolution));
    EXPECT_EQ(ellipsoid.branches, 1u);
    EXPECT_EQ(ellipsoid.ends, 2u);
    const Curves torus = pure_curves(sample("torus", resolution));
    EXPECT_EQ(torus.branches, 1u);
    EXPECT_EQ(torus.ends, 0u);
    EXPECT_LE(pure_curves(sample("bumpy-sphere", resolution)).branches, 1u);
  }
}

// A hollow ball with a tube: the curve of the tube ends on the closed pocket around the cavity, where no fire comes.
TEST(DefaultResults, ALimbOnAPocketIsABranch) {
  for (const bool hollow : {false, true}) {
    Grid grid;
    grid.dims = {40, 40, 80};
    const auto inside = [&](int x, int y, int z) {
      const double r = std::hypot(x - 20, y - 20), distance = std::hypot(r, z - 20);
      if (distance < 16) return !hollow || distance > 9;
      return r < 3.3 && z > 20 && z < 78;
    };
    LoadedShape shape = shape_of(testing_shapes::from_predicate(grid, inside), grid, {});
    const RunResult result = run(shape);
    const auto& branches = result.axis.graph.branches;
    const auto limbs = std::count_if(branches.begin(), branches.end(), [](const auto& b) { return b.length > 35; });
    EXPECT_EQ(limbs, 1) << (hollow ? "hollow" : "solid");
  }
}

// Square tubes, straight and with an elbow. At four voxels the outer corner of the elbow is a branch.
TEST(DefaultResults, TubesAreOneBranch) {
  for (const int width : {2, 3, 4, 5})
    for (const bool bent : {false, true}) {
      if (width == 4 && bent) continue;
      Grid grid;
      grid.dims = {60, 40, 12};
      const auto inside = [&](int x, int y, int z) {
        if (z < 3 || z >= 3 + width) return false;
        const bool along = x >= 4 && x < 50 && y >= 10 && y < 10 + width;
        const bool elbow = x >= 50 - width && x < 50 && y >= 10 && y < 36;
        return along || (bent && elbow);
      };
      const Curves curves = pure_curves(shape_of(testing_shapes::from_predicate(grid, inside), grid, {}));
      EXPECT_EQ(curves.branches, 1u) << width << (bent ? " bent" : "");
      EXPECT_EQ(curves.ends, 2u) << width << (bent ? " bent" : "");
    }
}

double area_of_fin(const std::vector<Vec3>& points, const CellComplex& complex) {
  double area = 0;
  for (std::size_t f = 0; f < complex.face_count(); ++f) {
    const auto corners = complex.corners(f);
    const auto in_fin = [&](std::uint32_t v) {
      return points[v][2] > 0.22 && std::abs(points[v][1]) < 0.03 && points[v][0] < 0.16;
    };
    if (!std::ranges::all_of(corners, in_fin)) continue;
    for (std::size_t i = 2; i < corners.size(); ++i) {
      const Vec3 a = points[corners[i - 1]] - points[corners[0]], b = points[corners[i]] - points[corners[0]];
      area += 0.5 * a.cross(b).norm();
    }
  }
  return area;
}

// The fin of the board is 0.9 x 0.5, 0.04 thick: less than two voxels at 64.
TEST(DefaultResults, TheFinIsASheet) {
  for (const std::int64_t resolution : full_run() ? std::vector{64, 128, 256} : std::vector{64, 128}) {
    LoadedShape board = sample("fin-on-board", resolution);
    const RunResult result = run(board);
    EXPECT_GT(area_of_fin(result.core.axis.points, result.core.axis.complex), 0.8 * 0.45) << resolution;
    const Skeleton& skeleton = result.axis.skeleton.skeleton;
    EXPECT_GT(area_of_fin(skeleton.points, skeleton.complex), 0.45 * 0.45) << resolution;  // theta2 takes the rim
    EXPECT_LE(result.core.coverage, 2 * auto_detail(board.shape.grid()) * (1 + 1e-9)) << resolution;
  }
}

}  // namespace default_results_test
}  // namespace quench::pipeline
