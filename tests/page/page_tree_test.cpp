// SPDX-License-Identifier: Apache-2.0
// The layer `tree` of pages, read back as a browser does.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "page_reader.h"
#include "quench/error.h"
#include "quench/page.h"
#include "quench/pipeline.h"
#include "temporary_folder.h"
#include "tree_of_root.h"

namespace quench {
namespace page_tree_test {

using testing_page::Contents;

Contents read_back(const Page& page) {
  const TemporaryFolder folder;
  write_page(folder / "page.html", page, "<html><body></body></html>");
  return testing_page::read_page(testing_page::bytes_of(folder / "page.html"));
}

struct RootPage {
  Tree tree = testing_trees::tree_of_root(make_sample("root", {.branches = 25}));
  Traits traits = testing_trees::traits_of_root(tree);
  std::vector<TreeEdit> edits;
  Page page() const {
    Page page;
    page.side = 1;
    add_tree(page, tree, traits, edits);
    return page;
  }
};

std::vector<double> doubles(const std::vector<std::uint32_t>& numbers) { return {numbers.begin(), numbers.end()}; }

TEST(PageTree, CoursesAndHierarchyComeBack) {
  RootPage root;
  root.tree.branches[2].bridged.assign(root.tree.branches[2].points.size() - 1, 0);
  root.tree.branches[2].bridged.back() = 1;
  const Contents read = read_back(root.page());
  std::vector<std::uint32_t> offsets{0}, parents, axes, orders, strahler, levels, axis_parents, plants;
  double far = 0;
  for (const Tree::Branch& branch : root.tree.branches) {
    const bool leaves = branch.parent != kNone && root.tree.branches[branch.parent].axis != branch.axis;
    for (std::size_t i = 0; i < branch.points.size(); ++i) {
      const std::size_t row = offsets.back() + i;
      for (int k = 0; k < 3; ++k)
        far = std::max(far, std::abs(read["tree/points"][3 * row + static_cast<std::size_t>(k)] - branch.points[i][k]));
      const double radius = read["tree/point/radius"][row];
      if (leaves)
        EXPECT_LE(radius, branch.radius[i] * (1 + 1e-4));
      else
        EXPECT_NEAR(radius, branch.radius[i], 1e-4 * branch.radius[i]);
    }
    offsets.push_back(offsets.back() + static_cast<std::uint32_t>(branch.points.size()));
    parents.push_back(branch.parent);
    axes.push_back(branch.axis);
    orders.push_back(branch.order);
    strahler.push_back(branch.strahler);
  }
  for (const Tree::Axis& axis : root.tree.axes) {
    levels.push_back(axis.level);
    axis_parents.push_back(axis.parent);
    plants.push_back(axis.plant);
  }
  EXPECT_LT(far, 1e-6);
  EXPECT_EQ(read["tree/branch_offsets"], doubles(offsets));
  EXPECT_EQ(read["tree/branch_parent"], doubles(parents));
  EXPECT_EQ(read["tree/branch_axis"], doubles(axes));
  EXPECT_EQ(read["tree/branch_order"], doubles(orders));
  EXPECT_EQ(read["tree/branch_strahler"], doubles(strahler));
  EXPECT_EQ(read["tree/axis_level"], doubles(levels));
  EXPECT_EQ(read["tree/axis_parent"], doubles(axis_parents));
  EXPECT_EQ(read["tree/axis_plant"], doubles(plants));
  EXPECT_EQ(read["tree/bridged"], std::vector<double>{offsets[3] - 2.0});
}

TEST(PageTree, ABranchIsInsideOfItsAxisNoThickerThanOutside) {
  Tree tree;
  tree.axes.resize(2);
  tree.axes[1].parent = 0;
  tree.axes[1].level = 1;
  const auto branch = [&](std::uint32_t parent, std::uint32_t axis, std::vector<Vec3> points,
                          std::vector<double> radius) {
    Tree::Branch b;
    b.parent = parent;
    b.axis = axis;
    b.points = std::move(points);
    b.radius = std::move(radius);
    tree.branches.push_back(std::move(b));
  };
  branch(kNone, 0, {{0, 0, 0}, {0, 0, -4}}, {2, 2});
  branch(0, 0, {{0, 0, -4}, {0, 0, -8}}, {2, 1});                                         // goes on
  branch(0, 1, {{0, 0, -4}, {1, 0, -4}, {2.5, 0, -4}, {5, 0, -4}}, {2, 1.5, 0.5, 0.75});  // leaves
  Page page;
  add_tree(page, tree, {}, {});
  EXPECT_EQ(std::get<std::vector<float>>(page.find("tree/point/radius")->values),
            (std::vector<float>{2, 2, 2, 1, 0.5F, 0.5F, 0.5F, 0.75F}));
  const auto& angles = std::get<std::vector<float>>(page.find("tree/point/angle_to_down")->values);
  for (std::size_t i = 0; i < 8; ++i) EXPECT_NEAR(angles[i], i < 4 ? 0 : 90, 1e-3);
}

TEST(PageTree, TablesAreThoseOfTheFiles) {
  RootPage root;
  root.tree.coordinates.units = "mm";
  std::get<std::vector<double>>(root.traits.axes.columns[5].values)[3] = std::nan("");
  root.edits.resize(3);
  root.edits[0].kind = TreeEdit::Kind::bridge;
  root.edits[0].from = {1, 2, 3};
  root.edits[0].to = {1, 2, 4};
  root.edits[0].cost = 7;
  root.edits[1].kind = TreeEdit::Kind::left_out;
  root.edits[2].kind = TreeEdit::Kind::bridge;
  const Contents read = read_back(root.page());
  std::map<std::string, nlohmann::json> columns;
  for (const auto& column : read.meta["tree"]["columns"])
    columns[column["table"].get<std::string>() + "/" + column["name"].get<std::string>()] = column;
  for (const auto& [table, name] :
       {std::pair(&root.traits.axes, "axes/"), {&root.traits.branches, "branches/"}, {&root.traits.sample, "sample/"}})
    for (const Table::Column& column : table->columns) {
      SCOPED_TRACE(name + column.name);
      const nlohmann::json& json = columns.at(name + column.name);
      const std::vector<double>& values = read["tree/" + (name + column.name)];
      EXPECT_EQ(json["unit"], column.unit);
      EXPECT_EQ(json["meaning"], column.meaning);
      ASSERT_EQ(values.size(), table->rows);
      for (std::size_t row = 0; row < values.size(); ++row) {
        if (const auto* words = std::get_if<std::vector<std::string>>(&column.values)) {
          EXPECT_EQ(json["words"][static_cast<std::size_t>(values[row])], (*words)[row]);
        } else if (const auto* whole = std::get_if<std::vector<std::int64_t>>(&column.values)) {
          EXPECT_TRUE(json["whole"]);
          EXPECT_EQ(values[row], static_cast<double>((*whole)[row]));
        } else {
          const double x = std::get<std::vector<double>>(column.values)[row];
          EXPECT_TRUE(std::isnan(x) ? std::isnan(values[row])
                                    : values[row] == static_cast<double>(static_cast<float>(x)));
        }
      }
    }
  EXPECT_EQ(columns.at("edits/kind")["words"], (std::vector<std::string>{"bridge", "left_out"}));
  EXPECT_EQ(read["tree/edits/kind"], (std::vector<double>{0, 1, 0}));
  EXPECT_EQ(read["tree/edits/cost"], (std::vector<double>{7, 0, 0}));
  EXPECT_TRUE(std::isnan(read["tree/edits/grey"][0]));
  EXPECT_EQ(columns.at("edits/length")["unit"], "mm");
  ASSERT_EQ(read["tree/edit_points"].size(), 18U);
  EXPECT_NEAR(read["tree/edit_points"][5], 4, 1e-5);
}

/// Two arms along `wide` and a stem along `down`.
Tree cross(const Vec3& down, const Vec3& wide) {
  Tree tree;
  tree.down = down;
  tree.axes.resize(3);
  for (std::uint32_t a = 0; a < 3; ++a) {
    Tree::Branch branch;
    branch.axis = a;
    branch.points = {Vec3::Zero(), a == 0 ? Vec3(4 * down) : a == 1 ? Vec3(2 * wide) : Vec3(-2 * wide)};
    branch.radius = {0.1, 0.1};
    tree.branches.push_back(branch);
  }
  return tree;
}

TEST(PageTree, IsSeenUprightFromItsBroadestSide) {
  for (const auto& [down, wide] : {std::pair<Vec3, Vec3>{-Vec3::UnitZ(), Vec3::UnitX()},
                                   {Vec3::UnitY(), Vec3::UnitZ()},
                                   {Vec3(0.6, 0, -0.8), Vec3(0.8, 0, 0.6)}}) {
    Page page;
    add_tree(page, cross(down, wide), {}, {});
    EXPECT_NEAR(std::abs(page.tree->to_eye.dot(down.cross(wide))), 1, 1e-9);
    EXPECT_LT((page.tree->up + down).norm(), 1e-9);
  }
  // A flat neuron is looked at from above, whatever down is.
  Page flat;
  add_tree(flat, cross(Vec3::UnitX(), Vec3::UnitY()), {}, {}, false);
  EXPECT_NEAR(std::abs(flat.tree->to_eye.z()), 1, 1e-9);
  Page from_above;
  Tree plate = cross(Vec3::UnitX(), Vec3::UnitY());
  plate.down = -Vec3::UnitZ();
  add_tree(from_above, plate, {}, {}, false);
  EXPECT_LT(std::abs(from_above.tree->up.dot(from_above.tree->to_eye)), 0.5);
}

TEST(PageTree, TheBuilderTakesSideAndUnitFromTheTree) {
  RootPage root;
  root.tree.coordinates.units = "mm";
  pipeline::PageBuilder builder;
  builder.add_tree(root.tree, root.traits, {});
  EXPECT_EQ(builder.page.unit, "mm");
  EXPECT_NEAR(builder.page.side, (builder.page.high - builder.page.low).maxCoeff(), 1e-12);
  pipeline::PageBuilder of_shape;
  of_shape.page.unit = "cm";
  of_shape.page.side = 7;
  of_shape.add_tree(root.tree, root.traits, {});
  EXPECT_EQ(of_shape.page.unit, "cm");
  EXPECT_EQ(of_shape.page.side, 7);
}

TEST(PageTree, BranchesThatDoNotFitAreRefused) {
  const auto refused = [](const auto& damage) {
    RootPage root;
    damage(root.tree);
    EXPECT_THROW(root.page(), Error);
  };
  refused([](Tree& tree) { tree.branches[1].radius.pop_back(); });
  refused([](Tree& tree) { tree.branches[1].axis = 999; });
  refused([](Tree& tree) { tree.branches[1].points.resize(1); });
  refused([](Tree& tree) { tree.branches[1].bridged.assign(tree.branches[1].points.size(), 0); });
  refused([](Tree& tree) { tree.axes[1].parent = 999; });
}

}  // namespace page_tree_test
}  // namespace quench
