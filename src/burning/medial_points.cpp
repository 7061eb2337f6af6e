// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "base/csr.h"
#include "base/union_find.h"
#include "quench/axis.h"
#include "quench/burn.h"
#include "quench/error.h"

namespace quench {

std::vector<MedialPoint> medial_points(const MedialAxis& axis, const Burning& burning) {
  const CellComplex& complex = axis.complex;
  if (!burning.options.plane || burning.burn_time.size() != complex.vertex_count)
    throw Error(ErrorCode::usage, "medial points are those of a medial axis of the plane and its burning");
  base::UnionFind sets(complex.vertex_count);
  for (const auto& [a, b] : complex.edges) sets.unite(a, b);
  const std::vector<double>& time = burning.burn_time;
  // Of a tree the vertex that burns last; components with loops burn for ever.
  std::vector<std::uint32_t> last(complex.vertex_count, kNone);
  for (std::uint32_t v = 0; v < complex.vertex_count; ++v) {
    std::uint32_t& of_set = last[sets.find(v)];
    if (of_set == kNone || time[v] > time[of_set]) of_set = v;
  }
  const auto edges_at = base::Csr<std::uint32_t>::group(complex.vertex_count, [&](const auto& emit) {
    for (std::uint32_t e = 0; e < complex.edges.size(); ++e)
      for (const std::uint32_t v : complex.edges[e]) emit(v, e);
  });
  std::vector<MedialPoint> points;
  for (std::uint32_t root = 0; root < complex.vertex_count; ++root) {
    const std::uint32_t v = last[root];
    if (v == kNone || std::isinf(time[v])) continue;
    // Fire comes to it over every edge. Over the one where it comes last, it meets what went on from here.
    MedialPoint found{axis.points[v], axis.radius[v], time[v]};
    double latest = time[v];
    for (const std::uint32_t e : edges_at[v]) {
      const std::uint32_t u = complex.edges[e][complex.edges[e][0] == v];
      const double length = (axis.points[u] - axis.points[v]).norm();
      if (!(time[u] + length > latest)) continue;
      latest = time[u] + length;
      const double way = 0.5 * (latest - time[v]), t = way / length;
      found.point = axis.points[v] + t * (axis.points[u] - axis.points[v]);
      found.radius = radius_inside_edge(axis.radius[v], axis.radius[u], length, t, burning.options.radius);
      found.burn_time = time[v] + way;
    }
    points.push_back(found);
  }
  return points;
}

}  // namespace quench
