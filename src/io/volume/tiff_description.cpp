// SPDX-License-Identifier: Apache-2.0
#include "io/volume/tiff_description.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <pugixml.hpp>
#include <string_view>
#include <vector>

#include "io/common/words.h"
#include "io/volume/stored_volume.h"

namespace quench::io {
namespace {

/// A count; 1 for what is not one.
std::int64_t count(std::string_view text) {
  std::int64_t value = 1;
  return parse_integer(trimmed(text), value) ? std::max<std::int64_t>(1, value) : 1;
}

bool usable(double length) { return std::isfinite(length) && length > 0; }

/// A text that is there but not a number gives a size that cannot be used.
double length(std::string_view text) {
  double value = 0;
  return parse_number(trimmed(text), value) ? value : 0;
}

// ImageJ writes "key=value" lines; all pictures have the size of the first.
void read_imagej(std::string_view text, TiffDescription& d) {
  d.name = "ImageJ description";
  d.one_directory = true;  // where they take more than 4 GB
  std::optional<std::string> z_unit;
  while (!text.empty()) {
    const auto end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    const auto equals = line.find('=');
    if (equals == line.npos) continue;
    const std::string_view key = line.substr(0, equals), value = trimmed(line.substr(equals + 1));
    if (key == "images") d.images = count(value);
    if (key == "channels") d.channels = count(value);
    if (key == "frames") d.times = count(value);
    if (key == "unit") d.unit = value;
    if (key == "zunit") z_unit = value;
    if (std::int64_t kind = 0; key == "cf" && parse_integer(value, kind)) d.function = kind;
    for (const std::size_t i : {0, 1})
      if (key == fmt::format("c{}", i) && !parse_number(value, d.line[i])) d.line[i] = 0;
    if (key == "spacing" && length(value) != 0) d.size[2] = {std::abs(length(value)), {}};  // ImageJ: 0 is not given
  }
  if (d.size[2]) d.size[2]->unit = z_unit.value_or(d.unit.value_or(""));
}

/// Whether the planes of an image are in files of more than one name.
bool several_files(const pugi::xml_node& pixels) {
  std::string_view first;
  for (const pugi::xml_node data : pixels.children())
    for (const pugi::xml_node uuid : data.children()) {
      const std::string_view name = uuid.attribute("FileName").value();
      if (!first.empty() && !name.empty() && name != first) return true;
      if (first.empty()) first = name;
    }
  return false;
}

void read_ome(const pugi::xml_document& document, TiffDescription& d) {
  const auto local = [](const pugi::xml_node& node) {
    const std::string_view name = node.name();
    return name.substr(name.find(':') + 1);  // npos + 1 is 0
  };
  d.name = "OME-XML description";
  d.volumes = 0;
  for (const pugi::xml_node image : document.document_element().children()) {
    if (local(image) != "Image") continue;
    if (d.volumes++ > 0) continue;
    for (const pugi::xml_node pixels : image.children()) {
      if (local(pixels) != "Pixels") continue;
      d.channels = count(pixels.attribute("SizeC").value());
      d.times = count(pixels.attribute("SizeT").value());
      if (std::int64_t z = 0; parse_integer(trimmed(pixels.attribute("SizeZ").value()), z))
        d.images = std::max<std::int64_t>(1, z);
      d.several_files = several_files(pixels);
      for (std::size_t a = 0; a < 3; ++a) {
        const std::string name = std::string("PhysicalSize") + "XYZ"[a];
        if (const pugi::xml_attribute size = pixels.attribute(name.c_str()))
          d.size[a] = {length(size.value()), pixels.attribute((name + "Unit").c_str()).as_string("um")};
      }
      break;
    }
  }
  d.volumes = std::max<std::int64_t>(1, d.volumes);
}

/// The text behind `"name":` in a flat JSON object.
std::string_view json_value(std::string_view text, std::string_view name) {
  const auto at = text.find(fmt::format("\"{}\"", name));
  const auto colon = at == text.npos ? at : text.find(':', at);
  return colon == text.npos ? std::string_view() : trimmed(text.substr(colon + 1));
}

// tifffile: {"shape": [2, 10, 64, 64], "axes": "CZYX", "truncated": true}; the last two axes are a picture.
void read_shaped(std::string_view text, TiffDescription& d) {
  std::string_view list = json_value(text, "shape");
  if (!list.starts_with('[')) return;
  list = list.substr(1, list.find(']') - 1);
  std::vector<std::int64_t> shape;
  for (std::size_t begin = 0; begin <= list.size();) {
    const auto end = std::min(list.find(',', begin), list.size());
    shape.push_back(count(list.substr(begin, end - begin)));
    begin = end + 1;
  }
  if (shape.size() < 3) return;
  shape.resize(shape.size() - 2);
  d.name = "tifffile description";
  d.images = 1;
  std::string_view axes = json_value(text, "axes");
  if (axes.starts_with('"')) axes = axes.substr(1, axes.find('"', 1) - 1);
  constexpr std::int64_t kMost = std::int64_t{1} << 31;
  for (std::size_t i = 0; i < shape.size(); ++i) {
    const char axis = axes.size() == shape.size() + 2 ? axes[i] : '?';
    std::int64_t& of = axis == 'C' ? d.channels : axis == 'T' ? d.times : i + 1 == shape.size() ? d.images : d.volumes;
    of = std::min(of * std::min(shape[i], kMost), kMost);
  }
  if (json_value(text, "truncated").starts_with("true")) d.one_directory = true;
}

/// Three sizes in the unit of the first; nothing where a size cannot be used or the units cannot be compared. Units of
/// no known length are not told of: "pixel", "reference frame".
std::optional<TiffCalibration> in_one_unit(const std::array<TiffLength, 3>& sizes) {
  TiffCalibration result;
  const LengthUnit first = known_unit(sizes[0].unit);
  for (std::size_t a = 0; a < 3; ++a) {
    const LengthUnit unit = known_unit(sizes[a].unit);
    if ((unit.metres > 0) != (first.metres > 0) || (unit.metres == 0 && sizes[a].unit != sizes[0].unit)) return {};
    const double to_first = unit.name == first.name ? 1 : unit.metres / first.metres;
    result.spacing[static_cast<Eigen::Index>(a)] = sizes[a].value * unit.factor * to_first;
    if (!usable(result.spacing[static_cast<Eigen::Index>(a)])) return {};
  }
  result.units = first.name;
  return result;
}

/// "0.1 x 0.2 mm"
std::string lengths(std::initializer_list<double> values, const std::string& unit) {
  const LengthUnit known = known_unit(unit);
  std::string text;
  for (const double value : values) text += fmt::format("{}{:.6g}", text.empty() ? "" : " x ", value * known.factor);
  return known.name.empty() ? text : text + " " + known.name;
}

constexpr const char* kTakenAsOne = "the spacing is taken as 1 x 1 x 1; give another one where that is wrong";

/// Pixels that are not squares are meant so, unlike dots per inch: their sizes are put ready.
std::string change_of_spacing(double x, double y, const std::string& unit) {
  constexpr double kRounding = 0.01;
  if (std::abs(x - y) <= kRounding * std::max(x, y)) return kTakenAsOne;
  const double factor = known_unit(unit).factor;
  return fmt::format("the spacing is taken as 1 x 1 x 1; give the spacing {:.6g},{:.6g},Z, where Z is that distance",
                     x * factor, y * factor);
}

TiffCalibration without_spacing(const std::optional<double>& x, const std::optional<double>& y,
                                const std::string& unit) {
  TiffCalibration result;
  if ((x && !usable(*x)) || (y && !usable(*y)))
    result.note = fmt::format("gives a size of pixels that is not positive and finite; {}", kTakenAsOne);
  else if (x && y && (known_unit(unit).metres > 0 || *x != *y))
    result.note = fmt::format("gives a size of pixels, {}, but no distance of slices; {}", lengths({*x, *y}, unit),
                              change_of_spacing(*x, *y, unit));
  return result;
}

TiffCalibration contradictory() {
  TiffCalibration result;
  result.note =
      fmt::format("gives sizes of voxels that are not positive and finite or not in units of length; {}", kTakenAsOne);
  return result;
}

/// OME with some of the sizes, but not those of x and y.
TiffCalibration without_pixels(const TiffDescription& d) {
  const auto& [x, y, z] = d.size;
  for (const auto& size : {x, y, z})
    if (size && !usable(size->value)) return contradictory();
  const auto text = [](const TiffLength& size) { return lengths({size.value}, size.unit); };
  TiffCalibration result;
  if (x || y)
    result.note =
        fmt::format("gives a size of pixels along {} only ({}); {}", x ? "x" : "y", text(x ? *x : *y), kTakenAsOne);
  else
    result.note = fmt::format("gives a distance of slices ({}) but no size of pixels; {}", text(*z), kTakenAsOne);
  return result;
}

TiffCalibration of_ome(const TiffDescription& d, const TiffResolution& resolution) {
  const auto& size = d.size;
  if (!size[0] && !size[1] && !size[2]) return without_spacing(resolution.x, resolution.y, resolution.unit);
  if (!size[0] || !size[1]) return without_pixels(d);
  if (!size[2]) return without_spacing(size[0]->value, size[1]->value, size[0]->unit);
  return in_one_unit({*size[0], *size[1], *size[2]}).value_or(contradictory());
}

/// ImageJ's resolution tags and their unit: 72 dots per inch are not a calibration.
TiffResolution imagej_resolution(const TiffDescription& d, TiffResolution resolution) {
  constexpr double kScreen = 1.0 / 72;
  if (!d.unit && resolution.unit == "inch" && resolution.x == kScreen) return {1.0, 1.0, ""};
  resolution.unit = d.unit.value_or(resolution.unit);
  return resolution;
}

/// Whether a unit is one of a microscope or ruler, not of a scanner of paper: dots per inch, or the same per
/// centimetre.
bool measures(const std::string& text) {
  const LengthUnit unit = known_unit(text);
  return unit.metres > 0 && unit.factor == 1 && unit.name != "cm";
}

// As ImageJ's FileOpener: the unit of the description is that of the resolution tags, a missing size is 1.
TiffCalibration of_imagej(const TiffDescription& d, const TiffResolution& tags, std::int64_t slices) {
  const TiffResolution resolution = imagej_resolution(d, tags);
  const std::string& unit = resolution.unit;
  const double x = resolution.x.value_or(1), y = resolution.y.value_or(1);
  if (d.size[2]) {
    const std::string z_unit = d.size[2]->unit.empty() ? unit : d.size[2]->unit;
    auto result = in_one_unit({TiffLength{x, unit}, {y, unit}, {d.size[2]->value, z_unit}}).value_or(contradictory());
    if (result.note.empty()) result.source = "the " + d.name;
    return result;
  }
  if (slices > 1 && resolution.x && resolution.y && measures(unit))
    if (auto result = in_one_unit({TiffLength{x, unit}, {y, unit}, {1, unit}})) {
      result->source =
          fmt::format("the {}, which gives no distance of slices: ImageJ takes 1 {} then", d.name, result->units);
      return *result;
    }
  return without_spacing(resolution.x, resolution.y, unit);
}

}  // namespace

LengthUnit known_unit(std::string_view text) {
  text = trimmed(text);
  bool micro = false;
  for (const std::string_view sign : {"\\u00B5", "\\u00b5", "\xC2\xB5", "\xCE\xBC", "\xB5"})
    if (!micro && text.starts_with(sign)) {
      text.remove_prefix(sign.size());
      micro = true;
    }
  std::string name = fmt::format("{}{}", micro ? "u" : "", text);
  for (char& c : name)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  const auto among = [&](std::initializer_list<const char*> list) {
    return std::any_of(list.begin(), list.end(), [&](const char* one) { return name == one; });
  };
  if (among({"nm", "nanometer", "nanometers", "nanometre", "nanometres"})) return {"nm", 1e-9};
  if (among({"um", "micron", "microns", "micrometer", "micrometers", "micrometre", "micrometres"})) return {"um", 1e-6};
  if (among({"mm", "millimeter", "millimeters", "millimetre", "millimetres"})) return {"mm", 1e-3};
  if (among({"cm", "centimeter", "centimeters", "centimetre", "centimetres"})) return {"cm", 1e-2};
  if (among({"m", "meter", "meters", "metre", "metres"})) return {"m", 1};
  if (among({"in", "inch", "inches", "\""})) return {"mm", 1e-3, 25.4};
  if (among({"angstrom", "angstroms", "\xC3\x85", "\xE2\x84\xAB", "\\u00c5"})) return {"angstrom", 1e-10};
  return {};
}

TiffDescription tiff_description(const std::string& text) {
  TiffDescription d;
  const std::string_view trimmed_text = trimmed(text);
  if (trimmed_text.starts_with("ImageJ=")) {
    read_imagej(trimmed_text, d);
  } else if (trimmed_text.starts_with('<') && text.find("OME") != text.npos) {
    pugi::xml_document document;
    if (document.load_buffer(text.data(), text.size()) &&
        std::string_view(document.document_element().name()).ends_with("OME"))
      read_ome(document, d);
  } else if (trimmed_text.starts_with('{')) {
    read_shaped(trimmed_text, d);
  }
  return d;
}

double pixel_side(std::uint32_t numerator, std::uint32_t denominator) {
  const double n = numerator, d = denominator;
  const double side = d / n;
  if (!usable(side)) return 0;
  double precision = 1000;  // of the fraction, beyond the digits: that a number fits is not chance then
  for (int digits = 1; digits <= 6 && n >= precision; ++digits, precision *= 10) {
    const double shortest = length(fmt::format("{:.{}g}", side, digits));
    if (std::abs(1 / shortest - n / d) <= 1 / d) return shortest;
  }
  return side;
}

TiffCalibration tiff_calibration(const TiffDescription& description, const TiffResolution& resolution,
                                 std::int64_t slices) {
  if (description.name == "ImageJ description") return of_imagej(description, resolution, slices);
  if (description.name == "OME-XML description") {
    TiffCalibration result = of_ome(description, resolution);
    if (description.size[2] && result.note.empty()) result.source = "the " + description.name;
    return result;
  }
  return without_spacing(resolution.x, resolution.y, resolution.unit);
}

TiffCalibration tiff_plane_calibration(const TiffDescription& description, const TiffResolution& tags) {
  std::optional<TiffLength> x, y;
  TiffResolution resolution = tags;
  if (description.name == "OME-XML description") {
    x = description.size[0];
    y = description.size[1];
  } else if (description.name == "ImageJ description") {
    resolution = imagej_resolution(description, tags);
    if (resolution.x && resolution.y && measures(resolution.unit)) {
      x = {*resolution.x, resolution.unit};
      y = {*resolution.y, resolution.unit};
    }
  }
  TiffCalibration result;
  if (x && y) {
    if (auto known = in_one_unit({*x, *y, *x})) {
      known->source = "the " + description.name;
      return *known;
    }
    result.note = "gives a size of pixels that is not positive and finite; the spacing is taken as 1 x 1";
  } else if (resolution.x && resolution.y && usable(*resolution.x) && usable(*resolution.y) &&
             *resolution.x != *resolution.y) {
    const double factor = known_unit(resolution.unit).factor;
    result.note = fmt::format(
        "has pixels that are not squares ({}); the spacing is taken as 1 x 1; give the spacing "
        "{:.6g},{:.6g} where they are meant so",
        lengths({*resolution.x, *resolution.y}, resolution.unit), *resolution.x * factor, *resolution.y * factor);
  }
  return result;
}

}  // namespace quench::io
