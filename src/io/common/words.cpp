// SPDX-License-Identifier: Apache-2.0
#include "io/common/words.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "base/text.h"
#include "quench/error.h"

namespace quench::io {
namespace {

bool blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f' || c == '\0'; }
bool line_end(char c) { return c == '\n' || c == '\r'; }

/// A word for an error sentence: short, and without bytes that are not text.
std::string shown(std::string_view word) {
  std::string text;
  for (char c : word.substr(0, 40)) text += c >= ' ' && c <= '~' ? c : '?';
  return text;
}

}  // namespace

bool parse_number(std::string_view text, double& value) {
  const char* begin = text.data();
  const char* end = begin + text.size();
  if (begin != end && *begin == '+') ++begin;
  const auto [stop, error] = std::from_chars(begin, end, value);
  if (stop != end || begin == end) return false;
  if (error == std::errc::result_out_of_range) {
    // from_chars does not tell underflow from overflow.
    const std::size_t exponent = text.find_first_of("eE");
    const bool tiny = exponent == std::string_view::npos ? text.find('.') < 3 : text.substr(exponent + 1, 1) == "-";
    value = 0;
    return tiny;
  }
  return error == std::errc();
}

bool parse_integer(std::string_view text, std::int64_t& value) {
  const char* begin = text.data();
  const char* end = begin + text.size();
  if (end - begin > 1 && *begin == '+' && begin[1] != '-') ++begin;
  const auto [stop, error] = std::from_chars(begin, end, value);
  return error == std::errc() && stop == end;
}

Words::Words(std::string_view text, const std::string& file, Dialect dialect, std::size_t first_line)
    : begin_(text.data()), at_(begin_), end_(begin_ + text.size()), line_(first_line), file_(&file), dialect_(dialect) {
  if (text.substr(0, 3) == "\xEF\xBB\xBF") at_ += 3;
}

void Words::fail(std::string_view what) const {
  throw Error(ErrorCode::input, fmt::format("'{}', line {}: {}", *file_, line_, base::plain(std::string(what))));
}

bool Words::at_line_end() const { return at_ == end_ || line_end(*at_); }

void Words::pass_line_end() {
  if (at_ == end_) return;
  at_ += *at_ == '\r' && at_ + 1 != end_ && at_[1] == '\n' ? 2 : 1;
  ++line_;
}

void Words::pass_blanks() {
  while (at_ != end_) {
    if (blank(*at_)) {
      ++at_;
    } else if (dialect_.continuation && *at_ == '\\' && at_ + 1 != end_ && line_end(at_[1])) {
      ++at_;
      pass_line_end();
    } else if (dialect_.comment && *at_ == dialect_.comment) {
      while (!at_line_end()) ++at_;
    } else {
      return;
    }
  }
}

std::string_view Words::word() {
  const char* start = at_;
  while (!at_line_end() && !blank(*at_) &&
         !(dialect_.continuation && *at_ == '\\' && at_ + 1 != end_ && line_end(at_[1])))
    ++at_;
  return {start, static_cast<std::size_t>(at_ - start)};
}

std::string_view Words::next() {
  fresh_ = false;
  for (;;) {
    pass_blanks();
    if (at_ == end_) return {};
    if (!line_end(*at_)) return word();
    pass_line_end();
  }
}

std::string_view Words::next_on_line() {
  fresh_ = false;
  pass_blanks();
  return at_line_end() ? std::string_view{} : word();
}

bool Words::next_line() {
  if (!fresh_) rest_of_line();
  fresh_ = false;
  for (;;) {
    pass_blanks();
    if (at_ == end_) return false;
    if (!line_end(*at_)) return true;
    pass_line_end();
  }
}

std::string_view Words::rest_of_line() {
  const char* start = at_;
  while (!at_line_end()) {
    if (dialect_.continuation && *at_ == '\\' && at_ + 1 != end_ && line_end(at_[1])) {
      ++at_;
      pass_line_end();
    } else {
      ++at_;
    }
  }
  const std::string_view rest(start, static_cast<std::size_t>(at_ - start));
  pass_line_end();
  fresh_ = true;
  return rest;
}

double Words::as_number(std::string_view word, const char* what) const {
  double value = 0;
  if (word.empty()) fail(fmt::format("{} is missing", what));
  if (!parse_number(word, value)) fail(fmt::format("{} is '{}', which is not a number", what, shown(word)));
  return value;
}

std::int64_t Words::as_integer(std::string_view word, const char* what) const {
  std::int64_t value = 0;
  if (word.empty()) fail(fmt::format("{} is missing", what));
  if (!parse_integer(word, value)) fail(fmt::format("{} is '{}', which is not a whole number", what, shown(word)));
  return value;
}

double Words::number(const char* what) { return as_number(next(), what); }
double Words::number_on_line(const char* what) { return as_number(next_on_line(), what); }
std::int64_t Words::integer(const char* what) { return as_integer(next(), what); }
std::int64_t Words::integer_on_line(const char* what) { return as_integer(next_on_line(), what); }

double Words::coordinate_on_line(const char* what) {
  const double value = number_on_line(what);
  if (!std::isfinite(value)) fail(fmt::format("{} is not finite", what));
  return value;
}

}  // namespace quench::io
