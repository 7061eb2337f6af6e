// SPDX-License-Identifier: Apache-2.0
// Pages of shapes of the plane: the figure covers the pixels and nothing else, and layers hold lines.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "page_reader.h"
#include "quench/error.h"
#include "quench/page.h"
#include "quench/pipeline.h"
#include "random_shapes.h"
#include "temporary_folder.h"

namespace quench {
namespace page_plane_test {

using testing_page::Contents;

/// A slice of a random shape that has a voxel.
VoxelShape random_plane(std::uint64_t seed, int largest = 14) {
  const VoxelShape solid = testing_shapes::random_shape(seed, largest, seed % 3 == 1);
  std::int64_t z = 0;
  while (solid.row(0, z).empty() && z + 1 < solid.grid().dims[2]) {
    bool empty = true;
    for (std::int64_t y = 0; y < solid.grid().dims[1]; ++y) empty &= solid.row(y, z).empty();
    if (!empty) break;
    ++z;
  }
  Grid grid = solid.grid();
  grid.dims[2] = 1;
  grid.make_plane();
  return testing_shapes::from_predicate(grid, [&](int x, int y, int) { return solid.contains(x, y, z); });
}

Contents read_back(const Page& page) {
  const TemporaryFolder folder;
  write_page(folder / "page.html", page, "<body><!--quench-data--></body>");
  return testing_page::read_page(testing_page::bytes_of(folder / "page.html"));
}

template <class T>
const std::vector<T>& values(const Page& page, const std::string& name) {
  static const std::vector<T> none;
  const PageArray* const found = page.find(name);
  EXPECT_TRUE(found) << name;
  return found ? std::get<std::vector<T>>(found->values) : none;
}

// The boundary of the triangles, all of one sense, is that of the pixels: so they cover these, each once.
TEST(PagePlane, TheFigureIsThePixels) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE(seed);
    const VoxelShape shape = random_plane(seed);
    const TriangleMesh mesh = flat_pixels(shape);
    using Corner = std::array<std::int64_t, 2>;
    const auto corner = [&](std::uint32_t v) {
      const Vec3 at = shape.grid().lattice(mesh.points[v]);
      return Corner{std::llround(at[0]), std::llround(at[1])};
    };
    double area = 0;
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> sides;
    for (const auto& t : mesh.triangles) {
      const Vec3 a = mesh.points[t[0]], b = mesh.points[t[1]], c = mesh.points[t[2]];
      const double twice = (b - a)[0] * (c - a)[1] - (b - a)[1] * (c - a)[0];
      ASSERT_GT(twice, 0);
      area += twice / 2;
      for (std::size_t i = 0; i < 3; ++i) ++sides[std::pair(t[i], t[(i + 1) % 3])];
    }
    const double pixel = shape.grid().spacing[0] * shape.grid().spacing[1];
    ASSERT_NEAR(area, pixel * static_cast<double>(shape.voxel_count()), 1e-9 * area);
    std::map<std::pair<Corner, Corner>, int> found, wanted;
    for (const auto& [side, count] : sides) {
      ASSERT_EQ(count, 1);
      if (sides.contains(std::pair(side.second, side.first))) continue;
      Corner at = corner(side.first);
      const Corner end = corner(side.second);
      ASSERT_TRUE(at[0] == end[0] || at[1] == end[1]);
      while (at != end) {
        const Corner before = at;
        for (std::size_t i = 0; i < 2; ++i) at[i] += (end[i] > at[i]) - (end[i] < at[i]);
        ++found[std::pair(before, at)];
      }
    }
    const auto& dims = shape.grid().dims;
    for (std::int64_t y = 0; y < dims[1]; ++y)
      for (std::int64_t x = 0; x < dims[0]; ++x) {
        if (!shape.contains(x, y, 0)) continue;
        const std::array<Corner, 4> c{{{x, y}, {x + 1, y}, {x + 1, y + 1}, {x, y + 1}}};
        const std::array<bool, 4> beside{shape.contains(x, y - 1, 0), shape.contains(x + 1, y, 0),
                                         shape.contains(x, y + 1, 0), shape.contains(x - 1, y, 0)};
        for (std::size_t i = 0; i < 4; ++i)
          if (!beside[i]) ++wanted[std::pair(c[i], c[(i + 1) % 4])];
      }
    ASSERT_EQ(found, wanted);
  }
}

TEST(PagePlane, ThereIsNoSurface) { EXPECT_THROW(smoothed_boundary(random_plane(1), 1), Error); }

TEST(PagePlane, SurfacesAreAddedToEachOther) {
  const VoxelShape first = random_plane(3), second = random_plane(5);
  Page page;
  const std::size_t a = add_surface(page, first, 100000), b = add_surface(page, second, 100000);
  const auto& triangles = values<std::uint32_t>(page, "shape/triangles");
  EXPECT_EQ(triangles.size(), 3 * (a + b));
  EXPECT_EQ(*std::max_element(triangles.begin(), triangles.end()) + 1, values<float>(page, "shape/points").size() / 3);
  EXPECT_TRUE(page.notes.empty());
  Page alone;
  add_surface(alone, second, 100000);
  const std::uint32_t before = *std::max_element(triangles.begin(), triangles.begin() + static_cast<long>(3 * a)) + 1;
  for (std::size_t i = 0; i < 3 * b; ++i)
    ASSERT_EQ(triangles[3 * a + i], values<std::uint32_t>(alone, "shape/triangles")[i] + before);
}

TEST(PagePlane, OneNoteSaysThatSurfacesAreSimplified) {
  Page page;
  const std::size_t a = add_surface(page, random_plane(3), 10);
  ASSERT_EQ(page.notes.size(), 1u);
  EXPECT_TRUE(page.notes[0].starts_with("The shape has ")) << page.notes[0];
  page.notes.emplace_back("other");
  const std::size_t b = add_surface(page, random_plane(5), 10), c = add_surface(page, random_plane(7), 100000);
  ASSERT_EQ(page.notes.size(), 2u);
  EXPECT_TRUE(page.notes[0].starts_with("The 3 shapes have ")) << page.notes[0];
  EXPECT_EQ(page.surfaces.drawn, a + b + c);
  EXPECT_EQ(page.surfaces.given,
            flat_pixels(random_plane(3)).triangles.size() + flat_pixels(random_plane(5)).triangles.size() + c);
}

TEST(PagePlane, SamplesLieInThePixels) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const VoxelShape shape = random_plane(seed);
    Page page;
    add_samples(page, shape, 500);
    const auto& samples = values<float>(page, "shape/samples");
    ASSERT_EQ(samples.size(), 1500u);
    for (std::size_t i = 0; i < samples.size(); i += 3) {
      ASSERT_EQ(samples[i + 2], 0);
      const Vec3 lattice = shape.grid().lattice({samples[i], samples[i + 1], 0});
      const auto in = [&](double x) {
        return shape.contains(static_cast<std::int64_t>(std::floor(lattice[0] + x)),
                              static_cast<std::int64_t>(std::floor(lattice[1] + x)), 0);
      };
      ASSERT_TRUE(in(-1e-5) || in(1e-5));
    }
  }
}

TEST(PagePlane, TheMainJobWritesLinesAndOneTheta) {
  for (const bool y_down : {true, false}) {
    VoxelShape voxels = random_plane(7, 40);
    const Grid grid = voxels.grid();
    pipeline::LoadedShape shape = pipeline::shape_of(std::move(voxels), grid, {});
    shape.coordinates.y_down = y_down;
    pipeline::PageBuilder builder;
    pipeline::RunOptions options;
    options.page = &builder;
    const pipeline::RunResult result = pipeline::run(shape, options);
    const Contents contents = read_back(builder.page);
    EXPECT_EQ(contents.meta["dimension"], 2);
    EXPECT_EQ(contents.meta["y_axis"], y_down ? "down" : "up");
    EXPECT_FALSE(contents.meta.contains("theta2"));
    EXPECT_FALSE(contents.meta.contains("surface"));
    for (const char* layer : {"skeleton", "family", "core"}) {
      const std::string name = layer;
      EXPECT_EQ(contents[name + "/polygon_corners"].size(), 0u);
      for (const char* measure : {"radius", "burn_time", "erosion_thickness"})
        EXPECT_EQ(3 * contents[name + "/point/" + measure].size(), contents[name + "/points"].size()) << measure;
      EXPECT_FALSE(contents.has(name + "/point/curve_burn_time"));
      const auto& points = contents[name + "/points"];
      for (std::size_t i = 2; i < points.size(); i += 3) ASSERT_EQ(points[i], 0);
    }
    EXPECT_EQ(contents["core/edges"].size(), 2 * result.core.axis.complex.edges.size());
    const auto& sites = contents["shape/sites"];
    EXPECT_EQ(sites.size(), 3 * boundary_vertices(shape.shape).size());
    // The fire of the layer `core` is that of its file.
    const auto &times = contents["core/point/burn_time"], &radii = contents["core/point/radius"];
    for (std::size_t v = 0; v < times.size(); ++v) EXPECT_GE(times[v], radii[v] * (1 - 1e-3));
  }
}

TEST(PagePlane, PagesOfVolumesDoNotSayADimension) {
  Page page;
  add_surface(page, testing_shapes::box_shape(2, 2, 2), 1000);
  const Contents contents = read_back(page);
  EXPECT_FALSE(contents.meta.contains("dimension"));
  EXPECT_FALSE(contents.meta.contains("y_axis"));
}

}  // namespace page_plane_test
}  // namespace quench
