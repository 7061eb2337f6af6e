// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "graph/segment_contacts.h"
#include "hand_built_skeletons.h"
#include "quench/axis.h"
#include "quench/error.h"
#include "quench/graph.h"
#include "random_shapes.h"

namespace quench {
namespace curve_graph_smoothing_test {

using testing_skeletons::Cells;
using testing_skeletons::skeleton_of;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Least distance of two segments by bisection of both parameters: the distance is convex in them.
double brute_distance(const graph::NamedSegment& s, const graph::NamedSegment& t) {
  const auto distance = [&](double a, double b) { return ((1 - a) * s.a + a * s.b - (1 - b) * t.a - b * t.b).norm(); };
  const auto search = [](const auto& f) {
    double low = 0, high = 1;
    for (int i = 0; i < 100; ++i) {
      const double a = low + (high - low) / 3, b = high - (high - low) / 3;
      (f(a) < f(b) ? high : low) = f(a) < f(b) ? b : a;
    }
    return f((low + high) / 2);
  };
  return search([&](double a) { return search([&](double b) { return distance(a, b); }); });
}

TEST(SegmentContacts, DistancesEqualThoseBySearch) {
  std::mt19937_64 random(3);
  const auto coordinate = [&] { return static_cast<double>(random() % 7); };  // parallel, touching, degenerate ones
  for (int i = 0; i < 400; ++i) {
    const auto point = [&] { return Vec3(coordinate(), coordinate(), i % 2 ? coordinate() : 0.0); };
    const graph::NamedSegment s{point(), point(), {0, 1}}, t{point(), point(), {2, 3}};
    ASSERT_NEAR(graph::segment_distance(s.a, s.b, t.a, t.b), brute_distance(s, t), 1e-6) << i;
  }
}

TEST(SegmentContacts, TheGridFindsAllPairs) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    std::mt19937_64 random(seed);
    const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
    std::vector<graph::NamedSegment> segments;
    std::vector<Vec3> points;
    for (int i = 0; i < 40; ++i) {
      const Vec3 corner(10 * unit(), 10 * unit(), seed % 2 ? unit() : 0.0);
      points.push_back(seed % 3 ? Vec3(corner) : Vec3(corner.array().round()));
    }
    for (int i = 0; i < 60; ++i) {
      const std::uint64_t a = random() % points.size(), b = random() % points.size();
      if (a != b) segments.push_back({points[a], points[b], {a, b}});
    }
    const double tolerance = seed % 4 == 0 ? 0 : 1e-9;
    std::set<std::pair<std::uint32_t, std::uint32_t>> wanted, found;
    for (std::uint32_t i = 0; i < segments.size(); ++i)
      for (std::uint32_t j = i + 1; j < segments.size(); ++j)
        if (graph::in_contact(segments[i], segments[j], tolerance)) wanted.insert({i, j});
    graph::for_each_contact(
        segments, tolerance, [](auto, auto) { return true; },
        [&](auto i, auto j) {
          found.insert({i, j});
        });
    ASSERT_EQ(found, wanted) << "seed " << seed;
  }
}

TEST(SegmentContacts, AtACommonEndOnlyOverlapsCount) {
  const auto contact = [](const Vec3& a, const Vec3& b) {
    return graph::in_contact({{0, 0, 0}, a, {0, 1}}, {b, {0, 0, 0}, {2, 0}}, 1e-12);
  };
  EXPECT_FALSE(contact({1, 0, 0}, {0, 1, 0}));
  EXPECT_FALSE(contact({1, 0, 0}, {-1, 0, 0}));
  EXPECT_TRUE(contact({1, 0, 0}, {2, 0, 0}));
  EXPECT_TRUE(contact({3, 0, 0}, {2, 0, 0}));
  EXPECT_TRUE(graph::in_contact({{0, 0, 0}, {1, 0, 0}, {0, 1}}, {{1, 0, 0}, {0, 0, 0}, {1, 0}}, 0));
}

/// Pairs of segments in contact, all against all.
std::size_t contacts(const CurveGraph& graph) {
  std::vector<graph::NamedSegment> segments;
  std::uint64_t name = graph.nodes.size();
  for (const auto& branch : graph.branches)
    for (std::size_t i = 1; i < branch.points.size(); ++i) {
      const std::uint64_t first = i == 1 ? branch.from : name - 1,
                          last = i + 1 == branch.points.size() ? branch.to : name++;
      segments.push_back({branch.points[i - 1], branch.points[i], {first, last}});
    }
  std::size_t count = 0;
  for (std::size_t i = 0; i < segments.size(); ++i)
    for (std::size_t j = i + 1; j < segments.size(); ++j) count += graph::in_contact(segments[i], segments[j], 0);
  return count;
}

void expect_same_graph(const CurveGraph& old, const CurveGraph& now) {
  ASSERT_EQ(now.nodes.size(), old.nodes.size());
  for (std::size_t n = 0; n < now.nodes.size(); ++n) {
    ASSERT_EQ(now.nodes[n].point, old.nodes[n].point);
    ASSERT_EQ(now.nodes[n].radius, old.nodes[n].radius);
    ASSERT_EQ(now.nodes[n].kind, old.nodes[n].kind);
  }
  ASSERT_EQ(now.branches.size(), old.branches.size());
  for (std::size_t b = 0; b < now.branches.size(); ++b) {
    const CurveGraph::Branch &was = old.branches[b], &is = now.branches[b];
    ASSERT_EQ(is.from, was.from);
    ASSERT_EQ(is.to, was.to);
    ASSERT_EQ(is.points.front(), was.points.front());
    ASSERT_EQ(is.points.back(), was.points.back());
    ASSERT_EQ(is.radius.front(), was.radius.front());
    ASSERT_EQ(is.radius.back(), was.radius.back());
    ASSERT_EQ(is.points.size(), is.radius.size());
    ASSERT_EQ(is.thickness, was.thickness);
    double length = 0;
    for (std::size_t i = 1; i < is.points.size(); ++i) length += (is.points[i] - is.points[i - 1]).norm();
    ASSERT_NEAR(is.length, length, 1e-12 * (1 + length));
    ASSERT_LE(is.length, was.length * (1 + 1e-9));
  }
}

/// The curves (and sheets) of the voxel core pruned at lambda.
CurveGraph graph_of_core(const VoxelShape& shape, double lambda) {
  MedialAxis axis = voxel_core(shape, {});
  prune_levels(axis);
  axis = pruned(axis, lambda);
  Skeleton skeleton;
  skeleton.complex = axis.complex;
  skeleton.points = axis.points;
  skeleton.radius = axis.radius;
  skeleton.edge_thickness.assign(axis.complex.edges.size(), 1);
  return curve_graph(skeleton);
}

/// In the open interior of the union of the voxels: all voxels that have the point are foreground.
bool is_inside(const VoxelShape& shape, const Vec3& world) {
  const Vec3 x = shape.grid().lattice(world);
  std::array<std::vector<std::int64_t>, 3> voxels;
  for (int a = 0; a < 3; ++a) {
    const double low = std::floor(x[a] - 1e-11), high = std::floor(x[a] + 1e-11);
    voxels[a] = {static_cast<std::int64_t>(low), static_cast<std::int64_t>(high)};
  }
  for (std::int64_t i : voxels[0])
    for (std::int64_t j : voxels[1])
      for (std::int64_t k : voxels[2])
        if (!shape.contains(i, j, k)) return false;
  return true;
}

/// Thick closed polygons, at random.
VoxelShape random_rings(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  Grid grid;
  grid.dims = {26, 24, 22};
  if (seed % 2) grid.spacing = {1, 1, 1.5};
  std::vector<std::array<Vec3, 2>> sticks;
  for (int ring = 0; ring < 2; ++ring) {
    std::vector<Vec3> corners;
    for (int i = 0; i < 3 + static_cast<int>(seed % 3); ++i)
      corners.push_back({4 + 17 * unit(), 4 + 15 * unit(), 4 + 13 * unit()});
    for (std::size_t i = 0; i < corners.size(); ++i) sticks.push_back({corners[i], corners[(i + 1) % corners.size()]});
  }
  const double thick = 1.5 + unit();
  return testing_shapes::from_predicate(grid, [&](int x, int y, int z) {
    const Vec3 p(x + 0.5, y + 0.5, z + 0.5);
    return std::any_of(sticks.begin(), sticks.end(),
                       [&](const auto& stick) { return graph::segment_distance(p, p, stick[0], stick[1]) < thick; });
  });
}

TEST(Smoothing, StaysInTheShapeWithRadiiThatAreNeverTooLarge) {
  const double lambdas[] = {0.6, 0.9, 1.2, kInfinity, 1.5};
  std::size_t moved = 0, resampled = 0, straighter = 0;
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    const VoxelShape shape = seed % 7 == 0 ? random_rings(seed) : testing_shapes::random_shape(seed, 11, seed % 3 == 0);
    const CurveGraph graph = graph_of_core(shape, lambdas[seed % 5]);
    SmoothOptions options;
    options.iterations = static_cast<int>(seed % 4) * 7;
    options.spacing = seed % 2 ? 0.3 * static_cast<double>(seed % 7) : 0;
    options.gap = boundary_gap(shape.grid().spacing);
    const CurveGraph now = smoothed(graph, options);
    expect_same_graph(graph, now);
    ASSERT_EQ(contacts(now), 0u) << "seed " << seed;
    std::vector<Vec3> sites;
    for (const LatticePoint& p : boundary_vertices(shape)) sites.push_back(shape.grid().world(Vec3(p[0], p[1], p[2])));
    for (std::size_t b = 0; b < now.branches.size(); ++b) {
      const CurveGraph::Branch &branch = now.branches[b], &old = graph.branches[b];
      for (std::size_t i = 1; i < branch.points.size(); ++i)
        for (int k = 0; k <= 8; ++k) {
          const Vec3 x = branch.points[i - 1] + (branch.points[i] - branch.points[i - 1]) * (k / 8.0);
          ASSERT_TRUE(is_inside(shape, x)) << "seed " << seed << " branch " << b << " segment " << i;
        }
      for (std::size_t i = 0; i < branch.points.size(); ++i) {
        double nearest = kInfinity;
        for (const Vec3& site : sites) nearest = std::min(nearest, (site - branch.points[i]).norm());
        ASSERT_LE(branch.radius[i], nearest * (1 + 1e-9)) << "seed " << seed;
        ASSERT_GT(branch.radius[i], 0.3 * nearest) << "seed " << seed;
      }
      if (options.spacing == 0 && branch.points.size() == old.points.size())
        for (std::size_t i = 0; i < branch.points.size(); ++i) {
          ASSERT_LE((branch.points[i] - old.points[i]).norm(), old.radius[i] / 2);
          moved += branch.points[i] != old.points[i];
        }
      if (options.spacing > 0) resampled += branch.points != old.points;
      straighter += branch.length < old.length * (1 - 1e-9);
    }
  }
  EXPECT_GT(moved, 300u);
  EXPECT_GT(resampled, 200u);
  EXPECT_GT(straighter, 100u);
}

// The staircase of a voxel tube makes its axis longer than it is; smoothing takes that away.
TEST(Smoothing, BringsTheAxisOfAVoxelTubeNearerToTheTruth) {
  Grid grid;
  grid.dims = {64, 64, 20};
  grid.spacing = {0.5, 0.5, 1};
  // A wavy ring.
  std::vector<Vec3> course;
  double true_length = 0;
  for (int i = 0; i <= 628; ++i) {
    const double a = i * std::numbers::pi / 314;
    course.push_back({16 + 10 * std::cos(a), 16 + 10 * std::sin(a), 10 + 4 * std::sin(2 * a)});
    if (i > 0) true_length += (course[course.size() - 1] - course[course.size() - 2]).norm();
  }
  const VoxelShape shape = testing_shapes::from_predicate(grid, [&](int x, int y, int z) {
    const Vec3 p = grid.world({x + 0.5, y + 0.5, z + 0.5});
    return std::any_of(course.begin(), course.end(), [&](const Vec3& q) { return (p - q).norm() < 2.6; });
  });
  const CurveGraph graph = graph_of_core(shape, kInfinity);
  const auto length = [](const CurveGraph& g) {
    double sum = 0;
    for (const auto& branch : g.branches) sum += branch.length;
    return sum;
  };
  EXPECT_GT(length(graph), 1.1 * true_length);
  for (double spacing : {0.0, 1.0}) {
    const CurveGraph now = smoothed(graph, {.iterations = 5, .spacing = spacing, .gap = boundary_gap(grid.spacing)});
    EXPECT_NEAR(length(now), true_length, 0.01 * true_length);
    for (const auto& branch : now.branches) EXPECT_GT(branch.mean_radius, 0.97 * graph.branches[0].mean_radius);
  }
}

TEST(Smoothing, ResamplesEvenly) {
  Cells cells;
  std::vector<std::uint32_t> vertices;
  for (int i = 0; i <= 400; ++i) {
    const double a = 0.01 * i + 0.004 * ((i * 7) % 3);
    vertices.push_back(cells.add(10 * std::cos(a), 10 * std::sin(a), a, 3 + std::sin(a)));
  }
  cells.path(vertices);
  const CurveGraph graph = curve_graph(skeleton_of(cells));
  const CurveGraph now = smoothed(graph, {.iterations = 0, .spacing = 0.5, .gap = 0});
  const CurveGraph::Branch& branch = now.branches.at(0);
  ASSERT_NEAR(static_cast<double>(branch.points.size() - 1), graph.branches[0].length / 0.5, 1);
  for (std::size_t i = 1; i < branch.points.size(); ++i)
    EXPECT_NEAR((branch.points[i] - branch.points[i - 1]).norm(), 0.5, 0.01);
  EXPECT_NEAR(branch.length, graph.branches[0].length, 0.02);
  EXPECT_NEAR(branch.mean_radius, graph.branches[0].mean_radius, 0.01);
}

TEST(Smoothing, TakesTheZigzagOutOfACurve) {
  Cells cells;
  std::vector<std::uint32_t> vertices;
  for (int i = 0; i <= 60; ++i) vertices.push_back(cells.add(i, i % 2 ? 0.4 : -0.4, 0, 8));
  cells.path(vertices);
  const CurveGraph graph = curve_graph(skeleton_of(cells));
  const CurveGraph now = smoothed(graph, {.iterations = 20, .spacing = 0, .gap = 0});
  EXPECT_GT(graph.branches[0].tortuosity, 1.2);
  EXPECT_LT(now.branches.at(0).tortuosity, 1.01);
  EXPECT_GT(now.branches[0].min_radius, 7);
}

// Curves wound about each other in one wide space: smoothing alone would pull them through each other.
TEST(Smoothing, BranchesNeverTouch) {
  std::size_t as_they_were = 0, changed = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    std::mt19937_64 random(seed);
    const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
    Cells cells;
    const std::uint32_t hub = cells.add(0, 0, 0, 20);
    const int strands = 2 + static_cast<int>(seed % 4);
    for (int s = 0; s < strands; ++s) {
      std::vector<std::uint32_t> vertices;
      if (seed % 2) vertices.push_back(hub);
      for (int i = 1; i < 25; ++i) vertices.push_back(cells.add(i, unit() * 2 - 1, unit() * 2 - 1, 20));
      cells.path(vertices);
    }
    const CurveGraph graph = curve_graph(skeleton_of(cells));
    ASSERT_EQ(contacts(graph), 0u);
    const CurveGraph now = smoothed(graph, {.iterations = 30, .spacing = seed % 3 ? 4.0 : 0.0, .gap = 0});
    expect_same_graph(graph, now);
    ASSERT_EQ(contacts(now), 0u) << "seed " << seed;
    for (std::size_t b = 0; b < graph.branches.size(); ++b)
      (now.branches[b].points == graph.branches[b].points ? as_they_were : changed) += 1;
  }
  EXPECT_GT(changed, 300u);
}

// Two branches with the same ends and a closed one: few points would make them one line.
TEST(Smoothing, ParallelAndClosedBranchesStayApart) {
  Cells cells;
  const std::uint32_t a = cells.add(0, 0, 0, 9), b = cells.add(8, 0, 0, 9);
  std::vector<std::uint32_t> up{a}, down{a}, ring{a};
  for (int i = 1; i < 8; ++i) {
    up.push_back(cells.add(i, 1 + 0.1 * i, 0, 9));
    down.push_back(cells.add(i, -1 - 0.1 * i, 0, 9));
    ring.push_back(cells.add(-2 + 2 * std::cos(i * 0.785), 2 * std::sin(i * 0.785), 0, 9));
  }
  up.push_back(b);
  down.push_back(b);
  ring.push_back(a);
  cells.path(up);
  cells.path(down);
  cells.path(ring);
  const CurveGraph graph = curve_graph(skeleton_of(cells));
  for (double spacing : {0.5, 3.0, 100.0}) {
    const CurveGraph now = smoothed(graph, {.iterations = 3, .spacing = spacing, .gap = 0});
    expect_same_graph(graph, now);
    EXPECT_EQ(contacts(now), 0u) << spacing;
    for (const auto& branch : now.branches)
      if (branch.from == branch.to) {
        EXPECT_GE(branch.points.size(), 4u);
      }
  }
}

TEST(Smoothing, NothingAskedNothingChangedAndNonsenseRefused) {
  const CurveGraph graph = curve_graph(skeleton_of(testing_skeletons::random_cells(4)));
  const CurveGraph same = smoothed(graph, {});
  for (std::size_t b = 0; b < graph.branches.size(); ++b) EXPECT_EQ(same.branches[b].points, graph.branches[b].points);
  EXPECT_THROW(smoothed(graph, {.iterations = -1, .spacing = 0, .gap = 0}), Error);
  EXPECT_THROW(smoothed(graph, {.iterations = 1, .spacing = kInfinity, .gap = 0}), Error);
  EXPECT_THROW(smoothed(graph, {.iterations = 1, .spacing = -1, .gap = 0}), Error);
  EXPECT_THROW(smoothed(graph, {.iterations = 1, .spacing = 0, .gap = NAN}), Error);
}

TEST(Smoothing, IsDeterministic) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const CurveGraph graph = curve_graph(skeleton_of(testing_skeletons::random_cells(seed)));
    const SmoothOptions options{.iterations = 5, .spacing = 0.7, .gap = 0.1};
    const CurveGraph one = smoothed(graph, options), two = smoothed(graph, options);
    for (std::size_t b = 0; b < one.branches.size(); ++b) {
      ASSERT_EQ(one.branches[b].points, two.branches[b].points);
      ASSERT_EQ(one.branches[b].radius, two.branches[b].radius);
    }
  }
}

}  // namespace curve_graph_smoothing_test
}  // namespace quench
