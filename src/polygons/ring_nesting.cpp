// SPDX-License-Identifier: Apache-2.0
#include "polygons/ring_nesting.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

#include "base/text.h"
#include "polygons/exact_sum.h"

namespace quench::polygons {
namespace {

bool before(const Vec2& a, const Vec2& b) { return a[0] < b[0] || (a[0] == b[0] && a[1] < b[1]); }

/// 1 when c is at the left of the way from a to b, -1 at the right, 0 on their line; exact.
int side(const Vec2& a, const Vec2& b, const Vec2& c) {
  const double left = (a[0] - c[0]) * (b[1] - c[1]), right = (a[1] - c[1]) * (b[0] - c[0]);
  // Shewchuk 1997, sec. 4.3; the second part is for products that underflow.
  const double error = 3.4e-16 * (std::abs(left) + std::abs(right)) + 1e-300;
  if (std::abs(left - right) > error) return left > right ? 1 : -1;
  ExactSum sum;
  sum.add_product(a[0], b[1]);
  sum.add_product(-a[1], b[0]);
  sum.add_product(b[0], c[1]);
  sum.add_product(-b[1], c[0]);
  sum.add_product(c[0], a[1]);
  sum.add_product(-c[1], a[0]);
  return sum.sign();
}

/// An edge that the sweep line crosses.
struct Edge {
  Vec2 left, right;
  std::int32_t winding;  ///< above the edge
};

/// Whether two edges of rings whose points all differ meet elsewhere than in a common end.
bool meet(const Edge& a, const Edge& b) {
  if (a.left == b.left || a.right == b.right || a.left == b.right || a.right == b.left) return false;
  return side(a.left, a.right, b.left) * side(a.left, a.right, b.right) <= 0 &&
         side(b.left, b.right, a.left) * side(b.left, b.right, a.right) <= 0;
}

/// Edges from below to above. Both cross the sweep line and do not meet, so the end that comes later decides.
struct Lower {
  bool operator()(const Edge* a, const Edge* b) const {
    if (a == b) return false;
    if (a->left == b->left) return side(a->left, a->right, b->right) > 0;
    return before(a->left, b->left) ? side(a->left, a->right, b->left) > 0 : side(b->left, b->right, a->left) < 0;
  }
};

class Sweep {
 public:
  Sweep(const Polygons& polygons, PolygonFill fill) : fill_(fill) {
    for (const auto& ring : polygons.rings) {
      const std::size_t first = points_.size();
      for (const Vec2& p : ring)
        if (points_.size() == first || points_.back() != p) points_.push_back(p);
      while (points_.size() > first + 1 && points_.back() == points_[first]) points_.pop_back();
      for (std::size_t i = first; i < points_.size(); ++i) {
        next_.push_back(i + 1 < points_.size() ? i + 1 : first);
        previous_.push_back(i > first ? i - 1 : points_.size() - 1);
        ring_.push_back(rings_);
      }
      ++rings_;
    }
  }

  std::optional<RegionTopology> run() {
    std::vector<std::size_t> order(points_.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return before(points_[a], points_[b]); });
    for (std::size_t i = 1; i < order.size(); ++i)
      if (points_[order[i - 1]] == points_[order[i]]) return {};
    edges_.resize(points_.size());
    places_.resize(points_.size());
    seen_.resize(rings_);
    for (const std::size_t p : order)
      if (!pass(p)) return {};
    return result_;
  }

 private:
  using Status = std::set<Edge*, Lower>;

  bool inside(std::int32_t winding) const { return fill_ == PolygonFill::evenodd ? winding % 2 != 0 : winding != 0; }

  /// False when edges meet. Edge e of a ring runs from point e to next_[e].
  bool pass(std::size_t p) {
    const std::size_t in = previous_[p], out = p;
    const bool in_ends = before(points_[in], points_[p]), out_ends = before(points_[next_[p]], points_[p]);
    if (in_ends && out_ends) return end(in, out);
    if (!in_ends && !out_ends) return begin(p, in, out);
    return in_ends ? go_on(in, out, points_[next_[p]]) : go_on(out, in, points_[in]);
  }

  bool begin(std::size_t p, std::size_t in, std::size_t out) {
    const Vec2 &to_in = points_[in], &to_out = points_[next_[p]];
    const int turn = side(points_[p], to_out, to_in);
    if (turn == 0) return false;
    // Of the lower edge: above it the winding number grows by 1 when the ring goes along it to the right.
    const auto [lower, upper] = turn > 0 ? std::pair(out, in) : std::pair(in, out);
    edges_[in] = {points_[p], to_in, 0};
    edges_[out] = {points_[p], to_out, 0};
    const auto [at, between] = status_.insert(&edges_[lower]);
    if (!between) return false;  // on another edge
    places_[lower] = at;
    const auto above = std::next(at);
    const std::int32_t outer = at == status_.begin() ? 0 : (*std::prev(at))->winding;
    edges_[lower].winding = outer + (turn > 0 ? 1 : -1);
    edges_[upper].winding = outer;
    places_[upper] = status_.insert(above, &edges_[upper]);
    if (std::next(at) != places_[upper] || *places_[upper] != &edges_[upper]) return false;
    if (!std::exchange(seen_[ring_[p]], true)) {
      const bool around = inside(outer), within = inside(edges_[lower].winding);
      if (within && !around) ++result_.components;
      if (around && !within) ++result_.holes;
    }
    return free_below(at) && free_above(places_[upper]);
  }

  bool go_on(std::size_t from, std::size_t to, const Vec2& end) {
    edges_[to] = {edges_[from].right, end, edges_[from].winding};
    const auto above = status_.erase(places_[from]);
    places_[to] = status_.insert(above, &edges_[to]);
    if (std::next(places_[to]) != above || *places_[to] != &edges_[to]) return false;
    return free_below(places_[to]) && free_above(places_[to]);
  }

  bool end(std::size_t in, std::size_t out) {
    auto a = places_[in], b = places_[out];
    if (std::next(a) != b) std::swap(a, b);
    if (std::next(a) != b) return false;
    status_.erase(a);
    const auto above = status_.erase(b);
    return above == status_.end() || above == status_.begin() || !meet(**std::prev(above), **above);
  }

  bool free_below(Status::iterator at) const { return at == status_.begin() || !meet(**std::prev(at), **at); }
  bool free_above(Status::iterator at) const { return std::next(at) == status_.end() || !meet(**at, **std::next(at)); }

  PolygonFill fill_;
  std::vector<Vec2> points_;
  std::vector<std::size_t> next_, previous_, ring_;
  std::size_t rings_ = 0;
  std::vector<Edge> edges_;
  std::vector<Status::iterator> places_;
  std::vector<char> seen_;
  Status status_;
  RegionTopology result_;
};

std::string topology_text(std::int64_t components, std::int64_t holes) {
  return fmt::format("{} and {}", base::counted(components, "part"), base::counted(holes, "hole"));
}

}  // namespace

std::optional<RegionTopology> region_topology(const Polygons& polygons, PolygonFill fill) {
  return Sweep(polygons, fill).run();
}

void note_other_topology(const Polygons& polygons, const VoxelShape& shape, PolygonFill fill, Context* context) {
  if (!context || !context->note) return;
  constexpr std::size_t most = std::size_t{1} << 17;  // a tenth of a second
  std::size_t points = 0;
  for (const auto& ring : polygons.rings) points += ring.size();
  if (points > most) return;
  const auto region = region_topology(polygons, fill);
  if (!region) return;
  const Topology found = topology(shape);
  if (found.betti[0] == region->components && found.betti[1] == region->holes) return;
  note(context,
       fmt::format("the pixels have {}, the polygon {}: it or its gaps are thinner than a pixel somewhere, as at "
                   "sharp tips; use a higher resolution, or drop small components",
                   topology_text(found.betti[0], found.betti[1]), topology_text(region->components, region->holes)));
}

}  // namespace quench::polygons
