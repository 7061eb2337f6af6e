// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "quench/complex.h"
#include "quench/context.h"
#include "quench/geometry.h"

namespace quench {

/// Foreground voxels [begin, end) of one scanline along x.
struct Run {
  std::int32_t begin;
  std::int32_t end;
  friend bool operator==(const Run&, const Run&) = default;
};

/// A voxel shape O: the open interior of the union of the foreground voxels (foreground 6-connected, background
/// 26-connected; Yan 2018, sec. 2.4). Sparse: sorted, disjoint, non-touching runs per scanline; row index y +
/// dims[1]*z. Memory: 8 bytes per run and 4 per scanline.
class VoxelShape {
 public:
  VoxelShape() = default;
  explicit VoxelShape(const Grid& grid) : grid_(grid) {}

  const Grid& grid() const { return grid_; }
  /// The runs of scanline (y, z); empty outside the grid.
  std::span<const Run> row(std::int64_t y, std::int64_t z) const {
    if (y < 0 || z < 0 || y >= grid_.dims[1] || z >= grid_.dims[2] || row_begin_.empty()) return {};
    const std::size_t r = static_cast<std::size_t>(y + grid_.dims[1] * z);
    return {runs_.data() + row_begin_[r], runs_.data() + row_begin_[r + 1]};
  }
  /// O(log runs of the scanline); false outside the grid.
  bool contains(std::int64_t x, std::int64_t y, std::int64_t z) const;
  std::span<const Run> runs() const { return runs_; }
  std::int64_t voxel_count() const;
  bool empty() const { return runs_.empty(); }
  /// Smallest and one-past-largest voxel coordinates of the foreground; both 0 when empty.
  struct Box {
    std::array<std::int64_t, 3> begin{0, 0, 0}, end{0, 0, 0};
  };
  Box foreground_box() const;
  /// Longest side of the foreground box in world units: what a plain number as a length refers to for volumes.
  double longest_side() const;
  /// Throws Error(invariant) naming the first relation that does not hold (row offsets, order of runs, grid).
  void validate() const;

  /// Appends the runs of the next scanline (y fastest, then z); merges touching runs, drops empty ones.
  /// All dims[1]*dims[2] scanlines must be appended before the shape is used. Runs must be sorted by begin.
  void append_row(std::span<const Run> runs);

 private:
  Grid grid_;
  std::vector<std::uint32_t> row_begin_;  // dims[1]*dims[2] + 1 offsets into runs_
  std::vector<Run> runs_;
};

/// The boundary vertices P (the sites): lattice points whose 8 incident voxels are neither all in O nor all out,
/// in order of z, y, x. O(runs + sites).
std::vector<LatticePoint> boundary_vertices(const VoxelShape& shape);
/// Their number, without storing them.
std::int64_t count_boundary_vertices(const VoxelShape& shape);

/// The shape with every voxel split into factor^3 voxels (Yan 2018, Figs. 2.3, 2.4).
VoxelShape subdivide(const VoxelShape& shape, int factor);

/// Whether the segment between two points of the world lies in the shape: every voxel it passes is foreground. False
/// when an end is not finite. O(voxels passed * log runs).
bool contains_segment(const VoxelShape& shape, const Vec3& a, const Vec3& b);

/// Topology of the open voxel shape: euler = voxels - face-adjacent pairs + full 2x2 squares - full 2x2x2 cubes;
/// b0 = 6-connected components; b2 = 26-connected components of the complement - 1. O(runs log runs), exact.
Topology topology(const VoxelShape& shape);

/// A scalar image as read from a file: x fastest. The sample type is kept, so that labels stay exact.
struct Volume {
  using Samples =
      std::variant<std::vector<std::uint8_t>, std::vector<std::int8_t>, std::vector<std::uint16_t>,
                   std::vector<std::int16_t>, std::vector<std::uint32_t>, std::vector<std::int32_t>,
                   std::vector<std::uint64_t>, std::vector<std::int64_t>, std::vector<float>, std::vector<double>>;
  Grid grid;
  Samples samples;
  Coordinates coordinates;
  std::string spacing_source;  ///< what the spacing was taken from, e.g. "the ImageJ description"; empty: the file
                               ///< does not say one, and it is 1
  std::string picture;         ///< what kind of picture it was, e.g. "an RGB picture"; empty: none, or not known
};

/// A bound of samples. Whole numbers stay exact: 64-bit samples have values that a double rounds.
using Threshold = std::variant<double, std::int64_t, std::uint64_t>;

inline constexpr int kLargestClosing = 64;

/// Which voxels of an image are the shape. At most one of threshold and label may be set; with neither, the
/// foreground is the non-zero voxels of an image that has at most two values, and any other image is Error(usage).
struct ForegroundOptions {
  std::optional<Threshold> threshold;  ///< foreground: value >= threshold (NaN is background)
  std::optional<std::int64_t> label;   ///< foreground: value == label, 0 included
  /// Hysteresis: of the voxels of at least `threshold` only those that are connected (as `connectivity` says) to one of
  /// at least this, which is no less. Not with `invert`.
  std::optional<Threshold> seed_threshold = {};
  bool invert = false;                 ///< foreground becomes background, within the image's box
  /// Morphological closing by a ball of this radius, in voxels of the smallest spacing, at most kLargestClosing; 0: none.
  int close = 0;
  /// 6 or 26 (in a plane 4 or 8). With 26, voxels that touch in edges or corners are joined by few voxels: one per edge,
  /// two per corner, fewer where one joins several parts, those first that make no loop, then the brighter ones. Then
  /// there are as many 6-connected components as there were 26-connected ones, but where two parts of one cannot be
  /// joined by so few voxels without touching a third that belongs to another.
  int connectivity = 6;
  bool largest_component = false;      ///< keep the largest 6-connected component
  std::int64_t min_component = 0;      ///< drop 6-connected components of fewer voxels
  bool fill_cavities = false;          ///< fill 26-connected background components that do not reach outside the box
  std::int64_t min_cavity = 0;         ///< fill those of fewer voxels only; in a plane 8-connected: holes
};

/// What cleaning has changed.
struct ForegroundReport {
  std::int64_t voxels_before = 0;  ///< of the shape, before anything was dropped or filled
  std::int64_t components_removed = 0;
  std::int64_t voxels_removed = 0;
  std::int64_t cavities_filled = 0;
  std::int64_t voxels_filled = 0;
  std::int64_t voxels_closed = 0;      ///< added by closing
  std::int64_t voxels_joined = 0;      ///< added to join what touches in edges or corners
  std::int64_t components_joined = 0;  ///< by how many 6-connected components there are less for it
  std::int64_t weak_dropped = 0;       ///< voxels, by hysteresis
};

/// "36%", "0.02%": at least one digit that is not 0, and 100% only of everything.
std::string percent_text(std::int64_t part, std::int64_t whole);
/// The voxels of each cavity (26-connected background that does not reach outside the box; in a plane each hole),
/// descending.
std::vector<std::int64_t> cavity_sizes(const VoxelShape& shape, Context* context = nullptr);
/// The 6-connected (in a plane 4-connected) components of fewer voxels than `below`, as noise makes them.
struct Specks {
  std::int64_t count = 0;
  std::int64_t voxels = 0;    ///< of all of them
  std::int64_t touching = 0;  ///< how many of them touch another component, in edges or corners
};
Specks specks_of(const VoxelShape& shape, std::int64_t below, Context* context = nullptr);
/// A warning, when dropping components took so much of the shape that this may be a mistake; empty otherwise.
/// `plane`: of pixels.
std::string much_dropped(const ForegroundReport& report, bool plane = false);

/// The foreground of an image as a voxel shape on the image's grid. Applied in the order hysteresis, invert, closing,
/// connectivity, components, cavities.
/// Throws Error(input) when nothing is left, naming the range of values found.
VoxelShape foreground(const Volume& volume, const ForegroundOptions& options, ForegroundReport* report = nullptr,
                      Context* context = nullptr, std::optional<TriangleMesh>* isosurface = nullptr);

/// Drops components and fills cavities as asked (the part of ForegroundOptions that also applies to voxelized meshes).
VoxelShape clean(const VoxelShape& shape, const ForegroundOptions& options, ForegroundReport* report = nullptr,
                 Context* context = nullptr);

enum class SampleType { uint8, int8, uint16, int16, uint32, int32, uint64, int64, float32, float64 };

/// Samples that somebody else owns, in any order in memory: sample (x, y, z) is `strides[0]*x + strides[1]*y +
/// strides[2]*z` bytes after `data`. Strides may be negative or 0; samples need not be aligned. Nothing is copied.
struct ImageView {
  Grid grid;
  SampleType type = SampleType::uint8;
  const void* data = nullptr;
  std::array<std::int64_t, 3> strides{0, 0, 0};
};

/// The samples of a volume.
ImageView view_of(const Volume& volume);

/// As foreground() of a volume. The result does not depend on the order in memory. Memory beyond the shape: 8 bytes per
/// voxel of one slice where x is not the closest axis in memory, else nothing.
///
/// `isosurface`: becomes the surface of the shape by the values of the samples, in lattice coordinates: closed, faces
/// outward, with the topology of the shape; nothing without a threshold and for an image of at most two values, where
/// the values do not say more than the voxels. Where samples interpolated trilinearly between the centres of voxels
/// equal the threshold (half a unit less for integer samples and a whole threshold, so that the surface of a mask is
/// half way), in triangles of about a voxel; half a voxel outside the image where the shape meets its border, and half
/// way to a sample that is not finite and to a voxel that closing or joining has added. On all threads; about 80 bytes
/// per boundary vertex.
VoxelShape foreground(const ImageView& image, const ForegroundOptions& options, ForegroundReport* report = nullptr,
                      Context* context = nullptr, std::optional<TriangleMesh>* isosurface = nullptr);

/// The surface through the points half way between neighbouring voxels of foreground and background, in lattice
/// coordinates: closed, faces outward, with the topology of the shape.
TriangleMesh midpoint_surface(const VoxelShape& shape, Context* context = nullptr);

/// Drops what does not bound `shape` of a surface as foreground() or midpoint_surface() make it, of a shape of which
/// clean() made `shape`. O(triangles * log runs).
void restrict_surface(TriangleMesh& surface, const VoxelShape& shape);

/// How far smooth_surface() goes.
struct SurfaceSmoothing {
  int passes = 2;
  double reach = 0.3;  ///< of every coordinate of a vertex, in voxels; below half of one
};

/// What takes the steps of voxels away.
inline constexpr SurfaceSmoothing kStepSmoothing{6, 0.49};

/// Smooths a surface as foreground() or midpoint_surface() make it: vertices go to quadrics fitted to what lies up to
/// four cells around them, and no farther than `reach`. Planes, spheres and cylinders stay where they are; noise and
/// steps of few voxels go. Corners stay within their cells.
void smooth_surface(TriangleMesh& surface, const SurfaceSmoothing& options = {}, Context* context = nullptr);

/// From lattice coordinates to those of the world; faces stay outward.
void to_world(TriangleMesh& surface, const Grid& grid);

/// A label of an image and the box of its voxels.
struct LabelRuns {
  /// Voxels [begin, end) along x in scanline (y, z).
  struct Piece {
    std::int32_t z, y, begin, end;
    friend auto operator<=>(const Piece&, const Piece&) = default;
  };
  std::int64_t label = 0;
  std::vector<Piece> pieces;  ///< in no particular order
  /// The voxels of the label on a grid cut to their box: world coordinates are those of the whole image.
  VoxelShape shape(const Grid& image) const;
};

/// The voxels of every label that `wanted` takes (all but 0 without it), in one pass, by ascending label: 16 bytes per
/// run of equal values. Throws Error(input) for samples that are not integers.
std::vector<LabelRuns> label_runs(const ImageView& image, const std::function<bool(std::int64_t)>& wanted = nullptr,
                                  Context* context = nullptr);

/// An image one slice at a time, so that it is never in memory as a whole.
struct SliceStream {
  Grid grid;
  SampleType type = SampleType::uint8;
  Coordinates coordinates;
  std::string spacing_source;  ///< as of a Volume
  std::string picture;         ///< as of a Volume
  /// Fills in the next slice, z ascending: dims[0] * dims[1] samples, x fastest, in the byte order of the machine.
  /// Throws Error(input) when the data end early.
  std::function<void(std::span<std::byte> slice)> next;
};

/// As foreground() of an image. Reads the stream once; memory beyond the shape: one slice, two with an isosurface, all
/// of the image where voxels are closed or joined by a threshold.
VoxelShape foreground(const SliceStream& image, const ForegroundOptions& options, ForegroundReport* report = nullptr,
                      Context* context = nullptr, std::optional<TriangleMesh>* isosurface = nullptr);

}  // namespace quench
