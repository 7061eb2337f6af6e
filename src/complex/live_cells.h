// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "base/bucket_queue.h"
#include "base/parallel.h"
#include "quench/complex.h"

namespace quench::complex {

/// A simple pair is known by its free cell, the edge or vertex whose only larger cell is the other half. Pairs go in
/// the order of their keys, then of the dimension of the free cell, then of its index.
using PairQueue = base::BucketQueue<std::uint64_t>;
inline constexpr std::uint64_t kEdgeIsFree = std::uint64_t{1} << 32;
inline constexpr double kNever = std::numeric_limits<double>::infinity();

/// The live larger cells at a cell, as the sum of 2^32 + index: below 2^32 there is none, below 2^33 one, which the low
/// half names. Sums may be made in any order, by several threads.
class Cofaces {
 public:
  void add(std::uint32_t cell, bool shared) { base::fetch_add(sum_, one(cell), shared); }
  void remove(std::uint32_t cell, bool shared = false) { base::fetch_add(sum_, -one(cell), shared); }
  bool none() const { return sum_ == 0; }
  bool single() const { return sum_ >> 32 == 1; }
  std::uint32_t only() const { return static_cast<std::uint32_t>(sum_); }

 private:
  static std::uint64_t one(std::uint32_t cell) { return std::uint64_t{1} << 32 | cell; }
  std::uint64_t sum_;
};

/// An edge or vertex. A cell that has gone has no cofaces, and needs its value no more: in its place is the level, with
/// the sign bit set (values are not negative), so that one look at memory tells all.
struct LiveCell {
  Cofaces cofaces;
  double value;

  void begin(double its_value) {
    cofaces = Cofaces{};
    value = its_value + 0.0;  // no -0
  }
  void go(double level) { value = -std::abs(level); }  // also of -0
  bool gone() const { return std::signbit(value); }
  double level() const { return gone() ? -value : kNever; }
  /// Whether it is there and of a value below the bound (not negative): one comparison, since bits of doubles are in
  /// the order of the doubles, and above all others where the sign is set.
  bool below(double bound) const { return std::bit_cast<std::uint64_t>(value) < std::bit_cast<std::uint64_t>(bound); }
};

/// The cells of a complex that have not gone yet, with what tells which pairs are simple. 16 bytes per vertex and edge,
/// 8 per face.
class LiveCells {
 public:
  /// An array that the threads fill, so that each of them has its share of the page faults.
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

  /// Values are not negative. On all threads.
  LiveCells(const CellComplex& of, std::span<const double> vertex, std::span<const double> edge,
            std::span<const double> face);

  /// The pair whose free cell it is; of key kNever where there is none that can go.
  PairQueue::Entry pair_of_edge(std::uint32_t e) const {
    const LiveCell& edge = edges[e];
    if (!edge.cofaces.single()) return {kNever, 0};
    return {edges_decide ? edge.value : std::max(face_value[edge.cofaces.only()], edge.value), kEdgeIsFree | e};
  }
  /// As above, for keys below the bound. Cofaces of edges of the bound or more are not read.
  PairQueue::Entry pair_of_vertex(std::uint32_t v, double bound = kNever) const {
    const LiveCell& vertex = vertices[v];
    if (!vertex.cofaces.single()) return {kNever, 0};
    const LiveCell& edge = edges[vertex.cofaces.only()];
    return {edge.value < bound && edge.cofaces.none() ? std::max(edge.value, vertex.value) : kNever, v};
  }

  const CellComplex& complex;
  std::span<const double> face_value;
  Array edges, vertices;
  std::vector<double> face_level;  ///< kNever while it is there
  bool edges_decide = false;       ///< no face has a larger value than an edge of it: keys are those of edges
};

}  // namespace quench::complex
