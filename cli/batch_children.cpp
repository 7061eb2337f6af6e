// SPDX-License-Identifier: Apache-2.0
#include "batch_children.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <ctime>
#include <fstream>

#include "quench/error.h"

namespace quench::program {
namespace {

constexpr timespec kNap{0, 20'000'000};

/// In the forked child: only what is safe in a signal handler.
[[noreturn]] void become(char* const* argv, int log, pid_t parent) {
  prctl(PR_SET_PDEATHSIG, static_cast<unsigned long>(SIGKILL));  // variadic: of the type it reads
  if (getppid() != parent) _exit(127);
  for (const int signal : {SIGINT, SIGHUP}) std::signal(signal, SIG_IGN);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  const int nothing = open("/dev/null", O_RDONLY | O_CLOEXEC);
  if (dup2(nothing, STDIN_FILENO) < 0 || dup2(log, STDOUT_FILENO) < 0 || dup2(log, STDERR_FILENO) < 0) _exit(127);
  execv("/proc/self/exe", argv);
  _exit(127);
}

int code_of(int status) { return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status); }

}  // namespace

void BatchChildren::start(std::size_t number, const std::vector<std::string>& words, const std::filesystem::path& log) {
  std::vector<std::string> all{"quench"};
  all.insert(all.end(), words.begin(), words.end());
  std::vector<char*> argv;
  for (std::string& word : all) argv.push_back(word.data());
  argv.push_back(nullptr);
  const int file = open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, 0666);
  if (file < 0)
    throw Error(ErrorCode::failed, fmt::format("cannot write '{}': {}", log.string(), std::strerror(errno)));
  const pid_t parent = getpid(), child = fork();
  if (child == 0) become(argv.data(), file, parent);
  const int reason = errno;
  close(file);
  if (child < 0)
    throw Error(ErrorCode::failed, fmt::format("a process cannot be started: {}; close other programs, or give fewer "
                                               "--jobs",
                                               std::strerror(reason)));
  running_.emplace(child, number);
}

void BatchChildren::look(const std::function<void(std::size_t number, int code)>& ended) {
  bool none = true;
  for (auto it = running_.begin(); it != running_.end();) {
    int status = 0;
    const pid_t got = waitpid(it->first, &status, WNOHANG);
    if (got == 0 || (got < 0 && errno == EINTR)) {
      ++it;
      continue;
    }
    const std::size_t number = it->second;
    it = running_.erase(it);
    none = false;
    ended(number, got < 0 ? 127 : code_of(status));
  }
  if (none) nanosleep(&kNap, nullptr);
}

void BatchChildren::kill_all() {
  for (const auto& [child, number] : running_) kill(child, SIGKILL);
  for (const auto& [child, number] : running_)
    while (waitpid(child, nullptr, 0) < 0 && errno == EINTR) {
    }
  running_.clear();
}

std::string sentence_of(int code, const std::filesystem::path& log) {
  constexpr std::string_view kMark = "quench: ";
  std::string last;
  std::ifstream in(log, std::ios::binary);
  for (std::string line; std::getline(in, line);)
    if (line.starts_with(kMark)) last = line.substr(kMark.size());
  if (code == 128 + SIGKILL) return "it was killed: the system may have had no more memory";
  if (code > 128 && code < 128 + NSIG) return fmt::format("it was ended by a signal: {}", strsignal(code - 128));
  return last.empty() ? fmt::format("it ended with exit code {} and said nothing", code) : last;
}

}  // namespace quench::program
