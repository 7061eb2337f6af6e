// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "quench/geometry.h"

namespace quench {

/// Name of the measure that every voxel core has: of a face half the distance of its sites, in world units.
inline constexpr std::string_view kLambda = "lambda";
/// In the plane: of an edge the shorter way along the boundary between its two sites (the medial geodesic function of
/// Dey and Sun 2006), infinite where they lie on different curves of the boundary.
inline constexpr std::string_view kMgf = "mgf";
/// Names of the measures of the default pruning: what the shape loses where the axis ends at a cell, and the detail up
/// to which the cell is kept. See add_detail().
inline constexpr std::string_view kCapHeight = "cap_height", kDetail = "detail";

/// How an infinite level is written to files: colour ranges of viewers break on inf.
inline constexpr double kInfiniteLevelInFiles = 3.4e38;

/// The version of the arrays of files; files without the field array `format_version` are of version 1, whose only
/// measure with levels is lambda.
inline constexpr std::int64_t kFormatVersion = 2;

/// A named array of a file: `values.size()` is rows * components. Strings are allowed in field data only.
struct DataArray {
  using Values = std::variant<std::vector<double>, std::vector<float>, std::vector<std::int64_t>,
                              std::vector<std::int32_t>, std::vector<std::uint8_t>, std::vector<std::string>>;
  std::string name;
  int components = 1;
  Values values;

  std::size_t size() const {
    return std::visit([](const auto& v) { return v.size(); }, values);
  }
  /// The numbers as doubles; throws Error(input) for strings.
  std::vector<double> numbers() const;
};

/// What a surface or medial-axis file holds, before it is given a meaning: points, isolated points (`verts`), segments,
/// polygons, and named arrays. Mirrors VTK's PolyData: cell arrays have one row per cell in the order verts, lines,
/// polys.
struct Record {
  std::vector<Vec3> points;
  std::vector<std::uint32_t> verts;
  std::vector<std::array<std::uint32_t, 2>> lines;
  std::vector<std::uint32_t> poly_offsets{0};
  std::vector<std::uint32_t> poly_corners;
  std::vector<DataArray> point_data, cell_data, field_data;

  std::size_t poly_count() const { return poly_offsets.empty() ? 0 : poly_offsets.size() - 1; }
  std::size_t cell_count() const { return verts.size() + lines.size() + poly_count(); }
  /// Throws Error(invariant) naming the first relation that does not hold (index ranges, offsets, array lengths).
  void validate() const;
};

/// The array of that name, or null.
const DataArray* find_array(const std::vector<DataArray>& arrays, std::string_view name);

/// The polygons as triangle fans; isolated points and lines are left out.
TriangleMesh to_triangle_mesh(const Record& data);

/// The triangles as polygons, without arrays.
Record to_record(const TriangleMesh& mesh);

}  // namespace quench
