// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "quench/axis.h"

namespace quench::axis {

/// Lowers the cap heights of faces above `least` that the surface does not bear out: the two sites of a face stand for
/// two places where its ball should touch the surface; where these are one, or the cap between them is not above half
/// of `least`, the steps of the voxels have made the face, and its height becomes that of the cap on the surface. Faces
/// with a `known` height (0 or more) stay as they are; empty: none are known.
/// O(faces above `least` * log triangles) in practice, on all threads.
void lower_to_surface(const MedialAxis& axis, const Surface& surface, double least, std::span<const double> known,
                      CellValues& height, Context* context);

}  // namespace quench::axis
