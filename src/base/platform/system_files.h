// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>

namespace quench::base {

/// What std::filesystem does not offer. Errors are numbers of errno, 0 for none. What is noexcept may be called when
/// the process ends by a signal: it makes system calls only.

/// The longest path that the system takes, its end included.
inline constexpr std::size_t kLongestPath = 4096;

/// Longest name in a folder, in bytes; 0 where the system does not say.
std::size_t longest_name_in(const std::filesystem::path& folder);

/// A folder that was not there, with these permissions less those of the umask.
int make_folder(const std::filesystem::path& folder, std::filesystem::perms permissions);

/// A new folder in another one, of a name that nobody has, for its owner only. Empty where that fails: errno says why.
std::filesystem::path make_temporary_folder(const std::filesystem::path& in);

/// Two names change places in one step. EINVAL or ENOSYS where the file system or the system cannot do that.
int exchange_names(const std::filesystem::path& a, const std::filesystem::path& b);

/// Removes a file or link; not a folder.
bool remove_file(const char* path) noexcept;

/// Replaces what has the name `to`.
int rename_file(const char* from, const char* to) noexcept;

/// Whether a file, pipe or device that is there may be written to: an error if not.
int writing_error(const std::filesystem::path& file);

/// Whether a file can be made in a folder: an error if not. One is, and is removed: the permissions say too little, as
/// some file systems (/proc) take no files.
int creation_error(const std::filesystem::path& folder);

struct FileFacts {
  std::int64_t size = 0;
  std::int64_t seconds = 0, nanoseconds = 0;  ///< last change, since 1970
};
std::optional<FileFacts> facts_of(const std::filesystem::path& file);

/// A file that is read and written at any place, by several threads at once. Closed when its object ends.
class PlacedFile {
 public:
  PlacedFile() = default;
  PlacedFile(PlacedFile&& other) noexcept : descriptor_(other.descriptor_) { other.descriptor_ = -1; }
  PlacedFile& operator=(PlacedFile&& other) noexcept;
  ~PlacedFile() { close(); }

  /// Not open where that fails: errno says why.
  static PlacedFile open(const std::filesystem::path& file);
  /// A new file without a name in a folder: its disk is free when it is closed, or the process ends.
  static PlacedFile nameless(const std::filesystem::path& folder);

  bool is_open() const { return descriptor_ >= 0; }
  void close();
  /// Fills `out` from byte `at` on, as far as the file goes; the number of bytes, fewer after an error, too (errno).
  std::size_t read(std::uint64_t at, std::span<std::byte> out) const;
  /// 0 or an errno.
  int write(std::uint64_t at, std::span<const std::byte> bytes);

 private:
  int descriptor_ = -1;
};

/// A lock that other processes see while this object lives. Where the file system has none, everybody gets it.
class FileLock {
 public:
  /// On a folder, without waiting: elsewhere() says that another process has it.
  static FileLock try_folder(const std::filesystem::path& folder);
  /// On a file, made if it is not there; waits. error() where it cannot be opened.
  static FileLock wait_for(const std::filesystem::path& file);

  FileLock(FileLock&& other) noexcept
      : descriptor_(other.descriptor_), error_(other.error_), elsewhere_(other.elsewhere_) {
    other.descriptor_ = -1;
  }
  FileLock& operator=(FileLock&&) = delete;
  ~FileLock();

  int error() const { return error_; }
  bool elsewhere() const { return elsewhere_; }

 private:
  FileLock() = default;

  int descriptor_ = -1, error_ = 0;
  bool elsewhere_ = false;
};

}  // namespace quench::base
