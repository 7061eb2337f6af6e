// SPDX-License-Identifier: Apache-2.0
#include "dual/peel/remainder.h"

#include <algorithm>
#include <atomic>
#include <memory>
#include <utility>

#include "base/parallel.h"
#include "delaunay/delaunay.h"
#include "delaunay/polytopes.h"
#include "dual/flood.h"
#include "dual/from_polytopes.h"

namespace quench::dual::peel {
namespace {

using delaunay::Delaunay;
using delaunay::Tetrahedron;

class UnmatchedFacets {
 public:
  UnmatchedFacets(const CellsPart& part, const Hulls& hulls) : part_(part), hulls_(hulls) {}
  std::size_t size() const { return part_.unmatched.size(); }
  CellsPart::Corners corners(std::uint32_t facet) const { return part_.corners_of(part_.unmatched[facet], hulls_); }

 private:
  const CellsPart& part_;
  const Hulls& hulls_;
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
    const UnmatchedFacets facets(whole_, hulls_);
    const Marks marks =
        Flood(*delaunay, TriangleIndex(facets, std::move(place), sites_.size()), nullptr, context_).run();
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
