// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>

namespace quench::base {

/// The time or level of what never burns, is never reached or never removed.
inline constexpr double kNever = std::numeric_limits<double>::infinity();

}  // namespace quench::base
