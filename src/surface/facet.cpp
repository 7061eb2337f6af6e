// SPDX-License-Identifier: Apache-2.0
#include "surface/facet.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace quench::surface {
namespace {

using Heights = std::array<double, 3>;

bool has_corner(const Facet& facet, std::uint32_t corner) {
  return std::find(facet.corner.begin(), facet.corner.end(), corner) != facet.corner.end();
}

// Of the corners of s from the plane of t; a common corner lies in it.
Heights heights(const Facet& s, const Facet& t, double near) {
  Heights of{};
  for (std::size_t i = 0; i < 3; ++i)
    if (!has_corner(t, s.corner[i])) of[i] = t.height(s.at[i], near);
  return of;
}

bool on_one_side(const Heights& h) { return (h[0] > 0 && h[1] > 0 && h[2] > 0) || (h[0] < 0 && h[1] < 0 && h[2] < 0); }
bool in_plane(const Heights& h) { return h[0] == 0 && h[1] == 0 && h[2] == 0; }

// Where the plane cuts the triangle, whose corners are at these heights over it. The end on an edge is the same to the
// bit for both triangles at the edge, so that the segments of neighbours join.
std::optional<std::array<Vec3, 2>> chord(const Facet& s, const Heights& h) {
  std::array<Vec3, 2> ends;
  std::size_t count = 0;
  for (std::size_t i = 0; i < 3 && count < 2; ++i)
    if (h[i] == 0) ends[count++] = s.at[i];
  for (std::size_t i = 0; i < 3 && count < 2; ++i) {
    std::size_t low = i, high = (i + 1) % 3;
    if (!(h[low] * h[high] < 0)) continue;
    if (s.corner[low] > s.corner[high]) std::swap(low, high);
    ends[count++] = s.at[low] + h[low] / (h[low] - h[high]) * (s.at[high] - s.at[low]);
  }
  if (count < 2) return std::nullopt;
  return ends;
}

// Whether a side of s has all of t beyond it, for triangles of one plane.
bool separates(const Facet& s, const Facet& t, double near) {
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 &a = s.at[i], &b = s.at[(i + 1) % 3];
    const Vec3 outward = (b - a).cross(s.normal).normalized();
    if (std::all_of(t.at.begin(), t.at.end(), [&](const Vec3& p) { return outward.dot(p - a) <= near; })) return true;
  }
  return false;
}

}  // namespace

Facet::Facet(const std::array<Vec3, 3>& places, const std::array<std::uint32_t, 3>& corners, double near)
    : at(places), corner(corners) {
  const Vec3 area = (at[1] - at[0]).cross(at[2] - at[0]);
  const double longest2 =
      std::max({(at[1] - at[0]).squaredNorm(), (at[2] - at[1]).squaredNorm(), (at[0] - at[2]).squaredNorm()});
  const double twice = area.norm();
  flat = !(twice > near * std::sqrt(longest2));
  if (flat) return;
  normal = area / twice;
  bend = 8 * std::numeric_limits<double>::epsilon() * longest2 / twice;
}

double Facet::height(const Vec3& p, double near) const {
  const Vec3 from = p - at[0];
  const double h = normal.dot(from);
  return std::abs(h) <= near || std::abs(h) <= near + bend * from.norm() ? 0 : h;
}

Meeting meeting(const Facet& s, const Facet& t, double near) {
  const Heights of_s = heights(s, t, near);
  if (on_one_side(of_s)) return {};
  const Heights of_t = heights(t, s, near);
  if (on_one_side(of_t)) return {};
  if (in_plane(of_s) || in_plane(of_t)) {
    if (separates(s, t, near) || separates(t, s, near)) return {};
    return {Meeting::Kind::overlap, {}};
  }
  if (std::count_if(s.corner.begin(), s.corner.end(), [&](std::uint32_t c) { return has_corner(t, c); }) > 1) return {};
  auto a = chord(s, of_s), b = chord(t, of_t);
  if (!a || !b) return {};
  const Vec3 along = s.normal.cross(t.normal);
  const auto before = [&](const Vec3& p, const Vec3& q) { return along.dot(p) < along.dot(q); };
  for (auto* ends : {&*a, &*b})
    if (before((*ends)[1], (*ends)[0])) std::swap((*ends)[0], (*ends)[1]);
  const Vec3& from = before((*a)[0], (*b)[0]) ? (*b)[0] : (*a)[0];
  const Vec3& to = before((*a)[1], (*b)[1]) ? (*a)[1] : (*b)[1];
  if (!(along.dot(to - from) > near * along.norm())) return {};
  return {Meeting::Kind::segment, {from, to}};
}

}  // namespace quench::surface
