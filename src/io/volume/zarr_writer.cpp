// SPDX-License-Identifier: Apache-2.0
// OME-Zarr: NGFF 0.4 (https://ngff.openmicroscopy.org/0.4) on Zarr v2.
#include "io/volume/zarr_writer.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "base/parallel.h"
#include "io/common/formats.h"
#include "io/common/output_file.h"
#include "quench/error.h"

namespace quench::io {
namespace {

namespace fs = std::filesystem;
using ZarrJson = nlohmann::ordered_json;

constexpr int kDeflateLevel = 6;
constexpr int kDeepestZarr = 16;      // folders in folders; no one writes more
constexpr double kNearlyAxes = 1e-9;  // of a direction; a voxel at the far end moves by far less than its size

std::string text_of(const ZarrJson& text) {
  return text.dump(2, ' ', false, ZarrJson::error_handler_t::replace) + '\n';
}

/// The name of a unit of length in NGFF, which are those of UDUNITS-2; others stay as they are.
std::string ngff_unit(const std::string& unit) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 12> kNames{{{"mm", "millimeter"},
                                                                                  {"um", "micrometer"},
                                                                                  {"\u00b5m", "micrometer"},
                                                                                  {"\u03bcm", "micrometer"},
                                                                                  {"micron", "micrometer"},
                                                                                  {"microns", "micrometer"},
                                                                                  {"nm", "nanometer"},
                                                                                  {"pm", "picometer"},
                                                                                  {"cm", "centimeter"},
                                                                                  {"m", "meter"},
                                                                                  {"km", "kilometer"},
                                                                                  {"in", "inch"}}};
  for (const auto& [name, full] : kNames)
    if (unit == name) return std::string(full);
  return unit;
}

ZarrJson attributes_of(const Grid& grid, const Coordinates& coordinates, const std::string& name) {
  ZarrJson axes = ZarrJson::array(), scale = ZarrJson::array(), translation = ZarrJson::array();
  for (const int a : {2, 1, 0}) {
    ZarrJson axis = {{"name", std::string(1, "xyz"[a])}, {"type", "space"}};
    if (!coordinates.units.empty()) axis["unit"] = ngff_unit(coordinates.units);
    axes.push_back(std::move(axis));
    scale.push_back(grid.spacing[a]);
    translation.push_back(0.0 + grid.origin[a]);  // 0 for -0
  }
  const auto transformation = [](const std::string& kind, ZarrJson& values) {
    return ZarrJson::object({{"type", kind}, {kind, std::move(values)}});
  };
  const ZarrJson level = ZarrJson::object(
      {{"path", "0"},
       {"coordinateTransformations",
        ZarrJson::array({transformation("scale", scale), transformation("translation", translation)})}});
  const ZarrJson image = ZarrJson::object(
      {{"version", "0.4"}, {"name", name}, {"axes", std::move(axes)}, {"datasets", ZarrJson::array({level})}});
  return ZarrJson::object({{"multiscales", ZarrJson::array({image})}});
}

ZarrJson array_of(const Grid& grid, std::uint8_t background) {
  return {{"zarr_format", 2},
          {"shape", {grid.dims[2], grid.dims[1], grid.dims[0]}},
          {"chunks", {kZarrSide, kZarrSide, kZarrSide}},
          {"dtype", "|u1"},
          {"compressor", {{"id", "zlib"}, {"level", kDeflateLevel}}},
          {"fill_value", background},
          {"order", "C"},
          {"filters", nullptr},
          {"dimension_separator", "/"}};
}

/// As zlib does it. Runs of equal bytes are all that there is to find in most chunks, which takes a third of the time.
std::string compressed_chunk(const std::vector<std::uint8_t>& samples) {
  z_stream stream{};
  if (deflateInit2(&stream, kDeflateLevel, Z_DEFLATED, MAX_WBITS, 8, Z_RLE) != Z_OK)
    throw Error(ErrorCode::failed, "zlib cannot be started: out of memory");
  std::string out(deflateBound(&stream, samples.size()), '\0');
  stream.next_in = const_cast<Bytef*>(samples.data());
  stream.avail_in = static_cast<uInt>(samples.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  const int result = deflate(&stream, Z_FINISH);
  out.erase(out.size() - stream.avail_out);
  deflateEnd(&stream);
  if (result != Z_STREAM_END) throw Error(ErrorCode::invariant, "a chunk does not fit into what zlib said it takes");
  return out;
}

bool is_all(const std::vector<std::uint8_t>& samples, std::uint8_t value) {
  return samples.empty() ||
         (samples[0] == value && std::memcmp(samples.data(), samples.data() + 1, samples.size() - 1) == 0);
}

/// "zarr.json", ".zarray", "0", "3.4.5", "c.3.4": what files of a Zarr of version 2 or 3 are called.
bool is_zarr_part(const std::string& name) {
  for (const char* known : {".zgroup", ".zattrs", ".zarray", ".zmetadata", "zarr.json"})
    if (name == known) return true;
  return !name.empty() && name.find_first_not_of("0123456789.", name[0] == 'c' ? 1 : 0) == std::string::npos;
}

/// A folder without the slash behind its name.
fs::path without_slash(const fs::path& path) { return path.has_filename() ? path : path.parent_path(); }

/// Which chunks hold voxels of the shape, x fastest. O(runs + scanlines).
std::vector<bool> touched_chunks(const VoxelShape& shape, const std::array<std::int64_t, 3>& counts) {
  const Grid& grid = shape.grid();
  std::vector<bool> touched(static_cast<std::size_t>(counts[0] * counts[1] * counts[2]));
  for (std::int64_t z = 0; z < grid.dims[2]; ++z)
    for (std::int64_t y = 0; y < grid.dims[1]; ++y) {
      const std::int64_t first = counts[0] * (y / kZarrSide + counts[1] * (z / kZarrSide));
      for (const Run& run : shape.row(y, z))
        for (std::int64_t c = run.begin / kZarrSide; c * kZarrSide < run.end; ++c)
          touched[static_cast<std::size_t>(first + c)] = true;
    }
  return touched;
}

std::vector<std::uint8_t> chunk_of_shape(const VoxelShape& shape, const std::array<std::int64_t, 3>& begin) {
  std::vector<std::uint8_t> samples(kZarrSide * kZarrSide * kZarrSide, 0);
  for (std::int64_t z = 0; z < kZarrSide; ++z)
    for (std::int64_t y = 0; y < kZarrSide; ++y) {
      const std::span<const Run> row = shape.row(begin[1] + y, begin[2] + z);
      std::uint8_t* to = samples.data() + kZarrSide * (y + kZarrSide * z);
      for (auto run = std::partition_point(row.begin(), row.end(), [&](const Run& r) { return r.end <= begin[0]; });
           run != row.end() && run->begin < begin[0] + kZarrSide; ++run) {
        const std::int64_t from = std::max<std::int64_t>(run->begin - begin[0], 0);
        const std::int64_t end = std::min(run->end - begin[0], kZarrSide);
        std::memset(to + from, 1, static_cast<std::size_t>(end - from));
      }
    }
  return samples;
}

std::array<std::int64_t, 3> chunk_counts(const Grid& grid) {
  std::array<std::int64_t, 3> counts{};
  for (std::size_t a = 0; a < 3; ++a) counts[a] = (grid.dims[a] + kZarrSide - 1) / kZarrSide;
  return counts;
}

/// The same shape in the world, on a grid in which every axis goes up. Direction: diagonal, of 1 and -1. O(runs).
VoxelShape upward(const VoxelShape& shape) {
  Grid grid = shape.grid();
  const auto turned = [&](Eigen::Index a) { return shape.grid().direction(a, a) < 0; };
  for (Eigen::Index a = 0; a < 3; ++a)
    if (turned(a)) grid.origin[a] -= grid.spacing[a] * static_cast<double>(grid.dims[static_cast<std::size_t>(a)] - 1);
  grid.direction = Mat3::Identity();
  VoxelShape result(grid);
  std::vector<Run> runs;
  for (std::int64_t z = 0; z < grid.dims[2]; ++z)
    for (std::int64_t y = 0; y < grid.dims[1]; ++y) {
      const std::span<const Run> row =
          shape.row(turned(1) ? grid.dims[1] - 1 - y : y, turned(2) ? grid.dims[2] - 1 - z : z);
      runs.assign(row.begin(), row.end());
      const auto end = static_cast<std::int32_t>(grid.dims[0]);
      if (turned(0)) {
        std::reverse(runs.begin(), runs.end());
        for (Run& run : runs) run = {end - run.end, end - run.begin};
      }
      result.append_row(runs);
    }
  return result;
}

void check_zarr_grid(const fs::path& folder, const Grid& grid) {
  const auto refuse = [&](const char* reason) {
    throw Error(ErrorCode::usage, fmt::format("cannot write '{}': {}; write .nrrd", folder.string(), reason));
  };
  if (grid.is_plane()) refuse("Zarr is written of volumes, and this is an image of the plane");
  if (!grid.direction.isIdentity(kNearlyAxes))
    refuse("OME-Zarr has no directions of axes, and those of this volume are not x, y and z");
}

}  // namespace

bool is_zarr_name(const fs::path& path) { return lower_extension(without_slash(path)) == ".zarr"; }

void check_zarr_output(const fs::path& path) {
  const fs::path folder = place_of_output(without_slash(path));
  std::error_code error;
  const fs::file_status status = fs::status(folder, error);
  if (!fs::exists(status)) return;
  const auto refuse = [&](const std::string& reason) {
    throw Error(ErrorCode::usage, fmt::format("'{}' {}, and is not replaced; give another name or remove it yourself",
                                              without_slash(path).string(), reason));
  };
  if (!fs::is_directory(status)) refuse("is not a folder");
  if (::access(folder.c_str(), W_OK) != 0) refuse("is not writable");
  fs::recursive_directory_iterator entry(folder, error);
  for (const fs::recursive_directory_iterator end; !error && entry != end; entry.increment(error)) {
    const fs::file_status found = entry->symlink_status(error);
    const bool part = fs::is_directory(found) ? entry.depth() < kDeepestZarr
                                              : fs::is_regular_file(found) && is_zarr_part(entry->path().filename());
    if (fs::is_directory(found) && ::access(entry->path().c_str(), W_OK) != 0)
      refuse(
          fmt::format("is a folder in which '{}' is not writable", entry->path().lexically_relative(folder).string()));
    if (!part && !error)
      refuse(fmt::format("is a folder that holds '{}', which is no part of a Zarr",
                         entry->path().lexically_relative(folder).string()));
  }
  if (error) throw Error(ErrorCode::failed, fmt::format("cannot look into '{}': {}", path.string(), error.message()));
}

void write_zarr(const fs::path& path, const Grid& grid, std::uint8_t background, const ZarrChunk& chunk,
                const Coordinates& coordinates, Context* context) {
  const fs::path folder = without_slash(path);
  check_zarr_grid(folder, grid);
  check_zarr_output(folder);
  OutputFolder out(folder);
  out.write(".zgroup", text_of({{"zarr_format", 2}}));
  out.write(".zattrs", text_of(attributes_of(grid, coordinates, folder.stem().string())));
  out.write("0/.zarray", text_of(array_of(grid, background)));
  const std::array<std::int64_t, 3> counts = chunk_counts(grid);
  const auto all = static_cast<std::size_t>(counts[0] * counts[1] * counts[2]);
  base::in_arena(context, [&] {
    base::for_chunks(all, context, "write", 0, 1, [&](std::size_t i) {
      const auto number = static_cast<std::int64_t>(i);
      const std::int64_t x = number % counts[0], y = number / counts[0] % counts[1], z = number / counts[0] / counts[1];
      const std::vector<std::uint8_t> samples = chunk({x * kZarrSide, y * kZarrSide, z * kZarrSide});
      if (!samples.empty() && samples.size() != kZarrSide * kZarrSide * kZarrSide)
        throw Error(ErrorCode::invariant, fmt::format("a chunk of {} samples", samples.size()));
      if (!is_all(samples, background)) out.write(fmt::format("0/{}/{}/{}", z, y, x), compressed_chunk(samples));
    });
  });
  check_zarr_output(folder);  // long ago
  out.commit();
}

void write_shape_zarr(const fs::path& folder, const VoxelShape& shape, const Coordinates& coordinates,
                      Context* context) {
  const Mat3& direction = shape.grid().direction;
  if (direction.cwiseAbs().isIdentity(kNearlyAxes) && direction.diagonal().minCoeff() < 0)
    return write_shape_zarr(folder, upward(shape), coordinates, context);
  check_zarr_grid(folder, shape.grid());
  const std::array<std::int64_t, 3> counts = chunk_counts(shape.grid());
  const std::vector<bool> touched = touched_chunks(shape, counts);
  const auto chunk = [&](const std::array<std::int64_t, 3>& begin) {
    const std::int64_t number =
        (begin[0] + counts[0] * (begin[1] + counts[1] * begin[2])) / kZarrSide;  // each is a multiple of it
    return touched[static_cast<std::size_t>(number)] ? chunk_of_shape(shape, begin) : std::vector<std::uint8_t>();
  };
  write_zarr(folder, shape.grid(), 0, chunk, coordinates, context);
}

}  // namespace quench::io
