// SPDX-License-Identifier: Apache-2.0
#include "surface/triangle_tree.h"

#include <tbb/parallel_sort.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "base/parallel.h"
#include "base/z_order.h"

namespace quench::surface {
namespace {

constexpr int kBits = 21;  // of a coordinate along the curve

std::vector<std::uint32_t> in_z_order(const TriangleMesh& mesh, const Vec3& low, double size) {
  std::vector<std::pair<std::uint64_t, std::uint32_t>> keyed(mesh.triangles.size());
  const double scale = size > 0 ? ((1 << kBits) - 1) / size : 0;
  base::for_indices(keyed.size(), [&](std::size_t t) {
    const auto& [a, b, c] = mesh.triangles[t];
    const Vec3 at = ((mesh.points[a] + mesh.points[b] + mesh.points[c]) / 3 - low) * scale;
    const auto whole = [&](int i) { return static_cast<std::uint64_t>(std::max(at[i], 0.0)); };
    keyed[t] = {base::z_order(whole(0), whole(1), whole(2)), static_cast<std::uint32_t>(t)};
  });
  tbb::parallel_sort(keyed.begin(), keyed.end());
  std::vector<std::uint32_t> order(keyed.size());
  base::for_indices(order.size(), [&](std::size_t i) { order[i] = keyed[i].second; });
  return order;
}

// The nearest point of a triangle, as a vector from its corner a (Ericson 2005, sec. 5.1.5). `p` is relative to a.
std::pair<Vec3, Feature> nearest_in(const Vec3& ab, const Vec3& ac, const Vec3& p) {
  const double d1 = ab.dot(p), d2 = ac.dot(p);
  if (d1 <= 0 && d2 <= 0) return {Vec3::Zero(), kCorner};
  const Vec3 bp = p - ab;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return {ab, kCorner + 1};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return {d1 / (d1 - d3) * ab, kSide + 2};
  const Vec3 cp = p - ac;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return {ac, kCorner + 2};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return {d2 / (d2 - d6) * ac, kSide + 1};
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const double t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {ab + t * (ac - ab), kSide};
  }
  const double scale = 1 / (va + vb + vc);
  return {vb * scale * ab + vc * scale * ac, kInterior};
}

}  // namespace

TriangleTree::TriangleTree(const TriangleMesh& mesh) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  Vec3 low = Vec3::Constant(kFar), high = -low;
  for (const auto& triangle : mesh.triangles)
    for (const std::uint32_t corner : triangle) {
      low = low.cwiseMin(mesh.points[corner]);
      high = high.cwiseMax(mesh.points[corner]);
    }
  origin_ = low;
  const std::vector<std::uint32_t> order = in_z_order(mesh, low, (high - low).maxCoeff());
  leaves_ = std::bit_ceil((order.size() + kLeaf - 1) / kLeaf);
  triangles_.resize(order.size());
  constexpr float kEmpty = std::numeric_limits<float>::infinity();
  boxes_.assign(2 * leaves_, {{kEmpty, kEmpty, kEmpty}, {-kEmpty, -kEmpty, -kEmpty}});
  base::for_indices((order.size() + kLeaf - 1) / kLeaf, [&](std::size_t leaf) {
    Box& box = boxes_[leaves_ + leaf];
    for (std::size_t i = leaf * kLeaf; i < std::min(order.size(), (leaf + 1) * kLeaf); ++i) {
      const auto& corners = mesh.triangles[order[i]];
      const Vec3 a = mesh.points[corners[0]] - origin_, b = mesh.points[corners[1]] - origin_,
                 c = mesh.points[corners[2]] - origin_;
      triangles_[i] = {a, b - a, c - a, order[i]};
      for (const Vec3* p : {&a, &b, &c})
        for (std::size_t k = 0; k < 3; ++k) {
          const double x = (*p)[static_cast<int>(k)];
          box.low[k] = std::min(box.low[k], std::nextafter(static_cast<float>(x), -kEmpty));
          box.high[k] = std::max(box.high[k], std::nextafter(static_cast<float>(x), kEmpty));
        }
    }
  });
  for (std::size_t n = leaves_ - 1; n > 0; --n)
    for (std::size_t k = 0; k < 3; ++k) {
      boxes_[n].low[k] = std::min(boxes_[2 * n].low[k], boxes_[2 * n + 1].low[k]);
      boxes_[n].high[k] = std::max(boxes_[2 * n].high[k], boxes_[2 * n + 1].high[k]);
    }
}

double TriangleTree::squared_distance(const Box& box, const Vec3& p) const {
  double squared = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double x = p[static_cast<int>(k)];
    const double outside = std::max({static_cast<double>(box.low[k]) - x, x - static_cast<double>(box.high[k]), 0.0});
    squared += outside * outside;
  }
  return squared;
}

TriangleTree::Near TriangleTree::nearest(const Vec3& point, double squared_limit) const {
  const Vec3 p = point - origin_;
  Near best;
  best.squared = squared_limit;
  std::array<std::pair<double, std::size_t>, 64> stack;  // a node deferred per floor of the tree
  std::size_t deferred = 0;
  double own = squared_distance(boxes_[1], p);
  for (std::size_t node = 1;;) {
    if (own <= best.squared) {
      if (node < leaves_) {
        double left = squared_distance(boxes_[2 * node], p), right = squared_distance(boxes_[2 * node + 1], p);
        std::size_t near = 2 * node, far = 2 * node + 1;
        if (right < left) {
          std::swap(near, far);
          std::swap(left, right);
        }
        if (right <= best.squared) stack[deferred++] = {right, far};
        node = near;
        own = left;
        continue;
      }
      const std::size_t first = (node - leaves_) * kLeaf, end = std::min(triangles_.size(), first + kLeaf);
      for (std::size_t i = first; i < end; ++i) {
        const Triangle& t = triangles_[i];
        const Vec3 from_a = p - t.a;
        const auto [at, feature] = nearest_in(t.ab, t.ac, from_a);
        const double squared = (from_a - at).squaredNorm();
        if (squared < best.squared || (squared == best.squared && best.triangle == kNone))
          best = {t.a + at, squared, t.row, feature};
      }
    }
    if (deferred == 0) break;
    std::tie(own, node) = stack[--deferred];
  }
  best.point += origin_;
  return best;
}

}  // namespace quench::surface
