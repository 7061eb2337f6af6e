// SPDX-License-Identifier: Apache-2.0
#include "quench/voxelize.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "quench/error.h"
#include "quench/shape.h"
#include "random_meshes.h"

namespace quench {
namespace voxelize_test {

using namespace testing_meshes;
using Int128 = __int128;

std::optional<ErrorCode> error_of(const TriangleMesh& mesh, const VoxelizeOptions& options = {}) {
  try {
    voxelize(mesh, options);
    return std::nullopt;
  } catch (const Error& e) {
    EXPECT_GT(std::string(e.what()).size(), 20u);
    return e.code();
  }
}

int sign_of_volume(const Point& a, const Point& b, const Point& c, const Point& d) {
  const auto m = [&](const Point& p, std::size_t i) { return Int128{p[i] - a[i]}; };
  const Int128 det = m(b, 0) * (m(c, 1) * m(d, 2) - m(c, 2) * m(d, 1)) -
                     m(b, 1) * (m(c, 0) * m(d, 2) - m(c, 2) * m(d, 0)) +
                     m(b, 2) * (m(c, 0) * m(d, 1) - m(c, 1) * m(d, 0));
  return det > 0 ? 1 : det < 0 ? -1 : 0;
}

// The oracle: the winding number of a closed surface around p is the number of signed tetrahedra, from any point o to
// the triangles, that contain p. No scanline, no projection; nullopt when p lies on the plane of a face of one of them.
std::optional<int> winding_number(const std::vector<Point>& points, const TriangleMesh& mesh, const Point& o,
                                  const Point& p) {
  int winding = 0;
  for (const auto& t : mesh.triangles) {
    const Point &a = points[t[0]], &b = points[t[1]], &c = points[t[2]];
    const int whole = sign_of_volume(o, a, b, c);
    if (whole == 0) continue;  // o, chosen in general position, lies in the plane only of degenerate triangles
    const int parts[4] = {sign_of_volume(p, a, b, c), sign_of_volume(o, p, b, c), sign_of_volume(o, a, p, c),
                          sign_of_volume(o, a, b, p)};
    int same = 0;
    for (const int s : parts) {
      if (s == 0) return std::nullopt;
      same += s == whole;
    }
    if (same == 4) winding += whole;
  }
  return winding;
}

/// Compares every voxel with the oracle. `points` are the points of `mesh`, `voxel` the size of a voxel and `shift`
/// that of the centre, all in the oracle's units; the minimum of the mesh's box is its origin.
void expect_equals_oracle(const TriangleMesh& mesh, const std::vector<Point>& points, std::int64_t voxel,
                          const Point& shift, const Point& o, std::int64_t resolution, std::uint64_t seed) {
  for (const FillRule fill : {FillRule::nonzero, FillRule::evenodd}) {
    VoxelizeOptions options;
    options.resolution = resolution;
    options.fill = fill;
    options.topology = TopologyRule::voxels;
    options.margin = static_cast<std::int64_t>(seed % 3);
    VoxelShape shape;
    try {
      shape = voxelize(mesh, options).shape;
      shape.validate();
    } catch (const Error& e) {
      ASSERT_NE(std::string(e.what()).find("no voxel centre"), std::string::npos) << e.what();
    }
    for (std::int64_t z = -1; z <= resolution; ++z)
      for (std::int64_t y = -1; y <= resolution; ++y)
        for (std::int64_t x = -1; x <= resolution; ++x) {
          const Point p{x * voxel + voxel / 2 + shift[0], y * voxel + voxel / 2 + shift[1],
                        z * voxel + voxel / 2 + shift[2]};
          const auto winding = winding_number(points, mesh, o, p);
          ASSERT_TRUE(winding) << "seed " << seed;
          const bool inside = fill == FillRule::nonzero ? *winding != 0 : *winding % 2 != 0;
          const std::int64_t m = options.margin;
          ASSERT_EQ(shape.contains(x + m, y + m, z + m), inside)
              << "seed " << seed << " voxel " << x << ' ' << y << ' ' << z;
        }
  }
}

Point low_corner(const TriangleMesh& mesh, std::int64_t& side) {
  Vec3 low = mesh.points[0], high = low;
  for (const Vec3& p : mesh.points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  side = static_cast<std::int64_t>((high - low).maxCoeff());
  return {std::llround(low[0]), std::llround(low[1]), std::llround(low[2])};
}

bool flat(const TriangleMesh& mesh) {
  for (int a = 0; a < 3; ++a) {
    std::set<double> values;
    for (const Vec3& p : mesh.points) values.insert(p[a]);
    if (values.size() < 2) return true;
  }
  return false;
}

// Corners on half voxels: centres lie on faces, edges and vertices all the time. A shift of the centre by 2^-12, 2^-22
// and 2^-32 units is small enough, against faces with normals below 2^9, to act as the symbolic one.
TEST(Voxelize, EqualsTheWindingNumberOfTheShiftedCentreWithTies) {
  constexpr std::int64_t unit = std::int64_t{1} << 32;
  std::mt19937_64 random(11);
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const TriangleMesh mesh = random_mesh(random, 12);
    if (flat(mesh)) continue;
    std::int64_t side = 0;
    const Point low = low_corner(mesh, side);
    if (side % 2) continue;
    std::vector<Point> points;
    for (const Vec3& p : mesh.points) {
      points.emplace_back();
      for (std::size_t a = 0; a < 3; ++a) points.back()[a] = (std::llround(p[static_cast<int>(a)]) - low[a]) * unit;
    }
    const Point o{-31 * unit + 123'456'791, -37 * unit + 987'654'323, -41 * unit + 555'555'557};
    expect_equals_oracle(mesh, points, 2 * unit, {1 << 20, 1 << 10, 1}, o, side / 2, seed);
  }
}

// General position: the rounded coordinates decide, at any scale and offset.
TEST(Voxelize, EqualsTheWindingNumberOfTheRoundedMesh) {
  std::mt19937_64 random(12);
  for (std::uint64_t seed = 0; seed < 150; ++seed) {
    TriangleMesh mesh = random_mesh(random, 40);
    const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
    const double scale = std::exp(20 * unit() - 10);
    const Vec3 offset(unit(), unit(), unit());
    for (Vec3& p : mesh.points) p = scale * (p + 0.9 * Vec3(unit(), unit(), unit()) + 10 * offset);
    const std::int64_t resolution = 1 + static_cast<std::int64_t>(random() % 10);
    Vec3 low = mesh.points[0], high = low;
    for (const Vec3& p : mesh.points) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    std::vector<Point> points;
    for (const Vec3& p : mesh.points) {
      points.emplace_back();
      for (std::size_t a = 0; a < 3; ++a) {
        const int i = static_cast<int>(a);
        points.back()[a] =
            std::llround((p[i] - low[i]) / (high - low).maxCoeff() * std::ldexp(static_cast<double>(resolution), 20));
      }
    }
    const Point o{-31'456'789, -37'654'321, -41'555'557};
    expect_equals_oracle(mesh, points, 1 << 20, {0, 0, 0}, o, resolution, seed);
  }
}

// The six tetrahedra of every cell of a grid whose inner vertices were moved tile the box: so must their voxels, with
// centres on shared faces, edges and vertices.
TEST(Voxelize, TetrahedraThatTileABoxShareNoVoxelAndMissNone) {
  constexpr std::array<std::array<std::size_t, 3>, 6> orders{
      {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
  std::mt19937_64 random(13);
  for (int repeat = 0; repeat < 30; ++repeat) {
    const std::int64_t side = 24;  // half voxels; cells of 8
    const auto vertex = [&, salt = random()](std::array<std::int64_t, 3> cell) {
      std::mt19937_64 local(salt + static_cast<std::uint64_t>(cell[0] + 4 * cell[1] + 16 * cell[2]));
      Point p{};
      for (std::size_t a = 0; a < 3; ++a) {
        p[a] = 8 * cell[a];
        if (cell[a] > 0 && cell[a] < 3) p[a] += static_cast<std::int64_t>(local() % 3) - 1;
      }
      return p;
    };
    std::array<int, 12 * 12 * 12> owners{};
    for (std::int64_t c = 0; c < 27; ++c)
      for (const auto& order : orders) {
        std::array<std::int64_t, 3> cell{c % 3, c / 3 % 3, c / 9};
        std::array<Point, 4> corners{vertex(cell)};
        for (std::size_t k = 0; k < 3; ++k) {
          ++cell[order[k]];
          corners[k + 1] = vertex(cell);
        }
        ASSERT_NE(sign_of_volume(corners[0], corners[1], corners[2], corners[3]), 0);
        TriangleMesh mesh;
        add_tetrahedron(mesh, corners, random() % 2 == 0);
        add_frame(mesh, side);
        VoxelizeOptions options;
        options.resolution = 12;
        options.margin = 0;
        options.topology = TopologyRule::voxels;
        const VoxelShape shape = voxelize(mesh, options).shape;
        for (std::size_t v = 0; v < owners.size(); ++v) {
          const auto i = static_cast<std::int64_t>(v);
          owners[v] += shape.contains(i % 12, i / 12 % 12, i / 144);
        }
      }
    for (const int n : owners) ASSERT_EQ(n, 1) << "repeat " << repeat;
  }
}

TEST(Voxelize, PermutedAndMirroredAxesGiveThePermutedAndMirroredShape) {
  std::mt19937_64 random(14);
  constexpr std::int64_t side = 11 << 20;  // in general position: no centre on a face
  for (int repeat = 0; repeat < 40; ++repeat) {
    TriangleMesh mesh = random_mesh(random, side / 2);
    for (Vec3& p : mesh.points)
      p = (p + Vec3::Constant(static_cast<double>(side / 4))).cwiseMin(static_cast<double>(side));
    add_frame(mesh, side);
    TriangleMesh turned = mesh;
    for (Vec3& p : turned.points) p = Vec3(p[2], static_cast<double>(side) - p[0], p[1]);
    VoxelizeOptions options;
    options.resolution = 11;
    if (error_of(mesh, options)) {  // encloses no centre
      EXPECT_TRUE(error_of(turned, options));
      continue;
    }
    const VoxelShape a = voxelize(mesh, options).shape, b = voxelize(turned, options).shape;
    EXPECT_EQ(a.voxel_count(), b.voxel_count());
    for (std::int64_t z = 0; z < 13; ++z)
      for (std::int64_t y = 0; y < 13; ++y)
        for (std::int64_t x = 0; x < 13; ++x) ASSERT_EQ(a.contains(x, y, z), b.contains(z, 12 - x, y));
  }
}

TEST(Voxelize, GridLiesAWholeNumberOfVoxelsBelowTheBox) {
  TriangleMesh mesh;
  add_box(mesh, {10, 20, 30}, {20, 24, 33});
  VoxelizeOptions options;
  options.resolution = 20;
  options.margin = 3;
  const Voxelization result = voxelize(mesh, options);
  const Grid& grid = result.shape.grid();
  EXPECT_EQ(grid.dims, (std::array<std::int64_t, 3>{26, 14, 12}));
  EXPECT_EQ(grid.spacing, Vec3(0.5, 0.5, 0.5));
  EXPECT_EQ(grid.world(Vec3::Constant(3)), Vec3(10, 20, 30));
  EXPECT_EQ(result.longest_side, 10);
  EXPECT_EQ(result.shape.voxel_count(), 20 * 8 * 6);
  EXPECT_FALSE(result.topology_changed) << result.topology_difference;
  for (Vec3& p : mesh.points) p += Vec3(-50, 1, 7);
  const Voxelization moved = voxelize(mesh, options);
  EXPECT_TRUE(std::equal(moved.shape.runs().begin(), moved.shape.runs().end(), result.shape.runs().begin()));
  EXPECT_EQ(moved.shape.grid().world(Vec3::Constant(3)), Vec3(-40, 21, 37));
}

TEST(Voxelize, NumberOfThreadsChangesNothing) {
  std::mt19937_64 random(15);
  const TriangleMesh mesh = random_mesh(random, 100);
  Context one, two;
  one.threads = 1;
  two.threads = 2;
  double last = 0;
  one.progress = [&](std::string_view, double f) {
    EXPECT_GE(f, last);
    last = f;
  };
  const VoxelShape a = voxelize(mesh, {}, &one).shape, b = voxelize(mesh, {}, &two).shape;
  EXPECT_TRUE(std::equal(a.runs().begin(), a.runs().end(), b.runs().begin(), b.runs().end()));
  EXPECT_EQ(last, 1);
  one.cancel();
  EXPECT_THROW(voxelize(mesh, {}, &one), Error);
}

// The largest numbers: slivers across 16384 voxels, along every axis. Compared where the side on which a centre lies
// does not depend on a small shift; ties are tested above.
TEST(Voxelize, HighestResolutionIsExact) {
  constexpr std::int64_t n = 16384, unit = std::int64_t{1} << 20;
  std::mt19937_64 random(16);
  const auto below = [&](std::int64_t m) {
    return static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(m));
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::array<Point, 4> corners{{{0, 0, 0}, {2 * n, 3, 1}, {0, 9, 0}, {1, 0, 9}}};
    for (Point& p : corners) std::rotate(p.begin(), p.begin() + static_cast<std::ptrdiff_t>((3 - axis) % 3), p.end());
    TriangleMesh mesh;
    add_tetrahedron(mesh, corners);
    std::vector<Point> points;
    for (const Point& p : corners) points.push_back({p[0] * unit, p[1] * unit, p[2] * unit});
    VoxelizeOptions options;
    options.resolution = n;
    const VoxelShape sliver = voxelize(mesh, options).shape;
    const Point o{-31 * unit, -37 * unit - 5, -41 * unit + 9};
    int compared = 0, inside = 0;
    for (int sample = 0; sample < 20000; ++sample) {
      Point v{below(4), below(4), below(4)};
      v[axis] = below(n - 8);  // the tip is thinner than the shift
      std::array<std::optional<int>, 2> w;
      for (const int side : {0, 1}) {
        Point p{};
        for (std::size_t a = 0; a < 3; ++a)
          p[a] = (2 * v[a] + 1) * unit + (side ? 1 : -1) * (a == 0 ? 7 : a == 1 ? 3 : 1);
        w[static_cast<std::size_t>(side)] = winding_number(points, mesh, o, p);
        ASSERT_TRUE(w[static_cast<std::size_t>(side)]);
      }
      if (*w[0] != *w[1]) continue;
      ++compared;
      inside += *w[0] != 0;
      ASSERT_EQ(sliver.contains(v[0] + 1, v[1] + 1, v[2] + 1), *w[0] != 0) << v[0] << ' ' << v[1] << ' ' << v[2];
    }
    EXPECT_GT(compared, 15000);
    EXPECT_GT(inside, 500);
  }
}

TEST(Voxelize, NestedOverlappingAndInwardPartsNeedNothingMore) {
  TriangleMesh mesh;
  add_box(mesh, {0, 0, 0}, {16, 16, 16}, true);
  VoxelizeOptions options;
  options.resolution = 16;
  EXPECT_FALSE(voxelize(mesh, options).topology_changed);
  add_box(mesh, {4, 4, 4}, {12, 12, 12});  // against the outer one: a cavity
  Voxelization result = voxelize(mesh, options);
  EXPECT_EQ(result.shape.voxel_count(), 4096 - 512);
  EXPECT_FALSE(result.topology_changed) << result.topology_difference;
  EXPECT_EQ(result.surface.euler, 2);
  EXPECT_EQ(result.surface.components, 2);
  for (std::size_t t = 12; t < 24; ++t) std::swap(mesh.triangles[t][0], mesh.triangles[t][1]);  // the same way: solid
  result = voxelize(mesh, options);
  EXPECT_EQ(result.shape.voxel_count(), 4096);
  EXPECT_TRUE(result.topology_known);  // from the winding number around the inner one
  options.topology = TopologyRule::voxels;
  result = voxelize(mesh, options);
  EXPECT_FALSE(result.topology_known);
  EXPECT_FALSE(result.topology_changed);
  options.fill = FillRule::evenodd;
  EXPECT_EQ(voxelize(mesh, options).shape.voxel_count(), 4096 - 512);
}

TEST(Voxelize, ReportsAGapThatCloses) {
  TriangleMesh mesh;
  add_box(mesh, {0, 0, 0}, {500, 999, 500});
  add_box(mesh, {0, 1001, 0}, {500, 2000, 500});
  const VoxelizeOptions options{.topology = TopologyRule::voxels};
  const Voxelization coarse = voxelize(mesh, options);
  EXPECT_TRUE(coarse.topology_changed);
  EXPECT_NE(coarse.topology_difference.find("1 component"), std::string::npos) << coarse.topology_difference;
  const Voxelization fine = voxelize_auto(mesh, options);
  EXPECT_FALSE(fine.topology_changed);
  EXPECT_DOUBLE_EQ(fine.shape.grid().spacing[0], 2000.0 / 1024);
}

TEST(Voxelize, RefusesWhatItCannotUse) {
  TriangleMesh box;
  add_box(box, {0, 0, 0}, {4, 5, 6});
  EXPECT_EQ(error_of(box), std::nullopt);
  VoxelizeOptions options;
  for (const std::int64_t resolution : {std::int64_t{0}, std::int64_t{-3}, std::int64_t{16385}}) {
    options.resolution = resolution;
    EXPECT_EQ(error_of(box, options), ErrorCode::usage);
  }
  options = {};
  options.margin = -1;
  EXPECT_EQ(error_of(box, options), ErrorCode::usage);
  EXPECT_EQ(error_of({}), ErrorCode::input);
  for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
    TriangleMesh mesh = box;
    mesh.points[3][1] = bad;
    EXPECT_EQ(error_of(mesh), ErrorCode::input);
    EXPECT_EQ(surface_topology(mesh).components, 1);
    mesh.points[3] = box.points[3];
    mesh.points.push_back(Vec3::Constant(bad));  // unused: does not matter
    EXPECT_EQ(error_of(mesh), std::nullopt);
  }
  TriangleMesh mesh = box;
  for (Vec3& p : mesh.points) p[2] = 1;
  EXPECT_EQ(error_of(mesh), ErrorCode::input);
  mesh = box;
  mesh.triangles[5][1] = 99;
  EXPECT_EQ(error_of(mesh), ErrorCode::input);
  EXPECT_THROW(surface_topology(mesh), Error);
  mesh = box;
  mesh.triangles.pop_back();  // the winding number closes it
  EXPECT_EQ(error_of(mesh), std::nullopt);
  mesh = {};
  add_frame(mesh, 5);
  EXPECT_EQ(error_of(mesh), ErrorCode::input);
  mesh = box;
  for (std::size_t t = 0; t < 2; ++t) std::swap(mesh.triangles[t][0], mesh.triangles[t][1]);  // one side turned
  EXPECT_FALSE(surface_topology(mesh).manifold);
  for (Vec3& p : mesh.points) p = Vec3(p[2], p[0], p[1]);  // that side now meets scanlines
  EXPECT_EQ(error_of(mesh), std::nullopt);
  options = {};
  options.fill = FillRule::evenodd;
  EXPECT_EQ(error_of(mesh, options), std::nullopt);
}

void expect_surface(const TriangleMesh& mesh, std::int64_t euler, std::int64_t components, bool manifold) {
  const SurfaceTopology t = surface_topology(mesh);
  EXPECT_EQ(t.euler, euler);
  EXPECT_EQ(t.components, components);
  EXPECT_EQ(t.manifold, manifold);
}

TEST(SurfaceTopology, CountsTheSolid) {
  TriangleMesh mesh;
  expect_surface(mesh, 0, 0, false);
  add_box(mesh, {0, 0, 0}, {4, 4, 4});
  expect_surface(mesh, 1, 1, true);
  mesh.points.emplace_back(1, 2, 3);    // unreferenced
  mesh.triangles.push_back({0, 0, 1});  // degenerate
  add_octahedron(mesh, {9, 9, 9}, {2, 2, 2});
  expect_surface(mesh, 2, 2, true);
  TriangleMesh soup;  // no shared points, and -0 for 0
  for (const auto& t : mesh.triangles)
    for (const std::uint32_t p : t) {
      Vec3 q = mesh.points[p];
      for (int a = 0; a < 3; ++a)
        if (q[a] == 0 && soup.points.size() % 2) q[a] = -0.0;
      soup.points.push_back(q);
      if (soup.points.size() % 3 == 0) {
        const auto n = static_cast<std::uint32_t>(soup.points.size());
        soup.triangles.push_back({n - 3, n - 2, n - 1});
      }
    }
  expect_surface(soup, 2, 2, true);
  EXPECT_EQ(error_of(soup), std::nullopt);
}

TEST(SurfaceTopology, PartsThatTouchCountAsTheOpenSolid) {
  for (const bool inward : {false, true}) {
    TriangleMesh corner, edge;
    add_box(corner, {0, 0, 0}, {4, 4, 4}, inward);
    add_box(corner, {4, 4, 4}, {8, 8, 8}, inward);
    expect_surface(corner, 2, 1, false);
    add_box(edge, {0, 0, 0}, {4, 4, 4}, inward);
    add_box(edge, {4, 4, 0}, {8, 8, 4}, inward);
    expect_surface(edge, 2, 1, false);
    VoxelizeOptions options;
    options.resolution = 16;
    EXPECT_FALSE(voxelize(corner, options).topology_changed);
    EXPECT_FALSE(voxelize(edge, options).topology_changed);
  }
}

}  // namespace voxelize_test
}  // namespace quench
