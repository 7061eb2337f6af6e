// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <tbb/global_control.h>

#include <chrono>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/memory.h"
#include "interrupts.h"
#include "quench/context.h"

namespace quench::program {

/// Options every subcommand has.
struct CommonOptions {
  int threads = 0;
  std::string memory_limit;
  std::string report;
  std::string units;               ///< of the input, as results name it; empty: as the file says
  std::string command;             ///< the line that started the program, for results that say how they were made
  std::vector<std::string> words;  ///< of a batch: what stands behind its "--"
  bool quiet = false, verbose = false, overwrite = false;
  bool module = false;        ///< of 3D Slicer: progress and notes go to stdout, in its format
  std::string module_folder;  ///< of files that go with it: its name is left out of what is said
};

/// One run of the program: its context (progress on stderr, notes, Ctrl-C), its clock per stage, its outputs.
class Session {
 public:
  explicit Session(const CommonOptions& options);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  Context context;
  CommonOptions options;

  /// Refuses, before any work is done, an output that exists (unless --overwrite), that is an input, or whose folder
  /// cannot be written. `option` is what names it. Also the file of --json.
  void check_output(const std::filesystem::path& output, const std::vector<std::filesystem::path>& inputs,
                    const std::string& option = "-o") const;
  /// The file of --json, for commands that write nothing else (check_output() includes it).
  void check_report(const std::vector<std::filesystem::path>& inputs) const;
  /// What the caller asked for, on stdout; progress is cleared first. Throws Error(failed) when it cannot be written.
  void answer(const std::string& text);
  /// One line of it, in which names and texts of files may stand: made printable, and ended.
  void answer_line(const std::string& line);
  /// The time since the last report belongs to `stage`. Unlike checkpoint() never throws: for work that is done.
  void finished(std::string_view stage);
  /// A line on stderr, made printable: notes always, unless --quiet; details with --verbose only.
  void say(const std::string& line);
  void detail(const std::string& line);

  /// Seconds per stage so far, by the stage names of the progress callback.
  const std::map<std::string, double>& seconds() const { return seconds_; }
  double total_seconds() const;
  static std::int64_t peak_bytes();

 private:
  void progress(std::string_view stage, double fraction);
  void tell_slicer(double fraction, bool new_stage);
  void complain(const std::string& text) const;
  void clear_line();

  using Clock = std::chrono::steady_clock;
  Clock::time_point start_ = Clock::now(), last_ = start_, stage_start_ = start_, last_print_ = start_;
  std::string stage_, ended_stage_;
  bool terminal_ = false, line_open_ = false;
  double overall_ = 0;  ///< of all stages, as modules say it
  std::map<std::string, double> seconds_;
  std::optional<Interrupts> interrupts_;
  std::unique_ptr<tbb::global_control> thread_limit_;
};

/// Whether two paths name one file, which need not exist.
bool is_same_place(const std::filesystem::path& a, const std::filesystem::path& b);
/// Throws Error(usage) when two of the outputs are one file. Empty names are of no output.
void check_distinct(const std::vector<std::string>& outputs);
/// Throws Error(usage) for a link that leads to itself or to what does not exist. `option` is what names it.
void check_link(const std::filesystem::path& link, const std::string& option);
/// Throws Error(usage) when the system has no room for such a name.
void check_name_length(const std::filesystem::path& output);

/// Throws Error(failed) unless all answers have reached stdout (e.g. its disk is full).
void finish_results();

}  // namespace quench::program
