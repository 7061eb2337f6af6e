// SPDX-License-Identifier: Apache-2.0
// Medial meshes of a page.
#include <algorithm>
#include <array>

#include "quench/pipeline.h"
#include "quench/simplify.h"

namespace quench::pipeline {
namespace {

constexpr std::size_t kFinest = 4096;  // vertices of the finest mesh of a page
constexpr std::size_t kFirst = 200;    // viewer/src/state.ts: what is shown first is fitted
constexpr std::array<std::size_t, 6> kMeasured{25, 50, 100, 200, 400, 1000};

/// The points that stand for an area: the others are many, and for exact extremes.
BoundaryPoints with_area(const BoundaryPoints& boundary) {
  BoundaryPoints points;
  for (std::size_t i = 0; i < boundary.points.size(); ++i)
    if (boundary.areas[i] > 0) {
      points.points.push_back(boundary.points[i]);
      points.areas.push_back(boundary.areas[i]);
    }
  return points;
}

/// The mesh of as many vertices as `fitted` has becomes it: its vertices move once more.
void go_through(CollapseSequence& sequence, const MedialAxis& fitted) {
  const std::size_t wanted = fitted.points.size();
  std::vector<char> left(sequence.most(), 1);
  std::size_t count = left.size();
  auto step = sequence.steps.begin();
  for (; step != sequence.steps.end(); ++step) {
    if (step->removed == kNone) continue;
    if (count == wanted) break;
    left[step->removed] = 0;
    --count;
  }
  if (count != wanted) return;
  std::vector<Collapse> moves;
  for (std::uint32_t v = 0; v < left.size(); ++v)
    if (left[v]) moves.push_back({v, kNone, fitted.points[moves.size()], fitted.radius[moves.size()]});
  sequence.steps.insert(step, moves.begin(), moves.end());
}

}  // namespace

void PageBuilder::add_meshes(const MedialAxis& axis, const BoundaryPoints& boundary, bool measured, Context* context) {
  if (page.plane || axis.points.empty()) return;
  const BoundaryPoints points = with_area(boundary);
  const Simplified simplified = simplify(axis, points, {.vertices = kFirst}, context);
  CollapseSequence sequence = simplified.sequence.from(kFinest);
  go_through(sequence, simplified.axis);
  std::vector<PageMeshError> errors;
  for (const std::size_t vertices : kMeasured) {
    if (!measured || vertices < sequence.least() || vertices > sequence.most()) continue;
    const OneSidedDistances off = errors_of(sequence.at(vertices), points, context);
    errors.push_back({vertices, off.either.mean, off.either.p99, off.either.largest});
  }
  quench::add_meshes(page, sequence, errors);
}

}  // namespace quench::pipeline
