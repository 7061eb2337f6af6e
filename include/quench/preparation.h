// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "quench/context.h"
#include "quench/shape.h"

namespace quench {

inline constexpr int kLargestMedian = 16;
inline constexpr double kLargestBlur = 100;

/// What is done to the values of a volume before any of them is called foreground, in this order. Samples beside the
/// image are those at its border.
struct PreparationOptions {
  bool interpolate = false;  ///< resample thick slices to cubes of the smallest spacing
  int median = 0;  ///< each value becomes the median of the (2 median + 1)^3 around it; at most kLargestMedian; 0: none
  double blur = 0;  ///< standard deviation of a Gaussian, in voxels of the smallest spacing, the same length along
                    ///< every axis; at most kLargestBlur; 0: none
  bool any() const { return interpolate || median != 0 || blur != 0; }  ///< also numbers that prepared() refuses
};

/// What preparing has changed.
struct PreparationReport {
  Grid before;                    ///< the grid of the image as it was read
  std::vector<std::string> done;  ///< a sentence per step, in order
};

/// The volume with its values made ready. `foreground` says what it is: with a label only whether voxels have it, of
/// which interpolation makes a shape by signed distances in the slices along the largest spacing, linear between them
/// (Raya and Udupa 1990, IEEE Trans. Med. Imaging 9); the same of an image of at most two values without a threshold.
/// Other values are interpolated linearly.
///
/// The kernel of the Gaussian is that of the lattice, whose variance is exact for every width (Lindeberg 1990, IEEE
/// Trans. PAMI 12). Integer samples stay integers, rounded to the nearest, so that a voxel is of at least the whole
/// threshold T where the exact value is at least T - 1/2; where they span less than 64 they become float. Samples that
/// are not finite stay as they are and are left out of medians and Gaussians.
///
/// In slabs, on all threads; beyond the volume the memory of few slices, with `interpolate` or where the type of the
/// samples changes that of the result. The result does not depend on the number of threads. Throws Error(usage), with
/// the field, for numbers out of range, a blurred label or mask, and an interpolated image of the plane.
Volume prepared(Volume&& volume, const PreparationOptions& options, const ForegroundOptions& foreground,
                PreparationReport* report = nullptr, Context* context = nullptr);

/// Bytes prepared() holds beyond the volume it gets.
std::int64_t predicted_preparation_bytes(const Volume& volume, const PreparationOptions& options);

/// The samples of a view as a volume of its own, x fastest.
Volume volume_of(const ImageView& image);

/// How often values occur, in classes of equal width.
struct Histogram {
  double low = 0, high = 0;           ///< the range of finite values
  double width = 1;                   ///< of a class; a whole number for integer samples
  std::vector<std::uint64_t> counts;  ///< per class, the first one from `low`, the last one includes `high`
  std::uint64_t not_finite = 0;
};
/// At most that many classes. O(samples).
Histogram histogram_of(const Volume& volume, std::size_t classes = 256);

/// The values of a volume of labels, ascending; nothing where they look like grey values. Labels are whole numbers from
/// 0 on, three to 64 of them, at least half of those up to the largest one; and they fill regions: nine of ten samples
/// are as the next one in their row, as they are in no image with noise. O(samples).
std::vector<std::int64_t> labels_in(const Volume& volume);
/// "0, 1, 2 ... 11".
std::string labels_text(const std::vector<std::int64_t>& labels);

/// A threshold that a rule proposes.
struct ProposedThreshold {
  std::string rule;  ///< `edges`, `otsu` or `thin`
  Threshold value;
  std::string reason;                  ///< what it is good for, one sentence
  std::optional<Threshold> seed = {};  ///< of two thresholds the upper one, as ForegroundOptions::seed_threshold
};
/// Thresholds worth trying, the recommended one first; nothing for an image of at most two values.
///
/// `edges`: the value at which most of the edges are cut. A step is a pair of neighbouring samples whose difference
/// exceeds three times that of noise (by the median of all differences); a value cuts the steps from below to above it,
/// and each counts by the square of its difference. That is the middle of the edges of a bright thing, thick or thin,
/// however little of the image it fills. Values nearer to the most frequent one than three times the noise are no
/// candidates. Missing where there are no such steps. `otsu`: Otsu's method (1979, IEEE Trans. SMC 9).
///
/// `thin`: two thresholds for hysteresis. What is thinner than the blur of the image does not get as bright as what is
/// thick. The background is the median of what is below `edges`, its noise the distance from there to the quantile of
/// one standard deviation below it, and as bright as thick things is 0.9 of what is above `edges`. The upper threshold
/// is half way between background and bright. The lower one is half way between background and the upper one, which is
/// the edge of a thing that gets just as bright as that, but at least three times the noise above the background.
/// Missing where `edges` is, or noise leaves no room between the two.
/// O(samples), on all threads.
std::vector<ProposedThreshold> proposed_thresholds(const Volume& volume, Context* context = nullptr);

}  // namespace quench
