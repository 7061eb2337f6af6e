// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/csr.h"
#include "quench/tree.h"
#include "tree/course.h"

namespace quench::tree {

inline constexpr double kNotDefined = std::numeric_limits<double>::quiet_NaN();

/// What is measured of a polyline with radii.
struct CourseMeasures {
  double length = 0, chord = 0;
  double mean_radius = 0, min_radius = 0, max_radius = 0;  ///< the mean is along the length
  double volume = 0, surface = 0;                          ///< of the frusta between its points, without their ends
  double tortuosity = kNotDefined;                         ///< length over chord
};
CourseMeasures measures_of(std::span<const Vec3> points, std::span<const double> radius);

/// In degrees; NaN where one of the two has no length.
double degrees_between(const Vec3& a, const Vec3& b);

/// A tree with what several tables need.
struct MeasuredTree {
  explicit MeasuredTree(const Tree& tree);

  const Tree& tree;
  base::Csr<std::uint32_t> children;         ///< of branches
  std::vector<CourseMeasures> branch, axis;  ///< measures_of() each
  std::vector<Course> course;                ///< of each axis
  std::vector<double> branch_start;          ///< length from the root node to the base of a branch
  std::vector<double> axis_start;            ///< the same of an axis, along the axes before it
  std::vector<std::uint32_t> tips;           ///< per branch: free ends of it and of what follows it
  double height_of(const Vec3& point) const { return -point.dot(tree.down); }
  double bridged_length(std::uint32_t branch) const;
};

/// The beginning of an axis as a direction: from the centre line of its parent to where it is clear of the parent's
/// tube by its own diameter.
Vec3 emergence_direction(const MeasuredTree& measured, std::uint32_t axis);
/// The direction in which an axis arrives at its tip: over the last three radii, or all of it.
Vec3 tip_direction(const MeasuredTree& measured, std::uint32_t axis);
/// Direction of a course at a length, over one radius to both sides.
Vec3 direction_at(const Course& course, double length);
/// The line through a course's points with the least squares of distances (first principal component), pointing to
/// where the course ends.
Vec3 principal_direction(const Course& course);

/// Local (between first segments) and remote (between far ends) angle in degrees, means over all pairs of branches
/// that begin at the far end of this one; NaN where there are fewer than two.
std::pair<double, double> fork_angles(const MeasuredTree& measured, std::uint32_t branch);
/// |a - b| / (a + b - 2) of the tips behind the two branches of a fork, 0 where each has one; NaN unless there are two.
double partition_asymmetry(const MeasuredTree& measured, std::uint32_t branch);

/// Volume and surface of the union of the balls along courses, half a radius apart, by points on and in the balls,
/// 4096 or more in all but 128 at most for each.
/// Of a tube both are right to about 2 %.
struct BallUnion {
  double volume = 0, surface = 0;
};
BallUnion union_of_balls(std::span<const Course> courses);

/// Volume of the convex hull of points; 0 where they lie in a plane.
double hull_volume(const std::vector<Vec3>& points);
/// The largest distance of two points of a plane: the third coordinate is not looked at.
double widest(std::vector<Vec3> points);
/// Box counting dimension of courses: the slope of log(boxes) over log(1 / side), sides from an eighth of the longest
/// side of the box around them down to a 256th. NaN for courses without length.
double box_dimension(std::span<const Course> courses);

/// Builds a table column by column.
class Columns {
 public:
  explicit Columns(std::size_t rows) { table_.rows = rows; }
  /// `value(row)` is a number, an integer or a text.
  template <class Value>
  void add(std::string name, std::string unit, std::string meaning, const Value& value) {
    using Result = std::decay_t<decltype(value(std::size_t{0}))>;
    using Kept = std::conditional_t<std::is_integral_v<Result>, std::int64_t,
                                    std::conditional_t<std::is_floating_point_v<Result>, double, std::string>>;
    std::vector<Kept> values;
    for (std::size_t row = 0; row < table_.rows; ++row) values.push_back(static_cast<Kept>(value(row)));
    table_.columns.push_back({std::move(name), std::move(unit), std::move(meaning), std::move(values)});
  }
  Table take() { return std::move(table_); }

 private:
  Table table_;
};

Table axes_table(const MeasuredTree& measured);
Table branches_table(const MeasuredTree& measured);
Table sholl_table(const MeasuredTree& measured, double step);
Table depths_table(const MeasuredTree& measured, int bins);
Table sample_table(const MeasuredTree& measured, const Table& axes, const Table& branches, const Table& sholl);

}  // namespace quench::tree
