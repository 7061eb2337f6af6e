// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "burn/fire.h"
#include "burn/places.h"
#include "quench/error.h"

namespace quench::burning {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

// The burn sequence. A sector is *removed* from its node's link once, and from then on may be the parent of others in
// its polygons.
class Sequence {
 public:
  Sequence(const Site& site, const std::vector<char>& opened, std::vector<double>& time,
           std::vector<std::uint32_t>& parent, std::vector<std::uint32_t>& parent_face)
      : site_(site),
        opened_(opened),
        time_(time),
        parent_(parent),
        parent_face_(parent_face),
        status_(time.size(), 0),
        done_time_(time.size(), kNever),
        unoffered_(site.complex.face_count(), ~std::uint64_t{0}),
        offers_again_(site.complex.face_count(), 0),
        queue_(time.empty() ? 0 : *std::min_element(time.begin(), time.end()), site.network.omega / 4),
        views_(site) {
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
    for (std::uint32_t s = 0; s < time.size(); ++s)
      if (opened_[s]) {
        if (best_key_.empty()) best_key_.assign(time.size(), kNever);
        for_each_place(site_, s, views_, [&](const PolygonView& view, const Place&) { offers_again_[view.face] = 1; });
      }
  }

  void run(Context* context) {
    start();
    LabelQueue::Entry entry;
    const auto stale = [&](const LabelQueue::Entry& e) { return (status_[e.state] & kDone) != 0; };
    const double states = static_cast<double>(time_.size());
    for (std::uint64_t popped = 0; queue_.pop(entry, stale);) {
      if (stale(entry)) continue;
      if (popped++ % 4096 == 0)
        checkpoint(context, "burn", std::min(0.99, 0.8 + 0.2 * static_cast<double>(popped) / states));
      burn(entry.state, entry.time);
    }
    for (std::uint32_t s = 0; s < time_.size(); ++s)
      if (!(status_[s] & kRemoved) && time_[s] < kNever)
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
    status_[state] |= kRemoved | kOffered;
    queue_.push(time_[state], state);
  }

  // The remaining link of a vertex into link_; returns the vertex' first state.
  std::uint32_t load_vertex(std::uint32_t v) {
    const std::uint32_t first = site_.network.vertex_base[v], count = site_.network.vertex_base[v + 1] - first;
    removed_.resize(count);
    for (std::uint32_t s = 0; s < count; ++s)
      removed_[s] = (status_[first + s] & kRemoved) || time_[first + s] == kNever;  // gone, or a pocket
    link_.reset({site_.links.ends.data() + first, count}, removed_);
    return first;
  }

  void burn(std::uint32_t state, double key) {
    if (status_[state] & kRemoved) {  // an open sector
      publish(state);
      return;
    }
    if (site_.is_vertex(state)) {
      const std::uint32_t first = load_vertex(site_.links.vertex_of[state]);
      // A bridge never becomes prime: it goes when one of its sides has opened.
      if (!link_.on_cycle(state - first)) return;
      if (!find_parent(state)) return;
      stripped_.clear();
      link_.remove(state - first, stripped_);
      remove(state, key);
      publish(state);
      for (const std::uint32_t s : stripped_) {
        remove(first + s, key);
        publish(first + s);
      }
      return;
    }
    if (!find_parent(state)) return;
    remove(state, key);
    const std::uint32_t e = site_.edge_of(state), sectors = site_.links.edges[e].sectors;
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
    publish(state);
    if (last == kNone) return;
    remove(last, key);
    publish(last);
  }

  void remove(std::uint32_t state, double key) {
    status_[state] |= kRemoved;
    time_[state] = key;
  }

  // A removed sector offers the states that may have its node as parent. A state is offered once, by the first such
  // node of its polygons; again only if it waits, or opened by itself in the burn pass.
  void publish(std::uint32_t state) {
    status_[state] |= kDone;
    const double now = done_time_[state] = time_[state];
    const auto wanted = [&](std::uint32_t f) { return unoffered_[f] != 0 || offers_again_[f]; };
    for_each_place(site_, state, views_, wanted, [&](const PolygonView& view, const Place& place) {
      const std::uint32_t f = view.face;
      std::uint64_t& left = unoffered_[f];
      const Vec3 here = view.sides[place.side].at(place.k);
      const auto offer_one = [&](const Side& side, std::uint32_t k) { offer(side.state(k), now, side, k, here); };
      if (offers_again_[f] || view.sides.size() > kMostTracked) {
        for_each_arc(view, place, offer_one);
        return;
      }
      // Off the node's own sides everything; on them the two neighbours only.
      for_each_edge_arc(view, place, offer_one);
      const std::size_t i = place.side, next = view.side_after(i), before = view.side_before(i);
      std::uint64_t own = side_bit(i) | corner_bit(i) | corner_bit(next);
      if (place.is_corner()) own |= side_bit(before) | corner_bit(before);
      for (std::size_t s = 0; s < view.sides.size(); ++s) {
        if ((left & ~own & corner_bit(s)) != 0) offer_one(view.sides[s], 0);
        if ((left & ~own & side_bit(s)) != 0)
          for (std::uint32_t k = 1; k < view.sides[s].pieces; ++k) offer_one(view.sides[s], k);
      }
      left &= own;
      if (place.is_corner()) left &= ~corner_bit(i);
    });
  }
  // What is not offered yet of a polygon: a bit for the inside of every side, a bit for every corner.
  static constexpr std::size_t kMostTracked = 32;
  static std::uint64_t side_bit(std::size_t i) { return std::uint64_t{1} << (i % kMostTracked); }
  static std::uint64_t corner_bit(std::size_t i) { return std::uint64_t{1} << (i % kMostTracked + kMostTracked); }

  void offer(std::uint32_t state, double now, const Side& side, std::uint32_t k, const Vec3& from) {
    unsigned char& status = status_[state];
    if (status & kRemoved || time_[state] == kNever) return;
    if (opened_[state]) {
      // It opened by itself in the burn pass; should it be on a cycle now, its own arrival is its time.
      const double key = std::max(time_[state], now + (side.at(k) - from).norm());
      if (!(key < best_key_[state]) && !(status & kBlocked)) return;
      best_key_[state] = std::min(key, best_key_[state]);
      status = static_cast<unsigned char>((status | kOffered) & ~kBlocked);
      queue_.push(std::max(best_key_[state], now), state);
      return;
    }
    if (status & kOffered && !(status & kBlocked)) return;
    status = static_cast<unsigned char>((status | kOffered) & ~kBlocked);
    queue_.push(std::max(time_[state], now), state);
  }

  struct Candidate {
    double value;
    std::uint32_t face, node, own_place, place;  // places on the polygon's boundary
  };

  // The parent of a prime sector: among the nodes in the sequence the one from which fire would come first, whose chord
  // crosses none drawn so far. False, and the state is marked as waiting, when there is none.
  bool find_parent(std::uint32_t state) {
    Candidate best{kNever, kNone, kNone, 0, 0};
    const auto better = [](const Candidate& a, const Candidate& b) {
      if (a.value != b.value) return a.value < b.value;
      return a.face != b.face ? a.face < b.face : a.place < b.place;
    };
    scan(state, true, [&](const Candidate& c) {
      if (better(c, best)) best = c;
      return best.value;
    });
    if (best.face != kNone && crosses(best)) {
      candidates_.clear();
      scan(state, false, [&](const Candidate& c) {
        candidates_.push_back(c);
        return kNever;
      });
      std::sort(candidates_.begin(), candidates_.end(), better);
      const auto free =
          std::find_if(candidates_.begin(), candidates_.end(), [&](const Candidate& c) { return !crosses(c); });
      best = free == candidates_.end() ? Candidate{kNever, kNone, kNone, 0, 0} : *free;
    }
    if (best.face == kNone) {
      status_[state] |= kBlocked;
      for_each_place(site_, state, views_,
                     [&](const PolygonView& view, const Place&) { offers_again_[view.face] = 1; });
      return false;
    }
    parent_[state] = best.node;
    parent_face_[state] = best.face;
    draw(best);
    return true;
  }

  // Calls visit(candidate), which returns the best value so far, for the nodes in the sequence that arcs of the state
  // lead to. With `skip`, leaves out nodes that cannot be better: times change by no more than distance along a side.
  template <class Visit>
  void scan(std::uint32_t state, bool skip, const Visit& visit) {
    for_each_place(site_, state, views_, [&](const PolygonView& view, const Place& place) {
      const Vec3 here = view.sides[place.side].at(place.k);
      const std::uint32_t own = view.sides[place.side].before + place.k;
      double best = kNever;
      const auto consider = [&](const Side& side, std::uint32_t k) {
        const std::uint32_t other = side.state(k);
        if (done_time_[other] == kNever) return -1.0;
        const double value = done_time_[other] + (side.at(k) - here).norm();
        const std::uint32_t at = side.before + k;
        best = visit({value, view.face, node_of(side, k), own, at == view.nodes ? 0 : at});
        return value;
      };
      for_each_edge_arc(view, place, consider);
      for_each_far_side(view, place, [&](const Side& side, std::uint32_t first, std::uint32_t last) {
        const double reach = 2.02 * side.spacing();
        for (std::uint32_t k = first; k <= last;) {
          const double value = consider(side, k);
          std::uint32_t step = 1;
          if (skip && value > best && reach > 0)
            step = std::max(1u, static_cast<std::uint32_t>(std::min<double>(last, (value - best) / reach)));
          k += step;
        }
      });
    });
  }
  std::uint32_t node_of(const Side& side, std::uint32_t k) const {
    if (k == 0) return site_.complex.face_vertices[side.corner];
    if (k == side.pieces) {
      const auto e = site_.complex.edges[side.edge];
      return side.forward ? e[1] : e[0];
    }
    return site_.network.node_base[side.edge] + side.along_edge(k) - 1;
  }

  // Chords of a polygon lie in its stretch of chords_, as many as it has nodes at most: each is of another node.
  using Chord = std::array<std::uint32_t, 2>;
  bool crosses(const Candidate& c) const {
    const std::uint32_t low = std::min(c.own_place, c.place), high = std::max(c.own_place, c.place);
    const auto side = [&](std::uint32_t p) { return p == low || p == high ? 0 : p > low && p < high ? 1 : -1; };
    for (std::size_t i = chord_base_[c.face]; i < chord_base_[c.face + 1] && chords_[i][0] != kNone; ++i)
      if (side(chords_[i][0]) * side(chords_[i][1]) < 0) return true;
    return false;
  }
  void draw(const Candidate& c) {
    std::size_t i = chord_base_[c.face];
    while (chords_[i][0] != kNone) ++i;
    chords_[i] = {c.own_place, c.place};
  }

  const Site& site_;
  const std::vector<char>& opened_;
  std::vector<double>& time_;
  std::vector<std::uint32_t>& parent_;
  std::vector<std::uint32_t>& parent_face_;
  std::vector<unsigned char> status_;
  std::vector<double> done_time_;         // of states in the sequence
  std::vector<double> best_key_;          // of opened states; empty when there are none
  std::vector<std::uint64_t> unoffered_;  // per polygon
  std::vector<std::uint64_t> chord_base_;
  std::vector<char> offers_again_;  // per polygon: some of its states wait, or opened by themselves
  std::vector<Chord> chords_;
  LabelQueue queue_;
  Link link_;
  std::vector<char> removed_;
  std::vector<std::uint32_t> stripped_;
  std::vector<Candidate> candidates_;
  PolygonViews views_;
};

}  // namespace

void order_pass(const Site& site, const std::vector<char>& opened, std::vector<double>& time,
                std::vector<std::uint32_t>& parent, std::vector<std::uint32_t>& parent_face, Context* context) {
  Sequence(site, opened, time, parent, parent_face).run(context);
}

}  // namespace quench::burning
