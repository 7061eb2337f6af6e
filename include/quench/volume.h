// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "quench/context.h"
#include "quench/geometry.h"
#include "quench/voxel_shape.h"

namespace quench {

/// A scalar image as read from a file: x fastest. The sample type is kept, so that labels stay exact.
struct Volume {
  using Samples =
      std::variant<std::vector<std::uint8_t>, std::vector<std::int8_t>, std::vector<std::uint16_t>,
                   std::vector<std::int16_t>, std::vector<std::uint32_t>, std::vector<std::int32_t>,
                   std::vector<std::uint64_t>, std::vector<std::int64_t>, std::vector<float>, std::vector<double>>;
  Grid grid;
  Samples samples;
  Coordinates coordinates;
  std::string spacing_source;  ///< what the spacing was taken from, e.g. "the ImageJ description"; empty: the file
                               ///< does not say one, and it is 1
};

/// A bound of samples. Whole numbers stay exact: 64-bit samples have values that a double rounds.
using Threshold = std::variant<double, std::int64_t, std::uint64_t>;

/// Which voxels of an image are the shape. At most one of threshold and label may be set; with neither, the
/// foreground is the non-zero voxels of an image that has at most two values, and any other image is Error(usage).
struct ForegroundOptions {
  std::optional<Threshold> threshold;  ///< foreground: value >= threshold (NaN is background)
  std::optional<std::int64_t> label;   ///< foreground: value == label, 0 included
  bool invert = false;                 ///< foreground becomes background, within the image's box
  bool largest_component = false;      ///< keep the largest 6-connected component
  std::int64_t min_component = 0;      ///< drop 6-connected components of fewer voxels
  bool fill_cavities = false;          ///< fill 26-connected background components that do not reach outside the box
};

/// What was changed on request, for the report.
struct ForegroundReport {
  std::int64_t voxels_before = 0;  ///< of the shape, before anything was dropped or filled
  std::int64_t components_removed = 0;
  std::int64_t voxels_removed = 0;
  std::int64_t cavities_filled = 0;
  std::int64_t voxels_filled = 0;
};

/// "36%", "0.02%": at least one digit that is not 0, and 100% only of everything.
std::string percent_text(std::int64_t part, std::int64_t whole);
/// A warning, when dropping components took so much of the shape that it may not have been meant; empty otherwise.
std::string much_dropped(const ForegroundReport& report);

/// The foreground of an image as a voxel shape on the image's grid. Applied in the order invert, components, cavities.
/// Throws Error(input) when nothing is left, naming the range of values found.
VoxelShape foreground(const Volume& volume, const ForegroundOptions& options, ForegroundReport* report = nullptr,
                      Context* context = nullptr);

/// Drops components and fills cavities as asked (the part of ForegroundOptions that also applies to voxelized meshes).
VoxelShape clean(const VoxelShape& shape, const ForegroundOptions& options, ForegroundReport* report = nullptr,
                 Context* context = nullptr);

}  // namespace quench
