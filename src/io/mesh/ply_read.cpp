// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>

#include "base/text.h"
#include "io/common/formats.h"
#include "io/common/words.h"

/// Stanford PLY: a header that names elements and their properties, then the elements as text or as binary numbers of
/// either byte order.
///
/// Used: `vertex` (x, y, z; other properties become point arrays), `face` (the list vertex_indices or vertex_index) and
/// `edge` (vertex1, vertex2), whose other properties become cell arrays. Other lists and elements are skipped.
namespace quench::io {
namespace {

enum class Type { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

struct TypeName {
  std::string_view name;
  Type type;
};
constexpr TypeName kTypeNames[] = {
    {"char", Type::int8},     {"int8", Type::int8},       {"uchar", Type::uint8},    {"uint8", Type::uint8},
    {"short", Type::int16},   {"int16", Type::int16},     {"ushort", Type::uint16},  {"uint16", Type::uint16},
    {"int", Type::int32},     {"int32", Type::int32},     {"uint", Type::uint32},    {"uint32", Type::uint32},
    {"float", Type::float32}, {"float32", Type::float32}, {"double", Type::float64}, {"float64", Type::float64}};

std::size_t size_of(Type type) {
  constexpr std::size_t kSizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

struct Property {
  std::string name;
  Type type = Type::int8;
  std::optional<Type> count_type;  ///< of a list; nothing for a single number
};

struct Element {
  std::string name;
  std::size_t count = 0;
  std::vector<Property> properties;
};

enum class Encoding { text, little, big };

struct Header {
  Encoding encoding = Encoding::text;
  std::vector<Element> elements;
  std::size_t body = 0;       ///< byte at which the elements begin
  std::size_t body_line = 1;  ///< and its line
};

Type read_type(Words& words) {
  const std::string_view word = words.next_on_line();
  for (const TypeName& known : kTypeNames)
    if (known.name == word) return known.type;
  words.fail(fmt::format("'{}' is not a type of PLY properties", word.substr(0, 40)));
}

Property read_property(Words& words) {
  Property property;
  const Words before = words;
  if (words.next_on_line() == "list")
    property.count_type = read_type(words);
  else
    words = before;
  property.type = read_type(words);
  property.name = words.next_on_line();
  if (property.name.empty()) words.fail("a property has no name");
  return property;
}

Header read_header(const FileText& file) {
  Words words(file.bytes, file.name, {.comment = '\0'});
  if (words.next() != "ply") words.fail("a PLY file begins with 'ply'");
  Header header;
  bool format_known = false;
  while (words.next_line()) {
    const std::string_view keyword = words.next_on_line();
    if (keyword == "format") {
      const std::string_view name = words.next_on_line();
      if (name == "ascii")
        header.encoding = Encoding::text;
      else if (name == "binary_little_endian")
        header.encoding = Encoding::little;
      else if (name == "binary_big_endian")
        header.encoding = Encoding::big;
      else
        words.fail("the format is not one of ascii, binary_little_endian and binary_big_endian");
      format_known = true;
    } else if (keyword == "element") {
      Element element;
      element.name = words.next_on_line();
      const std::int64_t count = words.integer_on_line("the number of elements");
      if (count < 0) words.fail("the number of elements is negative");
      element.count = static_cast<std::size_t>(count);
      for (const Element& other : header.elements)
        if (other.name == element.name) words.fail(fmt::format("there are two elements '{}'", element.name));
      header.elements.push_back(std::move(element));
    } else if (keyword == "property") {
      if (header.elements.empty()) words.fail("a property comes before the first element");
      Property property = read_property(words);
      auto& properties = header.elements.back().properties;
      for (const Property& other : properties)
        if (other.name == property.name) words.fail(fmt::format("there are two properties '{}'", property.name));
      properties.push_back(std::move(property));
    } else if (keyword == "end_header") {
      if (!format_known) words.fail("the header does not give the format");
      words.rest_of_line();
      header.body = words.position();
      header.body_line = words.line();
      return header;
    } else if (keyword != "comment" && keyword != "obj_info") {
      words.fail("a header line does not begin with format, comment, obj_info, element, property or end_header");
    }
  }
  words.fail("the file ends in its header");
}

/// The numbers after the header, one by one, in either encoding. Every number is exact in a double.
class Numbers {
 public:
  Numbers(const FileText& file, const Header& header)
      : file_(file),
        encoding_(header.encoding),
        words_(std::string_view(file.bytes).substr(header.body), file.name, {.comment = '\0'}, header.body_line),
        at_(header.body) {}

  double next(Type type) {
    if (encoding_ == Encoding::text) {
      const double value = words_.number("a value");
      check_range(type, value);
      return value;
    }
    const std::size_t size = size_of(type);
    if (remaining() < size) fail("the file ends early");
    std::array<char, 8> bytes{};
    std::memcpy(bytes.data(), file_.bytes.data() + at_, size);
    if (encoding_ == Encoding::big) std::reverse(bytes.data(), bytes.data() + size);
    at_ += size;
    switch (type) {
      case Type::int8:
        return as<std::int8_t>(bytes);
      case Type::uint8:
        return as<std::uint8_t>(bytes);
      case Type::int16:
        return as<std::int16_t>(bytes);
      case Type::uint16:
        return as<std::uint16_t>(bytes);
      case Type::int32:
        return as<std::int32_t>(bytes);
      case Type::uint32:
        return as<std::uint32_t>(bytes);
      case Type::float32:
        return static_cast<double>(as<float>(bytes));
      case Type::float64:
        break;
    }
    return as<double>(bytes);
  }

  std::size_t list_size(const Property& list) {
    const double size = next(*list.count_type);
    // Every member takes a byte at least, so a list cannot be longer than the rest of the file.
    if (!(size >= 0 && size <= static_cast<double>(remaining()) && size == std::floor(size)))
      fail(fmt::format("a list declares {} members", size));
    return static_cast<std::size_t>(size);
  }

  std::uint32_t vertex(Type type, std::size_t vertices) {
    const double index = next(type);
    if (!(index >= 0 && index < static_cast<double>(vertices) && index == std::floor(index)))
      fail(fmt::format("a corner refers to vertex {} of {} (the first is 0)", index, vertices));
    return static_cast<std::uint32_t>(index);
  }

  void pass_list(const Property& list) {
    for (std::size_t size = list_size(list); size > 0; --size) next(list.type);
  }

  std::size_t remaining() const { return encoding_ == Encoding::text ? words_.remaining() : file_.bytes.size() - at_; }

  [[noreturn]] void fail(const std::string& what) const {
    if (encoding_ == Encoding::text) words_.fail(what);
    throw Error(ErrorCode::input, fmt::format("'{}', byte {}: {}", file_.name, at_, base::plain(what)));
  }

 private:
  template <class T>
  static T as(const std::array<char, 8>& bytes) {
    T value;
    std::memcpy(&value, bytes.data(), sizeof value);
    return value;
  }

  void check_range(Type type, double value) const {
    if (type == Type::float32 || type == Type::float64) return;
    constexpr double kLow[] = {-128, 0, -32768, 0, -2147483648.0, 0};
    constexpr double kHigh[] = {127, 255, 32767, 65535, 2147483647, 4294967295.0};
    const auto t = static_cast<std::size_t>(type);
    if (!(value >= kLow[t] && value <= kHigh[t] && value == std::floor(value)))
      fail(fmt::format("{} does not fit the type {} that the header gives", value, kTypeNames[2 * t].name));
  }

  const FileText& file_;
  Encoding encoding_;
  Words words_;
  std::size_t at_;
};

DataArray empty_array(const Property& property) {
  DataArray array{property.name, 1, {}};
  switch (property.type) {
    case Type::uint8:
      array.values = std::vector<std::uint8_t>();
      break;
    case Type::int8:
    case Type::int16:
    case Type::uint16:
    case Type::int32:
      array.values = std::vector<std::int32_t>();
      break;
    case Type::uint32:
      array.values = std::vector<std::int64_t>();
      break;
    case Type::float32:
      array.values = std::vector<float>();
      break;
    case Type::float64:
      array.values = std::vector<double>();
      break;
  }
  return array;
}

void append(DataArray& array, double value) {
  std::visit(
      [value](auto& values) {
        using T = typename std::decay_t<decltype(values)>::value_type;
        if constexpr (std::is_same_v<T, float>)
          values.push_back(std::isfinite(value) ? to_float(value) : static_cast<float>(value));
        else if constexpr (!std::is_same_v<T, std::string>)
          values.push_back(static_cast<T>(value));
      },
      array.values);
}

/// What to do with each property of an element: its role, or the array that keeps it, or nothing.
class Reader {
 public:
  Reader(const FileText& file, const Header& header) : header_(header), numbers_(file, header), name_(file.name) {
    for (const Element& element : header.elements)
      if (element.name == "vertex") vertices_ = element.count;
  }

  Record read() {
    bool has_vertices = false;
    for (const Element& element : header_.elements) {
      // A row of an element without properties takes no space, and there is nothing to read.
      if ((element.properties.empty() || element.count == 0) && element.name != "vertex") continue;
      if (element.count > numbers_.remaining())
        numbers_.fail(
            fmt::format("{} elements '{}' are declared, more than the file can hold; it is damaged or incomplete",
                        element.count, element.name));
      if (element.name == "tristrips") numbers_.fail("triangle strips are not supported; save it with faces");
      if (element.name == "vertex") {
        read_vertices(element);
        has_vertices = true;
      } else if (element.name == "face") {
        read_faces(element);
      } else if (element.name == "edge") {
        read_edges(element);
      } else {
        for (std::size_t i = 0; i < element.count; ++i)
          for (const Property& property : element.properties) pass(property);
      }
    }
    if (!has_vertices) throw Error(ErrorCode::input, fmt::format("'{}' has no element 'vertex'", name_));
    join_cell_arrays();
    return std::move(data_);
  }

 private:
  void pass(const Property& property) {
    if (property.count_type)
      numbers_.pass_list(property);
    else
      numbers_.next(property.type);
  }

  std::size_t position_of(const Element& element, std::initializer_list<std::string_view> names, bool list) {
    for (std::size_t p = 0; p < element.properties.size(); ++p)
      for (std::string_view name : names)
        if (element.properties[p].name == name && element.properties[p].count_type.has_value() == list) return p;
    throw Error(ErrorCode::input, fmt::format("'{}': the element '{}' has no {} '{}'", name_, base::plain(element.name),
                                              list ? "list" : "property", *names.begin()));
  }

  /// An array for every scalar property that has no other use; `array_of[p]` is its number or -1.
  std::vector<int> make_arrays(const Element& element, std::initializer_list<std::size_t> used,
                               std::vector<DataArray>& arrays) {
    std::vector<int> array_of(element.properties.size(), -1);
    for (std::size_t p = 0; p < element.properties.size(); ++p)
      if (!element.properties[p].count_type && std::find(used.begin(), used.end(), p) == used.end()) {
        array_of[p] = static_cast<int>(arrays.size());
        arrays.push_back(empty_array(element.properties[p]));
      }
    return array_of;
  }

  /// Reads a property that has no special use in its element.
  void keep(const Property& property, int array, std::vector<DataArray>& arrays) {
    if (array < 0)
      pass(property);
    else
      append(arrays[static_cast<std::size_t>(array)], numbers_.next(property.type));
  }

  void read_vertices(const Element& element) {
    const std::size_t x = position_of(element, {"x"}, false), y = position_of(element, {"y"}, false),
                      z = position_of(element, {"z"}, false);
    if (element.count > 0xFFFFFFFE) numbers_.fail("there are more than 4,294,967,294 vertices");
    const std::vector<int> array_of = make_arrays(element, {x, y, z}, data_.point_data);
    data_.points.reserve(element.count);
    for (std::size_t v = 0; v < element.count; ++v) {
      Vec3 point = Vec3::Zero();
      for (std::size_t p = 0; p < element.properties.size(); ++p) {
        if (p != x && p != y && p != z) {
          keep(element.properties[p], array_of[p], data_.point_data);
          continue;
        }
        const double value = numbers_.next(element.properties[p].type);
        if (!std::isfinite(value)) numbers_.fail(fmt::format("a coordinate of vertex {} is not finite", v));
        point[p == x ? 0 : p == y ? 1 : 2] = value;
      }
      data_.points.push_back(point);
    }
  }

  void read_faces(const Element& element) {
    const std::size_t list = position_of(element, {"vertex_indices", "vertex_index"}, true);
    const std::vector<int> array_of = make_arrays(element, {}, face_arrays_);
    std::vector<std::uint32_t> corners;
    for (std::size_t f = 0; f < element.count; ++f)
      for (std::size_t p = 0; p < element.properties.size(); ++p) {
        const Property& property = element.properties[p];
        if (p != list) {
          keep(property, array_of[p], face_arrays_);
          continue;
        }
        const std::size_t size = numbers_.list_size(property);
        if (size == 0) numbers_.fail(fmt::format("face {} has no corners", f));
        corners.clear();
        for (std::size_t c = 0; c < size; ++c) corners.push_back(numbers_.vertex(property.type, vertices_));
        add_cell(data_, corners, name_);
        (size == 1 ? vert_rows_ : size == 2 ? line_rows_ : poly_rows_).push_back({false, f});
      }
  }

  void read_edges(const Element& element) {
    const std::size_t a = position_of(element, {"vertex1"}, false), b = position_of(element, {"vertex2"}, false);
    const std::vector<int> array_of = make_arrays(element, {a, b}, edge_arrays_);
    for (std::size_t e = 0; e < element.count; ++e) {
      std::array<std::uint32_t, 2> ends{};
      for (std::size_t p = 0; p < element.properties.size(); ++p) {
        if (p == a || p == b)
          ends[p == b] = numbers_.vertex(element.properties[p].type, vertices_);
        else
          keep(element.properties[p], array_of[p], edge_arrays_);
      }
      data_.lines.push_back(ends);
      line_rows_.push_back({true, e});
    }
  }

  /// The edge or face of the file that a cell comes from.
  struct Row {
    bool edge;
    std::size_t number;
  };

  /// Cell arrays have a row for each cell: what only edges or only faces have is 0 for the others.
  void join_cell_arrays() {
    std::vector<Row> rows = std::move(vert_rows_);
    rows.insert(rows.end(), line_rows_.begin(), line_rows_.end());
    rows.insert(rows.end(), poly_rows_.begin(), poly_rows_.end());
    for (DataArray& edge : edge_arrays_) {
      DataArray* face = nullptr;
      for (DataArray& other : face_arrays_)
        if (other.name == edge.name) face = &other;
      if (face && face->values.index() != edge.values.index()) {
        edge.values = edge.numbers();
        face->values = face->numbers();
      }
      data_.cell_data.push_back(joined(rows, &edge, face));
    }
    for (const DataArray& face : face_arrays_)
      if (!find_array(edge_arrays_, face.name)) data_.cell_data.push_back(joined(rows, nullptr, &face));
  }

  /// The cell array made of an array of edges and one of faces of the same type; one of them may be missing.
  static DataArray joined(const std::vector<Row>& rows, const DataArray* edge, const DataArray* face) {
    const DataArray& one = edge ? *edge : *face;
    DataArray result{one.name, 1, {}};
    std::visit(
        [&](const auto& like) {
          using Values = std::decay_t<decltype(like)>;
          Values values;
          values.reserve(rows.size());
          for (const Row& row : rows)
            if (const DataArray* from = row.edge ? edge : face)
              values.push_back(std::get<Values>(from->values)[row.number]);
            else
              values.emplace_back();
          result.values = std::move(values);
        },
        one.values);
    return result;
  }

  const Header& header_;
  Numbers numbers_;
  const std::string& name_;
  std::size_t vertices_ = 0;
  Record data_;
  std::vector<DataArray> edge_arrays_, face_arrays_;
  std::vector<Row> vert_rows_, line_rows_, poly_rows_;
};

}  // namespace

Record read_ply(const FileText& file) {
  const Header header = read_header(file);
  Record data = Reader(file, header).read();
  if (find_array(data.point_data, "radius")) add_isolated_points(data);  // a medial axis; scans have stray vertices
  return data;
}

}  // namespace quench::io
