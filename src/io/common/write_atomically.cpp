// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <system_error>

#include "io/common/file_out.h"
#include "io/common/output_file.h"
#include "quench/io.h"

namespace quench::io {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void cannot_write(const fs::path& file, const std::string& reason) {
  throw Error(ErrorCode::failed, fmt::format("cannot write '{}': {}", file.string(), reason));
}

std::string reason_of(int error) { return error ? std::strerror(error) : "the system gives no reason"; }

/// Waits until the disk has what was written. Errors name `file`.
void finish_writing(FileOut& out, const fs::path& file) {
  // Who writes does not check the stream: once it has failed, later output is lost and the first reason is kept.
  out.flush_to_disk();
  out.close();
  if (out.error() || !out.stream()) cannot_write(file, reason_of(out.error()));
}

/// How many threads rename just now; `kStopped`: the program is about to end, and nothing may be renamed any more.
constexpr unsigned kStopped = ~0u;
std::atomic<unsigned> renaming{0};
std::atomic<bool> in_place{false};
static_assert(std::atomic<unsigned>::is_always_lock_free);

/// While one exists, stop_outputs() waits.
struct Renaming {
  Renaming() {
    unsigned now = renaming.load();
    do {
      if (now == kStopped) throw Error(ErrorCode::cancelled, "cancelled");
    } while (!renaming.compare_exchange_weak(now, now + 1));
  }
  Renaming(const Renaming&) = delete;
  Renaming& operator=(const Renaming&) = delete;
  ~Renaming() { --renaming; }
};

void rename_to(const fs::path& temporary, const fs::path& target, const fs::path& file) {
  std::error_code error;
  fs::rename(temporary, target, error);
  if (error) cannot_write(file, error.message());
}

fs::path folder_of(const fs::path& file) { return file.has_parent_path() ? file.parent_path() : fs::path("."); }

void flush_folder(const fs::path& folder, const fs::path& file) {
  if (const int error = flush_folder_to_disk(folder))
    cannot_write(file,
                 fmt::format("it is written, but its folder cannot be flushed to the disk: {}", reason_of(error)));
}

thread_local OutputGroup* open_group = nullptr;

// Names of temporary files, for a signal handler, which may neither allocate nor lock. Who exchanges a name for null
// owns it.
std::array<std::atomic<char*>, 64> remembered{};
static_assert(std::atomic<char*>::is_always_lock_free);

/// Index of the name in `remembered`; -1 when it is full.
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

/// A file of a new name beside the output; removed at the end of its scope unless it has been renamed.
class Temporary {
 public:
  /// Where it cannot be created, `out.error()` says why.
  Temporary(const fs::path& folder, mode_t permissions, FileOut& out) {
    std::random_device random;  // no one can guess the name and put a link to another file there
    for (int tries = 0; tries < 100; ++tries) {
      if (renaming == kStopped) throw Error(ErrorCode::cancelled, "cancelled");  // it would not be removed
      path = folder / fmt::format(".quench-{:08x}{:08x}.tmp", random(), random());
      place = remember(path);
      out.create(path, permissions);
      created = !out.error();
      if (created) return;
      forget(place);
      place = -1;
      if (out.error() != EEXIST) return;
    }
  }
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;
  ~Temporary() {
    if (kept) return;
    std::error_code ignored;
    if (created) fs::remove(path, ignored);
    forget(place);
  }

  fs::path path;
  int place = -1;  ///< index of the name in `remembered`, or -1
  bool created = false, kept = false;
};

}  // namespace

void remove_temporary_files() noexcept {
  for (auto& place : remembered)
    if (const char* name = place.exchange(nullptr)) ::unlink(name);
}

Outputs stop_outputs() noexcept {
  unsigned none = 0;
  if (!renaming.compare_exchange_strong(none, kStopped) && none != kStopped) return Outputs::being_renamed;
  return in_place ? Outputs::in_place : Outputs::untouched;
}

struct PostponedRename {
  static void add(OutputGroup& group, fs::path temporary, fs::path target, fs::path name, int place) {
    group.pending_.push_back({std::move(temporary), std::move(target), std::move(name), place});
  }
};

OutputGroup::OutputGroup() {
  if (open_group) throw Error(ErrorCode::invariant, "a group of outputs must not be begun inside another");
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
  if (pending_.empty()) return;
  std::map<fs::path, fs::path> folders;  // with a file to be named when one fails
  for (const Renaming all; !pending_.empty(); pending_.erase(pending_.begin())) {
    const Pending& file = pending_.front();
    rename_to(file.temporary, file.target, file.name);
    in_place = true;
    folders.emplace(folder_of(file.target), file.name);
    forget(file.place);
  }
  for (const auto& [folder, file] : folders) flush_folder(folder, file);
}

std::uintmax_t OutputGroup::size_of(const fs::path& file) const {
  fs::path where = file;
  for (const Pending& written : pending_)
    if (written.name == file) where = written.temporary;
  std::error_code error;
  const std::uintmax_t size = fs::file_size(where, error);
  return error ? 0 : size;
}

fs::path place_of_output(const fs::path& file) {
  constexpr int kMostLinks = 40;  // as many as Linux follows
  fs::path target = file;
  std::error_code error;
  for (int links = 0; links < kMostLinks && fs::is_symlink(target, error); ++links) {
    const fs::path next = fs::read_symlink(target, error);
    if (error) return file;
    target = next.is_absolute() ? next : target.parent_path() / next;
  }
  return target;
}

struct OutputFile::Impl {
  fs::path file, folder, target;
  FileOut out;
  std::optional<Temporary> temporary;  ///< none: a pipe or a device
};

OutputFile::OutputFile(const fs::path& file) : impl_(std::make_unique<Impl>()) {
  impl_->file = file;
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (error && error != std::errc::no_such_file_or_directory && !fs::status_known(status))
    cannot_write(file, error.message());
  if (fs::is_directory(status)) cannot_write(file, "it is a folder; name a file in it");
  FileOut& out = impl_->out;
  // A pipe or a device (/dev/stdout) takes bytes and must not be replaced.
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    out.open(file);
  } else {
    impl_->target = place_of_output(file);
    const fs::path& folder = impl_->folder = folder_of(impl_->target);
    if (!fs::exists(folder, error))
      cannot_write(file, fmt::format("the folder '{}' does not exist; create it first", folder.string()));
    if (!fs::is_directory(folder, error)) cannot_write(file, fmt::format("'{}' is not a folder", folder.string()));

    // Those of the file that is replaced, never more on the way there. Without the bits that let others act for its
    // owner: the new file is owned by who writes it.
    const bool replaces = fs::exists(status);
    const auto permissions = static_cast<mode_t>(replaces ? status.permissions() & fs::perms::all : fs::perms(0666));
    impl_->temporary.emplace(folder, permissions, out);
    if (replaces && !out.error()) out.set_permissions(permissions);
  }
  if (out.error()) cannot_write(file, reason_of(out.error()));
}

OutputFile::~OutputFile() = default;

std::ostream& OutputFile::stream() { return impl_->out.stream(); }

void OutputFile::commit() {
  finish_writing(impl_->out, impl_->file);
  if (!impl_->temporary) return;
  Temporary& temporary = *impl_->temporary;
  if (open_group) {
    PostponedRename::add(*open_group, temporary.path, impl_->target, impl_->file, temporary.place);
    temporary.kept = true;
    return;
  }
  {
    const Renaming one;
    rename_to(temporary.path, impl_->target, impl_->file);
    in_place = true;
    temporary.kept = true;
    forget(temporary.place);
  }
  flush_folder(impl_->folder, impl_->file);
}

void write_atomically(const fs::path& file, const std::function<void(std::ostream&)>& body) {
  OutputFile out(file);
  body(out.stream());
  out.commit();
}

}  // namespace quench::io
