// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "picture/camera.h"
#include "picture/scene.h"
#include "quench/context.h"
#include "quench/picture.h"

namespace quench::picture {

/// Draws a scene of the plane, everything but letters: the shape as a flat figure with its outline, over it the curves.
/// Each of the three covers a pixel by the share of its area that is inside of the shape, or of the line there. `unit`:
/// pixels of the picture per pixel of the page, for widths of lines. O(pixels + lines * their pixels).
Picture draw_plane(const Scene& scene, const ViewState& state, const ColourRange& range, const Camera& camera,
                   int width, int height, double unit, Context* context);

}  // namespace quench::picture
