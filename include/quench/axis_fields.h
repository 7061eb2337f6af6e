// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "quench/context.h"
#include "quench/poly_data.h"

namespace quench {

/// Takes out of the data of a medial axis the field arrays that a number or a name would be taken from but that hold
/// something else (an omega that is infinite, a spacing of two numbers), each with a note that names `file` and the
/// field.
void drop_unusable_fields(PolyData& data, const std::string& file, Context* context = nullptr);

}  // namespace quench
