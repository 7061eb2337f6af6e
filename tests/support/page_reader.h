// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>
#include <zlib.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "page_unpack.h"

/// Reads a page as a browser does.
namespace quench::testing_page {

inline std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

struct Contents {
  nlohmann::json meta;
  Arrays arrays;

  bool has(const std::string& name) const { return arrays.contains(name); }
  const std::vector<double>& operator[](const std::string& name) const {
    static const std::vector<double> none;
    const auto found = arrays.find(name);
    EXPECT_TRUE(found != arrays.end()) << name;
    return found == arrays.end() ? none : found->second;
  }
};

/// What is between the tags of the script element with this id; nothing may look like its end before its end.
inline std::string element(const std::string& html, const std::string& id) {
  const std::size_t at = html.find("id=\"" + id + "\"");
  EXPECT_NE(at, std::string::npos) << id;
  if (at == std::string::npos) return {};
  const std::size_t begin = html.find('>', at) + 1;
  return html.substr(begin, html.find("</script", begin) - begin);
}

inline std::string from_base64(const std::string& text) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  EXPECT_EQ(text.size() % 4, 0u);
  for (std::size_t i = 0; i + 4 <= text.size(); i += 4) {
    std::uint32_t word = 0, padding = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t digit = digits.find(text[i + k]);
      padding += text[i + k] == '=';
      EXPECT_TRUE(digit != std::string::npos || text[i + k] == '=');
      word = word << 6 | (digit == std::string::npos ? 0 : static_cast<std::uint32_t>(digit));
    }
    for (std::uint32_t k = 0; k + padding < 3; ++k) bytes += static_cast<char>(word >> (16 - 8 * k) & 0xFF);
  }
  return bytes;
}

/// One gzip member and nothing behind it: more is an error for browsers.
inline std::string unzipped(const std::string& bytes) {
  z_stream stream{};
  EXPECT_EQ(inflateInit2(&stream, 16 + 15), Z_OK);
  std::string in = bytes, out;
  std::vector<char> block(1 << 16);
  stream.next_in = reinterpret_cast<Bytef*>(in.data());
  stream.avail_in = static_cast<uInt>(in.size());
  int result = Z_OK;
  while (result == Z_OK) {
    stream.next_out = reinterpret_cast<Bytef*>(block.data());
    stream.avail_out = static_cast<uInt>(block.size());
    result = inflate(&stream, Z_NO_FLUSH);
    out.append(block.data(), block.size() - stream.avail_out);
  }
  EXPECT_EQ(result, Z_STREAM_END);
  EXPECT_EQ(stream.avail_in, 0u);
  inflateEnd(&stream);
  return out;
}

template <class T>
std::vector<double> numbers(const std::string& bytes, std::size_t offset, std::size_t count) {
  std::vector<T> values(count);
  if (count > 0) std::memcpy(values.data(), bytes.data() + offset, count * sizeof(T));
  return {values.begin(), values.end()};
}

inline Contents read_page(const std::string& html) {
  Contents contents;
  contents.meta = nlohmann::json::parse(element(html, "quench-meta"));
  const std::string bytes = unzipped(from_base64(element(html, "quench-data")));
  std::size_t end = 0;
  std::vector<nlohmann::json> later;  // of others
  for (const auto& array : contents.meta["arrays"]) {
    const std::size_t offset = array["offset"].get<std::size_t>(),
                      count = array["count"].get<std::size_t>() * array["components"].get<std::size_t>();
    const std::string type = array["type"];
    EXPECT_EQ(offset % 4, 0u);
    EXPECT_EQ(offset, end) << "a gap";
    const std::size_t width = type == "u8" ? 1 : type == "u16" ? 2 : 4;
    end = offset + (count * (array.contains("code") ? array["planes"].get<std::size_t>() : width) + 3) / 4 * 4;
    EXPECT_LE(end, bytes.size());
    if (end > bytes.size()) break;
    if (array.contains("code")) {
      if (array["code"] == "difference" || array["code"] == "again")
        later.push_back(array);
      else
        contents.arrays[array["name"]] = decoded(array, bytes.substr(offset), contents.arrays);
      continue;
    }
    contents.arrays[array["name"]] = type == "f32"   ? numbers<float>(bytes, offset, count)
                                     : type == "u32" ? numbers<std::uint32_t>(bytes, offset, count)
                                     : type == "u16" ? numbers<std::uint16_t>(bytes, offset, count)
                                                     : numbers<std::uint8_t>(bytes, offset, count);
  }
  EXPECT_EQ(end, bytes.size());
  for (const auto& array : later)
    contents.arrays[array["name"]] = decoded(array, bytes.substr(array["offset"].get<std::size_t>()), contents.arrays);
  std::vector<std::string> measures;
  for (std::size_t m = 1; contents.meta.contains("measures") && m < contents.meta["measures"].size(); ++m)
    measures.push_back(contents.meta["measures"][m]["name"]);
  for (const char* layer : {"family", "core", "still"})
    complete(layer, std::string(layer) == "core" ? measures : std::vector<std::string>(), contents.arrays);
  return contents;
}

}  // namespace quench::testing_page
