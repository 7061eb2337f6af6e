// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "graph/branch_measures.h"
#include "quench/graph.h"

namespace quench {
namespace {

// How far a ray from a point of the shape runs inside of it, in multiples of `direction`. Stops at the first voxel that
// is not in the shape.
double way_out(const VoxelShape& shape, const Vec3& from, const Vec3& direction) {
  const Grid& grid = shape.grid();
  const Vec3 start = grid.lattice(from), way = grid.lattice(from + direction) - start;
  std::array<std::int64_t, 3> voxel;
  for (int a = 0; a < 3; ++a) voxel[static_cast<std::size_t>(a)] = static_cast<std::int64_t>(std::floor(start[a]));
  double along = 0;
  while (shape.contains(voxel[0], voxel[1], voxel[2])) {
    double next = std::numeric_limits<double>::infinity();
    int through = 0;
    for (int a = 0; a < 3; ++a) {
      if (way[a] == 0) continue;
      const auto border = static_cast<double>(voxel[static_cast<std::size_t>(a)] + (way[a] > 0));
      if (const double t = (border - start[a]) / way[a]; t < next) {
        next = t;
        through = a;
      }
    }
    along = std::max(along, next);
    voxel[static_cast<std::size_t>(through)] += way[through] > 0 ? 1 : -1;
  }
  return along;
}

// The direction in which a branch arrives at its end: from the point that lies `back` before it.
Vec3 direction_at(std::span<const Vec3> from_end, double back) {
  double passed = 0;
  for (std::size_t i = 1; i < from_end.size(); ++i) {
    const Vec3 step = from_end[i] - from_end[i - 1];
    const double length = step.norm();
    if (passed + length >= back && length > 0)
      return from_end[0] - (from_end[i - 1] + step * ((back - passed) / length));
    passed += length;
  }
  return from_end.front() - from_end.back();
}

}  // namespace

CurveGraph extended(const CurveGraph& graph, const VoxelShape& shape) {
  CurveGraph result = graph;
  const double least = 2 * shape.grid().spacing.minCoeff();
  for (CurveGraph::Branch& branch : result.branches) {
    bool changed = false;
    for (const bool at_front : {true, false}) {
      CurveGraph::Node& node = result.nodes[at_front ? branch.from : branch.to];
      if (node.kind != CurveGraph::NodeKind::end) continue;
      std::vector<Vec3> from_end = branch.points;
      if (!at_front) std::reverse(from_end.begin(), from_end.end());
      const Vec3 direction = direction_at(from_end, std::max(least, node.radius));
      if (!(direction.norm() > 0)) continue;
      const double along = way_out(shape, node.point, direction);
      if (!(along > 0)) continue;
      node.point += along * direction;
      node.radius = 0;
      branch.points.insert(at_front ? branch.points.begin() : branch.points.end(), node.point);
      branch.radius.insert(at_front ? branch.radius.begin() : branch.radius.end(), 0.0);
      for (auto* values : {&branch.erosion_thickness, &branch.mgf})  // those of where the axis ends
        if (!values->empty())
          values->insert(at_front ? values->begin() : values->end(), at_front ? values->front() : values->back());
      changed = true;
    }
    if (changed) graph::measure(branch);
  }
  return result;
}

}  // namespace quench
