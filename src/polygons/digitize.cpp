// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "base/memory.h"
#include "base/text.h"
#include "polygons/pixel_lattice.h"
#include "polygons/ring_nesting.h"
#include "quench/polygons.h"

namespace quench {
namespace {

using polygons::PixelLattice;

struct Box {
  Vec2 low = Vec2::Constant(std::numeric_limits<double>::infinity()), high = -low;
};

/// Less than three points that differ enclose nothing.
bool has_three_points(const std::vector<Vec2>& ring) {
  const auto second = std::find_if(ring.begin(), ring.end(), [&](const Vec2& p) { return p != ring.front(); });
  return std::any_of(second, ring.end(), [&](const Vec2& p) { return p != ring.front() && p != *second; });
}

Box checked_box(const Polygons& polygons) {
  Box box;
  for (const auto& ring : polygons.rings) {
    for (const Vec2& p : ring) {
      if (!p.allFinite())
        throw Error(ErrorCode::input,
                    fmt::format("the polygon has a coordinate that is not finite, ({}, {})", p[0], p[1]));
      box.low = box.low.cwiseMin(p);
      box.high = box.high.cwiseMax(p);
    }
    if (!has_three_points(ring))
      throw Error(ErrorCode::input,
                  fmt::format("a ring of the polygon has {} of which less than three differ; it encloses nothing",
                              base::counted(ring.size(), "point")));
  }
  if (polygons.rings.empty()) throw Error(ErrorCode::input, "the polygon is empty");
  return box;
}

void check_options(const DigitizeOptions& options) {
  if (options.resolution && options.pixel)
    throw Error(ErrorCode::usage, "resolution and pixel both say how large pixels are; give one of them", "pixel");
  if (options.resolution && (*options.resolution < 1 || *options.resolution > kMostPixels))
    throw Error(ErrorCode::usage, fmt::format("resolution {} is not from 1 to {}", *options.resolution, kMostPixels),
                "resolution");
  if (options.pixel && !(*options.pixel > 0 && std::isfinite(*options.pixel)))
    throw Error(ErrorCode::usage, fmt::format("pixel {} is not a positive length", *options.pixel), "pixel");
}

/// As many pixels as cover the box. A quotient that rounding lifts above a whole number does not count as more: the
/// centre of the next pixel would be half a pixel beyond the box.
Grid grid_of(const Box& box, const DigitizeOptions& options) {
  const Vec2 sides = box.high - box.low;
  const double longest = sides.maxCoeff();
  const double pixel =
      options.pixel.value_or(longest / static_cast<double>(options.resolution.value_or(kDefaultResolution)));
  constexpr double smallest = 1e-30, largest = 1e30, farthest = 1e12;
  if (!(pixel >= smallest && pixel <= largest))
    throw Error(ErrorCode::input,
                fmt::format("pixels of {:g} are beyond what can be computed with, {:g} to {:g}; scale the polygon",
                            pixel, smallest, largest));
  if (const double distance = std::max(box.low.cwiseAbs().maxCoeff(), box.high.cwiseAbs().maxCoeff());
      !(distance <= farthest * pixel))
    throw Error(ErrorCode::input,
                fmt::format("the polygon lies {:g} from the origin of its coordinates, more than 10^12 pixels of {:g}, "
                            "which is too far for exact results; move it nearer or give larger pixels",
                            distance, pixel),
                options.pixel ? "pixel" : "resolution");
  Grid grid;
  grid.dims[2] = 1;
  for (int a = 0; a < 2; ++a) {
    const double pixels = std::max(1.0, std::ceil(sides[a] / pixel * (1 - 0x1p-50)));
    if (pixels > static_cast<double>(kMostPixels))
      throw Error(ErrorCode::input,
                  fmt::format("pixels of {:g} are {:g} along a side of the polygon, more than {}; give larger ones",
                              pixel, pixels, kMostPixels),
                  "pixel");
    grid.dims[static_cast<std::size_t>(a)] = static_cast<std::int64_t>(pixels);
    grid.spacing[a] = pixel;
    grid.origin[a] = box.low[a] + pixel / 2;
  }
  grid.make_plane();
  return grid;
}

void check_memory(std::uint64_t crossings, const Context* context) {
  const std::uint64_t bytes = crossings * sizeof(std::int32_t);
  if (bytes < std::uint64_t{1} << 26) return;  // asking the system takes longer
  const bool limited = context && context->memory_limit > 0;
  const std::int64_t limit = limited ? context->memory_limit : base::available_memory();
  if (bytes <= static_cast<std::uint64_t>(limit)) return;
  throw Error(ErrorCode::failed,
              fmt::format("the rings cross rows of pixels {} times, which needs {} of memory, and {} {}; use a lower "
                          "resolution",
                          crossings, base::bytes_text(static_cast<std::int64_t>(bytes)), base::bytes_text(limit),
                          limited ? "are allowed" : "are free"),
              "resolution");
}

/// Crossings of the edges with the rows of centres, and the runs between them. An edge crosses the rows from the first
/// one not below its lower end to before the first one not below its upper end, so that chains of edges cross a row
/// once where they go through it.
class Scanlines {
 public:
  Scanlines(const Polygons& polygons, const Grid& grid, Context* context)
      : polygons_(polygons), grid_(grid), lattice_(grid), context_(context) {
    count();
    check_memory(begin_.back(), context);
    crossings_.resize(begin_.back());
    each_edge([&](const Vec2& a, const Vec2& b, std::int32_t first, std::int32_t last) {
      if (first > last)
        add(PixelLattice::Edge(lattice_, b, a), last, first, 0);
      else
        add(PixelLattice::Edge(lattice_, a, b), first, last, 1);
    });
    std::rotate(begin_.begin(), begin_.end() - 1, begin_.end());  // add() has moved every begin to its end
    begin_.front() = 0;
  }

  VoxelShape shape(PolygonFill fill) {
    VoxelShape result(grid_);
    std::vector<Run> runs;
    for (std::size_t row = 0; row + 1 < begin_.size(); ++row) {
      if (row % 4096 == 0)
        checkpoint(context_, "digitize", static_cast<double>(row) / static_cast<double>(begin_.size()));
      runs.clear();
      add_runs({crossings_.begin() + static_cast<std::ptrdiff_t>(begin_[row]),
                crossings_.begin() + static_cast<std::ptrdiff_t>(begin_[row + 1])},
               fill, runs);
      result.append_row(runs);
    }
    return result;
  }

 private:
  template <class Visit>
  void each_edge(const Visit& visit) {
    std::size_t vertex = 0, edges = 0;
    for (const auto& ring : polygons_.rings) {
      std::size_t before = vertex + ring.size() - 1;
      const Vec2* from = &ring.back();
      for (const Vec2& to : ring) {
        if (++edges % 65536 == 0) checkpoint(context_, "digitize", 0);
        if (rows_[before] != rows_[vertex]) visit(*from, to, rows_[before], rows_[vertex]);
        from = &to;
        before = vertex++;
      }
    }
  }

  /// Fills in begin_: the number of crossings before each row.
  void count() {
    std::size_t points = 0;
    for (const auto& ring : polygons_.rings) points += ring.size();
    rows_.reserve(points);
    for (const auto& ring : polygons_.rings)
      for (const Vec2& p : ring) rows_.push_back(lattice_.first_row(p[1]));
    const auto rows = static_cast<std::size_t>(grid_.dims[1]);
    std::vector<std::int64_t> change(rows + 1);
    each_edge([&](const Vec2&, const Vec2&, std::int32_t first, std::int32_t last) {
      ++change[static_cast<std::size_t>(std::min(first, last))];
      --change[static_cast<std::size_t>(std::max(first, last))];
    });
    begin_.reserve(rows + 1);
    begin_.push_back(0);
    std::int64_t edges = 0;
    for (std::size_t row = 0; row < rows; ++row) {
      edges += change[row];
      begin_.push_back(begin_.back() + static_cast<std::uint64_t>(edges));
    }
  }

  void add(const PixelLattice::Edge& edge, std::int32_t first, std::int32_t last, std::int32_t upwards) {
    for (std::int32_t row = first; row < last; ++row)
      crossings_[begin_[static_cast<std::size_t>(row)]++] = 2 * edge.column(row) + upwards;
  }

  static void add_runs(std::span<std::int32_t> crossings, PolygonFill fill, std::vector<Run>& runs) {
    std::sort(crossings.begin(), crossings.end());
    std::int32_t winding = 0, begin = 0;
    const auto inside = [&] { return fill == PolygonFill::evenodd ? winding % 2 != 0 : winding != 0; };
    for (const std::int32_t crossing : crossings) {
      const bool was = inside();
      winding += crossing % 2 != 0 ? 1 : -1;
      if (!was && inside()) begin = crossing / 2;
      if (was && !inside()) runs.push_back({begin, crossing / 2});  // empty ones are dropped
    }
  }

  const Polygons& polygons_;
  const Grid& grid_;
  PixelLattice lattice_;
  Context* context_;
  std::vector<std::int32_t> rows_;       // per point of all rings: the first row not below it
  std::vector<std::uint64_t> begin_;     // per row, into crossings_
  std::vector<std::int32_t> crossings_;  // 2 * column + 1 for edges upwards
};

VoxelShape pixels_of(const Polygons& polygons, const Grid& grid, PolygonFill fill, Context* context) {
  return Scanlines(polygons, grid, context).shape(fill);
}

double length_of(const Polygons& polygons) {
  double length = 0;
  for (const auto& ring : polygons.rings)
    for (std::size_t i = 0; i < ring.size(); ++i) length += (ring[i] - ring[i == 0 ? ring.size() - 1 : i - 1]).norm();
  return length;
}

/// Finer grids are tried, up to a 64th of the pixel, so that the advice is known to help.
[[noreturn]] void refuse_empty(const Polygons& polygons, const Box& box, double pixel, PolygonFill fill,
                               Context* context) {
  const double longest = (box.high - box.low).maxCoeff();
  const auto now = static_cast<std::int64_t>(std::ceil(longest / pixel * (1 - 0x1p-50)));
  for (std::int64_t finer = 2 * now; finer <= std::min(64 * now, kMostPixels); finer *= 2) {
    const Grid grid = grid_of(box, {.resolution = finer, .pixel = {}});
    const std::int64_t found = pixels_of(polygons, grid, fill, context).voxel_count();
    if (found == 0) continue;
    const double area = static_cast<double>(found) * grid.spacing[0] * grid.spacing[0];
    throw Error(
        ErrorCode::input,
        fmt::format("no centre of a pixel lies in the polygon: it is about {:.2g} thin, and a pixel is {:.3g} "
                    "long; at resolution {} (pixels of {:.3g}) it has {}",
                    2 * area / length_of(polygons), pixel, finer, grid.spacing[0], base::counted(found, "pixel")),
        "resolution");
  }
  throw Error(ErrorCode::input,
              fmt::format("no centre of a pixel lies in the polygon: it is far thinner than a pixel of {:.3g}, or "
                          "encloses nothing",
                          pixel),
              "resolution");
}

}  // namespace

VoxelShape digitize(const Polygons& polygons, const DigitizeOptions& options, Context* context) {
  check_options(options);
  const Box box = checked_box(polygons);
  const Grid grid = grid_of(box, options);
  VoxelShape shape = pixels_of(polygons, grid, options.fill, context);
  if (shape.empty()) refuse_empty(polygons, box, grid.spacing[0], options.fill, context);
  polygons::note_other_topology(polygons, shape, options.fill, context);
  checkpoint(context, "digitize", 1);
  return shape;
}

}  // namespace quench
