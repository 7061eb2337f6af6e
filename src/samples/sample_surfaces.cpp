// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <numbers>

#include "samples/sample_shapes.h"

namespace quench::samples {

std::uint32_t LatticeSurface::vertex(const LatticePoint& p) {
  std::uint64_t key = 0;
  for (const std::int32_t c : p) key = key << 21 | static_cast<std::uint64_t>(c);
  const auto [it, added] = index_.emplace(key, static_cast<std::uint32_t>(mesh_.points.size()));
  if (added) mesh_.points.push_back(place_(p));
  return it->second;
}

void LatticeSurface::add_side(LatticePoint cell, int axis, bool upper) {
  const auto a = static_cast<std::size_t>(axis), u = (a + 1) % 3, v = (a + 2) % 3;
  cell[a] += upper;
  std::array<std::uint32_t, 4> corner{};
  for (std::size_t c = 0; c < 4; ++c) {
    LatticePoint p = cell;
    p[u] += c == 1 || c == 2;
    p[v] += c >= 2;
    corner[c] = vertex(p);
  }
  if (!upper) std::swap(corner[1], corner[3]);
  // The shorter diagonal, so that a curved surface is met best.
  const auto length = [&](std::size_t i, std::size_t j) {
    return (mesh_.points[corner[i]] - mesh_.points[corner[j]]).squaredNorm();
  };
  const std::size_t s = length(0, 2) <= length(1, 3) ? 0 : 1;
  mesh_.triangles.push_back({corner[s], corner[s + 1], corner[s + 2]});
  mesh_.triangles.push_back({corner[s], corner[s + 2], corner[(s + 3) % 4]});
}

TriangleMesh box_surface(const LatticePoint& counts, const std::function<Vec3(const LatticePoint&)>& place) {
  LatticeSurface surface(place);
  for (std::size_t a = 0; a < 3; ++a) {
    const std::size_t u = (a + 1) % 3, v = (a + 2) % 3;
    for (std::int32_t i = 0; i < counts[u]; ++i)
      for (std::int32_t j = 0; j < counts[v]; ++j)
        for (const bool upper : {false, true}) {
          LatticePoint cell;
          cell[a] = upper ? counts[a] - 1 : 0;
          cell[u] = i;
          cell[v] = j;
          surface.add_side(cell, static_cast<int>(a), upper);
        }
  }
  return surface.take();
}

TriangleMesh cells_surface(const LatticePoint& counts, const std::function<bool(const LatticePoint&)>& inside,
                           const std::function<Vec3(const LatticePoint&)>& place) {
  LatticeSurface surface(place);
  const auto in = [&](const LatticePoint& c) {
    for (std::size_t a = 0; a < 3; ++a)
      if (c[a] < 0 || c[a] >= counts[a]) return false;
    return inside(c);
  };
  for (std::int32_t z = 0; z < counts[2]; ++z)
    for (std::int32_t y = 0; y < counts[1]; ++y)
      for (std::int32_t x = 0; x < counts[0]; ++x) {
        const LatticePoint cell{x, y, z};
        if (!in(cell)) continue;
        for (std::size_t a = 0; a < 3; ++a)
          for (const bool upper : {false, true}) {
            LatticePoint other = cell;
            other[a] += upper ? 1 : -1;
            if (!in(other)) surface.add_side(cell, static_cast<int>(a), upper);
          }
      }
  return surface.take();
}

TriangleMesh sphere(int n, const std::function<Vec3(const Vec3&)>& place) {
  return box_surface({n, n, n}, [&](const LatticePoint& p) {
    Vec3 d;
    for (int a = 0; a < 3; ++a) {
      // Mirrored counts give mirrored coordinates to the last bit.
      const int centred = 2 * p[static_cast<std::size_t>(a)] - n;
      d[a] = std::tan(std::numbers::pi / 4 * centred / n);
    }
    return place(d.normalized());
  });
}

void append_tube(TriangleMesh& mesh, std::span<const Ring> rings, int around) {
  const auto count = static_cast<std::uint32_t>(around);
  const auto first = static_cast<std::uint32_t>(mesh.points.size());
  mesh.points.push_back(rings.front().centre);
  for (const Ring& ring : rings.subspan(1, rings.size() - 2))
    for (std::uint32_t k = 0; k < count; ++k) {
      const double angle = 2 * std::numbers::pi * k / around;
      mesh.points.push_back(ring.centre +
                            ring.radius * (std::cos(angle) * ring.normal + std::sin(angle) * ring.binormal));
    }
  const auto last = static_cast<std::uint32_t>(mesh.points.size());
  mesh.points.push_back(rings.back().centre);
  const auto inner = static_cast<std::uint32_t>(rings.size()) - 2;
  const auto at = [&](std::uint32_t ring, std::uint32_t k) { return first + 1 + ring * count + k % count; };
  for (std::uint32_t k = 0; k < count; ++k) {
    mesh.triangles.push_back({first, at(0, k + 1), at(0, k)});
    for (std::uint32_t r = 0; r + 1 < inner; ++r) {
      mesh.triangles.push_back({at(r, k), at(r, k + 1), at(r + 1, k + 1)});
      mesh.triangles.push_back({at(r, k), at(r + 1, k + 1), at(r + 1, k)});
    }
    mesh.triangles.push_back({last, at(inner - 1, k), at(inner - 1, k + 1)});
  }
}

void append(TriangleMesh& mesh, const TriangleMesh& part, bool reversed) {
  const auto shift = static_cast<std::uint32_t>(mesh.points.size());
  mesh.points.insert(mesh.points.end(), part.points.begin(), part.points.end());
  for (auto t : part.triangles) {
    if (reversed) std::swap(t[1], t[2]);
    mesh.triangles.push_back({t[0] + shift, t[1] + shift, t[2] + shift});
  }
}

int scaled(double count, double fineness, int least) {
  return std::max(least, static_cast<int>(std::lround(count * fineness)));
}

}  // namespace quench::samples
