// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>

#include "io/common/text_out.h"
#include "io/graph/line_format.h"

/// Lines as GeoJSON (RFC 7946).
namespace quench::io {
namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr std::string_view kOwnProperties[] = {"feature",     "feature_id", "branch",     "from",      "to",
                                               "from_kind",   "to_kind",    "kind",       "length",    "radius",
                                               "mean_radius", "min_radius", "max_radius", "thickness", "tortuosity"};

/// JSON has no infinity.
std::string json_number(double value) { return std::isfinite(value) ? fmt::format("{}", value) : "null"; }

std::string json_text(const OrderedJson& value) {
  return value.dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
}

class GeoJsonLines : public LineFormat {
 public:
  GeoJsonLines(std::ostream& out, bool collection) : text_(out), collection_(collection) {}

  void append(const PlaneLines& lines) override {
    const std::string common = common_properties(lines);
    const auto& nodes = lines.graph.nodes;
    for (std::size_t b = 0; b < lines.graph.branches.size(); ++b) {
      const CurveGraph::Branch& branch = lines.graph.branches[b];
      begin_feature();
      text_.print(R"({{"type":"Feature","geometry":{{"type":"LineString","coordinates":[)");
      const char* before = "";
      for (const Vec3& p : branch.points) text_.print("{}[{},{}]", std::exchange(before, ","), p[0], p[1]);
      text_.print(R"(]}},"properties":{{{}"branch":{},"from":{},"to":{},"from_kind":"{}","to_kind":"{}")", common, b,
                  branch.from, branch.to, name_of(nodes[branch.from].kind), name_of(nodes[branch.to].kind));
      const std::pair<const char*, double> measures[] = {
          {"length", branch.length},         {"mean_radius", branch.mean_radius}, {"min_radius", branch.min_radius},
          {"max_radius", branch.max_radius}, {"thickness", branch.thickness},     {"tortuosity", branch.tortuosity}};
      for (const auto& [name, value] : measures) text_.print(R"(,"{}":{})", name, json_number(value));
      print_array("radius", branch.radius);
      for (const auto& array : lines.arrays) print_array(array.name, array.values.at(b));
      text_.print("}}}}");
    }
    for (const Polygons& part : parts_of(lines.wide)) {
      begin_feature();
      text_.print(R"({{"type":"Feature","geometry":{{"type":"Polygon","coordinates":[)");
      const char* next = "";
      for (const auto& ring : part.rings) {
        text_.print("{}[", std::exchange(next, ","));
        for (const Vec2& p : ring) text_.print("[{},{}],", p[0], p[1]);
        text_.print("[{},{}]]", ring[0][0], ring[0][1]);
      }
      text_.print(R"(]}},"properties":{{{}"kind":"wide"}}}})", common);
    }
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      if (nodes[n].kind != CurveGraph::NodeKind::isolated) continue;
      begin_feature();
      text_.print(R"({{"type":"Feature","geometry":{{"type":"Point","coordinates":[{},{}]}},)", nodes[n].point[0],
                  nodes[n].point[1]);
      text_.print(R"("properties":{{{}"from":{},"kind":"isolated","radius":{}}}}})", common, n,
                  json_number(nodes[n].radius));
    }
  }

  void finish() override {
    if (collection_ && !begun_) text_.print("{}", kHead);
    text_.print("{}", collection_ ? "\n]}\n" : begun_ ? "\n" : "");
    text_.flush();
  }

 private:
  static constexpr const char* kHead = "{\"type\":\"FeatureCollection\",\"features\":[";

  void begin_feature() {
    if (collection_)
      text_.print("{}\n", begun_ ? "," : kHead);
    else if (begun_)
      text_.print("\n");
    begun_ = true;
  }

  void print_array(const std::string& name, const std::vector<double>& values) {
    text_.print(",{}:[", json_text(name));
    const char* before = "";
    for (const double value : values) text_.print("{}{}", std::exchange(before, ","), json_number(value));
    text_.print("]");
  }

  /// What all features of a shape have, with a comma behind each.
  static std::string common_properties(const PlaneLines& lines) {
    std::string text;
    const auto add = [&](const std::string& name, const std::string& value) {
      text += json_text(name) + ":" + value + ",";
    };
    if (!lines.properties.empty()) {
      const OrderedJson carried = OrderedJson::parse(lines.properties, nullptr, false);
      if (!carried.is_object()) throw Error(ErrorCode::input, "the properties of a polygon are not an object of JSON");
      const auto taken = [&](const std::string& name) {
        return std::find(std::begin(kOwnProperties), std::end(kOwnProperties), name) != std::end(kOwnProperties) ||
               std::any_of(lines.arrays.begin(), lines.arrays.end(), [&](const auto& a) { return a.name == name; });
      };
      for (const auto& [name, value] : carried.items()) {
        std::string own = name;
        while (own != name ? carried.contains(own) : taken(own)) own = "polygon_" + own;
        add(own, json_text(value));
      }
    }
    if (lines.number) add("feature", fmt::format("{}", *lines.number));
    if (!lines.id.empty()) add("feature_id", lines.id);
    return text;
  }

  TextOut text_;
  bool collection_, begun_ = false;
};

}  // namespace

std::unique_ptr<LineFormat> geojson_lines(std::ostream& out, bool collection) {
  return std::make_unique<GeoJsonLines>(out, collection);
}

}  // namespace quench::io
