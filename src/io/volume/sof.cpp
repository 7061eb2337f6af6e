// SPDX-License-Identifier: Apache-2.0
// The signed octree in which the authors of voxel cores publish their shapes: int32 n, a power of 2, then the
// nodes in pre-order. A cell of size s at (x, y, z) has its corners at x and x+s, and so on; corners are voxel centres.
#include <fmt/format.h>

#include <bit>
#include <cstring>

#include "base/text.h"
#include "io/volume/volume_formats.h"
#include "quench/error.h"

namespace quench::io {
namespace {

enum Node : unsigned char { internal = 0, empty = 1, leaf = 2 };

constexpr std::int32_t kLargestResolution = 2048;

struct Cell {
  std::int32_t x, y, z, size;
};

// Calls `visit(cell, node type, sign byte)` for empty and leaf cells in file order, after checking what it reads.
template <class Visit>
void each_cell(const std::vector<unsigned char>& bytes, std::int32_t n, const std::filesystem::path& file,
               const Visit& visit) {
  std::size_t at = 4;
  std::vector<Cell> open{{0, 0, 0, n}};  // pre-order: the next cell of the file is the last one here
  while (!open.empty()) {
    const Cell cell = open.back();
    open.pop_back();
    if (at >= bytes.size()) refuse(file, ".sof", fmt::format("the octree is cut off at byte {}", at));
    const unsigned char type = bytes[at++];
    if (type == internal) {
      if (cell.size == 1) refuse(file, ".sof", fmt::format("the cell before byte {} is divided below size 1", at));
      const std::int32_t half = cell.size / 2;
      for (int child = 8; child-- > 0;)
        open.push_back(
            {cell.x + (child >> 2 & 1) * half, cell.y + (child >> 1 & 1) * half, cell.z + (child & 1) * half, half});
      continue;
    }
    if (type != empty && type != leaf)
      refuse(file, ".sof", fmt::format("byte {} is {}, which is not a node type", at - 1, type));
    if (at >= bytes.size()) refuse(file, ".sof", fmt::format("the octree is cut off at byte {}", at));
    if (type == leaf && cell.size != 1)
      refuse(file, ".sof", fmt::format("the leaf before byte {} has size {}; leaves must be of size 1", at, cell.size));
    visit(cell, static_cast<Node>(type), bytes[at++]);
  }
  if (at != bytes.size()) refuse(file, ".sof", fmt::format("the octree ends at byte {} of {}", at, bytes.size()));
}

}  // namespace

Volume read_sof(const std::filesystem::path& file, Context* context) {
  InputFile in(file);
  std::vector<unsigned char> bytes(in.size);
  in.stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!in.stream || bytes.size() < 6) refuse(file, ".sof", "it is too short");
  std::uint32_t resolution = 0;
  std::memcpy(&resolution, bytes.data(), 4);
  if (!std::has_single_bit(resolution) || resolution > static_cast<std::uint32_t>(kLargestResolution))
    refuse(file, ".sof", fmt::format("the resolution {} is not a power of 2 up to {}", resolution, kLargestResolution));
  const auto n = static_cast<std::int32_t>(resolution);

  std::uint64_t leaves = 0;
  each_cell(bytes, n, file, [&](const Cell&, Node type, unsigned char) { leaves += type == leaf; });
  // A surface across n cells has at least n leaves; far fewer bytes for a large grid are not a shape.
  const auto side = static_cast<std::uint64_t>(n) + 1;
  const std::uint64_t voxels = side * side * side;
  if (leaves == 0 || (voxels > (std::uint64_t{1} << 28) && voxels / bytes.size() > 256 * side))
    refuse(file, ".sof", fmt::format("{} leaves are too few for a shape of resolution {}", leaves, n));

  check_read_memory(file, voxels + voxels / 8 + bytes.size(), context);  // also a bit per voxel, see below
  Volume volume;
  volume.grid.dims.fill(static_cast<std::int64_t>(side));
  std::vector<std::uint8_t> inside(voxels, 0);
  const auto at = [&](std::int32_t x, std::int32_t y, std::int32_t z) -> std::uint8_t& {
    return inside[static_cast<std::uint64_t>(x) +
                  side * (static_cast<std::uint64_t>(y) + side * static_cast<std::uint64_t>(z))];
  };
  // Neighbouring cells share corners. Leaves come second, so that they decide where an empty cell contradicts them.
  std::uint64_t count = 0, contradictions = 0;
  each_cell(bytes, n, file, [&](const Cell& c, Node type, unsigned char sign) {
    if ((++count & 0xffff) == 0) checkpoint(context, "read", 0);
    if (type != empty || sign != 0) return;
    for (std::int32_t z = c.z; z <= c.z + c.size; ++z)
      for (std::int32_t y = c.y; y <= c.y + c.size; ++y)
        std::memset(&at(c.x, y, z), 1, static_cast<std::size_t>(c.size) + 1);
  });
  std::vector<bool> decided(voxels, false);
  each_cell(bytes, n, file, [&](const Cell& c, Node type, unsigned char signs) {
    if (type != leaf) return;
    for (int corner = 0; corner < 8; ++corner) {
      std::uint8_t& voxel = at(c.x + (corner >> 2), c.y + (corner >> 1 & 1), c.z + (corner & 1));
      const auto index = static_cast<std::size_t>(&voxel - inside.data());
      const auto value = static_cast<std::uint8_t>(~signs >> corner & 1);
      contradictions += decided[index] && voxel != value;
      decided[index] = true;
      voxel = value;
    }
  });
  if (contradictions)
    note(context, fmt::format("'{}': neighbouring cells of the octree contradict each other at {}; the later "
                              "one was taken",
                              file.string(), base::counted(contradictions, "corner")));
  checkpoint(context, "read", 1);
  volume.samples = std::move(inside);
  return volume;
}

}  // namespace quench::io
