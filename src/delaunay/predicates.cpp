// SPDX-License-Identifier: Apache-2.0
#include "delaunay/predicates.h"

#include <cstring>

// Where the system can choose at start, a second version of the in-sphere test uses the wider registers of newer
// processors (AVX2); both are exact, so results are the same. Sanitizers start too late for such choices.
#if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define QUENCH_FOR_NEWER_PROCESSORS __attribute__((target_clones("arch=x86-64-v3", "default")))
#else
#define QUENCH_FOR_NEWER_PROCESSORS
#endif

namespace quench::delaunay {
namespace {

using Words = std::uint32_t __attribute__((vector_size(16)));
using Integers = std::int32_t __attribute__((vector_size(16)));
using Reals = double __attribute__((vector_size(32)));

}  // namespace

// One lane per corner a, b, c, d, relative to p; x1 holds the following corner of each lane, cyclically, x2 the one
// after it.
QUENCH_FOR_NEWER_PROCESSORS
int Predicates::in_sphere(const Point& a, const Point& b, const Point& c, const Point& d, const Point& p) const {
  // The fourth numbers are ranks of sites: their differences wrap around and are not used.
  const auto load = [](const Point& point) {
    Words words;
    std::memcpy(&words, &point, sizeof words);
    return words;
  };
  const Words origin = load(p);
  const auto ia = Integers(load(a) - origin), ib = Integers(load(b) - origin), ic = Integers(load(c) - origin),
             id = Integers(load(d) - origin);
  const Integers xy_ab = __builtin_shufflevector(ia, ib, 0, 4, 1, 5),
                 xy_cd = __builtin_shufflevector(ic, id, 0, 4, 1, 5);
  const Integers z_ab = __builtin_shufflevector(ia, ib, 2, 6, 2, 6), z_cd = __builtin_shufflevector(ic, id, 2, 6, 2, 6);
  const Integers ix = __builtin_shufflevector(xy_ab, xy_cd, 0, 1, 4, 5);
  const Integers iy = __builtin_shufflevector(xy_ab, xy_cd, 2, 3, 6, 7);
  const Integers iz = __builtin_shufflevector(z_ab, z_cd, 0, 1, 4, 5);
  const Reals x = __builtin_convertvector(ix, Reals), y = __builtin_convertvector(iy, Reals),
              z = __builtin_convertvector(iz, Reals);
  const Reals x1 = __builtin_shufflevector(x, x, 1, 2, 3, 0), x2 = __builtin_shufflevector(x, x, 2, 3, 0, 1);
  const Reals y1 = __builtin_shufflevector(y, y, 1, 2, 3, 0), y2 = __builtin_shufflevector(y, y, 2, 3, 0, 1);
  const Reals z1 = __builtin_shufflevector(z, z, 1, 2, 3, 0), z2 = __builtin_shufflevector(z, z, 2, 3, 0, 1);
  const Reals m = x * y1 - x1 * y;  // minors of a and b, b and c, c and d, d and a
  const Reals n = x * y2 - x2 * y;  // a and c, b and d, c and a, d and b
  const Reals m1 = __builtin_shufflevector(m, m, 1, 2, 3, 0);
  const Reals t = z * m1 - z1 * n + z2 * m;  // abc, bcd, cda, dab
  const Reals t1 = __builtin_shufflevector(t, t, 1, 2, 3, 0);
  const Reals lifted = (real_weight_[0] * (x * x) + real_weight_[1] * (y * y) + real_weight_[2] * (z * z)) * t1;
  const double det = (lifted[0] - lifted[1]) + (lifted[2] - lifted[3]);
  // The limits are powers of two, so one OR over the magnitudes tells whether all differences are below them.
  const Integers sizes = (ix ^ (ix >> 31)) | (iy ^ (iy >> 31)) | (iz ^ (iz >> 31));
  const auto largest = static_cast<std::uint32_t>(sizes[0] | sizes[1] | sizes[2] | sizes[3]);
  if (largest < double_limit_) return (det > 0) - (det < 0);
  if (largest >= int64_limit_) {
    const double size = static_cast<double>(largest) + 1;  // at least the largest difference
    const double bound = filter_ * size * size * size * size * size;
    if (det > bound) return 1;
    if (det < -bound) return -1;
  }
  return in_sphere_far(a, b, c, d, p, largest);
}

template <class T>
int Predicates::exact(const Point& a, const Point& b, const Point& c, const Point& d, const Point& p) const {
  const T ax = a.x - p.x, ay = a.y - p.y, az = a.z - p.z, bx = b.x - p.x, by = b.y - p.y, bz = b.z - p.z;
  const T cx = c.x - p.x, cy = c.y - p.y, cz = c.z - p.z, dx = d.x - p.x, dy = d.y - p.y, dz = d.z - p.z;
  const T ab = ax * by - bx * ay, bc = bx * cy - cx * by, cd = cx * dy - dx * cy;
  const T da = dx * ay - ax * dy, ac = ax * cy - cx * ay, bd = bx * dy - dx * by;
  const T abc = az * bc - bz * ac + cz * ab, bcd = bz * cd - cz * bd + dz * bc;
  const T cda = cz * da + dz * ac + az * cd, dab = dz * ab + az * bd + bz * da;
  const auto lift = [this](T x, T y, T z) {
    return T(weight_[0]) * (x * x) + T(weight_[1]) * (y * y) + T(weight_[2]) * (z * z);
  };
  const T v = (lift(cx, cy, cz) * dab - lift(dx, dy, dz) * abc) + (lift(ax, ay, az) * bcd - lift(bx, by, bz) * cda);
  return (v > 0) - (v < 0);
}

// Differences too large for doubles; `largest`: all are below it or equal.
int Predicates::in_sphere_far(const Point& a, const Point& b, const Point& c, const Point& d, const Point& p,
                              std::uint32_t largest) const {
  if (largest < int64_limit_) return exact<std::int64_t>(a, b, c, d, p);
  // Differences D along an axis of weight w obey D < 2^22 and w D^2 < 2^47 (delaunay.cpp), so
  // |det| <= 4 * (lift < 3 * 2^47) * (minor < 6 * 2^66) < 2^120.
  return exact<Int128>(a, b, c, d, p);
}

}  // namespace quench::delaunay
