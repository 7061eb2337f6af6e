// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "quench/shape.h"

namespace quench::shape {

/// Samples of an image as signed values, of which 0 is the surface.
class SignedSamples {
 public:
  virtual ~SignedSamples() = default;
  /// Of a voxel in the image: above 0 in the foreground (an exact tie may be 0), else below. Not finite, or below 0 in
  /// the foreground: not known.
  virtual double at(std::int64_t x, std::int64_t y, std::int64_t z) const = 0;
};

/// The surface between foreground and background, layer by layer: layer z is the cells between the centres of slices z
/// and z + 1, from -1 to the last slice, as what is outside of the image is background. A vertex lies on every edge
/// between a foreground and a background voxel, where the samples interpolated along it are 0, but no nearer to a voxel
/// centre than kClearance; half way where a sample is not finite or outside the image. A loop of them in a cell bounds
/// a fan of triangles around a point of the surface on which the samples interpolated trilinearly are 0, or fewer
/// triangles where that point is within kFlat of them. The surface is a closed manifold with the topology of the shape,
/// and has every voxel centre on its side. Source: marching cubes (Lorensen and Cline 1987), with the topology of the
/// voxels (Lachaud and Montanvert 2000).
///
/// The order of vertices and triangles depends on the shape only. Only scanlines of the two slices of a layer, and
/// samples of the voxels around the surface, are read.
class SurfaceLayers {
 public:
  static constexpr double kClearance = 0.01;  ///< voxels

  /// `samples` null: all vertices half way.
  SurfaceLayers(const VoxelShape& shape, const SignedSamples* samples, std::int64_t first_layer);

  /// The next layer; scanlines of the slices up to z + 1 are there.
  void add_layer();

  /// What the layers so far give, in lattice coordinates; vertices of the last slice are missing, as they are the first
  /// ones of the layer that follows.
  TriangleMesh mesh;

 private:
  /// The vertices on edges between two slices or two scanlines: where those of each scanline begin.
  struct Slice {
    std::vector<Vec3> points;
    std::vector<std::uint32_t> along_x, along_y;
  };
  struct Row;
  struct Column;

  void read_slice(std::int64_t z, Slice& slice) const;
  void add_upright(std::int64_t z);
  void add_row(std::int64_t y, std::int64_t z);
  void add_cell(int corners, const Row& row, std::int64_t x, const Column& left, const Column& right);
  void add_tube(const std::uint8_t* edges, const std::array<std::uint32_t, 12>& id);
  void add_loop(std::span<const std::uint8_t> edges, const std::array<std::uint32_t, 12>& id,
                const std::array<Vec3, 12>& place, const std::array<double, 8>& value, const Vec3& corner);
  void read(Column& column, std::int64_t x, std::int64_t y, std::int64_t z, unsigned foreground) const;
  double value(std::int64_t x, std::int64_t y, std::int64_t z, bool foreground) const;
  /// Place on the edge from a voxel to the next one along an axis.
  Vec3 on_edge(std::int64_t x, std::int64_t y, std::int64_t z, int axis, bool first_is_foreground) const;

  const VoxelShape& shape_;
  const SignedSamples* samples_;
  std::int64_t layer_;
  Slice lower_, upper_;
  std::vector<std::uint32_t> upright_;  // where the vertices between two slices begin, per scanline
};

}  // namespace quench::shape
