// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "quench/geometry.h"
#include "quench/record.h"
#include "session.h"

namespace quench::program {

CLI::Option* add_units(CLI::App& app, std::string& units);

/// Puts the unit of --units, if it is given, in place of what `file` says, with a note where that is another. No number
/// changes.
void take_units(Coordinates& coordinates, const std::string& file, Session& session);
/// The same for the field `units` of a file's arrays.
void take_units(Record& data, const std::string& file, Session& session);

}  // namespace quench::program
