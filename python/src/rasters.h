// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "arrays.h"
#include "quench/complex.h"

namespace quench::python {

/// Into a writable three-dimensional array of bytes.
void mark_balls_in(const py::buffer& mask, std::span<const Vec3> centres, std::span<const double> radius,
                   const Grid& grid, const py::object& listener, int threads);
void mark_cells_in(const py::buffer& mask, const CellComplex& complex, std::span<const Vec3> points, const Grid& grid,
                   const py::object& listener, int threads);

}  // namespace quench::python
