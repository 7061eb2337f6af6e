// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "base/constants.h"

namespace quench::burning {

/// Fire of one source on a stretch of an edge: it arrives at x, counted along the edge from its first vertex, at the
/// time of the source plus its distance.
struct SourceWindow {
  double from, to;      ///< the stretch
  double along, depth;  ///< the source, unfolded into a plane that holds the edge: along it, and beside it (>= 0)
  double time;          ///< when the fire was, or would have been, at the source

  double distance(double x) const { return std::sqrt((x - along) * (x - along) + depth * depth); }
  double at(double x) const { return time + distance(x); }
  /// By how much the arrival grows per length at x, in [-1, 1].
  double slope(double x) const {
    const double d = distance(x);
    return d > 0 ? (x - along) / d : 0;
  }
  double earliest() const { return at(std::clamp(along, from, to)); }
};

/// The places inside (low, high) where two windows arrive at the same time, ascending: at most two.
struct Crossings {
  double at[2];
  int count = 0;
};
Crossings crossings(const SourceWindow& a, const SourceWindow& b, double low, double high);

/// The earliest fire along an edge as disjoint windows in order: the lower envelope of all that were inserted.
class WindowEnvelope {
 public:
  struct Entry {
    SourceWindow window;
    std::uint32_t id;       ///< unique in the envelope, for the parts of one window too
    std::uint32_t through;  ///< the caller's: through which polygon it came
    bool sent = false;      ///< the caller's; parts of a window inherit it
  };

  const std::vector<Entry>& entries() const { return entries_; }
  /// The entry of this id, or null.
  Entry* find(std::uint32_t id);
  /// The entry at x, or the nearest within `reach`, or null.
  const Entry* at(double x, double reach) const;

  /// Inserts the window where it is earlier than all others by more than `margin`, in stretches longer than
  /// `narrowest`, and appends the ids of new entries: of such stretches, and of parts of entries that were divided and
  /// not sent. O(entries).
  void insert(const SourceWindow& window, std::uint32_t through, double margin, double narrowest,
              std::vector<std::uint32_t>& made);

 private:
  std::vector<Entry> entries_;
  std::uint32_t next_id_ = 0;
};

}  // namespace quench::burning
