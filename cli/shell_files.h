// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>
#include <vector>

/// Manual pages and completion, from the definitions that --help shows. The build writes them with the program.
namespace quench::program {

/// What completion knows of an option or an argument.
struct ShellOption {
  enum class Takes { nothing, words, files, folders, other };
  std::vector<std::string> names;  ///< with their dashes; none of an argument
  std::string value;               ///< what help calls its value, or the name of the argument
  std::string brief;               ///< a few words
  std::string group;
  Takes takes = Takes::nothing;
  std::vector<std::string> words;  ///< that it takes, or takes beside other values
  bool repeats = false;
};

struct ShellCommand {
  std::string name;  ///< "bricks plan"; empty: the program itself
  std::string brief;
  std::vector<ShellOption> options, arguments;
  std::vector<std::string> commands;  ///< the words that may follow
};

/// The program, then every command, those of a command behind it.
std::vector<ShellCommand> shell_commands(CLI::App& program);

std::string bash_completion(const std::vector<ShellCommand>& commands);
std::string zsh_completion(const std::vector<ShellCommand>& commands);
std::string fish_completion(const std::vector<ShellCommand>& commands);

/// The manual page of the program or of a command, in the macros of man(7).
std::string manual_page(const CLI::App& command);

/// Writes man1/*.1, bash/quench, zsh/_quench and fish/quench.fish into the folder, which is created.
/// Throws Error(failed).
void write_shell_files(CLI::App& program, const std::filesystem::path& folder);

}  // namespace quench::program
