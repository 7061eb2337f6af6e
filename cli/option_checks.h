// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <string>
#include <vector>

/// Checks of option values: as those of CLI11, without their additions to the help text.
namespace quench::program {

inline CLI::Validator one_of(std::vector<std::string> names) {
  return CLI::Validator(
      [names](std::string& value) {
        if (std::find(names.begin(), names.end(), value) != names.end()) return std::string();
        return fmt::format("'{}' is none of {}", value, fmt::join(names, ", "));
      },
      "");
}

inline CLI::Validator within(double least, double most) {
  return CLI::Validator(
      [=](std::string& text) {
        double value = 0;
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
        if (error == std::errc() && end == text.data() + text.size() && value >= least && value <= most)
          return std::string();
        return fmt::format("'{}' is not from {} to {}", text, least, most);
      },
      "");
}

inline CLI::Validator at_least_zero() {
  return CLI::Validator(
      [](std::string& text) { return text.starts_with('-') ? fmt::format("'{}' is negative", text) : std::string(); },
      "");
}

}  // namespace quench::program
