// SPDX-License-Identifier: Apache-2.0
// Volumes of numbers as they are written, read by the readers (which value_writer.py does by libraries of others).
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <string>

#include "quench/error.h"
#include "quench/io.h"
#include "temporary_folder.h"

namespace quench {
namespace value_writer_test {

Grid sample_grid(bool plane = false) {
  Grid grid;
  grid.dims = {7, 5, plane ? 1 : 40};
  grid.spacing = {0.5, 0.25, 2};
  grid.origin = {10, -20, 30};
  grid.direction << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  if (plane) {
    grid.make_plane();
    grid.direction = Mat3::Identity();
    grid.origin = {3, 4, 0};
  }
  return grid;
}

float sample_value(std::int64_t i) { return i % 3 == 0 ? 0.0f : static_cast<float>(std::sqrt(static_cast<double>(i))); }

void write_sample(const std::filesystem::path& file, const Grid& grid, const Coordinates& coordinates) {
  io::write_values(
      file, grid,
      [&](const auto& take) {
        const std::int64_t size = grid.dims[0] * grid.dims[1];
        std::vector<float> slice(static_cast<std::size_t>(size));
        for (std::int64_t z = 0; z < grid.dims[2]; ++z) {
          for (std::int64_t i = 0; i < size; ++i) slice[static_cast<std::size_t>(i)] = sample_value(z * size + i);
          take(slice);
        }
      },
      coordinates);
}

void expect_sample(const Volume& volume, const Grid& grid) {
  EXPECT_EQ(volume.grid.dims, grid.dims);
  EXPECT_EQ(volume.grid.dimension, grid.dimension);
  const auto& values = std::get<std::vector<float>>(volume.samples);
  ASSERT_EQ(values.size(), static_cast<std::size_t>(grid.dims[0] * grid.dims[1] * grid.dims[2]));
  for (std::size_t i = 0; i < values.size(); ++i) ASSERT_EQ(values[i], sample_value(static_cast<std::int64_t>(i))) << i;
}

TEST(ValueWriter, FormatsAreReadAgain) {
  TemporaryFolder folder;
  const Grid grid = sample_grid();
  for (const char* name : {"a.nrrd", "a.nii", "a.nii.gz", "a.tif", "a.npy"}) {
    write_sample(folder / name, grid, {"mm", "LPS"});
    const Volume volume = io::read_volume(folder / name);
    expect_sample(volume, grid);
    const std::string format = name;
    if (format.ends_with(".npy")) continue;
    EXPECT_TRUE(volume.grid.spacing.isApprox(grid.spacing, 1e-6)) << name << volume.grid.spacing.transpose();
    EXPECT_EQ(volume.coordinates.units, "mm") << name;
    if (format.ends_with(".tif")) continue;
    EXPECT_TRUE(volume.grid.origin.isApprox(grid.origin, 1e-6)) << name << volume.grid.origin.transpose();
    EXPECT_TRUE(volume.grid.direction.isApprox(grid.direction, 1e-6)) << name;
    EXPECT_EQ(volume.coordinates.space, "LPS") << name;
  }
}

TEST(ValueWriter, Images) {
  TemporaryFolder folder;
  const Grid grid = sample_grid(true);
  Coordinates coordinates;
  coordinates.y_down = true;
  for (const char* name : {"a.nrrd", "a.tif", "a.npy"}) {
    write_sample(folder / name, grid, coordinates);
    expect_sample(io::read_volume(folder / name), grid);
  }
}

TEST(ValueWriter, TiffHasItsSlicesBehindOneAnother) {  // as ImageJ reads them, which looks at the first directory only
  TemporaryFolder folder;
  Grid grid;
  grid.dims = {3, 5, 7};  // slices of 60 bytes
  write_sample(folder / "a.tif", grid, {});
  expect_sample(io::read_volume(folder / "a.tif"), grid);
  std::ifstream file(folder / "a.tif", std::ios::binary);
  file.seekg(8);
  for (std::int64_t i = 0; i < 3 * 5 * 7; ++i) {
    float value = 0;
    file.read(reinterpret_cast<char*>(&value), sizeof value);
    ASSERT_EQ(value, sample_value(i)) << i;
  }
}

TEST(ValueWriter, SlicesOfSeveralParts) {  // more than are compressed at a time
  TemporaryFolder folder;
  Grid grid;
  grid.dims = {512, 512, 24};
  write_sample(folder / "a.nrrd", grid, {});
  expect_sample(io::read_volume(folder / "a.nrrd"), grid);
}

TEST(ValueWriter, RefusesOtherFormats) {
  EXPECT_THROW(io::check_value_format("a.vol"), Error);
  EXPECT_THROW(io::check_value_format("nrrd"), Error);
  TemporaryFolder folder;
  Grid grid;
  grid.dims = {40000, 1, 1};
  EXPECT_THROW(io::write_values(folder / "a.nii", grid, [](const auto&) {}), Error);
  EXPECT_FALSE(std::filesystem::exists(folder / "a.nii"));
}

}  // namespace value_writer_test
}  // namespace quench
