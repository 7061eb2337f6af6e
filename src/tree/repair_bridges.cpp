// SPDX-License-Identifier: Apache-2.0
#include "tree/repair_bridges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "base/csr.h"
#include "base/parallel.h"
#include "tree/grey_path.h"

namespace quench::tree {
namespace {

constexpr double kReachRadii = 8, kReachVoxels = 20;  // the longest bridge, in radii of the end and in about voxels
constexpr double kReachOfLength = 0.3;                // added for the length of the component, as much again at most
constexpr double kTurn = 3;                           // what a turn adds, times 1 - its cosine
constexpr double kUnknownTurn = 1;                    // of isolated nodes
constexpr std::size_t kMostTargets = 8;               // components that one end is bridged to
constexpr std::size_t kMostWays = 4;                  // of those, with ways through grey values
constexpr double kSideways = 1;                   // what it costs to end on the side of a branch, as part of the gap
constexpr double kByTip = 3;                      // and by the thinner end, times the change of ln radius
constexpr double kDarkest = 1, kBrightest = 0.3;  // what a gap costs for its length, by its grey values

/// A place a bridge may end at.
struct Place {
  Vec3 point;
  double radius;
  std::uint32_t piece;  // kNone: an isolated node
  std::uint32_t joint;  // of an isolated node
  double at;
};

/// Places in cells of a grid, to find those near a point.
class PlaceGrid {
 public:
  explicit PlaceGrid(const std::vector<Place>& places) : places_(places) {
    Vec3 high = Vec3::Zero();
    if (!places.empty()) low_ = high = places[0].point;
    for (const Place& place : places) {
      low_ = low_.cwiseMin(place.point);
      high = high.cwiseMax(place.point);
    }
    const double longest = std::max((high - low_).maxCoeff(), std::numeric_limits<double>::min());
    // About one place per cell along curves, and no more than some cells per place.
    const double most = std::clamp(std::cbrt(4.0 * static_cast<double>(places.size())), 1.0, 512.0);
    cell_ = longest / most * (1 + 1e-9);
    for (int i = 0; i < 3; ++i) size_[static_cast<std::size_t>(i)] = coordinate(high[i], i) + 1;
    cells_ = base::Csr<std::uint32_t>::group(static_cast<std::size_t>(size_[0] * size_[1] * size_[2]),
                                             [&](const auto& emit) {
                                               for (std::uint32_t p = 0; p < places_.size(); ++p)
                                                 emit(cell_of(places_[p].point), p);
                                             });
  }

  template <class Visit>
  void near(const Vec3& point, double reach, const Visit& visit) const {
    std::array<std::int64_t, 3> first, last;
    for (int i = 0; i < 3; ++i) {
      const auto axis = static_cast<std::size_t>(i);
      first[axis] = std::max<std::int64_t>(coordinate(point[i] - reach, i), 0);
      last[axis] = std::min(coordinate(point[i] + reach, i), size_[axis] - 1);
    }
    for (std::int64_t z = first[2]; z <= last[2]; ++z)
      for (std::int64_t y = first[1]; y <= last[1]; ++y)
        for (std::int64_t x = first[0]; x <= last[0]; ++x)
          for (const std::uint32_t p : cells_[static_cast<std::size_t>(x + size_[0] * (y + size_[1] * z))])
            if ((places_[p].point - point).norm() <= reach) visit(p);
  }

 private:
  std::int64_t coordinate(double x, int axis) const {
    return static_cast<std::int64_t>(std::floor((x - low_[axis]) / cell_));
  }
  std::size_t cell_of(const Vec3& p) const {
    return static_cast<std::size_t>(coordinate(p[0], 0) +
                                    size_[0] * (coordinate(p[1], 1) + size_[1] * coordinate(p[2], 2)));
  }
  const std::vector<Place>& places_;
  Vec3 low_ = Vec3::Zero();
  double cell_ = 1;
  std::array<std::int64_t, 3> size_{1, 1, 1};
  base::Csr<std::uint32_t> cells_;
};

/// Where bridges begin.
struct Source {
  BridgeEnd end;
  Vec3 point;
  Vec3 direction = Vec3::Zero();  // outwards; zero where there is none
  double radius;
  double taper = 0;  // by how much it is thinner than the other end of its pass, in ln radius
  std::uint32_t component;
};

class BridgeSearch {
 public:
  BridgeSearch(const Model& model, double reach, const GreyValues* grey, Context* context)
      : model_(model), reach_(reach), context_(context), places_(places_of(model)), grid_(places_) {
    if (grey && grey->volume) paths_.emplace(*grey);
  }

  std::vector<Bridge> run() {
    length_.assign(model_.components, 0);
    for (const Piece& piece : model_.pieces) length_[model_.component[piece.node[0]]] += piece.length;
    find_sources();
    std::vector<std::vector<Bridge>> found(sources_.size());
    const std::size_t chunks = base::chunks_for(sources_.size(), paths_ ? 1 : 64);  // ways take long
    base::in_arena(context_, [&] {
      base::for_chunks(chunks, context_, "bridges", 0, 1, [&](std::size_t chunk) {
        const auto [first, last] = base::part_of(sources_.size(), chunk, chunks);
        for (std::size_t s = first; s < last; ++s) found[s] = from(sources_[s]);
      });
    });
    std::vector<Bridge> bridges;
    for (std::vector<Bridge>& more : found)
      bridges.insert(bridges.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
    return bridges;
  }

 private:
  static std::vector<Place> places_of(const Model& model) {
    std::vector<Place> places;
    for (std::uint32_t p = 0; p < model.pieces.size(); ++p) {
      const Piece& piece = model.pieces[p];
      if (piece.bar) continue;
      const std::vector<double> arc = piece.course.arc();
      for (std::size_t i = 0; i < arc.size(); ++i)
        places.push_back({piece.course.points[i], piece.course.radius[i], p, kNone, arc[i]});
    }
    for (std::uint32_t j = 0; j < model.joints.size(); ++j)
      if (model.joints[j].arms.empty()) {
        const CurveGraph::Node& node = model.nodes[model.joints[j].nodes.front()];
        places.push_back({node.point, node.radius, kNone, j, 0});
      }
    return places;
  }

  std::uint32_t component_of(const Place& place) const {
    const std::uint32_t node =
        place.piece != kNone ? model_.pieces[place.piece].node[0] : model_.joints[place.joint].nodes.front();
    return model_.component[node];
  }

  // Free ends and isolated nodes; of components that have neither, every junction.
  void find_sources() {
    std::vector<char> has(model_.components, 0);
    for (std::uint32_t j = 0; j < model_.joints.size(); ++j) {
      const Joint& joint = model_.joints[j];
      if (joint.arms.size() > 1) continue;
      const CurveGraph::Node& node = model_.nodes[joint.nodes.front()];
      Source source;
      source.point = node.point;
      source.component = model_.component[joint.nodes.front()];
      has[source.component] = 1;
      if (joint.arms.empty()) {
        source.end.vertex = vertex_of_joint(model_, j);
        source.end.joint = j;
        source.radius = node.radius;
      } else {
        const std::uint32_t arm = joint.arms.front();
        source.end.vertex = source.end.arm = arm;
        source.direction = -model_.arms[arm].direction;
        source.radius = model_.arms[arm].radius;
        source.taper = taper_of(arm);
      }
      sources_.push_back(source);
    }
    for (const Joint& joint : model_.joints) {
      const std::uint32_t component = model_.component[joint.nodes.front()];
      if (has[component]) continue;
      const std::uint32_t arm = joint.arms.front();
      Source source;
      source.end = end_on(arm / 2, arm % 2 == 0 ? 0 : model_.piece_of(arm).length);
      source.point = model_.nodes[model_.piece_of(arm).node[arm % 2]].point;
      source.radius = model_.arms[arm].radius;
      source.component = component;
      sources_.push_back(source);
    }
  }

  // Roots grow thinner from base to tip.
  double taper_of(std::uint32_t arm) const {
    const Pass& pass = model_.passes[model_.piece_of(arm).pass];
    const std::size_t end = pass.arms[0] == arm ? 0 : 1;
    const double here = pass.radius[end], there = pass.radius[1 - end];
    return here > 0 && there > here ? std::log(there / here) : 0;
  }

  // A piece that is cut has two sides.
  BridgeEnd end_on(std::uint32_t piece, double at) const {
    BridgeEnd end;
    end.vertex = 2 * piece + (at > model_.pieces[piece].cut_at ? 1 : 0);
    end.piece = piece;
    end.at = at;
    return end;
  }

  // Ends of branches are taken for the free ends they are.
  BridgeEnd end_at(const Place& place) const {
    BridgeEnd end;
    if (place.piece == kNone) {
      end.vertex = vertex_of_joint(model_, place.joint);
      end.joint = place.joint;
      return end;
    }
    const std::uint32_t arm = free_arm_at(place);
    if (arm == kNone) return end_on(place.piece, place.at);
    end.vertex = end.arm = arm;
    return end;
  }
  std::uint32_t free_arm_at(const Place& place) const {
    if (place.piece == kNone) return kNone;
    const Piece& piece = model_.pieces[place.piece];
    for (std::uint32_t arm : {2 * place.piece, 2 * place.piece + 1}) {
      const double away = arm % 2 == 0 ? place.at : piece.length - place.at;
      if (model_.is_free(arm) && away == 0) return arm;
    }
    return kNone;
  }

  // Within the ball of a free end, but for the end itself.
  bool is_beside_end(const Place& place) const {
    if (place.piece == kNone) return false;
    const Piece& piece = model_.pieces[place.piece];
    for (std::uint32_t arm : {2 * place.piece, 2 * place.piece + 1}) {
      const double away = arm % 2 == 0 ? place.at : piece.length - place.at;
      if (model_.is_free(arm) && away > 0 && away < 2 * model_.arms[arm].radius) return true;
    }
    return false;
  }

  /// Without grey values: gap times what turns and changes of radius add.
  double cost(const Source& source, const Place& place, double* gap) const {
    const Vec3 way = place.point - source.point;
    const double distance = way.norm();
    const std::uint32_t arm = free_arm_at(place);
    const bool inside = place.piece != kNone && arm == kNone;
    *gap = std::max(inside ? distance - place.radius : distance, 0.5 * model_.finest);
    double factor = 1;
    // Of directions between neighbouring voxels little is known.
    const double sure = distance / (distance + 2 * model_.finest);
    const auto turn = [&](const Vec3& direction, const Vec3& to) {
      return direction.squaredNorm() > 0 && distance > 0 ? kTurn * sure * (1 - direction.dot(to) / distance)
                                                         : kUnknownTurn;
    };
    factor += turn(source.direction, way);
    factor += inside ? kSideways + kByTip * source.taper
                     : turn(arm != kNone ? Vec3(-model_.arms[arm].direction) : Vec3(Vec3::Zero()), -way);
    const double other = arm != kNone ? model_.arms[arm].radius : place.radius;
    if (source.radius > 0 && other > 0) {
      const double change = std::log(source.radius / other);
      factor += inside ? std::max(change, 0.0) : std::abs(change);
    }
    return *gap * factor;
  }

  double reach_of(const Source& source) const {
    const double near = std::max(kReachRadii * source.radius, kReachVoxels * model_.finest);
    return near + std::min(near, kReachOfLength * length_[source.component]);
  }

  std::vector<Bridge> from(const Source& source) const {
    struct Target {
      double cost;
      std::uint32_t place;
      double gap;
    };
    const double reach = reach_ > 0 ? reach_ : reach_of(source);
    std::map<std::uint32_t, Target> nearest;  // per component
    grid_.near(source.point, reach, [&](std::uint32_t p) {
      const std::uint32_t component = component_of(places_[p]);
      if (component == source.component || is_beside_end(places_[p])) return;
      double gap = 0;
      const double c = cost(source, places_[p], &gap);
      const auto [at, fresh] = nearest.try_emplace(component, Target{c, p, gap});
      if (!fresh && std::pair(c, p) < std::pair(at->second.cost, at->second.place)) at->second = {c, p, gap};
    });
    std::vector<Target> targets;
    for (const auto& [component, target] : nearest) targets.push_back(target);
    std::ranges::sort(targets, [](const Target& a, const Target& b) {
      return std::pair(a.cost, a.place) < std::pair(b.cost, b.place);
    });
    if (targets.size() > kMostTargets) targets.resize(kMostTargets);
    std::vector<Bridge> bridges;
    for (std::size_t i = 0; i < targets.size(); ++i) {
      const Place& place = places_[targets[i].place];
      Bridge bridge;
      bridge.ends[0] = source.end;
      bridge.ends[1] = end_at(place);
      bridge.cost = targets[i].cost;
      bridge.grey = std::numeric_limits<double>::quiet_NaN();
      if (paths_) {
        double darkness = 1;
        if (i < kMostWays) {
          const GreyPaths::Way way = paths_->between(source.point, place.point);
          darkness = way.darkness;
          bridge.grey = way.grey;
        }
        bridge.cost *= kBrightest + (kDarkest - kBrightest) * darkness;
      }
      bridge.course = straight(source.point, source.radius, place.point, std::min(place.radius, source.radius), true);
      bridges.push_back(std::move(bridge));
    }
    return bridges;
  }

  const Model& model_;
  double reach_;
  Context* context_;
  std::vector<Place> places_;
  PlaceGrid grid_;
  std::optional<GreyPaths> paths_;
  std::vector<Source> sources_;
  std::vector<double> length_;  // per component
};

}  // namespace

std::vector<Bridge> bridges_of(const Model& model, double reach, const GreyValues* grey, Context* context) {
  return BridgeSearch(model, reach, grey, context).run();
}

}  // namespace quench::tree
