// SPDX-License-Identifier: Apache-2.0
#include "program.h"

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cstring>

#include "option_checks.h"
#include "shell_files.h"
#include "slicer_module.h"
#include "units.h"

namespace quench::program {
namespace {

// Which of the common options mean something for a command.
enum Common : unsigned { computes = 1, writes = 2, reports = 4, answers_json = 8, names_units = 16 };

struct Command {
  const char* name;  // "bricks plan" is the command `plan` of `bricks`
  const char* summary;
  const char* example;
  unsigned common;
  Action (*add)(CLI::App&);
};

constexpr Command kCommands[] = {
    {"run", "The main job: everything Quench computes of a shape, into a folder",
     "quench run bunny.off --resolution 512 -o bunny", computes | writes | reports | names_units, add_run},
    {"tree", "Roots, neurons, vessels, airways: one tree per plant, its axes and what is measured of them",
     "quench tree root_ct.nrrd -o root", computes | writes | reports | names_units, add_tree},
    {"batch", "Measures many samples: behind '--' stand 'tree' or 'run' and the options for all of them",
     "quench batch scans -o measured -- tree --kind root", computes | writes, add_batch},
    {"sample", "Writes a built-in shape", "quench sample root --seed 7 -o root.ply", writes, add_sample},
    {"voxelize", "Writes the voxel shape of a mesh or a volume",
     "quench voxelize part.stl --resolution 256 -o part.nrrd", computes | writes | reports | names_units, add_voxelize},
    {"core", "Computes the medial axis of the voxel shape (its voxel core), pruned",
     "quench core ct.nrrd --threshold 20 --detail 2vox -o axis.vtp", computes | writes | reports | names_units,
     add_core},
    {"bricks plan", "Cuts the work on a large shape into bricks, in a folder that tasks share",
     "quench bricks plan brain.zarr --threshold 300 -o work", computes | reports | names_units, add_bricks_plan},
    {"bricks run", "Does the bricks of a task: one of an array of jobs, or all",
     "quench bricks run work --round 1 --task 0/100", computes, add_bricks_run},
    {"bricks merge", "Makes the medial axis of what all tasks have done", "quench bricks merge work -o axis.vtp",
     computes | writes | reports, add_bricks_merge},
    {"bricks status", "Says what is done, and what it took", "quench bricks status work", answers_json,
     add_bricks_status},
    {"burn", "Adds burn time and erosion thickness to a medial axis", "quench burn axis.vtp -o burned.vtp",
     computes | writes | reports | names_units, add_burn},
    {"skeleton", "Computes a skeleton of sheets and curves of a medial axis",
     "quench skeleton burned.vtp --theta2 inf --swc tree.swc -o curves.vtp", computes | writes | reports | names_units,
     add_skeleton},
    {"reconstruct",
     "Writes the solid of a medial axis, its balls or all between them, and how far it is from the shape",
     "quench reconstruct axis.vtp --envelope --shape bunny.off -o solid.ply", computes | writes | reports | names_units,
     add_reconstruct},
    {"parts", "Names the sheets, seams and junctions of a skeleton; measures each, writes each sheet as a mesh",
     "quench parts casting.off --remesh 2% -o casting_parts", computes | writes | reports | names_units, add_parts},
    {"thickness", "Local thickness: as a volume, on the surface, as tables; of pores, too",
     "quench thickness bone.nrrd --threshold 64 -o thickness.nrrd --csv thickness.csv",
     computes | writes | reports | names_units, add_thickness},
    {"simplify", "Makes a medial axis one of few vertices whose balls, cones and slabs stay near the shape",
     "quench simplify bunny/core.vtp --vertices 200 --shape bunny.off -o bunny.ma",
     computes | writes | reports | names_units, add_simplify},
    {"smooth", "Smooths the sheets and curves of a medial axis, by no more than a length",
     "quench smooth axis.vtp --most 0.5vox -o smooth.vtp", computes | writes | reports | names_units, add_smooth},
    {"view", "Writes an interactive page of a medial axis or a skeleton: one HTML file, or a picture of it",
     "quench view bunny/core.vtp --shape bunny.off -o bunny.html", computes | writes | reports | names_units, add_view},
    {"info", "Says what a file is", "quench info axis.vtp", answers_json, add_info},
    {"convert", "Writes a mesh or a medial axis in another format", "quench convert axis.vtp axis.ma",
     writes | names_units, add_convert},
    {"verify", "Checks a result against its shape, or prints what is wrong", "quench verify ct.nrrd axis.vtp",
     computes | writes | reports, add_verify},
};

void add_common(CLI::App& app, CommonOptions& options, unsigned common) {
  const auto group = "Common";
  add_number(app, "--threads", options.threads, "Threads, up to 256; 0: all processors", 0,
             256)  // a thread costs memory even when it has no processor
      ->type_name("N")
      ->capture_default_str()
      ->group(group);
  app.add_option("--memory-limit", options.memory_limit,
                 "Work in bricks or refuse to start what needs more, e.g. 8G [default: the memory that is free]")
      ->type_name("BYTES")
      ->group(group);
  if (common & answers_json)
    app.add_flag_callback(
           "--json", [&options] { options.report = "-"; }, "Answer as JSON")
        ->group(group);
  if (common & reports)
    app.add_option("--json", options.report, "Write a report to this file ('-': to stdout)")
        ->type_name("FILE")
        ->group(group);
  if (common & names_units) add_units(app, options.units)->group(group);
  if (common & writes) app.add_flag("--overwrite", options.overwrite, "Replace existing outputs")->group(group);
  app.add_flag("--quiet", options.quiet, "No progress and no notes")->group(group);
  if (common & computes)
    app.add_flag("--verbose", options.verbose, "Also say the time of every stage and the memory used")->group(group);
}

constexpr const char* kBricksSummary =
    "The medial axis of a shape that no machine holds, in tasks: the same to the byte as that of 'core'";

/// Whether the word of a command follows.
bool has_commands(const CLI::App& app) {
  return !app.get_subcommands([](const CLI::App*) { return true; }).empty();
}

/// "quench bricks plan"
std::string full_name(const CLI::App& app) {
  return app.get_parent() ? full_name(*app.get_parent()) + " " + app.get_name() : app.get_name();
}

/// The command that was given: `app` itself where there is none.
const CLI::App& used_command(const CLI::App& app) {
  const auto used = app.get_subcommands();
  return used.empty() ? app : used_command(*used.front());
}

std::string names_of_commands(const CLI::App& of) {
  std::string names;
  for (const CLI::App* command : of.get_subcommands([](const CLI::App*) { return true; }))
    names += (names.empty() ? "" : ", ") + command->get_name();
  return names;
}

/// `of`: the program, or a command that has commands.
std::string unknown_command(const std::string& word, const CLI::App& of) {
  std::vector<std::string> names;
  for (const CLI::App* command : of.get_subcommands([](const CLI::App*) { return true; }))
    names.push_back(command->get_name());
  const std::string meant = nearest_name(word, names);
  return fmt::format(
      "unknown command '{}'; {}", word,
      meant.empty() ? "commands are " + names_of_commands(of) : fmt::format("did you mean '{}'?", meant));
}

std::string unknown_option(const std::string& word, const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  const std::string meant = nearest_name(word.substr(0, word.find('=')), names);
  return fmt::format("there is no option {}{}", word, meant.empty() ? "" : fmt::format("; did you mean {}?", meant));
}

/// Whether a word is an option rather than a value: "--" and what follows it, the short options of the command. "-" is
/// stdout, and negative numbers are values.
bool is_option(const CLI::App& command, const std::string& word) {
  return word.starts_with("--") || (word.size() == 2 && word[0] == '-' && command.get_option_no_throw(word));
}

/// After an option that takes a value: CLI11 takes the next word for it even when that is an option, too.
void refuse_option_as_value(const CLI::App& command, const std::string& option, const std::string& value) {
  if (!is_option(command, value)) return;
  const bool known = command.get_option_no_throw(value.substr(0, value.find('='))) != nullptr;
  throw Error(ErrorCode::usage, fmt::format("{} needs a value ('{}' {})", option, value,
                                            known           ? "is an option"
                                            : value == "--" ? "ends the options"
                                                            : "begins as an option does"));
}

/// A word of the form "name=value" that CLI11 reads otherwise: "--json=" as "--json", whose value is then the next
/// word, and "-o=file" as a file named "=file".
void refuse_misread_equals(const CLI::App& command, const std::string& word, std::size_t equals) {
  const std::string name = word.substr(0, equals);
  if (name.starts_with("--") && name.size() > 2 && equals + 1 == word.size()) {
    const CLI::Option* option = command.get_option_no_throw(name);
    throw Error(ErrorCode::usage,
                option ? fmt::format("{} {}", name, empty_value_text(*option))
                       : fmt::format("{}; see {} --help", unknown_option(name, command), full_name(command)));
  }
  if (name.size() == 2 && name[1] != '-')
    throw Error(ErrorCode::usage,
                fmt::format("'{}': after {} the value follows without '=', or as the next word", word, name));
}

/// What CLI11 would take for something else than was meant.
void refuse_misread_words(const CLI::App& app, const std::vector<std::string>& words) {
  const CLI::App* command = &app;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string& word = words[i];
    if (word == "--") return;
    if (!word.starts_with('-') && has_commands(*command)) {
      const auto named = command->get_subcommands([&](const CLI::App* sub) { return sub->get_name() == word; });
      if (named.empty()) return;
      command = named.front();
    } else if (word.starts_with('-')) {
      const CLI::App& at = *command;
      if (const std::size_t equals = word.find('='); equals != std::string::npos) {
        refuse_misread_equals(at, word, equals);
      } else if (const CLI::Option* option = at.get_option_no_throw(word);
                 option && option->get_items_expected_max() > 0 && i + 1 < words.size()) {
        refuse_option_as_value(at, word, words[++i]);
      }
    }
  }
}

/// One sentence on what is wrong with the command line.
std::string usage_sentence(const CLI::ParseError& error, const CLI::App& app) {
  const CLI::App& at = used_command(app);
  const std::vector<std::string> left = at.remaining();
  const auto option = std::find_if(left.begin(), left.end(),
                                   [](const std::string& word) { return word.starts_with('-') && word != "-"; });
  const std::string help = full_name(at) + " --help";
  const auto with_help = [&](const std::string& sentence) {
    return fmt::format("{}{} see {}", sentence, sentence.ends_with('?') ? "" : ";", help);
  };
  if (has_commands(at) && !left.empty() && !left.front().starts_with('-'))
    return with_help(unknown_command(left.front(), at));
  if (option != left.end()) return with_help(unknown_option(*option, at));
  if (has_commands(at)) return fmt::format("give a command: {}; see {}", names_of_commands(at), help);
  if (!left.empty()) return fmt::format("'{}' is one argument too many; see {}", left.front(), help);
  std::string what = error.what();
  // CLI11's sentences, rephrased: "Could not convert: --threads = abc", "--threads: 1 required N missing".
  if (const std::string could_not = "Could not convert: "; what.starts_with(could_not)) {
    const std::size_t equals = what.find(" = ");
    what = fmt::format("{} cannot be '{}'", what.substr(could_not.size(), equals - could_not.size()),
                       what.substr(equals + 3));
  } else if (const std::size_t colon = what.find(": 1 required "); colon != std::string::npos) {
    what = what.substr(0, colon) + " needs a value";
  } else if (const std::size_t many = what.find(": At Most 1 required"); many != std::string::npos) {
    what = what.substr(0, many) + " is given more than once";
  } else if (dynamic_cast<const CLI::ValidationError*>(&error)) {  // ours, behind the name of the option
    what.replace(what.find(": "), 2, " ");
  }
  return with_help(what);
}

}  // namespace

std::string command_text(const std::vector<std::string>& words) {
  std::string line = "quench";
  for (const std::string& word : words) {
    const auto plain = [](char c) {
      return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || std::strchr("_.,:+@%/=-", c);
    };
    if (!word.empty() && std::all_of(word.begin(), word.end(), plain)) {
      line += fmt::format(" {}", word);
      continue;
    }
    line += " '";
    for (const char c : word) line += c == '\'' ? std::string("'\\''") : std::string(1, c);
    line += "'";
  }
  return line;
}

namespace {

/// The sentence of an error with the option of this command for its field, where there is one: in place of the name the
/// library has for it, or behind.
std::string with_option(const Error& error, const CLI::App& command, const CommonOptions& common) {
  const std::string sentence = error.what(), &field = error.field();
  std::string option = "--" + field;
  std::replace(option.begin(), option.end(), '_', '-');
  if (field.empty() || !command.get_option_no_throw(option)) return sentence;
  if (sentence.starts_with(field + " '")) return option + sentence.substr(field.size());
  if (field == "memory_limit")
    return sentence +
           (common.memory_limit.empty() ? ", or --memory-limit to try all the same" : ", or a larger --memory-limit");
  if (field == "threshold")
    option = sentence.find("invert it") == sentence.npos ? "--threshold, --label" : "--threshold, --invert, --label";
  return fmt::format("{} [{}]", sentence, option);
}

/// What --xml throws, before it is known whether anything is missing.
struct DescriptionAsked : CLI::Success {
  explicit DescriptionAsked(CLI::App* of) : command(of) {}
  CLI::App* command;
};

/// The program's command line: all commands with their options.
struct CommandLine {
  CommandLine() {
    app.set_version_flag("--version", std::string("quench " QUENCH_VERSION));
    app.require_subcommand(1);
    app.footer(
        "Every command has its own --help with an example.\nExit codes: 0 ok, 1 failed, 2 usage, 3 unusable input, 4 a "
        "promised invariant "
        "failed, 130 interrupted.");
    for (const Command& command : kCommands) {
      CLI::App* sub = added(command);
      sub->footer(fmt::format("Example:\n  {}", command.example));
      actions.emplace_back(sub, command.add(*sub));
      add_common(*sub, common, command.common);
      if (is_slicer_module(command.name))
        sub->add_flag_callback(
               "--xml", [sub] { throw DescriptionAsked(sub); },
               "Only print the command's description as a command line module of 3D Slicer")
            ->group("Common");
      refuse_empty_values(*sub);
    }
  }

  /// The command, or one that belongs to another.
  CLI::App* added(const Command& command) {
    const std::string name = command.name;
    const std::size_t blank = name.find(' ');
    if (blank == name.npos) return app.add_subcommand(name, command.summary);
    const auto there = app.get_subcommands([&](CLI::App* sub) { return sub->get_name() == name.substr(0, blank); });
    CLI::App* of = there.empty() ? app.add_subcommand(name.substr(0, blank), kBricksSummary) : there.front();
    return of->require_subcommand(1)->add_subcommand(name.substr(blank + 1), command.summary);
  }

  /// Throws CLI::ParseError, or Error(usage). What stands behind the "--" of a batch is for another command.
  void parse(std::vector<std::string> words) {
    refuse_misread_words(app, words);
    common.command = command_text(words);
    if (!words.empty() && words[0] == "batch") {
      const auto end = std::ranges::find(words, "--");
      if (end != words.end()) common.words.assign(end + 1, words.end());
      words.erase(end, words.end());
    }
    std::ranges::reverse(words);  // as CLI11 wants them
    app.parse(words);
  }

  const CLI::App& used() const { return used_command(app); }

  CLI::App app{"Quench: medial axes of real 3D shapes, exact and with the topology of the shape.", "quench"};
  CommonOptions common;
  std::vector<std::pair<CLI::App*, Action>> actions;
};

}  // namespace

void check_command(const std::vector<std::string>& words) {
  CommandLine line;
  try {
    line.parse(words);
  } catch (const CLI::ParseError& error) {
    throw Error(ErrorCode::usage, usage_sentence(error, line.app));
  } catch (const Error& error) {
    throw Error(error.code(), with_option(error, line.used(), line.common));
  }
}

std::vector<std::string> with_own_options(const std::vector<std::string>& words, const std::vector<std::string>& own) {
  CommandLine line;
  const auto named = line.app.get_subcommands([&](const CLI::App* sub) { return sub->get_name() == words.at(0); });
  if (own.empty() || named.empty()) return words;
  const auto option_of = [&](const std::string& word) -> const CLI::Option* {
    return is_option(*named[0], word) ? named[0]->get_option_no_throw(word.substr(0, word.find('='))) : nullptr;
  };
  std::vector<std::string> merged;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const CLI::Option* option = option_of(words[i]);
    const bool replaced =
        option && std::ranges::any_of(own, [&](const std::string& word) { return option_of(word) == option; });
    const bool has_value =
        option && option->get_items_expected_max() > 0 && words[i].find('=') == words[i].npos && i + 1 < words.size();
    if (!replaced) merged.push_back(words[i]);
    if (has_value && !replaced) merged.push_back(words[i + 1]);
    i += has_value;
  }
  merged.insert(merged.end(), own.begin(), own.end());
  return merged;
}

namespace {

/// Runs the command line of these words.
int run_words(CommandLine& line, const std::vector<std::string>& words) {
  int result = 0;
  try {
    line.parse(words);
    Session session(line.common);
    const int threads = session.options.threads;
    tbb::task_arena arena(threads > 0 ? threads : tbb::task_arena::automatic);  // for what takes no context
    for (const auto& [sub, action] : line.actions)
      if (sub->parsed()) arena.execute([&, &act = action] { result = act(session); });
  } catch (const DescriptionAsked& asked) {
    std::cout << slicer_description(*asked.command);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() != 0) throw Error(ErrorCode::usage, usage_sentence(error, line.app));
    line.app.exit(error);  // --help, --version
  } catch (const Error& error) {
    throw Error(error.code(), with_option(error, line.used(), line.common));
  }
  std::cout.flush();
  if (!std::cout) throw Error(ErrorCode::failed, "cannot write to stdout");
  return result;
}

/// Like run_words() for a command that 3D Slicer calls as a module.
int run_module(CommandLine& line, const std::vector<std::string>& words) {
  if (words.empty() || !is_slicer_module(words[0]))
    throw Error(ErrorCode::usage, "modules of 3D Slicer are run, thickness and tree");
  if (words.size() == 2 && words[1] == "--xml") return run_words(line, words);
  line.common.module = true;
  return call_slicer_module(*line.app.get_subcommand(words[0]), {words.begin() + 1, words.end()},
                            [&](const std::vector<std::string>& of_command, const std::string& folder) {
                              line.common.module_folder = folder;
                              return run_words(line, of_command);
                            });
}

}  // namespace

int run(int argc, char** argv) {
  CommandLine line;
  const std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
  int result = 0;
  // Two commands that no user needs: for the build, and for the modules in plugins/slicer.
  if (words.size() == 2 && words[0] == "shell-files")
    write_shell_files(line.app, words[1]);
  else if (!words.empty() && words[0] == "slicer-module")
    result = run_module(line, {words.begin() + 1, words.end()});
  else
    result = run_words(line, words);
  finish_results();
  return result;
}

}  // namespace quench::program
