// SPDX-License-Identifier: Apache-2.0
// TIFF volumes, through libtiff.
#include <algorithm>

#include "io/volume/slice_streams.h"
#include "memory_file.h"
#include "quench/context.h"
#include "shape/sample_type.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace quench;
  static const fuzz::MemoryFile file(".tif");
  fuzz::reads_or_refuses(
      [&] {
        Context context;
        context.memory_limit = 1 << 20;  // for a slice
        const SliceStream stream = io::open_tiff(file.holding(data, size), {}, &context);
        const auto& dims = stream.grid.dims;
        if (*std::min_element(dims.begin(), dims.end()) < 1) fuzz::defect("a side of the volume is not positive");
        if (!stream.grid.spacing.allFinite() || stream.grid.spacing.minCoeff() <= 0)
          fuzz::defect("the spacing is not positive");
        std::vector<std::byte> slice(static_cast<std::size_t>(dims[0] * dims[1]) * shape::size_of(stream.type));
        constexpr std::int64_t enough = 50;
        for (std::int64_t z = 0; z < std::min(dims[2], enough); ++z) stream.next(slice);
      },
      true);
  return 0;
}
