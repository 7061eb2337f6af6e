// SPDX-License-Identifier: Apache-2.0
#include "complex/thinning.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "bucket_queue.h"
#include "parallel.h"
#include "prefetch.h"

namespace quench {
namespace {

// A simple pair is known by its free cell, the edge or vertex whose only larger cell is the other half. Pairs go in the
// order of their keys, then of the dimension of the free cell, then of its index.
constexpr std::uint64_t kEdgeIsFree = std::uint64_t{1} << 32;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// The live larger cells at a cell, as the sum of 2^32 + index: below 2^32 there is none, below 2^33 one, which the low
// half names. Sums may be made in any order, by several threads.
class Cofaces {
 public:
  void add(std::uint32_t cell, bool shared) { fetch_add(sum_, one(cell), shared); }
  void remove(std::uint32_t cell) { sum_ -= one(cell); }
  bool none() const { return sum_ == 0; }
  bool single() const { return sum_ >> 32 == 1; }
  std::uint32_t only() const { return static_cast<std::uint32_t>(sum_); }

 private:
  static std::uint64_t one(std::uint32_t cell) { return std::uint64_t{1} << 32 | cell; }
  std::uint64_t sum_;
};

// An edge or vertex. A cell that has gone has no cofaces, and needs its value no more: in its place is the level, with
// the sign bit set (values are not negative), so that one look at memory tells all.
struct Cell {
  Cofaces cofaces;
  double value;

  void begin(double its_value) {
    cofaces = Cofaces{};
    value = its_value + 0.0;  // no -0
  }
  void go(double level) { value = -std::abs(level); }  // also of -0
  double level() const { return std::signbit(value) ? -value : kInfinity; }
};

class Thinning {
 public:
  Thinning(const CellComplex& complex, std::span<const double> vertex, std::span<const double> edge,
           std::span<const double> face, Context* context, std::string_view stage)
      : complex_(complex),
        face_(face),
        context_(context),
        stage_(stage),
        edges_(complex.edges.size()),
        vertices_(complex.vertex_count),
        face_level_(complex.face_count(), kInfinity),
        // Keys are not negative, and few are far above their mean.
        queue_(0, mean(edge) / 512) {
    count_cofaces(vertex, edge);
    offer_all(edges_.size(), [this](std::uint32_t e) { return pair_of_edge(e); });
    offer_all(vertices_.size(), [this](std::uint32_t v) { return pair_of_vertex(v); });
  }

  void run() {
    const auto total = static_cast<double>(complex_.edges.size() + 1);
    std::size_t removed = 0;
    double running = -kInfinity;
    // Those whose free cell is no longer free were overtaken.
    const auto stale = [this](const Queue::Entry& pair) { return !still_simple(pair.id); };
    const auto fetch = [this](std::uint64_t pair) {
      const auto free = static_cast<std::uint32_t>(pair);
      prefetch(pair & kEdgeIsFree ? &edges_[free] : &vertices_[free]);
    };
    for (Queue::Entry pair{}; queue_.pop(pair, stale, fetch);) {
      prefetch_ahead();
      if (!still_simple(pair.id)) continue;
      if ((++removed & 0xFFFF) == 0) checkpoint(context_, stage_, std::min(1.0, static_cast<double>(removed) / total));
      running = std::max(running, pair.key);
      const auto free = static_cast<std::uint32_t>(pair.id);
      if (pair.id & kEdgeIsFree)
        remove_face(edges_[free].cofaces.only(), free, running);
      else
        remove_edge(vertices_[free].cofaces.only(), free, running);
    }
    checkpoint(context_, stage_, 1);
  }

  CellValues levels() && {
    queue_ = Queue(0, 0);
    CellValues level;
    level.vertex = levels_of(vertices_);
    level.edge = levels_of(edges_);
    level.face = std::move(face_level_);
    return level;
  }

 private:
  using Queue = BucketQueue<std::uint64_t>;

  // An array that the threads fill, so that each of them has its share of the page faults.
  class Cells {
   public:
    explicit Cells(std::size_t size) : size_(size), cells_(std::make_unique_for_overwrite<Cell[]>(size)) {}
    std::size_t size() const { return size_; }
    Cell& operator[](std::size_t i) { return cells_[i]; }
    const Cell& operator[](std::size_t i) const { return cells_[i]; }

   private:
    std::size_t size_;
    std::unique_ptr<Cell[]> cells_;
  };

  static double mean(std::span<const double> values) {
    double sum = 0;
    std::size_t count = 0;
    for (const double v : values)
      if (v < kInfinity) {
        sum += v;
        ++count;
      }
    return count == 0 ? 0 : sum / static_cast<double>(count);
  }

  static std::vector<double> levels_of(Cells& cells) {
    std::vector<double> level(cells.size());
    for_indices(cells.size(), [&](std::size_t i) { level[i] = cells[i].level(); });
    cells = Cells(0);
    return level;
  }

  void count_cofaces(std::span<const double> vertex, std::span<const double> edge) {
    for_indices(edges_.size(), [&](std::size_t e) { edges_[e].begin(edge[e]); });
    for_indices(vertices_.size(), [&](std::size_t v) { vertices_[v].begin(vertex[v]); });
    const bool shared = several_threads();
    std::atomic<bool> edges_decide{true};
    for_indices(face_level_.size(), [&](std::size_t f) {
      bool below = true;
      for (const std::uint32_t e : complex_.sides(f)) {
        edges_[e].cofaces.add(static_cast<std::uint32_t>(f), shared);
        below = below && face_[f] <= edges_[e].value;
      }
      if (!below) edges_decide.store(false, std::memory_order_relaxed);
    });
    edges_decide_ = edges_decide;
    for_indices(edges_.size(), [&](std::size_t e) {
      for (const std::uint32_t v : complex_.edges[e]) vertices_[v].cofaces.add(static_cast<std::uint32_t>(e), shared);
    });
  }

  // The pair whose free cell it is; of infinite key where there is none that can go.
  Queue::Entry pair_of_edge(std::uint32_t e) const {
    const Cell& edge = edges_[e];
    if (!edge.cofaces.single()) return {kInfinity, 0};
    return {edges_decide_ ? edge.value : std::max(face_[edge.cofaces.only()], edge.value), kEdgeIsFree | e};
  }
  Queue::Entry pair_of_vertex(std::uint32_t v) const {
    const Cell& vertex = vertices_[v];
    if (!vertex.cofaces.single()) return {kInfinity, 0};
    const Cell& edge = edges_[vertex.cofaces.only()];
    return {edge.cofaces.none() ? std::max(edge.value, vertex.value) : kInfinity, v};
  }
  void offer(const Queue::Entry& pair) {
    if (pair.key < kInfinity) queue_.push(pair.key, pair.id);
  }
  void offer_edge(std::uint32_t e) { offer(pair_of_edge(e)); }
  void offer_vertex(std::uint32_t v) { offer(pair_of_vertex(v)); }

  // Looking through all cells is for all threads; the queue belongs to one.
  template <class PairOf>
  void offer_all(std::size_t count, const PairOf& pair_of) {
    const std::size_t chunks = chunks_for(count);
    std::vector<std::vector<Queue::Entry>> found(chunks);
    tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
      const auto [first, last] = part_of(count, chunk, chunks);
      for (std::size_t i = first; i < last; ++i)
        if (const Queue::Entry pair = pair_of(static_cast<std::uint32_t>(i)); pair.key < kInfinity)
          found[chunk].push_back(pair);
    });
    for (const auto& pairs : found)
      for (const Queue::Entry& pair : pairs) queue_.push(pair.key, pair.id);
  }

  // Cells that have gone have no cofaces.
  bool still_simple(std::uint64_t pair) const { return cofaces_of(pair).single(); }
  Cofaces cofaces_of(std::uint64_t pair) const {
    const auto free = static_cast<std::uint32_t>(pair);
    return pair & kEdgeIsFree ? edges_[free].cofaces : vertices_[free].cofaces;
  }

  // Waiting for memory is most of the cost: what the next pairs need is fetched step by step.
  void prefetch_ahead() const {
    queue_.peek(20, [this](std::uint64_t pair) {
      const auto free = static_cast<std::uint32_t>(pair);
      if (pair & kEdgeIsFree) {
        prefetch(&edges_[free]);
        prefetch(&complex_.edges[free]);
      } else {
        prefetch(&vertices_[free]);
      }
    });
    queue_.peek(15, [this](std::uint64_t pair) {
      const Cofaces cofaces = cofaces_of(pair);
      if (!cofaces.single()) return;
      if (pair & kEdgeIsFree) {
        prefetch(&complex_.face_offsets[cofaces.only()]);
        prefetch(&face_level_[cofaces.only()]);
        for (const std::uint32_t v : complex_.edges[static_cast<std::uint32_t>(pair)]) prefetch(&vertices_[v]);
      } else {
        prefetch(&edges_[cofaces.only()]);
        prefetch(&complex_.edges[cofaces.only()]);
      }
    });
    queue_.peek(10, [this](std::uint64_t pair) {
      const Cofaces cofaces = cofaces_of(pair);
      if (!cofaces.single()) return;
      if (pair & kEdgeIsFree)
        prefetch(&complex_.face_edges[complex_.face_offsets[cofaces.only()]]);
      else
        for (const std::uint32_t v : complex_.edges[cofaces.only()]) prefetch(&vertices_[v]);
    });
    queue_.peek(5, [this](std::uint64_t pair) {
      const Cofaces cofaces = cofaces_of(pair);
      if ((pair & kEdgeIsFree) && cofaces.single())
        for (const std::uint32_t e : complex_.sides(cofaces.only())) prefetch(&edges_[e]);
    });
  }

  void remove_face(std::uint32_t f, std::uint32_t e, double at) {
    face_level_[f] = at;
    for (const std::uint32_t s : complex_.sides(f)) {
      edges_[s].cofaces.remove(f);
      if (s == e) continue;
      if (edges_[s].cofaces.none())
        for (const std::uint32_t v : complex_.edges[s]) offer_vertex(v);
      else
        offer_edge(s);
    }
    edges_[e].go(at);
    for (const std::uint32_t v : complex_.edges[e]) {
      vertices_[v].cofaces.remove(e);
      offer_vertex(v);
    }
  }

  void remove_edge(std::uint32_t e, std::uint32_t v, double at) {
    const std::uint32_t other = complex_.edges[e][0] == v ? complex_.edges[e][1] : complex_.edges[e][0];
    edges_[e].go(at);
    vertices_[v].cofaces.remove(e);
    vertices_[v].go(at);
    vertices_[other].cofaces.remove(e);
    offer_vertex(other);
  }

  const CellComplex& complex_;
  std::span<const double> face_;
  Context* context_;
  std::string_view stage_;
  Cells edges_, vertices_;
  std::vector<double> face_level_;
  bool edges_decide_ = false;  // no face has a larger value than an edge of it, so keys are those of edges
  Queue queue_;
};

}  // namespace

CellValues thin(const CellComplex& complex, std::span<const double> vertex_value, std::span<const double> edge_value,
                std::span<const double> face_value, Context* context, std::string_view stage) {
  Thinning thinning(complex, vertex_value, edge_value, face_value, context, stage);
  thinning.run();
  return std::move(thinning).levels();
}

}  // namespace quench
