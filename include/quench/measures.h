// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <string_view>

#include "quench/record.h"

/// @file
/// The measures that medial axes are pruned by.
namespace quench {

/// What values and thresholds of a measure are.
enum class MeasureUnit {
  length,   ///< world units; thresholds are lengths
  degrees,  ///< a number
  ratio     ///< a number
};

/// Which files of cores have the arrays of a measure, beside those where it is asked for or the core is pruned by it.
enum class MeasureFiles {
  on_request,    ///< no others
  of_the_plane,  ///< of shapes of the plane
  all
};

/// Of thresholds that no number bounds.
inline constexpr double kUnbounded = std::numeric_limits<double>::infinity();

/// A measure that voxel cores can be pruned by: pipeline::add_measure() adds it.
struct MeasureKind {
  std::string_view name;  ///< what it and its arrays in files are called
  MeasureUnit unit;
  double least, most;  ///< of thresholds
  bool automatic;      ///< a threshold can be chosen
  MeasureFiles files;
  std::string_view words;
};

inline constexpr std::string_view kObjectAngle = "object_angle";
/// Radius of the ball.
inline constexpr std::string_view kCircumradius = "circumradius";
/// The erosion thickness of the whole core. `erosion_thickness` is that of what a pruning has kept.
inline constexpr std::string_view kCoreErosionThickness = "core_erosion_thickness";
/// The share of it in the burn time.
inline constexpr std::string_view kRelativeErosionThickness = "relative_erosion_thickness";
/// What `mgf` exceeds the distance of the two sites by.
inline constexpr std::string_view kChordResidual = "chord_residual";
/// The factor by which balls grow until a larger one swallows the ball.
inline constexpr std::string_view kScaleAxis = "scale_axis";

/// All of them; what each is stands in docs/algorithms/pruning.md.
inline constexpr std::array kMeasures{
    MeasureKind{kDetail, MeasureUnit::length, 0, kUnbounded, true, MeasureFiles::on_request,
                "up to which detail the default pruning keeps a place"},
    MeasureKind{kLambda, MeasureUnit::length, 0, kUnbounded, true, MeasureFiles::all,
                "half the distance of the two nearest boundary points"},
    MeasureKind{kCapHeight, MeasureUnit::length, 0, kUnbounded, false, MeasureFiles::all,
                "what the ball reaches beyond the chord between them"},
    MeasureKind{kObjectAngle, MeasureUnit::degrees, 0, 180, false, MeasureFiles::all,
                "the angle between the directions to them"},
    MeasureKind{kCircumradius, MeasureUnit::length, 0, kUnbounded, false, MeasureFiles::on_request,
                "the radius of the ball"},
    MeasureKind{kMgf, MeasureUnit::length, 0, kUnbounded, false, MeasureFiles::of_the_plane,
                "the length of the shortest way on the boundary between them"},
    MeasureKind{kChordResidual, MeasureUnit::length, 0, kUnbounded, false, MeasureFiles::on_request,
                "what that way is longer than their distance"},
    MeasureKind{kCoreErosionThickness, MeasureUnit::length, 0, kUnbounded, false, MeasureFiles::on_request,
                "how much longer the whole core burns there than the radius says"},
    MeasureKind{kRelativeErosionThickness, MeasureUnit::ratio, 0, 1, false, MeasureFiles::on_request,
                "its share of the burn time"},
    MeasureKind{kScaleAxis, MeasureUnit::ratio, 1, kUnbounded, false, MeasureFiles::on_request,
                "the factor by which balls grow until a larger one swallows the ball"}};

/// The measure of that name, or null.
constexpr const MeasureKind* find_measure_kind(std::string_view name) {
  const auto found =
      std::find_if(kMeasures.begin(), kMeasures.end(), [&](const MeasureKind& m) { return m.name == name; });
  return found == kMeasures.end() ? nullptr : &*found;
}

}  // namespace quench
