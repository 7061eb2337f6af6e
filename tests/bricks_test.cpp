// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <memory>

#include "bricks/dual_complex_in_bricks.h"
#include "lattice/cells.h"
#include "quench/sample.h"
#include "quench/voxelize.h"
#include "random_shapes.h"

namespace quench::bricks {
namespace {

using lattice::DualComplex;

void expect_same(const DualComplex& a, const DualComplex& b, const std::string& where) {
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

const std::vector<BrickPlan> kTinyPlans{
    {{{3, 2}, {6, 4}}, 0}, {{{4, 3}}, 0}, {{{1, 1}, {2, 1}, {3, 1}, {4, 1}}, 0}, {{{5, 1}, {2, 6}, {3, 1}}, 0}};

void expect_same_in_bricks(const VoxelShape& shape, std::span<const BrickPlan> plans, const std::string& where) {
  const auto sites = boundary_vertices(shape);
  const auto spacing = integer_spacing(shape.grid());
  const DualComplex whole =
      lattice::dual_complex(shape, std::make_unique<lattice::Delaunay>(sites, spacing, nullptr), sites, nullptr);
  for (std::size_t p = 0; p < plans.size(); ++p)
    for (const int threads : {1, 4}) {
      tbb::task_arena arena(threads);
      const std::string what = where + ", plan " + std::to_string(p) + ", threads " + std::to_string(threads);
      try {
        const DualComplex parts =
            arena.execute([&] { return dual_complex_in_bricks(shape, sites, spacing, plans[p], nullptr); });
        expect_same(parts, whole, what);
      } catch (const std::exception& e) {
        FAIL() << what << ": " << e.what();
      }
    }
}

TEST(Bricks, RandomShapesAreTheSameInBricks) {
  for (std::uint64_t seed = 0; seed < 300; ++seed)
    expect_same_in_bricks(testing_shapes::random_shape(seed, 12), kTinyPlans, "seed " + std::to_string(seed));
}

}  // namespace
}  // namespace quench::bricks
