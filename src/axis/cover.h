// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "axis/ball_tree.h"
#include "axis/significant_parts.h"
#include "quench/axis.h"

namespace quench::axis {

/// Balls up to this factor of the automatic detail are those of thin parts: 2.17 voxels for cubes, so that plates of
/// four voxels (2.12) are thin.
inline constexpr double kThin = 2.5;

/// A boundary vertex is near the balls that it lies outside of by less; `least`: the automatic detail.
inline double near_limit(double least) { return 2 * least * (1 + 0.5e-9); }

/// Per site 0 if it lies no farther than 2 * least outside some ball, up to rounding.
std::vector<char> uncovered_sites(std::span<const LatticePoint> sites, const Grid& grid, const BallTree& kept,
                                  double least, Context* context);

/// Paths are at most so many times `least` long: 55 voxels for cubes. Needed lengths grow like the root of the
/// resolution; of 5800 at 1024 voxels seven are longer.
inline constexpr double kLongestPath = 64;
/// They join an earlier one that is so many times `least` away or less.
inline constexpr double kNearPath = 4;
/// The same for those between cells of thin parts, and from them to the rest.
inline constexpr double kLongestThinPath = 16;

/// Raises details to `least` where boundary vertices need it that lie farther than 2 * least outside the balls of the
/// cells with detail `least` or more, such that none is left. On a thick body the shortest path along edges to a ball
/// near enough is kept, where it is no longer than kLongestPath * least, else the largest such ball. In thin parts it
/// is the component that touches the boundary vertex, or else the cells whose balls touch it; shortest paths, no longer
/// than that, then connect these to the rest, since the thinning would by detours.
///
/// `pending`: the boundary vertices that are looked at, in order of z, y, x. In thin parts those that cells touch are
/// sites of the axis.
void cover_boundary(const MedialAxis& axis, double least, std::span<const LatticePoint> pending,
                    SignificantParts& parts, const TopCells& cells, CellValues& detail, Context* context);

}  // namespace quench::axis
