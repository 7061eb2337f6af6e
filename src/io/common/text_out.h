// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <ostream>

namespace quench::io {

/// Formats text into a stream in large pieces. Numbers formatted with {} are the shortest text that reads back as the
/// same number, in any locale.
class TextOut {
 public:
  explicit TextOut(std::ostream& out) : out_(out) {}
  TextOut(const TextOut&) = delete;
  TextOut& operator=(const TextOut&) = delete;

  template <class... Args>
  void print(fmt::format_string<Args...> format, Args&&... args) {
    append(format, fmt::make_format_args(args...));
    if (buffer_.size() > 1 << 16) flush();
  }
  /// Must be called at the end: a destructor could not report errors.
  void flush() {
    out_.write(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
    buffer_.clear();
  }

 private:
  // Not in the template: all of fmt would be compiled again in every file that prints.
  void append(fmt::string_view format, fmt::format_args args);

  std::ostream& out_;
  fmt::memory_buffer buffer_;
};

}  // namespace quench::io
