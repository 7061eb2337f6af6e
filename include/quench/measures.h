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

/// A measure that voxel cores can be pruned by: pipeline::add_measure() adds it.
struct MeasureKind {
  std::string_view name;  ///< what it and its arrays in files are called
  MeasureUnit unit;
  double least, most;  ///< of thresholds
  bool automatic;      ///< a threshold can be chosen
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
    MeasureKind{kDetail, MeasureUnit::length, 0, std::numeric_limits<double>::infinity(), true,
                "up to which detail the default pruning keeps a place"},
    MeasureKind{kLambda, MeasureUnit::length, 0, std::numeric_limits<double>::infinity(), true,
                "half the distance of the two nearest boundary points"},
    MeasureKind{kCapHeight, MeasureUnit::length, 0, std::numeric_limits<double>::infinity(), false,
                "what the ball reaches beyond the chord between them"},
    MeasureKind{kObjectAngle, MeasureUnit::degrees, 0, 180, false, "the angle between the directions to them"},
    MeasureKind{kCircumradius, MeasureUnit::length, 0, std::numeric_limits<double>::infinity(), false,
                "the radius of the ball"},
    MeasureKind{kMgf, MeasureUnit::length, 0, std::numeric_limits<double>::infinity(), false,
                "the length of the shortest way on the boundary between them"},
    MeasureKind{kChordResidual, MeasureUnit::length, 0, std::numeric_limits<double>::infinity(), false,
                "what that way is longer than their distance"},
    MeasureKind{kCoreErosionThickness, MeasureUnit::length, 0, std::numeric_limits<double>::infinity(), false,
                "how much longer the whole core burns there than the radius says"},
    MeasureKind{kRelativeErosionThickness, MeasureUnit::ratio, 0, 1, false, "its share of the burn time"},
    MeasureKind{kScaleAxis, MeasureUnit::ratio, 1, std::numeric_limits<double>::infinity(), false,
                "the factor by which balls grow until a larger one swallows the ball"}};

/// The measure of that name, or null.
constexpr const MeasureKind* find_measure_kind(std::string_view name) {
  const auto found =
      std::find_if(kMeasures.begin(), kMeasures.end(), [&](const MeasureKind& m) { return m.name == name; });
  return found == kMeasures.end() ? nullptr : &*found;
}

}  // namespace quench
