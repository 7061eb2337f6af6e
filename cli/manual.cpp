// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "shell_files.h"

namespace quench::program {
namespace {

struct ManualEntry {
  const char *term, *text;
};
using ManualEntries = std::vector<ManualEntry>;

const ManualEntries kExitCodes = {{"0", "done"},
                                  {"1", "failed: memory, disk, a file that cannot be opened"},
                                  {"2", "a wrong command line"},
                                  {"3", "an input that cannot be used"},
                                  {"4", "a promised invariant does not hold; of verify: a counterexample"},
                                  {"130", "interrupted"}};

const ManualEntries kLengths = {
    {"0.02, 2%",
     "a fraction of the longest side of the bounding box: of the mesh, of the foreground of a volume, of a foreign "
     "medial axis itself (unless a shape is given)"},
    {"2.5vox", "a multiple of the smallest side of a voxel or pixel"},
    {"3.5abs", "units of the input"},
    {"0, inf", "nothing is dropped; only what topology needs is kept"}};

/// What the commands that write folders put there, and what others keep beside their output.
const std::map<std::string, ManualEntries> kFiles = {
    {"run",
     {{"core.vtp", "the pruned medial axis with radius, burn time and erosion thickness"},
      {"skeleton.vtp", "the skeleton of sheets and curves"},
      {"skeleton.swc", "its curves as trees"},
      {"skeleton.geojson, skeleton.svg", "of images and polygons: its branches as lines of the plane"},
      {"branches.csv", "a row per branch"},
      {"parts.csv", "a row per sheet of the skeleton; not of images and polygons"},
      {"features.csv", "of a file of many polygons: a row per polygon"},
      {"picture.png", "a picture of the skeleton"},
      {"view.html", "the interactive page"},
      {"report.json", "all figures and parameters"}}},
    {"tree",
     {{"tree.swc, tree.rsml, tree.mtg, tree.graphml", "the trees"},
      {"centerlines.vtp", "their branches with radii"},
      {"axes.csv, branches.csv, traits.csv, sholl.csv, depths.csv", "what is measured"},
      {"edits.csv, edited.nrrd", "what was repaired, and the shape with the repairs"},
      {"picture.png, view.html", "a picture and the interactive page"},
      {"report.json", "all figures and parameters"}}},
    {"parts",
     {{"parts.csv, seams.csv, junctions.csv", "a row per sheet, seam and junction"},
      {"parts.vtp, parts.obj", "all sheets in one mesh"},
      {"sheets/", "a mesh of each sheet"},
      {"report.json", "all figures and parameters"}}},
    {"batch",
     {{"a folder per sample", "what the command writes, log.txt among it"},
      {"samples.csv", "a row per sample"},
      {"axes.csv, branches.csv", "the axes of all trees; of 'run' the branches of all skeletons"},
      {"index.html", "a contact sheet of all samples"}}},
};

/// Text as the macros read it: no letter is an escape, no line a request, and quotes and dashes stay what they are.
std::string escaped(const std::string& text) {
  std::string result;
  bool begins = true;
  for (const char c : text) {
    if (begins && (c == '.' || c == '\'')) result += "\\&";
    switch (c) {
      case '\\':
        result += "\\e";
        break;
      case '-':
        result += "\\-";
        break;
      case '\'':
        result += "\\(aq";
        break;
      case '`':
        result += "\\(ga";
        break;
      case '^':
        result += "\\(ha";
        break;
      case '~':
        result += "\\(ti";
        break;
      case '"':
        result += "\\(dq";
        break;
      default:
        result += c;
    }
    begins = c == '\n';
  }
  return result;
}

std::string bold(const std::string& text) { return "\\fB" + escaped(text) + "\\fR"; }
std::string italic(const std::string& text) { return "\\fI" + escaped(text) + "\\fR"; }

/// A paragraph; lines behind the first are shown as they are.
std::string paragraph(const std::string& text) {
  const std::size_t end = text.find('\n');
  std::string result = escaped(text.substr(0, end)) + "\n";
  if (end == text.npos) return result;
  return result + ".sp\n.nf\n" + escaped(text.substr(end + 1)) + "\n.fi\n";
}

std::string manual_entries(const ManualEntries& entries, std::string (*term)(const std::string&)) {
  std::string text;
  for (const ManualEntry& entry : entries) text += fmt::format(".TP\n{}\n{}\n", term(entry.term), escaped(entry.text));
  return text;
}

std::string words_of_command(const CLI::App& command) {
  return command.get_parent() ? words_of_command(*command.get_parent()) + " " + command.get_name() : command.get_name();
}

std::string page_name(const CLI::App& command) {
  std::string name = words_of_command(command);
  std::replace(name.begin(), name.end(), ' ', '-');
  return name;
}

std::string reference_to(const std::string& page) { return bold(page) + "(1)"; }

/// "-o, --output DIR", of a flag that may have a value "--in-bricks[=DIR]".
std::string option_term(const CLI::Option& option) {
  std::string term;
  for (const auto& [names, dashes] : {std::pair(option.get_snames(), "-"), std::pair(option.get_lnames(), "--")})
    for (const std::string& name : names) term += (term.empty() ? "" : ", ") + bold(dashes + name);
  const std::string type = option.get_type_name();
  if (option.get_items_expected_max() == 0) return term;
  return term + " " + italic(type.empty() ? "FILE" : type);
}

std::string option_entry(const CLI::Option& option) {
  std::string text = fmt::format(".TP\n{}\n{}", option_term(option), paragraph(option.get_description()));
  const auto names = [](const std::set<CLI::Option*>& options) {
    std::string list;
    for (const CLI::Option* other : options) list += (list.empty() ? "" : ", ") + bold(other->get_name());
    return list;
  };
  std::vector<std::string> more;
  if (option.get_required()) more.push_back("Required.");
  if (const std::string value = option.get_default_str(); !value.empty() && option.get_items_expected_max() > 0)
    more.push_back(fmt::format("Default: {}.", bold(value)));
  if (!option.get_excludes().empty()) more.push_back(fmt::format("Not with {}.", names(option.get_excludes())));
  if (!option.get_needs().empty()) more.push_back(fmt::format("Only with {}.", names(option.get_needs())));
  if (more.empty()) return text;
  text.pop_back();
  return fmt::format("{}{}\n{}\n", text, text.ends_with('.') ? "" : ".", fmt::join(more, "\n"));
}

std::vector<const CLI::Option*> arguments_of(const CLI::App& command) {
  return command.get_options([](const CLI::Option* option) { return option->get_positional(); });
}

std::vector<const CLI::App*> commands_of(const CLI::App& command) {
  return command.get_subcommands([](const CLI::App*) { return true; });
}

std::string argument_name(const CLI::Option& argument) {
  return argument.get_name(true) + (argument.get_expected_max() > 1 ? "..." : "");
}

std::string shortest_name(const CLI::Option& option) {
  return option.get_snames().empty() ? "--" + option.get_lnames().front() : "-" + option.get_snames().front();
}

std::string synopsis_of(const CLI::App& command) {
  std::string text = bold(words_of_command(command));
  if (!commands_of(command).empty()) return text + fmt::format(" {} [{}]\n", italic("COMMAND"), italic("OPTIONS"));
  text += fmt::format(" [{}]", italic("OPTIONS"));
  for (const CLI::Option* argument : arguments_of(command)) text += " " + italic(argument_name(*argument));
  for (const CLI::Option* option : command.get_options())
    if (option->get_required() && !option->get_positional())
      text += fmt::format(" {} {}", bold(shortest_name(*option)), italic(option->get_type_name()));
  if (command.get_name() == "batch")
    text += fmt::format(" {} {} [{}]", bold("--"), italic("COMMAND"), italic("OPTIONS"));
  return text + "\n";
}

std::string options_section(const CLI::App& command) {
  std::string text = ".SH OPTIONS\n";
  std::vector<std::string> groups = command.get_groups();
  for (const std::string& group : groups) {
    std::string entries;
    for (const CLI::Option* option : command.get_options())
      if (option->get_group() == group && option->nonpositional()) entries += option_entry(*option);
    if (entries.empty()) continue;
    if (group != "Options") text += fmt::format(".SS {}\n", escaped(group));
    text += entries;
  }
  return text;
}

bool takes_lengths(const CLI::App& command) {
  return std::ranges::any_of(command.get_options(),
                             [](const CLI::Option* option) { return option->get_type_name().starts_with("LENGTH"); });
}

std::string files_section(const CLI::App& command) {
  std::string text;
  const auto known = kFiles.find(command.get_name());
  if (known != kFiles.end() && command.get_parent() && !command.get_parent()->get_parent())
    text += manual_entries(known->second, italic);
  if (!command.get_parent())
    text += manual_entries({{".vtp", "the primary format of results: all arrays and parameters"},
                            {".ply .obj .off .stl", "meshes"},
                            {".nrrd .nii.gz .mha .tif .zarr", "volumes"},
                            {".png .pgm .jpg .bmp .geojson .svg", "images and polygons"}},
                           italic);
  if (!command.get_parent() || command.get_option_no_throw("--json"))
    text += ".TP\n" + italic("share/quench/report.schema.json") + "\n" +
            escaped("describes every key of report.json and of what --json writes, as JSON Schema") + "\n";
  if (!text.empty()) text = ".SH FILES\n" + text;
  if (!text.empty())
    text += ".PP\nExisting files are not replaced without " + bold("--overwrite") +
            ", and none is ever half written.\nThe extension of a name chooses the format.\n";
  return text;
}

/// The lines of the footer behind "Example:".
std::string example_of(const CLI::App& command) {
  std::string text = command.get_footer();
  const std::size_t at = text.find("Example:\n");
  return at == text.npos ? std::string() : text.substr(at + 9);
}

std::string examples_section(const CLI::App& command) {
  std::string text;
  const auto show = [&](const std::string& line) {
    const std::size_t begin = line.find_first_not_of(' ');
    text += fmt::format(".nf\n.RS\n{}\n.RE\n.fi\n", escaped(line.substr(begin)));
  };
  if (const std::string own = example_of(command); !own.empty()) show(own);
  for (const CLI::App* sub : commands_of(command))
    if (const std::string one = example_of(*sub); !one.empty()) show(one);
  return text.empty() ? text : ".SH EXAMPLES\n" + text;
}

std::string see_also_section(const CLI::App& command) {
  std::vector<std::string> pages;
  if (command.get_parent()) pages.push_back(page_name(*command.get_parent()));
  for (const CLI::App* sub : commands_of(command.get_parent() ? *command.get_parent() : command))
    if (sub != &command) pages.push_back(page_name(*sub));
  if (command.get_parent())
    for (const CLI::App* sub : commands_of(command)) pages.push_back(page_name(*sub));
  std::string text = ".SH SEE ALSO\n";
  for (std::size_t i = 0; i < pages.size(); ++i)
    text += fmt::format("{}{}\n", reference_to(pages[i]), i + 1 < pages.size() ? "," : "");
  return text + ".PP\nThe guide for users is installed as Markdown in " + italic("share/doc/quench") + ".\n";
}

std::string without_end(std::string sentence) {
  while (sentence.ends_with('.')) sentence.pop_back();
  return sentence;
}

}  // namespace

std::string manual_page(const CLI::App& command) {
  const bool program = command.get_parent() == nullptr;
  std::string upper = page_name(command);
  std::ranges::transform(upper, upper.begin(), [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  std::string summary = without_end(command.get_description());
  if (program && summary.starts_with("Quench: ")) summary.erase(0, 8);
  std::string text = fmt::format(".\\\" SPDX-License-Identifier: Apache-2.0\n.TH {} 1 \"\" \"quench {}\" \"Quench\"\n",
                                 escaped(upper), escaped(QUENCH_VERSION));
  text += fmt::format(".SH NAME\n{} \\- {}\n", escaped(page_name(command)), escaped(summary));
  text += ".SH SYNOPSIS\n" + synopsis_of(command);
  if (program) text += ".br\n" + bold("quench") + " " + italic("COMMAND") + " " + bold("--help") + "\n";
  text += ".SH DESCRIPTION\n" + escaped(without_end(command.get_description())) + ".\n";
  for (const CLI::Option* argument : arguments_of(command))
    text += fmt::format(".TP\n{}\n{}", italic(argument_name(*argument)), paragraph(argument->get_description()));
  if (const auto commands = commands_of(command); !commands.empty()) {
    text += ".SH COMMANDS\n";
    for (const CLI::App* sub : commands)
      text += fmt::format(".TP\n{}\n{}.\nSee {}.\n", bold(sub->get_name()),
                          escaped(without_end(sub->get_description())), reference_to(page_name(*sub)));
  }
  text += options_section(command);
  if (program || takes_lengths(command)) text += ".SH LENGTHS\n" + manual_entries(kLengths, bold);
  text += files_section(command);
  text += ".SH EXIT STATUS\n" + manual_entries(kExitCodes, bold);
  text += ".PP\nAn error is one sentence on standard error that names the file or value, the reason and the way out.\n";
  text += examples_section(command);
  return text + see_also_section(command);
}

}  // namespace quench::program
