// SPDX-License-Identifier: Apache-2.0
// What holds for every measure of the menu, in space and in the plane: a new line of the table is tested by itself.
#include "quench/measures.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "plane_shapes.h"
#include "quench/axis.h"
#include "quench/burn.h"
#include "quench/error.h"
#include "quench/pipeline.h"
#include "quench/verify.h"
#include "random_shapes.h"

namespace quench {
namespace measures_of_menu_test {

using testing_planes::random_plane_shape;
using testing_shapes::box_shape;
using testing_shapes::from_predicate;
using testing_shapes::random_shape;

pipeline::LoadedShape loaded(VoxelShape&& shape) {
  const Grid grid = shape.grid();
  return pipeline::shape_of(std::move(shape), grid, {});
}

// Finite values of the cells, some of them, ascending.
std::vector<double> thresholds(const CellValues& values, std::size_t count) {
  std::vector<double> all;
  for (const auto* of : {&values.vertex, &values.edge, &values.face})
    std::ranges::copy_if(*of, std::back_inserter(all), [](double x) { return std::isfinite(x); });
  std::ranges::sort(all);
  std::vector<double> some;
  for (std::size_t i = 0; i < count && !all.empty(); ++i) some.push_back(all[(all.size() - 1) * i / (count - 1)]);
  return some;
}

class OfEveryMeasure : public testing::TestWithParam<MeasureKind> {};

INSTANTIATE_TEST_SUITE_P(Menu, OfEveryMeasure, testing::ValuesIn(kMeasures),
                         [](const auto& of) { return std::string(of.param.name); });

void expect_topology_kept(pipeline::LoadedShape&& shape, const MeasureKind& measure, const std::string& what) {
  MedialAxis axis = voxel_core(shape.shape);
  pipeline::add_measure(axis, shape, measure.name);
  prune_levels(axis, measure.name);
  const Measure& of = axis.measure(measure.name);
  const Topology whole = topology(axis.complex);
  for (const double t : thresholds(of.value, 6)) {
    const MedialAxis kept = pruned(axis, t, measure.name);
    ASSERT_EQ(topology(kept.complex), whole) << what << ", threshold " << t;
    std::size_t above = 0;
    for (std::size_t f = 0; f < axis.complex.face_count(); ++f) above += of.value.face[f] >= t;
    ASSERT_GE(kept.complex.face_count(), above) << what;
  }
  const double most = std::isfinite(measure.most) ? measure.most : 1e9;
  for (const auto* values : {&of.value.vertex, &of.value.edge, &of.value.face})
    for (const double x : *values)
      ASSERT_TRUE(x >= std::min(measure.least, 1.0) && (std::isinf(x) || x <= most)) << what;
}

TEST_P(OfEveryMeasure, TopologyIsKept) {
  for (std::uint64_t seed = 0; seed < 60 && !HasFatalFailure(); ++seed)
    expect_topology_kept(loaded(random_shape(seed, 9, seed % 4 == 0)), GetParam(), "seed " + std::to_string(seed));
}

TEST_P(OfEveryMeasure, TopologyIsKeptInThePlane) {
  for (std::uint64_t seed = 0; seed < 60 && !HasFatalFailure(); ++seed)
    expect_topology_kept(loaded(random_plane_shape(seed, 16)), GetParam(), "seed " + std::to_string(seed));
}

// A threshold as a user gives it, about in the middle.
pipeline::Length middle(pipeline::LoadedShape& shape, const MeasureKind& measure) {
  MedialAxis axis = voxel_core(shape.shape);
  pipeline::add_measure(axis, shape, measure.name);
  const std::vector<double> some = thresholds(axis.measure(measure.name).value, 3);
  const double t = some.size() < 2 ? measure.least : std::max(measure.least, some[1]);
  if (measure.unit == MeasureUnit::length) return pipeline::world_length(t);
  return {t, pipeline::Length::Unit::number};
}

void expect_verified(pipeline::LoadedShape&& shape, const MeasureKind& measure, bool full, const std::string& what) {
  pipeline::AxisOptions options;
  options.pruning = {measure.name, middle(shape, measure)};
  options.full = full;
  const Record file = pipeline::core_file(pipeline::core_of(shape, options));
  const Certificate certificate = verify(shape.shape, file);
  for (const Check& check : certificate.checks)
    ASSERT_TRUE(check.passed) << what << ": " << check.name << ": " << check.detail;
  ASSERT_NE(find_array(file.cell_data, std::string(measure.name) + "_level"), nullptr);
  ASSERT_NE(find_array(file.field_data, measure.name), nullptr);
}

TEST_P(OfEveryMeasure, PruningsAreVerified) {
  for (std::uint64_t seed = 0; seed < 24 && !HasFatalFailure(); ++seed) {
    const std::string what = "seed " + std::to_string(seed);
    expect_verified(loaded(random_shape(seed, 10)), GetParam(), seed % 3 == 0, what);
    expect_verified(loaded(random_plane_shape(seed, 16)), GetParam(), seed % 3 == 0, what + " of the plane");
  }
}

TEST_P(OfEveryMeasure, WrongValuesAreFound) {
  for (const bool prunes : {true, false}) {
    pipeline::LoadedShape shape = loaded(random_shape(5, 12));
    pipeline::AxisOptions options;
    if (prunes)
      options.pruning = {GetParam().name, middle(shape, GetParam())};
    else
      options.measures = {std::string(GetParam().name)};
    Record file = pipeline::core_file(pipeline::core_of(shape, options));
    ASSERT_TRUE(verify(shape.shape, file).passed());
    // Of what is not pruned by them, only bounds of these are checked.
    const bool of_fire = GetParam().name == kCoreErosionThickness || GetParam().name == kRelativeErosionThickness;
    for (DataArray& array : file.cell_data)
      if (array.name == GetParam().name) {
        std::vector<double> numbers = array.numbers();
        for (double& x : numbers) x = of_fire && !prunes ? -1 - x : 1.5 * x;
        array.values = std::move(numbers);
      }
    EXPECT_FALSE(verify(shape.shape, file).passed()) << prunes;
  }
}

TEST_P(OfEveryMeasure, DoesNotDependOnThreadsOrOrientation) {
  // A mirror image has the same values, but for rounding.
  for (const std::uint64_t seed : {2u, 5u, 9u}) {
    const VoxelShape shape = random_shape(seed, 12);
    const auto values = [&](bool mirrored, int threads) {
      Context context;
      context.threads = threads;
      const auto& dims = shape.grid().dims;
      pipeline::LoadedShape of = loaded(from_predicate(shape.grid(), [&](int x, int y, int z) {
        return shape.contains(mirrored ? static_cast<int>(dims[0]) - 1 - x : x, y, z);
      }));
      MedialAxis axis = voxel_core(of.shape, {}, &context);
      pipeline::add_measure(axis, of, GetParam().name, &context);
      return axis.measure(GetParam().name).value;
    };
    const CellValues one = values(false, 1), two = values(false, 2);
    ASSERT_EQ(one.face, two.face);
    ASSERT_EQ(one.edge, two.edge);
    ASSERT_EQ(one.vertex, two.vertex);
    std::vector<double> here = one.face, there = values(true, 1).face;
    std::ranges::sort(here);
    std::ranges::sort(there);
    ASSERT_EQ(here.size(), there.size());
    // The fire of segments depends on where nodes are, which rounding decides.
    const bool of_fire = GetParam().name == kCoreErosionThickness || GetParam().name == kRelativeErosionThickness;
    for (std::size_t i = 0; i < here.size(); ++i) {
      if (std::isinf(here[i])) {
        ASSERT_EQ(here[i], there[i]);
      } else {
        ASSERT_NEAR(here[i], there[i], (of_fire ? 1e-2 : 1e-6) * (1 + here[i]));
      }
    }
  }
}

TEST_P(OfEveryMeasure, IsWrittenWhereItIsAskedFor) {
  pipeline::LoadedShape shape = loaded(box_shape(12, 9, 5));
  pipeline::AxisOptions options;
  options.measures = pipeline::parse_measures(GetParam().name);
  const Record file = pipeline::core_file(pipeline::core_of(shape, options));
  EXPECT_NE(find_array(file.cell_data, GetParam().name), nullptr);
  EXPECT_NE(find_array(file.point_data, GetParam().name), nullptr);
  const Certificate certificate = verify(shape.shape, file);
  for (const Check& check : certificate.checks) EXPECT_TRUE(check.passed) << check.name << ": " << check.detail;
}

std::vector<DataArray>& arrays_of(Record& data, const std::string& of) {
  return of == "point" ? data.point_data : of == "cell" ? data.cell_data : data.field_data;
}

void expect_missed(const VoxelShape& shape, const Record& file, const std::string& of, const std::string& name) {
  Record data = file;
  std::vector<DataArray>& arrays = arrays_of(data, of);
  ASSERT_EQ(std::erase_if(arrays, [&](const DataArray& array) { return array.name == name; }), 1u) << of << name;
  EXPECT_EQ(verify(shape, data).absent, std::vector<std::string>{of + " " + name});
}

// Which files have arrays of the measure, the table says; verify() names each that is not there.
TEST_P(OfEveryMeasure, ItsArraysAreExpected) {
  const std::string name(GetParam().name);
  for (const bool plane : {false, true}) {
    pipeline::LoadedShape shape = loaded(plane ? random_plane_shape(3, 16) : random_shape(3, 12));
    Record unasked = pipeline::run(shape, {}).axis.file;
    const MeasureFiles files = GetParam().files;
    const bool expected =
        name == kDetail || files == MeasureFiles::all || (files == MeasureFiles::of_the_plane && plane);
    for (const char* of : {"point", "cell"}) {
      EXPECT_EQ(find_array(arrays_of(unasked, of), name) != nullptr, expected) << of << plane;
      if (expected) expect_missed(shape.shape, unasked, of, name);
    }
    pipeline::RunOptions options;
    options.axis.pruning = {GetParam().name, middle(shape, GetParam())};
    const pipeline::RunResult run = pipeline::run(shape, options);
    EXPECT_EQ(verify(shape.shape, run.axis.file).absent, std::vector<std::string>{});
    for (const char* of : {"point", "cell"}) expect_missed(shape.shape, run.axis.file, of, name);
    expect_missed(shape.shape, run.axis.file, "cell", name + "_level");
    const Record skeleton = pipeline::skeleton_file(run.axis.skeleton, run.axis.file);
    for (const Record* file : {&run.axis.file, &skeleton})
      for (const std::string& field : {name, name + "_chosen"}) expect_missed(shape.shape, *file, "field", field);
  }
}

TEST_P(OfEveryMeasure, RefusesWhatIsNoThreshold) {
  const std::string name(GetParam().name);
  const auto refusal = [&](const std::string& text) {
    try {
      pipeline::pruning_of(name, text, "prune_by");
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::usage);
      EXPECT_EQ(error.field(), "prune_by");
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(refusal("much"), "");
  EXPECT_NE(refusal("-1"), "");
  EXPECT_EQ(refusal("auto").empty(), GetParam().automatic);
  if (GetParam().unit != MeasureUnit::length) {
    EXPECT_NE(refusal("2vox").find("is not a number"), std::string::npos);
  }
  if (std::isfinite(GetParam().most)) {
    EXPECT_NE(refusal("inf"), "");
  }
}

// Of a whole core burned by default options, faces have the smallest of their corners.
TEST(Measures, ErosionThicknessIsThatOfTheWholeCore) {
  pipeline::LoadedShape shape = loaded(box_shape(16, 12, 7));
  MedialAxis axis = voxel_core(shape.shape);
  pipeline::add_measure(axis, shape, kCoreErosionThickness);
  pipeline::add_measure(axis, shape, kRelativeErosionThickness);
  BurnOptions options;
  options.rounded = true;
  const Burning burning = burn(axis, options);
  for (std::size_t f = 0; f < axis.complex.face_count(); ++f) {
    double thickness = 1e9, share = 1;
    for (const std::uint32_t v : axis.complex.corners(f)) {
      thickness = std::min(thickness, burning.erosion_thickness[v]);
      share = std::min(share, 1 - axis.radius[v] / burning.burn_time[v]);
    }
    EXPECT_EQ(axis.measure(kCoreErosionThickness).value.face[f], thickness);
    EXPECT_NEAR(axis.measure(kRelativeErosionThickness).value.face[f], share, 1e-12);
  }
}

// Pockets never burn: the shell around a cavity.
TEST(Measures, WhatNeverBurnsStays) {
  const VoxelShape ball = from_predicate(
      [] {
        Grid g;
        g.dims = {15, 15, 15};
        return g;
      }(),
      [](int x, int y, int z) {
        const int d = (x - 7) * (x - 7) + (y - 7) * (y - 7) + (z - 7) * (z - 7);
        return d <= 49 && d >= 9;
      });
  pipeline::LoadedShape shape = loaded(VoxelShape(ball));
  MedialAxis axis = voxel_core(shape.shape);
  for (const std::string_view name : {kCoreErosionThickness, kRelativeErosionThickness, kMgf, kChordResidual}) {
    pipeline::add_measure(axis, shape, name);
    const double most = std::ranges::max(axis.measure(name).value.face);
    EXPECT_EQ(most, name == kRelativeErosionThickness ? 1 : std::numeric_limits<double>::infinity()) << name;
  }
}

TEST(Measures, OtherNamesAreRefused) {
  for (const char* name : {"thickness", "erosion_thickness", "potential_residual", ""})
    EXPECT_THROW(pipeline::pruning_of(name, "1", "prune_by"), Error) << name;
  EXPECT_THROW(pipeline::parse_measures("mgf,"), Error);
  EXPECT_EQ(pipeline::parse_measures("mgf,lambda").size(), 2u);
  EXPECT_EQ(pipeline::parse_measures("all").size(), kMeasures.size());
  pipeline::LoadedShape shape = loaded(box_shape(5, 5, 5));
  pipeline::AxisOptions options;
  options.pruning.measure = kMgf;
  EXPECT_THROW(pipeline::core_of(shape, options), Error);
  options.pruning = {};
  options.measures = {"mgf"};
  options.bricks_in = ".";
  EXPECT_THROW(pipeline::core_of(shape, options), Error);
}

}  // namespace measures_of_menu_test
}  // namespace quench
