// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>
#include <vector>

#include "quench/axis.h"

namespace quench::axis {

/// A measure that is derived from another one. It is computed when a file is written, and takes no memory before unless
/// it is added to the axis.
struct DerivedMeasure {
  std::string_view name;
  std::string_view from;  ///< the measure it needs
  bool is_length;         ///< written in double precision: thresholds may be ties; else in single precision
  CellValues (*values)(const MedialAxis& axis, const CellValues& from);
};

/// Those that can be derived from what the axis has, in the order of the table in measures.cpp.
std::vector<DerivedMeasure> derivable(const MedialAxis& axis);

/// A new measure is a function in a file of its own, declared here, and a line in the table.
CellValues object_angles(const MedialAxis& axis, const CellValues& lambda);
CellValues cap_heights(const MedialAxis& axis, const CellValues& lambda);

/// Height of the cap that a chord of length 2 lambda cuts off a ball: r - sqrt(r^2 - lambda^2), r where lambda is
/// larger. Right to a few units in the last place.
double cap_height(double lambda, double radius);

inline constexpr double kNoTopCell = -1;
/// Cap heights of the cells that are not part of a larger one: all faces, edges without faces, vertices without edges;
/// others have kNoTopCell.
CellValues cap_heights_of_top_cells(const MedialAxis& axis, const CellValues& lambda);
/// Of faces the smallest of their corners, of edges without faces of their ends, of vertices without edges their own; of
/// other cells the largest of those around.
CellValues smallest_of_corners(const CellComplex& complex, const std::vector<double>& of_vertices);
/// Leaves edges and vertices that are part of a larger cell nothing but the largest of the cells around.
void take_largest_around(const CellComplex& complex, CellValues& value);
/// Raises the value of edges to the largest of the faces around, then that of vertices to the largest of the edges.
void spread_to_sides(const CellComplex& complex, CellValues& value);

}  // namespace quench::axis
