// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "tree/measured_tree.h"

namespace quench {
namespace {

// The beginning of an axis is so many points of its course for TopoRoot.
constexpr std::size_t kEmergencePoints = 30;

}  // namespace

// Names of columns without units: scripts look them up as TopoRoot writes them.
Table toporoot_table(const Tree& tree, const Traits&) {
  const tree::MeasuredTree measured(tree);
  const std::vector<Tree::Axis>& axes = tree.axes;
  std::vector<Vec3> line;
  for (const tree::Course& course : measured.course) line.push_back(tree::principal_direction(course));
  const auto to_down = [&](const Vec3& direction) { return tree::degrees_between(direction, tree.down); };
  const auto from_base = [&](std::size_t a, std::size_t point) {
    const auto& points = axes[a].points;
    return to_down(points[std::min(point, points.size() - 1)] - points[0]);
  };
  // What lies in the parent's tube does not count.
  const auto length = [&](std::size_t a) {
    const double whole = measured.axis[a].length;
    return axes[a].parent == kNone ? whole
                                   : std::max(0.0, whole - measured.course[axes[a].parent].radius_at(axes[a].position));
  };
  tree::Columns columns(axes.size());
  columns.add("Index", "", "Number of the axis, from 1.", [](std::size_t a) { return a + 1; });
  columns.add("Level", "", "Level.", [&](std::size_t a) { return axes[a].level; });
  columns.add("Length", "", "Length less the radius of the parent where it begins.", length);
  columns.add("Geodesic depth", "", "Length from the root node to the tip.",
              [&](std::size_t a) { return measured.axis_start[a] + measured.axis[a].length; });
  columns.add("Average Radius", "", "Mean radius of the points.", [&](std::size_t a) {
    double sum = 0;
    for (const double r : axes[a].radius) sum += r;
    return sum / static_cast<double>(axes[a].radius.size());
  });
  columns.add("Skeleton edges", "", "Segments of the course.",
              [&](std::size_t a) { return axes[a].points.size() - 1; });
  columns.add("Tortuosity", "", "Length over the distance of base and tip.", [&](std::size_t a) {
    return measured.axis[a].chord > 0 ? length(a) / measured.axis[a].chord : tree::kNotDefined;
  });
  constexpr const char* kTips[] = {"Tip Location X", "Tip Location Y", "Tip Location Z"};
  for (int k = 0; k < 3; ++k)
    columns.add(kTips[k], "", "Place of the tip.", [&](std::size_t a) { return axes[a].points.back()[k]; });
  columns.add("Number of Children", "", "Axes that grow from it.",
              [&](std::size_t a) { return axes[a].children.size(); });
  columns.add("Angle to Gravity", "", "Angle of its principal line and down.",
              [&](std::size_t a) { return to_down(line[a]); });
  columns.add("Parent angle", "", "Angle of its principal line and that of the parent; without one: and down.",
              [&](std::size_t a) {
                return axes[a].parent == kNone ? to_down(line[a])
                                               : tree::degrees_between(line[a], line[axes[a].parent]);
              });
  columns.add("Tip angle", "", "Angle of base to tip and down.",
              [&](std::size_t a) { return from_base(a, axes[a].points.size() - 1); });
  columns.add("Emergence angle", "", "Angle of base to the 30th point and down.",
              [&](std::size_t a) { return from_base(a, kEmergencePoints); });
  columns.add("Midpoint angle", "", "Angle of base to the point behind the middle one and down.",
              [&](std::size_t a) { return from_base(a, axes[a].points.size() / 2 + 1); });
  return columns.take();
}

}  // namespace quench
