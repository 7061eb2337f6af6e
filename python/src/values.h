// SPDX-License-Identifier: Apache-2.0
// What Python holds: shapes, medial axes, skeletons, graphs. Each keeps what it was made of, so that results outlive
// their inputs.
#pragma once

#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "arrays.h"
#include "quench/envelope.h"
#include "quench/picture.h"
#include "quench/pipeline.h"
#include "quench/shape.h"
#include "quench/simplify.h"
#include "quench/solid_stages.h"
#include "quench/table.h"
#include "quench/tree.h"
#include "quench/verify.h"
#include "run.h"

namespace quench::python {

/// An image as read from a file.
struct Image {
  std::shared_ptr<const Volume> volume;
};

using Shape = pipeline::LoadedShape;

/// A burned axis: what is left of it once the family of skeletons is made.
struct Fire {
  Burning burning;                  ///< without its states when `family` is there
  std::vector<DataArray> sequence;  ///< what files keep of these states, when `family` is there
  std::shared_ptr<const pipeline::FamilyResult> family;
  bool stored = false;  ///< of a pickle: of `burning` the options only, until restored() is asked
};

struct Axis {
  std::shared_ptr<Shape> shape;      ///< none for an axis from a file
  pipeline::CoreResult core;         ///< of an axis from a file: axis, longest_side, topology, coordinates, and where
                                     ///< the file says them measure, threshold, reconstructed and coverage; else NaN
  std::optional<Record> file;        ///< of an axis from a file
  Vec3 spacing = Vec3::Zero();       ///< of its voxels, 0 where unknown
  std::optional<pipeline::PlaneSites> sites = {};  ///< of the plane: from which radii are known
  bool voxel_core = true;            ///< radii are distances to points that neighbours share: not fitted
  std::shared_ptr<const Fire> fire;  ///< the last one; under the interpreter's lock

  const MedialAxis& axis() const { return core.axis; }
  /// Whether measure and threshold of a pruning are known: not of an axis of another program.
  bool is_pruned() const { return !std::isnan(core.threshold); }
  pipeline::Scale scale() const {
    Grid grid = axis().grid;
    grid.spacing = spacing;
    return {core.longest_side, spacing.minCoeff(), auto_detail(grid), axis().is_fitted()};
  }
  /// World units of a length such as "0.02" or "2.5vox".
  double resolve(const std::string& text, const std::string& field) const;
  /// The axis as a file, with what a fire says, if any; and with its burn sequence, for later.
  Record data(const Fire* with, bool sequence = false) const;
};

struct SkeletonValue {
  std::shared_ptr<Axis> axis;  ///< of skeletonize(): without its cells
  bool has_axis = true;
  pipeline::SkeletonResult checked;  ///< drawn with its smoothed branches
  CurveGraph drawn;                  ///< these branches
  Skeleton member;                   ///< the same before that: what graphs are made of
  Record about;                      ///< FieldData of the file of the axis, for files of the skeleton
};

struct GraphValue {
  std::shared_ptr<SkeletonValue> skeleton;
  CurveGraph graph;
};

struct PartsValue {
  pipeline::PartsRun run;
  Record about;  ///< of the skeleton, for files
  std::string units;
};

/// A tree with what it is of.
struct TreeValue {
  pipeline::TreeRun run;
  std::shared_ptr<Axis> axis;  ///< none for a tree from a file
  bool upright = false;
};

/// The solid of an axis or of a skeleton, and the shape it is compared with, if any.
struct SolidValue {
  std::shared_ptr<Shape> shape;
  std::shared_ptr<Axis> axis;  ///< one of the two
  std::shared_ptr<SkeletonValue> skeleton;
  Coordinates coordinates;
  pipeline::SolidResult result;
};

/// What simplify() gives, with the points that it stays near.
struct SimplificationValue {
  std::shared_ptr<Axis> from;
  BoundaryPoints boundary;
  std::string boundary_is;
  Simplified result;
  int fits = 0;
};

/// Of a picture: width, height, whether there is a caption. None: as files of pictures are.
using PictureSize = std::optional<std::tuple<int, int, bool>>;
PictureOptions options_of(const PictureSize& size);

/// Lengths as texts.
struct Thetas {
  std::string theta2, theta1;
  bool full_tips = true;
};

/// outside, either_side (each mean, p99, largest) and places.
py::dict dict_of(const OneSidedDistances& of);
/// Of the names "detail" and "lambda", and "auto" or a length.
pipeline::Pruning pruning_of(const std::string& measure, const std::string& threshold);
std::shared_ptr<Axis> compute_axis(std::shared_ptr<Shape> shape, const pipeline::AxisOptions& options,
                                   Context& context);
/// Of a fire; omega 0 and no propagation: those of the file the axis came from, or automatic.
struct FireOptions {
  double omega = 0;
  std::optional<Propagation> propagation = {};

  /// Those of a fire that is known, or automatic.
  static FireOptions of(const std::shared_ptr<const Fire>& known) {
    if (!known) return {};
    return {known->burning.options.omega, known->burning.options.propagation};
  }
  /// "auto", "segments" or "windows".
  FireOptions(double spacing, const std::string& name)
      : omega(spacing), propagation(pipeline::propagation_of(name)) {}
  FireOptions(double spacing = 0, std::optional<Propagation> how = {}) : omega(spacing), propagation(how) {}
};
/// Burns an axis and, if `family`, makes its skeletons; takes over what `known` has of the same options.
std::shared_ptr<const Fire> compute_fire(const Axis& axis, const FireOptions& how, bool family,
                                         const std::shared_ptr<const Fire>& known, Context& context);
/// A fire that is not only stored, or null.
std::shared_ptr<const Fire> restored(const Axis& axis, std::shared_ptr<const Fire> fire, Context& context);
std::shared_ptr<SkeletonValue> compute_skeleton(std::shared_ptr<Axis> axis, const Fire& fire, const Thetas& thetas,
                                                Context& context);

/// What is known of the shape of an axis, for graphs of its skeletons.
pipeline::GraphOptions graph_options(const Axis& axis);

/// The complex, points and radii of a skeleton, whose solid is wanted.
MedialAxis balls_of(const SkeletonValue& skeleton);

/// The voxels of a shape as an image of 0 and 1.
Image image_of(const VoxelShape& shape, const Coordinates& coordinates);

/// What results of a shape are verified with; it must outlive them.
VerifyOptions verify_options(const Shape& shape, std::size_t samples);
/// Rows (name, passed, detail).
py::list checks_of(const Certificate& certificate);

/// A table as rows (name, unit, meaning, values), a column each.
py::list columns_of(const Table& table);

void bind_shapes(py::module_& m);
void bind_axes(py::module_& m);
void bind_skeletons(py::module_& m);
void bind_parts(py::module_& m);
void bind_trees(py::module_& m);
void bind_solids(py::module_& m);
void bind_labels(py::module_& m);
void bind_thickness(py::module_& m);
void bind_pages(py::module_& m);
void bind_pickles(py::module_& m);

}  // namespace quench::python
