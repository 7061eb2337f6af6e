// SPDX-License-Identifier: Apache-2.0
#include "bricks/brick.h"

#include <algorithm>
#include <memory>

#include "lattice/delaunay.h"
#include "lattice/polytopes.h"
#include "lattice/rings.h"

namespace quench::bricks {
namespace {

using lattice::Delaunay;
using lattice::Int128;
using lattice::kNone;
using lattice::Polytopes;
using lattice::Tetrahedron;

// Room for rounding when a ball is said to lie in a region, and the same with room for the rounding of another brick,
// which may have computed the ball from other sites on it.
constexpr double kSlack = 1e-9, kSlackForOthers = 1e-6;

// The ball of four sites that span space. Its centre relative to the first one is a quotient of integers, so that only
// their conversion and the division round. Differences below 2^14: terms below 3 * 2^28 * 2 * 2^28.
template <class Integer>
Ball ball_of(const std::array<std::array<std::int64_t, 3>, 4>& corner) {
  std::array<std::array<Integer, 3>, 3> d, normal;
  std::array<Integer, 3> square{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t a = 0; a < 3; ++a) {
      d[i][a] = corner[i + 1][a] - corner[0][a];
      square[i] += d[i][a] * d[i][a];
    }
  for (std::size_t i = 0; i < 3; ++i) {
    const auto &u = d[(i + 1) % 3], &v = d[(i + 2) % 3];
    normal[i] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
  }
  const Integer volume = d[0][0] * normal[0][0] + d[0][1] * normal[0][1] + d[0][2] * normal[0][2];
  Vec3 offset;
  for (std::size_t a = 0; a < 3; ++a)
    offset[static_cast<Eigen::Index>(a)] =
        static_cast<double>(square[0] * normal[0][a] + square[1] * normal[1][a] + square[2] * normal[2][a]) /
        (2 * static_cast<double>(volume));
  const Vec3 first(static_cast<double>(corner[0][0]), static_cast<double>(corner[0][1]),
                   static_cast<double>(corner[0][2]));
  return {first + offset, offset.norm()};
}

Ball ball_of(const std::array<LatticePoint, 4>& sites, const std::array<std::int64_t, 3>& spacing) {
  std::array<std::array<std::int64_t, 3>, 4> corner;
  std::int64_t largest = 0;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t a = 0; a < 3; ++a) {
      corner[i][a] = sites[i][a] * spacing[a];
      largest = std::max(largest, std::abs(corner[i][a] - corner[0][a]));
    }
  return largest < 1 << 14 ? ball_of<std::int64_t>(corner) : ball_of<Int128>(corner);
}

class Worker {
 public:
  Worker(const Brick& brick, Context* context) : brick_(brick), context_(context) {}

  BrickPart run() {
    const auto [low, high] = brick_.grid.region(brick_.index);
    auto delaunay = std::make_unique<Delaunay>(brick_.points, brick_.spacing, low, high, context_);
    const std::vector<std::uint8_t> selected = select(*delaunay);
    const auto keep = [&selected](std::uint32_t slot, const Tetrahedron&) { return selected[slot] != 0; };
    polytopes_ = lattice::polytopes_of(keep, std::move(delaunay), brick_.points, context_);
    certify();
    find_finished();
    collect_vertices();
    collect_edges();
    collect_faces();
    return std::move(part_);
  }

 private:
  // In or out, seen from a site that is not finished: there all cells inside O are among those of the known sites.
  // Elsewhere the answer only matters when the tetrahedron is part of such a cell; then all its corners give it.
  bool leads_into_shape(const Delaunay& delaunay, const Tetrahedron& t) const {
    const auto& points = delaunay.points();
    std::uint32_t from = t.corner[0];
    std::array<std::int64_t, 3> direction{};
    for (const std::uint32_t c : t.corner) {
      const lattice::Point& p = points[c];
      direction[0] += p.x;
      direction[1] += p.y;
      direction[2] += p.z;
      if (brick_.role[p.site] != Role::known) from = c;
    }
    const lattice::Point& p = points[from];
    direction[0] -= std::int64_t{4} * p.x;
    direction[1] -= std::int64_t{4} * p.y;
    direction[2] -= std::int64_t{4} * p.z;
    return leads_inside(brick_.octants[p.site], direction);
  }

  // The tetrahedra inside O at sites of this brick, and those of the cells they are part of. The rest is of no use.
  std::vector<std::uint8_t> select(const Delaunay& delaunay) const {
    const auto& tetrahedra = delaunay.tetrahedra();
    const auto& points = delaunay.points();
    std::vector<std::uint8_t> selected(tetrahedra.size(), 0);
    std::vector<std::uint32_t> border;
    for (std::uint32_t t = 0; t < tetrahedra.size(); ++t) {
      const Tetrahedron& tetrahedron = tetrahedra[t];
      if (tetrahedron.corner[0] == kNone || delaunay.touches_box(tetrahedron)) continue;
      std::uint32_t own = 0;
      for (const std::uint32_t c : tetrahedron.corner) own += brick_.role[points[c].site] == Role::own;
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

  std::span<const std::uint32_t> sites_of(std::size_t p) const {
    return {polytopes_.sites.data() + polytopes_.site_offsets[p],
            polytopes_.sites.data() + polytopes_.site_offsets[p + 1]};
  }
  const Tetrahedron& root_of(std::size_t p) const {
    return polytopes_.tetrahedra[polytopes_.members[polytopes_.member_offsets[p]]];
  }

  // A cell at a site of this brick is certain when its ball lies in the region. Others are of no use here.
  void certify() {
    certain_.resize(polytopes_.count());
    for (std::size_t p = 0; p < polytopes_.count(); ++p) {
      const auto sites = sites_of(p);
      certain_[p] = std::any_of(sites.begin(), sites.end(), [&](auto s) { return brick_.role[s] == Role::own; }) &&
                    brick_.grid.certainly_holds(brick_.index, ball(p), kSlack);
    }
  }
  Ball ball(std::size_t p) const {
    std::array<LatticePoint, 4> corners;
    for (std::size_t i = 0; i < 4; ++i) corners[i] = brick_.points[root_of(p).corner[i]];
    return ball_of(corners, brick_.spacing);
  }

  // A site is finished when the certain cells around it close up: each of their facets leads to another one or lies on
  // the boundary of O, and every square of the boundary is met. Then they fill O near the site.
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
        const auto& facet = lattice::kFacet[i];
        for (std::uint32_t k = 0; k < 3; ++k) {
          const std::uint32_t at = tetrahedron.corner[facet[k]];
          const Squares square =
              static_cast<Squares>(square_at(brick_.points[at], brick_.points[tetrahedron.corner[facet[(k + 1) % 3]]],
                                             brick_.points[tetrahedron.corner[facet[(k + 2) % 3]]]) &
                                   boundary_squares(brick_.octants[at]));
          met[at] = static_cast<Squares>(met[at] | square);
          open[at] |= square == 0;
        }
      }
    }
    finished_.resize(count);
    for (std::size_t s = 0; s < count; ++s) {
      finished_[s] = brick_.role[s] == Role::own && !open[s] && met[s] == boundary_squares(brick_.octants[s]);
      if (finished_[s]) part_.finished.push_back(brick_.rank[s]);
    }
  }

  void append(SiteLists& lists, std::span<const std::uint32_t> sites) const {
    for (const std::uint32_t s : sites) lists.sites.push_back(brick_.rank[s]);
    lattice::check_index(lists.sites.size());
    lists.offsets.push_back(static_cast<std::uint32_t>(lists.sites.size()));
  }

  void collect_vertices() {
    number_.assign(polytopes_.count(), kNone);
    for (std::size_t p = 0; p < polytopes_.count(); ++p) {
      if (!certain_[p]) continue;
      const auto sites = sites_of(p);
      if (finished_[sites.front()]) {
        number_[p] = static_cast<std::uint32_t>(part_.vertices.count());
        append(part_.vertices, sites);
      }
      if (may_be_needed(p, sites)) append(part_.known, sites);
    }
  }

  // Whether a site of the cell stays unfinished in this round, unless the brick of that site knows the cell too.
  bool may_be_needed(std::size_t p, std::span<const std::uint32_t> sites) const {
    bool others = false;
    for (const std::uint32_t s : sites) {
      if (brick_.role[s] == Role::own && !finished_[s]) return true;
      others |= brick_.role[s] == Role::unfinished;
    }
    if (!others) return false;
    const Ball b = ball(p);
    return std::any_of(sites.begin(), sites.end(), [&](std::uint32_t s) {
      return brick_.role[s] == Role::unfinished &&
             !brick_.grid.certainly_holds(brick_.grid.brick_of(brick_.points[s]), b, kSlackForOthers);
    });
  }

  // The number of a certain polytope in the part.
  std::uint32_t number(std::uint32_t p) {
    if (number_[p] == kNone) {
      number_[p] = static_cast<std::uint32_t>(part_.vertices.count() + part_.elsewhere.size());
      std::array<std::uint32_t, 4> key = root_of(p).corner;  // it has the smallest site of the polytope
      for (std::uint32_t& s : key) s = brick_.rank[s];
      std::sort(key.begin(), key.end());
      part_.elsewhere.push_back(key);
    }
    return number_[p];
  }

  // Facets between certain cells, where their smallest site is finished.
  void collect_edges() {
    struct Facet {
      std::uint32_t across, smallest;
      bool operator<(const Facet& other) const {
        return across != other.across ? across < other.across : smallest < other.smallest;
      }
    };
    std::vector<Facet> facets;
    for (std::uint32_t p = 0; p < polytopes_.count(); ++p) {
      if (!certain_[p]) continue;
      facets.clear();
      for (std::uint32_t m = polytopes_.member_offsets[p]; m < polytopes_.member_offsets[p + 1]; ++m) {
        const Tetrahedron& t = polytopes_.tetrahedra[polytopes_.members[m]];
        for (std::uint32_t i = 0; i < 4; ++i) {
          if (t.neighbour[i] == kNone) continue;
          const std::uint32_t q = polytopes_.polytope_of[t.neighbour[i] >> 2];
          if (q <= p || !certain_[q]) continue;
          const auto& f = lattice::kFacet[i];
          facets.push_back({q, std::min({t.corner[f[0]], t.corner[f[1]], t.corner[f[2]]})});
        }
      }
      // A facet of more than three corners is met once per triangle of it; the first one has its smallest corner.
      std::sort(facets.begin(), facets.end());
      for (std::size_t i = 0; i < facets.size(); ++i)
        if ((i == 0 || facets[i].across != facets[i - 1].across) && finished_[facets[i].smallest])
          part_.edges.push_back({number(p), number(facets[i].across)});
    }
  }

  void collect_faces() {
    struct Name {
      std::uint32_t list, face;
    };
    const std::vector<lattice::RawFaces> raw = lattice::collect_faces(polytopes_, finished_, context_);
    std::vector<Name> order;
    std::size_t corners = 0;
    for (std::uint32_t list = 0; list < raw.size(); ++list) {
      for (std::uint32_t f = 0; f < raw[list].sites.size(); ++f) order.push_back({list, f});
      corners += raw[list].corners.size();
    }
    lattice::check_index(corners);
    std::sort(order.begin(), order.end(),
              [&](const Name& a, const Name& b) { return raw[a.list].sites[a.face] < raw[b.list].sites[b.face]; });
    part_.face_sites.reserve(order.size());
    part_.face_offsets.reserve(order.size() + 1);
    part_.face_corners.reserve(corners);
    for (const auto& [list, face] : order) {
      const lattice::RawFaces& faces = raw[list];
      const auto& [a, b] = faces.sites[face];
      part_.face_sites.push_back({brick_.rank[a], brick_.rank[b]});
      for (std::uint32_t c = faces.offsets[face]; c < faces.offsets[face + 1]; ++c)
        part_.face_corners.push_back(number(faces.corners[c]));
      part_.face_offsets.push_back(static_cast<std::uint32_t>(part_.face_corners.size()));
    }
  }

  const Brick& brick_;
  Context* context_;
  Polytopes polytopes_;
  std::vector<std::uint8_t> certain_;   // per polytope
  std::vector<std::uint8_t> finished_;  // per site
  std::vector<std::uint32_t> number_;   // per polytope, in the part; kNone: not yet
  BrickPart part_;
};

}  // namespace

BrickPart work(const Brick& brick, Context* context) { return Worker(brick, context).run(); }

}  // namespace quench::bricks
