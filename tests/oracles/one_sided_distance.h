// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <numeric>
#include <vector>

#include "quench/axis.h"
#include "smooth_shapes.h"

/// Both halves of a Hausdorff distance, with a bound on the error instead of a sampling density.
namespace quench::smooth {

/// The cells of a medial axis: polygons as fans (Voronoi faces are flat and convex), lone edges, lone vertices.
inline Soup soup_of(const MedialAxis& axis) {
  const CellComplex& complex = axis.complex;
  Soup soup{axis.points, {}};
  std::vector<char> edge_done(complex.edges.size(), 0), vertex_done(complex.vertex_count, 0);
  for (std::size_t f = 0; f < complex.face_count(); ++f) {
    const auto corners = complex.corners(f);
    for (std::size_t i = 2; i < corners.size(); ++i) soup.triangles.push_back({corners[0], corners[i - 1], corners[i]});
    for (const std::uint32_t e : complex.sides(f)) edge_done[e] = 1;
  }
  for (std::size_t e = 0; e < complex.edges.size(); ++e) {
    const auto& [u, v] = complex.edges[e];
    if (!edge_done[e]) soup.triangles.push_back({u, v, v});
    vertex_done[u] = vertex_done[v] = 1;
  }
  for (std::uint32_t v = 0; v < complex.vertex_count; ++v)
    if (!vertex_done[v]) soup.triangles.push_back({v, v, v});
  return soup;
}

inline double squared_distance_to_segment(const Vec3& x, const Vec3& a, const Vec3& b) {
  const Vec3 d = b - a;
  const double length = d.squaredNorm();
  const double t = length > 0 ? std::clamp((x - a).dot(d) / length, 0.0, 1.0) : 0.0;
  return (x - a - t * d).squaredNorm();
}

/// Also for triangles that are segments or points: the plane counts only where the foot of x is inside.
inline double squared_distance_to_triangle(const Vec3& x, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 n = (b - a).cross(c - a);
  const double area = n.squaredNorm();
  if (area > 0 && n.dot((b - a).cross(x - a)) >= 0 && n.dot((c - b).cross(x - b)) >= 0 &&
      n.dot((a - c).cross(x - c)) >= 0) {
    const double height = n.dot(x - a);
    return height * height / area;
  }
  return std::min({squared_distance_to_segment(x, a, b), squared_distance_to_segment(x, b, c),
                   squared_distance_to_segment(x, c, a)});
}

/// Exact distance to the nearest triangle: hierarchy of boxes by median cuts. Keeps a reference to the soup.
class NearestTriangle {
 public:
  explicit NearestTriangle(const Soup& soup) : soup_(soup), order_(soup.triangles.size()) {
    std::iota(order_.begin(), order_.end(), 0u);
    if (!order_.empty()) build(0, static_cast<std::uint32_t>(order_.size()));
  }
  /// Infinite when there is no triangle. A caller that only asks whether the distance is above `enough` may get any
  /// upper bound of the distance below that.
  double operator()(const Vec3& x, double enough = 0) const {
    double best = std::numeric_limits<double>::infinity();
    if (!nodes_.empty()) search(0, x, std::max(enough, 0.0) * enough, best);
    return std::sqrt(best);
  }

 private:
  struct Node {
    Eigen::AlignedBox3d box;
    std::uint32_t begin, end;  // of a leaf; begin == end for an inner node
    std::uint32_t right;       // the left child follows its parent
  };

  void build(std::uint32_t begin, std::uint32_t end) {
    const std::size_t self = nodes_.size();
    Eigen::AlignedBox3d box;
    for (std::uint32_t i = begin; i < end; ++i)
      for (const std::uint32_t v : soup_.triangles[order_[i]]) box.extend(soup_.points[v]);
    nodes_.push_back({box, begin, end, 0});
    if (end - begin <= 6) return;
    int axis = 0;
    box.sizes().maxCoeff(&axis);
    const auto centre = [&](std::uint32_t i) {
      const auto& t = soup_.triangles[i];
      return soup_.points[t[0]][axis] + soup_.points[t[1]][axis] + soup_.points[t[2]][axis];
    };
    const std::uint32_t middle = begin + (end - begin) / 2;
    std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                     [&](std::uint32_t i, std::uint32_t j) { return centre(i) < centre(j); });
    build(begin, middle);
    nodes_[self].right = static_cast<std::uint32_t>(nodes_.size());
    build(middle, end);
    nodes_[self].begin = nodes_[self].end = 0;
  }

  void search(std::uint32_t n, const Vec3& x, double enough, double& best) const {
    const Node& node = nodes_[n];
    if (node.begin != node.end) {
      for (std::uint32_t i = node.begin; i < node.end; ++i) {
        const auto& t = soup_.triangles[order_[i]];
        best =
            std::min(best, squared_distance_to_triangle(x, soup_.points[t[0]], soup_.points[t[1]], soup_.points[t[2]]));
      }
      return;
    }
    std::array<std::uint32_t, 2> child{n + 1, node.right};
    std::array<double, 2> distance{nodes_[child[0]].box.squaredExteriorDistance(x),
                                   nodes_[child[1]].box.squaredExteriorDistance(x)};
    const std::size_t first = distance[1] < distance[0];
    if (distance[first] < best) search(child[first], x, enough, best);
    if (best > enough && distance[1 - first] < best) search(child[1 - first], x, enough, best);
  }

  const Soup& soup_;
  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
};

/// The largest value of `distance` (1-Lipschitz) over all points of the soup, at most `tolerance` too small: a triangle
/// is quartered while its centroid's value plus its radius could beat the best value found. `distance(x, enough)` may
/// answer with any upper bound of the distance that is below `enough`.
template <class Distance>
double largest_distance(const Soup& soup, const Distance& distance, double tolerance) {
  using Corners = std::array<Vec3, 3>;
  double best = 0;
  const auto could_beat = [&](const Corners& t) {
    const Vec3 centroid = (t[0] + t[1] + t[2]) / 3;
    const double radius = std::sqrt(
        std::max({(t[0] - centroid).squaredNorm(), (t[1] - centroid).squaredNorm(), (t[2] - centroid).squaredNorm()}));
    const double value = distance(centroid, best + std::min(0.0, tolerance - radius));
    best = std::max(best, value);
    return value + radius > best + tolerance;
  };
  const auto corners = [&](const std::array<std::uint32_t, 3>& t) {
    return Corners{soup.points[t[0]], soup.points[t[1]], soup.points[t[2]]};
  };
  // First the corners, so that most triangles are left out at their first look.
  std::vector<char> seen(soup.points.size(), 0);
  for (const auto& t : soup.triangles)
    for (const std::uint32_t v : t)
      if (!seen[v]) {
        seen[v] = 1;
        best = std::max(best, distance(soup.points[v], best));
      }
  std::vector<Corners> stack;
  for (const auto& t : soup.triangles) {
    stack.push_back(corners(t));
    while (!stack.empty()) {
      const Corners c = stack.back();
      stack.pop_back();
      if (!could_beat(c)) continue;
      const Vec3 ab = 0.5 * (c[0] + c[1]), bc = 0.5 * (c[1] + c[2]), ca = 0.5 * (c[2] + c[0]);
      stack.insert(stack.end(),
                   {Corners{c[0], ab, ca}, Corners{ab, c[1], bc}, Corners{ca, bc, c[2]}, Corners{ab, bc, ca}});
    }
  }
  return best;
}

/// Both one-sided distances between a medial axis and the true lambda-medial axis, in world units; at most 0.01 and
/// 0.05 voxels too small.
struct AxisDistances {
  double core_to_axis = 0, axis_to_core = 0;
};
inline AxisDistances axis_distances(const MedialAxis& core, const Solid& solid, double lambda) {
  const double h = core.grid.spacing[0];
  const Soup cells = soup_of(core);
  const NearestTriangle nearest(cells);
  const auto to_axis = [&](const Vec3& x, double) { return solid.axis_distance(x, lambda); };
  return {largest_distance(cells, to_axis, 0.01 * h), largest_distance(solid.axis(lambda), nearest, 0.05 * h)};
}

}  // namespace quench::smooth
