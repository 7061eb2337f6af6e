// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "io/volume/chunked_volume.h"
#include "io/volume/zarr_array.h"
#include "io/volume/zarr_axes.h"

namespace quench::io {

/// The chunks of an array as those of a section of it. Not for several threads at once.
class ZarrChunks {
 public:
  /// `file`: the name of the volume in errors.
  ZarrChunks(std::filesystem::path file, std::filesystem::path folder, ZarrArray array, ZarrSection section);

  /// Of a chunk along x, y, z.
  std::array<std::int64_t, 3> sides() const;
  bool exists(const ChunkIndex& index);
  void read(const ChunkIndex& index, std::span<std::byte> out);

 private:
  /// Along the axes of the array.
  using Index = std::vector<std::int64_t>;
  /// Where a chunk is in its shard; `size` 0: it is not there.
  struct Part {
    std::uint64_t begin = 0, size = 0;
  };

  Index index_of(const ChunkIndex& index) const;
  std::string name_of(const Index& file) const;
  bool is_file(const std::string& name) const;
  std::vector<std::byte> bytes_of(const std::string& name, std::uint64_t begin, std::uint64_t size) const;
  std::uint64_t size_of(const std::string& name) const;
  Part part_of(const Index& chunk);
  std::vector<Part> parts_of_shard(const std::string& name, std::size_t count) const;
  std::vector<std::byte> samples_of(const Index& chunk, std::vector<std::int64_t>& sides);
  void skip_header(const std::string& name, std::span<const std::byte>& packed, std::vector<std::int64_t>& sides) const;
  [[noreturn]] void refuse_chunk(const std::string& name, const std::string& why) const;

  std::filesystem::path file_, folder_;
  ZarrArray array_;
  ZarrSection section_;
  std::map<std::string, std::vector<Part>> shards_;  ///< by the names of their files
  std::size_t parts_ = 0;                            ///< in all of them
};

}  // namespace quench::io
