// SPDX-License-Identifier: Apache-2.0
#include <quench/quench.h>

#include <cstdio>
#include <string>

bool old_names_work();

int main() {
  const auto shape = quench::voxelize(quench::make_sample("torus").mesh, {.resolution = 48}).shape;
  quench::MedialAxis axis = quench::voxel_core(shape);
  quench::prune_levels(axis);
  const quench::MedialAxis kept = quench::pruned(axis, 2 * shape.grid().spacing[0]);
  const bool same = quench::topology(kept.complex) == quench::topology(shape);
  std::printf("%u vertices, topology %s\n", kept.complex.vertex_count, same ? "kept" : "lost");
  const std::string version = std::to_string(QUENCH_VERSION_MAJOR) + "." + std::to_string(QUENCH_VERSION_MINOR) + "." +
                              std::to_string(QUENCH_VERSION_PATCH);
  if (version != PACKAGE_VERSION) std::printf("the header says %s, the package %s\n", version.c_str(), PACKAGE_VERSION);
  return same && version == PACKAGE_VERSION && old_names_work() ? 0 : 1;
}
