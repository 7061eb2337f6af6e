// SPDX-License-Identifier: Apache-2.0
#include "dual/bricks/rounds.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <iterator>
#include <numeric>
#include <string_view>
#include <thread>

#include "base/parallel.h"
#include "base/return_memory.h"
#include "dual/assemble.h"
#include "dual/bricks/brick.h"

namespace quench::dual::bricks {
namespace {

class Rounds {
 public:
  Rounds(const VoxelShape& shape, std::span<const LatticePoint> sites, const std::array<std::int64_t, 3>& spacing,
         Hulls& hulls, Context* context)
      : sites_(sites),
        spacing_(spacing),
        hulls_(hulls),
        context_(context),
        octants_(octants_of(shape, sites, context)),
        unfinished_(sites.size(), 1),
        finished_now_(sites.size(), 0),
        round_sites_(sites.size()) {
    std::iota(round_sites_.begin(), round_sites_.end(), 0u);
  }

  std::vector<CellsPart> run(const BrickPlan& plan) {
    const delaunay::Bounds bounds = delaunay::bounds_of(sites_);
    double done = 0;
    for (std::size_t round = 0;; ++round) {
      BrickGrid grid(bounds, spacing_);
      if (round < plan.rounds.size() && round_sites_.size() > plan.at_once)
        grid = BrickGrid(bounds, spacing_, plan.rounds[round].size, plan.rounds[round].halo);
      const double end = grid.whole() ? 1 : done + 0.7 * (1 - done);
      process_all(grid, done, end);
      if (!finish_round()) break;
      if (grid.whole()) throw Error(ErrorCode::invariant, "the polytopes around a site do not close up");
      done = end;
    }
    checkpoint(context_, "delaunay", 1);
    return std::move(found_);
  }

 private:
  // Of the work on a brick.
  static double share_of(std::string_view stage, double fraction) {
    return stage == "delaunay" ? 0.5 * fraction : 0.5 + 0.49 * fraction;
  }

  void process_all(const BrickGrid& grid, double begin, double end) {
    std::vector<std::uint32_t> unfinished;
    std::ranges::copy_if(round_sites_, std::back_inserter(unfinished), [&](std::uint32_t s) { return unfinished_[s]; });
    const std::vector<BrickIndex> bricks = grid.occupied(sites_, unfinished);
    std::vector<BrickPart> parts(bricks.size());
    const auto caller = std::this_thread::get_id();
    std::atomic<std::size_t> done{0};
    base::for_chunks(bricks.size(), nullptr, {}, 0, 1, [&](std::size_t b) {
      // A brick takes long: cancel is seen inside it. Progress is told by the calling thread only.
      Context inner;
      inner.progress = [&](std::string_view stage, double fraction) {
        if (std::this_thread::get_id() == caller)
          checkpoint(context_, "delaunay",
                     begin + (end - begin) * (static_cast<double>(done.load()) + share_of(stage, fraction)) /
                                 static_cast<double>(bricks.size()));
        else if (context_ && context_->cancelled())
          throw Error(ErrorCode::cancelled, "cancelled");
      };
      checkpoint(&inner, "delaunay", 0);
      const auto process = [&] { parts[b] = process_brick(brick(bricks[b], grid), hulls_, &inner); };
      // A brick is the work of one thread, which must not begin another one in the middle of it.
      if (grid.whole())
        process();
      else
        tbb::task_arena(1).execute(process);
      done.fetch_add(1);
      for (const std::uint32_t s : parts[b].finished) finished_now_[s] = 1;
    });
    checkpoint(context_, "delaunay", end);
    absorb_results(std::move(parts));
  }

  void absorb_results(std::vector<BrickPart> parts) {
    for (BrickPart& part : parts) {
      carried_.push_back(std::move(part.carried));
      found_.push_back(std::move(part.found));
    }
  }

  // The sites of this round in the region of a brick, found row by row.
  Brick brick(const BrickIndex& index, const BrickGrid& grid) const {
    Brick result(grid, index);
    result.spacing = spacing_;
    const auto [low, high] = grid.region(index);
    auto next = seek(round_sites_.begin(), {low[0], low[1], low[2]});
    while (next != round_sites_.end()) {
      const LatticePoint& p = sites_[*next];
      if (p[2] > high[2]) break;
      if (p[1] < low[1])
        next = seek(next, {low[0], low[1], p[2]});
      else if (p[1] > high[1])
        next = seek(next, {low[0], low[1], p[2] + 1});
      else if (p[0] < low[0])
        next = seek(next, {low[0], p[1], p[2]});
      else if (p[0] > high[0])
        next = seek(next, {low[0], p[1] + 1, p[2]});
      else {
        const std::uint32_t s = *next++;
        result.points.push_back(p);
        result.rank.push_back(s);
        result.octants.push_back(octants_[s]);
        result.state.push_back(!unfinished_[s]             ? SiteState::finished
                               : grid.brick_of(p) == index ? SiteState::own
                                                           : SiteState::unfinished);
      }
    }
    return result;
  }

  // The first site of the round, from `begin` on, that does not come before p; in steps of doubling size, as it is
  // near.
  using SiteIterator = std::vector<std::uint32_t>::const_iterator;
  SiteIterator seek(SiteIterator begin, const LatticePoint& p) const {
    const auto before = [&](std::uint32_t s) {
      return std::array{sites_[s][2], sites_[s][1], sites_[s][0]} < std::array{p[2], p[1], p[0]};
    };
    std::ptrdiff_t step = 1;
    while (step < round_sites_.end() - begin && before(begin[step - 1])) {
      begin += step;
      step *= 2;
    }
    return std::partition_point(begin, begin + std::min(step, round_sites_.end() - begin), before);
  }

  // Chooses the sites of the next round: the unfinished ones and all sites of the polytopes found so far that have one
  // of them. False: all sites are finished.
  bool finish_round() {
    for (const std::uint32_t s : round_sites_)
      if (finished_now_[s]) unfinished_[s] = 0;
    std::vector<std::uint8_t> wanted(finished_now_.size(), 0);
    for (SiteLists& lists : carried_) {
      SiteLists kept;
      for (std::size_t p = 0; p < lists.count(); ++p) {
        if (std::ranges::none_of(lists[p], [&](std::uint32_t s) { return unfinished_[s]; })) continue;
        for (const std::uint32_t s : lists[p]) wanted[s] = 1;
        kept.add(lists[p]);
      }
      lists = std::move(kept);
    }
    std::erase_if(carried_, [](const SiteLists& lists) { return lists.count() == 0; });
    round_sites_.clear();
    for (std::uint32_t s = 0; s < sites_.size(); ++s)
      if (unfinished_[s] || wanted[s]) round_sites_.push_back(s);
    round_sites_.shrink_to_fit();
    return std::ranges::any_of(unfinished_, [](std::uint8_t is) { return is != 0; });
  }

  std::span<const LatticePoint> sites_;
  std::array<std::int64_t, 3> spacing_;
  Hulls& hulls_;
  Context* context_;
  std::vector<Octants> octants_;
  std::vector<std::uint8_t> unfinished_;    // per site, as the round began
  std::vector<std::uint8_t> finished_now_;  // per site; bricks write those of their own sites
  std::vector<std::uint32_t> round_sites_;  // those that bound the balls of this round, ascending
  std::vector<SiteLists> carried_;          // polytopes found so far that have an unfinished site
  std::vector<CellsPart> found_;
};

}  // namespace

BrickPlan plan_for(const VoxelShape& shape) {
  const auto& dims = shape.grid().dims;
  const std::int64_t longest = *std::max_element(dims.begin(), dims.end());
  const std::int64_t size =
      std::max(std::clamp<std::int64_t>(longest / 2, 64, 512), std::min<std::int64_t>(longest / 8, 1024));
  return {.rounds = {{size, 16}, {4 * size, size / 2}}};
}

DualComplex dual_complex(const VoxelShape& shape, std::span<const LatticePoint> sites,
                         const std::array<std::int64_t, 3>& spacing, const BrickPlan& plan, Context* context) {
  base::check_index(sites.size());
  Hulls hulls;
  std::vector<CellsPart> found = Rounds(shape, sites, spacing, hulls, context).run(plan);
  base::return_free_memory();
  CellsPart whole;
  append(found, Numbers::per_part, whole);
  match_all(whole, sites.size(), context, "merge", 0.7);
  DualComplex dual = assemble(std::move(whole.cells), hulls, sites.size(), context);
  base::return_free_memory();
  return dual;
}

}  // namespace quench::dual::bricks
