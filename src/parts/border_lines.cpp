// SPDX-License-Identifier: Apache-2.0
#include "parts/border_lines.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "base/csr.h"
#include "base/union_find.h"
#include "parts/cut_sheets.h"

namespace quench::parts {

SheetPoint BorderLine::place(double along) const {
  const auto next = static_cast<std::size_t>(std::upper_bound(at.begin() + 1, at.end() - 1, along) - at.begin());
  const double step = at[next] - at[next - 1];
  const double t = step > 0 ? std::clamp((along - at[next - 1]) / step, 0.0, 1.0) : 0;
  return mixed(points[next - 1], points[next], t);
}

namespace {

struct BorderEdge {
  std::uint32_t a, b;
  std::int32_t seam;
};

class LineTracer {
 public:
  LineTracer(const SheetMesh& mesh, double corner) : mesh_(mesh), corner_(corner) {
    const std::vector<TriangleSide> sides = sorted_sides(mesh.triangles);
    std::map<std::array<std::uint32_t, 2>, std::int32_t> seam;
    for (std::size_t e = 0; e < mesh.seam_edges.size(); ++e) {
      const auto [a, b] = std::minmax(mesh.seam_edges[e][0], mesh.seam_edges[e][1]);
      seam[{a, b}] = mesh.seam[e];
    }
    each_edge(sides, [&](std::span<const TriangleSide> at) {
      if (at.size() == 2) return;
      const auto found = seam.find({at[0].a, at[0].b});
      edges_.push_back({at[0].a, at[0].b, found == seam.end() ? -1 : found->second});
    });
    edges_at_ = base::Csr<std::uint32_t>::group(mesh.points.size(), [&](const auto& emit) {
      for (std::uint32_t e = 0; e < edges_.size(); ++e) emit(edges_[e].a, e), emit(edges_[e].b, e);
    });
    find_irregular(cut_sheets(mesh.triangles, sides));
  }

  BorderLines run() {
    // Lines between what must be fixed; then again between their corners.
    trace();
    bool any = false;
    for (const BorderLine& line : result_.lines) any = fix_corners(line) || any;
    if (any) trace();
    for (BorderLine& line : result_.lines)
      if (line.seam < 0) line = smoothed_rim(line);
    return std::move(result_);
  }

 private:
  // Inside a sheet there is one fan, at a border one from edge to edge for each sheet that meets it there.
  void find_irregular(const CutSheets& cut) {
    result_.fixed.assign(mesh_.points.size(), 0);
    for (const std::uint32_t v : mesh_.fixed) result_.fixed[v] = 1;
    std::vector<std::uint32_t> fans(mesh_.points.size(), 0);
    for (const std::uint32_t c : cut.corner_of) ++fans[mesh_.triangles[c / 3][c % 3]];
    std::vector<std::uint32_t> sides_at(edges_.size(), 0);
    std::map<std::array<std::uint32_t, 2>, std::uint32_t> row;
    for (std::uint32_t e = 0; e < edges_.size(); ++e) row[{edges_[e].a, edges_[e].b}] = e;
    // Per fan at a border: which two edges it goes between.
    std::vector<std::array<std::uint32_t, 2>> between(cut.vertices, {kNone, kNone});
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t)
      for (std::uint32_t i = 0; i < 3; ++i) {
        const std::uint32_t from = 3 * t + i, to = 3 * t + (i + 1) % 3;
        const auto [a, b] = std::minmax(mesh_.triangles[t][i], mesh_.triangles[t][(i + 1) % 3]);
        if (edges_at_[a].empty() || edges_at_[b].empty()) continue;
        const auto found = row.find({a, b});
        if (found == row.end()) continue;
        ++sides_at[found->second];
        for (const std::uint32_t corner : {from, to}) {
          auto& ends = between[cut.vertex[corner]];
          ends[ends[0] != kNone] = found->second;
        }
      }
    for (std::uint32_t v = 0; v < mesh_.points.size(); ++v) {
      const auto edges = edges_at_[v];
      if (edges.empty()) {
        if (fans[v] > 1) result_.fixed[v] = 1;
        continue;
      }
      if (edges.size() != 2 || edges_[edges[0]].seam != edges_[edges[1]].seam ||
          sides_at[edges[0]] != sides_at[edges[1]] || fans[v] != sides_at[edges[0]])
        result_.fixed[v] = 1;
    }
    for (std::uint32_t i = 0; i < cut.vertices; ++i) {
      const auto& ends = between[i];
      const std::uint32_t v = mesh_.triangles[cut.corner_of[i] / 3][cut.corner_of[i] % 3];
      if (!edges_at_[v].empty() && ends[0] == ends[1]) result_.fixed[v] = 1;  // also a fan without border
    }
  }

  void trace() {
    result_.lines.clear();
    std::vector<char> done(edges_.size(), 0);
    const auto follow = [&](std::uint32_t v, std::uint32_t e) {
      BorderLine line;
      line.seam = edges_[e].seam;
      append(line, v);
      while (!done[e]) {
        done[e] = 1;
        v = edges_[e].a == v ? edges_[e].b : edges_[e].a;
        append(line, v);
        if (result_.fixed[v]) break;
        e = edges_at_[v][edges_at_[v][0] == e];
      }
      result_.lines.push_back(std::move(line));
    };
    for (std::uint32_t e = 0; e < edges_.size(); ++e)
      for (const std::uint32_t v : {edges_[e].a, edges_[e].b})
        if (!done[e] && result_.fixed[v]) follow(v, e);
    for (std::uint32_t e = 0; e < edges_.size(); ++e) {  // closed ones
      if (done[e]) continue;
      result_.fixed[edges_[e].a] = 1;
      follow(edges_[e].a, e);
    }
  }
  void append(BorderLine& line, std::uint32_t v) const {
    line.at.push_back(line.at.empty() ? 0 : line.at.back() + (mesh_.points[v] - line.points.back().point).norm());
    line.vertices.push_back(v);
    line.points.push_back({mesh_.points[v], mesh_.radius[v], mesh_.erosion.empty() ? 0 : mesh_.erosion[v]});
  }

  // Every point becomes the mean of the line over a length to both sides, weighted by a hat; near an end over as much
  // as there is to it.
  std::vector<SheetPoint> means(const BorderLine& line, const std::vector<SheetPoint>& of) const {
    std::vector<SheetPoint> mean = of;
    for (std::size_t i = 1; i + 1 < of.size(); ++i) {
      const double window = std::min({corner_, line.at[i], line.length() - line.at[i]});
      SheetPoint sum;
      double weights = 0;
      const auto take = [&](std::size_t k) {
        // Of the segment from k to k + 1 what the window has, with the weight and the place in the middle of it.
        const double size = line.at[k + 1] - line.at[k];
        const double low = std::max(line.at[k] - line.at[i], -window),
                     high = std::min(line.at[k + 1] - line.at[i], window);
        if (!(high > low) || !(size > 0)) return;
        const double middle = 0.5 * (low + high), weight = (high - low) * (window - std::abs(middle));
        const SheetPoint there = mixed(of[k], of[k + 1], (middle + line.at[i] - line.at[k]) / size);
        sum.point += weight * there.point;
        sum.radius += weight * there.radius;
        if (std::isfinite(there.erosion)) sum.erosion += weight * there.erosion;
        weights += weight;
      };
      for (std::size_t k = i; k + 1 < of.size() && line.at[k] - line.at[i] < window; ++k) take(k);
      for (std::size_t k = i; k-- > 0 && line.at[i] - line.at[k + 1] < window;) take(k);
      if (weights > 0) mean[i] = {sum.point / weights, sum.radius / weights, sum.erosion / weights};
    }
    return mean;
  }
  // Means, and the means of what these leave added: so a bend stays where it is, and a ragged rim becomes smooth. By no
  // more than half a length or half the radius.
  BorderLine smoothed_rim(const BorderLine& line) const {
    if (line.vertices.size() < 3) return line;
    const std::vector<SheetPoint> first = means(line, line.points);
    std::vector<SheetPoint> rest = line.points;
    for (std::size_t i = 0; i < rest.size(); ++i) rest[i].point -= first[i].point;
    rest = means(line, rest);
    BorderLine smooth = line;
    for (std::size_t i = 1; i + 1 < rest.size(); ++i) {
      Vec3 step = first[i].point + rest[i].point - line.points[i].point;
      const double most = 0.5 * std::min(corner_, std::max(0.0, line.points[i].radius));
      if (const double size = step.norm(); size > most) step *= most / size;
      smooth.points[i] = {line.points[i].point + step, first[i].radius, first[i].erosion};
    }
    for (std::size_t i = 1; i < rest.size(); ++i)
      smooth.at[i] = smooth.at[i - 1] + (smooth.points[i].point - smooth.points[i - 1].point).norm();
    return smooth;
  }

  // The point that is farthest from the chord around a corner, half a length to both sides of it.
  std::size_t tip(const BorderLine& line, std::size_t corner) const {
    const double at = line.at[corner], reach = std::min({corner_, at, line.length() - at});
    const Vec3 from = line.place(at - reach).point, chord = line.place(at + reach).point - from;
    std::size_t best = corner;
    double most = 0;
    for (std::size_t i = 1; i + 1 < line.vertices.size(); ++i) {
      if (std::abs(line.at[i] - at) > 0.5 * corner_) continue;
      Vec3 off = line.points[i].point - from;
      if (const double size = chord.squaredNorm(); size > 0) off -= off.dot(chord) / size * chord;
      if (off.norm() > most) best = i, most = off.norm();
    }
    return best;
  }

  // Where a line turns most, if it turns by more than 50 degrees between chords as long as `corner_`, or as the line
  // has to the nearer end. True where something is fixed.
  bool fix_corners(const BorderLine& traced) {
    constexpr double kTurn = 0.643;  // cos 50 degrees
    BorderLine line = traced;
    line.points = means(traced, traced.points);  // a ragged rim has no corners
    const std::size_t n = line.vertices.size();
    std::vector<double> turn(n, 2);
    for (std::size_t i = 1; i + 1 < n; ++i) {
      const double reach = std::min({corner_, line.at[i], line.length() - line.at[i]});
      if (reach < 0.5 * corner_) continue;
      const Vec3 before = line.points[i].point - line.place(line.at[i] - reach).point,
                 behind = line.place(line.at[i] + reach).point - line.points[i].point;
      const double size = before.norm() * behind.norm();
      if (size > 0) turn[i] = before.dot(behind) / size;
    }
    bool any = false;
    for (std::size_t i = 1; i + 1 < n; ++i) {
      if (turn[i] > kTurn) continue;
      bool least = true;
      for (std::size_t j = i; least && j-- > 1 && line.at[i] - line.at[j] < corner_;) least = turn[j] > turn[i];
      for (std::size_t j = i + 1; least && j + 1 < n && line.at[j] - line.at[i] < corner_; ++j)
        least = turn[j] >= turn[i];
      if (!least) continue;
      result_.fixed[traced.vertices[tip(traced, i)]] = 1;
      any = true;
    }
    return any;
  }

  const SheetMesh& mesh_;
  double corner_;
  std::vector<BorderEdge> edges_;
  base::Csr<std::uint32_t> edges_at_;
  BorderLines result_;
};

}  // namespace

BorderLines border_lines(const SheetMesh& mesh, double corner) { return LineTracer(mesh, corner).run(); }

}  // namespace quench::parts
