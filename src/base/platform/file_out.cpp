// SPDX-License-Identifier: Apache-2.0
#include "base/platform/file_out.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

namespace quench::base {
namespace {

/// fsync() or syncfs(); 0 also where it is not possible: pipes, file systems that do not support it or are read only.
int flushed(int descriptor, int (*flush)(int) = ::fsync) {
  while (flush(descriptor) != 0) {
    if (errno == EINTR) continue;
    const bool offered = errno != EINVAL && errno != ENOTSUP && errno != EROFS && errno != ENOSYS;
    return offered ? errno : 0;
  }
  return 0;
}

}  // namespace

void FileOut::opened(int descriptor) {
  if (descriptor < 0) {
    error_ = errno;
    return;
  }
  descriptor_ = descriptor;
  error_ = 0;
  buffer_.resize(std::size_t{1} << 20);
  setp(buffer_.data(), buffer_.data() + buffer_.size());
  stream_.clear();
}

void FileOut::create(const std::filesystem::path& file, std::filesystem::perms permissions) {
  opened(::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, static_cast<mode_t>(permissions)));
}

void FileOut::open(const std::filesystem::path& file) {
  opened(::open(file.c_str(), O_WRONLY | O_TRUNC | O_CLOEXEC, 0));
}

void FileOut::set_permissions(std::filesystem::perms permissions) {
  if (descriptor_ >= 0 && ::fchmod(descriptor_, static_cast<mode_t>(permissions)) != 0 && errno != EPERM &&
      errno != ENOTSUP)
    error_ = errno;
}

bool FileOut::send(const char* bytes, std::size_t count) {
  while (count > 0 && error_ == 0) {
    const ssize_t sent = ::write(descriptor_, bytes, count);
    if (sent > 0) {
      bytes += sent;
      count -= static_cast<std::size_t>(sent);
    } else if (sent == 0) {
      error_ = ENOSPC;
    } else if (errno != EINTR) {
      error_ = errno;
    }
  }
  return error_ == 0;
}

bool FileOut::empty_buffer() {
  const bool sent = send(pbase(), static_cast<std::size_t>(pptr() - pbase()));
  setp(buffer_.data(), buffer_.data() + buffer_.size());
  return sent;
}

FileOut::int_type FileOut::overflow(int_type c) {
  if (descriptor_ < 0 || !empty_buffer()) return traits_type::eof();
  if (!traits_type::eq_int_type(c, traits_type::eof())) sputc(traits_type::to_char_type(c));
  return traits_type::not_eof(c);
}

std::streamsize FileOut::xsputn(const char* bytes, std::streamsize count) {
  if (count < epptr() - pptr()) return std::streambuf::xsputn(bytes, count);
  if (descriptor_ < 0 || !empty_buffer() || !send(bytes, static_cast<std::size_t>(count))) return 0;
  return count;
}

int FileOut::sync() { return descriptor_ >= 0 && empty_buffer() ? 0 : -1; }

void FileOut::flush_to_disk() {
  stream_.flush();
  if (error_ == 0) error_ = flushed(descriptor_);
}

void FileOut::close() {
  if (descriptor_ < 0) return;
  empty_buffer();
  if (::close(descriptor_) != 0 && error_ == 0 && errno != EINTR) error_ = errno;
  descriptor_ = -1;
}

namespace {

int folder_flushed(const std::filesystem::path& folder, int (*flush)(int)) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return 0;  // a folder that may be written but not read
  const int error = flushed(descriptor, flush);
  ::close(descriptor);
  return error;
}

}  // namespace

int flush_folder_to_disk(const std::filesystem::path& folder) { return folder_flushed(folder, ::fsync); }

int flush_file_system(const std::filesystem::path& folder) { return folder_flushed(folder, ::syncfs); }

}  // namespace quench::base
