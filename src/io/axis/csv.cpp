// SPDX-License-Identifier: Apache-2.0
#include <type_traits>

#include "io/common/formats.h"
#include "io/common/text_out.h"

/// One row per vertex: x, y, z and every point array, in the file's order; a header names the columns.
namespace quench::io {
namespace {

/// A name as a field: quoted where it must be (RFC 4180).
std::string field(const std::string& name) {
  if (name.find_first_of(",\"\r\n") == std::string::npos) return name;
  std::string quoted = "\"";
  for (char c : name) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

}  // namespace

void write_csv(std::ostream& out, const Record& data) {
  TextOut text(out);
  text.print("x,y,z");
  for (const DataArray& array : data.point_data)
    for (int c = 0; c < array.components; ++c)
      text.print(",{}", field(array.components == 1 ? array.name : fmt::format("{}_{}", array.name, c)));
  text.print("\n");
  for (std::size_t v = 0; v < data.points.size(); ++v) {
    text.print("{},{},{}", data.points[v][0], data.points[v][1], data.points[v][2]);
    for (const DataArray& array : data.point_data)
      std::visit(
          [&](const auto& values) {
            const std::size_t components = static_cast<std::size_t>(array.components);
            for (std::size_t c = 0; c < components; ++c) {
              if constexpr (std::is_same_v<std::decay_t<decltype(values)>, std::vector<std::string>>)
                text.print(",{}", field(values[v * components + c]));
              else
                text.print(",{}", values[v * components + c]);
            }
          },
          array.values);
    text.print("\n");
  }
  text.flush();
}

}  // namespace quench::io
