// SPDX-License-Identifier: Apache-2.0
#include "voxelization/voxel_graph.h"

#include <algorithm>

#include "shape/voxel_components.h"

namespace quench::voxelization {
namespace {

std::array<std::int32_t, 3> by_row(const Voxel& v) { return {v[2], v[1], v[0]}; }

/// The index of a voxel in a list in order of z, y, x; its size where it is not there.
std::uint32_t index_in(const std::vector<Voxel>& voxels, const Voxel& v) {
  const auto at = std::lower_bound(voxels.begin(), voxels.end(), v,
                                   [](const Voxel& a, const Voxel& b) { return by_row(a) < by_row(b); });
  return static_cast<std::uint32_t>(at != voxels.end() && *at == v ? at - voxels.begin()
                                                                   : static_cast<std::ptrdiff_t>(voxels.size()));
}

/// Calls visit(neighbour, its bit) for the 26 neighbours of a voxel.
template <class Visit>
void for_26(const Voxel& v, const Visit& visit) {
  for (int dz = -1; dz <= 1; ++dz)
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx)
        if (dx != 0 || dy != 0 || dz != 0) visit(Voxel{v[0] + dx, v[1] + dy, v[2] + dz}, neighbour_bit(dx, dy, dz));
}

/// The set of a voxel among shape::foreground_components() or, of one outside, shape::background_components().
std::uint32_t set_of(const VoxelShape& shape, bool foreground, base::UnionFind& sets, const Voxel& v) {
  const auto row = shape.row(v[1], v[2]);
  const auto after =
      std::upper_bound(row.begin(), row.end(), v[0], [](std::int32_t x, const Run& run) { return x < run.begin; });
  const auto outside = static_cast<std::uint32_t>(shape.runs().size());
  if (!foreground && (after == row.begin() || after == row.end())) return sets.find(outside);
  return sets.find(shape::first_index(shape, row) + static_cast<std::uint32_t>(after - row.begin()) - 1);
}

}  // namespace

VoxelShape with_flipped(const VoxelShape& shape, std::span<const Voxel> voxels) {
  VoxelShape result(shape.grid());
  auto voxel = voxels.begin();
  std::vector<std::int32_t> ends;
  std::vector<Run> runs;
  for (std::int32_t z = 0; z < shape.grid().dims[2]; ++z)
    for (std::int32_t y = 0; y < shape.grid().dims[1]; ++y) {
      const std::span<const Run> row = shape.row(y, z);
      if (voxel == voxels.end() || (*voxel)[2] != z || (*voxel)[1] != y) {
        result.append_row(row);
        continue;
      }
      ends.clear();  // places where inside begins or ends; a flipped voxel adds two, and pairs cancel
      for (const Run& run : row) ends.insert(ends.end(), {run.begin, run.end});
      for (; voxel != voxels.end() && (*voxel)[2] == z && (*voxel)[1] == y; ++voxel)
        ends.insert(ends.end(), {(*voxel)[0], (*voxel)[0] + 1});
      std::sort(ends.begin(), ends.end());
      runs.clear();
      for (std::size_t i = 0; i < ends.size(); i += 2) runs.push_back({ends[i], ends[i + 1]});
      result.append_row(runs);
    }
  return result;
}

VoxelGraph::VoxelGraph(const VoxelShape& shape, std::int64_t euler, std::vector<Voxel> loose)
    : loose_(std::move(loose)), inside_(loose_.size()), in_group_(loose_.size()), lasting_(loose_.size()) {
  look_around(shape);
  std::vector<Voxel> in, out;
  for (std::uint32_t v = 0; v < loose_.size(); ++v) (inside_[v] ? in : out).push_back(loose_[v]);
  find_components(foreground_, with_flipped(shape, in));
  find_components(background_, with_flipped(shape, out));
  euler_ = euler;
  for (Side* side : {&foreground_, &background_}) recount(*side);
}

void VoxelGraph::look_around(const VoxelShape& shape) {
  for (std::uint32_t v = 0; v < loose_.size(); ++v)
    inside_[v] = shape.contains(loose_[v][0], loose_[v][1], loose_[v][2]);
  links_ = base::Csr<Link>::group(loose_.size(), [&](const auto& emit) {
    for (std::uint32_t v = 0; v < loose_.size(); ++v)
      for_26(loose_[v], [&](const Voxel& other, Neighbours bit) {
        const std::uint32_t at = index_in(loose_, other);
        if (at < loose_.size())
          emit(v, {at, bit});
        else if (shape.contains(other[0], other[1], other[2]))
          lasting_[v] |= bit;
      });
  });
}

void VoxelGraph::find_components(Side& side, const VoxelShape& lasting) {
  base::UnionFind sets =
      side.foreground ? shape::foreground_components(lasting) : shape::background_components(lasting);
  const Neighbours reach = side.foreground ? kFaceNeighbours : kAllNeighbours;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> touching;  // loose voxel, set
  for (std::uint32_t v = 0; v < loose_.size(); ++v)
    for_26(loose_[v], [&](const Voxel& other, Neighbours bit) {
      const bool is_lasting = side.foreground ? (lasting_[v] & bit) != 0
                                              : (lasting_[v] & bit) == 0 && index_in(loose_, other) == loose_.size();
      if ((bit & reach) && is_lasting) touching.emplace_back(v, set_of(lasting, side.foreground, sets, other));
    });
  std::sort(touching.begin(), touching.end());
  touching.erase(std::unique(touching.begin(), touching.end()), touching.end());
  std::vector<std::uint32_t> names;
  for (const auto& [v, set] : touching) names.push_back(set);
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  side.touched = base::Csr<std::uint32_t>::group(loose_.size(), [&](const auto& emit) {
    for (const auto& [v, set] : touching) {
      const auto name = std::lower_bound(names.begin(), names.end(), set) - names.begin();
      emit(v, static_cast<std::uint32_t>(loose_.size() + static_cast<std::size_t>(name)));
    }
  });
  side.nodes = loose_.size() + names.size();
  side.untouched = sets.count() - static_cast<std::int64_t>(names.size());
}

Neighbours VoxelGraph::around(std::uint32_t v) const {
  Neighbours result = lasting_[v];
  for (const Link& link : links_[v])
    if (inside_[link.to]) result |= link.bit;
  return result;
}

/// Nodes of the side that a voxel is joined to, as far as they are there.
template <class Visit>
void VoxelGraph::for_links(const Side& side, std::uint32_t v, const Visit& visit) const {
  const Neighbours reach = side.foreground ? kFaceNeighbours : kAllNeighbours;
  for (const Link& link : links_[v])
    if ((link.bit & reach) && is_in(side, link.to)) visit(link.to);
  for (const std::uint32_t node : side.touched[v]) visit(node);
}

/// Their number without the group.
std::int64_t VoxelGraph::components(const Side& side, base::UnionFind& sets) {
  work_ += static_cast<std::int64_t>(loose_.size());
  sets = base::UnionFind(side.nodes);
  std::int64_t absent = 0;
  for (std::uint32_t v = 0; v < loose_.size(); ++v) {
    if (!is_in(side, v) || in_group_[v])
      ++absent;
    else
      for_links(side, v, [&](std::uint32_t node) {
        if (node >= loose_.size() || !in_group_[node]) sets.unite(v, node);
      });
  }
  return sets.count() - absent + side.untouched;
}

/// How many more components there are when the group, which is not in the side, comes into it.
std::int64_t VoxelGraph::joined(Side& side, std::span<const std::uint32_t> group) const {  // find() halves paths
  std::vector<std::size_t> nodes(group.begin(), group.end());
  // Sets are named by a member, which may be one of the group that has left: they get names of their own.
  const auto set_at = [&](std::uint32_t node) { return side.nodes + side.sets.find(node); };
  for (const std::uint32_t v : group) for_links(side, v, [&](std::uint32_t node) { nodes.push_back(set_at(node)); });
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  const auto place = [&](std::size_t node) {
    return static_cast<std::uint32_t>(std::lower_bound(nodes.begin(), nodes.end(), node) - nodes.begin());
  };
  base::UnionFind sets(nodes.size());
  const Neighbours reach = side.foreground ? kFaceNeighbours : kAllNeighbours;
  for (const std::uint32_t v : group) {
    for_links(side, v, [&](std::uint32_t node) { sets.unite(place(v), place(set_at(node))); });
    for (const Link& link : links_[v])
      if ((link.bit & reach) && in_group_[link.to]) sets.unite(place(v), place(link.to));
  }
  return sets.count() - static_cast<std::int64_t>(nodes.size() - group.size());
}

/// Whether nothing comes apart when the group leaves the side, because it is one voxel whose neighbours are joined
/// without it, or because all of it and all it touches touch one lasting component. False where that does not tell.
bool VoxelGraph::holds(const Side& side, std::span<const std::uint32_t> group) const {
  if (group.size() == 1) {
    const Neighbours foreground = around(group[0]), faces = foreground & kFaceNeighbours;
    const Neighbours background = ~foreground & kAllNeighbours;
    if (side.foreground ? faces != 0 && joined_by_faces(foreground & kFaceAndEdgeNeighbours, faces)
                        : background != 0 && is_joined(background))
      return true;
  }
  const auto common = side.touched[group[0]];
  const auto touches = [&](std::uint32_t v) {
    return common.size() == 1 && side.touched[v].size() == 1 && side.touched[v][0] == common[0];
  };
  return std::ranges::all_of(group, [&](std::uint32_t v) {
    bool all = touches(v);
    for_links(side, v, [&](std::uint32_t node) { all = all && (node >= loose_.size() || touches(node)); });
    return all;
  });
}

/// How many more there are when the group leaves the side.
std::int64_t VoxelGraph::parted(const Side& side, std::span<const std::uint32_t> group) {
  if (holds(side, group)) return 0;
  base::UnionFind sets(0);
  return components(side, sets) - count_of(side);
}

Betti VoxelGraph::after(std::span<const std::uint32_t> group) {
  const bool puts_in = !inside_[group[0]];
  work_ += static_cast<std::int64_t>(group.size());
  for (const std::uint32_t v : group) in_group_[v] = 1;
  const std::int64_t components = components_ + (puts_in ? joined(foreground_, group) : parted(foreground_, group));
  const std::int64_t background =
      background_components_ + (puts_in ? parted(background_, group) : joined(background_, group));
  std::int64_t euler = euler_;
  for (const std::uint32_t v : group) {
    euler += (puts_in ? 1 : -1) * euler_change(around(v));
    inside_[v] = puts_in;
  }
  for (const std::uint32_t v : group) {
    inside_[v] = !puts_in;
    in_group_[v] = 0;
  }
  return betti_of(components, background, euler);
}

void VoxelGraph::flip(std::span<const std::uint32_t> group) {
  if (group.empty()) return;
  const bool puts_in = !inside_[group[0]];
  Side& to = puts_in ? foreground_ : background_;
  Side& from = puts_in ? background_ : foreground_;
  const bool uniform = std::ranges::all_of(group, [&](std::uint32_t v) { return inside_[v] != puts_in; });
  const bool joins = uniform && std::ranges::none_of(group, [&](std::uint32_t v) { return to.left[v] != 0; });
  const bool held = uniform && holds(from, group);
  for (const std::uint32_t v : group) in_group_[v] = 1;
  if (joins) count_of(to) += joined(to, group);
  for (const std::uint32_t v : group) {
    euler_ += (inside_[v] ? -1 : 1) * euler_change(around(v));
    inside_[v] = !inside_[v];
  }
  for (const std::uint32_t v : group) in_group_[v] = 0;
  if (joins) {
    for (const std::uint32_t v : group) for_links(to, v, [&](std::uint32_t node) { to.sets.unite(v, node); });
  } else {
    recount(to);
  }
  if (held) {
    for (const std::uint32_t v : group) from.left[v] = 1;
  } else {
    recount(from);
  }
}

void VoxelGraph::recount(Side& side) {
  count_of(side) = components(side, side.sets);
  side.left.assign(loose_.size(), 0);
}

}  // namespace quench::voxelization
