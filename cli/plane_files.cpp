// SPDX-License-Identifier: Apache-2.0
#include "plane_files.h"

#include <utility>

#include "quench/polygons.h"

namespace quench::program {

io::PlaneLines plane_lines(const pipeline::LoadedShape& shape, const pipeline::RunResult& result) {
  io::PlaneLines lines;
  lines.graph = result.axis.graph;
  io::PlaneLines::Array thickness{"erosion_thickness", {}}, mgf{"mgf", {}};
  for (const CurveGraph::Branch& branch : lines.graph.branches) {
    thickness.values.push_back(branch.erosion_thickness);
    mgf.values.push_back(branch.mgf);
  }
  lines.arrays = {std::move(thickness), std::move(mgf)};
  lines.outline = shape.polygon ? shape.polygon->polygons : boundary_rings(shape.shape);
  if (result.wide) lines.wide = boundary_rings(*result.wide);
  return lines;
}

}  // namespace quench::program
