// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/csr.h"
#include "base/parallel.h"
#include "quench/simplify.h"
#include "simplification/quadric.h"

namespace quench {
namespace {

// Steps towards the mean of the neighbours and back from it, a little farther: shapes keep their size (Taubin 1995).
constexpr double kTo = 0.5, kFro = -0.53;

/// What lines run along an edge.
enum class Line : std::uint8_t { none, curve, rim, seam };

/// Per vertex the neighbours it is drawn to; none: it stays.
base::Csr<std::uint32_t> smoothing_neighbours(const CellComplex& complex) {
  std::vector<std::uint8_t> faces(complex.edges.size(), 0);
  for (const std::uint32_t e : complex.face_edges) faces[e] = static_cast<std::uint8_t>(std::min(faces[e] + 1, 3));
  const auto line = [&](std::size_t e) {
    return faces[e] == 0 ? Line::curve : faces[e] == 1 ? Line::rim : faces[e] == 2 ? Line::none : Line::seam;
  };
  // A vertex inside a sheet is drawn to all around it, one inside a line to both sides, others stay.
  std::vector<std::array<std::uint32_t, 4>> count(complex.vertex_count, {0, 0, 0, 0});
  for (std::size_t e = 0; e < complex.edges.size(); ++e)
    for (const std::uint32_t v : complex.edges[e]) ++count[v][static_cast<std::size_t>(line(e))];
  const auto drawn_along = [&](std::uint32_t v) -> std::optional<Line> {
    const auto& [none, curve, rim, seam] = count[v];
    const std::uint32_t lines = curve + rim + seam;
    if (lines == 0) return none > 0 ? std::optional(Line::none) : std::nullopt;
    if (lines != 2) return {};
    return curve == 2  ? std::optional(Line::curve)
           : rim == 2  ? std::optional(Line::rim)
           : seam == 2 ? std::optional(Line::seam)
                       : std::nullopt;
  };
  return base::Csr<std::uint32_t>::group(complex.vertex_count, [&](const auto& emit) {
    for (std::size_t e = 0; e < complex.edges.size(); ++e) {
      const auto [a, b] = complex.edges[e];
      if (drawn_along(a) == line(e)) emit(a, b);
      if (drawn_along(b) == line(e)) emit(b, a);
    }
  });
}

}  // namespace

void smooth(MedialAxis& axis, double most, int iterations, Context* context) {
  using simplification::ball_of;
  using simplification::Vec4;
  if (axis.points.size() != axis.complex.vertex_count || axis.radius.size() != axis.points.size())
    throw Error(ErrorCode::usage, "a medial axis without a point and a radius per vertex cannot be smoothed");
  if (!(most >= 0)) throw Error(ErrorCode::usage, fmt::format("most {:g} is not a length of 0 or more", most), "most");
  if (iterations < 0) throw Error(ErrorCode::usage, fmt::format("iterations {} is below 0", iterations), "iterations");
  const auto neighbours = smoothing_neighbours(axis.complex);
  std::vector<Vec4> first(axis.points.size());
  for (std::size_t v = 0; v < first.size(); ++v) first[v] = ball_of(axis.points[v], axis.radius[v]);
  std::vector<Vec4> balls = first, next = first;
  base::in_arena(context, [&] {
    for (int round = 0; round < 2 * iterations; ++round) {
      checkpoint(context, "smooth", static_cast<double>(round) / (2 * iterations));
      base::for_indices(balls.size(), [&](std::size_t v) {
        const auto around = neighbours[v];
        if (around.empty()) return;
        Vec4 mean = Vec4::Zero();
        for (const std::uint32_t w : around) mean += balls[w];
        mean /= static_cast<double>(around.size());
        Vec4 move = balls[v] + (round % 2 == 0 ? kTo : kFro) * (mean - balls[v]) - first[v];
        const double length = move.head<3>().norm();
        if (length > most) move.head<3>() *= most / length;
        move[3] = std::clamp(move[3], -most, most);
        next[v] = first[v] + move;
        next[v][3] = std::max(next[v][3], 0.0);
      });
      std::swap(balls, next);
    }
  });
  checkpoint(context, "smooth", 1);
  for (std::size_t v = 0; v < balls.size(); ++v) {
    axis.points[v] = balls[v].head<3>();
    axis.radius[v] = balls[v][3];
  }
}

}  // namespace quench
