// SPDX-License-Identifier: Apache-2.0
// Local thickness per voxel inside, beyond the core: wall and CPU time, of all points of edges and of vertices alone,
// for plates and rods as of trabecular bone (a fifth of the volume: |f| < c for a random field f of one wavelength),
// and for what else is named. With a file, writes the shape for bench/thickness.py.
//   bench_thickness bone:SIZE|cube:SIZE|slab:SIZE|SHAPE_FILE[:THRESHOLD]... [-o VOLUME.nrrd]
// Environment: THREADS (2), WAVELENGTH of bone in voxels (137: walls of 12).
#include "quench/thickness.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "measure.h"
#include "quench/axis.h"
#include "quench/io.h"
#include "quench/pipeline.h"

namespace {

using namespace quench;

template <class Inside>
VoxelShape shape_where(std::int64_t size, const Inside& inside) {
  Grid grid;
  grid.dims = {size, size, size};
  VoxelShape shape(grid);
  const auto rows = static_cast<std::size_t>(size);
  std::vector<std::vector<Run>> runs(rows);
  for (std::int32_t z = 0; z < size; ++z) {
    tbb::parallel_for(std::size_t{0}, rows, [&](std::size_t y) {
      runs[y].clear();
      for (std::int32_t x = 0; x < size; ++x) {
        if (!inside(x, static_cast<std::int32_t>(y), z)) continue;
        if (!runs[y].empty() && runs[y].back().end == x)
          ++runs[y].back().end;
        else
          runs[y].push_back({x, x + 1});
      }
    });
    for (const auto& row : runs) shape.append_row(row);
  }
  return shape;
}

// A sum of waves of random directions and phases, known at every fourth voxel and interpolated.
class RandomField {
 public:
  RandomField(std::int64_t size, double wavelength) : n_(size / kStep + 2) {
    constexpr int kWaves = 40;
    std::mt19937_64 random(1);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> phase(0, 2 * std::numbers::pi);
    std::vector<Vec3> k(kWaves);
    std::vector<double> phi(kWaves);
    for (int w = 0; w < kWaves; ++w) {
      const double x = normal(random), y = normal(random), z = normal(random);
      k[static_cast<std::size_t>(w)] = Vec3(x, y, z).normalized() * (2 * std::numbers::pi / wavelength * kStep);
      phi[static_cast<std::size_t>(w)] = phase(random);
    }
    values_.resize(static_cast<std::size_t>(n_ * n_ * n_));
    tbb::parallel_for(std::int64_t{0}, n_, [&](std::int64_t z) {
      for (std::int64_t y = 0; y < n_; ++y)
        for (std::int64_t x = 0; x < n_; ++x) {
          double sum = 0;
          for (std::size_t w = 0; w < k.size(); ++w)
            sum += std::cos(k[w].dot(Vec3(static_cast<double>(x), static_cast<double>(y), static_cast<double>(z))) +
                            phi[w]);
          values_[at(x, y, z)] = static_cast<float>(sum * std::sqrt(2.0 / kWaves));
        }
    });
  }
  float operator()(std::int32_t x, std::int32_t y, std::int32_t z) const {
    const auto part = [](std::int32_t i) { return (static_cast<float>(i % kStep) + 0.5f) / kStep; };
    const float u = part(x), v = part(y), w = part(z);
    const std::int64_t i = x / kStep, j = y / kStep, k = z / kStep;
    const auto along_x = [&](std::int64_t b, std::int64_t c) {
      return (1 - u) * values_[at(i, b, c)] + u * values_[at(i + 1, b, c)];
    };
    return (1 - w) * ((1 - v) * along_x(j, k) + v * along_x(j + 1, k)) +
           w * ((1 - v) * along_x(j, k + 1) + v * along_x(j + 1, k + 1));
  }

 private:
  static constexpr int kStep = 4;
  std::size_t at(std::int64_t x, std::int64_t y, std::int64_t z) const {
    return static_cast<std::size_t>((z * n_ + y) * n_ + x);
  }
  std::int64_t n_;
  std::vector<float> values_;
};

VoxelShape shape_of(const std::string& name) {
  const std::size_t colon = name.find(':');
  const std::string kind = name.substr(0, colon), number = colon == name.npos ? "" : name.substr(colon + 1);
  const std::int64_t size = std::atoll(number.c_str());
  if (kind == "bone") {
    const char* wavelength = std::getenv("WAVELENGTH");
    const RandomField field(size, wavelength ? std::atof(wavelength) : 137);
    return shape_where(size, [&](auto x, auto y, auto z) { return std::abs(field(x, y, z)) < 0.2533f; });
  }
  if (kind == "cube") return shape_where(size, [](auto, auto, auto) { return true; });
  if (kind == "slab") return shape_where(size, [&](auto, auto, auto z) { return std::abs(z - size / 2) < size / 8; });
  pipeline::ShapeOptions options;
  options.surface = SurfaceKind::voxels;
  if (!number.empty()) options.foreground.threshold = std::atof(number.c_str());
  return pipeline::load_shape(kind, options).shape;
}

}  // namespace

int main(int argc, char** argv) {
  const char* threads = std::getenv("THREADS");
  Context context;
  context.threads = threads ? std::atoi(threads) : 2;
  for (int i = 1; i < argc; ++i) {
    const std::string name = argv[i];
    double cpu = cpu_seconds(), wall = wall_seconds();
    VoxelShape shape = shape_of(name);
    const auto voxels = static_cast<double>(shape.voxel_count());
    const auto all = static_cast<double>(shape.grid().dims[0] * shape.grid().dims[1] * shape.grid().dims[2]);
    fmt::print("{}: {:.0f} voxels inside ({:.1f} %), {} boundary vertices; made in {:.1f} s\n", name, voxels,
               100 * voxels / all, count_boundary_vertices(shape), wall_seconds() - wall);
    if (i + 2 < argc && std::string(argv[i + 1]) == "-o") {
      io::write_volume(argv[i + 2], shape);
      i += 2;
    }
    cpu = cpu_seconds(), wall = wall_seconds();
    MedialAxis core = voxel_core(shape, {}, &context);
    fmt::print("  core          {:8.2f} s, {:8.2f} s of CPU, {:6.1f} ns of CPU per voxel; {} vertices, {} edges\n",
               wall_seconds() - wall, cpu_seconds() - cpu, 1e9 * (cpu_seconds() - cpu) / voxels, core.points.size(),
               core.complex.edges.size());
    core.measures = {};
    core.face_sites = {};
    core.sites = {};
    core.complex.face_offsets = {0};
    core.complex.face_vertices = core.complex.face_edges = {};
    for (const bool between : {true, false}) {
      cpu = cpu_seconds(), wall = wall_seconds();
      ThicknessOptions options;
      options.between = between;
      const ThicknessReport report = local_thickness(shape, core, options, nullptr, &context);
      cpu = cpu_seconds() - cpu, wall = wall_seconds() - wall;
      const ThicknessDistribution& d = report.distribution;
      fmt::print(
          "  {} {:8.2f} s, {:8.2f} s of CPU, {:6.1f} ns of CPU per voxel; {} items; mean {:.4f} sd {:.4f} max {:.4f}\n",
          between ? "all of edges " : "vertices only", wall, cpu, 1e9 * cpu / voxels, report.items, d.mean(),
          d.deviation(), d.largest());
      std::fflush(stdout);
    }
    fmt::print("  peak {:.2f} GB\n", peak_bytes() / 1e9);
  }
}
