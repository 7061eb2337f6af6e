// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "quench/axis.h"

namespace quench::axis {

/// Raises details of vertices, of those that are `least` or more, such that for every d >= least each of these has a
/// vertex of detail d or more whose ball, grown by 2 (d - least), contains its own. The largest in each connected
/// component becomes infinite. `detail`: of sides no smaller than of what they are sides of.
void keep_within_reach(const MedialAxis& axis, double least, CellValues& detail, Context* context);

}  // namespace quench::axis
