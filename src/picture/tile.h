// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "picture/style.h"
#include "quench/geometry.h"

/// What is seen through each sample of a square of the picture. Positions are in samples from the left top of the
/// picture; the middle of sample (x, y) is (x + 1/2, y + 1/2). Depth is 1 / distance along the line of sight: it is
/// affine on the screen, and what is larger is nearer.
namespace quench::picture {

inline constexpr int kSamples = 3;  ///< along each side of a pixel
inline constexpr int kTile = 32;    ///< pixels
inline constexpr int kTileSamples = kTile * kSamples;

/// Bounds of samples, the upper ones beyond.
struct Box {
  int x0, y0, x1, y1;
  bool empty() const { return x0 >= x1 || y0 >= y1; }
  Box cut(const Box& o) const {
    return {std::max(x0, o.x0), std::max(y0, o.y0), std::min(x1, o.x1), std::min(y1, o.y1)};
  }
};

/// A projected point: (x w, y w, w), w the distance along the line of sight.
using Projected = Vec3;

/// A triangle as affine functions of the position: weight_i / w of each corner. Both sides count, and corners may lie
/// behind the eye (Olano and Greer, Triangle scan conversion using 2D homogeneous coordinates, 1997).
struct TriangleSetup {
  Mat3 rows = Mat3::Zero();   ///< per corner: factors of x, y, 1
  Vec3 depth = Vec3::Zero();  ///< their sum
  bool visible = false;       ///< seen from its edge it covers nothing

  TriangleSetup(const Projected& a, const Projected& b, const Projected& c) {
    const Vec3 bc = b.cross(c);
    const double det = a.dot(bc);
    if (!(std::abs(det) > 1e-300)) return;
    rows << bc.transpose(), c.cross(a).transpose(), a.cross(b).transpose();
    rows /= det;
    depth = rows.colwise().sum();
    visible = rows.allFinite();
  }
  /// Shares of the corners at a position, perspective-correct.
  Vec3f weights(double x, double y) const {
    const Vec3 at = rows * Vec3(x, y, 1);
    return (at / at.sum()).cast<float>();
  }
};

/// A straight bar with round ends between projected points; its width may differ at the ends.
struct BarSetup {
  Eigen::Vector2d a, along;  ///< first end, to the second
  double length2, depth_a, depth_b, half_a, half_b;

  BarSetup(const Projected& pa, const Projected& pb, double ha, double hb)
      : a(pa.head<2>() / pa.z()),
        along(pb.head<2>() / pb.z() - a),
        length2(along.squaredNorm()),
        depth_a(1 / pa.z()),
        depth_b(1 / pb.z()),
        half_a(ha),
        half_b(hb) {}
  double share(double x, double y) const {
    return length2 > 1e-12 ? std::clamp(((x - a.x()) * along.x() + (y - a.y()) * along.y()) / length2, 0.0, 1.0) : 0;
  }
  double half(double t) const { return half_a + (half_b - half_a) * t; }
  double depth(double t) const { return depth_a + (depth_b - depth_a) * t; }
  Box box() const;
};

/// One thing per sample, the nearest.
struct Layer {
  std::vector<float> depth;
  std::vector<std::uint32_t> id;
  void clear() {
    depth.assign(kTileSamples * kTileSamples, 0);
    id.assign(depth.size(), kNone);
  }
};

struct Tile {
  Box box{};  ///< of its samples
  Layer solid, glass;
  std::vector<std::uint8_t> line;  ///< kinds of thin lines before what is solid, as bits

  void begin(const Box& samples);
  std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y - box.y0) * kTileSamples + static_cast<std::size_t>(x - box.x0);
  }
  /// `nearest`: the largest depth that is drawn. Of what is equally near the first stays.
  void draw(Layer& layer, const TriangleSetup& triangle, const Box& bounds, double nearest, std::uint32_t id) const;
  /// `bias`: added to the depth.
  void draw(const BarSetup& bar, double bias, std::uint32_t id);
  /// What is drawn of a thing whose hit(ray) says how far it is; `ray`: of a position.
  template <class Thing, class Ray>
  void draw(const Thing& thing, const Ray& ray, const Box& bounds, std::uint32_t id) {
    const Box b = bounds.cut(box);
    for (int y = b.y0; y < b.y1; ++y)
      for (int x = b.x0; x < b.x1; ++x) {
        const auto hit = thing.hit(ray(x + 0.5, y + 0.5));
        if (!hit || !(hit->distance > 0)) continue;
        const auto depth = static_cast<float>(1 / hit->distance);
        const std::size_t i = at(x, y);
        if (depth <= solid.depth[i]) continue;
        solid.depth[i] = depth;
        solid.id[i] = id;
      }
  }
  void draw_line(const BarSetup& bar, double bias, std::uint8_t kind);
};

}  // namespace quench::picture
