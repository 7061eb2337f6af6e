// SPDX-License-Identifier: Apache-2.0
#include "surface/inside.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace quench::surface {
namespace {

constexpr int kDirections = 64;
constexpr double kGoldenAngle = 2.399963229728653;
constexpr double kSteep = 0.2;      // least sine of the angle between a ray and the triangle it begins at
constexpr double kParallel = 1e-9;  // below this sine a ray and a triangle it meets are parallel
constexpr double kFromEdge = 8;     // in units of `near`: a ray passes an edge too near
constexpr double kSamePlane = 2;    // in units of `near`: the point of a triangle is in the plane of another one

// A spiral over the sphere, in no relation to the axes.
Vec3 direction(int k) {
  const double z = 1 - (2 * k + 1.0) / kDirections, turn = 0.7 + k * kGoldenAngle;
  const double across = std::sqrt(1 - z * z);
  return {across * std::cos(turn), across * std::sin(turn), z};
}

}  // namespace

struct Inside::Ray {
  Vec3 from, along, inverse, normal;  // `normal`: of the facet it begins at
  double begin;                       // a little before the facet

  Ray(const Vec3& p, const Vec3& d, const Vec3& n, double near)
      : from(p), along(d), inverse(d.cwiseInverse()), normal(n), begin(-4 * kSamePlane * near / kSteep) {}

  bool meets(const Bounds& box, double margin) const {
    double enter = begin, leave = std::numeric_limits<double>::infinity();
    for (int a = 0; a < 3; ++a) {
      const double s = (box.low[a] - margin - from[a]) * inverse[a], t = (box.high[a] + margin - from[a]) * inverse[a];
      enter = std::max(enter, std::min(s, t));
      leave = std::min(leave, std::max(s, t));
    }
    return enter <= leave;
  }
};

void Inside::add(const Facet& facet, bool earlier, const Ray& ray, Count& count) const {
  const double slope = facet.normal.dot(ray.along);
  if (std::abs(slope) < kParallel) {
    count.doubtful = true;
    return;
  }
  const Vec3 to = facet.at[0] - ray.from;
  const double t = facet.normal.dot(to) / slope;
  const bool same_plane = facet.height(ray.from, kSamePlane * near_) == 0;
  if (t < 0 && !same_plane) return;
  const Vec3 p = ray.from + t * ray.along;
  const double margin = kFromEdge * near_ + 4 * facet.bend * to.norm() / std::abs(slope);
  double inner = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 side = facet.at[(i + 1) % 3] - facet.at[i];
    inner = std::min(inner, side.cross(p - facet.at[i]).dot(facet.normal) / side.norm());
  }
  if (inner < -margin) return;
  count.doubtful = count.doubtful || inner < margin;
  if (inner < 0) return;
  const int sign = odd_ || slope > 0 ? 1 : -1;
  if (!same_plane) {
    count.beyond += sign;
    return;
  }
  count.at += sign;
  if (earlier) count.first = false;
}

Inside::Count Inside::count(const Ray& ray, std::uint32_t facet) const {
  Count count;
  count.at = 1;
  tree_.visit([&](const Bounds& box) { return ray.meets(box, kFromEdge * near_); },
              [&](std::uint32_t other) {
                if (other != facet && !facets_[other].flat) add(facets_[other], other < facet, ray, count);
              });
  return count;
}

Side Inside::side(const Vec3& p, std::uint32_t facet) const {
  const Vec3& normal = facets_[facet].normal;
  Count found;
  for (int k = 0; k < kDirections; ++k) {
    // Neighbours in the spiral are neighbours on the sphere: a stride without common divisor takes them far apart.
    const Vec3 d = direction(k * 29 % kDirections);
    const double steep = d.dot(normal);
    if (std::abs(steep) < kSteep) continue;
    found = count(Ray(p, steep > 0 ? d : Vec3(-d), normal, near_), facet);
    if (!found.doubtful) break;
  }
  const bool before = in_solid(found.beyond), behind = in_solid(found.beyond + found.at);
  if (before == behind || !found.first) return Side::none;
  return behind ? Side::behind : Side::before;
}

}  // namespace quench::surface
