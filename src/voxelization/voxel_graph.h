// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/csr.h"
#include "base/union_find.h"
#include "quench/shape.h"
#include "shape/simple_voxel.h"
#include "voxelization/deflate.h"

namespace quench::voxelization {

using shape::is_simple, shape::joined_by_faces, shape::neighbour_bit, shape::euler_change, shape::is_joined;
using shape::Neighbours, shape::kAllNeighbours, shape::kFaceNeighbours, shape::kFaceAndEdgeNeighbours;

using Betti = std::array<std::int64_t, 3>;

/// A shape with every voxel of a list (in order of z, y, x) taken out where it is in, and put in where it is not.
VoxelShape with_flipped(const VoxelShape& shape, std::span<const Voxel> voxels);

/// A shape of which a few voxels, the *loose* ones, may be put in or taken out, and its Betti numbers meanwhile. The
/// components of what never changes are found once; then every question is about the graph of loose voxels and the
/// components they touch. Loose voxels are known by their place in the list.
class VoxelGraph {
 public:
  /// `euler`: of the shape; `loose`: in order of z, y, x.
  VoxelGraph(const VoxelShape& shape, std::int64_t euler, std::vector<Voxel> loose);

  std::size_t size() const { return loose_.size(); }
  const Voxel& voxel(std::uint32_t v) const { return loose_[v]; }
  bool inside(std::uint32_t v) const { return inside_[v]; }
  Betti betti() const { return betti_of(components_, background_components_, euler_); }
  Neighbours around(std::uint32_t v) const;
  /// Loose voxels among the 26 neighbours.
  template <class Visit>
  void for_neighbours(std::uint32_t v, const Visit& visit) const {
    for (const Link& link : links_[v]) visit(link.to);
  }

  /// Betti numbers after flip(group); all of a group are inside, or all are outside.
  Betti after(std::span<const std::uint32_t> group);
  /// In the time of the group, unless something may have come apart.
  void flip(std::span<const std::uint32_t> group);
  /// How many loose voxels were looked at, by after() and to count components anew.
  std::int64_t work() const { return work_; }

 private:
  struct Link {
    std::uint32_t to;
    Neighbours bit;  ///< of `to` among the neighbours
  };
  /// Foreground or background: loose voxels, and the components of what is there for good, from size() on.
  struct Side {
    bool foreground;
    base::Csr<std::uint32_t> touched{};  ///< per loose voxel the lasting components it touches, each once
    std::size_t nodes = 0;
    std::int64_t untouched = 0;  ///< lasting components that no loose voxel touches
    base::UnionFind sets{0};     ///< at present; of loose voxels that are not there, those of `left` are in one, too
    std::vector<char> left{};    ///< that were there when `sets` was made, and went without anything coming apart
  };

  static Betti betti_of(std::int64_t components, std::int64_t background, std::int64_t euler) {
    return {components, components + background - 1 - euler, background - 1};
  }
  void look_around(const VoxelShape& shape);
  void find_components(Side& side, const VoxelShape& lasting);
  bool is_in(const Side& side, std::uint32_t v) const { return inside_[v] == side.foreground; }
  template <class Visit>
  void for_links(const Side& side, std::uint32_t v, const Visit& visit) const;
  std::int64_t components(const Side& side, base::UnionFind& sets);
  std::int64_t joined(Side& side, std::span<const std::uint32_t> group) const;
  bool holds(const Side& side, std::span<const std::uint32_t> group) const;
  std::int64_t parted(const Side& side, std::span<const std::uint32_t> group);
  void recount(Side& side);
  std::int64_t& count_of(const Side& side) { return side.foreground ? components_ : background_components_; }

  std::vector<Voxel> loose_;
  std::vector<char> inside_, in_group_;
  std::vector<Neighbours> lasting_;  ///< per loose voxel the neighbours that are foreground for good
  base::Csr<Link> links_;
  Side foreground_{true, {}}, background_{false, {}};
  std::int64_t euler_ = 0, components_ = 0, background_components_ = 0;  ///< of the shape, and of the background
  std::int64_t work_ = 0;
};

}  // namespace quench::voxelization
