// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

namespace quench::surface {

using Vec2 = Eigen::Vector2d;
using Polygon = std::vector<Vec2>;  ///< convex, counterclockwise
using Segment = std::array<Vec2, 2>;

/// Cuts a convex polygon into convex pieces whose insides no segment crosses; parts of segments outside do not matter.
/// What is nearer than `near` to a cut is on it. O(k log k) pieces for k segments unless many cross.
std::vector<Polygon> cut(const Polygon& polygon, const std::vector<Segment>& segments, double near);

/// Area of a convex polygon by its half perimeter: the radius of its largest circle up to a factor of 2.
double width(const Polygon& polygon);
/// A point inside: of all points the one with the mean coordinates of the area.
Vec2 centroid(const Polygon& polygon);

}  // namespace quench::surface
