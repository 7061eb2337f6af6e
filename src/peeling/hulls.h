// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <tbb/concurrent_vector.h>

#include <array>
#include <cstdint>
#include <map>
#include <mutex>
#include <span>
#include <unordered_map>
#include <vector>

#include "lattice/predicates.h"

namespace quench::peeling {

/// The facets of a convex polytope by the ranks of its corners: what all polytopes with the same facets share. A side
/// is an edge of a facet, walked counter-clockwise seen from outside; each edge of the polytope is two sides.
struct Hull {
  std::uint32_t corners = 0;
  std::vector<std::uint32_t> facet_begin{0};           ///< sides of facet f: [facet_begin[f], facet_begin[f + 1])
  std::vector<std::uint32_t> from;                     ///< per side: the corner it starts at
  std::vector<std::uint32_t> facet_of;                 ///< per side
  std::vector<std::uint32_t> mate;                     ///< per side: the same edge walked the other way
  std::vector<std::array<std::uint32_t, 3>> smallest;  ///< per facet: its three smallest corners, ascending

  std::uint32_t facets() const { return static_cast<std::uint32_t>(smallest.size()); }
  std::uint32_t next(std::uint32_t side) const {
    return side + 1 == facet_begin[facet_of[side] + 1] ? facet_begin[facet_of[side]] : side + 1;
  }
  std::span<const std::uint32_t> corners_of(std::uint32_t facet) const {
    return {from.data() + facet_begin[facet], from.data() + facet_begin[facet + 1]};
  }
};

/// Facets of one polytope while they are collected, each with a tag of the collector's.
class FacetList {
 public:
  void clear() {
    begin_.assign(1, 0);
    cycle_.clear();
    facets_.clear();
  }
  /// Appends a corner to the facet that close() ends. Corners counter-clockwise seen from outside.
  void corner(std::uint32_t rank) { cycle_.push_back(rank); }
  void close(std::uint32_t tag);
  /// Turns the facets to begin with their smallest corners and sorts them, so that equal polytopes have equal lists.
  /// Descending, which puts the facets of a tetrahedron in the order of the corners they leave out.
  void sort();

  std::uint32_t size() const { return static_cast<std::uint32_t>(facets_.size()); }
  std::span<const std::uint32_t> operator[](std::uint32_t f) const {
    return {cycle_.data() + begin_[f], cycle_.data() + begin_[f + 1]};
  }
  std::uint32_t tag(std::uint32_t f) const { return facets_[f].tag; }
  const std::array<std::uint32_t, 3>& smallest(std::uint32_t f) const { return facets_[f].smallest; }

 private:
  struct Facet {
    std::array<std::uint32_t, 3> smallest;
    std::uint32_t tag, begin, end;
  };
  std::vector<std::uint32_t> begin_{0}, cycle_, scratch_;
  std::vector<Facet> facets_;
};

/// All hulls that occurred, each once. Any number of threads.
class Hulls {
 public:
  /// Numbers of the two hulls of four corners: facet i lies opposite to corner i; 0 for corners of positive
  /// orientation.
  static constexpr std::uint32_t kTetrahedron[2] = {0, 1};

  Hulls();
  /// The number of the hull with these sorted facets. Throws Error(invariant) where they do not close up.
  std::uint32_t number_of(std::uint32_t corners, const FacetList& facets);
  const Hull& operator[](std::uint32_t number) const { return hulls_[number]; }

 private:
  tbb::concurrent_vector<Hull> hulls_;  // grows without moving what others read
  std::map<std::vector<std::uint32_t>, std::uint32_t> numbers_;
  std::mutex mutex_;
};

/// Looks hulls up without asking all threads to wait for each other. One per thread.
class HullFinder {
 public:
  static constexpr std::size_t kMostCorners = 24;  ///< of find(): beyond it brute force is no longer the right way
  static constexpr std::uint32_t kNone = 0xFFFFFFFF;

  explicit HullFinder(Hulls& hulls) : hulls_(hulls) {}
  /// The number of the hull of 4 to kMostCorners points in convex position, all differences below 2^15; kNone when they
  /// lie in one plane. O(points^4) for the first points of a kind, which is known by its differences.
  std::uint32_t find(std::span<const lattice::Point> points);
  /// As Hulls::number_of.
  std::uint32_t number_of(std::uint32_t corners, const FacetList& facets);

 private:
  std::uint32_t compute(std::span<const lattice::Point> points);

  struct Hash {
    std::size_t operator()(const std::array<std::uint64_t, 2>& key) const {
      return (key[0] ^ key[1] * 0x9E3779B97F4A7C15ull) * 0xD1B54A32D192ED03ull >> 7;
    }
  };
  Hulls& hulls_;
  std::unordered_map<std::array<std::uint64_t, 2>, std::uint32_t, Hash> by_points_;
  std::unordered_multimap<std::uint64_t, std::uint32_t> by_facets_;
  FacetList facets_;
};

}  // namespace quench::peeling
