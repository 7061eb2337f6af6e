// SPDX-License-Identifier: Apache-2.0
// Shapes of fine structure: a pack of beads, a rough plate, long bars.
#include "samples/sample_shapes.h"

namespace quench::samples {

// A grain pack, as in a porous rock: beads on a jittered cubic lattice, each large enough to overlap its neighbours, so
// that grains and pores are both connected.
Sample bead_pack(const SampleOptions& options) {
  constexpr int kSide = 12;
  Random random(options.seed);
  const TriangleMesh bead = sphere(scaled(6, options.fineness, 2), [](const Vec3& d) { return d; });
  Sample sample;
  for (int k = 0; k < kSide; ++k)
    for (int j = 0; j < kSide; ++j)
      for (int i = 0; i < kSide; ++i) {
        Vec3 centre(i, j, k);
        for (int a = 0; a < 3; ++a) centre[a] += random.between(-0.12, 0.12);
        const double radius = random.between(0.54, 0.62);
        TriangleMesh moved = bead;
        for (Vec3& p : moved.points) p = centre + radius * p;
        append(sample.mesh, moved);
      }
  return sample;
}

// A thin plate, each vertex of its large faces displaced at random across the plate.
Sample rough_plate(const SampleOptions& options) {
  const double height = 2 * (options.noise > 0 ? options.noise : 0.01);
  const int along = scaled(200, options.fineness, 2), across = scaled(140, options.fineness, 2);
  constexpr double kHalfThickness = 0.06;
  const double most = std::min(height, 0.9 * kHalfThickness);  // the faces never meet
  const auto place = [&](const LatticePoint& p) {
    const auto name = (static_cast<std::uint64_t>(p[2]) * 4096 + static_cast<std::uint64_t>(p[1])) * 4096 +
                      static_cast<std::uint64_t>(p[0]);
    const double noise = Random(options.seed * 0x100000000ull + name).between(-most, most);
    return Vec3(-1 + 2.0 * p[0] / along, -0.7 + 1.4 * p[1] / across, (p[2] == 0 ? -1 : 1) * kHalfThickness + noise);
  };
  return {box_surface({along, across, 1}, place), {}};
}

// Three parallel bars, up to 128 times as long as thick: few boundary vertices for their resolution.
Sample bars(const SampleOptions& options) {
  const int along = scaled(512, options.fineness, 4), around = scaled(4, options.fineness, 1);
  Sample sample;
  double y = 0;
  for (const double thick : {2.0 / 128, 2.0 / 100, 2.0 / 80}) {
    append(sample.mesh, box_surface({along, around, around}, [&](const LatticePoint& p) {
             return Vec3(-1 + 2.0 * p[0] / along, y + thick * p[1] / around, thick * p[2] / around);
           }));
    y += 2 * thick;
  }
  return sample;
}

}  // namespace quench::samples
