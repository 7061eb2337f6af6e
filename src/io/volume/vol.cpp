// SPDX-License-Identifier: Apache-2.0
// DGtal's .vol and .longvol: "key: value" lines, a line with a dot, then samples, x fastest.
#include <fmt/format.h>
#include <zlib.h>

#include <charconv>
#include <map>

#include "base/text.h"
#include "io/common/words.h"
#include "io/volume/volume_formats.h"
#include "quench/error.h"

namespace quench::io {
namespace {

constexpr int kLongestHeader = 1000;  // lines
constexpr std::uint64_t kBlock = 1 << 20;

std::string trimmed(const std::string& text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

using Fields = std::map<std::string, std::string>;

Fields read_header(InputFile& in, const std::filesystem::path& file) {
  Fields fields;
  std::string line;
  for (int number = 1;; ++number) {
    line.clear();
    for (int c; (c = in.stream.get()) != '\n';) {
      if (c == std::char_traits<char>::eof())
        refuse(file, ".vol", "the header does not end with a line that is one dot");
      line.push_back(static_cast<char>(c));
      if (line.size() > 4096) refuse(file, ".vol", fmt::format("line {} of the header is too long", number));
    }
    line = trimmed(line);
    if (line == ".") return fields;
    if (number > kLongestHeader) refuse(file, ".vol", "the header does not end with a line that is one dot");
    const auto colon = line.find(':');
    if (line.empty() || line[0] == '#') continue;
    if (colon == std::string::npos)
      refuse(file, ".vol", fmt::format("line {} of the header is not 'key: value'", number));
    fields[trimmed(line.substr(0, colon))] = trimmed(line.substr(colon + 1));
  }
}

std::int64_t number_of(const Fields& fields, const std::filesystem::path& file, const std::string& key,
                       std::int64_t otherwise) {
  const auto it = fields.find(key);
  if (it == fields.end()) {
    if (otherwise < 0) refuse(file, ".vol", fmt::format("the header lacks {}", key));
    return otherwise;
  }
  std::int64_t value = 0;
  const char* end = it->second.data() + it->second.size();
  const auto [stop, error] = std::from_chars(it->second.data(), end, value);
  if (error != std::errc() || stop != end)
    refuse(file, ".vol", fmt::format("{} is '{}', not a whole number", key, it->second.substr(0, 40)));
  return value;
}

// Inflates the rest of the file into exactly `size` bytes.
void inflate_into(InputFile& in, const std::filesystem::path& file, unsigned char* out, std::uint64_t size,
                  Context* context) {
  struct Stream : z_stream {
    Stream() : z_stream() {}
    Stream(const Stream&) = delete;
    Stream& operator=(const Stream&) = delete;
    ~Stream() { inflateEnd(this); }
  } z;
  if (inflateInit(&z) != Z_OK) throw Error(ErrorCode::failed, "zlib cannot be started: out of memory");
  std::vector<char> input(kBlock);
  std::uint64_t done = 0;
  for (bool ended = false; !ended && done < size;) {
    checkpoint(context, "read", static_cast<double>(done) / static_cast<double>(size));
    in.stream.read(input.data(), static_cast<std::streamsize>(input.size()));
    const auto got = in.stream.gcount();
    if (got <= 0)
      refuse(file, ".vol",
             fmt::format("the compressed samples end after {} of {} bytes: the file is incomplete; copy it again", done,
                         size));
    z.next_in = reinterpret_cast<unsigned char*>(input.data());
    z.avail_in = static_cast<unsigned>(got);
    while (z.avail_in > 0 && done < size && !ended) {
      const std::uint64_t room = std::min(size - done, std::uint64_t{1} << 30);
      z.next_out = out + done;
      z.avail_out = static_cast<unsigned>(room);
      const int result = inflate(&z, Z_NO_FLUSH);
      done += room - z.avail_out;
      if (result == Z_STREAM_END)
        ended = true;
      else if (result != Z_OK && result != Z_BUF_ERROR)
        refuse(file, ".vol",
               fmt::format("the compressed samples are damaged after {} of {} bytes; copy the file again", done, size));
    }
  }
  if (done < size)
    refuse(file, ".vol",
           fmt::format("the compressed samples end after {} of {} bytes: the file is incomplete; copy it again", done,
                       size));
  checkpoint(context, "read", 1);
}

}  // namespace

Volume read_vol(const std::filesystem::path& file, Context* context) {
  InputFile in(file);
  const Fields fields = read_header(in, file);
  Volume volume;
  volume.grid.dims = {number_of(fields, file, "X", -1), number_of(fields, file, "Y", -1),
                      number_of(fields, file, "Z", -1)};
  const std::int64_t bytes = number_of(fields, file, "Voxel-Size", 1);
  const std::int64_t version = number_of(fields, file, "Version", 2);
  if (version < 1 || version > 3) refuse(file, ".vol", fmt::format("version {} is not known (2 and 3 are)", version));
  const bool compressed = version == 3;
  // The field lists byte positions, least significant first in "0123"; "0" is a single byte or no statement.
  const auto order = fields.find("Voxel-Endian");
  const bool big = order != fields.end() && !order->second.empty() && order->second[0] != '0';

  const std::uint64_t left = in.size - std::min(in.size, static_cast<std::uint64_t>(in.stream.tellg()));
  const auto read = [&]<class T>(T) {
    const std::uint64_t count =
        checked_sample_count(file, volume.grid.dims, sizeof(T), compressed ? left * kDeflateLimit : left);
    check_read_memory(file, count * sizeof(T), context);
    std::vector<T> samples(count);
    auto* out = reinterpret_cast<unsigned char*>(samples.data());
    if (compressed) {
      inflate_into(in, file, out, count * sizeof(T), context);
    } else {
      in.stream.read(reinterpret_cast<char*>(out), static_cast<std::streamsize>(count * sizeof(T)));
      if (!in.stream) refuse(file, ".vol", "the samples end too early");
    }
    if (big && sizeof(T) > 1) swap_bytes(samples);
    return samples;
  };
  if (bytes == 1)
    volume.samples = read(std::uint8_t{});
  else if (bytes == 2)
    volume.samples = read(std::uint16_t{});
  else if (bytes == 4)
    volume.samples = read(std::uint32_t{});
  else if (bytes == 8)
    volume.samples = read(std::uint64_t{});
  else
    refuse(file, ".vol", fmt::format("Voxel-Size {} is not 1, 2, 4 or 8", bytes));
  return volume;
}

}  // namespace quench::io
