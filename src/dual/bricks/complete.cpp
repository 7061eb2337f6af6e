// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "base/parallel.h"
#include "delaunay/delaunay.h"
#include "delaunay/polytopes.h"
#include "dual/bricks/part.h"
#include "dual/bricks/part_order.h"
#include "dual/flood.h"
#include "dual/from_polytopes.h"
#include "quench/error.h"

namespace quench::dual::bricks {
namespace {

// The unmatched facets of several parts that no two of them have: what encloses the polytopes that none knows.
class OpenFacets {
 public:
  OpenFacets(const Unfinished& own, std::span<const Unfinished> around, Context* context) {
    all_.sites = own.sites;
    for (const Unfinished& part : around) all_.sites = united(all_.sites, part.sites);
    add(own);
    for (const Unfinished& part : around) add(part);
    CellsPart facets;
    for (std::uint32_t f = 0; f < all_.size(); ++f) facets.unmatched.push_back({key(f), kNone, f});
    match(facets, all_.sites.size(), context, "merge", 0);
    for (const UnmatchedFacet& f : facets.unmatched) open_.push_back(f.facet);
  }

  std::span<const LatticePoint> sites() const { return all_.sites; }
  std::size_t size() const { return open_.size(); }
  std::span<const std::uint32_t> corners(std::size_t facet) const { return all_.corners_of(open_[facet]); }

 private:
  void add(const Unfinished& part) {
    const std::vector<std::uint32_t> place = places_of(part.sites, all_.sites);
    const auto before = static_cast<std::uint32_t>(all_.corners.size());
    for (const std::uint32_t c : part.corners) all_.corners.push_back(place[c]);
    for (std::size_t f = 0; f < part.size(); ++f) all_.begin.push_back(before + part.begin[f + 1]);
    base::check_index(all_.corners.size());
  }
  FacetKey key(std::size_t facet) const {
    FacetKey key{};
    std::ranges::partial_sort_copy(all_.corners_of(facet), key);
    return key;
  }

  Unfinished all_;
  std::vector<std::uint32_t> open_;
};

delaunay::Bounds bounds_of_box(const Box& box) {
  delaunay::Bounds bounds;
  for (std::size_t a = 0; a < 3; ++a) {
    bounds[0][a] = static_cast<std::int32_t>(box.low[a]);
    bounds[1][a] = static_cast<std::int32_t>(box.high[a] - 1);
  }
  return bounds;
}

class Completion {
 public:
  Completion(Part& part, const Box& box, const Box* region, const std::array<std::int64_t, 3>& spacing, Hulls& hulls,
             Context* context)
      : part_(part), box_(box), region_(region), spacing_(spacing), hulls_(hulls), context_(context) {}

  void run(std::span<const Unfinished> around) {
    add_missing(around);
    if (!part_.contact.empty()) part_.extend();
    match(part_.found, part_.sites.size(), context_, "merge", 0.75);
    put_in_order(part_, context_);
    if (!region_ && !part_.found.unmatched.empty())
      throw Error(ErrorCode::invariant, "a facet of the voxel core's dual is not shared by two polytopes");
  }

 private:
  void add_missing(std::span<const Unfinished> around) {
    auto polytopes = missing_polytopes(around);
    if (!polytopes) return;
    const std::vector<std::uint32_t> number = number_wanted(*polytopes);
    const std::vector<std::uint32_t> site = add_sites(*polytopes, number);
    append(std::move(*polytopes), sites_,
           {.site = site, .number = number, .on_boundary = [](const auto&) { return false; }}, hulls_, part_.found,
           context_);
  }

  std::optional<delaunay::Polytopes> missing_polytopes(std::span<const Unfinished> around) {
    const OpenFacets facets(unfinished(part_, hulls_), around, context_);
    std::vector<std::uint32_t> number = choose_sites(facets);
    if (sites_.empty()) return std::nullopt;
    const delaunay::Bounds bounds = bounds_of_box(region_ ? *region_ : box_);
    auto delaunay = std::make_unique<delaunay::Delaunay>(sites_, spacing_, bounds, context_);
    // By points, since tetrahedra lie in memory as points do.
    std::vector<std::uint32_t> point(sites_.size());
    base::for_indices(sites_.size(), [&](std::size_t p) {
      point[delaunay->points()[p + delaunay::Delaunay::kBoxPoints].site] = static_cast<std::uint32_t>(p);
    });
    for (std::uint32_t& n : number)
      if (n != kNone) n = point[n];
    const KnownBox known(bounds, spacing_);
    const Marks marks =
        Flood(*delaunay, TriangleIndex(facets, std::move(number), sites_.size()), region_ ? &known : nullptr, context_)
            .run();
    const auto keep = [&](std::uint32_t t, const delaunay::Tetrahedron&) { return (marks.get(t) & Marks::kKept) != 0; };
    return delaunay::polytopes_of(keep, std::move(delaunay), sites_, context_);
  }

  // The corners of the facets in the region; returns the number of each site of the facets among them.
  std::vector<std::uint32_t> choose_sites(const OpenFacets& facets) {
    const auto all = facets.sites();
    std::vector<std::uint32_t> number(all.size(), kNone);
    for (std::size_t f = 0; f < facets.size(); ++f)
      for (const std::uint32_t c : facets.corners(f)) number[c] = 0;
    for (std::size_t s = 0; s < all.size(); ++s) {
      if (number[s] == kNone) continue;
      number[s] = kNone;
      if (region_ && !region_->contains(all[s])) continue;
      number[s] = static_cast<std::uint32_t>(sites_.size());
      sites_.push_back(all[s]);
    }
    return number;
  }

  std::vector<std::uint32_t> number_wanted(const delaunay::Polytopes& polytopes) const {
    std::vector<std::uint32_t> number(polytopes.count(), kNone);
    std::uint32_t next = 0;
    for (std::uint32_t p = 0; p < polytopes.count(); ++p)
      if (!region_ || box_.contains(sites_[polytopes.sites_of(p)[0]])) number[p] = next++;
    return number;
  }

  // Adds the corners of the wanted polytopes to the part; returns the place there of each of sites_.
  std::vector<std::uint32_t> add_sites(const delaunay::Polytopes& polytopes, std::span<const std::uint32_t> number) {
    std::vector<std::uint8_t> named(sites_.size(), 0);
    for (std::uint32_t p = 0; p < polytopes.count(); ++p)
      if (number[p] != kNone)
        for (const std::uint32_t s : polytopes.sites_of(p)) named[s] = 1;
    std::vector<LatticePoint> added;
    for (std::size_t s = 0; s < sites_.size(); ++s)
      if (named[s]) added.push_back(sites_[s]);
    std::vector<LatticePoint> all = united(part_.sites, added);
    const std::vector<std::uint32_t> places = places_of(added, all);
    std::vector<std::uint32_t> site(sites_.size(), kNone);
    for (std::size_t s = 0, next = 0; s < sites_.size(); ++s)
      if (named[s]) site[s] = places[next++];
    if (all.size() > part_.sites.size()) {
      const std::vector<std::uint32_t> place = places_of(part_.sites, all);
      renumber_sites(part_, place, std::move(all));
    }
    return site;
  }

  Part& part_;
  const Box& box_;
  const Box* region_;
  const std::array<std::int64_t, 3>& spacing_;
  Hulls& hulls_;
  Context* context_;
  std::vector<LatticePoint> sites_;  // of the triangulation
};

}  // namespace

void complete(Part& part, const Box& box, const Box* region, std::span<const Unfinished> around,
              const std::array<std::int64_t, 3>& spacing, Hulls& hulls, Context* context) {
  Completion(part, box, region, spacing, hulls, context).run(around);
}

}  // namespace quench::dual::bricks
