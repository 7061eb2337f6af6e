// SPDX-License-Identifier: Apache-2.0
#include "surface/solid_boundary.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <random>

#include "closed_surfaces.h"
#include "data.h"
#include "full_run.h"
#include "quench/io.h"
#include "quench/samples.h"
#include "random_meshes.h"

namespace quench {
namespace solid_boundary_test {

using surface::solid_boundary;

using testing_surfaces::volume_of;
using testing_surfaces::winding_number;

double area(const TriangleMesh& mesh) {
  double sum = 0;
  for (const auto& t : mesh.triangles)
    sum += (mesh.points[t[1]] - mesh.points[t[0]]).cross(mesh.points[t[2]] - mesh.points[t[0]]).norm() / 2;
  return sum;
}

TriangleMesh joined(TriangleMesh a, const TriangleMesh& b) {
  const auto offset = static_cast<std::uint32_t>(a.points.size());
  a.points.insert(a.points.end(), b.points.begin(), b.points.end());
  for (const auto& t : b.triangles) a.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  return a;
}

TriangleMesh moved(TriangleMesh mesh, const Vec3& by, double scale = 1) {
  for (Vec3& p : mesh.points) p = scale * p + by;
  return mesh;
}

TriangleMesh turned(TriangleMesh mesh) {
  for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

TriangleMesh rotated(TriangleMesh mesh, double angle, const Vec3& axis) {
  const Mat3 turn = Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
  for (Vec3& p : mesh.points) p = turn * p;
  return mesh;
}

TriangleMesh box(const testing_meshes::Point& low, const testing_meshes::Point& high) {
  TriangleMesh mesh;
  testing_meshes::add_box(mesh, low, high);
  return mesh;
}

/// Around the origin, of radius 1: an octahedron whose faces are divided into n * n triangles.
TriangleMesh ball(std::uint32_t n) {
  TriangleMesh mesh;
  for (int octant = 0; octant < 8; ++octant) {
    const Vec3 sign(octant & 1 ? -1 : 1, octant & 2 ? -1 : 1, octant & 4 ? -1 : 1);
    std::vector<std::vector<std::uint32_t>> at(n + 1);
    for (std::uint32_t i = 0; i <= n; ++i)
      for (std::uint32_t j = 0; i + j <= n; ++j) {
        at[i].push_back(static_cast<std::uint32_t>(mesh.points.size()));
        mesh.points.push_back(sign.cwiseProduct(Vec3(i, j, n - i - j).normalized()));
      }
    const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
      if (sign.prod() > 0)
        mesh.triangles.push_back({a, b, c});
      else
        mesh.triangles.push_back({a, c, b});
    };
    for (std::uint32_t i = 0; i < n; ++i)
      for (std::uint32_t j = 0; i + j < n; ++j) {
        add(at[i][j], at[i + 1][j], at[i][j + 1]);
        if (i + j + 1 < n) add(at[i + 1][j], at[i + 1][j + 1], at[i][j + 1]);
      }
  }
  return mesh;
}

/// Sides, by the places of their ends, that are not there as often in one direction as in the other.
std::size_t open_sides(const TriangleMesh& mesh) {
  const auto key = [&](std::uint32_t i) {
    const Vec3& p = mesh.points[i];
    return std::array<double, 3>{p[0] + 0.0, p[1] + 0.0, p[2] + 0.0};
  };
  std::map<std::array<std::array<double, 3>, 2>, int> balance;
  for (const auto& t : mesh.triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      const auto a = key(t[i]), b = key(t[(i + 1) % 3]);
      a < b ? ++balance[{a, b}] : --balance[{b, a}];
    }
  return static_cast<std::size_t>(
      std::count_if(balance.begin(), balance.end(), [](const auto& e) { return e.second != 0; }));
}

/// The result must have the winding number 1 in the solid and 0 outside it, at random points.
void expect_boundary(const TriangleMesh& mesh, bool odd, const TriangleMesh& result, int points,
                     std::mt19937_64& random) {
  EXPECT_LE(open_sides(result), result.triangles.size() / 10000);  // where pieces are too narrow
  Vec3 low = mesh.points[0], high = low;
  for (const Vec3& p : mesh.points) low = low.cwiseMin(p), high = high.cwiseMax(p);
  for (int i = 0; i < points; ++i) {
    Vec3 p;
    for (int a = 0; a < 3; ++a) p[a] = std::uniform_real_distribution<>(low[a] - 0.01, high[a] + 0.01)(random);
    const auto w = std::lround(winding_number(mesh, p));
    const bool inside = odd ? w % 2 != 0 : w != 0;
    ASSERT_NEAR(winding_number(result, p), inside ? 1 : 0, 1e-6) << "at " << p.transpose() << ", winding number " << w;
  }
}

TEST(SolidBoundary, KeepsSoundMeshes) {
  for (const auto& info : built_in_samples()) {
    if (info.name == "root" || info.name == "bead-pack") continue;  // parts overlap
    const TriangleMesh mesh = make_sample(info.name, {.fineness = repeats(0.5, 0.25)}).mesh;
    EXPECT_EQ(solid_boundary(mesh).triangles, mesh.triangles) << info.name;
    EXPECT_EQ(solid_boundary(mesh, true).triangles, mesh.triangles) << info.name;
    EXPECT_EQ(solid_boundary(turned(mesh)).points, mesh.points) << info.name;
  }
}

TEST(SolidBoundary, TurnsWhatFacesInward) {
  const TriangleMesh torus = make_sample("torus").mesh;
  EXPECT_EQ(solid_boundary(turned(torus)).triangles, turned(turned(torus)).triangles);
  EXPECT_NEAR(volume_of(solid_boundary(turned(torus))), volume_of(torus), 1e-12);
}

TEST(SolidBoundary, NestedShells) {
  const TriangleMesh outer = box({0, 0, 0}, {10, 10, 10}), inner = box({3, 3, 3}, {7, 7, 7});
  EXPECT_DOUBLE_EQ(volume_of(solid_boundary(joined(outer, inner))), 1000);  // wound twice
  EXPECT_DOUBLE_EQ(area(solid_boundary(joined(outer, inner))), 600);
  EXPECT_DOUBLE_EQ(volume_of(solid_boundary(joined(outer, turned(inner)))), 1000 - 64);
  EXPECT_DOUBLE_EQ(volume_of(solid_boundary(joined(outer, inner), true)), 1000 - 64);
}

TEST(SolidBoundary, OverlappingBoxes) {
  const TriangleMesh a = box({0, 0, 0}, {10, 10, 10}), b = box({4, 5, 6}, {14, 15, 16});
  for (const double angle : {0.0, 0.3}) {  // planes along the axes, and not
    const TriangleMesh both = rotated(joined(a, b), angle, {1, 2, 3});
    const TriangleMesh result = solid_boundary(both);
    EXPECT_NEAR(volume_of(result), 2000 - 6 * 5 * 4, 1e-8);
    EXPECT_NEAR(area(result), 1200 - 2 * (6 * 5 + 5 * 4 + 6 * 4), 1e-8);
    EXPECT_NEAR(volume_of(solid_boundary(both, true)), 2000 - 2 * 6 * 5 * 4, 1e-8);
  }
}

// Parts with common planes, edges and corners, and parts that are there twice.
TEST(SolidBoundary, TouchingBoxes) {
  const TriangleMesh a = box({0, 0, 0}, {10, 10, 10});
  const auto with = [&](const TriangleMesh& b) { return solid_boundary(rotated(joined(a, b), 0.3, {1, 2, 3})); };
  const TriangleMesh stacked = with(box({0, 0, 10}, {10, 10, 15})), on_top = with(box({2, 3, 10}, {7, 8, 15}));
  EXPECT_NEAR(area(stacked), 2 * 100 + 4 * 150, 1e-8);
  EXPECT_NEAR(volume_of(on_top), 1000 + 125, 1e-8);
  EXPECT_NEAR(area(on_top), 600 + 4 * 25, 1e-8);
  EXPECT_NEAR(area(with(box({10, 10, 0}, {20, 20, 10}))), 1200, 1e-8);   // a common edge
  EXPECT_NEAR(area(with(box({10, 10, 10}, {20, 20, 20}))), 1200, 1e-8);  // a common corner
  EXPECT_NEAR(area(with(a)), 600, 1e-8);
  EXPECT_NEAR(volume_of(with(a)), 1000, 1e-8);
  EXPECT_NEAR(area(with(box({5, 0, 0}, {20, 10, 10}))), 2 * 100 + 4 * 200, 1e-8);
  EXPECT_EQ(solid_boundary(joined(a, turned(a))).triangles.size(), 0u);
}

// A cap of height h is missing of each ball.
TEST(SolidBoundary, OverlappingBalls) {
  const double h = 0.4, pi = std::numbers::pi;
  const TriangleMesh one = ball(40), both = joined(one, moved(one, 2 * (1 - h) * Vec3(1, 2, 0.5).normalized()));
  const TriangleMesh result = solid_boundary(both);
  EXPECT_NEAR(area(result) / (2 * (4 * pi - 2 * pi * h)), 1, 1e-3);
  EXPECT_NEAR(volume_of(result) / (2 * (4 * pi / 3 - pi * h * h * (3 - h) / 3)), 1, 2e-3);
  std::mt19937_64 random(1);
  expect_boundary(both, false, result, 100, random);
}

// A large triangle that is cut along a curve of many segments.
TEST(SolidBoundary, FineBallInCoarseBox) {
  const TriangleMesh both = joined(moved(box({-1, -1, -1}, {1, 1, 1}), Vec3(0.01, 0.02, -1.03), 1.2), ball(60));
  const TriangleMesh result = solid_boundary(both);
  EXPECT_LT(result.triangles.size(), both.triangles.size());
  std::mt19937_64 random(1);
  expect_boundary(both, false, result, 100, random);
}

// Parts of any orientation and position on small integers: most planes, edges and corners meet.
TEST(SolidBoundary, RandomPartsOnIntegers) {
  std::mt19937_64 random(7);
  for (int i = 0; i < 400; ++i) {
    TriangleMesh mesh = testing_meshes::random_mesh(random, 4 + i % 9);
    if (i % 2 == 1) mesh = rotated(mesh, 0.1 * i, {1, 2, 3});
    for (const bool odd : {false, true}) {
      SCOPED_TRACE(testing::Message() << "mesh " << i << (odd ? ", odd" : ""));
      expect_boundary(mesh, odd, solid_boundary(mesh, odd), 30, random);
      if (HasFatalFailure()) return;
    }
  }
}

TEST(SolidBoundary, Root) {
  const TriangleMesh mesh = make_sample("root", {.branches = 20, .fineness = 0.5}).mesh;
  const TriangleMesh result = solid_boundary(mesh);
  EXPECT_LT(volume_of(result), volume_of(mesh));
  std::mt19937_64 random(1);
  expect_boundary(mesh, false, result, 100, random);
  for (std::size_t t = 0; t < result.triangles.size(); t += 50) {  // points on both sides
    const auto& [i, j, k] = result.triangles[t];
    const Vec3 &a = result.points[i], &b = result.points[j], &c = result.points[k];
    const Vec3 normal = (b - a).cross(c - a), middle = (a + b + c) / 3;
    const double width = normal.norm() / ((b - a).norm() + (c - b).norm() + (a - c).norm());
    if (width < 1e-9 * longest_side_of(mesh.points)) continue;
    EXPECT_EQ(std::lround(winding_number(mesh, middle + 0.01 * width * normal.normalized())), 0) << t;
    EXPECT_NE(std::lround(winding_number(mesh, middle - 0.01 * width * normal.normalized())), 0) << t;
  }
  Context one;
  one.threads = 1;
  EXPECT_EQ(solid_boundary(mesh, false, &one).triangles, result.triangles);
}

TriangleMesh read_triangles(const char* name) {
  const Record record = io::read_record(data_file(name));
  TriangleMesh mesh{record.points, {}};
  for (std::size_t f = 0; f < record.poly_count(); ++f)
    for (std::uint32_t k = record.poly_offsets[f] + 1; k + 1 < record.poly_offsets[f + 1]; ++k)
      mesh.triangles.push_back(
          {record.poly_corners[record.poly_offsets[f]], record.poly_corners[k], record.poly_corners[k + 1]});
  return mesh;
}

TEST(SolidBoundary, RealMeshes) {
  REQUIRE_DATA("meshes/casting.off");
  const TriangleMesh casting = read_triangles("meshes/casting.off");  // faces inward
  EXPECT_EQ(solid_boundary(casting).triangles, turned(casting).triangles);
  const TriangleMesh sound = read_triangles("meshes/fandisk.off");
  EXPECT_EQ(solid_boundary(sound).triangles, sound.triangles);
  std::mt19937_64 random(1);
  for (const char* name :
       {"meshes/fertility.off", "meshes/octopus.off", "meshes/neptune.off"}) {  // intersect themselves
    SCOPED_TRACE(name);
    const TriangleMesh mesh = read_triangles(name);
    expect_boundary(mesh, false, solid_boundary(mesh), 30, random);
  }
}

TEST(SolidBoundary, SmallInputs) {
  EXPECT_TRUE(solid_boundary({}).triangles.empty());
  TriangleMesh mesh = box({0, 0, 0}, {1, 1, 1});
  mesh.triangles.push_back({0, 0, 1});
  EXPECT_EQ(solid_boundary(mesh).triangles.size(), 12u);
}

}  // namespace solid_boundary_test
}  // namespace quench
