// SPDX-License-Identifier: Apache-2.0
#include "program.h"

#include <fmt/format.h>

#include "quench/axis.h"
#include "quench/io.h"
#include "quench/samples.h"
#include "quench/shape.h"

using namespace quench::testing_program;
using quench::find_array;
using quench::Record;

namespace program_test {

class Program : public ProgramTest {
 protected:
  Record read(const std::string& name) const {
    Record data = quench::io::read_record(folder / name);
    data.validate();
    return data;
  }
  quench::Volume volume(const std::string& name) const { return quench::io::read_volume(folder / name); }
};

std::vector<double> radii(const Record& data) {
  const auto* array = find_array(data.point_data, "radius");
  return array ? array->numbers() : std::vector<double>();
}

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST_F(Program, HelpAndVersion) {
  EXPECT_EQ(works({"--version"}).out, "quench " QUENCH_TEST_VERSION "\n");
  const std::string all = works({"--help"}).out;
  for (const char* command : {"run", "sample", "voxelize", "core", "view", "info", "convert", "verify"}) {
    EXPECT_TRUE(has(all, std::string("\n  ") + command));
    const auto help = works({command, "--help"});
    EXPECT_TRUE(has(help.out, std::string("Example:\n  quench ") + command)) << help.out;
    EXPECT_EQ(help.err, "");
    for (const char* jargon : {"TEXT", "INT", "FLOAT", ":{"})
      EXPECT_FALSE(has(help.out, jargon)) << command << " says " << jargon;
  }
}

TEST_F(Program, SamplesAsMeshAndVolume) {
  for (const auto& info : quench::built_in_samples()) {
    const std::string name(info.name);
    works({"sample", name, "-o", name + ".ply", "--fineness", "0.2"});
    const int resolution = name == "bars" ? 64 : 24;  // bars are thin
    works({"sample", name, "-o", name + ".nrrd", "--resolution", std::to_string(resolution), "--fineness", "0.2",
           "--overwrite"});
    EXPECT_GT(read(name + ".ply").poly_count(), 3u) << name;
    EXPECT_EQ(std::max({volume(name + ".nrrd").grid.dims[0], volume(name + ".nrrd").grid.dims[1],
                        volume(name + ".nrrd").grid.dims[2]}),
              resolution + 2)
        << name;
  }
  EXPECT_TRUE(has(bytes("root.json"), "\"branches\""));
  works({"sample", "box", "-o", "box.obj"});
  works({"sample", "box", "-o", "box.vtp"});
  EXPECT_EQ(read("box.obj").poly_count(), 12u);
  EXPECT_EQ(read("box.vtp").poly_count(), 12u);
}

TEST_F(Program, RootInGreyValuesWithItsDamage) {
  const std::vector<std::string> root{"sample", "root",       "--branches", "20",     "--grey", "--resolution",
                                      "48",     "--touching", "1",          "--gaps", "2",      "--blur",
                                      "0.8",    "--noise",    "0.1",        "-o"};
  const auto written = [&](const std::string& file, const std::vector<std::string>& more) {
    std::vector<std::string> line = root;
    line.push_back(file);
    line.insert(line.end(), more.begin(), more.end());
    return works(line).err;
  };
  const std::string said = written("a.nrrd", {"--threads", "1"});
  EXPECT_TRUE(has(said, "20 true branches, 3 damaged places")) << said;
  written("b.nrrd", {"--threads", "2"});
  EXPECT_EQ(bytes("a.nrrd"), bytes("b.nrrd"));
  const std::string truth = bytes("a.json");
  for (const char* part : {"\"kind\": \"gap\"", "\"kind\": \"touching\"", "\"level\": 2", "\"on_purpose\": true"})
    EXPECT_TRUE(has(truth, part)) << part;
  works({"core", "a.nrrd", "--threshold", "125", "-o", "a.vtp"});
}

TEST_F(Program, VoxelizeGivesTheSameShapeAgain) {
  works({"sample", "torus", "-o", "torus.ply", "--fineness", "0.2"});
  works({"voxelize", "torus.ply", "--resolution", "32", "-o", "a.nrrd", "--json", "a.json"});
  works({"voxelize", "a.nrrd", "-o", "b.nrrd"});
  EXPECT_EQ(bytes("a.nrrd"), bytes("b.nrrd"));
  EXPECT_TRUE(has(bytes("a.json"), "\"betti\": [\n      1,\n      1,\n      0\n"));
  works({"voxelize", "a.nrrd", "-o", "c.nrrd", "--subdivide", "2"});
  EXPECT_EQ(volume("c.nrrd").grid.dims[0], 2 * volume("a.nrrd").grid.dims[0]);
}

TEST_F(Program, CoreInEveryFormat) {
  works({"sample", "fin-on-board", "-o", "shape.ply"});
  for (const char* file : {"a.vtp", "a.ply", "a.obj", "a.ma", "a.r", "a.csv"}) {
    const auto outcome = works({"core", "shape.ply", "--resolution", "40", "-o", file});
    EXPECT_EQ(outcome.out, "");
    EXPECT_TRUE(has(outcome.err, file)) << outcome.err;
  }
  const Record vtp = read("a.vtp");
  const auto topology = quench::topology(quench::complex_of(vtp));
  EXPECT_EQ(topology.euler, 1);
  for (const char* file : {"a.ply", "a.obj", "a.ma"}) {
    const Record other = read(file);
    EXPECT_EQ(other.points.size(), vtp.points.size()) << file;
    EXPECT_EQ(quench::topology(quench::complex_of(other)), topology) << file;
  }
  EXPECT_EQ(radii(read("a.ma")), radii(vtp));
  EXPECT_EQ(quench::io::read_radii(folder / "a.r", vtp.points), radii(vtp));
  const std::string csv = bytes("a.csv");
  EXPECT_EQ(static_cast<std::size_t>(std::count(csv.begin(), csv.end(), '\n')), vtp.points.size() + 1);
}

TEST_F(Program, RunWritesAxisAndReport) {
  works({"sample", "hollow-sphere", "-o", "a shape.ply", "--fineness", "0.2"});
  const auto outcome = works({"run", "a shape.ply", "--resolution", "24", "-o", "new/my result"});
  EXPECT_EQ(outcome.out, "");
  const std::size_t line = outcome.err.rfind("new/my result/core.vtp: ");  // what, where, in which units
  const std::string last = outcome.err.substr(line);
  for (const char* part :
       {"new/my result/core.vtp: ", " vertices", "lengths in the input's units", "new/my result/report.json"})
    EXPECT_TRUE(has(last, part)) << last;
  const std::string report = bytes("new/my result/report.json");
  for (const char* section : {"input", "parameters", "shape", "core", "pruned", "burn", "curves", "skeleton", "picture",
                              "seconds", "peak_bytes", "version"})
    EXPECT_TRUE(has(report, fmt::format("\n  \"{}\": ", section))) << section;
  for (const char* member : {"file",     "kind",     "euler", "components",    "dims",
                             "spacing",  "voxels",   "sites", "betti",         "voxelization_changed_topology",
                             "vertices", "edges",    "faces", "reconstructed", "detail",
                             "voxelize", "delaunay", "prune", "write",         "total"})
    EXPECT_TRUE(has(report, fmt::format("\n    \"{}\": ", member))) << member;
  works({"run", "a shape.ply", "--resolution", "24", "-o", "new/my result", "--overwrite", "--quiet"});
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder / "new/my result"), {}),
            7 + exists("new/my result/view.html"));  // where the page is built in
  EXPECT_TRUE(has(works({"verify", "a shape.ply", "new/my result/core.vtp"}).out, ": verified\n"));
}

TEST_F(Program, QuietIsSilentAndVerboseSaysMore) {
  folder.write("v.npy", npy_box(3, 4, 5, 1));
  const auto quiet = works({"core", "v.npy", "-o", "a.vtp", "--quiet"});
  EXPECT_EQ(quiet.out + quiet.err, "");
  const auto plain = works({"core", "v.npy", "-o", "b.vtp"});
  const auto verbose = works({"core", "v.npy", "-o", "c.vtp", "--verbose"});
  EXPECT_FALSE(has(plain.err, "at the peak"));
  EXPECT_TRUE(has(verbose.err, "at the peak"));
  const auto report = works({"core", "v.npy", "-o", "d.vtp", "--json", "-"});
  EXPECT_TRUE(report.out.starts_with("{\n") && report.out.ends_with("}\n")) << report.out;
}

TEST_F(Program, Info) {
  folder.write("cube.off", cube_off());
  folder.write("open.off", cube_off(true));
  folder.write("v.npy", npy_box(3, 4, 5, 1));
  const auto mesh = works({"info", "cube.off"});
  EXPECT_EQ(mesh.err, "");
  for (const char* part : {"kind: mesh\n", " euler: 2\n", " closed: true\n", " boundary_edges: 0\n"})
    EXPECT_TRUE(has(mesh.out, part)) << part << mesh.out;
  EXPECT_TRUE(has(works({"info", "open.off", "--json"}).out, "\"boundary_edges\": 3,"));
  const auto image = works({"info", "v.npy", "--json"});
  for (const char* part : {"\"kind\": \"volume\"", "\"type\": \"uint8\"", "\"0\": 150", "\"1\": 60"})
    EXPECT_TRUE(has(image.out, part)) << part << image.out;
  works({"core", "v.npy", "-o", "axis.vtp"});
  const auto axis = works({"info", "axis.vtp"});
  for (const char* part : {"kind: medial axis\n", "betti: [1,0,0]", "radius: type float64"})
    EXPECT_TRUE(has(axis.out, part)) << part << axis.out;
  EXPECT_TRUE(has(works({"info", "axis.vtp", "--json"}).out, "\"detail_level\""));
}

TEST_F(Program, InfoOfNumbersThatAreNone) {
  const std::string inf("\0\0\x80\x7f", 4), nan("\0\0\xc0\x7f", 4), one("\0\0\x80\x3f", 4);
  folder.write("v.npy", npy(1, 1, 4, nan + one + inf + one, "<f4"));
  const std::string out = works({"info", "v.npy", "--json"}).out;
  for (const char* part : {"\"min\": 1.0", "\"max\": \"inf\"", "\"not_a_number\": 1", "\"1\": 2"})
    EXPECT_TRUE(has(out, part)) << part << out;
}

TEST_F(Program, ConvertKeepsVerticesAndRadii) {
  works({"sample", "torus", "-o", "torus.ply", "--fineness", "0.2"});
  works({"core", "torus.ply", "--resolution", "24", "-o", "a.vtp"});
  works({"convert", "a.vtp", "b.ma"});
  works({"convert", "b.ma", "c.vtp"});
  works({"convert", "c.vtp", "d.ply"});
  const Record a = read("a.vtp"), c = read("c.vtp");
  EXPECT_EQ(a.points, c.points);
  EXPECT_EQ(radii(a), radii(c));
  EXPECT_EQ(quench::topology(quench::complex_of(a)), quench::topology(quench::complex_of(c)));
  EXPECT_EQ(read("d.ply").points.size(), a.points.size());
  for (const char* file : {"e.obj", "e.r", "e.csv"}) works({"convert", "a.vtp", file});
  works({"convert", "e.obj", "f.ma", "--radii", "e.r"});
  EXPECT_EQ(radii(read("f.ma")), radii(a));
  works({"convert", "a.vtp", "q.ply", "--quality", "lambda"});
  refuses(2, {"no_such_array"}, {"convert", "a.vtp", "r.ply", "--quality", "no_such_array"});
  refuses(3, {"'torus.ply'", "--radii", ".ma"}, {"convert", "torus.ply", "t.ma"});
}

TEST_F(Program, VerifyFindsSabotage) {
  works({"sample", "box", "-o", "box.ply"});
  works({"core", "box.ply", "--resolution", "20", "--lambda", "auto", "-o", "a.vtp"});
  // Other formats do not hold the voxel core's geometry beside a fitted one.
  works({"core", "box.ply", "--resolution", "20", "--lambda", "2vox", "--surface", "voxels", "-o", "a.ply"});
  EXPECT_TRUE(has(works({"verify", "box.ply", "a.vtp"}).out, "a.vtp: verified\n"));
  const auto json = works({"verify", "box.ply", "a.vtp", "--json", "-"});
  EXPECT_TRUE(json.out.starts_with("{\n") && has(json.out, "\"verified\": true")) << json.out;
  EXPECT_TRUE(has(json.out, "\"not_checked\": [") && has(json.out, "\"array\": \"field parameters\"") &&
              has(json.out, "\"cell lambda_level\""))
      << json.out;
  const auto foreign = works({"verify", "box.ply", "a.ply", "--resolution", "20", "--lambda", "2vox"});
  EXPECT_TRUE(has(foreign.out, "-    legal pruning: not checked") && has(foreign.err, "--core"))
      << foreign.out << foreign.err;
  EXPECT_TRUE(has(works({"verify", "box.ply", "a.ply", "--resolution", "20", "--lambda", "2vox", "--core"}).out,
                  "ok   legal pruning"));
  EXPECT_EQ(quench({"verify", "box.ply", "a.ply", "--resolution", "20", "--lambda", "1vox", "--core"}).code, 4)
      << "more than that was pruned";

  Record less = read("a.vtp");
  std::erase_if(less.field_data, [](const auto& array) { return array.name == "betti"; });
  quench::io::write_record(folder / "less.vtp", less);
  const auto listed = works({"verify", "box.ply", "less.vtp", "--json", "less.json"});
  EXPECT_TRUE(has(listed.out, "not in the file: field betti")) << listed.out;
  EXPECT_TRUE(has(bytes("less.json"), "\"absent\": [\n      \"field betti\"\n    ]")) << bytes("less.json");
  EXPECT_TRUE(has(foreign.out, "not in the file: field stage\n")) << foreign.out;
  std::erase_if(less.field_data, [](const auto& array) { return array.name == "dims"; });
  quench::io::write_record(folder / "less.vtp", less);
  const auto lacking = quench({"verify", "box.ply", "less.vtp"});
  EXPECT_EQ(lacking.code, 4);
  EXPECT_TRUE(has(lacking.out, "less.vtp: FAIL arrays: missing: field dims;")) << lacking.out;

  Record broken = read("a.vtp");
  broken.poly_corners.erase(broken.poly_corners.begin(), broken.poly_corners.begin() + broken.poly_offsets[1]);
  const std::uint32_t removed = broken.poly_offsets[1];
  broken.poly_offsets.erase(broken.poly_offsets.begin());
  for (auto& offset : broken.poly_offsets) offset -= removed;
  const auto row = static_cast<std::ptrdiff_t>(broken.verts.size() + broken.lines.size());
  for (auto& array : broken.cell_data) std::visit([&](auto& v) { v.erase(v.begin() + row); }, array.values);
  quench::io::write_record(folder / "hole.vtp", broken);
  const auto hole = quench({"verify", "box.ply", "a.vtp", "hole.vtp"});
  EXPECT_EQ(hole.code, 4);
  EXPECT_TRUE(has(hole.out, "a.vtp: verified\n") && has(hole.out, "hole.vtp: NOT verified\n") &&
              has(hole.out, "hole.vtp: FAIL legal pruning"))
      << hole.out;
}

TEST_F(Program, SmallestShapes) {
  folder.write("voxel.npy", npy_box(1, 1, 1, 1));
  folder.write("bar.npy", npy_box(1, 1, 7, 1));
  folder.write("full.npy", npy_box(4, 4, 4, 0));
  folder.write("image.npy", npy_box(9, 1, 5, 0));
  for (const char* name : {"voxel", "bar", "full", "image"}) {
    works({"core", fmt::format("{}.npy", name), "--lambda", "0", "-o", fmt::format("{}.vtp", name)});
    works({"verify", fmt::format("{}.npy", name), fmt::format("{}.vtp", name)});
  }
  EXPECT_EQ(read("voxel.vtp").points.size(), 1u);
  EXPECT_EQ(read("voxel.vtp").verts.size(), 1u);
  EXPECT_EQ(read("bar.vtp").points.size(), 7u);
  EXPECT_EQ(read("bar.vtp").lines.size(), 6u);
  EXPECT_EQ(read("bar.vtp").poly_count(), 0u);
  EXPECT_EQ(read("image.vtp").points.size(), 45u);  // the sheet through the centres of the pixels
  EXPECT_EQ(read("image.vtp").poly_count(), 32u);
  works({"core", "voxel.npy", "-o", "voxel.ma"});
  works({"verify", "voxel.npy", "voxel.ma"});  // a lone point is a part of the axis
  works({"core", "voxel.npy", "-o", "voxel.ply"});
  works({"verify", "voxel.npy", "voxel.ply"});
}

TEST_F(Program, OptionsOfVolumes) {
  std::string ramp;  // -10 ... 9 along x, signed
  for (int row = 0; row < 4; ++row)
    for (int x = -10; x < 10; ++x) ramp += static_cast<char>(x);
  folder.write("ramp.npy", npy(20, 2, 2, ramp, "|i1"));
  works({"voxelize", "ramp.npy", "--threshold", "-5", "-o", "a.nrrd", "--json",
         "a.json"});  // a negative number is a value
  EXPECT_TRUE(has(bytes("a.json"), "\"voxels\": 60"));
  works({"voxelize", "ramp.npy", "--label=-3", "-o", "b.nrrd", "--json", "b.json"});
  EXPECT_TRUE(has(bytes("b.json"), "\"voxels\": 4"));
  works({"voxelize", "ramp.npy", "--threshold", "-5", "--invert", "-o", "c.nrrd", "--json", "c.json"});
  EXPECT_TRUE(has(bytes("c.json"), "\"voxels\": 20"));
  works({"core", "ramp.npy", "--threshold", "0", "--spacing", "0.5,0.5,2", "-o", "d.vtp"});
  works({"verify", "ramp.npy", "d.vtp"});  // threshold and spacing are in the file
  EXPECT_TRUE(has(works({"core", "ramp.npy", "--threshold", "0", "--resolution", "9", "-o", "e.vtp"}).err,
                  "--resolution is for meshes"));
}

TEST_F(Program, LambdaFromNothingToAll) {
  folder.write("v.npy", npy_box(6, 7, 9, 1));
  std::size_t last = 0;
  for (const char* lambda : {"inf", "50%", "2vox", "1.5abs", "0.01", "0"}) {
    works({"core", "v.npy", "--lambda", lambda, "-o", "a.vtp", "--overwrite"});
    works({"verify", "v.npy", "a.vtp"});
    const std::size_t points = read("a.vtp").points.size();
    EXPECT_GE(points, last) << lambda;
    last = points;
  }
  works({"core", "v.npy", "--lambda", "2vox", "--full", "-o", "full.vtp"});
  EXPECT_EQ(read("full.vtp").points.size(), last);
  works({"verify", "v.npy", "full.vtp"});
}

TEST_F(Program, DefectiveMeshesBecomeShapesAndSaySo) {
  folder.write("open.off", cube_off(true));
  const auto plain = works({"core", "open.off", "--resolution", "24", "-o", "a.vtp", "--json", "a.json"});
  EXPECT_TRUE(has(plain.err, "warning: the mesh is not closed (3 open edges); the winding number decides "))
      << plain.err;
  EXPECT_FALSE(has(plain.err, "(auto): "));
  const std::string report = bytes("a.json");
  for (const char* part : {"\"open_edges\": 3", "\"defective_scanlines\": ", "\"winding_share\": 0.",
                           "\"sound\": false", "\"fill\": \"nonzero\"", "\"flipped_components\": 0"})
    EXPECT_TRUE(has(report, part)) << part << report;
  works({"verify", "open.off", "a.vtp"});
  const auto chosen =
      works({"core", "open.off", "--resolution", "24", "--fill", "auto", "-o", "b.vtp", "--json", "b.json"});
  EXPECT_TRUE(has(chosen.err, "fill winding (auto): the surface is not closed: 3 edges")) << chosen.err;
  EXPECT_TRUE(has(bytes("b.json"), "\"fill_reason\": \"the surface is not closed")) << bytes("b.json");
  works({"verify", "open.off", "b.vtp"});  // the rule is in the file
  folder.write("cube.off", cube_off());
  for (const char* fill : {"nonzero", "winding", "auto"}) {
    const auto closed =
        works({"voxelize", "cube.off", "--resolution", "24", "--fill", fill, "-o", std::string(fill) + ".nrrd"});
    EXPECT_FALSE(has(closed.err, "warning")) << closed.err;
    EXPECT_EQ(bytes(std::string(fill) + ".nrrd"), bytes("nonzero.nrrd"));
  }
}

TEST_F(Program, VolumesAtTheLimits) {
  const auto verified = [&](const char* name, const std::string& file, std::vector<std::string> more) {
    folder.write(name, file);
    more.insert(more.begin(), {"core", name, "-o", "limit.vtp", "--overwrite"});
    works(more);
    works({"verify", name, "limit.vtp"});
  };
  verified("full.npy", npy(4, 5, 6, std::string(120, '\7')), {});  // all foreground, at every border
  verified("slice.npy", npy(6, 1, 5, std::string(30, '\1')), {});
  const double nan = std::nan(""), infinite = HUGE_VAL;
  const auto doubles = [](std::initializer_list<double> values) {
    std::string text;
    for (const double v : values) text.append(reinterpret_cast<const char*>(&v), sizeof v);
    return text;
  };
  verified("nan.npy", npy(1, 1, 4, doubles({nan, 2, infinite, -infinite}), "<f8"), {"--threshold", "1"});
  refuses(3, {"no values but NaN"},
          {"core", (folder.write("none.npy", npy(1, 1, 2, doubles({nan, nan}), "<f8")), "none.npy"), "--threshold", "1",
           "-o", "a.vtp"});
  const auto integers = [](std::initializer_list<std::int64_t> values) {
    std::string text;
    for (const std::int64_t v : values) text.append(reinterpret_cast<const char*>(&v), sizeof v);
    return text;
  };
  const std::int64_t label = (std::int64_t{1} << 53) + 1;  // no double
  verified("label.npy", npy(1, 1, 3, integers({0, label, label - 1}), "<i8"), {"--label", std::to_string(label)});
  folder.write("constant.npy", npy(3, 3, 3, std::string(27, '\0')));
  refuses(3, {"'constant.npy'", "from 0 to 0"}, {"core", "constant.npy", "-o", "a.vtp"});
  folder.write("huge.npy", npy(100000, 100000, 100000, "0123456789"));
  refuses(3, {"'huge.npy'", "too short"}, {"core", "huge.npy", "-o", "a.vtp"});
  refuses(3, {"proportion of whole numbers"}, {"core", "full.npy", "--spacing", "1e-30,1,1e30", "-o", "a.vtp"});
}

// Enough edges for several chunks of work on three threads (2^16 each, src/base/parallel.h).
TEST_F(Program, SameBytesForAnyThreadsAndAgain) {
  works({"sample", "bumpy-sphere", "--fineness", "0.3", "-o", "s.ply"});
  const auto core = [&](const std::string& threads, const std::string& name) {
    works(
        {"core", "s.ply", "--resolution", "128", "--threads", threads, "--json", name + ".json", "-o", name + ".vtp"});
    return bytes(name + ".vtp");
  };
  const std::string one = core("1", "1");
  for (const std::string threads : {"2", "3"}) EXPECT_TRUE(core(threads, threads) == one) << threads << " threads";
  EXPECT_TRUE(core("3", "again") == one);
  const std::string report = bytes("1.json"), key = "\"edges\": ";
  EXPECT_GE(std::stoll(report.substr(report.find(key, report.find("\"core\": ")) + key.size())), 3 << 16);
}

}  // namespace program_test
