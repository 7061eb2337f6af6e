// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include "quench/tree.h"

namespace quench::tree {

/// How far from a fork directions and radii are measured, in radii of its ball: from a third of that on, where the
/// courses are free of it.
inline constexpr double kWindow = 4;

/// A polyline with radii that grows branch by branch.
class Course {
 public:
  void append(const Tree::Branch& branch);
  void append(const Vec3& point, double radius);
  double length() const { return at_.empty() ? 0 : at_.back(); }
  /// From its end back, as far as `length`.
  Course reversed(double length) const;

  std::size_t size() const { return points_.size(); }
  const std::vector<Vec3>& points() const { return points_; }
  const std::vector<double>& radius() const { return radius_; }
  const std::vector<double>& at() const { return at_; }  ///< lengths from the beginning
  /// The point at a length, and the radius there.
  Vec3 point_at(double length) const;
  double radius_at(double length) const;

 private:
  std::pair<std::size_t, double> place(double length) const;
  std::vector<Vec3> points_;
  std::vector<double> radius_, at_;
};

/// The course as a mean of itself over one radius to both sides, weighted by a hat; near its ends over as much as there
/// is on both sides, so that they stay. A straight line stays too.
Course smoothed(const Course& course);

/// The point of a course that is nearest to something.
struct Foot {
  double at = 0;  ///< length along the course
  double distance = std::numeric_limits<double>::infinity();
};
/// Only segments that lie between two lengths, at least in part, are looked at.
Foot nearest_on(const Course& course, const Vec3& point, double low = -std::numeric_limits<double>::infinity(),
                double high = std::numeric_limits<double>::infinity());
/// The same of a ray: a line from a point on, in a direction of length 1.
Foot nearest_to_ray(const Course& course, const Vec3& from, const Vec3& direction, double low, double high);

/// What a course that begins at a fork is like outside of its ball.
struct Window {
  Vec3 direction = Vec3::Zero();  ///< away from the fork
  double radius = 0;
};
/// From a third of the window to its end; where the course is shorter, the window is as long as that.
Window window_of(const Course& course, double ball);

/// Integral of the radius along a course, over a length from its beginning; what lies beyond its end counts 0.
double radius_integral(const Course& course, double length);

/// In radians; of a vector without length it is a right angle.
double angle_between(const Vec3& a, const Vec3& b);

}  // namespace quench::tree
