// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <string>

#include "quench/io.h"
#include "quench/pipeline.h"
#include "session.h"
#include "shape_input.h"

namespace quench::program {

struct CorePipelineOptions {
  std::string lambda = "auto";
  std::string rule = "coface";
  bool full = false;
};

void add_core_options(CLI::App& app, CorePipelineOptions& options);
/// Throws Error(usage) for an option that cannot be, before anything is read.
void check_core_options(const CorePipelineOptions& options);

/// The pruned (or, with --full, whole) core of a shape, and the report of all stages so far.
struct CorePipelineResult {
  CheckedCore core;
  nlohmann::ordered_json report;
};

/// Voxel core, levels, lambda, reconstruction and topology of a loaded shape. Throws Error(invariant) when a promise
/// does not hold: topology of core and pruning must be that of the shape.
CorePipelineResult compute_core(const LoadedShape& loaded, const CorePipelineOptions& options, Session& session);

/// Writes `report` with seconds, peak memory and version filled in; "-" is stdout.
void write_report(const std::string& file, nlohmann::ordered_json report, Session& session);

/// Ends a command that writes: the report of --json, if any, joins the other outputs, all appear together, and a report
/// for stdout comes last, so that a result is not lost with a reader of stdout that has gone.
void write_report(io::OutputGroup& outputs, const nlohmann::ordered_json& report, Session& session);

/// JSON as text; bytes that are no UTF-8 (names of files may be anything) are replaced.
/// "5 vertices, 1 edge, 0 faces".
std::string cells_text(std::size_t vertices, std::size_t edges, std::size_t faces);

std::string json_text(const nlohmann::ordered_json& value, int indent = -1);

/// One line on what was written where, in which units. `report` may be empty.
void say_written(Session& session, const std::string& axis, const std::string& report, const CheckedCore& core,
                 const LoadedShape& loaded);

}  // namespace quench::program
