// SPDX-License-Identifier: Apache-2.0
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "base/parallel.h"
#include "quench/envelope.h"
#include "quench/error.h"
#include "shape/isosurface.h"

namespace quench {
namespace {

/// The voxels around which not all 26 neighbours are of their kind: those of cells that the surface passes.
VoxelShape band_of(const VoxelShape& voxels) {
  const Grid& grid = voxels.grid();
  VoxelShape band(grid);
  std::vector<std::pair<std::int64_t, int>> events;  // where scanlines around begin or end
  std::vector<Run> runs;
  for (std::int64_t z = 0; z < grid.dims[2]; ++z)
    for (std::int64_t y = 0; y < grid.dims[1]; ++y) {
      events.clear();
      for (std::int64_t dz = -1; dz <= 1; ++dz)
        for (std::int64_t dy = -1; dy <= 1; ++dy)
          for (const Run& run : voxels.row(y + dy, z + dz)) {
            events.emplace_back(run.begin, 1);
            events.emplace_back(run.end, -1);
          }
      std::sort(events.begin(), events.end());
      runs.clear();
      // Columns from which to which some scanlines are in and others not, one longer on both sides; where all begin or
      // end at once, the columns on both sides.
      int in = 0;
      const auto add = [&](std::int64_t begin, std::int64_t end) {
        begin = std::max<std::int64_t>(begin, 0);
        end = std::min(end, grid.dims[0]);
        if (begin < end) runs.push_back({static_cast<std::int32_t>(begin), static_cast<std::int32_t>(end)});
      };
      for (std::size_t i = 0; i < events.size();) {
        const std::int64_t at = events[i].first;
        add(at - 1, at + 1);
        for (; i < events.size() && events[i].first == at; ++i) in += events[i].second;
        if (in > 0 && in < 9) add(at - 1, events[i].first + 1);
      }
      band.append_row(runs);
    }
  return band;
}

/// Depths of the centres of the band below the boundary, or what counts for them.
class Depths final : public shape::SignedSamples {
 public:
  Depths(const Envelope& envelope, const VoxelShape& voxels, Context* context) : band_(band_of(voxels)) {
    const Grid& grid = voxels.grid();
    const auto rows = static_cast<std::size_t>(grid.dims[1] * grid.dims[2]);
    first_.resize(band_.runs().size() + 1, 0);
    for (std::size_t r = 0; r < band_.runs().size(); ++r)
      first_[r + 1] = first_[r] + static_cast<std::size_t>(band_.runs()[r].end - band_.runs()[r].begin);
    depth_.resize(first_.back());
    constexpr std::size_t kRows = 64;
    const std::size_t chunks = (rows + kRows - 1) / kRows;
    base::for_chunks(chunks, context, "distances", 0, 1, [&](std::size_t chunk) {
      for (std::size_t row = chunk * kRows; row < std::min(rows, (chunk + 1) * kRows); ++row) {
        const std::int64_t y = static_cast<std::int64_t>(row) % grid.dims[1],
                           z = static_cast<std::int64_t>(row) / grid.dims[1];
        const auto runs = band_.row(y, z);
        for (const Run& run : runs) {
          float* depth = depth_.data() + first_[static_cast<std::size_t>(&run - band_.runs().data())];
          for (std::int32_t x = run.begin; x < run.end; ++x) {
            const double d = -envelope.distance(
                grid.world(Vec3(x + 0.5, static_cast<double>(y) + 0.5, static_cast<double>(z) + 0.5)));
            *depth++ = static_cast<float>(voxels.contains(x, y, z) ? std::max(d, 0.0) : std::min(d, 0.0));
          }
        }
      }
    });
  }

  double at(std::int64_t x, std::int64_t y, std::int64_t z) const override {
    const auto runs = band_.row(y, z);
    const auto after =
        std::upper_bound(runs.begin(), runs.end(), x, [](std::int64_t v, const Run& r) { return v < r.begin; });
    if (after == runs.begin() || x >= (after - 1)->end) return std::nan("");
    const Run& run = *(after - 1);
    return static_cast<double>(
        depth_[first_[static_cast<std::size_t>(&run - band_.runs().data())] + static_cast<std::size_t>(x - run.begin)]);
  }

 private:
  VoxelShape band_;
  std::vector<std::size_t> first_;  // of every run of the band
  std::vector<float> depth_;
};

}  // namespace

TriangleMesh mesh_of(const Envelope& envelope, const VoxelShape& voxels, Context* context) {
  if (voxels.grid().is_plane())
    throw Error(ErrorCode::usage, "the solid of an axis of a plane is flat and has no mesh");
  return base::in_arena(context, [&] {
    const Depths depths(envelope, voxels, context);
    TriangleMesh mesh = shape::all_layers(voxels, &depths, context);
    to_world(mesh, voxels.grid());
    return mesh;
  });
}

Surface surface_of_voxels(const VoxelShape& shape, Context* context) {
  // Corners of faces in order of the lattice; a surface makes those at one place one.
  TriangleMesh mesh;
  const Grid& grid = shape.grid();
  const bool mirrored = grid.direction.determinant() < 0;
  const auto add = [&](const std::array<std::int64_t, 3>& voxel, int axis, bool upper) {
    const auto base = static_cast<std::uint32_t>(mesh.points.size());
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (int i = 0; i < 4; ++i) {
      LatticePoint at;
      for (std::size_t a = 0; a < 3; ++a) at[a] = static_cast<std::int32_t>(voxel[a]);
      at[static_cast<std::size_t>(axis)] += upper;
      at[static_cast<std::size_t>(u)] += i == 1 || i == 2;
      at[static_cast<std::size_t>(v)] += i == 2 || i == 3;
      mesh.points.push_back(grid.world_of(at));
    }
    if (upper != mirrored) {
      mesh.triangles.push_back({base, base + 1, base + 2});
      mesh.triangles.push_back({base, base + 2, base + 3});
    } else {
      mesh.triangles.push_back({base, base + 2, base + 1});
      mesh.triangles.push_back({base, base + 3, base + 2});
    }
  };
  const auto faces_towards = [&](const Run& run, std::int64_t y, std::int64_t z, int axis, int step) {
    std::int64_t x = run.begin;
    const auto put = [&](std::int64_t end) {
      for (; x < end; ++x) add({x, y, z}, axis, step > 0);
    };
    for (const Run& other : shape.row(axis == 1 ? y + step : y, axis == 2 ? z + step : z)) {
      if (other.end <= x) continue;
      if (other.begin >= run.end) break;
      put(std::min<std::int64_t>(other.begin, run.end));
      x = std::max<std::int64_t>(x, other.end);
    }
    put(run.end);
  };
  for (std::int64_t z = 0; z < grid.dims[2]; ++z)
    for (std::int64_t y = 0; y < grid.dims[1]; ++y)
      for (const Run& run : shape.row(y, z)) {
        add({run.begin, y, z}, 0, false);
        add({run.end - 1, y, z}, 0, true);
        for (int axis = 1; axis < 3; ++axis)
          for (const int step : {-1, 1}) faces_towards(run, y, z, axis, step);
      }
  return Surface(std::move(mesh), SurfaceKind::voxels, context);
}

}  // namespace quench
