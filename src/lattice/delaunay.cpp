// SPDX-License-Identifier: Apache-2.0
#include "lattice/delaunay.h"

#include <fmt/format.h>

#include <cmath>
#include <unordered_map>

#include "lattice/site_order.h"

namespace quench::lattice {
namespace {

constexpr std::uint32_t kSmall = 64;  // cavities of more points link their tetrahedra through a hash map

constexpr std::uint8_t kUntouched = 0, kConflict = 1, kNoConflict = 2;

// The facet opposite to corner i, counter-clockwise seen from outside of a positively oriented tetrahedron.
constexpr std::uint32_t kFacet[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};

}  // namespace

Delaunay::Box Delaunay::enclosing_box(std::span<const LatticePoint> sites, const std::array<std::int64_t, 3>& spacing) {
  Box box{{0, 0, 0}, {0, 0, 0}, 0};
  std::array<std::int64_t, 3> sorted = spacing;
  std::sort(sorted.begin(), sorted.end());
  const double poke = 0.5 * std::sqrt(static_cast<double>(sorted[1] * sorted[1] + sorted[2] * sorted[2]));
  for (int a = 0; a < 3; ++a) {
    box.low[a] = box.high[a] = sites[0][a];
    for (const auto& s : sites) {
      box.low[a] = std::min<std::int64_t>(box.low[a], s[a]);
      box.high[a] = std::max<std::int64_t>(box.high[a], s[a]);
    }
    // spacing * voxels <= 2^20 on every axis, so poke < 2^20 and spacing * (difference of box corners) < 2^23.
    const auto margin = static_cast<std::int64_t>(std::ceil(poke / static_cast<double>(spacing[a]))) + 2;
    box.low[a] -= margin;
    box.high[a] += margin;
    box.extent = std::max(box.extent, box.high[a] - box.low[a]);
  }
  return box;
}

Delaunay::Delaunay(std::span<const LatticePoint> sites, const std::array<std::int64_t, 3>& spacing, Context* context)
    : Delaunay(sites, spacing, enclosing_box(sites, spacing), context) {}

Delaunay::Delaunay(std::span<const LatticePoint> sites, const std::array<std::int64_t, 3>& spacing, const Box& box,
                   Context* context)
    : predicates_(spacing, box.extent), pair_table_(kSmall * kSmall, kNone) {
  // 4 * tetrahedron must fit 32 bits; there are fewer than 7 tetrahedra per site on every shape met.
  if (sites.size() > (std::size_t{1} << 30) / 7)
    throw Error(ErrorCode::failed,
                fmt::format("{} boundary vertices are more than this version can triangulate at once "
                            "({}); use a lower resolution",
                            sites.size(), (1u << 30) / 7));
  const std::vector<std::uint32_t> order = insertion_order(sites);
  points_.reserve(sites.size() + kBoxPoints);
  for (std::uint32_t c = 0; c < kBoxPoints; ++c)
    points_.push_back({static_cast<std::int32_t>(c & 1 ? box.high[0] : box.low[0]),
                       static_cast<std::int32_t>(c & 2 ? box.high[1] : box.low[1]),
                       static_cast<std::int32_t>(c & 4 ? box.high[2] : box.low[2]), kNone});
  for (std::uint32_t i : order) points_.push_back({sites[i][0], sites[i][1], sites[i][2], i});
  local_.assign(points_.size(), kNone);
  tetrahedra_.reserve(sites.size() * 7 + 1000);
  state_.reserve(sites.size() * 7 + 1000);

  // The box cut into six tetrahedra around its diagonal 0-7, one per path of unit steps from corner 0 to corner 7;
  // neighbouring paths differ in one corner. Its corners are cospherical, so any triangulation is Delaunay.
  constexpr std::uint32_t kSteps[6][2] = {{1, 3}, {3, 2}, {2, 6}, {6, 4}, {4, 5}, {5, 1}};
  for (const auto& step : kSteps) tetrahedra_.push_back({{0, step[0], step[1], 7}, {kNone, kNone, kNone, kNone}});
  for (std::uint32_t t = 0; t < 6; ++t) {
    // Across the facet without its first step corner lies the next one around the diagonal.
    const std::uint32_t next = (t + 1) % 6;
    tetrahedra_[t].neighbour[1] = 4 * next + 2;
    tetrahedra_[next].neighbour[2] = 4 * t + 1;
  }
  for (Tetrahedron& t : tetrahedra_)
    if (predicates_.orientation(points_[t.corner[0]], points_[t.corner[1]], points_[t.corner[2]],
                                points_[t.corner[3]]) < 0)
      throw Error(ErrorCode::invariant, "the enclosing box is cut wrongly");
  state_.assign(tetrahedra_.size(), kUntouched);

  const auto count = static_cast<std::uint32_t>(points_.size());
  for (std::uint32_t p = kBoxPoints; p < count; ++p) {
    if ((p & 0x3FFF) == 0) checkpoint(context, "delaunay", static_cast<double>(p) / count);
    insert(p);
  }
  checkpoint(context, "delaunay", 1);
}

void Delaunay::insert(std::uint32_t p) {
  find_cavity(p, locate(p));
  fill_cavity(p);
}

// Visibility walk; the facet tried first is random, so that it cannot cycle among the tetrahedra of a cospherical set.
// The tetrahedron found contains p, and p is none of its corners, so p is strictly inside its ball.
std::uint32_t Delaunay::locate(std::uint32_t p) {
  const Point& target = points_[p];
  std::uint32_t current = hint_, from = kNone;
  for (;;) {
    const Tetrahedron& t = tetrahedra_[current];
    random_ = random_ * 1664525u + 1013904223u;
    const std::uint32_t first = random_ >> 30;
    std::uint32_t next = kNone;
    for (std::uint32_t k = 0; k < 4; ++k) {
      const std::uint32_t i = (first + k) & 3;
      if (t.neighbour[i] == from || t.neighbour[i] == kNone) continue;
      const auto& f = kFacet[i];
      // kFacet is counter-clockwise seen from outside, so a point beyond it makes a negative volume with it.
      if (predicates_.orientation(points_[t.corner[f[0]]], points_[t.corner[f[1]]], points_[t.corner[f[2]]], target) >
          0) {
        next = i;
        break;
      }
    }
    if (next == kNone) return current;
    from = 4 * current + next;
    current = t.neighbour[next] >> 2;
  }
}

void Delaunay::find_cavity(std::uint32_t p, std::uint32_t start) {
  const Point point = points_[p];
  cavity_.clear();
  rim_.clear();
  facets_.clear();
  cavity_.push_back(start);
  state_[start] = kConflict;
  for (std::size_t c = 0; c < cavity_.size(); ++c) {
    const Tetrahedron t = tetrahedra_[cavity_[c]];
    for (std::uint32_t i = 0; i < 4; ++i) {
      const std::uint32_t outside = t.neighbour[i];
      if (outside != kNone) {
        const std::uint32_t n = outside >> 2;
        if (state_[n] == kUntouched) {
          if (conflicts(n, point)) {
            state_[n] = kConflict;
            cavity_.push_back(n);
          } else {
            state_[n] = kNoConflict;
            rim_.push_back(n);
          }
        }
        if (state_[n] == kConflict) continue;
      }
      facets_.push_back({t.corner, i, outside, kNone});
    }
  }
  for (std::uint32_t t : rim_) state_[t] = kUntouched;
  for (std::uint32_t t : cavity_) state_[t] = kUntouched;
}

void Delaunay::fill_cavity(std::uint32_t p) {
  cavity_points_.clear();
  std::size_t reused = 0;
  for (CavityFacet& f : facets_) {
    std::uint32_t t;
    if (reused < cavity_.size()) {
      t = cavity_[reused++];
    } else if (!free_.empty()) {
      t = free_.back();
      free_.pop_back();
    } else {
      t = static_cast<std::uint32_t>(tetrahedra_.size());
      if (t >= kNone / 4) throw Error(ErrorCode::failed, "more than 2^30 tetrahedra; use a lower resolution");
      tetrahedra_.emplace_back();
      state_.push_back(kUntouched);
    }
    f.tetrahedron = t;
    Tetrahedron& created = tetrahedra_[t];
    created.corner = f.corner;
    created.corner[f.facet] = p;
    created.neighbour[f.facet] = f.outside;
    if (f.outside != kNone) tetrahedra_[f.outside >> 2].neighbour[f.outside & 3] = 4 * t + f.facet;
    for (std::uint32_t i = 0; i < 4; ++i)
      if (i != f.facet && local_[f.corner[i]] == kNone) {
        local_[f.corner[i]] = static_cast<std::uint32_t>(cavity_points_.size());
        cavity_points_.push_back(f.corner[i]);
      }
  }
  for (; reused < cavity_.size(); ++reused) {
    free_.push_back(cavity_[reused]);
    tetrahedra_[cavity_[reused]].corner[0] = kNone;
  }

  if (cavity_points_.size() <= kSmall) {
    link_new_tetrahedra(
        [this](std::uint32_t a, std::uint32_t b) -> std::uint32_t& { return pair_table_[a * kSmall + b]; });
  } else {
    std::unordered_map<std::uint64_t, std::uint32_t> table;
    table.reserve(facets_.size() * 2);
    link_new_tetrahedra([&table](std::uint32_t a, std::uint32_t b) -> std::uint32_t& {
      return table.try_emplace(static_cast<std::uint64_t>(a) << 32 | b, kNone).first->second;
    });
  }
  for (std::uint32_t v : cavity_points_) local_[v] = kNone;
  hint_ = facets_.front().tetrahedron;
}

// Two new tetrahedra are neighbours exactly when their cavity facets share an edge. The cavity's surface is a sphere
// and consistently oriented, so each of its edges is met twice; the table holds the first.
template <class Table>
void Delaunay::link_new_tetrahedra(Table&& table) {
  for (const CavityFacet& f : facets_) {
    const auto& corners = kFacet[f.facet];
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t opposite = corners[k];  // the new facet without this corner, over the edge of the other two
      std::uint32_t a = local_[f.corner[corners[(k + 1) % 3]]], b = local_[f.corner[corners[(k + 2) % 3]]];
      if (a > b) std::swap(a, b);
      std::uint32_t& entry = table(a, b);
      const std::uint32_t here = 4 * f.tetrahedron + opposite;
      if (entry == kNone) {
        entry = here;
      } else {
        tetrahedra_[f.tetrahedron].neighbour[opposite] = entry;
        tetrahedra_[entry >> 2].neighbour[entry & 3] = here;
        entry = kNone;
      }
    }
  }
}

void Delaunay::validate() const {
  const auto fail = [](std::size_t t, const char* what) {
    throw Error(ErrorCode::invariant, fmt::format("Delaunay: tetrahedron {} {}", t, what));
  };
  for (std::size_t t = 0; t < tetrahedra_.size(); ++t) {
    const Tetrahedron& tet = tetrahedra_[t];
    if (tet.corner[0] == kNone) continue;
    const auto& c = tet.corner;
    if (predicates_.orientation(points_[c[0]], points_[c[1]], points_[c[2]], points_[c[3]]) <= 0)
      fail(t, "is not positive");
    for (std::uint32_t i = 0; i < 4; ++i) {
      if (tet.neighbour[i] == kNone) continue;
      const Tetrahedron& other = tetrahedra_[tet.neighbour[i] >> 2];
      const std::uint32_t j = tet.neighbour[i] & 3;
      if (other.corner[0] == kNone) fail(t, "has a dead neighbour");
      if (other.neighbour[j] != 4 * t + i) fail(t, "has a neighbour that does not know it");
      std::array<std::uint32_t, 4> mine = c, theirs = other.corner;
      mine[i] = theirs[j] = kNone;
      std::sort(mine.begin(), mine.end());
      std::sort(theirs.begin(), theirs.end());
      if (mine != theirs) fail(t, "and its neighbour do not share a facet");
      if (conflicts(static_cast<std::uint32_t>(t), points_[other.corner[j]])) fail(t, "has a site inside its ball");
    }
  }
}

}  // namespace quench::lattice
