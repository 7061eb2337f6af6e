// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ostream>
#include <pugixml.hpp>
#include <sstream>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

#include "io/mesh/vtp_blocks.h"
#include "quench/record.h"

namespace quench::io {

template <class T>
const char* vtk_type_name() {
  if constexpr (std::is_same_v<T, double>)
    return "Float64";
  else if constexpr (std::is_same_v<T, float>)
    return "Float32";
  else if constexpr (std::is_same_v<T, std::int64_t>)
    return "Int64";
  else if constexpr (std::is_same_v<T, std::int32_t>)
    return "Int32";
  else if constexpr (std::is_same_v<T, std::uint8_t>)
    return "UInt8";
  else
    return "String";
}

/// A VTK XML file: the XML so far, and the bytes of the arrays it refers to.
class VtkXml {
 public:
  /// `type`: that of the data, e.g. "PolyData".
  explicit VtkXml(const char* type) {
    file_ = document_.append_child("VTKFile");
    file_.append_attribute("type") = type;
    file_.append_attribute("version") = "1.0";
    file_.append_attribute("byte_order") = "LittleEndian";
    file_.append_attribute("header_type") = "UInt64";
    file_.append_attribute("compressor") = "vtkZLibDataCompressor";
  }

  pugi::xml_node root() { return file_; }

  template <class T>
  void array(pugi::xml_node parent, const std::string& name, int components, const std::vector<T>& values,
             bool field = false) {
    constexpr bool kText = std::is_same_v<T, std::string>;
    pugi::xml_node node = parent.append_child(kText ? "Array" : "DataArray");
    node.append_attribute("type") = vtk_type_name<T>();
    node.append_attribute("Name") = name.c_str();
    if (components != 1 || !kText) node.append_attribute("NumberOfComponents") = components;
    if (field)
      node.append_attribute("NumberOfTuples") =
          static_cast<unsigned long long>(values.size() / static_cast<std::size_t>(components));
    node.append_attribute("format") = "appended";
    node.append_attribute("offset") = static_cast<unsigned long long>(appended_.size());
    if constexpr (kText) {
      // Strings end with a zero byte, so none can hold one.
      std::string joined;
      for (const std::string& value : values) joined.append(value.c_str()).push_back('\0');
      appended_ += encode_blocks(joined);
    } else {
      appended_ += encode_blocks({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)});
    }
  }

  void array(pugi::xml_node parent, const DataArray& data, bool field = false) {
    std::visit([&](const auto& values) { array(parent, data.name, data.components, values, field); }, data.values);
  }

  /// The field data, and the one piece of a data set.
  pugi::xml_node begin_piece(pugi::xml_node set, const Record& data) {
    if (!data.field_data.empty()) {
      const pugi::xml_node field = set.append_child("FieldData");
      for (const DataArray& values : data.field_data) array(field, values, true);
    }
    return set.append_child("Piece");
  }
  void point_data(pugi::xml_node piece, const Record& data) {
    pugi::xml_node node = piece.append_child("PointData");
    if (find_array(data.point_data, "radius")) node.append_attribute("Scalars") = "radius";
    for (const DataArray& values : data.point_data) array(node, values);
  }
  void points(pugi::xml_node piece, const Record& data) {
    std::vector<double> coordinates;
    coordinates.reserve(3 * data.points.size());
    for (const Vec3& p : data.points) coordinates.insert(coordinates.end(), {p[0], p[1], p[2]});
    array(piece.append_child("Points"), "Points", 3, coordinates);
  }

  void write(std::ostream& out) const {
    std::ostringstream xml;
    document_.save(xml, "  ", pugi::format_default, pugi::encoding_utf8);
    std::string text = xml.str();
    text.erase(text.rfind("</VTKFile>"));
    out << text << "  <AppendedData encoding=\"raw\">\n_";
    out.write(appended_.data(), static_cast<std::streamsize>(appended_.size()));
    out << "\n  </AppendedData>\n</VTKFile>\n";
  }

 private:
  pugi::xml_document document_;
  pugi::xml_node file_;
  std::string appended_;
};

}  // namespace quench::io
