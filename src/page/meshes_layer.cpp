// SPDX-License-Identifier: Apache-2.0
#include "page/layer.h"
#include "quench/error.h"
#include "quench/simplify.h"

namespace quench {

void add_meshes(Page& page, const CollapseSequence& sequence, const std::vector<PageMeshError>& errors) {
  const MedialAxis& mesh = sequence.start;
  const CellComplex& complex = mesh.complex;
  if (mesh.points.empty()) return;
  const auto add = [&](const char* name, int components, PageArray::Values values) {
    page.arrays.push_back({std::string("simple/") + name, components, std::move(values)});
  };
  // Beside other things the page shows as much as without, as pictures do.
  const bool is_alone = page.low == page.high;
  if (is_alone) page::widen(page, mesh.points);
  add("points", 3, page::places_of(page, mesh.points));
  add("point/radius", 1, std::vector<float>(mesh.radius.begin(), mesh.radius.end()));
  std::vector<std::uint32_t> triangles, lone;
  std::vector<char> is_side(complex.edges.size(), 0);
  for (std::size_t f = 0; f < complex.face_count(); ++f) {
    const auto corners = complex.corners(f);
    if (corners.size() != 3) throw Error(ErrorCode::usage, "a medial mesh for a page has a face that is no triangle");
    triangles.insert(triangles.end(), corners.begin(), corners.end());
    for (const std::uint32_t e : complex.sides(f)) is_side[e] = 1;
  }
  for (std::size_t e = 0; e < complex.edges.size(); ++e)
    if (!is_side[e]) lone.insert(lone.end(), complex.edges[e].begin(), complex.edges[e].end());
  add("triangles", 3, std::move(triangles));
  add("edges", 2, std::move(lone));
  std::vector<std::uint32_t> steps;
  std::vector<Vec3> points;
  std::vector<float> radius;
  for (const Collapse& step : sequence.steps) {
    steps.insert(steps.end(), {step.kept, step.removed == kNone ? step.kept : step.removed});
    points.push_back(step.point);
    radius.push_back(static_cast<float>(step.radius));
  }
  if (is_alone) page::widen(page, points);
  add("steps", 2, std::move(steps));
  add("step_points", 3, page::places_of(page, points));
  add("step_radius", 1, std::move(radius));
  std::vector<float> rows;
  for (const PageMeshError& error : errors)
    for (const double x : {static_cast<double>(error.vertices), error.mean, error.percentile99, error.largest})
      rows.push_back(static_cast<float>(x));
  if (!rows.empty()) add("errors", 4, std::move(rows));
}

}  // namespace quench
