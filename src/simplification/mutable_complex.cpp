// SPDX-License-Identifier: Apache-2.0
#include "simplification/mutable_complex.h"

#include <algorithm>

namespace quench::simplification {
namespace {

void append(std::vector<std::uint32_t>& first, std::vector<std::uint32_t>& last, std::vector<std::uint32_t>& next,
            std::uint32_t v, std::uint32_t slot) {
  next[slot] = kNone;
  (first[v] == kNone ? first[v] : next[last[v]]) = slot;
  last[v] = slot;
}

/// Takes the slots for which lives(slot) does not hold out of a list.
template <class Lives>
void keep_living(std::uint32_t& first, std::uint32_t& last, std::vector<std::uint32_t>& next, const Lives& lives) {
  std::uint32_t* link = &first;
  last = kNone;
  while (*link != kNone) {
    if (lives(*link)) {
      last = *link;
      link = &next[*link];
    } else {
      *link = next[*link];
    }
  }
}

}  // namespace

MutableComplex::MutableComplex(const CellComplex& complex)
    : edges_(complex.edges),
      triangles_(complex.face_count()),
      first_edge_(complex.vertex_count, kNone),
      last_edge_(complex.vertex_count, kNone),
      next_edge_(2 * edges_.size(), kNone),
      first_triangle_(complex.vertex_count, kNone),
      last_triangle_(complex.vertex_count, kNone),
      next_triangle_(3 * triangles_.size(), kNone),
      vertex_lives_(complex.vertex_count, 1),
      left_(complex.vertex_count),
      mark_(complex.vertex_count, 0) {
  for (std::uint32_t e = 0; e < edges_.size(); ++e)
    for (std::uint32_t i = 0; i < 2; ++i) append(first_edge_, last_edge_, next_edge_, edges_[e][i], 2 * e + i);
  for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
    const auto corners = complex.corners(t);
    for (std::uint32_t i = 0; i < 3; ++i) {
      triangles_[t][i] = corners[i];
      append(first_triangle_, last_triangle_, next_triangle_, corners[i], 3 * t + i);
    }
  }
}

void MutableComplex::drop_dead(std::uint32_t v) {
  keep_living(first_edge_[v], last_edge_[v], next_edge_, [&](std::uint32_t slot) { return has_edge(slot / 2); });
  keep_living(first_triangle_[v], last_triangle_[v], next_triangle_,
              [&](std::uint32_t slot) { return has_triangle(slot / 3); });
}

void MutableComplex::mark_neighbours(std::uint32_t v) {
  ++round_;
  for_edges(v, [&](std::uint32_t e) { mark_[other_end(e, v)] = round_; });
}

bool MutableComplex::may_collapse(std::uint32_t e) {
  const std::uint32_t a = edges_[e][0], b = edges_[e][1];
  drop_dead(a);
  drop_dead(b);
  mark_neighbours(a);
  std::size_t common = 0, triangles = 0;
  for_edges(b, [&](std::uint32_t f) { common += mark_[other_end(f, b)] == round_; });
  // Edges that triangles of `v`, without the other end, see: only those between common neighbours can be seen twice.
  const auto seen_from = [&](std::uint32_t v, std::uint32_t other, const auto& take) {
    for_triangles(v, [&](std::uint32_t t) {
      const auto& corners = triangles_[t];
      if (corners[0] == other || corners[1] == other || corners[2] == other) {
        triangles += v == b;
        return;
      }
      const std::uint32_t i = corners[0] == v ? 0 : corners[1] == v ? 1 : 2;
      const std::uint32_t c = corners[(i + 1) % 3], d = corners[(i + 2) % 3];
      if (mark_[c] == round_ && mark_[d] == round_) take(std::array{std::min(c, d), std::max(c, d)});
    });
  };
  seen_.clear();
  seen_from(b, a, [&](const std::array<std::uint32_t, 2>& edge) { seen_.push_back(edge); });
  if (common != triangles) return false;
  if (seen_.empty()) return true;
  bool twice = false;
  seen_from(a, b, [&](const std::array<std::uint32_t, 2>& edge) {
    twice = twice || std::ranges::find(seen_, edge) != seen_.end();
  });
  return !twice;
}

void MutableComplex::collapse(std::uint32_t e, std::uint32_t removed) {
  const std::uint32_t kept = other_end(e, removed);
  mark_neighbours(kept);
  edges_[e][0] = kNone;
  for (std::uint32_t slot = first_edge_[removed]; slot != kNone;) {
    const std::uint32_t next = next_edge_[slot], f = slot / 2;
    if (has_edge(f)) {
      if (mark_[other_end(f, removed)] == round_) {
        edges_[f][0] = kNone;  // the kept vertex has one to that neighbour
      } else {
        edges_[f][slot % 2] = kept;
        append(first_edge_, last_edge_, next_edge_, kept, slot);
      }
    }
    slot = next;
  }
  for (std::uint32_t slot = first_triangle_[removed]; slot != kNone;) {
    const std::uint32_t next = next_triangle_[slot], t = slot / 3;
    if (has_triangle(t)) {
      auto& corners = triangles_[t];
      if (corners[0] == kept || corners[1] == kept || corners[2] == kept) {
        corners[0] = kNone;
      } else {
        corners[slot % 3] = kept;
        append(first_triangle_, last_triangle_, next_triangle_, kept, slot);
      }
    }
    slot = next;
  }
  first_edge_[removed] = last_edge_[removed] = first_triangle_[removed] = last_triangle_[removed] = kNone;
  vertex_lives_[removed] = 0;
  --left_;
  drop_dead(kept);
}

}  // namespace quench::simplification
