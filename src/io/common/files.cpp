// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <limits>

#include "base/memory.h"
#include "io/common/formats.h"
#include "io/volume/zarr.h"

namespace quench::io {
namespace {

constexpr std::array kSurfaceExtensions{".ply", ".obj", ".off", ".stl", ".vtp", ".ma"};
// What Assimp reads and people store meshes in. Listed here so that the kind of a file does not depend on how Quench
// was built: without Assimp, reading explains what is missing.
constexpr std::array kAssimpExtensions{".3ds", ".3mf", ".ac",  ".amf",     ".ase",  ".b3d",  ".blend", ".bvh",
                                       ".dae", ".dxf", ".fbx", ".glb",     ".gltf", ".iqm",  ".irr",   ".lwo",
                                       ".lws", ".md2", ".md3", ".md5mesh", ".mdl",  ".ms3d", ".nff",   ".ogex",
                                       ".q3d", ".smd", ".ter", ".wrl",     ".x",    ".x3d",  ".xgl",   ".zgl"};
constexpr std::array kVolumeExtensions{".nrrd", ".nhdr", ".mha", ".mhd", ".nii", ".mrc", ".map",
                                       ".tif",  ".tiff", ".png", ".npy", ".vol", ".sof", ".out",
                                       ".pbm",  ".pgm",  ".ppm", ".pnm", ".bmp", ".jpg", ".jpeg"};
constexpr std::array kPolygonExtensions{".geojson", ".json", ".geojsonl", ".geojsons", ".ndjson", ".wkt", ".svg"};
constexpr std::array kSliceExtensions{".png", ".tif", ".tiff"};
constexpr std::array kHdf5Extensions{".h5", ".hdf5", ".hdf", ".ims"};
constexpr std::array kDicomExtensions{".dcm", ".dicom", ".ima"};

bool among(const auto& list, const std::string& extension) {
  return std::find(list.begin(), list.end(), extension) != list.end();
}

bool ends_with_nii_gz(const std::filesystem::path& file) {
  return lower_extension(file) == ".gz" && lower_extension(file.stem()) == ".nii";
}

}  // namespace

std::string lower_extension(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  for (char& c : extension)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return extension;
}

std::optional<Hdf5Name> hdf5_name(const std::filesystem::path& name) {
  if (among(kHdf5Extensions, lower_extension(name))) return Hdf5Name{name, {}};
  const std::string text = name.string();
  for (std::size_t colon = text.find(':'); colon != text.npos; colon = text.find(':', colon + 1)) {
    const std::filesystem::path file(text.substr(0, colon));
    if (among(kHdf5Extensions, lower_extension(file))) return Hdf5Name{file, text.substr(colon + 1)};
  }
  return {};
}

namespace {

/// Nothing: not by its extension.
std::optional<Kind> kind_by_extension(const std::filesystem::path& file) {
  const std::string extension = lower_extension(file);
  if (among(kSurfaceExtensions, extension) || among(kAssimpExtensions, extension)) return Kind::surface;
  if (among(kVolumeExtensions, extension) || ends_with_nii_gz(file) || hdf5_name(file)) return Kind::volume;
  if (among(kPolygonExtensions, extension)) return Kind::polygons;
  return {};
}

/// "DICM" behind 128 bytes of anything.
bool has_dicom_mark(const std::filesystem::path& file) {
  constexpr std::size_t kMark = 128;
  std::array<char, kMark + 4> start{};
  std::ifstream in(file, std::ios::binary);
  return in.read(start.data(), start.size()) && std::memcmp(start.data() + kMark, "DICM", 4) == 0;
}

}  // namespace

bool is_dicom(const std::filesystem::path& file) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored) || kind_by_extension(file)) return false;
  return among(kDicomExtensions, lower_extension(file)) || has_dicom_mark(file);
}

bool holds_dicom(const std::filesystem::path& folder) {
  std::error_code error;
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
    if (!entry->path().filename().string().starts_with('.') && is_dicom(entry->path())) return true;
  return false;
}

Kind kind_of(const std::filesystem::path& file) {
  if (is_zarr(file)) return Kind::volume;
  std::error_code ignored;
  if (std::filesystem::is_directory(file, ignored)) {
    for (std::filesystem::directory_iterator entry(file, ignored), end; !ignored && entry != end;
         entry.increment(ignored))
      if (among(kSliceExtensions, lower_extension(entry->path()))) return Kind::volume;
    return holds_dicom(file) ? Kind::volume : Kind::unknown;
  }
  const auto kind = kind_by_extension(file);
  return kind ? *kind : is_dicom(file) ? Kind::volume : Kind::unknown;
}

std::filesystem::path place_of_input(const std::filesystem::path& file) {
  const std::string name = file.string();
  const auto exists = [](const std::filesystem::path& path) {
    std::error_code ignored;
    return std::filesystem::exists(path, ignored);
  };
  if (exists(file)) return file;
  for (std::size_t colon = name.rfind(':'); colon != name.npos && colon > 0; colon = name.rfind(':', colon - 1))
    if (exists(name.substr(0, colon))) return name.substr(0, colon);
  return file;
}

namespace {

/// Throws when `more` bytes do not fit into memory beside the `held` ones.
void check_text_memory(const std::string& name, std::size_t held, std::size_t more, const Context* context) {
  if (more < std::size_t{1} << 24) return;  // asking the system takes longer than reading this
  const bool limited = context && context->memory_limit > 0;
  const std::int64_t limit = limited ? context->memory_limit : base::available_memory();
  const std::size_t needed = limited ? held + more : more;
  if (needed <= static_cast<std::size_t>(limit)) return;
  throw Error(ErrorCode::failed,
              fmt::format("reading '{}' needs more than {} of memory, all that {}; give a smaller file, and one that "
                          "ends",
                          name, base::bytes_text(limit), limited ? "is allowed" : "is free"));
}

}  // namespace

FileText load_file(const std::filesystem::path& file, Context* context) {
  FileText text{file.string(), {}};
  std::error_code ignored;
  if (std::filesystem::is_directory(file, ignored))
    throw Error(ErrorCode::failed, fmt::format("cannot read '{}': it is a folder, not a file", text.name));
  if (std::filesystem::is_character_file(file, ignored))
    throw Error(ErrorCode::input, fmt::format("'{}' is a device, not a file", text.name));
  errno = 0;
  std::ifstream in(file, std::ios::binary);
  if (!in) throw Error(ErrorCode::failed, fmt::format("cannot open '{}': {}", text.name, std::strerror(errno)));
  if (const auto size = std::filesystem::file_size(file, ignored); !ignored) {
    check_text_memory(text.name, 0, size, context);
    text.bytes.reserve(size);
  }
  // The size is a hint only: pipes have none, and a file may grow.
  for (std::array<char, 1 << 16> block; in;) {
    if (context && context->cancelled()) throw Error(ErrorCode::cancelled, "cancelled");
    in.read(block.data(), block.size());
    const auto got = static_cast<std::size_t>(in.gcount());
    if (text.bytes.size() + got > text.bytes.capacity())
      check_text_memory(text.name, text.bytes.capacity(), 2 * text.bytes.capacity(), context);
    text.bytes.append(block.data(), got);
  }
  if (in.bad()) throw Error(ErrorCode::failed, fmt::format("cannot read '{}': {}", text.name, std::strerror(errno)));
  if (text.bytes.empty()) throw Error(ErrorCode::input, fmt::format("'{}' is empty", text.name));
  return text;
}

Record read_record(const std::filesystem::path& file, Context* context) {
  const std::string extension = lower_extension(file);
  if (extension == ".ply") return read_ply(load_file(file, context));
  if (extension == ".obj") return read_obj(load_file(file, context));
  if (extension == ".off") return read_off(load_file(file, context));
  if (extension == ".stl") return read_stl(load_file(file, context));
  if (extension == ".vtp") return read_vtp(load_file(file, context));
  if (extension == ".ma") return read_ma(load_file(file, context));
  if (among(kAssimpExtensions, extension)) {
#ifdef QUENCH_HAS_ASSIMP
    return read_with_assimp(file);
#else
    throw Error(ErrorCode::input, fmt::format("cannot read '{}': this Quench was built without Assimp; convert the "
                                              "file to .ply, .obj, .off or .stl",
                                              file.string()));
#endif
  }
  if (std::error_code ignored; std::filesystem::is_directory(file, ignored))
    throw Error(ErrorCode::input, fmt::format("'{}' is a folder; give a file of a mesh or medial axis: .ply .obj .off "
                                              ".stl .vtp or .ma",
                                              file.string()));
  throw Error(ErrorCode::input,
              fmt::format("cannot read '{}': '{}' is not a file type of meshes or medial axes; use .ply .obj .off .stl "
                          ".vtp or .ma",
                          file.string(), extension));
}

namespace {

using Writer = void (*)(std::ostream&, const Record&, const WriteOptions&);

Writer writer_of(const std::filesystem::path& file) {
  const std::string extension = lower_extension(file);
  if (extension == ".ply")
    return [](std::ostream& out, const Record& data, const WriteOptions& o) { write_ply(out, data, o); };
  if (extension == ".obj")
    return [](std::ostream& out, const Record& data, const WriteOptions&) { write_obj(out, data); };
  if (extension == ".vtp")
    return [](std::ostream& out, const Record& data, const WriteOptions&) { write_vtp(out, data); };
  if (extension == ".vtu")
    return [](std::ostream& out, const Record& data, const WriteOptions&) { write_vtu(out, data); };
  if (extension == ".stl")
    return [](std::ostream& out, const Record& data, const WriteOptions&) { write_stl(out, data); };
  if (extension == ".ma")
    return [](std::ostream& out, const Record& data, const WriteOptions&) { write_ma(out, data); };
  if (extension == ".r") return [](std::ostream& out, const Record& data, const WriteOptions&) { write_r(out, data); };
  if (extension == ".csv")
    return [](std::ostream& out, const Record& data, const WriteOptions&) { write_csv(out, data); };
  throw Error(
      ErrorCode::usage,
      fmt::format(
          "cannot write '{}': '{}' is not a file type Quench writes; use .vtp .vtu .ply .obj .stl .ma .r or .csv",
          file.string(), extension));
}

}  // namespace

void write_record(const std::filesystem::path& file, const Record& data, const WriteOptions& options) {
  const Writer writer = writer_of(file);
  write_atomically(file, [&](std::ostream& out) { writer(out, data, options); });
}

void check_writable_format(const std::filesystem::path& file) { writer_of(file); }

void add_cell(Record& data, std::span<const std::uint32_t> corners, const std::string& file) {
  if (corners.size() == 1) {
    data.verts.push_back(corners[0]);
  } else if (corners.size() == 2) {
    data.lines.push_back({corners[0], corners[1]});
  } else {
    if (data.poly_corners.size() + corners.size() > std::numeric_limits<std::uint32_t>::max())
      throw Error(ErrorCode::input, fmt::format("'{}' has more than 4,294,967,295 polygon corners", file));
    data.poly_corners.insert(data.poly_corners.end(), corners.begin(), corners.end());
    data.poly_offsets.push_back(static_cast<std::uint32_t>(data.poly_corners.size()));
  }
}

void add_isolated_points(Record& data) {
  std::vector<char> used(data.points.size(), 0);
  for (const std::uint32_t v : data.verts) used[v] = 1;
  for (const auto& line : data.lines) used[line[0]] = used[line[1]] = 1;
  for (const std::uint32_t v : data.poly_corners) used[v] = 1;
  const std::size_t before = data.verts.size();
  for (std::uint32_t v = 0; v < used.size(); ++v)
    if (!used[v]) data.verts.push_back(v);
  const std::size_t added = data.verts.size() - before;
  for (DataArray& array : data.cell_data)
    std::visit(
        [&](auto& values) {
          const auto components = static_cast<std::size_t>(array.components);
          const auto at = values.begin() + static_cast<std::ptrdiff_t>(before * components);
          values.insert(at, added * components, typename std::decay_t<decltype(values)>::value_type());
        },
        array.values);
}

std::vector<double> required_radii(const Record& data, const char* format) {
  const DataArray* radius = find_array(data.point_data, "radius");
  if (!radius || radius->components != 1)
    throw Error(ErrorCode::input,
                fmt::format("a {} file needs a radius per vertex, and this data has no point array 'radius'", format));
  return radius->numbers();
}

std::string space_comment(const Record& data) {
  const DataArray* array = find_array(data.field_data, "SPACE");
  const auto* text = array ? std::get_if<std::vector<std::string>>(&array->values) : nullptr;
  return text && text->size() == 1 && text->front() == "LPS" ? "SPACE=LPS" : std::string();
}

float to_float(double value) {
  constexpr double kLargest = std::numeric_limits<float>::max();
  return static_cast<float>(value > kLargest ? kLargest : value < -kLargest ? -kLargest : value);
}

}  // namespace quench::io
