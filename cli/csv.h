// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <iosfwd>
#include <string>
#include <string_view>
#include <vector>

/// Tables as text: separated values as in RFC 4180.
namespace quench::program {

using CsvRow = std::vector<std::string>;

/// Reads rows one by one: cells in quotes may hold separators, line ends and doubled quotes; lines end with LF, CR LF
/// or CR; empty lines are no rows; a byte order mark at the beginning is skipped. A quote inside of a cell that does
/// not begin with one is a character like others.
class CsvReader {
 public:
  /// `name`: of the file, for errors.
  CsvReader(std::istream& in, std::string name, char separator = ',');

  /// False at the end. Throws Error(input), naming file and line, for a quote that is not closed.
  bool next(CsvRow& row);
  /// The line in which the row read last begins, from 1.
  std::size_t line() const { return line_; }

 private:
  /// Appends a cell, and says what ended it: the separator, '\n', or -1 at the end of the text.
  int read_cell(CsvRow& row);

  std::streambuf& in_;
  std::string name_;
  char separator_;
  std::size_t line_ = 0, next_line_ = 1;
};

/// Writes a row; what needs quotes gets them.
void write_row(std::ostream& out, const CsvRow& row);

}  // namespace quench::program
