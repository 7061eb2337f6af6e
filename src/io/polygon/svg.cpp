// SPDX-License-Identifier: Apache-2.0
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <pugixml.hpp>
#include <string_view>
#include <vector>

#include "base/text.h"
#include "io/common/words.h"
#include "io/polygon/polygon_formats.h"
#include "io/polygon/svg_path.h"

/// The filled shapes of a drawing: every path, polygon, polyline, rectangle, circle and ellipse is a feature, in
/// coordinates of the outermost svg element.
namespace quench::io {
namespace {

constexpr int kDeepestElement = 256;

/// What elements inherit.
struct Style {
  SvgTransform transform = SvgTransform::Identity();
  std::string fill = "black";
  PolygonFill rule = PolygonFill::nonzero;
  bool visible = true;
  std::optional<Vec2> viewport;  ///< what lengths in percent refer to: its sides in units of the user space
};

struct Box {
  Vec2 low, high;
};

/// The name of an element without the prefix of its namespace.
std::string_view local_name(const pugi::xml_node& node) {
  const std::string_view name = node.name();
  return name.substr(name.find(':') + 1);  // npos + 1 is 0
}

/// A property of an element: its `style` goes before an attribute. Empty: it has none.
std::string property(const pugi::xml_node& node, std::string_view name) {
  std::string value = node.attribute(std::string(name).c_str()).value();
  std::string_view style = node.attribute("style").value();
  const auto trimmed = [](std::string_view text) {
    const auto first = text.find_first_not_of(" \t\r\n");
    return first == text.npos ? std::string_view() : text.substr(first, text.find_last_not_of(" \t\r\n") + 1 - first);
  };
  while (!style.empty()) {
    const std::string_view declaration = style.substr(0, style.find(';'));
    style.remove_prefix(std::min(declaration.size() + 1, style.size()));
    const auto colon = declaration.find(':');
    if (colon != declaration.npos && trimmed(declaration.substr(0, colon)) == name)
      value = trimmed(declaration.substr(colon + 1));
  }
  return value;
}

class SvgReader {
 public:
  SvgReader(const FileText& file, double tolerance, FeatureSink& sink)
      : file_(file), tolerance_(tolerance), sink_(sink) {}

  void read() {
    const pugi::xml_parse_result parsed =
        xml_.load_buffer(file_.bytes.data(), file_.bytes.size(), pugi::parse_default, pugi::encoding_auto);
    if (!parsed)
      fail(fmt::format("the XML is incomplete or damaged at byte {}: {}", parsed.offset, parsed.description()));
    const pugi::xml_node root = xml_.document_element();
    if (local_name(root) != "svg") fail("this is not an SVG file");
    find_page(root);
    try {
      Style style = inherited(root, {});
      style.viewport = viewport_;
      visit_children(root, style, 0);
    } catch (const SvgDamage& damage) {  // of the root itself; others are told feature by feature
      fail(damage.reason);
    }
    hand_over();
    say_what_is_left_out();
  }

 private:
  struct Found {
    PolygonFeature feature;
    std::string problem;  ///< not empty: it cannot be used
    bool background = false;
  };

  [[noreturn]] void fail(const std::string& what) const {
    throw Error(ErrorCode::input, fmt::format("'{}': {}", file_.name, base::plain(what)));
  }

  /// What is seen of the drawing: its viewBox, or its width and height.
  void find_page(const pugi::xml_node& root) {
    try {
      if (const auto box = read_svg_numbers(root.attribute("viewBox").value()); box.size() == 4) {
        viewport_ = Vec2(box[2], box[3]);
        page_ = Box{{box[0], box[1]}, {box[0] + box[2], box[1] + box[3]}};
      } else if (root.attribute("width") && root.attribute("height")) {
        viewport_ = Vec2(length(root, "width", {}), length(root, "height", {}));
        page_ = Box{{0, 0}, *viewport_};
      }
    } catch (const SvgDamage&) {
      // e.g. 100%: nothing can be known to be its background
    }
  }

  static std::string fill_of(const pugi::xml_node& node, const Style& outer) {
    const std::string fill = property(node, "fill");
    return fill.empty() || fill == "inherit" ? outer.fill : fill;
  }

  Style inherited(const pugi::xml_node& node, Style style) const {
    style.transform = style.transform * read_svg_transform(node.attribute("transform").value());
    style.fill = fill_of(node, style);
    if (const std::string rule = property(node, "fill-rule"); rule == "evenodd" || rule == "nonzero")
      style.rule = rule == "evenodd" ? PolygonFill::evenodd : PolygonFill::nonzero;
    if (const std::string visibility = property(node, "visibility"); !visibility.empty() && visibility != "inherit")
      style.visible = visibility == "visible";
    return style;
  }

  void visit_children(const pugi::xml_node& parent, const Style& style, int depth) {
    if (depth > kDeepestElement) fail("elements are nested too deep");
    for (const pugi::xml_node node : parent.children())
      if (node.type() == pugi::node_element) visit(node, style, depth);
  }

  void visit(const pugi::xml_node& node, const Style& outer, int depth) {
    static constexpr std::string_view groups[] = {"g", "a", "svg", "switch"},
                                      shapes[] = {"path", "polygon", "polyline", "rect", "circle", "ellipse"},
                                      unread[] = {"use", "text", "image", "style", "foreignObject"};
    const auto among = [name = local_name(node)](const auto& names) {
      return std::find(std::begin(names), std::end(names), name) != std::end(names);
    };
    if (property(node, "display") == "none") return;
    if (among(unread)) ++unread_[std::string(local_name(node))];
    if (!among(groups) && !among(shapes)) return;
    for (const char* name : {"clip-path", "mask"})
      if (const std::string value = property(node, name); !value.empty() && value != "none") ++unread_[name];
    try {
      const Style style = inherited(node, outer);
      if (among(groups))
        visit_children(node, inner(node, style), depth + 1);
      else
        add_shape(node, style);
    } catch (const SvgDamage& damage) {
      found_.push_back({without_rings(node, fill_of(node, outer)),
                        fmt::format("of the element {}: {}", local_name(node), damage.reason), false});
    }
  }

  /// Of a nested svg element also its place, its sides and its viewBox.
  Style inner(const pugi::xml_node& node, Style style) const {
    if (local_name(node) != "svg") return style;
    style.transform.translate(Vec2(length(node, "x", style.viewport), length(node, "y", style.viewport)));
    const bool has_width = node.attribute("width"), has_height = node.attribute("height");
    if (!style.viewport && !(has_width && has_height)) return style;
    const Vec2 size(has_width ? length(node, "width", style.viewport) : (*style.viewport)[0],
                    has_height ? length(node, "height", style.viewport) : (*style.viewport)[1]);
    style.viewport = size;
    const auto box = read_svg_numbers(node.attribute("viewBox").value());
    if (box.size() != 4) return style;
    const Vec2 inside(box[2], box[3]);
    if (!(inside.minCoeff() > 0)) throw SvgDamage{"its viewBox has no area"};
    style.viewport = inside;
    const double scale = size.cwiseQuotient(inside).minCoeff();
    style.transform.translate(Vec2((size - scale * inside) / 2)).scale(scale).translate(Vec2(-box[0], -box[1]));
    return style;
  }

  /// What 100 % of the attribute is (SVG 2, section 8.9).
  static double whole(std::string_view name, const std::optional<Vec2>& viewport) {
    if (!viewport) throw SvgDamage{fmt::format("{} is in percent of a drawing without a size", name)};
    if (name == "r") return viewport->norm() / std::numbers::sqrt2;
    return (*viewport)[name == "y" || name == "cy" || name == "ry" || name == "height"];
  }

  /// A length in units of the user space, at 96 to an inch; 0 without the attribute.
  static double length(const pugi::xml_node& node, const char* name, const std::optional<Vec2>& viewport) {
    static constexpr std::pair<std::string_view, double> units[] = {{"px", 1},  {"mm", 96 / 25.4}, {"cm", 96 / 2.54},
                                                                    {"in", 96}, {"pt", 96.0 / 72}, {"pc", 16}};
    std::string_view text = node.attribute(name).value();
    double unit = 1, parts = 1;
    for (const auto& [ending, value] : units)
      if (text.ends_with(ending)) {
        unit = value;
        text.remove_suffix(ending.size());
        break;
      }
    if (text.ends_with('%')) {
      unit = whole(name, viewport);
      parts = 100;
      text.remove_suffix(1);
    }
    const auto numbers = read_svg_numbers(text);
    if (numbers.size() > 1) throw SvgDamage{fmt::format("{} is not one length", name)};
    return numbers.empty() ? 0 : unit * (numbers[0] / parts);
  }

  void add_shape(const pugi::xml_node& node, const Style& style) {
    const std::string opacity = property(node, "fill-opacity");
    double opaque = 1;
    if (!style.visible || style.fill == "none" || style.fill == "transparent" ||
        (parse_number(opacity, opaque) && opaque == 0))
      return;
    SvgPath path(style.transform);
    draw(node, style.viewport, path);
    Found found;
    found.feature = without_rings(node, style.fill);
    found.feature.polygons = path.flattened(tolerance_);
    if (found.feature.polygons.rings.empty()) return;  // a line, or nothing
    found.feature.fill = style.rule;
    found.background = covers_page(found.feature.polygons);
    found_.push_back(std::move(found));
  }

  static void draw(const pugi::xml_node& node, const std::optional<Vec2>& viewport, SvgPath& path) {
    const std::string_view name = local_name(node);
    if (name == "path") return read_path_data(node.attribute("d").value(), path);
    if (name == "rect") return draw_rectangle(node, viewport, path);
    if (name == "polygon" || name == "polyline") {
      const auto n = read_svg_numbers(node.attribute("points").value());
      if (n.size() % 2 != 0) throw SvgDamage{"its points have an odd number of coordinates"};
      for (std::size_t k = 0; k < n.size(); k += 2)
        k == 0 ? path.move_to(Vec2(n[k], n[k + 1])) : path.line_to(Vec2(n[k], n[k + 1]));
      return;
    }
    const bool circle = name == "circle";
    const auto number = [&](const char* of) { return length(node, of, viewport); };
    const Vec2 centre(number("cx"), number("cy")), radii(number(circle ? "r" : "rx"), number(circle ? "r" : "ry"));
    if (radii.minCoeff() < 0) throw SvgDamage{"its radius is negative"};
    if (radii.minCoeff() == 0) return;
    const Vec2 right = centre + Vec2(radii[0], 0), left = centre - Vec2(radii[0], 0);
    path.move_to(right);
    path.arc_to(radii, 0, false, true, left);
    path.arc_to(radii, 0, false, true, right);
  }

  static void draw_rectangle(const pugi::xml_node& node, const std::optional<Vec2>& viewport, SvgPath& path) {
    const auto number = [&](const char* of) { return length(node, of, viewport); };
    const Vec2 low(number("x"), number("y")), size(number("width"), number("height"));
    if (size.minCoeff() < 0) throw SvgDamage{"its width or height is negative"};
    const bool has_rx = node.attribute("rx"), has_ry = node.attribute("ry");
    const double rx = number(has_rx ? "rx" : "ry"), ry = number(has_ry ? "ry" : "rx");
    const Vec2 r = Vec2(rx, ry).cwiseMax(0).cwiseMin(size / 2), high = low + size;
    const auto side = [&](const Vec2& p) {
      if (p != path.at()) path.line_to(p);
    };
    path.move_to({low[0] + r[0], low[1]});
    side({high[0] - r[0], low[1]});
    path.arc_to(r, 0, false, true, {high[0], low[1] + r[1]});
    side({high[0], high[1] - r[1]});
    path.arc_to(r, 0, false, true, {high[0] - r[0], high[1]});
    side({low[0] + r[0], high[1]});
    path.arc_to(r, 0, false, true, {low[0], high[1] - r[1]});
    side({low[0], low[1] + r[1]});
    path.arc_to(r, 0, false, true, {low[0] + r[0], low[1]});
  }

  static std::string json(const std::string& text) {
    return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  }
  static PolygonFeature without_rings(const pugi::xml_node& node, const std::string& fill) {
    PolygonFeature feature;
    feature.y_down = true;
    if (const std::string id = node.attribute("id").value(); !id.empty()) feature.id = json(id);
    feature.properties = fmt::format(R"({{"element":{},"fill":{})", json(std::string(local_name(node))), json(fill));
    if (const std::string name = node.attribute("class").value(); !name.empty())
      feature.properties += R"(,"class":)" + json(name);
    feature.properties += "}";
    return feature;
  }

  /// Whether this is one rectangle, upright, that leaves nothing of the page free.
  bool covers_page(const Polygons& polygons) const {
    if (!page_ || polygons.rings.size() != 1) return false;
    const auto& ring = polygons.rings[0];
    Vec2 low = ring[0], high = ring[0];
    for (const Vec2& p : ring) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    std::size_t corners = 0;
    for (std::size_t k = 0; k < ring.size(); ++k) {
      const Vec2 &p = ring[k], &next = ring[(k + 1) % ring.size()];
      if (p == next) continue;
      ++corners;
      const bool corner = (p[0] == low[0] || p[0] == high[0]) && (p[1] == low[1] || p[1] == high[1]);
      if (!corner || (p[0] != next[0] && p[1] != next[1])) return false;
    }
    return corners == 4 && (low.array() <= page_->low.array()).all() && (high.array() >= page_->high.array()).all();
  }

  void hand_over() {
    const bool others = std::any_of(found_.begin(), found_.end(), [](const Found& f) { return !f.background; });
    for (Found& found : found_) {
      if (!found.problem.empty())
        sink_.refuse(base::plain(found.problem), std::move(found.feature));
      else if (found.background && others)
        sink_.skip(
            fmt::format("'{}': shape {} is a rectangle that covers the drawing; it is taken for the background "
                        "and left out",
                        file_.name, sink_.count()));
      else
        sink_.take(std::move(found.feature));
    }
    if (found_.empty()) fail("it has no filled shapes; strokes are not shapes, make paths of them first");
  }

  void say_what_is_left_out() const {
    std::string names;
    for (const auto& [name, count] : unread_) names += fmt::format("{}{} {}", names.empty() ? "" : ", ", count, name);
    if (!names.empty()) note(sink_.context(), fmt::format("'{}': not read: {}", file_.name, names));
  }

  const FileText& file_;
  double tolerance_;
  FeatureSink& sink_;
  pugi::xml_document xml_;
  std::optional<Vec2> viewport_;
  std::optional<Box> page_;
  std::vector<Found> found_;
  std::map<std::string, int> unread_;
};

}  // namespace

void read_svg(const FileText& file, double curve_tolerance, FeatureSink& sink) {
  SvgReader(file, curve_tolerance, sink).read();
}

}  // namespace quench::io
