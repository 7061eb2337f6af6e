// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace quench::program {

/// Text for a terminal: UTF-8 stays, what could move the cursor, end the line or change how other text reads is shown
/// instead of done. "\n", "\t", "\r" for these, "\x1b" for other control characters and for bytes that are not UTF-8,
/// "\u202e" for line separators and changes of the writing direction. A backslash stays as it is.
std::string printable(std::string_view text);

}  // namespace quench::program
