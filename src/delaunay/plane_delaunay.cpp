// SPDX-License-Identifier: Apache-2.0
#include "delaunay/plane_delaunay.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

#include "base/index.h"

namespace quench::delaunay {

class PlaneDelaunay::Builder {
 public:
  Builder(std::span<const LatticePoint> sites, const std::array<std::int64_t, 3>& spacing, PlaneDelaunay& triangulation,
          Context* context)
      : sites_(sites),
        in_circle_(spacing),
        triangulation_(triangulation),
        half_edges_(triangulation.half_edges_.data()),
        context_(context) {
    for (std::size_t s = 0; s < sites.size(); ++s)
      if (s == 0 || sites[s][1] != sites[s - 1][1]) row_begin_.push_back(static_cast<std::uint32_t>(s));
    row_begin_.push_back(static_cast<std::uint32_t>(sites.size()));
  }

  void run() {
    if (!sites_.empty()) triangulate(0, row_begin_.size() - 1);
  }

 private:
  // Rows [begin, end). Halves are of about as many sites.
  Part triangulate(std::size_t begin, std::size_t end) {
    if (end - begin == 1) return chain(row_begin_[begin], row_begin_[end]);
    const std::uint32_t count = row_begin_[end] - row_begin_[begin];
    const auto half =
        std::lower_bound(row_begin_.begin() + static_cast<std::ptrdiff_t>(begin) + 1,
                         row_begin_.begin() + static_cast<std::ptrdiff_t>(end) - 1, row_begin_[begin] + count / 2);
    const auto middle = static_cast<std::size_t>(half - row_begin_.begin());
    constexpr std::uint32_t kWorthATask = 1 << 13;
    if (count <= kWorthATask) return merge(triangulate(begin, middle), triangulate(middle, end));
    report();
    Part left, right;
    tbb::parallel_invoke([&] { left = triangulate(begin, middle); }, [&] { right = triangulate(middle, end); });
    for (const std::uint32_t size : {row_begin_[middle] - row_begin_[begin], row_begin_[end] - row_begin_[middle]})
      if (size <= kWorthATask) done_.fetch_add(size, std::memory_order_relaxed);
    return merge(left, right);
  }

  // Progress by the thread that began; the others only ask whether to stop.
  void report() {
    if (std::this_thread::get_id() == caller_)
      checkpoint(context_, "peel",
                 0.5 * static_cast<double>(done_.load(std::memory_order_relaxed)) / static_cast<double>(sites_.size()));
    else if (context_ && context_->cancelled())
      throw Error(ErrorCode::cancelled, "cancelled");
  }

  // Sites [begin, end) of one row, two or more.
  Part chain(std::uint32_t begin, std::uint32_t end) {
    const std::uint32_t first = 6 * begin;
    std::uint32_t e = first;
    for (std::uint32_t s = begin; s + 1 < end; ++s, e += 2) {
      const std::uint32_t before = s > begin ? e - 1 : e, after = s + 2 < end ? e + 2 : e + 1;
      half_edges_[e] = {s, before, before};
      half_edges_[e + 1] = {s + 1, after, after};
    }
    const Part part{first, e - 1, e, 6 * end - 2};
    for (; e < 6 * end; e += 2) {
      half_edges_[e] = {kNone, e + 2 < 6 * end ? e + 2 : kNone, kNone};
      half_edges_[e + 1].origin = kNone;
    }
    return part;
  }

  // Zips two triangulations along the line between them, from its lower end to its upper one. `base` is the last edge
  // across, from right to left; candidates for the next triangle are neighbours of its ends.
  Part merge(const Part& l, const Part& r) {
    Part part{l.first, r.last, l.unused, r.unused_end};
    half_edges_[l.unused_end].next = r.unused;
    auto [left, right] = lower_tangent(l.last, r.first);
    std::uint32_t base = connect(part, right ^ 1, left);
    if (origin(left) == origin(part.first)) part.first = base ^ 1;
    if (origin(right) == origin(part.last)) part.last = base;
    for (;;) {
      const LatticePoint &low = site(destination(base)), &high = site(origin(base));
      const auto above = [&](std::uint32_t e) { return orientation(site(destination(e)), low, high) > 0; };
      const auto follow = [&](std::uint32_t candidate, std::uint32_t HalfEdge::*turn) {
        if (!above(candidate)) return kNone;
        for (;;) {
          const std::uint32_t beyond = half_edges_[candidate].*turn;
          if (!(in_circle_(low, high, site(destination(candidate)), site(destination(beyond))) > 0)) return candidate;
          remove(part, candidate);
          candidate = beyond;
        }
      };
      const std::uint32_t a = follow(half_edges_[base ^ 1].next, &HalfEdge::next);
      const std::uint32_t b = follow(half_edges_[base].previous, &HalfEdge::previous);
      if (a == kNone && b == kNone) return part;
      if (a == kNone || (b != kNone && in_circle_(site(destination(a)), low, high, site(destination(b))) > 0))
        base = connect(part, b, base ^ 1);
      else
        base = connect(part, base ^ 1, a ^ 1);
    }
  }

  // Half-edges of both that start at the ends of the lower common tangent.
  std::array<std::uint32_t, 2> lower_tangent(std::uint32_t left, std::uint32_t right) const {
    for (;;) {
      if (orientation(site(origin(right)), site(origin(left)), site(destination(left))) > 0)
        left = half_edges_[left ^ 1].previous;
      else if (orientation(site(origin(left)), site(destination(right)), site(origin(right))) > 0)
        right = half_edges_[right ^ 1].next;
      else
        return {left, right};
    }
  }

  // A new edge from the destination of a to the origin of b, which have the same face on their left, as it will.
  std::uint32_t connect(Part& part, std::uint32_t a, std::uint32_t b) {
    const std::uint32_t e = part.unused;
    part.unused = half_edges_[e].next;
    insert(e, destination(a), half_edges_[a ^ 1].previous);
    insert(e ^ 1, origin(b), b);
    return e;
  }
  // Counter-clockwise after `before`.
  void insert(std::uint32_t e, std::uint32_t origin, std::uint32_t before) {
    const std::uint32_t after = half_edges_[before].next;
    half_edges_[e] = {origin, after, before};
    half_edges_[before].next = e;
    half_edges_[after].previous = e;
  }
  void remove(Part& part, std::uint32_t e) {
    triangulation_.remove(e);
    half_edges_[e & ~1u].next = part.unused;
    part.unused = e & ~1u;
  }

  const LatticePoint& site(std::uint32_t s) const { return sites_[s]; }
  std::uint32_t origin(std::uint32_t e) const { return half_edges_[e].origin; }
  std::uint32_t destination(std::uint32_t e) const { return half_edges_[e ^ 1].origin; }

  std::span<const LatticePoint> sites_;
  const InCircle in_circle_;
  PlaneDelaunay& triangulation_;
  HalfEdge* const half_edges_;
  Context* context_;
  const std::thread::id caller_ = std::this_thread::get_id();
  std::atomic<std::size_t> done_{0};  // sites in parts that are finished but for large merges
  std::vector<std::uint32_t> row_begin_;
};

PlaneDelaunay::PlaneDelaunay(std::span<const LatticePoint> sites, const std::array<std::int64_t, 3>& spacing,
                             Context* context) {
  // A planar graph of n sites has fewer than 3 n edges.
  base::check_index(6 * sites.size());
  half_edges_.resize(6 * sites.size());
  Builder(sites, spacing, *this, context).run();
}

}  // namespace quench::delaunay
