// SPDX-License-Identifier: Apache-2.0
// Medial curves and the family of skeletons on random complexes: topology, collapses, nesting.
#include "quench/skeleton.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>

#include "full_run.h"
#include "quench/error.h"
#include "quench/shape.h"
#include "random_complexes.h"
#include "same_skeletons.h"
#include "skeleton/member.h"

namespace quench {
namespace skeleton_test {

using testing_complexes::BurnInput;
using testing_complexes::random_input;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

RefinedAxis refined(const BurnInput& input, double omega) {
  const Burning burning = burn(input.complex, input.points, input.radius, {.omega = omega, .radius = input.rule});
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

double area(const Skeleton& skeleton) {
  double sum = 0;
  for (std::size_t f = 0; f < skeleton.complex.face_count(); ++f) {
    const auto corners = skeleton.complex.corners(f);
    Vec3 twice = Vec3::Zero();
    for (std::size_t i = 2; i < corners.size(); ++i)
      twice += (skeleton.points[corners[i - 1]] - skeleton.points[corners[0]])
                   .cross(skeleton.points[corners[i]] - skeleton.points[corners[0]]);
    sum += 0.5 * twice.norm();
  }
  return sum;
}

TEST(Skeleton, EveryMemberHasTheTopologyOfTheAxis) {
  const std::uint64_t seeds = repeats(3000, 1000);
  for (std::uint64_t seed = 0; seed < seeds && !testing::Test::HasFatalFailure(); ++seed) {
    SCOPED_TRACE(seed);
    const BurnInput input = random_input(seed);
    const Topology wanted = topology(input.complex);
    const bool degenerate = has_flat_cell(input);
    const SkeletonFamily family = skeletons(refined(input, some_omega(seed / 2)));
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
          const Skeleton skeleton = extract(family, theta2, theta1, {.parts = parts, .regrow_tips_above = kInfinity});
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

// The cells of K in a member of the family, by the definition: pairs of the least key first, whatever is free.
struct Cells {
  std::vector<char> vertex, edge, face;
};

Cells greedy(const SkeletonFamily& family, double theta2, double theta1, std::mt19937_64& random) {
  const RefinedAxis& k = family.refined;
  Cells cells;
  for (const double level : family.vertex_sheet_level) cells.vertex.push_back(level >= theta2);
  for (const double level : family.edge_sheet_level) cells.edge.push_back(level >= theta2);
  for (const double level : family.face_sheet_level) cells.face.push_back(level >= theta2);
  for (bool changed = true; changed;) {
    changed = false;
    std::vector<std::uint32_t> degree(k.complex.vertex_count, 0), order;
    std::vector<char> on_face(k.complex.edges.size(), 0);
    for (std::size_t f = 0; f < cells.face.size(); ++f)
      if (cells.face[f])
        for (const std::uint32_t e : k.complex.sides(f)) on_face[e] = 1;
    for (std::uint32_t e = 0; e < cells.edge.size(); ++e)
      if (cells.edge[e]) {
        for (const std::uint32_t v : k.complex.edges[e]) ++degree[v];
        order.push_back(e);
      }
    std::shuffle(order.begin(), order.end(), random);
    for (const std::uint32_t e : order) {
      if (!k.curve_edge[e] || on_face[e] || !(family.thickness_of(e) < theta1)) continue;
      for (const std::uint32_t v : k.complex.edges[e]) {
        if (!cells.edge[e] || degree[v] != 1 || k.medial_point[v]) continue;
        cells.edge[e] = cells.vertex[v] = 0;
        for (const std::uint32_t u : k.complex.edges[e]) --degree[u];
        changed = true;
      }
    }
  }
  return cells;
}

// A member with all its parts has as many cells of each kind as the greedy one; and its curves are the same.
TEST(Skeleton, LinearCurvePruningIsGreedyPruning) {
  std::mt19937_64 random(1);
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE(seed);
    const BurnInput input = random_input(seed);
    const SkeletonFamily family = skeletons(refined(input, some_omega(seed)));
    for (const double theta2 : {0.4, kInfinity})
      for (const double theta1 : {0.3, 1.0, kInfinity}) {
        const Cells cells = greedy(family, theta2, theta1, random);
        const Topology wanted = topology(part_of(family.refined.complex, cells.vertex, cells.edge, cells.face));
        ASSERT_EQ(wanted, topology(input.complex));
        const Skeleton skeleton = extract(family, theta2, theta1, {.parts = true, .regrow_tips_above = kInfinity});
        double expected = 0, found = 0;  // total thickness of curves off the sheets
        std::vector<char> on_face(cells.edge.size(), 0), has_face(skeleton.complex.edges.size(), 0);
        for (std::size_t f = 0; f < cells.face.size(); ++f)
          if (cells.face[f])
            for (const std::uint32_t e : family.refined.complex.sides(f)) on_face[e] = 1;
        for (std::uint32_t e = 0; e < cells.edge.size(); ++e) {
          if (!cells.edge[e] || on_face[e] || !family.refined.curve_edge[e]) continue;
          const std::uint32_t exit_of[2] = {family.refined.exit[family.refined.complex.edges[e][0]],
                                            family.refined.exit[family.refined.complex.edges[e][1]]};
          // Exit edges of region duals are contracted.
          const bool dual = family.refined.complex.edges[e][1] >= family.refined.nodes + family.refined.doors;
          if (dual && (exit_of[1] == e || exit_of[1] == kNone)) continue;
          expected += std::min(family.thickness_of(e), 1e3);
        }
        for (const std::uint32_t e : skeleton.complex.face_edges) has_face[e] = 1;
        for (std::size_t e = 0; e < has_face.size(); ++e)
          if (!has_face[e] && !std::isnan(skeleton.edge_thickness[e]))
            found += std::min(skeleton.edge_thickness[e], 1e3);
        if (theta2 == kInfinity && topology(input.complex).betti[2] == 0 && seed % 3 != 0) {
          // Parallel curves are written with a vertex in the middle, which counts them twice: rare, and only more.
          ASSERT_GE(found, expected - 1e-6) << "theta1 " << theta1;
        }
      }
  }
}

// The family is nested: what a larger threshold keeps, a smaller one keeps.
TEST(Skeleton, MembersAreNested) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE(seed);
    const BurnInput input = random_input(seed);
    const SkeletonFamily family = skeletons(refined(input, some_omega(seed)));
    const auto places = [&](double theta2, double theta1) {
      std::vector<std::array<double, 3>> points;
      for (const Vec3& p : extract(family, theta2, theta1, {.parts = true, .regrow_tips_above = kInfinity}).points)
        points.push_back({p[0], p[1], p[2]});
      std::sort(points.begin(), points.end());
      return points;
    };
    const std::vector<double> thetas{0, 0.2, 0.7, 2, kInfinity};
    for (std::size_t i = 1; i < thetas.size(); ++i) {
      // Curves only, so that vertices are not moved by merging.
      const auto large = places(kInfinity, thetas[i]), small = places(kInfinity, thetas[i - 1]);
      ASSERT_LE(large.size(), small.size()) << "theta1 " << thetas[i];
    }
    for (std::size_t i = 1; i < thetas.size(); ++i) {
      std::size_t large = 0, small = 0;
      for (const double level : family.face_sheet_level) {
        large += level >= thetas[i];
        small += level >= thetas[i - 1];
      }
      ASSERT_LE(large, small);
    }
    // Closed: a cell stays as long as what it bounds.
    const CellComplex& k = family.refined.complex;
    for (std::size_t f = 0; f < k.face_count(); ++f)
      for (const std::uint32_t e : k.sides(f)) ASSERT_GE(family.edge_sheet_level[e], family.face_sheet_level[f]);
    for (std::size_t e = 0; e < k.edges.size(); ++e)
      for (const std::uint32_t v : k.edges[e]) ASSERT_GE(family.vertex_sheet_level[v], family.edge_sheet_level[e]);
  }
}

// What of the sheets a member has is part of what one with a smaller theta2 has, whether they grow back or not.
TEST(Skeleton, SheetsAreNested) {
  using skeleton::Member;
  std::size_t cut = 0, grown = 0;
  for (std::uint64_t seed = 0; seed < 1500; ++seed) {
    SCOPED_TRACE(seed);
    const BurnInput input = random_input(seed);
    const SkeletonFamily family = skeletons(refined(input, some_omega(seed)));
    const CellComplex& k = family.refined.complex;
    for (const double rims : {0.05, 0.4, kInfinity}) {
      std::vector<char> more(k.face_count(), Member::kWhole);  // with the theta2 before
      for (const double theta2 : {0.1, 0.3, 0.7, 1.5}) {
        const ExtractOptions options{.regrow_rims_above = rims, .minor_curve = 0.3};
        const Member member = skeleton::member_of(family, theta2, 0, options);
        for (std::size_t f = 0; f < more.size(); ++f) {
          ASSERT_TRUE(member.face[f] == Member::kNo || member.face[f] == more[f] || more[f] == Member::kWhole)
              << "theta2 " << theta2 << " rims " << rims << " face " << f;
          cut += member.face[f] == Member::kInPart;
          grown += member.face[f] != Member::kNo && family.face_sheet_level[f] < theta2;
        }
        more = member.face;
      }
    }
  }
  EXPECT_GT(cut, 10000u);
  EXPECT_GT(grown, 1000u);
}

// The curve level of an edge is the largest theta1 it stays for, when no sheets are left.
TEST(Skeleton, CurveLevelsAreThoseOfThePruning) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE(seed);
    const BurnInput input = random_input(seed);
    const SkeletonFamily family = skeletons(refined(input, some_omega(seed)));
    std::mt19937_64 random(seed);
    for (const double theta1 : {0.1, 0.5, 1.3}) {
      const Cells cells = greedy(family, kInfinity, theta1, random);
      for (std::uint32_t e = 2 * family.refined.doors; e < cells.edge.size(); ++e) {
        if (!family.refined.curve_edge[e]) continue;
        ASSERT_EQ(cells.edge[e] != 0, family.level_of(e) >= theta1) << "edge " << e << " theta1 " << theta1;
      }
    }
  }
}

TEST(Skeleton, TwiceTheSame) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const BurnInput input = random_input(seed);
    const auto once = [&] { return extract(skeletons(refined(input, some_omega(seed))), 0.3, 0.3); };
    const Skeleton a = once(), b = once();
    testing_skeletons::expect_same(a, b);
  }
}

// With rims grown back topology stays, and nothing is lost.
TEST(Skeleton, RimsGrowBack) {
  std::size_t longer = 0;
  const std::uint64_t seeds = repeats(3000, 1000);
  for (std::uint64_t seed = 0; seed < seeds && !testing::Test::HasFailure(); ++seed) {
    SCOPED_TRACE(seed);
    const BurnInput input = random_input(seed);
    const SkeletonFamily family = skeletons(refined(input, some_omega(seed)));
    const Topology wanted = topology(input.complex);
    const double rims = std::array{0.02, 0.1, 0.3}[seed % 3], minor = std::array{0.0, 0.3, 10.0}[seed / 3 % 3];
    for (const double theta2 : {0.3, 1.0, kInfinity})
      for (const bool parts : {false, true}) {
        ExtractOptions options{.parts = parts, .regrow_tips_above = 0.05};
        const Skeleton before = extract(family, theta2, 0.3, options);
        options.regrow_rims_above = rims;
        options.minor_curve = minor;
        const Skeleton grown = extract(family, theta2, 0.3, options);
        grown.complex.validate();
        ASSERT_EQ(topology(grown.complex), wanted) << "theta2 " << theta2 << " rims " << rims << " minor " << minor;
        ASSERT_GE(area(grown), area(before) * (1 - 1e-9));
        longer += area(grown) > 1.01 * area(before);
        for (const double level : grown.face_level) ASSERT_GE(level, std::min(rims, theta2));
      }
  }
  EXPECT_GT(longer, seeds / 3);
}

// A sheet of squares in the plane z = 0, raised at every second vertex.
Skeleton rough_sheet(std::uint32_t n, const Vec3& corner, Skeleton skeleton = {}) {
  std::vector<std::array<std::uint32_t, 2>> edges = skeleton.complex.edges;
  std::vector<std::uint32_t> offsets = skeleton.complex.face_offsets, corners = skeleton.complex.face_vertices;
  if (offsets.empty()) offsets.push_back(0);
  const bool first = skeleton.points.empty();
  const auto base = static_cast<std::uint32_t>(skeleton.points.size());
  const auto at = [&](std::uint32_t x, std::uint32_t y) {  // a second sheet has its first vertex with the last one
    return first ? x + y * n : x + y == 0 ? base - 1 : base - 1 + x + y * n;
  };
  for (std::uint32_t y = 0; y < n; ++y)
    for (std::uint32_t x = 0; x < n; ++x) {
      if (!first && x + y == 0) continue;
      skeleton.points.push_back(corner + Vec3(x, y, (x + y) % 2 ? 0.2 : 0.0));
      skeleton.radius.push_back(3);
    }
  for (std::uint32_t y = 0; y < n; ++y)
    for (std::uint32_t x = 0; x < n; ++x) {
      if (x + 1 < n) edges.push_back({at(x, y), at(x + 1, y)});
      if (y + 1 < n) edges.push_back({at(x, y), at(x, y + 1)});
      if (x + 1 == n || y + 1 == n) continue;
      for (const std::uint32_t v : {at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)}) corners.push_back(v);
      offsets.push_back(static_cast<std::uint32_t>(corners.size()));
    }
  skeleton.complex = make_complex(static_cast<std::uint32_t>(skeleton.points.size()), edges, offsets, corners);
  return skeleton;
}

TEST(SmoothSheets, MovesWhatIsRoughAndNothingWhereThingsMeet) {
  const std::uint32_t n = 7;
  Skeleton rough = rough_sheet(n, Vec3::Zero());
  rough = rough_sheet(n, Vec3(n - 1, n - 1, 0), rough);  // touches the first one in a vertex
  const std::uint32_t pinch = n * n - 1, end = static_cast<std::uint32_t>(rough.points.size()), start = n / 2;
  rough.points.push_back(Vec3(start, -5, 0));  // a curve from the middle of a rim
  rough.radius.push_back(3);
  std::vector<std::array<std::uint32_t, 2>> edges = rough.complex.edges;
  edges.push_back({start, end});
  rough.complex = make_complex(end + 1, edges, rough.complex.face_offsets, rough.complex.face_vertices);
  Skeleton smooth = rough;
  smooth_sheets(smooth, {.window = 2, .passes = 5, .most = 0.3});
  EXPECT_EQ(smooth.smooth, 5);
  double before = 0, after = 0;
  for (std::size_t v = 0; v < rough.points.size(); ++v) {
    const double way = (smooth.points[v] - rough.points[v]).norm();
    EXPECT_LE(way, 0.3 * (1 + 1e-12));
    EXPECT_DOUBLE_EQ(smooth.radius[v], rough.radius[v] - way);
    before += std::abs(rough.points[v][2] - 0.1);
    after += std::abs(smooth.points[v][2] - 0.1);
  }
  EXPECT_LT(after, 0.4 * before);
  for (const std::uint32_t v : {pinch, start, end}) EXPECT_EQ(smooth.points[v], rough.points[v]) << v;
  Skeleton same = rough;
  smooth_sheets(same, {});
  EXPECT_EQ(same.points, rough.points);
  EXPECT_THROW(smooth_sheets(same, {.window = -1}), Error);
  EXPECT_THROW(smooth_sheets(same, {.passes = -1}), Error);
}

// With tips grown back topology stays, and nothing is lost.
TEST(Skeleton, TipsGrowBack) {
  std::size_t longer = 0;
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    SCOPED_TRACE(seed);
    const BurnInput input = random_input(seed);
    const SkeletonFamily family = skeletons(refined(input, some_omega(seed)));
    const auto free_ends = [](const Skeleton& s) {
      std::vector<int> degree(s.points.size(), 0);
      for (const auto& e : s.complex.edges)
        for (const std::uint32_t v : e) ++degree[v];
      return std::count(degree.begin(), degree.end(), 1);
    };
    for (const double theta2 : {0.4, kInfinity})
      for (const double theta1 : {0.3, 1.0}) {
        const Skeleton cut = extract(family, theta2, theta1);
        const Skeleton grown = extract(family, theta2, theta1, {.parts = false, .regrow_tips_above = 0.05});
        grown.complex.validate();
        ASSERT_EQ(topology(grown.complex), topology(input.complex));
        // Not equal: what was pruned to an edge of length zero, written as a point, can grow at both ends.
        ASSERT_GE(free_ends(grown), free_ends(cut));
        ASSERT_GE(grown.points.size(), cut.points.size());
        longer += grown.points.size() > cut.points.size();
      }
  }
  EXPECT_GT(longer, 100u);
}

}  // namespace skeleton_test
}  // namespace quench
