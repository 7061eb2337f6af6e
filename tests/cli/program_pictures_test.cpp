// SPDX-License-Identifier: Apache-2.0
// What the program says of pictures and of TIFF stacks, whose spacing is in no header of the format.
#include "program.h"
#include "quench/io.h"
#include "small_files.h"

using namespace quench;
using namespace quench::testing_program;

namespace {

class Pictures : public ProgramTest {
 protected:
  std::string box(int side) const {
    std::string samples;
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) samples += x > 0 && y > 0 && x + 1 < side && y + 1 < side ? '\1' : '\0';
    return samples;
  }
  bool says(const Outcome& outcome, const std::string& words) const {
    return outcome.err.find(words) != std::string::npos;
  }
};

TEST_F(Pictures, OnePictureIsASlabAndSaidToBeOne) {
  std::string rows;
  for (int y = 0; y < 8; ++y) rows += '\0' + box(8).substr(static_cast<std::size_t>(y) * 8, 8);
  folder.write("p.png", small_files::png(8, 8, 8, 0, false, rows));
  const std::string words = "'p.png' is one picture of 8 x 8 pixels; it is taken as a slab one voxel thick";
  const Outcome core = works({"core", "p.png", "-o", "a.vtp"});
  EXPECT_TRUE(says(core, words)) << core.err;
  EXPECT_TRUE(says(core, "folder of slices")) << core.err;
  const Outcome info = works({"info", "p.png"});
  EXPECT_TRUE(says(info, words)) << info.err;
  EXPECT_FALSE(says(works({"core", "p.png", "-o", "b.vtp", "--quiet"}), "picture"));
  folder.write("rgb.png", small_files::png(1, 1, 8, 2, false, std::string("\0abc", 4)));
  for (const char* command : {"info", "core"}) {
    std::vector<std::string> arguments{command, "rgb.png"};
    if (std::string(command) == "core") arguments.insert(arguments.end(), {"-o", "c.vtp"});
    refuses(3, {"'rgb.png' is an RGB picture of 1 x 1 pixels", "one value per voxel", "convert"}, arguments);
  }
}

// RAS in the file: everything that is written is in LPS, and says so where its format has a place.
TEST_F(Pictures, FilesSayTheirSpace) {
  std::string samples(6 * 6 * 6, '\1');
  folder.write(
      "v.nrrd",
      "NRRD0004\ntype: uint8\ndimension: 3\nspace: right-anterior-superior\nsizes: 6 6 6\n"
      "space directions: (1,0,0) (0,1,0) (0,0,2)\nspace origin: (10,20,30)\nspace units: \"mm\" \"mm\" \"mm\"\n"
      "encoding: raw\n\n" +
          samples);
  works({"voxelize", "v.nrrd", "-o", "w.nrrd"});
  const std::string written = bytes("w.nrrd");
  for (const char* words :
       {"space: left-posterior-superior\n", "space origin: (-10,-20,30)", "space units: \"mm\" \"mm\" \"mm\""})
    EXPECT_NE(written.find(words), std::string::npos) << words;
  works({"run", "v.nrrd", "-o", "out", "--no-view"});
  for (const char* file : {"out/core.vtp", "out/skeleton.vtp"}) {
    const Record data = io::read_record(folder.path() / file);
    const DataArray* space = find_array(data.field_data, "SPACE");
    ASSERT_TRUE(space) << file;
    EXPECT_EQ(std::get<std::vector<std::string>>(space->values), std::vector<std::string>{"LPS"});
  }
  EXPECT_NE(bytes("out/skeleton.swc").find("# SPACE: LPS\n"), std::string::npos);
  EXPECT_NE(bytes("out/report.json").find("\"space\": \"LPS\""), std::string::npos);
  works({"skeleton", "out/core.vtp", "-o", "s.ply", "--graphml", "s.graphml"});
  EXPECT_NE(bytes("s.ply").find("comment SPACE=LPS\n"), std::string::npos);
  EXPECT_NE(bytes("s.graphml").find("<data key=\"space\">LPS</data>"), std::string::npos);
  works({"convert", "out/core.vtp", "c.obj"});
  EXPECT_NE(bytes("c.obj").find("# SPACE=LPS\n"), std::string::npos);
  works({"verify", "v.nrrd", "out/core.vtp", "out/skeleton.vtp"});
  works({"core", "w.nrrd", "-o", "again.vtp"});  // of the same place
  EXPECT_EQ(io::read_record(folder.path() / "again.vtp").points,
            io::read_record(folder.path() / "out/core.vtp").points);
}

#ifdef QUENCH_TESTS_HAVE_TIFF
TEST_F(Pictures, SpacingOfATiffIsSaidAndReported) {
  const std::vector<std::string> pages(4, box(6));
  folder.write("s.tif",
               testing_tiff::tiff(6, 6, pages,
                                  {.tags = testing_tiff::imagej_tags(
                                       "ImageJ=1.53c\nimages=4\nslices=4\nunit=micron\nspacing=2.0\n", 2000000)}));
  const Outcome core = works({"core", "s.tif", "-o", "a.vtp", "--json", "a.json"});
  EXPECT_TRUE(says(core, "note: spacing 0.5 x 0.5 x 2 um from the ImageJ description")) << core.err;
  EXPECT_FALSE(says(core, "picture")) << core.err;
  const std::string report = bytes("a.json");
  for (const char* words : {"\"spacing_source\": \"the ImageJ description\"", "\"units\": \"um\""})
    EXPECT_NE(report.find(words), std::string::npos) << report;
  const auto spacing = report.find("\"spacing\": [");
  ASSERT_NE(spacing, std::string::npos) << report;
  const Outcome given = works({"core", "s.tif", "-o", "b.vtp", "--spacing", "1,1,3", "--json", "b.json"});
  EXPECT_FALSE(says(given, "ImageJ")) << given.err;
  EXPECT_NE(bytes("b.json").find("\"spacing_source\": \"--spacing\""), std::string::npos) << bytes("b.json");
  const Outcome info = works({"info", "s.tif"});
  EXPECT_NE(info.out.find("spacing_source: the ImageJ description"), std::string::npos) << info.out;
  EXPECT_NE(info.out.find("units: um"), std::string::npos) << info.out;
}
#endif

}  // namespace
