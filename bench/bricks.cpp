// SPDX-License-Identifier: Apache-2.0
// The dual complex of a mesh's boundary vertices at once and in boxes that grow, in the same run: CPU seconds on one
// thread, one child process each.
//   bench_bricks MESH RESOLUTION [SIZE:HALO | whole]...
#include <fmt/format.h>
#include <sys/wait.h>
#include <tbb/global_control.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <string>

#include "dual/peel/peel.h"
#include "measure.h"
#include "parts_in_rounds.h"
#include "quench/io.h"
#include "quench/voxelize.h"

namespace {

using namespace quench;

dual::DualComplex in_boxes(const VoxelShape& shape, const std::string& boxes) {
  char* end = nullptr;
  const std::int64_t size = std::strtoll(boxes.c_str(), &end, 10), halo = std::strtoll(end + 1, nullptr, 10);
  testing_duals::Rounds rounds(shape, {size, halo});
  double last = cpu_seconds();
  std::size_t round = 0, parts = 0;
  const auto tell = [&](const char* what) {
    const double now = cpu_seconds();
    fmt::print("  {} {:.2f} s", what, now - last);
    last = now;
  };
  const dual::bricks::Part whole = rounds.run(100, [&](dual::bricks::Part& part) {
    if (round != rounds.rounds()) {
      round = rounds.rounds();
      parts = 0;
      tell(fmt::format("round {}", round).c_str());
    }
    fmt::print(" [{} polytopes, {} open]", part.found.cells.count(), part.found.unmatched.size());
    ++parts;
  });
  tell("rest");
  dual::DualComplex dual = complex_of(whole, rounds.hulls(), nullptr).dual;
  tell("complex");
  fmt::print("\n");
  return dual;
}

void run(const VoxelShape& shape, const std::string& boxes) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
  const auto sites = boundary_vertices(shape);
  const double before = peak_bytes(), start = cpu_seconds();
  const dual::DualComplex dual =
      boxes == "whole" ? dual::peel::dual_complex(shape, sites, integer_spacing(shape.grid()), {}, nullptr)
                       : in_boxes(shape, boxes);
  const double spent = cpu_seconds() - start, count = static_cast<double>(sites.size());
  fmt::print("{:<10} {:>9} sites {:8.2f} s {:6.2f} us/site {:5.0f} bytes/site  {} vertices, {} faces\n", boxes,
             sites.size(), spent, 1e6 * spent / count, (peak_bytes() - before) / count, dual.complex.vertex_count,
             dual.complex.face_count());
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 4) {
    fmt::print(stderr, "usage: bench_bricks MESH RESOLUTION [SIZE:HALO | whole]...\n");
    return 2;
  }
  for (int i = 3; i < argc; ++i) {
    const pid_t child = fork();
    if (child == 0) {
      const TriangleMesh mesh = to_triangle_mesh(io::read_record(argv[1]));
      run(voxelize(mesh, {.resolution = std::atoll(argv[2])}).shape, argv[i]);
      std::_Exit(0);
    }
    int status = 0;
    waitpid(child, &status, 0);
    if (status != 0) return 1;
  }
  return 0;
}
