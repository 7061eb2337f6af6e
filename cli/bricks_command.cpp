// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdlib>

#include "base/memory.h"
#include "base/platform/streams.h"
#include "base/text.h"
#include "option_checks.h"
#include "program.h"
#include "quench/bricks.h"
#include "report.h"
#include "shape_input.h"

namespace quench::program {
namespace {

using pipeline::BrickFigures;
using pipeline::BrickStatus;
using pipeline::BrickTask;

CLI::Option* add_work(CLI::App& app, std::string& work) {
  return app.add_option("WORK", work, "The folder that 'bricks plan' has made")->type_name("")->required();
}

std::string figures_text(const BrickFigures& f) {
  return fmt::format("{:.1f} s, {:.1f} s of processors, {} of memory, {} read, {} written", f.seconds, f.cpu_seconds,
                     base::bytes_text(f.peak_bytes), base::bytes_text(f.bytes_read), base::bytes_text(f.bytes_written));
}

Json figures_section(const BrickFigures& f) {
  return {{"cpu_seconds", f.cpu_seconds},
          {"seconds", f.seconds},
          {"peak_bytes", f.peak_bytes},
          {"bytes_read", f.bytes_read},
          {"bytes_written", f.bytes_written}};
}

std::string rounds_text(const BrickStatus& status) {
  std::vector<std::size_t> bricks;
  for (const auto& round : status.rounds) bricks.push_back(round.bricks);
  const bool one = bricks.size() == 1;
  return fmt::format("{} of {} {}", base::counted(bricks.size(), "round"), fmt::join(bricks, ", "),
                     one && bricks[0] == 1 ? "brick" : "bricks");
}

Json rounds_section(const BrickStatus& status) {
  Json rounds = Json::array();
  for (const auto& round : status.rounds) {
    rounds.push_back({{"round", rounds.size() + 1}, {"bricks", round.bricks}, {"done", round.done}});
    rounds.back().update(figures_section(round.figures));
    rounds.back()["unfinished_files"] = round.unfinished;
  }
  return rounds;
}

// ---------------------------------------------------------------------------------------------------------------- plan

int plan(ShapeOptions shape, const pipeline::AxisOptions& axis, std::int64_t size, const std::string& work,
         Session& session) {
  check_shape_options(shape);
  session.check_report({shape.file});
  choose_surface_in_bricks(shape, session);
  const pipeline::LoadedShape loaded = load_shape(shape, session);
  Json report = {{"input", input_section(shape, loaded)}, {"shape", shape_section(loaded)}};
  const BrickStatus status = pipeline::plan_bricks(loaded, axis, size, work, json_text(report), &session.context);
  report["rounds"] = rounds_section(status);
  if (!session.options.report.empty()) write_report(session.options.report, report, session);
  session.say(fmt::format("{}: {}; do them with 'quench bricks run {}{}', then 'quench bricks merge'", work,
                          rounds_text(status), work, status.rounds.size() > 1 ? " --round R" : ""));
  return 0;
}

// ----------------------------------------------------------------------------------------------------------------- run

std::optional<std::size_t> number_in_environment(const char* name) {
  const char* text = std::getenv(name);
  if (!text) return {};
  std::size_t value = 0;
  if (!is_number(text, value))
    throw Error(ErrorCode::usage, fmt::format("the environment variable {} is '{}', which is not a number; give --task "
                                              "i/n",
                                              name, text));
  return value;
}

/// The part of an array of jobs that this process is, by what their schedulers set.
std::optional<BrickTask> task_in_environment() {
  struct Scheduler {
    const char *index, *count, *first, *step;
  };
  constexpr Scheduler kSchedulers[] = {
      {"SLURM_ARRAY_TASK_ID", "SLURM_ARRAY_TASK_COUNT", "SLURM_ARRAY_TASK_MIN", "SLURM_ARRAY_TASK_STEP"},
      {"AWS_BATCH_JOB_ARRAY_INDEX", "AWS_BATCH_JOB_ARRAY_SIZE", nullptr, nullptr},
      {"JOB_COMPLETION_INDEX", "JOB_COMPLETIONS", nullptr, nullptr}};
  for (const Scheduler& s : kSchedulers) {
    const auto index = number_in_environment(s.index);
    if (!index) continue;
    const auto count = number_in_environment(s.count);
    const std::size_t first = s.first ? number_in_environment(s.first).value_or(0) : 0;
    const std::size_t step = s.step ? number_in_environment(s.step).value_or(1) : 1;
    if (!count || *index < first || step == 0 || (*index - first) / step >= *count)
      throw Error(ErrorCode::usage,
                  fmt::format("the environment variable {} is set, but {} does not say of how many; give --task i/n",
                              s.index, s.count));
    return BrickTask{{}, (*index - first) / step, *count};
  }
  return {};
}

void parse_task(const std::string& option, const std::string& text, BrickTask& task) {
  const std::size_t slash = text.find('/');
  if (slash == text.npos || !is_number(text.substr(0, slash), task.task) ||
      !is_number(text.substr(slash + 1), task.tasks) || task.task >= task.tasks)
    throw Error(ErrorCode::usage,
                fmt::format("{} '{}' is not one of 0/n, 1/n ... (n-1)/n, which n tasks are", option, text));
}

int run_task(const std::string& work, const BrickTask& task, Session& session) {
  // Without a terminal a line per brick is enough.
  if (!base::stderr_is_terminal()) session.context.progress = nullptr;
  std::size_t found = 0, done = 0;
  pipeline::run_bricks(
      work, task,
      [&](const pipeline::BrickDone& brick) {
        found += brick.was_there;
        done += !brick.was_there;
        if (!brick.was_there)
          session.say(fmt::format("round {}, brick {} of {}: {}", brick.round, brick.brick, brick.bricks,
                                  figures_text(brick.figures)));
      },
      &session.context);
  session.say(fmt::format("{}: {} done{}", work, base::counted(done, "brick"),
                          found > 0 ? fmt::format(", {} there already", found) : std::string()));
  return 0;
}

// --------------------------------------------------------------------------------------------------------------- merge

int merge(const std::string& work, const std::string& output, Session& session) {
  session.check_output(output, {});
  io::check_writable_format(output);
  pipeline::MergedBricks merged = pipeline::merge_bricks(work, &session.context);
  say_core(merged.shape, merged.core, session);
  const Json of_plan = Json::parse(merged.report);
  Json report = {{"input", of_plan.at("input")}};
  add_core_sections(report, merged.shape, merged.core);
  report["shape"] = of_plan.at("shape");
  {
    io::OutputGroup outputs;
    io::write_record(output, pipeline::core_file(std::move(merged.core)));
    session.finished("write");
    write_report(outputs, report, session);
  }
  pipeline::note_merged(work, merged.figures);
  say_written(session, output, session.options.report == "-" ? "" : session.options.report, merged.core, merged.shape);
  return 0;
}

// -------------------------------------------------------------------------------------------------------------- status

int status(const std::string& work, Session& session) {
  const BrickStatus status = pipeline::status_of_bricks(work);
  if (session.options.report == "-") {
    Json answer = {{"rounds", rounds_section(status)}, {"merged", status.merge.has_value()}};
    if (status.merge) answer["merge"] = figures_section(*status.merge);
    answer["shape"] = Json::parse(status.report).at("shape");
    session.answer(json_text(answer, 2) + "\n");
    return 0;
  }
  const auto row = [&](const std::string& name, const std::string& done, const BrickFigures& f) {
    session.answer_line(fmt::format("{:<8}{:>15}{:>13.1f}{:>13.1f}{:>12}{:>12}{:>12}", name, done, f.cpu_seconds,
                                    f.seconds, base::bytes_text(f.peak_bytes), base::bytes_text(f.bytes_read),
                                    base::bytes_text(f.bytes_written)));
  };
  session.answer_line(fmt::format("{:<8}{:>15}{:>13}{:>13}{:>12}{:>12}{:>12}", "round", "bricks done", "processor s",
                                  "seconds", "memory", "read", "written"));
  std::size_t unfinished = 0, number = 0;
  for (const auto& round : status.rounds) {
    row(std::to_string(++number), fmt::format("{}/{}", round.done, round.bricks), round.figures);
    unfinished += round.unfinished;
  }
  row("merge", status.merge ? "1/1" : "0/1", status.merge.value_or(BrickFigures{}));
  if (unfinished > 0)
    session.answer_line(
        fmt::format("{} of tasks at work or killed; none of them is used, and once no task is at work they may be "
                    "removed: {}/round-*/.quench-*",
                    base::counted(unfinished, "unfinished file"), work));
  return 0;
}

}  // namespace

Action add_bricks_plan(CLI::App& app) {
  struct Options {
    ShapeOptions shape;
    pipeline::AxisOptions axis;
    std::int64_t size = pipeline::kBrickSize;
    std::string work;
  };
  auto o = std::make_shared<Options>();
  add_shape_options(app, o->shape);
  add_core_options(app, o->axis);
  add_number<std::int64_t>(app, "--size", o->size,
                           "Voxels along a side of the boxes of the first round, 8 to 4096; about 4 GB of memory per "
                           "task for 512",
                           8, 4096)
      ->type_name("N")
      ->capture_default_str();
  app.add_option("-o,--output", o->work, "The folder to make")->type_name("WORK")->required();
  return [o](Session& session) { return plan(o->shape, o->axis, o->size, o->work, session); };
}

Action add_bricks_run(CLI::App& app) {
  struct Options {
    std::string work;
    std::optional<std::size_t> round;
    std::optional<BrickTask> task;
  };
  auto o = std::make_shared<Options>();
  add_work(app, o->work);
  add_parsed(
      app, "--round", "The round, from 1 [default: all, one after the other]",
      [o](const std::string& option, const std::string& text) { o->round = number_of<std::size_t>(option, text, 1); })
      ->type_name("R");
  add_parsed(
      app, "--task",
      "Only the bricks whose number is i modulo n, i from 0 [default: what SLURM, AWS Batch or Kubernetes say of "
      "an array of jobs, else all]",
      [o](const std::string& option, const std::string& text) { parse_task(option, text, o->task.emplace()); })
      ->type_name("i/n");
  return [o](Session& session) {
    if (!o->task) o->task = task_in_environment();
    BrickTask task = o->task.value_or(BrickTask{});
    task.round = o->round;
    return run_task(o->work, task, session);
  };
}

Action add_bricks_merge(CLI::App& app) {
  struct Options {
    std::string work, output;
  };
  auto o = std::make_shared<Options>();
  add_work(app, o->work);
  app.add_option("-o,--output", o->output, "The medial axis: .vtp .vtu .ply .obj .stl .ma .r .csv")
      ->type_name("FILE")
      ->required();
  return [o](Session& session) { return merge(o->work, o->output, session); };
}

Action add_bricks_status(CLI::App& app) {
  auto work = std::make_shared<std::string>();
  add_work(app, *work);
  return [work](Session& session) { return status(*work, session); };
}

}  // namespace quench::program
