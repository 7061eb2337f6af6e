// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <initializer_list>
#include <string>
#include <utility>
#include <variant>

namespace quench::pipeline {

/// The parameters of a run are a flat JSON object: appends values to its text; "" is the empty object. Bytes that are
/// not UTF-8 are replaced.
using Parameter = std::variant<bool, std::int64_t, std::uint64_t, double, std::string>;
std::string with_parameters(const std::string& text,
                            std::initializer_list<std::pair<std::string, Parameter>> parameters);

}  // namespace quench::pipeline
