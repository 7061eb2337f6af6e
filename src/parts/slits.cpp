// SPDX-License-Identifier: Apache-2.0
#include "parts/slits.h"

#include <algorithm>
#include <map>

#include "parts/cut_sheets.h"

namespace quench::parts {

void halve_slits(SheetMesh& mesh) {
  const std::vector<TriangleSide> sides = sorted_sides(mesh.triangles);
  const CutSheets cut = cut_sheets(mesh.triangles, sides);
  std::vector<std::array<std::uint32_t, 2>> slits;
  std::vector<std::array<std::uint32_t, 2>> ends;
  each_edge(sides, [&](std::span<const TriangleSide> at) {
    if (at.size() < 3) return;
    ends.clear();
    for (const TriangleSide& side : at) {
      const std::uint32_t a = cut.vertex[3 * side.triangle + side.side],
                          b = cut.vertex[3 * side.triangle + (side.side + 1) % 3];
      ends.push_back({std::min(a, b), std::max(a, b)});
    }
    std::ranges::sort(ends);
    if (std::ranges::adjacent_find(ends) != ends.end()) slits.push_back({at[0].a, at[0].b});
  });
  if (slits.empty()) return;
  std::map<std::array<std::uint32_t, 2>, std::uint32_t> middle;
  for (const auto& [a, b] : slits) {
    middle[{a, b}] = static_cast<std::uint32_t>(mesh.points.size());
    mesh.points.push_back(0.5 * (mesh.points[a] + mesh.points[b]));
    mesh.radius.push_back(0.5 * (mesh.radius[a] + mesh.radius[b]));
    if (!mesh.erosion.empty()) mesh.erosion.push_back(0.5 * (mesh.erosion[a] + mesh.erosion[b]));
  }
  const auto middle_of = [&](std::uint32_t a, std::uint32_t b) {
    const auto found = middle.find({std::min(a, b), std::max(a, b)});
    return found == middle.end() ? kNone : found->second;
  };
  // What is halved off a triangle is looked at again: another of its sides may be one.
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t i = 0; i < 3; ++i) {
      auto& corners = mesh.triangles[t];
      const std::uint32_t m = middle_of(corners[i], corners[(i + 1) % 3]);
      if (m == kNone) continue;
      std::array<std::uint32_t, 3> other = corners;
      other[i] = m;
      corners[(i + 1) % 3] = m;
      mesh.triangles.push_back(other);
      mesh.sheet.push_back(mesh.sheet[t]);
      i = std::size_t(-1);
    }
  for (std::size_t e = 0; e < mesh.seam_edges.size(); ++e) {
    auto& [a, b] = mesh.seam_edges[e];
    const std::uint32_t m = middle_of(a, b);
    if (m == kNone) continue;
    mesh.seam_edges.push_back({m, b});
    mesh.seam.push_back(mesh.seam[e]);
    mesh.seam_edges[e][1] = m;
  }
}

}  // namespace quench::parts
