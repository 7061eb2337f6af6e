// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "quench/pipeline.h"
#include "session.h"

namespace quench::program {

/// How a file becomes a voxel shape: the options SHAPE arguments share.
struct ShapeOptions {
  std::string file;
  pipeline::ShapeOptions how;
  std::vector<std::string> recorded;  ///< what take_recorded() has set
  std::string recorded_in;            ///< the file they are from
};

void add_shape_options(CLI::App& app, ShapeOptions& options);
/// --resolution, --fill and --topology alone, for commands that show a shape.
CLI::Option* add_resolution(CLI::App& app, ShapeOptions& options, const std::string& help);
CLI::Option* add_fill(CLI::App& app, ShapeOptions& options, const std::string& help);
CLI::Option* add_topology(CLI::App& app, ShapeOptions& options, const std::string& help);

/// Which voxels of a volume are the shape, and what is done to it before: the options of all commands that take one.
/// `of`: what the help says first, e.g. "Volume, image: ".
void add_volume_options(CLI::App& app, pipeline::ShapeOptions& how, const std::string& of, const std::string& group);
/// Whether one of them is given.
bool has_volume_options(const pipeline::ShapeOptions& how);

/// Throws the Error of an option that cannot be or of a file that is not there, before anything is read.
void check_shape_options(const ShapeOptions& options);
/// Says which of the options have no effect on a file of that kind.
/// `plane`: of a file that is an image.
void say_ignored(const ShapeOptions& options, io::Kind kind, Session& session, bool plane = false);
/// Throws Error(failed) for a file that is not there.
void check_exists(const std::filesystem::path& file);
/// Throws Error(input) for a medial axis or a skeleton, given where a mesh is expected: what takes it.
void refuse_result(const Record& data, const std::string& file);

/// What the axis is fitted to in bricks where nothing else is asked for: not to the grey values of a volume, whose
/// surface takes more memory than its axis.
void choose_surface_in_bricks(ShapeOptions& options, Session& session);

/// Reads SHAPE; says what the user should know (assumptions, warnings).
pipeline::LoadedShape load_shape(const ShapeOptions& options, Session& session);
/// The report's section `input`.
nlohmann::ordered_json input_section(const ShapeOptions& options, const pipeline::LoadedShape& shape);

/// Options not given on the command line are taken from the result in `file`.
void take_recorded(ShapeOptions& options, const Record& result, const std::string& file);

/// --channel and --dimension alone, for commands that show an image.
CLI::Option* add_channel(CLI::App& app, std::string& channel);
CLI::Option* add_dimension(CLI::App& app, std::optional<int>& dimension);

}  // namespace quench::program
