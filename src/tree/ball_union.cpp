// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <unordered_map>

#include "tree/measured_tree.h"

namespace quench::tree {
namespace {

constexpr int kOnBall = 128;          // points spread over the surface of each ball
constexpr double kBallSpacing = 0.5;  // of balls along a course, in radii

struct Ball {
  Vec3 centre;
  double radius;
};

// Points on the unit sphere, of equal areas: heights in equal steps, turned by the golden angle.
std::vector<Vec3> spread_directions() {
  std::vector<Vec3> directions;
  const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
  for (int i = 0; i < kOnBall; ++i) {
    const double z = 1 - (2.0 * i + 1) / kOnBall, flat = std::sqrt(1 - z * z);
    directions.emplace_back(flat * std::cos(golden * i), flat * std::sin(golden * i), z);
  }
  return directions;
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
  // Whether a ball other than `own` holds the point. Of two equal balls only the first one shows.
  bool covered(const Vec3& x, std::uint32_t own) const {
    for (std::size_t g = 0; g < sizes_.size(); ++g) {
      const Cell middle = cell_of(x, sizes_[g]);
      for (int k = 0; k < 27; ++k) {
        const auto found =
            cells_[g].find(key({middle[0] + k % 3 - 1, middle[1] + k / 3 % 3 - 1, middle[2] + k / 9 - 1}));
        if (found == cells_[g].end()) continue;
        for (const std::uint32_t b : found->second)
          if (b != own && holds(b, x, own)) return true;
      }
    }
    return false;
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
  bool holds(std::uint32_t b, const Vec3& x, std::uint32_t own) const {
    const Ball &ball = balls_[b], &of = balls_[own];
    if (ball.centre == of.centre && ball.radius == of.radius) return b < own;
    return (x - ball.centre).squaredNorm() < ball.radius * ball.radius;
  }

  const std::vector<Ball>& balls_;
  std::vector<int> sizes_;
  std::vector<std::unordered_map<std::uint64_t, std::vector<std::uint32_t>>> cells_;
};

}  // namespace

// The volume is the flow of x / 3 through the surface (divergence theorem); from the centre of all, for the digits.
BallUnion union_of_balls(std::span<const Course> courses) {
  const std::vector<Ball> balls = balls_of(courses);
  BallUnion result;
  if (balls.empty()) return result;
  static const std::vector<Vec3> directions = spread_directions();
  Vec3 middle = Vec3::Zero();
  for (const Ball& ball : balls) middle += ball.centre / static_cast<double>(balls.size());
  const BallGrids grids(balls);
  for (std::uint32_t b = 0; b < balls.size(); ++b) {
    const Ball& ball = balls[b];
    const double share = 4 * std::numbers::pi * ball.radius * ball.radius / kOnBall;
    for (const Vec3& n : directions) {
      const Vec3 x = ball.centre + ball.radius * n;
      if (grids.covered(x, b)) continue;
      result.surface += share;
      result.volume += share * (x - middle).dot(n) / 3;
    }
  }
  return result;
}

}  // namespace quench::tree
