// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <set>
#include <sstream>

#include "program.h"
#include "program_arrays.h"
#include "quench/axis.h"
#include "quench/io.h"
#include "quench/shape.h"

// `quench skeleton`, and the skeleton part of `quench run`.

using namespace quench::testing_program;
using quench::DataArray;
using quench::find_array;
using quench::Record;
using quench::Topology;

namespace program_skeleton_test {

// Of a report's section: the text between its name and the end of its object.
std::string section(const std::string& report, const std::string& name) {
  const std::size_t begin = report.find(fmt::format("\n  \"{}\": {{", name));
  return begin == std::string::npos ? "" : report.substr(begin, report.find("\n  }", begin + 1) - begin);
}
// The first number after "name": in a section, also that of a list.
double number_in(const std::string& text, const std::string& name) {
  const std::size_t at = text.find(fmt::format("\"{}\": ", name));
  return at == std::string::npos ? NAN
                                 : std::stod(text.substr(text.find_first_of("-0123456789", at + name.size() + 3)));
}
std::string betti_in(const std::string& text) {
  const std::size_t at = text.find("\"betti\": [");
  return at == std::string::npos ? "none" : text.substr(at, text.find(']', at) - at);
}

struct Sample {
  std::array<double, 3> point;
  double radius;
  long parent, type;
};
std::vector<Sample> swc_rows(const std::string& text) {
  std::vector<Sample> rows;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with('#')) continue;
    std::istringstream row(line);
    long id = 0;
    Sample s{};
    row >> id >> s.type >> s.point[0] >> s.point[1] >> s.point[2] >> s.radius >> s.parent;
    EXPECT_TRUE(row) << line;
    EXPECT_EQ(id, static_cast<long>(rows.size()) + 1);
    EXPECT_LT(s.parent, id);
    EXPECT_GE(s.radius, 0);
    rows.push_back(s);
  }
  return rows;
}
std::size_t line_count(const std::string& text) {
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}
std::size_t count(const std::string& text, const std::string& word) {
  std::size_t n = 0;
  for (std::size_t at = 0; (at = text.find(word, at)) != std::string::npos; at += word.size()) ++n;
  return n;
}

class SkeletonProgram : public ProgramTest {
 protected:
  Record read(const std::string& name) const {
    Record data = quench::io::read_record(folder / name);
    data.validate();
    return data;
  }
  Topology topology_of(const std::string& name) const { return quench::topology(quench::complex_of(read(name))); }

  /// A plate with a bar through its rim and a loop: 1 component, 1 tunnel, sheets and curves.
  void make_core() {
    constexpr int nx = 38, ny = 22, nz = 9;
    const auto inside = [](int x, int y, int z) {
      const bool plate = x >= 2 && x < 20 && y >= 2 && y < 20 && z >= 3 && z < 6;
      const bool hole = x >= 8 && x < 12 && y >= 8 && y < 12;
      const bool bar = x >= 18 && x < 36 && y >= 9 && y < 12 && z >= 3 && z < 6;
      return (plate && !hole) || bar;
    };
    std::string samples;
    for (int z = 0; z < nz; ++z)
      for (int y = 0; y < ny; ++y)
        for (int x = 0; x < nx; ++x) samples += inside(x, y, z) ? '\1' : '\0';
    folder.write("v.npy", npy(nx, ny, nz, samples));
    works({"core", "v.npy", "--lambda", "0", "-o", "core.vtp"});
  }
  Outcome skeleton(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "skeleton");
    return works(arguments);
  }
  void refuses_skeleton(int code, const std::vector<std::string>& words, std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "skeleton");
    refuses(code, words, arguments);
  }
};

TEST_F(SkeletonProgram, HelpNamesIt) {
  EXPECT_TRUE(has(works({"--help"}).out, "\n  skeleton "));
  const auto help = works({"skeleton", "--help"});
  EXPECT_TRUE(has(help.out, "Example:\n  quench skeleton ")) << help.out;
  for (const char* part : {"--theta2", "--theta1", "--smooth", "--resample", "--root", "--full", "--swc", "--graphml",
                           "--csv", "--omega", "--radii", "--shape"})
    EXPECT_TRUE(has(help.out, part)) << part;
  for (const char* jargon : {"TEXT", "INT", "FLOAT", ":{"}) EXPECT_FALSE(has(help.out, jargon)) << jargon;
}

TEST_F(SkeletonProgram, BurnsWhatIsUnburned) {
  make_core();
  works({"burn", "core.vtp", "-o", "burned.vtp"});
  skeleton({"core.vtp", "-o", "a.vtp"});
  skeleton({"burned.vtp", "-o", "b.vtp"});
  EXPECT_EQ(bytes("a.vtp"), bytes("b.vtp"));
}

TEST_F(SkeletonProgram, RepeatsTheBurnOfTheFile) {
  make_core();
  works({"burn", "core.vtp", "-o", "burned.vtp", "--omega", "0.3vox", "--radius", "linear"});
  skeleton({"burned.vtp", "-o", "a.vtp"});
  const Record data = read("a.vtp");
  EXPECT_DOUBLE_EQ(field(data, "omega"), 0.3);
  EXPECT_EQ(text_field(data, "radius_rule"), "linear");
  skeleton({"core.vtp", "-o", "b.vtp", "--omega", "0.3vox", "--radius", "linear"});
  EXPECT_EQ(numbers(read("b.vtp").point_data, "burn_time"), numbers(data.point_data, "burn_time"));
  EXPECT_EQ(numbers(read("b.vtp").cell_data, "curve_level"), numbers(data.cell_data, "curve_level"));
  // An option overrides what the file says.
  skeleton({"burned.vtp", "-o", "c.vtp", "--radius", "exact"});
  EXPECT_EQ(text_field(read("c.vtp"), "radius_rule"), "exact");
  EXPECT_DOUBLE_EQ(field(read("c.vtp"), "omega"), 0.3);
}

TEST_F(SkeletonProgram, BurnsNothingThatIsBurned) {
  make_core();
  const char* const taken = "the file is burned on ";
  works({"burn", "core.vtp", "-o", "burned.vtp"});
  Record plain = read("burned.vtp");
  EXPECT_GT(std::erase_if(plain.field_data, [](const DataArray& a) { return a.name.starts_with("sequence_"); }), 0u);
  quench::io::write_record(folder / "plain.vtp", plain);
  for (const char* full : {"", "--full"}) {
    std::vector<std::string> arguments{"skeleton", "burned.vtp", "-o",        "a.vtp",
                                       "--theta2", "0.02",       "--verbose", "--overwrite"};
    if (*full) arguments.emplace_back(full);
    const Outcome once = works(arguments);
    arguments[1] = "plain.vtp";
    arguments[3] = "b.vtp";
    const Outcome again = works(arguments);
    EXPECT_TRUE(has(once.err, taken)) << once.err;
    EXPECT_FALSE(has(once.err, "note: ")) << once.err;
    EXPECT_FALSE(has(again.err, taken) || has(again.err, "note: ")) << again.err;
    EXPECT_EQ(bytes("a.vtp"), bytes("b.vtp"));
  }
  // Another spacing is another burning.
  const Outcome other = skeleton({"burned.vtp", "-o", "c.vtp", "--omega", "0.3vox", "--verbose"});
  EXPECT_FALSE(has(other.err, taken) || has(other.err, "note: ")) << other.err;
  // Other programs change points and keep what they do not know.
  Record moved = read("burned.vtp");
  for (quench::Vec3& p : moved.points) p *= 2;
  quench::io::write_record(folder / "moved.vtp", moved);
  const Outcome changed = skeleton({"moved.vtp", "-o", "d.vtp", "--verbose"});
  EXPECT_FALSE(has(changed.err, taken));
  EXPECT_TRUE(has(changed.err, "note: the burn sequence in the file does not fit its medial axis")) << changed.err;
}

TEST_F(SkeletonProgram, FamilyKeepsTheTopology) {
  make_core();
  const Topology wanted = topology_of("core.vtp");
  EXPECT_EQ(wanted.betti[1], 1);
  for (const char* theta2 : {"0", "0.03", "2vox", "inf"})
    for (const char* theta1 : {"0", "0.02", "3abs", "inf"}) {
      SCOPED_TRACE(fmt::format("{} {}", theta2, theta1));
      skeleton({"core.vtp", "-o", "a.vtp", "--theta2", theta2, "--theta1", theta1, "--json", "a.json", "--overwrite"});
      const Record data = read("a.vtp");
      const Topology found = quench::topology(quench::complex_of(data));
      EXPECT_EQ(found, wanted);
      EXPECT_EQ(numbers(data.field_data, "euler"), std::vector<double>{static_cast<double>(wanted.euler)});
      EXPECT_EQ(numbers(data.field_data, "betti"), (std::vector<double>{1, 1, 0}));
      const std::string report = bytes("a.json");
      for (const char* part : {"curves", "skeleton"}) {
        EXPECT_EQ(number_in(section(report, part), "euler"), 0) << report;
        EXPECT_EQ(betti_in(section(report, part)), betti_in(section(report, "curves")));
      }
      EXPECT_EQ(number_in(section(report, "skeleton"), "faces"), static_cast<double>(data.poly_count()));
      EXPECT_EQ(number_in(section(report, "skeleton"), "vertices"), static_cast<double>(data.points.size()));
      // What `inf` means at both ends.
      if (theta2 == std::string("inf")) {
        EXPECT_EQ(data.poly_count(), 0u);
        EXPECT_TRUE(has(report, "\"theta2\": \"inf\""));
        EXPECT_GT(data.lines.size(), 10u);
      }
      if (theta2 == std::string("0")) {
        EXPECT_GT(data.poly_count(), 100u);
      }
      if (theta1 == std::string("inf")) {
        EXPECT_TRUE(has(report, "\"theta1\": \"inf\""));
        EXPECT_EQ(number_in(section(report, "skeleton"), "ends"), 0);  // the shape has a loop: no tree is left
      }
    }
}

TEST_F(SkeletonProgram, ParametersNest) {
  make_core();
  const auto size = [&](const char* theta2, const char* theta1) {
    skeleton({"core.vtp", "-o", "a.vtp", "--theta2", theta2, "--theta1", theta1, "--overwrite"});
    const Record data = read("a.vtp");
    return std::pair(data.poly_count(), data.lines.size());
  };
  EXPECT_GE(size("0", "0").first, size("0.05", "0").first);
  EXPECT_GE(size("0.05", "0").first, size("0.2", "0").first);
  EXPECT_GT(size("inf", "0").second, size("inf", "0.02").second);
  EXPECT_GE(size("inf", "0.02").second, size("inf", "0.1").second);
  EXPECT_GT(size("inf", "0.1").second, size("inf", "inf").second);
}

TEST_F(SkeletonProgram, ArraysAndFields) {
  make_core();
  skeleton({"core.vtp", "-o", "a.vtp"});
  const Record data = read("a.vtp");
  for (const char* name : {"radius", "burn_time", "erosion_thickness", "curve_burn_time", "curve_erosion_thickness",
                           "unburned", "curve_unburned"}) {
    const auto values = numbers(data.point_data, name);
    ASSERT_EQ(values.size(), data.points.size()) << name;
    for (const double v : values) ASSERT_TRUE(std::isfinite(v) && v >= 0) << name;
  }
  const std::size_t cells = data.verts.size() + data.lines.size() + data.poly_count();
  for (const char* name : {"kind", "component", "sheet_level", "curve_level"}) {
    const auto values = numbers(data.cell_data, name);
    ASSERT_EQ(values.size(), cells) << name;
    for (const double v : values) ASSERT_TRUE(std::isfinite(v)) << name;
  }
  const auto kind = numbers(data.cell_data, "kind");
  for (std::size_t c = 0; c < cells; ++c)
    ASSERT_EQ(kind[c], c < data.verts.size() ? 2 : c < data.verts.size() + data.lines.size() ? 1 : 0) << c;
  EXPECT_EQ(text_field(data, "stage"), "skeleton");
  EXPECT_EQ(text_field(data, "version"), QUENCH_TEST_VERSION);
  EXPECT_EQ(numbers(data.field_data, "spacing"), (std::vector<double>{1, 1, 1}));
  EXPECT_GT(field(data, "theta2"), 0);
  EXPECT_GT(field(data, "theta1"), 0);
  // Sheets below theta2 are there only where topology needs them, or where they grew back to their rims: every face
  // that is free stays by its level.
  const auto level = numbers(data.cell_data, "sheet_level");
  ASSERT_LT(field(data, "rims_above"), field(data, "theta2"));
  for (std::size_t c = cells - data.poly_count(); c < cells; ++c) ASSERT_GE(level[c], field(data, "rims_above"));
}

TEST_F(SkeletonProgram, LengthsInAllUnits) {
  make_core();
  const auto theta = [&](const char* name, const std::string& length) {
    skeleton({"core.vtp", "-o", "a.vtp", "--overwrite", std::string("--") + name, length});
    return field(read("a.vtp"), name);
  };
  for (const char* name : {"theta2", "theta1"}) {
    EXPECT_DOUBLE_EQ(theta(name, "0.05"), 1.7);  // of the longest side, 34
    EXPECT_DOUBLE_EQ(theta(name, "10%"), 3.4);
    EXPECT_DOUBLE_EQ(theta(name, "2.5vox"), 2.5);
    EXPECT_DOUBLE_EQ(theta(name, "0.7abs"), 0.7);
    EXPECT_DOUBLE_EQ(theta(name, "0"), 0);
    EXPECT_GT(theta(name, "inf"), 1e38);
  }
}

TEST_F(SkeletonProgram, GraphFiles) {
  make_core();
  const auto outcome = skeleton({"core.vtp", "--theta2", "inf", "-o", "a.vtp", "--swc", "a.swc", "--graphml",
                                 "a.graphml", "--csv", "a.csv", "--json", "a.json"});
  const std::string report = section(bytes("a.json"), "skeleton");
  const std::string swc = bytes("a.swc"), graphml = bytes("a.graphml"), csv = bytes("a.csv");
  const auto rows = swc_rows(swc);
  EXPECT_EQ(static_cast<double>(rows.size()), number_in(report, "samples"));
  std::size_t roots = 0;
  for (const Sample& s : rows) roots += s.parent == -1;
  EXPECT_EQ(roots, 1u);
  EXPECT_TRUE(has(swc, "loops cut 1\n") && has(swc, "# loop cut at ")) << swc.substr(0, 300);
  EXPECT_TRUE(has(outcome.err, "a.swc") && has(outcome.err, "cut")) << outcome.err;
  const double branches = number_in(report, "branches");
  EXPECT_GE(branches, 2);
  EXPECT_EQ(static_cast<double>(line_count(csv)), branches + 1);
  EXPECT_EQ(static_cast<double>(count(graphml, "<edge ")), branches);
  EXPECT_TRUE(csv.starts_with("branch,from,to,component,"));
  // Ends and junctions: chi of the graph is that of the shape, 0.
  EXPECT_EQ(static_cast<double>(count(graphml, "<node ")), branches);
  EXPECT_GE(number_in(report, "ends"), 1);
  EXPECT_GE(number_in(report, "junctions"), 1);
  double length = 0;
  for (const Sample& s : rows) {
    if (s.parent < 0) continue;
    const auto& p = rows[static_cast<std::size_t>(s.parent) - 1].point;
    length += std::hypot(s.point[0] - p[0], s.point[1] - p[1], s.point[2] - p[2]);
  }
  EXPECT_NEAR(length, number_in(report, "curve_length"), 2);  // all but the cut
}

// Programs for neurons refuse the type 0.
TEST_F(SkeletonProgram, TypesOfSwcSamples) {
  make_core();
  const auto types = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words{"core.vtp", "--theta2", "inf", "-o", "a.vtp", "--swc", "a.swc", "--overwrite"};
    words.insert(words.end(), more.begin(), more.end());
    skeleton(words);
    std::set<long> found;
    for (const Sample& s : swc_rows(bytes("a.swc"))) found.insert(s.type);
    return found;
  };
  EXPECT_EQ(types({}), std::set<long>{3});
  EXPECT_TRUE(has(bytes("a.swc"), "# type of every sample: 3 (dendrite)")) << bytes("a.swc").substr(0, 400);
  EXPECT_EQ(types({"--swc-type", "7"}), std::set<long>{7});
  EXPECT_EQ(types({"--swc-type", "18"}), std::set<long>{18});
  EXPECT_EQ(types({"--swc-type", "0"}), std::set<long>{0});
  for (const auto& [name, number] : {std::pair{"soma", 1L}, std::pair{"axon", 2L}, std::pair{"basal-dendrite", 3L},
                                     std::pair{"apical-dendrite", 4L}, std::pair{"custom", 5L}})
    EXPECT_EQ(types({"--swc-type", name}), std::set<long>{number}) << name;
  for (const char* type : {"-1", "256", "1.5", "0x3", "twig"})
    refuses_skeleton(2, {fmt::format("--swc-type '{}' is not", type), "soma, axon"},
                     {"core.vtp", "-o", "b.vtp", "--swc", "b.swc", "--swc-type", type});
}

TEST_F(SkeletonProgram, RootSmoothingAndResampling) {
  make_core();
  const auto swc = [&](std::vector<std::string> more) {
    more.insert(more.begin(),
                {"core.vtp", "--theta2", "inf", "--theta1", "0.02", "-o", "a.vtp", "--swc", "a.swc", "--overwrite"});
    skeleton(more);
    return swc_rows(bytes("a.swc"));
  };
  const auto first = swc({"--root", "35,10,4"}).front(), other = swc({"--root", "-5,-5.5,4e0"}).front();
  EXPECT_GT(first.point[0], 28);  // the free end of the bar
  EXPECT_LT(other.point[0], 12);
  EXPECT_EQ(first.parent, -1);
  const auto length = [](const std::vector<Sample>& rows) {
    double sum = 0;
    for (const Sample& s : rows) {
      if (s.parent < 0) continue;
      const auto& p = rows[static_cast<std::size_t>(s.parent) - 1].point;
      sum += std::hypot(s.point[0] - p[0], s.point[1] - p[1], s.point[2] - p[2]);
    }
    return sum;
  };
  const auto rough = swc({"--smooth", "0"}), smooth = swc({"--smooth", "40"});
  EXPECT_LE(length(smooth), length(rough) + 1e-9);
  // In a thick shape points are as far apart as asked.
  folder.write("line.ma", "3 2 0\nv 0 0 0 1\nv 1 0 0 2\nv 2 0 0 1\ne 0 1\ne 1 2\n");
  skeleton({"line.ma", "--theta1", "0", "-o", "l.vtp", "--swc", "l.swc", "--resample", "0.5abs"});
  EXPECT_EQ(swc_rows(bytes("l.swc")).size(), 5u);
  EXPECT_EQ(read("l.vtp").points.size(), 5u);  // the skeleton is the same
}

TEST_F(SkeletonProgram, FullHasItsOwnPartsAndLevels) {
  make_core();
  skeleton({"core.vtp", "--theta2", "0", "-o", "a.vtp"});
  skeleton({"core.vtp", "--theta2", "0", "--full", "-o", "b.vtp"});
  const Record merged = read("a.vtp"), full = read("b.vtp");
  EXPECT_GT(full.poly_count(), merged.poly_count());
  EXPECT_EQ(topology_of("a.vtp"), topology_of("b.vtp"));
  // The levels of the full file pick the faces of any larger theta2.
  const double theta2 = 1.0;
  skeleton({"core.vtp", "--theta2", "1abs", "--full", "-o", "c.vtp"});
  const Record larger = read("c.vtp");
  std::size_t kept = 0;
  const auto level = numbers(full.cell_data, "sheet_level");
  for (std::size_t c = level.size() - full.poly_count(); c < level.size(); ++c) kept += level[c] >= theta2;
  EXPECT_EQ(kept, larger.poly_count());
}

TEST_F(SkeletonProgram, OtherFormats) {
  make_core();
  for (const char* file : {"a.vtp", "a.ply", "a.obj", "a.csv"}) skeleton({"core.vtp", "-o", file});
  const Topology wanted = topology_of("core.vtp");
  for (const char* file : {"a.ply", "a.obj"}) EXPECT_EQ(topology_of(file), wanted) << file;
  EXPECT_EQ(line_count(bytes("a.csv")), read("a.vtp").points.size() + 1);
}

// A square of unit cells with a curve at a corner, as another program writes it; a curve without area; a point.
TEST_F(SkeletonProgram, ForeignAxis) {
  std::string text = "27 1 32\n";
  for (int j = 0; j < 5; ++j)
    for (int i = 0; i < 5; ++i) text += fmt::format("v {} {} 0 1\n", i, j);
  text += "v 5 5 0 1\nv 9 9 9 0.5\ne 24 25\n";
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 4; ++i) {
      const int v = 5 * j + i;
      text += fmt::format("f {} {} {}\nf {} {} {}\n", v, v + 1, v + 6, v, v + 6, v + 5);
    }
  folder.write("s.ma", text);
  for (const char* theta2 : {"0", "0.1", "inf"}) {
    skeleton({"s.ma", "--theta2", theta2, "-o", "a.vtp", "--swc", "a.swc", "--overwrite"});
    const Topology t = topology_of("a.vtp");
    EXPECT_EQ(t.betti[0], 2) << theta2;
    EXPECT_EQ(t.euler, 2) << theta2;
  }
  EXPECT_GE(swc_rows(bytes("a.swc")).size(), 3u);
  folder.write("line.ma", "3 2 0\nv 0 0 0 1\nv 1 0 0 2\nv 2 0 0 1\ne 0 1\ne 1 2\n");
  skeleton({"line.ma", "-o", "a.vtp", "--swc", "a.swc", "--theta1", "0", "--overwrite"});
  EXPECT_EQ(swc_rows(bytes("a.swc")).size(), 3u);
  skeleton({"line.ma", "-o", "a.vtp", "--swc", "a.swc", "--theta1", "inf", "--overwrite"});
  EXPECT_EQ(swc_rows(bytes("a.swc")).size(), 1u);  // a tree keeps its medial point
  EXPECT_EQ(read("a.vtp").verts.size(), 1u);
}

TEST_F(SkeletonProgram, ClosedSheet) {
  works({"sample", "hollow-sphere", "-o", "s.ply", "--fineness", "0.3"});
  works({"core", "s.ply", "--resolution", "24", "-o", "core.vtp"});
  const auto outcome = skeleton({"core.vtp", "-o", "a.vtp", "--theta2", "inf", "--theta1", "inf", "--swc", "a.swc",
                                 "--graphml", "a.graphml", "--csv", "a.csv", "--json", "a.json"});
  EXPECT_TRUE(has(outcome.err, "sheets without curves")) << outcome.err;
  EXPECT_EQ(topology_of("a.vtp").betti, (std::array<std::int64_t, 3>{1, 0, 1}));
  EXPECT_GT(read("a.vtp").poly_count(), 100u);  // a closed pocket stays, also for `inf`
  EXPECT_TRUE(swc_rows(bytes("a.swc")).empty());
  EXPECT_TRUE(has(bytes("a.swc"), "# component 0 is a sheet without curves")) << bytes("a.swc");
  EXPECT_EQ(line_count(bytes("a.csv")), 1u);
  EXPECT_TRUE(has(bytes("a.graphml"), "</graphml>"));
  EXPECT_EQ(number_in(section(bytes("a.json"), "skeleton"), "trees"), 0);
}

TEST_F(SkeletonProgram, RunWritesAllFiles) {
  works({"sample", "root", "-o", "s.ply", "--branches", "5", "--fineness", "0.3"});
  works({"run", "s.ply", "--resolution", "48", "-o", "a"});
  for (const char* file :
       {"core.vtp", "skeleton.vtp", "skeleton.swc", "branches.csv", "parts.csv", "report.json", "picture.png"})
    EXPECT_TRUE(exists(std::string("a/") + file)) << file;
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder / "a"), {}),
            7 + exists("a/view.html"));  // where the page is built in
  const std::string report = bytes("a/report.json");
  for (const char* part : {"curves", "skeleton"}) {
    EXPECT_EQ(betti_in(section(report, part)), betti_in(section(report, "shape"))) << part;
    EXPECT_EQ(number_in(section(report, part), "euler"), number_in(section(report, "shape"), "euler")) << part;
    EXPECT_NE(report.find(fmt::format("\n    \"{}\": ", part), report.find("\"seconds\"")), std::string::npos);
  }
  for (const char* member : {"theta2", "theta1", "vertices", "edges", "faces", "reconstructed", "branches"})
    EXPECT_TRUE(has(section(report, "skeleton"), fmt::format("\n    \"{}\": ", member))) << member;
  EXPECT_EQ(line_count(bytes("a/branches.csv")), number_in(section(report, "skeleton"), "branches") + 1);
  EXPECT_EQ(line_count(bytes("a/parts.csv")), number_in(section(report, "skeleton"), "sheets") + 1);
  const std::string thickness = section(report, "thickness");
  for (const char* member : {"sheets", "shape", "mean", "percentiles", "correction"})
    EXPECT_TRUE(has(thickness, fmt::format("\"{}\": ", member))) << member;
  // Again, with another number of threads: the same bytes. And by the commands one after the other.
  works({"run", "s.ply", "--resolution", "48", "-o", "b", "--threads", "1", "--quiet"});
  works({"run", "s.ply", "--resolution", "48", "-o", "b", "--threads", "2", "--quiet", "--overwrite"});
  skeleton({"a/core.vtp", "-o", "s.vtp"});  // (its branches are smoothed without the shape)
  for (const char* file : {"core.vtp", "skeleton.vtp", "skeleton.swc", "branches.csv", "parts.csv"})
    EXPECT_EQ(bytes(std::string("a/") + file), bytes(std::string("b/") + file)) << file;
  const Record run = read("a/skeleton.vtp"), alone = read("s.vtp");
  EXPECT_EQ(run.lines, alone.lines);
  EXPECT_EQ(run.poly_corners, alone.poly_corners);
  for (const char* name : {"branch", "component", "sheet_level", "curve_level", "curve_erosion_thickness"})
    EXPECT_EQ(numbers(run.cell_data, name), numbers(alone.cell_data, name)) << name;
  // VTK sees one polyline per branch.
  const std::vector<double> branch = numbers(run.cell_data, "branch");
  EXPECT_TRUE(has(bytes("a/skeleton.vtp"),
                  fmt::format("NumberOfLines=\"{:.0f}\"", *std::max_element(branch.begin(), branch.end()) + 1)));
}

TEST_F(SkeletonProgram, Refusals) {
  make_core();
  folder.write("old.swc", "old");
  for (const char* option : {"--theta2", "--theta1", "--resample"})
    for (const char* length : {"-1", "-0.5vox", "nan", "abc", "1 vox", ""})
      refuses_skeleton(2, {option}, {"core.vtp", "-o", "a.vtp", option, length});
  refuses_skeleton(2, {"--smooth"}, {"core.vtp", "-o", "a.vtp", "--smooth", "-1"});
  for (const char* root : {"1", "1,2", "1,2,3,4", "a,b,c", "1,2,", "nan,0,0", "inf,0,0", "1;2;3"})
    refuses_skeleton(2, {"--root", "x,y,z"}, {"core.vtp", "-o", "a.vtp", "--swc", "a.swc", "--root", root});
  refuses_skeleton(2, {"two outputs", "a.vtp"}, {"core.vtp", "-o", "a.vtp", "--csv", "a.vtp"});
  refuses_skeleton(2, {"--json", "a.vtp"}, {"core.vtp", "-o", "a.vtp", "--json", "a.vtp"});
  refuses_skeleton(2, {"old.swc", "--overwrite"}, {"core.vtp", "-o", "a.vtp", "--swc", "old.swc"});
  refuses_skeleton(2, {"core.vtp", "input"}, {"core.vtp", "-o", "core.vtp", "--overwrite"});
  refuses_skeleton(2, {"core.vtp", "input"}, {"core.vtp", "-o", "a.vtp", "--swc", "core.vtp", "--overwrite"});
  refuses_skeleton(2, {"--output"}, {"core.vtp"});
  refuses_skeleton(2, {"AXIS"}, {"-o", "a.vtp"});
  refuses_skeleton(3, {"'v.npy'", "volume", "quench core"}, {"v.npy", "-o", "a.vtp"});
  folder.write("cube.off", cube_off());
  refuses_skeleton(3, {"'cube.off' is a mesh, not a medial axis"}, {"cube.off", "-o", "a.vtp"});
  refuses_skeleton(1, {"'no.vtp'"}, {"no.vtp", "-o", "a.vtp"});
  refuses(2, {"--theta2"}, {"run", "v.npy", "-o", "dir", "--theta2", "nan"});
  refuses(2, {"--root"}, {"run", "v.npy", "-o", "dir", "--root", "1,2"});
}

TEST_F(SkeletonProgram, RefusesTwoOutputsOfOneNameHoweverItIsWritten) {
  make_core();
  refuses_skeleton(2, {"two outputs", "x.swc"}, {"core.vtp", "-o", "a.vtp", "--swc", "x.swc", "--graphml", "./x.swc"});
}

TEST_F(SkeletonProgram, RefusesAnInfiniteSpacingOfPoints) {
  make_core();
  refuses_skeleton(2, {"--resample"}, {"core.vtp", "-o", "a.vtp", "--csv", "a.csv", "--resample", "inf"});
}

}  // namespace program_skeleton_test
