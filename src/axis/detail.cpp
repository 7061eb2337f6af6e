// SPDX-License-Identifier: Apache-2.0
// docs/algorithms/pruning.md
#include <string>
#include <utility>

#include "axis/caps_on_surface.h"
#include "axis/cover.h"
#include "axis/measures.h"
#include "axis/reach.h"
#include "axis/significant_parts.h"
#include "base/parallel.h"

namespace quench {
namespace {

// Cap heights are lowered by this factor before they are compared, so that those that equal a detail up to rounding are
// not above it: on flat sides staircases attain half the voxel diagonal.
constexpr double kBelowTie = 1 - 2e-9;

void lower_below_ties(CellValues& height) {
  for (auto* values : {&height.vertex, &height.edge, &height.face})
    base::for_indices(values->size(), [&](std::size_t i) {
      if ((*values)[i] != axis::kNoTopCell) (*values)[i] *= kBelowTie;
    });
}

CellValues details(const MedialAxis& axis, const Surface* surface, Context* context) {
  const double least = auto_detail(axis.grid);
  checkpoint(context, "detail", 0);
  CellValues detail = axis::cap_heights_of_top_cells(axis, axis.measure(kLambda).value);
  lower_below_ties(detail);
  if (surface) axis::lower_to_surface(axis, *surface, least, detail, context);
  const axis::TopCells cells(axis.complex, detail);
  axis::SignificantParts parts(cells, axis.complex.vertex_count, least);
  parts.set_details();
  checkpoint(context, "detail", 0.3);
  axis::cover_boundary(axis, least, parts, cells, detail, context);
  axis::spread_to_sides(axis.complex, detail);
  axis::keep_within_reach(axis, least, detail, context);
  checkpoint(context, "detail", 1);
  return detail;
}

}  // namespace

double auto_detail(const Grid& grid) { return 0.5 * grid.diagonal(); }

static void add_details(MedialAxis& axis, const Surface* surface, Context* context) {
  CellValues detail = base::in_arena(context, [&] { return details(axis, surface, context); });
  std::erase_if(axis.measures, [](const Measure& m) { return m.name == kDetail; });
  axis.measures.push_back({std::string(kDetail), std::move(detail), {}});
}

void add_detail(MedialAxis& axis, Context* context) { add_details(axis, nullptr, context); }

void add_detail(MedialAxis& axis, const Surface& surface, Context* context) { add_details(axis, &surface, context); }

}  // namespace quench
