// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <numbers>
#include <set>

#include "quench/error.h"
#include "small_graphs.h"

namespace quench {
namespace hierarchy_test {

using testing_trees::Builder;
using testing_trees::moved;
using testing_trees::random_forest;

constexpr AxisRule kRules[] = {AxisRule::depth, AxisRule::length, AxisRule::radius, AxisRule::strahler,
                               AxisRule::continuation};

double length_of(const std::vector<Vec3>& points) {
  double length = 0;
  for (std::size_t i = 1; i < points.size(); ++i) length += (points[i] - points[i - 1]).norm();
  return length;
}
HierarchyOptions by(AxisRule rule) {
  HierarchyOptions options;
  options.rule = rule;
  return options;
}
// The axis that ends at a point.
const Tree::Axis& ending_at(const Tree& tree, const Vec3& tip) {
  const auto found = std::ranges::find_if(tree.axes, [&](const Tree::Axis& a) { return a.points.back() == tip; });
  if (found == tree.axes.end()) throw std::runtime_error("no axis ends there");
  return *found;
}

// Down from (0, 0, 0), 4 long, with a fork at -2: one child goes on straight for 2, the other to the side for 5.
Builder long_lateral() {
  Builder y;
  const auto root = y.node({0, 0, 0}, 0.5), fork = y.node({0, 0, -2}, 0.4);
  y.branch(root, fork, {}, 0.4);
  y.branch(fork, y.node({0, 0, -4}, 0.3), {{0, 0, -3}}, 0.35);
  y.branch(fork, y.node({5, 0, -2}, 0.1), {{1, 0, -2}}, 0.1);
  return y;
}

TEST(Hierarchy, RulesDifferWhereALateralIsLongerThanTheRestOfItsParent) {
  const Repaired repaired = long_lateral().repaired();
  for (const AxisRule rule : {AxisRule::radius, AxisRule::continuation}) {
    const Tree tree = tree_of(repaired, by(rule));
    ASSERT_EQ(tree.axes.size(), 2u);
    EXPECT_EQ(tree.axes[0].points.back(), Vec3(0, 0, -4)) << name_of(rule);
    EXPECT_NEAR(length_of(tree.axes[1].points), 5, 1e-9);
    EXPECT_NEAR(tree.axes[1].position, 2, 1e-9);
    EXPECT_EQ(tree.axes[1].level, 1u);
    EXPECT_EQ(tree.axes[1].parent, 0u);
    EXPECT_EQ(tree.axes[0].children, (std::vector<std::uint32_t>{1}));
  }
  for (const AxisRule rule : {AxisRule::length, AxisRule::depth, AxisRule::strahler})
    EXPECT_EQ(tree_of(repaired, by(rule)).axes[0].points.back(), Vec3(5, 0, -2)) << name_of(rule);
}

TEST(Hierarchy, DepthFollowsTheChildWithTheLargestLevelBehindIt) {
  // To the left a long branch, to the right a short one that forks: `length` takes the first, `depth` the second.
  Builder b;
  const auto root = b.node({0, 0, 0}, 1), fork = b.node({0, 0, -1}), right = b.node({1, 0, -2});
  b.branch(root, fork);
  b.branch(fork, b.node({-9, 0, -9}));
  b.branch(fork, right);
  b.branch(right, b.node({1, 0, -3}));
  b.branch(right, b.node({2, 0, -3}));
  const auto most = [](const Tree& tree) {
    std::uint32_t level = 0;
    for (const Tree::Axis& a : tree.axes) level = std::max(level, a.level);
    return level;
  };
  EXPECT_EQ(most(tree_of(b.repaired(), by(AxisRule::length))), 2u);
  EXPECT_EQ(most(tree_of(b.repaired(), by(AxisRule::depth))), 1u);
}

// The least largest level that any choice of continuing children gives, with the branch at level 0.
std::uint32_t least_level(const std::vector<std::vector<std::uint32_t>>& children, std::uint32_t b) {
  std::uint32_t least = kNone;
  if (children[b].empty()) return 0;
  for (const std::uint32_t on : children[b]) {
    std::uint32_t most = least_level(children, on);
    for (const std::uint32_t other : children[b])
      if (other != on) most = std::max(most, least_level(children, other) + 1);
    least = std::min(least, most);
  }
  return least;
}
std::uint32_t strahler_of(const std::vector<std::vector<std::uint32_t>>& children, std::uint32_t b) {
  std::vector<std::uint32_t> below;
  for (const std::uint32_t c : children[b]) below.push_back(strahler_of(children, c));
  if (below.empty()) return 1;
  const std::uint32_t most = *std::ranges::max_element(below);
  return most + (std::ranges::count(below, most) > 1 ? 1 : 0);
}

TEST(Hierarchy, RandomForests) {
  std::mt19937 random(1);
  for (int round = 0; round < 2000; ++round) {
    const Builder builder = random_forest(random, round % 40);
    HierarchyOptions options = by(kRules[round % 5]);
    options.root = static_cast<RootRule>(round / 5 % 3);
    options.stem = round / 15 % 2 == 1;
    const Tree tree = tree_of(builder.repaired(), options);
    SCOPED_TRACE(round);

    double whole = 0, branches = 0;
    for (const auto& b : builder.graph.branches) whole += length_of(b.points);
    std::vector<std::vector<std::uint32_t>> children(tree.branches.size());
    for (std::uint32_t b = 0; b < tree.branches.size(); ++b) {
      const Tree::Branch& branch = tree.branches[b];
      branches += length_of(branch.points);
      ASSERT_EQ(branch.points.size(), branch.radius.size());
      if (branch.parent == kNone) {
        EXPECT_EQ(branch.points[0], tree.plants[branch.plant].root);
        EXPECT_EQ(branch.order, 0u);
        continue;
      }
      ASSERT_LT(branch.parent, b);
      children[branch.parent].push_back(b);
      EXPECT_EQ(branch.points[0], tree.branches[branch.parent].points.back());
      EXPECT_EQ(branch.plant, tree.branches[branch.parent].plant);
      EXPECT_EQ(branch.order, tree.branches[branch.parent].order + 1);
    }
    EXPECT_NEAR(branches, whole, 1e-9 * (1 + whole));
    for (std::uint32_t b = 0; b < tree.branches.size(); ++b) {
      EXPECT_NE(children[b].size(), 1u);  // a fork has two at least
      EXPECT_EQ(tree.branches[b].strahler, strahler_of(children, b));
    }

    std::vector<int> axes_of(tree.branches.size(), 0);
    for (std::uint32_t a = 0; a < tree.axes.size(); ++a) {
      const Tree::Axis& axis = tree.axes[a];
      ASSERT_FALSE(axis.branches.empty());
      ASSERT_EQ(axis.points.size(), axis.radius.size());
      for (std::size_t i = 0; i < axis.branches.size(); ++i) {
        ++axes_of[axis.branches[i]];
        EXPECT_EQ(tree.branches[axis.branches[i]].axis, a);
        if (i > 0) {
          EXPECT_EQ(tree.branches[axis.branches[i]].parent, axis.branches[i - 1]);
        }
      }
      EXPECT_EQ(axis.points.back(), tree.branches[axis.branches.back()].points.back());
      if (axis.parent == kNone) {
        EXPECT_EQ(axis.level, 0u);
        EXPECT_EQ(tree.plants[axis.plant].main_axis, a);
      } else {
        ASSERT_LT(axis.parent, a);
        EXPECT_EQ(axis.level, tree.axes[axis.parent].level + 1);
        EXPECT_EQ(std::ranges::count(tree.axes[axis.parent].children, a), 1);
        EXPECT_GE(axis.position, 0);
        EXPECT_LE(axis.position, length_of(tree.axes[axis.parent].points) * (1 + 1e-9) + 1e-9);
      }
      EXPECT_TRUE(std::ranges::is_sorted(axis.children, {}, [&](std::uint32_t c) { return tree.axes[c].position; }));
    }
    EXPECT_EQ(std::ranges::count(axes_of, 1), static_cast<std::ptrdiff_t>(axes_of.size()));

    // As a tree of a file, by depth: every largest level is the least there is. (A graph's tree may have less: its
    // forks inside of an older tube are that one's.)
    if (tree.branches.size() > 25) continue;
    const Tree again = with_hierarchy(tree, by(AxisRule::depth));
    for (std::uint32_t p = 0; p < again.plants.size(); ++p) {
      std::uint32_t most = 0, least = 0, at_root = 0;
      for (const Tree::Axis& a : again.axes)
        if (a.plant == p) most = std::max(most, a.level);
      for (std::uint32_t b = 0; b < again.branches.size(); ++b)
        if (again.branches[b].parent == kNone && again.branches[b].plant == p) {
          least = least_level(children, b);
          ++at_root;
        }
      if (at_root == 1) {
        EXPECT_EQ(most, least);
      }
    }
  }
}

TEST(Hierarchy, DoesNotDependOnPlaceTurnSizeAndOrder) {
  std::mt19937 random(2);
  for (int round = 0; round < 300; ++round) {
    SCOPED_TRACE(round);
    const Builder builder = random_forest(random, 30);
    const HierarchyOptions options = by(kRules[round % 5]);
    const Mat3 turn = (Eigen::AngleAxisd(1 + round, Vec3(1, 2, 3).normalized())).toRotationMatrix();
    const auto place = [&](const Vec3& x) -> Vec3 { return 3 * (turn * x) + Vec3(5, -7, 2); };
    Repaired other = builder.repaired();
    other.graph = moved(other.graph, place, 3);
    std::ranges::shuffle(other.graph.branches, random);
    const Tree a = tree_of(builder.repaired(), options), b = tree_of(other, options);
    ASSERT_EQ(a.axes.size(), b.axes.size());
    std::multiset<std::string> of_a, of_b;
    const auto describe = [](const Tree& tree, double scale) {
      std::multiset<std::string> all;
      for (const Tree::Axis& axis : tree.axes) {
        char text[80];
        std::snprintf(text, sizeof text, "%u %zu %zu %.6g", axis.level, axis.branches.size(), axis.children.size(),
                      length_of(axis.points) / scale);
        all.insert(text);
      }
      return all;
    };
    EXPECT_EQ(describe(a, 1), describe(b, 3));
  }
}

TEST(Hierarchy, EmptyAndIsolated) {
  Builder b;
  const Tree none = tree_of(b.repaired(), {});
  EXPECT_TRUE(none.branches.empty() && none.axes.empty() && none.plants.empty());
  b.node({1, 2, 3}, 0.5);
  for (const bool again : {false, true}) {
    Tree one = tree_of(b.repaired(), {});
    if (again) one = with_hierarchy(std::move(one), {});
    ASSERT_EQ(one.branches.size(), 1u);
    ASSERT_EQ(one.axes.size(), 1u);
    EXPECT_EQ(one.axes[0].points, (std::vector<Vec3>{{1, 2, 3}}));
    EXPECT_EQ(one.axes[0].radius, (std::vector<double>{0.5}));
    EXPECT_EQ(one.plants[0].root, Vec3(1, 2, 3));
  }
}

TEST(Hierarchy, RefusesLoopsAndSheets) {
  Builder b;
  const auto p = b.node({0, 0, 0}), q = b.node({1, 0, 0});
  b.branch(p, q);
  b.branch(p, q, {{0, 1, 0}});
  EXPECT_THROW(tree_of(b.repaired(), {}), Error);
  Builder closed;
  const auto loop = closed.node({0, 0, 0});
  closed.branch(loop, loop, {{1, 0, 0}, {0, 1, 0}});
  EXPECT_THROW(tree_of(closed.repaired(), {}), Error);
  Repaired sheet = Builder().repaired();
  sheet.graph.sheets = 1;
  EXPECT_THROW(tree_of(sheet, {}), Error);
}

TEST(Hierarchy, Roots) {
  Builder b;  // the thickest node is the fork, the thickest end is the lower one
  const auto up = b.node({0, 0, 0}, 0.3), fork = b.node({0, 0, -1}, 0.9);
  b.branch(up, fork);
  b.branch(fork, b.node({1, 0, -9}, 0.5));
  b.branch(fork, b.node({-1, 0, -0.1}, 0.2));
  HierarchyOptions options;
  const auto root = [&] { return tree_of(b.repaired(), options).plants.at(0).root; };
  EXPECT_EQ(root(), Vec3(0, 0, -1));
  options.root = RootRule::end;
  EXPECT_EQ(root(), Vec3(1, 0, -9));
  options.root = RootRule::top;
  EXPECT_EQ(root(), Vec3(0, 0, 0));
  options.down = Vec3(0, 0, 1);
  EXPECT_EQ(root(), Vec3(1, 0, -9));
  options.roots = {Vec3(-5, 0, 0)};
  EXPECT_EQ(root(), Vec3(-1, 0, -0.1));
  // A tree of a file keeps its root node but for one that is asked for.
  Tree tree = tree_of(b.repaired(), options);
  EXPECT_EQ(with_hierarchy(tree, {}).plants[0].root, Vec3(-1, 0, -0.1));
  options.roots = {Vec3(0, 0, 1)};
  EXPECT_EQ(with_hierarchy(tree, options).plants[0].root, Vec3(0, 0, 0));
}

TEST(Hierarchy, Soma) {
  // A ball of radius 2 in the middle of a branch, a fork inside of it.
  Builder b;
  const auto left = b.node({-10, 0, 0}, 0.2), inside = b.node({1, 0, 0}, 1.5);
  b.branch(left, inside);
  b.graph.branches[0].points = {{-10, 0, 0}, {-2, 0, 0}, {0, 0, 0}, {1, 0, 0}};
  b.graph.branches[0].radius = {0.2, 0.2, 2, 1.5};
  b.branch(inside, b.node({10, 0, 0}, 0.2), {{3, 0, 0}}, 0.2);
  b.branch(inside, b.node({1, 10, 0}, 0.2), {{1, 3, 0}}, 0.2);
  HierarchyOptions options;
  options.soma = SomaRule::automatic;
  const Tree tree = tree_of(b.repaired(), options);
  ASSERT_EQ(tree.plants.size(), 1u);
  EXPECT_EQ(tree.plants[0].soma, 2.0);
  EXPECT_EQ(tree.plants[0].root, Vec3(0, 0, 0));
  ASSERT_EQ(tree.branches.size(), 3u);
  for (const Tree::Branch& branch : tree.branches) {
    EXPECT_EQ(branch.parent, kNone);
    EXPECT_NEAR(branch.points[1].norm(), 2, 1e-9);
    EXPECT_LE(branch.radius[0], 0.2 + 1e-9);
  }
  for (const Tree::Axis& axis : tree.axes) EXPECT_EQ(axis.level, 0u);
  // A tube without a thick ball has none.
  Builder tube;
  tube.branch(tube.node({0, 0, 0}, 1), tube.node({9, 0, 0}, 0.8));
  EXPECT_FALSE(tree_of(tube.repaired(), options).plants[0].soma);
}

TEST(Hierarchy, AStemGoesOnInWhatIsThickEnough) {
  Builder b;  // 1 thick for 4, then 0.6 for 6, with a lateral on both
  const auto top = b.node({0, 0, 0}, 1), first = b.node({0, 0, -2}, 1), last = b.node({0, 0, -7}, 0.6);
  b.branch(top, first, {}, 1);
  b.branch(first, last, {{0, 0, -3}, {0, 0, -4}, {0, 0, -5}}, 0.6);
  b.branch(last, b.node({0, 0, -10}, 0.3), {}, 0.3);
  b.branch(first, b.node({9, 0, -2}, 0.2), {{2, 0, -2}}, 0.2);
  b.branch(last, b.node({9, 0, -7}, 0.1), {{1, 0, -7}}, 0.1);
  HierarchyOptions options = by(AxisRule::continuation);
  options.root = RootRule::top;
  options.stem = true;
  const Tree tree = tree_of(b.repaired(), options);
  ASSERT_EQ(tree.axes.size(), 3u);
  EXPECT_FALSE(tree.axes[0].stem);
  EXPECT_EQ(tree.axes[0].points.back(), Vec3(0, 0, -10));
  EXPECT_EQ(ending_at(tree, {9, 0, -7}).level, 1u);
}

TEST(Hierarchy, AStemEndsWhereOnlyThinRootsGoOn) {
  Builder b;  // a trunk 2 thick; at its side a thin root goes straight on, at its end there is a crown
  const auto top = b.node({0, 0, 0}, 2), side = b.node({0, 0, -6}, 2), end = b.node({3, 0, -9}, 2),
             crown = b.node({6, 0, -12}, 1.8);
  b.branch(top, side, {{0, 0, -3}}, 2);
  b.branch(side, b.node({0, 0, -30}, 0.3), {{0, 0, -8}}, 0.3);
  b.branch(side, end, {}, 2);
  b.branch(end, b.node({3, 0, -30}, 0.3), {{3, 0, -11}}, 0.3);
  b.branch(end, crown, {}, 1.8);
  b.branch(crown, b.node({20, 0, -20}, 0.3), {{8, 0, -14}}, 0.3);
  b.branch(crown, b.node({6, 9, -20}, 0.3), {{6, 2, -14}}, 0.3);
  HierarchyOptions options = by(AxisRule::continuation);
  options.root = RootRule::top;
  EXPECT_EQ(tree_of(b.repaired(), options).axes.size(), 4u);
  options.stem = true;
  const Tree tree = tree_of(b.repaired(), options);
  ASSERT_EQ(tree.axes.size(), 5u);
  EXPECT_TRUE(tree.axes[0].stem);
  EXPECT_EQ(tree.axes[0].points.back(), Vec3(6, 0, -12));
  for (std::size_t a = 1; a < 5; ++a) EXPECT_EQ(tree.axes[a].level, 1u);
}

TEST(Hierarchy, NearTiesOfContinuationGoToTheLongerWay) {
  Builder b;  // two children of equal radius that turn by nearly the same
  const auto top = b.node({0, 0, 0}, 0.5), fork = b.node({0, 0, -9}, 0.5);
  b.branch(top, fork, {}, 0.5);
  b.branch(fork, b.node({4, 0, -13}, 0.3), {}, 0.3);
  b.branch(fork, b.node({-41, 0, -49}, 0.3), {}, 0.3);
  HierarchyOptions options = by(AxisRule::continuation);
  options.root = RootRule::top;
  EXPECT_EQ(tree_of(b.repaired(), options).axes[0].points.back(), Vec3(-41, 0, -49));
}

TEST(Hierarchy, TipsGrowByAQuarterOfAVoxel) {
  Builder b;
  b.branch(b.node({0, 0, 0}, 0.5), b.node({0, 0, -9}, 0.5), {{0, 0, -5}}, 0.5);
  HierarchyOptions options;
  options.root = RootRule::top;
  options.voxel = 0.2;
  const Tree tree = tree_of(b.repaired(), options);
  EXPECT_NEAR(tree.axes[0].points.back()[2], -9.05, 1e-12);
  EXPECT_EQ(tree.plants[0].root, Vec3(0, 0, 0));
}

TEST(Hierarchy, TheRootNodeAtTheTopIsWhereTheTreeIsThick) {
  Builder b;  // the trunk's top ends in a thin spur; a lateral's tip is higher and thicker than that
  const auto spur = b.node({0.5, 0, 0}, 0.1), trunk = b.node({0, 0, -1.2}, 1), fork = b.node({0, 0, -6}, 1);
  b.branch(spur, trunk, {}, 0.1);
  b.branch(trunk, fork, {}, 1);
  b.branch(fork, b.node({0, 0, -30}, 0.5), {}, 0.5);
  b.branch(fork, b.node({9, 0, 1}, 0.3), {{2, 0, -5}}, 0.3);
  HierarchyOptions options;
  options.root = RootRule::top;
  EXPECT_EQ(tree_of(b.repaired(), options).plants.at(0).root, Vec3(0.5, 0, 0));
}

TEST(Hierarchy, ChildrenBeginOnTheCentreLineOfTheirParent) {
  // Two laterals at one place: their courses meet inside of the thick axis, 0.3 from its centre line.
  Builder b;
  const auto top = b.node({0, 0, 5}, 1), on = b.node({0, 0, 0}, 1), inner = b.node({0.3, 0, 0}, 0.8);
  b.branch(top, on, {{0, 0, 3}, {0, 0, 1}}, 1);
  b.branch(on, b.node({0, 0, -20}, 1), {{0, 0, -1}, {0, 0, -3}, {0, 0, -5}}, 1);
  b.branch(on, inner, {}, 0.8);
  b.branch(inner, b.node({6, 4, 0}, 0.2), {{1.5, 1, 0}, {3, 2, 0}}, 0.2);
  b.branch(inner, b.node({6, -4, 0}, 0.2), {{1.5, -1, 0}, {3, -2, 0}}, 0.2);
  HierarchyOptions options = by(AxisRule::continuation);
  options.root = RootRule::top;
  const Tree tree = tree_of(b.repaired(), options);
  ASSERT_EQ(tree.axes.size(), 3u);
  for (const Vec3& tip : {Vec3(6, 4, 0), Vec3(6, -4, 0)}) {
    const Tree::Axis& axis = ending_at(tree, tip);
    EXPECT_EQ(axis.parent, 0u);
    EXPECT_NEAR(axis.points[0].norm(), 0, 1e-9);
    EXPECT_NEAR(axis.position, 5, 1e-9);
    EXPECT_NEAR(length_of(axis.points), std::sqrt(52.0), 1e-9);
  }
  // What a file says stays as it is: one of the two grows from the other.
  const Tree of_file = with_hierarchy(tree, options);
  const std::uint32_t left = ending_at(of_file, {6, 4, 0}).level, right = ending_at(of_file, {6, -4, 0}).level;
  EXPECT_EQ(left + right, 3u);
  EXPECT_EQ(ending_at(of_file, {6, left == 2 ? 4.0 : -4.0, 0}).points[0], Vec3(0.3, 0, 0));
}

TEST(Hierarchy, BridgesAndTypesStay) {
  Builder b;
  const auto p = b.node({0, 0, 0}, 1), q = b.node({1, 0, 0}), r = b.node({2, 0, 0});
  b.branch(q, p, {{0.5, 0, 0}});
  b.branch(q, r);
  Repaired repaired = b.repaired();
  repaired.bridged = {{1, 0}, {}};
  const Tree tree = tree_of(repaired, {});
  ASSERT_EQ(tree.branches.size(), 1u);  // a node of two branches is none
  EXPECT_EQ(tree.branches[0].bridged, (std::vector<std::uint8_t>{0, 1, 0}));
  Tree typed;
  typed.plants.emplace_back();
  typed.branches.resize(2);
  typed.branches[0].points = {{0, 0, 0}, {1, 0, 0}};
  typed.branches[1].points = {{1, 0, 0}, {2, 0, 0}};
  typed.branches[0].radius = typed.branches[1].radius = {1, 1};
  typed.branches[0].type = 3;
  typed.branches[1].type = 2;
  typed.branches[1].parent = 0;
  EXPECT_EQ(with_hierarchy(typed, {}).branches.size(), 2u);
  typed.branches[1].type = 3;
  EXPECT_EQ(with_hierarchy(typed, {}).branches.size(), 1u);
}

TEST(Hierarchy, Names) {
  for (const AxisRule rule : kRules) EXPECT_EQ(axis_rule_of(name_of(rule)), rule);
  for (const RootRule rule : {RootRule::thickest, RootRule::end, RootRule::top})
    EXPECT_EQ(root_rule_of(name_of(rule)), rule);
  for (const SomaRule rule : {SomaRule::none, SomaRule::automatic, SomaRule::thickest})
    EXPECT_EQ(soma_rule_of(name_of(rule)), rule);
  EXPECT_FALSE(axis_rule_of("longest"));
}

}  // namespace hierarchy_test
}  // namespace quench
