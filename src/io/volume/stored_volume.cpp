// SPDX-License-Identifier: Apache-2.0
#include "io/volume/stored_volume.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <istream>
#include <limits>
#include <memory>

#include "base/text.h"
#include "io/common/formats.h"
#include "io/common/words.h"
#include "io/volume/data_files.h"
#include "io/volume/float16.h"
#include "io/volume/sample_source.h"
#include "io/volume/scaled_values.h"
#include "io/volume/slice_streams.h"
#include "io/volume/volume_formats.h"
#include "quench/error.h"
#include "shape/sample_type.h"

namespace quench::io {
namespace {

/// What the samples become: halves a float; scaled ones a float where it tells all stored values apart, else a double.
SampleType type_in_memory(const StoredVolume& volume) {
  if (!volume.scaled()) return volume.type.half ? SampleType::float32 : volume.type.type;
  const bool real = volume.type.half || volume.type.type == SampleType::float32;
  if (real) return volume.intercept == 0 ? SampleType::float32 : SampleType::float64;
  const bool fine = volume.type.size() <= 2 && fits_float32(volume.slope, volume.intercept);
  return fine ? SampleType::float32 : SampleType::float64;
}

/// Bytes of a block in its file.
std::uint64_t size_of_block(const SampleBlock& block) {
  const std::uint64_t all = size_of_file(block.file);
  const std::uint64_t there = all > block.begin ? all - block.begin : 0;
  return block.size ? std::min(*block.size, there) : there;
}

/// The fewest bytes in a file that can become `bytes` of `samples` samples.
std::uint64_t least_bytes(Encoding encoding, std::uint64_t samples, std::uint64_t bytes) {
  switch (encoding) {
    case Encoding::raw:
      return bytes;
    case Encoding::deflate:
      return bytes / kDeflateLimit + 1;
    case Encoding::text:
      return 2 * samples - 1;
    case Encoding::hex:
      return 2 * bytes;
  }
  return bytes;
}

/// The samples of each block. Throws Error(input) where the files cannot hold them.
std::uint64_t checked_share(const std::filesystem::path& file, const StoredVolume& volume, Context* context) {
  const auto& dims = volume.grid.dims;
  const std::uint64_t count = checked_sample_count(file, dims, volume.type.size(), std::uint64_t{1} << 62);
  const std::uint64_t blocks = volume.blocks.size();
  if (blocks == 0 || count % blocks != 0)
    refuse_volume(file,
                  fmt::format("it names {} files for {} x {} x {} samples, which cannot be divided equally among them",
                              blocks, dims[0], dims[1], dims[2]));
  const std::uint64_t share = count / blocks;
  std::uint64_t unread = 0;
  for (const SampleBlock& block : volume.blocks) {
    const std::uint64_t there = size_of_block(block);
    const std::uint64_t needed = least_bytes(volume.encoding, share, share * volume.type.size());
    std::error_code error;
    if (block.file != file) {
      if (!std::filesystem::exists(block.file, error))
        refuse_volume(file,
                      fmt::format("its samples are in '{}', which does not exist; put it there{}",
                                  base::plain(block.file.string()),
                                  block.file.string().find('%') == std::string::npos
                                      ? ""
                                      : " (a pattern with a number, such as s%03d.raw 1 9 1, has no other blanks)"));
      if (!std::filesystem::is_regular_file(block.file, error))
        refuse_volume(file, fmt::format("its samples are in '{}', which is not a regular file",
                                        base::plain(block.file.string())));
      if (there < needed)
        refuse_volume(file,
                      fmt::format("its samples are in '{}', which has {} bytes for them where {} are needed; it is "
                                  "damaged or incomplete, or the header is wrong",
                                  base::plain(block.file.string()), there, needed));
    }
    if (there < needed) checked_sample_count(file, dims, volume.type.size(), there);
    if (there < needed) refuse_volume(file, "it is too short for its samples; it is damaged or incomplete");
    if (volume.encoding == Encoding::raw && !block.size) unread += there - needed;
  }
  if (unread > 0)
    note(context, fmt::format("'{}' has {} bytes after its samples, which are not read; check the sizes in its header",
                              file.string(), unread));
  return share;
}

/// The samples of all blocks as one stream.
class StoredSamples {
 public:
  StoredSamples(std::filesystem::path file, StoredVolume volume, std::uint64_t share)
      : file_(std::move(file)), volume_(std::move(volume)), share_(share * volume_.type.size()) {
    for (std::size_t a = 0; a < 3; ++a) stored_[a] = volume_.grid.dims[static_cast<std::size_t>(volume_.axes[a])];
  }

  /// The next stored slice as values.
  void next(std::span<std::byte> out) {
    const std::size_t size = volume_.type.size(), count = static_cast<std::size_t>(stored_[0] * stored_[1]);
    const bool in_place = !volume_.type.half && !volume_.scaled();
    buffer_.resize(in_place ? 0 : count * size);
    const std::span<std::byte> samples = in_place ? out : std::span(buffer_);
    read(samples);
    if (volume_.swapped && size > 1)
      for (std::size_t i = 0; i < count; ++i) std::reverse(samples.data() + i * size, samples.data() + (i + 1) * size);
    if (!in_place) convert(samples, out, count);
    ++slice_;
  }

  /// All samples in the order of the grid's axes: what next() gives, sorted.
  std::vector<std::byte> sorted(std::size_t value_size) {
    const auto& dims = volume_.grid.dims;
    std::array<std::size_t, 3> step{};  // of the grid's axes, by stored axis
    for (std::size_t a = 0; a < 3; ++a) {
      const int axis = volume_.axes[a];
      step[a] = axis == 0 ? 1 : static_cast<std::size_t>(axis == 1 ? dims[0] : dims[0] * dims[1]);
    }
    std::vector<std::byte> all(static_cast<std::size_t>(dims[0] * dims[1] * dims[2]) * value_size);
    std::vector<std::byte> slice(static_cast<std::size_t>(stored_[0] * stored_[1]) * value_size);
    const auto steps = [](std::int64_t n) { return static_cast<std::size_t>(n); };
    for (std::size_t k = 0; k < steps(stored_[2]); ++k) {
      next(slice);
      const std::byte* from = slice.data();
      for (std::size_t j = 0; j < steps(stored_[1]); ++j)
        for (std::size_t i = 0; i < steps(stored_[0]); ++i, from += value_size)
          std::memcpy(all.data() + (i * step[0] + j * step[1] + k * step[2]) * value_size, from, value_size);
    }
    return all;
  }

 private:
  void read(std::span<std::byte> out) {
    while (!out.empty()) {
      if (left_ == 0) {
        source_ = open_block(volume_.blocks.at(block_++), volume_.encoding, volume_.type.type);
        left_ = share_;
      }
      const auto part = out.first(static_cast<std::size_t>(std::min<std::uint64_t>(out.size(), left_)));
      if (!source_->read(part)) {
        if (source_->damaged()) refuse_damaged();
        slices_end_early(file_, slice_, stored_[2]);
      }
      left_ -= part.size();
      if (left_ == 0 && !source_->ends_well()) refuse_damaged();
      out = out.subspan(part.size());
    }
  }

  [[noreturn]] void refuse_damaged() const {
    const std::filesystem::path& file = volume_.blocks[block_ - 1].file;
    refuse_volume(file_, fmt::format("its compressed samples{} are damaged or incomplete (their checksum is "
                                     "wrong); copy or download it again",
                                     file == file_ ? "" : fmt::format(", in '{}',", base::plain(file.string()))));
  }

  void convert(std::span<const std::byte> samples, std::span<std::byte> out, std::size_t count) const {
    if (volume_.type.half) return scale<std::uint16_t>(samples, out, count, [](auto h) { return from_half(h); });
    shape::with_sample_type(volume_.type.type,
                            [&]<class T>(T) { scale<T>(samples, out, count, [](T value) { return value; }); });
  }
  template <class T, class Value>
  void scale(std::span<const std::byte> samples, std::span<std::byte> out, std::size_t count, Value value) const {
    const bool as_float = type_in_memory(volume_) == SampleType::float32;
    for (std::size_t i = 0; i < count; ++i) {
      T sample;
      std::memcpy(&sample, samples.data() + i * sizeof(T), sizeof(T));
      const double scaled = volume_.slope * static_cast<double>(value(sample)) + volume_.intercept;
      const float single = std::isfinite(scaled) ? to_float(scaled) : static_cast<float>(scaled);
      if (as_float)
        std::memcpy(out.data() + i * sizeof single, &single, sizeof single);
      else
        std::memcpy(out.data() + i * sizeof scaled, &scaled, sizeof scaled);
    }
  }

  std::filesystem::path file_;
  StoredVolume volume_;
  std::uint64_t share_;  ///< bytes of samples in a block
  std::array<std::int64_t, 3> stored_{};
  std::unique_ptr<SampleSource> source_;
  std::uint64_t left_ = 0;  ///< of the block that is open
  std::size_t block_ = 0;
  std::int64_t slice_ = 0;
  std::vector<std::byte> buffer_;
};

}  // namespace

std::size_t StoredType::size() const { return half ? 2 : shape::size_of(type); }

SliceStream open_stored(const std::filesystem::path& file, const StoredVolume& volume, Context* context) {
  const std::uint64_t share = checked_share(file, volume, context);
  SliceStream stream;
  stream.grid = volume.grid;
  stream.type = type_in_memory(volume);
  stream.spacing_source = volume.spacing_source;
  stream.coordinates = volume.coordinates;
  const auto& dims = volume.grid.dims;
  const std::size_t value_size = shape::size_of(stream.type);
  const auto slice = static_cast<std::uint64_t>(dims[0]) * static_cast<std::uint64_t>(dims[1]);
  const auto samples = std::make_shared<StoredSamples>(file, volume, share);
  if (volume.axes == std::array{0, 1, 2}) {
    check_read_memory(file, slice * (value_size + volume.type.size()), context);
    stream.next = [samples](std::span<std::byte> out) { samples->next(out); };
    return stream;
  }
  // All of it here, and again where the caller keeps all slices.
  check_read_memory(file, slice * static_cast<std::uint64_t>(dims[2]) * value_size * 2, context);
  stream.next = [samples, value_size, all = std::vector<std::byte>(),
                 at = std::size_t{0}](std::span<std::byte> out) mutable {
    if (at == 0) all = samples->sorted(value_size);
    std::memcpy(out.data(), all.data() + at, out.size());
    at += out.size();
    if (at == all.size()) all = {};
  };
  return stream;
}

bool is_stored_volume(std::string_view extension) {
  constexpr std::array kKnown{".nrrd", ".nhdr", ".mha", ".mhd", ".nii", ".nii.gz", ".mrc", ".map"};
  return std::find(kKnown.begin(), kKnown.end(), extension) != kKnown.end();
}

SliceStream open_stored(const std::filesystem::path& file, Context* context) {
  const std::string extension = volume_extension(file);
  const auto header = [&] {
    if (extension == ".nrrd" || extension == ".nhdr") return nrrd_header(file);
    if (extension == ".mha" || extension == ".mhd") return meta_header(file, context);
    if (extension == ".mrc" || extension == ".map") return mrc_header(file);
    return nifti_header(file, context);
  };
  return open_stored(file, header(), context);
}

void refuse_volume(const std::filesystem::path& file, const std::string& why) {
  throw Error(ErrorCode::input, fmt::format("'{}' cannot be read: {}", file.string(), why));
}

void set_steps(const std::filesystem::path& file, const Mat3& steps, std::string_view where, Grid& grid) {
  // What integer_spacing() can take: squares of lengths are needed in double precision.
  constexpr double kShortest = 1e-30, kLongest = 1e30;
  for (int a = 0; a < 3; ++a) {
    const Vec3 step = steps.col(a);
    const double length = step.allFinite() ? step.stableNorm() : 0;
    if (!(length >= kShortest && length <= kLongest))
      refuse_volume(
          file, fmt::format("its step between voxels along axis {} is ({:.6g}, {:.6g}, {:.6g}), whose length is not "
                            "from {:g} to {:g}; correct the {} in its header, or save the volume again",
                            a, step[0], step[1], step[2], kShortest, kLongest, where));
    grid.spacing[a] = length;
    grid.direction.col(a) = step / length + Vec3::Zero();  // 0 for -0
  }
  const double shear = (grid.direction.transpose() * grid.direction - Mat3::Identity()).cwiseAbs().maxCoeff();
  if (!(shear <= kShearTolerance))
    refuse_volume(file,
                  fmt::format("its axes are not perpendicular (a sheared grid, by the {} in its header); resample "
                              "it to a rectangular grid",
                              where));
  if (shear > 1e-15) {  // rounded by the format: take the nearest orthonormal matrix
    const Eigen::JacobiSVD<Mat3> svd(grid.direction, Eigen::ComputeFullU | Eigen::ComputeFullV);
    grid.direction = svd.matrixU() * svd.matrixV().transpose();
  }
}

bool next_header_line(std::istream& in, const std::filesystem::path& file, std::string& line) {
  constexpr std::size_t kLongest = std::size_t{1} << 20;
  line.clear();
  for (int c = in.get(); c != std::istream::traits_type::eof(); c = in.get()) {
    if (c == '\n') {
      if (!line.empty() && line.back() == '\r') line.pop_back();
      return true;
    }
    line.push_back(static_cast<char>(c));
    if (line.size() > kLongest)
      refuse_volume(file, "a line of its header is longer than a megabyte; it is not a header");
  }
  return !line.empty();
}

double decimal(float value) {
  char text[32];
  const auto [end, error] = std::to_chars(text, text + sizeof text, value);
  double result = static_cast<double>(value);
  if (std::isfinite(value)) std::from_chars(text, end, result);
  return result;
}

std::string lower(std::string_view text) {
  std::string result(trimmed(text));
  for (char& c : result)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return result;
}

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r\n\v\f";
  const auto begin = text.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlanks) + 1 - begin);
}

std::vector<std::string_view> words_of(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r\n\v\f";
  std::vector<std::string_view> words;
  for (std::size_t at = text.find_first_not_of(kBlanks); at != std::string_view::npos;) {
    const std::size_t end = std::min(text.find_first_of(kBlanks, at), text.size());
    words.push_back(text.substr(at, end - at));
    at = text.find_first_not_of(kBlanks, end);
  }
  return words;
}

}  // namespace quench::io
