// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <set>
#include <tuple>
#include <vector>

#include "quench/parts.h"

/// What is known of parts and meshes of sheets, found by walking.
namespace quench::testing_parts {

inline CellComplex complex_of(const SheetMesh& mesh) {
  std::vector<std::uint32_t> offsets{0}, corners;
  for (const auto& t : mesh.triangles) {
    corners.insert(corners.end(), t.begin(), t.end());
    offsets.push_back(static_cast<std::uint32_t>(corners.size()));
  }
  return make_complex(static_cast<std::uint32_t>(mesh.points.size()), {}, std::move(offsets), std::move(corners));
}

inline double area_of(const SheetMesh& mesh, std::size_t t) {
  const auto& [a, b, c] = mesh.triangles[t];
  return 0.5 * (mesh.points[b] - mesh.points[a]).cross(mesh.points[c] - mesh.points[a]).norm();
}

/// Every edge of a mesh of triangles with the triangles at it.
using Edges = std::map<std::array<std::uint32_t, 2>, std::vector<std::uint32_t>>;
inline Edges edges_of(const std::vector<std::array<std::uint32_t, 3>>& triangles) {
  Edges edges;
  for (std::uint32_t t = 0; t < triangles.size(); ++t)
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [a, b] = std::minmax(triangles[t][i], triangles[t][(i + 1) % 3]);
      edges[{a, b}].push_back(t);
    }
  return edges;
}

/// Euler characteristic, borders and whether it is orientable, of a sheet in a file; expects a manifold.
struct SheetShape {
  std::int64_t euler = 0;
  std::uint32_t borders = 0;
  bool orientable = true;  ///< as its triangles are turned
  friend auto operator<=>(const SheetShape&, const SheetShape&) = default;
};
inline SheetShape shape_of(const Record& sheet) {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  for (std::size_t f = 0; f < sheet.poly_count(); ++f) {
    EXPECT_EQ(sheet.poly_offsets[f + 1] - sheet.poly_offsets[f], 3u);
    const std::uint32_t* c = sheet.poly_corners.data() + sheet.poly_offsets[f];
    triangles.push_back({c[0], c[1], c[2]});
  }
  const Edges edges = edges_of(triangles);
  SheetShape shape;
  shape.euler = static_cast<std::int64_t>(sheet.points.size()) - static_cast<std::int64_t>(edges.size()) +
                static_cast<std::int64_t>(triangles.size());
  std::map<std::uint32_t, std::vector<std::uint32_t>> along;  // neighbours along borders
  std::vector<std::vector<std::array<std::uint32_t, 2>>> link(sheet.points.size());
  for (const auto& t : triangles)
    for (std::size_t i = 0; i < 3; ++i) link[t[i]].push_back({t[(i + 1) % 3], t[(i + 2) % 3]});
  for (const auto& [ends, at] : edges) {
    EXPECT_LE(at.size(), 2u) << "an edge of more than two triangles";
    if (at.size() == 1) {
      along[ends[0]].push_back(ends[1]);
      along[ends[1]].push_back(ends[0]);
      continue;
    }
    int up = 0;
    for (const std::uint32_t t : at)
      for (std::size_t i = 0; i < 3; ++i) up += triangles[t][i] == ends[0] && triangles[t][(i + 1) % 3] == ends[1];
    if (up != 1) shape.orientable = false;
  }
  // The link of each vertex is one path or one cycle.
  for (std::size_t v = 0; v < link.size(); ++v) {
    EXPECT_FALSE(link[v].empty()) << "a point without triangle";
    std::map<std::uint32_t, std::vector<std::uint32_t>> next;
    for (const auto& [a, b] : link[v]) next[a].push_back(b), next[b].push_back(a);
    std::set<std::uint32_t> seen;
    std::vector<std::uint32_t> stack{link[v].empty() ? 0 : link[v][0][0]};
    while (!stack.empty()) {
      const std::uint32_t at = stack.back();
      stack.pop_back();
      if (!seen.insert(at).second) continue;
      for (const std::uint32_t to : next[at]) stack.push_back(to);
    }
    EXPECT_EQ(seen.size(), next.size()) << "a vertex that joins two parts of a sheet";
  }
  std::set<std::uint32_t> seen;
  for (const auto& [start, ignored] : along) {
    if (seen.contains(start)) continue;
    ++shape.borders;
    for (std::vector<std::uint32_t> stack{start}; !stack.empty();) {
      const std::uint32_t at = stack.back();
      stack.pop_back();
      if (!seen.insert(at).second) continue;
      EXPECT_EQ(along[at].size(), 2u);
      for (const std::uint32_t to : along[at]) stack.push_back(to);
    }
  }
  return shape;
}

/// All that a mesh of sheets is by its topology: of each sheet its shape and how its seams are, of each seam its ends
/// and sheets. Numbers of sheets and seams are those of the mesh.
struct MeshFacts {
  std::vector<SheetShape> sheets;
  std::map<std::int32_t, std::vector<std::int32_t>> sheets_of_seam;
  std::map<std::int32_t, bool> closed;
  std::size_t junctions = 0;
  Topology whole;
  friend bool operator==(const MeshFacts&, const MeshFacts&) = default;
};
inline MeshFacts facts_of(const SheetMesh& mesh) {
  MeshFacts facts;
  for (const Record& sheet : sheet_records(mesh)) facts.sheets.push_back(shape_of(sheet));
  const CellComplex complex = complex_of(mesh);
  facts.whole = topology(complex);
  const Structure structure = structure_of(complex);
  facts.junctions = static_cast<std::size_t>(std::count(structure.junction.begin(), structure.junction.end(), 1));
  // The seams of the mesh are its edges of three triangles or more, and each is one seam of the structure.
  const Edges edges = edges_of(mesh.triangles);
  std::map<std::array<std::uint32_t, 2>, std::int32_t> named;
  for (std::size_t e = 0; e < mesh.seam_edges.size(); ++e) {
    const auto [a, b] = std::minmax(mesh.seam_edges[e][0], mesh.seam_edges[e][1]);
    EXPECT_TRUE((named.emplace(std::array{a, b}, mesh.seam[e]).second)) << "a seam edge twice";
  }
  std::map<std::int32_t, std::int32_t> seam_of;
  std::size_t seams = 0;
  for (std::size_t e = 0; e < complex.edges.size(); ++e) {
    const auto found = named.find(complex.edges[e]);
    const std::vector<std::uint32_t>& at = edges.at(complex.edges[e]);
    EXPECT_EQ(found != named.end(), at.size() > 2);
    if (found == named.end() || at.size() <= 2) continue;
    ++seams;
    const std::int32_t own = structure.edge_seam[e];
    const auto [it, added] = seam_of.emplace(own, found->second);
    EXPECT_EQ(it->second, found->second) << "a seam with two names";
    std::vector<std::int32_t> sheets;
    for (const std::uint32_t t : at) sheets.push_back(mesh.sheet[t]);
    std::ranges::sort(sheets);
    std::vector<std::int32_t>&known = facts.sheets_of_seam[found->second], both;
    std::ranges::set_union(known, sheets, std::back_inserter(both));
    known = both;
    bool& closed = facts.closed.emplace(found->second, true).first->second;
    for (const std::uint32_t v : complex.edges[e])
      if (structure.junction[v]) closed = false;
  }
  EXPECT_EQ(seams, named.size());
  return facts;
}

/// Squared distance of a point to a triangle, by trying its inside, sides and corners.
inline double squared_distance(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  double least = std::min({(p - a).squaredNorm(), (p - b).squaredNorm(), (p - c).squaredNorm()});
  for (const auto& [u, v] : {std::pair{a, b}, {b, c}, {c, a}}) {
    const double length = (v - u).squaredNorm();
    if (!(length > 0)) continue;
    const double t = (p - u).dot(v - u) / length;
    if (t > 0 && t < 1) least = std::min(least, (p - u - t * (v - u)).squaredNorm());
  }
  const Vec3 n = (b - a).cross(c - a);
  if (!(n.squaredNorm() > 0)) return least;
  const Vec3 foot = p - n.dot(p - a) / n.squaredNorm() * n;
  if ((b - a).cross(foot - a).dot(n) >= 0 && (c - b).cross(foot - b).dot(n) >= 0 && (a - c).cross(foot - c).dot(n) >= 0)
    least = std::min(least, (p - foot).squaredNorm());
  return least;
}

}  // namespace quench::testing_parts
