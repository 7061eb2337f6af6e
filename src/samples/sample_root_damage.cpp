// SPDX-License-Identifier: Apache-2.0
// What is wrong with the `root` sample on purpose: branches that touch, and gaps.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <optional>

#include "quench/error.h"
#include "samples/sample_root.h"

namespace quench::samples {
namespace {

using Kind = RootDamage::Kind;

/// A stretch of a branch.
struct Stretch {
  std::size_t first, last;
};

RootDamage touching_at(const std::vector<RootBranch>& branches, std::size_t branch, std::size_t point,
                       std::size_t other, std::size_t other_point) {
  RootDamage damage;
  damage.kind = Kind::touching;
  damage.branch = static_cast<std::uint32_t>(branch);
  damage.other = static_cast<std::uint32_t>(other);
  damage.from_point = static_cast<std::uint32_t>(point);
  damage.to_point = static_cast<std::uint32_t>(other_point);
  damage.from = branches[branch].points[point];
  damage.to = branches[other].points[other_point];
  return damage;
}

class RootDamager {
 public:
  RootDamager(Sample& sample, Random& random, const std::function<RootBranch(const RootBranch&)>& redrawn)
      : sample_(sample), branches_(sample.branches), random_(random), redrawn_(redrawn) {
    const auto count = static_cast<std::uint32_t>(branches_.size());
    children_.resize(count);
    for (std::uint32_t b = 1; b < count; ++b) children_[static_cast<std::size_t>(branches_[b].parent)].push_back(b);
    fill_space();
  }

  void add_touching() {
    constexpr int kTries = 200000;
    for (int k = 0; k < kTries; ++k)
      if (const auto damage = grazing()) {
        sample_.damage.push_back(*damage);
        fill_space();
        return;
      }
    throw Error(ErrorCode::usage,
                fmt::format("there is no room for more than {} places where branches touch; ask for fewer, or for more "
                            "branches",
                            sample_.damage.size()),
                "touching");
  }

  void add_gap() {
    constexpr int kTries = 200000;
    for (int k = 0; k < kTries; ++k)
      if (const auto damage = interrupted()) {
        sample_.damage.push_back(*damage);
        return;
      }
    throw Error(ErrorCode::usage, "there is no room for so many gaps; ask for fewer, or for more branches", "gaps");
  }

  /// Pairs of branches that came too near without being asked to.
  void list_accidents() {
    const std::vector<RootDamage> on_purpose = sample_.damage;
    constexpr double kVoxel = 0.004;  // at resolution 256: nearer tubes join there
    for (std::size_t b = 1; b < branches_.size(); ++b) {
      struct Nearest {
        double depth;
        std::uint32_t point, other, other_point;
      };
      std::vector<Nearest> found;
      const RootBranch& branch = branches_[b];
      for (std::uint32_t i = 0; i < branch.points.size(); ++i)
        space_->balls().any_near(
            branches_, branch.points[i], branch.radius[i] + kVoxel, [&](std::uint32_t other, std::uint32_t k) {
              if (other >= b || related(b, other) || i < space_->surface(b) || k < space_->surface(other)) return false;
              const double depth = (branches_[other].points[k] - branch.points[i]).norm() - branches_[other].radius[k] -
                                   branch.radius[i];
              for (Nearest& n : found)
                if (n.other == other) {
                  if (depth < n.depth) n = {depth, i, other, k};
                  return false;
                }
              found.push_back({depth, i, other, k});
              return false;
            });
      for (const Nearest& n : found) {
        const bool asked = std::any_of(on_purpose.begin(), on_purpose.end(), [&](const RootDamage& d) {
          return (d.branch == b && d.other == n.other) || (d.branch == n.other && d.other == b);
        });
        if (asked) continue;
        RootDamage damage = touching_at(branches_, b, n.point, n.other, n.other_point);
        damage.on_purpose = false;
        sample_.damage.push_back(damage);
      }
    }
  }

 private:
  bool related(std::size_t a, std::size_t b) const {
    return branches_[a].parent == static_cast<std::int32_t>(b) || branches_[b].parent == static_cast<std::int32_t>(a);
  }
  void fill_space() {
    space_.emplace(branches_);
    for (const RootBranch& branch : branches_) space_->add(branch);
  }

  /// Points of a branch within a length of one of them; nothing where it is not as long.
  std::optional<Stretch> around(const RootBranch& branch, std::size_t point, double length) const {
    Stretch stretch{point, point};
    double before = 0, behind = 0;
    while (before < length) {
      if (stretch.first == 0) return {};
      before += length_between(branch.points, stretch.first - 1, stretch.first);
      --stretch.first;
    }
    while (behind < length) {
      if (stretch.last + 1 == branch.points.size()) return {};
      behind += length_between(branch.points, stretch.last, stretch.last + 1);
      ++stretch.last;
    }
    return stretch;
  }

  /// Whether a stretch is out of the parent, some radii from the tip, and without children.
  bool undisturbed(std::size_t b, const RootBranch& branch, const Stretch& stretch) const {
    constexpr double kRadiiToTip = 5;
    if (length_between(branch.points, stretch.last, branch.points.size() - 1) <
        kRadiiToTip * branch.radius[stretch.last])
      return false;
    if (branch.parent >= 0 && stretch.first < emerged_at(space_->parent_of(branch), branch)) return false;
    return std::none_of(children_[b].begin(), children_[b].end(), [&](std::uint32_t child) {
      const auto at = static_cast<std::size_t>(branches_[child].parent_point);
      return at >= stretch.first && at <= stretch.last;
    });
  }

  /// Whether it is farther from all damage than ten radii of it.
  bool far_from_damage(const RootBranch& branch, const Stretch& stretch) const {
    return std::none_of(sample_.damage.begin(), sample_.damage.end(), [&](const RootDamage& d) {
      for (std::size_t i = stretch.first; i <= stretch.last; ++i)
        for (const Vec3& place : {d.from, d.to})
          if ((branch.points[i] - place).norm() < 10 * branch.radius[i]) return true;
      return false;
    });
  }

  /// A random lateral without children, drawn anew and turned about its base towards another branch; nothing where that
  /// does not work.
  std::optional<RootDamage> grazing() {
    if (branches_.size() < 3) return {};
    const std::size_t b = 1 + random_.below(branches_.size() - 1);
    const bool touches = std::any_of(sample_.damage.begin(), sample_.damage.end(),
                                     [&](const RootDamage& d) { return d.branch == b || d.other == b; });
    if (touches || !children_[b].empty()) return {};
    RootBranch moved = redrawn_(branches_[b]);
    const std::size_t i = 1 + random_.below(moved.points.size() - 1);
    const double overlap = random_.between(0.05, 0.25);
    const Vec3 base = moved.points[0], arm = moved.points[i] - base;
    constexpr double kFarthest = 0.1;
    const auto near = a_stranger(b, moved.points[i], kFarthest);
    if (!near) return {};
    const RootBranch& other = branches_[near->branch];
    const Vec3 towards = other.points[near->point] - moved.points[i];
    const double way = towards.norm() - (1 - overlap) * (moved.radius[i] + other.radius[near->point]);
    const auto turn = Eigen::Quaterniond::FromTwoVectors(arm, arm + way * towards.normalized());
    for (Vec3& p : moved.points) p = base + turn * (p - base);
    const auto damage = touching(moved, b, near->branch);
    if (damage) branches_[b] = std::move(moved);
    return damage;
  }

  struct Near {
    std::size_t branch, point;
  };
  /// A random point near to a place, of a branch that is not parent or child of b.
  std::optional<Near> a_stranger(std::size_t b, const Vec3& place, double reach) {
    std::vector<Near> found;
    space_->balls().any_near(branches_, place, reach, [&](std::uint32_t other, std::uint32_t k) {
      if (other != b && !related(other, b)) found.push_back({other, k});
      return false;
    });
    if (found.empty()) return {};
    return found[random_.below(found.size())];
  }

  /// Where `moved`, to be branch b, touches another over a short stretch; nothing where it does not, touches it more
  /// than once, or comes near to a third.
  std::optional<RootDamage> touching(const RootBranch& moved, std::size_t b, std::size_t other) const {
    const RootSpace::Course course = space_->course(moved);
    std::optional<Stretch> near;
    for (std::size_t k = 0; k < moved.points.size(); ++k) {
      bool meets = false;
      const bool blocked = space_->collides(course, k, [&](std::uint32_t o) {
        meets |= o == other;
        return o != other && o != b;
      });
      if (blocked || (meets && near && near->last + 1 != k)) return {};
      if (meets) near = Stretch{near ? near->first : k, k};
    }
    constexpr double kLongest = 24;  // radii, of the stretch within the clearance
    if (!near || length_between(moved.points, near->first, near->last) > kLongest * moved.radius[near->first])
      return {};
    double depth = 0;  // of the overlap, share of the sum of the radii
    std::size_t point = 0, other_point = 0;
    for (std::size_t k = near->first; k <= near->last; ++k)
      for (std::size_t i = 0; i < branches_[other].points.size(); ++i) {
        const double sum = moved.radius[k] + branches_[other].radius[i];
        const double overlap = 1 - (moved.points[k] - branches_[other].points[i]).norm() / sum;
        if (overlap <= depth) continue;
        depth = overlap;
        point = k;
        other_point = i;
      }
    if (depth < 0.05 || depth > 0.3) return {};
    constexpr double kFromForks = 0.015;
    const auto passed = around(branches_[other], other_point, branches_[other].radius[other_point] + kFromForks);
    if (!passed || !undisturbed(b, moved, *near) || !undisturbed(other, branches_[other], *passed)) return {};
    if (!far_from_damage(moved, *near) || !far_from_damage(branches_[other], *passed)) return {};
    RootDamage damage = touching_at(branches_, b, point, other, other_point);
    damage.from = moved.points[point];
    return damage;
  }

  /// A gap of some radii on a random branch; nothing where there is no room.
  std::optional<RootDamage> interrupted() {
    const std::size_t b = random_.below(branches_.size());
    const RootBranch& branch = branches_[b];
    const std::size_t i = random_.below(branch.points.size());
    // The balls at the ends of what is left reach a radius into it.
    const double half = 0.5 * random_.between(4, 7) * branch.radius[i];
    const double contrast = random_.unit() < 0.5 ? 0 : random_.between(0.1, 0.3);
    const auto gap = around(branch, i, half);
    const auto shoulders = around(branch, i, half + 2 * branch.radius[i]);
    if (!gap || !shoulders || !undisturbed(b, branch, *shoulders) || !far_from_damage(branch, *shoulders)) return {};
    RootDamage damage;
    damage.branch = damage.other = static_cast<std::uint32_t>(b);
    damage.from_point = static_cast<std::uint32_t>(gap->first);
    damage.to_point = static_cast<std::uint32_t>(gap->last);
    damage.from = branch.points[gap->first];
    damage.to = branch.points[gap->last];
    damage.contrast = contrast;
    return damage;
  }

  Sample& sample_;
  std::vector<RootBranch>& branches_;
  Random& random_;
  const std::function<RootBranch(const RootBranch&)>& redrawn_;
  std::optional<RootSpace> space_;
  std::vector<std::vector<std::uint32_t>> children_;
};

}  // namespace

void damage_root(Sample& sample, const SampleOptions& options, Random& random,
                 const std::function<RootBranch(const RootBranch&)>& redrawn) {
  RootDamager damager(sample, random, redrawn);
  for (int k = 0; k < options.touching; ++k) damager.add_touching();
  for (int k = 0; k < options.gaps; ++k) damager.add_gap();
  damager.list_accidents();
}

}  // namespace quench::samples
