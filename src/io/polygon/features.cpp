// SPDX-License-Identifier: Apache-2.0
#include <cerrno>
#include <cstring>
#include <fstream>

#include "io/polygon/polygon_formats.h"

namespace quench::io {
namespace {

std::ifstream opened(const std::filesystem::path& file) {
  std::error_code ignored;
  if (std::filesystem::is_directory(file, ignored))
    throw Error(ErrorCode::failed, fmt::format("cannot read '{}': it is a folder, not a file", file.string()));
  if (std::filesystem::is_character_file(file, ignored))
    throw Error(ErrorCode::input, fmt::format("'{}' is a device, not a file", file.string()));
  errno = 0;
  std::ifstream in(file, std::ios::binary);
  if (!in) throw Error(ErrorCode::failed, fmt::format("cannot open '{}': {}", file.string(), std::strerror(errno)));
  if (in.peek() == std::ifstream::traits_type::eof())
    throw Error(ErrorCode::input, fmt::format("'{}' is empty", file.string()));
  in.clear();
  return in;
}

void say_what_coordinates_suggest(const FeatureSink& sink, Reference reference) {
  if (reference != Reference::degrees || !sink.has_positions()) return;
  const auto [x, y] = std::pair(sink.largest()[0], sink.largest()[1]);
  if (x <= 90 && y > 90 && y <= 360)
    note(sink.context(),
         fmt::format("'{}': the first coordinates stay within 90 and the second do not: are latitude and longitude "
                     "exchanged? Longitude comes first",
                     sink.file()));
  if (x <= 360 && y <= 360)
    note(sink.context(), fmt::format("'{}': coordinates look like degrees; lengths are in degrees", sink.file()));
}

Reference read_stream(const std::filesystem::path& file, const std::string& extension, FeatureSink& sink) {
  std::ifstream in = opened(file);
  if (extension == ".wkt") return read_wkt(in, sink);
  if (extension == ".geojson" || extension == ".json") return read_geojson(in, sink);
  return read_geojson_lines(in, sink);
}

}  // namespace

std::uint64_t for_each_feature(const std::filesystem::path& file, const std::function<void(PolygonFeature&&)>& take,
                               const std::function<void(PolygonFeature&&, const Error&)>& bad, Context* context,
                               const PolygonReadOptions& options) {
  if (kind_of(file) != Kind::polygons)
    throw Error(
        ErrorCode::input,
        fmt::format("'{}' is not a file of polygons; they are read from .geojson, .json, .geojsonl, .wkt and .svg",
                    file.string()));
  FeatureSink sink(file.string(), take, bad, context);
  const std::string extension = lower_extension(file);
  if (extension == ".svg")
    read_svg(load_file(file, context), options.curve_tolerance, sink);
  else
    say_what_coordinates_suggest(sink, read_stream(file, extension, sink));
  return sink.count();
}

}  // namespace quench::io
