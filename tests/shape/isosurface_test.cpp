// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <random>
#include <set>

#include "closed_surfaces.h"
#include "quench/error.h"
#include "quench/shape.h"
#include "random_shapes.h"
#include "shape/cell_loops.h"

namespace quench {
namespace isosurface_test {

using namespace testing_surfaces;

void expect_topology_of(const TriangleMesh& surface, const VoxelShape& shape, const std::string& what) {
  const Topology t = topology(shape);
  ASSERT_TRUE(is_closed_manifold(surface)) << what;
  EXPECT_EQ(euler_of(surface), 2 * t.euler) << what;
  EXPECT_EQ(components_of(surface), t.betti[0] + t.betti[2]) << what;
}

// A volume with values of the samples' type.
template <class T>
Volume volume_of_values(const std::array<std::int64_t, 3>& dims, const std::vector<double>& values) {
  Volume volume;
  volume.grid.dims = dims;
  std::vector<T> samples;
  for (const double v : values) samples.push_back(static_cast<T>(v));
  volume.samples = std::move(samples);
  return volume;
}

Volume random_volume(unsigned seed) {
  std::mt19937 random(seed);
  const auto below = [&](unsigned n) { return static_cast<int>(random() % n); };
  const std::array<std::int64_t, 3> dims{1 + below(6), 1 + below(6), 1 + below(6)};
  std::vector<double> values;
  for (std::int64_t i = 0; i < dims[0] * dims[1] * dims[2]; ++i) values.push_back(static_cast<double>(below(200)));
  if (seed % 3 == 0) return volume_of_values<std::uint8_t>(dims, values);
  if (seed % 3 == 1) return volume_of_values<std::int16_t>(dims, values);
  for (double& v : values) v += below(64) / 64.0;
  if (seed % 2) values[random() % values.size()] = std::numeric_limits<double>::quiet_NaN();
  if (seed % 5 == 0) values[random() % values.size()] = std::numeric_limits<double>::infinity();
  return volume_of_values<float>(dims, values);
}

ForegroundOptions at_least(double threshold) {
  ForegroundOptions options;
  options.threshold = threshold;
  return options;
}

TEST(CellLoops, EveryCellHasTheBoundaryOfItsForeground) {
  // One cell with the corners of a set, in a background: the whole surface has the topology of the voxels.
  for (int corners = 1; corners < 256; ++corners) {
    Grid grid;
    grid.dims = {2, 2, 2};
    const VoxelShape shape = testing_shapes::from_predicate(
        grid, [&](int x, int y, int z) { return (corners >> (x + 2 * y + 4 * z) & 1) != 0; });
    expect_topology_of(midpoint_surface(shape), shape, "corners " + std::to_string(corners));
  }
}

TEST(CellLoops, DiscsAndTubes) {
  int tubes = 0;
  for (const auto& loops : shape::cell_loops()) tubes += loops.tube;
  EXPECT_EQ(tubes, 4);
}

TEST(Isosurface, HasTheTopologyOfTheShape) {
  std::set<int> seen;
  for (unsigned seed = 0; seed < 3000; ++seed) {
    const Volume volume = random_volume(seed);
    ForegroundOptions options = at_least(seed % 4 ? 100 : 60.5);
    options.invert = seed % 7 == 0;
    options.close = seed % 5 == 0 ? 1 : 0;
    options.connectivity = seed % 3 == 0 ? 26 : 6;
    std::optional<TriangleMesh> surface;
    VoxelShape shape;
    try {
      shape = foreground(volume, options, nullptr, nullptr, &surface);
    } catch (const Error&) {
      continue;  // nothing is foreground
    }
    if (!surface) continue;
    expect_topology_of(*surface, shape, "seed " + std::to_string(seed));
    if (HasFatalFailure()) return;
    const auto& dims = volume.grid.dims;
    for (std::int64_t z = -1; z < dims[2]; ++z)
      for (std::int64_t y = -1; y < dims[1]; ++y)
        for (std::int64_t x = -1; x < dims[0]; ++x) {
          int corners = 0;
          for (int c = 0; c < 8; ++c)
            corners |= shape.contains(x + (c & 1), y + (c >> 1 & 1), z + (c >> 2)) ? 1 << c : 0;
          seen.insert(corners);
        }
  }
  EXPECT_EQ(seen.size(), 256u);
}

TEST(Isosurface, HasEveryVoxelCentreOnItsSide) {
  for (unsigned seed = 0; seed < 150; ++seed) {
    const Volume volume = random_volume(seed);
    std::optional<TriangleMesh> surface;
    const VoxelShape shape = foreground(volume, at_least(30), nullptr, nullptr, &surface);
    if (!surface) continue;
    const auto& dims = volume.grid.dims;
    for (std::int64_t z = -1; z <= dims[2]; ++z)
      for (std::int64_t y = -1; y <= dims[1]; ++y)
        for (std::int64_t x = -1; x <= dims[0]; ++x) {
          const Vec3 centre(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5, static_cast<double>(z) + 0.5);
          ASSERT_NEAR(winding_number(*surface, centre), shape.contains(x, y, z) ? 1 : 0, 1e-6) << "seed " << seed;
        }
  }
}

bool same(const TriangleMesh& a, const TriangleMesh& b) { return a.points == b.points && a.triangles == b.triangles; }

TEST(Isosurface, IsTheSameForEveryOrderInMemoryForSlicesAndForThreads) {
  for (const unsigned seed : {3u, 4u, 5u}) {
    std::mt19937 random(seed);
    std::vector<double> values(9 * 11 * 70);
    for (double& v : values) v = static_cast<double>(random() % 100);
    const std::array<std::int64_t, 3> dims{9, 11, 70};
    const Volume volume = volume_of_values<std::uint16_t>(dims, values);
    const auto& samples = std::get<std::vector<std::uint16_t>>(volume.samples);
    std::optional<TriangleMesh> expected;
    Context one;
    one.threads = 1;
    foreground(volume, at_least(50), nullptr, &one, &expected);
    ASSERT_TRUE(expected);

    Context three;
    three.threads = 3;
    std::optional<TriangleMesh> found;
    foreground(volume, at_least(50), nullptr, &three, &found);
    EXPECT_TRUE(found && same(*expected, *found));

    std::vector<std::uint16_t> turned(samples.size());
    ImageView view = view_of(volume);
    view.strides = {2 * dims[1] * dims[2], 2 * dims[2], 2};
    for (std::int64_t z = 0; z < dims[2]; ++z)
      for (std::int64_t y = 0; y < dims[1]; ++y)
        for (std::int64_t x = 0; x < dims[0]; ++x)
          turned[static_cast<std::size_t>(z + dims[2] * (y + dims[1] * x))] =
              samples[static_cast<std::size_t>(x + dims[0] * (y + dims[1] * z))];
    view.data = turned.data();
    foreground(view, at_least(50), nullptr, nullptr, &found);
    EXPECT_TRUE(found && same(*expected, *found));

    SliceStream stream;
    stream.grid = volume.grid;
    stream.type = SampleType::uint16;
    std::size_t read = 0;
    stream.next = [&](std::span<std::byte> slice) {
      std::memcpy(slice.data(), samples.data() + read, slice.size());
      read += slice.size() / 2;
    };
    foreground(stream, at_least(50), nullptr, nullptr, &found);
    EXPECT_TRUE(found && same(*expected, *found));
  }
}

TEST(Isosurface, IsCutToTheShapeThatIsLeft) {
  for (unsigned seed = 0; seed < 300; ++seed) {
    const VoxelShape whole = testing_shapes::random_shape(seed);
    ForegroundOptions options;
    options.largest_component = seed % 2;
    options.fill_cavities = seed % 3 != 0;
    const VoxelShape shape = clean(whole, options);
    TriangleMesh cut = midpoint_surface(whole);
    restrict_surface(cut, shape);
    const TriangleMesh direct = midpoint_surface(shape);
    expect_topology_of(cut, shape, "seed " + std::to_string(seed));
    EXPECT_NEAR(volume_of(cut), volume_of(direct), 1e-9);
  }
}

TEST(Isosurface, NeedsGreyValues) {
  std::optional<TriangleMesh> surface;
  const Volume mask = volume_of_values<std::uint8_t>({2, 1, 1}, {0, 255});
  foreground(mask, at_least(128), nullptr, nullptr, &surface);
  EXPECT_FALSE(surface);
  const Volume labels = volume_of_values<std::uint8_t>({3, 1, 1}, {0, 1, 2});
  ForegroundOptions label;
  label.label = 2;
  foreground(labels, label, nullptr, nullptr, &surface);
  EXPECT_FALSE(surface);
  foreground(labels, at_least(1), nullptr, nullptr, &surface);
  EXPECT_TRUE(surface);
}

TEST(Isosurface, LiesWhereTheSamplesSay) {
  // Along x: whole samples and a whole threshold, a threshold between, floats, ties; the border is half a voxel
  // outside.
  const auto first_and_last = [](const Volume& volume, Threshold threshold, bool invert = false) {
    ForegroundOptions options;
    options.threshold = threshold;
    options.invert = invert;
    std::optional<TriangleMesh> surface;
    foreground(volume, options, nullptr, nullptr, &surface);
    double low = 100, high = -100;
    for (const Vec3& p : surface.value().points) {
      low = std::min(low, p[0] - 0.5);
      high = std::max(high, p[0] - 0.5);
    }
    return std::pair(low, high);
  };
  const auto near = [](std::pair<double, double> found, double low, double high) {
    return std::abs(found.first - low) < 1e-9 && std::abs(found.second - high) < 1e-9;
  };
  const std::vector<double> values{0, 10, 30, 40, 20};
  const auto bytes = volume_of_values<std::uint8_t>({5, 1, 1}, values);
  EXPECT_TRUE(near(first_and_last(bytes, 20.0), 1 + 9.5 / 20, 4.5));
  EXPECT_TRUE(near(first_and_last(bytes, std::int64_t{20}), 1 + 9.5 / 20, 4.5));
  EXPECT_TRUE(near(first_and_last(bytes, 25.0), 1 + 14.5 / 20, 3 + 15.5 / 20));
  EXPECT_TRUE(near(first_and_last(bytes, 24.25), 1 + 14.25 / 20, 3 + 15.75 / 20));
  EXPECT_TRUE(near(first_and_last(bytes, 24.25, true), -0.5, 4.5));
  const auto floats = volume_of_values<float>({5, 1, 1}, values);
  EXPECT_TRUE(near(first_and_last(floats, 25.0), 1.75, 3.75));
  EXPECT_TRUE(near(first_and_last(floats, 30.0), 1.99, 3.5));
  const auto largest = std::numeric_limits<std::int64_t>::max();
  Volume wide = bytes;
  wide.samples = std::vector<std::int64_t>{0, largest - 3, largest - 1, largest, 7};
  EXPECT_TRUE(near(first_and_last(wide, largest - 1), 1.75, 3 + 1.5 / static_cast<double>(largest - 7)) ||
              near(first_and_last(wide, largest - 1), 1.75, 3.01));
}

TEST(Isosurface, IsOutwardInReflectedWorlds) {
  Grid grid;
  grid.dims = {5, 4, 3};
  grid.spacing = {1, 2, 0.5};
  grid.origin = {7, -3, 2};
  grid.direction = Vec3(1, -1, 1).asDiagonal();
  const VoxelShape box = testing_shapes::from_predicate(grid, [](int x, int, int) { return x > 1; });
  TriangleMesh surface = midpoint_surface(box);
  const double lattice = volume_of(surface);
  to_world(surface, grid);
  EXPECT_GT(lattice, 0);
  EXPECT_NEAR(volume_of(surface), lattice, 1e-9);  // voxels of volume 1
}

// Samples of a signed distance, blurred to a slope of one per `width` voxels.
Volume blurred(const std::array<std::int64_t, 3>& dims, double width, double noise, unsigned seed,
               const std::function<double(const Vec3&)>& inside) {
  std::mt19937 random(seed);
  std::vector<double> values;
  for (std::int64_t z = 0; z < dims[2]; ++z)
    for (std::int64_t y = 0; y < dims[1]; ++y)
      for (std::int64_t x = 0; x < dims[0]; ++x) {
        // The sum of twelve uniform numbers: near to normal, the same everywhere.
        double normal = -6;
        for (int i = 0; i < 12; ++i) normal += static_cast<double>(random()) * 0x1p-32;
        const Vec3 p(static_cast<double>(x), static_cast<double>(y), static_cast<double>(z));
        values.push_back(0.5 + 0.5 * std::erf(inside(p) * std::sqrt(M_PI) / width) + noise * normal);
      }
  return volume_of_values<float>(dims, values);
}

TriangleMesh largest_surface(const Volume& volume) {
  ForegroundOptions options = at_least(0.5);
  options.largest_component = options.fill_cavities = true;
  std::optional<TriangleMesh> surface;
  foreground(volume, options, nullptr, nullptr, &surface);
  return surface.value();
}

TEST(Isosurface, IsNearToTheTrueSurface) {
  // Interpolation lies inside of what is curved: an eighth of the curvature at most, along each axis.
  const Vec3 centre(15.3, 15.6, 15.45);
  for (const double radius : {3.0, 6.0, 12.0}) {
    const auto inside = [=](const Vec3& p) { return radius - (p - centre).norm(); };
    const TriangleMesh surface = largest_surface(blurred({32, 32, 32}, 2, 0, 1, inside));
    for (const Vec3& p : surface.points) {
      const double error = inside(p - Vec3::Constant(0.5));
      EXPECT_GT(error, -0.03);
      EXPECT_LT(error, 0.03 + 0.375 / radius);
    }
  }
}

TEST(SurfaceSmoothing, BallsInTubesAreRight) {
  for (const double radius : {3.0, 5.0})
    for (const double noise : {0.0, 0.05}) {
      const Vec3 direction = Vec3(0.2, 0.1, 1).normalized(), middle(9.3, 9.6, 25.1);
      const auto inside = [&](const Vec3& p) { return radius - direction.cross(p - middle).norm(); };
      TriangleMesh surface = largest_surface(blurred({20, 20, 50}, 2, noise, 5, inside));
      smooth_surface(surface);
      ASSERT_TRUE(is_closed_manifold(surface));
      double sum = 0;
      int places = 0;
      for (double s = -10; s <= 10; s += 2) {
        // The largest ball near the axis.
        const Vec3 axis = middle + Vec3::Constant(0.5) + s * direction;
        const Vec3 u = direction.unitOrthogonal(), v = direction.cross(u);
        double largest = 0;
        for (int i = -3; i <= 3; ++i)
          for (int j = -3; j <= 3; ++j)
            largest = std::max(largest, distance_to(surface, axis + 0.02 * i * u + 0.02 * j * v));
        sum += largest - radius;
        ++places;
      }
      EXPECT_NEAR(sum / places, 0, noise > 0 ? 0.1 : 0.05) << "radius " << radius << " noise " << noise;
    }
}

TEST(SurfaceSmoothing, TakesTheStepsOfAMaskAway) {
  Grid grid;
  grid.dims = {20, 20, 20};
  const Vec3 centre(9.4, 9.6, 9.55);
  const auto inside = [&](const Vec3& p) { return 6 - (p - centre).norm(); };
  const VoxelShape ball =
      testing_shapes::from_predicate(grid, [&](int x, int y, int z) { return inside(Vec3(x, y, z)) >= 0; });
  const auto error = [&](const TriangleMesh& mesh) {
    double sum = 0, squares = 0;
    for (const Vec3& p : mesh.points) {
      const double e = -inside(p - Vec3::Constant(0.5));
      sum += e;
      squares += e * e;
    }
    const auto n = static_cast<double>(mesh.points.size());
    return std::pair(sum / n, std::sqrt(squares / n));
  };
  TriangleMesh surface = midpoint_surface(ball);
  EXPECT_GT(error(surface).second, 0.15);
  smooth_surface(surface, kStepSmoothing);
  expect_topology_of(surface, ball, "ball");
  EXPECT_NEAR(error(surface).first, 0, 0.1);
  EXPECT_LT(error(surface).second, 0.1);
  EXPECT_NEAR(std::cbrt(volume_of(surface) * 3 / 4 / M_PI), 6, 0.1);
}

TEST(SurfaceSmoothing, LeavesFlatWallsFlatAndStaysWithinReach) {
  const VoxelShape box = testing_shapes::box_shape(20, 14, 12, 2);
  TriangleMesh surface = midpoint_surface(box);
  smooth_surface(surface, kStepSmoothing);
  expect_topology_of(surface, box, "box");
  int in_the_wall = 0;
  for (const Vec3& p : surface.points) {
    if (p[0] < 8 || p[0] > 16 || p[1] < 7 || p[1] > 11 || p[2] > 8) continue;
    EXPECT_NEAR(p[2], 2, 0.08);
    ++in_the_wall;
  }
  EXPECT_GT(in_the_wall, 20);
  for (unsigned seed = 0; seed < 200; ++seed) {
    const VoxelShape shape = testing_shapes::random_shape(seed);
    const TriangleMesh start = midpoint_surface(shape);
    TriangleMesh smooth = start;
    smooth_surface(smooth, {3, 0.4});
    expect_topology_of(smooth, shape, "seed " + std::to_string(seed));
    if (smooth.points.size() != start.points.size()) continue;  // some were not needed
    for (std::size_t v = 0; v < start.points.size(); ++v)
      EXPECT_LE((smooth.points[v] - start.points[v]).cwiseAbs().maxCoeff(), 0.4 + 1e-9);
  }
}

TEST(SurfaceSmoothing, KeepsEveryVoxelCentreOnItsSide) {
  for (unsigned seed = 0; seed < 60; ++seed) {
    const VoxelShape shape = testing_shapes::random_shape(seed, 8);
    TriangleMesh surface = midpoint_surface(shape);
    smooth_surface(surface, kStepSmoothing);
    const auto& dims = shape.grid().dims;
    for (std::int64_t z = 0; z < dims[2]; ++z)
      for (std::int64_t y = 0; y < dims[1]; ++y)
        for (std::int64_t x = 0; x < dims[0]; ++x) {
          const Vec3 centre(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5, static_cast<double>(z) + 0.5);
          ASSERT_NEAR(winding_number(surface, centre), shape.contains(x, y, z) ? 1 : 0, 1e-6) << "seed " << seed;
        }
  }
}

TEST(SurfaceSmoothing, IsTheSameForAnyNumberOfThreads) {
  const VoxelShape shape = testing_shapes::random_shape(3, 40);
  Context one, four;
  one.threads = 1;
  four.threads = 4;
  TriangleMesh a = midpoint_surface(shape, &one), b = midpoint_surface(shape, &four);
  smooth_surface(a, kStepSmoothing, &one);
  smooth_surface(b, kStepSmoothing, &four);
  EXPECT_TRUE(same(a, b));
}

}  // namespace isosurface_test
}  // namespace quench
