// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <algorithm>
#include <utility>

#include "base/parallel.h"
#include "parts/cut_sheets.h"
#include "parts/slits.h"
#include "parts/triangulation.h"
#include "quench/error.h"
#include "quench/parts.h"

namespace quench {

namespace {

// One way round all sheets that can be, and along the normals of their planes.
void turn_sheets(SheetMesh& mesh, const Parts& parts) {
  const std::vector<parts::TriangleSide> sides = parts::sorted_sides(mesh.triangles);
  const parts::CutSheets cut = parts::cut_sheets(mesh.triangles, sides);
  std::vector<double> along(parts.sheets.size(), 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    auto& [a, b, c] = mesh.triangles[t];
    if (cut.turned[t]) std::swap(b, c);
    const auto s = static_cast<std::size_t>(mesh.sheet[t]);
    const Vec3 area = (mesh.points[b] - mesh.points[a]).cross(mesh.points[c] - mesh.points[a]);
    along[s] += parts.sheets[s].normal.dot(area);
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (along[static_cast<std::size_t>(mesh.sheet[t])] < 0) std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
}

}  // namespace

SheetMesh sheet_mesh(const CellComplex& complex, std::span<const Vec3> points, std::span<const double> radius,
                     std::span<const double> erosion, const Parts& parts, Context* context) {
  if (points.size() != complex.vertex_count || radius.size() != complex.vertex_count ||
      (!erosion.empty() && erosion.size() != complex.vertex_count))
    throw Error(ErrorCode::usage, "the sheets of a complex need a point and a radius for each of its vertices");
  if (parts.structure.face_sheet.size() != complex.face_count() ||
      parts.structure.edge_seam.size() != complex.edges.size())
    throw Error(ErrorCode::usage, "the parts are not those of this complex");
  return base::in_arena(context, [&] {
    const parts::Triangulation triangles = parts::triangulated(complex, points);
    checkpoint(context, "sheets", 0.4);
    SheetMesh mesh;
    std::vector<std::uint32_t> row(complex.vertex_count + triangles.middle_of.size(), kNone);
    for (const auto& corners : triangles.triangles)
      for (const std::uint32_t v : corners) row[v] = 0;
    const auto add = [&](std::uint32_t v, const Vec3& point, double r, double e) {
      row[v] = static_cast<std::uint32_t>(mesh.points.size());
      mesh.points.push_back(point);
      mesh.radius.push_back(r);
      if (!erosion.empty()) mesh.erosion.push_back(e);
    };
    for (std::uint32_t v = 0; v < complex.vertex_count; ++v)
      if (row[v] != kNone) add(v, points[v], radius[v], erosion.empty() ? 0 : erosion[v]);
    for (std::uint32_t i = 0; i < triangles.middle_of.size(); ++i) {
      const auto corners = complex.corners(triangles.middle_of[i]);
      const double part = 1 / static_cast<double>(corners.size());
      Vec3 point = Vec3::Zero();
      double r = 0, e = 0;
      for (const std::uint32_t v : corners) {
        point += part * points[v];
        r += part * radius[v];
        if (!erosion.empty()) e += part * erosion[v];
      }
      add(complex.vertex_count + i, point, r, e);
    }
    for (std::size_t t = 0; t < triangles.triangles.size(); ++t) {
      const auto& [a, b, c] = triangles.triangles[t];
      mesh.triangles.push_back({row[a], row[b], row[c]});
      mesh.sheet.push_back(parts.structure.face_sheet[triangles.face[t]]);
    }
    std::vector<char> has_face(complex.edges.size(), 0), fixed(complex.vertex_count, 0);
    for (const std::uint32_t e : complex.face_edges) has_face[e] = 1;
    for (std::size_t e = 0; e < complex.edges.size(); ++e) {
      const auto& [a, b] = complex.edges[e];
      if (!has_face[e]) fixed[a] = fixed[b] = 1;
      if (parts.structure.edge_seam[e] < 0) continue;
      mesh.seam_edges.push_back({row[a], row[b]});
      mesh.seam.push_back(parts.structure.edge_seam[e]);
    }
    for (std::uint32_t v = 0; v < complex.vertex_count; ++v)
      if (row[v] != kNone && (fixed[v] || parts.structure.junction[v])) mesh.fixed.push_back(row[v]);
    turn_sheets(mesh, parts);
    parts::halve_slits(mesh);
    checkpoint(context, "sheets", 1);
    return mesh;
  });
}

SheetMesh sheet_mesh(const Skeleton& skeleton, const Parts& parts, Context* context) {
  std::vector<double> erosion(skeleton.points.size());
  for (std::size_t v = 0; v < erosion.size(); ++v)
    erosion[v] = std::max(0.0, skeleton.burn_time[v] - skeleton.radius[v]);
  return sheet_mesh(skeleton.complex, skeleton.points, skeleton.radius, erosion, parts, context);
}

}  // namespace quench
