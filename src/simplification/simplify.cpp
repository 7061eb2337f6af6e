// SPDX-License-Identifier: Apache-2.0
#include "quench/simplify.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/parallel.h"
#include "simplification/collapser.h"
#include "simplification/fit.h"
#include "simplification/patches.h"

namespace quench::simplification {
namespace {

// From so many vertices on collapses follow the boundary points, fitted again at every half of them.
constexpr std::size_t kFirstFit = 1024;
constexpr int kRoundsBetween = 3;
// Planes at boundary points do not keep balls from sliding out of corners; those of the envelope at its rims do.
constexpr double kOfPatches = 0.3;
// Boundary points per vertex that is fitted, and the least of all.
constexpr std::size_t kPointsBetween = 20, kPointsAtEnd = 40, kLeastPoints = 4000;
// Where numbers of vertices are looked for that meet an error, they are known to one part of so many.
constexpr std::size_t kExactness = 20;

/// Coordinates around 0, of size about 1, so that quadrics lose no digits. A power of two is exact.
struct Unit {
  Vec3 middle = Vec3::Zero();
  double size = 1;

  explicit Unit(const std::vector<Vec3>& points) {
    if (points.empty()) return;
    Vec3 low = points[0], high = low;
    for (const Vec3& p : points) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    middle = (low + high) / 2;
    const double side = (high - low).maxCoeff();
    if (side > 0) size = std::exp2(std::ceil(std::log2(side)));
  }
  void enter(std::vector<Vec3>& points) const {
    for (Vec3& p : points) p = (p - middle) / size;
  }
  void leave(MedialAxis& mesh) const {
    for (Vec3& p : mesh.points) p = p * size + middle;
    for (double& r : mesh.radius) r *= size;
  }
};

/// About `count` of the points that stand for an area, evenly chosen.
BoundaryPoints share_of(const BoundaryPoints& boundary, std::size_t count) {
  const auto all = static_cast<std::size_t>(std::ranges::count_if(boundary.areas, [](double a) { return a > 0; }));
  const std::size_t step = std::max<std::size_t>(1, all / std::max(count, kLeastPoints));
  BoundaryPoints share;
  std::size_t row = 0;
  for (std::size_t i = 0; i < boundary.points.size(); ++i)
    if (boundary.areas[i] > 0 && row++ % step == 0) {
      share.points.push_back(boundary.points[i]);
      share.areas.push_back(boundary.areas[i]);
    }
  return share;
}

/// The whole sequence of a mesh, down to what its topology allows.
CollapseSequence collapsed(const MedialAxis& mesh, const BoundaryPoints& boundary, Context* context) {
  CollapseSequence sequence{mesh, {}};
  MedialAxis left = mesh;
  std::vector<std::uint32_t> rows(mesh.points.size());  // of the mesh, per vertex that is left
  for (std::uint32_t v = 0; v < rows.size(); ++v) rows[v] = v;
  std::vector<Quadric> quadrics(mesh.points.size());
  base::in_arena(context, [&] {
    const Patches patches(mesh);
    base::for_indices(quadrics.size(),
                      [&](std::size_t v) { quadrics[v] = patches.quadric(static_cast<std::uint32_t>(v)); });
  });
  std::size_t next = kFirstFit;
  while (next >= left.points.size() && next > 1) next /= 2;
  for (double done = 0; left.points.size() > 1; next /= 2) {
    Collapser collapser(left, std::move(quadrics), context);
    const double until = done + (1 - done) * 0.7;
    const std::vector<Collapse> steps = collapser.run(next, done, until);
    done = until;
    for (Collapse step : steps) {
      step.kept = rows[step.kept];
      step.removed = rows[step.removed];
      sequence.steps.push_back(step);
    }
    std::vector<std::uint32_t> kept;
    left = collapser.mesh(kept);
    for (std::uint32_t& row : kept) row = rows[row];
    rows = std::move(kept);
    if (left.points.size() > next || next <= 1) break;
    const BoundaryPoints share = share_of(boundary, kPointsBetween * next);
    fit(left, share, kRoundsBetween, context);
    for (std::size_t v = 0; v < rows.size(); ++v)
      sequence.steps.push_back({rows[v], kNone, left.points[v], left.radius[v]});
    quadrics = boundary_quadrics(left, share, context);
    const Patches patches(left);
    for (std::uint32_t v = 0; v < quadrics.size(); ++v) {
      Quadric q = patches.quadric(v);
      q *= kOfPatches;
      quadrics[v] += q;
    }
  }
  checkpoint(context, "simplify", 1);
  return sequence;
}

/// The mesh of so many vertices, fitted.
MedialAxis fitted(const CollapseSequence& sequence, std::size_t vertices, const BoundaryPoints& boundary, int rounds,
                  Context* context) {
  MedialAxis mesh = sequence.at(vertices);
  if (mesh.points.size() < sequence.most())
    fit(mesh, share_of(boundary, kPointsAtEnd * mesh.points.size()), rounds, context);
  return mesh;
}

/// The mesh of the fewest vertices found whose largest error is no larger than `error`.
MedialAxis within(double error, const CollapseSequence& sequence, const BoundaryPoints& boundary, int rounds,
                  double size, Context* context) {
  MedialAxis best;
  double reached = 0;
  const auto meets = [&](std::size_t vertices) {
    MedialAxis mesh = fitted(sequence, vertices, boundary, rounds, context);
    reached = errors_of(mesh, boundary, context).either.largest;
    if (!(reached <= error)) return false;
    best = std::move(mesh);
    return true;
  };
  const std::size_t least = sequence.least(), most = sequence.most();
  std::size_t failed = least, met = least;
  while (!meets(met)) {
    failed = met;
    if (met == most)
      throw Error(
          ErrorCode::usage,
          fmt::format("error {:.6g} is less than that of the medial axis itself, {:.6g}; prune it less, or give "
                      "a larger error",
                      error * size, reached * size),
          "error");
    met = std::min(most, std::max(met + 1, met * 3 / 2));
  }
  while (met - failed > std::max<std::size_t>(1, met / kExactness)) {
    const std::size_t middle = failed + (met - failed) / 2;
    (meets(middle) ? met : failed) = middle;
  }
  return best;
}

}  // namespace
}  // namespace quench::simplification

namespace quench {

Simplified simplify(const MedialAxis& axis, const BoundaryPoints& boundary, const SimplifyOptions& options,
                    Context* context) {
  using namespace simplification;
  if (axis.grid.is_plane())
    throw Error(ErrorCode::usage, "the medial axis is one of the plane; axes of solids can be simplified");
  if (options.error && !(*options.error > 0))
    throw Error(ErrorCode::usage, fmt::format("error {:g} is not a length above 0", *options.error), "error");
  if (!options.error && options.vertices == 0)
    throw Error(ErrorCode::usage, "vertices 0 is not a number of vertices", "vertices");
  MedialAxis plain = medial_mesh_of(axis), mesh = plain;
  const Unit unit(mesh.points);
  unit.enter(mesh.points);
  for (double& r : mesh.radius) r /= unit.size;
  BoundaryPoints points = boundary;
  unit.enter(points.points);
  for (double& a : points.areas) a /= unit.size * unit.size;

  Simplified result;
  result.sequence = collapsed(mesh, points, context);
  result.axis = options.error
                    ? within(*options.error / unit.size, result.sequence, points, options.fits, unit.size, context)
                    : fitted(result.sequence, options.vertices, points, options.fits, context);
  unit.leave(result.axis);
  result.axis.grid = axis.grid;
  result.errors = errors_of(result.axis, boundary, context);
  result.sequence.start = std::move(plain);
  for (Collapse& step : result.sequence.steps) {
    step.point = step.point * unit.size + unit.middle;
    step.radius *= unit.size;
  }
  return result;
}

MedialAxis fitted_level(const CollapseSequence& sequence, std::size_t vertices, const BoundaryPoints& boundary,
                        int fits, Context* context) {
  // Damping and steps do not depend on the unit of length.
  return simplification::fitted(sequence, vertices, boundary, fits, context);
}

std::vector<SimplifiedLevel> errors_of_levels(const CollapseSequence& sequence, const BoundaryPoints& boundary,
                                              int fits, Context* context) {
  std::vector<SimplifiedLevel> levels;
  for (std::size_t vertices = 1000;; vertices /= 2) {
    const bool last = vertices <= sequence.least();
    if (vertices < sequence.most() || last) {
      const MedialAxis mesh = fitted_level(sequence, vertices, boundary, fits, context);
      const CellComplex& c = mesh.complex;
      levels.push_back({c.vertex_count, c.edges.size(), c.face_count(), errors_of(mesh, boundary, context)});
    }
    if (last || vertices == 1) return levels;
  }
}

std::int64_t predicted_simplify_bytes(const CellComplex& complex) {
  std::size_t triangles = 0, diagonals = 0;
  for (std::size_t f = 0; f < complex.face_count(); ++f) {
    triangles += complex.corners(f).size() - 2;
    diagonals += complex.corners(f).size() - 3;
  }
  return static_cast<std::int64_t>(500 * std::size_t{complex.vertex_count} + 130 * (complex.edges.size() + diagonals) +
                                   110 * triangles);
}

}  // namespace quench
