// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace quench::picture {

/// The bytes of a TrueType font, built into the library (cmake/QuenchFont.cmake): pictures look the same everywhere.
std::string_view font_file();

}  // namespace quench::picture
