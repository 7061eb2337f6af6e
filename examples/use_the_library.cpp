// SPDX-License-Identifier: Apache-2.0
// The main job through the library: mesh, voxels, voxel core, pruning, file.
#include <cstdio>
#include <exception>

#include "quench/quench.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: use_the_library OUT.vtp\n");
    return 2;
  }
  try {
    // Or: quench::to_triangle_mesh(quench::io::read_record("part.off"))
    const quench::TriangleMesh mesh = quench::make_sample("fin-on-board").mesh;
    const quench::Voxelization voxels = quench::voxelize(mesh, {.resolution = 128});
    const quench::MedialAxis axis = quench::medial_axis(voxels.shape);
    quench::io::write_record(argv[1], quench::to_record(axis));
    const bool same = quench::topology(axis.complex) == quench::topology(voxels.shape);
    std::printf("%u vertices; topology %s\n", axis.complex.vertex_count, same ? "kept" : "lost");
    return same ? 0 : 4;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
