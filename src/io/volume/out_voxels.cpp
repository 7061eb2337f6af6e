// SPDX-License-Identifier: Apache-2.0
// The sparse voxel lists of the programs of DynamicRoots: the size of a voxel in mm, the number of voxels, then
// `x y z` per voxel, each on a line.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>

#include "base/text.h"
#include "io/common/formats.h"
#include "io/common/words.h"
#include "io/volume/slice_streams.h"
#include "io/volume/volume_formats.h"
#include "quench/error.h"

namespace quench::io {
namespace {

/// z first: in the order of slices.
using ListedVoxel = std::array<std::int32_t, 3>;

constexpr std::int64_t kFarthest = std::numeric_limits<std::int32_t>::max() / 2;

struct VoxelList {
  double scale = 1;
  std::vector<ListedVoxel> voxels;
};

VoxelList read_list(const std::filesystem::path& file, Context* context) {
  const FileText text = load_file(file, context);
  Words words(text.bytes, text.name, {.comment = 0});
  VoxelList list;
  list.scale = words.number("the size of a voxel");
  if (!(list.scale > 0 && list.scale <= kLargestLength)) words.fail("the size of a voxel is not a positive number");
  const std::int64_t count = words.integer("the number of voxels");
  // The shortest line is "0 0 0".
  if (count < 1 || static_cast<std::uint64_t>(count) > (words.remaining() + 1) / 6)
    words.fail(fmt::format("there are not {} voxels in the file", count));
  list.voxels.reserve(static_cast<std::size_t>(count));
  for (std::int64_t i = 0; i < count; ++i) {
    if (i % 65536 == 0) checkpoint(context, "read", static_cast<double>(i) / static_cast<double>(count));
    ListedVoxel voxel;
    for (std::size_t a = 0; a < 3; ++a) {
      const std::int64_t value = words.integer("a coordinate");
      if (std::abs(value) > kFarthest) words.fail(fmt::format("a coordinate is {}, which is too far away", value));
      voxel[2 - a] = static_cast<std::int32_t>(value);
    }
    list.voxels.push_back(voxel);
  }
  if (!words.next().empty()) words.fail(fmt::format("there are more voxels than the {} of line 2", count));
  std::ranges::sort(list.voxels);
  return list;
}

}  // namespace

SliceStream open_out_voxels(const std::filesystem::path& file, Context* context) {
  check_regular_file(file);
  const auto list = std::make_shared<const VoxelList>(read_list(file, context));
  ListedVoxel low = list->voxels[0], high = low;
  for (const ListedVoxel& voxel : list->voxels)
    for (std::size_t a = 0; a < 3; ++a) {
      low[a] = std::min(low[a], voxel[a]);
      high[a] = std::max(high[a], voxel[a]);
    }
  SliceStream stream;
  Grid& grid = stream.grid;
  for (std::size_t a = 0; a < 3; ++a) {
    grid.dims[a] = std::int64_t{high[2 - a]} - low[2 - a] + 1;
    grid.origin[static_cast<Eigen::Index>(a)] = list->scale * low[2 - a];
  }
  grid.spacing.setConstant(list->scale);
  checked_sample_count(file, grid.dims, 1, std::numeric_limits<std::uint64_t>::max());
  stream.type = SampleType::uint8;
  stream.coordinates.units = "mm";
  stream.spacing_source = "its first line";
  stream.next = [list, low, width = grid.dims[0], z = low[0], at = std::size_t{0}](std::span<std::byte> slice) mutable {
    std::memset(slice.data(), 0, slice.size());
    for (; at < list->voxels.size() && list->voxels[at][0] == z; ++at) {
      const ListedVoxel& voxel = list->voxels[at];
      slice[static_cast<std::size_t>((voxel[1] - low[1]) * width + (voxel[2] - low[2]))] = std::byte{1};
    }
    ++z;
  };
  return stream;
}

}  // namespace quench::io
