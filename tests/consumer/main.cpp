// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "quench/axis.h"
#include "quench/samples.h"
#include "quench/shape.h"
#include "quench/axis.h"
#include "quench/voxelize.h"

int main() {
  const auto shape = quench::voxelize(quench::make_sample("torus").mesh, {.resolution = 48}).shape;
  quench::MedialAxis axis = quench::voxel_core(shape);
  quench::prune_levels(axis);
  const quench::MedialAxis kept = quench::pruned(axis, 2 * shape.grid().spacing[0]);
  const bool same = quench::topology(kept.complex) == quench::topology(shape);
  std::printf("%u vertices, topology %s\n", kept.complex.vertex_count, same ? "kept" : "lost");
  return same ? 0 : 1;
}
