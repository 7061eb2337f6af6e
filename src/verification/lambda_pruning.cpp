// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "verification/checks.h"

namespace quench::verification {

namespace {

constexpr double lambda_tolerance = 1e-6;

// Lambda of cells of a result; their vertices' sites must be prepared. 0 where a cell is not of the Voronoi diagram
// (that is reported by check_voronoi).
struct Values {
  const Result& result;
  const Sites& sites;
  const VertexSites& vertex_sites;
  LambdaOfSites of;

  Values(const Result& r, const Sites& s, const VertexSites& v)
      : result(r), sites(s), vertex_sites(v), of(r.shape, s, r.unit, r.ball_rule) {}

  double vertex(std::uint32_t v) const {
    const Ids& set = vertex_sites.at(v);
    if (result.plane) return set.empty() ? 0 : of.edge(convex_cycle(sites, set));
    const std::vector<Ids> facets = hull_facets(sites, set);
    return facets.empty() ? 0 : of.vertex(set, facets);
  }
  double edge(std::uint32_t e) const {
    const Ids set = edge_sites(result, vertex_sites, e);
    if (result.plane) return set.size() != 2 ? 0 : of.face(set[0], set[1]);
    return set.size() < 3 ? 0 : of.edge(convex_cycle(sites, set));
  }
  double face(std::size_t f) const {
    const Ids set = face_sites(result, vertex_sites, f);
    return set.size() != 2 ? 0 : of.face(set[0], set[1]);
  }
};

bool equal(const Result& result, double written, double expected) {
  return std::abs(written - expected) <= (lambda_tolerance + result.slack) * expected;
}

std::string legality(const Result& result, const Values& values, VertexSites& vertex_sites, Context* context) {
  const CellComplex& complex = result.complex;
  const double below = result.lambda * (1 - 1e-9 - result.slack);
  std::vector<std::uint32_t> free_edge_faces, free_edges, free_lines, free_vertices, needed;
  for (std::uint32_t f = 0; f < complex.face_count(); ++f)
    for (std::uint32_t e : complex.sides(f))
      if (result.edge_faces_count[e] == 1) {
        free_edge_faces.push_back(f);
        free_edges.push_back(e);
      }
  for (std::uint32_t v = 0; v < result.rows.size(); ++v) {
    if (result.vertex_edges[v].size() != 1) continue;
    const std::uint32_t e = result.vertex_edges[v][0];
    if (result.edge_faces_count[e] != 0) continue;
    free_vertices.push_back(v);
    free_lines.push_back(e);
  }
  for (std::uint32_t f : free_edge_faces)
    needed.insert(needed.end(), complex.corners(f).begin(), complex.corners(f).end());
  for (std::uint32_t e : free_lines) needed.insert(needed.end(), complex.edges[e].begin(), complex.edges[e].end());
  vertex_sites.prepare(needed, context);

  const std::size_t face = first_failure(free_edges.size(), context, "verify: pruning", [&](std::size_t i) {
    return !(values.face(free_edge_faces[i]) < below && values.edge(free_edges[i]) < below);
  });
  if (face != free_edges.size())
    return fmt::format(
        "{} (lambda {:.9g}) could still be pruned with its free {} (lambda {:.9g}): both are below {:.9g}",
        result.describe_face(free_edge_faces[face]), values.face(free_edge_faces[face]),
        result.describe_edge(free_edges[face]), values.edge(free_edges[face]), result.lambda);
  const std::size_t line = first_failure(free_lines.size(), context, "verify: pruning", [&](std::size_t i) {
    return !(values.edge(free_lines[i]) < below && values.vertex(free_vertices[i]) < below);
  });
  if (line != free_lines.size())
    return fmt::format(
        "{} (lambda {:.9g}) could still be pruned with its free {} (lambda {:.9g}): both are below {:.9g}",
        result.describe_edge(free_lines[line]), values.edge(free_lines[line]),
        result.describe_vertex(free_vertices[line]), values.vertex(free_vertices[line]), result.lambda);
  return {};
}

std::string completeness(const Result& result, const Values& values, VertexSites& vertex_sites,
                         const std::vector<std::uint32_t>& vertices, Context* context) {
  const CellComplex& complex = result.complex;
  // Rounding of lengths only: a cell of exactly lambda must be there.
  const double least = result.lambda * (1 + (result.slack > 1e-13 ? result.slack : -5e-13));
  std::vector<std::uint32_t> needed = vertices;
  for (std::uint32_t v : vertices) {
    for (std::uint32_t e : result.vertex_edges[v])
      needed.insert(needed.end(), complex.edges[e].begin(), complex.edges[e].end());
    for (std::uint32_t f : result.vertex_faces[v])
      needed.insert(needed.end(), complex.corners(f).begin(), complex.corners(f).end());
  }
  vertex_sites.prepare(needed, context);

  const auto missing_in_plane = [&](std::uint32_t v) -> std::string {
    const std::vector<Ids> edges = sites_of_edges_at(result, vertex_sites, v);
    for (const Ids& side : sides_of_polygon(values.sites, vertex_sites.at(v)))
      if (const double lambda = values.of.face(side[0], side[1]);
          lambda >= least && !values.of.is_boundary_edge(side[0], side[1]) &&
          std::find(edges.begin(), edges.end(), side) == edges.end())
        return fmt::format("a core edge of lambda {:.9g} at {} is missing", lambda, result.describe_vertex(v));
    return {};
  };
  const auto missing = [&](std::uint32_t v) -> std::string {
    if (result.plane) return missing_in_plane(v);
    const std::vector<Ids> facets = hull_facets(values.sites, vertex_sites.at(v));
    const std::vector<Ids> edges = sites_of_edges_at(result, vertex_sites, v);
    std::vector<Ids> faces;
    for (std::uint32_t f : result.vertex_faces[v]) faces.push_back(face_sites(result, vertex_sites, f));
    for (const Ids& facet : facets) {
      if (!values.of.is_boundary_square(facet) && values.of.edge(facet) >= least) {
        Ids set = facet;
        std::sort(set.begin(), set.end());
        if (std::find(edges.begin(), edges.end(), set) == edges.end())
          return fmt::format("a core edge of lambda {:.9g} at {} is missing", values.of.edge(facet),
                             result.describe_vertex(v));
      }
      for (std::size_t i = 0; i < facet.size(); ++i) {
        const std::uint32_t a = facet[i], b = facet[(i + 1) % facet.size()];
        if (a > b || values.of.is_boundary_edge(a, b) || values.of.face(a, b) < least) continue;
        if (std::find(faces.begin(), faces.end(), Ids{a, b}) == faces.end())
          return fmt::format("a core polygon of lambda {:.9g} at {} is missing", values.of.face(a, b),
                             result.describe_vertex(v));
      }
    }
    return {};
  };
  const std::size_t bad = first_failure(vertices.size(), context, "verify: pruning",
                                        [&](std::size_t i) { return missing(vertices[i]).empty(); });
  return bad == vertices.size() ? std::string{} : missing(vertices[bad]);
}

}  // namespace

Check check_lambda(const Result& result, const Sites& sites, VertexSites& vertex_sites, std::size_t samples,
                   Context* context) {
  Check check{"lambda", false, {}, {}};
  if (result.vertex_lambda.empty() && result.cell_lambda.empty()) return not_checked(check.name, "no array 'lambda'");
  const CellComplex& complex = result.complex;
  std::vector<std::uint32_t> vertices, lines, faces, needed;
  if (!result.vertex_lambda.empty()) vertices = sample(result.rows.size(), samples);
  if (!result.cell_lambda.empty()) {
    lines = sample(result.line_edges.size(), samples);
    faces = sample(complex.face_count(), samples);
    // Vertex cells are few, but can be many in a shape of loose voxels.
    for (std::uint32_t i : sample(result.vert_vertices.size(), samples)) needed.push_back(result.vert_vertices[i]);
  }
  needed.insert(needed.end(), vertices.begin(), vertices.end());
  for (std::uint32_t l : lines)
    for (std::uint32_t v : complex.edges[result.line_edges[l]]) needed.push_back(v);
  for (std::uint32_t f : faces) needed.insert(needed.end(), complex.corners(f).begin(), complex.corners(f).end());
  vertex_sites.prepare(needed, context);

  const Values values(result, sites, vertex_sites);
  const auto compare = [&](const std::vector<std::uint32_t>& cells, const auto& written, const auto& expected,
                           const auto& describe) {
    const std::size_t bad = first_failure(cells.size(), context, "verify: lambda", [&](std::size_t i) {
      return equal(result, written(cells[i]), expected(cells[i]));
    });
    if (bad == cells.size()) return true;
    check.detail = fmt::format("{} has lambda {:.9g}, its sites give {:.9g}", describe(cells[bad]), written(cells[bad]),
                               expected(cells[bad]));
    return false;
  };
  const std::size_t line_row = result.data.verts.size(), face_row = line_row + result.data.lines.size();
  const std::vector<std::uint32_t> verts =
      result.cell_lambda.empty() ? std::vector<std::uint32_t>{} : sample(result.vert_vertices.size(), samples);
  check.passed =
      compare(
          faces, [&](std::uint32_t f) { return result.cell_lambda[face_row + f]; },
          [&](std::uint32_t f) { return values.face(f); }, [&](std::uint32_t f) { return result.describe_face(f); }) &&
      compare(
          lines, [&](std::uint32_t l) { return result.cell_lambda[line_row + l]; },
          [&](std::uint32_t l) { return values.edge(result.line_edges[l]); },
          [&](std::uint32_t l) { return result.describe_edge(result.line_edges[l]); }) &&
      compare(
          verts, [&](std::uint32_t i) { return result.cell_lambda[i]; },
          [&](std::uint32_t i) { return values.vertex(result.vert_vertices[i]); },
          [&](std::uint32_t i) { return "the vertex cell of " + result.describe_vertex(result.vert_vertices[i]); }) &&
      compare(
          vertices, [&](std::uint32_t v) { return result.vertex_lambda[v]; },
          [&](std::uint32_t v) { return values.vertex(v); },
          [&](std::uint32_t v) { return result.describe_vertex(v); });
  if (!check.passed) return check;
  check.detail = fmt::format("{} of {} vertices, {} of {} lines", vertices.size(), result.rows.size(), lines.size(),
                             result.line_edges.size());
  if (!result.plane) check.detail += fmt::format(", {} of {} polygons", faces.size(), complex.face_count());
  check.detail += fmt::format(" as their sites give them, rule {}", result.ball_rule ? "ball" : "coface");
  if (!result.vertex_lambda.empty()) cover(check, "point lambda");
  if (!result.cell_lambda.empty()) cover(check, "cell lambda");
  cover(check, "field lambda_rule");
  return check;
}

std::vector<std::uint32_t> vertices_to_complete(const Result& result, std::size_t samples) {
  const CellComplex& complex = result.complex;
  std::vector<std::uint32_t> faces(complex.edges.size(), 0);
  for (std::uint32_t e : complex.face_edges) ++faces[e];
  std::vector<char> chosen(complex.vertex_count, 0);
  for (std::size_t e = 0; e < faces.size(); ++e)
    if (faces[e] < 2)
      for (std::uint32_t v : complex.edges[e]) chosen[v] = 1;
  for (std::uint32_t v : sample(result.rows.size(), samples)) chosen[v] = 1;
  std::vector<std::uint32_t> vertices;
  for (std::uint32_t v = 0; v < chosen.size(); ++v)
    if (chosen[v]) vertices.push_back(v);
  return vertices;
}

Check check_pruning(const Result& result, const Sites& sites, VertexSites& vertex_sites, std::size_t samples,
                    Context* context) {
  Check check{"legal pruning", false, {}, {}};
  if (!(result.lambda >= 0)) {
    check.detail = fmt::format("lambda {} is not a pruning radius", result.lambda);
    return check;
  }
  const Values values(result, sites, vertex_sites);
  check.detail = legality(result, values, vertex_sites, context);
  if (!check.detail.empty()) return check;
  const std::vector<std::uint32_t> vertices = vertices_to_complete(result, samples);
  check.detail = completeness(result, values, vertex_sites, vertices, context);
  if (!check.detail.empty()) return check;
  check.passed = true;
  if (result.lambda_of_file) cover(check, "field lambda");
  check.detail = fmt::format(
      "lambda {:.9g}{}: no simple pair below it is left, all core cells of at least lambda at {} of {} vertices are "
      "there",
      result.lambda, result.lambda_given ? "" : " (the file has no FieldData 'lambda')", vertices.size(),
      result.rows.size());
  return check;
}

}  // namespace quench::verification
