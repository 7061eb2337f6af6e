// SPDX-License-Identifier: Apache-2.0
#include "bricks/dual_complex_in_bricks.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <string_view>
#include <thread>

#include "base/parallel.h"
#include "bricks/assembly.h"
#include "bricks/brick.h"
#include "lattice/polytopes.h"

namespace quench::bricks {
namespace {

class Rounds {
 public:
  Rounds(const VoxelShape& shape, std::span<const LatticePoint> sites, const std::array<std::int64_t, 3>& spacing,
         Context* context)
      : sites_(sites),
        spacing_(spacing),
        context_(context),
        octants_(octants_of(shape, sites, context)),
        unfinished_(sites.size(), 1),
        finished_now_(sites.size(), 0),
        low_(sites[0]),
        high_(sites[0]) {
    for (const LatticePoint& s : sites)
      for (std::size_t a = 0; a < 3; ++a) {
        low_[a] = std::min(low_[a], s[a]);
        high_[a] = std::max(high_[a], s[a]);
      }
  }

  std::vector<BrickPart> run(const BrickPlan& plan) {
    double done = 0;
    for (std::size_t round = 0;; ++round) {
      BrickGrid grid(low_, high_, spacing_);
      if (round < plan.rounds.size() && site_count() > plan.at_once)
        grid = BrickGrid(low_, high_, spacing_, plan.rounds[round].size, plan.rounds[round].halo);
      const double end = grid.whole() ? 1 : done + 0.7 * (1 - done);
      work_on_all(grid, done, end);
      if (!settle()) break;
      if (grid.whole()) throw Error(ErrorCode::invariant, "cells of the voxel core do not close up around a site");
      done = end;
    }
    checkpoint(context_, "delaunay", 1);
    return std::move(parts_);
  }

 private:
  // The sites that bound the balls of this round: all of them at first, then those of `known_sites_`.
  std::size_t site_count() const { return first_ ? sites_.size() : known_sites_.size(); }
  std::uint32_t rank(std::size_t i) const { return first_ ? static_cast<std::uint32_t>(i) : known_sites_[i]; }
  const LatticePoint& site(std::size_t i) const { return sites_[rank(i)]; }

  // Of the work on a brick.
  static double share_of(std::string_view stage, double fraction) {
    return stage == "delaunay" ? 0.5 * fraction : 0.5 + 0.49 * fraction;
  }

  void work_on_all(const BrickGrid& grid, double begin, double end) {
    if (grid.whole()) {  // on all threads
      Context inner;
      inner.progress = [&](std::string_view stage, double fraction) {
        checkpoint(context_, "delaunay", begin + (end - begin) * share_of(stage, fraction));
      };
      std::vector<BrickPart> part(1);
      part[0] = work(brick({0, 0, 0}, grid), &inner);
      take(part);
      return;
    }
    std::vector<std::uint32_t> left;
    if (!first_)
      for (const std::uint32_t s : known_sites_)
        if (unfinished_[s]) left.push_back(s);
    const std::vector<BrickIndex> bricks = grid.occupied(first_ ? sites_.size() : left.size(),
                                                         [&](std::size_t i) { return sites_[first_ ? i : left[i]]; });
    std::vector<BrickPart> parts(bricks.size());
    const auto caller = std::this_thread::get_id();
    std::atomic<std::size_t> done{0};
    const auto progress = [&](double more) {
      return begin + (end - begin) * (static_cast<double>(done.load()) + more) / static_cast<double>(bricks.size());
    };
    base::for_chunks(bricks.size(), nullptr, {}, 0, 1, [&](std::size_t b) {
      // A brick takes long: cancel is seen inside it. Progress is told by the calling thread only.
      Context inner;
      inner.progress = [&](std::string_view stage, double fraction) {
        if (std::this_thread::get_id() == caller)
          checkpoint(context_, "delaunay", progress(share_of(stage, fraction)));
        else if (context_ && context_->cancelled())
          throw Error(ErrorCode::cancelled, "cancelled");
      };
      checkpoint(&inner, "delaunay", 0);
      // A brick is the work of one thread, which must not begin another one in the middle of it.
      tbb::task_arena(1).execute([&] { parts[b] = work(brick(bricks[b], grid), &inner); });
      done.fetch_add(1);
      for (const std::uint32_t s : parts[b].finished) finished_now_[s] = 1;
      std::vector<std::uint32_t>().swap(parts[b].finished);
    });
    checkpoint(context_, "delaunay", end);
    take(parts);
  }

  void take(std::vector<BrickPart>& parts) {
    for (BrickPart& part : parts) {
      for (const std::uint32_t s : part.finished) finished_now_[s] = 1;
      std::vector<std::uint32_t>().swap(part.finished);
      known_.push_back(std::move(part.known));
      part.known = {};
      parts_.push_back(std::move(part));
    }
  }

  // The sites of this round in the region of a brick, found row by row.
  Brick brick(const BrickIndex& index, const BrickGrid& grid) const {
    Brick result(grid, index);
    result.spacing = spacing_;
    const auto [low, high] = grid.region(index);
    std::size_t i = seek(0, {low[0], low[1], low[2]});
    while (i < site_count()) {
      const LatticePoint& p = site(i);
      if (p[2] > high[2]) break;
      if (p[1] < low[1])
        i = seek(i, {low[0], low[1], p[2]});
      else if (p[1] > high[1])
        i = seek(i, {low[0], low[1], p[2] + 1});
      else if (p[0] < low[0])
        i = seek(i, {low[0], p[1], p[2]});
      else if (p[0] > high[0])
        i = seek(i, {low[0], p[1] + 1, p[2]});
      else {
        const std::uint32_t s = rank(i++);
        result.points.push_back(p);
        result.rank.push_back(s);
        result.octants.push_back(octants_[s]);
        result.role.push_back(!unfinished_[s] ? Role::known : grid.brick_of(p) == index ? Role::own : Role::unfinished);
      }
    }
    return result;
  }

  // The first site from the i-th on that does not come before p.
  std::size_t seek(std::size_t i, const LatticePoint& p) const {
    const auto before = [&](std::size_t k) {
      const LatticePoint& s = site(k);
      return std::array{s[2], s[1], s[0]} < std::array{p[2], p[1], p[0]};
    };
    std::size_t step = 1, last = i;  // everything before `last` comes before p
    while (last + step <= site_count() && before(last + step - 1)) {
      last += step;
      step *= 2;
    }
    std::size_t end = std::min(last + step - 1, site_count());
    while (last < end) {
      const std::size_t middle = last + (end - last) / 2;
      if (before(middle))
        last = middle + 1;
      else
        end = middle;
    }
    return last;
  }

  // Ends a round: what is left of the sites, and what must be known to finish them: themselves and all sites of the
  // cells found so far that have one of them. False: nothing is left.
  bool settle() {
    for (std::size_t i = 0; i < site_count(); ++i)
      if (finished_now_[rank(i)]) unfinished_[rank(i)] = 0;
    std::vector<std::uint8_t> wanted(finished_now_.size(), 0);
    for (SiteLists& lists : known_) {
      SiteLists kept;
      for (std::size_t p = 0; p < lists.count(); ++p) {
        const auto begin = lists.sites.begin() + lists.offsets[p], end = lists.sites.begin() + lists.offsets[p + 1];
        if (std::none_of(begin, end, [&](std::uint32_t s) { return unfinished_[s]; })) continue;
        for (auto s = begin; s != end; ++s) wanted[*s] = 1;
        kept.sites.insert(kept.sites.end(), begin, end);
        kept.offsets.push_back(static_cast<std::uint32_t>(kept.sites.size()));
      }
      lists = std::move(kept);
    }
    std::erase_if(known_, [](const SiteLists& lists) { return lists.count() == 0; });
    std::vector<std::uint32_t> next;
    bool left = false;
    for (std::size_t i = 0; i < sites_.size(); ++i) {
      left |= unfinished_[i] != 0;
      if (unfinished_[i] || wanted[i]) next.push_back(static_cast<std::uint32_t>(i));
    }
    known_sites_ = std::move(next);
    first_ = false;
    return left;
  }

  std::span<const LatticePoint> sites_;
  std::array<std::int64_t, 3> spacing_;
  Context* context_;
  std::vector<Octants> octants_;
  std::vector<std::uint8_t> unfinished_;    // per site, as the round began
  std::vector<std::uint8_t> finished_now_;  // per site; bricks write those of their own sites
  LatticePoint low_, high_;                 // of all sites
  bool first_ = true;
  std::vector<std::uint32_t> known_sites_;  // after the first round
  std::vector<SiteLists> known_;            // cells found so far that have an unfinished site
  std::vector<BrickPart> parts_;
};

}  // namespace

BrickPlan plan_for(const VoxelShape& shape) {
  const auto& dims = shape.grid().dims;
  const std::int64_t longest = *std::max_element(dims.begin(), dims.end());
  const std::int64_t size =
      std::max(std::clamp<std::int64_t>(longest / 2, 64, 512), std::min<std::int64_t>(longest / 8, 1024));
  return {.rounds = {{size, 16}, {4 * size, size / 2}}};
}

lattice::DualComplex dual_complex_in_bricks(const VoxelShape& shape, std::span<const LatticePoint> sites,
                                            const std::array<std::int64_t, 3>& spacing, const BrickPlan& plan,
                                            Context* context) {
  lattice::check_index(sites.size());
  std::vector<BrickPart> parts = Rounds(shape, sites, spacing, context).run(plan);
  return assemble(std::move(parts), sites.size(), context);
}

}  // namespace quench::bricks
