// SPDX-License-Identifier: Apache-2.0
// Arrays in and out by the buffer protocol only: the same module works with numpy 1 and 2.
#pragma once

#include <pybind11/pybind11.h>

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "quench/geometry.h"
#include "quench/shape.h"

namespace quench::python {

namespace py = pybind11;

/// Numbers that live as long as `owner`, C order, read-only: numpy.asarray() of one copies nothing.
struct Array {
  std::shared_ptr<const void> owner;
  const void* data = nullptr;
  std::string format;
  py::ssize_t item = 0;
  std::vector<py::ssize_t> shape;

  py::buffer_info info() const;
};

template <class T>
std::string format_of() {
  // Indices are shown with a sign: differences of unsigned ones wrap around.
  using Shown = std::conditional_t<std::is_same_v<T, std::uint32_t>, std::int32_t, T>;
  return py::format_descriptor<Shown>::format();
}

/// One number per row.
template <class T>
Array view(std::shared_ptr<const void> owner, std::span<const T> values) {
  return {std::move(owner), values.data(), format_of<T>(), sizeof(T), {static_cast<py::ssize_t>(values.size())}};
}
template <class T, std::size_t N>
Array view(std::shared_ptr<const void> owner, std::span<const std::array<T, N>> rows) {
  return {std::move(owner),
          rows.data(),
          format_of<T>(),
          sizeof(T),
          {static_cast<py::ssize_t>(rows.size()), static_cast<py::ssize_t>(N)}};
}
inline Array view(std::shared_ptr<const void> owner, std::span<const Vec3> rows) {
  return {
      std::move(owner), rows.data(), format_of<double>(), sizeof(double), {static_cast<py::ssize_t>(rows.size()), 3}};
}
template <class T>
Array view(std::shared_ptr<const void> owner, const std::vector<T>& values) {
  return view(std::move(owner), std::span<const T>(values));
}
/// An array of its own.
template <class T>
Array own(std::vector<T> values) {
  auto kept = std::make_shared<const std::vector<T>>(std::move(values));
  return view(kept, *kept);
}

// Arrays of three axes are volumes: x is the first. Arrays of two are images of the plane, rows from the top: y is the
// first axis and grows downwards, x the second, as everybody who shows images has it.

/// Where an image lies in the world.
struct Place {
  Grid grid;  ///< its dims are of no meaning
  Coordinates coordinates;
};
/// The grid of an array that lies there. Throws Error(usage) when it has not as many axes.
Grid placed(const py::buffer_info& held, const Place& place);

/// An image somebody else owns: the place of a voxel or pixel is its index times spacing. `held` keeps the buffer.
ImageView image_of(const py::buffer_info& held, const Grid& grid);
/// The grid of an array without a place in the world: the centre of the first voxel or pixel is at 0. `spacing` is that
/// of x, y, z.
Grid grid_of(const py::buffer_info& held, const std::array<double, 3>& spacing);
/// What the grid of such an array says of its coordinates.
Coordinates coordinates_of(const Grid& grid);
/// The sides of an array for samples of that grid: x, y, z, or rows, columns.
std::vector<py::ssize_t> sides_of(const Grid& grid);
/// The steps in bytes from a voxel or pixel to the next along x, y, z in an array of two or three axes.
std::array<std::int64_t, 3> steps_of(const py::buffer_info& held);

/// Rows of three doubles; rows of three indices below `count`.
std::vector<Vec3> points_of(const py::buffer& points);
std::vector<std::array<std::uint32_t, 3>> triangles_of(const py::buffer& triangles, std::size_t count);

void bind_arrays(py::module_& m);

}  // namespace quench::python
