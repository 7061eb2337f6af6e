// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>

#include "quench/axis.h"
#include "quench/burn.h"
#include "quench/context.h"
#include "quench/graph.h"
#include "quench/record.h"
#include "quench/shape.h"
#include "quench/skeleton.h"

/// @file
/// The stages in a row, each promise checked on the way, and their results as files: what the program and the Python
/// module have in common.
namespace quench {

/// Throws Error(invariant) with the Betti numbers of both unless the two agree: "the topology of the WHAT ... is not
/// that of the WHOSE".
void require_topology(const Topology& got, const Topology& wanted, const char* what, const char* whose);

struct CheckedCoreOptions {
  std::optional<double> lambda;  ///< world units; none: auto_lambda()
  LambdaRule rule = LambdaRule::coface;
  bool full = false;       ///< also the cells below lambda
  bool in_bricks = false;  ///< as CoreOptions::in_bricks
};

/// A pruned (or, `full`, whole) voxel core with what was found on the way.
struct CheckedCore {
  MedialAxis axis;
  CheckedCoreOptions options;
  double lambda = 0;                               ///< that was used or chosen, world units
  double longest_side = 0;                         ///< what lengths refer to
  Topology topology;                               ///< of shape, core and pruned core
  double reconstructed = 0;                        ///< share of the shape in the balls of the pruned core
  double whole = 0;                                ///< the same of the unpruned one
  std::size_t vertices = 0, edges = 0, faces = 0;  ///< of the unpruned core
  std::size_t kept_vertices = 0, kept_edges = 0, kept_faces = 0;  ///< of the pruned one
};

/// Voxel core, levels, lambda, pruning, reconstruction. `wanted`: the topology of the shape, which core and pruning
/// are checked against; throws Error(invariant) when they differ.
CheckedCore checked_core(const VoxelShape& shape, const Topology& wanted, double longest_side,
                         const CheckedCoreOptions& options = {}, Context* context = nullptr);

/// The axis as a file: cells and arrays (docs/user/files.md), and as field data stage, lambda, longest_side,
/// reconstructed, topology, units, space, version and `parameters`, the JSON text from which `quench verify` takes how
/// the shape was made.
Record core_file(const CheckedCore& core, const Coordinates& coordinates, const std::string& parameters);
/// The same where the axis is not needed any more: it is empty afterwards, the rest of `core` as it was.
Record core_file(CheckedCore&& core, const Coordinates& coordinates, const std::string& parameters);

struct CheckedSkeletonOptions {
  double theta2 = 0, theta1 = 0;                          ///< world units, may be infinite
  bool parts = false;                                     ///< as ExtractOptions::parts
  double tips = std::numeric_limits<double>::infinity();  ///< of `measured`, as ExtractOptions::tips
};

struct CheckedSkeleton {
  Skeleton skeleton;
  Skeleton measured;  ///< the same with the tips of branches grown back: what lengths are measured on
  Topology topology;
};

/// One member of a family. Throws Error(invariant) when its topology is not `wanted`, that of the medial axis.
CheckedSkeleton checked_skeleton(const SkeletonFamily& family, const Topology& wanted,
                                 const CheckedSkeletonOptions& options, Context* context = nullptr);

/// The skeleton as a file: its cells and arrays, and what the file `from` of its axis says of shape and burning.
Record skeleton_file(const Skeleton& skeleton, const Topology& topology, const Record& from);

/// Share of the shape's (sampled) voxel centres in the balls of a skeleton's vertices.
double reconstructed_share(const VoxelShape& shape, const Skeleton& skeleton, Context* context = nullptr);

struct GraphOptions {
  int smooth = 10;                    ///< as SmoothOptions::iterations
  double resample = 0;                ///< as SmoothOptions::spacing
  const VoxelShape* shape = nullptr;  ///< where it is known: segments are tested against its voxels
  Vec3 voxel = Vec3::Zero();          ///< spacing of the voxels; 0 for axes of other programs
};

/// The curves of a skeleton as a graph to measure on, smoothed as asked. Radii of a voxel core get half a voxel more:
/// of the corners of a staircase the nearest lies that far inside the surface it stands for.
CurveGraph measured_graph(const Skeleton& skeleton, const GraphOptions& options = {});

/// Memory that quench_curves() and skeletons() need for a burning, in bytes.
std::int64_t predicted_skeleton_bytes(const Burning& burning);

}  // namespace quench
