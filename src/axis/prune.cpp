// SPDX-License-Identifier: Apache-2.0
// Yan 2018, sec. 2.6 step 3, for every lambda at once.
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/parallel.h"
#include "complex/thinning.h"
#include "quench/axis.h"
#include "quench/error.h"

namespace quench {

namespace {

// Whether there is a value for each cell.
bool complete(const CellComplex& complex, const std::vector<double>& vertex, const std::vector<double>& edge,
              const std::vector<double>& face) {
  return vertex.size() == complex.vertex_count && edge.size() == complex.edges.size() &&
         face.size() == complex.face_count();
}

void require_lambdas(const MedialAxis& axis) {
  if (!complete(axis.complex, axis.vertex_lambda, axis.edge_lambda, axis.face_lambda))
    throw Error(ErrorCode::usage,
                "the medial axis has no lambda for each of its cells; voxel_core() makes one that has");
  for (const auto* lambdas : {&axis.vertex_lambda, &axis.edge_lambda, &axis.face_lambda})
    if (!std::ranges::all_of(*lambdas, [](double lambda) { return lambda >= 0; }))
      throw Error(ErrorCode::usage, "a cell of the medial axis has a lambda that is negative or no number");
}

void require_levels(const MedialAxis& axis) {
  if (!complete(axis.complex, axis.vertex_level, axis.edge_level, axis.face_level))
    throw Error(ErrorCode::usage,
                "the medial axis has no level for each of its cells; give it levels by prune_levels() first");
}

}  // namespace

void prune_levels(MedialAxis& axis, Context* context) {
  require_lambdas(axis);
  complex::CellValues level = base::in_arena(context, [&] {
    return complex::thin(axis.complex, axis.vertex_lambda, axis.edge_lambda, axis.face_lambda, context, "prune");
  });
  axis.vertex_level = std::move(level.vertex);
  axis.edge_level = std::move(level.edge);
  axis.face_level = std::move(level.face);
}

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

// `axis` and `result` may be the same.
void prune(const MedialAxis& axis, double lambda, MedialAxis& result) {
  require_levels(axis);
  if (std::isnan(lambda)) throw Error(ErrorCode::usage, "a pruning needs a lambda; it is no number");
  const double threshold = lambda * (1 - 1e-12);
  std::vector<std::uint32_t> vertex, edge, face;
  std::uint32_t vertices = 0, edges = 0, faces = 0;
  tbb::parallel_invoke([&] { edges = renumber(axis.edge_level, threshold, edge); },
                       [&] { faces = renumber(axis.face_level, threshold, face); },
                       [&] { vertices = renumber(axis.vertex_level, threshold, vertex); });

  result.grid = axis.grid;
  result.complex.vertex_count = vertices;
  tbb::parallel_invoke(
      [&] {
        select(axis.points, vertex, vertices, result.points);
        select(axis.radius, vertex, vertices, result.radius);
        select(axis.vertex_lambda, vertex, vertices, result.vertex_lambda);
        select(axis.vertex_level, vertex, vertices, result.vertex_level);
      },
      [&] {
        select(axis.edge_lambda, edge, edges, result.edge_lambda);
        select(axis.edge_level, edge, edges, result.edge_level);
        select(axis.complex.edges, edge, edges, result.complex.edges);
        for (auto& ends : result.complex.edges)
          for (auto& v : ends) v = vertex[v];
      },
      [&] {
        select(axis.face_lambda, face, faces, result.face_lambda);
        select(axis.face_level, face, faces, result.face_level);
        select(axis.face_sites, face, faces, result.face_sites);
      },
      [&] { select_faces(axis.complex, vertex, edge, face, faces, result.complex); });

  if (axis.sites.empty()) return;
  std::vector<std::uint32_t> site(axis.sites.size(), kDropped);
  for (const auto& pair : result.face_sites)
    for (const std::uint32_t s : pair) site[s] = 0;
  std::uint32_t sites = 0;
  for (std::uint32_t& s : site)
    if (s != kDropped) s = sites++;
  select(axis.sites, site, sites, result.sites);
  for (auto& pair : result.face_sites)
    for (std::uint32_t& s : pair) s = site[s];
}

}  // namespace

MedialAxis pruned(const MedialAxis& axis, double lambda) {
  MedialAxis result;
  prune(axis, lambda, result);
  return result;
}

MedialAxis pruned(MedialAxis&& axis, double lambda) {
  prune(axis, lambda, axis);
  return std::move(axis);
}

}  // namespace quench
