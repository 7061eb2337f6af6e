// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <system_error>
#include <vector>

#include "quench/io.h"
#include "quench/output_group.h"

namespace quench::io {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void cannot_write(const fs::path& file, const std::string& reason) {
  throw Error(ErrorCode::failed, fmt::format("cannot write '{}': {}", file.string(), reason));
}

std::string reason_of(int error) { return error ? std::strerror(error) : "the system gives no reason"; }

/// Writes and closes `target`; errors are told about `file`.
void write_to(const fs::path& target, const fs::path& file, const std::function<void(std::ostream&)>& body) {
  std::vector<char> buffer(1 << 20);
  std::ofstream out;
  out.rdbuf()->pubsetbuf(buffer.data(), static_cast<std::streamsize>(buffer.size()));
  errno = 0;
  out.open(target, std::ios::binary | std::ios::trunc);
  if (!out) cannot_write(file, reason_of(errno));
  errno = 0;
  body(out);
  // A body does not look at the stream: once it has failed, later output is lost and errno still has the reason.
  if (!out) cannot_write(file, reason_of(errno));
  out.flush();
  if (!out) cannot_write(file, reason_of(errno));
  out.close();
  if (!out) cannot_write(file, reason_of(errno));
}

thread_local OutputGroup* open_group = nullptr;

// Names of temporary files, for a handler of signals: it may neither allocate nor lock. Whoever takes a name out of its
// place owns it.
std::array<std::atomic<char*>, 64> remembered{};
static_assert(std::atomic<char*>::is_always_lock_free);

/// The place of the name; none, when all are taken.
int remember(const fs::path& path) {
  char* name = ::strdup(path.c_str());
  for (std::size_t i = 0; name && i < remembered.size(); ++i)
    if (char* empty = nullptr; remembered[i].compare_exchange_strong(empty, name)) return static_cast<int>(i);
  std::free(name);
  return -1;
}

void forget(int place) {
  if (place >= 0) std::free(remembered[static_cast<std::size_t>(place)].exchange(nullptr));
}

/// Removes a file at the end of its scope unless it has been renamed.
struct Temporary {
  fs::path path;
  int place;
  bool renamed = false;
  explicit Temporary(fs::path where) : path(std::move(where)), place(remember(path)) {}
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;
  ~Temporary() {
    if (renamed) return;
    std::error_code ignored;
    fs::remove(path, ignored);
    forget(place);
  }
};

}  // namespace

void remove_temporary_files() noexcept {
  for (auto& place : remembered)
    if (const char* name = place.exchange(nullptr)) ::unlink(name);
}

struct PostponedRename {
  static void add(OutputGroup& group, fs::path temporary, fs::path target, fs::path name, int place) {
    group.pending_.push_back({std::move(temporary), std::move(target), std::move(name), place});
  }
};

OutputGroup::OutputGroup() {
  if (open_group) throw Error(ErrorCode::invariant, "a group of outputs is begun inside another");
  open_group = this;
}

OutputGroup::~OutputGroup() {
  open_group = nullptr;
  std::error_code ignored;
  for (const Pending& file : pending_) {
    fs::remove(file.temporary, ignored);
    forget(file.place);
  }
}

void OutputGroup::commit() {
  while (!pending_.empty()) {
    const Pending& file = pending_.front();
    std::error_code error;
    fs::rename(file.temporary, file.target, error);
    if (error) cannot_write(file.name, error.message());
    forget(file.place);
    pending_.erase(pending_.begin());
  }
}

std::uintmax_t OutputGroup::size_of(const fs::path& file) const {
  fs::path where = file;
  for (const Pending& written : pending_)
    if (written.name == file) where = written.temporary;
  std::error_code error;
  const std::uintmax_t size = fs::file_size(where, error);
  return error ? 0 : size;
}

void write_atomically(const fs::path& file, const std::function<void(std::ostream&)>& body) {
  std::error_code ignored;
  const fs::file_status status = fs::status(file, ignored);
  if (fs::is_directory(status)) cannot_write(file, "it is a folder; name a file in it");
  // A pipe or a device (/dev/stdout) takes bytes and must not be replaced.
  if (fs::exists(status) && !fs::is_regular_file(status)) return write_to(file, file, body);
  // The file behind a link is replaced, not the link.
  fs::path target = fs::is_symlink(file, ignored) ? fs::weakly_canonical(file, ignored) : file;
  if (target.empty()) target = file;
  const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
  if (!fs::exists(folder, ignored))
    cannot_write(file, fmt::format("the folder '{}' does not exist; create it first", folder.string()));
  if (!fs::is_directory(folder, ignored)) cannot_write(file, fmt::format("'{}' is not a folder", folder.string()));

  static std::atomic<unsigned> count{0};
  Temporary temporary(folder / fmt::format(".quench-{}-{}.tmp", ::getpid(), count++));
  write_to(temporary.path, file, body);
  if (fs::exists(status)) fs::permissions(temporary.path, status.permissions(), ignored);
  if (open_group) {
    PostponedRename::add(*open_group, temporary.path, target, file, temporary.place);
    temporary.renamed = true;
    return;
  }
  std::error_code error;
  fs::rename(temporary.path, target, error);
  if (error) cannot_write(file, error.message());
  temporary.renamed = true;
  forget(temporary.place);
}

}  // namespace quench::io
