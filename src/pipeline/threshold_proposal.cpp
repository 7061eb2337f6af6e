// SPDX-License-Identifier: Apache-2.0
// A threshold for an image that nobody gave one for.
#include <algorithm>
#include <cmath>
#include <type_traits>

#include "preparation/classes.h"
#include "quench/pipeline.h"

namespace quench::pipeline {
namespace {

/// Whether most pixels at the sides of an image are of at least this value.
template <class T>
bool border_is_bright(const std::vector<T>& samples, const Grid& grid, double threshold) {
  const auto w = static_cast<std::size_t>(grid.dims[0]), h = static_cast<std::size_t>(grid.dims[1]);
  std::size_t bright = 0, all = 0;
  for (std::size_t y = 0; y < h; ++y)
    for (std::size_t x = 0; x < w; x += y == 0 || y + 1 == h || w == 1 ? 1 : w - 1) {
      bright += static_cast<double>(samples[y * w + x]) >= threshold;
      ++all;
    }
  return 2 * bright > all;
}

}  // namespace

std::optional<ThresholdProposal> propose_threshold(const Volume& image) {
  return std::visit(
      [&]<class T>(const std::vector<T>& samples) -> std::optional<ThresholdProposal> {
        const preparation::Range<T> range(samples);
        if (!range.third && (range.low == range.high || range.low == T{} || range.high == T{})) return {};
        const preparation::Classes<T> classes = preparation::otsu_classes(range);
        if (classes.count == 0) return {};
        const double offset = static_cast<double>(preparation::otsu(classes.counts(samples))) * classes.step;
        ThresholdProposal proposal;
        proposal.low = static_cast<double>(range.low);
        proposal.high = static_cast<double>(range.high);
        proposal.two_values = !range.third;
        const double value = proposal.low + offset;
        if constexpr (std::is_integral_v<T>)
          proposal.threshold = static_cast<std::int64_t>(std::clamp(std::ceil(value), -0x1p62, 0x1p62));
        else
          proposal.threshold = value;
        proposal.bright_border = image.grid.dims[2] == 1 && border_is_bright(samples, image.grid, value);
        return proposal;
      },
      image.samples);
}

}  // namespace quench::pipeline
