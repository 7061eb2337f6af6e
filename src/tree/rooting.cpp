// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "tree/polyline_network.h"

namespace quench::tree {
namespace {

// A soma is at least so many times as thick as everything farther from its centre than so many of its radii: what is
// nearer is where neurites widen into it.
constexpr double kSomaThicker = 2, kSomaSurrounds = 1.5;
// The part of the height of a tree in which RootRule::top looks for the root node.
constexpr double kTopPart = 0.2;
// There an end is as thick as the thickest ball within so many of the largest radii of the tree; of those nearly as
// thick as the thickest one, the highest is taken.
constexpr double kTopSurrounds = 1.5, kTopAsThick = 0.8, kEndAsThick = 0.5;

bool before(const Vec3& a, const Vec3& b) { return std::tie(a[0], a[1], a[2]) < std::tie(b[0], b[1], b[2]); }

// A point of a tree and how thick it is. The thickest one does not depend on the order of nodes.
struct Candidate {
  double radius = -1;
  Vec3 point = Vec3::Zero();
  std::uint32_t node = kNone;  // a node, or
  std::uint32_t link = kNone;  // a point on a link
  std::size_t at = 0;

  bool better_than(const Candidate& other) const {
    return radius > other.radius || (radius == other.radius && before(point, other.point));
  }
};

class Rooting {
 public:
  Rooting(Network& network, std::span<const Start> known, const HierarchyOptions& options)
      : network_(network), options_(options), components_(components_of(network)) {
    starts_.resize(components_.count);
    given_.assign(components_.count, std::numeric_limits<std::size_t>::max());
    for (Start& start : starts_) start.node = kNone;
    for (const Start& start : known) starts_[components_.of_node[start.node]] = start;
  }

  std::vector<Start> run() {
    take_given();
    if (options_.soma != SomaRule::none) find_somata();
    choose();
    return sorted();
  }

 private:
  void take_given() {
    std::vector<double> nearest(components_.count, std::numeric_limits<double>::infinity());
    for (std::size_t i = 0; i < options_.roots.size() && !network_.nodes.empty(); ++i) {
      std::uint32_t best = 0;
      const auto away = [&](std::uint32_t n) { return (network_.nodes[n].point - options_.roots[i]).squaredNorm(); };
      for (std::uint32_t n = 1; n < network_.nodes.size(); ++n)
        if (away(n) < away(best)) best = n;
      const std::uint32_t c = components_.of_node[best];
      given_[c] = std::min(given_[c], i);
      if (away(best) >= nearest[c]) continue;
      nearest[c] = away(best);
      if (starts_[c].node != best) starts_[c].plant.soma.reset();
      starts_[c].node = best;
    }
  }

  // The thickest point of each tree, nodes and points of links alike.
  std::vector<Candidate> thickest_points() const {
    std::vector<Candidate> best(components_.count);
    const auto offer = [&](std::uint32_t node_of_tree, const Candidate& candidate) {
      Candidate& old = best[components_.of_node[node_of_tree]];
      if (candidate.better_than(old)) old = candidate;
    };
    for (std::uint32_t n = 0; n < network_.nodes.size(); ++n)
      offer(n, {network_.nodes[n].radius, network_.nodes[n].point, n});
    for (std::uint32_t l = 0; l < network_.links.size(); ++l) {
      const Network::Link& link = network_.links[l];
      for (std::size_t i = 1; i + 1 < link.points.size(); ++i)
        offer(link.from, {link.radius[i], link.points[i], kNone, l, i});
    }
    return best;
  }
  void find_somata() {
    const std::vector<Candidate> thickest = thickest_points();
    std::vector<double> elsewhere(components_.count, 0);
    std::vector<char> leaves(components_.count, 0);  // something is outside of the ball: else it is no soma
    for (const Network::Link& link : network_.links) {
      const std::uint32_t c = components_.of_node[link.from];
      for (std::size_t i = 0; i < link.points.size(); ++i) {
        const double away = (link.points[i] - thickest[c].point).norm();
        if (away > thickest[c].radius) leaves[c] = 1;
        if (away > kSomaSurrounds * thickest[c].radius) elsewhere[c] = std::max(elsewhere[c], link.radius[i]);
      }
    }
    for (std::uint32_t c = 0; c < components_.count; ++c) {
      Start& start = starts_[c];
      const Candidate& centre = thickest[c];
      if (start.plant.soma || !(centre.radius > 0) || !leaves[c]) continue;
      if (options_.soma == SomaRule::automatic && (elsewhere[c] == 0 || centre.radius < kSomaThicker * elsewhere[c]))
        continue;
      if (start.node != kNone && (network_.nodes[start.node].point - centre.point).norm() > centre.radius) continue;
      start.node = centre.node != kNone ? centre.node : split(centre.link, centre.at, c);
      start.plant.soma = centre.radius;
      merge_into(start.node, centre.radius);
    }
  }
  std::uint32_t split(std::uint32_t l, std::size_t at, std::uint32_t component) {
    const auto node = static_cast<std::uint32_t>(network_.nodes.size());
    Network::Link &first = network_.links[l], second = first;
    network_.nodes.push_back({first.points[at], first.radius[at]});
    components_.of_node.push_back(component);
    const auto cut = static_cast<std::ptrdiff_t>(at);
    second.from = first.to = node;
    second.points.erase(second.points.begin(), second.points.begin() + cut);
    second.radius.erase(second.radius.begin(), second.radius.begin() + cut);
    first.points.resize(at + 1);
    first.radius.resize(at + 1);
    if (!first.bridged.empty()) {
      second.bridged.erase(second.bridged.begin(), second.bridged.begin() + cut);
      first.bridged.resize(at);
    }
    network_.links.push_back(std::move(second));
    return node;
  }
  // What is joined to the node inside of its ball goes; what leaves the ball begins with a straight line from its
  // centre. The soma is no part of a neurite: the radius is that where it leaves the ball.
  void merge_into(std::uint32_t centre, double ball) {
    const auto links_at = network_.links_at_nodes();
    const Vec3 c = network_.nodes[centre].point;
    const auto inside = [&](const Vec3& x) { return (x - c).norm() <= ball; };
    std::vector<char> gone(network_.links.size(), 0);
    std::vector<std::pair<std::uint32_t, std::uint32_t>> came{{centre, kNone}};
    for (std::size_t i = 0; i < came.size(); ++i) {
      const auto [node, by] = came[i];
      for (const std::uint32_t l : links_at[node]) {
        if (l == by) continue;
        Network::Link& link = network_.links[l];
        if (link.from != node) reverse(link);
        std::size_t out = 0;
        while (out < link.points.size() && inside(link.points[out])) ++out;
        if (out == link.points.size()) {
          gone[l] = 1;
          came.push_back({link.to, l});
        } else {
          leave(link, out, centre, ball);
        }
      }
    }
    std::vector<Network::Link> left;
    for (std::size_t l = 0; l < gone.size(); ++l)
      if (!gone[l]) left.push_back(std::move(network_.links[l]));
    network_.links = std::move(left);
    for (const auto& [node, by] : came)
      if (node != centre) components_.of_node[node] = kNone;
  }
  static void reverse(Network::Link& link) {
    std::swap(link.from, link.to);
    std::ranges::reverse(link.points);
    std::ranges::reverse(link.radius);
    std::ranges::reverse(link.bridged);
  }
  // `out`: the first point outside; those before it lie inside.
  void leave(Network::Link& link, std::size_t out, std::uint32_t centre, double ball) const {
    const Vec3 c = network_.nodes[centre].point;
    const Vec3 a = link.points[out - 1] - c, d = link.points[out] - link.points[out - 1];
    const double dd = d.squaredNorm(), ad = a.dot(d);
    const double t = (-ad + std::sqrt(std::max(0.0, ad * ad - dd * (a.squaredNorm() - ball * ball)))) / dd;
    const double radius = (1 - t) * std::min(link.radius[out - 1], link.radius[out]) + t * link.radius[out];
    const auto last = static_cast<std::ptrdiff_t>(out);
    const Vec3 door = c + a + t * d;
    link.points.erase(link.points.begin(), link.points.begin() + last);
    link.radius.erase(link.radius.begin(), link.radius.begin() + last);
    link.points.insert(link.points.begin(), {c, door});
    link.radius.insert(link.radius.begin(), {radius, radius});
    if (!link.bridged.empty()) {
      link.bridged.erase(link.bridged.begin(), link.bridged.begin() + last - 1);
      link.bridged.insert(link.bridged.begin(), 0);
    }
    link.from = centre;
  }

  void choose() {
    const auto links_at = network_.links_at_nodes();
    std::vector<std::vector<Candidate>> offers(components_.count);
    for (std::uint32_t n = 0; n < network_.nodes.size(); ++n) {
      const std::uint32_t c = components_.of_node[n];
      if (c == kNone || starts_[c].node != kNone) continue;
      const bool any = options_.root == RootRule::thickest;
      if (!any && links_at[n].size() > 1) continue;
      offers[c].push_back({any ? network_.nodes[n].radius : thickness_of_end(links_at, n), network_.nodes[n].point, n});
    }
    if (options_.root == RootRule::top) keep_top_ends(offers);
    for (std::uint32_t c = 0; c < components_.count; ++c)
      for (Candidate best; const Candidate& candidate : offers[c])
        if (candidate.better_than(best)) {
          best = candidate;
          starts_[c].node = best.node;
        }
  }
  // Keeps the candidates whose value is at least this share of the largest.
  template <class Value>
  static void keep_largest(std::vector<Candidate>& candidates, double share, const Value& value) {
    std::vector<double> values;
    for (const Candidate& candidate : candidates) values.push_back(value(candidate));
    const double least = share * *std::ranges::max_element(values);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < values.size(); ++i)
      if (values[i] >= least) candidates[kept++] = candidates[i];
    candidates.resize(kept);
  }
  double height(const Vec3& x) const { return -x.dot(options_.down); }
  // Of the free ends of each tree only the highest one of those at the top by the thickness around it and its own.
  void keep_top_ends(std::vector<std::vector<Candidate>>& offers) const {
    std::vector<std::vector<Candidate>> balls(components_.count);
    for (const Network::Link& link : network_.links)
      for (std::size_t i = 0; i < link.points.size(); ++i)
        balls[components_.of_node[link.from]].push_back({link.radius[i], link.points[i]});
    for (std::uint32_t c = 0; c < components_.count; ++c) {
      std::vector<Candidate>& ends = offers[c];
      if (ends.size() < 2) continue;
      const auto of_height = [&](const Candidate& end) { return height(end.point); };
      const auto [low, high] = std::ranges::minmax(balls[c], {}, of_height);
      const double highest_end = of_height(std::ranges::max(ends, {}, of_height));
      const double top = std::min(highest_end, of_height(high) - kTopPart * (of_height(high) - of_height(low)));
      std::erase_if(ends, [&](const Candidate& end) { return of_height(end) < top; });
      const double reach = kTopSurrounds * std::ranges::max(balls[c], {}, &Candidate::radius).radius;
      const auto around = [&](const Candidate& end) {
        double radius = end.radius;
        for (const Candidate& ball : balls[c])
          if (ball.radius > radius && (ball.point - end.point).norm() <= reach) radius = ball.radius;
        return radius;
      };
      keep_largest(ends, kTopAsThick, around);
      keep_largest(ends, kEndAsThick, [](const Candidate& end) { return end.radius; });
      const double highest = of_height(std::ranges::max(ends, {}, of_height));
      std::erase_if(ends, [&](const Candidate& end) { return of_height(end) < highest; });
    }
  }
  // A course that ends where a tube is cut off may run into the rim: it is as thick as the balls that hold its end.
  double thickness_of_end(const base::Csr<std::uint32_t>& links_at, std::uint32_t n) const {
    const Vec3& end = network_.nodes[n].point;
    double radius = network_.nodes[n].radius;
    for (const std::uint32_t l : links_at[n])
      for (std::size_t i = 0; i < network_.links[l].points.size(); ++i)
        if ((network_.links[l].points[i] - end).norm() <= network_.links[l].radius[i])
          radius = std::max(radius, network_.links[l].radius[i]);
    return radius;
  }

  std::vector<Start> sorted() const {
    std::vector<double> length(components_.count, 0);
    for (const Network::Link& link : network_.links) length[components_.of_node[link.to]] += length_of(link.points);
    std::vector<std::uint32_t> order(components_.count);
    for (std::uint32_t c = 0; c < components_.count; ++c) order[c] = c;
    std::ranges::stable_sort(order, [&](std::uint32_t a, std::uint32_t b) {
      return given_[a] != given_[b] ? given_[a] < given_[b] : length[a] > length[b];
    });
    std::vector<Start> result;
    for (const std::uint32_t c : order) result.push_back(starts_[c]);
    return result;
  }

  Network& network_;
  const HierarchyOptions& options_;
  Components components_;
  std::vector<Start> starts_;       // per component; node kNone: not chosen yet
  std::vector<std::size_t> given_;  // per component: the first of the roots that are given which is its
};

}  // namespace

std::vector<Start> rooted(Network& network, std::span<const Start> known, const HierarchyOptions& options) {
  return Rooting(network, known, options).run();
}

}  // namespace quench::tree
