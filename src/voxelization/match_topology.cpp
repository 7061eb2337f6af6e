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

/// Which pieces are flipped.
class Choice {
 public:
  Choice(const VoxelShape& shape, std::int64_t euler, std::vector<Voxel> loose, const Betti& wanted)
      : graph_(shape, euler, std::move(loose)), wanted_(wanted), was_inside_(graph_.size()) {
    for (std::uint32_t v = 0; v < graph_.size(); ++v) was_inside_[v] = graph_.inside(v);
    find_pieces();
  }

  void run() {
    most_work_ = enough_work();
    choose();
    if (left() == 0) return;
    // Where no order of single pieces does it: from all fills on.
    const Group first = changed();
    const std::int64_t was = left();
    graph_.flip(first);
    Group fills;
    for (const Group& piece : pieces_)
      if (!was_inside_[piece[0]]) fills.insert(fills.end(), piece.begin(), piece.end());
    graph_.flip(fills);
    most_work_ = enough_work();
    choose();
    if (left() < was) return;
    graph_.flip(changed());
    graph_.flip(first);
  }

  Topology topology() const {
    const Betti b = graph_.betti();
    return {b[0] - b[1] + b[2], b};
  }
  std::int64_t left() const { return off(graph_.betti(), wanted_); }
  std::vector<Voxel> flipped() const {
    std::vector<Voxel> result;
    for (const std::uint32_t v : changed()) result.push_back(graph_.voxel(v));
    return result;
  }
  /// A voxel each of some pieces that would bring one of the numbers nearer, but could not be used; of any that change
  /// the topology where there are none. The largest pieces first.
  std::vector<Voxel> places() {
    constexpr std::size_t kPlaces = 3;
    std::vector<Voxel> result;
    for (const bool any : {false, true})
      for (auto piece = pieces_.rbegin(); piece != pieces_.rend() && result.size() < kPlaces; ++piece) {
        if (!is_uniform(*piece)) continue;
        const Betti after = graph_.after(*piece);
        bool nearer = any && after != graph_.betti();
        for (std::size_t i = 0; i < 3; ++i)
          nearer = nearer || std::abs(after[i] - wanted_[i]) < std::abs(graph_.betti()[i] - wanted_[i]);
        if (nearer) result.push_back(graph_.voxel(piece->front()));
      }
    return result;
  }

 private:
  /// More of VoxelGraph::work(), then what is not reached is given up: about a second, or what is linear.
  std::int64_t enough_work() const { return graph_.work() + 8'000'000 + 20 * static_cast<std::int64_t>(graph_.size()); }

  /// Fills before cuts, so that what is thin is mended rather than torn open further; cuts that take components away
  /// come last.
  void choose() {
    for (const bool drops_parts : {false, true}) {
      drops_parts_ = drops_parts;
      for (const bool cuts : {false, true})
        for (const bool only_harmless : {true, false}) take(of_kind(cuts), only_harmless);
      take(single_voxels(), false);
      if (left() > 0) take_with_single_voxels();
    }
    tidy();
  }

  std::vector<Group> of_kind(bool cuts) const {
    std::vector<Group> result;
    for (const Group& piece : pieces_)
      if (static_cast<bool>(was_inside_[piece[0]]) == cuts) result.push_back(piece);
    return result;
  }

  Group changed() const {
    Group result;
    for (std::uint32_t v = 0; v < graph_.size(); ++v)
      if (graph_.inside(v) != static_cast<bool>(was_inside_[v])) result.push_back(v);
    return result;
  }

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
        if (graph_.work() > most_work_) return;
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
      if (left() == 0 || graph_.work() > most_work_) return;
      if (!is_uniform(piece) || graph_.after(piece) == graph_.betti()) continue;
      const bool before = graph_.inside(piece[0]);
      const std::int64_t was = left();
      graph_.flip(piece);
      std::vector<Group> around;
      for (const std::uint32_t v : piece) around.push_back({v});
      take(around, false);
      if (left() < was) continue;
      Group back;
      for (const std::uint32_t v : piece)
        if (graph_.inside(v) != before) back.push_back(v);
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
  std::int64_t most_work_ = 0;
  bool drops_parts_ = false;  ///< whether cuts may take away whole components, rather than have fills join them
};

}  // namespace

MatchedShape match_topology(const FixedMesh& mesh, const VoxelShape& shape, std::int64_t margin, const Topology& before,
                            const Betti& wanted, const Progress& progress) {
  const SurfaceCover cover = surface_cover(mesh, progress);
  Choice choice(shape, before.euler, deflate(cover, shape, margin, progress), wanted);
  choice.run();
  const std::vector<Voxel> flipped = choice.flipped();
  MatchedShape result;
  result.shape = with_flipped(shape, flipped);
  result.topology = choice.topology();
  for (const Voxel& v : flipped) ++(shape.contains(v[0], v[1], v[2]) ? result.removed : result.added);
  if (choice.left() > 0) result.places = choice.places();
  return result;
}

}  // namespace quench::voxelization
