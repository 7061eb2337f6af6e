// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>

#include "session.h"

namespace quench::program {

/// Parses the command line and runs the subcommand; returns the exit code (0 ok, 1 failed, 2 usage, 3 input,
/// 4 invariant, 130 interrupted).
int run(int argc, char** argv);

/// Throws the Error(usage) of a command line whose words these are, without doing anything else.
void check_command(const std::vector<std::string>& words);
/// The words of a command and its options, with the options of `own` in place of those of the same name.
std::vector<std::string> with_own_options(const std::vector<std::string>& words, const std::vector<std::string>& own);
/// A command line as it can be typed again.
std::string command_text(const std::vector<std::string>& words);

/// A subcommand adds its options to the app and returns what to do once they are parsed; what it needs to keep lives
/// in the returned function. One file per subcommand.
using Action = std::function<int(Session&)>;
/// Throws Error(usage) unless the extension is that of the volumes Quench writes.
void check_volume_format(const std::filesystem::path& output);
/// Throws Error(usage) with the sentence `formats` unless the file is one of a mesh.
void check_mesh_format(const std::filesystem::path& output, const std::string& formats);

Action add_sample(CLI::App& app);
Action add_voxelize(CLI::App& app);
Action add_core(CLI::App& app);
Action add_bricks_plan(CLI::App& app);
Action add_bricks_run(CLI::App& app);
Action add_bricks_merge(CLI::App& app);
Action add_bricks_status(CLI::App& app);
Action add_info(CLI::App& app);
Action add_convert(CLI::App& app);
Action add_burn(CLI::App& app);
Action add_skeleton(CLI::App& app);
Action add_reconstruct(CLI::App& app);
Action add_simplify(CLI::App& app);
Action add_smooth(CLI::App& app);
Action add_verify(CLI::App& app);
Action add_run(CLI::App& app);
Action add_tree(CLI::App& app);
Action add_parts(CLI::App& app);
Action add_thickness(CLI::App& app);
Action add_view(CLI::App& app);
Action add_batch(CLI::App& app);

}  // namespace quench::program
