// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>

#include "quench/image.h"

namespace quench::io {

/// What ITK says about a volume of three axes before its samples are read.
struct ItkHeader {
  Grid grid;
  SampleType type = SampleType::uint8;
  std::size_t sample_size = 1;
  std::function<void(std::span<std::byte>)> next_slice;  ///< empty where ITK reads the format only as a whole
};

/// Nothing for files that read_itk() refuses or treats in a special way. Throws Error(input) for a damaged header.
std::optional<ItkHeader> itk_header(const std::filesystem::path& file, Context* context);

}  // namespace quench::io
