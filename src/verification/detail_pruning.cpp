// SPDX-License-Identifier: Apache-2.0
// What a pruning by detail must have kept, as far as one vertex shows it. With h, v0, a and t as in details.cpp, a cell
// is kept when v0 >= t, and its h is at least that by its lambda and the radius of the vertex. So it must be there
// - where h >= sqrt(3) t: v0 is h, or at least h / sqrt(3), as it is part of the component that it is the peak of;
// - where h >= t and t <= a / sqrt(3): v0 is h, or at least a / sqrt(3);
// - where h >= max(t, a) and a top cell g at the vertex has a detail v >= t above a: v is the v0 of g, so the component
//   of { h >= max(t, a) } that g is in, and with it the cell, has a peak of at least sqrt(3) v >= sqrt(3) max(t, a).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "verification/checks.h"

namespace quench::verification {

namespace {

constexpr double kSurely = 1 + 1e-8;  // as cap heights count that are lowered below ties

class KeptByDetail {
 public:
  KeptByDetail(const Result& result, const Sites& sites, const VertexSites& vertex_sites)
      : result_(result),
        sites_(sites),
        vertex_sites_(vertex_sites),
        of_(result.shape, sites, result.unit, result.ball_rule),
        detail_(numbers_or_empty(result.data.cell_data, kDetail)) {
    const double peak = std::sqrt(3.0), t = result.detail, a = result.auto_detail;
    always_ = peak * t <= a ? t : peak * t;
    beside_ = std::max(t, a);
    if (detail_.empty()) return;
    edge_detail_.assign(result.complex.edges.size(), 0);
    for (std::size_t l = 0; l < result.line_edges.size(); ++l)
      if (result.edge_faces_count[result.line_edges[l]] == 0)
        edge_detail_[result.line_edges[l]] = detail_[result.vert_vertices.size() + l];
  }

  /// A cell at the vertex that is missing, else empty.
  std::string missing(std::uint32_t v) const {
    const Ids& set = vertex_sites_.at(v);
    if (result_.plane) return set.empty() ? std::string{} : missing_in_plane(v);
    const std::vector<Ids> facets = hull_facets(sites_, set);
    if (facets.empty()) return {};  // no Voronoi vertex: another check says so
    const double radius = result_.unit * (result_.scaled[v] - scaled(set[0])).norm();
    const double least = least_height(v);
    const std::vector<Ids> edges = sites_of_edges_at(result_, vertex_sites_, v);
    std::vector<Ids> faces;
    for (const std::uint32_t f : result_.vertex_faces[v]) faces.push_back(face_sites(result_, vertex_sites_, f));
    for (const Ids& facet : facets) {
      for (std::size_t i = 0; i < facet.size(); ++i) {
        const std::uint32_t a = facet[i], b = facet[(i + 1) % facet.size()];
        if (a > b || of_.is_boundary_edge(a, b)) continue;
        const double height = least_height_of(of_.face(a, b), radius);
        if (height >= least && std::find(faces.begin(), faces.end(), Ids{a, b}) == faces.end())
          return sentence("polygon", height, v);
      }
      if (of_.is_boundary_square(facet) || !of_.has_only_boundary_edges(facet)) continue;
      Ids sorted = facet;
      std::sort(sorted.begin(), sorted.end());
      const double height = least_height_of(of_.edge(facet), radius);
      if (height >= least && std::find(edges.begin(), edges.end(), sorted) == edges.end())
        return sentence("edge", height, v);
    }
    return {};
  }

 private:
  std::string missing_in_plane(std::uint32_t v) const {
    const Ids& set = vertex_sites_.at(v);
    const double radius = result_.unit * (result_.scaled[v] - scaled(set[0])).norm(), least = least_height(v);
    const std::vector<Ids> edges = sites_of_edges_at(result_, vertex_sites_, v);
    for (const Ids& side : sides_of_polygon(sites_, set)) {
      if (of_.is_boundary_edge(side[0], side[1])) continue;
      const double height = least_height_of(of_.face(side[0], side[1]), radius);
      if (height >= least && std::find(edges.begin(), edges.end(), side) == edges.end())
        return sentence("edge", height, v);
    }
    return {};
  }
  Vec3 scaled(std::uint32_t site) const {
    const Point& p = sites_.scaled()[site];
    return {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
  }
  // The cap height from which on a cell at the vertex must be there.
  double least_height(std::uint32_t v) const {
    double largest = 0;
    if (!detail_.empty()) {
      for (const std::uint32_t f : result_.vertex_faces[v])
        largest = std::max(largest, detail_[result_.first_polygon() + f]);
      for (const std::uint32_t e : result_.vertex_edges[v]) largest = std::max(largest, edge_detail_[e]);
    }
    const bool is_significant = largest > result_.auto_detail * kSurely && largest >= result_.detail;
    return kSurely * (is_significant ? std::min(beside_, always_) : always_);
  }
  double least_height_of(double lambda, double radius) const {
    const double off = radius * (1e-12 + result_.slack) + 4 * result_.rounding * result_.unit;
    return cap_height(lambda, radius + off) * (1 - 2 * result_.slack);
  }
  std::string sentence(const char* what, double height, std::uint32_t v) const {
    return fmt::format("a core {} of cap height {:.9g} or more at {} is missing", what, height,
                       result_.describe_vertex(v));
  }

  const Result& result_;
  const Sites& sites_;
  const VertexSites& vertex_sites_;
  LambdaOfSites of_;
  std::vector<double> detail_, edge_detail_;  // per cell of the file; per edge, of those without polygons
  double always_ = 0, beside_ = 0;            // least cap heights: anywhere, and beside what is significant
};

}  // namespace

Check check_detail_pruning(const Result& result, const Sites& sites, VertexSites& vertex_sites, std::size_t samples,
                           Context* context) {
  Check check{"legal pruning", false, {}, {}};
  if (!(result.detail >= 0)) {
    check.detail = fmt::format("detail {} is not a length", result.detail);
    return check;
  }
  if (result.fitted) return not_checked(check.name, kBorneOutBySurface);
  const CellComplex& complex = result.complex;
  const std::vector<std::uint32_t> vertices = vertices_to_complete(result, samples);
  std::vector<std::uint32_t> needed = vertices;
  for (const std::uint32_t v : vertices) {
    for (const std::uint32_t e : result.vertex_edges[v])
      needed.insert(needed.end(), complex.edges[e].begin(), complex.edges[e].end());
    for (const std::uint32_t f : result.vertex_faces[v])
      needed.insert(needed.end(), complex.corners(f).begin(), complex.corners(f).end());
  }
  vertex_sites.prepare(needed, context);
  const KeptByDetail kept(result, sites, vertex_sites);
  const std::size_t bad = first_failure(vertices.size(), context, "verify: pruning",
                                        [&](std::size_t i) { return kept.missing(vertices[i]).empty(); });
  if (bad != vertices.size()) {
    check.detail = kept.missing(vertices[bad]);
    return check;
  }
  check.passed = true;
  if (result.detail_of_file) cover(check, "field detail");
  check.detail =
      fmt::format("detail {:.9g}: all core cells at {} of {} vertices are there that are certain to be significant",
                  result.detail, vertices.size(), result.rows.size());
  return check;
}

}  // namespace quench::verification
