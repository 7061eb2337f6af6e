// SPDX-License-Identifier: Apache-2.0
// How fast voxel cores approach the medial axes of smooth shapes (Yan 2018, Thms. 2.5.1 to 2.5.4, Fig. 2.9), as the
// Markdown tables of notes/convergence.md.
//   bench_convergence voxels|topology|axis|prunings|mesh|blobs [LARGEST_RESOLUTION]
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <string>
#include <vector>

#include "one_sided_distance.h"
#include "quench/axis.h"
#include "quench/samples.h"
#include "quench/voxelize.h"
#include "smooth_shapes.h"
#include "voxelization_distance.h"

namespace {

using namespace quench;

double voxel_size(const smooth::Solid& solid, std::int64_t resolution) {
  return solid.longest_side / static_cast<double>(resolution);
}
const char* placed(std::uint64_t tilt) { return tilt ? "tilted" : "aligned"; }

// Theorem 2.5.1: Hausdorff distances in voxels; the largest of one aligned and a few tilted grids.
void print_voxel_distances(std::int64_t largest) {
  fmt::print(
      "| solid | resolution | h / reach | vertices to surface | surface to vertices | bound | "
      "voxels to solid | solid to voxels | bound |\n|---|---|---|---|---|---|---|---|---|\n");
  for (const auto& solid : smooth::solids())
    for (std::int64_t resolution = 8; resolution <= largest; resolution *= 2) {
      const double h = voxel_size(*solid, resolution);
      if (h >= 2 * std::sqrt(3.0) / 3 * solid->reach) continue;
      smooth::VoxelizationDistances worst;
      const std::uint64_t tilts = resolution <= 256 ? 4 : 1;
      for (std::uint64_t tilt = 0; tilt <= tilts; ++tilt) {
        const VoxelShape shape = smooth::digitize(*solid, smooth::grid_for(*solid, resolution, tilt));
        const auto d = smooth::voxelization_distances(*solid, shape, 100000);
        worst.vertices_to_surface = std::max(worst.vertices_to_surface, d.vertices_to_surface);
        worst.surface_to_vertices = std::max(worst.surface_to_vertices, d.surface_to_vertices);
        worst.voxels_to_solid = std::max(worst.voxels_to_solid, d.voxels_to_solid);
        worst.solid_to_voxels = std::max(worst.solid_to_voxels, d.solid_to_voxels);
      }
      fmt::print("| {} | {} | {:.3f} | {:.3f} | {:.3f} | {:.3f} | {:.3f} | {:.3f} | {:.3f} |\n", solid->name,
                 resolution, h / solid->reach, worst.vertices_to_surface, worst.surface_to_vertices,
                 (std::sqrt(2.0) + std::sqrt(3.0)) / 2, worst.voxels_to_solid, worst.solid_to_voxels,
                 std::sqrt(3.0) / 2);
      std::fflush(stdout);
    }
}

// Theorems 2.5.2 and 2.5.3: every resolution from 4 voxels up, one aligned and 20 tilted grids each; cores too
// below 64.
void print_topology(std::int64_t largest) {
  fmt::print(
      "| solid | resolutions | h / reach | shapes | wrong shapes | cores | wrong cores "
      "|\n|---|---|---|---|---|---|---|\n");
  for (const auto& solid : smooth::solids()) {
    struct Row {
      std::int64_t from = 0, to = 0;
      int shapes = 0, wrong_shapes = 0, cores = 0, wrong_cores = 0;
    };
    const auto promised =
        static_cast<std::int64_t>(std::floor(std::sqrt(3.0) * solid->longest_side / solid->reach)) + 1;
    std::array<Row, 3> rows{Row{4, promised / 2}, Row{promised / 2 + 1, promised - 1}, Row{promised, largest}};
    for (Row& row : rows) {
      for (std::int64_t resolution = row.from; resolution <= row.to; ++resolution)
        for (std::uint64_t tilt = 0; tilt <= 20; ++tilt) {
          const VoxelShape shape = smooth::digitize(*solid, smooth::grid_for(*solid, resolution, tilt));
          ++row.shapes;
          row.wrong_shapes += !(topology(shape) == solid->topology);
          if (resolution > 64 || tilt > 4) continue;
          ++row.cores;
          row.wrong_cores += !(topology(voxel_core(shape).complex) == solid->topology);
        }
      fmt::print("| {} | {} to {} | {:.2f} to {:.2f} | {} | {} | {} | {} |\n", solid->name, row.from, row.to,
                 voxel_size(*solid, row.from) / solid->reach, voxel_size(*solid, row.to) / solid->reach, row.shapes,
                 row.wrong_shapes, row.cores, row.wrong_cores);
      std::fflush(stdout);
    }
  }
}

// Theorem 2.5.4 and Fig. 2.9.
void print_axis_distances(std::int64_t largest) {
  std::string head = "| solid | grid | λ / side | distance |", rule = "|---|---|---|---|";
  for (std::int64_t resolution = 128; resolution <= largest; resolution *= 2) {
    head += fmt::format(" {} |", resolution);
    rule += "---|";
  }
  fmt::print("{}\n{}\n", head, rule);
  constexpr std::array<double, 3> fractions{0.015, 0.025, 0.065};
  for (const auto& solid : smooth::solids())
    for (const std::uint64_t tilt : {0u, 1u}) {
      std::array<std::string, 2 * fractions.size()> rows;
      for (std::size_t i = 0; i < rows.size(); ++i)
        rows[i] = fmt::format("| {} | {} | {} | {} |", solid->name, placed(tilt), fractions[i / 2],
                              i % 2 ? "axis to core" : "core to axis");
      for (std::int64_t resolution = 128; resolution <= largest; resolution *= 2) {
        const double h = voxel_size(*solid, resolution);
        MedialAxis core = voxel_core(smooth::digitize(*solid, smooth::grid_for(*solid, resolution, tilt)));
        prune_levels(core);
        for (std::size_t i = 0; i < fractions.size(); ++i) {
          const double lambda = fractions[i] * solid->longest_side;
          const auto d = smooth::axis_distances(pruned(core, lambda), *solid, lambda);
          const auto cell = [&](double x) {
            return fmt::format(" {:.5f} ({:.2f} h) |", x / solid->longest_side, x / h);
          };
          rows[2 * i] += cell(d.core_to_axis);
          rows[2 * i + 1] += cell(d.axis_to_core);
        }
        fmt::print(stderr, "{} {} {} done\n", solid->name, placed(tilt), resolution);
      }
      for (const std::string& row : rows) fmt::print("{}\n", row);
      std::fflush(stdout);
    }
}

// Prunings by detail and by lambda beside each other: to the whole axis, and from the axis of a lambda.
void print_prunings(std::int64_t largest) {
  constexpr std::array<double, 3> fractions{0.015, 0.025, 0.065};
  fmt::print(
      "| solid | grid | resolution | pruning | faces | core to axis | axis of λ 0.015 to core | 0.025 | 0.065 |\n"
      "|---|---|---|---|---|---|---|---|---|\n");
  for (const auto& solid : smooth::solids())
    for (const std::uint64_t tilt : {0u, 1u})
      for (std::int64_t resolution = 64; resolution <= largest; resolution *= 2) {
        const double h = voxel_size(*solid, resolution);
        MedialAxis core = voxel_core(smooth::digitize(*solid, smooth::grid_for(*solid, resolution, tilt)));
        prune_levels(core);
        add_detail(core);
        prune_levels(core, kDetail);
        const auto row = [&](const std::string& name, const MedialAxis& kept) {
          std::string line =
              fmt::format("| {} | {} | {} | {} | {} | {:.2f} h |", solid->name, placed(tilt), resolution, name,
                          kept.complex.face_count(), smooth::axis_distances(kept, *solid, 0).core_to_axis / h);
          for (const double fraction : fractions)
            line += fmt::format(" {:.2f} h |",
                                smooth::axis_distances(kept, *solid, fraction * solid->longest_side).axis_to_core / h);
          fmt::print("{}\n", line);
          std::fflush(stdout);
        };
        row("detail", pruned(core, auto_detail(core.grid), kDetail));
        for (const double fraction : fractions)
          row(fmt::format("λ {}", fraction), pruned(core, fraction * solid->longest_side));
      }
}

// The digitization of the formula against voxelize() of the tessellated sample, on the grid that voxelize() chose.
void print_mesh_comparison(std::int64_t largest) {
  fmt::print("| solid | triangles | resolution | voxels | voxels that differ |\n|---|---|---|---|---|\n");
  for (const auto& solid : smooth::solids())
    for (const double detail : {1.0, 4.0}) {
      const TriangleMesh mesh = make_sample(solid->name, {.fineness = detail}).mesh;
      const Voxelization v = voxelize(mesh, {.resolution = largest});
      const VoxelShape exact = smooth::digitize(*solid, v.shape.grid());
      std::int64_t differ = 0;
      const auto& dims = v.shape.grid().dims;
      for (std::int64_t z = 0; z < dims[2]; ++z)
        for (std::int64_t y = 0; y < dims[1]; ++y) {
          const auto a = exact.row(y, z), b = v.shape.row(y, z);
          if (std::equal(a.begin(), a.end(), b.begin(), b.end())) continue;
          for (std::int64_t x = 0; x < dims[0]; ++x) differ += exact.contains(x, y, z) != v.shape.contains(x, y, z);
        }
      fmt::print("| {} | {} | {} | {} | {} |\n", solid->name, mesh.triangles.size(), largest, exact.voxel_count(),
                 differ);
    }
}

// Fig. 2.11: bridges of 2.3 voxels at resolution 256.
void print_blobs(std::int64_t largest) {
  const auto text = [](const Topology& t) { return fmt::format("{}, {}, {}", t.betti[0], t.betti[1], t.betti[2]); };
  fmt::print("| resolution | shape b0, b1, b2 | core | pruned, λ = 0.02 | pruned, λ = inf |\n|---|---|---|---|---|\n");
  const TriangleMesh mesh = make_sample("four-blobs").mesh;
  for (const std::int64_t resolution : {64, 128, 192, 256, 384, 512}) {
    if (resolution > largest) break;
    const Voxelization v = voxelize(mesh, {.resolution = resolution});
    MedialAxis core = voxel_core(v.shape);
    prune_levels(core);
    fmt::print("| {} | {} | {} | {} | {} |\n", resolution, text(topology(v.shape)), text(topology(core.complex)),
               text(topology(pruned(core, 0.02 * v.longest_side).complex)),
               text(topology(pruned(core, std::numeric_limits<double>::infinity()).complex)));
    std::fflush(stdout);
  }
}

}  // namespace

int main(int argc, char** argv) {
  const std::string table = argc > 1 ? argv[1] : "";
  const auto largest = [&](std::int64_t preset) { return argc > 2 ? std::atoll(argv[2]) : preset; };
  if (table == "voxels")
    print_voxel_distances(largest(1024));
  else if (table == "topology")
    print_topology(largest(128));
  else if (table == "axis")
    print_axis_distances(largest(1024));
  else if (table == "prunings")
    print_prunings(largest(512));
  else if (table == "mesh")
    print_mesh_comparison(largest(512));
  else if (table == "blobs")
    print_blobs(largest(512));
  else {
    fmt::print(stderr, "usage: bench_convergence voxels|topology|axis|prunings|mesh|blobs [LARGEST_RESOLUTION]\n");
    return 2;
  }
  return 0;
}
