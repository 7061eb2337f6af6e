// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "burning/network.h"

namespace quench::burning {

/// The link of one vertex: a graph whose edges are sectors, whose vertices are singular directions. A sector
/// on which a direction hangs alone has a free end and burns by itself; direction 0 is a pocket and never free.
class Link {
 public:
  /// `removed[i]`: the sector is gone (burned, or part of the contracted pocket). Both spans must outlive the link.
  Link(std::span<const Links::Ends> ends, std::span<char> removed) { reset(ends, removed); }
  Link() = default;
  void reset(std::span<const Links::Ends> ends, std::span<char> removed);

  /// Removes a sector, then every sector that has a free end; appends those to `stripped` in the order they go.
  void remove(std::uint32_t sector, std::vector<std::uint32_t>& stripped);
  /// Removes every sector that has a free end.
  void strip(std::vector<std::uint32_t>& stripped);
  /// Whether a sector that is left lies on a cycle of what is left; otherwise it is a bridge. O(k).
  bool on_cycle(std::uint32_t sector);

 private:
  void detach(std::uint32_t sector);
  std::span<const Links::Ends> ends_;
  std::span<char> removed_;
  struct Direction {
    std::uint32_t degree, sectors_xor;  // with degree 1 the xor is the only sector
  };
  std::vector<Direction> directions_;  // count_ of them are of this link
  std::uint32_t count_ = 0;
  std::vector<std::uint32_t> free_, group_;
};

/// When each sector burns, from the arrivals of fire at each: open sectors at the radius before everything else; then
/// by increasing arrival (ties: smaller index): what is still there goes, then what has a free end by now, at the same
/// time. Monotone in every arrival. Pocket sectors never.
class SectorTimes {
 public:
  struct Time {
    double time;
    std::uint32_t
        opened_by;  ///< the sector that arrived; itself if this one did; kNone if open from the start or never
  };
  /// `pocket[i]` is lost. O(k log k).
  std::span<const Time> operator()(std::span<const Links::Ends> ends, std::span<const double> arrival,
                                   std::span<const char> pocket, double radius);

 private:
  Link link_;
  std::vector<char> removed_;
  std::vector<std::uint32_t> order_, stripped_;
  std::vector<Time> times_;
};

}  // namespace quench::burning
