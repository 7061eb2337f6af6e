// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "quench/axis.h"
#include "quench/burn.h"
#include "quench/graph.h"
#include "quench/pipeline.h"
#include "quench/record.h"
#include "quench/shape.h"
#include "quench/skeleton.h"
#include "session.h"

namespace quench::program {

struct SkeletonPipelineOptions {
  std::string theta2 = "0.03";
  std::string theta1 = "0.02";
  bool full = false;
  int smooth = 10;
  std::string resample = "0";
  std::string tips = "full";  ///< of the graph files: grown back, or "pruned" as in the skeleton
  std::string root;           ///< x,y,z or empty
  std::string swc_type = "dendrite";
};

/// Files of the curves; empty names are not written.
struct GraphFiles {
  std::filesystem::path swc, graphml, csv;
};

void add_skeleton_options(CLI::App& app, SkeletonPipelineOptions& options);
/// Throws Error(usage) for an option that cannot be, before anything is read.
void check_skeleton_options(const SkeletonPipelineOptions& options);

/// Medial curves and a skeleton of a burned axis (the burning is used up); `resolve(text, option)` turns a length into
/// world units. Adds the sections `curves` and `skeleton` to the report. Throws Error(invariant) when the topology of
/// the curves or of the skeleton is not that of the axis. `use_family` sees the whole family.
CheckedSkeleton compute_skeleton(const MedialAxis& axis, Burning&& burning, const SkeletonPipelineOptions& options,
                                 double finest,
                                 const std::function<double(const std::string&, const std::string&)>& resolve,
                                 nlohmann::ordered_json& report, Session& session,
                                 const std::function<void(const SkeletonFamily&)>& use_family = {});

/// The curves of a skeleton as a graph, smoothed as asked, into files; adds what they hold to the report's section
/// `skeleton`. `shape`: the voxel shape, where it is known; `spacing`: of its voxels, 0 for axes of other programs.
/// Radii then get half a voxel more: of the corners of a staircase the nearest lies that far inside the surface it
/// stands for.
void write_graph(const Skeleton& skeleton, const GraphFiles& files, const SkeletonPipelineOptions& options,
                 const VoxelShape* shape, const Vec3& spacing, const Coordinates& coordinates,
                 const std::function<double(const std::string&, const std::string&)>& resolve,
                 nlohmann::ordered_json& report, Session& session);

}  // namespace quench::program
