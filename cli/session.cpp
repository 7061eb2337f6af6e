// SPDX-License-Identifier: Apache-2.0
#include "session.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <charconv>
#include <csignal>
#include <cstdio>
#include <fstream>

namespace quench::program {
namespace {

// The handler may only touch lock-free atomics; Context::cancel is one store.
std::atomic<Context*> interrupted_context{nullptr};

void interrupt(int signal) {
  if (Context* context = interrupted_context.load()) context->cancel();
  std::signal(signal, SIG_DFL);  // a second Ctrl-C ends at once
}

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
    throw Error(ErrorCode::usage, fmt::format("--memory-limit '{}' is not an amount of memory; give e.g. 8G or 500M", text));
  return static_cast<std::int64_t>(value * factor);
}

std::int64_t available_memory() {
  std::ifstream file("/proc/meminfo");
  std::string key, unit;
  std::int64_t value = 0;
  while (file >> key >> value) {
    std::getline(file, unit);
    if (key == "MemAvailable:") return value * 1024;
  }
  return static_cast<std::int64_t>(sysconf(_SC_PHYS_PAGES)) * sysconf(_SC_PAGESIZE);
}

std::string gigabytes(std::int64_t bytes) { return fmt::format("{:.3g} GB", static_cast<double>(bytes) / 0x1p30); }

}  // namespace

Session::Session(const CommonOptions& o) : options(o) {
  if (options.threads < 0) throw Error(ErrorCode::usage, fmt::format("--threads {} is negative; give 0 for all processors", options.threads));
  if (!options.memory_limit.empty()) parse_bytes(options.memory_limit);
  context.threads = options.threads;
  if (options.threads > 0)
    thread_limit_ = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                          static_cast<std::size_t>(options.threads));
  terminal_ = isatty(STDERR_FILENO) != 0;
  context.progress = [this](std::string_view stage, double fraction) { progress(stage, fraction); };
  context.note = [this](const std::string& sentence) { say("note: " + sentence); };
  interrupted_context = &context;
  std::signal(SIGINT, interrupt);
  std::signal(SIGTERM, interrupt);
}

Session::~Session() {
  interrupted_context = nullptr;
  clear_line();
}

void Session::check_output(const std::filesystem::path& output, const std::vector<std::filesystem::path>& inputs) const {
  namespace fs = std::filesystem;
  std::error_code ignored;
  for (const auto& input : inputs)
    if (fs::exists(output, ignored) && fs::equivalent(output, input, ignored))
      throw Error(ErrorCode::usage, fmt::format("the output {} is the input itself; give -o another name", output.string()));
  if (fs::is_directory(output, ignored))
    throw Error(ErrorCode::usage, fmt::format("the output {} is a folder; give -o a file name", output.string()));
  if (fs::exists(output, ignored) && !options.overwrite)
    throw Error(ErrorCode::usage, fmt::format("{} exists; give --overwrite to replace it", output.string()));
  const fs::path folder = output.has_parent_path() ? output.parent_path() : fs::path(".");
  if (!fs::is_directory(folder, ignored))
    throw Error(ErrorCode::failed, fmt::format("the folder {} does not exist; make it first", folder.string()));
  if (access(folder.c_str(), W_OK) != 0)
    throw Error(ErrorCode::failed, fmt::format("the folder {} cannot be written", folder.string()));
}

void Session::check_memory(std::int64_t bytes, const std::string& what) const {
  const bool limited = !options.memory_limit.empty();
  const std::int64_t limit = limited ? parse_bytes(options.memory_limit) : available_memory();
  if (bytes <= limit) return;
  throw Error(ErrorCode::failed,
              fmt::format("{} needs about {} of memory, {} {}; use a lower --resolution{}", what, gigabytes(bytes), gigabytes(limit),
                          limited ? "are allowed by --memory-limit" : "are free",
                          limited ? " or a larger --memory-limit" : ", or --memory-limit to try all the same"));
}

void Session::say(const std::string& line) {
  if (options.quiet) return;
  clear_line();
  fmt::print(stderr, "{}\n", line);
}

void Session::detail(const std::string& line) {
  if (options.verbose) say(line);
}

double Session::total_seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

std::int64_t Session::peak_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::int64_t>(usage.ru_maxrss) * 1024;
}

// The time since the last call belongs to the stage that reports now.
void Session::progress(std::string_view stage, double fraction) {
  const auto now = Clock::now();
  const auto seconds_since = [&](Clock::time_point t) { return std::chrono::duration<double>(now - t).count(); };
  seconds_[std::string(stage)] += seconds_since(last_);
  last_ = now;
  if (stage != stage_) {
    stage_ = stage;
    stage_start_ = now;
  }
  if (options.quiet) return;
  const bool ended = fraction >= 1;
  if (terminal_) {
    if (!ended && seconds_since(last_print_) < 0.1) return;
    last_print_ = now;
    if (ended) return clear_line();
    const int filled = static_cast<int>(fraction * 30);
    const double spent = seconds_since(stage_start_);
    const std::string eta = fraction > 0.02 && spent > 0.5 ? fmt::format("{:.0f} s left", spent / fraction * (1 - fraction)) : "";
    fmt::print(stderr, "\r{:<12} [{:<30}] {:3.0f}% {:<14}", stage_, std::string(static_cast<std::size_t>(filled), '#'), fraction * 100, eta);
    std::fflush(stderr);
    line_open_ = true;
  } else if (ended ? seconds_since(stage_start_) > 1 : seconds_since(last_print_) > 5) {
    // Plain lines: one per five seconds, and one at the end of every stage of more than a second.
    last_print_ = now;
    const double spent = seconds_since(stage_start_);
    if (ended)
      fmt::print(stderr, "{}: done in {:.1f} s\n", stage_, spent);
    else
      fmt::print(stderr, "{}: {:.0f}%{}\n", stage_, fraction * 100,
                 fraction > 0.02 ? fmt::format(", about {:.0f} s left", spent / fraction * (1 - fraction)) : "");
  }
}

void Session::clear_line() {
  if (!line_open_) return;
  fmt::print(stderr, "\r{:70}\r", "");
  line_open_ = false;
}

}  // namespace quench::program
