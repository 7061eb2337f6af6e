// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>

#include "base/prefetch.h"
#include "complex/live_cells.h"

namespace quench::complex {

/// Removes simple pairs of keys below a bound, in order, until none is left: of the pairs that were offered, and of
/// those that their removal lays free.
///
/// Several may work on the same cells at a time, each on components of its own (thinning_in_slabs.h): cells of the
/// bound or more, which they share, lose cofaces, and only their values are read.
class Removal {
 public:
  /// `width`: of the queue's buckets.
  Removal(LiveCells& cells, double origin, double width, double bound, bool shared)
      : cells_(cells), bound_(bound), shared_(shared), queue_(origin, width) {}

  void offer(const PairQueue::Entry& pair) {
    if (pair.key < bound_) queue_.push(pair.key, pair.id);
  }

  /// Calls step(number of pairs) after every 65536 of them and at the end; stops if it returns false, and returns that.
  template <class Step>
  bool run(const Step& step) {
    std::size_t removed = 0;
    double running = -kNever;
    // Those whose free cell is no longer free were overtaken.
    const auto stale = [this](const PairQueue::Entry& pair) { return !still_simple(pair.id); };
    const auto fetch = [this](std::uint64_t pair) {
      const auto free = static_cast<std::uint32_t>(pair);
      base::prefetch(pair & kEdgeIsFree ? &cells_.edges[free] : &cells_.vertices[free]);
    };
    for (PairQueue::Entry pair{}; queue_.pop(pair, stale, fetch);) {
      prefetch_ahead();
      if (!still_simple(pair.id)) continue;
      if (++removed == kStep) {
        if (!step(removed)) return false;
        removed = 0;
      }
      running = std::max(running, pair.key);
      const auto free = static_cast<std::uint32_t>(pair.id);
      if (pair.id & kEdgeIsFree)
        remove_face(cells_.edges[free].cofaces.only(), free, running);
      else
        remove_edge(cells_.vertices[free].cofaces.only(), free, running);
    }
    return step(removed);
  }

 private:
  static constexpr std::size_t kStep = std::size_t{1} << 16;

  // Cells that have gone have no cofaces.
  bool still_simple(std::uint64_t pair) const { return cofaces_of(pair).single(); }
  Cofaces cofaces_of(std::uint64_t pair) const {
    const auto free = static_cast<std::uint32_t>(pair);
    return pair & kEdgeIsFree ? cells_.edges[free].cofaces : cells_.vertices[free].cofaces;
  }

  void remove_face(std::uint32_t f, std::uint32_t e, double at) {
    const CellComplex& complex = cells_.complex;
    cells_.face_level[f] = at;
    for (const std::uint32_t s : complex.sides(f)) {
      LiveCell& side = cells_.edges[s];
      if (!(side.value < bound_)) {
        side.cofaces.remove(f, shared_);
        continue;
      }
      side.cofaces.remove(f);
      if (s == e) continue;
      if (side.cofaces.none())
        for (const std::uint32_t v : complex.edges[s]) offer_vertex(v);
      else
        offer(cells_.pair_of_edge(s));
    }
    cells_.edges[e].go(at);
    for (const std::uint32_t v : complex.edges[e]) leave(v, e);
  }

  void remove_edge(std::uint32_t e, std::uint32_t v, double at) {
    const auto& ends = cells_.complex.edges[e];
    const std::uint32_t other = ends[0] == v ? ends[1] : ends[0];
    cells_.edges[e].go(at);
    cells_.vertices[v].cofaces.remove(e);
    cells_.vertices[v].go(at);
    leave(other, e);
  }

  // The vertex loses the edge.
  void leave(std::uint32_t v, std::uint32_t e) {
    LiveCell& vertex = cells_.vertices[v];
    if (!(vertex.value < bound_)) {
      vertex.cofaces.remove(e, shared_);
      return;
    }
    vertex.cofaces.remove(e);
    offer(cells_.pair_of_vertex(v, bound_));
  }

  void offer_vertex(std::uint32_t v) {
    if (cells_.vertices[v].value < bound_) offer(cells_.pair_of_vertex(v, bound_));
  }

  // Waiting for memory is most of the cost: what the next pairs need is fetched step by step.
  void prefetch_ahead() const {
    const CellComplex& complex = cells_.complex;
    queue_.peek(20, [&](std::uint64_t pair) {
      const auto free = static_cast<std::uint32_t>(pair);
      if (pair & kEdgeIsFree) {
        base::prefetch(&cells_.edges[free]);
        base::prefetch(&complex.edges[free]);
      } else {
        base::prefetch(&cells_.vertices[free]);
      }
    });
    queue_.peek(15, [&](std::uint64_t pair) {
      const Cofaces cofaces = cofaces_of(pair);
      if (!cofaces.single()) return;
      if (pair & kEdgeIsFree) {
        base::prefetch(&complex.face_offsets[cofaces.only()]);
        base::prefetch(&cells_.face_level[cofaces.only()]);
        for (const std::uint32_t v : complex.edges[static_cast<std::uint32_t>(pair)])
          base::prefetch(&cells_.vertices[v]);
      } else {
        base::prefetch(&cells_.edges[cofaces.only()]);
        base::prefetch(&complex.edges[cofaces.only()]);
      }
    });
    queue_.peek(10, [&](std::uint64_t pair) {
      const Cofaces cofaces = cofaces_of(pair);
      if (!cofaces.single()) return;
      if (pair & kEdgeIsFree)
        base::prefetch(&complex.face_edges[complex.face_offsets[cofaces.only()]]);
      else
        for (const std::uint32_t v : complex.edges[cofaces.only()]) base::prefetch(&cells_.vertices[v]);
    });
    queue_.peek(5, [&](std::uint64_t pair) {
      const Cofaces cofaces = cofaces_of(pair);
      if ((pair & kEdgeIsFree) && cofaces.single())
        for (const std::uint32_t e : complex.sides(cofaces.only())) base::prefetch(&cells_.edges[e]);
    });
  }

  LiveCells& cells_;
  double bound_;
  bool shared_;
  PairQueue queue_;
};

}  // namespace quench::complex
