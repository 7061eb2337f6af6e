// SPDX-License-Identifier: Apache-2.0
#include "dual/peel/wrapping.h"

#include <algorithm>
#include <cmath>

namespace quench::dual::peel {

using delaunay::Point;

namespace {

// Centres of neighbouring polytopes that differ less along the normal of their facet are so rare (1 of 150 such facets
// on meshes; more than half of the others lead to a polytope) that it is cheaper to leave them to the triangulation.
// In voxels of the largest spacing.
constexpr double kStep = 1.75;

using Real3 = std::array<double, 3>;

double dot(const Real3& p, const Real3& q) { return p[0] * q[0] + p[1] * q[1] + p[2] * q[2]; }

Real3 cross(const Real3& p, const Real3& q) {
  return {p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]};
}

}  // namespace

Wrapping::Wrapping(std::span<const LatticePoint> sites, const std::array<std::int64_t, 3>& spacing,
                   const delaunay::Predicates& predicates, const SiteIndex& index, double reach)
    : sites_(sites), predicates_(predicates), index_(index), reach_(reach) {
  for (std::size_t i = 0; i < 3; ++i) spacing_[i] = static_cast<double>(spacing[i]);
  step_ = kStep * *std::max_element(spacing_.begin(), spacing_.end());
}

// Above the plane of a, b, c the balls through them grow with the height of their centres: what any of them has there,
// the largest one has too. It only bounds the search: rounding is kept out by margins.
bool Wrapping::limit(const Point& a, const Point& b, const Point& c, std::uint32_t behind, Limit& limit) const {
  Real3 u, v;
  const std::array<std::int32_t, 3> pa{a.x, a.y, a.z}, pb{b.x, b.y, b.z}, pc{c.x, c.y, c.z};
  for (std::size_t i = 0; i < 3; ++i) {
    u[i] = (pb[i] - pa[i]) * spacing_[i];
    v[i] = (pc[i] - pa[i]) * spacing_[i];
  }
  const auto n = cross(u, v);
  const double nn = dot(n, n), uu = dot(u, u), vv = dot(v, v);
  Real3 w;
  for (std::size_t i = 0; i < 3; ++i) w[i] = uu * v[i] - vv * u[i];
  Real3 centre = cross(w, n);  // of the circle, relative to a
  for (double& x : centre) x /= 2 * nn;
  const double rest = reach_ * reach_ - dot(centre, centre);
  if (rest < 0) return false;
  const double height = std::sqrt(rest), circle = std::sqrt(dot(centre, centre)), length = std::sqrt(nn);
  if (behind != kNone) {
    // Its ball is empty, so the balls that are left have their centres between its own and the highest one.
    const LatticePoint& s = sites_[behind];
    const auto known = predicates_.centre(predicates_.sphere(a, c, b, {s[0], s[1], s[2], behind}));
    const double known_height = dot(known, n) / length;
    if (height - known_height < step_) return false;
  }
  limit.level = false;
  for (std::size_t i = 0; i < 3; ++i) {
    const double up = n[i] / length;  // of the unit normal
    limit.centre[i] = centre[i] + height * up;
    const double middle = pa[i] + limit.centre[i] / spacing_[i], half = reach_ / spacing_[i] + 1e-6;
    // Where the plane cuts off the outermost point of the ball along this axis, the circle has the outermost one.
    const double rim = pa[i] + centre[i] / spacing_[i];
    const double wide = circle * std::sqrt(std::max(0.0, 1 - up * up)) / spacing_[i] + 1e-6;
    limit.low[i] = static_cast<std::int32_t>(std::ceil(reach_ * up > height ? rim - wide : middle - half));
    limit.high[i] = static_cast<std::int32_t>(std::floor(-reach_ * up > height ? rim + wide : middle + half));
    const bool level = n[(i + 1) % 3] == 0 && n[(i + 2) % 3] == 0;  // products of integers: exact
    limit.level = limit.level || level;
    if (level && n[i] > 0) limit.low[i] = pa[i] + 1;
    if (level && n[i] < 0) limit.high[i] = pa[i] - 1;
  }
  return true;
}

bool Wrapping::polytope_across(std::span<const std::uint32_t> facet, std::uint32_t behind,
                               std::vector<std::uint32_t>& found) {
  const auto point = [&](std::uint32_t s) { return Point{sites_[s][0], sites_[s][1], sites_[s][2], s}; };
  const Point a = point(facet[0]), b = point(facet[1]), c = point(facet[2]);
  Limit bound;
  if (!limit(a, b, c, behind, bound)) return false;
  // Differences below 2^15 (peeling.cpp sees to it): everything here fits 64 bits.
  const std::int64_t bx = b.x - a.x, by = b.y - a.y, bz = b.z - a.z, cx = c.x - a.x, cy = c.y - a.y, cz = c.z - a.z;
  const std::int64_t nx = by * cz - bz * cy, ny = bz * cx - bx * cz, nz = bx * cy - by * cx;
  const double reach = reach_ * reach_ * (1 + 1e-9) + 1e-6;
  candidates_.clear();
  delaunay::Predicates::Sphere ball;
  index_.each_in_box(bound.low, bound.high,
                     [&](std::int32_t x, std::int32_t y, std::int32_t z, const SiteIndex::Entry& entry) {
                       const std::int32_t dx = x - a.x, dy = y - a.y, dz = z - a.z;
                       if (!bound.level && nx * dx + ny * dy + nz * dz <= 0) return;
                       const double ox = dx * spacing_[0] - bound.centre[0], oy = dy * spacing_[1] - bound.centre[1],
                                    oz = dz * spacing_[2] - bound.centre[2];
                       if (ox * ox + oy * oy + oz * oz > reach) return;
                       const Point p{x, y, z, 0};
                       const int side = candidates_.empty() ? 1 : predicates_.side(ball, p);
                       if (side < 0) return;
                       candidates_.emplace_back(p, entry);
                       if (side > 0) ball = predicates_.sphere(a, b, c, p);
                     });
  if (candidates_.empty()) return false;
  const Real3 centre = predicates_.centre(ball);
  if (dot(centre, centre) > reach_ * reach_) return false;
  found.assign(facet.begin(), facet.end());
  for (const auto& [p, entry] : candidates_)
    if (predicates_.on_sphere(ball, p)) found.push_back(index_.site(entry));
  std::sort(found.begin(), found.end());
  return true;
}

}  // namespace quench::dual::peel
