// SPDX-License-Identifier: Apache-2.0
#include "voxelization/surface_cover.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "voxelization/deflate.h"
#include "shape/simple_voxel.h"
#include "voxelization/solid_topology.h"
#include "voxelization/voxel_graph.h"

namespace quench::voxelization {
namespace surface_cover_test {

using Rational = __int128;
using Triple = std::array<FixedPoint, 3>;
constexpr std::int64_t kVoxel = std::int64_t{1} << kFractionBits;

/// A point (x, y, z) / w, w > 0.
struct Homogeneous {
  std::array<Rational, 3> p;
  Rational w;
};

/// The oracle, with rational numbers: the triangle is clipped to the closed box, and meets the open one exactly when
/// the mean of the corners that are left is inside it. Coordinates in units of `unit` are small integers.
bool meets_by_clipping(const Triple& triangle, const std::array<std::int64_t, 3>& voxel, std::int64_t unit) {
  std::vector<Homogeneous> polygon;
  for (const FixedPoint& p : triangle) polygon.push_back({{p[0] / unit, p[1] / unit, p[2] / unit}, 1});
  const std::int64_t side = kVoxel / unit;
  for (std::size_t a = 0; a < 3; ++a)
    for (const int sign : {1, -1}) {
      const Rational bound = (voxel[a] + (sign > 0 ? 0 : 1)) * side;
      std::vector<Homogeneous> left;
      for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Homogeneous &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
        const Rational s = sign * (p.p[a] - bound * p.w), t = sign * (q.p[a] - bound * q.w);  // times w
        if (s >= 0) left.push_back(p);
        if ((s < 0) == (t < 0)) continue;
        Homogeneous cut;  // |t| p + |s| q
        const Rational u = t < 0 ? -t : t, v = s < 0 ? -s : s;
        for (std::size_t b = 0; b < 3; ++b) cut.p[b] = u * p.p[b] + v * q.p[b];
        cut.w = u * p.w + v * q.w;
        Rational g = cut.w;
        for (const Rational c : cut.p) {
          Rational m = c < 0 ? -c : c;
          while (m != 0) {
            const Rational r = g % m;
            g = m;
            m = r;
          }
        }
        for (Rational& c : cut.p) c /= g;
        cut.w /= g;
        left.push_back(cut);
      }
      polygon = std::move(left);
      if (polygon.empty()) return false;
    }
  for (std::size_t a = 0; a < 3; ++a)
    for (const int sign : {1, -1}) {
      const Rational bound = (voxel[a] + (sign > 0 ? 0 : 1)) * side;
      bool off = false;  // some corner is off this side of the box
      for (const Homogeneous& p : polygon) off = off || p.p[a] != bound * p.w;
      if (!off) return false;
    }
  return true;
}

FixedPoint random_point(std::mt19937_64& random, std::int64_t side, std::int64_t unit) {
  FixedPoint p;
  for (std::int64_t& c : p) c = static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(side + 1)) * unit;
  return p;
}

TEST(SurfaceCover, AVoxelIsMetExactlyWhenTheClippedTriangleIsInside) {
  std::mt19937_64 random(1);
  int met = 0, touched = 0;
  for (int repeat = 0; repeat < 4000; ++repeat) {
    // Corners on halves of voxels, on eighths, and with the precision of the voxelizer: ties all the time, or never.
    const std::int64_t unit = repeat % 3 == 0 ? kVoxel / 2 : repeat % 3 == 1 ? kVoxel / 8 : kVoxel / 64;
    const std::int64_t side = 3 * kVoxel / unit;
    Triple triangle{random_point(random, side, unit), random_point(random, side, unit),
                    random_point(random, side, unit)};
    if (repeat % 7 == 0) triangle[2] = triangle[1];
    for (std::int64_t z = -1; z <= 3; ++z)
      for (std::int64_t y = -1; y <= 3; ++y)
        for (std::int64_t x = -1; x <= 3; ++x) {
          const bool expected = meets_by_clipping(triangle, {x, y, z}, unit);
          ASSERT_EQ(meets(triangle, {x, y, z}), expected) << repeat << ": " << x << ' ' << y << ' ' << z;
          met += expected;
          ++touched;
        }
  }
  EXPECT_GT(met, 20000);
  EXPECT_GT(touched, 10 * met);
}

/// Where 128 bits are needed.
TEST(SurfaceCover, LargeTrianglesAreMetWhereTheirPartsAre) {
  std::mt19937_64 random(2);
  constexpr std::int64_t kFar = std::int64_t{16384} * kVoxel;
  for (int repeat = 0; repeat < 3000; ++repeat) {
    const Triple triangle{FixedPoint{0, 0, 0}, random_point(random, 16384, kVoxel), random_point(random, kFar, 1)};
    // The middles of its edges divide it into four triangles.
    std::array<FixedPoint, 3> middle;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t a = 0; a < 3; ++a) middle[i][a] = (triangle[i][a] + triangle[(i + 1) % 3][a]) / 2;
    const double s = static_cast<double>(random() >> 11) * 0x1p-53, t = static_cast<double>(random() >> 11) * 0x1p-53;
    std::array<std::int64_t, 3> voxel;
    FixedPoint inside;  // of the triangle, nearly
    for (std::size_t a = 0; a < 3; ++a) {
      const double u = std::min(s, 1 - t), v = std::min(t, 1 - s);
      inside[a] = std::llround((1 - u - v) * static_cast<double>(triangle[0][a]) +
                               u * static_cast<double>(triangle[1][a]) + v * static_cast<double>(triangle[2][a]));
      voxel[a] = inside[a] >> kFractionBits;
    }
    bool off_faces = true;
    for (std::size_t a = 0; a < 3; ++a) {
      const std::int64_t within = inside[a] - voxel[a] * kVoxel;
      off_faces = off_faces && within > 16 && within < kVoxel - 16;
    }
    if (off_faces) {
      EXPECT_TRUE(meets(triangle, voxel)) << repeat;
    }
    bool even = true;
    for (const FixedPoint& p : triangle)
      for (const std::int64_t c : p) even = even && c % 2 == 0;
    if (!even) continue;
    const bool of_parts =
        meets({triangle[0], middle[0], middle[2]}, voxel) || meets({middle[0], triangle[1], middle[1]}, voxel) ||
        meets({middle[2], middle[1], triangle[2]}, voxel) || meets({middle[0], middle[1], middle[2]}, voxel);
    EXPECT_EQ(meets(triangle, voxel), of_parts) << repeat;
  }
}

struct RandomSoup {
  FixedMesh mesh;
  std::vector<std::array<std::uint32_t, 3>> triangles;

  RandomSoup(std::mt19937_64& random, std::int64_t cells, int count, std::int64_t unit) {
    for (int t = 0; t < count; ++t) {
      const auto n = static_cast<std::uint32_t>(mesh.points.size());
      const FixedPoint at = random_point(random, cells * kVoxel / unit, unit);
      for (int i = 0; i < 3; ++i) {
        FixedPoint p = random_point(random, cells * kVoxel / unit, unit);
        if (t % 2)  // a small one
          for (std::size_t a = 0; a < 3; ++a) p[a] = at[a] + (p[a] - at[a]) / 16;
        mesh.points.push_back(p);
      }
      triangles.push_back({n, n + 1, n + 2});
    }
    mesh.triangles = triangles;
    mesh.cells = {cells, cells, cells};
  }
  RandomSoup(const RandomSoup&) = delete;
  RandomSoup& operator=(const RandomSoup&) = delete;
};

TEST(SurfaceCover, HoldsExactlyTheVoxelsThatAreMet) {
  std::mt19937_64 random(3);
  for (int repeat = 0; repeat < 60; ++repeat) {
    const std::int64_t cells = 5 + repeat % 8;
    const RandomSoup soup(random, cells, 1 + repeat % 9, repeat % 2 ? kVoxel / 2 : 1);
    const SurfaceCover cover = surface_cover(soup.mesh, {});
    ASSERT_EQ(cover.x.size(), cover.distance.size());
    for (std::int64_t z = 0; z < cells; ++z)
      for (std::int64_t y = 0; y < cells; ++y) {
        const auto row = cover.row(y, z);
        ASSERT_TRUE(std::is_sorted(row.begin(), row.end()));
        for (std::int64_t x = 0; x < cells; ++x) {
          bool met = false;
          for (const auto& t : soup.triangles)
            met = met || meets({soup.mesh.points[t[0]], soup.mesh.points[t[1]], soup.mesh.points[t[2]]}, {x, y, z});
          const auto found = std::count(row.begin(), row.end(), static_cast<std::int32_t>(x));
          ASSERT_EQ(found, met ? 1 : 0) << repeat << ": " << x << ' ' << y << ' ' << z;
        }
      }
    for (const std::uint8_t d : cover.distance) ASSERT_LE(d * SurfaceCover::kDistanceUnit, std::sqrt(0.75));
  }
}

VoxelShape random_voxel_shape(std::mt19937_64& random, std::int64_t cells, std::int64_t margin) {
  Grid grid;
  grid.dims = {cells + 2 * margin, cells + 2 * margin, cells + 2 * margin};
  VoxelShape shape(grid);
  for (std::int64_t row = 0; row < grid.dims[1] * grid.dims[2]; ++row) {
    std::vector<Run> runs;
    const std::int64_t y = row % grid.dims[1], z = row / grid.dims[1];
    const auto in = [&](std::int64_t i) { return i >= margin && i < cells + margin; };
    if (in(y) && in(z))
      for (std::int64_t x = margin; x < cells + margin; ++x)
        if (random() % 3 == 0)
          runs.push_back({static_cast<std::int32_t>(x), static_cast<std::int32_t>(std::min(x + 3, cells + margin))});
    shape.append_row(runs);
  }
  return shape;
}

/// What deflation leaves, of any shape and any cover: the topologies it promises, and nothing simple.
TEST(Deflation, KeepsTheTopologyOfTheCoverAndLeavesNothingSimple) {
  std::mt19937_64 random(4);
  std::size_t left_over = 0;
  for (int repeat = 0; repeat < 80; ++repeat) {
    const std::int64_t cells = 4 + repeat % 6, margin = repeat % 3;
    const RandomSoup soup(random, cells, 1 + repeat % 6, 1);
    const SurfaceCover cover = surface_cover(soup.mesh, {});
    const VoxelShape shape = random_voxel_shape(random, cells, margin);
    std::array<std::vector<Voxel>, 2> met, left;  // outside, inside
    for (std::int32_t z = 0; z < cells; ++z)
      for (std::int32_t y = 0; y < cells; ++y)
        for (const std::int32_t x : cover.row(y, z)) {
          const auto m = static_cast<std::int32_t>(margin);
          met[shape.contains(x + m, y + m, z + m)].push_back({x + m, y + m, z + m});
        }
    for (const Voxel& v : deflate(cover, shape, margin, {})) left[shape.contains(v[0], v[1], v[2])].push_back(v);
    for (const std::size_t inside : {0u, 1u}) {
      const VoxelShape whole = with_flipped(shape, met[inside]), deflated = with_flipped(shape, left[inside]);
      ASSERT_EQ(topology(deflated).betti, topology(whole).betti) << repeat;
      left_over += left[inside].size();
      for (const Voxel& v : left[inside]) {
        Neighbours around = 0;
        for (int i = 0; i < 27; ++i)
          if (deflated.contains(v[0] + i % 3 - 1, v[1] + i / 3 % 3 - 1, v[2] + i / 9 - 1)) around |= 1u << i;
        ASSERT_FALSE(is_simple(around)) << repeat;
      }
    }
  }
  EXPECT_GT(left_over, 500u);
}

/// Points of both triangles, found by trying: a common one proves that they meet.
TEST(SolidTopology, TrianglesMeetExactlyWhenAnEdgeOfOneMeetsTheOther) {
  std::mt19937_64 random(5);
  const auto volume = [](const FixedPoint& a, const FixedPoint& b, const FixedPoint& c, const FixedPoint& d) {
    const auto m = [&](const FixedPoint& p, std::size_t i) { return Rational{p[i] - a[i]}; };
    const Rational v = m(b, 0) * (m(c, 1) * m(d, 2) - m(c, 2) * m(d, 1)) -
                       m(b, 1) * (m(c, 0) * m(d, 2) - m(c, 2) * m(d, 0)) +
                       m(b, 2) * (m(c, 0) * m(d, 1) - m(c, 1) * m(d, 0));
    return v > 0 ? 1 : v < 0 ? -1 : 0;
  };
  // Where no four points are coplanar: an edge passes through the other triangle.
  const auto pierces = [&](const FixedPoint& p, const FixedPoint& q, const Triple& t) {
    if (volume(t[0], t[1], t[2], p) == volume(t[0], t[1], t[2], q)) return false;
    const int s = volume(p, q, t[0], t[1]);
    return s == volume(p, q, t[1], t[2]) && s == volume(p, q, t[2], t[0]);
  };
  int meeting = 0, apart = 0;
  for (int repeat = 0; repeat < 20000; ++repeat) {
    Triple a, b;
    for (FixedPoint& p : a) p = random_point(random, repeat % 2 ? 1 << 30 : 1000, 1);
    for (FixedPoint& p : b) p = random_point(random, repeat % 2 ? 1 << 30 : 1000, 1);
    bool expected = false, general = true;
    for (std::size_t i = 0; i < 3; ++i) {
      expected = expected || pierces(a[i], a[(i + 1) % 3], b) || pierces(b[i], b[(i + 1) % 3], a);
      general = general && volume(a[0], a[1], a[2], b[i]) != 0 && volume(b[0], b[1], b[2], a[i]) != 0;
      for (std::size_t j = 0; j < 3; ++j) general = general && volume(a[i], a[(i + 1) % 3], b[j], b[(j + 1) % 3]) != 0;
    }
    if (!general) continue;
    ASSERT_EQ(triangles_meet(a, b), expected) << repeat;
    ASSERT_EQ(triangles_meet(b, a), expected) << repeat;
    ++(expected ? meeting : apart);
  }
  EXPECT_GT(meeting, 1000);
  EXPECT_GT(apart, 1000);
  const Triple flat{{{0, 0, 0}, {10, 0, 0}, {0, 10, 0}}};
  EXPECT_TRUE(triangles_meet(flat, {{{10, 0, 0}, {20, 0, 0}, {20, 10, 0}}}));  // coplanar, at a corner
  EXPECT_FALSE(triangles_meet(flat, {{{6, 6, 0}, {10, 10, 0}, {6, 10, 0}}}));  // coplanar, boxes overlap
  EXPECT_TRUE(triangles_meet(flat, {{{2, 2, 0}, {3, 2, 0}, {2, 3, 0}}}));      // one in the other
  EXPECT_TRUE(triangles_meet(flat, {{{2, 2, 0}, {2, 2, 0}, {2, 2, 9}}}));      // a segment that stands on it
  EXPECT_FALSE(triangles_meet(flat, {{{2, 2, 1}, {2, 2, 1}, {2, 2, 9}}}));
}

}  // namespace surface_cover_test
}  // namespace quench::voxelization
