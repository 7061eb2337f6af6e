// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <queue>
#include <span>
#include <utility>
#include <vector>

#include "base/constants.h"
#include "base/csr.h"
#include "quench/axis.h"

namespace quench::axis {

/// Shortest paths along the edges of a medial axis (Dijkstra 1959) from many sources, for searches that stay near them.
/// Lengths are whole multiples of `unit`, so that paths of one length are ties whatever the rounding of coordinates;
/// ties go to the vertex of smaller index.
class ShortestPaths {
 public:
  ShortestPaths(const MedialAxis& axis, double unit)
      : axis_(axis),
        per_unit_(1 / unit),
        edges_at_(base::Csr<std::uint32_t>::group(axis.complex.vertex_count,
                                                  [&](const auto& emit) {
                                                    for (std::uint32_t e = 0; e < axis.complex.edges.size(); ++e)
                                                      for (const std::uint32_t v : axis.complex.edges[e]) emit(v, e);
                                                  })),
        distance_(axis.complex.vertex_count, base::kNever),
        came_by_(axis.complex.vertex_count, kNone),
        source_(axis.complex.vertex_count, kNone),
        settled_(axis.complex.vertex_count, 0) {}

  /// Forgets sources and what was reached. What is farther away than `longest` is not reached from now on.
  void restart(double longest) {
    longest_ = std::round(longest * per_unit_);
    for (const std::uint32_t v : reached_) {
      distance_[v] = base::kNever;
      came_by_[v] = kNone;
      settled_[v] = 0;
    }
    reached_.clear();
    queue_ = {};
  }
  /// `distance`: that it begins with.
  void add_source(std::uint32_t vertex, double distance = 0) { reach(vertex, distance, kNone, vertex); }
  /// The next nearest vertex; kNone when all are reached. Its neighbours are reached by it unless `stop(vertex)`.
  template <class Stop>
  std::uint32_t next(const Stop& stop) {
    while (!queue_.empty()) {
      const auto [distance, v] = queue_.top();
      queue_.pop();
      if (distance > distance_[v] || settled_[v]) continue;
      settled_[v] = 1;
      if (!stop(v))
        for (const std::uint32_t e : edges_at_[v]) {
          const std::uint32_t w = other_end(e, v);
          reach(w, distance + length(e), e, source_[v]);
        }
      return v;
    }
    return kNone;
  }

  std::span<const std::uint32_t> edges_at(std::uint32_t vertex) const { return edges_at_[vertex]; }
  std::uint32_t other_end(std::uint32_t edge, std::uint32_t vertex) const {
    const auto [a, b] = axis_.complex.edges[edge];
    return a == vertex ? b : a;
  }
  /// In units, as all lengths here.
  double length(std::uint32_t edge) const {
    const auto [a, b] = axis_.complex.edges[edge];
    return std::round((axis_.points[a] - axis_.points[b]).norm() * per_unit_);
  }
  std::size_t vertex_count() const { return distance_.size(); }
  double longest() const { return longest_; }
  /// Of a vertex that is reached, from the source.
  double distance(std::uint32_t vertex) const { return distance_[vertex]; }
  /// Calls visit(edge, next vertex) along the path from a reached vertex back to its source.
  template <class Visit>
  void walk_back(std::uint32_t vertex, const Visit& visit) const {
    while (came_by_[vertex] != kNone) {
      const std::uint32_t e = came_by_[vertex];
      vertex = other_end(e, vertex);
      visit(e, vertex);
    }
  }
  /// Whether next() has returned the vertex.
  bool is_settled(std::uint32_t vertex) const { return settled_[vertex] != 0; }
  /// The source that a reached vertex is nearest to.
  std::uint32_t source_of(std::uint32_t vertex) const { return source_[vertex]; }

 private:
  void reach(std::uint32_t v, double distance, std::uint32_t by, std::uint32_t source) {
    if (!(distance < distance_[v]) || distance > longest_) return;
    if (distance_[v] == base::kNever) reached_.push_back(v);
    source_[v] = source;
    distance_[v] = distance;
    came_by_[v] = by;
    queue_.push({distance, v});
  }

  const MedialAxis& axis_;
  double per_unit_, longest_ = 0;
  base::Csr<std::uint32_t> edges_at_;
  std::vector<double> distance_;        // so far
  std::vector<std::uint32_t> came_by_;  // the edge; kNone for sources
  std::vector<std::uint32_t> source_;
  std::vector<char> settled_;
  std::vector<std::uint32_t> reached_;
  using Entry = std::pair<double, std::uint32_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue_;
};

}  // namespace quench::axis
