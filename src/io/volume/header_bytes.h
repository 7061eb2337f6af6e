// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <vector>

namespace quench::io {

/// Numbers at fixed positions of a binary header, in its byte order.
class HeaderBytes {
 public:
  HeaderBytes() = default;
  HeaderBytes(std::vector<unsigned char> bytes, bool swapped) : bytes_(std::move(bytes)), swapped_(swapped) {}

  /// `place`: bytes before the number; the header must hold all of its bytes.
  template <class T>
  T at(std::size_t place) const {
    std::array<unsigned char, sizeof(T)> raw;
    std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(place), sizeof(T), raw.begin());
    if (swapped_) std::reverse(raw.begin(), raw.end());
    return std::bit_cast<T>(raw);
  }
  bool swapped() const { return swapped_; }
  void swap() { swapped_ = !swapped_; }

 private:
  std::vector<unsigned char> bytes_;
  bool swapped_ = false;
};

}  // namespace quench::io
