// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "burning/fire.h"
#include "burning/polygon_view.h"
#include "burning/prefetch_ahead.h"
#include "quench/error.h"

namespace quench::burning {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

// The burn sequence. A sector is *removed* from its node's link once, and from then on its node may be the parent of
// others in its polygons. Keys are times of the burn pass, but never before a possible parent; a bridge waits until one
// of its sides has opened.
class Sequence {
 public:
  Sequence(const Site& site, const std::vector<char>& opened, const Times& time, Burning& result)
      : site_(site),
        opened_(opened),
        time_(time),
        parent_(result.parent),
        parent_face_(result.parent_face),
        rank_(result.rank),
        status_(time.size(), 0),
        done_time_(time.size(), kNever),
        unoffered_(site.complex.face_count(), ~std::uint64_t{0}),
        offers_again_(site.complex.face_count(), 0),
        queue_(time.empty() ? 0 : *std::min_element(time.begin(), time.end()), site.network.omega / 32) {
    chord_base_.reserve(site.complex.face_count() + 1);
    chord_base_.push_back(0);
    for (std::uint32_t f = 0; f < site.complex.face_count(); ++f) {
      std::uint64_t nodes = 0;
      for (const std::uint32_t e : site.complex.sides(f)) nodes += site.network.pieces[e];
      chord_base_.push_back(chord_base_.back() + nodes);
    }
    chords_.assign(chord_base_.back(), {kNone, kNone});
    parent_.assign(time.size(), kNone);
    parent_face_.assign(time.size(), kNone);
    rank_.assign(time.size(), kNone);
    for (std::uint32_t s = 0; s < time.size(); ++s)
      if (time[s] == kNever) status_[s] = kPocket;
  }

  void run(Context* context) {
    start();
    StateQueue::Entry entry;
    const auto stale = [&](const StateQueue::Entry& e) { return (status_[e.id] & kDone) != 0; };
    const double states = static_cast<double>(time_.size());
    const auto fetch = [&](std::uint32_t s) { base::prefetch(&status_[s]); };
    for (std::uint64_t popped = 0; queue_.pop(entry, stale, fetch);) {
      prefetch_ahead(queue_, site_, done_time_);
      queue_.peek(12, [&](std::uint32_t s) { base::prefetch(&status_[s]); });
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

 private:
  enum : unsigned char {
    kRemoved = 1,  // from the link
    kDone = 2,     // in the sequence: may be a parent
    kOffered = 4,  // in the queue
    kBlocked = 8,  // popped, but no chord was free
    kPocket = 16,
  };

  // Open sectors are gone from their links before everything else; they enter the sequence at their time.
  void start() {
    std::vector<std::uint32_t> stripped;
    for (std::uint32_t v = 0; v < site_.complex.vertex_count; ++v) {
      const std::uint32_t first = load_vertex(v);
      stripped.clear();
      link_.strip(stripped);
      for (const std::uint32_t s : stripped) open(first + s);
    }
    for (std::uint32_t e = 0; e < site_.complex.edges.size(); ++e)
      if (site_.network.sides_of(e).size() == 1)
        for (std::uint32_t s = site_.network.state_base[e]; s < site_.network.state_base[e + 1]; ++s) open(s);
  }
  void open(std::uint32_t state) {
    status_[state] |= kOffered;
    leave(state);
    queue_.push(time_[state], state);
  }

  // The remaining link of a vertex into link_; returns the vertex' first state.
  std::uint32_t load_vertex(std::uint32_t v) {
    const std::uint32_t first = site_.network.vertex_base[v], count = site_.network.vertex_base[v + 1] - first;
    removed_.resize(count);
    for (std::uint32_t s = 0; s < count; ++s) removed_[s] = (status_[first + s] & (kRemoved | kPocket)) != 0;
    link_.reset({site_.links.ends.data() + first, count}, removed_);
    return first;
  }

  // From the link of its node.
  void leave(std::uint32_t state) {
    status_[state] |= kRemoved;
    rank_[state] = removed_count_++;
  }

  void burn(std::uint32_t state, double key) {
    if (status_[state] & kRemoved) {  // an open sector
      publish(state, key);
      return;
    }
    if (site_.is_vertex(state)) {
      const std::uint32_t first = load_vertex(site_.links.vertex_of[state]);
      // A bridge never becomes prime: it goes when one of its sides has opened.
      if (!link_.on_cycle(state - first)) return;
      if (!find_parent(state)) return;
      stripped_.clear();
      link_.remove(state - first, stripped_);
      leave(state);
      publish(state, key);
      for (const std::uint32_t s : stripped_) {
        leave(first + s);
        publish(first + s, key);
      }
      return;
    }
    if (!find_parent(state)) return;
    leave(state);
    const std::uint32_t e = site_.edge_of(state), sectors = site_.links.edges[e].sectors();
    std::uint32_t last = kNone;
    if (sectors > 1 && !site_.links.edges[e].pocket) {  // the last sheet goes with the last but one
      const std::uint32_t first = state - (state - site_.network.state_base[e]) % sectors;
      std::uint32_t left = 0;
      for (std::uint32_t s = first; s < first + sectors; ++s)
        if (!(status_[s] & kRemoved)) {
          ++left;
          last = s;
        }
      if (left != 1) last = kNone;
    }
    publish(state, key);
    if (last == kNone) return;
    leave(last);
    publish(last, key);
  }

  // A removed sector offers the states that may have its node as parent. A state is offered once, by the first such
  // node of its polygons; again only if it waits.
  void publish(std::uint32_t state, double now) {
    status_[state] |= kDone;
    done_time_[state] = time_[state];
    const auto wanted = [&](std::uint32_t f) { return unoffered_[f] != 0 || offers_again_[f]; };
    for_each_place(site_, state, wanted, [&](const PolygonView& view, const Place& place) {
      const std::uint32_t f = view.face, sides = view.side_count();
      std::uint64_t& left = unoffered_[f];
      const Offer from{now, time_[state], view.at(place.side, place.k)};
      const auto offer_range = [&](std::uint32_t i, std::uint32_t first, std::uint32_t last) {
        view.nodes(i, first, last, [&](std::uint32_t k, std::uint32_t s) { offer(s, from, view, i, k); });
      };
      for_each_edge_arc(view, place,
                        [&](std::uint32_t i, std::uint32_t k) { offer(view.state(i, k), from, view, i, k); });
      if (offers_again_[f] || sides > kMostTracked) {
        for_each_far_side(view, place, offer_range);
        return;
      }
      // Off the node's own sides everything; on them the two neighbours only.
      const std::uint32_t i = place.side, before = view.before(i);
      std::uint64_t own = side_bit(i) | corner_bit(i) | corner_bit(view.after(i));
      if (place.is_corner()) own |= side_bit(before) | corner_bit(before);
      const std::uint64_t offered = left & ~own;
      for (std::uint32_t s = 0; s < sides; ++s) {
        if (offered & corner_bit(s)) offer(view.side(s).corner_state, from, view, s, 0);
        if (offered & side_bit(s) && view.side(s).pieces > 1) offer_range(s, 1, view.side(s).pieces - 1);
      }
      left &= own & all_bits(sides);
      if (place.is_corner()) left &= ~corner_bit(i);
    });
  }
  // What is not offered yet of a polygon: a bit for the inside of every side, a bit for every corner.
  static constexpr std::size_t kMostTracked = 32;
  static std::uint64_t side_bit(std::size_t i) { return std::uint64_t{1} << (i % kMostTracked); }
  static std::uint64_t corner_bit(std::size_t i) { return std::uint64_t{1} << (i % kMostTracked + kMostTracked); }

  static std::uint64_t all_bits(std::uint32_t sides) {
    const std::uint64_t half = (std::uint64_t{1} << (sides % (kMostTracked + 1))) - 1;
    return half | half << kMostTracked;
  }

  struct Offer {
    double now, time;
    Point from;
  };
  void offer(std::uint32_t state, const Offer& by, const PolygonView& view, std::uint32_t i, std::uint32_t k) {
    unsigned char& status = status_[state];
    if (status & (kRemoved | kPocket)) return;
    if (status & kOffered && !(status & kBlocked)) return;
    status = static_cast<unsigned char>((status | kOffered) & ~kBlocked);
    double key = std::max(time_[state], by.now);
    // It opened by itself in the burn pass and will here, unless it is on a cycle when fire arrives.
    if (opened_[state]) key = std::max(key, by.time + distance(view.at(i, k), by.from));
    queue_.push(key, state);
  }

  struct Candidate {
    double value;
    std::uint32_t face, side, k;  // the parent: node k of a side of the polygon
    std::uint32_t own_side, own_k;
  };

  // The parent of a prime sector: among the nodes in the sequence the one from which fire would come first, whose chord
  // crosses none drawn so far. Ties: the smaller face, then the first met along its sides from the node on. False, and
  // the state is marked as waiting, when there is none.
  bool find_parent(std::uint32_t state) {
    Candidate best{kNever, kNone, 0, 0, 0, 0};
    scan(state, true, [&](const Candidate& c) {
      if (c.value < best.value) best = c;
      return best.value;
    });
    if (best.face != kNone && crosses(best)) {
      candidates_.clear();
      scan(state, false, [&](const Candidate& c) {
        candidates_.push_back(c);
        return kNever;
      });
      std::stable_sort(candidates_.begin(), candidates_.end(),
                       [](const Candidate& a, const Candidate& b) { return a.value < b.value; });
      const auto free =
          std::find_if(candidates_.begin(), candidates_.end(), [&](const Candidate& c) { return !crosses(c); });
      best = free == candidates_.end() ? Candidate{kNever, kNone, 0, 0, 0, 0} : *free;
    }
    if (best.face == kNone) {
      status_[state] |= kBlocked;
      for_each_place(site_, state, [&](const PolygonView& view, const Place&) { offers_again_[view.face] = 1; });
      return false;
    }
    const PolygonView view(site_, best.face);
    parent_[state] = node_of(view, best.side, best.k);
    parent_face_[state] = best.face;
    draw(view, best);
    return true;
  }

  // Calls visit(candidate), which returns the best value so far, for the nodes in the sequence that arcs of the state
  // lead to. With `skip`, leaves out nodes that cannot be better: times change by no more than distance along a side.
  template <class Visit>
  void scan(std::uint32_t state, bool skip, const Visit& visit) {
    double best = kNever;
    for_each_place(site_, state, [&](const PolygonView& view, const Place& place) {
      const Point here = view.at(place.side, place.k);
      for_each_edge_arc(view, place, [&](std::uint32_t i, std::uint32_t k) {
        const double done = done_time_[view.state(i, k)];
        if (done < best) best = visit({done + view.side(i).spacing(), view.face, i, k, place.side, place.k});
      });
      for_each_far_side(view, place, [&](std::uint32_t i, std::uint32_t first, std::uint32_t last) {
        std::uint32_t next = first;
        view.nodes(i, first, last, [&](std::uint32_t k, std::uint32_t other) {
          if (k < next) return;
          const double done = done_time_[other];
          if (!(done < best)) return;
          const double value = done + distance(view.at(i, k), here);
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
  std::uint32_t node_of(const PolygonView& view, std::uint32_t i, std::uint32_t k) const {
    const Polygons::Side& side = view.side(i);
    const std::uint32_t along = side.along_edge(k);
    if (along == 0) return site_.complex.edges[side.edge][0];
    if (along == side.pieces) return site_.complex.edges[side.edge][1];
    return site_.network.node_base[side.edge] + along - 1;
  }

  // Chords of a polygon lie in its stretch of chords_, as many as it has nodes at most: each is of another node.
  using Chord = std::array<std::uint32_t, 2>;
  bool crosses(const Candidate& c) const {
    std::size_t i = chord_base_[c.face];
    const std::size_t end = chord_base_[c.face + 1];
    if (i == end || chords_[i][0] == kNone) return false;
    const PolygonView view(site_, c.face);
    const std::uint32_t a = view.place(c.own_side, c.own_k), b = view.place(c.side, c.k);
    const std::uint32_t low = std::min(a, b), high = std::max(a, b);
    const auto side = [&](std::uint32_t p) { return p == low || p == high ? 0 : p > low && p < high ? 1 : -1; };
    for (; i < end && chords_[i][0] != kNone; ++i)
      if (side(chords_[i][0]) * side(chords_[i][1]) < 0) return true;
    return false;
  }
  void draw(const PolygonView& view, const Candidate& c) {
    std::size_t i = chord_base_[c.face];
    while (chords_[i][0] != kNone) ++i;
    chords_[i] = {view.place(c.own_side, c.own_k), view.place(c.side, c.k)};
  }

  const Site& site_;
  const std::vector<char>& opened_;
  const Times& time_;
  std::vector<std::uint32_t>& parent_;
  std::vector<std::uint32_t>&parent_face_, &rank_;
  std::uint32_t removed_count_ = 0;
  base::HugeVector<unsigned char> status_;
  Times done_time_;                       // of states in the sequence
  std::vector<std::uint64_t> unoffered_;  // per polygon
  std::vector<std::uint64_t> chord_base_;
  std::vector<char> offers_again_;  // per polygon: some of its states wait
  base::HugeVector<Chord> chords_;
  StateQueue queue_;
  Link link_;
  std::vector<char> removed_;
  std::vector<std::uint32_t> stripped_;
  std::vector<Candidate> candidates_;
};

}  // namespace

void order_pass(const Site& site, const std::vector<char>& opened, const Times& time, Burning& result,
                Context* context) {
  Sequence(site, opened, time, result).run(context);
}

}  // namespace quench::burning
