// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "quench/context.h"
#include "quench/pipeline.h"

/// @file
/// The core of a shape that one machine does not hold, in tasks that share a folder, WORK: plan_bricks() makes it,
/// any number of processes on any machines do run_bricks(), merge_bricks() makes the core of what they leave
/// there. The core is that of core_of(), to the byte of its file, however the work is divided (docs/user/bricks.md).
///
/// Work is done in rounds. A brick of the first round is a box of the shape, one of the second a box of four times the
/// side, of each further round of twice the side of the one before, made of those below it. What a task leaves there
/// appears at once, by a rename, and is the same whoever does it; so tasks may be killed, repeated, and done twice at
/// the same time.
namespace quench::pipeline {

inline constexpr std::int64_t kBrickSize = 512;  ///< voxels along a side of the boxes of the first round

/// What a brick or several of them took.
struct BrickFigures {
  double cpu_seconds = 0, seconds = 0;
  std::int64_t peak_bytes = 0;  ///< memory of the process until then; of several bricks the largest
  std::int64_t bytes_read = 0, bytes_written = 0;
};

struct RoundStatus {
  std::size_t bricks = 0, done = 0;
  BrickFigures figures;        ///< of those done
  std::size_t unfinished = 0;  ///< temporary files, of tasks at work or killed
};

struct BrickStatus {
  std::vector<RoundStatus> rounds;
  std::optional<BrickFigures> merge;  ///< where it was done
  std::string report;                 ///< as given to plan_bricks()
};

/// Makes the folder `work`, or finds in it what it would make: then it does nothing. `size`: kBrickSize or another
/// number of 8 or more. `report`: JSON text to be kept for the merge. Throws Error(usage), field `in_bricks`, for what
/// cannot be done in bricks, and Error(usage) for a folder with another plan or other files. Memory: that of the shape,
/// and a layer of 64 slices of its boundary vertices.
BrickStatus plan_bricks(const LoadedShape& shape, const AxisOptions& options, std::int64_t size,
                        const std::filesystem::path& work, const std::string& report, Context* context = nullptr);

/// Which bricks are done: those of a round whose number modulo `tasks` is `task`.
struct BrickTask {
  std::optional<std::size_t> round = {};  ///< from 1; none: all rounds in order, of one task
  std::size_t task = 0, tasks = 1;
};

struct BrickDone {
  std::size_t round = 0, rounds = 0;  ///< from 1
  std::size_t brick = 0, bricks = 0;  ///< from 0; of the round
  bool was_there = false;             ///< nothing was done
  BrickFigures figures;
};

/// Does bricks, one after the other, on the threads of the context; what is there is not done again. `on_brick` is
/// called after each. Throws Error(failed) when a brick of the round before is missing, Error(usage) for a round or
/// task that is not, and Error(input) for a folder that is no such plan, is of another version of Quench, or is
/// damaged, naming the file.
void run_bricks(const std::filesystem::path& work, const BrickTask& task,
                const std::function<void(const BrickDone&)>& on_brick = {}, Context* context = nullptr);

struct MergedBricks {
  CoreResult core;
  LoadedShape shape;   ///< without what only its file says
  std::string report;  ///< as given to plan_bricks()
  BrickFigures figures;
};

/// What is left when all rounds are done. Throws as run_bricks().
MergedBricks merge_bricks(const std::filesystem::path& work, Context* context = nullptr);
/// Writes down that the core is written.
void note_merged(const std::filesystem::path& work, const BrickFigures& figures);

/// How the processes of core_by_messages() reach each other. All of them call exchange() equally often.
class Messenger {
 public:
  Messenger() = default;
  Messenger(const Messenger&) = delete;
  Messenger& operator=(const Messenger&) = delete;
  virtual ~Messenger() = default;

  virtual std::size_t rank() const = 0;  ///< from 0
  virtual std::size_t ranks() const = 0;
  /// Sends the messages to[r] to rank r, for all ranks; answers with those that each has sent to this one. What is sent
  /// must stay until the answer.
  virtual std::vector<std::vector<std::string>> exchange(const std::vector<std::vector<std::string_view>>& to) = 0;
};

/// Does `work` on every process; where it fails on some, all throw the Error of the first of them.
void together(Messenger& messenger, const std::function<void()>& work);

/// The core by processes that send each other their parts: the whole on rank 0, nothing on the others. All read the
/// folder `work` of plan_bricks(), and nothing is written there. In each round the bricks with most sites come first,
/// each on another rank; a rank holds the parts it has made until no brick needs them any more, and what the others
/// have sent it for the brick it works on. `on_round`: called on every rank as a round of so many bricks begins.
/// `figures.peak_bytes` is that of the rank with most. Throws as run_bricks(), before the merge on all ranks alike.
std::optional<MergedBricks> core_by_messages(
    const std::filesystem::path& work, Messenger& messenger,
    const std::function<void(std::size_t round, std::size_t bricks)>& on_round = {}, Context* context = nullptr);

/// Throws Error(input) as run_bricks().
BrickStatus status_of_bricks(const std::filesystem::path& work);

}  // namespace quench::pipeline
