// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "quench/burn.h"
#include "quench/complex.h"

/// Burn times by nodes straight from the definition: the least length of an exposing tree, as the fixed point of
/// T(x, s) = min over sets E of sectors at x that let s burn (s in E, or s is free once E and all that becomes free are
/// removed) of the largest arrival in E, but no less than the radius of x where that is a distance to the surface (at
/// vertices, and inside edges by the exact rule). Own links, sectors and pockets; exponential in the sectors of a node,
/// quadratic in the nodes of a polygon.
namespace quench::testing_burn {

/// The polygons in closed pockets: no edge of theirs has only one of them.
inline std::vector<char> pocket_faces(const CellComplex& complex) {
  std::vector<char> alive(complex.face_count(), 1);
  for (bool changed = true; changed;) {
    changed = false;
    std::vector<int> uses(complex.edges.size(), 0);
    for (std::size_t f = 0; f < alive.size(); ++f)
      if (alive[f])
        for (std::uint32_t e : complex.sides(f)) ++uses[e];
    for (std::size_t f = 0; f < alive.size(); ++f) {
      if (!alive[f]) continue;
      const auto sides = complex.sides(f);
      if (std::any_of(sides.begin(), sides.end(), [&](std::uint32_t e) { return uses[e] == 1; })) {
        alive[f] = 0;
        changed = true;
      }
    }
  }
  return alive;
}

/// The link of a node as a multigraph: each polygon corner joins two edge directions.
struct Link {
  std::vector<std::array<int, 2>> corners;  ///< ends of each link edge
  std::vector<char> in_pocket;              ///< of each link edge
};

/// The sectors of a link with pockets contracted, and which sets of arrivals burn each.
class LinkSectors {
 public:
  static constexpr int kMost = 12;  ///< sectors that neither are open nor lie in a pocket; throws beyond

  explicit LinkSectors(const Link& link) {
    const int n = static_cast<int>(link.corners.size());
    std::map<int, std::vector<int>> at;  // direction: corners, with multiplicity
    for (int c = 0; c < n; ++c)
      for (int d : link.corners[c]) at[d].push_back(c);
    std::vector<int> name(n);
    std::iota(name.begin(), name.end(), 0);
    const auto rename = [&](int from, int to) { std::replace(name.begin(), name.end(), from, to); };
    for (const auto& [d, corners] : at)
      if (corners.size() == 2) rename(name[corners[0]], name[corners[1]]);
    std::map<int, int> number;
    for (int c = 0; c < n; ++c) number.emplace(name[c], static_cast<int>(number.size()));
    sector_of.resize(n);
    for (int c = 0; c < n; ++c) sector_of[c] = number[name[c]];
    const int count = static_cast<int>(number.size());
    pocket.assign(count, 0);
    ends_.resize(count);
    std::set<int> fixed;  // directions on a pocket
    for (int c = 0; c < n; ++c) {
      pocket[sector_of[c]] = link.in_pocket[c];
      if (link.in_pocket[c]) fixed.insert(link.corners[c].begin(), link.corners[c].end());
    }
    for (const auto& [d, corners] : at)
      if (corners.size() != 2)
        for (int c : corners) ends_[sector_of[c]].push_back(fixed.contains(d) ? kFixed : d);
    std::vector<char> left(count);
    for (int s = 0; s < count; ++s) left[s] = !pocket[s];
    strip(left);
    open.assign(count, 0);
    for (int s = 0; s < count; ++s) open[s] = !pocket[s] && !left[s];
    find_minimal_sets(left);
    count_loops();
  }

  /// Times from arrivals; open sectors burn at the radius, none before `least`.
  void times(double radius, std::span<const double> arrival, std::span<double> time, double least = 0) const {
    for (std::size_t s = 0; s < sets_.size(); ++s) {
      time[s] = std::numeric_limits<double>::infinity();
      if (pocket[s]) continue;
      if (open[s]) time[s] = radius;
      for (const std::vector<int>& set : sets_[s]) {
        double latest = 0;
        for (int q : set) latest = std::max(latest, arrival[q]);
        time[s] = std::min(time[s], std::max(latest, least));
      }
    }
  }
  std::size_t size() const { return ends_.size(); }

  std::vector<int> sector_of;  ///< of each corner of the link
  std::vector<char> open, pocket;
  std::vector<char> bridge;  ///< can be left as a bridge when others have burned
  int loops = 0;             ///< first Betti number, pockets contracted

 private:
  static constexpr int kFixed = -1;

  // Removes every sector with a free end, until there is none.
  void strip(std::vector<char>& left) const {
    for (bool changed = true; changed;) {
      changed = false;
      std::map<int, int> degree;
      for (std::size_t s = 0; s < left.size(); ++s)
        if (left[s])
          for (int d : ends_[s]) ++degree[d];
      for (std::size_t s = 0; s < left.size(); ++s)
        if (left[s])
          for (int d : ends_[s])
            if (d != kFixed && degree[d] == 1) {
              left[s] = 0;
              changed = true;
            }
    }
  }

  bool on_cycle(int sector, const std::vector<char>& left) const {
    const auto& ends = ends_[static_cast<std::size_t>(sector)];
    if (ends.empty() || ends[0] == ends[1]) return true;
    std::set<int> reached{ends[0]};
    for (bool changed = true; changed;) {
      changed = false;
      for (std::size_t s = 0; s < left.size(); ++s)
        if (left[s] && static_cast<int>(s) != sector && !ends_[s].empty() &&
            reached.contains(ends_[s][0]) != reached.contains(ends_[s][1])) {
          reached.insert(ends_[s].begin(), ends_[s].end());
          changed = true;
        }
    }
    return reached.contains(ends[1]);
  }

  void find_minimal_sets(const std::vector<char>& left) {
    std::vector<int> closed;
    for (std::size_t s = 0; s < left.size(); ++s)
      if (left[s]) closed.push_back(static_cast<int>(s));
    if (closed.size() > kMost) throw std::length_error("too many sectors for brute force");
    std::vector<unsigned> masks(std::size_t{1} << closed.size());
    std::iota(masks.begin(), masks.end(), 0u);
    std::stable_sort(masks.begin(), masks.end(),
                     [](unsigned a, unsigned b) { return std::popcount(a) < std::popcount(b); });
    std::vector<std::vector<unsigned>> minimal(left.size());
    bridge.assign(left.size(), 0);
    for (unsigned mask : masks) {
      std::vector<char> rest = left;
      for (std::size_t i = 0; i < closed.size(); ++i)
        if (mask >> i & 1) rest[closed[i]] = 0;
      strip(rest);
      for (int s : closed) {
        if (rest[s] && !bridge[s] && !on_cycle(s, rest)) bridge[s] = 1;
        const auto& known = minimal[s];
        if (!rest[s] && std::none_of(known.begin(), known.end(), [&](unsigned m) { return (m & mask) == m; }))
          minimal[s].push_back(mask);
      }
    }
    sets_.resize(left.size());
    for (std::size_t s = 0; s < left.size(); ++s)
      for (unsigned mask : minimal[s]) {
        sets_[s].emplace_back();
        for (std::size_t i = 0; i < closed.size(); ++i)
          if (mask >> i & 1) sets_[s].back().push_back(closed[i]);
      }
  }

  // A closed loop without singular direction is a vertex with a loop.
  void count_loops() {
    std::map<int, int> group;
    int edges = 0, extra = 0;
    for (std::size_t s = 0; s < ends_.size(); ++s) {
      if (pocket[s]) continue;
      if (ends_[s].empty()) {
        ++extra;
        continue;
      }
      ++edges;
      for (int d : ends_[s]) group.emplace(d, d);
    }
    int components = static_cast<int>(group.size());
    for (std::size_t s = 0; s < ends_.size(); ++s) {
      if (pocket[s] || ends_[s].empty()) continue;
      const int a = group[ends_[s][0]], b = group[ends_[s][1]];
      if (a == b) continue;
      --components;
      for (auto& [d, g] : group)
        if (g == a) g = b;
    }
    loops = edges - static_cast<int>(group.size()) + components + extra;
  }

  std::vector<std::vector<int>> ends_;               // of each sector: singular directions, none or two
  std::vector<std::vector<std::vector<int>>> sets_;  // of each sector: the minimal sets that burn it
};

inline double radius_on_edge(double r0, double r1, double length, double t, RadiusRule rule) {
  const bool no_common_point = std::abs(r0 - r1) > length || length > r0 + r1;
  if (rule == RadiusRule::linear || no_common_point) return r0 + t * (r1 - r0);
  return std::sqrt(std::max(0.0, (1 - t) * r0 * r0 + t * r1 * r1 - t * (1 - t) * length * length));
}

inline std::vector<std::uint32_t> pieces_for(const CellComplex& complex, std::span<const Vec3> points, double omega) {
  std::vector<std::uint32_t> uses(complex.edges.size(), 0), pieces(complex.edges.size(), 1);
  for (std::uint32_t e : complex.face_edges) ++uses[e];
  std::set<std::uint32_t> at_seam;
  for (std::size_t e = 0; e < uses.size(); ++e)
    if (uses[e] > 2) at_seam.insert(complex.edges[e].begin(), complex.edges[e].end());
  for (std::uint32_t e : complex.face_edges) {  // no fire runs along lone edges: they stay whole
    const auto [a, b] = complex.edges[e];
    const double length = (points[a] - points[b]).norm();
    const std::uint32_t least = length > 0 && (at_seam.contains(a) || at_seam.contains(b)) ? 2 : 1;
    // A length that is a multiple of the spacing but for rounding counts as one.
    pieces[e] = std::max(least, static_cast<std::uint32_t>(std::ceil(length / omega * (1 - 1e-12))));
  }
  return pieces;
}

/// Throws std::length_error where a node has more than LinkSectors::kMost sectors to look at.
class BruteForceBurn {
 public:
  struct Node {
    Vec3 point;
    double radius = 0;
    double least = 0;             ///< the radius where it is a lower bound of times, else 0
    std::size_t link = 0;         ///< index in `links`
    std::size_t first_state = 0;  ///< states of a node follow each other, one per sector
  };
  /// A node on the rim of a polygon, in order around it.
  struct RimNode {
    std::size_t node, state;
    int side;        ///< of the polygon; a corner is named by the side that starts there
    bool is_corner;  ///< then it lies on the side before, too
  };

  BruteForceBurn(const CellComplex& complex, std::span<const Vec3> points, std::span<const double> radius,
                 std::vector<std::uint32_t> pieces_of_edges, RadiusRule rule)
      : pieces(std::move(pieces_of_edges)), pocket(pocket_faces(complex)) {
    std::vector<Link> at_vertex(complex.vertex_count), at_edge(complex.edges.size());
    place_in_link.resize(complex.face_vertices.size());
    place_in_edge_link.resize(complex.face_vertices.size());
    for (std::size_t f = 0; f < complex.face_count(); ++f) {
      const auto corners = complex.corners(f), sides = complex.sides(f);
      for (std::size_t i = 0; i < corners.size(); ++i) {
        const std::size_t before = (i + corners.size() - 1) % corners.size(), c = complex.face_offsets[f] + i;
        Link& link = at_vertex[corners[i]];
        place_in_link[c] = link.corners.size();
        link.corners.push_back({static_cast<int>(sides[before]), static_cast<int>(sides[i])});
        link.in_pocket.push_back(pocket[f]);
        place_in_edge_link[c] = at_edge[sides[i]].corners.size();
        at_edge[sides[i]].corners.push_back({0, 1});
        at_edge[sides[i]].in_pocket.push_back(pocket[f]);
      }
    }
    const auto add = [&](const Vec3& point, double r, bool is_bound, std::size_t link) {
      nodes.push_back({point, r, is_bound ? r : 0, link, state_count_});
      state_count_ += links[link].size();
      can_be_bridge.insert(can_be_bridge.end(), links[link].bridge.begin(), links[link].bridge.end());
    };
    for (std::size_t v = 0; v < complex.vertex_count; ++v) {
      links.emplace_back(at_vertex[v]);
      add(points[v], radius[v], true, v);
    }
    for (std::size_t e = 0; e < complex.edges.size(); ++e) {
      links.emplace_back(at_edge[e]);
      first_inserted.push_back(nodes.size());
      const auto [a, b] = complex.edges[e];
      const double length = (points[b] - points[a]).norm();
      for (std::uint32_t i = 1; i < pieces[e]; ++i) {
        const double t = static_cast<double>(i) / pieces[e];
        add(points[a] + t * (points[b] - points[a]), radius_on_edge(radius[a], radius[b], length, t, rule),
            rule == RadiusRule::exact, complex.vertex_count + e);
      }
    }
    first_inserted.push_back(nodes.size());
    for (std::size_t f = 0; f < complex.face_count(); ++f) {
      rims.emplace_back();
      const auto corners = complex.corners(f), sides = complex.sides(f);
      for (std::size_t i = 0; i < corners.size(); ++i) {
        const std::size_t c = complex.face_offsets[f] + i;
        const int side = static_cast<int>(i);
        rims[f].push_back({corners[i], state_at(corners[i], place_in_link[c]), side, true});
        const std::size_t first = first_inserted[sides[i]], last = first_inserted[sides[i] + 1];
        const bool forward = complex.edges[sides[i]][0] == corners[i];
        for (std::size_t k = first; k < last; ++k) {
          const std::size_t node = forward ? k : last - 1 - (k - first);
          rims[f].push_back({node, state_at(node, place_in_edge_link[c]), side, false});
        }
      }
    }
    solve();
    vertex_time.assign(complex.vertex_count, 0);
    for (std::size_t v = 0; v < complex.vertex_count; ++v) {
      vertex_time[v] = radius[v];
      for (std::size_t s = 0; s < links[v].size(); ++s)
        vertex_time[v] = std::max(vertex_time[v], time[nodes[v].first_state + s]);
    }
  }

  /// The nodes `i` and `j` of the rim of polygon `f` are joined by an arc in it.
  bool joined(std::size_t f, std::size_t i, std::size_t j) const {
    const auto& rim = rims[f];
    if (i == j) return false;
    if ((i + 1) % rim.size() == j || (j + 1) % rim.size() == i) return true;  // along an edge
    const int sides = rim.back().side + 1;
    const auto on = [&](const RimNode& n, int side) {
      return n.side == side || (n.is_corner && (n.side + sides - 1) % sides == side);
    };
    for (int side = 0; side < sides; ++side)
      if (on(rim[i], side) && on(rim[j], side)) return false;
    return true;
  }

  std::vector<std::uint32_t> pieces;
  std::vector<char> pocket;
  std::vector<LinkSectors> links;               ///< of the vertices, then of the edges
  std::vector<Node> nodes;                      ///< the vertices, then the inserted nodes, edge by edge
  std::vector<std::size_t> first_inserted;      ///< edges + 1
  std::vector<std::size_t> place_in_link;       ///< of each corner: its place in the link of its vertex
  std::vector<std::size_t> place_in_edge_link;  ///< of each corner: place of the polygon at the side that starts there
  std::vector<std::vector<RimNode>> rims;       ///< of each polygon
  std::vector<double> time;                     ///< per state
  std::vector<char> can_be_bridge;              ///< per state
  std::vector<double> vertex_time;

  std::size_t state_at(std::size_t node, std::size_t place) const {
    return nodes[node].first_state + static_cast<std::size_t>(links[nodes[node].link].sector_of[place]);
  }

 private:
  void solve() {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    time.assign(state_count_, infinity);
    struct Arc {
      std::size_t from, to;
      double length;
    };
    std::vector<Arc> arcs;
    for (std::size_t f = 0; f < rims.size(); ++f)
      for (std::size_t i = 0; !pocket[f] && i < rims[f].size(); ++i)
        for (std::size_t j = 0; j < rims[f].size(); ++j)
          if (joined(f, i, j))
            arcs.push_back({rims[f][i].state, rims[f][j].state,
                            (nodes[rims[f][i].node].point - nodes[rims[f][j].node].point).norm()});
    std::vector<double> arrival, last;
    do {
      last = time;
      arrival.assign(state_count_, infinity);
      for (const Arc& arc : arcs) arrival[arc.to] = std::min(arrival[arc.to], last[arc.from] + arc.length);
      for (const Node& node : nodes) {
        const LinkSectors& link = links[node.link];
        link.times(node.radius, std::span(arrival).subspan(node.first_state, link.size()),
                   std::span(time).subspan(node.first_state, link.size()), node.least);
      }
    } while (time != last);
  }

  std::size_t state_count_ = 0;
};

}  // namespace quench::testing_burn
