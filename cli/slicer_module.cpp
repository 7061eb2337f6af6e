// SPDX-License-Identifier: Apache-2.0
#include "slicer_module.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <ostream>
#include <set>

#include "base/platform/system_files.h"
#include "option_checks.h"
#include "quench/error.h"
#include "quench/io.h"

namespace quench::program {
namespace {

namespace fs = std::filesystem;
using Parameters = std::vector<SlicerParameter>;

constexpr const char* kByDefault = "default";  // of a choice that the command makes where nothing is said

/// What a module has besides the options of its command.
struct Module {
  const char *title, *description;
  Parameters files, returned;
  bool writes_folder;             // its outputs are files of a folder; of others they are the values of options
  std::set<std::string> without;  // options that make no sense in Slicer
};

SlicerParameter output(const char* tag, const char* name, const char* label, const char* description,
                       const char* extension, const char* source, const char* type = "") {
  return {tag, name, label, description, "", "output", extension, type, source};
}

SlicerParameter returned(const char* tag, const char* name, const char* label, const char* place) {
  return {tag, name, label, std::string(label) + ", once the module has run", "0", "output", "", "", place};
}

Parameters inputs(const std::string& of_volume) {
  return {{"image", "volume", "Volume",
           "A labelmap or mask, or a volume of grey values. " + of_volume + " Give a volume or a model, not both", "",
           "input", ".nrrd", "scalar"},
          {"geometry", "model", "Model", "A closed surface, instead of a volume", "", "input", ".vtp", "model"}};
}

Parameters with(Parameters parameters, const Parameters& more) {
  parameters.insert(parameters.end(), more.begin(), more.end());
  return parameters;
}

SlicerParameter all_results() {
  return {"string",
          "folder",
          "Folder for all results",
          "Keep everything that the command writes in this folder, with the interactive page and a picture; nothing "
          "where it is empty",
          "",
          "",
          "",
          "",
          "folder"};
}

const std::set<std::string> kNotInSlicer = {
    "help",    "xml",     "json",      "overwrite", "quiet",      "verbose",       "output",   "units",    "pixel",
    "feature", "channel", "dimension", "no-view",   "no-picture", "max-triangles", "swc-type", "narrower", "extend"};

const std::map<std::string, Module> kModules = {
    {"run",
     {"Quench Medial Axis and Skeleton",
      "The medial axis of a segmented object, exact and with its topology, and its skeleton of sheets and curves, with "
      "radius, burn time and erosion thickness at every vertex.",
      with(
          inputs("Grey values need a threshold."),
          {output("geometry", "core", "Medial axis", "The pruned medial axis, as a model", ".vtp", "core.vtp", "model"),
           output("geometry", "skeleton", "Skeleton", "Sheets and curves, as a model", ".vtp", "skeleton.vtp", "model"),
           output("table", "branches", "Branches", "A row per branch of the curves", ".csv", "branches.csv"),
           output("table", "sheets", "Sheets", "A row per sheet", ".csv", "parts.csv"), all_results()}),
      {returned("integer", "components", "Components", "/shape/betti/0"),
       returned("integer", "tunnels", "Tunnels", "/shape/betti/1"),
       returned("integer", "cavities", "Cavities", "/shape/betti/2")},
      true,
      {}}},
    {"tree",
     {"Quench Trees and Centerlines",
      "Vessels, airways, neurons or roots as one tree per plant: centre lines with radii and measures, without loops "
      "and gaps.",
      with(inputs("Where nothing is said, the threshold of grey values is chosen."),
           {output("geometry", "centerlines", "Centerlines",
                   "A polyline per branch with its radii ('Radius', 'MaximumInscribedSphereRadius'), as a model",
                   ".vtp", "centerlines.vtp", "model"),
            output("image", "edited", "Repaired shape", "The shape after repair, as a labelmap", ".nrrd", "edited.nrrd",
                   "label"),
            output("table", "branches_table", "Branches", "A row per branch", ".csv", "branches.csv"),
            output("table", "axes_table", "Axes", "A row per axis", ".csv", "axes.csv"),
            output("table", "traits_table", "Traits", "What is measured of each tree", ".csv", "traits.csv"),
            all_results()}),
      {returned("integer", "number_of_axes", "Number of axes", "/tree/axes"),
       returned("integer", "number_of_branches", "Number of branches", "/tree/branches"),
       returned("double", "total_length", "Total length", "/tree/length")},
      true,
      {"shape", "columns"}}},
    {"thickness",
     {"Quench Local Thickness",
      "The local thickness of a segmented object: at every voxel the diameter of the largest ball inside that covers "
      "it; and on its surface.",
      with(inputs("Grey values need a threshold."),
           {{"image", "mask", "Mask", "Measure only the voxels that are not 0 in this volume of the same size", "",
             "input", ".nrrd", "label", "--mask"},
            {"geometry", "axis", "Medial axis", "Take the balls of this medial axis", "", "input", ".vtp", "model",
             "--axis"},
            output("image", "thickness", "Thickness", "The thickness at every voxel, 0 outside", ".nrrd", "--output",
                   "scalar"),
            output("geometry", "surface", "Surface", "The surface with the thickness at its vertices, as a model",
                   ".vtp", "--surface", "model"),
            output("table", "summary", "Summary", "Voxels, mean, deviation, percentiles", ".csv", "--csv"),
            output("table", "histogram", "Histogram", "The voxels of each bin", ".csv", "--histogram")}),
      {returned("double", "mean", "Mean thickness", "/thickness/mean"),
       returned("double", "deviation", "Standard deviation", "/thickness/sd"),
       returned("double", "largest", "Largest thickness", "/thickness/max")},
      false,
      {"surface", "csv", "histogram", "png", "page", "mask", "axis"}}}};

std::string identifier_of(std::string name) {
  std::ranges::replace(name, '-', '_');
  return name;
}

std::string label_of(std::string name) {
  std::ranges::replace(name, '-', ' ');
  name[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(name[0])));
  return name;
}

SlicerParameter parameter_of(CLI::Option& option) {
  const std::string name = option.get_lnames().front();
  SlicerParameter p{"string", identifier_of(name), label_of(name), option.get_description(), option.get_default_str()};
  p.source = "--" + name;
  if (option.get_items_expected_max() == 0) {
    p.tag = "boolean";
    p.value = "false";
  } else if (option.get_type_name() == "X,Y,Z") {
    p.tag = "point";
    p.several = option.get_multi_option_policy() == CLI::MultiOptionPolicy::TakeAll;
  } else if (takes_only_words(option)) {
    p.tag = "string-enumeration";
    p.elements = words_of(option);
    if (p.value.empty()) {
      p.value = kByDefault;
      p.elements.insert(p.elements.begin(), kByDefault);
    }
  } else if (const auto range = range_of(option); range && !p.value.empty()) {
    p.tag = range->whole ? "integer" : "double";
    p.range = {range->least, range->most};
  }
  return p;
}

std::string escaped_xml(const std::string& text) {
  std::string result;
  for (const char c : text)
    result += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '"' ? "&quot;" : std::string(1, c);
  return result;
}

std::string element(const char* name, const std::string& text, int depth) {
  return fmt::format("{0:{3}}<{1}>{2}</{1}>\n", "", name, escaped_xml(text), 2 * depth);
}

std::string attributes_of(const SlicerParameter& p) {
  std::string text;
  if (!p.type.empty()) text += fmt::format(" type=\"{}\"", p.type);
  if (!p.extensions.empty()) text += fmt::format(" fileExtensions=\"{}\"", p.extensions);
  if (p.tag == "point") text += fmt::format(" multiple=\"{}\" coordinateSystem=\"lps\"", p.several);
  if (p.channel == "output" && p.tag == "image") text += " reference=\"volume\"";
  return text;
}

bool is_file(const SlicerParameter& p) { return p.tag == "image" || p.tag == "geometry" || p.tag == "table"; }

bool is_returned(const SlicerParameter& p) { return p.channel == "output" && !is_file(p); }

std::string text_of(const SlicerParameter& p) {
  std::string text = fmt::format("    <{}{}>\n", p.tag, attributes_of(p));
  text += element("name", p.name, 3);
  if (!is_returned(p)) text += element("longflag", "--" + p.name, 3);
  text += element("label", p.label, 3) + element("description", p.description, 3);
  if (!p.value.empty()) text += element("default", p.value, 3);
  if (!p.channel.empty()) text += element("channel", p.channel, 3);
  for (const std::string& word : p.elements) text += element("element", word, 3);
  if (p.range)
    text += fmt::format(
        "      <constraints>\n        <minimum>{}</minimum>\n        <maximum>{}</maximum>\n        <step>{}</step>\n"
        "      </constraints>\n",
        p.range->first, p.range->second, p.tag == "integer" ? "1" : "0.1");
  return text + fmt::format("    </{}>\n", p.tag);
}

/// A folder that goes with all that is in it.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    path = base::make_temporary_folder(fs::temp_directory_path());
    if (path.empty())
      throw Error(ErrorCode::failed, fmt::format("cannot create a folder in '{}'", fs::temp_directory_path().string()));
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path, ignored);
  }
  fs::path path;
};

/// What Slicer asks for.
struct Call {
  std::vector<std::string> options;          ///< of the command
  std::map<std::string, std::string> files;  ///< by the names of their parameters
  std::string return_file;
};

Call parsed_call(CLI::App& command, const std::vector<std::string>& words) {
  std::map<std::string, SlicerParameter> known;
  for (const SlicerGroup& group : slicer_groups(command))
    for (const SlicerParameter& p : group.parameters)
      if (!is_returned(p)) known.emplace(p.name, p);
  Call call;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string name = words[i].starts_with("--") ? identifier_of(words[i].substr(2)) : std::string();
    const auto found = known.find(name);
    const bool returns = name == "returnparameterfile";
    if (found == known.end() && !returns)
      throw Error(ErrorCode::usage, fmt::format("'{}' is no parameter of the module; --xml describes it", words[i]));
    if (!returns && found->second.tag == "boolean") {
      call.options.push_back(found->second.source);
      continue;
    }
    if (i + 1 == words.size()) throw Error(ErrorCode::usage, fmt::format("{} needs a value", words[i]));
    const std::string& value = words[++i];
    if (returns) {
      call.return_file = value;
      continue;
    }
    const SlicerParameter& p = found->second;
    if (is_file(p) || p.source == "folder") {
      call.files[p.name] = value;
    } else if (value != p.value) {  // Slicer passes every value, also those that exclude each other
      call.options.push_back(p.source);
      call.options.push_back(value);
    }
  }
  return call;
}

std::string input_of(const Call& call) {
  const auto volume = call.files.find("volume"), model = call.files.find("model");
  if ((volume == call.files.end()) == (model == call.files.end()))
    throw Error(ErrorCode::usage, "choose a volume or a model as input, one of the two");
  return volume != call.files.end() ? volume->second : model->second;
}

void copy_result(const fs::path& from, const fs::path& to) {
  std::ifstream in(from, std::ios::binary);
  if (!in) {
    std::printf("note: there is no %s of this shape\n", from.filename().c_str());
    return;
  }
  io::write_atomically(to, [&](std::ostream& out) {
    if (in.peek() != std::ifstream::traits_type::eof()) out << in.rdbuf();
  });
}

/// The numbers that Slicer shows, in its format.
void write_returned(const Module& module, const fs::path& report, const fs::path& file) {
  std::ifstream in(report);
  const auto json = nlohmann::json::parse(in, nullptr, false);
  io::write_atomically(file, [&](std::ostream& out) {
    for (const SlicerParameter& p : module.returned) {
      const nlohmann::json::json_pointer place(p.source);
      if (!json.is_discarded() && json.contains(place)) out << p.name << " = " << json.at(place).dump() << "\n";
    }
  });
}

}  // namespace

bool is_slicer_module(const std::string& command) { return kModules.contains(command); }

std::vector<SlicerGroup> slicer_groups(CLI::App& command) {
  const Module& module = kModules.at(command.get_name());
  static const std::map<std::string, const char*> descriptions = {
      {"Shape", "Which part of the input is the shape, and how a model becomes voxels"},
      {"Tree", "What it is the tree of, and what is measured"},
      {"Repair", "Loops and gaps of the shape"},
      {"Medial axis", "What of the medial axis is noise"},
      {"Burning", "How erosion thickness is computed"},
      {"Skeleton", "What of the medial axis becomes sheets and curves"},
      {"Thickness", "Which balls measure, and how"},
      {"Common", "Processors and memory"}};
  std::vector<SlicerGroup> groups{{"Input and output", "What is read and what is made", false, module.files}};
  for (const std::string& name : command.get_groups()) {
    // What is asked for most is open.
    const auto described = descriptions.find(name);
    SlicerGroup group{name,
                      described == descriptions.end() ? name : described->second,
                      name != "Shape" && name != "Skeleton" && name != "Tree" && name != "Thickness",
                      {}};
    if (name == "Common") group.label = "Resources";
    for (CLI::Option* option : command.get_options()) {
      if (option->get_group() != name || !option->nonpositional()) continue;
      const std::string& word = option->get_lnames().front();
      if (!kNotInSlicer.contains(word) && !module.without.contains(word))
        group.parameters.push_back(parameter_of(*option));
    }
    if (!group.parameters.empty()) groups.push_back(std::move(group));
  }
  groups.push_back({"Results", "Numbers that are known once the module has run", false, module.returned});
  return groups;
}

std::string slicer_description(CLI::App& command) {
  const Module& module = kModules.at(command.get_name());
  std::string text = "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<executable>\n";
  text += element("category", "Quench", 1) + element("title", module.title, 1) +
          element("description", module.description, 1) + element("version", QUENCH_VERSION, 1) +
          element("documentation-url", "", 1) + element("license", "Apache-2.0", 1) +
          element("contributor", "The authors of Quench", 1);
  for (const SlicerGroup& group : slicer_groups(command)) {
    text += group.advanced ? "  <parameters advanced=\"true\">\n" : "  <parameters>\n";
    text += element("label", group.label, 2) + element("description", group.description, 2);
    for (const SlicerParameter& p : group.parameters) text += text_of(p);
    text += "  </parameters>\n";
  }
  return text + "</executable>\n";
}

int call_slicer_module(CLI::App& command, const std::vector<std::string>& words,
                       const std::function<int(const std::vector<std::string>&, const std::string& folder)>& run) {
  const Module& module = kModules.at(command.get_name());
  const Call call = parsed_call(command, words);
  const TemporaryFolder temporary;
  const auto kept = call.files.find("folder");
  const fs::path folder = kept != call.files.end() ? fs::path(kept->second) : temporary.path / "results";
  const fs::path report = module.writes_folder ? folder / "report.json" : temporary.path / "report.json";

  std::vector<std::string> line{command.get_name(), input_of(call)};
  line.insert(line.end(), call.options.begin(), call.options.end());
  bool has_output = kept != call.files.end();
  for (const SlicerParameter& p : module.files) {
    const auto file = call.files.find(p.name);
    if (file == call.files.end() || !is_file(p)) continue;
    has_output |= p.channel == "output";
    if (p.source.starts_with("--")) line.insert(line.end(), {p.source, file->second});
  }
  if (!has_output) throw Error(ErrorCode::usage, "nothing would be written; choose at least one output");
  if (!module.writes_folder) line.insert(line.end(), {"--json", report.string()});
  if (module.writes_folder) {
    line.insert(line.end(), {"--output", folder.string()});
    if (kept == call.files.end()) line.insert(line.end(), {"--no-view", "--no-picture"});
  }
  line.emplace_back("--overwrite");

  const auto start = std::chrono::steady_clock::now();
  std::printf("<filter-start>\n<filter-name>%s</filter-name>\n<filter-comment>%s</filter-comment>\n</filter-start>\n",
              module.title, "started");
  std::fflush(stdout);
  const int code = run(line, kept == call.files.end() ? folder.string() + "/" : std::string());
  if (code != 0) return code;
  if (module.writes_folder)
    for (const SlicerParameter& p : module.files)
      if (const auto file = call.files.find(p.name); is_file(p) && p.channel == "output" && file != call.files.end())
        copy_result(folder / p.source, file->second);
  if (!call.return_file.empty()) write_returned(module, report, call.return_file);
  const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start;
  std::printf(
      "<filter-progress>1</filter-progress>\n<filter-end>\n<filter-name>%s</filter-name>\n"
      "<filter-time>%.3f</filter-time>\n</filter-end>\n",
      module.title, spent.count());
  return 0;
}

}  // namespace quench::program
