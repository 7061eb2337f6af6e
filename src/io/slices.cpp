// SPDX-License-Identifier: Apache-2.0
// Volumes slice by slice. ITK reads the header; of NRRD, which it cannot read in parts, the samples are read here.
#ifdef QUENCH_HAS_ITK
#include "quench/slices.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <fstream>
#include <memory>
#include <vector>

#include "io/itk_header.h"
#include "io/volume_formats.h"
#include "quench/error.h"

namespace quench::io {
namespace {

[[noreturn]] void ends_early(const std::filesystem::path& file, std::int64_t slice, std::int64_t slices) {
  throw Error(ErrorCode::input, fmt::format("'{}' is damaged or incomplete: its data end in slice {} of {}",
                                            file.string(), slice + 1, slices));
}

// What the header of an NRRD file says about where and how its samples lie; nothing when that is not simple.
struct NrrdData {
  bool gzip = false, swapped = false;
  std::streamoff offset = 0;
};

std::optional<NrrdData> nrrd_data(const std::filesystem::path& file, std::size_t sample_size) {
  std::ifstream in(file, std::ios::binary);
  std::string line;
  if (!std::getline(in, line) || !line.starts_with("NRRD000")) return {};
  NrrdData data;
  bool encoded = false;
  for (int lines = 0; lines < 1000 && std::getline(in, line); ++lines) {
    if (line.empty()) {
      data.offset = in.tellg();
      if (!encoded) return {};
      return data;
    }
    std::transform(line.begin(), line.end(), line.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    const auto value = [&] {
      const auto at = line.find_first_not_of(' ', line.find(':') + 1);
      return at == std::string::npos ? std::string() : line.substr(at);
    };
    if (line.back() == '\r' || line.starts_with("data file") || line.starts_with("datafile") ||
        line.starts_with("byte skip") || line.starts_with("byteskip") || line.starts_with("line skip") ||
        line.starts_with("lineskip"))
      return {};
    if (line.starts_with("dimension:") && value() != "3") return {};
    if (line.starts_with("endian:")) {
      if (value() != "little" && value() != "big") return {};
      data.swapped = sample_size > 1 && (value() == "little") != (std::endian::native == std::endian::little);
    }
    if (line.starts_with("encoding:")) {
      data.gzip = value() == "gzip" || value() == "gz";
      encoded = data.gzip || value() == "raw";
      if (!encoded) return {};
    }
  }
  return {};
}

class NrrdSlices {
 public:
  NrrdSlices(std::filesystem::path file, const NrrdData& data, std::size_t sample_size, std::int64_t slices)
      : file_(std::move(file)), data_(data), sample_size_(sample_size), slices_(slices) {
    in_.open(file_, std::ios::binary);
    in_.seekg(data.offset);
    constexpr int gzip_or_zlib = 15 + 32;
    if (data_.gzip && inflateInit2(&z_, gzip_or_zlib) != Z_OK)
      throw Error(ErrorCode::failed, "zlib cannot be started: out of memory");
  }
  NrrdSlices(const NrrdSlices&) = delete;
  NrrdSlices& operator=(const NrrdSlices&) = delete;
  ~NrrdSlices() {
    if (data_.gzip) inflateEnd(&z_);
  }

  void next(std::span<std::byte> slice) {
    for (std::size_t done = 0; done < slice.size();) {
      constexpr std::size_t piece = std::size_t{1} << 30;  // what one call can be asked for
      const auto part = slice.subspan(done, std::min(slice.size() - done, piece));
      data_.gzip ? inflate_into(part) : read_into(part);
      done += part.size();
    }
    if (data_.swapped)
      for (std::size_t i = 0; i + sample_size_ <= slice.size(); i += sample_size_)
        std::reverse(slice.begin() + static_cast<std::ptrdiff_t>(i),
                     slice.begin() + static_cast<std::ptrdiff_t>(i + sample_size_));
    ++slice_;
  }

 private:
  void read_into(std::span<std::byte> part) {
    if (!in_.read(reinterpret_cast<char*>(part.data()), static_cast<std::streamsize>(part.size())))
      ends_early(file_, slice_, slices_);
  }
  void inflate_into(std::span<std::byte> part) {
    z_.next_out = reinterpret_cast<Bytef*>(part.data());
    z_.avail_out = static_cast<uInt>(part.size());
    while (z_.avail_out > 0) {
      if (z_.avail_in == 0) {
        in_.read(reinterpret_cast<char*>(buffer_.data()), static_cast<std::streamsize>(buffer_.size()));
        z_.next_in = buffer_.data();
        z_.avail_in = static_cast<uInt>(in_.gcount());
        if (z_.avail_in == 0) ends_early(file_, slice_, slices_);
      }
      const int result = inflate(&z_, Z_NO_FLUSH);
      if (result == Z_STREAM_END && z_.avail_out > 0) {  // another member may follow
        if (inflateReset(&z_) != Z_OK) ends_early(file_, slice_, slices_);
      } else if (result != Z_OK && result != Z_STREAM_END && result != Z_BUF_ERROR) {
        ends_early(file_, slice_, slices_);
      }
    }
  }

  std::filesystem::path file_;
  NrrdData data_;
  std::size_t sample_size_;
  std::int64_t slices_, slice_ = 0;
  std::ifstream in_;
  z_stream z_{};
  std::vector<Bytef> buffer_ = std::vector<Bytef>(1 << 18);
};

}  // namespace

std::optional<SliceStream> open_slices(const std::filesystem::path& file, const VolumeReadOptions& options,
                                       Context* context) {
  const std::string extension = volume_extension(file);
  if (extension != ".nrrd" && extension != ".mha" && extension != ".mrc" && extension != ".map") return {};
  std::error_code error;
  if (std::filesystem::is_directory(file, error)) return {};
  const InputFile probe(file);
  if (probe.size == 0) return {};  // read_volume() says so
  SliceStream stream;
  const std::optional<ItkHeader> header = itk_header(file, context);
  if (!header) return {};
  stream.grid = header->grid;
  stream.type = header->type;
  apply_spacing(file, options, stream.grid);
  const auto& dims = stream.grid.dims;
  const std::uint64_t slice = static_cast<std::uint64_t>(dims[0]) * static_cast<std::uint64_t>(dims[1]);
  if (extension == ".nrrd") {
    const auto data = nrrd_data(file, header->sample_size);
    if (!data) return {};
    checked_sample_count(file, dims, header->sample_size, data->gzip ? probe.size * deflate_limit : probe.size);
    check_read_memory(file, slice * header->sample_size, context);
    const auto slices = std::make_shared<NrrdSlices>(file, *data, header->sample_size, dims[2]);
    stream.next = [slices](std::span<std::byte> out) { slices->next(out); };
    return stream;
  }
  if (!header->next_slice) return {};
  // Only an uncompressed file is as long as its samples.
  if (dims[2] < 1 || probe.size / header->sample_size / static_cast<std::uint64_t>(dims[2]) < slice) return {};
  checked_sample_count(file, dims, header->sample_size, probe.size);
  check_read_memory(file, slice * header->sample_size, context);
  stream.next = header->next_slice;
  return stream;
}

}  // namespace quench::io
#endif
