// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "quench/complex.h"

namespace quench::dual {

/// The Delaunay complex inside O, seen from its dual: Delaunay polytope = vertex of the voxel core, facet between two
/// polytopes inside O = edge, Delaunay edge inside O = face. In the plane: Delaunay polygon = vertex, Delaunay edge
/// inside O = edge. Combinatorics only.
struct DualComplex {
  CellComplex complex;
  /// Sites of each vertex (the corners of its polytope, ascending). The sites of an edge are those its two ends share,
  /// since two polytopes of a tessellation meet in a common facet.
  std::vector<std::uint32_t> vertex_site_offsets, vertex_sites;
  std::vector<std::array<std::uint32_t, 2>> face_sites;  ///< ascending
  std::vector<std::array<std::uint32_t, 2>> edge_sites;  ///< of the plane: the same of each edge

  std::span<const std::uint32_t> sites_of(std::uint32_t vertex) const {
    return {vertex_sites.data() + vertex_site_offsets[vertex], vertex_sites.data() + vertex_site_offsets[vertex + 1]};
  }
};

}  // namespace quench::dual
