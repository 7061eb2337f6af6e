// SPDX-License-Identifier: Apache-2.0
// The dual complex of a mesh's boundary vertices at once and in bricks, in the same run: seconds (CPU time on one
// thread, wall time otherwise) and growth of the peak of memory per site, one child process each.
//   bench_bricks MESH RESOLUTION THREADS [SIZE:HALO,SIZE:HALO... | whole]...
#include <fmt/format.h>
#include <sys/wait.h>
#include <tbb/global_control.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <string>

#include "dual/bricks/rounds.h"
#include "dual/peel/peel.h"
#include "measure.h"
#include "quench/io.h"
#include "quench/voxelize.h"

namespace {

double seconds(bool cpu) { return cpu ? cpu_seconds() : wall_seconds(); }

quench::dual::bricks::BrickPlan parse(const std::string& text) {
  quench::dual::bricks::BrickPlan plan;
  plan.rounds.clear();
  for (const char* p = text.c_str(); *p;) {
    char* end = nullptr;
    const std::int64_t size = std::strtoll(p, &end, 10);
    const std::int64_t halo = std::strtoll(end + 1, &end, 10);
    plan.rounds.push_back({size, halo});
    p = *end == ',' ? end + 1 : end;
  }
  return plan;
}

void run(const quench::VoxelShape& shape, const std::string& plan, int threads) {
  using namespace quench;
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  const auto sites = boundary_vertices(shape);
  const auto spacing = integer_spacing(shape.grid());
  const double before = peak_bytes(), start = seconds(threads == 1);
  double last = start, divided = 0;
  Context context;
  context.progress = [&](std::string_view stage, double) {
    const double now = seconds(threads == 1);
    if (stage == "delaunay") divided += now - last;
    last = now;
  };
  const dual::DualComplex dual = plan == "whole"
                                     ? dual::peel::dual_complex(shape, sites, spacing, {}, &context)
                                     : dual::bricks::dual_complex(shape, sites, spacing, parse(plan), &context);
  const double spent = seconds(threads == 1) - start, count = static_cast<double>(sites.size());
  fmt::print(
      "{:<24} {:>9} sites {:8.2f} s {:6.2f} us/site ({:.2f} before merging)  {:5.0f} bytes/site  {} vertices, {} "
      "faces\n",
      plan, sites.size(), spent, 1e6 * spent / count, 1e6 * divided / count, (peak_bytes() - before) / count,
      dual.complex.vertex_count, dual.complex.face_count());
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 5) {
    fmt::print(stderr, "usage: bench_bricks MESH RESOLUTION THREADS [SIZE:HALO,... | whole]...\n");
    return 2;
  }
  for (int i = 4; i < argc; ++i) {
    const pid_t child = fork();
    if (child == 0) {
      const quench::TriangleMesh mesh = quench::to_triangle_mesh(quench::io::read_record(argv[1]));
      run(quench::voxelize(mesh, {.resolution = std::atoll(argv[2])}).shape, argv[i], std::atoi(argv[3]));
      std::_Exit(0);
    }
    int status = 0;
    waitpid(child, &status, 0);
    if (status != 0) return 1;
  }
  return 0;
}
