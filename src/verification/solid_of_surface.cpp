// SPDX-License-Identifier: Apache-2.0
#include "verification/solid_of_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <vector>

#include "base/union_find.h"

namespace quench::verification {

namespace {

// Per point the first one at the same place.
std::vector<std::uint32_t> first_there(const std::vector<Vec3>& points) {
  std::vector<std::uint32_t> order(points.size()), first(points.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto key = [&](std::uint32_t i) { return std::array{points[i][0], points[i][1], points[i][2]}; };
  std::sort(order.begin(), order.end(), [&](std::uint32_t i, std::uint32_t j) { return key(i) < key(j); });
  for (std::size_t i = 0; i < order.size(); ++i)
    first[order[i]] = i > 0 && key(order[i]) == key(order[i - 1]) ? first[order[i - 1]] : order[i];
  return first;
}

struct Side {
  std::array<std::uint32_t, 2> ends;  // ascending
  std::uint32_t corner;               // it goes on from, three per triangle
  bool upward;
};

}  // namespace

std::optional<Topology> solid_topology(const TriangleMesh& surface) {
  const std::vector<std::uint32_t> first = first_there(surface.points);
  const std::size_t triangles = surface.triangles.size();
  std::vector<Side> sides;
  for (std::uint32_t t = 0; t < triangles; ++t)
    for (std::uint32_t i = 0; i < 3; ++i) {
      const std::uint32_t a = first[surface.triangles[t][i]], b = first[surface.triangles[t][(i + 1) % 3]];
      if (a == b) return std::nullopt;
      sides.push_back({{std::min(a, b), std::max(a, b)}, 3 * t + i, a < b});
    }
  std::sort(sides.begin(), sides.end(), [](const Side& s, const Side& t) { return s.ends < t.ends; });
  const auto next = [](std::uint32_t corner) { return corner % 3 == 2 ? corner - 2 : corner + 1; };
  base::UnionFind fans(3 * triangles), parts(triangles);
  for (std::size_t i = 0; i < sides.size(); i += 2) {
    if (i + 1 == sides.size() || sides[i].ends != sides[i + 1].ends || sides[i].upward == sides[i + 1].upward ||
        (i + 2 < sides.size() && sides[i + 2].ends == sides[i].ends))
      return std::nullopt;
    const std::uint32_t a = sides[i].corner, b = sides[i + 1].corner;
    fans.unite(a, next(b));
    fans.unite(next(a), b);
    parts.unite(a / 3, b / 3);
  }
  std::vector<double> volume(triangles, 0);
  const Vec3 origin = surface.points.empty() ? Vec3::Zero() : surface.points[0];
  for (std::uint32_t t = 0; t < triangles; ++t) {
    const auto& [a, b, c] = surface.triangles[t];
    volume[parts.find(t)] +=
        (surface.points[a] - origin).dot((surface.points[b] - origin).cross(surface.points[c] - origin));
  }
  Topology solid;
  for (std::uint32_t t = 0; t < triangles; ++t)
    if (parts.find(t) == t) ++solid.betti[volume[t] > 0 ? 0 : 2];
  solid.euler = (fans.count() - static_cast<std::int64_t>(sides.size() / 2 - triangles)) / 2;
  solid.betti[1] = solid.betti[0] + solid.betti[2] - solid.euler;
  return solid;
}

}  // namespace quench::verification
