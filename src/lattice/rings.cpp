// SPDX-License-Identifier: Apache-2.0
#include "lattice/rings.h"

#include <tbb/task_arena.h>

#include <algorithm>

#include "base/parallel.h"

namespace quench::lattice {
namespace {

// The six edges (i, j) of a tetrahedron and the other two corners (k, l), (i, j, k, l) an even permutation.
constexpr std::uint8_t kEdge[6][4] = {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2},
                                      {1, 2, 0, 3}, {1, 3, 2, 0}, {2, 3, 0, 1}};
// Bits of the edges of the facet opposite to each corner.
constexpr std::uint8_t kFacetEdges[4] = {0b111000, 0b100110, 0b010101, 0b001011};
constexpr std::uint8_t kEdgeOf[4][4] = {{0, 0, 1, 2}, {0, 0, 3, 4}, {1, 3, 0, 5}, {2, 4, 5, 0}};

// Walks around the edges of the triangulation inside O whose first tetrahedron is in [first, last): ranges share the
// work. An edge is an edge of the Delaunay complex, not a diagonal of a polytope or facet, exactly when at least three
// polytopes surround it. Each polytope is convex, so its tetrahedra are consecutive around the edge.
class FaceCollector {
 public:
  // `done`, bit e of tetrahedron t: its edge kEdge[e] was walked around. A collector uses those of its range.
  FaceCollector(const Polytopes& polytopes, std::span<const std::uint8_t> wanted, std::size_t first, std::size_t last,
                RawHugeVector<std::uint8_t>& done)
      : polytopes_(polytopes), wanted_(wanted), first_(first), last_(last), done_(done) {}

  RawFaces run() {
    for (std::size_t t = first_; t < last_; ++t) {
      // Edges on the boundary of O have no face; most of them are found here.
      const auto& neighbour = polytopes_.tetrahedra[t].neighbour;
      std::uint32_t boundary = 0;
      for (std::size_t i = 0; i < 4; ++i) boundary |= neighbour[i] == kNone ? kFacetEdges[i] : 0u;
      done_[t] = static_cast<std::uint8_t>(boundary);
    }
    for (std::size_t t = first_; t < last_; ++t)
      for (std::uint32_t e = 0; e < 6; ++e)
        if (!(done_[t] >> e & 1)) walk_around(static_cast<std::uint32_t>(t), e);
    return std::move(faces_);
  }

 private:
  void walk_around(std::uint32_t start, std::uint32_t e) {
    const auto& corner = polytopes_.tetrahedra[start].corner;
    const auto& index = kEdge[e];
    std::uint32_t a = corner[index[0]], b = corner[index[1]], leave = index[2], keep = index[3];
    if (a > b) {
      std::swap(a, b);
      std::swap(leave, keep);
    }
    if (!wanted_.empty() && !wanted_[a]) return;
    ring_.assign(1, polytopes_.polytope_of[start]);
    earlier_ = false;
    if (!walk(start, a, b, leave, corner[keep])) {
      walk(start, a, b, keep, corner[leave]);  // an edge on the boundary of O: only to mark the other side as done
      return;
    }
    if (earlier_) return;
    if (ring_.size() > 1 && ring_.front() == ring_.back()) ring_.pop_back();
    if (ring_.size() < 3) return;
    std::rotate(ring_.begin(), std::min_element(ring_.begin(), ring_.end()), ring_.end());
    faces_.sites.push_back({a, b});
    faces_.corners.insert(faces_.corners.end(), ring_.begin(), ring_.end());
    check_index(faces_.corners.size());
    faces_.offsets.push_back(static_cast<std::uint32_t>(faces_.corners.size()));
  }

  // Collects the polytopes around (a, b) until the walk is back (true) or leaves O (false).
  bool walk(std::uint32_t start, std::uint32_t a, std::uint32_t b, std::uint32_t leave, std::uint32_t keep) {
    for (std::uint32_t t = start;;) {
      const std::uint32_t across = polytopes_.tetrahedra[t].neighbour[leave];
      if (across == kNone) return false;
      t = across >> 2;
      if (t == start) return true;
      const auto& corner = polytopes_.tetrahedra[t].corner;
      std::uint32_t ia = 0, ib = 0;
      for (std::uint32_t i = 0; i < 4; ++i) {
        if (corner[i] == a) ia = i;
        if (corner[i] == b) ib = i;
        if (corner[i] == keep) leave = i;
      }
      keep = corner[across & 3];
      if (t < first_)
        earlier_ = true;  // the edge belongs to an earlier range
      else if (t < last_)
        done_[t] = static_cast<std::uint8_t>(done_[t] | 1u << kEdgeOf[ia][ib]);
      if (polytopes_.polytope_of[t] != ring_.back()) ring_.push_back(polytopes_.polytope_of[t]);
    }
  }

  const Polytopes& polytopes_;
  std::span<const std::uint8_t> wanted_;
  std::size_t first_, last_;
  RawHugeVector<std::uint8_t>& done_;
  bool earlier_ = false;
  std::vector<std::uint32_t> ring_;
  RawFaces faces_;
};

}  // namespace

std::vector<RawFaces> collect_faces(const Polytopes& polytopes, std::span<const std::uint8_t> wanted,
                                    Context* context) {
  // Few chunks: edges between them are walked around once in each.
  const std::size_t count = polytopes.tetrahedra.size();
  const std::size_t chunks = std::min<std::size_t>(
      base::chunks_for(count), 4 * static_cast<std::size_t>(std::max(1, tbb::this_task_arena::max_concurrency())));
  RawHugeVector<std::uint8_t> done(count);
  std::vector<RawFaces> faces(chunks);
  base::for_chunks(chunks, context, "merge", 0.76, 0.9, [&](std::size_t chunk) {
    const auto [first, last] = base::part_of(count, chunk, chunks);
    faces[chunk] = FaceCollector(polytopes, wanted, first, last, done).run();
  });
  return faces;
}

}  // namespace quench::lattice
