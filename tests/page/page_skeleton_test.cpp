// SPDX-License-Identifier: Apache-2.0
// The skeleton that was asked for is in the page cell by cell, and what a file leaves out comes back from it.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <vector>

#include "hand_built_skeletons.h"
#include "page_reader.h"
#include "quench/page.h"
#include "quench/pipeline.h"
#include "quench/sample.h"
#include "random_complexes.h"
#include "random_shapes.h"
#include "temporary_folder.h"

namespace quench {
namespace page_skeleton_test {

using testing_page::Contents;

Contents read_back(const Page& page) {
  const TemporaryFolder folder;
  write_page(folder / "page.html", page, "<body><!--quench-data--></body>");
  return testing_page::read_page(testing_page::bytes_of(folder / "page.html"));
}

std::size_t at(const std::vector<double>& values, std::size_t i) { return static_cast<std::size_t>(values.at(i)); }

/// Numbers of places; those that are nearer to each other than `tolerance` have one.
class Numbers {
 public:
  explicit Numbers(double tolerance) : tolerance_(tolerance) {}
  std::size_t of(const Vec3& p) {
    const auto cell = [&](Eigen::Index k, int d) {
      return static_cast<std::int64_t>(std::floor(p[k] / (4 * tolerance_))) + d;
    };
    for (const int x : {0, -1, 1})
      for (const int y : {0, -1, 1})
        for (const int z : {0, -1, 1})
          for (const std::size_t n : cells_[{cell(0, x), cell(1, y), cell(2, z)}])
            if ((places_[n] - p).norm() < tolerance_) return n;
    cells_[{cell(0, 0), cell(1, 0), cell(2, 0)}].push_back(places_.size());
    places_.push_back(p);
    return places_.size() - 1;
  }

 private:
  double tolerance_;
  std::map<std::array<std::int64_t, 3>, std::vector<std::size_t>> cells_;
  std::vector<Vec3> places_;
};

using Cycle = std::vector<std::size_t>;

/// The cells of a skeleton: polygons by their corners in order, from the least on, segments of curves by their ends,
/// isolated vertices.
struct Drawn {
  std::multiset<Cycle> polygons, segments, isolated;
  friend bool operator==(const Drawn&, const Drawn&) = default;
};

Cycle from_least(Cycle cycle) {
  std::rotate(cycle.begin(), std::min_element(cycle.begin(), cycle.end()), cycle.end());
  return cycle;
}

void add_segment(Drawn& drawn, std::size_t a, std::size_t b) {
  drawn.segments.insert({std::min(a, b), std::max(a, b)});
}

/// Sheets of the skeleton and branches of the graph.
Drawn drawn_by_program(const Skeleton& skeleton, const CurveGraph& graph, Numbers& numbers) {
  Drawn drawn;
  for (std::size_t f = 0; f < skeleton.complex.face_count(); ++f) {
    Cycle corners;
    for (const std::uint32_t v : skeleton.complex.corners(f)) corners.push_back(numbers.of(skeleton.points[v]));
    drawn.polygons.insert(from_least(std::move(corners)));
  }
  for (const CurveGraph::Branch& branch : graph.branches)
    for (std::size_t i = 1; i < branch.points.size(); ++i)
      add_segment(drawn, numbers.of(branch.points[i - 1]), numbers.of(branch.points[i]));
  for (const CurveGraph::Node& node : graph.nodes)
    if (node.kind == CurveGraph::NodeKind::isolated) drawn.isolated.insert({numbers.of(node.point)});
  return drawn;
}

Vec3 place_of(const Contents& page, std::size_t v) {
  const std::vector<double>& p = page["skeleton/points"];
  return {p.at(3 * v), p.at(3 * v + 1), p.at(3 * v + 2)};
}

Drawn drawn_by_page(const Contents& page, Numbers& numbers) {
  Drawn drawn;
  const std::vector<double>&corners = page["skeleton/polygon_corners"], &offsets = page["skeleton/polygon_offsets"],
        &along = page["skeleton/branch_points"], &branches = page["skeleton/branch_offsets"];
  const auto number = [&](double v) { return numbers.of(place_of(page, static_cast<std::size_t>(v))); };
  for (std::size_t f = 0; f + 1 < offsets.size(); ++f) {
    Cycle cycle;
    for (std::size_t i = at(offsets, f); i < at(offsets, f + 1); ++i) cycle.push_back(number(corners.at(i)));
    drawn.polygons.insert(from_least(std::move(cycle)));
  }
  for (std::size_t b = 0; b + 1 < branches.size(); ++b)
    for (std::size_t i = at(branches, b) + 1; i < at(branches, b + 1); ++i)
      add_segment(drawn, number(along.at(i - 1)), number(along.at(i)));
  for (const double v : page["skeleton/isolated"]) drawn.isolated.insert({number(v)});
  return drawn;
}

TEST(PageSkeleton, HoldsEveryCellAndValueOfASkeleton) {
  for (std::uint64_t seed = 0; seed < 300 && !testing::Test::HasFailure(); ++seed) {
    SCOPED_TRACE(seed);
    const Skeleton skeleton = testing_skeletons::skeleton_of(testing_skeletons::random_cells(seed));
    const CurveGraph graph = curve_graph(skeleton);
    Page page;
    page.side = 10;
    std::size_t triangles = 0;
    for (std::size_t f = 0; f < skeleton.complex.face_count(); ++f) triangles += skeleton.complex.corners(f).size() - 2;
    ASSERT_EQ(add_skeleton(page, skeleton, graph), triangles);
    const Contents read = read_back(page);
    Numbers numbers(1e-5);  // of a box of 10
    ASSERT_TRUE(drawn_by_program(skeleton, graph, numbers) == drawn_by_page(read, numbers));
    ASSERT_EQ(read["skeleton/points"].size(), 3 * skeleton.points.size());
    std::map<std::size_t, double> radius;
    for (std::size_t v = 0; v < skeleton.points.size(); ++v)
      radius[numbers.of(skeleton.points[v])] = skeleton.radius[v];
    for (std::size_t v = 0; v < skeleton.points.size(); ++v)
      ASSERT_NEAR(read["skeleton/point/radius"][v], radius.at(numbers.of(place_of(read, v))), 1e-4);
    for (std::size_t b = 0; b < graph.branches.size(); ++b) {
      const CurveGraph::Branch& branch = graph.branches[b];
      ASSERT_FLOAT_EQ(static_cast<float>(read["skeleton/branch/length"][b]), static_cast<float>(branch.length));
      ASSERT_FLOAT_EQ(static_cast<float>(read["skeleton/branch/mean_radius"][b]),
                      static_cast<float>(branch.mean_radius));
      ASSERT_EQ(read["skeleton/branch_nodes"][2 * b], branch.from);
      ASSERT_EQ(read["skeleton/branch_nodes"][2 * b + 1], branch.to);
    }
    for (std::size_t n = 0; n < graph.nodes.size(); ++n)
      ASSERT_EQ(read["skeleton/node_kind"][n], static_cast<double>(graph.nodes[n].kind));
  }
}

// A T of squares.
TEST(PageSkeleton, FacesHaveTheirSheets) {
  testing_skeletons::Cells cells;
  for (const double x : {0, 1, 2, 3})
    for (const double y : {0, 1}) cells.add(x, y, 0);
  cells.add(2, 0, 1);
  cells.add(2, 1, 1);
  cells.faces = {{0, 1, 3, 2}, {2, 3, 5, 4}, {4, 5, 7, 6}, {4, 5, 9, 8}};
  Skeleton skeleton = testing_skeletons::skeleton_of(cells);
  skeleton.face_sheet = {0, 0, 1, 2};
  Page page;
  page.side = 3;
  add_skeleton(page, skeleton, curve_graph(skeleton));
  EXPECT_EQ(read_back(page)["skeleton/polygon_sheet"], (std::vector<double>{0, 0, 1, 2}));
}

TEST(PageSkeleton, IsThatOfTheFilesForBuiltShapesWhateverTheBudget) {
  const SampleOptions coarse{.fineness = 0.3};
  for (const auto& [sample, resolution] : std::vector<std::pair<std::string, int>>{{"fin-on-board", 40},
                                                                                   {"torus", 32},
                                                                                   {"box", 24},
                                                                                   {"four-blobs", 40},
                                                                                   {"plate-with-holes", 40},
                                                                                   {"root", 48}})
    for (const std::size_t budget : {kPageTriangles, std::size_t{300}}) {
      SCOPED_TRACE(testing::Message() << sample << ' ' << budget);
      pipeline::PageBuilder builder(budget);
      pipeline::RunOptions options;
      options.page = &builder;
      pipeline::LoadedShape shape = pipeline::shape_of(make_sample(sample, coarse).mesh, {.resolution = resolution});
      const pipeline::RunResult result = pipeline::run(shape, options);
      const Contents read = read_back(builder.page);
      Numbers numbers(1e-6 * shape.longest_side);
      const Skeleton& skeleton = result.axis.skeleton.skeleton;
      EXPECT_TRUE(drawn_by_program(skeleton, result.axis.graph, numbers) == drawn_by_page(read, numbers));
      EXPECT_FLOAT_EQ(read.meta["theta2"].get<float>(), static_cast<float>(skeleton.theta2));
      EXPECT_FLOAT_EQ(read.meta["theta1"].get<float>(), static_cast<float>(skeleton.theta1));
      EXPECT_EQ(read.meta.contains("note"), read.meta["floor"]["theta2"] > read.meta["theta2"] ||
                                                read.meta["floor"]["theta1"] > read.meta["theta1"]);
    }
}

/// Cells of a layer by the numbers of their vertices in `id`, with their levels.
struct Cells {
  std::multiset<std::vector<double>> vertices, edges, faces;
  friend bool operator==(const Cells&, const Cells&) = default;
};

Cells cells_of(const testing_page::Arrays& arrays, const std::string& layer) {
  const auto get = [&](const std::string& name) -> const std::vector<double>& { return arrays.at(layer + "/" + name); };
  Cells cells;
  const std::vector<double>& id = get("point/id");
  const auto number = [&](double v) { return std::round(id.at(static_cast<std::size_t>(v))); };
  for (std::size_t v = 0; v < id.size(); ++v)
    cells.vertices.insert({number(static_cast<double>(v)), get("vertex_level")[v]});
  std::map<std::size_t, double> curve;
  for (std::size_t i = 0; layer == "family" && i < get("curve_edges").size(); ++i)
    curve[at(get("curve_edges"), i)] = get("curve_thickness")[i];
  const std::vector<double>&ends = get("edges"), &offsets = get("polygon_offsets");
  for (std::size_t e = 0; 2 * e < ends.size(); ++e) {
    const double a = number(ends[2 * e]), b = number(ends[2 * e + 1]);
    cells.edges.insert({std::min(a, b), std::max(a, b), get("edge_level")[e], curve.contains(e) ? curve[e] : -1});
  }
  for (std::size_t f = 0; f + 1 < offsets.size(); ++f) {
    std::vector<double> face{get("face_level")[f]};
    for (std::size_t i = at(offsets, f); i < at(offsets, f + 1); ++i) {
      face.push_back(number(get("polygon_corners")[i]));
      if (layer == "family") face.push_back(get("corner_level")[i]);
      // Which of parallel edges a side is, its values tell.
      const std::size_t e = at(get("polygon_edges"), i);
      face.push_back(get("edge_level").at(e));
      face.push_back(curve.contains(e) ? curve[e] : -1);
    }
    cells.faces.insert(face);
  }
  return cells;
}

testing_page::Arrays numbers_of(const Page& page) {
  testing_page::Arrays arrays;
  for (const PageArray& array : page.arrays)
    std::visit([&](const auto& values) { arrays[array.name].assign(values.begin(), values.end()); }, array.values);
  return arrays;
}

void add_id(Page& page, const std::string& layer) {
  std::vector<float> id(std::get<std::vector<float>>(page.find(layer + "/points")->values).size() / 3);
  for (std::size_t v = 0; v < id.size(); ++v) id[v] = static_cast<float>(v);
  page.arrays.push_back({layer + "/point/id", 1, std::move(id)});
}

TEST(PageFile, CellsAndLevelsOfAFamilyComeBackExactly) {
  for (std::uint64_t seed = 0; seed < 200 && !testing::Test::HasFailure(); ++seed) {
    SCOPED_TRACE(seed);
    const testing_complexes::BurnInput input = testing_complexes::random_input(seed);
    BurnOptions options;
    options.omega = std::array{0.3, 0.45, 0.8, 1.7, 20.0}[seed % 5];
    options.radius = input.rule;
    const Burning burning = burn(input.complex, input.points, input.radius, options);
    Page page;
    page.side = 1;
    add_family(page, skeletons(quench_curves(input.complex, input.points, input.radius, burning)), 100'000);
    add_id(page, "family");
    ASSERT_TRUE(cells_of(read_back(page).arrays, "family") == cells_of(numbers_of(page), "family"));
  }
}

TEST(PageFile, CellsAndLevelsOfACoreComeBackExactly) {
  for (std::uint64_t seed = 0; seed < 60 && !testing::Test::HasFailure(); ++seed) {
    SCOPED_TRACE(seed);
    MedialAxis axis = voxel_core(testing_shapes::random_shape(seed, 12));
    prune_levels(axis);
    Page page;
    page.side = 12;
    add_core(page, axis, to_record(axis).point_data, 100'000);
    add_id(page, "core");
    const Contents read = read_back(page);
    ASSERT_TRUE(cells_of(read.arrays, "core") == cells_of(numbers_of(page), "core"));
    const auto& points = std::get<std::vector<float>>(page.find("core/points")->values);
    for (std::size_t v = 0; v < points.size() / 3; ++v)
      for (std::size_t k = 0; k < 3; ++k)
        ASSERT_NEAR(read["core/points"][3 * v + k],
                    points[3 * static_cast<std::size_t>(std::lround(read["core/point/id"][v])) + k], 12 / 65533.0);
  }
}

}  // namespace page_skeleton_test
}  // namespace quench
