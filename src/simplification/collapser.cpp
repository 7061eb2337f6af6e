// SPDX-License-Identifier: Apache-2.0
#include "simplification/collapser.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <utility>

#include "base/parallel.h"

namespace quench::simplification {
namespace {

// How much the new ball is drawn to the mean of the old ones, as a share of the planes: decides where these do not.
constexpr double kStay = 1e-3;
// Edges that could not be collapsed are tried again when so many of the vertices are left.
constexpr double kAgain = 0.9;

}  // namespace

Collapser::Collapser(const MedialAxis& mesh, std::vector<Quadric> quadrics, Context* context)
    : complex_(mesh.complex),
      quadrics_(std::move(quadrics)),
      version_(mesh.complex.edges.size(), 0),
      context_(context) {
  balls_.reserve(mesh.points.size());
  for (std::size_t v = 0; v < mesh.points.size(); ++v) balls_.push_back(ball_of(mesh.points[v], mesh.radius[v]));
  std::vector<Entry> entries(mesh.complex.edges.size());
  base::in_arena(context, [&] {
    base::for_indices(entries.size(), [&](std::size_t i) {
      const auto e = static_cast<std::uint32_t>(i);
      entries[i] = {place(e).cost, e, 0};
    });
  });
  queue_ = decltype(queue_)(std::greater<>(), std::move(entries));
}

Collapser::Place Collapser::place(std::uint32_t e) const {
  const auto [a, b] = complex_.ends(e);
  Quadric q = quadrics_[a];
  q += quadrics_[b];
  const double wa = quadrics_[a].weight, wb = quadrics_[b].weight;
  Vec4 mean = (balls_[a] + balls_[b]) / 2;
  if (q.weight > 0) mean = (wa * balls_[a] + wb * balls_[b]) / q.weight;
  const double stay = kStay * q.weight;
  Mat4 m = q.a;
  m.diagonal().array() += stay;
  Vec4 ball = stay > 0 ? Vec4(m.ldlt().solve(q.b + stay * mean)) : mean;
  if (!ball.allFinite() || !(ball[3] >= 0)) ball = mean;
  return {ball, q(ball) + stay * (ball - mean).squaredNorm()};
}

// Tells whether there is anything to try again.
bool Collapser::push_blocked() {
  std::vector<std::uint32_t> again = std::exchange(blocked_, {});
  std::ranges::sort(again);
  again.erase(std::unique(again.begin(), again.end()), again.end());
  bool any = false;
  for (const std::uint32_t e : again) {
    if (!complex_.has_edge(e)) continue;
    if (!complex_.may_collapse(e)) {
      blocked_.push_back(e);
      continue;
    }
    push(e);
    any = true;
  }
  return any;
}

std::vector<Collapse> Collapser::run(std::size_t vertices, double begin, double end) {
  std::vector<Collapse> steps;
  const std::size_t first = complex_.vertices_left();
  auto again = static_cast<std::size_t>(kAgain * static_cast<double>(first));
  std::size_t looked = 0;
  while (complex_.vertices_left() > vertices) {
    if (queue_.empty() || complex_.vertices_left() < again) {
      again = static_cast<std::size_t>(kAgain * static_cast<double>(complex_.vertices_left()));
      if (!push_blocked() && queue_.empty()) break;
    }
    if (++looked % 4096 == 0)
      checkpoint(context_, "simplify",
                 begin + (end - begin) * static_cast<double>(first - complex_.vertices_left()) /
                             static_cast<double>(first - vertices));
    const Entry entry = queue_.top();
    queue_.pop();
    const std::uint32_t e = entry.edge;
    if (!complex_.has_edge(e) || version_[e] != entry.version) continue;
    if (!complex_.may_collapse(e)) {
      blocked_.push_back(e);
      continue;
    }
    const Vec4 ball = place(e).ball;
    const auto [a, b] = complex_.ends(e);
    const std::uint32_t kept = std::min(a, b), removed = std::max(a, b);
    complex_.collapse(e, removed);
    quadrics_[kept] += quadrics_[removed];
    balls_[kept] = ball;
    steps.push_back({kept, removed, ball.head<3>(), ball[3]});
    complex_.for_edges(kept, [&](std::uint32_t f) { push(f); });
  }
  checkpoint(context_, "simplify", end);
  return steps;
}

MedialAxis Collapser::mesh(std::vector<std::uint32_t>& rows) const {
  MedialAxis mesh;
  rows.clear();
  std::vector<std::uint32_t> row_of(balls_.size(), kNone);
  for (std::uint32_t v = 0; v < balls_.size(); ++v) {
    if (!complex_.has_vertex(v)) continue;
    row_of[v] = static_cast<std::uint32_t>(rows.size());
    rows.push_back(v);
    mesh.points.push_back(balls_[v].head<3>());
    mesh.radius.push_back(balls_[v][3]);
  }
  std::vector<std::array<std::uint32_t, 2>> edges;
  for (std::uint32_t e = 0; e < complex_.edge_count(); ++e) {
    if (!complex_.has_edge(e)) continue;
    const auto [a, b] = complex_.ends(e);
    edges.push_back({std::min(row_of[a], row_of[b]), std::max(row_of[a], row_of[b])});
  }
  std::vector<std::uint32_t> offsets{0}, corners;
  for (std::uint32_t t = 0; t < complex_.triangle_count(); ++t) {
    if (!complex_.has_triangle(t)) continue;
    for (const std::uint32_t v : complex_.corners(t)) corners.push_back(row_of[v]);
    offsets.push_back(static_cast<std::uint32_t>(corners.size()));
  }
  mesh.complex = make_complex(static_cast<std::uint32_t>(rows.size()), edges, std::move(offsets), std::move(corners));
  return mesh;
}

}  // namespace quench::simplification
