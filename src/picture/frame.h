// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "picture/camera.h"
#include "picture/scene.h"
#include "quench/context.h"
#include "quench/picture.h"

namespace quench::picture {

inline constexpr int kBand = 1024;

/// The ground in row y.
Vec3f ground_at(int y, int height, bool dark);

/// Draws a scene: everything but letters. `unit`: pixels of the picture per pixel of the page, for widths of lines.
/// `band`: so many rows at a time, which bounds the memory and changes nothing else.
Picture draw_scene(const Scene& scene, const ViewState& state, const ColourRange& range, const Camera& camera,
                   int width, int height, double unit, Context* context, int band = kBand);

}  // namespace quench::picture
