// SPDX-License-Identifier: Apache-2.0
// The hierarchical winding number against the sum of solid angles of all faces (Jacobson 2013).
#include "voxelization/winding_number.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "damage.h"
#include "quench/samples.h"
#include "random_meshes.h"
#include "voxelization/surface_caps.h"
#include "voxelization/surface_edges.h"
#include "voxelization/surface_repair.h"

namespace quench::voxelization {
namespace winding_number_test {

/// As voxelize() makes it: the box of the mesh from 0 to resolution.
struct Fixed {
  std::vector<FixedPoint> points;
  std::vector<Triangle> faces;
  std::int64_t resolution;
  Fixed(const TriangleMesh& mesh, std::int64_t cells) : resolution(cells) {
    Vec3 low = mesh.points[0], high = low;
    for (const Vec3& p : mesh.points) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    const double scale = std::ldexp(static_cast<double>(cells), kFractionBits) / (high - low).maxCoeff();
    for (const Vec3& p : mesh.points) {
      points.emplace_back();
      for (int a = 0; a < 3; ++a) points.back()[static_cast<std::size_t>(a)] = std::llround((p[a] - low[a]) * scale);
    }
    faces = weld(points, mesh.triangles);
  }
  Vec3 at(std::uint32_t p) const {
    return Vec3(static_cast<double>(points[p][0]), static_cast<double>(points[p][1]),
                static_cast<double>(points[p][2])) *
           std::ldexp(1.0, -kFractionBits);
  }
  double winding_number(const Vec3& p) const {
    double angle = 0;
    for (const Triangle& t : faces) {
      const Vec3 a = at(t[0]) - p, b = at(t[1]) - p, c = at(t[2]) - p;
      const double la = a.norm(), lb = b.norm(), lc = c.norm();
      angle += 2 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
    }
    return angle / (4 * std::numbers::pi);
  }
};

// w + g is the number of crossings, an integer, whatever was done to the surface: this is the identity all rests on,
// and its distance to an integer the error of the hierarchy.
TEST(WindingNumber, AddsUpToWholeCrossings) {
  double worst = 0;
  for (const char* name : {"torus", "four-blobs", "fin-on-board"}) {
    const TriangleMesh clean = make_sample(name, {.noise = 0, .seed = 1, .branches = 60, .fineness = 0.15}).mesh;
    for (const auto& damage : testing_damage::damages()) {
      const Fixed fixed(damage.apply(clean, 3), 24);
      const WindingNumber winding(fixed.points, fixed.faces);
      for (std::int64_t i = 0; i < 30; ++i) {
        const std::int64_t x = (7 * i + 3) % 24, y = (11 * i + 5) % 24, z = (5 * i + 1) % 24;
        const Vec3 p(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5, static_cast<double>(z) + 0.5);
        const double crossings = fixed.winding_number(p) + winding.g(x, y, z);
        const double error = std::abs(crossings - std::nearbyint(crossings));
        worst = std::max(worst, error);
        ASSERT_LT(error, 0.05) << name << ' ' << damage.name << " at " << x << ' ' << y << ' ' << z;
      }
    }
  }
  EXPECT_GT(worst, 1e-9) << "no cluster was ever taken as a whole";
}

TEST(WindingNumber, CapsCloseEverySurface) {
  const TriangleMesh clean = make_sample("torus", {.noise = 0, .seed = 1, .branches = 60, .fineness = 0.15}).mesh;
  for (const auto& damage : testing_damage::damages()) {
    const Fixed fixed(damage.apply(clean, 6), 24);
    const std::vector<BoundaryEdge> chain = boundary_chain(fixed.points.size(), fixed.faces);
    std::int64_t edges = 0, told = 0;
    for (const BoundaryEdge& e : chain) edges += e.times;
    std::vector<Triangle> closed = fixed.faces;
    for (const CapTriangle& cap : close_boundary(fixed.points.size(), fixed.faces)) {
      closed.push_back(cap.corners);
      for (const bool boundary : cap.boundary) told += boundary;
    }
    EXPECT_EQ(told, edges) << damage.name;
    EXPECT_TRUE(boundary_chain(fixed.points.size(), closed).empty()) << damage.name;
  }
}

TEST(WindingNumber, OfAnOpenBoxIsTheSolidAngle) {
  TriangleMesh mesh;
  testing_meshes::add_box(mesh, {0, 0, 0}, {8, 8, 8});
  mesh.triangles.resize(8);  // sides x = 0 and x = 8 are open
  const Fixed fixed(mesh, 8);
  const WindingNumber winding(fixed.points, fixed.faces);
  EXPECT_EQ(winding.boundary_edges(), 8u);
  for (std::int64_t x = 0; x < 8; ++x) {  // no crossing on these scanlines
    const double w = fixed.winding_number({static_cast<double>(x) + 0.5, 4.5, 3.5});
    EXPECT_NEAR(winding.g(x, 4, 3), -w, 1e-12);
  }
  EXPECT_LT(winding.g(4, 4, 3), -0.6);
}

// Decisions for whole blocks are those of every voxel, but for ties within the error of the hierarchy.
TEST(WindingNumber, BlocksAgreeWithTheirVoxels) {
  const TriangleMesh clean = make_sample("torus", {.noise = 0, .seed = 1, .branches = 60, .fineness = 0.15}).mesh;
  std::int64_t nonzero = 0;
  for (const auto& damage : testing_damage::damages()) {
    const std::int64_t n = 32;
    const Fixed fixed(damage.apply(clean, 5), n);
    const WindingNumber winding(fixed.points, fixed.faces);
    std::vector<std::vector<OffsetStep>> rows;
    for (std::int64_t z = 0; z < n; z += 5) {
      winding.offsets(z, {n, n, n}, crossings_of_slice({fixed.points, winding.caps(), {n, n, n}}, z), rows);
      ASSERT_EQ(rows.size(), static_cast<std::size_t>(n));
      for (std::int64_t y = 0; y < n; ++y) {
        const auto& row = rows[static_cast<std::size_t>(y)];
        ASSERT_FALSE(row.empty());
        ASSERT_EQ(row[0].begin, 0);
        for (std::size_t s = 1; s < row.size(); ++s) {
          ASSERT_GT(row[s].begin, row[s - 1].begin);
          ASSERT_NE(row[s].offset, row[s - 1].offset);
        }
        std::size_t s = 0;
        for (std::int64_t x = 0; x < n; ++x) {
          while (s + 1 < row.size() && row[s + 1].begin <= x) ++s;
          ASSERT_LT(std::abs(winding.g(x, y, z) - row[s].offset), 0.55)
              << damage.name << " at " << x << ' ' << y << ' ' << z;
          nonzero += row[s].offset != 0;
        }
      }
    }
  }
  EXPECT_GT(nonzero, 1000);
}

TEST(WindingNumber, OfAClosedSurfaceIsThatOfTheCrossings) {
  std::mt19937_64 random(5);
  for (int i = 0; i < 50; ++i) {
    const Fixed fixed(testing_meshes::random_mesh(random, 12), 12);
    const WindingNumber winding(fixed.points, fixed.faces);
    EXPECT_TRUE(winding.closed());
    EXPECT_EQ(winding.g(3, 4, 5), 0);
  }
}

// Boundary edges that go through the centres of voxels, along and across scanlines: ties fall as those of crossings do.
TEST(WindingNumber, EdgesOnCentresAreDecidedAsCrossingsAre) {
  TriangleMesh mesh;
  testing_meshes::add_box(mesh, {0, 0, 0}, {9, 9, 9});
  testing_meshes::add_box(mesh, {1, 1, 1}, {8, 8, 8});
  mesh.triangles.resize(23);
  mesh.triangles.erase(mesh.triangles.begin() + 2);
  for (Vec3& p : mesh.points) p *= 2;  // all corners but those of the box are whole numbers: centres at resolution 9
  const Fixed fixed(mesh, 9);
  std::vector<std::vector<OffsetStep>> rows;
  const WindingNumber winding(fixed.points, fixed.faces);
  for (std::int64_t z = 0; z < 9; ++z) {
    winding.offsets(z, {9, 9, 9}, crossings_of_slice({fixed.points, winding.caps(), {9, 9, 9}}, z), rows);
    for (const auto& row : rows)
      for (const OffsetStep& s : row) EXPECT_LE(std::abs(s.offset), 1);
  }
}

TEST(RepairOrientation, TurnsWhatDisagreesAndKeepsCavities) {
  const TriangleMesh hollow = make_sample("hollow-sphere", {.noise = 0, .seed = 1, .branches = 60, .fineness = 0.2}).mesh;
  const auto volume = [](const Fixed& f, std::span<const Triangle> faces) {
    double sum = 0;
    for (const Triangle& t : faces) sum += f.at(t[0]).dot(f.at(t[1]).cross(f.at(t[2]))) / 6;
    return sum;
  };
  const Fixed clean(hollow, 64);
  const double wanted = volume(clean, clean.faces);
  ASSERT_GT(wanted, 0);
  RepairedSurface repaired = repair_orientation(clean.points, clean.faces);
  EXPECT_EQ(repaired.faces, clean.faces);
  EXPECT_EQ(repaired.flipped_faces + repaired.flipped_components + repaired.duplicate_faces, 0);
  for (const auto& damage : testing_damage::damages()) {
    if (!damage.exact) continue;
    const TriangleMesh mesh = damage.apply(hollow, 9);
    if (damage.name == "unreferenced points") continue;  // they would be in the box of this test
    const Fixed fixed(mesh, 64);
    repaired = repair_orientation(fixed.points, fixed.faces);
    EXPECT_EQ(repaired.faces.size(), hollow.triangles.size()) << damage.name;
    EXPECT_TRUE(boundary_chain(fixed.points.size(), repaired.faces).empty()) << damage.name;
    EXPECT_NEAR(std::abs(volume(fixed, repaired.faces)), wanted, 1e-6 * wanted) << damage.name;
  }
}

}  // namespace winding_number_test
}  // namespace quench::voxelization
