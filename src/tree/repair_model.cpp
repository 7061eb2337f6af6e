// SPDX-License-Identifier: Apache-2.0
#include "tree/repair_model.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/union_find.h"

namespace quench::tree {
namespace {

constexpr std::size_t kMostArmsOfJoint = 8;  // of joints of several nodes
constexpr double kArmWindow = 5;             // radii over which directions are averaged
// Turn of a continuation, radians, and change of the logarithm of its radius, at one standard deviation: for the arms
// that are most alike, and for those that pass through others.
constexpr double kSharpTurn = 0.5, kTurnThrough = 0.3, kRadiusChange = 0.5, kRadiusChangeThrough = 0.25;
constexpr double kMostUnsure = 0.25;  // variance of directions of short arms, square radians
constexpr double kLeastContinuation = 0.02, kLeastThrough = 0.2;  // below that, two arms do not continue each other
constexpr double kNeck = 0.7;                                     // radius at a neck, of what it connects

double angle_between(const Vec3& a, const Vec3& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

class ModelBuilder {
 public:
  ModelBuilder(const CurveGraph& graph, double voxel) : graph_(graph) { model_.finest = voxel; }

  Model build() {
    model_.nodes = graph_.nodes;
    for (const CurveGraph::Branch& branch : graph_.branches) add_piece(polyline_of(branch), branch.from, branch.to);
    add_links();
    if (!(model_.finest > 0)) find_finest();
    find_components();
    find_necks();
    find_joints();
    measure_arms();
    for (Joint& joint : model_.joints) continue_arms(joint);
    find_passes();
    for (Piece& piece : model_.pieces) weigh(piece);
    return std::move(model_);
  }

 private:
  void add_piece(Polyline course, std::uint32_t from, std::uint32_t to) {
    Piece piece;
    piece.length = course.length();
    piece.course = std::move(course);
    piece.node = {from, to};
    model_.pieces.push_back(std::move(piece));
  }

  // The nodes on one patch of sheets are joined by straight links of the least length (Prim 1957).
  void add_links() {
    std::vector<std::vector<std::uint32_t>> on(graph_.sheets);
    for (std::uint32_t n = 0; n < graph_.nodes.size(); ++n)
      if (graph_.nodes[n].sheet != kNone) on[graph_.nodes[n].sheet].push_back(n);
    for (std::vector<std::uint32_t>& nodes : on) {
      std::vector<std::pair<double, std::uint32_t>> nearest(nodes.size(), {std::numeric_limits<double>::infinity(), 0});
      for (std::size_t last = 0, left = nodes.size(); left > 1;) {
        const std::uint32_t from = nodes[last];
        std::swap(nodes[last], nodes[--left]);
        std::swap(nearest[last], nearest[left]);
        for (std::size_t i = 0; i < left; ++i)
          nearest[i] =
              std::min(nearest[i], {(graph_.nodes[nodes[i]].point - graph_.nodes[from].point).squaredNorm(), from});
        last = static_cast<std::size_t>(
            std::min_element(nearest.begin(), nearest.begin() + static_cast<std::ptrdiff_t>(left)) - nearest.begin());
        const CurveGraph::Node &a = graph_.nodes[nodes[last]], &b = graph_.nodes[nearest[last].second];
        add_piece(straight(a.point, a.radius, b.point, b.radius, false), nodes[last], nearest[last].second);
        model_.pieces.back().link = model_.pieces.back().bar = true;
      }
    }
  }

  // The median radius of pieces along their length; without pieces, of nodes.
  void find_finest() {
    std::vector<std::pair<double, double>> radii;  // with how much each counts
    double sum = 0;
    for (const Piece& piece : model_.pieces) {
      if (piece.link) continue;
      const std::vector<double> arc = piece.course.arc();
      for (std::size_t i = 1; i < arc.size(); ++i) {
        radii.push_back({0.5 * (piece.course.radius[i - 1] + piece.course.radius[i]), arc[i] - arc[i - 1]});
        sum += radii.back().second;
      }
    }
    sum *= 0.5;
    if (sum == 0) {
      for (const CurveGraph::Node& node : model_.nodes) radii.push_back({node.radius, 1});
      sum = 0.5 * static_cast<double>(radii.size());
    }
    std::ranges::sort(radii);
    for (const auto& [radius, counts] : radii) {
      model_.finest = radius;
      if ((sum -= counts) <= 0) return;
    }
  }

  void find_components() {
    base::UnionFind sets(model_.nodes.size());
    for (const Piece& piece : model_.pieces) sets.unite(piece.node[0], piece.node[1]);
    model_.component.resize(model_.nodes.size());
    for (std::uint32_t n = 0; n < model_.nodes.size(); ++n)
      model_.component[n] = sets.find(n) == n ? model_.components++ : model_.component[sets.find(n)];
  }

  // A short piece between two junctions, thinner than what it connects: than the second thickest of the other branches
  // that meet there.
  void find_necks() {
    std::vector<std::vector<std::uint32_t>> at(model_.nodes.size());
    for (std::uint32_t p = 0; p < model_.pieces.size(); ++p)
      if (!model_.pieces[p].link)
        for (const std::uint32_t n : model_.pieces[p].node) at[n].push_back(p);
    std::vector<double> median(model_.pieces.size());
    for (std::uint32_t p = 0; p < model_.pieces.size(); ++p) {
      std::vector<double> radius = model_.pieces[p].course.radius;
      const auto middle = radius.begin() + static_cast<std::ptrdiff_t>(radius.size() / 2);
      std::nth_element(radius.begin(), middle, radius.end());
      median[p] = *middle;
    }
    for (std::uint32_t p = 0; p < model_.pieces.size(); ++p) {
      Piece& piece = model_.pieces[p];
      double thinner = std::numeric_limits<double>::infinity(), both = 0;
      for (const std::uint32_t n : piece.node) {
        std::array<double, 2> thickest{0, 0};
        for (const std::uint32_t q : at[n])
          if (q != p && median[q] > thickest[1])
            thickest =
                median[q] > thickest[0] ? std::array{median[q], thickest[0]} : std::array{thickest[0], median[q]};
        thinner = std::min(thinner, thickest[1]);
        both += model_.nodes[n].radius;
      }
      const double least = *std::ranges::min_element(piece.course.radius);
      if (piece.link || piece.node[0] == piece.node[1] || piece.length > 2 * both) continue;
      if (least < kNeck * thinner) piece.neck = least / thinner + 1e-6;
    }
  }

  // Two junctions whose balls nearly meet, and what is between, become one joint, shortest pieces first.
  void find_joints() {
    base::UnionFind sets(model_.nodes.size());
    std::vector<std::uint32_t> arms(model_.nodes.size(), 0);
    std::vector<double> extent(model_.nodes.size(), 0);  // per joint: length of its bars
    for (const Piece& piece : model_.pieces) {
      if (piece.link)
        sets.unite(piece.node[0], piece.node[1]);
      else
        for (const std::uint32_t n : piece.node) ++arms[n];
    }
    for (std::uint32_t n = 0; n < model_.nodes.size(); ++n)
      if (sets.find(n) != n) arms[sets.find(n)] += arms[n];
    std::vector<std::pair<double, std::uint32_t>> bars;
    for (std::uint32_t p = 0; p < model_.pieces.size(); ++p) {
      const Piece& piece = model_.pieces[p];
      const double radii = model_.nodes[piece.node[0]].radius + model_.nodes[piece.node[1]].radius;
      if (!piece.link && !piece.neck && piece.length <= 1.5 * radii) bars.push_back({piece.length / radii, p});
    }
    std::sort(bars.begin(), bars.end());
    for (const auto& [key, p] : bars) {
      Piece& piece = model_.pieces[p];
      const std::uint32_t a = sets.find(piece.node[0]), b = sets.find(piece.node[1]);
      if (a == b || arms[a] < 3 || arms[b] < 3 || arms[a] + arms[b] - 2 > kMostArmsOfJoint) continue;
      const double radius = std::max(model_.nodes[piece.node[0]].radius, model_.nodes[piece.node[1]].radius);
      if (extent[a] + extent[b] + piece.length > 6 * radius) continue;
      piece.bar = true;
      sets.unite(a, b);
      const std::uint32_t both = sets.find(a), other = both == a ? b : a;
      arms[both] += arms[other] - 2;
      extent[both] += extent[other] + piece.length;
    }
    model_.joint_of.resize(model_.nodes.size());
    for (std::uint32_t n = 0; n < model_.nodes.size(); ++n) {
      if (sets.find(n) == n) {
        model_.joint_of[n] = static_cast<std::uint32_t>(model_.joints.size());
        model_.joints.emplace_back();
      }
      model_.joint_of[n] = model_.joint_of[sets.find(n)];
      Joint& joint = model_.joints[model_.joint_of[n]];
      joint.nodes.push_back(n);
      joint.radius = std::max(joint.radius, model_.nodes[n].radius);
    }
    for (std::uint32_t p = 0; p < model_.pieces.size(); ++p) {
      const Piece& piece = model_.pieces[p];
      if (piece.bar) {
        model_.joints[model_.joint_of[piece.node[0]]].bars.push_back(p);
        continue;
      }
      for (std::uint32_t end : {0u, 1u}) model_.joints[model_.joint_of[piece.node[end]]].arms.push_back(2 * p + end);
    }
  }

  void measure_arms() {
    model_.arms.resize(2 * model_.pieces.size());
    for (std::uint32_t p = 0; p < model_.pieces.size(); ++p)
      if (!model_.pieces[p].bar)
        for (std::uint32_t end : {0u, 1u}) measure_arm(model_.pieces[p], end, model_.arms[2 * p + end]);
  }

  void measure_arm(const Piece& piece, std::uint32_t end, Arm& arm) const {
    arm.joint = model_.joint_of[piece.node[end]];
    const bool free = model_.joints[arm.joint].arms.size() == 1;
    const std::vector<double> arc = piece.course.arc();
    const auto at = [&](double s) { return place_on(piece.course, arc, end == 0 ? s : piece.length - s); };
    arm.skip = free ? 0 : std::min(model_.nodes[piece.node[end]].radius, 0.4 * piece.length);
    // The last radius of a free end is the least certain.
    const double first = free ? std::min(model_.nodes[piece.node[end]].radius, 0.4 * piece.length) : arm.skip;
    const double window = kArmWindow * std::max(at(first).radius, model_.finest);
    const double last = std::min(first + window, first + 0.8 * (piece.length - first));
    arm.span = last - first;
    arm.place = at(arm.skip).point;
    const Vec3 way = at(last).point - at(first).point;
    const Vec3 whole = at(piece.length).point - at(0).point;
    arm.direction = way.squaredNorm() > 0 ? way.normalized() : whole.squaredNorm() > 0 ? whole.normalized() : way;
    std::array<double, 9> radii;
    for (std::size_t i = 0; i < radii.size(); ++i)
      radii[i] = at(first + (last - first) * static_cast<double>(i) / (radii.size() - 1)).radius;
    std::nth_element(radii.begin(), radii.begin() + radii.size() / 2, radii.end());
    arm.radius = radii[radii.size() / 2];
  }

  double continuation(std::uint32_t i, std::uint32_t j, double turns, double changes) const {
    const Arm &a = model_.arms[i], &b = model_.arms[j];
    const Vec3 across = b.place - a.place;
    const double turn = angle_between(-a.direction, b.direction);
    double q = turn * turn;
    if (across.squaredNorm() > 0) {
      const double in = angle_between(-a.direction, across), out = angle_between(across, b.direction);
      q += 0.5 * (in * in + out * out);
    }
    // A place is known to about half a voxel, a radius to about a voxel.
    double change = 0, variance = turns * turns;
    if (model_.finest > 0) {
      change = std::log((a.radius + model_.finest) / (b.radius + model_.finest));
      const double unsure = model_.finest * std::hypot(1 / a.span, 1 / b.span);
      variance += std::min(unsure * unsure, kMostUnsure);
    }
    return std::exp(-0.5 * q / variance - 0.5 * change * change / (changes * changes));
  }

  // Best pairs first, those of thick arms before others.
  void continue_arms(const Joint& joint) {
    struct Pair {
      double weight;
      std::uint32_t a, b;
    };
    std::vector<Pair> pairs;
    if (joint.arms.size() > 64) return;  // of a sheet
    for (std::size_t i = 0; i < joint.arms.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) {
        const double how = continuation(joint.arms[j], joint.arms[i], kSharpTurn, kRadiusChange);
        const double thinner = std::min(model_.arms[joint.arms[j]].radius, model_.arms[joint.arms[i]].radius);
        if (how >= kLeastContinuation) pairs.push_back({how * thinner, joint.arms[j], joint.arms[i]});
      }
    std::ranges::stable_sort(pairs, [](const Pair& p, const Pair& q) { return p.weight > q.weight; });
    bool first = true;
    for (const Pair& pair : pairs) {
      Arm &a = model_.arms[pair.a], &b = model_.arms[pair.b];
      if (a.continued != kNone || b.continued != kNone) continue;
      const double through = continuation(pair.a, pair.b, kTurnThrough, kRadiusChangeThrough);
      if (!first && through < kLeastThrough) continue;
      first = false;
      a.continued = pair.b;
      b.continued = pair.a;
      a.straight = b.straight = through;
    }
  }

  void find_passes() {
    for (std::uint32_t arm = 0; arm < model_.arms.size(); ++arm)
      if (!model_.piece_of(arm).bar && model_.piece_of(arm).pass == kNone && model_.arms[arm].continued == kNone)
        follow(arm);
    for (std::uint32_t arm = 0; arm < model_.arms.size(); arm += 2)
      if (!model_.piece_of(arm).bar && model_.piece_of(arm).pass == kNone) follow(arm);
  }

  void follow(std::uint32_t arm) {
    const auto number = static_cast<std::uint32_t>(model_.passes.size());
    Pass pass;
    std::vector<std::uint32_t> row;  // the arms by which its pieces are entered
    for (std::uint32_t at = arm; model_.pieces[at / 2].pass == kNone;) {
      model_.pieces[at / 2].pass = number;
      row.push_back(at);
      pass.length += model_.pieces[at / 2].length;
      const std::uint32_t next = model_.arms[model_.far(at)].continued;
      if (next == kNone) {
        pass.arms = {arm, model_.far(at)};
        break;
      }
      at = next;
    }
    measure_thirds(pass, row);
    model_.passes.push_back(pass);
  }

  // Places inside the balls of joints do not count, where there are others.
  void measure_thirds(Pass& pass, const std::vector<std::uint32_t>& row) const {
    std::array<double, 2> weight{0, 0}, sum{0, 0};
    double at = 0;
    for (const std::uint32_t arm : row) {
      const Piece& piece = model_.piece_of(arm);
      const Polyline course = arm % 2 == 0 ? piece.course : reversed(piece.course);
      const std::vector<double> arc = course.arc();
      const double first = model_.arms[arm].skip, last = piece.length - model_.arms[model_.far(arm)].skip;
      for (std::size_t i = 1; i < arc.size(); ++i) {
        const double middle = 0.5 * (arc[i - 1] + arc[i]), step = arc[i] - arc[i - 1];
        const double counts = (middle < first || middle > last ? 1e-3 : 1) * (step + 1e-12 * pass.length);
        const double radius = 0.5 * (course.radius[i - 1] + course.radius[i]), where = at + middle;
        for (std::size_t end : {0u, 1u}) {
          if ((end == 0 ? where : pass.length - where) > pass.length / 3 && arc.size() > 2) continue;
          weight[end] += counts;
          sum[end] += counts * radius;
        }
      }
      at += piece.length;
    }
    const double other = model_.piece_of(row.front()).course.radius.front();
    for (std::size_t end : {0u, 1u}) pass.radius[end] = weight[end] > 0 ? sum[end] / weight[end] : other;
    pass.widest = std::max(pass.radius[0], pass.radius[1]);
  }

  // Where it is thinnest, outside of the balls at its ends.
  void weigh(Piece& piece) const {
    const auto p = static_cast<std::size_t>(&piece - model_.pieces.data());
    if (piece.bar) return;
    const std::vector<double> arc = piece.course.arc();
    const double first = model_.arms[2 * p].skip, last = piece.length - model_.arms[2 * p + 1].skip;
    piece.cut_at = 0.5 * (first + last);
    double thinnest = place_on(piece.course, arc, piece.cut_at).radius;
    for (std::size_t i = 0; i < arc.size(); ++i)
      if (arc[i] > first && arc[i] < last && piece.course.radius[i] < thinnest) {
        thinnest = piece.course.radius[i];
        piece.cut_at = arc[i];
      }
    const double radius = std::max(model_.arms[2 * p].radius, model_.arms[2 * p + 1].radius);
    // What goes on beyond it is no neck.
    for (const Arm& arm : {model_.arms[2 * p], model_.arms[2 * p + 1]})
      if (arm.continued != kNone) piece.neck = 0;
    if (piece.neck > 0) {
      piece.gain = 0.01 + 0.2 * piece.neck;
      const auto thin = std::ranges::min_element(piece.course.radius) - piece.course.radius.begin();
      piece.cut_at = arc[static_cast<std::size_t>(thin)];
      return;
    }
    piece.gain = 3 + (radius > 0 ? std::min(piece.length / radius, 50.0) / 10 : 0);
  }

  const CurveGraph& graph_;
  Model model_;
};

}  // namespace

Model model_of(const CurveGraph& graph, double voxel) { return ModelBuilder(graph, voxel).build(); }

}  // namespace quench::tree
