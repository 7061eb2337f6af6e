// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "quench/parts.h"

namespace quench::parts {

/// A point of sheets with its values.
struct SheetPoint {
  Vec3 point = Vec3::Zero();
  double radius = 0, erosion = 0;
};
inline SheetPoint mixed(const SheetPoint& a, const SheetPoint& b, double t) {
  return {(1 - t) * a.point + t * b.point, (1 - t) * a.radius + t * b.radius, (1 - t) * a.erosion + t * b.erosion};
}

/// A rim or a seam between two fixed points, which may be one.
struct BorderLine {
  std::vector<std::uint32_t> vertices;
  std::vector<SheetPoint> points;  ///< of the vertices; of rims smoothed
  std::vector<double> at;          ///< length along it
  std::int32_t seam = -1;          ///< -1: a rim
  double length() const { return at.back(); }
  /// The place at a length along it.
  SheetPoint place(double along) const;
};

/// The edges of a mesh that have not exactly two triangles, as lines. Rims are smoothed over the length `corner`.
struct BorderLines {
  std::vector<BorderLine> lines;
  /// Per vertex: it may not move. Those at which lines end, meet or turn by more than 50 degrees between what `corner`
  /// reaches before and behind them, one of each closed line, those around which triangles are no fan or no leaves of a
  /// book, and the fixed ones of the mesh.
  std::vector<char> fixed;
};
BorderLines border_lines(const SheetMesh& mesh, double corner);

}  // namespace quench::parts
