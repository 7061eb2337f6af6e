// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <string_view>
#include <utility>

#include "base/parallel.h"
#include "base/prefetch.h"
#include "base/sorted_by_key.h"
#include "quench/axis.h"
#include "quench/error.h"

namespace quench {
namespace {

constexpr double kNotCovered = -1;

// A kd-tree over points that balls cover one after the other. Every point is covered once, and subtrees without others
// are skipped, so n points cost O(n log n) in all and a ball that covers nothing costs little.
class BallCover {
 public:
  explicit BallCover(std::vector<Vec3> points)
      : value(points.size(), kNotCovered), points_(std::move(points)), left_(points_.size()) {
    std::iota(left_.begin(), left_.end(), 0u);
    if (!points_.empty()) build(0, static_cast<std::uint32_t>(points_.size()));
  }

  std::vector<double> value;  ///< per point: of the first ball that contained it, or kNotCovered

  bool all_covered() const { return nodes_.empty() || nodes_[0].count == 0; }
  bool mostly_covered() const { return !nodes_.empty() && 2 * std::size_t{nodes_[0].count} < points_.size(); }
  // A tree of the points that are not covered, whose boxes are tight again; appends the values of the others.
  BallCover rebuilt_without_covered(std::vector<double>& values) const {
    std::vector<Vec3> rest;
    for (std::size_t i = 0; i < points_.size(); ++i)
      if (value[i] == kNotCovered)
        rest.push_back(points_[i]);
      else
        values.push_back(value[i]);
    return BallCover(std::move(rest));
  }
  void cover(const Vec3& center, double squared_radius, double level) {
    if (!all_covered()) cover(0, center, squared_radius, level);
  }

 private:
  struct Node {
    Vec3 low = Vec3::Zero(), high = Vec3::Zero();
    std::uint32_t begin = 0, count = 0;  // leaf: left_[begin, begin + count); inner: points left below
    std::uint32_t children = 0;          // index of the first of two, 0 for a leaf
  };

  std::uint32_t build(std::uint32_t begin, std::uint32_t end) {
    const auto index = static_cast<std::uint32_t>(nodes_.size());
    nodes_.push_back({});
    fill(index, begin, end);
    return index;
  }

  void fill(std::uint32_t index, std::uint32_t begin, std::uint32_t end) {
    Vec3 low = points_[left_[begin]], high = low;
    for (std::uint32_t i = begin; i < end; ++i) {
      low = low.cwiseMin(points_[left_[i]]);
      high = high.cwiseMax(points_[left_[i]]);
    }
    nodes_[index] = {low, high, begin, end - begin, 0};
    if (end - begin <= 8) return;
    Eigen::Index axis;
    (high - low).maxCoeff(&axis);
    const std::uint32_t middle = begin + (end - begin) / 2;
    std::nth_element(left_.begin() + begin, left_.begin() + middle, left_.begin() + end,
                     [&](std::uint32_t a, std::uint32_t b) { return points_[a][axis] < points_[b][axis]; });
    const auto children = static_cast<std::uint32_t>(nodes_.size());
    nodes_.resize(nodes_.size() + 2);
    nodes_[index].children = children;
    fill(children, begin, middle);
    fill(children + 1, middle, end);
  }

  std::uint32_t cover(std::uint32_t index, const Vec3& center, double squared_radius, double level) {
    Node& node = nodes_[index];
    if (node.count == 0) return 0;
    const Vec3 nearest = center.cwiseMax(node.low).cwiseMin(node.high);
    if ((nearest - center).squaredNorm() > squared_radius) return 0;
    std::uint32_t covered = 0;
    if (node.children) {
      covered =
          cover(node.children, center, squared_radius, level) + cover(node.children + 1, center, squared_radius, level);
    } else {
      for (std::uint32_t i = node.begin; i < node.begin + node.count - covered;) {
        if ((points_[left_[i]] - center).squaredNorm() <= squared_radius) {
          value[left_[i]] = level;
          ++covered;
          std::swap(left_[i], left_[node.begin + node.count - covered]);
        } else {
          ++i;
        }
      }
    }
    node.count -= covered;
    return covered;
  }

  std::vector<Vec3> points_;
  std::vector<std::uint32_t> left_;  // point indices in leaf order; the covered ones at the end of each leaf
  std::vector<Node> nodes_;
};

// `count` voxel centres, one hashed position in each of `count` equal parts of the list of voxels.
std::vector<Vec3> sampled_centres(const VoxelShape& shape, std::size_t count) {
  std::vector<Vec3> centres;
  const auto voxels = static_cast<std::uint64_t>(shape.voxel_count());
  count = static_cast<std::size_t>(std::min<std::uint64_t>(count, voxels));
  centres.reserve(count);
  const auto wanted = [&](std::size_t i) {
    const auto part = [&](std::size_t k) {
      return static_cast<std::uint64_t>(static_cast<double>(k) * static_cast<double>(voxels) /
                                        static_cast<double>(count));
    };
    const std::uint64_t begin = part(i), end = part(i + 1);
    const std::uint64_t hash = (i + 1) * 0x9E3779B97F4A7C15ull >> 16;
    return begin + hash % std::max<std::uint64_t>(end - begin, 1);
  };
  std::uint64_t passed = 0;
  std::size_t next = 0;
  const auto& dims = shape.grid().dims;
  for (std::int64_t z = 0; z < dims[2] && next < count; ++z)
    for (std::int64_t y = 0; y < dims[1] && next < count; ++y)
      for (const Run& run : shape.row(y, z)) {
        const auto length = static_cast<std::uint64_t>(run.end - run.begin);
        for (; next < count && wanted(next) < passed + length; ++next)
          centres.push_back(shape.grid().world(
              {static_cast<double>(run.begin) + static_cast<double>(wanted(next) - passed) + 0.5,
               static_cast<double>(y) + 0.5, static_cast<double>(z) + shape.grid().first_centre()[2]}));
        passed += length;
      }
  return centres;
}

// The vertices, highest level first, so that the first ball to contain a centre is the last to go. Where there are not
// too many of a level large balls come first: they cover most centres, which saves time.
std::vector<std::uint32_t> by_level(const MedialAxis& axis, std::span<const double> level) {
  return base::sorted_by_key_descending(
      axis.points.size(), 1024, [&](std::size_t v) { return level[v]; },
      [&](std::uint32_t a, std::uint32_t b) { return axis.radius[a] > axis.radius[b]; });
}

// For each of the sampled centres, in ascending order: up to which threshold a ball covers it. `level`: of the
// vertices.
std::vector<double> covered_until(const VoxelShape& shape, const MedialAxis& axis, std::span<const double> level,
                                  std::size_t samples, Context* context) {
  std::vector<double> covered;
  const std::vector<std::uint32_t> order = by_level(axis, level);
  checkpoint(context, "reconstruct", 0.1);

  // Each slab of centres meets all balls in their order, a block at a time; blocks are copied first, since looking a
  // ball up costs more than seeing that it is far away.
  const std::vector<Vec3> centres = sampled_centres(shape, samples);
  const auto threads = static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
  const std::size_t slab_count = threads == 1 ? 1 : 4 * threads;
  constexpr std::size_t kBlock = std::size_t{1} << 17;
  std::vector<BallCover> slabs;
  for (std::size_t s = 0; s < slab_count; ++s) {
    const auto [first, last] = base::part_of(centres.size(), s, slab_count);
    slabs.emplace_back(std::vector<Vec3>(centres.begin() + static_cast<std::ptrdiff_t>(first),
                                         centres.begin() + static_cast<std::ptrdiff_t>(last)));
  }
  struct Placed {
    Vec3 centre;
    double squared_radius, level;
  };
  std::vector<Placed> block;
  const auto all_covered = [&] {
    return std::all_of(slabs.begin(), slabs.end(), [](const BallCover& slab) { return slab.all_covered(); });
  };
  for (std::size_t begin = 0; begin < order.size() && !all_covered(); begin += kBlock) {
    const std::size_t count = std::min(kBlock, order.size() - begin);
    const double done = 0.1 + 0.9 * static_cast<double>(begin) / static_cast<double>(order.size());
    block.resize(count);
    const std::size_t chunks = base::chunks_for(count, std::size_t{1} << 14);
    base::for_chunks(chunks, context, "reconstruct", done, done, [&](std::size_t chunk) {
      const auto [first, last] = base::part_of(count, chunk, chunks);
      for (std::size_t i = first; i < last; ++i) {
        if (begin + i + 8 < order.size()) {
          base::prefetch(&axis.points[order[begin + i + 8]]);
          base::prefetch(&axis.radius[order[begin + i + 8]]);
        }
        const std::uint32_t v = order[begin + i];
        const double radius = axis.radius[v] * (1 + 1e-9);  // a centre on the sphere counts
        block[i] = {axis.points[v], radius * radius, level[v]};
      }
    });
    base::for_chunks(slab_count, context, "reconstruct", done, done, [&](std::size_t s) {
      for (std::size_t i = 0; i < count && !slabs[s].all_covered(); ++i)
        slabs[s].cover(block[i].centre, block[i].squared_radius, block[i].level);
    });
    for (BallCover& slab : slabs)
      if (slab.mostly_covered()) slab = slab.rebuilt_without_covered(covered);
  }
  for (const BallCover& slab : slabs) covered.insert(covered.end(), slab.value.begin(), slab.value.end());
  std::sort(covered.begin(), covered.end());
  checkpoint(context, "reconstruct", 1);
  return covered;
}

}  // namespace

Reconstruction::Reconstruction(const VoxelShape& shape, const MedialAxis& axis, std::size_t samples, Context* context,
                               std::string_view measure) {
  const Measure* by = axis.find_measure(measure);
  const std::span<const double> level = by ? by->level.vertex : std::span<const double>{};
  if (axis.radius.size() != axis.points.size() || level.size() != axis.points.size())
    throw Error(ErrorCode::usage,
                fmt::format("the medial axis has {} vertices, but {} radii and {} levels; give it levels by "
                            "prune_levels() first",
                            axis.points.size(), axis.radius.size(), level.size()));
  covered_until_ = base::in_arena(context, [&] { return covered_until(shape, axis, level, samples, context); });
}

double Reconstruction::share(double threshold) const {
  if (covered_until_.empty()) return 1;
  const auto first =
      std::lower_bound(covered_until_.begin(), covered_until_.end(), std::max(0.0, threshold * (1 - 1e-12)));
  return static_cast<double>(covered_until_.end() - first) / static_cast<double>(covered_until_.size());
}

double auto_lambda(const Reconstruction& reconstruction, double longest_side, double smallest_spacing) {
  if (!(smallest_spacing > 0) || !std::isfinite(smallest_spacing) || !(longest_side >= 0) ||
      !std::isfinite(longest_side))
    throw Error(ErrorCode::usage,
                fmt::format("a lambda cannot be chosen for a longest side of {} and a spacing of {}; both must be "
                            "finite, and the spacing above 0",
                            longest_side, smallest_spacing));
  for (int step = 0;; ++step) {
    const double lambda = 0.02 * longest_side * std::pow(0.5, 0.5 * step);
    if (lambda < 0.5 * smallest_spacing) return 0;
    if (reconstruction.share(lambda) >= 0.98) return lambda;
  }
}

}  // namespace quench
