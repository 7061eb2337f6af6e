// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <random>
#include <set>
#include <tuple>
#include <vector>

#include "dual/bricks/part_order.h"
#include "dual_of_triangulation.h"
#include "full_run.h"
#include "parts_in_rounds.h"
#include "quench/error.h"
#include "quench/io.h"
#include "quench/samples.h"
#include "quench/voxelize.h"
#include "random_shapes.h"
#include "same_dual.h"

namespace quench::dual::bricks {
namespace parts_test {

using testing_duals::Boxes;
using testing_duals::expect_same;
using testing_duals::Rounds;

constexpr std::size_t kAllRounds = 100;

// Boxes far smaller than cells, halos that miss most balls, boxes that begin anywhere.
const std::vector<Boxes> kBoxes{{4, 2}, {4, 5, {-1, -2, -3}}, {5, 1}, {6, 4, {3, 3, 3}}, {9, 3}, {64, 8}};

void expect_same_in_boxes(const VoxelShape& shape, std::span<const Boxes> all, std::size_t rounds,
                          const std::string& where) {
  const DualComplex whole = oracles::dual_of_triangulation(shape, boundary_vertices(shape));
  for (const Boxes& boxes : all) {
    const std::string what = where + ", boxes of " + std::to_string(boxes.size) + ", halo " +
                             std::to_string(boxes.halo) + ", rounds " + std::to_string(rounds);
    try {
      Rounds parts(shape, boxes);
      const Part part = parts.run(rounds);
      EXPECT_TRUE(part.sites == parts.sites()) << what;
      const PartComplex complex = complex_of(part, parts.hulls(), nullptr);
      expect_same(complex.dual, whole, what);
      EXPECT_EQ(std::ranges::count(complex.vertex_incomplete, 1), 0) << what;
    } catch (const std::exception& e) {
      FAIL() << what << ": " << e.what();
    }
  }
}

void expect_random_shapes_same(std::uint64_t first, std::uint64_t last, int largest, bool anisotropic) {
  testing_duals::for_random_shapes(first, last, largest, anisotropic, kBoxes,
                                   [](const VoxelShape& shape, auto ways, const std::string& where) {
                                     expect_same_in_boxes(shape, ways, where.back() % 3 == 0 ? 2 : kAllRounds, where);
                                   });
}

TEST(Parts, RandomShapesAreTheSame) {
  expect_random_shapes_same(0, 800, 8, false);
  expect_random_shapes_same(10000, 10040, 14, false);
}

// Larger than what the first parts know around their boxes.
TEST(Parts, LargerShapesAreTheSame) { expect_random_shapes_same(30000, repeats(30030, 30015), 40, false); }

TEST(Parts, AnisotropicShapesAreTheSame) {
  expect_random_shapes_same(0, 400, 8, true);
  testing_duals::for_spacings({Vec3(0.782, 0.782, 5), Vec3(1, 1000, 1)}, kBoxes,
                              [](const VoxelShape& shape, auto ways, const std::string& where) {
                                expect_same_in_boxes(shape, ways, kAllRounds, where);
                              });
}

// Cells larger than any region, and sites with nothing but such cells.
TEST(Parts, HugeCells) {
  const auto expect_all = [](const VoxelShape& shape, const std::string& where) {
    expect_same_in_boxes(shape, kBoxes, kAllRounds, where);
    if (full_run() || shape.voxel_count() < 2000) expect_same_in_boxes(shape, kBoxes, 1, where);
  };
  expect_all(testing_shapes::box_shape(1, 1, 1), "voxel");
  expect_all(testing_shapes::box_shape(1, 1, 1, 0), "voxel without margin");
  expect_all(testing_shapes::box_shape(20, 20, 20), "cube");
  expect_all(testing_shapes::box_shape(24, 17, 2), "flat box");
  expect_all(testing_shapes::box_shape(1, 2, 70), "bar");
  expect_all(testing_duals::shells(0, 12, 0), "ball");
  expect_all(testing_duals::shells(0, 7, 0), "96 sites on a sphere");
  expect_all(testing_duals::shells(9, 12, 0), "hollow ball");
  expect_all(testing_duals::shells(9, 12, 2.5), "hollow ball with an axle");
}

// Parts with nothing between them.
TEST(Parts, FarApart) {
  expect_same_in_boxes(testing_duals::far_apart(40000), std::vector<Boxes>{{2, 2}, {64, 8}}, kAllRounds, "far apart");
}

TEST(Parts, TouchingWalls) {
  for (int rule = 0; rule < testing_duals::kWallRules; ++rule)
    expect_same_in_boxes(testing_duals::touching_walls(rule), kBoxes, kAllRounds, "rule " + std::to_string(rule));
}

TEST(Parts, MeshesAreTheSame) {
  for (const char* name : {"torus", "rippled-box", "plate-with-holes", "hollow-sphere"})
    expect_same_in_boxes(voxelize(make_sample(name).mesh, {.resolution = 64}).shape,
                         std::vector<Boxes>{{16, 4}, {32, 12, {5, 6, 7}}}, kAllRounds, name);
  const auto file = std::filesystem::path(QUENCH_DATA) / "meshes/armadillo.off";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "no test data";
  const TriangleMesh mesh = to_triangle_mesh(io::read_record(file));
  expect_same_in_boxes(voxelize(mesh, {.resolution = 128}).shape,
                       std::vector<Boxes>{{16, 4}, {40, 8, {-5, 11, 30}}, {64, 3}}, kAllRounds, "armadillo");
}

using SiteList = std::vector<LatticePoint>;
using Link = std::set<SiteList>;

SiteList sites_of(const DualComplex& dual, std::uint32_t vertex, std::span<const LatticePoint> sites) {
  SiteList list;
  for (const std::uint32_t s : dual.sites_of(vertex)) list.push_back(sites[s]);
  return list;
}

Link link_of(const DualComplex& dual, std::size_t edge, std::span<const LatticePoint> sites) {
  const auto& [u, v] = dual.complex.edges[edge];
  return {sites_of(dual, u, sites), sites_of(dual, v, sites)};
}

// Some number of a cell.
double value_of(const SiteList& sites) {
  double value = 0;
  for (const LatticePoint& s : sites) value = std::fmod(3 * value + s[0] + 7 * s[1] + 31 * s[2], 1e6);
  return value;
}
double value_of(const Link& link) { return value_of(*link.begin()) + 2 * value_of(*link.rbegin()); }

// Prunes parts at random, and gives what is left values by which it is recognised later.
class RandomPruning {
 public:
  RandomPruning(std::uint64_t seed, const Hulls& hulls) : random_(seed), hulls_(hulls) {}

  void prune(Part& part) {
    const PartComplex complex = complex_of(part, hulls_, nullptr);
    set_values(part, complex);
    const auto& edges = complex.dual.complex.edges;
    Removal removal{std::vector<std::uint8_t>(part.found.cells.count(), 1), std::vector<std::uint8_t>(edges.size(), 0)};
    const std::uint64_t share = random_() % 5;
    for (std::size_t e = 0; e < edges.size(); ++e) {
      removal.edge[e] = random_() % 4 < share;
      if (removal.edge[e])
        links.insert(link_of(complex.dual, e, part.sites));
      else
        removal.vertex[edges[e][0]] = removal.vertex[edges[e][1]] = 0;
    }
    for (const UnmatchedFacet& f : part.found.unmatched)
      if (f.polytope != kNone) removal.vertex[f.polytope] = 0;
    for (std::uint32_t v = 0; v < removal.vertex.size(); ++v)
      if (removal.vertex[v]) vertices.insert(sites_of(complex.dual, v, part.sites));
    remove(part, complex, removal, 0);
  }

  void expect_values(const Part& part, const PartComplex& complex) const {
    const Cells& cells = part.found.cells;
    std::size_t known = 0;
    for (std::uint32_t v = 0; v < cells.count(); ++v) {
      if (part.vertex_lambda[v] < 0) continue;
      ++known;
      const SiteList sites = sites_of(complex.dual, v, part.sites);
      EXPECT_EQ(part.vertex_lambda[v], value_of(sites));
      EXPECT_EQ(part.vertex_detail[v], value_of(sites) + 1);
      for (std::size_t c = 0; c < sites.size(); ++c)
        EXPECT_EQ(part.contact[cells.site_begin[v] + c], 1 + sites[c][0] % 2);
    }
    for (std::size_t e = 0; e < complex.link_of.size(); ++e) {
      const std::uint32_t link = complex.link_of[e], twin = complex.twin_of[e];
      EXPECT_EQ(part.link_lambda[link], part.link_lambda[twin]);
      if (part.link_lambda[link] < 0) continue;
      EXPECT_EQ(part.link_lambda[link], value_of(link_of(complex.dual, e, part.sites)));
      EXPECT_EQ(part.link_detail[twin], value_of(link_of(complex.dual, e, part.sites)) + 1);
    }
    for (const FaceValue& f : part.faces)
      EXPECT_EQ(f.value, value_of(SiteList{part.sites[f.sites[0]], part.sites[f.sites[1]]}));
    EXPECT_TRUE(std::ranges::is_sorted(part.faces, {}, &FaceValue::sites));
    EXPECT_LE(known, cells.count());
    values_seen += known;
  }

  std::set<SiteList> vertices;
  std::set<Link> links;
  mutable std::size_t values_seen = 0;

 private:
  static void set_values(Part& part, const PartComplex& complex) {
    const Cells& cells = part.found.cells;
    part.extend();
    for (std::uint32_t v = 0; v < cells.count(); ++v) {
      const SiteList sites = sites_of(complex.dual, v, part.sites);
      part.vertex_lambda[v] = value_of(sites);
      part.vertex_detail[v] = value_of(sites) + 1;
      for (std::size_t c = 0; c < sites.size(); ++c)
        part.contact[cells.site_begin[v] + c] = static_cast<std::uint8_t>(1 + sites[c][0] % 2);
    }
    for (std::size_t e = 0; e < complex.link_of.size(); ++e) {
      const double value = value_of(link_of(complex.dual, e, part.sites));
      for (const std::uint32_t link : {complex.link_of[e], complex.twin_of[e]}) {
        part.link_lambda[link] = value;
        part.link_detail[link] = value + 1;
      }
    }
    part.faces.clear();
    for (const auto& sites : complex.dual.face_sites)
      part.faces.push_back({sites, value_of(SiteList{part.sites[sites[0]], part.sites[sites[1]]}), true});
  }

  std::mt19937_64 random_;
  const Hulls& hulls_;
};

// What is left of the whole when cells are removed.
DualComplex without(const DualComplex& whole, std::span<const LatticePoint> sites, const RandomPruning& removed) {
  DualComplex rest;
  rest.vertex_site_offsets = {0};
  std::vector<std::uint32_t> vertex(whole.complex.vertex_count, kNone), edge(whole.complex.edges.size(), kNone);
  for (std::uint32_t v = 0; v < whole.complex.vertex_count; ++v) {
    if (removed.vertices.contains(sites_of(whole, v, sites))) continue;
    vertex[v] = rest.complex.vertex_count++;
    const auto corners = whole.sites_of(v);
    rest.vertex_sites.insert(rest.vertex_sites.end(), corners.begin(), corners.end());
    rest.vertex_site_offsets.push_back(static_cast<std::uint32_t>(rest.vertex_sites.size()));
  }
  for (std::size_t e = 0; e < edge.size(); ++e) {
    if (removed.links.contains(link_of(whole, e, sites))) continue;
    edge[e] = static_cast<std::uint32_t>(rest.complex.edges.size());
    rest.complex.edges.push_back({vertex[whole.complex.edges[e][0]], vertex[whole.complex.edges[e][1]]});
  }
  for (std::size_t f = 0; f < whole.complex.face_count(); ++f) {
    const std::uint32_t first = whole.complex.face_offsets[f], last = whole.complex.face_offsets[f + 1];
    const auto gone = [&](std::uint32_t i) { return edge[whole.complex.face_edges[i]] == kNone; };
    bool any = false;
    for (std::uint32_t i = first; i < last; ++i) any |= gone(i);
    if (any) continue;
    for (std::uint32_t i = first; i < last; ++i) {
      rest.complex.face_vertices.push_back(vertex[whole.complex.face_vertices[i]]);
      rest.complex.face_edges.push_back(edge[whole.complex.face_edges[i]]);
    }
    rest.complex.face_offsets.push_back(static_cast<std::uint32_t>(rest.complex.face_vertices.size()));
    rest.face_sites.push_back(whole.face_sites[f]);
  }
  return rest;
}

// With the places of the sites among others.
DualComplex renumbered(DualComplex dual, std::span<const LatticePoint> from, std::span<const LatticePoint> to) {
  const std::vector<std::uint32_t> place = places_of(from, to);
  for (std::uint32_t& s : dual.vertex_sites) s = place[s];
  for (auto& sites : dual.face_sites)
    for (std::uint32_t& s : sites) s = place[s];
  return dual;
}

TEST(Parts, WhatIsLeftOfPrunedPartsIsTheSame) {
  std::size_t values = 0, pruned = 0;
  for (std::uint64_t seed = 0; seed < 300 && !HasFatalFailure(); ++seed) {
    const std::string where = "seed " + std::to_string(seed);
    const VoxelShape shape = testing_shapes::random_shape(seed, 12, seed % 2 == 1);
    Rounds rounds(shape, kBoxes[seed % kBoxes.size()]);
    RandomPruning pruning(seed, rounds.hulls());
    const Part part = rounds.run(kAllRounds, [&](Part& p) { pruning.prune(p); });
    const PartComplex complex = complex_of(part, rounds.hulls(), nullptr);
    pruning.expect_values(part, complex);
    expect_same(renumbered(complex.dual, part.sites, rounds.sites()),
                without(oracles::dual_of_triangulation(shape, rounds.sites()), rounds.sites(), pruning), where);
    EXPECT_EQ(part.pruned.vertices, pruning.vertices.size()) << where;
    EXPECT_EQ(part.pruned.edges, pruning.links.size()) << where;
    values += pruning.values_seen;
    pruned += pruning.vertices.size();
  }
  EXPECT_GT(values, 1000u);
  EXPECT_GT(pruned, 1000u);
}

// Cells around one that is called complete are all there.
TEST(Parts, CompleteCellsAreComplete) {
  std::size_t complete_edges = 0, incomplete_edges = 0;
  for (std::uint64_t seed = 0; seed < 100 && !HasFatalFailure(); ++seed) {
    const VoxelShape shape = testing_shapes::random_shape(seed, 12, seed % 2 == 1);
    Rounds rounds(shape, kBoxes[seed % kBoxes.size()]);
    const DualComplex whole = oracles::dual_of_triangulation(shape, rounds.sites());
    std::map<Link, std::size_t> faces_around;
    std::map<SiteList, std::size_t> edges_around;
    std::vector<Link> links;
    for (std::size_t e = 0; e < whole.complex.edges.size(); ++e) {
      links.push_back(link_of(whole, e, rounds.sites()));
      for (const SiteList& end : links.back()) ++edges_around[end];
    }
    for (const std::uint32_t e : whole.complex.face_edges) ++faces_around[links[e]];
    rounds.run(kAllRounds, [&](Part& part) {
      const PartComplex complex = complex_of(part, rounds.hulls(), nullptr);
      const auto& [edges, face_edges] = std::tie(complex.dual.complex.edges, complex.dual.complex.face_edges);
      std::vector<std::size_t> faces(edges.size(), 0), around(part.found.cells.count(), 0);
      for (const std::uint32_t e : face_edges) ++faces[e];
      for (std::size_t e = 0; e < edges.size(); ++e) {
        for (const std::uint32_t v : edges[e]) ++around[v];
        ++(complex.edge_incomplete[e] ? incomplete_edges : complete_edges);
        if (complex.edge_incomplete[e]) continue;
        EXPECT_EQ(faces[e], faces_around[link_of(complex.dual, e, part.sites)]) << "seed " << seed;
      }
      for (std::uint32_t v = 0; v < around.size(); ++v) {
        if (complex.vertex_incomplete[v]) continue;
        EXPECT_EQ(around[v], edges_around[sites_of(complex.dual, v, part.sites)]) << "seed " << seed;
      }
    });
  }
  EXPECT_GT(complete_edges, 1000u);
  EXPECT_GT(incomplete_edges, 1000u);
}

TEST(Parts, ThreadsDoNotMatter) {
  const tbb::global_control control(tbb::global_control::max_allowed_parallelism, 4);
  for (std::uint64_t seed = 0; seed < 40 && !HasFatalFailure(); ++seed) {
    const VoxelShape shape = testing_shapes::random_shape(seed, 14, seed % 2 == 1);
    const auto parts_with = [&](int threads) {
      tbb::task_arena arena(threads);
      std::vector<Part> parts;
      arena.execute([&] {
        Rounds(shape, kBoxes[seed % kBoxes.size()]).run(kAllRounds, [&](Part& part) { parts.push_back(part); });
      });
      return parts;
    };
    const std::vector<Part> one = parts_with(1), four = parts_with(4);
    ASSERT_EQ(one.size(), four.size());
    for (std::size_t p = 0; p < one.size(); ++p) {
      EXPECT_TRUE(one[p].sites == four[p].sites && one[p].pending == four[p].pending);
      const CellsPart &a = one[p].found, &b = four[p].found;
      EXPECT_TRUE(a.cells.sites == b.cells.sites && a.cells.site_begin == b.cells.site_begin);
      EXPECT_TRUE(a.cells.neighbours == b.cells.neighbours && a.squares == b.squares);
      const auto same = [](const UnmatchedFacet& f, const UnmatchedFacet& g) {
        return f.key == g.key && f.polytope == g.polytope && f.facet == g.facet;
      };
      EXPECT_TRUE(std::ranges::equal(a.unmatched, b.unmatched, same));
    }
  }
}

// A part that lacks others, which it is told to have.
TEST(Parts, WhatIsNotCompleteIsNotAResult) {
  const VoxelShape shape = testing_shapes::box_shape(20, 20, 20);
  Rounds rounds(shape, {9, 3});
  std::vector<Part> parts;
  rounds.run(kAllRounds, [&](Part& part) { parts.push_back(part); });
  EXPECT_THROW(complete(parts[0], {{0, 0, 0}, {24, 24, 24}}, nullptr, {}, {1, 1, 1}, rounds.hulls(), nullptr), Error);
}

TEST(Parts, OnlyClosedSetsAreLeft) {
  const VoxelShape shape = testing_shapes::box_shape(6, 7, 8);
  Rounds rounds(shape, {4, 3});
  std::size_t parts = 0;
  rounds.run(1, [&](Part& part) {
    const PartComplex complex = complex_of(part, rounds.hulls(), nullptr);
    Removal removal{std::vector<std::uint8_t>(part.found.cells.count(), 0),
                    std::vector<std::uint8_t>(complex.link_of.size(), 0)};
    if (removal.edge.empty()) return;
    ++parts;
    removal.vertex[complex.dual.complex.edges[0][1]] = 1;
    EXPECT_THROW(remove(part, complex, removal, 0), Error);  // its edge has no other end
    std::ranges::fill(removal.edge, 1);
    std::ranges::fill(removal.vertex, 1);
    EXPECT_THROW(remove(part, complex, removal, 0), Error);  // something is not known
  });
  EXPECT_GT(parts, 0u);
}

}  // namespace parts_test
}  // namespace quench::dual::bricks
