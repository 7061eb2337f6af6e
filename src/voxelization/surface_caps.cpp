// SPDX-License-Identifier: Apache-2.0
#include "voxelization/surface_caps.h"

namespace quench::voxelization {
namespace {

/// Closes a path that runs along the faces' sides from each point to the next, and from the last to the first.
class PathCap {
 public:
  PathCap(std::span<const std::uint32_t> path, std::vector<CapTriangle>& caps) : path_(path), caps_(caps) {
    if (path.size() > 2) between(0, path.size() - 1);
  }

 private:
  // The part of the path from `first` to `last`, closed by the side between them.
  void between(std::size_t first, std::size_t last) {
    const std::size_t middle = (first + last) / 2;
    caps_.push_back({{path_[first], path_[last], path_[middle]},
                     {last - first + 1 == path_.size(), last - middle == 1, middle - first == 1}});
    if (middle - first > 1) between(first, middle);
    if (last - middle > 1) between(middle, last);
  }

  std::span<const std::uint32_t> path_;
  std::vector<CapTriangle>& caps_;
};

}  // namespace

std::vector<CapTriangle> close_boundary(std::size_t points, std::span<const Triangle> welded) {
  std::vector<CapTriangle> caps;
  std::vector<BoundaryEdge> chain = boundary_chain(points, welded);
  if (chain.empty()) return caps;
  const auto out = edges_from(points, chain);
  std::vector<std::uint32_t> next(points, 0);  // per point: of its edges the first one that is left
  const auto leave = [&](std::uint32_t p) {
    std::uint32_t& at = next[p];
    while (at < out[p].size() && chain[out[p][at]].times == 0) ++at;
    if (at == out[p].size()) return kNone;
    --chain[out[p][at]].times;
    return chain[out[p][at]].to;
  };
  std::vector<std::uint32_t> path, place(points, kNone);  // of the points on the path
  for (const BoundaryEdge& e : chain)
    while (e.times > 0) {
      // As many edges enter a point as leave it: the walk ends where it began. What it closes on its way is cut off.
      for (std::uint32_t p = e.from; p != kNone; p = leave(p)) {
        if (place[p] != kNone) {
          const std::size_t start = place[p];
          PathCap(std::span<const std::uint32_t>(path).subspan(start), caps);
          for (std::size_t i = start; i < path.size(); ++i) place[path[i]] = kNone;
          path.resize(start);
          if (path.empty() && e.times == 0) break;
        }
        place[p] = static_cast<std::uint32_t>(path.size());
        path.push_back(p);
      }
      for (const std::uint32_t p : path) place[p] = kNone;
      path.clear();
    }
  return caps;
}

}  // namespace quench::voxelization
