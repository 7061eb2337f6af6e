// SPDX-License-Identifier: Apache-2.0
#include "voxelization/winding_number.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "voxelization/surface_caps.h"

namespace quench::voxelization {
namespace {

constexpr std::uint32_t kLeaf = 4;
// The moments of a cluster stand for it when its radius is below this share of its distance; its angle is taken as
// linear in blocks of a radius below that share of it.
constexpr double kFar = 0.3, kLinear = 0.25;
constexpr double kSphere = 4 * std::numbers::pi;

double squared(double v) { return v * v; }

/// |v| + v.x without cancellation; rho2 = v.y^2 + v.z^2.
double length_plus_x(double x, double rho2, double length) { return x >= 0 ? length + x : rho2 / (length - x); }

/// The sign of ay * bz - az * by for the scanline shifted as scan_conversion.cpp shifts it: y by more than z.
double exact_sign(double ay, double az, double by, double bz) {
  const auto fixed = [](double v) { return static_cast<__int128>(std::llround(std::ldexp(v, kFractionBits))); };
  const __int128 d = fixed(ay) * fixed(bz) - fixed(az) * fixed(by);
  if (d != 0) return d > 0 ? 1 : -1;
  if (az != bz) return az > bz ? 1 : -1;
  return by > ay ? 1 : by < ay ? -1 : 0;
}

}  // namespace

std::int32_t CapCrossings::until(std::int64_t x, std::int64_t y) const {
  const auto row = static_cast<std::size_t>(y);
  const auto begin = steps.begin() + row_begin[row], end = steps.begin() + row_begin[row + 1];
  const auto after = std::upper_bound(begin, end, x, [](std::int64_t v, const Step& s) { return v < s.voxel; });
  return after == begin ? 0 : (after - 1)->sum;
}

WindingNumber::WindingNumber(std::span<const FixedPoint> points, std::span<const std::array<std::uint32_t, 3>> faces)
    : points_(points) {
  const auto in_voxels = [&](std::uint32_t p) {
    const FixedPoint& q = points[p];
    const auto voxels = [](std::int64_t v) { return std::ldexp(static_cast<double>(v), -kFractionBits); };
    return Vector{voxels(q[0]), voxels(q[1]), voxels(q[2])};
  };
  for (const CapTriangle& t : close_boundary(points.size(), faces)) {
    Cap cap{t.corners, t.boundary, {}, {}};
    for (std::size_t i = 0; i < 3; ++i) cap.at[i] = in_voxels(t.corners[i]);
    const auto& [a, b, c] = cap.at;
    const Vector u{b.x - a.x, b.y - a.y, b.z - a.z}, v{c.x - a.x, c.y - a.y, c.z - a.z};
    cap.area = {(u.y * v.z - u.z * v.y) / 2, (u.z * v.x - u.x * v.z) / 2, (u.x * v.y - u.y * v.x) / 2};
    for (const bool boundary : cap.boundary) boundary_edges_ += boundary;
    caps_.push_back(cap);
  }
  if (caps_.empty()) return;
  nodes_.reserve(caps_.size());
  build(0, static_cast<std::uint32_t>(caps_.size()));
  for (const Cap& cap : caps_) faces_.push_back(cap.corners);
}

std::uint32_t WindingNumber::build(std::uint32_t begin, std::uint32_t end) {
  const auto index = static_cast<std::uint32_t>(nodes_.size());
  nodes_.emplace_back();
  nodes_[index].begin = begin;
  nodes_[index].end = end;
  if (end - begin > kLeaf) {
    std::array<double, 3> low, high;
    low.fill(std::numeric_limits<double>::infinity());
    high.fill(-std::numeric_limits<double>::infinity());
    const auto middle = [](const Cap& cap) {  // times 3
      const auto& [a, b, c] = cap.at;
      return std::array<double, 3>{a.x + b.x + c.x, a.y + b.y + c.y, a.z + b.z + c.z};
    };
    for (std::uint32_t i = begin; i < end; ++i) {
      const auto m = middle(caps_[i]);
      for (std::size_t a = 0; a < 3; ++a) {
        low[a] = std::min(low[a], m[a]);
        high[a] = std::max(high[a], m[a]);
      }
    }
    std::size_t axis = 0;
    for (std::size_t a = 1; a < 3; ++a)
      if (high[a] - low[a] > high[axis] - low[axis]) axis = a;
    const std::uint32_t half = begin + (end - begin) / 2;
    std::nth_element(caps_.begin() + begin, caps_.begin() + half, caps_.begin() + end,
                     [&](const Cap& p, const Cap& q) { return middle(p)[axis] < middle(q)[axis]; });
    build(begin, half);
    const std::uint32_t right = build(half, end);
    nodes_[index].right = right;
  }
  summarize(nodes_[index]);
  return index;
}

void WindingNumber::summarize(Node& node) const {
  Vector& c = node.centre;
  for (std::uint32_t i = node.begin; i < node.end; ++i) {
    for (const Vector& v : caps_[i].at) c = {c.x + v.x, c.y + v.y, c.z + v.z};
  }
  const double corners = 3.0 * (node.end - node.begin);
  c = {c.x / corners, c.y / corners, c.z / corners};
  for (std::uint32_t i = node.begin; i < node.end; ++i) {
    const Cap& cap = caps_[i];
    Vector offset;
    for (const Vector& v : cap.at) {
      node.radius = std::max(node.radius, std::hypot(v.x - c.x, v.y - c.y, v.z - c.z));
      offset = {offset.x + (v.x - c.x) / 3, offset.y + (v.y - c.y) / 3, offset.z + (v.z - c.z) / 3};
    }
    node.sum = {node.sum.x + cap.area.x, node.sum.y + cap.area.y, node.sum.z + cap.area.z};
    node.area += std::hypot(cap.area.x, cap.area.y, cap.area.z);
    const std::array<double, 3> area{cap.area.x, cap.area.y, cap.area.z}, from_centre{offset.x, offset.y, offset.z};
    for (std::size_t r = 0; r < 3; ++r)
      for (std::size_t k = 0; k < 3; ++k) node.moment[r][k] += area[r] * from_centre[k];
  }
  node.sum_norm = std::hypot(node.sum.x, node.sum.y, node.sum.z);
  for (const auto& row : node.moment)
    for (const double v : row) node.moment_norm += v * v;
  node.moment_norm = std::sqrt(node.moment_norm);
}

// Van Oosterom and Strackee 1983. In the plane of the cap, on its inside or its rim, the sign is that for the shifted
// centre of the voxel: the crossing of the cap and the angles of the strips from its sides to +x.
double WindingNumber::cap_angle(const Cap& cap, const std::array<std::int64_t, 3>& voxel, const Vector& p) const {
  const auto& [va, vb, vc] = cap.at;
  const Vector a{va.x - p.x, va.y - p.y, va.z - p.z}, b{vb.x - p.x, vb.y - p.y, vb.z - p.z},
      c{vc.x - p.x, vc.y - p.y, vc.z - p.z};
  const auto dot = [](const Vector& u, const Vector& v) { return u.x * v.x + u.y * v.y + u.z * v.z; };
  const double la = std::sqrt(dot(a, a)), lb = std::sqrt(dot(b, b)), lc = std::sqrt(dot(c, c));
  const double sine = 2 * dot(a, cap.area);  // a . (b - a) x (c - a)
  const double cosine = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
  const double tiny = 0x1p-36 * (la * lb * lc + lb * lc + lc * la + la * lb);
  if (cosine > tiny || std::abs(sine) > tiny) return 2 * std::atan2(sine, cosine);
  const double crossing =
      crossings_until(points_[cap.corners[0]], points_[cap.corners[1]], points_[cap.corners[2]], voxel);
  return kSphere * crossing + strip_angle(va, vb, p) + strip_angle(vb, vc, p) + strip_angle(vc, va, p);
}

// The strip of a side, seen from p, is the spherical triangle of a, b and +x.
double WindingNumber::strip_angle(const Vector& a, const Vector& b, const Vector& p) {
  const double ax = a.x - p.x, ay = a.y - p.y, az = a.z - p.z;
  const double bx = b.x - p.x, by = b.y - p.y, bz = b.z - p.z;
  const double a2 = ay * ay + az * az, b2 = by * by + bz * bz;
  const double cosine =
      length_plus_x(ax, a2, std::sqrt(ax * ax + a2)) * length_plus_x(bx, b2, std::sqrt(bx * bx + b2)) + ay * by +
      az * bz;
  double sine = ay * bz - az * by;
  if (cosine <= 0 && std::abs(sine) <= 0x1p-49 * (std::abs(ay * bz) + std::abs(az * by))) {
    const double sign = exact_sign(ay, az, by, bz);  // only here the sign decides between 2 pi and -2 pi
    if (sign == 0) return 0;
    sine = std::copysign(sine, sign);
  }
  return 2 * std::atan2(sine, cosine);
}

// The angle of a small area n at r is n . r / |r|^3; the moments give the integral of its linear part around the
// centre of the cluster.
double WindingNumber::cluster_angle(const Node& node, const Vector& r) {
  const double r2 = r.x * r.x + r.y * r.y + r.z * r.z, cubed = 1 / (r2 * std::sqrt(r2));
  const auto& m = node.moment;
  const double along = r.x * (m[0][0] * r.x + m[0][1] * r.y + m[0][2] * r.z) +
                       r.y * (m[1][0] * r.x + m[1][1] * r.y + m[1][2] * r.z) +
                       r.z * (m[2][0] * r.x + m[2][1] * r.y + m[2][2] * r.z);
  return cubed *
         (node.sum.x * r.x + node.sum.y * r.y + node.sum.z * r.z + m[0][0] + m[1][1] + m[2][2] - 3 * along / r2);
}

// The gradient is the field of a current around the cap (Biot-Savart). Its change is bounded by the distance of the
// sides. Currents in a side of two caps cancel when both are evaluated exactly; the other one may be part of a cluster
// only where the side is short compared with its distance.
void WindingNumber::add_gradient(const Cap& cap, const Vector& p, double within, Slope& slope) {
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector &from = cap.at[i], &to = cap.at[(i + 1) % 3];
    const Vector a{from.x - p.x, from.y - p.y, from.z - p.z}, b{to.x - p.x, to.y - p.y, to.z - p.z};
    const Vector ab{b.x - a.x, b.y - a.y, b.z - a.z};
    const double length2 = ab.x * ab.x + ab.y * ab.y + ab.z * ab.z, length = std::sqrt(length2);
    const double t = length2 > 0 ? std::clamp(-(a.x * ab.x + a.y * ab.y + a.z * ab.z) / length2, 0.0, 1.0) : 0.0;
    const double near = std::sqrt(squared(a.x + t * ab.x) + squared(a.y + t * ab.y) + squared(a.z + t * ab.z)) - within;
    const bool cancels = !cap.boundary[i] && (near <= 0 || length > 2 * kFar / (1 - kFar) * near);
    if (!cancels) {
      if (near <= 0) {
        slope.bend = std::numeric_limits<double>::infinity();
        return;
      }
      slope.bend += 3 * std::min(length / near, 1.0) / squared(near);
    }
    const double la = std::sqrt(a.x * a.x + a.y * a.y + a.z * a.z), lb = std::sqrt(b.x * b.x + b.y * b.y + b.z * b.z);
    const double product = la * lb, sum = product + a.x * b.x + a.y * b.y + a.z * b.z;
    if (!(sum > 1e-12 * product)) {  // on the side itself
      slope.bend = std::numeric_limits<double>::infinity();
      return;
    }
    const double field = (la + lb) / (product * sum);
    slope.x += field * (a.y * b.z - a.z * b.y);
    slope.y += field * (a.z * b.x - a.x * b.z);
  }
}

bool WindingNumber::meets(const Cap& cap, const Vector& p, double hx, double hy) {
  const auto& [a, b, c] = cap.at;
  const auto beside = [](double u, double v, double w, double at, double half) {
    return std::min({u, v, w}) > at + half || std::max({u, v, w}) < at - half;
  };
  if (beside(a.z, b.z, c.z, p.z, 0) || beside(a.y, b.y, c.y, p.y, hy) || beside(a.x, b.x, c.x, p.x, hx)) return false;
  const double from_plane = cap.area.x * (a.x - p.x) + cap.area.y * (a.y - p.y) + cap.area.z * (a.z - p.z);
  return std::abs(from_plane) <= (1 + 1e-9) * (std::abs(cap.area.x) * hx + std::abs(cap.area.y) * hy) + 1e-9;
}

// The middle of a block, and half the sides of a box around it with the centres of all its voxels.
struct WindingNumber::Middle {
  explicit Middle(const Block& block)
      : voxel(block.middle()),
        hx(static_cast<double>(voxel[0] - block.x0)),
        hy(static_cast<double>(voxel[1] - block.y0)),
        h(std::hypot(hx, hy)) {
    const auto centre = [](std::int64_t i) { return static_cast<double>(i) + 0.5; };
    p = {centre(voxel[0]), centre(voxel[1]), centre(voxel[2])};
  }
  std::array<std::int64_t, 3> voxel;
  Vector p;
  double hx, hy, h;
};

// Clusters far from a block, as one linear function, which the parts of the block inherit.
struct WindingNumber::Field {
  Vector at;
  double angle = 0, along_x = 0, along_y = 0;

  void move_to(const Vector& p) {
    angle += along_x * (p.x - at.x) + along_y * (p.y - at.y);
    at = p;
  }
};

// Clusters near a block, evaluated at its middle, and again for the parts of the block.
struct WindingNumber::Near {
  double angle = 0;
  Slope slope;
  bool decided = true;  // the slope is known and not too steep
  bool met = false;     // a cap meets the block
};

// Adds a cluster to the field when both it and the block are small compared with their distance, and opens it when it
// is larger than the block; else it is appended to `pool`, the list of the parts of the block.
void WindingNumber::accumulate(std::uint32_t cluster, const Middle& block, Field& field, Near& near,
                               std::vector<std::uint32_t>& pool) const {
  std::array<std::uint32_t, 128> stack;
  std::size_t depth = 0;
  stack[depth++] = cluster;
  while (depth > 0) {
    const std::uint32_t index = stack[--depth];
    const Node& node = nodes_[index];
    const Vector r{node.centre.x - block.p.x, node.centre.y - block.p.y, node.centre.z - block.p.z};
    const double away = std::sqrt(r.x * r.x + r.y * r.y + r.z * r.z);
    const bool separate = node.radius < kFar * (away - block.h);
    if (separate && block.h <= kLinear * away) {
      add_to_field(node, r, block, field);
    } else if (node.right != 0 && node.radius > block.h / 2) {
      stack[depth++] = node.right;
      stack[depth++] = index + 1;
    } else {
      pool.push_back(index);
      if (near.decided) add_near(node, r, away, separate, block, near);
    }
  }
}

void WindingNumber::add_to_field(const Node& node, const Vector& r, const Middle& block, Field& field) {
  const double hx = block.hx, hy = block.hy;
  field.angle += cluster_angle(node, r);
  if (hx > 0)
    field.along_x += (cluster_angle(node, {r.x - hx, r.y, r.z}) - cluster_angle(node, {r.x + hx, r.y, r.z})) / (2 * hx);
  if (hy > 0)
    field.along_y += (cluster_angle(node, {r.x, r.y - hy, r.z}) - cluster_angle(node, {r.x, r.y + hy, r.z})) / (2 * hy);
}

void WindingNumber::add_near(const Node& node, const Vector& r, double away, bool separate, const Middle& block,
                             Near& near) const {
  Slope& slope = near.slope;
  if (separate) {
    near.angle += cluster_angle(node, r);
    if (block.h == 0) return;
    const double gap = away - block.h, cubed = 1 / (away * away * away);
    const double along = 3 * (node.sum.x * r.x + node.sum.y * r.y + node.sum.z * r.z) / (away * away);
    slope.x += cubed * (along * r.x - node.sum.x);
    slope.y += cubed * (along * r.y - node.sum.y);
    slope.error += 9 * node.moment_norm / squared(squared(gap));
    slope.bend += 6 * node.area / squared(squared(gap - node.radius));
  } else if (node.right == 0) {
    for (std::uint32_t k = node.begin; k < node.end; ++k) {
      near.angle += cap_angle(caps_[k], block.voxel, block.p);
      if (block.h == 0) continue;
      add_gradient(caps_[k], block.p, block.h, slope);
      near.met = near.met || (block.hy > 0 && meets(caps_[k], block.p, block.hx, block.hy));
    }
  } else {
    near.decided = false;
  }
  if (near.met || slope.bend * block.h * block.h > kSphere) near.decided = false;
}

// How far W can be from its value at the middle, anywhere in the block.
double WindingNumber::error_bound(const Middle& block, const Field& field, const Slope& slope) {
  const double reach = std::abs(slope.x + field.along_x) * block.hx + std::abs(slope.y + field.along_y) * block.hy +
                       slope.error * block.h + slope.bend * block.h * block.h / 2;
  return reach / kSphere;
}

// Along the longer side, but soon into rows at a cap. Lower x first: rows are filled from left to right.
std::array<WindingNumber::Block, 2> WindingNumber::split(const Block& block, bool met) {
  const std::int64_t nx = block.x1 - block.x0, ny = block.y1 - block.y0;
  Block low = block, high = block;
  if (ny > 1 && (ny >= nx || (met && nx <= 16)))
    low.y1 = high.y0 = block.y0 + ny / 2;
  else
    low.x1 = high.x0 = block.x0 + nx / 2;
  return {low, high};
}

// Blocks are within one slice. Where a cap meets the block, W jumps in it, but g does not along x: such a block must be
// a row.
void WindingNumber::refine(const Block& block, Field field, std::size_t list, std::vector<std::uint32_t>& pool,
                           const Take& take) const {
  const Middle middle(block);
  field.move_to(middle.p);
  const std::size_t end = pool.size();
  Near near;
  for (std::size_t i = list; i < end; ++i) accumulate(pool[i], middle, field, near, pool);
  const double W = (field.angle + near.angle) / kSphere;
  if (middle.h == 0 ||
      (near.decided && std::abs(W - std::nearbyint(W)) + error_bound(middle, field, near.slope) < 0.5)) {
    take(block, W);
    pool.resize(end);
    return;
  }
  for (const Block& part : split(block, near.met)) {
    const std::size_t mine = pool.size();
    // The list of a part must end where the part begins its own.
    for (std::size_t i = end; i < mine; ++i) pool.push_back(pool[i]);
    refine(part, field, mine, pool, take);
    pool.resize(mine);
  }
  pool.resize(end);
}

double WindingNumber::caps_angle(std::int64_t x, std::int64_t y, std::int64_t z) const {
  if (closed()) return 0;
  double value = 0;
  std::vector<std::uint32_t> pool{0};
  refine({x, x + 1, y, y + 1, z}, {}, 0, pool, [&](const Block&, double W) { value = W; });
  return value;
}

double WindingNumber::g(std::int64_t x, std::int64_t y, std::int64_t z) const {
  int crossings = 0;
  for (const auto& [a, b, c] : faces_) crossings += crossings_until(points_[a], points_[b], points_[c], {x, y, z});
  return caps_angle(x, y, z) - crossings;
}

void WindingNumber::offsets(std::int64_t z, const std::array<std::int64_t, 3>& cells, const CapCrossings& crossings,
                            std::vector<std::vector<OffsetStep>>& rows) const {
  rows.resize(static_cast<std::size_t>(cells[1]));
  for (auto& row : rows) row.clear();
  const Block slice{0, cells[0], 0, cells[1], z};
  const Take take = [&](const Block& block, double W) {
    const auto whole = static_cast<std::int32_t>(std::nearbyint(W));
    for (std::int64_t y = block.y0; y < block.y1; ++y) {
      const std::int32_t offset = whole - (closed() ? 0 : crossings.until(block.middle()[0], y));
      auto& row = rows[static_cast<std::size_t>(y)];
      if (row.empty() || row.back().offset != offset) row.push_back({static_cast<std::int32_t>(block.x0), offset});
    }
  };
  if (closed()) return take(slice, 0);
  std::vector<std::uint32_t> pool{0};
  refine(slice, {}, 0, pool, take);
}

}  // namespace quench::voxelization
