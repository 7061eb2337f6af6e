// SPDX-License-Identifier: Apache-2.0
#include "burning/blocks.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/z_order.h"
#include "burning/label_queue.h"

namespace quench::burning {
namespace {

// Space is divided into 64 x 64 x 64 boxes, numbered along a Z-order curve.
constexpr int kBits = 6;
constexpr std::uint32_t kBoxes = 1u << (3 * kBits);

std::vector<std::uint32_t> boxes_of(std::span<const Vec3> points) {
  std::vector<std::uint32_t> boxes(points.size(), 0);
  if (points.empty()) return boxes;
  Vec3 low = points[0], high = points[0];
  for (const Vec3& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const double size = (high - low).maxCoeff();
  if (!(size > 0) || std::isinf(size)) return boxes;
  for (std::size_t v = 0; v < points.size(); ++v) {
    std::array<std::uint32_t, 3> at{};
    for (int axis = 0; axis < 3; ++axis)
      at[static_cast<std::size_t>(axis)] =
          static_cast<std::uint32_t>(std::min((points[v][axis] - low[axis]) / size * (1 << kBits), (1 << kBits) - 1.0));
    boxes[v] = static_cast<std::uint32_t>(base::z_order(at[0], at[1], at[2]));
  }
  return boxes;
}

// Pairs of blocks, numbers combined, that must not be processed at the same time. Fire from a block writes to all nodes
// of the polygons at its states: two blocks are too near to each other if a vertex lies in such polygons of both.
std::vector<std::uint64_t> near_pairs(const CellComplex& complex, const std::vector<std::uint32_t>& block_of_vertex) {
  std::vector<std::uint64_t> reached;  // (vertex, block): where a polygon at the vertex is not of its block alone
  std::vector<std::uint32_t> blocks;
  for (std::uint32_t f = 0; f < complex.face_count(); ++f) {
    const auto corners = complex.corners(f);
    blocks.clear();
    for (const std::uint32_t v : corners) blocks.push_back(block_of_vertex[v]);
    std::sort(blocks.begin(), blocks.end());
    blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
    if (blocks.size() == 1) continue;
    for (const std::uint32_t v : corners)
      for (const std::uint32_t b : blocks) reached.push_back(std::uint64_t{v} << 32 | b);
  }
  std::sort(reached.begin(), reached.end());
  reached.erase(std::unique(reached.begin(), reached.end()), reached.end());
  std::vector<std::uint64_t> pairs;
  for (std::size_t i = 0, end = 0; i < reached.size(); i = end) {
    while (end < reached.size() && reached[end] >> 32 == reached[i] >> 32) ++end;
    for (std::size_t a = i; a < end; ++a)
      for (std::size_t b = i; b < end; ++b)
        if (a != b) pairs.push_back(reached[a] << 32 | (reached[b] & 0xFFFFFFFFu));
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

// Colours blocks greedily and numbers them by colours. Returns the new number of each.
std::vector<std::uint32_t> color_blocks(std::uint32_t count, const std::vector<std::uint64_t>& pairs, Blocks& blocks) {
  std::vector<std::uint32_t> color(count, kNone);
  std::vector<char> taken;
  for (std::size_t b = 0, i = 0; b < count; ++b) {
    taken.assign(taken.size(), 0);
    for (; i < pairs.size() && pairs[i] >> 32 == b; ++i)
      if (const std::uint32_t c = color[pairs[i] & 0xFFFFFFFFu]; c != kNone) taken[c] = 1;
    color[b] = static_cast<std::uint32_t>(std::find(taken.begin(), taken.end(), 0) - taken.begin());
    if (color[b] == taken.size()) taken.push_back(0);
  }
  std::vector<std::uint32_t> number(count);
  std::uint32_t next = 0;
  blocks.color_end.clear();
  for (std::uint32_t c = 0; c < taken.size(); ++c) {
    for (std::uint32_t b = 0; b < count; ++b)
      if (color[b] == c) number[b] = next++;
    blocks.color_end.push_back(next);
  }
  return number;
}

}  // namespace

Blocks make_blocks(const CellComplex& complex, std::span<const Vec3> points, const BurnNetwork& network,
                   std::uint64_t states) {
  Blocks blocks;
  const std::uint64_t all = network.state_count();
  blocks.of_state.assign(all, 0);
  if (all <= states) return blocks;
  const std::uint64_t size = std::max(states, all / 0x8000);  // half of 2^16: boxes may overfill their block

  const std::vector<std::uint32_t> boxes = boxes_of(points);
  std::vector<std::uint32_t> block_of(kBoxes, 0);  // per box: its number of states, later its block
  for (std::uint32_t v = 0; v < complex.vertex_count; ++v)
    block_of[boxes[v]] += network.vertex_base[v + 1] - network.vertex_base[v];
  for (std::uint32_t e = 0; e < complex.edges.size(); ++e)
    block_of[boxes[complex.edges[e][0]]] += network.state_base[e + 1] - network.state_base[e];
  std::uint64_t before = 0;
  for (std::uint32_t& box : block_of) {
    const std::uint64_t here = box;
    box = static_cast<std::uint32_t>(before / size);
    before += here;
  }
  const std::uint32_t count = static_cast<std::uint32_t>((all - 1) / size) + 1;
  std::vector<std::uint32_t> of_vertex(complex.vertex_count);
  for (std::uint32_t v = 0; v < complex.vertex_count; ++v) of_vertex[v] = block_of[boxes[v]];
  const auto number = color_blocks(count, near_pairs(complex, of_vertex), blocks);

  const auto set = [&](const std::vector<std::uint32_t>& base, std::size_t i, std::uint32_t v) {
    std::fill(blocks.of_state.begin() + base[i], blocks.of_state.begin() + base[i + 1],
              static_cast<std::uint16_t>(number[of_vertex[v]]));
  };
  for (std::uint32_t v = 0; v < complex.vertex_count; ++v) set(network.vertex_base, v, v);
  for (std::size_t e = 0; e < complex.edges.size(); ++e) set(network.state_base, e, complex.edges[e][0]);
  return blocks;
}

LabelQueue make_label_queue(const BurnDomain& domain, const BlockSchedule& schedule) {
  const double origin = domain.radius.empty() ? 0 : *std::min_element(domain.radius.begin(), domain.radius.end());
  return {origin, schedule.window_width * domain.network.omega,
          make_blocks(domain.complex, domain.points, domain.network, schedule.states_per_block)};
}

}  // namespace quench::burning
