// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <utility>

#include "quench/simplify.h"

namespace quench {
namespace {

/// What is left of the vertices of a start after some steps.
struct Merged {
  std::vector<std::uint32_t> into;  // per vertex that it became one with, or itself
  std::vector<Vec3> points;
  std::vector<double> radius;

  explicit Merged(const MedialAxis& start)
      : into(start.complex.vertex_count), points(start.points), radius(start.radius) {
    for (std::uint32_t v = 0; v < into.size(); ++v) into[v] = v;
  }
  void apply(const Collapse& step) {
    points[step.kept] = step.point;
    radius[step.kept] = step.radius;
    if (step.removed != kNone) into[step.removed] = step.kept;
  }
  std::uint32_t find(std::uint32_t v) {
    while (into[v] != v) v = into[v] = into[into[v]];
    return v;
  }
};

/// The first step that is not part of the mesh of so many vertices.
std::size_t steps_until(const CollapseSequence& sequence, std::size_t vertices) {
  std::size_t left = sequence.most(), step = 0;
  for (; step < sequence.steps.size(); ++step)
    if (sequence.steps[step].removed != kNone) {
      if (left <= vertices) break;
      --left;
    }
  return step;
}

/// The mesh after the first `steps`; `row_of[v]`: of vertex v of the start, where it is left.
MedialAxis mesh_after(const CollapseSequence& sequence, std::size_t steps, std::vector<std::uint32_t>& row_of) {
  const CellComplex& from = sequence.start.complex;
  Merged merged(sequence.start);
  for (std::size_t s = 0; s < steps; ++s) merged.apply(sequence.steps[s]);
  MedialAxis mesh;
  mesh.grid = sequence.start.grid;
  row_of.assign(from.vertex_count, kNone);
  for (std::uint32_t v = 0; v < from.vertex_count; ++v) {
    if (merged.into[v] != v) continue;
    row_of[v] = static_cast<std::uint32_t>(mesh.points.size());
    mesh.points.push_back(merged.points[v]);
    mesh.radius.push_back(merged.radius[v]);
  }
  const auto row = [&](std::uint32_t v) { return row_of[merged.find(v)]; };
  std::vector<std::array<std::uint32_t, 2>> edges;
  for (const auto& [a, b] : from.edges)
    if (const auto i = row(a), j = row(b); i != j) edges.push_back({std::min(i, j), std::max(i, j)});
  std::vector<std::uint32_t> offsets{0}, corners;
  for (std::size_t f = 0; f < from.face_count(); ++f) {
    const auto face = from.corners(f);
    const std::uint32_t a = row(face[0]), b = row(face[1]), c = row(face[2]);
    if (a == b || b == c || c == a) continue;
    corners.insert(corners.end(), {a, b, c});
    offsets.push_back(static_cast<std::uint32_t>(corners.size()));
  }
  mesh.complex =
      make_complex(static_cast<std::uint32_t>(mesh.points.size()), edges, std::move(offsets), std::move(corners));
  return mesh;
}

}  // namespace

std::size_t CollapseSequence::least() const {
  return most() - static_cast<std::size_t>(
                      std::ranges::count_if(steps, [](const Collapse& step) { return step.removed != kNone; }));
}

MedialAxis CollapseSequence::at(std::size_t vertices) const {
  std::vector<std::uint32_t> row_of;
  return mesh_after(*this, steps_until(*this, vertices), row_of);
}

CollapseSequence CollapseSequence::from(std::size_t vertices) const {
  std::vector<std::uint32_t> row_of;
  const std::size_t first = steps_until(*this, vertices);
  CollapseSequence rest{mesh_after(*this, first, row_of), {}};
  rest.steps.reserve(steps.size() - first);
  for (std::size_t s = first; s < steps.size(); ++s) {
    Collapse step = steps[s];
    step.kept = row_of[step.kept];
    if (step.removed != kNone) step.removed = row_of[step.removed];
    rest.steps.push_back(step);
  }
  return rest;
}

}  // namespace quench
