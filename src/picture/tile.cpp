// SPDX-License-Identifier: Apache-2.0
#include "picture/tile.h"

namespace quench::picture {
namespace {

/// Positions on an edge belong to both triangles there, whatever the rounding.
constexpr double kOnEdge = 1e-6;

/// Calls sample(x, y, t) for what lies in a bar.
template <class Sample>
void for_samples(const BarSetup& bar, const Box& box, const Sample& sample) {
  for (int y = box.y0; y < box.y1; ++y)
    for (int x = box.x0; x < box.x1; ++x) {
      const double t = bar.share(x + 0.5, y + 0.5), half = bar.half(t);
      const double dx = x + 0.5 - bar.a.x() - t * bar.along.x(), dy = y + 0.5 - bar.a.y() - t * bar.along.y();
      if (dx * dx + dy * dy <= half * half) sample(x, y, t);
    }
}

}  // namespace

Box BarSetup::box() const {
  static constexpr double kFar = 1e6;
  const double reach = std::max(half_a, half_b) + 1;
  const Eigen::Vector2d low = a.cwiseMin(a + along), high = a.cwiseMax(a + along);
  const auto floor = [](double x) { return static_cast<int>(std::floor(std::clamp(x, -kFar, kFar))); };
  return {floor(low.x() - reach), floor(low.y() - reach), floor(high.x() + reach) + 1, floor(high.y() + reach) + 1};
}

void Tile::begin(const Box& samples) {
  box = samples;
  solid.clear();
  glass.clear();
  line.assign(solid.depth.size(), 0);
}

void Tile::draw(Layer& layer, const TriangleSetup& triangle, const Box& bounds, double nearest,
                std::uint32_t id) const {
  const Box b = bounds.cut(box);
  for (int y = b.y0; y < b.y1; ++y) {
    double low = b.x0 + 0.5, high = b.x1 - 0.5;
    for (int i = 0; i < 3; ++i) {
      const double slope = triangle.rows(i, 0), rest = triangle.rows(i, 1) * (y + 0.5) + triangle.rows(i, 2);
      if (slope > 0)
        low = std::max(low, -rest / slope - kOnEdge);
      else if (slope < 0)
        high = std::min(high, -rest / slope + kOnEdge);
      else if (rest < 0)
        high = low - 1;
    }
    if (!(low <= high)) continue;
    const int first = static_cast<int>(std::ceil(low - 0.5)), last = static_cast<int>(std::floor(high - 0.5));
    const double rest = triangle.depth.y() * (y + 0.5) + triangle.depth.z();
    for (int x = first; x <= last; ++x) {
      const double depth = triangle.depth.x() * (x + 0.5) + rest;
      const std::size_t i = at(x, y);
      if (static_cast<float>(depth) <= layer.depth[i] || depth > nearest) continue;
      layer.depth[i] = static_cast<float>(depth);
      layer.id[i] = id;
    }
  }
}

void Tile::draw(const BarSetup& bar, double bias, std::uint32_t id) {
  for_samples(bar, bar.box().cut(box), [&](int x, int y, double t) {
    const auto depth = static_cast<float>(bar.depth(t) + bias);
    const std::size_t i = at(x, y);
    if (depth <= solid.depth[i]) return;
    solid.depth[i] = depth;
    solid.id[i] = id;
  });
}

void Tile::draw_line(const BarSetup& bar, double bias, std::uint8_t kind) {
  for_samples(bar, bar.box().cut(box), [&](int x, int y, double t) {
    const std::size_t i = at(x, y);
    if (static_cast<float>(bar.depth(t) + bias) >= solid.depth[i]) line[i] |= kind;
  });
}

}  // namespace quench::picture
