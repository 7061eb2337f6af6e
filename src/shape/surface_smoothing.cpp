// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "base/parallel.h"
#include "quench/shape.h"
#include "shape/surface_fans.h"
#include "shape/surface_sides.h"

namespace quench {
namespace {

using shape::SurfaceFans;
using Fan = SurfaceFans::Fan;

constexpr double kUnit = 4;  ///< voxels: lengths of patches, so that powers of coordinates are about 1

/// A piece of a quadric as heights over a tangent plane: h = c0 + c1 a + c2 b + c3 a^2 + c4 a b + c5 b^2 + c6 h^2, in
/// units of kUnit. The last term makes spheres and cylinders of any radius exact.
struct Patch {
  Eigen::Vector3f normal;
  std::array<float, 7> c{};
  bool fits = false;
};

/// The plane of a patch.
struct Frame {
  Vec3 at, u, v, w;

  Frame(const Vec3& place, const Eigen::Vector3f& normal)
      : at(place), u(normal.unitOrthogonal().cast<double>()), w(normal.cast<double>()) {
    v = w.cross(u);
  }
  /// A point moved along the normal onto the patch, and further outward by `beyond` times the sum of its curvatures.
  Vec3 lift(const Patch& patch, const Vec3& p, double beyond) const {
    const auto& c = patch.c;
    const Vec3 d = (p - at) / kUnit;
    const double a = u.dot(d), b = v.dot(d), before = w.dot(d);
    const double flat = c[0] + c[1] * a + c[2] * b + c[3] * a * a + c[4] * a * b + c[5] * b * b;
    double h = before;
    for (int i = 0; i < 3; ++i) h = flat + c[6] * h * h;
    return p + ((h - before) * kUnit - beyond * 2 * (c[3] + c[5]) / kUnit) * w;
  }
};

/// Normal equations of a patch; single precision, as a patch is good to a thousandth of a voxel at best.
class Equations {
 public:
  void add(float a, float b, float h, float weight) {
    const std::array<float, 8> row{1, a, b, a * a, a * b, b * b, h * h, h};
    for (std::size_t i = 0; i < 7; ++i) {
      const float weighted = weight * row[i];
      for (std::size_t j = 0; j < 8; ++j) sums_[i][j] += weighted * row[j];
    }
  }
  /// Whether there is a solution. Curvatures are held near 0 as far as the points do not say more.
  bool solve(std::array<float, 7>& c) const {
    constexpr double kStiff = 4e-6, kStiffest = 8e-5;
    Eigen::Matrix<double, 7, 7> m;
    Eigen::Matrix<double, 7, 1> right;
    for (Eigen::Index i = 0; i < 7; ++i) {
      const auto& row = sums_[static_cast<std::size_t>(i)];
      for (Eigen::Index j = 0; j < 7; ++j) m(i, j) = row[static_cast<std::size_t>(j)];
      right[i] = row[7];
    }
    for (Eigen::Index i = 3; i < 6; ++i) m(i, i) += kStiff * m(0, 0);
    m(6, 6) += kStiffest * m(0, 0);
    const Eigen::LLT<Eigen::Matrix<double, 7, 7>> solver(m);
    if (solver.info() != Eigen::Success) return false;
    const Eigen::Matrix<double, 7, 1> x = solver.solve(right);
    for (std::size_t i = 0; i < 7; ++i) c[i] = static_cast<float>(x[static_cast<Eigen::Index>(i)]);
    return x.allFinite();
  }

 private:
  std::array<std::array<float, 8>, 7> sums_{};
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
  Smoother(TriangleMesh& surface, const SurfaceFans& fans, double reach)
      : surface_(surface),
        reach_(Vec3::Constant(reach)),
        fans_(fans),
        normal_(count()),
        place_(count()),
        patch_(count()) {}

  void run(int passes) {
    base::for_indices(count(), [&](std::size_t f) { begin(f); });
    for (int pass = 0; pass < passes; ++pass) {
      base::for_indices(count(), [&](std::size_t f) { fit(static_cast<std::uint32_t>(f)); });
      if (pass + 1 < passes) base::for_indices(count(), [&](std::size_t f) { move(f); });
    }
    finish();
  }

 private:
  std::size_t count() const { return fans_.fans().size(); }
  /// As near to where it started as it must be. A vertex between two voxel centres stays between them, and in a cone of
  /// 45 degrees from the nearer one, so that voxel centres stay on their side.
  Vec3 bounded(const Vec3& p, const Vec3& start) const {
    constexpr double kRoom = 0.02;
    Vec3 q = p.cwiseMax(start - reach_).cwiseMin(start + reach_);
    const Vec3 below = (start.array() - 0.5).floor() + 0.5;
    if ((start.array() != below.array()).count() != 1) return q;
    int along = 0;
    (start - below).maxCoeff(&along);
    q[along] = std::clamp(q[along], below[along] + kRoom, below[along] + 1 - kRoom);
    const double room = std::min(q[along] - below[along], below[along] + 1 - q[along]);
    for (int a = 0; a < 3; ++a)
      if (a != along) q[a] = std::clamp(q[a], start[a] - room, start[a] + room);
    return q;
  }

  /// Normal and mean of a loop.
  void begin(std::size_t f) {
    const Fan& fan = fans_.fans()[f];
    Vec3 sum = Vec3::Zero(), normal = Vec3::Zero();
    const Vec3& middle = surface_.points[fan.middle];
    for (std::uint32_t t = fan.first; t < fan.first + fan.size; ++t) {
      const auto& corners = surface_.triangles[t];
      const Vec3& from = surface_.points[corners[0]];
      normal += (from - middle).cross(surface_.points[corners[1]] - middle);
      sum += from;
    }
    place_[f] = sum / fan.size;
    normal_[f] = normal.cast<float>().normalized();
  }

  void fit(std::uint32_t f) {
    constexpr float kWidth = 2;         // kUnits; there the weight becomes 0
    constexpr float kSameSide = 0.2F;   // cosine between normals
    constexpr std::size_t kEnough = 9;  // fans
    const Surrounding around(fans_, f);
    Patch& patch = patch_[f];
    patch.fits = false;
    if (around.list().size() < kEnough) return;
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();
    for (const std::uint32_t g : around.list())
      if (normal_[g].dot(normal_[f]) > kSameSide) normal += normal_[g];
    patch.normal = normal.normalized();
    const Frame frame(place_[f], patch.normal);
    const Eigen::Vector3f u = frame.u.cast<float>(), v = frame.v.cast<float>();
    Equations equations;
    for (const std::uint32_t g : around.list()) {
      if (!(normal_[g].dot(patch.normal) > kSameSide)) continue;
      const Eigen::Vector3f d = ((place_[g] - frame.at) / kUnit).cast<float>();
      const float inside = std::max(0.0F, 1 - d.squaredNorm() / (kWidth * kWidth));
      equations.add(u.dot(d), v.dot(d), patch.normal.dot(d), inside * inside);
    }
    patch.fits = equations.solve(patch.c);
  }

  void move(std::size_t f) {
    const Patch& patch = patch_[f];
    if (!patch.fits) return;
    const Frame frame(place_[f], patch.normal);
    place_[f] = bounded(frame.lift(patch, place_[f], 0), surface_.points[fans_.fans()[f].middle]);
    normal_[f] = (frame.w - patch.c[1] * frame.u - patch.c[2] * frame.v).cast<float>().normalized();
  }

  /// All vertices; those on edges to the mean of the patches around them.
  void finish() {
    std::vector<Vec3>& points = surface_.points;
    std::vector<Vec3> moved = points;
    const auto lifted = [&](std::uint32_t f, const Vec3& p) {
      return Frame(place_[f], patch_[f].normal).lift(patch_[f], p, kBeyond);
    };
    base::for_indices(count(), [&](std::size_t f) {
      if (patch_[f].fits) moved[fans_.fans()[f].middle] = lifted(static_cast<std::uint32_t>(f), place_[f]);
    });
    base::for_indices(points.size(), [&](std::size_t v) {
      Vec3 sum = Vec3::Zero();
      int patches = 0;
      fans_.for_fans_around(v, [&](std::uint32_t f) {
        if (!patch_[f].fits) return;
        sum += lifted(f, points[v]);
        ++patches;
      });
      if (patches > 0) moved[v] = sum / patches;
    });
    base::for_indices(points.size(), [&](std::size_t v) { moved[v] = bounded(moved[v], points[v]); });
    shape::keep_sides(surface_, moved);
    shape::keep_faces_up(surface_, moved);
    points = std::move(moved);
  }

  /// The mean of a loop lies inside of a curved surface, and so do triangles between vertices on it. Chosen such that
  /// the largest balls in tubes and balls of three voxels radius and more, without noise, are right to 0.02 voxel.
  static constexpr double kBeyond = 0.18;  // voxels squared

  TriangleMesh& surface_;
  Vec3 reach_;
  const SurfaceFans& fans_;
  std::vector<Eigen::Vector3f> normal_;
  std::vector<Vec3> place_;
  std::vector<Patch> patch_;
};

}  // namespace

void smooth_surface(TriangleMesh& surface, const SurfaceSmoothing& options, Context* context) {
  constexpr double kFlat = 0.01;  // voxels
  const SurfaceFans fans(surface);
  base::in_arena(context, [&] { Smoother(surface, fans, options.reach).run(options.passes); });
  shape::flatten_fans(surface, fans, kFlat);
}

}  // namespace quench
