// SPDX-License-Identifier: Apache-2.0
#include "peeling/remainder.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <numeric>
#include <utility>

#include "base/parallel.h"
#include "lattice/delaunay.h"
#include "lattice/polytopes.h"
#include "quench/error.h"

namespace quench::peeling {
namespace {

using lattice::Delaunay;
using lattice::Polytopes;
using lattice::Tetrahedron;

// Open facets by their triangles. A triangle is found by its smallest corner; sites are numbered as suits the user.
class OpenIndex {
 public:
  struct Found {
    std::uint32_t facet;  ///< kNone: none
    bool turns;           ///< the triangle runs counter-clockwise seen from the side that is not known
  };

  OpenIndex(const OpenFacets& open, std::vector<std::uint32_t> number) : open_(open), number_(std::move(number)) {
    const bool shared = base::several_threads();
    begin_.assign(number_.size() + 1, 0);
    each_entry([&](std::uint32_t site, const Entry&) { base::fetch_add(begin_[site + 1], 1u, shared); });
    lattice::prefix_sum(begin_);
    entries_.resize(begin_.back());
    std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
    each_entry(
        [&](std::uint32_t site, const Entry& entry) { entries_[base::fetch_add(next[site], 1u, shared)] = entry; });
  }

  Found find(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
    bool even = true;
    const auto order = [&even](std::uint32_t& i, std::uint32_t& j) {
      if (i < j) return;
      std::swap(i, j);
      even = !even;
    };
    order(a, b);
    order(b, c);
    order(a, b);
    for (std::uint32_t i = begin_[a]; i < begin_[a + 1]; ++i) {
      const Entry& entry = entries_[i];
      if (entry.second == b && entry.third == c) return {entry.facet >> 1, (entry.facet & 1) == even};
      if (entry.second != kNone) continue;
      const auto corners = open_[entry.facet];
      std::size_t at[3] = {corners.size(), corners.size(), corners.size()};
      for (std::size_t k = 0; k < corners.size(); ++k)
        for (std::size_t j = 0; j < 3; ++j)
          if (number_[corners[k]] == (j == 0 ? a : j == 1 ? b : c)) at[j] = k;
      if (at[1] == corners.size() || at[2] == corners.size()) continue;
      return {entry.facet, ((at[0] < at[1]) + (at[1] < at[2]) + (at[2] < at[0]) == 2) == even};
    }
    return {kNone, false};
  }

 private:
  // A triangle: its larger corners, and 2 * facet + 1 where (smallest, second, third) runs counter-clockwise. For
  // facets of many corners `second` is kNone, and the triangle's corners are looked up in the facet.
  struct Entry {
    std::uint32_t second, third, facet;
  };
  static constexpr std::size_t kFew = 6;

  template <class Visit>
  void each_entry(const Visit& visit) const {
    const std::size_t chunks = base::chunks_for(open_.count());
    tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
      const auto [first, last] = base::part_of(open_.count(), chunk, chunks);
      each_entry(first, last, visit);
    });
  }
  template <class Visit>
  void each_entry(std::size_t first, std::size_t last, const Visit& visit) const {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> sorted;  // corners and their places in the cycle
    for (auto f = static_cast<std::uint32_t>(first); f < last; ++f) {
      sorted.clear();
      for (const std::uint32_t s : open_[f]) sorted.emplace_back(number_[s], sorted.size());
      std::sort(sorted.begin(), sorted.end());
      for (std::size_t i = 0; i + 2 < sorted.size(); ++i) {
        if (sorted.size() > kFew) {
          visit(sorted[i].first, Entry{kNone, kNone, f});
          continue;
        }
        for (std::size_t j = i + 1; j + 1 < sorted.size(); ++j)
          for (std::size_t k = j + 1; k < sorted.size(); ++k) {
            const bool turns = (sorted[i].second < sorted[j].second) + (sorted[j].second < sorted[k].second) +
                                   (sorted[k].second < sorted[i].second) ==
                               2;
            visit(sorted[i].first, Entry{sorted[j].first, sorted[k].first, 2 * f + turns});
          }
      }
    }
  }

  const OpenFacets& open_;
  std::vector<std::uint32_t> number_;  // per site
  std::vector<std::uint32_t> begin_;
  std::vector<Entry> entries_;
};

class Remainder {
 public:
  Remainder(std::span<const LatticePoint> sites, const std::array<std::int64_t, 3>& spacing, OpenFacets open,
            Hulls& hulls, Cells& cells, Context* context)
      : all_(sites), spacing_(spacing), open_(std::move(open)), hulls_(hulls), cells_(cells), context_(context) {}

  void run() {
    if (open_.count() == 0) return;
    choose_sites();
    LatticePoint low = all_[0], high = all_[0];
    for (const auto& s : all_)
      for (std::size_t a = 0; a < 3; ++a) {
        low[a] = std::min(low[a], s[a]);
        high[a] = std::max(high[a], s[a]);
      }
    auto delaunay = std::make_unique<Delaunay>(sites_, spacing_, low, high, context_);
    const std::vector<std::uint8_t> mark = flood(*delaunay);
    const Polytopes polytopes =
        lattice::polytopes_of([&](std::uint32_t t, const Tetrahedron&) { return (mark[t] & kKept) != 0; },
                              std::move(delaunay), sites_, context_);
    std::vector<std::uint32_t> same(sites_.size());
    std::iota(same.begin(), same.end(), 0u);
    take(polytopes, OpenIndex(open_, std::move(same)));
  }

 private:
  static constexpr std::uint8_t kKept = 16;  // of the marks; the lower bits are facets that are open ones

  // The unfinished sites; from here on they are numbered among themselves, in the same order.
  void choose_sites() {
    std::vector<std::uint32_t> rank(all_.size() + 1, 0);
    base::for_indices(open_.corners.size(), [&](std::size_t i) {
      std::atomic_ref<std::uint32_t>(rank[open_.corners[i] + 1]).store(1, std::memory_order_relaxed);
    });
    lattice::prefix_sum(rank);
    sites_.resize(rank.back());
    names_.resize(rank.back());
    base::for_indices(all_.size(), [&](std::size_t s) {
      if (rank[s + 1] == rank[s]) return;
      sites_[rank[s]] = all_[s];
      names_[rank[s]] = static_cast<std::uint32_t>(s);
    });
    base::for_indices(open_.corners.size(), [&](std::size_t i) { open_.corners[i] = rank[open_.corners[i]]; });
  }

  [[noreturn]] static void leaves_shape() {
    throw Error(ErrorCode::invariant, "a cell of the voxel core reaches out of the shape");
  }

  // Which tetrahedra belong to missing cells.
  std::vector<std::uint8_t> flood(const Delaunay& delaunay) const {
    const auto& tetrahedra = delaunay.tetrahedra();
    const auto& points = delaunay.points();
    std::vector<std::uint32_t> place(sites_.size());
    base::for_indices(sites_.size(), [&](std::size_t p) {
      place[points[p + Delaunay::kBoxPoints].site] = static_cast<std::uint32_t>(p);
    });
    const OpenIndex index(open_, std::move(place));  // by points, since tetrahedra lie in memory as points do
    std::vector<std::uint8_t> mark(tetrahedra.size(), 0);
    const std::size_t chunks = base::chunks_for(tetrahedra.size());
    std::vector<std::vector<std::uint32_t>> seeds(chunks);
    const bool shared = base::several_threads();
    // Sets bits of a mark and returns what it was before.
    const auto set = [&](std::uint32_t t, std::uint32_t bits) {
      const auto more = static_cast<std::uint8_t>(bits);
      if (shared) return std::atomic_ref<std::uint8_t>(mark[t]).fetch_or(more, std::memory_order_relaxed);
      return std::exchange(mark[t], static_cast<std::uint8_t>(mark[t] | more));
    };
    const auto get = [&](std::uint32_t t) {
      return std::atomic_ref<std::uint8_t>(mark[t]).load(std::memory_order_relaxed);
    };
    base::for_chunks(chunks, context_, "merge", 0, 0.1, [&](std::size_t chunk) {
      const auto [first, last] = base::part_of(tetrahedra.size(), chunk, chunks);
      for (std::size_t t = first; t < last; ++t) {
        const auto& corner = tetrahedra[t].corner;
        if (corner[0] == kNone || Delaunay::touches_box(tetrahedra[t])) continue;
        for (std::uint32_t i = 0; i < 4; ++i) {
          const std::uint32_t neighbour = tetrahedra[t].neighbour[i], n = neighbour >> 2;
          // One of the two looks; n may touch the box, and then does not.
          if (n < t && !Delaunay::touches_box(tetrahedra[n])) continue;
          const auto& f = lattice::kFacet[i];
          const auto open = index.find(corner[f[0]] - Delaunay::kBoxPoints, corner[f[1]] - Delaunay::kBoxPoints,
                                       corner[f[2]] - Delaunay::kBoxPoints);
          if (open.facet == kNone) continue;
          // Seen from outside a tetrahedron its facets run counter-clockwise, so from inside they do not.
          const auto me = static_cast<std::uint32_t>(t), inner = open.turns ? n : me;
          if (inner != me && Delaunay::touches_box(tetrahedra[n])) leaves_shape();
          set(me, 1u << i);
          set(n, 1u << (neighbour & 3));
          if (set(inner, kKept) & kKept) continue;
          seeds[chunk].push_back(inner);
        }
      }
    });
    // Facets are all marked by now; who keeps a tetrahedron first goes on from there.
    base::for_chunks(chunks, context_, "merge", 0.1, 0.12, [&](std::size_t chunk) {
      std::vector<std::uint32_t> stack = std::move(seeds[chunk]);
      for (std::size_t step = 1; !stack.empty(); ++step) {
        if (step % 0x10000 == 0 && context_ && context_->cancelled()) return;  // for_chunks() throws
        const std::uint32_t t = stack.back();
        stack.pop_back();
        const std::uint32_t open = get(t);
        for (std::uint32_t i = 0; i < 4; ++i) {
          const std::uint32_t n = tetrahedra[t].neighbour[i] >> 2;
          if (open >> i & 1 || get(n) & kKept) continue;
          if (Delaunay::touches_box(tetrahedra[n])) leaves_shape();
          if (!(set(n, kKept) & kKept)) stack.push_back(n);
        }
      }
    });
    return mark;
  }

  // Cells of a range of polytopes; neighbours are numbered from `base` on.
  class Taker {
   public:
    Taker(Remainder& remainder, const Polytopes& polytopes, const OpenIndex& index, std::uint32_t base)
        : remainder_(remainder), polytopes_(polytopes), index_(index), base_(base), finder_(remainder.hulls_) {}

    Cells run(std::size_t first, std::size_t last) {
      for (std::size_t p = first; p < last; ++p) take(static_cast<std::uint32_t>(p));
      return std::move(cells_);
    }

   private:
    struct Triangle {
      std::uint32_t key;                    // the polytope behind it, or with kOpenBit the open facet
      std::array<std::uint32_t, 3> corner;  // ranks
    };
    static constexpr std::uint32_t kOpenBit = std::uint32_t{1} << 31;

    void take(std::uint32_t p) {
      const std::span<const std::uint32_t> corners(polytopes_.sites.data() + polytopes_.site_offsets[p],
                                                   polytopes_.sites.data() + polytopes_.site_offsets[p + 1]);
      if (corners.size() == 4) {
        take_tetrahedron(p, polytopes_.tetrahedra[polytopes_.members[polytopes_.member_offsets[p]]], corners);
        return;
      }
      triangles_.clear();
      for (std::uint32_t m = polytopes_.member_offsets[p]; m < polytopes_.member_offsets[p + 1]; ++m) {
        const Tetrahedron& t = polytopes_.tetrahedra[polytopes_.members[m]];
        for (std::uint32_t i = 0; i < 4; ++i) {
          const auto& f = lattice::kFacet[i];
          const std::array<std::uint32_t, 3> sites{t.corner[f[0]], t.corner[f[1]], t.corner[f[2]]};
          std::uint32_t key;
          if (t.neighbour[i] == kNone) {
            key = index_.find(sites[0], sites[1], sites[2]).facet;
            if (key == kNone) throw Error(ErrorCode::invariant, "a facet of the voxel core's dual stays open");
            key |= kOpenBit;
          } else {
            key = polytopes_.polytope_of[t.neighbour[i] >> 2];
            if (key == p) continue;
          }
          Triangle triangle{key, {}};
          for (std::size_t j = 0; j < 3; ++j)
            triangle.corner[j] = static_cast<std::uint32_t>(std::lower_bound(corners.begin(), corners.end(), sites[j]) -
                                                            corners.begin());
          triangles_.push_back(triangle);
        }
      }
      facets_.clear();
      std::sort(triangles_.begin(), triangles_.end(),
                [](const Triangle& a, const Triangle& b) { return a.key < b.key; });
      for (std::size_t begin = 0, end = 0; begin < triangles_.size(); begin = end) {
        while (end < triangles_.size() && triangles_[end].key == triangles_[begin].key) ++end;
        join({triangles_.data() + begin, triangles_.data() + end});
      }
      facets_.sort();
      names_.clear();
      for (const std::uint32_t s : corners) names_.push_back(remainder_.names_[s]);
      const std::uint32_t cell =
          cells_.add(names_, finder_.number_of(static_cast<std::uint32_t>(corners.size()), facets_), facets_.size());
      const auto neighbours = cells_.neighbours_of(cell);
      for (std::uint32_t f = 0; f < facets_.size(); ++f) {
        const std::uint32_t key = facets_.tag(f);
        neighbours[f] = key & kOpenBit ? remainder_.close(key & ~kOpenBit, base_ + p) : base_ + key;
      }
    }

    // Its hull is known by the permutation that sorts its corners, and the order of its facets with it.
    void take_tetrahedron(std::uint32_t p, const Tetrahedron& t, std::span<const std::uint32_t> corners) {
      std::array<std::uint32_t, 4> at{0, 1, 2, 3};
      std::size_t inversions = 0;
      for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = i + 1; j < 4; ++j) inversions += t.corner[i] > t.corner[j];
      std::sort(at.begin(), at.end(), [&](std::uint32_t i, std::uint32_t j) { return t.corner[i] < t.corner[j]; });
      names_.clear();
      for (const std::uint32_t s : corners) names_.push_back(remainder_.names_[s]);
      const std::uint32_t cell = cells_.add(names_, Hulls::kTetrahedron[inversions & 1], 4);
      const auto neighbours = cells_.neighbours_of(cell);
      for (std::size_t i = 0; i < 4; ++i) {
        const std::uint32_t n = t.neighbour[at[i]];
        if (n != kNone) {
          neighbours[i] = base_ + polytopes_.polytope_of[n >> 2];
          continue;
        }
        const auto& f = lattice::kFacet[at[i]];
        const std::uint32_t open = index_.find(t.corner[f[0]], t.corner[f[1]], t.corner[f[2]]).facet;
        if (open == kNone) throw Error(ErrorCode::invariant, "a facet of the voxel core's dual stays open");
        neighbours[i] = remainder_.close(open, base_ + p);
      }
    }

    // The outline of the triangles of a facet: the sides that only one of them has, end to end.
    void join(std::span<const Triangle> triangles) {
      if (triangles.size() == 1) {
        for (const std::uint32_t c : triangles[0].corner) facets_.corner(c);
      } else {
        sides_.clear();
        for (const Triangle& t : triangles)
          for (std::size_t j = 0; j < 3; ++j) {
            const std::array<std::uint32_t, 2> side{t.corner[j], t.corner[(j + 1) % 3]};
            const auto back = std::find(sides_.begin(), sides_.end(), std::array<std::uint32_t, 2>{side[1], side[0]});
            if (back == sides_.end()) {
              sides_.push_back(side);
            } else {
              *back = sides_.back();
              sides_.pop_back();
            }
          }
        const std::uint32_t start = sides_[0][0];
        std::uint32_t at = start;
        do {
          facets_.corner(at);
          const auto side = std::find_if(sides_.begin(), sides_.end(), [&](const auto& s) { return s[0] == at; });
          if (side == sides_.end()) throw Error(ErrorCode::invariant, "a facet of a Delaunay polytope is no polygon");
          at = (*side)[1];
          sides_.erase(side);
        } while (at != start);
        if (!sides_.empty()) throw Error(ErrorCode::invariant, "a facet of a Delaunay polytope is no polygon");
      }
      facets_.close(triangles[0].key);
    }

    Remainder& remainder_;
    const Polytopes& polytopes_;
    const OpenIndex& index_;
    const std::uint32_t base_;
    HullFinder finder_;
    Cells cells_;
    std::vector<Triangle> triangles_;
    std::vector<std::array<std::uint32_t, 2>> sides_;
    std::vector<std::uint32_t> names_;
    FacetList facets_;
  };

  // What the cell `by` has behind the open facet, which is closed now: each by one cell.
  std::uint32_t close(std::uint32_t facet, std::uint32_t by) {
    if (std::atomic_ref<std::uint8_t>(closed_[facet]).exchange(1, std::memory_order_relaxed))
      throw Error(ErrorCode::invariant, fmt::format("open facet {} of the voxel core's dual was closed twice", facet));
    const std::uint32_t cell = open_.cell[facet];
    if (cell == kNone) return kBoundary;
    cells_.neighbours_of(cell)[open_.facet[facet]] = by;
    return cell;
  }

  void take(const Polytopes& polytopes, const OpenIndex& index) {
    const std::uint32_t base = cells_.count();
    const std::size_t chunks = base::chunks_for(polytopes.count());
    std::vector<Cells> parts(chunks);
    closed_.assign(open_.count(), 0);
    base::for_chunks(chunks, context_, "merge", 0.7, 0.75, [&](std::size_t chunk) {
      const auto [first, last] = base::part_of(polytopes.count(), chunk, chunks);
      parts[chunk] = Taker(*this, polytopes, index, base).run(first, last);
    });
    if (const auto never = std::find(closed_.begin(), closed_.end(), 0); never != closed_.end())
      throw Error(ErrorCode::invariant,
                  fmt::format("open facet {} of the voxel core's dual was not closed", never - closed_.begin()));
    cells_.append(parts, Cells::Numbers::final);
  }

  std::span<const LatticePoint> all_;
  const std::array<std::int64_t, 3>& spacing_;
  OpenFacets open_;
  Hulls& hulls_;
  Cells& cells_;
  Context* context_;
  std::vector<LatticePoint> sites_;
  std::vector<std::uint32_t> names_;  // among all sites
  std::vector<std::uint8_t> closed_;  // per open facet
};

}  // namespace

OpenFacets joined(std::vector<OpenFacets>& parts) {
  OpenFacets all;
  for (OpenFacets& part : parts) {
    const auto shift = static_cast<std::uint32_t>(all.corners.size());
    lattice::check_index(all.corners.size() + part.corners.size());
    for (std::size_t i = 1; i < part.begin.size(); ++i) all.begin.push_back(shift + part.begin[i]);
    all.corners.insert(all.corners.end(), part.corners.begin(), part.corners.end());
    all.cell.insert(all.cell.end(), part.cell.begin(), part.cell.end());
    all.facet.insert(all.facet.end(), part.facet.begin(), part.facet.end());
    part = {};
  }
  return all;
}

void add_remainder(std::span<const LatticePoint> sites, const std::array<std::int64_t, 3>& spacing, OpenFacets open,
                   Hulls& hulls, Cells& cells, Context* context) {
  Remainder(sites, spacing, std::move(open), hulls, cells, context).run();
}

}  // namespace quench::peeling
