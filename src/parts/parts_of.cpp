// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/csr.h"
#include "base/parallel.h"
#include "base/union_find.h"
#include "parts/cut_sheets.h"
#include "parts/triangulation.h"
#include "quench/error.h"
#include "quench/parts.h"

namespace quench {
namespace {

using parts::CutSheets;
using parts::TriangleSide;
using parts::Triangulation;

constexpr double kNever = std::numeric_limits<double>::infinity();

void sort_unique(std::vector<std::uint32_t>& list) {
  std::ranges::sort(list);
  list.erase(std::unique(list.begin(), list.end()), list.end());
}

class PartsMeasurer {
 public:
  PartsMeasurer(const CellComplex& complex, std::span<const Vec3> points, std::span<const double> radius,
                std::span<const double> erosion, const PartsOptions& options, Context* context)
      : complex_(complex), erosion_(erosion), context_(context) {
    parts_.structure = structure_of(complex);
    triangles_ = parts::triangulated(complex, points);
    points_.assign(points.begin(), points.end());
    for (const double r : radius) thickness_.push_back(2 * (r + options.more_radius));
    for (const std::uint32_t f : triangles_.middle_of) {
      const auto corners = complex.corners(f);
      Vec3 point = Vec3::Zero();
      double thickness = 0;
      for (const std::uint32_t v : corners) {
        point += points[v] / static_cast<double>(corners.size());
        thickness += thickness_[v] / static_cast<double>(corners.size());
      }
      points_.push_back(point);
      thickness_.push_back(thickness);
    }
    checkpoint(context, "parts", 0.3);
  }

  Parts run() {
    parts_.sheets.resize(parts_.structure.sheets);
    parts_.seams.resize(parts_.structure.seams);
    triangles_of_ = base::Csr<std::uint32_t>::group(parts_.sheets.size(), [&](const auto& emit) {
      for (std::uint32_t t = 0; t < triangles_.triangles.size(); ++t) emit(sheet_of(t), t);
    });
    tbb::parallel_for(std::size_t{0}, parts_.sheets.size(), [&](std::size_t s) { measure(s); });
    count_faces();
    checkpoint(context_, "parts", 0.5);
    measure_borders();
    checkpoint(context_, "parts", 0.8);
    measure_seams();
    find_junctions();
    find_neighbours();
    checkpoint(context_, "parts", 1);
    return std::move(parts_);
  }

 private:
  std::size_t sheet_of(std::uint32_t triangle) const {
    return static_cast<std::size_t>(parts_.structure.face_sheet[triangles_.face[triangle]]);
  }
  double length_of(std::uint32_t edge) const {
    const auto& [a, b] = complex_.edges[edge];
    return (points_[b] - points_[a]).norm();
  }

  // The moments of linear functions over triangles are known exactly.
  void measure(std::size_t s) {
    Sheet& sheet = parts_.sheets[s];
    sheet.min_thickness = kNever;
    const auto rows = triangles_of_[s];
    const Vec3 origin = points_[triangles_.triangles[rows[0]][0]];
    Vec3 first = Vec3::Zero();
    Mat3 second = Mat3::Zero();
    double thickness = 0, erosion = 0;
    for (const std::uint32_t t : rows) {
      const auto& corners = triangles_.triangles[t];
      const Vec3 a = points_[corners[0]] - origin, b = points_[corners[1]] - origin, c = points_[corners[2]] - origin,
                 sum = a + b + c;
      const double area = 0.5 * (b - a).cross(c - a).norm();
      sheet.area += area;
      first += area / 3 * sum;
      second += area / 12 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
      for (const std::uint32_t v : corners) {
        thickness += area / 3 * thickness_[v];
        sheet.min_thickness = std::min(sheet.min_thickness, thickness_[v]);
        sheet.max_thickness = std::max(sheet.max_thickness, thickness_[v]);
      }
      if (erosion_.empty()) continue;
      const double value = erosion_[triangles_.face[t]];
      if (area > 0) erosion += area * value;
      sheet.max_erosion = std::isnan(sheet.max_erosion) ? value : std::max(sheet.max_erosion, value);
    }
    if (!(sheet.area > 0)) {  // a sheet of no area has the values of its first corner
      sheet.mean_thickness = thickness_[triangles_.triangles[rows[0]][0]];
      if (!erosion_.empty()) sheet.mean_erosion = sheet.max_erosion;
      sheet.centre = origin;
      return;
    }
    sheet.mean_thickness = std::clamp(thickness / sheet.area, sheet.min_thickness, sheet.max_thickness);
    if (!erosion_.empty()) sheet.mean_erosion = std::min(erosion / sheet.area, sheet.max_erosion);
    const Vec3 centre = first / sheet.area;
    sheet.centre = origin + centre;
    const Eigen::SelfAdjointEigenSolver<Mat3> solver(second / sheet.area - centre * centre.transpose());
    sheet.normal = solver.eigenvectors().col(0);
    int largest = 0;
    sheet.normal.cwiseAbs().maxCoeff(&largest);
    if (sheet.normal[largest] < 0) sheet.normal = -sheet.normal;
    sheet.flatness = std::sqrt(std::max(0.0, solver.eigenvalues()[0]));
    for (const std::uint32_t t : rows)
      for (const std::uint32_t v : triangles_.triangles[t])
        sheet.largest_off = std::max(sheet.largest_off, std::abs(sheet.normal.dot(points_[v] - sheet.centre)));
    sheet.flatness = std::min(sheet.flatness, sheet.largest_off);
  }

  void count_faces() {
    base::UnionFind sets(complex_.vertex_count);
    for (const auto& [a, b] : complex_.edges) sets.unite(a, b);
    std::vector<std::int32_t> component(complex_.vertex_count);
    std::int32_t components = 0;
    for (std::uint32_t v = 0; v < complex_.vertex_count; ++v)
      component[v] = sets.find(v) == v ? components++ : component[sets.find(v)];
    for (std::size_t f = 0; f < complex_.face_count(); ++f) {
      Sheet& sheet = parts_.sheets[static_cast<std::size_t>(parts_.structure.face_sheet[f])];
      ++sheet.faces;
      sheet.component = component[complex_.corners(f)[0]];
    }
  }

  // Of the sheets cut off: Euler characteristic, borders, orientation, lengths.
  void measure_borders() {
    const std::vector<TriangleSide> sides = parts::sorted_sides(triangles_.triangles);
    const CutSheets cut = parts::cut_sheets(triangles_.triangles, sides);
    base::UnionFind along(cut.vertices);
    std::vector<char> at_border(cut.vertices, 0);
    for (std::uint32_t v = 0; v < cut.vertices; ++v) ++parts_.sheets[sheet_of(cut.corner_of[v] / 3)].euler;
    for (std::uint32_t t = 0; t < triangles_.triangles.size(); ++t) {
      Sheet& sheet = parts_.sheets[sheet_of(t)];
      ++sheet.euler;
      if (cut.inconsistent[t]) sheet.orientable = false;
    }
    parts::each_edge(sides, [&](std::span<const TriangleSide> at) {
      if (at.size() == 2) {
        --parts_.sheets[sheet_of(at[0].triangle)].euler;
        return;
      }
      for (const TriangleSide& side : at) {
        Sheet& sheet = parts_.sheets[sheet_of(side.triangle)];
        --sheet.euler;
        const std::uint32_t a = cut.vertex[3 * side.triangle + side.side],
                            b = cut.vertex[3 * side.triangle + (side.side + 1) % 3];
        along.unite(a, b);
        at_border[a] = at_border[b] = 1;
        const double length = (points_[side.b] - points_[side.a]).norm();
        (at.size() == 1 ? sheet.rim_length : sheet.seam_length) += length;
      }
    });
    for (std::uint32_t v = 0; v < cut.vertices; ++v)
      if (at_border[v] && along.find(v) == v) ++parts_.sheets[sheet_of(cut.corner_of[v] / 3)].borders;
  }

  void measure_seams() {
    faces_at_ = base::Csr<std::uint32_t>::group(complex_.edges.size(), [&](const auto& emit) {
      for (std::uint32_t f = 0; f < complex_.face_count(); ++f)
        for (const std::uint32_t e : complex_.sides(f))
          if (parts_.structure.edge_seam[e] >= 0) emit(e, f);
    });
    std::vector<double> sum(parts_.seams.size(), 0);
    for (Seam& seam : parts_.seams) seam.min_thickness = kNever, seam.closed = true;
    for (std::uint32_t e = 0; e < complex_.edges.size(); ++e) {
      const std::int32_t s = parts_.structure.edge_seam[e];
      if (s < 0) continue;
      Seam& seam = parts_.seams[static_cast<std::size_t>(s)];
      const double length = length_of(e);
      ++seam.edges;
      seam.length += length;
      for (const std::uint32_t v : complex_.edges[e]) {
        sum[static_cast<std::size_t>(s)] += 0.5 * length * thickness_[v];
        seam.min_thickness = std::min(seam.min_thickness, thickness_[v]);
        seam.max_thickness = std::max(seam.max_thickness, thickness_[v]);
        if (parts_.structure.junction[v]) seam.closed = false;
      }
      take_sheets(seam, e);
    }
    for (std::size_t s = 0; s < parts_.seams.size(); ++s) {
      Seam& seam = parts_.seams[s];
      seam.mean_thickness = seam.length > 0 ? std::clamp(sum[s] / seam.length, seam.min_thickness, seam.max_thickness)
                                            : seam.min_thickness;
    }
  }
  // Each sheet as often as it is at the edge that has it most.
  void take_sheets(Seam& seam, std::uint32_t e) {
    at_edge_.clear();
    for (const std::uint32_t f : faces_at_[e])
      at_edge_.push_back(static_cast<std::uint32_t>(parts_.structure.face_sheet[f]));
    std::ranges::sort(at_edge_);
    if (at_edge_ != last_) {
      for (std::size_t i = 0; i < at_edge_.size(); ++i)
        for (std::size_t j = 0; j < at_edge_.size(); ++j)
          if (j != i) parts_.sheets[at_edge_[i]].neighbours.push_back(at_edge_[j]);
      last_ = at_edge_;
    }
    if (at_edge_ == seam.sheets) return;
    merged_.clear();
    std::ranges::set_union(seam.sheets, at_edge_, std::back_inserter(merged_));
    seam.sheets = merged_;
  }

  void find_junctions() {
    std::vector<std::uint32_t> row(complex_.vertex_count, kNone);
    for (std::uint32_t v = 0; v < complex_.vertex_count; ++v) {
      if (!parts_.structure.junction[v]) continue;
      row[v] = static_cast<std::uint32_t>(parts_.junctions.size());
      parts_.junctions.push_back({v, points_[v], thickness_[v], {}, {}});
    }
    for (std::uint32_t e = 0; e < complex_.edges.size(); ++e) {
      const std::int32_t s = parts_.structure.edge_seam[e];
      if (s < 0) continue;
      Seam& seam = parts_.seams[static_cast<std::size_t>(s)];
      for (const std::uint32_t v : complex_.edges[e]) {
        if (row[v] == kNone) continue;
        parts_.junctions[row[v]].seams.push_back(static_cast<std::uint32_t>(s));
        seam.ends[seam.ends[0] != kNone] = row[v];
      }
    }
    for (std::size_t f = 0; f < complex_.face_count(); ++f)
      for (const std::uint32_t v : complex_.corners(f))
        if (row[v] != kNone)
          parts_.junctions[row[v]].sheets.push_back(static_cast<std::uint32_t>(parts_.structure.face_sheet[f]));
    for (Junction& junction : parts_.junctions) sort_unique(junction.seams), sort_unique(junction.sheets);
    for (Seam& seam : parts_.seams)
      if (seam.ends[1] < seam.ends[0]) std::swap(seam.ends[0], seam.ends[1]);
  }

  void find_neighbours() {
    for (std::uint32_t s = 0; s < parts_.seams.size(); ++s) {
      const std::vector<std::uint32_t>& meet = parts_.seams[s].sheets;
      for (const std::uint32_t sheet : meet) {
        std::vector<std::uint32_t>& seams = parts_.sheets[sheet].seams;
        if (seams.empty() || seams.back() != s) seams.push_back(s);
      }
    }
    for (Sheet& sheet : parts_.sheets) sort_unique(sheet.neighbours);
  }

  const CellComplex& complex_;
  std::span<const double> erosion_;
  Context* context_;
  Parts parts_;
  Triangulation triangles_;
  std::vector<Vec3> points_;       // and the middles of faces
  std::vector<double> thickness_;  // the same
  base::Csr<std::uint32_t> triangles_of_, faces_at_;
  std::vector<std::uint32_t> at_edge_, last_, merged_;
};

}  // namespace

std::vector<std::uint32_t> Parts::by_area() const {
  std::vector<std::uint32_t> order(sheets.size());
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::stable_sort(order, [&](std::uint32_t a, std::uint32_t b) { return sheets[a].area > sheets[b].area; });
  return order;
}

Parts parts_of(const CellComplex& complex, std::span<const Vec3> points, std::span<const double> radius,
               std::span<const double> erosion, const PartsOptions& options, Context* context) {
  if (points.size() != complex.vertex_count || radius.size() != complex.vertex_count)
    throw Error(ErrorCode::usage, "the parts of a complex need a point and a radius for each of its vertices");
  if (!erosion.empty() && erosion.size() != complex.face_count())
    throw Error(ErrorCode::usage, "the erosion thickness of parts is one for each face");
  return base::in_arena(context,
                        [&] { return PartsMeasurer(complex, points, radius, erosion, options, context).run(); });
}

Parts parts_of(const Skeleton& skeleton, const PartsOptions& options, Context* context) {
  return parts_of(skeleton.complex, skeleton.points, skeleton.radius, skeleton.face_thickness, options, context);
}

}  // namespace quench
