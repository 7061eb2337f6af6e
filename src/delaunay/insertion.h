// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <vector>

#include "base/huge_pages.h"
#include "base/index.h"
#include "delaunay/predicates.h"

namespace quench::delaunay {


/// A tetrahedron of positive orientation. `neighbour[i]` lies across the facet opposite to corner i and is encoded as
/// 4 * tetrahedron + the index of that facet there; kNone on the hull of the enclosing box. 32 bytes. A dead slot has
/// corner[0] == kNone.
struct Tetrahedron {
  std::array<std::uint32_t, 4> corner;
  std::array<std::uint32_t, 4> neighbour;
};

/// The facet opposite to corner i, counter-clockwise seen from outside of a positively oriented tetrahedron.
inline constexpr std::uint32_t kFacet[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};

/// A triangulation that several inserters can work on at once.
struct Triangulation {
  Triangulation(const std::array<std::int64_t, 3>& spacing, std::int64_t extent) : predicates(spacing, extent) {}

  Predicates predicates;
  base::HugeVector<Point> points;
  base::RawHugeVector<Tetrahedron> tetrahedra;  ///< slots; `used` of them have been handed out
  base::RawHugeVector<std::uint8_t> owner;      ///< per slot: 0 free, else a mark of the inserter that holds it
  std::atomic<std::uint32_t> used{0};
  std::uint32_t settled = 0;  ///< slots below it have been written before several inserters started
  /// An inserter has failed and never releases what it owned: no other may wait for it. The triangulation is invalid
  /// then.
  std::atomic<bool> abandoned{false};

  bool conflicts(std::uint32_t tetrahedron, const Point& p) const {
    const auto& c = tetrahedra[tetrahedron].corner;
    return predicates.in_sphere(points[c[0]], points[c[1]], points[c[2]], points[c[3]], p) > 0;
  }
  /// Room for at least `slots` slots in all. No inserter may be running.
  void grow(std::size_t slots);
};

/// Numbers the corners of a cavity from 0, so that two of them are a place in a small table.
class LocalIndex {
 public:
  static constexpr std::uint32_t kCapacity = 64;

  void start() {
    count_ = 0;
    if (++round_ == 0) {  // after 2^32 rounds old marks would look current
      slots_.fill({});
      round_ = 1;
    }
  }
  /// Local indices >= kCapacity are invalid; callers fall back to the slow path.
  std::uint8_t of(std::uint32_t corner) {
    for (std::uint32_t i = corner * 0x9E3779B9u >> 24;; i = (i + 1) % kSlots) {
      Slot& slot = slots_[i];
      if (slot.round != round_) {
        if (count_ > kCapacity) return kCapacity;
        slot = {corner, round_, static_cast<std::uint8_t>(count_++)};
        return slot.index;
      }
      if (slot.corner == corner) return slot.index;
    }
  }
  bool all_valid() const { return count_ <= kCapacity; }

 private:
  static constexpr std::uint32_t kSlots = 256;  // 8 bits of the hash
  struct Slot {
    std::uint32_t corner = 0, round = 0;
    std::uint8_t index = 0;
  };
  std::array<Slot, kSlots> slots_{};
  std::uint32_t round_ = 0, count_ = 0;
};

/// Finds the edge that two facets of a cavity share: the first facet leaves its number at the edge, the second takes
/// it. For cavities of any size.
class EdgeTable {
 public:
  /// Forgets all edges and makes room for `edges` of them.
  void start(std::size_t edges);
  /// The value at the edge (a, b), a < b: kNone where it is met for the first time.
  std::uint32_t& at(std::uint32_t a, std::uint32_t b) {
    const std::uint64_t key = std::uint64_t{a} << 32 | b;
    for (std::uint64_t i = key * 0x9E3779B97F4A7C15ull >> shift_;; i = (i + 1) & (slots_.size() - 1)) {
      Slot& slot = slots_[i];
      if (slot.round != round_) {
        slot = {key, round_, kNone};
        return slot.value;
      }
      if (slot.key == key) return slot.value;
    }
  }

 private:
  struct Slot {
    std::uint64_t key = 0;
    std::uint32_t round = 0, value = kNone;
  };
  std::vector<Slot> slots_ = std::vector<Slot>(256);
  std::uint32_t round_ = 0;
  int shift_ = 56;
};

/// Inserts points by cavities (Bowyer-Watson).
///
/// With `kShared`, other inserters work on the same triangulation. A tetrahedron is read and changed only by the
/// inserter that owns it; an inserter owns its whole cavity and all tetrahedra around it before it changes anything, so
/// insertions happen one after the other in some order, and any order gives a triangulation of the same Delaunay
/// complex. No inserter waits while it owns anything: one that meets a tetrahedron of another gives up and tries again
/// later. Only the walk to the point reads what it does not own; it may miss the point, and its result is checked again
/// once it is owned.
template <bool kShared>
class Inserter {
 public:
  enum class Outcome { done, busy, full };

  /// `number`: of this inserter among those that share the triangulation, 0 to 126.
  Inserter(Triangulation& triangulation, std::uint32_t number)
      : triangulation_(triangulation),
        conflict_(static_cast<std::uint8_t>(2 * number + 1)),
        rim_mark_(static_cast<std::uint8_t>(2 * number + 2)),
        random_(number + 1) {}

  /// `busy`: another inserter is at work near the point, nothing was changed; `full`: no slots are left, nothing was
  /// changed (shared only). Once the triangulation is abandoned insert() still returns, but the outcome is meaningless.
  /// An exception (std::bad_alloc) leaves what the inserter owns as it is: the triangulation must be abandoned then.
  Outcome insert(std::uint32_t p);

 private:
  // The new tetrahedron on a facet of the cavity is its inner tetrahedron with corner `facet` replaced by the point.
  struct CavityFacet {
    std::array<std::uint32_t, 4> corner;
    std::uint32_t facet;
    std::uint32_t outside;
    std::uint32_t tetrahedron;          // the new one
    std::array<std::uint8_t, 4> local;  // of the corners
  };

  // What walks may read while it changes. A link is stored after the corners it leads to, and read before them.
  static std::uint32_t load(const std::uint32_t& value) {
    if constexpr (kShared)
      return std::atomic_ref<std::uint32_t>(const_cast<std::uint32_t&>(value)).load(std::memory_order_acquire);
    else
      return value;
  }
  static void store(std::uint32_t& place, std::uint32_t value) {
    if constexpr (kShared)
      std::atomic_ref<std::uint32_t>(place).store(value, std::memory_order_release);
    else
      place = value;
  }
  std::uint8_t owner(std::uint32_t t) const {
    if constexpr (kShared)
      return std::atomic_ref<std::uint8_t>(triangulation_.owner[t]).load(std::memory_order_relaxed);
    else
      return triangulation_.owner[t];
  }
  bool claim(std::uint32_t t);
  void give_back(std::uint32_t t);
  void give_back_all();

  std::uint32_t locate(const Point& target);
  std::array<std::uint8_t, 4> local_across(const Tetrahedron& t, const std::array<std::uint8_t, 4>& local,
                                           const Tetrahedron& other, std::uint32_t apex);
  bool find_cavity(const Point& point, std::uint32_t start);
  bool collect_slots();
  void fill_cavity(std::uint32_t p);
  void connect_few();
  void connect_many();

  Triangulation& triangulation_;
  const std::uint8_t conflict_, rim_mark_;
  std::vector<std::uint32_t> cavity_, rim_, free_;
  std::vector<std::array<std::uint8_t, 4>> cavity_local_;  // of the corners of cavity_
  std::vector<CavityFacet> facets_;
  LocalIndex local_index_;
  std::array<std::uint32_t, std::size_t{LocalIndex::kCapacity} * LocalIndex::kCapacity>
      at_edge_{};  // by two local indices
  EdgeTable table_;
  std::uint32_t hint_ = 0;
  std::uint32_t random_;
};

extern template class Inserter<false>;
extern template class Inserter<true>;

}  // namespace quench::delaunay
