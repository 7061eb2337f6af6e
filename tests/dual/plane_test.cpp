// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "axis/mgf.h"
#include "brute_force_plane.h"
#include "dual/plane/dual_of_plane.h"
#include "plane_shapes.h"
#include "quench/axis.h"
#include "same_dual.h"

namespace quench::dual::plane {
namespace plane_test {

using brute_force::PlaneCore;
using brute_force::PlaneOracle;
using testing_planes::plane_grid;
using testing_planes::plane_picture;
using testing_planes::plane_shape;
using testing_planes::random_plane_shape;

std::string text(const VoxelShape& shape) {
  std::string rows;
  for (int y = 0; y < shape.grid().dims[1]; ++y) {
    for (int x = 0; x < shape.grid().dims[0]; ++x) rows += shape.contains(x, y, 0) ? '#' : '.';
    rows += '\n';
  }
  return rows;
}

DualComplex dual_of(const VoxelShape& shape) {
  return dual_complex(shape, brute_force::sites_of_plane(shape), integer_spacing(shape.grid()), nullptr);
}

void expect_same_as_oracle(const VoxelShape& shape, std::array<std::int64_t, 2> scale, const std::string& where) {
  PlaneOracle oracle(shape, scale);
  const PlaneCore& expected = oracle.run();
  const DualComplex dual = dual_of(shape);
  std::vector<std::uint32_t> offsets{0}, sites;
  for (const auto& vertex : expected.vertices) {
    sites.insert(sites.end(), vertex.sites.begin(), vertex.sites.end());
    offsets.push_back(static_cast<std::uint32_t>(sites.size()));
  }
  std::vector<std::array<std::uint32_t, 2>> edges, pairs;
  std::vector<double> mgf;
  for (const auto& edge : expected.edges) {
    edges.push_back(edge.ends), pairs.push_back(edge.sites);
    mgf.push_back(edge.mgf);
  }
  const std::string what = where + "\n" + text(shape);
  ASSERT_EQ(dual.complex.vertex_count, expected.vertices.size()) << what;
  ASSERT_EQ(dual.vertex_site_offsets, offsets) << what;
  ASSERT_EQ(dual.vertex_sites, sites) << what;
  ASSERT_EQ(dual.complex.edges, edges) << what;
  ASSERT_EQ(dual.edge_sites, pairs) << what;
  ASSERT_TRUE(dual.complex.face_count() == 0 && dual.face_sites.empty()) << what;
  // Sides and diagonals of polygons too.
  for (const auto& vertex : expected.vertices)
    for (const std::uint32_t a : vertex.sites)
      for (const std::uint32_t b : vertex.sites)
        if (a < b) {
          pairs.push_back({a, b});
          mgf.push_back(oracle.mgf(a, b));
        }
  ASSERT_EQ(axis::mgf_of_edges(shape, expected.sites, pairs), mgf) << what;
}

void expect_random_as_oracle(std::uint64_t first, std::uint64_t last, int largest,
                             std::array<std::int64_t, 2> scale = {1, 1}) {
  for (std::uint64_t seed = first; seed < last && !testing::Test::HasFatalFailure(); ++seed)
    expect_same_as_oracle(
        random_plane_shape(seed, largest, {static_cast<double>(scale[0]), static_cast<double>(scale[1])}), scale,
        "seed " + std::to_string(seed));
}

TEST(Plane, RandomShapesAreThoseOfTheOracle) {
  expect_random_as_oracle(0, 20000, 6);
  expect_random_as_oracle(20000, 21000, 9);
}

const std::array<std::int64_t, 2> kScales[] = {{1, 2}, {2, 1}, {3, 2}, {1, 5}, {391, 2500}, {2500, 391}, {1, 1000}};

TEST(Plane, AnisotropicShapesAreThoseOfTheOracle) {
  std::uint64_t seed = 100000;
  for (const auto& scale : kScales) {
    expect_random_as_oracle(seed, seed + 1000, 6, scale);
    expect_random_as_oracle(seed, seed + 50, 9, scale);
    seed += 1000;
  }
}

// Parts at the ends of the largest grids, whose triangulation has the largest differences of coordinates.
TEST(Plane, FarAndSkewShapesAreThoseOfTheOracle) {
  constexpr std::int32_t kEnd = 1 << 20;
  for (const std::int64_t step : {1, 1 << 17}) {
    VoxelShape shape(plane_grid(kEnd, 4, {1, static_cast<double>(step)}));
    for (int y = 0; y < 4; ++y)
      shape.append_row(std::vector<quench::Run>{{0, 2}, {70000 + y, 70002 + y}, {kEnd - 1, kEnd}});
    expect_same_as_oracle(shape, {1, step}, "step " + std::to_string(step));
  }
}

// Components of pixels that are foreground or background, which touch along edges or also in corners.
std::int64_t components(const VoxelShape& shape, bool foreground, bool corners) {
  const std::int64_t width = shape.grid().dims[0] + 2, height = shape.grid().dims[1] + 2;
  std::vector<char> seen(static_cast<std::size_t>(width * height), 0);
  std::int64_t count = 0;
  std::vector<std::array<std::int64_t, 2>> open;
  const auto reach = [&](std::int64_t x, std::int64_t y) {
    if (x < 0 || y < 0 || x >= width || y >= height || shape.contains(x - 1, y - 1, 0) != foreground) return false;
    char& mark = seen[static_cast<std::size_t>(x + width * y)];
    if (mark) return false;
    mark = 1;
    open.push_back({x, y});
    return true;
  };
  for (std::int64_t y = 0; y < height; ++y)
    for (std::int64_t x = 0; x < width; ++x)
      for (count += reach(x, y); !open.empty();) {
        const auto [px, py] = open.back();
        open.pop_back();
        for (int i = 0; i < 9; ++i)
          if (corners || i % 2 == 1) reach(px + i % 3 - 1, py + i / 3 - 1);
      }
  return count;
}

using Point = std::array<double, 2>;
double squared(const Point& a, const Point& b) { return (a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]); }

// What needs no oracle, so that shapes may be larger: every circle carries its sites and holds none, its centre is in
// O; components and holes are those of the pixels.
void expect_core(const VoxelShape& shape, const std::string& where) {
  const auto sites = brute_force::sites_of_plane(shape);
  const auto spacing = integer_spacing(shape.grid());
  const DualComplex dual = dual_of(shape);
  dual.complex.validate();
  const PlaneOracle oracle(shape, {spacing[0], spacing[1]});
  for (std::uint32_t v = 0; v < dual.complex.vertex_count; ++v) {
    const auto ids = dual.sites_of(v);
    ASSERT_TRUE(std::ranges::is_sorted(ids)) << where;
    const auto circle = oracle.circle(ids[0], ids[1], ids[2]);
    ASSERT_TRUE(circle) << where;
    std::size_t on_circle = 0;
    for (std::uint32_t s = 0; s < sites.size(); ++s) {
      const auto side = oracle.side(*circle, s);
      ASSERT_GE(side, 0) << where << ": site " << s << " is in the circle of vertex " << v;
      on_circle += side == 0;
    }
    ASSERT_EQ(on_circle, ids.size()) << where << ": vertex " << v;
    ASSERT_TRUE(oracle.inside(oracle.centre(*circle))) << where << ": vertex " << v;
  }
  const Topology topology = quench::topology(dual.complex);
  EXPECT_EQ(topology.betti[0], components(shape, true, false)) << where;
  EXPECT_EQ(topology.betti[1], components(shape, false, true) - 1) << where;
  EXPECT_EQ(topology.betti[2], 0) << where;
  EXPECT_EQ(dual.edge_sites.size(), dual.complex.edges.size()) << where;
}

TEST(Plane, CoresOfRandomShapes) {
  for (std::uint64_t seed = 0; seed < 400 && !HasFatalFailure(); ++seed)
    expect_core(random_plane_shape(seed, 40), "seed " + std::to_string(seed));
  for (std::uint64_t seed = 0; seed < 140 && !HasFatalFailure(); ++seed) {
    const auto& scale = kScales[seed % std::size(kScales)];
    expect_core(random_plane_shape(seed, 30, {static_cast<double>(scale[0]), static_cast<double>(scale[1])}),
                "scaled seed " + std::to_string(seed));
  }
}

VoxelShape ring(int size, double inner, double outer) {
  return plane_shape(plane_grid(size, size), [=](int x, int y) {
    const double d = squared({x + 0.5, y + 0.5}, {0.5 * size, 0.5 * size});
    return d < outer * outer && d >= inner * inner;
  });
}

TEST(Plane, CoresOfKnownShapes) {
  expect_core(ring(64, 0, 31), "disc");
  expect_core(ring(64, 20, 31), "ring");
  expect_core(ring(64, 29.5, 31), "thin ring");
  expect_core(plane_shape(plane_grid(40, 40), [](int, int) { return true; }), "square");
  expect_core(plane_shape(plane_grid(60, 7), [](int, int) { return true; }), "rectangle");
  expect_core(plane_shape(plane_grid(20, 20), [](int x, int y) { return (x + y) % 2 == 0; }), "checkerboard");
  expect_core(plane_shape(plane_grid(24, 24), [](int x, int y) { return (x / 3 + y / 3) % 2 == 0; }), "squares");
  expect_core(plane_shape(plane_grid(30, 30), [](int x, int y) { return x == 5 || y % 9 == 3; }), "lines");
  expect_core(plane_shape(plane_grid(31, 31),
                          [](int x, int y) { return std::max(std::abs(x - 15), std::abs(y - 15)) % 4 < 2; }),
              "islands in holes");
}

TEST(Plane, OnePixel) {
  const DualComplex dual = dual_of(plane_picture({"#"}));
  EXPECT_EQ(dual.complex.vertex_count, 1u);
  EXPECT_EQ(dual.vertex_sites, (std::vector<std::uint32_t>{0, 1, 2, 3}));
  EXPECT_TRUE(dual.complex.edges.empty());
}

TEST(Plane, PixelsThatTouchInACornerAreApart) {
  const DualComplex dual = dual_of(plane_picture({"#.", ".#"}));
  EXPECT_EQ(dual.complex.vertex_count, 2u);
  EXPECT_TRUE(dual.complex.edges.empty());
}

// The boundary distance along a line of pixels, and from one side of a ring to the other.
TEST(Plane, BoundaryDistances) {
  const VoxelShape line = plane_picture({"#####"});
  const DualComplex dual = dual_of(line);
  ASSERT_EQ(dual.complex.edges.size(), 4u);
  EXPECT_EQ(axis::mgf_of_edges(line, brute_force::sites_of_plane(line), dual.edge_sites),
            (std::vector<double>{3, 5, 5, 3}));
  const VoxelShape thin = ring(64, 29.5, 31);
  const DualComplex around = dual_of(thin);
  std::size_t infinite = 0;
  for (const double distance : axis::mgf_of_edges(thin, brute_force::sites_of_plane(thin), around.edge_sites))
    infinite += std::isinf(distance);
  EXPECT_GT(infinite, 100u);
}

// The boundary of O as segments, and places of the core, in units of the integer spacing.
class Proximity {
 public:
  explicit Proximity(const VoxelShape& shape) : shape_(shape), spacing_(integer_spacing(shape.grid())) {
    for (std::int32_t y = 0; y <= shape.grid().dims[1]; ++y)
      for (std::int32_t x = 0; x <= shape.grid().dims[0]; ++x) {
        const bool here = shape.contains(x, y, 0);
        if (here != shape.contains(x, y - 1, 0)) edges_.push_back({scaled(x, y), scaled(x + 1, y)});
        if (here != shape.contains(x - 1, y, 0)) edges_.push_back({scaled(x, y), scaled(x, y + 1)});
      }
  }

  /// The bound of docs/algorithms/voxel_core.md.
  double beta() const {
    const auto [low, high] = std::minmax({static_cast<double>(spacing_[0]), static_cast<double>(spacing_[1])});
    return high * high / (8 * low);
  }

  /// Vertices of the core and middles of its edges.
  std::vector<Point> places() const {
    const PlaneOracle oracle(shape_, {spacing_[0], spacing_[1]});
    const DualComplex dual = dual_of(shape_);
    std::vector<Point> points;
    for (std::uint32_t v = 0; v < dual.complex.vertex_count; ++v) {
      const auto ids = dual.sites_of(v);
      const auto p = oracle.centre(*oracle.circle(ids[0], ids[1], ids[2]));
      const auto d = static_cast<double>(p.denominator);
      points.push_back({static_cast<double>(p.x) / d * static_cast<double>(spacing_[0]),
                        static_cast<double>(p.y) / d * static_cast<double>(spacing_[1])});
    }
    for (const auto& [u, v] : dual.complex.edges)
      points.push_back({(points[u][0] + points[v][0]) / 2, (points[u][1] + points[v][1]) / 2});
    return points;
  }

  /// Whether a point of the medial axis of O lies between x and what is `distance` farther from its nearest boundary
  /// point p: x has two of them, or the farther place has another one.
  bool holds(const Point& x, double distance) const {
    double nearest = std::numeric_limits<double>::infinity();
    Point p{};
    for (const auto& edge : edges_)
      if (const Point q = nearest_on(edge, x); std::sqrt(squared(q, x)) < nearest)
        nearest = std::sqrt(squared(q, x)), p = q;
    const Point y{x[0] + distance * (x[0] - p[0]) / nearest, x[1] + distance * (x[1] - p[1]) / nearest};
    const auto other = [&](const Point& from, double reach) {
      return std::ranges::any_of(edges_, [&](const Edge& edge) {
        const Point q = nearest_on(edge, from);
        return squared(q, p) > 1e-12 && std::sqrt(squared(q, from)) <= reach * (1 + 1e-9);
      });
    };
    return other(x, nearest) || other(y, nearest + distance);
  }

 private:
  using Edge = std::array<Point, 2>;
  Point scaled(std::int64_t x, std::int64_t y) const {
    return {static_cast<double>(x * spacing_[0]), static_cast<double>(y * spacing_[1])};
  }
  static Point nearest_on(const Edge& edge, const Point& x) {
    return {std::clamp(x[0], edge[0][0], edge[1][0]), std::clamp(x[1], edge[0][1], edge[1][1])};
  }

  const VoxelShape& shape_;
  const std::array<std::int64_t, 3> spacing_;
  std::vector<Edge> edges_;
};

void expect_proximity(const VoxelShape& shape, const std::string& where) {
  const Proximity proximity(shape);
  for (const Point& x : proximity.places())
    ASSERT_TRUE(proximity.holds(x, proximity.beta())) << where << "\n" << text(shape) << x[0] << ", " << x[1];
}

TEST(Plane, CoresAreNearTheMedialAxis) {
  for (std::uint64_t seed = 0; seed < 1000 && !HasFatalFailure(); ++seed)
    expect_proximity(random_plane_shape(seed, 12), "seed " + std::to_string(seed));
  for (std::uint64_t seed = 0; seed < 700 && !HasFatalFailure(); ++seed) {
    const auto& scale = kScales[seed % std::size(kScales)];
    expect_proximity(random_plane_shape(seed, 12, {static_cast<double>(scale[0]), static_cast<double>(scale[1])}),
                     "scaled seed " + std::to_string(seed));
  }
  // The bound is attained over the middle of the edge opposite to two corners.
  const VoxelShape corners = plane_picture({"###", ".#."});
  const Proximity proximity(corners);
  EXPECT_TRUE(std::ranges::any_of(proximity.places(),
                                  [&](const Point& x) { return !proximity.holds(x, 0.999 * proximity.beta()); }));
}

// Vertices as sorted site lists and edges as pairs of these, sites by their coordinates.
using Places = std::vector<LatticePoint>;
struct Geometry {
  std::map<Places, std::set<Places>> neighbours;
  std::map<Places, double> mgf;  // per pair of sites
  friend bool operator==(const Geometry&, const Geometry&) = default;
};
template <class Map>
Geometry geometry(const VoxelShape& shape, const Map& map) {
  const auto sites = brute_force::sites_of_plane(shape);
  const DualComplex dual = dual_of(shape);
  const auto places = [&](auto&& ids) {
    Places result;
    for (const std::uint32_t s : ids) result.push_back(map(sites[s]));
    std::ranges::sort(result);
    return result;
  };
  Geometry g;
  for (std::uint32_t v = 0; v < dual.complex.vertex_count; ++v) g.neighbours[places(dual.sites_of(v))];
  const auto mgf = axis::mgf_of_edges(shape, sites, dual.edge_sites);
  for (std::size_t e = 0; e < mgf.size(); ++e) {
    const auto& [u, v] = dual.complex.edges[e];
    g.neighbours[places(dual.sites_of(u))].insert(places(dual.sites_of(v)));
    g.neighbours[places(dual.sites_of(v))].insert(places(dual.sites_of(u)));
    g.mgf[places(dual.edge_sites[e])] = mgf[e];
  }
  return g;
}

TEST(Plane, SymmetriesTranslationAndPadding) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const VoxelShape shape = random_plane_shape(seed, 20);
    const auto [width, height, depth] = shape.grid().dims;
    const Geometry expected = geometry(shape, [](const LatticePoint& p) { return p; });
    for (int symmetry = 0; symmetry < 8; ++symmetry) {
      // From the new coordinates to the old ones, of pixels (`size` is one less) and of lattice points.
      const auto old = [&, w = static_cast<int>(width), h = static_cast<int>(height)](int x, int y, int less) {
        if (symmetry & 4) std::swap(x, y);
        return LatticePoint{symmetry & 1 ? w - less - x : x, symmetry & 2 ? h - less - y : y, 0};
      };
      const VoxelShape turned =
          plane_shape(symmetry & 4 ? plane_grid(height, width) : plane_grid(width, height), [&](int x, int y) {
            const LatticePoint p = old(x, y, 1);
            return shape.contains(p[0], p[1], 0);
          });
      EXPECT_EQ(geometry(turned, [&](const LatticePoint& p) { return old(p[0], p[1], 0); }), expected)
          << "seed " << seed << ", symmetry " << symmetry;
    }
    const VoxelShape moved =
        plane_shape(plane_grid(width + 9, height + 4), [&](int x, int y) { return shape.contains(x - 6, y - 1, 0); });
    testing_duals::expect_same(dual_of(moved), dual_of(shape), "moved seed " + std::to_string(seed));
  }
}

TEST(Plane, ThreadsMakeNoDifference) {
  const VoxelShape shape = plane_shape(plane_grid(700, 700), [](int x, int y) {
    return std::sin(0.3 * x + 0.0004 * x * y) + std::sin(0.25 * y - 0.0003 * x * x) > 0.2;
  });
  const tbb::global_control more(tbb::global_control::max_allowed_parallelism, 5);
  const auto with_threads = [&](int threads) {
    return tbb::task_arena(threads).execute([&] { return dual_of(shape); });
  };
  const DualComplex expected = with_threads(1);
  ASSERT_GT(expected.complex.vertex_count, 40000u);
  for (const int threads : {2, 5}) testing_duals::expect_same(with_threads(threads), expected, "threads");
}

TEST(Plane, StopsWhenAsked) {
  const VoxelShape shape = ring(64, 0, 31);
  Context context;
  context.cancel();
  EXPECT_THROW(dual_complex(shape, brute_force::sites_of_plane(shape), integer_spacing(shape.grid()), &context), Error);
}

}  // namespace plane_test
}  // namespace quench::dual::plane
