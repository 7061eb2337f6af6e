// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <variant>
#include <vector>

#include "quench/context.h"
#include "quench/shape.h"

/// What prepared() is made of. All work in slabs of slices, on all threads, and give the same for any number of them.
namespace quench::preparation {

/// Blurs with a Gaussian of `sigma` voxels of the smallest spacing.
void blur(Volume& volume, double sigma, Context* context);
/// The kernel of a Gaussian on a lattice, e^-t I_n(t) for t = sigma^2 (Lindeberg 1990), from n = 0 to where less than
/// 1e-5 is left on each side; both sides together sum to 1.
std::vector<double> gaussian_kernel(double sigma);

/// The medians of the samples around each.
void take_medians(Volume& volume, int radius, Context* context);

/// Resamples to cubes of the smallest spacing. `mask`: of what is not 0, by signed distances; else linearly.
void interpolate(Volume& volume, bool mask, Context* context);
/// The grid of the result: its first corner is that of `grid`, its box as large but for half a voxel.
Grid cubes_of(const Grid& grid);

/// Integer samples that span less become float.
inline constexpr double kLeastSpan = 64;

/// Whether results computed from the samples are to be rounded to their type.
template <class T>
bool stays_whole(const std::vector<T>& samples) {
  if constexpr (!std::is_integral_v<T>) {
    return false;
  } else {
    if (samples.empty()) return true;
    const auto [low, high] = std::ranges::minmax(samples);
    return static_cast<double>(high) - static_cast<double>(low) >= kLeastSpan;
  }
}

/// Numbers to compute with: exact for the samples where a float is.
template <class T>
using Work = std::conditional_t<(sizeof(T) <= 2) || std::is_same_v<T, float>, float, double>;

template <class T>
bool is_finite(T sample) {
  if constexpr (std::is_integral_v<T>)
    return true;
  else
    return std::isfinite(sample);
}

/// The nearest sample, the upper one of two.
template <class T, class Number>
T as_sample(Number number) {
  if constexpr (std::is_integral_v<T>) {
    const Number whole = std::floor(number + Number{0.5});
    if (whole <= static_cast<Number>(std::numeric_limits<T>::min())) return std::numeric_limits<T>::min();
    if (whole >= std::ldexp(Number{1}, std::numeric_limits<T>::digits)) return std::numeric_limits<T>::max();
    return static_cast<T>(whole);
  } else {
    return static_cast<T>(number);
  }
}

/// Calls work(samples, out), where `out` is a vector of the type of the results: the samples themselves where they
/// stay whole or are not, else a vector of float, which takes their place.
template <class Work>
void with_results(Volume& volume, const Work& work) {
  std::visit(
      [&]<class T>(std::vector<T>& samples) {
        if (!std::is_integral_v<T> || stays_whole(samples)) return work(samples, samples);
        std::vector<float> out(samples.size());
        work(samples, out);
        volume.samples = std::move(out);
      },
      volume.samples);
}

}  // namespace quench::preparation
