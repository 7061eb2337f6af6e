// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

/// How bytes of chunks are packed.
namespace quench::io {

enum class ChunkCodec { deflate, zstd, blosc, crc32c };  ///< deflate: zlib or gzip

/// The codec that Zarr and N5 call "zlib", "gzip", "zstd", "blosc" or "crc32c". Throws Error(input) for others, and
/// Error(usage) for one that Quench was built without.
ChunkCodec chunk_codec(const std::filesystem::path& file, std::string_view name);

/// Undoes `codecs`, which stand in the order in which they were applied; at most one of them is not crc32c. False where
/// the bytes are damaged, or not packed of exactly `out.size()` bytes: no more than that is ever unpacked.
bool unpack_chunk(std::span<const std::byte> packed, std::span<const ChunkCodec> codecs, std::span<std::byte> out);

/// Castagnoli's polynomial (RFC 3720, B.4).
std::uint32_t crc32c(std::span<const std::byte> bytes);

}  // namespace quench::io
