// SPDX-License-Identifier: Apache-2.0
// The burn sequence in files: what is read is what was written, and nothing else is taken for it.
#include "burning/burn_sequence.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "quench/axis.h"
#include "quench/burn.h"
#include "quench/error.h"
#include "quench/skeleton.h"
#include "random_complexes.h"
#include "random_shapes.h"
#include "same_skeletons.h"

namespace quench {
namespace burn_sequence_test {

using namespace testing_complexes;

/// An axis that was burned as files keep it, and the fields of its file.
struct Burned {
  MedialAxis axis;
  Burning burning;
  Record file;
};

Burned burned(MedialAxis axis, BurnOptions options) {
  options.rounded = true;
  Burned result{std::move(axis), {}, {}};
  result.burning = burn(result.axis, options);
  result.file.points = result.axis.points;
  add_burning(result.file, result.burning, burn_sequence(result.axis, result.burning));
  return result;
}

MedialAxis axis_of(const BurnInput& input) {
  MedialAxis axis;
  axis.complex = input.complex;
  axis.points = input.points;
  axis.radius = input.radius;
  return axis;
}

double some_omega(std::uint64_t seed) {
  constexpr std::array<double, 5> omegas{0.05, 0.3, 0.8, 1.7, 20};
  return omegas[seed % omegas.size()];
}

MedialAxis pruned_core(const VoxelShape& shape, double lambda) {
  MedialAxis core = voxel_core(shape);
  prune_levels(core);
  return pruned(core, lambda);
}

/// Random complexes, and random voxel cores.
Burned random_burned(std::uint64_t seed) {
  if (seed % 3 == 0)
    return burned(pruned_core(testing_shapes::random_shape(seed, 9, seed % 2 == 1), seed % 4 ? 0 : 1.2),
                  {.omega = some_omega(seed)});
  const BurnInput input = random_input(seed);
  return burned(axis_of(input), {.omega = some_omega(seed), .radius = input.rule});
}

/// What is read, and the notes about it.
struct Reading {
  std::optional<Burning> burning;
  std::vector<std::string> notes;
};
Reading read(const Record& file, const MedialAxis& axis, const BurnOptions& options) {
  Reading result;
  Context context;
  context.note = [&](const std::string& sentence) { result.notes.push_back(sentence); };
  result.burning = kept_burning(file, axis, options, &context);
  return result;
}
void expect_not_taken(const Record& file, const MedialAxis& axis, const BurnOptions& options, const char* why) {
  const Reading reading = read(file, axis, options);
  EXPECT_FALSE(reading.burning) << why;
  ASSERT_EQ(reading.notes.size(), 1u) << why;
  EXPECT_NE(reading.notes[0].find(why), std::string::npos) << reading.notes[0];
}

DataArray& array_of(Record& file, const std::string& name) {
  return *std::ranges::find(file.field_data, name, &DataArray::name);
}
/// Makes damaged arrays look like those that were written.
void seal(Record& file) {
  std::get<std::vector<std::int64_t>>(array_of(file, "sequence_of").values)[1] =
      static_cast<std::int64_t>(burning::fingerprint(file.field_data));
}

TEST(BurnSequence, IsReadAsItWasWritten) {
  std::size_t large = 0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    SCOPED_TRACE(seed);
    const Burned wanted = random_burned(seed);
    const Reading reading = read(wanted.file, wanted.axis, wanted.burning.options);
    ASSERT_TRUE(reading.burning) << reading.notes.front();
    EXPECT_TRUE(reading.notes.empty());
    const Burning& found = *reading.burning;
    EXPECT_EQ(found.burn_time, wanted.burning.burn_time);
    EXPECT_EQ(found.erosion_thickness, wanted.burning.erosion_thickness);
    EXPECT_EQ(found.max_burn_time, wanted.burning.max_burn_time);
    EXPECT_EQ(found.unburned, wanted.burning.unburned);
    EXPECT_EQ(found.node_count, wanted.burning.node_count);
    EXPECT_EQ(found.options.omega, wanted.burning.options.omega);
    EXPECT_EQ(found.sectors->state_time, wanted.burning.sectors->state_time);
    EXPECT_EQ(found.sectors->parent, wanted.burning.sectors->parent);
    EXPECT_EQ(found.sectors->parent_face, wanted.burning.sectors->parent_face);
    if (seed % 4 == 0)
      testing_skeletons::expect_same(skeletons(wanted.axis, found), skeletons(wanted.axis, wanted.burning));
    // Writing what was read gives the same file.
    for (const DataArray& array : burn_sequence(wanted.axis, found))
      EXPECT_EQ(array.values, find_array(wanted.file.field_data, array.name)->values) << array.name;
    large += find_array(wanted.file.field_data, "sequence_large")->size();
  }
  EXPECT_GT(large, 100u);  // ways around polygons of many nodes
}

TEST(BurnSequence, RoundingIsSmallAndKeepsTheRadius) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const BurnInput input = random_input(seed);
    BurnOptions options{.omega = some_omega(seed), .radius = input.rule};
    const Burning exact = burn(axis_of(input), options);
    options.rounded = true;
    const Burning rounded = burn(axis_of(input), options);
    EXPECT_EQ(rounded.sectors->parent, exact.sectors->parent);
    EXPECT_EQ(rounded.unburned, exact.unburned);
    for (std::size_t v = 0; v < input.points.size(); ++v) {
      if (std::isinf(exact.burn_time[v])) continue;
      EXPECT_NEAR(rounded.burn_time[v], exact.burn_time[v], options.omega / 8192 * 1.001);
      EXPECT_GE(rounded.erosion_thickness[v], 0);
      if (exact.erosion_thickness[v] == 0) {
        EXPECT_EQ(rounded.erosion_thickness[v], 0);
      }
    }
  }
}

TEST(BurnSequence, TimesOfAnySizeAreKept) {
  for (const double scale : {1e-280, 1e-30, 1e30, 1e150}) {
    for (const double radius : {0.0, 1e9}) {  // at one vertex: fire comes to its neighbours at that time
      BurnInput input = random_input(7);
      for (Vec3& p : input.points) p *= scale;
      for (double& r : input.radius) r *= scale;
      input.radius[0] += radius * scale;
      const Burned wanted = burned(axis_of(input), {.omega = 0.8 * scale, .radius = input.rule});
      const Reading reading = read(wanted.file, wanted.axis, wanted.burning.options);
      ASSERT_TRUE(reading.burning) << scale;
      EXPECT_EQ(reading.burning->sectors->state_time, wanted.burning.sectors->state_time);
      EXPECT_EQ(reading.burning->sectors->parent, wanted.burning.sectors->parent);
    }
  }
}

TEST(BurnSequence, IsOfOneAxisOnly) {
  const Burned known = random_burned(3);
  const auto changed = [&](const std::function<void(MedialAxis&, BurnOptions&)>& change) {
    MedialAxis axis = known.axis;
    BurnOptions options = known.burning.options;
    change(axis, options);
    expect_not_taken(known.file, axis, options, "does not fit its medial axis");
  };
  changed([](MedialAxis& a, BurnOptions&) { a.points[5][1] += 1e-9; });
  changed([](MedialAxis& a, BurnOptions&) { a.radius[0] += 1e-9; });
  changed([](MedialAxis& a, BurnOptions&) { std::swap(a.complex.edges[0], a.complex.edges[1]); });
  changed([](MedialAxis& a, BurnOptions&) { std::swap(a.complex.face_vertices[0], a.complex.face_vertices[1]); });
  changed([](MedialAxis&, BurnOptions& o) { o.omega *= 1.0001; });
  changed([](MedialAxis&, BurnOptions& o) { o.radius = RadiusRule::linear; });
}

TEST(BurnSequence, DamagedArraysAreNotTaken) {
  Burned known = random_burned(3);
  for (std::uint64_t seed = 1; array_of(known.file, "sequence_large").size() == 0; ++seed) known = random_burned(seed);
  const auto damaged = [&](const std::function<void(Record&)>& damage, bool sealed = false) {
    Record file = known.file;
    damage(file);
    if (sealed) seal(file);
    expect_not_taken(file, known.axis, known.burning.options, "is damaged");
  };
  for (const char* name :
       {"sequence_steps", "sequence_parents", "sequence_order", "sequence_large", "sequence_step", "sequence_of"}) {
    SCOPED_TRACE(name);
    const bool last = name == std::string("sequence_of");
    if (!last) {
      damaged([&](Record& f) { std::erase_if(f.field_data, [&](const DataArray& a) { return a.name == name; }); },
              true);
      damaged([&](Record& f) { array_of(f, name).values = std::vector<std::string>{"text"}; }, true);
      damaged([&](Record& f) { array_of(f, name).values = std::vector<float>{1}; }, true);
      damaged([&](Record& f) { std::visit([](auto& v) { v.emplace_back(); }, array_of(f, name).values); }, true);
      damaged([&](Record& f) { std::visit([](auto& v) { v.clear(); }, array_of(f, name).values); }, true);
    }
  }
  damaged([](Record& f) { std::get<std::vector<std::int64_t>>(array_of(f, "sequence_of").values)[1] ^= 1; });
  damaged([](Record& f) { std::get<std::vector<std::int32_t>>(array_of(f, "sequence_steps").values)[9] += 1; });
  damaged([](Record& f) { std::get<std::vector<std::uint8_t>>(array_of(f, "sequence_parents").values)[9] ^= 1; });
  damaged([](Record& f) { std::get<std::vector<double>>(array_of(f, "sequence_step").values)[0] = NAN; }, true);
  damaged([](Record& f) { std::get<std::vector<double>>(array_of(f, "sequence_step").values)[0] = 1e308; }, true);
  damaged([](Record& f) { std::get<std::vector<std::uint8_t>>(array_of(f, "sequence_parents").values)[9] = 255; },
          true);
  Record none = known.file;
  burning::drop_sequence(none);
  const Reading reading = read(none, known.axis, known.burning.options);
  EXPECT_FALSE(reading.burning);
  EXPECT_TRUE(reading.notes.empty());  // files of earlier versions have none
}

// Whoever writes arrays with right fingerprints gets an error at worst.
TEST(BurnSequence, ForgedArraysDoNoHarm) {
  int taken = 0;
  for (std::uint64_t seed = 0; seed < 900; ++seed) {
    Burned known = random_burned(seed % 30);
    Random random(seed);
    auto& steps = std::get<std::vector<std::int32_t>>(array_of(known.file, "sequence_steps").values);
    auto& parents = std::get<std::vector<std::uint8_t>>(array_of(known.file, "sequence_parents").values);
    auto& order = std::get<std::vector<std::uint8_t>>(array_of(known.file, "sequence_order").values);
    const int changes = 1 + static_cast<int>(seed % 7);
    for (int i = 0; i < changes; ++i) {
      const auto at = [&](const auto& v) {
        return static_cast<std::size_t>(random.unit() * static_cast<double>(v.size()));
      };
      const auto any = [&](double most) { return random.unit() * most; };
      if (seed % 3 == 0 && !steps.empty()) steps[at(steps)] = static_cast<std::int32_t>(any(2147483647.0)) - 1;
      if (seed % 3 != 0 && !parents.empty()) parents[at(parents)] = static_cast<std::uint8_t>(any(i % 2 ? 255 : 12));
      if (seed % 3 == 2 && !parents.empty()) std::swap(parents[at(parents)], parents[at(parents)]);
      if (!order.empty()) order[at(order)] = static_cast<std::uint8_t>(any(255));
    }
    seal(known.file);
    const Reading reading = read(known.file, known.axis, known.burning.options);
    if (!reading.burning) continue;
    ++taken;
    try {
      const SkeletonFamily family = skeletons(known.axis, *reading.burning);
      extract(family, 0.5, 0.5);
    } catch (const Error&) {
    }
  }
  EXPECT_GT(taken, 100);
}

TEST(BurnSequence, NeedsWhatItKeeps) {
  const MedialAxis axis = axis_of(random_input(1));
  for (const BurnOptions& options : {BurnOptions{.parents = false, .rounded = true}, BurnOptions{}})
    EXPECT_THROW(burn_sequence(axis, burn(axis, options)), Error);
  Burned known = random_burned(1);
  add_burning(known.file, burn(known.axis));  // another burning: the sequence would not be its
  EXPECT_FALSE(find_array(known.file.field_data, "sequence_of"));
}

}  // namespace burn_sequence_test
}  // namespace quench
