// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <ostream>
#include <string_view>

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

/// The same for an output that is a folder: its files are written into a temporary folder beside it, which commit()
/// flushes and puts in place as a whole. A folder that is there is replaced by it, with all that it holds: whether that
/// may be is for the caller to check. Anything else that is there is Error(failed).
class OutputFolder {
 public:
  explicit OutputFolder(const std::filesystem::path& folder);
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;
  ~OutputFolder();

  /// A file of the folder, by its name relative to it; folders on the way are made. For several threads at a time.
  void write(const std::filesystem::path& name, std::string_view bytes);
  void commit();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace quench::io
