// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <span>
#include <unordered_map>

#include "tree/measured_tree.h"

namespace quench::tree {
namespace {

// Points per ball: 4 to 128, so many in all. Of few balls each needs many, of many the errors even out.
constexpr int kFewestPoints = 4, kMostPoints = 128, kPoints = 4096;
constexpr double kBallSpacing = 0.5;  // of balls along a course, in radii

struct Ball {
  Vec3 centre;
  double radius;
};

// Points on the unit sphere, of equal areas: heights in equal steps, turned by the golden angle.
std::vector<Vec3> spread_directions(int count) {
  std::vector<Vec3> directions;
  const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
  for (int i = 0; i < count; ++i) {
    const double z = 1 - (2.0 * i + 1) / count, flat = std::sqrt(1 - z * z);
    directions.emplace_back(flat * std::cos(golden * i), flat * std::sin(golden * i), z);
  }
  return directions;
}

// Another turn for each ball (Shoemake 1992), so that what the points of one miss the next ones do not.
Mat3 turn_of(std::uint32_t ball) {
  std::uint64_t state = ball;
  const auto next = [&] {  // splitmix64
    std::uint64_t z = state += 0x9E3779B97F4A7C15ull;
    z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9ull;
    z = (z ^ z >> 27) * 0x94D049BB133111EBull;
    return std::ldexp(static_cast<double>((z ^ z >> 31) >> 11), -53);
  };
  const double u = next(), a = 2 * std::numbers::pi * next(), b = 2 * std::numbers::pi * next();
  const double near = std::sqrt(1 - u), far = std::sqrt(u);
  return Eigen::Quaterniond(near * std::sin(a), near * std::cos(a), far * std::sin(b), far * std::cos(b))
      .toRotationMatrix();
}

std::vector<Ball> balls_of(std::span<const Course> courses) {
  std::vector<Ball> balls;
  for (const Course& course : courses) {
    double at = 0;
    while (true) {
      const double radius = course.radius_at(at);
      if (radius > 0) balls.push_back({course.point_at(at), radius});
      if (at >= course.length()) break;
      // Never more than 4096 steps along one course, however thin it is.
      at = std::min(course.length(), at + std::max(kBallSpacing * radius, course.length() / 4096));
    }
  }
  return balls;
}

bool holds(const Ball& ball, const Vec3& x) { return (x - ball.centre).squaredNorm() < ball.radius * ball.radius; }

// Per ball the others that it meets.
class Neighbours {
 public:
  explicit Neighbours(const std::vector<Ball>& balls) : balls_(balls), meets_(balls.size()) {
    for (std::uint32_t b = 0; b < balls.size(); ++b)
      grids_[size_of(balls[b])][key(cell_of(balls[b].centre, size_of(balls[b])))].push_back(b);
    for (std::uint32_t b = 0; b < balls.size(); ++b) find(b);
  }
  std::span<const std::uint32_t> of(std::uint32_t ball) const { return meets_[ball]; }

 private:
  using Cell = std::array<std::int64_t, 3>;

  // A grid for every power of two, with cells as wide as two balls of its size: what meets a ball that is no larger
  // lies in the cells around it.
  void find(std::uint32_t b) {
    for (auto grid = grids_.lower_bound(size_of(balls_[b])); grid != grids_.end(); ++grid) {
      const Cell middle = cell_of(balls_[b].centre, grid->first);
      for (int k = 0; k < 27; ++k) {
        const auto found =
            grid->second.find(key({middle[0] + k % 3 - 1, middle[1] + k / 3 % 3 - 1, middle[2] + k / 9 - 1}));
        if (found == grid->second.end()) continue;
        for (const std::uint32_t other : found->second)
          if ((grid->first > size_of(balls_[b]) || other < b) && meet(balls_[b], balls_[other])) {
            meets_[b].push_back(other);
            meets_[other].push_back(b);
          }
      }
    }
  }
  static bool meet(const Ball& a, const Ball& b) {
    const double reach = a.radius + b.radius;
    return (a.centre - b.centre).squaredNorm() < reach * reach;
  }
  static int size_of(const Ball& ball) { return std::ilogb(ball.radius) + 2; }
  static Cell cell_of(const Vec3& x, int size) {
    Cell cell;
    for (int k = 0; k < 3; ++k)
      cell[static_cast<std::size_t>(k)] = static_cast<std::int64_t>(std::floor(std::scalbn(x[k], -size)));
    return cell;
  }
  static std::uint64_t key(const Cell& cell) {
    std::uint64_t hash = 0;
    for (const std::int64_t c : cell)
      hash = (hash ^ hash >> 29 ^ static_cast<std::uint64_t>(c)) * 0x9E3779B97F4A7C15ull;
    return hash;
  }

  const std::vector<Ball>& balls_;
  std::map<int, std::unordered_map<std::uint64_t, std::vector<std::uint32_t>>> grids_;  // by size
  std::vector<std::vector<std::uint32_t>> meets_;
};

// Whether another ball holds a point on the surface of one. Of equal balls only the first one shows.
bool is_covered(const std::vector<Ball>& balls, std::span<const std::uint32_t> others, std::uint32_t own,
                const Vec3& x) {
  return std::ranges::any_of(others, [&](std::uint32_t b) {
    if (balls[b].centre == balls[own].centre && balls[b].radius == balls[own].radius) return b < own;
    return holds(balls[b], x);
  });
}

}  // namespace

// Of the volume of each ball a point stands for its share, divided among the balls that hold it; of the surface, what
// no other ball holds.
BallUnion union_of_balls(std::span<const Course> courses) {
  const std::vector<Ball> balls = balls_of(courses);
  if (balls.empty()) return {};
  const int count = std::clamp(kPoints / static_cast<int>(balls.size()), kFewestPoints, kMostPoints);
  const std::vector<Vec3> directions = spread_directions(count);
  const Neighbours neighbours(balls);
  BallUnion result;
  for (std::uint32_t b = 0; b < balls.size(); ++b) {
    const Ball& ball = balls[b];
    const double surface = 4 * std::numbers::pi * ball.radius * ball.radius, volume = surface * ball.radius / 3;
    const std::span<const std::uint32_t> others = neighbours.of(b);
    const Mat3 turn = turn_of(b);
    for (int i = 0; i < count; ++i) {
      const Vec3 n = turn * directions[static_cast<std::size_t>(i)];
      if (!is_covered(balls, others, b, ball.centre + ball.radius * n)) result.surface += surface / count;
      // Evenly over the volume, and in another order than the heights of the directions.
      const double depth = std::cbrt(std::fmod((i + 0.5) * std::numbers::phi, 1));
      const Vec3 x = ball.centre + depth * ball.radius * n;
      const auto more = std::ranges::count_if(others, [&](std::uint32_t o) { return holds(balls[o], x); });
      result.volume += volume / count / static_cast<double>(1 + more);
    }
  }
  return result;
}

}  // namespace quench::tree
