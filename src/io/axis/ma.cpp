// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <iterator>
#include <vector>

#include "io/common/formats.h"
#include "io/common/text_out.h"
#include "io/common/words.h"

/// Medial axes as text: the counts `nV nE nF`, then `v x y z r`, `e i j` and `f i j k` with vertices counted from
/// 0. Written are triangles, and all edges, also the sides of triangles, in this order: Q-MAT looks up the sides of a
/// triangle among the edges that were read before, and takes no polygons; the add-on for Blender takes both. Polygons
/// of any size, and without their sides, are read, too.
namespace quench::io {

Record read_ma(const FileText& file) {
  Words words(file.bytes, file.name);
  const std::int64_t vertices = words.integer("the number of vertices");
  const std::int64_t edges = words.integer_on_line("the number of edges");
  const std::int64_t faces = words.integer_on_line("the number of faces");
  if (vertices < 0 || edges < 0 || faces < 0) words.fail("a number of vertices, edges or faces is negative");
  Record data;
  std::vector<double> radii;
  std::vector<std::uint32_t> corners;
  std::int64_t found_edges = 0, found_faces = 0;
  while (words.next_line()) {
    const std::string_view keyword = words.next_on_line();
    if (keyword == "v") {
      const double x = words.coordinate_on_line("x"), y = words.coordinate_on_line("y"),
                   z = words.coordinate_on_line("z"), r = words.coordinate_on_line("the radius");
      data.points.emplace_back(x, y, z);
      radii.push_back(r);
    } else if (keyword == "e" || keyword == "f") {
      const bool edge = keyword == "e";
      corners.clear();
      for (std::string_view word = words.next_on_line(); !word.empty(); word = words.next_on_line()) {
        std::int64_t index = 0;
        if (!parse_integer(word, index) || index < 0 || index >= vertices || index > 0xFFFFFFFE)
          words.fail(fmt::format("a corner is not a vertex number between 0 and {}", vertices - 1));
        corners.push_back(static_cast<std::uint32_t>(index));
      }
      if (edge ? corners.size() != 2 : corners.empty())
        words.fail(fmt::format("{} has {} corners", edge ? "an edge" : "a face", corners.size()));
      add_cell(data, corners, file.name);
      ++(edge ? found_edges : found_faces);
    } else {
      words.fail("a line does not begin with v, e or f");
    }
  }
  if (static_cast<std::size_t>(vertices) != data.points.size() || edges != found_edges || faces != found_faces)
    throw Error(ErrorCode::input,
                fmt::format("'{}' declares {} vertices, {} edges and {} faces, but has {}, {} and {}", file.name,
                            vertices, edges, faces, data.points.size(), found_edges, found_faces));
  data.point_data.push_back({"radius", 1, std::move(radii)});
  add_isolated_points(data);
  return data;
}

namespace {

/// Triangles of all polygons, as fans, and all edges: those of the file, then sides of triangles.
struct Simplices {
  std::vector<std::array<std::uint32_t, 2>> edges;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

Simplices simplices_of(const Record& data) {
  Simplices simplices;
  simplices.edges.assign(data.lines.begin(), data.lines.end());
  std::vector<std::array<std::uint32_t, 2>> sides;
  const auto ends = [](std::uint32_t a, std::uint32_t b) { return std::array{std::min(a, b), std::max(a, b)}; };
  for (std::size_t f = 0; f < data.poly_count(); ++f)
    for (std::size_t c = data.poly_offsets[f] + 2; c < data.poly_offsets[f + 1]; ++c) {
      const std::uint32_t i = data.poly_corners[data.poly_offsets[f]], j = data.poly_corners[c - 1],
                          k = data.poly_corners[c];
      simplices.triangles.push_back({i, j, k});
      for (const auto& side : {ends(i, j), ends(j, k), ends(k, i)}) sides.push_back(side);
    }
  std::vector<std::array<std::uint32_t, 2>> known;
  for (const auto& line : data.lines) known.push_back(ends(line[0], line[1]));
  std::ranges::sort(known);
  std::ranges::sort(sides);
  sides.erase(std::unique(sides.begin(), sides.end()), sides.end());
  std::ranges::set_difference(sides, known, std::back_inserter(simplices.edges));
  return simplices;
}

}  // namespace

void write_ma(std::ostream& out, const Record& data) {
  const std::vector<double> radii = required_radii(data, ".ma");
  const Simplices simplices = simplices_of(data);
  TextOut text(out);
  text.print("{} {} {}\n", data.points.size(), simplices.edges.size(), simplices.triangles.size());
  for (std::size_t v = 0; v < data.points.size(); ++v)
    text.print("v {} {} {} {}\n", data.points[v][0], data.points[v][1], data.points[v][2], radii[v]);
  for (const auto& [i, j] : simplices.edges) text.print("e {} {}\n", i, j);
  for (const auto& [i, j, k] : simplices.triangles) text.print("f {} {} {}\n", i, j, k);
  text.flush();
}

}  // namespace quench::io
