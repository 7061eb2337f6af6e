// SPDX-License-Identifier: Apache-2.0
#include "envelope/surface_places.h"

#include <tbb/parallel_sort.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/parallel.h"

namespace quench::envelope {

std::vector<Vec3> places_on(const TriangleMesh& mesh, std::size_t count) {
  std::vector<double> until(mesh.triangles.size());
  double area = 0;
  for (std::size_t t = 0; t < until.size(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    area += (mesh.points[b] - mesh.points[a]).cross(mesh.points[c] - mesh.points[a]).norm();
    until[t] = area;
  }
  std::vector<Vec3> places;
  if (!(area > 0)) return places;
  places.reserve(count);
  constexpr double kFirst = 0.7548776662466927, kSecond = 0.5698402909980532;  // powers of 1 / 1.32471795724...
  for (std::size_t i = 0, t = 0; i < count; ++i) {
    const double at = (static_cast<double>(i) + 0.5) / static_cast<double>(count) * area;
    while (t + 1 < until.size() && until[t] < at) ++t;
    double whole, u = std::modf(static_cast<double>(i + 1) * kFirst, &whole),
                  v = std::modf(static_cast<double>(i + 1) * kSecond, &whole);
    if (u + v > 1) {
      u = 1 - u;
      v = 1 - v;
    }
    const auto& [a, b, c] = mesh.triangles[t];
    places.push_back(mesh.points[a] + u * (mesh.points[b] - mesh.points[a]) + v * (mesh.points[c] - mesh.points[a]));
  }
  return places;
}

DistanceFigures figures_of(std::vector<Weighted>& values) {
  DistanceFigures figures;
  if (values.empty()) return figures;
  tbb::parallel_sort(values.begin(), values.end());
  double weight = 0, sum = 0;
  for (const Weighted& v : values) {
    weight += v.weight;
    sum += v.weight * v.value;
  }
  figures.mean = weight > 0 ? sum / weight : 0;
  figures.largest = values.back().value;
  double until = 0;
  for (const Weighted& v : values) {
    until += v.weight;
    figures.p99 = v.value;
    if (until >= 0.99 * weight) break;
  }
  return figures;
}

}  // namespace quench::envelope

namespace quench {

OneSidedDistances distances_from_envelope(const Surface& surface, const Envelope& envelope, std::size_t places,
                                          Context* context) {
  const TriangleMesh& mesh = surface.mesh();
  std::vector<Vec3> points = envelope::places_on(mesh, places);
  const std::size_t even = points.size();
  points.insert(points.end(), mesh.points.begin(), mesh.points.end());
  std::vector<double> distance(points.size());
  base::in_arena(context, [&] {
    const std::size_t chunks = base::chunks_for(points.size(), 1024);
    base::for_chunks(chunks, context, "errors", 0, 1, [&](std::size_t chunk) {
      const auto [first, last] = base::part_of(points.size(), chunk, chunks);
      for (std::size_t i = first; i < last; ++i) distance[i] = envelope.distance(points[i]);
    });
  });
  OneSidedDistances result;
  result.places = even;
  std::vector<envelope::Weighted> outside(even), either(even);
  for (std::size_t i = 0; i < even; ++i) {
    outside[i] = {std::max(0.0, distance[i]), 1};
    either[i] = {std::abs(distance[i]), 1};
  }
  result.outside = envelope::figures_of(outside);
  result.either = envelope::figures_of(either);
  for (std::size_t i = even; i < distance.size(); ++i) {
    result.outside.largest = std::max(result.outside.largest, distance[i]);
    result.either.largest = std::max(result.either.largest, std::abs(distance[i]));
  }
  return result;
}

}  // namespace quench
