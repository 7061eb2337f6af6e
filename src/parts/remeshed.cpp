// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>

#include "base/parallel.h"
#include "parts/border_lines.h"
#include "parts/live_sheets.h"
#include "parts/slits.h"
#include "quench/error.h"
#include "quench/parts.h"
#include "surface/triangle_tree.h"

namespace quench {
namespace {

using parts::LiveSheets;
using parts::SheetPoint;

// The sheets as they were, to be asked for nearest places.
class OldSheets {
 public:
  explicit OldSheets(const SheetMesh& mesh) : mesh_(mesh) {
    std::int32_t sheets = 0;
    for (const std::int32_t s : mesh.sheet) sheets = std::max(sheets, s + 1);
    rows_.resize(static_cast<std::size_t>(sheets));
    trees_.resize(rows_.size());
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
      rows_[static_cast<std::size_t>(mesh.sheet[t])].push_back(t);
    tbb::parallel_for(std::size_t{0}, rows_.size(), [&](std::size_t s) {
      TriangleMesh part;  // its own points: the size of a tree's room is that of its points
      part.points.reserve(3 * rows_[s].size());
      for (const std::uint32_t t : rows_[s]) {
        const auto first = static_cast<std::uint32_t>(part.points.size());
        for (const std::uint32_t v : mesh.triangles[t]) part.points.push_back(mesh.points[v]);
        part.triangles.push_back({first, first + 1, first + 2});
      }
      if (!rows_[s].empty()) trees_[s] = std::make_unique<surface::TriangleTree>(part);
    });
  }

  SheetPoint nearest(std::int32_t sheet, const Vec3& p) const {
    const auto s = static_cast<std::size_t>(sheet);
    const auto near = trees_[s]->nearest(p, std::numeric_limits<double>::infinity());
    const auto& corners = mesh_.triangles[rows_[s][near.triangle]];
    const std::array<double, 3> weight = weights(corners, near.point);
    SheetPoint place{near.point, 0, 0};
    for (std::size_t i = 0; i < 3; ++i) {
      place.radius += weight[i] * mesh_.radius[corners[i]];
      if (!mesh_.erosion.empty() && weight[i] > 0) place.erosion += weight[i] * mesh_.erosion[corners[i]];
    }
    return place;
  }

 private:
  // Barycentric; of a triangle without area by the nearest corner.
  std::array<double, 3> weights(const std::array<std::uint32_t, 3>& corners, const Vec3& p) const {
    const Vec3 &a = mesh_.points[corners[0]], &b = mesh_.points[corners[1]], &c = mesh_.points[corners[2]];
    const Vec3 n = (b - a).cross(c - a);
    const double whole = n.squaredNorm();
    if (!(whole > 0)) {
      const std::array<double, 3> far{(p - a).squaredNorm(), (p - b).squaredNorm(), (p - c).squaredNorm()};
      std::array<double, 3> one{0, 0, 0};
      one[static_cast<std::size_t>(std::ranges::min_element(far) - far.begin())] = 1;
      return one;
    }
    const double u = std::clamp((c - b).cross(p - b).dot(n) / whole, 0.0, 1.0),
                 v = std::clamp((a - c).cross(p - c).dot(n) / whole, 0.0, 1.0 - u);
    return {u, v, 1 - u - v};
  }

  const SheetMesh& mesh_;
  std::vector<std::vector<std::uint32_t>> rows_;
  std::vector<std::unique_ptr<surface::TriangleTree>> trees_;
};

class Remesher {
 public:
  Remesher(const SheetMesh& mesh, const RemeshOptions& options, Context* context)
      : options_(options),
        context_(context),
        old_(mesh),
        lines_(parts::border_lines(mesh, options.length)),
        live_(mesh, lines_),
        with_erosion_(!mesh.erosion.empty()) {}

  SheetMesh run() {
    for (int round = 0; round < options_.rounds; ++round) {
      checkpoint(context_, "remesh", static_cast<double>(round) / options_.rounds);
      split_long();
      collapse_short();
      flip_all();
      even_out();
      even_out();
    }
    flip_all();
    SheetMesh mesh = live_.mesh(with_erosion_);
    parts::halve_slits(mesh);
    checkpoint(context_, "remesh", 1);
    return mesh;
  }

 private:
  // Botsch and Kobbelt's bounds: both halves of an edge that is split are nearer to the length than it was, and so is
  // what two collapsed edges become.
  double longest() const { return options_.length * 4 / 3; }
  double shortest() const { return options_.length * 4 / 5; }

  void split_long() {
    for (;;) {
      const auto edges = live_.edges(std::nextafter(longest(), 2 * longest()), std::numeric_limits<double>::infinity());
      if (edges.empty()) return;
      if (context_ && context_->cancelled()) throw Error(ErrorCode::cancelled, "cancelled");
      for (auto edge = edges.rbegin(); edge != edges.rend(); ++edge) {
        if (live_.kind(edge->a) == LiveSheets::Kind::inner || live_.kind(edge->b) == LiveSheets::Kind::inner) {
          const std::uint32_t inner = live_.kind(edge->a) == LiveSheets::Kind::inner ? edge->a : edge->b;
          const Vec3 middle = 0.5 * (live_.at(edge->a) + live_.at(edge->b));
          live_.split(edge->a, edge->b, old_.nearest(live_.sheet_of(inner), middle));
        } else {
          live_.split(edge->a, edge->b, parts::mixed(live_.point(edge->a), live_.point(edge->b), 0.5));
        }
      }
    }
  }

  void collapse_short() {
    constexpr int kPasses = 12;  // each takes most of what it can: of what is left the ends have moved
    for (int pass = 0; pass < kPasses; ++pass) {
      std::size_t done = 0;
      for (const LiveSheets::LiveEdge& edge : live_.edges(0, shortest())) {
        if (!live_.alive(edge.a) || !live_.alive(edge.b) || !live_.adjacent(edge.a, edge.b)) continue;
        if (live_.length(edge.a, edge.b) > shortest()) continue;
        done += collapse_to_middle(edge.a, edge.b) || live_.collapse(edge.a, edge.b, longest()) ||
                live_.collapse(edge.b, edge.a, longest());
      }
      if (done == 0) return;
      if (context_ && context_->cancelled()) throw Error(ErrorCode::cancelled, "cancelled");
    }
  }

  bool collapse_to_middle(std::uint32_t a, std::uint32_t b) {
    const LiveSheets::Kind kind = live_.kind(a);
    if (kind != live_.kind(b) || kind == LiveSheets::Kind::fixed) return false;
    if (kind == LiveSheets::Kind::inner)
      return live_.collapse(a, b, longest(), old_.nearest(live_.sheet_of(a), 0.5 * (live_.at(a) + live_.at(b))), 0);
    const LiveSheets::OnLine middle = live_.middle(a, b);
    if (middle.line < 0) return false;
    return live_.collapse(a, b, longest(), lines_.lines[static_cast<std::size_t>(middle.line)].place(middle.at),
                          middle.at);
  }

  void flip_all() {
    constexpr int kPasses = 8;
    for (int pass = 0; pass < kPasses; ++pass) {
      std::size_t done = 0;
      for (const LiveSheets::LiveEdge& edge : live_.edges(0, std::numeric_limits<double>::infinity()))
        done += live_.adjacent(edge.a, edge.b) && live_.flip(edge.a, edge.b);
      if (done == 0) return;
    }
  }

  // Vertices inside sheets go to the mean of the triangles around them, by area, along the sheet; those of lines to the
  // middle between their neighbours. Where to is found from all as they are; then they move one by one.
  void even_out() {
    const std::uint32_t count = live_.vertices();
    std::vector<SheetPoint> to(count);
    std::vector<double> along(count, 0);
    base::for_indices(count, [&](std::size_t i) {
      const auto v = static_cast<std::uint32_t>(i);
      if (live_.alive(v)) to[v] = target(v, along[v]);
    });
    for (std::uint32_t v = 0; v < count; ++v) {
      if (!live_.alive(v) || live_.kind(v) == LiveSheets::Kind::fixed) continue;
      if (live_.move(v, to[v], along[v])) continue;
      if (live_.kind(v) == LiveSheets::Kind::border) {  // half of the way
        const LiveSheets::OnLine on = live_.on_line(v);
        const double half = 0.5 * (on.at + along[v]);
        live_.move(v, lines_.lines[static_cast<std::size_t>(on.line)].place(half), half);
      } else {
        live_.move(v, old_.nearest(live_.sheet_of(v), 0.5 * (live_.at(v) + to[v].point)));
      }
    }
  }

  SheetPoint target(std::uint32_t v, double& along) const {
    if (live_.kind(v) == LiveSheets::Kind::fixed) return live_.point(v);
    if (live_.kind(v) == LiveSheets::Kind::border) {
      const LiveSheets::OnLine on = live_.on_line(v);
      along = 0.5 * (on.before + on.behind);
      return lines_.lines[static_cast<std::size_t>(on.line)].place(along);
    }
    Vec3 mean = Vec3::Zero(), normal = Vec3::Zero();
    double weight = 0;
    for (const std::uint32_t t : live_.triangles_at(v)) {
      const auto& corners = live_.corners(t);
      const std::size_t i = corners[0] == v ? 0 : corners[1] == v ? 1 : 2;
      const Vec3 &b = live_.at(corners[(i + 1) % 3]), &c = live_.at(corners[(i + 2) % 3]);
      const Vec3 area = (b - live_.at(v)).cross(c - live_.at(v));
      mean += area.norm() * (live_.at(v) + b + c) / 3;
      weight += area.norm();
      normal += normal.dot(area) < 0 ? Vec3(-area) : area;
    }
    Vec3 step = weight > 0 ? Vec3(mean / weight - live_.at(v)) : Vec3(Vec3::Zero());
    if (const double size = normal.norm(); size > 0) step -= normal.dot(step) / (size * size) * normal;
    return old_.nearest(live_.sheet_of(v), live_.at(v) + step);
  }

  const RemeshOptions& options_;
  Context* context_;
  OldSheets old_;
  parts::BorderLines lines_;
  LiveSheets live_;
  bool with_erosion_;
};

}  // namespace

SheetMesh remeshed(const SheetMesh& mesh, const RemeshOptions& options, Context* context) {
  if (!(options.length > 0) || !std::isfinite(options.length) || options.rounds < 0)
    throw Error(ErrorCode::usage, "sheets are remeshed to an edge length above 0", "remesh");
  return base::in_arena(context, [&] { return Remesher(mesh, options, context).run(); });
}

}  // namespace quench
