// SPDX-License-Identifier: Apache-2.0
#include "rasters.h"

#include "quench/axis.h"
#include "run.h"

namespace quench::python {
namespace {

MaskView mask_of(const py::buffer_info& held) {
  return {grid_of(held, {1, 1, 1}).dims, steps_of(held), static_cast<std::uint8_t*>(held.ptr)};
}

}  // namespace

void mark_balls_in(const py::buffer& mask, std::span<const Vec3> centres, std::span<const double> radius,
                   const Grid& grid, const py::object& listener, int threads) {
  const py::buffer_info held = mask.request(true);
  run_cancellable(listener, threads,
                  [&](Context& context) { mark_balls(centres, radius, grid, mask_of(held), &context); });
}

void mark_cells_in(const py::buffer& mask, const CellComplex& complex, std::span<const Vec3> points, const Grid& grid,
                   const py::object& listener, int threads) {
  const py::buffer_info held = mask.request(true);
  run_cancellable(listener, threads,
                  [&](Context& context) { mark_cells(complex, points, grid, mask_of(held), &context); });
}

Array rows_and_columns(std::span<const Vec3> points, const Grid& grid) {
  std::vector<std::array<double, 2>> rows;
  rows.reserve(points.size());
  for (const Vec3& p : points) {
    const Vec3 lattice = grid.lattice(p) - grid.first_centre();
    rows.push_back({lattice[1], lattice[0]});
  }
  auto kept = std::make_shared<const std::vector<std::array<double, 2>>>(std::move(rows));
  return view(kept, std::span<const std::array<double, 2>>(*kept));
}

}  // namespace quench::python
