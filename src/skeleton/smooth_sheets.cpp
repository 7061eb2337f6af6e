// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "base/csr.h"
#include "base/parallel.h"
#include "quench/error.h"
#include "quench/skeleton.h"

namespace quench {
namespace {

// Edges by the number of their faces: borders of sheets are rims, of one face, and seams, of three or more.
enum class EdgeKind : char { curve, rim, inner, seam };

class SheetSmoother {
 public:
  SheetSmoother(Skeleton& skeleton, const SheetSmoothing& how, Context* context)
      : s_(skeleton), c_(skeleton.complex), how_(how), context_(context), kind_(c_.edges.size(), EdgeKind::curve) {
    std::vector<std::uint32_t> faces(c_.edges.size(), 0);
    for (const std::uint32_t e : c_.face_edges) ++faces[e];
    for (std::size_t e = 0; e < faces.size(); ++e)
      kind_[e] = faces[e] == 0   ? EdgeKind::curve
                 : faces[e] == 1 ? EdgeKind::rim
                 : faces[e] == 2 ? EdgeKind::inner
                                 : EdgeKind::seam;
    edges_at_ = base::Csr<std::uint32_t>::group(c_.vertex_count, [&](const auto& emit) {
      for (std::uint32_t e = 0; e < c_.edges.size(); ++e)
        for (const std::uint32_t v : c_.edges[e]) emit(v, e);
    });
    moved_ = s_.points;
  }

  void run() {
    smooth_borders(EdgeKind::rim);
    smooth_borders(EdgeKind::seam);
    smooth_insides();
    take_back_folds();
    for (std::size_t v = 0; v < moved_.size(); ++v) {
      s_.radius[v] -= (moved_[v] - s_.points[v]).norm();  // half of it at most
      s_.points[v] = moved_[v];
    }
    s_.smooth = how_.passes;
  }

 private:
  std::uint32_t other(std::uint32_t e, std::uint32_t v) const { return c_.edges[e][c_.edges[e][0] == v]; }

  // Whether a border goes on over the vertex: two of its edges are there, and nothing else but the inside of a sheet.
  bool goes_on(std::uint32_t v, EdgeKind kind) const {
    int of_kind = 0;
    for (const std::uint32_t e : edges_at_[v]) {
      of_kind += kind_[e] == kind;
      if (kind_[e] != kind && kind_[e] != EdgeKind::inner) return false;
    }
    return of_kind == 2;
  }
  std::uint32_t next_edge(std::uint32_t v, std::uint32_t before, EdgeKind kind) const {
    for (const std::uint32_t e : edges_at_[v])
      if (kind_[e] == kind && e != before) return e;
    return kNone;
  }

  void smooth_borders(EdgeKind kind) {
    std::vector<char> done(c_.edges.size(), 0);
    std::vector<std::uint32_t> line;
    const auto follow = [&](std::uint32_t v, std::uint32_t e) {
      line.assign(1, v);
      while (e != kNone && !done[e]) {
        done[e] = 1;
        v = other(e, v);
        line.push_back(v);
        e = goes_on(v, kind) ? next_edge(v, e, kind) : kNone;
      }
      smooth_line(line, line.front() == line.back() && goes_on(line.front(), kind));
    };
    // Open borders from their ends, then closed ones.
    for (const bool closed : {false, true})
      for (std::uint32_t e = 0; e < c_.edges.size(); ++e)
        for (const std::uint32_t v : c_.edges[e])
          if (kind_[e] == kind && !done[e] && (closed || !goes_on(v, kind))) follow(v, e);
  }

  // Every point goes to the mean of the line around it, weighted by 1 at the point falling to 0 at the window's ends.
  // The window of a point near an end of an open line is as short on its other side, and short beside a corner, where
  // the line before and behind has different directions.
  void smooth_line(const std::vector<std::uint32_t>& line, bool closed) {
    const std::size_t n = line.size();
    std::vector<double> at(n, 0);
    for (std::size_t i = 1; i < n; ++i) at[i] = at[i - 1] + (s_.points[line[i]] - s_.points[line[i - 1]]).norm();
    const double length = at.back();
    for (std::size_t i = closed ? 0 : 1; i + 1 < n; ++i) {
      double window = std::min(how_.window, closed ? length / 4 : std::min(at[i], length - at[i]));
      for (int halvings = 0; halvings < 4 && is_corner(line, at, i, window); ++halvings) window *= 0.5;
      if (!(window > 0)) continue;
      Vec3 sum = Vec3::Zero();
      double weights = 0;
      // Over the segments that the window meets: with the weight and the point in the middle of what it has of them.
      const auto take = [&](std::size_t a, std::size_t b, double from, double to) {
        const double low = std::max(from, -window), high = std::min(to, window), size = high - low;
        if (!(size > 0)) return;
        const double middle = 0.5 * (low + high), weight = size * (window - std::abs(middle));
        const double t = (middle - from) / (to - from);
        sum += weight * ((1 - t) * s_.points[line[a]] + t * s_.points[line[b]]);
        weights += weight;
      };
      for (std::size_t steps = 0, j = i; steps < n; ++steps) {
        if (j + 1 == n) {
          if (!closed) break;
          j = 0;
        }
        const double from = along(at, i, j, length, true);
        if (from >= window) break;
        take(j, j + 1, from, from + at[j + 1] - at[j]);
        ++j;
      }
      for (std::size_t steps = 0, j = i; steps < n; ++steps) {
        if (j == 0) {
          if (!closed) break;
          j = n - 1;
        }
        const double to = along(at, i, j, length, false);
        if (to <= -window) break;
        take(j - 1, j, to - (at[j] - at[j - 1]), to);
        --j;
      }
      move(line[i], sum / weights);
    }
  }
  // Whether the line turns by more than 40 degrees between the windows before and behind point i.
  bool is_corner(const std::vector<std::uint32_t>& line, const std::vector<double>& at, std::size_t i,
                 double window) const {
    const Vec3& point = s_.points[line[i]];
    const Vec3 before = point - place(line, at, at[i] - window), behind = place(line, at, at[i] + window) - point;
    return before.dot(behind) < 0.766 * before.norm() * behind.norm();
  }
  // The point of the line at a distance along it; of a closed one beyond its ends, too.
  Vec3 place(const std::vector<std::uint32_t>& line, const std::vector<double>& at, double distance) const {
    const double length = at.back();
    if (distance < 0) distance += length;
    if (distance > length) distance -= length;
    const auto next = static_cast<std::size_t>(std::upper_bound(at.begin(), at.end() - 1, distance) - at.begin());
    const std::size_t first = next == 0 ? 0 : next - 1, second = first + 1;
    const double step = at[second] - at[first], t = step > 0 ? (distance - at[first]) / step : 0;
    return (1 - t) * s_.points[line[first]] + t * s_.points[line[second]];
  }
  // Signed distance along the line from point i to point j, ahead or behind.
  static double along(const std::vector<double>& at, std::size_t i, std::size_t j, double length, bool ahead) {
    const double d = at[j] - at[i];
    if (ahead) return d < 0 ? d + length : d;
    return d > 0 ? d - length : d;
  }

  // Vertices inside a sheet move along its normal towards the mean of their neighbours.
  void smooth_insides() {
    std::vector<char> inside(c_.vertex_count, 1);
    for (std::size_t e = 0; e < kind_.size(); ++e)
      if (kind_[e] != EdgeKind::inner)
        for (const std::uint32_t v : c_.edges[e]) inside[v] = 0;
    std::vector<Vec3> normal(c_.vertex_count, Vec3::Zero()), next;
    for (std::size_t f = 0; f < c_.face_count(); ++f) {
      const auto corners = c_.corners(f);
      Vec3 area = Vec3::Zero();
      for (std::size_t i = 2; i < corners.size(); ++i)
        area +=
            (s_.points[corners[i - 1]] - s_.points[corners[0]]).cross(s_.points[corners[i]] - s_.points[corners[0]]);
      for (const std::uint32_t v : corners) normal[v] += normal[v].dot(area) < 0 ? Vec3(-area) : area;
    }
    for (int pass = 0; pass < how_.passes; ++pass) {
      checkpoint(context_, "smooth", static_cast<double>(pass) / how_.passes);
      next = moved_;
      base::for_indices(c_.vertex_count, [&](std::size_t i) {
        const auto v = static_cast<std::uint32_t>(i);
        if (!inside[v] || edges_at_[v].empty() || !(normal[v].norm() > 0)) return;
        Vec3 mean = Vec3::Zero();
        for (const std::uint32_t e : edges_at_[v]) mean += moved_[other(e, v)];
        mean /= static_cast<double>(edges_at_[v].size());
        const Vec3 n = normal[v].normalized();
        next[v] = bounded(v, moved_[v] + 0.5 * n.dot(mean - moved_[v]) * n);
      });
      moved_.swap(next);
    }
  }

  // Polygons that can be seen whole from their middle can be so afterwards: where one could not, its corners go half of
  // their way back, in the end all of it.
  void take_back_folds() {
    std::vector<std::uint32_t> open(c_.face_count());
    std::iota(open.begin(), open.end(), 0u);
    std::erase_if(open, [&](std::uint32_t f) { return is_folded(f, s_.points); });
    std::vector<std::uint32_t> check = open;
    constexpr int kHalvings = 4;
    for (int round = 0; !check.empty(); ++round) {
      std::vector<char> back(c_.vertex_count, 0);
      for (const std::uint32_t f : check)
        if (is_folded(f, moved_))
          for (const std::uint32_t v : c_.corners(f)) back[v] = moved_[v] != s_.points[v];
      for (std::size_t v = 0; v < back.size(); ++v)
        if (back[v]) moved_[v] = round < kHalvings ? Vec3(0.5 * (moved_[v] + s_.points[v])) : s_.points[v];
      check = open;
      std::erase_if(check, [&](std::uint32_t f) {
        const auto corners = c_.corners(f);
        return std::none_of(corners.begin(), corners.end(), [&](std::uint32_t v) { return back[v]; });
      });
    }
  }
  bool is_folded(std::uint32_t f, const std::vector<Vec3>& at) const {
    const auto corners = c_.corners(f);
    const std::size_t n = corners.size();
    Vec3 middle = Vec3::Zero(), normal = Vec3::Zero();
    for (const std::uint32_t v : corners) middle += at[v] / static_cast<double>(n);
    const auto piece = [&](std::size_t i) -> Vec3 {
      return (at[corners[i]] - middle).cross(at[corners[i + 1 == n ? 0 : i + 1]] - middle);
    };
    for (std::size_t i = 0; i < n; ++i) normal += piece(i);
    for (std::size_t i = 0; i < n; ++i)
      if (!(normal.dot(piece(i)) > 0)) return true;
    return false;
  }

  void move(std::uint32_t v, const Vec3& to) { moved_[v] = bounded(v, to); }
  Vec3 bounded(std::uint32_t v, const Vec3& to) const {
    const double way = (to - s_.points[v]).norm(), most = std::min(how_.most, 0.5 * s_.radius[v]);
    return way > most ? Vec3(s_.points[v] + (to - s_.points[v]) * (most / way)) : to;
  }

  Skeleton& s_;
  const CellComplex& c_;
  const SheetSmoothing& how_;
  Context* context_;
  std::vector<EdgeKind> kind_;
  base::Csr<std::uint32_t> edges_at_;
  std::vector<Vec3> moved_;
};

}  // namespace

void smooth_sheets(Skeleton& skeleton, const SheetSmoothing& how, Context* context) {
  if (!(how.window >= 0) || !(how.most >= 0) || how.passes < 0)
    throw Error(ErrorCode::usage, "how sheets are smoothed must not be negative");
  SheetSmoother(skeleton, how, context).run();
}

}  // namespace quench
