// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "burning/link.h"
#include "burning/network.h"
#include "burning/window_queue.h"

namespace quench::burning {

/// Everything a propagation works on.
struct Site {
  const CellComplex& complex;
  std::span<const Vec3> points;
  std::span<const double> radius;
  const BurnNetwork& network;
  const Links& links;
  const Polygons& polygons;
  RadiusRule rule;
  double scale;  ///< the farthest of the points from the first: at least half the diameter of all

  std::uint32_t vertex_states() const { return network.vertex_base.back(); }
  bool is_vertex(std::uint32_t state) const { return state < vertex_states(); }
  std::uint32_t edge_of(std::uint32_t state) const { return links.edge_of[state - vertex_states()]; }
  /// For the state of an inserted node: its place on the edge, from 1.
  std::uint32_t place_of(std::uint32_t state, std::uint32_t edge) const {
    return (state - links.edges[edge].state_base) / links.edges[edge].sectors() + 1;
  }
  double radius_inside(std::uint32_t edge, std::uint32_t place) const {
    const auto [a, b] = complex.edges[edge];
    return radius_inside_edge(radius[a], radius[b], network.length[edge],
                              static_cast<double>(place) / links.edges[edge].pieces, rule);
  }
  double radius_of(std::uint32_t state) const {
    if (is_vertex(state)) return radius[links.vertex_of[state]];
    const std::uint32_t e = edge_of(state);
    return radius_inside(e, place_of(state, e));
  }
};

/// How many states take turns together, and for how long (see WindowQueue). What fire reads of so many states is a
/// megabyte or two. In wider windows more of a block's work is done in one turn, but more of it is done again when fire
/// comes in from other blocks. Measured in notes/performance.md, "Burning".
struct Turns {
  std::uint64_t states = 8192;
  double window = 4;  ///< spacings of nodes
};

/// One number per state, accessed at random.
using Times = base::HugeVector<double>;

/// Where a front came from: its field is `time` + distance to the point (x, y) in the frame of the label's own edge, x
/// along the edge from its first vertex, y >= 0 the distance from the edge's line, on whichever side.
struct Source {
  double x, y, time;
};
inline constexpr Source kUnknownSource{0, 0, std::numeric_limits<double>::quiet_NaN()};

/// Labels of all states during the burn pass, and the rules by which arrivals become times.
class Labels {
 public:
  enum Status : unsigned char {
    open = 1,    ///< needs no arrival
    pocket = 2,  ///< never burns
    queued = 4,
    burned = 8,    ///< at least once
    several = 16,  ///< the node has other sectors, or its times follow from theirs
    floor = 32     ///< at the radius: cannot burn earlier
  };

  /// Open sectors are labelled with the radius and queued, pockets set aside. `tolerance`: by how much the time of a
  /// burned state must drop to burn it again; `segments`: keep the sources of fronts, and no time below the radius.
  Labels(const Site& site, const Turns& turns, double tolerance, bool segments);

  /// Fire of time t arrives at a state through polygon `through`, from `source` (ignored at vertices, which are sources
  /// themselves). Recomputes the times of the node's sectors and queues those that drop.
  void lower(std::uint32_t state, double t, std::uint32_t through, const Source& source) {
    if (t < time_[state] && !(status_[state] & (open | pocket | floor))) lower_time(state, t, through, source);
  }
  /// The next state to burn, marked as burned; false at the end.
  bool next(std::uint32_t& state, bool& again);

  double time(std::uint32_t s) const { return time_[s]; }
  bool is_burned(std::uint32_t s) const { return status_[s] & burned; }
  bool is_open(std::uint32_t s) const { return status_[s] & open; }
  std::uint32_t through(std::uint32_t s) const { return through_[s]; }
  const Source& source(std::uint32_t s) const { return source_[s - site_.vertex_states()]; }

  /// The end: times, and a flag per state that burned because the others of its link had.
  void release(Times& times, std::vector<char>& opened);

 private:
  void start_vertices();
  void start_edges();
  void lower_time(std::uint32_t state, double t, std::uint32_t through, const Source& source);
  void label(std::uint32_t state, double t);
  void label(std::uint32_t state, double t, std::uint32_t through, const Source& source);
  void lower_vertex(std::uint32_t state, double t, std::uint32_t through);
  bool is_parallel(std::uint32_t first, std::uint32_t count) const;
  void lower_seam(std::uint32_t state, double t, std::uint32_t through, const Source& source);

  const Site& site_;
  double tolerance_;
  bool segments_;
  WindowQueue queue_;
  Times time_;
  Times arrival_;  // of the states of Links::arrivals
  // Of the segments only: the polygon a front came through, and for inserted nodes (vertices are sources themselves)
  // its source.
  base::HugeVector<std::uint32_t> through_;
  base::HugeVector<Source> source_;
  base::HugeVector<unsigned char> status_;
  std::vector<char> removed_;  // scratch
  SectorTimes sector_times_;
};

/// burn() with other turns. By nodes they change nothing; by segments, where fronts meet, times by a small part of the
/// spacing.
Burning burn_in_turns(const CellComplex& complex, std::span<const Vec3> points, std::span<const double> radius,
                      const BurnOptions& options, const Turns& turns, Context* context);

/// Burn pass (geometry) by either propagation: times per state.
void propagate_by_nodes(const Site& site, Labels& labels, Context* context);
void propagate_by_segments(const Site& site, Labels& labels, double tolerance, Context* context);

/// Order pass (topology): the burn sequence over the times of the burn pass, and from it the parents of prime sectors,
/// into `result`. Throws Error(invariant) when a sector outside the pockets has no place in it.
void order_pass(const Site& site, const std::vector<char>& opened, const Times& time, Burning& result,
                Context* context);

}  // namespace quench::burning
