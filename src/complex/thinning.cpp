// SPDX-License-Identifier: Apache-2.0
#include "complex/thinning.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <thread>
#include <utility>

#include "base/parallel.h"
#include "complex/live_cells.h"
#include "complex/removal.h"
#include "complex/thinning_in_slabs.h"

namespace quench::complex {
namespace {

constexpr std::size_t kEdgesOfASlab = std::size_t{1} << 16;  // fewer are not worth a thread

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

// Looking through all cells is for all threads; the queue belongs to one.
template <class PairOf>
void offer_all(std::size_t count, const PairOf& pair_of, Removal& removal) {
  const std::size_t chunks = base::chunks_for(count);
  std::vector<std::vector<PairQueue::Entry>> found(chunks);
  tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
    const auto [first, last] = base::part_of(count, chunk, chunks);
    for (std::size_t i = first; i < last; ++i)
      if (const PairQueue::Entry pair = pair_of(static_cast<std::uint32_t>(i)); pair.key < kNever)
        found[chunk].push_back(pair);
  });
  for (const auto& pairs : found)
    for (const PairQueue::Entry& pair : pairs) removal.offer(pair);
}

std::vector<double> levels_of(LiveCells::Array& cells) {
  std::vector<double> level(cells.size());
  base::for_indices(cells.size(), [&](std::size_t i) { level[i] = cells[i].level(); });
  cells = LiveCells::Array(0);
  return level;
}

}  // namespace

CellValues thin(const CellComplex& complex, std::span<const double> vertex_value, std::span<const double> edge_value,
                std::span<const double> face_value, Context* context, std::string_view stage,
                const ThinningOptions& options) {
  LiveCells cells(complex, vertex_value, edge_value, face_value);
  const auto caller = std::this_thread::get_id();
  std::atomic<std::size_t> removed{0};
  const auto tell = [&] {
    checkpoint(context, stage,
               std::min(1.0, static_cast<double>(removed) / static_cast<double>(complex.edges.size() + 1)));
  };
  const auto step = [&](std::size_t more) {
    removed += more;
    if (std::this_thread::get_id() != caller) return !(context && context->cancelled());  // the caller throws
    tell();
    return true;
  };
  // Keys are not negative, and few are far above their mean.
  const double width = mean(edge_value) / 512;

  const auto threads = static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
  const std::size_t slabs = options.slabs > 0 ? options.slabs : std::min(threads, complex.edges.size() / kEdgesOfASlab);
  double bound = 0;
  if (slabs > 1) bound = thin_in_slabs(cells, slabs, options.most_crossing, width, step);
  tell();
  {
    Removal removal(cells, bound, width, kNever, false);
    offer_all(
        cells.edges.size(), [&](std::uint32_t e) { return cells.pair_of_edge(e); }, removal);
    offer_all(
        cells.vertices.size(), [&](std::uint32_t v) { return cells.pair_of_vertex(v); }, removal);
    removal.run(step);
  }
  checkpoint(context, stage, 1);

  CellValues level;
  level.face = std::move(cells.face_level);
  level.vertex = levels_of(cells.vertices);
  level.edge = levels_of(cells.edges);
  return level;
}

}  // namespace quench::complex
