// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <pugixml.hpp>
#include <sstream>

#include "polygon_files.h"
#include "quench/graph.h"
#include "quench/io.h"
#include "temporary_folder.h"

using namespace quench;
using io::PlaneLines;
using Json = nlohmann::json;

namespace line_files_test {

/// A branch of three points, a closed branch and an isolated node.
PlaneLines example() {
  PlaneLines lines;
  using Kind = CurveGraph::NodeKind;
  const auto node = [&](double x, double y, Kind kind) {
    CurveGraph::Node n;
    n.point = Vec3(x, y, 0);
    n.radius = 0.1;
    n.kind = kind;
    lines.graph.nodes.push_back(n);
  };
  node(0, 0, Kind::end);
  node(1.0 / 3, 2, Kind::junction);
  node(-5, 1e-7, Kind::isolated);
  CurveGraph::Branch branch;
  branch.from = 0;
  branch.to = 1;
  branch.points = {{0, 0, 0}, {0.1, 1, 0}, {1.0 / 3, 2, 0}};
  branch.radius = {0.1, 0.2, 0.30000000000000004};
  branch.length = 2.2;
  branch.mean_radius = 0.2;
  branch.min_radius = 0.1;
  branch.max_radius = 0.30000000000000004;
  branch.thickness = 1.5;
  branch.tortuosity = 1.1;
  lines.graph.branches.push_back(branch);
  branch.from = branch.to = 1;
  branch.points = {{1.0 / 3, 2, 0}, {2, 3, 0}, {3, 2, 0}, {1.0 / 3, 2, 0}};
  branch.radius = {0.1, 0.1, 0.1, 0.1};
  branch.mean_radius = 0.1;
  branch.thickness = branch.tortuosity = std::numeric_limits<double>::infinity();
  lines.graph.branches.push_back(branch);
  lines.arrays.push_back({"mgf", {{1, 2, std::numeric_limits<double>::infinity()}, {4, 5, 6, 7}}});
  lines.outline.rings = {{{-6, -1}, {4, -1}, {4, 5}, {-6, 5}}, {{0, 4}, {0, 4.5}, {1, 4}}};
  return lines;
}

std::string text_of(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

TEST(LineFiles, GeoJson) {
  const TemporaryFolder folder;
  PlaneLines lines = example();
  lines.number = 12;
  lines.id = "\"r1\"";
  lines.properties = R"({"name":"Rh\u00een\n","length":5,"mgf":[1],"polygon_length":6,"n":null})";
  io::write_lines(folder / "a.geojson", lines);
  const Json json = Json::parse(text_of(folder / "a.geojson"));
  EXPECT_EQ(json["type"], "FeatureCollection");
  ASSERT_EQ(json["features"].size(), 3u);
  const Json& first = json["features"][0];
  EXPECT_EQ(first["type"], "Feature");
  EXPECT_EQ(first["geometry"]["type"], "LineString");
  EXPECT_EQ(first["geometry"]["coordinates"], Json::parse("[[0,0],[0.1,1],[0.3333333333333333,2]]"));
  const Json expected = Json::parse(R"({"name":"Rhîn\n","polygon_polygon_length":5,"polygon_mgf":[1],"polygon_length":6,
    "n":null,"feature":12,"feature_id":"r1","branch":0,"from":0,"to":1,"from_kind":"end","to_kind":"junction",
    "length":2.2,"mean_radius":0.2,"min_radius":0.1,"max_radius":0.30000000000000004,"thickness":1.5,"tortuosity":1.1,
    "radius":[0.1,0.2,0.30000000000000004],"mgf":[1,2,null]})");
  EXPECT_EQ(first["properties"], expected) << first["properties"].dump();
  EXPECT_TRUE(json["features"][1]["properties"]["thickness"].is_null());
  EXPECT_EQ(json["features"][2]["geometry"], Json::parse(R"({"type":"Point","coordinates":[-5,1e-7]})"));
  EXPECT_EQ(json["features"][2]["properties"]["kind"], "isolated");
}

TEST(LineFiles, ManyFeaturesAndNone) {
  const TemporaryFolder folder;
  for (const char* name : {"a.json", "a.ndjson", "a.wkt", "a.svg"}) {
    io::LineWriter(folder / name).finish();
    io::LineWriter dropped(folder / "dropped.wkt");
    dropped.append(example());
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "dropped.wkt"));
  EXPECT_TRUE(Json::parse(text_of(folder / "a.json"))["features"].empty());
  EXPECT_EQ(text_of(folder / "a.ndjson"), "");
  EXPECT_EQ(text_of(folder / "a.wkt"), "");

  io::LineWriter json(folder / "many.json"), lines(folder / "many.geojsonl");
  for (std::uint64_t k = 0; k < 100; ++k) {
    PlaneLines one = example();
    one.number = k;
    json.append(one);
    lines.append(one);
  }
  json.finish();
  lines.finish();
  const Json all = Json::parse(text_of(folder / "many.json"));
  ASSERT_EQ(all["features"].size(), 300u);
  EXPECT_EQ(all["features"][299]["properties"]["feature"], 99);
  std::istringstream text(text_of(folder / "many.geojsonl"));
  std::size_t count = 0;
  for (std::string line; std::getline(text, line); ++count) EXPECT_EQ(Json::parse(line), all["features"][count]);
  EXPECT_EQ(count, 300u);
}

TEST(LineFiles, Wkt) {
  const TemporaryFolder folder;
  io::write_lines(folder / "a.wkt", example());
  EXPECT_EQ(text_of(folder / "a.wkt"),
            "LINESTRING (0 0, 0.1 1, 0.3333333333333333 2)\n"
            "LINESTRING (0.3333333333333333 2, 2 3, 3 2, 0.3333333333333333 2)\n"
            "POINT (-5 1e-07)\n");
  const ReadPolygons read = read_polygons(folder / "a.wkt");
  EXPECT_EQ(read.bad.size(), 3u) << "well-formed, but lines";
}

TEST(LineFiles, Svg) {
  const TemporaryFolder folder;
  for (const bool y_down : {false, true}) {
    io::write_lines(folder / "a.svg", example(), {y_down});
    pugi::xml_document xml;
    ASSERT_TRUE(xml.load_file((folder / "a.svg").c_str()));
    const pugi::xml_node root = xml.child("svg"), group = root.child("g");
    std::istringstream box(root.attribute("viewBox").value());
    double x = 0, y = 0, width = 0, height = 0;
    box >> x >> y >> width >> height;
    EXPECT_NEAR(x, -6.2, 1e-9);
    EXPECT_NEAR(y, y_down ? -1.2 : -5.2, 1e-9);
    EXPECT_NEAR(width, 10.4, 1e-9);
    EXPECT_NEAR(height, 6.4, 1e-9);
    EXPECT_EQ(std::string(group.attribute("transform").value()), y_down ? "" : "scale(1,-1)");
    const pugi::xml_node shape = group.child("g");
    EXPECT_STREQ(shape.child("path").attribute("d").value(), "M-6 -1L4 -1L4 5L-6 5ZM0 4L0 4.5L1 4Z");
    const pugi::xml_node line = shape.child("polyline");
    EXPECT_STREQ(line.attribute("points").value(), "0,0 0.1,1 0.3333333333333333,2");
    EXPECT_STREQ(line.attribute("data-mean-radius").value(), "0.2");
    EXPECT_STREQ(shape.child("circle").attribute("cx").value(), "-5");
    // Read again it is the outline.
    const ReadPolygons read = read_polygons(folder / "a.svg");
    ASSERT_EQ(read.features.size(), 2u) << "the outline and the isolated node";
    const double sign = y_down ? 1 : -1;
    EXPECT_EQ(read.features[0].polygons.rings[0][2], Vec2(4, 5 * sign));
  }
  io::write_lines(folder / "b.svg", example(), {true, io::LineOptions::Colour::thickness});
  EXPECT_NE(text_of(folder / "b.svg"), text_of(folder / "a.svg"));
}

TEST(LineFiles, Refused) {
  const TemporaryFolder folder;
  const auto code_of = [](const auto& action) {
    try {
      action();
    } catch (const Error& error) {
      return static_cast<int>(error.code());
    }
    return 0;
  };
  EXPECT_EQ(code_of([&] { io::LineWriter(folder / "a.vtp"); }), static_cast<int>(ErrorCode::usage));
  EXPECT_EQ(code_of([&] { io::LineWriter(folder / "none/a.wkt"); }), static_cast<int>(ErrorCode::failed));
  PlaneLines lines = example();
  lines.properties = "[1]";
  EXPECT_EQ(code_of([&] { io::write_lines(folder / "a.json", lines); }), static_cast<int>(ErrorCode::input));
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(LineFiles, AppearWithTheirGroup) {
  const TemporaryFolder folder;
  {
    io::OutputGroup group;
    io::write_lines(folder / "a.wkt", example());
    EXPECT_FALSE(std::filesystem::exists(folder / "a.wkt"));
    group.commit();
  }
  EXPECT_TRUE(std::filesystem::exists(folder / "a.wkt"));
}

}  // namespace line_files_test
