// SPDX-License-Identifier: Apache-2.0
#include "tree/repair_polyline.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace quench::tree {
namespace {

// The segment that `at` lies on, and where on it, from 0 to 1.
std::pair<std::size_t, double> segment_at(const std::vector<double>& arc, double at) {
  const auto above = std::upper_bound(arc.begin() + 1, arc.end() - 1, at);
  const auto segment = static_cast<std::size_t>(above - arc.begin()) - 1;
  const double piece = arc[segment + 1] - arc[segment];
  return {segment, piece > 0 ? std::clamp((at - arc[segment]) / piece, 0.0, 1.0) : 0};
}

double between(const std::vector<double>& values, std::size_t segment, double t) {
  const double a = values[segment], b = values[segment + 1];
  if (t == 0 || a == b) return a;
  if (t == 1) return b;
  return std::isinf(a) || std::isinf(b) ? std::min(a, b) : (1 - t) * a + t * b;
}

void add_place(Polyline& to, const Polyline& from, std::size_t segment, double t) {
  to.points.push_back((1 - t) * from.points[segment] + t * from.points[segment + 1]);
  to.radius.push_back(between(from.radius, segment, t));
  if (!from.erosion_thickness.empty()) to.erosion_thickness.push_back(between(from.erosion_thickness, segment, t));
  if (!from.mgf.empty()) to.mgf.push_back(between(from.mgf, segment, t));
}

void append_known(std::vector<double>& to, const std::vector<double>& more) {
  if (to.empty() || more.empty())
    to.clear();
  else
    to.insert(to.end(), more.begin() + 1, more.end());
}

}  // namespace

std::vector<double> Polyline::arc() const {
  std::vector<double> at(points.size(), 0);
  for (std::size_t i = 1; i < points.size(); ++i) at[i] = at[i - 1] + (points[i] - points[i - 1]).norm();
  return at;
}

Polyline polyline_of(const CurveGraph::Branch& branch) {
  Polyline course{branch.points,   branch.radius, branch.erosion_thickness, branch.mgf, branch.vertices, {},
                  branch.thickness};
  if (course.vertices.size() != course.points.size()) course.vertices.clear();
  return course;
}

Polyline straight(const Vec3& a, double radius_a, const Vec3& b, double radius_b, bool bridged) {
  Polyline course;
  course.points = {a, b};
  course.radius = {radius_a, radius_b};
  if (bridged) course.bridged = {1};
  return course;
}

Polyline part_of(const Polyline& course, double begin, double end) {
  const std::vector<double> arc = course.arc();
  if (begin <= 0 && end >= arc.back()) return course;
  Polyline part;
  part.thickness = course.thickness;
  const auto [first, t] = segment_at(arc, std::max(begin, 0.0));
  const auto [last, u] = segment_at(arc, std::max(end, begin));
  add_place(part, course, first, t);
  const Vec3 stop = place_on(course, arc, std::max(end, begin)).point;
  for (std::size_t i = first + 1; i <= last; ++i) {
    if (course.points[i] != part.points.back() && course.points[i] != stop) {
      add_place(part, course, i - 1, 1);
      if (!course.bridged.empty()) part.bridged.push_back(course.bridged[i - 1]);
    }
  }
  add_place(part, course, last, u);
  if (!course.bridged.empty()) part.bridged.push_back(course.bridged[last]);
  return part;
}

Polyline reversed(Polyline course) {
  std::ranges::reverse(course.points);
  std::ranges::reverse(course.radius);
  std::ranges::reverse(course.erosion_thickness);
  std::ranges::reverse(course.mgf);
  std::ranges::reverse(course.vertices);
  std::ranges::reverse(course.bridged);
  return course;
}

void append(Polyline& to, const Polyline& more) {
  if (to.empty()) {
    to = more;
    return;
  }
  if (!to.bridged.empty() || !more.bridged.empty()) {
    to.bridged.resize(to.points.size() - 1, 0);
    to.bridged.insert(to.bridged.end(), more.bridged.begin(), more.bridged.end());
    to.bridged.resize(to.points.size() + more.points.size() - 2, 0);
  }
  to.points.insert(to.points.end(), more.points.begin() + 1, more.points.end());
  to.radius.insert(to.radius.end(), more.radius.begin() + 1, more.radius.end());
  append_known(to.erosion_thickness, more.erosion_thickness);
  append_known(to.mgf, more.mgf);
  if (to.vertices.empty() || more.vertices.empty())
    to.vertices.clear();
  else
    to.vertices.insert(to.vertices.end(), more.vertices.begin() + 1, more.vertices.end());
  to.thickness = std::max(to.thickness, more.thickness);
}

PolylinePlace place_on(const Polyline& course, const std::vector<double>& arc, double at) {
  const auto [segment, t] = segment_at(arc, at);
  return {(1 - t) * course.points[segment] + t * course.points[segment + 1], between(course.radius, segment, t)};
}

}  // namespace quench::tree
