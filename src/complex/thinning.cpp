// SPDX-License-Identifier: Apache-2.0
#include "complex/thinning.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "bucket_queue.h"
#include "prefetch.h"

namespace quench {
namespace {

// A simple pair is known by its free cell, the edge or vertex whose only larger cell is the other half. Pairs go in the
// order of their keys, then of the dimension of the free cell, then of its index.
constexpr std::uint64_t kEdgeIsFree = std::uint64_t{1} << 32;

// The number of live larger cells at a cell, and their XOR: with number 1 that is the only one.
struct Cofaces {
  std::uint32_t count = 0, sum = 0;
  void add(std::uint32_t cell) { ++count, sum ^= cell; }
  void remove(std::uint32_t cell) { --count, sum ^= cell; }
};

class Thinning {
 public:
  Thinning(const CellComplex& complex, std::span<const double> vertex, std::span<const double> edge,
           std::span<const double> face)
      : complex_(complex),
        vertex_(vertex),
        edge_(edge),
        face_(face),
        faces_(complex.edges.size()),
        edges_(complex.vertex_count),
        // Keys are not negative, and few are far above their mean.
        queue_(0, mean(edge) / 512) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    level.vertex.assign(complex.vertex_count, infinity);
    level.edge.assign(complex.edges.size(), infinity);
    level.face.assign(complex.face_count(), infinity);
    for (std::uint32_t f = 0; f < complex.face_count(); ++f)
      for (std::uint32_t e : complex.sides(f)) faces_[e].add(f);
    for (std::uint32_t e = 0; e < complex.edges.size(); ++e)
      for (std::uint32_t v : complex.edges[e]) edges_[v].add(e);
    for (std::uint32_t e = 0; e < complex.edges.size(); ++e) offer_edge(e);
    for (std::uint32_t v = 0; v < complex.vertex_count; ++v) offer_vertex(v);
  }

  void run(Context* context, std::string_view stage) {
    const auto total = static_cast<double>(complex_.edges.size() + 1);
    std::size_t removed = 0;
    double running = -std::numeric_limits<double>::infinity();
    // Those whose free cell is no longer free were overtaken.
    const auto stale = [this](const Queue::Entry& pair) { return !still_simple(pair.id); };
    for (Queue::Entry pair{}; queue_.pop(pair, stale);) {
      prefetch_ahead();
      if (!still_simple(pair.id)) continue;
      if ((++removed & 0xFFFF) == 0) checkpoint(context, stage, std::min(1.0, static_cast<double>(removed) / total));
      running = std::max(running, pair.key);
      const auto free = static_cast<std::uint32_t>(pair.id);
      if (pair.id & kEdgeIsFree)
        remove_face(faces_[free].sum, free, running);
      else
        remove_edge(edges_[free].sum, free, running);
    }
    checkpoint(context, stage, 1);
  }

  CellValues level;

 private:
  static double mean(std::span<const double> values) {
    double sum = 0;
    std::size_t count = 0;
    for (const double v : values)
      if (v < std::numeric_limits<double>::infinity()) {
        sum += v;
        ++count;
      }
    return count == 0 ? 0 : sum / static_cast<double>(count);
  }
  static bool alive(double cell_level) { return cell_level == std::numeric_limits<double>::infinity(); }

  void offer(double key, std::uint64_t pair) {
    if (key < std::numeric_limits<double>::infinity()) queue_.push(key, pair);
  }
  void offer_edge(std::uint32_t e) {
    if (faces_[e].count == 1) offer(std::max(face_[faces_[e].sum], edge_[e]), kEdgeIsFree | e);
  }
  void offer_vertex(std::uint32_t v) {
    const std::uint32_t e = edges_[v].sum;
    if (edges_[v].count == 1 && faces_[e].count == 0) offer(std::max(edge_[e], vertex_[v]), v);
  }

  bool still_simple(std::uint64_t pair) const {
    const auto free = static_cast<std::uint32_t>(pair);
    if (pair & kEdgeIsFree) return faces_[free].count == 1 && alive(level.edge[free]);
    return edges_[free].count == 1 && alive(level.vertex[free]);
  }

  // Waiting for memory is most of the cost: what the next pairs need is fetched in two steps.
  void prefetch_ahead() const {
    queue_.peek(12, [this](std::uint64_t pair) {
      const auto free = static_cast<std::uint32_t>(pair);
      if (pair & kEdgeIsFree) {
        prefetch(&faces_[free]);
        prefetch(&level.edge[free]);
        prefetch(&complex_.edges[free]);
      } else {
        prefetch(&edges_[free]);
      }
    });
    queue_.peek(8, [this](std::uint64_t pair) {
      const auto free = static_cast<std::uint32_t>(pair);
      if (!(pair & kEdgeIsFree) || faces_[free].count != 1) return;
      prefetch(&complex_.face_offsets[faces_[free].sum]);
      prefetch(&level.face[faces_[free].sum]);
      for (const std::uint32_t v : complex_.edges[free]) prefetch(&edges_[v]);
    });
    queue_.peek(4, [this](std::uint64_t pair) {
      const auto free = static_cast<std::uint32_t>(pair);
      if ((pair & kEdgeIsFree) && faces_[free].count == 1)
        for (const std::uint32_t e : complex_.sides(faces_[free].sum)) prefetch(&faces_[e]);
    });
  }

  void remove_face(std::uint32_t f, std::uint32_t e, double at) {
    level.face[f] = level.edge[e] = at;
    for (std::uint32_t s : complex_.sides(f)) {
      faces_[s].remove(f);
      if (s == e) continue;
      offer_edge(s);
      if (faces_[s].count == 0)
        for (std::uint32_t v : complex_.edges[s]) offer_vertex(v);
    }
    for (std::uint32_t v : complex_.edges[e]) {
      edges_[v].remove(e);
      offer_vertex(v);
    }
  }

  void remove_edge(std::uint32_t e, std::uint32_t v, double at) {
    level.edge[e] = level.vertex[v] = at;
    const std::uint32_t other = complex_.edges[e][0] == v ? complex_.edges[e][1] : complex_.edges[e][0];
    edges_[v].remove(e);
    edges_[other].remove(e);
    offer_vertex(other);
  }

  const CellComplex& complex_;
  std::span<const double> vertex_, edge_, face_;
  std::vector<Cofaces> faces_;  // per edge
  std::vector<Cofaces> edges_;  // per vertex
  using Queue = BucketQueue<std::uint64_t>;
  Queue queue_;
};

}  // namespace

CellValues thin(const CellComplex& complex, std::span<const double> vertex_value, std::span<const double> edge_value,
                std::span<const double> face_value, Context* context, std::string_view stage) {
  Thinning thinning(complex, vertex_value, edge_value, face_value);
  thinning.run(context, stage);
  return std::move(thinning.level);
}

}  // namespace quench
