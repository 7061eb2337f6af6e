// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "tree/measured_tree.h"

namespace quench::tree {
namespace {

constexpr std::size_t kLevels = 6;  // that have columns of their own; the last holds all above too
constexpr int kSlices = 200;
const Vec3 kAnyDirection = Vec3(0.48, 0.36, 0.8);

std::vector<double> numbers_in(const Table& table, const char* name) {
  const Table::Column* column = table.find(name);
  std::vector<double> result;
  std::visit(
      [&](const auto& values) {
        if constexpr (!std::is_same_v<std::decay_t<decltype(values)>, std::vector<std::string>>)
          for (const auto v : values) result.push_back(static_cast<double>(v));
      },
      column->values);
  return result;
}

// The mean of the values that are defined.
double mean(const std::vector<double>& values) {
  double sum = 0, count = 0;
  for (const double v : values)
    if (!std::isnan(v)) {
      sum += v;
      ++count;
    }
  return count > 0 ? sum / count : kNotDefined;
}
double ratio(double a, double b) { return b > 0 ? a / b : kNotDefined; }

struct LevelSums {
  std::int64_t axes = 0;
  double length = 0, radius = 0;  // radius times length
};

// Where along the main axes children leave them: clusters, as far apart as less than the radius there.
struct Whorls {
  std::int64_t count = 0, axes = 0;
  std::vector<double> internodes;
};
Whorls whorls_of(const MeasuredTree& measured) {
  Whorls whorls;
  for (const Tree::Plant& plant : measured.tree.plants) {
    const Tree::Axis& stem = measured.tree.axes[plant.main_axis];
    double last = 0, sum = 0, size = 0, before = kNotDefined;
    const auto close = [&] {
      if (size == 0) return;
      ++whorls.count;
      if (!std::isnan(before)) whorls.internodes.push_back(sum / size - before);
      before = sum / size;
      sum = size = 0;
    };
    for (const std::uint32_t child : stem.children) {
      const double at = measured.tree.axes[child].position;
      if (size > 0 && at - last > measured.course[plant.main_axis].radius_at(at)) close();
      sum += at;
      ++size;
      ++whorls.axes;
      last = at;
    }
    close();
  }
  return whorls;
}

// How many axes pass through each of the planes across `down`, in the middle of 200 layers of equal height.
std::vector<double> axes_per_slice(const MeasuredTree& measured, double top, double bottom) {
  std::vector<double> counts(kSlices, 0);
  const double layer = (top - bottom) / kSlices;
  if (!(layer > 0)) return {};
  std::vector<std::size_t> last(kSlices, 0);  // axis that passed a plane, from 1: each counts once
  for (std::size_t n = 1; n <= measured.tree.axes.size(); ++n) {
    const Tree::Axis& a = measured.tree.axes[n - 1];
    for (std::size_t i = 1; i < a.points.size(); ++i) {
      const double from = (top - measured.height_of(a.points[i - 1])) / layer - 0.5;
      const double to = (top - measured.height_of(a.points[i])) / layer - 0.5;
      const auto [low, high] = std::minmax(from, to);
      for (double k = std::floor(low) + 1; k <= high && k < kSlices; ++k)
        if (const auto plane = static_cast<std::size_t>(k); std::exchange(last[plane], n) != n) ++counts[plane];
    }
  }
  return counts;
}

// The depth above which there is this share of all length.
double depth_of_share(const MeasuredTree& measured, double top, double share) {
  std::vector<std::pair<double, double>> pieces;  // depth of the middle of a segment, and its length
  double whole = 0;
  for (const Tree::Axis& a : measured.tree.axes)
    for (std::size_t i = 1; i < a.points.size(); ++i) {
      pieces.emplace_back(top - measured.height_of((a.points[i] + a.points[i - 1]) / 2),
                          (a.points[i] - a.points[i - 1]).norm());
      whole += pieces.back().second;
    }
  std::sort(pieces.begin(), pieces.end());
  double sum = 0;
  for (const auto& [depth, length] : pieces)
    if ((sum += length) >= share * whole * (1 - 1e-12)) return depth;
  return kNotDefined;
}

// Points on the balls, in 26 directions: their hull is nearly that of the balls.
std::vector<Vec3> points_on_balls(const Tree& tree) {
  std::vector<Vec3> points;
  for (const Tree::Axis& a : tree.axes)
    for (std::size_t i = 0; i < a.points.size(); ++i)
      for (int k = 0; k < 27; ++k)
        if (k != 13 && (a.radius[i] > 0 || k == 0))
          points.push_back(a.points[i] + a.radius[i] * Vec3(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1).normalized());
  return points;
}

}  // namespace

Table sample_table(const MeasuredTree& measured, const Table& axes, const Table& branches, const Table& sholl) {
  const Tree& tree = measured.tree;
  const std::string unit = tree.coordinates.units, area = unit_to_the(unit, 2), volume = unit_to_the(unit, 3);
  const std::string deg = "degrees";
  Columns columns(tree.plants.empty() ? 0 : 1);
  const auto add = [&](const std::string& name, const std::string& of, const std::string& meaning, auto value) {
    columns.add(name, of, meaning, [&](std::size_t) { return value; });
  };
  const auto mean_in = [&](const Table& table, const char* name) { return mean(numbers_in(table, name)); };

  std::array<LevelSums, kLevels> levels;
  double length = 0, radius = 0, chord = 0, frusta = 0, lateral = 0, bridged = 0;
  std::uint32_t deepest = 0;
  for (std::size_t a = 0; a < tree.axes.size(); ++a) {
    const CourseMeasures& m = measured.axis[a];
    LevelSums& level = levels[std::min<std::size_t>(tree.axes[a].level, kLevels - 1)];
    ++level.axes;
    level.length += m.length;
    level.radius += m.length * m.mean_radius;
    length += m.length;
    radius += m.length * m.mean_radius;
    chord += m.chord;
    frusta += m.volume;
    lateral += m.surface;
    deepest = std::max(deepest, tree.axes[a].level);
  }
  std::int64_t tips = 0;
  std::uint32_t strahler = 0, order = 0;
  for (std::uint32_t b = 0; b < tree.branches.size(); ++b) {
    tips += measured.children[b].empty() ? 1 : 0;
    strahler = std::max(strahler, tree.branches[b].strahler);
    order = std::max(order, tree.branches[b].order);
    bridged += measured.bridged_length(b);
  }
  add("plants", "", "Trees.", tree.plants.size());
  add("axes", "", "Axes of all levels.", tree.axes.size());
  add("branches", "", "Pieces between forks and ends.", tree.branches.size());
  add("tips", "", "Free ends, root nodes not counted.", tips);
  add("forks", "", "Places where a branch goes on as several.", static_cast<std::int64_t>(tree.branches.size()) - tips);
  add("levels", "", "Largest level and one more.", std::int64_t{deepest} + 1);
  for (std::size_t l = 0; l < kLevels; ++l) {
    const std::string of = std::to_string(l), more = l + 1 == kLevels ? " and above." : ".";
    add("axes_level_" + of, "", "Axes of level " + of + more, levels[l].axes);
    add("length_level_" + of, unit, "Their length in all.", levels[l].length);
    add("mean_radius_level_" + of, unit, "Their mean radius along the length.",
        ratio(levels[l].radius, levels[l].length));
  }
  add("total_length", unit, "Length of all axes.", length);
  add("mean_length", unit, "Mean length of axes.", ratio(length, static_cast<double>(tree.axes.size())));
  add("mean_radius", unit, "Mean radius along all length.", ratio(radius, length));
  add("tortuosity", "", "Length of all axes over the sum of their chords.", ratio(length, chord));
  add("volume", volume, "Frusta of all axes; what lies in several counts several times.", frusta);
  add("surface", area, "Lateral surfaces of these frusta.", lateral);
  const BallUnion balls = union_of_balls(measured.course);
  add("volume_balls", volume, "Volume of the union of all balls.", balls.volume);
  add("surface_balls", area, "Surface of the union of all balls.", balls.surface);
  add("specific_length", unit_to_the(unit, -2), "Length over volume of the union of balls.",
      ratio(length, balls.volume));

  double top = -std::numeric_limits<double>::infinity(), bottom = -top;
  std::vector<Vec3> seen_from_above;
  const Mat3 frame = [&] {
    const Vec3 z = -tree.down;
    Vec3 other = kAnyDirection;
    if (std::abs(other.dot(z)) > 0.9) other = Vec3(-other[2], other[0], other[1]);
    const Vec3 x = (other - other.dot(z) * z).normalized();
    const Vec3 y(z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0]);
    Mat3 rows;
    rows << x.transpose(), y.transpose(), z.transpose();
    return rows;
  }();
  for (const Tree::Axis& a : tree.axes)
    for (const Vec3& p : a.points) {
      top = std::max(top, measured.height_of(p));
      bottom = std::min(bottom, measured.height_of(p));
      seen_from_above.push_back(frame * p);
    }
  const double depth = tree.axes.empty() ? 0 : top - bottom, width = widest(std::move(seen_from_above));
  const double hull = hull_volume(points_on_balls(tree));
  add("down", "", "Where gravity points.", direction_text(tree.down));
  add("depth", unit, "Extent of the courses along down.", depth);
  add("width", unit, "Largest extent of the courses across down.", width);
  add("width_depth_ratio", "", "Width over depth.", ratio(width, depth));
  add("median_depth", unit, "Depth above which half of the length lies.", depth_of_share(measured, top, 0.5));
  add("depth_95", unit, "Depth above which 95 % of the length lies.", depth_of_share(measured, top, 0.95));
  add("hull_volume", volume, "Volume of the convex hull.", hull);
  add("solidity", "", "Volume of the union of balls over that of the convex hull.", ratio(balls.volume, hull));
  add("length_density", unit_to_the(unit, -2), "Length over volume of the convex hull.", ratio(length, hull));
  add("fractal_dimension", "", "Box counting dimension of the courses.", box_dimension(measured.course));
  std::vector<double> slices = axes_per_slice(measured, top, bottom);
  std::sort(slices.begin(), slices.end());
  const double median = slices.empty() ? kNotDefined : (slices[(kSlices - 1) / 2] + slices[kSlices / 2]) / 2;
  const double most = slices.empty() ? kNotDefined : slices.back();
  add("median_axes_per_slice", "", "Median of the axes that pass through 200 planes across down.", median);
  add("max_axes_per_slice", "", "The largest of these numbers.", most);
  add("bushiness", "", "The largest over the median.", ratio(most, median));
  const Whorls whorls = whorls_of(measured);
  add("whorls", "", "Clusters of children along the main axis.", whorls.count);
  add("axes_per_whorl", "", "Children of the main axis per cluster.",
      ratio(static_cast<double>(whorls.axes), static_cast<double>(whorls.count)));
  add("mean_internode", unit, "Mean distance of clusters along the main axis.", mean(whorls.internodes));
  add("longest_internode", unit, "Longest distance of clusters along the main axis.",
      whorls.internodes.empty() ? kNotDefined : *std::ranges::max_element(whorls.internodes));
  add("mean_gravity_angle", deg, "Mean of gravity_angle of the axes.", mean_in(axes, "gravity_angle"));
  add("mean_parent_angle", deg, "Mean of parent_angle of the axes.", mean_in(axes, "parent_angle"));
  add("mean_emergence_angle", deg, "Mean of emergence_angle of the axes.", mean_in(axes, "emergence_angle"));
  add("strahler", "", "Largest Horton-Strahler number.", strahler);
  add("max_order", "", "Largest centrifugal order.", order);
  add("partition_asymmetry", "", "Mean over forks of two branches.", mean_in(branches, "partition_asymmetry"));
  add("taper", "", "Mean of taper of the branches.", mean_in(branches, "taper"));
  add("local_angle", deg, "Mean of local_angle of the forks.", mean_in(branches, "local_angle"));
  add("remote_angle", deg, "Mean of remote_angle of the forks.", mean_in(branches, "remote_angle"));
  const std::vector<double> crossings = numbers_in(sholl, "crossings");
  const auto peak = std::ranges::max_element(crossings);
  add("sholl_max", "", "Largest number of crossings of a sphere around the root node.",
      crossings.empty() ? kNotDefined : *peak);
  add("sholl_radius", unit, "Radius of the first such sphere.",
      crossings.empty() ? kNotDefined
                        : numbers_in(sholl, "radius")[static_cast<std::size_t>(peak - crossings.begin())]);
  add("soma_radius", unit, "Radius of the first soma.", [&] {
    for (const Tree::Plant& plant : tree.plants)
      if (plant.soma) return *plant.soma;
    return kNotDefined;
  }());
  add("bridged_length", unit, "Length of branches where the shape has gaps.", bridged);
  return columns.take();
}

}  // namespace quench::tree
