// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "io/volume/zarr_array.h"
#include "io/volume/zarr_node.h"
#include "quench/io.h"

namespace quench::io {

/// An axis of an array: sample i is at `first` + i `step`.
struct ZarrAxis {
  std::string name, unit;  ///< empty: not said
  double step = 1, first = 0;
};

/// An array of a multiscale image, by OME-Zarr 0.1 to 0.5.
struct ZarrLevel {
  std::string path;            ///< from the folder of the image
  std::vector<ZarrAxis> axes;  ///< empty: not said
};

/// Whether attributes are those of a multiscale image.
bool is_multiscale(const nlohmann::json& attributes);

/// The finest level, or the one at `path`; nothing where there is no such one. Throws Error(input) where it is damaged.
std::optional<ZarrLevel> zarr_level(const std::filesystem::path& file, const nlohmann::json& attributes,
                                    const std::optional<std::string>& path, Context* context);

/// The axes of an N5 array by `transform`, or by `pixelResolution`, `resolution`, `units`, `downsamplingFactors` and
/// `offset` of the array or, where it does not say, of the group it is in.
std::vector<ZarrAxis> n5_axes(const nlohmann::json& array, const nlohmann::json& group);

/// Which axis of an array is x, y and z, and where it is cut along the others.
struct ZarrSection {
  std::array<std::optional<std::size_t>, 3> axis;  ///< of a plane none for z
  std::vector<std::int64_t> at;                    ///< per axis of the array; 0 for x, y, z
};

/// `axes` as many as the array has, or none. `chosen`: indices by names of axes. Throws Error(input) where it is not
/// clear which section is meant.
ZarrSection zarr_section(const std::filesystem::path& file, const ZarrArray& array, const std::vector<ZarrAxis>& axes,
                         const std::map<std::string, std::int64_t>& chosen);

/// Where the section lies; a spacing of the options is not looked at here.
void place_section(const std::filesystem::path& file, const ZarrSection& section, const std::vector<ZarrAxis>& axes,
                   const VolumeReadOptions& options, Grid& grid, Coordinates& coordinates, Context* context);

}  // namespace quench::io
