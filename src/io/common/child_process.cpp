// SPDX-License-Identifier: Apache-2.0
#include "io/common/child_process.h"

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

namespace quench::io {
namespace {

// The first byte of an answer.
constexpr char kResult = 'R', kRefusal = 'E', kNoMemory = 'M';

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

double seconds_for(const SandboxLimits& limits, std::int64_t file_size) {
  return limits.seconds + 2e-6 * static_cast<double>(file_size);
}

void send(int pipe, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t sent = write(pipe, bytes.data(), bytes.size());
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) _exit(1);  // the parent has closed its end
    bytes.remove_prefix(static_cast<std::size_t>(sent));
  }
}

[[noreturn]] void child(int pipe, pid_t parent, const std::function<std::string()>& read, const SandboxLimits& limits,
                        std::int64_t file_size) {
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
  limit(RLIMIT_CPU, static_cast<std::int64_t>(seconds_for(limits, file_size)) + 1);
  limit(RLIMIT_AS, address_space_now() + limits.bytes + 200 * file_size);
  try {
    const std::string bytes = read();
    send(pipe, {&kResult, 1});
    send(pipe, bytes);
  } catch (const Error& error) {
    send(pipe, kRefusal + std::string(1, static_cast<char>(error.code())) + error.what());
  } catch (const std::bad_alloc&) {
    send(pipe, {&kNoMemory, 1});
  } catch (...) {
    _exit(1);
  }
  _exit(0);
}

/// One end or both of a pipe, closed at the end of the scope.
struct Descriptor {
  int number = -1;
  Descriptor() = default;
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() { close(); }
  void close() {
    if (number >= 0) ::close(number);
    number = -1;
  }
};

/// A child process. Unless wait() was called, it is killed and waited for at the end of the scope.
class Child {
 public:
  explicit Child(pid_t process) : process_(process) {}
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child() {
    if (process_ <= 0) return;
    end();
    wait();
  }
  void end() const { kill(process_, SIGKILL); }
  int wait() {
    int status = 0;
    while (waitpid(process_, &status, 0) < 0 && errno == EINTR) {
    }
    process_ = -1;
    return status;
  }

 private:
  pid_t process_;
};

}  // namespace

std::string read_in_child_process(const std::filesystem::path& file, const std::function<std::string()>& read,
                                  const SandboxLimits& limits) {
  std::error_code unknown;
  const std::uintmax_t size = std::filesystem::file_size(file, unknown);
  const std::int64_t file_size = unknown ? 0 : static_cast<std::int64_t>(size);
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0)
    throw Error(ErrorCode::failed, fmt::format("'{}' cannot be read: {}", file.string(), std::strerror(errno)));
  Descriptor from, to;
  from.number = ends[0];
  to.number = ends[1];
  const pid_t parent = getpid(), process = fork();
  if (process < 0)
    throw Error(ErrorCode::failed, fmt::format("'{}' cannot be read: {}", file.string(), std::strerror(errno)));
  if (process == 0) child(to.number, parent, read, limits, file_size);
  Child reader(process);
  to.close();

  const auto start = std::chrono::steady_clock::now();
  const auto patience = std::chrono::seconds(60) + 10 * std::chrono::duration<double>(seconds_for(limits, file_size));
  bool waiting = true;
  std::string bytes;
  for (std::array<char, 1 << 16> block;;) {
    pollfd end{from.number, POLLIN, 0};
    if (poll(&end, 1, 1000) <= 0) {  // a child that waits for something uses no processor time
      if (std::chrono::steady_clock::now() - start < patience) continue;
      waiting = false;
      break;
    }
    const ssize_t got = ::read(from.number, block.data(), block.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) break;
    bytes.append(block.data(), static_cast<std::size_t>(got));
  }
  if (!waiting) reader.end();
  const int status = reader.wait();
  const auto refuse = [&](const std::string& why) {
    throw Error(ErrorCode::input, fmt::format("'{}' cannot be read: {}", file.string(), why));
  };
  if (WIFSIGNALED(status)) {
    const int signal = WTERMSIG(status);
    if (signal == SIGINT || signal == SIGTERM || signal == SIGHUP) throw Error(ErrorCode::cancelled, "cancelled");
    if (signal == SIGXCPU || signal == SIGKILL) refuse("reading it takes too long; it is damaged");
    refuse("the library that reads it fails; it is damaged");
  }
  if (!bytes.empty() && bytes[0] == kNoMemory)
    refuse("reading it needs more memory than a file of its size should; it is damaged");
  if (WEXITSTATUS(status) != 0 || bytes.empty()) refuse("the library that reads it fails; it is damaged");
  if (bytes[0] == kRefusal && bytes.size() >= 2)
    throw Error(static_cast<ErrorCode>(static_cast<unsigned char>(bytes[1])), bytes.substr(2));
  return bytes.erase(0, 1);
}

}  // namespace quench::io
