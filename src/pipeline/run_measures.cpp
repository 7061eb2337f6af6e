// SPDX-License-Identifier: Apache-2.0
#include "pipeline/run_measures.h"

#include <algorithm>
#include <random>

#include "quench/error.h"
#include "quench/simplify.h"

namespace quench::pipeline {
namespace {

constexpr std::int64_t kSamples = 20000;
constexpr std::size_t kBoundary = 20000;  // points of the boundary by which medial meshes of a page are made

/// Centres of voxels of a shape: one of each of equal shares of them, in scanline order. Of small shapes all.
std::vector<Vec3> centres_in(const VoxelShape& shape) {
  const std::int64_t voxels = shape.voxel_count(), count = std::min(voxels, kSamples);
  std::mt19937_64 random(20180501);
  std::vector<Vec3> centres;
  std::int64_t passed = 0, target = 0;
  const auto choose = [&](std::int64_t i) {
    const std::int64_t begin = voxels * i / count, end = voxels * (i + 1) / count;
    target = begin +
             static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(std::max<std::int64_t>(1, end - begin)));
  };
  if (count == 0) return centres;
  choose(0);
  const auto& dims = shape.grid().dims;
  const double flat = shape.grid().is_plane() ? 0 : 0.5;
  for (std::int32_t z = 0; z < dims[2]; ++z)
    for (std::int32_t y = 0; y < dims[1]; ++y)
      for (const Run& run : shape.row(y, z)) {
        const std::int64_t length = run.end - run.begin;
        while (std::ssize(centres) < count && target < passed + length) {
          centres.push_back(
              shape.grid().world({static_cast<double>(run.begin + (target - passed)) + 0.5, y + 0.5, z + flat}));
          choose(std::ssize(centres));
        }
        passed += length;
      }
  return centres;
}

/// The skeleton as sheet_thickness() takes it.
MedialAxis axis_of_skeleton(const Skeleton& skeleton, const Grid& grid) {
  MedialAxis axis;
  axis.complex = skeleton.complex;
  axis.points = skeleton.points;
  axis.radius = skeleton.radius;
  axis.grid = grid;
  return axis;
}

}  // namespace

RunThickness thickness_of(const LoadedShape& shape, const MedialAxis& axis, const Skeleton& skeleton,
                          Context* context) {
  RunThickness thickness;
  thickness.correction = thickness_correction(axis);
  thickness.sheets = sheet_thickness(axis_of_skeleton(skeleton, axis.grid), thickness.correction);
  const std::vector<Vec3> centres = centres_in(shape.shape);
  const SurfaceThickness found =
      surface_thickness(centres, nullptr, axis, {.tolerance = 0, .correction = thickness.correction}, context);
  const double largest = found.thickness.empty() ? 0 : *std::ranges::max_element(found.thickness);
  thickness.shape = ThicknessDistribution(automatic_bin_width(shape.shape.grid(), largest));
  for (const double t : found.thickness) thickness.shape.add(t);
  return thickness;
}

void add_meshes_of(const LoadedShape& shape, const MedialAxis& axis, PageBuilder& builder, Context* context) {
  if (shape.shape.grid().is_plane()) return;
  const BoundaryPoints boundary = axis.is_fitted() && shape.surface ? boundary_points(*shape.surface, kBoundary)
                                                                    : boundary_points(shape.shape, kBoundary);
  builder.add_meshes(axis, boundary, true, context);
}

void PageBuilder::add_thickness(const MedialAxis& axis, Context* context) {
  if (page.plane || !page.find("shape/points") || axis.points.empty()) return;
  const std::vector<Vec3> points = surface_points(page);
  const SurfaceThickness found = surface_thickness(
      points, nullptr, axis, {.tolerance = page.voxel, .correction = thickness_correction(axis)}, context);
  add_surface_measure(page, "thickness", found.thickness);
}

void PageBuilder::add_sheets(const Parts& parts) {
  if (!parts.sheets.empty()) quench::add_sheets(page, sheet_table(parts, page.unit));
}

}  // namespace quench::pipeline
