// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "base/text.h"
#include "io/common/formats.h"
#include "io/common/words.h"

/// Geomview's OFF: an optional keyword [ST][C][N]OFF, the counts of vertices, faces and edges, one line per vertex (x y
/// z and, as the keyword says, more) and per face (number of corners, corners, perhaps a colour).
namespace quench::io {
namespace {

/// Reads the keyword and the number of vertices, which may follow it on the same line.
std::int64_t read_vertex_count(Words& words) {
  std::string_view keyword = words.next();
  std::int64_t count = 0;
  if (parse_integer(keyword, count)) return count;
  if (keyword.starts_with("ST")) keyword.remove_prefix(2);
  if (keyword.starts_with("C")) keyword.remove_prefix(1);
  if (keyword.starts_with("N")) keyword.remove_prefix(1);
  if (keyword == "4OFF" || keyword == "nOFF" || keyword == "4nOFF")
    words.fail(fmt::format("{} files have points that are not three-dimensional", keyword));
  if (keyword != "OFF") words.fail("an OFF file begins with 'OFF'");
  const std::string_view next = words.next();
  if (next == "BINARY") words.fail("binary OFF files are not supported; convert it to PLY");
  if (!parse_integer(next, count)) words.fail("the number of vertices is missing");
  return count;
}

}  // namespace

Record read_off(const FileText& file) {
  Words words(file.bytes, file.name);
  const std::int64_t vertices = read_vertex_count(words);
  const std::int64_t faces = words.integer("the number of faces");
  if (vertices < 0 || faces < 0) words.fail("a count is negative");
  // A vertex takes 6 bytes of text and a face 4, perhaps without the last line end.
  if (static_cast<std::size_t>(vertices) > words.remaining() / 5 ||
      static_cast<std::size_t>(faces) > words.remaining() / 3)
    words.fail(fmt::format("{} and {} are declared, more than the file can hold; it is damaged or incomplete",
                           base::counted(vertices, "vertex", "vertices"), base::counted(faces, "face")));

  Record data;
  data.points.reserve(static_cast<std::size_t>(vertices));
  for (std::int64_t v = 0; v < vertices; ++v) {
    if (!words.next_line()) words.fail(fmt::format("the file ends after {} of {} vertices", v, vertices));
    const double x = words.coordinate_on_line("x"), y = words.coordinate_on_line("y"),
                 z = words.coordinate_on_line("z");
    data.points.emplace_back(x, y, z);
  }
  std::vector<std::uint32_t> corners;
  for (std::int64_t f = 0; f < faces; ++f) {
    if (!words.next_line()) words.fail(fmt::format("the file ends after {} of {} faces", f, faces));
    const std::int64_t size = words.integer_on_line("the number of corners");
    if (size < 1) words.fail(fmt::format("a face has {} corners", size));
    corners.clear();
    for (std::int64_t c = 0; c < size; ++c) {
      const std::int64_t corner = words.integer_on_line("a corner");
      if (corner < 0 || corner >= vertices)
        words.fail(fmt::format("a face refers to vertex {} of {} (the first is 0)", corner, vertices));
      corners.push_back(static_cast<std::uint32_t>(corner));
    }
    add_cell(data, corners, file.name);
  }
  return data;
}

}  // namespace quench::io
