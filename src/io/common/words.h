// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace quench::io {

/// Whole text as a number, independent of the locale ("+1", ".5", "1e5", "nan", "inf"; underflow gives 0).
bool parse_number(std::string_view text, double& value);
bool parse_integer(std::string_view text, std::int64_t& value);

/// Reads blank-separated words of a text and knows their line. Lines end with LF, CR LF or CR.
///
/// Everything that throws, throws Error(input) naming file and line.
class Words {
 public:
  struct Dialect {
    char comment = '#';         ///< starts a comment where a word could start; 0: none
    bool continuation = false;  ///< a backslash at the end of a line joins it with the next (OBJ)
  };

  Words(std::string_view text, const std::string& file) : Words(text, file, Dialect{}) {}
  Words(std::string_view text, const std::string& file, Dialect dialect, std::size_t first_line = 1);

  /// The next word of the text; empty at its end.
  std::string_view next();
  /// The next word of the present line; empty at the end of the line.
  std::string_view next_on_line();
  /// Goes to the next line that has a word; false at the end of the text.
  bool next_line();
  /// Reads the rest of the present line, without its line end.
  std::string_view rest_of_line();

  /// The next word as a number: of the present line for `on_line`, else of the text; `coordinate`: a finite one.
  /// `what`: its name in errors.
  double number(const char* what);
  double coordinate_on_line(const char* what);
  double number_on_line(const char* what);
  std::int64_t integer(const char* what);
  std::int64_t integer_on_line(const char* what);

  std::size_t line() const { return line_; }
  std::size_t position() const { return static_cast<std::size_t>(at_ - begin_); }
  std::size_t remaining() const { return static_cast<std::size_t>(end_ - at_); }
  [[noreturn]] void fail(std::string_view what) const;

 private:
  bool at_line_end() const;
  void pass_line_end();
  void pass_blanks();
  std::string_view word();
  double as_number(std::string_view word, const char* what) const;
  std::int64_t as_integer(std::string_view word, const char* what) const;

  const char* begin_;
  const char* at_;
  const char* end_;
  std::size_t line_;
  bool fresh_ = true;        ///< nothing of the present line has been read
  const std::string* file_;  ///< its name; a pointer, so that a place in the text can be kept and returned to
  Dialect dialect_;
};

}  // namespace quench::io
