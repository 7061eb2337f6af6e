// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>

#include "data.h"
#include "program.h"
#include "program_arrays.h"
#include "quench/axis.h"
#include "quench/io.h"

// `quench burn`, and the burning part of `quench run`.

using namespace quench::testing_program;
using quench::DataArray;
using quench::find_array;
using quench::Record;

namespace program_burn_test {

std::vector<double> of_points(const Record& data, const char* name) { return numbers(data.point_data, name); }

// What holds of every burned file: a value per vertex, finite, BT = ET + R, not before the shape burns.
void expect_sound(const Record& data) {
  const auto bt = of_points(data, "burn_time"), et = of_points(data, "erosion_thickness"),
             radius = of_points(data, "radius"), unburned = of_points(data, "unburned");
  ASSERT_EQ(bt.size(), data.points.size());
  ASSERT_EQ(et.size(), data.points.size());
  ASSERT_EQ(unburned.size(), data.points.size());
  for (std::size_t v = 0; v < bt.size(); ++v) {
    ASSERT_TRUE(std::isfinite(bt[v]) && std::isfinite(et[v])) << v;
    ASSERT_TRUE(unburned[v] == 0 || unburned[v] == 1) << v;
    ASSERT_GE(et[v], -1e-9) << v;
    if (unburned[v] == 0) {
      ASSERT_NEAR(bt[v], et[v] + radius[v], 1e-9 * (1 + bt[v])) << v;
    }
  }
}

// A square of side 4 in unit cells, two triangles each, at constant radius 1: ET is the distance to the rim.
constexpr int kSide = 4;
std::string square_points(const std::string& after = "") {
  std::string text;
  for (int j = 0; j <= kSide; ++j)
    for (int i = 0; i <= kSide; ++i) text += fmt::format("{} {} 0{}\n", i, j, after);
  return text;
}
std::vector<std::array<int, 3>> square_triangles() {
  std::vector<std::array<int, 3>> triangles;
  const auto at = [](int i, int j) { return j * (kSide + 1) + i; };
  for (int j = 0; j < kSide; ++j)
    for (int i = 0; i < kSide; ++i) {
      triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return triangles;
}
constexpr int kPoints = (kSide + 1) * (kSide + 1), kTriangles = 2 * kSide * kSide;
double square_thickness(int v) {
  const int i = v % (kSide + 1), j = v / (kSide + 1);
  return std::min({i, j, kSide - i, kSide - j});
}

std::string square_off() {
  std::string text = fmt::format("OFF\n{} {} 0\n", kPoints, kTriangles) + square_points();
  for (const auto& [a, b, c] : square_triangles()) text += fmt::format("3 {} {} {}\n", a, b, c);
  return text;
}
std::string square_obj() {
  std::string text;
  for (int v = 0; v < kPoints; ++v) text += fmt::format("v {} {} 0\n", v % (kSide + 1), v / (kSide + 1));
  for (const auto& [a, b, c] : square_triangles()) text += fmt::format("f {} {} {}\n", a + 1, b + 1, c + 1);
  return text;
}
std::string ply(int vertices, const std::string& points, int faces, const std::string& cells) {
  return fmt::format(
             "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n"
             "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
             vertices, faces) +
         points + cells;
}
std::string square_ply(int more_vertices = 0, const std::string& points = "", int more_faces = 0,
                       const std::string& faces = "") {
  std::string cells;
  for (const auto& [a, b, c] : square_triangles()) cells += fmt::format("3 {} {} {}\n", a, b, c);
  return ply(kPoints + more_vertices, square_points() + points, kTriangles + more_faces, cells + faces);
}
// Radii in another order than the vertices: they are matched by position.
std::string square_radii(const std::string& more = "", int count = 0) {
  std::string text = fmt::format("{}\n", kPoints + count) + more;
  for (int v = kPoints - 1; v >= 0; --v) text += fmt::format("{} {} 0 1\n", v % (kSide + 1), v / (kSide + 1));
  return text;
}
std::string square_ma(const std::string& more_vertices, int vertices, const std::string& edges, int edge_count) {
  std::string text = fmt::format("{} {} {}\n", kPoints + vertices, edge_count, kTriangles);
  for (int v = 0; v < kPoints; ++v) text += fmt::format("v {} {} 0 1\n", v % (kSide + 1), v / (kSide + 1));
  text += more_vertices + edges;
  for (const auto& [a, b, c] : square_triangles()) text += fmt::format("f {} {} {}\n", a, b, c);
  return text;
}

class Burn : public ProgramTest {
 protected:
  Record read(const std::string& name) const {
    Record data = quench::io::read_record(folder / name);
    data.validate();
    return data;
  }
  /// A core of the box with sides 10, 7 and 5 voxels.
  void make_core() {
    folder.write("v.npy", npy_box(10, 7, 5, 1));
    works({"core", "v.npy", "--lambda", "0", "-o", "core.vtp"});
  }
  Outcome burn(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "burn");
    return works(arguments);
  }
};

TEST_F(Burn, HelpNamesIt) {
  EXPECT_TRUE(has(works({"--help"}).out, "\n  burn "));
  const auto help = works({"burn", "--help"});
  EXPECT_TRUE(has(help.out, "Example:\n  quench burn ")) << help.out;
  for (const char* part : {"--omega", "--radius", "--radii", "--shape"}) EXPECT_TRUE(has(help.out, part)) << part;
  for (const char* jargon : {"TEXT", "INT", "FLOAT", ":{"}) EXPECT_FALSE(has(help.out, jargon)) << jargon;
}

TEST_F(Burn, AddsArraysAndKeepsTheRest) {
  make_core();
  EXPECT_TRUE(has(burn({"core.vtp", "-o", "burned.vtp"}).err, "burned.vtp: burn time up to "));
  const Record before = read("core.vtp"), after = read("burned.vtp");
  expect_sound(after);
  EXPECT_EQ(before.points, after.points);
  EXPECT_EQ(before.verts, after.verts);
  EXPECT_EQ(before.lines, after.lines);
  EXPECT_EQ(before.poly_offsets, after.poly_offsets);
  EXPECT_EQ(before.poly_corners, after.poly_corners);
  const auto kept = [](const std::vector<DataArray>& old, const std::vector<DataArray>& now) {
    for (const DataArray& array : old) {
      const DataArray* same = find_array(now, array.name);
      ASSERT_TRUE(same) << array.name;
      EXPECT_EQ(same->components, array.components) << array.name;
      EXPECT_EQ(same->values, array.values) << array.name;
    }
  };
  kept(before.point_data, after.point_data);
  kept(before.cell_data, after.cell_data);
  kept(before.field_data, after.field_data);
  EXPECT_TRUE(find_array(after.point_data, "object_angle") && find_array(after.cell_data, "object_angle"));
  EXPECT_EQ(text_field(after, "propagation"), "segments");
  EXPECT_EQ(text_field(after, "radius_rule"), "exact");
  EXPECT_GT(field(after, "omega"), 0);
  EXPECT_GE(field(after, "burn_nodes"), static_cast<double>(after.points.size()));
  const auto bt = of_points(after, "burn_time");
  EXPECT_EQ(field(after, "max_burn_time"), *std::max_element(bt.begin(), bt.end()));
  // The middle of the box: the fire of the rim of the middle sheet is there at 5 (1 / sqrt 2) + what is left of 7.
  EXPECT_GT(field(after, "max_burn_time"), 3.5);
  EXPECT_LT(field(after, "max_burn_time"), 5);
}

TEST_F(Burn, SameBytesAgainAndWhenBurnedTwice) {
  make_core();
  burn({"core.vtp", "-o", "a.vtp"});
  burn({"core.vtp", "-o", "b.vtp", "--threads", "1"});
  EXPECT_EQ(bytes("a.vtp"), bytes("b.vtp"));
  burn({"a.vtp", "-o", "c.vtp"});  // arrays are replaced, not added once more
  EXPECT_EQ(bytes("a.vtp"), bytes("c.vtp"));
  burn({"a.vtp", "-o", "d.vtp", "--omega", "0.3vox"});
  EXPECT_NE(bytes("a.vtp"), bytes("d.vtp"));
  EXPECT_EQ(read("d.vtp").point_data.size(), read("a.vtp").point_data.size());
  EXPECT_EQ(read("d.vtp").field_data.size(), read("a.vtp").field_data.size());
}

TEST_F(Burn, OtherFilesHoldTheArraysToo) {
  make_core();
  for (const char* file : {"a.vtp", "a.ply", "a.csv"}) burn({"core.vtp", "-o", file});
  EXPECT_EQ(of_points(read("a.ply"), "burn_time").size(), read("a.vtp").points.size());
  const std::string csv = bytes("a.csv");
  for (const char* name : {"burn_time", "erosion_thickness", "unburned"})
    EXPECT_TRUE(has(csv.substr(0, csv.find('\n')), name)) << name;
  EXPECT_EQ(static_cast<std::size_t>(std::count(csv.begin(), csv.end(), '\n')), read("a.vtp").points.size() + 1);
  works({"convert", "a.vtp", "b.ply"});
  EXPECT_EQ(bytes("a.ply").size(), bytes("b.ply").size());
}

TEST_F(Burn, ForeignFormats) {
  folder.write("s.off", square_off());
  folder.write("s.obj", square_obj());
  folder.write("s.ply", square_ply());
  folder.write("s.ma", square_ma("", 0, "", 0));
  folder.write("s.r", square_radii());
  for (const char* file : {"s.off", "s.obj", "s.ply", "s.ma"}) {
    SCOPED_TRACE(file);
    std::vector<std::string> arguments{file, "-o", "out.vtp", "--overwrite"};
    if (std::string(file) != "s.ma") arguments.insert(arguments.end(), {"--radii", "s.r"});
    burn(arguments);
    const Record data = read("out.vtp");
    expect_sound(data);
    ASSERT_EQ(data.points.size(), static_cast<std::size_t>(kPoints));
    EXPECT_EQ(data.poly_count(), static_cast<std::size_t>(kTriangles));
    EXPECT_EQ(text_field(data, "radius_rule"), "linear");
    const auto et = of_points(data, "erosion_thickness");
    for (int v = 0; v < kPoints; ++v) {
      EXPECT_EQ(data.points[static_cast<std::size_t>(v)], quench::Vec3(v % (kSide + 1), v / (kSide + 1), 0));
      EXPECT_NEAR(et[static_cast<std::size_t>(v)], square_thickness(v), 0.02) << v;
    }
  }
}

TEST_F(Burn, OmegaInAllUnits) {
  make_core();
  const auto omega = [&](const std::string& file, const std::string& length) {
    burn({file, "-o", "out.vtp", "--overwrite", "--omega", length});
    return field(read("out.vtp"), "omega");
  };
  EXPECT_DOUBLE_EQ(omega("core.vtp", "0.05"), 0.5);  // of the longest side, 10
  EXPECT_DOUBLE_EQ(omega("core.vtp", "2.5%"), 0.25);
  EXPECT_DOUBLE_EQ(omega("core.vtp", "0.4vox"), 0.4);
  EXPECT_DOUBLE_EQ(omega("core.vtp", "0.7abs"), 0.7);
  EXPECT_GT(omega("core.vtp", "auto"), 0);
  works({"core", "v.npy", "--spacing", "2,2,3", "--lambda", "0", "-o", "coarse.vtp"});
  EXPECT_DOUBLE_EQ(omega("coarse.vtp", "0.4vox"), 0.8);  // of the smallest side of a voxel
  EXPECT_DOUBLE_EQ(omega("coarse.vtp", "0.05"), 1);
  // A foreign axis: fractions of its own box, until a shape is given.
  folder.write("s.ma", square_ma("", 0, "", 0));
  EXPECT_DOUBLE_EQ(omega("s.ma", "0.1"), 0.4);
  EXPECT_DOUBLE_EQ(omega("s.ma", "0.7abs"), 0.7);
  burn({"s.ma", "-o", "out.vtp", "--overwrite", "--omega", "0.05", "--shape", "v.npy"});
  EXPECT_DOUBLE_EQ(field(read("out.vtp"), "omega"), 0.5);
  burn({"s.ma", "-o", "out.vtp", "--overwrite", "--omega", "0.5vox", "--shape", "v.npy"});
  EXPECT_DOUBLE_EQ(field(read("out.vtp"), "omega"), 0.5);
  refuses(2, {"--omega '0.5vox'", "voxel size", "abs"}, {"burn", "s.ma", "-o", "no.vtp", "--omega", "0.5vox"});
}

TEST_F(Burn, RadiusRule) {
  make_core();
  const auto run = [&](const std::string& rule) {
    burn({"core.vtp", "-o", "out.vtp", "--overwrite", "--omega", "0.5vox", "--radius", rule});
    const Record data = read("out.vtp");
    EXPECT_EQ(text_field(data, "radius_rule"), rule == "auto" ? "exact" : rule);
    EXPECT_EQ(text_field(data, "propagation"), "segments");
    const auto bt = of_points(data, "burn_time");
    double sum = 0;
    for (const double t : bt) sum += t;
    return sum / static_cast<double>(bt.size());
  };
  const double exact = run("exact"), linear = run("linear");
  EXPECT_EQ(run("auto"), exact);
  EXPECT_GT(linear, exact);  // the exact radius is never above the line between the ends
  folder.write("s.ma", square_ma("", 0, "", 0));
  burn({"s.ma", "-o", "out.vtp", "--overwrite", "--radius", "exact"});
  EXPECT_EQ(text_field(read("out.vtp"), "radius_rule"), "exact");
}

TEST_F(Burn, ClosedPocket) {
  works({"sample", "hollow-sphere", "-o", "s.ply", "--fineness", "0.3"});
  works({"core", "s.ply", "--resolution", "32", "--lambda", "0", "-o", "core.vtp"});
  const auto outcome = burn({"core.vtp", "-o", "burned.vtp", "--json", "report.json"});
  EXPECT_TRUE(has(outcome.err, "note: ") && has(outcome.err, "closed pocket") && has(outcome.err, "'unburned'"))
      << outcome.err;
  const Record data = read("burned.vtp");
  expect_sound(data);
  const auto unburned = of_points(data, "unburned"), et = of_points(data, "erosion_thickness"),
             bt = of_points(data, "burn_time");
  double finite_et = 0, finite_bt = 0, pocket = 0;
  for (std::size_t v = 0; v < et.size(); ++v) {
    pocket += unburned[v];
    if (unburned[v] == 1) continue;
    finite_et = std::max(finite_et, et[v]);
    finite_bt = std::max(finite_bt, bt[v]);
  }
  EXPECT_GT(pocket, 0.1 * static_cast<double>(et.size()));
  EXPECT_EQ(field(data, "max_burn_time"), finite_bt);
  for (std::size_t v = 0; v < et.size(); ++v) {
    if (unburned[v] == 1) {
      EXPECT_EQ(et[v], finite_et);
      EXPECT_EQ(bt[v], finite_bt);
    }
  }
  EXPECT_TRUE(has(bytes("report.json"), fmt::format("\"unburned\": {:.0f}", pocket)));
}

TEST_F(Burn, NothingButAPocket) {
  folder.write("t.ma", "4 0 4\nv 0 0 0 1\nv 1 0 0 1\nv 0 1 0 1\nv 0 0 1 1\nf 0 1 2\nf 0 1 3\nf 0 2 3\nf 1 2 3\n");
  EXPECT_TRUE(has(burn({"t.ma", "-o", "out.vtp"}).err, "4 of 4"));
  const Record data = read("out.vtp");
  EXPECT_EQ(of_points(data, "unburned"), std::vector<double>(4, 1));
  EXPECT_EQ(of_points(data, "burn_time"), std::vector<double>(4, 0));
  EXPECT_EQ(of_points(data, "erosion_thickness"), std::vector<double>(4, 0));
  EXPECT_EQ(field(data, "max_burn_time"), 0);
}

// Triangles that repeat a corner, are there twice, or have corners at the same place; points of no cell.
TEST_F(Burn, DefectiveTriangles) {
  const std::string first = "3 0 1 6\n", again = "3 6 0 1\n", needle = "3 6 6 7\n", point = "3 8 8 8\n";
  // Vertices 25, 26: at the place of vertex 24, a flap with an edge of length 0; 27: alone.
  folder.write("s.ply", square_ply(3, "4 4 0\n5 4 0\n9 9 9\n", 5, again + needle + point + "3 24 25 26\n" + again));
  folder.write("s.r", square_radii("5 4 0 1\n9 9 9 2\n", 2));
  const auto outcome = burn({"s.ply", "--radii", "s.r", "-o", "out.vtp"});
  EXPECT_TRUE(has(outcome.err, "note: 's.ply' has 2 cells with a repeated corner")) << outcome.err;
  EXPECT_TRUE(has(outcome.err, "2 polygons twice")) << outcome.err;
  const Record data = read("out.vtp");
  expect_sound(data);
  ASSERT_EQ(data.points.size(), kPoints + 3u);
  const auto et = of_points(data, "erosion_thickness"), bt = of_points(data, "burn_time");
  for (int v = 0; v < kPoints; ++v) EXPECT_NEAR(et[static_cast<std::size_t>(v)], square_thickness(v), 0.02) << v;
  EXPECT_NEAR(et[25], 0, 1e-9);
  EXPECT_NEAR(et[26], 0, 1e-9);
  EXPECT_EQ(bt[27], 2);  // alone: gone with the shape
}

TEST_F(Burn, AreaWithoutAreaAndEdgesWithoutLength) {
  // All triangles flat, some to a point.
  folder.write("flat.ma", "5 0 3\nv 0 0 0 1\nv 1 0 0 1\nv 2 0 0 1\nv 2 0 0 1\nv 2 0 0 1\nf 0 1 2\nf 0 2 3\nf 2 3 4\n");
  burn({"flat.ma", "-o", "out.vtp"});
  expect_sound(read("out.vtp"));
  folder.write("point.ma", "3 0 1\nv 1 1 1 1\nv 1 1 1 1\nv 1 1 1 1\nf 0 1 2\n");  // no edge has a length
  burn({"point.ma", "-o", "out.vtp", "--overwrite"});
  expect_sound(read("out.vtp"));
}

TEST_F(Burn, PartsOfDimensionOneAndZero) {
  // A curve from a corner of the square and a curve of its own: their vertices burn with the shape.
  folder.write("s.ma", square_ma("v 5 5 0 0.5\nv 6 6 0 0.7\nv 9 9 0 0.2\nv 9 9 1 0.3\nv 7 7 7 0.4\n", 5,
                                 "e 24 25\ne 25 26\ne 27 28\n", 3));
  burn({"s.ma", "-o", "out.vtp"});
  const Record data = read("out.vtp");
  expect_sound(data);
  const auto et = of_points(data, "erosion_thickness"), radius = of_points(data, "radius"),
             bt = of_points(data, "burn_time");
  ASSERT_EQ(et.size(), kPoints + 5u);
  for (int v = 0; v < kPoints; ++v) EXPECT_NEAR(et[static_cast<std::size_t>(v)], square_thickness(v), 0.02) << v;
  for (std::size_t v = kPoints; v < et.size(); ++v) {
    EXPECT_EQ(et[v], 0) << v;
    EXPECT_EQ(bt[v], radius[v]) << v;
  }
  folder.write("line.ma", "2 1 0\nv 0 0 0 1\nv 1 0 0 2\ne 0 1\n");  // nothing but a curve: no nodes on it
  burn({"line.ma", "-o", "out.vtp", "--overwrite"});
  EXPECT_EQ(of_points(read("out.vtp"), "burn_time"), (std::vector<double>{1, 2}));
}

TEST_F(Burn, RunBurnsTheCore) {
  works({"sample", "box", "-o", "s.ply"});
  works({"run", "s.ply", "--resolution", "24", "-o", "dir"});
  const Record data = read("dir/core.vtp");
  expect_sound(data);
  const std::string report = bytes("dir/report.json");
  const std::size_t begin = report.find("\n  \"burn\": {"), end = report.find("\n  }", begin);
  ASSERT_NE(begin, std::string::npos) << report;
  const std::string section = report.substr(begin, end - begin);
  for (const char* member : {"omega", "nodes", "unburned", "max_burn_time"})
    EXPECT_TRUE(has(section, fmt::format("\n    \"{}\": ", member))) << member;
  EXPECT_TRUE(has(section, fmt::format("\"nodes\": {:.0f}", field(data, "burn_nodes")))) << section;
  EXPECT_NE(report.find("\n    \"burn\": ", report.find("\"seconds\"")), std::string::npos);
  // The same as core and burn one after the other, and still proved.
  works({"core", "s.ply", "--resolution", "24", "-o", "core.vtp"});
  burn({"core.vtp", "-o", "burned.vtp"});
  EXPECT_EQ(of_points(read("burned.vtp"), "burn_time"), of_points(data, "burn_time"));
  EXPECT_TRUE(has(works({"verify", "s.ply", "dir/core.vtp"}).out, ": verified\n"));
  works({"run", "s.ply", "--resolution", "24", "-o", "dir", "--omega", "0.2vox", "--radius", "linear", "--overwrite"});
  const Record other = read("dir/core.vtp");
  EXPECT_NEAR(field(other, "omega"), 0.2 * 2 / 24, 1e-12);
  EXPECT_EQ(text_field(other, "radius_rule"), "linear");
}

// 'auto' is what a burned file was burned with where a command goes on from it; `burn` burns anew.
TEST_F(Burn, AutoIsThatOfABurnedFile) {
  make_core();
  burn({"core.vtp", "-o", "a.vtp", "--propagation", "windows", "--radius", "linear", "--omega", "0.3vox"});
  burn({"a.vtp", "-o", "again.vtp"});
  const Record again = read("again.vtp");
  EXPECT_EQ(text_field(again, "propagation"), "segments");
  EXPECT_EQ(text_field(again, "radius_rule"), "exact");
  EXPECT_NE(field(again, "omega"), field(read("a.vtp"), "omega"));
  const std::string goes_on = works({"skeleton", "a.vtp", "-o", "s.vtp", "--verbose", "--json", "-"}).out;
  for (const char* said : {"\"propagation\": \"windows\"", "\"radius\": \"linear\""})
    EXPECT_TRUE(has(goes_on, said)) << goes_on;
  EXPECT_FALSE(has(goes_on, "segments")) << goes_on;
  const auto on_one_line = [](std::string text) {
    std::string words;
    for (const char c : text)
      if (c != ' ' && c != '\n')
        words += c;
      else if (!words.empty() && words.back() != ' ')
        words += ' ';
    return words;
  };
  for (const char* command : {"skeleton", "view", "parts", "tree", "run", "burn"}) {
    const bool takes = std::string(command) != "run" && std::string(command) != "burn";
    const std::string help = on_one_line(works({command, "--help"}).out);
    std::size_t said = 0;
    for (std::size_t at = 0; (at = help.find("'auto': as the file was burned, else", at)) != std::string::npos; ++at)
      ++said;
    EXPECT_EQ(said, takes ? 3u : 0u) << command;
  }
}

TEST_F(Burn, RefusesOptionsThatCannotBe) {
  make_core();
  for (const char* omega : {"0", "0vox", "-1", "-0.5vox", "nan", "inf", "abc", "1 vox", ""})
    refuses(2, {"--omega"}, {"burn", "core.vtp", "-o", "a.vtp", "--omega", omega});
  refuses(2, {"--radius", "exact"}, {"burn", "core.vtp", "-o", "a.vtp", "--radius", "round"});
  refuses(2, {"--propagation"}, {"burn", "core.vtp", "-o", "a.vtp", "--propagation", "nodes"});
  refuses(2, {"--threshold", "--shape"}, {"burn", "core.vtp", "-o", "a.vtp", "--threshold", "3"});
  refuses(2, {"AXIS"}, {"burn", "-o", "a.vtp"});
  refuses(2, {"--output"}, {"burn", "core.vtp"});
  refuses(2, {"--omega"}, {"run", "v.npy", "-o", "dir", "--omega", "0"});
  refuses(1, {"--memory-limit"}, {"burn", "core.vtp", "-o", "a.vtp", "--omega", "1e-7abs", "--memory-limit", "4G"});
}

TEST_F(Burn, RefusesInputsThatAreNoAxis) {
  std::filesystem::create_directory(folder / "folder");
  refuses(3, {"'folder' is a folder", ".vtp"}, {"burn", "folder", "-o", "o.vtp"});
  make_core();
  folder.write("s.ply", square_ply());
  folder.write("s.r", square_radii());
  folder.write("short.r", "2\n0 0 0 1\n1 0 0 1\n");
  folder.write("negative.ma", "3 0 1\nv 0 0 0 1\nv 1 0 0 -1\nv 0 1 0 1\nf 0 1 2\n");
  folder.write("nan.ma", "3 0 1\nv 0 0 0 1\nv 1 0 0 nan\nv 0 1 0 1\nf 0 1 2\n");
  folder.write("place.ma", "3 0 1\nv 0 0 0 1\nv 1 nan 0 1\nv 0 1 0 1\nf 0 1 2\n");
  folder.write("empty.ma", "0 0 0\n");
  refuses(3, {"'s.ply'", "--radii"}, {"burn", "s.ply", "-o", "a.vtp"});
  refuses(3, {"'short.r'"}, {"burn", "s.ply", "--radii", "short.r", "-o", "a.vtp"});
  refuses(3, {"'v.npy'", "volume", "quench core"}, {"burn", "v.npy", "-o", "a.vtp"});
  refuses(3, {"negative.ma"}, {"burn", "negative.ma", "-o", "a.vtp"});
  refuses(3, {"nan.ma"}, {"burn", "nan.ma", "-o", "a.vtp"});
  refuses(3, {"place.ma"}, {"burn", "place.ma", "-o", "a.vtp"});
  refuses(3, {"empty.ma"}, {"burn", "empty.ma", "-o", "a.vtp"});
  refuses(1, {"'no.vtp'"}, {"burn", "no.vtp", "-o", "a.vtp"});
  refuses(1, {"'no.r'"}, {"burn", "s.ply", "--radii", "no.r", "-o", "a.vtp"});
  refuses(1, {"'no.nrrd'"}, {"burn", "core.vtp", "--shape", "no.nrrd", "-o", "a.vtp"});
}

TEST_F(Burn, RefusesOutputs) {
  make_core();
  folder.write("old.vtp", "precious");
  folder.write("s.ma", square_ma("", 0, "", 0));
  refuses(2, {"'old.vtp'", "--overwrite"}, {"burn", "core.vtp", "-o", "old.vtp"});
  refuses(2, {"input itself"}, {"burn", "core.vtp", "-o", "./core.vtp", "--overwrite"});
  refuses(2, {"input itself"},
          {"burn", "core.vtp", "--shape", "v.npy", "-o", "a.vtp", "--json", "v.npy", "--overwrite"});
  refuses(2, {"same file"}, {"burn", "core.vtp", "-o", "a.vtp", "--json", "./a.vtp"});
  for (const char* file : {"a.obj", "a.ma", "a.r"})
    refuses(2, {file, ".vtp", ".ply"}, {"burn", "core.vtp", "-o", file});
  refuses(2, {"a.xyz"}, {"burn", "core.vtp", "-o", "a.xyz"});
  refuses(1, {"'no'", "does not exist"}, {"burn", "core.vtp", "-o", "no/a.vtp"});
  burn({"core.vtp", "-o", "old.vtp", "--overwrite", "--quiet"});
  EXPECT_TRUE(bytes("old.vtp").starts_with("<?xml"));
}

TEST_F(Burn, RealMedialAxisOfOthers) {
  REQUIRE_DATA("references/bunny7_lambda0.025.ply");
  REQUIRE_DATA("references/bunny7_lambda0.025.r");
  burn({data_file("references/bunny7_lambda0.025.ply"), "--radii", data_file("references/bunny7_lambda0.025.r"), "-o",
        "bunny.ply"});
  const Record data = read("bunny.ply");
  EXPECT_EQ(data.points.size(), 14353u);
  EXPECT_EQ(data.poly_count(), 27318u);
  const auto bt = of_points(data, "burn_time");
  EXPECT_NEAR(*std::max_element(bt.begin(), bt.end()), 39.78, 0.1);
}

}  // namespace program_burn_test
