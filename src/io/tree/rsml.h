// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cctype>
#include <pugixml.hpp>
#include <string>
#include <string_view>

/// What reader and writer of RSML share.
namespace quench::io {

/// The length of a pixel of the file: points are in pixels, `resolution` says how many make a unit.
inline constexpr const char* kRsmlResolution = "resolution";
/// Our function along the polyline: 1 where the segment before a point is not in the file or shape it is from.
inline constexpr const char* kRsmlBridged = "bridged";
/// Our property: the structure identifier of SWC.
inline constexpr const char* kRsmlSwcType = "swc-type";

/// Elements nested deeper are refused: destroying a document of pugixml takes the stack.
inline constexpr int kRsmlDeepest = 1000;

/// In lower case, without the prefix of its namespace: dialects write Point, ID.
inline std::string rsml_plain_name(std::string_view name) {
  std::string result(name.substr(name.find(':') + 1));  // npos + 1 is 0
  std::ranges::transform(result, result.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return result;
}

inline bool rsml_is(const pugi::xml_node& node, std::string_view name) {
  return node.type() == pugi::node_element && rsml_plain_name(node.name()) == name;
}

inline pugi::xml_node rsml_child(const pugi::xml_node& node, std::string_view name) {
  return node.find_child([&](const pugi::xml_node& c) { return rsml_is(c, name); });
}

inline pugi::xml_attribute rsml_attribute(const pugi::xml_node& node, std::string_view name) {
  return node.find_attribute([&](const pugi::xml_attribute& a) { return rsml_plain_name(a.name()) == name; });
}

/// The attribute `value`, or the text.
inline std::string rsml_value_of(const pugi::xml_node& node) {
  const pugi::xml_attribute value = rsml_attribute(node, "value");
  std::string text = value ? value.value() : node.text().get();
  const auto first = text.find_first_not_of(" \t\r\n");
  return first == text.npos ? std::string() : text.substr(first, text.find_last_not_of(" \t\r\n") + 1 - first);
}

/// The element alone, as text.
inline std::string rsml_text_of(const pugi::xml_node& node) {
  struct Writer : pugi::xml_writer {
    std::string text;
    void write(const void* data, std::size_t size) override { text.append(static_cast<const char*>(data), size); }
  } writer;
  node.print(writer, "", pugi::format_raw);
  return writer.text;
}

}  // namespace quench::io
