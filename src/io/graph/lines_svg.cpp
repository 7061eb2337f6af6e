// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>

#include "io/common/text_out.h"
#include "io/common/viridis.h"
#include "io/graph/line_format.h"

/// Lines as a drawing: the shape grey, branches coloured. Lengths of the drawing are those of the graph.
namespace quench::io {
namespace {

std::string hex(const Colour& c) { return fmt::format("#{:02x}{:02x}{:02x}", c[0], c[1], c[2]); }

class SvgLines : public LineFormat {
 public:
  SvgLines(std::ostream& out, const LineOptions& options) : out_(out), options_(options) {}

  void append(const PlaneLines& lines) override {
    Vec2 low = Vec2::Constant(std::numeric_limits<double>::infinity()), high = -low;
    const auto widen = [&](const Vec2& p) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    };
    for (const auto& ring : lines.outline.rings)
      for (const Vec2& p : ring) widen(p);
    for (const auto& branch : lines.graph.branches)
      for (const Vec3& p : branch.points) widen(p.head<2>());
    for (const auto& node : lines.graph.nodes) widen(node.point.head<2>());
    if (!low.allFinite()) return;  // nothing to draw
    low_ = low_.cwiseMin(low);
    high_ = high_.cwiseMax(high);

    const double side = (high - low).maxCoeff();
    ++shapes_;
    print("<g");
    if (lines.number) print(R"( data-feature="{}")", *lines.number);
    print(">\n");
    print_area(lines.outline, "#d0d0d0");
    print_area(lines.wide, "#9db4c8");
    print_branches(lines.graph);
    for (const auto& node : lines.graph.nodes)
      if (node.kind == CurveGraph::NodeKind::isolated)
        print(R"(<circle cx="{}" cy="{}" r="{:g}" fill="{}" stroke="none" data-radius="{}"/>)"
              "\n",
              node.point[0], node.point[1], 0.004 * side, hex(viridis(fraction_of(node, lines.graph))), node.radius);
    print("</g>\n");
  }

  void finish() override {
    TextOut text(out_);
    const bool any = low_.allFinite();
    const Vec2 low = any ? low_ : Vec2(0, 0), high = any ? high_ : Vec2(1, 1);
    const double margin = 0.02 * std::max((high - low).maxCoeff(), std::numeric_limits<double>::min());
    const double top = options_.y_down ? low[1] : -high[1];
    text.print("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"{} {} {} {}\">\n", low[0] - margin, top - margin,
               high[0] - low[0] + 2 * margin, high[1] - low[1] + 2 * margin);
    if (!options_.y_down) text.print("<!-- y of the coordinates grows upwards, that of SVG downwards -->\n");
    // One width for all lines: thinner where there are many shapes, of which most are small.
    const double width = (shapes_ > 1 ? 0.002 : 0.004) * (high - low).maxCoeff();
    text.print(R"(<g fill="none" stroke-width="{:g}" stroke-linecap="round" stroke-linejoin="round"{}>)"
               "\n",
               width, options_.y_down ? "" : " transform=\"scale(1,-1)\"");
    text.flush();
    out_.write(body_.data(), static_cast<std::streamsize>(body_.size()));
    text.print("</g>\n</svg>\n");
    text.flush();
  }

 private:
  template <class... Args>
  void print(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(body_), format, std::forward<Args>(args)...);
  }

  void print_area(const Polygons& area, const char* fill) {
    if (area.rings.empty()) return;
    print(R"(<path fill="{}" fill-rule="evenodd" stroke="none" d=")", fill);
    for (const auto& ring : area.rings) {
      char before = 'M';
      for (const Vec2& p : ring) print("{}{} {}", std::exchange(before, 'L'), p[0], p[1]);
      print("Z");
    }
    print("\"/>\n");
  }

  double value_of(const CurveGraph::Branch& branch) const {
    return options_.colour == LineOptions::Colour::radius ? branch.mean_radius : branch.thickness;
  }
  double largest_value(const CurveGraph& graph) const {
    double largest = 0;
    for (const auto& branch : graph.branches)
      if (std::isfinite(value_of(branch))) largest = std::max(largest, value_of(branch));
    return largest;
  }
  // Of a point: it has a radius, and no thickness.
  double fraction_of(const CurveGraph::Node& node, const CurveGraph& graph) const {
    const double largest = largest_value(graph);
    if (options_.colour != LineOptions::Colour::radius) return 0;
    return largest > 0 ? std::min(1.0, node.radius / largest) : 1;
  }

  void print_branches(const CurveGraph& graph) {
    const double largest = largest_value(graph);
    for (std::size_t b = 0; b < graph.branches.size(); ++b) {
      const CurveGraph::Branch& branch = graph.branches[b];
      const double value = value_of(branch);
      const double fraction = !std::isfinite(value) ? 1 : largest > 0 ? value / largest : 0;
      print(
          R"(<polyline stroke="{}" data-branch="{}" data-length="{}" data-mean-radius="{}" data-thickness="{}" points=")",
          hex(viridis(fraction)), b, branch.length, branch.mean_radius, branch.thickness);
      const char* before = "";
      for (const Vec3& p : branch.points) print("{}{},{}", std::exchange(before, " "), p[0], p[1]);
      print("\"/>\n");
    }
  }

  std::ostream& out_;
  LineOptions options_;
  std::string body_;
  std::size_t shapes_ = 0;
  Vec2 low_ = Vec2::Constant(std::numeric_limits<double>::infinity()), high_ = -low_;
};

}  // namespace

std::unique_ptr<LineFormat> svg_lines(std::ostream& out, const LineOptions& options) {
  return std::make_unique<SvgLines>(out, options);
}

}  // namespace quench::io
