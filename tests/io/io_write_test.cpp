// SPDX-License-Identifier: Apache-2.0
// Kinds of files, atomic writing, and round trips of Record through each output format.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <cmath>
#include <csignal>
#include <fstream>
#include <limits>
#include <set>
#include <utility>

#include "poly_samples.h"
#include "quench/axis.h"
#include "quench/io.h"

namespace quench {
namespace io_write_test {

using testing_files::bytes_of;
using testing_files::code_of;
using testing_files::expect_same;
using testing_files::expect_same_cells;
using testing_files::Folder;
using testing_files::mixed_sample;
using testing_files::values_of;
using testing_files::write_bytes;

Record round_trip(const Record& data, const std::string& name, const io::WriteOptions& options = {}) {
  const Folder folder;
  io::write_record(folder / name, data, options);
  EXPECT_EQ(folder.entries(), 1u) << "a temporary file is left";
  Record read = io::read_record(folder / name);
  read.validate();
  return read;
}

// --- kinds and writing ---------------------------------------------------------------------------------------------

TEST(Kind, FollowsTheExtensionInAnyCase) {
  for (const char* name : {"a.ply", "b.OBJ", "c.Off", "d.stl", "e.vtp", "f.ma", "g.fbx", "h.gltf"})
    EXPECT_EQ(io::kind_of(name), io::Kind::surface) << name;
  for (const char* name :
       {"a.nrrd", "a.nhdr", "a.mha", "a.mhd", "a.nii", "a.nii.gz", "a.NII.GZ", "a.mrc", "a.map", "a.tif", "a.tiff",
        "a.png", "a.npy", "a.vol", "a.sof", "a.h5", "a.HDF5", "a.h5:/b/c", "a.ims:c"})
    EXPECT_EQ(io::kind_of(name), io::Kind::volume) << name;
  for (const char* name : {"a", "a.gz", "a.txt", "ply", ".ply", "a.csv"})
    EXPECT_EQ(io::kind_of(name), io::Kind::unknown) << name;
}

TEST(Kind, NamesADatasetOfAFile) {
  const Folder folder;
  for (const char* there : {"d", "x:y"}) std::filesystem::create_directories(folder / there);
  for (const char* there : {"d/a.h5", "a.h5", "x:y/a.hdf5", "a:b"}) write_bytes(folder / there, "");
  for (const auto& [name, file] : {std::pair("d/a.h5:/b/c", "d/a.h5"),
                                   {"a.h5", "a.h5"},
                                   {"x:y/a.hdf5:b:c", "x:y/a.hdf5"},
                                   {"a:b", "a:b"},
                                   {"missing:c", "missing:c"}})
    EXPECT_EQ(io::place_of_input(folder / name), folder / file) << name;
}

TEST(Kind, DicomIsKnownByItsMark) {
  const Folder folder;
  std::ofstream(folder / "IM0001") << std::string(128, '\0') + "DICM";
  std::ofstream(folder / "1.2.840.113") << std::string(128, '\0') + "DICM";
  std::ofstream(folder / "other") << std::string(128, '\0') + "DICK";
  std::ofstream(folder / "mesh.ply") << std::string(128, '\0') + "DICM";
  EXPECT_EQ(io::kind_of(folder / "IM0001"), io::Kind::volume);
  EXPECT_EQ(io::kind_of(folder / "1.2.840.113"), io::Kind::volume);
  EXPECT_EQ(io::kind_of(folder / "other"), io::Kind::unknown);
  EXPECT_EQ(io::kind_of(folder / "mesh.ply"), io::Kind::surface);
  EXPECT_EQ(io::kind_of(folder / ""), io::Kind::volume);
}

TEST(Kind, FolderOfSlicesIsAVolume) {
  const Folder folder;
  std::filesystem::create_directories(folder / "slices.ply");
  EXPECT_EQ(io::kind_of(folder / "slices.ply"), io::Kind::unknown);
  write_bytes(folder / "slices.ply/001.PNG", "");
  EXPECT_EQ(io::kind_of(folder / "slices.ply"), io::Kind::volume);
}

TEST(WriteAtomically, AnExceptionLeavesTheOldFileAndNothingElse) {
  const Folder folder;
  write_bytes(folder / "a.txt", "old");
  EXPECT_THROW(io::write_atomically(folder / "a.txt",
                                    [](std::ostream& out) {
                                      out << "half";
                                      throw Error(ErrorCode::cancelled, "cancelled");
                                    }),
               Error);
  EXPECT_EQ(bytes_of(folder / "a.txt"), "old");
  EXPECT_EQ(folder.entries(), 1u);
  io::write_atomically(folder / "a.txt", [](std::ostream& out) { out << "new"; });
  EXPECT_EQ(bytes_of(folder / "a.txt"), "new");
  EXPECT_EQ(folder.entries(), 1u);
}

TEST(WriteAtomically, ReplacesTheFileBehindALink) {
  const Folder folder;
  write_bytes(folder / "target", "old");
  std::filesystem::create_symlink("target", folder / "link");
  io::write_atomically(folder / "link", [](std::ostream& out) { out << "new"; });
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link"));
  EXPECT_EQ(bytes_of(folder / "target"), "new");
}

TEST(WriteAtomically, MakesTheFileALinkPointsTo) {
  const Folder folder;
  std::filesystem::create_directory(folder / "real");
  std::filesystem::create_symlink("real/b", folder / "a");  // relative to the folder of the link
  std::filesystem::create_symlink("a", folder / "first");
  EXPECT_EQ(io::place_of_output(folder / "first"), folder / "real/b");
  io::write_atomically(folder / "first", [](std::ostream& out) { out << "new"; });
  EXPECT_EQ(bytes_of(folder / "real/b"), "new");
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "a"));
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "first"));
  EXPECT_EQ(folder.entries(), 3u);
  std::filesystem::create_symlink("round", folder / "round");
  EXPECT_EQ(code_of([&] { io::write_atomically(folder / "round", [](std::ostream&) {}); }), ErrorCode::failed);
}

// Who may read the old file may read the new one, nobody else at any time; and it does not act for its owner.
TEST(WriteAtomically, KeepsThePermissions) {
  const Folder folder;
  for (const mode_t mode : {0600, 0640, 0444, 0666, 04755, 02777}) {
    write_bytes(folder / "a", "old");
    ASSERT_EQ(chmod((folder / "a").c_str(), mode), 0);
    io::write_atomically(folder / "a", [&](std::ostream& out) {
      out << "new";
      for (const auto& entry : std::filesystem::directory_iterator(folder / "")) {
        const auto now = static_cast<mode_t>(entry.status().permissions());
        EXPECT_EQ(now & ~mode, 0u) << entry.path();
      }
    });
    EXPECT_EQ(static_cast<mode_t>(std::filesystem::status(folder / "a").permissions()), mode & 0777);
    std::filesystem::remove(folder / "a");
  }
  const mode_t before = umask(027);
  io::write_atomically(folder / "fresh", [](std::ostream& out) { out << "new"; });
  umask(before);
  EXPECT_EQ(static_cast<mode_t>(std::filesystem::status(folder / "fresh").permissions()), 0640u);
}

TEST(WriteAtomically, TemporaryNamesCannotBeGuessed) {
  const Folder folder;
  std::set<std::string> names;
  for (int i = 0; i < 100; ++i)
    io::write_atomically(folder / "a", [&](std::ostream& out) {
      out << "new";
      for (const auto& entry : std::filesystem::directory_iterator(folder / ""))
        if (entry.path().extension() == ".tmp") names.insert(entry.path().filename().string());
    });
  EXPECT_EQ(names.size(), 100u);
  std::set<std::string> ends;  // numbers in a row would share their beginning or their end
  for (const std::string& name : names) {
    EXPECT_EQ(name.size(), std::string(".quench-0123456789abcdef.tmp").size()) << name;
    ends.insert(name.substr(8, 8));
    ends.insert(name.substr(16, 8));
  }
  EXPECT_GT(ends.size(), 195u);
}

TEST(WriteAtomically, LargePiecesAndManySmallOnes) {
  const Folder folder;
  std::string expected;
  io::write_atomically(folder / "a", [&](std::ostream& out) {
    for (std::size_t i = 0; i < 5; ++i) {
      const std::string piece(i * 700'001, static_cast<char>('a' + i));
      out << piece;
      out.put('-');
      expected += piece + '-';
      for (int n = 0; n < 1000; ++n) out << n;
      for (int n = 0; n < 1000; ++n) expected += std::to_string(n);
    }
  });
  EXPECT_TRUE(bytes_of(folder / "a") == expected);
}

TEST(WriteAtomically, SaysWhatIsWrongWithTheFolder) {
  const Folder folder;
  const auto body = [](std::ostream& out) { out << "text"; };
  std::string sentence;
  EXPECT_EQ(code_of([&] { io::write_atomically(folder / "none/a.txt", body); }, &sentence), ErrorCode::failed);
  EXPECT_NE(sentence.find("does not exist"), std::string::npos) << sentence;
  write_bytes(folder / "file", "");
  EXPECT_EQ(code_of([&] { io::write_atomically(folder / "file/a.txt", body); }, &sentence), ErrorCode::failed);
  EXPECT_EQ(code_of([&] { io::write_atomically(folder / "", body); }, &sentence), ErrorCode::failed);
  EXPECT_NE(sentence.find("folder"), std::string::npos) << sentence;
}

TEST(WriteAtomically, AFullDiskIsAnError) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  std::string sentence;
  EXPECT_EQ(code_of([] { io::write_atomically("/dev/full", [](std::ostream& out) { out << "text"; }); }, &sentence),
            ErrorCode::failed);
  EXPECT_NE(sentence.find("No space left"), std::string::npos) << sentence;
  EXPECT_FALSE(std::filesystem::is_regular_file("/dev/full"));
}

TEST(WriteAtomically, AFileThatMayNotGrowIsAnErrorAndLeavesNothing) {
  const Folder folder;
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit small{1 << 16, before.rlim_max};
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  const std::string much(1 << 22, 'x');
  ErrorCode code{};
  try {
    io::write_atomically(folder / "a.txt", [&](std::ostream& out) { out << much; });
  } catch (const Error& error) {
    code = error.code();
  }
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(code, ErrorCode::failed);
  EXPECT_EQ(folder.entries(), 0u);
}

TEST(Read, MissingFilesFoldersAndUnknownFormatsAreNamed) {
  const Folder folder;
  EXPECT_EQ(code_of([&] { io::read_record(folder / "none.ply"); }), ErrorCode::failed);
  std::filesystem::create_directories(folder / "folder.ply");
  EXPECT_EQ(code_of([&] { io::read_record(folder / "folder.ply"); }), ErrorCode::failed);
  EXPECT_EQ(code_of([&] { io::read_record(folder / "a.txt"); }), ErrorCode::input);
  EXPECT_EQ(code_of([&] { io::write_record(folder / "a.off", {}); }), ErrorCode::usage);
}

// --- round trips ---------------------------------------------------------------------------------------------------

TEST(RoundTrip, VtpCarriesEverything) {
  const Record data = mixed_sample();
  data.validate();
  expect_same(data, round_trip(data, "a.vtp"));
}

TEST(RoundTrip, VtpKeepsNonFiniteAndExtremeNumbers) {
  Record data = mixed_sample();
  auto& radius = std::get<std::vector<double>>(data.point_data[0].values);
  radius[0] = std::numeric_limits<double>::infinity();
  radius[1] = std::numeric_limits<double>::denorm_min();
  radius[2] = -0.0;
  expect_same(data, round_trip(data, "a.vtp"));
  radius[3] = std::nan("");
  EXPECT_TRUE(std::isnan(values_of<double>(round_trip(data, "a.vtp").point_data, "radius")[3]));
}

TEST(RoundTrip, VtpOfNothing) { expect_same({}, round_trip({}, "a.vtp")); }

TEST(RoundTrip, VtpOfSeveralCompressedBlocks) {
  Record data;
  std::vector<double> radius;
  for (int i = 0; i < 100000; ++i) {
    data.points.emplace_back(std::sin(i), std::cos(3.0 * i), i);
    radius.push_back(std::sqrt(i));
    if (i >= 2) {
      for (int c = 0; c < 3; ++c) data.poly_corners.push_back(static_cast<std::uint32_t>(i - c));
      data.poly_offsets.push_back(static_cast<std::uint32_t>(data.poly_corners.size()));
    }
  }
  data.point_data = {{"radius", 1, radius}};
  expect_same(data, round_trip(data, "a.vtp"));
}

TEST(RoundTrip, VtpHasTheSameBytesEveryTime) {
  const Folder folder;
  io::write_record(folder / "a.vtp", mixed_sample());
  io::write_record(folder / "b.vtp", mixed_sample());
  EXPECT_EQ(bytes_of(folder / "a.vtp"), bytes_of(folder / "b.vtp"));
}

TEST(RoundTrip, PlyCarriesCellsAndSingleArrays) {
  const Record data = mixed_sample();
  const Record read = round_trip(data, "a.ply");
  expect_same_cells(data, read);
  EXPECT_EQ(values_of<double>(read.point_data, "radius"), values_of<double>(data.point_data, "radius"));
  EXPECT_EQ(values_of<float>(read.point_data, "burn_time"), values_of<float>(data.point_data, "burn_time"));
  EXPECT_EQ(values_of<float>(read.point_data, "component")[3], -3);
  const auto radius = values_of<double>(data.point_data, "radius");
  EXPECT_EQ(values_of<float>(read.point_data, "quality"), std::vector<float>(radius.begin(), radius.end()));
  EXPECT_EQ(values_of<std::uint8_t>(read.point_data, "red").front(), 68);
  EXPECT_EQ(values_of<std::uint8_t>(read.point_data, "red").back(), 253);
  EXPECT_EQ(find_array(read.point_data, "a <name> & \"more\""), nullptr);
}

TEST(RoundTrip, PlyQualityOfAnotherArray) {
  const Record data = mixed_sample();
  const Record read = round_trip(data, "a.ply", {.quality_array = "burn_time"});
  EXPECT_EQ(values_of<float>(read.point_data, "quality"), values_of<float>(data.point_data, "burn_time"));
  EXPECT_EQ(code_of([&] { round_trip(data, "a.ply", {.quality_array = "nothing"}); }), ErrorCode::usage);
}

TEST(RoundTrip, PlyReadsItselfTwiceTheSame) {
  const Record once = round_trip(mixed_sample(), "a.ply");
  expect_same(once, round_trip(once, "a.ply"));
}

TEST(RoundTrip, PlyOfLongFaces) {
  Record data;
  for (std::uint32_t i = 0; i < 300; ++i) {
    data.points.emplace_back(i, 0, 0);
    data.poly_corners.push_back(i);
  }
  data.poly_offsets.push_back(300);
  expect_same(data, round_trip(data, "a.ply"));
}

TEST(RoundTrip, ObjCarriesAllCells) {
  const Record data = mixed_sample();
  const Record read = round_trip(data, "a.obj");
  expect_same_cells(data, read);
  EXPECT_EQ(data.verts, read.verts);
}

TEST(RoundTrip, MaCarriesRadii) {
  const Record data = mixed_sample();
  const Record read = round_trip(data, "a.ma");
  EXPECT_EQ(data.points, read.points);
  // All edges are there: lines first, then the sides of triangles.
  ASSERT_GE(read.lines.size(), data.lines.size());
  EXPECT_TRUE(std::equal(data.lines.begin(), data.lines.end(), read.lines.begin()));
  EXPECT_EQ(to_triangle_mesh(data).triangles, to_triangle_mesh(read).triangles);  // .ma has triangles only
  const CellComplex all = complex_of(read);
  EXPECT_EQ(all.edges.size(), read.lines.size());
  EXPECT_EQ(read.poly_corners.size(), 3 * read.poly_count());
  EXPECT_EQ(values_of<double>(read.point_data, "radius"), values_of<double>(data.point_data, "radius"));
  EXPECT_EQ(code_of([] { round_trip({}, "a.ma"); }), ErrorCode::input);
}

TEST(RoundTrip, RadiiOfAnRFile) {
  Record data = mixed_sample();
  for (std::size_t i = 0; i < data.points.size(); ++i) data.points[i][2] = static_cast<double>(i * i);
  const Folder folder;
  io::write_record(folder / "a.r", data);
  auto radii = values_of<double>(data.point_data, "radius");
  EXPECT_EQ(io::read_radii(folder / "a.r", data.points), radii);
  std::vector<Vec3> shifted(data.points.rbegin(), data.points.rend());
  for (Vec3& p : shifted) p += Vec3(0.01, 0.01, -0.01);
  std::reverse(radii.begin(), radii.end());
  EXPECT_EQ(io::read_radii(folder / "a.r", shifted), radii);
  for (Vec3& p : shifted) p[0] += 0.2;
  EXPECT_EQ(code_of([&] { io::read_radii(folder / "a.r", shifted); }), ErrorCode::input);
}

TEST(Write, CsvHasARowPerVertex) {
  Record data;
  data.points = {{0.1, 2, -3}, {1e-300, 0, 1.0 / 3}};
  data.point_data = {{"radius", 1, std::vector<double>{0.5, 1e22}},
                     {"a,b", 2, std::vector<float>{0.1f, 2, 3, 4}},
                     {"flag", 1, std::vector<std::uint8_t>{7, 65}}};
  const Folder folder;
  io::write_record(folder / "a.csv", data);
  EXPECT_EQ(bytes_of(folder / "a.csv"),
            "x,y,z,radius,\"a,b_0\",\"a,b_1\",flag\n0.1,2,-3,0.5,0.1,2,7\n1e-300,0,0.3333333333333333,1e+22,3,4,65\n");
}

}  // namespace io_write_test
}  // namespace quench
