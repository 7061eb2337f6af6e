// SPDX-License-Identifier: Apache-2.0
// Volumes in HDF5, through the C interface of its library, which works in a child process: on damaged files it may
// crash or read endlessly.
#include <fmt/format.h>

#include "io/volume/slice_streams.h"
#include "quench/error.h"

#ifdef QUENCH_HAS_HDF5
#include <hdf5.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <memory>
#include <vector>

#include "base/platform/child_process.h"
#include "base/text.h"
#include "io/common/formats.h"
#include "io/volume/child_slices.h"
#include "io/volume/hdf5_spacing.h"
#include "io/volume/stored_volume.h"
#include "io/volume/volume_formats.h"
#include "shape/sample_type.h"

namespace quench::io {
namespace {

/// What the library says of the last thing that failed, at its origin: "inflate() failed".
std::string hdf5_reason() {
  std::string reason;
  const auto take = [](unsigned, const H5E_error2_t* error, void* to) -> herr_t {
    std::string& text = *static_cast<std::string*>(to);
    if (text.empty() && error->desc) text = error->desc;
    return 0;
  };
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, take, &reason);
  reason = reason.substr(0, std::min<std::size_t>(reason.find(':'), 120));  // behind a colon: addresses in memory
  return reason.empty() ? "no reason given" : base::plain(reason);
}

/// Nothing: a type that is no number.
std::optional<SampleType> hdf5_sample_type(hid_t type) {
  const std::size_t size = H5Tget_size(type);
  Hdf5Handle of_values;
  H5T_class_t kind = H5Tget_class(type);
  if (kind == H5T_ENUM) {
    of_values = Hdf5Handle(H5Tget_super(type), H5Tclose);
    type = of_values.id();
    kind = H5Tget_class(type);
  }
  if (kind == H5T_FLOAT && size <= 8) return size <= 4 ? SampleType::float32 : SampleType::float64;
  if (kind != H5T_INTEGER || size > 8 || size == 0) return {};
  const bool is_signed = H5Tget_sign(type) == H5T_SGN_2;
  if (size == 1) return is_signed ? SampleType::int8 : SampleType::uint8;
  if (size == 2) return is_signed ? SampleType::int16 : SampleType::uint16;
  if (size <= 4) return is_signed ? SampleType::int32 : SampleType::uint32;
  return is_signed ? SampleType::int64 : SampleType::uint64;
}

hid_t native_type(SampleType type) {
  const hid_t all[] = {H5T_NATIVE_UINT8, H5T_NATIVE_INT8,   H5T_NATIVE_UINT16, H5T_NATIVE_INT16, H5T_NATIVE_UINT32,
                       H5T_NATIVE_INT32, H5T_NATIVE_UINT64, H5T_NATIVE_INT64,  H5T_NATIVE_FLOAT, H5T_NATIVE_DOUBLE};
  return all[static_cast<std::size_t>(type)];
}

/// A dataset as a volume: which of its axes are x, y and z.
struct Hdf5Layout {
  std::vector<hsize_t> shape;           ///< of the dataset, the last axis fastest
  std::array<int, 3> axis{-1, -1, -1};  ///< of the dataset, for x, y, z; -1: none
  std::array<std::int64_t, 3> dims{1, 1, 1};
  std::optional<SampleType> type;
  bool fits = false;  ///< at most three axes remain, and at least two

  /// Axes longer than one voxel.
  int extended() const {
    return static_cast<int>(std::count_if(dims.begin(), dims.end(), [](auto n) { return n != 1; }));
  }
  std::string text() const {
    std::string sides;
    for (const hsize_t n : shape) sides += (sides.empty() ? "" : " x ") + std::to_string(n);
    return sides;
  }
};

Hdf5Layout layout_of(hid_t dataset) {
  Hdf5Layout layout;
  const Hdf5Handle space(H5Dget_space(dataset), H5Sclose), type(H5Dget_type(dataset), H5Tclose);
  const int rank = space.valid() ? H5Sget_simple_extent_ndims(space.id()) : -1;
  if (rank < 1 || !type.valid()) return layout;
  layout.shape.resize(static_cast<std::size_t>(rank));
  H5Sget_simple_extent_dims(space.id(), layout.shape.data(), nullptr);
  layout.type = hdf5_sample_type(type.id());
  std::size_t used = 0;
  for (int a = rank; a-- > 0;) {
    const hsize_t length = layout.shape[static_cast<std::size_t>(a)];
    if (rank > 3 && length == 1) continue;
    if (used == 3) return layout;
    layout.axis[used] = a;
    layout.dims[used++] = static_cast<std::int64_t>(std::min(length, hsize_t{1} << 62));
  }
  layout.fits = rank >= 2;
  return layout;
}

/// The datasets below a group that are numbers of two or three axes, with their layout.
std::vector<std::pair<std::string, Hdf5Layout>> volumes_below(hid_t group) {
  struct Found {
    std::vector<std::pair<std::string, Hdf5Layout>> all;
    std::size_t seen = 0;
  } found;
  const auto visit = [](hid_t from, const char* name, const H5O_info_t* info, void* to) -> herr_t {
    constexpr std::size_t kMost = 100'000;
    Found& here = *static_cast<Found*>(to);
    if (++here.seen > kMost) return 1;
    if (info->type != H5O_TYPE_DATASET) return 0;
    const Hdf5Handle dataset(H5Dopen2(from, name, H5P_DEFAULT), H5Dclose);
    if (!dataset.valid()) return 0;
    Hdf5Layout layout = layout_of(dataset.id());
    if (layout.fits && layout.type && layout.extended() >= 2) here.all.emplace_back(name, std::move(layout));
    return 0;
  };
  H5Ovisit2(group, H5_INDEX_NAME, H5_ITER_NATIVE, visit, &found, H5O_INFO_BASIC);
  const auto is_plane = [](const auto& each) { return each.second.extended() < 3; };
  if (!std::all_of(found.all.begin(), found.all.end(), is_plane)) std::erase_if(found.all, is_plane);
  return found.all;
}

/// The volume of a file, slice by slice.
class Hdf5Volume {
 public:
  Hdf5Volume(std::filesystem::path name, Context* context) : name_(std::move(name)), context_(context) {
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    const Hdf5Name parts = *hdf5_name(name_);
    open_file(parts.file);
    open_dataset(parts);
    check_type();
    check_filters();
    plan();
  }

  SliceStream stream() const {
    SliceStream stream;
    stream.grid.dims = layout_.dims;
    if (layout_.shape.size() == 2) stream.grid.dimension = 2;
    stream.type = *layout_.type;
    const Hdf5Spacing found = hdf5_spacing(dataset_.id(), layout_.shape.size(), layout_.axis);
    stream.grid.spacing = found.spacing;
    stream.grid.origin = found.origin;
    stream.coordinates.units = found.units;
    stream.spacing_source = found.source;
    if (!found.note.empty()) note(context_, fmt::format("'{}' {}", name_.string(), found.note));
    return stream;
  }

  void next(std::span<std::byte> out) {
    const std::int64_t in_layer = z_ % layer_;
    if (in_layer == 0) read_layer();
    std::memcpy(out.data(), buffer_.data() + static_cast<std::size_t>(in_layer) * out.size(), out.size());
    ++z_;
  }

 private:
  [[noreturn]] void refuse(const std::string& why) const { refuse_volume(name_, why); }

  void open_file(const std::filesystem::path& file) {
    { const InputFile there(file); }  // or its sentence
    if (H5Fis_hdf5(file.c_str()) <= 0)
      refuse("it is not a file of HDF5, or its begin is damaged; copy or download it again");
    const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
#if H5_VERSION_GE(1, 10, 7)
    H5Pset_file_locking(access.id(), false, true);  // of a file system that has no locks, too
#endif
    file_ = Hdf5Handle(H5Fopen(file.c_str(), H5F_ACC_RDONLY, access.id()), H5Fclose);
    if (!file_.valid()) refuse(fmt::format("it is damaged or incomplete ({})", hdf5_reason()));
  }

  /// "/a (64 x 64 x 64), /b (...)", at most 8.
  static std::string listed(const std::string& group, const std::vector<std::pair<std::string, Hdf5Layout>>& volumes) {
    constexpr std::size_t kMost = 8;
    std::string text;
    for (std::size_t i = 0; i < std::min(kMost, volumes.size()); ++i)
      text += fmt::format("{}{}{} ({})", i == 0 ? "" : ", ", group, base::plain(volumes[i].first.substr(0, 200)),
                          volumes[i].second.text());
    if (volumes.size() > kMost) text += fmt::format(" and {} more", volumes.size() - kMost);
    return text;
  }

  void open_dataset(const Hdf5Name& parts) {
    const std::string path = parts.dataset.empty() ? "/" : parts.dataset;
    const Hdf5Handle object(H5Oopen(file_.id(), path.c_str(), H5P_DEFAULT), H5Oclose);
    if (!object.valid()) {
      const auto volumes = volumes_below(file_.id());
      refuse(fmt::format("the file holds no '{}', or it is damaged{}", base::plain(path),
                         volumes.empty() ? "; nor does it hold any volume" : "; it holds " + listed("/", volumes)));
    }
    std::string chosen = path;
    if (H5Iget_type(object.id()) == H5I_GROUP) {
      const auto volumes = volumes_below(object.id());
      const std::string below = path.ends_with('/') ? path : path + '/';
      if (volumes.empty())
        refuse("it holds no array of numbers with two or three axes; give the file that holds the volume");
      if (volumes.size() > 1)
        refuse(fmt::format("it holds {} {}; name the one you mean, as in '{}:{}{}'",
                           base::counted(volumes.size(), "array"), listed(below, volumes), parts.file.string(), below,
                           base::plain(volumes[0].first)));
      chosen = below + volumes[0].first;
    }
    dataset_ = Hdf5Handle(H5Dopen2(file_.id(), chosen.c_str(), H5P_DEFAULT), H5Dclose);
    if (!dataset_.valid())
      refuse(fmt::format("'{}' is not an array, or it is damaged ({})", base::plain(chosen), hdf5_reason()));
    layout_ = layout_of(dataset_.id());
  }

  void check_type() {
    if (!layout_.fits)
      refuse(
          fmt::format("its array has the axes {}; a volume has three, an image two: save the part you mean on its own",
                      layout_.shape.empty() ? "of a single value" : layout_.text()));
    if (!layout_.type)
      refuse("its values are not numbers of up to 64 bits; convert them to integers, float32 or float64");
  }

  void check_filters() const {
    const Hdf5Handle made(H5Dget_create_plist(dataset_.id()), H5Pclose);
    const int filters = made.valid() ? H5Pget_nfilters(made.id()) : 0;
    for (int i = 0; i < filters; ++i) {
      unsigned flags = 0, config = 0;
      std::size_t values = 0;
      char name[80] = {};
      const H5Z_filter_t filter =
          H5Pget_filter2(made.id(), static_cast<unsigned>(i), &flags, &values, nullptr, sizeof name - 1, name, &config);
      if (filter >= 0 && H5Zfilter_avail(filter) <= 0)
        refuse(
            fmt::format("it is compressed by the filter {}{}, which this libhdf5 does not have; save it with gzip, or "
                        "install the filter and set HDF5_PLUGIN_PATH",
                        static_cast<int>(filter), *name ? fmt::format(" ({})", base::plain(name)) : ""));
    }
  }

  /// How many slices are read at a time: a layer of chunks.
  void plan() {
    const auto& dims = layout_.dims;
    const std::uint64_t size = shape::size_of(*layout_.type);
    checked_sample_count(name_, dims, size, std::uint64_t{1} << 62);
    const std::uint64_t slice = static_cast<std::uint64_t>(dims[0]) * static_cast<std::uint64_t>(dims[1]) * size;
    const Hdf5Handle made(H5Dget_create_plist(dataset_.id()), H5Pclose);
    std::vector<hsize_t> chunk(layout_.shape.size());
    const bool chunked = made.valid() && H5Pget_layout(made.id()) == H5D_CHUNKED &&
                         H5Pget_chunk(made.id(), static_cast<int>(chunk.size()), chunk.data()) >= 0;
    std::int64_t together = 1;
    std::uint64_t in_library = std::uint64_t{1} << 24;  // chunks as they are stored, decompressed and converted
    if (chunked) {
      std::uint64_t samples = 1;  // of a chunk, which has less than 4 GB
      for (const hsize_t n : chunk)
        samples = std::min<std::uint64_t>(samples * std::min<std::uint64_t>(n, std::uint64_t{1} << 32),
                                          std::uint64_t{1} << 32);
      in_library += 3 * samples * size;
      if (layout_.axis[2] >= 0)
        together = static_cast<std::int64_t>(
            std::min(chunk[static_cast<std::size_t>(layout_.axis[2])], static_cast<hsize_t>(dims[2])));
    }
    check_read_memory(name_, 2 * slice + in_library, context_);
    const auto fitting = static_cast<std::int64_t>(static_cast<std::uint64_t>(memory_of(context_)) / 2 / slice);
    layer_ = std::clamp<std::int64_t>(together, 1, std::max<std::int64_t>(1, fitting));
    base::allow_memory(static_cast<std::uint64_t>(layer_) * slice + in_library);
  }

  void read_layer() {
    checkpoint(context_, "read", 0);
    const std::int64_t slices = std::min(layer_, layout_.dims[2] - z_);
    std::vector<hsize_t> start(layout_.shape.size(), 0), count(layout_.shape.size(), 1);
    for (std::size_t a = 0; a < 3; ++a) {
      if (layout_.axis[a] < 0) continue;
      const auto axis = static_cast<std::size_t>(layout_.axis[a]);
      start[axis] = a == 2 ? static_cast<hsize_t>(z_) : 0;
      count[axis] = static_cast<hsize_t>(a == 2 ? slices : layout_.dims[a]);
    }
    buffer_.resize(static_cast<std::size_t>(layout_.dims[0] * layout_.dims[1] * slices) *
                   shape::size_of(*layout_.type));
    const Hdf5Handle space(H5Dget_space(dataset_.id()), H5Sclose);
    const Hdf5Handle memory(H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr), H5Sclose);
    if (H5Sselect_hyperslab(space.id(), H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr) < 0 ||
        H5Dread(dataset_.id(), native_type(*layout_.type), memory.id(), space.id(), H5P_DEFAULT, buffer_.data()) < 0)
      refuse(fmt::format("its values are damaged or incomplete in slice {} of {} ({})", z_ + 1, layout_.dims[2],
                         hdf5_reason()));
  }

  std::filesystem::path name_;
  Context* context_;
  Hdf5Handle file_, dataset_;
  Hdf5Layout layout_;
  std::int64_t layer_ = 1, z_ = 0;
  std::vector<std::byte> buffer_;
};

}  // namespace

SliceStream open_hdf5(const std::filesystem::path& name, Context* context) {
  const auto open = [&name](Context* in_child) {
    const auto volume = std::make_shared<Hdf5Volume>(name, in_child);
    SliceStream stream = volume->stream();
    stream.next = [volume](std::span<std::byte> out) { volume->next(out); };
    return stream;
  };
  return slices_of_child(name, open, context);
}

}  // namespace quench::io
#else
namespace quench::io {

SliceStream open_hdf5(const std::filesystem::path& name, Context*) {
  throw Error(ErrorCode::usage,
              fmt::format("'{}' cannot be read: HDF5 needs a Quench built with libhdf5 (libhdf5-dev); "
                          "convert it to NRRD or .npy, or rebuild",
                          name.string()));
}

}  // namespace quench::io
#endif
