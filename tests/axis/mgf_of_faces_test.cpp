// SPDX-License-Identifier: Apache-2.0
// The MGF in space: against an oracle, through pruning, files and their verification.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "brute_force_geodesic.h"
#include "full_run.h"
#include "quench/axis.h"
#include "quench/error.h"
#include "quench/pipeline.h"
#include "quench/verify.h"
#include "random_shapes.h"

namespace quench {
namespace mgf_of_faces_test {

using brute_force::GeodesicOracle;
using testing_shapes::box_shape;
using testing_shapes::from_predicate;
using testing_shapes::random_shape;

constexpr double kInfinite = std::numeric_limits<double>::infinity();

pipeline::LoadedShape loaded_shape(VoxelShape&& shape) {
  const Grid grid = shape.grid();
  return pipeline::shape_of(std::move(shape), grid, {});
}

void expect_near(double found, double expected, const std::string& what) {
  if (std::isinf(expected))
    ASSERT_EQ(found, expected) << what;
  else
    ASSERT_NEAR(found, expected, 1e-9 * (1 + expected)) << what;
}

TEST(MgfOfFaces, IsThatOfTheOracle) {
  for (std::uint64_t seed = 0; seed < 120 && !testing::Test::HasFatalFailure(); seed += repeats(1, 2)) {
    const VoxelShape shape = random_shape(seed, 5, seed % 5 == 0);
    MedialAxis axis = voxel_core(shape);
    add_mgf(axis, shape);
    const CellValues& mgf = axis.measure(kMgf).value;
    ASSERT_TRUE(mgf.complete(axis.complex));
    const GeodesicOracle oracle(shape);
    std::map<GeodesicOracle::Point, std::map<GeodesicOracle::Point, double>> from;
    const std::string what = "seed " + std::to_string(seed);
    std::vector<double> edge(mgf.edge.size(), 0), vertex(mgf.vertex.size(), 0);
    std::vector<char> has_faces(edge.size(), 0);
    for (std::size_t f = 0; f < axis.complex.face_count(); ++f) {
      const auto contact = [&](int i, int j) {
        return oracle.contact(axis.sites[axis.face_sites[f][i]], axis.sites[axis.face_sites[f][j]]);
      };
      const GeodesicOracle::Point a = contact(0, 1), b = contact(1, 0);
      auto& distances = from[a];
      if (distances.empty()) distances = oracle.distances(a);
      const auto found = distances.find(b);
      expect_near(mgf.face[f], found == distances.end() ? kInfinite : found->second, what);
      for (const std::uint32_t e : axis.complex.sides(f)) edge[e] = std::max(edge[e], mgf.face[f]), has_faces[e] = 1;
    }
    for (std::size_t e = 0; e < edge.size(); ++e) {
      if (has_faces[e])
        ASSERT_EQ(mgf.edge[e], edge[e]) << what;
      else
        ASSERT_GT(mgf.edge[e], 0) << what;
      for (const std::uint32_t v : axis.complex.edges[e]) vertex[v] = std::max(vertex[v], mgf.edge[e]);
    }
    for (std::size_t v = 0; v < vertex.size(); ++v)
      if (vertex[v] > 0)
        ASSERT_EQ(mgf.vertex[v], vertex[v]) << what;
      else
        ASSERT_GT(mgf.vertex[v], 0) << what;
  }
}

// Cells without faces: opposite corners of a voxel, and of the cross-section of a bar.
TEST(MgfOfFaces, ThinPartsHaveThatOfTheirOwnSites) {
  for (const int length : {1, 7}) {
    const VoxelShape shape = box_shape(length, 1, 1);
    MedialAxis axis = voxel_core(shape);
    ASSERT_EQ(axis.complex.face_count(), 0u);
    add_mgf(axis, shape);
    const CellValues& mgf = axis.measure(kMgf).value;
    for (const double d : mgf.edge) EXPECT_DOUBLE_EQ(d, 2);
    // A voxel: over two squares.
    for (const double d : mgf.vertex) EXPECT_DOUBLE_EQ(d, length == 1 ? std::sqrt(5.0) : 2);
  }
}

TEST(MgfOfFaces, IsInfiniteBetweenTheSidesOfAShell) {
  Grid grid;
  grid.dims = {9, 9, 9};
  const VoxelShape shape =
      from_predicate(grid, [](int x, int y, int z) { return !(x > 1 && x < 7 && y > 1 && y < 7 && z > 1 && z < 7); });
  MedialAxis axis = voxel_core(shape);
  add_mgf(axis, shape);
  EXPECT_GT(std::ranges::count(axis.measure(kMgf).value.face, kInfinite), 100);
  prune_levels(axis, kMgf);
  const MedialAxis kept = pruned(axis, 1e6, kMgf);
  EXPECT_EQ(topology(kept.complex), topology(shape));
  EXPECT_GT(kept.complex.face_count(), 100u);
}

TEST(MgfOfFaces, PrunesAndIsVerified) {
  for (std::uint64_t seed = 0; seed < 24 && !testing::Test::HasFatalFailure(); ++seed) {
    const pipeline::LoadedShape loaded = loaded_shape(random_shape(seed, 10, seed % 4 == 3));
    for (const bool full : {false, true})
      for (const double threshold : {0., 3., 9.}) {
        pipeline::AxisOptions options;
        options.pruning = {kMgf, pipeline::world_length(threshold)};
        options.full = full;
        pipeline::CoreResult core = pipeline::core_of(loaded, options);
        for (const double level : core.axis.measure(kMgf).level.face)
          ASSERT_GE(level, full ? 0 : threshold * (1 - 1e-9));
        Record file = pipeline::core_file(core);
        const Certificate certificate = verify(loaded.shape, file);
        for (const Check& check : certificate.checks)
          ASSERT_TRUE(check.passed) << seed << ' ' << check.name << ": " << check.detail;
        // What is too short or too long is found.
        const std::vector<double>& lengths = core.axis.measure(kMgf).value.face;
        for (const double factor : {0.5, 1.5})
          if (std::ranges::any_of(lengths, [](double d) { return std::isfinite(d); })) {
            Record wrong = file;
            for (auto* arrays : {&wrong.cell_data, &wrong.point_data})
              for (DataArray& array : *arrays)
                if (array.name == kMgf) {
                  std::vector<double> numbers = array.numbers();
                  for (double& d : numbers) d *= factor;
                  array.values = std::move(numbers);
                }
            const Certificate refused = verify(loaded.shape, wrong);
            EXPECT_FALSE(std::ranges::find(refused.checks, "ways along the boundary", &Check::name)->passed) << seed;
          }
      }
    pipeline::AxisOptions options;
    options.measures = {std::string(kMgf)};
    const pipeline::CoreResult core = pipeline::core_of(loaded, options);
    EXPECT_TRUE(core.axis.measure(kMgf).value.complete(core.axis.complex));
    EXPECT_TRUE(core.axis.measure(kMgf).level.empty());
    EXPECT_TRUE(verify(loaded.shape, pipeline::core_file(core)).passed()) << seed;
  }
}

TEST(MgfOfFaces, ThreadsChangeNothing) {
  const VoxelShape shape = random_shape(2, 24);
  std::vector<CellValues> found;
  for (const int threads : {1, 3}) {
    Context context;
    context.threads = threads;
    MedialAxis axis = voxel_core(shape, {}, &context);
    add_mgf(axis, shape, &context);
    found.push_back(axis.measure(kMgf).value);
  }
  EXPECT_TRUE(found[0] == found[1]);
}

TEST(MgfOfFaces, NeedsTheSitesOfTheShape) {
  MedialAxis foreign;
  EXPECT_THROW(add_mgf(foreign, box_shape(3, 3, 3)), Error);
  pipeline::AxisOptions options;
  options.pruning = {kMgf, {}};
  EXPECT_THROW(pipeline::core_of(loaded_shape(box_shape(3, 3, 3)), options), Error);
}

}  // namespace mgf_of_faces_test
}  // namespace quench
