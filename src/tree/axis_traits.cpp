// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "tree/measured_tree.h"

namespace quench::tree {
namespace {

std::int64_t number_of(std::uint32_t id) { return id == kNone ? -1 : std::int64_t{id}; }

std::string class_of(const Tree::Axis& axis) {
  if (axis.stem) return "stem";
  return axis.level == 0 ? "main" : "level " + std::to_string(axis.level);
}

// Distances between children that follow each other along an axis.
std::vector<double> child_distances(const Tree& tree, const Tree::Axis& axis) {
  std::vector<double> distances;
  for (std::size_t i = 1; i < axis.children.size(); ++i)
    distances.push_back(tree.axes[axis.children[i]].position - tree.axes[axis.children[i - 1]].position);
  return distances;
}

// Where a course becomes less than half as thick as the thickest place before: the mean radius over the next two of
// that place's radii tells, so that a single thin place does not.
double length_of_stem(const Course& course) {
  double thickest = 0;
  for (std::size_t i = 0; i < course.size(); ++i) {
    thickest = std::max(thickest, course.radius()[i]);
    if (course.radius()[i] >= thickest / 2) continue;
    Course rest;
    for (std::size_t k = i; k < course.size() && rest.length() < 2 * thickest; ++k)
      rest.append(course.points()[k], course.radius()[k]);
    const double reach = std::min(2 * thickest, rest.length());
    if (radius_integral(rest, reach) <= thickest / 2 * reach) return course.at()[i];
  }
  return course.length();
}

double mean_of(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v;
  return values.empty() ? kNotDefined : sum / static_cast<double>(values.size());
}

// x, y, z of a point of each row.
template <class Point>
void add_place(Columns& columns, const std::string& what, const std::string& unit, const std::string& meaning,
               const Point& point) {
  constexpr const char* kNames[] = {"_x", "_y", "_z"};
  for (int k = 0; k < 3; ++k)
    columns.add(what + kNames[k], unit, meaning + ": " + "xyz"[k] + ".", [&](std::size_t i) { return point(i)[k]; });
}

void add_measures(Columns& columns, const std::vector<CourseMeasures>& measures, const std::string& unit) {
  const auto add = [&](const char* name, const std::string& of, const char* meaning, double CourseMeasures::*value) {
    columns.add(name, of, meaning, [&](std::size_t i) { return measures[i].*value; });
  };
  add("length", unit, "Length of the course.", &CourseMeasures::length);
  add("chord", unit, "Distance of its two ends.", &CourseMeasures::chord);
  add("tortuosity", "", "Length over chord.", &CourseMeasures::tortuosity);
  add("mean_radius", unit, "Mean radius along the length.", &CourseMeasures::mean_radius);
  add("min_radius", unit, "Smallest radius.", &CourseMeasures::min_radius);
  add("max_radius", unit, "Largest radius.", &CourseMeasures::max_radius);
  add("volume", unit_to_the(unit, 3), "Sum of the frusta between its points.", &CourseMeasures::volume);
  add("surface", unit_to_the(unit, 2), "Sum of the lateral surfaces of these frusta.", &CourseMeasures::surface);
}

}  // namespace

Table axes_table(const MeasuredTree& measured) {
  const Tree& tree = measured.tree;
  const std::vector<Tree::Axis>& axes = tree.axes;
  const std::string unit = tree.coordinates.units, deg = "degrees";
  Columns columns(axes.size());
  columns.add("axis", "", "Number of the axis.", [](std::size_t i) { return i; });
  columns.add("plant", "", "Number of the plant.", [&](std::size_t i) { return axes[i].plant; });
  columns.add("class", "", "stem, main or level n.", [&](std::size_t i) { return class_of(axes[i]); });
  if (std::ranges::any_of(axes, [](const Tree::Axis& a) { return !a.label.empty(); }))
    columns.add("label", "", "Name in the file it was read from.", [&](std::size_t i) { return axes[i].label; });
  columns.add("level", "", "That of the parent and one more; 0 without a parent.",
              [&](std::size_t i) { return axes[i].level; });
  columns.add("parent", "", "The axis it grows from; -1: none.",
              [&](std::size_t i) { return number_of(axes[i].parent); });
  columns.add("children", "", "Axes that grow from it.", [&](std::size_t i) { return axes[i].children.size(); });
  columns.add("branches", "", "Pieces between forks that it consists of.",
              [&](std::size_t i) { return axes[i].branches.size(); });
  columns.add("order", "", "Centrifugal order of its first branch: forks before it.",
              [&](std::size_t i) { return axes[i].branches.empty() ? 0 : tree.branches[axes[i].branches[0]].order; });
  columns.add("strahler", "", "Horton-Strahler number of its first branch.", [&](std::size_t i) {
    return axes[i].branches.empty() ? 1 : tree.branches[axes[i].branches[0]].strahler;
  });
  add_measures(columns, measured.axis, unit);
  std::vector<BallUnion> balls;
  for (const Course& course : measured.course) balls.push_back(union_of_balls({&course, 1}));
  columns.add("volume_balls", unit_to_the(unit, 3), "Volume of the union of its balls.",
              [&](std::size_t i) { return balls[i].volume; });
  columns.add("surface_balls", unit_to_the(unit, 2), "Surface of the union of its balls.",
              [&](std::size_t i) { return balls[i].surface; });
  columns.add("base_radius", unit, "Radius at the base.", [&](std::size_t i) { return axes[i].radius.front(); });
  columns.add("tip_radius", unit, "Radius at the tip.", [&](std::size_t i) { return axes[i].radius.back(); });
  columns.add("path_length", unit, "Length from the root node along the axes to the tip.",
              [&](std::size_t i) { return measured.axis_start[i] + measured.axis[i].length; });
  columns.add("stem_length", unit, "Length of the thick part of an axis of level 0, from its base.",
              [&](std::size_t i) { return axes[i].level == 0 ? length_of_stem(measured.course[i]) : kNotDefined; });
  columns.add("position", unit, "Length along the parent from its base to where this axis leaves it.",
              [&](std::size_t i) { return axes[i].parent == kNone ? kNotDefined : axes[i].position; });
  columns.add("relative_position", "", "Position over the length of the parent.", [&](std::size_t i) {
    const double whole = axes[i].parent == kNone ? 0 : measured.axis[axes[i].parent].length;
    return whole > 0 ? axes[i].position / whole : kNotDefined;
  });
  columns.add("mean_child_distance", unit, "Mean length between children that follow each other.",
              [&](std::size_t i) { return mean_of(child_distances(tree, axes[i])); });
  columns.add("longest_child_distance", unit, "Longest length between children that follow each other.",
              [&](std::size_t i) {
                const std::vector<double> distances = child_distances(tree, axes[i]);
                return distances.empty() ? kNotDefined : *std::ranges::max_element(distances);
              });
  columns.add("child_density", unit_to_the(unit, -1), "Children per length.", [&](std::size_t i) {
    const double length = measured.axis[i].length;
    return length > 0 ? static_cast<double>(axes[i].children.size()) / length : kNotDefined;
  });
  columns.add("gravity_angle", deg, "Angle between base to tip and down.",
              [&](std::size_t i) { return degrees_between(axes[i].points.back() - axes[i].points[0], tree.down); });
  columns.add("parent_angle", deg, "Angle between the first direction and that of the parent there.",
              [&](std::size_t i) {
                if (axes[i].parent == kNone) return kNotDefined;
                return degrees_between(emergence_direction(measured, static_cast<std::uint32_t>(i)),
                                       direction_at(measured.course[axes[i].parent], axes[i].position));
              });
  columns.add("emergence_angle", deg, "Angle between the first direction and down.", [&](std::size_t i) {
    return degrees_between(emergence_direction(measured, static_cast<std::uint32_t>(i)), tree.down);
  });
  columns.add("midpoint_angle", deg, "Angle between base to middle and down.", [&](std::size_t i) {
    const Course& course = measured.course[i];
    return degrees_between(course.point_at(course.length() / 2) - course.points()[0], tree.down);
  });
  columns.add("tip_angle", deg, "Angle between the last direction and down.", [&](std::size_t i) {
    return degrees_between(tip_direction(measured, static_cast<std::uint32_t>(i)), tree.down);
  });
  add_place(columns, "base", unit, "Where it begins, on the course of its parent",
            [&](std::size_t i) { return axes[i].points.front(); });
  add_place(columns, "tip", unit, "Centre of the last ball", [&](std::size_t i) { return axes[i].points.back(); });
  columns.add("tip_depth", unit, "How far the tip lies below the root node.", [&](std::size_t i) {
    return measured.height_of(tree.plants[axes[i].plant].root) - measured.height_of(axes[i].points.back());
  });
  columns.add("bridged_length", unit, "Length of it where the shape has gaps.", [&](std::size_t i) {
    double length = 0;
    for (const std::uint32_t b : axes[i].branches) length += measured.bridged_length(b);
    return length;
  });
  return columns.take();
}

Table branches_table(const MeasuredTree& measured) {
  const Tree& tree = measured.tree;
  const std::vector<Tree::Branch>& branches = tree.branches;
  const std::string unit = tree.coordinates.units, deg = "degrees";
  const auto id = [](std::size_t i) { return static_cast<std::uint32_t>(i); };
  Columns columns(branches.size());
  columns.add("branch", "", "Number of the branch.", [](std::size_t i) { return i; });
  columns.add("parent", "", "The branch at whose far end it begins; -1: a root node.",
              [&](std::size_t i) { return number_of(branches[i].parent); });
  columns.add("axis", "", "The axis it is part of.", [&](std::size_t i) { return branches[i].axis; });
  columns.add("plant", "", "Number of the plant.", [&](std::size_t i) { return branches[i].plant; });
  columns.add("level", "", "Level of its axis.", [&](std::size_t i) { return tree.axes[branches[i].axis].level; });
  columns.add("order", "", "Centrifugal order: forks between the root node and its base.",
              [&](std::size_t i) { return branches[i].order; });
  columns.add("strahler", "", "Horton-Strahler number.", [&](std::size_t i) { return branches[i].strahler; });
  columns.add("type", "", "Structure identifier of SWC; 0: not known.",
              [&](std::size_t i) { return branches[i].type; });
  columns.add("end", "", "What its far end is: fork or tip.",
              [&](std::size_t i) { return std::string(measured.children[i].empty() ? "tip" : "fork"); });
  columns.add("tips", "", "Tips of it and of all behind it.", [&](std::size_t i) { return measured.tips[i]; });
  add_measures(columns, measured.branch, unit);
  columns.add("base_radius", unit, "Radius at the base.", [&](std::size_t i) { return branches[i].radius.front(); });
  columns.add("end_radius", unit, "Radius at the far end.", [&](std::size_t i) { return branches[i].radius.back(); });
  columns.add("path_length", unit, "Length from the root node to the far end.",
              [&](std::size_t i) { return measured.branch_start[i] + measured.branch[i].length; });
  columns.add("taper", "", "Diameter at the base less that at the far end, over the length.", [&](std::size_t i) {
    const double length = measured.branch[i].length;
    return length > 0 ? 2 * (branches[i].radius.front() - branches[i].radius.back()) / length : kNotDefined;
  });
  columns.add("gravity_angle", deg, "Angle between base to far end and down.", [&](std::size_t i) {
    return degrees_between(branches[i].points.back() - branches[i].points[0], tree.down);
  });
  columns.add("local_angle", deg, "Angle between the first segments of the branches at its far end.",
              [&](std::size_t i) { return fork_angles(measured, id(i)).first; });
  columns.add("remote_angle", deg, "Angle at its far end between the far ends of the branches there.",
              [&](std::size_t i) { return fork_angles(measured, id(i)).second; });
  columns.add("partition_asymmetry", "", "|a - b| / (a + b - 2) of the tips behind the two branches at its far end.",
              [&](std::size_t i) { return partition_asymmetry(measured, id(i)); });
  add_place(columns, "base", unit, "Where it begins", [&](std::size_t i) { return branches[i].points.front(); });
  add_place(columns, "end", unit, "Its far end", [&](std::size_t i) { return branches[i].points.back(); });
  columns.add("bridged_length", unit, "Length of it where the shape has a gap.",
              [&](std::size_t i) { return measured.bridged_length(id(i)); });
  return columns.take();
}

}  // namespace quench::tree
