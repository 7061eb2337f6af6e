// SPDX-License-Identifier: Apache-2.0
#include "simplification/fit.h"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "base/parallel.h"

namespace quench::simplification {
namespace {

double fenv(const char* n, double d) { const char* s = getenv(n); return s ? atof(s) : d; }
const double kDamp = fenv("DAMP", 1e-2);

double sum_of_squares(std::span<const Reach> feet, const BoundaryPoints& boundary) {
  double sum = 0;
  for (std::size_t i = 0; i < feet.size(); ++i) sum += boundary.areas[i] * feet[i].distance * feet[i].distance;
  return sum;
}

}  // namespace

double fit(std::vector<Vec4>& balls, std::span<const Primitive> primitives, const BoundaryPoints& boundary, int rounds,
           Context*) {
  const std::size_t n = boundary.points.size();
  std::vector<std::uint32_t> row(balls.size(), kNone), vertices;
  for (const Primitive& p : primitives)
    for (const std::uint32_t v : p)
      if (v != kNone && row[v] == kNone) row[v] = 0;
  for (std::uint32_t v = 0; v < balls.size(); ++v)
    if (row[v] != kNone) row[v] = static_cast<std::uint32_t>(vertices.size()), vertices.push_back(v);
  std::vector<Reach> feet(n), next(n);
  const auto find = [&](std::vector<Reach>& out, const std::vector<Reach>* before) {
    const PrimitiveTree tree(primitives, balls);
    const std::size_t chunks = n / 1024 + 1;
    tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
      const auto [first, last] = base::part_of(n, chunk, chunks);
      for (std::size_t i = first; i < last; ++i)
        out[i] = tree.nearest(boundary.points[i], before ? (*before)[i].primitive : kNone);
    });
  };
  find(feet, nullptr);
  double sum = sum_of_squares(feet, boundary), damping = kDamp;
  for (int round = 0; round < rounds; ++round) {
    // Normal equations.
    std::vector<Eigen::Triplet<double>> entries;
    const std::size_t size = vertices.size();
    std::vector<Mat4> diagonal(size, Mat4::Zero());
    std::vector<Vec4> right(size, Vec4::Zero());
    // per primitive: blocks of pairs
    struct Blocks { std::array<Mat4, 3> m; };
    std::vector<Blocks> blocks(primitives.size());
    for (auto& b : blocks) for (auto& m : b.m) m.setZero();
    for (std::size_t i = 0; i < n; ++i) {
      const Reach& f = feet[i];
      if (f.primitive == kNone) continue;
      const Primitive& p = primitives[f.primitive];
      Vec3 centre = Vec3::Zero();
      for (int k = 0; k < 3; ++k) if (f.share[k] > 0) centre += f.share[k] * balls[p[k]].head<3>();
      Vec3 normal = boundary.points[i] - centre;
      const double length = normal.norm();
      if (!(length > 0)) continue;
      normal /= length;
      const Vec4 j{normal[0], normal[1], normal[2], 1};
      const Mat4 jj = boundary.areas[i] * j * j.transpose();
      for (int k = 0; k < 3; ++k) {
        if (!(f.share[k] > 0)) continue;
        diagonal[row[p[k]]] += f.share[k] * f.share[k] * jj;
        right[row[p[k]]] += boundary.areas[i] * f.share[k] * f.distance * j;
        for (int l = k + 1; l < 3; ++l)
          if (f.share[l] > 0) blocks[f.primitive].m[k + l - 1] += f.share[k] * f.share[l] * jj;
      }
    }
    double mean_trace = 0;
    for (const Mat4& m : diagonal) mean_trace += m.trace() / 4 / static_cast<double>(size);
    for (std::size_t v = 0; v < size; ++v)
      for (int a = 0; a < 4; ++a)
        for (int b = 0; b < 4; ++b)
          entries.emplace_back(4 * v + a, 4 * v + b, diagonal[v](a, b) + (a == b ? damping * (diagonal[v].trace() / 4 + 0.01 * mean_trace) + 1e-12 * mean_trace : 0));
    for (std::size_t q = 0; q < primitives.size(); ++q)
      for (int k = 0; k < 3; ++k)
        for (int l = k + 1; l < 3; ++l) {
          if (primitives[q][k] == kNone || primitives[q][l] == kNone) continue;
          const Mat4& m = blocks[q].m[k + l - 1];
          const std::size_t r = row[primitives[q][k]], c = row[primitives[q][l]];
          for (int a = 0; a < 4; ++a)
            for (int b = 0; b < 4; ++b) {
              entries.emplace_back(4 * r + a, 4 * c + b, m(a, b));
              entries.emplace_back(4 * c + b, 4 * r + a, m(a, b));
            }
        }
    Eigen::SparseMatrix<double> matrix(4 * size, 4 * size);
    matrix.setFromTriplets(entries.begin(), entries.end());
    Eigen::VectorXd b(4 * size);
    for (std::size_t v = 0; v < size; ++v) b.segment<4>(4 * v) = right[v];
    Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(matrix);
    const Eigen::VectorXd x = solver.solve(b);
    std::vector<Vec4> before = balls;
    for (std::size_t v = 0; v < size; ++v) {
      balls[vertices[v]] += x.segment<4>(4 * v);
      balls[vertices[v]][3] = std::max(balls[vertices[v]][3], 0.0);
    }
    find(next, &feet);
    const double after = sum_of_squares(next, boundary);
    if (getenv("VERB")) std::fprintf(stderr, "  fit %d: %.4g -> %.4g damp %g\n", round, std::sqrt(sum), std::sqrt(after), damping);
    if (after < sum) {
      const bool still = after > sum * 0.999;
      sum = after;
      std::swap(feet, next);
      damping /= 3;
      if (still) break;
    } else {
      balls = before;
      damping *= 10;
      if (damping > 1e4) break;
    }
  }
  return sum;
}

}  // namespace quench::simplification
