// SPDX-License-Identifier: Apache-2.0
#include "dual/from_polytopes.h"

#include <algorithm>
#include <bit>
#include <memory>
#include <unordered_map>
#include <utility>
#include <vector>

#include "base/parallel.h"
#include "quench/error.h"

namespace quench::dual {
namespace {

using delaunay::Polytopes;
using delaunay::Tetrahedron;

// Hull and neighbours of each polytope, from its tetrahedra.
class Converter {
 public:
  // `first`: number of the first wanted polytope in the whole.
  Converter(const Polytopes& polytopes, std::span<const LatticePoint> sites, const PolytopeSelection& selection,
            Hulls& hulls, std::uint32_t first)
      : polytopes_(polytopes),
        sites_(sites),
        selection_(selection),
        hulls_(hulls),
        first_(first),
        rank_(std::make_unique_for_overwrite<std::uint32_t[]>(sites.size())) {}

  CellsPart run(std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      const auto polytope = static_cast<std::uint32_t>(p);
      if (number(polytope) == kNone) continue;
      if (polytopes_.sites_of(polytope).size() == 4)
        add_tetrahedron(polytope);
      else
        add(polytope);
    }
    return std::move(part_);
  }

 private:
  using Triangle = std::array<std::uint32_t, 3>;
  // What lies behind a triangle of the surface tells its facet: the wanted polytope there, which shares one facet with
  // this one; kPlane and the place of its plane in planes_ where there is none.
  static constexpr std::uint32_t kPlane = std::uint32_t{1} << 31;
  struct SurfaceTriangle {
    std::uint32_t behind;
    Triangle corner;  // ranks, counter-clockwise seen from outside
  };
  struct Facet {
    std::uint32_t behind;
    std::uint64_t corners;  // bits by rank
  };
  // A hull by the corners of its facets, and its facets in their order.
  struct Known {
    std::uint32_t hull;
    std::vector<std::uint32_t> facet;
  };

  std::uint32_t number(std::uint32_t polytope) const {
    return selection_.number.empty() ? polytope : selection_.number[polytope];
  }
  // Of the wanted polytope across a facet of a tetrahedron, in the whole.
  std::uint32_t number_across(std::uint32_t neighbour) const {
    if (neighbour == kNone) return kNone;
    const std::uint32_t across = number(polytopes_.polytope_of[neighbour >> 2]);
    return across == kNone ? kNone : first_ + across;
  }

  void add(std::uint32_t p) {
    collect_triangles(p);
    const std::size_t corners = polytopes_.sites_of(p).size();
    if (corners > Hulls::kMostCorners) {
      add(p, compute(corners));
      for (std::uint32_t f = 0; f < outlines_.size(); ++f) set_neighbour(p, f, outlines_[f].tag);
      return;
    }
    collect_facets();
    const auto [place, fresh] = known_.try_emplace(key_of_facets(p));
    Known& known = place->second;
    if (fresh) {
      known.hull = hulls_.find(key_);
      if (known.hull == kNone) known.hull = compute(corners);
      find_facets(known);
    }
    add(p, known.hull);
    for (std::size_t i = 0; i < facets_.size(); ++i) set_neighbour(p, known.facet[i], facets_[i].behind);
  }

  // The facets of a hull in the order of facets_.
  void find_facets(Known& known) const {
    const Hull& hull = hulls_[known.hull];
    known.facet.resize(facets_.size());
    for (std::uint32_t f = 0; f < hull.facets(); ++f) {
      const auto place = std::ranges::lower_bound(facets_, bits_of(hull.corners_of(f)), {}, &Facet::corners);
      known.facet[static_cast<std::size_t>(place - facets_.begin())] = f;
    }
  }
  static std::uint64_t bits_of(std::span<const std::uint32_t> corners) {
    std::uint64_t bits = 0;
    for (const std::uint32_t c : corners) bits |= std::uint64_t{1} << c;
    return bits;
  }

  void collect_triangles(std::uint32_t p) {
    triangles_.clear();
    planes_.clear();
    const auto corners = polytopes_.sites_of(p);
    for (std::uint32_t i = 0; i < corners.size(); ++i) rank_[corners[i]] = i;
    for (const std::uint32_t m : polytopes_.members_of(p)) {
      const Tetrahedron& t = polytopes_.tetrahedra[m];
      for (std::uint32_t i = 0; i < 4; ++i) {
        if (t.neighbour[i] != kNone && polytopes_.polytope_of[t.neighbour[i] >> 2] == p) continue;
        const auto& f = delaunay::kFacet[i];
        const Triangle sites{t.corner[f[0]], t.corner[f[1]], t.corner[f[2]]};
        const std::uint32_t across = number_across(t.neighbour[i]);
        SurfaceTriangle& triangle = triangles_.emplace_back();
        triangle.behind = across == kNone ? kPlane | plane_of(sites) : across;
        for (std::size_t j = 0; j < 3; ++j) triangle.corner[j] = rank_[sites[j]];
      }
    }
  }

  // Of triangles_, sorted by their corners.
  void collect_facets() {
    facets_.clear();
    for (const SurfaceTriangle& t : triangles_) {
      auto facet = std::ranges::find(facets_, t.behind, &Facet::behind);
      if (facet == facets_.end()) facet = facets_.insert(facet, {t.behind, 0});
      facet->corners |= bits_of(t.corner);
    }
    std::ranges::sort(facets_, {}, &Facet::corners);
  }

  // Seen from a corner off a facet, its corners run clockwise.
  const HullKey& key_of_facets(std::uint32_t p) {
    key_.clear();
    for (const Facet& facet : facets_) key_.push_back(facet.corners);
    const auto corner = [&](std::uint64_t set) {
      return point(polytopes_.sites_of(p)[static_cast<std::size_t>(std::countr_zero(set))]);
    };
    const std::uint64_t a = facets_[0].corners, b = a & (a - 1), c = b & (b - 1);
    key_.push_back(delaunay::orientation_determinant<std::int64_t>(corner(a), corner(b), corner(c), corner(~a)) < 0);
    return key_;
  }

  // The hull of triangles_, with its facets in outlines_.
  std::uint32_t compute(std::size_t corners) {
    std::ranges::sort(triangles_, {}, &SurfaceTriangle::behind);
    outlines_.clear();
    for (std::size_t begin = 0, end = 0; begin < triangles_.size(); begin = end) {
      while (end < triangles_.size() && triangles_[end].behind == triangles_[begin].behind) ++end;
      add_outline({triangles_.data() + begin, triangles_.data() + end});
    }
    sort_facets(outlines_);
    return hulls_.intern(static_cast<std::uint32_t>(corners), outlines_);
  }

  // The hull is known by the permutation that sorts the corners, and the order of the facets with it.
  void add_tetrahedron(std::uint32_t p) {
    const Tetrahedron& t = polytopes_.tetrahedra[polytopes_.members_of(p)[0]];
    std::array<std::uint32_t, 4> at{0, 1, 2, 3};
    std::size_t inversions = 0;
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = i + 1; j < 4; ++j) inversions += t.corner[i] > t.corner[j];
    std::ranges::sort(at, {}, [&](std::uint32_t i) { return t.corner[i]; });
    add(p, Hulls::kTetrahedron[inversions & 1]);
    for (std::uint32_t f = 0; f < 4; ++f) set_neighbour(p, f, number_across(t.neighbour[at[f]]));
  }

  void add(std::uint32_t p, std::uint32_t hull) {
    corners_.clear();
    for (const std::uint32_t s : polytopes_.sites_of(p))
      corners_.push_back(selection_.site.empty() ? s : selection_.site[s]);
    part_.cells.add(corners_, hull, hulls_[hull].facets());
  }

  // Of the polytope that was added last. `across`: as SurfaceTriangle::behind, or kNone.
  void set_neighbour(std::uint32_t p, std::uint32_t facet, std::uint32_t across) {
    std::uint32_t& neighbour = part_.cells.neighbours_of(part_.cells.count() - 1)[facet];
    const Hull& hull = hulls_[part_.cells.hull.back()];
    if (!(across & kPlane))
      neighbour = across;
    else if (selection_.on_boundary(key_of(hull, facet, polytopes_.sites_of(p))))
      neighbour = kBoundary;
    else
      part_.unmatched.push_back({key_of(hull, facet, corners_), first_ + number(p), facet});
  }

  delaunay::Point point(std::uint32_t s) const { return {sites_[s][0], sites_[s][1], sites_[s][2], s}; }

  std::uint32_t plane_of(const Triangle& triangle) {
    const auto same = std::ranges::find_if(planes_, [&](const Triangle& plane) {
      const delaunay::Point a = point(plane[0]), b = point(plane[1]), c = point(plane[2]);
      // Coordinates of sites differ by at most 2^20.
      return std::ranges::all_of(triangle, [&](std::uint32_t s) {
        return delaunay::orientation_determinant<std::int64_t>(a, b, c, point(s)) == 0;
      });
    });
    const auto place = static_cast<std::uint32_t>(same - planes_.begin());
    if (same == planes_.end()) planes_.push_back(triangle);
    return place;
  }

  // The outline of the triangles of a facet: the edges that only one of them has, end to end.
  void add_outline(std::span<const SurfaceTriangle> triangles) {
    edges_.clear();
    for (const SurfaceTriangle& t : triangles)
      for (std::size_t j = 0; j < 3; ++j) {
        const std::uint32_t from = t.corner[j], to = t.corner[(j + 1) % 3];
        const auto twin = std::ranges::find(edges_, std::pair{to, from});
        if (twin == edges_.end()) {
          edges_.emplace_back(from, to);
        } else {
          *twin = edges_.back();
          edges_.pop_back();
        }
      }
    HullFacet& facet = outlines_.emplace_back();
    facet.tag = triangles[0].behind;
    std::uint32_t at = edges_[0].first;
    while (!edges_.empty()) {
      facet.corners.push_back(at);
      const auto edge = std::ranges::find(edges_, at, &std::pair<std::uint32_t, std::uint32_t>::first);
      if (edge == edges_.end()) throw Error(ErrorCode::invariant, "a facet of a Delaunay polytope is not a polygon");
      at = edge->second;
      edges_.erase(edge);
    }
  }

  const Polytopes& polytopes_;
  std::span<const LatticePoint> sites_;
  const PolytopeSelection& selection_;
  Hulls& hulls_;
  const std::uint32_t first_;
  const std::unique_ptr<std::uint32_t[]> rank_;  // rank_[s]: of site s among the corners of the polytope
  CellsPart part_;
  std::vector<SurfaceTriangle> triangles_;
  std::vector<Triangle> planes_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges_;
  std::vector<std::uint32_t> corners_;  // of the polytope that was added last, among all sites
  std::vector<Facet> facets_;
  HullKey key_;
  std::unordered_map<HullKey, Known, HashOfWords> known_;
  std::vector<HullFacet> outlines_;
};

}  // namespace

void append(Polytopes polytopes, std::span<const LatticePoint> sites, const PolytopeSelection& selection, Hulls& hulls,
            CellsPart& whole, Context* context) {
  const std::size_t chunks = base::chunks_for(polytopes.count());
  std::vector<CellsPart> parts(chunks);
  base::for_chunks(chunks, context, "merge", 0.7, 0.75, [&](std::size_t chunk) {
    const auto [begin, end] = base::part_of(polytopes.count(), chunk, chunks);
    parts[chunk] = Converter(polytopes, sites, selection, hulls, whole.cells.count()).run(begin, end);
  });
  polytopes = {};
  append(parts, Numbers::final, whole);
}

}  // namespace quench::dual
