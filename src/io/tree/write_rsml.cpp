// SPDX-License-Identifier: Apache-2.0
#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <optional>

#include "io/common/words.h"
#include "io/tree/rsml.h"
#include "io/tree/tree_samples.h"
#include "quench/error.h"
#include "quench/io.h"

namespace quench::io {
namespace {

/// XML has no control characters, and UTF-8 is not checked: text of a file was UTF-8 when it was read.
std::string xml_safe(std::string text) {
  std::erase_if(text, [](char c) { return static_cast<unsigned char>(c) < ' ' && c != '\t' && c != '\n'; });
  return text;
}

/// Names of columns are names of elements but for characters that cannot be in one.
std::string element_name(const std::string& column) {
  std::string name;
  for (const char c : column)
    name += std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-' || c == '.' ? c : '_';
  return name.empty() || (std::isalpha(static_cast<unsigned char>(name[0])) == 0 && name[0] != '_') ? '_' + name : name;
}

class RsmlWriter {
 public:
  RsmlWriter(const Tree& tree, const Table* axes) : tree_(tree), traits_(axes) {
    rsml_ = put_foreign(document_, tree.foreign, "rsml");
    write_metadata();
    pugi::xml_node scene = rsml_child(rsml_, "scene");
    if (!scene) scene = rsml_.append_child("scene");
    has_z_ = std::ranges::any_of(tree.axes, [](const Tree::Axis& axis) {
      return std::ranges::any_of(axis.points, [](const Vec3& p) { return p[2] != 0; });
    });
    std::vector<pugi::xml_node> plants, roots;
    for (std::size_t p = 0; p < tree.plants.size(); ++p) {
      plants.push_back(put_foreign(scene, tree.plants[p].foreign, "plant"));
      name_element(plants.back(), p + 1, tree.plants[p].label);
    }
    for (std::size_t a = 0; a < tree.axes.size(); ++a) {
      const Tree::Axis& axis = tree.axes[a];
      const pugi::xml_node parent = axis.parent == kNone ? plants[axis.plant] : roots[axis.parent];
      roots.push_back(put_foreign(parent, axis.foreign, "root"));
      name_element(roots.back(), a, axis.label);
      write_axis(roots.back(), a);
    }
  }

  void write(std::ostream& out) const { document_.save(out, "  ", pugi::format_default, pugi::encoding_utf8); }

 private:
  /// The element a file had, or an empty one.
  static pugi::xml_node put_foreign(pugi::xml_node parent, const std::string& foreign, const char* name) {
    pugi::xml_document document;
    if (!foreign.empty() && document.load_buffer(foreign.data(), foreign.size()) &&
        rsml_is(document.document_element(), name))
      return parent.append_copy(document.document_element());
    return parent.append_child(name);
  }

  static void name_element(pugi::xml_node node, std::size_t id, const std::string& label) {
    if (!rsml_attribute(node, "id")) node.append_attribute("id") = static_cast<unsigned long long>(id);
    if (!label.empty() && !rsml_attribute(node, "label")) node.append_attribute("label") = xml_safe(label).c_str();
  }

  static pugi::xml_node made(pugi::xml_node parent, const char* name) {
    const pugi::xml_node node = rsml_child(parent, name);
    return node ? node : parent.append_child(name);
  }

  void write_metadata() {
    pugi::xml_node metadata = rsml_child(rsml_, "metadata");
    if (!metadata) metadata = rsml_.prepend_child("metadata");
    const auto say = [&](const char* name, const std::string& text, bool anew) {
      pugi::xml_node node = rsml_child(metadata, name);
      if (node && !anew) return;
      if (!node) node = metadata.append_child(name);
      node.remove_children();
      if (!text.empty()) node.text() = xml_safe(text).c_str();
    };
    const std::string known = rsml_value_of(rsml_child(metadata, kRsmlResolution));
    if (double value = 0; parse_number(known, value) && value > 0) resolution_ = value;
    say("version", "1", false);
    say("unit", tree_.coordinates.units, true);
    say(kRsmlResolution, "1", false);
    if (const std::optional<std::string> time = build_time())
      say("last-modified", *time, true);
    else
      metadata.remove_child(rsml_child(metadata, "last-modified"));  // it was true of another file
    say("software", fmt::format("Quench {}", QUENCH_VERSION), true);
    say("user", "", false);
    say("file-key", fmt::format("quench-{:016x}", fingerprint()), true);
    definitions_ = made(metadata, "property-definitions");
    define(kParentNode, "integer", "");
    define("level", "integer", "");
    define("length", "real", tree_.coordinates.units);
    if (std::ranges::any_of(tree_.branches, [](const Tree::Branch& branch) { return branch.type > 0; }))
      define(kRsmlSwcType, "integer", "");
    if (!traits_) return;
    for (const Table::Column& column : traits_->columns) {
      const std::size_t kind = column.values.index();
      define(element_name(column.name).c_str(), kind == 0 ? "real" : kind == 1 ? "integer" : "string", column.unit);
    }
  }

  void define(const char* label, const char* type, const std::string& unit) {
    for (const pugi::xml_node& known : definitions_.children())
      if (rsml_value_of(rsml_child(known, "label")) == label) return;
    pugi::xml_node definition = definitions_.append_child("property-definition");
    definition.append_child("label").text() = label;
    definition.append_child("type").text() = type;
    if (!unit.empty()) definition.append_child("unit").text() = xml_safe(unit).c_str();
  }

  /// The time that reproducible builds take for now (https://reproducible-builds.org/specs/source-date-epoch).
  static std::optional<std::string> build_time() {
    const char* text = std::getenv("SOURCE_DATE_EPOCH");
    std::int64_t seconds = 0;
    constexpr std::int64_t kEndOf9999 = 253402300799;
    if (!text || !parse_integer(text, seconds) || seconds < 0 || seconds > kEndOf9999) return {};
    return fmt::format("{:%Y-%m-%dT%H:%M:%S}", fmt::gmtime(static_cast<std::time_t>(seconds)));
  }

  /// FNV-1a of all courses: the same tree has the same key.
  std::uint64_t fingerprint() const {
    std::uint64_t hash = 0xcbf29ce484222325;
    for (const Tree::Axis& axis : tree_.axes)
      for (const Vec3& point : axis.points)
        for (int a = 0; a < 3; ++a) {
          unsigned char bytes[sizeof(double)];
          std::memcpy(bytes, &point[a], sizeof bytes);
          for (const unsigned char byte : bytes) hash = (hash ^ byte) * 0x100000001b3;
        }
    return hash;
  }

  void write_axis(pugi::xml_node root, std::size_t a) {
    const Tree::Axis& axis = tree_.axes[a];
    pugi::xml_node geometry = rsml_child(root, "geometry");
    if (!geometry) geometry = root.prepend_child("geometry");
    pugi::xml_node polyline = geometry.prepend_child("polyline");
    double length = 0;
    for (std::size_t i = 0; i < axis.points.size(); ++i) {
      if (i > 0) length += (axis.points[i] - axis.points[i - 1]).norm();
      pugi::xml_node point = polyline.append_child("point");
      for (int c = 0; c < (has_z_ ? 3 : 2); ++c)
        point.append_attribute(c == 0 ? "x" : c == 1 ? "y" : "z") = text_of_number(axis.points[i][c]).c_str();
    }
    pugi::xml_node properties = rsml_child(root, "properties");
    if (!properties) properties = root.insert_child_after("properties", geometry);
    const auto set = [&](const char* name, const std::string& value) {
      pugi::xml_node node = rsml_child(properties, name);
      if (!node) node = properties.append_child(name);
      if (!rsml_attribute(node, "value")) node.append_attribute("value");
      rsml_attribute(node, "value") = xml_safe(value).c_str();
    };
    if (axis.parent != kNone) set(kParentNode, fmt::format("{}", node_of_parent(a) + 1));
    set("level", fmt::format("{}", axis.level));
    set("length", fmt::format("{}", length));
    if (const int type = type_of(axis); type > 0) set(kRsmlSwcType, fmt::format("{}", type));
    if (traits_)
      for (const Table::Column& column : traits_->columns)
        if (const std::string value = text_of_value(column, a); !value.empty())
          set(element_name(column.name).c_str(), value);
    write_functions(root, axis);
  }

  std::string text_of_number(double value) const { return fmt::format("{}", value * resolution_); }

  static std::string text_of_value(const Table::Column& column, std::size_t row) {
    return std::visit(
        [&](const auto& values) {
          if constexpr (std::is_same_v<std::decay_t<decltype(values)>, std::vector<double>>)
            if (!std::isfinite(values[row])) return std::string();
          return fmt::format("{}", values[row]);
        },
        column.values);
  }

  int type_of(const Tree::Axis& axis) const {
    const int type = axis.branches.empty() ? 0 : tree_.branches[axis.branches.front()].type;
    const bool one = std::ranges::all_of(axis.branches, [&](auto b) { return tree_.branches[b].type == type; });
    return one ? type : 0;
  }

  /// The point of its parent's course nearest to where an axis begins, along the course.
  std::size_t node_of_parent(std::size_t a) const {
    const Tree::Axis& axis = tree_.axes[a];
    const std::vector<Vec3>& points = tree_.axes[axis.parent].points;
    std::size_t node = 0;
    double length = 0, least = std::abs(axis.position);
    for (std::size_t i = 1; i < points.size(); ++i) {
      length += (points[i] - points[i - 1]).norm();
      if (const double distance = std::abs(length - axis.position); distance < least) {
        least = distance;
        node = i;
      }
    }
    return node;
  }

  /// Per point of the course whether the segment before it is a bridge. Courses and branches end at the same point, but
  /// a course may begin later, where it is clear of its parent's tube.
  std::vector<std::uint8_t> bridged_points(const Tree::Axis& axis) const {
    std::vector<std::uint8_t> flags(axis.points.size(), 0);
    std::size_t next = flags.size();
    for (auto b = axis.branches.rbegin(); b != axis.branches.rend(); ++b) {
      const Tree::Branch& branch = tree_.branches[*b];
      for (std::size_t i = branch.points.size() - 1; i-- > 0 && next > 1;)
        flags[--next] = branch.bridged.empty() ? 0 : branch.bridged[i];
    }
    return flags;
  }

  void write_functions(pugi::xml_node root, const Tree::Axis& axis) {
    const std::vector<std::uint8_t> bridged = bridged_points(axis);
    const bool gaps = std::ranges::find(bridged, 1) != bridged.end();
    const bool thick = std::ranges::any_of(axis.radius, [](double radius) { return radius > 0; });
    if (!gaps && !thick) return;
    pugi::xml_node functions = made(root, "functions");
    const auto add = [&](const char* name, std::size_t count, const auto& value_of) {
      pugi::xml_node function = functions.append_child("function");
      function.append_attribute("domain") = "polyline";
      function.append_attribute("name") = name;
      for (std::size_t i = 0; i < count; ++i)
        function.append_child("sample").append_attribute("value") = fmt::format("{}", value_of(i)).c_str();
    };
    if (thick) add("diameter", axis.radius.size(), [&](std::size_t i) { return 2 * axis.radius[i] * resolution_; });
    if (gaps) add(kRsmlBridged, bridged.size(), [&](std::size_t i) { return static_cast<int>(bridged[i]); });
  }

  static constexpr const char* kParentNode = "parent-node";

  const Tree& tree_;
  const Table* traits_;
  pugi::xml_document document_;
  pugi::xml_node rsml_, definitions_;
  double resolution_ = 1;
  bool has_z_ = false;
};

}  // namespace

void write_rsml(const std::filesystem::path& file, const Tree& tree, const Table* axes) {
  require_axes(tree, "RSML");
  if (axes && axes->rows != tree.axes.size())
    throw Error(ErrorCode::usage,
                fmt::format("a table of {} rows is not that of {} axes", axes->rows, tree.axes.size()));
  const RsmlWriter writer(tree, axes);
  write_atomically(file, [&](std::ostream& out) { writer.write(out); });
}

}  // namespace quench::io
