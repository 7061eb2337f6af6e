// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "quench/record.h"
#include "quench/shape.h"
#include "session.h"

namespace quench::program {

/// How a file becomes a voxel shape: the options SHAPE arguments share.
struct ShapeOptions {
  std::string file;
  std::string resolution = "256";
  bool resolution_given = false;
  std::string fill = "nonzero";
  bool fill_given = false;
  std::string spacing;
  ForegroundOptions foreground;
  std::vector<std::string> recorded;  ///< of the options for volumes, those that take_parameters() has set
  std::string recorded_in;            ///< the file they are from
  int subdivide = 1;
  bool keep_mesh = false;    ///< LoadedShape::mesh is wanted
  bool core_follows = true;  ///< its memory counts too when the shape is subdivided
};

/// Nothing for 'auto'. Throws Error(usage) for what is not a resolution.
std::optional<std::int64_t> parse_resolution(const std::string& text);

void add_shape_options(CLI::App& app, ShapeOptions& options);
/// Throws the Error of an option that cannot be or of a file that is not there, before anything is read.
void check_shape_options(const ShapeOptions& options);

/// Throws the Error of a file whose name does not say what it holds.
[[noreturn]] void refuse_unknown_kind(const std::string& file);

/// A shape ready for the main job.
struct LoadedShape {
  VoxelShape shape;
  double longest_side = 0;               ///< what plain-number lengths refer to, world units
  std::string kind;                      ///< "mesh" or "volume"
  Coordinates coordinates;               ///< where the file says so
  nlohmann::ordered_json input;          ///< the report's section `input`
  nlohmann::ordered_json parameters;     ///< what made the voxel shape of the file
  std::optional<bool> topology_changed;  ///< by voxelization; none for volumes and meshes with overlapping parts
  Topology topology;
  std::optional<TriangleMesh> mesh;  ///< the file, where it was asked for and is one
};

/// Reads SHAPE; says what the user should know (assumptions, warnings).
LoadedShape load_shape(const ShapeOptions& options, Session& session);

/// Says that a volume is one picture (PNG, TIFF, a folder with one of them), where it is: a slab one voxel thick is
/// seldom what was meant.
void say_picture(const std::string& file, const Grid& grid, Session& session);

/// "0.5 x 0.5 x 2 um": the sides of a voxel.
std::string spacing_text(const Grid& grid, const std::string& units);

/// Options not given on the command line are taken from the FieldData `parameters` of the result in `file`. Throws
/// Error(input) naming the file and the parameter when it cannot be.
void take_parameters(ShapeOptions& options, const Record& result, const std::string& file);

/// The voxelizer needs up to four numbers per scanline and two runs: throws Error(failed) before any is made when there
/// is no memory for them.
void check_voxelization_memory(const TriangleMesh& mesh, std::int64_t resolution, const Session& session);

/// For the report: null where it cannot be told (overlapping parts); false for a volume.
nlohmann::ordered_json topology_changed_of(const LoadedShape& loaded);

/// FieldData `parameters` holds this as JSON text.
std::string parameters_of(const Record& result);

}  // namespace quench::program
