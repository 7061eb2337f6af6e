// SPDX-License-Identifier: Apache-2.0
// What the program says of pictures and of TIFF stacks, whose spacing is in no header of the format.
#include "program.h"
#include "quench/io.h"
#include "small_files.h"

using namespace quench;
using namespace quench::testing_program;

namespace program_pictures_test {

class Pictures : public ProgramTest {
 protected:
  std::string box(int side) const {
    std::string samples;
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) samples += x > 0 && y > 0 && x + 1 < side && y + 1 < side ? '\1' : '\0';
    return samples;
  }
  static std::vector<std::string> with(std::vector<std::string> words, const std::vector<std::string>& more) {
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  bool says(const Outcome& outcome, const std::string& words) const {
    return outcome.err.find(words) != std::string::npos;
  }
};

TEST_F(Pictures, AnImageIsAnImage) {
  std::string rows;
  for (int y = 0; y < 8; ++y) rows += '\0' + box(8).substr(static_cast<std::size_t>(y) * 8, 8);
  folder.write("p.png", small_files::png(8, 8, 8, 0, false, rows));
  const Outcome info = works({"info", "p.png"});
  for (const char* words :
       {"kind: image", "picture: a grey picture", "pixels: [8,8]", "0: 28", "1: 36", "y_axis: down"})
    EXPECT_NE(info.out.find(words), std::string::npos) << words << info.out;
  const Outcome shape = works({"voxelize", "p.png", "-o", "a.nrrd", "--spacing", "0.5,0.25"});
  EXPECT_TRUE(says(shape, "shape: 8 x 8 pixels of 0.5 x 0.25, 36 inside; 1 component, 0 holes")) << shape.err;
  EXPECT_TRUE(io::read_volume(folder.path() / "a.nrrd").grid.is_plane());
  refuses(2, {"--spacing", "three numbers"}, {"voxelize", "p.png", "-o", "b.nrrd", "--spacing", "1,2,3"});
  refuses(2, {"--spacing '1,2,x'", "two as x,y"}, {"voxelize", "p.png", "-o", "b.nrrd", "--spacing", "1,2,x"});
}

// Of many values: the darkest and the brightest one, and what parts them.
TEST_F(Pictures, AThresholdIsProposed) {
  const auto write = [&](const std::string& name, int dark, int bright) {
    std::string rows;
    for (int y = 0; y < 8; ++y) {
      rows += '\0';
      for (int x = 0; x < 8; ++x) {
        const bool inside = x > 1 && x < 6 && y > 1 && y < 6;
        rows += static_cast<char>((inside ? bright : dark) + (x + y) % 3);
      }
    }
    folder.write(name, small_files::png(8, 8, 8, 0, false, rows));
  };
  write("bright.png", 10, 100);
  write("dark.png", 100, 10);
  refuses(2, {"from 10 to 102", "e.g. 56,", "[--threshold, --label]"}, {"voxelize", "bright.png", "-o", "a.nrrd"});
  refuses(2, {"from 10 to 102", "e.g. 56,", "border is bright", "--invert"}, {"voxelize", "dark.png", "-o", "a.nrrd"});
  EXPECT_NE(works({"info", "dark.png"}).out.find("--threshold 56: what is bright, with --invert what is dark, as the"),
            std::string::npos);
  works({"voxelize", "dark.png", "-o", "a.nrrd", "--threshold", "56", "--invert"});
  EXPECT_EQ(foreground(io::read_volume(folder.path() / "a.nrrd"), {}).voxel_count(), 16);
}

// What one slice is and which channel was taken is kept in results: verify reads the same.
TEST_F(Pictures, DimensionAndChannelAreRecorded) {
  folder.write("v.npy", small_files::npy("|u1", false, "1, 8, 8", box(8)));
  refuses(2, {"volume of one slice", "2 takes it as an image", "[--dimension]"}, {"core", "v.npy", "-o", "a.vtp"});
  EXPECT_TRUE(says(works({"info", "v.npy"}), "volume of one slice"));
  works({"core", "v.npy", "-o", "a.vtp", "--dimension", "3"});
  works({"verify", "v.npy", "a.vtp"});
  std::string rows;
  for (int y = 0; y < 8; ++y) {
    rows += '\0';
    for (int x = 0; x < 8; ++x)
      rows += std::string{static_cast<char>(9 * x), '\7', static_cast<char>(x > 0 && x < 7 && y > 0 && y < 7), '\xff'};
  }
  folder.write("c.png", small_files::png(8, 8, 8, 6, false, rows));
  works({"core", "c.png", "-o", "c.vtp", "--dimension", "3", "--channel", "blue"});
  const Record core = io::read_record(folder.path() / "c.vtp");
  const DataArray* parameters = find_array(core.field_data, "parameters");
  ASSERT_TRUE(parameters);
  EXPECT_EQ(
      std::get<std::vector<std::string>>(parameters->values).front().rfind(R"({"channel":"blue","dimension":3)", 0),
      0u);
  works({"verify", "c.png", "c.vtp"});
  refuses(2, {"--channel 'alpha'"}, {"core", "v.npy", "-o", "b.vtp", "--dimension", "3", "--channel", "alpha"});
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

TEST_F(Pictures, SentencesOfThePlaneAreOfPixels) {
  folder.write("empty.pgm", "P5 4 3 255\n" + std::string(12, '\0'));
  folder.write("dot.pgm", "P5 4 3 255\n" + std::string(12, '\1'));
  folder.write("row.pgm", "P5 20000 1 255\n" + std::string(20000, '\1'));
  const std::vector<std::string> core{"core", "-o", "o.vtp", "--overwrite"};
  refuses(3, {"no pixel of the image has a value other than 0"}, with(core, {"empty.pgm"}));
  refuses(3, {"dropping components of fewer than 13 pixels", "has 12 pixels"},
          with(core, {"dot.pgm", "--min-component", "13"}));
  refuses(3, {"the spacing 1000 x 1 with 20000 x 1 pixels", "a twentieth of a pixel", "such as 1 x 2"},
          with(core, {"row.pgm", "--spacing", "1000,1"}));
  refuses(3, {"pixels of 1e-300 x 1e-300 are beyond", "scale the polygons, or give the image another spacing"},
          with(core, {"dot.pgm", "--spacing", "1e-300"}));
  const Outcome ignored = works(with(core, {"dot.pgm", "--resolution", "9"}));
  EXPECT_TRUE(says(ignored, "note: --resolution is for meshes and is ignored for an image")) << ignored.err;
}

// Two polygons, of which one result is verified and a picture is written, y up as in the file.
TEST_F(Pictures, PolygonsKeepTheirYAndAreVerifiedAsTheyWereMade) {
  const auto box = [](int x) {
    return R"({"type":"Feature","properties":{},"geometry":{"type":"Polygon","coordinates":[[[)" + std::to_string(x) +
           ",0],[" + std::to_string(x + 8) + ",0],[" + std::to_string(x + 8) + ",3],[" + std::to_string(x) + ",3],[" +
           std::to_string(x) + ",0]]]}}";
  };
  folder.write("a.geojson", R"({"type":"FeatureCollection","features":[)" + box(0) + "," + box(20) + "]}");
  for (const std::vector<std::string>& side : {std::vector<std::string>{"--pixel", "0.5"}, {"--resolution", "16"}}) {
    const std::vector<std::string> shape = with({"a.geojson", "--feature", "1", "--overwrite"}, side);
    works(with({"core", "-o", "c.vtp"}, shape));
    const Outcome verified = works({"verify", "a.geojson", "c.vtp"});
    EXPECT_FALSE(says(verified, "ignored")) << verified.err;
    works(with({"voxelize", "-o", "p.nrrd"}, shape));
    const Outcome info = works({"info", "p.nrrd"});
    EXPECT_NE(info.out.find("y_axis: up"), std::string::npos) << info.out;
  }
  const std::vector<std::string> run{"run", "a.geojson", "-o", "out", "--pixel", "0.5", "--no-view", "--no-picture"};
  const std::string sentence = "note: --root and --swc-type are for SWC";
  EXPECT_FALSE(says(works(run), sentence));
  EXPECT_TRUE(says(works(with(run, {"--overwrite", "--root", "1,2,0"})), sentence));
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

}  // namespace program_pictures_test
