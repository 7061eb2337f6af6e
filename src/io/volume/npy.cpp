// SPDX-License-Identifier: Apache-2.0
// NPY, as numpy.lib.format documents it: magic, version, header length, a Python dictionary as text, raw samples.
#include <fmt/format.h>

#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <string_view>

#include "base/text.h"
#include "io/common/words.h"
#include "io/volume/float16.h"
#include "io/volume/volume_formats.h"
#include "quench/error.h"

namespace quench::io {
namespace {

static_assert(std::endian::native == std::endian::little, "sample readers assume a little-endian machine");

struct Header {
  std::string descr;
  bool fortran_order = false;
  std::vector<std::int64_t> shape;
};

// Just enough of Python's literals for {'descr': '<f8', 'fortran_order': False, 'shape': (3, 4, 5), }.
class DictionaryParser {
 public:
  DictionaryParser(std::string_view text, const std::filesystem::path& file) : text_(text), file_(file) {}

  Header parse() {
    Header header;
    bool descr = false, order = false, shape = false;
    expect('{');
    while (!accept('}')) {
      const std::string key = quoted();
      expect(':');
      if (key == "descr") {
        skip_space();
        if (at_ < text_.size() && text_[at_] != '\'' && text_[at_] != '"')
          refuse(file_, "NPY", "its samples are records; save one field as a plain number type");
        header.descr = quoted();
        descr = true;
      } else if (key == "fortran_order") {
        header.fortran_order = boolean();
        order = true;
      } else if (key == "shape") {
        header.shape = tuple();
        shape = true;
      } else {
        refuse(file_, "NPY", fmt::format("the header has an unknown key '{}'", key.substr(0, 40)));
      }
      if (!accept(',')) {
        expect('}');
        break;
      }
    }
    if (!descr || !order || !shape) refuse(file_, "NPY", "the header lacks descr, fortran_order or shape");
    return header;
  }

 private:
  void skip_space() {
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\n' || text_[at_] == '\t')) ++at_;
  }
  bool accept(char c) {
    skip_space();
    if (at_ >= text_.size() || text_[at_] != c) return false;
    ++at_;
    return true;
  }
  void expect(char c) {
    if (!accept(c)) refuse(file_, "NPY", fmt::format("'{}' is missing at byte {} of the header", c, at_));
  }
  std::string quoted() {
    skip_space();
    const char quote = at_ < text_.size() ? text_[at_] : '\0';
    if (quote != '\'' && quote != '"')
      refuse(file_, "NPY", fmt::format("a string is missing at byte {} of the header", at_));
    const std::size_t end = text_.find(quote, at_ + 1);
    if (end == std::string_view::npos) refuse(file_, "NPY", "a string in the header does not end");
    std::string value(text_.substr(at_ + 1, end - at_ - 1));
    at_ = end + 1;
    return value;
  }
  bool boolean() {
    skip_space();
    for (const bool value : {true, false}) {
      const std::string_view word = value ? "True" : "False";
      if (text_.substr(at_, word.size()) == word) {
        at_ += word.size();
        return value;
      }
    }
    refuse(file_, "NPY", "fortran_order is neither True nor False");
  }
  std::vector<std::int64_t> tuple() {
    std::vector<std::int64_t> values;
    expect('(');
    while (!accept(')')) {
      skip_space();
      std::int64_t value = 0;
      const auto [end, error] = std::from_chars(text_.data() + at_, text_.data() + text_.size(), value);
      if (error != std::errc()) refuse(file_, "NPY", "the shape is not a tuple of numbers");
      at_ = static_cast<std::size_t>(end - text_.data());
      accept('L');  // Python 2 wrote long integers so
      values.push_back(value);
      if (values.size() > 32) refuse(file_, "NPY", "the shape has more than 32 axes");
      if (!accept(',')) {
        expect(')');
        break;
      }
    }
    return values;
  }

  std::string_view text_;
  const std::filesystem::path& file_;
  std::size_t at_ = 0;
};

template <class T>
std::vector<T> read_samples(InputFile& in, const std::filesystem::path& file, std::uint64_t count, bool swap,
                            Context* context) {
  std::vector<T> samples(count);
  constexpr std::uint64_t kBlock = 16 << 20;
  const std::uint64_t bytes = count * sizeof(T);
  for (std::uint64_t at = 0; at < bytes; at += kBlock) {
    checkpoint(context, "read", static_cast<double>(at) / static_cast<double>(bytes));
    in.stream.read(reinterpret_cast<char*>(samples.data()) + at,
                   static_cast<std::streamsize>(std::min(kBlock, bytes - at)));
    if (!in.stream) refuse(file, "NPY", "the samples end too early");
  }
  if (swap && sizeof(T) > 1) swap_bytes(samples);
  checkpoint(context, "read", 1);
  return samples;
}

// Memory order decides: x is the axis that is contiguous. More than three axes are fine where all but three have
// length 1.
std::array<std::int64_t, 3> dims_of(const std::filesystem::path& file, const Header& header) {
  std::vector<std::int64_t> axes = header.shape;
  if (!header.fortran_order) std::reverse(axes.begin(), axes.end());
  if (axes.size() < 2)
    refuse(file, "NPY", fmt::format("it has {} axes; a volume has three, an image two", axes.size()));
  std::array<std::int64_t, 3> dims{1, 1, 1};
  const bool squeeze = axes.size() > 3;
  std::size_t used = 0;
  for (const std::int64_t length : axes) {
    if (squeeze && length == 1) continue;
    if (used == 3) refuse(file, "NPY", fmt::format("it has {} axes; a volume has three", axes.size()));
    dims[used++] = length;
  }
  return dims;
}

}  // namespace

Volume read_npy(const std::filesystem::path& file, Context* context) {
  InputFile in(file);
  std::array<unsigned char, 12> start{};
  in.stream.read(reinterpret_cast<char*>(start.data()), 8);
  if (!in.stream || std::memcmp(start.data(), "\x93NUMPY", 6) != 0)
    refuse(file, "NPY", "it does not begin with \\x93NUMPY");
  const int version = start[6];
  if (version < 1 || version > 3)
    refuse(file, "NPY", fmt::format("version {} is unknown; versions 1 to 3 can be read", version));
  const int length_bytes = version == 1 ? 2 : 4;
  in.stream.read(reinterpret_cast<char*>(start.data()) + 8, length_bytes);
  if (!in.stream) refuse(file, "NPY", "the header is incomplete");
  std::uint64_t length = 0;
  for (int b = length_bytes; b-- > 0;) length = length << 8 | start[static_cast<std::size_t>(8 + b)];
  const std::uint64_t data = 8 + static_cast<std::uint64_t>(length_bytes) + length;
  if (data > in.size) refuse(file, "NPY", fmt::format("the header claims {} bytes, the file has {}", length, in.size));
  std::string text(length, '\0');
  in.stream.read(text.data(), static_cast<std::streamsize>(length));
  if (!in.stream) refuse(file, "NPY", "the header is incomplete");
  const Header header = DictionaryParser(text, file).parse();

  if (header.descr.size() != 3 || !std::strchr("<>|=", header.descr[0]))
    refuse(file, "NPY", fmt::format("samples of type '{}' are not plain numbers", header.descr.substr(0, 40)));
  const bool swap = header.descr[0] == '>';
  const std::string type = header.descr.substr(1);
  Volume volume;
  volume.grid.dims = dims_of(file, header);
  if (header.shape.size() == 2) volume.grid.dimension = 2;
  const auto read = [&]<class T>(T) {
    const std::uint64_t count = checked_sample_count(file, volume.grid.dims, sizeof(T), in.size - data);
    check_read_memory(file, count * sizeof(T) * (type == "f2" ? 3 : 1), context);
    return read_samples<T>(in, file, count, swap, context);
  };
  if (type == "b1" || type == "u1")
    volume.samples = read(std::uint8_t{});
  else if (type == "i1")
    volume.samples = read(std::int8_t{});
  else if (type == "u2")
    volume.samples = read(std::uint16_t{});
  else if (type == "i2")
    volume.samples = read(std::int16_t{});
  else if (type == "u4")
    volume.samples = read(std::uint32_t{});
  else if (type == "i4")
    volume.samples = read(std::int32_t{});
  else if (type == "u8")
    volume.samples = read(std::uint64_t{});
  else if (type == "i8")
    volume.samples = read(std::int64_t{});
  else if (type == "f4")
    volume.samples = read(float{});
  else if (type == "f8")
    volume.samples = read(double{});
  else if (type == "f2") {
    const std::vector<std::uint16_t> halves = read(std::uint16_t{});
    std::vector<float> values(halves.size());
    std::transform(halves.begin(), halves.end(), values.begin(), from_half);
    volume.samples = std::move(values);
  } else {
    refuse(file, "NPY",
           fmt::format("samples of type '{}' are not supported; save as integers, float32 or float64", header.descr));
  }
  return volume;
}

}  // namespace quench::io
