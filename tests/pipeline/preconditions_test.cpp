// SPDX-License-Identifier: Apache-2.0
// What a caller of the library may get wrong is answered by a sentence or by what it means, never by undefined
// behaviour, an endless loop or a wrong result.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "quench/axis.h"
#include "quench/burn.h"
#include "quench/error.h"
#include "quench/graph.h"
#include "quench/page.h"
#include "quench/skeleton.h"
#include "random_shapes.h"

namespace quench {
namespace preconditions_test {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

template <class Use>
void expect_refused(const Use& use, const char* part) {
  try {
    use();
    ADD_FAILURE() << "not refused: " << part;
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::usage) << error.what();
    EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
  }
}

MedialAxis axis_with_levels() {
  MedialAxis axis = voxel_core(testing_shapes::box_shape(7, 5, 4));
  prune_levels(axis);
  return axis;
}

TEST(Preconditions, ASegmentFarAwayOrNowhereIsNotInTheShape) {
  const VoxelShape shape = testing_shapes::box_shape(5, 5, 5);
  const Vec3 middle(3, 3, 3);
  ASSERT_TRUE(contains_segment(shape, middle, {5, 4, 3}));
  for (const double far : {1e9, 1e19, 1e300, -1e300, kInfinity, -kInfinity, kNan})
    for (int a = 0; a < 3; ++a) {
      Vec3 end = middle;
      end[a] = far;
      EXPECT_FALSE(contains_segment(shape, middle, end)) << far;
      EXPECT_FALSE(contains_segment(shape, end, middle)) << far;
      EXPECT_FALSE(contains_segment(shape, end, end)) << far;
    }
}

TEST(Preconditions, AComplexThatWasMovedAwayIsEmpty) {
  MedialAxis axis = axis_with_levels();
  const CellComplex taken = std::move(axis.complex);
  EXPECT_GT(taken.face_count(), 0u);
  EXPECT_EQ(axis.complex.face_count(), 0u);  // NOLINT: what is left is what is asked
  MedialAxis written = axis_with_levels();
  EXPECT_GT(to_record(std::move(written)).poly_count(), 0u);
  EXPECT_EQ(written.complex.face_count(), 0u);  // NOLINT: as above
}

TEST(Preconditions, VerticesFarFromAGridAreRefusedAndBallsAreClipped) {
  std::vector<std::uint8_t> memory(125, 0);
  const MaskView mask{{5, 5, 5}, {1, 5, 25}, memory.data()};
  const CellComplex line = make_complex(2, std::vector<std::array<std::uint32_t, 2>>{{0, 1}}, {0}, {});
  for (const double far : {1e300, -1e300, kInfinity, kNan})
    expect_refused([&] { mark_cells(line, std::vector<Vec3>{{1, 1, 1}, {1, far, 1}}, Grid(), mask); }, "vertex 1");
  EXPECT_EQ(std::count(memory.begin(), memory.end(), 1), 0);
  for (const double far : {1e300, kInfinity, kNan}) {
    mark_balls(std::vector<Vec3>{{far, 1, 1}, {1, far, 1}, {1, 1, far}}, std::vector<double>{1, 1, 1}, Grid(), mask);
    mark_balls(std::vector<Vec3>{{1, 1, 1}}, std::vector<double>{kNan}, Grid(), mask);
  }
  EXPECT_EQ(std::count(memory.begin(), memory.end(), 1), 0);
  mark_balls(std::vector<Vec3>{{1, 1, 1}}, std::vector<double>{kInfinity}, Grid(), mask);
  EXPECT_EQ(std::count(memory.begin(), memory.end(), 1), 125);
}

TEST(Preconditions, LevelsAndLambdasAreThereForAllCells) {
  const MedialAxis axis = axis_with_levels();
  MedialAxis wrong = axis;
  wrong.measure().value.edge.pop_back();
  expect_refused([&] { prune_levels(wrong); }, "lambda");
  expect_refused([&] { to_record(wrong); }, "lambda");
  for (const double lambda : {-1.0, kNan}) {
    wrong = axis;
    wrong.measure().value.face.back() = lambda;
    expect_refused([&] { prune_levels(wrong); }, "lambda");
  }
  wrong = axis;
  wrong.measure().level.vertex.clear();
  Page page;
  expect_refused([&] { add_core(page, wrong, {}, 1000); }, "level");
  expect_refused([&] { to_record(wrong); }, "level");
  wrong = axis;
  wrong.measure().level.face.back() = kNan;
  expect_refused([&] { add_core(page, wrong, {}, 1000); }, "level");
  expect_refused([&] { add_core(page, axis, {{"short", 1, std::vector<double>{1}}}, 1000); }, "'short'");
  wrong = axis;
  wrong.radius.pop_back();
  expect_refused([&] { to_record(wrong); }, "radius");
}

TEST(Preconditions, LevelsOfAnotherAxisAreNotTaken) {
  const MedialAxis axis = axis_with_levels();
  Record data = to_record(axis);
  const auto expect_unchanged = [&](const Record& other) {
    MedialAxis read = medial_axis_of(data);
    EXPECT_FALSE(take_levels(read, other));
    EXPECT_TRUE(read.measures.empty());
  };
  const auto with = [&](const auto& change) {
    Record other = data;
    change(other);
    for (DataArray& array : other.cell_data)
      if (array.name == "lambda_level") array.values = std::vector<double>(other.cell_count(), 1.0);
    return other;
  };
  const auto last = static_cast<std::uint32_t>(data.points.size() - 1);
  expect_unchanged(with([&](Record& d) { d.lines.push_back({0, last + 1}); }));
  expect_unchanged(with([&](Record& d) { d.lines.push_back({last, last + 7}); }));
  expect_unchanged(with([&](Record& d) { d.verts.push_back(last + 1); }));
  Record shorter = with([](Record&) {});
  for (DataArray& array : shorter.cell_data)
    if (array.name == "lambda_level") array.values = std::vector<double>(1, 1.0);
  expect_unchanged(shorter);
  for (const double level : {kNan, -1.0}) {
    Record no_levels = with([](Record&) {});
    for (DataArray& array : no_levels.cell_data)
      if (array.name == "lambda_level") std::get<std::vector<double>>(array.values).back() = level;
    expect_unchanged(no_levels);
  }
  MedialAxis read = medial_axis_of(data);
  EXPECT_TRUE(take_levels(read, with([](Record&) {})));
}

TEST(Preconditions, ThresholdsAndPointsAreNumbers) {
  const MedialAxis axis = axis_with_levels();
  expect_refused([&] { static_cast<void>(pruned(axis, kNan)); }, "lambda");
  const Burning burning = burn(axis.complex, axis.points, axis.radius);
  const SkeletonFamily family = skeletons(quench_curves(axis.complex, axis.points, axis.radius, burning));
  expect_refused([&] { extract(family, kNan, 1); }, "theta2");
  expect_refused([&] { extract(family, 1, kNan); }, "theta1");
  expect_refused([&] { extract(family, 1, 1, {.parts = false, .regrow_tips_above = kNan}); }, "tips");

  std::vector<Vec3> points = axis.points;
  points.pop_back();
  EXPECT_THROW(predicted_burn_bytes(axis.complex, points, {.omega = 1}), Error);
  EXPECT_THROW(default_omega(axis.complex, points), Error);

  CurveGraph graph = curve_graph(extract(family, kInfinity, 0));
  ASSERT_FALSE(graph.branches.empty());
  const SmoothOptions options{.iterations = 1};
  CurveGraph wrong = graph;
  wrong.branches[0].points[1][0] = kNan;
  expect_refused([&] { smoothed(wrong, options); }, "finite");
  wrong = graph;
  wrong.branches[0].radius.pop_back();
  expect_refused([&] { smoothed(wrong, options); }, "radius");
}

// Bricks allow 2^32 sites: more than 32 bits with a sign hold.
TEST(Preconditions, SitesBeyondTwoBillionAreWrittenAsTheyAre) {
  MedialAxis axis = axis_with_levels();
  const auto written = [&](const char* name) { return *find_array(to_record(axis).cell_data, name); };
  EXPECT_TRUE(std::holds_alternative<std::vector<std::int32_t>>(written("site_b").values));
  axis.face_sites.back()[1] = 3'000'000'000;
  EXPECT_EQ(written("site_b").numbers().back(), 3e9);
  EXPECT_EQ(written("site_a").numbers().back(), axis.face_sites.back()[0]);
}

}  // namespace preconditions_test
}  // namespace quench
