// SPDX-License-Identifier: Apache-2.0
// A stack of slices in a folder: PNG or TIFF files in natural order.
#include <fmt/format.h>

#include <cstring>
#include <memory>
#include <set>

#include "base/natural_order.h"
#include "io/volume/slice_numbers.h"
#include "io/volume/slice_streams.h"
#include "io/volume/volume_formats.h"
#include "quench/error.h"

namespace quench::io {
namespace {

bool is_slice(const std::string& extension) {
  return extension == ".png" || extension == ".tif" || extension == ".tiff";
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
  std::sort(files.begin(), files.end(), [](const auto& a, const auto& b) {
    return base::natural_less(a.filename().string(), b.filename().string());
  });
  return files;
}

// The slices of a folder, one after the other; all of one size and type, with or without colours.
class SliceFolder {
 public:
  SliceFolder(const std::filesystem::path& folder, const VolumeReadOptions& options, Context* context)
      : files_(slice_files(folder)), context_(context), options_(options) {
    if (context) of_slices_.memory_limit = context->memory_limit;
    of_slices_.progress = [context](std::string_view, double) {
      if (context && context->cancelled()) throw Error(ErrorCode::cancelled, "cancelled");
    };
    if (files_.empty())
      throw Error(ErrorCode::input,
                  fmt::format("the folder '{}' holds no PNG, TIFF or DICOM slices; give a volume file or a folder of slices",
                              folder.string()));
    for (const auto& file : files_)
      if (volume_extension(file).substr(0, 4) != volume_extension(files_.front()).substr(0, 4))
        throw Error(ErrorCode::input,
                    fmt::format("the folder '{}' holds PNG and TIFF files; keep the slices of one stack in it",
                                folder.string()));
    check_slice_numbers(folder, files_);
    first_ = read(files_.front());
    index_ = first_.samples.index();
    dims_ = first_.grid.dims;
  }

  std::size_t count() const { return files_.size(); }
  /// The first slice, until it is taken by next().
  const Volume& first() const { return first_; }

  Volume next() {
    const std::filesystem::path& file = files_.at(z_++);
    if (z_ == 1) return std::move(first_);
    Volume slice = read(file);
    if (slice.grid.dims != dims_)
      throw Error(ErrorCode::input,
                  fmt::format("slice '{}' has {} x {} pixels, the slices before it {} x {}", file.string(),
                              slice.grid.dims[0], slice.grid.dims[1], dims_[0], dims_[1]));
    if (slice.samples.index() != index_)
      throw Error(ErrorCode::input,
                  fmt::format("slice '{}' has a different sample type from the slices before it", file.string()));
    return slice;
  }

 private:
  Volume read(const std::filesystem::path& file) {
    checkpoint(&of_slices_, "read", 0);
    of_slices_.note = [this, &file](const std::string& sentence) { note_once(file, sentence); };
    Volume slice = volume_extension(file) == ".png" ? read_picture_slice(file) : read_tiff(file);
    slice.grid.spacing = Vec3::Ones();
    slice.grid.dimension = 3;
    slice.coordinates = {};
    slice.spacing_source.clear();
    slice.picture.clear();
    if (slice.grid.dims[2] != 1)
      throw Error(ErrorCode::input, fmt::format("'{}' has {} pages where one slice is needed; read it on its own",
                                                file.string(), slice.grid.dims[2]));
    return slice;
  }

  Volume read_picture_slice(const std::filesystem::path& file) {
    Pixels pixels = read_png(file, &of_slices_);
    const std::optional<Channel> channel = channel_named(options_.channel);
    if (pixels.has_colours() && !channel) refuse_colours_of_slices(file, pixels.kind, pixels.width, pixels.height);
    return volume_of(std::move(pixels), file, channel, &of_slices_);
  }

  Volume read_tiff(const std::filesystem::path& file) {
    const bool is_first = &file == &files_.front();
    // The spacing of the stack is that of no slice: one note is enough, even where the sizes of pixels differ.
    VolumeReadOptions options = options_;
    if (!is_first) options.spacing = Vec3::Ones();
    const TiffStream stream = open_tiff(file, options, &of_slices_, true);
    if (is_first) colour_indices_ = stream.colour_indices;
    if (stream.colour_indices != colour_indices_)
      throw Error(ErrorCode::input,
                  fmt::format("slice '{}' has {}, the slices before it {}; convert all slices to grey values",
                              file.string(), stream.colour_indices ? "a palette of colours" : "grey values",
                              stream.colour_indices ? "grey values" : "a palette of colours"));
    return read_stream(stream, file, &of_slices_);
  }

  /// A note begins with the name of the slice.
  void note_once(const std::filesystem::path& file, const std::string& sentence) {
    const std::string name = fmt::format("'{}'", file.string());
    if (said_.insert(sentence.starts_with(name) ? sentence.substr(name.size()) : sentence).second)
      note(context_, sentence + "; said once for all slices");
  }

  std::vector<std::filesystem::path> files_;
  Context* context_;
  Context of_slices_;  // the limit of the caller, whose progress is that of the stack
  VolumeReadOptions options_;
  bool colour_indices_ = false;
  std::set<std::string> said_;
  Volume first_;
  std::size_t z_ = 0, index_ = 0;
  std::array<std::int64_t, 3> dims_{};
};

}  // namespace

Volume read_slices(const std::filesystem::path& folder, const VolumeReadOptions& options, Context* context) {
  SliceFolder slices(folder, options, context);
  Volume volume;
  for (std::size_t z = 0; z < slices.count(); ++z) {
    checkpoint(context, "read", static_cast<double>(z) / static_cast<double>(slices.count()));
    Volume slice = slices.next();
    if (z == 0) {
      volume = std::move(slice);
      volume.grid.dims[2] = static_cast<std::int64_t>(slices.count());
      continue;
    }
    std::visit(
        [&](auto& all) {
          const auto& one = std::get<std::decay_t<decltype(all)>>(slice.samples);
          if (z == 1) {
            check_read_memory(folder, one.size() * slices.count() * sizeof one[0], context);
            all.reserve(one.size() * slices.count());
          }
          all.insert(all.end(), one.begin(), one.end());
        },
        volume.samples);
  }
  checkpoint(context, "read", 1);
  return volume;
}

SliceStream open_slice_folder(const std::filesystem::path& folder, const VolumeReadOptions& options, Context* context) {
  const auto slices = std::make_shared<SliceFolder>(folder, options, context);
  SliceStream stream;
  stream.grid = slices->first().grid;
  stream.grid.dims[2] = static_cast<std::int64_t>(slices->count());
  stream.coordinates = slices->first().coordinates;
  stream.type = view_of(slices->first()).type;
  stream.next = [slices](std::span<std::byte> out) {
    const Volume slice = slices->next();
    std::visit([&](const auto& samples) { std::memcpy(out.data(), samples.data(), out.size()); }, slice.samples);
  };
  return stream;
}

}  // namespace quench::io
