// SPDX-License-Identifier: Apache-2.0
// docs/algorithms/pruning.md
#include "axis/detail.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <numeric>
#include <optional>

#include <string>
#include <utility>

#include "axis/measures.h"
#include "axis/shortest_paths.h"
#include "base/constants.h"
#include "base/csr.h"
#include "base/parallel.h"
#include "base/union_find.h"

namespace quench::axis {
namespace {

// Balls up to this factor of the automatic detail are those of thin parts: 2.6 voxels for cubes.
constexpr double kThin = 3;

// The cells that no larger cell contains, as one list: faces, edges, vertices (most edges and vertices have the height
// kNoTopCell, and are not among them).
class TopCells {
 public:
  TopCells(const CellComplex& complex, CellValues& height) : complex_(complex), height_(height) {}

  std::uint32_t count() const {
    return static_cast<std::uint32_t>(height_.face.size() + height_.edge.size() + height_.vertex.size());
  }
  double& height(std::uint32_t cell) const {
    if (cell < faces()) return height_.face[cell];
    if (cell < faces() + edges()) return height_.edge[cell - faces()];
    return height_.vertex[cell - faces() - edges()];
  }
  template <class Visit>
  void for_corners(std::uint32_t cell, const Visit& visit) const {
    if (cell < faces())
      for (const std::uint32_t v : complex_.corners(cell)) visit(v);
    else if (cell < faces() + edges())
      for (const std::uint32_t v : complex_.edges[cell - faces()]) visit(v);
    else
      visit(static_cast<std::uint32_t>(cell - faces() - edges()));
  }
  std::uint32_t first_corner(std::uint32_t cell) const {
    std::uint32_t first = kNone;
    for_corners(cell, [&](std::uint32_t v) { first = first == kNone ? v : first; });
    return first;
  }

 private:
  std::uint32_t faces() const { return static_cast<std::uint32_t>(height_.face.size()); }
  std::uint32_t edges() const { return static_cast<std::uint32_t>(height_.edge.size()); }
  const CellComplex& complex_;
  CellValues& height_;
};

// The components of { height > d } while d falls from the largest height to `least`, each with its peak. A component
// becomes significant when d falls to peak / kPeak. What each cell gets as its detail is the d at which it first was
// part of a significant component.
class Components {
 public:
  Components(const TopCells& cells, std::uint32_t vertex_count, double least)
      : cells_(cells), member_of_(vertex_count, kNone) {
    for (std::uint32_t c = 0; c < cells.count(); ++c)
      if (cells.height(c) >= least) order_.push_back({cells.height(c), c});
    tbb::parallel_sort(order_.begin(), order_.end(), [](const Entry& a, const Entry& b) {
      return a.height != b.height ? a.height > b.height : a.cell < b.cell;
    });
    std::uint32_t members = 0;
    for (const Entry& entry : order_)
      cells.for_corners(entry.cell, [&](std::uint32_t v) {
        if (member_of_[v] == kNone) member_of_[v] = members++;
      });
    sets_ = base::UnionFind(members);
    parts_.resize(members);
    next_.assign(order_.size(), kNone);
  }

  /// Writes the detail of the cells at or above `least` in place of their heights.
  void set_details() {
    for (std::uint32_t i = 0; i < order_.size(); ++i) add(i);
    for (Part& part : parts_)
      if (!part.significant) resolve(part, part.peak / kPeak);
  }

  /// The component of a vertex when d is `least`; kNone for those of no cell above it.
  std::uint32_t component_of(std::uint32_t vertex) {
    return member_of_[vertex] == kNone ? kNone : sets_.find(member_of_[vertex]);
  }
  std::size_t member_count() const { return parts_.size(); }
  /// Raises the details of all cells of the components that are needed.
  void raise(const std::vector<char>& needed, double least) {
    for (const Entry& entry : order_)
      if (needed[component_of(cells_.first_corner(entry.cell))])
        cells_.height(entry.cell) = std::max(cells_.height(entry.cell), least);
  }

 private:
  struct Entry {
    double height;
    std::uint32_t cell;
  };
  struct Part {
    double peak = 0;
    bool significant = false;
    std::uint32_t first = kNone, last = kNone;  // list of its cells without a detail, in order_
  };

  void resolve(Part& part, double detail) {
    for (std::uint32_t i = part.first; i != kNone; i = next_[i]) cells_.height(order_[i].cell) = detail;
    part.first = part.last = kNone;
    part.significant = true;
  }
  // Before anything happens to a component at d: it may have become significant on the way there.
  void catch_up(Part& part, double d) {
    if (!part.significant && part.peak / kPeak >= d) resolve(part, part.peak / kPeak);
  }
  void join(std::uint32_t a, std::uint32_t b, double d) {
    Part &p = parts_[a], &q = parts_[b];
    catch_up(p, d);
    catch_up(q, d);
    if (p.significant != q.significant) resolve(p.significant ? q : p, d);
    sets_.unite(a, b);
    const std::uint32_t root = sets_.find(a);
    Part merged{std::max(p.peak, q.peak), p.significant, p.first, p.last};
    if (q.first != kNone) {
      (merged.first == kNone ? merged.first : next_[merged.last]) = q.first;
      merged.last = q.last;
    }
    Part& other = root == a ? q : p;
    other = {0, true, kNone, kNone};
    parts_[root] = merged;
  }
  void add(std::uint32_t i) {
    const auto [height, cell] = order_[i];
    std::uint32_t root = kNone;
    cells_.for_corners(cell, [&](std::uint32_t v) {
      const std::uint32_t set = sets_.find(member_of_[v]);
      parts_[set].peak = std::max(parts_[set].peak, height);  // changes vertices that are met for the first time
      if (root != kNone && set != root) join(root, set, height);
      root = sets_.find(set);
    });
    Part& part = parts_[root];
    catch_up(part, height);
    if (part.significant) return;  // the detail is the height
    (part.first == kNone ? part.first : next_[part.last]) = i;
    part.last = i;
  }

  const TopCells& cells_;
  std::vector<std::uint32_t> member_of_;  // per vertex of a cell above `least`: its number among them
  std::vector<Entry> order_;
  base::UnionFind sets_{0};  // of members
  std::vector<Part> parts_;  // per member; of meaning at the roots
  std::vector<std::uint32_t> next_;
};

// Keeps what the boundary vertices need that no kept ball is near. On a thick body that is the shortest path along edges
// to a ball near enough. In thin parts it is the component that touches the boundary vertex, or else the cells whose
// balls touch it; shortest paths then connect these to the rest, since the thinning would by detours.
class Cover {
 public:
  Cover(const MedialAxis& axis, double least, Components& components, const TopCells& cells, CellValues& detail)
      : axis_(axis), least_(least), components_(components), cells_(cells), detail_(detail) {}

  void run(Context* context) {
    find_uncovered(context);
    if (std::ranges::none_of(uncovered_, [](char u) { return u; })) return;
    std::vector<std::uint32_t> all(axis_.complex.vertex_count);
    std::iota(all.begin(), all.end(), 0u);
    const BallTree tree(axis_.points, axis_.radius, std::move(all));
    ShortestPaths paths(axis_);
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
    kept_.assign(axis_.complex.vertex_count, 0);  // vertices of what is significant
    for (std::uint32_t c = 0; c < cells_.count(); ++c)
      if (cells_.height(c) >= least_) cells_.for_corners(c, [&](std::uint32_t v) { kept_[v] = 1; });
    std::vector<std::uint32_t> vertices;
    for (std::uint32_t v = 0; v < kept_.size(); ++v)
      if (kept_[v]) vertices.push_back(v);
    kept_tree_.emplace(axis_.points, axis_.radius, std::move(vertices));
    uncovered_ = uncovered(axis_.sites, axis_.grid, *kept_tree_, 2 * least_, context);
  }

  // Sites of thick parts, the farthest from what is kept first, so that the paths to them cover others.
  void reach_out(const BallTree& tree, ShortestPaths& paths) {
    std::vector<double> away(axis_.sites.size(), 0);
    base::for_indices(axis_.sites.size(), [&](std::size_t s) {
      if (!uncovered_[s] || largest_near(tree, position(s)) <= kThin * least_) return;
      away[s] = std::numeric_limits<double>::max();
      kept_tree_->nearest(position(s), away[s]);
    });
    std::vector<std::uint32_t> order;
    for (std::uint32_t s = 0; s < away.size(); ++s)
      if (away[s] > 0) order.push_back(s);
    std::ranges::stable_sort(order, std::greater{}, [&](std::uint32_t s) { return away[s]; });
    for (const std::uint32_t s : order) {
      add_path_to(position(s), tree, paths);
      uncovered_[s] = 0;
    }
  }
  double largest_near(const BallTree& tree, const Vec3& p) const {
    double largest = 0;
    const double near = 2 * least_;
    const auto bound = [&](std::size_t node) {
      const double radius = tree.largest_radius(node);
      return radius <= largest ? near : tree.distance(node, p) - radius;
    };
    tree.walk(bound, near, [&](std::size_t i) {
      const BallTree::Ball& ball = tree.balls()[i];
      if (ball.radius > largest && outside(ball, p) < near) largest = ball.radius;
    });
    return largest;
  }
  // Keeps the shortest path from a ball near enough to what is kept.
  void add_path_to(const Vec3& p, const BallTree& tree, ShortestPaths& paths) {
    paths.restart();
    for_balls_near(tree, p, 2 * least_, [&](std::uint32_t v) { paths.add_source(v); });
    const auto stop = [&](std::uint32_t v) { return kept_[v] != 0; };
    std::uint32_t v = paths.next(stop);
    while (v != kNone && !kept_[v]) v = paths.next(stop);
    if (v == kNone) return;  // TODO
    keep_path(paths, v);
    paths.walk_back(v, [&](std::uint32_t, std::uint32_t w) { kept_[w] = 1; });
  }
  void keep_path(const ShortestPaths& paths, std::uint32_t from) {
    paths.walk_back(from, [&](std::uint32_t edge, std::uint32_t vertex) {
      keep(detail_.edge[edge]);
      keep(detail_.vertex[vertex]);
    });
  }
  template <class Visit>
  void for_balls_near(const BallTree& tree, const Vec3& p, double near, const Visit& visit) const {
    tree.walk([&](std::size_t node) { return tree.distance(node, p) - tree.largest_radius(node); }, near,
              [&](std::size_t i) {
                if (outside(tree.balls()[i], p) < near) visit(tree.balls()[i].vertex);
              });
  }
  Vec3 position(std::size_t site) const {
    const LatticePoint& s = axis_.sites[site];
    return axis_.grid.world({static_cast<double>(s[0]), static_cast<double>(s[1]), static_cast<double>(s[2])});
  }

  // Faces of uncovered sites: their components, where they have one; of other sites the faces.
  void take_faces() {
    std::vector<char> has_component(axis_.sites.size(), 0);
    has_face_.assign(axis_.sites.size(), 0);
    for (std::size_t f = 0; f < axis_.face_sites.size(); ++f) {
      const std::uint32_t component = components_.component_of(axis_.complex.corners(f)[0]);
      if (component == kNone || !is_above(f)) continue;
      for (const std::uint32_t s : axis_.face_sites[f])
        if (uncovered_[s]) has_component[s] = needed_[component] = 1;
    }
    for (std::size_t f = 0; f < axis_.face_sites.size(); ++f)
      for (const std::uint32_t s : axis_.face_sites[f]) {
        if (!uncovered_[s]) continue;
        has_face_[s] = 1;
        if (!has_component[s]) keep(detail_.face[f]);
      }
  }
  // Whether a face is one of the cells that components are made of: all its corners are in one component then.
  bool is_above(std::size_t f) const {
    const double height = cap_height(axis_.measure(kLambda).value.face[f], smallest_radius(f)) * kBelowTie;
    return height >= least_;
  }
  double smallest_radius(std::size_t f) const {
    double least = base::kNever;
    for (const std::uint32_t v : axis_.complex.corners(f)) least = std::min(least, axis_.radius[v]);
    return least;
  }

  // Uncovered sites without faces: vertices and edges without faces whose balls touch them.
  void take_vertices(const BallTree& tree) {
    std::vector<char> touching(axis_.complex.vertex_count, 0);
    for (std::uint32_t s = 0; s < uncovered_.size(); ++s) {
      if (!uncovered_[s] || has_face_[s]) continue;
      // No ball contains the site: those that it is not outside of touch it.
      for_balls_near(tree, position(s), 1e-6 * least_, [&](std::uint32_t v) {
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

  // Connects parts that nothing significant is in to the nearest other part along edges, until each is connected to what
  // is significant or there is nothing else in its component of the axis.
  void connect(ShortestPaths& paths) {
    base::UnionFind parts = united_cells();
    std::vector<char> connected(axis_.complex.vertex_count, 0);  // of the roots
    for (std::uint32_t v = 0; v < kept_.size(); ++v)
      if (kept_[v]) connected[parts.find(v)] = 1;
    paths.restart();
    std::size_t open = 0;  // parts that are not connected
    for (std::uint32_t v = 0; v < axis_.complex.vertex_count; ++v) {
      if (!in_part_[v] || connected[parts.find(v)]) continue;
      open += parts.find(v) == v;
      paths.add_source(v);
    }
    const auto is_end = [&](std::uint32_t v) { return kept_[v] != 0; };
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
      if (kept_[v]) {
        if (!apart(source, v)) continue;
        keep_path(paths, v);
        join(source, v);
        continue;
      }
      for (const std::uint32_t e : paths.edges_at(v)) {
        const std::uint32_t w = paths.other_end(e, v);
        if (!paths.is_settled(w) || kept_[w] || !apart(source, paths.source_of(w))) continue;
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
      if (cells_.height(c) < least_) continue;
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
  Components& components_;
  const TopCells& cells_;
  CellValues& detail_;
  std::optional<BallTree> kept_tree_;
  std::vector<char> kept_;     // per vertex: what is significant, and paths to it
  std::vector<char> in_part_;  // per vertex: of a cell that is kept
  std::vector<char> uncovered_, has_face_, needed_;
};

}  // namespace

std::vector<char> uncovered(std::span<const LatticePoint> sites, const Grid& grid, const BallTree& kept,
                            double tolerance, Context* context) {
  std::vector<char> result(sites.size(), 0);
  const double limit = tolerance * (1 + 1e-9);
  const std::size_t chunks = base::chunks_for(sites.size(), std::size_t{1} << 15);
  base::for_chunks(chunks, context, "detail: cover", 0.3, 0.6, [&](std::size_t chunk) {
    const auto [first, last] = base::part_of(sites.size(), chunk, chunks);
    NearBalls near(kept, grid);
    for (std::size_t s = first; s < last; ++s) {
      double away = limit;
      result[s] = !near.find(sites[s], limit, away);
    }
  });
  return result;
}

}  // namespace quench::axis

namespace quench {

double auto_detail(const Grid& grid) { return 0.5 * grid.spacing.norm(); }

void add_detail(MedialAxis& axis, Context* context) {
  base::in_arena(context, [&] {
    using namespace axis;
    const double least = auto_detail(axis.grid);
    checkpoint(context, "detail", 0);
    Measure detail{std::string(kDetail), cap_heights_of_top_cells(axis, axis.measure(kLambda).value), {}};
    for (auto* values : {&detail.value.vertex, &detail.value.edge, &detail.value.face})
      base::for_indices(values->size(), [&](std::size_t i) {
        if ((*values)[i] != kNoTopCell) (*values)[i] *= kBelowTie;
      });
    if (getenv("SHARP"))
      for (std::size_t f = 0; f < axis.face_sites.size(); ++f) {
        double dd = 0;
        for (int a = 0; a < 3; ++a)
          if ((axis.sites[axis.face_sites[f][0]][a] ^ axis.sites[axis.face_sites[f][1]][a]) & 1) dd += 0.25 * axis.grid.spacing[a] * axis.grid.spacing[a];
        if (detail.value.face[f] > sqrt(dd) && detail.value.face[f] < least) detail.value.face[f] = least;
      }
    checkpoint(context, "detail", 0.1);
    const TopCells cells(axis.complex, detail.value);
    Components components(cells, axis.complex.vertex_count, least);
    components.set_details();
    checkpoint(context, "detail", 0.3);
    if (!getenv("NOCOVER")) Cover(axis, least, components, cells, detail.value).run(context);
    spread_to_sides(axis.complex, detail.value);
    if (getenv("OWN")) {
      const CellValues& l = axis.measure(kLambda).value;
      const double cap = least * (1 - 1e-8);
      for (std::size_t e = 0; e < axis.complex.edges.size(); ++e) {
        auto [a, b] = axis.complex.edges[e];
        detail.value.edge[e] = std::max(detail.value.edge[e], std::min(cap, cap_height(l.edge[e], std::min(axis.radius[a], axis.radius[b]))));
      }
      for (std::size_t v = 0; v < axis.complex.vertex_count; ++v)
        detail.value.vertex[v] = std::max(detail.value.vertex[v], std::min(cap, cap_height(l.vertex[v], axis.radius[v])));
    }
    keep_within_reach(axis, least, detail.value.vertex, context);
    checkpoint(context, "detail", 1);
    std::erase_if(axis.measures, [](const Measure& m) { return m.name == kDetail; });
    axis.measures.push_back(std::move(detail));
  });
}

}  // namespace quench
