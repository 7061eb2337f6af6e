// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "quench/context.h"
#include "quench/shape.h"

namespace quench {

/// What is done to the values of a volume before any of them is called foreground, in this order.
struct PreparationOptions {
  bool interpolate = false;  ///< resample thick slices to cubes of the smallest spacing
  int median = 0;            ///< each value becomes the median of the (2 median + 1)^3 around it; 0: none
  double blur = 0;  ///< standard deviation of a Gaussian, in voxels of the smallest spacing, the same length along
                    ///< every axis; 0: none
  bool any() const { return interpolate || median > 0 || blur > 0; }
};

/// What preparing has changed.
struct PreparationReport {
  Grid before;                    ///< the grid of the image as it was read
  std::vector<std::string> done;  ///< a sentence per step, in order
};

/// The volume with its values made ready. Integer samples stay integers where that loses nothing that matters to a
/// threshold, else they become float; see docs/user/volumes.md. `foreground` says what is interpolated: a label or mask
/// by signed distances between slices, grey values linearly.
Volume prepared(Volume&& volume, const PreparationOptions& options, const ForegroundOptions& foreground,
                PreparationReport* report = nullptr, Context* context = nullptr);

/// How often values occur, in classes of equal width.
struct Histogram {
  double low = 0, high = 0;           ///< the range of finite values
  std::vector<std::uint64_t> counts;  ///< per class, the last one includes `high`
  std::uint64_t not_a_number = 0;
};
Histogram histogram_of(const Volume& volume, std::size_t classes = 256);

/// A threshold that a rule proposes.
struct ProposedThreshold {
  std::string rule;  ///< `otsu` ...
  Threshold value;
  std::string reason;  ///< what it is good for, one sentence
};
/// Thresholds worth trying, the recommended one first; nothing for an image of at most two values.
std::vector<ProposedThreshold> proposed_thresholds(const Volume& volume, Context* context = nullptr);

}  // namespace quench
