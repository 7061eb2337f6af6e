// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "quench/axis.h"
#include "quench/burn.h"
#include "quench/complex.h"
#include "quench/context.h"
#include "quench/geometry.h"
#include "quench/record.h"

namespace quench {

/// A burned medial axis M cut up so that its medial curves are part of it (Yan 2018, sec. 3.4.4;
/// docs/algorithms/skeletons.md): the complex K. It covers M exactly and has its topology; it collapses onto the medial
/// curves and the closed pockets.
///
/// The prime arcs of the fire cut every polygon into regions. The medial curves are the dual network: a *region dual*
/// in each region, a *door* on every segment between neighbouring nodes, an edge between the two unless fire ran along
/// that segment in that polygon; nodes whose link falls apart are kept and tied to the network; lone edges belong to
/// it.
///
/// Vertices of K: the nodes of the burn network, then the doors (edge by edge), then the region duals. K may have
/// parallel edges and polygons that meet an edge twice: incidences are by index, and validate() does not apply.
struct RefinedAxis {
  CellComplex complex;
  std::vector<Vec3> points;
  std::vector<double> radius;
  RadiusRule radius_rule = RadiusRule::exact;  ///< of the burning: how the radius runs along an edge
  bool plane = false;  ///< of a shape of the plane: the curves are M itself, and their fire starts at the radius
  std::vector<double> mgf;  ///< per vertex, in the plane: the measure of M; may be empty
  std::vector<double>
      burn_time;  ///< per vertex: of M at nodes; on the medial curves that of their own fire; infinite at pockets
  std::uint32_t original = 0;  ///< vertices of M, the first nodes
  std::uint32_t nodes = 0, doors = 0;

  std::vector<char> curve_edge;           ///< per edge: part of the medial curves
  std::vector<char> curve_vertex;         ///< per vertex: part of the medial curves
  std::vector<std::uint32_t> polygon_of;  ///< per face: the polygon of M it is a part of
  std::vector<double> face_thickness;     ///< per face: largest (sector time - radius) over its corners
  std::vector<float> corner_thickness;  ///< per corner of a face: that of the corner; the first one is the region dual
  std::vector<std::uint32_t> incomplete;  ///< polygons of M of which parts are missing, below the floor of a family

  std::vector<double> curve_burn_time;  ///< per vertex: BT_MC; infinite where fire on the curves does not come
  std::vector<std::uint32_t> exit;      ///< per vertex: the edge over which it passed that fire on, or kNone
  std::vector<char> medial_point;       ///< per vertex: the last to burn in a tree of the curves without pocket
};

/// The medial curves of a burned axis (with parents), and their burning: fire starts at their free ends at the time the
/// fire on M comes there, runs with unit speed, dies at a junction unless one branch is left, and never burns loops.
/// O(n log n). Throws Error(invariant) when the number of prime arcs at a node is not the number of cycles of its link.
/// Works on the threads of the context, but for the fire on the curves near where it ends. A burning that is moved in
/// is given back before that, and takes most of its memory with it.
RefinedAxis quench_curves(const CellComplex& complex, std::span<const Vec3> points, std::span<const double> radius,
                          Burning burning, Context* context = nullptr);

/// All skeletons of a refined axis. The skeleton for (theta2, theta1) is what is left of { sheet_level >= theta2 } and
/// the curves after pruning free curve edges of a thickness below theta1 (world units; infinity allowed).
struct SkeletonFamily {
  RefinedAxis refined;
  double theta2_floor = 0, theta1_floor = 0;  ///< smaller thetas have no member: see with_floor()
  std::vector<double> vertex_sheet_level, edge_sheet_level, face_sheet_level;  ///< infinite on curves and pockets
  /// Per corner of a face, no larger than the level of the face: how the level rises inside of it. Of a face that a
  /// theta2 leaves, what lies between its corners above theta2 is left, cut along a straight line between the points of
  /// its sides at theta2, where levels are linear. That is one piece: there is one low and one high around the face.
  std::vector<float> corner_sheet_level;
  /// Per edge from 2 * doors on (the halves before are not curves): ET_MC, the smaller of its ends', infinite where it
  /// never burns; and the theta1 up to which it stays when no sheets are left.
  std::vector<double> curve_thickness, curve_level;
  double thickness_of(std::uint32_t edge) const { return curve_thickness[edge - 2 * std::size_t{refined.doors}]; }
  double level_of(std::uint32_t edge) const { return curve_level[edge - 2 * std::size_t{refined.doors}]; }
};
SkeletonFamily skeletons(RefinedAxis refined, Context* context = nullptr);
/// The family without what no member with theta2 >= `theta2`, theta1 >= `theta1` and tips that grow back from at least
/// `theta1` has: those members stay as they are, cell by cell, and most of the memory goes where little is above the
/// floor. Of a door that stays both halves stay, with their nodes; what no member has of these has the sheet level -1.
/// Thetas below the floor that a family has already do nothing. O(n).
SkeletonFamily with_floor(SkeletonFamily family, double theta2, double theta1, Context* context = nullptr);
/// quench_curves() and skeletons() of an axis and its burning.
SkeletonFamily skeletons(const MedialAxis& axis, const Burning& burning, Context* context = nullptr);

/// One member of the family, as a proper complex: no parallel edges, no polygon that repeats a corner, no edge of
/// length zero (region duals lie on their exit doors).
struct Skeleton {
  double theta2 = 0, theta1 = 0, theta1_radii = 0;
  bool full_tips = false;                                       ///< free ends grew back
  double rims_above = std::numeric_limits<double>::infinity();  ///< from which sheet level on rims grew back
  int smooth = 0;                                               ///< passes of smooth_sheets()
  bool plane = false;                                           ///< of a shape of the plane: its curves are the axis
  bool main_axes = false;                                       ///< only one course per component: main_axes()
  CellComplex complex;                                          ///< edges without face are curves
  std::vector<Vec3> points;
  std::vector<double> radius, burn_time, curve_burn_time;  ///< per vertex; infinite where no fire comes
  std::vector<char> on_curve;                              ///< per vertex: the two measures of curves are defined
  std::vector<double> mgf;                                 ///< per vertex, in the plane; may be empty
  std::vector<double> edge_thickness, edge_level;          ///< per edge: ET_MC and curve level; NaN where not a curve
  std::vector<std::int32_t> edge_branch;  ///< per edge: its branch, -1 off the curves; empty before with_branches()
  std::vector<double> face_thickness, face_level;  ///< per face: erosion thickness and sheet level
  std::vector<std::int32_t> face_sheet;  ///< per face: its sheet, 0 and up: faces joined over edges of exactly two
};

struct ExtractOptions {
  bool parts = false;  ///< every part of a polygon is a face of its own; else what is left of a polygon is one face, if
                       ///< that is a disk
  /// Pruning takes about theta1 off every branch, also of those that stay. Where this thickness is finite, every free
  /// end grows back along the pruned curve of the largest level, as far as the thickness is at least this. The family
  /// remains nested, and topology does not change.
  double regrow_tips_above = std::numeric_limits<double>::infinity();
  /// Pruning takes about theta2 off every rim of a sheet. Where this sheet level is below theta2, what is left grows
  /// back along the fires that reached it, as far as the level is at least this, up to the next seam: where the fires
  /// of two other sheets met, as those between the sides of a plate and its end do. So do the fires beside these that
  /// died out before they came to a curve of ET_MC `minor_curve` or more, or whose level comes to half the radius or to
  /// 0.8 theta2. The family remains nested, and topology does not change.
  double regrow_rims_above = std::numeric_limits<double>::infinity();
  double minor_curve = 0;
  /// A curve with a free end also goes where it sticks out by less than this many burn times (radii, in a tube), or
  /// becomes so on the way from there to a sheet, a loop or the medial point: it then does not stick out of what it
  /// leaves or of a thick part on its way. It sticks out by its ET_MC, but by no more than one and a half times what the
  /// ball around that place, of its burn time, has to grow to contain the balls of the branch outside: courses under a
  /// rough surface are long because they are crooked. Of a tree that would go as a whole a course stays: the branches
  /// that stick out most at its medial point.
  /// Nested in this; in theta1 and theta2 but for such courses.
  double theta1_radii = 0;
  /// The balls of a branch are those of its curves with an ET_MC of at least this, or of theta1 if that is less: as
  /// long as this is infinite, branches count only as far as theta1 reaches. Set it with theta1_radii.
  double balls_above = std::numeric_limits<double>::infinity();
};
Skeleton extract(const SkeletonFamily& family, double theta2, double theta1, const ExtractOptions& options = {});

/// How smooth_sheets() moves the vertices of sheets. Lengths in world units.
struct SheetSmoothing {
  double window = 0;  ///< rims and seams become the mean of themselves over so much to both sides, weighted by a hat
  int passes = 0;  ///< in which vertices inside a sheet move half way to the mean of their neighbours, along its normal
  double most = 0;  ///< no vertex moves further, nor by more than half its radius: so all stay inside the shape
};
/// Smooths rims, seams and sheets; where these meet, and curves off the sheets, nothing moves. Cells stay as they are,
/// and values, but for radii: they are less by what the vertex moved, so that balls stay inside the shape. O(n), with
/// the number of vertices in a window.
void smooth_sheets(Skeleton& skeleton, const SheetSmoothing& how, Context* context = nullptr);

/// The skeleton as cells and arrays of a file (docs/algorithms/skeletons.md). A line is a curve, a vertex cell an
/// isolated vertex. Where branches are known, the lines of each follow each other along it and have the same values,
/// the largest of the branch: VTP files have one polyline for them. In the plane the fire on the curves is the burn:
/// its times are `burn_time` and `erosion_thickness`, and there are no arrays of sheets.
Record to_record(const Skeleton& skeleton);

}  // namespace quench
