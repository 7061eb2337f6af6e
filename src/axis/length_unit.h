// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace quench::axis {

/// Lengths are compared in units of this factor of the automatic detail: rounding depends on where a shape lies, what
/// is kept must not.
inline constexpr double kLengthUnit = 0x1p-20;

}  // namespace quench::axis
