// SPDX-License-Identifier: Apache-2.0
#include "io/volume/sample_source.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <type_traits>
#include <vector>

#include "base/text.h"
#include "io/common/formats.h"
#include "io/common/words.h"
#include "io/volume/volume_formats.h"
#include "quench/error.h"
#include "shape/sample_type.h"

namespace quench::io {
namespace {

/// The bytes of a block as they are in the file.
class BlockBytes {
 public:
  explicit BlockBytes(const SampleBlock& block)
      : in_(block.file, std::ios::binary), left_(block.size.value_or(std::numeric_limits<std::uint64_t>::max())) {
    if (!in_) throw Error(ErrorCode::failed, fmt::format("'{}' cannot be opened", base::plain(block.file.string())));
    in_.seekg(static_cast<std::streamoff>(block.begin));
  }
  /// As many bytes as there are, up to the size of `out`.
  std::size_t read(std::span<std::byte> out) {
    const auto wanted = static_cast<std::streamsize>(std::min<std::uint64_t>(out.size(), left_));
    in_.read(reinterpret_cast<char*>(out.data()), wanted);
    const auto got = static_cast<std::size_t>(in_.gcount());
    left_ -= got;
    return got;
  }

 private:
  std::ifstream in_;
  std::uint64_t left_;
};

class RawSource : public SampleSource {
 public:
  explicit RawSource(const SampleBlock& block) : bytes_(block) {}
  bool read(std::span<std::byte> out) override { return bytes_.read(out) == out.size(); }

 private:
  BlockBytes bytes_;
};

class InflateSource : public SampleSource {
 public:
  explicit InflateSource(const SampleBlock& block) : bytes_(block), skip_(block.skip) {
    constexpr int kGzipOrZlib = 15 + 32;
    if (inflateInit2(&z_, kGzipOrZlib) != Z_OK) throw Error(ErrorCode::failed, "zlib cannot be started: out of memory");
  }
  InflateSource(const InflateSource&) = delete;
  InflateSource& operator=(const InflateSource&) = delete;
  ~InflateSource() override { inflateEnd(&z_); }

  bool read(std::span<std::byte> out) override {
    for (std::vector<std::byte> nowhere; skip_ > 0;) {
      nowhere.resize(std::min<std::uint64_t>(skip_, from_.size()));
      if (!inflate_into(nowhere)) return false;
      skip_ -= nowhere.size();
    }
    constexpr std::size_t kPiece = std::size_t{1} << 30;  // what one call of zlib can be asked for
    for (std::size_t done = 0; done < out.size(); done += kPiece)
      if (!inflate_into(out.subspan(done, std::min(out.size() - done, kPiece)))) return false;
    return true;
  }

  bool damaged() const override { return damaged_; }

  /// Reads on to the checksum, through what may follow the samples.
  bool ends_well() override {
    std::vector<std::byte> nowhere(from_.size());
    while (!at_end_) {
      z_.next_out = reinterpret_cast<Bytef*>(nowhere.data());
      z_.avail_out = static_cast<uInt>(nowhere.size());
      if (!step()) return false;
    }
    return true;
  }

 private:
  bool inflate_into(std::span<std::byte> out) {
    z_.next_out = reinterpret_cast<Bytef*>(out.data());
    z_.avail_out = static_cast<uInt>(out.size());
    while (z_.avail_out > 0) {
      if (at_end_) {  // another member may follow
        if (!more_bytes() || inflateReset(&z_) != Z_OK) return false;
        at_end_ = false;
      }
      if (!step()) return false;
    }
    return true;
  }
  bool step() {
    if (!more_bytes()) return false;
    const int state = inflate(&z_, Z_NO_FLUSH);
    at_end_ = state == Z_STREAM_END;
    damaged_ = damaged_ || state == Z_DATA_ERROR || state == Z_NEED_DICT;
    return state == Z_OK || state == Z_STREAM_END || state == Z_BUF_ERROR;
  }
  bool more_bytes() {
    if (z_.avail_in > 0) return true;
    z_.next_in = reinterpret_cast<Bytef*>(from_.data());
    z_.avail_in = static_cast<uInt>(bytes_.read(from_));
    return z_.avail_in > 0;
  }

  BlockBytes bytes_;
  std::uint64_t skip_;
  z_stream z_{};
  bool at_end_ = false;  ///< of a member
  bool damaged_ = false;
  std::vector<std::byte> from_ = std::vector<std::byte>(1 << 18);
};

/// Reads characters one at a time from a buffer.
class BlockCharacters {
 public:
  explicit BlockCharacters(const SampleBlock& block) : bytes_(block) {}
  /// -1 at the end.
  int next() {
    if (at_ == end_) {
      end_ = bytes_.read(buffer_);
      at_ = 0;
      if (end_ == 0) return -1;
    }
    return static_cast<unsigned char>(buffer_[at_++]);
  }

 private:
  BlockBytes bytes_;
  std::vector<std::byte> buffer_ = std::vector<std::byte>(1 << 16);
  std::size_t at_ = 0, end_ = 0;
};

bool is_blank(int c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

class HexSource : public SampleSource {
 public:
  explicit HexSource(const SampleBlock& block) : characters_(block) {}
  bool read(std::span<std::byte> out) override {
    for (std::byte& byte : out) {
      const int high = digit(), low = high < 0 ? -1 : digit();
      if (low < 0) return false;
      byte = static_cast<std::byte>(high << 4 | low);
    }
    return true;
  }

 private:
  int digit() {
    int c = characters_.next();
    while (is_blank(c)) c = characters_.next();
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
  }
  BlockCharacters characters_;
};

template <class T>
class TextSource : public SampleSource {
 public:
  explicit TextSource(const SampleBlock& block) : file_(block.file), characters_(block) {}
  bool read(std::span<std::byte> out) override {
    for (std::size_t at = 0; at + sizeof(T) <= out.size(); at += sizeof(T)) {
      const std::string word = next_word();
      if (word.empty()) return false;
      const T value = parse(word);
      std::memcpy(out.data() + at, &value, sizeof(T));
    }
    return true;
  }

 private:
  std::string next_word() {
    constexpr std::size_t kLongest = 64;
    int c = characters_.next();
    while (is_blank(c) || c == ',') c = characters_.next();
    std::string word;
    for (; c >= 0 && !is_blank(c) && c != ',' && word.size() <= kLongest; c = characters_.next())
      word.push_back(static_cast<char>(c));
    ++count_;
    return word;
  }
  T parse(const std::string& word) {
    if constexpr (std::is_floating_point_v<T>) {
      double value = 0;
      if (parse_number(word, value)) {
        if constexpr (std::is_same_v<T, float>)
          return std::isfinite(value) ? to_float(value) : static_cast<float>(value);
        else
          return value;
      }
    } else {
      const char* begin = word.data() + (word[0] == '+' ? 1 : 0);
      const char* end = word.data() + word.size();
      T value{};
      const auto [stop, error] = std::from_chars(begin, end, value);
      if (error == std::errc() && stop == end) return value;
    }
    refuse_volume(file_, fmt::format("sample {} is '{}', which is not a number of its sample type", count_,
                                     base::plain(word.substr(0, 40))));
  }

  std::filesystem::path file_;
  BlockCharacters characters_;
  std::uint64_t count_ = 0;
};

}  // namespace

std::unique_ptr<SampleSource> open_block(const SampleBlock& block, Encoding encoding, SampleType type) {
  if (encoding == Encoding::raw) return std::make_unique<RawSource>(block);
  if (encoding == Encoding::deflate) return std::make_unique<InflateSource>(block);
  if (encoding == Encoding::hex) return std::make_unique<HexSource>(block);
  std::unique_ptr<SampleSource> source;
  shape::with_sample_type(type, [&]<class T>(T) { source = std::make_unique<TextSource<T>>(block); });
  return source;
}

}  // namespace quench::io
