// SPDX-License-Identifier: Apache-2.0
#include "quench/verify.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>

#include "brute_force_core.h"
#include "brute_force_poly_data.h"
#include "certificates.h"
#include "quench/error.h"
#include "random_shapes.h"

namespace quench {
namespace verify_test {

using namespace testing_certificates;

std::string detail(const Certificate& certificate, const std::string& name) {
  for (const Check& check : certificate.checks)
    if (check.name == name) return check.detail;
  return "no check of that name";
}

template <class T>
std::vector<T>& values(std::vector<DataArray>& arrays, const std::string& name) {
  for (DataArray& array : arrays)
    if (array.name == name) return std::get<std::vector<T>>(array.values);
  throw std::logic_error("no array " + name);
}

void remove_array(std::vector<DataArray>& arrays, const std::string& name) {
  std::erase_if(arrays, [&](const DataArray& array) { return array.name == name; });
}

// A solid without symmetry: its core has sheets with free edges, its faces many values of lambda.
VoxelShape block() {
  Grid grid;
  grid.dims = {13, 11, 9};
  return testing_shapes::from_predicate(grid, [](int x, int y, int z) {
    const bool body = x >= 1 && x < 12 && y >= 1 && y < 8 && z >= 1 && z < 6;
    const bool tower = x >= 3 && x < 7 && y >= 2 && y < 10 && z >= 2 && z < 8;
    return body || tower;
  });
}

// A box with a box-shaped cavity: its core has a closed pocket.
VoxelShape hollow() {
  Grid grid;
  grid.dims = {9, 10, 8};
  return testing_shapes::from_predicate(grid, [](int x, int y, int z) {
    const bool in = x >= 1 && x < 8 && y >= 1 && y < 9 && z >= 1 && z < 7;
    const bool cavity = x >= 3 && x < 6 && y >= 3 && y < 7 && z >= 3 && z < 5;
    return in && !cavity;
  });
}

struct Intact {
  explicit Intact(const VoxelShape& s) : shape(s), core(brute_force::voxel_core(s)), data(brute_force::record(core)) {}
  VoxelShape shape;
  brute_force::Core core;
  Record data;
};

// The file without one polygon; edges it does not share stay as lines, with their lambda, unless `drop` names one.
Record without_face(const Intact& intact, std::size_t face, std::int64_t drop_edge = -1) {
  brute_force::Kept kept = brute_force::keep_all(intact.core);
  kept.faces[face] = 0;
  if (drop_edge >= 0) kept.edges[static_cast<std::size_t>(drop_edge)] = 0;
  return brute_force::record(intact.core, kept);
}

void expect_passes(const VoxelShape& shape, const Record& data, const std::string& where) {
  const Certificate certificate = verify(shape, data);
  EXPECT_EQ(failed(certificate), Names{}) << where << "\n" << text(certificate);
}

TEST(Verify, PassesIntactCoresOfRandomShapes) {
  for (int anisotropic = 0; anisotropic < 2; ++anisotropic)
    for (std::uint64_t seed = 0; seed < 100; ++seed) {
      const VoxelShape shape = testing_shapes::random_shape(seed, 9, anisotropic == 1);
      const brute_force::Core core = brute_force::voxel_core(shape);
      const std::string where = "seed " + std::to_string(seed) + (anisotropic ? " anisotropic" : "");
      expect_passes(shape, brute_force::record(core), where);
    }
}

TEST(Verify, PassesPruningsByBothRules) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const VoxelShape shape = testing_shapes::random_shape(seed, 9, seed % 3 == 0);
    const brute_force::Core core = brute_force::voxel_core(shape);
    double largest = 0;
    for (const auto& face : core.faces) largest = std::max(largest, face.lambda);
    // Thresholds between values, on a value, and above all.
    std::vector<double> thresholds{0.7 * largest, largest, 2 * largest + 1};
    if (!core.faces.empty()) thresholds.push_back(core.faces[core.faces.size() / 2].lambda);
    for (const double lambda : thresholds)
      for (const bool ball : {false, true})
        expect_passes(shape, brute_force::record(core, brute_force::pruned(core, lambda, ball), lambda, ball),
                      "seed " + std::to_string(seed) + " lambda " + std::to_string(lambda) + (ball ? " ball" : ""));
  }
}

TEST(Verify, PassesInAnyWorld) {
  Grid grid;
  grid.dims = {10, 8, 7};
  grid.spacing = {0.782, 0.782, 5};
  grid.origin = {-120, 33.5, 1e3};
  grid.direction << 0, -1, 0, 0.6, 0, 0.8, 0.8, 0, -0.6;
  const VoxelShape shape = testing_shapes::from_predicate(grid, [](int x, int y, int z) {
    return x > 0 && x < 9 && y > 0 && y < 7 && z > 0 && z < 6 && (x < 4 || y < 5) && (z != 3 || x != 4);
  });
  expect_passes(shape, Intact(shape).data, "0.782 x 0.782 x 5");
}

VoxelShape moved_to(const VoxelShape& shape, const Vec3& origin) {
  Grid grid = shape.grid();
  grid.origin = origin;
  return testing_shapes::from_predicate(grid, [&](int x, int y, int z) { return shape.contains(x, y, z); });
}

// As in surveys, where centimetres are given in metres from the equator: doubles are some 1e-6 voxels apart.
TEST(Verify, PassesFarFromTheOriginWherePositionsAreRounded) {
  for (const double far : {1e8, 1e10})
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
      const VoxelShape near = testing_shapes::random_shape(seed, 9, seed % 3 == 0);
      const VoxelShape shape = moved_to(near, {0.77 * far, 0.31 * far, -0.93 * far});
      expect_passes(shape, Intact(shape).data, fmt::format("seed {} at {}", seed, far));
    }
}

TEST(Verify, CatchesAMovedVertexFarFromTheOrigin) {
  Intact intact(moved_to(block(), {0.77e9, 0.31e9, -0.93e9}));
  EXPECT_TRUE(failed(verify(intact.shape, intact.data)).empty());
  for (const Vec3& step : {Vec3(1e-3, 0, 0), Vec3(0, 1e-4, 1e-4)}) {
    Record moved = intact.data;
    moved.points[moved.points.size() / 3] += step;
    EXPECT_TRUE(failed(verify(intact.shape, moved)).count("Voronoi cells"));
  }
}

TEST(Verify, PassesSolidAndHollowBlocks) {
  expect_passes(block(), Intact(block()).data, "block");
  expect_passes(hollow(), Intact(hollow()).data, "hollow");
  expect_passes(testing_shapes::box_shape(2, 2, 9), Intact(testing_shapes::box_shape(2, 2, 9)).data, "bar");
  expect_passes(testing_shapes::box_shape(1, 1, 1), Intact(testing_shapes::box_shape(1, 1, 1)).data, "voxel");
}

TEST(Verify, CatchesADeletedFace) {
  const Intact intact(block());
  for (const std::size_t face : {std::size_t{0}, intact.core.faces.size() / 2}) {
    const Certificate certificate = verify(intact.shape, without_face(intact, face));
    EXPECT_EQ(failed(certificate), (Names{"euler and Betti numbers", "legal pruning"})) << text(certificate);
  }
}

TEST(Verify, CatchesAFaceDeletedWithItsFreeEdge) {
  const Intact intact(block());
  std::vector<int> faces_at(intact.core.edges.size(), 0);
  for (const auto& face : intact.core.faces)
    for (std::uint32_t e : face.edges) ++faces_at[e];
  int tried = 0;
  for (std::size_t f = 0; f < intact.core.faces.size() && tried < 5; ++f)
    for (std::uint32_t e : intact.core.faces[f].edges)
      if (faces_at[e] == 1) {
        const Certificate certificate = verify(intact.shape, without_face(intact, f, e));
        EXPECT_EQ(failed(certificate), Names{"legal pruning"}) << text(certificate);
        EXPECT_NE(detail(certificate, "legal pruning").find("missing"), std::string::npos);
        ++tried;
        break;
      }
  EXPECT_EQ(tried, 5);
}

TEST(Verify, CatchesAMovedVertex) {
  Intact intact(block());
  for (const Vec3& step : {Vec3(1e-3, 0, 0), Vec3(0, 1e-5, 1e-5)}) {
    Record moved = intact.data;
    moved.points[moved.points.size() / 3] += step;
    const Names names = failed(verify(intact.shape, moved));
    EXPECT_TRUE(names.count("Voronoi cells"));
  }
}

TEST(Verify, CatchesAVertexMovedAlongItsEdgeWithTheRightRadius) {
  Intact intact(block());
  // Moving the free end of an edge along the edge keeps it equally far from the edge's sites.
  const auto& edge = intact.core.edges[intact.core.edges.size() / 2];
  const std::uint32_t a = edge.cells[0], b = edge.cells[1];
  intact.data.points[a] = 0.75 * intact.data.points[a] + 0.25 * intact.data.points[b];
  const LatticePoint& site = intact.core.sites[edge.sites[0]];
  values<double>(intact.data.point_data, "radius")[a] =
      (intact.data.points[a] - intact.shape.grid().world(Vec3(site[0], site[1], site[2]))).norm();
  const Names names = failed(verify(intact.shape, intact.data));
  EXPECT_FALSE(names.count("radii"));
  EXPECT_TRUE(names.count("Voronoi cells"));
}

TEST(Verify, CatchesAWrongRadius) {
  Intact intact(block());
  values<double>(intact.data.point_data, "radius")[7] *= 1 + 3e-5;
  const Certificate certificate = verify(intact.shape, intact.data);
  EXPECT_EQ(failed(certificate), (Names{"radii", "sites of polygons"})) << text(certificate);
  EXPECT_NE(detail(certificate, "radii").find("point 7 at ("), std::string::npos);
}

TEST(Verify, CatchesDuplicatedCells) {
  const Intact intact(block());
  const auto copy_rows = [](Record& data, std::size_t row, std::size_t at) {
    for (DataArray& array : data.cell_data)
      std::visit(
          [&](auto& v) {
            const auto value = v[row];
            v.insert(v.begin() + static_cast<std::ptrdiff_t>(at), value);
          },
          array.values);
  };
  Record polygon = intact.data;
  const std::vector<std::uint32_t> corners(polygon.poly_corners.begin(),
                                           polygon.poly_corners.begin() + polygon.poly_offsets[1]);
  polygon.poly_corners.insert(polygon.poly_corners.end(), corners.rbegin(), corners.rend());
  polygon.poly_offsets.push_back(static_cast<std::uint32_t>(polygon.poly_corners.size()));
  copy_rows(polygon, polygon.verts.size() + polygon.lines.size(), polygon.cell_count() - 1);
  EXPECT_TRUE(failed(verify(intact.shape, polygon)).count("no duplicate or degenerate cell"));

  const Intact bar(testing_shapes::box_shape(1, 1, 4));
  Record line = bar.data;
  ASSERT_FALSE(line.lines.empty());
  line.lines.push_back({line.lines[0][1], line.lines[0][0]});
  copy_rows(line, line.verts.size(), line.verts.size());
  EXPECT_EQ(failed(verify(bar.shape, line)), Names{"no duplicate or degenerate cell"});

  const Intact voxel(testing_shapes::box_shape(1, 1, 1));
  Record point = voxel.data;
  point.points.push_back(point.points[0]);
  for (DataArray& array : point.point_data) {
    auto& v = std::get<std::vector<double>>(array.values);
    v.push_back(v[0]);
  }
  point.verts.push_back(1);
  copy_rows(point, 0, 0);
  EXPECT_TRUE(failed(verify(voxel.shape, point)).count("no duplicate or degenerate cell"));
}

TEST(Verify, CatchesDegenerateCells) {
  const Intact intact(block());
  Record bent = intact.data;
  bent.points[bent.poly_corners[0]] += Vec3(1e-4, 2e-4, 3e-4);
  EXPECT_TRUE(failed(verify(intact.shape, bent)).count("Voronoi cells"));
  Record repeated = intact.data;
  repeated.poly_corners[1] = repeated.poly_corners[0];
  EXPECT_EQ(failed(verify(intact.shape, repeated)), Names{"no duplicate or degenerate cell"});
  Record outside = intact.data;
  outside.poly_corners[0] = static_cast<std::uint32_t>(outside.points.size());
  EXPECT_EQ(failed(verify(intact.shape, outside)), Names{"no duplicate or degenerate cell"});
  Record crossed = intact.data;
  for (std::size_t f = 0; f < crossed.poly_count(); ++f)
    if (crossed.poly_offsets[f + 1] - crossed.poly_offsets[f] >= 4) {
      std::swap(crossed.poly_corners[crossed.poly_offsets[f]], crossed.poly_corners[crossed.poly_offsets[f] + 1]);
      break;
    }
  EXPECT_TRUE(failed(verify(intact.shape, crossed)).count("no duplicate or degenerate cell"));
}

TEST(Verify, CatchesAFilledOrOpenedPocket) {
  const Intact intact(hollow());
  // Opened: one polygon of the pocket is gone.
  EXPECT_TRUE(failed(verify(intact.shape, without_face(intact, 0))).count("euler and Betti numbers"));
  // Divided: a tent over one polygon makes a second pocket.
  Record tent = intact.data;
  const std::uint32_t n = tent.poly_offsets[1];
  Vec3 apex = Vec3::Zero();
  for (std::uint32_t i = 0; i < n; ++i) apex += tent.points[tent.poly_corners[i]] / n;
  const Vec3 normal = (tent.points[tent.poly_corners[1]] - apex).cross(tent.points[tent.poly_corners[0]] - apex);
  tent.points.push_back(apex + 0.05 * normal.normalized());
  for (DataArray& array : tent.point_data) std::get<std::vector<double>>(array.values).push_back(1);
  for (std::uint32_t i = 0; i < n; ++i) {
    const auto top = static_cast<std::uint32_t>(tent.points.size() - 1);
    tent.poly_corners.insert(tent.poly_corners.end(), {tent.poly_corners[i], tent.poly_corners[(i + 1) % n], top});
    tent.poly_offsets.push_back(static_cast<std::uint32_t>(tent.poly_corners.size()));
    for (DataArray& array : tent.cell_data) std::visit([](auto& v) { v.push_back(v.back()); }, array.values);
  }
  const Certificate certificate = verify(intact.shape, tent);
  EXPECT_TRUE(failed(certificate).count("euler and Betti numbers")) << text(certificate);
  EXPECT_NE(detail(certificate, "euler and Betti numbers").find("betti 1 0 2"), std::string::npos) << text(certificate);
}

TEST(Verify, CatchesACellThatCouldHaveBeenPruned) {
  const Intact intact(block());
  const double lambda = 1.3;
  const brute_force::Kept kept = brute_force::pruned(intact.core, lambda);
  expect_passes(intact.shape, brute_force::record(intact.core, kept, lambda), "pruned");
  // The unpruned core, a pruning at another lambda, and one cell too many all claim to be pruned at 1.3.
  for (const auto& wrong : {brute_force::keep_all(intact.core), brute_force::pruned(intact.core, 0.8)}) {
    const Certificate certificate = verify(intact.shape, brute_force::record(intact.core, wrong, lambda));
    EXPECT_EQ(failed(certificate), Names{"legal pruning"}) << text(certificate);
    EXPECT_NE(detail(certificate, "legal pruning").find("could still be pruned"), std::string::npos);
  }
  VerifyOptions options;
  options.lambda = 1.6;  // overrides the file
  EXPECT_EQ(failed(verify(intact.shape, brute_force::record(intact.core, kept, lambda), options)),
            Names{"legal pruning"});
}

TEST(Verify, CatchesAPruningThatWentTooFar) {
  const Intact intact(block());
  const brute_force::Kept kept = brute_force::pruned(intact.core, 1.9);
  const Certificate certificate = verify(intact.shape, brute_force::record(intact.core, kept, 1.3));
  EXPECT_EQ(failed(certificate), Names{"legal pruning"}) << text(certificate);
  EXPECT_NE(detail(certificate, "legal pruning").find("missing"), std::string::npos);
}

TEST(Verify, CatchesAWrongSite) {
  Intact intact(block());
  auto& site_a = values<std::int32_t>(intact.data.cell_data, "site_a");
  site_a.back() = (site_a.back() + 1) % static_cast<std::int32_t>(intact.core.sites.size());
  const Certificate certificate = verify(intact.shape, intact.data);
  EXPECT_EQ(failed(certificate), (Names{"Voronoi cells", "sites of polygons"})) << text(certificate);
  site_a.back() = 1 << 30;
  EXPECT_EQ(failed(verify(intact.shape, intact.data)), (Names{"Voronoi cells", "sites of polygons"}));
}

TEST(Verify, CatchesAWrongLambda) {
  const Intact intact(block());
  Record cell = intact.data, point = intact.data, rule = intact.data;
  values<double>(cell.cell_data, "lambda").back() *= 1 + 1e-5;
  EXPECT_EQ(failed(verify(intact.shape, cell)), (Names{"lambda", "sites of polygons"}));
  values<double>(point.point_data, "lambda")[3] *= 1 - 1e-5;
  EXPECT_EQ(failed(verify(intact.shape, point)), Names{"lambda"});
  values<std::string>(rule.field_data, "lambda_rule")[0] = "ball";
  EXPECT_EQ(failed(verify(intact.shape, rule)), Names{"lambda"});
}

TEST(Verify, CatchesALevelBelowLambda) {
  Intact intact(block());
  intact.data.cell_data.push_back({"lambda_level", 1, std::vector<double>(intact.data.cell_count(), 3.4e38)});
  const Certificate nothing_goes = verify(intact.shape, intact.data);
  EXPECT_EQ(failed(nothing_goes), Names{"nested levels"});
  EXPECT_NE(detail(nothing_goes, "nested levels").find("could have gone"), std::string::npos);
  values<double>(intact.data.cell_data, "lambda_level")[0] = 0.5;
  values<double>(intact.data.field_data, "lambda")[0] = 0.6;
  EXPECT_TRUE(failed(verify(intact.shape, intact.data)).count("nested levels"));
}

TEST(Verify, CatchesWhatLeavesTheShape) {
  // An edge through the gap of a U between two points inside.
  Grid grid;
  grid.dims = {7, 4, 4};
  const VoxelShape u = testing_shapes::from_predicate(
      grid, [](int x, int y, int z) { return y > 0 && y < 3 && z > 0 && (x < 2 || x > 4 || z == 1) && z < 4; });
  Record line;
  line.points = {u.grid().world(Vec3(1, 2, 3)), u.grid().world(Vec3(6, 2, 3))};
  line.lines = {{0, 1}};
  line.point_data = {{"radius", 1, std::vector<double>{1, 1}}};
  const Certificate certificate = verify(u, line);
  EXPECT_EQ(failed(certificate), Names{"inside the shape"}) << text(certificate);
  line.points[1] = u.grid().world(Vec3(5, 2, 3));  // on the boundary itself
  EXPECT_TRUE(detail(verify(u, line), "inside the shape").find("point 1") == 0);
}

TEST(Verify, CatchesAPointFarFromTheMedialAxis) {
  const VoxelShape shape = testing_shapes::box_shape(8, 8, 8);
  Record point;
  point.points = {shape.grid().world(Vec3(4.5, 5.5, 2.0))};
  point.verts = {0};
  point.point_data = {{"radius", 1, std::vector<double>{std::sqrt(1.5)}}};
  point.field_data = {{"stage", 1, std::vector<std::string>{"core"}}};
  const Names names = failed(verify(shape, point));
  EXPECT_TRUE(names.count("proximity bound"));
  EXPECT_TRUE(names.count("Voronoi cells"));
  EXPECT_FALSE(names.count("radii"));
}

TEST(Verify, SaysWhatItCouldNotCheck) {
  Intact intact(block());
  remove_array(intact.data.point_data, "lambda");
  remove_array(intact.data.cell_data, "lambda");
  remove_array(intact.data.cell_data, "site_a");
  Certificate certificate = verify(intact.shape, intact.data);
  EXPECT_TRUE(certificate.passed()) << text(certificate);
  EXPECT_EQ(detail(certificate, "lambda").find("not checked: "), 0u);
  EXPECT_EQ(detail(certificate, "nested levels").find("not checked: "), 0u);
  remove_array(intact.data.field_data, "stage");
  certificate = verify(intact.shape, intact.data);
  EXPECT_TRUE(certificate.passed()) << text(certificate);
  EXPECT_EQ(detail(certificate, "Voronoi cells").find("not checked: "), 0u);
  remove_array(intact.data.point_data, "radius");
  EXPECT_EQ(failed(verify(intact.shape, intact.data)), Names{"radii"});
}

TEST(Verify, AcceptsLinesAndVertsThatRepeatEdgesAndCorners) {
  Intact intact(block());
  // A file for a slider: a line that is also an edge of polygons, a vertex cell that is also an end of lines.
  Record data = intact.data;
  const auto& edge = intact.core.edges[intact.core.faces[0].edges[0]];
  for (DataArray& array : data.cell_data) std::visit([](auto& v) { v.insert(v.begin(), 2, v.front()); }, array.values);
  values<double>(data.cell_data, "lambda")[0] = intact.core.cells[edge.cells[0]].lambda;
  values<double>(data.cell_data, "lambda")[1] = edge.lambda;
  for (const char* site : {"site_a", "site_b"})
    for (const std::size_t row : {0, 1}) values<std::int32_t>(data.cell_data, site)[row] = -1;
  data.verts.insert(data.verts.begin(), edge.cells[0]);
  data.lines.insert(data.lines.begin(), {edge.cells[0], edge.cells[1]});
  expect_passes(intact.shape, data, "repeated cells");
}

TEST(Verify, CatchesAPointOfNoCell) {
  Intact intact(block());
  const std::size_t middle = intact.data.points.size() / 2;
  intact.data.points.insert(intact.data.points.begin() + static_cast<std::ptrdiff_t>(middle), Vec3(5, 4, 3));
  for (DataArray& array : intact.data.point_data) {
    auto& v = std::get<std::vector<double>>(array.values);
    v.insert(v.begin() + static_cast<std::ptrdiff_t>(middle), 1);
  }
  for (auto& corner : intact.data.poly_corners) corner += corner >= middle;
  for (auto& line : intact.data.lines)
    for (auto& end : line) end += end >= middle;
  const Certificate certificate = verify(intact.shape, intact.data);
  EXPECT_EQ(failed(certificate), Names{"no duplicate or degenerate cell"}) << text(certificate);
  EXPECT_EQ(detail(certificate, "no duplicate or degenerate cell"), fmt::format("point {} belongs to no cell", middle));
}

TEST(Verify, FailsWithoutCrashingOnWildNumbers) {
  const Intact intact(block());
  for (const double wild : {std::nan(""), HUGE_VAL, -1e300, 1e300}) {
    Record point = intact.data, radius = intact.data, lambda = intact.data;
    point.points[5][1] = wild;
    EXPECT_FALSE(verify(intact.shape, point).passed()) << wild;
    values<double>(radius.point_data, "radius")[5] = wild;
    EXPECT_EQ(failed(verify(intact.shape, radius)), (Names{"radii", "sites of polygons"})) << wild;
    values<double>(lambda.field_data, "lambda")[0] = wild;
    EXPECT_EQ(failed(verify(intact.shape, lambda)), Names{wild > 0 ? "legal pruning" : "arrays"}) << wild;
  }
  EXPECT_FALSE(verify(intact.shape, Record{}).passed());
}

TEST(Verify, StopsWhenCancelled) {
  Context context;
  context.cancel();
  EXPECT_THROW(verify(block(), Intact(block()).data, {}, &context), Error);
}

}  // namespace verify_test
}  // namespace quench
