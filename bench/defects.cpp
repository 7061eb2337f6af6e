// SPDX-License-Identifier: Apache-2.0
// The table of notes/defective_meshes.md: every damage of every mesh, and how far its voxels are from the clean ones.
//   bench_defects RESOLUTION [MESH...]      without MESH: the built-in shapes
#include <fmt/format.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "damage.h"
#include "quench/error.h"
#include "quench/io.h"
#include "quench/samples.h"
#include "quench/voxelize.h"
#include "voxel_difference.h"

int main(int argc, char** argv) {
  using namespace quench;
  VoxelizeOptions options;
  options.resolution = argc > 1 ? std::atoll(argv[1]) : 128;
  std::vector<std::pair<std::string, TriangleMesh>> meshes;
  for (int i = 2; i < argc; ++i)
    meshes.emplace_back(std::filesystem::path(argv[i]).stem().string(), to_triangle_mesh(io::read_record(argv[i])));
  if (meshes.empty())
    for (const SampleInfo& s : built_in_samples()) meshes.emplace_back(std::string(s.name), make_sample(s.name).mesh);
  fmt::print("| mesh | damage | outcome | difference | voxels by winding number | s |\n|---|---|---|---|---|---|\n");
  for (const auto& [name, clean] : meshes) {
    const Voxelization whole = voxelize(testing_damage::pinned(clean, clean), options);
    if (!whole.sound) {
      fmt::print(stderr, "{} is left out: {}\n", name, defects_text(whole));
      continue;
    }
    const VoxelShape& wanted = whole.shape;
    for (const auto& damage : testing_damage::damages()) {
      const auto start = std::chrono::steady_clock::now();
      try {
        const Voxelization v = voxelize(testing_damage::pinned(damage.apply(clean, 1), clean), options);
        const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
        fmt::print("| {} | {} | {} | {:.3f} % | {:.2f} % | {:.2f} |\n", name, damage.name,
                   v.sound                         ? "sound"
                   : v.defects.defective_scanlines ? "winding number"
                                                   : "crossings decide",
                   100 * voxel_difference(v.shape, wanted), 100 * v.defects.winding_share, seconds.count());
      } catch (const Error& error) {
        fmt::print("| {} | {} | {} | | | |\n", name, damage.name, error.what());
      }
      std::fflush(stdout);
    }
  }
}
