// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <tbb/concurrent_vector.h>

#include <array>
#include <cstdint>
#include <mutex>
#include <span>
#include <unordered_map>
#include <vector>

#include "base/index.h"
#include "delaunay/predicates.h"

namespace quench::dual {


/// The facets of a convex polytope by the ranks of its corners: what all polytopes with the same facets share. A
/// half-edge is an edge of a facet, directed counter-clockwise seen from outside; its twin is the same edge of the
/// neighbouring facet, directed the other way.
struct Hull {
  std::uint32_t corners = 0;
  std::vector<std::uint32_t> facet_begin{0};  ///< half-edges of facet f: [facet_begin[f], facet_begin[f + 1])
  std::vector<std::uint32_t> origin;          ///< origin[h]: the corner that half-edge h starts at
  std::vector<std::uint32_t> facet;           ///< facet[h]: the facet of half-edge h
  std::vector<std::uint32_t> twin;            ///< twin[h]: of half-edge h
  std::vector<std::array<std::uint32_t, 3>>
      smallest;  ///< smallest[f]: the three smallest corners of facet f, ascending

  std::uint32_t facets() const { return static_cast<std::uint32_t>(smallest.size()); }
  std::uint32_t next(std::uint32_t halfedge) const {
    return halfedge + 1 == facet_begin[facet[halfedge] + 1] ? facet_begin[facet[halfedge]] : halfedge + 1;
  }
  std::span<const std::uint32_t> corners_of(std::uint32_t f) const {
    return {origin.data() + facet_begin[f], origin.data() + facet_begin[f + 1]};
  }
};

/// A facet of a polytope whose hull is looked for.
struct HullFacet {
  std::vector<std::uint32_t> corners;          ///< counter-clockwise seen from outside
  std::uint32_t tag = 0;                       ///< the caller's
  std::array<std::uint32_t, 3> smallest = {};  ///< set by sort_facets()
};

/// Turns the facets to begin with their smallest corners and sorts them, so that equal polytopes have equal lists.
/// Descending, which puts the facets of a tetrahedron in the order of the corners they leave out.
void sort_facets(std::vector<HullFacet>& facets);

/// What tells hulls of up to 64 corners apart: the corners of each facet as bits, ascending, and 1 where the three
/// smallest corners of the first of these facets ascend counter-clockwise, 0 where they do not. The corners of all
/// facets fix the hull but for its mirror image.
using HullKey = std::vector<std::uint64_t>;

struct HashOfWords {
  template <class Words>
  std::size_t operator()(const Words& words) const {
    std::uint64_t hash = 0;
    for (const std::uint64_t word : words) hash = (hash ^ hash >> 29 ^ word) * 0x9E3779B97F4A7C15ull;
    return hash ^ hash >> 32;
  }
};

/// All hulls that occurred. Any number of threads.
class Hulls {
 public:
  /// The two hulls of four corners: facet i lies opposite to corner i; 0 for corners of positive orientation.
  static constexpr std::uint32_t kTetrahedron[2] = {0, 1};

  Hulls();
  static constexpr std::size_t kMostCorners = 64;  ///< of hulls that are recognised; of larger ones each is new

  /// The id of the hull, kNone when it has not occurred.
  std::uint32_t find(const HullKey& key) const;
  /// Returns the id of the hull with these sorted facets, adding it if new. Throws Error(invariant) where they do not
  /// close up.
  std::uint32_t intern(std::uint32_t corners, std::span<const HullFacet> facets);
  const Hull& operator[](std::uint32_t id) const { return hulls_[id]; }

 private:
  tbb::concurrent_vector<Hull> hulls_;  // grows without moving what others read
  std::unordered_map<HullKey, std::uint32_t, HashOfWords> ids_;
  mutable std::mutex mutex_;
};

/// Finds the hulls of points, which it remembers, so that threads seldom wait for each other. One per thread.
class HullFinder {
 public:
  static constexpr std::size_t kMostCorners = 24;  ///< of find(): brute force is too slow for more

  explicit HullFinder(Hulls& hulls) : hulls_(hulls) {}
  /// The id of the hull of 4 to kMostCorners points in convex position, all differences below 2^15; kNone when they lie
  /// in one plane. O(points^4) for the first points of a shape, which is known by its differences.
  std::uint32_t find(std::span<const delaunay::Point> points);

 private:
  std::uint32_t compute(std::span<const delaunay::Point> points);

  Hulls& hulls_;
  std::unordered_map<std::array<std::uint64_t, 2>, std::uint32_t, HashOfWords> by_points_;
};

}  // namespace quench::dual
