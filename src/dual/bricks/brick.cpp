// SPDX-License-Identifier: Apache-2.0
#include "dual/bricks/brick.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "delaunay/circumsphere.h"
#include "delaunay/delaunay.h"
#include "delaunay/polytopes.h"
#include "dual/from_polytopes.h"

namespace quench::dual::bricks {
namespace {

using delaunay::Delaunay;
using delaunay::Tetrahedron;

// Room for rounding when a ball is said to lie in a region, and the same with room for the rounding of another brick,
// which may have computed the ball from other sites on it.
constexpr double kSlack = 1e-9, kSlackForOthers = 1e-6;

Ball ball_of(const std::array<LatticePoint, 4>& sites, const std::array<std::int64_t, 3>& spacing) {
  const delaunay::Circumsphere sphere = delaunay::circumsphere(sites, spacing);
  Vec3 centre = sphere.offset;
  for (int a = 0; a < 3; ++a)
    centre[a] += static_cast<double>(sites[0][static_cast<std::size_t>(a)] * spacing[static_cast<std::size_t>(a)]);
  return {centre, std::sqrt(sphere.squared_radius)};
}

class Worker {
 public:
  Worker(const Brick& brick, Hulls& hulls, Context* context) : brick_(brick), hulls_(hulls), context_(context) {}

  BrickPart run() {
    auto delaunay =
        std::make_unique<Delaunay>(brick_.points, brick_.spacing, brick_.grid.region(brick_.index), context_);
    const std::vector<std::uint8_t> selected = select(*delaunay);
    const auto keep = [&selected](std::uint32_t slot, const Tetrahedron&) { return selected[slot] != 0; };
    polytopes_ = delaunay::polytopes_of(keep, std::move(delaunay), brick_.points, context_);
    certify();
    find_finished();
    choose_carried();
    hand_over();
    return std::move(part_);
  }

 private:
  // In or out, seen from a site that is not finished: there all polytopes inside O are among those of the known sites.
  // Elsewhere the answer only matters when the tetrahedron is part of such a polytope; then all its corners give it.
  bool leads_into_shape(const Delaunay& delaunay, const Tetrahedron& t) const {
    const auto& points = delaunay.points();
    std::uint32_t from = t.corner[0];
    std::array<std::int64_t, 3> direction{};
    for (const std::uint32_t c : t.corner) {
      const delaunay::Point& p = points[c];
      direction[0] += p.x;
      direction[1] += p.y;
      direction[2] += p.z;
      if (brick_.state[p.site] != SiteState::finished) from = c;
    }
    const delaunay::Point& p = points[from];
    direction[0] -= std::int64_t{4} * p.x;
    direction[1] -= std::int64_t{4} * p.y;
    direction[2] -= std::int64_t{4} * p.z;
    return leads_inside(brick_.octants[p.site], direction);
  }

  // The tetrahedra inside O at sites of this brick, and those of the polytopes they are part of. The rest is not
  // needed.
  std::vector<std::uint8_t> select(const Delaunay& delaunay) const {
    const auto& tetrahedra = delaunay.tetrahedra();
    const auto& points = delaunay.points();
    std::vector<std::uint8_t> selected(tetrahedra.size(), 0);
    std::vector<std::uint32_t> border;
    for (std::uint32_t t = 0; t < tetrahedra.size(); ++t) {
      const Tetrahedron& tetrahedron = tetrahedra[t];
      if (tetrahedron.corner[0] == kNone || delaunay.touches_box(tetrahedron)) continue;
      std::uint32_t own = 0;
      for (const std::uint32_t c : tetrahedron.corner) own += is_own(points[c].site);
      if (own == 0 || !leads_into_shape(delaunay, tetrahedron)) continue;
      selected[t] = 1;
      if (own == 1) border.push_back(t);  // with more, every neighbour has an own corner too
    }
    while (!border.empty()) {
      const Tetrahedron& t = tetrahedra[border.back()];
      border.pop_back();
      for (const std::uint32_t across : t.neighbour) {
        const std::uint32_t n = across >> 2;  // no neighbour is on the hull: it does not touch the box
        if (selected[n] || delaunay.touches_box(tetrahedra[n]) || !leads_into_shape(delaunay, tetrahedra[n])) continue;
        if (delaunay.predicates().in_sphere(points[t.corner[0]], points[t.corner[1]], points[t.corner[2]],
                                            points[t.corner[3]], points[tetrahedra[n].corner[across & 3]]) != 0)
          continue;
        selected[n] = 1;
        border.push_back(n);
      }
    }
    return selected;
  }

  bool is_own(std::uint32_t site) const { return brick_.state[site] == SiteState::own; }

  // A polytope at a site of this brick is certain when its ball lies in the region. Others are not needed here.
  void certify() {
    certain_.resize(polytopes_.count());
    for (std::size_t p = 0; p < polytopes_.count(); ++p)
      certain_[p] = std::ranges::any_of(polytopes_.sites_of(p), [&](std::uint32_t s) { return is_own(s); }) &&
                    brick_.grid.certainly_holds(brick_.index, ball(p), kSlack);
  }
  Ball ball(std::size_t p) const {
    const auto& root = polytopes_.tetrahedra[polytopes_.members_of(p)[0]];
    std::array<LatticePoint, 4> corners;
    for (std::size_t i = 0; i < 4; ++i) corners[i] = brick_.points[root.corner[i]];
    return ball_of(corners, brick_.spacing);
  }

  // The square of the boundary of O that a facet is, as seen from the first of three of its sites; 0 when it is not
  // one.
  Squares boundary_square(std::uint32_t at, std::uint32_t p, std::uint32_t q) const {
    return static_cast<Squares>(square_at(brick_.points[at], brick_.points[p], brick_.points[q]) &
                                boundary_squares(brick_.octants[at]));
  }

  // A site is finished when the certain polytopes around it close up: each of their facets leads to another one or lies
  // on the boundary of O, and every square of the boundary is met. Then they fill O near the site.
  void find_finished() {
    const std::size_t count = brick_.points.size();
    std::vector<std::uint8_t> open(count, 0);
    std::vector<Squares> met(count, 0);
    for (std::size_t t = 0; t < polytopes_.tetrahedra.size(); ++t) {
      if (!certain_[polytopes_.polytope_of[t]]) continue;
      const Tetrahedron& tetrahedron = polytopes_.tetrahedra[t];
      for (std::uint32_t i = 0; i < 4; ++i) {
        const std::uint32_t across = tetrahedron.neighbour[i];
        if (across != kNone && certain_[polytopes_.polytope_of[across >> 2]]) continue;
        const auto& facet = delaunay::kFacet[i];
        for (std::uint32_t k = 0; k < 3; ++k) {
          const std::uint32_t at = tetrahedron.corner[facet[k]];
          const Squares square =
              boundary_square(at, tetrahedron.corner[facet[(k + 1) % 3]], tetrahedron.corner[facet[(k + 2) % 3]]);
          met[at] = static_cast<Squares>(met[at] | square);
          open[at] |= square == 0;
        }
      }
    }
    finished_.resize(count);
    for (std::uint32_t s = 0; s < count; ++s) {
      finished_[s] = is_own(s) && !open[s] && met[s] == boundary_squares(brick_.octants[s]);
      if (finished_[s]) part_.finished.push_back(brick_.rank[s]);
    }
  }

  void choose_carried() {
    std::vector<std::uint32_t> ranks;
    for (std::size_t p = 0; p < polytopes_.count(); ++p) {
      if (!certain_[p] || !may_be_needed(p)) continue;
      ranks.clear();
      for (const std::uint32_t s : polytopes_.sites_of(p)) ranks.push_back(brick_.rank[s]);
      part_.carried.add(ranks);
    }
  }

  // Whether a site of the polytope stays unfinished in this round, unless the brick of that site knows it too.
  bool may_be_needed(std::size_t p) const {
    bool others = false;
    for (const std::uint32_t s : polytopes_.sites_of(p)) {
      if (is_own(s) && !finished_[s]) return true;
      others |= brick_.state[s] == SiteState::unfinished;
    }
    if (!others) return false;
    const Ball b = ball(p);
    return std::ranges::any_of(polytopes_.sites_of(p), [&](std::uint32_t s) {
      return brick_.state[s] == SiteState::unfinished &&
             !brick_.grid.certainly_holds(brick_.grid.brick_of(brick_.points[s]), b, kSlackForOthers);
    });
  }

  // The certain polytopes whose smallest sites are finished.
  void hand_over() {
    std::vector<std::uint32_t> number(polytopes_.count(), kNone);
    std::uint32_t next = 0;
    for (std::size_t p = 0; p < polytopes_.count(); ++p)
      if (certain_[p] && finished_[polytopes_.sites_of(p)[0]]) number[p] = next++;
    const auto on_boundary = [this](const std::array<std::uint32_t, 3>& s) {
      return boundary_square(s[0], s[1], s[2]) != 0;
    };
    append(std::move(polytopes_), brick_.points, {brick_.rank, number, on_boundary}, hulls_, part_.found, context_);
  }

  const Brick& brick_;
  Hulls& hulls_;
  Context* context_;
  delaunay::Polytopes polytopes_;
  std::vector<std::uint8_t> certain_;   // per polytope
  std::vector<std::uint8_t> finished_;  // per site
  BrickPart part_;
};

}  // namespace

BrickPart process_brick(const Brick& brick, Hulls& hulls, Context* context) {
  return Worker(brick, hulls, context).run();
}

}  // namespace quench::dual::bricks
