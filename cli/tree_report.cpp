// SPDX-License-Identifier: Apache-2.0
#include "tree_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/text.h"
#include "report.h"

namespace quench::program {
namespace {

using Kind = TreeEdit::Kind;

Json point_json(const Vec3& p) { return {p[0] + 0.0, p[1] + 0.0, p[2] + 0.0}; }  // -0 is 0

std::vector<std::size_t> axes_by_level(const Tree& tree) {
  std::vector<std::size_t> counts;
  for (const Tree::Axis& axis : tree.axes) {
    counts.resize(std::max<std::size_t>(counts.size(), axis.level + 1));
    ++counts[axis.level];
  }
  return counts;
}

/// Of all axes, as in the table of the sample.
double total_length(const Tree& tree) {
  double sum = 0;
  for (const Tree::Axis& axis : tree.axes)
    for (std::size_t i = 1; i < axis.points.size(); ++i) sum += (axis.points[i] - axis.points[i - 1]).norm();
  return sum;
}

/// Of all points of axes, how far the lowest lies below the highest.
double depth_of(const Tree& tree) {
  double low = HUGE_VAL, high = -HUGE_VAL;
  for (const Tree::Axis& axis : tree.axes)
    for (const Vec3& p : axis.points) {
      low = std::min(low, p.dot(tree.down));
      high = std::max(high, p.dot(tree.down));
    }
  return high - low;
}

std::string joined(const std::vector<std::string>& parts) {
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : ", ") + part;
  return text;
}

/// A part of a length in words: "less than 0.1 %".
std::string part_text(double part, double whole) {
  const double percent = whole > 0 ? 100 * part / whole : 0;
  return percent < 0.1 ? "less than 0.1 %" : fmt::format("{:.1f} %", percent);
}

}  // namespace

std::string unit_text(const Coordinates& coordinates) {
  return coordinates.units.empty() ? "the input's units" : coordinates.units;
}

Json repair_section(const pipeline::TreeRun& run, const std::string& list) {
  Json section = {{"components_before", run.components_before},
                  {"loops_before", run.loops_before},
                  {"length_before", run.length_before}};
  for (const Kind kind : {Kind::cut_loop, Kind::cut_touching, Kind::cut_crossing, Kind::bridge, Kind::left_out})
    section[name_of(kind)] = {{"count", run.edits_of(kind)}, {"length", run.length_of(kind)}};
  section["list"] = list;
  if (run.edited_topology)
    section["edited_shape"] = {{"voxels", run.edited->voxel_count()}, {"betti", run.edited_topology->betti}};
  return section;
}

Json tree_section(const pipeline::TreeRun& run) {
  const Tree& tree = run.tree;
  Json plants = Json::array();
  for (const Tree::Plant& plant : tree.plants) {
    Json row = {{"root", point_json(plant.root)}, {"main_axis", plant.main_axis}};
    if (plant.soma) row["soma_radius"] = *plant.soma;
    if (!plant.label.empty()) row["label"] = plant.label;
    plants.push_back(std::move(row));
  }
  return {{"plants", std::move(plants)},      {"axes", tree.axes.size()},      {"axes_by_level", axes_by_level(tree)},
          {"branches", tree.branches.size()}, {"length", total_length(tree)},  {"depth", depth_of(tree)},
          {"rule", name_of(tree.rule)},       {"down", point_json(tree.down)}, {"units", tree.coordinates.units}};
}

Json traits_section(const Table& sample) {
  Json section = Json::object();
  for (const Table::Column& column : sample.columns)
    std::visit(
        [&](const auto& values) {
          if (values.empty()) return;
          const auto& value = values.front();
          if constexpr (std::is_same_v<std::decay_t<decltype(value)>, double>)
            section[column.name] = std::isfinite(value) ? Json(value) : Json(nullptr);
          else
            section[column.name] = value;
        },
        column.values);
  return section;
}

void say_repair(const pipeline::TreeRun& run, const std::string& list, Session& session) {
  session.say(fmt::format("curves: {}, {}, total length {:.5g}", base::counted(run.components_before, "component"),
                          base::counted(run.loops_before, "loop"), run.length_before));
  const std::size_t touching = run.edits_of(Kind::cut_touching), crossing = run.edits_of(Kind::cut_crossing),
                    cuts = run.edits_of(Kind::cut_loop) + touching + crossing, bridges = run.edits_of(Kind::bridge),
                    left_out = run.edits_of(Kind::left_out);
  const double cut_length =
      run.length_of(Kind::cut_loop) + run.length_of(Kind::cut_touching) + run.length_of(Kind::cut_crossing);
  std::vector<std::string> done, of_cuts;
  if (touching > 0) of_cuts.push_back(fmt::format("{} where tubes touch", touching));
  if (crossing > 0) of_cuts.push_back(fmt::format("{} where they cross", crossing));
  if (cuts > 0)
    done.push_back(fmt::format("{}{} with {} of the length", base::counted(cuts, "cut"),
                               of_cuts.empty() ? "" : fmt::format(" ({})", joined(of_cuts)),
                               part_text(cut_length, run.length_before)));
  if (bridges > 0) done.push_back(base::counted(bridges, "bridge"));
  if (left_out > 0)
    done.push_back(fmt::format("{} left out with {} of the length", base::counted(left_out, "part"),
                               part_text(run.length_of(Kind::left_out), run.length_before)));
  session.say(done.empty() ? "repair: nothing was to be done"
                           : fmt::format("repair: {}; {} lists them", joined(done), list));
  const double kept = total_length(run.tree), joined_up = run.length_before - run.length_of(Kind::left_out);
  if (run.loops_before > 0 && 4 * kept < 3 * joined_up)
    session.say(fmt::format(
        "note: this does not look like a tree: its axes have {} of the length of the curves, the rest was cut to open "
        "loops or is no axis after that, as of shells and nets; quench run keeps loops, another --threshold or --blur "
        "may help against noise",
        part_text(kept, joined_up)));
  if (2 * run.length_of(Kind::left_out) > run.length_before)
    session.say(
        "note: this does not look like a tree: more than half of the length is left out; another --threshold or "
        "--blur may help against noise, --plants N keeps more trees than one");
}

std::string tree_text(const pipeline::TreeRun& run) {
  const Tree& tree = run.tree;
  constexpr std::size_t kLevels = 5;  // that are told apart
  std::vector<std::string> levels;
  const std::vector<std::size_t> counts = axes_by_level(tree);
  std::size_t more = 0;
  for (std::size_t level = 0; level < counts.size(); ++level)
    if (level < kLevels)
      levels.push_back(fmt::format("{} of level {}", counts[level], level));
    else
      more += counts[level];
  if (more > 0) levels.push_back(fmt::format("{} of higher levels", more));
  return fmt::format("{}{} ({}), total length {:.5g}, depth {:.5g}; lengths in {}",
                     tree.plants.size() == 1 ? "" : base::counted(tree.plants.size(), "tree") + ", ",
                     base::counted(tree.axes.size(), "axis", "axes"), joined(levels), total_length(tree),
                     depth_of(tree), unit_text(tree.coordinates));
}

}  // namespace quench::program
