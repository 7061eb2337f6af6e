// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <limits>
#include <new>

#include "base/memory.h"
#include "base/text.h"
#include "io/common/formats.h"
#include "io/volume/slice_streams.h"
#include "io/volume/stored_volume.h"
#include "io/volume/volume_formats.h"
#include "io/volume/zarr.h"
#include "quench/error.h"
#include "quench/io.h"

namespace quench::io {

void refuse(const std::filesystem::path& file, const char* format, const std::string& why) {
  throw Error(ErrorCode::input, fmt::format("'{}' cannot be read as {}: {}", file.string(), format, base::plain(why)));
}

namespace {

Volume read_by_extension(const std::filesystem::path& file, const VolumeReadOptions& options, Context* context) {
  if (is_zarr(file)) return read_stream(open_zarr(file, options, context), file, context);
  std::error_code ignored;
  const bool folder = std::filesystem::is_directory(file, ignored);
  if (folder && !holds_dicom(file)) return read_slices(file, options, context);
  const std::string extension = volume_extension(file);
  const std::optional<Channel> channel = channel_named(options.channel);
  if (is_picture(extension)) return volume_of(read_picture(file, context), file, channel, context);
  if (extension == ".tif" || extension == ".tiff") return read_stream(open_tiff(file, options, context), file, context);
  check_channel_of_grey(file, "a volume", channel);
  if (hdf5_name(file)) return read_stream(open_hdf5(file, context), file, context);
  if (folder || is_dicom(file)) return read_stream(open_dicom(file, options, context), file, context);
  if (extension == ".npy") return read_npy(file, context);
  if (extension == ".vol") return read_vol(file, context);
  if (extension == ".sof") return read_sof(file, context);
  if (extension == ".out") return read_stream(open_out_voxels(file, context), file, context);
  if (is_stored_volume(extension)) return read_stream(open_stored(file, context), file, context);
  throw Error(
      ErrorCode::usage,
      fmt::format("'{}' is neither a volume nor an image by its extension; volumes are .nrrd .nhdr .mha .mhd "
                  ".nii .nii.gz .mrc .map .tif .tiff .npy .vol .sof .out .h5 .hdf5 .dcm, a folder of Zarr or N5 or one "
                  "of DICOM, PNG or TIFF slices, images .png .tif .bmp .jpg .pgm .pbm .ppm",
                  file.string()));
}

/// Two numbers, or three.
std::string numbers_of(const Vec3& spacing) {
  return spacing[2] == 0 ? fmt::format("{},{}", spacing[0], spacing[1])
                         : fmt::format("{},{},{}", spacing[0], spacing[1], spacing[2]);
}

/// "640 x 480 pixels", "5 x 4 x 3 voxels".
std::string size_text(const std::array<std::int64_t, 3>& dims) {
  return dims[2] == 1 ? fmt::format("{} x {} pixels", dims[0], dims[1])
                      : fmt::format("{} x {} x {} voxels", dims[0], dims[1], dims[2]);
}

/// Whether y grows downwards where a slice is drawn the right way up: its first row on top, as its file shows it, or
/// the front of a body. `direction`: of the slice in its file.
bool grows_down(const Mat3& direction, const Coordinates& coordinates) {
  if (coordinates.y_recorded) return *coordinates.y_recorded;
  return coordinates.space == "LPS" || !(direction(1, 1) < 0);
}

/// Where a slice lies in its own plane.
void lay_in_plane(const std::filesystem::path& file, Grid& grid, Coordinates& coordinates, Context* context) {
  constexpr double kTilt = 1e-3;  // of the direction of an axis; more is not the rounding of a file
  grid.make_plane();
  grid.origin[2] = 0;
  const double tilt = grid.direction.row(2).head<2>().cwiseAbs().maxCoeff();
  if (tilt > kTilt) {
    grid.direction.setIdentity();
    grid.origin.setZero();
  }
  coordinates.y_down = grows_down(grid.direction, coordinates);
  coordinates.space.clear();
  if (tilt > kTilt) {
    note(context, fmt::format("'{}' lies obliquely in space; its coordinates are taken as those of its own plane, from "
                              "the centre of its first pixel",
                              file.string()));
    return;
  }
  for (int a = 0; a < 2 && tilt > 0; ++a) {
    grid.direction(2, a) = 0;
    grid.direction.col(a).normalize();
  }
  grid.direction.col(2) = Vec3::UnitZ();
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
      throw Error(ErrorCode::input, fmt::format("'{}' claims {}; every side must be from 1 to {}", file.string(),
                                                size_text(dims), kLongest));
    bytes *= static_cast<double>(side);
  }
  const auto claim = [&] {
    return fmt::format("'{}' claims {} of {}", file.string(), size_text(dims), base::counted(bytes_per_sample, "byte"));
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

void check_options(const VolumeReadOptions& options) {
  channel_named(options.channel);
  if (options.dimension && *options.dimension != 2 && *options.dimension != 3)
    throw Error(ErrorCode::usage, fmt::format("dimension '{}' is neither 2 nor 3", *options.dimension), "dimension");
  if (!options.spacing) return;
  const Vec3& s = *options.spacing;
  if (!s.allFinite() || s.head<2>().minCoeff() <= 0 || s[2] < 0)
    throw Error(
        ErrorCode::usage,
        fmt::format("the spacing {} must be positive numbers, two of an image or three of a volume", numbers_of(s)),
        "spacing");
}

void take_spacing(const std::string& what, const Vec3& spacing, Grid& grid) {
  const bool third = spacing[2] != 0;
  if (!grid.is_plane() && !third)
    throw Error(ErrorCode::usage,
                fmt::format("the spacing {} has two numbers, and {} is a volume, which needs three (or one)",
                            numbers_of(spacing), what),
                "spacing");
  if (grid.is_plane() && third && spacing[2] != spacing[0] && spacing[2] != spacing[1])
    throw Error(ErrorCode::usage,
                fmt::format("the spacing {} has three numbers, and {} is an image, which needs two (or one)",
                            numbers_of(spacing), what),
                "spacing");
  grid.spacing = spacing;
  if (grid.is_plane()) grid.make_plane();
}

namespace {

/// Whether the grid is that of a plane, by the file and the options.
bool becomes_plane(const std::filesystem::path& file, const std::optional<int>& dimension, const Grid& grid) {
  const auto& dims = grid.dims;
  if (grid.is_plane()) return dimension != 3;
  if (dims[2] == 1 && !dimension)
    throw Error(ErrorCode::usage,
                fmt::format("'{}' is a volume of one slice of {} x {} voxels, which may be meant as an image; say its "
                            "dimension: 2 takes it as an image of the plane, 3 as a slab one voxel thick",
                            file.string(), dims[0], dims[1]),
                "dimension");
  if (dims[2] > 1 && dimension == 2)
    throw Error(ErrorCode::usage,
                fmt::format("'{}' is a volume of {} slices, and an image has one; take it as a volume, or save the "
                            "slice you mean on its own",
                            file.string(), dims[2]),
                "dimension");
  return dimension == 2;
}

}  // namespace

void settle_grid(const std::filesystem::path& file, const VolumeReadOptions& options, Grid& grid,
                 Coordinates& coordinates, Context* context) {
  const Vec3& s = grid.spacing;
  if (becomes_plane(file, options.dimension, grid))
    lay_in_plane(file, grid, coordinates, context);
  else
    grid.dimension = 3;
  if (options.spacing) take_spacing(fmt::format("'{}'", file.string()), *options.spacing, grid);
  if (!s.allFinite() || s.minCoeff() <= 0)
    throw Error(ErrorCode::input, fmt::format("'{}' has the spacing {} x {} x {}, which is not positive; give another",
                                              file.string(), s[0], s[1], s[2]));
  if (!grid.origin.allFinite())
    throw Error(ErrorCode::input,
                fmt::format("the origin of '{}' is not a point; its header is damaged", file.string()));
}

bool is_picture(std::string_view extension) {
  constexpr std::array kKnown{".png", ".pbm", ".pgm", ".ppm", ".pnm", ".bmp", ".jpg", ".jpeg"};
  return std::find(kKnown.begin(), kKnown.end(), extension) != kKnown.end();
}

Pixels read_picture(const std::filesystem::path& file, Context* context) {
  const std::string extension = volume_extension(file);
  if (extension == ".png") return read_png(file, context);
  if (extension == ".bmp") return read_bmp(file, context);
  if (extension == ".jpg" || extension == ".jpeg") return read_jpeg(file, context);
  return read_pnm(file, context);
}

Volume read_volume(const std::filesystem::path& file, const VolumeReadOptions& options, Context* context) {
  check_options(options);  // before a long reading
  Volume volume;
  try {
    volume = read_by_extension(file, options, context);
  } catch (const std::bad_alloc&) {
    throw Error(ErrorCode::failed,
                fmt::format("'{}' does not fit into memory; crop it or lower its resolution", file.string()));
  }
  settle_grid(file, options, volume.grid, volume.coordinates, context);
  return volume;
}

}  // namespace quench::io
