// SPDX-License-Identifier: Apache-2.0
#include "verification/plane_boundary.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "verification/nearest_sites.h"

namespace quench::verification {

namespace {

// Directions 0 to 3: along x, along y, and back; one more is a turn to the left when y grows upwards.
constexpr std::array<LatticePoint, 4> kAlong{{{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}}};
// The pixel ahead on the left of a point: of the four around it, seen from their common corner.
constexpr std::array<LatticePoint, 4> kAheadLeft{{{0, 0, 0}, {-1, 0, 0}, {-1, -1, 0}, {0, -1, 0}}};

LatticePoint sum(const LatticePoint& p, const LatticePoint& q) { return {p[0] + q[0], p[1] + q[1], p[2] + q[2]}; }

bool has_pixel(const VoxelShape& shape, const LatticePoint& p) { return shape.contains(p[0], p[1], p[2]); }

}  // namespace

BoundaryCurves::BoundaryCurves(const VoxelShape& shape, const Sites& sites)
    : shape_(shape), sites_(sites), walked_(4 * sites.lattice().size(), 0), places_(2 * sites.lattice().size()) {
  for (std::uint32_t s = 0; s < sites.lattice().size(); ++s)
    for (int d = 0; d < 4; ++d)
      if (const LatticePoint& p = sites.lattice()[s];
          !walked_[4 * std::size_t{s} + static_cast<std::size_t>(d)] && inside_left(p, d) && !inside_right(p, d))
        walk({s, d});
}

bool BoundaryCurves::inside_left(const LatticePoint& p, int direction) const {
  return has_pixel(shape_, sum(p, kAheadLeft[static_cast<std::size_t>(direction)]));
}
bool BoundaryCurves::inside_right(const LatticePoint& p, int direction) const {
  return inside_left(p, (direction + 3) % 4);
}
bool BoundaryCurves::touches_itself(const LatticePoint& p) const {
  return inside_left(p, 0) == inside_left(p, 2) && inside_left(p, 1) == inside_left(p, 3) &&
         inside_left(p, 0) != inside_left(p, 1);
}

std::uint32_t BoundaryCurves::site_at(const LatticePoint& p) const {
  const auto& all = sites_.lattice();
  return static_cast<std::uint32_t>(std::lower_bound(all.begin(), all.end(), p,
                                                     [](const LatticePoint& a, const LatticePoint& b) {
                                                       return std::tie(a[2], a[1], a[0]) < std::tie(b[2], b[1], b[0]);
                                                     }) -
                                    all.begin());
}

BoundaryCurves::Step BoundaryCurves::next(const Step& step) const {
  const LatticePoint p = sum(sites_.lattice()[step.site], kAlong[static_cast<std::size_t>(step.direction)]);
  const int turn = !inside_left(p, step.direction) ? 1 : inside_right(p, step.direction) ? 3 : 0;
  return {site_at(p), (step.direction + turn) % 4};
}

void BoundaryCurves::walk(Step first) {
  const auto curve = static_cast<std::uint32_t>(length_.size());
  std::int64_t way = 0, turns = 0;
  Step step = first;
  do {
    const auto direction = static_cast<std::size_t>(step.direction);
    walked_[4 * std::size_t{step.site} + direction] = 1;
    const LatticePoint& p = sites_.lattice()[step.site];
    const bool after = kAheadLeft[direction][0] == 0;
    place(step.site, after) = {curve, way};
    if (!touches_itself(p)) place(step.site, !after) = {curve, way};
    const Step then = next(step);
    const Point &from = sites_.scaled()[step.site], &to = sites_.scaled()[then.site];
    way += std::abs(to[0] - from[0]) + std::abs(to[1] - from[1]);
    const int turn = (then.direction - step.direction + 4) % 4;
    turns += turn == 3 ? -1 : turn;
    step = then;
  } while (step.site != first.site || step.direction != first.direction);
  length_.push_back(way);
  (turns > 0 ? around_parts_ : around_holes_) += 1;
}

Topology BoundaryCurves::topology() const {
  Topology t;
  t.betti = {around_parts_, around_holes_, 0};
  t.euler = around_parts_ - around_holes_;
  return t;
}

const BoundaryCurves::Place& BoundaryCurves::place_towards(std::uint32_t site, std::uint32_t other) const {
  const bool after = sites_.lattice()[other][0] > sites_.lattice()[site][0];
  return places_[2 * std::size_t{site} + (after ? 1 : 0)];
}

double BoundaryCurves::shorter_way(std::uint32_t a, std::uint32_t b) const {
  const Place &p = place_towards(a, b), &q = place_towards(b, a);
  if (p.curve != q.curve) return std::numeric_limits<double>::infinity();
  const std::int64_t way = std::abs(p.way - q.way);
  return static_cast<double>(std::min(way, length_[p.curve] - way));
}

}  // namespace quench::verification
