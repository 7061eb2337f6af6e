// SPDX-License-Identifier: Apache-2.0
// The main job, from a mesh or a volume to the last file, as `quench run` does it: microseconds and bytes per boundary
// vertex, per stage, and what stands before and behind the core. CPU time of the process where it runs on one thread
// (other loads of the machine disturb it less), wall time otherwise.
//   bench_run SHAPE [RESOLUTION [THREADS [RUNS]]] [--lambda LENGTH] [--threshold T] [--largest-component]
#include <fmt/format.h>
#include <tbb/global_control.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "measure.h"
#include "quench/axis.h"
#include "quench/error.h"
#include "quench/graph.h"
#include "quench/io.h"
#include "quench/picture.h"
#include "quench/pipeline.h"
#include "quench/shape.h"

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

struct Job {
  std::filesystem::path file;
  quench::pipeline::ShapeOptions shape;
  quench::pipeline::AxisOptions axis;
};

Cost run(const Job& job, bool one_thread, std::size_t& sites) {
  using namespace quench;
  StageClock clock(one_thread);
  Context* context = &clock.context;
  pipeline::LoadedShape shape = pipeline::load_shape(job.file, job.shape, context);
  sites = static_cast<std::size_t>(count_boundary_vertices(shape.shape));
  checkpoint(context, "read", 1);
  pipeline::PageBuilder page;
  pipeline::RunOptions options;
  options.axis = job.axis;
  options.page = &page;
  double core = 0;
  options.on_core = [&](const pipeline::CoreResult&) {
    for (const auto& [stage, seconds] : clock.seconds) core += stage == "page" ? 0 : seconds;
  };
  const pipeline::RunResult result = pipeline::run(shape, options, context);

  const auto folder = std::filesystem::temp_directory_path() / fmt::format("quench_bench_{}", ::getpid());
  std::filesystem::create_directory(folder);
  io::write_record(folder / "core.vtp", result.axis.file);
  io::write_record(folder / "skeleton.vtp", pipeline::skeleton_file(result.axis.skeleton, result.axis.file));
  io::write_swc(folder / "skeleton.swc", result.axis.graph);
  io::write_branches(folder / "branches.csv", result.axis.graph);
  checkpoint(context, "write", 1);
  if (pipeline::has_page_program()) page.write(folder / "view.html");
  checkpoint(context, "page", 1);
  write_png(folder / "picture.png", draw_page(page.page, {}, context), context);
  checkpoint(context, "picture", 1);
  std::filesystem::remove_all(folder);
  double total = 0;
  for (const auto& [stage, seconds] : clock.seconds) total += seconds;
  Cost cost{clock.seconds, clock.peaks};
  cost.seconds["= to the core"] = core;
  cost.seconds["= behind it"] = total - core;
  cost.seconds["= total"] = total;
  return cost;
}

}  // namespace

int main(int argc, char** argv) {
  Job job;
  std::vector<std::string> numbers;
  try {
    for (int i = 1; i < argc; ++i) {
      const std::string word = argv[i];
      const auto value = [&] { return std::string(i + 1 < argc ? argv[++i] : ""); };
      if (word == "--lambda")
        job.axis.pruning = {quench::kLambda, quench::pipeline::parse_length_or_auto(value(), "lambda")};
      else if (word == "--threshold")
        job.shape.foreground.threshold = std::atof(value().c_str());
      else if (word == "--largest-component")
        job.shape.foreground.largest_component = true;
      else if (job.file.empty())
        job.file = word;
      else
        numbers.push_back(word);
    }
    if (job.file.empty()) {
      fmt::print(stderr,
                 "usage: bench_run SHAPE [RESOLUTION [THREADS [RUNS]]] [--lambda LENGTH] [--threshold T] "
                 "[--largest-component]\n");
      return 2;
    }
    const auto number = [&](std::size_t i, int preset) {
      return i < numbers.size() ? std::atoi(numbers[i].c_str()) : preset;
    };
    const int resolution = number(0, 512), threads = number(1, 1), runs = std::max(1, number(2, 5));
    if (quench::io::kind_of(job.file) == quench::io::Kind::surface) job.shape.resolution = resolution;
    job.shape.keep_mesh = true;
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
    std::map<std::string, std::vector<double>> all;
    std::map<std::string, double> peaks;
    std::size_t sites = 1;
    for (int r = 0; r < runs; ++r) {
      const Cost cost = run(job, threads == 1, sites);
      if (r == 0) peaks = cost.peaks;  // later runs begin at the peak of the first
      for (const auto& [stage, seconds] : cost.seconds) all[stage].push_back(seconds);
    }
    const auto per_site = [&](double x) { return x / static_cast<double>(sites); };
    fmt::print("{} at {}: {} sites, {} thread(s), median of {}\n", job.file.filename().string(), resolution, sites,
               threads, runs);
    for (auto& [stage, seconds] : all) {
      std::nth_element(seconds.begin(), seconds.begin() + runs / 2, seconds.end());
      const double median = seconds[static_cast<std::size_t>(runs / 2)];
      fmt::print("  {:<14} {:8.3f} s {:8.3f} us/site", stage, median, 1e6 * per_site(median));
      if (peaks.contains(stage)) fmt::print("   peak so far {:6.0f} bytes/site", per_site(peaks[stage]));
      fmt::print("\n");
    }
    fmt::print("  peak of all {:.0f} bytes/site\n",
               per_site(std::ranges::max_element(peaks, {}, [](const auto& p) { return p.second; })->second));
  } catch (const quench::Error& error) {
    fmt::print(stderr, "bench_run: {}\n", error.what());
    return 1;
  }
  return 0;
}
