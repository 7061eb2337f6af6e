// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "dual/cells.h"
#include "dual/dual_complex.h"
#include "quench/context.h"
#include "quench/shape.h"

/// The Delaunay complex inside O in parts: what is known of it in a box, at first the small polytopes along the
/// boundary, then, in ever larger boxes, all whose balls lie in a region around the box, in the end all. Between the
/// boxes lie unmatched facets. What a pruning has removed meanwhile is gone; what it needs to know of that is carried
/// along. Parts are values: they are written to files and read by other processes (docs/algorithms/bricks.md).
namespace quench::dual::bricks {

/// A half-open box of lattice points: low <= p < high.
struct Box {
  std::array<std::int64_t, 3> low{}, high{};

  bool contains(const LatticePoint& p) const {
    for (std::size_t a = 0; a < 3; ++a)
      if (p[a] < low[a] || p[a] >= high[a]) return false;
    return true;
  }
};

/// Cells of the whole complex, of which a part knows some.
struct Counts {
  std::uint64_t vertices = 0, edges = 0, faces = 0;
};

/// What is known of a face beyond its sites.
struct FaceValue {
  std::array<std::uint32_t, 2> sites{};  ///< places in Part::sites, ascending
  double value = 0;                      ///< cap height as it counts; where it is final, the detail
  bool final = false;                    ///< the detail is known: part of a component that is not significant
};

/// A polytope belongs to the part whose box holds its smallest site, and so does a boundary square; nothing else is in
/// a part. Polytopes are in order of their sites (but for joined()), unmatched facets in order of theirs: a part
/// depends on nothing but what it knows.
///
/// A link is what lies across a facet, an entry of Cells::neighbours. A pruned link (kPruned) is an edge of the core
/// that was removed; a pruned vertex is a polytope that is not there any more. A face is removed together with one of
/// its edges, so it is there exactly if the star of polytopes around its two sites closes without a pruned link.
struct Part {
  std::vector<LatticePoint> sites;  ///< of the whole lattice, in order of z, y, x: those that `found` names
  CellsPart found;                  ///< sites are places in `sites`; `unmatched` lists all unmatched facets and squares

  /// What pruned cells have left behind: the largest lambda and detail of the pruned faces around an edge (per link,
  /// the same on both sides), of the pruned edges around a vertex (per polytope); -1 where there are none. These and
  /// `contact` are empty until extend() is called.
  std::vector<double> link_lambda, link_detail, vertex_lambda, vertex_detail;
  /// Per corner of each polytope (as Cells::sites): whether some face of the whole core around the vertex has the site.
  std::vector<std::uint8_t> contact;
  std::vector<FaceValue> faces;  ///< in order of their sites
  /// Sites in the box of which it is not certain that a kept ball is near, in order.
  std::vector<LatticePoint> pending;
  Counts pruned;  ///< cells that are not there any more

  /// Makes the arrays beside the polytopes as long as they must be; new entries are those of cells around which nothing
  /// is pruned. complete() does so where they are not empty.
  void extend();
};

/// Sites around the box of a part within so many lattice steps must be known to first_part().
std::int32_t margin_of_first_part(const std::array<std::int64_t, 3>& spacing);

/// The small polytopes whose smallest site lies in the box, found one by one (docs/algorithms/peeling.md), and the
/// unmatched boundary squares whose smallest site does. `shape`: voxels around the box, at least margin_of_first_part()
/// + 1 beyond it where the whole has voxels there; its voxel (0, 0, 0) is voxel `at` of the whole. `sites`: the
/// boundary vertices of the whole within margin_of_first_part() of the box, in order. `pending` are the sites in the
/// box. About 200 bytes per site.
Part first_part(const VoxelShape& shape, const LatticePoint& at, std::span<const LatticePoint> sites, const Box& box,
                const std::array<std::int64_t, 3>& spacing, Hulls& hulls, Context* context);

/// Parts of disjoint boxes as one, with facets between them matched. Frees them on the way. Polytopes are those of one
/// part after the other, until complete() puts them in order.
Part joined(std::vector<Part> parts, Context* context);

/// All unmatched facets and squares of a part: what encloses the polytopes that it does not know.
struct Unfinished {
  std::vector<LatticePoint> sites;      ///< the corners of all facets, in order
  std::vector<std::uint32_t> begin{0};  ///< corners of facet f: [begin[f], begin[f + 1])
  std::vector<std::uint32_t> corners;   ///< places in `sites`, counter-clockwise seen from the unknown side

  std::size_t size() const { return begin.size() - 1; }
  std::span<const std::uint32_t> corners_of(std::size_t facet) const {
    return {corners.data() + begin[facet], corners.data() + begin[facet + 1]};
  }
};
Unfinished unfinished(const Part& part, const Hulls& hulls);
/// Those of the facets that have a corner in the box: what complete() wants of other parts.
Unfinished near(const Unfinished& unfinished, const Box& box);

/// Adds the polytopes that are certain and whose smallest site lies in the box: those of the Delaunay complex of the
/// unfinished sites that are reached across unmatched facets and whose balls lie in the region.
///
/// `region`: around the box, and beyond the bounds of the whole where the box is at its border (by two voxels; it is
/// not to be cut off there). `around`: what is unfinished in all other parts whose boxes meet it when they are grown by
/// the widest halo that they had so far, one voxel and margin_of_first_part() included. Without a region, that is with
/// all parts joined, `box` holds all sites of the whole, everything is certain, and nothing is unmatched afterwards:
/// otherwise Error(invariant). The spacing times the sides of region or box: at most 3 * 2^20. 360 bytes per unfinished
/// site.
void complete(Part& part, const Box& box, const Box* region, std::span<const Unfinished> around,
              const std::array<std::int64_t, 3>& spacing, Hulls& hulls, Context* context);

/// The complex of what is there.
struct PartComplex {
  DualComplex
      dual;  ///< vertex p is polytope p of the part: in order as those of the whole; sites: places in Part::sites
  std::vector<std::uint32_t> link_of;  ///< per edge: the entry of Cells::neighbours of its smaller end
  std::vector<std::uint32_t> twin_of;  ///< per edge: the entry of its larger end
  /// Whether cells around an edge or a vertex may be unknown: an edge is incomplete where the star around two of its
  /// sites ends at unmatched facets on both sides, a vertex where it has an unmatched facet or an incomplete edge.
  std::vector<std::uint8_t> edge_incomplete, vertex_incomplete;
};
PartComplex complex_of(const Part& part, const Hulls& hulls, Context* context);

/// Which cells of its complex are removed: a closed rest must be left. Faces follow from the edges.
struct Removal {
  std::vector<std::uint8_t> vertex, edge;
};
/// Takes cells out of a part, with the sites that nothing names any more; counts them in `pruned` (`faces`: removed
/// faces). Throws Error(invariant) where an edge would be left without an end, or a vertex with an unmatched facet
/// goes.
void remove(Part& part, const PartComplex& complex, const Removal& removal, std::uint64_t faces);

}  // namespace quench::dual::bricks
