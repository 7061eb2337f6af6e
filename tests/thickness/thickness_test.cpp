// SPDX-License-Identifier: Apache-2.0
#include "quench/thickness.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <span>
#include <vector>

#include "brute_force_thickness.h"
#include "quench/axis.h"
#include "quench/error.h"
#include "random_shapes.h"

namespace quench {
namespace thickness_test {

// The values of the voxels of a shape in the order of its runs.
std::vector<double> values_in(const VoxelShape& shape, const std::vector<float>& all) {
  std::vector<double> values;
  const auto& dims = shape.grid().dims;
  for (std::int64_t z = 0; z < dims[2]; ++z)
    for (std::int64_t y = 0; y < dims[1]; ++y)
      for (const Run& run : shape.row(y, z))
        for (std::int32_t x = run.begin; x < run.end; ++x)
          values.push_back(static_cast<double>(all[static_cast<std::size_t>(x + dims[0] * (y + dims[1] * z))]));
  return values;
}

std::vector<double> thickness_in(const VoxelShape& shape, const MedialAxis& axis,
                                 const ThicknessOptions& options = {}) {
  return values_in(shape, thickness_volume(shape, axis, options));
}

// Both between all points of edges and of vertices alone.
void expect_brute_force(const VoxelShape& shape, std::uint64_t seed) {
  const MedialAxis core = voxel_core(shape);
  const std::vector<Vec3> centres = oracles::voxel_centres(shape), sites = oracles::sites_of_edges(core, shape);
  const std::vector<double> all = thickness_in(shape, core), vertices = thickness_in(shape, core, {.between = false});
  ASSERT_EQ(all.size(), centres.size());
  for (std::size_t i = 0; i < centres.size(); ++i) {
    const double of_vertices = oracles::thickness_of_vertices(core, centres[i]);
    ASSERT_GT(of_vertices, 0) << "seed " << seed << ", voxel " << i;
    ASSERT_NEAR(vertices[i], of_vertices, 1e-6 * of_vertices) << "seed " << seed << ", voxel " << i;
    const double of_edges = oracles::thickness_of_edges(core, sites, centres[i]);
    ASSERT_NEAR(all[i], of_edges, 1e-6 * of_edges) << "seed " << seed << ", voxel " << i;
    ASSERT_GE(all[i], vertices[i]);
  }
}

TEST(LocalThickness, IsThatOfAllBalls) {
  for (std::uint64_t seed = 0; seed < 1500; ++seed) {
    expect_brute_force(testing_shapes::random_shape(seed, 9), seed);
    if (HasFatalFailure()) return;
  }
}

TEST(LocalThickness, IsThatOfAllBallsInVoxelsOfOtherProportions) {
  for (std::uint64_t seed = 0; seed < 1500; ++seed) {
    expect_brute_force(testing_shapes::random_shape(seed, 9, true), seed);
    if (HasFatalFailure()) return;
  }
}

TEST(LocalThickness, NoBallInsideAFaceIsLarger) {
  std::mt19937_64 random(7);
  std::exponential_distribution<double> share;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const VoxelShape shape = testing_shapes::random_shape(seed, 9, seed % 2 == 1);
    const MedialAxis core = voxel_core(shape);
    const std::vector<Vec3> centres = oracles::voxel_centres(shape);
    const std::vector<double> all = thickness_in(shape, core);
    for (std::size_t f = 0; f < core.complex.face_count(); ++f)
      for (int sample = 0; sample < 3; ++sample) {
        Vec3 x = Vec3::Zero();
        double sum = 0;
        for (const std::uint32_t v : core.complex.corners(f)) {
          const double part = share(random);
          x += part * core.points[v];
          sum += part;
        }
        x /= sum;
        const double r = (core.grid.world_of(core.sites[core.face_sites[f][0]]) - x).norm();
        for (std::size_t i = 0; i < centres.size(); ++i)
          if ((centres[i] - x).norm() <= r) {
            ASSERT_GE(all[i], 2 * r * (1 - 1e-6)) << "seed " << seed;
          }
      }
  }
}

// The distance of a point of a shape to its boundary.
double depth_of(const VoxelShape& shape, const Vec3& x) {
  const Grid& grid = shape.grid();
  double depth = std::numeric_limits<double>::infinity();
  for (std::int64_t k = -1; k <= grid.dims[2]; ++k)
    for (std::int64_t j = -1; j <= grid.dims[1]; ++j)
      for (std::int64_t i = -1; i <= grid.dims[0]; ++i) {
        if (shape.contains(i, j, k)) continue;
        const Vec3 centre = grid.world(Vec3(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)) +
                                       Vec3::Constant(0.5));
        depth = std::min(depth, ((x - centre).cwiseAbs() - grid.spacing / 2).cwiseMax(0).norm());
      }
  return depth;
}

TEST(LocalThickness, NoBallInsideTheShapeIsLarger) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> unit(-0.5, 0.5);
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    const VoxelShape shape = testing_shapes::random_shape(seed, 9);
    const std::vector<Vec3> centres = oracles::voxel_centres(shape);
    const std::vector<double> all = thickness_in(shape, voxel_core(shape));
    for (int sample = 0; sample < 30; ++sample) {
      const Vec3 x = centres[random() % centres.size()] + Vec3(unit(random), unit(random), unit(random));
      const double depth = depth_of(shape, x);
      for (std::size_t i = 0; i < centres.size(); ++i)
        if ((centres[i] - x).norm() <= depth) {
          ASSERT_GE(all[i], 2 * depth * (1 - 1e-6)) << "seed " << seed;
        }
    }
  }
}

VoxelShape digitized(int nx, int ny, int nz, const Vec3& spacing, const std::function<bool(const Vec3&)>& inside) {
  Grid grid;
  grid.dims = {nx, ny, nz};
  grid.spacing = spacing;
  return testing_shapes::from_predicate(
      grid, [&](int x, int y, int z) { return inside(grid.world(Vec3(x + 0.5, y + 0.5, z + 0.5))); });
}

double value_at(const VoxelShape& shape, const std::vector<float>& all, int x, int y, int z) {
  const auto& dims = shape.grid().dims;
  return static_cast<double>(all[static_cast<std::size_t>(x + dims[0] * (y + dims[1] * z))]);
}

// Balls that touch a wall of voxels touch the four corners of a square of it.
TEST(LocalThickness, OfASlab) {
  for (const int n : {1, 2, 3, 6, 11})
    for (const Vec3& h : {Vec3(1, 1, 1), Vec3(1, 2, 3), Vec3(0.25, 0.25, 0.5)}) {
      const int side = 40;
      const VoxelShape slab =
          digitized(side, side, n + 2, h, [&](const Vec3& p) { return p[2] > h[2] / 2 && p[2] < (n + 0.5) * h[2]; });
      const std::vector<float> all = thickness_volume(slab, voxel_core(slab));
      const double expected = std::sqrt(n * n * h[2] * h[2] + h[0] * h[0] + h[1] * h[1]);
      const int margin = static_cast<int>(std::ceil(expected / h.minCoeff() / 2)) + 1;
      for (int z = 1; z <= n && margin < side / 2; ++z)
        for (int x = margin; x < side - margin; ++x)
          ASSERT_NEAR(value_at(slab, all, x, side / 2, z), expected, 1e-6 * expected) << n << ' ' << h.transpose();
    }
}

TEST(LocalThickness, OfACylinder) {
  const double radius = 12.3;
  const VoxelShape cylinder = digitized(30, 30, 60, {1, 1, 1}, [&](const Vec3& p) {
    return std::hypot(p[0] - 14.6, p[1] - 14.4) < radius && p[2] > 0.5 && p[2] < 58.5;
  });
  const MedialAxis core = voxel_core(cylinder);
  const std::vector<float> all = thickness_volume(cylinder, core, {.correction = thickness_correction(core)});
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 30; ++x) {
      const double value = value_at(cylinder, all, x, y, 30);
      if (std::hypot(x - 14.6, y - 14.4) < radius - 1) {
        EXPECT_NEAR(value, 2 * radius, 1) << x << ' ' << y;
      }
    }
}

TEST(LocalThickness, OfTwoBallsThatOverlap) {
  const Vec3 a(20, 20, 20), b(38, 22, 21);
  const double ra = 14.2, rb = 9.1;
  const VoxelShape both =
      digitized(50, 40, 40, {1, 1, 1}, [&](const Vec3& p) { return (p - a).norm() < ra || (p - b).norm() < rb; });
  // As an axis of two balls: beside the larger one the ball through the common circle and the point.
  MedialAxis pair;
  pair.points = {a, b};
  pair.radius = {ra, rb};
  pair.complex.vertex_count = 2;
  pair.complex.edges = {{0, 1}};
  pair.grid = both.grid();
  const std::vector<Vec3> centres = oracles::voxel_centres(both);
  const std::vector<double> of_pair = thickness_in(both, pair);
  const Vec3 along = (b - a).normalized();
  const double d = (b - a).norm(), plane = (d * d + ra * ra - rb * rb) / (2 * d),
               rim = std::sqrt(ra * ra - plane * plane);
  for (std::size_t i = 0; i < centres.size(); ++i) {
    const Vec3 p = centres[i] - a;
    if (p.norm() < ra) {
      EXPECT_NEAR(of_pair[i], 2 * ra, 1e-5);
      continue;
    }
    // The centre at s along the line is as far from the circle as from the point.
    const double x = p.dot(along), y2 = p.squaredNorm() - x * x;
    const double s = (x * x + y2 - plane * plane - rim * rim) / (2 * (x - plane));
    const double r = std::hypot(s - plane, rim);
    EXPECT_NEAR(of_pair[i], 2 * std::max(r, rb), 1e-4 * r);
  }
  // As voxels.
  const MedialAxis core = voxel_core(both);
  const std::vector<double> of_core = thickness_in(both, core, {.correction = 0.5});
  for (std::size_t i = 0; i < centres.size(); ++i) {
    if ((centres[i] - a).norm() < ra - 2) {
      EXPECT_NEAR(of_core[i], 2 * ra, 1.5);
    }
    if ((centres[i] - b).norm() < rb - 2 && (centres[i] - a).norm() > ra + 2) {
      EXPECT_LT(of_core[i], of_pair[i] + 1.5);
      EXPECT_GT(of_core[i], 2 * rb - 1.5);
    }
  }
}

// A ball between two planes reaches the bisector at distance s from their edge when its centre is s / (1 - sin) away.
TEST(LocalThickness, OfAWedge) {
  const double half_angle = 0.3, length = 60;
  const VoxelShape wedge = digitized(64, 44, 30, {1, 1, 1}, [&](const Vec3& p) {
    return p[0] < length && std::abs(p[1] - 21.3) < (p[0] - 1) * std::tan(half_angle);
  });
  const std::vector<float> all = thickness_volume(wedge, voxel_core(wedge), {.correction = 0.5});
  const double sine = std::sin(half_angle);
  for (int x = 8; x < 30; ++x) {
    const double expected = 2 * (x - 1) * sine / (1 - sine);
    EXPECT_NEAR(value_at(wedge, all, x, 21, 15), expected, 1.2) << x;
  }
}

bool in_sponge(int x, int y, int z, int level) {
  for (; level > 0; --level, x /= 3, y /= 3, z /= 3)
    if ((x % 3 == 1) + (y % 3 == 1) + (z % 3 == 1) >= 2) return false;
  return true;
}

TEST(LocalThickness, OfASponge) {
  Grid grid;
  grid.dims = {27, 27, 27};
  const VoxelShape sponge =
      testing_shapes::from_predicate(grid, [](int x, int y, int z) { return in_sponge(x, y, z, 3); });
  const MedialAxis core = voxel_core(sponge);
  const std::vector<Vec3> centres = oracles::voxel_centres(sponge);
  const std::vector<double> all = thickness_in(sponge, core, {.between = false});
  for (std::size_t i = 0; i < centres.size(); i += 7)
    ASSERT_NEAR(all[i], oracles::thickness_of_vertices(core, centres[i]), 1e-5);
  ThicknessReport report = local_thickness(sponge, core, {}, nullptr);
  EXPECT_EQ(report.voxels, sponge.voxel_count());
  EXPECT_EQ(report.uncovered, 0);
  EXPECT_NEAR(report.distribution.least(), std::sqrt(3.0), 1e-6);
}

// Random balls and pairs in a volume of several bricks.
TEST(LocalThickness, OfRandomBallsInSeveralBricks) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> unit;
  for (int round = 0; round < 6; ++round) {
    Grid grid;
    grid.dims = {140, 70, 70};
    grid.spacing = round % 2 ? Vec3(1, 1, 1) : Vec3(0.5, 1, 2);
    grid.origin = {100, -20, 3};
    grid.direction << 0, -1, 0, 1, 0, 0, 0, 0, 1;
    MedialAxis axis;
    for (int v = 0; v < 60; ++v) {
      axis.points.push_back(grid.world(Vec3(140 * unit(random), 70 * unit(random), 70 * unit(random))));
      axis.radius.push_back(2 + (v % 10 == 0 ? 40 : 8) * unit(random));
    }
    axis.complex.vertex_count = 60;
    for (std::uint32_t v = 1; v < 60; ++v) axis.complex.edges.push_back({static_cast<std::uint32_t>(random() % v), v});
    const VoxelShape shape = testing_shapes::from_predicate(grid, [&](int, int, int) { return unit(random) < 0.03; });
    const std::vector<Vec3> centres = oracles::voxel_centres(shape);
    const std::vector<double> all = thickness_in(shape, axis);
    for (std::size_t i = 0; i < centres.size(); ++i) {
      double best = oracles::thickness_of_vertices(axis, centres[i]);
      for (const auto& [a, b] : axis.complex.edges) {
        const double pa = (centres[i] - axis.points[a]).squaredNorm() - axis.radius[a] * axis.radius[a];
        const double pb = (centres[i] - axis.points[b]).squaredNorm() - axis.radius[b] * axis.radius[b];
        if ((pa > 0) == (pb > 0)) continue;
        const double t = pa / (pa - pb);
        const Vec3 x = axis.points[a] + t * (axis.points[b] - axis.points[a]);
        best = std::max(best, 2 * (centres[i] - x).norm());
      }
      ASSERT_NEAR(all[i], best, 1e-5 * best) << "round " << round << ", voxel " << i;
    }
  }
}

TEST(LocalThickness, DoesNotDependOnThreadsAndPadding) {
  const VoxelShape shape = testing_shapes::random_shape(1, 90);
  const MedialAxis core = voxel_core(shape);
  Context one, four;
  one.threads = 1;
  four.threads = 4;
  std::vector<float> a, b;
  const auto into = [](std::vector<float>& all) {
    return [&all](std::int64_t, std::span<const float> slice) { all.insert(all.end(), slice.begin(), slice.end()); };
  };
  const ThicknessReport ra = local_thickness(shape, core, {}, into(a), &one);
  const ThicknessReport rb = local_thickness(shape, core, {}, into(b), &four);
  EXPECT_EQ(a, b);
  EXPECT_EQ(ra.distribution.mean(), rb.distribution.mean());
  EXPECT_EQ(ra.distribution.deviation(), rb.distribution.deviation());
  EXPECT_EQ(ra.distribution.bins(), rb.distribution.bins());
  EXPECT_EQ(ra.voxels, shape.voxel_count());

  Grid larger = shape.grid();
  const int pad = 37;
  for (auto& d : larger.dims) d += 2 * pad;
  const VoxelShape padded = testing_shapes::from_predicate(
      larger, [&](int x, int y, int z) { return shape.contains(x - pad, y - pad, z - pad); });
  EXPECT_EQ(values_in(shape, a), thickness_in(padded, voxel_core(padded)));
}

TEST(LocalThickness, MaskAndWhatNoBallHolds) {
  const VoxelShape box = testing_shapes::box_shape(12, 9, 7);
  const MedialAxis core = voxel_core(box);
  const std::vector<float> whole = thickness_volume(box, core);
  const VoxelShape mask =
      testing_shapes::from_predicate(box.grid(), [](int x, int y, int) { return x < 5 && (x + y) % 3 != 0; });
  std::vector<float> masked;
  const ThicknessReport report = local_thickness(
      box, core, {.mask = &mask},
      [&](std::int64_t, std::span<const float> slice) { masked.insert(masked.end(), slice.begin(), slice.end()); });
  std::int64_t inside = 0;
  const auto& dims = box.grid().dims;
  for (std::int64_t z = 0; z < dims[2]; ++z)
    for (std::int64_t y = 0; y < dims[1]; ++y)
      for (std::int64_t x = 0; x < dims[0]; ++x) {
        const auto at = static_cast<std::size_t>(x + dims[0] * (y + dims[1] * z));
        EXPECT_EQ(masked[at], mask.contains(x, y, z) ? whole[at] : 0.0f);
        inside += mask.contains(x, y, z) && box.contains(x, y, z);
      }
  EXPECT_EQ(report.voxels, inside);

  MedialAxis one = core;
  one.points = {core.grid.world(Vec3(3, 3, 3))};
  one.radius = {1.8};
  one.complex = {};
  one.complex.vertex_count = 1;
  const ThicknessReport few = local_thickness(box, one, {}, nullptr);
  EXPECT_EQ(few.voxels, box.voxel_count());
  EXPECT_EQ(few.uncovered, box.voxel_count() - 32);  // 8 of the corner and 24 beside
  EXPECT_EQ(local_thickness(box, MedialAxis{}, {}, nullptr).uncovered, box.voxel_count());
}

TEST(LocalThickness, Errors) {
  const VoxelShape box = testing_shapes::box_shape(3, 3, 3), other = testing_shapes::box_shape(4, 3, 3);
  MedialAxis core = voxel_core(box);
  EXPECT_THROW(local_thickness(box, core, {.mask = &other}, nullptr), Error);
  core.radius[0] = std::nan("");
  EXPECT_THROW(local_thickness(box, core, {}, nullptr), Error);
  core.radius.pop_back();
  EXPECT_THROW(local_thickness(box, core, {}, nullptr), Error);
}

TEST(LocalThickness, InThePlane) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    std::mt19937_64 random(seed);
    Grid grid;
    grid.dims = {static_cast<std::int64_t>(3 + random() % 14), static_cast<std::int64_t>(3 + random() % 14), 1};
    if (seed % 2) grid.spacing = {1, 3, 1};
    grid.make_plane();
    const double density = 0.3 + 0.6 * static_cast<double>(random() % 1000) / 1000;
    VoxelShape shape = testing_shapes::from_predicate(
        grid, [&](int, int, int) { return static_cast<double>(random() % 1000) / 1000 < density; });
    if (shape.empty()) continue;
    const MedialAxis core = voxel_core(shape);
    const std::vector<Vec3> centres = oracles::voxel_centres(shape), sites = oracles::sites_of_edges(core, shape);
    const std::vector<double> all = thickness_in(shape, core);
    for (std::size_t i = 0; i < centres.size(); ++i) {
      const double expected = oracles::thickness_of_edges(core, sites, centres[i]);
      ASSERT_GT(expected, 0);
      ASSERT_NEAR(all[i], expected, 1e-6 * expected) << "seed " << seed;
    }
  }
}

}  // namespace thickness_test
}  // namespace quench
