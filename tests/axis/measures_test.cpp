// SPDX-License-Identifier: Apache-2.0
// Measures by name: one that the library does not know goes the whole way of lambda, and files from before measures had
// names are read as they were.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "complex/thinning.h"
#include "quench/axis.h"
#include "quench/error.h"
#include "quench/io.h"
#include "quench/pipeline.h"
#include "quench/verify.h"
#include "random_shapes.h"
#include "temporary_folder.h"

namespace quench {
namespace measures_test {

// Numbers that follow from the indices of cells: unlike lambda, those of an edge are not the largest of its faces.
Measure numbered(const CellComplex& complex) {
  const auto values = [](std::size_t count, std::size_t step) {
    std::vector<double> list(count);
    for (std::size_t i = 0; i < count; ++i) list[i] = static_cast<double>((i * step + 3) % 32) / 8;
    return list;
  };
  return {"numbers",
          {values(complex.vertex_count, 7), values(complex.edges.size(), 11), values(complex.face_count(), 13)},
          {}};
}

MedialAxis axis_with_two_measures(const VoxelShape& shape) {
  MedialAxis axis = voxel_core(shape);
  axis.measures.push_back(numbered(axis.complex));
  prune_levels(axis);
  prune_levels(axis, "numbers");
  return axis;
}

VoxelShape shape_of(std::uint64_t seed) { return testing_shapes::random_shape(seed, 8, seed % 3 == 2); }

std::vector<std::string> texts(const Record& data, const char* name) {
  const DataArray* array = find_array(data.field_data, name);
  return array ? std::get<std::vector<std::string>>(array->values) : std::vector<std::string>{};
}

template <class Call>
void expect_refused(const Call& call, const std::string& says) {
  try {
    call();
    FAIL() << "not refused: " << says;
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::usage);
    EXPECT_NE(std::string(error.what()).find(says), std::string::npos) << error.what();
  }
}

TEST(Measures, AnyMeasurePrunesAsLambdaDoes) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const VoxelShape shape = shape_of(seed);
    const MedialAxis axis = axis_with_two_measures(shape);
    const auto& [name, value, level] = axis.measure("numbers");
    const CellComplex& c = axis.complex;
    ASSERT_TRUE(level == complex::thin(c, value.vertex, value.edge, value.face, nullptr, "")) << seed;
    for (const double threshold : {0.0, 0.5, 1.125, 2.0, 3.5, 1e30}) {
      const MedialAxis kept = pruned(axis, threshold, "numbers");
      ASSERT_EQ(topology(kept.complex), topology(shape)) << seed << " " << threshold;
      const auto left = [threshold](const std::vector<double>& levels) {
        return static_cast<std::size_t>(std::ranges::count_if(levels, [&](double x) { return x >= threshold; }));
      };
      ASSERT_EQ(kept.complex.vertex_count, left(level.vertex));
      ASSERT_EQ(kept.complex.edges.size(), left(level.edge));
      ASSERT_EQ(kept.complex.face_count(), left(level.face));
      ASSERT_TRUE(kept.measure("numbers").level.complete(kept.complex) &&
                  kept.measure("numbers").value.complete(kept.complex) && kept.measure().value.complete(kept.complex));
      ASSERT_TRUE(kept.measure().level.empty());  // that of the whole axis is not that of a part of it
      const MedialAxis in_place = pruned(MedialAxis(axis), threshold, "numbers");
      ASSERT_EQ(in_place.complex.edges, kept.complex.edges);
      for (const char* of : {"lambda", "numbers"})
        ASSERT_TRUE(in_place.measure(of).value == kept.measure(of).value &&
                    in_place.measure(of).level == kept.measure(of).level);
    }
  }
}

TEST(Measures, ReconstructionIsOfTheMeasureThatIsAskedFor) {
  const VoxelShape shape = shape_of(4);
  const MedialAxis axis = axis_with_two_measures(shape);
  const Reconstruction by_numbers(shape, axis, Reconstruction::kSamples, nullptr, "numbers");
  for (const double threshold : {0.0, 1.0, 2.5}) {
    MedialAxis kept = pruned(axis, threshold, "numbers");
    prune_levels(kept);
    EXPECT_EQ(by_numbers.share(threshold), Reconstruction(shape, kept).share(0)) << threshold;
  }
}

TEST(Measures, GoThroughAFile) {
  const TemporaryFolder folder;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const MedialAxis axis = axis_with_two_measures(shape_of(seed));
    io::write_record(folder / "axis.vtp", to_record(axis), {});
    const Record data = io::read_record(folder / "axis.vtp");
    EXPECT_EQ(texts(data, "measures"), (std::vector<std::string>{"lambda", "numbers", "object_angle", "cap_height"}));
    EXPECT_EQ(find_array(data.field_data, "format_version")->numbers(), std::vector<double>{2});
    EXPECT_EQ(find_array(data.point_data, "numbers")->numbers(), axis.measure("numbers").value.vertex);
    MedialAxis read = medial_axis_of(data);
    ASSERT_TRUE(take_levels(read, data));
    ASSERT_EQ(read.measures.size(), 2u);
    for (const char* name : {"lambda", "numbers"}) {
      ASSERT_TRUE(read.measure(name).level == axis.measure(name).level) << name << " " << seed;
      for (const double threshold : {0.7, 1.5})
        ASSERT_EQ(pruned(read, threshold, name).complex.edges, pruned(axis, threshold, name).complex.edges) << seed;
    }
    // Levels without values are written again.
    MedialAxis again = medial_axis_of(to_record(read));
    ASSERT_TRUE(take_levels(again, to_record(read)));
    ASSERT_TRUE(again.measure("numbers").level == axis.measure("numbers").level);
  }
}

Record core_with_two_measures(const VoxelShape& shape, double lambda, bool full) {
  const pipeline::LoadedShape loaded = pipeline::shape_of(VoxelShape(shape), shape.grid(), {});
  pipeline::CoreResult core =
      pipeline::core_of(loaded, {.pruning = {kLambda, pipeline::world_length(lambda)}, .full = full});
  core.axis.measures.push_back(numbered(core.axis.complex));
  prune_levels(core.axis, "numbers");
  return pipeline::core_file(core);
}

const Check* find_check(const Certificate& certificate, const std::string& name) {
  const auto found = std::ranges::find(certificate.checks, name, &Check::name);
  return found == certificate.checks.end() ? nullptr : &*found;
}

TEST(Measures, TheirLevelsAreReplayedByVerify) {
  std::size_t damaged = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const VoxelShape shape = shape_of(seed);
    for (const bool full : {true, false}) {
      const Record data = core_with_two_measures(shape, 0.8, full);
      const Certificate certificate = verify(shape, data);
      for (const Check& check : certificate.checks) EXPECT_TRUE(check.passed) << check.name << ": " << check.detail;
      const Check* replay = find_check(certificate, "nested levels of numbers");
      ASSERT_TRUE(replay);
      EXPECT_NE(replay->detail.find("thinning by the keys"), std::string::npos) << replay->detail;
      for (const char* array : {"point numbers", "cell numbers"})
        EXPECT_EQ(std::ranges::count(certificate.not_checked, array, &UncheckedArray::array), 1) << array;
      for (std::size_t cell = 0; cell < data.cell_count(); cell += 1 + data.cell_count() / 10)
        for (const double factor : {0.5, 1.5}) {
          const double level = find_array(data.cell_data, "numbers_level")->numbers()[cell];
          if (level == 0) continue;  // nothing would change
          Record wrong = data;
          for (DataArray& array : wrong.cell_data)
            if (array.name == "numbers_level") std::get<std::vector<double>>(array.values)[cell] *= factor;
          const Certificate refused = verify(shape, wrong);
          const Check* check = find_check(refused, "nested levels of numbers");
          ASSERT_TRUE(check);
          EXPECT_FALSE(check->passed) << seed << " cell " << cell << " " << level << " times " << factor;
          ++damaged;
        }
    }
  }
  EXPECT_GT(damaged, 200u);
}

TEST(Measures, WhatAFileSaysOfThemIsChecked) {
  const VoxelShape shape = shape_of(1);
  const Record data = core_with_two_measures(shape, 0.8, true);
  const auto fails = [&](const char* array, DataArray::Values values, const std::string& says) {
    Record wrong = data;
    for (DataArray& a : wrong.field_data)
      if (a.name == array) a.values = std::move(values);
    std::string text;
    for (const Check& check : verify(shape, wrong).checks)
      if (!check.passed) text += check.detail;
    EXPECT_NE(text.find(says), std::string::npos) << array << ": " << text;
  };
  using Names = std::vector<std::string>;
  fails("measures", Names{"lambda", "object_angle", "more"}, "'more'");
  fails("measures", Names{"lambda", "lambda", "object_angle"}, "twice");
  fails("measures", Names{"numbers", "object_angle"}, "do not have 'lambda'");
  fails("measures", std::vector<double>{1}, "'measures' is not text");
  fails("format_version", std::vector<std::int64_t>{3}, "version 3");
  fails("format_version", Names{"2"}, "'format_version'");
}

TEST(Measures, TheObjectAngleIsDerivedFromLambda) {
  const VoxelShape shape = shape_of(2);
  MedialAxis axis = voxel_core(shape);
  EXPECT_EQ(derived_measures(axis), (std::vector<std::string>{"object_angle", "cap_height"}));
  const Record derived_when_written = to_record(axis);
  const Measure angle = derived_measure(axis, "object_angle");
  ASSERT_TRUE(angle.value.complete(axis.complex) && angle.level.empty());
  const std::vector<double> of_points = find_array(derived_when_written.point_data, "object_angle")->numbers();
  for (std::uint32_t v = 0; v < axis.complex.vertex_count; ++v) {
    const double ratio = std::min(1.0, axis.measure().value.vertex[v] / axis.radius[v]);
    ASSERT_NEAR(angle.value.vertex[v], 2 * std::asin(ratio) * 180 / M_PI, 1e-9);
    ASSERT_EQ(static_cast<float>(angle.value.vertex[v]), of_points[v]);
  }
  // Added to the axis it prunes, and is written once, with its levels.
  axis.measures.push_back(angle);
  prune_levels(axis, "object_angle");
  EXPECT_EQ(topology(pruned(axis, 100, "object_angle").complex), topology(shape));
  const Record data = to_record(axis);
  EXPECT_EQ(std::ranges::count(data.cell_data, "object_angle", &DataArray::name), 1);
  EXPECT_TRUE(find_array(data.cell_data, "object_angle_level"));
  EXPECT_EQ(texts(data, "measures"), (std::vector<std::string>{"lambda", "object_angle", "cap_height"}));
  expect_refused([&] { derived_measure(axis, "no such"); }, "there are: object_angle");
  EXPECT_TRUE(derived_measures(MedialAxis()).empty());
}

TEST(Measures, MisuseIsRefused) {
  MedialAxis axis = axis_with_two_measures(shape_of(3));
  expect_refused([&] { prune_levels(axis, "absent"); }, "'absent'");
  expect_refused([&] { static_cast<void>(pruned(axis, 1, "absent")); }, "no level of absent");
  expect_refused([&] { static_cast<void>(axis.measure("absent")); }, "'absent'");
  for (const char* name : {"", "lambda", "kind", "radius", "lambda_level"}) {
    MedialAxis wrong = axis;
    wrong.measure("numbers").name = name;
    expect_refused([&] { to_record(wrong); }, fmt::format("the name '{}'", name));
  }
  axis.measure("numbers").value.edge.pop_back();
  expect_refused([&] { prune_levels(axis, "numbers"); }, "no numbers for each");
  expect_refused([&] { to_record(axis); }, "numbers");
}

TEST(Measures, FieldsOfALaterVersionAreNotedAndDropped) {
  Record data = to_record(axis_with_two_measures(shape_of(5)));
  Context context;
  std::vector<std::string> notes;
  context.note = [&](const std::string& sentence) { notes.push_back(sentence); };
  drop_unusable_fields(data, "axis.vtp", &context);
  EXPECT_TRUE(notes.empty());
  for (DataArray& array : data.field_data) {
    if (array.name == "format_version") array.values = std::vector<std::int64_t>{kFormatVersion + 1};
    if (array.name == "measures") array.values = std::vector<double>{1};
  }
  drop_unusable_fields(data, "axis.vtp", &context);
  ASSERT_EQ(notes.size(), 2u);
  EXPECT_EQ(notes[0],
            "the field 'format_version' of 'axis.vtp' is 3, not a version that is known here, and is ignored");
  EXPECT_EQ(notes[1], "the field 'measures' of 'axis.vtp' is not text, and is ignored");
  EXPECT_FALSE(find_array(data.field_data, "format_version") || find_array(data.field_data, "measures"));
}

// What `quench core --lambda 0 --full` wrote for five voxels before files had a version, as text.
const char* const kVersion1 = R"(<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian"><PolyData><FieldData>
<DataArray type="Int32" Name="sites" NumberOfComponents="3" format="ascii">0 0 0 1 0 0 0 1 0 1 1 0 0 2 0 1 2 0 0 0 1 1
0 1 0 1 1 1 1 1 0 2 1 1 2 1 0 0 2 1 0 2 0 1 2 1 1 2 0 2 2 1 2 2 0 0 3 1 0 3 0 1 3 1 1 3</DataArray>
<DataArray type="Int64" Name="dims" NumberOfComponents="3" format="ascii">1 2 3</DataArray>
<DataArray type="Float64" Name="spacing" NumberOfComponents="3" format="ascii">1.0 1.0 1.0</DataArray>
<DataArray type="Float64" Name="origin" NumberOfComponents="3" format="ascii">0.0 0.0 0.0</DataArray>
<DataArray type="Float64" Name="direction" NumberOfComponents="9" format="ascii">1.0 0.0 0.0 0.0 1.0 0.0 0.0 0.0
1.0</DataArray>
<Array type="String" Name="stage" format="ascii">99 111 114 101 0</Array>
<DataArray type="Float64" Name="lambda" format="ascii">0.0</DataArray>
<DataArray type="Float64" Name="lambda_chosen" format="ascii">0.0</DataArray>
<Array type="String" Name="lambda_rule" format="ascii">99 111 102 97 99 101 0</Array>
<DataArray type="Float64" Name="longest_side" format="ascii">3.0</DataArray>
<DataArray type="Float64" Name="reconstructed" format="ascii">1.0</DataArray>
<DataArray type="Int64" Name="euler" format="ascii">1</DataArray>
<DataArray type="Int64" Name="betti" NumberOfComponents="3" format="ascii">1 0 0</DataArray>
<Array type="String" Name="units" format="ascii">0</Array>
<Array type="String" Name="parameters" format="ascii">123 34 108 97 109 98 100 97 34 58 34 48 34 44 34 108 97 109 98
100 97 95 114 117 108 101 34 58 34 99 111 102 97 99 101 34 125 0</Array>
<Array type="String" Name="version" format="ascii">48 46 49 46 48 0</Array>
</FieldData>
<Piece NumberOfPoints="5" NumberOfVerts="1" NumberOfLines="1" NumberOfStrips="0" NumberOfPolys="1">
<PointData Scalars="radius">
<DataArray type="Float64" Name="radius" format="ascii">0.8660254037844386 0.8660254037844386 0.8660254037844386
0.8660254037844386 0.8660254037844386</DataArray>
<DataArray type="Float64" Name="lambda" format="ascii">0.5 0.5 0.7071067811865476 0.5 0.7071067811865476</DataArray>
<DataArray type="Float32" Name="object_angle" format="ascii">70.5287781 70.5287781 109.471222 70.5287781
109.471222</DataArray>
</PointData>
<CellData>
<DataArray type="UInt8" Name="kind" format="ascii">0 1 0</DataArray>
<DataArray type="Int32" Name="component" format="ascii">0 0 0</DataArray>
<DataArray type="Float64" Name="lambda" format="ascii">0.7071067811865476 0.7071067811865476 0.5</DataArray>
<DataArray type="Float64" Name="lambda_level" format="ascii">3.4e+38 0.7071067811865476 0.5</DataArray>
<DataArray type="Float32" Name="object_angle" format="ascii">109.471222 180 180</DataArray>
<DataArray type="Int32" Name="site_a" format="ascii">-1 -1 8</DataArray>
<DataArray type="Int32" Name="site_b" format="ascii">-1 -1 9</DataArray>
</CellData>
<Points>
<DataArray type="Float64" Name="Points" NumberOfComponents="3" format="ascii">0.0 0.0 0.0 0.0 1.0 0.0 0.0 0.0 1.0 0.0
1.0 1.0 0.0 0.0 2.0</DataArray>
</Points>
<Verts>
<DataArray type="Int32" Name="connectivity" format="ascii">4</DataArray>
<DataArray type="Int32" Name="offsets" format="ascii">1</DataArray>
</Verts>
<Lines>
<DataArray type="Int32" Name="connectivity" format="ascii">2 4</DataArray>
<DataArray type="Int32" Name="offsets" format="ascii">2</DataArray>
</Lines>
<Polys>
<DataArray type="Int32" Name="connectivity" format="ascii">0 1 3 2</DataArray>
<DataArray type="Int32" Name="offsets" format="ascii">4</DataArray>
</Polys>
</Piece>
</PolyData></VTKFile>
)";

TEST(Measures, FilesOfVersion1AreReadAsBefore) {
  const TemporaryFolder folder;
  const Record data = io::read_record(folder.write("old.vtp", kVersion1));
  EXPECT_FALSE(find_array(data.field_data, "measures") || find_array(data.field_data, "format_version"));
  Grid grid;
  grid.dims = {1, 2, 3};
  const VoxelShape shape = testing_shapes::from_predicate(grid, [](int, int y, int z) { return y == 0 || z < 2; });
  MedialAxis axis = voxel_core(shape);
  prune_levels(axis);
  MedialAxis read = medial_axis_of(data);
  ASSERT_TRUE(take_levels(read, data));
  EXPECT_EQ(read.points, axis.points);
  EXPECT_EQ(read.radius, axis.radius);
  EXPECT_EQ(read.complex.edges, axis.complex.edges);
  ASSERT_EQ(read.measures.size(), 1u);
  EXPECT_TRUE(read.measure().level == axis.measure().level);
  const Certificate certificate = verify(shape, data);
  for (const Check& check : certificate.checks) EXPECT_TRUE(check.passed) << check.name << ": " << check.detail;
  EXPECT_EQ(certificate.absent, (std::vector<std::string>{"point cap_height", "cell cap_height", "field format_version",
                                                          "field measures"}));
  EXPECT_NE(find_check(certificate, "nested levels")->detail.find("thinning by the keys"), std::string::npos);
  EXPECT_FALSE(find_check(certificate, "format and measures"));
  // What is written of the same axis now has these arrays and cap_height.
  const Record now = to_record(axis);
  for (const auto& [old_arrays, new_arrays] :
       {std::pair{&data.point_data, &now.point_data}, {&data.cell_data, &now.cell_data}}) {
    ASSERT_EQ(old_arrays->size() + 1, new_arrays->size());
    EXPECT_TRUE(find_array(*new_arrays, kCapHeight));
    for (const DataArray& array : *old_arrays) {
      const DataArray* same = find_array(*new_arrays, array.name);
      ASSERT_TRUE(same) << array.name;
      EXPECT_TRUE(array.values == same->values) << array.name;
    }
  }
}

}  // namespace measures_test
}  // namespace quench
