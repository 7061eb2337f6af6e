// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "delaunay/bounds.h"
#include "delaunay/predicates.h"
#include "dual/cells.h"
#include "dual/peel/site_index.h"
#include "quench/shape.h"

namespace quench::dual::peel {

/// What all slabs read.
struct Input {
  const VoxelShape& shape;
  std::span<const LatticePoint> sites;
  std::array<std::int64_t, 3> spacing;  ///< integer spacing
  const delaunay::Predicates& predicates;
  const SiteIndex& index;
  delaunay::Bounds known;  ///< between them the sites are all there are
  double reach;        ///< balls up to this radius are looked for, in units of the integer spacing; 0: unit cubes only
  double least_cubes;  ///< with fewer polytopes of unit cubes per site, unit cubes only

  /// No polytope of a ball that is looked for extends further along z, in layers.
  std::int32_t layers() const;
};

/// Finds polytopes around the sites of a box, a slab of layers z if it has no other bounds: first all of radius of a
/// unit cube, from a table; then facet by facet those of balls up to `reach` that can be walked to from the boundary.
/// They are polytopes of the whole complex, whatever the box; some may be missing, and which ones depends on the boxes.
/// Handed over are those whose smallest site lies in the box; facets and boundary squares whose other side is not are
/// unmatched.
///
/// Precondition: balls of at most `reach` with a site in the box on them lie between `known`. What is found farther out
/// may not be polytopes of the whole, but it does not leave O, since all boundary squares between `known` are facets
/// there.
CellsPart peel_box(const Input& input, const delaunay::Bounds& box, Hulls& hulls);

}  // namespace quench::dual::peel
