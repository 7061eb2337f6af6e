// SPDX-License-Identifier: Apache-2.0
#include "simplification/fit.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/parallel.h"
#include "quench/envelope.h"

namespace quench::simplification {
namespace {

// The damping in the beginning and at least, as a share of what holds a ball where it is.
constexpr double kFirstDamping = 0.03, kLeastDamping = 1e-3;
// Balls that hardly any boundary point holds are held by so much of the mean of the others.
constexpr double kHeld = 0.01;
constexpr int kSteps = 30;  // of conjugate gradients
// A round that gains a smaller share is the last.
constexpr double kStill = 1e-3;

/// The balls of an envelope that boundary points are least outside of.
using Feet = std::vector<Envelope::Ball>;

Feet feet_of(const Envelope& envelope, const BoundaryPoints& boundary, Context* context) {
  const std::size_t n = boundary.points.size();
  Feet feet(n);
  base::in_arena(context, [&] {
    const std::size_t chunks = base::chunks_for(n, 512);
    tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
      const auto [first, last] = base::part_of(n, chunk, chunks);
      for (std::size_t i = first; i < last; ++i) feet[i] = envelope.nearest(boundary.points[i]);
    });
  });
  return feet;
}

double sum_of_squares(const Feet& feet, const BoundaryPoints& boundary) {
  double sum = 0;
  for (std::size_t i = 0; i < feet.size(); ++i) sum += boundary.areas[i] * feet[i].distance * feet[i].distance;
  return sum;
}

/// The normal (n, 1) of the plane at a boundary point that its ball should touch; false in the centre of the ball.
bool plane_normal(const Vec3& p, const Envelope::Ball& foot, Vec4& normal) {
  const Vec3 n = p - foot.centre;
  const double length = n.norm();
  if (foot.element == kNone || !(length > 0)) return false;
  normal = {n[0] / length, n[1] / length, n[2] / length, 1};
  return true;
}

double dot(const std::vector<Vec4>& a, const std::vector<Vec4>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i].dot(b[i]);
  return sum;
}

/// Normal equations of the moves of balls, in blocks of four.
class NormalEquations {
 public:
  NormalEquations(const Envelope& envelope, std::size_t vertices)
      : envelope_(envelope), diagonal_(vertices, Mat4::Zero()), right_(vertices, Vec4::Zero()) {
    pairs_.resize(envelope.size());
    for (auto& blocks : pairs_) blocks.fill(Mat4::Zero());
  }

  /// The distance of a boundary point falls by n . (w1 m1 + w2 m2 + w3 m3) where the corners of its element move by m.
  void add(const Vec3& p, double area, const Envelope::Ball& foot) {
    Vec4 n;
    if (!plane_normal(p, foot, n)) return;
    const Mat4 square = area * n * n.transpose();
    const Envelope::Corners corners = envelope_.corners(foot.element);
    for (std::size_t k = 0; k < 3; ++k) {
      const double w = foot.weight[k];
      if (!(w > 0)) continue;
      diagonal_[corners[k]] += w * w * square;
      right_[corners[k]] += area * w * foot.distance * n;
      for (std::size_t l = k + 1; l < 3; ++l)
        if (foot.weight[l] > 0) pairs_[foot.element][k + l - 1] += w * foot.weight[l] * square;
    }
  }

  /// The damped moves, by conjugate gradients behind the inverted blocks of the diagonal.
  std::vector<Vec4> solve(double damping) const {
    const std::size_t n = diagonal_.size();
    double mean = 0;
    for (const Mat4& m : diagonal_) mean += m.trace() / (4 * static_cast<double>(n));
    std::vector<Mat4> damped = diagonal_, inverse(n);
    for (std::size_t v = 0; v < n; ++v) {
      damped[v].diagonal().array() += damping * (diagonal_[v].trace() / 4 + kHeld * mean) + 1e-300;
      inverse[v] = damped[v].inverse();
    }
    std::vector<Vec4> x(n, Vec4::Zero()), rest = right_, ahead(n), along(n), product(n);
    for (std::size_t v = 0; v < n; ++v) along[v] = ahead[v] = inverse[v] * rest[v];
    double size = dot(rest, ahead);
    const double enough = 1e-10 * size;
    for (int step = 0; step < kSteps && size > enough; ++step) {
      multiply(damped, along, product);
      const double far = size / dot(along, product);
      for (std::size_t v = 0; v < n; ++v) {
        x[v] += far * along[v];
        rest[v] -= far * product[v];
        ahead[v] = inverse[v] * rest[v];
      }
      const double next = dot(rest, ahead);
      for (std::size_t v = 0; v < n; ++v) along[v] = ahead[v] + next / size * along[v];
      size = next;
    }
    return x;
  }

 private:
  void multiply(const std::vector<Mat4>& damped, const std::vector<Vec4>& x, std::vector<Vec4>& product) const {
    for (std::size_t v = 0; v < x.size(); ++v) product[v] = damped[v] * x[v];
    for (std::size_t e = 0; e < pairs_.size(); ++e) {
      const Envelope::Corners c = envelope_.corners(e);
      for (std::size_t k = 0; k < 2; ++k)
        for (std::size_t l = k + 1; l < 3 && c[l] != kNone; ++l) {
          product[c[k]] += pairs_[e][k + l - 1] * x[c[l]];
          product[c[l]] += pairs_[e][k + l - 1] * x[c[k]];
        }
    }
  }

  const Envelope& envelope_;
  std::vector<Mat4> diagonal_;
  std::vector<Vec4> right_;
  std::vector<std::array<Mat4, 3>> pairs_;  // per element: of its corners 0 and 1, 0 and 2, 1 and 2
};

}  // namespace

void fit(MedialAxis& mesh, const BoundaryPoints& boundary, int rounds, Context* context) {
  Envelope envelope(mesh, EnvelopeKind::full, context);
  Feet feet = feet_of(envelope, boundary, context);
  double sum = sum_of_squares(feet, boundary), damping = kFirstDamping;
  for (int round = 0; round < rounds && sum > 0; ++round) {
    NormalEquations equations(envelope, mesh.points.size());
    for (std::size_t i = 0; i < feet.size(); ++i) equations.add(boundary.points[i], boundary.areas[i], feet[i]);
    const std::vector<Vec4> moves = equations.solve(damping);
    MedialAxis moved = mesh;
    for (std::size_t v = 0; v < moves.size(); ++v) {
      if (!moves[v].allFinite()) continue;
      moved.points[v] += moves[v].head<3>();
      moved.radius[v] = std::max(moved.radius[v] + moves[v][3], 0.0);
    }
    const Envelope there(moved, EnvelopeKind::full, context);
    Feet new_feet = feet_of(there, boundary, context);
    const double new_sum = sum_of_squares(new_feet, boundary);
    if (!(new_sum < sum)) {
      damping *= 10;
      continue;
    }
    const bool still = new_sum > (1 - kStill) * sum;
    mesh = std::move(moved);
    envelope = there;
    feet = std::move(new_feet);
    sum = new_sum;
    damping = std::max(damping / 3, kLeastDamping);
    if (still) break;
  }
}

std::vector<Quadric> boundary_quadrics(const MedialAxis& mesh, const BoundaryPoints& boundary, Context* context) {
  const Envelope envelope(mesh, EnvelopeKind::full, context);
  const Feet feet = feet_of(envelope, boundary, context);
  std::vector<Quadric> quadrics(mesh.points.size());
  for (std::size_t i = 0; i < feet.size(); ++i) {
    Vec4 n;
    if (!plane_normal(boundary.points[i], feet[i], n)) continue;
    const Envelope::Corners corners = envelope.corners(feet[i].element);
    for (std::size_t k = 0; k < 3; ++k)
      if (feet[i].weight[k] > 0)
        quadrics[corners[k]].add_plane(n, ball_of(boundary.points[i], 0), boundary.areas[i] * feet[i].weight[k]);
  }
  return quadrics;
}

}  // namespace quench::simplification
