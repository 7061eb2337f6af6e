// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "quench/complex.h"
#include "quench/context.h"
#include "quench/geometry.h"
#include "quench/record.h"

namespace quench {

struct MedialAxis;
namespace burning {
struct BurnedSectors;
}

/// The radius at nodes inside an edge.
enum class RadiusRule {
  exact,  ///< distance to a point the edge's ends share as nearest: R^2 = (1-t)R0^2 + tR1^2 - t(1-t)L^2
  linear  ///< for medial axes whose ends share no nearest point
};

/// How fire crosses the polygons of an axis.
enum class Propagation {
  segments,  ///< from the pieces of edges between nodes: mean error of erosion thickness 0.1 to 0.3 % at the default
             ///< spacing
  windows    ///< exactly, up to rounding, whatever the spacing, where radii are distances to points; two to five times
             ///< the time of burning, on one thread
};

struct BurnOptions {
  double omega = 0;  ///< largest distance of neighbouring nodes on an edge, world units; 0: default_omega()
  RadiusRule radius = RadiusRule::exact;
  Propagation propagation = Propagation::segments;
  /// The axis is that of a shape of the plane, a graph of curves: fire starts at its free ends at the time of the
  /// radius, runs with unit speed, dies at a junction unless one branch is left, and never burns loops (Yan 2018, ch. 3
  /// in two dimensions; Liu et al. 2011). Exact, without nodes inside of edges. burn(axis) sets it.
  bool plane = false;
  bool parents = true;  ///< also find the burn sequence: parents of prime sectors, which medial curves need
  /// Times are rounded to what files keep of them: the radius and a multiple of a power of two, which is at most a
  /// 4096th of omega (more where times are 2^28 of these: the largest that keep 28 bits). burn_sequence() needs it.
  bool rounded = false;
};

/// The result of burning. Times are in world units; infinite where no fire comes (closed pockets).
struct Burning {
  BurnOptions options;                    ///< with the spacing that was used
  std::vector<double> burn_time;          ///< per vertex: the largest time of its sectors; the radius if it has none
  std::vector<double> erosion_thickness;  ///< per vertex: burn_time - radius
  double max_burn_time = 0;               ///< largest finite burn time of a vertex
  std::uint32_t unburned = 0;             ///< number of vertices with infinite burn time
  std::uint32_t node_count = 0;           ///< vertices, and nodes inserted on edges
  /// Opaque: times and parents of all sectors, which quench_curves() continues from. Most of the memory of a burning;
  /// may be reset where no curves are needed.
  std::shared_ptr<const burning::BurnedSectors> sectors;
};

/// Burns a complex of convex polygons with a radius per vertex (Yan 2018, ch. 3, with a time per sector of a link in
/// place of Algorithm 1, see docs/algorithms/burning.md): fire starts on the free edges at the time of the radius, runs
/// with unit speed, stops at a seam until one sheet is left there, and continues in that one.
///
/// Preconditions: a point and a radius per vertex; radii finite and not negative, else Error(input); a spacing that is
/// finite and not negative, else Error(usage). Error(failed) when there are more than 2^32 states. Polygons that are
/// not flat or not convex are cut into triangles; those flatter than 1e-12 of a side are crossed along straight lines
/// from node to node only, which is less accurate. Propagation::windows follows fire exactly (open in Yan 2018,
/// sec. 4.1.1): the lower envelope of arrivals on every edge, each from an unfolded source. Linear radii on the rim are
/// taken as distances to a source a million times the edge away.
///
/// Deterministic. Near O(n log n) in nodes for polygons of few nodes; about 190 bytes per node, up to 300 where most of
/// the axis is noise.
Burning burn(const CellComplex& complex, std::span<const Vec3> points, std::span<const double> radius,
             const BurnOptions& options = {}, Context* context = nullptr);
/// The same for the complex, points and radii of an axis.
Burning burn(const MedialAxis& axis, const BurnOptions& options = {}, Context* context = nullptr);

/// Where the fire on a medial axis of the plane ends.
struct MedialPoint {
  Vec3 point;
  double radius = 0, burn_time = 0;
};

/// The medial point of every component of a burned medial axis of the plane that has no loop, in the order of their
/// first vertices: the point that burns last, mostly inside an edge, where fires meet (Yan 2018, sec. 4.1.2; Liu et al.
/// 2011 call it the centre). Loops never burn, and have none. O(n). Throws Error(usage) unless the burning is that of
/// an axis of the plane.
std::vector<MedialPoint> medial_points(const MedialAxis& axis, const Burning& burning);

/// The spacing of nodes that burn() takes where none is given: 0.35 of the mean edge for triangles, whose diagonals are
/// long, 0.65 for other polygons. The mean error of erosion thickness is then about 0.1% (docs/algorithms/burning.md).
double default_omega(const CellComplex& complex, std::span<const Vec3> points);

/// Predicted peak of memory of burn(), in bytes, without that of its input.
std::int64_t predicted_burn_bytes(const CellComplex& complex, std::span<const Vec3> points, const BurnOptions& options);

/// Adds the result to the file the axis came from (vertex v is row v): point arrays `burn_time`, `erosion_thickness`,
/// `unburned` (1 where infinite; the largest finite value is written there), field arrays `omega`, `propagation`
/// ("segments" or "windows"), `radius_rule`, `burn_nodes`, `max_burn_time`, and those of `sequence`. Arrays of these
/// names are replaced, and a sequence of an earlier burning goes.
void add_burning(Record& data, const Burning& burning, std::vector<DataArray> sequence = {});

/// The times and the burn sequence of all sectors as field arrays (docs/user/files.md), for add_burning(): 4 to 6 bytes
/// per sector, of which half is left when they are compressed. Throws Error(usage) unless the axis was burned with
/// BurnOptions::parents and rounded.
std::vector<DataArray> burn_sequence(const MedialAxis& axis, const Burning& burning);

/// The burning whose sequence a file holds, all of it: quench_curves() makes of it what it makes of the burning that
/// was written. Takes a tenth of the time of burning. Nothing where there is none; and, with a note, where it is
/// damaged or not of this axis, these radii and these options, whose omega must be above 0.
std::optional<Burning> kept_burning(const Record& data, const MedialAxis& axis, const BurnOptions& options,
                                    Context* context = nullptr);

/// Radius at a node inside an edge, `t` from the first end in [0, 1]; linear where the ends cannot share a nearest
/// point (|R0 - R1| > L or L > R0 + R1).
double radius_inside_edge(double r0, double r1, double length, double t, RadiusRule rule);

}  // namespace quench
