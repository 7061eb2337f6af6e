// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <string_view>
#include <system_error>

#include "base/platform/file_out.h"
#include "base/platform/remove_tree.h"
#include "base/platform/system_files.h"
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
void finish_writing(base::FileOut& out, const fs::path& file) {
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

constexpr std::string_view kEnding = ".tmp";  // of temporary files
constexpr fs::perms kReadAndWritten{0666};    // less the umask

/// Turns the name of a temporary file into another one that cannot be guessed.
void make_other(std::span<char> name) { name[name.size() - kEnding.size() - 1] = 'x'; }

/// Puts a new folder in the place of an old one, which gets the name of the new one. 0 or an errno.
int exchange(const fs::path& temporary, const fs::path& target) {
  if (const int error = base::exchange_names(temporary, target); error != EINVAL && error != ENOSYS) return error;
  // A file system that cannot do both at once. Between the two calls there is neither.
  std::string aside = temporary;
  make_other(aside);
  if (const int error = base::rename_file(target.c_str(), aside.c_str())) return error;
  if (const int error = base::rename_file(temporary.c_str(), target.c_str())) {
    base::rename_file(aside.c_str(), target.c_str());
    return error;
  }
  if (base::rename_file(aside.c_str(), temporary.c_str()) != 0) base::remove_tree(aside.c_str());
  return 0;
}

void rename_to(const fs::path& temporary, const fs::path& target, const fs::path& file) {
  std::error_code error;
  if (fs::is_directory(temporary, error) && fs::is_directory(target, error)) {
    if (const int reason = exchange(temporary, target)) cannot_write(file, reason_of(reason));
    return;
  }
  fs::rename(temporary, target, error);
  if (error) cannot_write(file, error.message());
}

fs::path folder_of(const fs::path& file) { return file.has_parent_path() ? file.parent_path() : fs::path("."); }

void flush_folder(const fs::path& folder, const fs::path& file) {
  if (const int error = base::flush_folder_to_disk(folder))
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

std::atomic<bool> removing{false};  // remove_temporary_files() has been called

/// Removes a temporary file or folder. Where remove_temporary_files() is at it already: not before all of it is gone,
/// so that the process does not end in the middle of that.
void discard_temporary(const fs::path& path, int place) {
  base::remove_tree(path.c_str());
  if (removing) {
    std::string other = path;
    make_other(other);
    base::remove_tree(other.c_str());
  }
  forget(place);
}

/// A file or folder of a new name beside the output. At the end of its scope what is there is removed: it, or the
/// folder that it has replaced.
class Temporary {
 public:
  /// `create` makes it: 0, or an errno, which `error` is then.
  template <class Create>
  Temporary(const fs::path& folder, const Create& create) {
    std::random_device random;  // no one can guess the name and put a link to another file there
    for (int tries = 0; tries < 100; ++tries) {
      if (renaming == kStopped) throw Error(ErrorCode::cancelled, "cancelled");  // it would not be removed
      path = folder / fmt::format(".quench-{:08x}{:08x}{}", random(), random(), kEnding);
      place = remember(path);
      error = create(path);
      if (!error) return;
      forget(place);
      place = -1;
      if (error != EEXIST) return;
    }
  }
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;
  ~Temporary() {
    if (postponed) return;
    if (!error) discard_temporary(path, place);
  }

  fs::path path;
  int place = -1;  ///< index of the name in `remembered`, or -1
  int error = 0;
  bool postponed = false;  ///< a group puts it in place
};

/// The folder that an output will lie in. Throws Error(failed) where it is none.
fs::path existing_folder_of(const fs::path& target, const fs::path& file) {
  fs::path folder = folder_of(target);
  std::error_code error;
  if (!fs::exists(folder, error))
    cannot_write(file, fmt::format("the folder '{}' does not exist; create it first", folder.string()));
  if (!fs::is_directory(folder, error)) cannot_write(file, fmt::format("'{}' is not a folder", folder.string()));
  return folder;
}

}  // namespace

void remove_temporary_files() noexcept {
  removing = true;
  for (auto& place : remembered)
    if (const char* name = place.exchange(nullptr)) {
      // Threads that still write files into a folder do not find it any more, and cannot fill it again.
      char other[base::kLongestPath];
      const std::size_t length = std::strlen(name);
      if (base::remove_file(name) || length >= sizeof other) continue;
      std::memcpy(other, name, length + 1);
      make_other({other, length});
      base::remove_tree(base::rename_file(name, other) == 0 ? other : name);
    }
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
  discard();
}

void OutputGroup::discard() {
  for (const Pending& file : pending_) discard_temporary(file.temporary, file.place);
  pending_.clear();
}

void OutputGroup::commit() {
  if (pending_.empty()) return;
  std::map<fs::path, fs::path> folders;  // with a file to be named when one fails
  {
    const Renaming all;
    for (const Pending& file : pending_) {
      rename_to(file.temporary, file.target, file.name);
      in_place = true;
      folders.emplace(folder_of(file.target), file.name);
    }
  }
  for (const auto& [folder, file] : folders) flush_folder(folder, file);
  discard();  // the folders that were replaced
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

namespace {

/// Renames what is complete, or leaves that to the group of the thread.
void put_in_place(Temporary& temporary, const fs::path& target, const fs::path& file) {
  if (open_group) {
    PostponedRename::add(*open_group, temporary.path, target, file, temporary.place);
    temporary.postponed = true;
    return;
  }
  {
    const Renaming one;
    rename_to(temporary.path, target, file);
    in_place = true;
  }
  flush_folder(folder_of(target), file);
}

/// What is at the place of an output. Throws Error(failed) where that cannot be known.
fs::file_status status_of(const fs::path& file) {
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (error && error != std::errc::no_such_file_or_directory && !fs::status_known(status))
    cannot_write(file, error.message());
  return status;
}

}  // namespace

struct OutputFile::Impl {
  fs::path file, target;
  base::FileOut out;
  std::optional<Temporary> temporary;  ///< none: a pipe or a device
};

OutputFile::OutputFile(const fs::path& file) : impl_(std::make_unique<Impl>()) {
  impl_->file = file;
  const fs::file_status status = status_of(file);
  if (fs::is_directory(status)) cannot_write(file, "it is a folder; name a file in it");
  base::FileOut& out = impl_->out;
  // A pipe or a device (/dev/stdout) takes bytes and must not be replaced.
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    out.open(file);
  } else {
    impl_->target = place_of_output(file);
    const fs::path folder = existing_folder_of(impl_->target, file);
    // Those of the file that is replaced, never more on the way there. Without the bits that let others act for its
    // owner: the new file is owned by who writes it.
    const bool replaces = fs::exists(status);
    const fs::perms permissions = replaces ? status.permissions() & fs::perms::all : kReadAndWritten;
    impl_->temporary.emplace(folder, [&](const fs::path& path) {
      out.create(path, permissions);
      return out.error();
    });
    if (replaces && !out.error()) out.set_permissions(permissions);
  }
  if (out.error()) cannot_write(file, reason_of(out.error()));
}

OutputFile::~OutputFile() = default;

std::ostream& OutputFile::stream() { return impl_->out.stream(); }

void OutputFile::commit() {
  finish_writing(impl_->out, impl_->file);
  if (impl_->temporary) put_in_place(*impl_->temporary, impl_->target, impl_->file);
}

struct OutputFolder::Impl {
  fs::path folder, target;
  fs::perms permissions;  ///< those of the folder that is replaced; none: none is
  std::optional<Temporary> temporary;
};

OutputFolder::OutputFolder(const fs::path& folder) : impl_(std::make_unique<Impl>()) {
  impl_->folder = folder;
  const fs::file_status status = status_of(folder);
  if (fs::exists(status) && !fs::is_directory(status)) cannot_write(folder, "it is a file, and not a folder");
  impl_->target = place_of_output(folder);
  impl_->permissions = fs::exists(status) ? status.permissions() : fs::perms::none;
  impl_->temporary.emplace(existing_folder_of(impl_->target, folder), [&](const fs::path& path) {
    return base::make_folder(path, fs::exists(status) ? impl_->permissions | fs::perms::owner_all : fs::perms::all);
  });
  if (impl_->temporary->error) cannot_write(folder, reason_of(impl_->temporary->error));
}

OutputFolder::~OutputFolder() = default;

void OutputFolder::write(const fs::path& name, std::string_view bytes) {
  const auto fail = [&](int error) {
    if (removing) throw Error(ErrorCode::cancelled, "cancelled");  // the folder is gone
    cannot_write(impl_->folder, reason_of(error));
  };
  base::FileOut out;
  out.create(impl_->temporary->path / name, kReadAndWritten);
  if (out.error() == ENOENT) {
    fs::path folder = impl_->temporary->path;  // which is not made again, when the end of the process has removed it
    for (const fs::path& part : name.parent_path())
      if (const int error = base::make_folder(folder /= part, fs::perms::all); error && error != EEXIST) fail(error);
    out.create(impl_->temporary->path / name, kReadAndWritten);
  }
  out.stream().write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (out.error() || !out.stream()) fail(out.error());
}

void OutputFolder::commit() {
  const fs::path& path = impl_->temporary->path;
  if (const int error = base::flush_file_system(path)) cannot_write(impl_->folder, reason_of(error));
  std::error_code ignored;  // some file systems have none
  if (impl_->permissions != fs::perms::none) fs::permissions(path, impl_->permissions, ignored);
  put_in_place(*impl_->temporary, impl_->target, impl_->folder);
}

void write_atomically(const fs::path& file, const std::function<void(std::ostream&)>& body) {
  OutputFile out(file);
  body(out.stream());
  out.commit();
}

}  // namespace quench::io
