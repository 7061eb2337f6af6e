// SPDX-License-Identifier: Apache-2.0
// What the descriptions of ImageJ, OME and tifffile and the tags of a TIFF file say of its volume, and what is said of
// them.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "quench/error.h"
#include "quench/io.h"
#include "quench/shape.h"
#include "small_files.h"
#include "tiff_fixture.h"
#ifdef QUENCH_TESTS_HAVE_TIFF

namespace quench {
namespace tiff_description_test {

using namespace testing_tiff;

// A stack with a resolution tag crashed (ImageJ, tifffile and most microscopes write one).
TEST_F(Tiff, ResolutionWithoutADistanceOfSlices) {
  const TiffBytes b;
  const auto with = [&](std::uint32_t x, std::uint32_t y, std::uint32_t denominator, std::uint32_t unit) {
    const std::string page(20, 'a');
    return tiff(5, 4, {page, page},
                {.tags = {b.rational(282, x, denominator), b.rational(283, y, denominator), b.shorts(296, {unit})}});
  };
  for (const std::uint32_t unit : {1u, 2u, 3u}) {
    const Volume v = read(with(300, 300, 1, unit));
    EXPECT_EQ(v.grid.spacing, Vec3(1, 1, 1));
    EXPECT_EQ(v.coordinates.units, "");
    EXPECT_EQ(v.spacing_source, "");
    EXPECT_EQ(notes.find("no distance of slices") != std::string::npos, unit != 1) << notes;
  }
  Context context;
  context.note = [](const std::string& sentence) { ADD_FAILURE() << "the spacing is given: " << sentence; };
  EXPECT_EQ(io::read_volume(folder / "t.tif", {.spacing = Vec3(1, 2, 3)}, &context).grid.spacing, Vec3(1, 2, 3));
  ASSERT_TRUE(io::open_slices(folder / "t.tif", {.spacing = Vec3(1, 2, 3)}, &context));
  // Pixels that are not squares are meant so: their sizes are ready to be given.
  read(with(254, 127, 1, 2));
  EXPECT_NE(notes.find("gives a size of pixels, 0.1 x 0.2 mm, but no distance of slices; the spacing is taken as 1 x 1 "
                       "x 1; give the spacing 0.1,0.2,Z,"),
            std::string::npos)
      << notes;
  read(with(3000, 3001, 1, 3));
  EXPECT_EQ(notes.find(",Z"), std::string::npos) << notes;
  for (const auto& [numerator, denominator] : {std::pair<std::uint32_t, std::uint32_t>{0, 1}, {1, 0}, {0, 0}}) {
    EXPECT_EQ(read(with(numerator, numerator, denominator, 2)).grid.spacing, Vec3(1, 1, 1));
    EXPECT_NE(notes.find("not positive"), std::string::npos) << notes;
  }
}

TEST_F(Tiff, SpacingOfImageJ) {
  const std::string page(20, 'a');
  const auto read_with = [&](const std::string& description, std::uint32_t per_unit, int pages = 2) {
    return read(tiff(5, 4, std::vector<std::string>(static_cast<std::size_t>(pages), page),
                     {.tags = imagej_tags("ImageJ=1.53c\n" + description, per_unit)}));
  };
  for (const char* unit : {"micron", "um", "\\u00B5m", "\xC2\xB5m", "\xB5m", "microns"}) {
    const Volume v = read_with(fmt::format("images=2\nslices=2\nunit={}\nspacing=2.0\nloop=false\n", unit), 2000000);
    EXPECT_EQ(v.grid.spacing, Vec3(0.5, 0.5, 2)) << unit;
    EXPECT_EQ(v.coordinates.units, "um") << unit;
    EXPECT_EQ(v.spacing_source, "the ImageJ description");
    EXPECT_EQ(notes, "");
  }
  EXPECT_EQ(read_with("images=2\nunit=mm\nspacing=-0.2", 15384615).grid.spacing, Vec3(0.065, 0.065, 0.2));
  EXPECT_EQ(read_with("images=2\nunit=inch\nspacing=0.1", 10000000).grid.spacing, Vec3(2.54, 2.54, 2.54));
  EXPECT_EQ(read_with("images=2\nunit=inch\nspacing=0.1", 10000000).coordinates.units, "mm");
  EXPECT_EQ(read_with("images=2\nunit=cm\nspacing=1e-1", 10000000).coordinates.units, "cm");
  EXPECT_TRUE(read_with("images=2\nunit=um\nzunit=nm\nspacing=300", 10000000).grid.spacing.isApprox(Vec3(.1, .1, .3)));
  // Sizes without a unit of length are proportions.
  EXPECT_EQ(read_with("images=2\nunit=pixel\nspacing=3", 1000000).grid.spacing, Vec3(1, 1, 3));
  EXPECT_EQ(read_with("images=2\nunit=pixel\nspacing=3", 1000000).coordinates.units, "");
  // ImageJ leaves out a distance of 1.
  const Volume one = read_with("images=2\nunit=micron", 5000000);
  EXPECT_EQ(one.grid.spacing, Vec3(0.2, 0.2, 1));
  EXPECT_NE(one.spacing_source.find("ImageJ takes 1 um"), std::string::npos) << one.spacing_source;
  EXPECT_EQ(read_with("images=2\nunit=inch", 300000000).grid.spacing, Vec3(1, 1, 1));
  EXPECT_NE(notes.find("no distance of slices"), std::string::npos) << notes;
  // One page is an image of the plane: its size of pixels is enough.
  const Volume image = read_with("unit=micron", 5000000, 1);
  EXPECT_EQ(image.grid.spacing, Vec3(0.2, 0.2, 0.2));
  EXPECT_EQ(image.coordinates.units, "um");
  EXPECT_EQ(read_with("unit=inch", 300000000, 1).grid.spacing, Vec3(1, 1, 1));
  EXPECT_EQ(read_with("unit=micron", 0, 1).grid.spacing, Vec3(1, 1, 1));
  EXPECT_NE(notes.find("not positive and finite"), std::string::npos) << notes;
  for (const char* spacing : {"nan", "inf"}) {
    EXPECT_EQ(read_with(fmt::format("images=2\nunit=um\nspacing={}", spacing), 2000000).grid.spacing, Vec3(1, 1, 1));
    EXPECT_NE(notes.find("not positive and finite"), std::string::npos) << notes;
  }
  for (const char* spacing : {"0", "x", "1e-400"})  // not given
    EXPECT_EQ(read_with(fmt::format("images=2\nunit=um\nspacing={}", spacing), 2000000).grid.spacing,
              Vec3(0.5, 0.5, 1));
  EXPECT_EQ(read_with("images=2\nunit=um\nspacing=2", 0).grid.spacing, Vec3(1, 1, 1));
  EXPECT_NE(notes.find("not positive and finite"), std::string::npos) << notes;
}

std::string ome(const std::string& attributes) {
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?><OME xmlns=\"http://www.openmicroscopy.org/Schemas/OME/2016-06\">"
         "<Image ID=\"Image:0\"><Pixels DimensionOrder=\"XYZCT\" " +
         attributes + "><Channel/></Pixels></Image></OME>";
}

TEST_F(Tiff, SpacingOfOme) {
  const std::string page(20, 'a');
  const auto read_with = [&](const std::string& attributes) {
    return read(tiff(5, 4, {page, page}, {.tags = {TiffBytes::text(270, ome(attributes))}}));
  };
  const std::string sizes = "SizeX=\"5\" SizeY=\"4\" SizeZ=\"2\" SizeC=\"1\" SizeT=\"1\" ";
  const Volume v = read_with(sizes + "PhysicalSizeX=\"0.25\" PhysicalSizeY=\"0.5\" PhysicalSizeZ=\"2\"");
  EXPECT_EQ(v.grid.spacing, Vec3(0.25, 0.5, 2));
  EXPECT_EQ(v.coordinates.units, "um");
  EXPECT_EQ(v.spacing_source, "the OME-XML description");
  EXPECT_EQ(notes, "");
  const Volume other = read_with(sizes +
                                 "PhysicalSizeX=\"250\" PhysicalSizeXUnit=\"nm\" PhysicalSizeY=\"250\" "
                                 "PhysicalSizeYUnit=\"nm\" PhysicalSizeZ=\"2\" PhysicalSizeZUnit=\"\xC2\xB5m\"");
  EXPECT_TRUE(other.grid.spacing.isApprox(Vec3(250, 250, 2000)));
  EXPECT_EQ(other.coordinates.units, "nm");
  EXPECT_EQ(read_with(sizes + "PhysicalSizeX=\"0.25\" PhysicalSizeY=\"0.25\"").grid.spacing, Vec3(1, 1, 1));
  EXPECT_NE(notes.find("0.25 x 0.25 um, but no distance of slices"), std::string::npos) << notes;
  for (const char* bad : {"0", "-1", "nan", "inf", "", "x"}) {
    EXPECT_EQ(read_with(sizes + "PhysicalSizeX=\"1\" PhysicalSizeY=\"1\" PhysicalSizeZ=\"" + bad + "\"").grid.spacing,
              Vec3(1, 1, 1))
        << bad;
    EXPECT_NE(notes.find("not positive and finite"), std::string::npos) << notes;
  }
  EXPECT_EQ(read_with(sizes + "PhysicalSizeX=\"1\" PhysicalSizeY=\"1\" PhysicalSizeZ=\"2\" "
                              "PhysicalSizeZUnit=\"reference frame\"")
                .coordinates.units,
            "");
  EXPECT_EQ(read_with(sizes + "PhysicalSizeZ=\"2\"").grid.spacing, Vec3(1, 1, 1));
  EXPECT_NE(notes.find("gives a distance of slices (2 um) but no size of pixels; the spacing is taken as 1 x 1 x 1"),
            std::string::npos)
      << notes;
  EXPECT_EQ(read_with(sizes + "PhysicalSizeZ=\"2\" PhysicalSizeY=\"500\" PhysicalSizeYUnit=\"nm\"").grid.spacing,
            Vec3(1, 1, 1));
  EXPECT_NE(notes.find("gives a size of pixels along y only (500 nm);"), std::string::npos) << notes;
  read_with(sizes + "PhysicalSizeZ=\"0\"");
  EXPECT_NE(notes.find("not positive and finite"), std::string::npos) << notes;
  read(tiff(5, 4, {page}, {.tags = {TiffBytes::text(270, "<OME><Image")}}));
}

TEST_F(Tiff, AStackShorterThanItsDescriptionIsRefused) {
  const auto with = [&](const std::string& description, std::size_t pages) {
    return tiff(5, 4, std::vector<std::string>(pages, std::string(20, 'a')),
                {.tags = {TiffBytes::text(270, description)}});
  };
  const char* incomplete = "; it is incomplete, or its description is of another stack: save it again";
  for (const std::size_t pages : {1, 6})
    refused(with("ImageJ=1.53c\nimages=12\nslices=12\n", pages),
            fmt::format("says in its ImageJ description that it has 12 slices and holds {}{}", pages, incomplete));
  for (const std::size_t pages : {1, 12})
    refused(with(ome("SizeZ=\"24\" SizeC=\"1\" SizeT=\"1\""), pages),
            fmt::format("says in its OME-XML description that it has 24 slices and holds {}{}", pages, incomplete));
  refused(with("{\"shape\": [4, 4, 5]}", 3), "says in its tifffile description that it has 4 slices and holds 3");
  const auto files = [](const std::string& second) {
    return "<OME><Image><Pixels SizeZ=\"4\"><TiffData IFD=\"0\"><UUID FileName=\"a.tif\">u</UUID></TiffData><TiffData "
           "IFD=\"1\"><UUID FileName=\"" +
           second + "\">v</UUID></TiffData></Pixels></Image></OME>";
  };
  refused(with(files("b.tif"), 2), "holds 2; the others are in other files of the data set, which are not read");
  refused(with(files("a.tif"), 2), incomplete);
  // A longer one is whole.
  EXPECT_EQ(read(with("ImageJ=1.53c\nimages=2\nslices=2\n", 3)).grid.dims[2], 3);
  EXPECT_NE(notes.find("has 3 slices, and its ImageJ description says 2; all are taken"), std::string::npos) << notes;
  // A slice in a folder may have the description of the whole stack.
  const TemporaryFolder slices;
  for (const char* name : {"1.tif", "2.tif"}) slices.write(name, with(ome("SizeZ=\"2\" SizeC=\"1\""), 1));
  EXPECT_EQ(io::read_volume(slices.path()).grid.dims[2], 2);
  EXPECT_TRUE(io::open_slices(slices.path()));
}

TEST_F(Tiff, PagesWhereZeroIsWhiteAreNamed) {
  const auto with = [&](const std::vector<std::uint32_t>& photometric) {
    TiffBytes file;
    for (const std::uint32_t one : photometric) file.page(1, 1, {"a"}, {.photometric = one});
    read(file.file());
    return notes;
  };
  const std::string name = "'" + (folder / "t.tif").string() + "'";
  EXPECT_EQ(with({1, 1, 0}), "page 3 of " + name + " says that 0 is white; its values are inverted\n");
  EXPECT_EQ(with({1, 0, 1, 0}),
            "2 pages of " + name + ", the first of them page 2, say that 0 is white; their values are inverted\n");
  EXPECT_EQ(with({0, 0}),
            name + " says that 0 is white: its values are inverted, so that bright voxels have high values\n");
}

TEST_F(Tiff, SeveralVolumesInOneFileAreRefused) {
  const std::string page(20, 'a');
  const auto with = [&](const std::string& description, std::size_t pages = 4) {
    return tiff(5, 4, std::vector<std::string>(pages, page), {.tags = {TiffBytes::text(270, description)}});
  };
  EXPECT_NE(refused(with("ImageJ=1\nimages=4\nchannels=2\nslices=2\nhyperstack=true"), "2 channels").find("Split"),
            std::string::npos);
  refused(with("ImageJ=1\nimages=4\nframes=4"), "4 points in time");
  refused(with(ome("SizeZ=\"2\" SizeC=\"2\" SizeT=\"1\"")), "2 channels");
  refused(with(ome("SizeZ=\"2\" SizeC=\"1\" SizeT=\"2\"")), "2 points in time");
  refused(with("<OME><Image><Pixels/></Image><Image><Pixels/></Image></OME>"), "2 images");
  refused(with("{\"shape\": [2, 2, 4, 5]}"), "2 images");
  refused(with("{\"shape\": [2, 2, 4, 5], \"axes\": \"CZYX\"}"), "2 channels");
  refused(with("{\"shape\": [4, 4, 5], \"axes\": \"TYX\"}"), "4 points in time");
  EXPECT_EQ(read(with("{\"shape\": [4, 4, 5]}")).grid.dims[2], 4);
  EXPECT_EQ(read(with("{\"shape\": [1, 4, 4, 5]}")).grid.dims[2], 4);
  // One page of a set whose description is of the set.
  EXPECT_EQ(read(with(ome("SizeZ=\"1\" SizeC=\"2\" SizeT=\"1\""), 1)).grid.dims[2], 1);
}

// What ImageJ writes beyond 4 GB: one directory, all pictures behind it.
TEST_F(Tiff, PicturesBehindTheOnlyDirectory) {
  std::vector<std::uint16_t> values;
  for (int i = 0; i < 20 * 6; ++i) values.push_back(static_cast<std::uint16_t>(i * 300));
  for (const bool big : {false, true}) {
    const std::string all = bytes_of(values, big), page = all.substr(0, 40);
    for (const std::string& description : {std::string("ImageJ=1.53c\nimages=6\nslices=6\n"),
                                           std::string("{\"shape\": [6, 4, 5], \"truncated\": true}")}) {
      const TiffOptions o{.bits = 16, .big_endian = big, .tags = {TiffBytes::text(270, description)}};
      const std::string file = tiff(5, 4, {page}, o) + all.substr(40);
      const Volume v = read(file);
      EXPECT_EQ(v.grid.dims, (Dims{5, 4, 6}));
      EXPECT_EQ(std::get<std::vector<std::uint16_t>>(v.samples), values);
      EXPECT_EQ(notes, "");
      refused(file.substr(0, file.size() - 1), "6 slices");
    }
    const TiffOptions packed{
        .bits = 16, .big_endian = big, .compression = 8, .tags = {TiffBytes::text(270, "ImageJ=1.53c\nimages=6\n")}};
    refused(tiff(5, 4, {small_files::deflated(page)}, packed) + all, "holds 1;");
  }
}

}  // namespace tiff_description_test
}  // namespace quench
#endif
