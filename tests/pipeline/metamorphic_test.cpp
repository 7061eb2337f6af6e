// SPDX-License-Identifier: Apache-2.0
// What must not change when the input is turned, mirrored, moved, padded, or when threads are added.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "quench/axis.h"
#include "quench/samples.h"
#include "quench/shape.h"
#include "quench/voxelize.h"
#include "random_shapes.h"

namespace quench {
namespace metamorphic_test {

struct Symmetry {
  std::array<int, 3> axis;  // new axis a is old axis axis[a]
  std::array<bool, 3> mirror;
};

std::vector<Symmetry> cube_symmetries() {
  std::vector<Symmetry> all;
  std::array<int, 3> axis{0, 1, 2};
  do
    for (int m = 0; m < 8; ++m) all.push_back({axis, {(m & 1) != 0, (m & 2) != 0, (m & 4) != 0}});
  while (std::next_permutation(axis.begin(), axis.end()));
  return all;
}

VoxelShape apply(const VoxelShape& shape, const Symmetry& s) {
  Grid grid = shape.grid();
  for (int a = 0; a < 3; ++a) {
    grid.dims[a] = shape.grid().dims[s.axis[a]];
    grid.spacing[a] = shape.grid().spacing[s.axis[a]];
  }
  return testing_shapes::from_predicate(grid, [&](int x, int y, int z) {
    const int p[3] = {x, y, z};
    std::array<std::int64_t, 3> old{};
    for (int a = 0; a < 3; ++a) old[s.axis[a]] = s.mirror[a] ? grid.dims[a] - 1 - p[a] : p[a];
    return shape.contains(old[0], old[1], old[2]);
  });
}

LatticePoint apply(const LatticePoint& p, const Grid& target, const Symmetry& s) {
  LatticePoint q;
  for (int a = 0; a < 3; ++a)
    q[a] = s.mirror[a] ? static_cast<std::int32_t>(target.dims[a]) - p[s.axis[a]] : p[s.axis[a]];
  return q;
}

MedialAxis core_of(const VoxelShape& shape) {
  MedialAxis axis = voxel_core(shape);
  prune_levels(axis);
  return axis;
}

// Faces by their sites, with lambda and the sorted radii of their corners: what identifies a full core without
// numbering.
using FaceKey = std::tuple<std::array<LatticePoint, 2>, double, std::vector<float>>;
std::multiset<FaceKey> faces_of(const MedialAxis& axis, double lambda, const Grid* target = nullptr,
                                const Symmetry* s = nullptr) {
  std::multiset<FaceKey> keys;
  const std::vector<double>& lambda_of = axis.measure().value.face;
  for (std::size_t f = 0; f < axis.complex.face_count(); ++f) {
    if (lambda_of[f] < lambda) continue;
    std::array<LatticePoint, 2> sites{axis.sites[axis.face_sites[f][0]], axis.sites[axis.face_sites[f][1]]};
    if (s)
      for (auto& p : sites) p = apply(p, *target, *s);
    std::sort(sites.begin(), sites.end());
    std::vector<float> radii;
    for (std::uint32_t v : axis.complex.corners(f))
      radii.push_back(static_cast<float>(std::round(axis.radius[v] * 1e4)));
    std::sort(radii.begin(), radii.end());
    keys.insert({sites, lambda_of[f], radii});
  }
  return keys;
}

TEST(Metamorphic, FortyEightSymmetriesGiveTheSameFullCoreAndLambdaSubset) {
  for (std::uint64_t seed = 0; seed < 24; ++seed) {
    const VoxelShape shape = testing_shapes::random_shape(seed, 10, seed % 3 == 2);
    const MedialAxis axis = core_of(shape);
    const Topology wanted = topology(shape);
    for (const Symmetry& s : cube_symmetries()) {
      const VoxelShape turned = apply(shape, s);
      const MedialAxis other = core_of(turned);
      ASSERT_EQ(topology(turned), wanted);
      ASSERT_EQ(other.complex.vertex_count, axis.complex.vertex_count) << "seed " << seed;
      ASSERT_EQ(other.complex.edges.size(), axis.complex.edges.size()) << "seed " << seed;
      ASSERT_EQ(faces_of(other, 0), faces_of(axis, 0, &turned.grid(), &s)) << "seed " << seed;
      for (double lambda : {0.9, 1.6, 3.0}) {
        ASSERT_EQ(topology(pruned(other, lambda).complex), wanted) << "seed " << seed;
        // What is whole above lambda does not depend on the order among ties.
        ASSERT_EQ(faces_of(pruned(other, lambda), lambda), faces_of(pruned(axis, lambda), lambda, &turned.grid(), &s))
            << "seed " << seed;
      }
    }
  }
}

void expect_same_up_to_shift(const MedialAxis& a, const MedialAxis& b, const LatticePoint& shift) {
  ASSERT_EQ(a.complex.edges, b.complex.edges);
  ASSERT_EQ(a.complex.face_offsets, b.complex.face_offsets);
  ASSERT_EQ(a.complex.face_vertices, b.complex.face_vertices);
  ASSERT_EQ(a.radius, b.radius);
  ASSERT_TRUE(a.measure().value == b.measure().value);
  ASSERT_TRUE(a.measure().level == b.measure().level);
  ASSERT_EQ(a.face_sites, b.face_sites);
  ASSERT_EQ(a.sites.size(), b.sites.size());
  for (std::size_t s = 0; s < a.sites.size(); ++s)
    for (int i = 0; i < 3; ++i) ASSERT_EQ(a.sites[s][i] + shift[i], b.sites[s][i]);
}

TEST(Metamorphic, PaddingAndTranslationChangeNothing) {
  for (std::uint64_t seed = 0; seed < 150; ++seed) {
    const VoxelShape shape = testing_shapes::random_shape(seed, 11, seed % 3 == 1);
    const LatticePoint shift{static_cast<std::int32_t>(seed % 7), static_cast<std::int32_t>(seed % 5),
                             static_cast<std::int32_t>(seed % 3)};
    Grid padded = shape.grid();
    for (int i = 0; i < 3; ++i) padded.dims[i] += shift[i] + static_cast<std::int64_t>(seed % 4);
    const VoxelShape moved = testing_shapes::from_predicate(
        padded, [&](int x, int y, int z) { return shape.contains(x - shift[0], y - shift[1], z - shift[2]); });
    expect_same_up_to_shift(core_of(shape), core_of(moved), shift);
  }
}

// More threads than processors, so that they are interrupted at any place.
TEST(Metamorphic, NumberOfThreadsAndRepetitionChangeNothing) {
  const VoxelShape shapes[] = {testing_shapes::random_shape(3, 40), testing_shapes::box_shape(90, 80, 3),
                               voxelize(make_sample("bumpy-sphere").mesh, {.resolution = 80}).shape};
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 8);
  for (const VoxelShape& shape : shapes) {
    const auto with_threads = [&](int n) {
      Context context;
      context.threads = n;
      MedialAxis core = voxel_core(shape, {}, &context);
      prune_levels(core, &context);
      return core;
    };
    const MedialAxis one = with_threads(1);
    for (const int n : {1, 2, 8, 8, 8}) {
      const MedialAxis other = with_threads(n);
      expect_same_up_to_shift(one, other, {0, 0, 0});
      for (std::size_t v = 0; v < one.points.size(); ++v) ASSERT_EQ(one.points[v], other.points[v]);
    }
  }
}

}  // namespace metamorphic_test
}  // namespace quench
