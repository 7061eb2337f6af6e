// SPDX-License-Identifier: Apache-2.0
// Fire as windows on edges: envelopes against brute force; fire that is never later than by nodes and to which nodes
// and segments come near.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>
#include <utility>
#include <vector>

#include "burn_by_nodes.h"
#include "burning/flat_faces.h"
#include "burning/network.h"
#include "burning/source_windows.h"
#include "full_run.h"
#include "quench/axis.h"
#include "random_complexes.h"
#include "random_shapes.h"

namespace quench {
namespace propagate_windows_test {

using namespace testing_complexes;
using burning::SourceWindow;
using burning::WindowEnvelope;
using testing_burn::burn_by;
using testing_burn::Propagation;

Burning burn(const BurnInput& input, double omega, Propagation by) {
  return burn_by(by, input.complex, input.points, input.radius,
                 {.omega = omega, .radius = input.rule, .parents = false});
}

SourceWindow random_window(std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  const bool on_edge = random() % 4 == 0;  // a source on the edge itself
  double from = unit(random), to = unit(random);
  if (from > to) std::swap(from, to);
  if (random() % 3 == 0) from = 0;
  if (random() % 3 == 0) to = 1;
  return {from, to, 3 * unit(random) - 1, on_edge ? 0 : 2 * unit(random), random() % 2 == 0 ? 0 : unit(random)};
}

TEST(SourceWindows, CrossingsAreWhereTimesAreEqual) {
  std::mt19937_64 random(1);
  int found = 0;
  for (int round = 0; round < 20000; ++round) {
    const SourceWindow a = random_window(random), b = random_window(random);
    const auto at = burning::crossings(a, b, 0, 1);
    for (int i = 0; i < at.count; ++i) EXPECT_NEAR(a.at(at.at[i]), b.at(at.at[i]), 1e-12);
    found += at.count;
    // Between crossings the order is one.
    double from = 0;
    for (int i = 0; i <= at.count; ++i) {
      const double to = i < at.count ? at.at[i] : 1;
      int before = 0, after = 0;
      for (int k = 1; k < 40; ++k) {
        const double x = from + (to - from) * k / 40, difference = a.at(x) - b.at(x);
        before += difference < -1e-9;
        after += difference > 1e-9;
      }
      EXPECT_TRUE(before == 0 || after == 0) << round;
      from = to;
    }
  }
  EXPECT_GT(found, 3000);
}

TEST(SourceWindows, TheEnvelopeIsTheEarliest) {
  for (std::uint64_t seed = 0; seed < 3000 && !testing::Test::HasFailure(); ++seed) {
    std::mt19937_64 random(seed);
    WindowEnvelope envelope;
    std::vector<SourceWindow> all;
    for (std::size_t count = 1 + random() % 12; count > 0; --count) {
      std::vector<std::uint32_t> made;
      all.push_back(random_window(random));
      envelope.insert(all.back(), static_cast<std::uint32_t>(all.size()), 1e-10, 1e-9, made);
      for (const std::uint32_t id : made) EXPECT_NE(envelope.find(id), nullptr);
    }
    double last = -1;
    for (const auto& entry : envelope.entries()) {
      EXPECT_LT(entry.window.from, entry.window.to) << seed;
      EXPECT_GE(entry.window.from, last) << seed;
      last = entry.window.to;
    }
    for (int k = 0; k <= 500; ++k) {
      const double x = (k + 0.37) / 501;
      double earliest = INFINITY;
      for (const SourceWindow& w : all)
        if (w.from <= x && x <= w.to) earliest = std::min(earliest, w.at(x));
      const WindowEnvelope::Entry* entry = envelope.at(x, 0);
      if (!entry)
        EXPECT_TRUE(std::isinf(earliest)) << seed << " at " << x;
      else
        EXPECT_NEAR(entry->window.at(x), earliest, 1e-8) << seed << " at " << x;
    }
  }
}

TEST(BurnByWindows, IsNeverLaterThanByNodesAndNodesComeNear) {
  double coarse_sum = 0, fine_sum = 0;
  int compared = 0;
  const std::uint64_t seeds = repeats(6000, 1500);
  for (std::uint64_t seed = 0; seed < seeds; ++seed) {
    const BurnInput input = random_input(seed);
    if (!input.consistent) continue;
    const Burning exact = burn(input, 20, Propagation::windows), coarse = burn(input, 0.2, Propagation::nodes),
                  fine = burn(input, 0.04, Propagation::nodes);
    for (std::size_t v = 0; v < input.points.size(); ++v) {
      ASSERT_EQ(std::isinf(exact.burn_time[v]), std::isinf(fine.burn_time[v])) << seed;
      if (std::isinf(exact.burn_time[v])) continue;
      ASSERT_LE(exact.burn_time[v], fine.burn_time[v] + 1e-6) << seed << " vertex " << v;
      ASSERT_LE(fine.burn_time[v], exact.burn_time[v] + 0.1) << seed << " vertex " << v;
      coarse_sum += coarse.burn_time[v] - exact.burn_time[v];
      fine_sum += fine.burn_time[v] - exact.burn_time[v];
      ++compared;
    }
  }
  EXPECT_GT(compared, static_cast<int>(5 * seeds));
  EXPECT_LT(fine_sum, 0.4 * coarse_sum);
  EXPECT_LT(fine_sum / compared, 1e-4);
}

// The nodes are where times are wanted, and change nothing.
TEST(BurnByWindows, DoesNotDependOnTheSpacing) {
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    const BurnInput input = random_input(seed);
    const Burning one = burn(input, 20, Propagation::windows), other = burn(input, 0.3, Propagation::windows);
    for (std::size_t v = 0; v < input.points.size(); ++v)
      ASSERT_TRUE(one.burn_time[v] == other.burn_time[v] || std::abs(one.burn_time[v] - other.burn_time[v]) < 1e-8)
          << seed << " vertex " << v;
  }
}

TEST(BurnByWindows, SegmentsComeNearOnVoxelCores) {
  double coarse_sum = 0, fine_sum = 0;
  int compared = 0;
  for (std::uint64_t seed = 0; seed < static_cast<std::uint64_t>(repeats(400, 100)); ++seed) {
    MedialAxis core = voxel_core(testing_shapes::random_shape(seed, 9));
    BurnInput input{core.complex, core.points, core.radius, RadiusRule::exact, true};
    const Burning exact = burn(input, 5, Propagation::windows), coarse = burn(input, 0.4, Propagation::segments),
                  fine = burn(input, 0.05, Propagation::segments);
    EXPECT_EQ(exact.unburned, fine.unburned) << seed;
    for (std::size_t v = 0; v < input.points.size(); ++v) {
      if (std::isinf(exact.burn_time[v])) continue;
      ASSERT_GE(exact.erosion_thickness[v], 0) << seed;
      ASSERT_NEAR(fine.burn_time[v], exact.burn_time[v], 0.05) << seed << " vertex " << v;
      coarse_sum += std::abs(coarse.burn_time[v] - exact.burn_time[v]);
      fine_sum += std::abs(fine.burn_time[v] - exact.burn_time[v]);
      ++compared;
    }
  }
  EXPECT_GT(compared, 5000);
  EXPECT_LT(fine_sum, 0.3 * coarse_sum);
}

// Polygons that are not flat, or not convex: everything that has a number keeps it, and the surface stays closed.
TEST(FlatFaces, CutPolygonsIntoTrianglesAndKeepAllNumbers) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  int cut_faces = 0;
  for (int round = 0; round < 2000 && !testing::Test::HasFailure(); ++round) {
    BurnInput input = random_input(static_cast<std::uint64_t>(round));
    for (Vec3& p : input.points) p += 0.2 * Vec3(unit(random), unit(random), unit(random));  // no polygon stays flat
    const CellComplex& complex = input.complex;
    std::vector<char> cut(complex.face_count());
    for (char& c : cut) c = random() % 4 != 0;
    const CellComplex flat = burning::with_flat_faces(complex, input.points, cut);
    ASSERT_EQ(flat.vertex_count, complex.vertex_count);
    ASSERT_TRUE(std::equal(complex.edges.begin(), complex.edges.end(), flat.edges.begin()));
    EXPECT_EQ(topology(flat).euler, topology(complex).euler) << round;
    EXPECT_EQ(topology(flat).betti, topology(complex).betti) << round;
    std::size_t triangles = 0;
    for (std::size_t f = 0; f < complex.face_count(); ++f) {
      const std::size_t corners = complex.corners(f).size();
      triangles += cut[f] && corners > 3 ? corners - 2 : 1;
      cut_faces += cut[f] && corners > 3;
    }
    ASSERT_EQ(flat.face_count(), triangles) << round;
    for (std::size_t f = 0; f < flat.face_count(); ++f)
      for (std::size_t i = 0; i < flat.corners(f).size(); ++i) {
        const std::uint32_t a = flat.corners(f)[i], b = flat.corners(f)[(i + 1) % flat.corners(f).size()];
        const auto ends = std::array{std::min(a, b), std::max(a, b)};
        ASSERT_EQ(flat.edges[flat.sides(f)[i]], ends) << round;
      }
    const auto before = burning::make_network(complex, input.points, 0.4),
               after = burning::make_network(flat, input.points, 0.4);
    ASSERT_EQ(before.vertex_base, after.vertex_base) << round;
    for (std::size_t e = 0; e <= complex.edges.size(); ++e)
      ASSERT_EQ(before.state_base[e], after.state_base[e]) << round;
    for (std::uint32_t e = 0; e < complex.edges.size(); ++e) ASSERT_EQ(before.degree(e), after.degree(e)) << round;
    // Every corner keeps its sector, and every polygon of an edge its place.
    std::size_t corner = 0;
    for (std::size_t f = 0, t = 0; f < complex.face_count(); ++f) {
      const std::size_t pieces = cut[f] && complex.corners(f).size() > 3 ? complex.corners(f).size() - 2 : 1;
      for (std::size_t i = 0; i < complex.corners(f).size(); ++i, ++corner)
        for (std::size_t piece = t; piece < t + pieces; ++piece)
          for (std::size_t k = 0; k < flat.corners(piece).size(); ++k) {
            const std::size_t c = flat.face_offsets[piece] + k;
            if (flat.face_vertices[c] == complex.face_vertices[corner]) {
              ASSERT_EQ(after.corner_state[c], before.corner_state[corner]) << round;
            }
            if (flat.face_edges[c] == complex.face_edges[corner]) {
              ASSERT_EQ(after.corner_rank[c], before.corner_rank[corner]) << round;
            }
          }
      t += pieces;
    }
  }
  EXPECT_GT(cut_faces, 2000);
}

// A flat convex polygon in triangles is the same sheet: the same fire.
TEST(FlatFaces, CutFlatPolygonsBurnTheSame) {
  int compared = 0;
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    const BurnInput input = random_input(seed);
    if (!input.consistent) continue;
    BurnInput other = input;
    other.complex =
        burning::with_flat_faces(input.complex, input.points, std::vector<char>(input.complex.face_count(), 1));
    compared += other.complex.face_count() > input.complex.face_count();
    const Burning one = burn(input, 20, Propagation::windows), two = burn(other, 20, Propagation::windows);
    for (std::size_t v = 0; v < input.points.size(); ++v)
      ASSERT_TRUE(one.burn_time[v] == two.burn_time[v] || std::abs(one.burn_time[v] - two.burn_time[v]) < 1e-6)
          << seed << " vertex " << v;
  }
  EXPECT_GT(compared, 200);
}

// A curved sheet of quadrilaterals, none of them flat, beside the fire on the same sheet in cells an eighth as wide:
// what segments find comes to it as the cells become smaller, as what windows find.
TEST(FlatFaces, CurvedSheetsOfQuadrilateralsComeNearToTheSheet) {
  const auto sheet = [](int n) {
    Builder b;
    const auto at = [n](int i, int j) {
      const double x = double(i) / n, y = double(j) / n;
      return Vec3(x, y, 0.6 * std::sin(3 * x + 1) * std::sin(4 * y));
    };
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) b.face({at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
    return b.input([](const Vec3&) { return 1.0; });
  };
  const BurnInput fine = sheet(80);
  const Burning there = burn(fine, 0, Propagation::windows);
  std::map<std::array<double, 2>, double> truth;
  for (std::size_t v = 0; v < fine.points.size(); ++v)
    truth[{std::round(fine.points[v][0] * 1e9), std::round(fine.points[v][1] * 1e9)}] = there.erosion_thickness[v];
  std::array<double, 2> errors{};
  for (const int n : {10, 20}) {
    const BurnInput coarse = sheet(n);
    for (const Propagation by : {Propagation::segments, Propagation::windows}) {
      const Burning here = burn(coarse, 0, by);
      double error = 0, sum = 0;
      for (std::size_t v = 0; v < coarse.points.size(); ++v) {
        const double right = truth.at({std::round(coarse.points[v][0] * 1e9), std::round(coarse.points[v][1] * 1e9)});
        error += std::abs(here.erosion_thickness[v] - right);
        sum += right;
      }
      const double before = std::exchange(errors[by == Propagation::windows], error / sum);
      EXPECT_LT(error, (n == 10 ? 0.008 : 0.004) * sum) << n;
      if (n == 20) {
        EXPECT_LT(error / sum, 0.5 * before);
      }
    }
  }
}

}  // namespace propagate_windows_test
}  // namespace quench
