// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <map>
#include <memory>
#include <set>

#include "base/memory.h"
#include "base/platform/system_files.h"
#include "base/text.h"
#include "batch_children.h"
#include "batch_page.h"
#include "batch_samples.h"
#include "batch_state.h"
#include "batch_tables.h"
#include "option_checks.h"
#include "program.h"
#include "run_command.h"

namespace quench::program {
namespace {

namespace fs = std::filesystem;

struct BatchOptions {
  std::vector<std::string> inputs;
  std::string out;
  int jobs = 1;
  std::size_t shard = 0, shards = 1;
  bool again = false, collect = false;
};

/// Marks a folder as that of a batch; who collects its tables holds a lock on it.
constexpr const char* kMarkFile = ".quench-batch";

struct BatchPlan {
  BatchResults results;
  std::vector<std::string> words;                  ///< the command and the options for all samples
  std::vector<std::vector<std::string>> words_of;  ///< per sample, with its own options
  std::vector<Json> made_of;                       ///< per sample
  std::vector<std::size_t> mine;                   ///< the samples of this shard
  const BatchInput& input() const { return results.input; }
};

// --------------------------------------------------------------------------------------------------------------- plan

/// The command and its options, of what stands behind "--".
std::vector<std::string> command_words(std::vector<std::string> words) {
  if (words.empty() || words[0].starts_with('-')) words.insert(words.begin(), "tree");
  if (words[0] != "tree" && words[0] != "run")
    throw Error(ErrorCode::usage,
                fmt::format("behind '--' stand 'tree' or 'run' and their options; '{}' is neither", words[0]));
  return words;
}

/// Options that `batch` gives itself.
void refuse_own_options(const std::vector<std::string>& words, const std::string& where) {
  for (const std::string& word : words) {
    const std::string name = word.substr(0, word.find('='));
    if (word.starts_with("-o") || name == "--output")
      throw Error(ErrorCode::usage, fmt::format("{}leave out {}: every sample has its folder", where, name));
    for (const char* common : {"--threads", "--memory-limit", "--overwrite"})
      if (name == common)
        throw Error(ErrorCode::usage,
                    fmt::format("{}give {} before the '--': it is for all of the batch", where, name));
    if (name == "--json")
      throw Error(ErrorCode::usage, fmt::format("{}leave out --json: every sample has its report.json", where));
    for (const char* answered : {"--help", "-h", "--version", "--xml"})  // without a sample
      if (name == answered)
        throw Error(ErrorCode::usage,
                    fmt::format("{}leave out {}: it asks about the program and measures nothing", where, name));
  }
}

/// The command line of a sample; its options last, so that one without its value is not given what follows.
std::vector<std::string> line_of(const BatchPlan& plan, std::size_t sample,
                                 const std::vector<std::string>& more_options = {}) {
  std::vector<std::string> words = plan.words_of[sample];
  const std::string file = plan.input().samples[sample].file.string();
  std::vector<std::string> own{file.starts_with('-') ? "./" + file : file, "-o",
                               plan.results.folder_of(sample).string(), "--overwrite"};
  own.insert(own.end(), more_options.begin(), more_options.end());
  words.insert(words.begin() + 1, own.begin(), own.end());
  return words;
}

/// Whether the options can be: told before all work, not by every sample.
void check_options(const BatchPlan& plan) {
  refuse_own_options(plan.words, "");
  std::set<std::vector<std::string>> checked;
  for (const std::size_t i : plan.mine) {
    const BatchSample& sample = plan.input().samples[i];
    if (!checked.insert(sample.options).second) continue;
    const std::string where = sample.options.empty() ? "" : fmt::format("options of '{}': ", sample.name);
    refuse_own_options(sample.options, where);
    try {
      check_command(line_of(plan, i));
    } catch (const Error& error) {
      throw Error(error.code(), where + error.what());
    }
  }
}

BatchPlan plan_batch(const BatchOptions& o, const Session& session) {
  BatchPlan plan;
  plan.words = command_words(session.options.words);
  plan.results.out = o.out;
  plan.results.command = plan.words[0];
  plan.results.input = read_batch(o.inputs, plan.words[0] == "tree");
  const std::size_t count = plan.input().samples.size();
  plan.results.states.resize(count);
  for (std::size_t i = o.shard; i < count; i += o.shards) plan.mine.push_back(i);
  for (const BatchSample& sample : plan.input().samples)
    plan.words_of.push_back(sample.options.empty() ? plan.words : with_own_options(plan.words, sample.options));
  check_options(plan);
  for (std::size_t i = 0; i < count; ++i)
    plan.made_of.push_back(made_of(plan.input().samples[i].file, plan.words_of[i], o.out));
  return plan;
}

// ------------------------------------------------------------------------------------------------------------ outputs

/// Whether a folder is empty, but for temporary files of Quench.
bool is_empty_folder(const fs::path& folder) {
  return std::ranges::all_of(fs::directory_iterator(folder), [](const fs::directory_entry& entry) {
    return entry.path().filename().string().starts_with(".quench-");
  });
}

void check_batch_outputs(const BatchOptions& o, const BatchPlan& plan, const Session& session) {
  check_folder(o.out);
  std::error_code ignored;
  for (const std::string& input : o.inputs)
    if (fs::is_directory(input, ignored) && is_same_place(input, o.out))
      throw Error(ErrorCode::usage,
                  fmt::format("-o names the folder of the samples, '{}'; give it another one", o.out));
  const auto refuse = [&](const fs::path& there) {
    throw Error(ErrorCode::usage, fmt::format("'{}' exists and is not of a batch; give -o another folder, or "
                                              "--overwrite to replace it",
                                              there.string()));
  };
  if (!fs::exists(fs::path(o.out) / kMarkFile, ignored))
    for (const char* file : {"samples.csv", joined_file(plan.results.command), "index.html"})
      if (fs::exists(fs::path(o.out) / file, ignored) && !session.options.overwrite) refuse(fs::path(o.out) / file);
  for (const std::size_t i : plan.mine) {
    const fs::path folder = plan.results.folder_of(i);
    check_name_length(folder / "branches.csv");
    if (!fs::exists(folder, ignored)) continue;
    if (!fs::is_directory(folder, ignored))
      throw Error(ErrorCode::usage, fmt::format("'{}' is not a folder; give -o another one", folder.string()));
    if (!has_state(folder) && !is_empty_folder(folder) && !session.options.overwrite) refuse(folder);
  }
}

/// Held while the tables are collected: shards that end at the same time do it one after the other, and the last one
/// sees the results of all.
base::FileLock lock_of_batch(const fs::path& out) {
  base::FileLock lock = base::FileLock::wait_for(out / kMarkFile);
  if (const int error = lock.error())
    throw Error(ErrorCode::failed,
                fmt::format("cannot write '{}': {}", (out / kMarkFile).string(), std::strerror(error)));
  return lock;
}

// --------------------------------------------------------------------------------------------------------------- work

/// What a job may use, as options.
std::vector<std::string> share_of_machine(int jobs, const Session& session) {
  const int threads = std::max(1, tbb::this_task_arena::max_concurrency() / jobs);
  std::vector<std::string> words{"--threads", std::to_string(threads)};
  const std::int64_t limit = session.context.memory_limit;
  if (limit > 0 || jobs > 1) {
    const std::int64_t bytes = (limit > 0 ? limit : base::available_memory()) / jobs;
    words.insert(words.end(), {"--memory-limit", std::to_string(std::max<std::int64_t>(bytes, 1))});
  }
  return words;
}

/// Works on samples, some at a time.
class BatchWork {
 public:
  BatchWork(const BatchPlan& plan, std::vector<std::size_t> samples, int jobs, Session& session)
      : plan_(plan),
        samples_(std::move(samples)),
        jobs_(static_cast<std::size_t>(std::clamp<std::int64_t>(jobs, 1, std::ssize(samples_)))),
        share_(share_of_machine(static_cast<int>(jobs_), session)),
        session_(session) {
    for (const std::size_t i : samples_) found_[i] = read_state(plan_.results.folder_of(i));
  }

  /// Throws Error(cancelled) when it is interrupted; what is done then stays.
  void run() {
    std::size_t next = 0, done = 0, elsewhere = 0;
    while (next < samples_.size() || children_.count() > 0) {
      if (session_.context.cancelled()) return stop(done);
      while (next < samples_.size() && children_.count() < jobs_)
        if (!start(samples_[next++])) ++done, ++elsewhere;
      children_.look([&](std::size_t sample, int code) {
        finish(sample, code);
        ++done;
      });
      session_.context.progress("samples", static_cast<double>(done) / static_cast<double>(samples_.size()));
    }
    if (elsewhere > 0)
      session_.say(fmt::format("note: {} left to another run of this batch, which works on it or has just done it",
                               base::counted(elsewhere, "sample")));
  }

 private:
  struct Started {
    std::unique_ptr<base::FileLock> lock;  ///< another run of the batch leaves the sample out
    SampleState state;
    FilesWithTimes before;
    std::chrono::steady_clock::time_point time = std::chrono::steady_clock::now();
  };

  /// False where another run works on the sample, or has finished it since this one looked.
  bool start(std::size_t i) {
    const fs::path folder = plan_.results.folder_of(i);
    create_folder(folder.string());
    auto lock = std::make_unique<base::FileLock>(base::FileLock::try_folder(folder));
    if (lock->elsewhere()) return false;
    const auto earlier = read_state(folder);
    if (earlier != found_[i] && is_current(earlier, plan_.made_of[i], folder)) return false;
    Started& started = started_[i];
    started.lock = std::move(lock);
    const std::vector<std::string> old = earlier ? earlier->files : std::vector<std::string>();
    started.state.made_of = plan_.made_of[i];
    started.state.files = with_expected_files(old, plan_.results.command);  // a run that is killed leaves some of them
    write_state(folder, started.state);
    remove_leavings(folder, old);
    started.before = files_with_times(folder);
    children_.start(i, line_of(plan_, i, share_), folder / "log.txt");
    return true;
  }

  void finish(std::size_t i, int code) {
    const fs::path folder = plan_.results.folder_of(i);
    const Started& started = started_.at(i);
    SampleState state = started.state;
    state.code = code;
    state.status = code == 0 ? SampleState::Status::ok : SampleState::Status::failed;
    if (code != 0) state.sentence = sentence_of(code, folder / "log.txt");
    state.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - started.time).count();
    state.files = written_since(started.before, folder);
    write_state(folder, state);
    started_.erase(i);
    const std::string& name = plan_.input().samples[i].name;
    if (code != 0)
      session_.say(fmt::format("{}: failed: {}", name, state.sentence));
    else
      session_.detail(fmt::format("{}: done in {:.1f} s", name, state.seconds));
  }

  [[noreturn]] void stop(std::size_t done) {
    children_.kill_all();
    for (const auto& [i, started] : started_) remove_leavings(plan_.results.folder_of(i), {});
    throw Error(ErrorCode::cancelled,
                fmt::format("interrupted; {} of {} {} done, and the same command does the rest", done,
                            base::counted(samples_.size(), "sample"), done == 1 ? "is" : "are"));
  }

  const BatchPlan& plan_;
  std::vector<std::size_t> samples_;
  std::size_t jobs_;
  std::vector<std::string> share_;
  Session& session_;
  std::map<std::size_t, std::optional<SampleState>> found_;  ///< how the samples stood when this run looked
  std::map<std::size_t, Started> started_;
  BatchChildren children_;
};

/// The samples of this shard that are not done, or that failed for a reason that may have gone.
std::vector<std::size_t> samples_to_do(const BatchPlan& plan, bool again) {
  std::vector<std::size_t> samples;
  for (const std::size_t i : plan.mine) {
    const fs::path folder = plan.results.folder_of(i);
    const auto state = read_state(folder);
    const bool failed = state && state->status == SampleState::Status::failed;
    if (!is_current(state, plan.made_of[i], folder) || !is_final(*state) || (failed && again)) samples.push_back(i);
  }
  return samples;
}

void work(const BatchOptions& o, const BatchPlan& plan, Session& session) {
  const std::vector<std::size_t> samples = samples_to_do(plan, o.again);
  const std::size_t done = plan.mine.size() - samples.size();
  session.say(fmt::format("{}{}{}", base::counted(plan.input().samples.size(), "sample"),
                          o.shards > 1 ? fmt::format(", {} of them in this shard", plan.mine.size()) : "",
                          done > 0 ? fmt::format("; {} done already, {} to do", done, samples.size()) : ""));
  if (!samples.empty()) BatchWork(plan, samples, o.jobs, session).run();
}

// ------------------------------------------------------------------------------------------------------------ results

/// Where samples differ in what is down, their depths and angles cannot be compared.
void say_where_down_differs(const SampleTable& table, Session& session) {
  const auto column = std::ranges::find(table.header, "down");
  if (column == table.header.end()) return;
  std::map<std::string, std::vector<std::string>> names;  // of the samples, by direction
  for (const CsvRow& row : table.rows)
    if (const std::string& down = row[static_cast<std::size_t>(column - table.header.begin())]; !down.empty())
      names[down].push_back(row.front());
  if (names.size() < 2) return;
  std::vector<std::string> texts;
  for (const auto& [down, samples] : names)
    texts.push_back(fmt::format("{} of {} ('{}'{})", down, base::counted(samples.size(), "sample"), samples.front(),
                                samples.size() > 1 ? " ..." : ""));
  session.say(
      fmt::format("note: down is {}; --down says it for all, or in a list for each", fmt::join(texts, " and ")));
}

void collect(BatchPlan& plan, Session& session) {
  BatchResults& results = plan.results;
  const base::FileLock lock = lock_of_batch(results.out);
  for (std::size_t i = 0; i < results.states.size(); ++i) {
    results.states[i] = read_state(results.folder_of(i));
    if (!is_current(results.states[i], plan.made_of[i], results.folder_of(i))) results.states[i].reset();
  }
  find_damaged(results);
  const SampleTable table = table_of(results);
  write_table(results.out / "samples.csv", table);
  const std::size_t rows = write_joined(results);
  std::vector<std::string> line = plan.words;
  line.insert(line.begin() + 1, "FILE");
  write_contact_sheet(results.out / "index.html", results, table, command_text(line));
  session.say(fmt::format("{}: {}; {}: {}", (results.out / "samples.csv").string(),
                          base::counted(table.rows.size(), "row"), joined_file(results.command),
                          base::counted(rows, "row")));
  say_where_down_differs(table, session);
  session.say(fmt::format("{}: the contact sheet; open it in a browser", (results.out / "index.html").string()));
}

/// Ends a batch in which samples of this shard failed, or are not there though they should.
void complain_of(const BatchPlan& plan, const std::string& status) {
  constexpr std::size_t kMost = 10;
  std::string names;
  std::size_t count = 0;
  for (const std::size_t i : plan.mine) {
    if (plan.results.status_of(i) != status) continue;
    if (++count <= kMost) names += fmt::format("{}'{}'", count > 1 ? ", " : "", plan.input().samples[i].name);
  }
  if (count == 0) return;
  if (count > kMost) names += fmt::format(" and {} more", count - kMost);
  const std::string of = fmt::format("{} of {}", count, base::counted(plan.mine.size(), "sample"));
  throw Error(ErrorCode::failed, status == "failed" ? fmt::format("{} failed: {}; '{}' says why", of, names,
                                                                  (plan.results.out / "samples.csv").string())
                                                    : fmt::format("{} {} not done, or with other options or files: {}",
                                                                  of, count == 1 ? "is" : "are", names));
}

int batch(const BatchOptions& o, Session& session) {
  BatchPlan plan = plan_batch(o, session);
  check_batch_outputs(o, plan, session);
  create_folder(o.out);
  lock_of_batch(o.out);
  if (!o.collect) work(o, plan, session);
  collect(plan, session);
  complain_of(plan, "failed");
  complain_of(plan, "missing");
  return 0;
}

/// "2/8": the second of eight.
void parse_shard(const std::string& option, const std::string& text, BatchOptions& o) {
  const std::size_t slash = text.find('/');
  std::size_t i = 0, n = 0;
  if (slash == text.npos || !is_number(std::string_view(text).substr(0, slash), i) ||
      !is_number(std::string_view(text).substr(slash + 1), n) || i < 1 || i > n)
    throw Error(ErrorCode::usage, fmt::format("{} '{}' is not a part such as 2/8, from 1/8 to 8/8", option, text));
  o.shard = i - 1;
  o.shards = n;
}

}  // namespace

Action add_batch(CLI::App& app) {
  auto o = std::make_shared<BatchOptions>();
  app.add_option("INPUT", o->inputs,
                 "A folder with a file or a folder of slices per sample, shapes, a 'pattern*', or a list: .txt with a "
                 "path per line, .csv or .tsv with the paths in its first column")
      ->type_name("")
      ->required();
  app.add_option(
         "-o,--output", o->out,
         "Folder for a folder per sample, samples.csv, axes.csv (of 'run' branches.csv) and index.html; created "
         "if absent")
      ->type_name("OUT")
      ->required();
  add_number(app, "--jobs", o->jobs, "Samples at a time, up to 256; threads and memory are divided among them", 1, 256)
      ->type_name("N")
      ->capture_default_str();
  add_parsed(app, "--shard", "Only every n-th sample, from the i-th on: for n machines that share OUT",
             [o](const std::string& option, const std::string& text) { parse_shard(option, text, *o); })
      ->type_name("I/N");
  app.add_flag("--again", o->again, "Try all again that failed, also those whose input or options were at fault");
  app.add_flag("--collect", o->collect, "Only make the tables and the contact sheet of what is done");
  return [o](Session& session) { return batch(*o, session); };
}

}  // namespace quench::program
