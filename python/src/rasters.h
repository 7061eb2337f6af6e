// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "arrays.h"
#include "quench/complex.h"

namespace quench::python {

/// Into a writable array of bytes of two or three axes.
void mark_balls_in(const py::buffer& mask, std::span<const Vec3> centres, std::span<const double> radius,
                   const Grid& grid, const py::object& listener, int threads);
void mark_cells_in(const py::buffer& mask, const CellComplex& complex, std::span<const Vec3> points, const Grid& grid,
                   const py::object& listener, int threads);

/// Row and column of points of a plane in an image on that grid: whole numbers at the centres of pixels.
Array rows_and_columns(std::span<const Vec3> points, const Grid& grid);

}  // namespace quench::python
