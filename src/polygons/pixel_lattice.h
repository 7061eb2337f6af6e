// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "polygons/exact_sum.h"
#include "quench/polygons.h"

namespace quench::polygons {

/// The centres of the pixels of a grid, (origin + i * pixel, origin + j * pixel) as real numbers, and exact answers to
/// where they lie. For points inside the box that the grid covers, of up to kMostPixels along a side.
class PixelLattice {
 public:
  explicit PixelLattice(const Grid& grid)
      : origin_(grid.origin[0], grid.origin[1]),
        pixel_(grid.spacing[0]),
        error_(static_cast<double>(std::max(grid.dims[0], grid.dims[1]) + 2) * 0x1p-51) {}

  /// An edge upwards, ready for the rows that it crosses.
  class Edge {
   public:
    Edge(const PixelLattice& lattice, const Vec2& low, const Vec2& high)
        : lattice_(lattice), low_(low), high_(high), u_(lattice.in_pixels(low, 0)), v_(lattice.in_pixels(low, 1)) {
      const double other = lattice.in_pixels(high, 0), height = lattice.in_pixels(high, 1) - v_;
      least_ = std::ceil(std::min(u_, other) - lattice.error_);
      most_ = std::ceil(std::max(u_, other) + lattice.error_);
      // The computed crossing u + (j - v) * slope: u, v and j - v are wrong by `error` at most, so are the differences
      // by twice that, and j - v is at most the height. So slope * (j - v) is wrong by 2 error + 4 error * slope and
      // three roundings, each below error * (1 + slope).
      flat_ = !(height > 0x1p-20);
      if (flat_) return;
      slope_ = (other - u_) / height;
      error_ = 8 * lattice.error_ * (1 + std::abs(slope_));
    }

    /// The first column whose centre in this row is not left of the edge.
    std::int32_t column(std::int32_t row) const {
      double least = least_, most = most_;
      if (!flat_) {
        const double crossing = u_ + (row - v_) * slope_;
        least = std::max(least, std::ceil(crossing - error_));
        most = std::min(most, std::ceil(crossing + error_));
      }
      auto first = static_cast<std::int32_t>(least), last = static_cast<std::int32_t>(most);
      while (first < last) {
        const std::int32_t middle = first + (last - first) / 2;
        if (is_left(middle, row))
          first = middle + 1;
        else
          last = middle;
      }
      return first;
    }

   private:
    /// Whether the centre is left of the edge: the sign of
    /// (low.x - centre.x) * (high.y - low.y) + (centre.y - low.y) * (high.x - low.x), exactly.
    bool is_left(std::int32_t column, std::int32_t row) const {
      const Product x = lattice_.steps(column), y = lattice_.steps(row);
      const Vec2& origin = lattice_.origin_;
      ExactSum sum;
      for (const double a : {low_[0], -origin[0], -x.high, -x.low}) {
        sum.add_product(a, high_[1]);
        sum.add_product(a, -low_[1]);
      }
      for (const double a : {-low_[1], origin[1], y.high, y.low}) {
        sum.add_product(a, high_[0]);
        sum.add_product(a, -low_[0]);
      }
      return sum.sign() > 0;
    }

    const PixelLattice& lattice_;
    Vec2 low_, high_;
    double u_, v_, slope_ = 0, error_ = 0, least_, most_;
    bool flat_;
  };

  /// The first row whose centres are not below y.
  std::int32_t first_row(double y) const {
    const double v = (y - origin_[1]) / pixel_, nearest = std::nearbyint(v);
    if (std::abs(v - nearest) > error_) return static_cast<std::int32_t>(std::ceil(v));
    const auto row = static_cast<std::int32_t>(nearest);
    const Product step = steps(row);
    ExactSum above;
    for (const double a : {origin_[1], step.high, step.low, -y}) above.add(a);
    return above.sign() >= 0 ? row : row + 1;
  }

 private:
  struct Product {
    double high, low;
  };
  /// n pixels, as an unevaluated sum without error: a pixel is at least 1e-30, so nothing underflows.
  Product steps(std::int32_t n) const {
    const double product = n * pixel_;
    return {product, std::fma(n, pixel_, -product)};
  }
  /// In pixels from the origin; two roundings, which `error_` bounds with room to spare.
  double in_pixels(const Vec2& p, int axis) const { return (p[axis] - origin_[axis]) / pixel_; }

  Vec2 origin_;
  double pixel_, error_;
};

}  // namespace quench::polygons
