// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cctype>
#include <cmath>
#include <limits>
#include <new>

#include "io/volume_formats.h"
#include "quench/error.h"
#include "quench/io.h"
#include "quench/memory.h"

namespace quench::io {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

// slice2 before slice10: digits compare as numbers (leading zeros left out), everything else by character.
bool natural_less(const std::string& a, const std::string& b) {
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (is_digit(a[i]) && is_digit(b[j])) {
      while (i < a.size() && a[i] == '0') ++i;
      while (j < b.size() && b[j] == '0') ++j;
      const std::size_t i0 = i, j0 = j;
      while (i < a.size() && is_digit(a[i])) ++i;
      while (j < b.size() && is_digit(b[j])) ++j;
      if (i - i0 != j - j0) return i - i0 < j - j0;
      if (const int order = a.compare(i0, i - i0, b, j0, j - j0); order != 0) return order < 0;
    } else {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i;
      ++j;
    }
  }
  if ((i < a.size()) != (j < b.size())) return j < b.size();
  return a < b;
}

bool is_slice(const std::string& extension) {
  return extension == ".png" || extension == ".tif" || extension == ".tiff";
}

Volume read_by_extension(const std::filesystem::path& file, Context* context) {
  std::error_code ignored;
  if (std::filesystem::is_directory(file, ignored)) return read_slices(file, context);
  const std::string extension = volume_extension(file);
  if (extension == ".npy") return read_npy(file, context);
  if (extension == ".vol") return read_vol(file, context);
  if (extension == ".sof") return read_sof(file, context);
  if (extension == ".png") return read_png(file, context);
  for (const char* known : {".nrrd", ".nhdr", ".mha", ".mhd", ".nii", ".nii.gz", ".mrc", ".map", ".tif", ".tiff"})
    if (extension == known) {
      const InputFile probe(file);  // "cannot be opened" in the same words for every format
      if (probe.size == 0) throw Error(ErrorCode::input, fmt::format("'{}' is empty", file.string()));
      return read_itk(file, context);
    }
  throw Error(ErrorCode::usage,
              fmt::format("'{}' is not a volume by its extension; volumes are .nrrd .nhdr .mha .mhd .nii .nii.gz .mrc "
                          ".map .tif .tiff .png .npy .vol .sof or a folder of PNG or TIFF slices",
                          file.string()));
}

}  // namespace

InputFile::InputFile(const std::filesystem::path& file) : stream(file, std::ios::binary) {
  std::error_code error;
  if (!stream || std::filesystem::is_directory(file, error))
    throw Error(ErrorCode::failed,
                fmt::format("'{}' cannot be opened; check the name and the permissions", file.string()));
  stream.seekg(0, std::ios::end);
  size = static_cast<std::uint64_t>(std::max<std::streamoff>(0, stream.tellg()));
  stream.seekg(0);
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
  constexpr std::int64_t longest = std::numeric_limits<std::int32_t>::max() - 1;
  constexpr double most = 0x1p62;
  double bytes = static_cast<double>(bytes_per_sample);
  for (const std::int64_t side : dims) {
    if (side < 1 || side > longest)
      throw Error(ErrorCode::input, fmt::format("'{}' claims {} x {} x {} voxels; every side must be from 1 to {}",
                                                file.string(), dims[0], dims[1], dims[2], longest));
    bytes *= static_cast<double>(side);
  }
  const auto claim = [&] {
    return fmt::format("'{}' claims {} x {} x {} voxels of {} bytes", file.string(), dims[0], dims[1], dims[2],
                       bytes_per_sample);
  };
  if (bytes > most) throw Error(ErrorCode::input, claim() + ", more than any memory; the header is damaged");
  const auto count =
      static_cast<std::uint64_t>(dims[0]) * static_cast<std::uint64_t>(dims[1]) * static_cast<std::uint64_t>(dims[2]);
  if (count * bytes_per_sample > available)
    throw Error(ErrorCode::input, claim() + " but is too short for them; it is damaged or incomplete");
  return count;
}

void check_read_memory(const std::filesystem::path& file, std::uint64_t bytes, const Context* context) {
  constexpr std::uint64_t little = std::uint64_t{1} << 24;  // asking the system takes longer than reading this
  const bool limited = context && context->memory_limit > 0;
  if (!limited && bytes < little) return;
  const std::int64_t limit = limited ? context->memory_limit : available_memory();
  const auto needed = static_cast<std::int64_t>(std::min(bytes, std::uint64_t{1} << 62));
  if (needed > limit)
    throw Error(
        ErrorCode::failed,
        fmt::format("reading '{}' needs about {} of memory, and {} {}; crop it or lower its resolution", file.string(),
                    bytes_text(needed), bytes_text(limit), limited ? "are allowed" : "are free"));
}

std::vector<std::filesystem::path> slice_files(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  std::error_code error;
  for (std::filesystem::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    const std::string name = it->path().filename().string();
    if (!name.starts_with('.') && is_slice(volume_extension(it->path()))) files.push_back(it->path());
  }
  if (error)
    throw Error(ErrorCode::failed, fmt::format("the folder '{}' cannot be read: {}", folder.string(), error.message()));
  std::sort(files.begin(), files.end(),
            [](const auto& a, const auto& b) { return natural_less(a.filename().string(), b.filename().string()); });
  return files;
}

Volume read_slices(const std::filesystem::path& folder, Context* context) {
  const std::vector<std::filesystem::path> files = slice_files(folder);
  if (files.empty())
    throw Error(ErrorCode::input,
                fmt::format("the folder '{}' holds no PNG or TIFF slices; give a volume file or a folder of slices",
                            folder.string()));
  for (const auto& file : files)
    if (volume_extension(file).substr(0, 4) != volume_extension(files.front()).substr(0, 4))
      throw Error(
          ErrorCode::input,
          fmt::format("the folder '{}' holds PNG and TIFF files; keep the slices of one stack in it", folder.string()));
  Volume volume;
  for (std::size_t z = 0; z < files.size(); ++z) {
    checkpoint(context, "read", static_cast<double>(z) / static_cast<double>(files.size()));
    Volume slice = volume_extension(files[z]) == ".png" ? read_png(files[z], nullptr) : read_itk(files[z], nullptr);
    if (slice.grid.dims[2] != 1)
      throw Error(ErrorCode::input, fmt::format("'{}' has {} pages where one slice is needed; read it on its own",
                                                files[z].string(), slice.grid.dims[2]));
    if (z == 0) {
      volume = std::move(slice);
      volume.grid.dims[2] = static_cast<std::int64_t>(files.size());
      continue;
    }
    if (slice.grid.dims[0] != volume.grid.dims[0] || slice.grid.dims[1] != volume.grid.dims[1])
      throw Error(ErrorCode::input,
                  fmt::format("slice '{}' has {} x {} pixels, the slices before it {} x {}", files[z].string(),
                              slice.grid.dims[0], slice.grid.dims[1], volume.grid.dims[0], volume.grid.dims[1]));
    if (slice.samples.index() != volume.samples.index())
      throw Error(ErrorCode::input,
                  fmt::format("slice '{}' has another sample type than the slices before it", files[z].string()));
    std::visit(
        [&](auto& all) {
          const auto& one = std::get<std::decay_t<decltype(all)>>(slice.samples);
          if (z == 1) {
            check_read_memory(folder, one.size() * files.size() * sizeof one[0], context);
            all.reserve(one.size() * files.size());
          }
          all.insert(all.end(), one.begin(), one.end());
        },
        volume.samples);
  }
  checkpoint(context, "read", 1);
  return volume;
}

void apply_spacing(const std::filesystem::path& file, const VolumeReadOptions& options, Grid& grid) {
  const auto positive = [](const Vec3& s) { return s.allFinite() && s.minCoeff() > 0; };
  if (options.spacing) {
    const Vec3& s = *options.spacing;
    if (!positive(s))
      throw Error(ErrorCode::usage, fmt::format("--spacing {},{},{} must be three positive numbers", s[0], s[1], s[2]));
    grid.spacing = s;
  }
  const Vec3& s = grid.spacing;
  if (!positive(s))
    throw Error(ErrorCode::input,
                fmt::format("'{}' has the spacing {} x {} x {}, which is not positive; give --spacing", file.string(),
                            s[0], s[1], s[2]));
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
    volume = read_by_extension(file, context);
  } catch (const std::bad_alloc&) {
    throw Error(ErrorCode::failed,
                fmt::format("'{}' does not fit into memory; crop it or lower its resolution", file.string()));
  }
  apply_spacing(file, options, volume.grid);
  return volume;
}

}  // namespace quench::io
