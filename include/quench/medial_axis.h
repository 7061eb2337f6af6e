// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "quench/complex.h"
#include "quench/geometry.h"
#include "quench/poly_data.h"

namespace quench {

/// A medial axis: a complex in the world with a radius per vertex. The voxel core fills every member; a foreign medial
/// axis has points, radius and complex only.
///
/// Lengths (radius, lambda, level) are in world units. The level of a cell is the largest pruning threshold it
/// survives: the pruning for lambda is { level >= lambda }; infinite where topology needs the cell at any lambda.
struct MedialAxis {
  CellComplex complex;
  std::vector<Vec3> points;    ///< per vertex
  std::vector<double> radius;  ///< per vertex: distance to its nearest sites

  std::vector<double> vertex_lambda, edge_lambda, face_lambda;  ///< SPEC: half the distance of the two sites for a face
  std::vector<double> vertex_level, edge_level, face_level;     ///< empty before prune()

  std::vector<std::array<std::uint32_t, 2>> face_sites;  ///< the two nearest sites of each face, smaller row first
  std::vector<LatticePoint> sites;                       ///< boundary vertices of the voxel shape that faces refer to
  Grid grid;                                             ///< transform of lattice coordinates
};

}  // namespace quench
