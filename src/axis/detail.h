// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "axis/ball_tree.h"
#include "quench/axis.h"

namespace quench::axis {

/// Cells are significant at detail d when their cap height is above d and that of some cell of their component (of
/// cells with cap heights above d, connected by vertices) above kPeak * d: 1.5 voxels for the automatic detail of cubes.
inline constexpr double kPeak = 1.7320508075688772;

/// Cap heights are lowered by this factor before they are compared, so that those that equal a detail up to rounding are
/// not above it: on flat sides staircases attain half the voxel diagonal.
inline constexpr double kBelowTie = 1 - 2e-9;

/// Per boundary vertex: whether it lies farther than `tolerance` outside all the balls of the tree.
std::vector<char> uncovered(std::span<const LatticePoint> sites, const Grid& grid, const BallTree& kept,
                            double tolerance, Context* context);

/// Raises `vertex_detail` of the vertices that are `least` or more such that for every d >= least each of them has a
/// vertex of detail d or more whose ball, grown by 2 (d - least), contains its own. The largest in each connected
/// component becomes infinite.
void keep_within_reach(const MedialAxis& axis, double least, std::vector<double>& vertex_detail, Context* context);

}  // namespace quench::axis
