// SPDX-License-Identifier: Apache-2.0
// Medial curves and the family of skeletons on random complexes: topology, collapses, nesting.
#include "quench/skeleton.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>

#include "quench/topology.h"
#include "random_complexes.h"

namespace quench {
namespace {

using testing_complexes::BurnInput;
using testing_complexes::random_input;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

RefinedAxis refined(const BurnInput& input, double omega, Propagation propagation) {
  BurnOptions options;
  options.omega = omega;
  options.propagation = propagation;
  options.radius = input.rule;
  const Burning burning = burn(input.complex, input.points, input.radius, options);
  return quench_curves(input.complex, input.points, input.radius, burning);
}

double some_omega(std::uint64_t seed) { return std::array{0.3, 0.45, 0.8, 1.7, 20.0}[seed % 5]; }

// The part of K with the given cells, as a complex of its own (vertices renumbered).
CellComplex part_of(const CellComplex& k, const std::vector<char>& vertex, const std::vector<char>& edge,
                    const std::vector<char>& face) {
  CellComplex part;
  std::vector<std::uint32_t> number(k.vertex_count, kNone), edge_number(k.edges.size(), kNone);
  for (std::uint32_t v = 0; v < k.vertex_count; ++v)
    if (vertex[v]) number[v] = part.vertex_count++;
  for (std::uint32_t e = 0; e < k.edges.size(); ++e) {
    if (!edge[e]) continue;
    edge_number[e] = static_cast<std::uint32_t>(part.edges.size());
    for (const std::uint32_t v : k.edges[e]) EXPECT_NE(number[v], kNone) << "an edge without its end";
    part.edges.push_back({number[k.edges[e][0]], number[k.edges[e][1]]});
  }
  for (std::size_t f = 0; f < k.face_count(); ++f) {
    if (!face[f]) continue;
    for (std::size_t i = 0; i < k.corners(f).size(); ++i) {
      EXPECT_NE(edge_number[k.sides(f)[i]], kNone) << "a face without its side";
      part.face_vertices.push_back(number[k.corners(f)[i]]);
      part.face_edges.push_back(edge_number[k.sides(f)[i]]);
    }
    part.face_offsets.push_back(static_cast<std::uint32_t>(part.face_vertices.size()));
  }
  return part;
}

// Sides join consecutive corners; everything is in range.
void expect_incident(const CellComplex& k) {
  for (std::size_t f = 0; f < k.face_count(); ++f) {
    const auto c = k.corners(f);
    ASSERT_GE(c.size(), 3u);
    for (std::size_t i = 0; i < c.size(); ++i) {
      const std::uint32_t a = c[i], b = c[(i + 1) % c.size()];
      ASSERT_LT(k.sides(f)[i], k.edges.size());
      ASSERT_EQ(k.edges[k.sides(f)[i]], (std::array{std::min(a, b), std::max(a, b)})) << "face " << f << " side " << i;
    }
  }
}

// An edge of no length or a polygon of no area.
bool has_flat_cell(const BurnInput& input) {
  for (const auto& e : input.complex.edges)
    if ((input.points[e[0]] - input.points[e[1]]).norm() < 1e-9) return true;
  for (std::size_t f = 0; f < input.complex.face_count(); ++f) {
    const auto c = input.complex.corners(f);
    double area = 0;
    for (std::size_t i = 2; i < c.size(); ++i)
      area += (input.points[c[i - 1]] - input.points[c[0]]).cross(input.points[c[i]] - input.points[c[0]]).norm();
    if (area < 1e-9) return true;
  }
  return false;
}

TEST(Skeleton, EveryMemberHasTheTopologyOfTheAxis) {
  for (std::uint64_t seed = 0; seed < 3000 && !testing::Test::HasFatalFailure(); ++seed) {
    SCOPED_TRACE(seed);
    const BurnInput input = random_input(seed);
    const Topology wanted = topology(input.complex);
    const bool degenerate = has_flat_cell(input);
    const auto propagation = seed % 2 ? Propagation::segments : Propagation::nodes;
    const SkeletonFamily family = skeletons(refined(input, some_omega(seed / 2), propagation));
    const RefinedAxis& k = family.refined;
    expect_incident(k.complex);
    ASSERT_EQ(topology(k.complex), wanted) << "the refined axis";

    // The curves with the pockets: what is left when everything else has collapsed.
    std::vector<char> vertex(k.complex.vertex_count), edge(k.complex.edges.size()), face(k.complex.face_count());
    for (std::size_t f = 0; f < face.size(); ++f) {
      const bool pocket = k.face_thickness[f] == kInfinity;
      ASSERT_EQ(family.face_sheet_level[f] == kInfinity, pocket) << "the collapse is stuck at face " << f;
      face[f] = pocket;
      if (!pocket) continue;
      for (const std::uint32_t e : k.complex.sides(f)) edge[e] = 1;
      for (const std::uint32_t v : k.complex.corners(f)) vertex[v] = 1;
    }
    for (std::size_t e = 0; e < edge.size(); ++e) {
      edge[e] = edge[e] || k.curve_edge[e];
      ASSERT_EQ(family.edge_sheet_level[e] == kInfinity, edge[e] != 0) << "the collapse is stuck at edge " << e;
    }
    for (std::size_t v = 0; v < vertex.size(); ++v) {
      vertex[v] = vertex[v] || k.curve_vertex[v];
      ASSERT_EQ(family.vertex_sheet_level[v] == kInfinity, vertex[v] != 0) << "the collapse is stuck at vertex " << v;
    }
    ASSERT_EQ(topology(part_of(k.complex, vertex, edge, face)), wanted) << "the medial curves";

    for (std::size_t e = 0; e < edge.size(); ++e)
      ASSERT_TRUE(!k.curve_edge[e] || family.thickness_of(static_cast<std::uint32_t>(e)) >= 0);
    for (std::size_t v = 0; v < vertex.size(); ++v)
      ASSERT_TRUE(!k.curve_vertex[v] || k.curve_burn_time[v] >= k.burn_time[v]);

    for (const double theta2 : {0.0, 0.1, 0.5, 1.5, kInfinity})
      for (const double theta1 : {0.0, 0.2, 1.0, kInfinity})
        for (const bool parts : {false, true}) {
          const Skeleton skeleton = extract(family, theta2, theta1, parts);
          skeleton.complex.validate();
          ASSERT_EQ(topology(skeleton.complex), wanted)
              << "theta2 " << theta2 << " theta1 " << theta1 << " parts " << parts;
          for (const auto& [a, b] : skeleton.complex.edges)
            ASSERT_TRUE(degenerate || skeleton.points[a] != skeleton.points[b])
                << skeleton.points[a].transpose() << " of " << a << " " << b << " of " << skeleton.points.size()
                << " an edge of length zero, theta2 " << theta2 << " theta1 " << theta1 << " parts " << parts;
        }
  }
}

}  // namespace
}  // namespace quench
