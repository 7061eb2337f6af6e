// SPDX-License-Identifier: Apache-2.0
#include "quench/slices.h"

#include <fmt/format.h>

#include <utility>

#include "io/slice_streams.h"
#include "io/volume_formats.h"
#include "quench/error.h"

namespace quench::io {

void slices_end_early(const std::filesystem::path& file, std::int64_t slice, std::int64_t slices) {
  throw Error(ErrorCode::input, fmt::format("'{}' is damaged or incomplete: its data end in slice {} of {}",
                                            file.string(), slice + 1, slices));
}

std::size_t sample_size(SampleType type) {
  switch (type) {
    case SampleType::uint8:
    case SampleType::int8:
      return 1;
    case SampleType::uint16:
    case SampleType::int16:
      return 2;
    case SampleType::uint32:
    case SampleType::int32:
    case SampleType::float32:
      return 4;
    default:
      return 8;
  }
}

namespace {

template <std::size_t... i>
Volume::Samples samples_of(SampleType type, std::size_t count, std::index_sequence<i...>) {
  Volume::Samples samples;
  static_cast<void>(((static_cast<std::size_t>(type) == i && (samples.emplace<i>(count), true)) || ...));
  return samples;
}

}  // namespace

Volume read_stream(const SliceStream& stream, const std::filesystem::path& file, Context* context) {
  Volume volume;
  volume.grid = stream.grid;
  volume.units = stream.units;
  volume.spacing_source = stream.spacing_source;
  volume.space = stream.space;
  const auto& dims = stream.grid.dims;
  const auto side = [&](std::size_t a) { return static_cast<std::size_t>(dims[a]); };
  const std::size_t slice = side(0) * side(1);
  const std::size_t size = sample_size(stream.type);
  check_read_memory(file, slice * side(2) * size, context);
  volume.samples =
      samples_of(stream.type, slice * side(2), std::make_index_sequence<std::variant_size_v<Volume::Samples>>());
  std::visit(
      [&](auto& samples) {
        for (std::size_t z = 0; z < side(2); ++z) {
          checkpoint(context, "read", static_cast<double>(z) / static_cast<double>(side(2)));
          stream.next(std::as_writable_bytes(std::span(samples).subspan(z * slice, slice)));
        }
      },
      volume.samples);
  checkpoint(context, "read", 1);
  return volume;
}

std::optional<SliceStream> open_slices(const std::filesystem::path& file, const VolumeReadOptions& options,
                                       Context* context) {
  std::optional<SliceStream> stream;
  std::error_code error;
  const std::string extension = volume_extension(file);
  if (std::filesystem::is_directory(file, error))
    stream = open_slice_folder(file);
  else if (extension == ".tif" || extension == ".tiff")
    stream = open_tiff(file, context, options.spacing.has_value());
  else
    stream = open_itk_slices(file, context);
  if (stream) apply_spacing(file, options, stream->grid);
  return stream;
}

}  // namespace quench::io
