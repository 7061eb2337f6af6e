// SPDX-License-Identifier: Apache-2.0
// Cores pruned by detail: intact files pass, and what is taken from them or changed is found by the check it concerns.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <random>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "certificates.h"
#include "full_run.h"
#include "quench/axis.h"
#include "quench/error.h"
#include "quench/pipeline.h"
#include "quench/shape.h"
#include "quench/verify.h"
#include "random_shapes.h"

namespace quench {
namespace verify_detail_test {

using namespace testing_certificates;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

const Check& find_check(const Certificate& certificate, const std::string& name) {
  const auto found = std::ranges::find(certificate.checks, name, &Check::name);
  if (found == certificate.checks.end()) throw std::logic_error("no check " + name);
  return *found;
}

VerifyOptions options_for(const VoxelShape& shape) {
  VerifyOptions options;
  options.longest_side = shape.longest_side();
  options.format_holds_all = true;
  return options;
}

Certificate certificate_of(const VoxelShape& shape, const Record& data) {
  return verify(shape, data, options_for(shape));
}

// The automatic detail where none is given.
Record core_of(const VoxelShape& shape, std::optional<double> detail = {}, bool full = false) {
  pipeline::AxisOptions options{.full = full};
  if (detail) options.pruning.threshold = pipeline::world_length(*detail);
  return pipeline::core_file(pipeline::core_of(pipeline::shape_of(VoxelShape(shape), shape.grid(), {}), options));
}

VoxelShape spaced(const VoxelShape& shape, const Vec3& spacing) {
  Grid grid = shape.grid();
  grid.spacing = spacing;
  return testing_shapes::from_predicate(grid, [&](int x, int y, int z) { return shape.contains(x, y, z); });
}

const std::vector<Vec3>& spacings() {
  static const std::vector<Vec3> all{{1, 1, 1}, {1, 1, 2}, {0.782, 0.782, 5}};
  return all;
}

void expect_passes(const VoxelShape& shape, const std::string& where) {
  const double voxel = shape.grid().spacing.minCoeff();
  const auto check = [&](const Record& data, const std::string& what) {
    const Certificate certificate = certificate_of(shape, data);
    EXPECT_EQ(failed(certificate), Names{}) << where << ", " << what << "\n" << text(certificate);
    EXPECT_TRUE(certificate.absent.empty()) << where << ", " << what << ": " << certificate.checks.back().detail;
  };
  check(core_of(shape), "auto");
  check(core_of(shape, {}, true), "full");
  check(core_of(shape, 2 * voxel, true), "full, 2 voxels chosen");
  for (const double detail : {0.0, 0.5 * voxel, 2 * voxel, 5 * voxel, kInfinity})
    check(core_of(shape, detail), fmt::format("{}", detail));
}

TEST(VerifyDetail, PassesCoresOfRandomShapes) {
  const std::uint64_t seeds = repeats(40, 16);
  for (std::uint64_t seed = 0; seed < seeds; ++seed)
    for (const Vec3& spacing : spacings())
      expect_passes(spaced(testing_shapes::random_shape(seed, 12), spacing),
                    fmt::format("seed {}, spacing {}", seed, spacing[2]));
}

TEST(VerifyDetail, PassesThinAndLooseParts) {
  for (const Vec3& spacing : spacings())
    for (const int thick : {1, 2}) {
      const std::string where = fmt::format("spacing {}, {} voxels thick", spacing[2], thick);
      expect_passes(spaced(testing_shapes::box_shape(9, 7, thick), spacing), "plate, " + where);
      expect_passes(spaced(testing_shapes::box_shape(thick, 8, 9), spacing), "standing plate, " + where);
      expect_passes(spaced(testing_shapes::box_shape(14, thick, thick), spacing), "needle, " + where);
      expect_passes(spaced(testing_shapes::box_shape(thick, thick, 14), spacing), "standing needle, " + where);
      expect_passes(spaced(testing_shapes::box_shape(thick, thick, thick), spacing), "cube, " + where);
    }
  Grid grid;
  grid.dims = {24, 12, 11};
  const auto loose = [](int x, int y, int z) {
    const bool body = x >= 1 && x < 10 && y >= 1 && y < 9 && z >= 1 && z < 8;
    const bool ball = (x - 16) * (x - 16) + (y - 5) * (y - 5) + (z - 5) * (z - 5) < 18;
    const bool voxels = (x == 11 && y % 3 == 1 && z == 4) || (x == 10 && y == 9 && z == 8) || (x == 22 && y >= 3);
    return body || ball || voxels;
  };
  for (const Vec3& spacing : spacings())
    expect_passes(spaced(testing_shapes::from_predicate(grid, loose), spacing), fmt::format("loose, {}", spacing[2]));
}

// ------------------------------------------------------------------------------------------------------------ coverage

// The largest distance of a boundary vertex to the balls of the points that `is_kept` holds for.
template <class IsKept>
double distance_by_brute_force(const VoxelShape& shape, const Record& data, const IsKept& is_kept) {
  const std::vector<double> radius = find_array(data.point_data, "radius")->numbers();
  double largest = 0;
  for (const LatticePoint& q : boundary_vertices(shape)) {
    const Vec3 p = shape.grid().world(Vec3(q[0], q[1], q[2]));
    double nearest = kInfinity;
    for (std::size_t v = 0; v < data.points.size(); ++v)
      if (is_kept(v)) nearest = std::min(nearest, (p - data.points[v]).norm() - radius[v]);
    largest = std::max(largest, nearest);
  }
  return largest;
}

void set_field(Record& data, const std::string& name, double value) {
  for (DataArray& array : data.field_data)
    if (array.name == name) array.values = std::vector<double>{value};
}

// Single vertices as a file that says it was pruned at `detail`.
Record vertices_only(const Record& core, const std::vector<std::size_t>& vertices, double detail) {
  const std::vector<double> radius = find_array(core.point_data, "radius")->numbers();
  Record data;
  std::vector<double> kept;
  for (const std::size_t v : vertices) {
    data.verts.push_back(static_cast<std::uint32_t>(data.points.size()));
    data.points.push_back(core.points[v]);
    kept.push_back(radius[v]);
  }
  data.point_data = {{"radius", 1, kept}};
  data.field_data = {{"stage", 1, std::vector<std::string>{"core"}}, {"detail", 1, std::vector<double>{detail}}};
  return data;
}

TEST(VerifyDetail, CoverageIsThatOfBruteForce) {
  std::mt19937_64 random(7);
  int kept_promises = 0, broken = 0;
  for (std::uint64_t seed = 0; seed < 80; ++seed) {
    const VoxelShape shape = spaced(testing_shapes::random_shape(seed, 9), spacings()[seed % 3]);
    const double automatic = auto_detail(shape.grid());
    Record core = core_of(shape, 3 * automatic);
    const double covered = distance_by_brute_force(shape, core, [](std::size_t) { return true; });
    for (const double claimed : {covered, covered + 1e-4, std::abs(covered - 1e-4)}) {
      set_field(core, "coverage", claimed);
      EXPECT_EQ(find_check(verify(shape, core), "coverage").passed, claimed == covered) << seed;
    }
    for (int i = 0; i < 4; ++i) {
      std::vector<std::size_t> some;
      for (std::size_t v = 0; v < core.points.size(); ++v)
        if (random() % 3 != 0) some.push_back(v);
      if (some.empty()) continue;
      const double detail = automatic * static_cast<double>(random() % 5);
      const Record data = vertices_only(core, some, detail);
      const double distance = distance_by_brute_force(shape, data, [](std::size_t) { return true; });
      const bool promised = distance <= 2 * std::max(detail, automatic) * (1 + 1e-9);
      const Certificate certificate = verify(shape, data);
      EXPECT_EQ(find_check(certificate, "coverage").passed, promised) << seed << "\n" << text(certificate);
      ++(promised ? kept_promises : broken);
    }
  }
  EXPECT_GT(kept_promises, 30);
  EXPECT_GT(broken, 30);
}

// Levels of a whole core that drop a vertex too early are found at the details that are looked at.
TEST(VerifyDetail, LevelsThatBreakThePromiseAreFound) {
  int broken = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const VoxelShape shape = spaced(testing_shapes::random_shape(seed, 12), spacings()[seed % 3]);
    const double automatic = auto_detail(shape.grid());
    Record core = core_of(shape, 2 * automatic, true);
    // Everything farther than some distance from a corner goes at a detail between two of those.
    std::vector<double> level = find_array(core.cell_data, "detail_level")->numbers();
    const Vec3 corner = core.points[core.points.size() / 2];
    std::vector<double> of_vertex(core.points.size(), 0);
    std::size_t row = 0;
    const auto lower = [&](const auto& corners) {
      double farthest = 0;
      for (const std::uint32_t v : corners) farthest = std::max(farthest, (core.points[v] - corner).norm());
      if (farthest > 3 * automatic) level[row] = std::min(level[row], 3 * automatic);
      for (const std::uint32_t v : corners) of_vertex[v] = std::max(of_vertex[v], level[row]);
      ++row;
    };
    for (const std::uint32_t v : core.verts) lower(std::array{v});
    for (const auto& line : core.lines) lower(line);
    for (std::size_t f = 0; f < core.poly_count(); ++f)
      lower(
          std::span(core.poly_corners).subspan(core.poly_offsets[f], core.poly_offsets[f + 1] - core.poly_offsets[f]));
    for (DataArray& array : core.cell_data)
      if (array.name == "detail_level") array.values = level;
    bool promised = true;
    for (const double factor : {1.0, 2.0, 4.0, 8.0})
      promised = promised && distance_by_brute_force(shape, core, [&](std::size_t v) {
                               return of_vertex[v] >= factor * automatic * (1 - 1e-12);
                             }) <= 2 * factor * automatic * (1 + 1e-9);
    const Certificate certificate = verify(shape, core);
    EXPECT_EQ(find_check(certificate, "coverage").passed, promised) << seed << "\n" << text(certificate);
    broken += !promised;
  }
  EXPECT_GT(broken, 10);
}

// ------------------------------------------------------------------------------------------------------------- damages

// A body with a tower, a ball, a plate and a needle.
VoxelShape body(const Vec3& spacing = {1, 1, 1}) {
  Grid grid;
  grid.dims = {42, 20, 18};
  grid.spacing = spacing;
  return testing_shapes::from_predicate(grid, [](int x, int y, int z) {
    const bool box = x >= 1 && x < 18 && y >= 1 && y < 14 && z >= 1 && z < 8;
    const bool tower = x >= 3 && x < 9 && y >= 2 && y < 18 && z >= 2 && z < 16;
    const bool ball = (x - 18) * (x - 18) + 2 * (y - 8) * (y - 8) + (z - 9) * (z - 9) < 50;
    const bool plate = x >= 18 && x < 34 && y >= 2 && y < 14 && z >= 4 && z < 7;
    const bool needle = x >= 34 && x < 41 && y >= 5 && y < 6 && z >= 4 && z < 5;
    return box || tower || ball || plate || needle;
  });
}

template <class T>
std::vector<T>& values(std::vector<DataArray>& arrays, const std::string& name) {
  for (DataArray& array : arrays)
    if (array.name == name) return std::get<std::vector<T>>(array.values);
  throw std::logic_error("no array " + name);
}

// A file with what a pruning at `detail` of an axis has, as the program writes it.
Record file_of(const VoxelShape& shape, const MedialAxis& pruned, double detail) {
  Record data = to_record(pruned);
  const auto add = [&](const char* name, double value) {
    data.field_data.push_back({name, 1, std::vector<double>{value}});
  };
  const auto add_text = [&](const char* name, const char* value) {
    data.field_data.push_back({name, 1, std::vector<std::string>{value}});
  };
  add_text("stage", "core");
  add_text("lambda_rule", "coface");
  add("detail", detail);
  add("detail_chosen", detail);
  add("coverage", coverage(shape, pruned));
  return data;
}

struct Whole {
  explicit Whole(const VoxelShape& s) : shape(s), axis(voxel_core(s)), least(auto_detail(s.grid())) {
    add_detail(axis);
  }
  Record pruned_file(MedialAxis changed, double detail) const {
    prune_levels(changed, kDetail);
    return file_of(shape, pruned(std::move(changed), detail, kDetail), detail);
  }
  Record intact() const { return pruned_file(axis, least); }
  VoxelShape shape;
  MedialAxis axis;
  double least;
};

// The axis where polygons within some steps of one have no detail, nor have their sides, so that pruning takes a hole
// from a rim, or a sheet, that has to stay.
MedialAxis without_sheet(const Whole& whole, std::size_t middle, int steps) {
  MedialAxis axis = whole.axis;
  const CellComplex& complex = axis.complex;
  CellValues& detail = axis.measure(kDetail).value;
  std::vector<char> near(complex.vertex_count, 0);
  for (const std::uint32_t v : complex.corners(middle)) near[v] = 1;
  for (int step = 0; step < steps; ++step) {
    std::vector<char> next = near;
    for (std::size_t f = 0; f < complex.face_count(); ++f)
      if (std::ranges::any_of(complex.corners(f), [&](std::uint32_t v) { return near[v] != 0; }))
        for (const std::uint32_t v : complex.corners(f)) next[v] = 1;
    near = std::move(next);
  }
  for (std::size_t f = 0; f < complex.face_count(); ++f)
    if (std::ranges::all_of(complex.corners(f), [&](std::uint32_t v) { return near[v] != 0; })) detail.face[f] = 0;
  detail.edge.assign(detail.edge.size(), 0);
  for (std::size_t f = 0; f < complex.face_count(); ++f)
    for (const std::uint32_t e : complex.sides(f)) detail.edge[e] = std::max(detail.edge[e], detail.face[f]);
  for (std::uint32_t v = 0; v < complex.vertex_count; ++v)
    if (near[v] && detail.vertex[v] < kInfinity) detail.vertex[v] = 0;
  return axis;
}

TEST(VerifyDetail, ASheetThatIsMissingIsFound) {
  int missing = 0, by_rim = 0;
  for (const Vec3& spacing : spacings()) {
    const Whole whole(body(spacing));
    ASSERT_EQ(failed(verify(whole.shape, whole.intact())), Names{}) << text(verify(whole.shape, whole.intact()));
    const Measure& detail = whole.axis.measure(kDetail);
    for (std::size_t f = 0; f < whole.axis.complex.face_count(); f += 13)
      for (const int steps : {0, 1, 3}) {
        if (detail.value.face[f] < 1.2 * whole.least) continue;
        const Record data = whole.pruned_file(without_sheet(whole, f, steps), whole.least);
        if (data.poly_count() == whole.intact().poly_count()) continue;  // topology needs it
        const Certificate certificate = verify(whole.shape, data);
        const Names names = failed(certificate);
        EXPECT_TRUE(names.contains("legal pruning") || names.contains("details") || names.contains("coverage"))
            << spacing[2] << ": polygon " << f << ", " << steps << "\n"
            << text(certificate);
        ++missing;
        by_rim += names.contains("legal pruning");
      }
  }
  EXPECT_GT(missing, 50);
  EXPECT_GT(by_rim, missing * 9 / 10);
}

TEST(VerifyDetail, ChangesAreFoundByTheCheckTheyConcern) {
  for (const Vec3& spacing : spacings())
    for (const bool full : {false, true}) {
      const VoxelShape shape = body(spacing);
      const double automatic = auto_detail(shape.grid());
      const Record intact = core_of(shape, {}, full);
      const std::vector<double> detail = find_array(intact.cell_data, "detail")->numbers(),
                                level = find_array(intact.cell_data, "detail_level")->numbers();
      const std::size_t polygons = intact.verts.size() + intact.lines.size();
      const auto step = [](std::size_t count) { return count / repeats(5, 3) + 1; };
      const auto expect_found = [&](const std::string& by, const auto& change) {
        Record data = intact;
        change(data);
        const Certificate certificate = certificate_of(shape, data);
        EXPECT_TRUE(failed(certificate).contains(by)) << spacing[2] << " " << full << " " << by << "\n"
                                                      << text(certificate);
      };
      for (const double factor : {1 - 1e-6, 1 + 1e-6}) {
        for (std::size_t c = 0; c < intact.cell_count(); c += step(intact.cell_count()))
          expect_found("cap heights", [&](Record& d) { values<double>(d.cell_data, "cap_height")[c] *= factor; });
        for (std::size_t v = 0; v < intact.points.size(); v += step(intact.points.size()))
          expect_found("cap heights", [&](Record& d) { values<double>(d.point_data, "cap_height")[v] *= factor; });
        for (std::size_t c = polygons; c < intact.cell_count(); c += step(intact.poly_count()))
          if (std::abs(detail[c] - automatic) > 1e-6 * automatic && (full || detail[c] >= automatic))
            expect_found("details", [&](Record& d) { values<double>(d.cell_data, "detail")[c] *= factor; });
        for (std::size_t c = 0; c < intact.cell_count(); c += step(intact.cell_count()))
          if (level[c] < kInfiniteLevelInFiles)
            expect_found("nested levels of detail",
                         [&](Record& d) { values<double>(d.cell_data, "detail_level")[c] *= factor; });
      }
      for (std::size_t f = 0; f < intact.poly_count(); f += step(intact.poly_count()))
        if (detail[polygons + f] > automatic)
          expect_found("details", [&](Record& d) {
            values<double>(d.point_data, "detail")[d.poly_corners[d.poly_offsets[f]]] = 0.9 * automatic;
          });
      expect_found("details", [&](Record& d) {
        auto& of_points = values<double>(d.point_data, "detail");
        std::ranges::fill(of_points, kInfinity);
      });
      if (full) continue;
      for (const double more : {1e-4, -1e-4, 1.0})
        expect_found("coverage", [&](Record& d) {
          double& written = values<double>(d.field_data, "coverage")[0];
          written = std::abs(written + more * automatic);
        });
      expect_found("nested levels of detail", [&](Record& d) {
        for (const char* name : {"detail", "detail_chosen"}) set_field(d, name, 1.5 * automatic);
      });
      expect_found("what the file says of the shape", [&](Record& d) { set_field(d, "detail", 0.9 * automatic); });
      if (spacing[2] == 1)
        expect_found("legal pruning", [&](Record& d) {
          for (const char* name : {"detail", "detail_chosen"}) set_field(d, name, 0.2 * automatic);
        });
    }
}

TEST(VerifyDetail, AMissingPolygonIsFound) {
  const VoxelShape shape = body();
  const Record intact = core_of(shape);
  const std::vector<double> detail = find_array(intact.cell_data, "detail")->numbers();
  const std::size_t polygons = intact.verts.size() + intact.lines.size();
  int tried = 0;
  for (std::size_t f = 0; f < intact.poly_count(); f += 19) {
    if (detail[polygons + f] <= 1.01 * auto_detail(shape.grid())) continue;
    Record data = intact;
    const std::uint32_t begin = data.poly_offsets[f], size = data.poly_offsets[f + 1] - begin;
    data.poly_corners.erase(data.poly_corners.begin() + begin, data.poly_corners.begin() + begin + size);
    data.poly_offsets.erase(data.poly_offsets.begin() + static_cast<std::ptrdiff_t>(f) + 1);
    for (std::size_t g = f + 1; g < data.poly_offsets.size(); ++g) data.poly_offsets[g] -= size;
    for (DataArray& array : data.cell_data)
      std::visit([&](auto& v) { v.erase(v.begin() + static_cast<std::ptrdiff_t>(polygons + f)); }, array.values);
    const Certificate certificate = verify(shape, data);
    EXPECT_TRUE(failed(certificate).contains("legal pruning")) << f << "\n" << text(certificate);
    ++tried;
  }
  EXPECT_GT(tried, 20);
}

// ------------------------------------------------------------------------------------------------------------- options

TEST(VerifyDetail, AThresholdThatIsGivenTakesThePlaceOfTheFiles) {
  const VoxelShape shape = body();
  Record core = core_of(shape);
  VerifyOptions options = options_for(shape);
  options.detail = 2 * auto_detail(shape.grid());
  EXPECT_TRUE(failed(verify(shape, core, options)).contains("nested levels of detail"));
  options.detail = auto_detail(shape.grid());
  EXPECT_EQ(failed(verify(shape, core, options)), Names{});
  std::erase_if(core.field_data, [](const DataArray& array) { return array.name == kDetail; });
  EXPECT_EQ(failed(verify(shape, core, options)), Names{});
  EXPECT_TRUE(failed(verify(shape, core, options_for(shape))).contains("arrays"));
}

TEST(VerifyDetail, ThresholdsThatContradictAreRefused) {
  const VoxelShape shape = body();
  const Record by_detail = core_of(shape);
  const pipeline::AxisOptions lambda{.pruning = {kLambda, pipeline::world_length(1)}};
  const Record by_lambda =
      pipeline::core_file(pipeline::core_of(pipeline::shape_of(VoxelShape(shape), shape.grid(), {}), lambda));
  VerifyOptions both;
  both.lambda = both.detail = 1;
  EXPECT_THROW(verify(shape, by_detail, both), Error);
  VerifyOptions other;
  other.lambda = 1;
  EXPECT_THROW(verify(shape, by_detail, other), Error);
  EXPECT_NO_THROW(verify(shape, by_lambda, other));
  other = {};
  other.detail = 1;
  EXPECT_THROW(verify(shape, by_lambda, other), Error);
  EXPECT_NO_THROW(verify(shape, by_detail, other));
  Record twice = by_detail;
  twice.field_data.push_back({"lambda", 1, std::vector<double>{1}});
  EXPECT_EQ(failed(verify(shape, twice)), Names{"arrays"});
}

}  // namespace verify_detail_test
}  // namespace quench
