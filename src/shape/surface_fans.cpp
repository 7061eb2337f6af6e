// SPDX-License-Identifier: Apache-2.0
#include "shape/surface_fans.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "shape/surface_sides.h"

namespace quench::shape {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

/// The triangles of a loop of three or four vertices without the one inside, written over those of the fan; their
/// number, 0 where that one is not near enough.
std::size_t flattened(std::span<Triangle> fan, const std::vector<Vec3>& points, double tolerance) {
  const auto p = [&](std::size_t i) -> const Vec3& { return points[fan[i][0]]; };
  const auto is_clear = [&](const std::array<Vec3, 3>& triangle) {  // of voxel centres, which stay on their side
    return distance_to_centres(triangle) > 3 * tolerance;
  };
  const Vec3& middle = points[fan[0][2]];
  if (fan.size() == 3) {
    const Vec3 normal = (p(1) - p(0)).cross(p(2) - p(0)).normalized();
    if (!(std::abs(normal.dot(middle - p(0))) <= tolerance) || !is_clear({p(0), p(1), p(2)})) return 0;
    fan[0] = {fan[0][0], fan[1][0], fan[2][0]};
    return 1;
  }
  const Vec3 normal = (p(2) - p(0)).cross(p(3) - p(1)).normalized();
  const double first = std::abs(normal.dot(middle - p(0))), second = std::abs(normal.dot(middle - p(1)));
  if (!(std::max(first, second) <= tolerance)) return 0;
  const std::array<std::uint32_t, 4> loop{fan[0][0], fan[1][0], fan[2][0], fan[3][0]};
  const std::size_t start = first <= second ? 0 : 1;  // of the diagonal nearer to the vertex inside
  const std::size_t last = (start + 3) & 3;
  if (!is_clear({p(start), p(start + 1), p(start + 2)}) || !is_clear({p(start), p(start + 2), p(last)})) return 0;
  fan[0] = {loop[start], loop[start + 1], loop[start + 2]};
  fan[1] = {loop[start], loop[start + 2], loop[last]};
  return 2;
}

}  // namespace

SurfaceFans::SurfaceFans(const TriangleMesh& mesh) : fan_of_(mesh.triangles.size(), kNone) {
  for (std::uint32_t t = 0; t < fan_of_.size(); ++t) {
    const std::uint32_t middle = mesh.triangles[t][2];
    if (!is_inside_cell(mesh.points[middle])) continue;
    if (fans_.empty() || fans_.back().middle != middle) fans_.push_back({middle, t, 0});
    ++fans_.back().size;
    fan_of_[t] = static_cast<std::uint32_t>(fans_.size() - 1);
  }
  list_rims(mesh);
  neighbour_.assign(fan_of_.size(), kNone);
  for (std::uint32_t t = 0; t < fan_of_.size(); ++t) {
    if (fan_of_[t] == kNone) continue;
    const std::uint32_t from = mesh.triangles[t][0], to = mesh.triangles[t][1];
    for (std::uint32_t i = begin_[to]; i < begin_[to + 1]; ++i)
      if (mesh.triangles[rim_[i]][1] == from) neighbour_[t] = fan_of_[rim_[i]];
  }
}

void SurfaceFans::list_rims(const TriangleMesh& mesh) {
  begin_.assign(mesh.points.size() + 2, 0);
  for (std::size_t t = 0; t < fan_of_.size(); ++t)
    if (fan_of_[t] != kNone) ++begin_[mesh.triangles[t][0] + 2];
  for (std::size_t v = 2; v < begin_.size(); ++v) begin_[v] += begin_[v - 1];
  rim_.resize(begin_.back());
  for (std::uint32_t t = 0; t < fan_of_.size(); ++t)
    if (fan_of_[t] != kNone) rim_[begin_[mesh.triangles[t][0] + 1]++] = t;
  begin_.pop_back();
}

// A diagonal between two vertices in one face of a cell might be there in the neighbouring cell too, so only loops of
// three and four vertices, which have none, can do without a vertex inside.
void flatten_fans(TriangleMesh& mesh, const SurfaceFans& fans, double tolerance) {
  std::size_t kept = 0, next = 0;
  const auto keep = [&](std::size_t from, std::size_t count) {
    std::copy_n(mesh.triangles.begin() + static_cast<std::ptrdiff_t>(from), count,
                mesh.triangles.begin() + static_cast<std::ptrdiff_t>(kept));
    kept += count;
  };
  for (const SurfaceFans::Fan& fan : fans.fans()) {
    keep(next, fan.first - next);  // tubes
    next = fan.first + fan.size;
    std::size_t count = 0;
    if (fan.size <= 4) count = flattened({mesh.triangles.data() + fan.first, fan.size}, mesh.points, tolerance);
    keep(fan.first, count > 0 ? count : fan.size);
  }
  keep(next, mesh.triangles.size() - next);
  mesh.triangles.resize(kept);
  drop_unused_points(mesh);
}

void drop_unused_points(TriangleMesh& mesh) {
  std::vector<std::uint32_t> place(mesh.points.size(), kNone);
  for (const Triangle& triangle : mesh.triangles)
    for (const std::uint32_t corner : triangle) place[corner] = 0;
  std::uint32_t kept = 0;
  for (std::size_t v = 0; v < place.size(); ++v) {
    if (place[v] == kNone) continue;
    mesh.points[kept] = mesh.points[v];
    place[v] = kept++;
  }
  mesh.points.resize(kept);
  for (Triangle& triangle : mesh.triangles)
    for (std::uint32_t& corner : triangle) corner = place[corner];
}

}  // namespace quench::shape
