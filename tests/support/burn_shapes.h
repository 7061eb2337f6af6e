// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "random_complexes.h"

/// Complexes whose burn times are known in closed form. Interior vertices are displaced at random inside their sheet,
/// so that no line of nodes happens to run along the fire.
namespace quench::testing_complexes {

/// An input with the true burn time of each vertex; NaN where it is not known.
struct KnownBurn {
  BurnInput input;
  std::vector<double> truth;
};

inline KnownBurn known(BurnInput input, const std::function<double(const Vec3&)>& truth) {
  KnownBurn result{std::move(input), {}};
  for (const Vec3& p : result.input.points) result.truth.push_back(truth(p));
  return result;
}

inline double distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const double t = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
  return (p - (a + t * (b - a))).norm();
}

/// The parallelogram at `origin` in `nu` by `nv` cells of two triangles, its inner vertices displaced by up to `jitter`
/// cells. Cells (i, j) with skip(i, j) are left out, and vertices of such cells stay in place.
inline void jittered_sheet(
    Builder& b, const Vec3& origin, const Vec3& u, const Vec3& v, int nu, int nv, Random& random, double jitter = 0.3,
    const std::function<bool(int, int)>& skip = [](int, int) { return false; }) {
  std::vector<std::uint32_t> at;
  const auto fixed = [&](int i, int j) {
    return i == 0 || j == 0 || i == nu || j == nv || skip(i, j) || skip(i - 1, j) || skip(i, j - 1) ||
           skip(i - 1, j - 1);
  };
  for (int i = 0; i <= nu; ++i)
    for (int j = 0; j <= nv; ++j) {
      const double du = jitter * (2 * random.unit() - 1), dv = jitter * (2 * random.unit() - 1);
      const bool used = !(skip(i, j) && skip(i - 1, j) && skip(i, j - 1) && skip(i - 1, j - 1));
      at.push_back(
          !used ? 0
                : b.vertex(origin + u * ((i + (fixed(i, j) ? 0 : du)) / nu) + v * ((j + (fixed(i, j) ? 0 : dv)) / nv)));
    }
  const auto node = [&](int i, int j) { return at[static_cast<std::size_t>(i * (nv + 1) + j)]; };
  for (int i = 0; i < nu; ++i)
    for (int j = 0; j < nv; ++j) {
      if (skip(i, j)) continue;
      if ((i + j) % 2) {
        b.face({node(i, j), node(i + 1, j), node(i + 1, j + 1)});
        b.face({node(i, j), node(i + 1, j + 1), node(i, j + 1)});
      } else {
        b.face({node(i, j), node(i + 1, j), node(i, j + 1)});
        b.face({node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)});
      }
    }
}

/// The triangle abc in n^2 triangles, inner vertices displaced.
inline void jittered_triangle(Builder& builder, const Vec3& a, const Vec3& b, const Vec3& c, int n, Random& random) {
  const auto position = [&](int i, int j) { return Vec3(a + (b - a) * (double(i) / n) + (c - a) * (double(j) / n)); };
  std::vector<std::vector<std::uint32_t>> at(static_cast<std::size_t>(n) + 1);
  for (int i = 0; i <= n; ++i)
    for (int j = 0; i + j <= n; ++j) {
      Vec3 p = position(i, j);
      const double x = 0.25 * (2 * random.unit() - 1) / n, y = 0.25 * (2 * random.unit() - 1) / n;
      if (i > 0 && j > 0 && i + j < n) p += x * (b - a) + y * (c - a);
      at[static_cast<std::size_t>(i)].push_back(builder.vertex(p));
    }
  const auto node = [&](int i, int j) { return at[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)]; };
  for (int i = 0; i < n; ++i)
    for (int j = 0; i + j < n; ++j) {
      builder.face({node(i, j), node(i + 1, j), node(i, j + 1)});
      if (i + j + 1 < n) builder.face({node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)});
    }
}

/// Constant radius: fire comes from the nearest side.
inline KnownBurn square_sheet(double side = 10, int n = 8) {
  Random random(1);
  Builder b;
  jittered_sheet(b, {0, 0, 0}, {side, 0, 0}, {0, side, 0}, n, n, random);
  return known(b.input([](const Vec3&) { return 1.5; }), [=](const Vec3& p) {
    return 1.5 + std::min({p[0], p[1], side - p[0], side - p[1]});
  });
}

/// Radius = distance to a site at height h over the square. A path from the site over a side to x is straight when the
/// plane through site and side is turned about the side into the sheet, beyond the side: for the side on the line L,
/// BT^2 = (difference along L)^2 + (d(site, L) + d(x, L))^2, and the least over the sides is taken. The straight
/// line crosses the side itself, between the feet of both on L.
inline KnownBurn square_under_site(const Vec3& site = {3, 4.5, 2}, double side = 10, int n = 8) {
  Random random(2);
  Builder b;
  jittered_sheet(b, {0, 0, 0}, {side, 0, 0}, {0, side, 0}, n, n, random);
  return known(b.input([=](const Vec3& p) { return (p - site).norm(); }, RadiusRule::exact), [=](const Vec3& p) {
    double best = 1e9;
    for (int axis : {0, 1})
      for (double at : {0.0, side})
        best = std::min(best, std::hypot(p[1 - axis] - site[1 - axis],
                                         std::abs(p[axis] - at) + std::hypot(site[axis] - at, site[2])));
    return best;
  });
}

/// [0,12]^2 without [6,12]^2, constant radius: the nearest rim point is visible, around the reflex corner fronts are
/// circles.
inline KnownBurn l_sheet() {
  Random random(3);
  Builder b;
  const int n = 8;
  jittered_sheet(b, {0, 0, 0}, {12, 0, 0}, {0, 12, 0}, n, n, random, 0.3,
                 [](int i, int j) { return i >= n / 2 && j >= n / 2; });
  const std::vector<Vec3> rim{{0, 0, 0}, {12, 0, 0}, {12, 6, 0}, {6, 6, 0}, {6, 12, 0}, {0, 12, 0}};
  return known(b.input([](const Vec3&) { return 0.7; }), [=](const Vec3& p) {
    double best = 1e9;
    for (std::size_t i = 0; i < rim.size(); ++i)
      best = std::min(best, distance_to_segment(p, rim[i], rim[(i + 1) % rim.size()]));
    return 0.7 + best;
  });
}

/// n equal triangles around an apex at the origin, rim vertices alternately at heights `up` and `down`. Radius =
/// distance to the first rim vertex s, so BT(x) = min over rim points y of |y - s| + geodesic(y, x); a geodesic is
/// straight in the unrolled cone where it passes the apex by less than a half turn, else it goes through the apex.
inline KnownBurn cone(int n, double rim, double up, double down, int refine) {
  Random random(4);
  Builder b;
  std::vector<Vec3> ring;
  for (int i = 0; i < n; ++i) {
    const double angle = 2 * std::numbers::pi * i / n;
    ring.push_back({rim * std::cos(angle), rim * std::sin(angle), i % 2 ? up : down});
  }
  const auto next = [&](int i) { return ring[static_cast<std::size_t>((i + 1) % n)]; };
  for (int i = 0; i < n; ++i)
    jittered_triangle(b, Vec3::Zero(), ring[static_cast<std::size_t>(i)], next(i), refine, random);
  const double corner = std::acos(ring[0].normalized().dot(ring[1].normalized())), turn = n * corner;
  // Angle around the apex of a point of triangle i.
  const auto polar = [=](const Vec3& p, int i) {
    const Vec3 a = ring[static_cast<std::size_t>(i)].normalized();
    return i * corner + (p.norm() > 1e-12 ? std::acos(std::clamp(p.normalized().dot(a), -1.0, 1.0)) : 0);
  };
  const Vec3 site = ring[0];
  return known(b.input([=](const Vec3& p) { return (p - site).norm(); }, RadiusRule::exact), [=](const Vec3& p) {
    int triangle = 0;
    double least = 1e9;  // the triangle of p: the barycentric excess is least
    for (int i = 0; i < n; ++i) {
      const Vec3 u = ring[static_cast<std::size_t>(i)], v = ring[static_cast<std::size_t>((i + 1) % n)];
      const Vec3 normal = u.cross(v);
      const double s = p.cross(v).dot(normal) / normal.squaredNorm(), t = u.cross(p).dot(normal) / normal.squaredNorm();
      const double off = std::abs(p.dot(normal.normalized())) + std::max({0.0, -s, -t, s + t - 1});
      if (off < least) {
        least = off;
        triangle = i;
      }
    }
    const double angle = polar(p, triangle), r = p.norm();
    double best = 1e9;
    for (int i = 0; i < n; ++i)
      if (distance_to_segment(p, ring[static_cast<std::size_t>(i)], ring[static_cast<std::size_t>((i + 1) % n)]) < 1e-9)
        best = (p - site).norm();
    constexpr int kSamples = 4000;  // of each side; off the rim the error is second order
    for (int i = 0; i < n; ++i)
      for (int k = 0; k <= kSamples; ++k) {
        const Vec3 a = ring[static_cast<std::size_t>(i)], c = ring[static_cast<std::size_t>((i + 1) % n)];
        const Vec3 y = a + (c - a) * (double(k) / kSamples);
        double between = std::abs(polar(y, i) - angle);
        between = std::min(between, turn - between);
        const double q = y.norm();
        const double path = between >= std::numbers::pi
                                ? q + r
                                : std::sqrt(std::max(0.0, q * q + r * r - 2 * q * r * std::cos(between)));
        best = std::min(best, (y - site).norm() + path);
      }
    return best;
  });
}

/// Three sheets of widths 3, 4 and 6 on a seam of length 12, constant radius. At the seam, off its ends, the second
/// latest sheet opens the latest: BT = radius + 4, and from there fire runs into the widest sheet. Every other point:
/// the nearest of its sheet's free sides.
inline KnownBurn three_sheets() {
  Random random(5);
  Builder b;
  const double pi = std::numbers::pi;
  for (const auto& [width, angle] : {std::pair{3.0, 0.1}, {4.0, 0.1 + 2 * pi / 3}, {6.0, 0.1 + 4 * pi / 3}})
    jittered_sheet(b, {0, 0, 0}, {0, 0, 12}, width * Vec3(std::cos(angle), std::sin(angle), 0), 8, 4, random);
  return known(b.input([](const Vec3&) { return 2.0; }), [=](const Vec3& p) {
    const double d = std::hypot(p[0], p[1]), ends = std::min(p[2], 12 - p[2]);
    if (d < 1e-9) return 2 + std::min(4.0, ends);
    const double angle = std::atan2(p[1], p[0]);
    for (const auto& [width, a] : {std::pair{3.0, 0.1}, {4.0, 0.1 + 2 * pi / 3}, {6.0, 0.1 + 4 * pi / 3}})
      if (std::cos(angle - a) > 0.99) return 2 + std::min({width - d, ends, width == 6.0 ? 4 + d : 1e9});
    return std::nan("");
  });
}

/// Medial axis of the box [0,a]x[0,b]x[0,c], a >= b >= c: a middle sheet at height c/2, two sheets from each of its
/// sides to the box's edges, a triangle from each of its corners to an upright edge: 13 sheets, radius = distance to
/// the walls. Fire starts at the box's edges at time 0; a point of radius r on a slanted sheet is r*sqrt(2) away from
/// its edge. So the sides of the middle sheet burn at c/sqrt(2) (ET = c(1/sqrt(2) - 1/2)), and inside it the distance
/// to them is added.
inline KnownBurn box_axis(double a, double b, double c, int n) {
  Random random(6);
  Builder builder;
  const double h = c / 2;
  const auto rotate = [](const std::vector<Vec3>& corners, std::size_t i) { return corners[(i + 1) % 4]; };
  const std::vector<Vec3> middle{{h, h, h}, {a - h, h, h}, {a - h, b - h, h}, {h, b - h, h}};
  jittered_sheet(builder, middle[0], middle[1] - middle[0], middle[3] - middle[0], n, n, random);
  for (const double z : {0.0, c}) {
    const std::vector<Vec3> outer{{0, 0, z}, {a, 0, z}, {a, b, z}, {0, b, z}};
    for (std::size_t i = 0; i < 4; ++i) {
      // A trapezoid: its base in n pieces, too, each strip cut along a diagonal.
      const auto on = [&](const Vec3& p, const Vec3& q, int k) { return Vec3(p + (q - p) * (double(k) / n)); };
      for (int k = 0; k < n; ++k) {
        const Vec3 p0 = on(outer[i], rotate(outer, i), k), p1 = on(outer[i], rotate(outer, i), k + 1);
        const Vec3 q0 = on(middle[i], rotate(middle, i), k), q1 = on(middle[i], rotate(middle, i), k + 1);
        builder.face({p0, p1, q0});
        builder.face({p1, q1, q0});
      }
    }
  }
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec3 foot(i == 1 || i == 2 ? a : 0, i >= 2 ? b : 0, 0);
    builder.face({foot, foot + Vec3(0, 0, c), middle[i]});
  }
  const auto radius = [=](const Vec3& p) {
    return std::max(0.0, std::min({p[0], a - p[0], p[1], b - p[1], p[2], c - p[2]}));
  };
  return known(builder.input(radius), [=](const Vec3& p) {
    if (std::abs(p[2] - h) > 1e-9) return std::sqrt(2) * radius(p);
    return c / std::sqrt(2) + std::min({p[0] - h, a - h - p[0], p[1] - h, b - h - p[1]});
  });
}

/// Fig. 3.5 with a square chimney of side 2 and height 20 on a plate [-5,5]^2, radius = distance to the site (-6,0,0)
/// in the plate's plane. Where the line of sight to the site is free BT = R. Behind the chimney fire goes round two of
/// its corners *beside* the seam; a fire that had to open the seam could pass only after that of the chimney,
/// which takes more than 40. Inside the foot the fire arrives over the top of the chimney: the front wall is reached at
/// sqrt(25 + 400) + 20 at the middle of its foot, and the centre one later.
inline KnownBurn chimney() {
  Random random(7);
  Builder b;
  const int n = 10;
  jittered_sheet(b, {-5, -5, 0}, {10, 0, 0}, {0, 10, 0}, n, n, random, 0.3,
                 [](int i, int j) { return i >= 4 && i < 6 && j >= 4 && j < 6; });
  jittered_sheet(b, {-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, 2, 2, random, 0);
  const std::vector<Vec3> foot{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  for (std::size_t i = 0; i < 4; ++i) jittered_sheet(b, foot[i], foot[(i + 1) % 4] - foot[i], {0, 0, 20}, 2, 8, random);
  const Vec3 site(-6, 0, 0);
  return known(b.input([=](const Vec3& p) { return (p - site).norm(); }, RadiusRule::exact), [=](const Vec3& p) {
    if (p[2] > 0) return std::nan("");
    const bool within = std::abs(p[0]) <= 1 + 1e-9 && std::abs(p[1]) <= 1 + 1e-9;
    if (within) return p.norm() < 1e-9 ? std::sqrt(425) + 21 : std::nan("");  // the seam: see the test
    const double y = std::abs(p[1]);
    const double sight = std::atan2(y, p[0] + 6), edge = std::atan2(1.0, 5.0);
    if (p[0] <= -1 || sight >= edge) return (p - site).norm();
    // In the shadow: by a front corner, those behind the chimney also by a rear one; or back from the plate's far side,
    // where R is a distance through the chimney (straight when x is reflected in that side).
    const double front = std::sqrt(26), back = std::hypot(16 - p[0], y);
    if (y >= 1) return std::min(back, front + std::hypot(p[0] + 1, y - 1));
    return std::min(back, front + 2 + std::hypot(p[0] - 1, y - 1));
  });
}

/// A closed fan of n triangles from `tip` to a regular ring of radius `rim`, `axis` higher.
inline void pyramid(Builder& b, const Vec3& tip, double axis, double rim, int n) {
  std::vector<std::uint32_t> base;
  for (int i = 0; i < n; ++i) {
    const double angle = 2 * std::numbers::pi * (i + 0.1) / n;
    base.push_back(b.vertex(tip + Vec3(rim * std::cos(angle), rim * std::sin(angle), axis)));
  }
  b.cone(b.vertex(tip), base);
}

/// Distance of the tip from the rim.
inline double pyramid_height(double axis, double rim, int n) {
  return std::hypot(axis, rim * std::cos(std::numbers::pi / n));
}

/// Six sheets between the four sites of a regular tetrahedron at distance 1 from the centre, cut off at distance d
/// along the junction rays. At the middle of a sheet's outer side (d/sqrt(3) from the centre) R^2 = d^2/3 + 1 - 2d/3.
/// R^2 and the squared distance to the centre both grow by u^2 with the distance u from there, so the first fire at the
/// centre comes straight from the middle, by symmetry at once in all sheets.
inline KnownBurn tetrahedral_junction(double d, int refine) {
  Random random(8);
  Builder b;
  const std::vector<Vec3> site{Vec3(1, 1, 1).normalized(), Vec3(1, -1, -1).normalized(), Vec3(-1, 1, -1).normalized(),
                               Vec3(-1, -1, 1).normalized()};
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = i + 1; j < 4; ++j)
      jittered_triangle(b, Vec3::Zero(), -d * site[i], -d * site[j], refine, random);
  const auto radius = [=](const Vec3& p) {
    double r = 1e9;
    for (const Vec3& s : site) r = std::min(r, (p - s).norm());
    return r;
  };
  return known(b.input(radius, RadiusRule::exact), [=](const Vec3& p) {
    return p.norm() < 1e-9 ? d / std::sqrt(3) + std::sqrt(d * d / 3 + 1 - 2 * d / 3) : std::nan("");
  });
}

/// A strip of width w around a circle with half a turn, constant radius 1.
inline BurnInput moebius_strip(double width, double circle, int n, int across) {
  Builder b;
  const auto at = [&](int i, int j) {
    const double turn = 2 * std::numbers::pi * i / n, half = turn / 2, s = width * (double(j) / across - 0.5);
    const double r = circle + s * std::cos(half);
    return b.vertex({r * std::cos(turn), r * std::sin(turn), s * std::sin(half)});
  };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < across; ++j) {
      b.face({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      b.face({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return b.input([](const Vec3&) { return 1.0; });
}

}  // namespace quench::testing_complexes
