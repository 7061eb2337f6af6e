// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <span>
#include <unordered_map>
#include <vector>

#include "quench/samples.h"

/// Building blocks of the built-in shapes; all surfaces are closed and oriented outward.
namespace quench::samples {

inline constexpr double kPi = std::numbers::pi;

/// A surface of quads between points of a lattice. Equal lattice points become one vertex.
class LatticeSurface {
 public:
  /// `place` gives the position of a lattice point.
  explicit LatticeSurface(std::function<Vec3(const LatticePoint&)> place) : place_(std::move(place)) {}
  /// The side of a unit cell towards +axis (`upper`) or -axis, seen from outside the cell.
  void add_side(LatticePoint cell, int axis, bool upper);
  TriangleMesh take() { return std::move(mesh_); }

 private:
  std::uint32_t vertex(const LatticePoint& p);
  std::function<Vec3(const LatticePoint&)> place_;
  std::unordered_map<std::uint64_t, std::uint32_t> index_;
  TriangleMesh mesh_;
};

/// The surface of counts[0] x counts[1] x counts[2] unit cells.
TriangleMesh box_surface(const LatticePoint& counts, const std::function<Vec3(const LatticePoint&)>& place);

/// The surface of those unit cells of a box of cells that are inside; cells may meet in faces only.
TriangleMesh cells_surface(const LatticePoint& counts, const std::function<bool(const LatticePoint&)>& inside,
                           const std::function<Vec3(const LatticePoint&)>& place);

/// Unit sphere of 12 n^2 triangles (a cube with equal angles), each direction d moved to place(d).
TriangleMesh sphere(int n, const std::function<Vec3(const Vec3&)>& place);

/// Surface around a path: ring i is a circle of `radius[i]` about centre[i] in the plane of normal[i] and binormal[i];
/// the first and the last radius must be 0 and close the surface.
struct Ring {
  Vec3 centre, normal, binormal;  ///< normal x binormal points along the path
  double radius;
};
void append_tube(TriangleMesh& mesh, std::span<const Ring> rings, int around);

void append(TriangleMesh& mesh, const TriangleMesh& part, bool reversed = false);

/// `count` times `fineness`, at least `least`.
int scaled(double count, double fineness, int least);

/// splitmix64 (Steele, Lea, Flood 2014): the same numbers on every machine, unlike the distributions of <random>.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  std::uint64_t next() {
    std::uint64_t z = (state_ += 0x9E3779B97F4A7C15ull);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
    return z ^ (z >> 31);
  }
  double unit() { return static_cast<double>(next() >> 11) * 0x1p-53; }  ///< in [0, 1)
  double between(double a, double b) { return a + (b - a) * unit(); }
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(next() % n); }

 private:
  std::uint64_t state_;
};

// One function per shape; the name is that of built_in_samples() with an underscore for a dash.
Sample ellipsoid(const SampleOptions& options);
Sample torus(const SampleOptions& options);
Sample box(const SampleOptions& options);
Sample rippled_box(const SampleOptions& options);
Sample bumpy_sphere(const SampleOptions& options);
Sample fin_on_board(const SampleOptions& options);
Sample four_blobs(const SampleOptions& options);
Sample plate_with_holes(const SampleOptions& options);
Sample hollow_sphere(const SampleOptions& options);
Sample bead_pack(const SampleOptions& options);
Sample rough_plate(const SampleOptions& options);
Sample bars(const SampleOptions& options);
Sample root(const SampleOptions& options);

}  // namespace quench::samples
