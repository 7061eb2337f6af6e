// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "quench/error.h"
#include "small_graphs.h"
#include "tree/measured_tree.h"

namespace quench {
namespace traits_test {

using std::numbers::pi;
using testing_trees::Builder;
using testing_trees::moved;
using testing_trees::random_forest;

double value(const Table& table, const std::string& column, std::size_t row = 0) {
  const Table::Column* found = table.find(column);
  if (!found) throw std::runtime_error("no column " + column);
  if (const auto* whole = std::get_if<std::vector<std::int64_t>>(&found->values))
    return static_cast<double>(whole->at(row));
  return std::get<std::vector<double>>(found->values).at(row);
}
// The row of the axis or branch whose tip or end is there.
std::size_t row_at(const Table& table, const std::string& what, const Vec3& place) {
  for (std::size_t row = 0; row < table.rows; ++row)
    if ((Vec3(value(table, what + "_x", row), value(table, what + "_y", row), value(table, what + "_z", row)) - place)
            .norm() < 1e-9)
      return row;
  throw std::runtime_error("no row ends there");
}
// As a tree of a file: its courses are not changed.
Tree as_it_is(const Builder& builder, HierarchyOptions options) {
  return with_hierarchy(tree_of(builder.repaired(), options), options);
}
HierarchyOptions from_top() {
  HierarchyOptions options;
  options.rule = AxisRule::continuation;
  options.root = RootRule::top;
  return options;
}

// Down for 3 and 1 more; at 3 a lateral that goes 2 to the side and then 1 down.
Builder small_plant() {
  Builder b;
  const auto top = b.node({0, 0, 0}, 0.5), fork = b.node({0, 0, -3}, 0.5);
  b.branch(top, fork, {}, 0.5);
  b.branch(fork, b.node({0, 0, -4}, 0.5), {}, 0.5);
  b.branch(fork, b.node({2, 0, -4}, 0.1), {{2, 0, -3}}, 0.1);
  return b;
}

TEST(Traits, OfASmallPlant) {
  Tree tree = as_it_is(small_plant(), from_top());
  tree.coordinates.units = "mm";
  const Traits traits = traits_of(tree);
  ASSERT_EQ(traits.axes.rows, 2u);
  EXPECT_EQ(traits.axes.find("length")->unit, "mm");
  EXPECT_EQ(traits.axes.find("volume")->unit, "mm^3");
  EXPECT_EQ(traits.axes.find("child_density")->unit, "mm^-1");
  const std::size_t lateral = row_at(traits.axes, "tip", {2, 0, -4});
  ASSERT_EQ(lateral, 1u);
  const auto axis = [&](const char* column) { return value(traits.axes, column, lateral); };
  EXPECT_EQ(axis("level"), 1);
  EXPECT_EQ(axis("parent"), 0);
  EXPECT_EQ(axis("order"), 1);
  EXPECT_EQ(axis("strahler"), 1);
  EXPECT_DOUBLE_EQ(axis("length"), 3);
  EXPECT_DOUBLE_EQ(axis("chord"), std::sqrt(5.0));
  EXPECT_DOUBLE_EQ(axis("tortuosity"), 3 / std::sqrt(5.0));
  EXPECT_DOUBLE_EQ(axis("position"), 3);
  EXPECT_DOUBLE_EQ(axis("relative_position"), 0.75);
  EXPECT_DOUBLE_EQ(axis("path_length"), 6);
  EXPECT_NEAR(axis("volume"), pi * 0.01 * 3, 1e-12);
  EXPECT_NEAR(axis("surface"), 2 * pi * 0.1 * 3, 1e-12);
  EXPECT_NEAR(axis("gravity_angle"), std::atan2(2, 1) * 180 / pi, 1e-9);
  EXPECT_NEAR(axis("parent_angle"), 90, 1e-9);
  EXPECT_NEAR(axis("emergence_angle"), 90, 1e-9);
  EXPECT_NEAR(axis("midpoint_angle"), 90, 1e-9);
  EXPECT_NEAR(axis("tip_angle"), 0, 1e-9);
  EXPECT_DOUBLE_EQ(axis("tip_depth"), 4);
  EXPECT_TRUE(std::isnan(value(traits.axes, "position", 0)));
  EXPECT_TRUE(std::isnan(axis("stem_length")));
  EXPECT_DOUBLE_EQ(value(traits.axes, "stem_length", 0), 4);
  EXPECT_EQ(value(traits.axes, "children", 0), 1);
  EXPECT_DOUBLE_EQ(value(traits.axes, "child_density", 0), 0.25);
  EXPECT_TRUE(std::isnan(value(traits.axes, "mean_child_distance", 0)));

  ASSERT_EQ(traits.branches.rows, 3u);
  const auto sample = [&](const char* column) { return value(traits.sample, column); };
  EXPECT_EQ(sample("axes"), 2);
  EXPECT_EQ(sample("branches"), 3);
  EXPECT_EQ(sample("tips"), 2);
  EXPECT_EQ(sample("forks"), 1);
  EXPECT_EQ(sample("levels"), 2);
  EXPECT_EQ(sample("axes_level_1"), 1);
  EXPECT_EQ(sample("axes_level_2"), 0);
  EXPECT_DOUBLE_EQ(sample("length_level_1"), 3);
  EXPECT_DOUBLE_EQ(sample("mean_radius_level_1"), 0.1);
  EXPECT_DOUBLE_EQ(sample("total_length"), 7);
  EXPECT_DOUBLE_EQ(sample("mean_length"), 3.5);
  EXPECT_NEAR(sample("mean_radius"), (4 * 0.5 + 3 * 0.1) / 7, 1e-12);
  EXPECT_DOUBLE_EQ(sample("depth"), 4);
  EXPECT_NEAR(sample("width"), 2, 1e-12);
  EXPECT_EQ(sample("strahler"), 2);
  EXPECT_EQ(sample("max_order"), 1);
  EXPECT_EQ(sample("partition_asymmetry"), 0);
  EXPECT_NEAR(sample("local_angle"), 90, 1e-9);
  EXPECT_NEAR(sample("remote_angle"), std::atan2(2, 1) * 180 / pi, 1e-9);
  EXPECT_EQ(sample("whorls"), 1);
  EXPECT_EQ(sample("max_axes_per_slice"), 2);
  EXPECT_EQ(sample("median_axes_per_slice"), 1);
  EXPECT_EQ(sample("bushiness"), 2);
}

TEST(Traits, EveryColumnSaysWhatItIs) {
  Tree tree = as_it_is(small_plant(), from_top());
  const Traits traits = traits_of(tree);
  for (const Table* table : {&traits.axes, &traits.branches, &traits.sample, &traits.sholl, &traits.depths}) {
    std::vector<std::string> names;
    for (const Table::Column& column : table->columns) {
      EXPECT_FALSE(column.meaning.empty()) << column.name;
      EXPECT_TRUE(column.meaning.ends_with('.')) << column.name;
      EXPECT_EQ(column.name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_"), std::string::npos);
      names.push_back(column.name);
      std::visit([&](const auto& values) { EXPECT_EQ(values.size(), table->rows) << column.name; }, column.values);
    }
    std::ranges::sort(names);
    EXPECT_EQ(std::ranges::adjacent_find(names), names.end());
  }
}

TEST(Traits, Helix) {
  // Radius 2, rise 3 per turn, 4 turns: the length of a turn is sqrt((4 pi)^2 + 9).
  Builder b;
  std::vector<Vec3> points;
  const int count = 4000;
  const auto at = [&](int i) {
    const double t = 8 * pi * i / count;
    return Vec3(2 * std::cos(t), 2 * std::sin(t), -3 * t / (2 * pi));
  };
  const auto top = b.node(at(0), 0.2), bottom = b.node(at(count), 0.2);
  for (int i = 1; i < count; ++i) points.push_back(at(i));
  b.branch(top, bottom, points, 0.2);
  const Traits traits = traits_of(as_it_is(b, from_top()));
  const double length = 4 * std::hypot(4 * pi, 3);
  EXPECT_NEAR(value(traits.axes, "length"), length, 1e-4 * length);
  EXPECT_NEAR(value(traits.axes, "chord"), 12, 1e-9);
  EXPECT_NEAR(value(traits.axes, "tortuosity"), length / 12, 1e-4 * length);
  EXPECT_NEAR(value(traits.axes, "gravity_angle"), 0, 1e-6);
  EXPECT_NEAR(value(traits.sample, "width"), 4, 1e-4);
  // A tube about a curve has the volume of a straight one (Pappus), and its ends are half balls.
  EXPECT_NEAR(value(traits.axes, "volume_balls"), pi * 0.04 * length + 4 * pi / 3 * 0.008, 0.03 * pi * 0.04 * length);
  EXPECT_NEAR(value(traits.axes, "volume"), pi * 0.04 * length, 1e-3 * length);
  for (std::size_t row = 0; row < traits.depths.rows; ++row)
    EXPECT_NEAR(value(traits.depths, "length", row), length / 20, 1e-3 * length);
}

TEST(Traits, UnionOfBalls) {
  const auto course = [](std::vector<std::pair<Vec3, double>> balls) {
    tree::Course line;
    for (const auto& [x, r] : balls) line.append(x, r);
    return line;
  };
  const tree::Course ball = course({{{1, 2, 3}, 2}});
  const tree::BallUnion one = tree::union_of_balls({&ball, 1});
  EXPECT_NEAR(one.volume, 4 * pi / 3 * 8, 1e-9);
  EXPECT_NEAR(one.surface, 16 * pi, 1e-9);
  const std::vector<tree::Course> twice{ball, ball};
  EXPECT_NEAR(tree::union_of_balls(twice).volume, one.volume, 1e-9);  // counted once
  const tree::Course tube = course({{{0, 0, 0}, 1}, {{30, 0, 0}, 1}});
  const tree::BallUnion of_tube = tree::union_of_balls({&tube, 1});
  EXPECT_NEAR(of_tube.surface, 60 * pi + 4 * pi, 0.03 * 60 * pi);
  EXPECT_NEAR(of_tube.volume, 30 * pi + 4 * pi / 3, 0.03 * 30 * pi);
  // Two balls of radius 1 whose centres are 1 apart: the lens is 5 pi / 12.
  const std::vector<tree::Course> lens{course({{{0, 0, 0}, 1}}), course({{{1, 0, 0}, 1}})};
  EXPECT_NEAR(tree::union_of_balls(lens).volume, 8 * pi / 3 - 5 * pi / 12, 0.1);
  EXPECT_EQ(tree::union_of_balls({}).volume, 0);
  const tree::Course thin = course({{{0, 0, 0}, 0}, {{1, 0, 0}, 0}});
  EXPECT_EQ(tree::union_of_balls({&thin, 1}).surface, 0);
}

TEST(Traits, Hull) {
  std::vector<Vec3> cube;
  for (int k = 0; k < 8; ++k) cube.emplace_back(k & 1, k >> 1 & 1, k >> 2);
  EXPECT_NEAR(tree::hull_volume(cube), 1, 1e-9);
  cube.insert(cube.begin(), Vec3(0.5, 0.5, 0.5));
  cube.insert(cube.begin(), Vec3(0.5, 0.5, 0));
  EXPECT_NEAR(tree::hull_volume(cube), 1, 1e-9);
  EXPECT_EQ(tree::hull_volume({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {2, 3, 0}}), 0);
  EXPECT_EQ(tree::hull_volume({}), 0);
  EXPECT_NEAR(tree::widest({{0, 0, 5}, {3, 4, -2}, {1, 1, 0}, {0, 0, 0}}), 5, 1e-12);
  EXPECT_EQ(tree::widest({{1, 1, 1}}), 0);
  // Against the volume as a sum over all tetrahedra that a plane through three points bounds: points on a sphere.
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int round = 0; round < 50; ++round) {
    std::vector<Vec3> points;
    for (int i = 0; i < 20; ++i) points.push_back(Vec3(normal(random), normal(random), normal(random)).normalized());
    double six = 0;
    for (std::size_t a = 0; a < points.size(); ++a)
      for (std::size_t b = a + 1; b < points.size(); ++b)
        for (std::size_t c = b + 1; c < points.size(); ++c) {
          const Vec3 n = (points[b] - points[a]).cross(points[c] - points[a]);
          const auto above = [&](const Vec3& p) { return n.dot(p - points[a]) > 1e-12; };
          const auto below = [&](const Vec3& p) { return n.dot(p - points[a]) < -1e-12; };
          if (std::ranges::none_of(points, above)) six += n.dot(points[a]);
          if (std::ranges::none_of(points, below)) six -= n.dot(points[a]);
        }
    EXPECT_NEAR(tree::hull_volume(points), six / 6, 1e-9);
  }
}

TEST(Traits, FractalDimensionOfALineAndAPlane) {
  tree::Course line, plane;
  line.append({0, 0, 0}, 1);
  line.append({10, 3, 1}, 1);
  EXPECT_NEAR(tree::box_dimension({&line, 1}), 1, 0.05);
  for (int i = 0; i <= 600; ++i) {
    plane.append({i / 600.0, i % 2 ? 1.0 : 0.0, 0.5}, 1);
    plane.append({i / 600.0, i % 2 ? 0.0 : 1.0, 0.5}, 1);
  }
  EXPECT_NEAR(tree::box_dimension({&plane, 1}), 2, 0.05);
  EXPECT_TRUE(std::isnan(tree::box_dimension({})));
}

TEST(Traits, ShollAndWhorls) {
  // A main axis of 10 with two laterals at 2 and two at 6, each 3 long.
  Builder b;
  std::vector<std::uint32_t> on;
  for (const double z : {0.0, -2.0, -6.0, -10.0}) on.push_back(b.node({0, 0, z}, 0.2));
  for (std::size_t i = 1; i < on.size(); ++i) b.branch(on[i - 1], on[i], {}, 0.2);
  for (const double side : {-3.0, 3.0})
    for (const std::size_t i : {1u, 2u}) {
      Vec3 tip = b.graph.nodes[on[i]].point;
      tip[0] = side;
      b.branch(on[i], b.node(tip, 0.05), {}, 0.05);
    }
  TraitOptions options;
  options.sholl_step = 1;
  const Traits traits = traits_of(as_it_is(b, from_top()), options);
  // Laterals reach from 2 to sqrt(13) and from 6 to sqrt(45).
  const std::vector<double> wanted{1, 1, 3, 1, 1, 1, 1, 1, 1, 1};
  ASSERT_EQ(traits.sholl.rows, wanted.size());
  for (std::size_t i = 0; i < wanted.size(); ++i) EXPECT_EQ(value(traits.sholl, "crossings", i), wanted[i]) << i;
  EXPECT_EQ(value(traits.sample, "sholl_max"), 3);
  EXPECT_EQ(value(traits.sample, "sholl_radius"), 3);
  EXPECT_EQ(value(traits.sample, "whorls"), 2);
  EXPECT_EQ(value(traits.sample, "axes_per_whorl"), 2);
  EXPECT_DOUBLE_EQ(value(traits.sample, "mean_internode"), 4);
  EXPECT_DOUBLE_EQ(value(traits.axes, "longest_child_distance", 0), 4);
  EXPECT_NEAR(value(traits.axes, "mean_child_distance", 0), 4.0 / 3, 1e-9);
  EXPECT_THROW(traits_of({}, {-1, 20}), Error);
  EXPECT_THROW(traits_of({}, {0, 0}), Error);
}

TEST(Traits, PartitionAsymmetryAndTaper) {
  Builder b;  // one tip on one side, three on the other: |1 - 3| / 2; there |1 - 2| / 1
  const auto root = b.node({0, 0, 0}, 1), f = b.node({0, 0, -2}, 0.5), g = b.node({1, 0, -3}), h = b.node({2, 0, -4});
  b.branch(root, f);
  b.branch(f, b.node({-1, 0, -3}));
  b.branch(f, g);
  b.branch(g, b.node({0, 0, -4}));
  b.branch(g, h);
  b.branch(h, b.node({2, 0, -5}));
  b.branch(h, b.node({3, 0, -5}));
  const Traits traits = traits_of(as_it_is(b, from_top()));
  const auto at = [&](const Vec3& end, const char* column) {
    return value(traits.branches, column, row_at(traits.branches, "end", end));
  };
  EXPECT_EQ(at({0, 0, -2}, "partition_asymmetry"), 1);
  EXPECT_EQ(at({1, 0, -3}, "partition_asymmetry"), 1);
  EXPECT_EQ(at({2, 0, -4}, "partition_asymmetry"), 0);
  EXPECT_TRUE(std::isnan(at({3, 0, -5}, "partition_asymmetry")));
  EXPECT_DOUBLE_EQ(at({0, 0, -2}, "taper"), 2 * 0.5 / 2);
  EXPECT_EQ(at({0, 0, -2}, "tips"), 4);
  EXPECT_EQ(at({0, 0, -2}, "strahler"), 2);
  EXPECT_NEAR(value(traits.sample, "partition_asymmetry"), 2.0 / 3, 1e-12);
}

TEST(Traits, TopoRoot) {
  const Tree tree = as_it_is(small_plant(), from_top());
  const Table table = toporoot_table(tree, traits_of(tree));
  const std::vector<std::string> names{
      "Index",        "Level",          "Length",          "Geodesic depth", "Average Radius",     "Skeleton edges",
      "Tortuosity",   "Tip Location X", "Tip Location Y",  "Tip Location Z", "Number of Children", "Angle to Gravity",
      "Parent angle", "Tip angle",      "Emergence angle", "Midpoint angle"};
  ASSERT_EQ(table.columns.size(), names.size());
  for (std::size_t i = 0; i < names.size(); ++i) EXPECT_EQ(table.columns[i].name, names[i]);
  ASSERT_EQ(table.rows, 2u);
  EXPECT_EQ(value(table, "Index", 1), 2);
  EXPECT_DOUBLE_EQ(value(table, "Length", 0), 4);
  EXPECT_DOUBLE_EQ(value(table, "Length", 1), 2.5);  // less the radius of the parent
  EXPECT_DOUBLE_EQ(value(table, "Geodesic depth", 1), 6);
  EXPECT_EQ(value(table, "Skeleton edges", 1), 2);
  EXPECT_DOUBLE_EQ(value(table, "Tip Location X", 1), 2);
  EXPECT_EQ(value(table, "Number of Children", 0), 1);
  EXPECT_NEAR(value(table, "Angle to Gravity", 0), 0, 1e-6);
  EXPECT_NEAR(value(table, "Tip angle", 1), std::atan2(2, 1) * 180 / pi, 1e-9);
}

TEST(Traits, OfNothingAndOfAPoint) {
  const Traits none = traits_of({});
  EXPECT_EQ(none.axes.rows + none.branches.rows + none.sample.rows + none.sholl.rows + none.depths.rows, 0u);
  EXPECT_GT(none.sample.columns.size(), 20u);
  Builder b;
  b.node({1, 2, 3}, 0.5);
  const Traits one = traits_of(tree_of(b.repaired(), {}));
  EXPECT_EQ(one.axes.rows, 1u);
  EXPECT_EQ(value(one.sample, "total_length"), 0);
  EXPECT_NEAR(value(one.sample, "volume_balls"), pi / 6, 1e-9);
  EXPECT_TRUE(std::isnan(value(one.axes, "tortuosity")));
}

// Columns whose values do not change, or are lengths to a power, when a tree is turned, moved and made larger.
TEST(Traits, ScaleWithTheTree) {
  std::mt19937 random(4);
  for (int round = 0; round < 20; ++round) {
    SCOPED_TRACE(round);
    const Builder builder = random_forest(random, 25);
    if (builder.graph.nodes.empty()) continue;
    const double scale = 4;
    const Mat3 turn = Eigen::AngleAxisd(0.7 * round, Vec3(2, 1, -1).normalized()).toRotationMatrix();
    HierarchyOptions options;
    Repaired other = builder.repaired();
    other.graph = moved(
        other.graph, [&](const Vec3& x) -> Vec3 { return scale * (turn * x) + Vec3(1, 2, 3); }, scale);
    Tree a = tree_of(builder.repaired(), options);
    options.down = turn * options.down;
    Tree b = tree_of(other, options);
    a.coordinates.units = b.coordinates.units = "m";
    const Traits of_a = traits_of(a), of_b = traits_of(b);
    for (const auto& [x, y] :
         {std::pair{&of_a.axes, &of_b.axes}, {&of_a.branches, &of_b.branches}, {&of_a.sample, &of_b.sample}}) {
      ASSERT_EQ(x->rows, y->rows);
      for (const Table::Column& column : x->columns) {
        const auto* values = std::get_if<std::vector<double>>(&column.values);
        const bool place = column.name.ends_with("_x") || column.name.ends_with("_y") || column.name.ends_with("_z");
        // Boxes, points on balls, and planes are those of the axes of coordinates.
        const bool rough = column.name.find("balls") != std::string::npos ||
                           column.name.find("hull") != std::string::npos || column.name == "fractal_dimension" ||
                           column.name == "solidity" || column.name == "specific_length" ||
                           column.name == "length_density";
        if (!values || place || rough) continue;
        int power = 0;
        for (const int p : {-2, -1, 1, 2, 3})
          if (column.unit == unit_to_the("m", p)) power = p;
        for (std::size_t row = 0; row < x->rows; ++row) {
          const double wanted = (*values)[row] * std::pow(scale, power), got = value(*y, column.name, row);
          if (std::isnan(wanted)) {
            EXPECT_TRUE(std::isnan(got)) << column.name;
          } else {
            EXPECT_NEAR(got, wanted, 1e-6 * (1 + std::abs(wanted))) << column.name << " " << row;
          }
        }
      }
    }
  }
}

TEST(Traits, LengthsSumUp) {
  std::mt19937 random(5);
  for (int round = 0; round < 40; ++round) {
    const Builder builder = random_forest(random, 25);
    const Tree tree = as_it_is(builder, {});
    const Traits traits = traits_of(tree);
    double axes = 0, branches = 0, layers = 0;
    for (std::size_t i = 0; i < traits.axes.rows; ++i) axes += value(traits.axes, "length", i);
    for (std::size_t i = 0; i < traits.branches.rows; ++i) branches += value(traits.branches, "length", i);
    for (std::size_t i = 0; i < traits.depths.rows; ++i) layers += value(traits.depths, "length", i);
    EXPECT_NEAR(axes, branches, 1e-9 * (1 + branches));
    EXPECT_NEAR(layers, branches, 1e-9 * (1 + branches));
    if (traits.sample.rows > 0) {
      EXPECT_NEAR(value(traits.sample, "total_length"), axes, 1e-9 * (1 + axes));
    }
    for (std::size_t i = 0; i < traits.axes.rows; ++i) {
      const double tortuosity = value(traits.axes, "tortuosity", i);
      if (!std::isnan(tortuosity)) {
        EXPECT_GE(tortuosity, 1 - 1e-9);
      }
    }
  }
}

TEST(Traits, Units) {
  EXPECT_EQ(unit_to_the("mm", 2), "mm^2");
  EXPECT_EQ(unit_to_the("mm", 1), "mm");
  EXPECT_EQ(unit_to_the("mm", -1), "mm^-1");
  EXPECT_EQ(unit_to_the("", 3), "");
}

}  // namespace traits_test
}  // namespace quench
