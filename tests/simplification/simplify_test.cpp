// SPDX-License-Identifier: Apache-2.0
#include "quench/simplify.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "medial_meshes.h"
#include "quench/error.h"
#include "simplification/mutable_complex.h"

namespace quench {
namespace simplify_test {

using testing_meshes::axis_of_box;
using testing_meshes::mesh_of;
using testing_meshes::random_mesh;
using testing_meshes::random_polygons;
using testing_meshes::subdivided;

/// The link condition by its definition: the cells that join a cell of both ends, as sets.
bool holds_link_condition(const simplification::MutableComplex& c, std::uint32_t a, std::uint32_t b) {
  using Cell = std::set<std::uint32_t>;
  std::set<Cell> cells;
  for (std::uint32_t v = 0; v < 64; ++v) cells.insert({v});  // of those that are left, edges tell
  for (std::uint32_t e = 0; e < c.edge_count(); ++e)
    if (c.has_edge(e)) cells.insert({c.ends(e)[0], c.ends(e)[1]});
  for (std::uint32_t t = 0; t < c.triangle_count(); ++t)
    if (c.has_triangle(t)) cells.insert({c.corners(t)[0], c.corners(t)[1], c.corners(t)[2]});
  const auto link = [&](const Cell& of) {
    std::set<Cell> result;
    for (Cell cell : cells) {
      const bool apart = std::ranges::none_of(of, [&](std::uint32_t v) { return cell.contains(v); });
      if (!apart) continue;
      Cell joined = cell;
      joined.insert(of.begin(), of.end());
      if (cells.contains(joined)) result.insert(cell);
    }
    return result;
  };
  const auto of_a = link({a}), of_b = link({b}), of_edge = link({a, b});
  std::set<Cell> both;
  std::ranges::set_intersection(of_a, of_b, std::inserter(both, both.end()));
  return both == of_edge;
}

TEST(MutableComplex, LinkConditionIsThatOfTheDefinition) {
  std::size_t may = 0, may_not = 0;
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    const MedialAxis mesh = random_mesh(seed, 9);
    simplification::MutableComplex complex(mesh.complex);
    std::mt19937_64 random(seed);
    for (bool left = true; left;) {
      left = false;
      std::vector<std::uint32_t> edges;
      for (std::uint32_t e = 0; e < complex.edge_count(); ++e)
        if (complex.has_edge(e)) edges.push_back(e);
      std::shuffle(edges.begin(), edges.end(), random);
      for (const std::uint32_t e : edges) {
        const bool holds = complex.may_collapse(e);
        ASSERT_EQ(holds, holds_link_condition(complex, complex.ends(e)[0], complex.ends(e)[1])) << "seed " << seed;
        ++(holds ? may : may_not);
        if (!holds) continue;
        complex.collapse(e, complex.ends(e)[random() % 2]);
        left = true;
        break;
      }
    }
  }
  EXPECT_GT(may, 3000u);
  EXPECT_GT(may_not, 1000u);
}

TEST(MedialMesh, PolygonsBecomeTrianglesOfTheSameTopology) {
  std::size_t centres = 0;
  for (std::uint64_t seed = 0; seed < 3000; ++seed) {
    const MedialAxis axis = random_polygons(seed);
    const MedialAxis mesh = medial_mesh_of(axis);
    ASSERT_NO_THROW(mesh.complex.validate()) << "seed " << seed;
    for (std::size_t f = 0; f < mesh.complex.face_count(); ++f) ASSERT_EQ(mesh.complex.corners(f).size(), 3u);
    ASSERT_EQ(topology(mesh.complex), topology(axis.complex)) << "seed " << seed;
    ASSERT_EQ(mesh.points.size(), mesh.complex.vertex_count);
    centres += mesh.points.size() > axis.points.size();
  }
  EXPECT_GT(centres, 100u);
}

TEST(MedialMesh, RefusesAxesWithoutBalls) {
  MedialAxis axis = axis_of_box(3, 2, 1);
  axis.radius[2] = -1;
  EXPECT_THROW(medial_mesh_of(axis), Error);
  axis.radius.clear();
  EXPECT_THROW(medial_mesh_of(axis), Error);
}

TEST(Simplify, TopologyStaysAtEveryLevelOfRandomComplexes) {
  for (std::uint64_t seed = 0; seed < 4000; ++seed) {
    const MedialAxis axis = seed % 3 == 0 ? random_polygons(seed) : random_mesh(seed, 14);
    const Topology wanted = topology(axis.complex);
    const Simplified result = simplify(axis, boundary_points(axis, 300), {.vertices = 3, .fits = 2});
    ASSERT_EQ(topology(result.axis.complex), wanted) << "seed " << seed;
    const CollapseSequence& sequence = result.sequence;
    for (std::size_t n = sequence.most(); n >= sequence.least(); --n) {
      const MedialAxis level = sequence.at(n);
      ASSERT_EQ(level.points.size(), n);
      ASSERT_NO_THROW(level.complex.validate()) << "seed " << seed;
      ASSERT_EQ(topology(level.complex), wanted) << "seed " << seed << ", " << n << " vertices";
      for (std::size_t v = 0; v < n; ++v) {
        ASSERT_TRUE(level.points[v].allFinite());
        ASSERT_GE(level.radius[v], 0);
      }
    }
  }
}

TEST(Simplify, CollapsesToTheFewestVerticesOfSimpleShapes) {
  const auto least = [](const MedialAxis& axis) {
    return simplify(axis, boundary_points(axis, 2000), {.vertices = 1, .fits = 0}).sequence.least();
  };
  std::vector<Vec3> ring;
  std::vector<std::array<std::uint32_t, 2>> path, closed;
  for (std::uint32_t i = 0; i < 40; ++i) {
    ring.emplace_back(std::cos(i * std::numbers::pi / 20), std::sin(i * std::numbers::pi / 20), 0);
    if (i > 0) path.push_back({i - 1, i});
  }
  closed = path;
  closed.push_back({0, 39});
  const std::vector<double> radius(40, 0.1);
  EXPECT_EQ(least(mesh_of(ring, radius, path, {})), 1u);
  EXPECT_EQ(least(mesh_of(ring, radius, closed, {})), 3u);
  EXPECT_EQ(least(subdivided(subdivided(medial_mesh_of(axis_of_box(3, 2, 1))))), 1u);
  const MedialAxis pocket = mesh_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {.1, .1, .1, .1}, {},
                                    {{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}});
  EXPECT_EQ(least(subdivided(subdivided(pocket))), 4u);
}

TEST(Simplify, CapsuleIsTwoBalls) {
  std::vector<Vec3> points;
  std::vector<double> radius;
  std::vector<std::array<std::uint32_t, 2>> edges;
  for (std::uint32_t i = 0; i <= 100; ++i) {
    points.emplace_back(0.03 * i, 0.01 * i, 0.02 * i);
    radius.push_back(0.5 + 0.001 * i);
    if (i > 0) edges.push_back({i - 1, i});
  }
  const MedialAxis axis = mesh_of(points, radius, edges, {});
  const Simplified result = simplify(axis, boundary_points(axis), {.vertices = 2});
  EXPECT_EQ(result.axis.points.size(), 2u);
  EXPECT_EQ(result.axis.complex.edges.size(), 1u);
  EXPECT_LT(result.errors.either.largest, 1e-3);
  const Simplified found = simplify(axis, boundary_points(axis), {.error = 1e-3});
  EXPECT_EQ(found.axis.points.size(), 2u);
}

TEST(Simplify, BoxIsTwelveBalls) {
  const MedialAxis axis = subdivided(subdivided(subdivided(medial_mesh_of(axis_of_box(3, 2, 1)))));
  ASSERT_GT(axis.points.size(), 500u);
  const BoundaryPoints boundary = boundary_points(axis);
  // They lie on the faces of the box.
  for (const Vec3& p : boundary.points)
    ASSERT_NEAR(std::max({std::abs(p[0]) / 3, std::abs(p[1]) / 2, std::abs(p[2])}), 1, 1e-9);
  const Simplified result = simplify(axis, boundary, {.vertices = 12, .fits = 50});
  EXPECT_EQ(result.axis.points.size(), 12u);
  EXPECT_LT(result.errors.either.mean, 0.003 * 6);
  EXPECT_LT(result.errors.either.largest, 0.03 * 6);
}

TEST(Simplify, AnErrorIsMetAtEveryPoint) {
  const MedialAxis axis = subdivided(subdivided(subdivided(medial_mesh_of(axis_of_box(3, 2, 1)))));
  const BoundaryPoints boundary = boundary_points(axis, 20000);
  std::size_t before = axis.points.size() + 1;
  for (const double error : {0.01, 0.1, 0.5}) {
    const Simplified result = simplify(axis, boundary, {.error = error});
    EXPECT_LE(errors_of(result.axis, boundary).either.largest, error);
    EXPECT_LE(result.axis.points.size(), before);
    before = result.axis.points.size();
  }
  EXPECT_LT(before, 60u);
  BoundaryPoints far = boundary;
  far.points.emplace_back(100, 0, 0);
  far.areas.push_back(0);
  EXPECT_THROW(simplify(axis, far, {.error = 0.01}), Error);
}

TEST(Simplify, DoesNotDependOnThreadsNorOnTheUnitOfLength) {
  const MedialAxis axis = subdivided(subdivided(random_mesh(7, 30)));
  const BoundaryPoints boundary = boundary_points(axis, 20000);
  Context one, two;
  one.threads = 1;
  two.threads = 2;
  const Simplified a = simplify(axis, boundary, {.vertices = 20}, &one),
                   b = simplify(axis, boundary, {.vertices = 20}, &two);
  EXPECT_EQ(a.axis.points, b.axis.points);
  EXPECT_EQ(a.axis.radius, b.axis.radius);
  EXPECT_EQ(a.axis.complex.edges, b.axis.complex.edges);
  MedialAxis larger = axis;
  for (Vec3& p : larger.points) p *= 1024;
  for (double& r : larger.radius) r *= 1024;
  BoundaryPoints far = boundary;
  for (Vec3& p : far.points) p *= 1024;
  for (double& area : far.areas) area *= 1024 * 1024;
  const Simplified c = simplify(larger, far, {.vertices = 20}, &one);
  EXPECT_EQ(c.axis.complex.edges, a.axis.complex.edges);
  for (std::size_t v = 0; v < a.axis.points.size(); ++v)
    EXPECT_LT((c.axis.points[v] / 1024 - a.axis.points[v]).norm(), 1e-9);
}

TEST(Simplify, SequencesCanBeginLater) {
  const MedialAxis axis = subdivided(subdivided(random_mesh(11, 20)));
  const CollapseSequence sequence = simplify(axis, boundary_points(axis, 5000), {.vertices = 5}).sequence;
  const CollapseSequence late = sequence.from(40);
  EXPECT_EQ(late.most(), 40u);
  EXPECT_EQ(late.least(), sequence.least());
  for (std::size_t n = 40; n >= sequence.least(); --n) {
    const MedialAxis a = sequence.at(n), b = late.at(n);
    ASSERT_EQ(a.points, b.points);
    ASSERT_EQ(a.radius, b.radius);
    ASSERT_EQ(a.complex.edges, b.complex.edges);
    ASSERT_EQ(a.complex.face_vertices, b.complex.face_vertices);
  }
}

TEST(Simplify, RefusesWhatItCannotDo) {
  const MedialAxis axis = axis_of_box(3, 2, 1);
  const BoundaryPoints boundary = boundary_points(axis, 100);
  EXPECT_THROW(simplify(axis, boundary, {.vertices = 0}), Error);
  EXPECT_THROW(simplify(axis, boundary, {.error = -1.0}), Error);
  MedialAxis plane = axis;
  plane.grid.make_plane();
  EXPECT_THROW(simplify(plane, boundary), Error);
}

TEST(BoundaryPoints, OfABallAndOfItsOwnEnvelope) {
  const MedialAxis ball = mesh_of({{1, 2, 3}}, {2}, {}, {});
  const BoundaryPoints boundary = boundary_points(ball, 1000);
  double area = 0;
  for (std::size_t i = 0; i < boundary.points.size(); ++i) {
    EXPECT_NEAR((boundary.points[i] - Vec3(1, 2, 3)).norm(), 2, 1e-12);
    area += boundary.areas[i];
  }
  EXPECT_NEAR(area, 16 * std::numbers::pi, 0.1);
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const MedialAxis mesh = random_mesh(seed);
    const OneSidedDistances errors = errors_of(mesh, boundary_points(mesh, 2000));
    ASSERT_LT(errors.either.largest, 1e-7) << "seed " << seed;
  }
}

TEST(Smooth, MovesNoFartherThanAllowedAndKeepsLinesApart) {
  std::mt19937_64 random(1);
  MedialAxis axis = subdivided(subdivided(subdivided(medial_mesh_of(axis_of_box(3, 2, 1)))));
  for (Vec3& p : axis.points)
    for (int k = 0; k < 3; ++k) p[k] += 0.02 * (static_cast<double>(random() % 1000) / 500 - 1);
  for (const double most : {0.0, 0.005, 0.03}) {
    MedialAxis smoothed = axis;
    smooth(smoothed, most);
    EXPECT_EQ(smoothed.complex.edges, axis.complex.edges);
    double moved = 0;
    for (std::size_t v = 0; v < axis.points.size(); ++v) {
      const double move = (smoothed.points[v] - axis.points[v]).norm();
      moved = std::max(moved, move);
      ASSERT_LE(move, most * (1 + 1e-12));
      ASSERT_LE(std::abs(smoothed.radius[v] - axis.radius[v]), most * (1 + 1e-12));
    }
    EXPECT_GE(moved, 0.9 * most);
    for (std::size_t v = 0; v < 12; ++v) EXPECT_EQ(smoothed.points[v], axis.points[v]) << "ends and junctions stay";
  }
}

TEST(Smooth, StraightensWhatIsRough) {
  std::vector<Vec3> points;
  std::vector<std::array<std::uint32_t, 2>> edges;
  for (std::uint32_t i = 0; i <= 60; ++i) {
    points.emplace_back(0.1 * i, i % 2 ? 0.02 : -0.02, 0);
    if (i > 0) edges.push_back({i - 1, i});
  }
  MedialAxis axis = mesh_of(points, std::vector<double>(61, 0.3), edges, {});
  smooth(axis, 0.05);
  for (std::size_t i = 5; i < 56; ++i) EXPECT_LT(std::abs(axis.points[i][1]), 0.005);
  EXPECT_EQ(axis.points.front(), points.front());
  EXPECT_EQ(axis.points.back(), points.back());
  EXPECT_THROW(smooth(axis, -1), Error);
  axis.radius.clear();
  EXPECT_THROW(smooth(axis, 1), Error);
}

}  // namespace simplify_test
}  // namespace quench
