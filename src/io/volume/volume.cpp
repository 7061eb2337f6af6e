// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cctype>
#include <cmath>
#include <limits>
#include <new>

#include "base/memory.h"
#include "base/text.h"
#include "io/volume/slice_streams.h"
#include "io/volume/stored_volume.h"
#include "io/volume/volume_formats.h"
#include "quench/error.h"
#include "quench/io.h"

namespace quench::io {

void refuse(const std::filesystem::path& file, const char* format, const std::string& why) {
  throw Error(ErrorCode::input, fmt::format("'{}' cannot be read as {}: {}", file.string(), format, base::plain(why)));
}

namespace {

Volume read_by_extension(const std::filesystem::path& file, bool spacing_is_given, Context* context) {
  std::error_code ignored;
  if (std::filesystem::is_directory(file, ignored)) return read_slices(file, context, spacing_is_given);
  const std::string extension = volume_extension(file);
  if (extension == ".npy") return read_npy(file, context);
  if (extension == ".vol") return read_vol(file, context);
  if (extension == ".sof") return read_sof(file, context);
  if (extension == ".png") return read_png(file, context);
  if (extension == ".tif" || extension == ".tiff")
    return read_stream(open_tiff(file, context, spacing_is_given), file, context);
  if (is_stored_volume(extension)) return read_stream(open_stored(file, context), file, context);
  throw Error(ErrorCode::usage,
              fmt::format("'{}' is not a volume by its extension; volumes are .nrrd .nhdr .mha .mhd .nii .nii.gz .mrc "
                          ".map .tif .tiff .png .npy .vol .sof or a folder of PNG or TIFF slices",
                          file.string()));
}

}  // namespace

void check_regular_file(const std::filesystem::path& file) {
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (error || std::filesystem::is_regular_file(status) || std::filesystem::is_directory(status)) return;
  throw Error(
      ErrorCode::input,
      fmt::format("'{}' is not a regular file (it is a pipe or a device); save it to disk first", file.string()));
}

InputFile::InputFile(const std::filesystem::path& file) {
  check_regular_file(file);  // before it is opened: a pipe would wait for its writer
  stream.open(file, std::ios::binary);
  std::error_code error;
  if (!stream || std::filesystem::is_directory(file, error))
    throw Error(ErrorCode::failed,
                fmt::format("'{}' cannot be opened; check the name and the permissions", file.string()));
  stream.seekg(0, std::ios::end);
  const std::streamoff end = stream.tellg();
  size = static_cast<std::uint64_t>(std::max<std::streamoff>(0, end));
  stream.seekg(0);
  if (end == 0) throw Error(ErrorCode::input, fmt::format("'{}' is empty", file.string()));
}

std::string volume_extension(const std::filesystem::path& file) {
  std::string name = file.filename().string();
  for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (name.ends_with(".nii.gz")) return ".nii.gz";
  return std::filesystem::path(name).extension().string();
}

std::uint64_t checked_sample_count(const std::filesystem::path& file, const std::array<std::int64_t, 3>& dims,
                                   std::uint64_t bytes_per_sample, std::uint64_t available) {
  // Voxel coordinates are 32-bit, and one past the last one is used.
  constexpr std::int64_t kLongest = std::numeric_limits<std::int32_t>::max() - 1;
  constexpr double kMost = 0x1p62;
  double bytes = static_cast<double>(bytes_per_sample);
  for (const std::int64_t side : dims) {
    if (side < 1 || side > kLongest)
      throw Error(ErrorCode::input, fmt::format("'{}' claims {} x {} x {} voxels; every side must be from 1 to {}",
                                                file.string(), dims[0], dims[1], dims[2], kLongest));
    bytes *= static_cast<double>(side);
  }
  const auto claim = [&] {
    return fmt::format("'{}' claims {} x {} x {} voxels of {}", file.string(), dims[0], dims[1], dims[2],
                       base::counted(bytes_per_sample, "byte"));
  };
  if (bytes > kMost) throw Error(ErrorCode::input, claim() + ", more than any memory; the header is damaged");
  const auto count =
      static_cast<std::uint64_t>(dims[0]) * static_cast<std::uint64_t>(dims[1]) * static_cast<std::uint64_t>(dims[2]);
  if (count * bytes_per_sample > available)
    throw Error(ErrorCode::input, claim() + " but is too short for them; it is damaged or incomplete");
  return count;
}

void check_read_memory(const std::filesystem::path& file, std::uint64_t bytes, const Context* context) {
  constexpr std::uint64_t kLittle = std::uint64_t{1} << 24;  // asking the system takes longer than reading this
  const bool limited = context && context->memory_limit > 0;
  if (!limited && bytes < kLittle) return;
  const std::int64_t limit = limited ? context->memory_limit : base::available_memory();
  const auto needed = static_cast<std::int64_t>(std::min(bytes, std::uint64_t{1} << 62));
  if (needed > limit)
    throw Error(
        ErrorCode::failed,
        fmt::format("reading '{}' needs about {} of memory, and {} {}; crop it or lower its resolution", file.string(),
                    base::bytes_text(needed), base::bytes_text(limit), limited ? "are allowed" : "are free"));
}

void apply_spacing(const std::filesystem::path& file, const VolumeReadOptions& options, Grid& grid) {
  const auto positive = [](const Vec3& s) { return s.allFinite() && s.minCoeff() > 0; };
  if (options.spacing) {
    const Vec3& s = *options.spacing;
    if (!positive(s))
      throw Error(ErrorCode::usage,
                  fmt::format("the spacing {},{},{} must be three positive numbers", s[0], s[1], s[2]));
    grid.spacing = s;
  }
  const Vec3& s = grid.spacing;
  if (!positive(s))
    throw Error(ErrorCode::input, fmt::format("'{}' has the spacing {} x {} x {}, which is not positive; give another",
                                              file.string(), s[0], s[1], s[2]));
  if (!grid.origin.allFinite())
    throw Error(ErrorCode::input,
                fmt::format("the origin of '{}' is not a point; its header is damaged", file.string()));
}

Volume read_volume(const std::filesystem::path& file, const VolumeReadOptions& options, Context* context) {
  if (options.spacing) {
    Grid any;
    apply_spacing(file, options, any);  // before a long reading
  }
  Volume volume;
  try {
    volume = read_by_extension(file, options.spacing.has_value(), context);
  } catch (const std::bad_alloc&) {
    throw Error(ErrorCode::failed,
                fmt::format("'{}' does not fit into memory; crop it or lower its resolution", file.string()));
  }
  apply_spacing(file, options, volume.grid);
  return volume;
}

}  // namespace quench::io
