// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>

#include "quench/error.h"
#include "quench/samples.h"

namespace quench {
namespace sample_test {

// What holds for a closed surface, from its triangles alone.
struct Surface {
  int components = 0;
  int euler = 0;
  double volume = 0;
  double smallest_volume = std::numeric_limits<double>::infinity();  // of a component
  bool closed = true;                                                // every directed edge once, and its opposite once

  explicit Surface(const TriangleMesh& mesh, bool weld = true) {
    // Equal positions are one vertex.
    std::vector<std::uint32_t> vertex(mesh.points.size());
    std::iota(vertex.begin(), vertex.end(), 0u);
    if (weld) {
      std::vector<std::uint32_t> order = vertex;
      const auto less = [&](std::uint32_t i, std::uint32_t j) {
        return std::lexicographical_compare(mesh.points[i].begin(), mesh.points[i].end(), mesh.points[j].begin(),
                                            mesh.points[j].end());
      };
      std::sort(order.begin(), order.end(), less);
      for (std::size_t k = 1; k < order.size(); ++k)
        if (!less(order[k - 1], order[k])) vertex[order[k]] = vertex[order[k - 1]];
    }
    std::vector<std::uint32_t> set(mesh.points.size());
    std::iota(set.begin(), set.end(), 0u);
    const auto find = [&](std::uint32_t i) {
      while (set[i] != i) i = set[i] = set[set[i]];
      return i;
    };
    std::vector<std::uint64_t> edges, opposites;
    std::vector<char> used(mesh.points.size(), 0);
    for (const auto& t : mesh.triangles)
      for (std::size_t e = 0; e < 3; ++e) {
        const std::uint64_t v = vertex[t[e]], w = vertex[t[(e + 1) % 3]];
        if (v == w) closed = false;
        edges.push_back(v << 32 | w);
        opposites.push_back(w << 32 | v);
        set[find(static_cast<std::uint32_t>(v))] = find(static_cast<std::uint32_t>(w));
        used[v] = 1;
      }
    std::sort(edges.begin(), edges.end());
    std::sort(opposites.begin(), opposites.end());
    if (edges != opposites || std::adjacent_find(edges.begin(), edges.end()) != edges.end()) closed = false;
    std::map<std::uint32_t, double> volumes;
    for (const auto& t : mesh.triangles)
      volumes[find(vertex[t[0]])] += mesh.points[t[0]].dot(mesh.points[t[1]].cross(mesh.points[t[2]])) / 6;
    for (const auto& [component, v] : volumes) {
      volume += v;
      smallest_volume = std::min(smallest_volume, v);
    }
    components = static_cast<int>(volumes.size());
    euler = static_cast<int>(std::count(used.begin(), used.end(), 1)) - static_cast<int>(edges.size() / 2) +
            static_cast<int>(mesh.triangles.size());
  }
};

TEST(Sample, EveryShapeIsClosedAndOutward) {
  const std::map<std::string_view, std::array<int, 2>> expected{
      {"ellipsoid", {1, 2}},     {"torus", {1, 0}},
      {"box", {1, 2}},           {"rippled-box", {1, 2}},
      {"bumpy-sphere", {1, 2}},  {"fin-on-board", {1, 2}},
      {"four-blobs", {1, 2}},    {"plate-with-holes", {1, 2 - 2 * 6}},
      {"hollow-sphere", {2, 4}}, {"bead-pack", {1728, 2 * 1728}},
      {"rough-plate", {1, 2}},   {"bars", {3, 6}},
  };
  for (const SampleInfo& info : built_in_samples()) {
    if (info.name == "root") continue;
    ASSERT_TRUE(expected.contains(info.name)) << info.name;
    EXPECT_FALSE(info.description.empty());
    for (const double fineness : {0.1, 0.37, 1.0}) {
      SampleOptions options;
      options.fineness = fineness;
      const Sample sample = make_sample(info.name, options);
      const Surface surface(sample.mesh);
      EXPECT_TRUE(surface.closed) << info.name << fineness;
      EXPECT_EQ(surface.components, expected.at(info.name)[0]) << info.name << fineness;
      EXPECT_EQ(surface.euler, expected.at(info.name)[1]) << info.name << fineness;
      EXPECT_GT(surface.volume, info.name == "bars" ? 1e-3 : 0.05) << info.name << fineness;
      EXPECT_TRUE(sample.branches.empty());
    }
  }
}

TEST(Sample, VolumesOfKnownShapes) {
  const double pi = std::numbers::pi;
  EXPECT_NEAR(Surface(make_sample("ellipsoid").mesh).volume, 4 * pi / 3 * 0.28, 1e-3);
  EXPECT_NEAR(Surface(make_sample("torus").mesh).volume, 2 * pi * pi * 0.35 * 0.35, 1e-3);
  EXPECT_NEAR(Surface(make_sample("box").mesh).volume, 2.8, 1e-12);
  EXPECT_NEAR(Surface(make_sample("hollow-sphere").mesh).volume, 4 * pi / 3 * (1 - std::pow(0.55, 3)), 2e-3);
  EXPECT_NEAR(Surface(make_sample("plate-with-holes").mesh).volume, 0.1 * (2 * 4.0 / 3 - 6 * pi * 0.04), 1e-3);
}

TEST(Sample, VerticesLieOnTheSurface) {
  for (const Vec3& p : make_sample("ellipsoid").mesh.points)
    ASSERT_NEAR(p.cwiseQuotient(Vec3(1, 0.7, 0.4)).norm(), 1, 1e-14);
  for (const Vec3& p : make_sample("torus").mesh.points)
    ASSERT_NEAR(std::hypot(std::hypot(p[0], p[1]) - 1, p[2]), 0.35, 1e-14);
}

// Midpoints of the edges and centroids are the points farthest from the surface.
TEST(Sample, DefaultTessellationIsWithinATwentiethOfAVoxel) {
  const double voxel = 2.0 / 512, torus_voxel = 2.7 / 512;
  const auto check = [](const TriangleMesh& mesh, double limit, const auto& distance) {
    for (const auto& t : mesh.triangles) {
      const Vec3 &a = mesh.points[t[0]], &b = mesh.points[t[1]], &c = mesh.points[t[2]];
      for (const Vec3& p : {Vec3((a + b) / 2), Vec3((b + c) / 2), Vec3((c + a) / 2), Vec3((a + b + c) / 3)})
        ASSERT_LT(distance(p), limit);
    }
  };
  check(make_sample("ellipsoid").mesh, voxel / 20, [](const Vec3& p) {
    const Vec3 axes(1, 0.7, 0.4);
    const Vec3 q = p.cwiseQuotient(axes);
    return std::abs(q.squaredNorm() - 1) / (2 * q.cwiseQuotient(axes).norm());  // first order
  });
  check(make_sample("torus").mesh, torus_voxel / 20,
        [](const Vec3& p) { return std::abs(std::hypot(std::hypot(p[0], p[1]) - 1, p[2]) - 0.35); });
}

TEST(Sample, NoiseChangesWhatHasSome) {
  SampleOptions strong;
  strong.noise = 0.03;
  strong.fineness = 0.3;
  SampleOptions usual;
  usual.fineness = 0.3;
  for (const char* name : {"rippled-box", "bumpy-sphere"}) {
    const Sample rough = make_sample(name, strong);
    const Surface surface(rough.mesh);
    EXPECT_TRUE(surface.closed && surface.euler == 2) << name;
    EXPECT_NE(rough.mesh.points, make_sample(name, usual).mesh.points) << name;
  }
  EXPECT_EQ(make_sample("torus", strong).mesh.points, make_sample("torus", usual).mesh.points);
}

TEST(Sample, IsDeterministic) {
  for (const SampleInfo& info : built_in_samples()) {
    SampleOptions options;
    options.fineness = 0.3;
    const Sample a = make_sample(info.name, options), b = make_sample(info.name, options);
    EXPECT_EQ(a.mesh.points, b.mesh.points);
    EXPECT_EQ(a.mesh.triangles, b.mesh.triangles);
  }
}

TEST(Sample, RefusesWhatCannotBe) {
  const auto refused = [](std::string_view name, const SampleOptions& options) -> std::string {
    try {
      make_sample(name, options);
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::usage);
      return e.what();
    }
    ADD_FAILURE() << name << " was made";
    return {};
  };
  const std::string what = refused("teapot", {});
  for (const SampleInfo& info : built_in_samples()) EXPECT_NE(what.find(info.name), std::string::npos) << what;
  SampleOptions options;
  options.branches = 0;
  refused("root", options);
  options = {};
  options.fineness = 0;
  refused("box", options);
  options = {};
  options.noise = -1;
  refused("box", options);
  options = {};
  options.touching = -1;
  refused("root", options);
  options = {.branches = 3, .touching = 3};  // two laterals
  refused("root", options);
}

TEST(Root, HasTheBranchesAskedFor) {
  for (const int count : {1, 2, 3, 5, 60, 500}) {
    SampleOptions options;
    options.branches = count;
    const Sample sample = make_sample("root", options);
    ASSERT_EQ(sample.branches.size(), static_cast<std::size_t>(count));
    int second_order = 0;
    for (std::size_t i = 0; i < sample.branches.size(); ++i) {
      const RootBranch& branch = sample.branches[i];
      EXPECT_GT(branch.length(), 0.02);
      ASSERT_EQ(branch.points.size(), branch.radius.size());
      EXPECT_GT(*std::min_element(branch.radius.begin(), branch.radius.end()), 0.001);
      EXPECT_GE(branch.radius.front(), branch.radius.back());
      EXPECT_EQ(branch.parent < 0, i == 0);
      if (i == 0) continue;
      ASSERT_LT(static_cast<std::size_t>(branch.parent), i);
      const RootBranch& parent = sample.branches[static_cast<std::size_t>(branch.parent)];
      ASSERT_LT(static_cast<std::size_t>(branch.parent_point), parent.points.size());
      // It begins inside its parent.
      EXPECT_EQ(branch.points.front(), parent.points[static_cast<std::size_t>(branch.parent_point)]);
      EXPECT_LT(branch.radius.front(), parent.radius[static_cast<std::size_t>(branch.parent_point)]);
      second_order += branch.parent > 0;
    }
    EXPECT_EQ(second_order > 0, count > 2);
    EXPECT_LT(sample.branches[0].points.back()[2], -0.8);  // it grows down
    const Surface surface(sample.mesh, false);
    EXPECT_TRUE(surface.closed) << count;
    EXPECT_EQ(surface.components, count);
    EXPECT_EQ(surface.euler, 2 * count);
    EXPECT_GT(surface.smallest_volume, 0);
  }
}

// Where the radius is below the radius of curvature the tube does not fold over itself.
TEST(Root, TubesDoNotFold) {
  SampleOptions options;
  options.branches = 300;
  for (options.seed = 1; options.seed <= 5; ++options.seed)
    for (const RootBranch& branch : make_sample("root", options).branches)
      for (std::size_t i = 1; i + 1 < branch.points.size(); ++i) {
        const Vec3 before = branch.points[i] - branch.points[i - 1], after = branch.points[i + 1] - branch.points[i];
        const double turn = before.cross(after).norm() / (before.norm() * after.norm());
        EXPECT_LT(branch.radius[i] * turn, 0.9 * before.norm()) << options.seed;
      }
}

TEST(Root, ThinRoots) {
  const Sample root = make_sample("root", {.branches = 200, .thickness = 0.04});
  EXPECT_TRUE(root.damage.empty()) << "there is more room than for thick ones";
  double thinnest = 1, widest = 0;
  for (const RootBranch& branch : root.branches)
    for (const double radius : branch.radius) {
      thinnest = std::min(thinnest, radius);
      widest = std::max(widest, radius);
    }
  EXPECT_DOUBLE_EQ(widest, 0.04 * 0.034);
  EXPECT_GT(thinnest, 0.04 * 0.0025);
  EXPECT_LE(thinnest, 0.04 * 0.005);
  for (const double thickness : {0.0, 1.1, std::nan("")})
    EXPECT_THROW(make_sample("root", {.branches = 2, .thickness = thickness}), Error);
}

TEST(Root, AnotherSeedAnotherRoot) {
  SampleOptions other;
  other.seed = 2;
  EXPECT_NE(make_sample("root").branches[3].points, make_sample("root", other).branches[3].points);
}

// The space between two balls of branches, least over all their points.
double space_between(const RootBranch& a, const RootBranch& b, std::size_t a_first = 0, std::size_t b_first = 0) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = a_first; i < a.points.size(); ++i)
    for (std::size_t k = b_first; k < b.points.size(); ++k)
      least = std::min(least, (a.points[i] - b.points[k]).norm() - a.radius[i] - b.radius[k]);
  return least;
}

// The first point of a branch that is out of the ball of its parent that it grows from.
std::size_t out_of_parent(const Sample& root, std::size_t b) {
  const RootBranch& branch = root.branches[b];
  if (branch.parent < 0) return 0;
  const RootBranch& parent = root.branches[static_cast<std::size_t>(branch.parent)];
  const double radius = parent.radius[static_cast<std::size_t>(branch.parent_point)];
  std::size_t i = 0;
  while ((branch.points[i] - branch.points[0]).norm() < radius) ++i;
  return i;
}

bool parent_and_child(const Sample& root, std::size_t a, std::size_t b) {
  return root.branches[a].parent == static_cast<std::int32_t>(b) ||
         root.branches[b].parent == static_cast<std::int32_t>(a);
}

constexpr double kClearance = 0.012;

TEST(Root, BranchesKeepClear) {
  for (const std::uint64_t seed : {1, 2, 3, 4, 5}) {
    const Sample root = make_sample("root", {.seed = seed, .branches = 60, .fineness = 0.1});
    EXPECT_TRUE(root.damage.empty());
    for (std::size_t a = 0; a < root.branches.size(); ++a) {
      for (std::size_t b = 0; b < a; ++b) {
        if (parent_and_child(root, a, b)) continue;
        EXPECT_GE(space_between(root.branches[a], root.branches[b], out_of_parent(root, a), out_of_parent(root, b)),
                  kClearance)
            << seed << ' ' << a << ' ' << b;
      }
      if (a == 0) continue;
      // It leaves its parent once, and stands out by several radii.
      const RootBranch& branch = root.branches[a];
      const RootBranch& parent = root.branches[static_cast<std::size_t>(branch.parent)];
      std::size_t out = 0;
      while (space_between({.points = {branch.points[out]}, .radius = {branch.radius[out]}}, parent) <= kClearance)
        ASSERT_LT(++out, branch.points.size());
      EXPECT_GT(space_between(branch, parent, out), kClearance);
      EXPECT_GT((branch.points.back() - branch.points[out]).norm(), 5 * branch.radius[0]) << seed << ' ' << a;
      // Nothing grows farther than what its parent grew after it.
      double rest = 0;
      for (auto i = static_cast<std::size_t>(branch.parent_point); i + 1 < parent.points.size(); ++i)
        rest += (parent.points[i + 1] - parent.points[i]).norm();
      EXPECT_LT(branch.length(), rest);
    }
  }
}

TEST(Root, BranchesTouchWhereAsked) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Sample root = make_sample("root", {.seed = seed, .fineness = 0.1, .touching = 4});
    ASSERT_EQ(root.damage.size(), 4u);
    for (std::size_t a = 0; a < root.branches.size(); ++a)
      for (std::size_t b = 0; b < a; ++b) {
        if (parent_and_child(root, a, b)) continue;
        const auto asked = std::find_if(root.damage.begin(), root.damage.end(), [&](const RootDamage& d) {
          return std::minmax<std::size_t>(d.branch, d.other) == std::minmax(a, b);
        });
        const double space =
            space_between(root.branches[a], root.branches[b], out_of_parent(root, a), out_of_parent(root, b));
        EXPECT_EQ(space < kClearance, asked != root.damage.end()) << seed << ' ' << a << ' ' << b;
        if (asked == root.damage.end()) continue;
        EXPECT_TRUE(asked->on_purpose && asked->kind == RootDamage::Kind::touching);
        EXPECT_LT(space, 0);
        EXPECT_EQ(asked->from, root.branches[asked->branch].points[asked->from_point]);
        EXPECT_EQ(asked->to, root.branches[asked->other].points[asked->to_point]);
      }
  }
}

TEST(Root, WhatTouchesForWantOfRoomIsListed) {
  const Sample root = make_sample("root", {.branches = 500, .fineness = 0.1});
  EXPECT_FALSE(root.damage.empty());
  for (const RootDamage& d : root.damage) {
    EXPECT_FALSE(d.on_purpose);
    const RootBranch &a = root.branches[d.branch], &b = root.branches[d.other];
    EXPECT_LT((d.from - d.to).norm(), a.radius[d.from_point] + b.radius[d.to_point] + 0.004);
  }
}

std::vector<double> shares_of(const Sample& root, const GreyOptions& options, int threads = 1) {
  Context context;
  context.threads = threads;
  std::vector<double> shares;
  grey_slices(
      root, options,
      [&](std::span<const std::uint8_t> slice) {
        for (const std::uint8_t value : slice)
          shares.push_back((value - kGreyBackground) / static_cast<double>(kGreyObject - kGreyBackground));
      },
      &context);
  const Grid grid = grey_grid(root, options);
  EXPECT_EQ(shares.size(), static_cast<std::size_t>(grid.dims[0] * grid.dims[1] * grid.dims[2]));
  return shares;
}

double share_at(const std::vector<double>& shares, const Grid& grid, const Vec3& place) {
  const Vec3 p = grid.lattice(place);
  const auto x = static_cast<std::int64_t>(p[0]), y = static_cast<std::int64_t>(p[1]),
             z = static_cast<std::int64_t>(p[2]);
  return shares[static_cast<std::size_t>(x + grid.dims[0] * (y + grid.dims[1] * z))];
}

TEST(GreyRoot, VoxelsHaveTheShareThatIsInside) {
  const Sample root = make_sample("root", {.branches = 1});
  const double volume = Surface(root.mesh).volume;
  for (const double blur : {0.0, 1.0}) {
    const GreyOptions options{.resolution = 96, .blur = blur};
    const std::vector<double> shares = shares_of(root, options);
    const double voxel = std::pow(grey_grid(root, options).spacing[0], 3);
    EXPECT_NEAR(std::accumulate(shares.begin(), shares.end(), 0.0) * voxel, volume, 0.01 * volume) << blur;
    EXPECT_EQ(shares.front(), 0);
  }
}

TEST(GreyRoot, NoiseHasTheSizeAskedFor) {
  const Sample root = make_sample("root", {.branches = 1});
  const GreyOptions clean{.resolution = 64}, noisy{.resolution = 64, .noise = 0.1};
  const std::vector<double> a = shares_of(root, clean), b = shares_of(root, noisy);
  double sum = 0, squares = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    sum += b[i] - a[i];
    squares += (b[i] - a[i]) * (b[i] - a[i]);
  }
  const auto count = static_cast<double>(a.size());
  EXPECT_NEAR(sum / count, 0, 0.003);
  EXPECT_NEAR(std::sqrt(squares / count), 0.1, 0.002);
  EXPECT_NE(b, shares_of(root, {.resolution = 64, .noise = 0.1, .seed = 2}));
}

TEST(GreyRoot, BranchesAreInterrupted) {
  const Sample root = make_sample("root", {.gaps = 8});
  ASSERT_EQ(root.damage.size(), 8u);
  const GreyOptions options{.resolution = 200};
  const std::vector<double> shares = shares_of(root, options);
  const Grid grid = grey_grid(root, options);
  for (const RootDamage& d : root.damage) {
    EXPECT_EQ(d.kind, RootDamage::Kind::gap);
    EXPECT_EQ(d.branch, d.other);
    const RootBranch& branch = root.branches[d.branch];
    EXPECT_EQ(d.from, branch.points[d.from_point]);
    EXPECT_EQ(d.to, branch.points[d.to_point]);
    EXPECT_GT((d.to - d.from).norm(), 3 * branch.radius[d.from_point]);
    EXPECT_NEAR(share_at(shares, grid, branch.points[(d.from_point + d.to_point) / 2]), d.contrast, 0.01);
    EXPECT_GT(share_at(shares, grid, d.from), 0.5);
    EXPECT_GT(share_at(shares, grid, d.to), 0.5);
  }
}

TEST(GreyRoot, IsTheSameOnEveryNumberOfThreads) {
  const Sample root = make_sample("root", {.branches = 6});
  const GreyOptions options{.resolution = 48, .blur = 0.8, .noise = 0.1};
  EXPECT_EQ(shares_of(root, options, 1), shares_of(root, options, 3));
}

}  // namespace sample_test
}  // namespace quench
