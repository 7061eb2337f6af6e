// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/cofaces.h"

namespace quench::base {

/// Peels a graph: removes edges at vertices of degree 1, and those whose vertices then have degree 1, where the caller
/// allows it. Also one dimension up: faces with a free edge, where "vertices" are edges and "edges" faces. Which edges
/// are removed does not depend on the order unless the caller's rule changes. O(1) per edge, 8 bytes per vertex.
///
/// `ends_of(e)` is a range of the vertices of edge e, a loop's twice; `may_remove(v, e)` says whether edge e may be
/// removed at its free vertex v; `removed(v, e)` is told that it was.
class GraphPeeler {
 public:
  explicit GraphPeeler(std::size_t vertices = 0) { reset(vertices); }
  /// A graph without edges.
  void reset(std::size_t vertices) { edges_at_.assign(vertices, {}); }

  /// Adds an edge at one of its ends.
  void add(std::uint32_t v, std::uint32_t e) { edges_at_[v].add(e); }
  std::size_t vertex_count() const { return edges_at_.size(); }
  const Cofaces& edges_at(std::uint32_t v) const { return edges_at_[v]; }

  /// Removes edge e, free or not, then peels from its vertices.
  template <class EndsOf, class MayRemove, class Removed>
  void remove(std::uint32_t e, const EndsOf& ends_of, const MayRemove& may_remove, const Removed& removed) {
    free_.clear();
    detach(e, ends_of);
    while (!free_.empty()) {
      const std::uint32_t v = free_.back();
      free_.pop_back();
      if (!edges_at_[v].single()) continue;  // its last edge was removed from the other end
      const std::uint32_t edge = edges_at_[v].only();
      if (!may_remove(v, edge)) continue;
      removed(v, edge);
      detach(edge, ends_of);
    }
  }

  /// Peels from every vertex in turn.
  template <class EndsOf, class MayRemove, class Removed>
  void peel(const EndsOf& ends_of, const MayRemove& may_remove, const Removed& removed) {
    for (std::uint32_t v = 0; v < edges_at_.size(); ++v) {
      if (!edges_at_[v].single()) continue;
      const std::uint32_t e = edges_at_[v].only();
      if (!may_remove(v, e)) continue;
      removed(v, e);
      remove(e, ends_of, may_remove, removed);
    }
  }

 private:
  template <class EndsOf>
  void detach(std::uint32_t e, const EndsOf& ends_of) {
    for (const std::uint32_t v : ends_of(e)) {
      edges_at_[v].remove(e);
      if (edges_at_[v].single()) free_.push_back(v);
    }
  }

  std::vector<Cofaces> edges_at_;
  std::vector<std::uint32_t> free_;  // vertices that may have become free
};

}  // namespace quench::base
