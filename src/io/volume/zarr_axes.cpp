// SPDX-License-Identifier: Apache-2.0
// After the specification of OME-NGFF (ngff.openmicroscopy.org), and what n5-viewer, Paintera and COSEM write into N5.
#include "io/volume/zarr_axes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/text.h"
#include "io/volume/stored_volume.h"
#include "io/volume/tiff_description.h"
#include "quench/error.h"

namespace quench::io {
namespace {

using nlohmann::json;

/// Version 0.5 puts all of OME under one name.
const json* multiscales_of(const json& attributes) {
  const json* ome = json_member(attributes, "ome");
  const json* list = json_member(ome ? *ome : attributes, "multiscales");
  return list && list->is_array() && !list->empty() ? list : nullptr;
}

/// Objects from version 0.4 on, texts in 0.3, none before.
std::vector<ZarrAxis> named_axes(const json& multiscale) {
  std::vector<ZarrAxis> axes;
  const json* list = json_member(multiscale, "axes");
  if (!list || !list->is_array()) return axes;
  for (const json& axis : *list)
    axes.push_back({axis.is_string() ? axis.get<std::string>() : json_text(json_member(axis, "name")),
                    json_text(json_member(axis, "unit"))});
  return axes;
}

/// Applies the transformations of an image or of one of its levels.
void transform(const std::filesystem::path& file, const json* list, std::vector<ZarrAxis>& axes) {
  if (!list || !list->is_array()) return;
  for (const json& step : *list) {
    const std::string type = json_text(json_member(step, "type"));
    if (type == "identity") continue;
    const auto numbers = json_numbers(json_member(step, type));
    if ((type != "scale" && type != "translation") || !numbers)
      refuse_volume(file, fmt::format("its coordinateTransformations are of the type '{}', and Quench knows scale and "
                                      "translation with their numbers; correct them",
                                      base::plain(type.substr(0, 40))));
    if (axes.empty()) axes.resize(numbers->size());
    if (numbers->size() != axes.size())
      refuse_volume(file, fmt::format("its coordinateTransformations have {} numbers for {} axes; correct them",
                                      numbers->size(), axes.size()));
    for (std::size_t a = 0; a < axes.size(); ++a) {
      if (type == "scale") axes[a].step *= (*numbers)[a];
      axes[a].first = type == "scale" ? axes[a].first * (*numbers)[a] : axes[a].first + (*numbers)[a];
    }
  }
}

bool is_index(const std::string& name, const char* letter) {
  return name.size() == 1 && (name[0] == letter[0] || name[0] == letter[0] - 'a' + 'A');
}

/// Where the names say it: x and y once, z at most once.
std::optional<std::array<std::optional<std::size_t>, 3>> axes_by_name(const std::vector<std::string>& names) {
  std::array<std::optional<std::size_t>, 3> found;
  constexpr std::array kLetters{"x", "y", "z"};
  for (std::size_t a = 0; a < names.size(); ++a)
    for (std::size_t g = 0; g < 3; ++g) {
      if (!is_index(names[a], kLetters[g])) continue;
      if (found[g]) return {};
      found[g] = a;
    }
  if (!found[0] || !found[1]) return {};
  return found;
}

/// Without names the last one is x. Axes of one sample do not count where there are more than three.
std::array<std::optional<std::size_t>, 3> axes_by_place(const std::vector<std::int64_t>& shape) {
  std::vector<std::size_t> axes;
  for (std::size_t a = 0; a < shape.size(); ++a) axes.push_back(a);
  for (auto at = axes.begin(); axes.size() > 3 && at != axes.end();) at = shape[*at] == 1 ? axes.erase(at) : at + 1;
  std::array<std::optional<std::size_t>, 3> found;
  for (std::size_t g = 0; g < std::min<std::size_t>(3, axes.size()); ++g) found[g] = axes[axes.size() - 1 - g];
  return found;
}

/// The numbers of a list that counts x first, or of an object that holds it; the last one first.
std::optional<std::vector<double>> reversed_numbers(const json& object, const char* name) {
  const json* value = json_member(object, name);
  if (value && value->is_object()) value = json_member(*value, "dimensions");
  auto numbers = json_numbers(value);
  if (numbers) std::reverse(numbers->begin(), numbers->end());
  return numbers;
}

}  // namespace

bool is_multiscale(const json& attributes) { return multiscales_of(attributes) != nullptr; }

std::optional<ZarrLevel> zarr_level(const std::filesystem::path& file, const json& attributes,
                                    const std::optional<std::string>& path, Context* context) {
  const json* list = multiscales_of(attributes);
  if (!list) return {};
  if (!path && list->size() > 1)
    note(context, fmt::format("'{}' has {} multiscale images; the first one is taken", file.string(), list->size()));
  for (const json& multiscale : *list) {
    const json* datasets = json_member(multiscale, "datasets");
    if (!datasets || !datasets->is_array() || datasets->empty())
      refuse_volume(file, "its multiscales name no datasets; its attributes are damaged");
    for (const json& dataset : *datasets) {
      ZarrLevel level{json_text(json_member(dataset, "path")), named_axes(multiscale)};
      if (level.path.empty())
        refuse_volume(file, "a dataset of its multiscales has no path; its attributes are damaged");
      if (path && std::filesystem::path(level.path).lexically_normal() != *path) continue;
      transform(file, json_member(dataset, "coordinateTransformations"), level.axes);
      transform(file, json_member(multiscale, "coordinateTransformations"), level.axes);
      return level;
    }
  }
  return {};
}

std::vector<ZarrAxis> n5_axes(const json& array, const json& group) {
  std::vector<ZarrAxis> axes;
  if (const json* transform = json_member(array, "transform")) {
    const auto scale = json_numbers(json_member(*transform, "scale"));
    const auto translate = json_numbers(json_member(*transform, "translate"));
    const json* names = json_member(*transform, "axes");
    const json* units = json_member(*transform, "units");
    if (scale && translate && names && units && names->is_array() && units->is_array() &&
        translate->size() == scale->size() && names->size() == scale->size() && units->size() == scale->size()) {
      for (std::size_t a = 0; a < scale->size(); ++a)
        axes.push_back({json_text(&(*names)[a]), json_text(&(*units)[a]), (*scale)[a], (*translate)[a]});
      return axes;
    }
  }
  const auto of = [&](const char* name) {
    auto numbers = reversed_numbers(array, name);
    return numbers ? numbers : reversed_numbers(group, name);
  };
  auto steps = of("pixelResolution");
  if (!steps) steps = of("resolution");
  if (!steps) return axes;
  const json* units = json_member(array, "units");
  if (!units) units = json_member(group, "units");
  const json* pixel = json_member(array, "pixelResolution");
  if (!pixel) pixel = json_member(group, "pixelResolution");
  const auto factors = reversed_numbers(array, "downsamplingFactors");
  const auto offset = reversed_numbers(array, "offset");
  const std::size_t n = steps->size();
  for (std::size_t a = 0; a < n; ++a) {
    ZarrAxis axis;
    axis.step = (*steps)[a];
    if (pixel) axis.unit = json_text(json_member(*pixel, "unit"));
    if (units && units->is_array() && units->size() == n) axis.unit = json_text(&(*units)[n - 1 - a]);
    if (offset && offset->size() == n) axis.first = (*offset)[a];
    if (factors && factors->size() == n) {  // a sample is the mean of so many; the first one is in their middle
      axis.first += ((*factors)[a] - 1) / 2 * axis.step;
      axis.step *= (*factors)[a];
    }
    axes.push_back(axis);
  }
  return axes;
}

ZarrSection zarr_section(const std::filesystem::path& file, const ZarrArray& array, const std::vector<ZarrAxis>& axes,
                         const std::map<std::string, std::int64_t>& chosen) {
  std::vector<std::string> names = array.names;
  if (!axes.empty() && std::ranges::any_of(axes, [](const ZarrAxis& axis) { return !axis.name.empty(); })) {
    names.clear();
    for (const ZarrAxis& axis : axes) names.push_back(axis.name);
  }
  const std::size_t n = array.axes();
  if (n < 2) refuse_volume(file, fmt::format("it has {} axes, and a volume has three and an image two", n));
  const auto named = axes_by_name(names);
  ZarrSection section;
  section.axis = named ? *named : axes_by_place(array.shape);
  section.at.resize(n, 0);
  names.resize(n);
  constexpr std::array kUsual{"c", "t"};  // before z
  std::size_t unnamed = 0, found = 0;
  for (std::size_t a = n; a-- > 0;) {
    if (std::ranges::find(section.axis, std::optional(a)) != section.axis.end()) continue;
    if (names[a].empty()) names[a] = unnamed < kUsual.size() ? kUsual[unnamed] : fmt::format("axis{}", a);
    ++unnamed;
    const auto at = chosen.find(names[a]);
    const std::string shown = base::plain(names[a].substr(0, 40));
    if (at == chosen.end() && array.shape[a] > 1)
      refuse_volume(file,
                    fmt::format("it has {} samples along its axis {}, of which one is read: add :{}=N to its name, "
                                "with N from 0 to {}",
                                array.shape[a], shown, shown, array.shape[a] - 1));
    if (at == chosen.end()) continue;
    ++found;
    section.at[a] = at->second;
    if (at->second >= array.shape[a])
      refuse_volume(file, fmt::format("its axis {} goes from 0 to {}, and {} is asked for", shown, array.shape[a] - 1,
                                      at->second));
  }
  if (found < chosen.size())
    refuse_volume(file, "what is behind the colon names an axis that it does not have, or one of x, y and z");
  return section;
}

void place_section(const std::filesystem::path& file, const ZarrSection& section, const std::vector<ZarrAxis>& axes,
                   const VolumeReadOptions& options, Grid& grid, Coordinates& coordinates, Context* context) {
  if (axes.empty()) return;
  Mat3 steps = Mat3::Identity();
  bool comparable = true;
  const LengthUnit first = known_unit(axes[*section.axis[0]].unit);
  for (std::size_t g = 0; g < 3; ++g) {
    if (!section.axis[g]) continue;
    const ZarrAxis& axis = axes[*section.axis[g]];
    const LengthUnit unit = known_unit(axis.unit);
    comparable = comparable && (unit.metres > 0) == (first.metres > 0);
    const double factor = unit.factor * (unit.name == first.name ? 1 : unit.metres / first.metres);
    const auto i = static_cast<Eigen::Index>(g);
    steps(i, i) = axis.step * (comparable ? factor : 1);
    grid.origin[i] = axis.first * (comparable ? factor : 1);
  }
  set_steps(file, steps, "scale", grid);
  if (comparable)
    coordinates.units = first.name;
  else if (!options.spacing)
    note(context, fmt::format("'{}' has axes in units that cannot be compared; the spacing is taken as {} x {} x {} "
                              "without units; give another one where that is wrong",
                              file.string(), grid.spacing[0], grid.spacing[1], grid.spacing[2]));
}

}  // namespace quench::io
