// SPDX-License-Identifier: Apache-2.0
#include "polygon_files.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include "data.h"
#include "quench/io.h"
#include "small_polygons.h"
#include "temporary_folder.h"

using namespace quench;

namespace polygon_files_test {

class PolygonFiles : public testing::Test {
 protected:
  ReadPolygons read(const std::string& name, const std::string& bytes) {
    return read_polygons(folder_.write(name, bytes));
  }
  /// The one feature of a file, as "x y,x y;..." per ring.
  std::string rings(const std::string& name, const std::string& bytes) {
    const ReadPolygons r = read(name, bytes);
    EXPECT_EQ(r.features.size(), 1u) << bytes;
    std::string text;
    for (const auto& ring : r.features.empty() ? Polygons{}.rings : r.features[0].polygons.rings) {
      for (const Vec2& p : ring) text += number(p[0]) + " " + number(p[1]) + ",";
      text.back() = ';';
    }
    return text;
  }
  void expect_bad(const std::string& name, const std::string& bytes, const std::string& words) {
    const ReadPolygons r = read(name, bytes);
    ASSERT_EQ(r.bad.size(), 1u) << bytes;
    EXPECT_NE(r.bad[0].second.find(words), std::string::npos) << r.bad[0].second;
  }
  void expect_refused(const std::string& name, const std::string& bytes, const std::string& words) {
    try {
      read(name, bytes);
      FAIL() << bytes.substr(0, 200);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::input);
      EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
    }
  }
  static std::string number(double x) {
    std::string text = std::to_string(std::round(x * 1e4) / 1e4);
    while (text.back() == '0') text.pop_back();
    if (text.back() == '.') text.pop_back();
    return text == "-0" ? "0" : text;
  }
  static double area(const Polygons& polygons) {
    double twice = 0;
    for (const auto& ring : polygons.rings)
      for (std::size_t k = 0; k < ring.size(); ++k) {
        const Vec2 &a = ring[k], &b = ring[(k + 1) % ring.size()];
        twice += a[0] * b[1] - a[1] * b[0];
      }
    return std::abs(twice) / 2;
  }
  TemporaryFolder folder_;
};

std::string svg(const std::string& body, const std::string& attributes = "viewBox=\"0 0 100 100\"") {
  return "<svg xmlns=\"http://www.w3.org/2000/svg\" " + attributes + ">" + body + "</svg>";
}

// --- GeoJSON -------------------------------------------------------------------------------------------------------

TEST_F(PolygonFiles, GeoJsonGeometries) {
  const std::string ring = "[[0,0],[4,0],[4,4],[0,0]]", hole = "[[1,0.5,7],[2,0.5,7],[2,1,7]]";
  EXPECT_EQ(rings("a.geojson", R"({"type":"Polygon","coordinates":[)" + ring + "," + hole + "]}"),
            "0 0,4 0,4 4,0 0;1 0.5,2 0.5,2 1;");
  EXPECT_EQ(rings("a.json", R"({"coordinates":[[)" + ring + "],[" + hole + R"(]],"type":"MultiPolygon"})"),
            "0 0,4 0,4 4,0 0;1 0.5,2 0.5,2 1;");
  EXPECT_EQ(
      rings("a.json", R"({"type":"Feature","properties":null,"geometry":{"type":"GeometryCollection","geometries":[
      {"type":"Point","coordinates":[1,2]},{"type":"Polygon","coordinates":[)" +
                          ring + R"(]},{"type":"GeometryCollection","geometries":[{"coordinates":[)" + hole +
                          R"(],"type":"Polygon"}]}]}})"),
      "0 0,4 0,4 4,0 0;1 0.5,2 0.5,2 1;");
}

TEST_F(PolygonFiles, GeoJsonKeepsPropertiesAndIds) {
  const std::string polygon = R"("geometry":{"type":"Polygon","coordinates":[[[0,0],[1,0],[0,1]]]})";
  const auto r = read(
      "a.geojson",
      "\xEF\xBB\xBF{\"features\":["
      R"({"id":"a\"b","properties":{"name":"B\u00fc\n","x":[1,{"y":1.50},[]],"n":null,"t":true,"e":{}},)" +
          polygon + R"(,"type":"Feature"},{"type":"Feature","id":7,"properties":{},)" + polygon +
          R"(,"more":{"type":"odd","coordinates":[1]}},{"type":"Feature",)" + polygon +
          R"(}],"type":"FeatureCollection","crs":{"type":"name","properties":{"name":"urn:ogc:def:crs:EPSG::25833"}}})");
  ASSERT_EQ(r.features.size(), 3u);
  EXPECT_EQ(r.features[0].properties, R"({"name":"Bü\n","x":[1,{"y":1.50},[]],"n":null,"t":true,"e":{}})");
  EXPECT_EQ(r.features[0].id, R"("a\"b")");
  EXPECT_EQ(r.features[1].properties, "");
  EXPECT_EQ(r.features[1].id, "7");
  EXPECT_EQ(r.features[2].number, 2u);
  EXPECT_FALSE(r.features[2].y_down);
  EXPECT_TRUE(r.notes.empty()) << "the system of coordinates is not degrees";
}

TEST_F(PolygonFiles, GeoJsonBadFeatures) {
  const auto feature = [](const std::string& geometry) {
    return R"({"type":"FeatureCollection","features":[{"type":"Feature","geometry":)" + geometry + "}]}";
  };
  expect_bad("a.json", feature("null"), "it has no geometry");
  expect_bad("a.json", feature(R"({"type":"LineString","coordinates":[[0,0],[1,1]]})"), "is a LineString");
  expect_bad("a.json", feature(R"({"type":"Point","coordinates":[0,0]})"), "is a Point");
  expect_bad("a.json", feature(R"({"type":"Circle","coordinates":[0,0]})"), "unknown type 'Circle'");
  expect_bad("a.json", feature(R"({"coordinates":[[[0,0],[1,1],[1,0]]]})"), "no type");
  expect_bad("a.json", feature(R"({"type":"Polygon","coordinates":[]})"), "is empty");
  expect_bad("a.json", feature(R"({"type":"Polygon"})"), "is empty");
  for (const char* coordinates : {"[[0,0],[1,0],[0,1]]", "[[[[0,0],[1,0],[0,1]]]]", "[[[0,0],[1,0],[0]]]",
                                  "[[[0,0],[1,0],[[0,1]]]]", "7", R"([[["0","0"]]])", "[[[0,0],[1,null],[0,1]]]",
                                  R"([[{"x":[0,1]},[1,0],[0,1]]])", "[[[0,[0],0],[1,1],[0,1]]]", "null"})
    expect_bad("a.json", feature(R"({"type":"Polygon","coordinates":)" + std::string(coordinates) + "}"),
               "not those of a Polygon");
  expect_bad("a.json", R"({"type":"FeatureCollection","features":[7]})", "not an object");
  expect_bad("a.json", R"({"type":"FeatureCollection","features":[[{"type":"Feature"}]]})", "not an object");
  expect_bad("a.json", R"({"type":"GeometryCollection","geometries":[1,{"type":"Point","coordinates":[1,1]}]})",
             "member");
  EXPECT_EQ(read("a.json", R"({"type":"FeatureCollection","features":[]})").count, 0u);
}

TEST_F(PolygonFiles, BadFeaturesKeepTheirIdAndProperties) {
  const auto r =
      read("a.json", R"({"features":[{"id":"x","geometry":null,"type":"Feature","properties":{"a":1}},)"
                     R"({"type":"Feature","geometry":{"type":"Polygon","coordinates":[[[0,0],[1]]]},"id":5}]})");
  ASSERT_EQ(r.bad.size(), 2u);
  EXPECT_EQ(r.bad[0].first.id, "\"x\"");
  EXPECT_EQ(r.bad[0].first.properties, R"({"a":1})");
  EXPECT_EQ(r.bad[1].first.id, "5");
  EXPECT_EQ(r.bad[1].first.number, 1u);
  const auto drawn = read("a.svg", svg("<g fill='red'><path id='p' class='c' d='L'/></g>"));
  ASSERT_EQ(drawn.bad.size(), 1u);
  EXPECT_EQ(drawn.bad[0].first.id, "\"p\"");
  EXPECT_EQ(drawn.bad[0].first.properties, R"({"element":"path","fill":"red","class":"c"})");
}

TEST_F(PolygonFiles, DeepPropertiesAreRefused) {
  const auto feature = [](const std::string& value) {
    return R"({"type":"FeatureCollection","features":[{"type":"Feature","id":3,"properties":{"a":)" + value +
           R"(},"geometry":{"type":"Polygon","coordinates":[[[0,0],[1,0],[0,1]]]}}]})";
  };
  const auto nested = [](std::size_t depth) { return std::string(depth, '[') + "1" + std::string(depth, ']'); };
  std::string objects = "1";
  for (int k = 0; k < 1000; ++k) objects = R"({"a":)" + objects + "}";
  EXPECT_EQ(read("a.json", feature(nested(63))).features.at(0).properties, R"({"a":)" + nested(63) + "}");
  for (const std::string& deep : {nested(64), nested(100000), objects}) {
    expect_bad("a.json", feature(deep), "properties are nested too deeply");
    EXPECT_EQ(read("a.json", feature(deep)).bad.at(0).first.id, "3");
  }
}

TEST_F(PolygonFiles, HostileGeoJson) {
  const std::string good = R"({"type":"Polygon","coordinates":[[[0,0],[1,0],[0,1]]]})";
  for (std::size_t length = 1; length < good.size(); ++length)
    expect_refused("a.json", good.substr(0, length), "damaged");
  expect_refused("a.json", "", "is empty");
  expect_refused("a.json", good + "x", "damaged");
  expect_refused("a.json", R"({"type":"Polygon","coordinates":[[[0,1e400],[1,0],[0,1]]]})", "beyond the range");
  expect_refused("a.json", R"({"type":"Polygon","coordinates":[[[0,NaN],[1,0],[0,1]]]})", "damaged");
  expect_refused("a.json", R"({"type":"Topology","objects":{}})", "'Topology'");
  expect_refused("a.json", R"({"stage":"core"})", "not GeoJSON");
  expect_refused("a.json", "[1,2]", "array");
  expect_refused("a.json", "7", "single value");
  expect_refused("a.json", std::string(1000000, '['), "array");
  std::string nested;
  for (int k = 0; k < 100000; ++k) nested += R"({"type":"GeometryCollection","geometries":[)";
  expect_refused("a.json", nested, "nested");
  expect_refused("a.json", R"({"type":"Polygon","coordinates":)" + std::string(1000000, '['), "damaged");
  expect_refused("a.json", R"({"properties":)" + std::string(1000000, '['), "damaged");
}

TEST_F(PolygonFiles, FeaturesBeforeTheDamageAreHandedOver) {
  int taken = 0;
  const auto file = folder_.write(
      "a.json",
      R"({"features":[{"type":"Feature","geometry":{"type":"Polygon","coordinates":[[[0,0],[1,0],[0,1]]]}},{"ty)");
  EXPECT_THROW(io::for_each_feature(
                   file, [&](PolygonFeature&&) { ++taken; }, [](PolygonFeature&&, const Error&) {}),
               Error);
  EXPECT_EQ(taken, 1);
  const auto fails = [](PolygonFeature&&) { throw Error(ErrorCode::failed, "mine"); };
  try {
    io::for_each_feature(folder_.write("b.ndjson", R"({"type":"Polygon","coordinates":[[[0,0],[1,0],[0,1]]]})"), fails,
                         [](PolygonFeature&&, const Error&) {});
    FAIL();
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "mine");
  }
}

TEST_F(PolygonFiles, GeoJsonLines) {
  const std::string good = R"({"type":"Polygon","coordinates":[[[0,0],[1,0],[0,1]]]})";
  const auto r = read("a.geojsonl", good + "\r\n\n\x1E" + good + "\n{\"type\":\"Pol\n[]\n" + good);
  EXPECT_EQ(r.features.size(), 3u);
  ASSERT_EQ(r.bad.size(), 2u);
  EXPECT_EQ(r.bad[0].first.number, 2u);
  EXPECT_EQ(r.features[2].number, 4u);
}

TEST_F(PolygonFiles, NotesWhatCoordinatesSuggest) {
  const auto notes = [&](const std::string& point) {
    return read("a.json", R"({"type":"Polygon","coordinates":[[[0,0],[1,0],)" + point + "]]}").notes;
  };
  ASSERT_EQ(notes("[170,80]").size(), 1u);
  EXPECT_NE(notes("[170,80]")[0].find("degrees"), std::string::npos);
  ASSERT_EQ(notes("[52,130]").size(), 2u);
  EXPECT_NE(notes("[52,130]")[0].find("exchanged"), std::string::npos);
  EXPECT_TRUE(notes("[52000,130]").empty());
  EXPECT_TRUE(read("a.json", R"({"type":"FeatureCollection","features":[]})").notes.empty());
  EXPECT_TRUE(read("a.json", R"({"type":"Feature","geometry":null})").notes.empty());
  EXPECT_EQ(read("a.wkt", "SRID=4326;POLYGON((0 0,1 0,0 1))").notes.size(), 1u);
  EXPECT_TRUE(read("a.wkt", "POLYGON((0 0,1 0,0 1))").notes.empty());
}

// --- WKT -----------------------------------------------------------------------------------------------------------

TEST_F(PolygonFiles, Wkt) {
  EXPECT_EQ(rings("a.wkt", "POLYGON((0 0,4 0,4 4,0 0),(1 .5,2 0.5e0,2 1))"), "0 0,4 0,4 4,0 0;1 0.5,2 0.5,2 1;");
  EXPECT_EQ(
      rings("a.WKT", "SRID = 25833 ;\n multipolygon z\n( ((0 0 5,1 0 5,0 1 5)) ,EMPTY,\t((3 3 5, 4 3 5, 3 4 5)))\n"),
      "0 0,1 0,0 1;3 3,4 3,3 4;");
  EXPECT_EQ(rings("a.wkt", "PolygonZM((0 0 1 2,1 0 1 2,0 1 1 2));"), "0 0,1 0,0 1;");
  EXPECT_EQ(rings("a.wkt", "GEOMETRYCOLLECTION M(POINT(1 2),POLYGON M((0 0 9,1 0 9,0 1 9)),LINESTRING(0 0,1 1))"),
            "0 0,1 0,0 1;");
  const auto r = read("a.wkt",
                      "POLYGON((0 0,1 0,0 1))\n"
                      "POINT(1 2)\n"
                      "POLYGON EMPTY\n"
                      "POLYGON((0 0,1 x,0 1)) POLYGON((7 7))\n"
                      "POLYGON((0 0,1 0,0 nan))\n"
                      "POLYGON((0 0,1 0,0 1)\n"
                      "POLYGON((0 0,1 0,0 2)); POLYGON((0 0,1 0,0 3))\n"
                      "what is this\n"
                      "POLYGON((0 0,1 0,0 1e999))");
  ASSERT_EQ(r.features.size(), 3u);
  EXPECT_EQ(r.features[1].polygons.rings[0][2], Vec2(0, 2));
  EXPECT_EQ(r.features[2].number, 7u);
  std::string reasons;
  for (const auto& [feature, reason] : r.bad)
    reasons += std::to_string(feature.number) + reason.substr(reason.rfind(": ")) + "|";
  EXPECT_EQ(
      reasons,
      "1: its geometry is a POINT, not a polygon|2: its polygon is empty|3: a number is missing before 'X' in line "
      "4|4: a number is missing before 'NAN' in line 5|5: ')' is missing before 'POLYGON' in line 7|8: the name of a "
      "geometry, such as POLYGON, is missing before 'WHAT' in line 8|9: a number is missing before '1E999' in line 9|");
}

TEST_F(PolygonFiles, HostileWkt) {
  for (const char* text :
       {"hello", "POLYGON", "POLYGON((", "POLYGON((0 0,1", "((0 0,1 0,0 1))", "SRID=", "POINT", "\xFF\x01\x02"})
    expect_refused("a.wkt", text, "not WKT");
  expect_refused("a.wkt", std::string(1000000, 'x'), "not WKT");
  expect_refused("a.wkt", "POINT" + std::string(1000000, '('), "not WKT");
  std::string nested;
  for (int k = 0; k < 100000; ++k) nested += "GEOMETRYCOLLECTION(";
  expect_refused("a.wkt", nested, "nested");
  EXPECT_EQ(read("a.wkt", " \n;\n").count, 0u);
}

// --- SVG -----------------------------------------------------------------------------------------------------------

TEST_F(PolygonFiles, SvgPathCommands) {
  const auto path = [&](const std::string& d) { return rings("a.svg", svg("<path d='" + d + "'/>")); };
  EXPECT_EQ(path("M1 1h2v2H1z"), "1 1,3 1,3 3,1 3;");
  EXPECT_EQ(path("m1,1 2 0 0 2-2 0zm4 0l1 0 0 1"), "1 1,3 1,3 3,1 3;5 1,6 1,6 2;");
  EXPECT_EQ(path("M1.5.5.5.5-.5-1e0L3-2"), "1.5 0.5,0.5 0.5,-0.5 -1,3 -2;");
  EXPECT_EQ(path("M0 0V2L+3,2ZL1 0 1-1"), "0 0,0 2,3 2;0 0,1 0,1 -1;")
      << "after Z the next subpath begins where the last did";
  const auto measured = [&](const std::string& d) {
    return area(read("a.svg", svg("<path d='" + d + "'/>")).features.at(0).polygons);
  };
  EXPECT_NEAR(measured("M10 0A10 10 0 1 1-10 0 10 10 0 0 1 10 0"), 100 * std::numbers::pi, 1e-2);
  EXPECT_NEAR(measured("M10 0a10 10 0 11-20 0a10 10 0 0120 0"), 100 * std::numbers::pi, 1e-2) << "flags without blanks";
  EXPECT_NEAR(measured("M0 0A1 1 0 0 0 10 0z"), 25 * std::numbers::pi / 2, 1e-2) << "too short radii grow";
  EXPECT_NEAR(measured("M0 0A5 5 77 1 0 5 5z"), 25 * (3 * std::numbers::pi / 4 + 0.5), 1e-2) << "the large arc";
  EXPECT_NEAR(measured("M0 0A10 5 90 0 1 0 20 10 5 90 0 1 0 0"), 50 * std::numbers::pi, 1e-2) << "a turned ellipse";
  EXPECT_NEAR(measured("M0 0Q5 10 10 0"), 2.0 / 3 * 10 * 5, 1e-2);
  EXPECT_NEAR(measured("M0 0C0 10 10 10 10 0"), 60, 1e-2);
  EXPECT_NEAR(measured("M0 0c0 10 10 10 10 0s10-10 10 0v20h-20z"),
              measured("M0 0C0 10 10 10 10 0C10 -10 20 -10 20 0V20H0Z"), 1e-9);
  EXPECT_NEAR(measured("M0 0Q5 10 10 0T20 0V20H0Z"), measured("M0 0Q5 10 10 0Q15-10 20 0V20H0Z"), 1e-9);
}

TEST_F(PolygonFiles, SvgShapesAndTransforms) {
  EXPECT_EQ(rings("a.svg", svg("<g transform='translate(10) scale(2,3)'><g transform='matrix(1 0 0 1 1 1)'><rect x='1' "
                               "y='1' width='2px' height='2'/></g></g>")),
            "14 6,18 6,18 12,14 12,14 6;");
  EXPECT_EQ(rings("a.svg", svg("<polygon points='0,0 4,0 4,4' transform='rotate(90) translate(1,1)'/>")),
            "-1 1,-1 5,-5 5;");
  EXPECT_EQ(rings("a.svg", svg("<polyline points='0,0 4,0 4,4' transform='rotate(180, 2 2), skewX(0)skewY(0)'/>")),
            "4 4,0 4,0 0;");
  EXPECT_EQ(
      rings("a.svg",
            svg("<svg x='10' y='20' width='10' height='20' viewBox='0 0 5 5'><polygon points='0,0 5,0 5,5'/></svg>")),
      "10 25,20 25,20 35;");
  const auto measured = [&](const std::string& body) { return area(read("a.svg", svg(body)).features.at(0).polygons); };
  EXPECT_NEAR(measured("<circle cx='5' cy='5' r='5'/>"), 25 * std::numbers::pi, 1e-2);
  EXPECT_NEAR(measured("<ellipse rx='5' ry='2mm'/>"), 10 * std::numbers::pi * 96 / 25.4, 1e-2);
  EXPECT_NEAR(measured("<rect width='10' height='10' rx='2'/>"), 100 - 4 * (4 - std::numbers::pi), 1e-2);
  EXPECT_NEAR(measured("<rect width='10' height='10' rx='50'/>"), 25 * std::numbers::pi, 1e-2);
}

TEST_F(PolygonFiles, SvgPercentages) {
  const std::string page = "viewBox='0 0 200 100'";
  EXPECT_EQ(rings("a.svg", svg("<rect x='10%' y='10%' width='50%' height='50%'/>", page)),
            "20 10,120 10,120 60,20 60,20 10;");
  EXPECT_EQ(rings("a.svg", svg("<rect width='50%' height='50%'/>", "width='10' height='1in'")),
            "0 0,5 0,5 48,0 48,0 0;");
  const auto circle = read("a.svg", svg("<circle cx='50%' cy='50%' r='10%'/>", page));
  EXPECT_NEAR(area(circle.features.at(0).polygons), 250 * std::numbers::pi, 0.1) << "of the mean square of the sides";
  EXPECT_EQ(circle.features[0].polygons.rings[0][0], Vec2(100 + std::sqrt(250.0), 50));
  for (const char* sides : {"width='100%' height='100%'", ""})
    EXPECT_EQ(rings("a.svg",
                    svg("<svg " + std::string(sides) + " viewBox='0 0 10 10'><rect width='100%' height='50%'/></svg>")),
              "0 0,100 0,100 50,0 50,0 0;");
  const std::string ground = "<rect width='100%' height='100%'/>", shape = "<path d='M1 1h2v2z'/>";
  for (const char* box : {"viewBox='0 0 100 100'", "viewBox='0 0 0.3 77.7'", "width='9.3mm' height='7'"})
    EXPECT_EQ(read("a.svg", svg(ground + shape, box)).features.size(), 1u) << box;
}

TEST_F(PolygonFiles, SvgFills) {
  const std::string square = " d='M0 0h4v4h-4z'";
  const auto r =
      read("a.svg", svg("<path id='a'" + square + "/><path fill='none'" + square + "/><g fill='none'><path" + square +
                        "/><path id='b' class='c' fill='#f00' fill-rule='evenodd'" + square +
                        "/></g><path style='stroke:red; fill : none'" + square + "/><g display='none'><path" + square +
                        "/></g><path visibility='hidden'" + square + "/><path fill-opacity='0'" + square +
                        "/><line x1='0' x2='5'/><path d='M0 0L5 5'/><defs><path" + square +
                        "/></defs><use href='#a'/><clipPath><path" + square +
                        "/></clipPath><text>no</text><path clip-path='url(#x)'" + square + "/>"));
  ASSERT_EQ(r.features.size(), 3u);
  EXPECT_EQ(r.features[0].id, "\"a\"");
  EXPECT_EQ(r.features[0].fill, PolygonFill::nonzero);
  EXPECT_EQ(r.features[1].fill, PolygonFill::evenodd);
  EXPECT_EQ(r.features[1].properties, R"({"element":"path","fill":"#f00","class":"c"})");
  EXPECT_TRUE(r.features[0].y_down);
  ASSERT_EQ(r.notes.size(), 1u);
  EXPECT_NE(r.notes[0].find("1 clip-path, 1 text, 1 use"), std::string::npos) << r.notes[0];
}

TEST_F(PolygonFiles, SvgBackgrounds) {
  const std::string ground = "<path d='M0 0h100v100H0z'/>", shape = "<path d='M1 1h2v2z'/>";
  const auto two = read("a.svg", svg(ground + shape));
  ASSERT_EQ(two.features.size(), 1u);
  EXPECT_EQ(two.features[0].number, 1u);
  EXPECT_EQ(two.notes.size(), 1u);
  EXPECT_EQ(read("a.svg", svg(ground)).features.size(), 1u);
  EXPECT_EQ(read("a.svg", svg(ground + shape, "viewBox='0 0 200 100'")).features.size(), 2u);
  EXPECT_EQ(
      read("a.svg", svg("<rect width='100' height='100'/>" + shape, "width='100' height='100px'")).features.size(), 1u);
  EXPECT_EQ(read("a.svg", svg("<rect width='100' height='100' rx='5'/>" + shape)).features.size(), 2u);
}

TEST_F(PolygonFiles, SvgWithNamespaces) {
  EXPECT_EQ(
      read("a.svg",
           "<?xml version='1.0'?><!DOCTYPE svg [<!ENTITY a 'b'>]><s:svg xmlns:s='x'><s:path d='M0 0h1v1z'/></s:svg>")
          .features.size(),
      1u);
}

TEST_F(PolygonFiles, HostileSvg) {
  for (const char* d : {"M0 0 5", "L5 5 0 0 1 1", "M0 0 X", "M0 0 1 1 1e400 0", "M0 0A1 1 0 2 0 5 5", "5 5",
                        "M0 0 1 0 1 1z5", "Mnan 0"})
    expect_bad("a.svg", svg("<path d='" + std::string(d) + "'/>"), "of the element path");
  expect_bad("a.svg", svg("<polygon points='1 2 3'/>"), "odd number");
  expect_bad("a.svg", svg("<circle r='5%'/>", ""), "r is in percent of a drawing without a size");
  expect_bad("a.svg", svg("<circle r='5em'/>"), "a number is missing");
  std::string curves = "M0 0";
  for (int k = 0; k < 10000; ++k) curves += "C0 0 0 0 1e20 0L0 1";
  for (const char* scale : {"1e99", "1e60"})
    expect_bad("a.svg",
               svg("<g transform='scale(" + std::string(scale) + ") scale(" + scale + ") scale(" + scale +
                   ")'><path d='" + curves + "z'/></g>"),
               "its coordinates are too large");
  expect_bad("a.svg", svg("<rect width='-5' height='1'/>"), "negative");
  expect_bad("a.svg", svg("<g transform='turn(5)'><path d='M0 0h1v1z'/></g>"), "unknown");
  expect_refused("a.svg", "", "is empty");
  expect_refused("a.svg", "<svg", "damaged");
  expect_refused("a.svg", "<html></html>", "not an SVG");
  expect_refused("a.svg", svg("<path fill='none' d='M0 0h1v1z'/>"), "no filled shapes");
  expect_refused("a.svg", svg("<path d=''/>"), "no filled shapes");
  expect_refused("a.svg", svg("<path d='M0 0h1v1z'/>", "transform='turn(1)'"), "unknown");
  EXPECT_EQ(rings("a.svg", svg("<path d='M0 0A1e99 1e99 0 0 0 1e-56 0L5 5 5 0z'/>")), "0 0,0 0,5 5,5 0;");
  std::string nested;
  for (int k = 0; k < 100000; ++k) nested += "<g>";
  expect_refused("a.svg", nested, "damaged");
  std::string closed;
  for (int k = 0; k < 100000; ++k) closed += "</g>";
  expect_refused("a.svg", svg(nested + closed), "nested too deep");
}

TEST_F(PolygonFiles, DamagedFilesAreReadOrRefused) {
  std::mt19937 random(5);
  std::size_t refused = 0;
  const auto try_to_read = [&](const small_files::SmallFile& file, const std::string& bytes) {
    try {
      for (const PolygonFeature& feature : read_polygons(folder_.write(file.name, bytes)).features) {
        try {
          digitize(feature.polygons, {.resolution = 8, .pixel = {}, .fill = feature.fill}).validate();
        } catch (const Error& error) {
          EXPECT_EQ(error.code(), ErrorCode::input) << bytes;
        }
      }
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::input) << bytes;
      ++refused;
    }
  };
  for (const small_files::SmallFile& file : small_files::polygons()) {
    try_to_read(file, file.bytes);
    EXPECT_EQ(refused, 0u) << file.name;
    for (std::size_t length = 0; length < file.bytes.size(); length += 5)
      try_to_read(file, file.bytes.substr(0, length));
    for (int round = 0; round < 100; ++round) {
      std::string bytes = file.bytes;
      for (auto changes = 1 + random() % 3; changes-- > 0;)
        bytes[random() % bytes.size()] = "0-.e,[]{}()\"<>/ zMA\xFF\n"[random() % 22];
      try_to_read(file, bytes);
    }
    refused = 0;
  }
}

TEST_F(PolygonFiles, OtherFiles) {
  std::filesystem::create_symlink("/dev/zero", folder_ / "zero.wkt");
  EXPECT_THROW(read_polygons(folder_ / "zero.wkt"), Error);
  for (const char* name : {"a.geojson", "a.JSON", "a.geojsonl", "a.geojsons", "a.ndjson", "a.wkt", "a.svg"})
    EXPECT_EQ(io::kind_of(name), io::Kind::polygons) << name;
  expect_refused("a.txt", "POLYGON((0 0,1 0,0 1))", "not a file of polygons");
  for (const char* name : {"none.json", "none.wkt", "none.svg"}) try {
      read_polygons(folder_ / name);
      FAIL();
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::failed);
    }
}

// --- real data -----------------------------------------------------------------------------------------------------

TEST(RealPolygons, NaturalEarth) {
  REQUIRE_DATA("images/ne_110m_lakes.json");
  for (const auto& [name, features, vertices] :
       {std::tuple("images/ne_110m_lakes.json", 25u, 400u), std::tuple("images/ne_110m_land.json", 127u, 5000u)}) {
    const ReadPolygons r = read_polygons(data_file(name));
    EXPECT_EQ(r.features.size(), features) << name;
    EXPECT_TRUE(r.bad.empty());
    EXPECT_EQ(r.notes.size(), 1u);
    std::size_t count = 0;
    for (const PolygonFeature& feature : r.features) {
      for (const auto& ring : feature.polygons.rings) count += ring.size();
      EXPECT_EQ(feature.properties.find(R"({"scalerank")") == 0 || feature.properties.find(R"({"featurecla")") == 0,
                true);
      EXPECT_FALSE(digitize(feature.polygons, {.resolution = 300, .pixel = {}}).empty());
    }
    EXPECT_GT(count, vertices);
  }
}

TEST(RealPolygons, Icons) {
  REQUIRE_DATA("images/icon_oak.svg");
  for (const char* name : {"images/icon_oak.svg", "images/icon_octopus.svg"}) {
    const ReadPolygons r = read_polygons(data_file(name));
    ASSERT_EQ(r.features.size(), 1u) << name;
    EXPECT_EQ(r.features[0].number, 1u);
    EXPECT_EQ(r.notes.size(), 1u);
    const VoxelShape shape =
        digitize(r.features[0].polygons, {.resolution = 500, .pixel = {}, .fill = r.features[0].fill});
    EXPECT_GT(shape.voxel_count(), 50000);
    EXPECT_LT(shape.voxel_count(), 200000);
  }
}

}  // namespace polygon_files_test
