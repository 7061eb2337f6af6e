// SPDX-License-Identifier: Apache-2.0
// From a mesh to its pruned core on disk: microseconds and bytes per site, per stage. CPU time of the process where it
// runs on one thread (other loads of the machine disturb it less), wall time otherwise.
//   bench_core MESH [RESOLUTION [THREADS [RUNS]]]
#include <fmt/format.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "measure.h"
#include "quench/axis.h"
#include "quench/io.h"
#include "quench/shape.h"
#include "quench/voxelize.h"

namespace {

// Time since the last report belongs to the stage that reports now.
class StageClock {
 public:
  explicit StageClock(bool one_thread) : now_(one_thread ? cpu_seconds : wall_seconds), last_(now_()) {
    context.progress = [this](std::string_view stage, double) {
      const double now = now_();
      seconds[std::string(stage)] += now - last_;
      last_ = now;
      peaks[std::string(stage)] = peak_bytes();
    };
  }
  quench::Context context;
  std::map<std::string, double> seconds;
  std::map<std::string, double> peaks;  // bytes of the process, until the end of the stage

 private:
  double (*now_)();
  double last_;
};

struct Cost {
  std::map<std::string, double> seconds, peaks;
};

Cost run(const quench::TriangleMesh& mesh, std::int64_t resolution, bool one_thread, std::size_t& sites) {
  using namespace quench;
  StageClock clock(one_thread);
  Context* context = &clock.context;
  const Voxelization v = voxelize(mesh, {.resolution = resolution}, context);
  checkpoint(context, "voxelize", 1);
  MedialAxis core = voxel_core(v.shape, {}, context);
  sites = core.sites.size();
  prune_levels(core, context);
  const Reconstruction reconstruction(v.shape, core, Reconstruction::kSamples, context);
  const double lambda = auto_lambda(reconstruction, v.longest_side, v.shape.grid().spacing[0]);
  checkpoint(context, "reconstruct", 1);
  topology(core.complex);
  MedialAxis kept = pruned(std::move(core), lambda);
  topology(kept.complex);
  checkpoint(context, "topology", 1);
  const auto file = std::filesystem::temp_directory_path() / "quench_bench.vtp";
  io::write_record(file, to_record(std::move(kept)));
  std::filesystem::remove(file);
  checkpoint(context, "write", 1);
  return {clock.seconds, clock.peaks};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr, "usage: bench_core MESH [RESOLUTION [THREADS [RUNS]]]\n");
    return 2;
  }
  const std::int64_t resolution = argc > 2 ? std::atoll(argv[2]) : 512;
  const int threads = argc > 3 ? std::atoi(argv[3]) : 1;
  const int runs = argc > 4 ? std::atoi(argv[4]) : 5;
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  const quench::TriangleMesh mesh = quench::to_triangle_mesh(quench::io::read_record(argv[1]));
  std::map<std::string, std::vector<double>> all;
  std::map<std::string, double> peaks;
  std::size_t sites = 1;
  for (int r = 0; r < runs; ++r) {
    double total = 0;
    const Cost cost = run(mesh, resolution, threads == 1, sites);
    if (r == 0) peaks = cost.peaks;  // later runs begin at the peak of the first
    for (const auto& [stage, seconds] : cost.seconds) {
      all[stage].push_back(seconds);
      total += seconds;
    }
    all["total"].push_back(total);
  }
  fmt::print("{} at {}: {} sites, {} thread(s), median of {}\n", std::filesystem::path(argv[1]).filename().string(),
             resolution, sites, threads, runs);
  for (auto& [stage, seconds] : all) {
    std::nth_element(seconds.begin(), seconds.begin() + runs / 2, seconds.end());
    const double median = seconds[static_cast<std::size_t>(runs / 2)];
    const double bytes = stage == "total" ? peak_bytes() : peaks[stage];
    fmt::print("  {:<12} {:8.3f} s {:8.3f} us/site   peak so far {:6.0f} bytes/site\n", stage, median,
               median * 1e6 / static_cast<double>(sites), bytes / static_cast<double>(sites));
  }
  return 0;
}
