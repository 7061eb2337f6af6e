// SPDX-License-Identifier: Apache-2.0
#include "arrays.h"

#include <fmt/format.h>

#include <cmath>
#include <cstring>

#include "quench/error.h"

namespace quench::python {
namespace {

// Which of the ten sample types a buffer has; the package has made byte order and rarer types right before.
SampleType sample_type(const py::buffer_info& held) {
  const char code = held.format.empty() ? 'B' : held.format.back();
  const bool floating = code == 'f' || code == 'd';
  const bool sign = code == 'b' || code == 'h' || code == 'i' || code == 'l' || code == 'q';
  const bool no_sign = code == '?' || code == 'B' || code == 'H' || code == 'I' || code == 'L' || code == 'Q';
  if (floating) return held.itemsize == 4 ? SampleType::float32 : SampleType::float64;
  if (sign || no_sign) switch (held.itemsize) {
      case 1:
        return sign ? SampleType::int8 : SampleType::uint8;
      case 2:
        return sign ? SampleType::int16 : SampleType::uint16;
      case 4:
        return sign ? SampleType::int32 : SampleType::uint32;
      case 8:
        return sign ? SampleType::int64 : SampleType::uint64;
      default:
        break;
    }
  throw Error(ErrorCode::input, fmt::format("samples of the buffer format '{}' are not numbers of an image; give bool, "
                                            "integer or float samples",
                                            held.format));
}

}  // namespace

py::buffer_info Array::info() const {
  std::vector<py::ssize_t> strides(shape.size());
  py::ssize_t step = item;
  for (std::size_t a = shape.size(); a-- > 0; step *= shape[a]) strides[a] = step;
  // Nothing is written through it: the buffer is marked read-only.
  return {const_cast<void*>(data), item, format, static_cast<py::ssize_t>(shape.size()), shape, strides, true};
}

Grid grid_of(const py::buffer_info& held, const std::array<double, 3>& spacing) {
  Grid grid;
  grid.spacing = {spacing[0], spacing[1], spacing[2]};
  if (held.ndim == 2) {
    grid.dims = {held.shape[1], held.shape[0], 1};
    grid.make_plane();
  } else {
    grid.dims = {held.shape[0], held.shape[1], held.shape[2]};
  }
  return grid;
}

Grid placed(const py::buffer_info& held, const Place& place) {
  Grid grid = place.grid;
  grid.dims = grid_of(held, {1, 1, 1}).dims;
  if (grid.is_plane() != (held.ndim == 2)) throw Error(ErrorCode::usage, "the image has not the axes of its place");
  return grid;
}

Coordinates coordinates_of(const Grid& grid) {
  Coordinates coordinates;
  coordinates.y_down = grid.is_plane();
  return coordinates;
}

std::vector<py::ssize_t> sides_of(const Grid& grid) {
  if (grid.is_plane()) return {grid.dims[1], grid.dims[0]};
  return {grid.dims[0], grid.dims[1], grid.dims[2]};
}

std::array<std::int64_t, 3> steps_of(const py::buffer_info& held) {
  // There is one slice of a plane, so that the step to the next is never made; rows before slices keep rows together.
  if (held.ndim == 2) return {held.strides[1], held.strides[0], held.strides[0]};
  return {held.strides[0], held.strides[1], held.strides[2]};
}

ImageView image_of(const py::buffer_info& held, const Grid& grid) {
  ImageView image;
  image.grid = grid;
  image.type = sample_type(held);
  image.data = held.ptr;
  image.strides = steps_of(held);
  return image;
}

std::vector<Vec3> points_of(const py::buffer& points) {
  const py::buffer_info held = points.request();
  std::vector<Vec3> result(static_cast<std::size_t>(held.shape[0]));
  const char* at = static_cast<const char*>(held.ptr);
  for (std::size_t p = 0; p < result.size(); ++p, at += held.strides[0])
    for (Eigen::Index a = 0; a < 3; ++a) std::memcpy(&result[p][a], at + a * held.strides[1], sizeof(double));
  return result;
}

std::vector<std::array<std::uint32_t, 3>> triangles_of(const py::buffer& triangles, std::size_t count) {
  const py::buffer_info held = triangles.request();
  std::vector<std::array<std::uint32_t, 3>> result(static_cast<std::size_t>(held.shape[0]));
  const char* at = static_cast<const char*>(held.ptr);
  for (std::size_t t = 0; t < result.size(); ++t, at += held.strides[0])
    for (std::size_t a = 0; a < 3; ++a) {
      std::int64_t corner = 0;
      std::memcpy(&corner, at + static_cast<py::ssize_t>(a) * held.strides[1], sizeof(corner));
      if (corner < 0 || corner >= static_cast<std::int64_t>(count))
        throw Error(ErrorCode::input,
                    fmt::format("face {} names vertex {}, and there are {} vertices", t, corner, count));
      result[t][a] = static_cast<std::uint32_t>(corner);
    }
  return result;
}

void bind_arrays(py::module_& m) {
  py::class_<Array>(m, "Array", py::buffer_protocol()).def_buffer([](const Array& a) { return a.info(); });
}

}  // namespace quench::python
