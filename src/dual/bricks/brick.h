// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "dual/bricks/brick_grid.h"
#include "dual/bricks/octants.h"
#include "dual/cells.h"

/// The Delaunay complex inside O brick by brick: a brick knows all sites of its round in its region and nothing else,
/// and finds all polytopes around those of its sites whose polytopes are certain. Why these are the polytopes of the
/// whole, each found once (docs/algorithms/bricks.md has it at length):
///
/// Invariant: every polytope inside O with an unfinished site has all its sites among those of the round, so it is a
/// polytope of their Delaunay complex. A polytope whose ball lies in the region is one of that complex, with all its
/// sites; seen from an unfinished corner it leads into O only if it is a polytope of the whole, since those fill O
/// there. A site is finished when such polytopes close up around it; then it has no others, and every polytope is found
/// where its smallest site is finished, which happens once. A polytope that has finished and unfinished sites was
/// certain in the brick that finished the former; it is carried to the next round, which has all its sites: the
/// invariant again.
namespace quench::dual::bricks {

enum class SiteState : std::uint8_t {
  finished,    ///< its polytopes are all known already; it only bounds the balls of others
  unfinished,  ///< another brick's
  own          ///< an unfinished site of this brick
};

/// The work of one brick: plain values, complete, independent of all other bricks.
struct Brick {
  Brick(const BrickGrid& g, const BrickIndex& i) : grid(g), index(i) {}

  BrickGrid grid;
  BrickIndex index;
  std::array<std::int64_t, 3> spacing{1, 1, 1};
  /// The sites in the region, in order of z, y, x, with their rank among all sites of the shape.
  std::vector<LatticePoint> points;
  std::vector<std::uint32_t> rank;
  std::vector<Octants> octants;
  std::vector<SiteState> state;
};

/// Site lists one after the other.
struct SiteLists {
  std::vector<std::uint32_t> offsets{0}, sites;  ///< ranks, ascending in each list

  std::size_t count() const { return offsets.size() - 1; }
  std::span<const std::uint32_t> operator[](std::size_t i) const {
    return {sites.data() + offsets[i], sites.data() + offsets[i + 1]};
  }
  void add(std::span<const std::uint32_t> list) {
    sites.insert(sites.end(), list.begin(), list.end());
    base::check_index(sites.size());
    offsets.push_back(static_cast<std::uint32_t>(sites.size()));
  }
};

struct BrickPart {
  std::vector<std::uint32_t> finished;  ///< ranks, ascending
  CellsPart found;                      ///< the polytopes whose smallest sites were finished here
  SiteLists carried;  ///< polytopes that this brick knows and some of whose sites may stay unfinished in this round
};

/// Triangulates the sites of a brick, serially or on the threads of the arena. About 360 bytes per site in the region.
BrickPart process_brick(const Brick& brick, Hulls& hulls, Context* context);

}  // namespace quench::dual::bricks
