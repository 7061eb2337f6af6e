// SPDX-License-Identifier: Apache-2.0
#include "verification/triangle_search.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace quench::verification {

namespace {

constexpr std::uint32_t kTrianglesOfLeaf = 4;
constexpr int kRays = 24;
constexpr double kNearEdge = 1e-9;  // of a triangle's size: a ray so near to a side may have missed it

double squared_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 d = b - a;
  const double length2 = d.squaredNorm();
  const double t = length2 > 0 ? std::clamp((p - a).dot(d) / length2, 0.0, 1.0) : 0.0;
  return (p - a - t * d).squaredNorm();
}

// The foot on the plane where it is inside, else the nearest of the sides.
double squared_to_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 normal = (b - a).cross(c - a);
  const auto left_of = [&](const Vec3& s, const Vec3& t) { return (t - s).cross(p - s).dot(normal) >= 0; };
  if (normal.squaredNorm() > 0 && left_of(a, b) && left_of(b, c) && left_of(c, a)) {
    const double height = normal.dot(p - a);
    return height * height / normal.squaredNorm();
  }
  return std::min({squared_to_segment(p, a, b), squared_to_segment(p, b, c), squared_to_segment(p, c, a)});
}

// Directions without a plan.
Vec3 ray(int k) {
  const double x = std::sin(1.3 + 12.9898 * k), y = std::sin(0.4 + 78.233 * k), z = std::cos(2.1 + 37.719 * k);
  return Vec3(x, y, z).normalized();
}

bool ray_meets(const Vec3& low, const Vec3& high, const Vec3& p, const Vec3& along) {
  double from = 0, to = std::numeric_limits<double>::infinity();
  for (int a = 0; a < 3; ++a) {
    const double s = (low[a] - p[a]) / along[a], t = (high[a] - p[a]) / along[a];
    from = std::max(from, std::min(s, t));
    to = std::min(to, std::max(s, t));
  }
  return from <= to * (1 + 1e-12);
}

}  // namespace

TriangleSearch::TriangleSearch(const TriangleMesh& mesh) : longest_side_(longest_side_of(mesh.points)) {
  for (const auto& [a, b, c] : mesh.triangles) triangles_.push_back({mesh.points[a], mesh.points[b], mesh.points[c]});
  if (!triangles_.empty()) build(0, static_cast<std::uint32_t>(triangles_.size()));
}

void TriangleSearch::build(std::uint32_t begin, std::uint32_t end) {
  const std::size_t self = nodes_.size();
  nodes_.push_back({triangles_[begin].a, triangles_[begin].a, begin, end, 0});
  for (std::uint32_t i = begin; i < end; ++i)
    for (const Vec3* p : {&triangles_[i].a, &triangles_[i].b, &triangles_[i].c}) {
      nodes_[self].low = nodes_[self].low.cwiseMin(*p);
      nodes_[self].high = nodes_[self].high.cwiseMax(*p);
    }
  if (end - begin <= kTrianglesOfLeaf) return;
  int axis = 0;
  (nodes_[self].high - nodes_[self].low).maxCoeff(&axis);
  const auto middle = [axis](const Triangle& t) { return t.a[axis] + t.b[axis] + t.c[axis]; };
  const std::uint32_t half = begin + (end - begin) / 2;
  std::nth_element(triangles_.begin() + begin, triangles_.begin() + half, triangles_.begin() + end,
                   [&](const Triangle& s, const Triangle& t) { return middle(s) < middle(t); });
  build(begin, half);
  nodes_[self].right = static_cast<std::uint32_t>(nodes_.size());
  build(half, end);
}

void TriangleSearch::find(std::uint32_t n, const Vec3& p, double& squared) const {
  const Node& node = nodes_[n];
  if (node.right == 0) {
    for (std::uint32_t i = node.begin; i < node.end; ++i)
      squared = std::min(squared, squared_to_triangle(p, triangles_[i].a, triangles_[i].b, triangles_[i].c));
    return;
  }
  const auto away = [&](std::uint32_t child) {
    return (p - p.cwiseMax(nodes_[child].low).cwiseMin(nodes_[child].high)).squaredNorm();
  };
  std::array<std::uint32_t, 2> child{n + 1, node.right};
  if (away(child[1]) < away(child[0])) std::swap(child[0], child[1]);
  for (const std::uint32_t c : child)
    if (away(c) < squared) find(c, p, squared);
}

double TriangleSearch::distance(const Vec3& p) const {
  double squared = std::numeric_limits<double>::infinity();
  if (!nodes_.empty()) find(0, p, squared);
  return std::sqrt(squared);
}

void TriangleSearch::cross(std::uint32_t n, const Vec3& p, const Vec3& along, Crossings& crossings) const {
  const Node& node = nodes_[n];
  if (!crossings.sure || !ray_meets(node.low, node.high, p, along)) return;
  if (node.right != 0) {
    cross(n + 1, p, along, crossings);
    cross(node.right, p, along, crossings);
    return;
  }
  for (std::uint32_t i = node.begin; i < node.end; ++i) {
    // The volumes that the ray spans with the sides have one sign where it passes between them.
    const Vec3 a = triangles_[i].a - p, b = triangles_[i].b - p, c = triangles_[i].c - p;
    const Vec3 normal = (b - a).cross(c - a);
    const double slope = normal.dot(along), size = normal.norm();
    if (size == 0) continue;
    const double u = along.dot(b.cross(c)), v = along.dot(c.cross(a)), w = along.dot(a.cross(b));
    const double sign = slope > 0 ? 1 : -1, least = std::min({u * sign, v * sign, w * sign});
    const double error = kNearEdge * (size + std::max({a.squaredNorm(), b.squaredNorm(), c.squaredNorm()}) * 1e-6);
    if (least < -error) continue;
    if (normal.dot(a) * sign < 0) continue;  // behind
    if (least < error || std::abs(slope) < kNearEdge * size) {
      crossings.sure = false;
      return;
    }
    crossings.sum += slope > 0 ? 1 : -1;
  }
}

bool TriangleSearch::inside(const Vec3& p) const {
  Crossings crossings;
  for (int k = 0; k < kRays && !nodes_.empty(); ++k) {
    crossings = {};
    cross(0, p, ray(k), crossings);
    if (crossings.sure) break;
  }
  return crossings.sum == 1;
}

}  // namespace quench::verification
