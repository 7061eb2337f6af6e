// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

namespace quench::io {

/// What a reader in a process of its own may use.
struct ApartLimits {
  double seconds = 2;                          ///< of the processor, beside 2 for every megabyte of the file
  std::int64_t bytes = std::int64_t{1} << 29;  ///< of memory, beside 200 for every byte of the file
};

/// Runs `read` in a child process and gives back the bytes it returns. For libraries of others, which a damaged file
/// can make crash or read endlessly: this throws Error(input) then, naming `file`, and the caller is unharmed. An Error
/// thrown by `read` is thrown here; bytes beyond `limits` and other exceptions are Error(input) too.
///
/// `read` runs in a copy of this process with one thread: it must not wait for others, nor touch what they may have
/// locked. It allocates, which needs an allocator that works in the child of a process with threads: that of glibc
/// does.
std::string read_apart(const std::filesystem::path& file, const std::function<std::string()>& read,
                       const ApartLimits& limits = {});

}  // namespace quench::io
