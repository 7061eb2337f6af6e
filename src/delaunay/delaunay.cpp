// SPDX-License-Identifier: Apache-2.0
#include "delaunay/delaunay.h"

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <memory>
#include <thread>
#include <vector>

#include "delaunay/site_order.h"

namespace quench::delaunay {
namespace {

constexpr std::uint32_t kAlone = 1 << 12;  // points that one thread inserts before several find room
constexpr std::uint32_t kBatch = 1 << 16;  // points per thread and batch

}  // namespace

Delaunay::Box Delaunay::enclosing_box(const Bounds& bounds, const std::array<std::int64_t, 3>& spacing) {
  Box box{{0, 0, 0}, {0, 0, 0}, 0};
  std::array<std::int64_t, 3> sorted = spacing;
  std::sort(sorted.begin(), sorted.end());
  const double overhang = 0.5 * std::sqrt(static_cast<double>(sorted[1] * sorted[1] + sorted[2] * sorted[2]));
  for (int a = 0; a < 3; ++a) {
    // spacing * voxels <= 2^20 on every axis, so overhang < 0.71 * 2^20 and spacing * margin < overhang + 3 * spacing.
    // The difference D of the box's corners then obeys spacing * D < (1 + 2 * 3.71) * 2^20, so its square is below
    // 2^47, and D < (1 + 2 * 0.71) * 2^20 / spacing + 6 < 2^22.
    const auto margin = static_cast<std::int64_t>(std::ceil(overhang / static_cast<double>(spacing[a]))) + 2;
    box.low[a] = bounds[0][a] - margin;
    box.high[a] = bounds[1][a] + margin;
    box.extent = std::max(box.extent, box.high[a] - box.low[a]);
  }
  return box;
}

Delaunay::Delaunay(std::span<const LatticePoint> sites, const std::array<std::int64_t, 3>& spacing, const Box& box,
                   Context* context)
    : triangulation_(spacing, box.extent) {
  if (sites.size() > kMostSites)
    throw Error(ErrorCode::failed,
                fmt::format("{} boundary vertices are more than this version can triangulate at once "
                            "({}); use a lower resolution",
                            sites.size(), kMostSites));
  const std::vector<std::uint32_t> order = insertion_order(sites);
  auto& points = triangulation_.points;
  points.reserve(sites.size() + kBoxPoints);
  for (std::uint32_t c = 0; c < kBoxPoints; ++c)
    points.push_back({static_cast<std::int32_t>(c & 1 ? box.high[0] : box.low[0]),
                      static_cast<std::int32_t>(c & 2 ? box.high[1] : box.low[1]),
                      static_cast<std::int32_t>(c & 4 ? box.high[2] : box.low[2]), kNone});
  for (std::uint32_t i : order) points.push_back({sites[i][0], sites[i][1], sites[i][2], i});
  triangulation_.grow(sites.size() * 7 + 1000);
  cut_box();
  insert_all(context);
  triangulation_.tetrahedra.resize(triangulation_.used);
  base::RawHugeVector<std::uint8_t>().swap(triangulation_.owner);
}

// The box cut into six tetrahedra around its diagonal 0-7, one per path of unit steps from corner 0 to corner 7;
// neighbouring paths differ in one corner. Its corners are cospherical, so any triangulation is Delaunay.
void Delaunay::cut_box() {
  const auto& points = triangulation_.points;
  auto& tetrahedra = triangulation_.tetrahedra;
  constexpr std::uint32_t kSteps[6][2] = {{1, 3}, {3, 2}, {2, 6}, {6, 4}, {4, 5}, {5, 1}};
  for (std::uint32_t t = 0; t < 6; ++t) {
    tetrahedra[t] = {{0, kSteps[t][0], kSteps[t][1], 7}, {kNone, kNone, kNone, kNone}};
    triangulation_.owner[t] = 0;
  }
  for (std::uint32_t t = 0; t < 6; ++t) {
    // Across the facet without its first step corner lies the next one around the diagonal.
    const std::uint32_t next = (t + 1) % 6;
    tetrahedra[t].neighbour[1] = 4 * next + 2;
    tetrahedra[next].neighbour[2] = 4 * t + 1;
    const auto& c = tetrahedra[t].corner;
    if (triangulation_.predicates.orientation(points[c[0]], points[c[1]], points[c[2]], points[c[3]]) < 0)
      throw Error(ErrorCode::invariant, "the enclosing box is cut wrongly");
  }
  triangulation_.used = 6;
}

void Delaunay::insert_all(Context* context) {
  const auto count = static_cast<std::uint32_t>(triangulation_.points.size());
  const auto allowed =
      static_cast<int>(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
  const auto workers =
      static_cast<std::uint32_t>(std::clamp(std::min(tbb::this_task_arena::max_concurrency(), allowed), 1, 126));
  const std::uint32_t alone = workers == 1 ? count : std::min(count, kBoxPoints + kAlone);
  Inserter<false> inserter(triangulation_, 0);
  for (std::uint32_t p = kBoxPoints; p < alone; ++p) {
    if ((p & 0x3FFF) == 0) checkpoint(context, "delaunay", static_cast<double>(p) / count);
    inserter.insert(p);
  }
  insert_together(alone, count, workers, context);
  checkpoint(context, "delaunay", 1);
}

namespace {

// Inserts points by several threads, a contiguous range of the order each.
class Team {
 public:
  Team(Triangulation& triangulation, std::uint32_t workers, Context* context)
      : triangulation_(triangulation), context_(context), caller_(std::this_thread::get_id()) {
    for (std::uint32_t w = 0; w < workers; ++w)
      workers_.push_back(std::make_unique<Worker>(Worker{Inserter<true>(triangulation_, w), {}, {}}));
  }

  // Inserts `count` points from `first` on; those that find no free slot are appended to `left`. Progress ends at
  // `total`.
  void insert(std::uint32_t first, std::uint32_t count, std::uint32_t total, std::vector<std::uint32_t>& left) {
    const auto workers = static_cast<std::uint32_t>(workers_.size());
    const auto at = [&](std::uint32_t i) {
      return first + static_cast<std::uint32_t>(std::uint64_t{count} * i / workers);
    };
    tbb::parallel_for(std::uint32_t{0}, workers, [&](std::uint32_t w) {
      try {
        work(*workers_[w], at(w), at(w + 1), [&](double share) { return (first + count * share) / total; });
      } catch (...) {
        // What this worker owned stays owned, so the others must not wait for it. TBB would rethrow the exception only
        // after all of them have ended.
        if (!triangulation_.abandoned.exchange(true)) failure_ = std::current_exception();
      }
    });
    if (triangulation_.abandoned) std::rethrow_exception(failure_);
    for (const auto& worker : workers_) {
      left.insert(left.end(), worker->left.begin(), worker->left.end());
      worker->left.clear();
    }
  }

 private:
  using Outcome = Inserter<true>::Outcome;
  struct Worker {
    Inserter<true> inserter;
    std::vector<std::uint32_t> later, left;  // points near another worker; points without slots
  };

  // `progress(share)`: where the stage is when this share of the points has been inserted.
  template <class Progress>
  void work(Worker& worker, std::uint32_t begin, std::uint32_t end, const Progress& progress) {
    for (std::uint32_t p = begin; p < end; ++p) {
      if (triangulation_.abandoned.load(std::memory_order_relaxed)) return;
      if (((p - begin) & 0x3FF) == 0) poll(progress(static_cast<double>(p - begin) / (end - begin)));
      if (insert(worker, p) == Outcome::busy) worker.later.push_back(p);
    }
    for (const std::uint32_t p : worker.later)
      while (insert(worker, p) == Outcome::busy) {
        if (triangulation_.abandoned.load(std::memory_order_relaxed)) return;
        poll(progress(1));
        std::this_thread::yield();
      }
    worker.later.clear();
  }

  static Outcome insert(Worker& worker, std::uint32_t p) {
    const Outcome outcome = worker.inserter.insert(p);
    if (outcome == Outcome::full) worker.left.push_back(p);
    return outcome;
  }

  // Every worker asks whether the caller wants to stop; the calling thread also reports progress.
  void poll(double progress) const {
    if (std::this_thread::get_id() == caller_)
      checkpoint(context_, "delaunay", progress);
    else if (context_ && context_->cancelled())
      throw Error(ErrorCode::cancelled, "cancelled");
  }

  Triangulation& triangulation_;
  Context* context_;
  const std::thread::id caller_;
  std::vector<std::unique_ptr<Worker>> workers_;
  std::exception_ptr failure_;  // of the worker that abandoned the triangulation
};

}  // namespace

// Each thread has a contiguous part of the Hilbert curve, so that they seldom meet.
void Delaunay::insert_together(std::uint32_t begin, std::uint32_t end, std::uint32_t workers, Context* context) {
  if (begin == end) return;
  Team team(triangulation_, workers, context);
  Inserter<false> alone(triangulation_, workers);
  std::vector<std::uint32_t> left;
  for (std::uint32_t first = begin; first < end;) {
    const std::uint32_t batch = std::min(end - first, workers * kBatch);
    triangulation_.grow(triangulation_.used + std::size_t{8} * batch);
    triangulation_.settled = triangulation_.used;
    team.insert(first, batch, end, left);
    first += batch;
    for (const std::uint32_t p : left) alone.insert(p);
    left.clear();
  }
}

void Delaunay::validate() const {
  const auto fail = [](std::size_t t, const char* what) {
    throw Error(ErrorCode::invariant, fmt::format("Delaunay: tetrahedron {} {}", t, what));
  };
  const auto& tetrahedra = triangulation_.tetrahedra;
  const auto& points = triangulation_.points;
  for (std::size_t t = 0; t < tetrahedra.size(); ++t) {
    const Tetrahedron& tet = tetrahedra[t];
    if (tet.corner[0] == kNone) continue;
    const auto& c = tet.corner;
    if (triangulation_.predicates.orientation(points[c[0]], points[c[1]], points[c[2]], points[c[3]]) <= 0)
      fail(t, "is not positive");
    for (std::uint32_t i = 0; i < 4; ++i) {
      if (tet.neighbour[i] == kNone) continue;
      const Tetrahedron& other = tetrahedra[tet.neighbour[i] >> 2];
      const std::uint32_t j = tet.neighbour[i] & 3;
      if (other.corner[0] == kNone) fail(t, "has a dead neighbour");
      if (other.neighbour[j] != 4 * t + i) fail(t, "has a neighbour that does not know it");
      std::array<std::uint32_t, 4> mine = c, theirs = other.corner;
      mine[i] = theirs[j] = kNone;
      std::sort(mine.begin(), mine.end());
      std::sort(theirs.begin(), theirs.end());
      if (mine != theirs) fail(t, "and its neighbour do not share a facet");
      if (triangulation_.conflicts(static_cast<std::uint32_t>(t), points[other.corner[j]]))
        fail(t, "has a site inside its ball");
    }
  }
}

}  // namespace quench::delaunay
