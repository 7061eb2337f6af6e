// SPDX-License-Identifier: Apache-2.0
// What Python holds: shapes, medial axes, skeletons, graphs. Each keeps what it was made of, so that results outlive
// their inputs.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "arrays.h"
#include "quench/pipeline.h"
#include "quench/shape.h"
#include "run.h"

namespace quench::python {

/// An image as read from a file.
struct Image {
  std::shared_ptr<const Volume> volume;
};

/// A voxel shape and the image it is cut from.
struct Shape {
  VoxelShape voxels;
  Grid image;               ///< voxels that to_volume() and reconstruct() refer to
  double longest_side = 0;  ///< what plain-number lengths refer to
  Coordinates coordinates;
  std::string parameters;  ///< JSON text: how the voxels follow from the input
  Topology topology;

  double smallest() const { return voxels.grid().spacing.minCoeff(); }
};

/// A burned axis: what is left of it once the family of skeletons is made.
struct Fire {
  Burning burning;  ///< without its states when `family` is there
  std::shared_ptr<const SkeletonFamily> family;
};

struct Axis {
  std::shared_ptr<Shape> shape;      ///< none for an axis from a file
  CheckedCore core;                  ///< of an axis from a file: axis, longest_side, topology
  std::optional<Record> file;        ///< of an axis from a file
  Vec3 spacing = Vec3::Zero();       ///< of its voxels, 0 where unknown
  bool voxel_core = true;            ///< radii are distances to points that neighbours share
  std::shared_ptr<const Fire> fire;  ///< the last one; under the interpreter's lock

  const MedialAxis& axis() const { return core.axis; }
  /// World units of a length such as "0.02" or "2.5vox".
  double resolve(const std::string& text, const std::string& argument) const;
  /// Of the shape, or as the file says.
  Coordinates coordinates() const;
  /// The axis as a file, with what a fire says, if any.
  Record data(const Fire* with) const;
};

struct SkeletonValue {
  std::shared_ptr<Axis> axis;  ///< of skeletonize(): without its cells
  bool has_axis = true;
  CheckedSkeleton checked;
  Record about;  ///< FieldData of the file of the axis, for files of the skeleton
};

struct GraphValue {
  std::shared_ptr<SkeletonValue> skeleton;
  CurveGraph graph;
};

/// How a shape is cut out of an image: arguments of medial_axis().
struct Cut {
  std::optional<Threshold> threshold;
  std::optional<std::int64_t> label;
  bool invert = false, largest_component = false, fill_cavities = false;
  std::int64_t min_component = 0;
  int subdivide = 1;

  ForegroundOptions foreground() const {
    return {threshold, label, invert, largest_component, min_component, fill_cavities};
  }
};

/// Fills in what follows from the voxels.
std::shared_ptr<Shape> finished(Shape shape, const Cut& cut);

/// Core of a shape; lambda "auto" or a length.
std::shared_ptr<Axis> compute_axis(std::shared_ptr<Shape> shape, const std::string& lambda, bool ball_rule,
                                   Context& context);
/// Burns an axis and, if `family`, makes its skeletons; takes over what `known` has of the same omega.
std::shared_ptr<const Fire> compute_fire(const Axis& axis, double omega, bool family,
                                         const std::shared_ptr<const Fire>& known, Context& context);
std::shared_ptr<SkeletonValue> compute_skeleton(std::shared_ptr<Axis> axis, const Fire& fire, double theta2,
                                                double theta1, Context& context);

/// Memory of the whole way from a shape to its skeletons, in bytes, by measured cases.
std::int64_t predicted_bytes(const VoxelShape& shape);

void bind_shapes(py::module_& m);
void bind_axes(py::module_& m);
void bind_skeletons(py::module_& m);
void bind_labels(py::module_& m);
void bind_pages(py::module_& m);

}  // namespace quench::python
