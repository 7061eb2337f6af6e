// SPDX-License-Identifier: Apache-2.0
// What follows a burning, stage by stage, per node: CPU time, wall time, and the most memory above what was held before
// (axis and burning).
//   bench_skeletons AXIS [THREADS [RUNS]]
#include <fmt/format.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "base/return_memory.h"
#include "measure.h"
#include "quench/pipeline.h"

namespace {

using namespace quench;

double status_bytes(const std::string& field) {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;)
    if (word == field + ":") {
      double kilobytes = 0;
      status >> kilobytes;
      return kilobytes * 1024;
    }
  return 0;
}
void forget_peak() { std::ofstream("/proc/self/clear_refs") << 5; }

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

struct Cost {
  double cpu = 0, wall = 0, bytes = 0;
  void add(const Cost& other) {
    cpu += other.cpu;
    wall += other.wall;
    bytes = std::max(bytes, other.bytes);
  }
};
struct Stage {
  std::string name;
  std::vector<double> cpu, wall;
  double bytes = 0;  // the peak of the first run
  Cost cost() const { return {median(cpu), median(wall), bytes}; }
};

class Stages {
 public:
  template <class Work>
  auto time(const std::string& name, double held, const Work& work) {
    forget_peak();
    const double cpu = cpu_seconds(), wall = wall_seconds();
    auto result = work();
    auto stage = std::find_if(all.begin(), all.end(), [&](const Stage& s) { return s.name == name; });
    if (stage == all.end()) stage = all.insert(all.end(), {name, {}, {}, status_bytes("VmHWM") - held});
    stage->cpu.push_back(cpu_seconds() - cpu);
    stage->wall.push_back(wall_seconds() - wall);
    return result;
  }
  std::vector<Stage> all;
};

void run(const pipeline::LoadedAxis& loaded, bool with_floor, Stages& stages, double& nodes) {
  const MedialAxis& axis = loaded.axis;
  Burning burning = pipeline::burning_of(axis, loaded.voxel_core, {}, true, loaded.scale);
  nodes = burning.node_count;
  const Topology wanted = topology(axis.complex);
  base::return_free_memory();  // else it would be used again, and not be counted
  const double omega = burning.options.omega, held = status_bytes("VmRSS");
  const pipeline::FamilyFloor floor =
      with_floor ? pipeline::floor_of({}, loaded.scale, omega) : pipeline::FamilyFloor{};
  RefinedAxis refined = stages.time("curves", held, [&] { return pipeline::curves_of(axis, std::move(burning)); });
  pipeline::FamilyResult family =
      stages.time("family", held, [&] { return pipeline::family_of(std::move(refined), wanted, floor); });
  pipeline::SkeletonResult skeleton =
      stages.time("skeleton", held, [&] { return pipeline::skeleton_of(family, {}, loaded.scale, omega); });
  const CurveGraph graph =
      stages.time("graph", held, [&] { return pipeline::draw_branches(skeleton, {}, loaded.scale); });
  pipeline::PageBuilder builder;
  stages.time("page layers", held, [&] {
    builder.add_skeleton(skeleton.skeleton, graph);
    return builder.add_family(std::move(family.family)), 0;
  });
  const auto file = std::filesystem::temp_directory_path() / "quench_bench.html";
  stages.time("page file", held, [&] { return builder.write(file), 0; });
  std::filesystem::remove(file);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr, "usage: bench_skeletons AXIS [THREADS [RUNS]]\n");
    return 2;
  }
  const int threads = argc > 2 ? std::atoi(argv[2]) : 1, runs = argc > 3 ? std::atoi(argv[3]) : 3;
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  const pipeline::LoadedAxis axis = pipeline::axis_of(pipeline::read_surface(argv[1]), argv[1]);
  Stages all, floored;
  double nodes = 1;
  for (int r = 0; r < runs; ++r) {
    run(axis, true, floored, nodes);
    run(axis, false, all, nodes);
  }
  fmt::print("{}: {:.0f} nodes, {} thread(s), median of {}; with the floor of a run, without, and the ratio\n\n",
             std::filesystem::path(argv[1]).filename().string(), nodes, threads, runs);
  fmt::print("| stage | CPU us/node | wall us/node | peak B/node |\n|---|---|---|---|\n");
  const auto cell = [&](double with, double without, double unit, const char* format) {
    return fmt::format(fmt::runtime(format), with * unit / nodes, without * unit / nodes, with / without);
  };
  const auto row = [&](const std::string& name, const Cost& with, const Cost& without) {
    constexpr const char* kTime = "{:.3f} {:.3f} {:.2f}";
    fmt::print("| {} | {} | {} | {} |\n", name, cell(with.cpu, without.cpu, 1e6, kTime),
               cell(with.wall, without.wall, 1e6, kTime), cell(with.bytes, without.bytes, 1, "{:.0f} {:.0f} {:.2f}"));
  };
  Cost total, total_all;
  for (std::size_t i = 0; i < all.all.size(); ++i) {
    const Cost with = floored.all[i].cost(), without = all.all[i].cost();
    row(all.all[i].name, with, without);
    total.add(with);
    total_all.add(without);
  }
  row("all", total, total_all);
  return 0;
}
