// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <utility>

#include "io/common/formats.h"
#include "io/volume/slice_streams.h"
#include "io/volume/stored_volume.h"
#include "io/volume/volume_formats.h"
#include "io/volume/zarr.h"
#include "quench/error.h"
#include "quench/io.h"
#include "quench/shape.h"
#include "shape/sample_type.h"

namespace quench::io {

void slices_end_early(const std::filesystem::path& file, std::int64_t slice, std::int64_t slices) {
  throw Error(ErrorCode::input, fmt::format("'{}' is damaged or incomplete: its data end in slice {} of {}",
                                            file.string(), slice + 1, slices));
}

Volume read_stream(const SliceStream& stream, const std::filesystem::path& file, Context* context) {
  Volume volume;
  volume.grid = stream.grid;
  volume.coordinates = stream.coordinates;
  volume.spacing_source = stream.spacing_source;
  volume.picture = stream.picture;
  const auto& dims = stream.grid.dims;
  const auto slice = static_cast<std::size_t>(dims[0]) * static_cast<std::size_t>(dims[1]);
  const auto slices = static_cast<std::size_t>(dims[2]);
  check_read_memory(file, slice * slices * shape::size_of(stream.type), context);
  shape::with_sample_type(stream.type, [&]<class T>(T) {
    std::vector<T> samples(slice * slices);
    for (std::size_t z = 0; z < slices; ++z) {
      checkpoint(context, "read", static_cast<double>(z) / static_cast<double>(slices));
      stream.next(std::as_writable_bytes(std::span(samples).subspan(z * slice, slice)));
    }
    volume.samples = std::move(samples);
  });
  checkpoint(context, "read", 1);
  return volume;
}

std::optional<SliceStream> open_slices(const std::filesystem::path& file, const VolumeReadOptions& options,
                                       Context* context) {
  check_options(options);
  std::optional<SliceStream> stream;
  std::error_code error;
  const std::string extension = volume_extension(file);
  if (is_zarr(file)) {
    stream = open_zarr(file, options, context);
  } else if (std::filesystem::is_directory(file, error) && !holds_dicom(file)) {
    stream = open_slice_folder(file, options, context);
  } else if (std::filesystem::is_directory(file, error) || is_dicom(file)) {
    check_channel_of_grey(file, "a volume", channel_named(options.channel));
    stream = open_dicom(file, options, context);
  } else if (hdf5_name(file)) {
    check_channel_of_grey(file, "a volume", channel_named(options.channel));
    stream = open_hdf5(file, context);
  } else if (extension == ".tif" || extension == ".tiff") {
    stream = open_tiff(file, options, context);
  } else if (extension == ".out") {
    check_channel_of_grey(file, "a volume", channel_named(options.channel));
    stream = open_out_voxels(file, context);
  } else if (is_stored_volume(extension)) {
    check_channel_of_grey(file, "a volume", channel_named(options.channel));
    stream = open_stored(file, context);
  }
  if (stream) settle_grid(file, options, stream->grid, stream->coordinates, context);
  return stream;
}

}  // namespace quench::io
