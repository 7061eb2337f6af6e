// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <unordered_map>
#include <vector>

#include "samples/sample_shapes.h"

/// What the files of the `root` sample share.
namespace quench::samples {

/// Space between the tubes of branches that do not touch on purpose: three voxels at resolution 256.
inline constexpr double kRootClearance = 0.012;

/// Points of branches in cubic cells, to find the balls that come near to a place.
class BallGrid {
 public:
  void add(const RootBranch& branch, std::uint32_t number) {
    for (std::uint32_t i = 0; i < branch.points.size(); ++i) {
      Level& level = level_of(branch.radius[i]);
      const Cell cell = cell_of(branch.points[i], level.side);
      for (std::size_t a = 0; a < 3; ++a) {
        level.low[a] = std::min(level.low[a], cell[a]);
        level.high[a] = std::max(level.high[a], cell[a]);
      }
      level.cells[key(cell)].push_back({number, i});
    }
  }

  /// Whether some(branch, point) is true of a ball of which the surface is nearer to `place` than `reach`.
  template <class Some>
  bool any_near(const std::vector<RootBranch>& branches, const Vec3& place, double reach, const Some& some) const {
    for (const Level& level : levels_) {
      const double far = reach + level.largest;
      Cell low = cell_of(place - Vec3::Constant(far), level.side);
      Cell high = cell_of(place + Vec3::Constant(far), level.side);
      for (std::size_t a = 0; a < 3; ++a) {
        low[a] = std::max(low[a], level.low[a]);
        high[a] = std::min(high[a], level.high[a]);
      }
      for (std::int64_t z = low[2]; z <= high[2]; ++z)
        for (std::int64_t y = low[1]; y <= high[1]; ++y)
          for (std::int64_t x = low[0]; x <= high[0]; ++x) {
            const auto cell = level.cells.find(key({x, y, z}));
            if (cell == level.cells.end()) continue;
            for (const auto& [b, i] : cell->second) {
              const double limit = reach + branches[b].radius[i];
              if ((branches[b].points[i] - place).squaredNorm() < limit * limit && some(b, i)) return true;
            }
          }
    }
    return false;
  }

 private:
  using Cell = std::array<std::int64_t, 3>;
  static constexpr std::int64_t kNone = std::int64_t{1} << 40;
  /// Balls of similar size.
  struct Level {
    double side;     ///< of a cell
    double largest;  ///< radius
    Cell low = {kNone, kNone, kNone}, high = {-kNone, -kNone, -kNone};  ///< of all cells
    std::unordered_map<std::uint64_t, std::vector<std::pair<std::uint32_t, std::uint32_t>>> cells = {};
  };

  static Cell cell_of(const Vec3& p, double side) {
    return {static_cast<std::int64_t>(std::floor(p[0] / side)), static_cast<std::int64_t>(std::floor(p[1] / side)),
            static_cast<std::int64_t>(std::floor(p[2] / side))};
  }
  static std::uint64_t key(const Cell& c) {
    constexpr std::int64_t kHalf = 1 << 20;
    return static_cast<std::uint64_t>(c[0] + kHalf) << 42 | static_cast<std::uint64_t>(c[1] + kHalf) << 21 |
           static_cast<std::uint64_t>(c[2] + kHalf);
  }
  Level& level_of(double radius) {
    for (Level& level : levels_)
      if (radius <= level.largest) return level;
    return levels_.back();
  }

  std::array<Level, 3> levels_{{{0.012, 0.0055}, {0.015, 0.012}, {0.04, 0.04}}};
};

/// Of a polyline from a point to a later one.
double length_between(const std::vector<Vec3>& points, std::size_t from, std::size_t to);

/// The first point of a branch that is farther from its base than the radius of its parent there; the number of its
/// points where there is none.
std::size_t surfaced_at(const RootBranch& parent, const RootBranch& branch);

/// The first point of a branch that keeps the clearance to its parent; the number of its points where there is none.
std::size_t emerged_at(const RootBranch& parent, const RootBranch& branch);

/// Branches, and which places are free of them.
class RootSpace {
 public:
  explicit RootSpace(const std::vector<RootBranch>& branches) : branches_(branches) {}

  /// `branch` is, or will be, the one after those added before.
  void add(const RootBranch& branch) {
    const auto number = static_cast<std::uint32_t>(surface_.size());
    balls_.add(branch, number);
    surface_.push_back(branch.parent < 0 ? 0 : surfaced_at(parent_of(branch), branch));
  }

  const RootBranch& parent_of(const RootBranch& branch) const {
    return branches_[static_cast<std::size_t>(branch.parent)];
  }

  /// A branch of which each point is tested against the others.
  struct Course {
    const RootBranch& branch;
    std::size_t surface, out;  ///< surfaced_at(), emerged_at()
  };
  Course course(const RootBranch& branch) const {
    return {branch, surfaced_at(parent_of(branch), branch), emerged_at(parent_of(branch), branch)};
  }

  /// Whether a point of a branch is nearer than the clearance to another for which `counts(number)`. Its parent counts
  /// from where it has emerged, siblings from where both are out of their parent's tube.
  template <class Counts>
  bool collides(const Course& course, std::size_t i, const Counts& counts) const {
    const RootBranch& branch = course.branch;
    return balls_.any_near(branches_, branch.points[i], branch.radius[i] + kRootClearance,
                           [&](std::uint32_t other, std::uint32_t k) {
                             if (other == static_cast<std::uint32_t>(branch.parent))
                               return i >= course.out && counts(other);
                             if (branches_[other].parent != branch.parent) return counts(other);
                             return i >= course.surface && k >= surface_[other] && counts(other);
                           });
  }

  std::size_t surface(std::size_t branch) const { return surface_[branch]; }
  const BallGrid& balls() const { return balls_; }

 private:
  const std::vector<RootBranch>& branches_;
  std::vector<std::size_t> surface_;  // surfaced_at() of each branch
  BallGrid balls_;
};

/// Lets branches grow anew until they touch others, chooses gaps, and lists these and what touches by chance.
/// `redrawn`: another branch at the same place of the parent. Throws Error(usage) where there is no room for as many as
/// the options ask for.
void damage_root(Sample& sample, const SampleOptions& options, Random& random,
                 const std::function<RootBranch(const RootBranch&)>& redrawn);

}  // namespace quench::samples
