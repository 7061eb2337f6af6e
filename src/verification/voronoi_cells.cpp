// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "verification/nearest_sites.h"

namespace quench::verification {

namespace {

constexpr std::size_t kAllRadiiUpTo = 2'000'000;
constexpr double kRadiusTolerance = 1e-5;

std::string describe(const LatticePoint& p) { return fmt::format("({}, {}, {})", p[0], p[1], p[2]); }

// The first two of the given cells with equal site sets.
template <class SitesOf>
std::optional<std::array<std::uint32_t, 2>> first_repeated(const std::vector<std::uint32_t>& cells,
                                                           const SitesOf& sites_of) {
  std::vector<std::pair<Ids, std::uint32_t>> sets;
  sets.reserve(cells.size());
  for (std::uint32_t c : cells) sets.push_back({sites_of(c), c});
  std::sort(sets.begin(), sets.end());
  for (std::size_t i = 1; i < sets.size(); ++i)
    if (sets[i].first == sets[i - 1].first) return std::array{sets[i - 1].second, sets[i].second};
  return std::nullopt;
}

}  // namespace

Check check_radii(const Result& result, const Sites& sites, Context* context) {
  Check check{"radii", false, {}, {}};
  if (!result.has_voxel_geometry) return not_checked(check.name, kNotOfVoxels);
  cover(check, result.fitted ? "point voxel_radius" : "point radius");
  if (result.fitted) cover(check, "point voxel_point");
  if (result.radius.empty()) {
    check.detail = "the point array 'radius' is missing";
    return check;
  }
  const std::vector<std::uint32_t> vertices = sample(result.rows.size(), kAllRadiiUpTo);
  const auto distance = [&](std::uint32_t v) {
    return result.unit * std::sqrt(sites.tree().nearest_squared(result.scaled[v]));
  };
  const std::vector<char> smoothed = smoothed_vertices(result);
  std::atomic<std::size_t> interpolated{0};
  const std::size_t bad = first_failure(vertices.size(), context, "verify: radii", [&](std::size_t i) {
    const double expected = distance(vertices[i]);
    if (smoothed[vertices[i]]) interpolated.fetch_add(1, std::memory_order_relaxed);
    return std::abs(result.radius[vertices[i]] - expected) <= (smoothed[vertices[i]] ? 2 * result.auto_detail : 0) +
                                                                  (kRadiusTolerance + result.slack) * expected +
                                                                  4 * result.rounding * result.unit;
  });
  check.passed = bad == vertices.size();
  check.detail = check.passed ? fmt::format("{} of {} vertices have the distance to the nearest boundary vertex",
                                            vertices.size(), result.rows.size()) +
                                    (interpolated > 0 ? fmt::format(", {} that may be smoothed to a {} diagonal",
                                                                    interpolated.load(), pixel_or_voxel(result))
                                                      : std::string())
                              : fmt::format("{} has radius {:.9g}, its nearest boundary vertex is at distance {:.9g}",
                                            result.describe_vertex(vertices[bad]), result.radius[vertices[bad]],
                                            distance(vertices[bad]));
  return check;
}

Check check_voronoi(const Result& result, const Sites& sites, VertexSites& vertex_sites, std::size_t samples,
                    Context* context) {
  Check check{"Voronoi cells", false, {}, {}};
  const CellComplex& complex = result.complex;
  const std::vector<std::uint32_t> vertices = sample(result.rows.size(), samples),
                                   edges = sample(complex.edges.size(), samples),
                                   faces = sample(complex.face_count(), samples);
  std::vector<std::uint32_t> needed = vertices;
  for (std::uint32_t e : edges) needed.insert(needed.end(), complex.edges[e].begin(), complex.edges[e].end());
  for (std::uint32_t f : faces) needed.insert(needed.end(), complex.corners(f).begin(), complex.corners(f).end());
  vertex_sites.prepare(needed, context);

  for (std::uint32_t v : needed)
    if (vertex_sites.at(v).empty()) {
      check.detail =
          fmt::format("{} is not the centre of an empty sphere through four boundary vertices that span space",
                      result.describe_vertex(v));
      return check;
    }
  for (std::uint32_t e : edges) {
    const auto& ends = complex.edges[e];
    const std::size_t common = edge_sites(result, vertex_sites, e).size();
    // The common sites of two different spheres lie on a circle: three of them span a plane.
    if (common < 3 || vertex_sites.at(ends[0]) == vertex_sites.at(ends[1])) {
      check.detail = fmt::format("{} is not a Voronoi edge: its ends share {} nearest boundary vertices",
                                 result.describe_edge(e), common);
      return check;
    }
  }
  for (std::uint32_t f : faces) {
    const Ids common = face_sites(result, vertex_sites, f);
    if (common.size() != 2) {
      check.detail = fmt::format("{} is not a Voronoi face: its corners share {} nearest boundary vertices",
                                 result.describe_face(f), common.size());
      return check;
    }
    if (result.face_sites.empty()) continue;
    const auto& claimed = result.face_sites[f];
    const LatticePoint &p = sites.lattice()[common[0]], &q = sites.lattice()[common[1]];
    if (!(claimed[0] == p && claimed[1] == q) && !(claimed[0] == q && claimed[1] == p)) {
      check.detail =
          fmt::format("{} lies between the sites {} and {}, its site_a and site_b are {} and {}",
                      result.describe_face(f), describe(p), describe(q), describe(claimed[0]), describe(claimed[1]));
      return check;
    }
  }
  if (const auto twice = first_repeated(vertices, [&](std::uint32_t v) { return vertex_sites.at(v); })) {
    check.detail = fmt::format("{} and {} are the same Voronoi vertex", result.describe_vertex((*twice)[0]),
                               result.describe_vertex((*twice)[1]));
    return check;
  }
  if (const auto twice = first_repeated(edges, [&](std::uint32_t e) { return edge_sites(result, vertex_sites, e); })) {
    check.detail = fmt::format("{} and {} are the same Voronoi edge", result.describe_edge((*twice)[0]),
                               result.describe_edge((*twice)[1]));
    return check;
  }
  if (const auto twice = first_repeated(faces, [&](std::uint32_t f) { return face_sites(result, vertex_sites, f); })) {
    check.detail = fmt::format("{} and {} are the same Voronoi face", result.describe_face((*twice)[0]),
                               result.describe_face((*twice)[1]));
    return check;
  }
  check.passed = true;
  check.detail =
      fmt::format("{} of {} vertices, {} of {} edges, {} of {} polygons have their nearest boundary vertices{}",
                  vertices.size(), result.rows.size(), edges.size(), complex.edges.size(), faces.size(),
                  complex.face_count(), result.face_sites.empty() ? " (no site_a, site_b to compare)" : "");
  return check;
}

}  // namespace quench::verification
