// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace quench::pipeline {

/// The program of the interactive page, an HTML file without data. Empty where Quench was built without it.
std::string_view page_program();

}  // namespace quench::pipeline
