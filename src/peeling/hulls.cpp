// SPDX-License-Identifier: Apache-2.0
#include "peeling/hulls.h"

#include <algorithm>

#include "quench/error.h"

namespace quench::peeling {

void FacetList::close(std::uint32_t tag) {
  const std::uint32_t begin = begin_.back(), end = static_cast<std::uint32_t>(cycle_.size());
  const auto first = cycle_.begin() + begin;
  std::rotate(first, std::min_element(first, cycle_.end()), cycle_.end());
  std::array<std::uint32_t, 3> smallest{cycle_[begin], cycle_[begin + 1], cycle_[begin + 2]};
  if (smallest[1] > smallest[2]) std::swap(smallest[1], smallest[2]);
  for (std::uint32_t i = begin + 3; i < end; ++i)
    if (cycle_[i] < smallest[2]) {
      smallest[2] = cycle_[i];
      if (smallest[1] > smallest[2]) std::swap(smallest[1], smallest[2]);
    }
  facets_.push_back({smallest, tag, begin, end});
  begin_.push_back(end);
}

void FacetList::sort() {
  std::sort(facets_.begin(), facets_.end(), [](const Facet& a, const Facet& b) { return a.smallest > b.smallest; });
  scratch_.clear();
  for (std::size_t f = 0; f < facets_.size(); ++f) {
    scratch_.insert(scratch_.end(), cycle_.begin() + facets_[f].begin, cycle_.begin() + facets_[f].end);
    begin_[f + 1] = static_cast<std::uint32_t>(scratch_.size());
  }
  cycle_.swap(scratch_);
  for (std::size_t f = 0; f < facets_.size(); ++f) {
    facets_[f].begin = begin_[f];
    facets_[f].end = begin_[f + 1];
  }
}

Hulls::Hulls() {
  constexpr std::uint32_t kFacets[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
  for (const bool positive : {true, false}) {
    FacetList facets;
    for (const auto& f : kFacets) {
      for (const std::uint32_t corner : {f[0], positive ? f[1] : f[2], positive ? f[2] : f[1]}) facets.corner(corner);
      facets.close(0);
    }
    facets.sort();
    number_of(4, facets);
  }
}

std::uint32_t Hulls::number_of(std::uint32_t corners, const FacetList& facets) {
  std::vector<std::uint32_t> name{corners};
  for (std::uint32_t f = 0; f < facets.size(); ++f) {
    name.push_back(static_cast<std::uint32_t>(facets[f].size()));
    name.insert(name.end(), facets[f].begin(), facets[f].end());
  }
  const std::lock_guard lock(mutex_);
  if (const auto place = numbers_.find(name); place != numbers_.end()) return place->second;

  Hull hull;
  hull.corners = corners;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> sides;
  for (std::uint32_t f = 0; f < facets.size(); ++f) {
    hull.smallest.push_back(facets.smallest(f));
    for (std::size_t i = 0; i < facets[f].size(); ++i) {
      sides[{facets[f][i], facets[f][(i + 1) % facets[f].size()]}] = static_cast<std::uint32_t>(hull.from.size());
      hull.from.push_back(facets[f][i]);
      hull.facet_of.push_back(f);
    }
    hull.facet_begin.push_back(static_cast<std::uint32_t>(hull.from.size()));
  }
  hull.mate.resize(hull.from.size());
  for (const auto& [ends, side] : sides) {
    const auto mate = sides.find({ends.second, ends.first});
    if (mate == sides.end() || sides.size() != hull.from.size())
      throw Error(ErrorCode::invariant, "the facets of a Delaunay polytope do not close up");
    hull.mate[side] = mate->second;
  }
  const auto number = static_cast<std::uint32_t>(hulls_.size());
  hulls_.push_back(std::move(hull));
  numbers_.emplace(std::move(name), number);
  return number;
}

std::uint32_t HullFinder::number_of(std::uint32_t corners, const FacetList& facets) {
  std::uint64_t hash = corners;
  for (std::uint32_t f = 0; f < facets.size(); ++f) {
    hash = (hash ^ facets[f].size()) * 0x9E3779B97F4A7C15ull;
    for (const std::uint32_t c : facets[f]) hash = (hash ^ (hash >> 29) ^ c) * 0xD1B54A32D192ED03ull;
  }
  const auto same = [&](const Hull& hull) {
    if (hull.corners != corners || hull.facets() != facets.size()) return false;
    for (std::uint32_t f = 0; f < facets.size(); ++f)
      if (!std::ranges::equal(hull.corners_of(f), facets[f])) return false;
    return true;
  };
  const auto [first, last] = by_facets_.equal_range(hash);
  for (auto place = first; place != last; ++place)
    if (same(hulls_[place->second])) return place->second;
  const std::uint32_t number = hulls_.number_of(corners, facets);
  by_facets_.emplace(hash, number);
  return number;
}

std::uint32_t HullFinder::find(std::span<const lattice::Point> points) {
  if (points.size() == 4) {
    // Differences below 2^15: 6 * 2^45 fits 64 bits.
    const auto volume = lattice::orientation_determinant<std::int64_t>(points[0], points[1], points[2], points[3]);
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

// Facets by brute force: three corners whose plane has all others on one side or in it, the three smallest of them.
std::uint32_t HullFinder::compute(std::span<const lattice::Point> points) {
  const auto count = static_cast<std::uint32_t>(points.size());
  const auto side = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    return lattice::orientation_determinant<std::int64_t>(points[a], points[b], points[c], points[d]);
  };
  facets_.clear();
  std::vector<std::uint32_t> in_plane;
  for (std::uint32_t a = 0; a < count; ++a)
    for (std::uint32_t b = a + 1; b < count; ++b)
      for (std::uint32_t c = b + 1; c < count; ++c) {
        bool above = false, below = false, smallest = true;
        in_plane.assign({a, b, c});
        for (std::uint32_t d = 0; d < count && !(above && below) && smallest; ++d) {
          if (d == a || d == b || d == c) continue;
          const auto s = side(a, b, c, d);
          above |= s > 0;
          below |= s < 0;
          if (s == 0) {
            smallest &= d > c;
            in_plane.push_back(d);
          }
        }
        if ((above && below) || !smallest) continue;
        if (!above && !below) return kNone;
        // Counter-clockwise from outside: the corner next to a is the one that has all others on its left, seen from a
        // point off the plane.
        const std::uint32_t off = [&] {
          for (std::uint32_t d = 0;; ++d)
            if (side(a, b, c, d) != 0) return d;
        }();
        std::vector<std::uint32_t> facet{a};
        while (facet.size() < in_plane.size()) {
          const auto next = std::find_if(in_plane.begin(), in_plane.end(), [&](std::uint32_t candidate) {
            if (std::find(facet.begin(), facet.end(), candidate) != facet.end()) return false;
            return std::all_of(in_plane.begin(), in_plane.end(), [&](std::uint32_t other) {
              return other == candidate || other == facet.back() || side(facet.back(), candidate, other, off) < 0;
            });
          });
          if (next == in_plane.end()) throw Error(ErrorCode::invariant, "a facet has corners on one line");
          facet.push_back(*next);
        }
        for (const std::uint32_t corner : facet) facets_.corner(corner);
        facets_.close(0);
      }
  facets_.sort();
  return hulls_.number_of(count, facets_);
}

}  // namespace quench::peeling
