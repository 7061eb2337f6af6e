// SPDX-License-Identifier: Apache-2.0
#include "quench/burn.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <string>

#include "brute_force_burn.h"
#include "burn_by_nodes.h"
#include "burn_shapes.h"
#include "burning/burn_pass.h"
#include "full_run.h"
#include "quench/axis.h"
#include "quench/error.h"
#include "quench/samples.h"
#include "random_shapes.h"

namespace quench {
namespace burn_test {

using namespace testing_complexes;
using burning::BurnNetwork;
using testing_burn::BruteForceBurn;
using testing_burn::burn_by;
using testing_burn::Propagation;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Burning burn(const BurnInput& input, double omega, Propagation by) {
  return burn_by(by, input.complex, input.points, input.radius, {.omega = omega, .radius = input.rule});
}

/// None where a link has too many sectors for it.
std::optional<BruteForceBurn> oracle(const BurnInput& input, const std::vector<std::uint32_t>& pieces) {
  try {
    return BruteForceBurn(input.complex, input.points, input.radius, pieces, input.rule);
  } catch (const std::length_error&) {
    return std::nullopt;
  }
}

/// Pairs (state of the oracle, state of the result) for all corners and inserted nodes, and the number of a node of the
/// oracle in the result.
struct StatePair {
  std::size_t expected, found;
};
std::vector<StatePair> matching_states(const CellComplex& complex, const BruteForceBurn& expected,
                                       const BurnNetwork& network) {
  std::vector<StatePair> pairs;
  for (std::size_t c = 0; c < complex.face_vertices.size(); ++c) {
    pairs.push_back({expected.state_at(complex.face_vertices[c], expected.place_in_link[c]), network.corner_state[c]});
    const std::uint32_t e = complex.face_edges[c], sectors = network.sectors_of(e);
    for (std::size_t n = expected.first_inserted[e]; n < expected.first_inserted[e + 1]; ++n)
      pairs.push_back({expected.state_at(n, expected.place_in_edge_link[c]),
                       network.state_base[e] + (n - expected.first_inserted[e]) * sectors +
                           (sectors > 1 ? network.corner_rank[c] : 0)});
  }
  return pairs;
}

std::string name_of(std::uint64_t seed, double omega) {
  return "seed " + std::to_string(seed) + " omega " + std::to_string(omega);
}

double some_omega(std::uint64_t seed) {
  constexpr std::array<double, 5> omegas{0.3, 0.45, 0.8, 1.7, 20};
  return omegas[seed % omegas.size()];
}

bool near(double one, double two, double tolerance) { return one == two || std::abs(one - two) <= tolerance; }

TEST(Burn, ByNodesEqualsTheDefinition) {
  int compared = 0;
  for (std::uint64_t seed = 0; seed < 4000 && !testing::Test::HasFailure(); ++seed) {
    const BurnInput input = random_input(seed);
    const double omega = some_omega(seed);
    const auto expected = oracle(input, testing_burn::pieces_for(input.complex, input.points, omega));
    if (!expected) continue;
    ++compared;
    const Burning found = burn(input, omega, Propagation::nodes);
    ASSERT_EQ(found.sectors->network.pieces, expected->pieces) << name_of(seed, omega);
    ASSERT_EQ(found.sectors->network.node_count(), expected->nodes.size()) << name_of(seed, omega);
    ASSERT_EQ(found.sectors->network.pocket, expected->pocket) << name_of(seed, omega);
    for (std::size_t v = 0; v < input.points.size(); ++v) {
      EXPECT_TRUE(near(found.burn_time[v], expected->vertex_time[v], 1e-9))
          << name_of(seed, omega) << " vertex " << v << ": " << found.burn_time[v] << ", not "
          << expected->vertex_time[v];
    }
    const auto pairs = matching_states(input.complex, *expected, found.sectors->network);
    std::vector<char> seen(found.sectors->network.state_count(), 0);
    for (const StatePair& s : pairs) {
      ASSERT_LT(s.found, seen.size());
      seen[s.found] = 1;
    }
    EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), std::ssize(seen)) << name_of(seed, omega);
    for (const StatePair& s : pairs) {
      const double time = expected->time[s.expected], mine = found.sectors->state_time[s.found];
      EXPECT_TRUE(near(mine, time, 1e-9))
          << name_of(seed, omega) << " state " << s.found << ": " << mine << ", not " << time;
    }
  }
  EXPECT_GE(compared, 3500);
}

// What every result must be, whatever the propagation. `tolerance` is that of label correction; parents may burn later
// than their states by `late`.
void expect_sound(const BurnInput& input, const Burning& found, double tolerance, const std::string& where,
                  double late = 0) {
  const CellComplex& complex = input.complex;
  const BurnNetwork& network = found.sectors->network;
  const auto model = oracle(input, network.pieces);
  if (!model) return;
  const auto pairs = matching_states(complex, *model, network);
  const bool bridges =
      std::find(model->can_be_bridge.begin(), model->can_be_bridge.end(), 1) != model->can_be_bridge.end();
  std::vector<std::size_t> state_in_result(model->time.size());
  for (const StatePair& s : pairs) state_in_result[s.expected] = s.found;
  std::vector<double> radius(network.state_count(), 0);
  std::uint32_t unburned = 0;
  double largest = 0;
  for (std::size_t n = 0; n < model->nodes.size(); ++n) {
    const auto& node = model->nodes[n];
    const auto& link = model->links[node.link];
    int primes = 0;
    bool never = false;
    double last = node.radius;
    for (std::size_t s = 0; s < link.size(); ++s) {
      const std::size_t state = state_in_result[node.first_state + s];
      radius[state] = node.radius;
      never |= link.pocket[s];
      primes += found.sectors->parent[state] != kNone;
      last = std::max(last, found.sectors->state_time[state]);
      ASSERT_EQ(found.sectors->state_time[state] == kInfinity, link.pocket[s] != 0) << where << " node " << n;
      if (link.open[s]) {
        ASSERT_NEAR(found.sectors->state_time[state], node.radius, 1e-12) << where << " node " << n;
        ASSERT_EQ(found.sectors->parent[state], kNone) << where << " node " << n;
      }
    }
    ASSERT_EQ(primes, link.loops) << where << " node " << n;
    if (n < input.points.size()) {
      ASSERT_EQ(found.burn_time[n], last) << where << " vertex " << n;
      ASSERT_EQ(found.erosion_thickness[n], last - input.radius[n]) << where << " vertex " << n;
      unburned += never;
      if (!never) largest = std::max(largest, last);
    }
  }
  ASSERT_EQ(found.unburned, unburned) << where;
  ASSERT_GE(found.max_burn_time, largest) << where;
  // In every polygon: Lipschitz along arcs, parents that burned before, prime arcs that do not cross.
  std::vector<std::size_t> parent_state(network.state_count(), network.state_count());
  for (std::size_t f = 0; f < complex.face_count(); ++f) {
    const auto& rim = model->rims[f];
    std::vector<std::array<std::size_t, 2>> chords;
    for (std::size_t i = 0; i < rim.size(); ++i) {
      const std::size_t state = state_in_result[rim[i].state];
      const double time = found.sectors->state_time[state];
      for (std::size_t j = 0; j < rim.size() && time < kInfinity; ++j) {
        if (!model->joined(f, i, j)) continue;
        const double arc = (model->nodes[rim[i].node].point - model->nodes[rim[j].node].point).norm();
        const double other = found.sectors->state_time[state_in_result[rim[j].state]];
        ASSERT_LE(time, std::max(radius[state], other + arc) + tolerance)
            << where << " face " << f << " nodes " << rim[j].node << " to " << rim[i].node;
      }
      if (found.sectors->parent[state] == kNone || found.sectors->parent_face[state] != f) continue;
      // The state may have several corners in this polygon's rim only if they are one node.
      for (std::size_t j = 0; j < rim.size(); ++j) {
        if (rim[j].node != found.sectors->parent[state]) continue;
        ASSERT_TRUE(model->joined(f, i, j)) << where << " face " << f << ": a prime arc that is no arc";
        parent_state[state] = state_in_result[rim[j].state];
        chords.push_back({std::min(i, j), std::max(i, j)});
      }
    }
    for (const auto& [a, b] : chords)
      for (const auto& [c, d] : chords)
        ASSERT_FALSE(a < c && c < b && b < d) << where << " face " << f << ": prime arcs cross between rim nodes " << a
                                              << "-" << b << " and " << c << "-" << d;
  }
  for (std::size_t state = 0; state < parent_state.size(); ++state) {
    ASSERT_EQ(found.sectors->parent[state] == kNone, parent_state[state] == parent_state.size())
        << where << " state " << state;
    ASSERT_EQ(found.sectors->parent[state] == kNone, found.sectors->parent_face[state] == kNone)
        << where << " state " << state;
    if (found.sectors->parent[state] == kNone) continue;
    // A bridge is removed later than it burns, and a node whose parent it could have been gets one that burns later.
    ASSERT_LE(found.sectors->state_time[parent_state[state]],
              bridges ? kInfinity : found.sectors->state_time[state] + tolerance + late)
        << where << " state " << state;
    std::size_t steps = 0;
    for (std::size_t s = state; s < parent_state.size(); s = parent_state[s])
      ASSERT_LE(++steps, parent_state.size()) << where << ": parents in a circle";
  }
}

TEST(Burn, ByNodesIsSound) {
  for (std::uint64_t seed = 0; seed < 3000 && !testing::Test::HasFatalFailure(); ++seed) {
    const BurnInput input = random_input(seed);
    const double omega = some_omega(seed / 5);
    expect_sound(input, burn(input, omega, Propagation::nodes), 1e-9, name_of(seed, omega));
  }
}

// Blocks of a few states each, so that fire comes in from other blocks all the time.
TEST(Burn, AnyBlockSchedule) {
  int compared = 0;
  double sum = 0;
  const std::uint64_t seeds = repeats(3000, 1000);
  for (std::uint64_t seed = 0; seed < seeds && !testing::Test::HasFatalFailure(); ++seed) {
    const BurnInput input = random_input(seed);
    const double omega = some_omega(seed / 5);
    const burning::BlockSchedule schedule{1 + seed % 3 * 4, std::array{0.25, 4.0, 1e9}[seed / 3 % 3]};
    const std::string where = name_of(seed, omega) + ", blocks of " + std::to_string(schedule.states_per_block);
    const auto burn_both = [&](Propagation by) {
      const BurnOptions options{.omega = omega, .radius = input.rule};
      return std::pair(burn_by(by, input.complex, input.points, input.radius, options),
                       burn_by(by, input.complex, input.points, input.radius, options, schedule));
    };
    const auto [nodes, nodes_in_blocks] = burn_both(Propagation::nodes);
    ASSERT_EQ(nodes_in_blocks.sectors->state_time, nodes.sectors->state_time)
        << where;  // the least of sums, in any order
    expect_sound(input, nodes_in_blocks, 1e-9, where);
    const auto [segments, in_blocks] = burn_both(Propagation::segments);
    expect_sound(input, in_blocks, 2 * std::min(1e-3, 2e-3 * omega), where);
    for (std::size_t v = 0; v < input.points.size(); ++v) {
      ASSERT_EQ(std::isinf(in_blocks.burn_time[v]), std::isinf(segments.burn_time[v])) << where;
      if (std::isinf(in_blocks.burn_time[v])) continue;
      // Where fronts meet, which label remains can depend on the order: by less than the error of segments there.
      const double change = std::abs(in_blocks.burn_time[v] - segments.burn_time[v]) / omega;
      ASSERT_LT(change, 0.25) << where << " vertex " << v;
      sum += change;
      ++compared;
    }
  }
  EXPECT_GT(compared, static_cast<int>(10 * seeds));
  EXPECT_LT(sum / compared, 1e-4);
}

// Tolerance of label correction: min(2e-3 w, 6e-4 of the mean edge); each label may be late by it once.
TEST(Burn, BySegmentsIsSound) {
  for (std::uint64_t seed = 0; seed < 3000 && !testing::Test::HasFatalFailure(); ++seed) {
    const BurnInput input = random_input(seed);
    const double omega = some_omega(seed / 5);
    const bool triangles = input.complex.face_vertices.size() == 3 * input.complex.face_count();
    const double mean_edge = default_omega(input.complex, input.points) / (triangles ? 0.35 : 0.5);
    expect_sound(input, burn(input, omega, Propagation::segments), 2 * std::min(2e-3 * omega, 6e-4 * mean_edge),
                 name_of(seed, omega));
  }
}

TEST(Burn, ByWindowsIsSound) {
  for (std::uint64_t seed = 0; seed < 3000 && !testing::Test::HasFatalFailure(); ++seed) {
    const BurnInput input = random_input(seed);
    if (!input.consistent) continue;
    const double omega = some_omega(seed / 5);
    // Fire that crosses a segment between its nodes can be earlier than at both.
    expect_sound(input, burn(input, omega, Propagation::windows), 1e-6, name_of(seed, omega), omega);
  }
}

// Segments only add ways to burn, so on the same nodes they are not later than nodes. (By segments no time is below the
// radius; where the radius of inserted nodes leaves that to chance, nodes can be earlier.)
TEST(Burn, SegmentsAreNotAboveNodes) {
  int compared = 0;
  for (std::uint64_t seed = 0; seed < 4000; ++seed) {
    const BurnInput input = random_input(seed);
    const double omega = some_omega(seed / 7);
    const Burning found = burn(input, omega, Propagation::segments);
    const auto nodes = oracle(input, found.sectors->network.pieces);
    if (!nodes) continue;
    const double tolerance = 2e-3 * std::min(omega, 1.0);
    for (std::size_t v = 0; v < input.points.size(); ++v)
      ASSERT_LE(found.burn_time[v], std::max(input.radius[v], nodes->vertex_time[v]) + tolerance)
          << name_of(seed, omega) << " vertex " << v;
    const auto pairs = matching_states(input.complex, *nodes, found.sectors->network);
    if (!input.consistent) continue;
    ++compared;
    for (const StatePair& s : pairs)
      ASSERT_LE(found.sectors->state_time[s.found], nodes->time[s.expected] + tolerance)
          << name_of(seed, omega) << " state " << s.found;
  }
  EXPECT_GT(compared, 1500);
}

TEST(Burn, ErosionThicknessIsNotNegative) {
  for (std::uint64_t seed = 0; seed < 3000; ++seed) {
    const BurnInput input = random_input(seed);
    const double omega = some_omega(seed / 3);
    const Burning segments = burn(input, omega, Propagation::segments);
    for (double et : segments.erosion_thickness) ASSERT_GE(et, 0) << name_of(seed, omega);
    if (!input.consistent) continue;
    const Burning nodes = burn(input, omega, Propagation::nodes);
    for (double et : nodes.erosion_thickness) ASSERT_GE(et, -1e-12) << name_of(seed, omega);
    const auto model = oracle(input, segments.sectors->network.pieces);
    if (!model) continue;
    for (const auto& node : model->nodes)
      for (std::size_t s = 0; s < model->links[node.link].size(); ++s)
        ASSERT_GE(model->time[node.first_state + s], node.radius - 1e-9) << name_of(seed, omega);
  }
}

TEST(Burn, SameBitsOnAnyNumberOfThreads) {
  const BurnInput input = moebius_strip(3, 12, 400, 60);
  ASSERT_GT(input.complex.edges.size(), std::size_t{1} << 16) << "work is split into parts of 2^14";
  for (Propagation propagation : {Propagation::nodes, Propagation::segments}) {
    const auto on = [&](int threads) {
      tbb::task_arena arena(threads);
      return arena.execute([&] { return burn(input, 0.1, propagation); });
    };
    const Burning one = on(1);
    for (const int threads : {2, 3, 3}) {
      const Burning other = on(threads);
      EXPECT_TRUE(one.sectors->state_time == other.sectors->state_time);
      EXPECT_TRUE(one.sectors->parent == other.sectors->parent);
      EXPECT_TRUE(one.sectors->parent_face == other.sectors->parent_face);
      EXPECT_TRUE(one.burn_time == other.burn_time);
      EXPECT_TRUE(one.erosion_thickness == other.erosion_thickness);
      EXPECT_TRUE(one.sectors->network.pieces == other.sectors->network.pieces);
    }
  }
}

// Rounding may put another of two equal ways first, and by segments a label within the tolerance.
TEST(Burn, MovesAndTurnsWithTheComplex) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const BurnInput input = random_input(seed);
    BurnInput moved = input;
    for (Vec3& p : moved.points) p = Vec3(p[2], p[0], p[1]) + Vec3(17, -8, 3);
    for (Propagation propagation : {Propagation::nodes, Propagation::segments}) {
      const Burning one = burn(input, 0.4, propagation), two = burn(moved, 0.4, propagation);
      ASSERT_EQ(one.sectors->network.pieces, two.sectors->network.pieces) << "seed " << seed;
      for (std::size_t v = 0; v < one.burn_time.size(); ++v) {
        if (one.burn_time[v] == kInfinity) {
          ASSERT_EQ(two.burn_time[v], kInfinity) << "seed " << seed;
        } else {
          ASSERT_NEAR(one.burn_time[v], two.burn_time[v], propagation == Propagation::nodes ? 1e-9 : 2e-3)
              << "seed " << seed << " vertex " << v;
        }
      }
    }
  }
}

// Disc i is the fan of vertex i over i+1, i+3, i+9 (mod 13): every edge has three polygons or more, none lies in a
// pocket that a search by node alone could tell from one, and that search stops with all times infinite.
TEST(Burn, ThirteenDiscsBurn) {
  Builder b;
  Random random(13);
  for (int i = 0; i < 13; ++i) b.vertex(random.point(4));
  for (std::uint32_t i = 0; i < 13; ++i) {
    const auto at = [&](std::uint32_t k) { return (i + k) % 13; };
    b.cone(i, {at(1), at(3), at(9)}, false);
  }
  const BurnInput input = b.input([](const Vec3&) { return 1.0; });
  for (double omega : {20.0, 1.0, 0.3})
    for (Propagation propagation : {Propagation::nodes, Propagation::segments}) {
      const Burning found = burn(input, omega, propagation);
      EXPECT_EQ(found.unburned, 0u);
      for (double t : found.sectors->state_time) EXPECT_LT(t, kInfinity);
      expect_sound(input, found, 2e-3, "omega " + std::to_string(omega));
    }
}

// Thm. 3.4.1: by nodes, ET is above the truth by (2|M| + g) omega at most, |M| triangles, g <= 1 the largest slope of R
// on the rim.
TEST(Burn, ErrorByNodesFallsWithTheSpacing) {
  for (const KnownBurn& known : {square_under_site(), l_sheet(), three_sheets(), cone(6, 4, 2, -2, 2)}) {
    double last = kInfinity;
    for (double omega : {1.0, 0.5, 0.25, 0.125, 0.0625}) {
      const Burning found = burn(known.input, omega, Propagation::nodes);
      double sum = 0;
      for (std::size_t v = 0; v < known.truth.size(); ++v) {
        const double error = found.burn_time[v] - known.truth[v];
        ASSERT_GE(error, -1e-5);
        ASSERT_LE(error, (2.0 * static_cast<double>(known.input.complex.face_count()) + 1) * omega);
        sum += error;
      }
      EXPECT_LE(sum, last * 0.7);
      last = sum;
    }
  }
}

MedialAxis pruned_core(const VoxelShape& shape, double lambda) {
  MedialAxis core = voxel_core(shape);
  prune_levels(core);
  return pruned(core, lambda);
}

VoxelShape rippled_plate() {
  Grid grid;
  grid.dims = {60, 50, 34};
  return testing_shapes::from_predicate(grid, [](int x, int y, int z) {
    const double a = x - 29.3, b = y - 24.6, c = z - 16.1;
    const double ripples =
        1.9 * std::sin(0.31 * a + 0.1 * b) * std::cos(0.37 * b) + 1.3 * std::sin(0.9 * a) * std::sin(0.7 * b + 0.2 * a);
    return a * a / 780 + b * b / 530 < 1 && std::abs(c) < 6.2 + ripples;
  });
}

/// Erosion thickness at every node: the latest of its sectors less the radius.
std::vector<double> node_thickness(const MedialAxis& axis, const Burning& found) {
  const BurnNetwork& network = found.sectors->network;
  std::vector<double> et = found.erosion_thickness;
  for (std::size_t e = 0; e < axis.complex.edges.size(); ++e) {
    const auto [a, b] = axis.complex.edges[e];
    const std::uint32_t sectors = network.sectors_of(static_cast<std::uint32_t>(e));
    for (std::uint32_t i = 1; i < network.pieces[e]; ++i) {
      double time = 0;
      for (std::uint32_t s = 0; s < sectors; ++s)
        time = std::max(time, found.sectors->state_time[network.state_base[e] + (i - 1) * sectors + s]);
      et.push_back(time - radius_inside_edge(axis.radius[a], axis.radius[b], network.length[e],
                                             static_cast<double>(i) / network.pieces[e], found.options.radius));
    }
  }
  return et;
}

// ET has no interior minima (Yan 2018, sec. 3.3). On a graph a few are left: inner nodes below every other node of
// their polygons.
TEST(Burn, MinimaOfErosionThicknessVanish) {
  const MedialAxis axis = pruned_core(rippled_plate(), 2);
  std::vector<int> uses(axis.complex.edges.size(), 0);
  for (std::uint32_t e : axis.complex.face_edges) ++uses[e];
  const auto minima = [&](double omega, Propagation propagation) {
    const Burning found =
        burn_by(propagation, axis.complex, axis.points, axis.radius, {.omega = omega, .radius = RadiusRule::exact});
    for (double et : found.erosion_thickness) EXPECT_GE(et, -1e-12);
    const std::vector<double> et = node_thickness(axis, found);
    std::vector<double> lowest(et.size(), kInfinity);  // of the nodes around
    for (std::size_t f = 0; f < axis.complex.face_count(); ++f) {
      const auto corners = axis.complex.corners(f);
      std::vector<std::uint32_t> around(corners.begin(), corners.end());
      for (std::uint32_t e : axis.complex.sides(f))
        for (std::uint32_t n = found.sectors->network.node_base[e]; n < found.sectors->network.node_base[e + 1]; ++n)
          around.push_back(n);
      for (std::uint32_t v : around)
        for (std::uint32_t w : around)
          if (v != w) lowest[v] = std::min(lowest[v], et[w]);
    }
    for (std::size_t e = 0; e < uses.size(); ++e) {
      if (uses[e] >= 2) continue;
      for (std::uint32_t v : axis.complex.edges[e]) lowest[v] = 0;
      for (std::uint32_t n = found.sectors->network.node_base[e]; n < found.sectors->network.node_base[e + 1]; ++n)
        lowest[n] = 0;
    }
    EXPECT_EQ(et.size(), found.sectors->network.node_count());
    EXPECT_GT(std::count_if(lowest.begin(), lowest.end(), [](double l) { return l > 0; }), 900);
    int count = 0;
    for (std::size_t n = 0; n < et.size(); ++n) count += et[n] < lowest[n] - 1e-9;
    return count;
  };
  for (Propagation propagation : {Propagation::nodes, Propagation::segments}) {
    const int coarse = minima(4, propagation), middle = minima(1, propagation), fine = minima(0.125, propagation);
    EXPECT_LE(middle, coarse);
    EXPECT_LE(fine, middle);
    EXPECT_EQ(fine, 0);
  }
}

// The core's radii are distances to sites, so ET >= 0 at every node and the results are sound there, too.
TEST(Burn, VoxelCoresAreSound) {
  int checked = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const MedialAxis axis = pruned_core(testing_shapes::random_shape(seed, 9, seed % 3 == 1), seed % 2 ? 0 : 1.2);
    const BurnInput input{axis.complex, axis.points, axis.radius, RadiusRule::exact, true};
    if (axis.complex.face_count() > 400) continue;
    for (Propagation propagation : {Propagation::nodes, Propagation::segments})
      expect_sound(input, burn(input, 0.5, propagation), propagation == Propagation::nodes ? 1e-9 : 2e-3,
                   "seed " + std::to_string(seed));
    ++checked;
  }
  EXPECT_GT(checked, 30);
}

// A seam whose ends have 100 sectors each, all pages of different width: the last two widths count.
TEST(Burn, MoreThan64SectorsAtAVertex) {
  Builder b;
  const Vec3 low(0, 0, 0), high(0, 0, 12), middle(0, 0, 6);
  for (int i = 0; i < 100; ++i) {
    const double angle = 2 * std::numbers::pi * i / 100, width = 1 + 0.04 * ((i * 37) % 100);
    const Vec3 out = width * Vec3(std::cos(angle), std::sin(angle), 0);
    b.face({low, middle, middle + out, low + out});
    b.face({middle, high, high + out, middle + out});
  }
  const BurnInput input = b.input([](const Vec3&) { return 1.0; });
  for (Propagation propagation : {Propagation::nodes, Propagation::segments}) {
    const Burning found = burn(input, 0.25, propagation);
    const std::uint32_t v = b.vertex(middle);
    // Widths are 1, 1.04 .. 4.96; the second latest is 4.92, and the seam's ends are 6 away.
    ASSERT_EQ(found.sectors->network.vertex_base[v + 1] - found.sectors->network.vertex_base[v], 100u);
    EXPECT_NEAR(found.burn_time[v], 1 + 4.92, 1e-7);
    EXPECT_EQ(found.unburned, 0u);
    int primes = 0;
    for (std::uint32_t s = found.sectors->network.vertex_base[v]; s < found.sectors->network.vertex_base[v + 1]; ++s)
      primes += found.sectors->parent[s] != kNone;
    EXPECT_EQ(primes, 99);
  }
}

// More sides than the order pass tells apart (SideMask), with flaps that make one of them, first or last, a seam.
TEST(Burn, PolygonsOfManySides) {
  for (const int sides : {30, 31, 32, 33, 64, 90})
    for (const int seam : {0, sides - 1}) {
      Builder b;
      std::vector<Vec3> rim;
      for (int i = 0; i < sides; ++i) {
        const double angle = 2 * std::numbers::pi * i / sides;
        rim.emplace_back(10 * std::cos(angle), 6 * std::sin(angle), 0);
      }
      b.face(rim);
      const Vec3 p = rim[seam], q = rim[(seam + 1) % sides];
      for (const Vec3& flap : {Vec3(0, 0, 3), Vec3(0, 0, -5)}) b.face({p, q, q + flap, p + flap});
      const BurnInput input = b.input([](const Vec3& x) { return 1 + 0.1 * x[0] * x[0] / 10; });
      for (Propagation by : {Propagation::nodes, Propagation::segments})
        expect_sound(input, burn(input, 0.6, by), by == Propagation::nodes ? 1e-9 : 2e-3,
                     std::to_string(sides) + " sides, seam " + std::to_string(seam));
    }
}

TEST(Burn, AnAxisIsItsComplexPointsAndRadii) {
  const MedialAxis axis = pruned_core(testing_shapes::box_shape(9, 7, 4), 0.6);
  const Burning one = burn(axis, {.omega = 0.4}), other = burn(axis.complex, axis.points, axis.radius, {.omega = 0.4});
  EXPECT_EQ(one.burn_time, other.burn_time);
  EXPECT_EQ(one.node_count, other.node_count);
  EXPECT_GT(one.node_count, axis.points.size());
}

TEST(Burn, RadiusInsideAnEdge) {
  // Distance to a point: along a line at distance 3 from it.
  for (double t : {0.0, 0.1, 0.5, 0.9, 1.0}) {
    EXPECT_NEAR(radius_inside_edge(5, std::hypot(3, 2), 6, t, RadiusRule::exact), std::hypot(3, -4 + 6 * t), 1e-12);
    EXPECT_NEAR(radius_inside_edge(1, 3, 10, t, RadiusRule::exact), 1 + 2 * t, 1e-12);  // too long for one point
    EXPECT_NEAR(radius_inside_edge(1, 5, 3, t, RadiusRule::exact), 1 + 4 * t, 1e-12);   // too steep for one point
    EXPECT_NEAR(radius_inside_edge(1, 2, 2, t, RadiusRule::linear), 1 + t, 1e-12);
  }
}

TEST(Burn, EmptyAndRefusedInput) {
  Builder nothing;
  const BurnInput empty = nothing.input([](const Vec3&) { return 1.0; });
  EXPECT_TRUE(burn(empty, 0.5, Propagation::segments).burn_time.empty());
  EXPECT_TRUE(burn(empty, 0, Propagation::segments).burn_time.empty());
  BurnInput square = square_sheet(10, 2).input;
  EXPECT_THROW(burn(square, -1, Propagation::segments), Error);
  EXPECT_THROW(burn(square, 1e-12, Propagation::segments), Error);
  square.radius[3] = -1;
  EXPECT_THROW(burn(square, 1, Propagation::segments), Error);
  square.radius[3] = std::nan("");
  EXPECT_THROW(burn(square, 1, Propagation::segments), Error);
}

TEST(Burn, SpacingIsAShareOfTheMeanEdgeWhereNoneIsGiven) {
  const BurnInput input = square_sheet().input;
  double sum = 0;
  for (const auto& [a, b] : input.complex.edges) sum += (input.points[a] - input.points[b]).norm();
  const double expected = 0.35 * sum / static_cast<double>(input.complex.edges.size());
  EXPECT_NEAR(default_omega(input.complex, input.points), expected, 1e-12);
  EXPECT_NEAR(burn(input, 0, Propagation::segments).options.omega, expected, 1e-12);
}

}  // namespace burn_test
}  // namespace quench
