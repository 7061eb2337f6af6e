// SPDX-License-Identifier: Apache-2.0
#include "io/volume/pixels.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "base/text.h"
#include "quench/error.h"

namespace quench::io {
namespace {

constexpr std::array kChannels{"luminance", "alpha", "red", "green", "blue"};

/// The samples of a picture, pixel by pixel.
template <class T>
class PixelView {
 public:
  PixelView(const Pixels& pixels, const std::vector<T>& samples)
      : channels_(static_cast<std::size_t>(pixels.channels)), white_(pixels.white), samples_(samples) {}

  std::size_t count() const { return samples_.size() / channels_; }
  std::uint32_t alpha(std::size_t i) const {
    return channels_ % 2 == 0 ? samples_[i * channels_ + channels_ - 1] : white_;
  }
  /// Red, green or blue: 0, 1, 2.
  std::uint32_t colour(std::size_t i, std::size_t which) const {
    return samples_[i * channels_ + (channels_ > 2 ? which : 0)];
  }
  std::uint32_t luminance(std::size_t i) const {
    constexpr std::uint32_t kRed = 19595, kGreen = 38470, kBlue = 7471, kSum = 1 << 16;  // of 0.299, 0.587, 0.114
    const std::uint32_t light =
        channels_ < 3 ? colour(i, 0)
                      : (kRed * colour(i, 0) + kGreen * colour(i, 1) + kBlue * colour(i, 2) + kSum / 2) / kSum;
    const std::uint64_t a = alpha(i), white = white_;
    return static_cast<std::uint32_t>((2 * (light * a + white * (white - a)) + white) / (2 * white));
  }
  std::uint32_t value(std::size_t i, Channel channel) const {
    switch (channel) {
      case Channel::luminance:
        return luminance(i);
      case Channel::alpha:
        return alpha(i);
      default:
        return colour(i, static_cast<std::size_t>(channel) - static_cast<std::size_t>(Channel::red));
    }
  }
  bool alpha_varies() const {
    for (std::size_t i = 1; i < count(); ++i)
      if (alpha(i) != alpha(0)) return true;
    return false;
  }
  bool opaque() const { return alpha(0) == white_ && !alpha_varies(); }
  /// Whether alpha alone says what is to be seen.
  bool is_stencil() const {
    std::optional<std::size_t> seen;
    for (std::size_t i = 0; i < count(); ++i) {
      if (alpha(i) == 0) continue;
      if (!seen) seen = i;
      for (std::size_t c = 0; c < 3; ++c)
        if (colour(i, c) != colour(*seen, c)) return false;
    }
    return alpha_varies();
  }

 private:
  std::size_t channels_;
  std::uint32_t white_;
  std::span<const T> samples_;
};

/// The channel nobody asked for, with a note on what is not plain luminance.
template <class T>
Channel own_channel(const Pixels& pixels, const PixelView<T>& view, const std::filesystem::path& file,
                    Context* context) {
  if (!pixels.has_alpha() || view.opaque()) return Channel::luminance;
  const bool stencil = view.is_stencil();
  note(context, stencil ? fmt::format("'{}' is {} of one colour on transparent ground: the values are its alpha",
                                      file.string(), pixels.kind)
                        : fmt::format("'{}' is {} with transparent pixels: the values are its luminance on white",
                                      file.string(), pixels.kind));
  return stencil ? Channel::alpha : Channel::luminance;
}

}  // namespace

std::optional<Channel> channel_named(const std::string& name) {
  if (name.empty()) return {};
  const auto found = std::find(kChannels.begin(), kChannels.end(), name);
  if (found == kChannels.end())
    throw Error(ErrorCode::usage,
                fmt::format("channel '{}' is not luminance, alpha, red, green or blue", base::plain(name)), "channel");
  return static_cast<Channel>(found - kChannels.begin());
}

void check_channel_of_grey(const std::filesystem::path& file, const std::string& kind, std::optional<Channel> channel) {
  if (channel == Channel::alpha)
    throw Error(ErrorCode::usage,
                fmt::format("channel 'alpha' is not in '{}', {} without transparency; take its luminance or a colour",
                            file.string(), kind),
                "channel");
}

Volume volume_of(Pixels&& pixels, const std::filesystem::path& file, std::optional<Channel> channel, Context* context) {
  if (!pixels.has_alpha()) check_channel_of_grey(file, pixels.kind, channel);
  Volume volume;
  volume.grid.dims = {pixels.width, pixels.height, 1};
  volume.grid.dimension = 2;
  volume.picture = pixels.kind;
  std::visit(
      [&]<class T>(std::vector<T>& samples) {
        if (pixels.has_colours()) {
          const PixelView<T> view(pixels, samples);
          const std::size_t count = view.count();
          const Channel taken = channel ? *channel : own_channel(pixels, view, file, context);
          // The value of a pixel goes where no pixel after it lies.
          for (std::size_t i = 0; i < count; ++i) samples[i] = static_cast<T>(view.value(i, taken));
          samples.resize(count);
          samples.shrink_to_fit();
        }
        volume.samples = std::move(samples);
      },
      pixels.samples);
  return volume;
}

void refuse_colours_of_slices(const std::filesystem::path& file, const std::string& kind, std::int64_t width,
                              std::int64_t height) {
  throw Error(
      ErrorCode::input,
      fmt::format("'{}' is {} of {} x {} pixels in a stack of slices, which need one value per voxel; say which "
                  "channel is meant (luminance, alpha, red, green or blue), or convert the slices to grey values",
                  file.string(), kind, width, height),
      "channel");
}

}  // namespace quench::io
