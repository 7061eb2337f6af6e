// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "full_run.h"
#include "polygons/ring_nesting.h"
#include "quench/polygons.h"

using namespace quench;

namespace digitize_test {

using Ring = std::vector<Vec2>;

/// A sum without error as doubles that do not overlap (Shewchuk 1997); nothing may underflow.
class Expansion {
 public:
  void add(double x) {
    std::vector<double> grown;
    for (const double part : parts_) {
      const double sum = x + part, back = sum - x;
      if (const double error = (x - (sum - back)) + (part - back); error != 0) grown.push_back(error);
      x = sum;
    }
    if (x != 0) grown.push_back(x);
    parts_ = grown;
  }
  void add_product(double a, double b) {
    add(a * b);
    add(std::fma(a, b, -(a * b)));
  }
  int sign() const { return parts_.empty() ? 0 : parts_.back() > 0 ? 1 : -1; }

 private:
  std::vector<double> parts_;
};

struct Centre {
  Vec2 origin;
  double pixel;
  int i, j;
};

bool at_or_below(double y, const Centre& c) {
  Expansion e;
  e.add(c.origin[1]);
  e.add_product(c.j, c.pixel);
  e.add(-y);
  return e.sign() >= 0;
}

/// Whether the edge from low to high is at the left of the centre, or through it.
bool at_left(const Vec2& low, const Vec2& high, const Centre& c) {
  const double xs[] = {low[0], -c.origin[0], -(c.i * c.pixel), -std::fma(c.i, c.pixel, -(c.i * c.pixel))};
  const double ys[] = {-low[1], c.origin[1], c.j * c.pixel, std::fma(c.j, c.pixel, -(c.j * c.pixel))};
  Expansion e;
  for (const double x : xs)
    for (const double y : {high[1], -low[1]}) e.add_product(x, y);
  for (const double y : ys)
    for (const double x : {high[0], -low[0]}) e.add_product(y, x);
  return e.sign() <= 0;
}

bool inside(const Polygons& polygons, PolygonFill fill, const Centre& c) {
  int winding = 0;
  for (const Ring& ring : polygons.rings)
    for (std::size_t k = 0; k < ring.size(); ++k) {
      const Vec2 &a = ring[k], &b = ring[(k + 1) % ring.size()];
      if (at_or_below(a[1], c) == at_or_below(b[1], c)) continue;
      const bool up = at_or_below(a[1], c);
      if (up ? at_left(a, b, c) : at_left(b, a, c)) winding += up ? 1 : -1;
    }
  return fill == PolygonFill::evenodd ? winding % 2 != 0 : winding != 0;
}

std::int64_t expect_exact(const Polygons& polygons, const DigitizeOptions& options, const std::string& what) {
  VoxelShape shape;
  try {
    shape = digitize(polygons, options);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::input) << error.what();
    return 0;
  }
  shape.validate();
  const Grid& grid = shape.grid();
  EXPECT_TRUE(grid.is_plane());
  std::int64_t wrong = 0;
  for (int j = -1; j <= grid.dims[1]; ++j)
    for (int i = -1; i <= grid.dims[0]; ++i) {
      const Centre centre{grid.origin.head<2>(), grid.spacing[0], i, j};
      wrong += inside(polygons, options.fill, centre) != shape.contains(i, j, 0);
    }
  EXPECT_EQ(wrong, 0) << what;
  return shape.voxel_count();
}

Ring square(double x, double y, double side) { return {{x, y}, {x + side, y}, {x + side, y + side}, {x, y + side}}; }

void expect_refused(const Polygons& polygons, const DigitizeOptions& options, ErrorCode code, const char* word) {
  try {
    digitize(polygons, options);
    FAIL() << word;
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
  }
}

TEST(Digitize, RandomRingsAgreeWithTheCrossingsOfEveryCentre) {
  std::mt19937 random(7);
  std::int64_t pixels = 0;
  const int rounds = repeats(1500, 600);
  for (int round = 0; round < rounds; ++round) {
    const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
    // Few different coordinates: many edges are collinear, horizontal or vertical, and go through centres.
    const int steps = std::vector{3, 6, 12, 1000, 1 << 30}[static_cast<std::size_t>(below(5))];
    const double scale = std::vector{1.0, 0.5, 0.1, 1e-12, 3e17}[static_cast<std::size_t>(below(5))];
    const double offset = std::vector{0.0, 0.0, 1e9, -12345.678, 0.1}[static_cast<std::size_t>(below(5))];
    Polygons polygons;
    for (int rings = 1 + below(3); rings-- > 0;) {
      Ring ring;
      for (int points = 3 + below(9); points-- > 0;)
        ring.emplace_back(offset * scale + below(steps) * scale, -offset * scale + below(steps) * scale);
      polygons.rings.push_back(ring);
    }
    DigitizeOptions options;
    options.fill = below(2) ? PolygonFill::evenodd : PolygonFill::nonzero;
    if (below(2))
      options.resolution = 1 + below(20);
    else
      options.pixel = scale * std::max(1, steps / 12) * std::vector{0.5, 1.0, 2.0}[static_cast<std::size_t>(below(3))];
    pixels += expect_exact(polygons, options, "round " + std::to_string(round));
  }
  EXPECT_GT(pixels, 20000 * rounds / 1500);
}

TEST(Digitize, EdgesNearlyThroughCentres) {
  // Points a few ulps beside the line through many centres.
  std::mt19937 random(8);
  for (int round = 0; round < 300; ++round) {
    const auto moved = [&](double x) {
      for (auto n = random() % 3; n-- > 0;) x = std::nextafter(x, random() % 2 ? 1e9 : -1e9);
      return x;
    };
    const double h = 1.0 / 7, far = round % 2 ? 1e6 : 0;
    Polygons polygons{
        {{{far, far}, {moved(far + 12 * h), moved(far + 12 * h)}, {moved(far + h / 2), moved(far + 12 * h + h / 2)}},
         {{moved(far + h / 2), moved(far + h / 2)},
          {moved(far + 6.5 * h), moved(far + 0.5 * h)},
          {moved(far + 9.5 * h), moved(far + 9.5 * h)}}}};
    expect_exact(polygons, {.resolution = {}, .pixel = h}, "round " + std::to_string(round));
  }
}

TEST(Digitize, NearlyHorizontalEdges) {
  for (const double rise : {1e-13, 1e-9, 5e-324, 1e-300, 1e-7}) {
    const Polygons polygons{{{{0, 0}, {1000, 2}, {1000, 2 + 4.5}, {1e-3, 4.5 + rise}, {0, 4.5}}}};
    const VoxelShape shape = digitize(polygons, {.resolution = {}, .pixel = 1.0});
    EXPECT_EQ(shape.row(4, 0).size(), 1u) << rise;
    EXPECT_EQ(shape.grid().dims[0], 1000);
  }
}

TEST(Digitize, DenormalCoordinatesCount) {
  // The row of centres at y = 0 is inside when the lower edge is at 0 or below, and not when it is the least above.
  const double least = std::numeric_limits<double>::denorm_min();
  for (const double y : {-least, 0.0, least}) {
    const Polygons polygons{{{{-0.5, -0.5}, {0, -0.5}, {0, y}, {4.5, y}, {4.5, 3}, {-0.5, 3}}}};
    const VoxelShape shape = digitize(polygons, {.resolution = {}, .pixel = 1.0});
    EXPECT_EQ(shape.contains(3, 0, 0), y <= 0) << y;
    EXPECT_TRUE(shape.contains(3, 1, 0));
  }
  for (const double x : {-least, 0.0, least}) {
    const Polygons polygons{{{{-0.5, -0.5}, {3, -0.5}, {3, 3}, {x, 3}, {x, 0.5}, {-0.5, 0.5}}}};
    EXPECT_EQ(digitize(polygons, {.resolution = {}, .pixel = 1.0}).contains(0, 2, 0), x <= 0) << x;
  }
}

TEST(Digitize, WholeSquaresArePixels) {
  const VoxelShape shape = digitize({{square(10, -3, 5)}}, {.resolution = {}, .pixel = 1.0});
  EXPECT_EQ(shape.voxel_count(), 25);
  EXPECT_EQ(shape.grid().dims, (std::array<std::int64_t, 3>{5, 5, 1}));
  EXPECT_EQ(shape.grid().world(shape.grid().first_centre()), Vec3(10.5, -2.5, 0));
  EXPECT_EQ(shape.grid().world_of({0, 0, 0}), Vec3(10, -3, 0));
  for (const std::int64_t n : {1, 3, 7, 100, 1024, 12345})
    EXPECT_EQ(digitize({{square(0.1, 0.7, 0.3)}}, {.resolution = n, .pixel = {}}).voxel_count(), n * n) << n;
  EXPECT_EQ(digitize({{square(0, 0, 1)}}).grid().dims[0], kDefaultResolution);
}

TEST(Digitize, NeighboursShareNoPixelAndLeaveNoneOut) {
  std::mt19937 random(9);
  for (int round = 0; round < 500; ++round) {
    const auto coordinate = [&] { return static_cast<double>(random() % 17) / 2; };
    // A square cut in four at a point: a frame of thin slivers at the corners keeps all four on one grid.
    const Vec2 middle(coordinate(), coordinate());
    const Vec2 corners[] = {{0, 0}, {8, 0}, {8, 8}, {0, 8}};
    std::int64_t sum = 0;
    for (int k = 0; k < 4; ++k) {
      Polygons part{
          {{corners[k], corners[(k + 1) % 4], middle}, {{0, 0}, {8, 8}, {8, 8}, {0, 0}, {8, 0}, {8, 8}, {8, 0}}}};
      if (middle == corners[k] || middle == corners[(k + 1) % 4]) continue;
      part.rings[1] = {{0, 0}, {8, 0}, {8, 8}, {0, 8}};  // inverted: the rest of the square
      sum += 64 - digitize(part, {.resolution = {}, .pixel = 1.0}).voxel_count();
    }
    EXPECT_EQ(sum, 64);
  }
}

TEST(Digitize, OpenAndClosedRingsAreTheSame) {
  Ring ring = square(0, 0, 4);
  const auto open = digitize({{ring}}, {.resolution = 9, .pixel = {}});
  ring.push_back(ring.front());
  ring.insert(ring.begin() + 1, ring[1]);
  const auto closed = digitize({{ring}}, {.resolution = 9, .pixel = {}});
  EXPECT_TRUE(std::equal(open.runs().begin(), open.runs().end(), closed.runs().begin(), closed.runs().end()));
}

TEST(Digitize, RulesOfFilling) {
  const Ring star{{0, 0}, {8, 6}, {-2, 6}, {6, 0}, {3, 10}};
  EXPECT_LT(digitize({{star}}, {.resolution = 100, .pixel = {}, .fill = PolygonFill::evenodd}).voxel_count(),
            digitize({{star}}, {.resolution = 100, .pixel = {}, .fill = PolygonFill::nonzero}).voxel_count());
  const Polygons overlapping{{square(0, 0, 4), square(2, 2, 4)}};
  EXPECT_EQ(digitize(overlapping, {.resolution = 6, .pixel = {}, .fill = PolygonFill::evenodd}).voxel_count(), 24);
  EXPECT_EQ(digitize(overlapping, {.resolution = 6, .pixel = {}, .fill = PolygonFill::nonzero}).voxel_count(), 28);
}

TEST(Digitize, RefusesInOneSentence) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), huge = std::numeric_limits<double>::infinity();
  expect_refused({{square(0, 0, 1)}}, {.resolution = 0, .pixel = {}}, ErrorCode::usage, "resolution 0");
  expect_refused({{square(0, 0, 1)}}, {.resolution = kMostPixels + 1, .pixel = {}}, ErrorCode::usage, "resolution");
  expect_refused({{square(0, 0, 1)}}, {.resolution = 5, .pixel = 1.0}, ErrorCode::usage, "one of them");
  for (const double pixel : {0.0, -1.0, nan, huge})
    expect_refused({{square(0, 0, 1)}}, {.resolution = {}, .pixel = pixel}, ErrorCode::usage, "positive");
  expect_refused({}, {}, ErrorCode::input, "empty");
  expect_refused({{{}}}, {}, ErrorCode::input, "0 points");
  expect_refused({{{{0, 0}, {1, 1}, {0, 0}, {1, 1}}}}, {}, ErrorCode::input, "less than three differ");
  expect_refused({{{{0, 0}, {1, nan}, {0, 1}}}}, {}, ErrorCode::input, "not finite");
  expect_refused({{{{0, 0}, {1, huge}, {0, 1}}}}, {}, ErrorCode::input, "not finite");
  expect_refused({{{{-1.7e308, 0}, {1.7e308, 0}, {0, 1}}}}, {}, ErrorCode::input, "beyond");
  expect_refused({{square(0, 0, 1e-40)}}, {}, ErrorCode::input, "beyond");
  expect_refused({{square(1e15, 0, 1)}}, {}, ErrorCode::input, "move it nearer");
  expect_refused({{square(0, 0, 1)}}, {.resolution = {}, .pixel = 1e-9}, ErrorCode::input, "give larger ones");
  expect_refused({{{{0, 0}, {1, 1}, {2, 2}}}}, {}, ErrorCode::input, "encloses nothing");
  expect_refused({{{{0, 0}, {100, 0.013}, {100, 0.014}, {0, 0.001}}}}, {.resolution = 100, .pixel = {}},
                 ErrorCode::input, "at resolution");
}

TEST(Digitize, TheAdviceForThinPolygonsHelps) {
  std::mt19937 random(10);
  int advised = 0;
  for (int round = 0; round < 200; ++round) {
    const double slope = static_cast<double>(random() % 1000) / 1000,
                 thin = 1e-4 * static_cast<double>(1 + random() % 50);
    const Polygons sliver{{{{0, 0}, {1, slope}, {1, slope + thin}, {0, thin}}}};
    try {
      digitize(sliver, {.resolution = 10, .pixel = {}});
    } catch (const Error& error) {
      const std::string text = error.what();
      const auto at = text.find("at resolution ");
      if (at == std::string::npos) continue;
      ++advised;
      EXPECT_FALSE(digitize(sliver, {.resolution = std::stoll(text.substr(at + 14)), .pixel = {}}).empty()) << text;
    }
  }
  EXPECT_GT(advised, 20);
}

TEST(Digitize, ManyPointsAndCancel) {
  Ring ring;
  constexpr int n = 1000000;
  for (int k = 0; k < n; ++k) {
    const double angle = 2 * 3.14159265358979 * k / n, r = 1 + 1e-3 * (k % 2);
    ring.emplace_back(r * std::cos(angle), r * std::sin(angle));
  }
  const double area = static_cast<double>(digitize({{ring}}, {.resolution = 4096, .pixel = {}}).voxel_count()) *
                      std::pow(2.002 / 4096, 2);
  EXPECT_NEAR(area, 3.1447, 1e-2);
  Context context;
  context.cancel();
  EXPECT_THROW(digitize({{ring}}, {}, &context), Error);
  Context small;
  small.memory_limit = 1000;
  Ring comb;
  for (int k = 0; k < 20000; ++k) comb.emplace_back(k, k % 2 * 20000);
  try {
    digitize({{comb}}, {.resolution = 20000, .pixel = {}}, &small);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::failed);
  }
}

TEST(Digitize, NotesOtherTopology) {
  std::vector<std::string> notes;
  Context context;
  context.note = [&](const std::string& sentence) { notes.push_back(sentence); };
  const Ring dumbbell{{0, 0},  {4, 0}, {4, 1.7}, {6, 1.7}, {6, 0}, {10, 0},
                      {10, 4}, {6, 4}, {6, 1.9}, {4, 1.9}, {4, 4}, {0, 4}};
  EXPECT_EQ(topology(digitize({{dumbbell}}, {.resolution = 10, .pixel = {}}, &context)).betti[0], 2);
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].find("2 parts"), std::string::npos) << notes[0];
  digitize({{dumbbell}}, {.resolution = 1000, .pixel = {}}, &context);
  EXPECT_EQ(notes.size(), 1u);
}

TEST(RegionTopology, OfNestedRings) {
  const auto of = [](const Polygons& polygons, PolygonFill fill = PolygonFill::evenodd) {
    const auto found = polygons::region_topology(polygons, fill);
    return found ? std::to_string(found->components) + "," + std::to_string(found->holes) : "none";
  };
  EXPECT_EQ(of({{square(0, 0, 10)}}), "1,0");
  EXPECT_EQ(of({{square(0, 0, 10), square(2, 2, 6), square(3, 3, 1), square(5, 5, 2)}}), "3,1");
  EXPECT_EQ(of({{square(0, 0, 10), square(2, 2, 6)}}, PolygonFill::nonzero), "1,0");
  EXPECT_EQ(of({{square(0, 0, 10), {{2, 2}, {2, 8}, {8, 8}, {8, 2}}}}, PolygonFill::nonzero), "1,1");
  EXPECT_EQ(of({{square(0, 0, 4), square(2, 2, 4)}}), "none");
  EXPECT_EQ(of({{square(0, 0, 4), square(4, 0, 4)}}), "none") << "they touch";
  EXPECT_EQ(of({{square(0, 0, 4), square(4, 1, 2)}}), "none") << "a point on an edge";
  EXPECT_EQ(of({{{{0, 0}, {4, 4}, {4, 0}, {0, 4}}}}), "none");
  EXPECT_EQ(of({{{{0, 0}, {4, 0}, {6, 0}, {4, 0}, {4, 4}}}}), "none");
}

TEST(RegionTopology, AgreesWithAllPairsOfEdges) {
  std::mt19937 random(11);
  int simple = 0, none = 0, nested = 0;
  for (int round = 0; round < 5000; ++round) {
    Polygons polygons;
    for (int rings = 1 + static_cast<int>(random() % 4); rings-- > 0;) {
      Ring ring;
      const auto size = std::uint64_t{random() % 2 ? 24u : 4u}, low = random() % (25 - size);
      for (int points = 3 + static_cast<int>(random() % 3); points-- > 0;)
        ring.emplace_back(static_cast<double>(low + random() % size), static_cast<double>(low + random() % size));
      polygons.rings.push_back(ring);
    }
    const PolygonFill fill = random() % 2 ? PolygonFill::evenodd : PolygonFill::nonzero;
    const auto found = polygons::region_topology(polygons, fill);
    // Whether any two edges that are not neighbours of one ring meet, by all pairs in whole numbers.
    struct Edge {
      Vec2 a, b;
      std::size_t ring, index, count;
    };
    std::vector<Edge> edges;
    for (std::size_t r = 0; r < polygons.rings.size(); ++r)
      for (std::size_t k = 0; k < polygons.rings[r].size(); ++k) {
        const Ring& ring = polygons.rings[r];
        edges.push_back({ring[k], ring[(k + 1) % ring.size()], r, k, ring.size()});
      }
    const auto cross = [](const Vec2& a, const Vec2& b, const Vec2& c) {
      const double value = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
      return value > 0 ? 1 : value < 0 ? -1 : 0;
    };
    const auto between = [&](const Vec2& a, const Vec2& b, const Vec2& p) {
      return cross(a, b, p) == 0 && (p - a).dot(p - b) <= 0;
    };
    bool meets = false;
    for (std::size_t e = 0; e < edges.size() && !meets; ++e) {
      meets = edges[e].a == edges[e].b;  // zero edges: not compared
      for (std::size_t f = 0; f < e && !meets; ++f) {
        const Edge &p = edges[e], &q = edges[f];
        const bool same = p.ring == q.ring;
        if (same && (q.index + 1) % q.count == p.index)
          meets = between(p.a, p.b, q.a) || between(q.a, q.b, p.b);
        else if (same && (p.index + 1) % p.count == q.index)
          meets = between(q.a, q.b, p.a) || between(p.a, p.b, q.b);
        else
          meets = between(p.a, p.b, q.a) || between(p.a, p.b, q.b) || between(q.a, q.b, p.a) ||
                  between(q.a, q.b, p.b) ||
                  (cross(p.a, p.b, q.a) * cross(p.a, p.b, q.b) < 0 && cross(q.a, q.b, p.a) * cross(q.a, q.b, p.b) < 0);
      }
    }
    if (std::any_of(edges.begin(), edges.end(), [](const Edge& e) { return e.a == e.b; })) continue;
    ASSERT_EQ(!found, meets) << round;
    (found ? simple : none) += 1;
    if (!found) continue;
    // What a ring is in follows from the winding number of the others about one of its points.
    std::int64_t components = 0, holes = 0;
    for (std::size_t r = 0; r < polygons.rings.size(); ++r) {
      const Vec2 p = polygons.rings[r][0];
      int around = 0;
      double twice_area = 0;
      for (const Edge& e : edges) {
        if (e.ring == r)
          twice_area += e.a[0] * e.b[1] - e.a[1] * e.b[0];
        else if ((e.a[1] <= p[1]) != (e.b[1] <= p[1]) && cross(e.a, e.b, p) == (e.a[1] <= p[1] ? -1 : 1))
          around += e.a[1] <= p[1] ? -1 : 1;
      }
      const int within = around + (twice_area > 0 ? 1 : -1);
      const auto is_inside = [&](int w) { return fill == PolygonFill::evenodd ? w % 2 != 0 : w != 0; };
      components += is_inside(within) && !is_inside(around);
      holes += !is_inside(within) && is_inside(around);
    }
    EXPECT_EQ(found->components, components) << round;
    EXPECT_EQ(found->holes, holes) << round;
    nested += holes > 0;
  }
  EXPECT_GT(simple, 100);
  EXPECT_GT(none, 100);
  EXPECT_GT(nested, 10);
}

}  // namespace digitize_test
