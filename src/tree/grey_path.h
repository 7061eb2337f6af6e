// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "quench/tree.h"

namespace quench::tree {

/// The cheapest way between two points through grey values: a step costs its length times how dark it is, 1 at the
/// background and darker, 0.05 at the threshold and brighter, linear between.
class GreyPaths {
 public:
  /// The background is the median of the values on the other side of the threshold.
  explicit GreyPaths(const GreyValues& grey);

  struct Way {
    double darkness = 1;  ///< cost over the distance of the points, at most 1
    double grey = 0;      ///< mean of the values along it: 0 at the background, 1 at the threshold
  };
  /// Among the ways inside an ellipsoid about the two points, between the voxels they lie in. O(n log n) in its voxels.
  /// The straight way where its box has more than 2^20 voxels.
  Way between(const Vec3& a, const Vec3& b) const;

 private:
  Way straight_way(const Vec3& a, const Vec3& b) const;
  double relative(double value) const { return (value - background_) / (grey_.threshold - background_); }

  const GreyValues& grey_;
  double background_ = 0;
};

}  // namespace quench::tree
