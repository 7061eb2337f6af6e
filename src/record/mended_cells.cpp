// SPDX-License-Identifier: Apache-2.0
#include "record/mended_cells.h"

#include <algorithm>

namespace quench::record {

MendedCells mended_cells(const Record& data) {
  MendedCells cells;
  for (const auto& line : data.lines)
    if (line[0] != line[1])
      cells.lines.push_back(line);
    else
      ++cells.degenerate;
  std::vector<std::uint32_t> own, distinct;
  for (std::size_t p = 0; p < data.poly_count(); ++p) {
    own.assign(data.poly_corners.begin() + data.poly_offsets[p], data.poly_corners.begin() + data.poly_offsets[p + 1]);
    const std::size_t given = own.size();
    own.erase(std::unique(own.begin(), own.end()), own.end());
    while (own.size() > 1 && own.front() == own.back()) own.pop_back();
    distinct = own;
    std::sort(distinct.begin(), distinct.end());
    const bool returns = std::adjacent_find(distinct.begin(), distinct.end()) != distinct.end();
    if (own.size() != given || own.size() < 3 || returns) ++cells.degenerate;
    if (own.size() >= 3 && !returns) {
      cells.corners.insert(cells.corners.end(), own.begin(), own.end());
      cells.offsets.push_back(static_cast<std::uint32_t>(cells.corners.size()));
    } else {
      for (std::size_t i = 0; i < own.size(); ++i)
        if (const std::uint32_t a = own[i], b = own[(i + 1) % own.size()]; a != b) cells.lines.push_back({a, b});
    }
  }
  return cells;
}

}  // namespace quench::record
