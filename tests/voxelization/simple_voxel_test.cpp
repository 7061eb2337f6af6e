// SPDX-License-Identifier: Apache-2.0
#include "shape/simple_voxel.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <random>
#include <vector>

#include "quench/shape.h"
#include "random_shapes.h"
#include "voxelization/voxel_graph.h"

namespace quench::voxelization {
namespace simple_voxel_test {

using namespace shape;  // NOLINT

struct Offset {
  int x, y, z;
  int steps() const { return std::abs(x) + std::abs(y) + std::abs(z); }
};

std::vector<Offset> offsets(int most_steps) {
  std::vector<Offset> result;
  for (int z = -1; z <= 1; ++z)
    for (int y = -1; y <= 1; ++y)
      for (int x = -1; x <= 1; ++x)
        if (const Offset o{x, y, z}; o.steps() > 0 && o.steps() <= most_steps) result.push_back(o);
  return result;
}

/// Components of some of the neighbours, by search; only those with a member of at most `touching` steps count.
int components(const std::vector<Offset>& members, bool by_faces, int touching) {
  std::vector<char> seen(members.size(), 0);
  int count = 0;
  for (std::size_t i = 0; i < members.size(); ++i) {
    if (seen[i]) continue;
    std::vector<std::size_t> stack{i};
    seen[i] = 1;
    bool touches = false;
    while (!stack.empty()) {
      const Offset a = members[stack.back()];
      stack.pop_back();
      touches = touches || a.steps() <= touching;
      for (std::size_t j = 0; j < members.size(); ++j) {
        const Offset d{members[j].x - a.x, members[j].y - a.y, members[j].z - a.z};
        const bool adjacent =
            by_faces ? d.steps() == 1 : std::abs(d.x) <= 1 && std::abs(d.y) <= 1 && std::abs(d.z) <= 1;
        if (seen[j] || !adjacent) continue;
        seen[j] = 1;
        stack.push_back(j);
      }
    }
    count += touches;
  }
  return count;
}

bool simple_by_search(Neighbours around) {
  std::vector<Offset> object, background;
  for (const Offset& o : offsets(2))
    if (around & neighbour_bit(o.x, o.y, o.z)) object.push_back(o);
  for (const Offset& o : offsets(3))
    if (!(around & neighbour_bit(o.x, o.y, o.z))) background.push_back(o);
  return components(object, true, 1) == 1 && components(background, false, 3) == 1;
}

/// A shape of the neighbours in the middle of a grid, with or without the voxel.
VoxelShape shape_of(Neighbours around, bool with_voxel) {
  Grid grid;
  grid.dims = {5, 5, 5};
  return testing_shapes::from_predicate(grid, [&](int x, int y, int z) {
    if (x == 2 && y == 2 && z == 2) return with_voxel;
    const bool near = x >= 1 && x <= 3 && y >= 1 && y <= 3 && z >= 1 && z <= 3;
    return near && (around & neighbour_bit(x - 2, y - 2, z - 2)) != 0;
  });
}

/// Random neighbours of every density.
Neighbours random_neighbours(std::mt19937_64& random) {
  Neighbours result = static_cast<Neighbours>(random());
  const auto thinning = random() % 5;
  if (thinning == 1) result &= static_cast<Neighbours>(random());
  if (thinning == 2) result |= static_cast<Neighbours>(random());
  if (thinning == 3) result &= static_cast<Neighbours>(random() & random());
  if (thinning == 4) result |= static_cast<Neighbours>(random() | random());
  return result & kAllNeighbours;
}

TEST(SimpleVoxel, EqualsTheDefinition) {
  std::mt19937_64 random(1);
  int simple = 0;
  for (int i = 0; i < 200000; ++i) {
    const Neighbours around = random_neighbours(random);
    ASSERT_EQ(is_simple(around), simple_by_search(around)) << around;
    ASSERT_EQ(is_simple(around | kCentre), is_simple(around)) << around;
    simple += is_simple(around);
  }
  EXPECT_GT(simple, 10000);
  EXPECT_LT(simple, 190000);
}

TEST(SimpleVoxel, SimpleVoxelsKeepTheTopologyAndTheEulerChangeIsThatOfTheShape) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 20000; ++i) {
    const Neighbours around = random_neighbours(random);
    const Topology without = topology(shape_of(around, false)), with = topology(shape_of(around, true));
    ASSERT_EQ(euler_change(around), with.euler - without.euler) << around;
    if (!is_simple(around)) continue;
    ASSERT_EQ(with.betti, without.betti) << around;
  }
}

std::vector<Voxel> random_voxels(const VoxelShape& shape, std::mt19937_64& random, std::uint64_t one_of) {
  std::vector<Voxel> result;
  const auto& dims = shape.grid().dims;
  for (std::int32_t z = 0; z < dims[2]; ++z)
    for (std::int32_t y = 0; y < dims[1]; ++y)
      for (std::int32_t x = 0; x < dims[0]; ++x)
        if (random() % one_of == 0) result.push_back({x, y, z});
  return result;
}

TEST(VoxelGraph, BettiNumbersAreThoseOfTheWholeShape) {
  std::mt19937_64 random(3);
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    VoxelShape shape = testing_shapes::random_shape(seed);
    const std::vector<Voxel> loose = random_voxels(shape, random, 2 + seed % 9);
    VoxelGraph graph(shape, topology(shape).euler, loose);
    ASSERT_EQ(graph.betti(), topology(shape).betti) << seed;
    for (int step = 0; step < 12 && graph.size() > 0; ++step) {
      std::vector<std::uint32_t> group;  // of voxels that are all inside or all outside
      const auto first = static_cast<std::uint32_t>(random() % graph.size());
      for (std::uint32_t v = 0; v < graph.size(); ++v)
        if (v == first || (random() % 4 == 0 && graph.inside(v) == graph.inside(first))) group.push_back(v);
      if (step % 2) group = {first};
      std::vector<Voxel> voxels;
      for (const std::uint32_t v : group) voxels.push_back(graph.voxel(v));
      const Betti promised = graph.after(group);
      shape = with_flipped(shape, voxels);
      shape.validate();
      ASSERT_EQ(promised, topology(shape).betti) << seed;
      graph.flip(group);
      ASSERT_EQ(graph.betti(), promised) << seed;
      for (const std::uint32_t v : group)
        ASSERT_EQ(graph.inside(v), shape.contains(graph.voxel(v)[0], graph.voxel(v)[1], graph.voxel(v)[2]));
    }
  }
}

}  // namespace simple_voxel_test
}  // namespace quench::voxelization
