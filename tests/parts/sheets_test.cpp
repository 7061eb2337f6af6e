// SPDX-License-Identifier: Apache-2.0
// Sheets, seams and junctions: closed forms, and what walking finds of random complexes.
#include "quench/parts.h"

#include <gtest/gtest.h>

#include <cmath>
#include <queue>

#include "burn_shapes.h"
#include "part_facts.h"
#include "quench/error.h"
#include "random_complexes.h"

namespace quench {
namespace sheets_test {

using testing_complexes::Builder;
using testing_complexes::BurnInput;
using testing_complexes::random_input;

Parts parts_of(const BurnInput& input, const PartsOptions& options = {}) {
  return quench::parts_of(input.complex, input.points, input.radius, {}, options);
}
SheetMesh mesh_of(const BurnInput& input, const Parts& parts) {
  return sheet_mesh(input.complex, input.points, input.radius, {}, parts);
}

TEST(Parts, OfAPlate) {
  Builder b;
  b.sheet({1, 2, 3}, {10, 0, 0}, {0, 6, 0}, 5, 4, false);
  const BurnInput input = b.input([](const Vec3& p) { return 1 + 0.1 * p[0]; });
  const Parts parts = parts_of(input, {.more_radius = 0.5});
  ASSERT_EQ(parts.sheets.size(), 1u);
  EXPECT_TRUE(parts.seams.empty());
  EXPECT_TRUE(parts.junctions.empty());
  const Sheet& sheet = parts.sheets[0];
  EXPECT_EQ(sheet.faces, 20u);
  EXPECT_NEAR(sheet.area, 60, 1e-12);
  EXPECT_NEAR(sheet.mean_thickness, 2 * (1 + 0.6 + 0.5), 1e-12);
  EXPECT_NEAR(sheet.min_thickness, 2 * (1.1 + 0.5), 1e-12);
  EXPECT_NEAR(sheet.max_thickness, 2 * (2.1 + 0.5), 1e-12);
  EXPECT_TRUE(std::isnan(sheet.mean_erosion));
  EXPECT_NEAR(sheet.rim_length, 32, 1e-12);
  EXPECT_EQ(sheet.seam_length, 0);
  EXPECT_EQ(sheet.borders, 1u);
  EXPECT_EQ(sheet.euler, 1);
  EXPECT_TRUE(sheet.orientable);
  EXPECT_LT((sheet.centre - Vec3(6, 5, 3)).norm(), 1e-12);
  EXPECT_LT((sheet.normal - Vec3::UnitZ()).norm(), 1e-12);
  EXPECT_LT(sheet.flatness, 1e-12);
}

// A web of height 4 on the middle of a flange of width 6: three sheets on one seam.
TEST(Parts, OfAT) {
  Builder b;
  for (const Vec3& across : {Vec3(-3, 0, 0), Vec3(3, 0, 0), Vec3(0, 0, 4)})
    b.sheet({0, 0, 0}, {0, 10, 0}, across, 10, 4);
  const BurnInput input = b.input([](const Vec3& p) { return 1 + 0.01 * p[1]; });
  const Parts parts = parts_of(input);
  ASSERT_EQ(parts.sheets.size(), 3u);
  ASSERT_EQ(parts.seams.size(), 1u);
  ASSERT_EQ(parts.junctions.size(), 2u);
  const Seam& seam = parts.seams[0];
  EXPECT_NEAR(seam.length, 10, 1e-12);
  EXPECT_NEAR(seam.mean_thickness, 2.1, 1e-12);
  EXPECT_NEAR(seam.min_thickness, 2, 1e-12);
  EXPECT_NEAR(seam.max_thickness, 2.2, 1e-12);
  EXPECT_FALSE(seam.closed);
  EXPECT_EQ(seam.sheets, (std::vector<std::uint32_t>{0, 1, 2}));
  EXPECT_EQ(seam.ends, (std::array<std::uint32_t, 2>{0, 1}));
  for (std::uint32_t s = 0; s < 3; ++s) {
    const Sheet& sheet = parts.sheets[s];
    EXPECT_NEAR(sheet.seam_length, 10, 1e-12);
    EXPECT_NEAR(sheet.area, s == 2 ? 40 : 30, 1e-12);
    EXPECT_NEAR(sheet.rim_length, s == 2 ? 18 : 16, 1e-12);
    EXPECT_EQ(sheet.seams, std::vector<std::uint32_t>{0});
    EXPECT_EQ(sheet.neighbours.size(), 2u);
    EXPECT_EQ(std::ranges::count(sheet.neighbours, s), 0);
  }
  EXPECT_EQ(parts.by_area().front(), 2u);
  EXPECT_EQ(parts.junctions[0].seams, std::vector<std::uint32_t>{0});
  EXPECT_EQ(parts.junctions[1].sheets, (std::vector<std::uint32_t>{0, 1, 2}));
}

// Three plates across each other: twelve quarters, six seams, one junction in the middle and an end of each seam.
TEST(Parts, OfACrossOfPlates) {
  Builder b;
  for (int across = 0; across < 3; ++across)
    for (const double u : {-2.0, 2.0})
      for (const double v : {-2.0, 2.0})
        b.sheet(Vec3::Zero(), u * Vec3::Unit((across + 1) % 3), v * Vec3::Unit((across + 2) % 3), 3, 3, false);
  const Parts parts = parts_of(b.input([](const Vec3&) { return 1.0; }));
  EXPECT_EQ(parts.sheets.size(), 12u);
  EXPECT_EQ(parts.seams.size(), 6u);
  ASSERT_EQ(parts.junctions.size(), 7u);
  for (const Seam& seam : parts.seams) {
    EXPECT_NEAR(seam.length, 2, 1e-12);
    EXPECT_EQ(seam.sheets.size(), 4u);
  }
  for (const Sheet& sheet : parts.sheets) {
    EXPECT_NEAR(sheet.area, 4, 1e-12);
    EXPECT_EQ(sheet.seams.size(), 2u);
    EXPECT_EQ(sheet.neighbours.size(), 6u);
  }
}

// The medial axis of a box: areas and mean thicknesses of its 13 sheets are those of rectangles, trapezoids, triangles.
TEST(Parts, OfABox) {
  const double a = 9, b = 6, c = 4, h = c / 2, slant = std::sqrt(2.0);
  const BurnInput input = testing_complexes::box_axis(a, b, c, 6).input;
  const Parts parts = parts_of(input);
  ASSERT_EQ(parts.sheets.size(), 13u);
  EXPECT_EQ(parts.seams.size(), 12u);
  EXPECT_EQ(parts.junctions.size(), 12u);
  std::multiset<std::pair<long, long>> got, wanted;  // area and mean thickness
  const auto round = [](double area, double thickness) {
    return std::pair(std::lround(1e6 * area), std::lround(1e6 * thickness));
  };
  for (const Sheet& sheet : parts.sheets) got.insert(round(sheet.area, sheet.mean_thickness));
  wanted.insert(round((a - c) * (b - c), c));
  for (const double side : {a, b})
    for (int i = 0; i < 4; ++i)
      wanted.insert(round((side + side - c) / 2 * h * slant, 2 * h * (3 * side - 2 * c) / (6 * side - 3 * c)));
  for (int i = 0; i < 4; ++i) wanted.insert(round(c / 2 * h * slant, 2 * h / 3));
  EXPECT_EQ(got, wanted);
  for (const Sheet& sheet : parts.sheets) {
    EXPECT_LT(sheet.flatness, 1e-9);
    EXPECT_EQ(sheet.euler, 1);
    EXPECT_EQ(sheet.borders, 1u);
  }
}

TEST(Parts, OfAMoebiusStrip) {
  const Parts parts = parts_of(testing_complexes::moebius_strip(1, 3, 30, 3));
  ASSERT_EQ(parts.sheets.size(), 1u);
  EXPECT_FALSE(parts.sheets[0].orientable);
  EXPECT_EQ(parts.sheets[0].borders, 1u);
  EXPECT_EQ(parts.sheets[0].euler, 0);
}

TEST(Parts, OfACylinderAndOfASphere) {
  Builder b;
  std::vector<std::uint32_t> low, high;
  for (int i = 0; i < 12; ++i) {
    const double turn = 2 * std::numbers::pi * i / 12;
    low.push_back(b.vertex({std::cos(turn), std::sin(turn), 0}));
    high.push_back(b.vertex({std::cos(turn), std::sin(turn), 1}));
  }
  for (std::size_t i = 0; i < 12; ++i) {
    const std::size_t n = (i + 1) % 12;
    b.face({low[i], low[n], high[n], high[i]});
  }
  const Parts ring = parts_of(b.input([](const Vec3&) { return 1.0; }));
  EXPECT_EQ(ring.sheets.at(0).borders, 2u);
  EXPECT_EQ(ring.sheets.at(0).euler, 0);
  EXPECT_TRUE(ring.sheets.at(0).orientable);
  b.cone(b.vertex({0, 0, -1}), low);
  b.cone(b.vertex({0, 0, 2}), high);
  const Parts ball = parts_of(b.input([](const Vec3&) { return 1.0; }));
  EXPECT_EQ(ball.sheets.at(0).borders, 0u);
  EXPECT_EQ(ball.sheets.at(0).euler, 2);
  EXPECT_EQ(ball.sheets.at(0).boundary_length(), 0);
}

// A sheet whose two sides meet along an edge inside of it, at a fin: its mesh is cut there and stays cut.
TEST(Parts, AFinOnOneEdgeInsideASheet) {
  Builder b;
  b.sheet({0, 0, 0}, {3, 0, 0}, {0, 3, 0}, 3, 3);
  b.face({Vec3(1, 1, 0), Vec3(2, 1, 0), Vec3(1.5, 1, 1)});
  const BurnInput input = b.input([](const Vec3&) { return 1.0; });
  const Parts parts = parts_of(input);
  ASSERT_EQ(parts.sheets.size(), 2u);
  EXPECT_EQ(parts.seams.at(0).sheets, (std::vector<std::uint32_t>{0, 0, 1}));
  EXPECT_EQ(parts.sheets[0].neighbours, (std::vector<std::uint32_t>{0, 1}));
  EXPECT_NEAR(parts.sheets[0].seam_length, 2, 1e-12);
  EXPECT_EQ(parts.sheets[0].borders, 2u);
  EXPECT_EQ(parts.sheets[0].euler, 0);
  const std::vector<Record> records = sheet_records(mesh_of(input, parts));
  const testing_parts::SheetShape shape = testing_parts::shape_of(records.at(0));
  EXPECT_EQ(shape.borders, 2u);
  EXPECT_EQ(shape.euler, 0);
}

TEST(Parts, OfNothingAndOfCurves) {
  Builder b;
  b.polyline({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(2, 0, 1)});
  const BurnInput input = b.input([](const Vec3&) { return 1.0; });
  const Parts parts = parts_of(input);
  EXPECT_TRUE(parts.sheets.empty());
  EXPECT_EQ(sheet_table(parts).rows, 0u);
  EXPECT_TRUE(mesh_of(input, parts).triangles.empty());
  EXPECT_TRUE(remeshed(mesh_of(input, parts), {.length = 1}).triangles.empty());
}

TEST(Parts, RefusesValuesOfOtherComplexes) {
  const BurnInput input = random_input(3);
  EXPECT_THROW(quench::parts_of(input.complex, input.points, {}, {}), Error);
  const std::vector<double> erosion(input.complex.face_count() + 1, 0);
  EXPECT_THROW(quench::parts_of(input.complex, input.points, input.radius, erosion), Error);
}

// Tables against sums over what is found by walking from face to face.
TEST(Parts, AreThoseOfWalking) {
  std::size_t seams = 0, rings = 0, twice = 0;
  for (std::uint64_t seed = 0; seed < 3000 && !testing::Test::HasFailure(); ++seed) {
    SCOPED_TRACE(seed);
    const BurnInput input = random_input(seed);
    const CellComplex& c = input.complex;
    std::vector<double> erosion;
    for (std::size_t f = 0; f < c.face_count(); ++f) erosion.push_back(0.25 * static_cast<double>(f % 7));
    const Parts parts = quench::parts_of(c, input.points, input.radius, erosion);
    std::vector<std::vector<std::uint32_t>> faces_at(c.edges.size());
    for (std::uint32_t f = 0; f < c.face_count(); ++f)
      for (const std::uint32_t e : c.sides(f)) faces_at[e].push_back(f);
    // Sheets by walking, in the order of their first faces.
    std::vector<int> sheet(c.face_count(), -1);
    int sheets = 0;
    for (std::uint32_t f = 0; f < c.face_count(); ++f) {
      if (sheet[f] >= 0) continue;
      std::queue<std::uint32_t> open({f});
      sheet[f] = sheets;
      for (; !open.empty(); open.pop())
        for (const std::uint32_t e : c.sides(open.front()))
          if (faces_at[e].size() == 2)
            for (const std::uint32_t g : faces_at[e])
              if (sheet[g] < 0) sheet[g] = sheets, open.push(g);
      ++sheets;
    }
    ASSERT_EQ(parts.sheets.size(), static_cast<std::size_t>(sheets));
    std::vector<double> rim(parts.sheets.size(), 0), seam(parts.sheets.size(), 0), area(parts.sheets.size(), 0),
        most(parts.sheets.size(), 0), least(parts.sheets.size(), 1e9), highest(parts.sheets.size(), 0);
    std::vector<std::set<std::uint32_t>> meets(parts.sheets.size());
    for (std::uint32_t e = 0; e < c.edges.size(); ++e) {
      const double length = (input.points[c.edges[e][0]] - input.points[c.edges[e][1]]).norm();
      for (const std::uint32_t f : faces_at[e]) {
        const auto s = static_cast<std::size_t>(sheet[f]);
        if (faces_at[e].size() == 1) rim[s] += length;
        if (faces_at[e].size() < 3) continue;
        seam[s] += length;
        int own = 0;
        for (const std::uint32_t g : faces_at[e]) {
          own += sheet[g] == sheet[f];
          if (sheet[g] != sheet[f]) meets[s].insert(static_cast<std::uint32_t>(sheet[g]));
        }
        if (own > 1) meets[s].insert(static_cast<std::uint32_t>(s)), ++twice;
      }
    }
    for (std::uint32_t f = 0; f < c.face_count(); ++f) {
      const auto s = static_cast<std::size_t>(sheet[f]);
      const auto corners = c.corners(f);
      Vec3 normal = Vec3::Zero();  // convex polygons of a plane
      for (std::size_t i = 2; i < corners.size(); ++i)
        normal += (input.points[corners[i - 1]] - input.points[corners[0]])
                      .cross(input.points[corners[i]] - input.points[corners[0]]);
      area[s] += 0.5 * normal.norm();
      for (const std::uint32_t v : corners) {
        most[s] = std::max(most[s], 2 * input.radius[v]);
        least[s] = std::min(least[s], 2 * input.radius[v]);
      }
      highest[s] = std::max(highest[s], erosion[f]);
    }
    for (std::size_t s = 0; s < parts.sheets.size(); ++s) {
      const Sheet& got = parts.sheets[s];
      EXPECT_NEAR(got.rim_length, rim[s], 1e-9);
      EXPECT_NEAR(got.seam_length, seam[s], 1e-9);
      EXPECT_NEAR(got.area, area[s], 1e-9 * (1 + area[s]));
      EXPECT_EQ(got.max_erosion, highest[s]);
      EXPECT_LE(got.mean_erosion, highest[s]);
      EXPECT_GE(got.min_thickness, least[s] - 1e-12);
      EXPECT_LE(got.max_thickness, most[s] + 1e-12);
      EXPECT_LE(got.min_thickness, got.mean_thickness);
      EXPECT_LE(got.mean_thickness, got.max_thickness);
      EXPECT_EQ(std::set<std::uint32_t>(got.neighbours.begin(), got.neighbours.end()), meets[s]);
      rings += got.borders != 1;
    }
    seams += parts.seams.size();
    // The meshes: manifolds, of the shape that the table says and of its area.
    const SheetMesh mesh = mesh_of(input, parts);
    std::vector<double> of_mesh(parts.sheets.size(), 0);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      of_mesh[static_cast<std::size_t>(mesh.sheet[t])] += testing_parts::area_of(mesh, t);
    const testing_parts::MeshFacts facts = testing_parts::facts_of(mesh);
    ASSERT_EQ(facts.sheets.size(), parts.sheets.size());
    for (std::size_t s = 0; s < parts.sheets.size(); ++s) {
      EXPECT_NEAR(of_mesh[s], parts.sheets[s].area, 1e-9 * (1 + area[s]));
      EXPECT_EQ(facts.sheets[s].euler, parts.sheets[s].euler);
      EXPECT_EQ(facts.sheets[s].borders, parts.sheets[s].borders);
      EXPECT_EQ(facts.sheets[s].orientable, parts.sheets[s].orientable);
    }
    ASSERT_EQ(facts.sheets_of_seam.size(), parts.seams.size());
    for (const auto& [s, sheets_there] : facts.sheets_of_seam) {
      const Seam& got = parts.seams[static_cast<std::size_t>(s)];
      EXPECT_EQ(std::vector<std::uint32_t>(sheets_there.begin(), sheets_there.end()), got.sheets);
      EXPECT_EQ(facts.closed.at(s), got.closed);
    }
  }
  EXPECT_GT(seams, 3000u);
  EXPECT_GT(rings, 100u);
  EXPECT_GT(twice, 100u);
}

TEST(Parts, TablesHaveARowEach) {
  const Parts parts = parts_of(testing_complexes::box_axis(9, 6, 4, 4).input);
  const Table sheets = sheet_table(parts, "mm");
  EXPECT_EQ(sheets.rows, 13u);
  const auto& areas = std::get<std::vector<double>>(sheets.find("area")->values);
  EXPECT_TRUE(std::ranges::is_sorted(areas, std::greater<>()));
  EXPECT_EQ(sheets.find("area")->unit, "mm^2");
  EXPECT_EQ(seam_table(parts).rows, 12u);
  EXPECT_EQ(junction_table(parts).rows, 12u);
  for (const Table& table : {sheets, seam_table(parts), junction_table(parts)})
    for (const Table::Column& column : table.columns) {
      EXPECT_EQ(std::visit([](const auto& v) { return v.size(); }, column.values), table.rows) << column.name;
      EXPECT_FALSE(column.meaning.empty()) << column.name;
    }
}

}  // namespace sheets_test
}  // namespace quench
