// SPDX-License-Identifier: Apache-2.0
#include "shape/surface_sides.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <limits>

#include "base/parallel.h"

namespace quench::shape {
namespace {

/// The point of a triangle that is nearest to p (Ericson, Real-Time Collision Detection, 2005).
Vec3 nearest_in(const std::array<Vec3, 3>& t, const Vec3& p) {
  const Vec3 ab = t[1] - t[0], ac = t[2] - t[0], ap = p - t[0];
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return t[0];
  const Vec3 bp = p - t[1];
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return t[1];
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return t[0] + d1 / (d1 - d3) * ab;
  const Vec3 cp = p - t[2];
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return t[2];
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return t[0] + d2 / (d2 - d6) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return t[1] + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (t[2] - t[1]);
  return t[0] + (vb * ab + vc * ac) / (va + vb + vc);
}

/// Calls visit(way from the triangle to it) for the voxel centres at the corners of its cell.
template <class Visit>
void for_centres(const std::array<Vec3, 3>& triangle, const Visit& visit) {
  const Vec3 middle = (triangle[0] + triangle[1] + triangle[2]) / 3;
  const Vec3 cell = (middle - Vec3::Constant(0.5)).array().floor() + 0.5;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 centre = cell + Vec3(corner & 1, corner >> 1 & 1, corner >> 2);
    visit(Vec3(centre - nearest_in(triangle, centre)));
  }
}

void lower(float& place, float value) {
  const std::atomic_ref<float> shared(place);
  float old = shared.load(std::memory_order_relaxed);
  while (value < old && !shared.compare_exchange_weak(old, value, std::memory_order_relaxed)) {
  }
}

void shorten(const TriangleMesh& surface, const std::vector<float>& share, std::vector<Vec3>& moved) {
  base::for_indices(moved.size(), [&](std::size_t v) {
    moved[v] = surface.points[v] + static_cast<double>(share[v]) * (moved[v] - surface.points[v]);
  });
}

}  // namespace

// The triangle lies on one side of the plane through its point nearest to the centre, across the way to it; it does not
// reach the centre while none of its corners moves along the way by more than its length. Centres of other cells are
// too far away.
void keep_sides(const TriangleMesh& surface, std::vector<Vec3>& moved) {
  constexpr double kShare = 0.98;  // of a way to a centre
  std::vector<float> share(moved.size(), 1);
  base::for_indices(surface.triangles.size(), [&](std::size_t t) {
    const auto& corners = surface.triangles[t];
    const std::array<Vec3, 3> triangle{surface.points[corners[0]], surface.points[corners[1]],
                                       surface.points[corners[2]]};
    for_centres(triangle, [&](const Vec3& way) {
      const double most = kShare * way.squaredNorm();
      for (std::size_t i = 0; i < 3; ++i)
        if (const double along = way.dot(moved[corners[i]] - triangle[i]); along > most)
          lower(share[corners[i]], static_cast<float>(most / along));
    });
  });
  shorten(surface, share, moved);
}

// Ways are halved, and given up in the end, where a triangle turns by more than about 80 degrees.
void keep_faces_up(const TriangleMesh& surface, std::vector<Vec3>& moved) {
  constexpr int kRounds = 4;
  constexpr double kUp = 0.2;  // cosine
  for (int round = 0; round < kRounds; ++round) {
    std::vector<float> share(moved.size(), 1);
    base::for_indices(surface.triangles.size(), [&](std::size_t t) {
      const auto& corners = surface.triangles[t];
      const auto normal = [&](const std::vector<Vec3>& p) -> Vec3 {
        return (p[corners[1]] - p[corners[0]]).cross(p[corners[2]] - p[corners[0]]);
      };
      const Vec3 before = normal(surface.points), after = normal(moved);
      if (before.dot(after) >= kUp * before.norm() * after.norm()) return;
      for (const std::uint32_t corner : surface.triangles[t]) lower(share[corner], round + 1 < kRounds ? 0.5F : 0.0F);
    });
    shorten(surface, share, moved);
  }
}

double distance_to_centres(const std::array<Vec3, 3>& triangle) {
  double nearest = std::numeric_limits<double>::infinity();
  for_centres(triangle, [&](const Vec3& way) { nearest = std::min(nearest, way.norm()); });
  return nearest;
}

}  // namespace quench::shape
