// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <ostream>

#include "io/common/formats.h"
#include "io/common/text_out.h"
#include "io/common/viridis.h"

/// Binary PLY for MeshLab, Blender and the like: point arrays by name, `quality` and colours of one of them.
namespace quench::io {
namespace {

/// Colours over the range of the finite values; a value that is not finite is grey.
std::vector<Colour> colours_of(const std::vector<double>& values) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (double value : values)
    if (std::isfinite(value)) {
      low = std::min(low, value);
      high = std::max(high, value);
    }
  std::vector<Colour> colours;
  colours.reserve(values.size());
  for (double value : values)
    colours.push_back(!std::isfinite(value) ? Colour{128, 128, 128}
                                            : viridis(high > low ? (value / 2 - low / 2) / (high / 2 - low / 2) : 0));
  return colours;
}

/// A column of the vertex element: numbers, and the type to write them in.
struct Column {
  enum class Type { uchar, single, twice } type;
  std::string name;
  std::vector<double> values;
};

std::string property_name(std::string name) {
  for (char& c : name)
    if (static_cast<unsigned char>(c) <= ' ') c = '_';
  return name.empty() ? "unnamed" : name;
}

float as_float(double value) { return std::isfinite(value) ? to_float(value) : static_cast<float>(value); }

std::vector<Column> columns_of(const Record& data, const WriteOptions& options) {
  const DataArray* quality = find_array(data.point_data, options.quality_array);
  if (quality && (quality->components != 1 || std::holds_alternative<std::vector<std::string>>(quality->values)))
    quality = nullptr;
  if (!quality && options.quality_array != WriteOptions().quality_array)
    throw Error(ErrorCode::usage, fmt::format("there is no point array '{}' of single numbers to write as quality",
                                              options.quality_array));
  std::vector<Column> columns;
  const auto taken = [&](const std::string& name) {
    if (name == "x" || name == "y" || name == "z") return true;
    if (quality && (name == "quality" || name == "red" || name == "green" || name == "blue")) return true;
    return std::any_of(columns.begin(), columns.end(), [&](const Column& column) { return column.name == name; });
  };
  for (const DataArray& array : data.point_data) {
    if (array.components != 1 || std::holds_alternative<std::vector<std::string>>(array.values)) continue;
    const std::string name = property_name(array.name);
    if (taken(name)) continue;
    // Colours that came with the mesh stay bytes, which is what programs expect.
    const bool colour = (name == "red" || name == "green" || name == "blue" || name == "alpha") &&
                        std::holds_alternative<std::vector<std::uint8_t>>(array.values);
    const auto type = colour ? Column::Type::uchar : name == "radius" ? Column::Type::twice : Column::Type::single;
    columns.push_back({type, name, array.numbers()});
  }
  if (!quality) return columns;
  const std::vector<double> values = quality->numbers();
  const std::vector<Colour> colours = colours_of(values);
  columns.push_back({Column::Type::single, "quality", values});
  for (std::size_t c = 0; c < 3; ++c) {
    Column column{Column::Type::uchar, std::array{"red", "green", "blue"}[c], {}};
    for (const Colour& colour : colours) column.values.push_back(colour[c]);
    columns.push_back(std::move(column));
  }
  return columns;
}

/// Numbers in the processor's (little-endian) byte order, in large pieces.
class BinaryOut {
 public:
  explicit BinaryOut(std::ostream& out) : out_(out) {}
  template <class T>
  void put(T value) {
    const char* bytes = reinterpret_cast<const char*>(&value);
    buffer_.insert(buffer_.end(), bytes, bytes + sizeof value);
    if (buffer_.size() > 1 << 16) flush();
  }
  void flush() {
    out_.write(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
    buffer_.clear();
  }

 private:
  std::ostream& out_;
  std::vector<char> buffer_;
};

}  // namespace

void write_ply(std::ostream& out, const Record& data, const WriteOptions& options) {
  const std::vector<Column> columns = columns_of(data, options);
  std::size_t most_corners = 0;
  for (std::size_t f = 0; f < data.poly_count(); ++f)
    most_corners = std::max<std::size_t>(most_corners, data.poly_offsets[f + 1] - data.poly_offsets[f]);

  TextOut header(out);
  header.print("ply\nformat binary_little_endian 1.0\ncomment Quench {}\n", QUENCH_VERSION);
  if (const std::string space = space_comment(data); !space.empty()) header.print("comment {}\n", space);
  header.print("element vertex {}\n", data.points.size());
  header.print("property double x\nproperty double y\nproperty double z\n");
  for (const Column& column : columns)
    header.print("property {} {}\n",
                 column.type == Column::Type::uchar    ? "uchar"
                 : column.type == Column::Type::single ? "float"
                                                       : "double",
                 column.name);
  // Many programs read signed indices only; the bytes are the same.
  const char* index = data.points.size() <= std::numeric_limits<std::int32_t>::max() ? "int" : "uint";
  header.print("element face {}\nproperty list {} {} vertex_indices\n", data.poly_count(),
               most_corners < 256 ? "uchar" : "uint", index);
  // Last: VTK, and so ParaView, does not skip what it does not know, and would take edges for faces.
  if (!data.lines.empty())
    header.print("element edge {}\nproperty {} vertex1\nproperty {} vertex2\n", data.lines.size(), index, index);
  header.print("end_header\n");
  header.flush();

  BinaryOut body(out);
  for (std::size_t v = 0; v < data.points.size(); ++v) {
    for (int a = 0; a < 3; ++a) body.put(data.points[v][a]);
    for (const Column& column : columns) switch (column.type) {
        case Column::Type::uchar:
          body.put(static_cast<std::uint8_t>(column.values[v]));
          break;
        case Column::Type::single:
          body.put(as_float(column.values[v]));
          break;
        case Column::Type::twice:
          body.put(column.values[v]);
          break;
      }
  }
  for (std::size_t f = 0; f < data.poly_count(); ++f) {
    const std::uint32_t begin = data.poly_offsets[f], end = data.poly_offsets[f + 1];
    if (most_corners < 256)
      body.put(static_cast<std::uint8_t>(end - begin));
    else
      body.put(end - begin);
    for (std::uint32_t c = begin; c < end; ++c) body.put(data.poly_corners[c]);
  }
  for (const auto& line : data.lines)
    for (std::uint32_t end : line) body.put(end);
  body.flush();
}

}  // namespace quench::io
