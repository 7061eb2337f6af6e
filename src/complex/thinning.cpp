// SPDX-License-Identifier: Apache-2.0
#include "complex/thinning.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <numeric>
#include <vector>

namespace quench {
namespace {

__extension__ using UInt128 = unsigned __int128;

// A simple pair is known by its free cell, the edge or vertex whose only larger cell is the other half. One integer
// holds (key, dimension of the free cell, its index) in the order in which pairs go: keys are not negative, and the
// bits of such doubles grow with them.
struct Pair {
  UInt128 order = 0;

  Pair() = default;
  Pair(double key, std::uint32_t dimension, std::uint32_t free)
      : order(static_cast<UInt128>(std::bit_cast<std::uint64_t>(key + 0.0)) << 64 | std::uint64_t{dimension} << 32 |
              free) {}
  double key() const { return std::bit_cast<double>(static_cast<std::uint64_t>(order >> 64)); }
  std::uint32_t dimension() const { return static_cast<std::uint32_t>(order >> 32); }
  std::uint32_t free() const { return static_cast<std::uint32_t>(order); }
  bool operator<(const Pair& other) const { return order > other.order; }  // heaps give the largest first
};

// A priority queue whose entries are spread over buckets of growing keys, each a small heap that stays in the cache.
// Any monotone map of keys to buckets gives the same order.
class PairQueue {
 public:
  // `typical`: a key of the middle of the range; keys far above it share the last bucket.
  explicit PairQueue(double typical) : scale_(typical > 0 ? kBuckets / (8 * typical) : 0), buckets_(kBuckets) {}

  void push(const Pair& pair) {
    const double place = pair.key() * scale_;
    const std::size_t b = place < kBuckets - 1 ? static_cast<std::size_t>(place) : kBuckets - 1;
    buckets_[b].push_back(pair);
    // The buckets that are not yet due are unsorted: they become heaps when their turn comes.
    if (b < heaps_) std::push_heap(buckets_[b].begin(), buckets_[b].end());
    first_ = std::min(first_, b);
  }
  bool pop(Pair& pair) {
    while (first_ < kBuckets && buckets_[first_].empty()) ++first_;
    if (first_ == kBuckets) return false;
    auto& bucket = buckets_[first_];
    for (; heaps_ <= first_; ++heaps_) std::make_heap(buckets_[heaps_].begin(), buckets_[heaps_].end());
    std::pop_heap(bucket.begin(), bucket.end());
    pair = bucket.back();
    bucket.pop_back();
    return true;
  }

 private:
  static constexpr std::size_t kBuckets = 4096;
  double scale_;
  std::size_t first_ = kBuckets, heaps_ = 0;  // buckets below heaps_ are heaps
  std::vector<std::vector<Pair>> buckets_;
};

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
        queue_(mean(edge)) {
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
    for (Pair pair{}; queue_.pop(pair);) {
      if (!still_simple(pair)) continue;
      if ((++removed & 0xFFFF) == 0) checkpoint(context, stage, std::min(1.0, static_cast<double>(removed) / total));
      running = std::max(running, pair.key());
      if (pair.dimension() == 1)
        remove_face(faces_[pair.free()].sum, pair.free(), running);
      else
        remove_edge(edges_[pair.free()].sum, pair.free(), running);
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

  void offer(double key, std::uint32_t dimension, std::uint32_t free) {
    if (key < std::numeric_limits<double>::infinity()) queue_.push({key, dimension, free});
  }
  void offer_edge(std::uint32_t e) {
    if (faces_[e].count == 1) offer(std::max(face_[faces_[e].sum], edge_[e]), 1, e);
  }
  void offer_vertex(std::uint32_t v) {
    const std::uint32_t e = edges_[v].sum;
    if (edges_[v].count == 1 && faces_[e].count == 0) offer(std::max(edge_[e], vertex_[v]), 0, v);
  }

  bool still_simple(const Pair& p) const {
    if (p.dimension() == 1) return alive(level.edge[p.free()]) && faces_[p.free()].count == 1;
    return alive(level.vertex[p.free()]) && edges_[p.free()].count == 1;
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
  PairQueue queue_;
};

}  // namespace

CellValues thin(const CellComplex& complex, std::span<const double> vertex_value, std::span<const double> edge_value,
                std::span<const double> face_value, Context* context, std::string_view stage) {
  Thinning thinning(complex, vertex_value, edge_value, face_value);
  thinning.run(context, stage);
  return std::move(thinning.level);
}

}  // namespace quench
