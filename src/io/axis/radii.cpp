// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "io/common/formats.h"
#include "io/common/text_out.h"
#include "io/common/words.h"
#include "io/mesh/weld.h"

/// Radii of the vertices of a mesh: a count, then `x y z r` per line. Lines belong to vertices by position, not by
/// order.
namespace quench::io {
namespace {

/// A balanced kd-tree: the middle of a range of `order` splits it along the range's longest axis. O(n log n) to build,
/// O(log n) per query for points close to one of the tree.
class KdTree {
 public:
  explicit KdTree(const std::vector<Vec3>& points) : points_(points), order_(points.size()), axis_(points.size()) {
    std::iota(order_.begin(), order_.end(), std::uint32_t{0});
    build(0, order_.size());
  }

  /// The point nearest to `query` within sqrt(bound), or -1; `bound` becomes its squared distance.
  std::int64_t nearest(const Vec3& query, double& bound) const {
    std::int64_t best = -1;
    search(query, 0, order_.size(), bound, best);
    return best;
  }

 private:
  void build(std::size_t begin, std::size_t end) {
    if (begin == end) return;
    Vec3 low = points_[order_[begin]], high = low;
    for (std::size_t i = begin; i < end; ++i) {
      low = low.cwiseMin(points_[order_[i]]);
      high = high.cwiseMax(points_[order_[i]]);
    }
    int axis = 0;
    (high - low).maxCoeff(&axis);
    const std::size_t middle = begin + (end - begin) / 2;
    const auto at = [&](std::size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(begin), at(middle), at(end),
                     [&](std::uint32_t a, std::uint32_t b) { return points_[a][axis] < points_[b][axis]; });
    axis_[middle] = static_cast<std::uint8_t>(axis);
    build(begin, middle);
    build(middle + 1, end);
  }

  void search(const Vec3& query, std::size_t begin, std::size_t end, double& bound, std::int64_t& best) const {
    if (begin == end || (best >= 0 && bound == 0)) return;
    const std::size_t middle = begin + (end - begin) / 2;
    const Vec3& split = points_[order_[middle]];
    const auto improves = [&](double squared) { return squared < bound || (best < 0 && squared <= bound); };
    const double distance = (split - query).squaredNorm();
    if (improves(distance)) {
      bound = distance;
      best = order_[middle];
    }
    const double side = query[axis_[middle]] - split[axis_[middle]];
    const bool lower_first = side <= 0;
    for (bool lower : {lower_first, !lower_first})
      if (lower == lower_first || improves(side * side))
        lower ? search(query, begin, middle, bound, best) : search(query, middle + 1, end, bound, best);
  }

  const std::vector<Vec3>& points_;
  std::vector<std::uint32_t> order_;
  std::vector<std::uint8_t> axis_;
};

}  // namespace

std::vector<double> read_radii(const std::filesystem::path& path, const std::vector<Vec3>& points, Context* context) {
  const FileText file = load_file(path, context);
  Words words(file.bytes, file.name);
  const std::int64_t count = words.integer("the number of radii");
  std::vector<Vec3> places;
  std::vector<double> radii;
  Weld weld;
  std::size_t rows = 0;
  while (words.next_line()) {
    const double x = words.coordinate_on_line("x"), y = words.coordinate_on_line("y"),
                 z = words.coordinate_on_line("z"), r = words.coordinate_on_line("the radius");
    if (r < 0) words.fail(fmt::format("the radius {} is negative", r));
    // Repeated points would make every query near them visit them all; the first one counts.
    if (weld(Vec3(x, y, z), places) == radii.size()) radii.push_back(r);
    ++rows;
  }
  if (count < 0 || static_cast<std::size_t>(count) != rows)
    throw Error(ErrorCode::input, fmt::format("'{}' declares {} radii, but has {}", file.name, count, rows));
  std::vector<double> result;
  if (points.empty()) return result;

  Vec3 low = points.front(), high = low;
  for (const Vec3& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const double tolerance = 1e-3 * (high - low).maxCoeff();
  const KdTree tree(places);
  result.reserve(points.size());
  for (std::size_t v = 0; v < points.size(); ++v) {
    double bound = tolerance * tolerance;
    const std::int64_t nearest = tree.nearest(points[v], bound);
    if (nearest < 0)
      throw Error(ErrorCode::input,
                  fmt::format("'{}' has no radius within {} of vertex {} at ({}, {}, {}); it belongs to another medial "
                              "axis",
                              file.name, tolerance, v, points[v][0], points[v][1], points[v][2]));
    result.push_back(radii[static_cast<std::size_t>(nearest)]);
  }
  return result;
}

void write_r(std::ostream& out, const Record& data) {
  const std::vector<double> radii = required_radii(data, ".r");
  TextOut text(out);
  text.print("{}\n", data.points.size());
  for (std::size_t v = 0; v < data.points.size(); ++v)
    text.print("{} {} {} {}\n", data.points[v][0], data.points[v][1], data.points[v][2], radii[v]);
  text.flush();
}

}  // namespace quench::io
