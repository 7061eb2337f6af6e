// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <ostream>

namespace quench::io {

/// What write_atomically() does, for writers that are handed their data piece by piece: what is written to stream()
/// goes to a temporary file, commit() flushes it and puts it in place, or leaves that to the OutputGroup of the thread.
/// Without commit() the temporary file is removed. Throws as write_atomically() does.
class OutputFile {
 public:
  explicit OutputFile(const std::filesystem::path& file);
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;
  ~OutputFile();

  std::ostream& stream();
  void commit();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace quench::io
