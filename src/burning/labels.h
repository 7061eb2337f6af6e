// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <vector>

#include "base/prefetch.h"
#include "burning/label_queue.h"
#include "burning/link.h"
#include "burning/vertex_angles.h"

namespace quench::burning {

/// The source of a front: its field is `time` + distance to a point. At an inserted node the point is (x, y) in the
/// frame of its edge: x along the edge from its first vertex, y >= 0 the distance from the line of the edge, on
/// whichever side. At a vertex, x is its direction (VertexAngles), y its distance. Where the time is NaN, fire came
/// into the sector of a vertex over its first and last sides from the points that lie x and y beyond them, as angles;
/// infinite: from nowhere that is known.
struct Source {
  double x, y, time;
};
inline constexpr Source kUnknownSource{kNever, kNever, std::numeric_limits<double>::quiet_NaN()};

/// A source as seen from a vertex along one of the sides of a corner: the angles between them, through the corner's
/// polygon and the other way round, infinite where the sector ends in between; distance and time of the source. The
/// time is NaN if it is unknown.
struct Seen {
  double inside, outside, distance, time;
};

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

  /// What one thread needs to burn the states of a block.
  struct Worker : WindowQueue::Worker {
    using WindowQueue::Worker::Worker;
    std::vector<char> removed;  // scratch
    SectorTimes sector_times;
  };

  /// Burns all states: calls work(worker) for every block of states, on several threads at the same time for blocks
  /// that do not touch each other; it takes states by next() until there are none. pause(burned) is called every now
  /// and then on the thread of the caller. The result does not depend on the number of threads.
  template <class Work, class Pause>
  void burn(const Work& work, const Pause& pause) {
    queue_.run([&] { return Worker(queue_); }, [&](std::uint32_t s) { return queued_time(s); },
               [&](std::uint32_t s) {
                 base::prefetch(&status_[s]);
                 base::prefetch(&time_[s]);
               },
               work, pause);
  }

  /// Relaxes a state: fire reaches it at time t from `source`, an inserted node through polygon `through`. Recomputes
  /// the times of the sectors of its node and queues those that drop.
  void lower(Worker& worker, std::uint32_t state, double t, std::uint32_t through, const Source& source) {
    if (t < time_[state] && !(status_[state] & (open | pocket | at_radius)))
      lower_time(worker, state, t, through, source);
  }
  /// The next state of the worker's block to burn, marked as burned; `again`: it was burned before. False when none is
  /// left.
  bool next(Worker& worker, std::uint32_t& state, bool& again);

  double tolerance() const { return tolerance_; }
  double time(std::uint32_t s) const { return time_[s]; }
  bool is_burned(std::uint32_t s) const { return status_[s] & burned; }
  /// Of an inserted node: the polygon through which its front came.
  std::uint32_t through(std::uint32_t s) const { return through_[s]; }
  /// Of a vertex state: the other state of the vertex whose fire goes on in it, or kNone.
  std::uint32_t opened_by(std::uint32_t s) const { return through_[s]; }
  const Source& source(std::uint32_t s) const { return source_[s]; }
  const VertexAngles& angles() const { return angles_; }
  /// The source of a vertex state, seen along the side that starts at a corner of its sector, or along the one before.
  Seen seen_along(std::uint32_t state, std::uint32_t corner, bool starts) const;

  /// The times when all have burned, and opened[s]: state s burned because the others of its link had, before fire
  /// arrived in it. Gives the memory of the labels back; nothing else may be called after it.
  BurnTimes release();

 private:
  void start_vertices();
  void start_edges();
  double queued_time(std::uint32_t s) const { return status_[s] & queued ? time_[s] : kNever; }
  void lower_time(Worker& worker, std::uint32_t state, double t, std::uint32_t through, const Source& source);
  void label(Worker& worker, std::uint32_t state, double t);
  void label(Worker& worker, std::uint32_t state, double t, std::uint32_t through, const Source& source);
  void lower_vertex(Worker& worker, std::uint32_t state, double t, const Source& source);
  Source source_at_rim(std::uint32_t state, std::uint32_t v) const;
  Source source_beyond(std::uint32_t state, std::uint32_t opener) const;
  double angle_beyond(std::uint32_t edge, std::uint32_t v, std::uint32_t opener) const;
  bool is_parallel(std::uint32_t first, std::uint32_t count) const;
  void lower_seam(Worker& worker, std::uint32_t state, double t, std::uint32_t through, const Source& source);

  const BurnDomain& domain_;
  double tolerance_;
  VertexAngles angles_;
  LabelQueue queue_;
  Times time_;
  Times arrival_;                      // of the states counted by Links::arrivals
  HugeVector<std::uint32_t> through_;  // through(), or opened_by()
  HugeVector<Source> source_;
  HugeVector<unsigned char> status_;
};

}  // namespace quench::burning
