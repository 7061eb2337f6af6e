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
#include "voxelization/surface_edges.h"

namespace quench::voxelization {
namespace {

/// For every point the first point (in a fixed order) at the same position. Bits are compared instead of numbers: a
/// total order even with NaN.
std::vector<std::uint32_t> first_at_position(const TriangleMesh& mesh) {
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

std::uint32_t next_corner(std::uint32_t side) { return side % 3 == 2 ? side - 2 : side + 1; }

/// The faces around the edges of a surface.
class EdgeFan {
 public:
  EdgeFan(const TriangleMesh& mesh, const std::vector<Triangle>& faces, bool inward)
      : mesh_(mesh), faces_(faces), inward_(inward) {}

  bool upward(const FaceSide& s) const { return is_upward(faces_, s.side); }

  /// Unites the corners of faces that bound the same solid at an edge. Returns as how many edges it counts.
  std::int64_t join(std::uint32_t low, std::span<const FaceSide> sides, base::UnionFind& fans) const {
    const auto unite = [&](const FaceSide& s, const FaceSide& t) {  // at both ends of the edge
      const bool same = upward(s) == upward(t);
      fans.unite(s.side, same ? t.side : next_corner(t.side));
      fans.unite(next_corner(s.side), same ? next_corner(t.side) : t.side);
    };
    const auto pairs = sides.size() > 2 ? wedges(low, sides) : std::vector<std::array<FaceSide, 2>>{};
    for (const auto& [s, t] : pairs) unite(s, t);
    if (!pairs.empty()) return static_cast<std::int64_t>(pairs.size());
    for (std::size_t i = 1; i < sides.size(); ++i) unite(sides[i - 1], sides[i]);
    return 1;
  }

 private:
  /// Pairs of faces that bound the same wedge of solid at a non-manifold edge of a closed surface; empty when faces
  /// do not alternate around it. In double precision: this only says how many sheets of solid meet there.
  std::vector<std::array<FaceSide, 2>> wedges(std::uint32_t low, std::span<const FaceSide> sides) const {
    const Vec3 origin = mesh_.points[low];
    const Vec3 axis = mesh_.points[sides[0].high] - origin;
    Vec3 u = axis.unitOrthogonal();
    const Vec3 v = axis.cross(u).normalized();
    std::vector<std::pair<double, FaceSide>> around;
    for (const FaceSide& s : sides) {
      const Vec3 w = mesh_.points[corner(next_corner(next_corner(s.side)))] - origin;
      const double angle = std::atan2(w.dot(v), w.dot(u));
      around.emplace_back(std::isfinite(angle) ? angle : 0, s);
    }
    std::sort(around.begin(), around.end(), [](const auto& a, const auto& b) {
      return a.first != b.first ? a.first < b.first : a.second.side < b.second.side;
    });
    // The normal of an upward face points to larger angles, so its solid lies at smaller ones (outward orientation).
    std::vector<std::array<FaceSide, 2>> pairs;
    const std::size_t k = around.size();
    for (std::size_t i = 0; i < k; ++i) {
      const FaceSide& first = around[i].second;
      const FaceSide& second = around[(i + 1) % k].second;
      if (upward(first) != inward_) continue;
      if (upward(second) == inward_) return {};
      pairs.push_back({first, second});
    }
    if (2 * pairs.size() != k) pairs.clear();
    return pairs;
  }

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

void refuse_corner(const TriangleMesh& mesh, std::size_t triangle, std::uint32_t point) {
  throw Error(ErrorCode::input,
              fmt::format("triangle {} of the mesh refers to point {}, but the last one is {}; the file "
                          "is damaged",
                          triangle, point, static_cast<std::int64_t>(mesh.points.size()) - 1));
}

std::vector<Triangle> welded_faces(const TriangleMesh& mesh) {
  const std::vector<std::uint32_t> first = first_at_position(mesh);
  std::vector<Triangle> faces;
  faces.reserve(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    Triangle face = mesh.triangles[t];
    for (std::uint32_t& corner : face) {
      if (corner >= mesh.points.size()) refuse_corner(mesh, t, corner);
      corner = first[corner];
    }
    if (face[0] != face[1] && face[1] != face[2] && face[2] != face[0]) faces.push_back(face);
  }
  return faces;
}

// Vertices are counted once per fan of faces and edges once per pair of faces that bound the same solid. On a
// 2-manifold these are the plain counts; where parts touch in a vertex or an edge, the open solid (foreground
// 6-connected) is not connected there, and only this count gives half the Euler characteristic of its boundary.
SurfaceAnalysis analyze_surface(const TriangleMesh& mesh) {
  constexpr std::size_t kLimit = std::numeric_limits<std::uint32_t>::max();
  if (mesh.points.size() >= kLimit || mesh.triangles.size() >= kLimit / 3)
    throw Error(ErrorCode::failed, "the mesh has more than 2^32 points or corners of triangles; simplify it first");
  const std::vector<Triangle> faces = welded_faces(mesh);
  const EdgeFan fan(mesh, faces, signed_volume(mesh, faces) < 0);

  SurfaceAnalysis result;
  result.degenerate_faces = static_cast<std::int64_t>(mesh.triangles.size() - faces.size());
  base::UnionFind fans(3 * faces.size()), parts(mesh.points.size());
  std::int64_t edges = 0;
  bool manifold = true;
  for_each_edge(mesh.points.size(), faces, [&](std::uint32_t low, std::uint32_t high, std::span<const FaceSide> sides) {
    parts.unite(low, high);
    const auto up = std::count_if(sides.begin(), sides.end(), [&](const FaceSide& s) { return fan.upward(s); });
    result.boundary_edges += sides.size() == 1;
    result.odd_edges += sides.size() % 2 != 0;
    result.unbalanced_edges += 2 * static_cast<std::size_t>(up) != sides.size();
    manifold = manifold && sides.size() == 2 && up == 1;
    edges += fan.join(low, sides, fans);
  });
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

}  // namespace quench::voxelization

quench::SurfaceTopology quench::surface_topology(const TriangleMesh& mesh) {
  return voxelization::analyze_surface(mesh).topology;
}
