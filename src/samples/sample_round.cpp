// SPDX-License-Identifier: Apache-2.0
// Ellipsoid, torus, bumpy sphere, hollow sphere, four blobs. Default tessellations deviate from the smooth surface by
// less than 1/20 voxel at resolution 512.

#include "samples/sample_shapes.h"

namespace quench::samples {
namespace {}  // namespace

Sample ellipsoid(const SampleOptions& options) {
  const Vec3 axes(1, 0.7, 0.4);
  return {sphere(scaled(160, options.fineness, 2), [&](const Vec3& d) { return Vec3(axes.cwiseProduct(d)); }), {}};
}

Sample hollow_sphere(const SampleOptions& options) {
  Sample sample;
  sample.mesh = sphere(scaled(130, options.fineness, 2), [](const Vec3& d) { return d; });
  append(sample.mesh, sphere(scaled(90, options.fineness, 2), [](const Vec3& d) { return Vec3(0.55 * d); }), true);
  return sample;
}

Sample bumpy_sphere(const SampleOptions& options) {
  constexpr int kBumps = 60;
  const double height = 2 * (options.noise > 0 ? options.noise : 0.015);
  constexpr double kWidth = 0.11;  // standard deviation of a bump, as an angle
  // Directions of a golden spiral: evenly spread, without a pole.
  std::vector<Vec3> centres;
  for (int i = 0; i < kBumps; ++i) {
    const double z = 1 - (2 * i + 1.0) / kBumps, angle = i * kPi * (3 - std::sqrt(5.0));
    const double r = std::sqrt(1 - z * z);
    centres.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
  }
  return {sphere(scaled(180, options.fineness, 2),
                 [&](const Vec3& d) {
                   double radius = 1;
                   for (const Vec3& c : centres) radius += height * std::exp((d.dot(c) - 1) / (kWidth * kWidth));
                   return Vec3(radius * d);
                 }),
          {}};
}

Sample torus(const SampleOptions& options) {
  constexpr double R = 1, r = 0.35;
  const auto nu = static_cast<std::uint32_t>(scaled(600, options.fineness, 3));
  const auto nv = static_cast<std::uint32_t>(scaled(240, options.fineness, 3));
  Sample sample;
  TriangleMesh& mesh = sample.mesh;
  for (std::uint32_t i = 0; i < nu; ++i)
    for (std::uint32_t j = 0; j < nv; ++j) {
      const double u = 2 * kPi * i / nu, v = 2 * kPi * j / nv;
      const double rho = R + r * std::cos(v);
      mesh.points.emplace_back(rho * std::cos(u), rho * std::sin(u), r * std::sin(v));
      const auto at = [&](std::uint32_t a, std::uint32_t b) { return a % nu * nv + b % nv; };
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return sample;
}

// Four balls on an arc, joined by bridges: a tube along the arc whose radius is that of the balls or of the bridge.
Sample four_blobs(const SampleOptions& options) {
  constexpr double kBend = 1.6;  // radius of the arc
  constexpr std::array<double, 4> kBall{0.30, 0.24, 0.27, 0.21};
  constexpr std::array<double, 4> kAlong{-1.02, -0.34, 0.36, 1.0};  // arc lengths of their centres
  const auto ring = [&](double s, double radius) {
    const double a = s / kBend;
    return Ring{Vec3(kBend * std::sin(a), kBend * (std::cos(a) - 1), 0), Vec3(std::sin(a), std::cos(a), 0),
                Vec3(0, 0, 1), radius};
  };
  const auto mesh_for = [&](double bridge) {
    std::vector<Ring> rings;
    const int arc = scaled(150, options.fineness, 6), straight = scaled(60, options.fineness, 2);
    for (std::size_t b = 0; b < 4; ++b) {
      // Angle from the pole behind: whole half circle, less where a bridge begins.
      const double cut = std::asin(bridge / kBall[b]);
      const double from = b == 0 ? 0 : cut, to = b == 3 ? kPi : kPi - cut;
      for (int i = 0; i <= arc; ++i) {
        const double angle = from + (to - from) * i / arc;
        const bool pole = (b == 0 && i == 0) || (b == 3 && i == arc);
        rings.push_back(ring(kAlong[b] - kBall[b] * std::cos(angle), pole ? 0 : kBall[b] * std::sin(angle)));
      }
      if (b == 3) break;
      const double begin = kAlong[b] + kBall[b] * std::cos(cut);
      const double end = kAlong[b + 1] - kBall[b + 1] * std::cos(std::asin(bridge / kBall[b + 1]));
      for (int i = 1; i < straight; ++i) rings.push_back(ring(begin + (end - begin) * i / straight, bridge));
    }
    TriangleMesh mesh;
    append_tube(mesh, rings, scaled(200, options.fineness, 8));
    return mesh;
  };
  // Bridges of 2.3 voxels at resolution 256, where they are connected; at 128 they may not be.
  const double side = ring(kAlong[3], 0).centre[0] + kBall[3] - (ring(kAlong[0], 0).centre[0] - kBall[0]);
  return {mesh_for(0.5 * 2.3 / 256 * side), {}};
}

}  // namespace quench::samples
