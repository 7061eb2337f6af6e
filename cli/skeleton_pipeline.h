// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "quench/burn.h"
#include "quench/medial_axis.h"
#include "quench/skeleton.h"
#include "quench/topology.h"
#include "session.h"

namespace quench::program {

struct SkeletonPipelineOptions {
  std::string theta2 = "0.03";
  std::string theta1 = "0.02";
  bool full = false;
};

void add_skeleton_options(CLI::App& app, SkeletonPipelineOptions& options);
/// Throws Error(usage) for an option that cannot be, before anything is read.
void check_skeleton_options(const SkeletonPipelineOptions& options);

struct SkeletonPipelineResult {
  Skeleton skeleton;
  Topology topology;
};

/// Medial curves and a skeleton of a burned axis (the burning is used up); `resolve(text, option)` turns a length into world units. Adds the
/// sections `curves` and `skeleton` to the report. Throws Error(invariant) when the topology of the curves or of the
/// skeleton is not that of the axis.
SkeletonPipelineResult compute_skeleton(const MedialAxis& axis, Burning&& burning,
                                        const SkeletonPipelineOptions& options,
                                        const std::function<double(const std::string&, const std::string&)>& resolve,
                                        nlohmann::ordered_json& report, Session& session);

}  // namespace quench::program
