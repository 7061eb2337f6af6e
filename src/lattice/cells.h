// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "lattice/delaunay.h"
#include "lattice/rings.h"
#include "quench/complex.h"
#include "quench/shape.h"

namespace quench::lattice {

/// The Delaunay complex inside O, seen from its dual: Delaunay polytope = vertex of the voxel core, facet between two
/// polytopes inside O = edge, Delaunay edge inside O = face. Combinatorics only.
struct DualComplex {
  CellComplex complex;
  /// Sites of each vertex (the corners of its polytope, ascending). The sites of an edge are those its two ends share,
  /// since two polytopes of a tessellation meet in a common facet.
  std::vector<std::uint32_t> vertex_site_offsets, vertex_sites;
  std::vector<std::array<std::uint32_t, 2>> face_sites;  ///< ascending

  std::span<const std::uint32_t> sites_of(std::uint32_t vertex) const {
    return {vertex_sites.data() + vertex_site_offsets[vertex], vertex_sites.data() + vertex_site_offsets[vertex + 1]};
  }
};

/// Merges cospherical tetrahedra inside O (polytopes.h) and walks around the edges between the polytopes. Cells are
/// sorted by their site lists (vertices), ends (edges) and sites (faces): independent of the triangulation. Face
/// corners run counter-clockwise around the direction from the first to the second site, from the smallest corner.
/// Consumes the triangulation to free its memory early. Linear time up to small sorts, on all threads.
DualComplex dual_complex(const VoxelShape& shape, std::unique_ptr<Delaunay> delaunay,
                         std::span<const LatticePoint> sites, Context* context);

/// Puts faces into a complex whose vertices and edges are there: sorts them by their sites and looks up their edges.
/// `edge_begin`: per vertex the first edge whose smaller end it is.
void store_faces(const std::vector<RawFaces>& raw, std::size_t site_count, const std::vector<std::uint32_t>& edge_begin,
                 DualComplex& dual, Context* context);

/// The edge between two vertices. `edge_begin`: per vertex the first edge whose smaller end it is. Throws
/// Error(invariant) when there is none.
std::uint32_t edge_between(const CellComplex& complex, const std::vector<std::uint32_t>& edge_begin, std::uint32_t u,
                           std::uint32_t v);

}  // namespace quench::lattice
