// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include "base/parallel.h"
#include "burning/burn_pass.h"
#include "burning/link.h"
#include "burning/polygon_view.h"
#include "burning/prefetch_ahead.h"
#include "burning/side_mask.h"
#include "quench/error.h"

namespace quench::burning {
namespace {

// Where the candidates for the parent of a state are: node k of a side of a polygon, and the state's own place in it.
struct Candidate {
  double value;  // when fire from there arrives
  std::uint32_t face, side, k;
  std::uint32_t own_side, own_k;
};
constexpr Candidate kNoCandidate{kNever, kNone, 0, 0, 0, 0};

// When states became possible parents, numbered in that order; kNone: not yet.
using DoneOrder = HugeVector<std::uint32_t>;

// Calls visit(candidate), which returns the best value so far, for the possible parents of a state: the nodes to which
// arcs lead from it and whose number is below that of the state. With `skip`, leaves out nodes that cannot be better:
// along a side, times change by at most the distance.
template <class Visit>
void scan(const BurnDomain& domain, const Times& time, const DoneOrder& order, std::uint32_t state, bool skip,
          const Visit& visit) {
  double best = kNever;
  const std::uint32_t end = order[state];
  for_each_place(domain, state, [&](const PolygonView& view, const Place& place) {
    const Point here = view.at(place.side, place.k);
    for_each_edge_arc(view, place, [&](std::uint32_t i, std::uint32_t k) {
      const std::uint32_t other = view.state(i, k);
      if (const double value = time[other] + view.side(i).spacing(); time[other] < best && order[other] < end)
        best = visit({value, view.face, i, k, place.side, place.k});
    });
    for_each_far_side(view, place, [&](std::uint32_t i, std::uint32_t first, std::uint32_t last) {
      std::uint32_t next = first;
      view.nodes(i, first, last, [&](std::uint32_t k, std::uint32_t other) {
        if (k < next || !(time[other] < best) || !(order[other] < end)) return;
        const double value = time[other] + distance(view.at(i, k), here);
        if (value < best || !skip) {
          best = visit({value, view.face, i, k, place.side, place.k});
        } else {
          next = k + static_cast<std::uint32_t>(
                         std::min<double>(last, (value - best) / (2.02 * view.side(i).spacing() + 1e-300)));
        }
      });
    });
  });
}

// The candidate from which fire would come first. Ties: the smaller face, then the first along its sides from the node
// on.
Candidate first_candidate(const BurnDomain& domain, const Times& time, const DoneOrder& order, std::uint32_t state) {
  Candidate best = kNoCandidate;
  scan(domain, time, order, state, true, [&](const Candidate& c) {
    if (c.value < best.value) best = c;
    return best.value;
  });
  return best;
}

using Chord = std::array<std::uint32_t, 2>;  // the places of its ends in the cycle of the polygon's nodes
bool cross(const Chord& a, const Chord& b) {
  const std::uint32_t low = std::min(a[0], a[1]), high = std::max(a[0], a[1]);
  const auto side = [&](std::uint32_t p) { return p == low || p == high ? 0 : p > low && p < high ? 1 : -1; };
  return side(b[0]) * side(b[1]) < 0;
}

// The burn sequence: the order in which sectors are removed from the links of their nodes. Once its sector has been
// removed, a node may be the parent of others in the polygons of that sector. The queue holds states with their times
// of the burn pass, or that of the first possible parent if this is later.
//
// Parents need the sequence, but the sequence hardly needs them: only where every chord to a possible parent crosses
// another does a state wait. So the sequence is made without them first, and they are sought afterwards, on all threads
// and polygon by polygon. If then all have parents and no chords cross, the result is that of seeking them on the way;
// else everything is done again that way.
class Sequence {
 public:
  Sequence(const BurnDomain& domain, const std::vector<char>& opened, const Times& time, BurnedSectors& result,
           bool with_parents)
      : domain_(domain),
        opened_(opened),
        time_(time),
        with_parents_(with_parents),
        parent_(result.parent),
        parent_face_(result.parent_face),
        rank_(result.rank),
        status_(time.size(), 0),
        done_order_(time.size(), kNone),
        unreached_(domain.complex.face_count(), SideMask::all()),
        blocked_in_(domain.complex.face_count(), 0),
        queue_(time.empty() ? 0 : *std::min_element(time.begin(), time.end()), domain.network.omega / 32) {
    parent_.assign(time.size(), kNone);
    parent_face_.assign(time.size(), kNone);
    rank_.assign(time.size(), kNone);
    for (std::uint32_t s = 0; s < time.size(); ++s)
      if (time[s] == kNever) status_[s] = kPocket;
    if (with_parents) reserve_chords();
  }

  void run(Context* context) {
    start();
    StateQueue::Entry entry;
    const auto stale = [&](const StateQueue::Entry& e) { return (status_[e.id] & kDone) != 0; };
    const double states = static_cast<double>(time_.size());
    const auto fetch = [&](std::uint32_t s) { base::prefetch(&status_[s]); };
    for (std::uint64_t popped = 0; queue_.pop(entry, stale, fetch);) {
      prefetch_ahead(queue_, domain_, time_, status_);
      if (stale(entry)) continue;
      if (popped++ % 4096 == 0)
        checkpoint(context, "burn", std::min(0.99, 0.8 + 0.2 * static_cast<double>(popped) / states));
      burn(entry.id, entry.key);
    }
    for (std::uint32_t s = 0; s < time_.size(); ++s)
      if (!(status_[s] & (kRemoved | kPocket)))
        throw Error(ErrorCode::invariant,
                    "a sector of the medial axis was reached by fire but has no place in the burn "
                    "sequence; this is a bug in Quench, please report it with the input");
  }

  // After a run without parents: seeks them. False if a state has none, or chords cross.
  bool find_parents() {
    std::atomic<bool> legal = true;
    base::for_indices(time_.size(), [&](std::size_t s) {
      if (!(status_[s] & kPrime)) return;
      const auto state = static_cast<std::uint32_t>(s);
      const Candidate best = first_candidate(domain_, time_, done_order_, state);
      parent_face_[s] = best.face;
      if (best.face == kNone)
        legal.store(false, std::memory_order_relaxed);
      else
        parent_[s] = PolygonView(domain_, best.face).place(best.side, best.k);  // its node further below
    });
    base::for_indices(domain_.complex.face_count(), [&](std::size_t f) {
      if (!draw_chords(static_cast<std::uint32_t>(f))) legal.store(false, std::memory_order_relaxed);
    });
    return legal;
  }

 private:
  enum : unsigned char {
    kRemoved = 1,  // from its link
    kDone = 2,     // its node may be a parent
    kQueued = 4,   // has been in the queue
    kBlocked = 8,  // popped, but every chord to a possible parent crossed another
    kPocket = 16,
    kPrime = 32,
  };

  // Free sectors are removed from their links before all others; their nodes may be parents from their times on.
  void start() {
    std::vector<std::uint32_t> stripped;
    for (std::uint32_t v = 0; v < domain_.complex.vertex_count; ++v) {
      const std::uint32_t first = load_vertex(v);
      stripped.clear();
      link_.strip(stripped);
      for (const std::uint32_t s : stripped) start_from_free_sector(first + s);
    }
    for (std::uint32_t e = 0; e < domain_.complex.edges.size(); ++e)
      if (domain_.network.degree(e) == 1)
        for (std::uint32_t s = domain_.network.state_base[e]; s < domain_.network.state_base[e + 1]; ++s)
          start_from_free_sector(s);
  }
  void start_from_free_sector(std::uint32_t state) {
    status_[state] |= kQueued;
    remove_from_link(state);
    queue_.push(time_[state], state);
  }

  // Sets link_ to what is left of the link of a vertex; returns the first state of the vertex.
  std::uint32_t load_vertex(std::uint32_t v) {
    const std::uint32_t first = domain_.network.vertex_base[v], count = domain_.network.vertex_base[v + 1] - first;
    removed_.resize(count);
    for (std::uint32_t s = 0; s < count; ++s) removed_[s] = (status_[first + s] & (kRemoved | kPocket)) != 0;
    link_.reset({domain_.links.ends.data() + first, count}, removed_);
    return first;
  }

  void remove_from_link(std::uint32_t state) {
    status_[state] |= kRemoved;
    rank_[state] = removed_count_++;
  }

  void burn(std::uint32_t state, double key) {
    if (status_[state] & kRemoved)  // a free sector
      propagate_to_polygons(state, key);
    else if (domain_.is_vertex(state))
      burn_at_vertex(state, key);
    else
      burn_on_edge(state, key);
  }

  // A sector on a cycle of the link is prime: it is removed, then all that become free. A bridge never is prime: it is
  // removed when it becomes free.
  void burn_at_vertex(std::uint32_t state, double key) {
    const std::uint32_t first = load_vertex(domain_.links.vertex_of[state]);
    if (!link_.on_cycle(state - first) || !make_prime(state)) return;
    stripped_.clear();
    link_.remove(state - first, stripped_);
    remove_from_link(state);
    propagate_to_polygons(state, key);
    for (const std::uint32_t s : stripped_) {
      remove_from_link(first + s);
      propagate_to_polygons(first + s, key);
    }
  }

  void burn_on_edge(std::uint32_t state, double key) {
    if (!make_prime(state)) return;
    remove_from_link(state);
    const std::uint32_t last = last_sector_beside(state);
    propagate_to_polygons(state, key);
    if (last == kNone) return;
    remove_from_link(last);
    propagate_to_polygons(last, key);
  }
  // The only sector that is left at the node of a removed state inside a seam: it is free now. kNone if there are more,
  // or none.
  std::uint32_t last_sector_beside(std::uint32_t state) const {
    const std::uint32_t e = domain_.edge_of(state), sectors = domain_.links.edges[e].sectors();
    if (sectors <= 1 || domain_.links.edges[e].pocket) return kNone;
    const std::uint32_t first = state - (state - domain_.network.state_base[e]) % sectors;
    std::uint32_t last = kNone;
    for (std::uint32_t s = first; s < first + sectors; ++s) {
      if (status_[s] & kRemoved) continue;
      if (last != kNone) return kNone;
      last = s;
    }
    return last;
  }

  // The node of a removed sector, as a parent of others.
  struct Parent {
    double now, time;  // time of the sequence; of the sector
    Point at;
  };

  // Relaxes the states for which the node of the removed sector is a candidate parent. The first such node of its
  // polygons queues a state; later ones need not look at it unless it is blocked.
  void propagate_to_polygons(std::uint32_t state, double now) {
    status_[state] |= kDone;
    done_order_[state] = done_count_++;
    const auto wanted = [&](std::uint32_t f) { return !unreached_[f].empty(); };
    for_each_place(domain_, state, wanted, [&](const PolygonView& view, const Place& place) {
      const Parent parent{now, time_[state], view.at(place.side, place.k)};
      for_each_edge_arc(view, place,
                        [&](std::uint32_t i, std::uint32_t k) { relax(view.state(i, k), parent, view, i, k); });
      // Face arcs lead to the nodes of all other sides; those of the node's own sides remain unreached.
      const std::uint32_t i = place.side, before = view.before(i), after = view.after(i);
      SideMask own = SideMask::none().with_side(i).with_corner(i).with_corner(after);
      if (place.is_corner()) own = own.with_side(before).with_corner(before);
      SideMask& unreached = unreached_[view.face];
      for (std::uint32_t s = 0; s < view.side_count(); ++s) {
        const bool on_before = place.is_corner() && s == before;
        if (unreached.has_corner(s) && s != i && s != after && !on_before)
          relax(view.side(s).corner_state, parent, view, s, 0);
        const std::uint32_t pieces = view.side(s).pieces;
        if (pieces > 1 && unreached.has_side(s) && s != i && !on_before)
          view.nodes(s, 1, pieces - 1, [&](std::uint32_t k, std::uint32_t t) { relax(t, parent, view, s, k); });
      }
      if (blocked_in_[view.face]) return;
      unreached = unreached & own;
      if (place.is_corner()) unreached = unreached.without_corner(i);
    });
  }

  void relax(std::uint32_t state, const Parent& parent, const PolygonView& view, std::uint32_t i, std::uint32_t k) {
    unsigned char& status = status_[state];
    if (status & (kRemoved | kPocket)) return;
    if (status & kQueued && !(status & kBlocked)) return;
    status = static_cast<unsigned char>((status | kQueued) & ~kBlocked);
    double key = std::max(time_[state], parent.now);
    // In the burn pass it burned because it became free. It will here, too, unless it is on a cycle when fire arrives.
    if (opened_[state]) key = std::max(key, parent.time + distance(view.at(i, k), parent.at));
    queue_.push(key, state);
  }

  // Makes a sector prime. False, and the state is blocked, when no parent is found for it: among the possible ones the
  // first whose chord crosses no earlier one.
  bool make_prime(std::uint32_t state) {
    status_[state] |= kPrime;
    if (!with_parents_) return true;
    Candidate best = first_candidate(domain_, time_, done_order_, state);
    if (best.face != kNone && crosses(best)) {
      candidates_.clear();
      scan(domain_, time_, done_order_, state, false, [&](const Candidate& c) {
        candidates_.push_back(c);
        return kNever;
      });
      std::stable_sort(candidates_.begin(), candidates_.end(),
                       [](const Candidate& a, const Candidate& b) { return a.value < b.value; });
      const auto free =
          std::find_if(candidates_.begin(), candidates_.end(), [&](const Candidate& c) { return !crosses(c); });
      best = free == candidates_.end() ? kNoCandidate : *free;
    }
    if (best.face == kNone) {
      status_[state] |= kBlocked;
      for_each_place(domain_, state, [&](const PolygonView& view, const Place&) {
        blocked_in_[view.face] = 1;
        unreached_[view.face] = SideMask::all();
      });
      return false;
    }
    const PolygonView view(domain_, best.face);
    parent_[state] = view.node(best.side, best.k);
    parent_face_[state] = best.face;
    std::size_t i = chord_base_[best.face];
    while (chords_[i][0] != kNone) ++i;
    chords_[i] = chord_of(view, best);
    return true;
  }

  static Chord chord_of(const PolygonView& view, const Candidate& c) {
    return {view.place(c.own_side, c.own_k), view.place(c.side, c.k)};
  }

  // The chords of a polygon are chords_[chord_base_[f]] up to the first unused one; at most one for each of its nodes.
  void reserve_chords() {
    chord_base_.reserve(domain_.complex.face_count() + 1);
    chord_base_.push_back(0);
    for (std::uint32_t f = 0; f < domain_.complex.face_count(); ++f) {
      std::uint64_t nodes = 0;
      for (const std::uint32_t e : domain_.complex.sides(f)) nodes += domain_.network.pieces[e];
      chord_base_.push_back(chord_base_.back() + nodes);
    }
    chords_.assign(chord_base_.back(), {kNone, kNone});
  }
  bool crosses(const Candidate& c) const {
    std::size_t i = chord_base_[c.face];
    const std::size_t end = chord_base_[c.face + 1];
    if (i == end || chords_[i][0] == kNone) return false;
    const Chord chord = chord_of(PolygonView(domain_, c.face), c);
    for (; i < end && chords_[i][0] != kNone; ++i)
      if (cross(chord, chords_[i])) return true;
    return false;
  }

  // Turns the places of parents in a polygon into nodes; false if two of its chords cross.
  bool draw_chords(std::uint32_t f) {
    const PolygonView view(domain_, f);
    std::vector<Chord> chords;
    std::vector<std::uint32_t> node_at;
    std::uint32_t place = 0;
    for (std::uint32_t i = 0; i < view.side_count(); ++i)
      for (std::uint32_t k = 0; k < view.side(i).pieces; ++k, ++place) {
        node_at.push_back(view.node(i, k));
        const std::uint32_t state = view.state(i, k);
        if (parent_face_[state] == f) chords.push_back({place, parent_[state]});
      }
    bool legal = true;
    for (std::size_t a = 0; a < chords.size(); ++a)
      for (std::size_t b = 0; b < a; ++b) legal &= !cross(chords[a], chords[b]);
    place = 0;
    for (std::uint32_t i = 0; i < view.side_count(); ++i)
      for (std::uint32_t k = 0; k < view.side(i).pieces; ++k) {
        const std::uint32_t state = view.state(i, k);
        if (parent_face_[state] == f) parent_[state] = node_at[parent_[state]];
      }
    return legal;
  }

  const BurnDomain& domain_;
  const std::vector<char>& opened_;
  const Times& time_;
  const bool with_parents_;
  std::vector<std::uint32_t>&parent_, &parent_face_, &rank_;
  std::uint32_t removed_count_ = 0, done_count_ = 0;
  HugeVector<unsigned char> status_;
  DoneOrder done_order_;
  std::vector<SideMask> unreached_;  // per polygon: nodes to which no face arc of a possible parent leads so far
  std::vector<char> blocked_in_;     // per polygon: it has a blocked state, and all of its nodes count as unreached
  std::vector<std::uint64_t> chord_base_;
  HugeVector<Chord> chords_;
  StateQueue queue_;
  Link link_;
  std::vector<char> removed_;
  std::vector<std::uint32_t> stripped_;
  std::vector<Candidate> candidates_;
};

}  // namespace

void order_pass(const BurnDomain& domain, const std::vector<char>& opened, const Times& time, BurnedSectors& result,
                Context* context) {
  {
    Sequence sequence(domain, opened, time, result, false);
    sequence.run(context);
    if (sequence.find_parents()) return;
  }
  Sequence(domain, opened, time, result, true).run(context);
}

}  // namespace quench::burning
