// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "axis/top_cells.h"
#include "base/union_find.h"

namespace quench::axis {

/// A component of cells with cap heights above d, connected by vertices, is significant when the largest is above
/// kPeak * d: 1.5 voxels for the automatic detail of cubes.
inline constexpr double kPeak = 1.7320508075688772;

/// The components of { cap height > d } while d falls from the largest height to `least`, each with its peak. A
/// component becomes significant when d falls to peak / kPeak. The *detail* of a cell is the largest d at which it is
/// part of a significant component. O(n log n) in the cells above `least`.
class SignificantParts {
 public:
  SignificantParts(const TopCells& cells, std::uint32_t vertex_count, double least);

  /// Writes the details of the cells of at least `least` in place of their heights.
  void set_details();

  /// The component of a vertex when d is `least`; kNone for those of no cell above it.
  std::uint32_t component_of(std::uint32_t vertex) {
    return member_of_[vertex] == kNone ? kNone : sets_.find(member_of_[vertex]);
  }
  /// Whether a cell is one of those that the components are made of.
  bool is_above(std::uint32_t cell) const { return above_[cell] != 0; }
  std::size_t member_count() const { return parts_.size(); }
  /// Raises the details of all cells of some components to `least`; `needed` per component, as component_of() numbers
  /// them, of member_count() entries.
  void raise(const std::vector<char>& needed, double least);

 private:
  struct Entry {
    double height;
    std::uint32_t cell;
  };
  struct Part {
    double peak = 0;
    bool significant = false;
    std::uint32_t first = kNone, last = kNone;  // list of its cells without a detail, in order_
  };
  void resolve(Part& part, double detail);
  void catch_up(Part& part, double d);
  void join(std::uint32_t a, std::uint32_t b, double d);
  void add(std::uint32_t i);

  const TopCells& cells_;
  std::vector<std::uint32_t> member_of_;  // per vertex of a cell above `least`: its number among them
  std::vector<char> above_;               // per cell: in order_
  std::vector<Entry> order_;
  base::UnionFind sets_{0};  // of members
  std::vector<Part> parts_;  // per member; of meaning at the roots
  std::vector<std::uint32_t> next_;
};

}  // namespace quench::axis
