// SPDX-License-Identifier: Apache-2.0
#include "base/memory.h"

#include <fmt/format.h>

namespace quench::base {

std::string bytes_text(std::int64_t bytes) {
  const double amount = static_cast<double>(bytes);
  const auto in = [&](double unit, const char* name) {
    return fmt::format("{:.{}f} {}", amount / unit, amount < 10 * unit ? 1 : 0, name);
  };
  if (amount >= 0x1p30) return in(0x1p30, "GB");
  if (amount >= 0x1p20) return in(0x1p20, "MB");
  if (amount >= 0x1p10) return in(0x1p10, "KB");
  return fmt::format("{} byte{}", bytes, bytes == 1 ? "" : "s");
}

}  // namespace quench::base
