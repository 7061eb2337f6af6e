// SPDX-License-Identifier: Apache-2.0
#include "geodesic/pair_distances.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>

#include "base/parallel.h"
#include "geodesic/window_search.h"

namespace quench::geodesic {
namespace {

constexpr double kInfinite = WindowSearch::kInfinite;
constexpr std::int64_t kNoBudget = std::numeric_limits<std::int64_t>::max();

using Pairs = std::span<const std::array<std::uint32_t, 2>>;

class StraightDistances {
 public:
  explicit StraightDistances(const VoxelSurface& surface) : surface_(surface) {}
  double operator()(std::uint32_t a, std::uint32_t b) const {
    double squared = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const double d = (surface_.place(a)[i] - surface_.place(b)[i]) * surface_.step()[i];
      squared += d * d;
    }
    return std::sqrt(squared) * (1 - 1e-15);
  }

 private:
  const VoxelSurface& surface_;
};

/// Distances of all points from some, in single precision.
class Landmarks {
 public:
  /// Of `candidates`, far from each other.
  Landmarks(const VoxelSurface& surface, std::vector<std::uint32_t> candidates, std::size_t count)
      : points_(surface.points()) {
    const StraightDistances straight(surface);
    std::vector<double> nearest(candidates.size(), kInfinite);
    std::size_t next = 0;
    while (at_.size() < count && nearest[next] > 0) {
      at_.push_back(candidates[next]);
      for (std::size_t i = 0; i < candidates.size(); ++i)
        nearest[i] = std::min(nearest[i], straight(candidates[i], at_.back()));
      next = static_cast<std::size_t>(std::ranges::max_element(nearest) - nearest.begin());
    }
    distance_.resize(at_.size() * points_);
  }

  std::size_t count() const { return at_.size(); }
  std::uint32_t at(std::size_t landmark) const { return at_[landmark]; }
  void set(std::size_t landmark, const WindowSearch& search) {
    for (std::uint32_t p = 0; p < points_; ++p)
      distance_[landmark * points_ + p] = static_cast<float>(search.distance(p));
  }
  double distance(std::size_t landmark, std::uint32_t point) const {
    return double{distance_[landmark * points_ + point]};
  }

 private:
  std::size_t points_;
  std::vector<std::uint32_t> at_;
  std::vector<float> distance_;  // per landmark and point
};

/// The landmarks that say most of a pair, and what they say.
struct Bounds {
  static constexpr std::size_t kMost = 4;
  std::array<std::size_t, kMost> landmark;
  std::array<double, kMost> of_target;
  std::size_t count = 0;
  double least, most = kInfinite;

  Bounds(const Landmarks& landmarks, std::array<std::uint32_t, 2>& pair, double straight) : least(straight) {
    std::vector<std::pair<double, std::size_t>> gains;
    double forward = 0, backward = 0;
    for (std::size_t l = 0; l < landmarks.count(); ++l) {
      const double a = landmarks.distance(l, pair[0]), b = landmarks.distance(l, pair[1]);
      if (a == kInfinite) continue;  // another component
      most = std::min(most, (a + b) * (1 + kRounding));
      forward = std::max(forward, a - b);
      backward = std::max(backward, b - a);
      gains.emplace_back(a - b, l);
    }
    if (backward > forward) {
      std::swap(pair[0], pair[1]);
      for (auto& gain : gains) gain.first = -gain.first;
    }
    count = std::min(kMost, gains.size());
    std::partial_sort(gains.begin(), gains.begin() + static_cast<std::ptrdiff_t>(count), gains.end(), std::greater<>());
    for (std::size_t i = 0; i < count; ++i) {
      landmark[i] = gains[i].second;
      of_target[i] = landmarks.distance(landmark[i], pair[1]) * (1 + kRounding);
    }
  }

  double rest(const Landmarks& landmarks, std::uint32_t point, double straight) const {
    for (std::size_t i = 0; i < count; ++i)
      straight = std::max(straight, landmarks.distance(landmark[i], point) * (1 - kRounding) - of_target[i]);
    return straight;
  }

  static constexpr double kRounding = 1.2e-7;  // of single precision
};

class Distances {
 public:
  Distances(const VoxelSurface& surface, Pairs pairs, Context* context)
      : surface_(surface),
        pairs_(pairs),
        context_(context),
        straight_(surface),
        searches_([&] { return WindowSearch(surface_); }),
        distance_(pairs.size(), -1) {}

  std::vector<double> find(std::int64_t landmark_bytes, PairCounts& counts) {
    base::for_indices(pairs_.size(), [&](std::size_t i) {
      const auto [a, b] = pairs_[i];
      if (surface_.component(a) != surface_.component(b)) distance_[i] = kInfinite;
      if (a == b) distance_[i] = 0;
    });
    for_pairs(0, 0.1, unknown(), 512, [&](std::size_t i) { find_near(i); });
    const std::vector<std::uint32_t> far = unknown();
    if (!far.empty()) {
      const Landmarks landmarks = make_landmarks(far, landmark_bytes);
      counts.landmarks = landmarks.count();
      for_pairs(0.3, 1, far, 16, [&](std::size_t i) { find_far(i, landmarks); });
    }
    counts.far = far.size();
    counts.near = pairs_.size() - far.size();
    counts.windows = windows_;
    return std::move(distance_);
  }

 private:
  std::vector<std::uint32_t> unknown() const {
    std::vector<std::uint32_t> list;
    for (std::uint32_t i = 0; i < distance_.size(); ++i)
      if (distance_[i] < 0) list.push_back(i);
    return list;
  }

  template <class Work>
  void for_pairs(double begin, double end, const std::vector<std::uint32_t>& list, std::size_t size, const Work& work) {
    const std::size_t chunks = base::chunks_for(list.size(), size);
    base::for_chunks(chunks, context_, "geodesics", begin, end, [&](std::size_t chunk) {
      const auto [first, last] = base::part_of(list.size(), chunk, chunks);
      for (std::size_t i = first; i < last; ++i) work(list[i]);
    });
  }

  void find_near(std::size_t pair) {
    constexpr std::int64_t budget = 1000;
    WindowSearch& search = searches_.local();
    const auto [from, to] = pairs_[pair];
    const double straight = straight_(from, to);
    for (const double factor : {1.1, 1.5, 2.5}) {
      const bool found = search.search(from, {&to, 1}, factor * (straight + surface_.smallest_step()), budget,
                                       [&, to = to](std::uint32_t point) { return straight_(point, to); });
      windows_ += search.windows();
      if (found) distance_[pair] = search.distance(to);
      if (found || search.windows() > budget) return;
    }
  }

  Landmarks make_landmarks(const std::vector<std::uint32_t>& far, std::int64_t bytes) {
    std::vector<char> needed(surface_.points(), 0);
    for (const std::uint32_t pair : far) needed[surface_.component(pairs_[pair][0])] = 1;
    std::vector<std::uint32_t> candidates;
    for (std::uint32_t p = 0; p < surface_.points(); ++p)
      if (needed[surface_.component(p)]) candidates.push_back(p);
    constexpr std::size_t most_candidates = 20000;
    const std::size_t step = candidates.size() / most_candidates + 1;
    for (std::size_t i = 0; i * step < candidates.size(); ++i) candidates[i] = candidates[i * step];
    candidates.resize((candidates.size() + step - 1) / step);
    const double wanted = std::sqrt(static_cast<double>(far.size()));
    const auto allowed = static_cast<double>(bytes) / (4 * static_cast<double>(surface_.points()));
    Landmarks landmarks(surface_, std::move(candidates),
                        static_cast<std::size_t>(std::max(1.0, std::min(wanted, allowed))));
    base::for_chunks(landmarks.count(), context_, "geodesics", 0.1, 0.3, [&](std::size_t l) {
      WindowSearch& search = searches_.local();
      search.search(landmarks.at(l), {}, kInfinite, kNoBudget, [](std::uint32_t) { return 0.0; });
      windows_ += search.windows();
      landmarks.set(l, search);
    });
    return landmarks;
  }

  void find_far(std::size_t i, const Landmarks& landmarks) {
    WindowSearch& search = searches_.local();
    std::array<std::uint32_t, 2> pair = pairs_[i];
    const Bounds bounds(landmarks, pair, straight_(pair[0], pair[1]));
    const auto rest = [&](std::uint32_t point) { return bounds.rest(landmarks, point, straight_(point, pair[1])); };
    const double least = rest(pair[0]);
    for (double slack = surface_.smallest_step();; slack *= 2) {
      const double limit = std::min(least + slack, bounds.most);
      const bool found = search.search(pair[0], {&pair[1], 1}, limit, kNoBudget, rest);
      windows_ += search.windows();
      if (!found && limit < bounds.most) continue;
      distance_[i] = search.distance(pair[1]);
      return;
    }
  }

  const VoxelSurface& surface_;
  Pairs pairs_;
  Context* context_;
  StraightDistances straight_;
  tbb::enumerable_thread_specific<WindowSearch> searches_;
  std::vector<double> distance_;  // -1: not known
  std::atomic<std::int64_t> windows_{0};
};

}  // namespace

std::vector<double> pair_distances(const VoxelSurface& surface, Pairs pairs, std::int64_t landmark_bytes,
                                   Context* context, PairCounts* counts) {
  PairCounts unused;
  return Distances(surface, pairs, context).find(landmark_bytes, counts ? *counts : unused);
}

}  // namespace quench::geodesic
