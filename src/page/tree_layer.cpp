// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "page/layer.h"
#include "quench/error.h"

namespace quench {
namespace {

constexpr double kParallel = 0.9;  ///< cosine: an upward direction so near to the line of sight says nothing

void add_numbers(Page& page, const std::string& name, int components, PageArray::Values values) {
  page.arrays.push_back({"tree/" + name, components, std::move(values)});
}

/// The courses of the branches one after the other.
struct Courses {
  std::vector<std::uint32_t> offsets{0}, bridged;
  std::vector<Vec3> points;
  std::vector<float> radius, to_down;
};

/// The radii of a branch that leaves its axis at a fork: inside of the ball there at most what it is where it comes
/// out.
std::vector<double> radii_outside(const Tree::Branch& branch) {
  std::vector<double> radius = branch.radius;
  const double ball = radius.front();
  std::size_t out = 0;
  while (out + 1 < radius.size() && (branch.points[out] - branch.points[0]).norm() < ball) ++out;
  for (std::size_t i = 0; i < out; ++i) radius[i] = std::min(radius[i], radius[out]);
  return radius;
}

/// Degrees between the course at a point and the direction `down`.
double angle_to_down(const std::vector<Vec3>& points, std::size_t i, const Vec3& down) {
  const Vec3 along = points[std::min(i + 1, points.size() - 1)] - points[i > 0 ? i - 1 : 0];
  const double length = along.norm();
  if (!(length > 0)) return std::numeric_limits<double>::quiet_NaN();
  return std::acos(std::clamp(along.dot(down) / length, -1.0, 1.0)) * 180 / std::numbers::pi;
}

Courses courses_of(const Tree& tree) {
  Courses courses;
  for (const Tree::Branch& branch : tree.branches) {
    const bool leaves = branch.parent != kNone && tree.branches[branch.parent].axis != branch.axis;
    const std::vector<double> radius = leaves ? radii_outside(branch) : branch.radius;
    for (std::size_t i = 0; i < branch.points.size(); ++i) {
      if (i < branch.bridged.size() && branch.bridged[i])
        courses.bridged.push_back(static_cast<std::uint32_t>(courses.points.size()));
      courses.points.push_back(branch.points[i]);
      courses.radius.push_back(page::measure_of(radius[i]));
      courses.to_down.push_back(page::measure_of(angle_to_down(branch.points, i, tree.down)));
    }
    courses.offsets.push_back(static_cast<std::uint32_t>(courses.points.size()));
  }
  return courses;
}

void require_whole(const Tree& tree) {
  const bool good = std::ranges::all_of(tree.branches,
                                        [&](const Tree::Branch& b) {
                                          return b.points.size() >= 2 && b.radius.size() == b.points.size() &&
                                                 b.axis < tree.axes.size() && b.bridged.size() < b.points.size() &&
                                                 (b.parent == kNone || b.parent < tree.branches.size());
                                        }) &&
                    std::ranges::all_of(tree.axes, [&](const Tree::Axis& a) {
                      return a.parent == kNone || a.parent < tree.axes.size();
                    });
  if (!good) throw Error(ErrorCode::usage, "the branches and axes of a tree for a page do not fit together");
}

template <class Rows, class Value>
std::vector<std::uint32_t> numbers_of(const Rows& rows, const Value& value) {
  std::vector<std::uint32_t> numbers;
  for (const auto& row : rows) numbers.push_back(value(row));
  return numbers;
}

void add_hierarchy(Page& page, const Tree& tree) {
  using Branch = Tree::Branch;
  using Axis = Tree::Axis;
  const auto of_branches = [&](const char* name, const auto& value) {
    add_numbers(page, std::string("branch_") + name, 1, numbers_of(tree.branches, value));
  };
  of_branches("parent", [](const Branch& b) { return b.parent; });
  of_branches("axis", [](const Branch& b) { return b.axis; });
  of_branches("order", [](const Branch& b) { return b.order; });
  of_branches("strahler", [](const Branch& b) { return b.strahler; });
  const auto of_axes = [&](const char* name, const auto& value) {
    add_numbers(page, std::string("axis_") + name, 1, numbers_of(tree.axes, value));
  };
  of_axes("parent", [](const Axis& a) { return a.parent; });
  of_axes("level", [](const Axis& a) { return a.level; });
  of_axes("plant", [](const Axis& a) { return a.plant; });
}

void add_column(Page& page, const char* table, const Table::Column& column) {
  std::vector<float> values;
  page.tree->columns.push_back(page::column_of(table, column, values));
  add_numbers(page, std::string(table) + "/" + column.name, 1, std::move(values));
}

void add_table(Page& page, const char* name, const Table& table) {
  for (const Table::Column& column : table.columns) add_column(page, name, column);
}

void add_edits(Page& page, const std::string& unit, const std::vector<TreeEdit>& edits) {
  std::vector<Vec3> ends;
  std::vector<std::string> kinds;
  for (const TreeEdit& edit : edits) {
    ends.insert(ends.end(), {edit.from, edit.to});
    kinds.emplace_back(name_of(edit.kind));
  }
  const auto add = [&](const char* name, const std::string& of, const char* meaning, double TreeEdit::*value) {
    std::vector<double> values;
    for (const TreeEdit& edit : edits) values.push_back(edit.*value);
    add_column(page, "edits", {name, of, meaning, std::move(values)});
  };
  add_numbers(page, "edit_points", 3, page::places_of(page, ends));
  add_column(page, "edits", {"kind", "", "What was done", std::move(kinds)});
  add("length", unit, "Of the gap, of the branch that is cut, of the part left out", &TreeEdit::length);
  add("radius", unit, "Of the branch there", &TreeEdit::radius);
  add("cost", "", "By which the choice was made", &TreeEdit::cost);
  add("grey", "", "Mean of the values along a bridge relative to the threshold", &TreeEdit::grey);
}

/// How places spread around their mean, weighted by the length of the courses.
Mat3 spread_of(const Courses& courses) {
  Vec3 mean = Vec3::Zero();
  double length = 0;
  Mat3 spread = Mat3::Zero();
  const auto each = [&](const auto& take) {
    for (std::size_t b = 0; b + 1 < courses.offsets.size(); ++b)
      for (std::size_t i = courses.offsets[b]; i + 1 < courses.offsets[b + 1]; ++i)
        take(0.5 * (courses.points[i] + courses.points[i + 1]), (courses.points[i + 1] - courses.points[i]).norm());
  };
  each([&](const Vec3& at, double weight) {
    mean += weight * at;
    length += weight;
  });
  if (!(length > 0)) return spread;
  mean /= length;
  each([&](const Vec3& at, double weight) { spread += weight * (at - mean) * (at - mean).transpose(); });
  return spread;
}

/// Where the tree is seen from.
void look_at(PageTree& view, const Mat3& spread, bool upright) {
  // Upright, the least spread is looked for across `down` only: along it there is more than anywhere.
  const Mat3 across = Mat3::Identity() - view.down * view.down.transpose();
  const Mat3 seen =
      upright ? Mat3(across * spread * across + (spread.trace() + 1) * view.down * view.down.transpose()) : spread;
  const Eigen::SelfAdjointEigenSolver<Mat3> axes(seen);
  view.to_eye = axes.eigenvectors().col(0);
  // Of the two sides the front, as for shapes.
  if (view.to_eye.dot(Vec3(0.62, -0.72, 0.32)) < 0) view.to_eye = -view.to_eye;
  view.up = -view.down;
  if (std::abs(view.up.dot(view.to_eye)) > kParallel)
    view.up = std::abs(view.to_eye.y()) > kParallel ? Vec3::UnitZ() : Vec3::UnitY();
}

}  // namespace

void add_tree(Page& page, const Tree& tree, const Traits& traits, const std::vector<TreeEdit>& edits, bool upright) {
  require_whole(tree);
  Courses courses = courses_of(tree);
  page::widen(page, courses.points);
  page.tree.emplace();
  page.tree->down = tree.down;
  look_at(*page.tree, spread_of(courses), upright);
  add_numbers(page, "points", 3, page::places_of(page, courses.points));
  add_numbers(page, "point/radius", 1, std::move(courses.radius));
  add_numbers(page, "point/angle_to_down", 1, std::move(courses.to_down));
  add_numbers(page, "branch_offsets", 1, std::move(courses.offsets));
  add_numbers(page, "bridged", 1, std::move(courses.bridged));
  add_hierarchy(page, tree);
  add_table(page, "axes", traits.axes);
  add_table(page, "branches", traits.branches);
  add_table(page, "sample", traits.sample);
  add_edits(page, tree.coordinates.units, edits);
}

}  // namespace quench
