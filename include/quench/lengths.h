// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include "quench/measures.h"

/// @file
/// Lengths in the user's units.
namespace quench::pipeline {

/// A length as users give it, resolved when the shape is known.
struct Length {
  enum class Unit { fraction, voxels, absolute, infinite, radii, number };
  double value = 0;            ///< 0 or more; of no meaning where infinite
  /// Of the longest side; of the smallest spacing; world units; of theta1 only: radii; of thresholds that are no lengths,
  /// as degrees: numbers.
  Unit unit = Unit::fraction;
  std::string text = {};       ///< as it was spelled: what records say; empty: text_of() spells it
};

/// A length in world units; may be infinite.
inline Length world_length(double value) {
  const bool infinite = value == std::numeric_limits<double>::infinity();
  return {value, infinite ? Length::Unit::infinite : Length::Unit::absolute};
}

/// `0.02` and `2%` are fractions, `12vox` voxels, `3.5abs` world units, `inf` infinite. Throws Error(usage), `field`,
/// when the text is not a non-negative length.
Length parse_length(std::string_view text, std::string_view field);
/// The same where "auto" is allowed too: then nothing.
std::optional<Length> parse_length_or_auto(std::string_view text, std::string_view field);
/// The same for theta1, which may be `0.5r`, half the radius of what a branch leaves, too.
std::optional<Length> parse_theta1(std::string_view text);
/// A threshold of a measure: a length, or a number in its range. "auto" is nothing where a threshold can be chosen. Throws
/// Error(usage), `field`, otherwise.
std::optional<Length> parse_threshold(std::string_view text, const MeasureKind& measure, std::string_view field);
/// parse_length(), parse_theta1() or parse_threshold() reads it back.
std::string text_of(const Length& length);
/// "auto" for nothing.
std::string text_of(const std::optional<Length>& length);

/// What lengths refer to.
struct Scale {
  double longest_side = 0;  ///< of the mesh, or of the foreground of a volume
  double voxel = 0;         ///< smallest spacing; 0 where there are no voxels
  double detail = 0;        ///< auto_detail() of the voxels; 0 where there are none
  bool fitted = false;      ///< the axis is that of a surface, not of the voxels

  /// World length, or the number. Throws Error(usage), `field`, for voxels where there are none.
  double resolve(const Length& length, std::string_view field) const;
};

}  // namespace quench::pipeline
