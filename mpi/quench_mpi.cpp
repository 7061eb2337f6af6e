// SPDX-License-Identifier: Apache-2.0
// quench-mpi: the bricks of a plan by processes of MPI, which send each other their parts instead of leaving them in
// files.
#include <fmt/format.h>
#include <mpi.h>
#include <sched.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <new>
#include <string>
#include <string_view>
#include <vector>

#include "base/memory.h"
#include "base/text.h"
#include "quench/bricks.h"
#include "quench/error.h"
#include "quench/io.h"

namespace {

using namespace quench;

class MpiMessenger : public pipeline::Messenger {
 public:
  MpiMessenger() {
    int rank = 0, ranks = 1;
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &ranks);
    rank_ = static_cast<std::size_t>(rank);
    ranks_ = static_cast<std::size_t>(ranks);
  }
  std::size_t rank() const override { return rank_; }
  std::size_t ranks() const override { return ranks_; }

  std::vector<std::vector<std::string>> exchange(const std::vector<std::vector<std::string_view>>& to) override {
    std::vector<std::vector<std::string>> from = room_for_messages(to);
    std::vector<MPI_Request> requests;
    for (std::size_t r = 0; r < ranks_; ++r)
      for (std::string& message : from[r])
        in_pieces(message.size(), [&](std::size_t at, int size) {
          MPI_Irecv(message.data() + at, size, MPI_BYTE, static_cast<int>(r), 0, MPI_COMM_WORLD,
                    &requests.emplace_back());
        });
    for (std::size_t r = 0; r < ranks_; ++r)
      for (const std::string_view message : to[r])
        in_pieces(message.size(), [&](std::size_t at, int size) {
          MPI_Isend(message.data() + at, size, MPI_BYTE, static_cast<int>(r), 0, MPI_COMM_WORLD,
                    &requests.emplace_back());
        });
    MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
    return from;
  }

 private:
  // Counts of MPI are ints. Messages between two processes do not overtake each other.
  template <class Visit>
  static void in_pieces(std::size_t size, const Visit& visit) {
    constexpr std::size_t kPiece = std::size_t{1} << 30;
    for (std::size_t at = 0; at < size; at += kPiece) visit(at, static_cast<int>(std::min(kPiece, size - at)));
  }

  // Messages of the sizes that all processes send to this one.
  std::vector<std::vector<std::string>> room_for_messages(const std::vector<std::vector<std::string_view>>& to) const {
    std::vector<int> sent(ranks_), received(ranks_), sent_at(ranks_), received_at(ranks_);
    for (std::size_t r = 0; r < ranks_; ++r) sent[r] = static_cast<int>(to[r].size());
    MPI_Alltoall(sent.data(), 1, MPI_INT, received.data(), 1, MPI_INT, MPI_COMM_WORLD);
    std::vector<std::uint64_t> sizes;
    int all = 0;
    for (std::size_t r = 0; r < ranks_; ++r) {
      sent_at[r] = static_cast<int>(sizes.size());
      for (const std::string_view message : to[r]) sizes.push_back(message.size());
      received_at[r] = all;
      all += received[r];
    }
    std::vector<std::uint64_t> sizes_received(static_cast<std::size_t>(all));
    MPI_Alltoallv(sizes.data(), sent.data(), sent_at.data(), MPI_UINT64_T, sizes_received.data(), received.data(),
                  received_at.data(), MPI_UINT64_T, MPI_COMM_WORLD);
    std::vector<std::vector<std::string>> from(ranks_);
    auto size = sizes_received.begin();
    for (std::size_t r = 0; r < ranks_; ++r)
      for (int i = 0; i < received[r]; ++i) from[r].emplace_back(*size++, '\0');
    return from;
  }

  std::size_t rank_ = 0, ranks_ = 1;
};

// A process's share of the processors that those of its machine may use: MPI may bind each to some of them, or all to
// the same.
int fair_threads() {
  MPI_Comm machine = MPI_COMM_NULL;
  MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine);
  int processes = 1;
  MPI_Comm_size(machine, &processes);
  cpu_set_t own, all;
  CPU_ZERO(&own);
  sched_getaffinity(0, sizeof own, &own);
  MPI_Allreduce(&own, &all, sizeof own, MPI_BYTE, MPI_BOR, machine);
  MPI_Comm_free(&machine);
  return std::max(1, CPU_COUNT(&all) / processes);
}

struct Options {
  std::string work, output;
  int threads = 0;
  bool quiet = false, overwrite = false;
};

void check_output(const Options& o) {
  io::check_writable_format(o.output);
  std::error_code ignored;
  if (!o.overwrite && std::filesystem::exists(o.output, ignored))
    throw Error(ErrorCode::usage, fmt::format("'{}' exists; give --overwrite to replace it", o.output));
}

void work_on(const Options& o, MpiMessenger& messenger) {
  const bool first = messenger.rank() == 0;
  const auto say = [&](const std::string& line) {
    if (first && !o.quiet) std::fprintf(stderr, "%s\n", line.c_str());
  };
  Context context;
  const int fair = fair_threads();
  context.threads = o.threads > 0 ? o.threads : fair;
  pipeline::together(messenger, [&] {
    if (first) check_output(o);
  });
  say(fmt::format("{}, {} each", base::counted(messenger.ranks(), "process", "processes"),
                  base::counted(static_cast<std::size_t>(context.threads), "thread")));
  auto merged = pipeline::core_by_messages(
      o.work, messenger,
      [&](std::size_t round, std::size_t bricks) {
        say(fmt::format("round {}: {}", round, base::counted(bricks, "brick")));
      },
      &context);
  if (!merged) return;
  const auto kept = merged->core.kept;
  io::write_record(o.output, pipeline::core_file(std::move(merged->core)));
  say(fmt::format("{}: {} vertices, {} edges, {} faces; at most {} of memory in a process", o.output, kept.vertices,
                  kept.edges, kept.faces, base::bytes_text(merged->figures.peak_bytes)));
}

int parsed(CLI::App& app, int argc, char** argv, bool first) {
  try {
    app.parse(argc, argv);
    return -1;
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return first ? app.exit(error) : 0;  // --help
    if (first) std::fprintf(stderr, "quench-mpi: %s; see quench-mpi --help\n", error.what());
    return static_cast<int>(ErrorCode::usage);
  }
}

int run(int argc, char** argv) {
  MpiMessenger messenger;
  Options o;
  CLI::App app(
      "The core of a shape in bricks by processes of MPI, which send each other what they find. 'quench bricks plan' "
      "makes WORK; all processes read it, and nothing is written there.");
  app.add_option("WORK", o.work, "The folder that 'quench bricks plan' has made")->type_name("")->required();
  app.add_option("-o,--output", o.output, "The medial axis: .vtp .ply .obj .ma .r .csv")->type_name("FILE")->required();
  app.add_option("--threads", o.threads, "Threads of a process; 0: its share of the processors of its machine")
      ->type_name("N")
      ->check(CLI::Range(0, 256))
      ->capture_default_str();
  app.add_flag("--overwrite", o.overwrite, "Replace an existing output");
  app.add_flag("--quiet", o.quiet, "Say nothing but errors");
  app.footer("Example:\n  mpirun -n 8 quench-mpi WORK -o core.vtp");
  const bool first = messenger.rank() == 0;
  if (const int code = parsed(app, argc, argv, first); code >= 0) return code;
  try {
    work_on(o, messenger);
    return 0;
  } catch (const Error& error) {
    if (first) std::fprintf(stderr, "quench-mpi: %s\n", error.what());
    return static_cast<int>(error.code());
  } catch (const std::exception& error) {  // of this process alone: others may wait for it
    const bool memory = dynamic_cast<const std::bad_alloc*>(&error) != nullptr;
    std::fprintf(stderr, "quench-mpi: %s\n", memory ? "out of memory" : error.what());
    MPI_Abort(MPI_COMM_WORLD, static_cast<int>(ErrorCode::failed));
  }
  return static_cast<int>(ErrorCode::failed);
}

}  // namespace

int main(int argc, char** argv) {
  int threads_given = 0;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &threads_given);  // the main thread alone sends
  const int code = run(argc, argv);
  MPI_Finalize();
  return code;
}
