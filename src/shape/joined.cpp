// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <queue>
#include <tuple>
#include <utility>

#include "shape/grown.h"
#include "shape/voxel_components.h"

namespace quench::shape {
namespace {

using Place = std::int64_t;  // x + nx (y + ny z)
using Voxel = std::array<std::int64_t, 3>;
constexpr Place kNoPlace = std::numeric_limits<Place>::max();

/// One or two voxels of the background that join components.
using Way = std::array<Place, 2>;

/// What a way is worth, the best first.
struct Worth {
  bool foreign = true;  ///< it joins what is not 26-connected
  int voxels = 0;       ///< of the way that are not there yet
  int components = 0;   ///< by how many there are less afterwards
  int loops = 0;        ///< how many tunnels and cavities it makes
  double value = 0;     ///< the lower one of its voxels
  auto key() const { return std::tuple(foreign, voxels, -components, loops, -value); }
};

/// The voxels of a shape and those that were added to it, and what is connected.
class Growing {
 public:
  Growing(const VoxelShape& shape, const SignedSamples* values, base::UnionFind& faces, base::UnionFind& corners)
      : shape_(shape), values_(values), dims_(shape.grid().dims) {
    find_ways(faces);
    places_.erase(std::unique(places_.begin(), places_.end()), places_.end());
    added_.assign(places_.size(), false);
    const auto runs = static_cast<std::uint32_t>(shape.runs().size());
    faces_ = base::UnionFind(runs + places_.size());
    corners_ = faces_;
    for (std::uint32_t i = 0; i < runs; ++i) {
      faces_.unite(i, faces.find(i));
      corners_.unite(i, corners.find(i));
    }
  }

  void join(Context* context) {
    using Entry = std::pair<decltype(Worth().key()), Way>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    for (const Way& way : std::exchange(ways_, {})) queue.emplace(worth_of(way).key(), way);
    const double all = static_cast<double>(queue.size()) + 1;
    for (std::size_t step = 0; !queue.empty(); ++step) {
      if (step % 1024 == 0) checkpoint(context, "connectivity", 1 - static_cast<double>(queue.size()) / all);
      const auto [key, way] = queue.top();
      queue.pop();
      const Worth worth = worth_of(way);  // what was joined meanwhile may have made it worse, or useless
      if (worth.components <= 0) continue;
      if (worth.key() > key)
        queue.emplace(worth.key(), way);
      else
        take(way);
    }
    checkpoint(context, "connectivity", 1);
  }

  VoxelShape result(ForegroundReport& report) const {
    VoxelShape grown(shape_.grid());
    std::vector<Run> runs;
    std::size_t next = 0;
    for (std::int64_t z = 0; z < dims_[2]; ++z)
      for (std::int64_t y = 0; y < dims_[1]; ++y) {
        const auto row = shape_.row(y, z);
        runs.assign(row.begin(), row.end());
        const Place first = place({0, y, z});
        for (; next < places_.size() && places_[next] < first + dims_[0]; ++next)
          if (added_[next]) {
            const auto x = static_cast<std::int32_t>(places_[next] - first);
            runs.push_back({x, x + 1});
            ++report.voxels_joined;
          }
        std::ranges::sort(runs, {}, &Run::begin);
        grown.append_row(runs);
      }
    report.components_joined = joined_;
    return grown;
  }

 private:
  Place place(const Voxel& v) const { return v[0] + dims_[0] * (v[1] + dims_[1] * v[2]); }
  Voxel voxel(Place p) const { return {p % dims_[0], p / dims_[0] % dims_[1], p / dims_[0] / dims_[1]}; }

  /// All ways to join two voxels of different components that touch. All voxels of a way lie in the box of the two.
  void find_ways(base::UnionFind& faces) {
    for_scanlines(shape_, nullptr, {}, [&](std::int64_t y, std::int64_t z) {
      const auto row = shape_.row(y, z);
      if (row.empty()) return;
      const std::uint32_t here = first_index(shape_, row);
      constexpr std::array<std::array<int, 2>, 4> kNeighbours{{{1, 0}, {-1, 1}, {0, 1}, {1, 1}}};
      for (const std::array<int, 2>& step : kNeighbours) {
        const int dy = step[0], dz = step[1];
        const auto other = shape_.row(y + dy, z + dz);
        const std::uint32_t there = first_index(shape_, other);
        for_touching(row, other, [&](std::size_t i, std::size_t j) {
          if (faces.find(here + static_cast<std::uint32_t>(i)) == faces.find(there + static_cast<std::uint32_t>(j)))
            return;
          const Run &a = row[i], &b = other[j];
          if (a.end == b.begin) add_ways({a.end - 1, y, z}, {b.begin, y + dy, z + dz});
          if (b.end == a.begin) add_ways({a.begin, y, z}, {b.end - 1, y + dy, z + dz});
          for (std::int64_t x = std::max(a.begin, b.begin); x < std::min(a.end, b.end); ++x)
            add_ways({x, y, z}, {x, y + dy, z + dz});
        });
      }
    });
    std::ranges::sort(places_);
  }
  void add_ways(const Voxel& a, const Voxel& b) {
    const auto along = [&](Voxel from, std::size_t axis) {
      from[axis] = b[axis];
      return from;
    };
    for (std::size_t first = 0; first < 3; ++first) {
      if (a[first] == b[first]) continue;
      const Voxel v = along(a, first);
      bool corner = false;
      for (std::size_t second = 0; second < 3; ++second) {
        const Voxel w = along(v, second);
        if (second == first || a[second] == b[second] || w == b) continue;
        corner = true;
        ways_.push_back({place(v), place(w)});
        places_.push_back(place(w));
      }
      if (!corner) ways_.push_back({place(v), kNoPlace});
      places_.push_back(place(v));
    }
  }

  /// Of an added voxel, or kNone.
  std::uint32_t index_of(Place p) const {
    const auto found = std::ranges::lower_bound(places_, p);
    if (found == places_.end() || *found != p) return kNone;
    const auto i = static_cast<std::uint32_t>(found - places_.begin());
    return added_[i] ? i : kNone;
  }
  bool is_inside(const Voxel& v) const {
    for (std::size_t a = 0; a < 3; ++a)
      if (v[a] < 0 || v[a] >= dims_[a]) return false;
    return true;
  }
  bool has(const Voxel& v) const {
    return is_inside(v) && (shape_.contains(v[0], v[1], v[2]) || index_of(place(v)) != kNone);
  }
  /// Of a voxel that is there.
  std::uint32_t element(const Voxel& v) const {
    const auto row = shape_.row(v[1], v[2]);
    const auto after = std::ranges::upper_bound(row, v[0], {}, &Run::begin);
    if (after != row.begin() && v[0] < (after - 1)->end)
      return first_index(shape_, row) + static_cast<std::uint32_t>(after - row.begin()) - 1;
    return static_cast<std::uint32_t>(shape_.runs().size()) + index_of(place(v));
  }
  /// Calls visit(element) for the voxels that share a face with one.
  template <class Visit>
  void for_neighbours(const Voxel& v, const Visit& visit) const {
    for (std::size_t a = 0; a < 3; ++a)
      for (const int step : {-1, 1}) {
        Voxel w = v;
        w[a] += step;
        if (has(w)) visit(element(w));
      }
  }

  /// By how much the Euler characteristic grows with a voxel; `also` is taken as there.
  int euler_of(const Voxel& v, const Voxel* also) const {
    std::array<bool, 27> there;
    for (int i = 0; i < 27; ++i) {
      const Voxel w{v[0] + i % 3 - 1, v[1] + i / 3 % 3 - 1, v[2] + i / 9 - 1};
      there[static_cast<std::size_t>(i)] = i == 13 || has(w) || (also && w == *also);
    }
    int euler = 1;
    const auto full = [&](std::initializer_list<int> steps) {
      // All sums of some of the steps.
      for (unsigned some = 1; some < 1u << steps.size(); ++some) {
        int at = 13;
        for (std::size_t s = 0; s < steps.size(); ++s)
          if (some >> s & 1) at += steps.begin()[s];
        if (!there[static_cast<std::size_t>(at)]) return 0;
      }
      return 1;
    };
    for (const int x : {-1, 1}) {
      euler -= full({x}) + full({3 * x}) + full({9 * x});
      for (const int y : {-1, 1}) {
        euler += full({x, 3 * y}) + full({x, 9 * y}) + full({3 * x, 9 * y});
        for (const int z : {-1, 1}) euler -= full({x, 3 * y, 9 * z});
      }
    }
    return euler;
  }

  Worth worth_of(const Way& way) {
    std::array<std::uint32_t, 12> faces, corners;
    std::size_t parts = 0, wholes = 0;
    const auto add = [](auto& list, std::size_t& size, std::uint32_t item) {
      if (std::find(list.begin(), list.begin() + size, item) == list.begin() + size) list[size++] = item;
    };
    Worth worth;
    worth.value = std::numeric_limits<double>::infinity();
    int euler = 0;
    Voxel first{};
    for (const Place p : way) {
      if (p == kNoPlace || has(voxel(p))) continue;
      const Voxel v = voxel(p);
      for_neighbours(v, [&](std::uint32_t e) {
        add(faces, parts, faces_.find(e));
        add(corners, wholes, corners_.find(e));
      });
      euler += euler_of(v, worth.voxels > 0 ? &first : nullptr);
      first = v;
      ++worth.voxels;
      if (values_) {
        const double value = values_->at(v[0], v[1], v[2]);
        worth.value = std::min(worth.value, std::isnan(value) ? -std::numeric_limits<double>::infinity() : value);
      }
    }
    if (worth.voxels == 0) return worth;
    worth.foreign = wholes > 1;
    worth.components = static_cast<int>(parts) - static_cast<int>(wholes);
    worth.loops = std::abs(1 - static_cast<int>(parts) - euler);
    return worth;
  }

  void take(const Way& way) {
    for (const Place p : way) {
      if (p == kNoPlace || has(voxel(p))) continue;
      const auto i = static_cast<std::size_t>(std::ranges::lower_bound(places_, p) - places_.begin());
      added_[i] = true;
      const auto own = static_cast<std::uint32_t>(shape_.runs().size() + i);
      --joined_;  // it is one itself
      for_neighbours(voxel(p), [&](std::uint32_t e) {
        joined_ += faces_.unite(own, e);
        corners_.unite(own, e);
      });
    }
  }

  const VoxelShape& shape_;
  const SignedSamples* values_;
  std::array<std::int64_t, 3> dims_;
  std::vector<Way> ways_;
  std::vector<Place> places_;              // of the voxels of all ways, ascending
  std::vector<bool> added_;                // of `places_`
  base::UnionFind faces_{0}, corners_{0};  // of the runs, then of `places_`
  std::int64_t joined_ = 0;
};

}  // namespace

VoxelShape joined(const VoxelShape& shape, const SignedSamples* values, ForegroundReport& report, Context* context) {
  base::UnionFind faces = foreground_components(shape, context), corners = touching_components(shape, context);
  if (faces.count() == corners.count()) return shape;
  Growing growing(shape, values, faces, corners);
  growing.join(context);
  return growing.result(report);
}

}  // namespace quench::shape
