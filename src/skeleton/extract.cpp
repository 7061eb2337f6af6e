// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/cofaces.h"
#include "base/constants.h"
#include "base/union_find.h"
#include "quench/error.h"
#include "quench/skeleton.h"
#include "skeleton/member.h"

namespace quench {
namespace {

using base::kNever;
using skeleton::Member;
using skeleton::other_end;
using skeleton::SheetCut;

constexpr double kNotACurve = std::numeric_limits<double>::quiet_NaN();

// How the cells of a member are written.
struct Outline {
  std::vector<char> whole;           // per polygon of M: no part is missing; one face, and nothing of its inside
  std::vector<char> inside_whole;    // per edge of K: in the inside of such a polygon
  std::vector<char> kept;            // per vertex of K: written; halves of segments are joined where it is not
  std::vector<std::uint32_t> drawn;  // per vertex of K: the one in whose place it is written
};

bool is_half(const RefinedAxis& k, std::uint32_t e) { return e < 2 * k.doors; }

void find_whole_polygons(const RefinedAxis& k, const Member& member, bool parts, Outline& outline) {
  const std::uint32_t polygons =
      k.polygon_of.empty() ? 0 : *std::max_element(k.polygon_of.begin(), k.polygon_of.end()) + 1;
  outline.whole.assign(polygons, !parts);
  for (const std::uint32_t polygon : k.incomplete)
    if (polygon < polygons) outline.whole[polygon] = 0;
  for (std::size_t f = 0; f < k.polygon_of.size(); ++f)
    if (member.face[f] != Member::kWhole) outline.whole[k.polygon_of[f]] = 0;
  outline.inside_whole.assign(k.complex.edges.size(), 0);
  for (std::size_t f = 0; f < k.polygon_of.size(); ++f)
    if (outline.whole[k.polygon_of[f]])
      for (const std::uint32_t e : k.complex.sides(f))
        if (!is_half(k, e)) outline.inside_whole[e] = 1;
}

// Edges of a member: those of K that are whole, and pieces.
std::uint32_t edge_in_k(const RefinedAxis& k, const Member& member, std::uint32_t e) {
  const std::size_t edges = k.complex.edges.size();
  return e < edges ? e : member.cut.pieces[e - edges].edge;
}
const std::array<std::uint32_t, 2>& ends_of(const RefinedAxis& k, const Member& member, std::uint32_t e) {
  const std::size_t edges = k.complex.edges.size();
  return e < edges ? k.complex.edges[e] : member.cut.pieces[e - edges].ends;
}

// Calls visit(start, end, e) for an edge of K, or for all its pieces, from its end `from` on.
template <class Visit>
void walk(const RefinedAxis& k, const Member& member, std::uint32_t e, std::uint32_t from, const Visit& visit) {
  const auto [a, b] = k.complex.edges[e];
  if (member.edge[e] != Member::kInPart) return visit(from, from == a ? b : a, e);
  const SheetCut::Split& split = member.cut.split_of(e);
  for (std::uint32_t i = 0; i < split.count; ++i) {
    const std::uint32_t piece = split.first + (from == a ? i : split.count - 1 - i);
    const auto& ends = member.cut.pieces[piece].ends;
    visit(ends[from != a], ends[from == a], static_cast<std::uint32_t>(k.complex.edges.size()) + piece);
  }
}

// A side of what a member has of a face: where it starts, and its edge or piece; kNone for a cut.
struct Side {
  std::uint32_t start, edge;
};
void sides_of(const RefinedAxis& k, const Member& member, std::size_t f, std::vector<Side>& sides) {
  sides.clear();
  const auto corners = k.complex.corners(f);
  const auto edges = k.complex.sides(f);
  for (std::size_t i = 0; i < corners.size(); ++i)
    walk(k, member, edges[i], corners[i], [&](std::uint32_t start, std::uint32_t, std::uint32_t e) {
      sides.push_back({start, e});
    });
  if (member.face[f] != Member::kInPart) return;
  const SheetCut::Chord& chord = member.cut.chord_of(static_cast<std::uint32_t>(f));
  const auto at = [&](std::uint32_t v) {
    return std::find_if(sides.begin(), sides.end(), [&](const Side& side) { return side.start == v; });
  };
  std::rotate(sides.begin(), at(chord.in), sides.end());
  sides.erase(at(chord.out), sides.end());
  sides.push_back({chord.out, kNone});
}

// Kept are the vertices of M, nodes inside edges and doors where anything but whole polygons meets the edge or parts of
// the edge are missing, vertices without any edge, and where edges are cut.
void find_kept_vertices(const RefinedAxis& k, const Member& member, Outline& outline) {
  const CellComplex& c = k.complex;
  std::vector<char>& kept = outline.kept;
  kept.assign(member.vertex.size(), 0);
  std::vector<char> on_face(member.edge.size(), 0), has_edge(member.vertex.size(), 0);
  std::vector<Side> sides;
  for (std::size_t f = 0; f < c.face_count(); ++f) {
    if (!member.face[f]) continue;
    sides_of(k, member, f, sides);
    const bool whole = outline.whole[k.polygon_of[f]];
    for (const Side& side : sides) {
      if (side.edge != kNone) on_face[side.edge] = 1;
      if (!whole) kept[side.start] = 1;
    }
  }
  std::vector<std::uint32_t> halves(member.vertex.size(), 0);
  for (std::uint32_t e = 0; e < member.edge.size(); ++e) {
    if (member.edge[e] != Member::kWhole) continue;
    const std::uint32_t of = edge_in_k(k, member, e);
    for (const std::uint32_t v : ends_of(k, member, e)) {
      has_edge[v] = 1;
      halves[v] += is_half(k, of);
      if (is_half(k, of) ? !on_face[e] : !outline.inside_whole[of]) kept[v] = 1;
    }
  }
  for (std::uint32_t v = 0; v < kept.size(); ++v) {
    const bool stretch_ends = halves[v] > 0 && halves[v] != 2;
    const bool cut = v >= c.vertex_count && !outline.inside_whole[member.cut.points[v - c.vertex_count].edge];
    kept[v] = member.vertex[v] && (v < k.original || cut || kept[v] || stretch_ends || !has_edge[v]);
  }
}

bool has_area(const RefinedAxis& k, const Vec3& origin, std::span<const std::uint32_t> corners) {
  Vec3 area = Vec3::Zero();
  double size = 0;
  for (std::size_t i = 1; i < corners.size(); ++i) {
    const Vec3 b = k.points[corners[i]] - origin;
    size = std::max(size, b.squaredNorm());
    if (i > 1) area += (k.points[corners[i - 1]] - origin).cross(b);
  }
  return area.norm() > 1e-9 * size;
}

void draw_duals_at_doors(const RefinedAxis& k, const Member& member, Outline& outline) {
  std::vector<std::uint32_t>& drawn = outline.drawn;
  drawn.resize(member.vertex.size());
  std::iota(drawn.begin(), drawn.end(), 0u);
  // Region duals are written merged into their exit doors.
  const std::uint32_t first_dual = k.nodes + k.doors, duals_end = k.complex.vertex_count;
  for (std::uint32_t v = first_dual; v < duals_end; ++v)
    if (const std::uint32_t e = k.exit[v]; e != kNone && member.edge[e] == Member::kWhole && member.vertex[v])
      drawn[v] = other_end(k, e, v);
  // Duals of curves that never burn have no exit: inside such a curve they are drawn at the door that burns last on the
  // sheet, so that the curve does not zigzag between doors and the middles of polygons.
  std::vector<std::uint32_t> curves(drawn.size(), 0), door(drawn.size(), kNone);
  for (std::uint32_t e = 2 * k.doors; e < k.complex.edges.size(); ++e) {
    const auto [a, v] = k.complex.edges[e];
    if (!member.edge[e] || !k.curve_edge[e] || v < first_dual) continue;
    curves[v] += member.edge[e] == Member::kWhole ? 1 : 3;  // not where the spoke is cut
    if (door[v] == kNone || k.burn_time[a] > k.burn_time[door[v]]) door[v] = a;
  }
  for (std::uint32_t v = first_dual; v < duals_end; ++v)
    if (member.vertex[v] && drawn[v] == v && curves[v] == 2) drawn[v] = door[v];
  // But not where a part of a sheet would have no area: between doors of one side of its polygon.
  for (std::size_t f = 0; f < k.complex.face_count(); ++f) {
    if (!member.face[f] || outline.whole[k.polygon_of[f]]) continue;
    const auto corners = k.complex.corners(f);
    std::uint32_t& at = drawn[corners[0]];
    if (at != corners[0] && !has_area(k, k.points[at], corners)) at = corners[0];
  }
}

Outline outline_of(const RefinedAxis& k, const Member& member, bool parts) {
  Outline outline;
  find_whole_polygons(k, member, parts, outline);
  find_kept_vertices(k, member, outline);
  draw_duals_at_doors(k, member, outline);
  return outline;
}

// The cells of a skeleton, in which several edges may have the same ends.
struct Cells {
  struct Edge {
    std::array<std::uint32_t, 2> ends;
    double thickness, level;
    bool mesh;  // lies on an edge of M
  };
  struct Face {
    std::vector<std::uint32_t> corners, sides;
    double thickness, level;
  };
  std::vector<std::uint32_t> vertices;  // of K
  std::vector<Edge> edges;
  std::vector<Face> faces;
};

class CellBuilder {
 public:
  CellBuilder(const SkeletonFamily& family, const Member& member, const Outline& outline)
      : family_(family),
        k_(family.refined),
        member_(member),
        outline_(outline),
        number_(member.vertex.size(), kNone),
        edge_(member.edge.size(), kNone) {
    for (std::uint32_t v = 0; v < number_.size(); ++v)
      if (outline.kept[v]) number(v);
    add_halves();
    for (std::uint32_t e = 2 * k_.doors; e < edge_.size(); ++e) {
      const std::uint32_t of = edge_in_k(k_, member, e);
      if (member.edge[e] != Member::kWhole || is_half(k_, of) || outline.inside_whole[of]) continue;
      const std::uint32_t a = number(ends_of(k_, member, e)[0]), b = number(ends_of(k_, member, e)[1]);
      if (a != b) edge_[e] = add_edge(a, b, of, false);
    }
    add_faces();
  }
  Cells take() { return std::move(cells_); }

 private:
  std::uint32_t number(std::uint32_t v) {
    std::uint32_t& known = number_[outline_.drawn[v]];
    if (known == kNone) {
      known = static_cast<std::uint32_t>(cells_.vertices.size());
      cells_.vertices.push_back(outline_.drawn[v]);
    }
    return known;
  }
  std::uint32_t add_edge(std::uint32_t a, std::uint32_t b, std::uint32_t of, bool mesh) {
    const bool curve = of != kNone && k_.curve_edge[of];
    cells_.edges.push_back({{std::min(a, b), std::max(a, b)},
                            curve ? family_.thickness_of(of) : kNotACurve,
                            curve ? family_.level_of(of) : kNotACurve,
                            mesh});
    return static_cast<std::uint32_t>(cells_.edges.size() - 1);
  }

  // Halves come edge by edge of M, in order along it: they are joined between vertices that are written.
  void add_halves() {
    std::vector<std::uint32_t> stretch;
    std::uint32_t stretch_start = kNone;
    const auto step = [&](std::uint32_t start, std::uint32_t end, std::uint32_t e) {
      if (!member_.edge[e]) return;
      if (outline_.kept[start]) stretch_start = start;
      stretch.push_back(e);
      if (!outline_.kept[end]) return;
      const std::uint32_t written = add_edge(number(stretch_start), number(end), kNone, true);
      for (const std::uint32_t half : stretch) edge_[half] = written;
      stretch.clear();
    };
    // The first half of a segment runs from the node to the door, the second one from the door to the node.
    for (std::uint32_t e = 0; e < 2 * k_.doors; ++e)
      if (member_.edge[e]) walk(k_, member_, e, k_.complex.edges[e][e % 2], step);
  }

  void add_faces() {
    const std::size_t faces = k_.complex.face_count();
    for (std::size_t f = 0, end = 0; f < faces; f = end) {
      while (end < faces && k_.polygon_of[end] == k_.polygon_of[f]) ++end;
      if (outline_.whole[k_.polygon_of[f]]) {
        add_whole_polygon(f, end);
      } else {
        for (std::size_t part = f; part < end; ++part)
          if (member_.face[part]) add_part(part);
      }
    }
  }

  // The outline of a whole polygon: the sides of its parts that are not shared by two of them.
  void add_whole_polygon(std::size_t begin, std::size_t end) {
    Cells::Face face{{}, {}, 0, kNever};
    after_.clear();
    for (std::size_t f = begin; f < end; ++f) {
      face.thickness = std::max(face.thickness, k_.face_thickness[f]);
      face.level = std::min(face.level, family_.face_sheet_level[f]);
      const auto corners = k_.complex.corners(f);
      const auto sides = k_.complex.sides(f);
      for (std::size_t i = 0; i < corners.size(); ++i)
        if (is_half(k_, sides[i]))
          walk(k_, member_, sides[i], corners[i], [&](std::uint32_t start, std::uint32_t stop, std::uint32_t e) {
            after_.push_back({start, stop, e});
          });
    }
    std::sort(after_.begin(), after_.end());
    std::uint32_t at = after_.front()[0];
    for (std::size_t step = 0; step < after_.size(); ++step) {
      const auto [from, to, half] =
          *std::lower_bound(after_.begin(), after_.end(), std::array<std::uint32_t, 3>{at, 0, 0});
      if (outline_.kept[from]) {
        face.corners.push_back(number(from));
        face.sides.push_back(edge_[half]);
      }
      at = to;
    }
    cells_.faces.push_back(std::move(face));
  }

  void add_part(std::size_t f) {
    Cells::Face face{{}, {}, k_.face_thickness[f], family_.face_sheet_level[f]};
    sides_of(k_, member_, f, sides_);
    for (const Side& side : sides_) {
      if (side.edge == kNone) {
        face.corners.push_back(number(side.start));
        face.sides.push_back(add_edge(number(side.start), number(sides_.front().start), kNone, false));
      } else if (edge_[side.edge] != kNone) {  // else its ends are written as one vertex
        face.corners.push_back(number(side.start));
        face.sides.push_back(edge_[side.edge]);
      }
    }
    std::vector<std::uint32_t> sorted = face.corners;
    std::sort(sorted.begin(), sorted.end());
    if (std::adjacent_find(sorted.begin(), sorted.end()) == sorted.end()) {
      cells_.faces.push_back(std::move(face));
      return;
    }
    // A part that meets its spoke twice comes back to a corner: it is written as a fan around its first one, the dual.
    std::uint32_t before = face.sides.front();
    const std::size_t n = face.corners.size();
    for (std::size_t i = 1; i + 1 < n; ++i) {
      const std::uint32_t after =
          i + 2 == n ? face.sides.back() : add_edge(face.corners[0], face.corners[i + 1], kNone, false);
      cells_.faces.push_back({{face.corners[0], face.corners[i], face.corners[i + 1]},
                              {before, face.sides[i], after},
                              face.thickness,
                              face.level});
      before = after;
    }
  }

  const SkeletonFamily& family_;
  const RefinedAxis& k_;
  const Member& member_;
  const Outline& outline_;
  std::vector<std::uint32_t> number_;  // per vertex of K; kNone where it has none (yet)
  std::vector<std::uint32_t> edge_;    // per edge of K: the written edge it is, or is a stretch of
  Cells cells_;
  std::vector<std::array<std::uint32_t, 3>> after_;  // halves around a whole polygon: from, to, half
  std::vector<Side> sides_;
};

// Edges between the same two vertices become paths: all but one get a vertex in the middle, numbered from `first` on;
// kNone for edges without.
std::vector<std::uint32_t> middles(const std::vector<Cells::Edge>& edges, std::uint32_t first) {
  std::vector<std::uint32_t> order(edges.size()), middle(edges.size(), kNone);
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    if (edges[a].ends != edges[b].ends) return edges[a].ends < edges[b].ends;
    return edges[a].mesh != edges[b].mesh ? edges[a].mesh : a < b;
  });
  for (std::size_t i = 1; i < order.size(); ++i)
    if (edges[order[i]].ends == edges[order[i - 1]].ends) middle[order[i]] = first++;
  return middle;
}

void fill_vertices(const RefinedAxis& k, const Member& member, const Outline& outline, const Cells& cells,
                   const std::vector<std::uint32_t>& middle, Skeleton& out) {
  std::vector<std::array<std::uint32_t, 2>> halved;  // ends of the edges with a middle, by the middle
  for (std::size_t e = 0; e < middle.size(); ++e) {
    if (middle[e] == kNone) continue;
    const std::size_t row = middle[e] - cells.vertices.size();
    halved.resize(std::max(halved.size(), row + 1));
    halved[row] = cells.edges[e].ends;
  }
  const auto fill = [&](auto& values, const auto& of_k, const auto& between) {
    for (const std::uint32_t v : cells.vertices) {
      if (v < k.complex.vertex_count) {
        values.push_back(of_k[v]);
      } else {
        const SheetCut::Point& point = member.cut.points[v - k.complex.vertex_count];
        const auto [a, b] = k.complex.edges[point.edge];
        values.push_back(between(of_k[outline.drawn[a]], of_k[outline.drawn[b]], point.along));
      }
    }
    for (const auto& [a, b] : halved) values.push_back(between(values[a], values[b], 0.5));
  };
  const auto linear = [](double a, double b, double t) { return a == b ? a : (1 - t) * a + t * b; };
  fill(out.points, k.points, [](const Vec3& a, const Vec3& b, double t) -> Vec3 { return (1 - t) * a + t * b; });
  fill(out.radius, k.radius, linear);
  fill(out.burn_time, k.burn_time, linear);
  fill(out.curve_burn_time, k.curve_burn_time, linear);
  fill(out.on_curve, k.curve_vertex, [](char a, char b, double) { return a && b; });
}

// Faces that are joined over edges of exactly two, numbered in the order of their first faces.
std::vector<std::int32_t> sheets_of(const CellComplex& complex) {
  const auto faces = static_cast<std::uint32_t>(complex.face_count());
  std::vector<base::Cofaces> at(complex.edges.size(), base::Cofaces{});
  for (std::uint32_t f = 0; f < faces; ++f)
    for (const std::uint32_t e : complex.sides(f)) at[e].add(f);
  base::UnionFind sets(faces);
  for (std::uint32_t f = 0; f < faces; ++f)
    for (const std::uint32_t e : complex.sides(f)) {
      if (at[e].count() != 2) continue;
      base::Cofaces other = at[e];
      other.remove(f);
      sets.unite(f, other.only());
    }
  std::vector<std::int32_t> sheet(faces);
  std::int32_t next = 0;
  for (std::uint32_t f = 0; f < faces; ++f) sheet[f] = sets.find(f) == f ? next++ : sheet[sets.find(f)];
  return sheet;
}

Skeleton skeleton_of(const RefinedAxis& k, const Member& member, const Outline& outline, const Cells& cells) {
  Skeleton out;
  const std::vector<std::uint32_t> middle = middles(cells.edges, static_cast<std::uint32_t>(cells.vertices.size()));
  fill_vertices(k, member, outline, cells, middle, out);
  std::vector<std::array<std::uint32_t, 2>> edges;
  std::vector<std::uint32_t> of;  // per edge: the one of `cells` it is, or is a half of
  for (std::uint32_t e = 0; e < cells.edges.size(); ++e) {
    const auto [a, b] = cells.edges[e].ends;
    if (middle[e] == kNone) {
      edges.push_back({a, b});
    } else {
      edges.push_back({a, middle[e]});
      edges.push_back({b, middle[e]});
    }
    of.resize(edges.size(), e);
  }
  std::vector<std::uint32_t> offsets{0}, corners;
  for (const Cells::Face& face : cells.faces) {
    for (std::size_t i = 0; i < face.corners.size(); ++i) {
      corners.push_back(face.corners[i]);
      if (middle[face.sides[i]] != kNone) corners.push_back(middle[face.sides[i]]);
    }
    offsets.push_back(static_cast<std::uint32_t>(corners.size()));
    out.face_thickness.push_back(face.thickness);
    out.face_level.push_back(face.level);
  }
  out.complex =
      make_complex(static_cast<std::uint32_t>(out.points.size()), edges, std::move(offsets), std::move(corners));
  out.face_sheet = sheets_of(out.complex);
  const auto& sorted = out.complex.edges;
  out.edge_thickness.assign(sorted.size(), kNotACurve);
  out.edge_level.assign(sorted.size(), kNotACurve);
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const auto at = static_cast<std::size_t>(std::lower_bound(sorted.begin(), sorted.end(), edges[i]) - sorted.begin());
    out.edge_thickness[at] = cells.edges[of[i]].thickness;
    out.edge_level[at] = cells.edges[of[i]].level;
  }
  return out;
}

}  // namespace

Skeleton extract(const SkeletonFamily& family, double theta2, double theta1, const ExtractOptions& options) {
  for (const double value : {theta2, theta1, options.theta1_radii, options.regrow_tips_above, options.regrow_rims_above,
                             options.minor_curve})
    if (std::isnan(value))
      throw Error(ErrorCode::usage, "theta2, theta1 and the options of a skeleton must be numbers");
  if (std::min(theta2, options.regrow_rims_above) < family.theta2_floor ||
      std::min(theta1, options.regrow_tips_above) < family.theta1_floor)
    throw Error(ErrorCode::usage,
                "theta2, theta1 or from where a skeleton grows back is below the floor of its family");
  const RefinedAxis& k = family.refined;
  const Member member = skeleton::member_of(family, theta2, theta1, options);
  const Outline outline = outline_of(k, member, options.parts);
  Skeleton skeleton = skeleton_of(k, member, outline, CellBuilder(family, member, outline).take());
  skeleton.theta2 = theta2;
  skeleton.theta1 = theta1;
  skeleton.theta1_radii = options.theta1_radii;
  skeleton.full_tips = options.regrow_tips_above < kNever;
  return skeleton;
}

}  // namespace quench
