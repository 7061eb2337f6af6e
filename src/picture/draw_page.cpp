// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "base/parallel.h"
#include "picture/caption.h"
#include "picture/frame.h"
#include "picture/plane.h"
#include "quench/error.h"

namespace quench {

Picture draw_page(const Page& page, const PictureOptions& options, Context* context) {
  using namespace picture;
  const auto good = [](int x) { return x >= 16 && x <= 8192; };
  if (!good(options.width) || !good(options.height))
    throw Error(ErrorCode::usage,
                fmt::format("a picture of {} x {} pixels; 16 to 8192 each are possible", options.width, options.height),
                "size");
  return base::in_arena(context, [&] {
    const ViewState state = view_state(page);
    const Scene scene = scene_of(page, state);
    const ColourRange range = colour_range(scene, state);
    const Camera camera = first_look(page, state, scene, options.width, options.height, insets_of(options));
    const double unit = line_unit(options);
    Picture picture = page.plane
                          ? draw_plane(scene, state, range, camera, options.width, options.height, unit, context)
                          : draw_scene(scene, state, range, camera, options.width, options.height, unit, context);
    write_captions(picture, page, scene, state, range, camera, options);
    return picture;
  });
}

}  // namespace quench
