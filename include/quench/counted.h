// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <string>

namespace quench {

/// A number with its noun, for sentences: "1 loop", "3 loops", "2 cavities". The plural has an s unless `many` says
/// otherwise.
template <std::integral T>
std::string counted(T n, const std::string& one, const std::string& many = {}) {
  return std::to_string(n) + " " + (n == T{1} ? one : many.empty() ? one + "s" : many);
}

}  // namespace quench
