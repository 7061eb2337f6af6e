// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <hdf5.h>

#include <array>
#include <string>
#include <utility>

#include "quench/geometry.h"

namespace quench::io {

/// An identifier of the library, closed at the end of its scope.
class Hdf5Handle {
 public:
  Hdf5Handle() = default;
  Hdf5Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  Hdf5Handle(Hdf5Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Hdf5Handle& operator=(Hdf5Handle&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
    return *this;
  }
  ~Hdf5Handle() {
    if (id_ >= 0) close_(id_);
  }
  hid_t id() const { return id_; }
  bool valid() const { return id_ >= 0; }

 private:
  hid_t id_ = -1;
  herr_t (*close_)(hid_t) = nullptr;
};

/// What the attributes of a dataset say of its steps and place; spacing 1 where they say nothing.
struct Hdf5Spacing {
  Vec3 spacing{1, 1, 1}, origin{0, 0, 0};
  std::string units, source, note;
};

/// From the attributes of a dataset of `rank` axes, whose `axis` are x, y, z (-1: none), in this order: element_size_um
/// (ilastik, plugins of Fiji), the resolutions in axistags (vigra, ilastik), voxel_size and resolution (CREMI, funlib,
/// with offset and units), spacing. Their numbers are one per axis in the order of the axes, or three where z, y and x
/// remain. A note where such an attribute cannot be used.
Hdf5Spacing hdf5_spacing(hid_t dataset, std::size_t rank, const std::array<int, 3>& axis);

}  // namespace quench::io
