// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lattice/predicates.h"
#include "peeling/cells.h"
#include "peeling/site_index.h"
#include "quench/shape.h"

namespace quench::peeling {

/// What all slabs read.
struct Input {
  const VoxelShape& shape;
  std::span<const LatticePoint> sites;
  std::array<std::int64_t, 3> spacing;  ///< integer spacing
  const lattice::Predicates& predicates;
  const SiteIndex& index;
  double reach;        ///< balls up to this radius are looked for, in units of the integer spacing; 0: unit cubes only
  double least_cubes;  ///< with fewer cells of unit cubes per site, unit cubes only

  /// No cell of a ball that is looked for extends further along z, in layers.
  std::int32_t layers() const;
};

/// A facet of a cell of the slab, or a boundary square, whose other side is not a cell of the slab.
struct LooseFacet {
  FacetName name;
  std::uint32_t cell;   ///< in the slab; kNone for a square
  std::uint32_t facet;  ///< of the cell's hull; for a square its place in SlabPart::squares
};

struct SlabPart {
  Cells cells;  ///< those whose smallest site lies in the slab
  std::vector<Square> squares;
  std::vector<LooseFacet> loose;
};

/// Finds cells around the sites with layer z in [begin, end): first all of radius of a unit cube, from a table; then
/// facet by facet those of balls up to `reach` that can be walked to from the boundary. Cells are those of the whole
/// complex, whatever the slab; some may be missing, and which ones depends on the slabs.
SlabPart peel_slab(const Input& input, std::int32_t begin, std::int32_t end, Hulls& hulls);

}  // namespace quench::peeling
