// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "quench/context.h"
#include "quench/shape.h"

/// Pictures as their files hold them, and how their colours become one value per pixel.
namespace quench::io {

/// Rows from the top, the channels of a pixel together.
struct Pixels {
  std::int64_t width = 0, height = 0;
  int channels = 1;           ///< 1: grey; 2: grey, alpha; 3: red, green, blue; 4: red, green, blue, alpha
  std::uint32_t white = 255;  ///< the largest value of a sample; alpha of this value is opaque
  std::variant<std::vector<std::uint8_t>, std::vector<std::uint16_t>> samples;
  std::string kind;  ///< "an RGB picture"

  bool has_colours() const { return channels > 1; }
  bool has_alpha() const { return channels % 2 == 0; }
};

enum class Channel { luminance, alpha, red, green, blue };

/// "luminance", "alpha", "red", "green", "blue"; nothing for the empty name. Throws Error(usage), field `channel`, for
/// any other.
std::optional<Channel> channel_named(const std::string& name);

/// Throws Error(usage), field `channel`, where it is asked of values that are not a picture with alpha.
void check_channel_of_grey(const std::filesystem::path& file, const std::string& kind, std::optional<Channel> channel);

/// A plane of one value per pixel, of the type of the samples: the channel or, without one, alpha where all that is
/// seen (alpha > 0) has one colour and alpha varies, else luminance. Luminance is that of ITU-R BT.601, (19595 red +
/// 38470 green + 7471 blue) / 2^16, on a white ground where pixels are transparent, each rounded to the nearest. A note
/// where it is not the luminance of an opaque picture that nobody asked for. Throws Error(usage), field `channel`, for
/// alpha where there is none. O(samples), in place.
Volume volume_of(Pixels&& pixels, const std::filesystem::path& file, std::optional<Channel> channel, Context* context);

/// Throws the Error(input), field `channel`, of slices with colours without a channel. `kind`: "an RGB picture".
[[noreturn]] void refuse_colours_of_slices(const std::filesystem::path& file, const std::string& kind,
                                           std::int64_t width, std::int64_t height);

}  // namespace quench::io
