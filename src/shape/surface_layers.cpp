// SPDX-License-Identifier: Apache-2.0
#include "shape/surface_layers.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "quench/error.h"
#include "shape/cell_loops.h"

namespace quench::shape {
namespace {

// Marks vertices of the upper slice, whose final place in the list is known at the end of the layer.
constexpr std::uint32_t kUpper = std::uint32_t{1} << 31;
constexpr std::int64_t kEnd = std::numeric_limits<std::int64_t>::max();

/// Calls visit(begin, end, foreground) for columns of the same foreground, a bit per scanline, from the first that has
/// any to what follows the last one, which goes on to kEnd.
template <std::size_t N, class Visit>
void for_columns(const std::array<std::span<const Run>, N>& rows, const Visit& visit) {
  std::array<const Run*, N> run;
  std::array<std::int64_t, N> next;
  unsigned foreground = 0;
  const auto look = [&](std::size_t r) {
    if (run[r] == rows[r].data() + rows[r].size()) return kEnd;
    return std::int64_t{foreground >> r & 1 ? run[r]->end : run[r]->begin};
  };
  for (std::size_t r = 0; r < N; ++r) {
    run[r] = rows[r].data();
    next[r] = look(r);
  }
  for (std::int64_t begin = *std::min_element(next.begin(), next.end()); begin != kEnd;) {
    for (std::size_t r = 0; r < N; ++r) {
      if (next[r] != begin) continue;
      if (foreground >> r & 1) ++run[r];
      foreground ^= 1u << r;
      next[r] = look(r);
    }
    const std::int64_t end = *std::min_element(next.begin(), next.end());
    visit(begin, end, foreground);
    begin = end;
  }
}

bool one_of_two(unsigned foreground) { return foreground == 1 || foreground == 2; }

/// Where between two samples of different sides they are 0.
double fraction(double first, double second) {
  const double t = first / (first - second);
  if (!std::isfinite(first) || !std::isfinite(second) || !std::isfinite(t)) return 0.5;
  return std::clamp(t, SurfaceLayers::kClearance, 1 - SurfaceLayers::kClearance);
}

/// The trilinear interpolation of the corners of a cell, and its gradient.
double interpolate(const std::array<double, 8>& v, const Vec3& p, Vec3& gradient) {
  const auto mix = [](double a, double b, double t) { return a + (b - a) * t; };
  const double a = mix(v[0], v[1], p[0]), b = mix(v[2], v[3], p[0]), c = mix(v[4], v[5], p[0]),
               d = mix(v[6], v[7], p[0]);
  gradient[0] = mix(mix(v[1] - v[0], v[3] - v[2], p[1]), mix(v[5] - v[4], v[7] - v[6], p[1]), p[2]);
  gradient[1] = mix(b - a, d - c, p[2]);
  const double low = mix(a, b, p[1]), high = mix(c, d, p[1]);
  gradient[2] = high - low;
  return mix(low, high, p[2]);
}

/// A point of the surface in a cell near `start`, by Newton's method; `start` where that leads nowhere.
Vec3 on_surface(const std::array<double, 8>& v, const Vec3& start) {
  constexpr int kSteps = 4;
  constexpr double kNear = 1e-4, kFar = 0.5;  // of a voxel
  Vec3 p = start, gradient;
  for (int step = 0; step < kSteps; ++step) {
    const double height = interpolate(v, p, gradient), steep = gradient.squaredNorm();
    const Vec3 move = gradient * (-height / steep);
    if (!move.allFinite()) return start;
    p = (p + move).cwiseMax(SurfaceLayers::kClearance).cwiseMin(1 - SurfaceLayers::kClearance);
    if (move.squaredNorm() < kNear * kNear) break;
  }
  const bool nearer = std::abs(interpolate(v, p, gradient)) <= std::abs(interpolate(v, start, gradient));
  return nearer && (p - start).squaredNorm() < kFar * kFar ? p : start;
}

}  // namespace

/// The four scanlines of a row of cells: bit dy + 2 dz.
struct SurfaceLayers::Row {
  std::int64_t y, z;
  std::array<std::uint32_t, 4> along_x;  ///< the next vertex along x of every scanline
  std::array<std::uint32_t, 2> along_y;  ///< behind the vertices of the left column: dz
  std::array<std::uint32_t, 2> along_z;  ///< the same: dy
};

/// Signed values of the four voxels of a column of a row of cells.
struct SurfaceLayers::Column {
  std::int64_t x = kEnd;  ///< of the voxels that were read
  std::array<double, 4> value;
};

SurfaceLayers::SurfaceLayers(const VoxelShape& shape, const SignedSamples* samples, std::int64_t first_layer)
    : shape_(shape), samples_(samples), layer_(first_layer) {
  read_slice(first_layer, upper_);
}

double SurfaceLayers::value(std::int64_t x, std::int64_t y, std::int64_t z, bool foreground) const {
  if (!samples_) return foreground ? 1 : -1;
  const auto& dims = shape_.grid().dims;
  const std::int64_t i = std::clamp<std::int64_t>(x, 0, dims[0] - 1), j = std::clamp<std::int64_t>(y, 0, dims[1] - 1),
                     k = std::clamp<std::int64_t>(z, 0, dims[2] - 1);
  double v = samples_->at(i, j, k);
  if (i != x || j != y || k != z) v = -std::abs(v);
  // The voxels decide: of one that was added to those of the value nothing is known.
  if (foreground && v < 0) v = std::numeric_limits<double>::quiet_NaN();
  constexpr double least = std::numeric_limits<double>::min();
  return std::isnan(v) ? v : foreground ? std::max(v, least) : std::min(v, -least);
}

Vec3 SurfaceLayers::on_edge(std::int64_t x, std::int64_t y, std::int64_t z, int axis, bool first_is_foreground) const {
  std::array<std::int64_t, 3> second{x, y, z};
  ++second[static_cast<std::size_t>(axis)];
  Vec3 place(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5, static_cast<double>(z) + 0.5);
  place[axis] +=
      fraction(value(x, y, z, first_is_foreground), value(second[0], second[1], second[2], !first_is_foreground));
  return place;
}

// The vertices in the plane of the voxel centres of a slice, scanline by scanline: along x, then towards y + 1.
void SurfaceLayers::read_slice(std::int64_t z, Slice& slice) const {
  const std::int64_t height = shape_.grid().dims[1];
  slice.points.clear();
  slice.along_x.clear();
  slice.along_y.clear();
  const auto at = [&] { return static_cast<std::uint32_t>(slice.points.size()); };
  for (std::int64_t y = -1; y <= height; ++y) {
    slice.along_x.push_back(at());
    for (const Run& run : shape_.row(y, z)) {
      slice.points.push_back(on_edge(run.begin - 1, y, z, 0, false));
      slice.points.push_back(on_edge(run.end - 1, y, z, 0, true));
    }
    slice.along_y.push_back(at());
    for_columns<2>({shape_.row(y, z), shape_.row(y + 1, z)},
                   [&](std::int64_t begin, std::int64_t end, unsigned foreground) {
                     if (!one_of_two(foreground)) return;
                     for (std::int64_t x = begin; x < end; ++x)
                       slice.points.push_back(on_edge(x, y, z, 1, foreground == 1));
                   });
  }
}

void SurfaceLayers::add_upright(std::int64_t z) {
  const std::int64_t height = shape_.grid().dims[1];
  upright_.clear();
  for (std::int64_t y = -1; y <= height; ++y) {
    upright_.push_back(static_cast<std::uint32_t>(mesh.points.size()));
    for_columns<2>({shape_.row(y, z), shape_.row(y, z + 1)},
                   [&](std::int64_t begin, std::int64_t end, unsigned foreground) {
                     if (!one_of_two(foreground)) return;
                     for (std::int64_t x = begin; x < end; ++x)
                       mesh.points.push_back(on_edge(x, y, z, 2, foreground == 1));
                   });
  }
}

void SurfaceLayers::add_layer() {
  const std::int64_t z = layer_++, height = shape_.grid().dims[1];
  std::swap(lower_, upper_);
  read_slice(z + 1, upper_);
  const auto base = static_cast<std::uint32_t>(mesh.points.size());
  for (auto* begins : {&lower_.along_x, &lower_.along_y})
    for (std::uint32_t& begin : *begins) begin += base;
  for (auto* begins : {&upper_.along_x, &upper_.along_y})
    for (std::uint32_t& begin : *begins) begin |= kUpper;
  mesh.points.insert(mesh.points.end(), lower_.points.begin(), lower_.points.end());
  add_upright(z);
  const std::size_t triangle = mesh.triangles.size();
  for (std::int64_t y = -1; y < height; ++y) add_row(y, z);
  if (mesh.points.size() + upper_.points.size() >= kUpper)
    throw Error(ErrorCode::failed, "the surface has more than 2^31 vertices; use the voxels alone");
  const auto next = static_cast<std::uint32_t>(mesh.points.size());
  for (std::size_t t = triangle; t < mesh.triangles.size(); ++t)
    for (std::uint32_t& corner : mesh.triangles[t])
      if (corner & kUpper) corner = next + (corner & ~kUpper);
  for (auto* begins : {&upper_.along_x, &upper_.along_y})
    for (std::uint32_t& begin : *begins) begin &= ~kUpper;
}

void SurfaceLayers::read(Column& column, std::int64_t x, std::int64_t y, std::int64_t z, unsigned foreground) const {
  if (column.x == x) return;
  column.x = x;
  for (unsigned r = 0; r < 4; ++r) column.value[r] = value(x, y + (r & 1), z + (r >> 1), (foreground >> r & 1) != 0);
}

void SurfaceLayers::add_row(std::int64_t y, std::int64_t z) {
  const auto i = static_cast<std::size_t>(y + 1);
  Row row{y,
          z,
          {lower_.along_x[i], lower_.along_x[i + 1], upper_.along_x[i], upper_.along_x[i + 1]},
          {lower_.along_y[i], upper_.along_y[i]},
          {upright_[i], upright_[i + 1]}};
  Column left, right;
  unsigned before = 0;
  const auto step = [&](std::int64_t x, unsigned foreground) {  // the cell between columns x - 1 and x
    int corners = 0;
    for (unsigned r = 0; r < 4; ++r)
      corners |= static_cast<int>((before >> r & 1) << (2 * r) | (foreground >> r & 1) << (2 * r + 1));
    if (corners != 0 && corners != 255) {
      read(left, x - 1, y, z, before);
      read(right, x, y, z, foreground);
      add_cell(corners, row, x - 1, left, right);
    }
    for (unsigned r = 0; r < 4; ++r) row.along_x[r] += (before ^ foreground) >> r & 1;
    for (unsigned d = 0; d < 2; ++d) {
      row.along_y[d] += one_of_two(foreground >> (2 * d) & 3);
      row.along_z[d] += (foreground >> d & 1) != (foreground >> (d + 2) & 1);
    }
    before = foreground;
    std::swap(left, right);
  };
  for_columns<4>({shape_.row(y, z), shape_.row(y + 1, z), shape_.row(y, z + 1), shape_.row(y + 1, z + 1)},
                 [&](std::int64_t begin, std::int64_t end, unsigned foreground) {
                   step(begin, foreground);
                   if (foreground == 0 || foreground == 15) return;  // columns that are all one have no surface
                   for (std::int64_t x = begin + 1; x < end; ++x) step(x, foreground);
                 });
}

void SurfaceLayers::add_cell(int corners, const Row& row, std::int64_t x, const Column& left, const Column& right) {
  const CellLoops& loops = cell_loops()[static_cast<std::size_t>(corners)];
  std::array<double, 8> value;
  for (std::size_t r = 0; r < 4; ++r) {
    value[2 * r] = left.value[r];
    value[2 * r + 1] = right.value[r];
  }
  // Vertices of the left column are the last ones that were passed, those of the right column the next ones.
  std::array<std::uint32_t, kCellEdges> id;
  for (std::size_t e = 0; e < 4; ++e) {
    id[e] = row.along_x[e];
    id[4 + e] = row.along_y[e >> 1] - (e & 1 ? 0 : 1);
    id[8 + e] = row.along_z[e >> 1] - (e & 1 ? 0 : 1);
  }
  if (loops.tube) return add_tube(loops.edges.data(), id);
  std::array<Vec3, kCellEdges> place;
  const Vec3 corner(static_cast<double>(x) + 0.5, static_cast<double>(row.y) + 0.5, static_cast<double>(row.z) + 0.5);
  const std::uint8_t* first = loops.edges.data();
  for (std::size_t loop = 0; loop < loops.count; ++loop) {
    const std::span<const std::uint8_t> edges(first, loops.length[loop]);
    first += loops.length[loop];
    for (const std::uint8_t e : edges) {
      const auto [a, b] = corners_of_edge(e);
      place[e] = Vec3(a & 1, a >> 1 & 1, a >> 2);
      place[e][e / 4] = fraction(value[static_cast<std::size_t>(a)], value[static_cast<std::size_t>(b)]);
    }
    add_loop(edges, id, place, value, corner);
  }
}

// Two opposite background corners: seen along their diagonal, every edge of one lies between two edges of the other.
void SurfaceLayers::add_tube(const std::uint8_t* edges, const std::array<std::uint32_t, 12>& id) {
  for (int side = 0; side < 2; ++side)
    for (int i = 0; i < 3; ++i) {
      const int a = edges[3 * side + i], b = edges[3 * side + (i + 1) % 3];
      const int third = 3 - a / 4 - b / 4;
      const std::uint8_t* other = edges + 3 * (1 - side);
      const int c = *std::find_if(other, other + 3, [&](int e) { return e / 4 == third; });
      mesh.triangles.push_back(
          {id[static_cast<std::size_t>(a)], id[static_cast<std::size_t>(b)], id[static_cast<std::size_t>(c)]});
    }
}

void SurfaceLayers::add_loop(std::span<const std::uint8_t> edges, const std::array<std::uint32_t, 12>& id,
                             const std::array<Vec3, 12>& place, const std::array<double, 8>& value,
                             const Vec3& corner) {
  Vec3 centre = Vec3::Zero();
  for (const std::uint8_t e : edges) centre += place[e];
  centre /= static_cast<double>(edges.size());
  if (samples_) {
    const Vec3 better = on_surface(value, centre);
    // Not where a triangle of the fan would turn over.
    const auto normal = [&](std::size_t i, const Vec3& from) -> Vec3 {
      return (place[edges[i]] - from).cross(place[edges[(i + 1) % edges.size()]] - from);
    };
    bool keeps = true;
    for (std::size_t i = 0; i < edges.size(); ++i) keeps &= normal(i, centre).dot(normal(i, better)) > 0;
    if (keeps) centre = better;
  }
  const auto middle = static_cast<std::uint32_t>(mesh.points.size());
  mesh.points.push_back(corner + centre);
  for (std::size_t i = 0; i < edges.size(); ++i)
    mesh.triangles.push_back({id[edges[i]], id[edges[(i + 1) % edges.size()]], middle});
}

}  // namespace quench::shape
