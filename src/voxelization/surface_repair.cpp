// SPDX-License-Identifier: Apache-2.0
#include "voxelization/surface_repair.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "quench/geometry.h"

namespace quench::voxelization {
namespace {

constexpr double kClearMajority =
    0.7;                               // of a patch's area must agree on its orientation, or the orientation is ignored
constexpr double kNearlyClosed = 0.1;  // largest sum of area vectors / area of a patch that counts as closed
constexpr std::size_t kMostHoleEdges = 24;
constexpr std::size_t kMostNested = 64;  // only the largest patches are tested for nesting

class Repair {
 public:
  Repair(std::span<const FixedPoint> points, std::span<const Triangle> welded) : points_(points) {
    take_one_of_each(welded);
    link();
    find_patches();
    orient_patches();
    for (std::size_t f = 0; f < faces_.size(); ++f)
      if (turned_[f]) {
        std::swap(faces_[f][1], faces_[f][2]);
        ++result_.flipped_faces;
      }
    fill_small_holes();
    result_.faces = std::move(faces_);
  }
  RepairedSurface result() { return std::move(result_); }

 private:
  struct Patch {
    std::vector<std::uint32_t> faces;
    double area = 0, turned_area = 0, volume = 0;
    Vec3 sum = Vec3::Zero();  // of area vectors, as oriented now
    Vec3 low = Vec3::Zero(), high = Vec3::Zero();
    bool closed() const { return sum.norm() < kNearlyClosed * area; }
  };

  Vec3 point(std::uint32_t p) const {
    const FixedPoint& q = points_[p];
    return Vec3(static_cast<double>(q[0]), static_cast<double>(q[1]), static_cast<double>(q[2])) *
           std::ldexp(1.0, -kFractionBits);
  }
  Vec3 twice_area(std::uint32_t f) const {  // as it was in the file
    const Vec3 a = point(faces_[f][0]);
    return (point(faces_[f][1]) - a).cross(point(faces_[f][2]) - a);
  }

  /// Keeps the first of the faces with the same three corners; one or none of them where both orientations occur.
  void take_one_of_each(std::span<const Triangle> welded) {
    std::vector<std::uint32_t> kept, doubtful;  // doubtful: in both orientations
    for_equal_faces(welded, [&](std::span<const std::uint32_t> equal) {
      const bool one_way = std::ranges::all_of(
          equal, [&](std::uint32_t f) { return is_even(welded[f]) == is_even(welded[equal.front()]); });
      (one_way ? kept : doubtful).push_back(equal.front());
      result_.duplicate_faces += static_cast<std::int64_t>(equal.size()) - 1;
    });
    for (auto* faces : {&kept, &doubtful}) {
      std::sort(faces->begin(), faces->end());
      for (const std::uint32_t f : *faces) faces_.push_back(welded[f]);
    }
    if (!doubtful.empty()) drop_doubtful(kept.size());
  }

  /// Whether the corners are an even permutation of the sorted ones.
  static bool is_even(const Triangle& t) { return (t[0] < t[1]) + (t[1] < t[2]) + (t[2] < t[0]) == 2; }

  /// Calls visit(faces) for all faces with the same three corners, ascending. Degenerate faces are left out.
  template <class Visit>
  static void for_equal_faces(std::span<const Triangle> welded, const Visit& visit) {
    const auto corners = [&](std::uint32_t f) {
      Triangle t = welded[f];
      std::sort(t.begin(), t.end());
      return t;
    };
    std::vector<std::uint32_t> order;
    for (std::uint32_t f = 0; f < welded.size(); ++f)
      if (const Triangle& t = welded[f]; t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) order.push_back(f);
    std::sort(order.begin(), order.end(), [&](std::uint32_t f, std::uint32_t g) {
      const Triangle a = corners(f), b = corners(g);
      return a != b ? a < b : f < g;
    });
    for (auto f = order.begin(); f != order.end();) {
      const auto after = std::find_if(f, order.end(), [&](std::uint32_t g) { return corners(g) != corners(*f); });
      visit(std::span<const std::uint32_t>(f, after));
      f = after;
    }
  }

  /// Of the faces from `sure` on keeps those that leave fewer edges with an odd number of faces: a face is taken or
  /// left out anew as long as that makes them fewer.
  void drop_doubtful(std::size_t sure) {
    std::vector<std::uint32_t> edge(3 * faces_.size());
    std::vector<char> odd;
    for_each_edge(points_.size(), faces_, [&](std::uint32_t, std::uint32_t, std::span<const FaceSide> sides) {
      char parity = 0;
      for (const FaceSide& s : sides) {
        edge[s.side] = static_cast<std::uint32_t>(odd.size());
        parity ^= s.side / 3 < sure ? 1 : 0;
      }
      odd.push_back(parity);
    });
    std::vector<char> chosen(faces_.size(), 0);
    for (bool changed = true; changed;) {
      changed = false;
      for (std::size_t f = sure; f < faces_.size(); ++f) {
        const std::uint32_t* sides = &edge[3 * f];
        if (odd[sides[0]] + odd[sides[1]] + odd[sides[2]] < 2) continue;
        for (std::size_t k = 0; k < 3; ++k) odd[sides[k]] ^= 1;
        chosen[f] ^= 1;
        changed = true;
      }
    }
    std::size_t end = sure;
    for (std::size_t f = sure; f < faces_.size(); ++f)
      if (chosen[f]) faces_[end++] = faces_[f];
    result_.duplicate_faces += static_cast<std::int64_t>(faces_.size() - end);
    faces_.resize(end);
  }

  void link() {
    other_.assign(3 * faces_.size(), kNone);
    for_each_edge(points_.size(), faces_, [&](std::uint32_t, std::uint32_t, std::span<const FaceSide> sides) {
      if (sides.size() != 2) return;
      for (std::size_t i = 0; i < 2; ++i) other_[sides[i].side] = sides[1 - i].side;
    });
  }

  void find_patches() {
    turned_.assign(faces_.size(), 0);
    std::vector<char> seen(faces_.size(), 0);
    for (std::uint32_t first = 0; first < faces_.size(); ++first) {
      if (seen[first]) continue;
      seen[first] = 1;
      Patch patch;
      patch.faces.push_back(first);
      for (std::size_t at = 0; at < patch.faces.size(); ++at) {
        const std::uint32_t f = patch.faces[at];
        for (std::uint32_t i = 0; i < 3; ++i) {
          const std::uint32_t other = other_[3 * f + i];
          if (other == kNone || seen[other / 3]) continue;
          seen[other / 3] = 1;
          const bool agree = is_upward(faces_, 3 * f + i) != is_upward(faces_, other);
          turned_[other / 3] = static_cast<char>(turned_[f] ^ (agree ? 0 : 1));
          patch.faces.push_back(other / 3);
        }
      }
      patches_.push_back(std::move(patch));
    }
  }

  void measure(Patch& patch) const {
    const Vec3 origin = point(faces_[patch.faces.front()][0]);
    patch.low = patch.high = origin;
    for (const std::uint32_t f : patch.faces) {
      const Vec3 normal = twice_area(f);
      const double sign = turned_[f] ? -1 : 1;
      patch.area += normal.norm();
      if (turned_[f]) patch.turned_area += normal.norm();
      patch.sum += sign * normal;
      patch.volume += sign * normal.dot(point(faces_[f][0]) - origin);
      for (const std::uint32_t corner : faces_[f]) {
        patch.low = patch.low.cwiseMin(point(corner));
        patch.high = patch.high.cwiseMax(point(corner));
      }
    }
    // Relative to the middle of its box: this makes the error of a hole smallest.
    patch.volume += patch.sum.dot(origin - (patch.low + patch.high) / 2);
  }

  void turn(Patch& patch) {
    for (const std::uint32_t f : patch.faces) turned_[f] ^= 1;
    patch.turned_area = patch.area - patch.turned_area;
    patch.sum = -patch.sum;
    patch.volume = -patch.volume;
  }

  void orient_patches() {
    std::vector<std::size_t> large;  // nearly closed ones by volume: what a patch can be nested in
    std::vector<char> unclear(patches_.size(), 0);
    double volume = 0;
    for (std::size_t i = 0; i < patches_.size(); ++i) {
      Patch& patch = patches_[i];
      measure(patch);
      if (patch.turned_area > patch.area / 2) turn(patch);
      unclear[i] = patch.turned_area > (1 - kClearMajority) * patch.area;
      if (!patch.closed()) continue;
      large.push_back(i);
      if (!unclear[i]) volume += patch.volume;
    }
    // A mesh that faces inward as a whole is as good as one that faces outward: |w| is the same.
    const double outward = volume < 0 ? -1 : 1;
    for (std::size_t i = 0; i < patches_.size(); ++i)
      if (unclear[i] && patches_[i].volume * outward < 0) turn(patches_[i]);
    std::stable_sort(large.begin(), large.end(), [&](std::size_t i, std::size_t j) {
      return std::abs(patches_[i].volume) > std::abs(patches_[j].volume);
    });
    const std::span<const std::size_t> outer = std::span(large).first(std::min(large.size(), kMostNested));
    const auto in_box = [&](const Patch& inner, const Patch& patch) {
      return (inner.low.array() > patch.low.array()).all() && (inner.high.array() < patch.high.array()).all();
    };
    for (const std::size_t i : large) {
      Patch& patch = patches_[i];
      if (unclear[i]) {
        std::size_t around = 0;
        for (const std::size_t j : outer)
          if (j != i && in_box(patch, patches_[j])) around += inside(patch, patches_[j]);
        if (around % 2 != 0) turn(patch);
      } else if (patch.volume * outward < 0 && std::none_of(outer.begin(), outer.end(), [&](std::size_t j) {
                   return j != i && in_box(patch, patches_[j]);
                 })) {
        turn(patch);
        ++result_.flipped_components;
      }
    }
  }

  /// A 32nd of the longest side, from 1 to 16 voxels.
  std::int64_t widest_hole() const {
    std::int64_t longest = 0;
    for (std::size_t a = 0; a < 3; ++a) {
      const auto by_axis = [a](const FixedPoint& p, const FixedPoint& q) { return p[a] < q[a]; };
      const auto [low, high] = std::minmax_element(points_.begin(), points_.end(), by_axis);
      if (low != points_.end()) longest = std::max(longest, (*high)[a] - (*low)[a]);
    }
    constexpr std::int64_t kVoxel = std::int64_t{1} << kFractionBits;
    return std::clamp(longest / 32, kVoxel, 16 * kVoxel);
  }

  void fill_small_holes() {
    const std::vector<BoundaryEdge> chain = boundary_chain(points_.size(), faces_);
    if (chain.empty()) return;
    std::vector<std::uint32_t> patch_size(points_.size(), 0);  // the smallest patch at a point
    for (const Patch& patch : patches_)
      for (const std::uint32_t f : patch.faces)
        for (const std::uint32_t p : faces_[f]) {
          const auto size = static_cast<std::uint32_t>(patch.faces.size());
          patch_size[p] = patch_size[p] == 0 ? size : std::min(patch_size[p], size);
        }
    // Where holes share points, any cycles will do: together their fans have the same boundary.
    const auto out = edges_from(points_.size(), chain);
    std::vector<char> used(chain.size(), 0);
    for (std::size_t e = 0; e < chain.size(); ++e) used[e] = chain[e].times > 1;
    const std::int64_t widest = widest_hole();
    std::vector<std::uint32_t> path, loop;  // edges, points
    for (std::uint32_t start = 0; start < chain.size(); ++start) {
      path.clear();
      for (std::uint32_t p = chain[start].from; path.size() <= kMostHoleEdges;) {
        const auto on_path =
            std::find_if(path.begin(), path.end(), [&](std::uint32_t e) { return chain[e].from == p; });
        if (on_path != path.end()) {  // a cycle
          loop.clear();
          for (auto e = on_path; e != path.end(); ++e) loop.push_back(chain[*e].from);
          for (auto e = on_path; e != path.end(); ++e) used[*e] = 1;
          path.erase(on_path, path.end());
          if (loop.size() <= kMostHoleEdges) fill_if_small(loop, widest, patch_size);
        }
        const auto next = std::find_if(out[p].begin(), out[p].end(), [&](std::uint32_t e) { return !used[e]; });
        if (next == out[p].end()) break;
        path.push_back(*next);
        p = chain[*next].to;
      }
    }
  }

  void fill_if_small(const std::vector<std::uint32_t>& loop, std::int64_t widest,
                     const std::vector<std::uint32_t>& patch_size) {
    const FixedPoint& first = points_[loop[0]];
    const bool small = loop.size() >= 3 && std::all_of(loop.begin(), loop.end(), [&](std::uint32_t q) {
                         for (std::size_t a = 0; a < 3; ++a)
                           if (std::abs(points_[q][a] - first[a]) >= widest) return false;
                         return patch_size[q] > 4 * loop.size();
                       });
    if (!small) return;
    for (std::size_t i = 2; i < loop.size(); ++i) faces_.push_back({loop[0], loop[i], loop[i - 1]});
    ++result_.filled_holes;
  }

  /// Whether points of `inner` are inside `patch`, by the sum of solid angles.
  bool inside(const Patch& inner, const Patch& patch) const {
    constexpr std::size_t kSamples = 5;
    for (std::size_t k = 0; k < kSamples; ++k) {
      const Vec3 p = point(faces_[inner.faces[inner.faces.size() * k / kSamples]][0]);
      double angle = 0;
      for (const std::uint32_t f : patch.faces) {
        const Vec3 a = point(faces_[f][0]) - p, b = point(faces_[f][1]) - p, c = point(faces_[f][2]) - p;
        const double la = a.norm(), lb = b.norm(), lc = c.norm();
        const double whole =
            2 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
        angle += turned_[f] ? -whole : whole;
      }
      if (std::abs(angle) < 2 * std::numbers::pi) return false;
    }
    return true;
  }

  std::span<const FixedPoint> points_;
  std::vector<Triangle> faces_;
  std::vector<std::uint32_t> other_;  // per side: the opposite one, where its edge has exactly two; else kNone
  std::vector<char> turned_;
  std::vector<Patch> patches_;
  RepairedSurface result_;
};

}  // namespace

RepairedSurface repair_orientation(std::span<const FixedPoint> points, std::span<const Triangle> welded) {
  return Repair(points, welded).result();
}

}  // namespace quench::voxelization
