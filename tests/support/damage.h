// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "quench/geometry.h"

/// Ways to spoil a closed mesh, for tests and for the table of notes/defective_meshes.md.
namespace quench::testing_damage {

struct Damage {
  std::string_view name;
  TriangleMesh (*apply)(const TriangleMesh& clean, std::uint64_t seed);
  /// Largest symmetric difference of the voxels / voxels of the clean shape, of a mesh of at least 2000 faces at
  /// resolution 48 or more; or what `otherwise` allows, when that is more.
  double limit;
  bool exact;  ///< no point moves and nothing stays open: the voxels must be the same
  enum class Otherwise {
    nothing,
    missing,  ///< what the missing part of the surface encloses (share_behind_missing_faces())
    moved     ///< a tenth of the boundary vertices
  } otherwise = Otherwise::nothing;
};

const std::vector<Damage>& damages();

/// With a box 3 % larger than that of `clean`, by faces without area: meshes of one box have the same voxel lattice.
TriangleMesh pinned(TriangleMesh mesh, const TriangleMesh& clean);

}  // namespace quench::testing_damage
