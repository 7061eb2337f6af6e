// SPDX-License-Identifier: Apache-2.0
#include "skeleton/kept_nodes.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <utility>

#include "base/parallel.h"
#include "base/union_find.h"
#include "quench/error.h"

namespace quench::skeleton {
namespace {

class LinkParting {
 public:
  explicit LinkParting(const BurnedAxis& axis)
      : axis_(axis), net_(axis.network), links_(burning::make_links(axis.complex, axis.network)) {}

  KeptNodes run() {
    KeptNodes kept;
    const CellComplex& m = axis_.complex;
    lone_.assign(m.vertex_count, 0);
    for (std::uint32_t e = 0; e < m.edges.size(); ++e)
      if (net_.degree(e) == 0) {
        for (const std::uint32_t v : m.edges[e]) ++lone_[v];
        kept.lone_edges.push_back(e);
      }
    const std::size_t chunks = base::chunks_for(m.vertex_count, std::size_t{1} << 13);
    std::vector<Found> found(chunks);
    tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
      const auto [first, last] = base::part_of(m.vertex_count, chunk, chunks);
      for (std::size_t v = first; v < last; ++v) look_at(static_cast<std::uint32_t>(v), found[chunk]);
    });
    for (const Found& f : found) kept.isolated.insert(kept.isolated.end(), f.isolated.begin(), f.isolated.end());
    kept.spokes = base::Csr<std::uint32_t>::group(m.face_count(), [&](const auto& emit) {
      for (const Found& f : found)
        for (const auto& [polygon, v] : f.spokes) emit(polygon, v);
    });
    return kept;
  }

 private:
  struct Found {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> spokes;  // polygon, vertex
    std::vector<std::uint32_t> isolated;
  };
  void look_at(std::uint32_t v, Found& found) {
    if (net_.vertex_base[v + 1] - net_.vertex_base[v] == 1 && lone_[v] == 0)  // nearly all of them
      return check_primes(v, 1);
    const LinkParts link = parts_of_link(v);
    const std::size_t parts = link.last.size() + link.pocket;
    check_primes(v, parts);
    if (parts + lone_[v] == 0) found.isolated.push_back(v);
    if (parts + lone_[v] <= 1) return;
    for (const std::uint32_t state : link.last) found.spokes.push_back({face_of(state), v});
  }
  // One of the polygons in the sector of a vertex state.
  std::uint32_t face_of(std::uint32_t state) const { return net_.corner_face[links_.corners[state].front()]; }
  bool in_pocket(std::uint32_t state) const { return net_.pocket[face_of(state)]; }

  // The components of the link of a vertex. All pockets are in one.
  struct LinkParts {
    std::vector<std::uint32_t> last;  // per component without pocket: the state that left the link last
    bool pocket = false;
  };
  LinkParts parts_of_link(std::uint32_t v) const {
    LinkParts parts;
    const std::uint32_t first = net_.vertex_base[v], count = net_.vertex_base[v + 1] - first;
    // Sectors are joined by singular directions, pockets by direction 0.
    std::uint32_t directions = 1;
    for (std::uint32_t s = first; s < first + count; ++s)
      if (links_.ends[s].a != kNone) directions = std::max({directions, links_.ends[s].a + 1, links_.ends[s].b + 1});
    base::UnionFind sets(directions + count);
    for (std::uint32_t s = 0; s < count; ++s) {
      const auto [a, b] = links_.ends[first + s];
      if (in_pocket(first + s)) {
        parts.pocket = true;
        sets.unite(0, directions + s);
      }
      if (a == kNone) continue;
      sets.unite(a, directions + s);
      sets.unite(b, directions + s);
    }
    std::vector<std::uint32_t> set_of;  // per component in `parts.last`
    for (std::uint32_t s = 0; s < count; ++s) {
      const std::uint32_t set = sets.find(directions + s);
      if (parts.pocket && set == sets.find(0)) continue;
      const auto at = static_cast<std::size_t>(std::find(set_of.begin(), set_of.end(), set) - set_of.begin());
      if (at == set_of.size()) {
        set_of.push_back(set);
        parts.last.push_back(first + s);
      } else if (axis_.burned.rank[first + s] > axis_.burned.rank[parts.last[at]]) {
        parts.last[at] = first + s;
      }
    }
    return parts;
  }
  // A vertex has as many prime arcs as its link has independent cycles, with pockets contracted: otherwise the curves
  // would have another topology than the axis.
  void check_primes(std::uint32_t v, std::size_t components) const {
    std::int64_t primes = 0, cycles = static_cast<std::int64_t>(components);
    std::vector<std::uint32_t> met;
    for (std::uint32_t s = net_.vertex_base[v]; s < net_.vertex_base[v + 1]; ++s) {
      primes += axis_.burned.parent[s] != kNone;
      const auto [a, b] = links_.ends[s];
      if (in_pocket(s)) {
        met.push_back(0);
        continue;
      }
      if (a == kNone) continue;
      cycles += 1;
      met.push_back(a);
      met.push_back(b);
    }
    std::sort(met.begin(), met.end());
    cycles -= std::unique(met.begin(), met.end()) - met.begin();
    if (primes != cycles)
      throw Error(ErrorCode::invariant,
                  fmt::format("vertex {} of the medial axis has {} prime arcs, but its link has {} independent cycles; "
                              "this is a bug in Quench, please report it with the input",
                              v, primes, cycles));
  }

  const BurnedAxis& axis_;
  const burning::BurnNetwork& net_;
  const burning::Links links_;
  std::vector<std::uint32_t> lone_;  // per vertex: edges without polygon
};

}  // namespace

KeptNodes kept_nodes(const BurnedAxis& axis) { return LinkParting(axis).run(); }

}  // namespace quench::skeleton
