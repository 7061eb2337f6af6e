// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "quench/error.h"
#include "quench/io.h"
#include "temporary_folder.h"
#include "tiff_bytes.h"

namespace quench::testing_tiff {

using Dims = std::array<std::int64_t, 3>;

/// Reads a file of bytes, or sees how it is refused.
class Tiff : public testing::Test {
 protected:
  Volume read(const std::string& bytes) {
    notes.clear();
    Context context;
    context.note = [this](const std::string& sentence) { notes += sentence + "\n"; };
    std::filesystem::remove(folder / "t.tif");  // much faster than to write over it
    return io::read_volume(folder.write("t.tif", bytes), {}, &context);
  }
  template <class T>
  std::vector<T> samples(const std::string& bytes) {
    return std::get<std::vector<T>>(read(bytes).samples);
  }
  /// The sentence, which has `part` and the name of the file.
  std::string refused(const std::string& bytes, const std::string& part) {
    try {
      read(bytes);
      ADD_FAILURE() << "was read; expected: " << part;
      return {};
    } catch (const Error& e) {
      const std::string what = e.what();
      EXPECT_EQ(e.code(), ErrorCode::input) << what;
      EXPECT_NE(what.find(part), std::string::npos) << what;
      EXPECT_NE(what.find("t.tif"), std::string::npos) << what;
      for (const char c : what) EXPECT_TRUE(c >= ' ' && c <= '~') << what;
      return what;
    }
  }
  /// Whether reading ends in a volume or in a sentence.
  std::optional<Volume> read_or_refuse(const std::string& bytes) {
    try {
      return read(bytes);
    } catch (const Error& e) {
      EXPECT_TRUE(e.code() == ErrorCode::input || e.code() == ErrorCode::failed) << e.what();
      EXPECT_NE(std::string(e.what()).find("t.tif"), std::string::npos) << e.what();
      return {};
    }
  }

  const TemporaryFolder folder;
  std::string notes;
};

/// The bytes of values in one byte order.
template <class T>
inline std::string bytes_of(const std::vector<T>& values, bool big_endian) {
  std::string bytes;
  for (const T value : values) {
    std::string one(sizeof(T), '\0');
    std::memcpy(one.data(), &value, sizeof(T));
    if (big_endian) std::reverse(one.begin(), one.end());
    bytes += one;
  }
  return bytes;
}

}  // namespace quench::testing_tiff
