// SPDX-License-Identifier: Apache-2.0
// docs/algorithms/pruning.md
#include <algorithm>
#include <span>
#include <string>
#include <utility>

#include "axis/cover.h"
#include "axis/measures.h"
#include "axis/reach.h"
#include "axis/rest_of_core.h"
#include "axis/significant_parts.h"
#include "base/parallel.h"

namespace quench {
namespace {

// `pending`: boundary vertices that may have to be covered.
CellValues details(const MedialAxis& axis, const axis::Carried& carried, std::span<const double> known,
                   std::span<const LatticePoint> pending, const Surface* surface, Context* context) {
  const double least = auto_detail(axis.grid);
  checkpoint(context, "detail", 0);
  CellValues detail = axis::heights_of(axis, carried, known, surface, context);
  const axis::TopCells cells(axis.complex, detail);
  axis::SignificantParts parts(cells, axis.complex.vertex_count, least);
  parts.set_details();
  checkpoint(context, "detail", 0.3);
  axis::cover_boundary(axis, least, pending, parts, cells, detail, context);
  base::for_indices(carried.edge_detail.size(),
                    [&](std::size_t e) { detail.edge[e] = std::max(detail.edge[e], carried.edge_detail[e]); });
  base::for_indices(carried.vertex_detail.size(),
                    [&](std::size_t v) { detail.vertex[v] = std::max(detail.vertex[v], carried.vertex_detail[v]); });
  axis::spread_to_sides(axis.complex, detail);
  axis::keep_within_reach(axis, least, detail, context);
  checkpoint(context, "detail", 1);
  return detail;
}

void set_detail(MedialAxis& axis, CellValues&& detail) {
  std::erase_if(axis.measures, [](const Measure& m) { return m.name == kDetail; });
  axis.measures.push_back({std::string(kDetail), std::move(detail), {}});
}

}  // namespace

double auto_detail(const Grid& grid) { return 0.5 * grid.diagonal(); }

static void add_details(MedialAxis& axis, const Surface* surface, Context* context) {
  set_detail(axis, base::in_arena(context, [&] { return details(axis, {}, {}, axis.sites, surface, context); }));
}

void add_detail(MedialAxis& axis, Context* context) { add_details(axis, nullptr, context); }

void add_detail(MedialAxis& axis, const Surface& surface, Context* context) { add_details(axis, &surface, context); }

void axis::add_detail(RestOfCore& core, const Surface* surface, Context* context) {
  const auto& pending = core.pending ? *core.pending : core.axis.sites;
  CellValues detail =
      base::in_arena(context, [&] { return details(core.axis, core.carried, core.known, pending, surface, context); });
  core.carried = {};
  core.known = {};
  core.pending.reset();
  set_detail(core.axis, std::move(detail));
}

}  // namespace quench
