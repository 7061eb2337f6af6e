// SPDX-License-Identifier: Apache-2.0
#include "dual/bricks/part.h"

#include <algorithm>
#include <iterator>
#include <tuple>
#include <utility>

#include "base/parallel.h"
#include "dual/assemble.h"
#include "dual/bricks/part_order.h"
#include "quench/error.h"

namespace quench::dual::bricks {

void Part::extend() {
  const Cells& cells = found.cells;
  link_lambda.resize(cells.neighbours.size(), -1);
  link_detail.resize(cells.neighbours.size(), -1);
  vertex_lambda.resize(cells.count(), -1);
  vertex_detail.resize(cells.count(), -1);
  contact.resize(cells.sites.size(), 0);
}

std::vector<LatticePoint> united(std::span<const LatticePoint> a, std::span<const LatticePoint> b) {
  std::vector<LatticePoint> all;
  all.reserve(a.size() + b.size());
  std::ranges::set_union(a, b, std::back_inserter(all), comes_before);
  return all;
}

std::vector<std::uint32_t> places_of(std::span<const LatticePoint> some, std::span<const LatticePoint> all) {
  std::vector<std::uint32_t> place(some.size());
  std::uint32_t at = 0;
  for (std::size_t s = 0; s < some.size(); ++s) {
    while (all[at] != some[s]) ++at;
    place[s] = at;
  }
  return place;
}

void renumber_sites(Part& part, std::span<const std::uint32_t> place, std::vector<LatticePoint> sites) {
  const auto renumber = [&](auto& list) {
    for (std::uint32_t& s : list) s = place[s];
  };
  renumber(part.found.cells.sites);
  for (UnmatchedFacet& f : part.found.unmatched) renumber(f.key);
  for (Square& s : part.found.squares) renumber(s);
  for (FaceValue& f : part.faces) renumber(f.sites);
  part.sites = std::move(sites);
}

void drop_unnamed_sites(Part& part) {
  std::vector<std::uint32_t> place(part.sites.size(), kNone);
  for (const std::uint32_t s : part.found.cells.sites) place[s] = 0;
  for (const Square& square : part.found.squares)
    for (const std::uint32_t s : square) place[s] = 0;
  std::vector<LatticePoint> sites;
  for (std::size_t s = 0; s < place.size(); ++s) {
    if (place[s] == kNone) continue;
    place[s] = static_cast<std::uint32_t>(sites.size());
    sites.push_back(part.sites[s]);
  }
  renumber_sites(part, place, std::move(sites));
}

namespace {

// Groups of a list in another order: group r of the result is group order[r] of the list.
template <class T>
std::vector<T> permuted_groups(const std::vector<T>& list, const std::vector<std::uint32_t>& begin,
                               std::span<const std::uint32_t> order) {
  std::vector<T> result;
  result.reserve(list.size());
  for (const std::uint32_t p : order) result.insert(result.end(), list.begin() + begin[p], list.begin() + begin[p + 1]);
  return result;
}

template <class T>
std::vector<T> permuted_list(const std::vector<T>& list, std::span<const std::uint32_t> order) {
  std::vector<T> result;
  result.reserve(list.size());
  for (const std::uint32_t p : order) result.push_back(list[p]);
  return result;
}

void permute_carried(Part& part, std::span<const std::uint32_t> order) {
  const Cells& cells = part.found.cells;
  part.link_lambda = permuted_groups(part.link_lambda, cells.neighbour_begin, order);
  part.link_detail = permuted_groups(part.link_detail, cells.neighbour_begin, order);
  part.contact = permuted_groups(part.contact, cells.site_begin, order);
  part.vertex_lambda = permuted_list(part.vertex_lambda, order);
  part.vertex_detail = permuted_list(part.vertex_detail, order);
}

void permute(Part& part, std::span<const std::uint32_t> order, Context* context) {
  if (!part.contact.empty()) permute_carried(part, order);
  std::vector<std::uint32_t> rank(order.size());
  for (std::uint32_t r = 0; r < order.size(); ++r) rank[order[r]] = r;
  for (UnmatchedFacet& f : part.found.unmatched)
    if (f.polytope != kNone) f.polytope = rank[f.polytope];
  part.found.cells = permuted(part.found.cells, order, context);
}

void append_to(auto& whole, auto&& part) {
  whole.insert(whole.end(), part.begin(), part.end());
  part = {};
}

}  // namespace

void put_in_order(Part& part, Context* context) {
  const std::vector<std::uint32_t> order = order_of(part.found.cells, part.sites.size(), context);
  if (!std::ranges::is_sorted(order)) permute(part, order, context);
  put_facets_in_order(part);
}

void put_facets_in_order(Part& part) {
  std::vector<UnmatchedFacet>& unmatched = part.found.unmatched;
  std::ranges::sort(unmatched, {}, [](const UnmatchedFacet& f) { return std::tuple(f.key, f.polytope); });
  std::vector<Square> squares;
  for (UnmatchedFacet& f : unmatched) {
    if (f.polytope != kNone) continue;
    squares.push_back(part.found.squares[f.facet]);
    f.facet = static_cast<std::uint32_t>(squares.size() - 1);
  }
  part.found.squares = std::move(squares);
}

Part joined(std::vector<Part> parts, Context* context) {
  if (parts.size() == 1) return std::move(parts[0]);
  Part whole;
  for (const Part& part : parts) whole.sites = united(whole.sites, part.sites);
  const bool carried = std::ranges::any_of(parts, [](const Part& part) { return !part.contact.empty(); });
  std::vector<CellsPart> found;
  for (Part& part : parts) {
    if (carried) part.extend();
    renumber_sites(part, places_of(part.sites, whole.sites), {});
    found.push_back(std::move(part.found));
    append_to(whole.link_lambda, std::move(part.link_lambda));
    append_to(whole.link_detail, std::move(part.link_detail));
    append_to(whole.vertex_lambda, std::move(part.vertex_lambda));
    append_to(whole.vertex_detail, std::move(part.vertex_detail));
    append_to(whole.contact, std::move(part.contact));
    append_to(whole.faces, std::move(part.faces));
    whole.pending = united(whole.pending, part.pending);
    whole.pruned.vertices += part.pruned.vertices;
    whole.pruned.edges += part.pruned.edges;
    whole.pruned.faces += part.pruned.faces;
    part = {};
  }
  append(found, Numbers::per_part, whole.found);
  std::ranges::sort(whole.faces, {}, &FaceValue::sites);
  match(whole.found, whole.sites.size(), context, "merge", 0);
  put_facets_in_order(whole);
  return whole;
}

// The corners are places in `sites`: of these the ones they name, and the corners as places there.
static void take_sites(std::span<const LatticePoint> sites, Unfinished& result) {
  std::vector<std::uint32_t> place(sites.size(), kNone);
  for (const std::uint32_t c : result.corners) place[c] = 0;
  for (std::size_t s = 0; s < place.size(); ++s) {
    if (place[s] == kNone) continue;
    place[s] = static_cast<std::uint32_t>(result.sites.size());
    result.sites.push_back(sites[s]);
  }
  for (std::uint32_t& c : result.corners) c = place[c];
}

Unfinished unfinished(const Part& part, const Hulls& hulls) {
  Unfinished result;
  for (const UnmatchedFacet& f : part.found.unmatched) {
    const auto corners = part.found.corners_of(f, hulls);
    for (std::size_t i = 0; i < corners.size(); ++i) result.corners.push_back(corners[i]);
    result.begin.push_back(static_cast<std::uint32_t>(result.corners.size()));
  }
  take_sites(part.sites, result);
  return result;
}

Unfinished near(const Unfinished& unfinished, const Box& box) {
  Unfinished result;
  for (std::size_t f = 0; f < unfinished.size(); ++f) {
    const auto corners = unfinished.corners_of(f);
    if (std::ranges::none_of(corners, [&](std::uint32_t c) { return box.contains(unfinished.sites[c]); })) continue;
    result.corners.insert(result.corners.end(), corners.begin(), corners.end());
    result.begin.push_back(static_cast<std::uint32_t>(result.corners.size()));
  }
  take_sites(unfinished.sites, result);
  return result;
}

}  // namespace quench::dual::bricks
