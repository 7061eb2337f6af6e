// SPDX-License-Identifier: Apache-2.0
#include "dual/peel/remainder.h"

#include <algorithm>
#include <atomic>
#include <memory>
#include <utility>

#include "base/parallel.h"
#include "delaunay/delaunay.h"
#include "delaunay/polytopes.h"
#include "dual/from_polytopes.h"
#include "quench/error.h"

namespace quench::dual::peel {
namespace {

using delaunay::Delaunay;
using delaunay::Tetrahedron;

// The unmatched facets of a part by their triangles. A triangle is found by its smallest corner. The sites of unmatched
// facets are renumbered: number[s] below `numbers` instead of s.
class TriangleIndex {
 public:
  struct Found {
    bool any;
    bool counter_clockwise;  // seen from the unknown side of the facet
  };

  TriangleIndex(const CellsPart& part, const Hulls& hulls, std::vector<std::uint32_t> number, std::size_t numbers)
      : part_(part), hulls_(hulls), number_(std::move(number)) {
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
      const auto corners = part_.corners_of(part_.unmatched[entry.facet], hulls_);
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
    const std::size_t chunks = base::chunks_for(part_.unmatched.size());
    tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
      const auto [first, last] = base::part_of(part_.unmatched.size(), chunk, chunks);
      each_entry(first, last, visit);
    });
  }
  template <class Visit>
  void each_entry(std::size_t first, std::size_t last, const Visit& visit) const {
    std::vector<std::pair<std::uint32_t, std::size_t>> sorted;  // corners and their places in the cycle
    for (auto f = static_cast<std::uint32_t>(first); f < last; ++f) {
      const auto corners = part_.corners_of(part_.unmatched[f], hulls_);
      sorted.clear();
      for (std::size_t i = 0; i < corners.size(); ++i) sorted.emplace_back(number_[corners[i]], i);
      std::sort(sorted.begin(), sorted.end());
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

  const CellsPart& part_;
  const Hulls& hulls_;
  std::vector<std::uint32_t> number_;  // per site
  std::vector<std::uint32_t> begin_;
  std::vector<Entry> entries_;
};

// Bits of tetrahedra that threads set at the same time. Bit i < 4: facet i is unmatched.
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

// Finds the tetrahedra of missing polytopes: those on the unknown sides of unmatched facets, and all that are reached
// from them without crossing an unmatched facet.
class Flood {
 public:
  Flood(const Delaunay& delaunay, const TriangleIndex& index, Context* context)
      : tetrahedra_(delaunay.tetrahedra()),
        index_(index),
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
    if (inner == n && at_box) leaves_shape();
    marks_.set(t, 1u << i);
    marks_.set(n, 1u << (neighbour & 3));
    if (!(marks_.set(inner, Marks::kKept) & Marks::kKept)) seeds.push_back(inner);
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
        if (Delaunay::touches_box(tetrahedra_[n])) leaves_shape();
        if (!(marks_.set(n, Marks::kKept) & Marks::kKept)) stack.push_back(n);
      }
    }
  }

  const base::RawHugeVector<Tetrahedron>& tetrahedra_;
  const TriangleIndex& index_;
  Context* context_;
  Marks marks_;
  const std::size_t chunks_;
  std::vector<std::vector<std::uint32_t>> seeds_;
};

class Remainder {
 public:
  Remainder(std::span<const LatticePoint> sites, const std::array<std::int64_t, 3>& spacing, Hulls& hulls,
            CellsPart& whole, Context* context)
      : all_(sites), spacing_(spacing), hulls_(hulls), whole_(whole), context_(context) {}

  void run() {
    choose_sites();
    auto delaunay = std::make_unique<Delaunay>(sites_, spacing_, delaunay::bounds_of(all_), context_);
    append(missing_polytopes(std::move(delaunay)), sites_,
           {.site = numbers_, .number = {}, .on_boundary = [](const auto&) { return false; }}, hulls_, whole_,
           context_);
    match_all(whole_, all_.size(), context_, "merge", 0.75);
  }

 private:
  // The unfinished sites; the triangulation numbers them among themselves, in the same order.
  void choose_sites() {
    std::vector<std::uint8_t> unfinished(all_.size(), 0);
    base::for_indices(whole_.unmatched.size(), [&](std::size_t f) {
      const auto corners = whole_.corners_of(whole_.unmatched[f], hulls_);
      for (std::size_t i = 0; i < corners.size(); ++i)
        std::atomic_ref<std::uint8_t>(unfinished[corners[i]]).store(1, std::memory_order_relaxed);
    });
    const auto count = static_cast<std::size_t>(std::ranges::count(unfinished, 1));
    sites_.reserve(count);
    numbers_.reserve(count);
    for (std::uint32_t s = 0; s < all_.size(); ++s) {
      if (!unfinished[s]) continue;
      sites_.push_back(all_[s]);
      numbers_.push_back(s);
    }
  }

  delaunay::Polytopes missing_polytopes(std::unique_ptr<Delaunay> delaunay) {
    std::vector<std::uint32_t> place(all_.size());  // by points, since tetrahedra lie in memory as points do
    base::for_indices(sites_.size(), [&](std::size_t p) {
      place[numbers_[delaunay->points()[p + Delaunay::kBoxPoints].site]] = static_cast<std::uint32_t>(p);
    });
    const Marks marks =
        Flood(*delaunay, TriangleIndex(whole_, hulls_, std::move(place), sites_.size()), context_).run();
    return delaunay::polytopes_of(
        [&](std::uint32_t t, const Tetrahedron&) { return (marks.get(t) & Marks::kKept) != 0; }, std::move(delaunay),
        sites_, context_);
  }

  std::span<const LatticePoint> all_;
  const std::array<std::int64_t, 3>& spacing_;
  Hulls& hulls_;
  CellsPart& whole_;
  Context* context_;
  std::vector<LatticePoint> sites_;
  std::vector<std::uint32_t> numbers_;  // of the unfinished sites among all
};

}  // namespace

void add_remainder(std::span<const LatticePoint> sites, const std::array<std::int64_t, 3>& spacing, Hulls& hulls,
                   CellsPart& whole, Context* context) {
  if (!whole.unmatched.empty()) Remainder(sites, spacing, hulls, whole, context).run();
}

}  // namespace quench::dual::peel
