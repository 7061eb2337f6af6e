// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "quench/shape.h"

namespace quench::shape {

/// Calls `visit` with a value of the C++ type behind a sample type.
template <class Visit>
auto with_sample_type(SampleType type, const Visit& visit) {
  switch (type) {
    case SampleType::uint8:
      return visit(std::uint8_t{});
    case SampleType::int8:
      return visit(std::int8_t{});
    case SampleType::uint16:
      return visit(std::uint16_t{});
    case SampleType::int16:
      return visit(std::int16_t{});
    case SampleType::uint32:
      return visit(std::uint32_t{});
    case SampleType::int32:
      return visit(std::int32_t{});
    case SampleType::uint64:
      return visit(std::uint64_t{});
    case SampleType::int64:
      return visit(std::int64_t{});
    case SampleType::float32:
      return visit(float{});
    default:
      return visit(double{});
  }
}

inline std::size_t size_of(SampleType type) {
  return with_sample_type(type, [](auto value) { return sizeof value; });
}

}  // namespace quench::shape
