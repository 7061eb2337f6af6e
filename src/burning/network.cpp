// SPDX-License-Identifier: Apache-2.0
#include "burning/network.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "base/parallel.h"
#include "base/union_find.h"
#include "complex/pockets.h"
#include "quench/error.h"

namespace quench::burning {
namespace {

// Calls body(first, last) for parts of [0, count) on all threads.
template <class Body>
void for_all(std::size_t count, const Body& body) {
  const std::size_t chunks = base::chunks_for(count, std::size_t{1} << 14);
  base::for_chunks(chunks, nullptr, {}, 0, 0, [&](std::size_t chunk) {
    const auto [first, last] = base::part_of(count, chunk, chunks);
    body(static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(last));
  });
}

void list_corners(const CellComplex& complex, BurnNetwork& network) {
  const std::size_t corners = complex.face_vertices.size(), edges = complex.edges.size();
  network.corner_face.resize(corners);
  for (std::uint32_t f = 0; f < complex.face_count(); ++f)
    std::fill(network.corner_face.begin() + complex.face_offsets[f],
              network.corner_face.begin() + complex.face_offsets[f + 1], f);
  network.edge_corners = base::Csr<std::uint32_t>::group(edges, [&](const auto& emit) {
    for (std::uint32_t c = 0; c < corners; ++c) emit(complex.face_edges[c], c);
  });
  network.corner_rank.resize(corners);
  for (std::uint32_t e = 0; e < edges; ++e)
    for (std::uint32_t i = 0; i < network.degree(e); ++i) network.corner_rank[network.face_corners_at(e)[i]] = i;
}

// Edges at the vertices of seams get at least two pieces: near a seam the times of the sheets differ.
void split_edges(const CellComplex& complex, BurnNetwork& network) {
  const std::size_t edges = complex.edges.size();
  std::vector<char> at_seam(complex.vertex_count, 0);
  for (std::uint32_t e = 0; e < edges; ++e)
    if (network.degree(e) > 2)
      for (const std::uint32_t v : complex.edges[e]) at_seam[v] = 1;
  network.pieces.resize(edges);
  network.node_base.resize(edges + 1);
  network.state_base.resize(edges + 1);
  std::uint64_t nodes = complex.vertex_count, states = network.vertex_base.back();
  for (std::uint32_t e = 0; e < edges; ++e) {
    network.node_base[e] = static_cast<std::uint32_t>(nodes);
    network.state_base[e] = static_cast<std::uint32_t>(states);
    double pieces = 1;
    if (network.degree(e) > 0 && network.length[e] > 0) {
      pieces = std::max(1.0, std::ceil(network.length[e] / network.omega * (1 - 1e-12)));
      if (pieces < 2 && (at_seam[complex.edges[e][0]] || at_seam[complex.edges[e][1]])) pieces = 2;
    }
    const double more = pieces - 1;
    if (!(static_cast<double>(states) + more * std::max(1u, network.sectors_of(e)) < 4294967295.0) ||
        !(pieces < 2147483647.0) || !(static_cast<double>(nodes) + more < 4294967295.0))
      throw Error(ErrorCode::failed, fmt::format("burning with a spacing of {:.6g} needs more than 2^32 nodes; use a "
                                                 "larger omega",
                                                 network.omega));
    network.pieces[e] = static_cast<std::uint32_t>(pieces);
    nodes += network.pieces[e] - 1;
    states += std::uint64_t{network.pieces[e] - 1} * network.sectors_of(e);
  }
  network.node_base[edges] = static_cast<std::uint32_t>(nodes);
  network.state_base[edges] = static_cast<std::uint32_t>(states);
}

// Projects a polygon on the plane of its mean normal (Newell's); one without area on the line of its longest side.
// False unless it is flat and convex, with an area above rounding.
bool unfold(std::span<const std::uint32_t> corners, std::span<const Vec3> points,
            std::vector<std::array<double, 2>>& out) {
  const std::size_t n = corners.size();
  const Vec3 origin = points[corners[0]];
  Vec3 normal = Vec3::Zero(), u = Vec3::Zero();
  double size = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 a = points[corners[i]] - origin, b = points[corners[(i + 1) % n]] - origin;
    normal += a.cross(b);
    size = std::max(size, a.norm());
    if ((b - a).squaredNorm() > u.squaredNorm()) u = b - a;
  }
  out.assign(n, {0, 0});
  if (!(size > 0)) return false;
  const double area = normal.norm();
  const bool has_area = area > 1e-12 * size * size;
  if (has_area) {
    normal /= area;
    u -= normal * normal.dot(u);
  }
  u.normalize();
  const Vec3 v = has_area ? Vec3(normal.cross(u)) : Vec3(Vec3::Zero());
  bool flat = has_area;
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 p = points[corners[i]] - origin;
    if (has_area && std::abs(p.dot(normal)) > 1e-6 * size) flat = false;
    out[i] = {p.dot(u), p.dot(v)};
  }
  for (std::size_t i = 0; i < n; ++i) {
    const auto &a = out[i], &b = out[(i + 1) % n], &c = out[(i + 2) % n];
    const double turn = (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0]);
    if (turn < -1e-9 * size * size) flat = false;
  }
  return flat;
}

void place_sides(const CellComplex& complex, std::span<const Vec3> points, const BurnNetwork& network, std::uint32_t f,
                 std::vector<std::array<double, 2>>& plane, Polygons& polygons) {
  const auto corners = complex.corners(f);
  polygons.flat[f] = unfold(corners, points, plane);
  for (std::uint32_t i = 0; i < corners.size(); ++i) {
    const std::uint32_t c = complex.face_offsets[f] + i, e = complex.face_edges[c];
    const auto &from = plane[i], &to = plane[i + 1 == corners.size() ? 0 : i + 1];
    Polygons::Side& side = polygons.sides[c];
    side.x = from[0];
    side.y = from[1];
    side.pieces = network.pieces[e] & 0x7FFFFFFFu;
    side.dx = (to[0] - from[0]) / side.pieces;
    side.dy = (to[1] - from[1]) / side.pieces;
    side.length = network.length[e];
    side.edge = e;
    side.forward = complex.edges[e][0] == corners[i];
    side.corner_state = network.corner_state[c];
    side.state_base = network.state_base[e];
    side.sectors = network.sectors_of(e);
    side.rank = side.sectors > 1 ? network.corner_rank[c] : 0;
  }
}

// Finds the ends of the sectors of a vertex; `directions`: its singular edges, in the order in which they are found.
void find_ends(const CellComplex& complex, const BurnNetwork& network, std::uint32_t v,
               std::vector<std::uint32_t>& directions, Links& links) {
  directions.clear();
  for (std::uint32_t s = network.vertex_base[v]; s < network.vertex_base[v + 1]; ++s)
    for (const std::uint32_t c : std::as_const(links.corners)[s]) {
      const std::uint32_t f = network.corner_face[c];
      const std::uint32_t before = c == complex.face_offsets[f] ? complex.face_offsets[f + 1] - 1 : c - 1;
      for (const std::uint32_t e : {complex.face_edges[c], complex.face_edges[before]}) {
        if (network.degree(e) == 2) continue;
        std::uint32_t id = 0;
        if (!links.edges[e].pocket) {
          const auto found = std::find(directions.begin(), directions.end(), e);
          id = static_cast<std::uint32_t>(found - directions.begin()) + 1;
          if (found == directions.end()) directions.push_back(e);
        }
        auto& ends = links.ends[s];
        (ends.a == kNone ? ends.a : ends.b) = id;
      }
    }
}

// Numbers the sectors of every vertex: vertex_base, corner_state. Corners that meet in an edge of exactly two polygons
// are of one sector.
void number_sectors(const CellComplex& complex, BurnNetwork& network) {
  const std::size_t corners = complex.face_vertices.size();
  base::UnionFind same(corners);
  std::vector<std::uint32_t> next(corners);
  for (std::uint32_t f = 0; f < complex.face_count(); ++f)
    for (std::uint32_t c = complex.face_offsets[f]; c < complex.face_offsets[f + 1]; ++c)
      next[c] = c + 1 == complex.face_offsets[f + 1] ? complex.face_offsets[f] : c + 1;
  for (std::uint32_t e = 0; e < complex.edges.size(); ++e) {
    if (network.degree(e) != 2) continue;
    const std::uint32_t c = network.face_corners_at(e)[0], d = network.face_corners_at(e)[1];
    const bool aligned = complex.face_vertices[c] == complex.face_vertices[d];
    same.unite(c, aligned ? d : next[d]);
    same.unite(next[c], aligned ? next[d] : d);
  }
  // The root of a set is its smallest corner: the sectors of a vertex are numbered in the order of their first corners.
  network.vertex_base.assign(std::size_t{complex.vertex_count} + 1, 0);
  for (std::uint32_t c = 0; c < corners; ++c)
    if (same.find(c) == c) ++network.vertex_base[complex.face_vertices[c] + 1];
  std::partial_sum(network.vertex_base.begin(), network.vertex_base.end(), network.vertex_base.begin());
  network.corner_state.resize(corners);
  std::vector<std::uint32_t> filled(complex.vertex_count, 0);
  for (std::uint32_t c = 0; c < corners; ++c) {
    const std::uint32_t root = same.find(c), v = complex.face_vertices[c];
    network.corner_state[c] = root == c ? network.vertex_base[v] + filled[v]++ : network.corner_state[root];
  }
}

}  // namespace

std::vector<char> flat_faces(const CellComplex& complex, std::span<const Vec3> points) {
  std::vector<char> flat(complex.face_count());
  for_all(complex.face_count(), [&](std::uint32_t first, std::uint32_t last) {
    std::vector<std::array<double, 2>> plane;
    for (std::uint32_t f = first; f < last; ++f) flat[f] = unfold(complex.corners(f), points, plane);
  });
  return flat;
}

BurnNetwork make_network(const CellComplex& complex, std::span<const Vec3> points, double omega) {
  BurnNetwork network;
  network.omega = omega;
  network.length.resize(complex.edges.size());
  for_all(complex.edges.size(), [&](std::uint32_t first, std::uint32_t last) {
    for (std::uint32_t e = first; e < last; ++e)
      network.length[e] = (points[complex.edges[e][1]] - points[complex.edges[e][0]]).norm();
  });
  list_corners(complex, network);
  number_sectors(complex, network);
  network.pocket = complex::faces_in_pockets(complex);
  split_edges(complex, network);
  return network;
}

Polygons make_polygons(const CellComplex& complex, std::span<const Vec3> points, const BurnNetwork& network) {
  Polygons polygons;
  polygons.sides.resize(complex.face_vertices.size());
  polygons.flat.resize(complex.face_count());
  for_all(complex.face_count(), [&](std::uint32_t first, std::uint32_t last) {
    std::vector<std::array<double, 2>> plane;
    for (std::uint32_t f = first; f < last; ++f) place_sides(complex, points, network, f, plane, polygons);
  });
  return polygons;
}

Links make_links(const CellComplex& complex, const BurnNetwork& network) {
  Links links;
  const std::uint32_t states = network.vertex_base.back();
  links.vertex_of.resize(states);
  for (std::uint32_t v = 0; v < complex.vertex_count; ++v)
    for (std::uint32_t s = network.vertex_base[v]; s < network.vertex_base[v + 1]; ++s) links.vertex_of[s] = v;
  links.corners = base::Csr<std::uint32_t>::group(states, [&](const auto& emit) {
    for (std::uint32_t c = 0; c < network.corner_state.size(); ++c) emit(network.corner_state[c], c);
  });
  links.edge_of.resize(network.state_count() - states);
  links.edges.resize(complex.edges.size());
  for_all(complex.edges.size(), [&](std::uint32_t first, std::uint32_t last) {
    for (std::uint32_t e = first; e < last; ++e) {
      std::fill(links.edge_of.begin() + (network.state_base[e] - states),
                links.edge_of.begin() + (network.state_base[e + 1] - states), e);
      auto& edge = links.edges[e];
      edge = {};
      edge.state_base = network.state_base[e];
      edge.pieces = network.pieces[e];
      edge.first_corner = network.edge_corners.offsets()[e];
      edge.degree = network.degree(e) & 0x7FFFFFFFu;
      const auto corners = network.face_corners_at(e);
      for (std::size_t i = 0; i < corners.size(); ++i) {
        const std::uint32_t f = network.corner_face[corners[i]];
        if (i < 2) edge.corner[i] = corners[i];
        if (i < 2 && edge.degree <= 2) edge.face[i] = f;
        if (network.pocket[f]) edge.pocket = 1;
      }
    }
  });
  links.arrivals = states;
  for (std::uint32_t e = 0; e < complex.edges.size(); ++e)
    if (links.edges[e].degree > 2) {
      links.edges[e].first_arrival = links.arrivals;
      links.arrivals += network.state_base[e + 1] - network.state_base[e];
    }
  links.ends.assign(states, {kNone, kNone});
  for_all(complex.vertex_count, [&](std::uint32_t first, std::uint32_t last) {
    std::vector<std::uint32_t> directions;
    for (std::uint32_t v = first; v < last; ++v) find_ends(complex, network, v, directions, links);
  });
  return links;
}

}  // namespace quench::burning
