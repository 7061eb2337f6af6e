// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/bucket_queue.h"
#include "base/cofaces.h"
#include "base/constants.h"
#include "quench/complex.h"

namespace quench::complex {

using base::kNever;

/// A simple pair is named by its free face: the edge or vertex whose only coface is the other half. Pairs are collapsed
/// in the order of their keys, then of the dimension of the free face, then of its index.
using PairQueue = base::BucketQueue<std::uint64_t>;
inline constexpr std::uint64_t kEdgeIsFree = std::uint64_t{1} << 32;

/// An edge or vertex. Packed state: value >= 0 while it is live; -level (sign bit set) once removed. One load decides.
/// A removed cell has no cofaces.
struct LiveCell {
  base::Cofaces cofaces;  ///< the live ones
  double value;

  void init(double its_value) {
    cofaces = {};
    value = its_value + 0.0;  // no -0
  }
  void remove(double level) { value = -std::abs(level); }  // also sets the sign of -0
  bool removed() const { return std::signbit(value); }
  double level() const { return removed() ? -value : kNever; }
};

/// The cells of a complex that are not removed yet, with what decides which pairs are simple. 16 bytes per vertex and
/// edge, 8 per face.
class LiveCells {
 public:
  /// An array without initial values: the threads that fill it share its page faults.
  class Array {
   public:
    explicit Array(std::size_t size) : size_(size), cells_(std::make_unique_for_overwrite<LiveCell[]>(size)) {}
    std::size_t size() const { return size_; }
    LiveCell& operator[](std::size_t i) { return cells_[i]; }
    const LiveCell& operator[](std::size_t i) const { return cells_[i]; }

   private:
    std::size_t size_;
    std::unique_ptr<LiveCell[]> cells_;
  };

  /// Values must not be negative. In parallel.
  LiveCells(const CellComplex& of, std::span<const double> vertex, std::span<const double> edge,
            std::span<const double> face);

  /// The pair whose free face is edge e; its key is kNever if there is none that can be collapsed.
  PairQueue::Entry pair_of_edge(std::uint32_t e) const {
    const LiveCell& edge = edges[e];
    if (!edge.cofaces.single()) return {kNever, 0};
    return {edges_decide ? edge.value : std::max(face_value[edge.cofaces.only()], edge.value), kEdgeIsFree | e};
  }
  /// The pair whose free face is vertex v; its key is kNever if there is none that can be collapsed.
  PairQueue::Entry pair_of_vertex(std::uint32_t v) const {
    const LiveCell& vertex = vertices[v];
    if (!vertex.cofaces.single()) return {kNever, 0};
    const LiveCell& edge = edges[vertex.cofaces.only()];
    return {edge.cofaces.none() ? std::max(edge.value, vertex.value) : kNever, v};
  }

  const CellComplex& complex;
  std::span<const double> face_value;
  Array edges, vertices;
  std::vector<double> face_level;  ///< kNever while the face is live
  bool edges_decide = false;       ///< no face has a larger value than an edge of it: the keys are those of edges
};

}  // namespace quench::complex
