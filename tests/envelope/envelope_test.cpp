// SPDX-License-Identifier: Apache-2.0
// Voxels, meshes and errors of envelopes, against brute force and closed forms.
#include "quench/envelope.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "closed_surfaces.h"
#include "envelope/element.h"
#include "quench/error.h"
#include "quench/samples.h"
#include "quench/voxelize.h"
#include "random_shapes.h"

namespace quench {
namespace envelope_test {

using testing_surfaces::components_of;
using testing_surfaces::euler_of;
using testing_surfaces::is_closed_manifold;
using testing_surfaces::winding_number;

class Random {
 public:
  explicit Random(std::uint64_t seed) : random_(seed) {}
  double in(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  std::uint32_t below(std::uint32_t n) { return static_cast<std::uint32_t>(random_() % n); }
  Vec3 point(double size) { return {in(-size, size), in(-size, size), in(-size, size)}; }

 private:
  std::mt19937_64 random_;
};

MedialAxis axis_of(std::vector<Vec3> points, std::vector<double> radius,
                   const std::vector<std::array<std::uint32_t, 2>>& edges,
                   const std::vector<std::vector<std::uint32_t>>& faces) {
  std::vector<std::uint32_t> offsets{0}, corners;
  for (const auto& f : faces) {
    corners.insert(corners.end(), f.begin(), f.end());
    offsets.push_back(static_cast<std::uint32_t>(corners.size()));
  }
  MedialAxis axis;
  axis.complex = make_complex(static_cast<std::uint32_t>(points.size()), edges, offsets, corners);
  axis.points = std::move(points);
  axis.radius = std::move(radius);
  return axis;
}

// Points, edges, triangles and a few quadrilaterals, within 1 of the origin; some balls in others, some of radius 0.
MedialAxis random_axis(std::uint64_t seed, bool plane = false) {
  Random random(seed);
  const std::uint32_t n = 1 + random.below(8);
  std::vector<Vec3> points;
  std::vector<double> radius;
  for (std::uint32_t v = 0; v < n; ++v) {
    points.push_back(random.point(0.8));
    if (plane) points.back()[2] = 0;
    radius.push_back(random.below(6) == 0 ? 0 : random.in(0.02, 0.5));
  }
  std::vector<std::array<std::uint32_t, 2>> edges;
  std::vector<std::vector<std::uint32_t>> faces;
  for (std::uint32_t i = random.below(4); n > 1 && i > 0; --i) {
    const std::uint32_t a = random.below(n), b = random.below(n);
    if (a != b) edges.push_back({a, b});
  }
  for (std::uint32_t i = plane ? 0 : random.below(4); n > 3 && i > 0; --i) {
    std::vector<std::uint32_t> corners(n);
    for (std::uint32_t v = 0; v < n; ++v) corners[v] = v;
    for (std::uint32_t v = 0; v < n; ++v) std::swap(corners[v], corners[v + random.below(n - v)]);
    corners.resize(3 + random.below(2));
    faces.push_back(corners);
  }
  return axis_of(std::move(points), std::move(radius), edges, faces);
}

Grid random_grid(const Envelope& envelope, std::uint64_t seed) {
  Random random(seed + 77);
  Grid grid =
      grid_around(envelope, std::max(0.1, (envelope.high() - envelope.low()).maxCoeff()) / (10 + random.below(10)));
  if (seed % 3 == 1) grid.spacing[2] *= 2;
  if (seed % 3 == 2) {
    grid.direction = Eigen::AngleAxisd(random.in(0, 3), random.point(1).normalized()).toRotationMatrix();
    if (seed % 2) grid.direction.col(0) *= -1;
    grid.origin += random.point(0.3);
  }
  return grid;
}

// Every face a fan from its corner of the smallest index, all edges and all vertices: more than there need be.
bool contains_by_all(const MedialAxis& axis, EnvelopeKind kind, const Vec3& p, double* distance) {
  using envelope::Element;
  std::vector<Element> all;
  const auto& x = axis.points;
  const auto& r = axis.radius;
  for (std::size_t v = 0; v < x.size(); ++v) all.emplace_back(x[v], r[v]);
  if (kind == EnvelopeKind::full) {
    for (const auto& [a, b] : axis.complex.edges) all.emplace_back(x[a], r[a], x[b], r[b]);
    for (std::size_t f = 0; f < axis.complex.face_count(); ++f) {
      auto corners = std::vector(axis.complex.corners(f).begin(), axis.complex.corners(f).end());
      std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
      for (std::size_t i = 2; i < corners.size(); ++i)
        all.emplace_back(x[corners[0]], r[corners[0]], x[corners[i - 1]], r[corners[i - 1]], x[corners[i]],
                         r[corners[i]]);
    }
  }
  bool in = false;
  *distance = std::numeric_limits<double>::infinity();
  for (const Element& e : all) {
    const auto near = e.nearest(p);
    *distance = std::min(*distance, near.distance);
    in = in || near.distance <= 1e-9 * near.radius;
  }
  return in;
}

TEST(Envelope, VoxelsAndDistancesAreThoseOfBruteForce) {
  std::int64_t foreground = 0;
  for (std::uint64_t seed = 0; seed < 1200; ++seed) {
    const MedialAxis axis = random_axis(seed);
    const auto kind = seed % 4 == 0 ? EnvelopeKind::balls : EnvelopeKind::full;
    const Envelope envelope(axis, kind);
    const Grid grid = random_grid(envelope, seed);
    const VoxelShape voxels = voxels_of(envelope, grid);
    voxels.validate();
    for (std::int64_t z = 0; z < grid.dims[2]; ++z)
      for (std::int64_t y = 0; y < grid.dims[1]; ++y)
        for (std::int64_t x = 0; x < grid.dims[0]; ++x) {
          const Vec3 p = grid.world(Vec3(x + 0.5, y + 0.5, z + 0.5));
          double distance;
          const bool in = contains_by_all(axis, kind, p, &distance);
          ASSERT_EQ(voxels.contains(x, y, z), in) << seed << ": " << distance;
          foreground += in;
          if ((x + 3 * y + 5 * z) % 37) continue;
          // Triangles whose corners lie in a line are the cones between them, to 1e-10 of their length.
          ASSERT_NEAR(envelope.distance(p), distance, 1e-12) << seed;
          const Envelope::Ball ball = envelope.nearest(p);
          ASSERT_NEAR((p - ball.centre).norm() - ball.radius, ball.distance, 1e-12) << seed;
          const Envelope::Corners corners = envelope.corners(ball.element);
          Vec3 centre = Vec3::Zero();
          for (std::size_t k = 0; k < 3 && corners[k] != kNone; ++k) centre += ball.weight[k] * axis.points[corners[k]];
          ASSERT_EQ(centre, ball.centre);
        }
  }
  EXPECT_GT(foreground, 100000);
}

TEST(Envelope, PixelsAreThoseOfBruteForce) {
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    MedialAxis axis = random_axis(seed, true);
    const Envelope envelope(axis);
    Grid grid;
    grid.dims = {30, 23, 1};
    grid.spacing = {0.1, 0.13, 1};
    grid.origin = {-1.5, -1.5, 0};
    grid.make_plane();
    const VoxelShape pixels = voxels_of(envelope, grid);
    for (std::int64_t y = 0; y < grid.dims[1]; ++y)
      for (std::int64_t x = 0; x < grid.dims[0]; ++x) {
        double distance;
        ASSERT_EQ(pixels.contains(x, y, 0),
                  contains_by_all(axis, EnvelopeKind::full, grid.world(Vec3(x + 0.5, y + 0.5, 0)), &distance));
      }
    const Grid grown = grown_around(envelope, grid);
    EXPECT_EQ(grown.dims[2], 1);
    EXPECT_THROW(mesh_of(envelope, pixels), Error);
  }
}

// Every voxel lies in a ball of the unpruned core, and balls of the core lie in the shape. Cones and slabs add to them.
TEST(Envelope, TheUnprunedCoreIsTheWholeShape) {
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    const VoxelShape shape = testing_shapes::random_shape(seed, 9, seed % 3 == 0);
    const MedialAxis core = voxel_core(shape);
    const Envelope balls(core, EnvelopeKind::balls), full(core);
    const VoxelShape again = voxels_of(balls, shape.grid());
    const VolumeErrors none = volume_errors(again, shape);
    ASSERT_EQ(none.missing, 0) << seed;
    // Balls of flat voxels may reach the centre of a neighbour that is not of the shape through their common face.
    if (seed % 3 == 0) continue;
    ASSERT_EQ(none.added, 0) << seed;
    ASSERT_TRUE(std::ranges::equal(again.runs(), shape.runs())) << seed;
    ASSERT_EQ(volume_errors(voxels_of(full, grown_around(full, shape.grid())), shape).missing, 0) << seed;
  }
}

TEST(Envelope, MeshesAreClosedManifoldsWithTheTopologyOfTheVoxels) {
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    const MedialAxis axis = random_axis(seed);
    const Envelope envelope(axis, seed % 4 == 0 ? EnvelopeKind::balls : EnvelopeKind::full);
    const VoxelShape voxels = voxels_of(envelope, grown_around(envelope, random_grid(envelope, seed)));
    if (voxels.empty()) continue;
    const TriangleMesh mesh = mesh_of(envelope, voxels);
    const Topology t = topology(voxels);
    ASSERT_TRUE(is_closed_manifold(mesh)) << seed;
    ASSERT_EQ(euler_of(mesh), 2 * t.euler) << seed;
    ASSERT_EQ(components_of(mesh), t.betti[0] + t.betti[2]) << seed;
    Random random(seed);
    const Grid& grid = voxels.grid();
    for (int i = 0; i < 20; ++i) {
      const std::int64_t x = random.below(static_cast<std::uint32_t>(grid.dims[0])),
                         y = random.below(static_cast<std::uint32_t>(grid.dims[1])),
                         z = random.below(static_cast<std::uint32_t>(grid.dims[2]));
      ASSERT_EQ(std::lround(winding_number(mesh, grid.world(Vec3(x + 0.5, y + 0.5, z + 0.5)))),
                voxels.contains(x, y, z) ? 1 : 0)
          << seed;
    }
  }
}

// Where the boundary is smooth, the mesh is much nearer to it than a voxel.
TEST(Envelope, MeshesLieOnTheBoundary) {
  const MedialAxis axis = axis_of({Vec3(0, 0, 0), Vec3(2, 0, 0), Vec3(0, 2, 0)}, {0.5, 0.8, 0.6}, {}, {{0, 1, 2}});
  const Envelope envelope(axis);
  const double h = 0.05;
  const TriangleMesh mesh = mesh_of(envelope, voxels_of(envelope, grid_around(envelope, h)));
  double largest = 0;
  for (const Vec3& p : mesh.points) largest = std::max(largest, std::abs(envelope.distance(p)));
  EXPECT_LT(largest, 0.03 * h);
}

TEST(Envelope, DoesNotDependOnThreadsOrOrder) {
  const auto sample = make_sample("fin-on-board", {.fineness = 0.3}).mesh;
  VoxelizeOptions how;
  how.resolution = 24;
  const VoxelShape shape = voxelize(sample, how).shape;
  const MedialAxis core = medial_axis(shape);
  const Surface surface(sample, SurfaceKind::mesh);
  Context one, four;
  one.threads = 1;
  four.threads = 4;
  const Envelope a(core, EnvelopeKind::full, &one), b(core, EnvelopeKind::full, &four);
  const Grid grid = grown_around(a, shape.grid());
  const VoxelShape va = voxels_of(a, grid, &one), vb = voxels_of(b, grid, &four);
  EXPECT_TRUE(std::ranges::equal(va.runs(), vb.runs()));
  const TriangleMesh ma = mesh_of(a, va, &one), mb = mesh_of(b, vb, &four);
  EXPECT_EQ(ma.points, mb.points);
  EXPECT_EQ(ma.triangles, mb.triangles);
  for (const bool to : {false, true}) {
    const OneSidedDistances da = to ? distances_from_surface(a, va, surface, 2000, &one)
                                    : distances_from_envelope(surface, a, 2000, &one),
                            db = to ? distances_from_surface(b, vb, surface, 2000, &four)
                                    : distances_from_envelope(surface, b, 2000, &four);
    EXPECT_EQ(da.outside.mean, db.outside.mean);
    EXPECT_EQ(da.outside.p99, db.outside.p99);
    EXPECT_EQ(da.either.largest, db.either.largest);
    EXPECT_GT(da.places, 1000u);
  }
}

TriangleMesh box_mesh(const Vec3& half) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.points.emplace_back(i & 1 ? half[0] : -half[0], i & 2 ? half[1] : -half[1], i & 4 ? half[2] : -half[2]);
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

TEST(Envelope, ErrorsOfABallInACubeAreThoseOfFormulas) {
  const Surface cube(box_mesh(Vec3::Constant(1)), SurfaceKind::mesh);
  for (const double r : {1.0, 0.5}) {
    const Envelope ball(axis_of({Vec3::Zero()}, {r}, {}, {}));
    const OneSidedDistances missing = distances_from_envelope(cube, ball, 200000);
    // From the cube: the length of a point of its boundary, less r.
    double mean = 0;
    constexpr int kSteps = 1000;
    std::vector<double> values;
    for (int i = 0; i < kSteps; ++i)
      for (int j = 0; j < kSteps; ++j) {
        const double x = (i + 0.5) / kSteps, y = (j + 0.5) / kSteps;
        values.push_back(std::sqrt(1 + x * x + y * y) - r);
        mean += values.back() / (kSteps * kSteps);
      }
    std::nth_element(values.begin(), values.begin() + 990000, values.end());
    EXPECT_NEAR(missing.outside.mean, mean, 1e-4);
    EXPECT_NEAR(missing.outside.p99, values[990000], 1e-3);
    EXPECT_NEAR(missing.outside.largest, std::sqrt(3.0) - r, 1e-12);
    EXPECT_EQ(missing.outside.mean, missing.either.mean);
    EXPECT_EQ(missing.places, 200000u);
    // From the ball: 1 - r times the largest coordinate of a direction.
    const VoxelShape voxels = voxels_of(ball, grid_around(ball, r / 40));
    const OneSidedDistances added = distances_from_surface(ball, voxels, cube, 1u << 30);
    double mean_largest = 0, weight = 0;
    for (int i = 0; i < kSteps; ++i)
      for (int j = 0; j < kSteps; ++j) {  // directions through a face of the cube
        const double x = (i + 0.5) / kSteps, y = (j + 0.5) / kSteps, l2 = 1 + x * x + y * y;
        const double solid = 1 / (l2 * std::sqrt(l2));
        weight += solid;
        mean_largest += solid / std::sqrt(l2);
      }
    mean_largest /= weight;
    EXPECT_NEAR(added.either.mean, 1 - r * mean_largest, 2e-3 * r);
    EXPECT_NEAR(added.either.largest, 1 - r / std::sqrt(3.0), r / 40);
    EXPECT_NEAR(added.outside.largest, 0, 1e-5);
    EXPECT_EQ(added.outside.mean, r < 1 ? 0 : added.outside.mean);
    const VolumeErrors volume = volume_errors(voxels, voxels);
    EXPECT_NEAR(volume.envelope, 4 * std::numbers::pi / 3 * r * r * r, 2e-3 * r * r * r);
    EXPECT_EQ(volume.added, 0);
  }
}

TEST(Envelope, WhatSticksOutOfAPlateIsThatOfFormulas) {
  // A plate of half height 0.1 whose envelope is 0.25 thick on each side.
  const Surface plate(box_mesh(Vec3(1, 1, 0.1)), SurfaceKind::mesh);
  const MedialAxis axis = axis_of({Vec3(-0.5, -0.5, 0), Vec3(0.5, -0.5, 0), Vec3(0.5, 0.5, 0), Vec3(-0.5, 0.5, 0)},
                                  {0.25, 0.25, 0.25, 0.25}, {}, {{0, 1, 2, 3}});
  const Envelope envelope(axis);
  const VoxelShape voxels = voxels_of(envelope, grid_around(envelope, 0.0171));
  const OneSidedDistances added = distances_from_surface(envelope, voxels, plate);
  EXPECT_NEAR(added.outside.largest, 0.15, 1e-6);
  EXPECT_NEAR(added.outside.p99, 0.15, 1e-6);
  // Two squares, four half cylinders and a sphere in four parts; what of them is higher than 0.1.
  const double squares = 2, cylinders = 4 * std::numbers::pi * 0.25, sphere = 4 * std::numbers::pi * 0.0625;
  double on_cylinders = 0, on_sphere = 0;
  constexpr int kSteps = 20000;
  for (int i = 0; i < kSteps; ++i) {
    const double angle = std::numbers::pi / 2 * (i + 0.5) / kSteps, z = 0.25 * (i + 0.5) / kSteps;
    on_cylinders += std::max(0.0, 0.25 * std::sin(angle) - 0.1) / kSteps;
    on_sphere += std::max(0.0, z - 0.1) / kSteps;
  }
  EXPECT_NEAR(added.outside.mean,
              (squares * 0.15 + cylinders * on_cylinders + sphere * on_sphere) / (squares + cylinders + sphere), 1e-3);
  const OneSidedDistances missing = distances_from_envelope(plate, envelope);
  EXPECT_NEAR(missing.outside.largest, std::sqrt(0.51) - 0.25, 1e-12);
}

TEST(Envelope, SurfacesOfVoxelsAreTheirFaces) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const VoxelShape shape = testing_shapes::random_shape(seed, 8, seed % 2 == 0);
    const Surface surface = surface_of_voxels(shape);
    const Grid& grid = shape.grid();
    double area = 0, wanted = 0, volume = 0;
    for (const auto& t : surface.mesh().triangles) {
      const Vec3 &a = surface.mesh().points[t[0]], &b = surface.mesh().points[t[1]], &c = surface.mesh().points[t[2]];
      area += (b - a).cross(c - a).norm() / 2;
      volume += a.dot(b.cross(c)) / 6;
    }
    for (std::int64_t z = 0; z < grid.dims[2]; ++z)
      for (std::int64_t y = 0; y < grid.dims[1]; ++y)
        for (std::int64_t x = 0; x < grid.dims[0]; ++x) {
          if (!shape.contains(x, y, z)) continue;
          const double sides[] = {grid.spacing[1] * grid.spacing[2], grid.spacing[0] * grid.spacing[2],
                                  grid.spacing[0] * grid.spacing[1]};
          for (const int step : {-1, 1})
            wanted += sides[0] * !shape.contains(x + step, y, z) + sides[1] * !shape.contains(x, y + step, z) +
                      sides[2] * !shape.contains(x, y, z + step);
        }
    ASSERT_NEAR(area, wanted, 1e-9 * wanted) << seed;
    ASSERT_NEAR(volume, static_cast<double>(shape.voxel_count()) * grid.spacing.prod(), 1e-9 * wanted) << seed;
  }
}

TEST(Envelope, RefusesWhatIsNoAxis) {
  const double nan = std::nan("");
  EXPECT_THROW(Envelope(MedialAxis{}), Error);
  EXPECT_THROW(Envelope(axis_of({Vec3::Zero()}, {-1}, {}, {})), Error);
  EXPECT_THROW(Envelope(axis_of({Vec3::Zero()}, {nan}, {}, {})), Error);
  EXPECT_THROW(Envelope(axis_of({Vec3(nan, 0, 0)}, {1}, {}, {})), Error);
  EXPECT_THROW(Envelope(axis_of({Vec3(0, 0, 0), Vec3(1, 0, 0)}, {1}, {{0, 1}}, {})), Error);
  const Envelope ball(axis_of({Vec3::Zero()}, {1}, {}, {}));
  EXPECT_THROW(grid_around(ball, 0), Error);
  EXPECT_THROW(grid_around(ball, nan), Error);
  EXPECT_THROW(grid_around(ball, 1e-9), Error);
  Grid far;
  far.dims = {4, 4, 4};
  far.origin = Vec3::Constant(1e9);
  EXPECT_THROW(grown_around(ball, far), Error);
  VoxelShape other = voxels_of(ball, grid_around(ball, 0.5));
  EXPECT_THROW(volume_errors(other, voxels_of(ball, grid_around(ball, 0.4))), Error);
}

}  // namespace envelope_test
}  // namespace quench
