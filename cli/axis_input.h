// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "quench/pipeline.h"
#include "session.h"

namespace quench::program {

/// How a file becomes a medial axis: the options AXIS arguments share.
struct AxisInput {
  std::string file, radii, shape;
  pipeline::ShapeOptions how;  ///< which voxels `shape` is
  std::vector<std::filesystem::path> inputs() const;
};

void add_axis_options(CLI::App& app, AxisInput& options);

/// A closed surface without radii: a shape, no medial axis.
bool is_closed_mesh(const Record& data);

/// Reads AXIS with the radii and the size of its shape, as asked.
pipeline::LoadedAxis load_axis(const AxisInput& options, Session& session);
/// The shape that an axis is compared with (not only its size): options not given are those its file says. Of a mesh it
/// is the mesh, whatever the axis is fitted to.
pipeline::LoadedShape load_shape_of(const AxisInput& options, const pipeline::LoadedAxis& axis, Session& session);
/// The report's section `input`.
nlohmann::ordered_json input_section(const AxisInput& options, const pipeline::LoadedAxis& axis);

}  // namespace quench::program
