// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>

#include "tree/measured_tree.h"

namespace quench::tree {

Table sholl_table(const MeasuredTree& measured, double step) {
  const Tree& tree = measured.tree;
  double farthest = 0;
  std::vector<std::vector<double>> away;  // of the points of each branch from the root node of its plant
  for (const Tree::Branch& b : tree.branches) {
    std::vector<double>& distances = away.emplace_back();
    for (const Vec3& p : b.points) distances.push_back((p - tree.plants[b.plant].root).norm());
    farthest = std::max(farthest, *std::ranges::max_element(distances));
  }
  if (!(step > 0)) step = farthest / 50;
  const auto spheres =
      step > 0 ? static_cast<std::size_t>(std::min(1e6, std::floor(farthest / step * (1 + 1e-12)))) : 0;
  std::vector<std::int64_t> crossings(spheres, 0);
  for (const std::vector<double>& distances : away)
    for (std::size_t i = 1; i < distances.size(); ++i) {
      // Spheres k with low < k step <= high.
      const auto [low, high] = std::minmax(distances[i - 1], distances[i]);
      for (auto k = static_cast<std::size_t>(low / step) + 1; k <= spheres && static_cast<double>(k) * step <= high;
           ++k)
        if (static_cast<double>(k) * step > low) ++crossings[k - 1];
    }
  Columns columns(spheres);
  columns.add("radius", tree.coordinates.units, "Radius of the sphere around the root node.",
              [&](std::size_t i) { return static_cast<double>(i + 1) * step; });
  columns.add("crossings", "", "How often courses pass through it.", [&](std::size_t i) { return crossings[i]; });
  return columns.take();
}

Table depths_table(const MeasuredTree& measured, int bins) {
  const Tree& tree = measured.tree;
  const std::string unit = tree.coordinates.units;
  double top = -std::numeric_limits<double>::infinity(), bottom = -top;
  for (const Tree::Axis& a : tree.axes)
    for (const Vec3& p : a.points) {
      top = std::max(top, measured.height_of(p));
      bottom = std::min(bottom, measured.height_of(p));
    }
  const auto count = tree.axes.empty() ? 0 : static_cast<std::size_t>(std::max(1, bins));
  const double layer = count > 0 ? (top - bottom) / static_cast<double>(count) : 0;
  std::vector<double> length(count, 0), volume(count, 0);
  std::vector<std::int64_t> axes(count, 0);
  double whole = 0;
  for (const Tree::Axis& a : tree.axes) {
    std::vector<char> here(count, 0);
    for (std::size_t i = 1; i < a.points.size(); ++i) {
      const double from = top - measured.height_of(a.points[i - 1]), to = top - measured.height_of(a.points[i]);
      const double step = (a.points[i] - a.points[i - 1]).norm(), radius = (a.radius[i] + a.radius[i - 1]) / 2;
      const auto [low, high] = std::minmax(from, to);
      const auto at = [&](double depth) {
        return layer > 0 ? std::min(count - 1, static_cast<std::size_t>(std::max(0.0, depth) / layer)) : 0;
      };
      for (std::size_t k = at(low); k <= at(high); ++k) {
        const double begin = static_cast<double>(k) * layer, end = k + 1 == count ? high : begin + layer;
        const double part = high > low ? (std::min(high, end) - std::max(low, begin)) / (high - low) : 1;
        length[k] += step * std::max(0.0, part);
        volume[k] += std::numbers::pi * radius * radius * step * std::max(0.0, part);
        here[k] = 1;
      }
      whole += step;
    }
    for (std::size_t k = 0; k < count; ++k) axes[k] += here[k];
  }
  Columns columns(count);
  columns.add("from", unit, "Upper side of the layer, below the highest point.",
              [&](std::size_t i) { return static_cast<double>(i) * layer; });
  columns.add("to", unit, "Lower side of the layer.",
              [&](std::size_t i) { return static_cast<double>(i + 1) * layer; });
  columns.add("length", unit, "Length of the axes in it.", [&](std::size_t i) { return length[i]; });
  columns.add("share", "", "The same, of all length.",
              [&](std::size_t i) { return whole > 0 ? length[i] / whole : kNotDefined; });
  columns.add("volume", unit_to_the(unit, 3), "Volume of the axes in it, as cylinders.",
              [&](std::size_t i) { return volume[i]; });
  columns.add("axes", "", "Axes that are in it.", [&](std::size_t i) { return axes[i]; });
  return columns.take();
}

}  // namespace quench::tree
