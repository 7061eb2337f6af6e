// SPDX-License-Identifier: Apache-2.0
#include "voxelization/scan_conversion.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "base/csr.h"
#include "voxelization/winding_number.h"

// Where ties are decided. The centre c of every voxel is shifted by (e1, e2, e3), with e1 infinitely larger than e2 and
// e2 infinitely larger than e3 > 0 (for instance e1 = e, e2 = e^2, e3 = e^3 for all sufficiently small e). With
// respect to the shifted centre the mesh is in general position, and every decision below is that of this one shift:
//   - An edge spans the slice Z when one end is <= Z and the other > Z: a point at height Z is below Z + e3.
//   - On that slice the edge is at y*(Z + e3); a centre lies beyond it when Y + e2 > y*(Z + e3), that is, when
//     Y >= y*(Z), since the slope times e3 is smaller than e2. The number depends on the edge alone, not on the face
//     or its orientation: neighbouring faces agree on which of them a scanline meets. An edge with both ends on one
//     side of Z + e3 is not met, in particular none that is parallel to y; a vertex is never met.
//   - A face that projects to a line is not met by any scanline: its two spanning edges have the same y*.
//   - On its scanline a face is at x*(Y + e2, Z + e3); a centre lies beyond it when X >= x*(Y, Z), since both slopes
//     times their shifts are smaller than e1.
// The crossings of a closed mesh along a scanline therefore always have the sum 0: it cannot leak.
//
// Bounds. Coordinates are <= 2^14 voxels = 2^34, differences < 2^34 + 1; products of two < 2^68 + 2^36, components of a
// normal < 2^70; a normal component times a difference < 2^104 + 2^71, the sum of two < 2^106. Int128 holds them all.

namespace quench::voxelization {
namespace {

using Int128 = __int128;

constexpr std::int64_t kUnit = std::int64_t{1} << kFractionBits;
constexpr std::int64_t kHalf = kUnit / 2;

/// The smallest i whose centre i + 1/2 is at or beyond v, |v| < 2^62. (>> rounds down, also negative numbers.)
std::int64_t first_centre_from(std::int64_t v) { return (v - kHalf + kUnit - 1) >> kFractionBits; }
std::int64_t centre(std::int64_t i) { return i * kUnit + kHalf; }

template <class Integer>
Integer quotient_up(Integer n, Integer d) {  // d > 0
  const Integer q = n / d;
  return q + (q * d < n);
}

/// First scanline of the slice Z at or beyond the edge ab; Z is at or above one end and below the other.
std::int64_t first_scanline(const FixedPoint* a, const FixedPoint* b, std::int64_t Z) {
  if ((*a)[2] > (*b)[2]) std::swap(a, b);
  const std::int64_t dy = (*b)[1] - (*a)[1], dz = (*b)[2] - (*a)[2], t = Z - (*a)[2];  // 0 <= t < dz
  constexpr std::int64_t kSmall = std::int64_t{1} << 31;                               // products < 2^62
  const std::int64_t step = dz < kSmall && dy < kSmall && -dy < kSmall
                                ? quotient_up(dy * t, dz)
                                : static_cast<std::int64_t>(quotient_up<Int128>(Int128{dy} * t, dz));  // |step| <= |dy|
  return first_centre_from((*a)[1] + step);
}

/// Crossings of one face with the scanlines of a slice.
class FacePlane {
 public:
  FacePlane(const FixedPoint& a, const FixedPoint& b, const FixedPoint& c, std::int64_t Z) : x0_(a[0]), y0_(a[1]) {
    const Int128 ux = b[0] - a[0], uy = b[1] - a[1], uz = b[2] - a[2];
    const Int128 vx = c[0] - a[0], vy = c[1] - a[1], vz = c[2] - a[2];
    nx_ = uy * vz - uz * vy;
    ny_ = uz * vx - ux * vz;
    const Int128 nz = ux * vy - uy * vx;
    leaving_ = nx_ > 0;  // the normal points along the scanline
    // With nx > 0: nx (x* - x0) = -ny (Y - y0) - nz (Z - z0).
    if (!leaving_)
      nx_ = -nx_;
    else
      ny_ = -ny_;
    at_slice_ = (leaving_ ? -nz : nz) * (Z - a[2]);
    // In double, v = x* - x0 - 1/2 in voxels, for centres inside the face's box. Each term has at most 5 roundings of
    // relative size 2^-53, the sums 3 more of what they add; `error_` allows 2^-49 of the sum of all magnitudes.
    const double scale = 1.0 / (static_cast<double>(nx_) * static_cast<double>(kUnit));
    slope_ = static_cast<double>(ny_) * scale;
    base_ = static_cast<double>(at_slice_) * scale;
    offset_ = static_cast<double>(x0_ - kHalf) / static_cast<double>(kUnit);
    const double reach = static_cast<double>(std::max({std::abs(b[1] - a[1]), std::abs(c[1] - a[1]), std::int64_t{1}}));
    error_ = 0x1p-49 * (std::abs(slope_) * reach + std::abs(base_) + std::abs(offset_) + 1);
  }

  /// First voxel of the scanline Y whose centre lies beyond the face.
  std::int64_t first_voxel(std::int64_t Y) const {
    const std::int64_t dy = Y - y0_;
    if (error_ < 0.25) {
      const double v = slope_ * static_cast<double>(dy) + base_ + offset_;  // > -1; + 2 makes truncation rounding down
      const auto low = static_cast<std::int64_t>(v - error_ + 2), high = static_cast<std::int64_t>(v + error_ + 2);
      if (low == high) return low - 1;
    }
    return first_centre_from(x0_ + static_cast<std::int64_t>(quotient_up<Int128>(ny_ * dy + at_slice_, nx_)));
  }
  bool leaving() const { return leaving_; }

 private:
  std::int64_t x0_, y0_;
  Int128 nx_, ny_, at_slice_;
  bool leaving_;
  double slope_, base_, offset_, error_;
};

/// One crossing as a number that sorts by scanline, then voxel: y (31 bits), x (32 bits), leaving (1 bit).
std::uint64_t pack(std::int64_t y, std::int64_t x, bool leaving) {
  return static_cast<std::uint64_t>(y) << 33 | static_cast<std::uint64_t>(x) << 1 | (leaving ? 1u : 0u);
}

/// One slice of the shape.
struct Slice {
  std::vector<Run> runs;
  std::vector<std::uint32_t> row_end;  ///< per scanline of the box: end of its runs
  std::int64_t defective = 0, winding_voxels = 0, sampled = 0, doubtful = 0;
  bool overlapping = false;
};

class Converter {
 public:
  /// The triangles of `mesh` from `faces` on are the caps of `winding`.
  Converter(const FixedMesh& mesh, std::size_t faces, std::int64_t margin, Inside inside, const WindingNumber* winding)
      : mesh_(mesh), faces_(faces), margin_(margin), inside_(inside), winding_(winding) {
    constexpr std::int64_t kSamples = 1 << 13;
    stride_ = std::max<std::int64_t>(1, mesh.cells[0] * mesh.cells[1] * mesh.cells[2] / kSamples);
  }

  std::array<std::int64_t, 2> slices_of(std::uint32_t triangle) const {
    const auto& [a, b, c] = mesh_.triangles[triangle];
    const auto [low, high] = std::minmax({mesh_.points[a][2], mesh_.points[b][2], mesh_.points[c][2]});
    return {first_centre_from(low), first_centre_from(high)};
  }

  CapCrossings crossings(std::int64_t z) const {
    std::vector<std::uint64_t> list;
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) cross(t, centre(z), list);
    return summed(list);
  }

  Slice convert(std::int64_t z, std::span<const std::uint32_t> triangles) const {
    std::vector<std::uint64_t> crossings, of_caps;
    for (const std::uint32_t t : triangles) cross(t, centre(z), t < faces_ ? crossings : of_caps);
    std::sort(crossings.begin(), crossings.end());
    std::vector<std::vector<OffsetStep>> offsets;
    CapCrossings cap_crossings;
    if (winding_) {
      cap_crossings = summed(of_caps);
      winding_->offsets(z, mesh_.cells, cap_crossings, offsets);
    }
    Slice slice;
    slice.row_end.reserve(static_cast<std::size_t>(mesh_.cells[1]));
    auto at = crossings.begin();
    for (std::int64_t y = 0; y < mesh_.cells[1]; ++y) {
      const auto begin = at;
      while (at != crossings.end() && static_cast<std::int64_t>(*at >> 33) == y) ++at;
      if (winding_) {
        const std::size_t runs_before = slice.runs.size();
        fill_row({begin, at}, offsets[static_cast<std::size_t>(y)], slice);
        if (!winding_->closed()) count_samples({begin, at}, cap_crossings, y, z, runs_before, slice);
      } else if (at != begin) {
        fill_row({begin, at}, slice);
      }
      slice.row_end.push_back(static_cast<std::uint32_t>(slice.runs.size()));
    }
    return slice;
  }

 private:
  void cross(std::uint32_t triangle, std::int64_t Z, std::vector<std::uint64_t>& crossings) const {
    const auto& corners = mesh_.triangles[triangle];
    const std::array<const FixedPoint*, 3> p{&mesh_.points[corners[0]], &mesh_.points[corners[1]],
                                             &mesh_.points[corners[2]]};
    std::array<std::int64_t, 2> y{};
    std::size_t spanning = 0;  // 2 for every face that spans the slice
    for (std::size_t i = 0; i < 3; ++i) {
      const FixedPoint *a = p[i], *b = p[(i + 1) % 3];
      if (((*a)[2] <= Z) != ((*b)[2] <= Z)) y[spanning++] = first_scanline(a, b, Z);
    }
    const auto [first, last] = std::minmax(y[0], y[1]);
    if (first == last) return;
    const FacePlane plane(*p[0], *p[1], *p[2], Z);
    for (std::int64_t j = first; j < last; ++j)
      crossings.push_back(pack(j, plane.first_voxel(centre(j)), plane.leaving()));
  }

  CapCrossings summed(std::vector<std::uint64_t>& crossings) const {
    std::sort(crossings.begin(), crossings.end());
    CapCrossings result;
    auto at = crossings.begin();
    for (std::int64_t y = 0; y < mesh_.cells[1]; ++y) {
      result.row_begin.push_back(static_cast<std::uint32_t>(result.steps.size()));
      for (std::int32_t sum = 0; at != crossings.end() && static_cast<std::int64_t>(*at >> 33) == y; ++at) {
        sum += *at & 1 ? -1 : 1;
        result.steps.push_back({static_cast<std::int32_t>(voxel(*at)), sum});
      }
    }
    result.row_begin.push_back(static_cast<std::uint32_t>(result.steps.size()));
    return result;
  }

  static std::int64_t voxel(std::uint64_t crossing) { return static_cast<std::int64_t>(crossing >> 1 & 0xffffffffu); }

  void fill_row(std::span<const std::uint64_t> crossings, Slice& slice) const {
    std::int64_t winding = 0;
    for (std::size_t i = 0; i < crossings.size(); ++i) {
      winding += crossings[i] & 1 ? -1 : 1;
      if (i + 1 < crossings.size()) fill(voxel(crossings[i]), voxel(crossings[i + 1]), winding, slice);
    }
  }

  /// The same where the boundary of the surface contributes to the winding number, even without any crossing.
  void fill_row(std::span<const std::uint64_t> crossings, std::span<const OffsetStep> offsets, Slice& slice) const {
    const std::size_t runs_before = slice.runs.size();
    std::int64_t winding = 0, at = 0;
    bool defective = false;
    std::size_t c = 0, s = 0;
    while (at < mesh_.cells[0]) {
      for (; c < crossings.size() && voxel(crossings[c]) <= at; ++c) winding += crossings[c] & 1 ? -1 : 1;
      while (s + 1 < offsets.size() && offsets[s + 1].begin <= at) ++s;
      std::int64_t next = mesh_.cells[0];
      if (c < crossings.size()) next = std::min(next, voxel(crossings[c]));
      if (s + 1 < offsets.size()) next = std::min<std::int64_t>(next, offsets[s + 1].begin);
      defective = defective || offsets[s].offset != 0;
      fill(at, next, winding - offsets[s].offset, slice);
      at = next;
    }
    for (; c < crossings.size(); ++c) winding += crossings[c] & 1 ? -1 : 1;
    if (!defective && winding == 0) return;
    ++slice.defective;
    for (std::size_t i = runs_before; i < slice.runs.size(); ++i)
      slice.winding_voxels += slice.runs[i].end - slice.runs[i].begin;
  }

  /// Counts the sampled foreground voxels of a row, every stride-th of the box, and those with a doubtful winding
  /// number.
  void count_samples(std::span<const std::uint64_t> crossings, const CapCrossings& of_caps, std::int64_t y,
                     std::int64_t z, std::size_t first_run, Slice& slice) const {
    const std::int64_t row = (z * mesh_.cells[1] + y) * mesh_.cells[0];
    std::size_t c = 0;
    std::int64_t winding = 0;
    for (std::size_t i = first_run; i < slice.runs.size(); ++i) {
      const std::int64_t begin = slice.runs[i].begin - margin_, end = slice.runs[i].end - margin_;
      for (std::int64_t x = (row + begin + stride_ - 1) / stride_ * stride_ - row; x < end; x += stride_) {
        for (; c < crossings.size() && voxel(crossings[c]) <= x; ++c) winding += crossings[c] & 1 ? -1 : 1;
        const double w = std::abs(static_cast<double>(winding + of_caps.until(x, y)) - winding_->caps_angle(x, y, z));
        const double certain = inside_ == Inside::odd ? 1 - std::abs(std::remainder(w - 1, 2)) : w;
        ++slice.sampled;
        slice.doubtful += certain < 0.75;
      }
    }
  }

  void fill(std::int64_t begin, std::int64_t end, std::int64_t winding, Slice& slice) const {
    if (begin == end || (inside_ == Inside::odd ? winding % 2 == 0 : winding == 0)) return;
    slice.runs.push_back({static_cast<std::int32_t>(begin + margin_), static_cast<std::int32_t>(end + margin_)});
    if (winding > 1 || winding < -1) slice.overlapping = true;
  }

  const FixedMesh& mesh_;
  std::size_t faces_;
  std::int64_t margin_;
  Inside inside_;
  const WindingNumber* winding_;
  std::int64_t stride_;  ///< of samples
};

}  // namespace

int crossings_until(const FixedPoint& a, const FixedPoint& b, const FixedPoint& c,
                    const std::array<std::int64_t, 3>& voxel) {
  const std::int64_t Z = centre(voxel[2]);
  const std::array<const FixedPoint*, 3> p{&a, &b, &c};
  std::array<std::int64_t, 2> y{};
  std::size_t spanning = 0;
  for (std::size_t i = 0; i < 3; ++i)
    if (((*p[i])[2] <= Z) != ((*p[(i + 1) % 3])[2] <= Z)) y[spanning++] = first_scanline(p[i], p[(i + 1) % 3], Z);
  const auto [first, last] = std::minmax(y[0], y[1]);
  if (voxel[1] < first || voxel[1] >= last) return 0;
  const FacePlane plane(a, b, c, Z);
  if (voxel[0] < plane.first_voxel(centre(voxel[1]))) return 0;
  return plane.leaving() ? -1 : 1;
}

CapCrossings crossings_of_slice(const FixedMesh& mesh, std::int64_t z) {
  return Converter(mesh, mesh.triangles.size(), 0, Inside::nonzero, nullptr).crossings(z);
}

namespace {

/// Assembles the slices of a box into a shape, with `margin` empty voxels around them.
class Collector {
 public:
  Collector(const Grid& grid, const std::array<std::int64_t, 3>& cells, std::int64_t margin) : margin_(margin) {
    result_.shape = VoxelShape(grid);
    result_.scanlines = cells[1] * cells[2];
    append_empty(margin_ * grid.dims[1]);
  }
  void append(const Slice& slice) {
    result_.defective_scanlines += slice.defective;
    result_.winding_voxels += slice.winding_voxels;
    result_.sampled += slice.sampled;
    result_.doubtful += slice.doubtful;
    result_.overlapping = result_.overlapping || slice.overlapping;
    append_empty(margin_);
    std::uint32_t from = 0;
    for (const std::uint32_t to : slice.row_end) {
      result_.shape.append_row(std::span(slice.runs).subspan(from, to - from));
      from = to;
    }
    append_empty(margin_);
  }
  Digitization finish() {
    append_empty(margin_ * result_.shape.grid().dims[1]);
    return std::move(result_);
  }

 private:
  void append_empty(std::int64_t rows) {
    for (; rows > 0; --rows) result_.shape.append_row({});
  }
  std::int64_t margin_;
  Digitization result_;
};

}  // namespace

// A sweep along z in batches of slices. Memory: 4 bytes per triangle that reaches into the batch and slice it spans, 8
// per crossing of the batch, and the result; never all crossings at once.
Digitization scan_convert(const FixedMesh& given, const Grid& grid, std::int64_t margin, Inside inside,
                          const WindingNumber* winding, const Progress& progress) {
  constexpr std::int64_t kBatch = 32;
  FixedMesh closed;
  std::vector<std::array<std::uint32_t, 3>> with_caps;
  const bool capped = winding && !winding->closed();
  if (capped) {
    with_caps.assign(given.triangles.begin(), given.triangles.end());
    with_caps.insert(with_caps.end(), winding->caps().begin(), winding->caps().end());
    closed = {given.points, with_caps, given.cells};
  }
  const FixedMesh& mesh = capped ? closed : given;
  const Converter converter(mesh, given.triangles.size(), margin, inside, winding);
  const std::int64_t slices = mesh.cells[2];
  const auto batches = static_cast<std::size_t>((slices + kBatch - 1) / kBatch);
  const auto entering = base::Csr<std::uint32_t>::group(batches, [&](const auto& emit) {
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      const auto [first, last] = converter.slices_of(t);
      if (first < last) emit(static_cast<std::size_t>(first / kBatch), t);
    }
  });

  Collector collector(grid, mesh.cells, margin);
  std::vector<std::uint32_t> active;
  std::vector<std::vector<std::uint32_t>> crossing(kBatch);  // triangles of each slice of the batch
  std::vector<Slice> converted(kBatch);
  for (std::size_t batch = 0; batch < batches; ++batch) {
    progress(static_cast<double>(batch) / static_cast<double>(batches));
    const std::int64_t begin = static_cast<std::int64_t>(batch) * kBatch, end = std::min(begin + kBatch, slices);
    active.insert(active.end(), entering[batch].begin(), entering[batch].end());
    for (auto& triangles : crossing) triangles.clear();
    std::erase_if(active, [&](std::uint32_t t) {
      const auto [first, last] = converter.slices_of(t);
      for (std::int64_t z = std::max(first, begin); z < std::min(last, end); ++z)
        crossing[static_cast<std::size_t>(z - begin)].push_back(t);
      return last <= end;
    });
    tbb::parallel_for(std::int64_t{0}, end - begin, [&](std::int64_t i) {
      const auto s = static_cast<std::size_t>(i);
      converted[s] = converter.convert(begin + i, crossing[s]);
    });
    for (std::int64_t i = 0; i < end - begin; ++i) collector.append(converted[static_cast<std::size_t>(i)]);
  }
  progress(1);
  return collector.finish();
}

}  // namespace quench::voxelization
