// SPDX-License-Identifier: Apache-2.0
// All stages in the plane, against closed forms, under symmetries, and against the definitions by brute force.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>
#include <vector>

#include "plane_shapes.h"
#include "quench/burn.h"
#include "quench/pipeline.h"
#include "same_skeletons.h"

namespace quench {
namespace plane_results_test {

using namespace testing_planes;

const double kDiagonalOfSquare = std::sqrt(2.0);

struct Burned {
  MedialAxis axis;
  Burning burning;
};

// The core pruned for a detail, 0: all of it.
Burned burned(const VoxelShape& shape, double detail) {
  Burned result{voxel_core(shape), {}};
  if (detail > 0) {
    add_detail(result.axis);
    prune_levels(result.axis, kDetail);
    result.axis = pruned(result.axis, detail, kDetail);
  }
  result.burning = burn(result.axis);
  return result;
}

std::uint32_t nearest_vertex(const MedialAxis& axis, double x, double y) {
  std::uint32_t best = 0;
  const Vec3 at(x, y, 0);
  for (std::uint32_t v = 1; v < axis.points.size(); ++v)
    if ((axis.points[v] - at).squaredNorm() < (axis.points[best] - at).squaredNorm()) best = v;
  return best;
}

// A grid whose corners are whole numbers in the world, pixels `size` wide.
Grid corner_grid(std::int64_t width, std::int64_t height, double size = 1) {
  Grid grid = plane_grid(width, height, {size, size});
  grid.origin = Vec3(0.5 * size, 0.5 * size, 0);
  return grid;
}

VoxelShape rectangle(int width, int height) {
  return plane_shape(corner_grid(width, height), [](int, int) { return true; });
}

TEST(PlaneResults, ARectangleBurnsAsTheClosedForm) {
  // Fire runs along the diagonals of the corners, which the core has exactly, and from where they meet along the
  // middle.
  for (int height = 2; height <= 15; ++height)
    for (const int width : {height, height + 1, height + 2, 2 * height + 3, 4 * height}) {
      const Burned full = burned(rectangle(width, height), 0);
      const double half = 0.5 * height;
      double latest = 0;
      for (std::uint32_t v = 0; v < full.axis.points.size(); ++v) {
        const double x = full.axis.points[v][0], y = full.axis.points[v][1];
        const double side = std::min(x, width - x), time = full.burning.burn_time[v];
        latest = std::max(latest, time);
        const double expected = side < half ? kDiagonalOfSquare * side : kDiagonalOfSquare * half + (side - half);
        EXPECT_NEAR(time, expected, 1e-9) << width << " x " << height << " at " << x << ", " << y;
        EXPECT_NEAR(full.burning.erosion_thickness[v], expected - full.axis.radius[v], 1e-9);
      }
      EXPECT_EQ(full.burning.max_burn_time, latest);
      EXPECT_EQ(full.burning.unburned, 0u);
    }
}

// With four arms of width 2 m fire comes to the crossing along the shortest two, then the third, and goes on along the
// longest. In the square in the middle the axis runs straight between the four corners: edges there are m long.
TEST(PlaneResults, ACrossBurnsAsTheClosedForm) {
  for (const int m : {1, 2, 4, 7})
    for (const std::array<int, 4>& arms : {std::array{17, 19, 22, 30}, {30, 17, 30, 17}, {40, 21, 21, 18}}) {
      // From the crossing to the ends: left, up, right, down.
      const int cx = arms[0], cy = arms[1];
      const VoxelShape cross = plane_shape(corner_grid(cx + arms[2], cy + arms[3]), [&](int x, int y) {
        return (x >= cx - m && x < cx + m) || (y >= cy - m && y < cy + m);
      });
      const Burned full = burned(cross, 0);
      std::array<int, 4> sorted = arms;
      std::sort(sorted.begin(), sorted.end());
      const double at_end = kDiagonalOfSquare * m;
      const double at_crossing = at_end + (sorted[2] - m);
      EXPECT_NEAR(full.burning.burn_time[nearest_vertex(full.axis, cx, cy)], at_crossing, 1e-9) << m;
      for (std::uint32_t v = 0; v < full.axis.points.size(); ++v) {
        const double dx = full.axis.points[v][0] - cx, dy = full.axis.points[v][1] - cy;
        if (std::abs(dx) > 1e-9 && std::abs(dy) > 1e-9) continue;  // of a diagonal at an end
        const double away = std::abs(dx) + std::abs(dy);
        const int arm = arms[dx < -1e-9 ? 0 : dy < -1e-9 ? 1 : dx > 1e-9 ? 2 : 3];
        const double from_end = at_end + (arm - m - away);
        if (arm - m < away || away < 1e-9) continue;
        EXPECT_NEAR(full.burning.burn_time[v], std::min(from_end, at_crossing + away), 1e-9)
            << m << " at " << dx << ", " << dy;
      }
    }
}

// Where a wall and the inner corner are equally far, the axis of an L is a parabola: with the corner as its focus its
// length from the end of the arm's middle line to the diagonal is w (t sqrt(1 + t^2) + asinh t) / 2, t = sqrt(2) - 1.
// Every point of the core is within 1/4 pixel (beta) of the axis and the diagonal is exact: times differ by less than
// two pixels, and by a share of the width that goes to 0.
TEST(PlaneResults, AnLBurnsAsTheClosedForm) {
  for (const int w : {8, 16, 32, 64}) {
    const int length = 4 * w;
    const VoxelShape shape = plane_shape(corner_grid(length, length), [&](int x, int y) { return x < w || y < w; });
    const Burned full = burned(shape, 0);
    const double t = kDiagonalOfSquare - 1, arc = 0.5 * w * (t * std::sqrt(1 + t * t) + std::asinh(t));
    const double meet = w * kDiagonalOfSquare / (1 + kDiagonalOfSquare);
    const double expected = kDiagonalOfSquare * 0.5 * w + (length - 1.5 * w) + arc;
    const std::uint32_t v = nearest_vertex(full.axis, meet, meet);
    EXPECT_NEAR(full.burning.burn_time[v], expected, 2) << w;
    EXPECT_NEAR(full.axis.radius[v], meet, 1) << w;
    EXPECT_NEAR(full.burning.max_burn_time, expected, 2) << w;
  }
}

// The union of pixels whose centres are in a disk of radius R lies in that of radius R + 0.71, and has all of that of
// R - 0.71. What fire does at a point v of the core is bounded by balls inside: of a core that is one piece of a few
// pixels the time is that of its ball, to a pixel.
TEST(PlaneResults, ADiskBurnsWithinAPixel) {
  for (const double radius : {10.0, 20.0, 40.0}) {
    for (const double shift : {0.0, 0.3}) {
      const int side = static_cast<int>(2 * radius) + 4;
      const double c = 0.5 * side + shift;
      const VoxelShape disk = plane_shape(corner_grid(side, side),
                                          [&](int x, int y) { return std::hypot(x + 0.5 - c, y + 0.5 - c) < radius; });
      const Burned core = burned(disk, 2);
      EXPECT_EQ(core.burning.unburned, 0u);
      EXPECT_GT(core.burning.max_burn_time, radius - 1) << radius;
      EXPECT_LT(core.burning.max_burn_time, radius + 1) << radius;
      for (const double thickness : core.burning.erosion_thickness) EXPECT_LT(thickness, 1.5);
    }
  }
}

TEST(PlaneResults, NothingBurnsInAnAnnulus) {
  for (const double radius : {9.0, 18.0, 36.0}) {
    const int side = static_cast<int>(2 * radius) + 4;
    const VoxelShape ring = plane_shape(corner_grid(side, side), [&](int x, int y) {
      const double r = std::hypot(x + 0.5 - 0.5 * side, y + 0.5 - 0.5 * side);
      return r < radius && r >= 0.5 * radius;
    });
    const Burned core = burned(ring, 1.5);
    EXPECT_EQ(core.burning.unburned, core.axis.points.size()) << radius;
    EXPECT_EQ(core.axis.complex.edges.size(), core.axis.points.size());
  }
}

// Three strips of half-width m that meet at equal angles, turned: fire comes to the middle along the two shorter ones.
// Ends and sides are where they are drawn to a pixel, and the middle line of a slanted strip turns by up to half a
// pixel in 2 m, so that it is longer by a share of 1 / (8 m^2): at these sizes three pixels are enough, whatever the
// size, and the error as a share goes to 0.
TEST(PlaneResults, AYBurnsAsTheClosedForm) {
  for (const double size : {1.0, 0.5, 0.25})
    for (const double turned : {10.0, 37.0, 55.0}) {
      const double m = 7, reach = 90;
      const std::array<double, 3> arms{50, 62, 80};
      const auto pixels = static_cast<std::int64_t>(2 * reach / size);
      Grid grid = corner_grid(pixels, pixels, size);
      const VoxelShape letter = plane_shape(grid, [&](int i, int j) {
        const double x = (i + 0.5) * size - reach, y = (j + 0.5) * size - reach;
        for (std::size_t k = 0; k < 3; ++k) {
          const double angle = (turned + 120.0 * static_cast<double>(k)) * std::numbers::pi / 180;
          const double along = x * std::cos(angle) + y * std::sin(angle);
          const double across = y * std::cos(angle) - x * std::sin(angle);
          if (along >= 0 && along < arms[k] && std::abs(across) < m) return true;
        }
        return false;
      });
      const Burned core = burned(letter, auto_detail(grid));
      const std::uint32_t middle = nearest_vertex(core.axis, reach, reach);
      EXPECT_NEAR(core.burning.burn_time[middle], kDiagonalOfSquare * m + arms[1] - m, 3 * size)
          << "pixel " << size << ", turned " << turned;
    }
}

// ------------------------------------------------------------------------------------------------------------- arcs

TEST(PlaneResults, WaysAlongTheBoundaryOfARectangle) {
  for (const auto& [width, height] : {std::pair{30, 8}, {31, 9}, {12, 12}}) {
    const MedialAxis axis = voxel_core(rectangle(width, height));
    const Measure& mgf = axis.measure(kMgf);
    const auto along = [&, w = width, h = height](const LatticePoint& p) {  // from (0, 0) through (w, 0) and (w, h)
      if (p[1] == 0) return p[0];
      if (p[0] == w) return w + p[1];
      return p[1] == h ? w + h + (w - p[0]) : 2 * w + h + (h - p[1]);
    };
    for (std::size_t e = 0; e < axis.edge_sites.size(); ++e) {
      const int way = std::abs(along(axis.sites[axis.edge_sites[e][0]]) - along(axis.sites[axis.edge_sites[e][1]]));
      EXPECT_EQ(mgf.value.edge[e], std::min(way, 2 * (width + height) - way));
    }
  }
}

// Steps of pixels along an arc of a circle are as long as its extents along both axes: 8 R around. Corners are within
// 0.71 of the circle, and so of where their direction from the middle says they are to a pixel along each axis.
TEST(PlaneResults, WaysAlongTheBoundaryOfADisk) {
  const double radius = 25, c = 27;
  const VoxelShape disk =
      plane_shape(corner_grid(54, 54), [&](int x, int y) { return std::hypot(x + 0.5 - c, y + 0.5 - c) < radius; });
  const MedialAxis axis = voxel_core(disk);
  const Measure& mgf = axis.measure(kMgf);
  const auto along = [&](const LatticePoint& p) {
    double angle = std::atan2(p[1] - c, p[0] - c);
    if (angle < 0) angle += 2 * std::numbers::pi;
    const double quarter = std::floor(angle / (0.5 * std::numbers::pi));
    const double rest = angle - quarter * 0.5 * std::numbers::pi;
    return radius * (2 * quarter + std::sin(rest) + 1 - std::cos(rest));
  };
  for (std::size_t e = 0; e < axis.edge_sites.size(); ++e) {
    const double way = std::abs(along(axis.sites[axis.edge_sites[e][0]]) - along(axis.sites[axis.edge_sites[e][1]]));
    EXPECT_NEAR(mgf.value.edge[e], std::min(way, 8 * radius - way), 4);
  }
}

TEST(PlaneResults, WaysBetweenDifferentCurvesAreInfinite) {
  const VoxelShape ring =
      plane_shape(corner_grid(20, 16), [](int x, int y) { return !(x >= 6 && x < 13 && y >= 5 && y < 11); });
  const MedialAxis axis = voxel_core(ring);
  const auto inner = [](const LatticePoint& p) { return p[0] > 0 && p[0] < 20 && p[1] > 0 && p[1] < 16; };
  std::size_t infinite = 0;
  for (std::size_t e = 0; e < axis.edge_sites.size(); ++e) {
    const bool apart = inner(axis.sites[axis.edge_sites[e][0]]) != inner(axis.sites[axis.edge_sites[e][1]]);
    EXPECT_EQ(std::isinf(axis.measure(kMgf).value.edge[e]), apart);
    infinite += apart;
  }
  EXPECT_GT(infinite, 10u);
}

// ------------------------------------------------------------------------------------------------------- symmetries

struct Symmetry {
  bool swap, mirror_x, mirror_y;
  Vec3 of(Vec3 p, const Grid& target) const {  // lattice coordinates
    if (swap) std::swap(p[0], p[1]);
    if (mirror_x) p[0] = static_cast<double>(target.dims[0]) - p[0];
    if (mirror_y) p[1] = static_cast<double>(target.dims[1]) - p[1];
    return p;
  }
};

VoxelShape turned(const VoxelShape& shape, const Symmetry& s) {
  Grid grid = shape.grid();
  if (s.swap) {
    std::swap(grid.dims[0], grid.dims[1]);
    std::swap(grid.spacing[0], grid.spacing[1]);
  }
  return plane_shape(grid, [&](int x, int y) {
    std::int64_t p = s.mirror_x ? grid.dims[0] - 1 - x : x, q = s.mirror_y ? grid.dims[1] - 1 - y : y;
    if (s.swap) std::swap(p, q);
    return shape.contains(p, q, 0);
  });
}

using Row = std::array<std::int64_t, 8>;  // numbers times 10^6
std::int64_t rounded(double x) { return std::isinf(x) ? -7 : std::llround(x * 1e6); }

// Vertices and edges with their measures, in an order of their own; places in lattice coordinates as `place` has them.
template <class Place>
std::multiset<Row> rows_of(const Burned& core, const Place& place) {
  const MedialAxis& axis = core.axis;
  const auto value = [&](std::string_view name, std::size_t i, bool edge) {
    const CellValues& values = axis.measure(name).value;
    return rounded(edge ? values.edge[i] : values.vertex[i]);
  };
  std::multiset<Row> rows;
  const auto at = [&](std::uint32_t v) { return place(axis.grid.lattice(axis.points[v])); };
  const bool has_detail = axis.find_measure(kDetail) != nullptr;
  for (std::uint32_t v = 0; v < axis.points.size(); ++v) {
    const Vec3 p = at(v);
    rows.insert({0, rounded(p[0]), rounded(p[1]), rounded(axis.radius[v]), value(kLambda, v, false),
                 value(kMgf, v, false), rounded(core.burning.burn_time[v]), 0});
  }
  for (std::uint32_t e = 0; e < axis.complex.edges.size(); ++e) {
    Vec3 p = at(axis.complex.edges[e][0]), q = at(axis.complex.edges[e][1]);
    if (std::pair(rounded(p[0]), rounded(p[1])) > std::pair(rounded(q[0]), rounded(q[1]))) std::swap(p, q);
    rows.insert({1, rounded(p[0]), rounded(p[1]), rounded(q[0]), rounded(q[1]), value(kLambda, e, true),
                 value(kMgf, e, true), has_detail ? value(kDetail, e, true) : 0});
  }
  return rows;
}

// A shape without symmetry, whose branches have thicknesses of their own.
VoxelShape creature() {
  return plane_shape(corner_grid(90, 70), [](int x, int y) {
    const auto limb = [&](double ax, double ay, double bx, double by, double r) {
      const double dx = bx - ax, dy = by - ay;
      const double t = std::clamp(((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy), 0.0, 1.0);
      return std::hypot(x - ax - t * dx, y - ay - t * dy) < r;
    };
    return limb(30.1, 30.2, 60.3, 36.7, 11.3) || limb(33, 30, 12.2, 8.1, 4.2) || limb(40, 35, 37.3, 62.4, 5.1) ||
           limb(60, 36, 81.7, 13.3, 3.4) || limb(57, 38, 70.6, 61.2, 6.3);
  });
}

void expect_same_turned(const VoxelShape& shape, bool with_details, const std::string& where) {
  const auto core_of = [&](const VoxelShape& pixels) {
    Burned result = burned(pixels, 0);
    if (with_details) add_detail(result.axis);
    return result;
  };
  const Burned own = core_of(shape);
  for (int s = 0; s < 8; ++s) {
    const Symmetry symmetry{(s & 1) != 0, (s & 2) != 0, (s & 4) != 0};
    const VoxelShape other = turned(shape, symmetry);
    EXPECT_EQ(rows_of(own, [&](const Vec3& p) { return symmetry.of(p, other.grid()); }),
              rows_of(core_of(other), [](const Vec3& p) { return p; }))
        << where << ", symmetry " << s;
  }
}

// What is raised for disks to cover depends on ties, which small shapes are full of: details are compared where there
// are none.
TEST(PlaneResults, EightSymmetriesGiveTheSameCoreAndFire) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const std::array<double, 2> spacing{1, seed % 3 == 0 ? 1.5 : 1};
    expect_same_turned(random_plane_shape(seed, 24, spacing), false, fmt::format("seed {}", seed));
  }
  expect_same_turned(creature(), true, "creature");
}

pipeline::RunResult run_of(const VoxelShape& shape) {
  pipeline::LoadedShape loaded = pipeline::shape_of(VoxelShape(shape), shape.grid(), {});
  return pipeline::run(loaded);
}

TEST(PlaneResults, EightSymmetriesGiveTheSameSkeleton) {
  const VoxelShape shape = creature();
  const pipeline::RunResult own = run_of(shape);
  const auto points = [](const pipeline::RunResult& run, const auto& place) {
    std::multiset<Row> rows;
    const Skeleton& skeleton = run.axis.skeleton.skeleton;
    for (std::size_t v = 0; v < skeleton.points.size(); ++v) {
      const Vec3 p = place(run.core.axis.grid.lattice(skeleton.points[v]));
      // Smoothing adds in another order: what is left is rounding.
      rows.insert({std::llround(p[0] * 1e3), std::llround(p[1] * 1e3), std::llround(skeleton.radius[v] * 1e3)});
    }
    return rows;
  };
  for (int s = 0; s < 8; ++s) {
    const Symmetry symmetry{(s & 1) != 0, (s & 2) != 0, (s & 4) != 0};
    const VoxelShape other = turned(shape, symmetry);
    const pipeline::RunResult result = run_of(other);
    EXPECT_EQ(result.axis.graph.branches.size(), own.axis.graph.branches.size());
    EXPECT_EQ(points(own, [&](const Vec3& p) { return symmetry.of(p, other.grid()); }),
              points(result, [](const Vec3& p) { return p; }))
        << "symmetry " << s;
  }
}

TEST(PlaneResults, MovingAndPaddingChangeNothingElse) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const VoxelShape shape = random_plane_shape(seed, 30);
    Grid grid = shape.grid();
    grid.dims[0] += 5 + static_cast<std::int64_t>(seed % 7);
    grid.dims[1] += 9;
    const int dx = 1 + static_cast<int>(seed % 5), dy = 4;
    const VoxelShape moved = plane_shape(grid, [&](int x, int y) { return shape.contains(x - dx, y - dy, 0); });
    const pipeline::RunResult a = run_of(shape), b = run_of(moved);
    EXPECT_EQ(a.core.axis.complex.edges, b.core.axis.complex.edges);
    EXPECT_EQ(a.core.axis.edge_sites, b.core.axis.edge_sites);
    EXPECT_EQ(a.core.axis.measure(kDetail).level.edge, b.core.axis.measure(kDetail).level.edge);
    const Skeleton &s = a.axis.skeleton.skeleton, &t = b.axis.skeleton.skeleton;
    ASSERT_EQ(s.complex.edges, t.complex.edges) << seed;
    EXPECT_EQ(s.edge_branch, t.edge_branch);
    for (std::size_t v = 0; v < s.points.size(); ++v) {
      EXPECT_NEAR((s.points[v] + Vec3(dx, dy, 0) - t.points[v]).norm(), 0, 1e-9);
      EXPECT_NEAR(s.radius[v], t.radius[v], 1e-9);
      if (!std::isinf(s.curve_burn_time[v])) {
        EXPECT_NEAR(s.curve_burn_time[v], t.curve_burn_time[v], 1e-9);
      }
    }
  }
}

TEST(PlaneResults, ThreadsChangeNothing) {
  // More edges than one chunk of a parallel loop takes.
  const VoxelShape noise = plane_shape(corner_grid(260, 240), [](int x, int y) {
    const auto h = static_cast<std::uint32_t>(x * 73856093) ^ static_cast<std::uint32_t>(y * 19349663);
    return h % 11 != 0 && std::hypot(x - 130, y - 120) < 118;
  });
  const auto run_with = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return run_of(noise);
  };
  const pipeline::RunResult one = run_with(1);
  for (const std::size_t threads : {2, 3, 8}) {
    const pipeline::RunResult more = run_with(threads);
    EXPECT_EQ(one.core.axis.complex.edges, more.core.axis.complex.edges);
    EXPECT_EQ(one.core.axis.points, more.core.axis.points);
    EXPECT_EQ(one.core.axis.radius, more.core.axis.radius);
    for (const std::string_view name : {kLambda, kMgf, kDetail})
      EXPECT_EQ(one.core.axis.measure(name).value.edge, more.core.axis.measure(name).value.edge) << name;
    const auto times = [](const pipeline::RunResult& run) {
      return find_array(run.axis.file.point_data, "burn_time")->numbers();
    };
    EXPECT_EQ(times(one), times(more));
    testing_skeletons::expect_same(one.axis.skeleton.skeleton, more.axis.skeleton.skeleton);
  }
}

// --------------------------------------------------------------------------------------------------------- topology

// Components and holes by filling pixels one by one.
std::array<std::int64_t, 2> filled_topology(const VoxelShape& shape) {
  const auto width = static_cast<int>(shape.grid().dims[0]) + 2, height = static_cast<int>(shape.grid().dims[1]) + 2;
  std::vector<char> pixel(static_cast<std::size_t>(width * height)), seen(pixel.size(), 0);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) pixel[static_cast<std::size_t>(x + width * y)] = shape.contains(x - 1, y - 1, 0);
  std::array<std::int64_t, 2> parts{0, 0};  // of the background, of the foreground
  for (std::size_t first = 0; first < pixel.size(); ++first) {
    if (seen[first]) continue;
    const char kind = pixel[first];
    ++parts[static_cast<std::size_t>(kind)];
    std::vector<std::size_t> fill{first};
    seen[first] = 1;
    while (!fill.empty()) {
      const auto i = static_cast<int>(fill.back());
      fill.pop_back();
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
          const int x = i % width + dx, y = i / width + dy;
          if (x < 0 || y < 0 || x >= width || y >= height || (kind && dx != 0 && dy != 0)) continue;
          const auto next = static_cast<std::size_t>(x + width * y);
          if (seen[next] || pixel[next] != kind) continue;
          seen[next] = 1;
          fill.push_back(next);
        }
    }
  }
  return {parts[1], parts[0] - 1};
}

std::array<std::int64_t, 2> graph_topology(const CellComplex& complex) {
  EXPECT_EQ(complex.face_count(), 0u);
  std::vector<std::uint32_t> part(complex.vertex_count);
  for (std::uint32_t v = 0; v < part.size(); ++v) part[v] = v;
  const auto root = [&](std::uint32_t v) {
    while (part[v] != v) v = part[v] = part[part[v]];
    return v;
  };
  std::int64_t parts = complex.vertex_count;
  for (const auto& [a, b] : complex.edges)
    if (const std::uint32_t p = root(a), q = root(b); p != q) {
      part[p] = q;
      --parts;
    }
  return {parts, static_cast<std::int64_t>(complex.edges.size()) - complex.vertex_count + parts};
}

TEST(PlaneResults, TopologyIsThatOfThePixels) {
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    const VoxelShape shape = random_plane_shape(seed, 22);
    const std::array<std::int64_t, 2> expected = filled_topology(shape);
    MedialAxis axis = voxel_core(shape);
    EXPECT_EQ(graph_topology(axis.complex), expected) << seed;
    add_detail(axis);
    prune_levels(axis, kDetail);
    for (const double detail : {0.7, 1.5, 6.0})
      EXPECT_EQ(graph_topology(pruned(axis, detail, kDetail).complex), expected) << seed << ", detail " << detail;
    const pipeline::RunResult run = run_of(shape);
    EXPECT_EQ(graph_topology(run.core.axis.complex), expected) << seed;
    EXPECT_EQ(graph_topology(run.axis.skeleton.skeleton.complex), expected) << seed;
    const Topology t = topology(shape);
    EXPECT_EQ((std::array{t.betti[0], t.betti[1]}), expected);
    EXPECT_EQ(t.betti[2], 0);
    EXPECT_EQ(t.euler, expected[0] - expected[1]);
  }
}

// --------------------------------------------------------------------------------------------------------- coverage

TEST(PlaneResults, DisksCoverTheOutlineAsPromised) {
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    const VoxelShape shape = random_plane_shape(seed, 36, seed % 4 == 0 ? std::array{1.0, 1.5} : std::array{1.0, 1.0});
    const double diagonal = std::hypot(shape.grid().spacing[0], shape.grid().spacing[1]);
    EXPECT_NEAR(auto_detail(shape.grid()), 0.5 * diagonal, 1e-15);
    MedialAxis axis = voxel_core(shape);
    const std::vector<LatticePoint> sites = axis.sites;
    add_detail(axis);
    prune_levels(axis, kDetail);
    for (const double detail : {0.5 * diagonal, diagonal, 1.7, 2.5, 5.0}) {
      const MedialAxis kept = pruned(axis, detail, kDetail);
      double farthest = 0;
      for (const LatticePoint& site : sites) {
        double away = std::numeric_limits<double>::infinity();
        for (std::size_t v = 0; v < kept.points.size(); ++v)
          away = std::min(away, (shape.grid().world_of(site) - kept.points[v]).norm() - kept.radius[v]);
        farthest = std::max(farthest, away);
      }
      EXPECT_LE(farthest, std::max(2 * detail, diagonal) * (1 + 1e-9)) << "seed " << seed << ", detail " << detail;
      EXPECT_NEAR(coverage(shape, kept), std::max(farthest, 0.0), 1e-9);
    }
  }
}

}  // namespace plane_results_test
}  // namespace quench
