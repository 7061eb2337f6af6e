// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <tbb/parallel_for.h>

#include <array>
#include <atomic>
#include <optional>
#include <string>
#include <vector>

#include "base/csr.h"
#include "quench/complex.h"
#include "quench/measures.h"
#include "quench/record.h"
#include "quench/shape.h"
#include "quench/verify.h"

namespace quench::verification {

/// As a 32-bit integer; out of its range, or not a number, as -1 (no voxel is at negative coordinates).
inline std::int32_t bounded(double value) {
  return value >= -0x1p30 && value <= 0x1p30 ? static_cast<std::int32_t>(value) : -1;
}

/// A result file read as a complex with measures. Arrays that the file does not have are empty.
struct Result {
  Result(const VoxelShape& voxels, const Record& file, const VerifyOptions& options);

  const VoxelShape& shape;
  const Record& data;
  CellComplex complex;
  std::vector<std::uint32_t> rows;        ///< per vertex: its point in the file (points used by no cell are left out)
  std::vector<std::uint32_t> line_edges;  ///< per line of the file: its edge
  std::vector<std::uint32_t> vert_vertices;  ///< per vertex cell of the file: its vertex

  std::array<std::int64_t, 3> scale{1, 1, 1};  ///< integer_spacing
  double unit = 1;                             ///< world length of one scaled unit
  double slack = 0;                            ///< relative error of the integer spacing, and so of every length
  /// Largest error of a scaled coordinate that comes from the coordinates of the file being doubles: much, in voxels,
  /// for a small shape far from the origin.
  double rounding = 0;
  /// Vertices of the voxel core (where the file has its geometry) in lattice coordinates, and these times `scale`.
  std::vector<Vec3> lattice, scaled;

  /// Whether the points and radii of the file are fitted to a surface, `surface`: "mesh", "grey" or "smooth". What they
  /// were in the voxel core then stands in arrays of its own; a skeleton has none.
  bool fitted = false, has_voxel_geometry = true;
  std::string surface;
  std::vector<double> radius;       ///< of the voxel core, where the file has its geometry, else as `ball_radius`
  std::vector<double> ball_radius;  ///< the array `radius`, of point()
  std::vector<double> vertex_lambda;
  std::vector<double> cell_lambda;                      ///< rows of the file: verts, lines, polys
  std::vector<std::array<LatticePoint, 2>> face_sites;  ///< as the file says
  std::vector<std::array<LatticePoint, 2>> line_sites;  ///< the same in the plane, per line of the file
  std::vector<std::uint32_t> edge_faces_count;          ///< polygons at each edge
  base::Csr<std::uint32_t> vertex_edges, vertex_faces;  ///< edges and polygons at each vertex

  std::vector<std::string> measures;  ///< names; of a file that does not say: lambda
  std::string stage;                  ///< empty: none given
  bool plane = false;                 ///< of a shape of the plane: points and lines only
  bool main_axes = false;             ///< a skeleton of one course per component, not all of the shape's topology
  bool ball_rule = false;
  double lambda = 0;
  bool lambda_given = false;
  bool lambda_of_file = false;  ///< it is that of the file
  bool by_detail = false;       ///< pruned by detail, not by lambda or another measure
  double detail = 0;            ///< where it was; world units, may be infinite
  bool detail_of_file = false;  ///< it is that of the file
  std::string by;               ///< of a core pruned by a measure other than these two: its name
  double by_threshold = 0;      ///< where it was; may be infinite
  double auto_detail = 0;       ///< half the diagonal of a voxel or pixel, world units

  std::string_view pruned_by() const { return !by.empty() ? by : by_detail ? kDetail : kLambda; }  ///< of a core
  const Vec3& point(std::uint32_t vertex) const { return data.points[rows[vertex]]; }
  Vec3 voxel_point(std::uint32_t vertex) const;   ///< of the voxel core, world coordinates
  Vec3 scaled_point(std::uint32_t vertex) const;  ///< point(), scaled
  std::string describe_vertex(std::uint32_t vertex) const;
  std::string describe_edge(std::uint32_t edge) const;
  std::string describe_face(std::size_t face) const;
  /// Per edge the largest of the numbers of its polygons, 0 where it has none; `of_cells` as in the file.
  std::vector<double> largest_of_polygons(const std::vector<double>& of_cells) const;
  std::size_t first_polygon() const { return data.verts.size() + data.lines.size(); }  ///< row of cell arrays
  Vec3 centroid(std::size_t face) const;                                               ///< of the corners, scaled

 private:
  const DataArray* voxel_points_ = nullptr;
  void parse_cells();
  void parse_surface();
  void parse_arrays(const VerifyOptions& options);
  void recover_lattice();
  void invert_incidences();
};

/// Whether it is one of those that Quench writes into files of cores.
bool is_measure_of_cores(std::string_view name);
/// Whether every file of a core has arrays of it.
bool is_in_every_file(const MeasureKind& measure, bool plane);

/// False for an array of strings.
bool has_numbers(const DataArray& array);
/// The numbers of an array of one number per row; empty when there is none of that name.
std::vector<double> numbers_or_empty(const std::vector<DataArray>& arrays, std::string_view name);
/// The first string of an array; empty when there is none of that name.
std::string text_or_empty(const std::vector<DataArray>& arrays, std::string_view name);

/// All texts of an array; empty when there is none of that name or it holds numbers.
std::vector<std::string> texts_or_empty(const std::vector<DataArray>& arrays, std::string_view name);

/// The cofaces of a cell that are left; when only one is, the sum of their indices is its index.
struct Cofaces {
  std::uint32_t count = 0;
  std::uint64_t sum = 0;
  void add(std::uint32_t i) { ++count, sum += i; }
  void remove(std::uint32_t i) { --count, sum -= i; }
  std::uint32_t only() const { return static_cast<std::uint32_t>(sum); }
};

/// At most `limit` indices below `count`, taken evenly.
std::vector<std::uint32_t> sample(std::size_t count, std::size_t limit);

/// The smallest index below `count` for which `holds` is false, or `count`. In parallel; `holds` must be thread-safe.
template <class Holds>
std::size_t first_failure(std::size_t count, Context* context, std::string_view stage, const Holds& holds) {
  constexpr std::size_t kBlock = 1 << 15;
  for (std::size_t begin = 0; begin < count; begin += kBlock) {
    checkpoint(context, stage, static_cast<double>(begin) / static_cast<double>(count));
    const std::size_t end = std::min(count, begin + kBlock);
    std::atomic<std::size_t> first{end};
    tbb::parallel_for(begin, end, [&](std::size_t i) {
      if (i >= first.load(std::memory_order_relaxed) || holds(i)) return;
      std::size_t known = first.load();
      while (i < known && !first.compare_exchange_weak(known, i)) {
      }
    });
    if (first.load() != end) return first.load();
  }
  return count;
}

/// Calls body(i) for every index below `count`, in parallel.
template <class Body>
void for_indices(std::size_t count, Context* context, std::string_view stage, const Body& body) {
  first_failure(count, context, stage, [&](std::size_t i) {
    body(i);
    return true;
  });
}

/// What a cell of the grid is called.
inline const char* pixel_or_voxel(const Result& result) { return result.plane ? "pixel" : "voxel"; }

inline Check not_checked(std::string name, const std::string& why) {
  return {std::move(name), true, "not checked: " + why, {}};
}
/// Notes that a check covers an array.
void cover(Check& check, std::string_view array);
inline Check failed(std::string name, std::string counterexample) {
  return {std::move(name), false, std::move(counterexample), {}};
}

}  // namespace quench::verification
