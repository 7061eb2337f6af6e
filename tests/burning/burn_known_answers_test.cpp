// SPDX-License-Identifier: Apache-2.0
// Burn times in closed form (derivations: burn_shapes.h), bounds for both propagations: what was measured, rounded up.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>

#include "brute_force_burn.h"
#include "burn_by_nodes.h"
#include "burn_shapes.h"
#include "data.h"
#include "quench/axis.h"
#include "quench/burn.h"
#include "quench/io.h"
#include "quench/shape.h"
#include "random_shapes.h"

namespace quench {
namespace burn_known_answers_test {

using namespace testing_complexes;
using testing_burn::burn_by;
using testing_burn::Propagation;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
const double kRoot2 = std::sqrt(2.0);

Burning burn(const BurnInput& input, double omega, Propagation by) {
  return burn_by(by, input.complex, input.points, input.radius, {.omega = omega, .radius = input.rule});
}

struct Errors {
  double mean = 0, least = kInfinity, largest = -kInfinity;
};
Errors errors_of(const KnownBurn& known, const Burning& found) {
  Errors e;
  std::size_t count = 0;
  for (std::size_t v = 0; v < known.truth.size(); ++v) {
    if (std::isnan(known.truth[v])) continue;
    const double error = found.burn_time[v] - known.truth[v];
    e.mean += std::abs(error);
    e.least = std::min(e.least, error);
    e.largest = std::max(e.largest, error);
    ++count;
  }
  e.mean /= static_cast<double>(count);
  return e;
}

struct Bound {
  double mean, largest;
};
// By windows: no spacing, and rounding only; plane waves, of linear radii, to 1e-6 of an edge.
void expect_exact(const KnownBurn& known, const std::string& name) {
  const Errors e = errors_of(known, burn(known.input, 20, Propagation::windows));
  // The closed forms of cones are minima that were looked for.
  const bool sharp = known.input.rule == RadiusRule::exact && name.find("cone") == std::string::npos;
  const double bound = sharp ? 1e-11 : 2e-6;
  EXPECT_LE(e.largest, bound) << name << " by windows";
  EXPECT_GE(e.least, -bound) << name << " by windows";
}
// Spacing 0.5 on sheets some 10 units wide.
void expect_near(const KnownBurn& known, Bound nodes, Bound segments, const std::string& name) {
  expect_exact(known, name);
  for (Propagation propagation : {Propagation::nodes, Propagation::segments}) {
    const bool by_nodes = propagation == Propagation::nodes;
    const Errors e = errors_of(known, burn(known.input, 0.5, propagation));
    const Bound bound = by_nodes ? nodes : segments;
    const std::string what = name + (by_nodes ? " by nodes" : " by segments");
    EXPECT_LE(e.mean, bound.mean) << what;
    EXPECT_LE(e.largest, bound.largest) << what;
    EXPECT_GE(e.least, by_nodes ? -1e-5 : -bound.largest) << what;  // the closed forms of cones are good to 1e-5
  }
}

TEST(BurnKnownAnswers, SquareOfConstantRadius) { expect_near(square_sheet(), {0.015, 0.1}, {1e-7, 1e-6}, "square"); }

TEST(BurnKnownAnswers, SquareUnderASite) {
  expect_near(square_under_site(), {0.02, 0.12}, {1e-7, 1e-6}, "square under a site");
}

// With the site in the sheet's plane, outside the sheet, all paths are straight: no erosion at all.
TEST(BurnKnownAnswers, SquareBesideASite) {
  expect_near(square_under_site({-2, 4, 0}), {0.04, 0.15}, {1e-7, 1e-6}, "square beside a site");
}

TEST(BurnKnownAnswers, LSheet) { expect_near(l_sheet(), {0.01, 0.05}, {1e-7, 1e-6}, "L"); }

TEST(BurnKnownAnswers, ConeAndSaddleCone) {
  expect_near(cone(5, 4, -3, -3, 3), {0.02, 0.1}, {1e-7, 1e-6}, "cone");
  expect_near(cone(6, 4, 2, -2, 3), {0.02, 0.12}, {1e-7, 1e-6}, "saddle cone");
}

TEST(BurnKnownAnswers, ThreeSheetsOnASeam) {
  expect_near(three_sheets(), {0.02, 0.12}, {1e-7, 1e-6}, "three sheets");
}

TEST(BurnKnownAnswers, MedialAxisOfABox) {
  expect_near(box_axis(12, 9, 6, 5), {0.01, 0.1}, {1e-7, 1e-6}, "box");
  const KnownBurn known = box_axis(12, 9, 6, 5);
  const Burning found = burn(known.input, 0.125, Propagation::segments);
  int rim = 0;
  for (std::size_t v = 0; v < known.input.points.size(); ++v) {
    const Vec3& p = known.input.points[v];
    if (p[2] != 3 || std::min({p[0] - 3, 9 - p[0], p[1] - 3, 6 - p[1]}) > 1e-9) continue;
    ++rim;
    EXPECT_NEAR(found.burn_time[v], 6 / kRoot2, 1e-5);
    EXPECT_NEAR(found.erosion_thickness[v], 6 * (1 / kRoot2 - 0.5), 1e-5);
  }
  EXPECT_EQ(rim, 20);
}

// The same from voxels of side 1: the core's middle sheet ends some way before the box's, within the bound on cores.
TEST(BurnKnownAnswers, VoxelBox) {
  const double a = 36, b = 24, c = 12;
  MedialAxis core = voxel_core(testing_shapes::box_shape(36, 24, 12));
  prune_levels(core);
  const MedialAxis axis = pruned(core, 0.9);
  Vec3 low = Vec3::Constant(1e9);
  const Grid& grid = core.grid;
  low = grid.world({1, 1, 1});  // the box's corner, behind the margin
  for (Propagation propagation : {Propagation::nodes, Propagation::segments}) {
    const Burning found = burn({axis.complex, axis.points, axis.radius, RadiusRule::exact, true}, 0.25, propagation);
    EXPECT_EQ(found.unburned, 0u);
    int rim = 0, inner = 0;
    for (std::size_t v = 0; v < axis.points.size(); ++v) {
      const Vec3 p = axis.points[v] - low;
      if (std::abs(p[2] - c / 2) > 1e-6) continue;
      const double inside = std::min({p[0] - c / 2, a - c / 2 - p[0], p[1] - c / 2, b - c / 2 - p[1]});
      if (inside < -1) continue;
      inner += inside > 1;
      rim += inside < 1;
      EXPECT_NEAR(found.burn_time[v], c / kRoot2 + inside, 3) << p.transpose();
      EXPECT_NEAR(found.erosion_thickness[v], c * (1 / kRoot2 - 0.5) + inside, 3) << p.transpose();
    }
    EXPECT_GT(rim, 40);
    EXPECT_GT(inner, 200);
  }
}

TEST(BurnKnownAnswers, FireRunsOnBesideASeam) {
  expect_near(chimney(), {0.06, 0.22}, {0.0005, 0.012}, "chimney");
  // The seam node behind the chimney, in the middle between its rear corners: its plate sheet burns when the fire has
  // come round; the node itself when the chimney's fire is down, by the front wall and the plate's inside at 42.6.
  const KnownBurn known = chimney();
  for (Propagation propagation : {Propagation::nodes, Propagation::segments}) {
    const Burning found = burn(known.input, 0.25, propagation);
    for (std::size_t c = 0; c < known.input.complex.face_vertices.size(); ++c) {
      const std::uint32_t v = known.input.complex.face_vertices[c];
      if ((known.input.points[v] - Vec3(1, 0, 0)).norm() > 1e-9) continue;
      const auto corners = known.input.complex.corners(found.sectors->network.corner_face[c]);
      const bool outside = std::any_of(corners.begin(), corners.end(),
                                       [&](std::uint32_t w) { return known.input.points[w][0] > 1 + 1e-9; });
      const double time = found.sectors->state_time[found.sectors->network.corner_state[c]];
      if (outside) {
        EXPECT_NEAR(time, std::sqrt(26) + 3, 0.05);
      } else {
        EXPECT_GT(time, 40);
      }
    }
  }
}

TEST(BurnKnownAnswers, TetrahedralJunction) {
  expect_near(tetrahedral_junction(10, 4), {0.08, 0.08}, {1e-7, 1e-6}, "junction");
  const KnownBurn known = tetrahedral_junction(10, 4);
  const Burning found = burn(known.input, 0.5, Propagation::segments);
  int primes = 0;
  for (std::uint32_t s = found.sectors->network.vertex_base[0]; s < found.sectors->network.vertex_base[1]; ++s)
    primes += found.sectors->parent[s] != kNone;
  EXPECT_EQ(found.sectors->network.vertex_base[1], 6u);
  EXPECT_EQ(primes, 3);  // loops of the complete graph on four rays
}

// Two discs joined by a curve: the curve has no sheet to wear off, and the discs burn as if it were not there.
TEST(BurnKnownAnswers, DiscsJoinedByACurve) {
  Builder b;
  pyramid(b, {0, 0, 0}, 0, 4, 8);
  pyramid(b, {20, 0, 0}, 0, 3, 8);
  b.polyline({{0, 0, 0}, {6, 0, 5}, {14, 0, 5}, {20, 0, 0}});
  const BurnInput input = b.input([](const Vec3& p) { return 1 + 0.01 * p[0]; });
  for (Propagation propagation : {Propagation::nodes, Propagation::segments}) {
    const Burning found = burn(input, 0.1, propagation);
    EXPECT_EQ(found.unburned, 0u);
    for (const Vec3& p : {Vec3(6, 0, 5), Vec3(14, 0, 5)}) {
      const std::uint32_t v = b.vertex(p);
      EXPECT_EQ(found.burn_time[v], input.radius[v]);
      EXPECT_EQ(found.erosion_thickness[v], 0);
    }
    // The radius grows by 0.01 along x, so by 0.04 from a disc's centre to its rim.
    EXPECT_NEAR(found.burn_time[b.vertex({0, 0, 0})], 1 + pyramid_height(0, 4, 8), 0.05);
    EXPECT_NEAR(found.burn_time[b.vertex({20, 0, 0})], 1.2 + pyramid_height(0, 3, 8), 0.05);
  }
}

TEST(BurnKnownAnswers, PinchPoint) {
  Builder b;
  pyramid(b, {0, 0, 0}, 3, 4, 5);
  pyramid(b, {0, 0, 0}, -1, 2, 4);
  const BurnInput input = b.input([](const Vec3&) { return 1.0; });
  for (Propagation propagation : {Propagation::nodes, Propagation::segments}) {
    const Burning found = burn(input, 0.05, propagation);
    const std::uint32_t tip = b.vertex({0, 0, 0}), s = found.sectors->network.vertex_base[tip];
    ASSERT_EQ(found.sectors->network.vertex_base[tip + 1], s + 2);  // two sectors, neither opens the other
    EXPECT_NEAR(found.burn_time[tip], 1 + pyramid_height(3, 4, 5), 1e-3);
    EXPECT_NEAR(std::min(found.sectors->state_time[s], found.sectors->state_time[s + 1]), 1 + pyramid_height(-1, 2, 4),
                1e-3);
    EXPECT_NE(found.sectors->parent[s], kNone);
    EXPECT_NE(found.sectors->parent[s + 1], kNone);
  }
}

// A closed surface never burns; a rectangular flap on an edge of it does, from its three free sides.
TEST(BurnKnownAnswers, SphereWithAFlap) {
  Random random(9);
  Builder b;
  std::vector<std::uint32_t> v;
  const double side = 4;  // corners of a box; its front edge is cut to fit the flap
  b.sheet({0, 0, 0}, {0, side, 0}, {0, 0, 8}, 2, 4);
  b.sheet({-side, 0, 0}, {0, side, 0}, {0, 0, 8}, 2, 4);
  b.sheet({0, 0, 0}, {-side, 0, 0}, {0, 0, 8}, 2, 4);
  b.sheet({0, side, 0}, {-side, 0, 0}, {0, 0, 8}, 2, 4);
  b.sheet({0, 0, 0}, {-side, 0, 0}, {0, side, 0}, 2, 2);
  b.sheet({0, 0, 8}, {-side, 0, 0}, {0, side, 0}, 2, 2);
  const std::size_t closed = b.points.size();
  jittered_sheet(b, {0, 0, 0}, {5, 0, 0}, {0, 0, 8}, 5, 4, random);
  const BurnInput input = b.input([](const Vec3&) { return 1.0; });
  ASSERT_EQ(topology(input.complex).betti[2], 1);
  for (Propagation propagation : {Propagation::nodes, Propagation::segments}) {
    const Burning found = burn(input, 0.5, propagation);
    EXPECT_EQ(found.unburned, closed);
    for (std::size_t i = 0; i < input.points.size(); ++i) {
      if (i < closed) {
        EXPECT_EQ(found.burn_time[i], kInfinity);
        EXPECT_EQ(found.erosion_thickness[i], kInfinity);
      } else {
        const Vec3& p = input.points[i];
        EXPECT_NEAR(found.burn_time[i], 1 + std::min({5 - p[0], p[2], 8 - p[2]}), 0.1);
      }
    }
    for (std::size_t c = 0; c < input.complex.face_vertices.size(); ++c) {
      EXPECT_EQ(found.sectors->state_time[found.sectors->network.corner_state[c]] == kInfinity,
                found.sectors->network.pocket[found.sectors->network.corner_face[c]] != 0);
    }
    EXPECT_LT(found.max_burn_time, 1 + 5);
  }
}

// Along the rungs fire comes from the rim at unit speed: by nodes no inner vertex is later. No path in space is shorter
// than the straight line to the rim.
TEST(BurnKnownAnswers, MoebiusStrip) {
  const double width = 4, circle = 8;
  const BurnInput input = moebius_strip(width, circle, 48, 4);
  ASSERT_EQ(topology(input.complex), (Topology{0, {1, 1, 0}}));
  std::vector<int> uses(input.complex.edges.size(), 0);
  for (std::uint32_t e : input.complex.face_edges) ++uses[e];
  for (Propagation propagation : {Propagation::nodes, Propagation::segments}) {
    const Burning found = burn(input, 0.25, propagation);
    EXPECT_EQ(found.unburned, 0u);
    double largest = 0;
    for (std::size_t v = 0; v < input.points.size(); ++v) {
      double nearest = kInfinity;
      for (std::size_t e = 0; e < uses.size(); ++e)
        if (uses[e] == 1)
          nearest = std::min(nearest, distance_to_segment(input.points[v], input.points[input.complex.edges[e][0]],
                                                          input.points[input.complex.edges[e][1]]));
      EXPECT_GE(found.burn_time[v], 1 + nearest - 0.01);
      EXPECT_LE(found.burn_time[v], 1 + width / 2 + 1e-9);
      largest = std::max(largest, found.erosion_thickness[v]);
    }
    EXPECT_GT(largest, 0.9 * width / 2);
  }
}

// The authors' core of the bunny with burn times of their program at spacings 0.575 and 0.0575 (references/README.md),
// an upper bound on the same nodes. Their radius is linear on edges.
struct AuthorsBunny {
  CellComplex complex;
  std::vector<Vec3> points;
  std::vector<double> radius;
  std::array<std::vector<double>, 2> burn_time;

  AuthorsBunny() {
    const Record mesh = io::read_record(data_file("references/bunny7_lambda0.025.ply"));
    std::vector<std::uint32_t> row;
    complex = complex_of(mesh, &row);
    std::ifstream table(data_file("references/bunny7_burn.tsv"));
    std::vector<std::array<double, 3>> lines;
    for (std::string line; std::getline(table, line);) {
      std::istringstream in(line);
      double vertex = 0;
      std::array<double, 3> values{};
      if (in >> vertex >> values[0] >> values[1] >> values[2]) lines.push_back(values);
    }
    EXPECT_EQ(lines.size(), mesh.points.size());
    for (std::uint32_t r : row) {
      points.push_back(mesh.points[r]);
      radius.push_back(lines[r][0]);
      for (std::size_t column : {0u, 1u}) burn_time[column].push_back(lines[r][column + 1]);
    }
  }
  Burning burned(double omega, Propagation propagation) const {
    return burn_by(propagation, complex, points, radius, {.omega = omega, .radius = RadiusRule::linear});
  }
};

struct Difference {
  double mean = 0, least = kInfinity, largest = -kInfinity;
};
Difference difference(const std::vector<double>& found, const std::vector<double>& reference) {
  Difference d;
  for (std::size_t v = 0; v < found.size(); ++v) {
    const double here = found[v] - reference[v];
    d.mean += here / static_cast<double>(found.size());
    d.least = std::min(d.least, here);
    d.largest = std::max(d.largest, here);
  }
  return d;
}

#define REQUIRE_AUTHORS_BUNNY()               \
  REQUIRE_DATA("references/bunny7_burn.tsv"); \
  REQUIRE_DATA("references/bunny7_lambda0.025.ply")

// On their nodes, round(L / spacing) parts of an edge and at least two, the definition is never above their times.
TEST(BurnAuthorsBunny, TheirTimesAreAnUpperBoundOnTheirNodes) {
  REQUIRE_AUTHORS_BUNNY();
  const AuthorsBunny bunny;
  ASSERT_EQ(bunny.complex.vertex_count, 14353u);
  ASSERT_EQ(bunny.complex.face_count(), 27318u);
  std::vector<std::uint32_t> pieces;
  for (const auto& [a, b] : bunny.complex.edges)
    pieces.push_back(
        1 + static_cast<std::uint32_t>(std::max((bunny.points[a] - bunny.points[b]).norm() / 0.575 - 1, 1.0) + 0.5));
  const testing_burn::BruteForceBurn oracle(bunny.complex, bunny.points, bunny.radius, pieces, RadiusRule::linear);
  const Difference d = difference(oracle.vertex_time, bunny.burn_time[0]);
  EXPECT_LT(d.largest, 1e-4);
  EXPECT_NEAR(d.mean, -0.22, 0.01);
}

TEST(BurnAuthorsBunny, ByNodesEqualsTheDefinition) {
  REQUIRE_AUTHORS_BUNNY();
  const AuthorsBunny bunny;
  const Burning found = bunny.burned(0.575, Propagation::nodes);
  const testing_burn::BruteForceBurn oracle(bunny.complex, bunny.points, bunny.radius,
                                            testing_burn::pieces_for(bunny.complex, bunny.points, 0.575),
                                            RadiusRule::linear);
  ASSERT_EQ(found.sectors->network.pieces, oracle.pieces);
  EXPECT_EQ(found.unburned, 0u);
  for (std::size_t c = 0; c < bunny.complex.face_vertices.size(); ++c)
    ASSERT_NEAR(found.sectors->state_time[found.sectors->network.corner_state[c]],
                oracle.time[oracle.state_at(bunny.complex.face_vertices[c], oracle.place_in_link[c])], 1e-9);
  // Other nodes than theirs, so single vertices may be later by part of the spacing.
  const Difference d = difference(found.burn_time, bunny.burn_time[0]);
  EXPECT_LT(d.largest, 0.25);
  EXPECT_LT(d.mean, -0.2);
  EXPECT_GT(d.least, -2.5);
}

TEST(BurnAuthorsBunny, FineNodesMeetTheirFineTimes) {
  REQUIRE_AUTHORS_BUNNY();
  const AuthorsBunny bunny;
  const Burning fine = bunny.burned(0.0575, Propagation::nodes);
  const Difference d = difference(fine.burn_time, bunny.burn_time[1]);
  EXPECT_LT(d.largest, 0.03);
  EXPECT_LT(d.mean, 0);
  EXPECT_GT(d.mean, -0.03);
  EXPECT_GT(d.least, -0.35);
  // Segments at ten times the spacing are within half a percent of ET where it is above a voxel, and below the authors'
  // times at that spacing.
  const Burning segments = bunny.burned(0.575, Propagation::segments);
  double relative = 0;
  int thick = 0;
  for (std::size_t v = 0; v < bunny.points.size(); ++v) {
    const double et = fine.erosion_thickness[v];
    if (et <= 1) continue;
    relative += std::abs(segments.burn_time[v] - fine.burn_time[v]) / et;
    ++thick;
  }
  EXPECT_GT(thick, 5000);
  EXPECT_LT(relative / thick, 0.005);
  EXPECT_LT(difference(segments.burn_time, bunny.burn_time[0]).largest, 0.01);
}

}  // namespace burn_known_answers_test
}  // namespace quench
