// SPDX-License-Identifier: Apache-2.0
// Volumes of single-precision numbers, slice by slice: NRRD, NIfTI-1, TIFF and NPY.
#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cctype>
#include <cmath>
#include <cstring>
#include <ostream>
#include <vector>

#include "base/deflated.h"
#include "base/parallel.h"
#include "base/text.h"
#include "io/common/words.h"
#include "io/volume/nrrd_lines.h"
#include "quench/error.h"
#include "quench/io.h"

namespace quench::io {
namespace {

static_assert(std::endian::native == std::endian::little, "samples are written as they are in memory");

using Slice = std::span<const float>;

std::string_view bytes_of(Slice slice) { return {reinterpret_cast<const char*>(slice.data()), slice.size_bytes()}; }

template <class T>
void put(std::ostream& out, const T& value) {
  out.write(reinterpret_cast<const char*>(&value), sizeof value);
}

// One gzip stream, of which a few megabytes at a time are compressed on all threads.
class GzipParts {
 public:
  explicit GzipParts(std::ostream& out) : out_(out) { out_.write("\x1f\x8b\x08\0\0\0\0\0\0\xff", 10); }

  void write(std::string_view bytes) {
    waiting_.append(bytes);
    if (waiting_.size() >= kParts * kPart) flush(false);
  }
  void finish() {
    flush(true);
    put(out_, static_cast<std::uint32_t>(sum_));
    put(out_, static_cast<std::uint32_t>(size_));
  }

 private:
  static constexpr std::size_t kPart = 1 << 20, kParts = 16;

  void flush(bool last) {
    const std::size_t parts = std::max<std::size_t>((waiting_.size() + kPart - 1) / kPart, 1);
    struct Part {
      std::optional<std::string> packed;
      uLong sum = 0;
      std::string_view bytes;
    };
    std::vector<Part> done(parts);
    tbb::parallel_for(std::size_t{0}, parts, [&](std::size_t p) {
      Part& part = done[p];
      part.bytes = std::string_view(waiting_).substr(std::min(p * kPart, waiting_.size()), kPart);
      part.sum = crc32(0, reinterpret_cast<const Bytef*>(part.bytes.data()), static_cast<uInt>(part.bytes.size()));
      part.packed = base::deflated(part.bytes, 3, Z_DEFAULT_STRATEGY, last && p + 1 == parts);
    });
    for (const Part& part : done) {
      if (!part.packed) throw Error(ErrorCode::failed, "zlib cannot work: out of memory");
      out_.write(part.packed->data(), static_cast<std::streamsize>(part.packed->size()));
      sum_ = crc32_combine(sum_, part.sum, static_cast<z_off_t>(part.bytes.size()));
      size_ += part.bytes.size();
    }
    waiting_.clear();
  }

  std::ostream& out_;
  std::string waiting_;
  uLong sum_ = 0;
  std::uint64_t size_ = 0;
};

void write_plain(std::ostream& out, const VolumeSlices& slices) {
  slices([&](Slice slice) { out.write(bytes_of(slice).data(), static_cast<std::streamsize>(slice.size_bytes())); });
}

void write_packed(std::ostream& out, std::string_view header, const VolumeSlices& slices) {
  GzipParts gzip(out);
  if (!header.empty()) gzip.write(header);
  slices([&](Slice slice) { gzip.write(bytes_of(slice)); });
  gzip.finish();
}

// NIfTI-1 (nifti.nimh.nih.gov/nifti-1), one file: world coordinates are right-anterior-superior, ours the other way
// round in x and y.
std::string nifti_header(const Grid& grid, const Coordinates& coordinates) {
  std::string h(352, '\0');
  const auto set = [&](std::size_t at, const auto& value) { std::memcpy(h.data() + at, &value, sizeof value); };
  set(0, std::int32_t{348});
  set(40, static_cast<std::int16_t>(grid.dimension));
  for (std::size_t a = 0; a < 7; ++a) set(42 + 2 * a, static_cast<std::int16_t>(a < 3 ? grid.dims[a] : 1));
  set(70, std::int16_t{16});  // float32
  set(72, std::int16_t{32});
  const Mat3 steps = grid.direction * grid.spacing.asDiagonal();
  set(76, 1.0f);
  for (std::size_t a = 0; a < 3; ++a) set(80 + 4 * a, static_cast<float>(grid.spacing[static_cast<Eigen::Index>(a)]));
  set(108, 352.0f);
  set(112, 1.0f);
  const std::string& unit = coordinates.units;
  h[123] = static_cast<char>(unit == "m" ? 1 : unit == "mm" ? 2 : unit == "um" || unit == "µm" ? 3 : 0);
  const std::string text = "local thickness";
  std::memcpy(h.data() + 148, text.data(), text.size());
  set(254, std::int16_t{1});  // the sform is the place in the scanner
  for (std::size_t row = 0; row < 3; ++row) {
    const double sign = row < 2 ? -1 : 1;
    const auto r = static_cast<Eigen::Index>(row);
    for (std::size_t a = 0; a < 3; ++a)
      set(280 + 16 * row + 4 * a, static_cast<float>(sign * steps(r, static_cast<Eigen::Index>(a))));
    set(280 + 16 * row + 12, static_cast<float>(sign * grid.origin[r]));
  }
  std::memcpy(h.data() + 344, "n+1", 4);
  return h;
}

// NPY of version 1.0: x is the first axis of three, the second of two.
std::string npy_header(const Grid& grid) {
  const std::string shape = grid.is_plane() ? fmt::format("({}, {})", grid.dims[1], grid.dims[0])
                                            : fmt::format("({}, {}, {})", grid.dims[0], grid.dims[1], grid.dims[2]);
  std::string text =
      fmt::format("{{'descr': '<f4', 'fortran_order': {}, 'shape': {}, }}", grid.is_plane() ? "False" : "True", shape);
  text.append(63 - (10 + text.size()) % 64, ' ');
  text += '\n';
  const auto size = static_cast<std::uint16_t>(text.size());
  return std::string("\x93NUMPY\x01\0", 8) + static_cast<char>(size & 255) + static_cast<char>(size >> 8) + text;
}

// TIFF (Adobe 1992; BigTIFF above 4 GB): the samples of all slices without a gap, then a directory for each. ImageJ
// reads the first directory only, and takes so many slices from behind one another as its description says.
class TiffWriter {
 public:
  TiffWriter(std::ostream& out, const Grid& grid, const Coordinates& coordinates) : out_(out), grid_(grid) {
    description_ = fmt::format("ImageJ=1.54f\nimages={0}\nslices={0}\nunit={1}\nspacing={2}\nloop=false\n",
                               grid.dims[2], coordinates.units.empty() ? "pixel" : coordinates.units, grid.spacing[2]);
    description_.push_back('\0');
    samples_ = static_cast<std::uint64_t>(grid.dims[0] * grid.dims[1]) * sizeof(float);
    const std::uint64_t all = static_cast<std::uint64_t>(grid.dims[2]) * (samples_ + 1024 + description_.size());
    big_ = all > 0xFFFFFFF0u;
    out_ << "II";
    if (big_) {
      put(out_, std::uint16_t{43});
      put(out_, std::uint16_t{8});
      put(out_, std::uint16_t{0});
      start_ = 16;
    } else {
      put(out_, std::uint16_t{42});
      start_ = 8;
    }
    put_offset(start_ + padded(samples_ * slices()));
  }

  void write(Slice slice) { out_.write(bytes_of(slice).data(), static_cast<std::streamsize>(samples_)); }

  void finish() {
    const std::uint64_t all = samples_ * slices();
    out_.write("\0\0\0\0\0\0\0\0", static_cast<std::streamsize>(padded(all) - all));
    std::uint64_t at = start_ + padded(all);
    for (std::uint64_t slice = 0; slice < slices(); ++slice)
      at = directory(at, start_ + slice * samples_, slice + 1 == slices());
  }

 private:
  // Writes the directory of the slice with these samples; where the next one begins.
  std::uint64_t directory(std::uint64_t at, std::uint64_t samples_at, bool last) {
    const std::uint64_t width = static_cast<std::uint64_t>(grid_.dims[0]),
                        height = static_cast<std::uint64_t>(grid_.dims[1]);
    std::vector<Entry> entries = {{256, 4, 1, width, {}},      {257, 4, 1, height, {}},  {258, 3, 1, 32, {}},
                                  {259, 3, 1, 1, {}},          {262, 3, 1, 1, {}},       {270, 2, 0, 0, description_},
                                  {273, 0, 1, samples_at, {}}, {277, 3, 1, 1, {}},       {278, 4, 1, height, {}},
                                  {279, 0, 1, samples_, {}},   {282, 5, 1, 0, ratio(0)}, {283, 5, 1, 0, ratio(1)},
                                  {296, 3, 1, 1, {}},          {339, 3, 1, 3, {}}};
    const std::uint64_t inline_size = big_ ? 8 : 4;
    const std::uint64_t size = (big_ ? 8 : 2) + entries.size() * (big_ ? 20 : 12) + inline_size;
    std::uint64_t beyond = at + padded(size);  // where values that do not fit lie
    if (big_)
      put(out_, static_cast<std::uint64_t>(entries.size()));
    else
      put(out_, static_cast<std::uint16_t>(entries.size()));
    std::string values;
    for (Entry& e : entries) {
      put(out_, e.tag);
      put(out_, static_cast<std::uint16_t>(e.type != 0 ? e.type : big_ ? 16 : 4));
      put_offset(e.type == 2 ? e.bytes.size() : 1);
      if (e.bytes.size() > inline_size) {
        put_offset(beyond + values.size());
        values += e.bytes;
        values.resize(padded(values.size()), '\0');
      } else if (!e.bytes.empty()) {
        e.bytes.resize(inline_size, '\0');
        out_.write(e.bytes.data(), static_cast<std::streamsize>(inline_size));
      } else {
        put_offset(e.value);  // little-endian: a short fills the first bytes
      }
    }
    const std::uint64_t next = beyond + values.size();
    put_offset(last ? 0 : next);
    out_.write("\0\0\0\0\0\0\0\0", static_cast<std::streamsize>(padded(size) - size));
    out_.write(values.data(), static_cast<std::streamsize>(values.size()));
    return next;
  }

  struct Entry {
    std::uint16_t tag, type;  // type 0: an offset
    std::uint64_t count, value;
    std::string bytes;
  };
  std::uint64_t slices() const { return static_cast<std::uint64_t>(grid_.dims[2]); }
  static std::uint64_t padded(std::uint64_t size) { return (size + 7) / 8 * 8; }
  void put_offset(std::uint64_t value) {
    if (big_)
      put(out_, value);
    else
      put(out_, static_cast<std::uint32_t>(value));
  }
  // Pixels per unit of length, as ImageJ has it.
  std::string ratio(Eigen::Index axis) const {
    double size = grid_.spacing[axis];
    std::uint32_t above = 1000000;
    while (above > 1 && above / size > 4e9) above /= 10;
    while (above < 1000000000 && above / size < 1e8) above *= 10;  // as many digits as there are
    const auto pixels = static_cast<std::uint32_t>(std::clamp(std::round(above / size), 1.0, 4294967295.0));
    std::string bytes(8, '\0');
    std::memcpy(bytes.data(), &pixels, 4);
    std::memcpy(bytes.data() + 4, &above, 4);
    return bytes;
  }

  std::ostream& out_;
  const Grid& grid_;
  std::string description_;
  std::uint64_t samples_ = 0, start_ = 0;
  bool big_ = false;
};

enum class ValueFormat { nrrd, nifti, nifti_packed, tiff, npy, none };

ValueFormat value_format_of(const std::filesystem::path& file) {
  std::string name = file.filename().string();
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (name.ends_with(".nrrd")) return ValueFormat::nrrd;
  if (name.ends_with(".nii")) return ValueFormat::nifti;
  if (name.ends_with(".nii.gz")) return ValueFormat::nifti_packed;
  if (name.ends_with(".tif") || name.ends_with(".tiff")) return ValueFormat::tiff;
  if (name.ends_with(".npy")) return ValueFormat::npy;
  return ValueFormat::none;
}

}  // namespace

void check_value_format(const std::filesystem::path& file) {
  if (value_format_of(file) == ValueFormat::none)
    throw Error(ErrorCode::usage,
                fmt::format("cannot write '{}': volumes of numbers are written as .nrrd, .nii, .nii.gz, .tif or .npy",
                            file.string()));
}

void write_values(const std::filesystem::path& file, const Grid& grid, const VolumeSlices& slices,
                  const Coordinates& coordinates, Context* context) {
  check_value_format(file);
  const ValueFormat format = value_format_of(file);
  if (format == ValueFormat::nifti || format == ValueFormat::nifti_packed)
    if (const auto longest = *std::max_element(grid.dims.begin(), grid.dims.end()); longest > 32767)
      throw Error(ErrorCode::usage,
                  fmt::format("'{}': NIfTI-1 has at most 32767 voxels along an axis, not {}; take .nrrd", file.string(),
                              longest));
  base::in_arena(context, [&] {
    write_atomically(file, [&](std::ostream& out) {
      switch (format) {
        case ValueFormat::nrrd:
          out << nrrd_lines(grid, coordinates, "float", "local thickness; 0: none");
          write_packed(out, {}, slices);
          break;
        case ValueFormat::nifti: {
          const std::string header = nifti_header(grid, coordinates);
          out.write(header.data(), static_cast<std::streamsize>(header.size()));
          write_plain(out, slices);
          break;
        }
        case ValueFormat::nifti_packed:
          write_packed(out, nifti_header(grid, coordinates), slices);
          break;
        case ValueFormat::tiff: {
          TiffWriter tiff(out, grid, coordinates);
          slices([&](Slice slice) { tiff.write(slice); });
          tiff.finish();
          break;
        }
        default: {
          const std::string header = npy_header(grid);
          out.write(header.data(), static_cast<std::streamsize>(header.size()));
          write_plain(out, slices);
        }
      }
    });
  });
}

}  // namespace quench::io
