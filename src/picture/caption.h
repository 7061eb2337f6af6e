// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "picture/camera.h"
#include "picture/scene.h"
#include "quench/picture.h"

namespace quench::picture {

/// What the page calls a measure of the vertices (viewer/src/measures.ts).
std::string label_of(const std::string& measure);
/// "mm"; of angles "°".
std::string unit_of(const Page& page, const std::string& measure);
/// Three significant digits, or as many as are asked for; no exponent where it can be avoided.
std::string short_text(double x, int digits = 3);
/// Of ticks, with as few digits as say where they are, four at least.
std::vector<std::string> names_of(const std::vector<double>& places);
/// Round values inside a range, at most `most` and one.
std::vector<double> ticks(double low, double high, int most);
/// The largest of 1, 2, 5, 10, 20 ... that is not above `most`.
double round_length(double most);

/// Pixels per pixel of the page: of lines, of letters.
double line_unit(const PictureOptions& options);
double letter_unit(const PictureOptions& options);
/// What the writing takes.
Insets insets_of(const PictureOptions& options);
/// File, colour bar, scale bar, axes: as the options say.
void write_captions(Picture& picture, const Page& page, const Scene& scene, const ViewState& state,
                    const ColourRange& range, const Camera& camera, const PictureOptions& options);

}  // namespace quench::picture
