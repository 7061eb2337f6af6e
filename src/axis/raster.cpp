// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "base/parallel.h"
#include "quench/axis.h"
#include "quench/error.h"

namespace quench {
namespace {

// Voxels from the first one to a vertex of a complex: twice what a grid may have along an axis.
constexpr double kFar = 0x1p21;

class Marker {
 public:
  Marker(const Grid& grid, const MaskView& mask) : grid_(grid), mask_(mask) {}

  // In lattice coordinates, where the voxel of a point is its whole part.
  Vec3 lattice(const Vec3& world) const { return grid_.lattice(world); }
  void mark(const Vec3& lattice) const {
    std::int64_t at = 0;
    for (std::size_t a = 0; a < 3; ++a) {
      const double whole = std::floor(lattice[static_cast<Eigen::Index>(a)]);
      if (!(whole >= 0) || whole >= static_cast<double>(mask_.dims[a])) return;
      at += static_cast<std::int64_t>(whole) * mask_.strides[a];
    }
    mask_.data[at] = 1;
  }
  static double steps(const Vec3& difference) { return std::max(1.0, std::ceil(3 * difference.cwiseAbs().maxCoeff())); }
  void segment(const Vec3& a, const Vec3& b) const {
    const double n = steps(b - a);
    for (double i = 0; i <= n; ++i) mark(a + (b - a) * (i / n));
  }
  void triangle(const Vec3& a, const Vec3& b, const Vec3& c) const {
    const double n = std::max({steps(b - a), steps(c - b), steps(a - c)});
    for (double i = 0; i <= n; ++i)
      for (double j = 0; j <= n - i; ++j) mark(a + (b - a) * (i / n) + (c - a) * (j / n));
  }

 private:
  const Grid& grid_;
  const MaskView& mask_;
};

// The axes of a mask by distance in memory, the closest last.
std::array<std::size_t, 3> axes_of(const MaskView& mask) {
  std::array<std::size_t, 3> axes{0, 1, 2};
  std::stable_sort(axes.begin(), axes.end(),
                   [&](auto a, auto b) { return std::abs(mask.strides[a]) > std::abs(mask.strides[b]); });
  return axes;
}

}  // namespace

void mark_cells(const CellComplex& complex, std::span<const Vec3> points, const Grid& grid, const MaskView& mask,
                Context* context) {
  const Marker marker(grid, mask);
  std::vector<Vec3> lattice(points.size());
  for (std::size_t p = 0; p < points.size(); ++p) {
    lattice[p] = marker.lattice(points[p]);
    if (!(lattice[p].cwiseAbs().maxCoeff() < kFar) || !lattice[p].allFinite())
      throw Error(ErrorCode::usage, fmt::format("vertex {} lies more than 2^21 voxels away from the grid, or nowhere; "
                                                "give the grid the complex belongs to",
                                                p));
  }
  for (const Vec3& p : lattice) marker.mark(p);
  std::vector<char> has_face(complex.edges.size(), 0);
  for (const std::uint32_t e : complex.face_edges) has_face[e] = 1;
  for (std::size_t e = 0; e < complex.edges.size(); ++e)
    if (!has_face[e]) marker.segment(lattice[complex.edges[e][0]], lattice[complex.edges[e][1]]);
  for (std::size_t f = 0; f < complex.face_count(); ++f) {
    if (f % 65536 == 0)
      checkpoint(context, "volume", static_cast<double>(f) / static_cast<double>(complex.face_count()));
    const auto corners = complex.corners(f);
    for (std::size_t i = 2; i < corners.size(); ++i)
      marker.triangle(lattice[corners[0]], lattice[corners[i - 1]], lattice[corners[i]]);
  }
  checkpoint(context, "volume", 1);
}

void mark_balls(std::span<const Vec3> centres, std::span<const double> radius, const Grid& grid, const MaskView& mask,
                Context* context) {
  const auto axes = axes_of(mask);
  const std::size_t far = axes[0], middle = axes[1], near = axes[2];
  struct Ball {
    double far, middle, near, squared, reach;  // centre in voxels, squared radius, reach along `far` in voxels
  };
  const auto axis = [](std::size_t a) { return static_cast<Eigen::Index>(a); };
  const Vec3 size = grid.spacing;
  const double d_far = size[axis(far)], d_middle = size[axis(middle)], d_near = size[axis(near)];
  std::vector<Ball> balls(centres.size());
  for (std::size_t b = 0; b < balls.size(); ++b) {
    const Vec3 c = grid.lattice(centres[b]) - grid.first_centre();
    const double r = radius[b] * (1 + 1e-9);  // centres on a sphere are in: they decide much in small shapes
    balls[b] = {c[axis(far)], c[axis(middle)], c[axis(near)], r * r, r / d_far};
  }
  constexpr std::int64_t kSlab = 8;
  const std::int64_t slabs = (mask.dims[far] + kSlab - 1) / kSlab;
  // Balls of each slab, so that every slab is written by one thread and looks at its own balls only.
  std::vector<std::vector<std::uint32_t>> members(static_cast<std::size_t>(slabs));
  const auto clipped = [](double value, std::int64_t least, std::int64_t most) {
    if (!(value > static_cast<double>(least))) return least;  // also for NaN
    return static_cast<std::int64_t>(std::min(value, static_cast<double>(std::max(least, most))));
  };
  for (std::uint32_t b = 0; b < balls.size(); ++b) {
    const std::int64_t first = clipped(std::ceil(balls[b].far - balls[b].reach), 0, mask.dims[far]);
    const std::int64_t last = clipped(std::floor(balls[b].far + balls[b].reach), -1, mask.dims[far] - 1);
    for (std::int64_t s = first / kSlab; first <= last && s <= last / kSlab; ++s)
      members[static_cast<std::size_t>(s)].push_back(b);
  }
  const auto fill = [&](std::int64_t s) {
    if (context && context->cancelled()) return;
    const std::int64_t begin = s * kSlab, end = std::min(begin + kSlab, mask.dims[far]);
    for (const std::uint32_t b : members[static_cast<std::size_t>(s)]) {
      const Ball& ball = balls[b];
      const std::int64_t i0 = std::max(begin, clipped(std::ceil(ball.far - ball.reach), 0, end));
      const std::int64_t i1 = std::min(end - 1, clipped(std::floor(ball.far + ball.reach), -1, end - 1));
      for (std::int64_t i = i0; i <= i1; ++i) {
        const double x = (static_cast<double>(i) - ball.far) * d_far;
        const double disk = ball.squared - x * x;
        if (disk < 0) continue;
        const double tall = std::sqrt(disk) / d_middle;
        const std::int64_t j0 = clipped(std::ceil(ball.middle - tall), 0, mask.dims[middle]);
        const std::int64_t j1 = clipped(std::floor(ball.middle + tall), -1, mask.dims[middle] - 1);
        for (std::int64_t j = j0; j <= j1; ++j) {
          const double y = (static_cast<double>(j) - ball.middle) * d_middle;
          const double chord = disk - y * y;
          if (chord < 0) continue;
          const double wide = std::sqrt(chord) / d_near;
          const std::int64_t k0 = clipped(std::ceil(ball.near - wide), 0, mask.dims[near]);
          const std::int64_t k1 = clipped(std::floor(ball.near + wide), -1, mask.dims[near] - 1);
          std::uint8_t* row = mask.data + i * mask.strides[far] + j * mask.strides[middle];
          if (mask.strides[near] == 1) {
            if (k0 <= k1) std::fill(row + k0, row + k1 + 1, std::uint8_t{1});
          } else {
            for (std::int64_t k = k0; k <= k1; ++k) row[k * mask.strides[near]] = 1;
          }
        }
      }
    }
  };
  base::in_arena(context, [&] {
    checkpoint(context, "reconstruct", 0);
    tbb::parallel_for(std::int64_t{0}, slabs, fill);
    checkpoint(context, "reconstruct", 1);
  });
}

}  // namespace quench
