// SPDX-License-Identifier: Apache-2.0
// Yan 2018, sec. 2.6 step 3, for every lambda at once.
#include "quench/prune.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "complex/thinning.h"

namespace quench {

void prune_levels(MedialAxis& axis, Context* context) {
  CellValues level = thin(axis.complex, axis.vertex_lambda, axis.edge_lambda, axis.face_lambda, context, "prune");
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

template <class T>
std::vector<T> select(const std::vector<T>& values, const std::vector<std::uint32_t>& index, std::size_t kept) {
  std::vector<T> result;
  if (values.empty()) return result;
  result.reserve(kept);
  for (std::size_t i = 0; i < values.size(); ++i)
    if (index[i] != kDropped) result.push_back(values[i]);
  return result;
}

}  // namespace

MedialAxis pruned(const MedialAxis& axis, double lambda) {
  const double threshold = lambda * (1 - 1e-12);
  std::vector<std::uint32_t> vertex, edge, face;
  std::uint32_t vertices = 0, edges = 0, faces = 0;
  tbb::parallel_invoke([&] { edges = renumber(axis.edge_level, threshold, edge); },
                       [&] { faces = renumber(axis.face_level, threshold, face); },
                       [&] { vertices = renumber(axis.vertex_level, threshold, vertex); });

  MedialAxis result;
  result.grid = axis.grid;
  result.complex.vertex_count = vertices;
  tbb::parallel_invoke(
      [&] {
        result.points = select(axis.points, vertex, vertices);
        result.radius = select(axis.radius, vertex, vertices);
        result.vertex_lambda = select(axis.vertex_lambda, vertex, vertices);
        result.vertex_level = select(axis.vertex_level, vertex, vertices);
      },
      [&] {
        result.edge_lambda = select(axis.edge_lambda, edge, edges);
        result.edge_level = select(axis.edge_level, edge, edges);
        result.complex.edges = select(axis.complex.edges, edge, edges);
        for (auto& ends : result.complex.edges)
          for (auto& v : ends) v = vertex[v];
      },
      [&] {
        result.face_lambda = select(axis.face_lambda, face, faces);
        result.face_level = select(axis.face_level, face, faces);
        result.face_sites = select(axis.face_sites, face, faces);
      },
      [&] {
        for (std::size_t f = 0; f < axis.complex.face_count(); ++f) {
          if (face[f] == kDropped) continue;
          for (std::uint32_t v : axis.complex.corners(f)) result.complex.face_vertices.push_back(vertex[v]);
          for (std::uint32_t e : axis.complex.sides(f)) result.complex.face_edges.push_back(edge[e]);
          result.complex.face_offsets.push_back(static_cast<std::uint32_t>(result.complex.face_vertices.size()));
        }
      });

  if (!axis.sites.empty()) {
    std::vector<std::uint32_t> site(axis.sites.size(), kDropped);
    for (const auto& pair : result.face_sites)
      for (std::uint32_t s : pair) site[s] = 0;
    for (std::size_t s = 0; s < site.size(); ++s)
      if (site[s] != kDropped) {
        site[s] = static_cast<std::uint32_t>(result.sites.size());
        result.sites.push_back(axis.sites[s]);
      }
    for (auto& pair : result.face_sites)
      for (std::uint32_t& s : pair) s = site[s];
  }
  return result;
}

}  // namespace quench
