// SPDX-License-Identifier: Apache-2.0
#include "shape/winding_number.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "shape/surface_edges.h"

namespace quench::detail {
namespace {

constexpr std::uint32_t leaf_size = 8;
// A cluster is seen as its moments when its radius is below this share of the distance from it to the point and to the
// line on which its strips would jump.
constexpr double far = 0.3;
constexpr double linear = 0.25;  // the same for a block in which its angle is taken as linear
constexpr double sphere = 4 * std::numbers::pi;

double squared(double v) { return v * v; }

/// Distance in n dimensions from the origin to the segment from a to b.
template <std::size_t n>
double distance(const std::array<double, n>& a, const std::array<double, n>& b) {
  double ab = 0, along = 0;
  for (std::size_t i = 0; i < n; ++i) {
    ab += squared(b[i] - a[i]);
    along -= a[i] * (b[i] - a[i]);
  }
  const double t = ab > 0 ? std::clamp(along / ab, 0.0, 1.0) : 0;
  double sum = 0;
  for (std::size_t i = 0; i < n; ++i) sum += squared(a[i] + t * (b[i] - a[i]));
  return std::sqrt(sum);
}

/// |v| + v.x without cancellation; rho2 = v.y^2 + v.z^2.
double length_plus_x(double x, double rho2, double length) { return x >= 0 ? length + x : rho2 / (length - x); }

/// The sign of ay * bz - az * by for the scanline shifted as scan_conversion.cpp shifts it: y by more than z.
double exact_sign(double ay, double az, double by, double bz) {
  const auto fixed = [](double v) { return static_cast<__int128>(std::llround(std::ldexp(v, fraction_bits))); };
  const __int128 d = fixed(ay) * fixed(bz) - fixed(az) * fixed(by);
  if (d != 0) return d > 0 ? 1 : -1;
  if (az != bz) return az > bz ? 1 : -1;
  return by > ay ? 1 : by < ay ? -1 : 0;
}

}  // namespace

WindingNumber::WindingNumber(std::span<const FixedPoint> points, std::span<const std::array<std::uint32_t, 3>> faces) {
  const auto in_voxels = [&](std::uint32_t p) {
    const FixedPoint& q = points[p];
    const auto voxels = [](std::int64_t v) { return std::ldexp(static_cast<double>(v), -fraction_bits); };
    return Vector{voxels(q[0]), voxels(q[1]), voxels(q[2])};
  };
  for (const BoundaryEdge& e : boundary_chain(points.size(), faces)) {
    Edge edge{in_voxels(e.from), in_voxels(e.to), static_cast<double>(e.times), 0};
    edge.length = std::hypot(edge.b.x - edge.a.x, edge.b.y - edge.a.y, edge.b.z - edge.a.z);
    edges_.push_back(edge);
  }
  if (edges_.empty()) return;
  nodes_.reserve(edges_.size() / 2 + 1);
  build(0, static_cast<std::uint32_t>(edges_.size()));
}

std::uint32_t WindingNumber::build(std::uint32_t begin, std::uint32_t end) {
  const auto index = static_cast<std::uint32_t>(nodes_.size());
  nodes_.emplace_back();
  nodes_[index].begin = begin;
  nodes_[index].end = end;
  if (end - begin > leaf_size) {
    std::array<double, 3> low, high;
    low.fill(std::numeric_limits<double>::infinity());
    high.fill(-std::numeric_limits<double>::infinity());
    const auto middle = [](const Edge& e) {  // twice the middle
      return std::array<double, 3>{e.a.x + e.b.x, e.a.y + e.b.y, e.a.z + e.b.z};
    };
    for (std::uint32_t e = begin; e < end; ++e) {
      const auto m = middle(edges_[e]);
      for (std::size_t a = 0; a < 3; ++a) {
        low[a] = std::min(low[a], m[a]);
        high[a] = std::max(high[a], m[a]);
      }
    }
    std::size_t axis = 0;
    for (std::size_t a = 1; a < 3; ++a)
      if (high[a] - low[a] > high[axis] - low[axis]) axis = a;
    const std::uint32_t half = begin + (end - begin) / 2;
    std::nth_element(edges_.begin() + begin, edges_.begin() + half, edges_.begin() + end,
                     [&](const Edge& e, const Edge& f) { return middle(e)[axis] < middle(f)[axis]; });
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
    const Edge& e = edges_[i];
    c = {c.x + e.a.x + e.b.x, c.y + e.a.y + e.b.y, c.z + e.a.z + e.b.z};
  }
  const double ends = 2.0 * (node.end - node.begin);
  c = {c.x / ends, c.y / ends, c.z / ends};
  for (std::uint32_t i = node.begin; i < node.end; ++i) {
    const Edge& e = edges_[i];
    for (const Vector& v : {e.a, e.b}) node.radius = std::max(node.radius, std::hypot(v.x - c.x, v.y - c.y, v.z - c.z));
    node.length += e.times * e.length;
    const std::array<double, 3> along{e.times * (e.b.x - e.a.x), e.times * (e.b.y - e.a.y), e.times * (e.b.z - e.a.z)};
    const std::array<double, 3> offset{(e.a.x + e.b.x) / 2 - c.x, (e.a.y + e.b.y) / 2 - c.y, (e.a.z + e.b.z) / 2 - c.z};
    node.sum = {node.sum.x + along[0], node.sum.y + along[1], node.sum.z + along[2]};
    for (std::size_t r = 0; r < 3; ++r)
      for (std::size_t k = 0; k < 3; ++k) node.moment[r][k] += along[r] * offset[k];
  }
  node.sum_norm = std::hypot(node.sum.x, node.sum.y, node.sum.z);
  for (const auto& row : node.moment)
    for (const double v : row) node.moment_norm += v * v;
  node.moment_norm = std::sqrt(node.moment_norm);
}

// The strip of an edge, seen from p, is the spherical triangle of a, b and +x (van Oosterom and Strackee 1983).
double WindingNumber::strip_angle(const Edge& edge, const Vector& p) {
  const double ax = edge.a.x - p.x, ay = edge.a.y - p.y, az = edge.a.z - p.z;
  const double bx = edge.b.x - p.x, by = edge.b.y - p.y, bz = edge.b.z - p.z;
  const double a2 = ay * ay + az * az, b2 = by * by + bz * bz;
  const double cosine =
      length_plus_x(ax, a2, std::sqrt(ax * ax + a2)) * length_plus_x(bx, b2, std::sqrt(bx * bx + b2)) + ay * by +
      az * bz;
  double sine = ay * bz - az * by;
  if (cosine <= 0 && std::abs(sine) <= 0x1p-49 * (std::abs(ay * bz) + std::abs(az * by))) {
    const double sign = exact_sign(ay, az, by, bz);  // only here it decides on a whole turn
    if (sign == 0) return 0;
    sine = std::copysign(sine, sign);
  }
  return 2 * edge.times * std::atan2(sine, cosine);
}

// The angle of a short edge dl at r is A(r) dl with A = (x cross r) / (|r| (|r| + r.x)), x the unit vector; the moments
// of a cluster give the integral of the linear part of A around its centre.
double WindingNumber::cluster_angle(const Node& node, const Vector& r) {
  const double rho2 = r.y * r.y + r.z * r.z, s = std::sqrt(r.x * r.x + rho2);
  const double h = 1 / (s * length_plus_x(r.x, rho2, s));
  const Vector turned{0, -r.z, r.y};
  const double value = h * (turned.y * node.sum.y + turned.z * node.sum.z);
  const auto& m = node.moment;
  double first = h * (m[2][1] - m[1][2]);  // the derivatives of `turned`
  const double common = 2 + r.x / s;
  const std::array<double, 3> slope{common * r.x + s, common * r.y, common * r.z};  // of 1 / h
  for (std::size_t k = 0; k < 3; ++k) first -= h * h * slope[k] * (turned.y * m[1][k] + turned.z * m[2][k]);
  return value + first;
}

// What a block inherits from the one around it: the sum of clusters far from that one, as a linear function, and the
// clusters still to look at, at the end of `pool`.
struct WindingNumber::Field {
  Vector at;
  double angle = 0, along_x = 0, along_y = 0;
};

// Blocks are within one slice. A cluster goes into the linear function when both it and the block are small compared
// with their distance, and is opened when it is larger than the block; else the children of the block look at it.
void WindingNumber::refine(const Block& block, Field field, std::size_t list, std::vector<std::uint32_t>& pool,
                           const Take& take) const {
  const auto middle = [](std::int64_t low, std::int64_t high) { return static_cast<double>(low + high) / 2; };
  const Vector p{middle(block.x0, block.x1), middle(block.y0, block.y1), static_cast<double>(block.z) + 0.5};
  // Half extents of the box of its centres.
  const double hx = static_cast<double>(block.x1 - block.x0 - 1) / 2;
  const double hy = static_cast<double>(block.y1 - block.y0 - 1) / 2;
  const double h = std::hypot(hx, hy);
  field.angle += field.along_x * (p.x - field.at.x) + field.along_y * (p.y - field.at.y);
  field.at = p;
  const std::size_t end = pool.size();
  double angle = 0, slope = 0;  // of what stays in the list
  bool decided = true, broken = false;
  std::array<std::uint32_t, 128> stack;
  for (std::size_t i = list; i < end; ++i) {
    std::size_t depth = 0;
    stack[depth++] = pool[i];
    while (depth > 0) {
      const std::uint32_t index = stack[--depth];
      const Node& node = nodes_[index];
      const Vector r{node.centre.x - p.x, node.centre.y - p.y, node.centre.z - p.z};
      const double rho = std::sqrt(r.y * r.y + r.z * r.z), away = std::sqrt(r.x * r.x + rho * rho);
      const bool ahead = r.x > node.radius + hx;  // its strips do not pass the block
      const bool separate = node.radius < far * (ahead ? away - h : rho - hy);
      if (separate && hx <= linear * away && hy <= linear * (ahead ? away : rho)) {
        field.angle += cluster_angle(node, r);
        if (hx > 0)
          field.along_x +=
              (cluster_angle(node, {r.x - hx, r.y, r.z}) - cluster_angle(node, {r.x + hx, r.y, r.z})) / (2 * hx);
        if (hy > 0)
          field.along_y +=
              (cluster_angle(node, {r.x, r.y - hy, r.z}) - cluster_angle(node, {r.x, r.y + hy, r.z})) / (2 * hy);
        continue;
      }
      if (node.right != 0 && node.radius > h / 2) {
        stack[depth++] = node.right;
        stack[depth++] = index + 1;
        continue;
      }
      pool.push_back(index);
      if (!decided) continue;
      if (separate) {
        angle += cluster_angle(node, r);
        const double near = std::max(away - h, rho - hy);
        slope += std::min(node.length / squared(near - node.radius),
                          node.sum_norm / squared(near) + 3 * node.moment_norm / (near * near * near));
      } else if (node.right == 0) {
        for (std::uint32_t k = node.begin; k < node.end; ++k) {
          const Edge& e = edges_[k];
          angle += strip_angle(e, p);
          if (h == 0) continue;
          const double flat = distance<2>({e.a.y - p.y, e.a.z - p.z}, {e.b.y - p.y, e.b.z - p.z}) - hy;
          if (hy > 0 && flat <= 0 && std::min(e.a.x, e.b.x) <= p.x + hx) broken = true;
          const double solid =
              distance<3>({e.a.x - p.x, e.a.y - p.y, e.a.z - p.z}, {e.b.x - p.x, e.b.y - p.y, e.b.z - p.z}) - h;
          const double near = std::max(flat, solid);
          slope += near <= 0 ? std::numeric_limits<double>::infinity()
                             : e.times * std::min(e.length / squared(near), 2 / near);
        }
      } else {
        decided = false;
        broken = hy > 0 && std::min(away - h, rho - hy) > hx;  // far along x only
      }
      if (broken || slope * h > sphere / 2) decided = false;
    }
  }
  const double g = -(field.angle + angle) / sphere;
  if (h > 0 && decided) {
    const double reach = std::abs(field.along_x) * hx + std::abs(field.along_y) * hy + slope * h;
    decided = std::abs(g - std::nearbyint(g)) + reach / sphere < 0.5;
  }
  if (decided || h == 0) {
    take(block, g);
    pool.resize(end);
    return;
  }
  // Along y at a jump between scanlines, else along the longer side. Lower x first: rows are filled from left to right.
  const std::int64_t nx = block.x1 - block.x0, ny = block.y1 - block.y0;
  Block low = block, high = block;
  if (ny > 1 && (broken || ny >= nx))
    low.y1 = high.y0 = block.y0 + ny / 2;
  else
    low.x1 = high.x0 = block.x0 + nx / 2;
  for (const Block& part : {low, high}) {
    const std::size_t mine = pool.size();
    // The part looks at a list that ends where its own begins.
    for (std::size_t i = end; i < mine; ++i) pool.push_back(pool[i]);
    refine(part, field, mine, pool, take);
    pool.resize(mine);
  }
  pool.resize(end);
}

double WindingNumber::g(std::int64_t x, std::int64_t y, std::int64_t z) const {
  if (closed()) return 0;
  double value = 0;
  std::vector<std::uint32_t> pool{0};
  refine({x, x + 1, y, y + 1, z}, {}, 0, pool, [&](const Block&, double g) { value = g; });
  return value;
}

void WindingNumber::offsets(std::int64_t z, const std::array<std::int64_t, 3>& cells,
                            std::vector<std::vector<OffsetStep>>& rows) const {
  rows.resize(static_cast<std::size_t>(cells[1]));
  for (auto& row : rows) row.clear();
  const Take take = [&](const Block& block, double g) {
    const auto offset = static_cast<std::int32_t>(std::nearbyint(g));
    for (std::int64_t y = block.y0; y < block.y1; ++y) {
      auto& row = rows[static_cast<std::size_t>(y)];
      if (row.empty() || row.back().offset != offset) row.push_back({static_cast<std::int32_t>(block.x0), offset});
    }
  };
  const Block slice{0, cells[0], 0, cells[1], z};
  if (closed()) return take(slice, 0);
  std::vector<std::uint32_t> pool{0};
  refine(slice, {}, 0, pool, take);
}

}  // namespace quench::detail
