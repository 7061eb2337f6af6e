// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <queue>
#include <vector>

#include "quench/simplify.h"
#include "simplification/mutable_complex.h"
#include "simplification/primitive_tree.h"
#include "simplification/quadric.h"

namespace quench::simplification {

/// Collapses the edges of a medial mesh, cheapest first.
class Collapser {
 public:
  Collapser(const MedialAxis& mesh, std::vector<Quadric> quadrics);

  /// Collapses until so few vertices are left, or no edge may be collapsed; appends the steps.
  void run(std::size_t vertices, std::vector<Collapse>& steps, Context* context, double begin, double end);

  const MutableComplex& complex() const { return complex_; }
  std::vector<Vec4>& balls() { return balls_; }
  /// Slabs, lone edges and lone vertices.
  std::vector<Primitive> primitives() const;
  /// Other quadrics, and other balls, for the vertices that are left.
  void restart(std::vector<Quadric> quadrics);

 private:
  struct Entry {
    double cost;
    std::uint32_t edge, version;
    friend bool operator>(const Entry& a, const Entry& b) {
      return a.cost != b.cost ? a.cost > b.cost : a.edge > b.edge;
    }
  };
  Vec4 place(std::uint32_t e, double* cost) const;
  void push(std::uint32_t e);

  MutableComplex complex_;
  std::vector<Vec4> balls_;
  std::vector<Quadric> quadrics_;
  std::vector<std::uint32_t> version_;
  std::vector<std::uint32_t> blocked_;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue_;
};

}  // namespace quench::simplification
