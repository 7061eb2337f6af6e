// SPDX-License-Identifier: Apache-2.0
#include "complex/thinning_in_slabs.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <limits>
#include <vector>

#include "base/union_find.h"
#include "complex/removal.h"

namespace quench::complex {
namespace {

struct Range {
  std::size_t begin, end;
  bool contains(std::size_t i) const { return begin <= i && i < end; }
  std::size_t size() const { return end - begin; }
};

// Ranges of vertices, edges and faces. Any ranges would do; where indices are near in space for cells that are near,
// few components cross.
class Slab {
 public:
  Slab(const LiveCells& cells, Range vertices, Range edges, Range faces)
      : cells_(cells),
        vertices_(vertices),
        edges_(edges),
        faces_(faces),
        pieces_(vertices.size() + edges.size()),
        crosses_(vertices.size() + edges.size()) {}

  // Finds the pieces of components of the slab's cells below the bound, and the pairs that are simple now.
  void scan(double bound) {
    const CellComplex& complex = cells_.complex;
    pairs_.clear();
    links_.clear();
    for (std::size_t i = vertices_.begin; i < vertices_.end; ++i) {
      if (!cells_.vertices[i].below(bound)) continue;
      const auto v = static_cast<std::uint32_t>(i);
      pieces_.reset(node_of_vertex(v));
      if (const auto pair = cells_.pair_of_vertex(v, bound); pair.key < bound) pairs_.push_back(pair);
    }
    for (std::size_t i = edges_.begin; i < edges_.end; ++i) {
      if (!cells_.edges[i].below(bound)) continue;
      const auto e = static_cast<std::uint32_t>(i);
      pieces_.reset(node_of_edge(e));
      if (const auto pair = cells_.pair_of_edge(e); pair.key < bound) pairs_.push_back(pair);
      for (const std::uint32_t v : complex.edges[e]) {
        if (!cells_.vertices[v].below(bound)) continue;
        if (vertices_.contains(v))
          pieces_.unite(node_of_edge(e), node_of_vertex(v));
        else
          links_.insert(links_.end(), {kEdgeIsFree | e, v});
      }
    }
    for (std::size_t f = faces_.begin; f < faces_.end; ++f) {
      if (cells_.face_level[f] < kNever || !(cells_.face_value[f] < bound)) continue;
      std::uint32_t own = kNone;
      bool crosses = false;
      for (const std::uint32_t e : complex.sides(f)) {
        if (!cells_.edges[e].below(bound)) continue;
        if (!edges_.contains(e)) {
          links_.push_back(kEdgeIsFree | e);
          crosses = true;
        } else {
          if (own != kNone) pieces_.unite(node_of_edge(own), node_of_edge(e));
          own = e;
        }
      }
      if (crosses && own != kNone) links_.push_back(kEdgeIsFree | own);
    }
  }

  // Tells pairs of components that cross slabs from the others, when all slabs have been scanned.
  void part(const std::vector<Slab>& all) {
    crosses_.assign(crosses_.size(), false);
    for (const Slab& slab : all)
      for (const std::uint64_t cell : slab.links_)
        if (contains(cell)) crosses_[piece_of(cell)] = true;
    const auto inside = [this](const PairQueue::Entry& pair) { return !crosses_[piece_of(pair.id)]; };
    inside_ = static_cast<std::size_t>(std::stable_partition(pairs_.begin(), pairs_.end(), inside) - pairs_.begin());
  }
  std::span<const PairQueue::Entry> inside() const { return {pairs_.data(), inside_}; }
  std::span<const PairQueue::Entry> crossing() const { return std::span(pairs_).subspan(inside_); }

 private:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  std::uint32_t node_of_vertex(std::size_t v) const { return static_cast<std::uint32_t>(v - vertices_.begin); }
  std::uint32_t node_of_edge(std::size_t e) const {
    return static_cast<std::uint32_t>(vertices_.size() + e - edges_.begin);
  }
  // Cells are given as the free cells of pairs are.
  bool contains(std::uint64_t cell) const {
    return cell & kEdgeIsFree ? edges_.contains(cell ^ kEdgeIsFree) : vertices_.contains(cell);
  }
  std::uint32_t piece_of(std::uint64_t cell) {
    return pieces_.find(cell & kEdgeIsFree ? node_of_edge(cell ^ kEdgeIsFree) : node_of_vertex(cell));
  }

  const LiveCells& cells_;
  Range vertices_, edges_, faces_;
  base::UnionFind pieces_;            // of vertices and edges; faces link their sides
  std::vector<bool> crosses_;         // by root
  std::vector<std::uint64_t> links_;  // both ends of links between slabs
  std::vector<PairQueue::Entry> pairs_;
  std::size_t inside_ = 0;
};

// As many edges in each, vertices and faces where the edges are in a complex that is sorted by the ends of edges and
// the sides of faces. In others more components cross.
std::vector<Slab> make_slabs(const LiveCells& cells, std::size_t count) {
  const CellComplex& complex = cells.complex;
  std::vector<Slab> slabs;
  std::size_t v = 0, e = 0, f = 0;
  for (std::size_t s = 0; s < count; ++s) {
    std::size_t v_end = complex.vertex_count, f_end = complex.face_count();
    const std::size_t e_end = base::part_of(complex.edges.size(), s, count).second;
    if (e_end < complex.edges.size()) {
      v_end = std::max<std::size_t>(v, complex.edges[e_end][0]);
      std::size_t high = f_end;
      for (f_end = f; f_end < high;) {
        const std::size_t middle = f_end + (high - f_end) / 2;
        if (complex.sides(middle)[0] < e_end)
          f_end = middle + 1;
        else
          high = middle;
      }
    }
    slabs.emplace_back(cells, Range{v, v_end}, Range{e, e_end}, Range{f, f_end});
    v = v_end;
    e = e_end;
    f = f_end;
  }
  return slabs;
}

// Finite values of the cells that decide the keys, sorted: some thousands, from everywhere.
std::vector<double> sample_of(const LiveCells& cells) {
  std::vector<double> sample;
  const std::size_t count = cells.edges_decide ? cells.edges.size() : cells.face_value.size();
  for (std::size_t i = 0; i < count; i += count / 4096 + 1)
    if (const double value = cells.edges_decide ? cells.edges[i].value : cells.face_value[i]; value < kNever)
      sample.push_back(value);
  std::sort(sample.begin(), sample.end());
  return sample;
}

}  // namespace

double thin_in_slabs(LiveCells& cells, std::size_t count, double most_crossing, double width,
                     const std::function<bool(std::size_t)>& step) {
  // Closer bounds have smaller components, which cross fewer slabs, but each costs a look at all cells. The last cells
  // are not worth it.
  constexpr double kShare = 0.25, kLeastShare = 0.1, kLast = 0.15;
  const std::vector<double> values = sample_of(cells);
  const auto all = static_cast<double>(values.size());
  std::vector<Slab> slabs = make_slabs(cells, count);
  double done = 0, share = kShare;  // of the values that are not below `done`
  for (auto left = all; left > kLast * all;) {
    // A little above that value, since equal ones may be rounded differently; and above 0.
    const double value = values[static_cast<std::size_t>(all - left + share * left)];
    const double bound = std::max(value * (1 + 1e-9), std::numeric_limits<double>::min());
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t s) { slabs[s].scan(bound); });
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t s) { slabs[s].part(slabs); });
    std::size_t inside = 0, crossing = 0;
    for (const Slab& slab : slabs) {
      inside += slab.inside().size();
      crossing += slab.crossing().size();
    }
    if (static_cast<double>(crossing) > most_crossing * static_cast<double>(inside + crossing)) {
      share /= 2;
      if (share < kLeastShare) break;
      continue;
    }
    std::atomic<bool> stopped{false};
    tbb::parallel_for(std::size_t{0}, count + 1, [&](std::size_t task) {
      Removal removal(cells, done, width, bound, true);
      const auto offer = [&removal](std::span<const PairQueue::Entry> pairs) {
        for (const PairQueue::Entry& pair : pairs) removal.offer(pair);
      };
      if (task == 0)
        for (const Slab& slab : slabs) offer(slab.crossing());
      else
        offer(slabs[task - 1].inside());
      try {
        if (!removal.run([&](std::size_t pairs) { return !stopped && step(pairs); })) stopped = true;
      } catch (...) {  // the others need not go on
        stopped = true;
        throw;
      }
    });
    if (stopped) break;
    done = bound;
    const auto left_now = static_cast<double>(values.end() - std::lower_bound(values.begin(), values.end(), bound));
    if (!(left_now < left)) break;  // values too small for a factor
    left = left_now;
    share = std::min(kShare, 2 * share);
  }
  return done;
}

}  // namespace quench::complex
