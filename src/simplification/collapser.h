// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <queue>
#include <vector>

#include "quench/simplify.h"
#include "simplification/mutable_complex.h"
#include "simplification/quadric.h"

namespace quench::simplification {

/// Collapses the edges of a medial mesh, cheapest first: what a ball in the place of both ends would miss of the planes
/// that these should touch, where it misses least.
class Collapser {
 public:
  Collapser(const MedialAxis& mesh, std::vector<Quadric> quadrics, Context* context);

  /// Collapses until so few vertices are left, or no edge may be collapsed; returns the steps, in vertices of the mesh.
  /// Progress of the stage goes from `begin` to `end`.
  std::vector<Collapse> run(std::size_t vertices, double begin, double end);

  /// The mesh that is left; `rows`: its vertices, as rows of the one in the beginning.
  MedialAxis mesh(std::vector<std::uint32_t>& rows) const;

 private:
  struct Entry {
    double cost;
    std::uint32_t edge, version;
    friend bool operator>(const Entry& a, const Entry& b) {
      return a.cost != b.cost ? a.cost > b.cost : a.edge > b.edge;
    }
  };
  struct Place {
    Vec4 ball;
    double cost;
  };
  Place place(std::uint32_t e) const;
  void push(std::uint32_t e) { queue_.push({place(e).cost, e, ++version_[e]}); }
  bool push_blocked();

  MutableComplex complex_;
  std::vector<Vec4> balls_;
  std::vector<Quadric> quadrics_;
  std::vector<std::uint32_t> version_;  // per edge: of its entry that counts
  std::vector<std::uint32_t> blocked_;  // edges whose link condition did not hold
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue_;
  Context* context_;
};

}  // namespace quench::simplification
