// SPDX-License-Identifier: Apache-2.0
// CPU time and memory per boundary vertex of a voxelized mesh: CGAL's Delaunay_triangulation_3 (EPICK, spatial sort,
// one thread), our lattice Delaunay, our whole voxel core. Each method runs in a child process of its own, several
// times, in turns; memory is the growth of the child's peak.
//   compare_delaunay MESH|SAMPLE [RESOLUTION [RUNS]]
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <fmt/format.h>
#include <malloc.h>
#include <sys/wait.h>
#include <tbb/global_control.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "../measure.h"
#include "delaunay/delaunay.h"
#include "quench/axis.h"
#include "quench/io.h"
#include "quench/samples.h"
#include "quench/voxelize.h"

namespace {

struct Cost {
  double microseconds = 0, bytes = 0;  // of all sites
  std::uint64_t cells = 0;             // tetrahedra, or vertices of the core: a sign that the work was done
};

Cost in_child(const std::function<std::uint64_t()>& method) {
  std::array<int, 2> ends{};
  if (pipe(ends.data()) != 0) throw std::runtime_error("no pipe");
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("no child process");
  if (child == 0) {
    int status = 1;
    try {
      // The peak of a fresh child is what it shares with its parent: the sites and the shape.
      const double bytes = peak_bytes(), seconds = cpu_seconds();
      Cost cost;
      cost.cells = method();
      cost.microseconds = 1e6 * (cpu_seconds() - seconds);
      cost.bytes = peak_bytes() - bytes;
      status = write(ends[1], &cost, sizeof cost) == static_cast<ssize_t>(sizeof cost) ? 0 : 1;
    } catch (const std::exception& e) {
      fmt::print(stderr, "{}\n", e.what());
    }
    _exit(status);
  }
  close(ends[1]);
  Cost cost;
  const ssize_t got = read(ends[0], &cost, sizeof cost);
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  if (got != static_cast<ssize_t>(sizeof cost) || status != 0) throw std::runtime_error("a method failed");
  return cost;
}

std::uint64_t run_cgal(const std::vector<quench::LatticePoint>& sites) {
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  std::vector<Kernel::Point_3> points;
  points.reserve(sites.size());
  for (const auto& p : sites) points.emplace_back(p[0], p[1], p[2]);
  const CGAL::Delaunay_triangulation_3<Kernel> triangulation(points.begin(), points.end());  // sorts by itself
  return triangulation.number_of_finite_cells();
}

std::uint64_t run_lattice(const std::vector<quench::LatticePoint>& sites, const quench::Grid& grid) {
  const quench::delaunay::Delaunay delaunay(sites, quench::integer_spacing(grid), nullptr);
  return static_cast<std::uint64_t>(
      std::count_if(delaunay.tetrahedra().begin(), delaunay.tetrahedra().end(),
                    [&](const auto& t) { return t.corner[0] != quench::delaunay::kNone && !delaunay.touches_box(t); }));
}

quench::TriangleMesh read(const std::string& name) {
  if (std::filesystem::exists(name)) return quench::to_triangle_mesh(quench::io::read_record(name));
  return quench::make_sample(name).mesh;
}

int compare(int argc, char** argv) {
  const std::int64_t resolution = argc > 2 ? std::atoll(argv[2]) : 256;
  const int runs = std::max(1, argc > 3 ? std::atoi(argv[3]) : 3);
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  const quench::VoxelShape shape = quench::voxelize(read(argv[1]), {.resolution = resolution}).shape;
  const std::vector<quench::LatticePoint> sites = quench::boundary_vertices(shape);

  struct Method {
    const char* name;
    std::function<std::uint64_t()> run;
    std::vector<Cost> costs;
  };
  std::array<Method, 3> methods{
      Method{"CGAL " CGAL_VERSION_STR " Delaunay", [&] { return run_cgal(sites); }, {}},
      Method{"lattice Delaunay", [&] { return run_lattice(sites, shape.grid()); }, {}},
      Method{"voxel core, whole", [&] { return quench::voxel_core(shape).complex.vertex_count; }, {}}};
  malloc_trim(0);  // else children would reuse, uncounted, what voxelize() has freed
  for (int r = 0; r < runs; ++r)
    for (Method& m : methods) m.costs.push_back(in_child(m.run));

  fmt::print("{} at {}: {} sites, one thread, CPU time, median of {}\n\n",
             std::filesystem::path(argv[1]).filename().string(), resolution, sites.size(), runs);
  fmt::print(
      "| method | us/site | bytes/site | time: CGAL / this | memory: CGAL / this | cells |\n"
      "|---|---|---|---|---|---|\n");
  const auto median = [&](const Method& m, double Cost::*what) {
    std::vector<double> values;
    for (const Cost& c : m.costs) values.push_back(c.*what);
    std::nth_element(values.begin(), values.begin() + runs / 2, values.end());
    return values[static_cast<std::size_t>(runs / 2)] / static_cast<double>(sites.size());
  };
  for (const Method& m : methods)
    fmt::print("| {} | {:.2f} | {:.0f} | {:.2f} | {:.2f} | {} |\n", m.name, median(m, &Cost::microseconds),
               median(m, &Cost::bytes), median(methods[0], &Cost::microseconds) / median(m, &Cost::microseconds),
               median(methods[0], &Cost::bytes) / median(m, &Cost::bytes), m.costs.front().cells);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr, "usage: compare_delaunay MESH|SAMPLE [RESOLUTION [RUNS]]\n");
    return 2;
  }
  try {
    return compare(argc, argv);
  } catch (const std::exception& e) {
    fmt::print(stderr, "compare_delaunay: {}\n", e.what());
    return 1;
  }
}
