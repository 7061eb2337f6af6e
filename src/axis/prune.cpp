// SPDX-License-Identifier: Apache-2.0
// Yan 2018, sec. 2.6 step 3, for every threshold at once.
#include <fmt/format.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>

#include "axis/rest_of_core.h"
#include "base/csr.h"
#include "base/parallel.h"
#include "complex/thinning.h"
#include "quench/axis.h"
#include "quench/error.h"

namespace quench {

namespace {

void require_values(const CellComplex& complex, const Measure& measure) {
  if (!measure.value.complete(complex))
    throw Error(ErrorCode::usage,
                fmt::format("the medial axis has no {} for each of its cells; voxel_core() makes one that has lambda",
                            measure.name));
  for (const auto* values : {&measure.value.vertex, &measure.value.edge, &measure.value.face})
    if (!std::ranges::all_of(*values, [](double value) { return value >= 0; }))
      throw Error(ErrorCode::usage,
                  fmt::format("a cell of the medial axis has a {} that is negative or not a number", measure.name));
}

}  // namespace

void prune_levels(MedialAxis& axis, std::string_view name, Context* context) {
  Measure& measure = axis.measure(name);
  require_values(axis.complex, measure);
  measure.level = base::in_arena(context, [&] {
    return complex::thin(axis.complex, measure.value.vertex, measure.value.edge, measure.value.face, context, "prune");
  });
}

void prune_levels(MedialAxis& axis, Context* context) { prune_levels(axis, kLambda, context); }

namespace {

constexpr std::uint32_t kDropped = std::numeric_limits<std::uint32_t>::max();

// New index per old cell, kDropped below the threshold; returns the number kept.
std::uint32_t renumber(const std::vector<double>& level, double threshold, std::vector<std::uint32_t>& index) {
  std::uint32_t kept = 0;
  index.resize(level.size());
  for (std::size_t i = 0; i < level.size(); ++i) index[i] = level[i] >= threshold ? kept++ : kDropped;
  return kept;
}

// The values that are kept, in order. `from` and `to` may be the same.
template <class T>
void select(const std::vector<T>& from, const std::vector<std::uint32_t>& index, std::size_t kept, std::vector<T>& to) {
  if (from.empty()) return;
  if (&to != &from) to.resize(kept);
  for (std::size_t i = 0; i < index.size(); ++i)
    if (index[i] != kDropped) to[index[i]] = from[i];
  to.resize(kept);
  to.shrink_to_fit();
}

// As above, for corners and sides of faces at once.
void select_faces(const CellComplex& from, const std::vector<std::uint32_t>& vertex,
                  const std::vector<std::uint32_t>& edge, const std::vector<std::uint32_t>& face, std::size_t kept,
                  CellComplex& to) {
  std::size_t corners = 0;
  for (std::size_t f = 0; f < face.size(); ++f)
    if (face[f] != kDropped) corners += from.face_offsets[f + 1] - from.face_offsets[f];
  if (&to != &from) {
    to.face_offsets.resize(kept + 1);
    to.face_vertices.resize(corners);
    to.face_edges.resize(corners);
  }
  std::uint32_t begin = 0, next = 0;
  for (std::size_t f = 0; f < face.size(); ++f) {
    const std::uint32_t end = from.face_offsets[f + 1];  // before the offset of a kept face takes its place
    if (face[f] != kDropped) {
      for (std::uint32_t i = begin; i < end; ++i, ++next) {
        to.face_vertices[next] = vertex[from.face_vertices[i]];
        to.face_edges[next] = edge[from.face_edges[i]];
      }
      to.face_offsets[face[f] + 1] = next;
    }
    begin = end;
  }
  to.face_offsets.resize(kept + 1);
  to.face_offsets.shrink_to_fit();
  to.face_vertices.resize(corners);
  to.face_vertices.shrink_to_fit();
  to.face_edges.resize(corners);
  to.face_edges.shrink_to_fit();
}

// The values of a measure, and its levels where the pruning is by it.
void select(const Measure& from, std::vector<double> CellValues::*cells, bool levels,
            const std::vector<std::uint32_t>& index, std::size_t kept, Measure& to) {
  select(from.value.*cells, index, kept, to.value.*cells);
  if (levels)
    select(from.level.*cells, index, kept, to.level.*cells);
  else
    to.level.*cells = {};
}

// The levels of all cells, and what is below the threshold: less than so much.
std::pair<const CellValues&, double> levels_for(const MedialAxis& axis, double at, std::string_view name) {
  static const CellValues none;
  const Measure* by = axis.find_measure(name);
  const CellValues& level = by ? by->level : none;
  if (!level.complete(axis.complex))
    throw Error(ErrorCode::usage, fmt::format("the medial axis has no level of {} for each of its cells; give it "
                                              "levels by prune_levels() first",
                                              name));
  if (std::isnan(at)) throw Error(ErrorCode::usage, fmt::format("a pruning needs a {}; it is not a number", name));
  return {level, at * (1 - 1e-12)};
}

// `axis` and `result` may be the same.
void prune(const MedialAxis& axis, double at, std::string_view name, MedialAxis& result) {
  const auto [level, threshold] = levels_for(axis, at, name);
  const Measure* by = axis.find_measure(name);
  std::vector<std::uint32_t> vertex, edge, face;
  std::uint32_t vertices = 0, edges = 0, faces = 0;
  tbb::parallel_invoke([&, &l = level, t = threshold] { edges = renumber(l.edge, t, edge); },
                       [&, &l = level, t = threshold] { faces = renumber(l.face, t, face); },
                       [&, &l = level, t = threshold] { vertices = renumber(l.vertex, t, vertex); });

  result.grid = axis.grid;
  result.surface = axis.surface;
  result.complex.vertex_count = vertices;
  result.measures.resize(axis.measures.size());
  for (std::size_t m = 0; m < axis.measures.size(); ++m) result.measures[m].name = axis.measures[m].name;
  const auto select_measures = [&](std::vector<double> CellValues::*cells, const std::vector<std::uint32_t>& index,
                                   std::size_t kept) {
    for (std::size_t m = 0; m < axis.measures.size(); ++m)
      select(axis.measures[m], cells, &axis.measures[m] == by, index, kept, result.measures[m]);
  };
  tbb::parallel_invoke(
      [&] {
        select(axis.points, vertex, vertices, result.points);
        select(axis.radius, vertex, vertices, result.radius);
        select(axis.voxel_points, vertex, vertices, result.voxel_points);
        select(axis.voxel_radius, vertex, vertices, result.voxel_radius);
        select_measures(&CellValues::vertex, vertex, vertices);
      },
      [&] {
        select_measures(&CellValues::edge, edge, edges);
        select(axis.edge_sites, edge, edges, result.edge_sites);
        select(axis.complex.edges, edge, edges, result.complex.edges);
        for (auto& ends : result.complex.edges)
          for (auto& v : ends) v = vertex[v];
      },
      [&] {
        select_measures(&CellValues::face, face, faces);
        select(axis.face_sites, face, faces, result.face_sites);
      },
      [&] { select_faces(axis.complex, vertex, edge, face, faces, result.complex); });

  if (axis.sites.empty()) return;
  std::vector<std::uint32_t> site(axis.sites.size(), kDropped);
  const std::array pairs_of{&result.face_sites, &result.edge_sites};
  for (const auto* pairs : pairs_of)
    for (const auto& pair : *pairs)
      for (const std::uint32_t s : pair) site[s] = 0;
  std::uint32_t sites = 0;
  for (std::uint32_t& s : site)
    if (s != kDropped) s = sites++;
  select(axis.sites, site, sites, result.sites);
  for (auto* pairs : pairs_of)
    for (auto& pair : *pairs)
      for (std::uint32_t& s : pair) s = site[s];
}

}  // namespace

static ContactSites contacts_of(const MedialAxis& axis, const axis::RestOfCore* rest, double threshold,
                                std::string_view measure) {
  const auto [level, least] = levels_for(axis, threshold, measure);
  std::vector<std::uint32_t> row;
  const std::uint32_t vertices = renumber(level.vertex, least, row);
  auto around = base::Csr<std::uint32_t>::group(vertices, [&](const auto& emit) {
    for (std::size_t f = 0; f < axis.face_sites.size(); ++f)
      for (const std::uint32_t v : axis.complex.corners(f))
        if (row[v] != kDropped)
          for (const std::uint32_t site : axis.face_sites[f]) emit(row[v], site);
    for (std::size_t e = 0; e < axis.edge_sites.size(); ++e)
      for (const std::uint32_t v : axis.complex.edges[e])
        if (row[v] != kDropped)
          for (const std::uint32_t site : axis.edge_sites[e]) emit(row[v], site);
    if (!rest || rest->contact.empty()) return;
    for (std::size_t v = 0; v < row.size(); ++v)
      if (row[v] != kDropped)
        for (std::uint32_t i = rest->corner_begin[v]; i < rest->corner_begin[v + 1]; ++i)
          if (rest->contact[i]) emit(row[v], rest->corners[i]);
  });
  ContactSites contacts;
  contacts.offsets.reserve(vertices + 1);
  std::vector<std::uint32_t> site(axis.sites.size(), kDropped);
  for (std::uint32_t v = 0; v < vertices; ++v) {
    const std::span<std::uint32_t> sites = around[v];
    std::ranges::sort(sites);
    for (const auto end = std::unique(sites.begin(), sites.end());
         const std::uint32_t s : std::span(sites.begin(), end)) {
      contacts.rows.push_back(s);
      site[s] = 0;
    }
    contacts.offsets.push_back(static_cast<std::uint32_t>(contacts.rows.size()));
  }
  for (std::uint32_t s = 0; s < site.size(); ++s)
    if (site[s] != kDropped) {
      site[s] = static_cast<std::uint32_t>(contacts.sites.size());
      contacts.sites.push_back(axis.sites[s]);
    }
  for (std::uint32_t& s : contacts.rows) s = site[s];
  return contacts;
}

ContactSites contact_sites(const MedialAxis& axis, double threshold, std::string_view measure) {
  return contacts_of(axis, nullptr, threshold, measure);
}

ContactSites axis::contact_sites(const RestOfCore& core, double threshold, std::string_view measure) {
  return contacts_of(core.axis, &core, threshold, measure);
}

MedialAxis pruned(const MedialAxis& axis, double threshold, std::string_view measure) {
  MedialAxis result;
  prune(axis, threshold, measure, result);
  return result;
}

MedialAxis pruned(MedialAxis&& axis, double threshold, std::string_view measure) {
  prune(axis, threshold, measure, axis);
  return std::move(axis);
}

}  // namespace quench
