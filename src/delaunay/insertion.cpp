// SPDX-License-Identifier: Apache-2.0
#include "delaunay/insertion.h"

#include <algorithm>
#include <bit>

#include "base/prefetch.h"
#include "quench/error.h"

namespace quench::delaunay {

namespace {
constexpr std::uint32_t kBlock = 512;      // slots an inserter takes at a time
constexpr std::uint32_t kLongWalk = 1000;  // steps after which a walk among changing tetrahedra starts again
}  // namespace

void Triangulation::grow(std::size_t slots) {
  if (slots <= tetrahedra.size()) return;
  // 4 * slot + facet must fit 32 bits, with room for kNone.
  constexpr std::size_t kMost = std::size_t{1} << 30;
  if (slots >= kMost) {
    if (tetrahedra.size() + 1 >= kMost)
      throw Error(ErrorCode::failed, "more than 2^30 tetrahedra; use a lower resolution");
    slots = kMost - 1;
  }
  tetrahedra.resize(slots);
  owner.resize(slots);
}

void EdgeTable::start(std::size_t edges) {
  if (4 * edges > slots_.size()) {
    slots_.assign(std::bit_ceil(4 * edges), {});
    shift_ = 64 - std::countr_zero(slots_.size());
    round_ = 0;
  }
  if (++round_ == 0) {  // after 2^32 rounds old marks would look current
    std::fill(slots_.begin(), slots_.end(), Slot{});
    round_ = 1;
  }
}

// Claimed tetrahedra are on the rim until they prove to be in conflict.
template <bool kShared>
bool Inserter<kShared>::claim(std::uint32_t t) {
  if constexpr (kShared) {
    std::uint8_t free = 0;
    return std::atomic_ref<std::uint8_t>(triangulation_.owner[t])
        .compare_exchange_strong(free, rim_mark_, std::memory_order_acquire, std::memory_order_relaxed);
  } else {
    triangulation_.owner[t] = rim_mark_;
    return true;
  }
}

template <bool kShared>
void Inserter<kShared>::give_back(std::uint32_t t) {
  if constexpr (kShared)
    std::atomic_ref<std::uint8_t>(triangulation_.owner[t]).store(0, std::memory_order_release);
  else
    triangulation_.owner[t] = 0;
}

template <bool kShared>
void Inserter<kShared>::give_back_all() {
  for (const std::uint32_t t : rim_) give_back(t);
  for (const std::uint32_t t : cavity_) give_back(t);
}

template <bool kShared>
typename Inserter<kShared>::Outcome Inserter<kShared>::insert(std::uint32_t p) {
  const Point& point = triangulation_.points[p];
  const std::uint32_t start = locate(point);
  if (start == kNone) return Outcome::busy;
  if (!find_cavity(point, start)) {
    give_back_all();
    return Outcome::busy;
  }
  if (!collect_slots()) {
    give_back_all();
    return Outcome::full;
  }
  fill_cavity(p);
  return Outcome::done;
}

// Visibility walk; the facet tried first is random, so that it cannot cycle among the tetrahedra of a cospherical set.
// The tetrahedron found contains p, and p is none of its corners, so p is strictly inside its ball. Alone, that is the
// answer; beside others, it is checked again. kNone: the walk did not end among changing tetrahedra.
template <bool kShared>
std::uint32_t Inserter<kShared>::locate(const Point& target) {
  const auto& tetrahedra = triangulation_.tetrahedra;
  const auto& points = triangulation_.points;
  const std::uint32_t written = kShared ? triangulation_.settled : triangulation_.used.load(std::memory_order_relaxed);
  while (load(tetrahedra[hint_].corner[0]) == kNone) {  // another inserter replaced it
    random_ = random_ * 1664525u + 1013904223u;
    hint_ = static_cast<std::uint32_t>(std::uint64_t{random_} * written >> 32);
  }
  std::uint32_t current = hint_, from = kNone;
  for (std::uint32_t steps = 0;; ++steps) {
    const Tetrahedron& t = tetrahedra[current];
    std::array<std::uint32_t, 4> corner;
    for (int i = 0; i < 4; ++i) corner[i] = load(t.corner[i]);
    if constexpr (kShared)
      if (corner[0] == kNone || steps > kLongWalk) {
        hint_ = current;
        return kNone;
      }
    random_ = random_ * 1664525u + 1013904223u;
    const std::uint32_t first = random_ >> 30;
    std::uint32_t next = kNone;
    for (std::uint32_t k = 0; k < 4; ++k) {
      const std::uint32_t i = (first + k) & 3;
      const std::uint32_t across = load(t.neighbour[i]);
      if (across == from || across == kNone) continue;
      const auto& f = kFacet[i];
      // kFacet is counter-clockwise seen from outside, so a point beyond it makes a negative volume with it.
      if (triangulation_.predicates.orientation(points[corner[f[0]]], points[corner[f[1]]], points[corner[f[2]]],
                                                target) > 0) {
        next = i;
        from = 4 * current + i;
        current = across >> 2;
        break;
      }
    }
    if (next == kNone) return current;
  }
}

// The local indices of the corners of `other`, which shares all but its corner `apex` with `t`.
template <bool kShared>
std::array<std::uint8_t, 4> Inserter<kShared>::local_across(const Tetrahedron& t,
                                                            const std::array<std::uint8_t, 4>& local,
                                                            const Tetrahedron& other, std::uint32_t apex) {
  std::array<std::uint8_t, 4> result;
  for (std::uint32_t k = 0; k < 4; ++k) {
    std::uint32_t index = 0;  // without branches, which would not be predicted
    for (std::uint32_t i = 0; i < 4; ++i) index |= t.corner[i] == other.corner[k] ? local[i] : 0u;
    result[k] = static_cast<std::uint8_t>(index);
  }
  result[apex] = local_index_.of(other.corner[apex]);
  return result;
}

// Claims the cavity and what is around it. False: a part of it belongs to another inserter, or `start` is not in it.
template <bool kShared>
bool Inserter<kShared>::find_cavity(const Point& point, std::uint32_t start) {
  Triangulation& tri = triangulation_;
  cavity_.clear();
  cavity_local_.clear();
  rim_.clear();
  facets_.clear();
  local_index_.start();
  const auto mark_conflict = [&](std::uint32_t t) {
    if constexpr (kShared)
      std::atomic_ref<std::uint8_t>(tri.owner[t]).store(conflict_, std::memory_order_relaxed);
    else
      tri.owner[t] = conflict_;
    cavity_.push_back(t);
  };
  if (!claim(start)) return false;
  if constexpr (kShared)
    if (tri.tetrahedra[start].corner[0] == kNone || !tri.conflicts(start, point)) {
      rim_.push_back(start);
      return false;
    }
  mark_conflict(start);
  const auto& first = tri.tetrahedra[start].corner;
  cavity_local_.push_back(
      {local_index_.of(first[0]), local_index_.of(first[1]), local_index_.of(first[2]), local_index_.of(first[3])});
  for (std::size_t c = 0; c < cavity_.size(); ++c) {
    const Tetrahedron t = tri.tetrahedra[cavity_[c]];
    const std::array<std::uint8_t, 4> local = cavity_local_[c];
    for (std::uint32_t i = 0; i < 4; ++i) {
      const std::uint32_t outside = t.neighbour[i];
      if (outside != kNone) {
        const std::uint32_t n = outside >> 2;
        std::uint8_t mark = owner(n);
        if (mark != conflict_ && mark != rim_mark_) {
          if (mark != 0 || !claim(n)) return false;
          if (tri.conflicts(n, point)) {
            mark_conflict(n);
            for (const std::uint32_t around : tri.tetrahedra[n].neighbour)
              if (around != kNone) {
                base::prefetch(&tri.tetrahedra[around >> 2]);
                base::prefetch(&tri.owner[around >> 2]);
              }
            cavity_local_.push_back(local_across(t, local, tri.tetrahedra[n], outside & 3));
            mark = conflict_;
          } else {
            rim_.push_back(n);
          }
        }
        if (mark == conflict_) continue;
      }
      facets_.push_back({t.corner, i, outside, kNone, local});
    }
  }
  return true;
}

// A slot per facet: those of the cavity first. Slots that are not of the cavity are claimed too, since other
// walks may read them. False: there are none left.
template <bool kShared>
bool Inserter<kShared>::collect_slots() {
  const std::size_t missing = facets_.size() > cavity_.size() ? facets_.size() - cavity_.size() : 0;
  while (free_.size() < missing) {
    const std::uint32_t first = triangulation_.used.load(std::memory_order_relaxed);
    if constexpr (!kShared)
      triangulation_.grow(first + kBlock <= triangulation_.tetrahedra.size() ? 0 : first * 5 / 4 + kBlock);
    const std::uint32_t block = triangulation_.used.fetch_add(kBlock, std::memory_order_relaxed);
    if (std::size_t{block} + kBlock > triangulation_.tetrahedra.size()) {
      triangulation_.used.fetch_sub(kBlock, std::memory_order_relaxed);
      return false;
    }
    // Whole and harmless, whatever part of them a walk sees: corners that exist, no neighbours.
    for (std::uint32_t t = block + kBlock; t-- > block;) {
      triangulation_.tetrahedra[t] = {{kNone, 0, 0, 0}, {kNone, kNone, kNone, kNone}};
      triangulation_.owner[t] = 0;
      free_.push_back(t);
    }
  }
  for (std::size_t f = 0; f < facets_.size(); ++f) {
    if (f < cavity_.size()) {
      facets_[f].tetrahedron = cavity_[f];
      continue;
    }
    const std::uint32_t t = free_.back();
    free_.pop_back();
    if constexpr (kShared)
      while (!claim(t))  // another inserter may have claimed it at the end of a walk
        if (triangulation_.abandoned.load(std::memory_order_relaxed)) return false;
    facets_[f].tetrahedron = t;
  }
  return true;
}

template <bool kShared>
void Inserter<kShared>::fill_cavity(std::uint32_t p) {
  auto& tetrahedra = triangulation_.tetrahedra;
  for (const CavityFacet& f : facets_) {
    Tetrahedron& created = tetrahedra[f.tetrahedron];
    for (std::uint32_t i = 0; i < 4; ++i) store(created.corner[i], i == f.facet ? p : f.corner[i]);
    store(created.neighbour[f.facet], f.outside);
    if (f.outside != kNone) store(tetrahedra[f.outside >> 2].neighbour[f.outside & 3], 4 * f.tetrahedron + f.facet);
  }
  if (local_index_.all_valid())
    connect_few();
  else
    connect_many();
  hint_ = facets_.front().tetrahedron;
  for (std::size_t c = facets_.size(); c < cavity_.size(); ++c) {
    store(tetrahedra[cavity_[c]].corner[0], kNone);
    free_.push_back(cavity_[c]);
  }
  give_back_all();
  for (std::size_t f = cavity_.size(); f < facets_.size(); ++f) give_back(facets_[f].tetrahedron);
}

// Two new tetrahedra are neighbours exactly when their cavity facets share an edge. The cavity's surface is a sphere
// and consistently oriented, so each of its edges is met twice, once in either direction: all entries that are read
// have been written in this round.
template <bool kShared>
void Inserter<kShared>::connect_few() {
  auto& tetrahedra = triangulation_.tetrahedra;
  const auto at = [this](std::uint32_t a, std::uint32_t b) -> std::uint32_t& {
    return at_edge_[a * LocalIndex::kCapacity + b];
  };
  for (const CavityFacet& f : facets_) {
    const auto& corners = kFacet[f.facet];
    const std::uint32_t a = f.local[corners[0]], b = f.local[corners[1]], c = f.local[corners[2]];
    at(b, c) = 4 * f.tetrahedron + corners[0];
    at(c, a) = 4 * f.tetrahedron + corners[1];
    at(a, b) = 4 * f.tetrahedron + corners[2];
  }
  for (const CavityFacet& f : facets_) {
    const auto& corners = kFacet[f.facet];
    const std::uint32_t a = f.local[corners[0]], b = f.local[corners[1]], c = f.local[corners[2]];
    Tetrahedron& created = tetrahedra[f.tetrahedron];
    store(created.neighbour[corners[0]], at(c, b));
    store(created.neighbour[corners[1]], at(a, c));
    store(created.neighbour[corners[2]], at(b, a));
  }
}

template <bool kShared>
void Inserter<kShared>::connect_many() {
  auto& tetrahedra = triangulation_.tetrahedra;
  table_.start(facets_.size() * 3 / 2);
  for (const CavityFacet& f : facets_) {
    const auto& corners = kFacet[f.facet];
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t opposite = corners[k];  // the new facet without this corner, over the edge of the other two
      const std::uint32_t a = f.corner[corners[(k + 1) % 3]], b = f.corner[corners[(k + 2) % 3]];
      std::uint32_t& entry = table_.at(std::min(a, b), std::max(a, b));
      const std::uint32_t here = 4 * f.tetrahedron + opposite;
      if (entry == kNone) {
        entry = here;
      } else {
        store(tetrahedra[f.tetrahedron].neighbour[opposite], entry);
        store(tetrahedra[entry >> 2].neighbour[entry & 3], here);
      }
    }
  }
}

template class Inserter<false>;
template class Inserter<true>;

}  // namespace quench::delaunay
