// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

namespace quench::io {

/// Processor time and address space of a reader in a child process.
struct SandboxLimits {
  double seconds = 2;                          ///< and 2 more for every megabyte of the file
  std::int64_t bytes = std::int64_t{1} << 29;  ///< and 200 more for every byte of the file
};

/// Runs `read` in a child process and returns the bytes it returns. For libraries that a damaged file can make crash or
/// read endlessly: this throws Error(input) then, naming `file`, and the calling process goes on. An Error thrown by
/// `read` is thrown here; what exceeds `limits` and other exceptions are Error(input) too.
///
/// `read` runs in a copy of this process with one thread: it must not wait for other threads, nor use what they may
/// have locked. It allocates, so the allocator must work in the forked child of a process with threads, as that of
/// glibc does.
std::string read_in_child_process(const std::filesystem::path& file, const std::function<std::string()>& read,
                                  const SandboxLimits& limits = {});

}  // namespace quench::io
