// SPDX-License-Identifier: Apache-2.0
// A root system with known branches: one main root, laterals of first order on it, laterals of second order on those.
// Its length is 1; down is -z.
#include <Eigen/Geometry>
#include <algorithm>

#include "samples/sample_shapes.h"

namespace quench::samples {
namespace {

/// How branches of one order grow.
struct Habit {
  double step;                ///< distance of neighbouring points
  double wander;              ///< standard turn per step
  double gravity;             ///< turn towards -z per step
  double tip;                 ///< radius at the tip as a fraction of that at the base
  double steepest, flattest;  ///< range of the angle to the parent at the base
};
constexpr Habit habits[3]{
    {0.010, 0.030, 0.040, 0.30, 0, 0}, {0.008, 0.045, 0.012, 0.45, 0.9, 1.45}, {0.006, 0.055, 0.004, 0.60, 0.7, 1.4}};

constexpr double kMainRadius = 0.034;
constexpr double kThinnest = 0.005;  // radius; about 1.3 voxels at resolution 256, where no branch is lost

Vec3 any_normal(const Vec3& d) {
  const Vec3 axis = std::abs(d[2]) < 0.8 ? Vec3::UnitZ() : Vec3::UnitX();
  return d.cross(axis).normalized();
}

// A smooth random path: its turns are correlated noise, so that it has no kinks, plus gravitropism.
void grow(RootBranch& branch, Vec3 point, Vec3 direction, double length, double base, const Habit& habit,
          Random& random) {
  const int steps = std::max(3, static_cast<int>(std::lround(length / habit.step)));
  const double step = length / steps;
  Vec3 turn = Vec3::Zero();
  for (int i = 0; i <= steps; ++i) {
    const double t = static_cast<double>(i) / steps;
    branch.points.push_back(point);
    branch.radius.push_back(std::max(base * (1 + t * (habit.tip - 1)), std::min(base, kThinnest)));
    Vec3 noise(random.between(-1, 1), random.between(-1, 1), random.between(-1, 1));
    turn = 0.85 * turn + 0.5 * habit.wander * noise;
    direction = (direction + turn - habit.gravity * Vec3::UnitZ()).normalized();
    point += step * direction;
  }
}

// Closed tube about the branch with hemispheres at both ends; frames by parallel transport, so that it does not twist.
void append_branch(TriangleMesh& mesh, const RootBranch& branch, double fineness) {
  // Deviation of a regular polygon from its circle below 1/20 voxel at resolution 512.
  const double widest = *std::max_element(branch.radius.begin(), branch.radius.end());
  const int around = scaled(std::ceil(kPi / std::sqrt(2e-4 / widest)), fineness, 6);
  const int cap = scaled(around / 4.0, 1, 2);
  const std::size_t count = branch.points.size();
  const auto tangent = [&](std::size_t i) {
    return Vec3((branch.points[std::min(i + 1, count - 1)] - branch.points[i == 0 ? 0 : i - 1]).normalized());
  };
  std::vector<Ring> rings;
  Vec3 along = tangent(0);
  Vec3 normal = any_normal(along);
  for (int k = 0; k < cap; ++k) {
    const double angle = 0.5 * kPi * k / cap;
    rings.push_back({branch.points[0] - branch.radius[0] * std::cos(angle) * along, normal, along.cross(normal),
                     branch.radius[0] * std::sin(angle)});
  }
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 next = tangent(i);
    normal = Eigen::Quaterniond::FromTwoVectors(along, next) * normal;
    normal = (normal - normal.dot(next) * next).normalized();
    along = next;
    rings.push_back({branch.points[i], normal, along.cross(normal), branch.radius[i]});
  }
  for (int k = cap; k-- > 0;) {
    const double angle = 0.5 * kPi * k / cap;
    rings.push_back({branch.points.back() + branch.radius.back() * std::cos(angle) * along, normal, along.cross(normal),
                     k == 0 ? 0 : branch.radius.back() * std::sin(angle)});
  }
  append_tube(mesh, rings, around);
}

// A lateral of `parent` at a random point between its base and its tip.
RootBranch lateral(const std::vector<RootBranch>& branches, std::size_t parent, int order, Random& random) {
  const RootBranch& trunk = branches[parent];
  const std::size_t last = trunk.points.size() - 1;
  const auto at = std::clamp<std::size_t>(
      static_cast<std::size_t>(std::lround(random.between(0.06, 0.92) * static_cast<double>(last))), 1, last);
  RootBranch branch;
  branch.parent = static_cast<std::int32_t>(parent);
  branch.parent_point = static_cast<std::int32_t>(at);
  const Habit& habit = habits[order];
  const Vec3 along = (trunk.points[at] - trunk.points[at - 1]).normalized();
  const Vec3 n = any_normal(along), b = along.cross(n);
  const double around = random.between(0, 2 * kPi), away = random.between(habit.steepest, habit.flattest);
  const Vec3 direction = std::cos(away) * along + std::sin(away) * (std::cos(around) * n + std::sin(around) * b);
  // Laterals nearer to the base are older and longer.
  const double age = 1 - static_cast<double>(at) / static_cast<double>(last);
  const double longest = order == 1 ? 0.55 : 0.22;
  const double length = longest * (0.25 + 0.75 * age) * random.between(0.6, 1);
  const double base = std::max(std::min(kThinnest, trunk.radius[at] * 0.9),
                               trunk.radius[at] * (order == 1 ? random.between(0.35, 0.5) : random.between(0.5, 0.65)));
  grow(branch, trunk.points[at], direction, length, base, habit, random);
  return branch;
}

}  // namespace

Sample root(const SampleOptions& options) {
  Random random(options.seed);
  Sample sample;
  std::vector<RootBranch>& branches = sample.branches;
  const auto count = static_cast<std::size_t>(options.branches);
  branches.reserve(count);
  RootBranch& main = branches.emplace_back();
  grow(main, Vec3::Zero(), Vec3(random.between(-0.1, 0.1), random.between(-0.1, 0.1), -1).normalized(), 1, kMainRadius,
       habits[0], random);
  // About one lateral in three is of first order, but never so many that the main root is covered by them.
  const std::size_t laterals = count - 1;
  const std::size_t first_order = std::min<std::size_t>((laterals + 2) / 3, 60);
  for (std::size_t i = 0; i < laterals; ++i) {
    const bool on_main = i < first_order;
    const std::size_t parent = on_main ? 0 : 1 + random.below(first_order);
    branches.push_back(lateral(branches, parent, on_main ? 1 : 2, random));
  }
  for (const RootBranch& branch : branches) append_branch(sample.mesh, branch, options.fineness);
  return sample;
}

}  // namespace quench::samples
