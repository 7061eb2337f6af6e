// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>

#include "base/prefetch.h"
#include "complex/live_cells.h"

namespace quench::complex {

/// Collapses simple pairs in key order: the initial ones and those that become free by earlier collapses, until none of
/// finite key is left.
class PairCollapser {
 public:
  /// Keys are about `origin` or larger; `width`: of the buckets of the queue.
  PairCollapser(LiveCells& cells, double origin, double width) : cells_(cells), queue_(origin, width) {}

  void push(const PairQueue::Entry& pair) {
    if (pair.key < kNever) queue_.push(pair.key, pair.id);
  }

  /// Calls step(number of pairs) after every 65536 collapses and at the end.
  template <class Step>
  void run(const Step& step) {
    std::size_t collapsed = 0;
    double level = -kNever;  // the largest key so far
    const auto stale = [this](const PairQueue::Entry& pair) { return !is_free(pair.id); };
    const auto fetch = [this](std::uint64_t pair) {
      const auto free = static_cast<std::uint32_t>(pair);
      base::prefetch(pair & kEdgeIsFree ? &cells_.edges[free] : &cells_.vertices[free]);
    };
    for (PairQueue::Entry pair{}; queue_.pop(pair, stale, fetch);) {
      prefetch_ahead();
      if (!is_free(pair.id)) continue;
      if (++collapsed == kStep) {
        step(collapsed);
        collapsed = 0;
      }
      level = std::max(level, pair.key);
      const auto free = static_cast<std::uint32_t>(pair.id);
      if (pair.id & kEdgeIsFree)
        remove_face(cells_.edges[free].cofaces.only(), free, level);
      else
        remove_edge(cells_.vertices[free].cofaces.only(), free, level);
    }
    step(collapsed);
  }

 private:
  static constexpr std::size_t kStep = std::size_t{1} << 16;

  // Whether the free face of a queued pair is free still; a removed cell has no cofaces.
  bool is_free(std::uint64_t pair) const { return cofaces_of(pair).single(); }
  base::Cofaces cofaces_of(std::uint64_t pair) const {
    const auto free = static_cast<std::uint32_t>(pair);
    return pair & kEdgeIsFree ? cells_.edges[free].cofaces : cells_.vertices[free].cofaces;
  }

  void remove_face(std::uint32_t f, std::uint32_t e, double level) {
    const CellComplex& complex = cells_.complex;
    cells_.face_level[f] = level;
    for (const std::uint32_t s : complex.sides(f)) {
      LiveCell& side = cells_.edges[s];
      side.cofaces.remove(f);
      if (s == e) continue;
      if (side.cofaces.none())
        for (const std::uint32_t v : complex.edges[s]) push(cells_.pair_of_vertex(v));
      else
        push(cells_.pair_of_edge(s));
    }
    cells_.edges[e].remove(level);
    for (const std::uint32_t v : complex.edges[e]) remove_coface(v, e);
  }

  void remove_edge(std::uint32_t e, std::uint32_t v, double level) {
    const auto& ends = cells_.complex.edges[e];
    const std::uint32_t other = ends[0] == v ? ends[1] : ends[0];
    cells_.edges[e].remove(level);
    cells_.vertices[v].cofaces.remove(e);
    cells_.vertices[v].remove(level);
    remove_coface(other, e);
  }

  void remove_coface(std::uint32_t v, std::uint32_t e) {
    cells_.vertices[v].cofaces.remove(e);
    push(cells_.pair_of_vertex(v));
  }

  // Cache misses are most of the cost: what the next pairs need is prefetched in steps, each using what the one before
  // fetched.
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
      const base::Cofaces cofaces = cofaces_of(pair);
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
      const base::Cofaces cofaces = cofaces_of(pair);
      if (!cofaces.single()) return;
      if (pair & kEdgeIsFree)
        base::prefetch(&complex.face_edges[complex.face_offsets[cofaces.only()]]);
      else
        for (const std::uint32_t v : complex.edges[cofaces.only()]) base::prefetch(&cells_.vertices[v]);
    });
    queue_.peek(5, [&](std::uint64_t pair) {
      const base::Cofaces cofaces = cofaces_of(pair);
      if ((pair & kEdgeIsFree) && cofaces.single())
        for (const std::uint32_t e : complex.sides(cofaces.only())) base::prefetch(&cells_.edges[e]);
    });
  }

  LiveCells& cells_;
  PairQueue queue_;
};

}  // namespace quench::complex
