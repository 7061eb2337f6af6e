// SPDX-License-Identifier: Apache-2.0
#include "io/volume/tiff_directories.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <unordered_set>

#include "io/volume/volume_formats.h"
#include "quench/error.h"

namespace quench::io {

TiffFile::TiffFile(const std::filesystem::path& file, Context* context) : path_(file) {
  check_regular_file(file);
  size_ = InputFile(file).size;
  bytes_ = base::PlacedFile::open(file);
  if (!bytes_.is_open())
    throw Error(ErrorCode::failed,
                fmt::format("'{}' cannot be opened; check the name and the permissions", file.string()));
  follow_chain(context);
}

std::size_t TiffFile::read(std::uint64_t at, std::span<std::byte> out) const {
  return at < size_ ? bytes_.read(at, out) : 0;
}

std::uint64_t TiffFile::number(const std::byte* bytes, std::size_t size) const {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < size; ++i)
    value = value << 8 | std::to_integer<std::uint64_t>(bytes[big_endian_ ? i : size - 1 - i]);
  return value;
}

std::optional<std::uint64_t> TiffFile::number_at(std::uint64_t at, std::size_t size) const {
  std::array<std::byte, 8> bytes;
  if (at > size_ || read(at, std::span(bytes).first(size)) != size) return {};
  return number(bytes.data(), size);
}

std::uint64_t TiffFile::next_directory(std::uint64_t directory, std::size_t index) const {
  const std::size_t count_size = big_tiff_ ? 8 : 2, entry_size = big_tiff_ ? 20 : 12, offset_size = big_tiff_ ? 8 : 4;
  const auto entries = number_at(directory, count_size);
  if (entries && *entries > 0 && *entries <= size_ / entry_size)
    if (const auto next = number_at(directory + count_size + *entries * entry_size, offset_size)) return *next;
  throw Error(ErrorCode::input,
              fmt::format("'{}' is damaged or incomplete: the directory of page {}, at byte {} of {}, is not whole",
                          path_.string(), index + 1, directory, size_));
}

void TiffFile::follow_chain(Context* context) {
  constexpr std::size_t kMost = 1000000;  // pages; far more than the slices of any volume
  std::array<std::byte, 16> header{};
  const std::size_t got = read(0, header);
  const auto letter = [&](std::size_t i) { return std::to_integer<char>(header[i]); };
  big_endian_ = letter(0) == 'M';
  const std::uint64_t version = number(&header[2], 2);
  big_tiff_ = version == 43;
  if (got < 8 || letter(0) != letter(1) || (letter(0) != 'M' && letter(0) != 'I') || (version != 42 && !big_tiff_) ||
      (big_tiff_ && (got < 16 || number(&header[4], 2) != 8)))
    throw Error(ErrorCode::input, fmt::format("'{}' cannot be read as TIFF: it does not begin as one", path_.string()));
  std::unordered_set<std::uint64_t> seen;
  for (std::uint64_t at = big_tiff_ ? number(&header[8], 8) : number(&header[4], 4); at != 0;) {
    checkpoint(context, "read", 0);
    if (directories_.size() == kMost)
      throw Error(ErrorCode::input,
                  fmt::format("'{}' has more than {} pages; it is damaged, or save it in several files", path_.string(),
                              kMost));
    if (!seen.insert(at).second)
      throw Error(ErrorCode::input,
                  fmt::format("'{}' is damaged: the directory after page {} is that of page {} again", path_.string(),
                              directories_.size(),
                              std::find(directories_.begin(), directories_.end(), at) - directories_.begin() + 1));
    const std::uint64_t next = next_directory(at, directories_.size());
    directories_.push_back(at);
    at = next;
  }
  if (directories_.empty())
    throw Error(ErrorCode::input, fmt::format("'{}' is damaged or incomplete: it has no pages", path_.string()));
}

std::optional<TiffFile::Entry> TiffFile::entry(std::uint64_t directory, std::uint16_t tag) const {
  constexpr std::array<std::uint8_t, 18> kSizes{0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8, 4, 0, 0, 8, 8};  // by type
  const std::size_t count_size = big_tiff_ ? 8 : 2, entry_size = big_tiff_ ? 20 : 12, offset_size = big_tiff_ ? 8 : 4;
  const std::uint64_t entries = number_at(directory, count_size).value_or(0);  // follow_chain() has checked it
  for (std::uint64_t i = 0; i < entries; ++i) {
    std::array<std::byte, 20> bytes{};
    const std::uint64_t at = directory + count_size + i * entry_size;
    if (read(at, std::span(bytes).first(entry_size)) != entry_size) return {};
    if (number(&bytes[0], 2) != tag) continue;
    Entry found{number(&bytes[2], 2), number(&bytes[4], offset_size), 0};
    if (found.type >= kSizes.size() || found.count > size_) return {};
    const bool inside = found.count * kSizes[found.type] <= offset_size;
    found.values = inside ? at + 4 + offset_size : number(&bytes[4 + offset_size], offset_size);
    return found;
  }
  return {};
}

std::optional<TiffFile::Rational> TiffFile::rational(std::uint64_t directory, std::uint16_t tag) const {
  constexpr std::uint64_t kRationalType = 5;
  const auto found = entry(directory, tag);
  if (!found || found->type != kRationalType || found->count != 1) return {};
  const auto numerator = number_at(found->values, 4), denominator = number_at(found->values + 4, 4);
  if (!numerator || !denominator) return {};
  return Rational{static_cast<std::uint32_t>(*numerator), static_cast<std::uint32_t>(*denominator)};
}

std::vector<std::uint64_t> TiffFile::numbers(std::uint64_t directory, std::uint16_t tag) const {
  const auto found = entry(directory, tag);
  const std::size_t size = !found ? 0 : found->type == 3 ? 2 : found->type == 4 ? 4 : found->type == 16 ? 8 : 0;
  if (size == 0 || found->count > size_ / size || found->values > size_) return {};
  std::vector<std::byte> bytes(found->count * size);
  if (read(found->values, bytes) != bytes.size()) return {};
  std::vector<std::uint64_t> values(found->count);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = number(&bytes[i * size], size);
  return values;
}

}  // namespace quench::io
