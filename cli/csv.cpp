// SPDX-License-Identifier: Apache-2.0
#include "csv.h"

#include <fmt/format.h>

#include <istream>
#include <ostream>
#include <utility>

#include "quench/error.h"

namespace quench::program {

CsvReader::CsvReader(std::istream& in, std::string name, char separator)
    : in_(*in.rdbuf()), name_(std::move(name)), separator_(separator) {
  for (const char mark : {'\xEF', '\xBB', '\xBF'}) {
    if (in_.sgetc() != static_cast<unsigned char>(mark)) break;
    in_.sbumpc();
  }
}

int CsvReader::read_cell(CsvRow& row) {
  constexpr int kEnd = std::char_traits<char>::eof();
  std::string& cell = row.emplace_back();
  bool quoted = in_.sgetc() == '"';
  if (quoted) in_.sbumpc();
  for (;;) {
    int c = in_.sbumpc();
    if (c == '\r') {
      if (in_.sgetc() == '\n') in_.sbumpc();
      c = '\n';
    }
    if (c == '\n') ++next_line_;
    if (quoted) {
      if (c == kEnd)
        throw Error(ErrorCode::input, fmt::format("'{}' line {}: a quote is opened and not closed", name_, line_));
      if (c != '"' || in_.sgetc() == '"') {
        if (c == '"') in_.sbumpc();
        cell += static_cast<char>(c);
      } else {
        quoted = false;
      }
      continue;
    }
    if (c == '\n' || c == kEnd || c == static_cast<unsigned char>(separator_)) return c;
    cell += static_cast<char>(c);
  }
}

bool CsvReader::next(CsvRow& row) {
  for (;;) {
    if (in_.sgetc() == std::char_traits<char>::eof()) return false;
    row.clear();
    line_ = next_line_;
    while (read_cell(row) == static_cast<unsigned char>(separator_)) {
    }
    if (row.size() > 1 || !row[0].empty()) return true;
  }
}

void write_row(std::ostream& out, const CsvRow& row) {
  const char* separator = "";
  for (const std::string& cell : row) {
    out << separator;
    separator = ",";
    // A blank at the end or the beginning, too: some readers leave it out.
    const bool plain = cell.find_first_of(",;\t\"\r\n#") == cell.npos && !cell.starts_with(' ') && !cell.ends_with(' ');
    if (plain) {
      out << cell;
      continue;
    }
    out << '"';
    for (const char c : cell) out << (c == '"' ? "\"\"" : std::string_view(&c, 1));
    out << '"';
  }
  out << '\n';
}

}  // namespace quench::program
