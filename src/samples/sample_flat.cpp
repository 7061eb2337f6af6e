// SPDX-License-Identifier: Apache-2.0
// Boxes and plates.
#include <algorithm>
#include <map>
#include <unordered_set>

#include "samples/sample_shapes.h"

namespace quench::samples {
namespace {

// Coordinates from `begin` to `end` in `count` equal steps, the ends exact, appended without the first.
void append_steps(std::vector<double>& coordinates, double end, int count) {
  const double begin = coordinates.back();
  for (int i = 1; i < count; ++i) coordinates.push_back(begin + (end - begin) * i / count);
  coordinates.push_back(end);
}

// A flat triangulation, counter-clockwise, with a wall along its border: the solid between z = -h and z = h.
TriangleMesh extruded(const std::vector<Eigen::Vector2d>& points,
                      const std::vector<std::array<std::uint32_t, 3>>& triangles, double h) {
  TriangleMesh mesh;
  const auto n = static_cast<std::uint32_t>(points.size());
  for (const double z : {h, -h})
    for (const auto& p : points) mesh.points.emplace_back(p[0], p[1], z);
  std::unordered_set<std::uint64_t> edges;
  const auto key = [](std::uint32_t a, std::uint32_t b) { return static_cast<std::uint64_t>(a) << 32 | b; };
  for (const auto& t : triangles) {
    mesh.triangles.push_back(t);
    mesh.triangles.push_back({t[0] + n, t[2] + n, t[1] + n});
    for (std::size_t e = 0; e < 3; ++e) edges.insert(key(t[e], t[(e + 1) % 3]));
  }
  for (const auto& t : triangles)
    for (std::size_t e = 0; e < 3; ++e) {
      const std::uint32_t a = t[e], b = t[(e + 1) % 3];
      if (edges.contains(key(b, a))) continue;
      mesh.triangles.push_back({b, a, a + n});
      mesh.triangles.push_back({b, a + n, b + n});
    }
  return mesh;
}

}  // namespace

Sample box(const SampleOptions& options) {
  const int n = scaled(1, options.fineness, 1);
  const Vec3 sides(2, 1.4, 1);
  return {box_surface({n, n, n},
                      [&](const LatticePoint& p) {
                        const Vec3 fraction = Vec3(p[0], p[1], p[2]) / n;
                        return Vec3(sides.cwiseProduct(fraction - Vec3::Constant(0.5)));
                      }),
          {}};
}

Sample rippled_box(const SampleOptions& options) {
  constexpr double kWidth = 2, kDepth = 1.4, kHeight = 0.6;
  const double amplitude = kWidth * (options.noise > 0 ? options.noise : 0.006);
  const int nx = scaled(300, options.fineness, 4), ny = scaled(210, options.fineness, 4),
            nz = scaled(4, options.fineness, 1);
  return {box_surface({nx, ny, nz},
                      [&](const LatticePoint& p) {
                        const double x = kWidth * (static_cast<double>(p[0]) / nx - 0.5);
                        const double y = kDepth * (static_cast<double>(p[1]) / ny - 0.5);
                        const double u = static_cast<double>(p[2]) / nz - 0.5;
                        // The ripples end at the edges, which stay straight; those of the two faces are out of phase.
                        const double fade = std::sin(kPi * p[0] / nx) * std::sin(kPi * p[1] / ny);
                        const double phase = u > 0 ? 0 : 1.3;
                        const double wave = std::sin(13 * x + phase) * std::cos(11 * y + 2 * phase);
                        return Vec3(x, y, kHeight * u + 2 * std::abs(u) * amplitude * fade * wave);
                      }),
          {}};
}

Sample fin_on_board(const SampleOptions& options) {
  // Coordinates of the lattice: fine where the top is curved, with lines along the fin.
  std::vector<double> x{-1}, y{-0.7};
  append_steps(x, -0.75, scaled(20, options.fineness, 1));
  append_steps(x, 0.15, scaled(90, options.fineness, 1));
  append_steps(x, 1, scaled(170, options.fineness, 1));
  append_steps(y, -0.02, scaled(120, options.fineness, 1));
  append_steps(y, 0.02, scaled(2, options.fineness, 1));
  append_steps(y, 0.7, scaled(120, options.fineness, 1));
  const std::vector<double> z{-0.2, 0.2, 0.7};
  const LatticePoint counts{static_cast<std::int32_t>(x.size()) - 1, static_cast<std::int32_t>(y.size()) - 1, 2};
  const auto in_fin = [&](const LatticePoint& c) {
    const auto i = static_cast<std::size_t>(c[0]), j = static_cast<std::size_t>(c[1]);
    const double cx = 0.5 * (x[i] + x[i + 1]), cy = 0.5 * (y[j] + y[j + 1]);
    return cx > -0.75 && cx < 0.15 && std::abs(cy) < 0.02;
  };
  return {cells_surface(
              counts, [&](const LatticePoint& c) { return c[2] == 0 || in_fin(c); },
              [&](const LatticePoint& p) {
                Vec3 place(x[static_cast<std::size_t>(p[0])], y[static_cast<std::size_t>(p[1])],
                           z[static_cast<std::size_t>(p[2])]);
                if (p[2] == 1) {  // the low bump, a raised cosine, beside the fin
                  const double r = std::hypot(place[0] - 0.6, place[1] - 0.1) / 0.32;
                  if (r < 1) place[2] += 0.06 * 0.5 * (1 + std::cos(kPi * r));
                }
                return place;
              }),
          {}};
}

// Square tiles, each a ring of quads between its border and a round hole.
Sample plate_with_holes(const SampleOptions& options) {
  constexpr int kColumns = 3, kRows = 2;
  constexpr double kTile = 2.0 / kColumns, kHole = 0.2, kHalfThickness = 0.05;
  const int side = scaled(48, options.fineness, 2), layers = scaled(8, options.fineness, 1);
  std::vector<Eigen::Vector2d> points;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::map<std::pair<int, int>, std::uint32_t> border;  // shared by neighbouring tiles
  const auto border_point = [&](int i, int j) {
    const auto [it, added] = border.emplace(std::pair(i, j), static_cast<std::uint32_t>(points.size()));
    if (added) points.emplace_back(kTile * i / side - 0.5 * kTile * kColumns, kTile * j / side - 0.5 * kTile * kRows);
    return it->second;
  };
  for (int row = 0; row < kRows; ++row)
    for (int column = 0; column < kColumns; ++column) {
      const Eigen::Vector2d centre(kTile * (column + 0.5 * (1 - kColumns)), kTile * (row + 0.5 * (1 - kRows)));
      std::vector<std::uint32_t> outer, inner;
      for (int k = 0; k < 4 * side; ++k) {  // counter-clockwise from the lower left corner
        const int edge = k / side, t = k % side;
        const int i = edge == 0 ? t : edge == 1 ? side : edge == 2 ? side - t : 0;
        const int j = edge == 0 ? 0 : edge == 1 ? t : edge == 2 ? side : side - t;
        outer.push_back(border_point(column * side + i, row * side + j));
      }
      for (int layer = 1; layer <= layers; ++layer) {
        inner.clear();
        for (int k = 0; k < 4 * side; ++k) {
          const double angle = 2 * kPi * k / (4 * side) - 0.75 * kPi;
          const Eigen::Vector2d circle = centre + kHole * Eigen::Vector2d(std::cos(angle), std::sin(angle));
          const double t = static_cast<double>(layer) / layers;
          const int edge = k / side, s = k % side;
          const int i = edge == 0 ? s : edge == 1 ? side : edge == 2 ? side - s : 0;
          const int j = edge == 0 ? 0 : edge == 1 ? s : edge == 2 ? side : side - s;
          const Eigen::Vector2d square = points[border_point(column * side + i, row * side + j)];
          inner.push_back(static_cast<std::uint32_t>(points.size()));
          points.push_back(layer == layers ? circle : Eigen::Vector2d((1 - t) * square + t * circle));
        }
        for (std::size_t k = 0; k < outer.size(); ++k) {
          const std::size_t next = (k + 1) % outer.size();
          triangles.push_back({outer[k], outer[next], inner[next]});
          triangles.push_back({outer[k], inner[next], inner[k]});
        }
        outer = inner;
      }
    }
  return {extruded(points, triangles, kHalfThickness), {}};
}

}  // namespace quench::samples
