// SPDX-License-Identifier: Apache-2.0
#include "complex/certain_thinning.h"

#include <algorithm>
#include <compare>
#include <functional>

#include "base/parallel.h"
#include "complex/live_cells.h"

namespace quench::complex {
namespace {

using Entry = PairQueue::Entry;

// A pair is named by its free face, as everywhere; this is none.
constexpr std::uint64_t kNoPair = ~std::uint64_t{0};

// Bits of edges and vertices.
constexpr std::uint8_t kOpen = 1;  // has cofaces that are doubtful or not known
constexpr std::uint8_t kDoubtful = 2;
constexpr std::uint8_t kIsFree = 4;  // was removed as the free face of its pair
constexpr std::uint8_t kStays = 8;   // and its pair must not be removed yet

// The thinning of the whole complex as far as its cells are known. At every time, cells are
// - removed: by the same pair in the whole;
// - doubtful: the whole may have removed them by now, alone knows what with. They are no cofaces any more;
// - present otherwise, in the whole as well.
// A removed edge or vertex that was a free face still has its only coface.
class CertainThinning {
 public:
  CertainThinning(const KnownCells& known, double cutoff, Context* context, std::string_view stage)
      : complex_(known.complex),
        cells_(known.complex, known.vertex_value, known.edge_value, known.face_value),
        cutoff_(cutoff),
        queue_(0, cutoff / 512),
        vertex_(known.vertex_uncertain.begin(), known.vertex_uncertain.end()),
        edge_(known.edge_uncertain.begin(), known.edge_uncertain.end()),
        context_(context),
        stage_(stage) {}

  CellFlags run() {
    for (std::uint32_t e = 0; e < edge_.size(); ++e) look_at_edge(e, kNoPair);
    for (std::uint32_t v = 0; v < vertex_.size(); ++v) look_at_vertex(v, kNoPair);
    const auto stale = [this](const Entry& pair) { return is_settled(pair.id); };
    std::size_t count = 0;
    for (Entry pair{}; queue_.pop(pair, stale);) {
      if (++count % (std::size_t{1} << 16) == 0) checkpoint(context_, stage_, pair.key / cutoff_);
      last_ = pair;
      decide(pair.id, kNoPair);
      while (!overdue_.empty()) {
        std::ranges::pop_heap(overdue_, std::greater<>());
        const Overdue next = overdue_.back();
        overdue_.pop_back();
        decide(next.pair.id, next.opened_by);
      }
    }
    return removed();
  }

 private:
  // A pair that a removal has made available although its turn was before.
  struct Overdue {
    Entry pair;
    std::uint64_t opened_by;
    friend bool operator>(const Overdue& a, const Overdue& b) { return a.pair > b.pair; }
  };

  static bool is_edge(std::uint64_t pair) { return (pair & kEdgeIsFree) != 0; }
  static std::uint32_t free_face(std::uint64_t pair) { return static_cast<std::uint32_t>(pair); }
  LiveCell& cell(std::uint64_t pair) {
    return is_edge(pair) ? cells_.edges[free_face(pair)] : cells_.vertices[free_face(pair)];
  }
  std::uint8_t& bits(std::uint64_t pair) { return is_edge(pair) ? edge_[free_face(pair)] : vertex_[free_face(pair)]; }
  // Whether there is nothing more to decide about a queued pair.
  bool is_settled(std::uint64_t pair) {
    const LiveCell& free = cell(pair);
    return free.removed() || (!free.cofaces.single() && (bits(pair) & (kOpen | kDoubtful)) != kOpen);
  }

  // Queues what may happen to a cell after one of its cofaces has gone, removed by the pair `cause`, or become
  // doubtful.
  void look_at_edge(std::uint32_t e, std::uint64_t cause) {
    const LiveCell& edge = cells_.edges[e];
    if (edge.removed()) return;
    if (edge.cofaces.single()) {
      queue(cells_.pair_of_edge(e), !edge_[e], cause);
    } else if (edge.cofaces.none()) {
      if (edge_[e] & kOpen) queue({edge.value, kEdgeIsFree | e}, false, cause);
      note_bare(kEdgeIsFree | e, edge.value, cause);
      for (const std::uint32_t v : complex_.edges[e])
        if (const base::Cofaces& at = cells_.vertices[v].cofaces; at.none() || (at.single() && at.only() == e))
          look_at_vertex(v, cause);
    }
  }
  void look_at_vertex(std::uint32_t v, std::uint64_t cause) {
    const LiveCell& vertex = cells_.vertices[v];
    if (vertex.removed()) return;
    if (vertex.cofaces.single()) {
      queue(cells_.pair_of_vertex(v), !vertex_[v] && !edge_[vertex.cofaces.only()], cause);
    } else if (vertex.cofaces.none()) {
      if (vertex_[v] & kOpen) queue({vertex.value, v}, false, cause);
      note_bare(v, vertex.value, cause);
    }
  }
  // The same holds for the removal of the last coface of a cell, if one of the cofaces that were removed before stays.
  void note_bare(std::uint64_t bare, double value, std::uint64_t cause) {
    if (cause != kNoPair && Entry{value, bare} < last_) links_.push_back({bare, cause});
  }
  // A removal that opens a pair whose turn was before must wait if this pair is not removed: without its cause it would
  // be collapsed at its turn, before others that come first.
  void queue(const Entry& pair, bool is_certain, std::uint64_t cause) {
    if (!(pair.key < cutoff_)) return;
    if (last_ < pair) {
      queue_.push(pair.key, pair.id);
      return;
    }
    if (is_certain)
      links_.push_back({pair.id, cause});
    else
      must_stay(cause);
    overdue_.push_back({pair, is_certain ? cause : kNoPair});
    std::ranges::push_heap(overdue_, std::greater<>());
  }

  void decide(std::uint64_t pair, std::uint64_t opened_by) {
    LiveCell& free = cell(pair);
    if (free.removed()) return;
    const bool is_one = free.cofaces.single();
    if (is_one && !bits(pair) && (is_edge(pair) || !edge_[free.cofaces.only()])) {
      remove(pair);
      return;
    }
    if (!is_one && !(bits(pair) & kOpen)) return;
    must_stay(opened_by);
    if (is_one) doubt_coface(pair, free.cofaces.only());
    is_edge(pair) ? doubt_edge(free_face(pair)) : doubt_vertex(free_face(pair));
  }

  void remove(std::uint64_t pair) {
    const std::uint32_t free = free_face(pair), coface = cell(pair).cofaces.only();
    cell(pair).remove(0);
    bits(pair) |= kIsFree;
    if (is_edge(pair)) {
      cells_.face_level[coface] = 0;
      for (const std::uint32_t s : complex_.sides(coface))
        if (s != free) cells_.edges[s].cofaces.remove(coface);
      for (const std::uint32_t v : complex_.edges[free]) cells_.vertices[v].cofaces.remove(free);
      for (const std::uint32_t s : complex_.sides(coface))
        if (s != free) look_at_edge(s, pair);
      for (const std::uint32_t v : complex_.edges[free]) look_at_vertex(v, pair);
    } else {
      cells_.edges[coface].remove(0);
      const std::uint32_t w = other_end(coface, free);
      cells_.vertices[w].cofaces.remove(coface);
      look_at_vertex(w, pair);
    }
  }
  std::uint32_t other_end(std::uint32_t e, std::uint32_t v) const {
    const auto& ends = complex_.edges[e];
    return ends[0] == v ? ends[1] : ends[0];
  }

  void doubt_coface(std::uint64_t pair, std::uint32_t coface) {
    if (!is_edge(pair)) {
      doubt_edge(coface);
      return;
    }
    cells_.face_level[coface] = 1;
    for (const std::uint32_t s : complex_.sides(coface)) {
      cells_.edges[s].cofaces.remove(coface);
      edge_[s] |= kOpen;
    }
    for (const std::uint32_t s : complex_.sides(coface)) look_at_edge(s, kNoPair);
  }
  void doubt_edge(std::uint32_t e) {
    if (edge_[e] & kDoubtful) return;
    edge_[e] |= kDoubtful;
    for (const std::uint32_t v : complex_.edges[e]) {
      cells_.vertices[v].cofaces.remove(e);
      vertex_[v] |= kOpen;
    }
    for (const std::uint32_t v : complex_.edges[e]) look_at_vertex(v, kNoPair);
  }
  void doubt_vertex(std::uint32_t v) { vertex_[v] |= kDoubtful; }

  void must_stay(std::uint64_t pair) {
    if (pair == kNoPair || (bits(pair) & kStays)) return;
    bits(pair) |= kStays;
    staying_.push_back(pair);
  }
  // A pair that must stay, although it is certain that it is removed, keeps all sides of its cells.
  void keep_sides_of_staying() {
    std::ranges::sort(links_);
    while (!staying_.empty()) {
      const std::uint64_t pair = staying_.back();
      staying_.pop_back();
      follow_links(pair);
      const std::uint32_t free = free_face(pair), coface = cell(pair).cofaces.only();
      if (is_edge(pair)) {
        for (const std::uint32_t s : complex_.sides(coface))
          if (s != free) keep_edge(s);
        for (const std::uint32_t v : complex_.edges[free]) keep_vertex(v);
      } else {
        keep_vertex(other_end(coface, free));
      }
    }
  }
  void follow_links(std::uint64_t cell) {
    for (auto link = std::ranges::lower_bound(links_, Link{cell, 0}); link != links_.end() && link->cell == cell;
         ++link)
      must_stay(link->cause);
  }
  void keep_vertex(std::uint32_t v) {
    if (vertex_[v] & kIsFree)
      must_stay(v);
    else
      follow_links(v);
  }
  void keep_edge(std::uint32_t e) {
    if (edge_[e] & kIsFree) {
      must_stay(kEdgeIsFree | e);
      return;
    }
    follow_links(kEdgeIsFree | e);
    if (cells_.edges[e].removed())
      for (const std::uint32_t v : complex_.edges[e])
        if ((vertex_[v] & kIsFree) && cells_.vertices[v].cofaces.only() == e) must_stay(v);
  }

  CellFlags removed() {
    keep_sides_of_staying();
    CellFlags removed{std::vector<std::uint8_t>(vertex_.size(), 0), std::vector<std::uint8_t>(edge_.size(), 0),
                      std::vector<std::uint8_t>(cells_.face_level.size(), 0)};
    for (std::uint32_t e = 0; e < edge_.size(); ++e)
      if ((edge_[e] & (kIsFree | kStays)) == kIsFree)
        removed.edge[e] = removed.face[cells_.edges[e].cofaces.only()] = 1;
    for (std::uint32_t v = 0; v < vertex_.size(); ++v)
      if ((vertex_[v] & (kIsFree | kStays)) == kIsFree)
        removed.vertex[v] = removed.edge[cells_.vertices[v].cofaces.only()] = 1;
    return removed;
  }

  const CellComplex& complex_;
  LiveCells cells_;
  double cutoff_;
  PairQueue queue_;
  Entry last_{-kNever, 0};        // the last one of the queue: pairs before it are overdue
  std::vector<Overdue> overdue_;  // heap
  // Of a cell that is overdue since it has one coface or none, and what has removed the last other one: if one of its
  // cofaces stays, so must what has removed this.
  struct Link {
    std::uint64_t cell, cause;
    auto operator<=>(const Link&) const = default;
  };
  std::vector<Link> links_;
  std::vector<std::uint8_t> vertex_, edge_;
  std::vector<std::uint64_t> staying_;
  Context* context_;
  std::string_view stage_;
};

}  // namespace

CellFlags certainly_removed(const KnownCells& known, double cutoff, Context* context, std::string_view stage) {
  return CertainThinning(known, cutoff, context, stage).run();
}

}  // namespace quench::complex
