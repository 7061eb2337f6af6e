// SPDX-License-Identifier: Apache-2.0
// A root system with known branches: one main root, laterals of first order on it, laterals of second order on those.
// Its length is 1; down is -z. Branches keep clear of each other as long as there is room.
#include "samples/sample_root.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <optional>

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

double thinned_to(double base, double tip, double t, double thinnest) {
  return std::max(base * (1 + t * (tip - 1)), std::min(base, thinnest));
}

// A smooth random path: its turns are correlated noise, so that it has no kinks, plus gravitropism.
void grow(RootBranch& branch, Vec3 point, Vec3 direction, double length, double base, double thinnest,
          const Habit& habit, Random& random) {
  const int steps = std::max(3, static_cast<int>(std::lround(length / habit.step)));
  const double step = length / steps;
  Vec3 turn = Vec3::Zero();
  for (int i = 0; i <= steps; ++i) {
    const double t = static_cast<double>(i) / steps;
    branch.points.push_back(point);
    branch.radius.push_back(thinned_to(base, habit.tip, t, thinnest));
    Vec3 noise(random.between(-1, 1), random.between(-1, 1), random.between(-1, 1));
    turn = 0.85 * turn + 0.5 * habit.wander * noise;
    direction = (direction + turn - habit.gravity * Vec3::UnitZ()).normalized();
    point += step * direction;
  }
}

// Closed tube about the branch with hemispheres at both ends; frames by parallel transport, so that it does not twist.
void append_branch(TriangleMesh& mesh, const RootBranch& branch, const SampleOptions& options) {
  // Deviation of a regular polygon from its circle below 1/20 voxel at resolution 512, of thinner roots less.
  const double widest = *std::max_element(branch.radius.begin(), branch.radius.end()) / options.thickness;
  const int around = scaled(std::ceil(kPi / std::sqrt(2e-4 / widest)), options.fineness, 6);
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

/// Lets laterals grow one after the other, each clear of those before it.
class Grower {
 public:
  Grower(std::vector<RootBranch>& branches, double thickness, Random& random)
      : branches_(branches), thickness_(thickness), random_(random), space_(branches) {}

  /// A lateral of a parent that `pick` chooses, anew for every few draws.
  template <class Pick>
  void add(int order, const Pick& pick) {
    constexpr int kDraws = 60, kDrawsPerParent = 6;
    std::optional<RootBranch> best;
    double best_share = 0;
    std::size_t parent = 0;
    RootBranch branch;
    for (int draw = 0; draw < kDraws; ++draw) {
      if (draw % kDrawsPerParent == 0) parent = pick();
      branch = draw_lateral(parent, draw_emergence(parent), order);
      if (draws_left_ == 0) break;
      --draws_left_;
      const std::size_t clear = clear_points(branch);
      const double share = static_cast<double>(clear) / static_cast<double>(branch.points.size());
      if (share > best_share) {
        best_share = share;
        best = branch;
        shorten(*best, clear, habits[order].tip);
      }
      if (best_share == 1) break;
    }
    if (best) branch = std::move(*best);
    children_[static_cast<std::size_t>(branch.parent)].push_back(branches_.size());
    take(std::move(branch));
  }

  void add_main(double length) {
    RootBranch main;
    grow(main, Vec3::Zero(), Vec3(random_.between(-0.1, 0.1), random_.between(-0.1, 0.1), -1).normalized(), length,
         kMainRadius * thickness_, thinnest_, habits[0], random_);
    take(std::move(main));
  }

  /// Without a look at the others.
  RootBranch draw_lateral(std::size_t parent, std::size_t at, int order) {
    const RootBranch& trunk = branches_[parent];
    const std::size_t last = trunk.points.size() - 1;
    RootBranch branch;
    branch.parent = static_cast<std::int32_t>(parent);
    branch.parent_point = static_cast<std::int32_t>(at);
    const Habit& habit = habits[order];
    const Vec3 along = (trunk.points[at] - trunk.points[at - 1]).normalized();
    const Vec3 n = any_normal(along), b = along.cross(n);
    const double around = random_.between(0, 2 * kPi), away = random_.between(habit.steepest, habit.flattest);
    const Vec3 direction = std::cos(away) * along + std::sin(away) * (std::cos(around) * n + std::sin(around) * b);
    // Laterals nearer to the base are older and longer, and none is longer than what its parent grew after it.
    const double share = static_cast<double>(at) / static_cast<double>(last);
    const double longest = order == 1 ? 0.55 : 0.22;
    const double length = std::min(longest * (0.25 + 0.75 * (1 - share)) * random_.between(0.6, 1),
                                   trunk.length() * (1 - share) * random_.between(0.6, 0.85));
    const double base =
        std::max(std::min(thinnest_, trunk.radius[at] * 0.9),
                 trunk.radius[at] * (order == 1 ? random_.between(0.35, 0.5) : random_.between(0.5, 0.65)));
    grow(branch, trunk.points[at], direction, length, base, thinnest_, habit, random_);
    return branch;
  }

 private:
  void take(RootBranch&& branch) {
    space_.add(branch);
    branches_.push_back(std::move(branch));
    children_.emplace_back();
  }

  std::size_t draw_emergence(std::size_t parent) {
    const std::size_t last = branches_[parent].points.size() - 1;
    return std::clamp<std::size_t>(
        static_cast<std::size_t>(std::lround(random_.between(0.06, 0.85) * static_cast<double>(last))), 1, last);
  }

  /// How many points of its beginning keep clear of the others; 0 where it does not stand out of its parent by several
  /// radii, or emerges within a tube's width of another.
  std::size_t clear_points(const RootBranch& branch) const {
    const auto parent = static_cast<std::size_t>(branch.parent);
    for (const std::size_t sibling : children_[parent]) {
      const double apart = (branches_[sibling].points[0] - branch.points[0]).norm();
      if (apart < branches_[sibling].radius[0] + branch.radius[0]) return 0;
    }
    const RootSpace::Course course = space_.course(branch);
    std::size_t clear = 0;
    while (clear < branch.points.size() && !space_.collides(course, clear, [](std::uint32_t) { return true; })) ++clear;
    constexpr double kRadiiOut = 6;
    const double standing_out = clear > course.out ? length_between(branch.points, course.out, clear - 1) : 0;
    return standing_out > std::max(kRadiiOut * branch.radius[0], 2 * kRootClearance) ? clear : 0;
  }

  void shorten(RootBranch& branch, std::size_t count, double tip) const {
    const double base = branch.radius[0];
    branch.points.resize(count);
    branch.radius.resize(count);
    for (std::size_t i = 0; i < count; ++i)
      branch.radius[i] = thinned_to(base, tip, static_cast<double>(i) / static_cast<double>(count - 1), thinnest_);
  }

  std::vector<RootBranch>& branches_;
  double thickness_, thinnest_ = kThinnest * thickness_;
  Random& random_;
  std::vector<std::vector<std::size_t>> children_;  // of each branch
  RootSpace space_;
  std::int64_t draws_left_ = 100000;  // then it is crowded, and branches are taken as they come
};

}  // namespace

double length_between(const std::vector<Vec3>& points, std::size_t from, std::size_t to) {
  double sum = 0;
  for (std::size_t i = from; i < to; ++i) sum += (points[i + 1] - points[i]).norm();
  return sum;
}

std::size_t surfaced_at(const RootBranch& parent, const RootBranch& branch) {
  const auto at = static_cast<std::size_t>(branch.parent_point);
  std::size_t i = 0;
  while (i < branch.points.size() && (branch.points[i] - parent.points[at]).norm() < parent.radius[at]) ++i;
  return i;
}

std::size_t emerged_at(const RootBranch& parent, const RootBranch& branch) {
  for (std::size_t i = 0; i < branch.points.size(); ++i) {
    bool out = true;
    for (std::size_t k = 0; out && k < parent.points.size(); ++k)
      out = (parent.points[k] - branch.points[i]).norm() > parent.radius[k] + branch.radius[i] + kRootClearance;
    if (out) return i;
  }
  return branch.points.size();
}

Sample root(const SampleOptions& options) {
  Random random(options.seed);
  Sample sample;
  std::vector<RootBranch>& branches = sample.branches;
  const auto count = static_cast<std::size_t>(options.branches);
  branches.reserve(count);
  Grower grower(branches, options.thickness, random);
  grower.add_main(1);
  // About one lateral in three is of first order, but never so many that the main root is covered by them.
  const std::size_t laterals = count - 1;
  const std::size_t first_order = std::min<std::size_t>((laterals + 2) / 3, 60);
  for (std::size_t i = 0; i < laterals; ++i) {
    if (i < first_order)
      grower.add(1, [] { return std::size_t{0}; });
    else
      grower.add(2, [&] { return 1 + random.below(first_order); });
  }
  damage_root(sample, options, random, [&](const RootBranch& branch) {
    return grower.draw_lateral(static_cast<std::size_t>(branch.parent), static_cast<std::size_t>(branch.parent_point),
                               branch.parent == 0 ? 1 : 2);
  });
  for (const RootBranch& branch : branches) append_branch(sample.mesh, branch, options);
  return sample;
}

}  // namespace quench::samples
