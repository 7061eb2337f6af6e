// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "geodesic/voxel_surface.h"
#include "quench/error.h"

namespace quench::geodesic {

/// Exact shortest ways on a VoxelSurface from one point, by propagation of windows (Chen and Han 1990; Mitchell, Mount
/// and Papadimitriou 1987; the tests by distances of vertices are those of Xin and Wang 2009).
///
/// A window is a cone of straight ways from a source, the point searched from or a saddle, through a side of a square,
/// in the plane of this square. The cone is bounded by two points of the lattice, so all coordinates are integers, and
/// every decision between left and right is exact while they are below kExact, which is checked. A window is dropped
/// only where the ways in it are longer than others by more than rounding, so the order does not matter for the result,
/// only for the cost. Windows of one source that meet beyond a flat vertex are merged.
///
/// Lengths are in units of VoxelSurface. About 45 bytes per square; a search takes time and memory for the part of the
/// surface it gets to only.
class WindowSearch {
 public:
  static constexpr double kInfinite = std::numeric_limits<double>::infinity();

  /// Products of smaller coordinates are below 2^52, so that their differences are exact.
  static constexpr double kExact = 0x1p26;

  /// `exact`: a smaller bound than kExact, for tests. Searches throw Error(failed) when a straight way outgrows it.
  explicit WindowSearch(const VoxelSurface& surface, double exact = kExact);

  /// Finds the distances of the targets that are within `limit`, of all points within it where there are no targets.
  /// Returns whether those of all targets are known; false, too, after `budget` windows. `rest(point)`: at most the
  /// distance from a point to the nearest target (0 is); ways that are too long with it are not followed.
  template <class Rest>
  bool search(std::uint32_t from, std::span<const std::uint32_t> targets, double limit, std::int64_t budget,
              const Rest& rest);

  /// After a search: the length of the shortest way to a point, infinite where it was not found. Of a target it is
  /// exact if it is at most `limit`.
  double distance(std::uint32_t point) const {
    return point_[point].search == search_ ? point_[point].distance : kInfinite;
  }
  /// Windows of the last search: its cost.
  std::int64_t windows() const { return windows_; }

 private:
  struct Window {
    double x, y;            // the source; the half-edge runs from 0 along x, its square is where y > 0
    double lx, ly, rx, ry;  // points on the bounding ways, left and right
    double source_distance;
    std::uint32_t source, next;
  };
  struct Point {
    double distance, rest, spread;  // from which the point was a source last
    std::uint32_t search = 0;
  };
  struct Pending {
    std::uint32_t first = kNone, search = 0;  // windows
    std::uint32_t bucket = 0;
  };

  static double cross(double ax, double ay, double bx, double by) { return ax * by - ay * bx; }

  template <class Rest>
  Point& point(std::uint32_t p, const Rest& rest) {
    Point& found = point_[p];
    if (found.search != search_) found = {kInfinite, rest(p), kInfinite, search_};
    return found;
  }
  template <class Rest>
  void reach(std::uint32_t p, double distance, const Rest& rest);
  template <class Rest>
  void spread(std::uint32_t p, const Rest& rest);
  template <class Rest>
  void pass(std::uint32_t half_edge, const Window& window, const Rest& rest);
  template <class Rest>
  void add(std::uint32_t half_edge, Window window, const Rest& rest);
  bool is_useless(std::uint32_t half_edge, const Window& window, double ends_distance, double begin_distance) const;
  bool merge(std::uint32_t first, const Window& window);
  void put(std::uint32_t what, std::size_t bucket);
  [[noreturn]] static void refuse_length();
  std::size_t bucket_of(double key) const {
    return std::max(bucket_, static_cast<std::size_t>(key * buckets_per_unit_));
  }

  static constexpr std::uint32_t kPointFlag = std::uint32_t{1} << 31;

  const VoxelSurface& surface_;
  double longest_straight_;  // so that coordinates are exact
  double half_side_;         // of the longest
  double buckets_per_unit_;  // four in the shortest
  std::uint32_t search_ = 0;
  std::vector<Point> point_;
  std::vector<Pending> pending_;
  std::vector<Window> pool_;
  std::uint32_t free_ = kNone;
  std::vector<std::vector<std::uint32_t>> buckets_;
  std::size_t bucket_ = 0, last_bucket_ = 0;
  double limit_ = kInfinite;
  std::int64_t windows_ = 0;
};

inline WindowSearch::WindowSearch(const VoxelSurface& surface, double exact)
    : surface_(surface), point_(surface.points()), pending_(surface.half_edges()) {
  half_side_ = 0.5 * std::ranges::max(surface.step());
  // Ways in a window cross the side, and what bounds them is a corner of a square that one of them crosses: all that is
  // subtracted in pass() and merge() is within two sides of a way to the middle.
  longest_straight_ = exact - 8 * half_side_;
  buckets_per_unit_ = 4 / surface.smallest_step();
}

inline void WindowSearch::put(std::uint32_t what, std::size_t bucket) {
  if (bucket >= buckets_.size()) buckets_.resize(std::max(bucket + 1, 2 * buckets_.size()));
  last_bucket_ = std::max(last_bucket_, bucket);
  buckets_[bucket].push_back(what);
}

template <class Rest>
bool WindowSearch::search(std::uint32_t from, std::span<const std::uint32_t> targets, double limit, std::int64_t budget,
                          const Rest& rest) {
  if (++search_ == 0) {
    for (Point& p : point_) p.search = 0;
    for (Pending& p : pending_) p.search = 0;
    search_ = 1;
  }
  pool_.clear();
  free_ = kNone;
  limit_ = limit;
  windows_ = 0;
  bucket_ = last_bucket_ = 0;
  const auto farthest = [&] {
    double distance = 0;
    for (const std::uint32_t t : targets) distance = std::max(distance, this->distance(t));
    return distance;
  };
  reach(from, 0, rest);
  spread(from, rest);
  for (; bucket_ <= last_bucket_ && bucket_ < buckets_.size() && windows_ <= budget; ++bucket_) {
    if (!targets.empty()) limit_ = std::min(limit_, farthest());
    if (static_cast<double>(bucket_) / buckets_per_unit_ - half_side_ > limit_) break;
    for (std::size_t i = 0; i < buckets_[bucket_].size(); ++i) {
      const std::uint32_t what = buckets_[bucket_][i];
      if (what & kPointFlag) {
        spread(what & ~kPointFlag, rest);
        continue;
      }
      std::uint32_t w = std::exchange(pending_[what].first, kNone);
      while (w != kNone) {
        const Window window = pool_[w];
        pool_[w].next = free_;
        free_ = w;
        w = window.next;
        pass(what, window, rest);
      }
    }
    buckets_[bucket_].clear();
  }
  for (; bucket_ <= last_bucket_ && bucket_ < buckets_.size(); ++bucket_) buckets_[bucket_].clear();
  return windows_ <= budget && (targets.empty() || farthest() <= limit);
}

template <class Rest>
void WindowSearch::reach(std::uint32_t p, double distance, const Rest& rest) {
  Point& reached = point(p, rest);
  if (!(distance < reached.distance)) return;
  reached.distance = distance;
  if (surface_.is_saddle(p) && distance + reached.rest <= limit_) put(p | kPointFlag, bucket_of(distance));
}

// The straight ways from a point into all squares around it.
template <class Rest>
void WindowSearch::spread(std::uint32_t p, const Rest& rest) {
  const double d = point_[p].distance;
  if (!(d < point_[p].spread)) return;
  point_[p].spread = d;
  for (const std::uint32_t h : surface_.around(p)) {
    const std::uint32_t square = h & ~3u;
    const std::uint32_t right = square | ((h + 1) & 3u), top = square | ((h + 2) & 3u), left = square | ((h + 3) & 3u);
    const double width = surface_.length(h), height = surface_.length(right);
    reach(surface_.begin(right), d + width, rest);
    reach(surface_.begin(top), d + std::sqrt(width * width + height * height), rest);
    reach(surface_.begin(left), d + height, rest);
    // In the squares beyond: as in pass().
    add(surface_.twin(right), {height, -width, 0, 0, height, 0, d, p, kNone}, rest);
    add(surface_.twin(top), {0, -height, 0, 0, width, 0, d, p, kNone}, rest);
  }
}

template <class Rest>
void WindowSearch::pass(std::uint32_t h, const Window& w, const Rest& rest) {
  if (point_[w.source].distance < w.source_distance) return;
  const std::uint32_t square = h & ~3u;
  const std::uint32_t right = square | ((h + 1) & 3u), top = square | ((h + 2) & 3u), left = square | ((h + 3) & 3u);
  if (is_useless(h, w, point(surface_.begin(right), rest).distance, point(surface_.begin(h), rest).distance)) return;
  const double width = surface_.length(h), height = surface_.length(right);
  const double lx = w.lx - w.x, ly = w.ly - w.y, rx = w.rx - w.x, ry = w.ry - w.y;
  const double tx = -w.x, ux = width - w.x, ty = height - w.y;  // the two corners beyond, left and right
  const double left_of_t = cross(lx, ly, tx, ty), right_of_t = cross(rx, ry, tx, ty);
  const double left_of_u = cross(lx, ly, ux, ty), right_of_u = cross(rx, ry, ux, ty);
  if (left_of_t <= 0 && right_of_t >= 0)
    reach(surface_.begin(left), w.source_distance + std::sqrt(tx * tx + ty * ty), rest);
  if (left_of_u <= 0 && right_of_u >= 0)
    reach(surface_.begin(top), w.source_distance + std::sqrt(ux * ux + ty * ty), rest);
  if (left_of_t < 0) {  // ways to the left side
    Window next{w.y, -w.x, w.ly, -w.lx, w.ry, -w.rx, w.source_distance, w.source, kNone};
    if (right_of_t > 0) next.rx = height, next.ry = 0;
    add(surface_.twin(left), next, rest);
  }
  if (right_of_u > 0) {
    Window next{height - w.y, w.x - width,       height - w.ly, w.lx - width, height - w.ry,
                w.rx - width, w.source_distance, w.source,      kNone};
    if (left_of_u < 0) next.lx = 0, next.ly = 0;
    add(surface_.twin(right), next, rest);
  }
  if (right_of_t > 0 && left_of_u < 0) {
    Window next{w.x, w.y - height, w.lx, w.ly - height, w.rx, w.ry - height, w.source_distance, w.source, kNone};
    if (left_of_t < 0) next.lx = 0, next.ly = 0;
    if (right_of_u > 0) next.rx = width, next.ry = 0;
    add(surface_.twin(top), next, rest);
  }
}

// Whether ways along the side from its ends are shorter than those in the window: so it is where the two are equally
// long, or at the end of the window next to that place, then everywhere.
inline bool WindowSearch::is_useless(std::uint32_t h, const Window& w, double end, double begin) const {
  const double width = surface_.length(h);
  if (end == kInfinite && begin == kInfinite) return false;
  const double a = w.x - (w.lx - w.x) * w.y / (w.ly - w.y), b = w.x - (w.rx - w.x) * w.y / (w.ry - w.y);
  const double even = end == kInfinite ? b : begin == kInfinite ? a : 0.5 * (width + end - begin);
  const double x = std::clamp(even, a, std::max(a, b));
  const double along = std::min(begin + x, end + width - x);
  const double straight = w.source_distance + std::sqrt((x - w.x) * (x - w.x) + w.y * w.y);
  return along < straight - 1e-11 * straight;
}

template <class Rest>
void WindowSearch::add(std::uint32_t h, Window w, const Rest& rest) {
  const Point& begin = point(surface_.begin(h), rest);
  const Point& end = point(surface_.begin((h & ~3u) | ((h + 1) & 3u)), rest);
  if (is_useless(h, w, end.distance, begin.distance)) return;
  const double width = surface_.length(h);
  if (limit_ < kInfinite) {
    const double a = w.x - (w.lx - w.x) * w.y / (w.ly - w.y), b = w.x - (w.rx - w.x) * w.y / (w.ry - w.y);
    const double x = std::clamp(0.5 * (width + begin.rest - end.rest), a, std::max(a, b));
    const double straight = w.source_distance + std::sqrt((x - w.x) * (x - w.x) + w.y * w.y);
    if (straight + std::max(begin.rest - x, end.rest - width + x) > limit_ * (1 + 1e-12)) return;
  }
  Pending& pending = pending_[h];
  if (pending.search != search_) pending = {kNone, search_, 0};
  const bool waits = pending.first != kNone;
  if (waits && merge(pending.first, w)) return;
  ++windows_;
  w.next = pending.first;
  if (free_ == kNone) {
    pending.first = static_cast<std::uint32_t>(pool_.size());
    pool_.push_back(w);
  } else {
    pending.first = free_;
    free_ = pool_[free_].next;
    pool_[pending.first] = w;
  }
  const double mx = 0.5 * width - w.x, straight = std::sqrt(mx * mx + w.y * w.y);
  if (!(straight < longest_straight_)) refuse_length();
  const std::size_t bucket = bucket_of(w.source_distance + straight);
  if (waits && pending.bucket <= bucket) return;
  pending.bucket = static_cast<std::uint32_t>(bucket);
  put(h, bucket);
}

inline void WindowSearch::refuse_length() {
  throw Error(ErrorCode::failed,
              "a straight way on the surface of the voxel shape is too long for exact distances along it; choose a "
              "smaller resolution, or a spacing in a proportion of smaller whole numbers");
}

inline bool WindowSearch::merge(std::uint32_t first, const Window& w) {
  for (std::uint32_t i = first; i != kNone; i = pool_[i].next) {
    Window& other = pool_[i];
    if (other.source != w.source || other.x != w.x || other.y != w.y || other.source_distance != w.source_distance)
      continue;
    if (cross(other.rx - w.x, other.ry - w.y, w.lx - w.x, w.ly - w.y) == 0) {
      other.rx = w.rx;
      other.ry = w.ry;
      return true;
    }
    if (cross(other.lx - w.x, other.ly - w.y, w.rx - w.x, w.ry - w.y) == 0) {
      other.lx = w.lx;
      other.ly = w.ly;
      return true;
    }
  }
  return false;
}

}  // namespace quench::geodesic
