// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>

#include "base/union_find.h"
#include "quench/error.h"
#include "voxelization/surface_analysis.h"

namespace quench {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

/// One side of a face, on the edge from a welded point to one with a larger index.
struct Side {
  std::uint32_t high;  ///< the larger point
  std::uint32_t side;  ///< 3 * face + i: from corner i of the face to the next one
};

/// For every point the first point (in a fixed order) at the same position. Bits are compared instead of numbers: a
/// total order even with NaN.
std::vector<std::uint32_t> weld(const TriangleMesh& mesh) {
  const std::size_t n = mesh.points.size();
  const auto key = [&](std::uint32_t p) {
    std::array<std::uint64_t, 3> bits;
    for (int a = 0; a < 3; ++a)
      bits[static_cast<std::size_t>(a)] = std::bit_cast<std::uint64_t>(mesh.points[p][a] + 0.0);  // -0 becomes 0
    return bits;
  };
  std::vector<std::uint32_t> order(n), first(n);
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t p, std::uint32_t q) {
    const auto a = key(p), b = key(q);
    return a != b ? a < b : p < q;
  });
  for (std::size_t i = 0; i < n; ++i)
    first[order[i]] = i > 0 && key(order[i]) == key(order[i - 1]) ? first[order[i - 1]] : order[i];
  return first;
}

std::vector<Triangle> welded_faces(const TriangleMesh& mesh) {
  const std::vector<std::uint32_t> first = weld(mesh);
  std::vector<Triangle> faces;
  faces.reserve(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    Triangle face = mesh.triangles[t];
    for (std::uint32_t& corner : face) {
      if (corner >= mesh.points.size()) voxelization::refuse_corner(mesh, t, corner);
      corner = first[corner];
    }
    if (face[0] != face[1] && face[1] != face[2] && face[2] != face[0]) faces.push_back(face);
  }
  return faces;
}

std::uint32_t next_corner(std::uint32_t side) { return side % 3 == 2 ? side - 2 : side + 1; }

/// The faces around one edge, and what they say about the surface there.
class EdgeFan {
 public:
  EdgeFan(const TriangleMesh& mesh, const std::vector<Triangle>& faces, bool inward)
      : mesh_(mesh), faces_(faces), inward_(inward) {}

  bool upward(const Side& s) const {  // the face runs along the edge from the smaller to the larger point
    return corner(next_corner(s.side)) == s.high;
  }

  /// Pairs of faces that bound the same wedge of solid at a non-manifold edge of a closed surface; empty when faces
  /// do not alternate around it. In double precision: this only says how many sheets of solid meet there.
  std::vector<std::array<Side, 2>> wedges(std::uint32_t low, std::span<const Side> sides) const {
    const Vec3 origin = mesh_.points[low];
    const Vec3 axis = mesh_.points[sides[0].high] - origin;
    Vec3 u = axis.unitOrthogonal();
    const Vec3 v = axis.cross(u).normalized();
    std::vector<std::pair<double, Side>> around;
    for (const Side& s : sides) {
      const Vec3 w = mesh_.points[corner(next_corner(next_corner(s.side)))] - origin;
      const double angle = std::atan2(w.dot(v), w.dot(u));
      around.emplace_back(std::isfinite(angle) ? angle : 0, s);
    }
    std::sort(around.begin(), around.end(), [](const auto& a, const auto& b) {
      return a.first != b.first ? a.first < b.first : a.second.side < b.second.side;
    });
    // The normal of an upward face points to larger angles, so its solid lies at smaller ones (outward orientation).
    std::vector<std::array<Side, 2>> pairs;
    const std::size_t k = around.size();
    for (std::size_t i = 0; i < k; ++i) {
      const Side& first = around[i].second;
      const Side& second = around[(i + 1) % k].second;
      if (upward(first) != inward_) continue;
      if (upward(second) == inward_) return {};
      pairs.push_back({first, second});
    }
    if (2 * pairs.size() != k) pairs.clear();
    return pairs;
  }

 private:
  std::uint32_t corner(std::uint32_t c) const { return faces_[c / 3][c % 3]; }
  const TriangleMesh& mesh_;
  const std::vector<Triangle>& faces_;
  bool inward_;
};

double signed_volume(const TriangleMesh& mesh, const std::vector<Triangle>& faces) {
  double sum = 0;
  if (faces.empty()) return sum;
  const Vec3 o = mesh.points[faces[0][0]];
  for (const Triangle& f : faces)
    sum += (mesh.points[f[0]] - o).dot((mesh.points[f[1]] - o).cross(mesh.points[f[2]] - o));
  return sum;
}

}  // namespace

void voxelization::refuse_corner(const TriangleMesh& mesh, std::size_t triangle, std::uint32_t point) {
  throw Error(ErrorCode::input,
              fmt::format("triangle {} of the mesh refers to point {}, but the last one is {}; the file "
                          "is damaged",
                          triangle, point, static_cast<std::int64_t>(mesh.points.size()) - 1));
}

// Vertices are counted once per fan of faces and edges once per pair of faces that bound the same solid. On a
// 2-manifold these are the plain counts; where parts touch in a vertex or an edge, the open solid (foreground
// 6-connected) is not connected there, and only this count gives half the Euler characteristic of its boundary.
voxelization::SurfaceAnalysis voxelization::analyze_surface(const TriangleMesh& mesh) {
  constexpr std::size_t limit = std::numeric_limits<std::uint32_t>::max();
  if (mesh.points.size() >= limit || mesh.triangles.size() >= limit / 3)
    throw Error(ErrorCode::failed, "the mesh has more than 2^32 points or corners of triangles; simplify it first");
  const std::vector<Triangle> faces = welded_faces(mesh);
  const EdgeFan fan(mesh, faces, signed_volume(mesh, faces) < 0);

  // Sides of faces by their smaller point: count, prefix, fill.
  std::vector<std::uint32_t> begin(mesh.points.size() + 1, 0);
  const auto for_each_side = [&](const auto& visit) {
    for (std::uint32_t f = 0; f < faces.size(); ++f)
      for (std::uint32_t i = 0; i < 3; ++i) {
        const std::uint32_t a = faces[f][i], b = faces[f][(i + 1) % 3];
        visit(std::min(a, b), Side{std::max(a, b), 3 * f + i});
      }
  };
  for_each_side([&](std::uint32_t low, const Side&) { ++begin[low + 1]; });
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<Side> sides(3 * faces.size());
  {
    std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
    for_each_side([&](std::uint32_t low, const Side& side) { sides[next[low]++] = side; });
  }

  SurfaceAnalysis result;
  result.degenerate_faces = static_cast<std::int64_t>(mesh.triangles.size() - faces.size());
  base::UnionFind fans(3 * faces.size()), parts(mesh.points.size());
  std::int64_t edges = 0;
  bool manifold = true;
  const auto join = [&](const Side& s, const Side& t) {  // the corners of two faces at both ends of their edge
    const bool same = fan.upward(s) == fan.upward(t);
    fans.unite(s.side, same ? t.side : next_corner(t.side));
    fans.unite(next_corner(s.side), same ? next_corner(t.side) : t.side);
  };
  for (std::uint32_t low = 0; low < mesh.points.size(); ++low) {
    const auto from = sides.begin() + begin[low], to = sides.begin() + begin[low + 1];
    std::sort(from, to,
              [](const Side& s, const Side& t) { return s.high != t.high ? s.high < t.high : s.side < t.side; });
    for (auto e = from; e != to;) {
      const auto after = std::find_if(e, to, [&](const Side& s) { return s.high != e->high; });
      const std::span<const Side> around(e, after);
      parts.unite(low, e->high);
      const auto up = std::count_if(around.begin(), around.end(), [&](const Side& s) { return fan.upward(s); });
      result.boundary_edges += around.size() == 1;
      result.odd_edges += around.size() % 2 != 0;
      result.unbalanced_edges += 2 * static_cast<std::size_t>(up) != around.size();
      const bool regular = around.size() == 2 && fan.upward(around[0]) != fan.upward(around[1]);
      manifold = manifold && regular;
      const auto wedges = around.size() > 2 ? fan.wedges(low, around) : std::vector<std::array<Side, 2>>{};
      for (const auto& wedge : wedges) join(wedge[0], wedge[1]);
      if (wedges.empty())
        for (std::size_t i = 1; i < around.size(); ++i) join(around[i - 1], around[i]);
      edges += std::max<std::int64_t>(1, static_cast<std::int64_t>(wedges.size()));
      e = after;
    }
  }
  std::vector<char> used(mesh.points.size(), 0);
  for (const Triangle& f : faces)
    for (const std::uint32_t corner : f) used[corner] = 1;
  const auto unused = std::count(used.begin(), used.end(), 0);
  const std::int64_t vertices = static_cast<std::int64_t>(mesh.points.size()) - unused;
  result.topology.manifold = manifold && fans.count() == vertices && !faces.empty();
  result.topology.components = parts.count() - unused;
  result.topology.surface_euler = fans.count() - edges + static_cast<std::int64_t>(faces.size());
  result.topology.euler = result.topology.surface_euler / 2;
  result.topology.boundary_edges = result.boundary_edges;
  return result;
}

SurfaceTopology surface_topology(const TriangleMesh& mesh) { return voxelization::analyze_surface(mesh).topology; }

}  // namespace quench
