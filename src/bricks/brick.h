// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "bricks/brick_grid.h"
#include "bricks/octants.h"
#include "quench/context.h"

/// The voxel core brick by brick: a brick knows all sites of its round in its region and nothing else, and finds all
/// cells around those of its sites whose cells are certain. Why these are the cells of the whole, each found once
/// (docs/algorithms/bricks.md has it at length):
///
/// Invariant: every cell inside O with an unfinished site has all its sites among those of the round, so it is a cell
/// of their Delaunay complex. A cell whose ball lies in the region is one of that complex, with all its sites; seen
/// from an unfinished corner it leads into O only if it is a cell of the whole, since those fill O there. A site is
/// finished when such cells close up around it; then it has no others, and every cell is found where its smallest site
/// is finished, which happens once. A cell that has finished and unfinished sites was certain in the brick that
/// finished the former; it is kept in `known`, and the next round has all its sites: the invariant again.
namespace quench::bricks {

/// What a brick is to do with a site.
enum class Role : std::uint8_t {
  known,       ///< its cells are all known already; it only bounds the balls of others
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
  std::vector<Role> role;
};

/// Site lists one after the other.
struct SiteLists {
  std::vector<std::uint32_t> offsets{0}, sites;  ///< ranks, ascending in each list

  std::size_t count() const { return offsets.size() - 1; }
};

/// What a brick found: everything around its finished sites. Each cell is found by exactly one brick: the one that
/// finishes its smallest site.
struct BrickPart {
  std::vector<std::uint32_t> finished;  ///< ranks, ascending
  SiteLists vertices;                   ///< sorted by their lists
  /// Vertices of the core that other bricks own: four sites that span space, the smallest one of all first.
  std::vector<std::array<std::uint32_t, 4>> elsewhere;
  /// Vertices are numbered from 0 in `vertices`, then in `elsewhere`.
  std::vector<std::array<std::uint32_t, 2>> edges;
  std::vector<std::array<std::uint32_t, 2>> face_sites;  ///< ascending
  std::vector<std::uint32_t> face_offsets{0}, face_corners;
  /// Cells that this brick knows and that perhaps contain sites which nobody finishes now.
  SiteLists known;
};

/// Triangulates the sites of a brick, serially or on the threads of the arena. About 360 bytes per site in the region.
BrickPart work(const Brick& brick, Context* context);

}  // namespace quench::bricks
