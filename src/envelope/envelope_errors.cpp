// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "base/parallel.h"
#include "envelope/surface_places.h"
#include "quench/envelope.h"

namespace quench {
namespace {

/// An edge of the lattice of centres between a voxel of the envelope and another one.
struct Crossing {
  std::array<std::int32_t, 3> voxel;  ///< of the envelope
  std::int8_t axis, step;
};

std::vector<Crossing> crossings_of(const VoxelShape& voxels) {
  std::vector<Crossing> all;
  const auto& dims = voxels.grid().dims;
  for (std::int64_t z = 0; z < dims[2]; ++z)
    for (std::int64_t y = 0; y < dims[1]; ++y)
      for (const Run& run : voxels.row(y, z)) {
        const auto at = [&](std::int64_t x) {
          return std::array<std::int32_t, 3>{static_cast<std::int32_t>(x), static_cast<std::int32_t>(y),
                                             static_cast<std::int32_t>(z)};
        };
        all.push_back({at(run.begin), 0, -1});
        all.push_back({at(run.end - 1), 0, 1});
        for (std::int8_t axis = 1; axis < 3; ++axis)
          for (std::int8_t step = -1; step <= 1; step += 2)
            for (std::int64_t x = run.begin; x < run.end; ++x)
              if (!voxels.contains(x, axis == 1 ? y + step : y, axis == 2 ? z + step : z))
                all.push_back({at(x), axis, step});
      }
  return all;
}

/// Where the line from a centre inside to its neighbour outside leaves the envelope, by false position (Illinois;
/// Dowell and Jarratt 1971), and the direction of the boundary there.
struct Place {
  Vec3 point, normal;
};
Place leaving(const Envelope& envelope, const Vec3& inside, const Vec3& outside) {
  constexpr double kNear = 1e-6;  // of the line
  double low = 0, high = 1, at = 0;
  Envelope::Ball ball;
  const auto distance = [&](double t) {
    ball = envelope.nearest(inside + t * (outside - inside));
    return ball.distance;
  };
  double below = std::min(distance(0), 0.0), above = std::max(distance(1), 0.0);
  int side = 0;
  for (int step = 0; step < 40 && high - low > kNear; ++step) {
    at = below < above ? low + (high - low) * below / (below - above) : low;
    at = std::clamp(at, low, high);
    const double d = distance(at);
    if (std::abs(d) <= kNear * (outside - inside).norm()) break;
    if (d > 0) {
      high = at;
      above = d;
      if (side > 0) below /= 2;
      side = 1;
    } else {
      low = at;
      below = d;
      if (side < 0) above /= 2;
      side = -1;
    }
  }
  const Vec3 point = inside + at * (outside - inside);
  const Vec3 away = point - ball.centre;
  const double length = away.norm();
  return {point, length > 0 ? Vec3(away / length) : Vec3((outside - inside).normalized())};
}

}  // namespace

OneSidedDistances distances_from_surface(const Envelope& envelope, const VoxelShape& voxels, const Surface& surface,
                                         std::size_t places, Context* context) {
  const Grid& grid = voxels.grid();
  std::vector<Crossing> crossings = crossings_of(voxels);
  const std::size_t every = places > 0 ? std::max<std::size_t>(1, crossings.size() / places) : 1;
  const std::size_t count = (crossings.size() + every - 1) / every;
  // Lines along an axis: so many for an area across them.
  const Vec3 density(1 / (grid.spacing[1] * grid.spacing[2]), 1 / (grid.spacing[0] * grid.spacing[2]),
                     1 / (grid.spacing[0] * grid.spacing[1]));
  std::vector<envelope::Weighted> outside(count), either(count);
  const std::vector<Vec3>& centres = envelope.centres();
  std::vector<double> far_end(centres.size(), 0);
  base::in_arena(context, [&] {
    const std::size_t chunks = base::chunks_for(count, 512);
    base::for_chunks(chunks, context, "errors", 0, 1, [&](std::size_t chunk) {
      const auto [first, last] = base::part_of(count, chunk, chunks);
      for (std::size_t i = first; i < last; ++i) {
        const Crossing& crossing = crossings[i * every];
        Vec3 at(crossing.voxel[0] + 0.5, crossing.voxel[1] + 0.5, crossing.voxel[2] + 0.5), next = at;
        next[crossing.axis] += crossing.step;
        const Place place = leaving(envelope, grid.world(at), grid.world(next));
        const Vec3 normal = grid.direction.transpose() * place.normal;
        const double weight = 1 / density.dot(normal.cwiseAbs());
        const Surface::Foot foot = surface.nearest(place.point);
        outside[i] = {foot.inside ? 0 : foot.distance, weight};
        either[i] = {foot.distance, weight};
      }
    });
    // A ball that is longer than its centre is deep reaches farthest beyond the surface at its nearest point, or near
    // it.
    base::for_indices(centres.size(), [&](std::size_t v) {
      const double r = envelope.radii()[v];
      const Surface::Foot foot = surface.nearest(centres[v]);
      if (!(foot.distance > 0)) return;
      const Vec3 out = (foot.point - centres[v]) * ((foot.inside ? 1 : -1) / foot.distance);
      const Surface::Foot end = surface.nearest(centres[v] + r * out);
      if (!end.inside) far_end[v] = end.distance;
    });
  });
  OneSidedDistances result;
  result.places = count;
  result.outside = envelope::figures_of(outside);
  result.either = envelope::figures_of(either);
  for (const double end : far_end) result.outside.largest = std::max(result.outside.largest, end);
  return result;
}

}  // namespace quench
