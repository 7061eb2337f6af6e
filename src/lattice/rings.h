// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lattice/polytopes.h"

namespace quench::lattice {

/// Faces of the core in the order they are found.
struct RawFaces {
  std::vector<std::array<std::uint32_t, 2>> sites;  ///< ascending
  std::vector<std::uint32_t> offsets{0}, corners;   ///< polytopes around, counter-clockwise from the smallest
};

/// Walks around the edges of the tetrahedra: those between three polytopes or more, whose rings do not leave the
/// tetrahedra, are faces. `wanted`, per site: faces whose smaller site it is are wanted; empty: all.
std::vector<RawFaces> collect_faces(const Polytopes& polytopes, std::span<const std::uint8_t> wanted, Context* context);

}  // namespace quench::lattice
