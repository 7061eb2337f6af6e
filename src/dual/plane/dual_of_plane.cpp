// SPDX-License-Identifier: Apache-2.0
#include "dual/plane/dual_of_plane.h"

#include <algorithm>
#include <vector>

#include "base/index.h"
#include "delaunay/plane_delaunay.h"
#include "shape/pixel_corners.h"

namespace quench::dual::plane {
namespace {

using delaunay::PlaneDelaunay;

/// Unit edges of the boundary of O are Delaunay edges: the disc around their middle holds no other lattice point, on
/// its rim neither. So polygons of the triangulation lie inside O or outside as a whole, and the pixel in which a
/// polygon begins, at any of its corners, says which.
class DualOfPlane {
 public:
  DualOfPlane(const VoxelShape& shape, std::span<const LatticePoint> sites, const std::array<std::int64_t, 3>& spacing,
              Context* context)
      : sites_(sites),
        in_circle_(spacing),
        corners_(shape::corners_of_sites(shape, sites)),
        delaunay_(sites, spacing, context),
        context_(context) {}

  DualComplex run() {
    join_cocircular();
    checkpoint(context_, "peel", 0.7);
    collect_vertices();
    checkpoint(context_, "peel", 0.9);
    collect_edges();
    return std::move(dual_);
  }

 private:
  // Whether the face on the left of e lies inside O: what is just counter-clockwise of e at its origin. The view of
  // plane_predicates.h has y to the right and x upwards.
  bool inside(std::uint32_t e) const {
    const std::uint32_t origin = delaunay_.origin(e);
    const LatticePoint &from = sites_[origin], &to = sites_[delaunay_.destination(e)];
    const std::int32_t dx = to[0] - from[0], dy = to[1] - from[1];
    return corners_[origin] >> shape::corner_of(dx > 0 || (dx == 0 && dy > 0), dy > 0 || (dy == 0 && dx < 0)) & 1;
  }

  // Removes edges between triangles of one circle inside O, and counts corners of polygons and edges.
  void join_cocircular() {
    corner_count_ = edge_count_ = 0;
    out_.assign(sites_.size(), kNone);
    for (std::uint32_t e = 0; e < delaunay_.half_edge_count(); e += 2) {
      if (delaunay_.origin(e) == kNone) continue;
      const bool left = inside(e), right = inside(e + 1);
      if (left && right) {
        const auto apex = [&](std::uint32_t h) -> const LatticePoint& {
          return sites_[delaunay_.destination(delaunay_.next_of_face(h))];
        };
        if (in_circle_(sites_[delaunay_.origin(e)], sites_[delaunay_.destination(e)], apex(e), apex(e + 1)) == 0) {
          delaunay_.remove(e);
          continue;
        }
        ++edge_count_;
      }
      corner_count_ += std::size_t{left} + std::size_t{right};
    }
    // Walks around sites and faces need `previous` only: `next` becomes the number of the polygon on the left.
    for (std::uint32_t e = 0; e < delaunay_.half_edge_count(); ++e) {
      delaunay_[e].next = kNone;
      if (delaunay_.origin(e) != kNone) out_[delaunay_.origin(e)] = e;
    }
  }

  // Polygons are found at the smallest of their sites, and numbered there in the order of the others.
  void collect_vertices() {
    base::check_index(corner_count_);
    dual_.vertex_sites.reserve(corner_count_);
    dual_.vertex_site_offsets.reserve(corner_count_ / 3 + 1);
    dual_.vertex_site_offsets.push_back(0);
    start_.reserve(corner_count_ / 3);
    struct Polygon {
      std::uint32_t begin, end, start;
    };
    std::vector<Polygon> polygons;
    std::vector<std::uint32_t> corners;
    for (std::uint32_t s = 0; s < sites_.size(); ++s) {
      corners.clear(), polygons.clear();
      std::uint32_t e = out_[s];
      do {
        if (delaunay_[e].next == kNone && inside(e)) {
          const auto begin = static_cast<std::uint32_t>(corners.size());
          for_sides(e, [&](std::uint32_t side) { corners.push_back(delaunay_.origin(side)); });
          std::sort(corners.begin() + begin, corners.end());
          polygons.push_back({begin, static_cast<std::uint32_t>(corners.size()), e});
        }
        e = delaunay_[e].previous;
      } while (e != out_[s]);
      // Two polygons share at most two sites, so the third decides at last.
      std::ranges::sort(polygons, {}, [&](const Polygon& p) {
        return std::array{corners[p.begin + 1], corners[p.begin + 2]};
      });
      for (const Polygon& p : polygons) {
        const auto number = static_cast<std::uint32_t>(start_.size());
        for_sides(p.start, [&](std::uint32_t side) { delaunay_[side].next = number; });
        dual_.vertex_sites.insert(dual_.vertex_sites.end(), corners.begin() + p.begin, corners.begin() + p.end);
        dual_.vertex_site_offsets.push_back(static_cast<std::uint32_t>(dual_.vertex_sites.size()));
        start_.push_back(p.start);
      }
    }
    dual_.complex.vertex_count = static_cast<std::uint32_t>(start_.size());
    out_ = {};
  }

  void collect_edges() {
    dual_.complex.edges.reserve(edge_count_);
    dual_.edge_sites.reserve(edge_count_);
    struct Edge {
      std::uint32_t other, half_edge;
    };
    std::vector<Edge> edges;
    for (std::uint32_t v = 0; v < start_.size(); ++v) {
      edges.clear();
      for_sides(start_[v], [&](std::uint32_t e) {
        const std::uint32_t other = delaunay_[e ^ 1].next;
        if (other != kNone && other > v) edges.push_back({other, e});
      });
      std::ranges::sort(edges, {}, &Edge::other);
      for (const Edge& edge : edges) {
        const std::uint32_t a = delaunay_.origin(edge.half_edge), b = delaunay_.destination(edge.half_edge);
        dual_.complex.edges.push_back({v, edge.other});
        dual_.edge_sites.push_back({std::min(a, b), std::max(a, b)});
      }
    }
  }

  // Half-edges around the face on the left of one.
  template <class Visit>
  void for_sides(std::uint32_t start, const Visit& visit) const {
    std::uint32_t e = start;
    do {
      visit(e);
      e = delaunay_.next_of_face(e);
    } while (e != start);
  }

  std::span<const LatticePoint> sites_;
  const delaunay::InCircle in_circle_;
  const std::vector<std::uint8_t> corners_;
  PlaneDelaunay delaunay_;
  Context* context_;
  std::size_t corner_count_ = 0, edge_count_ = 0;
  std::vector<std::uint32_t> out_;    // per site: a half-edge that starts there
  std::vector<std::uint32_t> start_;  // per vertex: a half-edge of its polygon
  DualComplex dual_;
};

}  // namespace

DualComplex dual_complex(const VoxelShape& shape, std::span<const LatticePoint> sites,
                         const std::array<std::int64_t, 3>& spacing, Context* context) {
  checkpoint(context, "peel", 0);
  DualComplex dual = DualOfPlane(shape, sites, spacing, context).run();
  checkpoint(context, "peel", 1);
  return dual;
}

}  // namespace quench::dual::plane
