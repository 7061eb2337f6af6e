// SPDX-License-Identifier: Apache-2.0
#include "burning/vertex_angles.h"

#include <cmath>

#include "base/parallel.h"

namespace quench::burning {
namespace {

// Walks through the corners of a sector, from one to the next across the edge of two polygons between them.
class Walk {
 public:
  explicit Walk(const BurnDomain& domain) : domain_(domain), complex_(domain.complex), network_(domain.network) {}

  // Starts at an end of the sector; false if it has none, since it is closed around the vertex.
  bool start(std::span<const std::uint32_t> corners) {
    for (const std::uint32_t c : corners)
      for (const bool from_side : {true, false}) {
        at_ = {c, from_side};
        if (network_.degree(edge_behind()) != 2) return true;
      }
    at_ = {corners[0], true};
    return false;
  }
  // The edges over which the walk came to its corner, and over which it leaves.
  std::uint32_t edge_behind() const { return complex_.face_edges[edge_corner(at_.from_side)]; }
  std::uint32_t edge_ahead() const { return complex_.face_edges[edge_corner(!at_.from_side)]; }
  // To the next corner; false at the end of the sector.
  bool step() {
    const std::uint32_t own = edge_corner(!at_.from_side), v = complex_.face_vertices[at_.corner];
    const auto beside = network_.face_corners_at(complex_.face_edges[own]);
    if (beside.size() != 2) return false;
    const std::uint32_t other = beside[beside[0] == own];
    const bool starts = complex_.face_vertices[other] == v;
    at_ = {starts ? other : domain_.corner_after(other), starts};
    return true;
  }
  std::uint32_t corner() const { return at_.corner; }
  // Whether the walk came in over the side that starts at the corner, not the one before.
  bool from_side() const { return at_.from_side; }

 private:
  // The corner at which that side starts, of the two sides at this corner.
  std::uint32_t edge_corner(bool starts_here) const {
    return starts_here ? at_.corner : domain_.corner_before(at_.corner);
  }

  const BurnDomain& domain_;
  const CellComplex& complex_;
  const BurnNetwork& network_;
  struct {
    std::uint32_t corner;
    bool from_side;
  } at_{};
};

}  // namespace

VertexAngles make_vertex_angles(const BurnDomain& domain) {
  VertexAngles angles;
  angles.corners.resize(domain.complex.face_vertices.size());
  angles.sectors.resize(domain.vertex_states());
  base::for_indices(domain.vertex_states(), [&](std::size_t state) {
    const auto corners = domain.links.corners[state];
    Walk walk(domain);
    const bool has_end = walk.start(corners);
    const std::uint32_t first_edge = has_end ? walk.edge_behind() : kNone;
    double direction = 0;
    for (std::size_t n = 0; n < corners.size(); ++n) {
      const std::uint32_t c = walk.corner();
      const auto &side = domain.polygons.sides[c], &previous = domain.polygons.sides[domain.corner_before(c)];
      // Between the side and the one before, which is turned round.
      const double next = direction + std::abs(std::atan2(side.dy * previous.dx - side.dx * previous.dy,
                                                          -side.dx * previous.dx - side.dy * previous.dy));
      angles.corners[c] =
          walk.from_side() ? VertexAngles::Corner{direction, next} : VertexAngles::Corner{next, direction};
      direction = next;
      if (!walk.step()) break;
    }
    angles.sectors[state] = {direction, first_edge, has_end ? walk.edge_ahead() : kNone};
  });
  return angles;
}

}  // namespace quench::burning
