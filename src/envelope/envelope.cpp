// SPDX-License-Identifier: Apache-2.0
#include "quench/envelope.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/parallel.h"
#include "envelope/element_tree.h"
#include "quench/error.h"

namespace quench {
namespace {

constexpr double kSlack = 1e-9;  // of a radius: what counts as in

void check_balls(const MedialAxis& axis) {
  if (axis.points.empty() || axis.radius.size() != axis.points.size())
    throw Error(ErrorCode::input, axis.points.empty() ? "the axis has no vertices, so there is no solid of it"
                                                      : "the axis has no radius for each of its vertices");
  for (std::size_t v = 0; v < axis.points.size(); ++v) {
    const bool number = axis.points[v].cwiseAbs().maxCoeff() <= kLargestLength && axis.points[v].allFinite();
    if (number && axis.radius[v] >= 0 && axis.radius[v] <= kLargestLength) continue;
    throw Error(ErrorCode::input, fmt::format("vertex {} has the {} {}; places must be numbers, and radii 0 or more", v,
                                              number ? "radius" : "place",
                                              number ? fmt::format("{:.6g}", axis.radius[v])
                                                     : fmt::format("{:.6g} {:.6g} {:.6g}", axis.points[v][0],
                                                                   axis.points[v][1], axis.points[v][2])));
  }
}

std::vector<Envelope::Corners> elements_of(const CellComplex& complex, EnvelopeKind kind) {
  std::vector<Envelope::Corners> elements;
  if (kind == EnvelopeKind::balls) {
    for (std::uint32_t v = 0; v < complex.vertex_count; ++v) elements.push_back({v, kNone, kNone});
    return elements;
  }
  std::vector<char> in_larger(complex.vertex_count, 0), has_face(complex.edges.size(), 0);
  for (const std::uint32_t e : complex.face_edges) has_face[e] = 1;
  for (std::size_t f = 0; f < complex.face_count(); ++f) {
    const auto corners = complex.corners(f);
    const std::size_t n = corners.size(),
                      first = static_cast<std::size_t>(std::ranges::min_element(corners) - corners.begin());
    for (std::size_t i = 2; i < n; ++i)
      elements.push_back({corners[first], corners[(first + i - 1) % n], corners[(first + i) % n]});
  }
  for (std::size_t e = 0; e < complex.edges.size(); ++e) {
    for (const std::uint32_t v : complex.edges[e]) in_larger[v] = 1;
    if (!has_face[e]) elements.push_back({complex.edges[e][0], complex.edges[e][1], kNone});
  }
  for (std::uint32_t v = 0; v < complex.vertex_count; ++v)
    if (!in_larger[v]) elements.push_back({v, kNone, kNone});
  return elements;
}

std::vector<envelope::Element> geometry_of(const MedialAxis& axis, const std::vector<Envelope::Corners>& corners) {
  std::vector<envelope::Element> elements(corners.size(), envelope::Element(Vec3::Zero(), 0));
  base::for_indices(corners.size(), [&](std::size_t i) {
    const auto& [a, b, c] = corners[i];
    const auto& x = axis.points;
    const auto& r = axis.radius;
    elements[i] = b == kNone   ? envelope::Element(x[a], r[a])
                  : c == kNone ? envelope::Element(x[a], r[a], x[b], r[b])
                               : envelope::Element(x[a], r[a], x[b], r[b], x[c], r[c]);
  });
  return elements;
}

}  // namespace

struct Envelope::Parts {
  EnvelopeKind kind;
  std::vector<Corners> corners;
  std::vector<Vec3> points;
  std::vector<double> radius;
  envelope::ElementTree tree;
  Vec3 low, high;
  double largest_radius = 0;

  Parts(const MedialAxis& axis, EnvelopeKind its_kind)
      : kind(its_kind),
        corners(elements_of(axis.complex, kind)),
        points(axis.points),
        radius(axis.radius),
        tree(geometry_of(axis, corners)) {
    low = high = points[0];
    for (std::size_t v = 0; v < points.size(); ++v) {
      low = low.cwiseMin(points[v] - Vec3::Constant(radius[v]));
      high = high.cwiseMax(points[v] + Vec3::Constant(radius[v]));
      largest_radius = std::max(largest_radius, radius[v]);
    }
  }
};

Envelope::Envelope(const MedialAxis& axis, EnvelopeKind kind, Context* context) {
  check_balls(axis);
  parts_ = base::in_arena(context, [&] { return std::make_shared<const Parts>(axis, kind); });
}

EnvelopeKind Envelope::kind() const { return parts_->kind; }
std::size_t Envelope::size() const { return parts_->corners.size(); }
Envelope::Corners Envelope::corners(std::size_t element) const { return parts_->corners[element]; }
const std::vector<Vec3>& Envelope::centres() const { return parts_->points; }
const std::vector<double>& Envelope::radii() const { return parts_->radius; }
const Vec3& Envelope::low() const { return parts_->low; }
const Vec3& Envelope::high() const { return parts_->high; }
double Envelope::largest_radius() const { return parts_->largest_radius; }

Envelope::Ball Envelope::nearest(const Vec3& p, double within, double enough) const {
  const envelope::ElementTree::Near near = parts_->tree.nearest(p, within, enough);
  Ball ball;
  if (near.element == kNone) return ball;
  ball.distance = near.ball.distance;
  ball.radius = near.ball.radius;
  ball.element = near.element;
  ball.weight = near.ball.weight;
  const Corners& corners = parts_->corners[near.element];
  for (std::size_t k = 0; k < 3 && corners[k] != kNone; ++k) ball.centre += ball.weight[k] * parts_->points[corners[k]];
  return ball;
}

bool Envelope::contains(const Vec3& p) const { return parts_->tree.contains(p, kSlack); }

}  // namespace quench
