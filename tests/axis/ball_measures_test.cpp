// SPDX-License-Identifier: Apache-2.0
// Circumradius, scale axis and chord residual: closed forms and brute force.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "plane_shapes.h"
#include "quench/axis.h"
#include "quench/error.h"
#include "quench/measures.h"
#include "random_shapes.h"

namespace quench {
namespace ball_measures_test {

using testing_planes::plane_grid;
using testing_planes::plane_shape;
using testing_planes::random_plane_shape;
using testing_shapes::box_shape;
using testing_shapes::random_shape;

constexpr double kInfinite = std::numeric_limits<double>::infinity();

double scale_by_all(const MedialAxis& axis, std::size_t v) {
  double scale = kInfinite;
  for (std::size_t w = 0; w < axis.points.size(); ++w)
    if (const double more = axis.radius[w] - axis.radius[v]; more > 1e-9 * axis.radius[v])
      scale = std::min(scale, std::max(1.0, (axis.points[v] - axis.points[w]).norm() / more));
  return scale;
}

/// Of faces, edges without faces and vertices without edges the smallest of their corners, of others the largest
/// around.
void expect_of_corners(const MedialAxis& axis, const std::vector<double>& of_vertices, const CellValues& found,
                       const std::string& what) {
  const CellComplex& complex = axis.complex;
  ASSERT_TRUE(found.complete(complex)) << what;
  std::vector<double> edge(complex.edges.size(), -1), vertex(complex.vertex_count, -1);
  for (std::size_t f = 0; f < complex.face_count(); ++f) {
    double least = kInfinite;
    for (const std::uint32_t v : complex.corners(f)) least = std::min(least, of_vertices[v]);
    ASSERT_EQ(found.face[f], least) << what;
    for (const std::uint32_t e : complex.sides(f)) edge[e] = std::max(edge[e], least);
  }
  for (std::size_t e = 0; e < edge.size(); ++e) {
    const auto [a, b] = complex.edges[e];
    if (edge[e] < 0) edge[e] = std::min(of_vertices[a], of_vertices[b]);
    for (const std::uint32_t v : {a, b}) vertex[v] = std::max(vertex[v], edge[e]);
  }
  for (std::size_t v = 0; v < vertex.size(); ++v)
    if (vertex[v] < 0) vertex[v] = of_vertices[v];
  ASSERT_EQ(found.edge, edge) << what;
  ASSERT_EQ(found.vertex, vertex) << what;
}

void expect_by_definition(const VoxelShape& shape, const std::string& what) {
  MedialAxis axis = voxel_core(shape);
  add_scale_axis(axis);
  add_circumradius(axis);
  expect_of_corners(axis, axis.radius, axis.measure(kCircumradius).value, what);
  std::vector<double> scale;
  for (std::size_t v = 0; v < axis.points.size(); ++v) scale.push_back(scale_by_all(axis, v));
  expect_of_corners(axis, scale, axis.measure(kScaleAxis).value, what);
  for (const double s : scale) ASSERT_GE(s, 1 - 1e-9) << what;
}

TEST(BallMeasures, AreThoseOfTheDefinition) {
  for (std::uint64_t seed = 0; seed < 400 && !testing::Test::HasFatalFailure(); ++seed)
    expect_by_definition(random_shape(seed, 9, seed % 3 == 0), "seed " + std::to_string(seed));
}

TEST(BallMeasures, AreThoseOfTheDefinitionInThePlane) {
  for (std::uint64_t seed = 0; seed < 200 && !testing::Test::HasFatalFailure(); ++seed)
    expect_by_definition(random_plane_shape(seed, 14), "seed " + std::to_string(seed));
}

// A rectangle: along the diagonals balls grow by 1 in sqrt 2, along the middle not at all. Pixels blur it by some
// percent.
TEST(BallMeasures, ScaleAxisOfARectangle) {
  MedialAxis axis = voxel_core(plane_shape(plane_grid(200, 80), [](int, int) { return true; }));
  add_scale_axis(axis);
  const std::vector<double>& scale = axis.measure(kScaleAxis).value.vertex;
  std::size_t middle = 0, diagonal = 0;
  for (std::size_t v = 0; v < scale.size(); ++v) {
    if (axis.radius[v] > 40 - 1e-9) {
      EXPECT_GT(scale[v], 100);
      ++middle;
    } else if (axis.radius[v] > 10) {
      EXPECT_NEAR(scale[v], std::sqrt(2.0), 0.02);
      ++diagonal;
    }
  }
  EXPECT_GT(middle, 100u);
  EXPECT_GT(diagonal, 50u);
}

// Between opposite points of a rectangle the way leads around the nearer side, between neighbours of a corner over it.
TEST(BallMeasures, ChordResidualOfARectangle) {
  const VoxelShape shape = plane_shape(plane_grid(20, 8), [](int, int) { return true; });
  MedialAxis axis = voxel_core(shape);
  add_chord_residual(axis, shape);
  const std::vector<double>& residual = axis.measure(kChordResidual).value.edge;
  for (std::size_t e = 0; e < residual.size(); ++e) {
    const LatticePoint &a = axis.sites[axis.edge_sites[e][0]], &b = axis.sites[axis.edge_sites[e][1]];
    const double across = std::abs(a[0] - b[0]), up = std::abs(a[1] - b[1]);
    if (across == 0 && up == 8) {
      EXPECT_NEAR(residual[e], 2 * std::min(a[0], 20 - a[0]), 1e-12);
    } else if (across == up && across < 4) {
      EXPECT_NEAR(residual[e], (2 - std::sqrt(2.0)) * across, 1e-12);
    }
  }
}

TEST(BallMeasures, OfABox) {
  const VoxelShape shape = box_shape(20, 16, 6, 0);
  MedialAxis axis = voxel_core(shape);
  add_chord_residual(axis, shape);
  add_circumradius(axis);
  std::size_t middle = 0;
  for (std::size_t f = 0; f < axis.complex.face_count(); ++f) {
    const LatticePoint &a = axis.sites[axis.face_sites[f][0]], &b = axis.sites[axis.face_sites[f][1]];
    if (a[0] != b[0] || a[1] != b[1]) continue;
    const double side = std::min({a[0], 20 - a[0], a[1], 16 - a[1]});
    EXPECT_NEAR(axis.measure(kChordResidual).value.face[f], 2 * side, 1e-9);
    if (side <= 4) continue;
    EXPECT_NEAR(axis.measure(kCircumradius).value.face[f], std::sqrt(9.5), 1e-12);
    ++middle;
  }
  EXPECT_GT(middle, 50u);
}

TEST(BallMeasures, ChordResidualIsTheSameWithAndWithoutMgf) {
  for (std::uint64_t seed = 0; seed < 60 && !testing::Test::HasFatalFailure(); ++seed) {
    const VoxelShape shape = random_shape(seed, 7, seed % 3 == 0);
    MedialAxis first = voxel_core(shape), second = first;
    add_chord_residual(first, shape);
    add_mgf(second, shape);
    add_chord_residual(second, shape);
    const CellValues &a = first.measure(kChordResidual).value, &b = second.measure(kChordResidual).value,
                     &mgf = second.measure(kMgf).value;
    ASSERT_EQ(a.face, b.face) << seed;
    ASSERT_EQ(a.edge, b.edge) << seed;
    ASSERT_EQ(a.vertex, b.vertex) << seed;
    for (std::size_t f = 0; f < a.face.size(); ++f) {
      if (std::isinf(mgf.face[f])) {
        ASSERT_EQ(a.face[f], kInfinite) << seed;
        continue;
      }
      ASSERT_NEAR(a.face[f], mgf.face[f] - 2 * second.measure().value.face[f], 1e-8) << seed;
      ASSERT_GE(a.face[f], 0) << seed;
    }
  }
}

TEST(BallMeasures, DoNotDependOnThreads) {
  const VoxelShape shape = random_shape(6, 24);
  std::vector<CellValues> found;
  for (const int threads : {1, 2, 5}) {
    Context context;
    context.threads = threads;
    MedialAxis axis = voxel_core(shape, {}, &context);
    add_scale_axis(axis, &context);
    add_chord_residual(axis, shape, &context);
    found.push_back(axis.measure(kScaleAxis).value);
    found.push_back(axis.measure(kChordResidual).value);
  }
  for (std::size_t i = 2; i < found.size(); ++i) {
    EXPECT_EQ(found[i].face, found[i - 2].face);
    EXPECT_EQ(found[i].vertex, found[i - 2].vertex);
  }
}

}  // namespace ball_measures_test
}  // namespace quench
