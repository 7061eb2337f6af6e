// SPDX-License-Identifier: Apache-2.0
#include "axis/cover.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "axis/ball_tree.h"
#include "axis/length_unit.h"
#include "axis/measures.h"
#include "axis/shortest_paths.h"
#include "base/constants.h"
#include "base/parallel.h"
#include "base/union_find.h"

namespace quench::axis {
namespace {

// What is compared with `2 * least` may be larger by so much, for rounding; see near_limit().
constexpr double kTolerance = 1e-9;

}  // namespace

std::vector<char> uncovered_sites(std::span<const LatticePoint> sites, const Grid& grid, const BallTree& kept,
                                  double least, Context* context) {
  std::vector<char> result(sites.size(), 0);
  const double limit = 2 * least * (1 + kTolerance);
  const std::size_t chunks = base::chunks_for(sites.size(), std::size_t{1} << 17);
  base::for_chunks(chunks, context, "detail", 0.3, 0.6, [&](std::size_t chunk) {
    const auto [first, last] = base::part_of(sites.size(), chunk, chunks);
    NearBalls near(kept, grid);
    for (std::size_t s = first; s < last; ++s) {
      double away = limit;
      result[s] = !near.find(sites[s], limit, away);
    }
  });
  return result;
}

namespace {

class Cover {
 public:
  Cover(const MedialAxis& axis, double least, std::span<const LatticePoint> pending, SignificantParts& components,
        const TopCells& cells, CellValues& detail)
      : axis_(axis), least_(least), pending_(pending), components_(components), cells_(cells), detail_(detail) {}

  void run(Context* context) {
    find_uncovered(context);
    if (std::ranges::none_of(uncovered_, [](char u) { return u; })) return;
    const BallTree tree(axis_);
    ShortestPaths paths(axis_, kLengthUnit * least_);
    reach_out(tree, paths);
    needed_.assign(components_.member_count(), 0);
    take_faces();
    take_vertices(tree);
    components_.raise(needed_, least_);
    connect(paths);
  }

 private:
  void keep(double& detail) const { detail = std::max(detail, least_); }

  void find_uncovered(Context* context) {
    kept_.assign(axis_.complex.vertex_count, kNot);
    for (std::uint32_t c = 0; c < cells_.count(); ++c)
      if (cells_.value(c) >= least_) cells_.for_corners(c, [&](std::uint32_t v) { kept_[v] = kSignificant; });
    std::vector<std::uint32_t> vertices;
    for (std::uint32_t v = 0; v < kept_.size(); ++v)
      if (kept_[v] != kNot) vertices.push_back(v);
    kept_tree_.emplace(axis_.points, axis_.radius, std::move(vertices));
    uncovered_ = uncovered_sites(pending_, axis_.grid, *kept_tree_, least_, context);
  }

  // Sites of thick parts, the farthest from what is kept first, so that the paths to them cover others.
  void reach_out(const BallTree& tree, ShortestPaths& paths) {
    std::vector<double> away(pending_.size(), 0);
    base::for_indices(pending_.size(), [&](std::size_t s) {
      if (!uncovered_[s] || largest_near(tree, position(s)) <= kThin * least_) return;
      away[s] = std::numeric_limits<double>::max();
      kept_tree_->nearest(position(s), away[s]);
    });
    std::vector<std::uint32_t> order;
    for (std::uint32_t s = 0; s < away.size(); ++s)
      if (away[s] > 0) order.push_back(s);
    std::ranges::stable_sort(order, std::greater{},
                             [&](std::uint32_t s) { return std::round(away[s] / (kLengthUnit * least_)); });
    path_nodes_.assign(tree.node_count(), 0);
    place_.resize(kept_.size());
    for (std::uint32_t i = 0; i < tree.size(); ++i) place_[tree.ball(i).vertex] = i;
    for (const std::uint32_t s : order) {
      if (!is_near_path(position(s), tree)) add_path_to(position(s), tree, paths);
      uncovered_[s] = 0;
    }
  }
  // Of most sites, and on wide smooth bodies each has thousands of balls near.
  bool is_near_path(const Vec3& p, const BallTree& tree) const {
    bool found = false;
    double limit = near_limit(least_);
    const auto bound = [&](std::size_t node) {
      return path_nodes_[node] ? tree.distance(node, p) - tree.largest_radius(node) : base::kNever;
    };
    tree.walk(bound, limit, [&](std::size_t i) {
      const BallTree::Ball ball = tree.ball(i);
      if (kept_[ball.vertex] != kPath || !(outside(ball, p) < limit)) return;
      found = true;
      limit = -base::kNever;
    });
    return found;
  }
  double largest_near(const BallTree& tree, const Vec3& p) const {
    double largest = 0;
    const double near = near_limit(least_);
    const auto bound = [&](std::size_t node) {
      const double radius = tree.largest_radius(node);
      return radius <= largest ? near : tree.distance(node, p) - radius;
    };
    tree.walk(bound, near, [&](std::size_t i) {
      const BallTree::Ball ball = tree.ball(i);
      if (ball.radius > largest && outside(ball, p) < near) largest = ball.radius;
    });
    return largest;
  }
  // Keeps the shortest path from a ball near enough to what is significant or, where one is very near, to an earlier
  // path; where all that is too far away, the largest of these balls. Not to any earlier path: in a chain of them each
  // would depend on what is far away, and they are longer. To none at all they would run side by side in thin tubes.
  void add_path_to(const Vec3& p, const BallTree& tree, ShortestPaths& paths) {
    paths.restart(kLongestPath * least_);
    std::vector<std::uint32_t> sources;
    for_balls_near(tree, p, near_limit(least_), [&](const BallTree::Ball& ball) {
      paths.add_source(ball.vertex);
      sources.push_back(ball.vertex);
    });
    const auto stop = [&](std::uint32_t v) {
      return kept_[v] == kSignificant || (kept_[v] == kPath && paths.distance(v) <= kNearPath / kLengthUnit);
    };
    std::uint32_t v = paths.next(stop);
    while (v != kNone && !stop(v)) v = paths.next(stop);
    const auto keep_vertex = [&](std::uint32_t w) {
      keep(detail_.vertex[w]);
      if (kept_[w] != kNot) return;
      kept_[w] = kPath;
      for (std::size_t node = tree.leaf_of(place_[w]); node > 0 && !path_nodes_[node]; node /= 2) path_nodes_[node] = 1;
    };
    if (v == kNone) v = largest_of(sources);
    keep_vertex(v);
    paths.walk_back(v, [&](std::uint32_t e, std::uint32_t w) {
      keep(detail_.edge[e]);
      keep_vertex(w);
    });
  }
  std::uint32_t largest_of(const std::vector<std::uint32_t>& vertices) const {
    return *std::ranges::max_element(vertices, {}, [&](std::uint32_t v) { return std::pair(axis_.radius[v], ~v); });
  }
  void keep_path(const ShortestPaths& paths, std::uint32_t from) {
    paths.walk_back(from, [&](std::uint32_t edge, std::uint32_t vertex) {
      keep(detail_.edge[edge]);
      keep(detail_.vertex[vertex]);
    });
  }
  Vec3 position(std::size_t site) const { return axis_.grid.world_of(pending_[site]); }

  // Faces (in a plane edges) of uncovered sites: their components, where they have one; of other sites the faces.
  void take_faces() {
    const auto& sites_of = top_sites(axis_);
    const std::vector<std::uint32_t> place = uncovered_places();
    std::vector<char> has_component(pending_.size(), 0);
    has_face_.assign(pending_.size(), 0);
    for (std::uint32_t f = 0; f < sites_of.size(); ++f) {
      const std::uint32_t component = components_.component_of(cells_.first_corner(f));
      if (component == kNone || !components_.is_above(f)) continue;
      for (const std::uint32_t s : sites_of[f])
        if (place[s] != kNone) has_component[place[s]] = needed_[component] = 1;
    }
    for (std::uint32_t f = 0; f < sites_of.size(); ++f)
      for (const std::uint32_t s : sites_of[f]) {
        if (place[s] == kNone) continue;
        has_face_[place[s]] = 1;
        if (!has_component[place[s]]) keep(cells_.value(f));
      }
  }
  // Where sites of the axis are in pending_, those that are uncovered; others kNone.
  std::vector<std::uint32_t> uncovered_places() const {
    std::vector<std::uint32_t> place(axis_.sites.size(), kNone);
    const auto in_order = [](const LatticePoint& a, const LatticePoint& b) {
      return std::array{a[2], a[1], a[0]} < std::array{b[2], b[1], b[0]};
    };
    std::uint32_t p = 0;
    for (std::size_t s = 0; s < place.size(); ++s) {
      while (p < pending_.size() && in_order(pending_[p], axis_.sites[s])) ++p;
      if (p < pending_.size() && pending_[p] == axis_.sites[s] && uncovered_[p]) place[s] = p;
    }
    return place;
  }
  // Uncovered sites without faces: vertices and edges without faces whose balls touch them.
  void take_vertices(const BallTree& tree) {
    std::vector<char> touching(axis_.complex.vertex_count, 0);
    for (std::uint32_t s = 0; s < uncovered_.size(); ++s) {
      if (!uncovered_[s] || has_face_[s]) continue;
      // No ball contains the site: those that it is not outside of touch it.
      for_balls_near(tree, position(s), 1e-6 * least_, [&](const BallTree::Ball& ball) {
        const std::uint32_t v = ball.vertex;
        if (const std::uint32_t component = components_.component_of(v); component != kNone) {
          needed_[component] = 1;
        } else {
          touching[v] = 1;
          keep(detail_.vertex[v]);
        }
      });
    }
    for (std::uint32_t e = 0; e < detail_.edge.size(); ++e) {
      const auto [a, b] = axis_.complex.edges[e];
      if (detail_.edge[e] != kNoTopCell && touching[a] && touching[b]) keep(detail_.edge[e]);
    }
  }

  // Connects parts that nothing significant is in to the nearest other part along edges, until each is connected to
  // what is significant or there is nothing else near enough.
  void connect(ShortestPaths& paths) {
    base::UnionFind parts = united_cells();
    std::vector<char> connected(axis_.complex.vertex_count, 0);  // of the roots
    for (std::uint32_t v = 0; v < kept_.size(); ++v)
      if (kept_[v] != kNot) connected[parts.find(v)] = 1;
    paths.restart(kLongestThinPath * least_);
    std::size_t open = 0;  // parts that are not connected
    for (std::uint32_t v = 0; v < axis_.complex.vertex_count; ++v) {
      if (!in_part_[v] || connected[parts.find(v)]) continue;
      open += parts.find(v) == v;
      paths.add_source(v);
    }
    const auto is_end = [&](std::uint32_t v) { return kept_[v] != kNot; };
    const auto join = [&](std::uint32_t a, std::uint32_t b) {
      const bool either = connected[parts.find(a)] || connected[parts.find(b)];
      parts.unite(a, b);
      connected[parts.find(a)] = either;
      --open;
    };
    const auto apart = [&](std::uint32_t a, std::uint32_t b) {
      a = parts.find(a);
      b = parts.find(b);
      return a != b && !(connected[a] && connected[b]);
    };
    for (std::uint32_t v; open > 0 && (v = paths.next(is_end)) != kNone;) {
      const std::uint32_t source = paths.source_of(v);
      if (kept_[v] != kNot) {
        if (!apart(source, v)) continue;
        keep_path(paths, v);
        join(source, v);
        continue;
      }
      for (const std::uint32_t e : paths.edges_at(v)) {
        const std::uint32_t w = paths.other_end(e, v);
        if (!paths.is_settled(w) || kept_[w] != kNot || !apart(source, paths.source_of(w))) continue;
        if (paths.distance(v) + paths.length(e) + paths.distance(w) > paths.longest()) continue;
        keep(detail_.edge[e]);
        keep_path(paths, v);
        keep_path(paths, w);
        join(source, paths.source_of(w));
      }
    }
  }
  // The cells that are kept, as sets of their vertices.
  base::UnionFind united_cells() {
    base::UnionFind parts(axis_.complex.vertex_count);
    in_part_.assign(axis_.complex.vertex_count, 0);
    for (std::uint32_t c = 0; c < cells_.count(); ++c) {
      if (cells_.value(c) < least_) continue;
      const std::uint32_t first = cells_.first_corner(c);
      cells_.for_corners(c, [&](std::uint32_t v) {
        in_part_[v] = 1;
        parts.unite(first, v);
      });
    }
    return parts;
  }

  const MedialAxis& axis_;
  double least_;
  std::span<const LatticePoint> pending_;
  SignificantParts& components_;
  const TopCells& cells_;
  CellValues& detail_;
  std::optional<BallTree> kept_tree_;
  enum Kept : char { kNot, kSignificant, kPath };
  std::vector<Kept> kept_;                  // per vertex: of what is significant, and of paths to it
  std::vector<std::uint32_t> place_;        // per vertex: of its ball in the tree
  std::vector<char> path_nodes_;            // per node of the tree: whether there is a ball of a path
  std::vector<char> in_part_;               // per vertex: of a cell that is kept
  std::vector<char> uncovered_, has_face_;  // per vertex of pending_
  std::vector<char> needed_;                // per component
};

}  // namespace

void cover_boundary(const MedialAxis& axis, double least, std::span<const LatticePoint> pending,
                    SignificantParts& parts, const TopCells& cells, CellValues& detail, Context* context) {
  Cover(axis, least, pending, parts, cells, detail).run(context);
}

}  // namespace quench::axis
