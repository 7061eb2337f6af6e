// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "quench/graph.h"

namespace quench::tree {

/// A polyline with what is known along it: a branch, a part of one, or several in a row. Arrays that are empty are not
/// known.
struct Polyline {
  std::vector<Vec3> points;
  std::vector<double> radius;
  std::vector<double> erosion_thickness, mgf;
  std::vector<std::uint32_t> vertices;  ///< of the skeleton; as many as points, or not known any more
  std::vector<std::uint8_t> bridged;    ///< per segment; empty: nowhere
  double thickness = 0;

  bool empty() const { return points.empty(); }
  double length() const { return arc().back(); }
  /// The distance along the course from its begin, per point.
  std::vector<double> arc() const;
};

Polyline polyline_of(const CurveGraph::Branch& branch);
/// A straight course of two points.
Polyline straight(const Vec3& a, double radius_a, const Vec3& b, double radius_b, bool bridged);
/// The course from `begin` to `end`, distances along it.
Polyline part_of(const Polyline& course, double begin, double end);
Polyline reversed(Polyline course);
/// Puts `more` behind `to`, whose last point is the first of `more`.
void append(Polyline& to, const Polyline& more);

/// A place on a course.
struct PolylinePlace {
  Vec3 point;
  double radius;
};
PolylinePlace place_on(const Polyline& course, const std::vector<double>& arc, double at);

}  // namespace quench::tree
