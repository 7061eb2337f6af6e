// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <filesystem>
#include <string>

#include "target.h"

namespace quench::fuzz {

/// A file in memory under a name that ends as its reader expects, for readers that take a path.
class MemoryFile {
 public:
  explicit MemoryFile(const std::string& extension) : descriptor_(memfd_create("quench-fuzz", MFD_CLOEXEC)) {
    if (descriptor_ < 0) defect("there is no file in memory");
    const std::string number = std::to_string(getpid()) + "-" + std::to_string(descriptor_);
    path_ = std::filesystem::temp_directory_path() / ("quench-fuzz-" + number + extension);
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
    std::filesystem::create_symlink("/proc/self/fd/" + std::to_string(descriptor_), path_);
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  ~MemoryFile() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
    close(descriptor_);
  }

  const std::filesystem::path& holding(const std::uint8_t* data, std::size_t size) const {
    if (ftruncate(descriptor_, 0) != 0 || pwrite(descriptor_, data, size, 0) != static_cast<ssize_t>(size))
      defect("the file in memory cannot be written");
    return path_;
  }

 private:
  int descriptor_;
  std::filesystem::path path_;
};

}  // namespace quench::fuzz
