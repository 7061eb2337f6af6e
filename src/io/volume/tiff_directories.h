// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/platform/system_files.h"
#include "quench/context.h"

/// The chain of directories (pages) of a TIFF file, followed without libtiff, whose TIFFReadDirectory() does not tell
/// the last directory from a damaged one.
namespace quench::io {

/// A TIFF file, open for reading at any place.
class TiffFile {
 public:
  /// Reads the header and follows the chain. Throws Error(failed) when the file cannot be opened, and Error(input) when
  /// it is not TIFF or when its chain leaves the file, ends in the middle of a directory, returns to one before or has
  /// more than a million. `context` is not kept.
  TiffFile(const std::filesystem::path& file, Context* context);
  TiffFile(const TiffFile&) = delete;
  TiffFile& operator=(const TiffFile&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::uint64_t size() const { return size_; }
  bool big_endian() const { return big_endian_; }
  bool big_tiff() const { return big_tiff_; }  ///< offsets of 8 bytes
  /// Where the directories begin, in the order of the chain; at least one.
  const std::vector<std::uint64_t>& directories() const { return directories_; }

  /// Fills `out` from byte `at` on, as far as the file goes; the number of bytes read.
  std::size_t read(std::uint64_t at, std::span<std::byte> out) const;

  /// The numerator and denominator of an unsigned rational tag, as they are stored.
  struct Rational {
    std::uint32_t numerator = 0, denominator = 0;
  };
  std::optional<Rational> rational(std::uint64_t directory, std::uint16_t tag) const;
  /// All values of a tag of unsigned integers; empty where there is none.
  std::vector<std::uint64_t> numbers(std::uint64_t directory, std::uint16_t tag) const;

 private:
  std::uint64_t number(const std::byte* bytes, std::size_t size) const;
  std::optional<std::uint64_t> number_at(std::uint64_t at, std::size_t size) const;
  struct Entry {
    std::uint64_t type, count;
    std::uint64_t values;  // where they are
  };
  std::optional<Entry> entry(std::uint64_t directory, std::uint16_t tag) const;
  std::uint64_t next_directory(std::uint64_t directory, std::size_t index) const;
  void follow_chain(Context* context);

  std::filesystem::path path_;
  base::PlacedFile bytes_;
  std::uint64_t size_ = 0;
  bool big_endian_ = false, big_tiff_ = false;
  std::vector<std::uint64_t> directories_;
};

}  // namespace quench::io
