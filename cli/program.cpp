// SPDX-License-Identifier: Apache-2.0
#include "program.h"

#include <fmt/format.h>

namespace quench::program {
namespace {

struct Command {
  const char* name;
  const char* summary;
  const char* example;
  Action (*add)(CLI::App&);
};

constexpr Command kCommands[] = {
    {"run", "The main job: everything Quench computes of a shape, into a folder", "quench run bunny.off --resolution 512 -o bunny", add_run},
    {"sample", "Writes a built-in shape", "quench sample root --seed 7 -o root.ply", add_sample},
    {"voxelize", "Writes the voxel shape of a mesh or a volume", "quench voxelize part.stl --resolution 256 -o part.nrrd", add_voxelize},
    {"core", "Computes the voxel core, pruned", "quench core ct.nrrd --threshold 20 --lambda 2.5vox -o axis.vtp", add_core},
    {"info", "Says what a file is", "quench info axis.vtp", add_info},
    {"convert", "Writes a mesh or a medial axis in another format", "quench convert axis.vtp axis.ma", add_convert},
    {"verify", "Proves a result against its shape", "quench verify ct.nrrd axis.vtp", add_verify},
};

void add_common(CLI::App& app, CommonOptions& options) {
  app.add_option("--threads", options.threads, "Threads; 0: all processors")->capture_default_str()->group("Common");
  app.add_option("--memory-limit", options.memory_limit, "Refuse to start what needs more, e.g. 8G [default: the memory that is free]")->group("Common");
  if (app.get_name() == "info")  // its answer is the report
    app.add_flag_callback("--json", [&options] { options.report = "-"; }, "Answer as JSON")->group("Common");
  else
    app.add_option("--json", options.report, "Write a report to this file ('-': to stdout)")->group("Common");
  app.add_flag("--quiet", options.quiet, "No progress and no notes")->group("Common");
  app.add_flag("--verbose", options.verbose, "More about what is done")->group("Common");
  app.add_flag("--overwrite", options.overwrite, "Replace existing outputs")->group("Common");
}

}  // namespace

int run(int argc, char** argv) {
  CLI::App app{"Quench: medial axes of real 3D shapes, exact and with the topology of the shape.", "quench"};
  app.set_version_flag("--version", std::string("quench " QUENCH_VERSION));
  app.require_subcommand(1);
  app.footer("Every command has its own --help with an example.\nExit codes: 0 ok, 1 failed, 2 usage, 3 unusable input, 4 a promised invariant "
             "failed, 130 interrupted.");
  CommonOptions common;
  std::vector<std::pair<CLI::App*, Action>> actions;
  for (const Command& command : kCommands) {
    CLI::App* sub = app.add_subcommand(command.name, command.summary);
    sub->footer(fmt::format("Example:\n  {}", command.example));
    actions.emplace_back(sub, command.add(*sub));
    add_common(*sub, common);
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    throw Error(ErrorCode::usage, fmt::format("{} (see quench --help)", error.what()));
  }
  Session session(common);
  for (const auto& [sub, action] : actions)
    if (sub->parsed()) return action(session);
  return 0;
}

}  // namespace quench::program
