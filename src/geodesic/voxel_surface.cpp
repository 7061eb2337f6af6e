// SPDX-License-Identifier: Apache-2.0
#include "geodesic/voxel_surface.h"

#include <algorithm>
#include <bit>
#include <numeric>

#include "base/union_find.h"
#include "quench/error.h"

namespace quench::geodesic {
namespace {

// Voxels around a site are numbered by bits: 1, 2, 4 where they lie towards larger x, y, z.
constexpr unsigned kAll = 7;

/// The parts of the voxels around a site that faces connect.
struct Parts {
  std::array<std::uint8_t, 8> of{};  ///< per voxel that is in O
  std::uint8_t count = 0;
};

constexpr Parts parts_of(unsigned mask) {
  Parts parts;
  unsigned left = mask;
  while (left) {
    unsigned part = left & (~left + 1), before = 0;
    while (part != before) {
      before = part;
      for (unsigned v = 0; v < 8; ++v)
        if (part >> v & 1)
          for (unsigned axis = 0; axis < 3; ++axis) part |= mask & 1u << (v ^ 1u << axis);
    }
    for (unsigned v = 0; v < 8; ++v)
      if (part >> v & 1) parts.of[v] = parts.count;
    ++parts.count;
    left &= ~part;
  }
  return parts;
}

const std::array<Parts, 256>& all_parts() {
  static const std::array<Parts, 256> table = [] {
    std::array<Parts, 256> parts;
    for (unsigned mask = 0; mask < 256; ++mask) parts[mask] = parts_of(mask);
    return parts;
  }();
  return table;
}

constexpr unsigned next_axis(unsigned axis) { return axis == 2 ? 0 : axis + 1; }

bool comes_before(const LatticePoint& a, const LatticePoint& b) {
  return a[2] != b[2] ? a[2] < b[2] : a[1] != b[1] ? a[1] < b[1] : a[0] < b[0];
}

/// The side of a square that runs along an axis, at its smallest corner or across. `forward`: its corners are m, m + b,
/// m + b + c, m + c, else m, m + c, m + b + c, m + b, where b and c are the axes after that across it.
constexpr unsigned side_of(unsigned across, bool forward, unsigned along, bool at_corner) {
  const bool first = (along == next_axis(across)) == forward;
  return first ? (at_corner ? 0 : 2) : (at_corner ? 3 : 1);
}

}  // namespace

/// Per site the next and the last one along each axis, if there is one.
struct VoxelSurface::Neighbours {
  explicit Neighbours(const std::vector<LatticePoint>& sites) {
    for (unsigned axis = 0; axis < 3; ++axis) {
      next[axis].assign(sites.size(), kNone);
      last[axis].assign(sites.size(), kNone);
      std::uint32_t t = 0;
      for (std::uint32_t s = 0; s < sites.size(); ++s) {
        LatticePoint wanted = sites[s];
        ++wanted[axis];
        while (t < sites.size() && comes_before(sites[t], wanted)) ++t;
        if (t == sites.size() || sites[t] != wanted) continue;
        next[axis][s] = t;
        last[axis][t] = s;
      }
    }
  }
  std::array<std::vector<std::uint32_t>, 3> next, last;
};

VoxelSurface::VoxelSurface(const VoxelShape& shape) : sites_(boundary_vertices(shape)) {
  std::ranges::copy(integer_spacing(shape.grid()), step_.begin());
  unit_ = shape.grid().spacing.minCoeff() / smallest_step();
  // At most 12 sides of squares begin at a vertex; their numbers share a word with a flag.
  if (sites_.size() >= 0x80000000u / 12)
    throw Error(ErrorCode::failed,
                "the surface of the voxel shape is too large for distances along it; choose a "
                "smaller resolution");
  find_masks(shape);
  const Neighbours neighbours(sites_);
  make_squares(neighbours);
  glue(neighbours);
  square_at_ = {};
  list_leaving();
  find_components();
}

void VoxelSurface::find_masks(const VoxelShape& shape) {
  mask_.assign(sites_.size(), 0);
  for (std::size_t first = 0, last = 0; first < sites_.size(); first = last) {
    const std::int32_t y = sites_[first][1], z = sites_[first][2];
    while (last < sites_.size() && sites_[last][1] == y && sites_[last][2] == z) ++last;
    for (unsigned row = 0; row < 4; ++row) {
      const auto runs = shape.row(y - 1 + int(row & 1), z - 1 + int(row >> 1));
      std::size_t r = 0;
      for (std::size_t s = first; s < last; ++s) {
        const std::int32_t x = sites_[s][0];
        while (r < runs.size() && runs[r].end < x) ++r;
        if (r == runs.size()) break;
        const bool left = runs[r].begin < x, right = runs[r].begin <= x && x < runs[r].end;
        mask_[s] |= static_cast<std::uint8_t>((unsigned{left} | unsigned{right} << 1) << 2 * row);
      }
    }
  }
  first_point_.reserve(sites_.size() + 1);
  first_point_.push_back(0);
  for (std::uint32_t s = 0; s < sites_.size(); ++s) {
    const unsigned parts = all_parts()[mask_[s]].count;
    site_of_.insert(site_of_.end(), parts, s);
    first_point_.push_back(static_cast<std::uint32_t>(site_of_.size()));
  }
}

void VoxelSurface::make_squares(const Neighbours& neighbours) {
  square_at_.assign(3 * sites_.size(), kNone);
  std::uint32_t count = 0;
  for (std::size_t s = 0; s < sites_.size(); ++s)
    for (unsigned axis = 0; axis < 3; ++axis)
      if ((mask_[s] >> kAll & 1) != (mask_[s] >> (kAll ^ 1u << axis) & 1)) square_at_[3 * s + axis] = count++;
  begin_.resize(4 * std::size_t{count});
  twin_.resize(begin_.size());
  axis_.resize(begin_.size());
  for (std::uint32_t s = 0; s < sites_.size(); ++s)
    for (unsigned axis = 0; axis < 3; ++axis) {
      const std::uint32_t square = square_at_[3 * s + axis];
      if (square == kNone) continue;
      const bool forward = !(mask_[s] >> kAll & 1);  // outside is towards larger coordinates
      const unsigned b = forward ? next_axis(axis) : next_axis(next_axis(axis)), c = 3 - axis - b;
      unsigned voxel = forward ? kAll ^ 1u << axis : kAll;  // of O at the square, as seen from the corner
      std::uint32_t corner = s;
      const std::array<unsigned, 4> along{b, c, b, c};
      for (unsigned side = 0; side < 4; ++side) {
        const std::size_t h = 4 * std::size_t{square} + side;
        begin_[h] = first_point_[corner] + all_parts()[mask_[corner]].of[voxel];
        axis_[h] = static_cast<std::uint8_t>(along[side]);
        corner = (side < 2 ? neighbours.next : neighbours.last)[along[side]][corner];
        voxel ^= 1u << along[side];
      }
    }
}

// Around every edge, squares are glued that the same voxels of O lie between.
void VoxelSurface::glue(const Neighbours& neighbours) {
  for (std::uint32_t u = 0; u < sites_.size(); ++u)
    for (unsigned d = 0; d < 3; ++d) {
      if (neighbours.next[d][u] == kNone) continue;
      const unsigned e = next_axis(d), f = next_axis(e);
      const auto in = [&](unsigned quadrant) {  // counter-clockwise in the plane of e and f
        quadrant &= 3;
        const unsigned voxel = 1u << d | (quadrant == 0 || quadrant == 3 ? 1u << e : 0) | (quadrant < 2 ? 1u << f : 0);
        return (mask_[u] >> voxel & 1) != 0;
      };
      const auto half_edge = [&](unsigned k) {  // of the square between quadrants k and k + 1
        k &= 3;
        const unsigned across = k & 1 ? f : e;
        const std::uint32_t corner = k == 1 ? neighbours.last[e][u] : k == 2 ? neighbours.last[f][u] : u;
        const bool forward = !(mask_[corner] >> kAll & 1);
        return 4 * square_at_[3 * std::size_t{corner} + across] + side_of(across, forward, d, k == 0 || k == 3);
      };
      for (unsigned k = 0; k < 4; ++k) {
        if (in(k) || !in(k + 1)) continue;
        unsigned j = k + 1;
        while (in(j + 1)) ++j;
        const std::uint32_t a = half_edge(k), b = half_edge(j);
        twin_[a] = b;
        twin_[b] = a;
      }
    }
}

void VoxelSurface::list_leaving() {
  leaving_begin_.assign(site_of_.size() + 2, 0);
  for (const std::uint32_t point : begin_) ++leaving_begin_[point + 2];
  std::partial_sum(leaving_begin_.begin(), leaving_begin_.end(), leaving_begin_.begin());
  leaving_.resize(begin_.size());
  for (std::uint32_t h = 0; h < begin_.size(); ++h) leaving_[leaving_begin_[begin_[h] + 1]++] = h;
  leaving_begin_.pop_back();
}

void VoxelSurface::find_components() {
  base::UnionFind sets(site_of_.size());
  for (std::uint32_t h = 0; h < begin_.size(); ++h) sets.unite(begin_[h], begin_[(h & ~3u) | ((h + 1) & 3u)]);
  component_.resize(site_of_.size());
  for (std::uint32_t p = 0; p < component_.size(); ++p) component_[p] = static_cast<std::uint32_t>(sets.find(p));
}

std::uint32_t VoxelSurface::point_towards(const LatticePoint& from, const LatticePoint& to) const {
  const auto found = std::ranges::lower_bound(sites_, from, comes_before);
  if (found == sites_.end() || *found != from) return kNone;
  const auto s = static_cast<std::size_t>(found - sites_.begin());
  for (unsigned voxel = 0; voxel < 8; ++voxel) {
    bool there = (mask_[s] >> voxel & 1) != 0;
    for (unsigned i = 0; i < 3; ++i) there &= from[i] == to[i] || (from[i] < to[i]) == ((voxel >> i & 1) != 0);
    if (there) return first_point_[s] + all_parts()[mask_[s]].of[voxel];
  }
  return kNone;
}

}  // namespace quench::geodesic
