// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "quench/context.h"
#include "quench/page.h"

/// @file
/// A picture of a page, drawn by the library itself: what the interactive page shows first, without a browser and
/// without a graphics card.
namespace quench {

struct PictureOptions {
  int width = 1600, height = 1000;  ///< pixels, 16 to 8192
  bool caption = true;              ///< file, thresholds, colour bar, scale bar
  bool axes = false;                ///< the directions of x, y and z
};

/// Rows from the top, three bytes (red, green, blue) per pixel.
struct Picture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> pixels;
};

/// The page in its initial state (`Page::state`): layer, colours, threshold, camera, light or dark. The same for every
/// number of threads. O(cells + pixels). Throws Error(usage) for a size out of bounds and for a layer or an array that
/// the page does not have; a page without any layer gives the background.
Picture draw_page(const Page& page, const PictureOptions& options = {}, Context* context = nullptr);

/// The lines of text above the picture: the file, what is shown, the pruning.
std::vector<std::string> caption_of(const Page& page);

/// Writes a PNG, atomically; the same bytes for every number of threads. Throws Error(failed) when writing fails.
void write_png(const std::filesystem::path& file, const Picture& picture, Context* context = nullptr);

}  // namespace quench
