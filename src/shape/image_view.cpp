// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "quench/error.h"
#include "quench/shape.h"

namespace quench {

ImageView view_of(const Volume& volume) {
  ImageView image;
  image.grid = volume.grid;
  image.type = static_cast<SampleType>(volume.samples.index());
  const auto& dims = volume.grid.dims;
  std::visit(
      [&](const auto& samples) {
        if (samples.size() != static_cast<std::uint64_t>(dims[0] * dims[1] * dims[2]))
          throw Error(ErrorCode::invariant, fmt::format("a volume of {} x {} x {} voxels has {} samples", dims[0],
                                                        dims[1], dims[2], samples.size()));
        image.data = samples.data();
        const auto size = static_cast<std::int64_t>(sizeof(samples[0]));
        image.strides = {size, size * dims[0], size * dims[0] * dims[1]};
      },
      volume.samples);
  return image;
}

}  // namespace quench
