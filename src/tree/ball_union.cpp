// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
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

// Balls by the cells of grids whose cells are as wide as they are: a point is only in balls of the cells around it, of
// each size.
class BallGrids {
 public:
  explicit BallGrids(const std::vector<Ball>& balls) : balls_(balls) {
    for (std::uint32_t b = 0; b < balls.size(); ++b) {
      const int size = size_of(balls[b].radius);
      auto grid = std::ranges::find(sizes_, size);
      if (grid == sizes_.end()) {
        sizes_.push_back(size);
        cells_.emplace_back();
        grid = sizes_.end() - 1;
      }
      cells_[static_cast<std::size_t>(grid - sizes_.begin())][key(cell_of(balls[b].centre, size))].push_back(b);
    }
  }
  // Calls visit(ball) for balls that may hold the point, until it returns true.
  template <class Visit>
  bool any_near(const Vec3& x, const Visit& visit) const {
    for (std::size_t g = 0; g < sizes_.size(); ++g) {
      const Cell middle = cell_of(x, sizes_[g]);
      for (int k = 0; k < 27; ++k) {
        const auto found =
            cells_[g].find(key({middle[0] + k % 3 - 1, middle[1] + k / 3 % 3 - 1, middle[2] + k / 9 - 1}));
        if (found == cells_[g].end()) continue;
        for (const std::uint32_t b : found->second)
          if (visit(b)) return true;
      }
    }
    return false;
  }
  // Whether another ball holds a point on the surface of `own`. Of equal balls only the first one shows.
  bool covered(const Vec3& x, std::uint32_t own) const {
    return any_near(x, [&](std::uint32_t b) {
      const Ball &ball = balls_[b], &of = balls_[own];
      if (ball.centre == of.centre && ball.radius == of.radius) return b < own;
      return holds(ball, x);
    });
  }
  // How many balls hold a point inside of `own`, itself included.
  int holders(const Vec3& x, std::uint32_t own) const {
    int count = 1;
    any_near(x, [&](std::uint32_t b) {
      count += b != own && holds(balls_[b], x) ? 1 : 0;
      return false;
    });
    return count;
  }

 private:
  using Cell = std::array<std::int64_t, 3>;

  // A grid for every power of two.
  static int size_of(double radius) { return std::ilogb(radius) + 1; }
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
  static bool holds(const Ball& ball, const Vec3& x) {
    return (x - ball.centre).squaredNorm() < ball.radius * ball.radius;
  }

  const std::vector<Ball>& balls_;
  std::vector<int> sizes_;
  std::vector<std::unordered_map<std::uint64_t, std::vector<std::uint32_t>>> cells_;
};

}  // namespace

// Of the volume of each ball a point stands for its share, divided among the balls that hold it; of the surface, what
// no other ball holds.
BallUnion union_of_balls(std::span<const Course> courses) {
  const std::vector<Ball> balls = balls_of(courses);
  if (balls.empty()) return {};
  const int count = std::clamp(kPoints / static_cast<int>(balls.size()), kFewestPoints, kMostPoints);
  const std::vector<Vec3> directions = spread_directions(count);
  const BallGrids grids(balls);
  BallUnion result;
  for (std::uint32_t b = 0; b < balls.size(); ++b) {
    const Ball& ball = balls[b];
    const double surface = 4 * std::numbers::pi * ball.radius * ball.radius, volume = surface * ball.radius / 3;
    const Mat3 turn = turn_of(b);
    for (int i = 0; i < count; ++i) {
      const Vec3 n = turn * directions[static_cast<std::size_t>(i)];
      if (!grids.covered(ball.centre + ball.radius * n, b)) result.surface += surface / count;
      // Evenly over the volume, and in another order than the heights of the directions.
      const double depth = std::cbrt(std::fmod((i + 0.5) * std::numbers::phi, 1));
      result.volume += volume / count / grids.holders(ball.centre + depth * ball.radius * n, b);
    }
  }
  return result;
}

}  // namespace quench::tree
