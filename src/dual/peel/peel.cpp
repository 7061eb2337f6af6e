// SPDX-License-Identifier: Apache-2.0
#include "dual/peel/peel.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <vector>

#include "base/parallel.h"
#include "dual/assemble.h"
#include "dual/from_polytopes.h"
#include "dual/peel/remainder.h"
#include "dual/peel/slab.h"

namespace quench::dual::peel {
namespace {

constexpr std::int32_t kFar = std::numeric_limits<std::int32_t>::max();
constexpr delaunay::Bounds kEverywhere{LatticePoint{-kFar, -kFar, -kFar}, LatticePoint{kFar, kFar, kFar}};

// The first layer of each slab, and the end of the last. `layers`: of a slab; 0: one slab for each thread, with about
// as many sites, since slabs overlap (with four for each, two threads had an eighth more to do, and one of them
// waited).
std::vector<std::int32_t> slab_limits(const Input& input, std::int32_t layers) {
  const auto& sites = input.sites;
  const std::int32_t end = sites.back()[2] + 1;
  std::vector<std::int32_t> limits{sites.front()[2]};
  const auto wanted = static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
  for (std::size_t slab = 1;; ++slab) {
    std::int32_t next = limits.back() + layers;
    if (layers == 0)
      next = slab < wanted ? std::max(limits.back() + 8 * input.layers(), sites[sites.size() / wanted * slab][2]) : end;
    if (next >= end || (layers == 0 && end - next < 8 * input.layers())) break;
    limits.push_back(next);
  }
  limits.push_back(end);
  return limits;
}

class Peeler {
 public:
  Peeler(const VoxelShape& shape, std::span<const LatticePoint> sites, const std::array<std::int64_t, 3>& spacing,
         const Options& options, Context* context)
      : shape_(shape), sites_(sites), spacing_(spacing), options_(options), context_(context) {}

  DualComplex run() {
    std::vector<CellsPart> slabs = peel();
    std::size_t peeled = 0;
    for (const CellsPart& slab : slabs) peeled += slab.cells.count();
    if (static_cast<double>(peeled) < options_.least_polytopes * static_cast<double>(sites_.size())) slabs.clear();
    if (slabs.empty())
      triangulate_all();
    else
      join(slabs);
    return assemble(std::move(whole_.cells), hulls_, sites_.size(), context_);
  }

 private:
  // One part per slab; nothing where the index would be too large.
  std::vector<CellsPart> peel() {
    if (SiteIndex::groups(shape_.grid().dims) > 4 * sites_.size() + options_.spare_groups) return {};
    const SiteIndex index(sites_);
    const delaunay::Predicates predicates(spacing_, *std::ranges::max_element(shape_.grid().dims) + 2);
    const Input input{
        shape_, sites_, spacing_, predicates, index, kEverywhere, options_.reach_in(spacing_), options_.least_cubes};
    const std::vector<std::int32_t> limits = slab_limits(input, options_.layers);
    std::vector<CellsPart> slabs(limits.size() - 1);
    base::for_chunks(slabs.size(), context_, "peel", 0, 1, [&](std::size_t slab) {
      delaunay::Bounds box = kEverywhere;
      box[0][2] = limits[slab];
      box[1][2] = limits[slab + 1] - 1;
      slabs[slab] = peel_box(input, box, hulls_);
    });
    return slabs;
  }

  void join(std::vector<CellsPart>& slabs) {
    if (slabs.size() > 1) whole_.cells.reserve_for(sites_.size());
    append(slabs, Numbers::per_part, whole_);
    match(whole_, sites_.size(), context_, "peel", 1);
    add_remainder(sites_, spacing_, hulls_, whole_, context_);
  }

  void triangulate_all() {
    auto delaunay = std::make_unique<delaunay::Delaunay>(sites_, spacing_, context_);
    append(delaunay::polytopes_inside(shape_, std::move(delaunay), sites_, context_), sites_,
           {.site = {}, .number = {}, .on_boundary = [](const auto&) { return true; }}, hulls_, whole_, context_);
  }

  const VoxelShape& shape_;
  std::span<const LatticePoint> sites_;
  const std::array<std::int64_t, 3>& spacing_;
  const Options& options_;
  Context* context_;
  Hulls hulls_;
  CellsPart whole_;
};

}  // namespace

DualComplex dual_complex(const VoxelShape& shape, std::span<const LatticePoint> sites,
                         const std::array<std::int64_t, 3>& spacing, const Options& options, Context* context) {
  return Peeler(shape, sites, spacing, options, context).run();
}

}  // namespace quench::dual::peel
