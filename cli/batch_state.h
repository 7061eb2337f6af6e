// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

/// What the folder of a sample says about how it was made: `batch.json` in it.
namespace quench::program {

using Json = nlohmann::ordered_json;

/// How a sample stands. Its file is written twice: as `running` before the sample is worked on, which marks the folder
/// as one of a batch, and when it is done.
struct SampleState {
  enum class Status { running, ok, failed };
  Status status = Status::running;
  Json made_of;          ///< version, command, and the file with its size and time
  int code = 0;          ///< exit code, or 128 and the signal
  std::string sentence;  ///< of a failure
  double seconds = 0;
  std::vector<std::string> files;  ///< what it left in the folder; while it runs, what it may leave there

  friend bool operator==(const SampleState&, const SampleState&) = default;
};

/// What a result depends on. `words`: the command and its options; `out`: the folder of the batch, to which the place
/// of the file is relative, so that both can be moved together. Of a folder of slices, and of a header with its data in
/// files of the same name (.mhd, .nhdr), all files count.
Json made_of(const std::filesystem::path& file, const std::vector<std::string>& words,
             const std::filesystem::path& out);

/// Whether the folder is one of a batch.
bool has_state(const std::filesystem::path& folder);
/// Nothing where there is none, or none that can be read.
std::optional<SampleState> read_state(const std::filesystem::path& folder);
void write_state(const std::filesystem::path& folder, const SampleState& state);

/// Whether the state is that of a finished sample made of just this, with all of its files.
bool is_current(const std::optional<SampleState>& state, const Json& made_of, const std::filesystem::path& folder);

/// Whether to try once more would be in vain: the input or the options are at fault, not memory, disk or a signal.
bool is_final(const SampleState& state);

/// These files and those that `quench tree` or `quench run` may write, sorted: what a run that is killed may leave.
std::vector<std::string> with_expected_files(std::vector<std::string> files, const std::string& command);

/// Names and times of the files in a folder, sorted, for written_since().
using FilesWithTimes = std::vector<std::pair<std::string, std::filesystem::file_time_type>>;
FilesWithTimes files_with_times(const std::filesystem::path& folder);
/// The files in it that are new or were written since then, but for the state; sorted.
std::vector<std::string> written_since(const FilesWithTimes& before, const std::filesystem::path& folder);

/// Removes what an earlier try left: the files its state names, and temporary ones.
void remove_leavings(const std::filesystem::path& folder, const std::vector<std::string>& files);

}  // namespace quench::program
