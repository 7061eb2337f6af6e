// SPDX-License-Identifier: Apache-2.0
#include "rasters.h"

#include "quench/axis.h"
#include "run.h"

namespace quench::python {
namespace {

MaskView mask_of(const py::buffer_info& held) {
  return {{held.shape[0], held.shape[1], held.shape[2]},
          {held.strides[0], held.strides[1], held.strides[2]},
          static_cast<std::uint8_t*>(held.ptr)};
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

}  // namespace quench::python
