// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <utility>
#include <vector>

#include "base/parallel.h"
#include "delaunay/delaunay.h"
#include "dual/cells.h"
#include "dual/known_box.h"
#include "quench/error.h"

/// The polytopes that unmatched facets enclose, in the triangulation of the unfinished sites.
namespace quench::dual {

/// Unmatched facets by their triangles. A triangle is found by its smallest corner. `Facets`: size() facets,
/// corners(facet) in cyclic order, counter-clockwise seen from the unknown side. Their sites are renumbered: number[s]
/// below `numbers` instead of s, kNone where facets of the site are not looked for.
template <class Facets>
class TriangleIndex {
 public:
  struct Found {
    bool any;
    bool counter_clockwise;  // seen from the unknown side of the facet
  };

  TriangleIndex(const Facets& facets, std::vector<std::uint32_t> number, std::size_t numbers)
      : facets_(facets), number_(std::move(number)) {
    const bool shared = base::several_threads();
    begin_.assign(numbers + 1, 0);
    each_entry([&](std::uint32_t site, const Entry&) { base::fetch_add(begin_[site + 1], 1u, shared); });
    base::prefix_sum(begin_);
    entries_.resize(begin_.back());
    std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
    each_entry(
        [&](std::uint32_t site, const Entry& entry) { entries_[base::fetch_add(next[site], 1u, shared)] = entry; });
  }

  Found find(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
    bool even = true;
    const auto order = [&even](std::uint32_t& i, std::uint32_t& j) {
      if (i < j) return;
      std::swap(i, j);
      even = !even;
    };
    order(a, b);
    order(b, c);
    order(a, b);
    for (std::uint32_t i = begin_[a]; i < begin_[a + 1]; ++i) {
      const Entry& entry = entries_[i];
      if (entry.second == b && entry.third == c) return {true, (entry.facet & 1) == even};
      if (entry.second != kNone) continue;
      const auto corners = facets_.corners(entry.facet);
      std::size_t at[3] = {corners.size(), corners.size(), corners.size()};
      for (std::size_t k = 0; k < corners.size(); ++k)
        for (std::size_t j = 0; j < 3; ++j)
          if (number_[corners[k]] == (j == 0 ? a : j == 1 ? b : c)) at[j] = k;
      if (at[1] == corners.size() || at[2] == corners.size()) continue;
      return {true, in_order(at[0], at[1], at[2]) == even};
    }
    return {false, false};
  }

 private:
  // A triangle: its larger corners, and 2 * facet + 1 where (smallest, second, third) runs counter-clockwise. For
  // facets of many corners `second` is kNone, and the triangle's corners are looked up in the facet.
  struct Entry {
    std::uint32_t second, third, facet;
  };
  static constexpr std::size_t kFew = 6;

  // Whether three places of a cycle follow each other in its direction.
  static bool in_order(std::size_t i, std::size_t j, std::size_t k) { return (i < j) + (j < k) + (k < i) == 2; }

  template <class Visit>
  void each_entry(const Visit& visit) const {
    const std::size_t chunks = base::chunks_for(facets_.size());
    tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
      const auto [first, last] = base::part_of(facets_.size(), chunk, chunks);
      each_entry(first, last, visit);
    });
  }
  template <class Visit>
  void each_entry(std::size_t first, std::size_t last, const Visit& visit) const {
    std::vector<std::pair<std::uint32_t, std::size_t>> sorted;  // corners and their places in the cycle
    for (auto f = static_cast<std::uint32_t>(first); f < last; ++f) {
      const auto corners = facets_.corners(f);
      sorted.clear();
      for (std::size_t i = 0; i < corners.size(); ++i) sorted.emplace_back(number_[corners[i]], i);
      std::sort(sorted.begin(), sorted.end());
      if (sorted.back().first == kNone) continue;
      for (std::size_t i = 0; i + 2 < sorted.size(); ++i) {
        if (sorted.size() > kFew) {
          visit(sorted[i].first, Entry{kNone, kNone, f});
          continue;
        }
        for (std::size_t j = i + 1; j + 1 < sorted.size(); ++j)
          for (std::size_t k = j + 1; k < sorted.size(); ++k)
            visit(sorted[i].first, Entry{sorted[j].first, sorted[k].first,
                                         2 * f + in_order(sorted[i].second, sorted[j].second, sorted[k].second)});
      }
    }
  }

  const Facets& facets_;
  std::vector<std::uint32_t> number_;  // per site
  std::vector<std::uint32_t> begin_;
  std::vector<Entry> entries_;
};

/// Bits of tetrahedra that threads set at the same time. Bit i < 4: facet i is unmatched.
class Marks {
 public:
  static constexpr std::uint32_t kKept = 16;

  explicit Marks(std::size_t count) : marks_(count, 0), shared_(base::several_threads()) {}

  // Returns what it was before.
  std::uint32_t set(std::uint32_t t, std::uint32_t bits) {
    const auto more = static_cast<std::uint8_t>(bits);
    if (shared_) return std::atomic_ref<std::uint8_t>(marks_[t]).fetch_or(more, std::memory_order_relaxed);
    return std::exchange(marks_[t], static_cast<std::uint8_t>(marks_[t] | more));
  }
  std::uint32_t get(std::uint32_t t) const {
    return std::atomic_ref<std::uint8_t>(const_cast<std::uint8_t&>(marks_[t])).load(std::memory_order_relaxed);
  }

 private:
  std::vector<std::uint8_t> marks_;
  bool shared_;
};

/// Finds the tetrahedra of missing polytopes: those on the unknown sides of unmatched facets, and all that are reached
/// from them without crossing an unmatched facet. `known`: only through polytopes whose balls it certainly holds; null:
/// all are certain, and Error(invariant) is thrown where the walk leaves the shape.
template <class Facets>
class Flood {
  using Delaunay = delaunay::Delaunay;
  using Tetrahedron = delaunay::Tetrahedron;

 public:
  Flood(const Delaunay& delaunay, const TriangleIndex<Facets>& index, const KnownBox* known, Context* context)
      : delaunay_(delaunay),
        tetrahedra_(delaunay.tetrahedra()),
        index_(index),
        known_(known),
        context_(context),
        marks_(tetrahedra_.size()),
        chunks_(base::chunks_for(tetrahedra_.size())),
        seeds_(chunks_) {}

  Marks run() {
    base::for_chunks(chunks_, context_, "merge", 0, 0.1, [&](std::size_t chunk) { mark_facets(chunk); });
    // Facets are all marked by now; the thread that keeps a tetrahedron first continues from it.
    base::for_chunks(chunks_, context_, "merge", 0.1, 0.12, [&](std::size_t chunk) { grow(std::move(seeds_[chunk])); });
    return std::move(marks_);
  }

 private:
  [[noreturn]] static void leaves_shape() {
    throw Error(ErrorCode::invariant, "a polytope of the voxel core's dual reaches out of the shape");
  }

  void mark_facets(std::size_t chunk) {
    const auto [first, last] = base::part_of(tetrahedra_.size(), chunk, chunks_);
    for (auto t = static_cast<std::uint32_t>(first); t < last; ++t) {
      if (tetrahedra_[t].corner[0] == kNone || Delaunay::touches_box(tetrahedra_[t])) continue;
      for (std::uint32_t i = 0; i < 4; ++i) mark_facet(t, i, seeds_[chunk]);
    }
  }

  void mark_facet(std::uint32_t t, std::uint32_t i, std::vector<std::uint32_t>& seeds) {
    const auto& corner = tetrahedra_[t].corner;
    const std::uint32_t neighbour = tetrahedra_[t].neighbour[i], n = neighbour >> 2;
    const bool at_box = Delaunay::touches_box(tetrahedra_[n]);
    if (n < t && !at_box) return;  // one of the two looks
    const auto& f = delaunay::kFacet[i];
    const auto facet = index_.find(corner[f[0]] - Delaunay::kBoxPoints, corner[f[1]] - Delaunay::kBoxPoints,
                                   corner[f[2]] - Delaunay::kBoxPoints);
    if (!facet.any) return;
    // Seen from outside a tetrahedron its facets run counter-clockwise, so from inside they do not.
    const std::uint32_t inner = facet.counter_clockwise ? n : t;
    if (inner == n && at_box && !known_) leaves_shape();
    marks_.set(t, 1u << i);
    marks_.set(n, 1u << (neighbour & 3));
    if (is_certain(inner) && !(marks_.set(inner, Marks::kKept) & Marks::kKept)) seeds.push_back(inner);
  }

  void grow(std::vector<std::uint32_t> stack) {
    for (std::size_t step = 1; !stack.empty(); ++step) {
      if (step % 0x10000 == 0 && context_ && context_->cancelled()) return;  // for_chunks() throws
      const std::uint32_t t = stack.back();
      stack.pop_back();
      const std::uint32_t unmatched = marks_.get(t);
      for (std::uint32_t i = 0; i < 4; ++i) {
        const std::uint32_t n = tetrahedra_[t].neighbour[i] >> 2;
        if (unmatched >> i & 1 || marks_.get(n) & Marks::kKept) continue;
        if (!continues(t, i)) continue;
        if (!(marks_.set(n, Marks::kKept) & Marks::kKept)) stack.push_back(n);
      }
    }
  }

  // Whether the tetrahedron across facet i of one that is kept may be kept: those of one polytope are kept together.
  bool continues(std::uint32_t t, std::uint32_t i) const {
    const std::uint32_t across = tetrahedra_[t].neighbour[i], n = across >> 2;
    if (Delaunay::touches_box(tetrahedra_[n])) {
      if (!known_) leaves_shape();
      return false;
    }
    if (is_certain(n)) return true;
    const auto& points = delaunay_.points();
    const auto& c = tetrahedra_[t].corner;
    return delaunay_.predicates().in_sphere(points[c[0]], points[c[1]], points[c[2]], points[c[3]],
                                            points[tetrahedra_[n].corner[across & 3]]) == 0;
  }
  bool is_certain(std::uint32_t t) const {
    if (!known_) return true;
    if (Delaunay::touches_box(tetrahedra_[t])) return false;
    std::array<LatticePoint, 4> corners;
    for (std::size_t i = 0; i < 4; ++i) {
      const delaunay::Point& p = delaunay_.points()[tetrahedra_[t].corner[i]];
      corners[i] = {p.x, p.y, p.z};
    }
    return known_->certainly_holds(corners);
  }

  const Delaunay& delaunay_;
  const base::RawHugeVector<Tetrahedron>& tetrahedra_;
  const TriangleIndex<Facets>& index_;
  const KnownBox* known_;
  Context* context_;
  Marks marks_;
  const std::size_t chunks_;
  std::vector<std::vector<std::uint32_t>> seeds_;
};

}  // namespace quench::dual
