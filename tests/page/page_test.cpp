// SPDX-License-Identifier: Apache-2.0
// What a page holds: arrays come back as they were put in, and its sets are those of the program.
#include "quench/page.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>
#include <random>

#include "page_reader.h"
#include "quench/axis.h"
#include "quench/error.h"
#include "random_complexes.h"
#include "random_shapes.h"
#include "temporary_folder.h"

namespace quench {
namespace page_test {

using testing_page::Contents;

constexpr float kInfinity = std::numeric_limits<float>::infinity();
const std::string kProgram = "<!doctype html><html><body><p></p><!--quench-data--><script>1</script></body></html>";

std::string written(const Page& page, const std::string& program = kProgram) {
  const TemporaryFolder folder;
  write_page(folder / "page.html", page, program);
  return testing_page::bytes_of(folder / "page.html");
}

template <class T>
const std::vector<T>& array(const Page& page, const std::string& name) {
  static const std::vector<T> none;
  const PageArray* found = page.find(name);
  EXPECT_TRUE(found) << name;
  return found ? std::get<std::vector<T>>(found->values) : none;
}

// A complex with what decides which of its cells are there; of K, or as a page holds it.
struct Family {
  CellComplex complex;
  std::vector<double> vertex, edge, face;  // levels
  std::vector<double> thickness;           // per edge; infinite where it is no curve
  std::vector<char> medial_point;
};

struct Cells {
  std::vector<char> vertex, edge, face;
  friend bool operator==(const Cells&, const Cells&) = default;
};

// FORMAT.md, "The sets", without any clever structure.
Cells cells_at(const Family& family, double theta2, double theta1) {
  const CellComplex& c = family.complex;
  Cells cells;
  for (const double level : family.vertex) cells.vertex.push_back(level >= theta2);
  for (const double level : family.edge) cells.edge.push_back(level >= theta2);
  for (const double level : family.face) cells.face.push_back(level >= theta2);
  std::vector<char> on_face(c.edges.size(), 0);
  for (std::size_t f = 0; f < cells.face.size(); ++f)
    if (cells.face[f])
      for (const std::uint32_t e : c.sides(f)) on_face[e] = 1;
  for (bool changed = true; changed;) {
    changed = false;
    std::vector<std::uint32_t> degree(c.vertex_count, 0);
    for (std::size_t e = 0; e < cells.edge.size(); ++e)
      if (cells.edge[e])
        for (const std::uint32_t v : c.edges[e]) ++degree[v];
    for (std::size_t e = 0; e < cells.edge.size(); ++e)
      for (const std::uint32_t v : c.edges[e])
        if (cells.edge[e] && !on_face[e] && family.thickness[e] < theta1 && degree[v] == 1 && !family.medial_point[v]) {
          cells.edge[e] = cells.vertex[v] = 0;
          for (const std::uint32_t u : c.edges[e]) --degree[u];
          changed = true;
        }
  }
  return cells;
}

Family family_of(const SkeletonFamily& skeletons) {
  const RefinedAxis& k = skeletons.refined;
  Family family{k.complex,     skeletons.vertex_sheet_level, skeletons.edge_sheet_level, skeletons.face_sheet_level, {},
                k.medial_point};
  for (std::uint32_t e = 0; e < k.complex.edges.size(); ++e)
    family.thickness.push_back(k.curve_edge[e] && e >= 2 * k.doors ? skeletons.thickness_of(e) : kInfinity);
  return family;
}

Family family_of(const Page& page, const std::string& layer) {
  const auto name = [&](const char* what) { return layer + "/" + what; };
  Family family;
  CellComplex& c = family.complex;
  const auto& levels = array<float>(page, name("vertex_level"));
  c.vertex_count = static_cast<std::uint32_t>(levels.size());
  EXPECT_EQ(array<float>(page, name("points")).size(), 3 * levels.size());
  const auto& ends = array<std::uint32_t>(page, name("edges"));
  for (std::size_t e = 0; e < ends.size(); e += 2) c.edges.push_back({ends[e], ends[e + 1]});
  c.face_offsets = array<std::uint32_t>(page, name("polygon_offsets"));
  c.face_vertices = array<std::uint32_t>(page, name("polygon_corners"));
  c.face_edges = array<std::uint32_t>(page, name("polygon_edges"));
  for (std::size_t f = 0; f < c.face_count(); ++f)
    for (std::size_t i = 0; i < c.corners(f).size(); ++i) {
      const std::uint32_t a = c.corners(f)[i], b = c.corners(f)[(i + 1) % c.corners(f).size()];
      EXPECT_EQ(c.edges.at(c.sides(f)[i]), (std::array{std::min(a, b), std::max(a, b)}));
    }
  const auto doubles = [](const std::vector<float>& v) { return std::vector<double>(v.begin(), v.end()); };
  family.vertex = doubles(levels);
  family.edge = doubles(array<float>(page, name("edge_level")));
  family.face = doubles(array<float>(page, name("face_level")));
  EXPECT_TRUE(std::is_sorted(family.face.rbegin(), family.face.rend()));
  family.thickness.assign(c.edges.size(), kInfinity);
  family.medial_point.assign(c.vertex_count, 0);
  if (layer == "family") {
    const auto& curves = array<std::uint32_t>(page, "family/curve_edges");
    for (std::size_t i = 0; i < curves.size(); ++i)
      family.thickness.at(curves[i]) = array<float>(page, "family/curve_thickness").at(i);
    for (const std::uint32_t v : array<std::uint32_t>(page, "family/medial_points")) family.medial_point.at(v) = 1;
  }
  return family;
}

// Cells of the page as cells of K: vertices and edges are in the order of K; which faces, their corners tell.
Cells as_cells_of(const Family& k, const Cells& kept, const Family& page, const Cells& shown) {
  Cells cells{std::vector<char>(k.vertex.size(), 0), std::vector<char>(k.edge.size(), 0),
              std::vector<char>(k.face.size(), 0)};
  std::vector<std::uint32_t> edge_of;
  std::size_t row = 0;
  for (std::size_t v = 0; v < kept.vertex.size(); ++v)
    if (kept.vertex[v]) cells.vertex[v] = shown.vertex.at(row++);
  EXPECT_EQ(row, shown.vertex.size());
  row = 0;
  for (std::size_t e = 0; e < kept.edge.size(); ++e)
    if (kept.edge[e]) {
      edge_of.push_back(static_cast<std::uint32_t>(e));
      cells.edge[e] = shown.edge.at(row++);
    }
  EXPECT_EQ(row, shown.edge.size());
  std::multimap<std::vector<std::uint32_t>, std::size_t> face_of;
  for (std::size_t f = 0; f < kept.face.size(); ++f)
    if (kept.face[f]) face_of.emplace(std::vector(k.complex.sides(f).begin(), k.complex.sides(f).end()), f);
  EXPECT_EQ(face_of.size(), shown.face.size());
  for (std::size_t f = 0; f < shown.face.size(); ++f) {
    std::vector<std::uint32_t> sides;
    for (const std::uint32_t e : page.complex.sides(f)) sides.push_back(edge_of.at(e));
    const auto found = face_of.find(sides);
    EXPECT_TRUE(found != face_of.end());
    if (found == face_of.end()) continue;
    cells.face[found->second] = shown.face[f];
    face_of.erase(found);
  }
  return cells;
}

std::size_t triangles_of(const CellComplex& c) {
  std::size_t count = 0;
  for (std::size_t f = 0; f < c.face_count(); ++f) count += c.corners(f).size() - 2;
  return count;
}

SkeletonFamily random_family(std::uint64_t seed) {
  const testing_complexes::BurnInput input = testing_complexes::random_input(seed);
  BurnOptions options;
  options.omega = std::array{0.3, 0.45, 0.8, 1.7, 20.0}[seed % 5];
  options.radius = input.rule;
  const Burning burning = burn(input.complex, input.points, input.radius, options);
  return skeletons(quench_curves(input.complex, input.points, input.radius, burning));
}

TEST(Page, SkeletonSetsAreThoseOfTheFamilyForEverySliderAboveTheFloors) {
  std::size_t with_theta2_floor = 0, with_theta1_floor = 0;
  for (std::uint64_t seed = 0; seed < 400 && !testing::Test::HasFailure(); ++seed) {
    // Every other family has a floor of its own.
    const bool floored = seed % 2 == 1;
    const SkeletonFamily skeletons = floored ? with_floor(random_family(seed), 0.2, 0.15) : random_family(seed);
    const Family k = family_of(skeletons);
    const std::size_t all = triangles_of(k.complex);
    for (const std::size_t budget : {10 * k.complex.edges.size() + all, all, all / 2, all / 5, std::size_t{3}}) {
      SCOPED_TRACE(testing::Message() << "seed " << seed << " budget " << budget << " of " << all);
      Page page;
      const std::size_t shown = add_family(page, skeletons, budget);
      const Family of_page = family_of(page, "family");
      ASSERT_EQ(shown, triangles_of(of_page.complex));
      const double floor2 = *page.theta2_floor, floor1 = *page.theta1_floor;
      with_theta2_floor += floor2 > 0;
      with_theta1_floor += floor1 > 0;
      ASSERT_GE(floor2, skeletons.theta2_floor);
      ASSERT_GE(floor1, skeletons.theta1_floor);
      ASSERT_TRUE(page.notes.empty());
      std::size_t never = 0, free_curves = 0;
      for (std::size_t f = 0; f < k.face.size(); ++f)
        if (std::isinf(k.face[f])) never += k.complex.corners(f).size() - 2;
      ASSERT_LE(shown, std::max(budget, never));
      const Cells kept = cells_at(k, floor2, floor1);
      std::vector<char> on_face(of_page.complex.edges.size(), 0);
      for (const std::uint32_t e : of_page.complex.face_edges) on_face[e] = 1;
      for (std::size_t e = 0; e < on_face.size(); ++e)
        free_curves += !on_face[e] && std::isfinite(of_page.thickness[e]);
      ASSERT_TRUE(shown + free_curves <= budget || shown >= budget || std::isfinite(floor1));
      for (const double theta2 : {0.0, 0.05, 0.25, 0.5, 1.0, 1.5, double{kInfinity}})
        for (const double theta1 : {0.0, 0.1, 0.25, 1.0, double{kInfinity}}) {
          const float a = std::max(static_cast<float>(theta2), static_cast<float>(floor2)),
                      b = std::max(static_cast<float>(theta1), static_cast<float>(floor1));
          const Cells expected = cells_at(k, a, b);
          const Cells found = as_cells_of(k, kept, of_page, cells_at(of_page, a, b));
          ASSERT_TRUE(expected.vertex == found.vertex) << "theta2 " << a << " theta1 " << b;
          ASSERT_TRUE(expected.edge == found.edge) << "theta2 " << a << " theta1 " << b;
          ASSERT_TRUE(expected.face == found.face) << "theta2 " << a << " theta1 " << b;
        }
    }
  }
  EXPECT_GT(with_theta2_floor, 300u);
  EXPECT_GT(with_theta1_floor, 300u);
}

double length_of(const Vec3& a, const Vec3& b) { return (a - b).norm(); }

// Positions: curves are drawn where skeletons that are written have them, but for region duals without exit, where
// what is written depends on how many curves meet there.
TEST(Page, CurvesAreAsLongAsThoseThatAreWritten) {
  std::size_t compared = 0, exact = 0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    SCOPED_TRACE(seed);
    const SkeletonFamily skeletons = random_family(seed);
    const RefinedAxis& k = skeletons.refined;
    if (topology(k.complex).betti[2] != 0) continue;
    Page page;
    add_family(page, skeletons, 1'000'000);
    const Family of_page = family_of(page, "family");
    const auto& places = array<float>(page, "family/points");
    const auto at = [&](std::uint32_t v) { return Vec3(places[3 * v], places[3 * v + 1], places[3 * v + 2]); };
    for (const float theta1 : {0.0F, 0.3F, 1.0F}) {
      const Cells cells = cells_at(of_page, kInfinity, theta1);
      const Skeleton skeleton = extract(skeletons, kInfinity, theta1);
      double found = 0, expected = 0, allowed = 0;
      std::vector<int> curves(k.complex.vertex_count, 0);
      std::vector<int> all(k.complex.vertex_count, 0);
      for (std::size_t e = 0; e < cells.edge.size(); ++e)
        if (k.curve_edge[e])
          for (const std::uint32_t v : k.complex.edges[e]) ++all[v];
      const auto undecided = [&](std::uint32_t v) {
        if (v < k.nodes + k.doors) return false;
        return k.exit[v] == kNone ? curves[v] != 2 || all[v] > 2 : !cells.edge[k.exit[v]];
      };
      for (std::size_t e = 0; e < cells.edge.size(); ++e)
        if (cells.edge[e])
          for (const std::uint32_t v : k.complex.edges[e]) ++curves[v];
      for (std::size_t e = 0; e < cells.edge.size(); ++e) {
        if (!cells.edge[e]) continue;
        const auto [a, b] = k.complex.edges[e];
        found += length_of(at(a), at(b));
        if (undecided(b)) allowed += 2 * length_of(k.points[a], k.points[b]);
      }
      for (const auto& [a, b] : skeleton.complex.edges) expected += length_of(skeleton.points[a], skeleton.points[b]);
      ASSERT_NEAR(found, expected, allowed + 1e-4 * (1 + expected)) << "theta1 " << theta1;
      ++compared;
      exact += std::abs(found - expected) < 1e-4 * (1 + expected);
    }
  }
  EXPECT_GT(compared, 600u);
  EXPECT_GT(exact, compared / 2);
}

TEST(Page, CoreSetsAreThePruningsForEverySliderAboveTheFloor) {
  std::size_t with_floor = 0;
  for (std::uint64_t seed = 0; seed < 200 && !testing::Test::HasFailure(); ++seed) {
    const VoxelShape shape = testing_shapes::random_shape(seed, 12, seed % 3 == 1);
    MedialAxis axis = voxel_core(shape);
    prune_levels(axis);
    const std::size_t all = triangles_of(axis.complex);
    for (const std::size_t budget : {all, all / 2, all / 10}) {
      SCOPED_TRACE(testing::Message() << "seed " << seed << " budget " << budget << " of " << all);
      Page page;
      const std::size_t shown = add_core(page, axis, to_record(axis).point_data, budget);
      with_floor += page.measures[0].floor > 0;
      const Family of_page = family_of(page, "core");
      std::size_t never = 0;
      for (std::size_t f = 0; f < axis.complex.face_count(); ++f)
        if (std::isinf(axis.measure().level.face[f])) never += axis.complex.corners(f).size() - 2;
      ASSERT_EQ(shown, triangles_of(of_page.complex));
      ASSERT_LE(shown, std::max(budget, never));
      // Levels of voxel cores are roots of fractions: sliders on them, rounded, are the hard ones.
      for (const double wish : {0.0, 0.5, std::sqrt(0.5), 1.0, std::sqrt(1.25), 1.5, 2.0, 2.5, 1e30}) {
        const float lambda = std::max(static_cast<float>(wish), static_cast<float>(page.measures[0].floor));
        const MedialAxis expected = pruned(axis, lambda);
        const Cells cells = cells_at(of_page, lambda, 0);
        const auto count = [](const std::vector<char>& v) {
          return static_cast<std::size_t>(std::count(v.begin(), v.end(), 1));
        };
        ASSERT_EQ(count(cells.vertex), expected.complex.vertex_count) << "lambda " << lambda;
        ASSERT_EQ(count(cells.edge), expected.complex.edges.size()) << "lambda " << lambda;
        ASSERT_EQ(count(cells.face), expected.complex.face_count()) << "lambda " << lambda;
        double found = 0, wanted = 0;  // of the same cells: their radii
        for (std::size_t v = 0; v < cells.vertex.size(); ++v)
          if (cells.vertex[v]) found += array<float>(page, "core/point/radius")[v];
        for (const double r : expected.radius) wanted += r;
        ASSERT_NEAR(found, wanted, 1e-5 * wanted);
      }
    }
  }
  EXPECT_GT(with_floor, 200u);
}

// Two measures of one axis: floors of each, and all that is above them is there.
TEST(Page, CoreIsPrunedByEachOfItsMeasures) {
  std::size_t with_floor = 0;
  for (std::uint64_t seed = 0; seed < 60 && !testing::Test::HasFailure(); ++seed) {
    MedialAxis axis = voxel_core(testing_shapes::random_shape(seed, 12));
    Measure indices{"from the end", {}, {}};
    const auto count_down = [](std::vector<double>& values, std::size_t count) {
      for (std::size_t i = 0; i < count; ++i) values.push_back(static_cast<double>((count - i) % 64) / 16);
    };
    count_down(indices.value.vertex, axis.complex.vertex_count);
    count_down(indices.value.edge, axis.complex.edges.size());
    count_down(indices.value.face, axis.complex.face_count());
    axis.measures.push_back(std::move(indices));
    prune_levels(axis);
    prune_levels(axis, "from the end");
    for (const std::size_t part : {1, 3}) {
      Page page;
      const std::size_t shown = add_core(page, axis, to_record(axis).point_data, 2 * triangles_of(axis.complex) / part);
      Family family = family_of(page, "core");
      ASSERT_EQ(shown, triangles_of(family.complex));
      ASSERT_EQ(page.measures.size(), 2u);
      ASSERT_EQ(page.measures[0].floor, page.measures[0].floor);
      for (const PageMeasure& measure : page.measures) {
        with_floor += measure.floor > 0;
        const auto levels = [&](const char* of) {
          const auto& floats = array<float>(
              page, std::string("core/") + of + "_level" + (measure.name == "lambda" ? "" : "/" + measure.name));
          return std::vector<double>(floats.begin(), floats.end());
        };
        family.vertex = levels("vertex");
        family.edge = levels("edge");
        family.face = levels("face");
        for (const float wish : {0.0F, 0.5F, 1.0F, 2.5F, 1e30F}) {
          const float threshold = std::max(wish, static_cast<float>(measure.floor));
          const MedialAxis expected = pruned(axis, threshold, measure.name);
          const Cells cells = cells_at(family, threshold, 0);
          ASSERT_EQ(std::count(cells.vertex.begin(), cells.vertex.end(), 1), expected.complex.vertex_count)
              << measure.name << " " << threshold << " seed " << seed;
          ASSERT_EQ(std::count(cells.edge.begin(), cells.edge.end(), 1), std::ssize(expected.complex.edges));
          ASSERT_EQ(std::count(cells.face.begin(), cells.face.end(), 1),
                    static_cast<std::ptrdiff_t>(expected.complex.face_count()));
        }
      }
      const Contents read = testing_page::read_page(written(page));
      EXPECT_EQ(read.meta["measures"][1]["name"], "from the end");
      EXPECT_EQ(read.meta["measures"][1]["floor"], page.measures[1].floor);
      EXPECT_TRUE(read.has("core/face_level/from the end") && read.has("core/point/from the end"));
    }
  }
  EXPECT_GT(with_floor, 60u);
}

TEST(Page, LevelsOfAFileAreThoseOfTheAxis) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    MedialAxis axis = voxel_core(testing_shapes::random_shape(seed, 10));
    prune_levels(axis);
    const Record data = to_record(axis);
    MedialAxis read = medial_axis_of(data);
    ASSERT_EQ(read.complex.edges, axis.complex.edges);
    ASSERT_TRUE(take_levels(read, data));
    ASSERT_TRUE(read.measure().level == axis.measure().level) << "seed " << seed;
    Record without = data;
    std::erase_if(without.cell_data, [](const DataArray& a) { return a.name == "lambda_level"; });
    ASSERT_FALSE(take_levels(read, without));
  }
}

TEST(Page, ArraysComeBackFromTheFile) {
  Page page;
  page.title = "</script><script>alert(\"1\")</script>\\\xC3\xA4\xFF\n";
  page.command = "quench run 'a b.off'";
  page.side = 2.5;
  page.pruning = {"cap \"height\"", 0.1};  // no float
  page.theta2 = kInfinity;
  page.theta1_floor = 0.25;
  page.origin = {1e6, 0, -3};
  page.notes = {"One </SCRIPT>.", "Two."};
  page.files = {{"core", "a/core.vtp"}};
  page.burning = BurnOptions{.omega = 0.5, .radius = RadiusRule::linear, .plane = true};
  page.topology = Topology{-1, {1, 2, 0}};
  page.arrays = {{"a", 3, std::vector<float>{1, -2.5F, kInfinity}},
                 {"b", 1, std::vector<std::uint8_t>{1, 2, 255}},
                 {"c", 2, std::vector<std::uint16_t>{65535, 7}},
                 {"d", 1, std::vector<std::uint32_t>{}},
                 {"e", 1, std::vector<std::uint32_t>(700'000, 4000000000U)}};
  std::mt19937 random(3);
  page.arrays.push_back({"f", 1, std::vector<float>(300'000)});
  for (float& x : std::get<std::vector<float>>(page.arrays.back().values)) x = static_cast<float>(random()) / 7;
  const std::string html = written(page);
  const Contents contents = testing_page::read_page(html);
  EXPECT_EQ(contents.meta["title"], "</script><script>alert(\"1\")</script>\\\xC3\xA4\xEF\xBF\xBD\n");
  EXPECT_EQ(contents.meta["command"], "quench run 'a b.off'");
  EXPECT_EQ(contents.meta["pruning"]["measure"], "cap \"height\"");
  EXPECT_EQ(contents.meta["pruning"]["threshold"], 0.1);
  EXPECT_TRUE(contents.meta["theta2"].is_null());
  EXPECT_FALSE(contents.meta.contains("theta1"));
  EXPECT_EQ(contents.meta["floor"]["theta1"], 0.25);
  EXPECT_EQ(contents.meta["origin"], (std::vector<double>{1e6, 0, -3}));
  EXPECT_EQ(contents.meta["notes"].size(), 2u);
  EXPECT_EQ(contents.meta["files"]["core"], "a/core.vtp");
  EXPECT_EQ(contents.meta["burning"]["radius"], "linear");
  EXPECT_EQ(contents.meta["topology"]["betti"], (std::vector<int>{1, 2, 0}));
  EXPECT_EQ(contents["a"], (std::vector<double>{1, -2.5, kInfinity}));
  EXPECT_EQ(contents["b"], (std::vector<double>{1, 2, 255}));
  EXPECT_EQ(contents["c"], (std::vector<double>{65535, 7}));
  EXPECT_EQ(contents["d"], std::vector<double>{});
  EXPECT_EQ(contents["e"], std::vector<double>(700'000, 4000000000.0));
  const auto& f = std::get<std::vector<float>>(page.arrays.back().values);
  EXPECT_EQ(contents["f"], std::vector<double>(f.begin(), f.end()));
  EXPECT_EQ(html, written(page)) << "not the same twice";
  // Around it the program is as it was.
  EXPECT_TRUE(html.starts_with("<!doctype html><html><body><p></p><script type="));
  EXPECT_TRUE(html.ends_with("</script><script>1</script></body></html>"));
}

TEST(Page, DataStandsAtTheBeginningOfTheBodyOfAProgramWithoutAPlaceForIt) {
  Page page;
  page.title = "t";
  const std::string html = written(page, "<html><body class=x><script>1</script></body></html>");
  EXPECT_LT(html.find("quench-data"), html.find("<script>1"));
  EXPECT_EQ(testing_page::read_page(html).meta["title"], "t");
  EXPECT_THROW(written(page, "no page"), Error);
}

TEST(Page, APageThatCannotBeWrittenLeavesNothing) {
  const TemporaryFolder folder;
  folder.write("page.html", "before");
  const Page page;
  EXPECT_THROW(write_page(folder / "page.html", page, "no page"), Error);
  EXPECT_THROW(write_page(folder / "absent/page.html", page, kProgram), Error);
  EXPECT_EQ(testing_page::bytes_of(folder / "page.html"), "before");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
}

double volume_of(const TriangleMesh& mesh) {
  double six = 0;
  for (const auto& [a, b, c] : mesh.triangles) six += mesh.points[a].dot(mesh.points[b].cross(mesh.points[c]));
  return six / 6;
}

TEST(Page, TheBoundaryOfAVoxelShapeEnclosesItAndSmoothingHardlyMovesIt) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    SCOPED_TRACE(seed);
    VoxelShape shape = testing_shapes::random_shape(seed, 12, seed % 3 == 1);
    const TriangleMesh sharp = smoothed_boundary(shape, 0);
    const double voxels = static_cast<double>(shape.voxel_count()) * shape.grid().spacing.prod();
    ASSERT_NEAR(volume_of(sharp), voxels, 1e-9 * voxels);
    const TriangleMesh smooth = smoothed_boundary(shape, 4);
    ASSERT_EQ(smooth.triangles, sharp.triangles);
    for (std::size_t v = 0; v < sharp.points.size(); ++v)
      ASSERT_LE((smooth.points[v] - sharp.points[v]).cwiseQuotient(shape.grid().spacing).cwiseAbs().maxCoeff(),
                0.5 + 1e-9);
  }
}

TEST(Page, SurfacesKeepToTheirBudget) {
  const VoxelShape ball = testing_shapes::from_predicate(
      [] {
        Grid grid;
        grid.dims = {60, 60, 60};
        return grid;
      }(),
      [](int x, int y, int z) {
        const double a = x - 29.5, b = y - 29.5, c = z - 29.5;
        return a * a + b * b + c * c < 27 * 27;
      });
  const TriangleMesh mesh = smoothed_boundary(ball, 4);
  for (const std::size_t budget : {std::size_t{100}, std::size_t{3000}, std::size_t{10000}}) {
    Page page;
    const std::size_t shown = add_surface(page, mesh, budget);
    EXPECT_LE(shown, budget);
    EXPECT_GT(shown, budget / 4);
    EXPECT_EQ(page.notes.size(), 1u);
    const auto& places = array<float>(page, "shape/points");
    EXPECT_EQ(array<std::uint32_t>(page, "shape/triangles").size(), 3 * shown);
    for (std::size_t v = 0; v < places.size(); v += 3)  // the centre of the ball is at 29.5 in the world
      EXPECT_NEAR(length_of({places[v], places[v + 1], places[v + 2]}, Vec3::Constant(29.5)), 27,
                  budget < 200 ? 7 : 1.5);
  }
  Page page;
  EXPECT_EQ(add_surface(page, mesh, mesh.triangles.size()), mesh.triangles.size());
  EXPECT_TRUE(page.notes.empty());
}

TEST(Page, SitesAndSamplesAreThoseOfTheShape) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    SCOPED_TRACE(seed);
    const VoxelShape shape = testing_shapes::random_shape(seed, 10, seed % 2 == 1);
    Page page;
    add_sites(page, shape);
    add_samples(page, shape, 2000);
    const auto& sites = array<std::uint16_t>(page, "shape/sites");
    const std::vector<LatticePoint> expected = boundary_vertices(shape);
    ASSERT_EQ(sites.size(), 3 * expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
      const Vec3 lattice(sites[3 * i], sites[3 * i + 1], sites[3 * i + 2]);
      ASSERT_EQ(lattice, Vec3(expected[i][0], expected[i][1], expected[i][2]));
      const auto& m = *page.sites_to_world;
      for (std::size_t r = 0; r < 3; ++r)
        ASSERT_NEAR(m[4 * r] * lattice[0] + m[4 * r + 1] * lattice[1] + m[4 * r + 2] * lattice[2] + m[4 * r + 3],
                    shape.grid().world(lattice)[static_cast<Eigen::Index>(r)], 1e-9);
    }
    const auto& samples = array<float>(page, "shape/samples");
    ASSERT_EQ(samples.size(), 6000u);
    std::map<std::array<std::int64_t, 3>, std::int64_t> in_voxel;
    for (std::size_t i = 0; i < samples.size(); i += 3) {
      const Vec3 lattice = shape.grid().lattice({samples[i], samples[i + 1], samples[i + 2]});
      // Rounding may put a place on the far side of a voxel.
      const auto whole = [](double x) { return static_cast<std::int64_t>(std::floor(x - 1e-6)); };
      const std::array<std::int64_t, 3> voxel{whole(lattice[0]), whole(lattice[1]), whole(lattice[2])};
      ++in_voxel[voxel];
      ASSERT_TRUE(shape.contains(voxel[0], voxel[1], voxel[2]) ||
                  shape.contains(whole(lattice[0] + 2e-6), whole(lattice[1] + 2e-6), whole(lattice[2] + 2e-6)));
    }
    const double share = 2000.0 / static_cast<double>(shape.voxel_count());
    for (const auto& [voxel, count] : in_voxel) ASSERT_LE(static_cast<double>(count), share + 3);
    Page again;
    add_samples(again, shape, 2000);
    ASSERT_EQ(array<float>(again, "shape/samples"), samples);
  }
}

TEST(Page, FilesOfOtherKindsAreShownAsTheyAre) {
  Record data;
  data.points = {{1e6, 0, 0}, {1e6 + 1, 0, 0}, {1e6, 1, 0}, {1e6 + 2, 2, 0}, {1e6 + 3, 0, 0.25}};
  data.verts = {4};
  data.lines = {{2, 3}, {1, 1}};
  data.poly_offsets = {0, 3, 6};
  data.poly_corners = {0, 1, 2, 1, 1, 3};  // the second is a line
  data.point_data = {{"burn_time", 1, std::vector<double>{1, 2, 3, 3, 1}},
                     {"unburned", 1, std::vector<std::uint8_t>{0, 0, 1, 0, 0}},
                     {"normal", 3, std::vector<double>(15, 0)}};
  Page page;
  page.origin = {1e6, 0, 0};
  EXPECT_EQ(add_still(page, data, 1000), 2u);
  EXPECT_EQ(array<float>(page, "still/points"), (std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1, 0, 2, 2, 0, 3, 0, 0.25F}));
  EXPECT_EQ(array<std::uint32_t>(page, "still/polygon_offsets"), (std::vector<std::uint32_t>{0, 3}));
  EXPECT_EQ(array<std::uint32_t>(page, "still/edges").size(), 10u);
  EXPECT_EQ(array<float>(page, "still/point/burn_time"), (std::vector<float>{1, 2, kInfinity, 3, 1}));
  EXPECT_FALSE(page.find("still/face_level"));
  EXPECT_FALSE(page.find("still/point/normal"));
  EXPECT_FALSE(page.find("still/point/unburned"));
}

TEST(Page, LargeFilesOfOtherKindsAreSimplified) {
  Record data;
  constexpr std::uint32_t n = 100;
  for (std::uint32_t i = 0; i < n; ++i)
    for (std::uint32_t j = 0; j < n; ++j) data.points.emplace_back(i, j, 0);
  std::vector<double> measure;
  for (const Vec3& p : data.points) measure.push_back(p[0]);
  data.point_data = {{"radius", 1, measure}};
  data.lines = {{0, n * n - 1}};
  for (std::uint32_t i = 0; i + 1 < n; ++i)
    for (std::uint32_t j = 0; j + 1 < n; ++j) {
      for (const std::uint32_t v : {i * n + j, i * n + j + n, i * n + j + n + 1, i * n + j + 1})
        data.poly_corners.push_back(v);
      data.poly_offsets.push_back(static_cast<std::uint32_t>(data.poly_corners.size()));
    }
  Page page;
  const std::size_t shown = add_still(page, data, 2000);
  EXPECT_LE(shown, 2000u);
  EXPECT_GT(shown, 500u);
  EXPECT_EQ(page.notes.size(), 1u);
  const auto& places = array<float>(page, "still/points");
  const auto& radius = array<float>(page, "still/point/radius");
  ASSERT_EQ(places.size(), 3 * radius.size());
  for (std::size_t v = 0; v < radius.size(); ++v) EXPECT_NEAR(radius[v], places[3 * v], 5);
}

}  // namespace page_test
}  // namespace quench
