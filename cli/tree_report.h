// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "quench/pipeline.h"
#include "session.h"

/// Trees as sections of a report and as sentences.
namespace quench::program {

/// "mm", or "the input's units".
std::string unit_text(const Coordinates& coordinates);

/// `repair`: what came in, what was changed, and the file that lists it.
nlohmann::ordered_json repair_section(const pipeline::TreeRun& run, const std::string& list);
/// `tree`: plants, axes by level, branches, the units.
nlohmann::ordered_json tree_section(const pipeline::TreeRun& run);
/// `traits`: the row of the sample by names of columns; null where a value is not defined.
nlohmann::ordered_json traits_section(const Table& sample);

/// What came in, and what was repaired.
void say_repair(const pipeline::TreeRun& run, const std::string& list, Session& session);
/// "312 axes (1 of level 0, 120 of level 1, ...), total length 12.3 mm".
std::string tree_text(const pipeline::TreeRun& run);

}  // namespace quench::program
