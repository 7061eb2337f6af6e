// SPDX-License-Identifier: Apache-2.0
// The burn sequence of a file: right ones pass, and wrong ones do not, even with right fingerprints.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <random>
#include <set>
#include <string>

#include "burning/burn_sequence.h"
#include "full_run.h"
#include "quench/axis.h"
#include "quench/burn.h"
#include "quench/pipeline.h"
#include "quench/verify.h"
#include "random_shapes.h"

namespace quench {
namespace verify_sequence_test {

Record burned_core(const VoxelShape& shape, double lambda, BurnOptions options) {
  const pipeline::LoadedShape loaded = pipeline::shape_of(VoxelShape(shape), shape.grid(), {});
  Record data = pipeline::core_file(pipeline::core_of(loaded, {.pruning = {kLambda, pipeline::world_length(lambda)}}));
  const MedialAxis axis = medial_axis_of(data);
  options.rounded = true;
  const Burning burning = burn(axis, options);
  add_burning(data, burning, burn_sequence(axis, burning));
  return data;
}

Check check_of(const VoxelShape& shape, const Record& data) {
  const Certificate certificate = verify(shape, data);
  const auto found = std::ranges::find(certificate.checks, "burn sequence", &Check::name);
  return found == certificate.checks.end() ? Check{"none", false, {}, {}} : *found;
}

TEST(VerifySequence, ThoseOfRandomCoresPass) {
  constexpr std::array<double, 4> omegas{0, 0.21, 0.6, 5};
  std::size_t pockets = 0;
  for (std::uint64_t seed = 0; seed < 120; ++seed) {
    const VoxelShape shape = testing_shapes::random_shape(seed, 9, seed % 3 == 1);
    const Record data =
        burned_core(shape, seed % 2 ? 0 : 1.2,
                    {.omega = omegas[seed % 4], .radius = seed % 7 == 0 ? RadiusRule::linear : RadiusRule::exact});
    const Check check = check_of(shape, data);
    EXPECT_TRUE(check.passed) << seed << ": " << check.detail;
    EXPECT_EQ(check.arrays.size(), 6u) << seed << ": " << check.detail;
    const auto flags = find_array(data.point_data, "unburned")->numbers();
    pockets += std::ranges::count(flags, 1.0) > 0;
  }
  EXPECT_GT(pockets, 5u);
}

class Forged : public testing::Test {
 protected:
  Forged() {
    Grid grid;
    grid.dims = {16, 14, 9};
    shape = testing_shapes::from_predicate(grid, [](int x, int y, int z) {  // a plate with a fin
      return x > 0 && x < 15 && y > 0 && y < 13 && z > 0 && (z < 4 || (y > 5 && y < 8)) && z < 8;
    });
    data = burned_core(shape, 0, {.omega = 0.3});
  }
  template <class T>
  std::vector<T>& values(const char* name) {
    return std::get<std::vector<T>>(std::ranges::find(data.field_data, name, &DataArray::name)->values);
  }
  /// A change under which the check must fail with these words, though the fingerprint is that of the changed arrays.
  void fails(const char* words, const std::function<void()>& change) {
    const Record before = data;
    change();
    values<std::int64_t>("sequence_of")[1] = static_cast<std::int64_t>(burning::fingerprint(data.field_data));
    const Check check = check_of(shape, data);
    EXPECT_FALSE(check.passed) << words;
    EXPECT_NE(check.detail.find(words), std::string::npos) << check.detail << "\n(expected: " << words << ")";
    data = before;
  }
  VoxelShape shape;
  Record data;
};

TEST_F(Forged, IsNoticedByWhatItSays) {
  EXPECT_TRUE(check_of(shape, data).passed) << check_of(shape, data).detail;
  auto& steps = values<std::int32_t>("sequence_steps");
  auto& parents = values<std::uint8_t>("sequence_parents");
  auto& order = values<std::uint8_t>("sequence_order");
  const auto with_parent =
      static_cast<std::size_t>(std::ranges::find_if(parents, [](auto n) { return n > 0; }) - parents.begin());
  const auto inside =
      parents.size() - 1 -
      static_cast<std::size_t>(std::ranges::find_if(parents.rbegin(), parents.rend(), [](auto n) { return n > 0; }) -
                               parents.rbegin());
  fails("does not burn, and is not in a closed pocket", [&] { steps[5] = std::numeric_limits<std::int32_t>::min(); });
  fails("burns before its radius", [&] { steps[5] = -1; });
  fails("the last of its sectors burns at", [&] { steps[with_parent] += 40000; });
  fails("has burn_time", [&] { values<double>("sequence_step")[0] *= 2; });
  fails("after each other", [&] { steps[inside] += 40000; });
  fails("is no node of it", [&] { parents[with_parent] = 254; });
  fails("prime arcs, and its link has", [&] { parents[with_parent] = 0; });
  fails("node ", [&] { parents[inside] = 0; });
  fails("the order of the sectors of", [&] { std::swap(order[0], order[1]), order[0] = order[1]; });
  fails("'sequence_large' has", [&] { values<std::int32_t>("sequence_large").push_back(300); });
  fails("the arrays are of", [&] { steps.pop_back(); });
  fails("is not of its type", [&] {
    std::ranges::find(data.field_data, "sequence_order", &DataArray::name)->values = std::vector<double>{1};
  });
}

TEST_F(Forged, ParentsThatCannotBeAreNoticed) {
  auto& parents = values<std::uint8_t>("sequence_parents");
  const std::vector<std::uint8_t> right = parents;
  std::set<std::string> said;
  std::mt19937 random(1);
  const int rounds = repeats(800, 300);
  for (int i = 0; i < rounds; ++i) {
    for (int changes = 0; changes < 1 + i % 3; ++changes) parents[random() % parents.size()] = random() % 9;
    if (parents == right) continue;
    const Check check = check_of(shape, data);
    EXPECT_FALSE(check.passed);
    for (const char* words : {"prime arcs cross in", "is its own ancestor", "of other arrays"})
      if (check.detail.find(words) != std::string::npos) said.insert(words);
    parents = right;
  }
  EXPECT_EQ(said.size(), 3u);
}

TEST_F(Forged, FingerprintsAreThoseOfTheFile) {
  values<std::int64_t>("sequence_of")[0] ^= 1;
  EXPECT_NE(check_of(shape, data).detail.find("of another axis"), std::string::npos);
  values<std::int64_t>("sequence_of")[0] ^= 1;
  values<std::int64_t>("sequence_of")[1] ^= 1;
  EXPECT_NE(check_of(shape, data).detail.find("of other arrays"), std::string::npos);
}

}  // namespace verify_sequence_test
}  // namespace quench
