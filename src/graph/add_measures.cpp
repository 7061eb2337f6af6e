// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <vector>

#include "quench/error.h"
#include "quench/graph.h"

namespace quench {
namespace {

// Finds vertices by where they are.
class VerticesByPlace {
 public:
  explicit VerticesByPlace(const std::vector<Vec3>& points) : points_(points), order_(points.size()) {
    std::iota(order_.begin(), order_.end(), 0u);
    std::sort(order_.begin(), order_.end(), [&](std::uint32_t a, std::uint32_t b) {
      return before(points[a], points[b]) || (points[a] == points[b] && a < b);
    });
  }
  std::uint32_t at(const Vec3& place) const {
    const auto found = std::lower_bound(order_.begin(), order_.end(), place,
                                        [&](std::uint32_t v, const Vec3& p) { return before(points_[v], p); });
    return found != order_.end() && points_[*found] == place ? *found : kNone;
  }

 private:
  static bool before(const Vec3& a, const Vec3& b) {
    return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
  }
  const std::vector<Vec3>& points_;
  std::vector<std::uint32_t> order_;
};

}  // namespace

void add_measures(CurveGraph& graph, const Skeleton& drawn) {
  const VerticesByPlace vertices(drawn.points);
  for (CurveGraph::Branch& branch : graph.branches) {
    branch.erosion_thickness.clear();
    branch.mgf.clear();
    for (const Vec3& point : branch.points) {
      const std::uint32_t v = vertices.at(point);
      if (v == kNone) throw Error(ErrorCode::usage, "the branches are not those of the skeleton");
      const double time = drawn.curve_burn_time[v];
      branch.erosion_thickness.push_back(
          std::isinf(time) ? time : std::max(0.0, time - (drawn.plane ? drawn.radius[v] : drawn.burn_time[v])));
      if (!drawn.mgf.empty()) branch.mgf.push_back(drawn.mgf[v]);
    }
  }
}

}  // namespace quench
