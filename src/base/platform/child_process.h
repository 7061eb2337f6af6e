// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "quench/context.h"

namespace quench::base {

/// Processor time and address space of a reader in a child process.
struct SandboxLimits {
  double seconds = 2;                          ///< for each message; and 2 more for every megabyte of the file
  std::int64_t bytes = std::int64_t{1} << 29;  ///< and 200 more for every byte of the file
};

/// The way from a reader in a child process to its parent. Whatever is sent gives the reader new processor time.
class ToParent {
 public:
  ToParent(int pipe, double seconds) : pipe_(pipe), seconds_(seconds) {}
  /// Waits while the parent is busy.
  void send(std::string_view bytes) { send('R', bytes); }
  /// Says that the work goes on, at most once a second.
  void say_alive();

 private:
  friend class ChildReader;
  void send(char kind, std::string_view bytes);

  int pipe_;
  double seconds_;
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

/// A reader in a child process, for libraries that a damaged file can make crash or read endlessly: then next() throws
/// Error(input), naming `file`, and the calling process goes on. An Error thrown by `read` is thrown by next(), after
/// the messages before it; what exceeds `limits` and other exceptions are Error(input) too.
///
/// `read` runs in a copy of this process with one thread: it must not wait for other threads, nor use what they may
/// have locked. It allocates, so the allocator must work in the forked child of a process with threads, as that of
/// glibc does. The child ends with this object, and with the thread that made it.
class ChildReader {
 public:
  ChildReader(std::filesystem::path file, const std::function<void(ToParent&)>& read, const SandboxLimits& limits = {},
              const Context* context = nullptr);
  ChildReader(const ChildReader&) = delete;
  ChildReader& operator=(const ChildReader&) = delete;
  ~ChildReader();

  /// The next message. Throws Error(cancelled) while it waits, where the context is cancelled.
  std::string next();
  /// The next message, which has the size of `out`.
  void next(std::span<std::byte> out);

 private:
  std::uint64_t next_size();
  void take(std::span<char> out);
  [[noreturn]] void refuse(const std::string& why) const;
  [[noreturn]] void refuse_end();
  int wait_for_end();

  std::filesystem::path file_;
  const Context* context_;
  std::chrono::duration<double> patience_;
  int process_ = -1;
  int pipe_ = -1;
};

/// To be called in a child process that knows how much more memory it needs: raises its limit by `bytes`.
void allow_memory(std::uint64_t bytes);

/// The only message of a ChildReader: the bytes that `read` returns.
std::string read_in_child_process(const std::filesystem::path& file, const std::function<std::string()>& read,
                                  const SandboxLimits& limits = {});

}  // namespace quench::base
