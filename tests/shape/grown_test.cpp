// SPDX-License-Identifier: Apache-2.0
// Hysteresis, closing and joining against naive code on random images.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>
#include <set>

#include "base/union_find.h"
#include "quench/error.h"
#include "quench/shape.h"
#include "random_shapes.h"

namespace quench {
namespace grown_test {

using Voxels = std::vector<bool>;

struct Dense {
  Grid grid;
  Voxels voxels;

  explicit Dense(const VoxelShape& shape) : grid(shape.grid()) {
    for (std::int64_t z = 0; z < grid.dims[2]; ++z)
      for (std::int64_t y = 0; y < grid.dims[1]; ++y)
        for (std::int64_t x = 0; x < grid.dims[0]; ++x) voxels.push_back(shape.contains(x, y, z));
  }
  std::size_t at(std::int64_t x, std::int64_t y, std::int64_t z) const {
    return static_cast<std::size_t>(x + grid.dims[0] * (y + grid.dims[1] * z));
  }
  bool has(std::int64_t x, std::int64_t y, std::int64_t z) const {
    return x >= 0 && y >= 0 && z >= 0 && x < grid.dims[0] && y < grid.dims[1] && z < grid.dims[2] &&
           voxels[at(x, y, z)];
  }
  /// Neighbours whose coordinates differ by 1 at most, in so many axes at most.
  base::UnionFind components(int axes) const {
    base::UnionFind sets(voxels.size());
    for_all([&](std::int64_t x, std::int64_t y, std::int64_t z) {
      for (int n = 0; n < 27; ++n) {
        const int dx = n % 3 - 1, dy = n / 3 % 3 - 1, dz = n / 9 - 1;
        if (std::abs(dx) + std::abs(dy) + std::abs(dz) <= axes && has(x, y, z) && has(x + dx, y + dy, z + dz))
          sets.unite(static_cast<std::uint32_t>(at(x, y, z)), static_cast<std::uint32_t>(at(x + dx, y + dy, z + dz)));
      }
    });
    return sets;
  }
  std::int64_t count(int axes) const {
    base::UnionFind sets = components(axes);
    std::int64_t found = 0;
    for (std::uint32_t i = 0; i < voxels.size(); ++i) found += voxels[i] && sets.find(i) == i;
    return found;
  }
  template <class Visit>
  void for_all(const Visit& visit) const {
    for (std::int64_t z = 0; z < grid.dims[2]; ++z)
      for (std::int64_t y = 0; y < grid.dims[1]; ++y)
        for (std::int64_t x = 0; x < grid.dims[0]; ++x) visit(x, y, z);
  }
};

Volume random_volume(unsigned seed) {
  std::mt19937 random(seed);
  Volume volume;
  for (auto& d : volume.grid.dims) d = 2 + static_cast<std::int64_t>(random() % 10);
  if (seed % 5 == 0) {
    volume.grid.dims[2] = 1;
    volume.grid.make_plane();
  }
  std::vector<std::int16_t> samples;
  const auto rare = 2 + random() % 6;
  for (std::int64_t i = 0; i < volume.grid.dims[0] * volume.grid.dims[1] * volume.grid.dims[2]; ++i)
    samples.push_back(static_cast<std::int16_t>(random() % rare == 0 ? 50 + random() % 100 : random() % 50));
  samples[0] = 149;
  volume.samples = std::move(samples);
  return volume;
}

/// A stream of the slices of a volume of int16.
SliceStream stream_of(const Volume& volume) {
  SliceStream stream;
  stream.grid = volume.grid;
  stream.type = SampleType::int16;
  stream.next = [&volume, at = std::size_t{0}](std::span<std::byte> slice) mutable {
    std::memcpy(slice.data(), std::get<std::vector<std::int16_t>>(volume.samples).data() + at, slice.size());
    at += slice.size() / 2;
  };
  return stream;
}

bool same(const VoxelShape& a, const VoxelShape& b) {
  return a.grid().dims == b.grid().dims && std::ranges::equal(a.runs(), b.runs()) && Dense(a).voxels == Dense(b).voxels;
}

ForegroundOptions at_least_50() {
  ForegroundOptions options;
  options.threshold = 50.0;
  return options;
}

TEST(Hysteresis, KeepsWhatIsConnectedToAStrongVoxel) {
  for (unsigned seed = 0; seed < 300; ++seed) {
    const Volume volume = random_volume(seed);
    const auto& samples = std::get<std::vector<std::int16_t>>(volume.samples);
    ForegroundOptions options = at_least_50();
    const Dense weak(foreground(volume, options));
    options.seed_threshold = 130.0;
    for (const int axes : {1, 3}) {
      options.connectivity = axes == 1 ? 6 : 26;
      ForegroundReport report;
      const VoxelShape shape = foreground(volume, options, &report);
      base::UnionFind sets = weak.components(axes);
      std::set<std::uint32_t> strong;
      for (std::uint32_t i = 0; i < samples.size(); ++i)
        if (samples[i] >= 130) strong.insert(sets.find(i));
      std::int64_t dropped = 0;
      const Dense found(shape);
      for (std::uint32_t i = 0; i < samples.size(); ++i) {
        const bool wanted = weak.voxels[i] && strong.contains(sets.find(i));
        dropped += weak.voxels[i] && !wanted;
        // Joined: there are more.
        EXPECT_TRUE(found.voxels[i] == wanted || (axes == 3 && found.voxels[i] && !weak.voxels[i])) << seed;
      }
      EXPECT_EQ(report.weak_dropped, dropped);
      EXPECT_TRUE(same(shape, foreground(stream_of(volume), options))) << seed;
    }
  }
}

TEST(Closing, IsTheErosionOfTheDilation) {
  for (unsigned seed = 0; seed < 120; ++seed) {
    Volume volume = random_volume(seed);
    if (seed % 3 == 0) volume.grid.spacing = {1, 2, 1.5};
    if (volume.grid.is_plane()) volume.grid.make_plane();
    ForegroundOptions options = at_least_50();
    const Dense before(foreground(volume, options));
    options.close = 1 + static_cast<int>(seed % 3);
    ForegroundReport report;
    const VoxelShape shape = foreground(volume, options, &report);
    const Vec3 step = volume.grid.spacing / volume.grid.spacing.minCoeff();
    const int reach = options.close;
    std::vector<std::array<int, 3>> ball;
    for (int z = -reach; z <= reach; ++z)
      for (int y = -reach; y <= reach; ++y)
        for (int x = -reach; x <= reach; ++x)
          if ((!volume.grid.is_plane() || z == 0) &&
              Vec3(x, y, z).cwiseProduct(step).squaredNorm() <= reach * reach + 1e-9)
            ball.push_back({x, y, z});
    const auto dilated = [&](std::int64_t x, std::int64_t y, std::int64_t z) {
      return std::ranges::any_of(ball, [&](const auto& b) { return before.has(x + b[0], y + b[1], z + b[2]); });
    };
    std::int64_t added = 0;
    before.for_all([&](std::int64_t x, std::int64_t y, std::int64_t z) {
      const bool wanted =
          std::ranges::all_of(ball, [&](const auto& b) { return dilated(x + b[0], y + b[1], z + b[2]); });
      EXPECT_EQ(shape.contains(x, y, z), wanted) << seed;
      added += wanted && !before.has(x, y, z);
    });
    EXPECT_EQ(report.voxels_closed, added);
    EXPECT_TRUE(same(shape, foreground(stream_of(volume), options))) << seed;
  }
}

TEST(Connectivity, MakesComponentsOfEdgesAndCornersComponentsOfFaces) {
  std::int64_t less = 0, cases = 0, loops = 0, voxels = 0;
  for (unsigned seed = 0; seed < 1500; ++seed) {
    const Volume volume = random_volume(seed);
    ForegroundOptions options = at_least_50();
    const VoxelShape plain = foreground(volume, options);
    options.connectivity = 26;
    ForegroundReport report;
    const VoxelShape shape = foreground(volume, options, &report);
    const Dense before(plain), after(shape);
    for (std::size_t i = 0; i < before.voxels.size(); ++i) ASSERT_TRUE(after.voxels[i] || !before.voxels[i]) << seed;
    EXPECT_EQ(report.voxels_joined, shape.voxel_count() - plain.voxel_count());
    EXPECT_EQ(report.components_joined, before.count(1) - after.count(1)) << seed;
    // What touches is joined.
    base::UnionFind touching = before.components(3), joined = after.components(1);
    for (std::uint32_t i = 0; i < before.voxels.size(); ++i)
      ASSERT_TRUE(!before.voxels[i] || joined.find(i) == joined.find(touching.find(i))) << seed;
    EXPECT_LE(after.count(1), before.count(3));
    less += before.count(3) - after.count(1);
    ++cases;
    // At most two voxels for each component that went.
    EXPECT_LE(report.voxels_joined, 2 * report.components_joined);
    voxels += 2 * report.components_joined - report.voxels_joined;
    loops += topology(shape).betti[1] - topology(plain).betti[1];
    EXPECT_TRUE(same(shape, foreground(stream_of(volume), options))) << seed;
  }
  RecordProperty("less", static_cast<int>(less));
  EXPECT_LT(less, cases / 5);  // rare, and only in noise
  EXPECT_GT(voxels, 0);
  RecordProperty("loops", static_cast<int>(loops));
}

Volume of_voxels(std::array<std::int64_t, 3> dims, const std::vector<std::array<std::int64_t, 3>>& voxels) {
  Volume volume;
  volume.grid.dims = dims;
  std::vector<std::int16_t> samples(static_cast<std::size_t>(dims[0] * dims[1] * dims[2]), 0);
  for (const auto& v : voxels) samples[static_cast<std::size_t>(v[0] + dims[0] * (v[1] + dims[1] * v[2]))] = 100;
  volume.samples = std::move(samples);
  return volume;
}

std::int64_t voxels_joined(const Volume& volume) {
  ForegroundOptions options = at_least_50();
  options.connectivity = 26;
  ForegroundReport report;
  const VoxelShape shape = foreground(volume, options, &report);
  EXPECT_EQ(topology(shape).betti, (std::array<std::int64_t, 3>{1, 0, 0}));
  return report.voxels_joined;
}

TEST(Connectivity, TakesTheFewestVoxels) {
  EXPECT_EQ(voxels_joined(of_voxels({2, 2, 1}, {{0, 0, 0}, {1, 1, 0}})), 1);
  EXPECT_EQ(voxels_joined(of_voxels({2, 2, 2}, {{0, 0, 0}, {1, 1, 1}})), 2);
  // One in the middle of three for three.
  EXPECT_EQ(voxels_joined(of_voxels({3, 3, 3}, {{0, 1, 1}, {1, 0, 1}, {1, 1, 0}})), 1);
  EXPECT_EQ(voxels_joined(of_voxels({3, 3, 3}, {{0, 1, 1}, {1, 0, 1}, {1, 1, 0}, {2, 1, 1}, {1, 2, 1}, {1, 1, 2}})), 1);
  // A chain of edges.
  EXPECT_EQ(voxels_joined(of_voxels({4, 4, 1}, {{0, 0, 0}, {1, 1, 0}, {2, 2, 0}, {3, 3, 0}})), 3);
}

TEST(Connectivity, PrefersTheBrighterVoxel) {
  for (const std::size_t bright : {1u, 2u}) {
    Volume volume = of_voxels({2, 2, 1}, {{0, 0, 0}, {1, 1, 0}});
    std::get<std::vector<std::int16_t>>(volume.samples)[bright] = 40;
    ForegroundOptions options = at_least_50();
    options.connectivity = 26;
    const VoxelShape shape = foreground(volume, options);
    EXPECT_TRUE(shape.contains(bright == 1 ? 1 : 0, bright == 1 ? 0 : 1, 0));
  }
}

TEST(Connectivity, MakesNoLoopWhereItNeedNot) {
  // A bent bar and a voxel at its inner corner's edge: one of two voxels would close a loop.
  const Volume volume = of_voxels({4, 3, 2}, {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 0, 1}, {3, 1, 1}, {3, 2, 1}});
  EXPECT_EQ(voxels_joined(volume), 1);
}

TEST(Foreground, RefusesWhatMakesNoSense) {
  const Volume volume = random_volume(3);
  const auto field = [&](const ForegroundOptions& options) {
    try {
      foreground(volume, options);
    } catch (const Error& error) {
      return error.field();
    }
    return std::string("none");
  };
  ForegroundOptions options = at_least_50();
  options.seed_threshold = 49.0;
  EXPECT_EQ(field(options), "threshold");
  options.seed_threshold = 1e9;
  EXPECT_EQ(field(options), "threshold");
  options.seed_threshold = 60.0;
  options.invert = true;
  EXPECT_EQ(field(options), "invert");
  options = at_least_50();
  options.connectivity = 18;
  EXPECT_EQ(field(options), "connectivity");
  options = at_least_50();
  options.close = -1;
  EXPECT_EQ(field(options), "close");
  options.close = kLargestClosing + 1;
  EXPECT_EQ(field(options), "close");
}

}  // namespace grown_test
}  // namespace quench
