// SPDX-License-Identifier: Apache-2.0
#include "verification/triangle_search.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "closed_surfaces.h"
#include "quench/samples.h"
#include "random_meshes.h"
#include "verification/solid_of_surface.h"

namespace quench {
namespace triangle_search_test {

using testing_surfaces::winding_number;
using verification::TriangleSearch;

/// By the nearest point of a fine grid of barycentric coordinates, within the size of its cells.
double rough_distance(const TriangleMesh& mesh, const Vec3& p, int n) {
  double best = std::numeric_limits<double>::infinity();
  for (const auto& t : mesh.triangles)
    for (int i = 0; i <= n; ++i)
      for (int j = 0; i + j <= n; ++j)
        best = std::min(best, (p - (i * mesh.points[t[0]] + j * mesh.points[t[1]] + (n - i - j) * mesh.points[t[2]]) /
                                       static_cast<double>(n))
                                  .norm());
  return best;
}

TEST(TriangleSearch, AgreesWithBruteForce) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<> coordinate(-1, 9);
  for (int i = 0; i < 100; ++i) {
    const TriangleMesh mesh = testing_meshes::random_mesh(random, 8);
    const TriangleSearch search(mesh);
    for (int k = 0; k < 20; ++k) {
      const Vec3 p(coordinate(random), coordinate(random), coordinate(random));
      const double rough = rough_distance(mesh, p, 60);
      EXPECT_LE(search.distance(p), rough + 1e-12);
      EXPECT_GE(search.distance(p), rough - 0.2);
      EXPECT_EQ(search.inside(p), std::lround(winding_number(mesh, p)) == 1) << "mesh " << i << " at " << p.transpose();
    }
  }
}

// Rays along edges and through corners are the rule here.
TEST(TriangleSearch, OnLatticePoints) {
  TriangleMesh mesh;
  testing_meshes::add_box(mesh, {0, 0, 0}, {4, 4, 4});
  testing_meshes::add_box(mesh, {1, 1, 1}, {3, 3, 3}, true);
  const TriangleSearch search(mesh);
  for (int x = -1; x <= 9; ++x)
    for (int y = -1; y <= 9; ++y)
      for (int z = -1; z <= 9; ++z) {
        const Vec3 p = Vec3(x, y, z) / 2;
        const double outer = std::min(p.minCoeff(), 4 - p.maxCoeff()),
                     inner = std::min((p - Vec3::Ones()).minCoeff(), 3 - p.maxCoeff());
        if (outer == 0 || inner == 0) {
          EXPECT_EQ(search.distance(p), 0);
          continue;
        }
        EXPECT_EQ(search.inside(p), outer > 0 && inner < 0) << p.transpose();
        if (inner > 0) {
          EXPECT_DOUBLE_EQ(search.distance(p), inner);
        }
      }
}

TEST(TriangleSearch, OfNothing) {
  const TriangleSearch search({});
  EXPECT_TRUE(std::isinf(search.distance(Vec3::Zero())));
  EXPECT_FALSE(search.inside(Vec3::Zero()));
}

TEST(SolidTopology, OfSamples) {
  const auto of = [](const char* name) {
    return verification::solid_topology(make_sample(name, {.fineness = 0.1}).mesh);
  };
  EXPECT_EQ(of("ellipsoid"), (Topology{1, {1, 0, 0}}));
  EXPECT_EQ(of("torus"), (Topology{0, {1, 1, 0}}));
  EXPECT_EQ(of("hollow-sphere"), (Topology{2, {1, 0, 1}}));
  TriangleMesh two;
  testing_meshes::add_box(two, {0, 0, 0}, {4, 4, 4});
  testing_meshes::add_octahedron(two, {8, 8, 8}, {1, 1, 1});
  EXPECT_EQ(verification::solid_topology(two), (Topology{2, {2, 0, 0}}));
  two.triangles.pop_back();
  EXPECT_EQ(verification::solid_topology(two), std::nullopt);
}

}  // namespace triangle_search_test
}  // namespace quench
