// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>

#include "quench/axis.h"
#include "quench/burn.h"
#include "quench/record.h"
#include "session.h"

namespace quench::program {

struct BurnPipelineOptions {
  std::string omega = "auto";
  std::string propagation = "auto";  ///< not an option: what reports say of how fire crosses polygons
  std::string radius = "auto";
};

void add_burn_options(CLI::App& app, BurnPipelineOptions& options);
/// Throws Error(usage) for an option that cannot be, before anything is read.
void check_burn_options(const BurnPipelineOptions& options);

/// Options not given on the command line are taken from the FieldData of a burned file.
void take_burn_parameters(BurnPipelineOptions& options, const Record& burned);

/// Burns an axis (`voxel_core`: one of Quench, whose radii are exact); `resolve(text, option)` turns a length into
/// world units. Checks memory first, says what is left unburned, and adds the section `burn` to the report. `parents`:
/// for the curves.
Burning compute_burning(const MedialAxis& axis, bool voxel_core, const BurnPipelineOptions& options, bool parents,
                        const std::function<double(const std::string&, const std::string&)>& resolve,
                        nlohmann::ordered_json& report, Session& session);

}  // namespace quench::program
