// SPDX-License-Identifier: Apache-2.0
// A threshold for an image that nobody gave one for.
#include <algorithm>
#include <cmath>
#include <type_traits>

#include "quench/pipeline.h"

namespace quench::pipeline {
namespace {

/// Counts of the values from `low` to `high`: of whole numbers one by one where they are few, else in equal intervals.
template <class T>
struct Histogram {
  T low{}, high{};
  bool two_values = false;
  double step = 1;  ///< width of an interval
  std::vector<double> counts;

  explicit Histogram(const std::vector<T>& samples) {
    bool any = false, third = false;
    for (const T v : samples) {
      if (!std::isfinite(static_cast<double>(v))) continue;
      if (!any) low = high = v;
      any = true;
      third = third || (v != low && v != high && low != high);
      low = std::min(low, v);
      high = std::max(high, v);
    }
    two_values = !third;
    if (!third && (low == high || low == T{} || high == T{})) return;
    constexpr double kMostValues = 65536, kIntervals = 256;
    const double range = static_cast<double>(high) - static_cast<double>(low);
    if (!std::isfinite(range)) return;
    const bool whole = std::is_integral_v<T> && range < kMostValues;
    counts.resize(static_cast<std::size_t>(whole ? range + 1 : kIntervals));
    step = whole ? 1 : range / kIntervals;
    for (const T v : samples)
      if (std::isfinite(static_cast<double>(v))) counts[interval(v)] += 1;
  }
  std::size_t interval(T v) const {
    const double at = (static_cast<double>(v) - static_cast<double>(low)) / step;
    return std::min(counts.size() - 1, static_cast<std::size_t>(at));
  }
};

/// The first interval of the upper of two classes whose means lie farthest apart for their sizes (Otsu 1979); of
/// equally good ones, as where values are missing between two, the middle one.
std::size_t otsu(const std::vector<double>& counts) {
  double all = 0, sum = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    all += counts[i];
    sum += counts[i] * static_cast<double>(i);
  }
  double below = 0, sum_below = 0, best = -1;
  std::size_t first = 1, last = 1;
  for (std::size_t i = 1; i < counts.size(); ++i) {
    below += counts[i - 1];
    sum_below += counts[i - 1] * static_cast<double>(i - 1);
    if (below <= 0 || below >= all) continue;
    const double apart = sum_below / below - (sum - sum_below) / (all - below);
    const double between = below * (all - below) * apart * apart;
    if (between > best) first = i;
    if (between >= best) last = i;
    best = std::max(best, between);
  }
  return first + (last - first) / 2;
}

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
        const Histogram<T> histogram(samples);
        if (histogram.counts.empty()) return {};
        const double offset = static_cast<double>(otsu(histogram.counts)) * histogram.step;
        ThresholdProposal proposal;
        proposal.low = static_cast<double>(histogram.low);
        proposal.high = static_cast<double>(histogram.high);
        proposal.two_values = histogram.two_values;
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
