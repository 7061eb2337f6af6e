// SPDX-License-Identifier: Apache-2.0
#include "complex/thinning.h"

#include <algorithm>
#include <limits>
#include <queue>

namespace quench {
namespace {

// A simple pair is known by its free cell: the edge or vertex, whose only larger cell is the other half.
struct Pair {
  double key;
  std::uint32_t dimension : 1;  // of the free cell
  std::uint32_t free : 31;
  bool operator<(const Pair& other) const {  // std::priority_queue gives the largest first
    if (key != other.key) return key > other.key;
    if (dimension != other.dimension) return dimension > other.dimension;
    return free > other.free;
  }
};
static_assert(sizeof(Pair) == 16);

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
        edges_(complex.vertex_count) {
    if (complex.edges.size() >= std::size_t{1} << 31)
      throw Error(ErrorCode::failed, "a complex of more than 2^31 edges cannot be thinned; use a lower resolution");
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
    while (!queue_.empty()) {
      const Pair pair = queue_.top();
      queue_.pop();
      if (!still_simple(pair)) continue;
      if ((++removed & 0xFFFF) == 0) checkpoint(context, stage, std::min(1.0, static_cast<double>(removed) / total));
      running = std::max(running, pair.key);
      if (pair.dimension == 1)
        remove_face(faces_[pair.free].sum, pair.free, running);
      else
        remove_edge(edges_[pair.free].sum, pair.free, running);
    }
    checkpoint(context, stage, 1);
  }

  CellValues level;

 private:
  static bool alive(double cell_level) { return cell_level == std::numeric_limits<double>::infinity(); }

  void offer_edge(std::uint32_t e) {
    if (faces_[e].count == 1) queue_.push({std::max(face_[faces_[e].sum], edge_[e]), 1, e & 0x7FFFFFFFu});
  }
  void offer_vertex(std::uint32_t v) {
    const std::uint32_t e = edges_[v].sum;
    if (edges_[v].count == 1 && faces_[e].count == 0) queue_.push({std::max(edge_[e], vertex_[v]), 0, v & 0x7FFFFFFFu});
  }

  bool still_simple(const Pair& p) const {
    if (p.dimension == 1) return alive(level.edge[p.free]) && faces_[p.free].count == 1;
    return alive(level.vertex[p.free]) && edges_[p.free].count == 1;
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
  std::priority_queue<Pair> queue_;
};

}  // namespace

CellValues thin(const CellComplex& complex, std::span<const double> vertex_value, std::span<const double> edge_value,
                std::span<const double> face_value, Context* context, std::string_view stage) {
  Thinning thinning(complex, vertex_value, edge_value, face_value);
  thinning.run(context, stage);
  return std::move(thinning.level);
}

}  // namespace quench
