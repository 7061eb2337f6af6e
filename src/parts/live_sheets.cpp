// SPDX-License-Identifier: Apache-2.0
#include "parts/live_sheets.h"

#include <tbb/parallel_sort.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <tuple>

namespace quench::parts {

LiveSheets::LiveSheets(const SheetMesh& mesh, const BorderLines& lines)
    : lines_(lines),
      kind_(mesh.points.size(), Kind::inner),
      triangles_at_(mesh.points.size()),
      links_(mesh.points.size()),
      triangles_(mesh.triangles),
      sheet_(mesh.sheet),
      mark_(mesh.points.size(), 0) {
  points_.reserve(mesh.points.size());
  for (std::size_t v = 0; v < mesh.points.size(); ++v)
    points_.push_back({mesh.points[v], mesh.radius[v], mesh.erosion.empty() ? 0 : mesh.erosion[v]});
  for (std::uint32_t t = 0; t < triangles_.size(); ++t)
    for (const std::uint32_t v : triangles_[t]) triangles_at_[v].push_back(t);
  for (std::size_t l = 0; l < lines.lines.size(); ++l) {
    const BorderLine& line = lines.lines[l];
    for (std::size_t i = 0; i + 1 < line.vertices.size(); ++i) {
      const std::uint32_t a = line.vertices[i], b = line.vertices[i + 1];
      links_[a].push_back({b, static_cast<std::int32_t>(l), line.at[i], line.at[i + 1]});
      links_[b].push_back({a, static_cast<std::int32_t>(l), line.at[i + 1], line.at[i]});
      kind_[a] = kind_[b] = Kind::border;
    }
  }
  for (std::size_t v = 0; v < kind_.size(); ++v)
    if (lines.fixed[v]) kind_[v] = Kind::fixed;
}

const LiveSheets::Link* LiveSheets::link(std::uint32_t a, std::uint32_t b) const {
  for (const Link& l : links_[a])
    if (l.to == b) return &l;
  return nullptr;
}

bool LiveSheets::has_edge(std::uint32_t a, std::uint32_t b) const {
  return std::ranges::any_of(triangles_at_[a],
                             [&](std::uint32_t t) { return std::ranges::count(triangles_[t], b) > 0; });
}

bool LiveSheets::adjacent(std::uint32_t a, std::uint32_t b) const { return has_edge(a, b); }

bool LiveSheets::has_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
  return std::ranges::any_of(triangles_at_[a], [&](std::uint32_t t) {
    return std::ranges::count(triangles_[t], b) > 0 && std::ranges::count(triangles_[t], c) > 0;
  });
}

void LiveSheets::find_triangles(std::uint32_t a, std::uint32_t b, std::vector<std::uint32_t>& found) const {
  found.clear();
  for (const std::uint32_t t : triangles_at_[a])
    if (std::ranges::count(triangles_[t], b) > 0) found.push_back(t);
}

std::uint32_t LiveSheets::third(std::uint32_t t, std::uint32_t a, std::uint32_t b) const {
  for (const std::uint32_t v : triangles_[t])
    if (v != a && v != b) return v;
  return kNone;
}

Vec3 LiveSheets::area(std::uint32_t t) const {
  const auto& [a, b, c] = triangles_[t];
  return (at(b) - at(a)).cross(at(c) - at(a));
}

Vec3 LiveSheets::area_with(std::uint32_t t, std::uint32_t v, const Vec3& to) const {
  const auto& corners = triangles_[t];
  const std::size_t i = corners[0] == v ? 0 : corners[1] == v ? 1 : 2;
  return (at(corners[(i + 1) % 3]) - to).cross(at(corners[(i + 2) % 3]) - to);
}

// 1 of an equilateral triangle, 0 of one without area.
double LiveSheets::quality_with(std::uint32_t t, std::uint32_t v, const Vec3& to) const {
  const auto& corners = triangles_[t];
  const std::size_t i = corners[0] == v ? 0 : corners[1] == v ? 1 : 2;
  const Vec3 b = at(corners[(i + 1) % 3]) - to, c = at(corners[(i + 2) % 3]) - to;
  const double sides = b.squaredNorm() + c.squaredNorm() + (b - c).squaredNorm();
  return sides > 0 ? 2 * std::sqrt(3.0) * b.cross(c).norm() / sides : 0;
}

void LiveSheets::detach(std::uint32_t t, std::uint32_t v) {
  auto& list = triangles_at_[v];
  list.erase(std::ranges::find(list, t));
}

std::uint32_t LiveSheets::split(std::uint32_t a, std::uint32_t b, const SheetPoint& place) {
  const auto m = static_cast<std::uint32_t>(points_.size());
  points_.push_back(place);
  kind_.push_back(Kind::inner);
  triangles_at_.emplace_back();
  links_.emplace_back();
  mark_.push_back(0);
  if (const Link* border = link(a, b)) {
    const Link whole = *border;
    const double along = 0.5 * (whole.at + whole.to_at);
    points_[m] = lines_.lines[static_cast<std::size_t>(whole.line)].place(along);
    kind_[m] = Kind::border;
    const auto shorten = [&](std::uint32_t from, std::uint32_t to) {
      for (Link& l : links_[from])
        if (l.to == to) {
          l.to = m;
          l.to_at = along;
          links_[m].push_back({from, l.line, along, l.at});
        }
    };
    shorten(a, b);
    shorten(b, a);
  }
  find_triangles(a, b, found_);
  for (const std::uint32_t t : found_) {
    const auto half = static_cast<std::uint32_t>(triangles_.size());
    triangles_.push_back(triangles_[t]);
    sheet_.push_back(sheet_[t]);
    std::ranges::replace(triangles_[t], b, m);
    std::ranges::replace(triangles_[half], a, m);
    detach(t, b);
    triangles_at_[b].push_back(half);
    triangles_at_[third(t, a, m)].push_back(half);
    triangles_at_[m].push_back(t);
    triangles_at_[m].push_back(half);
  }
  return m;
}

void LiveSheets::mark(std::uint32_t around) {
  ++marked_;
  for (const std::uint32_t t : triangles_at_[around])
    for (const std::uint32_t v : triangles_[t]) mark_[v] = marked_;
}

// The link conditions of Dey, Edelsbrunner, Guha and Nekhayev (1999): of the complex, and of its borders.
bool LiveSheets::keeps_topology(std::uint32_t gone, std::uint32_t kept, bool border) {
  if (border)
    for (const Link& l : links_[gone])
      if (l.to != kept && link(kept, l.to)) return false;
  mark(gone);
  others_.clear();  // neighbours of both
  for (const std::uint32_t t : triangles_at_[kept])
    for (const std::uint32_t v : triangles_[t])
      if (v != gone && v != kept && mark_[v] == marked_) others_.push_back(v);
  std::ranges::sort(others_);
  others_.erase(std::unique(others_.begin(), others_.end()), others_.end());
  if (others_.size() != found_.size()) return false;
  for (const std::uint32_t t : triangles_at_[gone]) {
    std::array<std::uint32_t, 2> opposite{kNone, kNone};
    for (const std::uint32_t v : triangles_[t])
      if (v != gone) opposite[opposite[0] != kNone] = v;
    if (opposite[0] == kept || opposite[1] == kept) continue;
    if (std::ranges::binary_search(others_, opposite[0]) && std::ranges::binary_search(others_, opposite[1]) &&
        has_triangle(kept, opposite[0], opposite[1]))
      return false;
  }
  return true;
}

// Whether the triangles at a vertex, but for those of the edge to `but`, stay the way they look, no slivers and small.
bool LiveSheets::may_move(std::uint32_t v, std::uint32_t but, const Vec3& to, double longest) const {
  constexpr double kTurn = 0.5;  // cosine: triangles turn by less than 60 degrees
  for (const std::uint32_t t : triangles_at_[v]) {
    if (std::ranges::count(triangles_[t], but) > 0) continue;
    const Vec3 before = area(t), behind = area_with(t, v, to);
    if (!(before.dot(behind) > kTurn * before.norm() * behind.norm())) return false;
    if (quality_with(t, v, to) < std::min(0.2, 0.5 * quality_with(t, v, at(v)))) return false;
    for (const std::uint32_t other : triangles_[t])
      if (other != v && (at(other) - to).norm() > longest) return false;
  }
  return true;
}

void LiveSheets::place_on_line(std::uint32_t v, double along) {
  for (Link& l : links_[v]) {
    l.at = along;
    for (Link& back : links_[l.to])
      if (back.to == v) back.to_at = along;
  }
}

bool LiveSheets::collapse(std::uint32_t gone, std::uint32_t kept, double longest, const SheetPoint& place,
                          double along) {
  if (kind_[gone] != kind_[kept] || kind_[kept] == Kind::fixed) return false;
  if (!may_move(kept, gone, place.point, longest)) return false;
  const SheetPoint before = points_[kept];
  points_[kept] = place;
  if (!collapse(gone, kept, longest)) {
    points_[kept] = before;
    return false;
  }
  if (kind_[kept] == Kind::border) place_on_line(kept, along);
  return true;
}

bool LiveSheets::collapse(std::uint32_t gone, std::uint32_t kept, double longest) {
  if (kind_[gone] == Kind::fixed) return false;
  const Link* border = link(gone, kept);
  if (kind_[gone] == Kind::border && !border) return false;
  find_triangles(gone, kept, found_);
  if (found_.empty() || !keeps_topology(gone, kept, border) || !may_move(gone, kept, at(kept), longest)) return false;
  if (border) {
    Link beyond{};  // the other neighbour of `gone` on the line
    for (const Link& l : links_[gone])
      if (l.to != kept) beyond = l;
    for (Link& l : links_[kept])
      if (l.to == gone) l.to = beyond.to, l.to_at = beyond.to_at, beyond.at = l.at;
    for (Link& l : links_[beyond.to])
      if (l.to == gone) l.to = kept, l.to_at = beyond.at;
    links_[gone].clear();
  }
  for (const std::uint32_t t : found_) {
    for (const std::uint32_t v : triangles_[t]) detach(t, v);
    triangles_[t][0] = kNone;
  }
  for (const std::uint32_t t : triangles_at_[gone]) {
    std::ranges::replace(triangles_[t], gone, kept);
    triangles_at_[kept].push_back(t);
  }
  triangles_at_[gone].clear();
  return true;
}

bool LiveSheets::flip(std::uint32_t a, std::uint32_t b) {
  if (link(a, b)) return false;
  find_triangles(a, b, found_);
  if (found_.size() != 2) return false;
  const std::uint32_t s = found_[0], t = found_[1], c = third(s, a, b), d = third(t, a, b);
  if (c == d || has_edge(c, d)) return false;
  const auto cosine = [&](std::uint32_t p, std::uint32_t q, std::uint32_t r) {  // of the angle at p
    const Vec3 u = at(q) - at(p), v = at(r) - at(p);
    const double size = u.norm() * v.norm();
    return size > 0 ? std::clamp(u.dot(v) / size, -1.0, 1.0) : 1.0;
  };
  constexpr double kPi = 3.14159265358979323846;
  if (!(std::acos(cosine(c, a, b)) + std::acos(cosine(d, a, b)) > kPi + 1e-6)) return false;
  // Seen from c's side: a, b go one way round in s and the other way in t, where both are turned alike.
  const Vec3 of_s = (at(b) - at(a)).cross(at(c) - at(a)), of_t = (at(d) - at(a)).cross(at(b) - at(a));
  const Vec3 of_a = (at(d) - at(a)).cross(at(c) - at(a)), of_b = (at(c) - at(b)).cross(at(d) - at(b));
  constexpr double kPlane = 0.8;
  const Vec3 mean = (of_s + of_t).normalized();
  if (!(mean.dot(of_a) > kPlane * of_a.norm()) || !(mean.dot(of_b) > kPlane * of_b.norm())) return false;
  if (mean.dot(of_s) < 0 || mean.dot(of_t) < 0) return false;
  // s keeps a, t keeps b; each is turned as it was.
  std::ranges::replace(triangles_[s], b, d);
  std::ranges::replace(triangles_[t], a, c);
  detach(s, b);
  detach(t, a);
  triangles_at_[d].push_back(s);
  triangles_at_[c].push_back(t);
  return true;
}

bool LiveSheets::move(std::uint32_t v, const SheetPoint& to, double along) {
  constexpr double kTurn = 0.7;
  double worst = 1, worst_then = 1;
  for (const std::uint32_t t : triangles_at_[v]) {
    const Vec3 before = area(t), behind = area_with(t, v, to.point);
    if (before.squaredNorm() > 0 && !(before.dot(behind) > kTurn * before.norm() * behind.norm())) return false;
    worst = std::min(worst, quality_with(t, v, at(v)));
    worst_then = std::min(worst_then, quality_with(t, v, to.point));
  }
  if (worst_then < std::min(worst, 0.3)) return false;
  points_[v] = to;
  place_on_line(v, along);
  return true;
}

LiveSheets::OnLine LiveSheets::on_line(std::uint32_t v) const {
  const Link &first = links_[v][0], &second = links_[v][1];
  return {first.line, first.at, first.to_at, second.to_at};
}

LiveSheets::OnLine LiveSheets::middle(std::uint32_t a, std::uint32_t b) const {
  const Link* l = link(a, b);
  return l ? OnLine{l->line, 0.5 * (l->at + l->to_at), l->at, l->to_at} : OnLine{};
}

std::vector<LiveSheets::LiveEdge> LiveSheets::edges(double least, double most) const {
  std::vector<LiveEdge> found;
  for (const auto& corners : triangles_) {
    if (corners[0] == kNone) continue;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [a, b] = std::minmax(corners[i], corners[(i + 1) % 3]);
      if (const double l = length(a, b); l >= least && l <= most) found.push_back({l, a, b});
    }
  }
  tbb::parallel_sort(found, [](const LiveEdge& x, const LiveEdge& y) {
    return std::tie(x.length, x.a, x.b) < std::tie(y.length, y.a, y.b);
  });
  found.erase(std::unique(found.begin(), found.end(),
                          [](const LiveEdge& x, const LiveEdge& y) { return x.a == y.a && x.b == y.b; }),
              found.end());
  return found;
}

SheetMesh LiveSheets::mesh(bool with_erosion) const {
  SheetMesh mesh;
  std::vector<std::uint32_t> row(points_.size(), kNone);
  for (std::uint32_t v = 0; v < points_.size(); ++v) {
    if (!alive(v)) continue;
    row[v] = static_cast<std::uint32_t>(mesh.points.size());
    mesh.points.push_back(points_[v].point);
    mesh.radius.push_back(points_[v].radius);
    if (with_erosion) mesh.erosion.push_back(points_[v].erosion);
    for (const Link& l : links_[v]) {
      const std::int32_t seam = lines_.lines[static_cast<std::size_t>(l.line)].seam;
      if (seam < 0 || l.to > v) continue;
      mesh.seam_edges.push_back({row[l.to], row[v]});
      mesh.seam.push_back(seam);
    }
  }
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    if (triangles_[t][0] == kNone) continue;
    const auto& [a, b, c] = triangles_[t];
    mesh.triangles.push_back({row[a], row[b], row[c]});
    mesh.sheet.push_back(sheet_[t]);
  }
  for (std::uint32_t v = 0; v < points_.size(); ++v)
    if (kind_[v] == Kind::fixed && alive(v)) mesh.fixed.push_back(row[v]);
  return mesh;
}

}  // namespace quench::parts
