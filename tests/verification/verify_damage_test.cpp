// SPDX-License-Identifier: Apache-2.0
// Every array of a result is changed in many ways: `verify` must notice, or have said that it does not check the array.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "certificates.h"
#include "full_run.h"
#include "quench/burn.h"
#include "quench/pipeline.h"
#include "quench/samples.h"
#include "quench/shape.h"
#include "quench/skeleton.h"
#include "quench/verify.h"
#include "random_shapes.h"

namespace quench {
namespace verify_damage_test {

using namespace testing_certificates;

using pipeline::world_length;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Result {
  std::string name;
  VoxelShape shape;
  Record data;
  std::optional<Surface> surface = {};  // that it is fitted to
};

VerifyOptions options_for(const VoxelShape& shape) {
  VerifyOptions options;
  options.longest_side = shape.longest_side();
  return options;
}

// Voxels of 1 x 2 x 1: a plate with a hole, a tower and a pair of loose voxels.
VoxelShape plate() {
  Grid grid;
  grid.dims = {12, 7, 6};
  grid.spacing = {1, 2, 1};
  grid.origin = {3, -4, 5};
  return testing_shapes::from_predicate(grid, [](int x, int y, int z) {
    const bool body = x >= 1 && x < 8 && y >= 1 && y < 6 && z >= 1 && z < 4;
    const bool hole = x >= 3 && x < 4 && y >= 3 && y < 4;
    const bool tower = x >= 5 && x < 8 && y >= 2 && y < 4 && z >= 1 && z < 6;
    const bool loose = x >= 9 && x < 11 && y == 4 && z == 2;
    return (body && !hole) || tower || loose;
  });
}

// A cavity makes a closed pocket, on which a fin stands.
VoxelShape hollow() {
  Grid grid;
  grid.dims = {12, 8, 7};
  return testing_shapes::from_predicate(grid, [](int x, int y, int z) {
    const bool in = x >= 1 && x < 7 && y >= 1 && y < 7 && z >= 1 && z < 6;
    const bool cavity = x >= 3 && x < 5 && y >= 3 && y < 5 && z >= 3 && z < 4;
    const bool fin = x >= 7 && x < 11 && y >= 2 && y < 6 && z >= 2 && z < 5;
    return (in && !cavity) || fin;
  });
}

Record core_of(const VoxelShape& shape, const pipeline::AxisOptions& options) {
  pipeline::LoadedShape loaded = pipeline::shape_of(VoxelShape(shape), shape.grid(), {});
  loaded.coordinates = {"mm", "LPS"};
  return pipeline::core_file(pipeline::core_of(loaded, options));
}

Record burned(Record data, BurnOptions options = {}) {
  const MedialAxis axis = medial_axis_of(data);
  options.rounded = true;
  const Burning burning = burn(axis, options);
  add_burning(data, burning, burn_sequence(axis, burning));
  return data;
}

pipeline::SkeletonResult drawn(const pipeline::FamilyResult& family, const pipeline::SkeletonOptions& options) {
  pipeline::SkeletonResult skeleton = pipeline::skeleton_of(family, options, {}, 0);
  pipeline::draw_branches(skeleton, {.smooth = 0}, {});
  return skeleton;
}

Record skeleton_of(const VoxelShape& shape, double theta2, double theta1, bool parts,
                   const pipeline::Pruning& pruning = {kLambda, world_length(0.0)}) {
  const Record core = burned(core_of(shape, {.pruning = pruning}));
  const MedialAxis axis = medial_axis_of(core);
  const Burning burning = burn(axis.complex, axis.points, axis.radius, {});
  const pipeline::FamilyResult family =
      pipeline::family_of(quench_curves(axis.complex, axis.points, axis.radius, burning), topology(shape));
  const pipeline::SkeletonOptions options{world_length(theta2), world_length(theta1), parts};
  return pipeline::skeleton_file(drawn(family, options), core);
}

void add_fitted(std::vector<Result>& all) {
  pipeline::ShapeOptions options;
  options.resolution = 10;
  options.surface = SurfaceKind::mesh;
  pipeline::LoadedShape loaded = pipeline::shape_of(make_sample("fin-on-board", {.fineness = 0.05}).mesh, options);
  loaded.coordinates = {"mm", "LPS"};
  const pipeline::CoreResult core = pipeline::core_of(loaded, {});
  const Record data = burned(pipeline::core_file(core), {.radius = RadiusRule::linear});
  const MedialAxis axis = medial_axis_of(data);
  const Burning burning = burn(axis, {.radius = RadiusRule::linear});
  const pipeline::FamilyResult family =
      pipeline::family_of(quench_curves(axis.complex, axis.points, axis.radius, burning), topology(loaded.shape));
  const pipeline::SkeletonOptions thetas{world_length(0.05), world_length(0.05), false};
  all.push_back({"fitted core", loaded.shape, data, loaded.surface});
  all.push_back(
      {"fitted skeleton", loaded.shape, pipeline::skeleton_file(drawn(family, thetas), data), loaded.surface});
}

std::vector<Result> results() {
  std::vector<Result> all;
  add_fitted(all);
  for (const auto& [name, shape] : {std::pair{"plate", plate()}, std::pair{"hollow", hollow()}}) {
    const auto add = [&, n = std::string(name), s = shape](const char* what, Record data) {
      all.push_back({n + " " + what, s, std::move(data)});
    };
    const bool is_plate = name == std::string("plate");
    if (is_plate) add("core", core_of(shape, {.pruning = {kLambda, world_length(1.2)}}));
    if (is_plate) add("full core", core_of(shape, {.pruning = {kLambda, world_length(1.2)}, .full = true}));
    add("core by balls",
        core_of(shape, {.pruning = {kLambda, world_length(1.1)}, .rule = LambdaRule::ball, .full = !is_plate}));
    add("burned core",
        burned(core_of(shape, {.pruning = {kLambda, world_length(1.2)}}), {.omega = is_plate ? 0 : 0.3}));
    add("core by detail", core_of(shape, {}));
    add("core by larger detail", core_of(shape, {.pruning = {kDetail, world_length(1.9)}}));
    if (is_plate) add("full core by detail", core_of(shape, {.full = true}));
    if (!is_plate) add("burned core by detail", burned(core_of(shape, {})));
    add("skeleton", skeleton_of(shape, 0.3, 0.2, false));
    if (is_plate) add("skeleton of a core by detail", skeleton_of(shape, 0.3, 0.2, false, {}));
    if (!is_plate) add("skeleton in parts", skeleton_of(shape, 0.5, 0, true));
    if (is_plate) add("curves", skeleton_of(shape, kInfinity, 0, false));
    add("curves that topology needs", skeleton_of(shape, kInfinity, kInfinity, false));
  }
  return all;
}

VerifyOptions options_for(const Result& result) {
  VerifyOptions options = options_for(result.shape);
  if (!result.surface) return options;
  options.longest_side = longest_side_of(result.surface->mesh().points);
  options.surface = &result.surface->mesh();
  options.surface_kind = name_of(result.surface->kind());
  return options;
}

bool is_core(const Record& data) {
  return std::get<std::vector<std::string>>(find_array(data.field_data, "stage")->values)[0] == "core";
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

// A change of one number, or of two for an exchange.
struct Damage {
  const char* name;
  std::function<double(double)> change;  // none: exchange with the next number that differs
};
const std::vector<Damage>& damages() {
  static const std::vector<Damage> all{
      {"half", [](double x) { return 0.5 * x; }},     {"times 1.5", [](double x) { return 1.5 * x; }},
      {"plus 1", [](double x) { return x + 1; }},     {"negative", [](double x) { return -x; }},
      {"zero", [](double) { return 0.0; }},           {"not a number", [](double) { return std::nan(""); }},
      {"infinite", [](double) { return kInfinity; }}, {"exchanged", nullptr}};
  return all;
}

// Changes numbers [first, last); false when nothing is different afterwards.
template <class T>
bool damage(std::vector<T>& values, std::size_t first, std::size_t last, const Damage& how) {
  if (!how.change) {
    for (std::size_t i = first + 1; i < values.size(); ++i)
      if (const double a = static_cast<double>(values[i]), b = static_cast<double>(values[first]);
          std::abs(a - b) > 1e-3 * std::max(std::abs(a), 1e-3)) {  // more than rounding
        std::swap(values[i], values[first]);
        return true;
      }
    return false;
  }
  bool changed = false;
  for (std::size_t i = first; i < last; ++i) {
    const double value = how.change(static_cast<double>(values[i]));
    T stored{};
    if constexpr (std::is_floating_point_v<T>) {
      stored = static_cast<T>(value);
    } else {
      if (!std::isfinite(value) || std::is_unsigned_v<T> != (value >= 0 && std::is_unsigned_v<T>)) continue;
      stored = static_cast<T>(value);
    }
    changed = changed || !(stored == values[i]);
    values[i] = stored;
  }
  return changed;
}

class EveryArray {
 public:
  /// Every third change from `turn` on, so that three results that have an array have all changes of it; all of them in
  /// a full run.
  EveryArray(const Result& result, std::size_t turn) : result_(result), turn_(turn) {}

  void damage_each() {
    for (const Arrays& arrays : kArrays)
      for (std::size_t a = 0; a < (result_.data.*arrays.list).size(); ++a)
        std::visit([&](const auto& values) { damage_array(arrays, a, values); }, (result_.data.*arrays.list)[a].values);
  }
  int tried() const { return tried_; }

 private:
  void damage_array(const Arrays& arrays, std::size_t a, const std::vector<std::string>& words) {
    for (const char* word : {"", "no such word", "core", "skeleton", "coface", "ball"})
      if (word != words[0]) expect_noticed(arrays, a, std::vector<std::string>{word}, fmt::format("'{}'", word));
  }
  template <class T>
  void damage_array(const Arrays& arrays, std::size_t a, const std::vector<T>& values) {
    for (const Damage& how : damages())
      for (const bool one : {true, false}) {
        std::vector<T> changed = values;
        const std::size_t first = one ? random(values.size()) : 0;
        if (values.empty() || !damage(changed, first, one ? first + 1 : values.size(), how)) continue;
        expect_noticed(arrays, a, changed, fmt::format("{}, {}", how.name, one ? fmt::format("row {}", first) : "all"));
      }
  }

  void expect_noticed(const Arrays& arrays, std::size_t a, DataArray::Values values, const std::string& how) {
    if (!full_run() && ++turn_ % 3 != 0) return;
    Record data = result_.data;
    DataArray& array = (data.*arrays.list)[a];
    array.values = std::move(values);
    ++tried_;
    const Certificate certificate = verify(result_.shape, data, options_for(result_));
    const bool said = left_out(certificate).contains(fmt::format("{} {}", arrays.of, array.name));
    EXPECT_TRUE(!certificate.passed() || said)
        << result_.name << ": " << arrays.of << " array " << array.name << ", " << how;
  }

  std::size_t random(std::size_t below) {
    state_ = state_ * 6364136223846793005ull + 1442695040888963407ull;
    return static_cast<std::size_t>(state_ >> 33) % std::max<std::size_t>(below, 1);
  }

  const Result& result_;
  std::size_t turn_;
  std::uint64_t state_ = 1;
  int tried_ = 0;
};

TEST(VerifyDamage, UnchangedResultsPassAndEveryArrayIsNamed) {
  for (const Result& result : results()) {
    const Certificate certificate = verify(result.shape, result.data, options_for(result));
    EXPECT_TRUE(certificate.passed()) << result.name << "\n" << text(certificate);
    std::multiset<std::string> named, all;
    for (const Check& check : certificate.checks) named.insert(check.arrays.begin(), check.arrays.end());
    for (const std::string& name : left_out(certificate)) {
      EXPECT_FALSE(named.contains(name)) << name << " is said to be checked and not to be";
      EXPECT_NE(certificate.checks.back().detail.find(name), std::string::npos);
      named.insert(name);
    }
    for (const Arrays& arrays : kArrays)
      for (const DataArray& array : result.data.*arrays.list) {
        all.insert(fmt::format("{} {}", arrays.of, array.name));
        EXPECT_TRUE(named.contains(fmt::format("{} {}", arrays.of, array.name))) << result.name << " " << array.name;
      }
    EXPECT_EQ(std::set(named.begin(), named.end()), std::set(all.begin(), all.end())) << result.name;
  }
}

// What Quench writes for a stage and is not there is named, and what the stage needs is a failure.
TEST(VerifyDamage, EveryArrayThatIsRemovedIsNoticedOrListed) {
  const std::set<std::string> needed{"point radius",
                                     "point voxel_point",
                                     "point voxel_radius",
                                     "field dims",
                                     "field spacing",
                                     "field origin",
                                     "field direction",
                                     "field sites",
                                     "cell lambda_level",
                                     "cell detail_level",
                                     "cell detail",
                                     "point detail",
                                     "cell site_a",
                                     "cell site_b",
                                     "field theta2",
                                     "field theta1",
                                     "cell sheet_level",
                                     "cell curve_level",
                                     "cell erosion_thickness",
                                     "cell curve_erosion_thickness"};
  const std::set<std::string> needed_of_cores{"field surface",     "field lambda", "field detail",
                                              "field lambda_rule", "point lambda", "cell lambda"};
  for (const Result& result : results()) {
    VerifyOptions whole = options_for(result);
    whole.format_holds_all = true;
    const Certificate unchanged = verify(result.shape, result.data, whole);
    EXPECT_TRUE(unchanged.passed() && unchanged.absent.empty()) << result.name << "\n" << text(unchanged);
    const bool core = is_core(result.data);
    for (const Arrays& arrays : kArrays)
      for (std::size_t a = 0; a < (result.data.*arrays.list).size(); ++a) {
        Record data = result.data;
        const std::string name = fmt::format("{} {}", arrays.of, (data.*arrays.list)[a].name);
        if (name == "field SPACE") continue;             // only where it is known
        if (name == "field surface" && !core) continue;  // not fitted then
        (data.*arrays.list).erase((data.*arrays.list).begin() + static_cast<std::ptrdiff_t>(a));
        const Certificate certificate = verify(result.shape, data, whole);
        EXPECT_EQ(certificate.absent, std::vector<std::string>{name}) << result.name << "\n" << text(certificate);
        EXPECT_NE(certificate.checks.back().detail.find("not in the file: " + name), std::string::npos) << result.name;
        const bool fails = needed.contains(name) || (core && needed_of_cores.contains(name));
        EXPECT_EQ(certificate.passed(), !fails) << result.name << " without " << name << "\n" << text(certificate);
        const Check& check = certificate.checks.front();
        EXPECT_EQ(check.name, "arrays");
        EXPECT_EQ(check.detail.find("missing: " + name + ";") == 0, fails) << check.detail;
        // A format that does not hold all of them: only what contradicts the cells is a failure.
        if (name.starts_with("field ") && !name.starts_with("field theta") && name != "field lambda" &&
            name != "field detail" && name != "field lambda_rule" && name != "field surface") {
          const Certificate of_part = verify(result.shape, data, options_for(result));
          EXPECT_TRUE(of_part.passed()) << result.name << " without " << name << "\n" << text(of_part);
          EXPECT_EQ(of_part.absent, certificate.absent);
        }
      }
  }
}

// A skeleton of another program's medial axis has no lattice to be placed on.
TEST(VerifyDamage, SkeletonsOfOtherProgramsNeedNoLattice) {
  const VoxelShape shape = plate();
  Record foreign = skeleton_of(shape, 0.3, 0.2, false);
  std::erase_if(foreign.field_data, [](const DataArray& array) {
    for (const char* name :
         {"dims", "origin", "direction", "longest_side", "lambda", "lambda_chosen", "units", "parameters"})
      if (array.name == name) return true;
    return false;
  });
  VerifyOptions options = options_for(shape);
  options.format_holds_all = true;
  const Certificate certificate = verify(shape, foreign, options);
  EXPECT_TRUE(certificate.passed()) << text(certificate);
  EXPECT_TRUE(certificate.absent.empty());
}

TEST(VerifyDamage, NegativeLengthsAreNoticed) {
  for (const Result& result : results())
    for (const char* name : {"theta2", "theta1", "lambda", "lambda_chosen", "detail", "detail_chosen", "coverage",
                             "longest_side", "omega", "max_burn_time"})
      for (const double value : {-1.99, std::nan("")}) {
        Record data = result.data;
        bool changed = false;
        for (DataArray& array : data.field_data)
          if (array.name == name) array.values = std::vector<double>{value}, changed = true;
        if (!changed) continue;
        const Certificate certificate = verify(result.shape, data, options_for(result));
        EXPECT_FALSE(certificate.passed()) << result.name << ": " << name << " " << value;
        EXPECT_NE(text(certificate).find(fmt::format("'{}'", name)), std::string::npos) << text(certificate);
      }
}

TEST(VerifyDamage, ThetasBeyondInfinityAreNoticed) {
  for (const char* name : {"theta2", "theta1"}) {
    Record curves = skeleton_of(plate(), kInfinity, kInfinity, false);
    for (DataArray& array : curves.field_data)
      if (array.name == name) array.values = std::vector<double>{1e300};
    const Certificate certificate = verify(plate(), curves, options_for(plate()));
    EXPECT_FALSE(certificate.passed()) << name;
    EXPECT_NE(text(certificate).find("FAIL skeleton levels"), std::string::npos) << text(certificate);
  }
}

// Lengths along an edge to such a point are counted in no loop.
TEST(VerifyDamage, PointsFarOutsideTheGridEndAtOnce) {
  for (const Result& result : results())
    for (const double x : {1e17, -1e17, 1e300, kInfinity, -kInfinity, std::nan("")})
      for (int axis = 0; axis < 3; ++axis) {
        Record data = result.data;
        data.points[data.points.size() / 2][axis] = x;
        const Certificate certificate = verify(result.shape, data, options_for(result));
        ASSERT_EQ(certificate.checks.size(), 1u) << result.name << " " << x;
        EXPECT_FALSE(certificate.passed());
        EXPECT_NE(text(certificate).find(std::isfinite(x) ? "is outside the grid of the shape" : "is not finite"),
                  std::string::npos)
            << text(certificate);
      }
}

// What no check can tell may grow only on purpose.
TEST(VerifyDamage, OnlyTheseArraysAreLeftOut) {
  const std::set<std::string> of_cores{"point burn_time",     "field omega",   "field propagation",
                                       "field radius_rule",   "field units",   "field lambda_chosen",
                                       "field detail_chosen", "point detail",  "cell detail",
                                       "field parameters",    "field version", "field SPACE"};
  std::set<std::string> of_skeletons = of_cores;
  of_skeletons.insert({"point curve_burn_time", "point curve_unburned", "cell erosion_thickness",
                       "cell curve_erosion_thickness", "cell sheet_level", "cell curve_level", "field theta2",
                       "field theta1", "field theta1_radii", "field rims_above", "field smooth", "field tips",
                       "field lambda", "field detail"});
  for (const Result& result : results()) {
    const Certificate certificate = verify(result.shape, result.data, options_for(result));
    const bool core = is_core(result.data);
    std::set<std::string> left = left_out(certificate);
    if (result.surface) left.erase(core ? "field detail" : "point radius");
    for (const std::string& name : left)
      EXPECT_TRUE((core ? of_cores : of_skeletons).contains(name)) << result.name << ": " << name;
  }
}

TEST(VerifyDamage, ChangesOfEveryArrayAreNoticed) {
  int tried = 0;
  for (std::size_t turn = 0; const Result& result : results()) {
    EveryArray arrays(result, turn++);
    arrays.damage_each();
    tried += arrays.tried();
  }
  EXPECT_GT(tried, repeats(2000, 2000 / 3));
}

// Another program may use the names as it likes: without a stage nothing is taken from them, and that is said.
TEST(VerifyDamage, ArraysOfOtherProgramsAreNamed) {
  const VoxelShape shape = plate();
  Record foreign = core_of(shape, {.pruning = {kLambda, world_length(0.0)}});
  const std::size_t cells = foreign.cell_count();
  foreign.cell_data = {{"kind", 1, std::vector<double>(cells, 7)}, {"component", 1, std::vector<double>(cells, -1)}};
  foreign.field_data = {{"betti", 1, std::vector<std::string>{"none"}},
                        {"sites", 3, std::vector<std::string>{"a", "b", "c"}},
                        {"euler", 1, std::vector<double>{17}}};
  const Certificate certificate = verify(shape, foreign);
  EXPECT_TRUE(certificate.passed()) << text(certificate);
  for (const char* name : {"cell kind", "cell component", "field betti", "field sites", "field euler"})
    EXPECT_TRUE(left_out(certificate).contains(name)) << name;
}

TEST(VerifyDamage, AMovedPointIsNoticed) {
  for (const Result& result : results()) {
    // Of a skeleton only that the radius is right, on the way of branches about right, the polygons plane and all
    // inside.
    const bool core = is_core(result.data);
    if (result.surface && !core) continue;  // of this only that it is inside, with about the right radius
    for (const Vec3& step : {Vec3(core ? 1e-3 : 3, 0, 0), Vec3(0, core ? 1 : 3, 0), Vec3(0, 0, core ? -1e-4 : -3)}) {
      Record moved = result.data;
      moved.points[moved.points.size() / 2] += step;
      EXPECT_FALSE(verify(result.shape, moved, options_for(result)).passed()) << result.name;
    }
  }
}

TEST(VerifyDamage, ArraysOfWrongFormAreNoticed) {
  const VoxelShape shape = plate();
  const Record core = core_of(shape, {.pruning = {kLambda, world_length(0.0)}});
  const auto fails = [&](const Record& data) {
    const Certificate certificate = verify(shape, data);
    EXPECT_FALSE(certificate.passed());
    return text(certificate);
  };
  Record twice = core;
  twice.point_data.push_back(twice.point_data.front());
  EXPECT_NE(fails(twice).find("two point arrays 'radius'"), std::string::npos);
  for (const char* name : {"betti", "euler", "sites", "dims", "reconstructed", "lambda"}) {
    Record text_for_numbers = core, too_many = core;
    for (DataArray& array : text_for_numbers.field_data)
      if (array.name == name) array.values = std::vector<std::string>{"1 0 0"};
    EXPECT_NE(fails(text_for_numbers).find(name), std::string::npos);
    for (DataArray& array : too_many.field_data)
      if (array.name == name) std::visit([](auto& values) { values.push_back(values.back()); }, array.values);
    EXPECT_NE(fails(too_many).find(name), std::string::npos);
  }
}

}  // namespace verify_damage_test
}  // namespace quench
