// SPDX-License-Identifier: Apache-2.0
// OME-Zarr as it is written, read here by code of its own; zarr_writer.py reads it with python3-zarr.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <zlib.h>

#include <atomic>
#include <map>
#include <nlohmann/json.hpp>
#include <random>

#include "poly_samples.h"
#include "quench/io.h"
#include "quench/samples.h"
#include "random_shapes.h"
#include "temporary_folder.h"

namespace quench {
namespace zarr_writer_test {

namespace fs = std::filesystem;
using testing_files::bytes_of;
using testing_files::code_of;
using testing_files::write_bytes;
constexpr std::size_t kZarrVoxels = 128 * 128 * 128;
using Files = std::map<std::string, std::string>;

/// Every file of a folder by its name in it.
Files files_of(const fs::path& folder) {
  Files files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) files[entry.path().lexically_relative(folder)] = bytes_of(entry.path());
  return files;
}

std::vector<std::string> names_in(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename());
  std::sort(names.begin(), names.end());
  return names;
}

std::string inflated(const std::string& bytes) {
  std::string out(kZarrVoxels, '\0');
  uLongf size = out.size();
  EXPECT_EQ(uncompress(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()),
                       bytes.size()),
            Z_OK);
  EXPECT_EQ(size, out.size());
  return out;
}

/// Compares every voxel with `expected`, and every file with what there should be.
template <class Expected>
void expect_voxels(const fs::path& folder, const Grid& grid, int background, const Expected& expected) {
  Files files = files_of(folder);
  const auto array = nlohmann::json::parse(files.at("0/.zarray"));
  EXPECT_EQ(array["shape"], (std::vector<std::int64_t>{grid.dims[2], grid.dims[1], grid.dims[0]}));
  EXPECT_EQ(array["chunks"], (std::vector<std::int64_t>{128, 128, 128}));
  EXPECT_EQ(array["fill_value"], background);
  for (const char* name : {".zgroup", ".zattrs", "0/.zarray"}) EXPECT_EQ(files.erase(name), 1u);
  const auto last = [&](std::size_t a) { return (grid.dims[a] - 1) / 128; };
  for (std::int64_t z = 0; z <= last(2); ++z)
    for (std::int64_t y = 0; y <= last(1); ++y)
      for (std::int64_t x = 0; x <= last(0); ++x) {
        const std::string name = "0/" + std::to_string(z) + '/' + std::to_string(y) + '/' + std::to_string(x);
        std::string samples(kZarrVoxels, static_cast<char>(background));
        for (std::int64_t k = 0; k < 128 && 128 * z + k < grid.dims[2]; ++k)
          for (std::int64_t j = 0; j < 128 && 128 * y + j < grid.dims[1]; ++j)
            for (std::int64_t i = 0; i < 128 && 128 * x + i < grid.dims[0]; ++i)
              samples[static_cast<std::size_t>(i + 128 * (j + 128 * k))] =
                  static_cast<char>(expected(128 * x + i, 128 * y + j, 128 * z + k));
        const bool empty = samples.find_first_not_of(static_cast<char>(background)) == std::string::npos;
        ASSERT_EQ(files.contains(name), !empty) << name;
        if (empty) continue;
        ASSERT_TRUE(inflated(files[name]) == samples) << name;
        files.erase(name);
      }
  EXPECT_TRUE(files.empty()) << files.begin()->first << " should not be there";
}

VoxelShape point_at(const Grid& grid, int x, int y, int z) {
  VoxelShape shape(grid);
  for (int k = 0; k < grid.dims[2]; ++k)
    for (int j = 0; j < grid.dims[1]; ++j) {
      const quench::Run run{x, x + 1};
      shape.append_row(j == y && k == z ? std::span<const quench::Run>(&run, 1) : std::span<const quench::Run>());
    }
  return shape;
}

Grid small_grid() {
  Grid grid;
  grid.dims = {5, 4, 3};
  return grid;
}

TEST(ZarrWriter, WhatItSays) {
  const TemporaryFolder folder;
  Grid grid = small_grid();
  grid.spacing = {0.25, 0.5, 2};
  grid.origin = {-1.5, -0.0, 1e-7};
  io::write_volume(folder / "a root.ome.zarr", point_at(grid, 4, 2, 1), {.units = "mm", .space = "LPS"});
  EXPECT_EQ(names_in(folder.path()), std::vector<std::string>{"a root.ome.zarr"});
  const Files files = files_of(folder / "a root.ome.zarr");
  EXPECT_EQ(files.size(), 4u);
  EXPECT_EQ(nlohmann::json::parse(files.at(".zgroup")), nlohmann::json::parse(R"({"zarr_format": 2})"));
  EXPECT_EQ(nlohmann::json::parse(files.at(".zattrs")), nlohmann::json::parse(R"({"multiscales": [{
      "version": "0.4", "name": "a root.ome",
      "axes": [{"name": "z", "type": "space", "unit": "millimeter"},
               {"name": "y", "type": "space", "unit": "millimeter"},
               {"name": "x", "type": "space", "unit": "millimeter"}],
      "datasets": [{"path": "0", "coordinateTransformations": [
          {"type": "scale", "scale": [2.0, 0.5, 0.25]},
          {"type": "translation", "translation": [1e-7, 0.0, -1.5]}]}]}]})"));
  EXPECT_EQ(files.at(".zattrs").find("-0.0"), std::string::npos);
  EXPECT_EQ(nlohmann::json::parse(files.at("0/.zarray")), nlohmann::json::parse(R"({"zarr_format": 2,
      "shape": [3, 4, 5], "chunks": [128, 128, 128], "dtype": "|u1", "compressor": {"id": "zlib", "level": 6},
      "fill_value": 0, "order": "C", "filters": null, "dimension_separator": "/"})"));
}

TEST(ZarrWriter, UnitsHaveTheNamesOfTheStandard) {
  const TemporaryFolder folder;
  for (const auto& [unit, name] : std::vector<std::pair<std::string, nlohmann::json>>{{"um", "micrometer"},
                                                                                      {"\u00b5m", "micrometer"},
                                                                                      {"angstrom", "angstrom"},
                                                                                      {"furlong", "furlong"},
                                                                                      {"", {}}}) {
    io::write_volume(folder / "u.zarr", point_at(small_grid(), 0, 0, 0), {.units = unit, .space = {}});
    const auto attributes = nlohmann::json::parse(bytes_of(folder / "u.zarr/.zattrs"));
    EXPECT_EQ(attributes["multiscales"][0]["axes"][0].value("unit", nlohmann::json()), name) << unit;
  }
}

TEST(ZarrWriter, RandomShapes) {
  const TemporaryFolder folder;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    SCOPED_TRACE(seed);
    const VoxelShape shape = testing_shapes::random_shape(seed, 12, true);
    io::write_volume(folder / "r.zarr", shape);
    expect_voxels(folder / "r.zarr", shape.grid(), 0,
                  [&](std::int64_t x, std::int64_t y, std::int64_t z) { return shape.contains(x, y, z); });
  }
}

// Sides that are one less than chunks, whole chunks, one more; runs over several chunks, and none in most.
TEST(ZarrWriter, ShapesOfSeveralChunks) {
  const TemporaryFolder folder;
  std::mt19937 random(7);
  for (const auto& dims : std::vector<std::array<std::int64_t, 3>>{
           {127, 129, 3}, {128, 256, 2}, {129, 128, 2}, {400, 2, 130}, {1, 1, 300}, {385, 130, 129}}) {
    Grid grid;
    grid.dims = dims;
    VoxelShape shape(grid);
    for (std::int64_t row = 0; row < dims[1] * dims[2]; ++row) {
      std::vector<quench::Run> runs;
      if (random() % 50 == 0) {
        const auto a = static_cast<std::int32_t>(random() % static_cast<std::uint32_t>(dims[0]));
        const auto more = static_cast<std::int32_t>(1 + random() % static_cast<std::uint32_t>(dims[0] - a));
        runs.push_back({a, a + more});
      }
      shape.append_row(runs);
    }
    io::write_volume(folder / "s.zarr", shape);
    expect_voxels(folder / "s.zarr", grid, 0,
                  [&](std::int64_t x, std::int64_t y, std::int64_t z) { return shape.contains(x, y, z); });
  }
}

TEST(ZarrWriter, AnEmptyVolumeHasNoChunks) {
  const TemporaryFolder folder;
  io::write_zarr(folder / "e.zarr", {.dims = {300000, 1000, 1000}}, 7,
                 [](const auto&) { return std::vector<std::uint8_t>(); });
  EXPECT_EQ(files_of(folder / "e.zarr").size(), 3u);
}

TEST(ZarrWriter, GreyRootsAreThoseOfTheSlices) {
  const TemporaryFolder folder;
  const Sample root = make_sample("root", {.branches = 8, .gaps = 3});
  for (const GreyOptions& options : {GreyOptions{.resolution = 150}, GreyOptions{.resolution = 140, .blur = 1.3},
                                     GreyOptions{.resolution = 60, .blur = 0.7, .noise = 0.05}}) {
    const Grid grid = grey_grid(root, options);
    std::string samples;
    grey_slices(root, options,
                [&](std::span<const std::uint8_t> slice) { samples.append(slice.begin(), slice.end()); });
    io::write_zarr(folder / "g.zarr", grid, kGreyBackground, grey_cubes(root, options, io::kZarrSide));
    expect_voxels(folder / "g.zarr", grid, kGreyBackground, [&](std::int64_t x, std::int64_t y, std::int64_t z) {
      return samples[static_cast<std::size_t>(x + grid.dims[0] * (y + grid.dims[1] * z))];
    });
  }
}

TEST(ZarrWriter, TheSameBytesOnEveryNumberOfThreads) {
  const TemporaryFolder folder;
  const Sample root = make_sample("root", {.branches = 8});
  const GreyOptions options{.resolution = 300};
  Files first;
  for (const int threads : {1, 2, 5}) {
    Context context;
    context.threads = threads;
    io::write_zarr(folder / "t.zarr", grey_grid(root, options), kGreyBackground,
                   grey_cubes(root, options, io::kZarrSide), {}, &context);
    if (first.empty()) first = files_of(folder / "t.zarr");
    EXPECT_GT(first.size(), 5u);
    EXPECT_TRUE(files_of(folder / "t.zarr") == first) << threads;
  }
}

// Every voxel stays at its place in the world.
TEST(ZarrWriter, AxesThatGoDownAreTurnedRound) {
  const TemporaryFolder folder;
  for (int turned = 1; turned < 8; ++turned) {
    Grid grid = small_grid();
    grid.dims[0] = 200;
    grid.spacing = {0.5, 2, 3};
    grid.origin = {7, -4, 1};
    for (int a = 0; a < 3; ++a)
      if (turned >> a & 1) grid.direction(a, a) = -1;
    const VoxelShape shape =
        testing_shapes::from_predicate(grid, [](int x, int y, int z) { return (x * x + 3 * y + z) % 7 < 2; });
    io::write_volume(folder / "t.zarr", shape);
    const auto level = nlohmann::json::parse(bytes_of(folder / "t.zarr/.zattrs"))["multiscales"][0]["datasets"][0];
    const auto translation = level["coordinateTransformations"][1]["translation"];
    Grid upward = grid;
    upward.direction = Mat3::Identity();
    for (int a = 0; a < 3; ++a) upward.origin[a] = translation[static_cast<std::size_t>(2 - a)].get<double>();
    expect_voxels(folder / "t.zarr", upward, 0, [&](std::int64_t x, std::int64_t y, std::int64_t z) {
      const Vec3 there = grid.lattice(upward.world(Vec3(x + 0.5, y + 0.5, z + 0.5)));
      const auto at = [&](int a) { return static_cast<std::int64_t>(std::floor(there[a])); };
      return shape.contains(at(0), at(1), at(2));
    });
  }
}

TEST(ZarrWriter, WhatTheFormatCannotSayIsRefused) {
  const TemporaryFolder folder;
  std::string sentence;
  Grid grid = small_grid();
  grid.direction << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  EXPECT_EQ(code_of([&] { io::write_volume(folder / "d.zarr", point_at(grid, 0, 0, 0)); }, &sentence),
            ErrorCode::usage);
  EXPECT_NE(sentence.find("directions"), std::string::npos) << sentence;
  Grid plane;
  plane.dims = {5, 4, 1};
  plane.make_plane();
  EXPECT_EQ(code_of([&] { io::write_volume(folder / "p.zarr", point_at(plane, 0, 0, 0)); }, &sentence),
            ErrorCode::usage);
  EXPECT_NE(sentence.find("plane"), std::string::npos) << sentence;
  EXPECT_TRUE(names_in(folder.path()).empty());
}

// --- what is there already ------------------------------------------------------------------------------------------

TEST(ZarrWriter, ReplacesAnotherZarrAsAWhole) {
  const TemporaryFolder folder;
  Grid wide;
  wide.dims = {300, 2, 2};
  io::write_volume(folder / "new.zarr", point_at(small_grid(), 1, 1, 1));
  for (const bool grouped : {false, true}) {
    io::write_volume(folder / "a.zarr", point_at(wide, 299, 1, 1));
    EXPECT_TRUE(fs::exists(folder / "a.zarr/0/0/0/2"));
    ASSERT_EQ(chmod((folder / "a.zarr").c_str(), 0750), 0);
    if (grouped) {
      io::OutputGroup group;
      io::write_volume(folder / "a.zarr/", point_at(small_grid(), 1, 1, 1));
      EXPECT_TRUE(fs::exists(folder / "a.zarr/0/0/0/2")) << "not before commit()";
      io::write_atomically(folder / "b.txt", [](std::ostream& out) { out << "text"; });
      group.commit();
      EXPECT_EQ(bytes_of(folder / "b.txt"), "text");
      fs::remove(folder / "b.txt");
    } else {
      io::write_volume(folder / "a.zarr", point_at(small_grid(), 1, 1, 1));
    }
    Files expected = files_of(folder / "new.zarr"), found = files_of(folder / "a.zarr");
    expected.erase(".zattrs");  // has the name
    found.erase(".zattrs");
    EXPECT_EQ(found, expected);
    EXPECT_EQ(static_cast<mode_t>(fs::status(folder / "a.zarr").permissions()), 0750u);
    EXPECT_EQ(names_in(folder.path()), (std::vector<std::string>{"a.zarr", "new.zarr"}));
  }
}

TEST(ZarrWriter, ReplacesTheFolderBehindALink) {
  const TemporaryFolder folder;
  fs::create_directory(folder / "disk");
  fs::create_directory_symlink("disk/real.zarr", folder / "link.zarr");
  for (int time = 0; time < 2; ++time) {
    io::write_volume(folder / "link.zarr", point_at(small_grid(), time, 1, 1));
    EXPECT_TRUE(fs::is_symlink(folder / "link.zarr"));
    EXPECT_EQ(names_in(folder / "disk"), std::vector<std::string>{"real.zarr"});
    expect_voxels(folder / "disk/real.zarr", small_grid(), 0,
                  [&](std::int64_t x, std::int64_t y, std::int64_t z) { return x == time && y == 1 && z == 1; });
  }
}

TEST(ZarrWriter, AFolderOfOtherThingsIsNeverReplaced) {
  const TemporaryFolder folder;
  io::write_volume(folder / "a.zarr", point_at(small_grid(), 1, 1, 1));
  const auto refused = [&](const std::string& word) {
    std::string sentence;
    const Files before = files_of(folder.path());
    EXPECT_EQ(code_of([&] { io::check_zarr_output(folder / "a.zarr"); }, &sentence), ErrorCode::usage);
    EXPECT_NE(sentence.find(word), std::string::npos) << sentence;
    EXPECT_EQ(code_of([&] { io::write_volume(folder / "a.zarr", point_at(small_grid(), 0, 0, 0)); }), ErrorCode::usage);
    EXPECT_EQ(files_of(folder.path()), before);
  };
  for (const char* name : {"notes.txt", "0/0/0/0.txt", "0/README", "labels/a.csv", "0/.hidden"}) {
    fs::create_directories((folder / "a.zarr" / name).parent_path());
    write_bytes(folder / "a.zarr" / name, "mine");
    refused(name);
    fs::remove(folder / "a.zarr" / name);
  }
  write_bytes(folder / "mine", "mine");
  fs::create_symlink(folder / "mine", folder / "a.zarr/0/0/0/1");
  refused("0/0/0/1");
  fs::remove(folder / "a.zarr/0/0/0/1");
  // What other programs write into a Zarr of version 2 or 3 is one.
  for (const char* name : {".zmetadata", "0/0.0.1", "s1/zarr.json", "s1/c/0/0/12", "s1/c.0.1"}) {
    fs::create_directories((folder / "a.zarr" / name).parent_path());
    write_bytes(folder / "a.zarr" / name, "{}");
  }
  io::write_volume(folder / "a.zarr", point_at(small_grid(), 1, 1, 1));
  EXPECT_EQ(files_of(folder / "a.zarr").size(), 4u);
  fs::remove_all(folder / "a.zarr");
  write_bytes(folder / "a.zarr", "a file");
  refused("not a folder");
}

TEST(ZarrWriter, SomethingPutThereMeanwhileStays) {
  const TemporaryFolder folder;
  const auto late = [&](const auto&) {
    fs::create_directories(folder / "a.zarr");
    write_bytes(folder / "a.zarr/notes.txt", "mine");
    return std::vector<std::uint8_t>();
  };
  EXPECT_EQ(code_of([&] { io::write_zarr(folder / "a.zarr", small_grid(), 0, late); }), ErrorCode::usage);
  EXPECT_EQ(files_of(folder.path()), (Files{{"a.zarr/notes.txt", "mine"}}));
}

// --- what goes wrong ------------------------------------------------------------------------------------------------

TEST(ZarrWriter, AnExceptionLeavesTheOldFolderAndNothingElse) {
  const TemporaryFolder folder;
  io::write_volume(folder / "a.zarr", point_at(small_grid(), 1, 1, 1));
  const Files before = files_of(folder.path());
  Grid grid;
  grid.dims = {700, 300, 300};
  std::atomic<int> chunks = 0;
  const auto broken = [&](const auto&) {
    if (++chunks == 12) throw Error(ErrorCode::failed, "no more");
    return std::vector<std::uint8_t>(kZarrVoxels, 1);
  };
  EXPECT_EQ(code_of([&] { io::write_zarr(folder / "a.zarr", grid, 0, broken); }), ErrorCode::failed);
  EXPECT_EQ(files_of(folder.path()), before);
  {
    io::OutputGroup group;
    io::write_volume(folder / "a.zarr", point_at(small_grid(), 0, 0, 0));
    io::write_volume(folder / "b.zarr", point_at(small_grid(), 0, 0, 0));
  }
  EXPECT_EQ(files_of(folder.path()), before) << "without commit()";
  EXPECT_EQ(names_in(folder.path()), std::vector<std::string>{"a.zarr"});
}

TEST(ZarrWriter, CancellingLeavesNothing) {
  const TemporaryFolder folder;
  Grid grid;
  grid.dims = {700, 300, 300};
  Context context;
  std::atomic<int> chunks = 0;
  const auto chunk = [&](const auto&) {
    if (++chunks == 5) context.cancel();
    return std::vector<std::uint8_t>(kZarrVoxels, 1);
  };
  EXPECT_EQ(code_of([&] { io::write_zarr(folder / "c.zarr", grid, 0, chunk, {}, &context); }), ErrorCode::cancelled);
  EXPECT_TRUE(names_in(folder.path()).empty());
}

// As when the program is ended by a second signal, while threads go on writing.
TEST(ZarrWriter, WhatIsRemovedAtTheEndOfTheProcessDoesNotComeBack) {
  const TemporaryFolder folder;
  Grid grid;
  grid.dims = {700, 300, 300};
  std::atomic<int> chunks = 0;
  const auto chunk = [&](const auto&) {
    if (++chunks == 7) {
      EXPECT_EQ(names_in(folder.path()).size(), 1u);
      io::remove_temporary_files();
      EXPECT_TRUE(names_in(folder.path()).empty());
    }
    return std::vector<std::uint8_t>(kZarrVoxels, 1);
  };
  EXPECT_EQ(code_of([&] { io::write_zarr(folder / "k.zarr", grid, 0, chunk); }), ErrorCode::cancelled);
  EXPECT_TRUE(names_in(folder.path()).empty());
}

TEST(ZarrWriter, SaysWhatIsWrongWithTheFolder) {
  const TemporaryFolder folder;
  std::string sentence;
  const auto write = [&](const std::string& name) {
    return code_of([&] { io::write_volume(folder / name, point_at(small_grid(), 0, 0, 0)); }, &sentence);
  };
  EXPECT_EQ(write("none/a.zarr"), ErrorCode::failed);
  EXPECT_NE(sentence.find("does not exist"), std::string::npos) << sentence;
  write_bytes(folder / "file", "");
  EXPECT_EQ(write("file/a.zarr"), ErrorCode::failed);
  EXPECT_NE(sentence.find("file"), std::string::npos) << sentence;
}

TEST(ZarrWriter, Names) {
  for (const char* name : {"a.zarr", "a.ome.zarr", "a.ZARR", "b/a.zarr/", "a.zarr/"})
    EXPECT_TRUE(io::is_zarr_name(name));
  for (const char* name : {"a.nrrd", "zarr", "a.zarr/0", "a.zarr.zip", "", "/"}) EXPECT_FALSE(io::is_zarr_name(name));
}

}  // namespace zarr_writer_test
}  // namespace quench
