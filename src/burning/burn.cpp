// SPDX-License-Identifier: Apache-2.0
#include "quench/burn.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "burning/burn_pass.h"
#include "burning/burn_sequence.h"
#include "burning/curve_fire.h"
#include "burning/flat_faces.h"
#include "quench/axis.h"
#include "quench/error.h"

namespace quench {
namespace {

using namespace burning;

void check_points(const CellComplex& complex, std::span<const Vec3> points) {
  if (points.size() != complex.vertex_count)
    throw Error(ErrorCode::input,
                fmt::format("the medial axis has {} vertices, but {} points", complex.vertex_count, points.size()));
}

// Of the edges that polygons have; of all if there are no polygons.
double mean_edge(const CellComplex& complex, std::span<const Vec3> points) {
  std::vector<char> used(complex.edges.size(), complex.face_count() == 0);
  for (const std::uint32_t e : complex.face_edges) used[e] = 1;
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t e = 0; e < used.size(); ++e)
    if (used[e]) {
      sum += (points[complex.edges[e][1]] - points[complex.edges[e][0]]).norm();
      ++count;
    }
  return count == 0 ? 0 : sum / static_cast<double>(count);
}

void check_input(const CellComplex& complex, std::span<const Vec3> points, std::span<const double> radius,
                 const BurnOptions& options) {
  if (points.size() != complex.vertex_count || radius.size() != complex.vertex_count)
    throw Error(ErrorCode::input, fmt::format("the medial axis has {} vertices, but {} points and {} radii",
                                              complex.vertex_count, points.size(), radius.size()));
  for (std::size_t v = 0; v < radius.size(); ++v) {
    if (!(radius[v] >= 0) || std::isinf(radius[v]))
      throw Error(ErrorCode::input,
                  fmt::format("the radius of vertex {} is {}; a medial axis needs a finite radius that "
                              "is not negative at every vertex",
                              v, radius[v]));
    if (!points[v].allFinite()) throw Error(ErrorCode::input, fmt::format("vertex {} has no finite coordinates", v));
  }
  if (!(options.omega >= 0) || std::isinf(options.omega))
    throw Error(ErrorCode::usage, fmt::format("omega '{}' is not a length above 0", options.omega), "omega");
}

}  // namespace

double default_omega(const CellComplex& complex, std::span<const Vec3> points) {
  check_points(complex, points);
  const bool triangles = complex.face_vertices.size() == 3 * complex.face_count();
  return (triangles ? 0.35 : 0.65) * mean_edge(complex, points);
}

std::int64_t predicted_burn_bytes(const CellComplex& complex, std::span<const Vec3> points,
                                  const BurnOptions& options) {
  check_points(complex, points);
  const double omega = options.omega > 0 ? options.omega : default_omega(complex, points);
  double nodes = complex.vertex_count, edges = static_cast<double>(complex.edges.size());
  const auto add = [&](std::uint32_t v, std::uint32_t w) {
    const double pieces = omega > 0 ? (points[w] - points[v]).norm() / omega : 1;
    nodes += std::max(0.0, std::ceil(pieces) - 1);
  };
  for (const auto& e : complex.edges) add(e[0], e[1]);
  // Diagonals of polygons that are cut; those of ears are shorter than these on average.
  const std::vector<char> cut = faces_to_cut(complex, points);
  double corners = static_cast<double>(complex.face_vertices.size()), kept = 0;
  for (std::size_t f = 0; f < cut.size(); ++f) {
    if (!cut[f]) continue;
    const auto of = complex.corners(f);
    for (std::size_t i = 2; i + 1 < of.size(); ++i) add(of[0], of[i]);
    edges += static_cast<double>(of.size()) - 3;
    corners += 2 * static_cast<double>(of.size()) - 6;
  }
  if (!cut.empty()) kept = 60.0 * complex.vertex_count + 8 * static_cast<double>(complex.face_vertices.size());
  double bytes = 300 * nodes + 40 * corners + kept;  // 190 per node on smooth cores, up to 290 on cores of noise
  if (options.propagation == Propagation::windows) bytes += 500 * edges;
  return static_cast<std::int64_t>(std::min(bytes, 0x1p62));
}

double radius_inside_edge(double r0, double r1, double length, double t, RadiusRule rule) {
  const double linear = (1 - t) * r0 + t * r1;
  if (!is_distance_to_point(r0, r1, length, rule)) return linear;
  return std::sqrt(std::max(0.0, (1 - t) * r0 * r0 + t * r1 * r1 - t * (1 - t) * length * length));
}

double burning::label_tolerance(const CellComplex& complex, std::span<const Vec3> points, double omega) {
  return std::min(2e-3 * omega, 6e-4 * mean_edge(complex, points));
}

Burning burning::finish_burning(const BurnDomain& domain, BurnTimes burned, std::shared_ptr<BurnedSectors> sectors,
                                const BurnOptions& options, Context* context) {
  auto& [times, opened] = burned;
  if (options.parents) order_pass(domain, opened, times, *sectors, context);

  if (options.rounded) round_times(domain, times, *sectors);
  sectors->state_time.assign(times.begin(), times.end());
  Burning result = burning_with(domain, std::move(sectors), options);
  checkpoint(context, "burn", 1);
  return result;
}

// In the plane the axis has no polygons to burn, and its curves are what burns.
static void burn_graph(const CellComplex& complex, std::span<const Vec3> points, std::span<const double> radius,
                       Burning& result) {
  if (complex.face_count() > 0)
    throw Error(ErrorCode::usage, "the medial axis of a shape of the plane has no faces; this one has some");
  std::vector<double> length(complex.edges.size());
  base::for_indices(length.size(), [&](std::size_t e) {
    length[e] = (points[complex.edges[e][1]] - points[complex.edges[e][0]]).norm();
  });
  const std::vector<char> all_edges(complex.edges.size(), 1), all_vertices(complex.vertex_count, 1);
  result.burn_time = burn_curves(complex.edges, all_edges, all_vertices, radius, length, {}, true).time;
  result.max_burn_time = 0;
  result.unburned = 0;
  result.node_count = complex.vertex_count;
  for (std::size_t v = 0; v < radius.size(); ++v) {
    const double time = result.burn_time[v];
    result.erosion_thickness[v] = time - radius[v];
    if (std::isinf(time))
      ++result.unburned;
    else
      result.max_burn_time = std::max(result.max_burn_time, time);
  }
}

static BurnTimes propagated(const BurnDomain& domain, double tolerance, const BurnOptions& options,
                            const BlockSchedule& schedule, Context* context) {
  if (options.propagation == Propagation::windows) return propagate_by_windows(domain, context);
  Labels labels(domain, schedule, tolerance);
  propagate_by_segments(domain, labels, context);
  return labels.release();
}

static Burning burned(const CellComplex& complex, std::span<const Vec3> points, std::span<const double> radius,
                      BurnOptions options, const BlockSchedule& schedule, Context* context) {
  checkpoint(context, "burn", 0);
  if (options.omega == 0) options.omega = default_omega(complex, points);
  if (options.omega == 0) options.omega = 1;  // all edges have length 0
  auto sectors = std::make_shared<BurnedSectors>();
  sectors->network = make_network(complex, points, options.omega);
  const double tolerance = label_tolerance(complex, points, options.omega);
  BurnTimes times;
  const std::vector<char> cut = faces_to_cut(complex, points);
  if (!cut.empty()) {
    const CellComplex flat = with_flat_faces(complex, points, cut);
    const BurnNetwork network = make_network(flat, points, options.omega);
    times = propagated({flat, points, radius, network, options.radius}, tolerance, options, schedule, context);
    times.times.resize(sectors->network.state_count());  // those of the diagonals come last
    times.opened.resize(sectors->network.state_count());
  }
  const BurnDomain domain{complex, points, radius, sectors->network, options.radius};
  if (cut.empty()) times = propagated(domain, tolerance, options, schedule, context);
  return finish_burning(domain, std::move(times), std::move(sectors), options, context);
}

Burning burning::burn_scheduled(const CellComplex& complex, std::span<const Vec3> points,
                                std::span<const double> radius, const BurnOptions& options,
                                const BlockSchedule& schedule, Context* context) {
  check_input(complex, points, radius, options);
  return base::in_arena(context, [&] {
    Burning result = burned(complex, points, radius, options, schedule, context);
    if (options.plane) burn_graph(complex, points, radius, result);
    return result;
  });
}

Burning burn(const CellComplex& complex, std::span<const Vec3> points, std::span<const double> radius,
             const BurnOptions& options, Context* context) {
  return burn_scheduled(complex, points, radius, options, {}, context);
}

Burning burn(const MedialAxis& axis, const BurnOptions& options, Context* context) {
  BurnOptions own = options;
  own.plane = axis.grid.is_plane();
  return burn(axis.complex, axis.points, axis.radius, own, context);
}

}  // namespace quench
