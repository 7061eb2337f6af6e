// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <variant>
#include <vector>

#include "quench/record.h"

/// What tests of the program ask of the texts and files it writes.
namespace quench::testing_program {

inline bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

inline std::vector<double> numbers(const std::vector<DataArray>& arrays, const char* name) {
  const DataArray* array = find_array(arrays, name);
  EXPECT_TRUE(array) << name;
  return array ? array->numbers() : std::vector<double>();
}
inline double field(const Record& data, const char* name) {
  const std::vector<double> values = numbers(data.field_data, name);
  return values.empty() ? NAN : values.front();
}
inline std::string text_field(const Record& data, const char* name) {
  const DataArray* array = find_array(data.field_data, name);
  const auto* text = array ? std::get_if<std::vector<std::string>>(&array->values) : nullptr;
  return text && !text->empty() ? text->front() : "";
}

}  // namespace quench::testing_program
