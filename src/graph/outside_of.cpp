// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "graph/branch_measures.h"
#include "quench/graph.h"

namespace quench {
namespace {

// Where a segment from a to b passes from one voxel to the next, from 0 at a to 1 at b, both included.
std::vector<double> borders_between(const Grid& grid, const Vec3& a, const Vec3& b) {
  const Vec3 from = grid.lattice(a), to = grid.lattice(b);
  std::vector<double> at{0, 1};
  for (int axis = 0; axis < 3; ++axis) {
    const auto [low, high] = std::minmax(from[axis], to[axis]);
    for (double border = std::floor(low) + 1; border < high; ++border)
      at.push_back((border - from[axis]) / (to[axis] - from[axis]));
  }
  std::sort(at.begin(), at.end());
  return at;
}

class Clipping {
 public:
  Clipping(const CurveGraph& graph, const VoxelShape& part) : graph_(graph), part_(part) {}

  CurveGraph run() {
    result_.components = graph_.components;
    result_.sheets = graph_.sheets;
    result_.sheet_only = graph_.sheet_only;
    node_.assign(graph_.nodes.size(), kNone);
    for (std::uint32_t n = 0; n < graph_.nodes.size(); ++n)
      if (!is_inside(graph_.nodes[n].point)) {
        node_[n] = static_cast<std::uint32_t>(result_.nodes.size());
        result_.nodes.push_back(graph_.nodes[n]);
        result_.nodes.back().degree = 0;
      }
    for (const CurveGraph::Branch& branch : graph_.branches) clip(branch);
    for (const CurveGraph::Branch& branch : result_.branches) {
      ++result_.nodes[branch.from].degree;
      ++result_.nodes[branch.to].degree;
    }
    return std::move(result_);
  }

 private:
  bool is_inside(const Vec3& point) const {
    const Vec3 at = part_.grid().lattice(point);
    return part_.contains(static_cast<std::int64_t>(std::floor(at[0])), static_cast<std::int64_t>(std::floor(at[1])),
                          static_cast<std::int64_t>(std::floor(at[2])));
  }

  void clip(const CurveGraph::Branch& branch) {
    bool open = node_[branch.from] != kNone;
    if (open) begin(branch, node_[branch.from], at_place(branch, 1, 0));
    for (std::size_t i = 1; i < branch.points.size(); ++i) {
      const Vec3 &a = branch.points[i - 1], &b = branch.points[i];
      const auto between = [&](double t) -> Vec3 { return a + t * (b - a); };
      const std::vector<double> at = borders_between(part_.grid(), a, b);
      for (std::size_t k = 1; k < at.size(); ++k) {
        if (at[k] == at[k - 1]) continue;
        const bool outside = !is_inside(between(0.5 * (at[k - 1] + at[k])));
        if (outside == open) continue;
        const Place place = at_place(branch, i, at[k - 1]);
        if (outside)
          begin(branch, border(branch, place), place);
        else
          end(border(branch, place), place);
        open = outside;
      }
      if (open && i + 1 < branch.points.size()) add(at_place(branch, i, 1));
    }
    if (!open) return;
    const Place last = at_place(branch, branch.points.size() - 1, 1);
    const std::uint32_t to = node_[branch.to];
    end(to != kNone ? to : border(branch, last), last);
  }

  // What a branch has at a place between two of its points.
  struct Place {
    Vec3 point;
    double radius;
    std::optional<double> erosion_thickness, mgf;
  };
  static Place at_place(const CurveGraph::Branch& branch, std::size_t i, double t) {
    const auto mix = [&](const std::vector<double>& values) {
      const double a = values[i - 1], b = values[i];
      if (t == 0 || a == b) return a;
      if (t == 1) return b;
      return std::isinf(a) || std::isinf(b) ? std::min(a, b) : (1 - t) * a + t * b;
    };
    Place place;
    place.point =
        t == 1 ? branch.points[i] : Vec3(branch.points[i - 1] + t * (branch.points[i] - branch.points[i - 1]));
    place.radius = mix(branch.radius);
    if (!branch.erosion_thickness.empty()) place.erosion_thickness = mix(branch.erosion_thickness);
    if (!branch.mgf.empty()) place.mgf = mix(branch.mgf);
    return place;
  }

  std::uint32_t border(const CurveGraph::Branch& branch, const Place& place) {
    CurveGraph::Node node;
    node.point = place.point;
    node.radius = place.radius;
    node.kind = CurveGraph::NodeKind::border;
    node.component = branch.component;
    node.vertex = kNone;
    result_.nodes.push_back(node);
    return static_cast<std::uint32_t>(result_.nodes.size() - 1);
  }
  void begin(const CurveGraph::Branch& branch, std::uint32_t node, const Place& place) {
    piece_ = {};
    piece_.from = node;
    piece_.component = branch.component;
    piece_.thickness = branch.thickness;
    add(place);
  }
  void add(const Place& place) {
    piece_.points.push_back(place.point);
    piece_.radius.push_back(place.radius);
    if (place.erosion_thickness) piece_.erosion_thickness.push_back(*place.erosion_thickness);
    if (place.mgf) piece_.mgf.push_back(*place.mgf);
  }
  void end(std::uint32_t node, const Place& place) {
    add(place);
    piece_.to = node;
    graph::measure(piece_);
    result_.branches.push_back(std::move(piece_));
  }

  const CurveGraph& graph_;
  const VoxelShape& part_;
  CurveGraph result_;
  CurveGraph::Branch piece_;
  std::vector<std::uint32_t> node_;  // per node of the whole graph
};

}  // namespace

CurveGraph outside_of(const CurveGraph& graph, const VoxelShape& part) { return Clipping(graph, part).run(); }

}  // namespace quench
