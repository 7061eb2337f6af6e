// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <queue>
#include <vector>

#include "quench/tree.h"
#include "tube_graphs.h"

namespace quench {
namespace repair_test {

using testing_tubes::graph_of;
using testing_tubes::Tube;
using Kind = TreeEdit::Kind;

std::vector<Kind> kinds(const Repaired& repaired) {
  std::vector<Kind> result;
  for (const TreeEdit& edit : repaired.edits) result.push_back(edit.kind);
  std::ranges::sort(result);
  return result;
}

double total_length(const CurveGraph& graph) {
  double sum = 0;
  for (const CurveGraph::Branch& branch : graph.branches) sum += branch.length;
  return sum;
}

std::int64_t loops_of(const CurveGraph& graph) {
  return static_cast<std::int64_t>(graph.branches.size()) + graph.components -
         static_cast<std::int64_t>(graph.nodes.size());
}

// What holds of every result.
void expect_consistent(const Repaired& repaired) {
  const CurveGraph& graph = repaired.graph;
  ASSERT_EQ(repaired.bridged.size(), graph.branches.size());
  std::vector<std::uint32_t> degree(graph.nodes.size(), 0);
  base::UnionFind sets(graph.nodes.size());
  for (std::size_t b = 0; b < graph.branches.size(); ++b) {
    const CurveGraph::Branch& branch = graph.branches[b];
    ASSERT_LE(branch.from, branch.to);
    ASSERT_LT(branch.to, graph.nodes.size());
    ASSERT_EQ(branch.points.front(), graph.nodes[branch.from].point);
    ASSERT_EQ(branch.points.back(), graph.nodes[branch.to].point);
    ASSERT_EQ(branch.radius.size(), branch.points.size());
    ASSERT_GT(branch.length, 0);
    if (!repaired.bridged[b].empty()) {
      ASSERT_EQ(repaired.bridged[b].size() + 1, branch.points.size());
      ASSERT_TRUE(branch.vertices.empty());
    }
    ++degree[branch.from];
    ++degree[branch.to];
    sets.unite(branch.from, branch.to);
  }
  for (std::size_t n = 0; n < graph.nodes.size(); ++n) ASSERT_EQ(degree[n], graph.nodes[n].degree);
  ASSERT_EQ(sets.count(), graph.components);
  ASSERT_EQ(loops_of(graph), 0);
}

// The nodes on the way from the node nearest to `from` to that nearest to `to`, and the length of the way.
double way_between(const CurveGraph& graph, const Vec3& from, const Vec3& to) {
  const auto nearest = [&](const Vec3& point) {
    return static_cast<std::uint32_t>(
        std::ranges::min_element(graph.nodes, {}, [&](const CurveGraph::Node& n) { return (n.point - point).norm(); }) -
        graph.nodes.begin());
  };
  std::vector<double> distance(graph.nodes.size(), -1);
  std::queue<std::uint32_t> queue;
  queue.push(nearest(from));
  distance[queue.front()] = 0;
  for (; !queue.empty(); queue.pop())
    for (const CurveGraph::Branch& branch : graph.branches)
      for (const auto& [a, b] : {std::pair{branch.from, branch.to}, std::pair{branch.to, branch.from}})
        if (a == queue.front() && distance[b] < 0) {
          distance[b] = distance[a] + branch.length;
          queue.push(b);
        }
  return distance[nearest(to)];
}

// A main root down the z axis, thick; pieces between the places where something emerges.
std::vector<Tube> main_root(const std::vector<double>& emergences) {
  std::vector<Tube> tubes;
  double last = 0;
  for (const double z : emergences) {
    tubes.push_back({{{0, 0, -last}, {0, 0, -z}}, 6, 6});
    last = z;
  }
  tubes.push_back({{{0, 0, -last}, {0, 0, -200}}, 6, 3});
  return tubes;
}

TEST(Repair, LeavesATreeAsItIs) {
  std::vector<Tube> tubes = main_root({40, 80});
  tubes.push_back({{{0, 0, -40}, {60, 0, -70}}, 3, 1.5});
  tubes.push_back({{{0, 0, -80}, {-60, 10, -90}}, 2, 1.5});
  const CurveGraph graph = graph_of(tubes);
  const Repaired result = repaired(graph, {});
  expect_consistent(result);
  EXPECT_TRUE(result.edits.empty());
  ASSERT_EQ(result.graph.branches.size(), graph.branches.size());
  EXPECT_NEAR(total_length(result.graph), total_length(graph), 1e-9);
  EXPECT_EQ(result.components_before, 1u);
  EXPECT_EQ(result.loops_before, 0u);
}

TEST(Repair, ClosesAGapInATube) {
  const CurveGraph graph = graph_of({{{{0, 0, 0}, {40, 0, 0}}, 2, 2}, {{{46, 0, 0}, {90, 0, 0}}, 2, 1.8}});
  const Repaired result = repaired(graph, {});
  expect_consistent(result);
  ASSERT_EQ(kinds(result), std::vector{Kind::bridge});
  const TreeEdit& bridge = result.edits.front();
  EXPECT_NEAR((bridge.from - bridge.to).norm(), 6, 1e-9);
  EXPECT_NEAR(bridge.length, 6, 1e-9);
  EXPECT_TRUE(std::isnan(bridge.grey));
  ASSERT_EQ(result.graph.branches.size(), 1u);
  EXPECT_NEAR(result.graph.branches[0].length, 90, 1e-9);
  EXPECT_EQ(std::accumulate(result.bridged[0].begin(), result.bridged[0].end(), 0), 1);
}

TEST(Repair, ABranchBrokenOffIsPutBackOnItsParent) {
  std::vector<Tube> tubes = main_root({});
  tubes.push_back({{{10, 0, -85}, {60, 0, -110}}, 2, 1.5});
  const Repaired result = repaired(graph_of(tubes), {});
  expect_consistent(result);
  ASSERT_EQ(kinds(result), std::vector{Kind::bridge});
  EXPECT_EQ(result.graph.branches.size(), 3u);  // the parent is split
  EXPECT_EQ(result.graph.components, 1u);
}

// The thinner end of a piece is nearer to the side of a branch than its thicker end to the end it broke off from.
TEST(Repair, APieceIsJoinedByItsBase) {
  const std::vector<Tube> tubes{{{{60, 0, 0}, {0, 0, 0}, {0, 60, 0}, {118, 60, 0}, {118, -40, 0}}, 2, 2},
                                {{{74, 0, 0}, {110, 0, 0}}, 1.8, 1.2}};
  const Repaired result = repaired(graph_of(tubes), {});
  expect_consistent(result);
  ASSERT_EQ(kinds(result), std::vector{Kind::bridge});
  EXPECT_NEAR(result.edits.front().length, 14, 1e-9);
  EXPECT_EQ(result.graph.branches.size(), 1u);
}

TEST(Repair, SpecksAndFarPiecesAreLeftOut) {
  const CurveGraph graph =
      graph_of({{{{0, 0, 0}, {80, 0, 0}}, 2, 2}, {{{40, 200, 0}}, 0.5}, {{{0, 300, 0}, {30, 300, 0}}, 1, 1}});
  const Repaired result = repaired(graph, {});
  expect_consistent(result);
  ASSERT_EQ(kinds(result), (std::vector{Kind::left_out, Kind::left_out}));
  EXPECT_NEAR(result.edits[0].length + result.edits[1].length, 30, 1e-9);
  EXPECT_EQ(result.graph.components, 1u);
  RepairOptions all;
  all.plants = 0;
  EXPECT_EQ(repaired(graph, all).graph.components, 3u);
  EXPECT_TRUE(repaired(graph, all).edits.empty());
  RepairOptions two;
  two.plants = 2;
  EXPECT_EQ(repaired(graph, two).graph.components, 2u);
  RepairOptions given;
  given.roots = {Vec3(0, 301, 0)};
  const Repaired there = repaired(graph, given);
  ASSERT_EQ(there.graph.branches.size(), 1u);
  EXPECT_NEAR(there.graph.branches[0].length, 30, 1e-9);
}

// Two laterals side by side; a thin neck joins them.
TEST(Repair, ANeckBetweenTwoTubesIsCut) {
  std::vector<Tube> tubes = main_root({40, 60});
  tubes.push_back({{{0, 0, -40}, {30, 0, -50}, {60, 0, -60}}, 3, 2.5});
  tubes.push_back({{{60, 0, -60}, {120, 0, -80}}, 2.5, 1.5});
  tubes.push_back({{{0, 0, -60}, {30, 0, -62}, {60, 0, -66}}, 3, 2.5});
  tubes.push_back({{{60, 0, -66}, {120, 0, -100}}, 2.5, 1.5});
  const double length = total_length(graph_of(tubes));
  tubes.push_back({{{60, 0, -60}, {60, 0, -66}}, 2.5, 2.5, 0.8});
  const Repaired result = repaired(graph_of(tubes), {});
  expect_consistent(result);
  ASSERT_EQ(kinds(result), std::vector{Kind::cut_touching});
  EXPECT_NEAR((result.edits[0].from - Vec3(60, 0, -63)).norm(), 0, 1.5);
  EXPECT_EQ(result.graph.branches.size(), 5u);
  EXPECT_NEAR(total_length(result.graph), length, 1e-6);
}

// Two laterals that cross at one point, and along a short common piece.
TEST(Repair, TubesThatCrossGoOnStraight) {
  for (const double common : {0.0, 4.0}) {
    const Vec3 a(50 - common / 2, 0, -60), b(50 + common / 2, 0, -60);
    std::vector<Tube> tubes = main_root({40, 80});
    tubes.push_back({{{0, 0, -40}, a}, 3, 2.5});
    tubes.push_back({{{0, 0, -80}, a}, 3, 2.5});
    tubes.push_back({{b, {100, 0, -80}}, 2.5, 1.6});
    tubes.push_back({{b, {100, 0, -40}}, 2.5, 1.6});
    if (common > 0) tubes.push_back({{a, b}, 2.6, 2.6});
    const Repaired result = repaired(graph_of(tubes), {});
    expect_consistent(result);
    ASSERT_EQ(kinds(result), std::vector{Kind::cut_crossing}) << common;
    EXPECT_EQ(result.graph.branches.size(), 5u);
    // Down, and out at the side where it goes on straight.
    EXPECT_NEAR(way_between(result.graph, {0, 0, 0}, {100, 0, -80}), 40 + Vec3(100, 0, -40).norm(), 1);
    EXPECT_NEAR(way_between(result.graph, {0, 0, 0}, {100, 0, -40}), 80 + Vec3(100, 0, 40).norm(), 1);
  }
}

// Two plants that cross: the cheapest cut leaves both whole. A tip is no plant.
TEST(Repair, PlantsThatTouchAreParted) {
  std::vector<Tube> tubes;
  for (const double side : {-1.0, 1.0}) {
    tubes.push_back({{{50 * side, 0, 0}, {0, 0, -60}}, 4, 3.5});
    tubes.push_back({{{0, 0, -60}, {-50 * side, 0, -120}}, 3.5, 3});
  }
  RepairOptions options;
  options.plants = 2;
  const Repaired result = repaired(graph_of(tubes), options);
  expect_consistent(result);
  EXPECT_EQ(kinds(result), std::vector{Kind::cut_crossing});
  EXPECT_EQ(result.graph.components, 2u);
  options.plants = 3;
  EXPECT_EQ(repaired(graph_of(tubes), options).graph.components, 2u);
}

// The tip of one lateral touches another: neither that one nor the place where it emerges is cut.
TEST(Repair, ATipThatTouchesIsCut) {
  std::vector<Tube> tubes = main_root({40, 100});
  tubes.push_back({{{0, 0, -40}, {60, 0, -70}}, 3.5, 3});
  tubes.push_back({{{60, 0, -70}, {120, 0, -100}}, 3, 1.5});
  tubes.push_back({{{0, 0, -100}, {40, 20, -90}, {60, 0, -70}}, 3, 1.5});
  const Repaired result = repaired(graph_of(tubes), {});
  expect_consistent(result);
  ASSERT_EQ(kinds(result), std::vector{Kind::cut_touching});
  EXPECT_NEAR((result.edits[0].to - Vec3(60, 0, -70)).norm(), 0, 1e-9);
  EXPECT_EQ(result.graph.branches.size(), 5u);
  EXPECT_GT(way_between(result.graph, {0, 0, 0}, {60, 0, -72}), 140);
}

TEST(Repair, EveryRungOfALadderIsCut) {
  std::vector<Tube> tubes = main_root({40, 47});
  double x = 0;
  for (int rung = 0; rung < 6; ++rung, x += 15) {
    tubes.push_back({{{x, 0, -40}, {x + 15, 0, -40}}, 2.5, 2.5});
    tubes.push_back({{{x, 0, -47}, {x + 15, 0, -47}}, 2.5, 2.5});
    if (rung > 0) tubes.push_back({{{x, 0, -40}, {x, 0, -47}}, 2.5, 2.5, 0.6});
  }
  const Repaired result = repaired(graph_of(tubes), {});
  expect_consistent(result);
  EXPECT_EQ(kinds(result), std::vector(5, Kind::cut_touching));
  EXPECT_EQ(result.loops_before, 5u);
  EXPECT_EQ(result.graph.branches.size(), 5u);
}

TEST(Repair, ARingIsCutWhereItIsThin) {
  std::vector<Vec3> ring;
  for (int i = 0; i <= 40; ++i) ring.push_back({20 * std::cos(i * 0.15707963), 20 * std::sin(i * 0.15707963), 0});
  ring.back() = ring.front();
  const Repaired result = repaired(graph_of({{ring, 2, 2, 1}}), {});
  expect_consistent(result);
  ASSERT_EQ(kinds(result), std::vector{Kind::cut_loop});
  EXPECT_NEAR((result.edits[0].from - Vec3(-20, 0, 0)).norm(), 0, 1);
  EXPECT_EQ(result.graph.branches.size(), 1u);
}

std::vector<Tube> tangle() {
  std::vector<Tube> tubes = main_root({40, 80});
  const Vec3 a(49, 1, -60), b(51, 1.5, -60.5);
  tubes.push_back({{{0, 0, -40}, a}, 3, 2.5});
  tubes.push_back({{{0, 0, -80}, a}, 3.1, 2.6});
  tubes.push_back({{b, {100, 3, -81}}, 2.5, 1.6});
  tubes.push_back({{b, {101, 4, -40}}, 2.4, 1.7});
  tubes.push_back({{a, b}, 2.6, 2.6});
  tubes.push_back({{{105, 4.5, -38}, {150, 8, -30}}, 1.7, 1.5});
  tubes.push_back({{{0, 40, -300}, {10, 41, -320}}, 1, 1.1});
  return tubes;
}

TEST(Repair, RulesDoTheirPart) {
  const CurveGraph graph = graph_of(tangle());
  RepairOptions options;
  options.rule = RepairRule::off;
  EXPECT_TRUE(repaired(graph, options).edits.empty());
  EXPECT_EQ(repaired(graph, options).graph.branches.size(), graph.branches.size());
  options.rule = RepairRule::loops;
  EXPECT_EQ(kinds(repaired(graph, options)), (std::vector{Kind::cut_crossing, Kind::left_out, Kind::left_out}));
  options.rule = RepairRule::gaps;
  const Repaired gaps = repaired(graph, options);
  EXPECT_EQ(kinds(gaps), (std::vector{Kind::bridge, Kind::left_out}));
  EXPECT_EQ(loops_of(gaps.graph), 1);
  options.rule = RepairRule::all;
  EXPECT_EQ(kinds(repaired(graph, options)), (std::vector{Kind::cut_crossing, Kind::bridge, Kind::left_out}));
}

TEST(Repair, IsTheSameOnAnyNumberOfThreadsAndInAMirror) {
  const CurveGraph graph = graph_of(tangle());
  const Repaired once = repaired(graph, {});
  for (const int threads : {1, 3}) {
    Context context;
    context.threads = threads;
    const Repaired again = repaired(graph, {}, nullptr, &context);
    ASSERT_EQ(again.graph.nodes.size(), once.graph.nodes.size());
    for (std::size_t n = 0; n < once.graph.nodes.size(); ++n)
      EXPECT_EQ(again.graph.nodes[n].point, once.graph.nodes[n].point);
  }
  const auto turned = [](const Vec3& p) { return Vec3(-p[2], p[0], p[1]); };
  std::vector<Tube> tubes = tangle();
  for (Tube& tube : tubes)
    for (Vec3& corner : tube.corners) corner = turned(corner);
  const Repaired other = repaired(graph_of(tubes), {});
  ASSERT_EQ(other.graph.nodes.size(), once.graph.nodes.size());
  for (std::size_t n = 0; n < once.graph.nodes.size(); ++n)
    EXPECT_NEAR((other.graph.nodes[n].point - turned(once.graph.nodes[n].point)).norm(), 0, 1e-9);
  EXPECT_EQ(kinds(other), kinds(once));
}

// Bright below the threshold on one side: the bridge goes there although the other is as near.
TEST(Repair, GreyValuesDecideBetweenBridges) {
  const CurveGraph graph = graph_of({{{{8, 30, 20}, {28, 30, 20}}, 2, 2},
                                     {{{36, 26, 20}, {56, 20, 20}}, 2, 2},
                                     {{{36, 34, 20}, {58, 40, 20}}, 2, 2}});
  for (const bool upper : {false, true}) {
    Volume volume;
    volume.grid.dims = {64, 64, 40};
    std::vector<std::uint8_t> samples(64 * 64 * 40, 10);
    for (std::int64_t x = 26; x < 40; ++x)
      for (std::int64_t y = upper ? 30 : 24; y < (upper ? 37 : 31); ++y)
        for (std::int64_t z = 18; z < 23; ++z) samples[static_cast<std::size_t>(x + 64 * (y + 64 * z))] = 90;
    volume.samples = samples;
    const GreyValues grey{&volume, 100, false};
    RepairOptions options;
    const Repaired result = repaired(graph, options, &grey);
    expect_consistent(result);
    const auto first =
        std::ranges::find_if(result.edits, [](const TreeEdit& e) { return e.kind == Kind::bridge && e.grey > 0.8; });
    ASSERT_NE(first, result.edits.end());
    EXPECT_EQ(std::max(first->from[1], first->to[1]) > 31, upper);
  }
}

TEST(Repair, NothingIsRepairedOfNothing) {
  const Repaired result = repaired(CurveGraph{}, {});
  EXPECT_TRUE(result.graph.nodes.empty());
  EXPECT_TRUE(result.edits.empty());
}

}  // namespace repair_test
}  // namespace quench
