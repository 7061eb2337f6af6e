// SPDX-License-Identifier: Apache-2.0
#ifdef QUENCH_HAS_HDF5
#include "io/volume/hdf5_spacing.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "base/text.h"

namespace quench::io {
namespace {

constexpr hsize_t kMostNumbers = 64;

Hdf5Handle attribute(hid_t object, const char* name) {
  if (H5Aexists(object, name) <= 0) return {};
  return {H5Aopen(object, name, H5P_DEFAULT), H5Aclose};
}

/// Nothing where there is no such attribute, or no numbers in it.
std::optional<std::vector<double>> numbers_in(hid_t object, const char* name) {
  const Hdf5Handle found = attribute(object, name);
  if (!found.valid()) return {};
  const Hdf5Handle space(H5Aget_space(found.id()), H5Sclose), type(H5Aget_type(found.id()), H5Tclose);
  const hssize_t count = space.valid() ? H5Sget_simple_extent_npoints(space.id()) : 0;
  const H5T_class_t kind = type.valid() ? H5Tget_class(type.id()) : H5T_NO_CLASS;
  if ((kind != H5T_INTEGER && kind != H5T_FLOAT) || count < 1 || count > static_cast<hssize_t>(kMostNumbers))
    return std::vector<double>();
  std::vector<double> numbers(static_cast<std::size_t>(count));
  if (H5Aread(found.id(), H5T_NATIVE_DOUBLE, numbers.data()) < 0) return std::vector<double>();
  return numbers;
}

/// The first string of an attribute; empty where there is none.
std::string text_in(hid_t object, const char* name) {
  constexpr std::size_t kLongest = 1 << 20;
  const Hdf5Handle found = attribute(object, name);
  if (!found.valid()) return {};
  const Hdf5Handle space(H5Aget_space(found.id()), H5Sclose), type(H5Aget_type(found.id()), H5Tclose);
  const hssize_t count = space.valid() ? H5Sget_simple_extent_npoints(space.id()) : 0;
  if (!type.valid() || H5Tget_class(type.id()) != H5T_STRING || count < 1 ||
      count > static_cast<hssize_t>(kMostNumbers))
    return {};
  const auto n = static_cast<std::size_t>(count);
  if (H5Tis_variable_str(type.id()) > 0) {
    std::vector<char*> texts(n, nullptr);
    if (H5Aread(found.id(), type.id(), texts.data()) < 0) return {};
    std::string text = texts[0] ? texts[0] : "";
    H5Dvlen_reclaim(type.id(), space.id(), H5P_DEFAULT, texts.data());
    return text;
  }
  const std::size_t size = H5Tget_size(type.id());
  if (size == 0 || size > kLongest) return {};
  std::string all(n * size, '\0');
  if (H5Aread(found.id(), type.id(), all.data()) < 0) return {};
  const std::string first = all.substr(0, size);
  return first.substr(0, first.find('\0'));
}

/// The numbers of x, y, z; the others stay.
bool take_numbers(const std::vector<double>& numbers, std::size_t rank, const std::array<int, 3>& axis, Vec3& to) {
  std::size_t used = 0;
  for (const int a : axis) used += a >= 0;
  for (std::size_t a = 0; a < used; ++a) {
    std::size_t at = 0;
    if (numbers.size() == rank)
      at = static_cast<std::size_t>(axis[a]);
    else if (numbers.size() == used)
      at = used - 1 - a;
    else
      return false;
    to[static_cast<int>(a)] = numbers[at];
  }
  return true;
}

bool are_lengths(const Vec3& v) { return v.allFinite() && v.minCoeff() > 0; }

/// The resolutions in the JSON of vigra: {"axes": [{"key": "z", "resolution": 0.5}, ...]}, 0 where they are not known.
std::optional<std::vector<double>> resolutions_in_axistags(hid_t dataset, std::size_t rank) {
  const auto tags = nlohmann::json::parse(text_in(dataset, "axistags"), nullptr, false);
  if (!tags.is_object() || !tags.contains("axes") || !tags["axes"].is_array() || tags["axes"].size() != rank) return {};
  std::vector<double> numbers;
  for (const auto& entry : tags["axes"]) {
    if (!entry.is_object() || !entry.contains("resolution") || !entry["resolution"].is_number()) return {};
    numbers.push_back(entry["resolution"]);
  }
  return numbers;
}

}  // namespace

Hdf5Spacing hdf5_spacing(hid_t dataset, std::size_t rank, const std::array<int, 3>& axis) {
  Hdf5Spacing result;
  for (const char* name : {"element_size_um", "axistags", "voxel_size", "resolution", "spacing"}) {
    const bool tags = std::string_view(name) == "axistags";
    const auto numbers = tags ? resolutions_in_axistags(dataset, rank) : numbers_in(dataset, name);
    if (!numbers) continue;
    Vec3 spacing = Vec3::Ones();
    if (!take_numbers(*numbers, rank, axis, spacing) || !are_lengths(spacing)) {
      if (!tags)
        result.note = fmt::format(
            "has an attribute '{}' that does not hold a positive number for each axis, and is not "
            "used for the spacing",
            name);
      continue;
    }
    result.spacing = spacing;
    result.source = fmt::format("the attribute '{}'", name);
    result.note.clear();
    if (std::string_view(name) == "element_size_um") {
      result.units = "um";
    } else {
      std::string units = text_in(dataset, "units");
      result.units = base::plain(units.empty() ? text_in(dataset, "unit") : units).substr(0, 40);
      const auto offset = numbers_in(dataset, "offset");
      Vec3 origin = Vec3::Zero();
      if (offset && take_numbers(*offset, rank, axis, origin) && origin.allFinite()) result.origin = origin;
    }
    break;
  }
  return result;
}

}  // namespace quench::io
#endif
