// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "quench/error.h"
#include "quench/pipeline.h"

namespace quench::pipeline {

Length parse_length(std::string_view text, std::string_view field) {
  using Unit = Length::Unit;
  const auto refuse = [&](const char* reason) -> Length {
    throw Error(ErrorCode::usage, fmt::format("{} '{}' {}", field, text, reason), std::string(field));
  };
  const std::string spelled(text);
  if (text == "inf") return {std::numeric_limits<double>::infinity(), Unit::infinite, spelled};
  if (text.size() > 1 && text[0] == '-' && ((text[1] >= '0' && text[1] <= '9') || text[1] == '.'))
    return refuse("is negative; a length is 0 or more");
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const std::string_view unit = text.substr(static_cast<std::size_t>(end - text.data()));
  if (error == std::errc() && value >= 0 && std::isfinite(value)) {
    if (unit.empty()) return {value, Unit::fraction, spelled};
    if (unit == "%") return {value / 100, Unit::fraction, spelled};
    if (unit == "vox") return {value, Unit::voxels, spelled};
    if (unit == "abs") return {value, Unit::absolute, spelled};
  }
  return refuse("is not a length; give a fraction (0.02 or 2%), voxels (12vox) or world units (3.5abs)");
}

std::optional<Length> parse_length_or_auto(std::string_view text, std::string_view field) {
  if (text == "auto") return {};
  return parse_length(text, field);
}

std::optional<Length> parse_threshold(std::string_view text, const MeasureKind& measure, std::string_view field) {
  const bool is_length = measure.unit == MeasureUnit::length, has_most = std::isfinite(measure.most);
  const std::string range = has_most ? fmt::format("from {} to {}", measure.least, measure.most)
                                     : fmt::format("of at least {}", measure.least);
  const std::string wanted = is_length                              ? "a length"
                             : measure.unit == MeasureUnit::degrees ? "a number of degrees " + range
                                                                    : "a number " + range;
  if (text == "auto") {
    if (measure.automatic) return {};
    throw Error(ErrorCode::usage, fmt::format("there is no automatic threshold of {}; give {}", measure.name, wanted),
                std::string(field));
  }
  if (is_length) return parse_length(text, field);
  if (text == "inf" && !has_most) return Length{std::numeric_limits<double>::infinity(), Length::Unit::infinite, "inf"};
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc() && end == text.data() + text.size() && value >= measure.least && value <= measure.most &&
      std::isfinite(value))
    return Length{value, Length::Unit::number, std::string(text)};
  throw Error(ErrorCode::usage, fmt::format("the {} '{}' is not {}", measure.name, text, wanted), std::string(field));
}

std::optional<Length> parse_theta1(std::string_view text) {
  if (text.ends_with('r') && text.size() > 1 && text[0] != '-') {
    double value = 0;
    const char* end = text.data() + text.size() - 1;
    const auto [read, error] = std::from_chars(text.data(), end, value);
    if (error == std::errc() && read == end && std::isfinite(value))
      return Length{value, Length::Unit::radii, std::string(text)};
  }
  try {
    return parse_length_or_auto(text, "theta1");
  } catch (const Error& error) {
    if (text.starts_with('-')) throw;
    throw Error(error.code(),
                fmt::format("theta1 '{}' is not a length; give a fraction (0.02 or 2%), voxels (12vox), world units "
                            "(3.5abs) or radii of what branches leave (0.5r)",
                            text),
                "theta1");
  }
}

std::optional<Length> parse_omega(std::string_view text) {
  const std::optional<Length> omega = parse_length_or_auto(text, "omega");
  if (omega && (!(omega->value > 0) || omega->unit == Length::Unit::infinite))
    throw Error(ErrorCode::usage,
                fmt::format("omega '{}' is not a distance between nodes; give a length above 0, or leave it out", text),
                "omega");
  return omega;
}

Length parse_resample(std::string_view text) {
  const Length length = parse_length(text, "resample");
  if (length.unit == Length::Unit::infinite)
    throw Error(
        ErrorCode::usage,
        fmt::format("resample '{}' is not a distance between points; give a length, or 0 for the points as they come",
                    text),
        "resample");
  return length;
}

std::string text_of(const Length& length) {
  if (!length.text.empty()) return length.text;
  switch (length.unit) {
    case Length::Unit::fraction:
      return fmt::format("{}", length.value);
    case Length::Unit::voxels:
      return fmt::format("{}vox", length.value);
    case Length::Unit::absolute:
      return fmt::format("{}abs", length.value);
    case Length::Unit::radii:
      return fmt::format("{}r", length.value);
    case Length::Unit::number:
      return fmt::format("{}", length.value);
    case Length::Unit::infinite:
      break;
  }
  return "inf";
}

std::string text_of(const std::optional<Length>& length) { return length ? text_of(*length) : "auto"; }

double Scale::resolve(const Length& length, std::string_view field) const {
  switch (length.unit) {
    case Length::Unit::fraction:
      return length.value * longest_side;
    case Length::Unit::voxels:
      if (!(voxel > 0))
        throw Error(
            ErrorCode::usage,
            fmt::format("{} '{}' needs a voxel size, which the medial axis does not say; give a fraction (0.01) "
                        "or a world length (3.5abs)",
                        field, text_of(length)),
            std::string(field));
      return length.value * voxel;
    case Length::Unit::absolute:
    case Length::Unit::number:
      return length.value;
    case Length::Unit::radii:
      throw Error(ErrorCode::usage, fmt::format("{} '{}' is not a length", field, text_of(length)), std::string(field));
    case Length::Unit::infinite:
      break;
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace quench::pipeline
