// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "graph/settings.h"
#include "quench/error.h"
#include "quench/graph.h"

namespace quench {
namespace {

constexpr double kNotACurve = std::numeric_limits<double>::quiet_NaN();

using Ends = std::array<std::uint32_t, 2>;

Ends sorted(std::uint32_t a, std::uint32_t b) { return {std::min(a, b), std::max(a, b)}; }

// Where the points of one polyline lie on another one, at the same fraction of the length.
class Places {
 public:
  struct Place {
    std::size_t segment;
    double t;
  };
  Places(const std::vector<Vec3>& from, const std::vector<Vec3>& to) : from_(lengths(from)), to_(lengths(to)) {}

  Place of_point(std::size_t i) const { return at(fraction(i)); }

 private:
  static std::vector<double> lengths(const std::vector<Vec3>& points) {
    std::vector<double> at(points.size(), 0);
    for (std::size_t i = 1; i < points.size(); ++i) at[i] = at[i - 1] + (points[i] - points[i - 1]).norm();
    return at;
  }
  double fraction(std::size_t i) const {
    return to_.back() > 0 ? to_[i] / to_.back() : static_cast<double>(i) / static_cast<double>(to_.size() - 1);
  }
  Place at(double fraction) const {
    const double goal = fraction * from_.back();
    const auto above = std::upper_bound(from_.begin() + 1, from_.end() - 1, goal);
    const auto segment = static_cast<std::size_t>(above - from_.begin()) - 1;
    const double piece = from_[segment + 1] - from_[segment];
    return {segment, piece > 0 ? std::clamp((goal - from_[segment]) / piece, 0.0, 1.0) : 0.5};
  }
  std::vector<double> from_, to_;
};

class Redrawing {
 public:
  Redrawing(const Skeleton& old, const CurveGraph& graph) : old_(old), graph_(graph) {}

  Skeleton run() {
    graph::copy_settings(old_, out_);
    out_.face_thickness = old_.face_thickness;
    out_.face_level = old_.face_level;
    out_.face_sheet = old_.face_sheet;
    keep_vertices();
    keep_sheets();
    find_doubled();
    for (std::uint32_t b = 0; b < graph_.branches.size(); ++b) add_branch(b);
    make_cells();
    return std::move(out_);
  }

 private:
  struct Edge {
    Ends ends;
    double thickness, level;
    std::int32_t branch;
  };

  void require(bool holds) const {
    if (!holds) throw Error(ErrorCode::usage, "the branches are not those of the skeleton");
  }

  void keep_vertices() {
    std::vector<char> inner(old_.points.size(), 0);
    for (const CurveGraph::Branch& branch : graph_.branches) {
      require(branch.vertices.size() >= 2 && branch.points.size() >= 2 && branch.radius.size() == branch.points.size());
      for (const std::uint32_t v : branch.vertices) require(v < inner.size());
      for (std::size_t i = 1; i + 1 < branch.vertices.size(); ++i) inner[branch.vertices[i]] = 1;
    }
    number_.assign(inner.size(), kNone);
    for (std::uint32_t v = 0; v < inner.size(); ++v)
      if (!inner[v]) number_[v] = add_vertex(old_.points[v], old_.radius[v], v, v, 0);
    for (const CurveGraph::Node& node : graph_.nodes) {
      require(node.vertex < inner.size() && !inner[node.vertex]);
      out_.points[number_[node.vertex]] = node.point;
      out_.radius[number_[node.vertex]] = node.radius;
    }
  }

  std::uint32_t add_vertex(const Vec3& point, double radius, std::uint32_t a, std::uint32_t b, double t) {
    // On the way of a branch there is no pocket: what is infinite at one end only does not reach inside.
    const auto mix = [&](const std::vector<double>& values) {
      if (t == 0 || values[a] == values[b]) return values[a];
      if (std::isinf(values[a])) return values[b];
      return std::isinf(values[b]) ? values[a] : (1 - t) * values[a] + t * values[b];
    };
    out_.points.push_back(point);
    out_.radius.push_back(radius);
    const double time = mix(old_.burn_time);
    out_.burn_time.push_back(t > 0 && std::isinf(time) ? radius : time);
    out_.curve_burn_time.push_back(mix(old_.curve_burn_time));
    if (!old_.mgf.empty()) out_.mgf.push_back(mix(old_.mgf));
    out_.on_curve.push_back(t == 0 ? old_.on_curve[a] : old_.on_curve[a] && old_.on_curve[b]);
    return static_cast<std::uint32_t>(out_.points.size() - 1);
  }

  void keep_sheets() {
    std::vector<char> of_face(old_.complex.edges.size(), 0);
    for (const std::uint32_t e : old_.complex.face_edges) of_face[e] = 1;
    for (std::uint32_t e = 0; e < of_face.size(); ++e) {
      const auto [a, b] = old_.complex.edges[e];
      if (!of_face[e]) continue;
      require(number_[a] != kNone && number_[b] != kNone);
      edges_.push_back({sorted(number_[a], number_[b]), old_.edge_thickness[e], old_.edge_level[e], -1});
    }
  }

  // Ends of branches of one segment that other edges have, too.
  void find_doubled() {
    for (const Edge& edge : edges_) single_.push_back(edge.ends);
    for (const CurveGraph::Branch& branch : graph_.branches)
      if (branch.points.size() == 2) single_.push_back(ends_of(branch));
    std::sort(single_.begin(), single_.end());
  }
  Ends ends_of(const CurveGraph::Branch& branch) const {
    return sorted(number_[graph_.nodes[branch.from].vertex], number_[graph_.nodes[branch.to].vertex]);
  }
  bool is_doubled(const Ends& ends) const {
    const auto [first, last] = std::equal_range(single_.begin(), single_.end(), ends);
    return last - first > 1;
  }

  void add_branch(std::uint32_t b) {
    const CurveGraph::Branch& branch = graph_.branches[b];
    std::vector<Vec3> points = branch.points;
    std::vector<double> radius = branch.radius;
    if (points.size() == 2 && is_doubled(ends_of(branch))) {
      points.insert(points.begin() + 1, 0.5 * (points[0] + points[1]));
      radius.insert(radius.begin() + 1, 0.5 * (radius[0] + radius[1]));
    }
    const std::vector<std::uint32_t>& was = branch.vertices;
    const bool same = was.size() == points.size();
    std::vector<Vec3> before;
    for (const std::uint32_t v : was) before.push_back(old_.points[v]);
    const Places places(before, points);
    std::uint32_t last = number_[was.front()];
    for (std::size_t i = 1; i < points.size(); ++i) {
      std::uint32_t next = number_[was.back()];
      if (i + 1 < points.size()) {
        const Places::Place at = same ? Places::Place{i, 0} : places.of_point(i);
        next = add_vertex(points[i], radius[i], was[at.segment], was[std::min(at.segment + 1, was.size() - 1)], at.t);
      }
      const std::size_t first = same ? i - 1 : places.of_point(i - 1).segment,
                        end = same ? i - 1 : places.of_point(i).segment;
      Edge edge{sorted(last, next), kNotACurve, kNotACurve, static_cast<std::int32_t>(b)};
      for (std::size_t k = first; k <= end; ++k) {
        const std::uint32_t e = old_edge(was, k);
        edge.thickness = std::fmax(edge.thickness, old_.edge_thickness[e]);
        edge.level = std::fmax(edge.level, old_.edge_level[e]);
      }
      edges_.push_back(edge);
      last = next;
    }
  }
  std::uint32_t old_edge(const std::vector<std::uint32_t>& vertices, std::size_t segment) const {
    const Ends ends = sorted(vertices[segment], vertices[segment + 1]);
    const auto at = std::lower_bound(old_.complex.edges.begin(), old_.complex.edges.end(), ends);
    require(at != old_.complex.edges.end() && *at == ends);
    return static_cast<std::uint32_t>(at - old_.complex.edges.begin());
  }

  void make_cells() {
    std::sort(edges_.begin(), edges_.end(), [](const Edge& a, const Edge& b) { return a.ends < b.ends; });
    std::vector<Ends> ends;
    for (const Edge& edge : edges_) {
      ends.push_back(edge.ends);
      out_.edge_thickness.push_back(edge.thickness);
      out_.edge_level.push_back(edge.level);
      out_.edge_branch.push_back(edge.branch);
    }
    std::vector<std::uint32_t> corners = old_.complex.face_vertices;
    for (std::uint32_t& v : corners) v = number_[v];
    out_.complex = make_complex(static_cast<std::uint32_t>(out_.points.size()), ends, old_.complex.face_offsets,
                                std::move(corners));
    require(out_.complex.edges.size() == edges_.size());
  }

  const Skeleton& old_;
  const CurveGraph& graph_;
  Skeleton out_;
  std::vector<std::uint32_t> number_;  // per old vertex; kNone inside branches
  std::vector<Edge> edges_;
  std::vector<Ends> single_;
};

}  // namespace

Skeleton with_branches(const Skeleton& skeleton, const CurveGraph& graph) { return Redrawing(skeleton, graph).run(); }

}  // namespace quench
