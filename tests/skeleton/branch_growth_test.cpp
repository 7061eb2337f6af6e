// SPDX-License-Identifier: Apache-2.0
// By how much a ball has to grow to contain a branch: against all pairs on random trees, and known curves.
#include "skeleton/branch_growth.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

namespace quench {
namespace branch_growth_test {

using skeleton::growth_to_contain;
using skeleton::StepInwards;

TEST(BranchGrowth, IsThatOfAllPairs) {
  std::mt19937_64 random(5);
  const auto below = [&](std::uint64_t n) { return static_cast<std::uint32_t>(random() % n); };
  for (int round = 0; round < 2000 && !testing::Test::HasFailure(); ++round) {
    // A forest whose roots make no steps; coordinates and times often equal.
    const std::uint32_t n = 1 + below(60);
    const std::uint32_t values = round % 2 ? 3 : 1000;
    std::vector<Vec3> points(n);
    std::vector<double> times(n);
    std::vector<std::uint32_t> to(n), name(n);
    for (std::uint32_t v = 0; v < n; ++v) {
      points[v] = {static_cast<double>(below(values)), static_cast<double>(below(values)),
                   static_cast<double>(below(values))};
      times[v] = static_cast<double>(below(values));
      name[v] = v;
    }
    std::shuffle(name.begin(), name.end(), random);
    std::vector<StepInwards> steps;
    for (std::uint32_t v = 0; v < n; ++v) {
      to[name[v]] = v + 1 < n && below(10) > 0 ? name[v + 1 + below(std::min(n - v - 1, 4u))] : name[v];
      if (to[name[v]] != name[v]) steps.push_back({name[v], to[name[v]]});
    }
    const std::vector<double> growth = growth_to_contain(steps, points, times);
    ASSERT_EQ(growth.size(), steps.size());
    std::vector<double> radius(times);
    for (const StepInwards& step : steps)
      for (std::uint32_t x = step.vertex; to[x] != x; x = to[x])
        radius[x] = std::max(radius[x], (points[x] - points[step.vertex]).norm() + times[step.vertex]);
    for (std::size_t s = 0; s < steps.size(); ++s)
      ASSERT_NEAR(growth[s], radius[steps[s].vertex] - times[steps[s].vertex], 1e-9) << "round " << round;
  }
}

// Along a straight tube of a ball of radius 1 it is the length; on a coil of two turns no more than that is wide.
TEST(BranchGrowth, CountsWhereABranchReachesAndNotHowLongItIs) {
  constexpr std::uint32_t kCount = 400;
  std::vector<Vec3> straight, coil;
  std::vector<StepInwards> steps;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    const double t = static_cast<double>(i) / (kCount - 1);
    straight.push_back({20 * t, 0, 0});
    coil.push_back({5 * std::cos(4 * std::numbers::pi * t), 5 * std::sin(4 * std::numbers::pi * t), t});
    if (i + 1 < kCount) steps.push_back({i, i + 1});
  }
  const std::vector<double> times(kCount, 1);
  EXPECT_NEAR(growth_to_contain(steps, straight, times).back(), 20, 0.1);
  const std::vector<double> growth = growth_to_contain(steps, coil, times);
  EXPECT_LE(*std::ranges::max_element(growth), std::hypot(10, 1));
  EXPECT_GE(growth.back(), 9.9);
  EXPECT_TRUE(growth_to_contain({}, straight, times).empty());
}

}  // namespace branch_growth_test
}  // namespace quench
