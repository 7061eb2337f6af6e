// SPDX-License-Identifier: Apache-2.0
#include "tree_conversion.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <set>

#include "base/text.h"
#include "option_checks.h"
#include "program.h"
#include "quench/pipeline.h"
#include "quench/tree.h"
#include "units.h"

namespace quench::program {
namespace {

struct TreeCounts {
  std::size_t nodes = 0, tips = 0, forks = 0;
  double length = 0, bridged = 0;
};

TreeCounts counts_of(const Tree& tree) {
  TreeCounts counts;
  counts.nodes = tree.plants.size();
  std::vector<std::size_t> children(tree.branches.size() + tree.plants.size(), 0);  // of branches, of root nodes
  for (const Tree::Branch& branch : tree.branches) {
    ++children[branch.parent == kNone ? tree.branches.size() + branch.plant : branch.parent];
    counts.nodes += branch.points.size() - 1;
    for (std::size_t i = 1; i < branch.points.size(); ++i) {
      const double step = (branch.points[i] - branch.points[i - 1]).norm();
      counts.length += step;
      if (!branch.bridged.empty() && branch.bridged[i - 1] != 0) counts.bridged += step;
    }
  }
  if (!tree.axes.empty()) {  // what joins them to their parents is no part of them
    counts.length = 0;
    for (const Tree::Axis& axis : tree.axes)
      for (std::size_t i = 1; i < axis.points.size(); ++i)
        counts.length += (axis.points[i] - axis.points[i - 1]).norm();
  }
  for (std::size_t i = 0; i < children.size(); ++i) {
    counts.tips += i < tree.branches.size() && children[i] == 0;
    counts.forks += children[i] > 1;
  }
  return counts;
}

}  // namespace

Json tree_info(const std::filesystem::path& file, Session& session) {
  bool axes_known = false;
  const Tree tree = io::read_tree(file, &axes_known, &session.context);
  const TreeCounts counts = counts_of(tree);
  Json info = {{"kind", "tree"}, {"plants", tree.plants.size()}, {"branches", tree.branches.size()}};
  if (axes_known) info["axes"] = tree.axes.size();
  info["nodes"] = counts.nodes;
  info["tips"] = counts.tips;
  info["forks"] = counts.forks;
  info["length"] = counts.length;
  if (counts.bridged > 0) info["joined_length"] = counts.bridged;
  if (!tree.coordinates.units.empty()) info["units"] = tree.coordinates.units;
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Vec3 low = Vec3::Constant(kInfinity), high = -low;
  double thinnest = kInfinity, thickest = 0;
  std::set<int> types;
  for (const Tree::Branch& branch : tree.branches) {
    if (branch.type > 0) types.insert(branch.type);
    for (std::size_t i = 0; i < branch.points.size(); ++i) {
      low = low.cwiseMin(branch.points[i]);
      high = high.cwiseMax(branch.points[i]);
      thinnest = std::min(thinnest, branch.radius[i]);
      thickest = std::max(thickest, branch.radius[i]);
    }
  }
  info["box"] = {{low[0], low[1], low[2]}, {high[0], high[1], high[2]}};
  if (thickest > 0)
    info["radius"] = {thinnest, thickest};
  else
    info["radius"] = "not known";
  if (!types.empty()) info["types"] = types;
  const auto somas =
      std::ranges::count_if(tree.plants, [](const Tree::Plant& plant) { return plant.soma.has_value(); });
  if (somas > 0) info["somas"] = somas;
  if (axes_known) {
    std::vector<std::size_t> levels;
    for (const Tree::Axis& axis : tree.axes) {
      levels.resize(std::max<std::size_t>(levels.size(), axis.level + 1), 0);
      ++levels[axis.level];
    }
    info["axes_per_level"] = levels;
  }
  return info;
}

void check_tree_format(const std::filesystem::path& output) {
  const std::string extension = extension_of(output);
  if (extension != ".swc" && extension != ".rsml" && extension != ".mtg" && extension != ".vtp" &&
      extension != ".graphml")
    throw Error(ErrorCode::usage,
                fmt::format("'{}': a tree is written as .swc, .rsml, .mtg, .vtp or .graphml", output.string()));
}

void convert_tree(const std::filesystem::path& input, const std::filesystem::path& output, Session& session) {
  bool axes_known = false;
  Tree tree = io::read_tree(input, &axes_known, &session.context);
  take_units(tree.coordinates, input.string(), session);
  checkpoint(&session.context, "read", 1);
  if (!axes_known) tree = with_hierarchy(std::move(tree), {});
  const std::string extension = extension_of(output);
  if (extension == ".swc") io::write_swc(output, tree);
  if (extension == ".rsml") io::write_rsml(output, tree);
  if (extension == ".mtg") io::write_mtg(output, tree);
  if (extension == ".vtp") io::write_centerlines(output, tree);
  if (extension == ".graphml") io::write_graphml(output, tree);
  session.finished("write");
  const TreeCounts counts = counts_of(tree);
  session.say(fmt::format("{}: {}, {}, {}, length {:.6g}{}", output.string(), base::counted(tree.plants.size(), "tree"),
                          base::counted(tree.axes.size(), "axis", "axes"),
                          base::counted(tree.branches.size(), "branch", "branches"), counts.length,
                          tree.coordinates.units.empty() ? "" : " " + tree.coordinates.units));
}

}  // namespace quench::program
