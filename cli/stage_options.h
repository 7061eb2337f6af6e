// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <cstddef>
#include <optional>
#include <string>

#include "quench/pipeline.h"

/// The options of the stages, each a value of quench/pipeline.h.
namespace quench::program {

/// A length of its own, or one that may be "auto".
CLI::Option* add_length(CLI::App& app, const std::string& name, pipeline::Length& length, const std::string& help);
CLI::Option* add_length(CLI::App& app, const std::string& name, std::optional<pipeline::Length>& length,
                        const std::string& help);

void add_core_options(CLI::App& app, pipeline::AxisOptions& options);
/// `takes_burned`: the command takes what it is not told from a burned file, by pipeline::take_recorded().
void add_burn_options(CLI::App& app, pipeline::BurningOptions& options, bool takes_burned);

/// How the curves of a skeleton become a graph and its files.
struct GraphFileOptions {
  pipeline::GraphOptions graph;
  std::optional<Vec3> root;  ///< none: the thickest node
  std::string swc_type = "dendrite";
};
CLI::Option* add_theta1(CLI::App& app, pipeline::SkeletonOptions& options, const std::string& help);
/// --theta1, --smooth, --resample and --tips: what a skeleton of curves takes.
void add_curve_options(CLI::App& app, pipeline::SkeletonOptions& options, GraphFileOptions& graph,
                       const std::string& theta1_help);
void add_skeleton_options(CLI::App& app, pipeline::SkeletonOptions& options, GraphFileOptions& graph);
/// Three numbers x,y,z. Throws Error(usage), naming the option.
Vec3 point_of(const std::string& option, const std::string& text);
CLI::Option* add_swc_type(CLI::App& app, std::string& type);

void add_page_options(CLI::App& app, std::size_t& max_triangles);

}  // namespace quench::program
