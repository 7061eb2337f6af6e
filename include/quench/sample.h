// SPDX-License-Identifier: Apache-2.0
// deprecated: the names before 0.2, for one release.
#pragma once

#include "quench/samples.h"

namespace quench {

[[deprecated("built_in_samples")]] inline const std::vector<SampleInfo>& samples() { return built_in_samples(); }

}  // namespace quench
