// SPDX-License-Identifier: Apache-2.0
// Nearest points and sides of closed surfaces, against brute force.
#include "quench/surface.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "closed_surfaces.h"
#include "quench/error.h"
#include "quench/samples.h"

namespace quench {
namespace surface_test {

using testing_surfaces::distance_to;
using testing_surfaces::winding_number;

TriangleMesh coarse(const char* name) {
  SampleOptions options;
  options.fineness = 0.1;
  return make_sample(name, options).mesh;
}

Vec3 random_in(std::mt19937_64& random, double size) {
  std::uniform_real_distribution<double> any(-size, size);
  return Vec3(any(random), any(random), any(random));
}

TEST(Surface, NearestPointsAndSidesAreThoseOfBruteForce) {
  std::mt19937_64 random(1);
  for (const char* name : {"ellipsoid", "torus", "box", "hollow-sphere", "plate-with-holes", "bumpy-sphere"}) {
    const TriangleMesh mesh = coarse(name);
    const Surface surface(mesh, SurfaceKind::mesh);
    for (int i = 0; i < 300; ++i) {
      const Vec3 p = random_in(random, 1.5);
      const Surface::Foot foot = surface.nearest(p);
      const double wanted = distance_to(mesh, p);
      ASSERT_NEAR(foot.distance, wanted, 1e-12) << name;
      ASSERT_NEAR((foot.point - p).norm(), wanted, 1e-12) << name;
      ASSERT_LT(foot.triangle, surface.mesh().triangles.size()) << name;
      ASSERT_EQ(foot.inside, std::lround(winding_number(mesh, p)) != 0) << name << ' ' << p.transpose();
      ASSERT_EQ(surface.nearest(p, wanted * (1 + 1e-9)).distance, foot.distance);
      ASSERT_EQ(surface.nearest(p, wanted * (1 - 1e-9)).triangle, kNone);
    }
  }
}

// Above corners and edges, where several triangles are equally near and their normals say different things.
TEST(Surface, SidesAtCornersAndEdgesFollowAllTrianglesThere) {
  const TriangleMesh mesh = coarse("fin-on-board");
  const Surface surface(mesh, SurfaceKind::mesh);
  std::mt19937_64 random(2);
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 corner = mesh.points[t[k]], middle = (corner + mesh.points[t[(k + 1) % 3]]) / 2;
      for (const Vec3& at : {corner, middle}) {
        const Vec3 p = at + 1e-4 * random_in(random, 1);
        ASSERT_EQ(surface.nearest(p).inside, std::lround(winding_number(mesh, p)) != 0) << p.transpose();
      }
    }
}

TEST(Surface, CornersAtOnePlaceAreOne) {
  const TriangleMesh mesh = coarse("ellipsoid");
  TriangleMesh soup;
  for (const auto& t : mesh.triangles) {
    const auto first = static_cast<std::uint32_t>(soup.points.size());
    for (const std::uint32_t corner : t) soup.points.push_back(mesh.points[corner]);
    soup.triangles.push_back({first, first + 1, first + 2});
    soup.triangles.push_back({first, first, first + 2});  // without area
  }
  const Surface surface(soup, SurfaceKind::mesh);
  EXPECT_EQ(surface.mesh().triangles.size(), mesh.triangles.size());
  std::mt19937_64 random(3);
  for (int i = 0; i < 200; ++i) {
    const Vec3 p = random_in(random, 1.2);
    ASSERT_EQ(surface.nearest(p).inside, std::lround(winding_number(mesh, p)) != 0);
  }
}

TEST(Surface, FarFromTheOriginDistancesAreAsGoodAsCoordinates) {
  TriangleMesh mesh = coarse("torus");
  const Surface near(mesh, SurfaceKind::mesh);
  const Vec3 away(1e6, -2e6, 3e6);
  for (Vec3& p : mesh.points) p += away;
  const Surface far(mesh, SurfaceKind::mesh);
  std::mt19937_64 random(4);
  for (int i = 0; i < 200; ++i) {
    const Vec3 p = random_in(random, 1.5);
    ASSERT_NEAR(far.nearest(p + away).distance, near.nearest(p).distance, 1e-8);
  }
}

TEST(Surface, NamesAndNothing) {
  for (const SurfaceKind kind : {SurfaceKind::voxels, SurfaceKind::mesh, SurfaceKind::grey, SurfaceKind::smooth})
    EXPECT_EQ(surface_kind_of(name_of(kind)), kind);
  EXPECT_FALSE(surface_kind_of("skin"));
  EXPECT_THROW(Surface({}, SurfaceKind::mesh), Error);
  EXPECT_THROW(Surface({{Vec3(0, 0, 0), Vec3(1, 0, 0)}, {{0, 1, 1}}}, SurfaceKind::mesh), Error);
}

}  // namespace surface_test
}  // namespace quench
