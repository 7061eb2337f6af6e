// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "complex/thinning.h"
#include "naive_thinning.h"
#include "quench/axis.h"
#include "quench/error.h"
#include "quench/shape.h"
#include "quench/verify.h"
#include "random_shapes.h"

namespace quench {
namespace prune_test {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

MedialAxis core_with_levels(const VoxelShape& shape, LambdaRule rule = LambdaRule::coface) {
  MedialAxis axis = voxel_core(shape, {.rule = rule});
  prune_levels(axis);
  return axis;
}

TEST(Prune, LevelsEqualTheNaiveThinning) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const MedialAxis axis =
        core_with_levels(testing_shapes::random_shape(seed, 6), seed % 2 ? LambdaRule::ball : LambdaRule::coface);
    const testing_complexes::NaiveThinning naive(axis.complex, axis.measure().value);
    ASSERT_EQ(axis.measure().level.vertex, naive.vertex) << "seed " << seed;
    ASSERT_EQ(axis.measure().level.edge, naive.edge) << "seed " << seed;
    ASSERT_EQ(axis.measure().level.face, naive.face) << "seed " << seed;
  }
}

// A roof whose slopes are stairs: thousands of cells have one and the same lambda.
VoxelShape roof(int side) {
  Grid grid;
  grid.dims = {side, side, side};
  return testing_shapes::from_predicate(
      grid, [side](int x, int y, int z) { return x > 0 && x + 1 < side && y > 1 && z > 1 && y + z < side; });
}

// The same order with a plain heap of all pairs, whose simplicity is looked up in lists.
CellValues thinned_with_a_heap(const MedialAxis& axis) {
  const CellComplex& complex = axis.complex;
  const CellValues& value = axis.measure().value;
  CellValues level{std::vector<double>(complex.vertex_count, kInfinity),
                   std::vector<double>(complex.edges.size(), kInfinity),
                   std::vector<double>(complex.face_count(), kInfinity)};
  std::vector<std::set<std::uint32_t>> faces(complex.edges.size()), edges(complex.vertex_count);
  for (std::uint32_t f = 0; f < complex.face_count(); ++f)
    for (std::uint32_t e : complex.sides(f)) faces[e].insert(f);
  for (std::uint32_t e = 0; e < complex.edges.size(); ++e)
    for (std::uint32_t v : complex.edges[e]) edges[v].insert(e);
  using Pair = std::tuple<double, int, std::uint32_t>;  // key, dimension and index of the free cell
  std::set<Pair> waiting;
  const auto offer_edge = [&](std::uint32_t e) {
    if (faces[e].size() == 1) waiting.insert({std::max(value.edge[e], value.face[*faces[e].begin()]), 1, e});
  };
  const auto offer_vertex = [&](std::uint32_t v) {
    if (edges[v].size() == 1 && faces[*edges[v].begin()].empty())
      waiting.insert({std::max(value.vertex[v], value.edge[*edges[v].begin()]), 0, v});
  };
  for (std::uint32_t e = 0; e < faces.size(); ++e) offer_edge(e);
  for (std::uint32_t v = 0; v < edges.size(); ++v) offer_vertex(v);
  double running = 0;
  while (!waiting.empty()) {
    const auto [key, dimension, cell] = *waiting.begin();
    waiting.erase(waiting.begin());
    if (dimension == 1 ? faces[cell].size() != 1 : edges[cell].size() != 1) continue;
    running = std::max(running, key);
    const std::uint32_t e = dimension == 1 ? cell : *edges[cell].begin();
    if (dimension == 1) {
      const std::uint32_t f = *faces[e].begin();
      level.face[f] = running;
      for (std::uint32_t s : complex.sides(f)) {
        faces[s].erase(f);
        if (s == e) continue;
        offer_edge(s);
        for (std::uint32_t v : complex.edges[s]) offer_vertex(v);
      }
    } else {
      level.vertex[cell] = running;
    }
    level.edge[e] = running;
    for (std::uint32_t v : complex.edges[e]) {
      edges[v].erase(e);
      offer_vertex(v);
    }
  }
  return level;
}

TEST(Prune, ThousandsOfEqualKeysGoInOrder) {
  for (const VoxelShape& shape : {roof(48), roof(70)}) {
    MedialAxis axis = voxel_core(shape);
    std::map<double, std::size_t> edges_of;
    for (const double lambda : axis.measure().value.edge) ++edges_of[lambda];
    std::size_t most = 0;
    for (const auto& [lambda, edges] : edges_of) most = std::max(most, edges);
    ASSERT_GT(most, 4000u);
    const CellValues expected = thinned_with_a_heap(axis);
    for (int threads : {1, 4}) {
      tbb::task_arena(threads).execute([&] { prune_levels(axis); });
      EXPECT_TRUE(axis.measure().level == expected);
    }
  }
}

// Two triangles with a common edge, one of value 0: its outer edges go with it, whatever the sign of the 0.
TEST(Prune, NegativeZeroIsZero) {
  const CellComplex complex{
      4, {{0, 1}, {0, 2}, {1, 2}, {1, 3}, {2, 3}}, {0, 3, 6}, {0, 1, 2, 1, 3, 2}, {0, 2, 1, 3, 4, 2}};
  for (const double zero : {0.0, -0.0}) {
    const std::vector<double> face{zero, 1}, edge(5, zero), vertex(4, zero);
    const CellValues level = complex::thin(complex, vertex, edge, face, nullptr, "");
    EXPECT_EQ(level.face, (std::vector<double>{0, 1}));
    EXPECT_EQ(level.edge, (std::vector<double>{0, 0, 1, 1, 1}));
    EXPECT_EQ(level.vertex, (std::vector<double>{0, 1, 1, std::numeric_limits<double>::infinity()}));
  }
}

// A legal pruning: closed, holds {lambda(cell) >= lambda}, has the topology of the shape, no removable pair below
// lambda.
void expect_legal(const MedialAxis& axis, double lambda, const Topology& wanted, const std::string& where) {
  const CellComplex& complex = axis.complex;
  const auto& [name, value, level] = axis.measure();
  const auto in = [&](const std::vector<double>& levels, std::size_t i) { return levels[i] >= lambda; };
  for (std::size_t v = 0; v < level.vertex.size(); ++v)
    ASSERT_TRUE(value.vertex[v] < lambda || in(level.vertex, v)) << where;
  for (std::size_t e = 0; e < level.edge.size(); ++e) {
    ASSERT_TRUE(value.edge[e] < lambda || in(level.edge, e)) << where;
    for (std::uint32_t v : complex.edges[e]) ASSERT_GE(level.vertex[v], level.edge[e]) << where;
  }
  for (std::size_t f = 0; f < level.face.size(); ++f) {
    ASSERT_TRUE(value.face[f] < lambda || in(level.face, f)) << where;
    for (std::uint32_t e : complex.sides(f)) ASSERT_GE(level.edge[e], level.face[f]) << where;
  }
  const MedialAxis kept = pruned(axis, lambda);
  ASSERT_NO_THROW(kept.complex.validate()) << where;
  ASSERT_EQ(topology(kept.complex), wanted) << where;
  const CellValues& left = kept.measure().value;
  std::vector<int> faces(kept.complex.edges.size(), 0), edges(kept.complex.vertex_count, 0);
  for (std::uint32_t e : kept.complex.face_edges) ++faces[e];
  for (const auto& e : kept.complex.edges)
    for (std::uint32_t v : e) ++edges[v];
  for (std::size_t f = 0; f < kept.complex.face_count(); ++f)
    for (std::uint32_t e : kept.complex.sides(f))
      ASSERT_FALSE(faces[e] == 1 && std::max(left.face[f], left.edge[e]) < lambda) << where;
  for (std::size_t e = 0; e < kept.complex.edges.size(); ++e)
    for (std::uint32_t v : kept.complex.edges[e])
      ASSERT_FALSE(faces[e] == 0 && edges[v] == 1 && std::max(left.edge[e], left.vertex[v]) < lambda) << where;
}

TEST(Prune, EveryPruningIsLegalAndKeepsTheTopology) {
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    const bool anisotropic = seed % 3 == 2;
    const VoxelShape shape = testing_shapes::random_shape(seed, seed % 50 == 0 ? 16 : 9, anisotropic);
    const Topology wanted = topology(shape);
    const MedialAxis axis = core_with_levels(shape, seed % 2 ? LambdaRule::ball : LambdaRule::coface);
    for (double lambda : {0.0, 0.6, 0.75, 1.0, 1.3, 2.5, 5.0, 1e30})
      expect_legal(axis, lambda, wanted, "seed " + std::to_string(seed) + " lambda " + std::to_string(lambda));
  }
}

TEST(Prune, PruningAPruningGivesTheSame) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const MedialAxis axis = core_with_levels(testing_shapes::random_shape(seed, 10));
    const MedialAxis once = pruned(axis, 1.5), twice = pruned(pruned(axis, 0.9), 1.5);
    ASSERT_EQ(once.complex.edges, twice.complex.edges);
    ASSERT_EQ(once.complex.face_vertices, twice.complex.face_vertices);
    ASSERT_EQ(once.sites, twice.sites);
    ASSERT_EQ(once.face_sites, twice.face_sites);
    ASSERT_EQ(once.radius, twice.radius);
  }
}

void expect_same(const Record& a, const Record& b, const std::string& where) {
  ASSERT_EQ(a.points, b.points) << where;
  ASSERT_EQ(a.verts, b.verts) << where;
  ASSERT_EQ(a.lines, b.lines) << where;
  ASSERT_EQ(a.poly_offsets, b.poly_offsets) << where;
  ASSERT_EQ(a.poly_corners, b.poly_corners) << where;
  for (const auto arrays : {&Record::point_data, &Record::cell_data, &Record::field_data}) {
    ASSERT_EQ((a.*arrays).size(), (b.*arrays).size()) << where;
    for (std::size_t i = 0; i < (a.*arrays).size(); ++i) {
      ASSERT_EQ((a.*arrays)[i].name, (b.*arrays)[i].name) << where;
      ASSERT_EQ((a.*arrays)[i].values, (b.*arrays)[i].values) << where << ", " << (a.*arrays)[i].name;
    }
  }
}

TEST(Prune, InTheMemoryOfTheAxisPruningAndFileAreTheSame) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const MedialAxis axis = core_with_levels(testing_shapes::random_shape(seed, 10, seed % 3 == 2));
    for (const double lambda : {0.0, 0.75, 1.3, 2.5, kInfinity}) {
      const std::string where = "seed " + std::to_string(seed) + " lambda " + std::to_string(lambda);
      const MedialAxis copied = pruned(axis, lambda);
      MedialAxis taken = axis;
      taken = pruned(std::move(taken), lambda);
      ASSERT_NO_THROW(taken.complex.validate()) << where;
      ASSERT_EQ(taken.complex.face_edges, copied.complex.face_edges) << where;
      expect_same(to_record(std::move(taken)), to_record(copied), where);
    }
  }
}

TEST(Prune, AllCollapsesToAPointInABallAndToALoopInATorus) {
  Grid grid;
  grid.dims = {24, 24, 12};
  const VoxelShape torus = testing_shapes::from_predicate(grid, [](int x, int y, int z) {
    const double a = x - 11.4, b = y - 11.3, c = z - 5.6, ring = std::sqrt(a * a + b * b) - 7.5;
    return ring * ring + c * c < 9;
  });
  ASSERT_EQ(topology(torus), (Topology{0, {1, 1, 0}}));
  const MedialAxis loop = pruned(core_with_levels(torus), kInfinity);
  EXPECT_EQ(loop.complex.face_count(), 0u);
  EXPECT_EQ(loop.complex.edges.size(), loop.complex.vertex_count);
  const MedialAxis point = pruned(core_with_levels(testing_shapes::box_shape(7, 6, 5)), kInfinity);
  EXPECT_EQ(point.complex.vertex_count, 1u);
}

// A file holds a line for every edge that outlives its faces, so {level >= t} of its cells is the pruning for every t.
TEST(Prune, TheCellsOfAFileAtEveryLevelAreThePruning) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const MedialAxis axis = core_with_levels(testing_shapes::random_shape(seed, 10));
    const Record data = to_record(axis);
    ASSERT_NO_THROW(data.validate());
    const std::vector<double> level = find_array(data.cell_data, "lambda_level")->numbers();
    for (double t : {0.8, 1.2, 2.0, 1e30}) {
      Record kept;
      kept.points = data.points;
      std::size_t cell = 0;
      for (std::uint32_t v : data.verts)
        if (level[cell++] >= t) kept.verts.push_back(v);
      for (const auto& line : data.lines)
        if (level[cell++] >= t) kept.lines.push_back(line);
      for (std::size_t p = 0; p < data.poly_count(); ++p)
        if (level[cell++] >= t) {
          kept.poly_corners.insert(kept.poly_corners.end(), data.poly_corners.begin() + data.poly_offsets[p],
                                   data.poly_corners.begin() + data.poly_offsets[p + 1]);
          kept.poly_offsets.push_back(static_cast<std::uint32_t>(kept.poly_corners.size()));
        }
      const CellComplex mine = complex_of(kept), expected = pruned(axis, t).complex;
      ASSERT_EQ(mine.vertex_count, expected.vertex_count) << "seed " << seed << " level " << t;
      ASSERT_EQ(mine.edges, expected.edges);
      ASSERT_EQ(mine.face_vertices, expected.face_vertices);
    }
  }
}

TEST(Prune, EveryPruningPassesTheIndependentVerifier) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const VoxelShape shape = testing_shapes::random_shape(seed, 10, seed % 4 == 3);
    const MedialAxis axis = core_with_levels(shape);
    for (double lambda : {0.0, 0.9, 2.0}) {
      Record data = to_record(pruned(axis, lambda));
      data.field_data.push_back({"stage", 1, std::vector<std::string>{"core"}});
      const Certificate certificate = verify(shape, data, {.lambda = lambda});
      for (const Check& check : certificate.checks)
        ASSERT_TRUE(check.passed) << "seed " << seed << ": " << check.name << ": " << check.detail;
    }
  }
}

Record result_of(const MedialAxis& axis, const VoxelShape& shape, double lambda) {
  Record data = to_record(pruned(axis, lambda));
  data.field_data.push_back({"stage", 1, std::vector<std::string>{"core"}});
  data.field_data.push_back({"lambda", 1, std::vector<double>{lambda}});
  data.field_data.push_back({"reconstructed", 1, std::vector<double>{Reconstruction(shape, axis).share(lambda)}});
  return data;
}

std::set<std::string> failed_checks(const VoxelShape& shape, const Record& data) {
  std::set<std::string> names;
  for (const Check& check : verify(shape, data).checks)
    if (!check.passed) names.insert(check.name);
  return names;
}

// Two balls on a bridge of one voxel: without one ball and the bridge, all that is left is locally right.
TEST(Verify, CatchesAPartThatHungOnAThinBridge) {
  Grid grid;
  grid.dims = {60, 22, 22};
  const VoxelShape shape = testing_shapes::from_predicate(grid, [](int x, int y, int z) {
    const double b = y - 10.4, c = z - 10.3, left = x - 11.2, right = x - 48.1;
    return left * left + b * b + c * c < 81 || right * right + b * b + c * c < 81 ||
           (y == 10 && z == 10 && x > 10 && x < 50);
  });
  const MedialAxis axis = core_with_levels(shape);
  const Record whole = result_of(axis, shape, 2);
  ASSERT_EQ(failed_checks(shape, whole), std::set<std::string>{});
  Record half = whole;
  half.cell_data.clear();
  const auto keep = [&](std::uint32_t v) { return whole.points[v][0] < 24; };
  std::erase_if(half.verts, [&](std::uint32_t v) { return !keep(v); });
  std::erase_if(half.lines, [&](const auto& line) { return !keep(line[0]) || !keep(line[1]); });
  half.poly_offsets = {0};
  half.poly_corners.clear();
  std::set<std::uint32_t> on_sheets;
  for (std::size_t p = 0; p < whole.poly_count(); ++p) {
    const auto begin = whole.poly_corners.begin() + whole.poly_offsets[p],
               end = whole.poly_corners.begin() + whole.poly_offsets[p + 1];
    if (!std::all_of(begin, end, keep)) continue;
    half.poly_corners.insert(half.poly_corners.end(), begin, end);
    half.poly_offsets.push_back(static_cast<std::uint32_t>(half.poly_corners.size()));
    on_sheets.insert(begin, end);
  }
  for (bool trimmed = true; trimmed;) {  // the stump of the bridge
    std::map<std::uint32_t, int> degree;
    for (const auto& line : half.lines)
      for (std::uint32_t v : line) ++degree[v];
    trimmed = std::erase_if(half.lines, [&](const auto& line) {
                return std::any_of(line.begin(), line.end(),
                                   [&](std::uint32_t v) { return degree[v] == 1 && !on_sheets.contains(v); });
              }) > 0;
  }
  EXPECT_TRUE(failed_checks(shape, half).contains("reconstructed"));
}

TEST(Verify, CatchesLevelsThatAreNoFamilyOfPrunings) {
  const VoxelShape shape = testing_shapes::random_shape(5, 12);
  const MedialAxis axis = core_with_levels(shape);
  Record data = result_of(axis, shape, 0);
  ASSERT_EQ(failed_checks(shape, data), std::set<std::string>{});
  for (DataArray& array : data.cell_data)
    if (array.name == "lambda_level") {
      auto& levels = std::get<std::vector<double>>(array.values);
      std::reverse(levels.begin(), levels.end());
    }
  EXPECT_EQ(failed_checks(shape, data), std::set<std::string>{"nested levels"});
}

TEST(Reconstruction, TheFullCoreHoldsEveryCentreAndSharesFallWithLambda) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const VoxelShape shape = seed == 0 ? roof(22) : testing_shapes::random_shape(seed, 12, seed % 2 == 1);
    const MedialAxis axis = core_with_levels(shape);
    const Reconstruction reconstruction =
        tbb::task_arena(seed % 3 == 0 ? 1 : 3).execute([&] { return Reconstruction(shape, axis); });
    ASSERT_EQ(reconstruction.share(0), 1) << "seed " << seed;
    double last = 1;
    for (double lambda = 0.3; lambda < 6; lambda *= 1.3) {
      // By brute force, from the balls of the pruning.
      const MedialAxis kept = pruned(axis, lambda);
      std::int64_t inside = 0;
      for (int z = 0; z < shape.grid().dims[2]; ++z)
        for (int y = 0; y < shape.grid().dims[1]; ++y)
          for (int x = 0; x < shape.grid().dims[0]; ++x) {
            if (!shape.contains(x, y, z)) continue;
            const Vec3 c = shape.grid().world({x + 0.5, y + 0.5, z + 0.5});
            bool found = false;
            for (std::size_t v = 0; v < kept.points.size() && !found; ++v)
              found = (kept.points[v] - c).norm() <= kept.radius[v] * (1 + 1e-9);
            inside += found;
          }
      const double share = reconstruction.share(lambda);
      ASSERT_NEAR(share, static_cast<double>(inside) / static_cast<double>(shape.voxel_count()), 1e-12);
      ASSERT_LE(share, last);
      last = share;
    }
  }
}

TEST(AutoLambda, KeepsThinShapesAndCleansThickOnes) {
  const auto of = [](const VoxelShape& shape) {
    const MedialAxis axis = core_with_levels(shape);
    return auto_lambda(Reconstruction(shape, axis), shape.longest_side(), 1);
  };
  // Every cell of the bar has lambda sqrt(1/2), so any larger threshold contracts it to a point.
  EXPECT_LE(of(testing_shapes::box_shape(1, 1, 200)), std::sqrt(0.5) * (1 + 1e-12));
  Grid grid;
  grid.dims = {70, 70, 70};
  const VoxelShape ball = testing_shapes::from_predicate(grid, [](int x, int y, int z) {
    const double a = x - 34.3, b = y - 34.1, c = z - 34.6;
    return a * a + b * b + c * c < 32 * 32;
  });
  EXPECT_GT(of(ball), 0.5);
}

// Thresholds of cells without levels mean nothing: an empty axis would be a wrong answer.
TEST(Prune, NeedsLevels) {
  const VoxelShape shape = testing_shapes::box_shape(6, 5, 4);
  const MedialAxis whole = core_with_levels(shape);
  const auto expect_refused = [](const auto& use) {
    try {
      use();
      ADD_FAILURE() << "taken without levels";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::usage);
      EXPECT_NE(std::string(error.what()).find("prune_levels()"), std::string::npos) << error.what();
    }
  };
  MedialAxis none = voxel_core(shape), one_short = whole;
  one_short.measure().level.face.pop_back();
  for (const MedialAxis& axis : {none, one_short}) {
    expect_refused([&] { static_cast<void>(pruned(axis, 1)); });
    expect_refused([&] { static_cast<void>(pruned(MedialAxis(axis), 1)); });
  }
  expect_refused([&] { Reconstruction(shape, none); });
  EXPECT_EQ(pruned(MedialAxis(), 1).complex.vertex_count, 0u);
}

TEST(AutoLambda, RefusesLengthsThatAreNone) {
  const VoxelShape shape = testing_shapes::box_shape(6, 5, 4);
  const Reconstruction reconstruction(shape, core_with_levels(shape));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const auto& [side, spacing] : std::vector<std::pair<double, double>>{
           {8, 0}, {8, -1}, {8, nan}, {8, kInfinity}, {nan, 1}, {kInfinity, 1}, {-8, 1}}) {
    try {
      auto_lambda(reconstruction, side, spacing);
      ADD_FAILURE() << side << " " << spacing;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::usage);
    }
  }
  EXPECT_EQ(auto_lambda(reconstruction, 0, 1), 0);
}

}  // namespace prune_test
}  // namespace quench
