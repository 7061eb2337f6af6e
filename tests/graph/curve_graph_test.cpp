// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <tuple>

#include "hand_built_skeletons.h"
#include "quench/graph.h"
#include "quench/shape.h"

namespace quench {
namespace curve_graph_test {

using testing_skeletons::Cells;
using testing_skeletons::random_cells;
using testing_skeletons::skeleton_of;
using Kind = CurveGraph::NodeKind;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::vector<Kind> kinds(const CurveGraph& graph) {
  std::vector<Kind> result;
  for (const auto& node : graph.nodes) result.push_back(node.kind);
  return result;
}

// 1 -- 0 -- 2 -- 3, and 0 -- 4
TEST(CurveGraph, Y) {
  Cells cells;
  cells.add(0, 0, 0, 4);
  cells.add(-3, 0, 0, 1);
  cells.add(2, 0, 0, 3);
  cells.add(2, 4, 0, 1);
  cells.add(0, 0, 5, 2);
  cells.path({1, 0, 2, 3});
  cells.path({0, 4});
  Skeleton skeleton = skeleton_of(cells);
  skeleton.edge_thickness = {0.5, 7, 1, 2};  // edges by their ends: 01 02 04 23
  const CurveGraph graph = curve_graph(skeleton);
  EXPECT_EQ(kinds(graph), (std::vector{Kind::junction, Kind::end, Kind::end, Kind::end}));
  EXPECT_EQ(graph.nodes[0].degree, 3u);
  EXPECT_EQ(graph.nodes[0].sheet, kNone);
  EXPECT_EQ(graph.nodes[2].point, Vec3(2, 4, 0));
  ASSERT_EQ(graph.branches.size(), 3u);
  EXPECT_EQ(graph.components, 1u);
  EXPECT_TRUE(graph.sheet_only.empty());
  const CurveGraph::Branch& bent = graph.branches[1];
  EXPECT_EQ(bent.from, 0u);
  EXPECT_EQ(bent.to, 2u);
  EXPECT_EQ(bent.points, (std::vector<Vec3>{{0, 0, 0}, {2, 0, 0}, {2, 4, 0}}));
  EXPECT_EQ(bent.radius, (std::vector<double>{4, 3, 1}));
  EXPECT_DOUBLE_EQ(bent.length, 6);
  EXPECT_DOUBLE_EQ(bent.mean_radius, (2 * 3.5 + 4 * 2) / 6);  // by length, not by point
  EXPECT_EQ(bent.min_radius, 1);
  EXPECT_EQ(bent.max_radius, 4);
  EXPECT_EQ(bent.thickness, 7);
  EXPECT_DOUBLE_EQ(bent.tortuosity, 6 / std::sqrt(20.0));
  EXPECT_EQ(graph.branches[0].tortuosity, 1);
}

TEST(CurveGraph, AClosedCurveGetsItsThickestVertexAsNode) {
  Cells cells;
  for (double r : {1, 2, 3, 1}) cells.add(r, 1 / r, cells.points.size() % 2 ? 1.0 : 0.0, r);
  cells.path({0, 1, 2, 3, 0});
  Skeleton skeleton = skeleton_of(cells);
  skeleton.edge_thickness.assign(4, kInfinity);
  const CurveGraph graph = curve_graph(skeleton);
  ASSERT_EQ(kinds(graph), std::vector{Kind::loop});
  EXPECT_EQ(graph.nodes[0].radius, 3);
  EXPECT_EQ(graph.nodes[0].degree, 2u);
  ASSERT_EQ(graph.branches.size(), 1u);
  EXPECT_EQ(graph.branches[0].points.size(), 5u);
  EXPECT_EQ(graph.branches[0].points.front(), graph.branches[0].points.back());
  EXPECT_EQ(graph.branches[0].tortuosity, kInfinity);
  EXPECT_EQ(graph.branches[0].thickness, kInfinity);
}

TEST(CurveGraph, Theta) {
  Cells cells;
  for (double x : {0, 4}) cells.add(x, 0, 0);
  for (double y : {-1, 0, 1}) cells.add(2, y, 0);
  for (std::uint32_t middle : {2u, 3u, 4u}) cells.path({0, middle, 1});
  const CurveGraph graph = curve_graph(skeleton_of(cells));
  EXPECT_EQ(kinds(graph), (std::vector{Kind::junction, Kind::junction}));
  ASSERT_EQ(graph.branches.size(), 3u);
  for (std::uint32_t b = 0; b < 3; ++b) EXPECT_EQ(graph.branches[b].points[1][1], b - 1.0);
}

TEST(CurveGraph, ComponentsIsolatedVerticesAndSheetsWithoutCurves) {
  Cells cells;
  cells.add(9, 9, 9, 2);  // component 0: isolated
  cells.square(0, 0, 0);  // 1: only a sheet
  const std::uint32_t a = cells.add(0, 0, 5), b = cells.add(1, 0, 5);
  cells.path({a, b});  // 2: a curve
  const CurveGraph graph = curve_graph(skeleton_of(cells));
  EXPECT_EQ(graph.components, 3u);
  EXPECT_EQ(graph.sheets, 1u);
  EXPECT_EQ(graph.sheet_only, std::vector<std::uint32_t>{1});
  EXPECT_EQ(kinds(graph), (std::vector{Kind::isolated, Kind::end, Kind::end}));
  EXPECT_EQ(graph.nodes[0].component, 0u);
  EXPECT_EQ(graph.nodes[0].degree, 0u);
  EXPECT_EQ(graph.nodes[1].component, 2u);
  EXPECT_EQ(graph.branches.at(0).component, 2u);
  EXPECT_TRUE(curve_graph(Skeleton{}).nodes.empty());
}

TEST(CurveGraph, HairsOnASheetAndALoneEdgeBetweenSheets) {
  Cells cells;
  const std::uint32_t low = cells.square(0, 0, 0), high = cells.square(0, 0, 3);
  const std::uint32_t hair = cells.add(5, 5, 0);
  cells.path({low, high});
  cells.path({low + 2, hair});
  const CurveGraph graph = curve_graph(skeleton_of(cells));
  EXPECT_EQ(kinds(graph), (std::vector{Kind::sheet, Kind::sheet, Kind::sheet, Kind::end}));
  EXPECT_EQ(graph.nodes[0].sheet, 0u);
  EXPECT_EQ(graph.nodes[1].sheet, 0u);
  EXPECT_EQ(graph.nodes[2].sheet, 1u);
  EXPECT_EQ(graph.sheets, 2u);
  EXPECT_EQ(graph.components, 1u);
  ASSERT_EQ(graph.branches.size(), 2u);
  EXPECT_EQ(graph.branches[0].length, 3);
}

TEST(CurveGraph, ACurveThatPassesThroughASheetHasANodeThere) {
  Cells cells;
  const std::uint32_t corner = cells.square(0, 0, 0), up = cells.add(-1, -1, 2), down = cells.add(-1, -1, -2);
  cells.path({down, corner, up});
  const CurveGraph graph = curve_graph(skeleton_of(cells));
  EXPECT_EQ(kinds(graph), (std::vector{Kind::sheet, Kind::end, Kind::end}));
  EXPECT_EQ(graph.branches.size(), 2u);
  Cells closed;
  const std::uint32_t c = closed.square(0, 0, 0), l = closed.add(-3, 0, 0), m = closed.add(-3, -3, 0);
  closed.path({c, l, m, c});
  const CurveGraph ring = curve_graph(skeleton_of(closed));
  EXPECT_EQ(kinds(ring), std::vector{Kind::sheet});
  ASSERT_EQ(ring.branches.size(), 1u);
  EXPECT_EQ(ring.branches[0].from, ring.branches[0].to);
}

using Coordinates = std::array<double, 3>;
Coordinates of(const Vec3& p) { return {p[0], p[1], p[2]}; }

TEST(CurveGraph, EveryCurveEdgeIsInOneBranchOnce) {
  std::map<Kind, int> met;
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    const Skeleton skeleton = skeleton_of(random_cells(seed));
    const CurveGraph graph = curve_graph(skeleton);
    std::multiset<std::array<Coordinates, 2>> wanted, found;
    std::map<Coordinates, int> degree;
    std::set<Coordinates> on_sheet, nodes;
    for (std::uint32_t v : skeleton.complex.face_vertices) on_sheet.insert(of(skeleton.points[v]));
    const auto add = [](auto& set, const Vec3& a, const Vec3& b) {
      set.insert({std::min(of(a), of(b)), std::max(of(a), of(b))});
    };
    double length = 0;
    for (std::size_t e = 0; e < skeleton.complex.edges.size(); ++e) {
      if (std::isnan(skeleton.edge_thickness[e])) continue;
      const auto [u, v] = skeleton.complex.edges[e];
      add(wanted, skeleton.points[u], skeleton.points[v]);
      for (std::uint32_t end : {u, v}) ++degree[of(skeleton.points[end])];
      length += (skeleton.points[u] - skeleton.points[v]).norm();
    }
    for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
      const CurveGraph::Node& node = graph.nodes[n];
      nodes.insert(of(node.point));
      ++met[node.kind];
      ASSERT_EQ(node.sheet != kNone, on_sheet.contains(of(node.point)));
      ASSERT_EQ(node.kind == Kind::sheet, on_sheet.contains(of(node.point)));
      ASSERT_EQ(static_cast<int>(node.degree), degree[of(node.point)]);
      if (node.kind == Kind::end) {
        ASSERT_EQ(node.degree, 1u);
      }
      if (node.kind == Kind::junction) {
        ASSERT_GE(node.degree, 3u);
      }
    }
    ASSERT_EQ(nodes.size(), graph.nodes.size());
    for (const CurveGraph::Branch& branch : graph.branches) {
      ASSERT_LE(branch.from, branch.to);
      ASSERT_EQ(branch.points.front(), graph.nodes[branch.from].point);
      ASSERT_EQ(branch.points.back(), graph.nodes[branch.to].point);
      ASSERT_EQ(branch.component, graph.nodes[branch.from].component);
      for (std::size_t i = 1; i < branch.points.size(); ++i) add(found, branch.points[i - 1], branch.points[i]);
      for (std::size_t i = 1; i + 1 < branch.points.size(); ++i) {
        ASSERT_EQ(degree[of(branch.points[i])], 2);
        ASSERT_FALSE(on_sheet.contains(of(branch.points[i])) || nodes.contains(of(branch.points[i])));
      }
      ASSERT_LE(branch.min_radius, branch.mean_radius);
      ASSERT_LE(branch.mean_radius, branch.max_radius);
      ASSERT_GE(branch.tortuosity, 1);
      length -= branch.length;
    }
    ASSERT_EQ(found, wanted) << "seed " << seed;
    ASSERT_NEAR(length, 0, 1e-9);
    ASSERT_EQ(graph.components, topology(skeleton.complex).betti[0]);
  }
  for (Kind kind : {Kind::end, Kind::junction, Kind::sheet, Kind::loop, Kind::isolated}) EXPECT_GT(met[kind], 30);
}

// Whatever the numbers of vertices: a branch from its smaller end, with all that is measured on it.
using Course = std::tuple<std::vector<Coordinates>, double, double, double>;
std::vector<Course> courses(const CurveGraph& graph) {
  std::vector<Course> result;
  for (const CurveGraph::Branch& branch : graph.branches) {
    std::vector<Coordinates> there;
    for (const Vec3& p : branch.points) there.push_back(of(p));
    std::vector<Coordinates> back(there.rbegin(), there.rend());
    result.emplace_back(std::min(there, back), branch.min_radius, branch.max_radius, branch.thickness);
  }
  std::sort(result.begin(), result.end());
  return result;
}

TEST(CurveGraph, DoesNotDependOnTheOrderOfCells) {
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    const Cells cells = random_cells(seed);
    std::mt19937_64 random(seed);
    std::vector<std::uint32_t> place(cells.points.size());
    std::iota(place.begin(), place.end(), 0u);
    std::shuffle(place.begin(), place.end(), random);
    Cells other = cells;
    for (std::size_t v = 0; v < place.size(); ++v) {
      other.points[place[v]] = cells.points[v];
      other.radius[place[v]] = cells.radius[v];
    }
    for (auto& edge : other.edges) edge = {place[edge[1]], place[edge[0]]};
    for (auto& face : other.faces)
      for (std::uint32_t& v : face) v = place[v];
    std::shuffle(other.edges.begin(), other.edges.end(), random);
    std::shuffle(other.faces.begin(), other.faces.end(), random);
    const CurveGraph one = curve_graph(skeleton_of(cells)), two = curve_graph(skeleton_of(other));
    ASSERT_EQ(courses(one).size(), courses(two).size()) << "seed " << seed;
    for (std::size_t i = 0; i < courses(one).size(); ++i) {
      ASSERT_EQ(std::get<0>(courses(one)[i]), std::get<0>(courses(two)[i])) << "seed " << seed;
      ASSERT_NEAR(std::get<3>(courses(one)[i]), std::get<3>(courses(two)[i]), 1e-12);
    }
    const auto described = [](const CurveGraph& graph) {
      std::vector<std::tuple<Coordinates, Kind, std::uint32_t>> nodes;
      for (const auto& node : graph.nodes) nodes.emplace_back(of(node.point), node.kind, node.degree);
      std::sort(nodes.begin(), nodes.end());
      return nodes;
    };
    ASSERT_EQ(described(one), described(two)) << "seed " << seed;
    ASSERT_EQ(one.sheets, two.sheets);
    ASSERT_EQ(one.components, two.components);
    ASSERT_EQ(one.sheet_only.size(), two.sheet_only.size());
  }
}

// Drawn anew with its own branches a skeleton is the same up to its numbers; smoothed and resampled it has the same
// topology and the same branches.
TEST(WithBranches, KeepsSheetsNodesAndTopology) {
  for (std::uint64_t seed = 0; seed < 2000 && !testing::Test::HasFailure(); ++seed) {
    SCOPED_TRACE(seed);
    const Skeleton skeleton = skeleton_of(random_cells(seed));
    const CurveGraph graph = curve_graph(skeleton);
    for (const SmoothOptions& options : {SmoothOptions{}, {5, 0, 0, {}}, {5, 0.3, 0, {}}, {0, 5, 0, {}}}) {
      const CurveGraph drawn = smoothed(graph, options);
      const Skeleton result = with_branches(skeleton, drawn);
      ASSERT_NO_THROW(result.complex.validate());
      ASSERT_EQ(topology(result.complex), topology(skeleton.complex));
      ASSERT_EQ(result.complex.face_count(), skeleton.complex.face_count());
      std::vector<double> length(graph.branches.size(), 0);
      for (std::size_t e = 0; e < result.edge_branch.size(); ++e) {
        const auto [a, b] = result.complex.edges[e];
        if (result.edge_branch[e] >= 0)
          length[static_cast<std::size_t>(result.edge_branch[e])] += (result.points[a] - result.points[b]).norm();
      }
      const CurveGraph again = curve_graph(result);
      ASSERT_EQ(again.nodes.size(), graph.nodes.size());
      ASSERT_EQ(again.branches.size(), graph.branches.size());
      for (std::size_t b = 0; b < length.size(); ++b) ASSERT_NEAR(length[b], drawn.branches[b].length, 1e-9);
      const Record record = to_record(result);
      ASSERT_NO_THROW(record.validate());
      ASSERT_EQ(record.lines.size() + record.poly_count() + record.verts.size(), record.cell_count());
      // The lines of a branch follow each other.
      const auto& branch = std::get<std::vector<std::int32_t>>(find_array(record.cell_data, "branch")->values);
      for (std::size_t l = 1; l < record.lines.size(); ++l)
        if (const std::size_t row = record.verts.size() + l; branch[row] == branch[row - 1]) {
          ASSERT_EQ(record.lines[l][0], record.lines[l - 1][1]);
        }
    }
  }
}

}  // namespace curve_graph_test
}  // namespace quench
