// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <iterator>
#include <vector>

#include "base/parallel.h"
#include "quench/shape.h"
#include "shape/boundary_count.h"

namespace quench {

namespace {

// Two scanlines of four that are neighbours in y or in z.
bool is_half(unsigned mask) { return mask == 3 || mask == 12 || mask == 5 || mask == 10; }

// A lattice point (x, y, z) touches the voxels x-1 and x of the scanlines (y-1, z-1), (y, z-1), (y-1, z), (y, z).
// Between two ends of runs the four scanlines have one 4-bit mask of foreground; the point is a site exactly when the
// masks left and right of it are not both empty or both full. Visits intervals [begin, end) of sites along x, in rows
// [first, last), each with whether its sites are flat: the voxels inside are those on one side of a plane.
// In a plane both layers of voxels around a point are the one that there is: then the four scanlines are two, twice.
template <class Visit>
void each_interval(const VoxelShape& shape, std::size_t first, std::size_t last, Visit&& visit) {
  const bool plane = shape.grid().is_plane();
  const auto rows_of_layer = static_cast<std::size_t>(shape.grid().dims[1] + 1);
  std::vector<std::int64_t> events;  // x * 4 + scanline: each event toggles one bit of the mask
  for (std::size_t row = first; row < last; ++row) {
    const auto y = static_cast<std::int64_t>(row % rows_of_layer), z = static_cast<std::int64_t>(row / rows_of_layer);
    events.clear();
    for (int s = 0; s < 4; ++s)
      for (const Run& run : shape.row(y - 1 + (s & 1), plane ? 0 : z - 1 + (s >> 1))) {
        events.push_back(std::int64_t{run.begin} * 4 + s);
        events.push_back(std::int64_t{run.end} * 4 + s);
      }
    std::sort(events.begin(), events.end());
    unsigned mask = 0;
    std::int64_t next = 0;  // first point not yet decided
    for (std::size_t e = 0; e < events.size();) {
      const std::int64_t x = events[e] >> 2;
      if (mask != 0 && mask != 15 && next < x) visit(next, x, y, z, is_half(mask));
      const unsigned before = mask;
      for (; e < events.size() && events[e] >> 2 == x; ++e) mask ^= 1u << (events[e] & 3);
      visit(x, x + 1, y, z, (before == 0 && mask == 15) || (before == 15 && mask == 0));
      next = x + 1;
    }
  }
}

std::size_t chunks_of(const VoxelShape& shape) {
  constexpr std::size_t kRows = 1 << 12;  // of a chunk
  return base::chunks_for(shape::boundary_rows(shape), kRows);
}

// Calls body(chunk, first row, last row + 1) for all rows of lattice points.
template <class Body>
void each_chunk(const VoxelShape& shape, const Body& body) {
  const std::size_t chunks = chunks_of(shape);
  tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
    const auto [first, last] = base::part_of(shape::boundary_rows(shape), chunk, chunks);
    body(chunk, first, last);
  });
}

// Those of the rows [first, last), written to `to`.
template <class To>
void write_sites(const VoxelShape& shape, std::size_t first, std::size_t last, To to) {
  each_interval(shape, first, last, [&](std::int64_t begin, std::int64_t end, std::int64_t y, std::int64_t z, bool) {
    for (std::int64_t x = begin; x < end; ++x)
      *to++ = {static_cast<std::int32_t>(x), static_cast<std::int32_t>(y), static_cast<std::int32_t>(z)};
  });
}

std::vector<shape::BoundaryCount> counts_of_chunks(const VoxelShape& shape) {
  std::vector<shape::BoundaryCount> count(chunks_of(shape));
  each_chunk(shape, [&](std::size_t chunk, std::size_t first, std::size_t last) {
    shape::BoundaryCount own;
    each_interval(shape, first, last, [&](std::int64_t begin, std::int64_t end, std::int64_t, std::int64_t, bool flat) {
      own.sites += end - begin;
      if (flat) own.flat += end - begin;
    });
    count[chunk] = own;
  });
  return count;
}

}  // namespace

std::vector<LatticePoint> boundary_vertices(const VoxelShape& shape) {
  std::vector<std::size_t> place{0};  // of the first site of a chunk, and their number
  for (const shape::BoundaryCount& count : counts_of_chunks(shape))
    place.push_back(place.back() + static_cast<std::size_t>(count.sites));
  std::vector<LatticePoint> sites(place.back());
  each_chunk(shape, [&](std::size_t chunk, std::size_t first, std::size_t last) {
    write_sites(shape, first, last, sites.begin() + static_cast<std::ptrdiff_t>(place[chunk]));
  });
  return sites;
}

std::size_t shape::boundary_rows(const VoxelShape& shape) {
  const auto& dims = shape.grid().dims;
  return static_cast<std::size_t>(shape.grid().is_plane() ? 1 : dims[2] + 1) * static_cast<std::size_t>(dims[1] + 1);
}

std::vector<LatticePoint> shape::boundary_vertices(const VoxelShape& shape, std::size_t first, std::size_t last) {
  std::vector<LatticePoint> sites;
  write_sites(shape, first, last, std::back_inserter(sites));
  return sites;
}

shape::BoundaryCount shape::count_boundary(const VoxelShape& shape) {
  shape::BoundaryCount all;
  for (const shape::BoundaryCount& count : counts_of_chunks(shape)) {
    all.sites += count.sites;
    all.flat += count.flat;
  }
  return all;
}

std::int64_t count_boundary_vertices(const VoxelShape& shape) { return shape::count_boundary(shape).sites; }

}  // namespace quench
