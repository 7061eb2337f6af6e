// SPDX-License-Identifier: Apache-2.0
#include "lattice/polytopes.h"

#include <algorithm>
#include <atomic>

#include "parallel.h"
#include "prefetch.h"

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

constexpr std::uint32_t kAhead = 8;  // tetrahedra whose neighbours are fetched early

// Components of tetrahedra, named by their smallest member; many threads may unite at once. Parents are never larger
// than their children, so finding ends.
class Components {
 public:
  explicit Components(RawHugeVector<std::uint32_t>& parent) : parent_(parent) {}

  std::uint32_t find(std::uint32_t t) {
    for (;;) {
      const std::uint32_t up = at(t).load(std::memory_order_relaxed);
      if (up == t) return t;
      const std::uint32_t top = at(up).load(std::memory_order_relaxed);
      if (top == up) return up;
      at(t).store(top, std::memory_order_relaxed);  // whatever others do meanwhile, top is above t
      t = top;
    }
  }
  void unite(std::uint32_t a, std::uint32_t b) {
    for (;;) {
      a = find(a);
      b = find(b);
      if (a == b) return;
      if (a > b) std::swap(a, b);
      if (at(b).compare_exchange_weak(b, a, std::memory_order_relaxed)) return;
    }
  }

 private:
  std::atomic_ref<std::uint32_t> at(std::uint32_t t) { return std::atomic_ref<std::uint32_t>(parent_[t]); }
  RawHugeVector<std::uint32_t>& parent_;
};

class Merger {
 public:
  Merger(const Keep& keep, std::span<const LatticePoint> sites, Context* context)
      : keep_(keep), sites_(sites), context_(context) {}

  Polytopes run(std::unique_ptr<Delaunay> delaunay) {
    const Predicates predicates = delaunay->predicates();
    sort_inside(*delaunay);
    delaunay.reset();
    unite_cospherical(predicates);
    collect();
    return std::move(result_);
  }

 private:
  // Keeps what is wanted, by counting in the order of their smallest corners.
  void sort_inside(const Delaunay& delaunay) {
    const auto& old = delaunay.tetrahedra();
    const auto& points = delaunay.points();
    const std::size_t chunks = chunks_for(old.size());
    RawHugeVector<std::uint32_t> place(old.size());  // first the smallest corner, then the new number
    begin_.assign(sites_.size() + 1, 0);
    for_chunks(chunks, context_, "merge", 0, 0.15, [&](std::size_t chunk) {
      const auto [first, last] = part_of(old.size(), chunk, chunks);
      for (std::size_t t = first; t < last; ++t) {
        place[t] = kNone;
        if (old[t].corner[0] == kNone || delaunay.touches_box(old[t]) || !keep_(delaunay, old[t])) continue;
        for (const std::uint32_t c : old[t].corner) place[t] = std::min(place[t], points[c].site);
        std::atomic_ref<std::uint32_t>(begin_[place[t] + 1]).fetch_add(1, std::memory_order_relaxed);
      }
    });
    prefix_sum(begin_);
    std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
    for_chunks(chunks, context_, "merge", 0.15, 0.2, [&](std::size_t chunk) {
      const auto [first, last] = part_of(old.size(), chunk, chunks);
      for (std::size_t t = first; t < last; ++t)
        if (place[t] != kNone)
          place[t] = std::atomic_ref<std::uint32_t>(next[place[t]]).fetch_add(1, std::memory_order_relaxed);
    });
    result_.tetrahedra.resize(begin_.back());
    for_chunks(chunks, context_, "merge", 0.2, 0.3, [&](std::size_t chunk) {
      const auto [first, last] = part_of(old.size(), chunk, chunks);
      for (std::size_t t = first; t < last; ++t) {
        if (t + kAhead < last && place[t + kAhead] != kNone) {
          prefetch(&result_.tetrahedra[place[t + kAhead]]);
          for (const std::uint32_t n : old[t + kAhead].neighbour) prefetch(&place[n >> 2]);
        }
        if (place[t] == kNone) continue;
        Tetrahedron moved = old[t];  // no neighbour is on the hull: it does not touch the box
        for (std::uint32_t& c : moved.corner) c = points[c].site;
        for (std::uint32_t& n : moved.neighbour) n = place[n >> 2] == kNone ? kNone : 4 * place[n >> 2] + (n & 3);
        result_.tetrahedra[place[t]] = moved;
      }
    });
  }

  Point point(std::uint32_t site) const { return {sites_[site][0], sites_[site][1], sites_[site][2], site}; }

  void unite_cospherical(const Predicates& predicates) {
    const auto& tetrahedra = result_.tetrahedra;
    root_.resize(tetrahedra.size());
    const std::size_t chunks = chunks_for(tetrahedra.size());
    for_chunks(chunks, context_, "merge", 0.3, 0.31, [&](std::size_t chunk) {
      const auto [first, last] = part_of(tetrahedra.size(), chunk, chunks);
      for (std::size_t t = first; t < last; ++t) root_[t] = static_cast<std::uint32_t>(t);
    });
    Components components(root_);
    for_chunks(chunks, context_, "merge", 0.31, 0.5, [&](std::size_t chunk) {
      const auto [first, last] = part_of(tetrahedra.size(), chunk, chunks);
      for (std::size_t t = first; t < last; ++t) {
        const Tetrahedron& tet = tetrahedra[t];
        for (const std::uint32_t neighbour : tet.neighbour) {
          const std::uint32_t n = neighbour >> 2;
          if (neighbour == kNone || n < t) continue;
          if (predicates.in_sphere(point(tet.corner[0]), point(tet.corner[1]), point(tet.corner[2]),
                                   point(tet.corner[3]), point(tetrahedra[n].corner[neighbour & 3])) == 0)
            components.unite(static_cast<std::uint32_t>(t), n);
        }
      }
    });
    for_chunks(chunks, context_, "merge", 0.5, 0.53, [&](std::size_t chunk) {
      const auto [first, last] = part_of(tetrahedra.size(), chunk, chunks);
      for (std::size_t t = first; t < last; ++t) {
        const std::uint32_t root = components.find(static_cast<std::uint32_t>(t));
        std::atomic_ref<std::uint32_t>(root_[t]).store(root, std::memory_order_relaxed);
      }
    });
  }

  // Polytopes whose smallest corners lie in one range of sites: no polytope is in two ranges, since its root has its
  // smallest corner.
  struct Part {
    std::vector<std::uint32_t> site_offsets{0}, sites, member_offsets{0}, members;
  };

  void flood(std::uint32_t root, Part& part) {
    const auto& tetrahedra = result_.tetrahedra;
    std::size_t next = part.members.size();
    const std::size_t first = part.sites.size();
    part.members.push_back(root);
    result_.polytope_of[root] = root;
    for (; next < part.members.size(); ++next) {
      const Tetrahedron& t = tetrahedra[part.members[next]];
      part.sites.insert(part.sites.end(), t.corner.begin(), t.corner.end());
      for (const std::uint32_t neighbour : t.neighbour) {
        const std::uint32_t n = neighbour >> 2;
        if (neighbour == kNone || root_[n] != root || result_.polytope_of[n] == root) continue;
        result_.polytope_of[n] = root;
        part.members.push_back(n);
      }
    }
    const auto begin = part.sites.begin() + static_cast<std::ptrdiff_t>(first);
    std::sort(begin, part.sites.end());
    part.sites.erase(std::unique(begin, part.sites.end()), part.sites.end());
    part.site_offsets.push_back(static_cast<std::uint32_t>(part.sites.size()));
    part.member_offsets.push_back(static_cast<std::uint32_t>(part.members.size()));
  }

  // The polytopes of a part come by smallest corner; among equal ones the whole lists decide.
  static std::vector<std::uint32_t> sorted(const Part& part) {
    const auto count = static_cast<std::uint32_t>(part.site_offsets.size() - 1);
    std::vector<std::uint32_t> order(count);
    for (std::uint32_t p = 0; p < count; ++p) order[p] = p;
    const auto smallest = [&](std::uint32_t p) { return part.sites[part.site_offsets[p]]; };
    const auto less = [&](std::uint32_t a, std::uint32_t b) {
      const auto begin = part.sites.begin();
      return std::lexicographical_compare(begin + part.site_offsets[a], begin + part.site_offsets[a + 1],
                                          begin + part.site_offsets[b], begin + part.site_offsets[b + 1]);
    };
    for (std::uint32_t p = 0, end = 0; p < count; p = end) {
      while (end < count && smallest(end) == smallest(p)) ++end;
      if (end - p > 1) std::sort(order.begin() + p, order.begin() + end, less);
    }
    return order;
  }

  void collect() {
    result_.polytope_of.resize(result_.tetrahedra.size());
    const std::size_t chunks = chunks_for(sites_.size(), std::size_t{1} << 13);
    std::vector<Part> parts(chunks);
    for_chunks(chunks, context_, "merge", 0.53, 0.55, [&](std::size_t chunk) {
      const auto [first, last] = part_of(sites_.size(), chunk, chunks);
      std::fill(result_.polytope_of.begin() + begin_[first], result_.polytope_of.begin() + begin_[last], kNone);
    });
    for_chunks(chunks, context_, "merge", 0.55, 0.65, [&](std::size_t chunk) {
      const auto [first, last] = part_of(sites_.size(), chunk, chunks);
      for (std::uint32_t t = begin_[first]; t < begin_[last]; ++t)
        if (root_[t] == t) flood(t, parts[chunk]);
    });
    RawHugeVector<std::uint32_t>().swap(root_);
    std::vector<std::size_t> polytopes(chunks + 1, 0), corners(chunks + 1, 0), members(chunks + 1, 0);
    for (std::size_t c = 0; c < chunks; ++c) {
      polytopes[c + 1] = polytopes[c] + parts[c].site_offsets.size() - 1;
      corners[c + 1] = corners[c] + parts[c].sites.size();
      members[c + 1] = members[c] + parts[c].members.size();
    }
    check_index(std::max(corners.back(), members.back()));
    result_.site_offsets.resize(polytopes.back() + 1);
    result_.member_offsets.resize(polytopes.back() + 1);
    result_.sites.resize(corners.back());
    result_.members.resize(members.back());
    for_chunks(chunks, context_, "merge", 0.65, 0.7, [&](std::size_t chunk) {
      Part part = std::move(parts[chunk]);
      std::size_t rank = polytopes[chunk], corner = corners[chunk], member = members[chunk];
      for (const std::uint32_t p : sorted(part)) {
        for (std::uint32_t s = part.site_offsets[p]; s < part.site_offsets[p + 1]; ++s)
          result_.sites[corner++] = part.sites[s];
        for (std::uint32_t m = part.member_offsets[p]; m < part.member_offsets[p + 1]; ++m) {
          result_.members[member++] = part.members[m];
          result_.polytope_of[part.members[m]] = static_cast<std::uint32_t>(rank);
        }
        ++rank;
        result_.site_offsets[rank] = static_cast<std::uint32_t>(corner);
        result_.member_offsets[rank] = static_cast<std::uint32_t>(member);
      }
    });
  }

  const Keep& keep_;
  std::span<const LatticePoint> sites_;
  Context* context_;
  Polytopes result_;
  std::vector<std::uint32_t> begin_;   // per site: the first tetrahedron whose smallest corner it is
  RawHugeVector<std::uint32_t> root_;  // per tetrahedron: the smallest one of its polytope
};

}  // namespace

Polytopes polytopes_of(const Keep& keep, std::unique_ptr<Delaunay> delaunay, std::span<const LatticePoint> sites,
                       Context* context) {
  return Merger(keep, sites, context).run(std::move(delaunay));
}

Polytopes polytopes_inside(const VoxelShape& shape, std::unique_ptr<Delaunay> delaunay,
                           std::span<const LatticePoint> sites, Context* context) {
  // The boundary faces and edges of O are Delaunay (Yan 2018, Thm. 2.4.1), so a tetrahedron is inside O or outside as
  // a whole, and the voxel that contains its centroid tells. A centroid between voxels needs no care: it is not on the
  // boundary of O, so all voxels around it agree.
  const auto inside = [&shape](const Delaunay& triangulation, const Tetrahedron& t) {
    std::int64_t x = 0, y = 0, z = 0;
    for (std::uint32_t c : t.corner) {
      const Point& p = triangulation.points()[c];
      x += p.x;
      y += p.y;
      z += p.z;
    }
    return shape.contains(x >> 2, y >> 2, z >> 2);
  };
  return polytopes_of(inside, std::move(delaunay), sites, context);
}

}  // namespace quench::lattice
