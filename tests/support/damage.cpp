// SPDX-License-Identifier: Apache-2.0
#include "damage.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <numeric>
#include <random>

namespace quench::testing_damage {
namespace {

using Triangle = std::array<std::uint32_t, 3>;
using Random = std::mt19937_64;

double below_one(Random& random) { return static_cast<double>(random() >> 11) * 0x1p-53; }

struct Extent {
  Vec3 low, high;
  explicit Extent(const TriangleMesh& mesh) : low(mesh.points[0]), high(low) {
    for (const Vec3& p : mesh.points) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
  }
  double longest() const { return (high - low).maxCoeff(); }
};

Vec3 direction(Random& random) {
  Vec3 d;
  do
    for (int a = 0; a < 3; ++a) d[a] = 2 * below_one(random) - 1;
  while (d.norm() > 1 || d.norm() < 0.1);
  return d.normalized();
}

std::uint32_t any(Random& random, std::size_t n) { return static_cast<std::uint32_t>(random() % n); }

Vec3 middle(const TriangleMesh& mesh, const Triangle& t) {
  return (mesh.points[t[0]] + mesh.points[t[1]] + mesh.points[t[2]]) / 3;
}

template <class Keep>
TriangleMesh keep_faces(const TriangleMesh& clean, const Keep& keep) {
  TriangleMesh mesh;
  mesh.points = clean.points;
  for (const Triangle& t : clean.triangles)
    if (keep(t)) mesh.triangles.push_back(t);
  return mesh;
}

template <int percent>
TriangleMesh remove_faces(const TriangleMesh& clean, std::uint64_t seed) {
  Random random(seed);
  return keep_faces(clean, [&](const Triangle&) { return below_one(random) >= percent / 100.0; });
}

TriangleMesh remove_one(const TriangleMesh& clean, std::uint64_t seed) {
  Random random(seed);
  TriangleMesh mesh = clean;
  mesh.triangles.erase(mesh.triangles.begin() + any(random, mesh.triangles.size()));
  return mesh;
}

/// All faces within 6 % of the longest side of three places.
TriangleMesh round_holes(const TriangleMesh& clean, std::uint64_t seed) {
  Random random(seed);
  std::array<Vec3, 3> places;
  for (Vec3& p : places) p = clean.points[clean.triangles[any(random, clean.triangles.size())][0]];
  const double reach = 0.06 * Extent(clean).longest();
  return keep_faces(clean, [&](const Triangle& t) {
    return std::none_of(places.begin(), places.end(),
                        [&](const Vec3& p) { return (middle(clean, t) - p).norm() < reach; });
  });
}

/// All faces beyond a plane near one end.
TriangleMesh delete_cap(const TriangleMesh& clean, std::uint64_t seed) {
  Random random(seed);
  const Vec3 d = direction(random);
  double low = d.dot(clean.points[0]), high = low;
  for (const Vec3& p : clean.points) {
    low = std::min(low, d.dot(p));
    high = std::max(high, d.dot(p));
  }
  return keep_faces(clean, [&](const Triangle& t) { return d.dot(middle(clean, t)) < high - 0.05 * (high - low); });
}

TriangleMesh flip_half(const TriangleMesh& clean, std::uint64_t seed) {
  Random random(seed);
  TriangleMesh mesh = clean;
  for (Triangle& t : mesh.triangles)
    if (random() % 2) std::swap(t[0], t[1]);
  return mesh;
}

TriangleMesh flip_tenth(const TriangleMesh& clean, std::uint64_t seed) {
  Random random(seed);
  TriangleMesh mesh = clean;
  for (Triangle& t : mesh.triangles)
    if (random() % 10 == 0) std::swap(t[0], t[1]);
  return mesh;
}

TriangleMesh flip_all(const TriangleMesh& clean, std::uint64_t) {
  TriangleMesh mesh = clean;
  for (Triangle& t : mesh.triangles) std::swap(t[0], t[1]);
  return mesh;
}

TriangleMesh duplicate(const TriangleMesh& clean, std::uint64_t seed) {
  Random random(seed);
  TriangleMesh mesh = clean;
  for (const Triangle& t : clean.triangles)
    if (random() % 4 == 0) mesh.triangles.push_back({t[1], t[2], t[0]});
  return mesh;
}

TriangleMesh duplicate_opposite(const TriangleMesh& clean, std::uint64_t seed) {
  Random random(seed);
  TriangleMesh mesh = clean;
  for (const Triangle& t : clean.triangles)
    if (random() % 10 == 0) mesh.triangles.push_back({t[1], t[0], t[2]});
  return mesh;
}

TriangleMesh soup(const TriangleMesh& clean, std::uint64_t) {
  TriangleMesh mesh;
  for (const Triangle& t : clean.triangles) {
    const auto n = static_cast<std::uint32_t>(mesh.points.size());
    for (const std::uint32_t p : t) mesh.points.push_back(clean.points[p]);
    mesh.triangles.push_back({n, n + 1, n + 2});
  }
  return mesh;
}

/// Every face on its own, its corners moved by up to a thousandth of the longest side: cracks everywhere.
TriangleMesh jitter(const TriangleMesh& clean, std::uint64_t seed) {
  Random random(seed);
  TriangleMesh mesh = soup(clean, seed);
  const double size = 0.001 * Extent(clean).longest();
  for (Vec3& p : mesh.points) p += size * below_one(random) * direction(random);
  return mesh;
}

/// Cracks along a quarter of the faces: their corners are points of their own, moved slightly.
TriangleMesh cracks(const TriangleMesh& clean, std::uint64_t seed) {
  Random random(seed);
  TriangleMesh mesh = clean;
  const double size = 0.0005 * Extent(clean).longest();
  for (Triangle& t : mesh.triangles) {
    if (random() % 4) continue;
    for (std::uint32_t& corner : t) {
      mesh.points.emplace_back(mesh.points[corner] + size * direction(random));
      corner = static_cast<std::uint32_t>(mesh.points.size() - 1);
    }
  }
  return mesh;
}

/// Faces between points of the surface: they cross the inside.
TriangleMesh internal_faces(const TriangleMesh& clean, std::uint64_t seed) {
  Random random(seed);
  TriangleMesh mesh = clean;
  const double reach = 0.1 * Extent(clean).longest();
  for (int added = 0; added < 20;) {
    const Triangle t = clean.triangles[any(random, clean.triangles.size())];
    const Vec3 normal =
        (clean.points[t[1]] - clean.points[t[0]]).cross(clean.points[t[2]] - clean.points[t[0]]).normalized();
    if (!normal.allFinite()) continue;
    ++added;
    const auto n = static_cast<std::uint32_t>(mesh.points.size());
    mesh.points.emplace_back(middle(clean, t) - 0.3 * reach * normal);
    mesh.triangles.push_back({t[0], t[1], n});
  }
  return mesh;
}

/// Two parts that share a band of faces, with points of their own.
TriangleMesh overlapping_halves(const TriangleMesh& clean, std::uint64_t) {
  const Extent extent(clean);
  int axis = 0;
  (extent.high - extent.low).maxCoeff(&axis);
  const double cut = (extent.low[axis] + extent.high[axis]) / 2, band = 0.02 * extent.longest();
  TriangleMesh mesh = keep_faces(clean, [&](const Triangle& t) { return middle(clean, t)[axis] < cut + band; });
  const TriangleMesh other = keep_faces(clean, [&](const Triangle& t) { return middle(clean, t)[axis] > cut - band; });
  const auto base = static_cast<std::uint32_t>(mesh.points.size());
  mesh.points.insert(mesh.points.end(), other.points.begin(), other.points.end());
  for (const Triangle& t : other.triangles) mesh.triangles.push_back({base + t[0], base + t[1], base + t[2]});
  return mesh;
}

TriangleMesh degenerate_faces(const TriangleMesh& clean, std::uint64_t seed) {
  Random random(seed);
  TriangleMesh mesh = clean;
  for (int i = 0; i < 100; ++i) {
    const Triangle t = clean.triangles[any(random, clean.triangles.size())];
    mesh.triangles.push_back({t[0], t[0], t[1]});
    mesh.points.emplace_back((mesh.points[t[0]] + mesh.points[t[1]]) / 2);  // and slivers of no area
    mesh.triangles.push_back({t[0], t[1], static_cast<std::uint32_t>(mesh.points.size() - 1)});
  }
  return mesh;
}

/// Faces that stand on edges of the surface, outside.
TriangleMesh fins(const TriangleMesh& clean, std::uint64_t seed) {
  Random random(seed);
  TriangleMesh mesh = clean;
  const double height = 0.02 * Extent(clean).longest();
  for (int i = 0; i < 50; ++i) {
    const Triangle t = clean.triangles[any(random, clean.triangles.size())];
    const Vec3 normal =
        (clean.points[t[1]] - clean.points[t[0]]).cross(clean.points[t[2]] - clean.points[t[0]]).normalized();
    if (!normal.allFinite()) continue;
    const auto n = static_cast<std::uint32_t>(mesh.points.size());
    mesh.points.emplace_back((clean.points[t[0]] + clean.points[t[1]]) / 2 + height * normal);
    mesh.triangles.push_back({t[0], t[1], n});
  }
  return mesh;
}

TriangleMesh unreferenced(const TriangleMesh& clean, std::uint64_t seed) {
  Random random(seed);
  TriangleMesh mesh = clean;
  for (int i = 0; i < 100; ++i) mesh.points.emplace_back(1000 * direction(random));
  return mesh;
}

/// Faces halved at an edge whose other face keeps it whole.
TriangleMesh t_junctions(const TriangleMesh& clean, std::uint64_t seed) {
  Random random(seed);
  TriangleMesh mesh = clean;
  for (std::size_t f = 0; f < clean.triangles.size(); ++f) {
    if (random() % 5) continue;
    const Triangle t = clean.triangles[f];
    const auto n = static_cast<std::uint32_t>(mesh.points.size());
    mesh.points.emplace_back((mesh.points[t[0]] + mesh.points[t[1]]) / 2);
    mesh.triangles[f] = {t[0], n, t[2]};
    mesh.triangles.push_back({n, t[1], t[2]});
  }
  return mesh;
}

/// Single faces floating about, within the box.
TriangleMesh islands(const TriangleMesh& clean, std::uint64_t seed) {
  Random random(seed);
  TriangleMesh mesh = clean;
  const Extent extent(clean);
  const double size = 0.02 * extent.longest();
  for (int i = 0; i < 30; ++i) {
    Vec3 p;
    for (int a = 0; a < 3; ++a)
      p[a] = extent.low[a] + size + (extent.high[a] - extent.low[a] - 2 * size) * below_one(random);
    const auto n = static_cast<std::uint32_t>(mesh.points.size());
    for (int k = 0; k < 3; ++k) mesh.points.emplace_back(p + size * direction(random));
    mesh.triangles.push_back({n, n + 1, n + 2});
  }
  return mesh;
}

TriangleMesh flip_half_with_holes(const TriangleMesh& clean, std::uint64_t seed) {
  return flip_half(round_holes(clean, seed), seed + 1);
}

/// A second shell just outside of a third of the surface, the same way around.
TriangleMesh double_shell(const TriangleMesh& clean, std::uint64_t) {
  const Extent extent(clean);
  TriangleMesh mesh = clean;
  const auto base = static_cast<std::uint32_t>(mesh.points.size());
  const Vec3 centre = (extent.low + extent.high) / 2;
  int axis = 0;
  (extent.high - extent.low).maxCoeff(&axis);
  for (const Vec3& p : clean.points) mesh.points.emplace_back(centre + 0.998 * (p - centre));
  for (const Triangle& t : clean.triangles)
    if (middle(clean, t)[axis] < extent.low[axis] + (extent.high[axis] - extent.low[axis]) / 3)
      mesh.triangles.push_back({base + t[0], base + t[1], base + t[2]});
  return mesh;
}

}  // namespace

TriangleMesh pinned(TriangleMesh mesh, const TriangleMesh& clean) {
  const Extent extent(clean);
  const Vec3 more = Vec3::Constant(0.03 * extent.longest());
  for (const Vec3& p : {Vec3(extent.low - more), Vec3(extent.high + more)}) {
    const auto n = static_cast<std::uint32_t>(mesh.points.size());
    mesh.points.push_back(p);
    mesh.triangles.push_back({n, n, n});
  }
  return mesh;
}

const std::vector<Damage>& damages() {
  static const std::vector<Damage> list{
      {"one face missing", remove_one, 0.005, false},
      {"1 % of faces missing", remove_faces<1>, 0.005, false},
      {"5 % of faces missing", remove_faces<5>, 0.01, false},
      {"20 % of faces missing", remove_faces<20>, 0.03, false},
      {"three round holes", round_holes, 0.03, false, Damage::Otherwise::missing},
      {"a cap missing", delete_cap, 0.06, false, Damage::Otherwise::missing},
      {"10 % of faces flipped", flip_tenth, 0, true},
      {"half of faces flipped", flip_half, 0, true},
      {"all faces flipped", flip_all, 0, true},
      {"half flipped, three holes", flip_half_with_holes, 0.03, false, Damage::Otherwise::missing},
      {"25 % of faces twice", duplicate, 0, true},
      {"10 % of faces twice, opposite", duplicate_opposite, 0, true},
      {"soup: no shared points", soup, 0, true},
      {"soup, points moved", jitter, 0.02, false, Damage::Otherwise::moved},
      {"cracks", cracks, 0.01, false},
      {"internal faces", internal_faces, 0.005, false},
      {"overlapping halves", overlapping_halves, 0.01, false},
      {"second shell on a third", double_shell, 0.03, false},
      {"degenerate faces", degenerate_faces, 0.001, false},
      {"fins", fins, 0.005, false},
      {"unreferenced points", unreferenced, 0, true},
      {"T-junctions", t_junctions, 0.001, false},
      {"islands of one face", islands, 0.005, false},
  };
  return list;
}

}  // namespace quench::testing_damage
