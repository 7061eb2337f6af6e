// SPDX-License-Identifier: Apache-2.0
// Burning a medial axis: error of erosion thickness against time, one thread.
//   bench_burn AXIS [--radii FILE.r] [--linear] [--times-only] [--spacing W]...
//   [--unit U] [--schedule STATES WINDOW]... [--parts THREADS]
// Spacings are multiples of the default one (default: 2 1 0.5 0.25); errors are mean relative errors over the vertices
// whose erosion thickness exceeds a voxel (of a core of Quench; else --unit, or the default spacing), against windows,
// which are exact; a row per spacing gives what these take there, and how many times the time of segments. --schedule
// adds a run with other blocks and windows (in node spacings) than the program's, and prints the ratio of its time to
// theirs: 1e12 0.125 is the order of time. --parts prints how long the parts of a burn take at the first spacing, on
// one thread and on THREADS, instead of errors.
#include <fmt/format.h>
#if defined(__GLIBC__)
#include <malloc.h>
#endif
#include <sys/wait.h>
#include <tbb/task_arena.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include "burning/burn_pass.h"
#include "measure.h"
#include "quench/axis.h"
#include "quench/burn.h"
#include "quench/io.h"

namespace {

using namespace quench;

struct Axis {
  CellComplex complex;
  std::vector<Vec3> points;
  std::vector<double> radius;
  double voxel = 0;
};

Axis read_axis(const std::string& file, const std::string& radii) {
  const Record data = io::read_record(file);
  Axis axis;
  std::vector<std::uint32_t> point_of;
  axis.complex = complex_of(data, &point_of);
  for (const std::uint32_t p : point_of) axis.points.push_back(data.points[p]);
  if (const DataArray* spacing = find_array(data.field_data, "spacing"); spacing && spacing->size() > 0)
    axis.voxel = spacing->numbers().front();
  if (!radii.empty()) {
    axis.radius = io::read_radii(radii, axis.points);
    return axis;
  }
  const DataArray* array = find_array(data.point_data, "radius");
  if (!array) {
    fmt::print(stderr, "{} has no radii; give --radii\n", file);
    std::exit(2);
  }
  const std::vector<double> all = array->numbers();
  for (const std::uint32_t p : point_of) axis.radius.push_back(all[p]);
  return axis;
}

// Peak memory of one burn above what was there before, measured in a process of its own. What reading the file has left
// free goes back to the system first: else the burn would use it again, and it would not be counted.
double burn_bytes(const Axis& axis, const BurnOptions& options, const burning::BlockSchedule& schedule) {
  int pipes[2];
  if (pipe(pipes) != 0) return 0;
#if defined(__GLIBC__)
  malloc_trim(0);
#endif
  const pid_t child = fork();
  if (child == 0) {
    const double before = peak_bytes();
    burn_scheduled(axis.complex, axis.points, axis.radius, options, schedule, nullptr);
    const double grown = peak_bytes() - before;
    if (write(pipes[1], &grown, sizeof grown) < 0) _exit(1);
    _exit(0);
  }
  double grown = 0;
  if (read(pipes[0], &grown, sizeof grown) < 0) grown = 0;
  waitpid(child, nullptr, 0);
  close(pipes[0]);
  close(pipes[1]);
  return grown;
}

// Wall seconds of the parts of a burn; the least of several runs, since other programs only make them longer.
constexpr std::array kParts{"network", "links", "polygons", "labels", "burn pass", "order pass"};
using Parts = std::array<double, kParts.size()>;
Parts seconds_of_parts(const Axis& axis, const BurnOptions& options, int threads) {
  using namespace burning;
  Parts least;
  least.fill(1e300);
  tbb::task_arena arena(threads);
  for (int run = 0; run < 7; ++run)
    arena.execute([&] {
      std::array<double, kParts.size() + 1> at{};
      std::size_t done = 0;
      const auto now = [&] { at[done++] = wall_seconds(); };
      now();
      BurnedSectors sectors;
      sectors.network = make_network(axis.complex, axis.points, options.omega);
      now();
      Links links = make_links(axis.complex, sectors.network);
      now();
      Polygons polygons = make_polygons(axis.complex, axis.points, sectors.network);
      now();
      const BurnDomain domain{axis.complex,   axis.points,      axis.radius,        sectors.network,
                              options.radius, std::move(links), std::move(polygons)};
      Labels labels(domain, {}, label_tolerance(axis.complex, axis.points, options.omega));
      now();
      propagate_by_segments(domain, labels, nullptr);
      now();
      const auto [times, opened] = labels.release();
      order_pass(domain, opened, times, sectors, nullptr);
      now();
      for (std::size_t i = 0; i < kParts.size(); ++i) least[i] = std::min(least[i], at[i + 1] - at[i]);
    });
  return least;
}

void print_parts(const Axis& axis, const BurnOptions& options, int threads) {
  const Parts one = seconds_of_parts(axis, options, 1), several = seconds_of_parts(axis, options, threads);
  const double n = burn(axis.complex, axis.points, axis.radius, options).node_count;
  fmt::print("{} nodes\n\n| part | us/node, 1 thread | {} threads | times faster |\n|---|---|---|---|\n", n, threads);
  const auto row = [&](const char* name, double a, double b) {
    fmt::print("| {} | {:.3f} | {:.3f} | {:.2f} |\n", name, a / n * 1e6, b / n * 1e6, a / b);
  };
  for (std::size_t i = 0; i < kParts.size(); ++i) row(kParts[i], one[i], several[i]);
  row("all", std::accumulate(one.begin(), one.end(), 0.0), std::accumulate(several.begin(), several.end(), 0.0));
}

}  // namespace

int main(int argc, char** argv) {
  std::string file, radii;
  std::vector<double> spacings;
  std::vector<burning::BlockSchedule> others;
  double unit_given = 0;
  int parts = 0;
  BurnOptions options;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--radii" && i + 1 < argc)
      radii = argv[++i];
    else if (word == "--spacing" && i + 1 < argc)
      spacings.push_back(std::atof(argv[++i]));
    else if (word == "--unit" && i + 1 < argc)
      unit_given = std::atof(argv[++i]);
    else if (word == "--parts" && i + 1 < argc)
      parts = std::atoi(argv[++i]);
    else if (word == "--schedule" && i + 2 < argc) {
      const auto states = static_cast<std::uint64_t>(std::atof(argv[++i]));
      others.push_back({states, std::atof(argv[++i])});
    } else if (word == "--linear")
      options.radius = RadiusRule::linear;
    else if (word == "--times-only")
      options.parents = false;
    else
      file = word;
  }
  if (file.empty()) {
    fmt::print(stderr,
               "usage: bench_burn AXIS [--radii FILE.r] [--linear] [--times-only] [--spacing W]... "
               "[--unit U] [--schedule STATES WINDOW]... [--parts THREADS]\n");
    return 2;
  }
  if (spacings.empty()) spacings = {2, 1, 0.5, 0.25};
  const Axis axis = read_axis(file, radii);
  const double base = default_omega(axis.complex, axis.points), unit = unit_given > 0   ? unit_given
                                                                       : axis.voxel > 0 ? axis.voxel
                                                                                        : base;
  if (parts > 0) {
    options.omega = base * spacings[0];
    print_parts(axis, options, parts);
    return 0;
  }
  struct Run {
    double spacing, bytes;
    Propagation propagation;
    std::optional<burning::BlockSchedule> other;  // than the program's
  };
  std::vector<Run> runs;
  for (const double w : spacings) {
    options.omega = base * w;
    for (const Propagation propagation : {Propagation::segments, Propagation::windows}) {  // before anything else grows
      options.propagation = propagation;
      runs.push_back({base * w, burn_bytes(axis, options, {}), propagation, std::nullopt});
    }
    options.propagation = Propagation::segments;
    for (const burning::BlockSchedule& schedule : others)
      runs.push_back({base * w, burn_bytes(axis, options, schedule), Propagation::segments, schedule});
  }
  options.omega = base;
  options.propagation = Propagation::windows;
  const Burning truth = burn(axis.complex, axis.points, axis.radius, options);
  fmt::print("{} vertices, {} faces, default spacing {:.4g}\n\n", axis.complex.vertex_count, axis.complex.face_count(),
             base);
  fmt::print("| spacing | by | nodes | s | us/node | B/node | mean error of ET | at most {:.3g} above, below |\n",
             unit);
  fmt::print("|---|---|---|---|---|---|---|---|\n");
  for (const Run& run : runs) {
    const bool windows = run.propagation == Propagation::windows;
    options.omega = run.spacing;
    std::vector<double> seconds, ratios;
    Burning result;
    const auto timed = [&](Propagation propagation, const burning::BlockSchedule& schedule) {
      options.propagation = propagation;
      const double start = cpu_seconds();
      result = burn_scheduled(axis.complex, axis.points, axis.radius, options, schedule, nullptr);
      return cpu_seconds() - start;
    };
    for (int round = 0; round < 3; ++round) {
      const double ours = windows || run.other ? timed(Propagation::segments, {}) : 0;
      seconds.push_back(timed(run.propagation, run.other.value_or(burning::BlockSchedule{})));
      ratios.push_back(seconds.back() / ours);
    }
    std::sort(seconds.begin(), seconds.end());
    std::sort(ratios.begin(), ratios.end());
    std::string name = "segments";
    if (windows) name = fmt::format("windows: {:.2f} x", ratios[1]);
    if (run.other)
      name = fmt::format("segments, blocks of {} states, turns of {:g} spacings: {:.2f} x", run.other->states_per_block,
                         run.other->window_width, ratios[1]);
    double error = 0, above = 0, below = 0;
    std::size_t count = 0;
    for (std::size_t v = 0; v < axis.radius.size(); ++v) {
      const double et = truth.erosion_thickness[v], got = result.erosion_thickness[v];
      if (std::isinf(et)) continue;
      above = std::max(above, got - et);
      below = std::max(below, et - got);
      if (et <= unit) continue;
      error += std::abs(got - et) / et;
      ++count;
    }
    const double n = result.node_count;
    fmt::print("| {:.4g} | {} | {} | {:.3f} | {:.2f} | {:.0f} | {:.3f}% | {:.3f}, {:.3f} |\n", options.omega, name,
               result.node_count, seconds[1], seconds[1] / n * 1e6, run.bytes / n,
               count ? 100 * error / static_cast<double>(count) : 0, above / unit, below / unit);
    std::fflush(stdout);
  }
  return 0;
}
