// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/csr.h"
#include "base/parallel.h"
#include "base/union_find.h"
#include "burning/curve_fire.h"
#include "burning/polygon_view.h"
#include "quench/error.h"
#include "quench/skeleton.h"

namespace quench {
namespace {

using namespace burning;

class Refinement {
 public:
  Refinement(const BurnDomain& domain, const Burning& burning)
      : domain_(domain), burning_(*burning.sectors), net_(domain.network) {
    out_.burn_time = burning.burn_time;
  }

  RefinedAxis run(Context* context) {
    place_nodes();
    place_doors();
    keep_nodes();
    count_primes();
    for (std::uint32_t f = 0; f < domain_.complex.face_count(); ++f) {
      if (f % 4096 == 0) checkpoint(context, "curves", 0.6 * f / static_cast<double>(domain_.complex.face_count()));
      cut(f);
    }
    out_.complex.vertex_count = static_cast<std::uint32_t>(out_.points.size());
    return std::move(out_);
  }

 private:
  std::uint32_t door_of(const Polygons::Side& side, std::uint32_t k) const {  // of the segment from node k to k + 1
    return out_.nodes + door_base_[side.edge] + (side.forward ? k : side.pieces - 1 - k);
  }
  std::uint32_t add_edge(std::uint32_t a, std::uint32_t b, bool curve) {
    out_.complex.edges.push_back({std::min(a, b), std::max(a, b)});
    out_.curve_edge.push_back(curve);
    if (curve) out_.curve_vertex[a] = out_.curve_vertex[b] = 1;
    return static_cast<std::uint32_t>(out_.complex.edges.size() - 1);
  }

  void place_nodes() {
    const CellComplex& m = domain_.complex;
    out_.original = m.vertex_count;
    out_.nodes = net_.node_count();
    out_.points.assign(domain_.points.begin(), domain_.points.end());
    out_.radius.assign(domain_.radius.begin(), domain_.radius.end());
    for (std::uint32_t e = 0; e < m.edges.size(); ++e)
      for (std::uint32_t i = 1; i < net_.pieces[e]; ++i) {
        out_.points.push_back(on_edge(e, static_cast<double>(i) / net_.pieces[e]));
        out_.radius.push_back(domain_.radius_inside(e, i));
        const std::uint32_t sectors = net_.sectors_of(e), first = net_.state_base[e] + (i - 1) * sectors;
        double time = out_.radius.back();
        for (std::uint32_t s = first; s < first + sectors; ++s) time = std::max(time, burning_.state_time[s]);
        out_.burn_time.push_back(time);
      }
  }
  Vec3 on_edge(std::uint32_t e, double t) const {
    const auto [a, b] = domain_.complex.edges[e];
    return domain_.points[a] * (1 - t) + domain_.points[b] * t;
  }

  // Doors halve the segments of all edges that polygons have. Halves come first among the edges of K: 2d and 2d + 1 are
  // those of door d.
  void place_doors() {
    const CellComplex& m = domain_.complex;
    door_base_.assign(m.edges.size() + 1, 0);
    std::uint64_t doors = 0;
    for (std::uint32_t e = 0; e < m.edges.size(); ++e) {
      door_base_[e] = static_cast<std::uint32_t>(doors);
      if (net_.degree(e) > 0) doors += net_.pieces[e];
    }
    // There are fewer regions, and so fewer of all other cells, than four per node on the boundaries of all polygons.
    std::uint64_t most = out_.nodes + doors;
    for (const std::uint32_t e : m.face_edges) most += 4 * std::uint64_t{net_.pieces[e]};
    if (most >= kNone)
      throw Error(ErrorCode::failed,
                  "the medial curves of this axis have more than 2^32 parts; use a larger omega or "
                  "lambda");
    out_.doors = static_cast<std::uint32_t>(doors);
    door_base_.back() = out_.doors;
    const std::size_t vertices = out_.nodes + doors;
    out_.points.reserve(vertices);
    out_.complex.edges.reserve(2 * doors);
    for (std::uint32_t e = 0; e < m.edges.size(); ++e) {
      const auto sides = net_.face_corners_at(e);
      if (sides.empty()) continue;
      const auto [a, b] = m.edges[e];
      for (std::uint32_t j = 0; j < net_.pieces[e]; ++j) {
        const double t = (j + 0.5) / net_.pieces[e];
        const auto door = static_cast<std::uint32_t>(out_.points.size());
        out_.points.push_back(on_edge(e, t));
        out_.radius.push_back(
            radius_inside_edge(domain_.radius[a], domain_.radius[b], net_.length[e], t, domain_.rule));
        out_.burn_time.push_back(door_time(sides, j));
        const std::uint32_t before = j == 0 ? a : net_.node_base[e] + j - 1;
        const std::uint32_t behind = j + 1 == net_.pieces[e] ? b : net_.node_base[e] + j;
        out_.complex.edges.push_back({before, door});
        out_.complex.edges.push_back({behind, door});
      }
    }
    out_.curve_edge.assign(out_.complex.edges.size(), 0);
    out_.curve_vertex.assign(vertices, 0);
  }
  // The second largest over the polygons of the mean time of the segment's nodes in the polygon's sector: the last
  // sheet burns together with the last but one. The radius on a rim, infinite on a pocket.
  double door_time(std::span<const std::uint32_t> sides, std::uint32_t j) {
    if (sides.size() == 1) return out_.radius.back();
    times_.clear();
    for (const std::uint32_t c : sides) {
      const std::uint32_t f = net_.corner_face[c];
      if (net_.pocket[f]) return kNever;
      const PolygonView view(domain_, f);
      const std::uint32_t i = c - domain_.complex.face_offsets[f];
      const Polygons::Side& side = view.side(i);
      const std::uint32_t k = side.forward ? j : side.pieces - 1 - j;
      times_.push_back(0.5 * (burning_.state_time[view.state(i, k)] + burning_.state_time[view.state(i, k + 1)]));
    }
    std::nth_element(times_.begin(), times_.end() - 2, times_.end());
    return times_[times_.size() - 2];
  }

  // A vertex that splits its link is kept, with an edge to one region of every component without pocket: a region in
  // the sector that burned last there. Lone edges and isolated vertices are part of the curves as they are.
  void keep_nodes() {
    const CellComplex& m = domain_.complex;
    std::vector<std::uint32_t> lone(m.vertex_count, 0);
    for (std::uint32_t e = 0; e < m.edges.size(); ++e)
      if (net_.face_corners_at(e).empty()) {
        for (const std::uint32_t v : m.edges[e]) ++lone[v];
        add_edge(m.edges[e][0], m.edges[e][1], true);
      }
    std::vector<std::pair<std::uint32_t, std::uint32_t>> kept;  // polygon, vertex
    for (std::uint32_t v = 0; v < m.vertex_count; ++v) {
      if (net_.vertex_base[v + 1] - net_.vertex_base[v] == 1 && lone[v] == 0) {  // nearly all of them
        check_primes(v, 1);
        continue;
      }
      const LinkParts link = parts_of_link(v);
      const std::size_t parts = link.last.size() + link.pocket;
      check_primes(v, parts);
      if (parts + lone[v] == 0) out_.curve_vertex[v] = 1;
      if (parts + lone[v] <= 1) continue;
      for (const std::uint32_t state : link.last) kept.push_back({domain_.face_of(state), v});
    }
    kept_ = base::Csr<std::uint32_t>::group(m.face_count(), [&](const auto& emit) {
      for (const auto& [f, v] : kept) emit(f, v);
    });
  }
  // The components of the link of a vertex. All pockets are in one.
  struct LinkParts {
    std::vector<std::uint32_t> last;  // per component without pocket: the state that left the link last
    bool pocket = false;
  };
  LinkParts parts_of_link(std::uint32_t v) const {
    LinkParts parts;
    const std::uint32_t first = net_.vertex_base[v], count = net_.vertex_base[v + 1] - first;
    // Sectors are joined by singular directions, pockets by direction 0.
    std::uint32_t directions = 1;
    for (std::uint32_t s = first; s < first + count; ++s)
      if (domain_.links.ends[s].a != kNone)
        directions = std::max({directions, domain_.links.ends[s].a + 1, domain_.links.ends[s].b + 1});
    base::UnionFind sets(directions + count);
    for (std::uint32_t s = 0; s < count; ++s) {
      const auto [a, b] = domain_.links.ends[first + s];
      if (domain_.in_pocket(first + s)) {
        parts.pocket = true;
        sets.unite(0, directions + s);
      }
      if (a == kNone) continue;
      sets.unite(a, directions + s);
      sets.unite(b, directions + s);
    }
    std::vector<std::uint32_t> set_of;  // per component in `parts.last`
    for (std::uint32_t s = 0; s < count; ++s) {
      const std::uint32_t set = sets.find(directions + s);
      if (parts.pocket && set == sets.find(0)) continue;
      const auto at = static_cast<std::size_t>(std::find(set_of.begin(), set_of.end(), set) - set_of.begin());
      if (at == set_of.size()) {
        set_of.push_back(set);
        parts.last.push_back(first + s);
      } else if (burning_.rank[first + s] > burning_.rank[parts.last[at]]) {
        parts.last[at] = first + s;
      }
    }
    return parts;
  }
  // A vertex has as many prime arcs as its link has independent cycles, with pockets contracted: otherwise the curves
  // would have another topology than the axis.
  void check_primes(std::uint32_t v, std::size_t components) const {
    std::int64_t primes = 0, cycles = static_cast<std::int64_t>(components);
    std::vector<std::uint32_t> met;
    for (std::uint32_t s = net_.vertex_base[v]; s < net_.vertex_base[v + 1]; ++s) {
      primes += burning_.parent[s] != kNone;
      const auto [a, b] = domain_.links.ends[s];
      if (domain_.in_pocket(s)) {
        met.push_back(0);
        continue;
      }
      if (a == kNone) continue;
      cycles += 1;
      met.push_back(a);
      met.push_back(b);
    }
    std::sort(met.begin(), met.end());
    cycles -= std::unique(met.begin(), met.end()) - met.begin();
    if (primes != cycles)
      throw Error(ErrorCode::invariant,
                  fmt::format("vertex {} of the medial axis has {} prime arcs, but its link has {} independent cycles; "
                              "this is a bug in Quench, please report it with the input",
                              v, primes, cycles));
  }

  // Counts the prime arcs of every polygon, and reserves what cutting it along them takes.
  void count_primes() {
    const std::size_t faces = domain_.complex.face_count();
    primes_.assign(faces, 0);
    for (const std::uint32_t f : burning_.parent_face)
      if (f != kNone) ++primes_[f];
    // Nearly exact bounds of what comes, so that no array is copied while it grows.
    std::size_t segments = kept_.items().size();
    for (const std::uint32_t e : domain_.complex.face_edges) segments += net_.pieces[e];
    const auto chords = std::accumulate(primes_.begin(), primes_.end(), std::size_t{0});
    const std::size_t regions = chords + faces;
    out_.points.reserve(out_.points.size() + regions);
    out_.radius.reserve(out_.points.capacity());
    out_.burn_time.reserve(out_.points.capacity());
    out_.curve_vertex.reserve(out_.points.capacity());
    out_.complex.edges.reserve(out_.complex.edges.size() + segments + chords);
    out_.curve_edge.reserve(out_.complex.edges.capacity());
    out_.complex.face_offsets.reserve(segments + 1);
    out_.polygon_of.reserve(segments);
    out_.face_thickness.reserve(segments);
    out_.complex.face_vertices.reserve(4 * segments + 2 * chords);
    out_.complex.face_edges.reserve(4 * segments + 2 * chords);
  }

  struct Chord {
    std::uint32_t from, to, edge;  // places on the polygon's boundary, from < to; edge of K
  };
  struct Arc {
    bool segment;
    std::uint32_t index;  // of a segment the place of its first node, else that of the chord
  };
  struct Region {
    std::vector<std::uint32_t> places;  // nodes of its boundary in order
    std::vector<Arc> arcs;              // arcs[i] leads from places[i] on
    std::uint32_t chord = kNone;        // the chord that closes the region; kNone for the outermost
  };
  // From the region dual to a node of the region's boundary, or to the door of the arc that leads on from it.
  struct Spoke {
    std::uint32_t place, edge;  // index into `places` and `arcs` of the region; edge of K
    bool to_door;
  };

  // Cuts a polygon along its prime arcs into regions, and each region along its spokes.
  void cut(std::uint32_t f) {
    if (net_.pocket[f]) return whole_pocket(f);
    const PolygonView view(domain_, f);
    node_.clear();
    state_.clear();
    door_.clear();
    for (std::uint32_t i = 0; i < view.side_count(); ++i)
      for (std::uint32_t k = 0; k < view.side(i).pieces; ++k) {
        node_.push_back(view.node(i, k));
        state_.push_back(view.state(i, k));
        door_.push_back(door_of(view.side(i), k));
      }
    const auto n = static_cast<std::uint32_t>(node_.size());
    prime_segment_.assign(n, 0);
    chords_.clear();
    std::uint32_t left = primes_[f];
    for (std::uint32_t p = 0; p < n && left > 0; ++p) {
      if (burning_.parent_face[state_[p]] != f) continue;
      --left;
      const std::uint32_t parent = burning_.parent[state_[p]];
      const auto q = static_cast<std::uint32_t>(std::find(node_.begin(), node_.end(), parent) - node_.begin());
      if (q == (p + 1) % n) {
        prime_segment_[p] = 1;
      } else if (p == (q + 1) % n) {
        prime_segment_[q] = 1;
      } else {
        chords_.push_back({std::min(p, q), std::max(p, q), 0});
      }
    }
    for (Chord& c : chords_) c.edge = add_edge(node_[c.from], node_[c.to], false);
    std::sort(chords_.begin(), chords_.end(),
              [](const Chord& a, const Chord& b) { return a.from != b.from ? a.from < b.from : a.to > b.to; });
    kept_here_.assign(kept_[f].begin(), kept_[f].end());
    open(kNone);
    std::size_t next = 0;
    for (std::uint32_t p = 0; p < n; ++p) {
      while (depth_ > 1 && chords_[top().chord].to == p) {
        const std::uint32_t c = top().chord;
        top().places.push_back(p);
        top().arcs.push_back({false, c});
        divide(f);
        --depth_;
        top().arcs.push_back({false, c});
      }
      top().places.push_back(p);
      for (; next < chords_.size() && chords_[next].from == p; ++next) {
        open(static_cast<std::uint32_t>(next));
        top().places.push_back(p);
      }
      top().arcs.push_back({true, p});
    }
    divide(f);
    depth_ = 0;
  }
  Region& top() { return stack_[depth_ - 1]; }
  void open(std::uint32_t chord) {
    if (stack_.size() == depth_) stack_.emplace_back();
    Region& r = stack_[depth_++];
    r.places.clear();
    r.arcs.clear();
    r.chord = chord;
  }

  // The region on top: its dual, spokes, and the polygons between them.
  void divide(std::uint32_t f) {
    const Region& region = top();
    const std::size_t m = region.places.size();
    const auto dual = static_cast<std::uint32_t>(out_.points.size());
    Vec3 centre = Vec3::Zero();
    double time = 0, squares = 0, radius = 0;
    for (const std::uint32_t p : region.places) centre += out_.points[node_[p]];
    centre /= static_cast<double>(m);
    for (const std::uint32_t p : region.places) {
      const std::uint32_t node = node_[p];
      time += burning_.state_time[state_[p]];
      radius += out_.radius[node];
      squares += out_.radius[node] * out_.radius[node] - (out_.points[node] - centre).squaredNorm();
    }
    // The squared distance to a shared nearest point is the mean of those of the nodes minus their variance.
    radius = domain_.rule == RadiusRule::exact ? std::sqrt(std::max(0.0, squares / static_cast<double>(m)))
                                               : radius / static_cast<double>(m);
    out_.points.push_back(centre);
    out_.radius.push_back(radius);
    out_.burn_time.push_back(time / static_cast<double>(m));
    out_.curve_vertex.push_back(1);

    spokes_.clear();
    for (std::uint32_t i = 0; i < m; ++i) {
      const auto kept = std::find(kept_here_.begin(), kept_here_.end(), node_[region.places[i]]);
      if (kept != kept_here_.end()) {
        spokes_.push_back({i, add_edge(node_[region.places[i]], dual, true), false});
        kept_here_.erase(kept);
      }
      if (region.arcs[i].segment && !prime_segment_[region.arcs[i].index])
        spokes_.push_back({i, add_edge(door_[region.arcs[i].index], dual, true), true});
    }
    if (spokes_.empty())
      throw Error(ErrorCode::invariant,
                  "prime arcs run all around a region of the medial axis; this is a bug in Quench, "
                  "please report it with the input");
    for (std::size_t s = 0; s < spokes_.size(); ++s)
      add_face(f, region, dual, spokes_[s], spokes_[(s + 1) % spokes_.size()]);
  }

  double thickness(std::uint32_t v, double time) const { return std::max(0.0, time - out_.radius[v]); }

  // The polygon between two neighbouring spokes of a region; they may be the same one, all around the region.

  void add_face(std::uint32_t f, const Region& region, std::uint32_t dual, const Spoke& from, const Spoke& to) {
    CellComplex& k = out_.complex;
    const std::size_t m = region.places.size();
    double thick = thickness(dual, out_.burn_time[dual]);
    const auto corner = [&](std::uint32_t v, std::uint32_t side) {
      k.face_vertices.push_back(v);
      k.face_edges.push_back(side);
    };
    const auto half = [&](std::uint32_t p, bool second) {  // of the segment from place p on
      const std::uint32_t door = door_[p] - out_.nodes;
      return 2 * door + ((k.edges[2 * door][0] == node_[p]) == second);
    };
    const auto door_thickness = [&](std::uint32_t p) {
      const std::uint32_t q = p + 1 == node_.size() ? 0 : p + 1;
      thick =
          std::max(thick, thickness(door_[p], 0.5 * (burning_.state_time[state_[p]] + burning_.state_time[state_[q]])));
    };
    corner(dual, from.edge);
    std::size_t i = from.place;
    if (from.to_door) {
      const std::uint32_t p = region.arcs[i].index;
      corner(door_[p], half(p, true));
      door_thickness(p);
      i = i + 1 == m ? 0 : i + 1;
    }
    // The node that `from` goes to is passed, not reached, where the walk starts.
    for (bool at_start = !from.to_door;; at_start = false) {
      const std::uint32_t p = region.places[i], node = node_[p];
      thick = std::max(thick, thickness(node, burning_.state_time[state_[p]]));
      if (i == to.place && !to.to_door && !at_start) {
        corner(node, to.edge);
        break;
      }
      const Arc& arc = region.arcs[i];
      if (!arc.segment) {
        corner(node, chords_[arc.index].edge);
      } else {
        corner(node, half(arc.index, false));
        door_thickness(arc.index);
        if (i == to.place && to.to_door) {
          corner(door_[arc.index], to.edge);
          break;
        }
        corner(door_[arc.index], half(arc.index, true));
      }
      i = i + 1 == m ? 0 : i + 1;
    }
    finish_face(f, thick);
  }
  void finish_face(std::uint32_t f, double thick) {
    out_.complex.face_offsets.push_back(static_cast<std::uint32_t>(out_.complex.face_vertices.size()));
    out_.polygon_of.push_back(f);
    out_.face_thickness.push_back(thick);
  }

  // A polygon of a pocket stays whole; the nodes and doors of its edges are its corners.
  void whole_pocket(std::uint32_t f) {
    const PolygonView view(domain_, f);
    for (std::uint32_t i = 0; i < view.side_count(); ++i)
      for (std::uint32_t k = 0; k < view.side(i).pieces; ++k) {
        const std::uint32_t door = door_of(view.side(i), k), node = view.node(i, k), first = 2 * (door - out_.nodes);
        const bool in_order = out_.complex.edges[first][0] == node;
        out_.complex.face_vertices.insert(out_.complex.face_vertices.end(), {node, door});
        out_.complex.face_edges.insert(out_.complex.face_edges.end(), {first + !in_order, first + in_order});
      }
    finish_face(f, kNever);
  }

  const BurnDomain& domain_;
  const BurnedSectors& burning_;
  const BurnNetwork& net_;
  RefinedAxis out_;
  std::vector<std::uint32_t> door_base_;
  std::vector<double> times_;
  base::Csr<std::uint32_t> kept_;      // per polygon: vertices with a spoke in it
  std::vector<std::uint32_t> primes_;  // per polygon: prime arcs in it
  // Of the polygon being cut: nodes, states and doors by place, chords, regions.
  std::vector<std::uint32_t> node_, state_, door_, kept_here_;
  std::vector<char> prime_segment_;
  std::vector<Chord> chords_;
  std::vector<Region> stack_;
  std::size_t depth_ = 0;
  std::vector<Spoke> spokes_;
};

// Burns the medial curves, moves every region dual onto the neighbour it passed the fire to, and burns again: the hairs
// of the network, which run beside the fire, are then no longer than what they stand for.
void burn_network(RefinedAxis& axis, Context* context) {
  std::vector<std::uint32_t> edge_of;  // of K, per edge of the curves
  std::vector<std::array<std::uint32_t, 2>> edges;
  for (std::uint32_t e = 0; e < axis.curve_edge.size(); ++e)
    if (axis.curve_edge[e]) {
      edge_of.push_back(e);
      edges.push_back(axis.complex.edges[e]);
    }
  std::vector<double> length(edges.size());
  const auto measure = [&](const std::vector<std::uint32_t>& at) {
    for (std::size_t e = 0; e < edges.size(); ++e)
      length[e] = (axis.points[at[edges[e][0]]] - axis.points[at[edges[e][1]]]).norm();
  };
  std::vector<std::uint32_t> at(axis.points.size());
  for (std::uint32_t v = 0; v < at.size(); ++v) at[v] = v;
  measure(at);
  const CurveFire first = burn_curves(edges, axis.curve_vertex, axis.burn_time, length);
  checkpoint(context, "curves", 0.8);
  axis.exit.assign(axis.points.size(), kNone);
  for (std::uint32_t v = axis.nodes + axis.doors; v < at.size(); ++v) {
    if (first.exit[v] == kNone) continue;
    const auto [a, b] = edges[first.exit[v]];
    at[v] = a == v ? b : a;
    axis.exit[v] = edge_of[first.exit[v]];
  }
  measure(at);
  CurveFire second = burn_curves(edges, axis.curve_vertex, axis.burn_time, length);
  axis.curve_burn_time = std::move(second.time);
  axis.medial_point = std::move(second.last);
}

RefinedAxis refined(const CellComplex& complex, std::span<const Vec3> points, std::span<const double> radius,
                    const Burning& burning, Context* context) {
  RefinedAxis axis;
  {
    const BurnDomain domain{complex, points, radius, burning.sectors->network, burning.options.radius};
    axis = Refinement(domain, burning).run(context);
  }
  burn_network(axis, context);
  checkpoint(context, "curves", 1);
  return axis;
}

}  // namespace

RefinedAxis quench_curves(const CellComplex& complex, std::span<const Vec3> points, std::span<const double> radius,
                          const Burning& burning, Context* context) {
  if (!burning.sectors || burning.sectors->parent.size() != burning.sectors->state_time.size() ||
      burning.burn_time.size() != complex.vertex_count)
    throw Error(ErrorCode::usage, "medial curves need a burning of the same axis with BurnOptions::parents");
  return base::in_arena(context, [&] { return refined(complex, points, radius, burning, context); });
}

}  // namespace quench
