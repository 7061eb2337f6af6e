// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "graph/branch_measures.h"
#include "graph/segment_contacts.h"
#include "quench/error.h"
#include "quench/graph.h"

/// Notation: x a point, r a lower bound of its distance to the boundary. The square of a distance to any set, minus
/// |x|^2, is a minimum of affine functions, so concave: an average x = sum w_j x_j (w_j >= 0, sum 1) is at least
/// sqrt(sum w_j (r_j^2 - |x_j - x|^2)) away from it. All that is done here to points is such averaging.
namespace quench {
namespace {

/// Relative margin of every comparison that a promise depends on.
constexpr double kMargin = 1e-9;

/// A point and the square of its bound; negative where averaging has lost it.
struct Ball {
  Vec3 x;
  double r2;
};

Ball average(const Ball& a, const Ball& b, double t) {
  return {(1 - t) * a.x + t * b.x, (1 - t) * a.r2 + t * b.r2 - t * (1 - t) * (b.x - a.x).squaredNorm()};
}

/// Whether the bound stays above `gap` all along the segment between the two, so that it does not leave the shape.
bool is_inside(const Ball& a, const Ball& b, double gap) {
  const double l2 = (b.x - a.x).squaredNorm();
  const double t = l2 > 0 ? std::clamp((a.r2 - b.r2 + l2) / (2 * l2), 0.0, 1.0) : 0.0;
  const double least = std::min({a.r2, b.r2, average(a, b, t).r2});
  return least > gap * gap + kMargin * std::max({a.r2, b.r2, l2});
}

bool stays(const Ball& a, const Ball& b, const SmoothOptions& options) {
  return options.inside ? options.inside(a.x, b.x) : is_inside(a, b, options.gap);
}

std::vector<Ball> balls_of(const CurveGraph::Branch& branch) {
  std::vector<Ball> balls;
  for (std::size_t i = 0; i < branch.points.size(); ++i)
    balls.push_back({branch.points[i], branch.radius[i] * branch.radius[i]});
  return balls;
}

/// The largest bound at x that follows from the old polyline near its point `place`: the bound of a point there, less
/// the distance to it.
double bound_from(const std::vector<Ball>& old, std::size_t place, const Vec3& x) {
  constexpr std::size_t kReach = 8;
  double best = 0;
  for (std::size_t i = place > kReach ? place - kReach : 0; i + 1 < old.size() && i < place + kReach; ++i) {
    const Vec3 along = old[i + 1].x - old[i].x;
    const double l2 = along.squaredNorm();
    const double t = l2 > 0 ? std::clamp((x - old[i].x).dot(along) / l2, 0.0, 1.0) : 0.0;
    const Ball foot = average(old[i], old[i + 1], t);
    best = std::max(best, std::sqrt(std::max(foot.r2, 0.0)) - (x - foot.x).norm());
  }
  return best * (1 - kMargin);
}

/// The inner points, moved half way to the middle of their neighbours `iterations` times. (Towards the point of the
/// chord that keeps the ratio of the two segments, points that are close together would come closer with each
/// iteration.)
std::vector<Ball> moved(const std::vector<Ball>& old, const SmoothOptions& options) {
  std::vector<Ball> now = old, next = old;
  for (int i = 0; i < options.iterations; ++i) {
    for (std::size_t p = 1; p + 1 < now.size(); ++p) {
      Ball ball = average(now[p], average(now[p - 1], now[p + 1], 0.5), 0.5);
      // At most half the radius of the point's own ball.
      const double way = (ball.x - old[p].x).norm(), most = (1 - kMargin) * std::sqrt(old[p].r2) / 2;
      if (way > most) ball = average(old[p], ball, most / way);
      next[p] = ball;
    }
    now.swap(next);
  }
  // Averaging many times loses more than one comparison with the old polyline.
  for (std::size_t p = 1; p + 1 < now.size(); ++p) {
    const double other = bound_from(old, p, now[p].x);
    now[p].r2 = std::max(now[p].r2, other * other);
  }
  // Ends of segments that could leave the shape go back to where they were, until there is no such segment. Segments
  // between two points that went back, or never moved, are old ones.
  std::vector<char> back(now.size(), 0);
  back.front() = back.back() = 1;
  std::vector<std::size_t> check;
  for (std::size_t s = 0; s + 1 < now.size(); ++s) check.push_back(s);
  while (!check.empty()) {
    const std::size_t s = check.back();
    check.pop_back();
    if ((back[s] && back[s + 1]) || stays(now[s], now[s + 1], options)) continue;
    for (std::size_t p : {s, s + 1}) {
      if (back[p]) continue;
      back[p] = 1;
      now[p] = old[p];
      check.push_back(p - 1);
      check.push_back(p);
    }
  }
  return now;
}

/// Points at even distances along the polyline; where a chord between two of them could leave the shape, the corners of
/// the polyline it would cut off as well.
std::vector<Ball> resampled(const std::vector<Ball>& line, bool closed, const SmoothOptions& options) {
  std::vector<double> at(line.size(), 0);  // arc length
  for (std::size_t i = 1; i < line.size(); ++i) at[i] = at[i - 1] + (line[i].x - line[i - 1].x).norm();
  const double length = at.back();
  if (!(length > 0)) return line;
  // A closed branch needs a triangle at least. A tiny spacing must not fill the memory.
  const double most = 64.0 * static_cast<double>(line.size()) + 1024;
  const auto pieces = static_cast<std::size_t>(
      std::clamp(std::round(length / options.spacing), closed ? 3.0 : 1.0, std::max(most, 3.0)));
  std::vector<Ball> result{line.front()};
  std::size_t segment = 0;  // the last sample lies in line[segment], line[segment + 1]
  for (std::size_t k = 1; k <= pieces; ++k) {
    const double goal = length * static_cast<double>(k) / static_cast<double>(pieces);
    std::size_t next = segment;
    while (next + 2 < line.size() && at[next + 1] <= goal) ++next;
    const double piece = at[next + 1] - at[next];
    Ball sample = line.back();
    if (k < pieces) {
      // No sample on a segment along which the distance to the boundary is not known.
      if (!options.inside && !is_inside(line[next], line[next + 1], 0)) continue;
      sample = average(line[next], line[next + 1], piece > 0 ? std::clamp((goal - at[next]) / piece, 0.0, 1.0) : 0.0);
    }
    if (next > segment && !stays(result.back(), sample, options))
      for (std::size_t corner = segment + 1; corner <= next; ++corner)
        if (line[corner].x != result.back().x && line[corner].x != sample.x) result.push_back(line[corner]);
    if (sample.x != result.back().x || k == pieces) result.push_back(sample);
    segment = next;
  }
  if (closed && result.size() < 4) return line;
  return result;
}

/// How a branch is processed, from the most to the least.
enum class Processing : std::uint8_t { smooth_and_resample, smooth_only, none };

/// Radii of the old polyline at the same fraction of the length.
void interpolate_radii(const CurveGraph::Branch& old, CurveGraph::Branch& branch) {
  const auto arc = [](const std::vector<Vec3>& points) {
    std::vector<double> at(points.size(), 0);
    for (std::size_t i = 1; i < points.size(); ++i) at[i] = at[i - 1] + (points[i] - points[i - 1]).norm();
    return at;
  };
  const std::vector<double> from = arc(old.points), to = arc(branch.points);
  if (!(from.back() > 0 && to.back() > 0)) return;
  std::size_t s = 0;
  for (std::size_t i = 0; i < to.size(); ++i) {
    const double at = to[i] / to.back() * from.back();
    while (s + 2 < from.size() && from[s + 1] < at) ++s;
    const double piece = from[s + 1] - from[s], t = piece > 0 ? std::clamp((at - from[s]) / piece, 0.0, 1.0) : 0;
    branch.radius[i] = (1 - t) * old.radius[s] + t * old.radius[s + 1];
  }
}

CurveGraph::Branch processed(const CurveGraph::Branch& old, Processing processing, const SmoothOptions& options) {
  if (processing == Processing::none || old.points.size() < 2) return old;
  std::vector<Ball> line = balls_of(old);
  if (options.iterations > 0) line = moved(line, options);
  if (options.spacing > 0 && processing == Processing::smooth_and_resample)
    line = resampled(line, old.from == old.to, options);
  CurveGraph::Branch branch = old;
  branch.points.clear();
  branch.radius.clear();
  for (const Ball& ball : line) {
    branch.points.push_back(ball.x);
    branch.radius.push_back(std::sqrt(std::max(ball.r2, 0.0)));
  }
  if (options.inside || options.interpolated_radii) {
    const std::vector<double> bound = branch.radius;
    interpolate_radii(old, branch);
    // The truth is not below the bound: where the branch was moved much, interpolated radii are not far above it.
    if (options.gap > 0)
      for (std::size_t i = 0; i < bound.size(); ++i)
        branch.radius[i] = std::min(branch.radius[i], bound[i] + 2 * options.gap);
  }
  // Exactly those of the nodes, also in the last digit.
  branch.radius.front() = old.radius.front();
  branch.radius.back() = old.radius.back();
  graph::measure(branch);
  return branch;
}

class Smoother {
 public:
  Smoother(const CurveGraph& graph, const SmoothOptions& options)
      : old_(graph), options_(options), graph_(graph), processing_(graph.branches.size()) {}

  CurveGraph run() {
    for (std::size_t b = 0; b < processing_.size(); ++b) process(b, Processing::smooth_and_resample);
    for (std::vector<char> bad = touching(); std::find(bad.begin(), bad.end(), 1) != bad.end(); bad = touching())
      for (std::size_t b = 0; b < bad.size(); ++b)
        if (bad[b])
          process(b,
                  processing_[b] == Processing::smooth_and_resample && options_.iterations > 0 && options_.spacing > 0
                      ? Processing::smooth_only
                      : Processing::none);
    return std::move(graph_);
  }

 private:
  void process(std::size_t b, Processing processing) {
    processing_[b] = processing;
    graph_.branches[b] = processed(old_.branches[b], processing, options_);
  }

  /// Branches that touch another one, or themselves, and are not left as they were.
  std::vector<char> touching() const {
    std::vector<graph::NamedSegment> segments;
    std::vector<std::uint32_t> branch_of;
    std::uint64_t name = graph_.nodes.size();
    double largest = 0;
    for (std::uint32_t b = 0; b < graph_.branches.size(); ++b) {
      const CurveGraph::Branch& branch = graph_.branches[b];
      std::uint64_t last = branch.from;
      for (std::size_t i = 1; i < branch.points.size(); ++i) {
        const std::uint64_t next = i + 1 < branch.points.size() ? name++ : branch.to;
        segments.push_back({branch.points[i - 1], branch.points[i], {last, next}});
        branch_of.push_back(b);
        largest = std::max(largest, branch.points[i].cwiseAbs().maxCoeff());
        last = next;
      }
    }
    std::vector<char> bad(graph_.branches.size(), 0);
    const auto is_new = [&](std::uint32_t b) { return processing_[b] != Processing::none; };
    graph::for_each_contact(
        segments, 1e-12 * largest,
        [&](std::uint32_t i, std::uint32_t j) { return is_new(branch_of[i]) || is_new(branch_of[j]); },
        [&](std::uint32_t i, std::uint32_t j) {
          for (std::uint32_t b : {branch_of[i], branch_of[j]})
            if (is_new(b)) bad[b] = 1;
        });
    return bad;
  }

  const CurveGraph& old_;
  const SmoothOptions& options_;
  CurveGraph graph_;
  std::vector<Processing> processing_;
};

}  // namespace

double boundary_gap(const Vec3& spacing) {
  const double x = spacing[0] * spacing[0], y = spacing[1] * spacing[1], z = spacing[2] * spacing[2];
  return std::sqrt(std::max({x + y, y + z, z + x})) / 2;
}

CurveGraph smoothed(const CurveGraph& graph, const SmoothOptions& options) {
  const auto is_length = [](double value) { return std::isfinite(value) && value >= 0; };
  if (options.iterations < 0 || !is_length(options.spacing) || !is_length(options.gap))
    throw Error(ErrorCode::usage, "smoothing takes a number of iterations, a spacing and a gap of 0 or more");
  for (const CurveGraph::Branch& branch : graph.branches)
    if (branch.radius.size() != branch.points.size() ||
        !std::ranges::all_of(branch.points, [](const Vec3& x) { return x.allFinite(); }))
      throw Error(ErrorCode::usage, "a branch to smooth needs points with finite coordinates and a radius for each");
  if (options.iterations == 0 && options.spacing == 0) return graph;
  return Smoother(graph, options).run();
}

}  // namespace quench
