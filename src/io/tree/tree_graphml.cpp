// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <string>

#include "io/common/text_out.h"
#include "io/common/xml_text.h"
#include "io/tree/tree_samples.h"
#include "quench/io.h"

namespace quench::io {
namespace {

class TreeGraphml {
 public:
  TreeGraphml(TextOut& text, const Tree& tree) : text_(text), tree_(tree), axes_(!tree.axes.empty()) {}

  void write() {
    text_.print("{}", kGraphmlBegin);
    for (const char* name : {"x", "y", "z", "radius"}) key("node", name, "double");
    key("node", "kind", "string");
    for (const char* name : {"length", "mean_radius"}) key("edge", name, "double");
    if (axes_)
      for (const char* name : {"axis", "level"}) key("edge", name, "long");
    for (const char* name : {"order", "strahler", "plant", "type"}) key("edge", name, "long");
    for (const char* name : {"course", "radii", "bridged"}) key("edge", name, "string");
    const std::pair<const char*, const std::string&> known[] = {{"units", tree_.coordinates.units},
                                                                {"space", tree_.coordinates.space}};
    for (const auto& [name, value] : known)
      if (!value.empty()) key("graph", name, "string");
    text_.print("  <graph id=\"tree\" edgedefault=\"directed\">\n");
    for (const auto& [name, value] : known)
      if (!value.empty()) text_.print("    <data key=\"graph_{}\">{}</data>\n", name, in_xml(value));
    write_nodes();
    for (std::size_t b = 0; b < tree_.branches.size(); ++b) write_edge(b);
    text_.print("  </graph>\n</graphml>\n");
    text_.flush();
  }

 private:
  void key(const char* domain, const char* name, const char* type) {
    text_.print("  <key id=\"{0}_{1}\" for=\"{0}\" attr.name=\"{1}\" attr.type=\"{2}\"/>\n", domain, name, type);
  }

  template <class Value>
  void edge_value(const char* name, const Value& value) {
    text_.print("<data key=\"edge_{}\">{}</data>", name, value);
  }

  void write_nodes() {
    const std::vector<std::uint32_t> children = children_of_branches(tree_);
    std::vector<double> radius(tree_.plants.size(), 0);
    for (std::size_t b = tree_.branches.size(); b-- > 0;)
      if (const Tree::Branch& branch = tree_.branches[b]; branch.parent == kNone)
        radius[branch.plant] = branch.radius.front();
    for (std::size_t p = 0; p < tree_.plants.size(); ++p)
      node(fmt::format("r{}", p), tree_.plants[p].root, tree_.plants[p].soma.value_or(radius[p]),
           tree_.plants[p].soma ? "soma" : "root");
    for (std::size_t b = 0; b < tree_.branches.size(); ++b) {
      const Tree::Branch& branch = tree_.branches[b];
      node(fmt::format("n{}", b), branch.points.back(), branch.radius.back(),
           children[b] == 0   ? "tip"
           : children[b] == 1 ? "tip_of_axis"
                              : "fork");
    }
  }

  void node(const std::string& id, const Vec3& p, double radius, const char* kind) {
    text_.print(
        "    <node id=\"{}\"><data key=\"node_x\">{}</data><data key=\"node_y\">{}</data><data key=\"node_z\">{}</data>"
        "<data key=\"node_radius\">{}</data><data key=\"node_kind\">{}</data></node>\n",
        id, p[0], p[1], p[2], radius, kind);
  }

  void write_edge(std::size_t b) {
    const Tree::Branch& branch = tree_.branches[b];
    const std::string source =
        branch.parent == kNone ? fmt::format("r{}", branch.plant) : fmt::format("n{}", branch.parent);
    text_.print("    <edge id=\"b{0}\" source=\"{1}\" target=\"n{0}\">", b, source);
    double length = 0, integral = 0;
    std::string course, radii, bridged;
    for (std::size_t i = 0; i < branch.points.size(); ++i) {
      const Vec3& p = branch.points[i];
      course += fmt::format("{}{} {} {}", i == 0 ? "" : ", ", p[0], p[1], p[2]);
      radii += fmt::format("{}{}", i == 0 ? "" : " ", branch.radius[i]);
      if (i == 0) continue;
      const double step = (p - branch.points[i - 1]).norm();
      length += step;
      integral += step * (branch.radius[i - 1] + branch.radius[i]) / 2;
    }
    for (const std::uint8_t gap : branch.bridged)
      bridged += bridged.empty() ? std::to_string(gap) : fmt::format(" {}", gap);
    edge_value("length", length);
    edge_value("mean_radius", length > 0 ? integral / length : branch.radius.back());
    if (axes_) {
      edge_value("axis", branch.axis);
      edge_value("level", tree_.axes[branch.axis].level);
    }
    edge_value("order", branch.order);
    edge_value("strahler", branch.strahler);
    edge_value("plant", branch.plant);
    edge_value("type", branch.type);
    edge_value("course", course);
    edge_value("radii", radii);
    if (!bridged.empty()) edge_value("bridged", bridged);
    text_.print("</edge>\n");
  }

  TextOut& text_;
  const Tree& tree_;
  bool axes_;
};

}  // namespace

void write_graphml(const std::filesystem::path& file, const Tree& tree) {
  write_atomically(file, [&](std::ostream& out) {
    TextOut text(out);
    TreeGraphml(text, tree).write();
  });
}

}  // namespace quench::io
