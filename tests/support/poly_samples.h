// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>

#include "quench/error.h"
#include "quench/io.h"
#include "quench/record.h"

/// Small Record and files for the tests of readers and writers.
namespace quench::testing_files {

/// A folder of the test, removed with everything in it.
class Folder {
 public:
  Folder() {
    static int count = 0;
    path_ = std::filesystem::temp_directory_path() /
            ("quench_test_" + std::to_string(::getpid()) + "_" + std::to_string(count++));
    std::filesystem::create_directories(path_);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  std::size_t entries() const {
    return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(path_), {}));
  }

 private:
  std::filesystem::path path_;
};

inline void write_bytes(const std::filesystem::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary) << bytes;
}

inline std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// What read_record makes of a file of that name and content.
inline Record read_bytes(const std::string& name, const std::string& bytes) {
  const Folder folder;
  write_bytes(folder / name, bytes);
  Record data = io::read_record(folder / name);
  data.validate();
  return data;
}

/// The sentence read_record refuses a file with; fails the test when it does not, or not as an input error.
inline std::string refusal(const std::string& name, const std::string& bytes) {
  try {
    read_bytes(name, bytes);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::input) << error.what();
    EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << "names no file: " << error.what();
    return error.what();
  }
  ADD_FAILURE() << name << " was read: " << bytes;
  return {};
}

/// The code of the Error that an action must throw.
inline ErrorCode code_of(const std::function<void()>& action, std::string* sentence = nullptr) {
  try {
    action();
  } catch (const Error& error) {
    if (sentence) *sentence = error.what();
    return error.code();
  }
  ADD_FAILURE() << "nothing was thrown";
  return ErrorCode::failed;
}

/// The values of an array that must have that type.
template <class T>
std::vector<T> values_of(const std::vector<DataArray>& arrays, const char* name) {
  const DataArray* array = find_array(arrays, name);
  if (!array || !std::holds_alternative<std::vector<T>>(array->values)) {
    ADD_FAILURE() << "no array " << name << " of that type";
    return {};
  }
  return std::get<std::vector<T>>(array->values);
}

/// Points, lines and polygons of 3 to 7 corners with arrays of every type, and field data with strings.
inline Record mixed_sample() {
  Record data;
  for (int i = 0; i < 12; ++i) data.points.emplace_back(i / 3.0, -1e-9 * i, i % 2 ? 1e300 : -0.1 * i);
  data.verts = {11, 0};
  data.lines = {{0, 1}, {10, 11}, {3, 2}};
  for (std::uint32_t corners = 3; corners <= 7; ++corners) {
    for (std::uint32_t c = 0; c < corners; ++c) data.poly_corners.push_back((c + corners) % 12);
    data.poly_offsets.push_back(static_cast<std::uint32_t>(data.poly_corners.size()));
  }
  std::vector<double> radius, vector;
  std::vector<float> burn_time;
  std::vector<std::int64_t> identity;
  std::vector<std::int32_t> component;
  std::vector<std::uint8_t> flag;
  for (int i = 0; i < 12; ++i) {
    radius.push_back(0.1 + i / 7.0);
    burn_time.push_back(static_cast<float>(i) / 9.0f);
    identity.push_back(std::int64_t{1} << (5 * i));
    component.push_back(-i);
    flag.push_back(static_cast<std::uint8_t>(20 * i));
    for (int c = 0; c < 3; ++c) vector.push_back(i + 0.01 * c);
  }
  data.point_data = {{"radius", 1, radius},       {"burn_time", 1, burn_time}, {"identity", 1, identity},
                     {"component", 1, component}, {"flag", 1, flag},           {"a <name> & \"more\"", 3, vector}};
  std::vector<float> level;
  std::vector<std::int32_t> sites;
  for (int i = 0; i < 10; ++i) {
    level.push_back(i == 4 ? 3.4e38f : static_cast<float>(i));
    sites.insert(sites.end(), {i, 2 * i, -3 * i});
  }
  data.cell_data = {{"lambda_level", 1, level}, {"sites_of_cell", 3, sites}};
  data.field_data = {{"sites", 3, std::vector<std::int32_t>{1, 2, 3, 4, 5, 6}},
                     {"units", 1, std::vector<std::string>{"mm"}},
                     {"notes", 1, std::vector<std::string>{"first", "", "third: \xC3\xA4 <&>"}},
                     {"lambda", 1, std::vector<double>{0.1}},
                     {"nothing", 1, std::vector<double>{}}};
  return data;
}

inline void expect_same_arrays(const std::vector<DataArray>& a, const std::vector<DataArray>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].name, b[i].name);
    EXPECT_EQ(a[i].components, b[i].components) << a[i].name;
    EXPECT_EQ(a[i].values, b[i].values) << a[i].name;
  }
}

inline void expect_same_cells(const Record& a, const Record& b) {
  EXPECT_EQ(a.points, b.points);
  EXPECT_EQ(a.lines, b.lines);
  EXPECT_EQ(a.poly_offsets, b.poly_offsets);
  EXPECT_EQ(a.poly_corners, b.poly_corners);
}

inline void expect_same(const Record& a, const Record& b) {
  expect_same_cells(a, b);
  EXPECT_EQ(a.verts, b.verts);
  expect_same_arrays(a.point_data, b.point_data);
  expect_same_arrays(a.cell_data, b.cell_data);
  expect_same_arrays(a.field_data, b.field_data);
}

}  // namespace quench::testing_files
