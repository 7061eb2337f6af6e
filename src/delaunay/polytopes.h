// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "delaunay/delaunay.h"
#include "quench/shape.h"

namespace quench::delaunay {

/// The Delaunay complex inside O: its polytopes (maximal cospherical sets of sites) and the tetrahedra they were cut
/// into, both in the order of their smallest corners. It is the order of scanlines, so that what follows works in the
/// cache.
struct Polytopes {
  std::vector<std::uint32_t> site_offsets{0}, sites;      ///< corners of each polytope, ascending site ids
  std::vector<std::uint32_t> member_offsets{0}, members;  ///< tetrahedra of each polytope
  /// Tetrahedra inside O: corners are site ids; across the boundary of O the neighbour is kNone.
  base::RawHugeVector<Tetrahedron> tetrahedra;
  base::RawHugeVector<std::uint32_t> polytope_of;  ///< per tetrahedron

  std::uint32_t count() const { return static_cast<std::uint32_t>(site_offsets.size() - 1); }
  std::span<const std::uint32_t> sites_of(std::size_t polytope) const {
    return {sites.data() + site_offsets[polytope], sites.data() + site_offsets[polytope + 1]};
  }
  std::span<const std::uint32_t> members_of(std::size_t polytope) const {
    return {members.data() + member_offsets[polytope], members.data() + member_offsets[polytope + 1]};
  }
};

/// Merges the cospherical tetrahedra inside O; consumes the triangulation to free its memory early. The polytopes do
/// not depend on the triangulation, their order and the tetrahedra do. Linear time up to small sorts, on all threads.
/// `range`: sites a thread works on at a time; nothing depends on it but speed.
Polytopes polytopes_inside(const VoxelShape& shape, std::unique_ptr<Delaunay> delaunay,
                           std::span<const LatticePoint> sites, Context* context,
                           std::size_t range = std::size_t{1} << 15);

/// Whether a tetrahedron without box points, by its slot and its corners, belongs to the complex that is wanted. Called
/// by many threads.
using Keep = std::function<bool(std::uint32_t slot, const Tetrahedron&)>;

/// The same for the tetrahedra that `keep` chooses. Those across a facet that are not kept are kNone, and cospherical
/// tetrahedra are merged where kept ones join them.
Polytopes polytopes_of(const Keep& keep, std::unique_ptr<Delaunay> delaunay, std::span<const LatticePoint> sites,
                       Context* context, std::size_t range = std::size_t{1} << 15);

}  // namespace quench::delaunay
