// SPDX-License-Identifier: Apache-2.0
#include "tree/measured_tree.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "tree/polyline_network.h"

namespace quench::tree {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

}  // namespace

CourseMeasures measures_of(std::span<const Vec3> points, std::span<const double> radius) {
  CourseMeasures m;
  if (points.empty()) return m;
  m.chord = (points.back() - points.front()).norm();
  m.min_radius = *std::ranges::min_element(radius);
  m.max_radius = *std::ranges::max_element(radius);
  double sum = 0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const double h = (points[i] - points[i - 1]).norm(), a = radius[i - 1], b = radius[i];
    m.length += h;
    sum += h * (a + b) / 2;
    m.volume += std::numbers::pi / 3 * h * (a * a + a * b + b * b);
    m.surface += std::numbers::pi * (a + b) * std::hypot(h, a - b);
  }
  m.mean_radius = m.length > 0 ? sum / m.length : radius[0];
  if (m.chord > 0) m.tortuosity = m.length / m.chord;
  return m;
}

double degrees_between(const Vec3& a, const Vec3& b) {
  return a.norm() > 0 && b.norm() > 0 ? kDegrees * angle_between(a, b) : kNotDefined;
}

MeasuredTree::MeasuredTree(const Tree& whole)
    : tree(whole),
      children(children_of(whole)),
      branch_start(whole.branches.size(), 0),
      tips(whole.branches.size(), 0) {
  for (const Tree::Branch& b : tree.branches) branch.push_back(measures_of(b.points, b.radius));
  for (std::uint32_t b = 0; b < tree.branches.size(); ++b)
    if (const std::uint32_t p = tree.branches[b].parent; p != kNone)
      branch_start[b] = branch_start[p] + branch[p].length;
  for (std::size_t b = tips.size(); b-- > 0;) {
    if (children[b].empty()) tips[b] = 1;
    if (const std::uint32_t p = tree.branches[b].parent; p != kNone) tips[p] += tips[b];
  }
  for (const Tree::Axis& a : tree.axes) {
    axis.push_back(measures_of(a.points, a.radius));
    axis_start.push_back(a.parent == kNone ? 0 : axis_start[a.parent] + a.position);
    Course& line = course.emplace_back();
    for (std::size_t i = 0; i < a.points.size(); ++i) line.append(a.points[i], a.radius[i]);
  }
}

double MeasuredTree::bridged_length(std::uint32_t b) const {
  const Tree::Branch& of = tree.branches[b];
  double length = 0;
  for (std::size_t s = 0; s < of.bridged.size(); ++s)
    if (of.bridged[s]) length += (of.points[s + 1] - of.points[s]).norm();
  return length;
}

Vec3 emergence_direction(const MeasuredTree& measured, std::uint32_t axis) {
  const Tree::Axis& a = measured.tree.axes[axis];
  const Course& course = measured.course[axis];
  const double own = course.radius()[0];
  const double tube = a.parent == kNone ? own : measured.course[a.parent].radius_at(a.position);
  const double window = tube + 2 * own;
  return course.point_at(window > 0 ? window : course.length()) - course.points()[0];
}

Vec3 tip_direction(const MeasuredTree& measured, std::uint32_t axis) {
  const Course& course = measured.course[axis];
  const double window = 3 * measured.axis[axis].mean_radius;
  return course.points().back() - course.point_at(window > 0 ? std::max(0.0, course.length() - window) : 0);
}

Vec3 direction_at(const Course& course, double length) {
  const double reach = course.radius_at(length);
  const double to = std::min(course.length(), length + reach), from = std::max(0.0, length - reach);
  if (to > from) return course.point_at(to) - course.point_at(from);
  return course.points().back() - course.points()[0];
}

Vec3 principal_direction(const Course& course) {
  Vec3 mean = Vec3::Zero();
  for (const Vec3& p : course.points()) mean += p / static_cast<double>(course.size());
  Mat3 spread = Mat3::Zero();
  for (const Vec3& p : course.points()) spread += (p - mean) * (p - mean).transpose();
  const Vec3 chord = course.points().back() - course.points()[0];
  if (!(spread.norm() > 0)) return Vec3::Zero();
  const Vec3 line = Eigen::SelfAdjointEigenSolver<Mat3>(spread).eigenvectors().col(2);
  return line.dot(chord) < 0 ? Vec3(-line) : line;
}

std::pair<double, double> fork_angles(const MeasuredTree& measured, std::uint32_t branch) {
  const auto at_fork = measured.children[branch];
  const auto end_of = [&](std::uint32_t b, bool first) -> Vec3 {
    const auto& points = measured.tree.branches[b].points;
    for (std::size_t i = 1; first && i < points.size(); ++i)
      if (points[i] != points[0]) return points[i] - points[0];
    return points.back() - points[0];
  };
  double local = 0, remote = 0, pairs = 0;
  for (std::size_t i = 0; i < at_fork.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      local += degrees_between(end_of(at_fork[i], true), end_of(at_fork[j], true));
      remote += degrees_between(end_of(at_fork[i], false), end_of(at_fork[j], false));
      ++pairs;
    }
  return pairs > 0 ? std::pair(local / pairs, remote / pairs) : std::pair(kNotDefined, kNotDefined);
}

double partition_asymmetry(const MeasuredTree& measured, std::uint32_t branch) {
  const auto at_fork = measured.children[branch];
  if (at_fork.size() != 2) return kNotDefined;
  const double a = measured.tips[at_fork[0]], b = measured.tips[at_fork[1]];
  return a + b > 2 ? std::abs(a - b) / (a + b - 2) : 0;
}

}  // namespace quench::tree
