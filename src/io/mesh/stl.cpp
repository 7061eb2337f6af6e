// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <ostream>

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

namespace {

void put_floats(std::string& bytes, const Vec3& v) {
  for (int k = 0; k < 3; ++k) {
    const float number = to_float(v[k]);
    bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
  }
}

}  // namespace

/// Binary, polygons as fans of triangles. The header does not begin with "solid".
void write_stl(std::ostream& out, const Record& data) {
  const TriangleMesh mesh = to_triangle_mesh(data);
  if (mesh.triangles.size() > std::numeric_limits<std::uint32_t>::max())
    throw Error(ErrorCode::failed, "an STL file has room for 4,294,967,295 triangles; write a .ply or .vtp file");
  std::string bytes = fmt::format("Quench {}", QUENCH_VERSION);
  bytes.resize(80, ' ');
  const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
  bytes.append(reinterpret_cast<const char*>(&count), sizeof count);
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3 &p = mesh.points[a], &q = mesh.points[b], &r = mesh.points[c], across = (q - p).cross(r - p);
    const double size = across.norm();
    put_floats(bytes, size > 0 ? Vec3(across / size) : Vec3(Vec3::Zero()));
    for (const Vec3* corner : {&p, &q, &r}) put_floats(bytes, *corner);
    bytes.append(2, '\0');
    if (bytes.size() > (std::size_t{1} << 20)) {
      out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
      bytes.clear();
    }
  }
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

Record read_stl(const FileText& file) { return is_binary(file.bytes) ? read_binary(file) : read_text(file); }

}  // namespace quench::io
