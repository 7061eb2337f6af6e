// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <vector>

#include "burning/label_queue.h"
#include "burning/link.h"

namespace quench::burning {

/// The source of a front: its field is `time` + distance to the point (x, y). Coordinates are in the frame of the
/// label's own edge: x along the edge from its first vertex, y >= 0 the distance from the line of the edge, on
/// whichever side.
struct Source {
  double x, y, time;
};
inline constexpr Source kUnknownSource{0, 0, std::numeric_limits<double>::quiet_NaN()};

/// Labels of all states during the burn pass, and the rules by which arrivals of fire become times.
class Labels {
 public:
  enum Status : unsigned char {
    open = 1,    ///< the sector has a free end: it burns at the radius and needs no arrival
    pocket = 2,  ///< never burns
    queued = 4,
    burned = 8,      ///< popped at least once
    several = 16,    ///< the node has other sectors, or its times follow from theirs
    at_radius = 32,  ///< the time is the radius: it cannot be earlier
  };

  /// Queues open sectors with the radius as their time. `tolerance`: by how much the time of a burned state must drop
  /// for it to be burned again; without one, states would burn again for every rounding.
  Labels(const BurnDomain& domain, const BlockSchedule& schedule, double tolerance);

  /// Relaxes a state: fire reaches it at time t through polygon `through`, from `source` (ignored at vertices, which
  /// are sources themselves). Recomputes the times of the sectors of its node and queues those that drop.
  void lower(std::uint32_t state, double t, std::uint32_t through, const Source& source) {
    if (t < time_[state] && !(status_[state] & (open | pocket | at_radius))) lower_time(state, t, through, source);
  }
  /// The next state to burn, marked as burned; `again`: it was burned before. False when none is left.
  bool next(std::uint32_t& state, bool& again);

  double tolerance() const { return tolerance_; }
  double time(std::uint32_t s) const { return time_[s]; }
  bool is_burned(std::uint32_t s) const { return status_[s] & burned; }
  std::uint32_t through(std::uint32_t s) const { return through_[s]; }
  const Source& source(std::uint32_t s) const { return source_[s - domain_.vertex_states()]; }

  /// The times when all have burned, and opened[s]: state s burned because the others of its link had, before fire
  /// arrived in it. Gives the memory of the labels back; nothing else may be called after it.
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

  const BurnDomain& domain_;
  double tolerance_;
  LabelQueue queue_;
  Times time_;
  Times arrival_;                      // of the states counted by Links::arrivals
  HugeVector<std::uint32_t> through_;  // the polygon through which the front of the label came
  HugeVector<Source> source_;          // of the states of inserted nodes, counted from vertex_states()
  HugeVector<unsigned char> status_;
  std::vector<char> removed_;  // scratch
  SectorTimes sector_times_;
};

}  // namespace quench::burning
