// SPDX-License-Identifier: Apache-2.0
#include "base/platform/child_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fstream>
#include <new>
#include <string_view>

#include "quench/error.h"

namespace quench::base {
namespace {

// The first byte of a message; behind it the number of its bytes, and these.
constexpr char kResult = 'R', kRefusal = 'E', kNoMemory = 'M', kAlive = 'A';
constexpr std::size_t kHead = 1 + sizeof(std::uint64_t);

std::int64_t address_space_now() {
  std::int64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return pages * sysconf(_SC_PAGESIZE);
}

using Resource = decltype(RLIMIT_CORE);  // an enumeration of glibc, an int elsewhere

void limit(Resource resource, std::int64_t amount) {
  rlimit both{};
  if (getrlimit(resource, &both) != 0) return;
  both.rlim_cur = std::min(static_cast<rlim_t>(amount), both.rlim_max);
  setrlimit(resource, &both);
}

/// `seconds` of processor time from now on.
void limit_time(double seconds) {
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  limit(RLIMIT_CPU, used.ru_utime.tv_sec + used.ru_stime.tv_sec + static_cast<std::int64_t>(seconds) + 2);
}

void write_all(int pipe, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t sent = write(pipe, bytes.data(), bytes.size());
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) _exit(1);  // the parent has closed its end
    bytes.remove_prefix(static_cast<std::size_t>(sent));
  }
}

/// What a child process does before it reads.
void settle(int pipe, pid_t parent) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE, SIGSEGV, SIGABRT, SIGFPE, SIGBUS, SIGILL})
    std::signal(signal, SIG_DFL);
  sigset_t none_blocked;
  sigemptyset(&none_blocked);
  sigprocmask(SIG_SETMASK, &none_blocked, nullptr);
  prctl(PR_SET_PDEATHSIG, static_cast<unsigned long>(SIGKILL));  // variadic: of the type it reads
  if (getppid() != parent) _exit(1);
  if (const int nothing = open("/dev/null", O_RDWR); nothing >= 0)
    for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
      if (stream != pipe) dup2(nothing, stream);
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_FSIZE, 0);
}

std::int64_t size_or_zero(const std::filesystem::path& file) {
  std::error_code unknown;
  const std::uintmax_t size = std::filesystem::file_size(file, unknown);
  return unknown ? 0 : static_cast<std::int64_t>(size);
}

}  // namespace

void ToParent::send(char kind, std::string_view bytes) {
  char head[kHead] = {kind};
  const std::uint64_t size = bytes.size();
  std::memcpy(head + 1, &size, sizeof size);
  write_all(pipe_, {head, kHead});
  write_all(pipe_, bytes);
  limit_time(seconds_);
  last_ = std::chrono::steady_clock::now();
}

void ToParent::say_alive() {
  if (std::chrono::steady_clock::now() - last_ > std::chrono::seconds(1)) send(kAlive, {});
}

ChildReader::ChildReader(std::filesystem::path file, const std::function<void(ToParent&)>& read,
                         const SandboxLimits& limits, const Context* context)
    : file_(std::move(file)), context_(context) {
  const std::int64_t size = size_or_zero(file_);
  const double seconds = limits.seconds + 2e-6 * static_cast<double>(size);
  patience_ = std::chrono::seconds(60) + 10 * std::chrono::duration<double>(seconds);
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0)
    throw Error(ErrorCode::failed, fmt::format("'{}' cannot be read: {}", file_.string(), std::strerror(errno)));
  const pid_t parent = getpid();
  process_ = fork();
  if (process_ < 0) {
    const int why = errno;
    for (const int end : ends) close(end);
    throw Error(ErrorCode::failed, fmt::format("'{}' cannot be read: {}", file_.string(), std::strerror(why)));
  }
  if (process_ > 0) {
    close(ends[1]);
    pipe_ = ends[0];
    return;
  }
  settle(ends[1], parent);
  limit_time(seconds);
  limit(RLIMIT_AS, address_space_now() + limits.bytes + 200 * size);
  ToParent to(ends[1], seconds);
  try {
    read(to);
  } catch (const Error& error) {
    to.send(kRefusal, std::string(1, static_cast<char>(error.code())) + error.field() + '\n' + error.what());
  } catch (const std::bad_alloc&) {
    to.send(kNoMemory, {});
  } catch (...) {
    _exit(1);
  }
  _exit(0);
}

ChildReader::~ChildReader() {
  if (pipe_ >= 0) close(pipe_);
  if (process_ <= 0) return;
  kill(process_, SIGKILL);
  wait_for_end();
}

int ChildReader::wait_for_end() {
  int status = 0;
  while (waitpid(process_, &status, 0) < 0 && errno == EINTR) {
  }
  process_ = -1;
  return status;
}

void ChildReader::refuse(const std::string& why) const {
  throw Error(ErrorCode::input, fmt::format("'{}' cannot be read: {}", file_.string(), why));
}

/// Why there is no further message.
void ChildReader::refuse_end() {
  const int status = process_ > 0 ? wait_for_end() : 0;
  if (WIFSIGNALED(status)) {
    const int signal = WTERMSIG(status);
    if (signal == SIGINT || signal == SIGTERM || signal == SIGHUP) throw Error(ErrorCode::cancelled, "cancelled");
    if (signal == SIGXCPU || signal == SIGKILL) refuse("reading it takes too long; it is damaged");
  }
  refuse("the library that reads it fails; it is damaged");
}

void ChildReader::take(std::span<char> out) {
  auto start = std::chrono::steady_clock::now();
  while (!out.empty()) {
    pollfd end{pipe_, POLLIN, 0};
    if (poll(&end, 1, 1000) <= 0) {  // a child that waits for something uses no processor time
      if (context_ && context_->cancelled()) throw Error(ErrorCode::cancelled, "cancelled");
      if (std::chrono::steady_clock::now() - start < patience_) continue;
      kill(process_, SIGKILL);
      refuse_end();
    }
    const ssize_t got = ::read(pipe_, out.data(), out.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) refuse_end();
    out = out.subspan(static_cast<std::size_t>(got));
    start = std::chrono::steady_clock::now();
  }
}

/// Of the next message that is a result.
std::uint64_t ChildReader::next_size() {
  for (;;) {
    std::array<char, kHead> head{};
    take(head);
    std::uint64_t size = 0;
    std::memcpy(&size, head.data() + 1, sizeof size);
    if (head[0] == kResult) return size;
    if (head[0] == kAlive) continue;
    if (head[0] == kNoMemory) refuse("reading it needs more memory than a file of its size should; it is damaged");
    if (head[0] != kRefusal || size < 2 || size > 1 << 20) refuse_end();
    std::string bytes(size, '\0');
    take(bytes);
    const std::size_t line = bytes.find('\n');
    throw Error(static_cast<ErrorCode>(static_cast<unsigned char>(bytes[0])), bytes.substr(line + 1),
                bytes.substr(1, line - 1));
  }
}

std::string ChildReader::next() {
  constexpr std::uint64_t kBlock = 1 << 20;
  std::string bytes;
  for (std::uint64_t left = next_size(); left > 0;) {
    const std::size_t before = bytes.size(), more = std::min(left, kBlock);
    bytes.resize(before + more);
    take(std::span(bytes).subspan(before));
    left -= more;
  }
  return bytes;
}

void ChildReader::next(std::span<std::byte> out) {
  if (next_size() != out.size()) refuse("the library that reads it fails; it is damaged");
  take({reinterpret_cast<char*>(out.data()), out.size()});
}

void allow_memory(std::uint64_t bytes) {
  rlimit both{};
  if (getrlimit(RLIMIT_AS, &both) != 0 || both.rlim_cur == RLIM_INFINITY) return;
  both.rlim_cur =
      std::min<rlim_t>(both.rlim_cur + std::min<std::uint64_t>(bytes, std::uint64_t{1} << 62), both.rlim_max);
  setrlimit(RLIMIT_AS, &both);
}

std::string read_in_child_process(const std::filesystem::path& file, const std::function<std::string()>& read,
                                  const SandboxLimits& limits) {
  return ChildReader(
             file, [&](ToParent& to) { to.send(read()); }, limits)
      .next();
}

}  // namespace quench::base
