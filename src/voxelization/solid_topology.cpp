// SPDX-License-Identifier: Apache-2.0
#include "voxelization/solid_topology.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/csr.h"
#include "base/union_find.h"
#include "voxelization/surface_edges.h"

// Bounds. Coordinates are <= 2^34. Products of two differences < 2^68, components of a normal or of the product of two
// edges < 2^69, times a difference < 2^103, the sum of three < 2^105.

namespace quench::voxelization {
namespace {

using Product = __int128;
using Corners3 = std::array<FixedPoint, 3>;
using Direction = std::array<Product, 3>;

FixedPoint minus(const FixedPoint& a, const FixedPoint& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

Direction cross_of(const FixedPoint& a, const FixedPoint& b) {
  Direction result;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t u = (i + 1) % 3, v = (i + 2) % 3;
    result[i] = Product{a[u]} * b[v] - Product{a[v]} * b[u];
  }
  return result;
}

Product dot_of(const Direction& n, const FixedPoint& p) { return n[0] * p[0] + n[1] * p[1] + n[2] * p[2]; }

bool is_zero(const Direction& n) { return n[0] == 0 && n[1] == 0 && n[2] == 0; }

/// Whether the triangles have no point in common along a direction. Coordinates relative to a corner of `a`.
bool separates(const Direction& n, const Corners3& a, const Corners3& b) {
  const auto [low_a, high_a] = std::minmax({dot_of(n, a[0]), dot_of(n, a[1]), dot_of(n, a[2])});
  const auto [low_b, high_b] = std::minmax({dot_of(n, b[0]), dot_of(n, b[1]), dot_of(n, b[2])});
  return high_a < low_b || high_b < low_a;
}

/// Directions in the plane of two axes, perpendicular to the edges of both: those that are left for coplanar triangles.
bool separated_in_plane(std::size_t u, std::size_t v, const Corners3& a, const Corners3& b) {
  for (const Corners3* of : {&a, &b})
    for (std::size_t i = 0; i < 3; ++i) {
      const FixedPoint edge = minus((*of)[(i + 1) % 3], (*of)[i]);
      Direction n{0, 0, 0};
      n[u] = -edge[v];
      n[v] = edge[u];
      if (!is_zero(n) && separates(n, a, b)) return true;
    }
  return false;
}

/// The surface by components.
struct Part {
  FixedPoint point{};  ///< a vertex
  std::int64_t vertices = 0, faces = 0;
  std::int64_t handles() const { return 1 - (vertices - faces / 2) / 2; }  // every edge has two faces
};

class Parts {
 public:
  Parts(const TriangleMesh& mesh, const FixedMesh& fixed) : faces_(welded_faces(mesh)), points_(fixed.points) {
    base::UnionFind sets(mesh.points.size());
    for (const Triangle& face : faces_) {
      sets.unite(face[0], face[1]);
      sets.unite(face[1], face[2]);
    }
    constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
    std::vector<std::uint32_t> of_root(mesh.points.size(), kNone);
    std::vector<char> seen(mesh.points.size(), 0);
    for (const Triangle& face : faces_) {
      std::uint32_t& part = of_root[sets.find(face[0])];
      if (part == kNone) {
        part = static_cast<std::uint32_t>(parts_.size());
        parts_.push_back({points_[face[0]]});
      }
      part_of_.push_back(part);
      ++parts_[part].faces;
      for (const std::uint32_t corner : face) {
        parts_[part].vertices += !seen[corner];
        seen[corner] = 1;
      }
    }
    cells_ = std::clamp<std::int64_t>(std::llround(std::cbrt(static_cast<double>(faces_.size()))), 1, 256);
    const std::int64_t longest = std::max({fixed.cells[0], fixed.cells[1], fixed.cells[2]}) << kFractionBits;
    cell_ = longest / cells_ + 1;
  }

  const std::vector<Part>& parts() const { return parts_; }

  /// Whether faces of two parts have a point in common.
  bool meet() const {
    const auto n = static_cast<std::size_t>(cells_);
    const auto in_cell = base::Csr<std::uint32_t>::group(n * n * n, [&](const auto& emit) {
      for (std::uint32_t f = 0; f < faces_.size(); ++f) {
        const auto x = cells_of(f, 0), y = cells_of(f, 1), z = cells_of(f, 2);
        for (std::size_t k = z[0]; k <= z[1]; ++k)
          for (std::size_t j = y[0]; j <= y[1]; ++j)
            for (std::size_t i = x[0]; i <= x[1]; ++i) emit((k * n + j) * n + i, f);
      }
    });
    for (std::size_t cell = 0; cell < n * n * n; ++cell)
      for (const std::uint32_t f : in_cell[cell])
        for (const std::uint32_t g : in_cell[cell])
          if (f < g && part_of_[f] != part_of_[g] && triangles_meet(corners(f), corners(g))) return true;
    return false;
  }

  /// Winding number at a vertex of each part of all other parts: the faces that a ray along x from there crosses. The
  /// ray is shifted symbolically as the centres in scan_conversion.cpp are.
  std::vector<std::int64_t> winding_outside() const {
    const auto n = static_cast<std::size_t>(cells_);
    const auto in_cell = base::Csr<std::uint32_t>::group(n * n, [&](const auto& emit) {
      for (std::uint32_t f = 0; f < faces_.size(); ++f) {
        const auto y = cells_of(f, 1), z = cells_of(f, 2);
        for (std::size_t k = z[0]; k <= z[1]; ++k)
          for (std::size_t j = y[0]; j <= y[1]; ++j) emit(k * n + j, f);
      }
    });
    std::vector<std::int64_t> winding(parts_.size(), 0);
    for (std::uint32_t part = 0; part < parts_.size(); ++part) {
      const FixedPoint& p = parts_[part].point;
      for (const std::uint32_t f : in_cell[cell_at(p[2]) * n + cell_at(p[1])])
        if (part_of_[f] != part) winding[part] += crossing(corners(f), p);
    }
    return winding;
  }

  /// Of a vertex of each part, and of the inside of it: +1 or -1 more.
  std::vector<std::int64_t> turns() const {
    std::vector<double> volume(parts_.size(), 0);
    for (std::uint32_t f = 0; f < faces_.size(); ++f) {
      const FixedPoint& o = parts_[part_of_[f]].point;
      const auto [a, b, c] = corners(f);
      const Direction n = cross_of(minus(b, a), minus(c, a));
      volume[part_of_[f]] += static_cast<double>(dot_of(n, minus(a, o)));
    }
    std::vector<std::int64_t> result;
    for (const double v : volume) result.push_back(v < 0 ? -1 : 1);
    return result;
  }

 private:
  Corners3 corners(std::uint32_t f) const {
    return {points_[faces_[f][0]], points_[faces_[f][1]], points_[faces_[f][2]]};
  }
  std::size_t cell_at(std::int64_t coordinate) const { return static_cast<std::size_t>(coordinate / cell_); }
  std::array<std::size_t, 2> cells_of(std::uint32_t f, std::size_t axis) const {
    const auto [a, b, c] = corners(f);
    const auto [low, high] = std::minmax({a[axis], b[axis], c[axis]});
    return {cell_at(low), cell_at(high)};
  }

  /// Whether the ray from p leaves (1) or enters (-1) through a face.
  static int crossing(const Corners3& face, const FixedPoint& p) {
    int beyond = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const FixedPoint *a = &face[i], *b = &face[(i + 1) % 3];
      if (((*a)[2] <= p[2]) == ((*b)[2] <= p[2])) continue;
      if ((*a)[2] > (*b)[2]) std::swap(a, b);
      // p is at or beyond the edge, in y, at its height.
      const Product side =
          Product{p[1] - (*a)[1]} * ((*b)[2] - (*a)[2]) - Product{(*b)[1] - (*a)[1]} * (p[2] - (*a)[2]);
      beyond += side >= 0;
    }
    if (beyond != 1) return 0;
    const Direction n = cross_of(minus(face[1], face[0]), minus(face[2], face[0]));
    const Product ahead = dot_of(n, minus(face[0], p));  // of the sign of n[0] when the face is ahead
    return ahead > 0 && n[0] > 0 ? 1 : ahead < 0 && n[0] < 0 ? -1 : 0;
  }

  std::vector<Triangle> faces_;
  const std::vector<FixedPoint>& points_;
  std::vector<Part> parts_;
  std::vector<std::uint32_t> part_of_;  ///< of a face
  std::int64_t cells_ = 1, cell_ = 1;
};

}  // namespace

bool triangles_meet(const Corners3& first, const Corners3& second) {
  for (std::size_t a = 0; a < 3; ++a) {
    const auto [low_f, high_f] = std::minmax({first[0][a], first[1][a], first[2][a]});
    const auto [low_s, high_s] = std::minmax({second[0][a], second[1][a], second[2][a]});
    if (high_f < low_s || high_s < low_f) return false;
  }
  Corners3 a, b, edge_a, edge_b;
  for (std::size_t i = 0; i < 3; ++i) {
    a[i] = minus(first[i], first[0]);
    b[i] = minus(second[i], first[0]);
  }
  for (std::size_t i = 0; i < 3; ++i) {
    edge_a[i] = minus(a[(i + 1) % 3], a[i]);
    edge_b[i] = minus(b[(i + 1) % 3], b[i]);
  }
  const Direction normal_a = cross_of(edge_a[0], edge_a[1]), normal_b = cross_of(edge_b[0], edge_b[1]);
  for (const Direction& n : {normal_a, normal_b})
    if (!is_zero(n) && separates(n, a, b)) return false;
  for (const FixedPoint& e : edge_a)
    for (const FixedPoint& f : edge_b)
      if (const Direction n = cross_of(e, f); !is_zero(n) && separates(n, a, b)) return false;
  // Coplanar, or degenerate: the projections along the axes along which they do not vanish.
  for (std::size_t i = 0; i < 3; ++i)
    if (separated_in_plane((i + 1) % 3, (i + 2) % 3, a, b)) return false;
  return true;
}

std::optional<std::array<std::int64_t, 3>> solid_betti(const TriangleMesh& mesh, const FixedMesh& fixed,
                                                       const SurfaceAnalysis& analysis, Inside inside) {
  const SurfaceTopology& surface = analysis.topology;
  if (!surface.manifold) return std::nullopt;
  if (surface.components == 1) return {{1, 1 - surface.euler, 0}};
  const Parts parts(mesh, fixed);
  if (parts.meet()) return std::nullopt;
  const auto is_solid = [&](std::int64_t winding) { return inside == Inside::odd ? winding % 2 != 0 : winding != 0; };
  const std::vector<std::int64_t> outside = parts.winding_outside(), turns = parts.turns();
  std::array<std::int64_t, 3> betti{};
  for (std::size_t p = 0; p < outside.size(); ++p) {
    const bool before = is_solid(outside[p]), after = is_solid(outside[p] + turns[p]);
    if (before == after) continue;
    ++betti[before ? 2 : 0];
    betti[1] += parts.parts()[p].handles();
  }
  return betti;
}

}  // namespace quench::voxelization
