// SPDX-License-Identifier: Apache-2.0
#include "surface/cutting.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

namespace quench::surface {
namespace {

// Above this number of segments a polygon is halved before it is cut along them: a line along one side of a convex
// curve has all others on one side.
constexpr std::size_t kMany = 32;

double cross(const Vec2& a, const Vec2& b) { return a[0] * b[1] - a[1] * b[0]; }

struct Line {
  Vec2 at, normal;
  double height(const Vec2& p) const { return normal.dot(p - at); }
  Line reversed() const { return {at, -normal}; }
};

Line line_along(const Vec2& a, const Vec2& b) {
  const Vec2 d = (b - a).normalized();
  return {a, {-d[1], d[0]}};
}

Vec2 crossing(const Vec2& a, double ha, const Vec2& b, double hb) { return a + ha / (ha - hb) * (b - a); }

// The parts of a polygon on both sides of a line, that of the normal first; empty where there is nothing beyond `near`.
std::array<Polygon, 2> split(const Polygon& polygon, const Line& line, double near) {
  std::array<Polygon, 2> parts;
  std::array<bool, 2> beyond{};
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec2 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double ha = line.height(a), hb = line.height(b);
    beyond[0] = beyond[0] || ha > near;
    beyond[1] = beyond[1] || ha < -near;
    if (ha >= -near) parts[0].push_back(a);
    if (ha <= near) parts[1].push_back(a);
    if ((ha > near && hb < -near) || (ha < -near && hb > near))
      for (Polygon& part : parts) part.push_back(crossing(a, ha, b, hb));
  }
  for (std::size_t side = 0; side < 2; ++side)
    if (!beyond[side]) parts[side].clear();
  return parts;
}

// The part of a segment on the side of the normal, unless all of it is within `near` of the line or beyond it.
std::optional<Segment> part_of(const Segment& s, const Line& line, double near) {
  const double ha = line.height(s[0]), hb = line.height(s[1]);
  if (ha <= near && hb <= near) return std::nullopt;
  if (ha >= -near && hb >= -near) return s;
  const Vec2 at = crossing(s[0], ha, s[1], hb);
  const Segment part = ha > hb ? Segment{s[0], at} : Segment{at, s[1]};
  if ((part[1] - part[0]).norm() <= near) return std::nullopt;
  return part;
}

std::vector<Segment> parts_of(const std::vector<Segment>& segments, const Line& line, double near) {
  std::vector<Segment> parts;
  for (const Segment& s : segments)
    if (const auto part = part_of(s, line, near)) parts.push_back(*part);
  return parts;
}

// Through the median of the middles of the segments, across the side along which they spread farther.
Line median_line(const std::vector<Segment>& segments) {
  std::vector<Vec2> middles;
  Vec2 low = segments[0][0], high = low;
  for (const Segment& s : segments) {
    middles.emplace_back((s[0] + s[1]) / 2);
    low = low.cwiseMin(middles.back());
    high = high.cwiseMax(middles.back());
  }
  const int axis = high[0] - low[0] >= high[1] - low[1] ? 0 : 1;
  const auto middle = middles.begin() + static_cast<std::ptrdiff_t>(middles.size() / 2);
  std::nth_element(middles.begin(), middle, middles.end(),
                   [&](const Vec2& p, const Vec2& q) { return p[axis] < q[axis]; });
  return {*middle, Vec2::Unit(axis)};
}

void cut_along(const Polygon& polygon, const std::vector<Segment>& segments, double near,
               std::vector<Polygon>& pieces) {
  if (segments.empty()) {
    pieces.push_back(polygon);
    return;
  }
  Line line;
  std::array<std::vector<Segment>, 2> left;
  const auto divide = [&](const Line& by) {
    line = by;
    left = {parts_of(segments, line, near), parts_of(segments, line.reversed(), near)};
    return std::max(left[0].size(), left[1].size());
  };
  if (segments.size() <= kMany || divide(median_line(segments)) * 8 > segments.size() * 7) {
    const Segment& s = segments[segments.size() / 2];
    divide(line_along(s[0], s[1]));
  }
  const std::array<Polygon, 2> parts = split(polygon, line, near);
  for (std::size_t side = 0; side < 2; ++side)
    if (!parts[side].empty()) cut_along(parts[side], left[side], near, pieces);
}

}  // namespace

std::vector<Polygon> cut(const Polygon& polygon, const std::vector<Segment>& segments, double near) {
  std::vector<Segment> inside;
  for (const Segment& s : segments)
    if ((s[1] - s[0]).norm() > near) inside.push_back(s);
  for (std::size_t i = 0; i < polygon.size(); ++i)
    inside = parts_of(inside, line_along(polygon[i], polygon[(i + 1) % polygon.size()]), near);
  std::vector<Polygon> pieces;
  cut_along(polygon, inside, near, pieces);
  return pieces;
}

double width(const Polygon& polygon) {
  double area = 0, perimeter = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec2 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    area += cross(a - polygon[0], b - polygon[0]) / 2;
    perimeter += (b - a).norm();
  }
  return perimeter > 0 ? 2 * area / perimeter : 0;
}

Vec2 centroid(const Polygon& polygon) {
  Vec2 sum = Vec2::Zero();
  double area = 0;
  for (std::size_t i = 1; i + 1 < polygon.size(); ++i) {
    const Vec2 a = polygon[i] - polygon[0], b = polygon[i + 1] - polygon[0];
    const double part = cross(a, b);
    area += part;
    sum += part * (a + b);
  }
  return polygon[0] + sum / (3 * area);
}

}  // namespace quench::surface
