// SPDX-License-Identifier: Apache-2.0
// Measures of the balls: their radius, and how long they stay outside of larger ones when all grow (Miklos, Giesen and
// Pauly 2010). docs/algorithms/pruning.md.
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "axis/ball_tree.h"
#include "axis/measures.h"
#include "base/parallel.h"
#include "quench/axis.h"
#include "quench/measures.h"

namespace quench {

void axis::take_largest_around(const CellComplex& complex, CellValues& value) {
  for (const std::uint32_t e : complex.face_edges) value.edge[e] = 0;
  for (const auto& ends : complex.edges)
    for (const std::uint32_t v : ends) value.vertex[v] = 0;
  spread_to_sides(complex, value);
}

CellValues axis::smallest_of_corners(const CellComplex& complex, const std::vector<double>& of_vertices) {
  CellValues value{of_vertices, std::vector<double>(complex.edges.size()), std::vector<double>(complex.face_count())};
  base::for_indices(complex.face_count(), [&](std::size_t f) {
    double least = std::numeric_limits<double>::infinity();
    for (const std::uint32_t v : complex.corners(f)) least = std::min(least, of_vertices[v]);
    value.face[f] = least;
  });
  base::for_indices(complex.edges.size(), [&](std::size_t e) {
    value.edge[e] = std::min(of_vertices[complex.edges[e][0]], of_vertices[complex.edges[e][1]]);
  });
  take_largest_around(complex, value);
  return value;
}

namespace {

/// The factors of all balls of an axis.
class SwallowingScales {
 public:
  explicit SwallowingScales(const MedialAxis& axis)
      : points_(axis.points_of_voxels()),
        radius_(axis.radius_of_voxels()),
        tree_(axis),
        largest_(tree_.node_count(), -kNever),
        scale_(radius_.size(), kNever) {
    // As doubles: where many balls are of one size, the floats of the tree would make each of them look at all.
    for (std::size_t i = 0; i < tree_.size(); ++i) {
      double& largest = largest_[tree_.leaf_of(i)];
      largest = std::max(largest, tree_.ball(i).radius);
    }
    for (std::size_t n = largest_.size() - 1; n > 1; --n) largest_[n / 2] = std::max(largest_[n / 2], largest_[n]);
    for (const auto& [a, b] : axis.complex.edges) {  // neighbours tell the searches where to stop
      lower(a, b);
      lower(b, a);
    }
  }

  std::vector<double> all(Context* context) {
    constexpr std::size_t kBlock = 1 << 14;
    for (std::size_t begin = 0; begin < scale_.size(); begin += kBlock) {
      checkpoint(context, "scale axis", static_cast<double>(begin) / static_cast<double>(scale_.size()));
      base::for_indices(std::min(kBlock, scale_.size() - begin), [&](std::size_t i) { search(begin + i); });
    }
    checkpoint(context, "scale axis", 1);
    return std::move(scale_);
  }

 private:
  static constexpr double kNever = std::numeric_limits<double>::infinity();
  static constexpr double kEqual = 1e-9;  // radii that differ by less, relatively, differ by rounding

  /// How much larger a ball is than v; 0 where it is not.
  double gap(double radius, std::size_t v) const {
    const double more = radius - radius_[v];
    return more > kEqual * radius_[v] ? more : 0;
  }
  void lower(std::size_t v, std::size_t larger) {
    if (const double more = gap(radius_[larger], v); more > 0)
      scale_[v] = std::min(scale_[v], std::max(1.0, (points_[v] - points_[larger]).norm() / more));
  }
  void search(std::size_t v) {
    const auto bound = [&](std::size_t node) {
      const double more = gap(largest_[node], v);
      return more > 0 ? tree_.distance(node, points_[v]) / more : kNever;
    };
    tree_.walk(bound, scale_[v], [&](std::size_t i) { lower(v, tree_.ball(i).vertex); });
  }

  const std::vector<Vec3>& points_;
  const std::vector<double>& radius_;
  const axis::BallTree tree_;
  std::vector<double> largest_;  // per node of the tree
  std::vector<double> scale_;
};

}  // namespace

void add_circumradius(MedialAxis& axis, Context* context) {
  if (axis.find_measure(kCircumradius)) return;
  axis.measures.push_back(base::in_arena(context, [&] {
    return Measure{std::string(kCircumradius), axis::smallest_of_corners(axis.complex, axis.radius_of_voxels()), {}};
  }));
}

void add_scale_axis(MedialAxis& axis, Context* context) {
  if (axis.find_measure(kScaleAxis)) return;
  axis.measures.push_back(base::in_arena(context, [&] {
    return Measure{
        std::string(kScaleAxis), axis::smallest_of_corners(axis.complex, SwallowingScales(axis).all(context)), {}};
  }));
}

}  // namespace quench
