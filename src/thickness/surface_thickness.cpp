// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <atomic>
#include <limits>
#include <numeric>

#include "axis/ball_tree.h"
#include "base/parallel.h"
#include "quench/error.h"
#include "quench/thickness.h"

namespace quench {
namespace {

// The largest ball that a point is at most `tolerance` outside of; tree.size() when there is none.
std::size_t largest_at(const axis::BallTree& tree, const Vec3& p, double tolerance) {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  std::size_t best = tree.size();
  double limit = kNever;  // less than this: minus the radius of the best one
  tree.walk(
      [&](std::size_t node) {
        const double largest = tree.largest_radius(node);
        return tree.distance(node, p) > largest + tolerance ? kNever : -largest;
      },
      limit,
      [&](std::size_t i) {
        const axis::BallTree::Ball ball = tree.ball(i);
        if (!(-ball.radius < limit) || axis::outside(ball, p) > tolerance) return;
        limit = -ball.radius;
        best = i;
      });
  return best;
}

// Of the balls that are nearly as large as the best one, all near enough, the one whose centre is nearest: walls of one
// thickness have many that touch a point within the tolerance, most of them obliquely.
std::size_t straightest_at(const axis::BallTree& tree, const Vec3& p, double tolerance, std::size_t best) {
  constexpr double kNearly = 0.98;
  const double least = kNearly * tree.ball(best).radius;
  double limit = (p - tree.ball(best).centre).norm();
  tree.walk(
      [&](std::size_t node) {
        return tree.largest_radius(node) < least ? std::numeric_limits<double>::infinity() : tree.distance(node, p);
      },
      limit,
      [&](std::size_t i) {
        const axis::BallTree::Ball ball = tree.ball(i);
        const double distance = (p - ball.centre).norm();
        if (ball.radius < least || !(distance < limit) || distance > ball.radius + tolerance) return;
        limit = distance;
        best = i;
      });
  return best;
}

// The other end of the diameter that begins at a point.
Vec3 end_of_diameter(const Vec3& p, const axis::BallTree::Ball& ball) {
  const Vec3 way = ball.centre - p;
  const double length = way.norm();
  return length > 0 ? Vec3(ball.centre + way * (ball.radius / length)) : p;
}

}  // namespace

SurfaceThickness surface_thickness(std::span<const Vec3> points, const Surface* surface, const MedialAxis& axis,
                                   const SurfaceThicknessOptions& options, Context* context) {
  if (axis.points.empty() || axis.radius.size() != axis.points.size())
    throw Error(ErrorCode::usage, "thickness of a surface needs a medial axis with a radius per vertex");
  return base::in_arena(context, [&] {
    checkpoint(context, "surface", 0);
    std::vector<std::uint32_t> all(axis.points.size());
    std::iota(all.begin(), all.end(), 0U);
    const axis::BallTree tree(axis.points, axis.radius, std::move(all));
    SurfaceThickness result;
    result.thickness.resize(points.size());
    if (surface) result.across.resize(points.size());
    result.ball.resize(points.size(), kNone);
    constexpr std::size_t kChunk = 1024;
    const std::size_t chunks = base::chunks_for(points.size(), kChunk);
    std::atomic<std::size_t> near{0};
    base::for_chunks(chunks, context, "surface", 0.1, 1, [&](std::size_t chunk) {
      const auto [first, last] = base::part_of(points.size(), chunk, chunks);
      for (std::size_t i = first; i < last; ++i) {
        const Vec3& p = points[i];
        if (surface) result.across[i] = p;
        if (!p.allFinite()) continue;
        std::size_t found = largest_at(tree, p, options.tolerance);
        if (found == tree.size()) {
          double limit = std::numeric_limits<double>::infinity();
          found = tree.nearest(p, limit);
          near.fetch_add(1, std::memory_order_relaxed);
        }
        if (found == tree.size()) continue;
        const axis::BallTree::Ball ball = tree.ball(found);
        result.ball[i] = ball.vertex;
        result.thickness[i] = 2 * (ball.radius + options.correction);
        if (!surface) continue;
        const axis::BallTree::Ball straight = tree.ball(straightest_at(tree, p, options.tolerance, found));
        result.across[i] = surface->nearest(end_of_diameter(p, straight)).point;
      }
    });
    result.near = near;
    return result;
  });
}

}  // namespace quench
