// SPDX-License-Identifier: Apache-2.0
#include "peeling/slab.h"

#include <cmath>

#include "peeling/unit_cubes.h"
#include "peeling/wrapping.h"
#include "quench/error.h"

namespace quench::peeling {

std::int32_t Input::layers() const {
  return static_cast<std::int32_t>(std::ceil(2 * reach / static_cast<double>(spacing[2]))) + 1;
}

namespace {

constexpr std::uint32_t kSquare = std::uint32_t{1} << 31;  // in FacetTable: not a cell but a square

// Facets of cells and boundary squares that wait for a cell on their other side, by their names. Chains start at the
// smallest site, so facets that are near each other are near each other in memory.
class FacetTable {
 public:
  struct Owner {
    std::uint32_t cell, facet;
  };
  explicit FacetTable(std::size_t sites) : head_(sites, kNone) { entries_.reserve(2 * sites); }

  // Takes the facet out of the table and returns who left it there; where nobody did, leaves it for `owner`, and
  // returns kNone. Names count from the first site of the slab.
  Owner match(const FacetName& name, Owner owner) {
    std::uint32_t* link = &head_[name[0]];
    for (; *link != kNone; link = &entries_[*link].next) {
      Entry& entry = entries_[*link];
      if (entry.second != name[1] || entry.third != name[2]) continue;
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
    entries_[place] = {head_[name[0]], name[1], name[2], owner};
    head_[name[0]] = place;
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
  Slab(const Input& input, std::int32_t begin, std::int32_t end, Hulls& hulls)
      : input_(input),
        hulls_(hulls),
        finder_(hulls),
        begin_(first_site(begin)),
        end_(first_site(end)),
        low_(first_site(begin - input.layers())),
        high_(first_site(end + input.layers())),
        table_(high_ - low_),
        cubes_(input.shape, input.sites, begin - input.layers(), end + input.layers(), hulls) {
    cells_.reserve_for(high_ - low_);
  }

  SlabPart run() {
    cubes_.each([&](const UnitCube& cube) { take(cube); });
    if (input_.reach > 0 && cells_.count() >= input_.least_cubes * (high_ - low_)) wrap();
    return own();
  }

 private:
  std::uint32_t first_site(std::int32_t layer) const {
    const auto place = std::partition_point(input_.sites.begin(), input_.sites.end(),
                                            [&](const LatticePoint& s) { return s[2] < layer; });
    return static_cast<std::uint32_t>(place - input_.sites.begin());
  }

  static FacetName name_of(Square square) {
    std::sort(square.begin(), square.end());
    return {square[0], square[1], square[2]};
  }

  void take(const UnitCube& cube) {
    if (cube.hull == HullFinder::kNone) {
      for (const Square& square : cube.squares) {
        squares_.push_back(square);
        square_cell_.push_back(kOpen);
        connect(name_of(square), {static_cast<std::uint32_t>(squares_.size() - 1) | kSquare, 0});
      }
      return;
    }
    add(cube.sites, cube.hull, cube.boundary);
  }

  // `boundary`: bits of the facets that are known to be boundary squares.
  void add(std::span<const std::uint32_t> sites, std::uint32_t number, std::uint64_t boundary) {
    const Hull& hull = hulls_[number];
    const std::uint32_t cell = cells_.add(sites, number, hull.facets());
    for (std::uint32_t f = 0; f < hull.facets(); ++f) {
      if (boundary >> f & 1) {
        cells_.neighbours_of(cell)[f] = kBoundary;
        continue;
      }
      const auto& s = hull.smallest[f];
      connect({sites[s[0]], sites[s[1]], sites[s[2]]}, {cell, f});
    }
  }

  void connect(FacetName name, FacetTable::Owner owner) {
    for (std::uint32_t& site : name) site -= low_;
    const FacetTable::Owner other = table_.match(name, owner);
    if (other.cell == kNone) {
      if (wrapping_) waiting_.push_back(owner);
      return;
    }
    link(owner, other.cell);
    link(other, owner.cell);
  }
  void link(FacetTable::Owner owner, std::uint32_t across) {
    if (owner.cell & kSquare)
      square_cell_[owner.cell & ~kSquare] = across;
    else
      cells_.neighbours_of(owner.cell)[owner.facet] = across;  // squares keep their numbers until own()
  }
  bool is_open(FacetTable::Owner owner) const {
    return owner.cell & kSquare ? square_cell_[owner.cell & ~kSquare] == kOpen
                                : cells_.neighbours_of(owner.cell)[owner.facet] == kOpen;
  }

  // From every facet that the unit cubes left open, as far as it goes.
  void wrap() {
    Wrapping wrapping(input_.sites, input_.spacing, input_.predicates, input_.index, input_.reach);
    wrapping_ = &wrapping;
    for (std::uint32_t s = 0; s < squares_.size(); ++s) wrap_from({s | kSquare, 0});
    for (std::uint32_t c = 0, count = cells_.count(); c < count; ++c)
      for (std::uint32_t f = 0; f < cells_.neighbours_of(c).size(); ++f) wrap_from({c, f});
    wrapping_ = nullptr;
  }

  void wrap_from(FacetTable::Owner start) {
    waiting_.assign(1, start);
    while (!waiting_.empty()) {
      const FacetTable::Owner owner = waiting_.back();
      waiting_.pop_back();
      if (!is_open(owner)) continue;
      std::uint32_t behind = kNone;
      if (owner.cell & kSquare) {
        const Square& square = squares_[owner.cell & ~kSquare];
        facet_.assign(square.begin(), square.end());
      } else {
        facet_.clear();
        const auto sites = cells_.sites_of(owner.cell);
        for (const std::uint32_t corner : hulls_[cells_.hull[owner.cell]].corners_of(owner.facet))
          facet_.push_back(sites[corner]);
        behind =
            *std::ranges::find_if(sites, [&](std::uint32_t s) { return std::ranges::find(facet_, s) == facet_.end(); });
      }
      if (!wrapping_->cell_across(facet_, behind, found_)) continue;
      // The table has the sites of a range of layers only; what lies beyond belongs to other slabs.
      if (found_.front() < low_ || found_.back() >= high_ || found_.size() > HullFinder::kMostCorners) continue;
      points_.clear();
      for (const std::uint32_t s : found_)
        points_.push_back({input_.sites[s][0], input_.sites[s][1], input_.sites[s][2], s});
      const std::uint32_t hull = finder_.find(points_);
      if (hull == HullFinder::kNone) throw Error(ErrorCode::invariant, "a Delaunay polytope is flat");
      add(found_, hull, 0);
    }
  }

  // Keeps the cells whose smallest site lies in the slab. All facets between one of them and anything that is not are
  // loose: who owns the other side may not have found it.
  SlabPart own() {
    SlabPart part;
    const std::uint32_t count = cells_.count();
    std::vector<std::uint32_t> number(count, kNone);
    const auto owned_site = [&](std::uint32_t s) { return s >= begin_ && s < end_; };
    bool all = true;
    for (std::uint32_t c = 0, next = 0; c < count; ++c)
      if (owned_site(cells_.sites_of(c)[0]))
        number[c] = next++;
      else
        all = false;
    const auto loose = [&](std::span<const std::uint32_t> sites, std::uint32_t old, std::uint32_t f) {
      const auto& s = hulls_[cells_.hull[old]].smallest[f];
      part.loose.push_back({{sites[s[0]], sites[s[1]], sites[s[2]]}, number[old], f});
    };
    const auto owned_square = [&](std::uint32_t square) {
      return owned_site(*std::min_element(squares_[square].begin(), squares_[square].end()));
    };
    for (std::uint32_t s = 0; s < squares_.size(); ++s) {
      if (!owned_square(s) || (square_cell_[s] != kOpen && number[square_cell_[s]] != kNone)) continue;
      part.loose.push_back({name_of(squares_[s]), kNone, static_cast<std::uint32_t>(part.squares.size())});
      part.squares.push_back(squares_[s]);
    }
    for (std::uint32_t c = 0; c < count; ++c) {
      if (number[c] == kNone) continue;
      const auto sites = cells_.sites_of(c);
      const auto neighbours = cells_.neighbours_of(c);
      for (std::uint32_t f = 0; f < neighbours.size(); ++f) {
        std::uint32_t& n = neighbours[f];
        if (n == kBoundary) continue;
        if (n != kOpen && n & kSquare) {
          const bool mine = owned_square(n & ~kSquare);
          n = mine ? kBoundary : kOpen;
          if (!mine) loose(sites, c, f);
        } else {
          static_assert(kOpen == kNone, "a neighbour that was dropped is as open as one that was never found");
          if (n != kOpen) n = number[n];
          if (n == kNone) loose(sites, c, f);
        }
      }
      if (!all) part.cells.sites.insert(part.cells.sites.end(), sites.begin(), sites.end());
    }
    if (all) {
      part.cells = std::move(cells_);
      return part;
    }
    for (std::uint32_t c = 0; c < count; ++c) {
      if (number[c] == kNone) continue;
      const auto neighbours = cells_.neighbours_of(c);
      part.cells.site_begin.push_back(part.cells.site_begin.back() +
                                      static_cast<std::uint32_t>(cells_.sites_of(c).size()));
      part.cells.hull.push_back(cells_.hull[c]);
      part.cells.neighbours.insert(part.cells.neighbours.end(), neighbours.begin(), neighbours.end());
      part.cells.neighbour_begin.push_back(static_cast<std::uint32_t>(part.cells.neighbours.size()));
    }
    return part;
  }

  const Input& input_;
  Hulls& hulls_;
  HullFinder finder_;
  const std::uint32_t begin_, end_, low_, high_;  // sites of the slab, and with the layers around it
  FacetTable table_;
  UnitCubes cubes_;
  Cells cells_;
  std::vector<Square> squares_;
  std::vector<std::uint32_t> square_cell_;
  Wrapping* wrapping_ = nullptr;            // while cells are looked for facet by facet
  std::vector<FacetTable::Owner> waiting_;  // facets that were open when they were found
  std::vector<std::uint32_t> facet_, found_;
  std::vector<lattice::Point> points_;
};

}  // namespace

SlabPart peel_slab(const Input& input, std::int32_t begin, std::int32_t end, Hulls& hulls) {
  return Slab(input, begin, end, hulls).run();
}

}  // namespace quench::peeling
