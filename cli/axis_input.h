// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "quench/axis.h"
#include "quench/geometry.h"
#include "session.h"
#include "shape_input.h"

namespace quench::program {

/// How a file becomes a medial axis: the options AXIS arguments share.
struct AxisOptions {
  std::string file, radii, shape;
  std::optional<Threshold> threshold;
  std::optional<std::int64_t> label;
  std::vector<std::filesystem::path> inputs() const;
};

void add_axis_options(CLI::App& app, AxisOptions& options);
void check_axis_options(const AxisOptions& options);

/// A medial axis ready for burning. Vertex v of the axis is row v of the file.
struct LoadedAxis {
  MedialAxis axis;
  Record data;                  ///< the file, with all its arrays
  double longest_side = 0;      ///< what plain-number lengths refer to, world units
  double voxel = 0;             ///< smallest spacing of the voxel shape; 0 where nothing tells
  Vec3 spacing = Vec3::Zero();  ///< of the voxel shape, where the file says so
  bool voxel_core = false;      ///< of Quench: the radius between vertices follows from theirs
  Coordinates coordinates;      ///< where the file says so
  nlohmann::ordered_json input;

  /// World length of an option. Throws Error(usage) for voxels where there are none.
  double resolve(const std::string& text, const std::string& option) const;
};

LoadedAxis load_axis(const AxisOptions& options, Session& session);
/// Of a file that has been read.
LoadedAxis make_axis(const AxisOptions& options, Record&& data, Session& session);
/// The file of an axis, if there is memory for it.
Record read_axis_file(const std::string& file, Session& session);

/// The first value of a field array of a file, if it is there.
std::optional<double> field_number(const Record& data, const char* name);
std::optional<std::string> field_text(const Record& data, const char* name);

}  // namespace quench::program
