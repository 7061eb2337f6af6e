// SPDX-License-Identifier: Apache-2.0
// VTP files against VTK itself: it reads ours, we read its own in every encoding. VTK runs in Python, outside.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <cstdio>

#include "poly_samples.h"

namespace quench {
namespace io_vtk_test {

using testing_files::Folder;
using testing_files::mixed_sample;

/// Runs VTK's side; its output, or nothing with `status` set.
std::string run_vtk(const std::string& arguments, int& status) {
  const auto script = std::filesystem::path(__FILE__).parent_path() / "vtk_roundtrip.py";
  const std::string command = fmt::format("/usr/bin/python3 -B '{}' {} 2>&1", script.string(), arguments);
  std::FILE* pipe = ::popen(command.c_str(), "r");
  if (!pipe) {
    status = -1;
    return {};
  }
  std::string output;
  std::array<char, 4096> block;
  while (const std::size_t size = std::fread(block.data(), 1, block.size(), pipe)) output.append(block.data(), size);
  const int result = ::pclose(pipe);
  status = WIFEXITED(result) ? WEXITSTATUS(result) : -1;
  return output;
}

#define REQUIRE_VTK()                                                    \
  if (int vtk_status = 0; run_vtk("probe", vtk_status), vtk_status != 0) \
  GTEST_SKIP() << "no VTK for /usr/bin/python3 here (Debian: python3-vtk9), status " << vtk_status

const char* vtk_type(const DataArray& array) {
  constexpr const char* names[] = {"double", "float", "long long", "int", "unsigned char", "string"};
  return names[array.values.index()];
}

std::string describe(const char* kind, const std::vector<DataArray>& arrays) {
  std::string text;
  for (const DataArray& array : arrays) {
    const auto components = static_cast<std::size_t>(array.components);
    text += fmt::format("{} {} {} {} {}", kind, array.name, vtk_type(array), components, array.size() / components);
    if (const auto* strings = std::get_if<std::vector<std::string>>(&array.values)) {
      text += ' ';
      for (std::size_t i = 0; i < strings->size(); ++i) text += (i ? "|" : "") + (*strings)[i];
    } else {
      const std::vector<double> values = array.numbers();
      for (std::size_t c = 0; c < components; ++c) {
        double low = 1e299, high = -1e299;
        for (std::size_t i = c; i < values.size(); i += components) {
          low = std::min(low, values[i]);
          high = std::max(high, values[i]);
        }
        text += fmt::format(" {:.9g} {:.9g}", low, high);
      }
    }
    text += '\n';
  }
  return text;
}

/// What vtk_roundtrip.py prints about this data.
std::string describe(const Record& data) {
  std::string text = fmt::format("errors 0\ncounts {} {} {} {} 0\n", data.points.size(), data.verts.size(),
                                 data.lines.size(), data.poly_count());
  for (const Vec3& p : data.points) text += fmt::format("point {:.17g} {:.17g} {:.17g}\n", p[0], p[1], p[2]);
  for (std::uint32_t v : data.verts) text += fmt::format("cell {}\n", v);
  for (const auto& line : data.lines) text += fmt::format("cell {} {}\n", line[0], line[1]);
  for (std::size_t p = 0; p < data.poly_count(); ++p) {
    text += "cell";
    for (std::uint32_t c = data.poly_offsets[p]; c < data.poly_offsets[p + 1]; ++c)
      text += fmt::format(" {}", data.poly_corners[c]);
    text += '\n';
  }
  text += "scalars radius\n";
  return text + describe("point", data.point_data) + describe("cell", data.cell_data) +
         describe("field", data.field_data);
}

TEST(Vtk, ReadsWhatWeWrite) {
  REQUIRE_VTK();
  Record data = mixed_sample();
  std::erase_if(data.field_data, [](const DataArray& array) { return array.size() == 0; });
  const Folder folder;
  io::write_record(folder / "a.vtp", data);
  int status = 0;
  const std::string seen = run_vtk("describe '" + (folder / "a.vtp").string() + "'", status);
  EXPECT_EQ(status, 0);
  EXPECT_EQ(seen, describe(data));
}

TEST(Vtk, ReadsLargeFilesOfManyBlocks) {
  REQUIRE_VTK();
  Record data;
  std::vector<double> radius;
  for (int i = 0; i < 40000; ++i) {
    data.points.emplace_back(i * 0.1, i % 7, i % 11);
    radius.push_back(0.25 + i % 13);
    data.verts.push_back(static_cast<std::uint32_t>(i));
  }
  data.point_data = {{"radius", 1, radius}};
  const Folder folder;
  io::write_record(folder / "a.vtp", data);
  int status = 0;
  EXPECT_EQ(run_vtk("describe '" + (folder / "a.vtp").string() + "'", status), describe(data));
  EXPECT_EQ(status, 0);
}

template <class T>
void expect_array(const std::vector<DataArray>& arrays, const char* name, const std::vector<T>& expected) {
  const DataArray* array = find_array(arrays, name);
  ASSERT_TRUE(array) << name;
  ASSERT_TRUE(std::holds_alternative<std::vector<T>>(array->values)) << name;
  EXPECT_EQ(std::get<std::vector<T>>(array->values), expected) << name;
}

/// The sample() of vtk_roundtrip.py: vertex cells, lines and strips of several points are split, with their cell data.
void expect_vtk_sample(const Record& data, bool ascii) {
  data.validate();
  ASSERT_EQ(data.points.size(), 6u);
  for (int i = 0; i < 6; ++i)
    EXPECT_LE((data.points[static_cast<std::size_t>(i)] - Vec3(0.1 * i, i * i, -i / 3.0)).norm(), ascii ? 1e-9 : 0.0);
  EXPECT_EQ(data.verts, (std::vector<std::uint32_t>{5, 3, 4}));
  EXPECT_EQ(data.lines, (std::vector<std::array<std::uint32_t, 2>>{{0, 1}, {1, 2}}));
  EXPECT_EQ(data.poly_offsets, (std::vector<std::uint32_t>{0, 3, 7, 10, 13}));
  EXPECT_EQ(data.poly_corners, (std::vector<std::uint32_t>{0, 1, 2, 2, 3, 4, 5, 0, 1, 2, 1, 3, 2}));
  expect_array<std::int32_t>(data.cell_data, "cell", {10, 20, 20, 30, 30, 40, 50, 60, 60});
  expect_array<std::uint8_t>(data.point_data, "flag", {0, 1, 50, 100, 200, 255});
  expect_array<std::int32_t>(data.point_data, "signed", {-128, -1, 0, 1, 2, 127});
  expect_array<std::int32_t>(data.point_data, "short", {0, 1, 2, 3, 4, 65535});
  expect_array<std::int32_t>(data.point_data, "int", {-2147483647 - 1, 1, 2, 3, 4, 2147483647});
  expect_array<std::int64_t>(data.point_data, "uint", {0, 1, 2, 3, 4, 4294967295});
  expect_array<std::int64_t>(data.point_data, "long", {-(std::int64_t{1} << 62), 1, 2, 3, 4, std::int64_t{1} << 62});
  expect_array<std::int64_t>(data.point_data, "id", {0, 1, 2, 3, 4, 5});
  if (!ascii) expect_array<double>(data.point_data, "radius", {0.1, 0.2, 1.0 / 3, 1e-300, 5, 6});
  std::vector<float> vector;
  for (int i = 0; i < 18; ++i) vector.push_back(0.5f * static_cast<float>(i));
  expect_array<float>(data.point_data, "vector", vector);
  EXPECT_EQ(find_array(data.point_data, "vector")->components, 3);
  expect_array<std::string>(data.field_data, "words", {"alpha", "", "beta <&> \xC3\xA4"});
  expect_array<std::int32_t>(data.field_data, "sites", {1, 2, 3, 4, 5, 6});
}

TEST(Vtk, FilesOfEveryEncodingAreRead) {
  REQUIRE_VTK();
  const Folder folder;
  int status = 0;
  const std::string output = run_vtk("write '" + (folder / "").string() + "'", status);
  ASSERT_EQ(status, 0) << output;
  for (const char* mode : {"ascii", "binary", "appended_raw", "appended_base64"})
    for (int compressed : {0, 1})
      for (int wide : {0, 1}) {
        const std::string name = fmt::format("{}_{}_{}.vtp", mode, compressed, wide);
        SCOPED_TRACE(name);
        expect_vtk_sample(io::read_record(folder / name), std::string(mode) == "ascii");
      }
  const Record pieces = io::read_record(folder / "pieces.vtp");
  pieces.validate();
  // The plane does not divide itself: VTK writes it whole as each of the two pieces.
  EXPECT_EQ(pieces.points.size(), 24u);
  EXPECT_EQ(pieces.poly_count(), 12u);
  try {
    io::read_record(folder / "big_endian.vtp");
    ADD_FAILURE() << "big endian was read";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("byte order"), std::string::npos) << error.what();
  }
}

}  // namespace io_vtk_test
}  // namespace quench
