// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <span>
#include <string>

#include "dual/dual_complex.h"
#include "random_shapes.h"

/// For tests that compare ways to the dual complex.
namespace quench::testing_duals {

inline void expect_same(const dual::DualComplex& a, const dual::DualComplex& b, const std::string& where) {
  ASSERT_EQ(a.complex.vertex_count, b.complex.vertex_count) << where;
  ASSERT_TRUE(a.vertex_site_offsets == b.vertex_site_offsets && a.vertex_sites == b.vertex_sites) << where;
  ASSERT_EQ(a.complex.edges.size(), b.complex.edges.size()) << where;
  ASSERT_TRUE(a.complex.edges == b.complex.edges) << where;
  ASSERT_EQ(a.complex.face_count(), b.complex.face_count()) << where;
  ASSERT_TRUE(a.face_sites == b.face_sites) << where;
  ASSERT_TRUE(a.complex.face_offsets == b.complex.face_offsets) << where;
  ASSERT_TRUE(a.complex.face_vertices == b.complex.face_vertices) << where;
  ASSERT_TRUE(a.complex.face_edges == b.complex.face_edges) << where;
}

/// Calls expect(shape, options, where) for random shapes of the seeds in [first, last), each with one of the `ways` to
/// the complex.
template <class Ways, class Expect>
void for_random_shapes(std::uint64_t first, std::uint64_t last, int largest, bool anisotropic, const Ways& ways,
                       const Expect& expect) {
  for (std::uint64_t seed = first; seed < last && !testing::Test::HasFatalFailure(); ++seed)
    expect(testing_shapes::random_shape(seed, largest, anisotropic),
           std::span(ways).subspan(seed / 4 % std::size(ways), 1), "seed " + std::to_string(seed));
}

/// The same for shapes with these spacings, each with all ways.
template <class Ways, class Expect>
void for_spacings(std::initializer_list<Vec3> spacings, const Ways& ways, const Expect& expect) {
  for (const Vec3& spacing : spacings)
    for (std::uint64_t seed = 0; seed < 20 && !testing::Test::HasFatalFailure(); ++seed) {
      const VoxelShape unit = testing_shapes::random_shape(seed, 9);
      Grid grid = unit.grid();
      grid.spacing = spacing;
      expect(testing_shapes::from_predicate(grid, [&](int x, int y, int z) { return unit.contains(x, y, z); }),
             std::span(ways), "skew spacing, seed " + std::to_string(seed));
    }
}

/// Walls that meet along edges and in points: sites with several components of O around them, on both sides of walls.
inline VoxelShape touching_walls(int rule) {
  Grid grid;
  grid.dims = {13, 13, 13};
  return testing_shapes::from_predicate(grid, [rule](int x, int y, int z) {
    const int a = x / 3, b = y / 3, c = z / 3;
    if (rule == 0) return (a + b + c) % 2 == 0;
    if (rule == 1) return (a + b) % 2 == 0;
    if (rule == 2) return x % 4 != 1 || (y + z) % 5 == 0;
    return (x + y + z) % 2 == 0;
  });
}
inline constexpr int kWallRules = 4;

/// A ball with a hole around a tube; radii in voxels, 0: none.
inline VoxelShape shells(double inner, double outer, double tube) {
  Grid grid;
  grid.dims = {26, 26, 26};
  return testing_shapes::from_predicate(grid, [=](int x, int y, int z) {
    const double a = x - 12.5, b = y - 12.5, c = z - 12.5, squared = a * a + b * b + c * c;
    return (squared < outer * outer && squared >= inner * inner) || (tube > 0 && a * a + b * b < tube * tube);
  });
}

/// Small parts at both ends of a grid of `length` voxels along x.
inline VoxelShape far_apart(int length) {
  Grid grid;
  grid.dims = {length, 3, 3};
  VoxelShape shape(grid);
  for (int z = 0; z < 3; ++z)
    for (int y = 0; y < 3; ++y)
      shape.append_row(std::vector<quench::Run>{{0, 2 + y}, {length / 2, length / 2 + 1}, {length - 10 + z, length}});
  return shape;
}

}  // namespace quench::testing_duals
