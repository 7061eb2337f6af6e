// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "base/parallel.h"
#include "quench/shape.h"

namespace quench {
namespace {

/// The neighbours of every vertex of a closed surface.
struct Neighbours {
  std::vector<std::uint32_t> begin, vertex;

  explicit Neighbours(const TriangleMesh& mesh) : begin(mesh.points.size() + 2, 0), vertex(3 * mesh.triangles.size()) {
    for (const auto& t : mesh.triangles)
      for (const std::uint32_t corner : t) ++begin[corner + 2];
    for (std::size_t v = 2; v < begin.size(); ++v) begin[v] += begin[v - 1];
    for (const auto& t : mesh.triangles)
      for (std::size_t i = 0; i < 3; ++i) vertex[begin[t[i] + 1]++] = t[(i + 1) % 3];
    begin.pop_back();
  }
  Vec3 mean(const std::vector<Vec3>& of, std::size_t v) const {
    Vec3 sum = Vec3::Zero();
    for (std::uint32_t i = begin[v]; i < begin[v + 1]; ++i) sum += of[vertex[i]];
    return sum / static_cast<double>(begin[v + 1] - begin[v]);
  }
};

double envd(const char* n, double d) {
  const char* e = std::getenv(n);
  return e ? std::atof(e) : d;
}

std::vector<double> coefficients(double theta, int terms) {
  std::vector<double> c;
  double sum = 0, slope = 0;
  for (int n = 0; n <= terms; ++n) {
    const double x = M_PI * n / (terms + 1);
    const double window = n ? std::pow(std::sin(x) / x, envd("WP", 1)) : 1;
    c.push_back((n ? 2 * std::sin(n * theta) / (n * M_PI) : theta / M_PI) * window);
    sum += c.back();
  }
  for (int n = 0; n <= terms; ++n) slope += (c[n] /= sum) * n * n;
  c[1] -= slope;
  c[0] += slope;
  return c;
}

}  // namespace

void smooth_surface(TriangleMesh& surface, Context* context) {
  const double reach = envd("SM", 0.45);
  const Neighbours near(surface);
  const std::size_t n = surface.points.size();
  const auto c = coefficients(std::acos(1 - envd("KPB", 0.15)), static_cast<int>(envd("TERMS", 12)));
  std::vector<Vec3> before = surface.points, now(n), sum(n);
  base::in_arena(context, [&] {
    base::for_indices(n, [&](std::size_t v) {
      now[v] = near.mean(before, v);
      sum[v] = c[0] * before[v] + c[1] * now[v];
    });
    for (std::size_t term = 2; term < c.size(); ++term) {
      std::vector<Vec3>& next = before;  // T(n + 1) takes the place of T(n - 1)
      base::for_indices(n, [&](std::size_t v) {
        next[v] = 2 * near.mean(now, v) - before[v];
        sum[v] += c[term] * next[v];
      });
      std::swap(before, now);
    }
    const double offset = envd("OFF", 0);
    base::for_indices(n, [&](std::size_t v) {
      double d2 = 0;
      for (std::uint32_t i = near.begin[v]; i < near.begin[v + 1]; ++i)
        d2 += (sum[near.vertex[i]] - sum[v]).squaredNorm();
      d2 /= near.begin[v + 1] - near.begin[v];
      now[v] = sum[v] - offset * 4 / d2 * (near.mean(sum, v) - sum[v]);
      const Vec3& start = surface.points[v];
      now[v] = now[v].cwiseMin(start + Vec3::Constant(reach)).cwiseMax(start - Vec3::Constant(reach));
    });
  });
  surface.points = std::move(now);
}

}  // namespace quench
