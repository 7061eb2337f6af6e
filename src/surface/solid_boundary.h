// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "quench/context.h"
#include "quench/geometry.h"

namespace quench::surface {

/// The boundary of the solid of a closed mesh whose parts may overlap, touch, intersect or face inward: of its
/// triangles what has the solid on one side only, with the normal away from it.
///
/// The solid is where the winding number is not 0, or, with `odd`, where it is odd (then the orientation of the
/// triangles does not matter). Where triangles intersect they are cut along each other, and neighbours get the new
/// corners, so that the result is closed again. Where triangles of one plane overlap, one is kept. A mesh that is such
/// a boundary comes back as it is but for triangles with two corners at the same place.
///
/// Exact to 1e-12 of the longest side of the mesh; what is narrower than 1e-10 of it may be left out. Coordinates must
/// be finite. O(n log n) for n triangles unless many intersect. Points are never removed.
TriangleMesh solid_boundary(const TriangleMesh& mesh, bool odd = false, Context* context = nullptr);

}  // namespace quench::surface
