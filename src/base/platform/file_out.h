// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <ostream>
#include <streambuf>
#include <vector>

namespace quench::base {

/// A file that is written from its beginning. Unlike std::ofstream it can refuse a file that exists, give a new one its
/// permissions from the first byte on, and wait until the data are on the disk. Once a call has failed, error() is its
/// errno and all further output is lost.
class FileOut : private std::streambuf {
 public:
  FileOut() = default;
  FileOut(const FileOut&) = delete;
  FileOut& operator=(const FileOut&) = delete;
  ~FileOut() override { close(); }

  /// Creates the file; error() is EEXIST when one of this name exists, a link included.
  void create(const std::filesystem::path& file, std::filesystem::perms permissions);
  /// Writes into a file that exists, e.g. a pipe or a device.
  void open(const std::filesystem::path& file);
  /// Exactly these permissions, whatever the umask is. File systems without permissions ignore them.
  void set_permissions(std::filesystem::perms permissions);
  std::ostream& stream() { return stream_; }
  /// Hands all output to the system, and waits until it is on the disk. Returns at once where the file cannot be
  /// flushed.
  void flush_to_disk();
  void close();
  int error() const { return error_; }

 private:
  int_type overflow(int_type c) override;
  std::streamsize xsputn(const char* bytes, std::streamsize count) override;
  int sync() override;
  void opened(int descriptor);
  bool send(const char* bytes, std::size_t count);
  bool empty_buffer();

  int descriptor_ = -1, error_ = 0;
  std::vector<char> buffer_;
  std::ostream stream_{this};
};

/// Waits until the names in a folder are on the disk, as far as the system can tell: 0 or an errno.
int flush_folder_to_disk(const std::filesystem::path& folder);

/// Waits until all that was written to the file system of a folder is on the disk: for folders of many files, each of
/// which would wait for the disk. 0 or an errno (Linux 5.8 and newer tell of data that could not be written).
int flush_file_system(const std::filesystem::path& folder);

}  // namespace quench::base
