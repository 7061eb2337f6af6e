// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <vector>

namespace quench::preparation {

/// The range of the finite samples, and whether there are more than two values.
template <class T>
struct Range {
  T low{}, high{};
  bool any = false, third = false;
  std::uint64_t not_finite = 0;

  explicit Range(const std::vector<T>& samples) {
    for (const T v : samples) {
      if (!std::isfinite(static_cast<double>(v))) {
        ++not_finite;
        continue;
      }
      if (!any) low = high = v;
      any = true;
      third = third || (v != low && v != high && low != high);
      low = std::min(low, v);
      high = std::max(high, v);
    }
  }
  double width() const { return static_cast<double>(high) - static_cast<double>(low); }
};

/// Classes of values from `low` on, of equal width: of whole numbers one each where they are at most `most_whole`, else
/// `intervals` of the range. None where the range is no finite number.
template <class T>
struct Classes {
  double low = 0, step = 1;
  std::size_t count = 0;

  Classes(const Range<T>& range, double most_whole, double intervals) : low(static_cast<double>(range.low)) {
    if (!range.any || !std::isfinite(range.width())) return;
    const bool whole = std::is_integral_v<T> && range.width() < most_whole;
    count = static_cast<std::size_t>(whole ? range.width() + 1 : intervals);
    step = whole ? 1 : range.width() / intervals;
  }
  std::size_t of(T v) const {
    return std::min(count - 1, static_cast<std::size_t>((static_cast<double>(v) - low) / step));
  }
  std::vector<double> counts(const std::vector<T>& samples) const {
    std::vector<double> result(count);
    for (const T v : samples)
      if (std::isfinite(static_cast<double>(v))) result[of(v)] += 1;
    return result;
  }
};

/// The first class of the upper of two whose means lie farthest apart for their sizes (Otsu 1979); of equally good
/// ones, as where values are missing between two, the middle one.
std::size_t otsu(const std::vector<double>& counts);

/// Classes as Otsu's method takes them here.
template <class T>
Classes<T> otsu_classes(const Range<T>& range) {
  return Classes<T>(range, 65536, 256);
}

}  // namespace quench::preparation
