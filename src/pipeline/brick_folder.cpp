// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/memory.h"
#include "base/text.h"
#include "pipeline/brick_files.h"
#include "quench/bricks.h"
#include "quench/error.h"
#include "quench/io.h"

namespace quench::pipeline {
namespace {

namespace fs = std::filesystem;

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// What is done while one exists.
class Meter {
 public:
  explicit Meter(const PartFiles& parts) : parts_(parts), read_(parts.read), written_(parts.written) {}

  BrickFigures figures() const {
    BrickFigures figures;
    figures.cpu_seconds = cpu_seconds() - cpu_;
    figures.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    figures.peak_bytes = base::peak_memory();
    figures.bytes_read = parts_.read - read_;
    figures.bytes_written = parts_.written - written_;
    return figures;
  }

 private:
  const PartFiles& parts_;
  std::int64_t read_, written_;
  double cpu_ = cpu_seconds();
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

void add(BrickFigures& sum, const BrickFigures& one) {
  sum.cpu_seconds += one.cpu_seconds;
  sum.seconds += one.seconds;
  sum.peak_bytes = std::max(sum.peak_bytes, one.peak_bytes);
  sum.bytes_read += one.bytes_read;
  sum.bytes_written += one.bytes_written;
}

void write_text(const fs::path& file, const std::string& text) {
  io::write_atomically(file, [&](std::ostream& out) { out << text; });
}

void write_figures(const fs::path& file, const BrickFigures& figures) {
  const nlohmann::ordered_json json = {{"cpu_seconds", figures.cpu_seconds},
                                       {"seconds", figures.seconds},
                                       {"peak_bytes", figures.peak_bytes},
                                       {"bytes_read", figures.bytes_read},
                                       {"bytes_written", figures.bytes_written}};
  write_text(file, json.dump() + "\n");
}

// Nothing where there are none: they are beside the work.
std::optional<BrickFigures> read_figures(const fs::path& file) {
  std::ifstream in(file);
  const auto json = nlohmann::json::parse(in, nullptr, false);
  if (!json.is_object()) return {};
  const auto number = [&](const char* name) {
    const auto found = json.find(name);
    return found != json.end() && found->is_number() ? found->get<double>() : 0;
  };
  return BrickFigures{number("cpu_seconds"), number("seconds"), static_cast<std::int64_t>(number("peak_bytes")),
                      static_cast<std::int64_t>(number("bytes_read")),
                      static_cast<std::int64_t>(number("bytes_written"))};
}

fs::path figures_of(const PartFiles& parts, std::size_t round, std::size_t brick) {
  return parts.file(round, brick).replace_extension(".json");
}

bool is_temporary(const fs::path& file) { return file.filename().string().starts_with(".quench-"); }

// Refuses a folder that holds something else; makes it where it is not there.
void prepare_folder(const fs::path& work) {
  std::error_code error;
  if (!fs::exists(work, error)) {
    fs::create_directory(work, error);
    if (error)
      throw Error(ErrorCode::failed, fmt::format("cannot make the folder '{}': {}", work.string(), error.message()));
    return;
  }
  if (!fs::is_directory(work, error))
    throw Error(ErrorCode::usage, fmt::format("'{}' is not a folder; give another name", work.string()));
  for (const auto& entry : fs::directory_iterator(work)) {
    const std::string name = entry.path().filename().string();
    if (name != "plan.json" && name != "shape" && name != "surface.mesh" && name != "log" &&
        !name.starts_with("round-") && !is_temporary(entry.path()) && !fs::exists(work / "plan.json", error))
      throw Error(ErrorCode::usage,
                  fmt::format("the folder '{}' holds other files, e.g. '{}'; give a new one", work.string(), name));
  }
}

// What tasks need of the shape as files, which are written with `write`.
void put_shape(const LoadedShape& shape, const fs::path& work, bool write, PlanFile& file, Context* context) {
  const ShapeFiles files = shape_files(work, file.plan);
  if (write) fs::create_directory(files.folder);
  for (std::size_t layer = 0; layer < files.count(); ++layer) {
    checkpoint(context, "plan", static_cast<double>(layer) / static_cast<double>(files.count()));
    const std::string bytes = files.encoded(shape.shape, layer, file.shape_sums.emplace_back());
    if (write) write_text(files.file(layer), bytes);
  }
  checkpoint(context, "plan", 1);
  if (!shape.surface) return;
  file.surface = shape.surface->kind();
  const std::string bytes = encoded_mesh(shape.surface->mesh(), file.surface_sum);
  if (write) write_text(work / "surface.mesh", bytes);
}

void require_round(const BrickPlan& plan, const PartFiles& parts, std::size_t round) {
  std::size_t missing = 0;
  for (std::size_t b = 0; b < plan.rounds[round].bricks.size(); ++b) missing += !parts.has(round, b);
  if (missing > 0)
    throw Error(ErrorCode::failed,
                fmt::format("{} of the {} bricks of round {} {} not done yet; run that round first", missing,
                            plan.rounds[round].bricks.size(), round + 1, missing == 1 ? "is" : "are"));
}

// Figures of the progress of one brick are beside those of all.
class BrickContext {
 public:
  explicit BrickContext(Context* outer) {
    if (!outer) return;
    inner_.threads = outer->threads;
    inner_.memory_limit = outer->memory_limit;
    inner_.note = outer->note;
    inner_.progress = [this, outer](std::string_view, double) { checkpoint(outer, "bricks", fraction); };
  }
  Context* get() { return &inner_; }
  double fraction = 0;

 private:
  Context inner_;
};

void check_task(const BrickPlan& plan, const BrickTask& task) {
  if (task.tasks < 1 || task.task >= task.tasks)
    throw Error(ErrorCode::usage, fmt::format("task '{}/{}' is none of 0/n to (n-1)/n", task.task, task.tasks), "task");
  if (task.round && (*task.round < 1 || *task.round > plan.rounds.size()))
    throw Error(ErrorCode::usage,
                fmt::format("round '{}' is not one of the plan, which has {}", *task.round, plan.rounds.size()),
                "round");
  if (!task.round && task.tasks > 1 && plan.rounds.size() > 1)
    throw Error(ErrorCode::usage,
                fmt::format("one of {} tasks cannot do all {} rounds, as each needs all bricks of the one before; give "
                            "a round",
                            task.tasks, plan.rounds.size()),
                "round");
}

}  // namespace

BrickStatus plan_bricks(const LoadedShape& shape, const AxisOptions& options, std::int64_t size, const fs::path& work,
                        const std::string& report, Context* context) {
  PlanFile file;
  file.plan = plan_of(shape, options, size, context);
  file.longest_side = shape.longest_side;
  file.topology = shape.topology;
  file.coordinates = shape.coordinates;
  file.parameters = shape.parameters;
  file.from_mesh = shape.from_mesh;
  file.report = report;
  prepare_folder(work);
  std::error_code ignored;
  const bool fresh = !fs::exists(work / "plan.json", ignored);
  put_shape(shape, work, fresh, file, context);
  const std::string text = text_of(file);
  if (fresh) {
    PartFiles(work, file.plan).make_folders();
    write_text(work / "plan.json", text);  // last: what holds it is complete
  } else {
    std::atomic<std::int64_t> read{0};
    if (WorkFile(work / "plan.json", read).rest() != text)
      throw Error(ErrorCode::usage,
                  fmt::format("'{}' holds another plan; give another folder, or remove it", work.string()));
  }
  return status_of_bricks(work);
}

void run_bricks(const fs::path& work, const BrickTask& task, const std::function<void(const BrickDone&)>& on_brick,
                Context* context) {
  FolderBrickStore store(work, context);
  const BrickPlan& plan = store.file.plan;
  check_task(plan, task);
  const std::size_t first = task.round ? *task.round - 1 : 0, end = task.round ? first + 1 : plan.rounds.size();
  for (std::size_t round = first; round < end; ++round) {
    if (round > 0) require_round(plan, store.parts, round - 1);
    const std::size_t bricks = plan.rounds[round].bricks.size();
    for (std::size_t brick = task.task; brick < bricks; brick += task.tasks) {
      BrickDone done{round + 1, plan.rounds.size(), brick, bricks, store.has(round, brick), {}};
      if (!done.was_there) {
        const Meter meter(store.parts);
        run_brick(plan, round, brick, store, context);
        done.figures = meter.figures();
        write_figures(figures_of(store.parts, round, brick), done.figures);
      }
      if (on_brick) on_brick(done);
    }
  }
}

MergedBricks merge_bricks(const fs::path& work, Context* context) {
  FolderBrickStore store(work, context);
  const Meter meter(store.parts);
  require_round(store.file.plan, store.parts, store.file.plan.rounds.size() - 1);
  MergedBricks merged;
  merged.report = store.file.report;
  merged.shape = store.shape();
  merged.core = merge_bricks(store.file.plan, merged.shape, store, context);
  merged.figures = meter.figures();
  return merged;
}

void note_merged(const fs::path& work, const BrickFigures& figures) { write_figures(work / "merged.json", figures); }

BrickStatus status_of_bricks(const fs::path& work) {
  const PlanFile file = read_plan(work);
  const PartFiles parts(work, file.plan);
  BrickStatus status;
  status.report = file.report;
  status.merge = read_figures(work / "merged.json");
  for (std::size_t round = 0; round < file.plan.rounds.size(); ++round) {
    RoundStatus& of = status.rounds.emplace_back();
    of.bricks = file.plan.rounds[round].bricks.size();
    for (std::size_t brick = 0; brick < of.bricks; ++brick) {
      if (!parts.has(round, brick)) continue;
      ++of.done;
      if (const auto figures = read_figures(figures_of(parts, round, brick))) add(of.figures, *figures);
    }
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(parts.folder(round), ignored))
      of.unfinished += is_temporary(entry.path());
  }
  return status;
}

CoreResult core_in_bricks(const LoadedShape& shape, const AxisOptions& options, const fs::path& folder,
                          Context* context) {
  const VoxelShape::Box box = shape.shape.foreground_box();
  std::int64_t longest = 0;
  for (std::size_t a = 0; a < 3; ++a) longest = std::max(longest, box.end[a] - box.begin[a]);
  const BrickPlan plan = plan_of(shape, options, std::clamp<std::int64_t>(longest / 4, 64, kBrickSize), context);
  TemporaryBrickStore store(plan, shape, folder);
  std::size_t all = 0, done = 0;
  for (const BrickRound& round : plan.rounds) all += round.bricks.size();
  BrickContext inner(context);
  for (std::size_t round = 0; round < plan.rounds.size(); ++round) {
    for (std::size_t brick = 0; brick < plan.rounds[round].bricks.size(); ++brick) {
      run_brick(plan, round, brick, store, inner.get());
      inner.fraction = static_cast<double>(++done) / static_cast<double>(all);
    }
    if (round > 0) store.drop(round - 1);
  }
  checkpoint(context, "bricks", 1);
  return merge_bricks(plan, shape, store, context);
}

}  // namespace quench::pipeline
