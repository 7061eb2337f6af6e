// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "io/common/formats.h"
#include "io/common/words.h"
#include "io/mesh/weld.h"

/// STL, text and binary. Triangles carry their own corners; equal positions become one vertex.
namespace quench::io {
namespace {

static_assert(std::endian::native == std::endian::little, "binary files are read in the byte order of the processor");

constexpr std::size_t kHeaderBytes = 84, kTriangleBytes = 50;

std::uint32_t triangle_count(const std::string& bytes) {
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + 80, 4);
  return count;
}

/// Binary files may begin with "solid" as well: the size decides first, then whether the beginning is text.
bool is_binary(const std::string& bytes) {
  if (bytes.size() >= kHeaderBytes && bytes.size() == kHeaderBytes + kTriangleBytes * triangle_count(bytes))
    return true;
  const std::string_view beginning = std::string_view(bytes).substr(0, 1024);
  if (beginning.find('\0') != std::string_view::npos) return true;
  const std::size_t word = beginning.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  const std::string_view keyword = beginning.substr(std::min(word, beginning.size()), 5);
  return keyword != "solid" && keyword != "SOLID" && keyword != "Solid";
}

Record read_binary(const FileText& file) {
  const auto fail = [&](const std::string& what) {
    throw Error(ErrorCode::input, fmt::format("'{}' {}", file.name, what));
  };
  if (file.bytes.size() < kHeaderBytes)
    fail(fmt::format("is not an STL file: it has {} bytes and does not begin with 'solid'", file.bytes.size()));
  const std::size_t triangles = triangle_count(file.bytes);
  if (triangles > (file.bytes.size() - kHeaderBytes) / kTriangleBytes)
    fail(fmt::format("is incomplete: it declares {} triangles and has {} bytes", triangles, file.bytes.size()));
  Record data;
  Weld weld;
  for (std::size_t t = 0; t < triangles; ++t) {
    const std::size_t start = kHeaderBytes + kTriangleBytes * t + 12;  // after the normal
    std::array<float, 9> numbers;
    std::memcpy(numbers.data(), file.bytes.data() + start, sizeof numbers);
    std::array<std::uint32_t, 3> corners;
    for (std::size_t c = 0; c < 3; ++c) {
      const Vec3 point(numbers[3 * c], numbers[3 * c + 1], numbers[3 * c + 2]);
      if (!point.allFinite()) fail(fmt::format("byte {}: a corner of triangle {} is not finite", start + 12 * c, t));
      corners[c] = weld(point, data.points);
    }
    add_cell(data, corners, file.name);
  }
  return data;
}

std::string lower(std::string_view word) {
  std::string result(word);
  for (char& c : result)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return result;
}

Record read_text(const FileText& file) {
  Record data;
  Weld weld;
  Words words(file.bytes, file.name, {.comment = '\0'});
  std::vector<std::uint32_t> corners;
  bool inside_solid = false, inside_loop = false;
  while (words.next_line()) {
    const std::string keyword = lower(words.next_on_line());
    if (keyword == "vertex" && inside_loop) {
      const double x = words.coordinate_on_line("x"), y = words.coordinate_on_line("y"),
                   z = words.coordinate_on_line("z");
      corners.push_back(weld(Vec3(x, y, z), data.points));
    } else if (keyword == "outer" && inside_solid && !inside_loop) {
      inside_loop = true;
      corners.clear();
    } else if (keyword == "endloop" && inside_loop) {
      if (corners.size() < 3) words.fail(fmt::format("a facet has {} corners", corners.size()));
      add_cell(data, corners, file.name);
      inside_loop = false;
    } else if (keyword == "solid" && !inside_solid) {
      inside_solid = true;
    } else if (keyword == "endsolid" && inside_solid && !inside_loop) {
      inside_solid = false;
    } else if ((keyword != "facet" && keyword != "endfacet") || !inside_solid || inside_loop) {
      words.fail("this is not expected here in a text STL file");
    }
  }
  if (inside_solid) words.fail("the file ends without 'endsolid': it is incomplete");
  return data;
}

}  // namespace

Record read_stl(const FileText& file) { return is_binary(file.bytes) ? read_binary(file) : read_text(file); }

}  // namespace quench::io
