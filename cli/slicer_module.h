// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

/// Commands as command line modules of 3D Slicer: described and called by the rules of the SlicerExecutionModel, from
/// the definitions that --help shows. A module names its inputs and outputs one by one, also where the command writes a
/// folder; its flags are identifiers ("--min_component" for --min-component).
namespace quench::program {

struct SlicerParameter {
  std::string tag;  ///< "image", "geometry", "table", "integer", "string-enumeration" ...
  std::string name, label, description;
  std::string value = {};       ///< by default
  std::string channel = {};     ///< of files "input" or "output"; of numbers "output": returned
  std::string extensions = {};  ///< of files, the one that Slicer takes first
  std::string type = {};        ///< of images and geometries
  std::string source = {};      ///< the option of the command; of outputs the file in its folder; of returned numbers
                                ///< the place in its report, a JSON pointer
  std::vector<std::string> elements = {};  ///< of enumerations
  std::optional<std::pair<double, double>> range = {};
  bool several = false;  ///< may be given again and again
};

struct SlicerGroup {
  std::string label, description;
  bool advanced = false;  ///< folded up at first
  std::vector<SlicerParameter> parameters;
};

/// The commands that are modules: run, thickness, tree.
bool is_slicer_module(const std::string& command);

/// All parameters of the module. Precondition: is_slicer_module().
std::vector<SlicerGroup> slicer_groups(CLI::App& command);

/// The description that Slicer asks for with --xml, UTF-8.
std::string slicer_description(CLI::App& command);

/// Does what Slicer asks of a module: the words are those behind the name of the program. `run` runs a command line and
/// returns its exit code; what it says leaves out the folder, where one is named, which is gone afterwards. Progress
/// and notes go to stdout, in the format of Slicer; outputs are replaced. Throws Error(usage) for parameters that are
/// unknown, lack a value, or name no input or no output, and all that `run` does.
int call_slicer_module(CLI::App& command, const std::vector<std::string>& words,
                       const std::function<int(const std::vector<std::string>&, const std::string& folder)>& run);

}  // namespace quench::program
