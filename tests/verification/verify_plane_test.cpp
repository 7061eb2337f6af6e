// SPDX-License-Identifier: Apache-2.0
// Results of the plane: those of the library pass, and every array that is changed in one place is noticed or was named
// as not checked.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <set>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "certificates.h"
#include "plane_shapes.h"
#include "quench/pipeline.h"
#include "quench/shape.h"
#include "quench/verify.h"
#include "random_shapes.h"

namespace quench {
namespace verify_plane_test {

using namespace testing_certificates;
using namespace testing_planes;

constexpr double kForever = std::numeric_limits<double>::infinity();

struct PlaneResult {
  std::string name;
  VoxelShape shape;
  Record data;
  double longest_side;
};

pipeline::LoadedShape loaded(const VoxelShape& shape, int subdivide = 1) {
  pipeline::ShapeOptions options;
  options.subdivide = subdivide;
  pipeline::LoadedShape result = pipeline::shape_of(VoxelShape(shape), shape.grid(), options);
  result.coordinates = {"mm", "LPS", true};
  return result;
}

// Core and skeleton of all stages.
std::vector<PlaneResult> results_of(const std::string& name, pipeline::LoadedShape shape,
                                    const pipeline::RunOptions& options) {
  pipeline::RunResult run = pipeline::run(shape, options);
  Record skeleton = pipeline::skeleton_file(run.axis.skeleton, run.axis.file);
  return {{name + " core", shape.shape, std::move(run.axis.file), shape.longest_side},
          {name + " skeleton", shape.shape, std::move(skeleton), shape.longest_side}};
}

VerifyOptions whole_file(const PlaneResult& result) {
  VerifyOptions options;
  options.longest_side = result.longest_side;
  options.y_down = true;
  options.format_holds_all = true;
  return options;
}

Certificate certificate_of(const PlaneResult& result, const Record& data) {
  return verify(result.shape, data, whole_file(result));
}

pipeline::RunOptions by(std::string_view measure, std::optional<double> threshold, bool full = false) {
  pipeline::RunOptions options;
  options.axis.pruning.measure = measure;
  if (threshold) options.axis.pruning.threshold = pipeline::world_length(*threshold);
  options.axis.full = full;
  return options;
}

void expect_verified(const std::vector<PlaneResult>& results) {
  for (const PlaneResult& result : results) {
    const Certificate certificate = certificate_of(result, result.data);
    EXPECT_TRUE(certificate.passed() && certificate.absent.empty()) << result.name << "\n" << text(certificate);
  }
}

TEST(VerifyPlane, PassesResultsOfRandomImages) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const pipeline::LoadedShape shape = loaded(random_plane_shape(seed, 40));
    const std::string where = fmt::format("seed {}", seed);
    expect_verified(results_of(where, shape, {}));
    expect_verified(results_of(where + " detail", shape, by(kDetail, 0.4 + static_cast<double>(seed % 5))));
    expect_verified(results_of(where + " lambda", shape, by(kLambda, 0.5 * static_cast<double>(seed % 7))));
    expect_verified(results_of(where + " full", shape, by(seed % 2 ? kDetail : kLambda, 1.5, true)));
    pipeline::RunOptions balls = by(kLambda, 2);
    balls.axis.rule = LambdaRule::ball;
    balls.graph.smooth = 0;
    balls.skeleton.full_tips = false;
    expect_verified(results_of(where + " balls", shape, balls));
  }
}

TEST(VerifyPlane, PassesResultsOfOblongPixels) {
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    const std::array<double, 2> spacing{0.5 + static_cast<double>(seed % 3), 1 + 0.25 * static_cast<double>(seed % 4)};
    const VoxelShape shape = random_plane_shape(seed, 30, spacing);
    expect_verified(results_of(fmt::format("oblong {}", seed), loaded(shape), {}));
    expect_verified(results_of(fmt::format("subdivided {}", seed), loaded(shape, 3), by(kDetail, 0.7, seed % 2 == 0)));
  }
}

TEST(VerifyPlane, PassesInAnyWorld) {
  Grid grid = plane_grid(31, 23, {0.75, 0.5});
  grid.origin = {-1200, 33.5, 17};
  grid.direction << 0.6, -0.8, 0, 0.8, 0.6, 0, 0, 0, 1;
  const VoxelShape shape = plane_shape(grid, [](int x, int y) {
    return x > 0 && x < 30 && y > 0 && y < 22 && (x < 12 || y < 15) && (x - 6) * (x - 6) + (y - 6) * (y - 6) > 9;
  });
  expect_verified(results_of("turned", loaded(shape), {}));
  grid.origin = {3e9, -7e9, 1e9};
  const VoxelShape far = plane_shape(grid, [&](int x, int y) { return shape.contains(x, y, 0); });
  expect_verified(results_of("far", loaded(far), {}));
}

TEST(VerifyPlane, AResultOfAnotherDimensionIsOneFailedCheck) {
  const VoxelShape image = random_plane_shape(5, 20);
  const VoxelShape solid = testing_shapes::random_shape(5, 8);
  const Record of_image = results_of("image", loaded(image), {})[0].data;
  pipeline::LoadedShape voxels = pipeline::shape_of(VoxelShape(solid), solid.grid(), {});
  const Record of_solid = pipeline::core_file(pipeline::core_of(voxels));
  Record unsaid = of_image;
  std::erase_if(unsaid.field_data, [](const DataArray& array) { return array.name == "dimension"; });
  for (const auto& [shape, data] : {std::pair{&image, &of_solid}, {&solid, &of_image}, {&image, &unsaid}}) {
    const Certificate certificate = verify(*shape, *data);
    EXPECT_EQ(failed(certificate).size(), 1u) << text(certificate);
    EXPECT_LE(certificate.checks.size(), 1u) << text(certificate);
  }
}

// A plate, a tower, a hole, two parts that touch in a corner, a pixel by itself.
VoxelShape plate(const Grid& grid) {
  return plane_shape(grid, [](int x, int y) {
    const bool body = x >= 1 && x < 14 && y >= 1 && y < 9, hole = x >= 4 && x < 6 && y >= 3 && y < 6;
    const bool tower = x >= 8 && x < 12 && y >= 9 && y < 19, step = x == 12 && y == 9;
    const bool corner = x >= 14 && x < 18 && y >= 9 && y < 12, alone = x == 19 && y == 2;
    return (body && !hole) || tower || step || corner || alone;
  });
}

std::vector<PlaneResult> damaged_results() {
  std::vector<PlaneResult> all;
  const auto add = [&](const std::string& name, const VoxelShape& shape, pipeline::RunOptions options) {
    options.graph.smooth = 0;  // without the array of branches no point is taken for a smoothed one
    for (PlaneResult& result : results_of(name, loaded(shape), options)) all.push_back(std::move(result));
  };
  Grid square = plane_grid(21, 20), oblong = plane_grid(21, 20, {1, 1.5});
  square.origin = {3, -4, 0};
  oblong.direction << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  add("plate", plate(square), {});
  pipeline::RunOptions edgy;
  add("larger detail", plate(square), by(kDetail, 1.9));
  add("full by detail", plate(square), by(kDetail, std::nullopt, true));
  add("lambda", plate(oblong), by(kLambda, 1.3));
  add("full by lambda", plate(oblong), by(kLambda, 1.3, true));
  edgy.skeleton.theta1 = pipeline::world_length(0.5);
  edgy.axis.pruning = {kLambda, pipeline::world_length(0.8)};
  edgy.axis.rule = LambdaRule::ball;
  add("balls", random_plane_shape(7, 24), edgy);
  add("holes", random_plane_shape(14, 26), {});
  return all;
}

std::set<std::string> left_out(const Certificate& certificate) {
  std::set<std::string> names;
  for (const UncheckedArray& array : certificate.not_checked) names.insert(array.array);
  return names;
}

struct Arrays {
  const char* of;
  std::vector<DataArray> Record::*list;
};
constexpr Arrays kArrays[]{
    {"point", &Record::point_data}, {"cell", &Record::cell_data}, {"field", &Record::field_data}};

struct Change {
  const char* name;
  std::function<double(double)> of;
};
const std::vector<Change>& changes() {
  static const std::vector<Change> all{
      {"half", [](double x) { return 0.5 * x; }},   {"times 1.5", [](double x) { return 1.5 * x; }},
      {"plus 1", [](double x) { return x + 1; }},   {"negative", [](double x) { return -x; }},
      {"zero", [](double) { return 0.0; }},         {"not a number", [](double) { return std::nan(""); }},
      {"infinite", [](double) { return kForever; }}};
  return all;
}

// False when nothing is different afterwards; what stands for infinity may be any number above it.
template <class T>
bool change_row(std::vector<T>& values, std::size_t row, const Change& change) {
  const auto before = static_cast<double>(values[row]), after = change.of(before);
  if constexpr (!std::is_floating_point_v<T>)
    if (!std::isfinite(after) || after != std::floor(after) || (std::is_unsigned_v<T> && after < 0)) return false;
  values[row] = static_cast<T>(after);
  return !(static_cast<double>(values[row]) == before) &&
         !(before >= kInfiniteLevelInFiles && after >= kInfiniteLevelInFiles);
}

class EveryArrayOfPlane {
 public:
  explicit EveryArrayOfPlane(const PlaneResult& result) : result_(result) {}

  int run() {
    for (const Arrays& arrays : kArrays)
      for (std::size_t a = 0; a < (result_.data.*arrays.list).size(); ++a)
        std::visit([&](const auto& values) { change_array(arrays, a, values); }, (result_.data.*arrays.list)[a].values);
    return tried_;
  }

 private:
  void change_array(const Arrays& arrays, std::size_t a, const std::vector<std::string>& words) {
    for (const char* word : {"", "no such word", "core", "skeleton", "coface", "ball", "up"})
      if (word != words[0]) expect_noticed(arrays, a, std::vector<std::string>{word}, fmt::format("'{}'", word));
  }
  template <class T>
  void change_array(const Arrays& arrays, std::size_t a, const std::vector<T>& values) {
    for (const Change& change : changes())
      for (int row = 0; row < 4 && !values.empty(); ++row) {
        std::vector<T> changed = values;
        const std::size_t at = random(values.size());
        if (!change_row(changed, at, change)) continue;
        // On the way of branches radii are checked to the diagonal of a pixel.
        const bool is_length = arrays.of == std::string_view("point") && result_.name.ends_with("skeleton");
        if (!is_length || !(std::abs(static_cast<double>(changed[at]) - static_cast<double>(values[at])) < 2))
          expect_noticed(arrays, a, std::move(changed), fmt::format("{}, row {}", change.name, at));
      }
  }
  void expect_noticed(const Arrays& arrays, std::size_t a, DataArray::Values values, const std::string& how) {
    Record data = result_.data;
    DataArray& array = (data.*arrays.list)[a];
    array.values = std::move(values);
    ++tried_;
    const Certificate certificate = certificate_of(result_, data);
    EXPECT_TRUE(!certificate.passed() || left_out(certificate).contains(fmt::format("{} {}", arrays.of, array.name)))
        << result_.name << ": " << arrays.of << " array " << array.name << ", " << how;
  }
  std::size_t random(std::size_t below) {
    state_ = state_ * 6364136223846793005ull + 1442695040888963407ull;
    return static_cast<std::size_t>(state_ >> 33) % below;
  }

  const PlaneResult& result_;
  std::uint64_t state_ = 1;
  int tried_ = 0;
};

TEST(VerifyPlane, ChangesOfEveryArrayAreNoticed) {
  int tried = 0;
  for (const PlaneResult& result : damaged_results()) {
    const Certificate certificate = certificate_of(result, result.data);
    EXPECT_TRUE(certificate.passed()) << result.name << "\n" << text(certificate);
    tried += EveryArrayOfPlane(result).run();
  }
  EXPECT_GT(tried, 3000);
}

// What no check can tell may grow only on purpose.
TEST(VerifyPlane, OnlyTheseArraysAreLeftOut) {
  const std::set<std::string> of_both{"field units",      "field lambda_chosen", "field detail_chosen",
                                      "field parameters", "field version",       "field SPACE"};
  std::set<std::string> of_cores = of_both, of_skeletons = of_both;
  of_cores.insert({"point detail", "cell detail"});
  of_skeletons.insert({"point mgf", "point burn_time", "cell erosion_thickness", "cell curve_level", "field theta1",
                       "field theta1_radii", "field smooth", "field tips", "field lambda", "field detail"});
  for (const PlaneResult& result : damaged_results()) {
    const bool core = result.name.ends_with("core");
    for (const std::string& name : left_out(certificate_of(result, result.data)))
      EXPECT_TRUE((core ? of_cores : of_skeletons).contains(name)) << result.name << ": " << name;
  }
}

TEST(VerifyPlane, EveryArrayThatIsRemovedIsNoticedOrListed) {
  const std::set<std::string> needed{"point radius",      "field dims",      "field spacing",    "field origin",
                                     "field direction",   "field dimension", "field sites",      "cell lambda_level",
                                     "cell detail_level", "cell detail",     "point detail",     "cell site_a",
                                     "cell site_b",       "field theta1",    "cell curve_level", "field stage"};
  const std::set<std::string> needed_of_cores{"field lambda", "field detail", "field lambda_rule", "point lambda",
                                              "cell lambda"};
  for (const PlaneResult& result : damaged_results()) {
    const bool core = result.name.ends_with("core");
    for (const Arrays& arrays : kArrays)
      for (std::size_t a = 0; a < (result.data.*arrays.list).size(); ++a) {
        Record data = result.data;
        const std::string name = fmt::format("{} {}", arrays.of, (data.*arrays.list)[a].name);
        if (name == "field SPACE" || name == "field stage") continue;
        (data.*arrays.list).erase((data.*arrays.list).begin() + static_cast<std::ptrdiff_t>(a));
        const Certificate certificate = certificate_of(result, data);
        const bool fails = needed.contains(name) || (core && needed_of_cores.contains(name)) ||
                           (!core && name == "cell erosion_thickness");
        EXPECT_EQ(certificate.passed(), !fails) << result.name << " without " << name << "\n" << text(certificate);
        if (name == "field dimension") continue;  // nothing else is checked
        if (!core && name == "point mgf") continue;
        if (!core && name == "field reconstructed") continue;  // only where the shape was at hand
        EXPECT_EQ(certificate.absent, std::vector<std::string>{name}) << result.name << "\n" << text(certificate);
      }
  }
}

TEST(VerifyPlane, AMovedPointIsNoticed) {
  for (const PlaneResult& result : damaged_results()) {
    const bool core = result.name.ends_with("core");
    // Of a skeleton only that it is inside and about in the middle.
    for (const Vec3& step :
         {core ? Vec3(1e-3, 0, 0) : Vec3(4, 4, 0), core ? Vec3(0, -1, 0) : Vec3(4, -4, 0), Vec3(0, 0, 1e-4)}) {
      Record moved = result.data;
      moved.points[moved.points.size() / 2] += step;
      EXPECT_FALSE(certificate_of(result, moved).passed()) << result.name;
    }
  }
}

// Without any one of its lines, or with one too many.
TEST(VerifyPlane, AMissingEdgeIsNoticed) {
  for (const PlaneResult& result : damaged_results()) {
    const std::size_t verts = result.data.verts.size();
    for (std::size_t l = 0; l < result.data.lines.size(); l += 5) {
      Record cut = result.data;
      cut.lines.erase(cut.lines.begin() + static_cast<std::ptrdiff_t>(l));
      for (DataArray& array : cut.cell_data)
        std::visit([&](auto& values) { values.erase(values.begin() + static_cast<std::ptrdiff_t>(verts + l)); },
                   array.values);
      EXPECT_FALSE(certificate_of(result, cut).passed()) << result.name << " without line " << l;
    }
  }
}

// A free end of a full core that is cut off leaves its topology as it was.
TEST(VerifyPlane, AMissingEndOfAFullCoreIsNoticed) {
  const PlaneResult full = results_of("full", loaded(plate(plane_grid(21, 20))), by(kLambda, 0))[0];
  std::vector<std::uint32_t> degree(full.data.points.size(), 0);
  for (const auto& line : full.data.lines)
    for (const std::uint32_t v : line) ++degree[v];
  int tried = 0;
  for (std::size_t l = 0; l < full.data.lines.size(); ++l) {
    const auto& line = full.data.lines[l];
    if (degree[line[0]] != 1 && degree[line[1]] != 1) continue;
    const std::uint32_t end = degree[line[0]] == 1 ? line[0] : line[1];
    const std::size_t row = full.data.verts.size() + l;
    Record cut = full.data;
    cut.lines.erase(cut.lines.begin() + static_cast<std::ptrdiff_t>(l));
    for (DataArray& array : cut.cell_data)
      std::visit([&](auto& values) { values.erase(values.begin() + static_cast<std::ptrdiff_t>(row)); }, array.values);
    cut.points.erase(cut.points.begin() + end);
    for (DataArray& array : cut.point_data)
      std::visit([&](auto& values) { values.erase(values.begin() + end); }, array.values);
    for (auto& other : cut.lines)
      for (std::uint32_t& v : other) v -= v > end;
    for (std::uint32_t& v : cut.verts) v -= v > end;
    const Names wrong = failed(certificate_of(full, cut));
    EXPECT_TRUE(wrong.contains("legal pruning")) << l;
    ++tried;
  }
  EXPECT_GT(tried, 5);
}

}  // namespace verify_plane_test
}  // namespace quench
