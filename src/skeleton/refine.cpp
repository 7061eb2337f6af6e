// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>

#include "base/constants.h"
#include "base/parallel.h"
#include "quench/error.h"
#include "quench/skeleton.h"
#include "skeleton/burned_axis.h"
#include "skeleton/curve_times.h"
#include "skeleton/kept_nodes.h"
#include "skeleton/member.h"

namespace quench {
namespace {

using base::kNever;
using skeleton::BurnedAxis;
using skeleton::KeptNodes;
using skeleton::PolygonArcs;

// Numbers of cells of K: how many a piece of work makes, or which comes first.
struct CellNumbers {
  std::uint32_t duals = 0, edges = 0, faces = 0, corners = 0;

  void add(const CellNumbers& more) {
    duals += more.duals;
    edges += more.edges;
    faces += more.faces;
    corners += more.corners;
  }
  friend bool operator==(const CellNumbers&, const CellNumbers&) = default;
};

// How many cells cutting a polygon makes: a region more than chords, a spoke to every door but those of prime segments,
// a part per spoke. Around a region its dual is a corner of every part, a door that of two parts where a spoke ends in
// it, else of one, and its nodes, of which chords have two more, that of one and those with a spoke of two.
CellNumbers parts_of(const PolygonArcs& arcs, std::size_t kept) {
  const auto chords = static_cast<std::uint32_t>(arcs.chords.size());
  const std::uint32_t spokes = arcs.size() - arcs.primes + static_cast<std::uint32_t>(kept);
  return {chords + 1, chords + spokes, spokes, 2 * (spokes + arcs.size() + chords)};
}

// Cuts polygons along their prime arcs into regions, and each region along its spokes; puts the cells where `next`
// says.
class PolygonCutter {
 public:
  PolygonCutter(const BurnedAxis& axis, const KeptNodes& kept, std::span<const std::uint32_t> door_base,
                RefinedAxis& out, const CellNumbers& first)
      : axis_(axis), kept_(kept), door_base_(door_base), out_(out), next_(first) {}

  const CellNumbers& next() const { return next_; }

  // The next polygon.
  void cut(std::uint32_t f) {
    arcs_.load(axis_, door_base_, f);
    if (axis_.network.pocket[f]) return whole_pocket(f);
    std::vector<PolygonArcs::Chord>& chords = arcs_.chords;
    for (PolygonArcs::Chord& c : chords) c.edge = add_edge(arcs_.node[c.from], arcs_.node[c.to], false);
    std::sort(chords.begin(), chords.end(), [](const PolygonArcs::Chord& a, const PolygonArcs::Chord& b) {
      return a.from != b.from ? a.from < b.from : a.to > b.to;
    });
    kept_here_.assign(kept_.spokes[f].begin(), kept_.spokes[f].end());
    open(kNone);
    std::size_t next = 0;
    for (std::uint32_t p = 0; p < arcs_.size(); ++p) {
      while (depth_ > 1 && arcs_.chords[top().chord].to == p) {
        const std::uint32_t c = top().chord;
        top().places.push_back(p);
        top().arcs.push_back({false, c});
        divide(f);
        --depth_;
        top().arcs.push_back({false, c});
      }
      top().places.push_back(p);
      for (; next < arcs_.chords.size() && arcs_.chords[next].from == p; ++next) {
        open(static_cast<std::uint32_t>(next));
        top().places.push_back(p);
      }
      top().arcs.push_back({true, p});
    }
    divide(f);
    depth_ = 0;
  }

 private:
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
    const std::uint32_t dual = out_.nodes + out_.doors + next_.duals++;
    Vec3 centre = Vec3::Zero();
    double time = 0, squares = 0, radius = 0;
    for (const std::uint32_t p : region.places) centre += out_.points[arcs_.node[p]];
    centre /= static_cast<double>(m);
    for (const std::uint32_t p : region.places) {
      const std::uint32_t node = arcs_.node[p];
      time += axis_.burned.state_time[arcs_.state[p]];
      radius += out_.radius[node];
      squares += out_.radius[node] * out_.radius[node] - (out_.points[node] - centre).squaredNorm();
    }
    // The squared distance to a shared nearest point is the mean of those of the nodes minus their variance.
    radius = axis_.rule == RadiusRule::exact ? std::sqrt(std::max(0.0, squares / static_cast<double>(m)))
                                             : radius / static_cast<double>(m);
    out_.points[dual] = centre;
    out_.radius[dual] = radius;
    out_.burn_time[dual] = time / static_cast<double>(m);

    spokes_.clear();
    for (std::uint32_t i = 0; i < m; ++i) {
      const auto kept = std::find(kept_here_.begin(), kept_here_.end(), arcs_.node[region.places[i]]);
      if (kept != kept_here_.end()) {
        spokes_.push_back({i, add_edge(arcs_.node[region.places[i]], dual, true), false});
        kept_here_.erase(kept);
      }
      if (region.arcs[i].segment && !arcs_.prime[region.arcs[i].index])
        spokes_.push_back({i, add_edge(door(region.arcs[i].index), dual, true), true});
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
    const CellComplex& k = out_.complex;
    const std::size_t m = region.places.size();
    const double of_dual = thickness(dual, out_.burn_time[dual]);
    double thick = of_dual;
    const auto reached = [&](double value) {
      thick = std::max(thick, value);
      return value;
    };
    const auto half = [&](std::uint32_t p, bool second) {  // of the segment from place p on
      const std::uint32_t door = arcs_.door[p];
      return 2 * door + ((k.edges[2 * door][0] == arcs_.node[p]) == second);
    };
    const auto door_thickness = [&](std::uint32_t p) {
      const std::uint32_t q = p + 1 == arcs_.size() ? 0 : p + 1;
      return reached(thickness(
          door(p), 0.5 * (axis_.burned.state_time[arcs_.state[p]] + axis_.burned.state_time[arcs_.state[q]])));
    };
    corner(dual, from.edge, of_dual);
    std::size_t i = from.place;
    if (from.to_door) {
      const std::uint32_t p = region.arcs[i].index;
      corner(door(p), half(p, true), door_thickness(p));
      i = i + 1 == m ? 0 : i + 1;
    }
    // The node that `from` goes to is passed, not reached, where the walk starts.
    for (bool at_start = !from.to_door;; at_start = false) {
      const std::uint32_t p = region.places[i], node = arcs_.node[p];
      const double of_node = reached(thickness(node, axis_.burned.state_time[arcs_.state[p]]));
      if (i == to.place && !to.to_door && !at_start) {
        corner(node, to.edge, of_node);
        break;
      }
      const Arc& arc = region.arcs[i];
      if (!arc.segment) {
        corner(node, arcs_.chords[arc.index].edge, of_node);
      } else {
        corner(node, half(arc.index, false), of_node);
        const double of_door = door_thickness(arc.index);
        if (i == to.place && to.to_door) {
          corner(door(arc.index), to.edge, of_door);
          break;
        }
        corner(door(arc.index), half(arc.index, true), of_door);
      }
      i = i + 1 == m ? 0 : i + 1;
    }
    finish_face(f, thick);
  }
  void corner(std::uint32_t vertex, std::uint32_t side, double thickness) {
    out_.corner_thickness[next_.corners] = static_cast<float>(thickness);
    out_.complex.face_vertices[next_.corners] = vertex;
    out_.complex.face_edges[next_.corners++] = side;
  }
  void finish_face(std::uint32_t f, double thick) {
    out_.polygon_of[next_.faces] = f;
    out_.face_thickness[next_.faces++] = thick;
    out_.complex.face_offsets[next_.faces] = next_.corners;
  }
  std::uint32_t door(std::uint32_t place) const { return out_.nodes + arcs_.door[place]; }
  std::uint32_t add_edge(std::uint32_t a, std::uint32_t b, bool curve) {
    out_.complex.edges[next_.edges] = {std::min(a, b), std::max(a, b)};
    out_.curve_edge[next_.edges] = curve;
    // Nodes and doors are those of several polygons, which other threads cut.
    if (curve)
      for (const std::uint32_t v : {a, b}) std::atomic_ref(out_.curve_vertex[v]).store(1, std::memory_order_relaxed);
    return next_.edges++;
  }

  // A polygon of a pocket stays whole; the nodes and doors of its edges are its corners.
  void whole_pocket(std::uint32_t f) {
    for (std::uint32_t p = 0; p < arcs_.size(); ++p) {
      const std::uint32_t first = 2 * arcs_.door[p];
      const bool in_order = out_.complex.edges[first][0] == arcs_.node[p];
      corner(arcs_.node[p], first + !in_order, kNever);
      corner(door(p), first + in_order, kNever);
    }
    finish_face(f, kNever);
  }

  const BurnedAxis& axis_;
  const KeptNodes& kept_;
  std::span<const std::uint32_t> door_base_;
  RefinedAxis& out_;
  CellNumbers next_;
  // Of the polygon being cut: nodes and arcs, spokes to nodes that are still to come, regions.
  PolygonArcs arcs_;
  std::vector<std::uint32_t> kept_here_;
  std::vector<Region> stack_;
  std::size_t depth_ = 0;
  std::vector<Spoke> spokes_;
};

class Refinement {
 public:
  Refinement(const BurnedAxis& axis, const Burning& burning)
      : axis_(axis), plane_(burning.options.plane), vertex_time_(plane_ ? axis.radius : burning.burn_time) {}

  RefinedAxis run(Context* context) {
    out_.radius_rule = axis_.rule;
    out_.plane = plane_;
    number_doors();
    kept_ = skeleton::kept_nodes(axis_);
    checkpoint(context, "curves", 0.1);
    count_cells(context);
    place_nodes();
    place_doors();
    const CellComplex& m = axis_.complex;
    for (const std::uint32_t v : kept_.isolated) out_.curve_vertex[v] = 1;
    for (std::size_t i = 0; i < kept_.lone_edges.size(); ++i) {
      const std::size_t e = 2 * std::size_t{out_.doors} + i;
      out_.complex.edges[e] = m.edges[kept_.lone_edges[i]];
      out_.curve_edge[e] = 1;
      for (const std::uint32_t v : out_.complex.edges[e]) out_.curve_vertex[v] = 1;
    }
    base::for_chunks(first_.size() - 1, context, "curves", 0.3, 0.6, [&](std::size_t chunk) {
      PolygonCutter cutter(axis_, kept_, door_base_, out_, first_[chunk]);
      const auto [first, last] = base::part_of(m.face_count(), chunk, first_.size() - 1);
      for (std::size_t f = first; f < last; ++f) cutter.cut(static_cast<std::uint32_t>(f));
      if (cutter.next() != first_[chunk + 1])
        throw Error(ErrorCode::invariant,
                    "polygons were cut into other parts than were counted; this is a bug in Quench, please report it "
                    "with the input");
    });
    return std::move(out_);
  }

 private:
  // Doors halve the segments of all edges that polygons have. Halves come first among the edges of K: 2d and 2d + 1 are
  // those of door d.
  void number_doors() {
    const CellComplex& m = axis_.complex;
    out_.original = m.vertex_count;
    out_.nodes = axis_.network.node_count();
    door_base_.assign(m.edges.size() + 1, 0);
    std::uint64_t doors = 0;
    for (std::uint32_t e = 0; e < m.edges.size(); ++e) {
      door_base_[e] = static_cast<std::uint32_t>(doors);
      if (axis_.network.degree(e) > 0) doors += axis_.pieces(e);
    }
    // There are fewer regions, and so fewer of all other cells, than four per node on the boundaries of all polygons.
    std::uint64_t most = out_.nodes + doors;
    for (const std::uint32_t e : m.face_edges) most += 4 * std::uint64_t{axis_.pieces(e)};
    if (most >= kNone)
      throw Error(ErrorCode::failed,
                  "the medial curves of this axis have more than 2^32 parts; use a larger omega or "
                  "lambda");
    out_.doors = static_cast<std::uint32_t>(doors);
    door_base_.back() = out_.doors;
  }

  // Which cells each chunk of polygons makes, so that chunks can be cut at the same time; room for all.
  void count_cells(Context* context) {
    const std::size_t faces = axis_.complex.face_count();
    const std::size_t chunks = base::chunks_for(faces, std::size_t{1} << 11);
    first_.resize(chunks + 1);
    base::for_chunks(chunks, context, "curves", 0.1, 0.3, [&](std::size_t chunk) {
      PolygonArcs arcs;
      const auto [first, last] = base::part_of(faces, chunk, chunks);
      for (std::size_t i = first; i < last; ++i) {
        const auto f = static_cast<std::uint32_t>(i);
        arcs.load(axis_, door_base_, f);
        first_[chunk + 1].add(axis_.network.pocket[f] ? CellNumbers{0, 0, 1, 2 * arcs.size()}
                                                      : parts_of(arcs, kept_.spokes[f].size()));
      }
    });
    first_[0].edges = 2 * out_.doors + static_cast<std::uint32_t>(kept_.lone_edges.size());
    for (std::size_t chunk = 0; chunk < chunks; ++chunk) first_[chunk + 1].add(first_[chunk]);
    const CellNumbers& all = first_.back();
    CellComplex& k = out_.complex;
    k.vertex_count = out_.nodes + out_.doors + all.duals;
    out_.points.resize(k.vertex_count);
    out_.radius.resize(k.vertex_count);
    out_.burn_time.resize(k.vertex_count);
    out_.curve_vertex.assign(k.vertex_count, 0);
    k.edges.resize(all.edges);
    out_.curve_edge.assign(all.edges, 0);
    k.face_offsets.assign(all.faces + std::size_t{1}, 0);
    k.face_vertices.resize(all.corners);
    k.face_edges.resize(all.corners);
    out_.corner_thickness.resize(all.corners);
    out_.polygon_of.resize(all.faces);
    out_.face_thickness.resize(all.faces);
  }

  void place_nodes() {
    const CellComplex& m = axis_.complex;
    const burning::BurnNetwork& net = axis_.network;
    std::copy(axis_.points.begin(), axis_.points.end(), out_.points.begin());
    std::copy(axis_.radius.begin(), axis_.radius.end(), out_.radius.begin());
    std::copy(vertex_time_.begin(), vertex_time_.end(), out_.burn_time.begin());
    base::for_indices(m.edges.size(), [&](std::size_t i) {
      const auto e = static_cast<std::uint32_t>(i);
      const std::uint32_t sectors = net.sectors_of(e);
      for (std::uint32_t along = 1; along < net.pieces[e]; ++along) {
        const std::uint32_t node = net.node_base[e] + along - 1, first = net.state_base[e] + (along - 1) * sectors;
        const double t = static_cast<double>(along) / net.pieces[e];
        out_.points[node] = axis_.on_edge(e, t);
        out_.radius[node] = axis_.radius_on_edge(e, t);
        double time = out_.radius[node];
        for (std::uint32_t s = first; s < first + sectors; ++s) time = std::max(time, axis_.burned.state_time[s]);
        out_.burn_time[node] = time;
      }
    });
  }

  void place_doors() {
    base::for_indices(axis_.complex.edges.size(), [&](std::size_t i) {
      const auto e = static_cast<std::uint32_t>(i);
      for (std::uint32_t d = door_base_[e]; d < door_base_[e + 1]; ++d) {
        const std::uint32_t j = d - door_base_[e], door = out_.nodes + d;
        const double t = (j + 0.5) / axis_.pieces(e);
        out_.points[door] = axis_.on_edge(e, t);
        out_.radius[door] = axis_.radius_on_edge(e, t);
        out_.burn_time[door] = door_time(e, j, out_.radius[door]);
        out_.complex.edges[2 * std::size_t{d}] = {axis_.node_on_edge(e, j), door};
        out_.complex.edges[2 * std::size_t{d} + 1] = {axis_.node_on_edge(e, j + 1), door};
      }
    });
  }
  // The second largest over the polygons of the mean time of the segment's nodes in the polygon's sector: the last
  // sheet burns together with the last but one. The radius on a rim, infinite on a pocket.
  double door_time(std::uint32_t e, std::uint32_t j, double radius) const {
    const auto sides = axis_.network.face_corners_at(e);
    if (sides.size() == 1) return radius;
    double largest = -kNever, second = -kNever;
    for (const std::uint32_t c : sides) {
      if (axis_.network.pocket[axis_.network.corner_face[c]]) return kNever;
      const double time = 0.5 * (axis_.burned.state_time[axis_.state_on_side(c, j)] +
                                 axis_.burned.state_time[axis_.state_on_side(c, j + 1)]);
      second = std::max(second, std::min(largest, time));
      largest = std::max(largest, time);
    }
    return second;
  }

  const BurnedAxis& axis_;
  bool plane_;
  std::span<const double> vertex_time_;  // at which the fire on the curves may start
  RefinedAxis out_;
  std::vector<std::uint32_t> door_base_;  // per edge; the number of doors behind
  KeptNodes kept_;
  std::vector<CellNumbers> first_;  // per chunk of polygons; all behind
};

// Region duals are drawn at the doors through which they passed their fire on, so they have the thickness of these, in
// the polygon of their region.
void set_thickness_of_duals(RefinedAxis& axis) {
  const CellComplex& k = axis.complex;
  const std::uint32_t first_dual = axis.nodes + axis.doors;
  std::vector<float> of_door(k.vertex_count - first_dual, -1);
  const auto each_face = [&](const auto& visit) {
    base::for_indices(k.face_count(), [&](std::size_t f) {
      const std::uint32_t dual = k.corners(f)[0];
      if (dual >= first_dual && axis.exit[dual] != kNone) visit(f, dual);
    });
  };
  // The spoke to the door is a side of two faces of the region at least, or twice of one: they write the same.
  each_face([&](std::size_t f, std::uint32_t dual) {
    const std::uint32_t exit = skeleton::other_end(axis, axis.exit[dual], dual);
    for (const std::uint32_t c : {k.face_offsets[f] + 1, k.face_offsets[f + 1] - 1})
      if (k.face_vertices[c] == exit)
        std::atomic_ref(of_door[dual - first_dual]).store(axis.corner_thickness[c], std::memory_order_relaxed);
  });
  each_face([&](std::size_t f, std::uint32_t dual) {
    const float thickness = of_door[dual - first_dual];
    axis.corner_thickness[k.face_offsets[f]] = thickness;
    axis.face_thickness[f] = std::max(axis.face_thickness[f], static_cast<double>(thickness));
  });
}

RefinedAxis refined(const CellComplex& complex, std::span<const Vec3> points, std::span<const double> radius,
                    Burning&& burning, Context* context) {
  RefinedAxis axis;
  {
    const BurnedAxis burned{
        complex, points, radius, *burning.sectors, burning.sectors->network, burning.options.radius};
    axis = Refinement(burned, burning).run(context);
  }
  burning = Burning();
  skeleton::burn_curve_network(axis, context);
  set_thickness_of_duals(axis);
  checkpoint(context, "curves", 1);
  return axis;
}

}  // namespace

RefinedAxis quench_curves(const CellComplex& complex, std::span<const Vec3> points, std::span<const double> radius,
                          Burning burning, Context* context) {
  if (!burning.sectors || burning.sectors->parent.size() != burning.sectors->state_time.size() ||
      burning.burn_time.size() != complex.vertex_count)
    throw Error(ErrorCode::usage, "medial curves need a burning of the same axis with BurnOptions::parents");
  return base::in_arena(context, [&] { return refined(complex, points, radius, std::move(burning), context); });
}

}  // namespace quench
