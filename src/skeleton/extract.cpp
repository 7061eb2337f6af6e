// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/constants.h"
#include "base/graph_peeler.h"
#include "quench/error.h"
#include "quench/skeleton.h"

namespace quench {
namespace {

using base::kNever;

// The cells of K that a member of the family has.
struct Member {
  std::vector<char> vertex, edge, face;
};

// Free ends of curves grow back into what was pruned beyond them. All of that hangs on them alone.
void grow_tips(const SkeletonFamily& family, double tips, const base::GraphPeeler& left, Member& member) {
  const RefinedAxis& k = family.refined;
  const auto edges = static_cast<std::uint32_t>(k.complex.edges.size());
  std::vector<std::uint32_t> offsets(std::size_t{k.complex.vertex_count} + 1, 0), list;
  const auto is_pruned = [&](std::uint32_t e) { return k.curve_edge[e] && !member.edge[e]; };
  for (std::uint32_t e = 2 * k.doors; e < edges; ++e)
    if (is_pruned(e))
      for (const std::uint32_t v : k.complex.edges[e]) ++offsets[v + 1];
  for (std::size_t v = 0; v < k.complex.vertex_count; ++v) offsets[v + 1] += offsets[v];
  list.resize(offsets.back());
  std::vector<std::uint32_t> next(offsets.begin(), offsets.end() - 1);
  for (std::uint32_t e = 2 * k.doors; e < edges; ++e)
    if (is_pruned(e))
      for (const std::uint32_t v : k.complex.edges[e]) list[next[v]++] = e;
  for (std::uint32_t end = 0; end < left.vertex_count(); ++end) {
    if (!left.edges_at(end).single() || !member.vertex[end]) continue;
    for (std::uint32_t v = end;;) {
      std::uint32_t best = kNone;  // ties: the smaller index
      for (std::uint32_t i = offsets[v]; i < offsets[v + 1]; ++i) {
        const std::uint32_t e = list[i];
        if (member.edge[e] || family.thickness_of(e) < tips) continue;
        if (best == kNone || family.level_of(e) > family.level_of(best)) best = e;
      }
      if (best == kNone) break;
      member.edge[best] = 1;
      v = k.complex.edges[best][0] == v ? k.complex.edges[best][1] : k.complex.edges[best][0];
      member.vertex[v] = 1;
    }
  }
}

Member member_of(const SkeletonFamily& family, double theta2, double theta1, double tips) {
  const RefinedAxis& k = family.refined;
  Member member;
  const std::size_t edges = k.complex.edges.size(), vertices = k.complex.vertex_count;
  member.vertex.resize(vertices);
  member.edge.resize(edges);
  member.face.resize(k.complex.face_count());
  for (std::size_t v = 0; v < vertices; ++v) member.vertex[v] = family.vertex_sheet_level[v] >= theta2;
  for (std::size_t e = 0; e < edges; ++e) member.edge[e] = family.edge_sheet_level[e] >= theta2;
  for (std::size_t f = 0; f < member.face.size(); ++f) member.face[f] = family.face_sheet_level[f] >= theta2;

  // Curves: free edges of a thickness below theta1 are removed.
  std::vector<char> on_face(edges, 0);
  for (std::size_t f = 0; f < member.face.size(); ++f)
    if (member.face[f])
      for (const std::uint32_t e : k.complex.sides(f)) on_face[e] = 1;
  base::GraphPeeler left(vertices);
  for (std::uint32_t e = 0; e < edges; ++e)
    if (member.edge[e])
      for (const std::uint32_t v : k.complex.edges[e]) left.add(v, e);
  left.peel(
      [&](std::uint32_t e) -> const auto& { return k.complex.edges[e]; },
      [&](std::uint32_t v, std::uint32_t e) {
        return !k.medial_point[v] && k.curve_edge[e] && !on_face[e] && family.thickness_of(e) < theta1;
      },
      [&](std::uint32_t v, std::uint32_t e) { member.edge[e] = member.vertex[v] = 0; });
  if (tips < kNever) grow_tips(family, tips, left, member);
  return member;
}

class Writer {
 public:
  Writer(const SkeletonFamily& family, const Member& member, bool parts)
      : family_(family), k_(family.refined), member_(member), parts_(parts) {}

  Skeleton run() {
    find_whole_polygons();
    find_inner_vertices();
    number_vertices();
    list_edges();
    list_faces();
    split_parallel_edges();
    finish();
    return std::move(out_);
  }

 private:
  using Path = std::vector<std::uint32_t>;

  bool is_half(std::uint32_t e) const { return e < 2 * k_.doors; }

  // Polygons of M of which no part is missing; their insides are not written.
  void find_whole_polygons() {
    const std::uint32_t polygons =
        k_.polygon_of.empty() ? 0 : *std::max_element(k_.polygon_of.begin(), k_.polygon_of.end()) + 1;
    whole_.assign(polygons, !parts_);
    for (std::size_t f = 0; f < k_.polygon_of.size(); ++f)
      if (!member_.face[f]) whole_[k_.polygon_of[f]] = 0;
    inside_whole_.assign(k_.complex.edges.size(), 0);
    for (std::size_t f = 0; f < k_.polygon_of.size(); ++f)
      if (whole_[k_.polygon_of[f]])
        for (const std::uint32_t e : k_.complex.sides(f))
          if (!is_half(e)) inside_whole_[e] = 1;
  }

  // Nodes inside edges and doors are written where anything but whole polygons meets the edge, or parts of the edge are
  // missing; elsewhere the halves of its segments are strung together.
  void find_inner_vertices() {
    const CellComplex& c = k_.complex;
    needed_.assign(c.vertex_count, 0);
    for (std::uint32_t e = 0; e < c.edges.size(); ++e)
      if (member_.edge[e] && !is_half(e) && !inside_whole_[e])
        for (const std::uint32_t v : c.edges[e]) needed_[v] = 1;
    for (std::size_t f = 0; f < c.face_count(); ++f)
      if (member_.face[f] && !whole_[k_.polygon_of[f]])
        for (const std::uint32_t v : c.corners(f)) needed_[v] = 1;
    // Ends of stretches, and stretches without face: every vertex of them.
    std::vector<std::uint32_t> halves(c.vertex_count, 0);
    std::vector<char> on_whole(c.edges.size(), 0);
    for (std::size_t f = 0; f < c.face_count(); ++f)
      if (member_.face[f])
        for (const std::uint32_t e : c.sides(f)) on_whole[e] = 1;
    for (std::uint32_t e = 0; e < 2 * k_.doors; ++e)
      if (member_.edge[e]) {
        for (const std::uint32_t v : c.edges[e]) {
          ++halves[v];
          if (!on_whole[e]) needed_[v] = 1;
        }
      }
    // What is left inside whole polygons is not written; a vertex without any edge is.
    std::vector<char> has_edge(c.vertex_count, 0);
    for (std::uint32_t e = 0; e < c.edges.size(); ++e)
      if (member_.edge[e])
        for (const std::uint32_t v : c.edges[e]) has_edge[v] = 1;
    for (std::uint32_t v = 0; v < c.vertex_count; ++v)
      if (member_.vertex[v] && ((halves[v] > 0 && halves[v] != 2) || !has_edge[v])) needed_[v] = 1;
  }

  void number_vertices() {
    original_ = k_.original;
    map_.resize(k_.complex.vertex_count);
    for (std::uint32_t v = 0; v < map_.size(); ++v) map_[v] = v;
    // Region duals are written merged into their exit doors.
    for (std::uint32_t v = k_.nodes + k_.doors; v < map_.size(); ++v) {
      const std::uint32_t e = k_.exit[v];
      if (e == kNone || !member_.edge[e] || !member_.vertex[v]) continue;
      map_[v] = k_.complex.edges[e][0] == v ? k_.complex.edges[e][1] : k_.complex.edges[e][0];
    }
    // On curves that never burn nothing exits: a dual inside such a curve goes to the door that burns last on the
    // sheet, so that it runs on the edges of the sheet's fire and not to and fro between them and the middles of
    // polygons.
    std::vector<std::uint32_t> curves(map_.size(), 0), door(map_.size(), kNone);
    for (std::uint32_t e = 2 * k_.doors; e < k_.complex.edges.size(); ++e) {
      const auto [a, v] = k_.complex.edges[e];
      if (!member_.edge[e] || !k_.curve_edge[e] || v < k_.nodes + k_.doors) continue;
      ++curves[v];
      if (door[v] == kNone || k_.burn_time[a] > k_.burn_time[door[v]]) door[v] = a;
    }
    for (std::uint32_t v = k_.nodes + k_.doors; v < map_.size(); ++v)
      if (member_.vertex[v] && map_[v] == v && curves[v] == 2) map_[v] = door[v];
    // But not where a part of a sheet would be pressed flat: between doors of one side of its polygon.
    for (std::size_t f = 0; f < k_.complex.face_count(); ++f) {
      if (!member_.face[f] || whole_[k_.polygon_of[f]]) continue;
      const auto corners = k_.complex.corners(f);
      if (map_[corners[0]] != corners[0] && !has_area(corners)) map_[corners[0]] = corners[0];
    }
    number_.assign(map_.size(), kNone);
  }
  bool has_area(std::span<const std::uint32_t> corners) const {
    const Vec3 origin = k_.points[map_[corners[0]]];
    Vec3 area = Vec3::Zero();
    double size = 0;
    for (std::size_t i = 1; i < corners.size(); ++i) {
      const Vec3 b = k_.points[corners[i]] - origin;
      size = std::max(size, b.squaredNorm());
      if (i > 1) area += (k_.points[corners[i - 1]] - origin).cross(b);
    }
    return area.norm() > 1e-9 * size;
  }
  bool is_written(std::uint32_t v) const {
    if (!member_.vertex[v]) return false;
    if (v < original_) return true;
    return needed_[v] != 0;
  }
  std::uint32_t number(std::uint32_t v) {
    v = map_[v];
    if (number_[v] == kNone) {
      number_[v] = add_vertex(k_.points[v], k_.radius[v], k_.burn_time[v], k_.curve_burn_time[v], k_.curve_vertex[v]);
    }
    return number_[v];
  }
  std::uint32_t add_vertex(const Vec3& point, double radius, double burn, double curve, bool on_curve) {
    out_.points.push_back(point);
    out_.radius.push_back(radius);
    out_.burn_time.push_back(burn);
    out_.curve_burn_time.push_back(curve);
    out_.on_curve.push_back(on_curve);
    return static_cast<std::uint32_t>(out_.points.size() - 1);
  }

  struct Edge {
    std::array<std::uint32_t, 2> ends;
    double thickness, level;
    bool mesh;  // lies on an edge of M
  };
  std::uint32_t add_edge(std::uint32_t a, std::uint32_t b, std::uint32_t of, bool mesh) {
    const bool curve = of != kNone && k_.curve_edge[of];
    edges_.push_back({{std::min(a, b), std::max(a, b)},
                      curve ? family_.thickness_of(of) : std::numeric_limits<double>::quiet_NaN(),
                      curve ? family_.level_of(of) : std::numeric_limits<double>::quiet_NaN(),
                      mesh});
    return static_cast<std::uint32_t>(edges_.size() - 1);
  }

  // edge_[e]: the written edge that edge e of K is, or is a stretch of.
  void list_edges() {
    const CellComplex& c = k_.complex;
    for (std::uint32_t v = 0; v < c.vertex_count; ++v)
      if (is_written(v)) number(v);
    edge_.assign(c.edges.size(), kNone);
    // Halves come edge by edge of M, in order along it: string them together between written vertices.
    for (std::uint32_t d = 0; d < k_.doors; ++d)
      for (std::uint32_t e = 2 * d; e < 2 * d + 2; ++e) {
        if (!member_.edge[e]) continue;
        // The half's end nearer to the edge's start: the node for the first half, the door for the second.
        const std::uint32_t start = c.edges[e][e % 2 == 0 ? 0 : 1], end = c.edges[e][e % 2 == 0 ? 1 : 0];
        if (is_written(start)) stretch_start_ = start;
        pending_.push_back(e);
        if (!is_written(end)) continue;
        const std::uint32_t written = add_edge(number(stretch_start_), number(end), kNone, true);
        for (const std::uint32_t p : pending_) edge_[p] = written;
        pending_.clear();
      }
    for (std::uint32_t e = 2 * k_.doors; e < c.edges.size(); ++e) {
      if (!member_.edge[e] || inside_whole_[e]) continue;
      const std::uint32_t a = number(c.edges[e][0]), b = number(c.edges[e][1]);
      if (a != b) edge_[e] = add_edge(a, b, e, false);
    }
  }

  struct Face {
    Path corners, sides;
    double thickness, level;
  };

  void list_faces() {
    const CellComplex& c = k_.complex;
    for (std::size_t f = 0; f < c.face_count();) {
      const std::uint32_t polygon = k_.polygon_of[f];
      std::size_t end = f;
      while (end < c.face_count() && k_.polygon_of[end] == polygon) ++end;
      if (whole_[polygon]) {
        whole_face(f, end);
      } else {
        for (std::size_t part = f; part < end; ++part)
          if (member_.face[part]) add_part(part);
      }
      f = end;
    }
  }

  // The outline of a whole polygon: the sides of its parts that are not shared by two of them.
  void whole_face(std::size_t begin, std::size_t end) {
    Face face{{}, {}, 0, kNever};
    next_.clear();
    for (std::size_t f = begin; f < end; ++f) {
      face.thickness = std::max(face.thickness, k_.face_thickness[f]);
      face.level = std::min(face.level, family_.face_sheet_level[f]);
      const auto corners = k_.complex.corners(f);
      const auto sides = k_.complex.sides(f);
      for (std::size_t i = 0; i < corners.size(); ++i)
        if (is_half(sides[i])) next_.push_back({corners[i], corners[(i + 1) % corners.size()], sides[i]});
    }
    std::sort(next_.begin(), next_.end());
    std::uint32_t at = next_.front()[0];
    for (std::size_t step = 0; step < next_.size(); ++step) {
      const auto found = std::lower_bound(next_.begin(), next_.end(), std::array<std::uint32_t, 3>{at, 0, 0});
      const auto [from, to, half] = *found;
      const std::uint32_t side = edge_[half];
      if (is_written(from)) {
        face.corners.push_back(number_[map_[from]]);
        face.sides.push_back(side);
      }
      at = to;
    }
    faces_.push_back(std::move(face));
  }

  void add_part(std::size_t f) {
    Face face{{}, {}, k_.face_thickness[f], family_.face_sheet_level[f]};
    const auto corners = k_.complex.corners(f);
    const auto sides = k_.complex.sides(f);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      if (edge_[sides[i]] == kNone) continue;  // merged away
      face.corners.push_back(number(corners[i]));
      face.sides.push_back(edge_[sides[i]]);
    }
    // One that still meets its spoke twice comes back to its corner: a fan around its first corner, the dual.
    Path sorted = face.corners;
    std::sort(sorted.begin(), sorted.end());
    if (std::adjacent_find(sorted.begin(), sorted.end()) == sorted.end()) {
      faces_.push_back(std::move(face));
      return;
    }
    std::uint32_t before = face.sides.front();
    const std::size_t n = face.corners.size();
    for (std::size_t i = 1; i + 1 < n; ++i) {
      const std::uint32_t after =
          i + 2 == n ? face.sides.back() : add_edge(face.corners[0], face.corners[i + 1], kNone, false);
      faces_.push_back({{face.corners[0], face.corners[i], face.corners[i + 1]},
                        {before, face.sides[i], after},
                        face.thickness,
                        face.level});
      before = after;
    }
  }

  // Edges of K between the same two vertices become paths: all but one get a vertex in the middle.
  void split_parallel_edges() {
    std::vector<std::uint32_t> order(edges_.size());
    for (std::uint32_t e = 0; e < order.size(); ++e) order[e] = e;
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
      if (edges_[a].ends != edges_[b].ends) return edges_[a].ends < edges_[b].ends;
      return edges_[a].mesh != edges_[b].mesh ? edges_[a].mesh : a < b;
    });
    middle_.assign(edges_.size(), kNone);
    for (std::size_t i = 1; i < order.size(); ++i) {
      const Edge& e = edges_[order[i]];
      if (e.ends != edges_[order[i - 1]].ends) continue;
      const auto [a, b] = e.ends;
      middle_[order[i]] =
          add_vertex(0.5 * (out_.points[a] + out_.points[b]), 0.5 * (out_.radius[a] + out_.radius[b]),
                     0.5 * (out_.burn_time[a] + out_.burn_time[b]),
                     0.5 * (out_.curve_burn_time[a] + out_.curve_burn_time[b]), out_.on_curve[a] && out_.on_curve[b]);
    }
  }

  void finish() {
    CellComplex& c = out_.complex;
    c.vertex_count = static_cast<std::uint32_t>(out_.points.size());
    std::vector<std::array<std::uint32_t, 2>> pieces;
    std::vector<double> thickness, level;
    for (std::uint32_t e = 0; e < edges_.size(); ++e) {
      const auto add = [&](std::uint32_t a, std::uint32_t b) {
        pieces.push_back({std::min(a, b), std::max(a, b)});
        thickness.push_back(edges_[e].thickness);
        level.push_back(edges_[e].level);
      };
      if (middle_[e] == kNone) {
        add(edges_[e].ends[0], edges_[e].ends[1]);
      } else {
        add(edges_[e].ends[0], middle_[e]);
        add(edges_[e].ends[1], middle_[e]);
      }
    }
    std::vector<std::uint32_t> offsets{0}, corners;
    for (const Face& face : faces_) {
      for (std::size_t i = 0; i < face.corners.size(); ++i) {
        corners.push_back(face.corners[i]);
        if (middle_[face.sides[i]] != kNone) corners.push_back(middle_[face.sides[i]]);
      }
      offsets.push_back(static_cast<std::uint32_t>(corners.size()));
      out_.face_thickness.push_back(face.thickness);
      out_.face_level.push_back(face.level);
    }
    c = make_complex(c.vertex_count, pieces, std::move(offsets), std::move(corners));
    out_.edge_thickness.assign(c.edges.size(), std::numeric_limits<double>::quiet_NaN());
    out_.edge_level = out_.edge_thickness;
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      const auto at =
          static_cast<std::size_t>(std::lower_bound(c.edges.begin(), c.edges.end(), pieces[i]) - c.edges.begin());
      out_.edge_thickness[at] = thickness[i];
      out_.edge_level[at] = level[i];
    }
  }

  const SkeletonFamily& family_;
  const RefinedAxis& k_;
  const Member& member_;
  bool parts_;
  Skeleton out_;
  std::uint32_t original_ = 0;
  std::vector<char> whole_, inside_whole_, needed_;
  std::vector<std::uint32_t> map_, number_, edge_, middle_;
  std::vector<Edge> edges_;
  std::vector<Face> faces_;
  std::vector<std::uint32_t> pending_;
  std::uint32_t stretch_start_ = kNone;
  std::vector<std::array<std::uint32_t, 3>> next_;
};

}  // namespace

Skeleton extract(const SkeletonFamily& family, double theta2, double theta1, const ExtractOptions& options) {
  if (std::isnan(theta2) || std::isnan(theta1) || std::isnan(options.tips))
    throw Error(ErrorCode::usage, "a skeleton needs theta2, theta1 and tips that are numbers");
  const Member member = member_of(family, theta2, theta1, options.tips);
  Skeleton skeleton = Writer(family, member, options.parts).run();
  skeleton.theta2 = theta2;
  skeleton.theta1 = theta1;
  return skeleton;
}

}  // namespace quench
