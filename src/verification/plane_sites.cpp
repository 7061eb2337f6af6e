// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "verification/nearest_sites.h"

namespace quench::verification {

namespace {

/// Circle through three sites, exact: with s = p - origin, determinant |s|^2 - linear . s is negative inside, and the
/// centre is origin + linear / (2 determinant); determinant > 0, below 2^42. |linear| < 2^62 for coordinates below
/// 2^20.
struct Circle {
  Point origin{};
  Wide determinant = 0;  ///< 0: the three sites are collinear
  std::array<Wide, 2> linear{};

  Circle() = default;
  Circle(const Point& a, const Point& b, const Point& c) : origin(a) {
    const std::array<Wide, 2> u{b[0] - a[0], b[1] - a[1]}, v{c[0] - a[0], c[1] - a[1]};
    const Wide uu = u[0] * u[0] + u[1] * u[1], vv = v[0] * v[0] + v[1] * v[1];
    determinant = u[0] * v[1] - u[1] * v[0];
    linear = {uu * v[1] - vv * u[1], vv * u[0] - uu * v[0]};
    if (determinant >= 0) return;
    determinant = -determinant;
    for (Wide& x : linear) x = -x;
  }
  Wide side(const Point& p) const {
    const std::array<Wide, 2> s{p[0] - origin[0], p[1] - origin[1]};
    return determinant * (s[0] * s[0] + s[1] * s[1]) - linear[0] * s[0] - linear[1] * s[1];
  }
  Vec3 centre() const {
    const double twice = 2 * static_cast<double>(determinant);
    return {static_cast<double>(origin[0]) + static_cast<double>(linear[0]) / twice,
            static_cast<double>(origin[1]) + static_cast<double>(linear[1]) / twice, 0};
  }
};

bool is_empty_of(const Circle& circle, const Ids& candidates, const Sites& sites) {
  return std::none_of(candidates.begin(), candidates.end(),
                      [&](std::uint32_t s) { return circle.side(sites.scaled()[s]) < 0; });
}

// The circle through the three nearest candidates that are not on one line.
Circle circle_of_nearest(const Ids& candidates, const Sites& sites) {
  const auto& at = sites.scaled();
  for (std::size_t k = 2; k < candidates.size(); ++k) {
    const Circle circle(at[candidates[0]], at[candidates[1]], at[candidates[k]]);
    if (circle.determinant != 0) return circle;
  }
  return {};
}

// As nearest_empty_sphere(): several Voronoi vertices may be closer to each other than the tolerance.
Circle nearest_empty_circle(const Ids& candidates, const Sites& sites, const Vec3& x) {
  const auto& at = sites.scaled();
  const std::size_t n = std::min<std::size_t>(candidates.size(), 40);
  Circle best;
  double best_distance = 0;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j)
      for (std::size_t k = j + 1; k < n; ++k) {
        const Circle circle(at[candidates[i]], at[candidates[j]], at[candidates[k]]);
        if (circle.determinant == 0) continue;
        const double distance = (circle.centre() - x).squaredNorm();
        if (best.determinant != 0 && distance >= best_distance) continue;
        if (!is_empty_of(circle, candidates, sites)) continue;
        best = circle;
        best_distance = distance;
      }
  return best;
}

std::string describe_place(const LatticePoint& p) { return fmt::format("({}, {})", p[0], p[1]); }

// Two cells with equal site sets, which are not empty.
std::optional<std::array<std::uint32_t, 2>> two_of_equal_sites(std::vector<std::pair<Ids, std::uint32_t>> sets) {
  std::sort(sets.begin(), sets.end());
  for (std::size_t i = 1; i < sets.size(); ++i)
    if (sets[i].first == sets[i - 1].first) return std::array{sets[i - 1].second, sets[i].second};
  return std::nullopt;
}

// What is wrong with the sites of line l of the file.
std::string wrong_line(const Result& result, const Sites& sites, const VertexSites& vertex_sites, std::size_t l) {
  const std::uint32_t e = result.line_edges[l];
  const auto& ends = result.complex.edges[e];
  const Ids common = edge_sites(result, vertex_sites, e);
  // Two different circles share at most two points.
  if (common.size() != 2 || vertex_sites.at(ends[0]) == vertex_sites.at(ends[1]))
    return fmt::format("{} is not a Voronoi edge: its ends share {} nearest boundary vertices", result.describe_edge(e),
                       common.size());
  if (result.line_sites.empty()) return {};
  const auto& claimed = result.line_sites[l];
  const LatticePoint &p = sites.lattice()[common[0]], &q = sites.lattice()[common[1]];
  if (claimed[0] == p && claimed[1] == q) return {};
  return fmt::format("{} lies between the sites {} and {}, its site_a and site_b are {} and {}",
                     result.describe_edge(e), describe_place(p), describe_place(q), describe_place(claimed[0]),
                     describe_place(claimed[1]));
}

}  // namespace

Ids voronoi_vertex_of_plane(const Sites& sites, const Vec3& x, double rounding) {
  const double squared = sites.tree().nearest_squared(x), radius = std::sqrt(squared);
  const double off = 1e-7 * radius + 2 * rounding;  // as in voronoi_vertex()
  std::vector<std::pair<double, std::uint32_t>> near;
  sites.tree().visit_within(x, squared + 5 * radius * off + 1e-9, [&](std::uint32_t s, const Box& box) {
    near.push_back({box.squared_distance(x), s});
    return true;
  });
  std::sort(near.begin(), near.end());
  Ids candidates;
  for (const auto& [distance, s] : near) candidates.push_back(s);
  Circle circle = circle_of_nearest(candidates, sites);
  if (circle.determinant == 0) return {};
  if (!is_empty_of(circle, candidates, sites)) circle = nearest_empty_circle(candidates, sites, x);
  if (circle.determinant == 0 || (circle.centre() - x).norm() > off + 1e-9) return {};
  Ids on_circle;
  for (const std::uint32_t s : candidates)
    if (circle.side(sites.scaled()[s]) == 0) on_circle.push_back(s);
  std::sort(on_circle.begin(), on_circle.end());
  return on_circle;
}

Check check_voronoi_of_plane(const Result& result, const Sites& sites, VertexSites& vertex_sites, Context* context) {
  const std::string name = "Voronoi cells";
  const std::vector<std::uint32_t> vertices = sample(result.rows.size(), result.rows.size());
  vertex_sites.prepare(vertices, context);
  for (const std::uint32_t v : vertices)
    if (vertex_sites.at(v).empty())
      return failed(name, fmt::format("{} is not the centre of an empty circle through three boundary vertices",
                                      result.describe_vertex(v)));
  const auto wrong = [&](std::size_t l) { return wrong_line(result, sites, vertex_sites, l); };
  const std::size_t lines = result.line_edges.size(),
                    bad = first_failure(lines, context, "verify: Voronoi cells",
                                        [&](std::size_t l) { return wrong(l).empty(); });
  if (bad < lines) return failed(name, wrong(bad));
  std::vector<std::pair<Ids, std::uint32_t>> sets;
  for (const std::uint32_t v : vertices) sets.push_back({vertex_sites.at(v), v});
  if (const auto twice = two_of_equal_sites(std::move(sets)))
    return failed(name, fmt::format("{} and {} are the same Voronoi vertex", result.describe_vertex((*twice)[0]),
                                    result.describe_vertex((*twice)[1])));
  sets.clear();
  for (const std::uint32_t e : result.line_edges) sets.push_back({edge_sites(result, vertex_sites, e), e});
  if (const auto twice = two_of_equal_sites(std::move(sets)))
    return failed(name, fmt::format("{} and {} are the same Voronoi edge", result.describe_edge((*twice)[0]),
                                    result.describe_edge((*twice)[1])));
  return {name,
          true,
          fmt::format("all {} vertices and {} edges have their nearest boundary vertices{}", vertices.size(), lines,
                      result.line_sites.empty() ? " (no site_a, site_b to compare)" : ""),
          {}};
}

}  // namespace quench::verification
