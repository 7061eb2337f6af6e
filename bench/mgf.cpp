// SPDX-License-Identifier: Apache-2.0
// The medial geodesic function of the faces of a core: CPU time on one thread, per face, beside searches over all of
// the surface and, for a sample of faces, Dijkstra's algorithm on sides that are subdivided: its time and its error.
//   bench_mgf [SHAPE_FILE]...      (a mesh or a volume; without one: a rippled plate)
// Environment: WHOLE=1: of the whole core instead of the default pruning; SAMPLE (24): faces that are compared;
// RESOLUTION of meshes (that of the program), THREADS (1).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <limits>
#include <queue>
#include <string>
#include <vector>

#include "geodesic/pair_distances.h"
#include "geodesic/voxel_surface.h"
#include "geodesic/window_search.h"
#include "measure.h"
#include "quench/axis.h"
#include "quench/pipeline.h"
#include "random_shapes.h"

namespace {

using namespace quench;
using geodesic::VoxelSurface;

int number(const char* name, int otherwise) {
  const char* text = std::getenv(name);
  return text ? std::atoi(text) : otherwise;
}

/// Shortest ways over the vertices and `parts` - 1 points on every side, straight through each square.
class Subdivision {
 public:
  Subdivision(const VoxelSurface& surface, std::uint32_t parts)
      : surface_(surface),
        parts_(parts),
        distance_(surface.points() + std::size_t{surface.half_edges()} * (parts - 1)) {}

  double shortest(std::uint32_t from, std::uint32_t to) {
    std::ranges::fill(distance_, std::numeric_limits<double>::infinity());
    using Entry = std::pair<double, std::uint32_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    distance_[from] = 0;
    queue.emplace(0, from);
    while (!queue.empty()) {
      const auto [d, node] = queue.top();
      queue.pop();
      if (node == to) return d;
      if (d > distance_[node]) continue;
      const auto pass = [&, d = d, node = node](std::uint32_t square) {
        list(square);
        const auto own = std::ranges::find(nodes_, node, &Node::id);
        for (const Node& next : nodes_) {
          const double length = d + std::hypot(next.x - own->x, next.y - own->y);
          if (length >= distance_[next.id]) continue;
          distance_[next.id] = length;
          queue.emplace(length, next.id);
        }
      };
      if (node < surface_.points()) {
        for (const std::uint32_t h : surface_.around(node)) pass(h / 4);
      } else {
        const std::uint32_t h = (node - surface_.points()) / (parts_ - 1);
        pass(h / 4);
        pass(surface_.twin(h) / 4);
      }
    }
    return std::numeric_limits<double>::infinity();
  }

 private:
  struct Node {
    std::uint32_t id;
    double x, y;
  };
  void list(std::uint32_t square) {
    nodes_.clear();
    double x = 0, y = 0;
    constexpr std::array<double, 4> dx{1, 0, -1, 0}, dy{0, 1, 0, -1};
    for (std::uint32_t side = 0; side < 4; ++side) {
      const std::uint32_t h = 4 * square + side, twin = surface_.twin(h), own = std::min(h, twin);
      const double step = surface_.length(h) / parts_;
      nodes_.push_back({surface_.begin(h), x, y});
      for (std::uint32_t i = 1; i < parts_; ++i)
        nodes_.push_back({surface_.points() + own * (parts_ - 1) + (own == h ? i : parts_ - i) - 1,
                          x + i * step * dx[side], y + i * step * dy[side]});
      x += surface_.length(h) * dx[side];
      y += surface_.length(h) * dy[side];
    }
  }

  const VoxelSurface& surface_;
  const std::uint32_t parts_;
  std::vector<double> distance_;
  std::vector<Node> nodes_;
};

void measure(const VoxelShape& shape, const std::string& name) {
  Context context;
  context.threads = number("THREADS", 1);
  MedialAxis axis = voxel_core(shape, {}, &context);
  if (!number("WHOLE", 0)) {
    add_detail(axis, &context);
    prune_levels(axis, kDetail, &context);
    axis = pruned(std::move(axis), auto_detail(shape.grid()), kDetail);
  }
  double start = cpu_seconds();
  const VoxelSurface surface(shape);
  const double of_surface = cpu_seconds() - start;
  std::vector<std::array<std::uint32_t, 2>> pairs;
  for (const auto& [a, b] : axis.face_sites)
    pairs.push_back(
        {surface.point_towards(axis.sites[a], axis.sites[b]), surface.point_towards(axis.sites[b], axis.sites[a])});
  geodesic::PairCounts counts;
  start = cpu_seconds();
  const double wall = wall_seconds();
  const std::vector<double> mgf = geodesic::pair_distances(surface, pairs, std::int64_t{1} << 30, &context, &counts);
  const double of_pairs = cpu_seconds() - start;
  double largest = 0;
  for (const double d : mgf)
    if (std::isfinite(d)) largest = std::max(largest, d);
  fmt::print("{}: {} squares (made in {:.2f} s), {} faces, largest MGF {:.3f}\n", name, surface.half_edges() / 4,
             of_surface, pairs.size(), largest * surface.unit());
  fmt::print("  all: {:.1f} s CPU, {:.1f} s wall; {} near, {} far, {} landmarks; {:.3f} ms and {:.0f} windows a face\n",
             of_pairs, wall_seconds() - wall, counts.near, counts.far, counts.landmarks,
             1e3 * of_pairs / static_cast<double>(pairs.size()),
             static_cast<double>(counts.windows) / static_cast<double>(pairs.size()));
  const std::size_t step = std::max<std::size_t>(1, pairs.size() / static_cast<std::size_t>(number("SAMPLE", 24)));
  const auto compare = [&](const std::string& how, const auto& search) {
    double worst = 0, sum = 0;
    std::size_t count = 0;
    start = cpu_seconds();
    for (std::size_t i = 0; i < pairs.size(); i += step) {
      if (!std::isfinite(mgf[i])) continue;
      const double off = std::abs(search(pairs[i][0], pairs[i][1]) / mgf[i] - 1);
      worst = std::max(worst, off);
      sum += off;
      ++count;
    }
    fmt::print("  {}: {:.1f} ms a face; off by {:.2g} on average, {:.2g} at most\n", how,
               1e3 * (cpu_seconds() - start) / static_cast<double>(count), sum / static_cast<double>(count), worst);
  };
  geodesic::WindowSearch search(surface);
  compare("windows until the partner is reached", [&](std::uint32_t a, std::uint32_t b) {
    search.search(a, {&b, 1}, std::numeric_limits<double>::infinity(), std::numeric_limits<std::int64_t>::max(),
                  [](std::uint32_t) { return 0.0; });
    return search.distance(b);
  });
  for (const std::uint32_t parts : {1u, 2u, 4u, 8u}) {
    Subdivision subdivision(surface, parts);
    compare(fmt::format("Dijkstra, sides in {}", parts),
            [&](std::uint32_t a, std::uint32_t b) { return subdivision.shortest(a, b); });
  }
}

VoxelShape rippled_plate() {
  Grid grid;
  grid.dims = {120, 80, 40};
  return testing_shapes::from_predicate(
      grid, [](int x, int y, int z) { return z < 36 + 3 * std::sin(x / 5.0) * std::cos(y / 4.0); });
}

}  // namespace

int main(int count, char** arguments) {
  if (count < 2) measure(rippled_plate(), "rippled plate");
  for (int i = 1; i < count; ++i) {
    Context context;
    pipeline::ShapeOptions options;
    if (const int resolution = number("RESOLUTION", 0)) options.resolution = resolution;
    measure(pipeline::load_shape(arguments[i], options, &context).shape, arguments[i]);
  }
}
