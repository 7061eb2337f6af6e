// SPDX-License-Identifier: Apache-2.0
#include "skeleton/sheet_levels.h"

#include <algorithm>
#include <atomic>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <utility>

#include "base/cofaces.h"
#include "base/constants.h"
#include "base/csr.h"
#include "base/parallel.h"
#include "base/rounded_down.h"

namespace quench::skeleton {
namespace {

using base::kNever;

// Sets of numbers that several threads unite at the same time. The least number of a set represents it.
class SharedSets {
 public:
  explicit SharedSets(std::size_t count) : parent_(std::make_unique_for_overwrite<std::uint32_t[]>(count)) {
    base::for_indices(count, [&](std::size_t i) { parent_[i] = static_cast<std::uint32_t>(i); });
  }
  std::uint32_t find(std::uint32_t i) {
    for (;;) {
      const std::uint32_t up = load(i);
      if (up == i) return i;
      const std::uint32_t above = load(up);
      if (above != up) std::atomic_ref(parent_[i]).store(above, std::memory_order_relaxed);
      i = above;
    }
  }
  void unite(std::uint32_t a, std::uint32_t b) {
    for (;;) {
      a = find(a);
      b = find(b);
      if (a == b) return;
      if (a < b) std::swap(a, b);
      std::uint32_t expected = a;
      if (std::atomic_ref(parent_[a]).compare_exchange_weak(expected, b, std::memory_order_relaxed)) return;
    }
  }

 private:
  std::uint32_t load(std::uint32_t i) { return std::atomic_ref(parent_[i]).load(std::memory_order_relaxed); }
  std::unique_ptr<std::uint32_t[]> parent_;
};

// The cells off the curves that are not removed yet.
struct Live {
  const RefinedAxis& axis;
  std::vector<char> fixed;                              // per vertex: on a curve or a pocket, and so never removed
  std::unique_ptr<base::Cofaces[]> faces_at, edges_at;  // per edge and vertex
  std::vector<float> flood;                             // per edge: at which level the faces that are gone left it

  explicit Live(const RefinedAxis& of)
      : axis(of),
        fixed(of.curve_vertex),
        faces_at(std::make_unique<base::Cofaces[]>(of.complex.edges.size())),
        edges_at(std::make_unique<base::Cofaces[]>(of.complex.vertex_count)),
        flood(of.complex.edges.size(), 0) {
    const CellComplex& k = axis.complex;
    for (std::size_t f = 0; f < k.face_count(); ++f)
      if (axis.face_thickness[f] == kNever)
        for (const std::uint32_t v : k.corners(f)) fixed[v] = 1;
    const bool shared = base::several_threads();
    base::for_indices(k.face_count(), [&](std::size_t f) {
      for (const std::uint32_t e : k.sides(f))
        if (!axis.curve_edge[e]) faces_at[e].add(static_cast<std::uint32_t>(f), shared);
    });
    base::for_indices(k.edges.size(), [&](std::size_t e) {
      for (const std::uint32_t v : k.edges[e])
        if (!fixed[v]) edges_at[v].add(static_cast<std::uint32_t>(e), shared);
    });
  }
};

// Thins one part after the other. The pairs of one part do not depend on those of others, and the level of a pair is
// the largest key of those that have to go before it, which are in its part.
class PartThinner {
 public:
  PartThinner(Live& live, CellValues& level, std::vector<float>& corners)
      : live_(live), level_(level), corners_(corners) {}

  void run(std::span<const std::uint32_t> faces) {
    for (const std::uint32_t f : faces)
      for (const std::uint32_t e : live_.axis.complex.sides(f)) push_edge(e);
    double now = 0;
    while (!lone_.empty() || !free_.empty()) {
      // Pairs of an edge and a vertex have key 0, and go before the pairs of a face of that key.
      if (!lone_.empty()) {
        const std::uint32_t v = pop(lone_);
        if (live_.edges_at[v].single()) remove_edge(live_.edges_at[v].only(), v, now);
        continue;
      }
      const Pair pair = pop(free_);
      if (!live_.faces_at[pair.edge].single()) continue;
      now = std::max(now, pair.key);
      remove_face(live_.faces_at[pair.edge].only(), pair.edge, now);
    }
  }

 private:
  struct Pair {
    double key;
    std::uint32_t edge;
    friend bool operator>(const Pair& a, const Pair& b) { return a.key != b.key ? a.key > b.key : a.edge > b.edge; }
  };
  template <class Entry>
  static void push(std::vector<Entry>& heap, const Entry& entry) {
    heap.push_back(entry);
    std::push_heap(heap.begin(), heap.end(), std::greater<>());
  }
  template <class Entry>
  static Entry pop(std::vector<Entry>& heap) {
    std::pop_heap(heap.begin(), heap.end(), std::greater<>());
    const Entry entry = heap.back();
    heap.pop_back();
    return entry;
  }

  void push_edge(std::uint32_t e) {
    if (!live_.faces_at[e].single()) return;
    const double key = live_.axis.face_thickness[live_.faces_at[e].only()];
    if (key < kNever) push(free_, {key, e});
  }
  void push_vertex(std::uint32_t v) {
    const base::Cofaces edges = live_.edges_at[v];
    if (!live_.fixed[v] && edges.single() && live_.faces_at[edges.only()].none()) push(lone_, v);
  }

  void remove_face(std::uint32_t f, std::uint32_t e, double now) {
    const CellComplex& k = live_.axis.complex;
    level_.face[f] = now;
    level_.edge[e] = now;
    fill(f, now);
    for (const std::uint32_t s : k.sides(f)) {
      if (live_.axis.curve_edge[s]) continue;
      live_.faces_at[s].remove(f);
      if (s == e) continue;
      if (live_.faces_at[s].none())
        for (const std::uint32_t v : k.edges[s]) push_vertex(v);
      else
        push_edge(s);
    }
    for (const std::uint32_t v : k.edges[e]) leave(v, e);
  }
  // The levels of the corners of a face, and with them of its sides for the faces behind.
  void fill(std::uint32_t f, double now) {
    const CellComplex& k = live_.axis.complex;
    const auto sides = k.sides(f);
    float* const corner = corners_.data() + k.face_offsets[f];
    const auto lower_end = [&](std::size_t i) {
      return std::min(corner[i], corner[i + 1 == sides.size() ? 0 : i + 1]);
    };
    float entry = std::numeric_limits<float>::infinity();
    for (std::size_t i = 0; i < sides.size(); ++i)
      if (!live_.axis.curve_edge[sides[i]] && live_.faces_at[sides[i]].single())
        entry = std::min(entry, std::max(live_.flood[sides[i]], lower_end(i)));
    for (std::size_t i = 0; i < sides.size(); ++i) {
      if (live_.axis.curve_edge[sides[i]]) continue;  // other parts are thinned beside it
      float& flood = live_.flood[sides[i]];
      flood = std::max({flood, entry, lower_end(i)});
    }
    const float most = base::rounded_down(now);
    for (std::size_t i = 0; i < sides.size(); ++i) corner[i] = std::min(most, std::max(entry, corner[i]));
    if (sides.front() == sides.back()) {  // the spoke is cut at one end or not at all
      const float at_spoke = std::max({corner[0], corner[1], corner[sides.size() - 1]});
      corner[0] = corner[1] = corner[sides.size() - 1] = at_spoke;
    }
    keep_in_one_piece(corner, sides.size());
  }
  // Raises corners so that they have one low and one high: what any level leaves of the face is in one piece.
  static void keep_in_one_piece(float* corner, std::size_t n) {
    const std::size_t low = static_cast<std::size_t>(std::min_element(corner, corner + n) - corner);
    const std::size_t high = static_cast<std::size_t>(std::max_element(corner, corner + n) - corner);
    for (std::size_t i = low, next; i != high; i = next) {
      next = i + 1 == n ? 0 : i + 1;
      corner[next] = std::max(corner[next], corner[i]);
    }
    for (std::size_t i = low, next; i != high; i = next) {
      next = i == 0 ? n - 1 : i - 1;
      corner[next] = std::max(corner[next], corner[i]);
    }
  }
  void remove_edge(std::uint32_t e, std::uint32_t v, double now) {
    const auto [a, b] = live_.axis.complex.edges[e];
    level_.edge[e] = level_.vertex[v] = now;
    live_.edges_at[v].remove(e);
    leave(a == v ? b : a, e);
  }
  void leave(std::uint32_t v, std::uint32_t e) {
    if (live_.fixed[v]) return;
    live_.edges_at[v].remove(e);
    push_vertex(v);
  }

  Live& live_;
  CellValues& level_;
  std::vector<float>& corners_;
  std::vector<Pair> free_;           // heap
  std::vector<std::uint32_t> lone_;  // heap of vertices of one edge, which has no face
};

// Faces by part: those that share edges off the curves.
class Parts {
 public:
  Parts(const Live& live) {
    const CellComplex& k = live.axis.complex;
    const auto faces = static_cast<std::uint32_t>(k.face_count());
    SharedSets sets(faces);
    std::mutex crowded_access;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> crowded;  // edges of more than two faces, and these
    base::for_indices(faces, [&](std::size_t f) {
      const auto face = static_cast<std::uint32_t>(f);
      for (const std::uint32_t e : k.sides(f)) {
        if (live.axis.curve_edge[e]) continue;
        const base::Cofaces at = live.faces_at[e];
        if (at.count() == 2) {
          base::Cofaces other = at;
          other.remove(face);
          if (other.only() > face) sets.unite(face, other.only());
        } else if (at.count() > 2) {
          const std::scoped_lock lock(crowded_access);
          crowded.push_back({e, face});
        }
      }
    });
    std::sort(crowded.begin(), crowded.end());
    for (std::size_t i = 1; i < crowded.size(); ++i)
      if (crowded[i].first == crowded[i - 1].first) sets.unite(crowded[i].second, crowded[i - 1].second);
    // A part has the number of its first face; other numbers are empty.
    faces_ = base::Csr<std::uint32_t>::group(faces, [&](const auto& emit) {
      for (std::uint32_t f = 0; f < faces; ++f) emit(sets.find(f), f);
    });
  }
  // Calls visit(faces of a part).
  template <class Visit>
  void each(std::size_t first, std::size_t last, const Visit& visit) const {
    for (std::size_t p = first; p < last; ++p)
      if (!faces_[p].empty()) visit(faces_[p]);
  }

 private:
  base::Csr<std::uint32_t> faces_;
};

}  // namespace

CellValues sheet_levels(const RefinedAxis& axis, std::vector<float>& corners, Context* context) {
  const CellComplex& k = axis.complex;
  CellValues level;
  level.vertex.assign(k.vertex_count, kNever);
  level.edge.assign(k.edges.size(), kNever);
  level.face.assign(k.face_count(), kNever);
  Live live(axis);
  const Parts parts(live);
  const std::size_t chunks = base::chunks_for(k.face_count(), std::size_t{1} << 13);
  base::for_chunks(chunks, context, "skeleton", 0, 1, [&](std::size_t chunk) {
    const auto [first, last] = base::part_of(k.face_count(), chunk, chunks);
    PartThinner thinner(live, level, corners);
    parts.each(first, last, [&](std::span<const std::uint32_t> faces) { thinner.run(faces); });
  });
  return level;
}

}  // namespace quench::skeleton
