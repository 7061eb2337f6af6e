// SPDX-License-Identifier: Apache-2.0
#include "voxelization/match_topology.h"

#include <algorithm>

#include "voxelization/deflate.h"
#include "voxelization/surface_cover.h"

namespace quench::voxelization {
namespace {

using Group = std::vector<std::uint32_t>;

std::int64_t off(const Betti& got, const Betti& wanted) {
  std::int64_t sum = 0;
  for (std::size_t i = 0; i < 3; ++i) sum += std::abs(got[i] - wanted[i]);
  return sum;
}

/// Whether no number is further from what is wanted than it was.
bool harmless(const Betti& before, const Betti& after, const Betti& wanted) {
  for (std::size_t i = 0; i < 3; ++i)
    if (std::abs(after[i] - wanted[i]) > std::abs(before[i] - wanted[i])) return false;
  return true;
}

class Choice {
 public:
  Choice(const VoxelShape& shape, std::vector<Voxel> loose, const Betti& wanted)
      : graph_(shape, std::move(loose)), wanted_(wanted), was_inside_(graph_.size()) {
    for (std::uint32_t v = 0; v < graph_.size(); ++v) was_inside_[v] = graph_.inside(v);
    find_pieces();
  }

  void run() {
    for (const bool drops_parts : {false, true}) {
      drops_parts_ = drops_parts;
      take(pieces_, true);
      take(pieces_, false);
      take(single_voxels(), false);
      if (left() > 0) take_with_single_voxels();
    }
    tidy();
  }

  std::int64_t left() const { return off(graph_.betti(), wanted_); }
  std::vector<Voxel> flipped() const {
    std::vector<Voxel> result;
    for (std::uint32_t v = 0; v < graph_.size(); ++v)
      if (graph_.inside(v) != static_cast<bool>(was_inside_[v])) result.push_back(graph_.voxel(v));
    return result;
  }
  const std::vector<Group>& pieces() const { return pieces_; }
  VoxelGraph& graph() { return graph_; }

 private:
  /// 26-components of the fills, and of the cuts; fewest voxels first, equal ones by their first voxel.
  void find_pieces() {
    base::UnionFind sets(graph_.size());
    for (std::uint32_t v = 0; v < graph_.size(); ++v)
      graph_.for_neighbours(v, [&](std::uint32_t w) {
        if (graph_.inside(v) == graph_.inside(w)) sets.unite(v, w);
      });
    std::vector<Group> of_root(graph_.size());
    for (std::uint32_t v = 0; v < graph_.size(); ++v) of_root[sets.find(v)].push_back(v);
    for (Group& piece : of_root)
      if (!piece.empty()) pieces_.push_back(std::move(piece));
    std::stable_sort(pieces_.begin(), pieces_.end(),
                     [](const Group& a, const Group& b) { return a.size() < b.size(); });
  }

  std::vector<Group> single_voxels() const {
    std::vector<Group> result;
    for (std::uint32_t v = 0; v < graph_.size(); ++v) result.push_back({v});
    return result;
  }

  bool is_uniform(const Group& group) const {
    return std::ranges::all_of(group, [&](std::uint32_t v) { return graph_.inside(v) == graph_.inside(group[0]); });
  }

  /// Flips groups while that brings the Betti numbers nearer.
  void take(const std::vector<Group>& groups, bool only_harmless) {
    for (bool again = true; again && left() > 0;) {
      again = false;
      for (const Group& group : groups) {
        if (!is_uniform(group)) continue;
        const Betti after = graph_.after(group);
        if (!drops_parts_ && graph_.inside(group[0]) && after[0] < graph_.betti()[0]) continue;
        if (off(after, wanted_) >= left() || (only_harmless && !harmless(graph_.betti(), after, wanted_))) continue;
        graph_.flip(group);
        again = true;
        if (left() == 0) return;
      }
    }
  }

  /// Pieces that bring some number nearer but another one further away, where single voxels then mend that.
  void take_with_single_voxels() {
    for (const Group& piece : pieces_) {
      if (left() == 0) return;
      if (!is_uniform(piece) || graph_.after(piece) == graph_.betti()) continue;
      std::vector<char> before(graph_.size());
      for (std::uint32_t v = 0; v < graph_.size(); ++v) before[v] = graph_.inside(v);
      const std::int64_t was = left();
      graph_.flip(piece);
      std::vector<Group> around;
      for (const std::uint32_t v : piece) around.push_back({v});
      take(around, false);
      if (left() < was) continue;
      Group back;
      for (std::uint32_t v = 0; v < graph_.size(); ++v)
        if (graph_.inside(v) != static_cast<bool>(before[v])) back.push_back(v);
      graph_.flip(back);
    }
  }

  /// Undoes what makes no difference.
  void tidy() {
    for (bool again = true; again;) {
      again = false;
      for (std::uint32_t v = 0; v < graph_.size(); ++v) {
        if (graph_.inside(v) == static_cast<bool>(was_inside_[v]) || !is_simple(graph_.around(v))) continue;
        graph_.flip(Group{v});
        again = true;
      }
    }
  }

  VoxelGraph graph_;
  Betti wanted_;
  std::vector<char> was_inside_;
  std::vector<Group> pieces_;
  bool drops_parts_ = false;  ///< whether cuts may take away whole components, rather than have fills join them
};

}  // namespace

MatchedShape match_topology(const FixedMesh& mesh, const VoxelShape& shape, std::int64_t margin, const Betti& wanted,
                            Context* context) {
  const SurfaceCover cover = surface_cover(mesh, context);
  MatchedShape result;
  result.shape = shape;
  const DeflatedCover deflated = deflate(cover, shape, margin, context);
  std::vector<Voxel> loose = deflated.fills;
  loose.insert(loose.end(), deflated.cuts.begin(), deflated.cuts.end());
  std::sort(loose.begin(), loose.end(), [](const Voxel& a, const Voxel& b) {
    return std::array{a[2], a[1], a[0]} < std::array{b[2], b[1], b[0]};
  });
  Choice choice(shape, std::move(loose), wanted);
  choice.run();
  const std::vector<Voxel> flipped = choice.flipped();
  for (const Voxel& v : flipped) ++(shape.contains(v[0], v[1], v[2]) ? result.removed : result.added);
  result.shape = with_flipped(shape, flipped);
  result.betti = choice.graph().betti();
  return result;
}

}  // namespace quench::voxelization
