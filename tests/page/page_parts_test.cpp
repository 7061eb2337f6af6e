// SPDX-License-Identifier: Apache-2.0
// What pages have of sheets, of the thickness of the surface and of medial meshes, read back as a browser does, and
// pictures of it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "page_reader.h"
#include "quench/error.h"
#include "quench/page.h"
#include "quench/parts.h"
#include "quench/picture.h"
#include "quench/pipeline.h"
#include "quench/sample.h"
#include "quench/simplify.h"
#include "random_shapes.h"
#include "temporary_folder.h"

namespace quench {
namespace page_parts_test {

using testing_page::Contents;
constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

Contents read_back(const Page& page) {
  const TemporaryFolder folder;
  write_page(folder / "page.html", page, "<body><!--quench-data--></body>");
  return testing_page::read_page(testing_page::bytes_of(folder / "page.html"));
}

std::array<int, 3> at(const Picture& picture, int x, int y) {
  const std::size_t i =
      3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width) + static_cast<std::size_t>(x));
  return {picture.pixels[i], picture.pixels[i + 1], picture.pixels[i + 2]};
}

/// Two squares of one sheet each, side by side: the second one is larger.
Page page_of_two_sheets() {
  Page page;
  page.side = 3;
  page.low = Vec3(-1, -1, 0);
  page.high = Vec3(2, 1, 0);
  const std::vector<float> points{-1, -1, 0, 0, -1, 0, 0, 1, 0, -1, 1, 0, 2, -1, 0, 2, 1, 0};
  page.arrays = {{"skeleton/points", 3, points},
                 {"skeleton/polygon_offsets", 1, std::vector<std::uint32_t>{0, 4, 8}},
                 {"skeleton/polygon_corners", 1, std::vector<std::uint32_t>{0, 1, 2, 3, 1, 4, 5, 2}},
                 {"skeleton/polygon_sheet", 1, std::vector<std::uint32_t>{0, 1}},
                 {"skeleton/point/radius", 1, std::vector<float>{1, 1, 1, 1, 1, 1}}};
  return page;
}

Table table_of_two_sheets() {
  Table table;
  table.rows = 2;  // the largest first, as in parts.csv
  table.columns = {{"sheet", "", "Number", std::vector<std::int64_t>{1, 0}},
                   {"area", "mm^2", "Of its polygons", std::vector<double>{4, 2}},
                   {"max_erosion", "mm", "Largest", std::vector<double>{INFINITY, kNothing}},
                   {"neighbours", "", "Sheets", std::vector<std::string>{"0", ""}}};
  return table;
}

TEST(PageParts, TheTableOfSheetsIsInTheOrderOfTheirNumbers) {
  Page page = page_of_two_sheets();
  add_sheets(page, table_of_two_sheets());
  const Contents read = read_back(page);
  EXPECT_EQ(read["sheets/sheet"], (std::vector<double>{0, 1}));
  EXPECT_EQ(read["sheets/area"], (std::vector<double>{2, 4}));
  EXPECT_TRUE(std::isnan(read["sheets/max_erosion"][0]) && std::isinf(read["sheets/max_erosion"][1]));
  const auto& columns = read.meta["columns"];
  ASSERT_EQ(columns.size(), 4u);
  EXPECT_EQ(columns[1]["table"], "sheets");
  EXPECT_EQ(columns[1]["unit"], "mm^2");
  EXPECT_EQ(columns[0]["whole"], true);
  EXPECT_EQ(columns[3]["words"][static_cast<std::size_t>(read["sheets/neighbours"][1])], "0");
}

TEST(PageParts, TablesThatDoNotFitAreRefused) {
  Page page = page_of_two_sheets();
  Table few = table_of_two_sheets(), twice = few, other = few;
  few.rows = 1;
  std::get<std::vector<std::int64_t>>(twice.columns[0].values)[0] = 0;
  other.columns[0].name = "row";
  for (const Table& table : {few, twice, other}) EXPECT_THROW(add_sheets(page, table), Error);
  Page empty;
  EXPECT_THROW(add_sheets(empty, table_of_two_sheets()), Error);
}

TEST(PageParts, PicturesHaveTheColoursOfSheets) {
  Page page = page_of_two_sheets();
  add_sheets(page, table_of_two_sheets());
  const std::string front = "&camera=0.5,0,8,0.5,0,0,0,1,0";
  const auto drawn = [&](const std::string& state) {
    page.state = state + front;
    const Picture picture = draw_page(page, {300, 200, false, false});
    return std::array{at(picture, 90, 100), at(picture, 200, 100)};
  };
  // The larger one has the first colour, blue; the other orange.
  const auto [small, large] = drawn("color=sheet");
  EXPECT_GT(large[2], large[0] + 30);
  EXPECT_GT(small[0], small[2] + 30);
  const auto [low, high] = drawn("color=sheets/area");
  EXPECT_GT(high[0], low[0] + 60);  // from purple to yellow
  EXPECT_THROW(drawn("color=sheets/neighbours"), Error);
  EXPECT_THROW(drawn("color=sheets/length"), Error);
}

TEST(PageParts, TheSurfaceHasValuesAtItsPoints) {
  const TriangleMesh box = make_sample("box", {}).mesh;
  Page page;
  page.side = 1;
  page.origin = Vec3(100, 0, 0);
  add_surface(page, box, 1000);
  const std::vector<Vec3> points = surface_points(page);
  ASSERT_GE(points.size(), 8u);
  std::vector<double> values;
  for (const Vec3& p : points) {
    double nearest = 1e9;
    for (const Vec3& q : box.points) nearest = std::min(nearest, (p - q).norm());
    EXPECT_LT(nearest, 1e-4);
    values.push_back(p.x());
  }
  values[0] = kNothing;
  add_surface_measure(page, "thickness", values);
  EXPECT_THROW(add_surface_measure(page, "other", {1, 2}), Error);
  const Contents read = read_back(page);
  const std::vector<double>& back = read["shape/point/thickness"];
  ASSERT_EQ(back.size(), values.size());
  EXPECT_TRUE(std::isnan(back[0]));
  for (std::size_t i = 1; i < back.size(); ++i) EXPECT_NEAR(back[i], values[i], 2e-3);
}

TEST(PageParts, PicturesOfTheSurfaceHideTheAxis) {
  Page page = page_of_two_sheets();
  page.arrays.push_back({"shape/points", 3, std::vector<float>{-1, -1, 0.5, 2, -1, 0.5, 2, 1, 0.5, -1, 1, 0.5}});
  page.arrays.push_back({"shape/triangles", 3, std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3}});
  add_surface_measure(page, "thickness", {0, 1, 1, 0});
  const std::string front = "&camera=0.5,0,8,0.5,0,0,0,1,0";
  const auto drawn = [&](const std::string& state) {
    page.state = state + front;
    const Picture picture = draw_page(page, {300, 200, false, false});
    return std::array{at(picture, 90, 100), at(picture, 210, 100)};
  };
  const auto [left, right] = drawn("surface=thickness");
  EXPECT_GT(right[0], left[0] + 60);
  EXPECT_EQ(drawn("surface=thickness&shapeOpacity=0.5"), drawn("color=radius"));  // glass, as ever
  EXPECT_THROW(drawn("surface=length"), Error);
}

/// A strip of triangles with a tail, which goes down to a vertex; in the middle one moves.
CollapseSequence small_sequence() {
  CollapseSequence sequence;
  MedialAxis& mesh = sequence.start;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {2, 1, 0}};
  mesh.radius = {0.5, 0.4, 0.3, 0.2, 0.1};
  const std::vector<std::array<std::uint32_t, 2>> edges{{0, 1}, {0, 2}, {1, 2}, {1, 3}, {2, 3}, {3, 4}};
  mesh.complex = make_complex(5, edges, {0, 3, 6}, {0, 1, 2, 1, 3, 2});
  sequence.steps = {{3, 4, Vec3(1.5, 1, 0), 0.15},
                    {0, 1, Vec3(0.5, 0, 0), 0.45},
                    {0, kNone, Vec3(0.4, 0, 0), 0.5},
                    {2, 3, Vec3(0.7, 1, 0), 0.2}};
  return sequence;
}

TEST(PageParts, MedialMeshesComeBack) {
  const CollapseSequence sequence = small_sequence();
  Page page;
  page.side = 2;
  add_meshes(page, sequence, {{3, 0.1, 0.2, 0.3}});
  const Contents read = read_back(page);
  EXPECT_EQ(read["simple/triangles"], (std::vector<double>{0, 1, 2, 1, 3, 2}));
  EXPECT_EQ(read["simple/edges"], (std::vector<double>{3, 4}));  // that are no sides
  EXPECT_EQ(read["simple/steps"], (std::vector<double>{3, 4, 0, 1, 0, 0, 2, 3}));
  for (std::size_t v = 0; v < 5; ++v) {
    EXPECT_NEAR(read["simple/point/radius"][v], sequence.start.radius[v], 1e-4);
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_NEAR(read["simple/points"][3 * v + k], sequence.start.points[v][static_cast<Eigen::Index>(k)], 1e-4);
  }
  for (std::size_t s = 0; s < 4; ++s) {
    EXPECT_NEAR(read["simple/step_radius"][s], sequence.steps[s].radius, 1e-4);
    EXPECT_NEAR(read["simple/step_points"][3 * s], sequence.steps[s].point[0], 1e-4);
  }
  EXPECT_EQ(read["simple/errors"].size(), 4u);
  EXPECT_EQ(read["simple/errors"][0], 3);
}

TEST(PageParts, PicturesOfMedialMeshesHaveTheVerticesAskedFor) {
  Page page;
  page.side = 2;
  add_meshes(page, small_sequence());
  const auto drawn = [&](const std::string& vertices) {
    page.state = "layer=simple&camera=1,0.5,6,1,0.5,0,0,1,0" + vertices;
    return draw_page(page, {200, 200, false, false}).pixels;
  };
  EXPECT_EQ(drawn(""), drawn("&vertices=5"));  // 200, or as many as there are
  EXPECT_EQ(drawn("&vertices=1"), drawn("&vertices=2"));
  EXPECT_NE(drawn("&vertices=5"), drawn("&vertices=4"));
  EXPECT_NE(drawn("&vertices=3"), drawn("&vertices=2"));
  page.state = "layer=simple&vertices=3";
  EXPECT_EQ(caption_of(page), std::vector<std::string>{"medial mesh of 3 vertices"});
}

// A plate of 48 x 48 x 8 voxels. The balls of its sheet touch four corners of voxels above and four below.
TEST(PageParts, ARunKnowsHowThickThingsAre) {
  Grid grid;
  grid.dims = {50, 50, 10};
  const auto inside = [](int x, int y, int z) { return x > 0 && x < 49 && y > 0 && y < 49 && z > 0 && z < 9; };
  pipeline::RunOptions options;
  options.measures = true;
  pipeline::PageBuilder builder;
  options.page = &builder;
  pipeline::LoadedShape shape =
      pipeline::shape_of(testing_shapes::from_predicate(grid, inside), grid, {.surface = SurfaceKind::voxels});
  const pipeline::RunResult result = pipeline::run(shape, options);
  ASSERT_TRUE(result.thickness && result.axis.parts);
  EXPECT_EQ(result.thickness->correction, 0.5);
  const double expected = 2 * std::sqrt(16.5) + 1;  // with half a voxel at either side
  EXPECT_NEAR(result.thickness->sheets.mean(), expected, 0.6);
  EXPECT_NEAR(result.thickness->shape.percentile(0.5), expected, expected / 8192);
  EXPECT_EQ(result.thickness->shape.weight(), 48 * 48 * 8);
  ASSERT_FALSE(result.axis.parts->sheets.empty());
  const Contents read = read_back(builder.page);
  const std::vector<double>& thickness = read["shape/point/thickness"];
  EXPECT_EQ(3 * thickness.size(), read["shape/points"].size());
  std::size_t thick = 0;
  for (const double t : thickness) thick += std::abs(t - expected) < 0.01 ? 1 : 0;
  EXPECT_GT(thick, thickness.size() / 2);
  EXPECT_EQ(read["sheets/area"].size(), result.axis.parts->sheets.size());
}

}  // namespace page_parts_test
}  // namespace quench
