// SPDX-License-Identifier: Apache-2.0
#include "io/tree/rsml_course.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "io/common/words.h"

namespace quench::io {
namespace {

constexpr double kRounding = 1e-9;  // of the length of a segment

void collect(const pugi::xml_node& node, std::vector<RsmlFunction>& found) {
  for (const pugi::xml_node& function : node.children()) {
    if (!rsml_is(function, "function") && !rsml_is(function, "functions")) continue;
    if (const pugi::xml_attribute name = rsml_attribute(function, "name")) {
      std::string domain = rsml_plain_name(rsml_attribute(function, "domain").value());
      found.push_back({function, rsml_plain_name(name.value()), domain.empty() ? "polyline" : std::move(domain)});
    } else {
      collect(function, found);
    }
  }
}

std::vector<double> lengths_along(const std::vector<Vec3>& points) {
  std::vector<double> lengths(points.size(), 0);
  for (std::size_t i = 1; i < points.size(); ++i) lengths[i] = lengths[i - 1] + (points[i] - points[i - 1]).norm();
  return lengths;
}

/// Linear between samples at ascending positions.
double between(const std::vector<double>& positions, const std::vector<double>& values, double at) {
  const auto next = static_cast<std::size_t>(std::ranges::upper_bound(positions, at) - positions.begin());
  if (next == 0) return values.front();
  if (next == positions.size()) return values.back();
  const double step = positions[next] - positions[next - 1];
  return values[next - 1] + (values[next] - values[next - 1]) * ((at - positions[next - 1]) / step);
}

/// The samples at other places of the polyline.
void resample(const std::vector<std::string>& samples, const std::vector<RsmlPlace>& places, pugi::xml_node into) {
  const auto add = [&](const std::string& value) {
    into.append_child("sample").append_attribute("value") = value.c_str();
  };
  for (const RsmlPlace& place : places) {
    if (place.index >= samples.size()) return;
    double a = 0, b = 0;
    if (place.part == 0 || place.index + 1 == samples.size() || !parse_number(samples[place.index], a) ||
        !parse_number(samples[place.index + 1], b))
      add(samples[place.index]);
    else
      add(fmt::format("{}", a + place.part * (b - a)));
  }
}

void copy_attributes(const pugi::xml_node& from, pugi::xml_node to) {
  for (const pugi::xml_attribute& a : from.attributes()) to.append_copy(a);
}

}  // namespace

std::vector<RsmlFunction> rsml_functions_of(const pugi::xml_node& root) {
  std::vector<RsmlFunction> found;
  for (const pugi::xml_node& node : root.children())
    if (rsml_is(node, "functions")) collect(node, found);
  return found;
}

std::vector<double> rsml_at_points(const RsmlFunction& function, const std::vector<Vec3>& points) {
  std::vector<double> values, positions;
  for (const pugi::xml_node& sample : function.node.children()) {
    double value = 0, position = 0;
    if (!rsml_is(sample, "sample")) continue;
    if (!parse_number(rsml_value_of(sample), value) || !std::isfinite(value)) return {};
    values.push_back(value);
    if (function.domain != "length") continue;
    if (!parse_number(rsml_attribute(sample, "position").value(), position) || !(position > -kLargestLength) ||
        (!positions.empty() && !(position > positions.back())))
      return {};
    positions.push_back(position);
  }
  if (values.empty()) return {};
  std::vector<double> result = function.domain == "polyline" ? values : lengths_along(points);
  if (function.domain == "polyline") {
    result.resize(points.size(), values.back());
    return result;
  }
  if (function.domain == "uniform") {
    const bool from_tip = rsml_plain_name(rsml_attribute(function.node, "origin").value()) == "tip";
    if (from_tip) std::ranges::reverse(values);
    const double whole = result.back();
    if (!(whole > 0)) return std::vector<double>(points.size(), values.front());
    for (std::size_t i = 0; i < values.size(); ++i)
      positions.push_back(values.size() == 1 ? 0
                                             : whole * static_cast<double>(i) / static_cast<double>(values.size() - 1));
  }
  for (double& at : result) at = between(positions, values, at);
  return result;
}

RsmlPlace rsml_nearest_place(const std::vector<Vec3>& polyline, const Vec3& point) {
  RsmlPlace best;
  double least = (polyline[0] - point).squaredNorm();
  for (std::uint32_t i = 0; i + 1 < polyline.size(); ++i) {
    const Vec3 along = polyline[i + 1] - polyline[i];
    const double square = along.squaredNorm();
    if (!(square > 0)) continue;
    const double part = std::clamp(along.dot(point - polyline[i]) / square, 0.0, 1.0);
    const double distance = (polyline[i] + part * along - point).squaredNorm();
    if (!(distance < least)) continue;
    least = distance;
    best = part < kRounding ? RsmlPlace{i, 0} : part > 1 - kRounding ? RsmlPlace{i + 1, 0} : RsmlPlace{i, part};
  }
  return best;
}

Vec3 rsml_point_at(const std::vector<Vec3>& polyline, const RsmlPlace& place) {
  const Vec3& from = polyline[place.index];
  return place.part == 0 ? from : from + place.part * (polyline[place.index + 1] - from);
}

std::string rsml_foreign_part(const pugi::xml_node& root, const std::vector<RsmlPlace>& places) {
  pugi::xml_document document;
  pugi::xml_node kept = document.append_child("root");
  copy_attributes(root, kept);
  for (const pugi::xml_node& node : root.children()) {
    if (rsml_is(node, "root") || rsml_is(node, "functions")) continue;
    if (!rsml_is(node, "geometry")) {
      kept.append_copy(node);
      continue;
    }
    pugi::xml_node geometry;  // others than the polyline
    for (const pugi::xml_node& shape : node.children()) {
      if (rsml_is(shape, "polyline")) continue;
      if (!geometry) geometry = kept.append_child("geometry");
      geometry.append_copy(shape);
    }
  }
  pugi::xml_node functions;
  for (const RsmlFunction& function : rsml_functions_of(root)) {
    if (function.name == "diameter" || function.name == "radius" || function.name == kRsmlBridged) continue;
    if (!functions) functions = kept.append_child("functions");
    pugi::xml_node copy = functions.append_child("function");
    copy_attributes(function.node, copy);
    std::vector<std::string> samples;
    for (const pugi::xml_node& sample : function.node.children()) {
      if (function.domain == "polyline" && rsml_is(sample, "sample"))
        samples.push_back(rsml_value_of(sample));
      else
        copy.append_copy(sample);
    }
    resample(samples, places, copy);
  }
  return rsml_text_of(kept);
}

}  // namespace quench::io
