// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "brute_force_core.h"
#include "quench/record.h"

/// Prunings of a brute-force core by the plainest possible thinning, and as what a result file holds.
namespace quench::brute_force {

/// Which cells of a core a pruning keeps.
struct Kept {
  std::vector<char> cells, edges, faces;
};

inline Kept keep_all(const Core& core) {
  return {std::vector<char>(core.cells.size(), 1), std::vector<char>(core.edges.size(), 1),
          std::vector<char>(core.faces.size(), 1)};
}

/// Removes simple pairs of which both cells are below lambda, in any order, until none is left.
inline Kept pruned(const Core& core, double lambda, bool ball_rule = false) {
  Kept kept = keep_all(core);
  const auto value = [&](const auto& cell) { return ball_rule ? cell.lambda_ball : cell.lambda; };
  const double below = lambda * (1 - 1e-12);
  for (bool changed = true; changed;) {
    changed = false;
    std::vector<int> edge_faces(core.edges.size(), 0), cell_edges(core.cells.size(), 0);
    for (std::size_t f = 0; f < core.faces.size(); ++f)
      if (kept.faces[f])
        for (std::uint32_t e : core.faces[f].edges) ++edge_faces[e];
    for (std::size_t f = 0; f < core.faces.size(); ++f) {
      if (!kept.faces[f] || core.faces[f].lambda >= below) continue;
      for (std::uint32_t e : core.faces[f].edges)
        if (edge_faces[e] == 1 && value(core.edges[e]) < below) {
          kept.faces[f] = kept.edges[e] = 0;
          for (std::uint32_t other : core.faces[f].edges) --edge_faces[other];
          changed = true;
          break;
        }
    }
    for (std::size_t e = 0; e < core.edges.size(); ++e)
      if (kept.edges[e])
        for (std::uint32_t c : core.edges[e].cells) ++cell_edges[c];
    for (std::size_t e = 0; e < core.edges.size(); ++e) {
      if (!kept.edges[e] || edge_faces[e] != 0 || value(core.edges[e]) >= below) continue;
      for (std::uint32_t c : core.edges[e].cells)
        if (cell_edges[c] == 1 && value(core.cells[c]) < below) {
          kept.edges[e] = kept.cells[c] = 0;
          for (std::uint32_t other : core.edges[e].cells) --cell_edges[other];
          changed = true;
          break;
        }
    }
  }
  return kept;
}

/// Polygons, edges without polygon as lines, cells without edge as vertex cells, with the arrays of docs/user/files.md.
inline Record record(const Core& core, const Kept& kept, double lambda = 0, bool ball_rule = false) {
  Record data;
  const auto value = [&](const auto& cell) { return ball_rule ? cell.lambda_ball : cell.lambda; };
  std::vector<std::uint32_t> row(core.cells.size());
  std::vector<double> radius, point_lambda;
  for (std::size_t c = 0; c < core.cells.size(); ++c) {
    if (!kept.cells[c]) continue;
    row[c] = static_cast<std::uint32_t>(data.points.size());
    data.points.push_back(core.cells[c].position);
    radius.push_back(core.cells[c].radius);
    point_lambda.push_back(value(core.cells[c]));
  }
  std::vector<char> edge_used(core.edges.size(), 0), cell_used(core.cells.size(), 0);
  for (std::size_t f = 0; f < core.faces.size(); ++f)
    if (kept.faces[f])
      for (std::uint32_t e : core.faces[f].edges) edge_used[e] = 1;
  for (std::size_t e = 0; e < core.edges.size(); ++e)
    if (kept.edges[e])
      for (std::uint32_t c : core.edges[e].cells) cell_used[c] = 1;

  std::vector<double> cell_lambda;
  std::vector<std::int32_t> site_a, site_b, kind;
  const auto row_of_cell = [&](int dimension, double cell_value, std::int32_t a, std::int32_t b) {
    kind.push_back(2 - dimension);
    cell_lambda.push_back(cell_value);
    site_a.push_back(a);
    site_b.push_back(b);
  };
  for (std::size_t c = 0; c < core.cells.size(); ++c)
    if (kept.cells[c] && !cell_used[c]) {
      data.verts.push_back(row[c]);
      row_of_cell(0, value(core.cells[c]), -1, -1);
    }
  for (std::size_t e = 0; e < core.edges.size(); ++e)
    if (kept.edges[e] && !edge_used[e]) {
      data.lines.push_back({row[core.edges[e].cells[0]], row[core.edges[e].cells[1]]});
      row_of_cell(1, value(core.edges[e]), -1, -1);
    }
  for (std::size_t f = 0; f < core.faces.size(); ++f)
    if (kept.faces[f]) {
      for (std::uint32_t c : core.faces[f].cells) data.poly_corners.push_back(row[c]);
      data.poly_offsets.push_back(static_cast<std::uint32_t>(data.poly_corners.size()));
      row_of_cell(2, core.faces[f].lambda, static_cast<std::int32_t>(core.faces[f].sites[0]),
                  static_cast<std::int32_t>(core.faces[f].sites[1]));
    }
  std::vector<std::int32_t> sites;
  for (const LatticePoint& p : core.sites) sites.insert(sites.end(), p.begin(), p.end());
  data.point_data = {{"radius", 1, radius}, {"lambda", 1, point_lambda}};
  data.cell_data = {{"lambda", 1, cell_lambda}, {"site_a", 1, site_a}, {"site_b", 1, site_b}, {"kind", 1, kind}};
  data.field_data = {{"sites", 3, sites},
                     {"lambda", 1, std::vector<double>{lambda}},
                     {"lambda_rule", 1, std::vector<std::string>{ball_rule ? "ball" : "coface"}},
                     {"stage", 1, std::vector<std::string>{"core"}}};
  return data;
}

inline Record record(const Core& core) { return record(core, keep_all(core)); }

}  // namespace quench::brute_force
