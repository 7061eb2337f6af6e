// SPDX-License-Identifier: Apache-2.0
#include "delaunay/polytopes.h"

#include <algorithm>
#include <atomic>

#include "base/parallel.h"
#include "base/prefetch.h"

namespace quench::delaunay {

namespace {

constexpr std::uint32_t kAhead = 8;                   // tetrahedra whose neighbours are fetched early
constexpr std::size_t kPiece = std::size_t{1} << 19;  // tetrahedra compacted together: whole pages

class Merger {
 public:
  Merger(const Keep& keep, std::span<const LatticePoint> sites, const Predicates& predicates, std::size_t range,
         Context* context)
      : keep_(keep), sites_(sites), predicates_(predicates), range_(range), context_(context) {}

  Polytopes run(std::unique_ptr<Delaunay> delaunay) {
    sort_inside(*delaunay);
    delaunay.reset();
    collect();
    return std::move(result_);
  }

 private:
  // Keeps the wanted tetrahedra, by a counting sort on their smallest corners. First each piece of the old array is
  // compacted to its own front and the rest of its memory given back, so that the triangulation and what is kept of it
  // are never in memory at the same time.
  void sort_inside(Delaunay& delaunay) {
    base::RawHugeVector<Tetrahedron> old = delaunay.take_tetrahedra();
    base::RawHugeVector<std::uint32_t> place(
        old.size());  // first the rank among those with one smallest corner, then of all
    const auto smallest = [](const Tetrahedron& t) { return *std::min_element(t.corner.begin(), t.corner.end()); };
    begin_.assign(sites_.size() + 1, 0);
    const std::size_t pieces = base::chunks_for(old.size(), kPiece);
    const auto piece_end = [&](std::size_t piece) { return std::min(old.size(), (piece + 1) * kPiece); };
    std::vector<std::size_t> kept_end(pieces);
    const base::HugeVector<Point>& points = delaunay.points();
    base::for_chunks(pieces, context_, "merge", 0, 0.15, [&](std::size_t piece) {
      std::size_t kept = piece * kPiece;
      for (std::size_t t = piece * kPiece; t < piece_end(piece); ++t) {
        place[t] = kNone;
        if (t + kAhead < piece_end(piece))
          for (const std::uint32_t c : old[t + kAhead].corner)
            if (c != kNone) base::prefetch(&points[c]);
        if (old[t].corner[0] == kNone || Delaunay::touches_box(old[t]) || !keep_(static_cast<std::uint32_t>(t), old[t]))
          continue;
        Tetrahedron moved = old[t];
        for (std::uint32_t& c : moved.corner) c = points[c].site;
        place[t] = std::atomic_ref<std::uint32_t>(begin_[smallest(moved) + 1]).fetch_add(1, std::memory_order_relaxed);
        old[kept++] = moved;
      }
      kept_end[piece] = kept;
      base::release_elements(old.data(), old.size(), kept, piece_end(piece));
    });
    delaunay.take_points();
    base::prefix_sum(begin_);
    base::for_chunks(pieces, context_, "merge", 0.15, 0.2, [&](std::size_t piece) {
      std::size_t from = piece * kPiece;
      for (std::size_t t = piece * kPiece; t < piece_end(piece); ++t)
        if (place[t] != kNone) place[t] += begin_[smallest(old[from++])];
    });
    result_.tetrahedra.resize(begin_.back());
    base::for_chunks(pieces, context_, "merge", 0.2, 0.3, [&](std::size_t piece) {
      std::size_t from = piece * kPiece;
      for (std::size_t t = piece * kPiece; t < piece_end(piece); ++t) {
        if (place[t] == kNone) continue;
        if (from + kAhead < kept_end[piece])
          for (const std::uint32_t n : old[from + kAhead].neighbour) base::prefetch(&place[n >> 2]);
        Tetrahedron moved = old[from++];  // no neighbour is on the hull: it does not touch the box
        for (std::uint32_t& n : moved.neighbour) n = place[n >> 2] == kNone ? kNone : 4 * place[n >> 2] + (n & 3);
        result_.tetrahedra[place[t]] = moved;
      }
      base::release_elements(old.data(), old.size(), piece * kPiece, piece_end(piece));
    });
  }

  Point point(std::uint32_t site) const { return {sites_[site][0], sites_[site][1], sites_[site][2], site}; }

  // Polytopes whose smallest corners lie in one range of sites: no polytope is in two ranges.
  struct Part {
    std::vector<std::uint32_t> site_offsets{0}, sites, member_offsets{0}, members;
  };

  // Finds the polytopes of one range of tetrahedra, [first, last). Ranges are worked on at the same time, so only
  // tetrahedra of the own range are marked; the few others of a polytope are remembered in a list. A polytope belongs
  // to the range of its first tetrahedron, which has its smallest corner; another range that finds it discards it.
  class Flood {
   public:
    Flood(Merger& merger, std::uint32_t first, std::uint32_t last) : merger_(merger), first_(first), last_(last) {}

    Part run() {
      auto& mark = merger_.result_.polytope_of;
      std::fill(mark.begin() + first_, mark.begin() + last_, kNone);
      for (std::uint32_t t = first_; t < last_; ++t)
        if (mark[t] == kNone) flood(t);
      return std::move(part_);
    }

   private:
    bool visit(std::uint32_t t) {  // true the first time
      if (t >= first_ && t < last_) {
        merger_.result_.polytope_of[t] = t;
        return true;  // it is not called for marked ones
      }
      if (std::find(elsewhere_.begin(), elsewhere_.end(), t) != elsewhere_.end()) return false;
      elsewhere_.push_back(t);
      return true;
    }

    // All tetrahedra of a polytope have one sphere, so that of the first tells which belong to it.
    void flood(std::uint32_t start) {
      const auto& tetrahedra = merger_.result_.tetrahedra;
      auto& members = part_.members;
      const std::size_t first_member = members.size(), first_site = part_.sites.size();
      const auto& c = tetrahedra[start].corner;
      const Predicates::Sphere sphere = merger_.predicates_.sphere(merger_.point(c[0]), merger_.point(c[1]),
                                                                   merger_.point(c[2]), merger_.point(c[3]));
      elsewhere_.clear();
      bool earlier = false;
      visit(start);
      members.push_back(start);
      for (std::size_t next = first_member; next < members.size(); ++next) {
        const Tetrahedron& t = tetrahedra[members[next]];
        part_.sites.insert(part_.sites.end(), t.corner.begin(), t.corner.end());
        for (const std::uint32_t neighbour : t.neighbour) {
          const std::uint32_t n = neighbour >> 2;
          if (neighbour == kNone || (n >= first_ && n < last_ && merger_.result_.polytope_of[n] != kNone)) continue;
          if (!merger_.predicates_.on_sphere(sphere, merger_.point(tetrahedra[n].corner[neighbour & 3]))) continue;
          if (!visit(n)) continue;
          members.push_back(n);
          earlier = earlier || n < first_;
        }
      }
      if (earlier) {
        members.resize(first_member);
        part_.sites.resize(first_site);
        return;
      }
      const auto begin = part_.sites.begin() + static_cast<std::ptrdiff_t>(first_site);
      std::sort(begin, part_.sites.end());
      part_.sites.erase(std::unique(begin, part_.sites.end()), part_.sites.end());
      part_.site_offsets.push_back(static_cast<std::uint32_t>(part_.sites.size()));
      part_.member_offsets.push_back(static_cast<std::uint32_t>(members.size()));
    }

    Merger& merger_;
    const std::uint32_t first_, last_;
    std::vector<std::uint32_t> elsewhere_;  // tetrahedra of this polytope outside [first_, last_)
    Part part_;
  };

  void collect() {
    result_.polytope_of.resize(result_.tetrahedra.size());
    const std::size_t chunks = base::chunks_for(sites_.size(), range_);
    std::vector<Part> parts(chunks);
    base::for_chunks(chunks, context_, "merge", 0.3, 0.65, [&](std::size_t chunk) {
      const auto [first, last] = base::part_of(sites_.size(), chunk, chunks);
      parts[chunk] = Flood(*this, begin_[first], begin_[last]).run();
    });
    std::vector<std::size_t> polytopes(chunks + 1, 0), corners(chunks + 1, 0), members(chunks + 1, 0);
    for (std::size_t c = 0; c < chunks; ++c) {
      polytopes[c + 1] = polytopes[c] + parts[c].site_offsets.size() - 1;
      corners[c + 1] = corners[c] + parts[c].sites.size();
      members[c + 1] = members[c] + parts[c].members.size();
    }
    base::check_index(std::max(corners.back(), members.back()));
    result_.site_offsets.resize(polytopes.back() + 1);
    result_.member_offsets.resize(polytopes.back() + 1);
    result_.sites.resize(corners.back());
    result_.members.resize(members.back());
    base::for_chunks(chunks, context_, "merge", 0.65, 0.7, [&](std::size_t chunk) {
      const Part part = std::move(parts[chunk]);
      std::ranges::copy(part.sites, result_.sites.begin() + static_cast<std::ptrdiff_t>(corners[chunk]));
      std::ranges::copy(part.members, result_.members.begin() + static_cast<std::ptrdiff_t>(members[chunk]));
      for (std::size_t p = 0; p + 1 < part.site_offsets.size(); ++p) {
        const std::size_t polytope = polytopes[chunk] + p;
        result_.site_offsets[polytope + 1] = static_cast<std::uint32_t>(corners[chunk] + part.site_offsets[p + 1]);
        result_.member_offsets[polytope + 1] = static_cast<std::uint32_t>(members[chunk] + part.member_offsets[p + 1]);
        for (std::uint32_t m = part.member_offsets[p]; m < part.member_offsets[p + 1]; ++m)
          result_.polytope_of[part.members[m]] = static_cast<std::uint32_t>(polytope);
      }
    });
  }

  const Keep& keep_;
  std::span<const LatticePoint> sites_;
  const Predicates predicates_;
  const std::size_t range_;
  Context* context_;
  Polytopes result_;
  std::vector<std::uint32_t> begin_;  // per site: the first tetrahedron whose smallest corner it is
};

}  // namespace

Polytopes polytopes_of(const Keep& keep, std::unique_ptr<Delaunay> delaunay, std::span<const LatticePoint> sites,
                       Context* context, std::size_t range) {
  return Merger(keep, sites, delaunay->predicates(), range, context).run(std::move(delaunay));
}

Polytopes polytopes_inside(const VoxelShape& shape, std::unique_ptr<Delaunay> delaunay,
                           std::span<const LatticePoint> sites, Context* context, std::size_t range) {
  // The boundary faces and edges of O are Delaunay (Yan 2018, Thm. 2.4.1), so a tetrahedron is inside O or outside as
  // a whole, and the voxel that contains its centroid tells. A centroid between voxels is not a special case: it is not
  // on the boundary of O, so all voxels around it agree.
  const auto inside = [&shape, &points = delaunay->points()](std::uint32_t, const Tetrahedron& t) {
    std::int64_t x = 0, y = 0, z = 0;
    for (std::uint32_t c : t.corner) {
      const Point& p = points[c];
      x += p.x;
      y += p.y;
      z += p.z;
    }
    return shape.contains(x >> 2, y >> 2, z >> 2);
  };
  return polytopes_of(inside, std::move(delaunay), sites, context, range);
}

}  // namespace quench::delaunay
