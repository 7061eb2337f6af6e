// SPDX-License-Identifier: Apache-2.0
#include "dual/hulls.h"

#include <algorithm>
#include <utility>

#include "delaunay/insertion.h"
#include "quench/error.h"

namespace quench::dual {

void sort_facets(std::vector<HullFacet>& facets) {
  for (HullFacet& facet : facets) {
    std::rotate(facet.corners.begin(), std::ranges::min_element(facet.corners), facet.corners.end());
    std::ranges::partial_sort_copy(facet.corners, facet.smallest);
  }
  std::ranges::sort(facets, std::ranges::greater{}, &HullFacet::smallest);
}

Hulls::Hulls() {
  for (const bool positive : {true, false}) {
    std::vector<HullFacet> facets;
    for (const auto& [a, b, c] : delaunay::kFacet) facets.push_back({{a, positive ? b : c, positive ? c : b}});
    sort_facets(facets);
    intern(4, facets);
  }
}

namespace {

Hull hull_of(std::uint32_t corners, std::span<const HullFacet> facets) {
  Hull hull;
  hull.corners = corners;
  std::vector<std::array<std::uint32_t, 3>> halfedges;  // both ends, and which one it is
  for (std::uint32_t f = 0; f < facets.size(); ++f) {
    const auto& cycle = facets[f].corners;
    for (std::size_t i = 0; i < cycle.size(); ++i) {
      halfedges.push_back({cycle[i], cycle[(i + 1) % cycle.size()], static_cast<std::uint32_t>(hull.origin.size())});
      hull.origin.push_back(cycle[i]);
      hull.facet.push_back(f);
    }
    hull.smallest.push_back(facets[f].smallest);
    hull.facet_begin.push_back(static_cast<std::uint32_t>(hull.origin.size()));
  }
  std::ranges::sort(halfedges);
  hull.twin.resize(hull.origin.size(), kNone);
  for (const auto& [from, to, halfedge] : halfedges) {
    const auto twin = std::ranges::lower_bound(halfedges, std::array{to, from, 0u});
    if (twin != halfedges.end() && (*twin)[0] == to && (*twin)[1] == from) hull.twin[halfedge] = (*twin)[2];
  }
  for (std::uint32_t h = 0; h < hull.twin.size(); ++h)  // of two half-edges with the same ends, one has no twin back
    if (hull.twin[h] == kNone || hull.twin[hull.twin[h]] != h)
      throw Error(ErrorCode::invariant, "the facets of a Delaunay polytope do not close up");
  return hull;
}

HullKey key_of(std::span<const HullFacet> facets) {
  std::vector<std::pair<std::uint64_t, bool>> sets;  // corners of each facet, and whether the smallest ascend in it
  for (const HullFacet& facet : facets) {
    std::uint64_t corners = 0;
    for (const std::uint32_t c : facet.corners) corners |= std::uint64_t{1} << c;
    const auto place = [&](std::size_t i) { return std::ranges::find(facet.corners, facet.smallest[i]); };
    sets.emplace_back(corners, place(1) < place(2));
  }
  std::ranges::sort(sets);
  HullKey key;
  for (const auto& [corners, ascend] : sets) key.push_back(corners);
  key.push_back(sets[0].second);
  return key;
}

}  // namespace

std::uint32_t Hulls::find(const HullKey& key) const {
  const std::lock_guard lock(mutex_);
  const auto place = ids_.find(key);
  return place == ids_.end() ? kNone : place->second;
}

std::uint32_t Hulls::intern(std::uint32_t corners, std::span<const HullFacet> facets) {
  const auto add = [&] {
    return static_cast<std::uint32_t>(hulls_.push_back(hull_of(corners, facets)) - hulls_.begin());
  };
  if (corners > kMostCorners) return add();
  HullKey key = key_of(facets);
  const std::lock_guard lock(mutex_);
  if (const auto place = ids_.find(key); place != ids_.end()) return place->second;
  return ids_.emplace(std::move(key), add()).first->second;
}

std::uint32_t HullFinder::find(std::span<const delaunay::Point> points) {
  if (points.size() == 4) {
    // Differences below 2^15: 6 * 2^45 fits 64 bits.
    const auto volume = delaunay::orientation_determinant<std::int64_t>(points[0], points[1], points[2], points[3]);
    return volume == 0 ? kNone : Hulls::kTetrahedron[volume < 0];
  }
  // Differences from -16 to 15 take 5 bits each: 15 for each of up to 8 further points.
  std::array<std::uint64_t, 2> key{points.size(), 0};
  bool small = points.size() <= 9;
  for (std::size_t i = 1; i < points.size() && small; ++i) {
    const std::uint32_t d[3] = {static_cast<std::uint32_t>(points[i].x - points[0].x + 16),
                                static_cast<std::uint32_t>(points[i].y - points[0].y + 16),
                                static_cast<std::uint32_t>(points[i].z - points[0].z + 16)};
    small = (d[0] | d[1] | d[2]) < 32;
    std::uint64_t& word = key[i > 4];
    word = word << 15 | d[0] | d[1] << 5 | d[2] << 10;
  }
  if (!small) return compute(points);
  const auto [place, fresh] = by_points_.emplace(key, 0);
  if (fresh) place->second = compute(points);
  return place->second;
}

namespace {

// Facets of points in convex position, by brute force.
class FacetSearch {
 public:
  explicit FacetSearch(std::span<const delaunay::Point> points) : points_(points) {}

  // None when all points lie in one plane.
  std::vector<HullFacet> run() {
    const auto count = static_cast<std::uint32_t>(points_.size());
    std::vector<HullFacet> facets;
    for (std::uint32_t a = 0; a < count; ++a)
      for (std::uint32_t b = a + 1; b < count; ++b)
        for (std::uint32_t c = b + 1; c < count; ++c) {
          if (!find_plane(a, b, c)) continue;
          if (plane_.size() == count) return {};
          facets.push_back({cycle()});
        }
    sort_facets(facets);
    return facets;
  }

 private:
  std::int64_t side(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) const {
    return delaunay::orientation_determinant<std::int64_t>(points_[a], points_[b], points_[c], points_[d]);
  }

  // Whether a < b < c are the three smallest corners of a facet: all others are on one side of their plane or in it.
  // The corners in the plane are plane_ then, and off_ is one that is not, if there are any.
  bool find_plane(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    plane_.assign({a, b, c});
    std::int64_t first = 0;
    for (std::uint32_t d = 0; d < points_.size(); ++d) {
      if (d == a || d == b || d == c) continue;
      const std::int64_t s = side(a, b, c, d);
      if (s == 0) {
        if (d < c) return false;
        plane_.push_back(d);
      } else if (first == 0) {
        first = s;
        off_ = d;
      } else if ((s < 0) != (first < 0)) {
        return false;
      }
    }
    return true;
  }

  // Corners of the plane, counter-clockwise seen from outside: the next one has all others on its left, seen from a
  // corner off the plane on its right.
  std::vector<std::uint32_t> cycle() const {
    std::vector<std::uint32_t> facet{plane_[0]};
    while (facet.size() < plane_.size()) {
      const auto next = std::ranges::find_if(plane_, [&](std::uint32_t candidate) {
        return std::ranges::find(facet, candidate) == facet.end() &&
               std::ranges::all_of(plane_, [&](std::uint32_t other) {
                 return other == candidate || other == facet.back() || side(facet.back(), candidate, other, off_) < 0;
               });
      });
      if (next == plane_.end()) throw Error(ErrorCode::invariant, "a facet has corners on one line");
      facet.push_back(*next);
    }
    return facet;
  }

  std::span<const delaunay::Point> points_;
  std::vector<std::uint32_t> plane_;
  std::uint32_t off_ = 0;
};

}  // namespace

std::uint32_t HullFinder::compute(std::span<const delaunay::Point> points) {
  const std::vector<HullFacet> facets = FacetSearch(points).run();
  return facets.empty() ? kNone : hulls_.intern(static_cast<std::uint32_t>(points.size()), facets);
}

}  // namespace quench::dual
