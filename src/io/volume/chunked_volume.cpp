// SPDX-License-Identifier: Apache-2.0
#include "io/volume/chunked_volume.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "io/volume/volume_formats.h"
#include "quench/error.h"
#include "shape/sample_type.h"

namespace quench::io {
namespace {

class ChunkLayers {
 public:
  ChunkLayers(std::filesystem::path file, const ChunkedVolume& volume, Context* context)
      : file_(std::move(file)), volume_(volume), context_(context), size_(shape::size_of(volume.type)) {
    const auto& dims = volume.grid.dims;
    for (std::size_t a = 0; a < 3; ++a) count_[a] = (dims[a] - 1) / volume.chunk[a] + 1;
    columns_.resize(static_cast<std::size_t>(count_[0] * count_[1]));
    fill_row_.resize(static_cast<std::size_t>(dims[0]) * size_);
    for (std::size_t at = 0; at < fill_row_.size(); at += size_) std::memcpy(&fill_row_[at], volume.fill.data(), size_);
  }

  void next(std::span<std::byte> out) {
    if (z_ % volume_.chunk[2] == 0) load(z_ / volume_.chunk[2]);
    const auto& dims = volume_.grid.dims;
    for (std::int64_t y = 0; y < dims[1]; ++y) copy_row(y, out.data() + static_cast<std::size_t>(y * dims[0]) * size_);
    ++z_;
  }

 private:
  std::size_t bytes_of_chunk() const {
    const auto& chunk = volume_.chunk;
    return static_cast<std::size_t>(chunk[0] * chunk[1] * chunk[2]) * size_;
  }

  /// The chunks of a layer that are there. Their memory is that of the layer before.
  void load(std::int64_t layer) {
    std::vector<std::vector<std::byte>> free;
    std::vector<std::size_t> there;
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      if (!columns_[c].empty()) free.push_back(std::exchange(columns_[c], {}));
      if (volume_.exists(index_of(c, layer))) there.push_back(c);
    }
    if (there.size() > free.size()) check_read_memory(file_, (there.size() - held(free)) * bytes_of_chunk(), context_);
    for (const std::size_t c : there) {
      if (context_ && context_->cancelled()) throw Error(ErrorCode::cancelled, "cancelled");
      if (!free.empty()) {
        columns_[c] = std::move(free.back());
        free.pop_back();
      }
      columns_[c].resize(bytes_of_chunk());
      volume_.read(index_of(c, layer), columns_[c]);
    }
  }

  /// How many chunks need no further memory: a limit counts all of them, what is free does not.
  std::size_t held(const std::vector<std::vector<std::byte>>& free) const {
    return context_ && context_->memory_limit > 0 ? 0 : free.size();
  }

  ChunkIndex index_of(std::size_t column, std::int64_t layer) const {
    const auto c = static_cast<std::int64_t>(column);
    return {c % count_[0], c / count_[0], layer};
  }

  void copy_row(std::int64_t y, std::byte* out) const {
    const auto& chunk = volume_.chunk;
    const std::vector<std::byte>* columns = columns_.data() + static_cast<std::size_t>(y / chunk[1] * count_[0]);
    const std::int64_t row = z_ % chunk[2] * chunk[1] + y % chunk[1];  // within each chunk
    for (std::int64_t c = 0; c < count_[0];) {
      const std::int64_t begin = c++;
      const std::vector<std::byte>& samples = columns[begin];
      while (samples.empty() && c < count_[0] && columns[c].empty()) ++c;
      const auto from = static_cast<std::size_t>(begin * chunk[0]) * size_;
      const auto to = std::min(static_cast<std::size_t>(c * chunk[0]) * size_, fill_row_.size());
      std::memcpy(
          out + from,
          samples.empty() ? fill_row_.data() : samples.data() + static_cast<std::size_t>(row * chunk[0]) * size_,
          to - from);
    }
  }

  std::filesystem::path file_;
  ChunkedVolume volume_;
  Context* context_;
  std::size_t size_;                             // of a sample
  std::array<std::int64_t, 3> count_{};          // of chunks
  std::vector<std::vector<std::byte>> columns_;  // the chunks of the layer, x fastest; empty: not there
  std::vector<std::byte> fill_row_;
  std::int64_t z_ = 0;
};

/// What a stream takes before a chunk is read, with the offsets of rows of the shape that is made of it.
std::uint64_t bytes_of_slices(const ChunkedVolume& volume) {
  const auto& dims = volume.grid.dims;
  const auto number = [](std::int64_t n) { return static_cast<std::uint64_t>(n); };
  const auto chunks = [&](std::size_t a) { return number((dims[a] - 1) / volume.chunk[a] + 1); };
  return number(dims[0]) * number(dims[1]) * shape::size_of(volume.type) +
         chunks(0) * chunks(1) * sizeof(std::vector<std::byte>) + number(dims[1]) * number(dims[2]) * 4;
}

}  // namespace

SliceStream open_chunks(const std::filesystem::path& file, const ChunkedVolume& volume, Context* context) {
  constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 62;
  constexpr double kLargestChunk = std::numeric_limits<std::int32_t>::max();  // as of Blosc
  checked_sample_count(file, volume.grid.dims, shape::size_of(volume.type), kMostBytes);
  double bytes = static_cast<double>(shape::size_of(volume.type));
  for (const std::int64_t side : volume.chunk) bytes *= static_cast<double>(side);
  if (*std::min_element(volume.chunk.begin(), volume.chunk.end()) < 1 || bytes > kLargestChunk)
    throw Error(
        ErrorCode::input,
        fmt::format("'{}' claims chunks of {} x {} x {} samples; every side must be 1 or more, and a chunk less "
                    "than 2 GiB",
                    file.string(), volume.chunk[0], volume.chunk[1], volume.chunk[2]));
  check_read_memory(file, bytes_of_slices(volume), context);
  SliceStream stream;
  stream.grid = volume.grid;
  stream.type = volume.type;
  stream.coordinates = volume.coordinates;
  stream.spacing_source = volume.spacing_source;
  const auto layers = std::make_shared<ChunkLayers>(file, volume, context);
  stream.next = [layers](std::span<std::byte> out) { layers->next(out); };
  return stream;
}

}  // namespace quench::io
