// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/constants.h"
#include "quench/error.h"
#include "quench/skeleton.h"
#include "quench/structure.h"
#include "skeleton/member.h"

namespace quench {
namespace {

using base::kNever;
using skeleton::edge_in_k;
using skeleton::ends_of;
using skeleton::Member;
using skeleton::other_end;
using skeleton::SheetCut;

constexpr double kNotACurve = std::numeric_limits<double>::quiet_NaN();

// How the cells of a member are written.
struct Outline {
  enum : char { kParts, kOne, kWhole };
  std::vector<char> polygon;         // per polygon of M: face by face, what is left as one face, or all of it
  std::vector<char> inside;          // per edge of the member: in the inside of what is written as one face
  std::vector<char> kept;            // per vertex of the member: written; halves of segments are joined where it is not
  std::vector<std::uint32_t> drawn;  // per vertex of the member: the one in whose place it is written
};

bool is_half(const RefinedAxis& k, std::uint32_t e) { return e < 2 * k.doors; }

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

// A side of what a member has of a face or of several: where it starts and ends, and its edge or piece; kNone for a
// cut.
struct Side {
  std::uint32_t start, end, edge;
};
void append_sides(const RefinedAxis& k, const Member& member, std::size_t f, std::vector<Side>& sides) {
  const auto corners = k.complex.corners(f);
  const auto edges = k.complex.sides(f);
  const auto first = static_cast<std::ptrdiff_t>(sides.size());
  for (std::size_t i = 0; i < corners.size(); ++i)
    walk(k, member, edges[i], corners[i], [&](std::uint32_t start, std::uint32_t end, std::uint32_t e) {
      sides.push_back({start, end, e});
    });
  if (member.face[f] != Member::kInPart) return;
  const SheetCut::Chord& chord = member.cut.chord_of(static_cast<std::uint32_t>(f));
  const auto at = [&](std::uint32_t v) {
    return std::find_if(sides.begin() + first, sides.end(), [&](const Side& side) { return side.start == v; });
  };
  std::rotate(sides.begin() + first, at(chord.in), sides.end());
  sides.erase(at(chord.out), sides.end());
  sides.push_back({chord.out, chord.in, kNone});
}

// The faces of one polygon.
struct Parts {
  std::size_t begin, end;
  std::uint32_t polygon;
};
template <class Visit>
void each_polygon(const RefinedAxis& k, const Visit& visit) {
  const std::size_t faces = k.polygon_of.size();
  for (std::size_t f = 0, end = 0; f < faces; f = end) {
    while (end < faces && k.polygon_of[end] == k.polygon_of[f]) ++end;
    visit(Parts{f, end, k.polygon_of[f]});
  }
}

// The sides around all that a member has of a polygon, in order; false where they are not one loop without a vertex
// that is passed twice.
bool loop_around(const RefinedAxis& k, const Member& member, const Parts& parts, bool whole, std::vector<Side>& sides) {
  sides.clear();
  for (std::size_t f = parts.begin; f < parts.end; ++f)
    if (member.face[f]) append_sides(k, member, f, sides);
  if (whole) std::erase_if(sides, [&](const Side& side) { return !is_half(k, edge_in_k(k, member, side.edge)); });
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) { return a.edge < b.edge; });
  std::size_t count = 0;
  for (std::size_t i = 0, next = 0; i < sides.size(); i = next) {
    while (next < sides.size() && sides[next].edge == sides[i].edge) ++next;
    if (sides[i].edge == kNone)
      for (std::size_t j = i; j < next; ++j) sides[count++] = sides[j];
    else if (next - i == 1)
      sides[count++] = sides[i];
  }
  sides.resize(count);
  // Each side is looked up by its start, and goes to its place in the loop.
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) { return a.start < b.start; });
  for (std::size_t i = 1; i < count; ++i)
    if (sides[i].start == sides[i - 1].start) return false;
  std::vector<Side> loop;
  loop.reserve(count);
  for (std::uint32_t at = sides.empty() ? kNone : sides.front().start; loop.size() < count;) {
    const auto side = std::lower_bound(sides.begin(), sides.end(), at,
                                       [](const Side& a, std::uint32_t start) { return a.start < start; });
    if (side == sides.end() || side->start != at || (!loop.empty() && at == loop.front().start)) return false;
    loop.push_back(*side);
    at = side->end;
  }
  sides.swap(loop);
  return count > 2 && sides.back().end == sides.front().start;
}

// Whether a loop passes no vertex twice as it is drawn, and at least three.
bool is_simple_as_drawn(const std::vector<Side>& loop, const std::vector<std::uint32_t>& drawn) {
  std::vector<std::uint32_t> places;
  for (const Side& side : loop)
    if (drawn[side.start] != drawn[side.end]) places.push_back(drawn[side.start]);
  std::sort(places.begin(), places.end());
  return places.size() > 2 && std::adjacent_find(places.begin(), places.end()) == places.end();
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

// Kept are the vertices of M, nodes inside edges and doors where anything but polygons of one face meets the edge,
// where such a face leaves it, or where parts of the edge are missing, and vertices without any edge.
class OutlineFinder {
 public:
  OutlineFinder(const RefinedAxis& k, const Member& member) : k_(k), member_(member) {}

  Outline run(bool parts) {
    find_whole_polygons(parts);
    draw_duals_at_doors();
    if (!parts) find_polygons_of_one_face();
    find_kept_vertices();
    return std::move(outline_);
  }

 private:
  void find_whole_polygons(bool parts) {
    const std::uint32_t polygons =
        k_.polygon_of.empty() ? 0 : *std::max_element(k_.polygon_of.begin(), k_.polygon_of.end()) + 1;
    outline_.polygon.assign(polygons, parts ? Outline::kParts : Outline::kWhole);
    for (const std::uint32_t polygon : k_.incomplete)
      if (polygon < polygons) outline_.polygon[polygon] = Outline::kParts;
    for (std::size_t f = 0; f < k_.polygon_of.size(); ++f)
      if (member_.face[f] != Member::kWhole) outline_.polygon[k_.polygon_of[f]] = Outline::kParts;
  }

  void find_polygons_of_one_face() {
    each_polygon(k_, [&](const Parts& parts) {
      char& polygon = outline_.polygon[parts.polygon];
      if (polygon == Outline::kParts && loop_around(k_, member_, parts, false, sides_) &&
          is_simple_as_drawn(sides_, outline_.drawn))
        polygon = Outline::kOne;
    });
  }

  void find_kept_vertices() {
    std::vector<char>& kept = outline_.kept;
    kept.assign(member_.vertex.size(), 0);
    outline_.inside.assign(member_.edge.size(), 0);
    std::vector<char> on_face(member_.edge.size(), 0), has_edge(member_.vertex.size(), 0);
    each_polygon(k_, [&](const Parts& parts) {
      const char polygon = outline_.polygon[parts.polygon];
      sides_.clear();
      for (std::size_t f = parts.begin; f < parts.end; ++f)
        if (member_.face[f]) append_sides(k_, member_, f, sides_);
      for (const Side& side : sides_) {
        if (side.edge != kNone) on_face[side.edge] = 1;
        if (polygon == Outline::kParts)
          kept[side.start] = 1;
        else if (side.edge != kNone && !is_half(k_, edge_in_k(k_, member_, side.edge)))
          outline_.inside[side.edge] = 1;
      }
      if (polygon != Outline::kOne) return;
      loop_around(k_, member_, parts, false, sides_);
      for (const Side& side : sides_) {
        if (side.edge != kNone && is_half(k_, edge_in_k(k_, member_, side.edge))) continue;
        kept[side.start] = kept[side.end] = 1;
        if (side.edge != kNone) outline_.inside[side.edge] = 0;
      }
    });
    std::vector<std::uint32_t> halves(member_.vertex.size(), 0);
    for (std::uint32_t e = 0; e < member_.edge.size(); ++e) {
      if (member_.edge[e] != Member::kWhole) continue;
      const bool half = is_half(k_, edge_in_k(k_, member_, e));
      for (const std::uint32_t v : ends_of(k_, member_, e)) {
        has_edge[v] = 1;
        halves[v] += half;
        if (half ? !on_face[e] : !outline_.inside[e]) kept[v] = 1;
      }
    }
    for (std::uint32_t v = 0; v < kept.size(); ++v) {
      const bool stretch_ends = halves[v] > 0 && halves[v] != 2;
      kept[v] = member_.vertex[v] && (v < k_.original || kept[v] || stretch_ends || !has_edge[v]);
    }
  }

  void draw_duals_at_doors() {
    const RefinedAxis& k = k_;
    const Member& member = member_;
    std::vector<std::uint32_t>& drawn = outline_.drawn;
    drawn.resize(member.vertex.size());
    std::iota(drawn.begin(), drawn.end(), 0u);
    // Region duals are written merged into their exit doors.
    const std::uint32_t first_dual = k.nodes + k.doors, duals_end = k.complex.vertex_count;
    for (std::uint32_t v = first_dual; v < duals_end; ++v)
      if (const std::uint32_t e = k.exit[v]; e != kNone && member.edge[e] == Member::kWhole && member.vertex[v])
        drawn[v] = other_end(k, e, v);
    // Duals of curves that never burn have no exit: inside such a curve they are drawn at the door that burns last on
    // the sheet, so that the curve does not zigzag between doors and the middles of polygons.
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
      if (!member.face[f] || outline_.polygon[k.polygon_of[f]] == Outline::kWhole) continue;
      const auto corners = k.complex.corners(f);
      std::uint32_t& at = drawn[corners[0]];
      if (at != corners[0] && !has_area(k, k.points[at], corners)) at = corners[0];
    }
  }

  const RefinedAxis& k_;
  const Member& member_;
  Outline outline_;
  std::vector<Side> sides_;
};

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
      if (member.edge[e] != Member::kWhole || is_half(k_, of) || outline.inside[e]) continue;
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
    each_polygon(k_, [&](const Parts& parts) {
      const char polygon = outline_.polygon[parts.polygon];
      if (polygon == Outline::kParts) {
        for (std::size_t part = parts.begin; part < parts.end; ++part)
          if (member_.face[part]) add_part(part);
      } else if (polygon == Outline::kOne || member_.face[parts.begin]) {
        add_polygon(parts);
      }
    });
  }

  // What is left of a polygon, as one face.
  void add_polygon(const Parts& parts) {
    Cells::Face face{{}, {}, 0, kNever};
    for (std::size_t f = parts.begin; f < parts.end; ++f) {
      if (!member_.face[f]) continue;
      face.thickness = std::max(face.thickness, k_.face_thickness[f]);
      face.level = std::min(face.level, family_.face_sheet_level[f]);
    }
    loop_around(k_, member_, parts, outline_.polygon[parts.polygon] == Outline::kWhole, sides_);
    add_corners(face);
    cells_.faces.push_back(std::move(face));
  }

  // The corners and sides of a face from `sides_`.
  void add_corners(Cells::Face& face) {
    for (const Side& side : sides_) {
      if (!outline_.kept[side.start]) continue;
      if (side.edge == kNone) {
        face.corners.push_back(number(side.start));
        face.sides.push_back(add_edge(number(side.start), number(side.end), kNone, false));
      } else if (edge_[side.edge] != kNone) {  // else its ends are written as one vertex
        face.corners.push_back(number(side.start));
        face.sides.push_back(edge_[side.edge]);
      }
    }
  }

  void add_part(std::size_t f) {
    Cells::Face face{{}, {}, k_.face_thickness[f], family_.face_sheet_level[f]};
    sides_.clear();
    append_sides(k_, member_, f, sides_);
    add_corners(face);
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
  std::vector<Side> sides_;
};

// Edges between the same two vertices become paths: all but one get a vertex on the way, numbered from `first` on,
// those of the same two one after the other; kNone for edges without.
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
  struct OnTheWay {
    std::array<std::uint32_t, 2> ends;
    double along;
  };
  std::vector<OnTheWay> halved;  // by the middle
  for (std::size_t e = 0; e < middle.size(); ++e) {
    if (middle[e] == kNone) continue;
    const std::size_t row = middle[e] - cells.vertices.size();
    halved.resize(std::max(halved.size(), row + 1));
    halved[row].ends = cells.edges[e].ends;
  }
  for (std::size_t i = 0, next = 0; i < halved.size(); i = next) {
    while (next < halved.size() && halved[next].ends == halved[i].ends) ++next;
    for (std::size_t j = i; j < next; ++j)
      halved[j].along = static_cast<double>(j - i + 1) / static_cast<double>(next - i + 1);
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
    for (const auto& [ends, along] : halved) values.push_back(between(values[ends[0]], values[ends[1]], along));
  };
  // Only what burns is cut, up to where it meets what does not.
  const auto linear = [](double a, double b, double t) {
    if (std::isinf(a) || std::isinf(b)) return std::min(a, b);
    return (1 - t) * a + t * b;
  };
  fill(out.points, k.points, [](const Vec3& a, const Vec3& b, double t) -> Vec3 { return (1 - t) * a + t * b; });
  fill(out.radius, k.radius, linear);
  for (std::size_t i = 0; i < cells.vertices.size(); ++i) {
    if (cells.vertices[i] < k.complex.vertex_count) continue;
    const SheetCut::Point& point = member.cut.points[cells.vertices[i] - k.complex.vertex_count];
    const std::uint32_t a = outline.drawn[k.complex.edges[point.edge][0]],
                        b = outline.drawn[k.complex.edges[point.edge][1]];
    out.radius[i] =
        radius_inside_edge(k.radius[a], k.radius[b], (k.points[a] - k.points[b]).norm(), point.along, k.radius_rule);
  }
  fill(out.burn_time, k.burn_time, linear);
  // What runs from pocket to pocket inside a polygon is on none; edges of pockets have no middles.
  for (std::size_t v = 0; v < out.burn_time.size(); ++v) {
    if (!std::isinf(out.burn_time[v])) continue;
    const std::uint32_t of = v < cells.vertices.size() ? cells.vertices[v] : kNone;
    const bool cut_inside =
        of != kNone && of >= k.complex.vertex_count && !is_half(k, member.cut.points[of - k.complex.vertex_count].edge);
    if (of == kNone || cut_inside) out.burn_time[v] = out.radius[v];
  }
  fill(out.curve_burn_time, k.curve_burn_time, linear);
  if (!k.mgf.empty()) fill(out.mgf, k.mgf, linear);
  fill(out.on_curve, k.curve_vertex, [](char a, char b, double) { return a && b; });
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
  out.face_sheet = structure_of(out.complex).face_sheet;
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
                             options.minor_curve, options.balls_above})
    if (std::isnan(value))
      throw Error(ErrorCode::usage,
                  "theta2, theta1, theta1_radii, minor_curve, balls_above and from where tips and rims of a skeleton "
                  "grow back must be numbers");
  if (std::min(theta2, options.regrow_rims_above) < family.theta2_floor ||
      std::min({theta1, options.regrow_tips_above, options.theta1_radii > 0 ? options.balls_above : theta1}) <
          family.theta1_floor)
    throw Error(ErrorCode::usage,
                "theta2, theta1, from where a skeleton grows back or from where balls count is below the floor of its "
                "family");
  const RefinedAxis& k = family.refined;
  const Member member = skeleton::member_of(family, theta2, theta1, options);
  const Outline outline = OutlineFinder(k, member).run(options.parts);
  Skeleton skeleton = skeleton_of(k, member, outline, CellBuilder(family, member, outline).take());
  skeleton.theta2 = theta2;
  skeleton.theta1 = theta1;
  skeleton.theta1_radii = options.theta1_radii;
  skeleton.full_tips = options.regrow_tips_above < kNever;
  skeleton.plane = k.plane;
  skeleton.rims_above = options.regrow_rims_above;
  return skeleton;
}

}  // namespace quench
