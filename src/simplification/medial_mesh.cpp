// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <unordered_set>
#include <utility>

#include "quench/simplify.h"

namespace quench {
namespace {

void check_medial_mesh(const MedialAxis& axis) {
  if (axis.points.size() != axis.complex.vertex_count || axis.radius.size() != axis.points.size())
    throw Error(ErrorCode::usage, "a medial axis without a point and a radius per vertex has no envelope");
  for (std::size_t v = 0; v < axis.points.size(); ++v) {
    const double r = axis.radius[v];
    if (!(r >= 0 && r <= kLargestLength) || !axis.points[v].allFinite())
      throw Error(ErrorCode::usage, fmt::format("vertex {} of the medial axis has the radius {:g}, or no place: it is "
                                                "not the centre of a ball",
                                                v, r));
  }
}

/// Edges by their ends: those of the complex, and the diagonals that were made.
class EdgeSet {
 public:
  explicit EdgeSet(const CellComplex& complex) {
    known_.reserve(complex.edges.size() * 2);
    for (const auto& [a, b] : complex.edges) known_.insert(key(a, b));
  }
  bool has(std::uint32_t a, std::uint32_t b) const { return known_.contains(key(a, b)); }
  void add(std::uint32_t a, std::uint32_t b) { known_.insert(key(a, b)); }

 private:
  static std::uint64_t key(std::uint32_t a, std::uint32_t b) {
    return a < b ? std::uint64_t{a} << 32 | b : std::uint64_t{b} << 32 | a;
  }
  std::unordered_set<std::uint64_t> known_;
};

/// Whether the diagonals of a fan around corner `apex` are no edges yet.
bool is_fan_free(const EdgeSet& edges, std::span<const std::uint32_t> corners, std::size_t apex) {
  const std::size_t n = corners.size();
  for (std::size_t i = 2; i + 1 < n; ++i)
    if (edges.has(corners[apex], corners[(apex + i) % n])) return false;
  return true;
}

}  // namespace

MedialAxis medial_mesh_of(const MedialAxis& axis) {
  check_medial_mesh(axis);
  const CellComplex& from = axis.complex;
  MedialAxis mesh;
  mesh.grid = axis.grid;
  mesh.points = axis.points;
  mesh.radius = axis.radius;
  std::vector<std::uint32_t> offsets{0}, triangles;
  const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    triangles.insert(triangles.end(), {a, b, c});
    offsets.push_back(static_cast<std::uint32_t>(triangles.size()));
  };
  std::optional<EdgeSet> edges;
  for (std::size_t f = 0; f < from.face_count(); ++f) {
    const auto corners = from.corners(f);
    const std::size_t n = corners.size();
    if (n == 3) {
      add(corners[0], corners[1], corners[2]);
      continue;
    }
    if (!edges) edges.emplace(from);
    std::size_t apex = 0;
    while (apex < n && !is_fan_free(*edges, corners, apex)) ++apex;
    if (apex < n) {
      for (std::size_t i = 1; i + 1 < n; ++i) add(corners[apex], corners[(apex + i) % n], corners[(apex + i + 1) % n]);
      for (std::size_t i = 2; i + 1 < n; ++i) edges->add(corners[apex], corners[(apex + i) % n]);
      continue;
    }
    const auto centre = static_cast<std::uint32_t>(mesh.points.size());
    Vec3 point = Vec3::Zero();
    double radius = 0;
    for (const std::uint32_t v : corners) {
      point += axis.points[v] / static_cast<double>(n);
      radius += axis.radius[v] / static_cast<double>(n);
    }
    mesh.points.push_back(point);
    mesh.radius.push_back(radius);
    for (std::size_t i = 0; i < n; ++i) add(corners[i], corners[(i + 1) % n], centre);
  }
  mesh.complex = make_complex(static_cast<std::uint32_t>(mesh.points.size()), from.edges, std::move(offsets),
                              std::move(triangles));
  return mesh;
}

}  // namespace quench
