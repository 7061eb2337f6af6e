// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "quench/context.h"
#include "verification/bvh.h"
#include "verification/result.h"

namespace quench::verification {

__extension__ typedef __int128 Wide;
using Ids = std::vector<std::uint32_t>;     ///< of sites; ascending unless they are documented to be a cycle
using Point = std::array<std::int64_t, 3>;  ///< scaled lattice coordinates; below 2^20 (integer_spacing)

/// The boundary vertices of the shape with a tree over them.
class Sites {
 public:
  explicit Sites(const VoxelShape& shape);

  const std::vector<LatticePoint>& lattice() const { return lattice_; }
  const std::vector<Point>& scaled() const { return scaled_; }
  const Bvh& tree() const { return tree_; }
  bool plane() const { return plane_; }

 private:
  std::vector<LatticePoint> lattice_;  // in order of z, y, x
  std::vector<Point> scaled_;
  Bvh tree_;
  bool plane_;
};

/// Sphere through four sites, exact: with s = p - origin, determinant |s|^2 - linear . s is negative inside. The centre
/// is origin + linear / (2 determinant); determinant > 0. |values| < 64 * 2^100 for coordinates below 2^20.
struct Sphere {
  Point origin{};
  Wide determinant = 0;  ///< 0: the four sites are coplanar
  std::array<Wide, 3> linear{};

  Sphere() = default;
  Sphere(const Point& a, const Point& b, const Point& c, const Point& d);
  Wide side(const Point& p) const;
  Vec3 centre() const;
};

/// All sites on the empty sphere whose centre is x, to 1e-7 of its radius and `rounding`: the Voronoi vertex x. Empty
/// when there is no such sphere (x is not a Voronoi vertex). Candidates are found in floating point, decided in
/// integers.
Ids voronoi_vertex(const Sites& sites, const Vec3& scaled, double rounding);
/// The same in the plane, with a circle through three sites.
Ids voronoi_vertex_of_plane(const Sites& sites, const Vec3& scaled, double rounding);

/// Site sets of the vertices of a result, computed on demand.
class VertexSites {
 public:
  VertexSites(const Result& result, const Sites& sites)
      : result_(result), sites_(sites), sets_(result.rows.size()), known_(result.rows.size(), 0) {}

  void prepare(const std::vector<std::uint32_t>& vertices, Context* context);
  /// The sites of a prepared vertex; empty when it is not a Voronoi vertex.
  const Ids& at(std::uint32_t vertex) const { return sets_[vertex]; }

 private:
  const Result& result_;
  const Sites& sites_;
  std::vector<Ids> sets_;
  std::vector<char> known_;
};

/// Radius of every vertex (sampled above 2 million) against the nearest boundary vertex.
Check check_radii(const Result& result, const Sites& sites, Context* context);

/// Vertices, edges and polygons are Voronoi vertices, whole Voronoi edges and whole Voronoi faces, each once.
Check check_voronoi(const Result& result, const Sites& sites, VertexSites& vertex_sites, std::size_t samples,
                    Context* context);
/// The same in the plane: vertices and edges, all of them, and the two sites that the file names for each edge.
Check check_voronoi_of_plane(const Result& result, const Sites& sites, VertexSites& vertex_sites, Context* context);

/// The common sites of an edge's ends. On an edge between two Voronoi vertices this is the set of nearest sites of all
/// its inner points: |x-t|^2 - |x-s|^2 is affine in x and not negative at both ends. In the plane these are two.
Ids edge_sites(const Result& result, const VertexSites& vertex_sites, std::uint32_t edge);
/// The same of all edges at a vertex.
std::vector<Ids> sites_of_edges_at(const Result& result, const VertexSites& vertex_sites, std::uint32_t vertex);
/// The common sites of a polygon's corners.
Ids face_sites(const Result& result, const VertexSites& vertex_sites, std::size_t face);

}  // namespace quench::verification
