// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <pugixml.hpp>
#include <sstream>
#include <tuple>

#include "hand_built_skeletons.h"
#include "quench/error.h"
#include "quench/graph.h"
#include "temporary_folder.h"

namespace quench {
namespace curve_graph_files_test {

using testing_skeletons::Cells;
using testing_skeletons::random_cells;
using testing_skeletons::skeleton_of;

using Coordinates = std::array<double, 3>;
using Segment = std::array<Coordinates, 2>;
Coordinates of(const Vec3& p) { return {p[0], p[1], p[2]}; }
Segment between(const Vec3& a, const Vec3& b) { return {std::min(of(a), of(b)), std::max(of(a), of(b))}; }

std::string text_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::vector<std::string> fields(const std::string& line) {
  std::vector<std::string> result;
  std::stringstream in(line);
  for (std::string field; std::getline(in, field, ',');) result.push_back(field);
  return result;
}

/// A strict reader: ids 1 .. n, parents before children, comments in front only.
struct Swc {
  struct Sample {
    int type;
    Vec3 point;
    double radius;
    long parent;
  };
  std::vector<Sample> samples;
  std::vector<std::string> header;

  explicit Swc(const std::string& text) {
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);) {
      if (line.rfind('#', 0) == 0) {
        EXPECT_TRUE(samples.empty()) << line;
        header.push_back(line);
        continue;
      }
      Sample s{};
      unsigned long id = 0;
      std::string rest;
      std::istringstream row(line);
      EXPECT_TRUE(row >> id >> s.type >> s.point[0] >> s.point[1] >> s.point[2] >> s.radius >> s.parent) << line;
      EXPECT_FALSE(row >> rest) << line;
      samples.push_back(s);
      EXPECT_EQ(id, samples.size());
      EXPECT_TRUE(s.parent == -1 || (s.parent >= 1 && s.parent < static_cast<long>(id))) << line;
    }
  }
  int roots() const {
    return static_cast<int>(
        std::count_if(samples.begin(), samples.end(), [](const Sample& s) { return s.parent == -1; }));
  }
  int lines_with(const std::string& words) const {
    return static_cast<int>(std::count_if(
        header.begin(), header.end(), [&](const std::string& line) { return line.find(words) != std::string::npos; }));
  }
};

std::pair<Swc, io::SwcReport> swc_of(const CurveGraph& graph, const io::SwcOptions& options = {}) {
  const TemporaryFolder folder;
  const io::SwcReport report = io::write_swc(folder / "a.swc", graph, options);
  return {Swc(text_of(folder / "a.swc")), report};
}

TEST(Swc, ATreeFromItsThickestNode) {
  Cells cells;
  cells.add(1e-17, 0, 0, 1);
  cells.add(1, 0, 0, 2);
  cells.add(2, 1. / 3, 0, 3);
  cells.add(2, -1, 0, 1);
  cells.add(5, 0, 0, 9);  // thick, but inside a branch
  cells.add(6, 0, 0, 1);
  cells.path({0, 1, 2});
  cells.path({1, 3});
  cells.path({1, 4, 5});
  const auto [swc, report] = swc_of(curve_graph(skeleton_of(cells)),
                                    {.root = {}, .type = 3, .coordinates = {.units = "mm\n9", .space = "LPS"}});
  EXPECT_EQ(report.trees, 1u);
  EXPECT_TRUE(report.cuts.empty());
  ASSERT_EQ(swc.samples.size(), 6u);
  EXPECT_EQ(report.samples, 6u);
  EXPECT_EQ(swc.samples[0].point, Vec3(2, 1. / 3, 0));  // all digits
  EXPECT_EQ(swc.samples[0].parent, -1);
  EXPECT_EQ(swc.samples[0].type, 3);
  EXPECT_EQ(swc.samples[0].radius, 3);
  EXPECT_EQ(swc.samples[1].point, Vec3(1, 0, 0));
  EXPECT_EQ(swc.lines_with("units: mm 9"), 1);
  EXPECT_EQ(swc.lines_with("SPACE: LPS"), 1);
  EXPECT_EQ(report.roots, std::vector<std::uint32_t>{2});
}

TEST(Swc, TheRootIsTheNodeNearestToAPointInItsComponentOnly) {
  Cells cells;
  cells.path({cells.add(0, 0, 0, 1), cells.add(4, 0, 0, 2)});
  cells.path({cells.add(0, 9, 0, 1), cells.add(4, 9, 0, 2)});
  const CurveGraph graph = curve_graph(skeleton_of(cells));
  const auto [swc, report] = swc_of(graph, {.root = Vec3(-1, 6, 0), .type = 0, .coordinates = {}});
  ASSERT_EQ(swc.roots(), 2);
  EXPECT_EQ(swc.samples[0].point, Vec3(4, 0, 0));
  EXPECT_EQ(swc.samples[2].point, Vec3(0, 9, 0));
}

TEST(Swc, LoopsAreCutAtTheirThinnestPlace) {
  Cells cells;  // a theta whose lower branch is thin in the middle, the middle one is a lone edge
  for (double x : {0, 6}) cells.add(x, 0, 0, 5);
  const double upper[] = {4, 3, 4}, lower[] = {2, 1, 1.5, 2};
  std::vector<std::uint32_t> up{0}, down{0};
  for (int i = 0; i < 3; ++i) up.push_back(cells.add(1.5 * i + 1.5, 3, 0, upper[i]));
  for (int i = 0; i < 4; ++i) down.push_back(cells.add(1.2 * i + 1.2, -3, 0, lower[i]));
  up.push_back(1);
  down.push_back(1);
  cells.path(up);
  cells.path(down);
  cells.path({0, 1});
  const CurveGraph graph = curve_graph(skeleton_of(cells));
  const auto [swc, report] = swc_of(graph);
  ASSERT_EQ(report.cuts.size(), 2u);
  EXPECT_EQ(swc.lines_with("loop cut at"), 2);
  EXPECT_EQ(swc.samples.size(), cells.points.size());
  std::set<Segment> cuts;
  for (const auto& cut : report.cuts) cuts.insert(between(cut.from, cut.to));
  // Thinnest segment of the lower branch: radii 1 and 1.5. Of the upper: 3 and 4, nearest to the middle, the first.
  EXPECT_TRUE(cuts.contains(between(cells.points[down[2]], cells.points[down[3]])));
  EXPECT_TRUE(cuts.contains(between(cells.points[up[1]], cells.points[up[2]])) ||
              cuts.contains(between(cells.points[up[2]], cells.points[up[3]])));
}

TEST(Swc, AClosedCurveIsCutOnce) {
  Cells cells;
  for (double r : {1, 2, 3, 1}) cells.add(r, 1 / r, cells.points.size() % 2 ? 1.0 : 0.0, r);
  cells.path({0, 1, 2, 3, 0});
  const auto [swc, report] = swc_of(curve_graph(skeleton_of(cells)));
  ASSERT_EQ(report.cuts.size(), 1u);
  EXPECT_EQ(between(report.cuts[0].from, report.cuts[0].to), between(cells.points[0], cells.points[3]));
  EXPECT_EQ(swc.samples.size(), 4u);
  EXPECT_EQ(swc.roots(), 1);
}

TEST(Swc, CurvesOnOneSheetHangTogetherThroughIt) {
  Cells cells;
  const std::uint32_t corner = cells.square(0, 0, 0);
  cells.radius[corner + 2] = 3;
  for (std::uint32_t i : {0u, 1u, 2u}) cells.path({corner + i, cells.add(9, i, 1, 0.5)});
  const auto [swc, report] = swc_of(curve_graph(skeleton_of(cells)));
  EXPECT_EQ(swc.roots(), 1);
  EXPECT_EQ(report.sheet_links, 2u);
  EXPECT_EQ(swc.lines_with("sheet link"), 2);
  EXPECT_EQ(swc.samples[0].point, cells.points[corner + 2]);
  EXPECT_TRUE(report.cuts.empty());
}

TEST(Swc, AHandleOnASheetIsALoop) {
  Cells cells;
  const std::uint32_t corner = cells.square(0, 0, 0), top = cells.add(0, 0, 3);
  cells.path({corner, top, corner + 2});
  const auto [swc, report] = swc_of(curve_graph(skeleton_of(cells)));
  EXPECT_EQ(report.cuts.size(), 1u);
  EXPECT_EQ(swc.samples.size(), 3u);
  EXPECT_EQ(swc.roots(), 1);
}

TEST(Swc, ASheetWithoutCurvesGetsASentence) {
  Cells cells;
  cells.square(0, 0, 0);
  const auto [swc, report] = swc_of(curve_graph(skeleton_of(cells)));
  EXPECT_EQ(swc.samples.size(), 0u);
  EXPECT_EQ(report.trees, 0u);
  EXPECT_EQ(swc.lines_with("component 0 is a sheet without curves"), 1);
  cells.add(5, 5, 5);
  EXPECT_EQ(swc_of(curve_graph(skeleton_of(cells))).first.samples.size(), 1u);
}

TEST(Swc, TypesByNumberAndName) {
  EXPECT_EQ(io::SwcOptions().type, 3);
  EXPECT_EQ(io::swc_type_of("undefined", "type"), 0);
  EXPECT_EQ(io::swc_type_of("dendrite", "type"), io::swc_type_of("basal-dendrite", "type"));
  EXPECT_EQ(io::swc_type_of("010", "type"), 10);
  for (const char* text : {"", "-1", "256", "99999999999", "3 ", "Soma"})
    EXPECT_THROW(io::swc_type_of(text, "type"), Error) << text;
}

TEST(Swc, RefusesWhatCannotBe) {
  const TemporaryFolder folder;
  EXPECT_THROW(io::write_swc(folder / "a.swc", {}, {.root = {}, .type = -1, .coordinates = {}}), Error);
  EXPECT_THROW(io::write_swc(folder / "a.swc", {}, {.root = Vec3(0, 0, NAN), .type = 0, .coordinates = {}}), Error);
  EXPECT_THROW(io::write_swc(folder / "no" / "a.swc", {}), Error);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(Swc, RandomGraphsBecomeTreesThatLoseOnlyTheirCuts) {
  std::size_t cuts = 0, links = 0;
  for (std::uint64_t seed = 0; seed < 600; ++seed) {
    const CurveGraph graph = curve_graph(skeleton_of(random_cells(seed)));
    const auto [swc, report] = swc_of(graph);
    std::multiset<Coordinates> wanted, found;
    std::multiset<Segment> curves, written;
    std::set<std::uint32_t> components, patches;
    std::size_t on_sheets = 0, segments = 0, points = graph.nodes.size();
    for (const auto& node : graph.nodes) {
      wanted.insert(of(node.point));
      components.insert(node.component);
      if (node.sheet != kNone) {
        patches.insert(node.sheet);
        ++on_sheets;
      }
    }
    for (const auto& branch : graph.branches) {
      for (std::size_t i = 1; i < branch.points.size(); ++i) {
        curves.insert(between(branch.points[i - 1], branch.points[i]));
        if (i + 1 < branch.points.size()) wanted.insert(of(branch.points[i]));
      }
      segments += branch.points.size() - 1;
      points += branch.points.size() - 2;
    }
    for (const auto& cut : report.cuts) {
      const auto at = curves.find(between(cut.from, cut.to));
      ASSERT_NE(at, curves.end());
      curves.erase(at);
    }
    std::size_t straight = 0;
    for (const auto& sample : swc.samples) {
      found.insert(of(sample.point));
      if (sample.parent == -1) continue;
      const Segment segment = between(sample.point, swc.samples[static_cast<std::size_t>(sample.parent) - 1].point);
      if (curves.contains(segment) && written.count(segment) < curves.count(segment)) {
        written.insert(segment);
      } else {
        ++straight;
      }
    }
    ASSERT_EQ(found, wanted) << "seed " << seed;
    ASSERT_EQ(written, curves) << "seed " << seed;
    ASSERT_EQ(swc.roots(), static_cast<int>(components.size())) << "seed " << seed;
    ASSERT_EQ(report.trees, components.size());
    ASSERT_EQ(straight, on_sheets - patches.size()) << "seed " << seed;
    ASSERT_EQ(report.sheet_links, straight);
    // b1 of the curves with every patch of sheets a point.
    ASSERT_EQ(report.cuts.size(), segments + straight + components.size() - points) << "seed " << seed;
    ASSERT_EQ(swc.lines_with("loop cut at"), static_cast<int>(report.cuts.size()));
    ASSERT_EQ(swc.lines_with("sheet link"), static_cast<int>(straight));
    for (std::size_t i = 0; i < report.roots.size(); ++i)
      for (const auto& node : graph.nodes) {
        const auto& root = graph.nodes[report.roots[i]];
        ASSERT_FALSE(node.component == root.component && node.radius > root.radius);
      }
    cuts += report.cuts.size();
    links += straight;
  }
  EXPECT_GT(cuts, 500u);
  EXPECT_GT(links, 50u);
}

CurveGraph example() {
  Cells cells;
  cells.square(0, 0, 0);
  cells.path({0, cells.add(-1, -1, 7, 2)});
  const std::uint32_t a = cells.add(20, 0, 0), b = cells.add(21, 1, 0), c = cells.add(22, 0, 1. / 3);
  cells.path({a, b, c, a});
  Skeleton skeleton = skeleton_of(cells);
  for (std::size_t e = 0; e < skeleton.complex.edges.size(); ++e)
    if (skeleton.complex.edges[e][0] >= a) skeleton.edge_thickness[e] = std::numeric_limits<double>::infinity();
  return curve_graph(skeleton);
}

TEST(BranchTable, OneRowPerBranch) {
  const TemporaryFolder folder;
  io::write_branches(folder / "b.csv", example());
  std::istringstream in(text_of(folder / "b.csv"));
  std::vector<std::vector<std::string>> rows;
  for (std::string line; std::getline(in, line);) rows.push_back(fields(line));
  ASSERT_EQ(rows.size(), 3u);
  for (const auto& row : rows) ASSERT_EQ(row.size(), 18u);
  const auto value = [&](std::size_t row, const std::string& column) {
    const auto at = std::find(rows[0].begin(), rows[0].end(), column);
    return at == rows[0].end() ? "no such column" : rows[row][static_cast<std::size_t>(at - rows[0].begin())];
  };
  EXPECT_EQ(value(1, "branch"), "0");
  EXPECT_EQ(value(1, "from_kind"), "sheet");
  EXPECT_EQ(value(1, "to_kind"), "end");
  EXPECT_EQ(value(1, "to_z"), "7");
  EXPECT_EQ(value(1, "length"), "7");
  EXPECT_EQ(value(1, "mean_radius"), "1.5");
  EXPECT_EQ(value(1, "tortuosity"), "1");
  EXPECT_EQ(value(2, "component"), "1");
  EXPECT_EQ(value(2, "from"), value(2, "to"));
  EXPECT_EQ(value(2, "thickness"), "inf");
  EXPECT_EQ(value(2, "tortuosity"), "inf");
  EXPECT_EQ(std::stod(value(2, "length")), example().branches[1].length);
}

TEST(GraphMl, NodesAndEdgesWithTheirValues) {
  const TemporaryFolder folder;
  const CurveGraph graph = example();
  io::write_graphml(folder / "g.graphml", graph);
  pugi::xml_document document;
  ASSERT_TRUE(document.load_file((folder / "g.graphml").c_str()));
  const pugi::xml_node root = document.child("graphml");
  std::map<std::string, std::string> name;  // of a key
  for (const pugi::xml_node& key : root.children("key"))
    ASSERT_TRUE(name.emplace(key.attribute("id").value(), key.attribute("attr.name").value()).second);
  const auto values = [&](const pugi::xml_node& element) {
    std::map<std::string, std::string> result;
    for (const pugi::xml_node& data : element.children("data"))
      result[name.at(data.attribute("key").value())] = data.text().get();
    return result;
  };
  std::vector<pugi::xml_node> nodes, edges;
  for (const pugi::xml_node& n : root.child("graph").children("node")) nodes.push_back(n);
  for (const pugi::xml_node& e : root.child("graph").children("edge")) edges.push_back(e);
  ASSERT_EQ(nodes.size(), graph.nodes.size());
  ASSERT_EQ(edges.size(), graph.branches.size());
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    auto at = values(nodes[n]);
    EXPECT_EQ(nodes[n].attribute("id").value(), "n" + std::to_string(n));
    EXPECT_EQ(std::stod(at.at("z")), graph.nodes[n].point[2]);
    EXPECT_EQ(std::stod(at.at("radius")), graph.nodes[n].radius);
    EXPECT_EQ(at.at("kind"), name_of(graph.nodes[n].kind));
    EXPECT_EQ(std::stoul(at.at("component")), graph.nodes[n].component);
  }
  EXPECT_EQ(values(nodes[0]).at("sheet"), "0");
  EXPECT_EQ(values(nodes[1]).at("sheet"), "-1");
  auto loop = values(edges[1]);
  EXPECT_EQ(edges[1].attribute("source").value(), std::string("n2"));
  EXPECT_EQ(edges[1].attribute("target").value(), std::string("n2"));
  EXPECT_EQ(loop.at("thickness"), "Infinity");
  EXPECT_EQ(loop.at("component"), "1");
  EXPECT_EQ(std::stod(loop.at("length")), graph.branches[1].length);
}

TEST(CurveGraphFiles, AreTheSameEveryTime) {
  const TemporaryFolder folder;
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    std::array<std::string, 3> first;
    for (int time = 0; time < 2; ++time) {
      const CurveGraph graph = curve_graph(skeleton_of(random_cells(seed)));
      io::write_swc(folder / "a.swc", graph);
      io::write_graphml(folder / "a.graphml", graph);
      io::write_branches(folder / "a.csv", graph);
      const std::array<std::string, 3> now{text_of(folder / "a.swc"), text_of(folder / "a.graphml"),
                                           text_of(folder / "a.csv")};
      if (time == 0) first = now;
      ASSERT_EQ(now, first);
    }
  }
}

}  // namespace curve_graph_files_test
}  // namespace quench
