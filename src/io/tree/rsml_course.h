// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "io/tree/rsml.h"
#include "quench/geometry.h"

/// The course of a root of an RSML file and the functions along it.
namespace quench::io {

/// A place on a polyline: on the segment that begins at point `index`, at this part of it.
struct RsmlPlace {
  std::uint32_t index = 0;
  double part = 0;
  friend auto operator<=>(const RsmlPlace&, const RsmlPlace&) = default;
};

struct RsmlFunction {
  pugi::xml_node node;
  std::string name;    ///< in lower case
  std::string domain;  ///< "polyline", "length", "uniform"
};

/// The functions of a root, whatever the dialect calls their elements.
std::vector<RsmlFunction> rsml_functions_of(const pugi::xml_node& root);

/// A function of numbers at the points of a polyline; empty where it has no number. Beyond its samples the last one
/// holds.
std::vector<double> rsml_at_points(const RsmlFunction& function, const std::vector<Vec3>& points);

/// The place on the polyline nearest to a point: the first of equals. At its points within rounding.
RsmlPlace rsml_nearest_place(const std::vector<Vec3>& polyline, const Vec3& point);

Vec3 rsml_point_at(const std::vector<Vec3>& polyline, const RsmlPlace& place);

/// The root element as it is to be written again: without the roots it bears, its polyline, and the functions that the
/// tree has itself. Functions along the polyline are given for `places`.
std::string rsml_foreign_part(const pugi::xml_node& root, const std::vector<RsmlPlace>& places);

}  // namespace quench::io
