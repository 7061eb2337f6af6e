// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "io/volume/chunk_codecs.h"
#include "io/volume/stored_volume.h"
#include "io/volume/zarr_node.h"

namespace quench::io {

/// What the metadata of an array say. Axes are in the order of Zarr, the last one being the fastest in an array of C
/// order; those of N5, which counts them the other way round, are reversed.
struct ZarrArray {
  std::vector<std::int64_t> shape;
  std::vector<std::int64_t> chunk;  ///< of samples that are packed together
  std::vector<std::int64_t> shard;  ///< of chunks in a file; empty: a file holds one chunk
  std::vector<std::size_t> order;   ///< the axes of a chunk as its samples lie, slowest first
  std::vector<std::string> names;   ///< of axes; empty: the array does not say
  StoredType type;
  bool swapped = false;             ///< the byte order is not the one of this machine
  std::array<std::byte, 8> fill{};  ///< a sample as it is in memory
  std::vector<ChunkCodec> codecs;   ///< as they were applied
  bool index_checked = false;       ///< the index of a shard has a checksum
  bool index_first = false;         ///< the index of a shard is at its begin
  std::string prefix;               ///< of the names of chunks
  char separator = '.';
  bool n5 = false;  ///< blocks have headers, and their names begin with x

  std::size_t axes() const { return shape.size(); }
};

/// Throws Error(input) for metadata that are damaged, and for all that samples of one number each in regular chunks are
/// not; Error(usage) for packings that Quench was built without. `file` is named in errors.
ZarrArray zarr_array(const std::filesystem::path& file, const ZarrNode& node);

}  // namespace quench::io
