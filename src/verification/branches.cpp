// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

#include "verification/checks.h"

/// The curves of skeletons, branch by branch.
namespace quench::verification {

namespace {

// Of the largest ratio on a branch: arrays are interpolated where branches were sampled anew.
constexpr double kInterpolatedRatio = 0.9;

// The two lines of a vertex of no other cell that is no isolated one; else none.
bool is_passed(const Result& result, std::uint32_t v) {
  return result.vertex_edges[v].size() == 2 && result.vertex_faces[v].empty();
}

/// Maximal paths of lines: per line of the file, the first line of its path.
std::vector<std::uint32_t> paths_of(const Result& result) {
  std::vector<std::uint32_t> line_of(result.complex.edges.size(), kNone), first(result.line_edges.size());
  for (std::uint32_t l = 0; l < result.line_edges.size(); ++l) line_of[result.line_edges[l]] = l;
  std::iota(first.begin(), first.end(), 0u);
  const auto root = [&](std::uint32_t l) {
    while (first[l] != l) l = first[l] = first[first[l]];
    return l;
  };
  for (std::uint32_t v = 0; v < result.complex.vertex_count; ++v) {
    if (!is_passed(result, v)) continue;
    const std::uint32_t a = root(line_of[result.vertex_edges[v][0]]), b = root(line_of[result.vertex_edges[v][1]]);
    first[std::max(a, b)] = std::min(a, b);
  }
  for (std::uint32_t l = 0; l < first.size(); ++l) first[l] = root(l);
  return first;
}

std::string wrong_numbers(const Result& result, const std::vector<double>& branch) {
  const std::size_t first_line = result.data.verts.size(), first_face = result.first_polygon();
  for (std::size_t row = 0; row < branch.size(); ++row)
    if ((row < first_line || row >= first_face) && branch[row] != -1)
      return fmt::format("cell {} is no curve and has branch {:.9g}", row, branch[row]);
  const std::vector<std::uint32_t> paths = paths_of(result);
  std::vector<std::size_t> number(paths.size());
  std::size_t count = 0;
  for (std::uint32_t l = 0; l < paths.size(); ++l) {
    number[l] = paths[l] == l ? count++ : number[paths[l]];
    if (branch[first_line + l] != static_cast<double>(number[l]))
      return fmt::format(
          "the line of {} has branch {:.9g}; counted from one end, junction or sheet to the next it is {}",
          result.describe_edge(result.line_edges[l]), branch[first_line + l], number[l]);
  }
  return {};
}

/// A branch with a free end.
struct FreeBranch {
  std::uint32_t end = kNone;
  double thickness = 0, ratio = 0;  ///< largest ET_MC of its lines; largest ET_MC over burn time (in the plane: ET over
                                    ///< radius) of its points
};

// The point array of how thick curves are.
const char* curve_thickness_of(const Result& result) {
  return result.plane ? "erosion_thickness" : "curve_erosion_thickness";
}

std::vector<FreeBranch> free_branches(const Result& result, const std::vector<double>& curve_thickness) {
  const std::vector<double> of_points = numbers_or_empty(result.data.point_data, curve_thickness_of(result)),
                            times = numbers_or_empty(result.data.point_data, result.plane ? "radius" : "burn_time"),
                            unburned =
                                numbers_or_empty(result.data.point_data, result.plane ? "unburned" : "curve_unburned");
  const bool measured = !of_points.empty() && !times.empty() && !unburned.empty();
  std::map<std::uint32_t, FreeBranch> branches;
  const std::vector<std::uint32_t> paths = paths_of(result);
  for (std::uint32_t l = 0; l < paths.size(); ++l) {
    FreeBranch& branch = branches[paths[l]];
    branch.thickness = std::max(branch.thickness, curve_thickness[result.data.verts.size() + l]);
    for (const std::uint32_t v : result.complex.edges[result.line_edges[l]]) {
      const std::uint32_t row = result.rows[v];
      if (!measured || unburned[row] != 0)
        branch.ratio = kInfiniteLevelInFiles;
      else if (times[row] > 0)
        branch.ratio = std::max(branch.ratio, of_points[row] / times[row]);
      if (is_passed(result, v)) continue;
      const bool is_free = result.vertex_edges[v].size() == 1 && result.vertex_faces[v].empty();
      if (is_free) branch.end = v;
    }
  }
  std::vector<FreeBranch> found;
  for (const auto& [first, branch] : branches)
    if (branch.end != kNone) found.push_back(branch);
  return found;
}

}  // namespace

std::vector<char> smoothed_vertices(const Result& result) {
  std::vector<char> smoothed(result.complex.vertex_count, 0);
  if (result.stage != "skeleton" || !find_array(result.data.cell_data, "branch")) return smoothed;
  const std::vector<double> passes = numbers_or_empty(result.data.field_data, "smooth");
  const bool sheets = passes.size() == 1 && passes[0] > 0;
  for (std::uint32_t v = 0; v < smoothed.size(); ++v)
    smoothed[v] = is_passed(result, v) || (sheets && !result.vertex_faces[v].empty());
  return smoothed;
}

std::string wrong_free_branch(const Result& result, double theta1, const std::vector<double>& curve_thickness) {
  if (result.main_axes) return {};  // ends of the longest way, wherever those are
  const std::vector<double> radii = numbers_or_empty(result.data.field_data, "theta1_radii"),
                            of_points = numbers_or_empty(result.data.point_data, curve_thickness_of(result));
  const bool pruned = text_or_empty(result.data.field_data, "tips") == "pruned" && !of_points.empty();
  const std::vector<std::uint32_t> component = components(result.complex);
  // One of each component stays without: the point that burns last; more where none sticks out, its longest course.
  std::map<std::uint32_t, std::size_t> spared;  // by component
  std::map<std::uint32_t, bool> sticks_out;
  std::vector<std::pair<const FreeBranch*, bool>> wrong;
  const std::vector<FreeBranch> branches = free_branches(result, curve_thickness);
  for (const FreeBranch& branch : branches) {
    const double at_end = pruned ? of_points[result.rows[branch.end]] : branch.thickness;
    const bool too_thin = std::min(at_end, branch.thickness) < theta1 * (1 - 1e-9),
               out = radii.size() != 1 || branch.ratio >= kInterpolatedRatio * radii[0];
    sticks_out[component[branch.end]] |= out && !too_thin;
    if (too_thin || !out) wrong.push_back({&branch, too_thin});
  }
  for (const auto& [branch, too_thin] : wrong)
    if ((too_thin || sticks_out[component[branch->end]]) && ++spared[component[branch->end]] > 1)
      return fmt::format("the branch to the free end at {} {}", result.describe_vertex(branch->end),
                         too_thin ? "is below theta1" : "sticks out of what it leaves by less than theta1_radii");
  return {};
}

Check check_branches(const Result& result) {
  const std::string name = "branches";
  if (result.stage != "skeleton") return not_checked(name, "the file does not say that it is a skeleton");
  const std::vector<double> branch = numbers_or_empty(result.data.cell_data, "branch");
  if (branch.size() != result.data.cell_count()) return not_checked(name, "no cell array 'branch'");
  if (std::string wrong = wrong_numbers(result, branch); !wrong.empty()) return failed(name, std::move(wrong));
  Check check{name, true, {}, {}};
  cover(check, "cell branch");
  check.detail =
      fmt::format("{} lines, in branches from one end, junction or sheet to the next", result.line_edges.size());
  return check;
}

}  // namespace quench::verification
