// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>

#include "data.h"
#include "quench/error.h"
#include "quench/io.h"
#include "quench/shape.h"
#include "random_shapes.h"
#include "temporary_folder.h"

namespace quench {
namespace volume_test {

// Every voxel of the grid, with a margin of one background voxel, labelled by flood fill.
struct Dense {
  std::array<int, 3> dims{};
  std::vector<char> inside;
  std::vector<int> label;                         // of foreground and background alike
  std::vector<std::vector<std::size_t>> members;  // per label

  explicit Dense(const VoxelShape& shape) {
    for (int a = 0; a < 3; ++a) dims[a] = static_cast<int>(shape.grid().dims[a]) + 2;
    inside.resize(static_cast<std::size_t>(dims[0] * dims[1] * dims[2]));
    each([&](int x, int y, int z) { inside[index(x, y, z)] = shape.contains(x - 1, y - 1, z - 1); });
    label.assign(inside.size(), -1);
    each([&](int x, int y, int z) {
      if (label[index(x, y, z)] < 0) fill(x, y, z);
    });
  }
  std::size_t index(int x, int y, int z) const { return static_cast<std::size_t>(x + dims[0] * (y + dims[1] * z)); }
  void each(const std::function<void(int, int, int)>& visit) const {
    for (int z = 0; z < dims[2]; ++z)
      for (int y = 0; y < dims[1]; ++y)
        for (int x = 0; x < dims[0]; ++x) visit(x, y, z);
  }
  void fill(int x0, int y0, int z0) {
    const char value = inside[index(x0, y0, z0)];
    const int number = static_cast<int>(members.size());
    members.emplace_back();
    std::vector<std::array<int, 3>> open{{x0, y0, z0}};
    label[index(x0, y0, z0)] = number;
    while (!open.empty()) {
      const auto [x, y, z] = open.back();
      open.pop_back();
      members.back().push_back(index(x, y, z));
      for (int d = 0; d < 27; ++d) {
        const int dx = d % 3 - 1, dy = d / 3 % 3 - 1, dz = d / 9 - 1;
        if (value && std::abs(dx) + std::abs(dy) + std::abs(dz) > 1) continue;
        const int x1 = x + dx, y1 = y + dy, z1 = z + dz;
        if (x1 < 0 || y1 < 0 || z1 < 0 || x1 >= dims[0] || y1 >= dims[1] || z1 >= dims[2]) continue;
        if (inside[index(x1, y1, z1)] != value || label[index(x1, y1, z1)] >= 0) continue;
        label[index(x1, y1, z1)] = number;
        open.push_back({x1, y1, z1});
      }
    }
  }
  VoxelShape shape(const Grid& grid) const {
    return testing_shapes::from_predicate(grid,
                                          [&](int x, int y, int z) { return inside[index(x + 1, y + 1, z + 1)] != 0; });
  }
};

bool same(const VoxelShape& a, const VoxelShape& b) {
  for (std::int64_t z = 0; z < a.grid().dims[2]; ++z)
    for (std::int64_t y = 0; y < a.grid().dims[1]; ++y)
      if (!std::ranges::equal(a.row(y, z), b.row(y, z))) return false;
  return a.grid().dims == b.grid().dims;
}

template <class T>
Volume line(std::vector<T> values) {
  Volume volume;
  volume.grid.dims = {static_cast<std::int64_t>(values.size()), 1, 1};
  volume.samples = std::move(values);
  return volume;
}

std::string pattern(const VoxelShape& shape) {
  std::string text;
  for (std::int64_t x = 0; x < shape.grid().dims[0]; ++x) text += shape.contains(x, 0, 0) ? '#' : '.';
  return text;
}

template <class T>
std::string by_threshold(std::vector<T> values, double t) {
  ForegroundOptions options;
  options.threshold = t;
  return pattern(foreground(line(std::move(values)), options));
}

template <class T>
std::string by_label(std::vector<T> values, std::int64_t label) {
  ForegroundOptions options;
  options.label = label;
  return pattern(foreground(line(std::move(values)), options));
}

std::string message(ErrorCode code, const std::function<void()>& body) {
  try {
    body();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), code) << e.what();
    EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos) << e.what();
    return e.what();
  }
  ADD_FAILURE() << "no error";
  return {};
}

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST(Foreground, ThresholdIsExactForEveryType) {
  EXPECT_EQ(by_threshold<std::uint8_t>({0, 1, 2, 255}, 1.5), "..##");
  EXPECT_EQ(by_threshold<std::uint8_t>({0, 1, 2, 255}, 2), "..##");
  EXPECT_EQ(by_threshold<std::uint8_t>({0, 1, 2, 255}, -7), "####");
  EXPECT_EQ(by_threshold<std::int8_t>({-128, -1, 0, 127}, -1.5), ".###");
  EXPECT_EQ(by_threshold<std::int8_t>({-128, -1, 0, 127}, -128), "####");
  const std::int64_t big = (std::int64_t{1} << 60) + 1;
  EXPECT_EQ(by_threshold<std::int64_t>({big - 2, big - 1, big}, static_cast<double>(big - 1)), ".##");
  EXPECT_EQ(by_threshold<std::uint64_t>({0, ~std::uint64_t{0}}, 0x1p63), ".#");
  EXPECT_EQ(by_threshold<float>({0.1f, 0.2f, std::nanf("")}, 0.1), "##.");  // 0.1f is above 0.1
  EXPECT_EQ(by_threshold<float>({0.7f, 0.8f}, 0.7), ".#");                  // 0.7f is below 0.7
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(by_threshold<double>({-infinity, 0, infinity, std::nan("")}, infinity), "..#.");
  EXPECT_EQ(by_threshold<double>({-infinity, 0, infinity, std::nan("")}, -infinity), "###.");
}

TEST(Foreground, LabelIsExactForEveryType) {
  EXPECT_EQ(by_label<std::uint8_t>({0, 3, 4, 3}, 3), ".#.#");
  EXPECT_EQ(by_label<std::uint8_t>({0, 3, 4, 0}, 0), "#..#");
  const std::int64_t big = (std::int64_t{1} << 53) + 1;
  EXPECT_EQ(by_label<std::int64_t>({big - 1, big, big + 1}, big), ".#.");
  EXPECT_EQ(by_label<std::uint64_t>({1, std::uint64_t{1} << 63}, 1), "#.");
  EXPECT_EQ(by_label<float>({1.0f, 1.5f, 2.0f}, 2), "..#");
  ForegroundOptions options;
  options.label = 256;
  const auto what = message(ErrorCode::input, [&] { foreground(line<std::uint8_t>({0, 255}), options); });
  EXPECT_TRUE(has(what, "value 256") && has(what, "from 0 to 255") && has(what, "give another threshold or label"))
      << what;
  options.label = big;
  message(ErrorCode::input, [&] { foreground(line<double>({static_cast<double>(big)}), options); });
}

TEST(Foreground, WithoutRuleTheImageMustHaveTwoValues) {
  EXPECT_EQ(pattern(foreground(line<std::uint8_t>({0, 255, 0}), {})), ".#.");
  EXPECT_EQ(pattern(foreground(line<std::uint8_t>({7, 7}), {})), "##");
  EXPECT_EQ(pattern(foreground(line<float>({-1, 0, -1}), {})), "#.#");
  EXPECT_EQ(pattern(foreground(line<std::int16_t>({3, 5, 3}), {})), "###");
  const auto three = message(ErrorCode::usage, [] { foreground(line<std::uint8_t>({0, 1, 2}), {}); });
  EXPECT_TRUE(has(three, "give a threshold T") && has(three, "a label K") && has(three, "from 0 to 2")) << three;
  message(ErrorCode::usage, [] { foreground(line<std::uint8_t>({5, 1, 3}), {}); });
  message(ErrorCode::usage, [] { foreground(line<std::uint8_t>({1, 5, 3}), {}); });
  EXPECT_TRUE(has(message(ErrorCode::input, [] { foreground(line<std::uint8_t>({0, 0}), {}); }), "from 0 to 0"));
  EXPECT_TRUE(
      has(message(ErrorCode::input, [] { foreground(line<double>({std::nan("")}), {}); }), "no values but NaN"));
}

TEST(Foreground, RefusesContradictions) {
  ForegroundOptions both;
  both.threshold = 1;
  both.label = 1;
  message(ErrorCode::usage, [&] { foreground(line<std::uint8_t>({0, 1}), both); });
  ForegroundOptions nan;
  nan.threshold = std::nan("");
  EXPECT_EQ(message(ErrorCode::usage,
                    [&] {
                      foreground(line<std::uint8_t>({0, 1}), nan);
                    }),
            "the threshold is not a number");
  ForegroundOptions high;
  high.threshold = 300;
  const auto what = message(ErrorCode::input, [&] { foreground(line<std::uint8_t>({3, 90}), high); });
  EXPECT_TRUE(has(what, "at least 300") && has(what, "from 3 to 90")) << what;
  ForegroundOptions inverted;
  inverted.invert = true;
  EXPECT_EQ(pattern(foreground(line<std::uint8_t>({0, 1, 0}), inverted)), "#.#");
  message(ErrorCode::input, [&] { foreground(line<std::uint8_t>({1, 1}), inverted); });
}

TEST(Clean, LargestComponentEqualsFloodFill) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const VoxelShape shape = testing_shapes::random_shape(seed, 9);
    Dense dense(shape);
    std::size_t largest = 0, components = 0;
    for (std::size_t m = 0; m < dense.members.size(); ++m)
      if (dense.inside[dense.members[m][0]]) {
        ++components;
        if (!dense.inside[dense.members[largest][0]] || dense.members[m].size() > dense.members[largest].size())
          largest = m;
      }
    for (std::size_t m = 0; m < dense.members.size(); ++m)
      if (m != largest)
        for (const std::size_t i : dense.members[m]) dense.inside[i] = 0;
    ForegroundOptions options;
    options.largest_component = true;
    ForegroundReport report;
    const VoxelShape result = clean(shape, options, &report);
    result.validate();
    EXPECT_TRUE(same(result, dense.shape(shape.grid()))) << "seed " << seed;
    EXPECT_EQ(report.components_removed, static_cast<std::int64_t>(components) - 1);
    EXPECT_EQ(report.voxels_before, shape.voxel_count());
    EXPECT_EQ(report.voxels_removed, shape.voxel_count() - result.voxel_count());
    EXPECT_EQ(much_dropped(report).empty(),
              20 * report.voxels_removed < std::max<std::int64_t>(report.voxels_before, 1))
        << "seed " << seed;
  }
}

TEST(Clean, MinComponentEqualsFloodFill) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const VoxelShape shape = testing_shapes::random_shape(seed, 9);
    Dense dense(shape);
    const std::int64_t least = 2 + static_cast<std::int64_t>(seed % 7);
    std::int64_t removed = 0, kept = 0;
    for (const auto& members : dense.members)
      if (dense.inside[members[0]]) {
        const bool drop = static_cast<std::int64_t>(members.size()) < least;
        ++(drop ? removed : kept);
        if (drop)
          for (const std::size_t i : members) dense.inside[i] = 0;
      }
    ForegroundOptions options;
    options.min_component = least;
    ForegroundReport report;
    if (kept == 0) {
      EXPECT_TRUE(has(message(ErrorCode::input, [&] { clean(shape, options); }), "dropping components of fewer than"));
      continue;
    }
    EXPECT_TRUE(same(clean(shape, options, &report), dense.shape(shape.grid()))) << "seed " << seed;
    EXPECT_EQ(report.components_removed, removed);
  }
}

TEST(Clean, FillCavitiesEqualsFloodFill) {
  std::int64_t cavities_seen = 0;
  for (std::uint64_t seed = 0; seed < 600; ++seed) {
    const VoxelShape random = testing_shapes::random_shape(seed, 8);
    // Every other shape inside out within its box: foreground parts become cavities.
    const VoxelShape shape =
        seed % 8 < 4 ? random : testing_shapes::from_predicate(random.grid(), [&](int x, int y, int z) {
          return !random.contains(x, y, z);
        });
    Dense dense(shape);
    const int outside = dense.label[0];
    std::int64_t cavities = 0, voxels = 0;
    for (std::size_t m = 0; m < dense.members.size(); ++m)
      if (!dense.inside[dense.members[m][0]] && static_cast<int>(m) != outside) {
        ++cavities;
        voxels += static_cast<std::int64_t>(dense.members[m].size());
        for (const std::size_t i : dense.members[m]) dense.inside[i] = 1;
      }
    ForegroundOptions options;
    options.fill_cavities = true;
    ForegroundReport report;
    const VoxelShape result = clean(shape, options, &report);
    result.validate();
    EXPECT_TRUE(same(result, dense.shape(shape.grid()))) << "seed " << seed;
    EXPECT_EQ(report.cavities_filled, cavities) << "seed " << seed;
    EXPECT_EQ(report.voxels_filled, voxels) << "seed " << seed;
    cavities_seen += cavities;
  }
  EXPECT_GT(cavities_seen, 50);
}

TEST(Clean, SharesInPercent) {
  EXPECT_EQ(percent_text(0, 10), "0%");
  EXPECT_EQ(percent_text(1, 100000), "0.001%");
  EXPECT_EQ(percent_text(36, 100), "36%");
  EXPECT_EQ(percent_text(99999, 100000), "more than 99%");
  EXPECT_EQ(percent_text(7, 7), "100%");
}

TEST(Clean, WithoutRequestChangesNothing) {
  const VoxelShape shape = testing_shapes::random_shape(4);
  ForegroundReport report;
  EXPECT_TRUE(same(clean(shape, {}, &report), shape));
  EXPECT_EQ(report.components_removed + report.voxels_removed + report.cavities_filled + report.voxels_filled, 0);
}

// Whole thresholds stay exact where a double rounds them, for samples of every type.
template <class T>
std::int64_t count_at_least(const std::vector<T>& samples, const Threshold& threshold) {
  Volume volume;
  volume.grid.dims = {static_cast<std::int64_t>(samples.size()), 1, 1};
  volume.samples = samples;
  ForegroundOptions options;
  options.threshold = threshold;
  try {
    return foreground(volume, options).voxel_count();
  } catch (const Error&) {
    return 0;
  }
}

TEST(Foreground, WholeThresholdsAreExact) {
  constexpr std::int64_t odd = (std::int64_t{1} << 53) + 1;
  constexpr std::int64_t low = std::numeric_limits<std::int64_t>::min(),
                         high = std::numeric_limits<std::int64_t>::max();
  const std::vector<std::int64_t> wide{low, -odd, odd - 1, odd, high};
  EXPECT_EQ(count_at_least(wide, low), 5);
  EXPECT_EQ(count_at_least(wide, low + 1), 4);
  EXPECT_EQ(count_at_least(wide, -odd), 4);
  EXPECT_EQ(count_at_least(wide, 1 - odd), 3);
  EXPECT_EQ(count_at_least(wide, odd), 2);
  EXPECT_EQ(count_at_least(wide, high), 1);
  EXPECT_EQ(count_at_least(wide, static_cast<std::uint64_t>(high) + 1), 0);
  const std::vector<std::uint64_t> natural{0, std::uint64_t{1} << 63, ~std::uint64_t{0}};
  EXPECT_EQ(count_at_least(natural, low), 3);
  EXPECT_EQ(count_at_least(natural, std::int64_t{1}), 2);
  EXPECT_EQ(count_at_least(natural, ~std::uint64_t{0}), 1);
  const std::vector<std::uint8_t> bytes{0, 7, 255};
  EXPECT_EQ(count_at_least(bytes, std::int64_t{255}), 1);
  EXPECT_EQ(count_at_least(bytes, std::int64_t{256}), 0);
  EXPECT_EQ(count_at_least(bytes, std::int64_t{-1}), 3);
  const std::vector<double> doubles{0x1p53, 0x1p53 + 2, 0x1p64, -HUGE_VAL};
  EXPECT_EQ(count_at_least(doubles, odd), 2);
  EXPECT_EQ(count_at_least(doubles, ~std::uint64_t{0}), 1);
  const std::vector<float> floats{0x1p53F, 0x1p54F, 16777218.F, 0x1p63F};
  EXPECT_EQ(count_at_least(floats, std::int64_t{16777217}), 4);
  EXPECT_EQ(count_at_least(floats, odd), 2);
  EXPECT_EQ(count_at_least(floats, high), 1);
}

// Real data: the counts of the volume table of the data's README and of references/expected_core_sizes.tsv.
void expect_counts(const char* name, double threshold, std::int64_t voxels, std::int64_t components) {
  ForegroundOptions options;
  options.threshold = threshold;
  const Volume volume = io::read_volume(data_file(name));
  EXPECT_EQ(foreground(volume, options).voxel_count(), voxels) << name;
  options.largest_component = true;
  ForegroundReport report;
  foreground(volume, options, &report);
  EXPECT_EQ(report.components_removed + 1, components) << name;
}

TEST(RealVolumes, CountsOfVol) {
  REQUIRE_DATA("volumes/Al.100.vol");
  expect_counts("volumes/Al.100.vol", 1, 70413, 1);
  expect_counts("volumes/xyz-dragon-256.vol", 1, 422542, 1);
  expect_counts("volumes/lobster.vol", 30, 316628, 147);
  expect_counts("volumes/lobster.vol", 80, 157904, 396);
}

TEST(RealVolumes, CountsThroughItk) {
  REQUIRE_DATA("volumes/maize_root_ct.nrrd");
  expect_counts("volumes/maize_root_ct.nrrd", 14, 638866, 2048);
  expect_counts("volumes/maize_root_ct.nrrd", 20, 189697, 3116);
  expect_counts("volumes/emd_5625.map", 1.991, 10609, 5);
  expect_counts("volumes/torsoLabel.nii.gz", 1, 859557, 6);
  expect_counts("references/bunny7.nrrd", 1, 305679, 1);
}

TEST(RealVolumes, SpacingAndOriginAreKept) {
  REQUIRE_DATA("volumes/torsoLabel.nii.gz");
  const Volume torso = io::read_volume(data_file("volumes/torsoLabel.nii.gz"));
  EXPECT_EQ(torso.grid.dims, (std::array<std::int64_t, 3>{384, 320, 89}));
  EXPECT_LT((torso.grid.spacing - Vec3(0.782, 0.782, 5)).cwiseAbs().maxCoeff(), 1e-3);
  EXPECT_EQ(torso.coordinates.units, "mm");
  EXPECT_NO_THROW(integer_spacing(torso.grid));
  EXPECT_LT((torso.grid.direction.transpose() * torso.grid.direction - Mat3::Identity()).norm(), 1e-14);
  EXPECT_TRUE(std::holds_alternative<std::vector<std::uint8_t>>(torso.samples));
  const Volume bunny = io::read_volume(data_file("references/bunny7.nrrd"));
  EXPECT_EQ(bunny.grid.dims, (std::array<std::int64_t, 3>{117, 116, 91}));
  EXPECT_EQ(bunny.grid.origin, Vec3(6, 7, 19));
  EXPECT_EQ(bunny.grid.direction, Mat3::Identity());
  io::VolumeReadOptions options;
  options.spacing = Vec3(1, 2, 3);
  EXPECT_EQ(io::read_volume(data_file("references/bunny7.nrrd"), options).grid.spacing, Vec3(1, 2, 3));
  const Volume map = io::read_volume(data_file("volumes/emd_5625.map"));
  EXPECT_TRUE(std::holds_alternative<std::vector<float>>(map.samples));
}

}  // namespace volume_test
}  // namespace quench
