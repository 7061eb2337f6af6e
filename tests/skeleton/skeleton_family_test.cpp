// SPDX-License-Identifier: Apache-2.0
// What follows a burning, against slower ways to the same result: thinning of the whole complex, fire in the order of a
// queue, families without floor; and one thread against several.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <functional>
#include <optional>
#include <queue>
#include <random>

#include "base/cofaces.h"
#include "burning/curve_fire.h"
#include "complex/thinning.h"
#include "full_run.h"
#include "quench/samples.h"
#include "quench/shape.h"
#include "quench/skeleton.h"
#include "quench/voxelize.h"
#include "random_complexes.h"
#include "same_skeletons.h"
#include "skeleton/member.h"

namespace quench {
namespace skeleton_family_test {

using testing_skeletons::expect_same;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

RefinedAxis some_axis(std::uint64_t seed, Context* context = nullptr) {
  const testing_complexes::BurnInput input = testing_complexes::random_input(seed);
  const double omega = std::array{0.3, 0.45, 0.8, 1.7, 20.0}[seed / 2 % 5];
  const Burning burning = burn(input.complex, input.points, input.radius, {.omega = omega, .radius = input.rule});
  return quench_curves(input.complex, input.points, input.radius, burning, context);
}

std::vector<double> infinite_where(const std::vector<char>& flags) {
  std::vector<double> values;
  for (const char flag : flags) values.push_back(flag ? kInfinity : 0);
  return values;
}

TEST(SkeletonLevels, AreThoseOfThinningTheWholeComplex) {
  for (std::uint64_t seed = 0; seed < 3000 && !testing::Test::HasFailure(); ++seed) {
    SCOPED_TRACE(seed);
    const SkeletonFamily family = skeletons(some_axis(seed));
    const RefinedAxis& k = family.refined;
    const CellValues sheet = complex::thin(k.complex, infinite_where(k.curve_vertex), infinite_where(k.curve_edge),
                                           k.face_thickness, nullptr, "");
    ASSERT_EQ(family.face_sheet_level, sheet.face);
    ASSERT_EQ(family.edge_sheet_level, sheet.edge);
    ASSERT_EQ(family.vertex_sheet_level, sheet.vertex);

    CellComplex curves;
    curves.vertex_count = k.complex.vertex_count;
    std::vector<double> thickness;
    std::vector<std::uint32_t> edge_of;
    for (std::uint32_t e = 2 * k.doors; e < k.complex.edges.size(); ++e)
      if (k.curve_edge[e]) {
        curves.edges.push_back(k.complex.edges[e]);
        thickness.push_back(family.thickness_of(e));
        edge_of.push_back(e);
      }
    std::vector<char> fixed = k.medial_point;
    for (std::size_t f = 0; f < k.complex.face_count(); ++f)
      if (k.face_thickness[f] == kInfinity)
        for (const std::uint32_t v : k.complex.corners(f)) fixed[v] = 1;
    const CellValues curve = complex::thin(curves, infinite_where(fixed), thickness, {}, nullptr, "");
    for (std::size_t i = 0; i < edge_of.size(); ++i) ASSERT_EQ(family.level_of(edge_of[i]), curve.edge[i]);
  }
}

// The definition: the vertex that burns first, the smaller of two at a time, goes first.
burning::CurveFire fire_in_order(const std::vector<std::array<std::uint32_t, 2>>& edges,
                                 const std::vector<double>& start, const std::vector<double>& length) {
  burning::CurveFire fire;
  fire.time.assign(start.size(), kInfinity);
  fire.exit.assign(start.size(), kNone);
  fire.last.assign(start.size(), 0);
  std::vector<base::Cofaces> left(start.size());
  for (std::uint32_t e = 0; e < edges.size(); ++e)
    for (const std::uint32_t v : edges[e]) left[v].add(e);
  std::vector<double> arrival = start;
  using Label = std::pair<double, std::uint32_t>;
  std::priority_queue<Label, std::vector<Label>, std::greater<>> queue;
  const auto push = [&](std::uint32_t v) {
    if (start[v] < kInfinity) queue.push({arrival[v], v});
  };
  for (std::uint32_t v = 0; v < start.size(); ++v)
    if (left[v].none() || left[v].single()) push(v);
  while (!queue.empty()) {
    const auto [t, v] = queue.top();
    queue.pop();
    fire.time[v] = t;
    fire.last[v] = left[v].none();
    if (fire.last[v]) continue;
    const std::uint32_t e = left[v].only(), other = edges[e][0] == v ? edges[e][1] : edges[e][0];
    fire.exit[v] = e;
    left[v].remove(e);
    left[other].remove(e);
    if (left[other].none()) continue;
    arrival[other] = std::max(arrival[other], t + length[e]);
    if (left[other].single()) push(other);
  }
  return fire;
}

TEST(CurveFire, BurnsAsInTheOrderOfTime) {
  std::mt19937_64 random(7);
  const auto below = [&](std::uint64_t n) { return static_cast<std::uint32_t>(random() % n); };
  for (int round = 0; round < 50'000 && !testing::Test::HasFailure(); ++round) {
    // Forests with a few edges more; in two of three rounds many times and lengths are equal, and lengths zero.
    const std::uint32_t n = 2 + below(14);
    const bool ties = round % 3 != 0;
    std::vector<double> start(n), length;
    for (double& time : start)
      time = below(20) == 0 ? kInfinity : ties ? below(3) : static_cast<double>(below(1000)) / 100;
    std::vector<std::uint32_t> name(n);
    for (std::uint32_t v = 0; v < n; ++v) name[v] = v;
    std::shuffle(name.begin(), name.end(), random);
    std::vector<std::array<std::uint32_t, 2>> edges;
    for (std::uint32_t v = 1; v < n; ++v)
      if (below(8) > 0) edges.push_back({name[below(v)], name[v]});
    for (std::uint32_t more = below(4) == 0 ? below(3) : 0; more > 0; --more) edges.push_back({below(n), below(n)});
    std::shuffle(edges.begin(), edges.end(), random);
    for (auto& e : edges) std::sort(e.begin(), e.end());
    for (std::size_t e = 0; e < edges.size(); ++e)
      length.push_back(ties ? below(2) : static_cast<double>(below(100)) / 100);
    const burning::CurveFire expected = fire_in_order(edges, start, length);
    const burning::CurveFire found =
        burning::burn_curves(edges, std::vector<char>(edges.size(), 1), std::vector<char>(n, 1), start, length);
    ASSERT_EQ(found.time, expected.time) << "round " << round;
    ASSERT_EQ(found.exit, expected.exit) << "round " << round;
    ASSERT_EQ(found.last, expected.last) << "round " << round;
  }
}

TEST(SkeletonFloor, MembersAboveItStayAsTheyAre) {
  std::size_t smaller = 0;
  for (std::uint64_t seed = 0; seed < 1000 && !testing::Test::HasFailure(); ++seed) {
    SCOPED_TRACE(seed);
    const SkeletonFamily all = skeletons(some_axis(seed));
    const double theta2 = std::array{0.0, 0.1, 0.3, 0.8, kInfinity}[seed % 5];
    const double theta1 = std::array{0.0, 0.2, 0.5, kInfinity}[seed / 5 % 4];
    // Raised in two steps, as a floor upon a floor.
    const SkeletonFamily above = with_floor(with_floor(all, 0.5 * theta2, 0.5 * theta1), theta2, theta1);
    smaller += above.refined.complex.face_count() < all.refined.complex.face_count();
    constexpr std::array kMore2{0.0, 0.2, 1.0, kInfinity};
    for (std::size_t i = 0; i < kMore2.size(); ++i)
      for (const double more1 : {0.0, 0.3, kInfinity})
        for (const bool parts : {false, true})
          for (const auto& [ends, radii] : {std::pair{0.1, 0.0}, {0.1, 0.4}, {kInfinity, 0.0}, {kInfinity, 1.0}}) {
            const double more2 = kMore2[i];
            if (!full_run() && i != seed / 20 % kMore2.size()) continue;
            SCOPED_TRACE(testing::Message() << more2 << " " << more1 << " above " << theta2 << " " << theta1
                                            << " parts " << parts << " ends " << ends << " radii " << radii);
            const ExtractOptions options{.parts = parts,
                                         .regrow_tips_above = theta1 + ends,
                                         .regrow_rims_above = theta2 + ends,
                                         .minor_curve = 0.2,
                                         .theta1_radii = radii,
                                         .balls_above = theta1 + ends};
            expect_same(extract(above, theta2 + more2, theta1 + more1, options),
                        extract(all, theta2 + more2, theta1 + more1, options));
          }
    if (theta2 > 0) {
      EXPECT_THROW(extract(above, 0, kInfinity), Error);
    }
    if (theta1 > 0) {
      EXPECT_THROW(extract(above, kInfinity, 0), Error);
    }
  }
  EXPECT_GT(smaller, 500u);
}

TEST(SkeletonRadii, MembersAreNestedAndKeepTopology) {
  std::size_t smaller = 0;
  for (std::uint64_t seed = 0; seed < 500 && !testing::Test::HasFailure(); ++seed) {
    SCOPED_TRACE(seed);
    const SkeletonFamily family = skeletons(some_axis(seed));
    for (const double theta2 : {0.3, kInfinity}) {
      std::vector<char> before;
      std::optional<Topology> wanted;
      for (const double radii : {0.0, 0.2, 0.5, 1.0, 3.0}) {
        const skeleton::Member member = skeleton::member_of(family, theta2, 0.05, {.theta1_radii = radii});
        for (std::size_t e = 0; e < before.size(); ++e) ASSERT_LE(member.edge[e], before[e]);
        if (!before.empty()) smaller += member.edge != before;
        before = member.edge;
        const Topology now = topology(extract(family, theta2, 0.05, {.theta1_radii = radii}).complex);
        if (!wanted) wanted = now;
        ASSERT_EQ(now, *wanted);
        ASSERT_EQ(topology(extract(family, theta2, 0.05, {.regrow_tips_above = 0.05, .theta1_radii = radii}).complex),
                  *wanted);
      }
    }
  }
  EXPECT_GT(smaller, 200u);
}

TEST(SkeletonThreads, ResultsAreTheSame) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 3);
  Context one, three;
  one.threads = 1;
  three.threads = 3;
  for (std::uint64_t seed = 0; seed < 300 && !testing::Test::HasFailure(); ++seed) {
    SCOPED_TRACE(seed);
    expect_same(skeletons(some_axis(seed, &one), &one), skeletons(some_axis(seed, &three), &three));
  }
}

// Large enough for work that is shared: parts in many chunks, whose curves are burned in zones.
TEST(SkeletonThreads, ResultsOfALargeAxisAreTheSame) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 4);
  for (const char* sample : {"bumpy-sphere", "hollow-sphere", "plate-with-holes"}) {
    SCOPED_TRACE(sample);
    const MedialAxis axis = medial_axis(voxelize(make_sample(sample).mesh, {.resolution = 48}).shape, 0);
    const Burning burning = burn(axis);
    Context one;
    one.threads = 1;
    const SkeletonFamily wanted = skeletons(axis, burning, &one);
    for (const int threads : {2, 4}) {
      Context several;
      several.threads = threads;
      const SkeletonFamily family = skeletons(axis, burning, &several);
      expect_same(family, wanted);
      expect_same(with_floor(family, 1, 1, &several), with_floor(wanted, 1, 1, &one));
    }
  }
}

}  // namespace skeleton_family_test
}  // namespace quench
