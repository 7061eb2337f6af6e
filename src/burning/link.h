// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "base/graph_peeler.h"
#include "burning/network.h"

namespace quench::burning {

/// The link of one vertex as a graph: its edges are sectors, its vertices singular directions. A link edge (sector)
/// with an endpoint of degree 1 is free: it is removed at once. Direction 0 is the contracted pocket and never makes a
/// sector free.
class Link {
 public:
  /// `removed[i]`: sector i is not part of the link (burned, or part of the contracted pocket). Both spans must outlive
  /// the use of the link.
  void reset(std::span<const Links::Ends> ends, std::span<char> removed);

  /// Removes a sector, then every sector that becomes free; appends those to `stripped` in the order of removal.
  void remove(std::uint32_t sector, std::vector<std::uint32_t>& stripped);
  /// Removes every sector that is free or becomes so.
  void strip(std::vector<std::uint32_t>& stripped);
  /// Whether a sector lies on a cycle of the link; otherwise it is a bridge. O(sectors).
  bool on_cycle(std::uint32_t sector);

 private:
  std::span<const Links::Ends> ends_;
  std::span<char> removed_;
  base::GraphPeeler directions_;
  std::vector<std::uint32_t> group_;
};

/// When each sector of a link burns, from the arrivals of fire in them: free sectors at the radius, before everything
/// else; then by increasing arrival (ties: smaller index) each sector that is left, and at the same time those that
/// become free by its removal. Monotone in every arrival. Pocket sectors never burn.
class SectorTimes {
 public:
  struct Time {
    double time;
    /// The sector whose arrival set the time: itself, or another by whose removal it became free. kNone if it was free
    /// from the start, or never burns.
    std::uint32_t opened_by;
  };
  /// The result is valid until the next call. O(k log k).
  std::span<const Time> operator()(std::span<const Links::Ends> ends, std::span<const double> arrival,
                                   std::span<const char> pocket, double radius);

 private:
  Link link_;
  std::vector<char> removed_;
  std::vector<std::uint32_t> order_, stripped_;
  std::vector<Time> times_;
};

}  // namespace quench::burning
