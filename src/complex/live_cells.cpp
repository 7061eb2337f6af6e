// SPDX-License-Identifier: Apache-2.0
#include "complex/live_cells.h"

#include <atomic>

#include "base/parallel.h"

namespace quench::complex {

LiveCells::LiveCells(const CellComplex& of, std::span<const double> vertex, std::span<const double> edge,
                     std::span<const double> face)
    : complex(of),
      face_value(face),
      edges(of.edges.size()),
      vertices(of.vertex_count),
      face_level(of.face_count(), kNever) {
  base::for_indices(edges.size(), [&](std::size_t e) { edges[e].init(edge[e]); });
  base::for_indices(vertices.size(), [&](std::size_t v) { vertices[v].init(vertex[v]); });
  const bool shared = base::several_threads();
  std::atomic<bool> decide{true};
  base::for_indices(face_level.size(), [&](std::size_t f) {
    bool at_most = true;
    for (const std::uint32_t e : complex.sides(f)) {
      edges[e].cofaces.add(static_cast<std::uint32_t>(f), shared);
      at_most = at_most && face[f] <= edges[e].value;
    }
    if (!at_most) decide.store(false, std::memory_order_relaxed);
  });
  edges_decide = decide;
  base::for_indices(edges.size(), [&](std::size_t e) {
    for (const std::uint32_t v : complex.edges[e]) vertices[v].cofaces.add(static_cast<std::uint32_t>(e), shared);
  });
}

}  // namespace quench::complex
