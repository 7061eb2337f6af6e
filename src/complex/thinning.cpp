// SPDX-License-Identifier: Apache-2.0
#include "complex/thinning.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <utility>

#include "base/parallel.h"
#include "complex/live_cells.h"
#include "complex/pair_collapser.h"

namespace quench::complex {
namespace {

double mean(std::span<const double> values) {
  double sum = 0;
  std::size_t count = 0;
  for (const double v : values)
    if (v < kNever) {
      sum += v;
      ++count;
    }
  return count == 0 ? 0 : sum / static_cast<double>(count);
}

// Looks for initial pairs in parallel; the queue is not shared between threads.
template <class PairOf>
void push_all(std::size_t count, const PairOf& pair_of, PairCollapser& collapser) {
  const std::size_t chunks = base::chunks_for(count);
  std::vector<std::vector<PairQueue::Entry>> found(chunks);
  tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
    const auto [first, last] = base::part_of(count, chunk, chunks);
    for (std::size_t i = first; i < last; ++i)
      if (const PairQueue::Entry pair = pair_of(static_cast<std::uint32_t>(i)); pair.key < kNever)
        found[chunk].push_back(pair);
  });
  for (const auto& pairs : found)
    for (const PairQueue::Entry& pair : pairs) collapser.push(pair);
}

std::vector<double> levels_of(LiveCells::Array& cells) {
  std::vector<double> level(cells.size());
  base::for_indices(cells.size(), [&](std::size_t i) { level[i] = cells[i].level(); });
  cells = LiveCells::Array(0);
  return level;
}

}  // namespace

CellValues thin(const CellComplex& complex, std::span<const double> vertex_value, std::span<const double> edge_value,
                std::span<const double> face_value, Context* context, std::string_view stage) {
  LiveCells cells(complex, vertex_value, edge_value, face_value);
  std::size_t collapsed = 0;
  const auto step = [&](std::size_t more) {
    collapsed += more;
    checkpoint(context, stage,
               std::min(1.0, static_cast<double>(collapsed) / static_cast<double>(complex.edges.size() + 1)));
  };
  step(0);
  {
    // Keys are not negative, and few are far above their mean.
    PairCollapser collapser(cells, 0, mean(edge_value) / 512);
    push_all(
        cells.edges.size(), [&](std::uint32_t e) { return cells.pair_of_edge(e); }, collapser);
    push_all(
        cells.vertices.size(), [&](std::uint32_t v) { return cells.pair_of_vertex(v); }, collapser);
    collapser.run(step);
  }
  checkpoint(context, stage, 1);

  CellValues level;
  level.face = std::move(cells.face_level);
  level.vertex = levels_of(cells.vertices);
  level.edge = levels_of(cells.edges);
  return level;
}

}  // namespace quench::complex
