// SPDX-License-Identifier: Apache-2.0
#include "base/platform/system_files.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <climits>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <utility>

namespace quench::base {

static_assert(kLongestPath >= PATH_MAX);

std::size_t longest_name_in(const std::filesystem::path& folder) {
  const long most = pathconf(folder.c_str(), _PC_NAME_MAX);
  return most > 0 ? static_cast<std::size_t>(most) : 0;
}

int make_folder(const std::filesystem::path& folder, std::filesystem::perms permissions) {
  return ::mkdir(folder.c_str(), static_cast<mode_t>(permissions)) == 0 ? 0 : errno;
}

std::filesystem::path make_temporary_folder(const std::filesystem::path& in) {
  std::string name = (in / "quench-XXXXXX").string();
  if (!::mkdtemp(name.data())) return {};
  return name;
}

int exchange_names(const std::filesystem::path& a, const std::filesystem::path& b) {
#if defined(RENAME_EXCHANGE)
  return ::renameat2(AT_FDCWD, a.c_str(), AT_FDCWD, b.c_str(), RENAME_EXCHANGE) == 0 ? 0 : errno;
#else
  static_cast<void>(a);
  static_cast<void>(b);
  return ENOSYS;
#endif
}

bool remove_file(const char* path) noexcept { return ::unlink(path) == 0; }

int rename_file(const char* from, const char* to) noexcept { return ::rename(from, to) == 0 ? 0 : errno; }

int writing_error(const std::filesystem::path& file) { return ::access(file.c_str(), W_OK) == 0 ? 0 : errno; }

int creation_error(const std::filesystem::path& folder) {
  std::string name = (folder / ".quench-XXXXXX").string();
  const int file = mkstemp(name.data());
  if (file < 0) return errno;
  ::close(file);
  ::unlink(name.c_str());
  return 0;
}

std::optional<FileFacts> facts_of(const std::filesystem::path& file) {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0) return {};
#if defined(__APPLE__)
  const timespec& changed = status.st_mtimespec;
#else
  const timespec& changed = status.st_mtim;
#endif
  return FileFacts{status.st_size, changed.tv_sec, changed.tv_nsec};
}

PlacedFile& PlacedFile::operator=(PlacedFile&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  other.close();
  return *this;
}

PlacedFile PlacedFile::open(const std::filesystem::path& file) {
  PlacedFile opened;
  opened.descriptor_ = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  return opened;
}

PlacedFile PlacedFile::nameless(const std::filesystem::path& folder) {
  std::string name = (folder / ".quench-XXXXXX").string();
  PlacedFile made;
  made.descriptor_ = mkostemp(name.data(), O_CLOEXEC);
  if (made.is_open()) ::unlink(name.c_str());
  return made;
}

void PlacedFile::close() {
  if (descriptor_ >= 0) ::close(std::exchange(descriptor_, -1));
}

std::size_t PlacedFile::read(std::uint64_t at, std::span<std::byte> out) const {
  std::size_t done = 0;
  errno = 0;
  while (done < out.size()) {
    const ssize_t got = ::pread(descriptor_, out.data() + done, out.size() - done, static_cast<off_t>(at + done));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) break;
    done += static_cast<std::size_t>(got);
  }
  return done;
}

int PlacedFile::write(std::uint64_t at, std::span<const std::byte> bytes) {
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t got = ::pwrite(descriptor_, bytes.data() + done, bytes.size() - done, static_cast<off_t>(at + done));
    if (got < 0 && errno != EINTR) return errno;
    if (got > 0) done += static_cast<std::size_t>(got);
  }
  return 0;
}

FileLock FileLock::try_folder(const std::filesystem::path& folder) {
  FileLock lock;
  lock.descriptor_ = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  lock.elsewhere_ = lock.descriptor_ >= 0 && ::flock(lock.descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  return lock;
}

FileLock FileLock::wait_for(const std::filesystem::path& file) {
  FileLock lock;
  lock.descriptor_ = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (lock.descriptor_ < 0)
    lock.error_ = errno;
  else
    while (::flock(lock.descriptor_, LOCK_EX) != 0 && errno == EINTR) {
    }
  return lock;
}

FileLock::~FileLock() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

}  // namespace quench::base
