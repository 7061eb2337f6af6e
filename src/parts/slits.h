// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "quench/parts.h"

namespace quench::parts {

/// Halves every edge along which a sheet is cut off from itself while both ends hold together: cut, its two sides would
/// be one edge again.
void halve_slits(SheetMesh& mesh);

}  // namespace quench::parts
