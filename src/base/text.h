// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <string>

namespace quench::base {

/// A number with its noun, for sentences: "1 loop", "3 loops", "2 cavities". The plural has an s unless `many` says
/// otherwise.
template <std::integral T>
std::string counted(T n, const std::string& one, const std::string& many = {}) {
  return std::to_string(n) + " " + (n == T{1} ? one : many.empty() ? one + "s" : many);
}

/// Text of a file for an error sentence: without bytes that would end the line or steer a terminal.
inline std::string plain(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < ' ' || c == '\x7F') c = '?';
  return text;
}

}  // namespace quench::base
