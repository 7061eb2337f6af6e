// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "dual/bricks/part.h"
#include "dual/bricks/part_order.h"
#include "dual/peel/peel.h"
#include "dual/peel/slab.h"

namespace quench::dual::bricks {

// A polytope that is looked for extends from its smallest site by no more than the diameter of its ball, one of a unit
// cube by one voxel. One more for rounding.
std::int32_t margin_of_first_part(const std::array<std::int64_t, 3>& spacing) {
  const double reach = peel::Options{}.reach_in(spacing);
  return 1 +
         std::max(1, static_cast<std::int32_t>(std::ceil(2 * reach / static_cast<double>(std::ranges::min(spacing)))));
}

Part first_part(const VoxelShape& shape, const LatticePoint& at, std::span<const LatticePoint> sites, const Box& box,
                const std::array<std::int64_t, 3>& spacing, Hulls& hulls, Context* context) {
  Part part;
  std::ranges::copy_if(sites, std::back_inserter(part.pending), [&](const auto& s) { return box.contains(s); });
  if (part.pending.empty()) return part;
  checkpoint(context, "peel", 0);
  std::vector<LatticePoint> local(sites.begin(), sites.end());
  for (LatticePoint& s : local)
    for (std::size_t a = 0; a < 3; ++a) s[a] -= at[a];
  delaunay::Bounds own, known;
  const std::int32_t margin = margin_of_first_part(spacing);
  for (std::size_t a = 0; a < 3; ++a) {
    own[0][a] = static_cast<std::int32_t>(box.low[a] - at[a]);
    own[1][a] = static_cast<std::int32_t>(box.high[a] - at[a] - 1);
    known[0][a] = own[0][a] - margin;
    known[1][a] = own[1][a] + margin;
  }
  const peel::Options options;
  const peel::SiteIndex index(local);
  const delaunay::Predicates predicates(spacing, std::ranges::max(shape.grid().dims) + 2);
  const peel::Input input{
      shape, local, spacing, predicates, index, known, options.reach_in(spacing), options.least_cubes};
  part.found = peel::peel_box(input, own, hulls);
  part.sites.assign(sites.begin(), sites.end());
  drop_unnamed_sites(part);
  put_in_order(part, context);
  return part;
}

}  // namespace quench::dual::bricks
