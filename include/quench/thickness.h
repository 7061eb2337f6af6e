// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "quench/axis.h"
#include "quench/context.h"
#include "quench/geometry.h"
#include "quench/shape.h"
#include "quench/surface.h"

/// @file
/// Local thickness (Hildebrand and Rüegsegger 1997): at a point of a shape the diameter of the largest ball that lies
/// in the shape and contains the point. The balls are those of a medial axis, of an unpruned voxel core all that are
/// maximal among the balls without boundary vertices inside (docs/algorithms/thickness.md).
namespace quench {

/// How values are distributed, each with a weight: voxels, or an area. Count, mean, deviation, extremes and histogram
/// are exact up to rounding, percentiles to 1/8192 of their value.
class ThicknessDistribution {
 public:
  /// A histogram of at least so many bins of `width`, from 0 on.
  explicit ThicknessDistribution(double width = 1, std::size_t bins = 0);

  /// A value of 0 or more; negative weights and values that are not finite are left out.
  void add(double value, double weight = 1);
  /// All of another one with bins of the same width.
  void add(const ThicknessDistribution& other);

  double weight() const { return weight_; }  ///< of all values
  double mean() const { return mean_; }      ///< 0 without values, as all that follow
  double deviation() const;                  ///< standard deviation of the values themselves (n, not n - 1)
  double least() const { return weight_ > 0 ? least_ : 0; }
  double largest() const { return weight_ > 0 ? largest_ : 0; }
  /// The least value v such that values of at most v have `share` (0 to 1) of the weight.
  double percentile(double share) const;

  double bin_width() const { return width_; }
  /// The weight of the values from i * bin_width() on, below (i + 1) * bin_width(). As long as needed.
  const std::vector<double>& bins() const { return bins_; }

 private:
  double width_ = 1, weight_ = 0, mean_ = 0, squares_ = 0, least_ = 0, largest_ = 0;
  std::vector<double> bins_;
  std::vector<double> fine_;  // by the leading bits of the value as a float
  std::size_t first_ = 0;     // the bucket of fine_[0]
};

struct ThicknessOptions {
  /// Also the balls between the two ends of each edge of the axis. With them the result is exact for all balls of the
  /// core; without, for those of its vertices.
  bool between = true;
  /// Added to every radius, world units: half a voxel where the radii are those of a voxel core, whose boundary
  /// vertices lie inside the surface they stand for (thickness_correction()). Which ball contains a voxel does not
  /// depend on it.
  double correction = 0;
  /// Voxels outside of it are 0 and not counted; balls are those of the whole shape. Its dims are those of the shape.
  const VoxelShape* mask = nullptr;
  double bin_width = 0;  ///< of the histogram; 0: automatic_bin_width()
};

/// Half the smallest spacing for voxels, 0 for pixels and axes that are fitted to a surface, as radii of graphs.
double thickness_correction(const MedialAxis& axis);

/// The least of 1, 2, 5, 10, 20, ... tenths of the smallest spacing that makes at most 200 bins up to `largest`.
double automatic_bin_width(const Grid& grid, double largest);

/// Takes the slices of a volume in ascending order of z: dims[0] * dims[1] values, x fastest, in world units; 0 outside
/// the shape and where no ball of the axis is.
using TakeThickness = std::function<void(std::int64_t z, std::span<const float> slice)>;

/// What local_thickness() found beside the values.
struct ThicknessReport {
  ThicknessDistribution distribution;  ///< of the voxels that have a value
  std::int64_t voxels = 0;             ///< of the shape, in the mask
  std::int64_t uncovered = 0;          ///< of these in no ball: 0 for an unpruned core
  std::uint64_t items = 0;             ///< balls and pairs of balls that were looked at
};

/// The local thickness at the centres of the voxels of a shape, slice by slice, from the balls of `axis`: of its
/// vertices and, `between`, of its edges, where the balls between two neighbours are those through the circle in which
/// the two meet (in a voxel core the balls of the points of the edge). A centre on a sphere, up to 1e-9 of the radius,
/// is in the ball.
///
/// `axis` needs points, radius and the edges of its complex; `shape.grid()` places both. In the plane balls are disks.
/// Works in bricks of voxels, on all threads, and gives the same for any number of them. Memory: 32 bytes per edge and
/// vertex, and 4 bytes per voxel of 32 slices. O(edges + voxels) in practice.
/// Throws Error(usage) for a mask of other dims and radii that are not finite.
ThicknessReport local_thickness(const VoxelShape& shape, const MedialAxis& axis, const ThicknessOptions& options,
                                const TakeThickness& take, Context* context = nullptr);

/// The same as one array, x fastest.
std::vector<float> thickness_volume(const VoxelShape& shape, const MedialAxis& axis,
                                    const ThicknessOptions& options = {}, Context* context = nullptr);

struct SurfaceThicknessOptions {
  double tolerance = 0;   ///< how far a ball may be from a point that it touches, world units
  double correction = 0;  ///< added to every radius
};

/// Thickness at points of the boundary.
struct SurfaceThickness {
  std::vector<double> thickness;    ///< per point, world units
  std::vector<Vec3> across;         ///< per point: where the same ball touches the boundary on the other side;
                                    ///< empty without a surface
  std::vector<std::uint32_t> ball;  ///< per point: the vertex of the axis whose ball it is; kNone: there is none
  std::size_t near = 0;             ///< points that no ball touches, which have the thickness of the nearest ball
};

/// At each point the diameter of the largest ball of a vertex of `axis` that is at most `tolerance` away from the point
/// or contains it; where there is none that of the ball the point is least outside of. The point across is the point
/// of `surface` (which may be null) nearest to the end of the diameter that begins at the point, of the ball with the
/// nearest centre among those of 0.98 of the radius or more that touch it too. O(n log n) in
/// practice, on all threads. Throws Error(usage) for an axis without vertices.
SurfaceThickness surface_thickness(std::span<const Vec3> points, const Surface* surface, const MedialAxis& axis,
                                   const SurfaceThicknessOptions& options, Context* context = nullptr);

/// The thickness 2 r + 2 `correction` of the sheets of an axis, weighted by area: of each triangle of a fan over a face
/// by its mean radius. In the plane of its curves, by length.
ThicknessDistribution sheet_thickness(const MedialAxis& axis, double correction = 0);

}  // namespace quench
