// SPDX-License-Identifier: Apache-2.0
// Tables as pages hold them.
#include <algorithm>
#include <map>

#include "page/layer.h"
#include "quench/error.h"

namespace quench {
namespace {

/// Words in the order in which they come first, and the number of each row.
std::vector<float> numbered(const std::vector<std::string>& rows, std::vector<std::string>& words) {
  std::map<std::string, std::size_t> number;
  std::vector<float> numbers;
  for (const std::string& word : rows) {
    const auto [found, is_new] = number.emplace(word, words.size());
    if (is_new) words.push_back(word);
    numbers.push_back(static_cast<float>(found->second));
  }
  return numbers;
}

[[noreturn]] void refuse() {
  throw Error(ErrorCode::usage, "the table of sheets for a page does not fit the sheets of its skeleton");
}

/// The rows of a table by the numbers of their sheets.
std::vector<std::size_t> rows_of_sheets(const Table& sheets) {
  const Table::Column* const numbers = sheets.find("sheet");
  const auto* const values = numbers ? std::get_if<std::vector<std::int64_t>>(&numbers->values) : nullptr;
  if (!values || values->size() != sheets.rows) refuse();
  std::vector<std::size_t> rows(sheets.rows, sheets.rows);
  for (std::size_t row = 0; row < values->size(); ++row) {
    const auto sheet = static_cast<std::size_t>((*values)[row]);
    if (sheet >= rows.size() || rows[sheet] != rows.size()) refuse();
    rows[sheet] = row;
  }
  return rows;
}

}  // namespace

PageColumn page::column_of(const char* table, const Table::Column& column, std::vector<float>& values) {
  PageColumn out{table, column.name, column.unit, column.meaning, false, {}};
  if (const auto* words = std::get_if<std::vector<std::string>>(&column.values)) {
    values = numbered(*words, out.words);
  } else if (const auto* whole = std::get_if<std::vector<std::int64_t>>(&column.values)) {
    values.assign(whole->begin(), whole->end());
    out.whole = true;
  } else {
    for (const double x : std::get<std::vector<double>>(column.values)) values.push_back(static_cast<float>(x));
  }
  return out;
}

void add_sheets(Page& page, const Table& sheets) {
  const PageArray* const known = page.find("skeleton/polygon_sheet");
  const std::vector<std::size_t> rows = rows_of_sheets(sheets);
  if (!known || std::ranges::any_of(std::get<std::vector<std::uint32_t>>(known->values),
                                    [&](std::uint32_t sheet) { return sheet >= rows.size(); }))
    refuse();
  for (const Table::Column& column : sheets.columns) {
    std::vector<float> values, sorted;
    page.columns.push_back(page::column_of("sheets", column, values));
    if (values.size() != rows.size()) refuse();
    for (const std::size_t row : rows) sorted.push_back(values[row]);
    page.arrays.push_back({"sheets/" + column.name, 1, std::move(sorted)});
  }
}

}  // namespace quench
