// SPDX-License-Identifier: Apache-2.0
// Sheets with triangles of even size: closed forms, topology on random complexes and cores of random shapes.
#include <gtest/gtest.h>

#include <cmath>

#include "burn_shapes.h"
#include "full_run.h"
#include "part_facts.h"
#include "quench/axis.h"
#include "quench/error.h"
#include "quench/parts.h"
#include "random_complexes.h"
#include "random_shapes.h"

namespace quench {
namespace remesh_test {

using testing_complexes::Builder;
using testing_complexes::BurnInput;
using testing_complexes::random_input;
using testing_parts::facts_of;

SheetMesh mesh_of(const BurnInput& input) {
  const Parts parts = parts_of(input.complex, input.points, input.radius);
  return sheet_mesh(input.complex, input.points, input.radius, {}, parts);
}

double longest_edge(const SheetMesh& mesh) {
  double longest = 0;
  for (const auto& [ends, at] : testing_parts::edges_of(mesh.triangles))
    longest = std::max(longest, (mesh.points[ends[0]] - mesh.points[ends[1]]).norm());
  return longest;
}

double area_of(const SheetMesh& mesh) {
  double area = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) area += testing_parts::area_of(mesh, t);
  return area;
}

double smallest_angle(const SheetMesh& mesh) {
  double least = 180;
  for (const auto& t : mesh.triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3 u = (mesh.points[t[(i + 1) % 3]] - mesh.points[t[i]]).normalized(),
                 v = (mesh.points[t[(i + 2) % 3]] - mesh.points[t[i]]).normalized();
      least = std::min(least, std::acos(std::clamp(u.dot(v), -1.0, 1.0)) * 180 / std::numbers::pi);
    }
  return least;
}

// The farthest vertex of a mesh from the triangles of its sheet in another one.
double farthest(const SheetMesh& mesh, const SheetMesh& from) {
  double most = 0;
  std::set<std::pair<std::uint32_t, std::int32_t>> seen;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const std::uint32_t v : mesh.triangles[t]) {
      if (!seen.emplace(v, mesh.sheet[t]).second) continue;
      double least = 1e300;
      for (std::size_t f = 0; f < from.triangles.size(); ++f)
        if (from.sheet[f] == mesh.sheet[t])
          least = std::min(least, testing_parts::squared_distance(mesh.points[v], from.points[from.triangles[f][0]],
                                                                  from.points[from.triangles[f][1]],
                                                                  from.points[from.triangles[f][2]]));
      most = std::max(most, std::sqrt(least));
    }
  return most;
}

// Coarser and finer than the polygons: all of the plate, once, and its corners.
TEST(Remesh, OfAPlateIsEven) {
  Builder b;
  b.sheet({0, 0, 0}, {10, 0, 0}, {0, 6, 0}, 23, 17);
  const BurnInput input = b.input([](const Vec3& p) { return 1 + 0.1 * p[0] + 0.02 * p[1]; });
  const SheetMesh before = mesh_of(input);
  for (const double length : {0.2, 0.5, 1.0, 2.0}) {
    SCOPED_TRACE(length);
    const SheetMesh mesh = remeshed(before, {.length = length});
    EXPECT_EQ(facts_of(mesh), facts_of(before));
    EXPECT_NEAR(area_of(mesh), 60, 1e-9);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const auto& [p, q, r] = mesh.triangles[t];
      EXPECT_GT((mesh.points[q] - mesh.points[p]).cross(mesh.points[r] - mesh.points[p])[2], 0);
    }
    const auto edges = testing_parts::edges_of(mesh.triangles);
    double sum = 0;
    for (const auto& [ends, at] : edges) {
      const double size = (mesh.points[ends[0]] - mesh.points[ends[1]]).norm();
      EXPECT_LT(size, 1.6 * length);
      EXPECT_GT(size, 0.45 * length);
      sum += size;
    }
    EXPECT_NEAR(sum / static_cast<double>(edges.size()), length, 0.15 * length);
    EXPECT_GT(smallest_angle(mesh), 25);
    for (std::size_t v = 0; v < mesh.points.size(); ++v)
      EXPECT_NEAR(mesh.radius[v], 1 + 0.1 * mesh.points[v][0] + 0.02 * mesh.points[v][1], 1e-9);
  }
}

// Sheets of a T stay in their planes, and their seam is one line of common points.
TEST(Remesh, SeamsStayCommon) {
  const BurnInput input = testing_complexes::three_sheets().input;
  const SheetMesh before = mesh_of(input);
  for (const double length : {0.4, 1.0, 2.5}) {
    const SheetMesh mesh = remeshed(before, {.length = length});
    EXPECT_EQ(facts_of(mesh), facts_of(before));
    EXPECT_NEAR(area_of(mesh), 12 * (3 + 4 + 6), 1e-8);
    double along = 0;
    for (const auto& [a, b] : mesh.seam_edges) {
      along += (mesh.points[a] - mesh.points[b]).norm();
      for (const std::uint32_t v : {a, b}) EXPECT_LT(mesh.points[v].head<2>().norm(), 1e-9);
    }
    EXPECT_NEAR(along, 12, 1e-9);
    EXPECT_NEAR(static_cast<double>(mesh.seam_edges.size()), 12 / length, 0.35 * 12 / length);
    EXPECT_LT(farthest(mesh, before), 1e-9);
  }
}

// Straight rims stay; those of the strip, whose balls have radius 1, move by at most half of that.
TEST(Remesh, OfABoxAJunctionAndAMoebiusStrip) {
  const std::pair<BurnInput, double> inputs[] = {{testing_complexes::box_axis(9, 6, 4, 8).input, 1e-6},
                                                 {testing_complexes::tetrahedral_junction(2, 6).input, 1e-6},
                                                 {testing_complexes::moebius_strip(1.5, 3, 60, 5), 0.5}};
  for (const auto& [input, off] : inputs) {
    const SheetMesh before = mesh_of(input);
    for (const double length : {0.15, 0.5, 1.0, 30.0}) {
      const SheetMesh mesh = remeshed(before, {.length = length});
      EXPECT_EQ(facts_of(mesh), facts_of(before));
      EXPECT_LT(farthest(mesh, before), off + 1e-6);
    }
  }
}

// A curved sheet: points stay on it, and a coarse mesh has nearly its area.
TEST(Remesh, OfAHalfCylinder) {
  Builder b;
  const int n = 40;
  const auto at = [&](int i, int j) {
    const double turn = std::numbers::pi * i / n;
    return b.vertex({5 * std::cos(turn), 5 * std::sin(turn), 0.3 * j});
  };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < 40; ++j) b.face({at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
  const SheetMesh before = mesh_of(b.input([](const Vec3&) { return 1.0; }));
  const SheetMesh mesh = remeshed(before, {.length = 1});
  EXPECT_EQ(facts_of(mesh), facts_of(before));
  EXPECT_LT(farthest(mesh, before), 3e-3);  // its round rims, near their ends
  EXPECT_NEAR(area_of(mesh), area_of(before), 0.01 * area_of(before));
  EXPECT_GT(smallest_angle(mesh), 20);
}

// Teeth of a rim are gone where they are smaller than the triangles, and the corners of the plate stay.
TEST(Remesh, SmoothsARaggedRim) {
  Builder b;
  const int n = 60;
  for (int i = 0; i < n; ++i) {
    const double x = 10.0 * i / n, step = 10.0 / n, tooth = i % 2 ? 0.25 : -0.25;
    const double low = i == 0 ? 0 : -tooth, high = i + 1 == n ? 0 : tooth;
    b.face({Vec3(x, 0, 0), Vec3(x + step, 0, 0), Vec3(x + step, 4, 0), Vec3(x, 4, 0)});
    b.face({Vec3(x, 4, 0), Vec3(x + step, 4, 0), Vec3(x + step, 5 + high, 0), Vec3(x, 5 + low, 0)});
  }
  const SheetMesh before = mesh_of(b.input([](const Vec3&) { return 2.0; }));
  const SheetMesh mesh = remeshed(before, {.length = 0.8});
  EXPECT_EQ(facts_of(mesh), facts_of(before));
  EXPECT_NEAR(area_of(mesh), 50, 0.3);
  std::size_t corners = 0;
  for (const Vec3& p : mesh.points) {
    if (p[1] > 4.6) {
      EXPECT_NEAR(p[1], 5, 0.06);
    }
    for (const Vec3& corner : {Vec3(0, 0, 0), Vec3(10, 0, 0), Vec3(0, 5, 0), Vec3(10, 5, 0)})
      corners += (p - corner).norm() < 1e-9;
  }
  EXPECT_EQ(corners, 4u);
}

// Random complexes are tangles of triangles in space: no operation may change what meets what.
TEST(Remesh, KeepsTheTopologyOfRandomComplexes) {
  std::size_t coarser = 0;
  for (std::uint64_t seed = 0; seed < 2500 && !testing::Test::HasFailure(); ++seed) {
    SCOPED_TRACE(seed);
    const SheetMesh before = mesh_of(random_input(seed));
    if (before.triangles.empty()) continue;
    const double longest = longest_edge(before), lengths[] = {0.12, 0.3, 0.7, 2.0, 20.0};
    const SheetMesh mesh = remeshed(before, {.length = lengths[seed % 5] * longest, .rounds = 3});
    ASSERT_EQ(facts_of(mesh), facts_of(before));
    coarser += mesh.triangles.size() < before.triangles.size();
  }
  EXPECT_GT(coarser, 300u);
}

// Cores of random voxel shapes, all teeth: sheets, seams and junctions as the voxels have them.
TEST(Remesh, KeepsTheTopologyOfCores) {
  std::size_t seams = 0;
  const std::uint64_t seeds = repeats(500, 200);
  for (std::uint64_t seed = 0; seed < seeds && !testing::Test::HasFailure(); ++seed) {
    SCOPED_TRACE(seed);
    const MedialAxis axis = voxel_core(testing_shapes::random_shape(seed, 8, seed % 3 == 0));
    const Parts parts = parts_of(axis.complex, axis.points, axis.radius);
    const SheetMesh before = sheet_mesh(axis.complex, axis.points, axis.radius, {}, parts);
    if (before.triangles.empty()) continue;
    const double lengths[] = {0.4, 1.0, 2.0, 5.0};
    const SheetMesh mesh = remeshed(before, {.length = lengths[seed % 4], .rounds = 3});
    ASSERT_EQ(facts_of(mesh), facts_of(before));
    seams += parts.seams.size();
  }
  EXPECT_GT(seams, 5 * seeds);
}

TEST(Remesh, IsTheSameForAnyNumberOfThreads) {
  const BurnInput input = testing_complexes::box_axis(9, 6, 4, 8).input;
  const SheetMesh before = mesh_of(input);
  Context one, four;
  one.threads = 1;
  four.threads = 4;
  const SheetMesh a = remeshed(before, {.length = 0.5}, &one), b = remeshed(before, {.length = 0.5}, &four);
  EXPECT_EQ(a.triangles, b.triangles);
  EXPECT_EQ(a.points, b.points);
  EXPECT_EQ(a.radius, b.radius);
}

TEST(Remesh, RefusesNoLength) {
  for (const double length : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()})
    EXPECT_THROW(remeshed(SheetMesh{}, {.length = length}), Error);
}

}  // namespace remesh_test
}  // namespace quench
