// SPDX-License-Identifier: Apache-2.0
// The oracle of the burn's tests against closed forms: by nodes, so from above, and near for a small spacing.
#include "brute_force_burn.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "burn_shapes.h"

namespace quench {
namespace brute_force_burn_test {

using namespace testing_complexes;
using testing_burn::BruteForceBurn;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

BruteForceBurn oracle(const BurnInput& input, double omega) {
  return {input.complex, input.points, input.radius, testing_burn::pieces_for(input.complex, input.points, omega),
          input.rule};
}

// Never below the truth; `mean` and `largest` are what was measured, rounded up.
void expect_near(const KnownBurn& known, double omega, double mean, double largest, const char* name) {
  const BruteForceBurn found = oracle(known.input, omega);
  double sum = 0, worst = 0;
  std::size_t count = 0;
  for (std::size_t v = 0; v < known.truth.size(); ++v) {
    if (std::isnan(known.truth[v])) continue;
    const double error = found.vertex_time[v] - known.truth[v];
    EXPECT_GT(error, -1e-5) << name << " vertex " << v << " at " << known.input.points[v].transpose();
    sum += error;
    worst = std::max(worst, error);
    ++count;
  }
  ASSERT_GT(count, 0u);
  EXPECT_LT(sum / static_cast<double>(count), mean) << name;
  EXPECT_LT(worst, largest) << name;
}

TEST(BruteForceBurn, IsNearTheClosedForms) {
  expect_near(square_sheet(), 0.5, 0.05, 0.2, "square");
  expect_near(square_under_site(), 0.5, 0.05, 0.2, "square under a site");
  expect_near(l_sheet(), 0.5, 0.1, 0.3, "L");
  expect_near(cone(5, 4, -3, -3, 3), 0.5, 0.1, 0.3, "cone");
  expect_near(cone(6, 4, 2, -2, 3), 0.5, 0.1, 0.3, "saddle cone");
  expect_near(three_sheets(), 0.5, 0.1, 0.3, "three sheets");
  expect_near(box_axis(12, 9, 6, 5), 0.5, 0.1, 0.3, "box");
  expect_near(chimney(), 0.5, 0.1, 0.4, "chimney");
  expect_near(tetrahedral_junction(10, 4), 0.5, 0.1, 0.2, "junction");
}

// The tip burns when the fire of both fans has reached it: one loop of its link does not open the other.
TEST(BruteForceBurn, PinchPointWaitsForBothFans) {
  Builder b;
  pyramid(b, {0, 0, 0}, 3, 4, 5);
  pyramid(b, {0, 0, 0}, -1, 2, 4);
  const BurnInput input = b.input([](const Vec3&) { return 1.0; });
  const BruteForceBurn found = oracle(input, 0.05);
  const std::uint32_t tip = b.vertex({0, 0, 0});
  ASSERT_EQ(found.links[tip].size(), 2u);
  EXPECT_EQ(found.links[tip].loops, 2);
  EXPECT_NEAR(found.vertex_time[tip], 1 + pyramid_height(3, 4, 5), 1e-3);
  const std::size_t s = found.nodes[tip].first_state;
  EXPECT_NEAR(std::min(found.time[s], found.time[s + 1]), 1 + pyramid_height(-1, 2, 4), 1e-3);
}

TEST(BruteForceBurn, PocketsNeverBurnAndTheirFlapsDo) {
  Builder b;
  std::vector<std::uint32_t> v;
  for (int i = 0; i < 6; ++i) v.push_back(b.vertex((i % 2 ? 3.0 : -3.0) * Vec3::Unit(i / 2)));
  for (int i = 0; i < 8; ++i) b.face({v[i & 1], v[2 + (i >> 1 & 1)], v[4 + (i >> 2)]});
  const std::uint32_t outer = b.vertex({5, 5, 0});
  b.face({v[1], v[3], outer});
  const BruteForceBurn found = oracle(b.input([](const Vec3&) { return 1.0; }), 0.5);
  for (std::uint32_t i : v) EXPECT_EQ(found.vertex_time[i], kInfinity);
  EXPECT_EQ(found.vertex_time[outer], 1);
  EXPECT_EQ(found.pocket, (std::vector<char>{1, 1, 1, 1, 1, 1, 1, 1, 0}));
  // On the flap's glued side its sector is a loop, and burns when the fire arrives.
  for (std::size_t n = 6; n < found.nodes.size(); ++n) {
    const auto& link = found.links[found.nodes[n].link];
    for (std::size_t s = 0; s < link.size(); ++s) {
      EXPECT_EQ(found.time[found.nodes[n].first_state + s] < kInfinity, !link.pocket[s]);
    }
  }
}

TEST(BruteForceBurn, SectorTimesOfLinks) {
  const std::vector<std::array<int, 2>> k4{{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};
  const testing_burn::LinkSectors junction({k4, std::vector<char>(6, 0)});
  EXPECT_EQ(junction.loops, 3);
  // A maximum spanning tree of the arrivals 1 to 6 is 6, 5, 3, so the node burns at 4, the largest outside. After 1 and
  // 2 are removed, the third sector is the only one at direction 0.
  std::vector<double> time(6);
  junction.times(0.5, std::vector<double>{1, 2, 3, 4, 5, 6}, time);
  EXPECT_EQ(time, (std::vector<double>{1, 2, 2, 4, 4, 4}));
  // Two loops joined by a bridge: it burns when one of them opens, or by its own fire.
  const testing_burn::LinkSectors dumbbell({{{0, 0}, {0, 1}, {1, 1}}, {0, 0, 0}});
  std::vector<double> three(3);
  dumbbell.times(0, std::vector<double>{4, 7, 5}, three);
  EXPECT_EQ(three, (std::vector<double>{4, 4, 5}));
  dumbbell.times(0, std::vector<double>{4, 3, 5}, three);
  EXPECT_EQ(three, (std::vector<double>{4, 3, 5}));
  // A pocket on two directions of a triangle: the third sector is a loop on it, the hanging one is open.
  const testing_burn::LinkSectors pocket({{{0, 1}, {0, 1}, {0, 2}, {2, 1}, {2, 3}}, {1, 1, 0, 0, 0}});
  EXPECT_EQ(pocket.loops, 1);
  EXPECT_EQ(pocket.size(), 5u);
}

}  // namespace brute_force_burn_test
}  // namespace quench
