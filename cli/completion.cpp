// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "shell_files.h"

namespace quench::program {
namespace {

using Takes = ShellOption::Takes;

/// In single quotes of a shell; fish has \' for one.
std::string in_quotes(const std::string& text, bool fish = false) {
  std::string result = "'";
  for (const char c : text)
    if (c == '\'')
      result += fish ? "\\'" : "'\\''";
    else if (c == '\\' && fish)
      result += "\\\\";
    else
      result += c;
  return result + "'";
}

/// "run -o|run --output" as a pattern of `case`.
std::string case_pattern(const std::string& command, const std::vector<std::string>& names) {
  std::string pattern;
  for (const std::string& name : names) pattern += fmt::format("{}'{} {}'", pattern.empty() ? "" : "|", command, name);
  return pattern;
}

std::string all_names(const ShellCommand& command) {
  std::string names;
  for (const ShellOption& option : command.options)
    for (const std::string& name : option.names) names += (names.empty() ? "" : " ") + name;
  return names;
}

std::string bash_values(const ShellOption& option) {
  switch (option.takes) {
    case Takes::words:
      return fmt::format("words='{}'", fmt::join(option.words, " "));
    case Takes::files:
      return "files=f";
    case Takes::folders:
      return "files=d";
    default:
      return ":";
  }
}

constexpr const char* kBash = R"bash(# Completion of quench for bash. SPDX-License-Identifier: Apache-2.0
# Written by the program from the definitions of its options.
_quench() {
  local cur=${COMP_WORDS[COMP_CWORD]} prev='' command='' names='' words='' files='' commands='' i word after=''
  local equals=''
  COMPREPLY=()
  [ "$COMP_CWORD" -gt 0 ] && prev=${COMP_WORDS[COMP_CWORD-1]}
  # --name=value is three words, or one where '=' does not break words.
  if [ "$cur" = = ]; then
    cur='' equals=1
  elif [ "$prev" = = ] && [ "$COMP_CWORD" -gt 1 ]; then
    prev=${COMP_WORDS[COMP_CWORD-2]} equals=1
  elif [ "${cur#--*=}" != "$cur" ]; then
    prev=${cur%%=*} equals=$prev= cur=${cur#*=}
  fi
  for ((i = 1; i < COMP_CWORD; ++i)); do
    word=${COMP_WORDS[i]}
    case $command in
      '' | COMMANDS) case $word in -*) ;; *) command="${command:+$command }$word" ;; esac ;;
      batch) [ "$word" = -- ] && command='' after=1 ;;
      *) ;;
    esac
  done
  case $command in
COMMAND_CASES    *) return ;;
  esac
  [ -n "$after" ] && [ -z "$command" ] && commands='tree run' names=''
  case "$command $prev" in
VALUE_CASES    *)
      case $cur in
        -*) words=$names ;;
        *) words=$commands
          if [ -z "$commands" ]; then
            case $command in
ARGUMENT_CASES              *) files=f ;;
            esac
          fi ;;
      esac ;;
  esac
  local IFS=$'\n'
  if [ -n "$files" ]; then
    type compopt >/dev/null 2>&1 && compopt -o filenames 2>/dev/null
    COMPREPLY=($(compgen -"$files" -- "$cur"))
    if [ "$files" = d ] && [ ${#COMPREPLY[@]} -eq 0 ]; then COMPREPLY=($(compgen -f -- "$cur")); fi
  elif [ -n "$words" ]; then
    IFS=$' \n'
    COMPREPLY=($(compgen -W "$words" -- "$cur"))
    # Behind the '=' of one word, that word is what is replaced.
    case $equals in --*) COMPREPLY=("${COMPREPLY[@]/#/$equals}") ;; esac
  fi
} &&
  complete -F _quench quench
)bash";

void replace_all(std::string& text, const std::string& what, const std::string& by) {
  for (std::size_t at = text.find(what); at != text.npos; at = text.find(what, at + by.size()))
    text.replace(at, what.size(), by);
}

/// In a description of _arguments: brackets and colons mean something there.
std::string zsh_text(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '[' || c == ']' || c == ':' || c == '\\') result += '\\';
    result += c;
  }
  return result;
}

std::string zsh_action(const ShellOption& option) {
  const std::string value = zsh_text(option.value);
  switch (option.takes) {
    case Takes::nothing:
      return {};
    case Takes::words:
      return fmt::format(":{}:({})", value, fmt::join(option.words, " "));
    case Takes::files:
      return fmt::format(":{}:_files", value);
    case Takes::folders:
      return fmt::format(":{}:_files -/", value);
    case Takes::other:
      break;
  }
  return fmt::format(":{}: ", value);
}

std::string zsh_option(const ShellOption& option) {
  const std::string repeats = option.repeats ? "*" : "";
  const std::string tail = fmt::format("[{}]{}", zsh_text(option.brief), zsh_action(option));
  std::vector<std::string> names = option.names;
  if (option.takes != Takes::nothing)
    for (std::string& name : names) name += name.starts_with("--") ? "=" : "+";
  if (names.size() == 1) return in_quotes(repeats + names[0] + tail);
  const std::string excluded = option.repeats ? "*" : fmt::format("({})", fmt::join(option.names, " "));
  return fmt::format("{}{{{}}}{}", in_quotes(excluded), fmt::join(names, ","), in_quotes(tail));
}

std::string zsh_function_name(const std::string& command) {
  std::string name = "_quench" + (command.empty() ? "" : "_" + command);
  std::ranges::replace(name, ' ', '_');
  return name;
}

std::string zsh_function(const ShellCommand& command, const std::vector<ShellCommand>& all) {
  std::string text = fmt::format("{}() {{\n", zsh_function_name(command.name));
  const bool more = !command.commands.empty();
  if (more) text += "  local curcontext=$curcontext state state_descr line\n  typeset -A opt_args\n";
  text += more ? "  _arguments -C" : "  _arguments -s -S";
  for (const ShellOption& option : command.options) text += " \\\n    " + zsh_option(option);
  if (!more) {
    int place = 1;
    for (const ShellOption& argument : command.arguments) {
      text += " \\\n    " + in_quotes((argument.repeats ? "*" : std::to_string(place)) + zsh_action(argument));
      ++place;
    }
    return text + "\n}\n\n";
  }
  text +=
      " \\\n    '1:command:->command' \\\n    '*::rest:->rest'\n  case $state in\n    command)\n      local -a "
      "commands=(\n";
  const std::string before = command.name.empty() ? "" : command.name + " ";
  const auto each = [&](const auto& use) {
    for (const std::string& name : command.commands)
      for (const ShellCommand& sub : all)
        if (sub.name == before + name) use(name, sub);
  };
  each([&](const std::string& name, const ShellCommand& sub) {
    text += fmt::format("        {}\n", in_quotes(name + ":" + zsh_text(sub.brief)));
  });
  text += "      )\n      _describe -t commands command commands ;;\n    rest)\n      case $words[1] in\n";
  each([&](const std::string& name, const ShellCommand& sub) {
    text += fmt::format("        {}) {} ;;\n", name, zsh_function_name(sub.name));
  });
  return text + "      esac ;;\n  esac\n}\n\n";
}

constexpr const char* kFish = R"fish(# Completion of quench for fish. SPDX-License-Identifier: Apache-2.0
# Written by the program from the definitions of its options.

# The command that is typed: empty, 'run', 'bricks plan'; of a batch, behind its '--', 'batch --', then what it runs.
function __quench_command
    set -l command
    for word in (commandline -opc)[2..-1]
        switch "$command"
            case '' COMMANDS
                string match -q -- '-*' $word; or set command (string trim -- "$command $word")
            case batch
                test "$word" = --; and set command 'batch --'
            case 'batch --'
                set command $word
        end
    end
    echo $command
end

function __quench_is
    test "$(__quench_command)" = "$argv[1]"
end

)fish";

std::string fish_option(const ShellCommand& command, const ShellOption& option) {
  std::string line = fmt::format("complete -c quench -n '__quench_is \"{}\"'", command.name);
  for (const std::string& name : option.names)
    line += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
  switch (option.takes) {
    case Takes::nothing:
      break;
    case Takes::words:
      line += fmt::format(" -x -a {}", in_quotes(fmt::format("{}", fmt::join(option.words, " ")), true));
      break;
    case Takes::files:
      line += " -r -F";
      break;
    case Takes::folders:
      line += " -x -a '(__fish_complete_directories)'";
      break;
    case Takes::other:
      line += " -x";
      break;
  }
  return line + fmt::format(" -d {}\n", in_quotes(option.brief, true));
}

}  // namespace

std::string bash_completion(const std::vector<ShellCommand>& commands) {
  std::string parents, cases, values, arguments;
  for (const ShellCommand& command : commands) {
    if (!command.commands.empty() && !command.name.empty())
      parents += (parents.empty() ? "" : " | ") + in_quotes(command.name);
    cases += fmt::format("    '{}') names='{}' commands='{}' ;;\n", command.name, all_names(command),
                         fmt::join(command.commands, " "));
    for (const ShellOption& option : command.options)
      if (option.takes != Takes::nothing)
        values += fmt::format("    {}) {} ;;\n", case_pattern(command.name, option.names), bash_values(option));
    for (const ShellOption& argument : command.arguments)
      if (argument.takes != Takes::files)
        arguments += fmt::format("              '{}') {} ;;\n", command.name, bash_values(argument));
  }
  std::string text = kBash;
  replace_all(text, "'' | COMMANDS", parents.empty() ? "''" : "'' | " + parents);
  replace_all(text, "COMMAND_CASES", cases);
  replace_all(text, "VALUE_CASES", values);
  replace_all(text, "ARGUMENT_CASES", arguments);
  return text;
}

std::string zsh_completion(const std::vector<ShellCommand>& commands) {
  std::string text =
      "#compdef quench\n# Completion of quench for zsh. SPDX-License-Identifier: Apache-2.0\n"
      "# Written by the program from the definitions of its options.\n\n";
  for (auto command = commands.rbegin(); command != commands.rend(); ++command)
    text += zsh_function(*command, commands);
  return text + "_quench \"$@\"\n";
}

std::string fish_completion(const std::vector<ShellCommand>& commands) {
  std::string text = kFish, parents;
  text += "complete -c quench -f -n '__quench_is \"batch --\"' -a 'tree run'\n";
  for (const ShellCommand& command : commands) {
    if (!command.commands.empty() && !command.name.empty()) parents += " " + in_quotes(command.name, true);
    for (const std::string& name : command.commands) {
      const std::string whole = command.name.empty() ? name : command.name + " " + name;
      const auto sub = std::ranges::find(commands, whole, &ShellCommand::name);
      text += fmt::format("complete -c quench -f -n '__quench_is \"{}\"' -a {} -d {}\n", command.name, name,
                          in_quotes(sub->brief, true));
    }
    for (const ShellOption& argument : command.arguments)
      if (argument.takes == Takes::words)
        text += fmt::format("complete -c quench -f -n '__quench_is \"{}\"' -a {}\n", command.name,
                            in_quotes(fmt::format("{}", fmt::join(argument.words, " ")), true));
    for (const ShellOption& option : command.options) text += fish_option(command, option);
  }
  replace_all(text, "case '' COMMANDS", "case ''" + parents);
  return text;
}

}  // namespace quench::program
