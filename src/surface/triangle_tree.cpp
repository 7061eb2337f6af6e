// SPDX-License-Identifier: Apache-2.0
#include "surface/triangle_tree.h"

#include <tbb/parallel_invoke.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "base/parallel.h"

namespace quench::surface {
namespace {

// Rows of triangles, such that each of `leaves` equal parts holds neighbours: halved along the longest side of the box
// of the centres, again and again.
class LeafOrder {
 public:
  LeafOrder(const TriangleMesh& mesh, std::size_t leaves) : centres_(mesh.triangles.size()), rows_(centres_.size()) {
    base::for_indices(rows_.size(), [&](std::size_t t) {
      const auto& [a, b, c] = mesh.triangles[t];
      centres_[t] = mesh.points[a] + mesh.points[b] + mesh.points[c];
      rows_[t] = static_cast<std::uint32_t>(t);
    });
    halve(0, leaves, leaves);
  }
  const std::vector<std::uint32_t>& rows() const { return rows_; }

 private:
  // Leaves [first, end) of all.
  void halve(std::size_t first, std::size_t end, std::size_t leaves) {
    const std::size_t middle = first + (end - first) / 2;
    const auto at = [&](std::size_t leaf) { return base::part_of(rows_.size(), leaf, leaves).first; };
    const std::size_t from = at(first), to = end == leaves ? rows_.size() : at(end), half = at(middle);
    if (end - first < 2 || to - from < 2) return;
    constexpr double kFar = std::numeric_limits<double>::infinity();
    Vec3 low = Vec3::Constant(kFar), high = -low;
    for (std::size_t i = from; i < to; ++i) {
      low = low.cwiseMin(centres_[rows_[i]]);
      high = high.cwiseMax(centres_[rows_[i]]);
    }
    int axis = 0;
    (high - low).maxCoeff(&axis);
    const auto begin = rows_.begin();
    std::nth_element(begin + static_cast<std::ptrdiff_t>(from), begin + static_cast<std::ptrdiff_t>(half),
                     begin + static_cast<std::ptrdiff_t>(to), [&](std::uint32_t a, std::uint32_t b) {
                       const double x = centres_[a][axis], y = centres_[b][axis];
                       return x != y ? x < y : a < b;
                     });
    constexpr std::size_t kTask = 4096;  // triangles that are worth a task of their own
    if (to - from < kTask) {
      halve(first, middle, leaves);
      halve(middle, end, leaves);
    } else {
      tbb::parallel_invoke([&] { halve(first, middle, leaves); }, [&] { halve(middle, end, leaves); });
    }
  }

  std::vector<Vec3> centres_;  // three times as far from 0
  std::vector<std::uint32_t> rows_;
};

// Parts of the surface with more triangles have no slab: their normals point everywhere.
constexpr std::size_t kLargestSlab = 4096;

// One number for each child of a node, worked on at once (a vector type of GCC and Clang).
using Four = float __attribute__((vector_size(16)));

Four load(const float* from) {
  Four four;
  std::memcpy(&four, from, sizeof four);
  return four;
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
  const double size = mesh.triangles.empty() ? 0 : (high - low).maxCoeff();
  origin_ = low;
  rounding_ = 0x1p-21 * size;
  std::size_t inner = 0;  // nodes above the last floor
  leaves_ = kChildren;
  while (leaves_ * kLeaf < mesh.triangles.size()) {
    inner = inner * kChildren + 1;
    leaves_ *= kChildren;
  }
  const LeafOrder order(mesh, leaves_);
  triangles_.resize(mesh.triangles.size());
  constexpr float kEmpty = std::numeric_limits<float>::infinity();
  Boxes empty;
  for (std::size_t k = 0; k < 3; ++k) {
    std::fill_n(empty.low[k], kChildren, kEmpty);
    std::fill_n(empty.high[k], kChildren, -kEmpty);
    std::fill_n(empty.normal[k], kChildren, 0.0F);
  }
  std::fill_n(empty.least, kChildren, -kEmpty);
  std::fill_n(empty.most, kChildren, kEmpty);
  nodes_.assign(inner + leaves_ / kChildren, empty);
  base::for_indices(leaves_, [&](std::size_t leaf) {
    fill_leaf(mesh, order.rows(), leaf, nodes_[inner + leaf / kChildren], leaf % kChildren);
  });
  for (std::size_t n = nodes_.size() - 1; n > 0; --n) {
    Boxes& parent = nodes_[(n - 1) / kChildren];
    const std::size_t child = (n - 1) % kChildren;
    for (std::size_t k = 0; k < 3; ++k) {
      parent.low[k][child] = *std::ranges::min_element(nodes_[n].low[k]);
      parent.high[k][child] = *std::ranges::max_element(nodes_[n].high[k]);
    }
  }
  std::size_t begin = 0, width = leaves_;  // of a floor: its first node, and the leaves below each
  for (; begin < nodes_.size(); begin = begin * kChildren + 1, width /= kChildren) {
    if (width / kChildren * kLeaf > kLargestSlab) continue;
    base::for_indices((leaves_ / width) * kChildren, [&](std::size_t i) {
      const std::size_t leaf = i * (width / kChildren);
      fill_slab(base::part_of(triangles_.size(), leaf, leaves_).first,
                base::part_of(triangles_.size(), leaf + width / kChildren - 1, leaves_).second,
                nodes_[begin + i / kChildren], i % kChildren);
    });
  }
}

void TriangleTree::fill_slab(std::size_t first, std::size_t last, Boxes& boxes, std::size_t child) const {
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = first; i < last; ++i) sum += triangles_[i].ab.cross(triangles_[i].ac);
  const Eigen::Vector3f normal = sum.normalized().cast<float>();
  if (!normal.allFinite() || first == last) return;
  const Vec3 along = normal.cast<double>();
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (std::size_t i = first; i < last; ++i) {
    const Triangle& t = triangles_[i];
    const double a = along.dot(t.a), b = a + along.dot(t.ab), c = a + along.dot(t.ac);
    least = std::min({least, a, b, c});
    most = std::max({most, a, b, c});
  }
  for (std::size_t k = 0; k < 3; ++k) boxes.normal[k][child] = normal[static_cast<int>(k)];
  constexpr float kFar = std::numeric_limits<float>::infinity();
  boxes.least[child] = std::nextafter(static_cast<float>(least), -kFar);
  boxes.most[child] = std::nextafter(static_cast<float>(most), kFar);
}

void TriangleTree::fill_leaf(const TriangleMesh& mesh, const std::vector<std::uint32_t>& order, std::size_t leaf,
                             Boxes& boxes, std::size_t child) {
  constexpr float kEmpty = std::numeric_limits<float>::infinity();
  const auto [first, last] = base::part_of(order.size(), leaf, leaves_);
  for (std::size_t i = first; i < last; ++i) {
    const auto& corners = mesh.triangles[order[i]];
    const Vec3 a = mesh.points[corners[0]] - origin_, b = mesh.points[corners[1]] - origin_,
               c = mesh.points[corners[2]] - origin_;
    triangles_[i] = {a, b - a, c - a, order[i]};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [least, most] = std::minmax({a[static_cast<int>(k)], b[static_cast<int>(k)], c[static_cast<int>(k)]});
      boxes.low[k][child] = std::min(boxes.low[k][child], std::nextafter(static_cast<float>(least), -kEmpty));
      boxes.high[k][child] = std::max(boxes.high[k][child], std::nextafter(static_cast<float>(most), kEmpty));
    }
  }
}

TriangleTree::Near TriangleTree::nearest(const Vec3& point, double squared_limit) const {
  const Vec3 p = point - origin_;
  const float at[3] = {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])};
  // Boxes and slabs are compared in single precision, with room for what is lost; points far outside lose more.
  const double lost = rounding_ + 0x1p-21 * p.cwiseAbs().maxCoeff();
  const auto limit_of = [&](double squared) {
    const double reach = std::sqrt(squared) + lost;
    return static_cast<float>(reach * reach * (1 + 0x1p-20));
  };
  Near best;
  best.squared = squared_limit;
  float limit = limit_of(squared_limit);
  struct Deferred {
    float squared;
    std::uint32_t node;
  };
  std::array<Deferred, 64> stack;  // up to three per floor of the tree
  std::size_t deferred = 0;
  Deferred now{0, 0};
  const auto inner = static_cast<std::uint32_t>(nodes_.size());
  for (;;) {
    if (now.node < inner) {
      const Boxes& boxes = nodes_[now.node];
      Four squared = {0, 0, 0, 0};
      for (std::size_t k = 0; k < 3; ++k) {
        const Four below = load(boxes.low[k]) - at[k], above = at[k] - load(boxes.high[k]);
        const Four larger = below > above ? below : above;
        const Four outside = larger > 0 ? larger : Four{0, 0, 0, 0};
        squared += outside * outside;
      }
      const Four height = load(boxes.normal[0]) * at[0] + load(boxes.normal[1]) * at[1] + load(boxes.normal[2]) * at[2];
      const Four below = load(boxes.least) - height, above = height - load(boxes.most);
      const Four larger = below > above ? below : above;
      const Four slab = larger > 0 ? larger * larger : Four{0, 0, 0, 0};
      squared = slab > squared ? slab : squared;
      Deferred children[kChildren];
      std::size_t count = 0;
      for (std::uint32_t c = 0; c < kChildren; ++c) {
        if (!(squared[c] <= limit)) continue;
        std::size_t place = count++;  // the farthest first
        for (; place > 0 && children[place - 1].squared < squared[c]; --place) children[place] = children[place - 1];
        children[place] = {squared[c], static_cast<std::uint32_t>(kChildren) * now.node + 1 + c};
      }
      for (std::size_t c = 0; c < count; ++c) stack[deferred++] = children[c];
    } else {
      const auto [first, end] = base::part_of(triangles_.size(), now.node - inner, leaves_);
      const double before = best.squared;
      for (std::size_t i = first; i < end; ++i) {
        const Triangle& t = triangles_[i];
        const Vec3 from_a = p - t.a;
        const auto [there, feature] = nearest_in(t.ab, t.ac, from_a);
        const double squared = (from_a - there).squaredNorm();
        if (squared < best.squared || (squared == best.squared && best.triangle == kNone))
          best = {t.a + there, squared, t.row, feature};
      }
      if (best.squared < before) limit = limit_of(best.squared);
    }
    do {
      if (deferred == 0) {
        best.point += origin_;
        return best;
      }
      now = stack[--deferred];
    } while (!(now.squared <= limit));
  }
}

}  // namespace quench::surface
