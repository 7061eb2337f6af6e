// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <vector>

#include "base/parallel.h"
#include "quench/shape.h"
#include "shape/surface_fans.h"

namespace quench {
namespace {

using shape::SurfaceFans;
using Fan = SurfaceFans::Fan;

constexpr std::size_t kTerms = 7;  ///< of a patch

/// A piece of a quadric as heights over a tangent plane: h = c0 + c1 a + c2 b + c3 a^2 + c4 a b + c5 b^2 + c6 h^2. The
/// last term makes spheres and cylinders of any radius exact.
struct Patch {
  Vec3 at, u, v, w;
  std::array<double, kTerms> c{};
  bool fits = false;

  /// A point moved along the normal onto the patch, and further outward by `beyond` times the sum of its curvatures.
  Vec3 lift(const Vec3& p, double beyond) const {
    const Vec3 d = p - at;
    const double a = u.dot(d), b = v.dot(d), before = w.dot(d);
    const double flat = c[0] + c[1] * a + c[2] * b + c[3] * a * a + c[4] * a * b + c[5] * b * b;
    double h = before;
    for (int i = 0; i < 3; ++i) h = flat + c[6] * h * h;
    return p + (h - before - beyond * 2 * (c[3] + c[5])) * w;
  }
};

/// Normal equations of a patch.
class Equations {
 public:
  void add(double a, double b, double h, double weight) {
    const std::array<double, kTerms> row{1, a, b, a * a, a * b, b * b, h * h};
    std::size_t k = 0;
    for (std::size_t i = 0; i < kTerms; ++i) {
      const double weighted = weight * row[i];
      for (std::size_t j = 0; j <= i; ++j) matrix_[k++] += weighted * row[j];
      right_[i] += weighted * h;
    }
  }
  /// Whether there is a solution. Curvatures are held near 0 as far as the points do not say more.
  bool solve(std::array<double, kTerms>& c) const {
    constexpr double kStiff = 1e-3, kStiffest = 2e-2;
    Eigen::Matrix<double, kTerms, kTerms> m;
    Eigen::Matrix<double, kTerms, 1> right;
    std::size_t k = 0;
    for (Eigen::Index i = 0; i < m.rows(); ++i) {
      for (Eigen::Index j = 0; j <= i; ++j) m(i, j) = matrix_[k++];
      right[i] = right_[static_cast<std::size_t>(i)];
    }
    for (Eigen::Index i = 3; i < 6; ++i) m(i, i) += kStiff * matrix_[0];
    m(6, 6) += kStiffest * matrix_[0];
    const Eigen::LDLT<Eigen::Matrix<double, kTerms, kTerms>, Eigen::Lower> solver(m);
    const Eigen::Matrix<double, kTerms, 1> x = solver.solve(right);
    for (std::size_t i = 0; i < kTerms; ++i) c[i] = x[static_cast<Eigen::Index>(i)];
    return x.allFinite();
  }

 private:
  std::array<double, kTerms*(kTerms + 1) / 2> matrix_{};
  std::array<double, kTerms> right_{};
};

/// The fans up to four steps from one, nearest first.
class Surrounding {
 public:
  Surrounding(const SurfaceFans& fans, std::uint32_t first) {
    add(first);
    std::size_t i = 0;
    for (int step = 0; step < kSteps; ++step)
      for (const std::size_t end = size_; i < end; ++i)
        for (const std::uint32_t next : fans.neighbours(fans.fans()[list_[i]]))
          if (next != kNone) add(next);
  }
  std::span<const std::uint32_t> list() const { return {list_.data(), size_}; }

 private:
  static constexpr int kSteps = 4;
  static constexpr std::size_t kMost = 96, kSlots = 256;

  void add(std::uint32_t fan) {
    std::size_t slot = fan * 0x9E3779B1u >> 24;
    while (slots_[slot] != 0) {
      if (slots_[slot] == fan + 1) return;
      slot = (slot + 1) % kSlots;
    }
    if (size_ == kMost) return;
    slots_[slot] = fan + 1;
    list_[size_++] = fan;
  }

  std::array<std::uint32_t, kSlots> slots_{};
  std::array<std::uint32_t, kMost> list_;
  std::size_t size_ = 0;
};

class Smoother {
 public:
  Smoother(TriangleMesh& surface, double reach)
      : surface_(surface),
        reach_(Vec3::Constant(reach)),
        fans_(surface),
        normal_(count()),
        place_(count()),
        patch_(count()) {}

  void run(int passes) {
    base::for_indices(count(), [&](std::size_t f) { begin(f); });
    for (int pass = 0; pass < passes; ++pass) {
      base::for_indices(count(), [&](std::size_t f) { fit(static_cast<std::uint32_t>(f)); });
      base::for_indices(count(), [&](std::size_t f) { move(f); });
    }
    finish();
  }

 private:
  std::size_t count() const { return fans_.fans().size(); }
  Vec3 bounded(const Vec3& p, const Vec3& start) const { return p.cwiseMax(start - reach_).cwiseMin(start + reach_); }

  /// Normal and mean of a loop.
  void begin(std::size_t f) {
    const Fan& fan = fans_.fans()[f];
    Vec3 sum = Vec3::Zero(), normal = Vec3::Zero();
    for (std::uint32_t t = fan.first; t < fan.first + fan.size; ++t) {
      const auto& corners = surface_.triangles[t];
      const Vec3 from = surface_.points[corners[0]] - surface_.points[fan.middle];
      normal += from.cross(surface_.points[corners[1]] - surface_.points[fan.middle]);
      sum += surface_.points[corners[0]];
    }
    place_[f] = sum / fan.size;
    normal_[f] = normal.normalized();
  }

  void fit(std::uint32_t f) {
    constexpr double kWidth = 8;        // voxels where the weight becomes 0
    constexpr double kSameSide = 0.2;   // cosine between normals
    constexpr std::size_t kEnough = 9;  // fans
    const Surrounding around(fans_, f);
    Patch& patch = patch_[f];
    patch.fits = false;
    if (around.list().size() < kEnough) return;
    Vec3 normal = Vec3::Zero();
    for (const std::uint32_t g : around.list())
      if (normal_[g].dot(normal_[f]) > kSameSide) normal += normal_[g];
    patch.at = place_[f];
    patch.w = normal.normalized();
    patch.u = patch.w.unitOrthogonal();
    patch.v = patch.w.cross(patch.u);
    Equations equations;
    for (const std::uint32_t g : around.list()) {
      if (!(normal_[g].dot(patch.w) > kSameSide)) continue;
      const Vec3 d = place_[g] - patch.at;
      const double inside = std::max(0.0, 1 - d.squaredNorm() / (kWidth * kWidth));
      equations.add(patch.u.dot(d), patch.v.dot(d), patch.w.dot(d), inside * inside);
    }
    patch.fits = equations.solve(patch.c);
  }

  void move(std::size_t f) {
    const Patch& patch = patch_[f];
    if (!patch.fits) return;
    place_[f] = bounded(patch.lift(place_[f], 0), surface_.points[fans_.fans()[f].middle]);
    normal_[f] = (patch.w - patch.c[1] * patch.u - patch.c[2] * patch.v).normalized();
  }

  /// All vertices; those on edges to the mean of the patches around them.
  void finish() {
    constexpr double kBeyond = 0.18;  // voxels, see below
    std::vector<Vec3>& points = surface_.points;
    std::vector<Vec3> moved = points;
    base::for_indices(count(), [&](std::size_t f) {
      if (patch_[f].fits) moved[fans_.fans()[f].middle] = patch_[f].lift(place_[f], kBeyond);
    });
    base::for_indices(points.size(), [&](std::size_t v) {
      Vec3 sum = Vec3::Zero();
      int patches = 0;
      fans_.for_fans_around(v, [&](std::uint32_t f) {
        if (!patch_[f].fits) return;
        sum += patch_[f].lift(points[v], kBeyond);
        ++patches;
      });
      if (patches > 0) moved[v] = sum / patches;
    });
    base::for_indices(points.size(), [&](std::size_t v) { points[v] = bounded(moved[v], points[v]); });
  }

  TriangleMesh& surface_;
  Vec3 reach_;
  SurfaceFans fans_;
  std::vector<Vec3> normal_, place_;
  std::vector<Patch> patch_;
};

}  // namespace

void smooth_surface(TriangleMesh& surface, const SurfaceSmoothing& options, Context* context) {
  constexpr double kFlat = 0.01;  // voxels
  base::in_arena(context, [&] { Smoother(surface, options.reach).run(options.passes); });
  shape::flatten_fans(surface, kFlat);
}

}  // namespace quench
