// SPDX-License-Identifier: Apache-2.0
#include "pipeline/parameters.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "quench/error.h"
#include "quench/pipeline.h"

namespace quench::pipeline {
namespace {

using Json = nlohmann::ordered_json;

/// The parameters of a result, as its file says them.
class Recorded {
 public:
  Recorded(const std::string& text, const std::string& file) : json_(Json::parse(text, nullptr, false)), file_(file) {}

  /// The value of a parameter that the file has, if it is of the type and `valid`.
  template <class T, class Valid>
  std::optional<T> get(const char* name, bool (Json::*of_type)() const, const Valid& valid) const {
    if (!has(name)) return {};
    const Json& value = json_[name];
    if ((value.*of_type)())
      if (const T taken = value.get<T>(); valid(taken)) return taken;
    throw Error(ErrorCode::input,
                fmt::format("'{}' says in its field 'parameters' that it was made with {} = {}, which cannot be; the "
                            "file was changed, compute it again",
                            file_, name, value.dump(-1, ' ', true, Json::error_handler_t::replace).substr(0, 40)));
  }
  std::optional<std::int64_t> whole(const char* name, std::int64_t least, std::int64_t most) const {
    const auto value = get<Json>(name, &Json::is_number_integer, [&](const Json& number) {
      const bool beyond = number.is_number_unsigned() && number.get<std::uint64_t>() > std::uint64_t{INT64_MAX};
      return !beyond && number.get<std::int64_t>() >= least && number.get<std::int64_t>() <= most;
    });
    if (!value) return {};
    return value->get<std::int64_t>();
  }
  std::optional<Threshold> threshold(const char* name) const {
    const auto value = get<Json>(name, &Json::is_number, [](const Json& number) {
      return !number.is_number_float() || std::isfinite(number.get<double>());
    });
    if (!value) return {};
    if (value->is_number_unsigned()) return value->get<std::uint64_t>();
    if (value->is_number_integer()) return value->get<std::int64_t>();
    return value->get<double>();
  }
  bool has(const char* name) const { return json_.is_object() && json_.contains(name); }
  bool flag(const char* name) const {
    return get<bool>(name, &Json::is_boolean, [](bool) { return true; }).value_or(false);
  }

 private:
  Json json_;
  const std::string& file_;
};

void take_preparation(ShapeOptions& options, const Recorded& recorded, std::vector<std::string>& taken) {
  PreparationOptions& p = options.preparation;
  ForegroundOptions& f = options.foreground;
  if (recorded.flag("interpolate") && !p.interpolate) {
    p.interpolate = true;
    taken.emplace_back("interpolate");
  }
  const auto take = [&](const char* name, int& value, int unset, std::int64_t least, std::int64_t most) {
    const auto n = recorded.whole(name, least, most);
    if (!n || value != unset) return;
    value = static_cast<int>(*n);
    taken.emplace_back(name);
  };
  take("median", p.median, 0, 1, kLargestMedian);
  const auto is_width = [](double width) { return width > 0 && width <= kLargestBlur; };
  if (const auto width = recorded.get<double>("blur", &Json::is_number, is_width); width && p.blur == 0) {
    p.blur = *width;
    taken.emplace_back("blur");
  }
  take("close", f.close, 0, 1, kLargestClosing);
  take("connectivity", f.connectivity, 6, 6, 26);
}

}  // namespace

std::string with_parameters(const std::string& text,
                            std::initializer_list<std::pair<std::string, Parameter>> parameters) {
  Json json = text.empty() ? Json::object() : Json::parse(text);
  for (const auto& parameter : parameters)
    std::visit([&](const auto& value) { json[parameter.first] = value; }, parameter.second);
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string parameters_of(const Record& result) { return field_text(result, "parameters").value_or(""); }

std::vector<std::string> take_recorded(ShapeOptions& options, const Record& result, const std::string& file) {
  constexpr std::int64_t most = std::numeric_limits<std::int64_t>::max();
  const std::string text = parameters_of(result);
  const Recorded recorded(text, file);
  std::vector<std::string> taken;
  if (const auto n = recorded.whole("resolution", 1, kLargestResolution); n && !options.resolution) {
    options.resolution = *n;
    taken.emplace_back("resolution");
  }
  const auto is_side = [](double side) { return side > 0 && std::isfinite(side); };
  if (const auto side = recorded.get<double>("pixel", &Json::is_number, is_side);
      side && !options.pixel && !options.resolution) {
    options.pixel = *side;
    taken.emplace_back("pixel");
  }
  if (const auto n = recorded.whole("feature", 0, most); n && !options.feature) {
    options.feature = static_cast<std::uint64_t>(*n);
    taken.emplace_back("feature");
  }
  const auto is_rule = [](const std::string& name) { return fill_of(name).has_value(); };
  if (const auto rule = recorded.get<std::string>("fill", &Json::is_string, is_rule); rule && !options.fill)
    options.fill = fill_of(*rule);
  const auto is_topology = [](const std::string& name) { return topology_of(name).has_value(); };
  const auto topology = recorded.get<std::string>("topology", &Json::is_string, is_topology);
  if (!options.topology && topology) options.topology = topology_of(*topology);
  if (!options.topology && recorded.has("resolution") && !recorded.has("feature"))
    options.topology = TopologyRule::voxels;  // of older files, too
  ForegroundOptions& f = options.foreground;
  const auto threshold = recorded.threshold("threshold"), seed_threshold = recorded.threshold("seed_threshold");
  const auto label = recorded.whole("label", -most - 1, most);
  if (!f.threshold && !f.label && !options.otsu && !options.recommended) {
    f.threshold = threshold;
    f.seed_threshold = seed_threshold;
    f.label = label;
    if (threshold) taken.emplace_back("threshold");
    if (label) taken.emplace_back("label");
  }
  take_preparation(options, recorded, taken);
  const bool invert = recorded.flag("invert");
  if (invert && !f.invert) taken.emplace_back("invert");
  f.invert |= invert;
  const auto is_spacing = [](const std::string& size) { return spacing_in(size).has_value(); };
  if (const auto size = recorded.get<std::string>("spacing", &Json::is_string, is_spacing); size && !options.spacing) {
    options.spacing = spacing_in(*size);
    options.spacing_text = *size;
    taken.emplace_back("spacing");
  }
  const auto is_channel = [](const std::string& name) {
    constexpr std::array kChannels{"luminance", "alpha", "red", "green", "blue"};
    return std::ranges::find(kChannels, name) != kChannels.end();
  };
  const auto channel = recorded.get<std::string>("channel", &Json::is_string, is_channel);
  if (channel && options.channel.empty()) {
    options.channel = *channel;
    taken.emplace_back("channel");
  }
  if (const auto n = recorded.whole("dimension", 2, 3); n && !options.dimension) {
    options.dimension = static_cast<int>(*n);
    taken.emplace_back("dimension");
  }
  const auto is_surface = [](const std::string& name) { return surface_kind_of(name).has_value(); };
  const auto surface = recorded.get<std::string>("surface", &Json::is_string, is_surface);
  if (!options.surface && !text.empty()) options.surface = surface_kind_of(surface.value_or("voxels"));
  f.largest_component |= recorded.flag("largest_component");
  f.fill_cavities |= recorded.flag("fill_cavities");
  if (const auto n = recorded.whole("min_component", 0, most); n && f.min_component == 0) f.min_component = *n;
  if (const auto n = recorded.whole("min_cavity", 0, most); n && f.min_cavity == 0) f.min_cavity = *n;
  if (const auto n = recorded.whole("subdivide", 1, 64); n && options.subdivide == 1)
    options.subdivide = static_cast<int>(*n);
  return taken;
}

}  // namespace quench::pipeline
