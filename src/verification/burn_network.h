// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "base/csr.h"
#include "verification/result.h"

namespace quench::verification {

/// Where fire is tracked (docs/algorithms/burning.md): the nodes on the edges of a result and their states, numbered as
/// in files.
class BurnNetwork {
 public:
  /// `exact`: the radius rule.
  BurnNetwork(const Result& result, double omega, bool exact);

  std::size_t states() const { return states_; }
  /// The states of vertex v are sectors()[v] up to sectors()[v + 1].
  const std::vector<std::uint32_t>& sectors() const { return sectors_; }
  /// The sector of a corner of a polygon, an index into the corners of all.
  std::uint32_t sector_of(std::uint32_t corner) const { return sector_of_[corner]; }
  const std::vector<std::uint32_t>& sectors_of_corners() const { return sector_of_; }
  /// Per edge: the number of its parts.
  const std::vector<std::uint32_t>& pieces() const { return pieces_; }

  /// The states of the nodes inside an edge: `each` per node.
  struct Inside {
    std::uint32_t first, nodes, each;
  };
  Inside inside(std::uint32_t edge) const { return {first_state_[edge], pieces_[edge] - 1, states_per_node(edge)}; }

  /// A node on the boundary of a polygon, and its state there.
  struct Stop {
    std::uint32_t state;
    double radius;
    Vec3 point;
  };
  /// The nodes of a polygon, along its sides.
  void stops_of(std::uint32_t face, std::vector<Stop>& stops) const;

 private:
  const Vec3& point(std::uint32_t v) const { return result_.point(v); }
  double radius_at(std::uint32_t a, std::uint32_t b, double t) const;
  std::uint32_t states_per_node(std::uint32_t edge) const {
    const auto polygons = static_cast<std::uint32_t>(at_edge_[edge].size());
    return polygons > 2 ? polygons : 1;
  }
  void number_sectors();
  void split_edges(double omega);

  const Result& result_;
  bool exact_;
  base::Csr<std::uint32_t> at_edge_;  // corners whose side the edge is
  std::vector<std::uint32_t> sectors_, sector_of_, pieces_, first_state_;
  std::size_t states_ = 0;
};

}  // namespace quench::verification
