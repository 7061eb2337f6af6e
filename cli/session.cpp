// SPDX-License-Identifier: Apache-2.0
#include "session.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "base/platform/streams.h"
#include "base/platform/system_files.h"
#include "printable.h"
#include "quench/io.h"

namespace quench::program {
namespace {

std::int64_t parse_bytes(const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const std::string unit(end, text.data() + text.size());
  double factor = 0;
  if (unit.empty() || unit == "B") factor = 1;
  if (unit == "K" || unit == "KB" || unit == "k") factor = 0x1p10;
  if (unit == "M" || unit == "MB") factor = 0x1p20;
  if (unit == "G" || unit == "GB") factor = 0x1p30;
  if (unit == "T" || unit == "TB") factor = 0x1p40;
  if (error != std::errc() || !(value > 0) || factor == 0 || value * factor > 0x1p60)
    throw Error(ErrorCode::usage,
                fmt::format("--memory-limit '{}' is not an amount of memory; give e.g. 8G or 500M", text));
  return static_cast<std::int64_t>(value * factor);
}

/// Whether a path leads into a folder, which need not exist.
bool is_inside(const std::filesystem::path& path, const std::filesystem::path& folder) {
  std::error_code ignored;
  for (std::filesystem::path up = std::filesystem::weakly_canonical(path, ignored); up.has_relative_path();) {
    up = up.parent_path();
    if (std::filesystem::equivalent(up, folder, ignored)) return true;
  }
  return false;
}

void check_no_input(const std::filesystem::path& output, const std::vector<std::filesystem::path>& inputs,
                    const std::string& option) {
  std::error_code ignored;
  for (const auto& input : inputs)
    if (std::filesystem::equivalent(output, input, ignored))
      throw Error(ErrorCode::usage,
                  fmt::format("the output '{}' is the input itself; give {} another name", output.string(), option));
    else if (io::is_zarr_name(output) && is_inside(input, output))
      throw Error(ErrorCode::usage, fmt::format("the input '{}' lies in the output '{}'; give {} another name",
                                                input.string(), output.string(), option));
}

void check_one_output(const std::filesystem::path& output, const std::vector<std::filesystem::path>& inputs,
                      const std::string& option, bool overwrite) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  const std::string name = output.string();
  if (name.empty())
    throw Error(ErrorCode::usage, fmt::format("the name of the output is empty; give {} a file name", option));
  check_no_input(output, inputs, option);
  const bool zarr = io::is_zarr_name(output);
  if (fs::is_directory(output, ignored) && !zarr)
    throw Error(ErrorCode::usage, fmt::format("the output '{}' is a folder; give a file name", name));
  std::error_code unknown;
  const fs::file_status status = fs::status(output, unknown);
  if (unknown == std::errc::too_many_symbolic_link_levels && fs::is_symlink(output, ignored))
    check_link(output, option);
  // A link is there also when what it points to is not.
  if (fs::exists(fs::symlink_status(output, ignored)) && !overwrite)
    throw Error(ErrorCode::usage, fmt::format("'{}' exists; give --overwrite to replace it", name));
  const auto cannot = [&](const std::string& reason) {
    throw Error(ErrorCode::failed, fmt::format("cannot write '{}': {}", name, reason));
  };
  if (zarr) {
    io::check_zarr_output(output);
  } else if (fs::exists(status) && !fs::is_regular_file(status)) {  // a pipe or a device is written to, not replaced
    if (const int error = base::writing_error(output)) cannot(std::strerror(error));
    return;
  }
  const fs::path target = io::place_of_output(output.has_filename() ? output : output.parent_path());
  const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
  check_name_length(output);
  if (!fs::exists(folder, ignored))
    cannot(fmt::format("the folder '{}' does not exist; create it first", folder.string()));
  if (!fs::is_directory(folder, ignored)) cannot(fmt::format("'{}' is not a folder", folder.string()));
  if (const int error = base::creation_error(folder))
    cannot(fmt::format("the folder '{}' is not writable: {}", folder.string(), std::strerror(error)));
}

}  // namespace

bool is_same_place(const std::filesystem::path& a, const std::filesystem::path& b) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  return fs::weakly_canonical(fs::absolute(a, ignored), ignored) ==
         fs::weakly_canonical(fs::absolute(b, ignored), ignored);
}

void check_distinct(const std::vector<std::string>& outputs) {
  for (std::size_t i = 0; i < outputs.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (!outputs[i].empty() && !outputs[j].empty() && is_same_place(outputs[i], outputs[j]))
        throw Error(ErrorCode::usage, fmt::format("two outputs are named '{}'; give them different names", outputs[i]));
}

void check_link(const std::filesystem::path& link, const std::string& option) {
  namespace fs = std::filesystem;
  std::error_code error, ignored;
  if (!fs::is_symlink(link, ignored) || fs::exists(link, error)) return;
  if (error == std::errc::too_many_symbolic_link_levels)
    throw Error(ErrorCode::usage,
                fmt::format("'{}' is a link that leads to itself; give {} another name", link.string(), option));
  throw Error(ErrorCode::usage,
              fmt::format("'{}' is a link to '{}', which does not exist; create that folder or give {} another name",
                          link.string(), fs::read_symlink(link, ignored).string(), option));
}

void check_name_length(const std::filesystem::path& output) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  fs::path existing = fs::absolute(output, ignored);
  const bool whole = existing.native().size() < base::kLongestPath;
  while (existing.has_relative_path() && !fs::exists(existing, ignored)) existing = existing.parent_path();
  const std::size_t most = base::longest_name_in(existing);
  for (const fs::path& part : output)
    if (!whole || (most > 0 && part.native().size() > most))
      throw Error(ErrorCode::usage,
                  fmt::format("cannot write '{}': the name is too long for this file system; give a shorter one",
                              output.string()));
}

void finish_results() {
  if (std::fflush(stdout) != 0 || std::ferror(stdout))
    throw Error(ErrorCode::failed,
                fmt::format("cannot write to stdout: {}", errno ? std::strerror(errno) : "an earlier write failed"));
}

Session::Session(const CommonOptions& o) : options(o) {
  if (!options.memory_limit.empty()) context.memory_limit = parse_bytes(options.memory_limit);
  context.threads = options.threads;
  if (options.threads > 0)
    thread_limit_ = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                          static_cast<std::size_t>(options.threads));
  terminal_ = base::stderr_is_terminal();
  context.progress = [this](std::string_view stage, double fraction) { progress(stage, fraction); };
  context.note = [this](const std::string& sentence) { say("note: " + sentence); };
  interrupts_.emplace(context);
}

Session::~Session() { clear_line(); }

void Session::check_output(const std::filesystem::path& output, const std::vector<std::filesystem::path>& inputs,
                           const std::string& option) const {
  check_one_output(output, inputs, option, options.overwrite);
  check_report(inputs);
  if (!options.report.empty() && options.report != "-" && is_same_place(options.report, output))
    throw Error(
        ErrorCode::usage,
        fmt::format("--json names the same file as another output, '{}'; give it another name", options.report));
}

void Session::check_report(const std::vector<std::filesystem::path>& inputs) const {
  if (!options.report.empty() && options.report != "-")
    check_one_output(options.report, inputs, "--json", options.overwrite);
}

// Straight to the stream: nobody can be told when stderr itself fails, and the result does not depend on it.
void Session::complain(const std::string& text) const { std::fwrite(text.data(), 1, text.size(), stderr); }

void Session::say(const std::string& line) {
  if (options.quiet) return;
  if (options.module) {  // what is on stderr is an error to Slicer
    std::string text = line;
    const std::string& folder = options.module_folder;
    if (!folder.empty())
      for (std::size_t at = text.find(folder); at != text.npos; at = text.find(folder)) text.erase(at, folder.size());
    return answer_line(text);
  }
  clear_line();
  complain(printable(line) + "\n");
}

void Session::answer_line(const std::string& line) { answer(printable(line) + "\n"); }

void Session::answer(const std::string& text) {
  clear_line();
  if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size()) finish_results();
}

void Session::finished(std::string_view stage) { progress(stage, 1); }

void Session::detail(const std::string& line) {
  if (options.verbose) say(line);
}

double Session::total_seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

std::int64_t Session::peak_bytes() { return base::peak_memory(); }

// The time since the last call belongs to the stage that reports now.
void Session::progress(std::string_view stage, double fraction) {
  const auto now = Clock::now();
  const auto seconds_since = [&](Clock::time_point t) { return std::chrono::duration<double>(now - t).count(); };
  seconds_[std::string(stage)] += seconds_since(last_);
  last_ = now;
  const bool new_stage = stage != stage_;
  if (new_stage) {
    stage_ = stage;
    stage_start_ = now;
  }
  if (options.quiet) return;
  const bool ended = fraction >= 1;
  if (options.module) {
    if (!new_stage && !ended && seconds_since(last_print_) < 0.1) return;
    last_print_ = now;
    return tell_slicer(fraction, new_stage);
  }
  if (ended && stage == ended_stage_) return;  // said already
  ended_stage_ = ended ? std::string(stage) : std::string();
  if (terminal_) {
    if (!ended && seconds_since(last_print_) < 0.1) return;
    last_print_ = now;
    if (ended) return clear_line();
    const int filled = static_cast<int>(fraction * 30);
    const double spent = seconds_since(stage_start_);
    const std::string eta =
        fraction > 0.02 && spent > 0.5 ? fmt::format("{:.0f} s left", spent / fraction * (1 - fraction)) : "";
    complain(fmt::format("\r{:<12} [{:<30}] {:3.0f}% {:<14}", stage_,
                         std::string(static_cast<std::size_t>(filled), '#'), fraction * 100, eta));
    std::fflush(stderr);
    line_open_ = true;
  } else if (ended ? seconds_since(stage_start_) > 1 : seconds_since(last_print_) > 5) {
    // Plain lines: one per five seconds, and one at the end of every stage of more than a second.
    last_print_ = now;
    const double spent = seconds_since(stage_start_);
    if (ended)
      complain(fmt::format("{}: done in {:.1f} s\n", stage_, spent));
    else
      complain(
          fmt::format("{}: {:.0f}%{}\n", stage_, fraction * 100,
                      fraction > 0.02 ? fmt::format(", about {:.0f} s left", spent / fraction * (1 - fraction)) : ""));
  }
}

// How far all is when a stage is on its way: about what stages take of a volume of a few million voxels.
void Session::tell_slicer(double fraction, bool new_stage) {
  struct Share {
    const char* stage;
    double begin, end;
  };
  constexpr Share kShares[] = {{"read", 0, 0.05},       {"voxelize", 0.05, 0.1}, {"delaunay", 0.1, 0.3},
                               {"detail", 0.3, 0.4},    {"burn", 0.4, 0.6},      {"curves", 0.6, 0.65},
                               {"skeleton", 0.65, 0.8}, {"repair", 0.7, 0.8},    {"thickness", 0.5, 0.9},
                               {"surface", 0.5, 0.9},   {"page", 0.8, 0.95},     {"write", 0.95, 1}};
  for (const Share& share : kShares)
    if (stage_ == share.stage)
      overall_ = std::max(overall_, share.begin + std::clamp(fraction, 0.0, 1.0) * (share.end - share.begin));
  std::string text;
  if (new_stage) text += fmt::format("<filter-comment>{}</filter-comment>\n", stage_);
  text +=
      fmt::format("<filter-progress>{:.4f}</filter-progress>\n<filter-stage-progress>{:.4f}</filter-stage-progress>\n",
                  overall_, fraction);
  answer(text);
  std::fflush(stdout);
}

void Session::clear_line() {
  if (!line_open_) return;
  complain(fmt::format("\r{:70}\r", ""));
  std::fflush(stderr);
  line_open_ = false;
}

}  // namespace quench::program
