// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace quench::program {

/// Runs of this program as child processes. They ignore Ctrl-C and a closed terminal: this process ends them. They die
/// with it, also when it is killed, and at the end of the scope.
///
/// All functions are to be called from one thread, which must live as long as the object.
class BatchChildren {
 public:
  BatchChildren() = default;
  BatchChildren(const BatchChildren&) = delete;
  BatchChildren& operator=(const BatchChildren&) = delete;
  ~BatchChildren() { kill_all(); }

  /// Starts `quench words...`; what it says goes to the file `log`, replacing it. Throws Error(failed) when it cannot
  /// be started. `number` names it.
  void start(std::size_t number, const std::vector<std::string>& words, const std::filesystem::path& log);
  std::size_t count() const { return running_.size(); }
  /// Waits a moment (20 ms) where none has ended; calls `ended` with the number and the exit code, or 128 and the
  /// signal, of every child that has ended.
  void look(const std::function<void(std::size_t number, int code)>& ended);
  /// Ends all that run, and waits for them.
  void kill_all();

 private:
  std::map<pid_t, std::size_t> running_;
};

/// The sentence of a child that has failed: what it said last, or what became of it.
std::string sentence_of(int code, const std::filesystem::path& log);

}  // namespace quench::program
