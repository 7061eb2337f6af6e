// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <string_view>

#include "quench/axis.h"
#include "quench/geometry.h"

namespace quench {
namespace {

bool is_length(double value) { return value > 0 && value <= kLargestLength; }
bool is_level(double value) { return value >= 0 && std::isfinite(value); }
bool is_version(double value) { return value >= 1 && value <= kFormatVersion; }

struct NumberField {
  const char* name;
  std::size_t count;
  bool (*allowed)(double);
  const char* wanted;
};
constexpr NumberField kNumbers[] = {{"omega", 1, is_length, "a length"},
                                    {"longest_side", 1, is_length, "a length"},
                                    {"spacing", 3, is_length, "three lengths"},
                                    {"lambda", 1, is_level, "a length or 0"},
                                    {"format_version", 1, is_version, "a version that is known here"}};

struct NameField {
  const char* name;
  std::span<const std::string_view> allowed;
};
constexpr std::string_view kPropagations[] = {"segments", "windows"}, kRadiusRules[] = {"exact", "linear"};
constexpr NameField kNames[] = {{"propagation", kPropagations}, {"radius_rule", kRadiusRules}};

/// What is wrong with an array; nothing when it can be used.
std::optional<std::string> fault_of(const DataArray& array) {
  const auto* texts = std::get_if<std::vector<std::string>>(&array.values);
  if (array.name == "measures" && !texts) return "is not text";
  for (const NameField& field : kNames)
    if (array.name == field.name) {
      const bool usable = texts && texts->size() == 1 && std::ranges::count(field.allowed, texts->front()) > 0;
      if (usable) return {};
      return fmt::format("is not one of {}", fmt::join(field.allowed, ", "));
    }
  for (const NumberField& field : kNumbers)
    if (array.name == field.name) {
      if (texts) return fmt::format("is text, not {}", field.wanted);
      const std::vector<double> values = array.numbers();
      if (values.size() == field.count && std::ranges::all_of(values, field.allowed)) return {};
      const std::span<const double> shown(values.data(), std::min<std::size_t>(values.size(), 3));
      return fmt::format("is {}{}, not {}", fmt::join(shown, ", "), values.size() > 3 ? " ..." : "", field.wanted);
    }
  return {};
}

}  // namespace

void drop_unusable_fields(Record& data, const std::string& file, Context* context) {
  std::erase_if(data.field_data, [&](const DataArray& array) {
    const std::optional<std::string> fault = fault_of(array);
    if (fault) note(context, fmt::format("the field '{}' of '{}' {}, and is ignored", array.name, file, *fault));
    return fault.has_value();
  });
}

}  // namespace quench
