// SPDX-License-Identifier: Apache-2.0
#include "shell_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <ostream>

#include "option_checks.h"
#include "quench/error.h"
#include "quench/io.h"

namespace quench::program {
namespace {

/// Where the first clause ends: "; ", " [default", or a full stop before a capital letter.
std::size_t end_of_clause(const std::string& text) {
  std::size_t end = std::min({text.find('\n'), text.find("; "), text.find(" [default"), text.size()});
  for (std::size_t at = text.find(". "); at < end; at = text.find(". ", at + 1))
    if (at + 2 < text.size() && text[at + 2] >= 'A' && text[at + 2] <= 'Z') end = at;
  return end;
}

/// The first clause of a help text, cut where it is long; no bracket is left open.
std::string brief_of(const std::string& help) {
  constexpr std::size_t most = 72;
  std::string text = help.substr(0, end_of_clause(help));
  const bool cut = text.size() > most;
  if (cut) text.resize(text.rfind(' ', most));
  if (const std::size_t open = text.rfind('('); open != text.npos && open > 0 && text.find(')', open) == text.npos)
    text.resize(open);
  while (!text.empty() && std::strchr(",:. ", text.back())) text.pop_back();
  return text + (cut ? " ..." : "");
}

ShellOption::Takes takes_of(const CLI::Option& option, const std::string& type, const std::vector<std::string>& words) {
  using Takes = ShellOption::Takes;
  if (option.get_items_expected_max() == 0) return Takes::nothing;
  if (type == "DIR" || type == "OUT" || type == "WORK") return Takes::folders;
  if (type.find("FILE") != type.npos) return Takes::files;
  if (!words.empty()) return Takes::words;
  // Arguments and what may stand for one have no type; all but the words above are files.
  return type.empty() ? Takes::files : Takes::other;
}

ShellOption shell_option(CLI::Option& option) {
  ShellOption result;
  for (const std::string& name : option.get_snames()) result.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) result.names.push_back("--" + name);
  const std::string type = option.get_type_name();
  result.value = type.empty() ? (result.names.empty() ? option.get_single_name() : "FILE") : type;
  result.brief = brief_of(option.get_description());
  result.group = option.get_group();
  result.words = words_of(option);
  result.takes = takes_of(option, type, result.words);
  result.repeats = option.get_expected_max() > 1 || option.get_multi_option_policy() == CLI::MultiOptionPolicy::TakeAll;
  return result;
}

void add_shell_command(CLI::App& app, const std::string& name, std::vector<ShellCommand>& commands) {
  ShellCommand command{name, brief_of(app.get_description()), {}, {}, {}};
  for (CLI::Option* option : app.get_options()) {
    if (option->get_positional()) {
      command.arguments.push_back(shell_option(*option));
      command.arguments.back().names.clear();
      command.arguments.back().value = option->get_name(true);
    }
    if (option->nonpositional()) command.options.push_back(shell_option(*option));
  }
  const auto subs = app.get_subcommands([](const CLI::App*) { return true; });
  for (const CLI::App* sub : subs) command.commands.push_back(sub->get_name());
  commands.push_back(std::move(command));
  for (CLI::App* sub : subs)
    add_shell_command(*sub, name.empty() ? sub->get_name() : name + " " + sub->get_name(), commands);
}

void write_manual_pages(const CLI::App& app, const std::string& name, const std::filesystem::path& folder) {
  const std::string text = manual_page(app);
  io::write_atomically(folder / (name + ".1"), [&](std::ostream& out) { out << text; });
  for (const CLI::App* sub : app.get_subcommands([](const CLI::App*) { return true; }))
    write_manual_pages(*sub, name + "-" + sub->get_name(), folder);
}

}  // namespace

std::vector<ShellCommand> shell_commands(CLI::App& program) {
  std::vector<ShellCommand> commands;
  add_shell_command(program, "", commands);
  return commands;
}

void write_shell_files(CLI::App& program, const std::filesystem::path& folder) {
  std::error_code error;
  for (const char* sub : {"man1", "bash", "zsh", "fish"}) std::filesystem::create_directories(folder / sub, error);
  if (error)
    throw Error(ErrorCode::failed, fmt::format("cannot create folders in '{}': {}", folder.string(), error.message()));
  write_manual_pages(program, program.get_name(), folder / "man1");
  const std::vector<ShellCommand> commands = shell_commands(program);
  const auto write = [&](const char* file, const std::string& text) {
    io::write_atomically(folder / file, [&](std::ostream& out) { out << text; });
  };
  write("bash/quench", bash_completion(commands));
  write("zsh/_quench", zsh_completion(commands));
  write("fish/quench.fish", fish_completion(commands));
}

}  // namespace quench::program
