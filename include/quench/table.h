// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace quench {

/// A table with named columns: measures of axes, branches or samples, one row for each.
struct Table {
  struct Column {
    std::string name;     ///< lower case with underscores: `mean_radius`
    std::string unit;     ///< `mm`, `degrees`; empty: a number without unit, or words
    std::string meaning;  ///< one sentence
    /// One value per row; NaN where it is not defined.
    std::variant<std::vector<double>, std::vector<std::int64_t>, std::vector<std::string>> values;
  };
  std::vector<Column> columns;
  std::size_t rows = 0;

  /// nullptr: there is none of this name.
  const Column* find(std::string_view name) const;
};

}  // namespace quench
