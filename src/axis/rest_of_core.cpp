// SPDX-License-Identifier: Apache-2.0
#include "axis/rest_of_core.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "axis/caps_on_surface.h"
#include "axis/lambda.h"
#include "axis/measures.h"
#include "base/parallel.h"
#include "base/return_memory.h"
#include "delaunay/circumsphere.h"

namespace quench::axis {

using dual::DualComplex;
using dual::bricks::Part;
using dual::bricks::PartComplex;

namespace {

void place_vertices(const DualComplex& dual, const std::array<std::int64_t, 3>& spacing, double unit, MedialAxis& axis,
                    Context* context) {
  const std::uint32_t count = axis.complex.vertex_count;
  tbb::parallel_invoke([&] { axis.points.resize(count); }, [&] { axis.radius.resize(count); });
  const std::size_t chunks = base::chunks_for(count, std::size_t{1} << 13);
  base::for_chunks(chunks, context, "core", 0, 0.5, [&](std::size_t chunk) {
    const auto [first, last] = base::part_of(count, chunk, chunks);
    for (std::size_t v = first; v < last; ++v) {
      const auto ids = dual.sites_of(static_cast<std::uint32_t>(v));
      const delaunay::Circumsphere sphere =
          axis.grid.is_plane()
              ? delaunay::circumcircle({axis.sites[ids[0]], axis.sites[ids[1]], axis.sites[ids[2]]}, spacing)
              : delaunay::circumsphere(ids, axis.sites, spacing);
      Vec3 lattice;
      for (int a = 0; a < 3; ++a)
        lattice[a] = axis.sites[ids[0]][a] + sphere.offset[a] / static_cast<double>(spacing[a]);
      axis.points[v] = axis.grid.world(lattice);
      axis.radius[v] = std::sqrt(sphere.squared_radius) * unit;
    }
  });
}

// Per edge the values of its link.
std::vector<double> of_edges(const std::vector<double>& of_links, const PartComplex& complex) {
  if (of_links.empty()) return {};
  std::vector<double> values(complex.link_of.size());
  base::for_indices(values.size(), [&](std::size_t e) { values[e] = of_links[complex.link_of[e]]; });
  return values;
}

// The same before there is a complex, so that the values of links are gone when it takes memory: edges are in the order
// of their ends.
std::vector<double> edge_values(const dual::Cells& cells, std::vector<double> of_links) {
  if (of_links.empty()) return {};
  const auto is_edge = [&](std::uint32_t p, std::uint32_t n) { return p < n && n < dual::kPruned; };
  std::size_t edges = 0;
  for (std::uint32_t p = 0; p < cells.count(); ++p)
    for (const std::uint32_t n : cells.neighbours_of(p)) edges += is_edge(p, n);
  std::vector<double> values;
  values.reserve(edges);
  std::vector<std::pair<std::uint32_t, double>> own;
  for (std::uint32_t p = 0; p < cells.count(); ++p) {
    own.clear();
    for (std::uint32_t link = cells.neighbour_begin[p]; link < cells.neighbour_begin[p + 1]; ++link)
      if (const std::uint32_t n = cells.neighbours[link]; is_edge(p, n)) own.emplace_back(n, of_links[link]);
    std::ranges::sort(own);
    for (const auto& [n, value] : own) values.push_back(value);
  }
  return values;
}

// Cap heights are lowered by this factor before they are compared, so that those that equal a detail up to rounding are
// not above it: on flat sides staircases attain half the voxel diagonal.
constexpr double kBelowTie = 1 - 2e-9;

void lower_below_ties(CellValues& height) {
  for (auto* values : {&height.vertex, &height.edge, &height.face})
    base::for_indices(values->size(), [&](std::size_t i) {
      if ((*values)[i] != kNoTopCell) (*values)[i] *= kBelowTie;
    });
}

// Those around which cells are gone are part of these.
void leave_out(std::vector<double>& height, const std::vector<double>& carried) {
  base::for_indices(carried.size(), [&](std::size_t i) {
    if (carried[i] >= 0) height[i] = kNoTopCell;
  });
}

}  // namespace

Carried carried_of(const Part& part, const PartComplex& complex) {
  return {of_edges(part.link_lambda, complex), of_edges(part.link_detail, complex), part.vertex_lambda,
          part.vertex_detail};
}

std::vector<double> known_heights(const Part& part, const DualComplex& complex) {
  if (part.faces.empty()) return {};
  std::vector<double> known(complex.face_sites.size(), -1);
  auto value = part.faces.begin();
  for (std::size_t f = 0; f < known.size(); ++f) {
    while (value != part.faces.end() && value->sites < complex.face_sites[f]) ++value;
    if (value != part.faces.end() && value->sites == complex.face_sites[f]) known[f] = value->value;
  }
  return known;
}

MedialAxis axis_of(DualComplex& dual, std::vector<LatticePoint> sites, const Grid& grid, LambdaRule rule,
                   const Carried& carried, Context* context) {
  const auto spacing = integer_spacing(grid);
  const double unit = grid.spacing.minCoeff() / static_cast<double>(std::ranges::min(spacing));
  MedialAxis axis;
  axis.grid = grid;
  axis.sites = std::move(sites);
  axis.complex = std::move(dual.complex);
  place_vertices(dual, spacing, unit, axis, context);
  axis.measures.push_back({std::string(kLambda), {}, {}});
  axis.measures.back().value = lambda(axis.complex, dual, axis.sites, spacing, unit, rule, carried, context);
  axis.face_sites = std::move(dual.face_sites);
  axis.edge_sites = std::move(dual.edge_sites);
  return axis;
}

CellValues heights_of(const MedialAxis& axis, const Carried& carried, std::span<const double> known,
                      const Surface* surface, Context* context) {
  CellValues height = cap_heights_of_top_cells(axis, axis.measure(kLambda).value);
  leave_out(height.edge, carried.edge_detail);
  leave_out(height.vertex, carried.vertex_detail);
  lower_below_ties(height);
  base::for_indices(known.size(), [&](std::size_t f) {
    if (known[f] >= 0) height.face[f] = known[f];
  });
  if (surface) lower_to_surface(axis, *surface, auto_detail(axis.grid), known, height, context);
  return height;
}

RestOfCore rest_of(Part&& part, const dual::Hulls& hulls, const Grid& grid, LambdaRule rule, bool contacts,
                   Context* context) {
  RestOfCore core;
  core.gone = part.pruned;
  core.pending = std::move(part.pending);
  core.carried = {edge_values(part.found.cells, std::move(part.link_lambda)),
                  edge_values(part.found.cells, std::move(part.link_detail)), std::move(part.vertex_lambda),
                  std::move(part.vertex_detail)};
  PartComplex complex = complex_of(part, hulls, context);
  core.known = known_heights(part, complex.dual);
  if (contacts) core.contact = std::move(part.contact);
  std::vector<LatticePoint> sites = std::move(part.sites);
  part = {};
  DualComplex dual = std::move(complex.dual);
  complex = {};
  base::return_free_memory();
  core.axis = axis_of(dual, std::move(sites), grid, rule, core.carried, context);
  core.carried.edge_lambda = core.carried.vertex_lambda = {};
  if (core.contact.empty()) return core;
  core.corner_begin = std::move(dual.vertex_site_offsets);
  core.corners = std::move(dual.vertex_sites);
  return core;
}

}  // namespace quench::axis
