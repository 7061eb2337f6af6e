// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "program.h"
#include "quench/io.h"

// What the program refuses.

using namespace quench::testing_program;

namespace program_refusals_test {

class Refusals : public ProgramTest {
 protected:
  void SetUp() override {
    folder.write("cube.off", cube_off());
    folder.write("grey.npy", npy(1, 1, 3, "\1\2\3"));
    folder.write("box.npy", npy_box(3, 4, 5, 1));
  }
};

TEST_F(Refusals, CommandLines) {
  refuses(2,
          {"run, tree, batch, sample, voxelize, core, bricks, burn, skeleton, reconstruct, parts, thickness, simplify, "
           "smooth, view, info, convert, verify"},
          {});
  refuses(2, {"'cores'", "did you mean 'core'?"}, {"cores"});
  refuses(2, {"'runn'", "did you mean 'run'?"}, {"runn", "cube.off", "-o", "a"});
  refuses(2, {"'skel'", "did you mean 'skeleton'?"}, {"skel", "a.vtp"});
  refuses(2, {"'thicken'", "run, tree, batch, sample"}, {"thicken", "--fast"});
  refuses(2, {"--resoluton", "did you mean --resolution?"}, {"core", "cube.off", "--resoluton", "9", "-o", "a.vtp"});
  refuses(2, {"--topology 'mehs' is not one of mesh, voxels; did you mean 'mesh'? see quench core --help"},
          {"core", "cube.off", "--topology", "mehs", "-o", "a.vtp"});
  refuses(2, {"--label is given more than once"}, {"core", "grey.npy", "--label", "1", "--label", "2", "-o", "a.vtp"});
  refuses(2, {"'-o=a.vtp'", "without '='"}, {"core", "cube.off", "-o=a.vtp"});
  refuses(2, {"--fast"}, {"--fast"});
  refuses(2, {"--fast", "quench core --help"}, {"core", "cube.off", "--fast", "3", "-o", "a.vtp"});
  refuses(2, {"'more'"}, {"core", "cube.off", "more", "-o", "a.vtp"});
  refuses(2, {"SHAPE"}, {"core", "-o", "a.vtp"});
  refuses(2, {"--output"}, {"core", "cube.off"});
  refuses(2, {"--lambda needs a value"}, {"core", "cube.off", "-o", "a.vtp", "--lambda"});
}

TEST_F(Refusals, OptionsThatCannotBe) {
  const auto core = [&](const std::string& option, const std::string& value) {
    refuses(2, {option}, {"core", "cube.off", "-o", "a.vtp", option, value});
  };
  for (const char* lambda : {"nonsense", "-1", "nan", "2 vox", "3%%", ""}) core("--lambda", lambda);
  for (const char* resolution : {"0", "-5", "1.5", "abc", "99999", "1e3", ""}) core("--resolution", resolution);
  for (const char* spacing : {"nonsense", "1,2,", "1,2,3,", "0", "-1", "1,2,inf", "1,2,3,4"})
    core("--spacing", spacing);
  for (const char* threads : {"-1", "two", "1.5"}) core("--threads", threads);
  for (const char* limit : {"nonsense", "-1G", "5X", "0", "G"}) core("--memory-limit", limit);
  for (const char* factor : {"0", "65", "x"}) core("--subdivide", factor);
  core("--fill", "odd");
  core("--lambda-rule", "round");
  core("--min-component", "-3");
  core("--threshold", "high");
  core("--label", "1.5");
  refuses(2, {"--threshold", "--label"}, {"core", "grey.npy", "--threshold", "1", "--label", "1", "-o", "a.vtp"});
  refuses(2, {"--threshold"}, {"core", "grey.npy", "--threshold", "nan", "-o", "a.vtp"});
  refuses(2, {"'cub'", "torus"}, {"sample", "cub", "-o", "a.ply"});
  refuses(2, {"--branches"}, {"sample", "root", "--branches", "0", "-o", "a.ply"});
  refuses(2, {"--noise"}, {"sample", "bumpy-sphere", "--noise", "1", "-o", "a.ply"});
  refuses(2, {"--fineness"}, {"sample", "torus", "--fineness", "0", "-o", "a.ply"});
  refuses(2, {"--gaps", "--grey"}, {"sample", "root", "--gaps", "2", "-o", "a.nrrd"});
  refuses(2, {"--grey", ".nrrd"}, {"sample", "root", "--grey", "-o", "a.ply"});
  refuses(2, {"--grey", "root"}, {"sample", "torus", "--grey", "-o", "a.nrrd"});
  refuses(2, {"--touching"}, {"sample", "root", "--branches", "2", "--touching", "2", "-o", "a.ply"});
  refuses(2, {"--resolution"}, {"sample", "torus", "--resolution", "0", "-o", "a.nrrd"});
}

TEST_F(Refusals, MissingFiles) {
  for (const char* command : {"core", "run", "voxelize"})
    refuses(1, {"'no such.ply'"},
            {command, "no such.ply", "-o", std::string(command) == "voxelize" ? "a.nrrd" : "a.vtp"});
  refuses(1, {"'no such.ply'"}, {"info", "no such.ply"});
  refuses(1, {"'no such.ply'"}, {"convert", "no such.ply", "a.vtp"});
  refuses(1, {"'no such.ply'"}, {"verify", "no such.ply", "cube.off"});
  refuses(1, {"'no such.ply'"}, {"verify", "cube.off", "no such.ply"});
  refuses(1, {"'no such.r'"}, {"convert", "cube.off", "a.ma", "--radii", "no such.r"});
}

TEST_F(Refusals, VerifyingAgainstTheOtherThreshold) {
  works({"core", "cube.off", "--resolution", "8", "-o", "detail.vtp"});
  works({"core", "cube.off", "--resolution", "8", "-o", "lambda.vtp", "--lambda", "1vox"});
  refuses(2, {"--lambda", "--detail"}, {"verify", "cube.off", "detail.vtp", "--lambda", "1vox", "--detail", "1vox"});
  refuses(2, {"--lambda", "pruned by detail"}, {"verify", "cube.off", "detail.vtp", "--lambda", "1vox"});
  refuses(2, {"--detail", "pruned by lambda"}, {"verify", "cube.off", "lambda.vtp", "--detail", "1vox"});
  works({"verify", "cube.off", "lambda.vtp", "--lambda", "1vox"});
  works({"verify", "cube.off", "detail.vtp"});
}

TEST_F(Refusals, FilesThatAreNotWhatTheyClaim) {
  folder.write("a.docx", "text");
  folder.write("empty.ply", "");
  folder.write("empty.nrrd", "");
  folder.write("empty.npy", "");
  folder.write("text.nrrd", "this is no volume\n");
  folder.write("text.npy", "this is no volume\n");
  folder.write("text.stl", "this is no mesh\n");
  std::filesystem::create_directory(folder / "no slices");
  refuses(3, {"'a.docx'"}, {"core", "a.docx", "-o", "a.vtp"});
  refuses(3, {"'a.docx'"}, {"info", "a.docx"});
  for (const char* name : {"empty.ply", "empty.nrrd", "empty.npy", "text.nrrd", "text.npy", "text.stl"}) {
    refuses(3, {name}, {"core", name, "-o", "a.vtp"});
    refuses(3, {name}, {"info", name});
  }
  refuses(3, {"'no slices'", "slices"}, {"core", "no slices", "-o", "a.vtp"});
  refuses(2, {"'grey.npy'", "volume"}, {"convert", "grey.npy", "a.vtp"});
}

// A medial axis has faces, too, and no shape is made of them.
TEST_F(Refusals, ResultsWhereAShapeIsExpected) {
  works({"core", "cube.off", "--resolution", "8", "-o", "core.vtp"});
  works({"burn", "core.vtp", "-o", "burned.vtp"});
  works({"skeleton", "burned.vtp", "-o", "skeleton.vtp"});
  works({"convert", "core.vtp", "core.ply"});
  const auto refused = [&](const std::string& file, const std::string& name, const std::string& taken_by) {
    const std::vector<std::string> words{
        fmt::format("'{}' is a {}, not a shape; give the mesh, volume or image it was made of, or give it to {}", file,
                    name, taken_by)};
    refuses(3, words, {"run", file, "-o", "a"});
    refuses(3, words, {"core", file, "-o", "a.vtp"});
    refuses(3, words, {"voxelize", file, "-o", "a.nrrd"});
    refuses(3, words, {"thickness", file, "-o", "a.nrrd"});
    refuses(3, words, {"bricks", "plan", file, "-o", "work"});
    refuses(3, words, {"verify", file, "core.vtp", "--surface", "voxels"});
    refuses(3, words, {"burn", "core.vtp", "--shape", file, "-o", "a.vtp"});
    refuses(3, words, {"view", "burned.vtp", "--shape", file, "-o", "a.html"});
  };
  refused("core.vtp", "medial axis", "'quench burn' or 'quench skeleton'");
  refused("core.ply", "medial axis", "'quench burn' or 'quench skeleton'");
  refused("burned.vtp", "burned medial axis", "'quench skeleton' or 'quench view'");
  refused("skeleton.vtp", "skeleton", "'quench view' or 'quench tree'");
}

TEST_F(Refusals, ShapesWhereAMedialAxisIsExpected) {
  folder.write("open.off", cube_off(true));
  for (const char* command : {"burn", "skeleton", "simplify", "smooth", "reconstruct"}) {
    const std::string output = command == std::string("reconstruct") ? "a.ply" : "a.vtp";
    refuses(3, {"'cube.off' is a mesh, not a medial axis; 'quench core cube.off' computes one of it"},
            {command, "cube.off", "-o", output});
    refuses(3, {"'box.npy' is a volume, not a medial axis; 'quench core box.npy' computes one of it"},
            {command, "box.npy", "-o", output});
    refuses(3, {"'open.off' has no radius per vertex", "'quench core open.off'", "[--radii]"},
            {command, "open.off", "-o", output});
  }
}

// Whoever measures a mesh may call an array so.
TEST_F(Refusals, ClosedMeshesWithRadiiAreShapes) {
  quench::Record mesh = quench::io::read_record(folder / "cube.off");
  mesh.point_data.push_back({"radius", 1, std::vector<double>(mesh.points.size(), 1.0)});
  quench::io::write_record(folder / "cube.vtp", mesh);
  works({"core", "cube.vtp", "--resolution", "8", "-o", "a.vtp"});
}

TEST_F(Refusals, TruncatedFiles) {
  works({"sample", "torus", "-o", "torus.ply", "--fineness", "0.1"});
  works({"sample", "torus", "-o", "torus.nrrd", "--resolution", "16"});
  const std::string vol = "Version: 2\nX: 4\nY: 4\nZ: 4\nVoxel-Size: 1\n.\n";
  for (const char* name : {"torus.ply", "torus.nrrd", "box.npy"}) {
    const std::string whole = bytes(name);
    folder.write(name, whole.substr(0, whole.size() / 2));
  }
  folder.write("short.vol", vol + std::string(20, '\1'));
  for (const char* name : {"torus.ply", "torus.nrrd", "box.npy", "short.vol"})
    refuses(3, {name}, {"core", name, "-o", "a.vtp"});
}

TEST_F(Refusals, MeshesThatEncloseNothing) {
  folder.write("sheet.off", "OFF\n4 2 0\n0 0 0\n4 0 0\n4 4 1.7\n0 4 1.7\n3 0 1 2\n3 0 2 3\n");
  folder.write("nan.off", cube_off(false, "nan"));
  folder.write("points.off", "OFF\n1 0 0\n0 0 0\n");
  refuses(3, {"'sheet.off'", "not closed", "encloses nothing"}, {"core", "sheet.off", "-o", "a.vtp"});
  refuses(3, {"nan.off"}, {"core", "nan.off", "-o", "a.vtp"});
  refuses(3, {"'points.off'", "closed surface"}, {"run", "points.off", "-o", "a"});
}

TEST_F(Refusals, VolumesWithoutAShape) {
  folder.write("zero.npy", npy(2, 2, 2, std::string(8, '\0')));
  refuses(2, {"'grey.npy'", "--threshold", "--label"}, {"core", "grey.npy", "-o", "a.vtp"});
  refuses(3, {"'grey.npy'", "4", "from 1 to 3"}, {"core", "grey.npy", "--threshold", "4", "-o", "a.vtp"});
  refuses(3, {"'grey.npy'", "9", "from 1 to 3"}, {"core", "grey.npy", "--label", "9", "-o", "a.vtp"});
  refuses(3, {"'zero.npy'"}, {"core", "zero.npy", "-o", "a.vtp"});
  folder.write("float.npy", npy(1, 1, 2, std::string("\0\0\0\0\0\0\xc0\x3f", 8), "<f4"));  // 0 and 1.5
  refuses(3, {"'float.npy'", "value 1", "1.5"}, {"core", "float.npy", "--label", "1", "-o", "a.vtp"});
}

TEST_F(Refusals, LengthsBeyondDoublePrecision) {
  const auto tetrahedron = [](const std::string& x0, const std::string& x1, const std::string& side) {
    return "OFF\n4 4 0\n" + x0 + " 0 0\n" + x1 + " 0 0\n" + x0 + " " + side + " 0\n" + x0 + " 0 " + side +
           "\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
  };
  folder.write("small.off", tetrahedron("0", "1e-32", "1e-32"));
  folder.write("far.off", tetrahedron("1e15", "1000000000001024", "1024"));
  refuses(3, {"1e-30 to 1e+30", "another spacing"},
          {"core", "box.npy", "--spacing", "1e200,1e200,1e200", "-o", "a.vtp"});
  refuses(3, {"1e-30 to 1e+30", "scale the mesh"}, {"core", "small.off", "--resolution", "4", "-o", "a.vtp"});
  refuses(3, {"1e+15", "move it nearer"}, {"core", "far.off", "--resolution", "8", "-o", "a.vtp"});
}

TEST_F(Refusals, Outputs) {
  works({"core", "box.npy", "-o", "old.vtp"});
  folder.write("old.vtp", "precious");
  folder.write("file", "");
  std::filesystem::create_directory(folder / "dir");
  refuses(2, {"'old.vtp'", "--overwrite"}, {"core", "box.npy", "-o", "old.vtp"});
  refuses(2, {"'old.vtp'", "--overwrite"}, {"core", "box.npy", "-o", "a.vtp", "--json", "old.vtp"});
  refuses(2, {"same file"}, {"core", "box.npy", "-o", "a.vtp", "--json", "./a.vtp"});
  refuses(2, {"input itself; give B another name"}, {"convert", "cube.off", "./cube.off", "--overwrite"});
  refuses(2, {"input itself; give -o another name"}, {"voxelize", "box.npy", "-o", "box.npy", "--overwrite"});
  refuses(2, {"input itself; give --json another name"},
          {"voxelize", "box.npy", "-o", "a.nrrd", "--json", "box.npy", "--overwrite"});
  for (const char* option : {"--swc", "--graphml", "--csv", "--json"})
    refuses(2, {std::string("'old.vtp' is the input itself; give ") + option + " another name"},
            {"skeleton", "old.vtp", "-o", "a.vtp", option, "old.vtp", "--overwrite"});
  refuses(2, {"'dir'", "folder"}, {"core", "box.npy", "-o", "dir", "--overwrite"});
  refuses(1, {"'no'", "does not exist"}, {"core", "box.npy", "-o", "no/a.vtp"});
  refuses(2, {"'a.xyz'", ".vtp"}, {"core", "not even read.npy", "-o", "a.xyz"});
  refuses(2, {"'a.npy'", ".nrrd"}, {"voxelize", "box.npy", "-o", "a.npy"});
  refuses(2, {"'a.off'"}, {"sample", "box", "-o", "a.off"});
  refuses(2, {"file", "not a folder"}, {"run", "box.npy", "-o", "file"});
  refuses(2, {"empty"}, {"core", "box.npy", "-o", ""});
  works({"run", "cube.off", "--resolution", "8", "-o", "mine"});
  refuses(2, {"input itself"}, {"run", "mine/core.vtp", "-o", "mine"});
  works({"core", "box.npy", "-o", "old.vtp", "--overwrite"});
  EXPECT_TRUE(bytes("old.vtp").starts_with("<?xml"));
}

// A link whose file is not there yet is an output that exists; replacing it makes the file it names.
TEST_F(Refusals, DanglingLinks) {
  std::filesystem::create_symlink("later.vtp", folder / "link.vtp");
  refuses(2, {"'link.vtp' exists", "--overwrite"}, {"core", "box.npy", "-o", "link.vtp"});
  refuses(2, {"'link.json' exists", "--overwrite"}, [&] {
    std::filesystem::create_symlink("later.json", folder / "link.json");
    return std::vector<std::string>{"core", "box.npy", "-o", "a.vtp", "--json", "link.json"};
  }());
  works({"core", "box.npy", "-o", "link.vtp", "--overwrite"});
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link.vtp"));
  EXPECT_TRUE(bytes("later.vtp").starts_with("<?xml"));
  std::filesystem::create_symlink("nowhere/later.vtp", folder / "lost.vtp");
  refuses(1, {"'lost.vtp'", "nowhere", "does not exist"}, {"core", "box.npy", "-o", "lost.vtp", "--overwrite"});
}

// Before the input is even read.
TEST_F(Refusals, LinksThatLeadNowhere) {
  folder.write("bad.npy", "not even read");
  std::filesystem::create_symlink("gone", folder / "link");
  refuses(2, {"'link' is a link to 'gone', which does not exist; create that folder or give -o another name"},
          {"run", "bad.npy", "-o", "link"});
  for (const char* below : {"link/", "link/sub", "link/sub/sub"})
    refuses(2, {"link' is a link to 'gone', which does not exist"}, {"run", "bad.npy", "-o", below});
  std::filesystem::create_symlink("loop.vtp", folder / "loop.vtp");
  for (const char* option : {"-o", "--json"}) {
    const bool report = std::string(option) == "--json";
    const std::string text = std::string("'loop.vtp' is a link that leads to itself; give ") + option + " another name";
    std::vector<std::string> line{"core", "bad.npy", option, "loop.vtp"};
    if (report) line.insert(line.end(), {"-o", "a.vtp"});
    refuses(2, {text}, line);
    line.emplace_back("--overwrite");
    refuses(2, {text}, line);
  }
  refuses(2, {"'loop.vtp' is a link that leads to itself"}, {"run", "bad.npy", "-o", "loop.vtp"});
}

// Root may write by the permissions, and cannot.
TEST_F(Refusals, FoldersThatTakeNoFiles) {
  if (!std::filesystem::exists("/proc/self")) GTEST_SKIP() << "there is no /proc";
  folder.write("bad.npy", "not even read");
  refuses(1, {"cannot write '/proc/a.vtp': the folder '/proc' is not writable"},
          {"core", "bad.npy", "-o", "/proc/a.vtp"});
  refuses(1, {"cannot write to '/proc/out': the folder '/proc' is not writable"},
          {"run", "bad.npy", "-o", "/proc/out"});
}

TEST_F(Refusals, TooLittleMemory) {
  works({"sample", "box", "-o", "box.ply"});
  refuses(1, {" MB of memory", "1.0 MB", "--memory-limit"}, {"core", "box.ply", "--memory-limit", "1M", "-o", "a.vtp"});
  refuses(1, {"GB", "4.0 GB", "a lower resolution, or a larger --memory-limit"},
          {"core", "box.ply", "--resolution", "4096", "--memory-limit", "4G", "-o", "a.vtp"});
  refuses(1, {"GB", "--memory-limit"}, {"core", "box.ply", "--subdivide", "64", "--memory-limit", "4G", "-o", "a.vtp"});
  refuses(1, {"--memory-limit"}, {"run", "box.ply", "--memory-limit", "1M", "-o", "folder"});
}

TEST_F(Refusals, BricksWithoutRoomForThem) {
  works({"sample", "box", "-o", "box.ply"});
  refuses(1, {"in bricks", "at once", "a lower resolution", "--memory-limit"},
          {"core", "box.ply", "--resolution", "512", "--in-bricks", "--memory-limit", "100M", "-o", "a.vtp"});
}

TEST_F(Refusals, DiskFull) {
  works({"sample", "torus", "-o", "torus.ply", "--fineness", "0.2"});
  folder.write("old.vtp", "precious");
  const auto before = files();
  const Outcome outcome =
      wait(start({"core", "torus.ply", "--resolution", "40", "-o", "old.vtp", "--overwrite"}, 4096));
  EXPECT_EQ(outcome.code, 1);
  EXPECT_NE(outcome.err.find("quench: cannot write 'old.vtp': File too large"), std::string::npos) << outcome.err;
  EXPECT_EQ(files(), before);
  if (!std::filesystem::exists("/dev/full")) return;
  std::filesystem::create_symlink("/dev/full", folder / "full.vtp");
  const Outcome full = quench({"core", "torus.ply", "--resolution", "20", "-o", "full.vtp", "--overwrite"});
  EXPECT_EQ(full.code, 1);
  EXPECT_NE(full.err.find("quench: cannot write 'full.vtp': No space left"), std::string::npos) << full.err;
}

}  // namespace program_refusals_test
