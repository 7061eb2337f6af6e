// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string_view>

#include "quench/context.h"
#include "quench/geometry.h"

namespace quench {

/// What the geometry of a medial axis refers to.
enum class SurfaceKind {
  voxels,  ///< the voxel shape itself: nothing is fitted
  mesh,    ///< the mesh that was voxelized
  grey,    ///< the isosurface of the trilinear interpolation of grey values, in triangles
  smooth   ///< a smoothed surface of a mask or label
};

/// "voxels", "mesh", "grey", "smooth".
std::string_view name_of(SurfaceKind kind);
/// Nothing when there is no such kind.
std::optional<SurfaceKind> surface_kind_of(std::string_view name);

/// The boundary of a solid: a closed triangle mesh, faces outward, that can be asked for nearest points. Copies share
/// the mesh.
class Surface {
 public:
  /// The nearest point of the surface to another point.
  struct Foot {
    Vec3 point = Vec3::Zero();
    double distance = std::numeric_limits<double>::infinity();
    std::uint32_t triangle = kNone;  ///< it lies in; none: nothing is near enough
    bool inside = false;             ///< whether the other point lies inside the solid
  };

  /// Triangles without area are left out, and points without triangles; corners at one place are one. O(n log n), on all threads; 160 bytes per
  /// triangle. Throws Error(input) for a mesh without triangles.
  Surface(TriangleMesh mesh, SurfaceKind kind, Context* context = nullptr);

  SurfaceKind kind() const;
  const TriangleMesh& mesh() const;

  /// The nearest point of the surface that is not farther than `within`, in double precision. `inside` follows from
  /// the angle-weighted normals around it (Baerentzen and Aanaes 2005). O(log n) in practice.
  Foot nearest(const Vec3& p, double within = std::numeric_limits<double>::infinity()) const;

 private:
  struct Parts;
  std::shared_ptr<const Parts> parts_;
};

}  // namespace quench
