// SPDX-License-Identifier: Apache-2.0
#include "plane_files.h"

#include <algorithm>
#include <utility>

#include "quench/polygons.h"

namespace quench::program {

io::PlaneLines plane_lines(const CurveGraph& graph) {
  io::PlaneLines lines;
  lines.graph = graph;
  io::PlaneLines::Array thickness{"erosion_thickness", {}}, mgf{"mgf", {}};
  for (const CurveGraph::Branch& branch : lines.graph.branches) {
    thickness.values.push_back(branch.erosion_thickness);
    mgf.values.push_back(branch.mgf);
  }
  lines.arrays = {std::move(thickness)};
  if (std::ranges::none_of(mgf.values, &std::vector<double>::empty)) lines.arrays.push_back(std::move(mgf));
  return lines;
}

io::PlaneLines plane_lines(const pipeline::LoadedShape& shape, const pipeline::RunResult& result) {
  io::PlaneLines lines = plane_lines(result.axis.graph);
  if (shape.polygon) {
    lines.number = shape.polygon->number;
    lines.id = shape.polygon->id;
    lines.properties = shape.polygon->properties;
  }
  lines.outline = shape.polygon ? shape.polygon->polygons : boundary_rings(shape.shape);
  if (result.wide) lines.wide = boundary_rings(*result.wide);
  return lines;
}

}  // namespace quench::program
