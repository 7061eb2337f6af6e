// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <random>
#include <vector>

#include "quench/polygons.h"

using namespace quench;

namespace boundary_rings_test {

VoxelShape random_plane(std::mt19937& random, int width, int height, unsigned long percent) {
  Grid grid;
  grid.dims = {width, height, 1};
  grid.make_plane();
  VoxelShape shape(grid);
  for (int y = 0; y < height; ++y) {
    std::vector<quench::Run> runs;
    for (int x = 0; x < width; ++x)
      if (random() % 100 < percent) runs.push_back({x, x + 1});
    shape.append_row(runs);
  }
  return shape;
}

double area(const std::vector<Vec2>& ring) {
  double twice = 0;
  for (std::size_t k = 0; k < ring.size(); ++k) {
    const Vec2 &a = ring[k], &b = ring[(k + 1) % ring.size()];
    twice += a[0] * b[1] - a[1] * b[0];
  }
  return twice / 2;
}

bool is_inside(const std::vector<Vec2>& ring, const Vec2& p) {
  bool inside = false;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Vec2 &a = ring[i], &b = ring[(i + 1) % ring.size()];
    if ((a[1] > p[1]) != (b[1] > p[1]) && p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])) inside = !inside;
  }
  return inside;
}

/// Of each hole, the least outer ring around the middle of its first edge, where a hole touches nothing else.
std::vector<Polygons> parts_by_trying_all(const Polygons& boundary) {
  std::vector<Polygons> parts;
  for (const auto& ring : boundary.rings)
    if (area(ring) > 0) parts.push_back({{ring}});
  for (const auto& ring : boundary.rings) {
    if (area(ring) > 0) continue;
    Polygons* best = nullptr;
    for (Polygons& part : parts)
      if (is_inside(part.rings[0], (ring[0] + ring[1]) / 2) && (!best || area(part.rings[0]) < area(best->rings[0])))
        best = &part;
    best->rings.push_back(ring);
  }
  return parts;
}

TEST(BoundaryRings, AreTheOutlineOfRandomShapes) {
  std::mt19937 random(3);
  for (int round = 0; round < 2000; ++round) {
    const VoxelShape shape = random_plane(random, 1 + static_cast<int>(random() % 12),
                                          1 + static_cast<int>(random() % 12), 20 + random() % 70);
    const Polygons outline = boundary_rings(shape);
    std::int64_t outer = 0, holes = 0;
    double total = 0;
    for (const auto& ring : outline.rings) {
      ASSERT_GE(ring.size(), 4u);
      for (std::size_t k = 0; k < ring.size(); ++k) {
        const Vec2 in = ring[(k + 1) % ring.size()] - ring[k],
                   out = ring[(k + 2) % ring.size()] - ring[(k + 1) % ring.size()];
        ASSERT_EQ(in.dot(out), 0) << "neighbours are at right angles";
        ASSERT_GT(in.norm(), 0.5);
      }
      total += area(ring);
      (area(ring) > 0 ? outer : holes) += 1;
    }
    const Topology expected = topology(shape);
    ASSERT_EQ(outer, expected.betti[0]) << round;
    ASSERT_EQ(holes, expected.betti[1]) << round;
    ASSERT_EQ(total, static_cast<double>(shape.voxel_count()));
    if (shape.empty()) continue;
    // Digitized again, the outline gives the same pixels.
    const VoxelShape again = digitize(outline, {.resolution = {}, .pixel = 1.0, .fill = PolygonFill::nonzero});
    ASSERT_EQ(again.voxel_count(), shape.voxel_count());
    const auto box = shape.foreground_box();
    for (std::int64_t y = 0; y < again.grid().dims[1]; ++y)
      for (std::int64_t x = 0; x < again.grid().dims[0]; ++x)
        ASSERT_EQ(again.contains(x, y, 0), shape.contains(x + box.begin[0], y + box.begin[1], 0));
  }
}

TEST(BoundaryRings, BeginAtTheLeastCornerAndGoCounterClockwise) {
  Grid grid;
  grid.dims = {4, 3, 1};
  grid.spacing = Vec3(2, 3, 1);
  grid.origin = Vec3(10, 20, 0);
  grid.make_plane();
  VoxelShape shape(grid);
  shape.append_row({});
  shape.append_row(std::vector<quench::Run>{{1, 3}});
  shape.append_row({});
  const Polygons outline = boundary_rings(shape);
  ASSERT_EQ(outline.rings.size(), 1u);
  EXPECT_EQ(outline.rings[0], (std::vector<Vec2>{{11, 21.5}, {15, 21.5}, {15, 24.5}, {11, 24.5}}));
  grid.direction(0, 0) = -1;
  VoxelShape mirrored(grid);
  mirrored.append_row({});
  mirrored.append_row(std::vector<quench::Run>{{1, 3}});
  mirrored.append_row({});
  EXPECT_GT(area(boundary_rings(mirrored).rings[0]), 0);
}

TEST(BoundaryRings, HolesBelongToTheirParts) {
  std::mt19937 random(8);
  for (int round = 0; round < 1000; ++round) {
    const int width = 1 + static_cast<int>(random() % 40), height = 1 + static_cast<int>(random() % 40);
    const VoxelShape pixels = random_plane(random, width, height, 30 + random() % 60);
    Grid grid = pixels.grid();
    const double angle = round % 4 == 0 ? 0 : 0.1 * round;
    grid.direction.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(angle).toRotationMatrix();
    if (round % 3 == 0) grid.direction.col(1) *= -1;
    grid.spacing = Vec3(1, round % 2 == 0 ? 1 : 0.3, 1);
    grid.origin = Vec3(round % 5 == 0 ? 1e6 : 0.1, -7, 0);
    VoxelShape shape(grid);
    for (int y = 0; y < height; ++y) shape.append_row(pixels.row(y, 0));
    const Polygons boundary = boundary_rings(shape);
    const std::vector<Polygons> parts = parts_of(boundary), expected = parts_by_trying_all(boundary);
    ASSERT_EQ(parts.size(), expected.size());
    for (std::size_t p = 0; p < parts.size(); ++p) ASSERT_EQ(parts[p].rings, expected[p].rings) << round;
  }
}

TEST(BoundaryRings, ManyNestedRings) {
  constexpr int n = 4001;  // squares in squares: a thousand parts, each with a hole
  Grid grid;
  grid.dims = {n, n, 1};
  grid.make_plane();
  VoxelShape shape(grid);
  for (int y = 0; y < n; ++y) {
    std::vector<quench::Run> runs;
    const int depth = std::min(y, n - 1 - y);
    for (int k = 0; k < depth; k += 2) runs.push_back({k, k + 1});
    if (depth % 2 == 0) runs.push_back({depth, n - depth});
    for (int k = (depth - 1) / 2 * 2; k >= 0 && depth > 0; k -= 2) runs.push_back({n - 1 - k, n - k});
    shape.append_row(runs);
  }
  const auto parts = parts_of(boundary_rings(shape));
  ASSERT_EQ(parts.size(), 1001u);
  for (std::size_t p = 0; p < parts.size(); ++p) {
    ASSERT_EQ(parts[p].rings.size(), p + 1 < parts.size() ? 2u : 1u);
    if (parts[p].rings.size() > 1) {
      ASSERT_EQ(parts[p].rings[1][0], parts[p].rings[0][0] + Vec2(1, 1));
    }
  }
}

}  // namespace boundary_rings_test
