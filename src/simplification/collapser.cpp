// SPDX-License-Identifier: Apache-2.0
#include "simplification/collapser.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cstdlib>

#include "base/parallel.h"

namespace quench::simplification {
namespace {

double env(const char* n, double d) { const char* s = getenv(n); return s ? atof(s) : d; }
const double kStay = env("STAY", 1e-3);

}  // namespace

Collapser::Collapser(const MedialAxis& mesh, std::vector<Quadric> quadrics)
    : complex_(mesh.complex), quadrics_(std::move(quadrics)), version_(mesh.complex.edges.size(), 0) {
  for (std::size_t v = 0; v < mesh.points.size(); ++v) balls_.push_back(ball_of(mesh.points[v], mesh.radius[v]));
}

Vec4 Collapser::place(std::uint32_t e, double* cost) const {
  const auto [a, b] = complex_.ends(e);
  Quadric q = quadrics_[a];
  q += quadrics_[b];
  const double wa = quadrics_[a].weight, wb = quadrics_[b].weight;
  const Vec4 mean = wa + wb > 0 ? Vec4((wa * balls_[a] + wb * balls_[b]) / (wa + wb)) : Vec4((balls_[a] + balls_[b]) / 2);
  const double stay = kStay * q.weight + 1e-300;
  Mat4 m = q.a;
  m.diagonal().array() += stay;
  Vec4 ball = m.ldlt().solve(q.b + stay * mean);
  if (!ball.allFinite() || !(ball[3] >= 0)) {
    ball = mean;
  }
  *cost = q(ball) + stay * (ball - mean).squaredNorm();
  return ball;
}

void Collapser::push(std::uint32_t e) {
  double cost = 0;
  place(e, &cost);
  queue_.push({cost, e, ++version_[e]});
}

void Collapser::restart(std::vector<Quadric> quadrics) {
  quadrics_ = std::move(quadrics);
  queue_ = {};
}

void Collapser::run(std::size_t vertices, std::vector<Collapse>& steps, Context* context, double begin, double end) {
  (void)context, (void)begin, (void)end;
  if (queue_.empty()) {
    std::vector<Entry> entries(complex_.edge_count());
    base::for_indices(complex_.edge_count(), [&](std::size_t i) {
      const auto e = static_cast<std::uint32_t>(i);
      if (!complex_.has_edge(e)) return;
      entries[i] = {0, e, ++version_[e]};
      place(e, &entries[i].cost);
    });
    std::erase_if(entries, [](const Entry& entry) { return entry.version == 0; });
    queue_ = decltype(queue_)(std::greater<>(), std::move(entries));
  }
  std::size_t retry = complex_.vertices_left() * 9 / 10;
  while (complex_.vertices_left() > vertices) {
    if (queue_.empty() || (complex_.vertices_left() < retry && !blocked_.empty())) {
      retry = complex_.vertices_left() * 9 / 10;
      const bool progress = queue_.empty() ? !steps.empty() : true;
      std::vector<std::uint32_t> again;
      std::swap(again, blocked_);
      std::ranges::sort(again);
      again.erase(std::unique(again.begin(), again.end()), again.end());
      bool any = false;
      for (const std::uint32_t e : again)
        if (complex_.has_edge(e)) {
          if (queue_.empty() && !any && !complex_.may_collapse(e)) { blocked_.push_back(e); continue; }
          push(e), any = true;
        }
      if (!any && queue_.empty()) break;
      (void)progress;
    }
    const Entry top = queue_.top();
    queue_.pop();
    const std::uint32_t e = top.edge;
    if (!complex_.has_edge(e) || version_[e] != top.version) continue;
    if (!complex_.may_collapse(e)) {
      blocked_.push_back(e);
      continue;
    }
    double cost = 0;
    const Vec4 ball = place(e, &cost);
    const auto [a, b] = complex_.ends(e);
    const std::uint32_t kept = std::min(a, b), removed = std::max(a, b);
    complex_.collapse(e, removed);
    quadrics_[kept] += quadrics_[removed];
    balls_[kept] = ball;
    steps.push_back({kept, removed, ball.head<3>(), ball[3]});
    complex_.for_edges(kept, [&](std::uint32_t f) { push(f); });
  }
}

std::vector<Primitive> Collapser::primitives() const {
  std::vector<Primitive> list;
  std::vector<char> has_triangle(complex_.edge_count(), 0);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> sides;
  for (std::uint32_t t = 0; t < complex_.triangle_count(); ++t) {
    if (!complex_.has_triangle(t)) continue;
    const auto& c = complex_.corners(t);
    list.push_back({c[0], c[1], c[2]});
    for (int i = 0; i < 3; ++i) sides.push_back(std::minmax(c[i], c[(i + 1) % 3]));
  }
  std::ranges::sort(sides);
  std::vector<char> lone(balls_.size(), 0);
  for (std::uint32_t v = 0; v < balls_.size(); ++v) lone[v] = complex_.has_vertex(v);
  for (std::uint32_t e = 0; e < complex_.edge_count(); ++e) {
    if (!complex_.has_edge(e)) continue;
    const auto [a, b] = complex_.ends(e);
    lone[a] = lone[b] = 0;
    if (!std::ranges::binary_search(sides, std::pair<std::uint32_t, std::uint32_t>(std::minmax(a, b))))
      list.push_back({std::min(a, b), std::max(a, b), kNone});
  }
  for (std::uint32_t v = 0; v < balls_.size(); ++v)
    if (lone[v]) list.push_back({v, kNone, kNone});
  return list;
}

}  // namespace quench::simplification
