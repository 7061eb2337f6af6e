// SPDX-License-Identifier: Apache-2.0
#include "burning/blocks.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace quench::burning {
namespace {

// Space is divided into 64 x 64 x 64 cells, numbered along a Z-order curve (Morton 1966).
constexpr int kBits = 6;
constexpr std::uint32_t kCells = 1u << (3 * kBits);

std::uint32_t cell_of(const std::array<std::uint32_t, 3>& at) {
  std::uint32_t cell = 0;
  for (int bit = kBits - 1; bit >= 0; --bit)
    for (const std::uint32_t x : at) cell = cell << 1 | (x >> bit & 1);
  return cell;
}

std::vector<std::uint32_t> cells_of(std::span<const Vec3> points) {
  std::vector<std::uint32_t> cells(points.size(), 0);
  if (points.empty()) return cells;
  Vec3 low = points[0], high = points[0];
  for (const Vec3& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const double size = (high - low).maxCoeff();
  if (!(size > 0) || std::isinf(size)) return cells;
  for (std::size_t v = 0; v < points.size(); ++v) {
    std::array<std::uint32_t, 3> at{};
    for (int axis = 0; axis < 3; ++axis)
      at[static_cast<std::size_t>(axis)] =
          static_cast<std::uint32_t>(std::min((points[v][axis] - low[axis]) / size * (1 << kBits), (1 << kBits) - 1.0));
    cells[v] = cell_of(at);
  }
  return cells;
}

}  // namespace

Blocks make_blocks(const CellComplex& complex, std::span<const Vec3> points, const BurnNetwork& network,
                   std::uint64_t states) {
  Blocks blocks;
  const std::uint64_t all = network.state_count();
  blocks.of_state.assign(all, 0);
  if (all <= states) return blocks;
  const std::uint64_t size = std::max(states, all / 0x8000);  // leaves room for cells that overfill their block

  const std::vector<std::uint32_t> cells = cells_of(points);
  std::vector<std::uint32_t> filled(kCells, 0);  // states per cell, then the cell's block
  for (std::uint32_t v = 0; v < complex.vertex_count; ++v)
    filled[cells[v]] += network.vertex_base[v + 1] - network.vertex_base[v];
  for (std::uint32_t e = 0; e < complex.edges.size(); ++e)
    filled[cells[complex.edges[e][0]]] += network.state_base[e + 1] - network.state_base[e];
  std::uint64_t before = 0;
  for (std::uint32_t& cell : filled) {
    const std::uint64_t here = cell;
    cell = static_cast<std::uint32_t>(before / size);
    before += here;
  }
  blocks.count = static_cast<std::uint32_t>((all - 1) / size) + 1;

  const auto set = [&](const std::vector<std::uint32_t>& base, std::size_t i, std::uint32_t v) {
    std::fill(blocks.of_state.begin() + base[i], blocks.of_state.begin() + base[i + 1],
              static_cast<std::uint16_t>(filled[cells[v]]));
  };
  for (std::uint32_t v = 0; v < complex.vertex_count; ++v) set(network.vertex_base, v, v);
  for (std::size_t e = 0; e < complex.edges.size(); ++e) set(network.state_base, e, complex.edges[e][0]);
  return blocks;
}

}  // namespace quench::burning
