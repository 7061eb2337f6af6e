// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdlib>
#include <cstring>
#include <type_traits>

#include "quench/shape.h"
#include "shape/sample_type.h"

namespace quench::shape {

/// The samples of a view in one type. They need not be aligned.
template <class T>
class Samples {
 public:
  explicit Samples(const ImageView& image) : image_(image), base_(static_cast<const char*>(image.data)) {}

  const Grid& grid() const { return image_.grid; }
  const std::array<std::int64_t, 3>& strides() const { return image_.strides; }
  T at(std::int64_t x, std::int64_t y, std::int64_t z) const {
    return load(base_ + image_.strides[0] * x + image_.strides[1] * y + image_.strides[2] * z);
  }
  static T load(const char* from) {
    T value;
    std::memcpy(&value, from, sizeof(T));
    return value;
  }
  /// Axes by distance in memory, the closest last.
  std::array<int, 3> order() const {
    std::array<int, 3> axes{2, 1, 0};
    const auto far = [&](int a) { return std::abs(image_.strides[static_cast<std::size_t>(a)]); };
    for (int i = 0; i < 2; ++i)
      for (int j = 0; j < 2 - i; ++j)
        if (far(axes[j]) < far(axes[j + 1])) std::swap(axes[j], axes[j + 1]);
    return axes;
  }

 private:
  const ImageView& image_;
  const char* base_;
};

/// Calls `visit` with the samples of a view in their type.
template <class Visit>
auto with_samples(const ImageView& image, const Visit& visit) {
  return with_sample_type(image.type, [&]<class T>(T) { return visit(Samples<T>(image)); });
}

}  // namespace quench::shape
