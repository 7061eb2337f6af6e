// SPDX-License-Identifier: Apache-2.0
// Burning in the plane: the axis is a graph, whose free ends catch fire when it is there by their radius. Fire runs
// along edges with unit speed and passes a junction over the last edge that is left, when it has come over all others.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "verification/checks.h"
#include "verification/point_measure.h"

namespace quench::verification {

namespace {

/// When fire comes to the vertices of a graph. Arrivals pass from vertex to vertex: one knows when it sends fire over
/// an edge as soon as it knows when fire comes over all of its others. O(edges * largest degree).
class FireOnGraph {
 public:
  explicit FireOnGraph(const Result& result) : result_(result), arrivals_(result.rows.size()) {
    std::vector<std::uint32_t> ready;
    for (std::uint32_t v = 0; v < arrivals_.size(); ++v)
      if (result.vertex_edges[v].size() == 1) ready.push_back(v);
    while (!ready.empty()) {
      const std::uint32_t v = ready.back();
      ready.pop_back();
      for (const std::uint32_t e : result.vertex_edges[v]) send(v, e, ready);
    }
  }

  /// Infinite where fire does not come: on loops, and between them.
  double time(std::uint32_t v) const {
    const Arrivals& at = arrivals_[v];
    const std::size_t edges = result_.vertex_edges[v].size();
    if (at.from.size() + 1 < edges) return std::numeric_limits<double>::infinity();
    // All but the last edge: of one that is not known, fire never comes.
    const bool all = at.from.size() == edges && edges > 0;
    return std::max(result_.radius[v], all ? at.latest[1] : at.latest[0]);
  }

 private:
  struct Arrivals {
    std::vector<std::uint32_t> from, sent;  // edges
    std::array<double, 2> latest{0, 0};     // the largest two times
    std::uint32_t latest_edge = kNone;
    void add(std::uint32_t edge, double time) {
      from.push_back(edge);
      if (time > latest[0] || latest_edge == kNone) {
        latest[1] = std::exchange(latest[0], time);
        latest_edge = edge;
      } else {
        latest[1] = std::max(latest[1], time);
      }
    }
  };

  // If fire has come over all edges but e.
  void send(std::uint32_t v, std::uint32_t e, std::vector<std::uint32_t>& ready) {
    Arrivals& at = arrivals_[v];
    const std::size_t edges = result_.vertex_edges[v].size();
    const bool over_e = std::find(at.from.begin(), at.from.end(), e) != at.from.end();
    if (at.from.size() != edges - (over_e ? 0 : 1) || std::find(at.sent.begin(), at.sent.end(), e) != at.sent.end())
      return;
    at.sent.push_back(e);
    const auto [a, b] = result_.complex.edges[e];
    const double start = std::max(result_.radius[v], at.latest_edge == e ? at.latest[1] : at.latest[0]);
    const std::uint32_t other = a == v ? b : a;
    arrivals_[other].add(e, start + (result_.point(a) - result_.point(b)).norm());
    if (arrivals_[other].from.size() + 1 >= result_.vertex_edges[other].size()) ready.push_back(other);
  }

  const Result& result_;
  std::vector<Arrivals> arrivals_;
};

std::string wrong_fire(const Result& result, const PointMeasure& time) {
  const FireOnGraph fire(result);
  const bool core = result.stage != "skeleton";
  // On the way of branches that were smoothed points slide along, up to the diagonal of a pixel beside the axis.
  const std::vector<char> smoothed = smoothed_vertices(result);
  for (std::uint32_t v = 0; v < result.rows.size(); ++v) {
    const double there = fire.time(v), expected = smoothed[v] ? result.radius[v] : there;
    // Main axes have lost the loops that fire comes to, and branches that it comes from.
    if (result.main_axes ? std::isinf(there) && !time.infinite[v] : time.infinite[v] != (std::isinf(there) ? 1 : 0))
      return fmt::format("{} has {:.9g} in 'unburned', and it is {} a loop or between two", result.describe_vertex(v),
                         time.infinite[v], std::isinf(there) ? "on" : "neither on");
    if (std::isinf(there) || time.infinite[v]) continue;
    const double off = kSingle * expected + (core ? 0 : 2 * result.auto_detail) +
                       4 * result.rounding * result.unit * static_cast<double>(result.rows.size());
    if (!(time.value[v] >= expected - off) || (core && time.value[v] > expected + off))
      return fmt::format("{} burns at {:.9g}; fire along its {} is there at {:.9g}", result.describe_vertex(v),
                         time.value[v], core ? "edges" : "branches, at the earliest,", expected);
  }
  return {};
}

}  // namespace

Check check_burning_of_plane(const Result& result) {
  const std::string name = "burning";
  const PointMeasure time(result, "burn_time", "unburned"), thickness(result, "erosion_thickness", "unburned");
  if (!time.known() || !thickness.known() || result.radius.empty())
    return not_checked(name, "no arrays 'burn_time', 'erosion_thickness' and 'unburned'");
  std::string wrong = wrong_fire(result, time);
  if (wrong.empty()) wrong = wrong_thickness(result, "erosion_thickness", thickness, time, result.radius);
  Check check{name, true, {}, {}};
  if (const std::vector<double> most = numbers_or_empty(result.data.field_data, "max_burn_time");
      most.size() == 1 && result.stage != "skeleton") {
    if (wrong.empty() && !(std::abs(most[0] - time.largest) <= kSingle * time.largest))
      wrong = fmt::format("max_burn_time is {:.9g}, the largest is {:.9g}", most[0], time.largest);
    cover(check, "field max_burn_time");
  }
  if (!wrong.empty()) return failed(name, std::move(wrong));
  cover(check, "point unburned");
  cover(check, "point erosion_thickness");
  if (result.stage == "core") cover(check, "point burn_time");
  const auto unburned = std::count(time.infinite.begin(), time.infinite.end(), 1.0);
  check.detail =
      fmt::format("fire along the edges comes to {} points {} their times, and never to {} on loops and between them",
                  time.infinite.size() - static_cast<std::size_t>(unburned),
                  result.stage == "skeleton" ? "before" : "at", unburned);
  return check;
}

Check check_skeleton_levels_of_plane(const Result& result) {
  const std::string name = "skeleton levels";
  if (result.stage != "skeleton") return not_checked(name, "the file does not say that it is a skeleton");
  const std::vector<double> theta1 = numbers_or_empty(result.data.field_data, "theta1"),
                            level = numbers_or_empty(result.data.cell_data, "curve_level"),
                            thickness = numbers_or_empty(result.data.cell_data, "erosion_thickness");
  if (theta1.size() != 1) return failed(name, "the stage is 'skeleton', but there is no field array 'theta1'");
  if (!(theta1[0] >= 0 && theta1[0] <= kInfiniteLevelInFiles))
    return failed(name, fmt::format("theta1 {:.9g} is not negative, and 3.4e38 stands for infinity", theta1[0]));
  const std::size_t rows = result.data.cell_count(), first_line = result.vert_vertices.size();
  if (level.size() != rows || thickness.size() != rows)
    return not_checked(name, "cell arrays of levels or thickness are missing");
  const double most = rows == 0 ? 0 : *std::max_element(thickness.begin(), thickness.end());
  for (std::size_t row = 0; row < rows; ++row) {
    const char* wrong = nullptr;
    if (!(thickness[row] >= 0 && level[row] >= 0 && level[row] <= kInfiniteLevelInFiles))
      wrong = "they are not negative, and 3.4e38 stands for infinity";
    else if (row < first_line && (level[row] != kInfiniteLevelInFiles || thickness[row] != 0))
      wrong = "points stay and have no thickness";
    else if (row >= first_line && thickness[row] < most && !(level[row] >= thickness[row] * (1 - 1e-9)))
      wrong = "a branch stays at least as long as its thickness";  // what never burns has the largest finite value
    if (wrong)
      return failed(name, fmt::format("cell {}: curve_level {:.9g}, erosion_thickness {:.9g}: {}", row, level[row],
                                      thickness[row], wrong));
  }
  if (std::string free = wrong_free_branch(result, theta1[0], thickness); !free.empty())
    return failed(name, std::move(free));
  return {name, true, fmt::format("no free branch below theta1 {:.9g}", theta1[0]), {}};
}

}  // namespace quench::verification
