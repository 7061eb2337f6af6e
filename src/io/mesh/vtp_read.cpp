// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <pugixml.hpp>
#include <type_traits>
#include <utility>

#include "base/text.h"
#include "io/common/formats.h"
#include "io/common/words.h"
#include "io/mesh/vtp_blocks.h"

/// VTK XML PolyData as VTK and Quench write it: text, inline base64 and appended (raw or base64) arrays, compressed by
/// zlib or not. Polylines become segments, triangle strips triangles, pieces one; arrays that Record has no place for
/// (bits, strings on points or cells) are left out.
namespace quench::io {
namespace {

/// The XML of a file, and the bytes after it that are not XML.
struct Document {
  std::string name;
  pugi::xml_document xml;
  std::string_view appended;  ///< from the byte after "_"
  BlockFormat format;         ///< of appended data; inline data is always base64

  [[noreturn]] void fail(const std::string& what) const {
    throw Error(ErrorCode::input, fmt::format("'{}': {}", name, base::plain(what)));
  }
};

void load(const FileText& file, Document& document) {
  document.name = file.name;
  std::string_view bytes = file.bytes;
  std::string xml;
  if (const std::size_t tag = bytes.find("<AppendedData"); tag != std::string_view::npos) {
    const std::size_t end = bytes.find('>', tag);
    const std::size_t start = end == std::string_view::npos ? end : bytes.find_first_not_of(" \t\r\n", end + 1);
    if (start == std::string_view::npos || bytes[start] != '_')
      document.fail("the appended data does not begin with '_'; the file is incomplete or damaged");
    document.appended = bytes.substr(start + 1);
    xml = std::string(bytes.substr(0, end + 1)) + "</AppendedData></VTKFile>";
    bytes = xml;
  }
  const pugi::xml_parse_result result =
      document.xml.load_buffer(bytes.data(), bytes.size(), pugi::parse_default, pugi::encoding_utf8);
  if (!result)
    document.fail(fmt::format("the XML is incomplete or damaged at byte {}: {}", result.offset, result.description()));

  const pugi::xml_node root = document.xml.child("VTKFile");
  if (!root) document.fail("this is not a VTK XML file");
  const std::string type = root.attribute("type").value(), order = root.attribute("byte_order").value(),
                    headers = root.attribute("header_type").as_string("UInt32"),
                    compressor = root.attribute("compressor").value();
  if (type != "PolyData") document.fail(fmt::format("the type is '{}', not PolyData", type));
  if (order != "LittleEndian" && !order.empty())
    document.fail(fmt::format("the byte order '{}' is not supported; write it on a little-endian machine", order));
  if (headers != "UInt32" && headers != "UInt64")
    document.fail(fmt::format("the header type '{}' is unknown", headers));
  if (!compressor.empty() && compressor != "vtkZLibDataCompressor")
    document.fail(fmt::format("the compressor '{}' is not supported; write it with zlib or uncompressed", compressor));
  const std::string encoding = root.child("AppendedData").attribute("encoding").as_string("raw");
  if (encoding != "raw" && encoding != "base64")
    document.fail(fmt::format("the encoding '{}' of the appended data is unknown", encoding));
  document.format = {headers == "UInt64", !compressor.empty(), encoding == "base64"};
}

template <class Stored, class Kept>
DataArray::Values from_bytes(std::string_view bytes, const Document& document, const std::string& what) {
  if (bytes.size() % sizeof(Stored) != 0) document.fail(what + " ends within a number");
  std::vector<Kept> values(bytes.size() / sizeof(Stored));
  for (std::size_t i = 0; i < values.size(); ++i) {
    Stored value;
    std::memcpy(&value, bytes.data() + i * sizeof value, sizeof value);
    if constexpr (std::is_same_v<Stored, std::uint64_t>)
      if (!std::in_range<Kept>(value)) document.fail(what + " has integers of 2^63 and more");
    values[i] = static_cast<Kept>(value);
  }
  return values;
}

template <class Kept>
std::vector<Kept> numbers_from_text(const std::string& text, const Document& document, const std::string& what) {
  Words words(text, document.name, {.comment = '\0'});
  std::vector<Kept> values;
  for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
    if constexpr (std::is_floating_point_v<Kept>) {
      double value = 0;
      if (!parse_number(word, value)) document.fail(what + " has text that is not a number");
      values.push_back(std::is_same_v<Kept, double> || !std::isfinite(value) ? static_cast<Kept>(value)
                                                                             : static_cast<Kept>(to_float(value)));
    } else {
      std::int64_t value = 0;
      if (!parse_integer(word, value) || !std::in_range<Kept>(value))
        document.fail(what + " has text that is not a whole number in the range of its type");
      values.push_back(static_cast<Kept>(value));
    }
  }
  return values;
}

template <class Kept>
DataArray::Values from_text(const std::string& text, const Document& document, const std::string& what) {
  return numbers_from_text<Kept>(text, document, what);
}

DataArray::Values strings_from_bytes(std::string_view bytes, const Document&, const std::string&) {
  std::vector<std::string> strings;
  while (!bytes.empty()) {
    const std::size_t end = std::min(bytes.find('\0'), bytes.size());
    strings.emplace_back(bytes.substr(0, end));
    bytes.remove_prefix(std::min(end + 1, bytes.size()));
  }
  return strings;
}

/// From character codes; some writers have signed characters.
DataArray::Values strings_from_text(const std::string& text, const Document& document, const std::string& what) {
  std::string bytes;
  for (std::int32_t code : numbers_from_text<std::int32_t>(text, document, what))
    bytes += static_cast<char>(code & 0xFF);
  return strings_from_bytes(bytes, document, what);
}

/// How the values of an array are read, by the type VTK gives it.
struct ArrayType {
  std::string_view name;
  DataArray::Values (*text)(const std::string& text, const Document& document, const std::string& what);
  DataArray::Values (*bytes)(std::string_view bytes, const Document& document, const std::string& what);
};
constexpr ArrayType kArrayTypes[] = {{"Float64", from_text<double>, from_bytes<double, double>},
                                     {"Float32", from_text<float>, from_bytes<float, float>},
                                     {"Int64", from_text<std::int64_t>, from_bytes<std::int64_t, std::int64_t>},
                                     {"Int32", from_text<std::int32_t>, from_bytes<std::int32_t, std::int32_t>},
                                     {"Int16", from_text<std::int32_t>, from_bytes<std::int16_t, std::int32_t>},
                                     {"Int8", from_text<std::int32_t>, from_bytes<std::int8_t, std::int32_t>},
                                     {"UInt64", from_text<std::int64_t>, from_bytes<std::uint64_t, std::int64_t>},
                                     {"UInt32", from_text<std::int64_t>, from_bytes<std::uint32_t, std::int64_t>},
                                     {"UInt16", from_text<std::int32_t>, from_bytes<std::uint16_t, std::int32_t>},
                                     {"UInt8", from_text<std::uint8_t>, from_bytes<std::uint8_t, std::uint8_t>},
                                     {"String", strings_from_text, strings_from_bytes}};

/// The bytes of an array that is not written as text.
std::string bytes_of(const Document& document, const pugi::xml_node& node, const std::string& format,
                     const std::string& what) {
  const std::string where = fmt::format("'{}': {}", document.name, base::plain(what));
  if (format == "appended") {
    const unsigned long long offset = node.attribute("offset").as_ullong();
    if (offset > document.appended.size()) document.fail(what + " lies beyond the end of the file");
    return decode_blocks(document.appended.substr(offset), document.format, where);
  }
  if (format != "binary") document.fail(fmt::format("{} has the unknown format '{}'", what, format));
  BlockFormat block = document.format;
  block.base64 = true;
  const std::string_view text = node.text().get();
  return text.empty() ? std::string() : decode_blocks(text, block, where);
}

/// One DataArray element. False, and no values, for a type that a Record cannot carry.
bool read_array(const Document& document, const pugi::xml_node& node, DataArray& array) {
  array.name = node.attribute("Name").value();
  array.components = node.attribute("NumberOfComponents").as_int(1);
  const std::string what = fmt::format("the array '{}'", array.name);
  const std::string_view name = node.attribute("type").value();
  const std::string format = node.attribute("format").as_string("ascii");
  if (array.components < 1) document.fail(fmt::format("{} has {} components", what, array.components));
  const auto type = std::ranges::find(kArrayTypes, name, &ArrayType::name);
  if (type == std::end(kArrayTypes)) return false;
  array.values = format == "ascii" ? type->text(node.text().get(), document, what)
                                   : type->bytes(bytes_of(document, node, format, what), document, what);
  return true;
}

/// The array of that name, or the first one where the name is empty, in a section of a piece.
DataArray required_array(const Document& document, const pugi::xml_node& section, const char* name) {
  for (const pugi::xml_node& node : section.children()) {
    if (*name && std::strcmp(node.attribute("Name").value(), name) != 0) continue;
    DataArray array;
    if (!read_array(document, node, array) || std::holds_alternative<std::vector<std::string>>(array.values))
      document.fail(fmt::format("an array of '{}' does not hold numbers", section.name()));
    return array;
  }
  document.fail(fmt::format("'{}' has no array {}", section.name(), name));
}

std::vector<std::int64_t> integers(const Document& document, const DataArray& array) {
  return std::visit(
      [&](const auto& values) -> std::vector<std::int64_t> {
        using T = typename std::decay_t<decltype(values)>::value_type;
        if constexpr (std::is_integral_v<T>)
          return {values.begin(), values.end()};
        else
          document.fail(fmt::format("the array '{}' does not hold integers", array.name));
      },
      array.values);
}

/// Rows of `array` in the order `rows`.
void gather(DataArray& array, const std::vector<std::size_t>& rows) {
  std::visit(
      [&](auto& values) {
        std::decay_t<decltype(values)> gathered;
        const std::size_t components = static_cast<std::size_t>(array.components);
        gathered.reserve(rows.size() * components);
        for (std::size_t row : rows)
          for (std::size_t c = 0; c < components; ++c) gathered.push_back(values[row * components + c]);
        values = std::move(gathered);
      },
      array.values);
}

std::vector<DataArray> read_arrays(const Document& document, const pugi::xml_node& section, std::size_t rows) {
  std::vector<DataArray> arrays;
  for (const pugi::xml_node& node : section.children()) {
    DataArray array;
    if (!read_array(document, node, array) || std::holds_alternative<std::vector<std::string>>(array.values)) continue;
    if (array.size() % static_cast<std::size_t>(array.components) != 0 ||
        array.size() / static_cast<std::size_t>(array.components) != rows)
      document.fail(fmt::format("the array '{}' has {} values of {} components for {} rows", array.name, array.size(),
                                array.components, rows));
    arrays.push_back(std::move(array));
  }
  return arrays;
}

/// Reads the cells of a piece; remembers for every new cell the file's cell it comes from.
class Cells {
 public:
  Cells(const Document& document, const pugi::xml_node& piece, Record& data)
      : document_(document), piece_(piece), data_(data) {
    each("Verts", "NumberOfVerts", [&](std::span<const std::uint32_t> corners) {
      for (std::uint32_t corner : corners) add({&corner, 1});
    });
    each("Lines", "NumberOfLines", [&](std::span<const std::uint32_t> corners) {
      if (corners.size() == 1) add(corners);
      for (std::size_t c = 1; c < corners.size(); ++c) add(corners.subspan(c - 1, 2));
    });
    // VTK counts the rows of cell data in the order verts, lines, polys, strips.
    each("Polys", "NumberOfPolys", [&](std::span<const std::uint32_t> corners) {
      if (corners.empty()) document_.fail("a polygon has no corners");
      add(corners);
    });
    each("Strips", "NumberOfStrips", [&](std::span<const std::uint32_t> corners) {
      if (corners.size() == 1 || corners.size() == 2) add(corners);
      for (std::size_t c = 2; c < corners.size(); ++c) {
        // Every second triangle of a strip runs the other way round.
        const std::array<std::uint32_t, 3> triangle{corners[c - 2], corners[c % 2 ? c : c - 1],
                                                    corners[c % 2 ? c - 1 : c]};
        add(triangle);
      }
    });
  }

  std::size_t count() const { return count_; }

  /// For every cell of the Record, its row in the file.
  std::vector<std::size_t> rows() const {
    std::vector<std::size_t> all = vert_rows_;
    all.insert(all.end(), line_rows_.begin(), line_rows_.end());
    all.insert(all.end(), poly_rows_.begin(), poly_rows_.end());
    return all;
  }

 private:
  void add(std::span<const std::uint32_t> corners) {
    add_cell(data_, corners, document_.name);
    (corners.size() == 1 ? vert_rows_ : corners.size() == 2 ? line_rows_ : poly_rows_).push_back(count_);
  }

  void each(const char* kind, const char* counter, const auto& visit) {
    const unsigned long long cells = piece_.attribute(counter).as_ullong();
    if (cells == 0) return;
    const pugi::xml_node section = piece_.child(kind);
    const std::vector<std::int64_t> corners = integers(document_, required_array(document_, section, "connectivity"));
    const std::vector<std::int64_t> ends = integers(document_, required_array(document_, section, "offsets"));
    if (ends.size() != cells) document_.fail(fmt::format("'{}' has {} offsets for {} cells", kind, ends.size(), cells));
    std::vector<std::uint32_t> cell;
    std::int64_t begin = 0;
    for (std::int64_t end : ends) {
      if (end < begin || end > static_cast<std::int64_t>(corners.size()))
        document_.fail(fmt::format("'{}' has an offset {} after {} with {} corners", kind, end, begin, corners.size()));
      cell.clear();
      for (; begin < end; ++begin) {
        const std::int64_t corner = corners[static_cast<std::size_t>(begin)];
        if (corner < 0 || corner >= static_cast<std::int64_t>(data_.points.size()))
          document_.fail(fmt::format("'{}' refers to point {} of {}", kind, corner, data_.points.size()));
        cell.push_back(static_cast<std::uint32_t>(corner));
      }
      visit(std::span<const std::uint32_t>(cell));
      ++count_;
    }
  }

  const Document& document_;
  const pugi::xml_node& piece_;
  Record& data_;
  std::size_t count_ = 0;
  std::vector<std::size_t> vert_rows_, line_rows_, poly_rows_;
};

Record read_piece(const Document& document, const pugi::xml_node& piece) {
  Record data;
  const unsigned long long points = piece.attribute("NumberOfPoints").as_ullong();
  if (points > 0) {
    const std::vector<double> coordinates = required_array(document, piece.child("Points"), "").numbers();
    if (coordinates.size() % 3 != 0 || coordinates.size() / 3 != points || points > 0xFFFFFFFE)
      document.fail(fmt::format("there are {} coordinates for {} points", coordinates.size(), points));
    data.points.reserve(points);
    for (std::size_t i = 0; i < coordinates.size(); i += 3) {
      data.points.emplace_back(coordinates[i], coordinates[i + 1], coordinates[i + 2]);
      if (!data.points.back().allFinite()) document.fail(fmt::format("a coordinate of point {} is not finite", i / 3));
    }
  }
  data.point_data = read_arrays(document, piece.child("PointData"), data.points.size());
  const Cells cells(document, piece, data);
  data.cell_data = read_arrays(document, piece.child("CellData"), cells.count());
  const std::vector<std::size_t> rows = cells.rows();
  for (DataArray& array : data.cell_data) gather(array, rows);
  return data;
}

/// Appends the rows of `more` to the arrays of the same name and type; drops the arrays that only one side has.
void join(std::vector<DataArray>& arrays, const std::vector<DataArray>& more) {
  std::vector<DataArray> joined;
  for (DataArray& array : arrays) {
    const DataArray* other = find_array(more, array.name);
    if (!other || other->components != array.components || other->values.index() != array.values.index()) continue;
    std::visit(
        [&](auto& values) {
          const auto& tail = std::get<std::decay_t<decltype(values)>>(other->values);
          values.insert(values.end(), tail.begin(), tail.end());
        },
        array.values);
    joined.push_back(std::move(array));
  }
  arrays = std::move(joined);
}

void append_piece(Record& data, const Record& piece, const std::string& name) {
  // Cell rows are grouped by kind over both.
  std::vector<std::size_t> rows;
  const auto take = [&](std::size_t begin, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) rows.push_back(begin + i);
  };
  const std::size_t verts = data.verts.size(), lines = data.lines.size(), cells = data.cell_count();
  take(0, verts);
  take(cells, piece.verts.size());
  take(verts, lines);
  take(cells + piece.verts.size(), piece.lines.size());
  take(verts + lines, data.poly_count());
  take(cells + piece.verts.size() + piece.lines.size(), piece.poly_count());
  join(data.point_data, piece.point_data);
  join(data.cell_data, piece.cell_data);
  for (DataArray& array : data.cell_data) gather(array, rows);

  if (data.points.size() + piece.points.size() > 0xFFFFFFFE)
    throw Error(ErrorCode::input, fmt::format("'{}' has more than 4,294,967,294 points", name));
  const auto shift = static_cast<std::uint32_t>(data.points.size());
  data.points.insert(data.points.end(), piece.points.begin(), piece.points.end());
  for (std::uint32_t v : piece.verts) data.verts.push_back(v + shift);
  for (const auto& line : piece.lines) data.lines.push_back({line[0] + shift, line[1] + shift});
  std::vector<std::uint32_t> corners;
  for (std::size_t p = 0; p < piece.poly_count(); ++p) {
    corners.clear();
    for (std::uint32_t c = piece.poly_offsets[p]; c < piece.poly_offsets[p + 1]; ++c)
      corners.push_back(piece.poly_corners[c] + shift);
    add_cell(data, corners, name);
  }
}

}  // namespace

Record read_vtp(const FileText& file) {
  Document document;
  load(file, document);
  const pugi::xml_node root = document.xml.child("VTKFile").child("PolyData");
  if (!root) document.fail("the element PolyData is missing");
  Record data;
  bool first = true;
  for (const pugi::xml_node& piece : root.children("Piece")) {
    Record read = read_piece(document, piece);
    if (first)
      data = std::move(read);
    else if (!read.points.empty())
      append_piece(data, read, file.name);
    first = false;
  }
  if (first) document.fail("there is no Piece: the file is empty");
  for (const pugi::xml_node& node : root.child("FieldData").children()) {
    DataArray array;
    if (!read_array(document, node, array)) continue;
    if (array.size() % static_cast<std::size_t>(array.components) != 0)
      document.fail(fmt::format("the array '{}' has incomplete rows", array.name));
    data.field_data.push_back(std::move(array));
  }
  return data;
}

}  // namespace quench::io
