// SPDX-License-Identifier: Apache-2.0
#include "io/mesh/vtp_blocks.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <vector>

#include "base/memory.h"
#include "quench/error.h"

namespace quench::io {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are written in the byte order of the processor");

/// Large enough to compress well, small enough to share among threads.
constexpr std::size_t kBlockBytes = std::size_t{1} << 18;
/// zlib cannot expand a byte to more.
constexpr std::uint64_t kLargestExpansion = 1040;

int base64_digit(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  return c == '+' ? 62 : c == '/' ? 63 : -1;
}

/// Takes bytes from raw or base64 storage.
class Source {
 public:
  Source(std::string_view stored, const BlockFormat& format, const std::string& what)
      : stored_(stored), format_(format), what_(what) {}

  [[noreturn]] void fail(const char* reason) const {
    throw Error(ErrorCode::input, fmt::format("{} {}", what_, reason));
  }

  /// The most bytes that can be left.
  std::uint64_t remaining() const { return format_.base64 ? (stored_.size() - at_) / 4 * 3 : stored_.size() - at_; }

  /// `count` bytes; in base64 they are encoded on their own.
  std::string take(std::uint64_t count) {
    if (count > remaining()) fail("is incomplete; copy the file again");
    if (!format_.base64) {
      at_ += count;
      return std::string(stored_.substr(at_ - count, count));
    }
    std::string bytes;
    bytes.reserve(count + 2);
    while (bytes.size() < count) take_group(bytes);
    bytes.resize(count);
    return bytes;
  }

  std::uint64_t word(const std::string& bytes, std::size_t index) const {
    std::uint64_t value = 0;
    std::memcpy(&value, bytes.data() + index * word_size(), word_size());
    return value;
  }
  std::size_t word_size() const { return format_.wide_headers ? 8 : 4; }

  const std::string& what() const { return what_; }
  std::size_t place() const { return at_; }
  void return_to(std::size_t place) { at_ = place; }

 private:
  /// Four digits are three bytes; "=" at the end stands for missing ones.
  void take_group(std::string& bytes) {
    std::uint32_t bits = 0;
    int digits = 0, missing = 0;
    while (digits + missing < 4) {
      if (at_ == stored_.size()) fail("is incomplete; copy the file again");
      const char c = stored_[at_++];
      if (c == ' ' || c == '\n' || c == '\r' || c == '\t') continue;
      const int digit = base64_digit(c);
      if (c == '=' && digits >= 2) {
        ++missing;
        bits <<= 6;
      } else if (digit >= 0 && missing == 0) {
        ++digits;
        bits = bits << 6 | static_cast<std::uint32_t>(digit);
      } else {
        fail("is not base64");
      }
    }
    for (int byte = 0; byte < 3 - missing; ++byte) bytes += static_cast<char>(bits >> (16 - 8 * byte) & 0xFF);
  }

  std::string_view stored_;
  BlockFormat format_;
  const std::string& what_;
  std::size_t at_ = 0;
};

std::string decode_whole(Source& source) {
  const std::size_t start = source.place();
  const std::uint64_t size = source.word(source.take(source.word_size()), 0);
  // Header and data are encoded together.
  source.return_to(start);
  if (size > source.remaining()) source.fail("is incomplete; copy the file again");
  std::string bytes = source.take(source.word_size() + size);
  bytes.erase(0, source.word_size());
  return bytes;
}

std::string decode_compressed(Source& source) {
  const std::size_t start = source.place();
  const std::uint64_t blocks = source.word(source.take(source.word_size()), 0);
  if (blocks == 0) return {};
  source.return_to(start);
  if (blocks > source.remaining() / source.word_size()) source.fail("is incomplete; copy the file again");
  const std::string header = source.take((3 + blocks) * source.word_size());
  const std::uint64_t full = source.word(header, 1), last = source.word(header, 2);
  std::uint64_t stored_bytes = 0;
  for (std::uint64_t b = 0; b < blocks; ++b) {
    const std::uint64_t size = source.word(header, 3 + b);
    if (size > source.remaining() || stored_bytes + size > source.remaining())
      source.fail("is incomplete; copy the file again");
    stored_bytes += size;
  }
  // The size of a full block is nominal where there is one block only.
  const std::uint64_t limit = stored_bytes * kLargestExpansion;
  if (last > full || (blocks > 1 && full > limit / (blocks - 1)))
    source.fail("has a damaged block header; copy the file again");
  const std::uint64_t size = (blocks - 1) * full + (last ? last : full);
  if (size > limit) source.fail("has a damaged block header; copy the file again");

  constexpr std::uint64_t kMuch = std::uint64_t{1} << 28;  // asking the system takes longer than unpacking less
  if (size > kMuch && size > static_cast<std::uint64_t>(base::available_memory()))
    throw Error(ErrorCode::failed, fmt::format("{} needs {} of memory, and {} are free; use a smaller file",
                                               source.what(), base::bytes_text(static_cast<std::int64_t>(size)),
                                               base::bytes_text(base::available_memory())));
  const std::string stored = source.take(stored_bytes);
  std::string bytes(size, '\0');
  std::uint64_t from = 0;
  for (std::uint64_t b = 0; b < blocks; ++b) {
    const std::uint64_t from_size = source.word(header, 3 + b);
    const std::uint64_t to_size = b + 1 == blocks && last ? last : full;
    uLongf written = to_size;
    const int result = ::uncompress(reinterpret_cast<Bytef*>(bytes.data() + b * full), &written,
                                    reinterpret_cast<const Bytef*>(stored.data() + from), from_size);
    if (result != Z_OK || written != to_size) source.fail("has a damaged zlib block; copy the file again");
    from += from_size;
  }
  return bytes;
}

}  // namespace

std::string decode_blocks(std::string_view stored, const BlockFormat& format, const std::string& what) {
  Source source(stored, format, what);
  return format.compressed ? decode_compressed(source) : decode_whole(source);
}

std::string encode_blocks(std::string_view bytes) {
  const std::size_t blocks = (bytes.size() + kBlockBytes - 1) / kBlockBytes;
  std::vector<std::string> compressed(blocks);
  std::vector<char> failed(blocks, 0);
  tbb::parallel_for(std::size_t{0}, blocks, [&](std::size_t b) {
    const std::string_view part = bytes.substr(b * kBlockBytes, kBlockBytes);
    uLongf size = ::compressBound(part.size());
    compressed[b].resize(size);
    failed[b] = ::compress2(reinterpret_cast<Bytef*>(compressed[b].data()), &size,
                            reinterpret_cast<const Bytef*>(part.data()), part.size(), Z_BEST_SPEED) != Z_OK;
    compressed[b].resize(size);
  });
  if (std::find(failed.begin(), failed.end(), 1) != failed.end())
    throw Error(ErrorCode::failed, "zlib cannot compress an array: not enough memory");
  std::string stored;
  const auto put = [&](std::uint64_t word) {
    const auto raw = std::bit_cast<std::array<char, 8>>(word);
    stored.append(raw.data(), raw.size());
  };
  put(blocks);
  put(kBlockBytes);
  put(bytes.size() % kBlockBytes);
  for (const std::string& block : compressed) put(block.size());
  for (const std::string& block : compressed) stored += block;
  return stored;
}

}  // namespace quench::io
