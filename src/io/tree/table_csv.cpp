// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <string_view>

#include "io/common/text_out.h"
#include "quench/io.h"
#include "quench/tree.h"

namespace quench::io {
namespace {

/// RFC 4180: in quotes where it holds a comma, a quote or an end of line.
std::string csv_field(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == text.npos) return std::string(text);
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + '"';
}

void print_value(TextOut& text, double value) {
  if (!std::isnan(value)) text.print("{}", value);
}
void print_value(TextOut& text, std::int64_t value) { text.print("{}", value); }
void print_value(TextOut& text, const std::string& value) { text.print("{}", csv_field(value)); }

}  // namespace

void write_table(const std::filesystem::path& file, const Table& table) {
  write_atomically(file, [&](std::ostream& out) {
    TextOut text(out);
    for (std::size_t c = 0; c < table.columns.size(); ++c) {
      const Table::Column& column = table.columns[c];
      const std::string head = column.unit.empty() ? column.name : fmt::format("{} [{}]", column.name, column.unit);
      text.print("{}{}", c == 0 ? "" : ",", csv_field(head));
    }
    text.print("\n");
    for (std::size_t row = 0; row < table.rows; ++row) {
      for (std::size_t c = 0; c < table.columns.size(); ++c) {
        if (c > 0) text.print(",");
        std::visit([&](const auto& values) { print_value(text, values[row]); }, table.columns[c].values);
      }
      text.print("\n");
    }
    text.flush();
  });
}

}  // namespace quench::io
