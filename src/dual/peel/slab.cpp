// SPDX-License-Identifier: Apache-2.0
#include "dual/peel/slab.h"

#include <cmath>

#include "dual/peel/unit_cubes.h"
#include "dual/peel/wrapping.h"
#include "quench/error.h"

namespace quench::dual::peel {

std::int32_t Input::layers() const {
  return static_cast<std::int32_t>(std::ceil(2 * reach / static_cast<double>(spacing[2]))) + 1;
}

namespace {

constexpr std::uint32_t kSquare = std::uint32_t{1} << 31;  // in FacetTable: not a polytope but a square

// Unmatched facets of polytopes and unmatched boundary squares, by their keys. Chains start at the smallest site, so
// facets that are near each other are near each other in memory.
class FacetTable {
 public:
  struct Owner {
    std::uint32_t polytope, facet;
  };
  explicit FacetTable(std::size_t sites) : head_(sites, kNone) { entries_.reserve(2 * sites); }

  // Removes the facet from the table and returns its owner; where it is not there, enters it with `owner` and returns
  // kNone. Sites in keys count from the first site of the slab.
  Owner match(const FacetKey& key, Owner owner) {
    std::uint32_t* link = &head_[key[0]];
    for (; *link != kNone; link = &entries_[*link].next) {
      Entry& entry = entries_[*link];
      if (entry.second != key[1] || entry.third != key[2]) continue;
      const Owner other = entry.owner;
      const std::uint32_t freed = *link;
      *link = entry.next;
      entry.next = free_;
      free_ = freed;
      return other;
    }
    std::uint32_t place = free_;
    if (place == kNone) {
      place = static_cast<std::uint32_t>(entries_.size());
      entries_.emplace_back();
    } else {
      free_ = entries_[place].next;
    }
    entries_[place] = {head_[key[0]], key[1], key[2], owner};
    head_[key[0]] = place;
    return {kNone, kNone};
  }

 private:
  struct Entry {
    std::uint32_t next, second, third;
    Owner owner;
  };
  std::vector<std::uint32_t> head_;
  std::vector<Entry> entries_;
  std::uint32_t free_ = kNone;
};

class Slab {
 public:
  Slab(const Input& input, const delaunay::Bounds& box, Hulls& hulls)
      : input_(input),
        hulls_(hulls),
        finder_(hulls),
        box_(box),
        low_(first_site(box[0][2] - input.layers())),
        high_(first_site(box[1][2] + input.layers() + 1)),
        table_(high_ - low_),
        cubes_(input.shape, input.sites, known_layers(), hulls) {
    cells_.reserve_for(high_ - low_);
  }

  CellsPart run() {
    cubes_.each([&](const UnitCube& cube) { add(cube); });
    if (input_.reach > 0 && cells_.count() >= input_.least_cubes * (high_ - low_)) wrap();
    return owned_part();
  }

 private:
  std::uint32_t first_site(std::int32_t layer) const {
    const auto place = std::partition_point(input_.sites.begin(), input_.sites.end(),
                                            [&](const LatticePoint& s) { return s[2] < layer; });
    return static_cast<std::uint32_t>(place - input_.sites.begin());
  }

  // What is known of the layers around the box.
  delaunay::Bounds known_layers() const {
    delaunay::Bounds bounds = input_.known;
    bounds[0][2] = std::max(bounds[0][2], box_[0][2] - input_.layers());
    bounds[1][2] = std::min(bounds[1][2], box_[1][2] + input_.layers());
    return bounds;
  }

  static FacetKey key_of_square(Square square) {
    std::sort(square.begin(), square.end());
    return {square[0], square[1], square[2]};
  }

  void add(const UnitCube& cube) {
    if (cube.hull != kNone) {
      add(cube.sites, cube.hull, cube.boundary);
      return;
    }
    for (const Square& square : cube.squares) {
      squares_.push_back(square);
      square_polytope_.push_back(kUnmatched);
      connect(key_of_square(square), {static_cast<std::uint32_t>(squares_.size() - 1) | kSquare, 0});
    }
  }

  // `boundary`: bits of the facets that are known to be boundary squares.
  void add(std::span<const std::uint32_t> sites, std::uint32_t its_hull, std::uint64_t boundary) {
    const Hull& hull = hulls_[its_hull];
    const std::uint32_t polytope = cells_.add(sites, its_hull, hull.facets());
    for (std::uint32_t f = 0; f < hull.facets(); ++f) {
      if (boundary >> f & 1)
        cells_.neighbours_of(polytope)[f] = kBoundary;
      else
        connect(key_of(hull, f, sites), {polytope, f});
    }
  }

  void connect(FacetKey key, FacetTable::Owner owner) {
    for (std::uint32_t& site : key) site -= low_;
    const FacetTable::Owner other = table_.match(key, owner);
    if (other.polytope == kNone) {
      if (wrapping_) waiting_.push_back(owner);
      return;
    }
    across(owner) = other.polytope;
    across(other) = owner.polytope;
  }
  // What lies across a facet: as in Cells, but squares keep their numbers until owned_part().
  std::uint32_t& across(FacetTable::Owner owner) {
    return owner.polytope & kSquare ? square_polytope_[owner.polytope & ~kSquare]
                                    : cells_.neighbours_of(owner.polytope)[owner.facet];
  }

  // From every facet that the unit cubes left unmatched, as far as it goes.
  void wrap() {
    Wrapping wrapping(input_.sites, input_.spacing, input_.predicates, input_.index, input_.reach);
    wrapping_ = &wrapping;
    for (std::uint32_t s = 0; s < squares_.size(); ++s) wrap_from({s | kSquare, 0});
    for (std::uint32_t p = 0, count = cells_.count(); p < count; ++p)
      for (std::uint32_t f = 0; f < cells_.neighbours_of(p).size(); ++f) wrap_from({p, f});
    wrapping_ = nullptr;
  }

  void wrap_from(FacetTable::Owner start) {
    waiting_.assign(1, start);
    while (!waiting_.empty()) {
      const FacetTable::Owner owner = waiting_.back();
      waiting_.pop_back();
      if (across(owner) != kUnmatched) continue;
      const std::uint32_t behind = take_facet(owner);
      if (!wrapping_->polytope_across(facet_, behind, found_)) continue;
      // The table has the sites of a range of layers only; what lies beyond belongs to other boxes.
      if (found_.front() < low_ || found_.back() >= high_ || found_.size() > HullFinder::kMostCorners) continue;
      points_.clear();
      for (const std::uint32_t s : found_)
        points_.push_back({input_.sites[s][0], input_.sites[s][1], input_.sites[s][2], s});
      const std::uint32_t hull = finder_.find(points_);
      if (hull == kNone) throw Error(ErrorCode::invariant, "a Delaunay polytope is flat");
      add(found_, hull, 0);
    }
  }

  // Puts the sites of a facet into facet_; returns another site of its polytope, kNone for a square.
  std::uint32_t take_facet(FacetTable::Owner owner) {
    if (owner.polytope & kSquare) {
      const Square& square = squares_[owner.polytope & ~kSquare];
      facet_.assign(square.begin(), square.end());
      return kNone;
    }
    facet_.clear();
    const auto sites = cells_.sites_of(owner.polytope);
    for (const std::uint32_t corner : hulls_[cells_.hull[owner.polytope]].corners_of(owner.facet))
      facet_.push_back(sites[corner]);
    return *std::ranges::find_if(sites, [&](std::uint32_t s) { return std::ranges::find(facet_, s) == facet_.end(); });
  }

  bool is_owned(std::uint32_t site) const {
    const LatticePoint& s = input_.sites[site];
    for (std::size_t a = 0; a < 3; ++a)
      if (s[a] < box_[0][a] || s[a] > box_[1][a]) return false;
    return true;
  }
  bool is_owned(const Square& square) const { return is_owned(*std::ranges::min_element(square)); }

  // Keeps the polytopes and squares whose smallest site lies in the box. All facets between one of them and anything
  // else are unmatched: the owner of the other side may not have found it.
  CellsPart owned_part() {
    CellsPart part;
    const std::vector<std::uint32_t> number = number_owned();
    add_unmatched_squares(number, part);
    for (std::uint32_t p = 0; p < cells_.count(); ++p)
      if (number[p] != kNone) renumber_neighbours(p, number, part);
    if (std::ranges::find(number, kNone) == number.end())
      part.cells = std::move(cells_);
    else
      copy_owned(number, part.cells);
    return part;
  }

  std::vector<std::uint32_t> number_owned() const {
    std::vector<std::uint32_t> number(cells_.count(), kNone);
    std::uint32_t next = 0;
    for (std::uint32_t p = 0; p < cells_.count(); ++p)
      if (is_owned(cells_.sites_of(p)[0])) number[p] = next++;
    return number;
  }

  void add_unmatched_squares(const std::vector<std::uint32_t>& number, CellsPart& part) const {
    for (std::uint32_t s = 0; s < squares_.size(); ++s) {
      if (!is_owned(squares_[s])) continue;
      if (square_polytope_[s] != kUnmatched && number[square_polytope_[s]] != kNone) continue;
      part.unmatched.push_back({key_of_square(squares_[s]), kNone, static_cast<std::uint32_t>(part.squares.size())});
      part.squares.push_back(squares_[s]);
    }
  }

  void renumber_neighbours(std::uint32_t p, const std::vector<std::uint32_t>& number, CellsPart& part) {
    const auto sites = cells_.sites_of(p);
    const auto neighbours = cells_.neighbours_of(p);
    for (std::uint32_t f = 0; f < neighbours.size(); ++f) {
      std::uint32_t& n = neighbours[f];
      if (n == kBoundary) continue;
      if (n != kUnmatched) n = renumbered(n, number);
      if (n == kUnmatched) part.unmatched.push_back({key_of(hulls_[cells_.hull[p]], f, sites), number[p], f});
    }
  }
  std::uint32_t renumbered(std::uint32_t n, const std::vector<std::uint32_t>& number) const {
    if (n & kSquare) return is_owned(squares_[n & ~kSquare]) ? kBoundary : kUnmatched;
    return number[n] == kNone ? kUnmatched : number[n];
  }

  void copy_owned(const std::vector<std::uint32_t>& number, Cells& to) const {
    for (std::uint32_t p = 0; p < cells_.count(); ++p) {
      if (number[p] == kNone) continue;
      const auto neighbours = cells_.neighbours_of(p);
      const std::uint32_t copy =
          to.add(cells_.sites_of(p), cells_.hull[p], static_cast<std::uint32_t>(neighbours.size()));
      std::ranges::copy(neighbours, to.neighbours_of(copy).begin());
    }
  }

  const Input& input_;
  Hulls& hulls_;
  HullFinder finder_;
  const delaunay::Bounds box_;
  const std::uint32_t low_, high_;  // sites of the layers of the box and those around it
  FacetTable table_;
  UnitCubes cubes_;
  Cells cells_;
  std::vector<Square> squares_;
  std::vector<std::uint32_t> square_polytope_;
  Wrapping* wrapping_ = nullptr;            // while polytopes are looked for facet by facet
  std::vector<FacetTable::Owner> waiting_;  // facets that were unmatched when they were found
  std::vector<std::uint32_t> facet_, found_;
  std::vector<delaunay::Point> points_;
};

}  // namespace

CellsPart peel_box(const Input& input, const delaunay::Bounds& box, Hulls& hulls) {
  return Slab(input, box, hulls).run();
}

}  // namespace quench::dual::peel
