// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <string>

#include "io/common/text_out.h"
#include "io/common/xml_text.h"
#include "quench/graph.h"
#include "quench/io.h"

/// A curve graph for networkx, igraph, Gephi and their like.
namespace quench::io {
namespace {

/// `Infinity` is what Java, Python and strtod all read; `inf` is not.
std::string number(double value) {
  return std::isinf(value) ? (value < 0 ? "-Infinity" : "Infinity") : fmt::format("{}", value);
}

template <class Value>
void print_data(TextOut& text, const char* key, const Value& value) {
  text.print("<data key=\"{}\">{}</data>", key, value);
}

}  // namespace

void write_graphml(const std::filesystem::path& file, const CurveGraph& graph, const Coordinates& coordinates) {
  write_atomically(file, [&](std::ostream& out) {
    TextOut text(out);
    text.print("{}", kGraphmlBegin);
    // Keys are unique in the whole file, names only per domain.
    const auto key = [&](const char* id, const char* domain, const char* name, const char* type) {
      text.print("  <key id=\"{}\" for=\"{}\" attr.name=\"{}\" attr.type=\"{}\"/>\n", id, domain, name, type);
    };
    for (const char* name : {"x", "y", "z", "radius"}) key(name, "node", name, "double");
    key("kind", "node", "kind", "string");
    key("component", "node", "component", "long");
    key("degree", "node", "degree", "long");
    key("sheet", "node", "sheet", "long");
    key("branch_component", "edge", "component", "long");
    for (const char* name : {"length", "mean_radius", "min_radius", "max_radius", "thickness", "tortuosity"})
      key(name, "edge", name, "double");
    const std::pair<const char*, const std::string&> known[] = {{"units", coordinates.units},
                                                                {"space", coordinates.space}};
    for (const auto& [name, value] : known)
      if (!value.empty()) key(name, "graph", name, "string");
    text.print("  <graph id=\"curves\" edgedefault=\"undirected\">\n");
    for (const auto& [name, value] : known)
      if (!value.empty()) text.print("    <data key=\"{}\">{}</data>\n", name, in_xml(value));
    for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
      const CurveGraph::Node& node = graph.nodes[n];
      text.print("    <node id=\"n{}\">", n);
      print_data(text, "x", number(node.point[0]));
      print_data(text, "y", number(node.point[1]));
      print_data(text, "z", number(node.point[2]));
      print_data(text, "radius", number(node.radius));
      print_data(text, "kind", name_of(node.kind));
      print_data(text, "component", node.component);
      print_data(text, "degree", node.degree);
      print_data(text, "sheet", node.sheet == kNone ? std::int64_t{-1} : std::int64_t{node.sheet});
      text.print("</node>\n");
    }
    for (std::size_t b = 0; b < graph.branches.size(); ++b) {
      const CurveGraph::Branch& branch = graph.branches[b];
      text.print("    <edge id=\"b{}\" source=\"n{}\" target=\"n{}\">", b, branch.from, branch.to);
      print_data(text, "branch_component", branch.component);
      print_data(text, "length", number(branch.length));
      print_data(text, "mean_radius", number(branch.mean_radius));
      print_data(text, "min_radius", number(branch.min_radius));
      print_data(text, "max_radius", number(branch.max_radius));
      print_data(text, "thickness", number(branch.thickness));
      print_data(text, "tortuosity", number(branch.tortuosity));
      text.print("</edge>\n");
    }
    text.print("  </graph>\n</graphml>\n");
    text.flush();
  });
}

}  // namespace quench::io
