// SPDX-License-Identifier: Apache-2.0
#include "graph/segment_contacts.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace quench::graph {
namespace {

double point_segment_distance(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 along = b - a;
  const double square = along.squaredNorm();
  const double t = square > 0 ? std::clamp((p - a).dot(along) / square, 0.0, 1.0) : 0.0;
  return (a + t * along - p).norm();
}

}  // namespace

double segment_distance(const Vec3& a0, const Vec3& a1, const Vec3& b0, const Vec3& b1) {
  // The least distance is at an end of one of them, or inside both, where it is the distance of the lines.
  double least = std::min({point_segment_distance(a0, b0, b1), point_segment_distance(a1, b0, b1),
                           point_segment_distance(b0, a0, a1), point_segment_distance(b1, a0, a1)});
  const Vec3 u = a1 - a0, v = b1 - b0, w = a0 - b0;
  const double uu = u.dot(u), uv = u.dot(v), vv = v.dot(v), uw = u.dot(w), vw = v.dot(w);
  const double det = uu * vv - uv * uv;
  if (!(det > 0)) return least;
  const double s = (uv * vw - vv * uw) / det, t = (uu * vw - uv * uw) / det;
  if (s >= 0 && s <= 1 && t >= 0 && t <= 1) least = std::min(least, (w + s * u - t * v).norm());
  return least;
}

bool in_contact(const NamedSegment& s, const NamedSegment& t, double tolerance) {
  const auto shares = [&](int i, int j) { return s.ends[i] == t.ends[j]; };
  const int common = shares(0, 0) + shares(0, 1) + shares(1, 0) + shares(1, 1);
  if (common == 0) return segment_distance(s.a, s.b, t.a, t.b) <= tolerance;
  if (common > 1) return true;
  // Two segments from one point meet again exactly when the end of the shorter one lies on the other.
  const bool first = shares(0, 0) || shares(0, 1), second = shares(0, 0) || shares(1, 0);
  const Vec3 &s_far = first ? s.b : s.a, &t_far = second ? t.b : t.a;
  return std::min(point_segment_distance(s_far, t.a, t.b), point_segment_distance(t_far, s.a, s.b)) <= tolerance;
}

void for_each_contact(const std::vector<NamedSegment>& segments, double tolerance,
                      const std::function<bool(std::uint32_t, std::uint32_t)>& wanted,
                      const std::function<void(std::uint32_t, std::uint32_t)>& found) {
  if (segments.empty()) return;
  double total = 0;
  Vec3 low = segments[0].a, high = low;
  for (const NamedSegment& s : segments) {
    total += (s.b - s.a).norm();
    low = low.cwiseMin(s.a).cwiseMin(s.b);
    high = high.cwiseMax(s.a).cwiseMax(s.b);
  }
  // 2^20 cells a side at most, so that three cell numbers fit a word.
  const double side = (high - low).maxCoeff() + 2 * tolerance;
  const double cell = std::max({total / static_cast<double>(segments.size()), 4 * tolerance, side / 0xffffe, 1e-300});
  const auto index = [&](double x, int axis) {
    return static_cast<std::uint64_t>(std::max(0.0, (x - low[axis]) / cell) + (tolerance > 0 ? 1 : 0));
  };
  // Long segments go in piece by piece: 2 n pieces at most.
  std::vector<std::pair<std::uint64_t, std::uint32_t>> entries;
  for (std::uint32_t i = 0; i < segments.size(); ++i) {
    const NamedSegment& s = segments[i];
    const int pieces = std::max(1, static_cast<int>(std::ceil((s.b - s.a).norm() / cell)));
    for (int p = 0; p < pieces; ++p) {
      const Vec3 from = s.a + (s.b - s.a) * (static_cast<double>(p) / pieces),
                 to = s.a + (s.b - s.a) * (static_cast<double>(p + 1) / pieces);
      std::array<std::uint64_t, 3> begin, end;
      for (int axis = 0; axis < 3; ++axis) {
        begin[axis] = index(std::min(from[axis], to[axis]) - tolerance, axis);
        end[axis] = index(std::max(from[axis], to[axis]) + tolerance, axis);
      }
      for (std::uint64_t z = begin[2]; z <= end[2]; ++z)
        for (std::uint64_t y = begin[1]; y <= end[1]; ++y)
          for (std::uint64_t x = begin[0]; x <= end[0]; ++x) entries.push_back({(z << 42) | (y << 21) | x, i});
    }
  }
  std::sort(entries.begin(), entries.end());
  entries.erase(std::unique(entries.begin(), entries.end()), entries.end());
  for (std::size_t begin = 0, end = 0; begin < entries.size(); begin = end) {
    while (end < entries.size() && entries[end].first == entries[begin].first) ++end;
    for (std::size_t a = begin; a < end; ++a)
      for (std::size_t b = a + 1; b < end; ++b) {
        const std::uint32_t i = entries[a].second, j = entries[b].second;
        if (wanted(i, j) && in_contact(segments[i], segments[j], tolerance)) found(i, j);
      }
  }
}

}  // namespace quench::graph
