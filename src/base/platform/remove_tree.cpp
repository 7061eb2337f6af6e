// SPDX-License-Identifier: Apache-2.0
#include "base/platform/remove_tree.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace quench::base {
namespace {

void remove_in(int parent, const char* name) noexcept;

void empty_folder(int folder) noexcept {
  alignas(dirent64) char entries[1 << 13];  // readdir() allocates
  for (;;) {
    const long got = ::syscall(SYS_getdents64, folder, entries, sizeof entries);
    if (got <= 0) return;
    for (long at = 0; at < got;) {
      const auto* entry = reinterpret_cast<const dirent64*>(entries + at);
      at += entry->d_reclen;
      if (std::strcmp(entry->d_name, ".") != 0 && std::strcmp(entry->d_name, "..") != 0)
        remove_in(folder, entry->d_name);
    }
  }
}

void remove_in(int parent, const char* name) noexcept {
  if (::unlinkat(parent, name, 0) == 0) return;
  const int folder = ::openat(parent, name, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
  if (folder < 0) return;
  constexpr int kTries = 10;  // another thread may be about to create a file in it
  for (int i = 0; i < kTries; ++i) {
    ::lseek(folder, 0, SEEK_SET);
    empty_folder(folder);
    if (::unlinkat(parent, name, AT_REMOVEDIR) == 0 || errno != ENOTEMPTY) break;
  }
  ::close(folder);
}

}  // namespace

void remove_tree(const char* path) noexcept { remove_in(AT_FDCWD, path); }

}  // namespace quench::base
