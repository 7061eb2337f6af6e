// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "quench/pipeline.h"

namespace quench::pipeline {

/// add_measure() for several, but for those that every file has; what they have in common is computed once.
void add_measures(MedialAxis& axis, const LoadedShape& of, const std::vector<std::string>& names, Context* context);

}  // namespace quench::pipeline
