// SPDX-License-Identifier: Apache-2.0
#include "lattice/polytopes.h"

#include <algorithm>

namespace quench::lattice {

void check_index(std::size_t count) {
  if (count >= kNone - 1)
    throw Error(ErrorCode::failed, "the voxel core outgrows 32-bit indices; use a lower resolution");
}

void prefix_sum(std::vector<std::uint32_t>& counts) {
  std::uint64_t sum = 0;
  for (std::uint32_t& c : counts) {
    sum += c;
    check_index(sum);
    c = static_cast<std::uint32_t>(sum);
  }
}

namespace {

constexpr std::uint32_t kOutside = kNone - 1;
constexpr std::uint32_t kAhead = 6;  // tetrahedra whose neighbours are fetched early

class Merger {
 public:
  Merger(const VoxelShape& shape, const Delaunay& delaunay, Context* context)
      : shape_(shape), delaunay_(delaunay), state_(delaunay.tetrahedra().size(), kNone) {
    const auto& tetrahedra = delaunay.tetrahedra();
    members_.reserve(tetrahedra.size() / 2);
    for (std::uint32_t t = 0; t < tetrahedra.size(); ++t) {
      if ((t & 0xFFFFF) == 0) checkpoint(context, "merge", 0.3 * t / static_cast<double>(tetrahedra.size()));
      if (t + kAhead < tetrahedra.size())
        for (std::uint32_t n : tetrahedra[t + kAhead].neighbour) {
          if (n == kNone) continue;  // the hull of the enclosing box
          __builtin_prefetch(&tetrahedra[n >> 2]);
          __builtin_prefetch(&state_[n >> 2]);
        }
      if (state_[t] != kNone) continue;
      if (tetrahedra[t].corner[0] == kNone || delaunay.touches_box(tetrahedra[t]) || !inside(tetrahedra[t]))
        state_[t] = kOutside;
      else
        flood(t);
    }
  }

  Polytopes renumbered(std::size_t site_count) {
    const std::vector<std::uint32_t> order = sorted_polytopes(site_count);
    Polytopes result;
    result.site_offsets.reserve(order.size() + 1);
    result.sites.reserve(sites_.size());
    result.polytope_of.reserve(members_.size());
    for (std::uint32_t p : order) {
      const auto rank = static_cast<std::uint32_t>(result.site_offsets.size() - 1);
      result.sites.insert(result.sites.end(), sites_.begin() + site_offsets_[p], sites_.begin() + site_offsets_[p + 1]);
      result.site_offsets.push_back(static_cast<std::uint32_t>(result.sites.size()));
      for (std::uint32_t m = member_offsets_[p]; m < member_offsets_[p + 1]; ++m) {
        state_[members_[m]] = static_cast<std::uint32_t>(result.polytope_of.size());
        result.polytope_of.push_back(rank);
      }
    }
    const auto& points = delaunay_.points();
    result.tetrahedra.reserve(members_.size());
    for (std::uint32_t p : order)
      for (std::uint32_t m = member_offsets_[p]; m < member_offsets_[p + 1]; ++m) {
        Tetrahedron t = delaunay_.tetrahedra()[members_[m]];
        for (std::uint32_t& c : t.corner) c = points[c].site;
        for (std::uint32_t& n : t.neighbour) {
          const std::uint32_t id = state_[n >> 2];
          n = id == kOutside ? kNone : 4 * id + (n & 3);
        }
        result.tetrahedra.push_back(t);
      }
    return result;
  }

 private:
  // The boundary faces and edges of O are Delaunay (Yan 2018, Thm. 2.4.1), so a tetrahedron is inside O or outside as
  // a whole, and the voxel that contains its centroid tells. A centroid between voxels needs no care: it is not on the
  // boundary of O, so all voxels around it agree.
  bool inside(const Tetrahedron& t) const {
    std::int64_t x = 0, y = 0, z = 0;
    for (std::uint32_t c : t.corner) {
      const Point& p = delaunay_.points()[c];
      x += p.x;
      y += p.y;
      z += p.z;
    }
    return shape_.contains(x >> 2, y >> 2, z >> 2);
  }

  void flood(std::uint32_t seed) {
    const auto& tetrahedra = delaunay_.tetrahedra();
    const auto& points = delaunay_.points();
    const auto polytope = static_cast<std::uint32_t>(site_offsets_.size() - 1);
    check_index(polytope);
    std::size_t next = members_.size();
    members_.push_back(seed);
    state_[seed] = polytope;
    const std::size_t first = sites_.size();
    for (; next < members_.size(); ++next) {
      const Tetrahedron& t = tetrahedra[members_[next]];
      for (std::uint32_t i = 0; i < 4; ++i) sites_.push_back(points[t.corner[i]].site);
      for (std::uint32_t i = 0; i < 4; ++i) {
        const std::uint32_t n = t.neighbour[i] >> 2;
        if (state_[n] != kNone) continue;
        const std::uint32_t apex = tetrahedra[n].corner[t.neighbour[i] & 3];
        if (apex < Delaunay::kBoxPoints) continue;
        // A facet on the boundary of O is a facet of the Delaunay complex: its two sides are never cospherical.
        if (delaunay_.predicates().in_sphere(points[t.corner[0]], points[t.corner[1]], points[t.corner[2]],
                                             points[t.corner[3]], points[apex]) == 0) {
          state_[n] = polytope;
          members_.push_back(n);
        }
      }
    }
    const auto begin = sites_.begin() + static_cast<std::ptrdiff_t>(first);
    std::sort(begin, sites_.end());
    sites_.erase(std::unique(begin, sites_.end()), sites_.end());
    check_index(sites_.size());
    site_offsets_.push_back(static_cast<std::uint32_t>(sites_.size()));
    member_offsets_.push_back(static_cast<std::uint32_t>(members_.size()));
  }

  // By smallest site through counting, then by comparison of the site lists.
  std::vector<std::uint32_t> sorted_polytopes(std::size_t site_count) const {
    const auto count = static_cast<std::uint32_t>(site_offsets_.size() - 1);
    std::vector<std::uint32_t> bucket(site_count + 1, 0);
    for (std::uint32_t p = 0; p < count; ++p) ++bucket[sites_[site_offsets_[p]] + 1];
    prefix_sum(bucket);
    std::vector<std::uint32_t> order(count), next(bucket.begin(), bucket.end() - 1);
    for (std::uint32_t p = 0; p < count; ++p) order[next[sites_[site_offsets_[p]]]++] = p;
    const auto less = [&](std::uint32_t a, std::uint32_t b) {
      return std::lexicographical_compare(sites_.begin() + site_offsets_[a], sites_.begin() + site_offsets_[a + 1],
                                          sites_.begin() + site_offsets_[b], sites_.begin() + site_offsets_[b + 1]);
    };
    for (std::size_t s = 0; s < site_count; ++s)
      if (bucket[s + 1] - bucket[s] > 1) std::sort(order.begin() + bucket[s], order.begin() + bucket[s + 1], less);
    return order;
  }

  const VoxelShape& shape_;
  const Delaunay& delaunay_;
  HugeVector<std::uint32_t> state_;  // per tetrahedron: its polytope, later its new number; kOutside outside O
  std::vector<std::uint32_t> site_offsets_{0}, sites_, member_offsets_{0}, members_;
};

}  // namespace

Polytopes polytopes_inside(const VoxelShape& shape, std::unique_ptr<Delaunay> delaunay, std::size_t site_count,
                           Context* context) {
  Merger merger(shape, *delaunay, context);
  return merger.renumbered(site_count);
}

}  // namespace quench::lattice
