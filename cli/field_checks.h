// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "quench/poly_data.h"
#include "session.h"

namespace quench::program {

/// Takes out of `data` the field arrays that commands would take a number or a name from but that hold something else
/// (an omega that is infinite, a spacing of two numbers), and says so in a note that names the file and the field.
void drop_unusable_fields(PolyData& data, const std::string& file, Session& session);

}  // namespace quench::program
