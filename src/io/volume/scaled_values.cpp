// SPDX-License-Identifier: Apache-2.0
#include "io/volume/scaled_values.h"

#include <algorithm>
#include <cstring>
#include <limits>

#include "shape/sample_type.h"

namespace quench::io {

SampleType type_of_whole_numbers(double low, double high) {
  for (const SampleType type : {SampleType::uint8, SampleType::int8, SampleType::uint16, SampleType::int16,
                                SampleType::uint32, SampleType::int32})
    if (shape::with_sample_type(type, [&]<class T>(T) {
          return low >= static_cast<double>(std::numeric_limits<T>::lowest()) &&
                 high <= static_cast<double>(std::numeric_limits<T>::max());
        }))
      return type;
  return SampleType::float64;
}

SampleType LinearValues::type(SampleType stored) const {
  if (slope == std::floor(slope) && intercept == std::floor(intercept))
    return shape::with_sample_type(stored, [&]<class T>(T) {
      const double least = static_cast<double>(std::numeric_limits<T>::lowest()),
                   most = static_cast<double>(std::numeric_limits<T>::max());
      const auto [low, high] = std::minmax({slope * least + intercept, slope * most + intercept});
      return type_of_whole_numbers(low, high);
    });
  return fits_float32(slope, intercept) ? SampleType::float32 : SampleType::float64;
}

void LinearValues::apply(SampleType stored, std::span<const std::byte> samples, std::span<std::byte> out) const {
  shape::with_sample_type(stored, [&]<class From>(From) {
    shape::with_sample_type(type(stored), [&]<class To>(To) {
      for (std::size_t i = 0; i < samples.size() / sizeof(From); ++i) {
        From sample;
        std::memcpy(&sample, samples.data() + i * sizeof(From), sizeof(From));
        const auto value = static_cast<To>(slope * static_cast<double>(sample) + intercept);
        std::memcpy(out.data() + i * sizeof(To), &value, sizeof(To));
      }
    });
  });
}

}  // namespace quench::io
