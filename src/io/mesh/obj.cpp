// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "io/common/formats.h"
#include "io/common/text_out.h"
#include "io/common/words.h"

/// Wavefront OBJ: v, f, l and p; everything else (normals, texture, groups, materials, free-form surfaces) is ignored.
namespace quench::io {
namespace {

/// The vertices an f, l or p line names. A reference is `v`, `v/vt`, `v//vn` or `v/vt/vn`; it counts from 1, or
/// backwards from the latest vertex where negative. Vertices may come later in the file, so the upper end of the range
/// is checked when all are known.
class References {
 public:
  void read(Words& words, std::size_t vertices) {
    corners.clear();
    for (std::string_view word = words.next_on_line(); !word.empty(); word = words.next_on_line()) {
      std::int64_t index = 0;
      if (!parse_integer(word.substr(0, word.find('/')), index)) words.fail("a corner is not a vertex number");
      if (index < 0) index += static_cast<std::int64_t>(vertices) + 1;
      if (index < 1 || index > 0xFFFFFFFE)
        words.fail(fmt::format("a corner refers to vertex {} (the first is 1)", index));
      if (index > largest_) {
        largest_ = index;
        largest_line_ = words.line();
      }
      corners.push_back(static_cast<std::uint32_t>(index - 1));
    }
    if (corners.empty()) words.fail("a face, line or point has no corners");
  }

  void check_range(std::size_t vertices, const std::string& file) const {
    if (static_cast<std::size_t>(largest_) > vertices)
      throw Error(ErrorCode::input, fmt::format("'{}', line {}: a corner refers to vertex {} of {}", file,
                                                largest_line_, largest_, vertices));
  }

  std::vector<std::uint32_t> corners;

 private:
  std::int64_t largest_ = 0;
  std::size_t largest_line_ = 0;
};

}  // namespace

Record read_obj(const FileText& file) {
  Record data;
  References references;
  Words words(file.bytes, file.name, {.comment = '#', .continuation = true});
  while (words.next_line()) {
    const std::string_view keyword = words.next_on_line();
    if (keyword == "v") {
      const double x = words.coordinate_on_line("x"), y = words.coordinate_on_line("y"),
                   z = words.coordinate_on_line("z");
      data.points.emplace_back(x, y, z);
    } else if (keyword == "f") {
      references.read(words, data.points.size());
      add_cell(data, references.corners, file.name);
    } else if (keyword == "l") {
      references.read(words, data.points.size());
      const auto& corners = references.corners;
      if (corners.size() < 2) words.fail("a line has one end only");
      for (std::size_t c = 1; c < corners.size(); ++c) data.lines.push_back({corners[c - 1], corners[c]});
    } else if (keyword == "p") {
      references.read(words, data.points.size());
      data.verts.insert(data.verts.end(), references.corners.begin(), references.corners.end());
    }
  }
  references.check_range(data.points.size(), file.name);
  if (data.points.empty()) throw Error(ErrorCode::input, fmt::format("'{}' has no vertices", file.name));
  return data;
}

namespace {

/// Of a file of parts: the sheet of every cell. Its polygons come sheet by sheet.
const std::vector<std::int32_t>* sheets_of_parts(const Record& data) {
  const DataArray* stage = find_array(data.field_data, "stage");
  const auto* text = stage ? std::get_if<std::vector<std::string>>(&stage->values) : nullptr;
  if (!text || text->size() != 1 || text->front() != "parts") return nullptr;
  const DataArray* array = find_array(data.cell_data, "sheet");
  const auto* sheet = array ? std::get_if<std::vector<std::int32_t>>(&array->values) : nullptr;
  return sheet && sheet->size() == data.cell_count() ? sheet : nullptr;
}

}  // namespace

/// The polygons of each sheet of parts are a group.
void write_obj(std::ostream& out, const Record& data) {
  TextOut text(out);
  text.print("# Quench {}: {} vertices, {} points, {} lines, {} faces\n", QUENCH_VERSION, data.points.size(),
             data.verts.size(), data.lines.size(), data.poly_count());
  if (const std::string space = space_comment(data); !space.empty()) text.print("# {}\n", space);
  for (const Vec3& p : data.points) text.print("v {} {} {}\n", p[0], p[1], p[2]);
  for (std::uint64_t v : data.verts) text.print("p {}\n", v + 1);
  for (const auto& line : data.lines) text.print("l {} {}\n", std::uint64_t{line[0]} + 1, std::uint64_t{line[1]} + 1);
  const auto* sheet = sheets_of_parts(data);
  const std::size_t first = data.verts.size() + data.lines.size();
  for (std::size_t f = 0; f < data.poly_count(); ++f) {
    if (sheet && (f == 0 || (*sheet)[first + f] != (*sheet)[first + f - 1]))
      text.print("g sheet_{}\n", (*sheet)[first + f]);
    text.print("f");
    for (std::size_t c = data.poly_offsets[f]; c < data.poly_offsets[f + 1]; ++c)
      text.print(" {}", std::uint64_t{data.poly_corners[c]} + 1);
    text.print("\n");
  }
  text.flush();
}

}  // namespace quench::io
