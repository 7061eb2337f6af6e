// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "quench/shape.h"

/// Smooth shapes whose reach and lambda-medial axis are known in closed form: the truth that voxel cores converge to
/// (Yan 2018, sec. 2.5). They are the samples `ellipsoid` and `torus` without their tessellation.
namespace quench::smooth {

/// Triangles that share points. A segment or a point is a triangle with repeated corners.
struct Soup {
  std::vector<Vec3> points;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

struct SurfacePoint {
  Vec3 point, normal;  ///< outward
};

class Solid {
 public:
  std::string name;
  double longest_side = 0;
  double reach = 0;  ///< distance of the surface to the medial axes of the solid and of its complement
  Topology topology;

  virtual ~Solid() = default;
  virtual bool inside(const Vec3& x) const = 0;
  /// Negative inside. Right where x is nearer to the surface than the reach.
  virtual double signed_distance(const Vec3& x) const = 0;
  /// Largest coordinate of the solid along a unit direction; the solid is symmetric about 0.
  virtual double extent(const Vec3& direction) const = 0;
  /// For (u, v) in the unit square; dense everywhere on the surface where (u, v) is.
  virtual SurfacePoint surface(double u, double v) const = 0;
  /// Distance to the lambda-medial axis: the medial points whose nearest surface points fit in no ball of radius
  /// lambda.
  virtual double axis_distance(const Vec3& x, double lambda) const = 0;
  /// That axis, at most 1e-5 of the longest side away from the true one.
  virtual Soup axis(double lambda) const = 0;
};

/// Signed distance of y to { sum (y_i / e_i)^2 = 1 }, negative inside. The nearest point is q_i = e_i^2 y_i / (t +
/// e_i^2) where F(t) = sum (e_i y_i / (t + e_i^2))^2 - 1 vanishes: y - q is t times the gradient at q. F falls and is
/// convex, so Newton's steps stay within a bracket.
template <std::size_t N>
double distance_to_quadric(const std::array<double, N>& e, const std::array<double, N>& y) {
  const auto value = [&](double t, double& slope) {
    double sum = -1;
    slope = 0;
    for (std::size_t i = 0; i < N; ++i) {
      const double g = e[i] * y[i] / (t + e[i] * e[i]);
      sum += g * g;
      slope -= 2 * g * g / (t + e[i] * e[i]);
    }
    return sum;
  };
  double slope = 0, norm = 0, least = e[0], most = e[0];
  for (std::size_t i = 0; i < N; ++i) {
    norm += y[i] * y[i];
    least = std::min(least, e[i]);
    most = std::max(most, e[i]);
  }
  const double at_zero = value(0, slope);
  double low = at_zero > 0 ? 0 : -least * least, high = at_zero > 0 ? most * std::sqrt(norm) : 0, t = 0;
  for (int i = 0; i < 100; ++i) {
    const double f = value(t, slope);
    (f > 0 ? low : high) = t;
    const double next = t - f / slope;
    if (std::abs(next - t) <= 1e-14 * most * most) break;
    t = next > low && next < high ? next : 0.5 * (low + high);
  }
  double squared = 0;
  for (std::size_t i = 0; i < N; ++i) {
    const double d = y[i] * t / (t + e[i] * e[i]);
    squared += d * d;
  }
  return at_zero > 0 ? std::sqrt(squared) : -std::sqrt(squared);
}

/// Semi-axes a > b > c. A surface point p with z > 0 and its mirror image touch one ball: the normal (x/a^2, y/b^2,
/// z/c^2) meets z = 0 at q = (x (1 - c^2/a^2), y (1 - c^2/b^2), 0). So the medial axis is the disk u <= 1, where u^2 =
/// (qx/A)^2 + (qy/B)^2, A = (a^2-c^2)/a, B = (b^2-c^2)/b; there z = c sqrt(1 - u^2), and lambda(q) = z.
/// Reach: the least radius of curvature, c^2/a at (a, 0, 0) = the distance a - A; outside a convex solid there is none.
class Ellipsoid final : public Solid {
 public:
  Ellipsoid() {
    name = "ellipsoid";
    longest_side = 2 * a;
    reach = c * c / a;
    topology = {1, {1, 0, 0}};
  }
  bool inside(const Vec3& x) const override {
    const double p = x[0] / a, q = x[1] / b, r = x[2] / c;
    return p * p + q * q + r * r < 1;
  }
  double signed_distance(const Vec3& x) const override { return distance_to_quadric<3>({a, b, c}, {x[0], x[1], x[2]}); }
  double extent(const Vec3& d) const override { return Vec3(a * d[0], b * d[1], c * d[2]).norm(); }
  SurfacePoint surface(double u, double v) const override {
    const double z = 1 - 2 * u, s = std::sqrt(1 - z * z), angle = 2 * std::numbers::pi * v;
    const Vec3 p(s * std::cos(angle), s * std::sin(angle), z);
    return {{a * p[0], b * p[1], c * p[2]}, Vec3(p[0] / a, p[1] / b, p[2] / c).normalized()};
  }
  double axis_distance(const Vec3& x, double lambda) const override {
    const double s = rim(lambda);
    const std::array<double, 2> e{s * (a * a - c * c) / a, s * (b * b - c * c) / b};
    const double p = x[0] / e[0], q = x[1] / e[1];
    const double flat = p * p + q * q <= 1 ? 0 : distance_to_quadric<2>(e, {x[0], x[1]});
    return std::hypot(flat, x[2]);
  }
  Soup axis(double lambda) const override {
    constexpr std::uint32_t rings = 32, sectors = 1024;
    const double s = rim(lambda);
    Soup soup;
    soup.points.push_back(Vec3::Zero());
    for (std::uint32_t r = 1; r <= rings; ++r)
      for (std::uint32_t k = 0; k < sectors; ++k) {
        const double angle = 2 * std::numbers::pi * k / sectors, u = s * r / rings;
        soup.points.emplace_back(u * (a * a - c * c) / a * std::cos(angle), u * (b * b - c * c) / b * std::sin(angle),
                                 0);
      }
    const auto at = [](std::uint32_t r, std::uint32_t k) { return 1 + (r - 1) * sectors + k % sectors; };
    for (std::uint32_t k = 0; k < sectors; ++k) {
      soup.triangles.push_back({0, at(1, k), at(1, k + 1)});
      for (std::uint32_t r = 1; r < rings; ++r) {
        soup.triangles.push_back({at(r, k), at(r + 1, k), at(r + 1, k + 1)});
        soup.triangles.push_back({at(r, k), at(r + 1, k + 1), at(r, k + 1)});
      }
    }
    return soup;
  }

 private:
  static constexpr double a = 1, b = 0.7, c = 0.4;
  static double rim(double lambda) { return std::sqrt(1 - lambda * lambda / (c * c)); }
};

/// Radii R (of the centre circle) and r. Every medial point is on the centre circle and touches a whole circle of
/// radius r: lambda = r everywhere. The complement's medial axis is the line x = y = 0, R - r away.
class Torus final : public Solid {
 public:
  Torus() {
    name = "torus";
    longest_side = 2 * (R + r);
    reach = std::min(r, R - r);
    topology = {0, {1, 1, 0}};
  }
  bool inside(const Vec3& x) const override { return axis_distance(x, 0) < r; }
  double signed_distance(const Vec3& x) const override { return axis_distance(x, 0) - r; }
  double extent(const Vec3& d) const override { return R * std::hypot(d[0], d[1]) + r; }
  SurfacePoint surface(double u, double v) const override {
    const double around = 2 * std::numbers::pi * u, across = 2 * std::numbers::pi * v;
    const Vec3 out(std::cos(around), std::sin(around), 0);
    const Vec3 normal = std::cos(across) * out + std::sin(across) * Vec3::UnitZ();
    return {R * out + r * normal, normal};
  }
  double axis_distance(const Vec3& x, double) const override {
    const double d = std::sqrt(x[0] * x[0] + x[1] * x[1]) - R;
    return std::sqrt(d * d + x[2] * x[2]);
  }
  Soup axis(double) const override {
    constexpr std::uint32_t parts = 1024;
    Soup soup;
    for (std::uint32_t k = 0; k < parts; ++k) {
      const double angle = 2 * std::numbers::pi * k / parts;
      soup.points.emplace_back(R * std::cos(angle), R * std::sin(angle), 0);
      soup.triangles.push_back({k, (k + 1) % parts, (k + 1) % parts});
    }
    return soup;
  }

 private:
  static constexpr double R = 1, r = 0.35;
};

inline std::vector<std::unique_ptr<Solid>> solids() {
  std::vector<std::unique_ptr<Solid>> all;
  all.push_back(std::make_unique<Ellipsoid>());
  all.push_back(std::make_unique<Torus>());
  return all;
}

/// A grid of `resolution` voxels along the longest side. Tilt 0 is the grid that voxelize() gives; any other number
/// turns and shifts the grid at random, because a solid whose symmetry planes are parallel to the grid's is a special
/// case.
inline Grid grid_for(const Solid& solid, std::int64_t resolution, std::uint64_t tilt) {
  const double h = solid.longest_side / static_cast<double>(resolution);
  Grid grid;
  grid.spacing = Vec3::Constant(h);
  Vec3 shift = Vec3::Zero();
  if (tilt != 0) {
    std::mt19937_64 random(tilt);
    const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
    Eigen::Vector4d q;
    do
      for (int i = 0; i < 4; ++i) q[i] = 2 * unit() - 1;
    while (q.norm() > 1 || q.norm() < 0.1);
    grid.direction = Eigen::Quaterniond(q).normalized().toRotationMatrix();
    for (int i = 0; i < 3; ++i) shift[i] = unit();
  }
  Vec3 corner;  // lattice 0, along the grid's directions
  for (int i = 0; i < 3; ++i) {
    const double e = solid.extent(grid.direction.col(i));
    grid.dims[static_cast<std::size_t>(i)] = static_cast<std::int64_t>(std::ceil(2 * e / h - 1e-9)) + (tilt ? 3 : 2);
    corner[i] = -e - h * (1 + shift[i]);
  }
  grid.origin = grid.direction * (corner + Vec3::Constant(0.5 * h));
  return grid;
}

/// Gauss digitization: the voxels whose centres are inside, by asking at every centre near the solid.
inline VoxelShape digitize(const Solid& solid, const Grid& grid) {
  VoxelShape shape(grid);
  const double h = grid.spacing[0], radius = 0.501 * solid.longest_side;
  std::vector<Run> runs;
  for (std::int64_t z = 0; z < grid.dims[2]; ++z)
    for (std::int64_t y = 0; y < grid.dims[1]; ++y) {
      runs.clear();
      const Vec3 first = grid.world(Vec3(0.5, static_cast<double>(y) + 0.5, static_cast<double>(z) + 0.5));
      const Vec3 step = h * grid.direction.col(0);
      // The part of the scanline inside a ball around the solid: both solids are as far from 0 as half their side.
      const double middle = -first.dot(step) / (h * h);
      const double beside = radius * radius - (first + middle * step).squaredNorm();
      if (beside > 0) {
        const double half = std::sqrt(beside) / h;
        const auto begin = static_cast<std::int32_t>(std::max(0.0, std::floor(middle - half)));
        const auto end = static_cast<std::int32_t>(
            std::min(static_cast<double>(grid.dims[0]), std::max(0.0, std::ceil(middle + half))));
        for (std::int32_t x = begin; x < end; ++x) {
          if (!solid.inside(first + x * step)) continue;
          if (!runs.empty() && runs.back().end == x)
            ++runs.back().end;
          else
            runs.push_back({x, x + 1});
        }
      }
      shape.append_row(runs);
    }
  return shape;
}

/// Evenly spread surface points (an additive sequence, Roberts 2018).
inline std::vector<SurfacePoint> surface_sample(const Solid& solid, std::size_t count) {
  constexpr double p = 1.32471795724474602596;  // p^3 = p + 1
  std::vector<SurfacePoint> sample;
  sample.reserve(count);
  double u = 0.5, v = 0.5;
  for (std::size_t i = 0; i < count; ++i) {
    u += 1 / p;
    v += 1 / (p * p);
    u -= std::floor(u);
    v -= std::floor(v);
    sample.push_back(solid.surface(u, v));
  }
  return sample;
}

}  // namespace quench::smooth
