// SPDX-License-Identifier: Apache-2.0
#include "dual/plane/plane.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "axis/mgf.h"
#include "brute_force_plane.h"
#include "plane_shapes.h"

namespace quench::dual::plane {
namespace {

using brute_force::PlaneCore;
using brute_force::PlaneOracle;
using testing_planes::plane_grid;
using testing_planes::plane_picture;
using testing_planes::plane_shape;
using testing_planes::random_plane_shape;

std::string text(const VoxelShape& shape) {
  std::string rows;
  for (int y = 0; y < shape.grid().dims[1]; ++y) {
    for (int x = 0; x < shape.grid().dims[0]; ++x) rows += shape.contains(x, y, 0) ? '#' : '.';
    rows += '\n';
  }
  return rows;
}

DualComplex dual_of(const VoxelShape& shape) {
  return dual_complex(shape, brute_force::sites_of_plane(shape), integer_spacing(shape.grid()), nullptr);
}

void expect_same_as_oracle(const VoxelShape& shape, std::array<std::int64_t, 2> scale, const std::string& where) {
  const PlaneCore expected = PlaneOracle(shape, scale).run();
  const DualComplex dual = dual_of(shape);
  std::vector<std::uint32_t> offsets{0}, sites;
  for (const auto& vertex : expected.vertices) {
    sites.insert(sites.end(), vertex.sites.begin(), vertex.sites.end());
    offsets.push_back(static_cast<std::uint32_t>(sites.size()));
  }
  std::vector<std::array<std::uint32_t, 2>> edges, edge_sites;
  for (const auto& edge : expected.edges) edges.push_back(edge.ends), edge_sites.push_back(edge.sites);
  const std::string what = where + "\n" + text(shape);
  ASSERT_EQ(dual.complex.vertex_count, expected.vertices.size()) << what;
  ASSERT_EQ(dual.vertex_site_offsets, offsets) << what;
  ASSERT_EQ(dual.vertex_sites, sites) << what;
  ASSERT_EQ(dual.complex.edges, edges) << what;
  ASSERT_EQ(dual.edge_sites, edge_sites) << what;
  ASSERT_EQ(dual.complex.face_count(), 0u) << what;
  ASSERT_TRUE(dual.face_sites.empty()) << what;
  dual.complex.validate();
  const std::vector<double> mgf = axis::mgf_of_edges(shape, expected.sites, edge_sites);
  for (std::size_t e = 0; e < edges.size(); ++e) ASSERT_EQ(mgf[e], expected.edges[e].mgf) << what << "edge " << e;
}

void expect_random_as_oracle(std::uint64_t first, std::uint64_t last, int largest,
                             std::array<std::int64_t, 2> scale = {1, 1}) {
  for (std::uint64_t seed = first; seed < last && !testing::Test::HasFatalFailure(); ++seed)
    expect_same_as_oracle(
        random_plane_shape(seed, largest, {static_cast<double>(scale[0]), static_cast<double>(scale[1])}), scale,
        "seed " + std::to_string(seed));
}

TEST(Plane, RandomShapesAreThoseOfTheOracle) {
  expect_random_as_oracle(0, 20000, 6);
  expect_random_as_oracle(20000, 21000, 9);
}

TEST(Plane, AnisotropicShapesAreThoseOfTheOracle) {
  std::uint64_t seed = 100000;
  for (const std::array<std::int64_t, 2> scale :
       {std::array<std::int64_t, 2>{1, 2}, {2, 1}, {3, 2}, {1, 5}, {391, 2500}, {2500, 391}, {1, 1000}}) {
    expect_random_as_oracle(seed, seed + 1000, 6, scale);
    expect_random_as_oracle(seed, seed + 50, 9, scale);
    seed += 1000;
  }
}

TEST(Plane, OnePixel) {
  const DualComplex dual = dual_of(plane_picture({"#"}));
  EXPECT_EQ(dual.complex.vertex_count, 1u);
  EXPECT_EQ(dual.vertex_sites, (std::vector<std::uint32_t>{0, 1, 2, 3}));
  EXPECT_TRUE(dual.complex.edges.empty());
}

}  // namespace
}  // namespace quench::dual::plane
