// SPDX-License-Identifier: Apache-2.0
// The core of pixel shapes on one thread, from the shape to centres and measures: CPU seconds and growth of the peak of
// memory per site, one child process each; beside it Boost.Polygon's Voronoi diagram of the same sites, where its
// headers were found. Shapes: thresholded noise with about a site per 67 pixels (8192^2: a million), and a disc.
//   bench_plane [noise|disc]:SIZE...
#include <fmt/format.h>
#include <sys/wait.h>
#include <tbb/global_control.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#if __has_include(<boost/polygon/voronoi.hpp>)
#include <boost/polygon/voronoi.hpp>
#define QUENCH_BENCH_BOOST
#endif

#include "axis/mgf.h"
#include "dual/plane/dual_of_plane.h"
#include "measure.h"
#include "quench/axis.h"
#include "quench/shape.h"

namespace {

using quench::LatticePoint;
using quench::VoxelShape;

template <class Inside>
VoxelShape square_image(std::int64_t size, const Inside& inside) {
  quench::Grid grid;
  grid.dims = {size, size, 1};
  grid.make_plane();
  VoxelShape shape(grid);
  std::vector<quench::Run> runs;
  for (std::int32_t y = 0; y < size; ++y) {
    runs.clear();
    for (std::int32_t x = 0; x < size; ++x) {
      if (!inside(x, y)) continue;
      if (!runs.empty() && runs.back().end == x)
        ++runs.back().end;
      else
        runs.push_back({x, x + 1});
    }
    shape.append_row(runs);
  }
  return shape;
}

// Random values at every 69th pixel, interpolated by cubic weights.
VoxelShape noise(std::int64_t size) {
  constexpr int kStep = 69;
  const auto value = [](std::uint64_t i, std::uint64_t j) {
    std::uint64_t x = i * 0x9E3779B97F4A7C15ull + j * 0xD1B54A32D192ED03ull + 1;
    x = (x ^ x >> 30) * 0xBF58476D1CE4E5B9ull;
    x = (x ^ x >> 27) * 0x94D049BB133111EBull;
    return static_cast<double>((x ^ x >> 31) >> 11) * 0x1p-53;
  };
  const auto weight = [](int place) {
    const double t = (place % kStep + 0.5) / kStep;
    return t * t * (3 - 2 * t);
  };
  return square_image(size, [&](int x, int y) {
    const auto i = static_cast<std::uint64_t>(x / kStep), j = static_cast<std::uint64_t>(y / kStep);
    const double u = weight(x), v = weight(y);
    return (1 - v) * ((1 - u) * value(i, j) + u * value(i + 1, j)) +
               v * ((1 - u) * value(i, j + 1) + u * value(i + 1, j + 1)) >
           0.5;
  });
}

VoxelShape disc(std::int64_t size) {
  const double middle = 0.5 * static_cast<double>(size), squared = middle * middle;
  return square_image(size, [&](int x, int y) {
    const double dx = x + 0.5 - middle, dy = y + 0.5 - middle;
    return dx * dx + dy * dy < squared;
  });
}

// CPU seconds and growth of the peak of memory since construction.
class Cost {
 public:
  double seconds() const { return cpu_seconds() - start_; }
  double bytes() const { return peak_bytes() - before_; }

 private:
  double before_ = peak_bytes(), start_ = cpu_seconds();
};

// Returns the seconds.
double print(const char* what, const Cost& cost, std::size_t sites) {
  const double seconds = cost.seconds(), count = static_cast<double>(sites);
  fmt::print("  {:<16} {:7.3f} s {:6.3f} us/site {:5.0f} bytes/site", what, seconds, 1e6 * seconds / count,
             cost.bytes() / count);
  std::fflush(stdout);
  return seconds;
}

// Runs `work` in a child, so that peaks of memory are its own; returns the seconds that it returns there.
template <class Work>
double in_child(const Work& work) {
  int ends[2];
  if (pipe(ends) != 0) std::exit(1);
  const pid_t child = fork();
  if (child == 0) {
    const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
    const double seconds = work();
    std::fflush(stdout);
    std::_Exit(write(ends[1], &seconds, sizeof seconds) == sizeof seconds ? 0 : 1);
  }
  int status = 0;
  waitpid(child, &status, 0);
  double seconds = 0;
  if (status != 0 || read(ends[0], &seconds, sizeof seconds) != sizeof seconds) std::exit(1);
  close(ends[0]);
  close(ends[1]);
  return seconds;
}

void measure(const VoxelShape& shape) {
  const auto sites = quench::boundary_vertices(shape);
  fmt::print("{} sites, {} runs\n", sites.size(), shape.runs().size());
  std::fflush(stdout);
  [[maybe_unused]] const double complex = in_child([&] {
    const Cost cost;
    const auto dual = quench::dual::plane::dual_complex(shape, sites, quench::integer_spacing(shape.grid()), nullptr);
    const double seconds = print("dual complex", cost, sites.size());
    fmt::print("  {} vertices, {} edges\n", dual.complex.vertex_count, dual.complex.edges.size());
    const Cost cost_of_mgf;
    const auto mgf = quench::axis::mgf_of_edges(shape, sites, dual.edge_sites);
    print("its mgf", cost_of_mgf, sites.size());
    fmt::print("\n");
    return seconds;
  });
  [[maybe_unused]] const double core = in_child([&] {
    const Cost cost;
    const quench::MedialAxis axis = quench::voxel_core(shape);
    const double seconds = print("core", cost, axis.sites.size());
    fmt::print("\n");
    return seconds;
  });
#ifdef QUENCH_BENCH_BOOST
  in_child([&] {
    const Cost cost;
    boost::polygon::voronoi_builder<std::int32_t> builder;
    for (const LatticePoint& s : sites) builder.insert_point(s[0], s[1]);
    boost::polygon::voronoi_diagram<double> diagram;
    builder.construct(&diagram);
    const double seconds = print("Boost.Polygon", cost, sites.size());
    fmt::print("  {} vertices; {:.1f} x the dual complex, {:.1f} x the core\n", diagram.num_vertices(),
               seconds / complex, seconds / core);
    return seconds;
  });
#endif
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::string> shapes(argv + 1, argv + argc);
  if (shapes.empty())
    shapes = {"noise:1024", "noise:2048", "noise:4096", "noise:8192", "noise:16384", "disc:8192", "disc:16384"};
  for (const std::string& name : shapes) {
    const std::size_t colon = name.find(':');
    const std::int64_t size = colon == std::string::npos ? 0 : std::atoll(name.c_str() + colon + 1);
    if (size < 1 || (name[0] != 'n' && name[0] != 'd')) {
      fmt::print(stderr, "usage: bench_plane [noise:SIZE | disc:SIZE]...\n");
      return 2;
    }
    fmt::print("{}: ", name);
    measure(name[0] == 'n' ? noise(size) : disc(size));
  }
  return 0;
}
