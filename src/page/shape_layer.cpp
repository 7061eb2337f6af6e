// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <random>

#include "page/layer.h"
#include "quench/error.h"

namespace quench {
namespace {

/// The values of an array of the page, which is made where there is none.
template <class T>
std::vector<T>& values_of(Page& page, const char* name, int components) {
  for (PageArray& array : page.arrays)
    if (array.name == name) return std::get<std::vector<T>>(array.values);
  page.arrays.push_back({name, components, std::vector<T>()});
  return std::get<std::vector<T>>(page.arrays.back().values);
}

/// Counts a surface. Where some are simplified, one note says so of all.
void note_surface(Page& page, const char* what, std::size_t given, std::size_t drawn) {
  PageSurfaces& all = page.surfaces;
  ++all.count;
  all.given += given;
  all.drawn += drawn;
  if (drawn < given && !all.note) {
    all.note = page.notes.size();
    page.notes.emplace_back();
  }
  if (all.note)
    page.notes[*all.note] =
        fmt::format("{} {} triangles; the page draws {}, with vertices close to each other merged{}",
                    all.count == 1 ? fmt::format("The {} has", what)
                                   : fmt::format("The {} shapes have", page::count_text(all.count)),
                    page::count_text(all.given), page::count_text(all.drawn), page::limit_text(page));
}

/// `finest`: as of clustered().
std::size_t add_triangles(Page& page, const Record& surface, const char* what, std::size_t max_triangles,
                          double finest = 0) {
  const std::size_t given = page::triangle_count(surface);
  Record fewer;
  if (given > max_triangles) {
    std::vector<std::uint32_t> ignored;
    fewer = page::clustered(surface, max_triangles, ignored, finest);
  }
  const Record& drawn = given > max_triangles ? fewer : surface;
  note_surface(page, what, given, page::triangle_count(drawn));
  auto& places = values_of<float>(page, "shape/points", 3);
  const std::size_t before = places.size() / 3;
  std::vector<std::uint32_t> number(drawn.points.size(), kNone), corners;
  std::vector<Vec3> shown;
  for (const std::uint32_t v : drawn.poly_corners) {
    if (number[v] == kNone) {
      number[v] = static_cast<std::uint32_t>(before + shown.size());
      shown.push_back(drawn.points[v]);
      for (int a = 0; a < 3; ++a) places.push_back(static_cast<float>(drawn.points[v][a] - page.origin[a]));
    }
    corners.push_back(number[v]);
  }
  page::widen(page, shown);
  auto& triangles = values_of<std::uint32_t>(page, "shape/triangles", 3);
  triangles.insert(triangles.end(), corners.begin(), corners.end());
  return page::triangle_count(drawn);
}

/// Rows of the boundary vertices by their coordinates.
class Corners {
 public:
  explicit Corners(const VoxelShape& shape) : sites_(boundary_vertices(shape)) {}
  const std::vector<LatticePoint>& sites() const { return sites_; }
  std::uint32_t at(const LatticePoint& p) const {
    const auto before = [](const LatticePoint& a, const LatticePoint& b) {
      return std::array{a[2], a[1], a[0]} < std::array{b[2], b[1], b[0]};
    };
    return static_cast<std::uint32_t>(std::lower_bound(sites_.begin(), sites_.end(), p, before) - sites_.begin());
  }

 private:
  std::vector<LatticePoint> sites_;
};

/// Triangles between two rows of corners, both from left to right with the same ends: `above` has the smaller y.
void add_strip(const std::vector<std::uint32_t>& above, const std::vector<std::uint32_t>& below,
               const std::vector<LatticePoint>& places, TriangleMesh& mesh) {
  std::size_t a = 0, b = 0;
  while (a + 1 < above.size() || b + 1 < below.size()) {
    const bool step_above =
        b + 1 == below.size() || (a + 1 < above.size() && places[above[a + 1]][0] <= places[below[b + 1]][0]);
    mesh.triangles.push_back({above[a], step_above ? above[a + 1] : below[b + 1], below[b]});
    step_above ? ++a : ++b;
  }
}

/// The faces between a voxel of the shape and one that is not, corners counterclockwise from outside.
std::vector<std::array<std::uint32_t, 4>> boundary_quads(const VoxelShape& shape, const Corners& corners) {
  std::vector<std::array<std::uint32_t, 4>> quads;
  // Of voxel p, the face across `axis`, on the far side or the near one.
  const auto add = [&](LatticePoint p, int axis, bool far) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    p[axis] += far;
    std::array<LatticePoint, 4> c{p, p, p, p};
    ++c[1][u];
    ++c[2][u];
    ++c[2][v];
    ++c[3][v];
    if (!far) std::swap(c[1], c[3]);
    quads.push_back({corners.at(c[0]), corners.at(c[1]), corners.at(c[2]), corners.at(c[3])});
  };
  const auto& dims = shape.grid().dims;
  for (std::int32_t z = 0; z < dims[2]; ++z)
    for (std::int32_t y = 0; y < dims[1]; ++y)
      for (const Run& run : shape.row(y, z)) {
        add({run.begin, y, z}, 0, false);
        add({run.end - 1, y, z}, 0, true);
        for (const int axis : {1, 2})
          for (const bool far : {false, true}) {
            const std::int64_t ny = y + (axis == 1 ? (far ? 1 : -1) : 0), nz = z + (axis == 2 ? (far ? 1 : -1) : 0);
            std::int32_t x = run.begin;
            for (const Run& other : shape.row(ny, nz)) {
              for (; x < std::min(other.begin, run.end); ++x) add({x, y, z}, axis, far);
              x = std::max(x, std::min(other.end, run.end));
            }
            for (; x < run.end; ++x) add({x, y, z}, axis, far);
          }
      }
  return quads;
}

}  // namespace

TriangleMesh smoothed_boundary(const VoxelShape& shape, int iterations) {
  if (shape.grid().is_plane()) throw Error(ErrorCode::usage, "a shape of the plane has no surface");
  const Corners corners(shape);
  const std::vector<std::array<std::uint32_t, 4>> quads = boundary_quads(shape, corners);
  const Grid& grid = shape.grid();
  std::vector<Vec3> start, sum;
  for (const LatticePoint& p : corners.sites()) start.emplace_back(p[0], p[1], p[2]);
  std::vector<Vec3> place = start;
  std::vector<double> neighbours(start.size());
  // Each corner moves to the mean of its neighbours, in lattice coordinates, by at most half a voxel per axis.
  for (int i = 0; i < iterations; ++i) {
    sum.assign(place.size(), Vec3::Zero());
    std::fill(neighbours.begin(), neighbours.end(), 0);
    for (const auto& q : quads)
      for (std::size_t c = 0; c < 4; ++c) {
        sum[q[c]] += place[q[(c + 1) % 4]] + place[q[(c + 3) % 4]];
        neighbours[q[c]] += 2;
      }
    for (std::size_t v = 0; v < place.size(); ++v)
      if (neighbours[v] > 0)
        place[v] =
            (sum[v] / neighbours[v]).cwiseMax(start[v] - Vec3::Constant(0.5)).cwiseMin(start[v] + Vec3::Constant(0.5));
  }
  TriangleMesh mesh;
  for (const Vec3& p : place) mesh.points.push_back(grid.world(p));
  const bool reflected = grid.direction.determinant() < 0;
  for (auto q : quads) {
    if (reflected) std::swap(q[1], q[3]);
    mesh.triangles.push_back({q[0], q[1], q[2]});
    mesh.triangles.push_back({q[0], q[2], q[3]});
  }
  return mesh;
}

TriangleMesh flat_pixels(const VoxelShape& shape) {
  const Corners corners(shape);
  TriangleMesh mesh;
  for (const LatticePoint& p : corners.sites()) mesh.points.push_back(shape.grid().world_of(p));
  // The corners on the line y from x = run.begin to run.end: the ends of the run, and those of `others`, the runs on
  // the other side of the line.
  const auto line = [&](const Run& run, std::span<const Run> others, std::int32_t y) {
    std::vector<std::uint32_t> row{corners.at({run.begin, y, 0})};
    auto other = std::lower_bound(others.begin(), others.end(), run.begin,
                                  [](const Run& r, std::int32_t x) { return r.end <= x; });
    for (; other != others.end() && other->begin < run.end; ++other)
      for (const std::int32_t x : {other->begin, other->end})
        if (x > run.begin && x < run.end) row.push_back(corners.at({x, y, 0}));
    row.push_back(corners.at({run.end, y, 0}));
    return row;
  };
  const auto has = [&](std::int32_t y, const Run& run) {
    const std::span<const Run> row = shape.row(y, 0);
    const auto at =
        std::lower_bound(row.begin(), row.end(), run.begin, [](const Run& r, std::int32_t x) { return r.begin < x; });
    return at != row.end() && *at == run;
  };
  // Equal runs below each other are one rectangle.
  for (std::int32_t y = 0; y < shape.grid().dims[1]; ++y)
    for (const Run& run : shape.row(y, 0)) {
      if (has(y - 1, run)) continue;
      std::int32_t end = y + 1;
      while (has(end, run)) ++end;
      add_strip(line(run, shape.row(y - 1, 0), y), line(run, shape.row(end, 0), end), corners.sites(), mesh);
    }
  return mesh;
}

std::size_t add_surface(Page& page, const TriangleMesh& mesh, std::size_t max_triangles) {
  return add_triangles(page, to_record(mesh), "surface of the shape", max_triangles);
}

std::size_t add_surface(Page& page, const VoxelShape& shape, std::size_t max_triangles) {
  if (shape.grid().is_plane())  // its triangles are narrow: their area says nothing
    return add_triangles(page, to_record(flat_pixels(shape)), "shape", max_triangles, shape.grid().spacing.maxCoeff());
  page.voxel_surface = true;
  page.notes.emplace_back("The surface drawn is that of the voxels, smoothed by at most half a voxel");
  return add_triangles(page, to_record(smoothed_boundary(shape, 4)), "surface of the voxels", max_triangles);
}

std::vector<Vec3> surface_points(const Page& page) {
  std::vector<Vec3> points;
  const PageArray* const array = page.find("shape/points");
  if (!array) return points;
  const auto& places = std::get<std::vector<float>>(array->values);
  for (std::size_t i = 0; i + 2 < places.size(); i += 3)
    points.push_back(page.origin + Vec3(places[i], places[i + 1], places[i + 2]));
  return points;
}

void add_surface_measure(Page& page, const std::string& name, const std::vector<double>& values) {
  const PageArray* const points = page.find("shape/points");
  const std::size_t count = points ? std::get<std::vector<float>>(points->values).size() / 3 : 0;
  if (values.size() != count)
    throw Error(ErrorCode::usage, fmt::format("the measure '{}' of the surface of a page has {} values for {} points",
                                              name, values.size(), count));
  std::vector<float> rounded(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) rounded[i] = page::measure_of(values[i]);
  page.arrays.push_back({"shape/point/" + name, 1, std::move(rounded)});
}

void add_sites(Page& page, const VoxelShape& shape) {
  constexpr std::int64_t kMost = 4'000'000;
  const Grid& grid = shape.grid();
  const std::int64_t count = count_boundary_vertices(shape);
  if (count > kMost || std::max({grid.dims[0], grid.dims[1], grid.dims[2]}) > 65535) {
    page.notes.push_back(
        fmt::format("The shape has {} boundary vertices, too many for a page: where {} touch the "
                    "boundary is not shown",
                    page::count_text(static_cast<std::size_t>(count)), grid.is_plane() ? "disks" : "balls"));
    return;
  }
  std::vector<std::uint16_t> sites;
  sites.reserve(static_cast<std::size_t>(count) * 3);
  for (const LatticePoint& p : boundary_vertices(shape))
    for (const std::int32_t x : p) sites.push_back(static_cast<std::uint16_t>(x));
  page.arrays.push_back({"shape/sites", 3, std::move(sites)});
  const Vec3 zero = grid.world(Vec3::Zero());
  std::array<double, 12> rows{};
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) rows[static_cast<std::size_t>(4 * r + c)] = grid.world(Vec3::Unit(c))[r] - zero[r];
    rows[static_cast<std::size_t>(4 * r + 3)] = zero[r];
  }
  page.sites_to_world = rows;
}

void add_samples(Page& page, const VoxelShape& shape, std::size_t count) {
  const std::int64_t voxels = shape.voxel_count();
  if (voxels == 0) return;
  std::mt19937_64 random(20180501);
  const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  std::vector<float> places;
  places.reserve(count * 3);
  // The i-th place is in the i-th of `count` equal shares of the voxels, which are in scanline order.
  std::size_t next = 0;
  std::int64_t passed = 0;
  double target = unit() * static_cast<double>(voxels) / static_cast<double>(count);
  const auto& dims = shape.grid().dims;
  for (std::int64_t z = 0; z < dims[2]; ++z)
    for (std::int64_t y = 0; y < dims[1]; ++y)
      for (const Run& run : shape.row(y, z)) {
        const std::int64_t length = run.end - run.begin;
        while (next < count && target < static_cast<double>(passed + length)) {
          const double x = run.begin + (target - static_cast<double>(passed));
          const double dy = unit(), dz = shape.grid().is_plane() ? 0 : unit();
          const Vec3 world = shape.grid().world({x, static_cast<double>(y) + dy, static_cast<double>(z) + dz});
          for (int a = 0; a < 3; ++a) places.push_back(static_cast<float>(world[a] - page.origin[a]));
          ++next;
          target = (static_cast<double>(next) + unit()) * static_cast<double>(voxels) / static_cast<double>(count);
        }
        passed += length;
      }
  page.arrays.push_back({"shape/samples", 3, std::move(places)});
}

}  // namespace quench
