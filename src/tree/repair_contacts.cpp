// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "tree/repair_model.h"

namespace quench::tree {
namespace {

constexpr double kCertain = 100;                // gain of what is never cut
constexpr double kMiss = 2;                     // weight of a miss of a radius
constexpr double kFromBody = 1.5;               // weight of coming out of a body
constexpr double kNeckEnd = 1.5;                // gain of the ends of a neck: rather the neck itself is cut
constexpr double kBase = 0.9;                   // gain of what is for certain the base of a branch
constexpr double kCrossing = 1.5, kBody = 2.5;  // radius of a tie over that of what it ties
constexpr std::size_t kMostPairs = 16;          // arms of a joint that are looked at in pairs

// By how much the line of an arm misses the axis of what goes on at its joint, in radii: a branch begins on the axis of
// its parent, a tip that touches need not end there.
double miss_of(const Model& model, std::uint32_t arm) {
  const Arm& own = model.arms[arm];
  const Joint& joint = model.joints[own.joint];
  double radius = 0, miss = 0;
  for (const std::uint32_t a : joint.arms) {
    const Arm& other = model.arms[a];
    if (a == arm || other.continued == kNone || other.continued == arm || other.radius <= radius) continue;
    radius = other.radius;
    const Vec3 along = other.place - model.arms[other.continued].place, across = own.direction.cross(along);
    const double norm = across.norm();
    miss = norm > 0 ? std::abs(across.dot(own.place - other.place)) / norm : (own.place - other.place).norm();
  }
  return radius > 0 ? miss / radius : 0;
}

const Vec3& point_of(const Model& model, std::uint32_t arm) {
  return model.nodes[model.piece_of(arm).node[arm % 2]].point;
}

// The radius of the joint where an arm begins: of an arm that comes out of a body it is that of the body.
double radius_at(const Model& model, std::uint32_t arm) {
  return model.nodes[model.piece_of(arm).node[arm % 2]].radius;
}

// From 0, where a tie is no thicker than a crossing of tubes of this radius, to 1, where it is a body they come out of.
double thickness_of_tie(const Model& model, double tie, double radius) {
  const double ratio = (tie + model.finest) / (radius + model.finest);
  return std::clamp((ratio - kCrossing) / (kBody - kCrossing), 0.0, 1.0);
}

// How likely an end of a pass is where it comes from another pass, from 0 to 1: roots grow thinner from base to tip, so
// that of two ends that both meet others the thinner one is a tip that touches.
double likeness_to_base(const Model& model, std::uint32_t arm, std::uint32_t on) {
  const Pass &pass = model.passes[model.piece_of(arm).pass], &other = model.passes[model.piece_of(on).pass];
  const std::size_t end = pass.arms[0] == arm ? 0 : 1;
  double likeness = kBase;
  if (!model.is_free(pass.arms[1 - end])) {
    const double here = pass.radius[end], there = pass.radius[1 - end];
    const double ratio = here > 0 && there > 0 ? std::log(here / there) : 0;
    const double miss_here = std::min(1.0, miss_of(model, arm)),
                 miss_there = std::min(1.0, miss_of(model, pass.arms[1 - end]));
    const double body = thickness_of_tie(model, radius_at(model, arm), here) -
                        thickness_of_tie(model, radius_at(model, pass.arms[1 - end]), there);
    const double odds = ratio / 0.15 + kMiss * (miss_there * miss_there - miss_here * miss_here) + kFromBody * body;
    likeness = 0.1 + 0.7 / (1 + std::exp(-odds));
  }
  // The thick end of a body that thin ones come out of is no touching.
  const double under = std::max(other.widest, radius_at(model, arm));
  const double thicker = pass.radius[end] > 0 ? under / pass.radius[end] : 1;
  if (other.widest < pass.radius[end])
    likeness = std::max(likeness, kBase * thickness_of_tie(model, radius_at(model, arm), other.widest));
  return likeness * std::min(1.0, thicker * thicker / 0.64);
}

bool is_end_of_pass(const Model& model, std::uint32_t arm) { return model.arms[arm].continued == kNone; }

double gain_of_continuation(const Model& model, std::uint32_t arm) {
  // A closed curve is cut where it is thin, not at the point that is called its node.
  const bool closed = model.nodes[model.piece_of(arm).node[arm % 2]].kind == CurveGraph::NodeKind::loop;
  return closed ? kCertain : 2 + model.arms[arm].straight;
}

// Two passes that go on: one of them begins here only where it does so nowhere else.
double gain_of_meeting(const Model& model, std::uint32_t a, std::uint32_t b) {
  double gain = 0.02;
  for (const auto& [own, on] : {std::pair{a, b}, std::pair{b, a}}) {
    const Pass &pass = model.passes[model.piece_of(own).pass], &under = model.passes[model.piece_of(on).pass];
    if (pass.arms[0] == kNone || !model.is_free(pass.arms[0]) || !model.is_free(pass.arms[1])) continue;
    if (under.widest <= pass.widest) continue;
    const double here = std::max(model.arms[own].radius, model.arms[model.arms[own].continued].radius);
    gain = std::max(gain, 0.4 * std::min(1.0, here * here / (pass.widest * pass.widest)));
  }
  gain += 0.3 * (1 - std::min(model.arms[a].straight, model.arms[b].straight));
  // Two that come out of opposite sides of a body look like one that passes it.
  const auto radius = [&](std::uint32_t arm) {
    return std::max(model.arms[arm].radius, model.arms[model.arms[arm].continued].radius);
  };
  const double tie = std::min(radius_at(model, a), radius_at(model, b));
  return std::max(gain, kBase * thickness_of_tie(model, tie, std::min(radius(a), radius(b))));
}

double gain_of_end(const Model& model, std::uint32_t arm, std::uint32_t on) {
  return model.piece_of(arm).neck > 0 ? kNeckEnd : likeness_to_base(model, arm, on);
}

class JointContacts {
 public:
  JointContacts(const Model& model, std::uint32_t joint, std::vector<Contact>& contacts)
      : model_(model), joint_(joint), contacts_(contacts) {}

  void run() {
    for (const std::uint32_t arm : model_.joints[joint_].arms)
      (is_end_of_pass(model_, arm) ? ends_ : through_).push_back(arm);
    for (const std::uint32_t arm : through_) {
      const std::uint32_t next = model_.arms[arm].continued;
      if (arm < next) add(arm, next, gain_of_continuation(model_, arm));
    }
    add_meetings();
    if (!through_.empty())
      for (const std::uint32_t arm : ends_) add_end(arm);
    else
      add_ends();
  }

 private:
  void add(std::uint32_t a, std::uint32_t b, double gain) {
    contacts_.push_back({joint_, {std::min(a, b), std::max(a, b), gain}});
  }

  // Each two passes once.
  void add_meetings() {
    for (std::size_t i = 0; i < through_.size(); ++i)
      for (std::size_t k = 0; k < i; ++k) {
        const std::uint32_t a = through_[k], b = through_[i];
        if (a < model_.arms[a].continued && b < model_.arms[b].continued) add(a, b, gain_of_meeting(model_, a, b));
      }
  }

  // An end belongs to the nearest pass, the thicker of two.
  void add_end(std::uint32_t arm) {
    std::uint32_t best = kNone;
    double nearest = std::numeric_limits<double>::infinity();
    for (const std::uint32_t other : through_) {
      const double distance = (point_of(model_, other) - point_of(model_, arm)).norm();
      if (distance > nearest || (distance == nearest && model_.arms[other].radius <= model_.arms[best].radius))
        continue;
      nearest = distance;
      best = other;
    }
    add(arm, best, gain_of_end(model_, arm, best));
  }

  // Nothing goes on: each two of a few, each of many with the thickest.
  void add_ends() {
    const auto both = [&](std::uint32_t a, std::uint32_t b) {
      add(a, b, std::min(gain_of_end(model_, a, b), gain_of_end(model_, b, a)));
    };
    if (ends_.size() <= kMostPairs) {
      for (std::size_t i = 0; i < ends_.size(); ++i)
        for (std::size_t k = 0; k < i; ++k) both(ends_[k], ends_[i]);
      return;
    }
    const std::uint32_t thickest = *std::ranges::max_element(
        ends_, [&](std::uint32_t a, std::uint32_t b) { return model_.arms[a].radius < model_.arms[b].radius; });
    for (const std::uint32_t arm : ends_)
      if (arm != thickest) both(arm, thickest);
  }

  const Model& model_;
  std::uint32_t joint_;
  std::vector<Contact>& contacts_;
  std::vector<std::uint32_t> through_, ends_;
};

}  // namespace

std::vector<Contact> contacts_of(const Model& model) {
  std::vector<Contact> contacts;
  for (std::uint32_t j = 0; j < model.joints.size(); ++j) JointContacts(model, j, contacts).run();
  return contacts;
}

}  // namespace quench::tree
