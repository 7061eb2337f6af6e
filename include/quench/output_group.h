// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

namespace quench::io {

/// Files that appear together. While a group lives, what its thread writes through write_atomically() (every writer of
/// the library does) stays in temporary files beside the real ones; commit() renames them all. Without commit(), e.g.
/// on an exception, they are removed, and every file is as it was. Groups do not nest.
class OutputGroup {
 public:
  OutputGroup();
  OutputGroup(const OutputGroup&) = delete;
  OutputGroup& operator=(const OutputGroup&) = delete;
  ~OutputGroup();

  /// Throws Error(failed) at the first file that cannot be renamed, naming it; files written before it are complete and
  /// in place, later ones as they were.
  void commit();

  /// Bytes of a file written in this group, or of the file of that name; 0 when there is none.
  std::uintmax_t size_of(const std::filesystem::path& file) const;

 private:
  friend struct PostponedRename;
  struct Pending {
    std::filesystem::path temporary, target, name;
    int place;  // of the name of the temporary file, for remove_temporary_files()
  };
  std::vector<Pending> pending_;
};

/// Removes the temporary files of all outputs that are not in place yet, of up to 64. For handlers of signals that end
/// the process at once: it neither allocates nor waits, and outputs being written are lost.
void remove_temporary_files() noexcept;

/// How far a process is with its outputs.
enum class Outputs {
  untouched,      ///< every file is as it was
  being_renamed,  ///< those of a group appear just now, one after the other
  in_place        ///< outputs have been put in their places
};

/// For who is about to end the process without waiting for its threads: from now on no output is renamed, and
/// committing or writing one throws Error(cancelled). Not while outputs are being renamed, which takes no time worth
/// mentioning: then it changes nothing, says so, and may be asked again.
Outputs stop_outputs() noexcept;

/// The file that writing to `file` replaces or makes: the one at the end of its links, which need not exist.
std::filesystem::path place_of_output(const std::filesystem::path& file);

}  // namespace quench::io
