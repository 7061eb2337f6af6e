// SPDX-License-Identifier: Apache-2.0
#include "io/volume/zarr.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <memory>

#include "base/natural_order.h"
#include "base/text.h"
#include "io/common/formats.h"
#include "io/volume/chunked_volume.h"
#include "io/volume/pixels.h"
#include "io/volume/zarr_axes.h"
#include "io/volume/zarr_chunks.h"
#include "io/volume/zarr_node.h"
#include "quench/error.h"

namespace quench::io {
namespace {

/// Indices by names of axes.
using Chosen = std::map<std::string, std::int64_t>;

/// The indices of "c=1,t=0"; nothing where it is something else.
std::optional<Chosen> chosen_in(std::string_view text) {
  Chosen chosen;
  while (!text.empty()) {
    const std::string_view word = text.substr(0, text.find(','));
    text.remove_prefix(std::min(word.size() + 1, text.size()));
    const std::size_t equals = word.find('=');
    std::int64_t index = 0;
    if (equals == 0 || equals == word.npos) return {};
    const auto [end, error] = std::from_chars(word.data() + equals + 1, word.data() + word.size(), index);
    if (error != std::errc() || end != word.data() + word.size() || index < 0) return {};
    if (!chosen.emplace(word.substr(0, equals), index).second) return {};
  }
  return chosen;
}

/// `chosen` is nothing where what is behind the colon is something else.
std::pair<std::filesystem::path, std::optional<Chosen>> parts_of_name(const std::filesystem::path& file) {
  const std::filesystem::path folder = place_of_input(file);
  if (folder == file) return {file, Chosen()};
  return {folder, chosen_in(std::string_view(file.native()).substr(folder.native().size() + 1))};
}

/// The array that is read, with what is said of its axes.
struct FoundArray {
  ZarrNode node;
  std::vector<ZarrAxis> axes;
  std::string source;
};

class ZarrSearch {
 public:
  ZarrSearch(const std::filesystem::path& file, Context* context) : file_(file), context_(context) {}

  FoundArray find(const std::filesystem::path& folder) {
    const auto node = zarr_node(folder);
    if (!node)
      refuse_volume(file_,
                    "it holds none of .zarray, .zgroup, zarr.json and attributes.json, which say what a folder of "
                    "Zarr or N5 is; name the folder of an array or of an image");
    return node->array ? placed(*node) : in_group(*node, 0);
  }

 private:
  /// A group of a group of a group, as bioformats2raw has them, is deep enough.
  static constexpr int kDeepest = 4;

  FoundArray in_group(const ZarrNode& group, int depth) {
    if (depth > kDeepest) refuse_volume(file_, "its groups are nested too deep; name the folder of an array");
    if (const auto level = zarr_level(file_, group.attributes, {}, context_)) {
      auto node = zarr_node(group.folder / level->path);
      if (!node || !node->array)
        refuse_volume(file_, fmt::format("its multiscales name the array '{}', which is not there; copy or download it "
                                         "again",
                                         base::plain(level->path)));
      return {std::move(*node), level->axes, kOfOme};
    }
    const std::vector<ZarrNode> inside = images_in(group);
    if (inside.size() == 1) return inside[0].array ? placed(inside[0]) : in_group(inside[0], depth + 1);
    for (const ZarrNode& node : inside)
      if (node.array && node.format == ZarrFormat::n5 && node.folder.filename() == "s0") return placed(node);
    if (inside.empty()) refuse_volume(file_, "it is a group without arrays");
    std::vector<std::string> names;
    constexpr std::size_t kMostNames = 10;
    for (std::size_t i = 0; i < std::min(inside.size(), kMostNames); ++i)
      names.push_back(base::plain(inside[i].folder.filename().string()));
    if (inside.size() > kMostNames) names.push_back("...");
    refuse_volume(file_, fmt::format("it is a group of {} arrays or images, of which one is read: add its name, one of "
                                     "{}, behind a /",
                                     inside.size(), fmt::join(names, ", ")));
  }

  /// What in a group can be read, in natural order.
  static std::vector<ZarrNode> images_in(const ZarrNode& group) {
    std::vector<std::filesystem::path> folders;
    std::error_code error;
    for (std::filesystem::directory_iterator it(group.folder, error), end; !error && it != end; it.increment(error))
      if (std::error_code ignored; it->is_directory(ignored)) folders.push_back(it->path());
    if (error)
      throw Error(ErrorCode::failed,
                  fmt::format("the folder '{}' cannot be read: {}", group.folder.string(), error.message()));
    std::sort(folders.begin(), folders.end(), [](const auto& a, const auto& b) {
      return base::natural_less(a.filename().string(), b.filename().string());
    });
    std::vector<ZarrNode> inside;
    for (const auto& folder : folders)
      if (auto node = zarr_node(folder); node && (node->array || is_multiscale(node->attributes)))
        inside.push_back(std::move(*node));
    return inside;
  }

  /// An array with what the groups around it say of its place.
  FoundArray placed(const ZarrNode& node) {
    std::error_code ignored;
    std::filesystem::path folder = std::filesystem::absolute(node.folder, ignored).lexically_normal();
    if (!folder.has_filename()) folder = folder.parent_path();
    const std::filesystem::path array = folder;
    nlohmann::json parent = nlohmann::json::object();
    for (int up = 0; up < kDeepest && folder.has_relative_path(); ++up) {
      folder = folder.parent_path();
      const auto group = zarr_node(folder);
      if (!group) continue;
      if (up == 0) parent = group->attributes;
      const std::string path = array.lexically_relative(folder).string();
      if (const auto level = zarr_level(file_, group->attributes, path, context_)) return {node, level->axes, kOfOme};
    }
    std::vector<ZarrAxis> axes;
    if (node.format == ZarrFormat::n5) axes = n5_axes(node.attributes, parent);
    return {node, axes, axes.empty() ? "" : "the attributes of N5"};
  }

  static constexpr const char* kOfOme = "the OME-Zarr metadata";
  std::filesystem::path file_;
  Context* context_;
};

}  // namespace

bool is_zarr(const std::filesystem::path& file) {
  std::error_code ignored;
  const std::filesystem::path folder = place_of_input(file);
  if (!std::filesystem::is_directory(folder, ignored)) return false;
  const std::string extension = lower_extension(folder.has_filename() ? folder : folder.parent_path());
  if (extension == ".zarr" || extension == ".n5") return true;
  for (const char* name : {".zarray", ".zgroup", "zarr.json", "attributes.json"})
    if (std::filesystem::exists(folder / name, ignored)) return true;
  return false;
}

SliceStream open_zarr(const std::filesystem::path& file, const VolumeReadOptions& options, Context* context) {
  check_channel_of_grey(file, "a volume", channel_named(options.channel));
  const auto [folder, chosen] = parts_of_name(file);
  if (!chosen) refuse_volume(file, "what is behind the colon is not a choice along axes such as c=1 or c=1,t=0");
  const FoundArray found = ZarrSearch(file, context).find(folder);
  const ZarrArray array = zarr_array(file, found.node);
  if (!found.axes.empty() && found.axes.size() != array.axes())
    refuse_volume(file, fmt::format("{} speaks of {} axes, and the array has {}; correct one of them", found.source,
                                    found.axes.size(), array.axes()));
  const ZarrSection section = zarr_section(file, array, found.axes, *chosen);
  ChunkedVolume volume;
  for (std::size_t g = 0; g < 3; ++g) volume.grid.dims[g] = section.axis[g] ? array.shape[*section.axis[g]] : 1;
  if (!section.axis[2]) volume.grid.dimension = 2;
  place_section(file, section, found.axes, options, volume.grid, volume.coordinates, context);
  volume.spacing_source = found.source;
  volume.type = array.type.type;
  volume.fill = array.fill;
  const auto chunks = std::make_shared<ZarrChunks>(file, found.node.folder, array, section);
  volume.chunk = chunks->sides();
  volume.exists = [chunks](const ChunkIndex& index) { return chunks->exists(index); };
  volume.read = [chunks](const ChunkIndex& index, std::span<std::byte> out) { chunks->read(index, out); };
  return open_chunks(file, volume, context);
}

}  // namespace quench::io
