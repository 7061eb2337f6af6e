// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "quench/geometry.h"

namespace quench::simplification {

using Vec4 = Eigen::Vector4d;  ///< a ball: centre and radius
using Mat4 = Eigen::Matrix4d;

inline Vec4 ball_of(const Vec3& centre, double radius) { return {centre[0], centre[1], centre[2], radius}; }

/// The sum of squared distances of a ball m from planes it should touch: m.A m - 2 b.m + c (Thiery et al. 2013). A
/// plane through p with the outward normal n is at n.(p - centre) - radius from it.
struct Quadric {
  Mat4 a = Mat4::Zero();
  Vec4 b = Vec4::Zero();
  double c = 0;
  double weight = 0;

  /// A plane with normal (n, 1) in the space of balls that goes through the ball `through`.
  void add_plane(const Vec4& normal, const Vec4& through, double w) {
    const double d = normal.dot(through);
    a.noalias() += w * normal * normal.transpose();
    b += w * d * normal;
    c += w * d * d;
    weight += w;
  }
  /// Many planes through one ball: w times the sum of n n^T; `count` is that of their weights.
  void add(const Mat4& sum, const Vec4& through, double w, double count) {
    const Vec4 product = sum * through;
    a += w * sum;
    b += w * product;
    c += w * through.dot(product);
    weight += w * count;
  }
  Quadric& operator*=(double factor) {
    a *= factor;
    b *= factor;
    c *= factor;
    weight *= factor;
    return *this;
  }
  Quadric& operator+=(const Quadric& other) {
    a += other.a;
    b += other.b;
    c += other.c;
    weight += other.weight;
    return *this;
  }
  double operator()(const Vec4& m) const {
    const double value = m.dot(a * m) - 2 * b.dot(m) + c;
    return value > 0 ? value : 0;
  }
};

}  // namespace quench::simplification
