// SPDX-License-Identifier: Apache-2.0
#include "tree/grey_path.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <queue>
#include <utility>
#include <variant>
#include <vector>

namespace quench::tree {
namespace {

constexpr double kBright = 0.05;
constexpr double kDetour = 1.3;         // longest way over the distance of its ends
constexpr double kMostCells = 1 << 20;  // of a box that ways are looked for in

using Cell = std::array<std::int64_t, 3>;

Cell voxel_at(const Grid& grid, const Vec3& point) {
  const Vec3 at = grid.lattice(point);
  Cell cell;
  for (int i = 0; i < 3; ++i) {
    const auto axis = static_cast<std::size_t>(i);
    cell[axis] = std::clamp<std::int64_t>(static_cast<std::int64_t>(std::floor(at[i])), 0, grid.dims[axis] - 1);
  }
  return cell;
}

// A box of voxels with their values relative to background and threshold.
struct Box {
  Cell low, size;
  std::vector<double> value;

  std::size_t index(const Cell& c) const {
    return static_cast<std::size_t>((c[0] - low[0]) + size[0] * ((c[1] - low[1]) + size[1] * (c[2] - low[2])));
  }
  Cell cell(std::size_t i) const {
    const auto n = static_cast<std::int64_t>(i);
    return {low[0] + n % size[0], low[1] + n / size[0] % size[1], low[2] + n / (size[0] * size[1])};
  }
  bool holds(const Cell& c) const {
    for (std::size_t i = 0; i < 3; ++i)
      if (c[i] < low[i] || c[i] >= low[i] + size[i]) return false;
    return true;
  }
};

double darkness_of(double relative) {
  return std::isnan(relative) ? 1 : std::clamp(1 - (1 - kBright) * relative, kBright, 1.0);
}

}  // namespace

GreyPaths::GreyPaths(const GreyValues& grey) : grey_(grey) {
  std::vector<double> outside;
  std::visit(
      [&](const auto& samples) {
        const std::size_t step = samples.size() / 100000 + 1;
        for (std::size_t i = 0; i < samples.size(); i += step) {
          const auto value = static_cast<double>(samples[i]);
          if (std::isfinite(value) && (value < grey.threshold) != grey.invert) outside.push_back(value);
        }
      },
      grey.volume->samples);
  background_ = grey.threshold + (grey.invert ? 1 : -1);
  if (outside.empty()) return;
  const auto middle = outside.begin() + static_cast<std::ptrdiff_t>(outside.size() / 2);
  std::nth_element(outside.begin(), middle, outside.end());
  if (*middle != grey.threshold) background_ = *middle;
}

GreyPaths::Way GreyPaths::straight_way(const Vec3& a, const Vec3& b) const {
  const Grid& grid = grey_.volume->grid;
  const auto steps = static_cast<std::int64_t>(std::ceil((b - a).cwiseQuotient(grid.spacing).cwiseAbs().maxCoeff()));
  Way way;
  way.darkness = 0;
  std::visit(
      [&](const auto& samples) {
        for (std::int64_t i = 0; i <= steps; ++i) {
          const double t = steps > 0 ? static_cast<double>(i) / static_cast<double>(steps) : 0;
          const Cell c = voxel_at(grid, (1 - t) * a + t * b);
          const double value = relative(static_cast<double>(
              samples[static_cast<std::size_t>(c[0] + grid.dims[0] * (c[1] + grid.dims[1] * c[2]))]));
          way.grey += std::isnan(value) ? 0 : value;
          way.darkness += darkness_of(value);
        }
      },
      grey_.volume->samples);
  way.grey /= static_cast<double>(steps + 1);
  way.darkness /= static_cast<double>(steps + 1);
  return way;
}

GreyPaths::Way GreyPaths::between(const Vec3& a, const Vec3& b) const {
  const Grid& grid = grey_.volume->grid;
  const Cell from = voxel_at(grid, a), to = voxel_at(grid, b);
  const auto centre = [&](const Cell& c) {
    return Vec3(static_cast<double>(c[0]), static_cast<double>(c[1]), static_cast<double>(c[2]))
        .cwiseProduct(grid.spacing)
        .eval();
  };
  const double apart = (centre(from) - centre(to)).norm(), most = kDetour * apart + 2 * grid.spacing.maxCoeff();
  Box box;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto margin = static_cast<std::int64_t>(0.5 * (most - apart) / grid.spacing[static_cast<int>(i)]) + 1;
    box.low[i] = std::max<std::int64_t>(std::min(from[i], to[i]) - margin, 0);
    box.size[i] = std::min(std::max(from[i], to[i]) + margin, grid.dims[i] - 1) - box.low[i] + 1;
  }
  if (static_cast<double>(box.size[0]) * static_cast<double>(box.size[1]) * static_cast<double>(box.size[2]) >
      kMostCells)
    return straight_way(a, b);
  const auto count = static_cast<std::size_t>(box.size[0] * box.size[1] * box.size[2]);
  box.value.resize(count);
  std::visit(
      [&](const auto& samples) {
        for (std::size_t i = 0; i < count; ++i) {
          const Cell c = box.cell(i);
          box.value[i] = relative(static_cast<double>(
              samples[static_cast<std::size_t>(c[0] + grid.dims[0] * (c[1] + grid.dims[1] * c[2]))]));
        }
      },
      grey_.volume->samples);
  const auto darkness = [&](std::size_t i) { return darkness_of(box.value[i]); };

  std::vector<double> cost(count, std::numeric_limits<double>::infinity());
  std::vector<std::uint32_t> before(count, kNone);
  using Entry = std::pair<double, std::size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  const std::size_t start = box.index(from), goal = box.index(to);
  cost[start] = 0;
  queue.push({0, start});
  while (!queue.empty()) {
    const auto [so_far, i] = queue.top();
    queue.pop();
    if (i == goal) break;
    if (so_far > cost[i]) continue;
    const Cell c = box.cell(i);
    for (int step = 0; step < 27; ++step) {
      const Cell n{c[0] + step % 3 - 1, c[1] + step / 3 % 3 - 1, c[2] + step / 9 - 1};
      if (step == 13 || !box.holds(n)) continue;
      const std::size_t j = box.index(n);
      if ((centre(n) - centre(from)).norm() + (centre(n) - centre(to)).norm() > most) continue;
      const double next = so_far + (centre(n) - centre(c)).norm() * 0.5 * (darkness(i) + darkness(j));
      if (next >= cost[j]) continue;
      cost[j] = next;
      before[j] = static_cast<std::uint32_t>(i);
      queue.push({next, j});
    }
  }
  Way way;
  double sum = 0, steps = 0;
  for (std::size_t i = goal;; i = before[i]) {
    sum += std::isnan(box.value[i]) ? 0 : box.value[i];
    ++steps;
    if (i == start) break;
  }
  way.grey = sum / steps;
  way.darkness = apart > 0 ? std::min(1.0, cost[goal] / apart) : darkness(goal);
  return way;
}

}  // namespace quench::tree
