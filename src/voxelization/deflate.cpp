// SPDX-License-Identifier: Apache-2.0
#include "voxelization/deflate.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <numeric>
#include <queue>

#include "base/parallel.h"
#include "voxelization/simple_voxel.h"

namespace quench::voxelization {
namespace {

/// A cover that is being deflated. Per voxel its neighbours: in the shape and the cover together as long as it is
/// outside the shape, in the shape without the cover where it is inside; taking a voxel away or putting it back flips
/// its bit in the neighbours of its own kind.
class Deflation {
 public:
  Deflation(const SurfaceCover& cover, const VoxelShape& shape, std::int64_t margin)
      : cover_(cover), shape_(shape), margin_(margin), row_(cover.x.size()), state_(cover.x.size()) {
    const std::size_t rows = cover.row_begin.size() - 1;
    base::for_indices(rows, [&](std::size_t r) { look_around(r); });
  }

  void run(Context* context) {
    std::vector<std::uint32_t> order = by_distance();
    std::size_t next = 0;
    for (std::uint32_t count = 0; next < order.size() || !again_.empty(); ++count) {
      if (count % (1u << 20) == 0) checkpoint(context, "voxelize", 1);
      std::uint32_t v;
      if (again_.empty() || (next < order.size() && before(order[next], again_.top()))) {
        v = order[next++];
      } else {
        v = again_.top();
        again_.pop();
      }
      state_[v] = (state_[v] | kSeen) & ~kQueued;
      if (is_simple(state_[v] & kAllNeighbours)) flip(v);
    }
  }

  std::vector<Voxel> left() const {
    std::vector<Voxel> result;
    for (std::uint32_t v = 0; v < state_.size(); ++v)
      if (!(state_[v] & kFlipped))
        result.push_back({static_cast<std::int32_t>(cover_.x[v] + margin_),
                          static_cast<std::int32_t>(row_[v] % cover_.cells[1] + margin_),
                          static_cast<std::int32_t>(row_[v] / cover_.cells[1] + margin_)});
    return result;
  }

 private:
  static constexpr std::uint32_t kInside = 1u << 27, kFlipped = 1u << 28, kSeen = 1u << 29, kQueued = 1u << 30;

  bool before(std::uint32_t a, std::uint32_t b) const {
    return cover_.distance[a] != cover_.distance[b] ? cover_.distance[a] > cover_.distance[b] : a < b;
  }

  /// Counting sort.
  std::vector<std::uint32_t> by_distance() const {
    std::vector<std::uint32_t> place(0x10001, 0), order(state_.size());
    for (const std::uint16_t d : cover_.distance) ++place[0x10000u - d];
    std::partial_sum(place.begin(), place.end(), place.begin());
    for (std::uint32_t v = 0; v < order.size(); ++v) order[place[0xffffu - cover_.distance[v]]++] = v;
    return order;
  }

  /// Which of x - 1, x and x + 1 are in the runs from `run` on, as bits; `run` moves along.
  static std::uint32_t three_of(std::span<const Run>& runs, std::int64_t x) {
    while (!runs.empty() && runs.front().end < x) runs = runs.subspan(1);
    std::uint32_t bits = 0;
    for (auto run = runs.begin(); run != runs.end() && run->begin <= x + 1; ++run)
      for (std::uint32_t i = 0; i < 3; ++i)
        if (run->begin <= x + i - 1 && x + i - 1 < run->end) bits |= 1u << i;
    return bits;
  }
  static std::uint32_t three_of(std::span<const std::int32_t>& cells, std::int32_t x) {
    while (!cells.empty() && cells.front() < x - 1) cells = cells.subspan(1);
    std::uint32_t bits = 0;
    for (auto cell = cells.begin(); cell != cells.end() && *cell <= x + 1; ++cell) bits |= 1u << (*cell - x + 1);
    return bits;
  }

  /// The neighbours of all voxels of a scanline of the cover.
  void look_around(std::size_t r) {
    const auto first = cover_.row_begin[r], last = cover_.row_begin[r + 1];
    if (first == last) return;
    const auto y = static_cast<std::int64_t>(r) % cover_.cells[1], z = static_cast<std::int64_t>(r) / cover_.cells[1];
    std::span<const Run> own = shape_.row(y + margin_, z + margin_);
    for (std::uint32_t v = first; v < last; ++v) {
      row_[v] = static_cast<std::uint32_t>(r);
      if (three_of(own, cover_.x[v] + margin_) & 2u) state_[v] = kInside;
    }
    for (int dz = -1; dz <= 1; ++dz)
      for (int dy = -1; dy <= 1; ++dy) {
        std::span<const Run> runs = shape_.row(y + dy + margin_, z + dz + margin_);
        std::span<const std::int32_t> cells = cover_.row(y + dy, z + dz);
        const int at = 3 * (dy + 1) + 9 * (dz + 1);
        for (std::uint32_t v = first; v < last; ++v) {
          const std::uint32_t inside = three_of(runs, cover_.x[v] + margin_), met = three_of(cells, cover_.x[v]);
          state_[v] |= (state_[v] & kInside ? inside & ~met : inside | met) << at;
        }
      }
  }

  void flip(std::uint32_t v) {
    state_[v] |= kFlipped;
    const std::int64_t y = row_[v] % cover_.cells[1], z = row_[v] / cover_.cells[1];
    const std::int32_t x = cover_.x[v];
    for (int dz = -1; dz <= 1; ++dz)
      for (int dy = -1; dy <= 1; ++dy) {
        const std::span<const std::int32_t> cells = cover_.row(y + dy, z + dz);
        for (auto c = std::lower_bound(cells.begin(), cells.end(), x - 1); c != cells.end() && *c <= x + 1; ++c) {
          const auto other = static_cast<std::uint32_t>(&*c - cover_.x.data());
          if (other == v || (state_[other] ^ state_[v]) & kInside) continue;
          state_[other] ^= neighbour_bit(x - *c, -dy, -dz);
          if ((state_[other] & (kFlipped | kSeen | kQueued)) != kSeen) continue;  // gone, to come, or to come again
          state_[other] |= kQueued;
          again_.push(other);
        }
      }
  }

  struct Later {
    const Deflation* of;
    bool operator()(std::uint32_t a, std::uint32_t b) const { return of->before(b, a); }
  };

  const SurfaceCover& cover_;
  const VoxelShape& shape_;
  std::int64_t margin_;
  std::vector<std::uint32_t> row_;    ///< y + cells[1] * z
  std::vector<std::uint32_t> state_;  ///< neighbours, and flags above
  std::priority_queue<std::uint32_t, std::vector<std::uint32_t>, Later> again_{Later{this}};  ///< that were not simple
};

}  // namespace

std::vector<Voxel> deflate(const SurfaceCover& cover, const VoxelShape& shape, std::int64_t margin, Context* context) {
  Deflation deflation(cover, shape, margin);
  deflation.run(context);
  return deflation.left();
}

}  // namespace quench::voxelization
